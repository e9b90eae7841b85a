//! Each test holds the pieces against areas, or against points: exactly one face is at each, and it is the right one.

use radgrad_core::{DVec3, Polygon};

use super::*;
use crate::occluders::segment::contains;
use crate::place::Position;
use crate::scene::prepared::Prepared;
use crate::texture::Texture;

/// A scene of faces in a plane: name, radiance and outline.
fn scene(faces: &[(&str, f64, Vec<[f64; 2]>)], place: impl Fn([f64; 2]) -> DVec3) -> Scene {
    let mut scene = Scene::new(["grey"]).unwrap();
    for (line, (name, radiance, outline)) in faces.iter().enumerate() {
        let material = scene.materials.iter().position(|material| material.radiance() == [*radiance]);
        let material = material.unwrap_or_else(|| scene.add_material(format!("of {radiance}"), [0.5], [*radiance]).unwrap());
        let surface = scene.surfaces_named(name).next().unwrap_or(scene.surfaces.len());
        if surface == scene.surfaces.len() {
            scene.add_surface(*name);
        }
        let polygon = Polygon::new(outline.iter().map(|&at| place(at)).collect()).unwrap();
        scene.add_face(surface, material, polygon, Some(Place::new("a.obj", Position::Line(line + 1)))).unwrap();
    }
    scene
}

fn flat([x, y]: [f64; 2]) -> DVec3 {
    DVec3::new(x, y, 0.0)
}

/// A plane in which coordinates round.
fn slanted([x, y]: [f64; 2]) -> DVec3 {
    DVec3::new(0.6 * x + 0.3, y / 3.0 - 1.1, 0.8 * x + 0.1 * y)
}

fn board(x: [f64; 2], y: [f64; 2]) -> Vec<[f64; 2]> {
    vec![[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]]
}

fn square(low: f64, high: f64) -> Vec<[f64; 2]> {
    board([low, high], [low, high])
}

fn is_at(face: &Face, point: DVec3) -> bool {
    contains(face.polygon.vertices(), face.polygon.normal(), point)
}

fn notes(scene: &Scene) -> Vec<String> {
    scene.notes().iter().map(ToString::to_string).collect()
}

/// Areas of surfaces after overlaps were resolved; every point of the plane is then of one face at most.
fn areas(faces: &[(&str, f64, Vec<[f64; 2]>)]) -> Vec<f64> {
    let mut of_slanted = scene(faces, slanted);
    resolve(&mut of_slanted, 0.0, Overlaps::Nested).unwrap();
    Prepared::new(&of_slanted).unwrap();
    let mut scene = scene(faces, flat);
    resolve(&mut scene, 0.0, Overlaps::Nested).unwrap();
    Prepared::new(&scene).unwrap();
    // A unit of the plane is `unit` in space.
    let unit = (slanted([1.0, 0.0]) - slanted([0.0, 0.0])).cross(slanted([0.0, 1.0]) - slanted([0.0, 0.0])).length();
    let areas: Vec<f64> = (0..scene.surfaces.len()).map(|surface| scene.area_of(surface)).collect();
    for (surface, area) in areas.iter().enumerate() {
        assert!((of_slanted.area_of(surface) - unit * area).abs() < 1e-12, "{surface}");
    }
    areas
}

#[test]
fn a_wall_is_cut_around_its_window_whose_corners_it_takes_bit_for_bit() {
    let window = board([1.1, 3.3], [1.0 / 3.0, 2.2]);
    let mut scene = scene(&[("wall", 0.0, board([0.0, 4.0], [0.0, 3.0])), ("window", 0.0, window.clone())], slanted);
    resolve(&mut scene, 0.0, Overlaps::default()).unwrap();
    assert_eq!(notes(&scene), ["a.obj:1: a face of `wall` is cut into 4 pieces around a face of `window` (a.obj:2)"]);
    assert_eq!((scene.surfaces[0].faces(), scene.surfaces[1].faces()), (&[0, 1, 2, 3][..], &[4][..]));
    for corner in window {
        let has_corner = |face: usize| scene.faces[face].polygon.vertices().contains(&slanted(corner));
        assert!((0..4).any(has_corner), "{corner:?}");
    }
    let place = scene.faces[3].place().cloned();
    assert_eq!(place, Some(Place::new("a.obj", Position::Line(1))));
    Prepared::new(&scene).unwrap();
}

