//! Cases at the ends of a double's range, where products underflow or overflow: each answer is right, and a case that cannot be
//! answered is refused.

use radgrad_core::batch::{Answers, EmitterTree, Engine, Precision, Receivers};
use radgrad_core::{
    DVec3, Emission, Emitter, Error, Polygon, Receiver, Tolerance, effort, evaluate, evaluate_to, evaluate_value,
    irradiance_vector, radiosity, radiosity_and_gradient,
};

/// Of an answer that many digits do not help: they take seconds.
const MOST_OPERATIONS: u64 = 1_000_000_000;

fn polygon(vertices: &[[f64; 3]]) -> Polygon {
    Polygon::new(vertices.iter().map(|v| DVec3::from(*v)).collect()).unwrap()
}

fn square(z: f64) -> Emitter {
    Emitter::new(polygon(&[[0.0, 0.0, z], [0.0, 1.0, z], [1.0, 1.0, z], [1.0, 0.0, z]]), Emission::Constant(1.0)).unwrap()
}

#[test]
fn a_tree_keeps_a_needle_whose_cross_product_rounds_to_0() {
    let needle = polygon(&[[2f64.powi(-60), 0.0, 1.0], [1.0, 1.0, 1.0], [2.0, 2.0, 1.0]]);
    let emitters = [needle.clone(), Polygon::new(needle.vertices().iter().rev().copied().collect()).unwrap()]
        .map(|polygon| Emitter::new(polygon, Emission::Constant(2f64.powi(60))).unwrap());
    let receiver = Receiver::new(DVec3::new(0.3, 0.1, 0.0), DVec3::new(0.1, 0.0, 1.0), 1.0).unwrap();
    for emitter in emitters {
        let expected = evaluate(&receiver, &emitter, &[]).unwrap();
        let receivers = Receivers::new([&[0.3], &[0.1], &[0.0]], [&[0.1], &[0.0], &[1.0]], &[1.0]).unwrap();
        let mut answers = Answers::new();
        let lone = [emitter];
        Engine::new().total(&receivers, &EmitterTree::new(&lone), 1e-6, &mut answers).unwrap();
        let error = (answers.radiosity[0] - expected.radiosity).abs();
        assert!(error <= answers.radiosity_error[0] + expected.radiosity_error, "{answers:?} {expected:?}");
    }
}

fn short_normals<F: Precision + Into<f64>>(lengths: &[f64], round: fn(f64) -> F, tolerance: f64) {
    let lamp = square(1.0);
    let to_double = |value: F| -> f64 { value.into() };
    for length in lengths {
        let normal = [0.3 * length, -0.2 * length, *length].map(round);
        let position = [0.25, 0.5, 0.0].map(round);
        let [x, y, z] = position.map(|c| [c]);
        let [nx, ny, nz] = normal.map(|c| [c]);
        let one = [round(1.0)];
        let receivers = Receivers::new([&x, &y, &z], [&nx, &ny, &nz], &one).unwrap();
        let direction = DVec3::from(normal.map(Into::into));
        let receiver = Receiver::new(DVec3::new(0.25, 0.5, 0.0), direction, 1.0).unwrap();
        let expected = evaluate(&receiver, &lamp, &[]).unwrap();
        let mut answers = Answers::new();
        Engine::new().evaluate_to(&receivers, &lamp, tolerance, &mut answers).unwrap();
        let error = (to_double(answers.radiosity[0]) - expected.radiosity).abs();
        let bound = to_double(answers.radiosity_error[0]) + expected.radiosity_error;
        assert!(error <= bound && bound < 1e-4, "{length:e}: {answers:?} {expected:?}");
        Engine::new().radiosity(&receivers, &lamp, &mut answers).unwrap();
        assert!((to_double(answers.radiosity[0]) - expected.radiosity).abs() < 1e-4, "{length:e}: {answers:?} {expected:?}");
    }
}

#[test]
#[allow(clippy::cast_possible_truncation, reason = "to the nearest")]
fn batches_take_normals_of_any_length() {
    let doubles = [1e-100, 1e-155, 1e-160, 1e-162, 1e-170, 1e-200, 1e-300, 1e-310, 1e154, 1e200, 1e307];
    short_normals::<f64>(&doubles, |c| c, 1e-9);
    let singles = [1e-10, 1e-12, 1e-19, 1e-22, 1e-23, 1e-25, 1e-30, 1e-37, 1e-40, 1e19, 1e25, 1e37];
    short_normals::<f32>(&singles, |c| c as f32, 1e-5);
}

#[test]
fn just_below_an_emitter_at_coordinate_0_a_batch_sees_it() {
    let lamp = square(0.0);
    for height in [1e-300, 1e-200, 1e-170, 1e-162, 1e-161, 1e-155, 5e-324, 0.0, -1e-200, -5e-324] {
        let (z, up) = ([-height], [1.0]);
        let receivers = Receivers::new([&[0.3], &[0.4], &z], [&[0.0], &[0.0], &up], &[1.0]).unwrap();
        let mut answers = Answers::new();
        Engine::new().radiosity_to(&receivers, &lamp, 1e-9, &mut answers).unwrap();
        let expected = if height > 0.0 { 1.0 } else { 0.0f64 };
        assert!((answers.radiosity[0] - expected).abs() <= answers.radiosity_error[0], "{height:e}: {answers:?}");
    }
}

