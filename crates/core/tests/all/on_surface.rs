//! Receivers on polygons whose vertices are rounded, so that they are not exactly in one plane: answers to one polygon must not
//! depend on which of its vertices is named first by more than their bounds, whichever way they are requested.

use radgrad_core::batch::{Answers, EmitterTree, Engine, Receivers};
use radgrad_core::{
    Answer, DMat3, DVec3, Emission, Emitter, Error, Method, Polygon, Receiver, Tolerance, evaluate_digits, evaluate_to,
    evaluate_value, hessian,
};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rayon::iter::{IntoParallelIterator, ParallelIterator};

fn vector(random: &mut ChaCha8Rng) -> DVec3 {
    DVec3::new(random.random_range(-1.0..1.0), random.random_range(-1.0..1.0), random.random_range(-1.0..1.0))
}

/// A polygon of `count` vertices around its middle, rotated and rounded: a 2 x 2 square for four. And a few points: inside, on an
/// edge, at a vertex, and in its plane outside, all rounded.
fn rotated(random: &mut ChaCha8Rng, count: usize) -> (Vec<DVec3>, [DVec3; 4], DVec3) {
    let turn = {
        let axis = vector(random).normalize();
        DMat3::from_axis_angle(axis, random.random_range(0.0..6.0))
    };
    let corner = |i: usize| {
        let angle = std::f64::consts::TAU * (i as f64 + 0.5) / count as f64;
        DVec3::new(angle.cos(), angle.sin(), 0.0) * std::f64::consts::SQRT_2
    };
    let middle = vector(random);
    let vertices: Vec<DVec3> = (0..count).map(|i| turn * corner(i) + middle).collect();
    let (r, phi) = (random.random_range(0.0..0.6), random.random_range(0.0..6.0f64));
    let inside = turn * (DVec3::new(phi.cos(), phi.sin(), 0.0) * r) + middle;
    let i = random.random_range(0..count);
    let on_edge = vertices[i].lerp(vertices[(i + 1) % count], random.random_range(0.1..0.9));
    let outside = turn * (DVec3::new(phi.cos(), phi.sin(), 0.0) * random.random_range(1.6..20.0)) + middle;
    (vertices.clone(), [inside, on_edge, vertices[i], outside], turn * DVec3::Z)
}

/// The same emission whichever vertex is named first: a value at the first vertex and a slope would be rounded anew for each.
fn emission(kind: usize, vertices: &[DVec3], first: usize, slope: DVec3) -> Emission {
    let mut values: Vec<f64> = vertices.iter().map(|v| 2.0 + slope.dot(*v - vertices[0])).collect();
    values.rotate_left(first);
    if kind == 0 { Emission::Constant(1.0) } else { Emission::at_vertices(values) }
}

fn starting_at(vertices: &[DVec3], first: usize) -> Polygon {
    let mut turned = vertices.to_vec();
    turned.rotate_left(first);
    Polygon::new(turned).unwrap()
}

fn meet(a: &Answer, b: &Answer) -> bool {
    (a.radiosity - b.radiosity).abs() <= a.radiosity_error + b.radiosity_error
        && (a.gradient - b.gradient).length() <= a.gradient_error + b.gradient_error
}

/// Answers from all ways of asking, for one way of naming the vertices. Those of a value alone have a gradient of 0 with an
/// infinite bound.
fn ways(receiver: &Receiver, emitter: &Emitter) -> Vec<Answer> {
    let mut every_way = vec![evaluate_to(receiver, emitter, &[], 1e-12).unwrap()];
    let of_value = |radiosity, radiosity_error| Answer {
        radiosity,
        radiosity_error,
        gradient: DVec3::ZERO,
        gradient_error: f64::INFINITY,
        method: Method::ClosedForm,
    };
    let value = evaluate_value(receiver, emitter, &[], Tolerance { relative: 1e-12, absolute: 0.0 }).unwrap();
    every_way.push(of_value(value.radiosity, value.radiosity_error));
    let [x, y, z] = receiver.position().to_array().map(|c| [c]);
    let [nx, ny, nz] = receiver.direction().to_array().map(|c| [c]);
    let reflectance = [receiver.reflectance()];
    let receivers = Receivers::new([&x, &y, &z], [&nx, &ny, &nz], &reflectance).unwrap();
    let mut answers = Answers::new();
    Engine::new().evaluate_to(&receivers, emitter, 1e-9, &mut answers).unwrap();
    every_way.push(Answer {
        gradient: DVec3::from([0, 1, 2].map(|axis: usize| answers.gradient[axis][0])),
        gradient_error: answers.gradient_error[0],
        ..of_value(answers.radiosity[0], answers.radiosity_error[0])
    });
    let emitters = [emitter.clone()];
    Engine::new().total(&receivers, &EmitterTree::new(&emitters), 1e-9, &mut answers).unwrap();
    every_way.push(of_value(answers.radiosity[0], answers.radiosity_error[0]));
    every_way
}

