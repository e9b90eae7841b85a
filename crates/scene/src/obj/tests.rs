//! OBJ and MTL as they are written in the world, and every kind of wrong line.

use super::*;
use crate::Degenerate;
use crate::{Note, Quantity};

/// Four vertices of a unit square in z = 0, counter-clockwise from above.
const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn scene(text: &str) -> Result<Scene, Error> {
    with_library(text, "newmtl grey\nKd 0.5 0.5 0.5\n")
}

fn with_library(text: &str, library: &str) -> Result<Scene, Error> {
    parse(text.as_bytes(), Path::new("a.obj"), Degenerate::Refuse, |name| match name.to_str() {
        Some("a.mtl" | "my lamps.mtl") => Ok(library.into()),
        _ => Err(io::Error::new(io::ErrorKind::NotFound, "no such file")),
    })
}

fn message(text: &str) -> String {
    scene(text).unwrap_err().to_string()
}

#[test]
fn every_form_of_a_face_gives_the_same_polygon() {
    let attributes = "vt 0 0\nvn 0 0 1\n";
    for face in ["1 2 3 4", "-4 -3 -2 -1", "1/1 2/1 3/1 4/1", "1//1 2//1 3//-1 4//1", "1/1/1 2/1/1 -2/1/1 4/1/1"] {
        let read = scene(&format!("{SQUARE}{attributes}f {face}\n")).unwrap();
        assert_eq!(read.faces().len(), 1);
        let polygon = read.faces()[0].polygon();
        assert_eq!((polygon.vertices().len(), polygon.normal(), polygon.area()), (4, DVec3::Z, 1.0), "{face}");
    }
}

#[test]
fn either_end_of_line_comments_continuations_and_a_mark_change_nothing() {
    let plain = scene(&format!("{SQUARE}g floor\nf 1 2 3 4\n")).unwrap();
    let dressed = "\u{feff}# head # \\\r\n\r\nv 0 0 0 # origin\r\nv 1 \\\r\n  0 \\\r\n 0\r\n\tv 1 1 0 1.0\r\nv 0 1 0 0.5 0.5 0.5\r\n\
                   g  floor  \r\nf 1 2 \\\r\n3 4";
    let dressed = scene(dressed).unwrap();
    assert_eq!(plain.polygons().collect::<Vec<_>>(), dressed.polygons().collect::<Vec<_>>());
    assert_eq!(plain.surfaces(), dressed.surfaces());
    assert_eq!(dressed.faces()[0].place().unwrap().to_string(), "a.obj:10", "the first line of the statement");
}

#[test]
fn coordinates_keep_the_digits_of_a_double() {
    let read = scene("v 0.1 0 0\nv 1e-300 1 0\nv 0 0.30000000000000004 1\nf 1 2 3").unwrap();
    let vertices = read.faces()[0].polygon().vertices();
    assert_eq!((vertices[0].x, vertices[1].x, vertices[2].y), (0.1, 1e-300, 0.1 + 0.2));
}

#[test]
fn surfaces_are_groups_in_objects_and_come_back_by_name() {
    let text = format!(
        "{SQUARE}f 1 2 3\no house\nf 1 2 3\ng south wall\nf 1 2 3\ng roof\nf 1 2 3\no shed\nf 1 2 3\no house\ng roof\nf 1 3 4\ng\nf 1 2 3\n"
    );
    let read = scene(&text).unwrap();
    let surfaces: Vec<(&str, &[usize])> = read.surfaces().iter().map(|s| (s.name(), s.faces())).collect();
    assert_eq!(
        surfaces,
        [("default", &[0][..]), ("house", &[1, 6]), ("house/south wall", &[2]), ("house/roof", &[3, 5]), ("shed", &[4])]
    );
    assert_eq!(read.notes().len(), 1, "no material: {:?}", read.notes());
    assert_eq!(read.materials()[0].reflectance(), [0.0; 3]);
}

