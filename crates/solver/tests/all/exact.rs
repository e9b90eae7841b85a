//! Exact solutions: inside twice the stated estimate, and as near as the default effort promises.

use std::f64::consts::PI;

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::Scene;
use radgrad_solver::{Options, Solution, solve};

type Quad = [[f64; 3]; 4];

/// A scene of one channel: each face with its reflectance and the radiosity that it emits.
fn scene(faces: &[(Quad, f64, f64)]) -> Scene {
    let mut scene = Scene::new(["grey"]).unwrap();
    for (index, (corners, reflectance, emitted)) in faces.iter().enumerate() {
        let material = scene.add_material(index.to_string(), [*reflectance], [emitted / PI]).unwrap();
        let surface = scene.add_surface(index.to_string());
        let polygon = Polygon::new(corners.iter().map(|&p| p.into()).collect()).unwrap();
        scene.add_face(surface, material, polygon, None).unwrap();
    }
    scene
}

fn solved(faces: &[(Quad, f64, f64)], options: &Options) -> Solution {
    solve(&scene(faces), options, |_| true).unwrap()
}

/// Radiosity at a point, after a check that it is within twice its estimate of `exact`; the estimate over the error is
/// returned with it.
fn checked(solution: &Solution, point: [f64; 3], normal: [f64; 3], exact: f64) -> (f64, f64) {
    let gathered = solution.gather(point.into(), normal.into()).unwrap();
    let (value, estimate) = (gathered.radiosity[0], gathered.estimate[0].total());
    assert!((value - exact).abs() <= 2.0 * estimate, "{point:?}: {value} off {exact} by more than twice {estimate:e}");
    (value, estimate / (value - exact).abs())
}

