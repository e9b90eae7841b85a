//! Two unit squares, in free sight and past a screen, against `data/reference/two_polygons.csv`: value, bracket, reciprocity.

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::{FactorSettings, FormFactors, Scene, largest};

const TABLE: &str = include_str!("../../../../data/reference/two_polygons.csv");

/// Relative errors allowed.
const IN_FREE_SIGHT: f64 = 1e-9;
const PAST_A_SCREEN: f64 = 1e-4;

const RECIPROCITY: f64 = 1e-14;

type Quad = [[f64; 3]; 4];

/// A rectangle at height z, lit upwards.
fn level([a, c]: [f64; 2], [b, d]: [f64; 2], z: f64) -> Quad {
    [[a, c, z], [b, c, z], [b, d, z], [a, d, z]]
}

fn ceiling(z: f64) -> Quad {
    let [a, b, c, d] = level([0.0; 2], [1.0; 2], z);
    [a, d, c, b]
}

/// The faces of a case, of which the first two are asked for.
fn faces(case: &str, value: &str) -> Vec<Quad> {
    let floor = level([0.0; 2], [1.0; 2], 0.0);
    let number = || value.parse::<f64>().unwrap();
    match case {
        "gap" => vec![floor, ceiling(number())],
        "wedge" => {
            let (sine, cosine) = (libm::sin(number().to_radians()), libm::cos(number().to_radians()));
            vec![floor, [[0.0; 3], [0.0, cosine, sine], [1.0, cosine, sine], [1.0, 0.0, 0.0]]]
        }
        "screen" => {
            let screen = match value {
                "quarter" => level([0.0; 2], [0.5; 2], 0.5),
                "half" => level([-1.0; 2], [0.5, 2.0], 0.5),
                _ => level([0.25; 2], [0.75; 2], 0.5),
            };
            vec![floor, ceiling(1.0), screen]
        }
        _ => panic!("{case} is no case"),
    }
}

fn scene(faces: &[Quad]) -> Scene {
    let mut scene = Scene::new(["grey"]).unwrap();
    let material = scene.add_material("white", [0.5], [0.0]).unwrap();
    for (index, corners) in faces.iter().enumerate() {
        let surface = scene.add_surface(index.to_string());
        scene.add_face(surface, material, Polygon::new(corners.map(DVec3::from).to_vec()).unwrap(), None).unwrap();
    }
    scene
}

#[test]
fn two_squares_exchange_what_the_table_says_within_their_brackets_and_alike_both_ways() {
    let mut worst = [0.0_f64; 2];
    for line in TABLE.lines().skip(1) {
        let [case, value, expected] = line.split(',').collect::<Vec<_>>()[..] else { panic!("{line}") };
        let expected: f64 = expected.parse().unwrap();
        let scene = scene(&faces(case, value));
        let settings = FactorSettings::default();
        let matrix = FormFactors::new(&scene).unwrap().matrix(&settings, || ()).unwrap();
        let is_free = case != "screen";
        let allowed = if is_free { IN_FREE_SIGHT } else { PAST_A_SCREEN };
        for (from, to) in [(0, 1), (1, 0)] {
            let entry = matrix.row(from).find(|entry| entry.face == to).unwrap();
            let relative_error = (entry.factor - expected).abs() / expected;
            assert!(relative_error <= allowed, "{line}: {entry:?}, off by {relative_error:e}");
            // The table and the sines of angles have a rounding each.
            let slack = 4.0 * f64::EPSILON * expected;
            assert!(entry.lower <= expected + slack && entry.upper >= expected - slack, "{line}: {entry:?}");
            assert!(entry.lower <= entry.factor && entry.factor <= entry.upper, "{line}: {entry:?}");
            assert!(entry.error <= settings.tolerance, "{line}: {entry:?}");
            worst[usize::from(!is_free)] = largest(worst[usize::from(!is_free)], relative_error);
        }
        assert!(matrix.worst_reciprocity() <= RECIPROCITY, "{line}: {:e}", matrix.worst_reciprocity());
    }
    println!("largest relative error: {:.1e} in free sight, {:.1e} past a screen", worst[0], worst[1]);
}