/// Counts the answers on the surface; the error names two answers that do not meet, and their problem.
fn check(random: &mut ChaCha8Rng, count: usize, distance: f64, kind: usize) -> Result<usize, String> {
    let (vertices, points, normal) = rotated(random, count);
    let slope = vector(random).cross(normal) * if kind == 2 { 3.0 } else { 0.3 };
    let mut on_surface = 0;
    for point in points {
        for direction in [-normal, vector(random), normal] {
            let receiver = Receiver::new(point + normal * distance, direction, 1.0).unwrap();
            let mut answers = Vec::new();
            for first in 0..count {
                let emitter = Emitter::new(starting_at(&vertices, first), emission(kind, &vertices, first, slope)).unwrap();
                answers.extend(ways(&receiver, &emitter));
            }
            on_surface += answers.iter().filter(|answer| answer.method == Method::OnSurface).count();
            let pairs = answers.iter().flat_map(|answer| answers.iter().map(move |other| [*answer, *other]));
            let finite = |answer: &Answer| answer.radiosity.is_finite() && answer.radiosity_error.is_finite();
            for answers in pairs {
                if !finite(&answers[0]) || !meet(&answers[0], &answers[1]) {
                    return Err(format!("{answers:?}\n{receiver:?}\n{vertices:?}"));
                }
            }
        }
    }
    Ok(on_surface)
}

/// Each case is drawn by its number, so that those after it do not depend on it, and all that fail are told.
fn run(seed: u64, cases: usize, offs: &[f64]) {
    let counts = (0..cases).into_par_iter().map(|case| {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(case as u64);
        let count = if case % 2 == 0 { 4 } else { 5 + case / 2 % 8 };
        let distance = offs[case % offs.len()] * if random.random_bool(0.5) { 1.0 } else { -1.0 };
        check(&mut random, count, distance, case % 3).map_err(|apart| println!("case {case}: {apart}"))
    });
    let counts: Vec<Result<usize, ()>> = counts.collect();
    let on_surface: usize = counts.iter().flatten().sum();
    let apart = counts.iter().filter(|case| case.is_err()).count();
    println!("seed {seed}: {apart} of {cases} cases are apart, {on_surface} answers on the surface");
    assert!(apart == 0 && on_surface > cases / 4);
}

#[test]
fn it_does_not_matter_which_vertex_is_named_first() {
    let cases = std::env::var("RADGRAD_ON_SURFACE_CASES").map_or(24, |cases| cases.parse().unwrap());
    run(1, cases, &[0.0]);
    run(2, cases, &[2e-16, 1e-15, 1e-14, 1e-13, 1e-12]);
}

/// The receiver's horizon is the polygon's plane but for roundings, so it cuts the polygon where vertices lie off that plane: which part is
/// visible depends on the surface that is assumed between the vertices.
#[test]
fn along_the_plane_it_does_not_matter_either() {
    let vertices = [
        [-0.13592089330296564, 1.7519002835173558, 0.031204766571449882],
        [-0.890447733020558, 1.9784373094127639, -0.08861214675684947],
        [-1.6628896350675364, 1.7882736807096504, -0.04216679224441089],
        [-2.2080017533576592, 1.2417850058892608, 0.15579475821825955],
        [-2.3527148419119905, 0.5124775779026068, 0.4424211110887403],
        [-2.051083517608353, -0.1680986479045926, 0.7267104245356872],
        [-1.3988735946880555, -0.5838655285603762, 0.918402850231997],
        [-0.6031571153831896, -0.6028200171249318, 0.9566373974530482],
        [0.08343156039093147, -0.2189441974050298, 0.8292748676085586],
        [0.4429053792797868, 0.4458840701751916, 0.5767519640235202],
        [0.3611339437067982, 1.1805865081110813, 0.2792429243446069],
    ]
    .map(DVec3::from);
    let position = DVec3::new(7.469189379308673, 17.41138886977516, -5.949959494603046);
    let normal = DVec3::new(0.035721678683050595, -0.3716753245683694, -0.9276752744247645);
    let receiver = Receiver::new(position, normal, 1.0).unwrap();
    hold_linear_emission(&vertices, &receiver, 40);
}

