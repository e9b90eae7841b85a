//! `View3D` files of our own, and every kind of wrong line.

use super::*;
use crate::reading::Degenerate;
use crate::scene::Surface;
use crate::scene::note::Note;

/// A unit cube seen from inside, as six surfaces.
const CUBE: &str = "T  a cube\nC  encl=1 list=2, eps=1.e-4 maxU = 8\nF  3\n\
    !  #   x  y  z\n\
    V  1   0. 0. 0.\nV  2   1. 0. 0.\nV  3   1. 1. 0.\nV  4   0. 1. 0.\n\
    V  5   0. 0. 1.\nV  6   1. 0. 1.\nV  7   1. 1. 1.\nV  8   0. 1. 1.\n\
    !  #   v1 v2 v3 v4 base cmb emit name\n\
    S  1   1  2  3  4    0   0  0.90  floor\n\
    S  2   8  7  6  5    0   0  0.80  ceiling   ! above\n\
    s  3   1  5  6  2    0   0  0.90  south/wall\n\
    S  4   2  6  7  3    0   0  0.90  east\n\
    S  5   3  7  8  4    0   0  0.90  north\n\
    S  6   4  8  5  1    0   0  0.90  west\n";

/// Reads a text to which its end is added.
fn scene(text: &str) -> Result<Scene, Error> {
    parse(format!("{text}\nEnd of data\n").as_bytes(), Path::new("a.vs3"), Degenerate::Refuse)
}

fn names(scene: &Scene) -> Vec<&str> {
    scene.surfaces().iter().map(|surface| surface.name()).collect()
}

/// The error message when `lines` follow those of the cube.
fn message(lines: &str) -> String {
    scene(&format!("{CUBE}{lines}")).unwrap_err().to_string()
}

#[test]
fn a_room_is_read_with_its_names_materials_and_control() {
    let cube = scene(CUBE).unwrap();
    assert_eq!(names(&cube), ["floor", "ceiling", "south/wall", "east", "north", "west"]);
    assert_eq!((cube.title(), cube.enclosure(), cube.channels()), (Some("a cube"), Some(true), &["grey".to_owned()][..]));
    let centre = DVec3::splat(0.5);
    for face in cube.faces() {
        let polygon = face.polygon();
        assert!(polygon.normal().dot(centre - polygon.vertices()[0]) > 0.0, "seen from inside");
    }
    let reflectance: Vec<f64> = cube.faces().iter().map(|f| cube.materials()[f.material()].reflectance()[0]).collect();
    assert_eq!(reflectance, [0.9, 0.8, 0.9, 0.9, 0.9, 0.9].map(|emittance| 1.0 - emittance));
    assert_eq!(cube.faces()[1].place().unwrap().to_string(), "a.vs3:15");
    assert!(cube.notes().is_empty());
}

#[test]
fn what_stands_after_the_end_is_not_read() {
    for end in ["End of data", "e", "* that is all"] {
        let text = format!("{CUBE}{end}\n  O   O\n  | S |\nQ\n").replace('\n', "\r\n");
        assert_eq!(scene(&text).unwrap().faces().len(), 6);
    }
}

#[test]
fn combined_surfaces_are_one_surface_of_several_faces() {
    let halves = "S 7 3 2 1 0 0 1 0.9 floor-b\nS 8 3 7 6 0 0 0 0.5 last\nS 9 5 6 7 0 0 1 0.9\n";
    let read = scene(&format!("{CUBE}{halves}")).unwrap();
    assert_eq!(read.surfaces().len(), 7);
    assert_eq!((read.surfaces()[0].faces(), read.area_of(0)), (&[0, 6, 8][..], 2.0));
    assert_eq!(read.faces()[7].surface(), 6);
}

#[test]
fn an_obstruction_hides_and_has_no_row() {
    for obstruction in ["O 7 1 2 7 8", "o 7 1 2 7 8 0 0 0.90 sheet"] {
        let read = scene(&format!("{CUBE}{obstruction}\n")).unwrap();
        assert_eq!((read.faces().len(), read.surfaces()[6].exchanges()), (7, false));
        assert!(read.surfaces()[..6].iter().all(Surface::exchanges));
    }
}

