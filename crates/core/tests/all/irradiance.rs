//! The irradiance vector and its bound, with occluders and where digits cancel.

use std::f64::consts::PI;

use radgrad_core::{
    DVec3, Emission, Emitter, Error, Method, Polygon, Polynomial, Receiver, evaluate_to, irradiance_vector, irradiance_vector_to,
};

fn polygon(points: &[[f64; 3]]) -> Polygon {
    Polygon::new(points.iter().map(|&p| p.into()).collect()).unwrap()
}

fn lamp() -> Polygon {
    polygon(&[[-0.9, -0.8, 1.0], [-0.7, 0.9, 1.0], [0.8, 0.7, 1.0], [0.9, -0.6, 1.0]])
}

fn emissions() -> [Emission; 3] {
    let polynomial = Polynomial::new(DVec3::Z, [(2.0, [0, 0, 0]), (0.5, [2, 1, 0]), (-0.3, [0, 3, 0])]).unwrap();
    [Emission::Constant(2.5), Emission::gradient(1.0, DVec3::new(0.3, -0.2, 0.0)), Emission::Polynomial(polynomial)]
}

/// Along a normal it is the radiosity of a receiver that has it, as long as that sees the same part.
#[test]
fn its_components_are_the_radiosities_of_receivers_within_the_bounds() {
    let screens = [polygon(&[[0.1, -2.0, 0.5], [0.1, 2.0, 0.5], [3.0, 0.0, 0.6]])];
    for emission in emissions() {
        let emitter = Emitter::new(lamp(), emission).unwrap();
        for occluders in [&[][..], &screens] {
            for tolerance in [1.0, 1e-9, 1e-15, 0.0] {
                let receiver = Receiver::new(DVec3::new(0.1, 0.2, 0.0), DVec3::Z, 1.0).unwrap();
                let irradiance = irradiance_vector_to(&receiver, &emitter, occluders, tolerance).unwrap();
                assert!(irradiance.meets(tolerance.max(1.2e-16)) && irradiance.error > 0.0, "{irradiance:?}");
                for normal in [DVec3::Z, DVec3::new(0.2, -0.1, 1.0), DVec3::new(-0.1, -0.2, 1.0)] {
                    let turned = Receiver::new(receiver.position(), normal, 1.0).unwrap();
                    let answer = evaluate_to(&turned, &emitter, occluders, 1e-15).unwrap();
                    let radiosity = turned.normal().dot(irradiance.vector) / PI;
                    let allowed =
                        irradiance.error / PI + answer.radiosity_error + 4.0 * f64::EPSILON * irradiance.vector.length();
                    assert!((radiosity - answer.radiosity).abs() <= allowed, "{radiosity} {answer:?} {irradiance:?}");
                }
            }
        }
    }
}

/// A sliver far away, of which double precision knows nothing, and a receiver that absorbs all that arrives.
#[test]
fn where_digits_cancel_more_bits_answer() {
    let sliver = polygon(&[[0.0, 0.0, 1e4], [0.0, 1.0, 1e4], [1e-9, 0.0, 1e4]]);
    let emitter = Emitter::new(sliver, Emission::Constant(1.0)).unwrap();
    let receiver = Receiver::new(DVec3::new(3.0, 2.0, 0.0), DVec3::new(0.1, 0.0, 1.0), 0.0).unwrap();
    let irradiance = irradiance_vector_to(&receiver, &emitter, &[], 1e-14).unwrap();
    assert!(irradiance.meets(1e-14) && irradiance.method != Method::ClosedForm, "{irradiance:?}");
    // Its area over the square of the distance, towards it.
    assert!((irradiance.vector.z - 5e-18).abs() < 1e-6 * 5e-18, "{irradiance:?}");
    let plain = irradiance_vector(&receiver, &emitter).unwrap();
    assert!((plain - irradiance.vector).length() <= 1e-9 * irradiance.vector.length());
}

#[test]
fn what_is_dark_hidden_or_wrong_is_said() {
    let emitter = Emitter::new(lamp(), Emission::Constant(1.0)).unwrap();
    let receiver = |z: f64| Receiver::new(DVec3::new(0.0, 0.0, z), DVec3::Z, 1.0).unwrap();
    let wall = [polygon(&[[-9.0, -9.0, 0.5], [9.0, -9.0, 0.5], [9.0, 9.0, 0.5], [-9.0, 9.0, 0.5]])];
    for (z, occluders) in [(2.0, &[][..]), (0.0, &wall)] {
        let irradiance = irradiance_vector_to(&receiver(z), &emitter, occluders, 1e-12).unwrap();
        assert_eq!((irradiance.vector, irradiance.error, irradiance.method), (DVec3::ZERO, 0.0, Method::Zero));
    }
    assert!(matches!(irradiance_vector_to(&receiver(0.0), &emitter, &[], -1.0), Err(Error::Tolerance { .. })));
}
