//! A room of small tiles whose lamp is tiles too: too many to be kept apart.

use std::time::Duration;

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::Scene;

use crate::solve::options::Options;
use crate::solve::solve;

/// Tiles along a side, and the first and the last one of the lamp.
const TILES: usize = 18;
const LAMP: [usize; 2] = [6, 11];

#[test]
fn the_first_answer_tells_walls_apart_though_there_is_no_time() {
    let mut scene = Scene::new(["grey"]).unwrap();
    let [white, lamp] = [0.0, 20.0].map(|radiance| scene.add_material(format!("{radiance}"), [0.6], [radiance]).unwrap());
    for side in 0..6 {
        let surface = scene.add_surface(format!("{side}"));
        let (axis, is_high) = (side / 2, side % 2 == 1);
        let corner = |i: usize, j: usize| {
            let mut corner = [f64::from(u8::from(is_high)); 3];
            (corner[(axis + 1) % 3], corner[(axis + 2) % 3]) = (i as f64 / TILES as f64, j as f64 / TILES as f64);
            DVec3::from(corner)
        };
        for (i, j) in (0..TILES).flat_map(|i| (0..TILES).map(move |j| (i, j))) {
            let mut corners = vec![corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
            if is_high {
                corners.reverse();
            }
            let glows = side == 5 && [i, j].iter().all(|at| (LAMP[0]..=LAMP[1]).contains(at));
            scene.add_face(surface, if glows { lamp } else { white }, Polygon::new(corners).unwrap(), None).unwrap();
        }
    }
    let options = Options { time: Some(Duration::ZERO), degree: Some(0), error: 0.1, ..Options::default() };
    let solution = solve(&scene, &options, |_| true).unwrap();
    let reflected: Vec<f64> = solution.by_surface(&scene).iter().map(|surface| surface.reflected[0]).collect();
    // By a solution of three rounds and 48,312 links. Where no light is told from other light all have 1.75.
    for (surface, expected) in [1.84, 1.84, 1.84, 1.84, 2.0, 1.11].into_iter().enumerate() {
        assert!((reflected[surface] - expected).abs() < 0.07 * expected, "{surface}: {reflected:?}");
    }
}
