//! Form factors of scenes against closed forms, and against each other.

use radgrad_core::{DVec3, Polygon, Receiver, evaluate_digits};
use radgrad_scene::{Beam, Degenerate, FactorSettings, FormFactors, Occluders, Scene, largest, smallest};

fn scene(faces: &[&[[f64; 3]]]) -> Scene {
    let mut scene = Scene::new(["grey"]).unwrap();
    let material = scene.add_material("white", [0.5], [0.0]).unwrap();
    for (i, face) in faces.iter().enumerate() {
        let surface = scene.add_surface(i.to_string());
        let polygon = Polygon::new(face.iter().map(|&p| p.into()).collect()).unwrap();
        scene.add_face(surface, material, polygon, None).unwrap();
    }
    scene
}

/// A rectangle at height z, lit upwards or downwards.
fn level(x: [f64; 2], y: [f64; 2], z: f64, up: bool) -> [[f64; 3]; 4] {
    let mut corners = [[x[0], y[0], z], [x[1], y[0], z], [x[1], y[1], z], [x[0], y[1], z]];
    if !up {
        corners.reverse();
    }
    corners
}

/// Howell C-11, unit squares at distance 1.
const FACING: f64 = 0.199_824_895_698_387_4;

const UNIT: [f64; 2] = [0.0, 1.0];

/// Two unit squares with a screen half way.
fn behind_a_screen(x: [f64; 2], y: [f64; 2]) -> Scene {
    scene(&[&level(UNIT, UNIT, 0.0, true), &level(UNIT, UNIT, 1.0, false), &level(x, y, 0.5, true)])
}

#[test]
fn free_factors_are_those_of_the_closed_forms() {
    // Howell C-14: a common edge, at a right angle.
    let common_edge = 0.200_043_776_075_403_3;
    let wall = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]];
    let scene = scene(&[&level(UNIT, UNIT, 0.0, true), &level(UNIT, UNIT, 1.0, false), &wall]);
    let factors = FormFactors::new(&scene).unwrap();
    for (from, to, expected) in [(0, 1, FACING), (1, 0, FACING), (0, 2, common_edge), (2, 0, common_edge)] {
        let factor = factors.between(from, to, &FactorSettings::default()).unwrap();
        assert!((factor.value - expected).abs() <= 1e-12 && factor.error <= 1e-12, "{factor:?}");
        assert!((factor.value - expected).abs() <= factor.error + 1e-15 && factor.occluders == 0, "{factor:?}");
    }
}

#[test]
fn what_a_screen_leaves_is_known_to_twelve_digits_and_inside_its_bound() {
    let settings = FactorSettings { estimate: 1e-13, ..FactorSettings::default() };
    // A quarter of the middle, and a half plane as far as the two see it.
    for (scene, share) in [(behind_a_screen([0.0, 0.5], [0.0, 0.5]), 0.75), (behind_a_screen([-1.0, 0.5], [-1.0, 2.0]), 0.5)] {
        let factors = FormFactors::new(&scene).unwrap();
        for (from, to) in [(0, 1), (1, 0)] {
            let factor = factors.between(from, to, &settings).unwrap();
            let expected = share * FACING;
            assert!((factor.value - expected).abs() <= smallest(factor.estimate, 1e-12), "{factor:?} {expected}");
            assert!((factor.value - expected).abs() <= factor.error && factor.occluders == 1, "{factor:?} {expected}");
        }
    }
}

#[test]
fn shadow_edges_that_cross_the_receiver_cost_no_digits() {
    // By translation, the factor left by two halves of a screen: each alone hides its own part, both hide both.
    let lit = |screens: &[[[f64; 3]; 4]]| {
        let mut faces: Vec<&[[f64; 3]]> = Vec::new();
        let ends = [level(UNIT, UNIT, 0.0, true), level(UNIT, UNIT, 1.0, false)];
        faces.extend(ends.iter().chain(screens).map(|face| &face[..]));
        let scene = scene(&faces);
        let settings = FactorSettings { estimate: 1e-10, most_points: 20_000, ..FactorSettings::default() };
        let factor = FormFactors::new(&scene).unwrap().between(0, 1, &settings).unwrap();
        assert!(factor.estimate < 1e-9, "{factor:?}");
        factor.value
    };
    let [left, right] = [[0.125, 0.375], [0.375, 0.5]].map(|x| level(x, [0.25, 0.875], 0.625, true));
    let both = level([0.125, 0.5], [0.25, 0.875], 0.625, true);
    let hidden = [lit(&[left]), lit(&[right]), lit(&[both])].map(|lit| FACING - lit);
    assert!((hidden[0] + hidden[1] - hidden[2]).abs() < 1e-10 && hidden[1] > 1e-3, "{hidden:?}");
}