#[test]
fn shapes_in_planes_give_the_room_that_vertices_give() {
    let text = "C encl=1\nF 3a\n\
        S 1 R 0 0 0.90 floor\n 0 0 0  180 0\n 1 1\n\
        S 2 R 0 0 0.80 ceiling\n 0 1 1  180 180   1 1 ! one line\n\
        S 3 R 0 0 0.90 south/wall\n 1 0 0  0 90\n 1\n\n 1\n\
        S 4 r 0 0 0.90 east\n 1 1 0  270 90  1 1\n\
        S 5 Q 0 0 0.90 north\n 0 1 0  180. 90\n 0 0  1 0  1 1  0 1\n\
        S 6 R 0 0 0.90 west\n 0 0 0  90 90  1 1\n\
        E\n";
    let shapes = scene(text).unwrap();
    let cube = scene(CUBE).unwrap();
    assert_eq!(names(&shapes), names(&cube));
    for (shape, face) in shapes.polygons().zip(cube.polygons()) {
        assert_eq!((shape.normal(), shape.area()), (face.normal(), face.area()));
        assert!(shape.vertices().iter().all(|v| face.vertices().contains(v)), "{:?} {:?}", shape.vertices(), face.vertices());
    }
    assert_eq!(shapes.faces()[3].place().unwrap().to_string(), "a.vs3:13", "where it starts");
}

#[test]
fn a_tilted_shape_faces_where_azimuth_and_tilt_say() {
    let read = scene("F 3a\nS 1 T 0 0 0.9 roof\n 1 2 3  30 60  0 0  2 0  0 1\n").unwrap();
    let polygon = read.faces()[0].polygon();
    let (half, root) = (0.5, 0.75_f64.sqrt());
    assert!((polygon.normal() - DVec3::new(root * half, root * root, half)).length() < 1e-15);
    assert!((polygon.area() - 1.0).abs() < 1e-15);
    assert_eq!(polygon.vertices()[0], DVec3::new(1.0, 2.0, 3.0));
}

#[test]
fn surfaces_described_as_shapes_are_read_under_either_geometry() {
    let read = scene("F 3\nS 1 R 0 0 0.9 wall\n 0 0 0  90 90  1 1\n").unwrap();
    assert_eq!(read.faces()[0].polygon().normal(), DVec3::X);
}

#[test]
fn a_base_is_cut_around_its_subsurfaces_and_no_area_counts_twice() {
    // Two windows with a common edge in the ceiling, one of them with a pane in it, and a door at the edge of the south wall.
    let vertices = "V 9 0.2 0.3 1\nV 10 0.5 0.3 1\nV 11 0.5 0.7 1\nV 12 0.2 0.7 1\nV 13 0.9 0.3 1\nV 14 0.9 0.7 1\n\
        V 15 0.6 0.4 1\nV 16 0.8 0.4 1\nV 17 0.8 0.6 1\nV 18 0.6 0.6 1\nV 19 0.1 0 0\nV 20 0.4 0 0\nV 21 0.4 0 0.7\nV 22 0.1 0 0.7\n";
    let surfaces = "S 7 12 11 10 9 2 0 0.9 window-a\nS 8 11 14 13 10 2 0 0.9 window-b\nS 9 18 17 16 15 8 0 0.9 pane\n\
        S 10 19 22 21 20 3 0 0.9 door\n";
    let text = CUBE.replace("!  #   v1", &format!("{vertices}! #")) + surfaces;
    let read = scene(&text).unwrap();
    let expected = [1.0, 1.0 - 0.28, 1.0 - 0.21, 1.0, 1.0, 1.0, 0.12, 0.16 - 0.04, 0.04, 0.21];
    for (surface, expected) in expected.into_iter().enumerate() {
        assert!((read.area_of(surface) - expected).abs() < 1e-15, "{surface} {}", read.area_of(surface));
    }
    let total: f64 = read.polygons().map(Polygon::area).sum();
    assert!((total - 6.0).abs() < 1e-14);
    // No two pieces of one surface overlap: a point is in one piece of the ceiling or in one of its windows.
    for i in 0..50 {
        for j in 0..50 {
            let point = DVec3::new((f64::from(i) + 0.5) / 50.03, (f64::from(j) + 0.5) / 50.07, 1.0);
            let ceiling = read.faces().iter().filter(|face| [1, 6, 7, 8].contains(&face.surface()));
            let holding = ceiling.filter(|face| {
                let v = face.polygon().vertices();
                (0..v.len()).all(|i| (v[(i + 1) % v.len()] - v[i]).cross(point - v[i]).dot(face.polygon().normal()) > 0.0)
            });
            assert_eq!(holding.count(), 1, "{point}");
        }
    }
}

