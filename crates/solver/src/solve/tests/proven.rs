use radgrad_core::{DVec3, Polygon};
use radgrad_scene::{Scene, largest};

use crate::links::station::Station;
use crate::solve::options::Options;
use crate::solve::solution::Solution;
use crate::solve::solve;
use crate::solve::tests::links::leaves;

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

/// A room with a lamp that looks down, of any size and height, in a shade of four sides; and a screen with a slit, of triangles, or a
/// tilted box that may go through a wall.
fn room(random: &mut Random, kind: usize) -> Scene {
    let mut scene = Scene::new(["grey"]).unwrap();
    let (wall, surface) = (scene.add_material("wall", [0.6], [0.0]).unwrap(), scene.add_surface("all"));
    let black = scene.add_material("black", [0.0], [0.0]).unwrap();
    let mut add = |material: usize, corners: &[DVec3]| {
        scene.add_face(surface, material, Polygon::new(corners.to_vec()).unwrap(), None).unwrap();
    };
    let cuboid = |low: DVec3, high: DVec3, turn: f64, inward: bool| {
        let (sin, cos) = turn.sin_cos();
        let middle = 0.5 * (low + high);
        let turned = |p: DVec3| {
            let p = p - middle;
            middle + DVec3::new(cos * p.x - sin * p.y, sin * p.x + cos * p.y, p.z)
        };
        let faces = cuboid(low, high).map(|face| face.map(turned));
        faces.map(|[a, b, c, d]| if inward { [d, c, b, a] } else { [a, b, c, d] })
    };
    cuboid(DVec3::ZERO, DVec3::new(4.0, 4.0, 3.0), 0.0, true).iter().for_each(|face| add(wall, face));
    let size = random.between(0.02, 0.4);
    let (x, y, z) = (random.between(0.1, 3.4), random.between(0.1, 3.4), random.between(0.05, 2.5));
    let deep = random.between(0.0, 0.9) * z;
    let shade = cuboid(DVec3::new(x, y, z - deep), DVec3::new(x + size, y + size, z), 0.0, true);
    shade[2..].iter().for_each(|side| add(black, side));
    let (u, v) = (DVec3::X * size, DVec3::Y * size);
    let corner = DVec3::new(x, y, z);
    match kind {
        0 => {}
        1 => {
            // Two triangles with a slit between.
            let (h, gap) = (0.5 * (z - deep), random.between(0.001, 0.1));
            let at = |a: f64, b: f64| DVec3::new(x + a, y + b, h);
            add(wall, &[at(-1.0, -1.0), at(2.0, -1.0), at(-1.0, 2.0)]);
            add(wall, &[at(2.0 + gap, 2.0), at(-1.0 + gap, 2.0), at(2.0 + gap, -1.0)]);
        }
        _ => {
            let low = DVec3::new(random.between(0.0, 3.5), random.between(0.0, 3.5), random.between(-0.2, 1.0));
            let size = DVec3::new(random.between(0.05, 1.0), random.between(0.05, 1.0), random.between(0.1, 1.5));
            cuboid(low, low + size, random.between(0.0, 1.5), false).iter().for_each(|face| add(wall, face));
        }
    }
    let lamp = scene.add_material("lamp", [0.0], [1.0 / (size * size)]).unwrap();
    let face = Polygon::new(vec![corner, corner + v, corner + u + v, corner + u]).unwrap();
    scene.add_face(surface, lamp, face, None).unwrap();
    scene
}