#[test]
fn narrower_brackets_cost_more_cells_and_stay_true() {
    let scene = behind_a_screen([0.0, 0.5], [0.0, 0.5]);
    let factors = FormFactors::new(&scene).unwrap();
    let mut before = f64::INFINITY;
    for most_cells in [1, 30, 300, 3000] {
        let settings = FactorSettings { tolerance: 0.0, most_cells, ..FactorSettings::default() };
        let factor = factors.between(0, 1, &settings).unwrap();
        assert!((factor.value - 0.75 * FACING).abs() <= factor.error && factor.error < before, "{factor:?}");
        before = factor.error;
    }
}

/// Where digits are known: the factor from the first face to the second.
#[test]
fn factors_are_the_exact_ones_in_their_brackets_both_ways() {
    let wedge = |degrees: f64| {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let up = |y: f64, along: f64| [y, along * cosine, along * sine];
        let floor = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        scene(&[&floor, &[up(0.0, 0.0), up(0.0, 1.0), up(1.0, 1.0), up(1.0, 0.0)]])
    };
    let facing = |gap: f64| scene(&[&level(UNIT, UNIT, 0.0, true), &level(UNIT, UNIT, gap, false)]);
    // Howell C-11 and C-14; C-16, and the centred screen by integrals of closed forms, to the digits given.
    let cases = [
        (facing(1.0), FACING, 1e-13),
        (facing(2.0), 0.068_589_588_818_552_6, 1e-13),
        (facing(0.001), 0.998_005_631_907_58, 1e-11),
        (wedge(90.0), 0.200_043_776_075_403_3, 1e-13),
        (wedge(30.0), 0.619_03, 1e-5),
        (behind_a_screen([0.25, 0.75], [0.25, 0.75]), 0.099_506_294_6, 1e-5),
        (behind_a_screen([0.0, 0.5], [0.0, 0.5]), 0.75 * FACING, 1e-5),
        (behind_a_screen([-1.0, 0.5], [-1.0, 2.0]), 0.5 * FACING, 1e-5),
    ];
    let settings = FactorSettings { most_cells: 400, ..FactorSettings::default() };
    for (index, (scene, expected, off)) in cases.iter().enumerate() {
        let factors = FormFactors::new(scene).unwrap();
        let matrix = factors.matrix(&settings, || ()).unwrap();
        for (from, to) in [(0, 1), (1, 0)] {
            let entry = matrix.row(from).find(|entry| entry.face == to).unwrap();
            let relative = (entry.factor - expected).abs() / expected;
            assert!(relative <= *off * 10.0, "{index}: {entry:?} {expected}");
            assert!(entry.lower <= expected + off * expected && entry.upper >= expected - off * expected, "{index}: {entry:?}");
            assert!(entry.lower <= entry.factor && entry.factor <= entry.upper, "{index}: {entry:?}");
        }
        assert!(matrix.worst_reciprocity() <= 1e-15);
    }
}

fn two_blocks() -> Scene {
    Scene::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj"), Degenerate::Refuse).unwrap()
}

const ROUGH: FactorSettings = FactorSettings {
    tolerance: 1e-2,
    relative: 0.0,
    most_cells: 1000,
    estimate: 3e-5,
    relative_estimate: 0.0,
    most_points: 1000,
};

#[test]
fn every_bracket_meets_that_of_a_finer_matrix_and_rows_close_within_theirs() {
    let scene = two_blocks();
    let factors = FormFactors::new(&scene).unwrap();
    let rough = factors.matrix(&ROUGH, || ()).unwrap();
    let fine = factors.matrix(&FactorSettings { tolerance: 4e-3, ..ROUGH }, || ()).unwrap();
    for (from, entry) in rough.entries() {
        let other = fine.row(from).find(|other| other.face == entry.face);
        let [lower, upper] = other.map_or([0.0; 2], |other| [other.lower, other.upper]);
        assert!(entry.lower <= upper && lower <= entry.upper, "{from}: {entry:?} {other:?}");
    }
    for matrix in [&rough, &fine] {
        assert_eq!(matrix.unclosed().count(), 0);
        assert!(matrix.worst_closure() < 1e-3, "{}", matrix.worst_closure());
    }
}