#[test]
fn materials_have_reflectance_and_radiance_and_the_rest_is_noted_where_it_matters() {
    let library = "# lamps\nnewmtl white\r\nKd 0.7 0.6 0.5\nNs 10\nillum 2\nd 1\nmap_Kd wood.png\nfancy 3\n\
                   newmtl the lamp\nKe 16.72\nTr 0.5\nnewmtl rest\n";
    let text = format!("mtllib my lamps.mtl\nmtllib my lamps.mtl\n{SQUARE}usemtl white\nf 1 2 3\nusemtl the lamp\nf 1 3 4\n");
    let read = with_library(&text, library).unwrap();
    let of = |face: usize| &read.materials()[read.faces()[face].material()];
    assert_eq!((of(0).name(), of(0).reflectance(), of(0).radiance()), ("white", &[0.7, 0.6, 0.5][..], &[0.0; 3][..]));
    assert_eq!((of(1).name(), of(1).reflectance(), of(1).radiance()), ("the lamp", &[0.0; 3][..], &[16.72; 3][..]));
    let notes: Vec<String> = read.notes().iter().map(ToString::to_string).collect();
    assert_eq!(
        notes,
        [
            "my lamps.mtl:4: property `Ns` is not used: surfaces are opaque and diffuse",
            "my lamps.mtl:5: property `illum` is not used: surfaces are opaque and diffuse",
            "my lamps.mtl:8: unknown property `fancy` is not used",
            "my lamps.mtl:11: transparency is not used: every face is opaque",
            "my lamps.mtl:7: texture `map_Kd` is not used, `wood.png` cannot be read: no such file: `Kd` holds all over the face",
        ]
    );
    assert_eq!(read.materials().len(), 3, "a library is read once");
}

#[test]
fn several_libraries_may_stand_in_one_line() {
    let read = with_library(&format!("mtllib my lamps.mtl a.mtl\n{SQUARE}usemtl grey\nf 1 2 3"), "newmtl grey\n");
    let notes: Vec<String> = read.unwrap().notes().iter().map(ToString::to_string).collect();
    assert_eq!(notes, ["my", "lamps.mtl"].map(|name| format!("a.obj:1: `{name}` cannot be read: no such file")));
    let both = format!("mtllib a.mtl a.mtl\n{SQUARE}usemtl grey\nf 1 2 3");
    assert!(with_library(&both, "newmtl grey\n").is_ok());
}

#[test]
fn a_missing_library_or_material_is_named_with_its_line() {
    let text = format!("# x\nmtllib none.mtl\n{SQUARE}usemtl grey\nf 1 2 3\n");
    assert_eq!(message(&text), "a.obj:7: there is no material `grey`: `none.mtl` cannot be read: no such file");
    // Where nobody needs it, it is black.
    let optional = Reading { materials: crate::Materials::Optional, ..Reading::default() };
    let missing = |_: &Path| Err(io::Error::new(io::ErrorKind::NotFound, "no such file"));
    let read = parse(text.as_bytes(), Path::new("a.obj"), optional, missing).unwrap();
    let notes: Vec<String> = read.notes().iter().map(ToString::to_string).collect();
    assert_eq!(notes[0], "a.obj:2: `none.mtl` cannot be read: no such file");
    assert!(notes[1].ends_with("no such file: taken as black") && read.materials()[0].name() == "grey", "{notes:?}");
    assert_eq!(message("mtllib a.mtl\nusemtl gray\n"), "a.obj:2: there is no material `gray`: 1 are known from 1 libraries");
    assert!(message("mtllib\n").starts_with("a.obj:1: expected the name of a material library"));
}

