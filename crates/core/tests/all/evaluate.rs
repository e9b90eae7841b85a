//! The evaluating functions agree: the plain closed form has the digits of the certified one, and each refuses wrong input.

use radgrad_core::{
    DVec3, Emission, Emitter, Error, Method, Polygon, Receiver, evaluate, evaluate_to, gradient, irradiance_vector, radiosity,
    radiosity_and_gradient,
};

fn case(normal: DVec3, emission: Emission) -> (Receiver, Emitter) {
    let triangle = [[-0.9, 0.1, 0.2], [-0.1, 0.7, 0.3], [0.4, -0.9, 0.1]].map(DVec3::from);
    let polygon = Polygon::new(triangle.iter().rev().copied().collect()).unwrap();
    let emitter = if polygon.normal().z < 0.0 { polygon } else { Polygon::new(triangle.to_vec()).unwrap() };
    (Receiver::new(DVec3::new(0.2, -0.1, 0.0), normal, 0.7).unwrap(), Emitter::new(emitter, emission).unwrap())
}

#[test]
fn value_alone_gradient_alone_and_both_have_the_digits_of_the_certified_closed_form() {
    for normal in [DVec3::new(0.1, 0.2, 1.0), DVec3::new(1.0, -0.3, 0.1)] {
        for emission in [Emission::Constant(3.2), Emission::at_vertices(vec![1.0, 0.25, 2.5])] {
            let (receiver, emitter) = case(normal, emission);
            let answer = evaluate_to(&receiver, &emitter, &[], 1e-9).unwrap();
            assert_eq!(answer.method, Method::ClosedForm);
            assert_eq!(radiosity(&receiver, &emitter).unwrap(), answer.radiosity);
            assert_eq!(gradient(&receiver, &emitter).unwrap(), answer.gradient);
            assert_eq!(radiosity_and_gradient(&receiver, &emitter).unwrap(), (answer.radiosity, answer.gradient));
        }
    }
}

#[test]
fn the_irradiance_vector_is_the_derivative_with_respect_to_the_normal() {
    for normal in [DVec3::new(0.1, 0.2, 1.0), DVec3::new(1.0, -0.3, 0.1)] {
        for emission in [Emission::Constant(3.2), Emission::at_vertices(vec![1.0, 0.25, 2.5])] {
            let (receiver, emitter) = case(normal, emission);
            let vector = irradiance_vector(&receiver, &emitter).unwrap();
            let per_pi = receiver.reflectance() / std::f64::consts::PI;
            let value = radiosity(&receiver, &emitter).unwrap();
            assert!((per_pi * receiver.normal().dot(vector) - value).abs() < 1e-15);
            let tangent = receiver.normal().any_orthonormal_vector();
            let step = 1e-4;
            let turned = |step: f64| {
                let turned = Receiver::new(receiver.position(), receiver.normal() + tangent * step, 0.7).unwrap();
                // The unit normal is shorter than n1 + step t by (1 + step^2)^(1/2).
                radiosity(&turned, &emitter).unwrap() * (1.0 + step * step).sqrt()
            };
            let difference = (turned(step) - turned(-step)) / (2.0 * step);
            assert!((difference - per_pi * tangent.dot(vector)).abs() < 1e-8, "{difference} {normal}");
        }
    }
}

#[test]
fn a_reversed_or_hidden_emitter_gives_exactly_zero() {
    let (receiver, emitter) = case(DVec3::Z, Emission::Constant(1.0));
    let reversed = Polygon::new(emitter.polygon().vertices().iter().rev().copied().collect()).unwrap();
    let dark = evaluate(&receiver, &Emitter::new(reversed, Emission::Constant(1.0)).unwrap(), &[]).unwrap();
    assert_eq!((dark.radiosity, dark.gradient, dark.radiosity_error, dark.method), (0.0, DVec3::ZERO, 0.0, Method::Zero));
    let away = Receiver::new(receiver.position(), DVec3::NEG_Z, 1.0).unwrap();
    assert_eq!(evaluate(&away, &emitter, &[]).unwrap().method, Method::Zero);
}

#[test]
fn a_tight_tolerance_is_met_in_double_double_and_a_wrong_one_refused() {
    let (receiver, emitter) = case(DVec3::new(1.0, -0.3, 0.1), Emission::at_vertices(vec![1.0, 0.25, 2.5]));
    let [rough, fine] = [1e-9, 2e-16].map(|tolerance| evaluate_to(&receiver, &emitter, &[], tolerance).unwrap());
    assert_eq!((rough.method, fine.method), (Method::ClosedForm, Method::DoubleDouble));
    assert!(fine.meets(2e-16));
    assert!((rough.radiosity - fine.radiosity).abs() <= rough.radiosity_error + fine.radiosity_error);
    assert!((rough.gradient - fine.gradient).length() <= rough.gradient_error + fine.gradient_error);
    for tolerance in [f64::NAN, -1e-12, 1.5] {
        assert!(matches!(evaluate_to(&receiver, &emitter, &[], tolerance), Err(Error::Tolerance { .. })));
    }
}

#[test]
fn next_to_an_edge_the_answer_is_a_number_however_asked_for() {
    let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]].map(DVec3::from);
    let emitter = Emitter::new(Polygon::new(square.to_vec()).unwrap(), Emission::Constant(1.0)).unwrap();
    for height in [1e-12, 1e-100, 1e-200] {
        let receiver = Receiver::new(DVec3::new(0.5, 0.0, height), DVec3::new(0.0, 0.0, -1.0), 1.0).unwrap();
        let value = radiosity(&receiver, &emitter).unwrap();
        assert!((value - 0.5).abs() < 1e-11, "{height:e}: {value}");
        assert_eq!(radiosity_and_gradient(&receiver, &emitter).unwrap().0, value);
    }
}

#[test]
fn a_result_too_large_for_a_double_is_an_error() {
    let (receiver, emitter) = case(DVec3::Z, Emission::Constant(1e308));
    assert!(evaluate(&receiver, &emitter, &[]).is_ok());
    let near = [[-1e-200, -1e-200, 1e-210], [0.0, 1e-200, 1e-210], [1e-200, -1e-200, 1e-210]].map(DVec3::from);
    let polygon = Polygon::new(near.to_vec()).unwrap();
    let emitter = Emitter::new(polygon, Emission::Constant(1e150)).unwrap();
    let below = Receiver::new(DVec3::new(1e-200, 0.0, 0.0), DVec3::Z, 1.0).unwrap();
    assert_eq!(evaluate(&below, &emitter, &[]), Err(Error::Overflow { quantity: "gradient" }));
}
