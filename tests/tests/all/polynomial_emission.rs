//! The closed form and the Gauss rule for polynomial emission against enclosures, degree by degree, near and far.

use radgrad_core::{Answer, DVec3, Emission, Emitter, Polygon, Polynomial, Receiver, evaluate_to};
use radgrad_oracle::{Enclosure, enclose};

/// An L in a tilted plane, its vertices exactly in it.
fn polygon() -> Polygon {
    let (along, across) = (DVec3::new(0.75, 0.0, 0.5), DVec3::new(0.0, -1.0, 0.0));
    let corners = [(0.0, 0.0), (1.5, 0.25), (1.25, 0.75), (0.5, 0.5), (0.25, 1.25), (-0.25, 1.0)];
    Polygon::new(corners.map(|(a, b)| DVec3::new(-0.25, 0.25, 1.0) + along * a + across * b).to_vec()).unwrap()
}

/// Every term up to the degree: a constant with ripples of both signs.
fn emission(degree: u8) -> Emission {
    let triples = (0..=degree).flat_map(|i| (0..=degree - i).flat_map(move |j| (0..=degree - i - j).map(move |k| [i, j, k])));
    let coefficient = |index: usize| if index == 0 { 2.0 } else { (index * 37 % 16) as f64 / 8.0 - 0.9375 };
    let terms = triples.enumerate().map(|(index, powers)| (coefficient(index), powers));
    Emission::Polynomial(Polynomial::new(DVec3::new(0.25, -0.25, 1.125), terms).unwrap())
}

/// Receivers that see the emitter whole, clipped, from a hair's breadth off its middle and off an edge's extension, grazing and
/// from afar.
fn receivers() -> Vec<(&'static str, Receiver)> {
    let polygon = polygon();
    let vertices = polygon.vertices();
    let middle = (vertices[0] + vertices[1] + vertices[3]) / 3.0;
    let lit = polygon.normal();
    let [beside, past] = [vertices[0] - vertices[1], vertices[1] + (vertices[1] - vertices[0]) * 0.5];
    let cases = [
        ("whole", middle + lit * 1.5, -lit),
        ("clipped", middle + lit * 0.75, beside + lit * 0.25),
        ("contact", middle + lit * 1e-5, beside - lit),
        ("past an edge", past + lit * 1e-6, beside * 2.0 - lit),
        ("grazing", middle - beside * 3.0 + lit * 1e-3, beside),
        ("at ten sizes", middle + lit * 10.0 + beside * 5.0, -lit),
        ("far", middle + lit * 1e5 + beside * 1e5, -lit),
    ];
    cases.map(|(name, x, normal)| (name, Receiver::new(x, normal, 0.75).unwrap())).to_vec()
}

/// The enclosures are 24 digits wide.
const WIDTH: f64 = 1e-6;

fn assert_within(answer: &Answer, truth: &Enclosure, case: &str) {
    let error = truth.radiosity.error_of(answer.radiosity);
    assert!(error <= answer.radiosity_error * (1.0 + WIDTH), "{case}: {error:e}, {answer:?}");
    let components = answer.gradient.to_array();
    let error = (0..3).map(|i| truth.gradient[i].error_of(components[i])).fold(0.0, |sum: f64, e| sum.hypot(e));
    assert!(error <= answer.gradient_error * (1.0 + WIDTH), "{case}: {error:e}, {answer:?}");
}

#[test]
fn no_bound_is_smaller_than_its_error_and_the_default_tolerance_is_met() {
    for degree in [0, 1, 2, 3, 5, 8] {
        let emitter = Emitter::new(polygon(), emission(degree)).unwrap();
        for (name, receiver) in receivers() {
            let truth = enclose(&receiver, &emitter, 24).unwrap();
            for tolerance in [1.0, 1e-12, 0.0] {
                let case = format!("{name}, degree {degree}, tolerance {tolerance:e}");
                let answer = evaluate_to(&receiver, &emitter, &[], tolerance).unwrap();
                assert_within(&answer, &truth, &case);
                assert!(tolerance == 0.0 || answer.meets(tolerance), "{case}: {answer:?}");
            }
        }
    }
}
