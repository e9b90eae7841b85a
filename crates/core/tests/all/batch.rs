//! Batches against the scalar path: within both bounds, in every regime, on every instruction set, at every length.

use radgrad_core::batch::{Answers, Emitters, Engine, Precision, Receivers};
use radgrad_core::{Answer, DVec3, Emission, Emitter, Error, Method, Polygon, Receiver, evaluate, radiosity_and_gradient};
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

/// Receivers as a structure of arrays of their own.
struct Points<F> {
    position: [Vec<F>; 3],
    normal: [Vec<F>; 3],
    reflectance: Vec<F>,
}

impl<F: Precision> Points<F> {
    fn new(points: &[(DVec3, DVec3, f64)], round: impl Fn(f64) -> F) -> Self {
        let along = |part: fn(&(DVec3, DVec3, f64)) -> DVec3| {
            [0, 1, 2].map(|axis| points.iter().map(|point| round(part(point).to_array()[axis])).collect())
        };
        let reflectance = points.iter().map(|point| round(point.2)).collect();
        Self { position: along(|point| point.0), normal: along(|point| point.1), reflectance }
    }

    fn receivers(&self) -> Receivers<'_, F> {
        let [x, y, z] = &self.position;
        let [nx, ny, nz] = &self.normal;
        Receivers::new([x, y, z], [nx, ny, nz], &self.reflectance).unwrap()
    }
}

#[allow(clippy::cast_possible_truncation, reason = "to the nearest")]
fn narrow(value: f64) -> f32 {
    value as f32
}

fn uniform(random: &mut ChaCha8Rng) -> DVec3 {
    DVec3::from([(); 3].map(|()| random.random_range(-1.0..1.0)))
}

/// Rounded to single precision, so that both precisions are given the same.
fn single(v: DVec3) -> DVec3 {
    v.as_vec3().as_dvec3()
}

/// A triangle, a square across an axis, or a concave pentagon in a plane of two integer directions.
fn emitter(random: &mut ChaCha8Rng, kind: usize) -> Emitter {
    let whole = |random: &mut ChaCha8Rng| DVec3::from([(); 3].map(|()| f64::from(random.random_range(-3..4))));
    let emission = Emission::Constant(random.random_range(-1.0..3.0));
    loop {
        let vertices: Vec<DVec3> = match kind % 3 {
            0 => (0..3).map(|_| single(uniform(random))).collect(),
            1 => {
                let z = f64::from(random.random_range(-2..3)) * 0.5;
                [(0.0, 0.0), (1.0, 0.0), (1.0, 1.5), (0.0, 1.5)].map(|(x, y)| DVec3::new(x, y, z)).to_vec()
            }
            _ => {
                let (a, b) = (whole(random), whole(random));
                let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.5, 0.25), (0.0, 1.0)];
                corners.map(|(u, v)| (a * u + b * v) * 0.25).to_vec()
            }
        };
        let turned: Vec<DVec3> = if random.random() { vertices } else { vertices.into_iter().rev().collect() };
        if let Ok(polygon) = Polygon::new(turned) {
            return Emitter::new(polygon, emission).unwrap();
        }
    }
}

/// The same outline with an affine emission, by values at the vertices of a triangle or by its gradient.
fn linear(random: &mut ChaCha8Rng, lamp: &Emitter) -> Emitter {
    let polygon = lamp.polygon().clone();
    let emission = if polygon.vertices().len() == 3 {
        Emission::at_vertices((0..3).map(|_| random.random_range(-1.0..3.0)).collect())
    } else {
        Emission::gradient(random.random_range(-1.0..3.0), uniform(random) / polygon.size())
    };
    Emitter::new(polygon, emission).unwrap()
}