#[test]
fn a_wrong_material_is_named_with_the_line_of_its_library() {
    let error = |library: &str| with_library("mtllib a.mtl\n", library).unwrap_err().to_string();
    assert_eq!(
        error("newmtl m\nKe 1 1 1\nKd 0.5 1.2 0.5\n"),
        "a.mtl:3: material `m`: reflectance is 1.2 in channel `g`: it must be between 0 and 1"
    );
    assert_eq!(
        error("newmtl m\nKd 1 1 1\n\nKe 0 0 -1\nnewmtl n\n"),
        "a.mtl:4: material `m`: radiance is -1 in channel `b`: it must be finite and not negative, and so must be its product with pi"
    );
    assert_eq!(error("newmtl m\nKd 0.5 0.5\n"), "a.mtl:2: expected a number (blue), found the end of the line");
    assert_eq!(
        error("newmtl m\nKd spectral a.rfl\n"),
        "a.mtl:2: a colour given as `spectral` cannot be represented: give red, green and blue"
    );
    // No word of a file that is none is shown.
    for foreign in ["Kd 1 1 1\n", "root:x:0:0\n", "secret", "\x1b[2J\n"] {
        assert_eq!(error(foreign), "a.mtl:1: expected a material library, `newmtl` first, found another file");
    }
    assert_eq!(error("newmtl\n"), "a.mtl:1: expected the name of a material, found the end of the line");
}

#[test]
fn wrong_statements_are_named_with_file_line_and_what_was_expected() {
    let with = |line: &str| message(&format!("{SQUARE}\n{line}\n"));
    assert_eq!(with("f 1 2 5"), "a.obj:6: expected the index of a vertex: 1 to 4 or -1 to -4 stand before this line, found `5`");
    for index in ["0", "-5", "99999999999999999", "-9223372036854775808"] {
        assert!(with(&format!("f 1 2 {index}")).contains(&format!("found `{index}`")), "{index}");
    }
    assert!(message("f 1 2 3").contains("no vertices stand before this line"));
    for word in ["a", "1/", "1/2/", "1/2/3/4", "1//", "1.0", "1/x"] {
        assert!(with(&format!("f 1 2 {word}")).contains(&format!("`v/vt/vn`), found `{word}`")), "{word}");
    }
    assert_eq!(with("v 1 2"), "a.obj:6: expected a number (z), found the end of the line");
    assert_eq!(with("v 1 2 nan"), "a.obj:6: expected a finite number (z), found `nan`");
    assert_eq!(with("v 1 2 3 4 5 6 7 8"), "a.obj:6: expected the end of the line, found `8`");
    assert_eq!(with("F 1 2 3"), "a.obj:6: expected a statement of OBJ (v, f, o, g, usemtl, mtllib, ...), found `F`");
    assert!(with("curv2 1 2").contains("free-form statement `curv2` cannot be represented"));
    assert_eq!(with("f 1 2"), "a.obj:6: face refused: a polygon needs at least 3 vertices, this one has 2");
    let bytes = [SQUARE.as_bytes(), b"g caf\xe9\n"].concat();
    let error = parse(&bytes, Path::new("a.obj"), Degenerate::Refuse, |_| Ok(Vec::new())).unwrap_err().to_string();
    assert_eq!(error, "a.obj:5: expected UTF-8 text, found byte 0xe9 at column 6");
}

#[test]
fn a_file_cut_off_anywhere_is_refused_or_is_a_smaller_scene() {
    let text = format!("mtllib a.mtl\n{SQUARE}g floor\nusemtl grey\nf 1 2 3\nf 1 3 4\n");
    let whole = scene(&text).unwrap();
    for length in 0..text.len() - 1 {
        match scene(&text[..length]) {
            Ok(part) => assert!(part.faces().len() < 2 || length >= text.len() - 2, "{length}"),
            Err(error) => assert!(error.to_string().starts_with("a.obj"), "{error}"),
        }
    }
    assert_eq!(whole.faces().len(), 2);
    assert_eq!(message(""), "a.obj: expected at least one face, found none");
}

