//! Many emitters together: within the stated bound of the sum over all of them, one by one, and with far fewer evaluations.

use radgrad_core::batch::{Answers, EmitterTree, Emitters, Engine, Receivers, Tally};
use radgrad_core::{DVec3, Emission, Emitter, Error, Polygon, Receiver, evaluate};
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

fn vector(random: &mut ChaCha8Rng) -> DVec3 {
    DVec3::from([(); 3].map(|()| random.random_range(-1.0..1.0)))
}

/// A patch `corner + u a + v b` in `side` by `side` cells, of triangles or of quadrilaterals, each with its own emission.
fn patch(lamps: &mut Vec<Emitter>, place: impl Fn(f64, f64) -> DVec3, side: usize, triangles: bool, random: &mut ChaCha8Rng) {
    let vertex = |i: usize, j: usize| place(i as f64 / side as f64, j as f64 / side as f64);
    for i in 0..side {
        for j in 0..side {
            let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
            let cells = if triangles { vec![vec![a, b, c], vec![a, c, d]] } else { vec![vec![a, b, c, d]] };
            for vertices in cells {
                if let Ok(polygon) = Polygon::new(vertices) {
                    lamps.push(Emitter::new(polygon, Emission::Constant(random.random_range(0.1..1.0))).unwrap());
                }
            }
        }
    }
}

/// The same outlines with linear emission, here and there below zero.
fn linear(lamps: &[Emitter], random: &mut ChaCha8Rng) -> Vec<Emitter> {
    lamps
        .iter()
        .map(|lamp| {
            let polygon = lamp.polygon().clone();
            let emission = if polygon.vertices().len() == 3 {
                Emission::at_vertices([(); 3].map(|()| random.random_range(-0.1..1.0)).to_vec())
            } else {
                Emission::gradient(random.random_range(0.1..1.0), vector(random) / polygon.size() * 0.5)
            };
            Emitter::new(polygon, emission).unwrap()
        })
        .collect()
}

/// A room of 5 by 4 by 3 lit from its six walls, with a lit ball in it.
fn room(side: usize, random: &mut ChaCha8Rng) -> Vec<Emitter> {
    let mut lamps = Vec::new();
    let (x, y, z) = (DVec3::X * 5.0, DVec3::Y * 4.0, DVec3::Z * 3.0);
    let walls = [(DVec3::ZERO, x, y), (z, y, x), (DVec3::ZERO, y, z), (x, z, y), (DVec3::ZERO, z, x), (y, x, z)];
    for (k, (corner, a, b)) in walls.into_iter().enumerate() {
        patch(&mut lamps, |u, v| corner + a * u + b * v, side, k % 3 != 1, random);
    }
    let ball = |u: f64, v: f64| {
        let (theta, phi) = (std::f64::consts::PI * u, std::f64::consts::TAU * v);
        let direction = DVec3::new(libm::sin(theta) * libm::cos(phi), libm::sin(theta) * libm::sin(phi), libm::cos(theta));
        DVec3::new(2.0, 1.5, 1.2) + direction * 0.5
    };
    patch(&mut lamps, ball, side, true, random);
    lamps
}

/// Receivers on the walls, facing inwards, and anywhere facing anywhere.
fn receivers(count: usize, random: &mut ChaCha8Rng) -> Vec<(DVec3, DVec3)> {
    let size = DVec3::new(5.0, 4.0, 3.0);
    (0..count)
        .map(|i| {
            let (x, n) = ((vector(random) + 1.0) * 0.5 * size, vector(random));
            if i % 2 == 1 {
                return (x, n);
            }
            let (axis, far) = (i / 2 % 3, i / 6 % 2);
            let (mut x, mut n) = (x.to_array(), [0.0; 3]);
            x[axis] = size.to_array()[axis] * far as f64;
            n[axis] = 1.0 - 2.0 * far as f64;
            (x.into(), n.into())
        })
        .collect()
}

fn total(engine: Engine, points: &[(DVec3, DVec3)], tree: &EmitterTree<'_>, tolerance: f64) -> (Answers, Tally) {
    let array = |part: fn(&(DVec3, DVec3)) -> DVec3, axis: usize| -> Vec<f64> {
        points.iter().map(|point| part(point).to_array()[axis]).collect()
    };
    let [x, y, z] = [0, 1, 2].map(|axis| array(|point| point.0, axis));
    let [nx, ny, nz] = [0, 1, 2].map(|axis| array(|point| point.1, axis));
    let receivers = Receivers::new([&x, &y, &z], [&nx, &ny, &nz], &[0.5]).unwrap();
    let mut answers = Answers::new();
    let tally = engine.total(&receivers, tree, tolerance, &mut answers).unwrap();
    (answers, tally)
}