/// The largest and the mean of what the projection of direct light leaves out on a leaf, of a grid.
fn sampled(solution: &Solution, leaf: usize, count: u32) -> [f64; 2] {
    let (element, basis) = (&solution.mesh.elements()[leaf], solution.mesh.basis(leaf));
    let held = basis.project(&solution.direct_samples(leaf, 0));
    let rho = solution.surfaces.reflectance[element.face()][0];
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(count);
    let (mut most, mut sum, mut places) = (0.0_f64, 0.0, 0.0);
    for [s, t] in (0..count).flat_map(|i| (0..count).map(move |j| [at(i), at(j)])) {
        if element.excess([s, t]) > 0.0 {
            continue;
        }
        let station = Station::on(element, element.point([s, t]));
        let lit = solution.lamps.at(&solution.optics(), &solution.surfaces, &station, solution.direct[leaf].sights()).unwrap();
        let polynomial: f64 = basis.values([s, t]).iter().zip(&held).map(|(f, c)| f * c).sum();
        let off = (rho * lit.irradiance[0] - polynomial).abs() - rho * (lit.error[0][0] + lit.error[0][1]);
        most = largest(most, off);
        sum += off;
        places += 1.0;
    }
    [most, sum / places]
}

#[test]
fn on_no_leaf_is_more_of_direct_light_left_out_than_is_proven() {
    let mut random = Random(5);
    let (mut leaves, mut lit, mut nearest) = (0, 0, 0.0_f64);
    for case in 0..18 {
        let scene = room(&mut random, case % 3);
        let first_elements = [8, 60, 120][case / 3 % 3];
        let options =
            Options { error: 1.0, first_elements, most_elements: first_elements, degree: Some(case % 4), ..Options::default() };
        let solution = solve(&scene, &options, |_| false).unwrap();
        for leaf in solution.mesh.leaves() {
            let proven = &solution.proven_direct[leaf].as_ref().unwrap()[0];
            let [most, mean] = sampled(&solution, leaf, 16);
            leaves += 1;
            lit += usize::from(most > 1e-9);
            let (by_most, by_mean) = (proven.largest.total(), proven.mean.total());
            assert!(most <= by_most, "case {case}, leaf {leaf}: {most:e} is left out, {by_most:e} is proven");
            // The mean over a grid is not quite that over the leaf.
            assert!(mean <= by_mean + 0.1 * most, "case {case}, leaf {leaf}: {mean:e} in the mean, {by_mean:e} is proven");
            if by_most > 0.0 {
                nearest = largest(nearest, most / by_most);
            }
        }
    }
    println!("{leaves} leaves, {lit} of them lit unevenly, the nearest {nearest:.2} of its bound");
    assert!(lit > 150 && nearest > 0.1, "{lit} of {leaves}, {nearest}");
}

/// The largest and the mean of what the projection of reflected light leaves out on a receiver, of a grid, and of what links neglect.
fn sampled_of_reflected(solution: &Solution, receiver: usize, count: u32) -> [f64; 2] {
    let (element, basis) = (&solution.mesh.elements()[receiver], solution.mesh.basis(receiver));
    let (links, rho) = (&solution.links[receiver], solution.surfaces.reflectance[element.face()][0]);
    let of = |source: usize| solution.field.of(source, 0, solution.mesh.basis(source).len());
    let sum = |values: &[f64], source: usize| values.iter().zip(of(source)).map(|(v, c)| v * c).sum::<f64>();
    let at_node = |node: usize| links.iter().map(|link| sum(&link.rows[node].values, link.source)).sum();
    let held = basis.project(&(0..basis.nodes().len()).map(at_node).collect::<Vec<f64>>());
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(count);
    let (mut most, mut mean, mut places) = (0.0_f64, 0.0, 0.0);
    for [s, t] in (0..count).flat_map(|i| (0..count).map(move |j| [at(i), at(j)])) {
        if element.excess([s, t]) > 0.0 {
            continue;
        }
        let station = Station::on(element, element.point([s, t]));
        let (mut light, mut error) = (0.0, 0.0);
        for link in links {
            for leaf in leaves(solution, link.source) {
                let row = solution.optics().receive(&station, leaf, &link.sight, of(leaf).len()).unwrap();
                light += sum(&row.values, leaf);
                error += row.error_of(of(leaf));
            }
        }
        let polynomial: f64 = basis.values([s, t]).iter().zip(&held).map(|(f, c)| f * c).sum();
        let off = rho * ((light - polynomial).abs() - error);
        (most, mean, places) = (largest(most, off), mean + off, places + 1.0);
    }
    [most, mean / places]
}