/// Receivers of all kinds around a polygon.
fn points(random: &mut ChaCha8Rng, polygon: &Polygon, count: usize) -> Vec<(DVec3, DVec3, f64)> {
    let vertices = polygon.vertices();
    let middle = vertices.iter().sum::<DVec3>() / vertices.len() as f64;
    let point = |random: &mut ChaCha8Rng, i: usize| {
        let (corner, next) = (vertices[i % vertices.len()], vertices[(i + 1) % vertices.len()]);
        let towards = |x: DVec3, random: &mut ChaCha8Rng| middle - x + uniform(random) * 0.5 * (middle - x).length();
        let power = |random: &mut ChaCha8Rng, low: f64, high: f64| libm::exp10(random.random_range(low..high));
        match i % 10 {
            // Anywhere near, in any direction.
            0 | 1 => (uniform(random) * 2.0, uniform(random)),
            // Facing it, from near to far.
            2 | 3 => {
                let x = middle + (polygon.normal() + uniform(random)) * power(random, -1.0, 3.0);
                (x, towards(x, random))
            }
            // Close to its plane.
            4 => {
                let x = middle
                    + uniform(random).reject_from_normalized(polygon.normal())
                    + polygon.normal() * power(random, -8.0, 0.0);
                (x, uniform(random))
            }
            // Close to an edge or its extension.
            5 => {
                let x = corner.lerp(next, random.random_range(-1.0..2.0)) + uniform(random) * power(random, -9.0, -1.0);
                (x, uniform(random))
            }
            // With a vertex on the horizon, or two.
            6 => {
                let x = uniform(random) * 2.0;
                (x, (corner - x).cross(uniform(random)))
            }
            7 => {
                let x = DVec3::new(random.random_range(-2.0..2.0), random.random_range(-2.0..2.0), corner.z);
                (x, if i.is_multiple_of(4) { DVec3::Z } else { DVec3::X })
            }
            // In its plane, or with the horizon along an axis.
            8 => (corner.lerp(next, random.random_range(-1.0..2.0)), uniform(random)),
            _ => (DVec3::new(0.5, 0.5, f64::from(random.random_range(-4..4)) * 0.5), [DVec3::X, DVec3::NEG_Z, DVec3::Z][i % 3]),
        }
    };
    (0..count)
        .map(|i| {
            let (position, normal) = point(random, i);
            let normal = if normal.length() < 1e-3 { DVec3::X } else { normal };
            (single(position), single(normal), f64::from(random.random_range(0..9)) * 0.125)
        })
        .collect()
}

fn receiver((position, normal, reflectance): (DVec3, DVec3, f64)) -> Receiver {
    Receiver::new(position, normal, reflectance).unwrap()
}

fn entry<F: Precision + Into<f64>>(answers: &Answers<F>, i: usize) -> (f64, DVec3, f64, f64) {
    let gradient = DVec3::from(answers.gradient.each_ref().map(|array| array[i].into()));
    (answers.radiosity[i].into(), gradient, answers.radiosity_error[i].into(), answers.gradient_error[i].into())
}

/// Checks an entry of a batch against a certified answer to a tight tolerance.
fn agrees<F: Precision + Into<f64>>(answers: &Answers<F>, i: usize, truth: &Answer, place: &dyn Fn() -> String) {
    let (radiosity, gradient, radiosity_error, gradient_error) = entry(answers, i);
    assert!(
        (radiosity - truth.radiosity).abs() <= radiosity_error + truth.radiosity_error,
        "{}: {radiosity} +- {radiosity_error:e} is not {} +- {:e}",
        place(),
        truth.radiosity,
        truth.radiosity_error
    );
    assert!(
        (gradient - truth.gradient).length() <= gradient_error + truth.gradient_error,
        "{}: {gradient} +- {gradient_error:e} is not {} +- {:e}",
        place(),
        truth.gradient,
        truth.gradient_error
    );
    if truth.radiosity == 0.0 && truth.radiosity_error == 0.0 {
        assert_eq!((radiosity, gradient, radiosity_error, gradient_error), (0.0, DVec3::ZERO, 0.0, 0.0), "{}", place());
    }
}