#[test]
fn what_lies_in_what_is_seen() {
    // Beside each other, touching the border, and three deep.
    let wall = || ("wall", 0.0, square(0.0, 10.0));
    let window = || ("window", 0.0, square(1.0, 3.0));
    assert_eq!(areas(&[wall(), window(), ("door", 0.0, board([5.0, 6.0], [0.0, 2.0]))]), [94.0, 4.0, 2.0]);
    assert_eq!(areas(&[("pane", 0.0, square(1.5, 2.0)), wall(), window()]), [0.25, 96.0, 3.75]);
    assert_eq!(areas(&[wall(), ("corner", 0.0, square(8.0, 10.0)), ("other", 0.0, square(0.0, 2.0))]), [92.0, 4.0, 4.0]);
    // A room of the shape of an L with a rug of this shape around its corner, and a star on it.
    let l = |s: f64| vec![[0.0, 0.0], [3.0, 0.0], [3.0, s], [s, s], [s, 3.0], [0.0, 3.0]];
    let star = vec![[0.2, 0.2], [0.5, 0.3], [0.8, 0.2], [0.7, 0.5], [0.8, 0.8], [0.5, 0.7], [0.2, 0.8], [0.3, 0.5]];
    let remaining = areas(&[("rug", 0.0, l(1.0)), ("star", 0.0, star), ("floor", 0.0, l(2.0))]);
    assert!(remaining.iter().zip([4.76, 0.24, 3.0]).all(|(a, b)| (a - b).abs() < 1e-12), "{remaining:?}");
}

#[test]
fn a_lamp_across_the_triangles_of_its_ceiling_is_on_it() {
    let mut faces = vec![
        ("ceiling", 0.0, vec![[0.0, 0.0], [4.0, 0.0], [4.0, 4.0]]),
        ("ceiling", 0.0, vec![[0.0, 0.0], [4.0, 4.0], [0.0, 4.0]]),
        ("lamp", 1.0, vec![[1.0, 1.5], [2.5, 1.5], [2.5, 2.5]]),
        ("lamp", 1.0, vec![[1.0, 1.5], [2.5, 2.5], [1.0, 2.5]]),
    ];
    assert_eq!(areas(&faces), [14.5, 1.5]);
    // And on a ceiling of triangles smaller than its own.
    faces.drain(..2);
    for (i, j) in (0..8).flat_map(|i| (0..8).map(move |j| (0.5 * f64::from(i), 0.5 * f64::from(j)))) {
        faces.push(("ceiling", 0.0, vec![[i, j], [i + 0.5, j], [i + 0.5, j + 0.5]]));
        faces.push(("ceiling", 0.0, vec![[i, j], [i + 0.5, j + 0.5], [i, j + 0.5]]));
    }
    let remaining = areas(&faces);
    assert!((remaining[0] - 1.5).abs() + (remaining[1] - 14.5).abs() < 1e-12, "{remaining:?}");
}