const FLOOR: Quad = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
const CEILING: Quad = [[0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [1.0, 1.0, 1.0], [1.0, 0.0, 1.0]];
const SIDES: [Quad; 4] = [
    [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, 0.0]],
    [[0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [0.0, 1.0, 1.0]],
    [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]],
    [[1.0, 0.0, 0.0], [1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [1.0, 1.0, 0.0]],
];

#[test]
fn a_furnace_glows_evenly() {
    let quads: Vec<Quad> = [FLOOR, CEILING].into_iter().chain(SIDES).collect();
    let rho = [0.9, 0.1, 0.5, 0.3, 0.7, 0.2];
    let faces: Vec<_> = quads.into_iter().zip(rho).map(|(quad, rho)| (quad, rho, 1.0 - rho)).collect();
    for degree in [0, 3] {
        let solution = solved(&faces, &Options { degree: Some(degree), ..Options::default() });
        for point in [[0.5, 0.5, 0.0], [0.01, 0.02, 0.0], [0.999, 0.3, 0.0]] {
            let (value, _) = checked(&solution, point, [0.0, 0.0, 1.0], 1.0);
            assert!((value - 1.0).abs() < 1e-10, "degree {degree}: {value}");
        }
        assert!(solution.mean_estimate()[0].total() < 1e-9, "{:?}", solution.mean_estimate());
    }
}

/// Half of the light that falls on the rim is missing there, in a strip as wide as the gap, in which no node of the first elements is. The
/// means are those of 2e7 random walks between a glowing square and a dark one, with standard errors below 3.6e-4.
#[test]
fn between_squares_that_are_close_the_estimate_has_the_light_that_the_rim_loses() {
    for (gap, mean, asked) in [(0.05, 3.1857, 0.05), (0.01, 4.5446, 0.05), (0.01, 4.5446, 0.001), (0.001, 4.9521, 0.05)] {
        let faces = [(FLOOR, 0.9, 1.0), (CEILING.map(|[x, y, _]| [x, y, gap]), 0.9, 0.0)];
        let solution = solved(&faces, &Options { error: asked, ..Options::default() });
        let (error, estimate) = ((solution.mean()[0] - mean).abs(), solution.mean_estimate()[0].total());
        println!("gap {gap}, {} elements: {error:.1e} off, {estimate:.1e} estimated", solution.progress().elements);
        assert!(error < estimate && estimate < 4.0 * error, "{gap} {asked}: {error:e} {estimate:e}");
    }
}

/// From an element of a low closed box the sources near by are all that is seen: nothing past their rims is.
#[test]
fn in_a_low_box_of_single_elements_the_estimate_is_finite_and_true() {
    for height in [0.1, 0.03] {
        let low = |quad: Quad| quad.map(|[x, y, z]| [x, y, height * z]);
        let faces: Vec<_> = [FLOOR, CEILING].into_iter().chain(SIDES).zip([1.0, 0.0, 0.0, 0.0, 0.0, 0.0]).collect();
        let faces: Vec<_> = faces.into_iter().map(|(quad, emitted)| (low(quad), 0.5, emitted)).collect();
        let mean_and_estimate = |options: Options| {
            let solution = solved(&faces, &options);
            (solution.mean()[0], solution.mean_estimate()[0].total())
        };
        let (truth, _) = mean_and_estimate(Options { error: 1e-3, ..Options::default() });
        for degree in 0..=2 {
            let (mean, estimate) =
                mean_and_estimate(Options { error: 1.0, degree: Some(degree), first_elements: 1, ..Options::default() });
            println!("{height} {degree}: {:.1e} off, {estimate:.1e} estimated", (mean - truth).abs());
            assert!(
                (mean - truth).abs() < 2.0 * estimate && estimate < 0.5 * mean,
                "{height} {degree}: {mean} {truth} {estimate}"
            );
        }
    }
}

#[test]
fn two_squares_that_face_each_other_have_the_known_radiosity() {
    let faces = [(FLOOR, 0.5, 1.0), (CEILING, 0.5, 1.0)];
    for degree in 0..=3 {
        let solution = solved(&faces, &Options { degree: Some(degree), ..Options::default() });
        let references = [([0.5, 0.5, 0.0], 1.133_303_564_992_420_8), ([0.0, 0.0, 0.0], 1.076_981_393_145_044_5)];
        for (point, exact) in references {
            let (value, index) = checked(&solution, point, [0.0, 0.0, 1.0], exact);
            // Degree 2 is the default in scenes without shadows.
            let promised = if degree >= 2 { 1e-6 } else { 1e-3 };
            assert!(
                (value - exact).abs() < promised && index < 1e4,
                "degree {degree}: {value}, estimate {index:.1} times the error"
            );
        }
    }
}

/// Radiosity between two infinite strips of width 1 at distance 1 that reflect `rho` and emit 1, at a distance from their middle:
/// `B(x) = 1 + rho int B(y) / 2 (1 + (x - y)^2)^(3/2) dy`, by Nystrom's method with Simpson's rule on 400 intervals.
fn between_strips(rho: f64, at: f64) -> f64 {
    let count = 400_u32;
    let node = |i: u32| f64::from(i) / f64::from(count) - 0.5;
    let weight = |i: u32| [2.0, 4.0][(i % 2) as usize] / if i == 0 || i == count { 2.0 } else { 1.0 } / 3.0 / f64::from(count);
    let kernel = |x: f64, y: f64| 0.5 / (1.0 + (x - y) * (x - y)).powf(1.5);
    let gather = |x: f64, b: &[f64]| 1.0 + rho * (0..=count).zip(b).map(|(i, b)| weight(i) * kernel(x, node(i)) * b).sum::<f64>();
    let mut b = vec![1.0; count as usize + 1];
    for _ in 0..60 {
        b = (0..=count).map(|i| gather(node(i), &b)).collect();
    }
    gather(at, &b)
}

#[test]
fn long_strips_have_the_radiosity_of_infinite_ones() {
    let half = 500.0;
    let floor = [[-0.5, -half, 0.0], [0.5, -half, 0.0], [0.5, half, 0.0], [-0.5, half, 0.0]];
    let ceiling = [[-0.5, -half, 1.0], [-0.5, half, 1.0], [0.5, half, 1.0], [0.5, -half, 1.0]];
    let rho = 0.5;
    let options = Options { most_elements: 500, ..Options::default() };
    let solution = solved(&[(floor, rho, 1.0), (ceiling, rho, 1.0)], &options);
    for at in [0.0, 0.25, 0.499] {
        let exact = between_strips(rho, at);
        checked(&solution, [at, 0.1, 0.0], [0.0, 0.0, 1.0], exact);
    }
}

#[test]
fn at_the_apex_of_a_groove_the_radiosity_is_that_of_a_wedge() {
    // Two long strips that meet at an angle: far from all other edges, at the apex, each sees (1 + cos phi)/2 of the other.
    for phi in [1.0_f64, 2.0] {
        let (far, half) = (1e3, 1e3);
        let away = [far * phi.cos(), far * phi.sin()];
        let flat = [[0.0, -half, 0.0], [far, -half, 0.0], [far, half, 0.0], [0.0, half, 0.0]];
        let slanted = [[0.0, -half, 0.0], [0.0, half, 0.0], [away[0], half, away[1]], [away[0], -half, away[1]]];
        let rho = 0.5;
        let solution = solved(&[(flat, rho, 1.0), (slanted, rho, 1.0)], &Options { degree: Some(1), ..Options::default() });
        let exact = 1.0 / (1.0 - 0.5 * rho * (1.0 + phi.cos()));
        // The walls end at 1000; a millimetre from the apex that is less than a millionth of the light.
        checked(&solution, [1e-3, 0.0, 0.0], [0.0, 0.0, 1.0], exact);
    }
}

#[test]
fn the_estimate_of_the_mean_is_its_error_in_lit_cubes_between_squares_and_in_a_groove() {
    let held = |name: &str, faces: &[(Quad, f64, f64)], exact: f64| {
        let solution = solved(faces, &Options { error: 0.05, ..Options::default() });
        let (error, estimate) = (solution.mean()[0] - exact, solution.mean_estimate()[0].total());
        println!("{name}: {error:.2e} off, estimated {estimate:.2e}");
        // The correction is in the mean: where it is all of the error, or the remainder of the sweeps is, a hundred-thousandth is
        // no error.
        let is_least = error.abs() < 1e-5 * exact && estimate < 1e-5 * exact;
        assert!(is_least || (0.7..5.0).contains(&(estimate / error.abs())), "{name}: {error:e} off, estimated {estimate:e}");
    };
    for rho in [0.5, 0.9, 0.99] {
        let lit: Vec<_> = SIDES.into_iter().chain([FLOOR]).map(|quad| (quad, rho, 0.0)).chain([(CEILING, rho, 1.0)]).collect();
        // No light is lost, so that the ceiling's emission is a share of 1 - rho of the radiosity everywhere.
        held(&format!("cube of {rho}"), &lit, 1.0 / 6.0 / (1.0 - rho));
    }
    // Known to 1e-10 and to 1e-8, by polynomials of degree 3 and an error asked for of 1e-7.
    held("squares", &[(FLOOR, 0.5, 0.0), (CEILING, 0.5, 1.0)], 0.555_582_622_2);
    held("groove", &[(FLOOR, 0.5, 0.0), (SIDES[2], 0.5, 1.0)], 0.557_976_77);
}

#[test]
fn polynomials_converge_with_the_order_of_their_degree() {
    let faces = [(FLOOR, 0.5, 1.0), (CEILING, 0.5, 1.0)];
    for degree in 0..=3 {
        // The centre is a corner of four elements, where polynomials are off most.
        let error = |first_elements: usize| {
            let options = Options { error: 1e-7, degree: Some(degree), first_elements, most_elements: 1, ..Options::default() };
            let solution = solved(&faces, &options);
            let leaf = solution.gather(DVec3::new(0.499_999, 0.499_999, 0.0), DVec3::Z).unwrap().leaf;
            let place = solution.mesh().elements()[leaf].reference(DVec3::new(0.5, 0.5, 0.0));
            (solution.value_on(leaf, 0, place) - 1.133_303_564_992_420_8).abs()
        };
        let order = (error(8) / error(32)).log2();
        println!("degree {degree}: order {order:.2}");
        let expected = f64::from(u32::try_from(degree).unwrap()) + 1.0;
        assert!(order > expected - 0.35, "degree {degree}: order {order}");
    }
}

#[test]
fn a_face_that_sees_nothing_radiates_what_it_emits_round_after_round() {
    let below = FLOOR.map(|[x, y, _]| [y, x, -1.0]);
    let options = Options { error: 1e-4, degree: Some(0), first_elements: 1, ..Options::default() };
    let solution = solved(&[(FLOOR, 0.5, 1.0), (CEILING, 0.5, 1.0), (below, 0.5, 0.7)], &options);
    assert!(solution.progress().round > 1, "{:?}", solution.progress());
    let alone = |leaf: &usize| solution.mesh().elements()[*leaf].face() == 2;
    for leaf in solution.mesh().leaves().filter(alone) {
        let value = solution.value_on(leaf, 0, [0.0, 0.0]);
        assert!((value - 0.7).abs() <= 1e-15, "{value}");
    }
}

/// A lamp of 0.1 mm that gives a unit of power, as far over the floor of a room of 1 m: the floor below it is some 1e7 times as bright as the
/// room, and seen past the lamp.
#[test]
fn the_estimate_at_points_does_not_grow_with_the_brightness_of_a_spot_below_a_small_lamp() {
    let lamp = [[0.367, 0.611], [0.367, 0.6111], [0.3671, 0.6111], [0.3671, 0.611]].map(|[x, y]| [x, y, 1e-4]);
    let room = [FLOOR, CEILING].into_iter().chain(SIDES).map(|quad| (quad, 0.7, 0.0));
    let faces: Vec<_> = room.chain([(lamp, 0.0, 1e8)]).collect();
    let solution = solved(&faces, &Options { error: 0.02, ..Options::default() });
    let point = DVec3::new(0.159_738_914_637_078_57, 0.638_790_212_777_912_6, 1.0);
    let gathered = solution.gather(point, -DVec3::Z).unwrap();
    // By random walks that share no code with the solver, with their standard error.
    let (reference, margin) = (0.289_448, 2.9e-4);
    let (value, estimate) = (gathered.radiosity[0], gathered.estimate[0].total());
    assert!(
        (value - reference).abs() <= 2.0 * estimate + 4.0 * margin,
        "{value} is not {reference}, with an estimate of {estimate:e}"
    );
    assert!(estimate <= 0.05 * value, "an estimate of {estimate:e} of {value}");
}

/// A room of 4 by 4 by 3, without the wall at x = 0.
const ROOM: [Quad; 5] = [
    [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 4.0, 0.0], [0.0, 4.0, 0.0]],
    [[0.0, 0.0, 3.0], [0.0, 4.0, 3.0], [4.0, 4.0, 3.0], [4.0, 0.0, 3.0]],
    [[4.0, 0.0, 0.0], [4.0, 0.0, 3.0], [4.0, 4.0, 3.0], [4.0, 4.0, 0.0]],
    [[0.0, 0.0, 0.0], [0.0, 0.0, 3.0], [4.0, 0.0, 3.0], [4.0, 0.0, 0.0]],
    [[0.0, 4.0, 0.0], [4.0, 4.0, 0.0], [4.0, 4.0, 3.0], [0.0, 4.0, 3.0]],
];

