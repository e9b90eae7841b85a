//! `radgrad solve` as a user sees it: a scene in, files and lines out, an exit status.

use std::process::{Command, Output};

use serde_json::Value;

use crate::folder::Folder;

/// Two unit squares at distance 1 that reflect half and radiate 1, the radiosity at a centre and at a corner.
pub(crate) const SQUARES: &str = "mtllib squares.mtl\nusemtl white\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n\
                       v 0 0 1\nv 0 1 1\nv 1 1 1\nv 1 0 1\nf 5 6 7 8\n";
pub(crate) const WHITE: &str = "newmtl white\nKd 0.5 0.5 0.5\nKe 0.3183098861837907 0.3183098861837907 0.3183098861837907\n";
const POINTS: &str = r#"{"position":[0.5,0.5,0],"normal":[0,0,1]}
{"id":"corner","position":[0,0,0],"normal":[0,0,2]}

{"position":[0.5,0.5,0.5],"normal":[0,0,1]}
{"position":[0.5,0.5],"normal":[0,0,1]}
"#;

/// A folder of its own with the scene in it.
pub(crate) fn folder(name: &str) -> Folder {
    Folder::new(&format!("solve-{name}"), &[("squares.obj", SQUARES), ("squares.mtl", WHITE), ("points.jsonl", POINTS)])
}

impl Folder {
    pub(crate) fn solve(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_radgrad"));
        command.current_dir(&self.0).args(["solve", "squares.obj"]).args(arguments).output().unwrap()
    }

    pub(crate) fn read(&self, file: &str) -> String {
        std::fs::read_to_string(self.0.join(file)).unwrap()
    }
}

/// The numbers of an array of a VTU file.
pub(crate) fn numbers(vtu: &str, name: &str) -> Vec<f64> {
    let (_, rest) = vtu.split_once(&format!("Name=\"{name}\"")).unwrap();
    let (_, rest) = rest.split_once('>').unwrap();
    rest.split_once('<').unwrap().0.split_whitespace().map(|number| number.parse().unwrap()).collect()
}

/// Channels that no two can be taken for each other: red is not reflected at all, green twice as much as blue.
pub(crate) const COLOURED: &str = "newmtl white\nKd 0 0.5 0.25\nKe 0.3183098861837907 0.6366197723675814 0.9549296585513721\n";

