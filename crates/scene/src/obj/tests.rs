//! OBJ and MTL as they are written in the world, and every kind of wrong line.

use super::*;
use crate::reading::Degenerate;
use crate::scene::note::Note;
use crate::texture::Quantity;

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
    let before = ["", "o house\n", "g south wall\n", "g roof\n", "o shed\n", "o house\ng roof\n", "g\n"];
    let square_at = |z: usize| format!("{}v 0 0 {z}\nv 1 0 {z}\nv 1 1 {z}\nf -3 -2 -1\n", before[z]);
    let read = scene(&(0..7).map(square_at).collect::<String>()).unwrap();
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
    let material = |face: usize| &read.materials()[read.faces()[face].material()];
    assert_eq!(
        (material(0).name(), material(0).reflectance(), material(0).radiance()),
        ("white", &[0.7, 0.6, 0.5][..], &[0.0; 3][..])
    );
    assert_eq!(
        (material(1).name(), material(1).reflectance(), material(1).radiance()),
        ("the lamp", &[0.0; 3][..], &[16.72; 3][..])
    );
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
    let expected = "a.obj:6: there is no material `gray`: did you mean `grey`? there are `grey`";
    assert_eq!(message(&format!("{SQUARE}mtllib a.mtl\nusemtl gray\nusemtl white\nusemtl gray\nf 1 2 3\n")), expected);
    // None has a face.
    let read = scene(&format!("{SQUARE}mtllib a.mtl\nusemtl gray\nusemtl grey\nf 1 2 3\n")).unwrap();
    assert_eq!(read.notes()[0].to_string(), format!("{expected}: no face has the material"));
    let read = scene(&format!("mtllib\nusemtl\n{SQUARE}f 1 2 3\n")).unwrap();
    let notes: Vec<String> = read.notes().iter().map(ToString::to_string).collect();
    assert_eq!(
        notes[..2],
        ["a.obj:1: `mtllib` without a name is not used", "a.obj:2: `usemtl` without a name: the faces after it have no material"]
    );
}

/// A scene whose one face has the material `m`, read with or without a need for it.
fn with_material(library: &[u8], materials: crate::Materials) -> Result<Scene, Error> {
    let reading = Reading { materials, ..Reading::default() };
    let text = format!("mtllib a.mtl\n{SQUARE}usemtl m\nf 1 2 3\n");
    parse(text.as_bytes(), Path::new("a.obj"), reading, |_| Ok(library.to_vec()))
}

#[test]
fn a_wrong_material_is_refused_where_a_face_needs_it_and_black_where_none_does() {
    let whole = "newmtl m\nKd 0.5 0.5 0.5\n";
    for (library, error) in [
        (
            "newmtl m\nKe 1 1 1\nKd 0.5 1.2 0.5\n",
            "a.mtl:3: material `m`: reflectance is 1.2 in channel `g`: it must be between 0 and 1",
        ),
        (
            "newmtl m\nKd 1 1 1\n\nKe 0 0 -1\nnewmtl n\n",
            "a.mtl:4: material `m`: radiance is -1 in channel `b`: it must be finite and not negative, and so must be its product with pi",
        ),
        ("newmtl m\nKd nan 0 0\nKe x\n", "a.mtl:2: expected a finite number (red), found `nan`"),
        ("newmtl m\nKd 0.5 0.5\n", "a.mtl:2: expected a number (blue), found the end of the line"),
        ("newmtl m\nKd 0,5 0,5 0,5\n", "a.mtl:2: expected three numbers with decimal points, found `0,5 0,5 0,5`, with commas"),
        (
            "newmtl m\nKd spectral a.rfl\n",
            "a.mtl:2: a colour given as `spectral` cannot be represented: give red, green and blue",
        ),
    ] {
        let used = with_material(library.as_bytes(), crate::Materials::Required).unwrap_err().to_string();
        assert_eq!(used, error);
        let black = with_material(library.as_bytes(), crate::Materials::Optional).unwrap();
        assert_eq!(black.notes()[0].to_string(), format!("{error}: taken as black"));
        assert_eq!(black.materials()[black.faces()[0].material()].reflectance(), [0.0; 3]);
        // Of another material, which no face has.
        let other = format!("{}{whole}", library.replace("newmtl m", "newmtl other"));
        let unused = with_material(other.as_bytes(), crate::Materials::Required).unwrap();
        assert_eq!(unused.notes()[0].to_string(), format!("{}: no face has the material", error.replace("`m`", "`other`")));
    }
}

