//! Certificates of `radgrad solve` as a user sees them.

use serde_json::Value;

use crate::solve::{COLOURED, SQUARES, WHITE, folder, lines, numbers};

#[test]
fn the_mean_is_certified_by_default_and_the_same_seed_gives_the_same_bytes() {
    let folder = folder("certified");
    std::fs::write(folder.0.join("squares.mtl"), COLOURED).unwrap();
    let summary = |more: &[&str]| lines(&folder.solve(&[&["--summary", "--error", "1%"][..], more].concat())).remove(0);
    let [first, again, other] = [&["--seed", "7"][..], &["--seed", "7"], &["--confidence", "1e-3"]].map(summary);
    let ends = |of: &Value, channel: usize| [0, 1].map(|k| of["channels"][channel]["certified"][k].as_f64().unwrap());
    for channel in 0..3 {
        let mean = first["channels"][channel]["mean"].as_f64().unwrap();
        let [lower, upper] = ends(&first, channel);
        assert!(lower <= mean * (1.0 + 1e-12) && mean <= upper * (1.0 + 1e-12) && upper - lower < 0.1 * mean, "{first}");
        assert_eq!(ends(&first, channel), ends(&again, channel));
    }
    // Red is not reflected, and so is known.
    assert!(ends(&first, 0)[0] == ends(&first, 0)[1] && ends(&first, 1) != ends(&other, 1));
    assert!(first["confidence"] == 1e-6 && other["confidence"] == 1e-3 && first["seed"] == 7 && other["seed"] == 1);
    let off = summary(&["--certify", "off"]);
    assert!(off.get("confidence").is_none() && off["channels"][0].get("certified").is_none());
    let surface = &first["surfaces"][0];
    let of = |name: &str| surface[name][1].as_f64().unwrap();
    assert!(surface["area"] == 2.0 && of("least") < of("mean") && of("mean") < of("largest"), "{surface}");
    assert!((of("mean") - first["channels"][1]["mean"].as_f64().unwrap()).abs() < 1e-12);
}

#[test]
fn points_are_certified_where_that_is_asked_for_with_the_exact_value_between() {
    let folder = folder("certified-points");
    let lines = lines(&folder.solve(&["--points", "points.jsonl", "--error", "2%", "--certify", "points,2%", "--summary"]));
    let form_factor = 4.0 / std::f64::consts::PI * 0.5_f64.sqrt() * 0.5_f64.sqrt().atan();
    let middle = lines[2]["irradiance"][0].as_f64().unwrap();
    assert!(middle > form_factor);
    for (line, exact) in [(0, 1.133_303_564_992_420_8), (1, 1.076_981_393_145_044_5), (2, middle)] {
        let [lower, upper] = [0, 1].map(|k| lines[line]["certified"][0][k].as_f64().unwrap());
        assert!(lower <= exact && exact <= upper && upper - lower < 0.1 * exact, "{}", lines[line]);
    }
    let (channel, confidence) = (&lines[4]["channels"][0], &lines[4]["confidence"]);
    let [lower, upper] = [0, 1].map(|k| channel["certified"][k].as_f64().unwrap());
    assert!(upper - lower <= 0.04 * channel["reflected"].as_f64().unwrap() && *confidence == 1e-6, "{channel}");
}

#[test]
fn what_is_asked_of_certificates_twice_or_of_nothing_is_refused() {
    let folder = folder("certify-wrong");
    let wrong = [
        (&["--certify", "points"][..], "--certify points has no points: give --points"),
        (&["--certify", "1%,off"], "--certify off is with another"),
        (&["--certify", "1%", "--certify", "2%"], "two widths"),
        (&["--certify", "all"], "expected `points`, `off` or a half-width such as `0.5%`"),
        (&["--confidence", "0"], "0 is not above 0 and below 1"),
    ];
    for (arguments, said) in wrong {
        let output = folder.solve(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(String::from_utf8_lossy(&output.stderr).contains(said), "{}", String::from_utf8_lossy(&output.stderr));
    }
}

#[test]
fn an_upper_end_that_nothing_bounds_is_null() {
    // Squares that lose light beside them alone.
    let folder = folder("unbounded");
    std::fs::write(folder.0.join("squares.mtl"), WHITE.replace("0.5 0.5 0.5", "1 1 1")).unwrap();
    let output = folder.solve(&["--error", "1%", "--summary"]);
    let summary = lines(&output).remove(0);
    let certified = &summary["channels"][0]["certified"];
    assert!(
        certified[0].as_f64().unwrap() > 1.0 && (certified[1].is_null() || certified[1].as_f64().unwrap() > 1.0),
        "{summary}"
    );
}

#[test]
fn a_table_by_surface_fits_a_terminal_and_ends_with_the_certificate() {
    let folder = folder("table");
    std::fs::write(folder.0.join("squares.mtl"), COLOURED).unwrap();
    let long = "a ceiling of a name that is longer than its column";
    let obj = SQUARES.replace("f 1 2 3 4", "g floor\nf 1 2 3 4").replace("f 5 6 7 8", &format!("g {long}\nf 5 6 7 8"));
    std::fs::write(folder.0.join("squares.obj"), obj).unwrap();
    let output = folder.solve(&["--error", "1%"]);
    assert_eq!(output.status.code(), Some(0));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    let floors: Vec<Vec<f64>> = text
        .lines()
        .filter_map(|line| line.strip_prefix("floor"))
        .map(|line| line.split_whitespace().map(|number| number.parse().unwrap()).collect())
        .collect();
    assert_eq!(floors.len(), 3, "a line for each channel: {text}");
    // Red light is emitted.
    assert_eq!(floors[0], [1.0; 4]);
    assert!(floors[1][2] < floors[1][1] && floors[1][1] < floors[1][3] && floors[1][1] > 2.0, "{text}");
    assert!(text.contains(long) && text.ends_with("certified but for a probability of 1e-6, seed 1\n"), "{text}");
}

#[test]
fn files_have_the_certificate_of_the_mean() {
    let folder = folder("certified-files");
    for file in ["out.vtu", "out.ply"] {
        assert_eq!(folder.solve(&["--error", "1%", "--out", file]).status.code(), Some(0));
    }
    let (vtu, ply) = (folder.read("out.vtu"), folder.read("out.ply"));
    let ends = numbers(&vtu, "certified g");
    assert!(ends.len() == 2 && ends[0] < ends[1] && ends[0] > 1.0, "{ends:?}");
    assert_eq!(numbers(&vtu, "confidence"), [1e-6]);
    let said =
        format!("comment mean radiosity of g: certified from {:e} to {:e} but for a probability of 1e-6", ends[0], ends[1]);
    assert!(ply.lines().any(|line| line == said), "{said}");
}