#[test]
fn batches_agree_with_the_scalar_path_within_both_bounds() {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let (mut double, mut float) = (Answers::new(), Answers::new());
    let (mut whole, mut clipped, mut zero) = (0, 0, 0);
    for kind in 0..60 {
        let lamp = emitter(&mut random, kind);
        let points = points(&mut random, lamp.polygon(), 300);
        let truth: Vec<Answer> = points.iter().map(|point| evaluate(&receiver(*point), &lamp, &[]).unwrap()).collect();
        let (wide, narrow) = (Points::new(&points, |v| v), Points::new(&points, narrow));
        for tolerance in [1e-3, 1e-8, 1e-12] {
            Engine::new().evaluate_to(&wide.receivers(), &lamp, tolerance, &mut double).unwrap();
            Engine::new().evaluate_to(&narrow.receivers(), &lamp, tolerance, &mut float).unwrap();
            for (method, counts) in [(&double.method, double.counts), (&float.method, float.counts)] {
                let zeros = method.iter().filter(|method| **method == Method::Zero).count();
                let on_lanes = method.iter().filter(|method| **method == Method::ClosedForm).count();
                assert_eq!((zeros, method.len()), (counts.zero, points.len()), "emitter {kind}");
                assert!(on_lanes + counts.doubled >= counts.whole + counts.clipped, "emitter {kind}: {counts:?}, {on_lanes}");
            }
            for (i, truth) in truth.iter().enumerate() {
                let place = || format!("emitter {kind}, receiver {i}: {:?} to {tolerance:e}", points[i]);
                agrees(&double, i, truth, &place);
                agrees(&float, i, truth, &place);
                let allowed = tolerance * double.radiosity[i].abs() * (1.0 + 1e-9);
                assert!(double.radiosity_error[i] <= allowed, "{}", place());
            }
            let counts = double.counts;
            assert_eq!(counts.zero + counts.whole + counts.clipped + counts.single, points.len());
            (whole, clipped, zero) = (whole + counts.whole, clipped + counts.clipped, zero + counts.zero);
        }
    }
    println!("{whole} whole, {clipped} clipped, {zero} zero");
    assert!(whole > 10_000 && clipped > 3_000 && zero > 10_000);
}

#[test]
fn linear_batches_agree_with_the_scalar_path_within_both_bounds() {
    let mut random = ChaCha8Rng::seed_from_u64(21);
    let (mut double, mut float) = (Answers::new(), Answers::new());
    let (mut whole, mut clipped, mut single) = (0, 0, 0);
    let (mut nearest, mut typical) = ([0.0f64; 2], Vec::new());
    for kind in 0..60 {
        let lamp = emitter(&mut random, kind);
        let lamp = linear(&mut random, &lamp);
        let points = points(&mut random, lamp.polygon(), 300);
        let truth: Vec<Answer> = points.iter().map(|point| evaluate(&receiver(*point), &lamp, &[]).unwrap()).collect();
        let (wide, narrow) = (Points::new(&points, |v| v), Points::new(&points, narrow));
        for tolerance in [1.0, 1e-5, 1e-10] {
            Engine::new().evaluate_to(&wide.receivers(), &lamp, tolerance, &mut double).unwrap();
            Engine::new().evaluate_to(&narrow.receivers(), &lamp, tolerance, &mut float).unwrap();
            for (i, truth) in truth.iter().enumerate() {
                let place = || format!("emitter {kind} {lamp:?}, receiver {i}: {:?} to {tolerance:e}", points[i]);
                agrees(&double, i, truth, &place);
                agrees(&float, i, truth, &place);
                if tolerance == 1.0 && truth.radiosity != 0.0 {
                    let (value, gradient, value_error, gradient_error) = entry(&double, i);
                    let shares =
                        [(value - truth.radiosity).abs() / value_error, (gradient - truth.gradient).length() / gradient_error];
                    nearest = [nearest[0].max(shares[0]), nearest[1].max(shares[1])];
                    typical.push(shares[0].max(shares[1]));
                }
            }
            let counts = double.counts;
            assert_eq!(counts.zero + counts.whole + counts.clipped + counts.single, points.len());
            (whole, clipped, single) = (whole + counts.whole, clipped + counts.clipped, single + counts.single);
        }
    }
    typical.sort_by(f64::total_cmp);
    println!(
        "{whole} whole, {clipped} clipped, {single} one by one; errors over bounds: {nearest:?}, {}",
        typical[typical.len() / 2]
    );
    assert!(whole > 8_000 && clipped > 3_000);
}

