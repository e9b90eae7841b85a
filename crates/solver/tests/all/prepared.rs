//! Where a scene lies and in which unit changes no answer; a scene that counts light twice or has no finite answer is refused.

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::{Degenerate, Quantity, Scene};
use radgrad_solver::{Error, Options, Solution, solve};

/// Two squares that face each other; the upper one glows. Exact values are those of the unit squares.
fn squares(to: impl Fn(f64) -> f64, radiance: f64) -> Scene {
    let mut scene = Scene::new(["grey"]).unwrap();
    let dull = scene.add_material("dull", [0.5], [0.0]).unwrap();
    let lamp = scene.add_material("lamp", [0.0], [radiance]).unwrap();
    let outline = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let (floor, ceiling) = (outline.map(|(x, y)| [x, y, 0.0]), outline.map(|(x, y)| [y, x, 1.0]));
    for (name, material, corners) in [("floor", dull, floor), ("ceiling", lamp, ceiling)] {
        let surface = scene.add_surface(name);
        let polygon = Polygon::new(corners.map(|v| DVec3::from(v.map(&to))).to_vec()).unwrap();
        scene.add_face(surface, material, polygon, None).unwrap();
    }
    scene
}

fn solved(scene: &Scene) -> Solution {
    solve(scene, &Options { error: 1e-3, ..Options::default() }, |_| true).unwrap()
}

/// The form factor of opposite unit squares at distance 1 (J. R. Howell, C-11), and that from the middle of one.
const FACTOR: f64 = 0.199_824_895_698_387;
const FROM_MIDDLE: f64 = 0.239_456_470_460_773_5;

#[test]
fn a_scene_that_is_shifted_exactly_has_the_same_answers_within_their_estimates() {
    for shift in [0.0, 1e3, 1e6, 1e9, 1e10, 1e12, 1e14, 1e15] {
        let solution = solved(&squares(|x| x + shift, std::f64::consts::FRAC_1_PI));
        assert!((solution.reflected()[0] / (0.25 * FACTOR) - 1.0).abs() <= 1e-3, "{shift:e}: {:?}", solution.mean());
        let middle = solution.gather(DVec3::new(shift + 0.5, shift + 0.5, shift), DVec3::Z).unwrap();
        let (value, estimate) = (middle.radiosity[0], middle.estimate[0].total());
        let error = (value - 0.5 * FROM_MIDDLE).abs();
        assert!(error <= 2.0 * estimate + 1e-12 && estimate < 1e-3, "{shift:e}: {value} +- {estimate:e}");
        assert_eq!(solution.warnings().is_empty(), shift < 1e9, "{shift:e}");
    }
}

#[test]
fn a_unit_that_is_another_power_of_two_changes_no_digit() {
    let (here, options) = (squares(|x| x, 1.0), Options { degree: Some(1), error: 1e-2, ..Options::default() });
    let reference = solve(&here, &options, |_| true).unwrap();
    for exponent in [-700, -520, -400, -65, -30, 30, 65, 400, 520, 700] {
        let unit = 2f64.powi(exponent);
        let solution = solve(&squares(|x| x * unit, 1.0), &options, |_| true).unwrap();
        assert_eq!((solution.mean(), solution.mean_estimate()), (reference.mean(), reference.mean_estimate()), "2^{exponent}");
        let gather = |solution: &Solution, unit: f64| solution.gather(DVec3::new(0.3 * unit, 0.6 * unit, 0.0), DVec3::Z).unwrap();
        assert_eq!(gather(&solution, unit), gather(&reference, 1.0), "2^{exponent}");
        let error = solution.gather(DVec3::splat(0.5 * unit), DVec3::Z).unwrap_err();
        assert!(matches!(error, Error::NoFace { reach, .. } if reach == 1e-6 * unit), "{error}");
    }
}