#[test]
fn a_face_that_is_not_planar_becomes_triangles_and_is_reported() {
    let warped = "v 552.8 0 0\nv 549.6 0 559.2\nv 556 548.8 559.2\nv 556 548.8 0\n";
    let read = scene(&format!("{warped}g left\nf 1 2 3 4\nf 1 2 3\n")).unwrap();
    assert_eq!(read.faces().len(), 3);
    let [first, second] = [0, 1].map(|i| read.faces()[i].polygon().vertices());
    let v = |i: usize| read.faces()[i / 3].polygon().vertices()[i % 3];
    assert_eq!((first, second), (&[v(0), v(1), v(2)][..], &[v(0), v(2), v(5)][..]), "the diagonal starts at the first vertex");
    assert!(read.faces().iter().all(|face| face.polygon().planarity_defect() == 0.0));
    let [_, Note::Split { place, surface, triangles, distance, size }] = read.notes() else { panic!("{:?}", read.notes()) };
    assert_eq!((place.to_string().as_str(), surface.as_str(), *triangles, *size), ("a.obj:6", "left", 2, 559.2));
    // The four vertices of a warped quadrilateral are as far off the best plane in turns.
    assert!((*distance - 0.8).abs() < 0.01, "{distance}");
    assert!(
        read.notes()[1].to_string().contains("a face of `left` has a vertex 8.000e-1 off its plane (size 5.592e2): split into 2")
    );
}

#[test]
fn a_flat_concave_face_stays_one_polygon_and_a_warped_one_keeps_its_outline() {
    let l = |z: f64| format!("v 0 0 0\nv 3 0 0\nv 3 1 0\nv 1 1 {z}\nv 1 3 0\nv 0 3 0\nf 1 2 3 4 5 6\n");
    let flat = scene(&l(0.0)).unwrap();
    assert_eq!((flat.faces().len(), flat.faces()[0].polygon().area()), (1, 5.0));
    let warped = scene(&l(0.1)).unwrap();
    assert_eq!(warped.faces().len(), 4);
    let seen: f64 = warped.polygons().map(|p| p.area() * p.normal().z).sum();
    assert!((seen - 5.0).abs() < 1e-14, "{seen}");
}

#[test]
fn faces_that_are_no_polygon_are_refused_or_left_out_with_a_note_on_request() {
    let text =
        format!("{SQUARE}v 2 0 0\nv 0 0 1\nf 1 2 3 4\ng gone\nf 1 2 5\ng\nf 1 1 2 3\nf 1 3 2 4\nf 1 2\nf 1 1 2\nf 1 6 3 2 4\n");
    for (line, reason) in [
        ("f 1 2 5", "face refused: the polygon has no area: all 3 vertices are on one line"),
        ("f 1 2 3 3", "face refused: vertices 2 and 3 are the same point [1, 1, 0]: leave one out"),
        ("f 1 3 2 4", "face refused: edges 0 and 2 meet: the polygon must be simple"),
        ("f 1 6 3 2 4", "at size 1e0), and seen along its normal the face crosses or touches"),
    ] {
        let message = message(&format!("{SQUARE}v 2 0 0\nv 0 0 1\n{line}\n"));
        assert!(message.contains(reason), "{message}");
    }
    let read = parse(text.as_bytes(), Path::new("a.obj"), Degenerate::Drop, |_| Ok(Vec::new())).unwrap();
    assert_eq!(read.faces().len(), 2, "the square, and the triangle whose first vertex came twice");
    let lines: Vec<String> = read.notes()[1..].iter().map(|note| note.to_string()).collect();
    let expected = [
        "a.obj:9: face left out: the polygon has no area",
        "a.obj:11: vertex 1 of the face repeats its predecessor: left out",
        "a.obj:12: face left out: edges 0 and 2 meet",
        "a.obj:13: face left out: a polygon needs at least 3 vertices, this one has 2",
        "a.obj:14: vertex 1 of the face repeats its predecessor: left out",
        "a.obj:14: face left out: a polygon needs at least 3 vertices, this one has 2",
        "a.obj:15: face left out: vertex ",
    ];
    assert_eq!(lines.len(), expected.len(), "{lines:#?}");
    for (line, expected) in lines.iter().zip(expected) {
        assert!(line.starts_with(expected), "{line}");
    }
    assert!(read.surfaces().iter().all(|surface| !surface.faces().is_empty()));
    let empty = parse(b"v 0 0 0\nf 1 1 1\n", Path::new("a.obj"), Degenerate::Drop, |_| Ok(Vec::new())).unwrap_err();
    assert_eq!(empty.to_string(), "a.obj: expected at least one face, found only the 1 that were left out");
}