#[test]
fn libraries_are_read_as_they_are_written() {
    let library =
        b"# \xa9 1999\r\nMaterial Count: 2\rnewmtl\rKd 9\rnewmtl m\nKd 0.5, 0.25 ,.125 # red\nmap_Kd -colorspace sRGB none.png\n\
                    map_Ke -new 1 2 off my none.png\nmap_Kd\nTr nan\nd\nKe 1 2 3 4\n";
    let read = with_material(library, crate::Materials::Required).unwrap();
    let material = &read.materials()[read.faces()[0].material()];
    assert_eq!((material.reflectance(), material.radiance()), (&[0.5, 0.25, 0.125][..], &[1.0, 2.0, 3.0][..]));
    let notes: Vec<String> = read.notes().iter().map(ToString::to_string).collect();
    assert_eq!(
        notes,
        [
            "a.mtl:1: the text is no UTF-8 (byte 0xa9): read as Latin-1",
            "a.mtl:3: `newmtl` must name a material: its name is taken as empty",
            "a.mtl:6: numbers of `Kd` are parted by spaces in MTL: commas are taken for these",
            "a.mtl:7: option `-colorspace` of a texture is not used",
            "a.mtl:8: option `-new` of a texture is not used",
            "a.mtl:9: a texture without the name of a file is not used",
            "a.mtl:10: transparency is not used: every face is opaque",
            "a.mtl:12: what follows the three numbers of `Ke` is not used",
            "a.mtl:2: statements before the first `newmtl` are not used",
            "a.mtl:8: texture `map_Ke` is not used, `my none.png` is of no known format and would have to be a PNG: `Ke` holds all over the face",
            "a.mtl:4: material ``: reflectance is 9 in channel `r`: it must be between 0 and 1: no face has the material",
        ]
    );
}

#[test]
fn no_word_of_a_file_that_is_no_library_is_shown() {
    for foreign in ["Kd 1 1 1\n", "root:x:0:0\n", "secret", "\x1b[2J\n", "\u{feff}secret", "s\0ecret"] {
        let error = with_material(foreign.as_bytes(), crate::Materials::Required).unwrap_err().to_string();
        assert!(error.starts_with("a.obj:6: there is no material `m`: a.mtl:1: expected a "), "{error}");
        let notes = with_material(foreign.as_bytes(), crate::Materials::Optional).unwrap();
        let messages = notes.notes().iter().map(ToString::to_string).collect::<String>() + &error;
        assert!(!messages.contains("ecret") && !messages.contains("root") && !messages.contains("Kd"), "{messages}");
    }
}

#[test]
fn wrong_statements_are_named_with_file_line_and_what_was_expected() {
    let with = |line: &str| message(&format!("{SQUARE}\n{line}\n"));
    assert_eq!(with("f 1 2 5"), "a.obj:6: expected the index of a vertex: 1 to 4 or -1 to -4 stand before this line, found `5`");
    for index in ["0", "-5", "99999999999999999", "-9223372036854775808"] {
        assert!(with(&format!("f 1 2 {index}")).contains(&format!("found `{index}`")), "{index}");
    }
    assert!(message("f 1 2 3").contains("no vertices stand before this line"));
    for word in ["a", "/1/2", "1.0", "a/1"] {
        assert!(with(&format!("f 1 2 {word}")).contains(&format!("`v/vt/vn`), found `{word}`")), "{word}");
    }
    assert_eq!(with("v 1 2\nf 1 2 5"), "a.obj:6: expected a number (z), found the end of the line");
    assert_eq!(with("v 1 2 nan\nf 1 2 -1"), "a.obj:6: expected a finite number (z), found `nan`");
    let comma = "a.obj:6: expected a number with a decimal point (y), found a decimal comma, `2,5`";
    assert_eq!(with("v 1 2,5 3\nf 1 2 5"), comma);
    assert_eq!(with("F 1/1 2// 3"), "a.obj:6: expected a statement of OBJ (v, f, o, g, usemtl, mtllib, ...), found `F`");
    assert_eq!(
        with("f 1 2"),
        "a.obj:6: expected at least one face, found none: a polygon needs at least 3 vertices, this one has 2"
    );
    assert_eq!(
        with("#\0"),
        "a.obj:6: expected a text of UTF-8, UTF-16 or Latin-1, found a byte 0: it is binary, or UTF-16 without a byte order mark"
    );
}