#[test]
fn a_null_surface_takes_area_from_its_base_and_still_hides() {
    let vertices = "V 9 0.2 0.2 0\nV 10 0.4 0.2 0\nV 11 0.4 0.4 0\nV 12 0.2 0.4 0\n";
    let read = scene(&(CUBE.replace("!  #   v1", &format!("{vertices}! #")) + "N 7 12 11 10 9 1 0 0.9 hole\n")).unwrap();
    assert!((read.area_of(0) - 0.96).abs() < 1e-15);
    assert_eq!((read.surfaces()[6].exchanges(), read.surfaces()[6].faces().len()), (false, 1));
}

#[test]
fn subsurfaces_that_do_not_fit_are_refused_with_the_reason() {
    let vertices = "V 9 0.5 0.5 0\nV 10 1.5 0.5 0\nV 11 1.5 1 0\nV 12 0.5 1 0\nV 13 0.5 0.5 0.001\nV 14 0.3 0.3 0\n";
    let error = |surfaces: &str| {
        let text = CUBE.replace("!  #   v1", &format!("{vertices}! #")) + surfaces + "\n";
        scene(&text).unwrap_err().to_string()
    };
    let outside = error("S 7 9 10 11 12 1 0 0.9 window");
    assert!(outside.starts_with("a.vs3:26: subsurface of surface 1: of its area 0.5, 2.5e-1 is outside the base"), "{outside}");
    let refusal = error("S 7 13 3 4 0 1 0 0.9 window");
    assert!(refusal.contains("a vertex is 1e-3 off the plane of the base (allowed 4"), "{refusal}");
    assert!(error("S 7 12 3 9 0 1 0 0.9 window").contains("must face as its base does"));
    assert!(error("N 7 9 3 12 0 1 0 0.9 hole").contains("a null surface must face its base"));
    assert!(error("S 7 9 3 12 0 1 0 0.9 window\nS 8 9 3 12 0 1 0 0.9 again").contains("in another subsurface"));
    assert!(error("S 7 1 2 14 4 0 0 0.9 arrow\nS 8 1 2 14 0 7 0 0.9 tip").contains("a base must be convex"));
    assert!(error("S 7 1 2 14 4 1 0 0.9 arrow").contains("a subsurface must be convex"));
}

#[test]
fn wrong_lines_are_named_with_what_was_expected() {
    for (lines, expected) in [
        ("S 8 1 2 3 0 0 0 0.9 x", "expected surface 7, the next in sequence, found 8"),
        ("V 10 1 2 3", "expected vertex 9, the next in sequence, found 10"),
        ("V 9 1 2 nan\nS 7 1 2 9 0 0 0 0.9 x", "expected a finite number (z), found `nan`"),
        ("V 9 1 2\nO 7 1 2 9 0", "expected a number (z), found the end of the line"),
        ("S 7 1 2 9 0 0 0 0.9 x", "expected a vertex from 1 to 8, those before this line, found 9"),
        ("S 7 1 2 0 0 0 0 0.9 x", "expected a vertex from 1 to 8, those before this line, found 0"),
        ("S 7 1 2 3 -4 0 0 0.9 x", "expected a vertex from 1 to 8, those before this line, found -4"),
        ("S 7 1 2 3", "expected an integer (number of vertex 4, or a shape R, Q or T), found the end of the line"),
        ("S 7 X 0 0 0.9 x", "expected an integer (number of vertex 1, or a shape R, Q or T), found `X`"),
        ("S 7 1 2 3 0 7 0 0.9 x", "expected an earlier surface, 1 to 6, or 0 for none (base), found 7"),
        ("S 7 1 2 3 0 0 9 0.9 x", "expected an earlier surface, 1 to 6, or 0 for none (cmb), found 9"),
        ("S 7 1 2 3 0 0 0 1.5 x", "expected an emittance between 0 and 1, found 1.5"),
        ("S 7 1 2 3 0 0 0", "expected a number (emittance), found the end of the line"),
        ("N 7 1 2 3 0 0 0 0.9 x", "expected the base of a null surface, found 0"),
        ("O 7 1 2 3 0 1 0 0.9 x", "expected 0, since an obstruction has no base, found 1"),
        ("M 7 1 2 3 0 1 0 0.9 x", "a masking surface cannot be represented: leave it"),
        ("F 2", "expected a geometry of three dimensions, F 3 or F 3a, found `2`"),
        ("C encl=x", "expected encl=0 or encl=1, found `x`"),
        ("7 0.5 0.5", "expected a line of T, C, F, V, S, O, N or E, found `7`"),
    ] {
        let message = message(lines);
        assert!(message.starts_with(&format!("a.vs3:20: {expected}")), "{lines}: {message}");
    }
    assert!(
        message("S 7 1 2 3 0 0 1 0.9 x\nS 8 1 2 3 0 0 7 0.9 y").starts_with("a.vs3:21: expected a radiating surface that is not")
    );
    assert_eq!(message("S 7 R 0 0 0.9 x\n0 0 0\n0 90 x 1"), "a.vs3:22: expected a number (width), found `x`");
    assert_eq!(message("S 7 R 0 0 0.9 x\n0 0 0"), "a.vs3:22: expected a number (azimuth), found `End`");
    assert_eq!(message("S 7 R 0 0 0.9 x\n0 0 0 0 90 1 1 1"), "a.vs3:21: expected the end of the line, found `1`");
    assert_eq!(scene("T nothing\n").unwrap_err().to_string(), "a.vs3: expected at least one face, found none");
}

