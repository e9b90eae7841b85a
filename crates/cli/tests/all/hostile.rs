//! Files from strangers, and hasty hands: every run ends, in little memory, with a status from 0 to 2 and a sentence.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use crate::folder::Folder;

const HOSTILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/hostile");

/// A folder of its own.
fn folder(name: &str) -> Folder {
    Folder::new(&format!("hostile-{name}"), &[])
}

/// Runs the program in a folder to its end, which must come, and must not take more than 512 MiB.
fn radgrad(folder: &Path, arguments: &[&str]) -> Output {
    const MOST_KILOBYTES: u64 = 512 << 10;
    let mut command = Command::new(env!("CARGO_BIN_EXE_radgrad"));
    command.current_dir(folder).args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let status = format!("/proc/{}/status", child.id());
    while child.try_wait().unwrap().is_none() {
        let memory = fs::read_to_string(&status).unwrap_or_default();
        let peak = memory.lines().find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix(" kB")?.parse::<u64>().ok());
        if peak.is_some_and(|peak| peak >= MOST_KILOBYTES) {
            child.kill().unwrap();
            panic!("{arguments:?}: {peak:?} kB");
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    child.wait_with_output().unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn every_hostile_file_ends_with_a_status_and_a_sentence() {
    let solve =
        |file: &'static str| vec!["solve", file, "--seconds", "1e6", "--most-elements", "200", "--error", "5%", "--summary"];
    let factors = |file: &'static str| vec!["factors", file, "--summary"];
    let cases: [(Vec<&str>, i32, &str); 37] = [
        (solve("bomb_8192.obj"), 2, "texture `bomb_8192.png` of 8192 x 8192 texels: reading takes more than the 256 MiB"),
        (solve("vt_1e300.obj"), 2, "texels from its origin"),
        (solve("ke_1e308.obj"), 2, "radiance is 1"),
        (solve("lit.obj"), 0, ""),
        (solve("scale_2p520.obj"), 0, ""),
        (solve("scale_1e-200.obj"), 0, ""),
        (solve("unknown_ctrl.obj"), 2, r"found `\u{1b}[2J\u{1b}[31mboo`"),
        (solve("foreign.obj"), 2, "secret.txt:1: expected a material library, `newmtl` first, found another file"),
        (
            factors("foreign.obj"),
            0,
            "secret.txt:1: expected a material library, `newmtl` first, found another file: the library is not",
        ),
        (factors("mtl_comma.obj"), 0, "mtl_comma.mtl:2: numbers of `Kd` are parted by spaces in MTL: commas are taken for these"),
        (factors("empty_newmtl.obj"), 0, "empty_newmtl.mtl:1: `newmtl` must name a material: its name is taken as empty"),
        (factors("latin1.obj"), 0, "latin1.obj:10: the text is no UTF-8 (byte 0xdf): read as Latin-1"),
        (factors("slashes.obj"), 0, ""),
        (factors("ply_prose.ply"), 0, "ply_prose.ply:3: a line of the header that is no statement of PLY is not used"),
        (
            factors("ply_columns.ply"),
            0,
            "ply_columns.ply: vertex[0]: numbers of vertex that the header does not tell of are not used",
        ),
        (
            factors("gltf1.gltf"),
            2,
            "asset.version: expected glTF 2.0, the only version that is read, found glTF 1.0: convert the file",
        ),
        (factors("wide_text.obj"), 2, "wide_text.obj:1: expected a text of UTF-8, UTF-16 or Latin-1, found a byte 0"),
        (factors("ply_no_properties.ply"), 2, "expected at least one property of each element, found none of `vertex`"),
        (
            factors("decimal_comma.obj"),
            2,
            "decimal_comma.obj:1: expected a number with a decimal point (y), found a decimal comma, `0,5`",
        ),
        (solve("outside.obj"), 2, "it lies outside the folder of the scene"),
        (solve("no_materials.obj"), 2, "no material `a`: `none.mtl` cannot be read"),
        (factors("no_materials.obj"), 0, "taken as black"),
        (solve("backwards.obj"), 0, "the scene seems to be turned inside out"),
        (solve("backwards.obj"), 0, "backwards.mtl:3: property `Ks` is not used"),
        (solve("unprintable.gltf"), 2, "found `VECren\\/e\\u{8} v"),
        (solve("white.gltf"), 0, ""),
        (vec!["solve", "white.gltf", "--max-reflectance", "0.95"], 0, "reflects more than 0.95: capped"),
        (vec!["solve", "lit.obj", "--points", "bad_utf8.jsonl", "--error", "5%"], 1, "1 points refused"),
        (vec!["eval", "slow_eval_182.jsonl"], 0, ""),
        (vec!["eval", "slow_eval_182.jsonl", "--effort", "10"], 1, "1 of 1 cases refused"),
        (vec!["eval", "below_range.jsonl"], 0, ""),
        (vec!["eval", "aff1.jsonl"], 1, "1 of 1 cases refused"),
        (vec!["eval", "misspelt.jsonl"], 1, "1 of 1 cases refused"),
        (vec!["factors", "lit.obj", "--cells", "18446744073709551615"], 2, "above 1000000000"),
        (vec!["field", "lit.obj", "--on", "floor", "--grid", "18446744073709551615", "--out", "f.csv"], 2, "--budget"),
        (
            vec!["solve", "lit.obj", "--divide", "shadows", "--resume", "run.json"],
            2,
            "--divide shadows cannot go on from a file of --resume",
        ),
        (vec!["solve", "lit.obj", "--resume", "/dev/zero"], 2, "/dev/zero: cannot read: it is a pipe, a device or a socket"),
    ];
    for (arguments, status, sentence) in cases {
        let output = radgrad(Path::new(HOSTILE), &arguments);
        let stderr = said(&output);
        assert!(output.status.code() == Some(status), "{arguments:?}: {:?} {stderr}", output.status);
        assert!(stderr.contains(sentence), "{arguments:?}: {stderr}");
        assert!(!stderr.contains("panicked") && !stderr.contains("top:secret"), "{arguments:?}: {stderr}");
        assert!(!stderr.contains(|c: char| c.is_control() && c != '\n'), "{arguments:?}: {stderr:?}");
        let stdout = String::from_utf8(output.stdout).unwrap();
        assert!(!stdout.contains("null,") && !stdout.contains("NaN") && !stdout.contains("inf"), "{arguments:?}: {stdout}");
    }
    assert!(fs::read_dir(HOSTILE).unwrap().all(|entry| !entry.unwrap().file_name().to_string_lossy().starts_with("f.")));
}

#[test]
fn a_document_that_says_little_and_means_much_is_refused() {
    let folder = folder("instances");
    let (nodes, parts) = (2000, 2000);
    let list = |count: usize, entry: &str| vec![entry; count].join(",");
    let document = format!(
        r#"{{"asset":{{"version":"2.0"}},"nodes":[{}],"meshes":[{{"primitives":[{}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"type":"VEC3","count":3}}],"bufferViews":[{{"buffer":0,"byteLength":36}}],
        "buffers":[{{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}}]}}"#,
        list(nodes, r#"{"mesh":0}"#),
        list(parts, r#"{"attributes":{"POSITION":0}}"#),
    );
    fs::write(folder.0.join("laughs.gltf"), document).unwrap();
    let output = radgrad(&folder.0, &["factors", "laughs.gltf"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        said(&output).contains("reading takes more than the 256 MiB that it may: give more with --budget"),
        "{}",
        said(&output)
    );
}

#[cfg(unix)]
#[test]
fn what_is_no_file_is_neither_read_nor_replaced() {
    use std::os::unix::fs::symlink;

    let folder = folder("special");
    for name in ["lit.obj", "lit.mtl"] {
        fs::copy(Path::new(HOSTILE).join(name), folder.0.join(name)).unwrap();
    }
    for name in ["pipe.obj", "pipe.csv"] {
        assert!(Command::new("mkfifo").arg(folder.0.join(name)).status().unwrap().success());
    }
    symlink("/dev/zero", folder.0.join("endless.obj")).unwrap();
    symlink("target.csv", folder.0.join("link.csv")).unwrap();
    let run = |arguments: &[&str]| {
        let output = radgrad(&folder.0, arguments);
        (output.status.code(), said(&output))
    };
    for scene in ["pipe.obj", "endless.obj"] {
        let (status, said) = run(&["factors", scene]);
        assert!(status == Some(2) && said.contains("only regular files are read"), "{said}");
    }
    let (status, said) = run(&["factors", "lit.obj", "--out", "pipe.csv"]);
    assert!(status == Some(2) && said.contains("it is a pipe or a disk"), "{said}");
    let (status, said) = run(&["factors", "lit.obj", "--out", "nowhere/a.csv"]);
    assert!(status == Some(2) && said.contains("`nowhere/a.csv` cannot be written"), "{said}");
    assert_eq!(run(&["factors", "lit.obj", "--out", "link.csv"]).0, Some(0));
    assert!(folder.0.join("link.csv").is_symlink() && folder.0.join("target.csv").is_file());
    let (status, said) = run(&["solve", "lit.obj", "--points", "lit.obj", "--answers", "lit.obj"]);
    assert!(status == Some(2) && said.contains("--answers is `lit.obj`, which is the scene"), "{said}");
}

#[test]
fn no_output_of_a_solve_is_another_file_of_the_run() {
    let folder = folder("outputs");
    for file in ["lit.obj", "lit.mtl"] {
        fs::copy(Path::new(HOSTILE).join(file), folder.0.join(file)).unwrap();
    }
    fs::write(folder.0.join("points.txt"), "0 0 0 0 0 1\n").unwrap();
    let before = |file: &str| fs::read(folder.0.join(file)).unwrap();
    let [scene, library, points] = ["lit.obj", "lit.mtl", "points.txt"].map(before);
    let camera = ["--camera", "0 0 1 0 0 0 0 1 0 60"];
    for (arguments, words) in [
        (&["--points", "points.txt", "--answers", "lit.mtl"][..], "--answers is `lit.mtl`, which is named in the scene"),
        (&["--points", "points.txt", "--answers", "./points.txt"], "which is read for --points"),
        (&["--resume", "lit.mtl"], "--resume is `lit.mtl`"),
        (&["--out", "new.vtu", "--resume", "./new.vtu"], "which is that of --out too"),
        (&["--view", "a.png", "--points", "points.txt", "--answers", "a.png", camera[0], camera[1]], "that of --view too"),
    ] {
        let output = radgrad(&folder.0, &[&["solve", "lit.obj"], arguments].concat());
        assert!(output.status.code() == Some(2) && said(&output).contains(words), "{arguments:?}: {}", said(&output));
    }
    assert_eq!(["lit.obj", "lit.mtl", "points.txt"].map(before), [scene, library, points]);
    assert!(!folder.0.join("new.vtu").exists() && !folder.0.join("a.png").exists());
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_or_closed_standard_error_or_output_is_no_panic() {
    let full = || fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let run = |arguments: &[&str], stdout: Stdio, stderr: Stdio| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_radgrad"));
        command.current_dir(HOSTILE).args(arguments).stdin(Stdio::null()).stdout(stdout).stderr(stderr);
        command.status().unwrap().code()
    };
    assert_eq!(run(&["solve", "missing.obj"], Stdio::null(), full().into()), Some(2));
    assert_eq!(run(&["factors", "no_materials.obj"], Stdio::null(), full().into()), Some(0));
    assert_eq!(run(&["eval", "misspelt.jsonl"], Stdio::null(), full().into()), Some(1));
    for arguments in
        [&["factors", "lit.obj"][..], &["solve", "lit.obj", "--error", "5%"], &["eval", "misspelt.jsonl"], &["--help"]]
    {
        assert_eq!(run(arguments, full().into(), Stdio::null()), Some(2), "{arguments:?}");
    }
    assert_eq!(run(&["nonsense"], Stdio::null(), full().into()), Some(2));
}

#[cfg(target_os = "linux")]
#[test]
fn a_run_that_is_killed_leaves_no_part_of_a_file() {
    let folder = folder("killed");
    for name in ["lit.obj", "lit.mtl"] {
        fs::copy(Path::new(HOSTILE).join(name), folder.0.join(name)).unwrap();
    }
    // To replace a file takes a name for the new one, for microseconds: whole, it may be left under that.
    let mut named = 0;
    for moment in 0..12 {
        let mut command = Command::new(env!("CARGO_BIN_EXE_radgrad"));
        let outputs = ["--out", "out.vtu", "--resume", "run.json", "--error", "1e-12", "--most-elements", "100000"];
        command.current_dir(&folder.0).args(["solve", "lit.obj"]).args(outputs).stderr(Stdio::null());
        let mut child = command.spawn().unwrap();
        std::thread::sleep(Duration::from_millis(10 + 37 * moment));
        child.kill().unwrap();
        child.wait().unwrap();
        for entry in fs::read_dir(&folder.0).unwrap() {
            let entry = entry.unwrap();
            let name = entry.file_name().into_string().unwrap();
            if !["lit.obj", "lit.mtl", "out.vtu", "run.json"].contains(&name.as_str()) {
                let (is_vtu, whole) = (name.starts_with(".out.vtu."), fs::read_to_string(entry.path()).unwrap());
                assert!(is_vtu || name.starts_with(".run.json."), "{name}");
                assert!(whole.trim_end().ends_with(if is_vtu { "</VTKFile>" } else { "}" }), "{name} is a part");
                fs::remove_file(entry.path()).unwrap();
                named += 1;
            }
        }
        if let Ok(vtu) = fs::read_to_string(folder.0.join("out.vtu")) {
            assert!(vtu.trim_end().ends_with("</VTKFile>"));
        }
    }
    assert!(named <= 1, "{named} of 12 are left under another name");
    assert_ne!(radgrad(&folder.0, &["solve", "lit.obj", "--most-elements", "1", "--resume", "run.json"]).status.code(), Some(2));
    // By the gradient faces are cut otherwise at first.
    let other = radgrad(&folder.0, &["solve", "lit.obj", "--divide", "gradient", "--resume", "run.json"]);
    assert_eq!(other.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&other.stderr).contains("run.json: it was written without --divide gradient"));
}

#[test]
fn a_scene_alone_is_answered_with_a_table_and_the_statuses_are_in_the_help() {
    let output = radgrad(Path::new(HOSTILE), &["solve", "lit.obj", "--error", "5%"]);
    let table = String::from_utf8(output.stdout).unwrap();
    assert!(
        table.contains(" elements, ") && table.contains("% asked for") && table.contains("\nmean of all, by channel"),
        "{table}"
    );
    let help = String::from_utf8(radgrad(Path::new(HOSTILE), &["--help"]).stdout).unwrap();
    assert!(help.contains("Exit status:\n  0  all was answered"), "{help}");
}
