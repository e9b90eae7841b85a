//! The value alone: the same as with the gradient, and decided where the gradient is not.

use radgrad_core::{DVec3, Emission, Emitter, Error, Method, Polygon, Receiver, Tolerance, evaluate, evaluate_value};

fn polygon(points: &[[f64; 3]]) -> Polygon {
    Polygon::new(points.iter().map(|&p| p.into()).collect()).unwrap()
}

/// A rectangle at height `z`, lit downwards.
fn ceiling(x: [f64; 2], y: [f64; 2], z: f64) -> Polygon {
    polygon(&[[x[0], y[0], z], [x[0], y[1], z], [x[1], y[1], z], [x[1], y[0], z]])
}

fn lamp(emission: f64) -> Emitter {
    Emitter::new(ceiling([-1.0, 1.0], [-1.0, 1.0], 2.0), Emission::Constant(emission)).unwrap()
}

fn receiver(position: [f64; 3]) -> Receiver {
    Receiver::new(position.into(), DVec3::new(0.1, -0.2, 1.0), 0.8).unwrap()
}

const ABSOLUTE: Tolerance = Tolerance { relative: 0.0, absolute: 1e-12 };

#[test]
fn the_value_alone_is_the_value() {
    let screens = [ceiling([-0.3, 0.4], [-2.0, 0.3], 1.0), ceiling([0.3, 0.9], [-0.2, 0.8], 1.5)];
    for position in [[0.1, 0.2, 0.0], [0.5, -0.7, 0.9], [3.0, 0.0, 1.9]] {
        for occluders in [&screens[..], &screens[..1], &[]] {
            for emission in [Emission::Constant(3.0), Emission::at_vertices(vec![1.0, 2.0, 4.0, 3.0])] {
                let lamp = Emitter::new(lamp(1.0).polygon().clone(), emission).unwrap();
                let answer = evaluate(&receiver(position), &lamp, occluders).unwrap();
                for tolerance in [ABSOLUTE, Tolerance { relative: 1e-12, absolute: 0.0 }] {
                    let value = evaluate_value(&receiver(position), &lamp, occluders, tolerance).unwrap();
                    let difference = (value.radiosity - answer.radiosity).abs();
                    assert!(difference <= value.radiosity_error + answer.radiosity_error, "{value:?} {answer:?}");
                    assert!(value.radiosity_error <= 1e-11, "{value:?}");
                }
            }
        }
    }
}

/// Two triangular screens whose edges are seen in one line from the origin, one at `nearer` of the distance of the other.
fn seen_in_one_line(nearer: f64) -> [Polygon; 2] {
    let edge = [[0.3, -3.0, 1.1], [0.1, 3.0, 0.9]];
    let screen = |scale: f64, apex: [f64; 3]| {
        let [a, b] = edge.map(|p: [f64; 3]| p.map(|c| c * scale));
        polygon(&[a, b, apex])
    };
    [screen(1.0, [-9.0, 0.1, 1.0]), screen(nearer, [9.0, 0.1, 0.8])]
}

#[test]
fn edges_in_line_with_each_other_cost_no_more_digits_than_the_value_needs() {
    let lamp = lamp(1.0);
    let eye = Receiver::new(DVec3::ZERO, DVec3::Z, 1.0).unwrap();
    // 0.7 is rounded, and so are the corners: the edges overlap, or leave a gap, by an ulp or so.
    for nearer in [0.7, 0.5] {
        let [left, right] = seen_in_one_line(nearer);
        for alone in [&left, &right].map(|screen| evaluate_value(&eye, &lamp, [screen], ABSOLUTE).unwrap()) {
            assert!(alone.radiosity > 0.01, "{alone:?}");
        }
        let value = evaluate_value(&eye, &lamp, [&left, &right], ABSOLUTE).unwrap();
        assert!(value.radiosity.abs() <= value.radiosity_error && value.radiosity_error <= 1e-12, "{value:?}");
        assert!(matches!(value.method, Method::ClosedForm | Method::Zero), "{value:?}");
    }
}

#[test]
fn what_a_coincidence_leaves_is_nothing() {
    // Half the distance is exact: the edges are seen in one line, and no number of bits parts them.
    let screens = seen_in_one_line(0.5);
    let eye = Receiver::new(DVec3::ZERO, DVec3::Z, 1.0).unwrap();
    let answer = evaluate(&eye, &lamp(1.0), &screens).unwrap();
    assert_eq!(answer.radiosity, 0.0, "{answer:?}");
    assert!(answer.radiosity_error < 1e-180, "{answer:?}");
}

#[test]
fn an_absolute_tolerance_is_in_the_unit_of_the_emission() {
    let screen = ceiling([-0.3, 0.4], [-2.0, 0.3], 1.0);
    let value = |emission: f64, absolute: f64| {
        evaluate_value(&receiver([0.1, 0.2, 0.0]), &lamp(emission), [&screen], Tolerance { relative: 0.0, absolute }).unwrap()
    };
    let (one, many) = (value(1.0, 1e-13), value(2f64.powi(300), 2f64.powi(300) * 1e-13));
    assert_eq!((one.radiosity * 2f64.powi(300), one.method), (many.radiosity, many.method));
    assert!(value(1.0, 1e-18).radiosity_error <= 1e-16);
}

#[test]
fn a_wrong_tolerance_is_refused() {
    let evaluate = |relative, absolute| evaluate_value(&receiver([0.0; 3]), &lamp(1.0), &[], Tolerance { relative, absolute });
    for relative in [f64::NAN, -1e-12, 1.5] {
        assert!(matches!(evaluate(relative, 0.0), Err(Error::Tolerance { .. })));
    }
    for absolute in [f64::NAN, -1e-12, f64::INFINITY] {
        assert!(matches!(evaluate(0.0, absolute), Err(Error::AbsoluteTolerance { .. })));
    }
}