#[test]
fn a_file_cut_off_anywhere_is_refused() {
    let text = format!("{CUBE}End of data");
    let read = |length: usize| parse(&text.as_bytes()[..length], Path::new("a.vs3"), Degenerate::Refuse);
    for length in 0..=CUBE.len() {
        let message = read(length).unwrap_err().to_string();
        assert!(message.starts_with("a.vs3"), "{message}");
    }
    assert!(read(text.len()).is_ok());
    assert_eq!(read(CUBE.len()).unwrap_err().to_string(), "a.vs3: expected a line `End of data`, found the end of the file");
}

#[test]
fn unknown_control_words_are_noted_and_warped_surfaces_split() {
    let lines = "C encl=8 epsilon=3 frob\nV 9 1 1 0.5\nS 7 1 2 9 4 0 0 0.9 warped\n";
    let read = scene(&format!("{CUBE}{lines}")).unwrap();
    assert_eq!(read.surfaces()[6].faces(), [6, 7]);
    let notes: Vec<String> = read.notes().iter().map(ToString::to_string).collect();
    assert_eq!(notes[1], "a.vs3:20: unknown control word `epsilon` is not used");
    assert_eq!(notes[2], "a.vs3:20: unknown control word `frob` is not used");
    assert_eq!((notes[0].as_str(), read.enclosure()), ("a.vs3:20: encl=8 is taken as encl=1", Some(true)));
    assert!(matches!(&read.notes()[3], Note::Split { surface, triangles: 2, .. } if surface == "warped"));
}

#[test]
fn what_no_surface_needs_is_noted() {
    let lines = "V 9 1 2 nan\nV 10 0 0 1 2\nS 7 1 2 10 0 0 0 1.5 x\n".replace("1.5 x", "0.9 Fu\u{1}");
    let bytes: Vec<u8> =
        format!("{CUBE}{lines}E\n").replace('\n', "\r").bytes().map(|byte| if byte == 1 { 0xdf } else { byte }).collect();
    let read = parse(&bytes, Path::new("a.vs3"), Degenerate::Refuse).unwrap();
    assert_eq!(names(&read)[6], "Fu\u{df}");
    let notes: Vec<String> = read.notes().iter().map(ToString::to_string).collect();
    assert_eq!(
        notes,
        [
            "a.vs3:22: the text is no UTF-8 (byte 0xdf): read as Latin-1",
            "a.vs3:21: what follows the coordinates of a vertex is not used",
            "a.vs3:20: expected a finite number (z), found `nan`: of a vertex that no face uses",
        ]
    );
    let optional = Reading { materials: crate::Materials::Optional, ..Reading::default() };
    let read = parse(format!("{CUBE}S 7 1 2 3 0 0 0 nan x\nE\n").as_bytes(), Path::new("a.vs3"), optional).unwrap();
    assert!(read.notes()[0].to_string().ends_with("found `nan`: taken as black"), "{}", read.notes()[0]);
}
