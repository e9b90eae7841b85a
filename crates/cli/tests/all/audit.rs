//! `radgrad audit` on the programs of the examples, with a slip planted in one, and on our own `eval`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use radgrad_audit::cases::family::Family;
use radgrad_audit::measures::run::Run;

const RADGRAD: &str = env!("CARGO_BIN_EXE_radgrad");

fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(name)
}

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("radgrad-audit-{name}-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn audit(program: &str, more: &[&str]) -> Output {
    Command::new(RADGRAD).args(["audit", "--program", program]).args(more).output().unwrap()
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Figure of a family in `errors.csv`: the worst decade of a quantity, as a number.
fn worst(folder: &Path, family: &str, quantity: &str) -> f64 {
    let text = fs::read_to_string(folder.join("errors.csv")).unwrap();
    let row = text.lines().find(|line| line.starts_with(&format!("{family},{quantity},"))).unwrap_or_else(|| panic!("{text}"));
    row.split(',').nth(5).unwrap().trim_start_matches('<').parse().unwrap()
}

/// Compiles a source with `cc`, which the project needs anyway.
fn compiled(source: &str, folder: &Path) -> PathBuf {
    let (file, program) = (folder.join("lambert.c"), folder.join("lambert"));
    fs::write(&file, source).unwrap();
    let status = Command::new("cc").args(["-O2", "-o"]).arg(&program).arg(&file).arg("-lm").status().expect("a C compiler");
    assert!(status.success());
    program
}

const FAMILIES: [&str; 6] = ["--family", "generic", "--family", "far", "--family", "near-edge"];

#[test]
fn a_lambert_sum_in_c_loses_its_digits_far_away_and_a_slip_of_sign_in_it_is_caught() {
    let folder = folder("c");
    let source = fs::read_to_string(example("lambert.c")).unwrap();
    let gates = folder.join("gates.toml");
    fs::write(&gates, "[generic]\nvalue = 1e-9\n").unwrap();
    let more = |out: &'static str| [&["--cases", "60", "--gates", gates.to_str().unwrap(), "--out", out][..], &FAMILIES].concat();
    let out: &'static str = folder.join("right").to_str().unwrap().to_owned().leak();
    let right = compiled(&source, &folder);
    let output = audit(right.to_str().unwrap(), &more(out));
    assert_eq!(output.status.code(), Some(0), "{}", text(&output));
    let at = |family: &str| worst(Path::new(out), family, "value");
    assert!(at("generic") <= 1e-9 && at("far") >= 1e-2 && at("near-edge") >= 1e-11, "{}", text(&output));
    // Counter-clockwise seen from the wrong side.
    let slipped = source.replace("return -sum;", "return sum;");
    assert_ne!(slipped, source);
    let out: &'static str = folder.join("slipped").to_str().unwrap().to_owned().leak();
    let output = audit(compiled(&slipped, &folder).to_str().unwrap(), &more(out));
    assert_eq!(output.status.code(), Some(1), "{}", text(&output));
    assert!(text(&output).contains("VIOLATED generic: value is 2.00e0, the gate is 1e-9"), "{}", text(&output));
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_lambert_sum_in_python_has_a_gradient_that_is_measured() {
    if Command::new("python3").arg("--version").output().is_err() {
        eprintln!("SKIPPED: python3 is not installed");
        return;
    }
    let folder = folder("python");
    let program = format!("python3 '{}'", example("lambert.py").display());
    let output = audit(&program, &[&["--cases", "30", "--out", folder.to_str().unwrap()][..], &FAMILIES].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output));
    let at = |family: &str, quantity: &str| worst(&folder, family, quantity);
    assert!(at("generic", "value") <= 1e-10 && at("generic", "gradient") <= 1e-7, "{}", text(&output));
    assert!(at("far", "gradient") >= 1e-3, "{}", text(&output));
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn our_own_program_has_the_tables_of_the_audit() {
    let folder = folder("own");
    let output =
        audit(&format!("'{RADGRAD}' eval - --effort 1e12"), &["--cases", "2", "--seed", "3", "--out", folder.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output));
    let table = Run::of_each(2, &Family::ALL, 3).table(|_| ());
    let (mut errors, mut outcomes) = (Vec::new(), Vec::new());
    table.write_errors(&mut errors).unwrap();
    table.write_outcomes(&mut outcomes).unwrap();
    assert_eq!(fs::read_to_string(folder.join("errors.csv")).unwrap(), String::from_utf8(errors).unwrap());
    assert_eq!(fs::read_to_string(folder.join("outcomes.csv")).unwrap(), String::from_utf8(outcomes).unwrap());
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_program_that_does_not_answer_is_refused_and_says_so() {
    let output = audit("head -n 3", &["--cases", "4", "--family", "generic"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("it answered 3 of 4 cases"), "{output:?}");
    let echoed = audit("cat", &["--cases", "2", "--family", "generic"]);
    assert!(text(&echoed).contains("no radiosity"), "{}", text(&echoed));
}

#[test]
fn a_program_that_hangs_or_answers_without_end_is_ended() {
    let of = |program: &str, more: &[&str]| {
        let output = audit(program, &[&["--cases", "2", "--family", "generic"][..], more].concat());
        assert_eq!(output.status.code(), Some(2), "{program}: {output:?}");
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    assert!(of("sleep 1000", &["--seconds", "1"]).contains("no answer came in time after 0 of 2"));
    assert!(of("sleep 1000 & sleep 1000", &["--seconds", "1"]).contains("--seconds"));
    assert!(of("yes '{}'", &[]).contains("more than 2 cases"));
    assert!(of("cat /dev/zero", &[]).contains("longer than"));
    if cfg!(target_os = "linux") {
        // A shell's own memory: it fails, and its line is missing.
        assert!(of("x=x; while :; do x=$x$x; done", &["--memory", "64", "--seconds", "20"]).contains("0 of 2 cases"));
    }
}

#[test]
fn what_a_program_answers_is_shown_escaped_and_nothing_answered_is_a_failure() {
    let answer = r#"while read line; do printf '{"error":"\\u001b[2J\\u001b[31mboo"}\n'; done"#;
    let output = audit(answer, &["--cases", "2", "--family", "generic"]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    assert!(!output.stdout.contains(&0x1b) && text(&output).contains("boo"), "{}", text(&output));
    assert!(text(&output).contains("nothing was answered"), "{}", text(&output));
}

#[test]
fn gates_are_read_as_scenes_are_and_not_quoted() {
    let folder = folder("gates");
    let secret = folder.join("secret.txt");
    fs::write(&secret, "root:x:0:0:secret\n").unwrap();
    for (gates, words) in [(secret.to_str().unwrap(), "line 1: expected `[all]`"), ("/dev/zero", "/dev/zero"), ("/", "/")] {
        let output = audit("cat", &["--cases", "1", "--family", "generic", "--gates", gates]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && said.contains(words) && !said.contains("secret\n"), "{said}");
    }
    fs::remove_dir_all(folder).unwrap();
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_output_is_a_sentence() {
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let program = format!("'{RADGRAD}' eval -");
    let arguments = ["audit", "--program", &program, "--cases", "1", "--family", "generic"];
    let output = Command::new(RADGRAD).args(arguments).stdout(full).stderr(std::process::Stdio::piped()).spawn().unwrap();
    let output = output.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(2) && said.contains("cannot write to the standard output"), "{said}");
}