/// Three triangles are among the receivers and emitters. Lanes answer where these surely hide nothing, the scalar path elsewhere.
#[test]
fn past_occluders_batches_agree_with_the_scalar_path_within_both_bounds() {
    let mut random = ChaCha8Rng::seed_from_u64(41);
    let (mut double, mut float, mut value, mut free) = (Answers::new(), Answers::new(), Answers::new(), Answers::new());
    let (mut hidden, mut same, mut on_lanes) = (0, 0, 0);
    for kind in 0..40 {
        let constant = emitter(&mut random, kind);
        let lamp = if kind % 4 == 3 { linear(&mut random, &constant) } else { constant };
        let mut triangle = || loop {
            let middle = uniform(&mut random);
            let corners = [(); 3].map(|()| single(middle + uniform(&mut random) * 0.2));
            if let Ok(polygon) = Polygon::new(corners.to_vec()) {
                return polygon;
            }
        };
        let screens = [triangle(), triangle(), triangle()];
        let screens: Vec<&Polygon> = screens.iter().collect();
        let points = points(&mut random, lamp.polygon(), 300);
        let (wide, narrow) = (Points::new(&points, |v| v), Points::new(&points, narrow));
        let engine = Engine::new().threads();
        engine.evaluate_occluded(&wide.receivers(), &lamp, &screens, 1e-8, &mut double).unwrap();
        engine.evaluate_occluded(&narrow.receivers(), &lamp, &screens, 1e-8, &mut float).unwrap();
        engine.radiosity_occluded(&wide.receivers(), &lamp, &screens, 1e-8, &mut value).unwrap();
        engine.evaluate_to(&wide.receivers(), &lamp, 1e-8, &mut free).unwrap();
        for (i, point) in points.iter().enumerate() {
            let place = || format!("emitter {kind}, receiver {i}: {point:?}");
            let truth = evaluate(&receiver(*point), &lamp, screens.iter().copied()).unwrap();
            agrees(&double, i, &truth, &place);
            agrees(&float, i, &truth, &place);
            let error = (value.radiosity[i] - truth.radiosity).abs();
            assert!(error <= value.radiosity_error[i] + truth.radiosity_error, "{}", place());
            hidden += usize::from((free.radiosity[i] - truth.radiosity).abs() > free.radiosity_error[i] + truth.radiosity_error);
            same += usize::from(entry(&free, i) == entry(&double, i) && free.radiosity[i] != 0.0);
        }
        let counts = double.counts;
        assert_eq!(counts.zero + counts.whole + counts.clipped + counts.single, points.len());
        on_lanes += counts.whole + counts.clipped;
    }
    println!("{hidden} hidden in part, {same} as without occluders, {on_lanes} on lanes");
    assert!(hidden > 300 && same > 1000 && on_lanes > 200);
}

#[test]
fn many_emitters_agree_with_the_scalar_path_within_both_bounds() {
    let mut random = ChaCha8Rng::seed_from_u64(12);
    // Mixed numbers of vertices, half of them linear, one dark.
    let mut lamps: Vec<Emitter> = (0..400).map(|kind| emitter(&mut random, kind % 7)).collect();
    for i in (1..lamps.len()).step_by(2) {
        lamps[i] = linear(&mut random, &lamps[i]);
    }
    let polygon = lamps[5].polygon().clone();
    lamps.push(Emitter::new(polygon.clone(), Emission::Constant(0.0)).unwrap());
    lamps.push(Emitter::new(polygon, Emission::gradient(1.0, DVec3::new(0.25, 0.0, 0.125))).unwrap());
    let (wide, narrow) = (Emitters::<f64>::new(&lamps), Emitters::<f32>::new(&lamps));
    let (mut double, mut float) = (Answers::new(), Answers::new());
    let mut counts = [0; 4];
    for (k, lamp) in (0..40).zip(lamps.iter().cycle().skip(3)) {
        for (m, point) in points(&mut random, lamp.polygon(), 10).into_iter().enumerate() {
            let point = receiver(point);
            Engine::new().each_to(&point, &wide, [1e-9, 1e-3, 1e-5][m % 3], &mut double).unwrap();
            Engine::new().each_to(&point, &narrow, 1e-4, &mut float).unwrap();
            let methods = double.counts;
            assert_eq!(methods.doubled, 0);
            for (sum, count) in counts.iter_mut().zip([methods.zero, methods.whole, methods.clipped, methods.single]) {
                *sum += count;
            }
            for (i, lamp) in lamps.iter().enumerate() {
                let truth = evaluate(&point, lamp, &[]).unwrap();
                agrees(&double, i, &truth, &|| format!("receiver {k}: {point:?}, emitter {i}"));
                agrees(&float, i, &truth, &|| format!("receiver {k}: {point:?}, emitter {i}, single precision"));
            }
        }
    }
    println!("zero, whole, clipped, one by one: {counts:?}");
    assert!(counts[1] > 20_000 && counts[2] > 10_000 && 5 * counts[3] < counts[1] + counts[2], "{counts:?}");
}