#[test]
fn points_and_lines_are_left_out_with_one_note_each() {
    let read = scene(&format!("{SQUARE}mtllib a.mtl\nusemtl grey\np 1\nl 1 2\np 2\ns off\nf 1 2 3\n")).unwrap();
    let notes: Vec<String> = read.notes().iter().map(ToString::to_string).collect();
    assert_eq!(notes.len(), 2);
    assert!(notes[0].starts_with("a.obj:7: `p` is no surface") && notes[1].starts_with("a.obj:8: `l` is no surface"));
}

/// A PNG of 2 x 2 linear greys: 0 and 1 above, 2/3 and 1/3 below.
fn greys() -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, 2, 2);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_gamma(png::ScaledFloat::from_scaled(100_000));
    encoder.write_header().unwrap().write_image_data(&[0, 255, 170, 85]).unwrap();
    file
}

fn textured(text: &str, library: &str) -> Result<Scene, Error> {
    parse(text.as_bytes(), Path::new("a.obj"), Degenerate::Refuse, |name| match name.to_str() {
        Some("a.mtl") => Ok(library.into()),
        Some("greys of the wall.png") => Ok(greys()),
        Some("broken.png") => Ok(greys()[..40].to_vec()),
        Some("photo.jpg") => Ok(vec![0xff, 0xd8]),
        _ => Err(io::Error::new(io::ErrorKind::NotFound, "no such file")),
    })
}

const COORDINATES: &str = "vt 0 0\nvt 1 0 0\nvt 1 1\nvt 0 1\n";

#[test]
fn textures_multiply_reflectance_and_radiance_and_v_is_upwards() {
    let library = "newmtl m\nKd 0.5 1 1\nmap_Kd greys of the wall.png\nmap_Ke -s 1 2 -o 0.5 greys of the wall.png\n";
    let text = format!("mtllib a.mtl\n{SQUARE}{COORDINATES}usemtl m\nf 1/1 2/2 3/-2 4/4\n");
    let read = textured(&text, library).unwrap();
    assert!(read.notes().is_empty() && read.is_textured());
    let at = |quantity, x: f64, y: f64| read.at(0, quantity, DVec3::new(x, y, 0.0));
    let seen = [(0.2, 0.2), (0.8, 0.2), (0.2, 0.8), (0.8, 0.8)].map(|(x, y)| at(Quantity::Reflectance, x, y));
    assert_eq!(seen.each_ref().map(|of| of[1]), [170.0 / 255.0, 85.0 / 255.0, 0.0, 1.0]);
    assert_eq!(seen[3], [0.5, 1.0, 1.0]);
    assert_eq!(at(Quantity::Radiance, 0.2, 0.1)[0], 85.0 / 255.0, "moved by half, twice as high");
    assert!((read.emitted_power(0) - std::f64::consts::PI * 0.5).abs() < 1e-15);
}