#[test]
fn of_a_face_that_is_there_twice_one_is_left() {
    let mut turned = square(0.0, 1.0);
    turned.rotate_left(3);
    let mut twice = scene(&[("a", 0.0, square(0.0, 1.0)), ("b", 0.0, turned.clone()), ("c", 0.0, square(0.0, 1.0))], slanted);
    resolve(&mut twice, 0.0, Overlaps::default()).unwrap();
    assert_eq!(twice.faces[0].place(), Some(&Place::new("a.obj", Position::Line(1))));
    assert_eq!((twice.faces.len(), twice.surfaces.len()), (1, 3));
    assert_eq!(notes(&twice)[0], "a.obj:2: a face of `b` is left out: it is the same as a face of `a` (a.obj:1)");
    // The one that emits light, wherever it is.
    for (radiances, line) in [([0.0, 2.0], 2), ([2.0, 0.0], 1), ([2.0, 3.0], 1)] {
        let faces = [("a", radiances[0], square(0.0, 1.0)), ("b", radiances[1], turned.clone())];
        let mut twice = scene(&faces, slanted);
        resolve(&mut twice, 0.0, Overlaps::default()).unwrap();
        assert_eq!(twice.faces[0].place(), Some(&Place::new("a.obj", Position::Line(line))));
        let note = &notes(&twice)[0];
        assert!(note.contains("its material `of ") && note.contains("which emits light") == (line == 2), "{note}");
    }
    // Cut into triangles in another way, and with a vertex more.
    let halves = [vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], vec![[0.0, 0.0], [1.0, 1.0], [0.0, 1.0]]];
    let others = [vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], vec![[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]];
    let [a, b] = halves;
    let [c, d] = others;
    assert_eq!(areas(&[("a", 0.0, a.clone()), ("a", 0.0, b.clone()), ("b", 0.0, c.clone()), ("b", 0.0, d.clone())]), [1.0, 0.0]);
    assert_eq!(areas(&[("a", 0.0, a.clone()), ("a", 0.0, b.clone()), ("b", 3.0, c), ("b", 3.0, d)]), [0.0, 1.0]);
    assert_eq!(areas(&[("whole", 3.0, square(0.0, 1.0)), ("halves", 0.0, a), ("halves", 0.0, b)]), [1.0, 0.0]);
    let more = vec![[0.0, 0.0], [0.3, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    assert_eq!(areas(&[("a", 0.0, more), ("b", 0.0, square(0.0, 1.0))]), [1.0, 0.0]);
}

#[test]
fn other_overlaps_are_refused_all_at_once_unless_they_are_to_be_cut() {
    let faces =
        [("a", 0.0, square(0.0, 2.0)), ("b", 0.0, board([1.0, 3.0], [0.5, 1.0])), ("c", 0.0, board([-1.0, 1.0], [1.5, 1.75]))];
    let mut given = scene(&faces, flat);
    let error = resolve(&mut given, 0.0, Overlaps::default()).unwrap_err().to_string();
    let first = "face 0 of `a` (a.obj:1) and face 1 of `b` (a.obj:2) overlap in one plane around (1.5, 0.75, 0.0), on 50.000 % of the smaller";
    let second = "; face 0 of `a` (a.obj:1) and face 2 of `c` (a.obj:3) overlap";
    assert!(error.starts_with(first) && error.contains(second) && error.contains("--overlaps cut"), "{error}");
    assert_eq!(given, scene(&faces, flat), "a refused scene stays as it is");
    resolve(&mut given, 0.0, Overlaps::Cut).unwrap();
    assert_eq!([0, 1, 2].map(|surface| given.area_of(surface)), [3.25, 1.0, 0.5]);
    Prepared::new(&given).unwrap();
    // Two that overlap are not nested because both lie on a third.
    let posters = [("wall", 0.0, square(-5.0, 5.0)), ("a", 0.0, square(0.0, 2.0)), ("b", 0.0, square(1.0, 2.5))];
    let error = resolve(&mut scene(&posters, flat), 0.0, Overlaps::default()).unwrap_err();
    assert!(matches!(&error, Error::Overlap { pairs, more: 0 } if pairs.len() == 1), "{error}");
    let many: Vec<_> = (0..23).map(|i| ("a", 0.0, board([f64::from(i), f64::from(i) + 1.5], [0.0, 1.0]))).collect();
    let error = resolve(&mut scene(&many, flat), 0.0, Overlaps::default()).unwrap_err();
    assert!(matches!(&error, Error::Overlap { pairs, more: 2 } if pairs.len() == 20), "{error}");
    assert!(error.to_string().contains("and 2 pairs more"));
    for faces in [
        [("a", 0.0, square(0.0, 2.0)), ("b", 0.0, square(0.0, 2.0))],
        [("a", 0.0, square(0.0, 2.0)), ("b", 0.0, square(0.5, 1.0))],
    ] {
        assert!(resolve(&mut scene(&faces, flat), 0.0, Overlaps::Refuse).is_err());
    }
    assert!(resolve(&mut scene(&faces, flat), f64::NAN, Overlaps::Cut).unwrap_err().to_string().contains("rounding"));
}

#[test]
fn faces_back_to_back_before_each_other_or_beside_each_other_stay() {
    let mut reversed = square(0.5, 1.0);
    reversed.reverse();
    let beside = board([2.0, 3.0], [0.3, 0.7]);
    let mut given = scene(&[("a", 0.0, square(0.0, 2.0)), ("b", 0.0, reversed), ("c", 0.0, beside)], slanted);
    let above = Polygon::new(square(0.5, 1.0).into_iter().map(|at| flat(at) + DVec3::Z * 1e-6).collect()).unwrap();
    given.add_face(0, 0, Polygon::new(square(0.0, 2.0).into_iter().map(flat).collect()).unwrap(), None).unwrap();
    given.add_face(0, 0, above, None).unwrap();
    let only_hides = given.add_obstruction("screen");
    given.add_face(only_hides, 0, given.faces[3].polygon.clone(), None).unwrap();
    let before = given.clone();
    resolve(&mut given, 1e-8, Overlaps::default()).unwrap();
    assert_eq!(given, before);
}

fn rounded(at: DVec3, q: f64) -> DVec3 {
    (at / (2.0 * q)).round() * (2.0 * q)
}

/// Numbers in [0, 1) that look random.
fn draws(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(2_654_435_769).wrapping_add(97);
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    }
}