#[test]
fn next_to_vertex_0_the_side_is_right() {
    // The receiver is that near to vertex 0, in front of a tilted triangle or behind.
    let triangle = |sign: f64| {
        let corners = [DVec3::ZERO, DVec3::new(1.0, 0.3, 0.2), DVec3::new(-0.2, 1.0, 0.4)];
        let corners = if sign > 0.0 { corners } else { [corners[0], corners[2], corners[1]] };
        Emitter::new(Polygon::new(corners.to_vec()).unwrap(), Emission::Constant(1.0)).unwrap()
    };
    let [front, back] = [1.0, -1.0].map(triangle);
    let mut evaluated = 0;
    for i in 0..400 {
        let angle = f64::from(i) * 0.37;
        let direction = DVec3::new(angle.cos(), angle.sin(), (3.1 * angle).cos());
        let length = 10f64.powi(-150 - i % 170);
        let position = direction * length;
        // Exact up to a factor while nothing underflows.
        let scaled = position * 2f64.powi(900);
        let height = front.polygon().normal().dot(scaled);
        if height.abs() < 1e-3 * scaled.length() || position.abs().max_element() < 1e-305 {
            continue;
        }
        let receiver = Receiver::new(position, DVec3::new(0.3, 0.5, 0.8), 1.0).unwrap();
        let tolerance = Tolerance { relative: 1e-9, absolute: 0.0 };
        let [in_front, behind] = [&front, &back].map(|emitter| evaluate_value(&receiver, emitter, &[], tolerance).unwrap());
        let (lit, dark) = if height > 0.0 { (in_front, behind) } else { (behind, in_front) };
        assert!(dark.radiosity == 0.0 && dark.radiosity_error == 0.0, "{position:?}: {dark:?}");
        assert!(lit.radiosity_error <= 1e-9 * lit.radiosity, "{position:?}: {lit:?}");
        evaluated += 1;
    }
    assert!(evaluated > 300, "{evaluated}");
}

#[test]
fn slivers_keep_the_digits_of_their_irradiance_vector() {
    for width in [1e-6, 1e-10, 1e-13, 1e-16, 1e-20] {
        let sliver = polygon(&[[0.0, 0.0, 1.0], [0.3, 1.1, 1.0], [width, 0.0, 1.0]]);
        let emitter = Emitter::new(sliver.clone(), Emission::Constant(1.0)).unwrap();
        let receiver = Receiver::new(DVec3::new(0.3, 0.1, 0.0), DVec3::new(0.1, 0.2, 1.0), 1.0).unwrap();
        let vector = irradiance_vector(&receiver, &emitter).unwrap();
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            for sign in [1.0, -1.0] {
                // All of it is above the horizon of a receiver that is turned a little.
                let turned = Receiver::new(receiver.position(), DVec3::Z + axis * (0.2 * sign), 1.0).unwrap();
                let expected = evaluate_to(&turned, &emitter, &[], 1e-11).unwrap().radiosity;
                let irradiance = turned.normal().dot(vector) / std::f64::consts::PI;
                assert!((irradiance / expected - 1.0).abs() < 1e-7, "{width:e}: {irradiance:e} {expected:e}");
            }
        }
    }
}

#[test]
fn values_that_cancel_fall_back_to_what_has_digits() {
    // The emission changes its sign across the emitter, seen from where the two parts cancel.
    let corners = [[-1.0, -1.0, 1.0], [-1.0, 1.0, 1.0], [1.0, 1.0, 1.0], [1.0, -1.0, 1.0]];
    for shift in [0.0, 1e-6, 1e-12, 1e-15, 1e-30] {
        let values = vec![-1e16 + shift, -1e16, 1e16, 1e16 - shift];
        let Ok(emitter) = Emitter::new(polygon(&corners), Emission::at_vertices(values)) else { continue };
        for x in [0.0, 1e-8, 1e-17, 1e-25, 1e-36] {
            let receiver = Receiver::new(DVec3::new(x, 0.0, 0.0), DVec3::Z, 1.0).unwrap();
            let expected = evaluate_to(&receiver, &emitter, &[], 1e-9).unwrap();
            let (value, slope) = radiosity_and_gradient(&receiver, &emitter).unwrap();
            let room = expected.radiosity_error + 1e-6 * expected.radiosity.abs();
            assert!((value - expected.radiosity).abs() <= room, "{shift:e} {x:e}: {value:e} {expected:?}");
            assert!((radiosity(&receiver, &emitter).unwrap() - expected.radiosity).abs() <= room);
            assert!((slope - expected.gradient).length() <= expected.gradient_error + 1e-6 * expected.gradient.length());
        }
    }
}