#[test]
fn a_face_whose_coordinates_are_not_affine_becomes_triangles_and_one_without_any_has_no_texture() {
    let library = "newmtl m\nKd 0.5 0.5 0.5\nmap_Kd greys of the wall.png\n";
    let skew = format!("mtllib a.mtl\n{SQUARE}vt 0 0\nvt 1 0\nvt 1 1\nvt 0 2\nusemtl m\nf 1/1 2/2 3/3 4/4\nf 1 2 3\n");
    let read = textured(&skew, library).unwrap();
    assert_eq!(read.faces().len(), 3);
    let notes: Vec<String> = read.notes().iter().map(ToString::to_string).collect();
    assert_eq!(
        notes,
        [
            "a.obj:11: a face of `default` has texture coordinates 1.000e0 off an affine function: split into 2 triangles",
            "a.obj:12: faces without `vt` have no texture: `Kd` and `Ke` hold all over them",
        ]
    );
    assert_eq!(read.at(2, Quantity::Reflectance, DVec3::new(0.9, 0.1, 0.0)), [0.5; 3]);
}

#[test]
fn a_texture_that_cannot_be_used_is_noted_and_a_broken_one_is_refused() {
    let with = |map: &str| {
        let text = format!("mtllib a.mtl\n{SQUARE}{COORDINATES}usemtl m\nf 1/1 2/2 3/3\n");
        textured(&text, &format!("newmtl m\nKd 0.5 0.5 0.5\n{map}\n"))
    };
    let note = with("map_Kd photo.jpg").unwrap().notes()[0].to_string();
    assert_eq!(
        note,
        "a.mtl:3: texture `map_Kd` is not used, `photo.jpg` is of no known format and would have to be a PNG: `Kd` holds all over the face"
    );
    assert!(with("map_Kd broken.png").unwrap_err().to_string().starts_with("a.mtl:3: texture `broken.png`: no PNG: "));
    assert_eq!(
        with("map_Kd -s 2").unwrap_err().to_string(),
        "a.mtl:3: expected the name of a texture's file, found the end of the line"
    );
    let unknown = with("map_Kd -x 2 wall.png").unwrap_err().to_string();
    assert_eq!(unknown, "a.mtl:3: expected an option of a texture (-s, -o, -clamp, ...), found `-x`");
    let text = format!("mtllib a.mtl\n{SQUARE}usemtl m\nf 1/1 2/2 3/3\n");
    let missing = textured(&text, "newmtl m\nmap_Kd greys of the wall.png\n").unwrap_err().to_string();
    assert_eq!(missing, "a.obj:7: expected the index of one of the 0 `vt` before this line, found `1/1`");
}

/// A comb of so many vertices, its teeth `warp` off the plane in turn.
fn comb(count: usize, warp: f64) -> String {
    let tooth = |index: usize| {
        let x = 10.0 * (1.0 - index as f64 / (count - 2) as f64);
        let y = if index.is_multiple_of(2) { 1.0 } else { 0.1 };
        format!("v {x:?} {y:?} {:?}\n", warp * libm::sin(index as f64))
    };
    let face: Vec<String> = (1..=count).map(|index| index.to_string()).collect();
    format!("v 0 0 0\nv 10 0 0\n{}f {}\n", (0..count - 2).map(tooth).collect::<String>(), face.join(" "))
}

#[test]
fn combs_and_lines_of_thousands_of_vertices_take_squares_of_their_counts() {
    let before = radgrad_core::effort::spent();
    assert_eq!(scene(&comb(4000, 0.0)).unwrap().faces().len(), 1);
    for warp in [1e-6, 0.3] {
        let warped = scene(&comb(4000, warp)).unwrap();
        assert!(
            warped.notes().iter().any(|note| note.to_string().ends_with("split into 3998 triangles")),
            "{:?}",
            warped.notes()
        );
    }
    let line: String = (0..5000).map(|index| format!("v {index} {index} 0\n")).collect();
    let face: Vec<String> = (1..=5000).map(|index| index.to_string()).collect();
    assert!(message(&format!("{line}f {}\n", face.join(" "))).contains("all 5000 vertices are on one line"));
    // Each ear that is cut off has two neighbours. Cubes would be 1e11.
    let looks = radgrad_core::effort::spent() - before;
    assert!((1..2 * 3 * 4000 * 4000 + 1_000_000).contains(&looks), "{looks} looks at vertices");
}