pub(crate) fn lines(output: &Output) -> Vec<Value> {
    std::str::from_utf8(&output.stdout).unwrap().lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn points_are_answered_in_their_order_inside_twice_their_estimates() {
    let folder = folder("points");
    let output = folder.solve(&["--points", "points.jsonl"]);
    assert_eq!(output.status.code(), Some(1), "one line is refused");
    let lines = lines(&output);
    assert_eq!(lines.len(), 4);
    for (line, exact) in lines.iter().zip([1.133_303_564_992_420_8, 1.076_981_393_145_044_5]) {
        for channel in 0..3 {
            let [value, estimate] = ["radiosity", "estimate"].map(|name| line[name][channel].as_f64().unwrap());
            assert!((value - exact).abs() <= (2.0 * estimate).min(1e-6), "{line}");
        }
    }
    assert_eq!((&lines[1]["id"], &lines[1]["on"], &lines[2]["on"]), (&"corner".into(), &"face".into(), &"free".into()));
    assert_eq!(lines[3]["line"], 5);
}

#[test]
fn sensors_are_answered_in_their_channels_on_faces_and_in_space() {
    let folder = folder("sensors");
    // A square from half its side below its middle has a known form factor.
    std::fs::write(folder.0.join("squares.mtl"), COLOURED).unwrap();
    let points = r#"{"position":[0.5,0.5,0.5],"normal":[0,0,2]}
{"position":[0.5,0.5,0],"normal":[0,0,1]}
{"position":[0.5,0.5,0],"normal":[0,0,1],"on":"free"}
{"position":[0.5,0.5,0],"normal":[0,0,-1]}
{"position":[0.5,0.5,0.5],"normal":[0,0,1],"on":"face"}
{"position":[0.5,0.5,0.5],"normal":[0,0,1],"on":"ceiling"}
"#;
    std::fs::write(folder.0.join("points.jsonl"), points).unwrap();
    let output = folder.solve(&["--points", "points.jsonl"]);
    assert_eq!(output.status.code(), Some(1), "three lines are refused");
    let lines = lines(&output);
    let of = |line: usize, name: &str, channel: usize| lines[line][name][channel].as_f64().unwrap();
    let form_factor = 4.0 / std::f64::consts::PI * 0.5_f64.sqrt() * 0.5_f64.sqrt().atan();
    let estimate = of(0, "irradiance_estimate", 0);
    assert!((of(0, "irradiance", 0) - form_factor).abs() <= 2.0 * estimate && estimate < 1e-9);
    assert!(lines[0]["on"] == "free" && lines[0].get("radiosity").is_none());
    for line in [1, 2] {
        let [emitted, reflectance] = [[1.0, 2.0, 3.0], [0.0, 0.5, 0.25]];
        for channel in 0..3 {
            let received = of(line, "irradiance", channel);
            let radiosity = emitted[channel] + reflectance[channel] * received;
            let estimate = of(line, "irradiance_estimate", channel);
            assert!((of(1, "radiosity", channel) - radiosity).abs() <= 2.0 * (of(1, "estimate", channel) + estimate));
            assert!(received > 0.2 && estimate > 0.0 && estimate < 0.03 * received, "{line}: {}", lines[line]);
        }
        assert!((0..2).all(|channel| of(line, "irradiance", channel + 1) > 1.2 * of(line, "irradiance", channel)));
    }
    let errors = [(3, "no face at [0.5, 0.5, 0] faces along [0, 0, -1]"), (4, "no face at [0.5, 0.5, 0.5]"), (5, "`ceiling`")];
    for (line, error) in errors {
        assert!(lines[line]["error"].as_str().unwrap().contains(error), "{}", lines[line]);
    }
}

#[test]
fn the_summary_is_one_object_with_the_error_that_was_asked_for_and_the_estimate() {
    let folder = folder("summary");
    let output = folder.solve(&["--error", "0.1%", "--summary"]);
    assert_eq!(output.status.code(), Some(0));
    let lines = lines(&output);
    assert_eq!(lines.len(), 1);
    let number = |name: &str| lines[0][name].as_f64().unwrap();
    assert!(number("seconds") > 0.0 && number("elements") >= 2.0 && number("links") >= 2.0);
    assert!(number("estimate") <= 0.001 && number("error") == 0.001);
}

#[test]
fn the_summary_says_what_is_reflected_and_what_is_probably_not_meant() {
    let folder = folder("warnings");
    let number = |of: &Value, name: &str| of["channels"][0][name].as_f64().unwrap();
    let summary = lines(&folder.solve(&["--summary"])).remove(0);
    assert_eq!(summary["warnings"], Value::Array(Vec::new()));
    assert!((number(&summary, "mean") - number(&summary, "reflected") - 1.0).abs() < 1e-12);
    let relative = number(&summary, "estimate") / number(&summary, "reflected");
    assert!((relative - summary["estimate"].as_f64().unwrap()).abs() <= 1e-12 * relative);
    // Both faces wound the other way, and then none that emits.
    let squares = folder.read("squares.obj");
    let turned = squares.replace("f 1 2 3 4", "f 4 3 2 1").replace("f 5 6 7 8", "f 8 7 6 5");
    for (obj, mtl, said) in [(&turned, WHITE.to_owned(), "turned inside out"), (&squares, WHITE.replace("Ke", "# Ke"), "no lamp")]
    {
        std::fs::write(folder.0.join("squares.obj"), obj).unwrap();
        std::fs::write(folder.0.join("squares.mtl"), mtl).unwrap();
        let output = folder.solve(&["--summary"]);
        let warnings = lines(&output)[0]["warnings"].clone();
        assert!(warnings[0].as_str().unwrap().contains(said) && warnings.as_array().unwrap().len() == 1, "{warnings}");
        assert!(String::from_utf8_lossy(&output.stderr).contains(said));
    }
}

#[test]
fn help_shows_what_many_need_first_and_wraps() {
    let output = folder("help").solve(&["--help"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    let (first, expert) = text.split_once("Expert:").unwrap();
    let is_option = |line: &&str| line.starts_with("      --") || line.starts_with("  -");
    let options = |text: &str| text.lines().filter(is_option).count();
    assert!(options(first) <= 14 && options(expert) > 0, "{first}");
    for name in [
        "error",
        "seconds",
        "certify",
        "points",
        "grid",
        "answers",
        "lux",
        "out",
        "view",
        "camera",
        "size",
        "false-colour",
        "summary",
    ] {
        assert!(first.contains(&format!("--{name}")), "{name}");
    }
}

#[test]
fn what_has_no_answer_is_refused_with_its_faces() {
    let folder = folder("refused");
    let refused = |obj: &str, mtl: &str| {
        std::fs::write(folder.0.join("squares.obj"), obj).unwrap();
        std::fs::write(folder.0.join("squares.mtl"), mtl).unwrap();
        let output = folder.solve(&["--summary"]);
        assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0));
        String::from_utf8(output.stderr).unwrap()
    };
    let rug = format!("{SQUARES}g rug\nv .2 .2 0\nv 1.4 .2 0\nv .3 .5 0\nf 9 10 11\n");
    let said = refused(&rug.replace("f 1 2 3 4", "g floor\nf 1 2 3 4"), WHITE);
    assert!(
        said.contains("face 0 of `floor` (squares.obj:8) and face 2 of `rug` (squares.obj:18) overlap in one plane"),
        "{said}"
    );
    let said = refused(SQUARES, &WHITE.replace("Ke 0.3183098861837907", "Ke 6e307"));
    assert!(said.contains("squares.mtl:3: material `white`: radiance is 6000") && said.contains("its product with pi"), "{said}");
}

#[test]
fn files_of_a_scene_far_away_have_its_own_coordinates_and_unit() {
    let folder = folder("far");
    let found = |shift: f64, unit: f64| {
        let moved = |line: &str| match line.strip_prefix("v ") {
            Some(v) => {
                let of = |c: &str| format!("{:?}", c.parse::<f64>().unwrap() * unit + shift);
                format!("v {}\n", v.split(' ').map(of).collect::<Vec<_>>().join(" "))
            }
            None => format!("{line}\n"),
        };
        std::fs::write(folder.0.join("squares.obj"), SQUARES.lines().map(moved).collect::<String>()).unwrap();
        let eye = 0.5 * unit + shift;
        let camera = format!("{eye:?} {eye:?} {:?}, {eye:?} {eye:?} {shift:?}, 0 1 0, 60", 0.9 * unit + shift);
        let files = ["--out", "out.vtu", "--view", "view.exr", "--size", "1x1", "--camera", &camera];
        assert_eq!(folder.solve(&files).status.code(), Some(0));
        let vtu = folder.read("out.vtu");
        let exr = std::fs::read(folder.0.join("view.exr")).unwrap();
        (numbers(&vtu, "position"), numbers(&vtu, "gradient"), exr)
    };
    let (positions, gradients, picture) = found(0.0, 1.0);
    let large = 2f64.powi(500);
    let (of_large, slight, same) = found(0.0, large);
    assert!(positions.iter().zip(&of_large).all(|(here, there)| *there == here * large));
    assert!(gradients.iter().zip(&slight).all(|(here, there)| *there == here / large));
    assert_eq!(picture, same);
    let (far, gradients_there, _) = found(1024.0, 1.0);
    assert!(positions.len() == far.len() && positions.iter().zip(&far).all(|(here, there)| *there == here + 1024.0));
    assert!(gradients.iter().zip(&gradients_there).all(|(here, there)| (here - there).abs() < 1e-9));
}

#[test]
fn files_are_whole_and_have_what_they_say() {
    let folder = folder("files");
    assert_eq!(folder.solve(&["--out", "out.vtu"]).status.code(), Some(0));
    let vtu = folder.read("out.vtu");
    assert!(vtu.trim_end().ends_with("</VTKFile>") && !vtu.contains("NaN") && !vtu.contains("inf"));
    assert_eq!(folder.solve(&["--out", "out.ply"]).status.code(), Some(0));
    let ply = folder.read("out.ply");
    let count = |what: &str| -> usize { ply.lines().find_map(|l| l.strip_prefix(what)).unwrap().parse().unwrap() };
    let header = ply.lines().position(|l| l == "end_header").unwrap() + 1;
    assert_eq!(ply.lines().count(), header + count("element vertex ") + count("element face "));
    let wrong = folder.solve(&["--out", "out.xyz"]);
    assert_eq!(wrong.status.code(), Some(2));
    assert!(String::from_utf8(wrong.stderr).unwrap().contains("out.xyz: expected a name ending in .vtu or .ply"));
}

#[test]
fn a_vtu_has_each_channel_in_its_component_with_its_estimate() {
    let folder = folder("vtu");
    std::fs::write(folder.0.join("squares.mtl"), COLOURED).unwrap();
    let obj = SQUARES.replace("f 1 2 3 4", "g floor\nf 1 2 3 4").replace("f 5 6 7 8", "g ceiling\nf 5 6 7 8");
    std::fs::write(folder.0.join("squares.obj"), obj).unwrap();
    let points = "{\"position\":[0,0,0],\"normal\":[0,0,1]}\n";
    std::fs::write(folder.0.join("points.jsonl"), points).unwrap();
    let output = folder.solve(&["--out", "out.vtu", "--points", "points.jsonl"]);
    assert_eq!(output.status.code(), Some(0));
    let (vtu, corner) = (folder.read("out.vtu"), &lines(&output)[0]);
    for (name, components) in [("radiosity", 3), ("estimate", 3), ("gradient", 9), ("solver", 3)] {
        assert!(vtu.contains(&format!("Name=\"{name}\" NumberOfComponents=\"{components}\" ComponentName0=\"r")), "{name}");
    }
    let [position, radiosity, estimate, gradient] =
        ["position", "radiosity", "estimate", "gradient"].map(|name| numbers(&vtu, name));
    assert!(radiosity.len() == position.len() && gradient.len() == 3 * radiosity.len() && position.len() >= 24);
    let mut corners = 0;
    for point in 0..position.len() / 3 {
        let at: [f64; 3] = std::array::from_fn(|k| position[3 * point + k]);
        for channel in 0..3 {
            let k = 3 * point + channel;
            assert!(radiosity[k] > 0.0 && estimate[k] >= 0.0);
            let slope = &gradient[3 * k..3 * k + 3];
            assert_eq!(slope[2], 0.0, "faces are level");
            let inward = slope[0] * (0.5 - at[0]) + slope[1] * (0.5 - at[1]);
            if channel == 0 {
                assert!((radiosity[k] - 1.0).abs() < 1e-12 && inward.abs() < 1e-10 && estimate[k] < 1e-6);
            } else if at == [0.0; 3] {
                let known = corner["radiosity"][channel].as_f64().unwrap();
                assert!((radiosity[k] - known).abs() <= estimate[k].min(0.01), "{channel}: {known}");
                let known: Vec<f64> = (0..3).map(|axis| corner["gradient"][channel][axis].as_f64().unwrap()).collect();
                let is_near = (0..3).all(|axis| (slope[axis] - known[axis]).abs() < 0.05 * known[0]);
                assert!(inward > 0.0 && is_near, "{channel}: {slope:?} for {known:?}");
                corners += 1;
            }
        }
    }
    assert_eq!(corners, 2);
    for (name, number) in [("surface floor", 0.0), ("surface ceiling", 1.0), ("channel g", 1.0)] {
        assert_eq!(numbers(&vtu, name), [number], "{name}");
    }
    assert!(vtu.contains("unit of radiosity: pi times the unit"));
    let (surface, offsets) = (numbers(&vtu, "surface"), numbers(&vtu, "offsets"));
    for (cell, surface) in surface.iter().enumerate() {
        let height = position.chunks_exact(3).zip(1..).find(|(_, end)| f64::from(*end) == offsets[cell]).map(|(at, _)| at[2]);
        assert_eq!(Some(*surface), height, "the floor is at 0 and the ceiling at 1");
    }
}

#[test]
fn divisions_keep_to_the_error_and_unknown_ones_are_refused() {
    let folder = folder("divisions");
    let estimate = |output: &Output| lines(output)[0]["estimate"].as_f64().unwrap();
    for asked in [&[][..], &["--divide", "gradient"]] {
        let output = folder.solve(&[&["--summary", "--error", "0.2%"][..], asked].concat());
        assert_eq!(output.status.code(), Some(0), "{asked:?}");
        assert!(estimate(&output) <= 0.002, "{asked:?}");
    }
    let refused = folder.solve(&["--divide", "random"]);
    assert_eq!(refused.status.code(), Some(2));
    let said = String::from_utf8(refused.stderr).unwrap();
    assert!(said.contains("gradient"), "{said}");
}

#[test]
fn a_run_that_is_killed_leaves_whole_files_and_is_taken_up_again() {
    let folder = folder("killed");
    // It would run for hours.
    let endless = ["solve", "squares.obj", "--error", "1e-14", "--most-elements", "1000000", "--degree", "0"];
    let mut child = Command::new(env!("CARGO_BIN_EXE_radgrad"))
        .current_dir(&folder.0)
        .args(endless)
        .args(["--out", "out.vtu", "--resume", "run.json"])
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let rounds = |text: &str| text.matches(',').count();
    // Several rounds, so that files have been replaced.
    while !std::fs::read_to_string(folder.0.join("run.json")).is_ok_and(|text| rounds(&text) > 20) {
        assert!(child.try_wait().unwrap().is_none(), "it has ended by itself");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let vtu = folder.read("out.vtu");
    assert!(vtu.starts_with("<?xml") && vtu.trim_end().ends_with("</VTKFile>"));
    let state: Value = serde_json::from_str(&folder.read("run.json")).unwrap();
    let divided = state["divisions"].as_array().unwrap().len();

    let output = folder.solve(&["--degree", "0", "--most-elements", "1", "--resume", "run.json", "--summary"]);
    let elements = lines(&output)[0]["elements"].as_u64().unwrap();
    assert_eq!(elements, 2 + 3 * divided as u64, "as many as were there");
    std::fs::write(folder.0.join("squares.mtl"), WHITE.replace("0.5", "0.4")).unwrap();
    let other = folder.solve(&["--resume", "run.json"]);
    assert_eq!(other.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&other.stderr).contains("run.json: it was written for another scene"));
}

#[test]
fn a_view_has_the_radiosity_of_what_is_seen_and_its_estimate() {
    let folder = folder("view");
    let camera = ["--camera", "0.5 0.5 0.9, 0.5 0.5 0, 0 1 0, 60", "--size", "5x3"];
    for shading in [&[][..], &["--gather"], &["--draft"]] {
        let view = [&["--degree", "1", "--view", "view.exr"][..], &camera, shading].concat();
        assert_eq!(folder.solve(&view).status.code(), Some(0));
        let exr = std::fs::read(folder.0.join("view.exr")).unwrap();
        // Three rows of B, G, R and their estimates; the middle of B is the centre of the floor.
        let row = 8 + 6 * 5 * 4;
        let at = |row_index: usize, channel: usize, column: usize| {
            let place = exr.len() - (3 - row_index) * row + 8 + 4 * (5 * channel + column);
            f64::from(f32::from_le_bytes(exr[place..place + 4].try_into().unwrap()))
        };
        let (value, estimate) = (at(1, 0, 2), at(1, 3, 2));
        assert!((value - 1.133_303_565).abs() <= 2.0 * estimate + 1e-7 && estimate < 0.06, "{shading:?}: {value} {estimate}");
        assert!((at(1, 0, 1) - at(1, 0, 3)).abs() < 1e-3 && at(1, 0, 1) < value);
    }
    let view = [&["--view", "view.png"][..], &camera].concat();
    let shades = |more: &[&str], said: &str| {
        let output = folder.solve(&[&view[..], more].concat());
        assert!(String::from_utf8_lossy(&output.stderr).contains(said), "{}", String::from_utf8_lossy(&output.stderr));
        let file = std::fs::File::open(folder.0.join("view.png")).unwrap();
        let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut bytes).unwrap();
        bytes
    };
    let plain = shades(&[], "view.png: tone curve reinhard, exposure 0: sRGB of L(1 + L/");
    let bright = shades(&["--exposure", "2"], "exposure 2");
    let linear = shades(&["--tone", "linear", "--exposure", "3"], "cut at 1 in 60.00 % of the pixels");
    // Pixels beside the floor are black.
    assert!(plain.len() == 45 && plain.iter().zip(&bright).all(|(plain, bright)| plain < bright || (*plain, *bright) == (0, 0)));
    assert!(linear[21..24] == [255; 3] && plain[21..24].iter().all(|byte| (1..255).contains(byte)));
    let wrong = folder.solve(&[&["--view", "view.jpg"][..], &camera].concat());
    assert_eq!(wrong.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&wrong.stderr).contains("view.jpg: expected a name ending in .exr or .png"));
}