/// A part of the wall at x = 0.
fn wall([y0, y1]: [f64; 2], [z0, z1]: [f64; 2]) -> Quad {
    [[0.0, y0, z0], [0.0, y1, z0], [0.0, y1, z1], [0.0, y0, z1]]
}

/// The sun shines through a slit of 1 cm by 1 m between four parts of a wall: a patch that no node of the first elements sees lights the
/// room. Light comes through the slit alone, not where a part's corner is on the edge of another.
#[test]
fn light_through_a_slit_is_found_by_few_elements() {
    let walls = [wall([0.0, 2.0], [0.0, 3.0]), wall([2.01, 4.0], [0.0, 3.0]), wall([2.0, 2.01], [0.0, 1.0])];
    let walls = walls.into_iter().chain([wall([2.0, 2.01], [2.0, 3.0])]);
    let sun = [
        [-80.639_804_520_390_53, -16.962_859_793_644_43, 57.515_876_515_161_736],
        [-80.823_605_628_586_11, -16.163_724_540_620_212, 57.515_876_515_161_736],
        [-80.373_256_382_509_17, -16.060_144_214_022_51, 58.193_266_116_868_045],
        [-80.189_455_274_313_59, -16.859_279_467_046_73, 58.193_266_116_868_045],
    ];
    let room = ROOM.into_iter().chain(walls).map(|quad| (quad, 0.7, 0.0));
    let faces: Vec<_> = room.chain([(sun, 0.0, PI * 14_872_099.940_511_595)]).collect();
    let options = Options { error: 0.05, ..Options::default() };
    let solution = solved(&faces, &options);
    let progress = solution.progress();
    assert!(progress.estimate <= options.error && progress.elements < 2000, "{progress:?}");
    let gathered = solution.gather([4.0, 1.497_987_062_351_529_5, 2.230_692_016_149_782].into(), -DVec3::X).unwrap();
    // By random walks that share no code with the solver, with their standard error.
    let (reference, margin) = (0.176_834, 4.7e-4);
    let (value, estimate) = (gathered.radiosity[0], gathered.estimate[0].total());
    assert!(
        (value - reference).abs() <= 2.0 * estimate + 4.0 * margin,
        "{value} is not {reference}, with an estimate of {estimate:e}"
    );
    assert!((value - reference).abs() <= 0.05 * reference, "{value} is not {reference}");
}