#[test]
fn what_rounding_explains_is_no_overlap_and_what_it_moved_is_one_plane() {
    for (seed, q) in (0..200).zip([5e-4, 5e-7, 3e-8].into_iter().cycle()) {
        let mut uniform = draws(seed);
        let axis = DVec3::new(uniform() - 0.5, uniform() - 0.5, uniform() - 0.5).normalize();
        let (along, across) = axis.any_orthonormal_pair();
        let (turn, far) = (6.3 * uniform(), DVec3::new(uniform(), uniform(), uniform()) * 20.0);
        let place = |[x, y]: [f64; 2]| {
            let (s, c) = (libm::sin(turn), libm::cos(turn));
            rounded(far + along * (c * x - s * y) + across * (s * x + c * y), q)
        };
        // A wall of triangles, since these stay flat: a joint with a vertex on it, a needle along the border, and a window across them.
        let joint = 1.0 + uniform();
        let faces = [
            ("wall", 0.0, vec![[0.0, 0.0], [4.0, 0.0], [4.0, joint]]),
            ("wall", 0.0, vec![[0.0, 0.0], [4.0, joint], [0.0, joint]]),
            ("wall", 0.0, vec![[0.0, joint], [2.2, joint], [0.0, 3.0]]),
            ("wall", 0.0, vec![[2.2, joint], [4.0, joint], [0.0, 3.0]]),
            ("needle", 0.0, vec![[0.0, 0.0], [0.01, -0.01], [4.0, 0.0]]),
            ("window", 0.0, vec![[0.5, 0.4], [2.0, 0.5], [1.7, joint + 0.2]]),
        ];
        let mut given = scene(&faces, place);
        let areas: Vec<f64> = (0..3).map(|surface| given.area_of(surface)).collect();
        resolve(&mut given, q, Overlaps::default()).unwrap_or_else(|error| panic!("{seed}: {error}"));
        let changes: Vec<f64> = (0..3).map(|surface| given.area_of(surface) - areas[surface]).collect();
        assert_eq!(changes[1..], [0.0, 0.0], "{seed}");
        assert!((changes[0] + areas[2]).abs() < 40.0 * q, "{seed}: {changes:?}");
        assert!(given.notes().iter().filter(|note| matches!(note, Note::SmallOverlaps { .. })).count() <= 1);
        assert_eq!(pairs(&given, &Occluders::new(given.polygons()), q).len(), 0, "{seed}");
    }
}