#[test]
fn an_emitter_among_many_has_the_digits_it_has_alone() {
    let mut random = ChaCha8Rng::seed_from_u64(41);
    let mut lamps: Vec<Emitter> = (0..60).map(|kind| emitter(&mut random, kind)).collect();
    for i in (1..lamps.len()).step_by(2) {
        lamps[i] = linear(&mut random, &lamps[i]);
    }
    let many = Emitters::<f64>::new(&lamps);
    let (mut each, mut alone) = (Answers::new(), Answers::new());
    let mut compared = 0;
    for point in points(&mut random, lamps[3].polygon(), 40) {
        Engine::new().each_to(&receiver(point), &many, 1e-6, &mut each).unwrap();
        let one = [point];
        let one = Points::new(&one, |v| v);
        for (i, lamp) in lamps.iter().enumerate() {
            Engine::new().evaluate_to(&one.receivers(), lamp, 1e-6, &mut alone).unwrap();
            if alone.counts.whole + alone.counts.clipped == 1 {
                let ((value, gradient, error, _), (other, other_gradient, other_error, _)) = (entry(&each, i), entry(&alone, 0));
                // n1 is normalised by one division or by three.
                assert!((value - other).abs() <= 0.1 * error.max(other_error), "{i}: {value} {other}");
                assert!((gradient - other_gradient).length() <= 0.1 * (entry(&each, i).3 + entry(&alone, 0).3), "{i}");
                compared += 1;
            }
        }
    }
    assert!(compared > 400, "{compared}");
}

/// Bits of all arrays.
fn bits(answers: &Answers<f64>) -> Vec<u64> {
    let arrays = answers.gradient.iter().chain([&answers.radiosity, &answers.radiosity_error, &answers.gradient_error]);
    arrays.flatten().map(|value| value.to_bits()).collect()
}

#[test]
fn instruction_sets_and_threads_give_the_same_digits() {
    let mut random = ChaCha8Rng::seed_from_u64(13);
    for kind in 0..18 {
        let lamp = emitter(&mut random, kind);
        let lamp = if kind < 9 { lamp } else { linear(&mut random, &lamp) };
        let points = points(&mut random, lamp.polygon(), 777);
        let (wide, narrow) = (Points::new(&points, |v| v), Points::new(&points, narrow));
        let mut first: Option<(Vec<u64>, Answers<f32>, _)> = None;
        for engine in Engine::all().into_iter().flat_map(|engine| [engine, engine.threads()]) {
            let (mut double, mut float) = (Answers::new(), Answers::new());
            engine.evaluate_to(&wide.receivers(), &lamp, 1e-9, &mut double).unwrap();
            engine.radiosity_and_gradient(&narrow.receivers(), &lamp, &mut float).unwrap();
            let digits = (bits(&double), float, double.counts);
            let first = first.get_or_insert_with(|| digits.clone());
            assert!(*first == digits, "{engine:?}, emitter {kind}");
        }
    }
}

#[test]
fn an_answer_does_not_depend_on_its_neighbours() {
    let mut random = ChaCha8Rng::seed_from_u64(14);
    let lamp = emitter(&mut random, 0);
    for lamp in [lamp.clone(), linear(&mut random, &lamp)] {
        let points = points(&mut random, lamp.polygon(), 300);
        let answers = |points: &[(DVec3, DVec3, f64)]| {
            let mut answers = Answers::new();
            Engine::new().evaluate_to(&Points::new(points, |v| v).receivers(), &lamp, 1e-9, &mut answers).unwrap();
            answers
        };
        let batch = answers(&points);
        for (start, length) in
            [(0, 1), (7, 1), (1, 2), (3, 5), (8, 15), (5, 16), (0, 17), (100, 127), (9, 128), (9, 129), (1, 299)]
        {
            let some = answers(&points[start..start + length]);
            for i in 0..length {
                assert_eq!(entry(&some, i), entry(&batch, start + i), "{start} {length}: {i}");
            }
        }
        assert_eq!(answers(&[]).radiosity, Vec::<f64>::new());
    }
}