#[test]
fn blocks_of_rows_are_those_of_the_whole_to_the_last_digit() {
    let scene = two_blocks();
    let factors = FormFactors::new(&scene).unwrap();
    let whole = factors.matrix(&ROUGH, || ()).unwrap();
    let count = factors.faces().len();
    for block in [0..5, 5..count] {
        let part = factors.rows(block.clone(), &ROUGH, || ()).unwrap();
        assert_eq!(part.faces(), &whole.faces()[block]);
        for &face in part.faces() {
            assert!(part.row(face).eq(whole.row(face)), "{face}");
        }
    }
    assert!(factors.rows(0..count + 1, &ROUGH, || ()).is_err());
}

#[test]
fn a_repair_closes_rows_inside_the_brackets_and_keeps_factors_reciprocal() {
    let scene = two_blocks();
    let mut matrix = FormFactors::new(&scene).unwrap().matrix(&ROUGH, || ()).unwrap();
    let before = matrix.clone();
    let repaired = matrix.repair(&ROUGH).unwrap();
    assert!(matrix.worst_closure() <= 1e-13 && matrix.worst_reciprocity() <= 1e-15, "{repaired:?}");
    // Bounds that were met are met still, though factors are not in the middle of their brackets any more.
    assert_eq!(matrix.unmet(&ROUGH).count(), before.unmet(&ROUGH).count());
    let mut largest_change = 0.0;
    for (from, entry) in matrix.entries() {
        let was = before.factor(from, entry.face);
        assert!(entry.lower <= entry.factor && entry.factor <= entry.upper, "{from}: {entry:?}");
        largest_change = largest(largest_change, (entry.factor - was).abs());
    }
    assert!((largest_change - repaired.largest).abs() <= 1e-15 && largest_change < 1e-3 && largest_change > 0.0, "{repaired:?}");
    // An open scene is none that can be repaired, and stays as it is.
    let scene = behind_a_screen([0.0, 0.5], [0.0, 0.5]);
    let mut matrix = FormFactors::new(&scene).unwrap().matrix(&ROUGH, || ()).unwrap();
    let before = matrix.clone();
    assert!(matrix.repair(&ROUGH).unwrap_err().to_string().contains("closed"));
    assert_eq!(matrix, before);
}

#[test]
fn factors_do_not_depend_on_the_unit_of_length() {
    let square = |power: f64, z: f64, up: bool| level([0.0, power], [0.0, power], z, up);
    for power in [1.0, libm::ldexp(1.0, 300), libm::ldexp(1.0, -300)] {
        let scene = scene(&[
            &square(power, 0.0, true),
            &square(power, power, false),
            &level([0.25 * power, 0.75 * power], [0.25 * power, 0.75 * power], 0.5 * power, true),
        ]);
        let matrix = FormFactors::new(&scene).unwrap().matrix(&ROUGH, || ()).unwrap();
        assert!((matrix.factor(0, 1) - 0.099_506_294_6).abs() < 1e-5, "{power:e}: {}", matrix.factor(0, 1));
    }
}

#[test]
fn a_matrix_does_not_depend_on_how_many_threads_there_are() {
    let scene = behind_a_screen([0.25, 0.5], [0.0, 0.75]);
    let factors = FormFactors::new(&scene).unwrap();
    let matrix = || factors.matrix(&FactorSettings::default(), || ()).unwrap();
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(matrix);
    assert_eq!(one, matrix());
}

#[test]
fn a_surface_that_only_hides_has_no_row() {
    let mut scene = scene(&[&level(UNIT, UNIT, 0.0, true), &level(UNIT, UNIT, 1.0, false)]);
    let screen = scene.add_obstruction("screen");
    let corners = level([-1.0, 2.0], [-1.0, 2.0], 0.5, true).map(DVec3::from);
    scene.add_face(screen, 0, Polygon::new(corners.to_vec()).unwrap(), None).unwrap();
    let matrix = FormFactors::new(&scene).unwrap().matrix(&FactorSettings::default(), || ()).unwrap();
    assert_eq!((matrix.faces(), matrix.row(2).count(), matrix.factor(0, 1)), (&[0, 1][..], 0, 0.0));
    assert_eq!(matrix.worst_closure(), 1.0);
    // All of it is proven hidden, since the screen is one convex polygon.
    assert_eq!(matrix.worst_bound(), 0.0);
    assert!(matrix.by_surface(&scene).rows.iter().flatten().all(|found| found.upper == 0.0));
}

