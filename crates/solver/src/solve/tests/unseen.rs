use radgrad_core::{DVec3, Polygon};
use radgrad_scene::Scene;

use crate::solve::options::Options;
use crate::solve::solve;

/// `SplitMix64` (G. Steele, D. Lea and C. Flood 2014): numbers in [low, high).
struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        low + (high - low) * ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// The sides of a cuboid seen from outside; the first is the bottom.
fn cuboid(low: DVec3, high: DVec3) -> [[DVec3; 4]; 6] {
    let corner = |i: usize| DVec3::new([low.x, high.x][i & 1], [low.y, high.y][i >> 1 & 1], [low.z, high.z][i >> 2 & 1]);
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]].map(|side| side.map(corner))
}

/// A room with a lamp that looks down, of any size and height, in a shade of four sides.
fn room(random: &mut Random) -> Scene {
    let mut scene = Scene::new(["grey"]).unwrap();
    let (wall, surface) = (scene.add_material("wall", [0.6], [0.0]).unwrap(), scene.add_surface("all"));
    let black = scene.add_material("black", [0.0], [0.0]).unwrap();
    let mut add = |material: usize, [a, b, c, d]: [DVec3; 4]| {
        scene.add_face(surface, material, Polygon::new(vec![d, c, b, a]).unwrap(), None).unwrap();
    };
    cuboid(DVec3::ZERO, DVec3::new(4.0, 4.0, 3.0)).into_iter().for_each(|face| add(wall, face));
    let size = random.between(0.02, 0.4);
    let (x, y, z) = (random.between(0.1, 3.4), random.between(0.1, 3.4), random.between(0.05, 2.5));
    let deep = random.between(0.0, 0.9) * z;
    let shade = cuboid(DVec3::new(x, y, z - deep), DVec3::new(x + size, y + size, z));
    shade[2..].iter().for_each(|side| add(black, *side));
    let (u, v) = (DVec3::X * size, DVec3::Y * size);
    let corner = DVec3::new(x, y, z);
    let lamp = scene.add_material("lamp", [0.0], [1.0 / (size * size)]).unwrap();
    let face = Polygon::new(vec![corner, corner + v, corner + u + v, corner + u]).unwrap();
    scene.add_face(surface, lamp, face, None).unwrap();
    scene
}

#[test]
fn lamps_that_no_node_sees_are_found_or_in_the_estimate() {
    let mut random = Random(8);
    for _ in 0..3 {
        let scene = room(&mut random);
        let options = Options { error: 0.5, most_elements: 4000, ..Options::default() };
        let solution = solve(&scene, &options, |_| true).unwrap();
        let fine = solve(&scene, &Options { error: 0.1, ..options }, |_| true).unwrap();
        let error = (solution.radiosity.mean[0] - fine.radiosity.mean[0]).abs();
        let estimates = solution.mean_estimate()[0].total() + fine.mean_estimate()[0].total();
        assert!(
            error <= estimates && fine.radiosity.mean[0] > 0.0,
            "{} and {}, {estimates}",
            solution.radiosity.mean[0],
            fine.radiosity.mean[0]
        );
    }
}

/// A hall with a closed box in it, whose six sides are seen from outside and from inside, and in that a lamp that no one in the hall sees.
#[test]
fn a_lamp_in_a_closed_box_lights_nothing_outside_of_it() {
    let mut scene = Scene::new(["grey"]).unwrap();
    let (wall, lamp) = (scene.add_material("wall", [0.5], [0.0]).unwrap(), scene.add_material("lamp", [0.0], [10.0]).unwrap());
    let (inside, outside) = (scene.add_surface("inside"), scene.add_surface("outside"));
    let mut add = |surface: usize, material: usize, corners: [DVec3; 4]| {
        scene.add_face(surface, material, Polygon::new(corners.to_vec()).unwrap(), None).unwrap();
    };
    let turned = |[a, b, c, d]: [DVec3; 4]| [d, c, b, a];
    cuboid(DVec3::splat(-1.0), DVec3::splat(2.0)).into_iter().for_each(|side| add(outside, wall, turned(side)));
    for side in cuboid(DVec3::splat(0.1), DVec3::splat(0.7)) {
        add(outside, wall, side);
        add(inside, wall, turned(side));
    }
    let [a, b, c, d] = [[0.3, 0.3], [0.3, 0.5], [0.5, 0.5], [0.5, 0.3]].map(|[x, y]| DVec3::new(x, y, 0.69));
    add(inside, lamp, [a, b, c, d]);
    let solution = solve(&scene, &Options { error: 0.05, ..Options::default() }, |_| true).unwrap();
    let in_hall = solution.gather(DVec3::new(0.5, 0.5, -1.0), DVec3::Z).unwrap();
    assert!(solution.progress.estimate <= 0.05, "{}", solution.progress.estimate);
    assert!(in_hall.radiosity[0] == 0.0 && in_hall.estimate[0].total() < 0.05 * solution.radiosity.reflected[0], "{in_hall:?}");
}
