//! Second derivatives against differences of the gradient, and against identities that must hold.

use radgrad_core::{
    DMat3, DVec3, Emission, Emitter, Error, Method, Polygon, Polynomial, Receiver, evaluate_to, hessian, hessian_to,
};

fn facing_down(points: &[[f64; 3]]) -> Emitter {
    let points: Vec<DVec3> = points.iter().map(|&p| p.into()).collect();
    let polygon = Polygon::new(points.clone()).unwrap();
    let polygon = if polygon.normal().z < 0.0 { polygon } else { Polygon::new(points.into_iter().rev().collect()).unwrap() };
    Emitter::new(polygon, Emission::Constant(2.5)).unwrap()
}

fn triangle() -> Emitter {
    facing_down(&[[-0.9, 0.1, 1.2], [0.4, -0.9, 1.1], [-0.1, 0.7, 1.3]])
}

fn concave() -> Emitter {
    facing_down(&[[-0.9, -0.8, 1.0], [0.8, -0.7, 1.0], [0.1, 0.0, 1.0], [0.7, 0.9, 1.0], [-0.8, 0.6, 1.0]])
}

fn receiver_at(position: DVec3, normal: DVec3) -> Receiver {
    Receiver::new(position, normal, 0.7).unwrap()
}

fn norm(m: DMat3) -> f64 {
    m.to_cols_array().iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// Central differences of the gradient, to a tolerance, of orders 2, 4, 6 by Richardson's extrapolation.
fn by_differences(x: DVec3, normal: DVec3, (emitter, occluders): (&Emitter, &[Polygon]), step: f64, tolerance: f64) -> DMat3 {
    let gradient = |x: DVec3| evaluate_to(&receiver_at(x, normal), emitter, occluders, tolerance).unwrap().gradient;
    let along = |axis: DVec3| {
        let central = |step: f64| (gradient(x + axis * step) - gradient(x - axis * step)) / (2.0 * step);
        let [one, two, four] = [step, 2.0 * step, 4.0 * step].map(central);
        let (fine, coarse) = ((4.0 * one - two) / 3.0, (4.0 * two - four) / 3.0);
        (16.0 * fine - coarse) / 15.0
    };
    DMat3::from_cols(along(DVec3::X), along(DVec3::Y), along(DVec3::Z))
}

/// Light from one emitter has no sources in free space: the radiosities of three perpendicular receivers, each differentiated
/// along its normal, sum to zero (Gershun 1939), and so do their gradients.
#[test]
fn the_flux_of_the_whole_emitter_has_no_divergence() {
    let emitter = facing_down(&[[1.0, 1.1, 1.4], [1.5, 0.9, 1.2], [1.2, 1.6, 1.3]]);
    let gradient_of_divergence: DVec3 = DVec3::AXES
        .into_iter()
        .map(|n1| hessian_to(&receiver_at(DVec3::ZERO, n1), &emitter, &[], 1e-15).unwrap().matrix * n1)
        .sum();
    let size = norm(hessian(&receiver_at(DVec3::ZERO, DVec3::Z), &emitter).unwrap());
    assert!(gradient_of_divergence.length() <= 1e-15 * size, "{gradient_of_divergence}, {size}");
}

#[test]
fn the_matrix_turns_with_the_scene() {
    // A cyclic change of the axes is exact.
    let turned = |v: DVec3| DVec3::new(v.z, v.x, v.y);
    let receiver = receiver_at(DVec3::new(0.2, -0.1, 0.0), DVec3::new(1.0, -0.3, 0.2));
    let vertices = triangle().polygon().vertices().iter().map(|v| turned(*v)).collect();
    let emitter = Emitter::new(Polygon::new(vertices).unwrap(), Emission::Constant(2.5)).unwrap();
    let there = hessian(&receiver_at(turned(receiver.position()), turned(receiver.normal())), &emitter).unwrap();
    let here = hessian(&receiver, &triangle()).unwrap();
    let columns = [here.z_axis, here.x_axis, here.y_axis].map(turned);
    assert!(norm(there - DMat3::from_cols(columns[0], columns[1], columns[2])) < 1e-14 * norm(here));
}

#[test]
fn bounds_hold_between_the_precisions() {
    for normal in [DVec3::new(0.1, 0.2, 1.0), DVec3::new(1.0, -0.3, 0.2)] {
        for distance in [1.0, 30.0, 1e3] {
            let receiver = receiver_at(DVec3::new(0.2, -0.1, 1.0 - distance), normal + DVec3::Z * (distance - 1.0));
            let [rough, fine] = [1.0, 0.0].map(|tolerance| hessian_to(&receiver, &triangle(), &[], tolerance).unwrap());
            assert_eq!(rough.matrix, hessian(&receiver, &triangle()).unwrap());
            assert_eq!((rough.method, fine.method), (Method::ClosedForm, Method::DoubleDouble));
            let difference = norm(rough.matrix - fine.matrix);
            assert!(difference <= rough.error + fine.error, "{difference:e} {rough:?} {fine:?}");
            assert!(fine.meets(1e-15), "{fine:?}");
        }
    }
}

/// Emissions that vary: linear both ways, and polynomials of degree 1, 2 and 5.
fn varying(polygon: &Polygon) -> Vec<Emitter> {
    let polynomial = |terms: &[(f64, [u8; 3])]| {
        Emission::Polynomial(Polynomial::new(DVec3::new(0.1, -0.2, 1.0), terms.iter().copied()).unwrap())
    };
    let emissions = [
        Emission::gradient(1.0, DVec3::new(0.7, -0.4, 0.2)),
        polynomial(&[(1.0, [0, 0, 0]), (0.7, [1, 0, 0]), (-0.4, [0, 1, 0])]),
        polynomial(&[(2.0, [0, 0, 0]), (0.7, [2, 0, 0]), (-0.4, [1, 1, 0]), (0.3, [0, 0, 1])]),
        polynomial(&[(2.0, [0, 0, 0]), (0.5, [3, 2, 0]), (-1.0, [1, 0, 2]), (0.3, [0, 1, 0])]),
    ];
    emissions.into_iter().map(|emission| Emitter::new(polygon.clone(), emission).unwrap()).collect()
}

#[test]
fn an_emission_that_varies_has_them_past_occluders() {
    let polygon = |points: [[f64; 3]; 3]| Polygon::new(points.map(DVec3::from).to_vec()).unwrap();
    let screens = [
        polygon([[0.1, -1.0, 0.5], [0.1, 1.2, 0.45], [2.0, 0.0, 0.5]]),
        polygon([[-1.0, 0.2, 0.7], [0.4, 0.25, 0.6], [0.0, 1.5, 0.7]]),
    ];
    for emitter in varying(concave().polygon()) {
        for (normal, occluders) in [(DVec3::new(0.1, 0.2, 1.0), &screens[..1]), (DVec3::new(1.0, -0.3, 0.2), &screens[..])] {
            let position = DVec3::new(0.02, -0.1, 0.0);
            let answer = hessian_to(&receiver_at(position, normal), &emitter, occluders, 1e-12).unwrap();
            let difference = by_differences(position, normal, (&emitter, occluders), 1e-3, 1e-15);
            let error = norm(answer.matrix - difference);
            assert!(error <= 1e-6 * norm(difference), "{normal}: {answer:?} {difference}, off by {error:e}");
            assert!(answer.meets(1e-12), "{answer:?}");
        }
    }
}

/// A constant emission as a polynomial has the digits of neither way lost.
#[test]
fn a_constant_as_a_polynomial_has_the_same() {
    let polynomial = Polynomial::new(DVec3::ZERO, [(2.5, [0, 0, 0]), (0.0, [2, 1, 0])]).unwrap();
    let emitter = Emitter::new(concave().polygon().clone(), Emission::Polynomial(polynomial)).unwrap();
    let receiver = receiver_at(DVec3::new(0.2, -0.1, 0.0), DVec3::new(1.0, -0.3, 0.2));
    let [one, other] = [&emitter, &concave()].map(|emitter| hessian_to(&receiver, emitter, &[], 1e-13).unwrap());
    assert!(norm(one.matrix - other.matrix) <= one.error + other.error);
}

#[test]
fn what_sees_nothing_has_none() {
    let away = receiver_at(DVec3::new(0.2, -0.1, 0.0), DVec3::NEG_Z);
    for emitter in varying(triangle().polygon()).into_iter().chain([triangle()]) {
        let dark = hessian_to(&away, &emitter, &[], 1e-12).unwrap();
        assert_eq!((dark.matrix, dark.error, dark.method), (DMat3::ZERO, 0.0, Method::Zero));
    }
    assert!(matches!(hessian_to(&away, &triangle(), &[], f64::NAN), Err(Error::Tolerance { .. })));
}