#[test]
fn vertex_values_near_the_largest_double_are_answered_or_refused() {
    let corners = [[0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [1.0, 1.0, 1.0], [1.0, 0.0, 1.0]];
    let receiver = Receiver::new(DVec3::new(0.3, 0.2, 0.0), DVec3::Z, 1.0).unwrap();
    let wrong = Emitter::new(polygon(&corners), Emission::at_vertices(vec![1e305, 2e305, 3e305, 9e305]));
    assert!(matches!(wrong, Err(Error::EmissionNotAffine { .. })), "{wrong:?}");
    let small = Emitter::new(polygon(&corners), Emission::at_vertices(vec![1.0, 2.0, 5.0, 4.0])).unwrap();
    let large =
        Emitter::new(polygon(&corners), Emission::at_vertices([1.0, 2.0, 5.0, 4.0].map(|b| b * 2f64.powi(1015)).to_vec()));
    let [small, large] = [small, large.unwrap()].map(|emitter| evaluate(&receiver, &emitter, &[]).unwrap());
    let down = large.radiosity * 2f64.powi(-1015);
    assert!((down - small.radiosity).abs() <= 2.0 * small.radiosity_error, "{down:e} {small:?}");
    assert!(large.radiosity_error.is_finite() && large.gradient_error.is_finite(), "{large:?}");
    let steep = Emitter::new(
        polygon(&corners.map(|v| v.map(|c| c * 1e-10))),
        Emission::at_vertices(vec![-1.7e308, -1.7e308, 1.7e308, 1.7e308]),
    );
    assert!(matches!(steep, Err(Error::EmissionNotFinite { .. })), "{steep:?}");
}

#[test]
fn an_exact_0_by_symmetry_ends_quickly() {
    let corners = [[-1.0, -1.0, 1.0], [-1.0, 1.0, 1.0], [1.0, 1.0, 1.0], [1.0, -1.0, 1.0]];
    let emission = Emission::gradient(-1.0, DVec3::X);
    let emitter = Emitter::new(polygon(&corners), emission).unwrap();
    let receiver = Receiver::new(DVec3::new(0.0, 0.2, 0.0), DVec3::Z, 1.0).unwrap();
    let (both, operations) = effort::within(MOST_OPERATIONS, || {
        let value = evaluate_value(&receiver, &emitter, &[], Tolerance { relative: 1e-12, absolute: 0.0 });
        (evaluate(&receiver, &emitter, &[]).unwrap(), value.unwrap())
    });
    // It took 25 s with 8448 bits.
    let (answer, value) = both.unwrap_or_else(|| panic!("{operations} operations"));
    assert_eq!(answer.radiosity, value.radiosity);
    assert!(answer.radiosity == 0.0 && answer.radiosity_error < 1e-100, "{answer:?}");
    assert!(answer.gradient.x > 0.1 && answer.gradient_error <= 1e-12 * answer.gradient.x, "{answer:?}");
}

#[test]
fn what_is_below_the_range_for_its_distance_is_so_without_a_digit_of_it() {
    // The horizon cuts it by 1 in 1e16, at a distance of 1e308.
    let receiver = Receiver::new(DVec3::new(1e16, -1e308, 0.0), DVec3::new(1.0, 0.0, 1.0), 0.5).unwrap();
    let corners = [[1.0, 0.0, 1e16], [0.3, -0.09, 1e16], [-0.8, -0.6, 1e15]];
    let emitter = |values: [f64; 3]| Emitter::new(polygon(&corners), Emission::at_vertices(values.to_vec())).unwrap();
    let tolerance = Tolerance { relative: 1e-9, absolute: 0.0 };
    let both = emitter([0.2, -9e-11, -0.9]);
    let before = effort::spent();
    let answer = evaluate_to(&receiver, &both, &[], 1e-9).unwrap();
    assert!(answer.radiosity == 0.0 && answer.gradient == DVec3::ZERO, "{answer:?}");
    let bounds = [answer.radiosity_error, answer.gradient_error];
    assert!(bounds.iter().all(|bound| (5e-324..f64::MIN_POSITIVE).contains(bound)), "{answer:?}");
    let value = evaluate_value(&receiver, &both, &[], tolerance).unwrap();
    assert_eq!((value.radiosity, value.radiosity_error), (0.0, answer.radiosity_error));
    for values in [[0.2, 9e-11, 0.9], [-0.2, -9e-11, -0.9]] {
        let (answer, value) =
            (evaluate_to(&receiver, &emitter(values), &[], 1e-9), evaluate_value(&receiver, &emitter(values), &[], tolerance));
        assert!(
            matches!(answer, Err(Error::Underflow { .. })) && matches!(value, Err(Error::Underflow { .. })),
            "{answer:?} {value:?}"
        );
    }
    // Many bits took 17 seconds.
    assert!(effort::spent() - before < MOST_OPERATIONS, "{} operations", effort::spent() - before);
}