#[test]
fn without_bounds_the_digits_are_those_with_them() {
    let mut random = ChaCha8Rng::seed_from_u64(15);
    let lamp = emitter(&mut random, 0);
    let given = points(&mut random, lamp.polygon(), 500);
    let points = Points::new(&given, |v| v);
    let (mut value, mut both, mut bounded) = (Answers::new(), Answers::new(), Answers::new());
    Engine::new().radiosity(&points.receivers(), &lamp, &mut value).unwrap();
    Engine::new().radiosity_and_gradient(&points.receivers(), &lamp, &mut both).unwrap();
    Engine::new().evaluate_to(&points.receivers(), &lamp, 1e-6, &mut bounded).unwrap();
    assert!(value.gradient[0].is_empty() && value.radiosity_error.is_empty() && both.gradient_error.is_empty());
    assert!(value.counts.single <= both.counts.single, "the value alone asks for less");
    let mut same = 0;
    for (i, given) in given.iter().enumerate() {
        let scalar = radiosity_and_gradient(&receiver(*given), &lamp).unwrap();
        let gradient = |answers: &Answers<f64>| DVec3::from(answers.gradient.each_ref().map(|array| array[i]));
        let plain = (both.radiosity[i], gradient(&both));
        let on_lanes = plain == (bounded.radiosity[i], gradient(&bounded));
        assert!(on_lanes || plain == scalar, "{given:?}");
        assert!([both.radiosity[i], bounded.radiosity[i], scalar.0].contains(&value.radiosity[i]), "{given:?}");
        same += usize::from(on_lanes);
    }
    assert!(same > 400, "{same}");
}

#[test]
fn scaling_a_scene_by_a_power_of_two_scales_the_digits() {
    let mut random = ChaCha8Rng::seed_from_u64(16);
    let lamp = emitter(&mut random, 0);
    let points = points(&mut random, lamp.polygon(), 200);
    let answers = |scale: f64| {
        let vertices = lamp.polygon().vertices().iter().map(|v| *v * scale).collect();
        let lamp = Emitter::new(Polygon::new(vertices).unwrap(), lamp.emission().clone()).unwrap();
        let scaled: Vec<_> = points.iter().map(|(x, n, rho)| (*x * scale, *n, *rho)).collect();
        let mut answers = Answers::new();
        Engine::new().evaluate_to(&Points::new(&scaled, |v| v).receivers(), &lamp, 1e-6, &mut answers).unwrap();
        answers
    };
    let unscaled = answers(1.0);
    for exponent in [-300, -40, 3, 29, 200] {
        let scale = 2f64.powi(exponent);
        let scaled = answers(scale);
        assert_eq!(scaled.radiosity, unscaled.radiosity, "2^{exponent}");
        for (scaled, unscaled) in scaled.gradient.iter().zip(&unscaled.gradient) {
            assert!(scaled.iter().zip(unscaled).all(|(scaled, unscaled)| scaled * scale == *unscaled), "2^{exponent}");
        }
    }
}