/// The sum over all emitters one by one, and a bound on its error.
fn one_by_one((x, n): (DVec3, DVec3), emitters: &Emitters<'_>) -> (f64, f64) {
    let mut each = Answers::new();
    let receiver = Receiver::new(x, n, 0.5).unwrap();
    Engine::new().each_to(&receiver, emitters, 1e-6, &mut each).unwrap();
    let size: f64 = each.radiosity.iter().map(|value| value.abs()).sum();
    (each.radiosity.iter().sum(), each.radiosity_error.iter().sum::<f64>() + emitters.count() as f64 * f64::EPSILON * size)
}

/// Holds the sums of emitters at points against the sums one by one, to five tolerances; the largest error over its bound.
fn nearest_to_its_bound(lamps: &[Emitter], points: &[(DVec3, DVec3)]) -> f64 {
    let (tree, emitters) = (EmitterTree::new(lamps), Emitters::new(lamps));
    let truth: Vec<(f64, f64)> = points.iter().map(|point| one_by_one(*point, &emitters)).collect();
    let mut closest = 0.0f64;
    for tolerance in [0.3, 1e-2, 1e-4, 1e-6, 1e-9] {
        let (answers, tally) = total(Engine::new(), points, &tree, tolerance);
        for (i, (truth, truth_error)) in truth.iter().enumerate() {
            let (value, error) = (answers.radiosity[i], answers.radiosity_error[i]);
            let share = (value - truth).abs() / (error + truth_error);
            assert!(share <= 1.0, "{:?} within {tolerance:e}: {value} +- {error:e} is not {truth}", points[i]);
            assert!(error <= tolerance, "{:?}: {error:e} > {tolerance:e}", points[i]);
            closest = closest.max(share);
        }
        println!("{tolerance:e}: {tally:?}");
        let decided = tally.below + tally.behind + tally.weak + tally.together + tally.alone;
        assert_eq!(decided, (points.len() * lamps.len()) as u64, "every emitter is in one count");
        assert!(tolerance < 1e-5 || tally.together > tally.alone, "{tally:?}");
    }
    println!("nearest to its bound: {closest:.3}");
    closest
}

#[test]
fn the_sum_is_within_its_bound_and_the_bound_within_the_tolerance() {
    let mut random = ChaCha8Rng::seed_from_u64(21);
    let mut lamps = room(24, &mut random);
    // A tilted sheet, a far one, a negative one, a concave emitter and a linear one.
    let (a, b) = (DVec3::new(0.7, 0.1, 0.3), DVec3::new(-0.2, 0.8, 0.1));
    patch(&mut lamps, |u, v| DVec3::new(3.0, 2.0, 0.5) + a * u + b * v, 20, false, &mut random);
    patch(&mut lamps, |u, v| DVec3::new(300.0, 2.0, 0.5) - b * (40.0 * u) + a * (40.0 * v), 12, true, &mut random);
    for lamp in &mut lamps[200..260] {
        *lamp = Emitter::new(lamp.polygon().clone(), Emission::Constant(-0.5)).unwrap();
    }
    let concave = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.5, 0.25), (0.0, 1.0)].map(|(u, v)| DVec3::new(u, v, 2.5)).to_vec();
    let concave = Polygon::new(concave.into_iter().rev().collect()).unwrap();
    lamps.push(Emitter::new(concave.clone(), Emission::Constant(1.0)).unwrap());
    lamps.push(Emitter::new(concave, Emission::gradient(1.0, DVec3::X * 0.5)).unwrap());
    let closest = nearest_to_its_bound(&lamps, &receivers(40, &mut random));
    assert!(closest > 0.05, "the bounds say something");
}

#[test]
fn the_sum_of_linear_emitters_is_within_its_bound_and_the_bound_within_the_tolerance() {
    let mut random = ChaCha8Rng::seed_from_u64(27);
    let lamps = room(24, &mut random);
    let mut lamps = linear(&lamps, &mut random);
    let even = lamps[0].polygon().clone();
    lamps.push(Emitter::new(even, Emission::Constant(0.5)).unwrap());
    let closest = nearest_to_its_bound(&lamps, &receivers(40, &mut random));
    assert!(closest > 0.01, "the bounds say something");
}