#[test]
fn a_view_of_two_faces_back_to_back_shows_the_one_that_faces_it() {
    let folder = folder("plate");
    let faces = ["usemtl dim\nf 1 2 3 4\n", "usemtl white\nf 4 3 2 1\n"];
    let dim = WHITE.replace("white", "dim").replace("0.3183098861837907", "0.15915494309189535");
    std::fs::write(folder.0.join("squares.mtl"), WHITE.to_owned() + &dim).unwrap();
    for order in [[0, 1], [1, 0]] {
        let obj = format!("mtllib squares.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n{}{}", faces[order[0]], faces[order[1]]);
        std::fs::write(folder.0.join("squares.obj"), obj).unwrap();
        for (height, radiosity) in [(1, 0.5), (-1, 1.0)] {
            let camera = format!("0.4 0.3 {height}, 0.4 0.3 0, 0 1 0, 10");
            let output = folder.solve(&["--view", "view.exr", "--size", "1x1", "--camera", &camera]);
            assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
            let exr = folder.0.join("view.exr");
            let bytes = std::fs::read(exr).unwrap();
            let blue = f32::from_le_bytes(bytes[bytes.len() - 24..][..4].try_into().unwrap());
            assert!((f64::from(blue) - radiosity).abs() < 1e-6, "{order:?} {height}: {blue}");
        }
    }
}

