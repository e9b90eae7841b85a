//! In contact at any height, down to 1e-307 of the emitter's size: every tolerance is met, whatever the horizon cuts.

use glam::DVec3;
use radgrad_core::{Emission, Emitter, Error, Method, Polygon, Polynomial, Receiver, evaluate_digits, evaluate_to};
use radgrad_tests::decimal::Decimal;

/// Over the inside, just off a corner, over it, over an edge to rounding, and beside the emitter.
const FEET: [[f64; 2]; 5] = [[0.0, 0.0], [0.3, 0.2 + 1e-9], [0.3, 0.2], [-0.05, -0.3], [2.0, 0.1]];

/// Facing the emitter, tilted, edge-on to it, and turned away by as little as the height.
const NORMALS: [[f64; 3]; 6] =
    [[0.1, 0.2, 1.0], [1.0, -0.3, 0.2], [1.0, 0.3, -1e-3], [1.0, 0.3, 0.0], [-1.0, 0.2, 1e-9], [-1.0, 0.3, 1e-250]];

fn emissions() -> [Emission; 3] {
    let cubic = [(1.0, [0, 0, 0]), (0.5, [1, 0, 0]), (0.25, [2, 1, 0])];
    [
        Emission::Constant(1.5),
        Emission::at_vertices(vec![1.0, 2.5, 0.5]),
        Emission::Polynomial(Polynomial::new(DVec3::ZERO, cubic).unwrap()),
    ]
}

#[test]
fn every_tolerance_is_met_at_any_height() {
    let (mut answered, mut out_of_range) = (0, 0);
    let cases = [1e-12, 1e-100, 1e-200, 1e-307].into_iter().flat_map(|h| FEET.map(|foot| (h, foot)));
    for (height, foot) in cases {
        let vertices = [[0.3, 0.2], [-0.4, -0.8], [-0.7, 0.9]].map(|[x, y]| DVec3::new(x - foot[0], y - foot[1], height));
        for (normal, emission) in NORMALS.into_iter().flat_map(|n| emissions().map(|e| (n, e))) {
            let case = format!("{foot:?} at {height:e} facing {normal:?}, {emission:?}");
            let emitter = Emitter::new(Polygon::new(vertices.to_vec()).unwrap(), emission).unwrap();
            let receiver = Receiver::new(DVec3::ZERO, normal.into(), 0.8).unwrap();
            for tolerance in [1e-12, 1e-15] {
                let answer = match evaluate_to(&receiver, &emitter, &[], tolerance) {
                    Err(Error::Overflow { quantity: "gradient" } | Error::Underflow { quantity: "radiosity" }) => {
                        out_of_range += 1;
                        continue;
                    }
                    answer => answer.unwrap(),
                };
                assert!(answer.meets(tolerance), "{case} to {tolerance:e}: {answer:?}");
                if answer.method != Method::Zero {
                    answered += 1;
                    let digits = evaluate_digits(&receiver, &emitter, &[], 30).unwrap();
                    let truth: Decimal = digits.radiosity.parse().unwrap();
                    assert!(truth.error_of(answer.radiosity) <= answer.radiosity_error, "{case}: {answer:?} for {digits:?}");
                }
            }
        }
    }
    println!("{answered} answered, {out_of_range} out of range");
    assert!(answered > 450 && out_of_range > 0 && out_of_range < 30);
}