#[test]
fn points_of_the_cornell_box_see_as_much_of_the_light_as_every_polygon_together_leaves() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/cornell.obj");
    let scene = Scene::read(file, Degenerate::Refuse).unwrap();
    let factors = FormFactors::new(&scene).unwrap();
    let light = scene.surfaces()[scene.surface_named("light").unwrap()].faces()[0];
    let emitter =
        radgrad_core::Emitter::new(scene.faces()[light].polygon().clone(), radgrad_core::Emission::Constant(1.0)).unwrap();
    let (mut lit, mut partly) = (0, 0);
    // Points above the floor, so that nothing is in their plane: all other polygons may be given as occluders.
    for (x, z) in (0..12).flat_map(|i| (0..5).map(move |k| (40.0 + 41.0 * f64::from(i), 33.0 + 101.0 * f64::from(k)))) {
        let receiver = Receiver::new(DVec3::new(x, 1.0, z), DVec3::Y, 1.0).unwrap();
        let answer = factors.at_point(&receiver, None, light, 1e-13).unwrap();
        let others = scene.polygons().enumerate().filter(|(face, _)| *face != light).map(|(_, polygon)| polygon);
        let Ok(truth) = evaluate_digits(&receiver, &emitter, others, 20) else { continue };
        let truth: f64 = truth.radiosity.parse().unwrap();
        assert!((answer.radiosity - truth).abs() <= answer.radiosity_error + 1e-16 && answer.radiosity_error <= 1e-12, "{x} {z}");
        let free = radgrad_core::radiosity(&receiver, &emitter).unwrap();
        lit += usize::from(truth == free || (truth - free).abs() < 1e-12);
        partly += usize::from(truth > 1e-6 && truth < free - 1e-6);
    }
    assert!(lit > 10 && partly > 2, "{lit} {partly}");
}

/// A lattice of small triangles in the unit cube, and two small squares at its ends.
fn a_cloud(per_side: u32) -> (Vec<Polygon>, [Polygon; 2]) {
    let mut triangles = Vec::new();
    let step = 1.0 / f64::from(per_side);
    for (i, j, k) in (0..per_side).flat_map(|i| (0..per_side).flat_map(move |j| (0..per_side).map(move |k| (i, j, k)))) {
        let corner = DVec3::new(f64::from(i), f64::from(j), f64::from(k)) * step;
        let size = 0.4 * step;
        let corners = [DVec3::ZERO, DVec3::new(size, 0.1 * size, 0.3 * size), DVec3::new(0.2 * size, size, 0.5 * size)];
        triangles.push(Polygon::new(corners.iter().map(|&c| corner + c + DVec3::splat(0.3 * step)).collect()).unwrap());
    }
    let square =
        |z: f64, up: bool| Polygon::new(level([0.40, 0.45], [0.52, 0.57], z, up).iter().map(|&p| p.into()).collect()).unwrap();
    (triangles, [square(-0.1, true), square(1.1, false)])
}

#[test]
fn one_factor_in_ten_thousand_triangles_costs_what_is_in_its_beam() {
    let (triangles, [from, to]) = a_cloud(22);
    assert!(triangles.len() > 10_000);
    let index = Occluders::new(&triangles);
    let search = index.in_beam(&Beam::from_polygon(&from, &to).unwrap(), &[]);
    let (near, all) = (search.polygons.len(), triangles.len());
    assert!((20..200).contains(&near), "{near}");
    assert!(search.polygons_tested < 20 * near && search.boxes_tested < 40 * near, "{search:?} of {all}");
    // An eighth of the triangles: a tenth of the cost or more, since the beam is as long in steps by a half.
    let (fewer, _) = a_cloud(11);
    let coarse = Occluders::new(&fewer).in_beam(&Beam::from_polygon(&from, &to).unwrap(), &[]);
    assert!(search.polygons_tested <= 12 * coarse.polygons_tested, "{search:?} {coarse:?}");
}