/// Four vertex values are off every affine function by roundings, as much as rounded differences from it may be off.
#[test]
fn what_vertex_values_are_off_an_affine_function_is_in_the_bound() {
    let vertices = [
        [-1.986155864732192, 0.21502227638330942, -1.093446960155119],
        [-1.937533786237133, -0.021199313283352783, 0.8919586039697971],
        [0.06187488533206875, -0.016374642688029822, 0.8435676274604509],
        [0.0132528068370098, 0.21984694697863236, -1.141837936664465],
    ]
    .map(DVec3::from);
    let position = DVec3::new(-0.923217869524635, 0.101522265292417, -0.14357160901220123);
    let normal = DVec3::new(-0.00046301638788392996, -0.9929974928378473, -0.11813452007594621);
    hold_linear_emission(&vertices, &Receiver::new(position, normal, 1.0).unwrap(), 1000);
}

/// Answers for some slopes along the receiver's plane do not depend on which vertex is named first.
fn hold_linear_emission(vertices: &[DVec3], receiver: &Receiver, slopes: usize) {
    let mut random = ChaCha8Rng::seed_from_u64(4);
    for case in 0..slopes {
        let slope = vector(&mut random).cross(receiver.direction()) * if case % 2 == 0 { 3.0 } else { 0.3 };
        let answer = |first: usize| {
            let emitter = Emitter::new(starting_at(vertices, first), emission(1, vertices, first, slope)).unwrap();
            evaluate_to(receiver, &emitter, &[], 1e-12).unwrap()
        };
        let answers: Vec<Answer> = (0..vertices.len()).map(answer).collect();
        for (answer, other) in answers.iter().flat_map(|a| answers.iter().map(move |b| (a, b))) {
            assert!(meet(answer, other), "{slope:?}\n{answer:?}\n{other:?}");
        }
    }
}

/// A rotated square, the point of its inside where it may be in front or behind, and the normal.
fn square_and_point() -> (Vec<DVec3>, DVec3, DVec3) {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    loop {
        let (vertices, points, normal) = rotated(&mut random, 4);
        let receiver = Receiver::new(points[0], -normal, 1.0).unwrap();
        let emitter = Emitter::new(starting_at(&vertices, 0), Emission::Constant(1.0)).unwrap();
        if evaluate_to(&receiver, &emitter, &[], 1e-12).unwrap().method == Method::OnSurface {
            return (vertices, points[0], normal);
        }
    }
}

#[test]
fn on_the_surface_the_bound_encloses_both_sides() {
    let (vertices, point, normal) = square_and_point();
    let emitter = Emitter::new(starting_at(&vertices, 0), Emission::Constant(3.0)).unwrap();
    let facing = Receiver::new(point, -normal, 0.5).unwrap();
    let answer = evaluate_to(&facing, &emitter, &[], 1e-12).unwrap();
    assert!((answer.radiosity - 0.75).abs() < 1e-9 && (answer.radiosity_error - 0.75).abs() < 1e-9, "{answer:?}");
    assert!(answer.gradient_error.is_finite() && answer.gradient_error > 0.1, "{answer:?}");
    // A floor gives nothing to a floor.
    let along = Receiver::new(point, normal, 0.5).unwrap();
    assert!(evaluate_to(&along, &emitter, &[], 1e-12).unwrap().radiosity_error < 1e-28);
    // Neither does an emitter seen edge-on from far outside, up to the distance of its vertices from the plane.
    let beside = Receiver::new(vertices[0] + (vertices[0] - vertices[2]) * 3.0, -normal, 0.5).unwrap();
    let answer = evaluate_to(&beside, &emitter, &[], 1e-12).unwrap();
    assert!(answer.radiosity.abs() + answer.radiosity_error < 1e-14 && answer.gradient_error < 1e-12, "{answer:?}");
}

#[test]
fn what_has_no_bound_is_refused_on_the_surface() {
    let (vertices, point, normal) = square_and_point();
    let emitter = Emitter::new(starting_at(&vertices, 0), Emission::Constant(3.0)).unwrap();
    let facing = Receiver::new(point, -normal, 0.5).unwrap();
    for error in [evaluate_digits(&facing, &emitter, &[], 10).unwrap_err(), hessian(&facing, &emitter).unwrap_err()] {
        assert!(matches!(error, Error::OnSurface { .. }), "{error}");
        assert!(error.to_string().contains("over the emitter's plane"), "{error}");
    }
}

#[test]
fn of_a_flat_polygon_the_side_is_exact() {
    let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
    let emitter = Emitter::new(Polygon::new(square.to_vec()).unwrap(), Emission::Constant(1.0)).unwrap();
    for (height, expected) in [(1e-300, 1.0), (0.0, 0.0), (-1e-300, 0.0)] {
        let receiver = Receiver::new(DVec3::new(0.3, 0.4, height), DVec3::NEG_Z, 1.0).unwrap();
        let answer = evaluate_to(&receiver, &emitter, &[], 1e-12).unwrap();
        assert!((answer.radiosity - expected).abs() <= answer.radiosity_error && answer.radiosity_error < 1e-12, "{answer:?}");
    }
}