#[test]
fn on_no_receiver_is_more_of_reflected_light_left_out_than_is_proven() {
    let mut random = Random(9);
    let (mut receivers, mut nearest) = (0, 0.0_f64);
    for case in 0..6 {
        let scene = room(&mut random, case % 3);
        let first_elements = [8, 12][case / 3];
        // With a bound that is asked for the proof cuts elements into cells as often as it may.
        let bound = Some([0.1, 1.0][case / 3]);
        let options = Options {
            error: 1.0,
            bound,
            first_elements,
            most_elements: 2 * first_elements,
            degree: Some(1 + case % 2),
            ..Options::default()
        };
        let solution = solve(&scene, &options, |_| false).unwrap();
        let proven = solution.proven().unwrap();
        for &receiver in solution.receivers.iter().filter(|&&receiver| solution.far[receiver].is_empty()) {
            let rest = &proven.reflected[receiver][0];
            let [most, mean] = sampled_of_reflected(&solution, receiver, 10);
            receivers += 1;
            let (by_most, by_mean) = (rest.largest.total(), rest.mean.total());
            assert!(most <= by_most, "case {case}, {receiver}: {most:e} is left out, {by_most:e} is proven");
            assert!(mean <= by_mean + 0.1 * most, "case {case}, {receiver}: {mean:e} in the mean, {by_mean:e} is proven");
            if by_most > 0.0 {
                nearest = largest(nearest, most / by_most);
            }
        }
    }
    println!("{receivers} receivers, the nearest {nearest:.2} of its bound");
    assert!(receivers > 100 && nearest > 0.02, "{receivers}, {nearest}");
}

#[test]
fn lamps_that_no_node_sees_are_found_or_in_the_estimate() {
    let mut random = Random(8);
    for _ in 0..3 {
        let scene = room(&mut random, 0);
        let options = Options { error: 0.5, most_elements: 4000, ..Options::default() };
        let solution = solve(&scene, &options, |_| true).unwrap();
        let fine = solve(&scene, &Options { error: 0.1, ..options }, |_| true).unwrap();
        let off = (solution.mean[0] - fine.mean[0]).abs();
        let bounds = solution.mean_bound()[0].total() + fine.mean_bound()[0].total();
        assert!(off <= bounds, "{} and {}, {bounds}", solution.mean[0], fine.mean[0]);
        let estimates = solution.mean_estimate()[0].total() + fine.mean_estimate()[0].total();
        assert!(off <= estimates && fine.mean[0] > 0.0, "{} and {}, {estimates}", solution.mean[0], fine.mean[0]);
    }
}

/// Faces that reflect and radiate alike.
fn alike(faces: &[[[f64; 3]; 4]], reflectance: f64, emitted: f64) -> Scene {
    let mut scene = Scene::new(["grey"]).unwrap();
    let emitted = emitted * std::f64::consts::FRAC_1_PI;
    let (wall, surface) = (scene.add_material("wall", [reflectance], [emitted]).unwrap(), scene.add_surface("all"));
    for corners in faces {
        let polygon = Polygon::new(corners.map(DVec3::from).to_vec()).unwrap();
        scene.add_face(surface, wall, polygon, None).unwrap();
    }
    scene
}

/// A room seen from inside, and in it a box on its corner seen from outside.
fn furnace() -> Vec<[[f64; 3]; 4]> {
    let room = cuboid(DVec3::ZERO, DVec3::splat(4.0)).map(|side| [3, 2, 1, 0].map(|i| side[i].to_array()));
    let (u, v, w) = (DVec3::new(0.6, 0.0, 0.8), DVec3::Y, DVec3::new(-0.8, 0.0, 0.6));
    let turned = |p: DVec3| (DVec3::new(2.0, 1.5, 1.0) + u * p.x + v * p.y + w * p.z).to_array();
    let solid = cuboid(DVec3::ZERO, DVec3::ONE).map(|side| side.map(turned));
    [room, solid].concat()
}