#[test]
fn a_thousand_receivers_of_a_hundred_thousand_emitters_cost_a_twentieth_of_all_pairs() {
    let mut random = ChaCha8Rng::seed_from_u64(22);
    let lamps = room(94, &mut random);
    let (tree, emitters) = (EmitterTree::new(&lamps), Emitters::new(&lamps));
    let points = receivers(1000, &mut random);
    let truth: Vec<(f64, f64)> = points[..8].iter().map(|point| one_by_one(*point, &emitters)).collect();
    let mean = truth.iter().map(|truth| truth.0).sum::<f64>() / truth.len() as f64;
    let (answers, tally) = total(Engine::new(), &points, &tree, 1e-6 * mean);
    for (i, (truth, error)) in truth.iter().enumerate() {
        assert!((answers.radiosity[i] - truth).abs() <= answers.radiosity_error[i] + error);
        assert!(answers.radiosity_error[i] <= 1e-6 * mean);
    }
    let pairs = (lamps.len() * points.len()) as u64;
    println!("{} emitters: {tally:?}, {:.1} times fewer", lamps.len(), pairs as f64 / (tally.alone + tally.far_fields) as f64);
    assert!(lamps.len() >= 100_000 && 20 * (tally.alone + tally.far_fields) <= pairs, "{tally:?}");
}

#[test]
fn cost_grows_more_slowly_than_the_number_of_emitters() {
    let cost = |side: usize| {
        let mut random = ChaCha8Rng::seed_from_u64(23);
        let lamps = room(side, &mut random);
        let tree = EmitterTree::new(&lamps);
        let (_, tally) = total(Engine::new(), &receivers(60, &mut random), &tree, 1e-5);
        (lamps.len() as f64, (tally.alone + tally.far_fields) as f64)
    };
    let ((few, cheap), (many, dear)) = (cost(20), cost(80));
    assert!(many > 15.0 * few && dear < 4.0 * cheap, "{few} {cheap} {many} {dear}");
}

#[test]
fn instruction_sets_threads_and_neighbours_do_not_change_a_sum() {
    let mut random = ChaCha8Rng::seed_from_u64(24);
    let lamps = room(16, &mut random);
    let tree = EmitterTree::new(&lamps);
    let points = receivers(300, &mut random);
    let (first, tally) = total(Engine::new(), &points, &tree, 1e-5);
    for engine in Engine::all().into_iter().flat_map(|engine| [engine, engine.threads()]) {
        let again = total(engine, &points, &tree, 1e-5);
        assert!(again.0 == first && again.1 == tally, "{engine}");
    }
    let (some, _) = total(Engine::new(), &points[100..177], &tree, 1e-5);
    assert_eq!(some.radiosity, first.radiosity[100..177]);
    assert_eq!(some.radiosity_error, first.radiosity_error[100..177]);
}

#[test]
fn what_is_out_of_sight_is_exactly_zero_and_a_wrong_tolerance_refused() {
    let mut random = ChaCha8Rng::seed_from_u64(25);
    let mut lamps = Vec::new();
    patch(&mut lamps, |u, v| DVec3::new(u, v, 1.0), 16, true, &mut random);
    let tree = EmitterTree::new(&lamps);
    // The sheet faces up: below it there is nothing to see, and above it nothing for who looks up.
    let points = [(DVec3::new(0.5, 0.5, 0.0), DVec3::Z), (DVec3::new(0.5, 0.5, 2.0), DVec3::Z), (DVec3::ONE, DVec3::X)];
    let (answers, tally) = total(Engine::new(), &points, &tree, 1e-3);
    assert_eq!((&answers.radiosity[..2], &answers.radiosity_error[..2]), (&[0.0; 2][..], &[0.0; 2][..]));
    assert!(tally.behind + tally.below >= 1024, "{tally:?}");
    let truth: f64 = lamps
        .iter()
        .map(|lamp| evaluate(&Receiver::new(points[2].0, points[2].1, 0.5).unwrap(), lamp, &[]).unwrap().radiosity)
        .sum();
    assert!((answers.radiosity[2] - truth).abs() <= answers.radiosity_error[2]);
    let receivers = Receivers::new([&[0.0], &[0.0], &[0.0]], [&[0.0], &[0.0], &[1.0]], &[1.0]).unwrap();
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let refused = Engine::new().total(&receivers, &tree, tolerance, &mut Answers::new());
        assert!(matches!(refused, Err(Error::AbsoluteTolerance { .. })));
    }
    let none = EmitterTree::new(&[]);
    assert_eq!(total(Engine::new(), &points, &none, 1.0).0.radiosity, [0.0; 3]);
}
