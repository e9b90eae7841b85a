//! `radgrad factors` and `radgrad field` as a user sees them: files in, files out, an exit status.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

const ROOM: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");

fn radgrad(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_radgrad")).args(arguments).output().unwrap()
}

fn place(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("scenes");
    fs::create_dir_all(&folder).unwrap();
    folder.join(name)
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

#[test]
fn the_summary_is_one_object_and_says_that_a_closed_room_closes() {
    let output = radgrad(&["factors", ROOM, "--summary"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    let number = |name: &str| summary[name].as_f64().unwrap_or_else(|| panic!("{name} in {summary}"));
    assert_eq!(summary["faces"], 21);
    assert!(number("worst_closure") < 1e-12 && number("seconds") > 0.0, "{summary}");
    assert!(number("worst_reciprocity") < 0.1 && number("worst_bound") < 0.5, "{summary}");
    assert!(number("worst_bound_in_free_sight") <= 0.0021, "{summary}");
}

#[test]
fn the_matrix_is_written_in_both_formats_and_they_agree() {
    let (csv, view3d) = (place("room.csv"), place("room.txt"));
    for file in [&csv, &view3d] {
        let output = radgrad(&["factors", ROOM, "--out", file.to_str().unwrap()]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        assert!(text(&output.stdout).starts_with("21 faces of 16 surfaces, "), "{}", text(&output.stdout));
    }
    let text = fs::read_to_string(view3d).unwrap();
    let lines: Vec<Vec<f64>> =
        text.lines().skip(1).map(|line| line.split_whitespace().map(|word| word.parse().unwrap()).collect()).collect();
    let (areas, rows, emittances) = (&lines[0], &lines[1..17], &lines[17]);
    assert_eq!((areas.len(), lines.len(), emittances.len()), (16, 18, 16));
    assert!(emittances.iter().all(|e| (e - 0.3).abs() < 1e-15));
    for row in rows {
        assert!((row.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }
    // Surface 0 is face 0 alone, surface 2 face 2.
    let csv = fs::read_to_string(csv).unwrap();
    let entry = csv.lines().find(|line| line.starts_with("0,room_top,2,room_north,")).unwrap();
    assert_eq!(entry.split(',').nth(4).unwrap().parse::<f64>(), Ok(rows[0][2]));
}

#[test]
fn a_field_has_a_line_a_cell_with_bounds_that_are_small() {
    let file = place("floor.csv");
    let output = radgrad(&["field", ROOM, "--on", "floor", "--grid", "3", "--out", file.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let table = fs::read_to_string(file).unwrap();
    let rows: Vec<Vec<f64>> =
        table.lines().skip(1).map(|line| line.split(',').map(|word| word.parse().unwrap()).collect()).collect();
    assert_eq!(rows.len(), 6 * 9);
    // The ceiling's radiance is 1, so nothing is brighter than pi.
    assert!(rows.iter().all(|row| (0.1..std::f64::consts::PI).contains(&row[4])), "{table}");
    assert!(rows.iter().all(|row| row[8] < 1e-11), "{table}");
}

#[test]
fn a_field_is_a_picture_of_one_patch_and_a_grid_of_any() {
    let (png, vtu) = (place("lit.png"), place("lit.vtu"));
    let field = |on: &str, file: &Path| radgrad(&["field", ROOM, "--on", on, "--grid", "4", "--out", file.to_str().unwrap()]);
    assert_eq!(field("tall_top", &png).status.code(), Some(0));
    assert_eq!(field("floor", &vtu).status.code(), Some(0));
    assert_eq!(&fs::read(&png).unwrap()[1..4], b"PNG");
    let grid = fs::read_to_string(vtu).unwrap();
    assert!(grid.contains("NumberOfPoints=\"384\" NumberOfCells=\"96\"") && grid.ends_with("</VTKFile>\n"));
    let refused = field("floor", &png);
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("the surface has 6"), "{}", text(&refused.stderr));
}

#[test]
fn what_is_wrong_is_named_with_its_place_and_nothing_is_written() {
    let broken = place("broken.obj");
    fs::write(&broken, "v 0 0 0\nv 1 0 0\nv 1 x 0\nf 1 2 3\n").unwrap();
    let out = place("never.csv");
    let out = out.to_str().unwrap();
    let cases: [(&[&str], &str); 7] = [
        (&["factors", broken.to_str().unwrap(), "--out", out], "broken.obj:3: "),
        (&["factors", "missing.obj", "--out", out], "`missing.obj` cannot be read"),
        (&["factors", ROOM, "--out", "matrix.zip"], "`matrix.zip`: the matrix is written to a name ending in"),
        (&["factors", ROOM, "--points", "17", "--out", out], "expected 1 to 16 points per side, found 17"),
        (&["factors", ROOM, "--tolerance", "2", "--out", out], "tolerance is 2"),
        (&["field", ROOM, "--on", "roof", "--grid", "2", "--out", out], "`roof`"),
        (&["field", ROOM, "--on", "floor", "--grid", "0", "--out", out], "grid of at least one cell"),
    ];
    for (arguments, message) in cases {
        let output = radgrad(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(output.stdout.is_empty() && text(&output.stderr).contains(message), "{}", text(&output.stderr));
    }
    assert!(!Path::new(out).exists());
}