#[test]
fn what_says_nothing_of_faces_is_noted() {
    let text = format!(
        "Made by hand\n{SQUARE}v 0 0 nan\nv 0 1,5 0\nv 1. .5 1e-3 0.5\nv 0 0 1 1\nv 0 0 1 0.5 0.5 0.5\nvn nan nan inf\nvp inf\n\
         vt inf 0\nvt a\ncurv 0 1 2\nsurf 1 2 3\ng\no\nl 1 2\nf 1// 2/ 3/1/x 4//\nf 1/1/1/1 2/ 3/2/\n"
    );
    let read = scene(&text).unwrap();
    assert_eq!((read.faces().len(), read.area_of(0)), (2, 1.0));
    let notes: Vec<String> = read.notes().iter().map(ToString::to_string).collect();
    assert_eq!(
        notes[..12],
        [
            "a.obj:1: a line that is no statement of OBJ is not used",
            "a.obj:8: the weight of a vertex, its fourth number, is not used",
            "a.obj:10: the numbers after the coordinates of a vertex, such as its colour, are not used",
            "a.obj:13: expected a finite number (u), found `inf`: the texture coordinate is not used",
            "a.obj:14: expected a number (u), found `a`: the texture coordinate is not used",
            "a.obj:15: free-form curves and surfaces are left out: export them as polygons",
            "a.obj:19: `l` is no surface: points and lines are left out",
            "a.obj:20: expected a vertex of a face (`v`, `v/vt`, `v//vn` or `v/vt/vn`), found `3/1/x`: what follows the vertex is not used",
            "a.obj:20: faces before the first `usemtl` have no material: taken as black",
            "a.obj:21: expected a vertex of a face (`v`, `v/vt`, `v//vn` or `v/vt/vn`), found `1/1/1/1`: what follows the vertex is not used",
            "a.obj:6: expected a finite number (z), found `nan`: of a vertex that no face uses",
            "a.obj:7: expected a number with a decimal point (y), found a decimal comma, `1,5`: of a vertex that no face uses",
        ]
    );
}

#[test]
fn texts_are_read_in_the_encodings_that_programs_write() {
    let text = format!("mtllib a.mtl\n{SQUARE}g Fu\u{df}boden # \u{e9}\nf 1 2 3\n");
    let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
    let utf_16 =
        |unit: fn(u16) -> [u8; 2]| -> Vec<u8> { "\u{feff}".encode_utf16().chain(text.encode_utf16()).flat_map(unit).collect() };
    let encodings = [
        (text.clone().into_bytes(), None),
        (format!("\u{feff}{text}\u{1a}").replace('\n', "\r").into_bytes(), None),
        (latin, Some("a.obj:6: the text is no UTF-8 (byte 0xdf): read as Latin-1")),
        (utf_16(u16::to_le_bytes), Some("a.obj:1: the text is read as UTF-16")),
        (utf_16(u16::to_be_bytes), Some("a.obj:1: the text is read as UTF-16")),
    ];
    for (content, note) in encodings {
        let read = parse(&content, Path::new("a.obj"), Degenerate::Refuse, |_| Ok("newmtl a\n".into())).unwrap();
        assert_eq!(read.surfaces()[0].name(), "Fu\u{df}boden");
        assert_eq!(read.notes().iter().map(ToString::to_string).find(|note| note.contains("text")).as_deref(), note);
    }
}

#[test]
fn the_precision_is_that_of_the_vertices_that_faces_use() {
    let rounding = |text: &str| {
        let reading = Reading::default();
        let intake = Intake::new(Scene::new(["r", "g", "b"]).unwrap(), Path::new("a.obj"), reading, &Budget::new(reading.budget));
        parse_within(text.as_bytes(), intake, &mut |_| Err(io::ErrorKind::NotFound.into())).unwrap().written().rounding()
    };
    let wall = "v 7200 5600 2\nv 7207.41162 5605.10596 2\nv 7207.41162 5605.10596 3.22960377\nv 1e30 0.123456789012 0\nf 1 2 3\n";
    assert_eq!(rounding(wall), 7207.41162 / f64::from(1 << 24));
    assert_eq!(rounding(&format!("{SQUARE}vt 0.123456 0.123456\nf 1 2 3 4\n")), 0.0);
    assert_eq!(
        rounding("v 0.000000 0.000000 1.000000\nv 1.000000 0.000000 0.000000\nv 0.500000 1.000000 2.000000\nf 1 2 3\n"),
        5e-7
    );
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
    let read = scene(&format!("{warped}g left\nf 1 2 3 4\nf 3 2 1\n")).unwrap();
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
    let projected: f64 = warped.polygons().map(|p| p.area() * p.normal().z).sum();
    assert!((projected - 5.0).abs() < 1e-14, "{projected}");
}