/// A lamp of 8 cm at the top of a shade as wide, 8 cm over the floor of a room: the shade's vertical edges touch all lines of sight to the
/// lamp's corners and hide nothing of it.
#[test]
fn a_lamp_in_a_shade_that_meets_it_takes_few_elements() {
    let [x, y, z] = [[1.37, 1.45], [3.62, 3.7], [0.08, 0.13]];
    let lamp = [[x[0], y[0], z[1]], [x[0], y[1], z[1]], [x[1], y[1], z[1]], [x[1], y[0], z[1]]];
    let corners = [[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]];
    let side = |i: usize| {
        let ([a, b], [c, d]) = (corners[i], corners[(i + 1) % 4]);
        ([[a, b, z[0]], [c, d, z[0]], [c, d, z[1]], [a, b, z[1]]], 0.0, 0.0)
    };
    let room = ROOM.into_iter().chain([wall([0.0, 4.0], [0.0, 3.0])]).map(|quad| (quad, 0.7, 0.0));
    let faces: Vec<_> = room.chain([(lamp, 0.0, PI * 4_973.591_971_621_73)]).chain((0..4).map(side)).collect();
    let options = Options { error: 0.01, ..Options::default() };
    let solution = solved(&faces, &options);
    let progress = solution.progress();
    assert!(progress.estimate <= options.error && progress.elements < 1000, "{progress:?}");
    // By random walks that share no code with the solver, with their standard error.
    let (reference, margin) = (2.143_82, 1.5e-3);
    let (mean, estimate) = (solution.mean()[0], solution.mean_estimate()[0].total());
    assert!(
        (mean - reference).abs() <= 2.0 * estimate + 4.0 * margin,
        "{mean} is not {reference}, with an estimate of {estimate:e}"
    );
}