#[test]
fn at_every_point_the_smallest_face_is_left() {
    for seed in 0..60 {
        let mut uniform = draws(1000 + seed);
        // Triangles and notched quadrilaterals at random, of different sizes.
        let outlines: Vec<Vec<[f64; 2]>> = (0..8)
            .map(|k| {
                let (x, y, size, start) = (4.0 * uniform(), 4.0 * uniform(), 0.6 + 0.5 * f64::from(k), 6.3 * uniform());
                let vertex =
                    |share: f64, r: f64| [x + size * r * libm::cos(start + share), y + size * r * libm::sin(start + share)];
                if k % 2 == 0 {
                    vec![vertex(0.0, 1.0), vertex(2.0, 1.0), vertex(4.0, 1.0)]
                } else {
                    vec![vertex(0.0, 1.0), vertex(2.0, 0.2), vertex(4.0, 1.0), vertex(5.0, 1.0)]
                }
            })
            .collect();
        let names: Vec<String> = (0..8).map(|k| format!("s{k}")).collect();
        let faces: Vec<_> = names.iter().zip(&outlines).map(|(name, outline)| (&name[..], 0.0, outline.clone())).collect();
        let given = scene(&faces, slanted);
        let mut cut = given.clone();
        resolve(&mut cut, 0.0, Overlaps::Cut).unwrap();
        assert!(Prepared::new(&cut).is_ok(), "{seed}");
        for _ in 0..400 {
            let point = slanted([10.0 * uniform() - 3.0, 10.0 * uniform() - 3.0]);
            let surfaces_at = |scene: &Scene| -> Vec<usize> {
                let faces = scene.faces.iter().filter(|face| is_at(face, point));
                faces.map(|face| face.surface).collect()
            };
            let area = |surface: &usize| given.area_of(*surface);
            let smallest = surfaces_at(&given).into_iter().min_by(|a, b| area(a).total_cmp(&area(b)));
            assert_eq!(surfaces_at(&cut), smallest.into_iter().collect::<Vec<_>>(), "{seed} {point:?}");
        }
    }
}

#[test]
fn pieces_are_few_and_wide() {
    // A round lamp of 32 sides on a ceiling: as many pieces, most of them wide.
    let disc: Vec<[f64; 2]> = (0..32)
        .map(|k| 2.0 * std::f64::consts::PI * f64::from(k) / 32.0)
        .map(|angle| [2.0 + 0.5 * libm::cos(angle), 1.5 + 0.5 * libm::sin(angle)])
        .collect();
    let mut ceiling = scene(&[("ceiling", 0.0, board([0.0, 4.0], [0.0, 3.0])), ("lamp", 1.0, disc)], flat);
    resolve(&mut ceiling, 0.0, Overlaps::default()).unwrap();
    let pieces: Vec<&Polygon> = ceiling.surfaces[0].faces().iter().map(|&face| ceiling.faces[face].polygon()).collect();
    assert!(pieces.len() <= 32, "{}", pieces.len());
    let longest = |piece: &Polygon| {
        let corners = piece.vertices();
        corners.iter().flat_map(|a| corners.iter().map(move |b| (*a - *b).length())).fold(0.0, largest)
    };
    let needles: f64 = pieces.iter().filter(|piece| piece.area() < 0.05 * longest(piece).powi(2)).map(|piece| piece.area()).sum();
    assert!(needles < 0.02 * ceiling.area_of(0), "{needles}");
    assert!(pieces.iter().map(|piece| longest(piece)).filter(|&length| length > 1.0).count() <= 8);
}