#[test]
fn faces_without_area_are_left_out_with_one_note_and_those_that_cross_themselves_are_refused() {
    let without = ["f 1 2 5", "f 1 2", "f 1 1 2", "f 1 2 3 2"];
    let text = format!("{SQUARE}v 2 0 0\nf 1 2 3 4\ng gone\n{}\ng\nf 1 1 3 2\n", without.join("\n"));
    let read = scene(&text.replace("f 1 1 3 2", "v 0 0 1\nv 1 0 1\nv 0 1 1\nf 6 7 7 8")).unwrap();
    assert_eq!(read.faces().len(), 2, "the square, and the triangle whose second vertex came twice");
    let notes: Vec<String> = read.notes()[1..].iter().map(ToString::to_string).collect();
    let expected = [
        "a.obj:10: vertices that repeat their predecessor were left out of 3 faces, this one first",
        "a.obj:8: 4 faces left out, this one first: the polygon has no area: all 3 vertices are on one line",
    ];
    assert_eq!(notes, expected);
    for (line, reason) in [
        ("f 1 3 2 4", "face refused: edges 0 and 2 meet: the polygon must be simple"),
        ("f 1 6 3 2 4", "at size 1e0), and seen along its normal the face crosses or touches"),
    ] {
        let text = format!("{SQUARE}v 2 0 0\nv 0 0 1\nf 1 2 3\n{line}\n");
        let message = message(&text);
        assert!(message.contains(reason), "{message}");
        let read = parse(text.as_bytes(), Path::new("a.obj"), Degenerate::Drop, |_| Ok(Vec::new())).unwrap();
        assert_eq!(read.faces().len(), 1);
        assert!(read.notes()[1].to_string().starts_with("a.obj:8: 1 face left out"), "{}", read.notes()[1]);
    }
    let read = scene(&text.replace("f 1 1 3 2", "")).unwrap();
    assert!(read.surfaces().iter().all(|surface| !surface.faces().is_empty()));
    let empty = parse(b"v 0 0 0\nf 1 1 1\n", Path::new("a.obj"), Degenerate::Drop, |_| Ok(Vec::new())).unwrap_err();
    let none = "a.obj:2: expected at least one face, found none: a polygon needs at least 3 vertices, this one has 1";
    assert_eq!(empty.to_string(), none);
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
    let value = |quantity, x: f64, y: f64| read.value_at(0, quantity, DVec3::new(x, y, 0.0));
    let values = [(0.2, 0.2), (0.8, 0.2), (0.2, 0.8), (0.8, 0.8)].map(|(x, y)| value(Quantity::Reflectance, x, y));
    assert_eq!(values.each_ref().map(|of| of[1]), [170.0 / 255.0, 85.0 / 255.0, 0.0, 1.0]);
    assert_eq!(values[3], [0.5, 1.0, 1.0]);
    assert_eq!(value(Quantity::Radiance, 0.2, 0.1)[0], 85.0 / 255.0, "moved by half, twice as high");
    assert!((read.emitted_power(0) - std::f64::consts::PI * 0.5).abs() < 1e-15);
}

#[test]
fn a_face_whose_coordinates_are_not_affine_becomes_triangles_and_one_without_any_has_no_texture() {
    let library = "newmtl m\nKd 0.5 0.5 0.5\nmap_Kd greys of the wall.png\n";
    let skew = format!("mtllib a.mtl\n{SQUARE}vt 0 0\nvt 1 0\nvt 1 1\nvt 0 2\nusemtl m\nf 1/1 2/2 3/3 4/4\nf 3 2 1\n");
    let read = textured(&skew, library).unwrap();
    assert_eq!(read.faces().len(), 3);
    let notes: Vec<String> = read.notes().iter().map(ToString::to_string).collect();
    assert_eq!(
        notes,
        [
            "a.obj:12: faces without `vt` have no texture: `Kd` and `Ke` hold all over them",
            "a.obj:11: a face of `default` has texture coordinates 1.000e0 off an affine function: split into 2 triangles",
        ]
    );
    assert_eq!(read.value_at(2, Quantity::Reflectance, DVec3::new(0.9, 0.1, 0.0)), [0.5; 3]);
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
    assert_eq!(with("map_Kd -s 2").unwrap().notes()[0].to_string(), "a.mtl:3: a texture without the name of a file is not used");
    assert_eq!(with("map_Kd -s x a.png").unwrap_err().to_string(), "a.mtl:3: expected a number (u), found `x`");
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