#[test]
fn single_precision_errs_by_a_millionth_where_it_does_not_hand_over() {
    let mut random = ChaCha8Rng::seed_from_u64(17);
    let (mut worst, mut squares, mut count, mut lanes) = ([0.0f64; 2], [0.0f64; 2], 0.0, 0);
    for kind in 0..60 {
        let lamp = emitter(&mut random, kind);
        let points = points(&mut random, lamp.polygon(), 300);
        let mut answers = Answers::new();
        Engine::new().radiosity_and_gradient(&Points::new(&points, narrow).receivers(), &lamp, &mut answers).unwrap();
        lanes += answers.counts.whole + answers.counts.clipped - answers.counts.doubled.min(answers.counts.whole);
        for (i, point) in points.iter().enumerate() {
            let truth = evaluate(&receiver(*point), &lamp, &[]).unwrap();
            if truth.radiosity == 0.0 {
                assert_eq!(answers.radiosity[i], 0.0);
                continue;
            }
            let gradient = DVec3::from(answers.gradient.each_ref().map(|array| f64::from(array[i])));
            let errors = [
                (f64::from(answers.radiosity[i]) / truth.radiosity - 1.0).abs(),
                (gradient - truth.gradient).length() / truth.gradient.length(),
            ];
            if errors[0] > 1e-6 || errors[1] > 5e-6 {
                // The scalar path has no more digits either.
                let scalar = radiosity_and_gradient(&receiver(*point), &lamp).unwrap();
                assert_eq!((answers.radiosity[i], gradient), (narrow(scalar.0), single(scalar.1)), "{point:?}");
                continue;
            }
            for k in 0..2 {
                worst[k] = worst[k].max(errors[k]);
                squares[k] += errors[k] * errors[k];
            }
            count += 1.0;
        }
    }
    let typical = squares.map(|square| (square / count).sqrt());
    println!("worst {worst:?}, root mean square {typical:?}, {lanes} lanes of {count}");
    assert!(typical[0] < 1e-7 && typical[1] < 2e-7, "{typical:?}");
    assert!(count > 7000.0 && lanes > 2000);
}

#[test]
fn wrong_inputs_are_named() {
    let (good, bad) = (vec![1.0; 20], (0..20).map(|i| if i == 13 { f64::NAN } else { 0.5 }).collect::<Vec<_>>());
    let zero = vec![0.0; 20];
    let error = Receivers::new([&good, &bad, &good], [&good, &good, &good], &[1.0]).unwrap_err();
    assert!(matches!(error, Error::InBatch { index: 13, .. }), "{error}");
    assert!(Receivers::new([&good, &good, &good], [&zero, &zero, &zero], &[1.0]).is_err());
    assert!(Receivers::new([&good, &good, &good], [&good, &zero, &zero], &good[..7]).is_err());
    assert!(Receivers::new([&good, &good, &good], [&good, &zero, &zero], &[1.5]).is_err());
    let receivers = Receivers::new([&good, &good, &good], [&good, &zero, &zero], &good).unwrap();
    let lamp = emitter(&mut ChaCha8Rng::seed_from_u64(1), 0);
    let refused = Engine::new().evaluate_to(&receivers, &lamp, f64::NAN, &mut Answers::new());
    assert!(matches!(refused, Err(Error::Tolerance { .. })));
    let bright = Emitter::new(lamp.polygon().clone(), Emission::Constant(1e300)).unwrap();
    let few = [3.0f32; 2];
    let single = Receivers::new([&few, &few, &few], [&[-1.0, -1.0], &[-1.0, -1.0], &[-1.0, -1.0]], &[1.0]).unwrap();
    let mut answers = Answers::new();
    let result = Engine::new().radiosity(&single, &bright, &mut answers);
    assert!(answers.radiosity == [0.0; 2] || matches!(result, Err(Error::InBatch { index: 0, .. })), "{result:?}");
}

#[test]
fn extreme_normals_and_brightness_are_left_to_the_scalar_path() {
    let mut random = ChaCha8Rng::seed_from_u64(18);
    let lamp = emitter(&mut random, 0);
    for (length, brightness, reflectance) in
        [(1e-161, 1.0, 1.0), (1e200, 1.0, 1.0), (1.0, 1e-307, 0.5), (1.0, 1.0, 1e-320), (1.0, 1e307, 1.0)]
    {
        let lamp = Emitter::new(lamp.polygon().clone(), Emission::Constant(brightness)).unwrap();
        let points: Vec<_> =
            points(&mut random, lamp.polygon(), 200).iter().map(|(x, n, _)| (*x, *n * length, reflectance)).collect();
        let mut answers = Answers::new();
        let result = Engine::new().evaluate_to(&Points::new(&points, |v| v).receivers(), &lamp, 1e-6, &mut answers);
        let scalar: Result<Vec<Answer>, Error> = points.iter().map(|point| evaluate(&receiver(*point), &lamp, &[])).collect();
        match scalar {
            Ok(truth) => {
                for (i, truth) in truth.iter().enumerate() {
                    agrees(&answers, i, truth, &|| format!("{:?}", points[i]));
                }
            }
            Err(_) => assert!(matches!(result, Err(Error::InBatch { .. }))),
        }
    }
}