#[test]
fn many_tiles_and_many_rugs_on_one_floor() {
    let offset = |i: u32| f64::from(i) * 1.25;
    let mut faces: Vec<_> = (0..14_400)
        .map(|k| ("rugs", 0.0, board([offset(k % 120), offset(k % 120) + 1.0], [offset(k / 120), offset(k / 120) + 1.0])))
        .collect();
    let tiles = (0..3_600).map(|k| (2.5 * f64::from(k % 60), 2.5 * f64::from(k / 60)));
    let tile = |(x, y): (f64, f64)| ("tiles", 0.0, board([x, x + 2.5], [y + 200.0, y + 202.5]));
    faces.extend(tiles.map(tile));
    faces.push(("floor", 0.0, square(-1.0, 151.0)));
    faces.push(("carpet", 0.0, board([0.0, 150.0], [200.0, 350.0])));
    let mut given = scene(&faces, flat);
    resolve(&mut given, 0.0, Overlaps::default()).unwrap();
    let areas: Vec<f64> = (0..4).map(|surface| given.area_of(surface)).collect();
    assert!((areas[2] - (152.0 * 152.0 - 14_400.0)).abs() < 1e-7, "{areas:?}");
    assert_eq!((areas[0], areas[1] + areas[3]), (14_400.0, 22_500.0));
    assert!(given.surfaces[2].faces().len() < 4 * 14_400, "{}", given.surfaces[2].faces().len());
}

#[test]
fn a_texture_stays_where_it_was() {
    let mut given = scene(&[("wall", 0.0, square(0.0, 4.0)), ("window", 0.0, square(1.0, 2.0))], slanted);
    let texture = Texture::from_fn("t", [4, 4], 1, |column, row| vec![0.1 + 0.05 * (column + 4 * row) as f64]).unwrap();
    let tiles = given.add_material("tiles", [1.0], [0.0]).unwrap();
    given.set_texture(tiles, Quantity::Reflectance, texture).unwrap();
    let polygon = given.faces[0].polygon.clone();
    let charted = given.add_textured_face(0, tiles, polygon, &square(0.0, 1.0), None).unwrap();
    let point = |k: usize| slanted([0.5 + (k % 4) as f64, 0.5 + (k / 4) as f64]);
    let values: Vec<Vec<f64>> = (0..16).map(|k| given.value_at(charted, Quantity::Reflectance, point(k))).collect();
    let plain = given.faces.remove(0);
    given.surfaces[0].faces = vec![1];
    given.surfaces[1].faces = vec![0];
    assert_eq!(plain.surface, 0);
    resolve(&mut given, 0.0, Overlaps::default()).unwrap();
    for (k, value) in values.into_iter().enumerate() {
        let piece = given.surfaces[0].faces().iter().find(|&&face| is_at(&given.faces[face], point(k)));
        assert_eq!(piece.map(|&face| given.value_at(face, Quantity::Reflectance, point(k))), (k != 5).then_some(value), "{k}");
    }
}

#[test]
fn any_unit_and_any_place_give_the_same_pieces() {
    let faces =
        [("wall", 0.0, board([0.0, 4.0], [0.0, 3.0])), ("window", 0.0, square(1.0, 2.5)), ("pane", 0.0, square(1.0, 1.5))];
    let pieces = |by: &dyn Fn(f64) -> f64| {
        let mut given = scene(&faces, |at| flat(at).to_array().map(by).into());
        resolve(&mut given, 0.0, Overlaps::default()).unwrap();
        Prepared::new(&given).unwrap();
        given.polygons().map(|polygon| polygon.vertices().len()).collect::<Vec<_>>()
    };
    let expected = pieces(&|x| x);
    assert_eq!(expected.len(), 4 + 2 + 1);
    let scales: [&dyn Fn(f64) -> f64; 3] = [&|x| x * 2f64.powi(600), &|x| x * 1e-200, &|x| x + 1e9];
    for by in scales {
        assert_eq!(pieces(by), expected);
    }
    // Far away, where corners are rounded.
    let lozenge = vec![[1.0, 1.1], [2.0, 0.3], [3.1, 1.2], [2.2, 2.3]];
    let faces = [("wall", 0.0, board([0.0, 4.0], [0.0, 3.0])), ("window", 0.0, lozenge)];
    let mut given = scene(&faces, |[x, y]| DVec3::new(1e6 + x, -3e6 + y, 2.0));
    resolve(&mut given, 0.0, Overlaps::default()).unwrap();
    Prepared::new(&given).unwrap();
}