/// Unit squares that face each other at distance 1.
fn squares() -> [[[f64; 3]; 4]; 2] {
    let floor = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let ceiling = [[0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [1.0, 1.0, 1.0], [1.0, 0.0, 1.0]];
    [floor, ceiling]
}

#[test]
fn where_all_is_seen_the_bound_is_near_the_error_and_in_even_light_it_is_that_of_rounding() {
    let even = solve(&alike(&furnace(), 0.7, 0.3), &Options::default(), |_| true).unwrap();
    let bound = even.mean_bound()[0].total();
    assert!((even.mean()[0] - 1.0).abs() <= bound && bound < 1e-8, "{} with {bound:e}", even.mean()[0]);
    let mut random = Random(3);
    for count in 0..1000 {
        let [a, b, _, d] = furnace()[count % 12].map(DVec3::from);
        let (u, v) = ((b - a) * random.between(0.0, 1.0), (d - a) * random.between(0.0, 1.0));
        let found = even.gather(a + u + v, (b - a).cross(d - a).normalize()).unwrap();
        let (off, bound) = ((found.radiosity[0] - 1.0).abs(), found.ledger[0].total());
        assert!(off <= bound && bound < 1e-6, "{off:e} with {bound:e} at {}", a + u + v);
    }

    let squares = solve(&alike(&squares(), 0.5, 1.0), &Options::default(), |_| true).unwrap();
    let bound = squares.mean_bound()[0].total() / squares.reflected()[0];
    assert!(bound < 1e-6, "{bound:e}");
    for count in 0..1000 {
        let at = DVec3::new(random.between(0.0, 1.0), random.between(0.0, 1.0), (count % 2) as f64);
        let bound = squares.gather(at, DVec3::Z * (1.0 - 2.0 * at.z)).unwrap().ledger[0].total();
        assert!(bound < 1e-6, "{bound:e} at {at}");
    }
    // Strips so long, so far from each other, that reflect so much.
    for (length, gap, rho) in [(3.0, 1.5, 0.6), (5.0, 1.0, 0.6), (8.0, 0.7, 0.9)] {
        let below = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, length, 0.0], [0.0, length, 0.0]];
        let above = [0, 3, 2, 1].map(|i: usize| [below[i][0], below[i][1], gap]);
        let strips = solve(&alike(&[below, above], rho, 1.0), &Options::default(), |_| true).unwrap();
        let bound = strips.mean_bound()[0].total() / strips.reflected()[0];
        assert!(bound < 1e-6, "{length} at {gap}: {bound:e}");
        for _ in 0..30 {
            let at = DVec3::new(random.between(0.0, 1.0), random.between(0.0, length), 0.0);
            let bound = strips.gather(at, DVec3::Z).unwrap().ledger[0].total();
            assert!(bound < 1e-6 * strips.mean()[0], "{length} at {gap}: {bound:e} at {at}");
        }
    }
}