#[test]
fn a_picture_has_each_channel_and_estimate_in_its_place_and_says_what_it_is() {
    let folder = folder("channels");
    std::fs::write(folder.0.join("squares.mtl"), COLOURED).unwrap();
    let view = ["--view", "view.exr", "--camera", "0.5 0.5 0.9, 0.5 0.5 0, 0 1 0, 10", "--size", "1x1"];
    let seen = |more: &[&str]| -> Vec<f64> {
        assert_eq!(folder.solve(&[&view[..], more].concat()).status.code(), Some(0));
        let exr = std::fs::read(folder.0.join("view.exr")).unwrap();
        for said in ["quantity\0string\0\x09\0\0\0radiosity", "unit\0string\0", "B\0", "estimate.R\0"] {
            assert!(exr.windows(said.len()).any(|part| part == said.as_bytes()), "{said}");
        }
        exr[exr.len() - 24..].chunks_exact(4).map(|bytes| f64::from(f32::from_le_bytes(bytes.try_into().unwrap()))).collect()
    };
    // Blue, green, red and their estimates.
    for shading in [&[][..], &["--gather"], &["--draft"], &["--samples", "5"]] {
        let found = seen(shading);
        for (value, known) in found.iter().zip([3.189_230_123, 2.266_605_395, 1.0]) {
            assert!((value - known).abs() < 2e-3, "{shading:?}: {found:?}");
        }
        assert!(found[5] < 1e-6 && found[3] > 5.0 * found[5] && found[4] > 1.3 * found[3], "{shading:?}: {found:?}");
    }
}