/// A scene with its channels in this order, and all its light times a number.
fn in_channels(scene: &Scene, order: [usize; 3], unit: f64) -> Scene {
    let mut changed = Scene::new(order.map(|channel| scene.channels()[channel].clone())).unwrap();
    for material in scene.materials() {
        let of = |quantity, unit: f64| order.map(|channel| unit * material.factors(quantity)[channel]);
        let (reflectance, radiance) = (of(Quantity::Reflectance, 1.0), of(Quantity::Radiance, unit));
        changed.add_material(material.name(), reflectance, radiance).unwrap();
    }
    for surface in scene.surfaces() {
        changed.add_surface(surface.name());
    }
    for face in scene.faces() {
        changed.add_face(face.surface(), face.material(), face.polygon().clone(), None).unwrap();
    }
    changed
}

#[test]
fn a_unit_of_light_that_is_another_power_of_two_and_an_order_of_channels_change_no_digit() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/cornell.obj");
    let scene = Scene::read(scene, Degenerate::Refuse).unwrap();
    let options = Options { degree: Some(1), error: 0.2, ..Options::default() };
    let solved = |order, unit| solve(&in_channels(&scene, order, unit), &options, |_| true).unwrap();
    let reference = solved([0, 1, 2], 1.0);
    for (order, exponent) in [([0, 1, 2], -40), ([2, 0, 1], 60), ([1, 2, 0], -300)] {
        let (unit, solution) = (2f64.powi(exponent), solved(order, 2f64.powi(exponent)));
        let of = |means: &[f64]| order.map(|channel| unit * means[channel]);
        assert_eq!(solution.mean(), of(reference.mean()), "{order:?}, 2^{exponent}");
        assert_eq!(solution.reflected(), of(reference.reflected()), "{order:?}, 2^{exponent}");
        assert_eq!(solution.progress(), reference.progress(), "{order:?}, 2^{exponent}");
    }
}

#[test]
fn overlapping_faces_are_refused_by_both_names_however_bright() {
    for reflectance in [0.5, 0.9] {
        let mut scene = squares(|x| x, 1.0);
        let white = scene.add_material("white", [reflectance], [1.0]).unwrap();
        let rug = scene.add_surface("rug");
        let corners = [(0.25, 0.25), (0.75, 0.25), (0.75, 0.75), (0.25, 0.75)].map(|(x, y)| DVec3::new(x, y, 0.0));
        scene.add_face(rug, white, Polygon::new(corners.to_vec()).unwrap(), None).unwrap();
        let error = solve(&scene, &Options::default(), |_| true).unwrap_err().to_string();
        assert!(error.contains("face 0 of `floor` and face 2 of `rug` overlap"), "{error}");
    }
}

#[test]
fn errors_are_relative_to_what_is_reflected() {
    let scene = squares(|x| x, std::f64::consts::FRAC_1_PI);
    let options = Options { error: 1e-3, ..Options::default() };
    let reflected = solve(&scene, &options, |_| true).unwrap();
    assert!((reflected.reflected()[0] - 0.25 * FACTOR).abs() < 1e-4);
    assert!((reflected.mean()[0] - reflected.reflected()[0] - 0.5).abs() < 1e-12);
    let estimated = reflected.mean_estimate()[0].total() / reflected.relative_to()[0];
    assert!(estimated <= (1.0 + 1e-12) * reflected.progress().estimate && reflected.progress().estimate <= 1e-3);
    assert_eq!(reflected.relative_to(), reflected.reflected());
    // Nothing reflects: the radiosity is the known emission.
    let mut dark = Scene::new(["grey"]).unwrap();
    let black = dark.add_material("black", [0.0], [1.0]).unwrap();
    let surface = dark.add_surface("all");
    for face in scene.faces() {
        dark.add_face(surface, black, face.polygon().clone(), None).unwrap();
    }
    let solution = solve(&dark, &options, |_| true).unwrap();
    assert!(solution.progress().estimate == 0.0 && solution.reflected()[0].abs() < 1e-14, "but for rounding");
}

#[test]
fn answers_beyond_the_range_of_a_double_are_errors() {
    // Squares of 1e300 are beyond it as well.
    for radiance in [1e300, 5e307] {
        let error = solve(&squares(|x| x, radiance), &Options::default(), |_| true).unwrap_err();
        assert!(matches!(&error, Error::NotFinite { channel, .. } if channel == "grey"), "{error}");
    }
    let large = solve(&squares(|x| x, 1e140), &Options::default(), |_| true).unwrap();
    assert!(large.mean()[0].is_finite() && large.progress().estimate <= 0.005);
}