/// All light that a room with one reflectance gets is reflected on and on: `E/(1 - rho)` of it is found, wherever and behind whatever it is lit.
#[test]
fn in_a_closed_room_of_one_reflectance_the_mean_is_proven_to_little_more_than_its_error() {
    let mut random = Random(17);
    for case in 0..6 {
        let rho = random.between(0.2, 0.9);
        let mut scene = Scene::new(["grey"]).unwrap();
        let (wall, surface) = (scene.add_material("wall", [rho], [0.0]).unwrap(), scene.add_surface("all"));
        let lit = scene.add_material("lit", [rho], [std::f64::consts::FRAC_1_PI]).unwrap();
        let (mut emitted, mut seen) = (0.0, 0.0);
        let mut add = |material: usize, corners: [DVec3; 4]| {
            let polygon = Polygon::new(corners.to_vec()).unwrap();
            let area = polygon.area();
            scene.add_face(surface, material, polygon, None).unwrap();
            area
        };
        for (side, [a, b, c, d]) in cuboid(DVec3::ZERO, DVec3::new(4.0, 4.0, 3.0)).into_iter().enumerate() {
            let is_lit = side == case;
            let area = add(if is_lit { lit } else { wall }, [d, c, b, a]);
            (emitted, seen) = (emitted + if is_lit { area } else { 0.0 }, seen + area);
        }
        // A box with or without a bottom on the floor, and one that hangs before the lit side.
        let bottom = usize::from(case % 2 == 0);
        let low = DVec3::new(random.between(0.2, 1.5), random.between(0.2, 1.5), 0.0);
        let high = low + DVec3::new(random.between(0.3, 2.0), random.between(0.3, 2.0), random.between(0.2, 1.4));
        let standing = cuboid(low, high);
        let base = (high - low).x * (high - low).y;
        let all: f64 = standing[bottom..].iter().map(|side| add(wall, *side)).sum();
        // What it stands on sees nothing, nor does its bottom.
        seen += all - base - if bottom == 0 { base } else { 0.0 };
        let dark = base + if bottom == 0 { base } else { 0.0 };
        let low = DVec3::new(random.between(0.2, 2.5), random.between(0.2, 2.5), 1.6);
        seen += cuboid(low, low + DVec3::new(0.7, 1.1, 1.0)).iter().map(|side| add(wall, *side)).sum::<f64>();
        // Where the lit side is the floor a part of what it emits goes nowhere.
        let below = if case == 0 { base } else { 0.0 };
        let options = Options { error: 0.02, ..Options::default() };
        let solution = solve(&scene, &options, |_| true).unwrap();
        let exact = ((emitted - below) / (1.0 - rho) + below) / (seen + dark);
        let (off, bound) = ((solution.mean()[0] - exact).abs(), solution.mean_bound()[0].total());
        // What evaluations may be off by is a small part of the error asked for.
        let close = 1.01 * off + 0.05 * options.error * exact;
        assert!(off <= bound && bound <= close, "case {case}: {exact} off by {off:e}, bound {bound:e}");
    }
}

/// Bounds that were a tenth of what they are would not hold: of light that is reflected once all is known at every point.
#[test]
fn some_errors_are_more_than_a_tenth_of_their_bounds() {
    let mut scene = Scene::new(["grey"]).unwrap();
    let surface = scene.add_surface("all");
    let [lamp, floor] = [(0.0, 1.0), (0.5, 0.0)].map(|(rho, radiance)| scene.add_material("of", [rho], [radiance]).unwrap());
    let rectangle = |corners: [[f64; 3]; 4]| Polygon::new(corners.map(DVec3::from).to_vec()).unwrap();
    let low = rectangle([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
    let high = rectangle([[0.0, 0.0, 1.0], [0.0, 0.2, 1.0], [0.3, 0.2, 1.0], [0.3, 0.0, 1.0]]);
    scene.add_face(surface, floor, low, None).unwrap();
    scene.add_face(surface, lamp, high, None).unwrap();
    for degree in 0..3 {
        let options = Options { error: 0.5, degree: Some(degree), first_elements: 1, most_elements: 2, ..Options::default() };
        let solution = solve(&scene, &options, |_| true).unwrap();
        let mut nearest = 0.0_f64;
        for leaf in solution.mesh.leaves().filter(|&leaf| solution.mesh.elements()[leaf].face() == 0) {
            let bound = solution.bound_on(leaf)[0].total();
            let at = |i: u32| (f64::from(i) + 0.5) / 12.0;
            for reference in (0..12).flat_map(|i| (0..12).map(move |j| [at(i), at(j)])) {
                let point = solution.mesh.elements()[leaf].point(reference);
                let truth = solution.gather(point, DVec3::Z).unwrap();
                let off = (solution.value_on(leaf, 0, reference) - truth.radiosity[0]).abs();
                let known = truth.ledger[0].total();
                assert!(off <= bound + known, "degree {degree}: {off:e} with {bound:e} at {point}");
                nearest = largest(nearest, (off - known) / bound);
            }
        }
        println!("degree {degree}: the nearest is {nearest:.2} of its bound");
        assert!(nearest > [0.5, 0.1, 0.05][degree], "degree {degree}: {nearest}");
    }
}