#[test]
fn a_limit_that_stops_the_work_is_said() {
    let folder = folder("limit");
    let output = folder.solve(&["--error", "0.0000000001%", "--most-elements", "1", "--summary"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("stopped at an estimate of"));
    assert!(lines(&output)[0]["estimate"].as_f64().unwrap() > 1e-12);
}

#[test]
fn a_texture_is_seen_by_points_and_unusable_ones_are_said() {
    let folder = folder("textures");
    let mut image = Vec::new();
    let mut encoder = png::Encoder::new(&mut image, 2, 1);
    encoder.set_source_gamma(png::ScaledFloat::from_scaled(100_000));
    encoder.write_header().unwrap().write_image_data(&[255, 51]).unwrap();
    std::fs::write(folder.0.join("halves.png"), image).unwrap();
    std::fs::write(folder.0.join("squares.mtl"), format!("{WHITE}map_Kd halves.png\nmap_Ke photo.jpg\n")).unwrap();
    let uv = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
    let text = SQUARES.replace("f 1 2 3 4", &format!("{uv}f 1/1 2/2 3/3 4/4")).replace("f 5 6 7 8", "f 5/1 6/4 7/3 8/2");
    std::fs::write(folder.0.join("squares.obj"), text).unwrap();
    let points = [0.25, 0.75].map(|x| format!("{{\"position\":[{x},0.5,0],\"normal\":[0,0,1]}}\n")).concat();
    std::fs::write(folder.0.join("points.jsonl"), points).unwrap();
    let output = folder.solve(&["--points", "points.jsonl", "--error", "0.5%"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(String::from_utf8_lossy(&output.stderr).contains("`photo.jpg` cannot be read"));
    // Each half reflects its reflectance times nearly the same irradiance.
    let reflected: Vec<f64> = lines(&output).iter().map(|line| line["radiosity"][0].as_f64().unwrap() - 1.0).collect();
    let ratio = reflected[0] / reflected[1];
    assert!((4.0..6.0).contains(&ratio), "{ratio}");
}

#[test]
fn refinement_serves_points_where_it_is_asked_to_and_needs_some() {
    let folder = folder("for");
    let none = folder.solve(&["--for", "points"]);
    assert_eq!(none.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&none.stderr).contains("--for points has no points"));
    let served = folder.solve(&["--for", "points", "--points", "points.jsonl", "--error", "1%"]);
    let answers = lines(&served);
    let value = answers[0]["radiosity"][0].as_f64().unwrap();
    assert!((value - 1.133_303_564_992_420_8).abs() < 0.01 * 0.2, "{value}");
    let seen = folder.solve(&["--for", "points", "--camera", "0.5 0.5 0.9 0.5 0.5 0 0 1 0 60", "--error", "1%", "--summary"]);
    assert_eq!(seen.status.code(), Some(0), "{}", String::from_utf8_lossy(&seen.stderr));
    assert!(lines(&seen)[0]["estimate"].as_f64().unwrap() <= 0.01);
}

#[test]
fn without_time_there_is_an_answer_and_its_estimate() {
    let folder = folder("hurry");
    let answers = lines(&folder.solve(&["--seconds", "0", "--points", "points.jsonl"]));
    let [value, estimate] = ["radiosity", "estimate"].map(|name| answers[0][name][0].as_f64().unwrap());
    assert!((value - 1.133_303_564_992_420_8).abs() <= 2.0 * estimate, "{}", answers[0]);
}

/// The reference holds gradients of solutions for its points alone.
#[test]
fn gradients_in_the_cornell_box_are_within_a_hundredth_by_default() {
    let data = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data");
    let text = std::fs::read_to_string(format!("{data}/reference/cornell_gradients.jsonl")).unwrap();
    let truth: Vec<Value> = text.lines().step_by(6).map(|line| serde_json::from_str(line).unwrap()).collect();
    let point = |of: &Value| format!("{{\"position\":{},\"normal\":{}}}\n", of["position"], of["normal"]);
    let points: String = truth.iter().map(point).collect();
    let folder = Folder::new("gradients", &[("points.jsonl", &points)]);
    let mut command = Command::new(env!("CARGO_BIN_EXE_radgrad"));
    let scene = format!("{data}/scenes/cornell.obj");
    let arguments = ["solve", &scene, "--points", "points.jsonl", "--seconds", "1e6", "--summary"];
    let output = command.current_dir(&folder.0).args(arguments).output().unwrap();
    let mut found = lines(&output);
    let summary = found.pop().unwrap();
    assert_eq!(found.len(), truth.len());
    // Some gradients are known to less than a hundredth at the error that is asked for: refinement went on for them.
    assert!(summary["error"] == 1e-3 && summary["estimate"].as_f64().unwrap() <= 2e-4, "{summary}");
    let vector = |of: &Value| [0, 1, 2].map(|k| of[k].as_f64().unwrap());
    let length = |of: [f64; 3]| of.iter().map(|c| c * c).sum::<f64>().sqrt();
    let (mut parts, mut effectivities) = (Vec::new(), Vec::new());
    for (found, truth) in found.iter().zip(&truth) {
        for channel in 0..3 {
            let [a, b] = [&found["gradient"][channel], &truth["gradient"][channel]].map(vector);
            let error = length([0, 1, 2].map(|k| a[k] - b[k]));
            if length(b) > 0.0 {
                parts.push(error / length(b));
                effectivities.push(found["gradient_estimate"][channel].as_f64().unwrap() / error);
            }
        }
    }
    let within = |limit: f64| parts.iter().filter(|part| **part <= limit).count() as f64 / parts.len() as f64;
    effectivities.sort_by(f64::total_cmp);
    let median = effectivities[effectivities.len() / 2];
    println!(
        "{} gradients, {:.3} within 1 %, {:.3} within 0.5 %; estimate over error {median:.2}",
        parts.len(),
        within(0.01),
        within(0.005)
    );
    assert!(within(0.01) >= 1.0, "{parts:.4?}");
    assert!((1.0..=5.0).contains(&median), "{median}");
}
