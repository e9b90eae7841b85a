//! Polynomial emission against quadrature of Eq. 1 and its differentiated kernel, against the forms of lower degree, and with
//! occluders.

use std::f64::consts::PI;

use radgrad_core::{DVec3, Emission, Emitter, Method, Polygon, Polynomial, Receiver, evaluate, evaluate_to, radiosity};

const TRIANGLE: [[f64; 3]; 3] = [[-0.9, 0.1, 1.2], [0.4, -0.9, 1.1], [-0.1, 0.7, 1.3]];

fn facing_down(points: &[[f64; 3]]) -> Polygon {
    let points: Vec<DVec3> = points.iter().map(|&p| p.into()).collect();
    let polygon = Polygon::new(points.clone()).unwrap();
    if polygon.normal().z < 0.0 { polygon } else { Polygon::new(points.into_iter().rev().collect()).unwrap() }
}

/// A polynomial with a term of every exponent triple up to the degree, coefficients of about 1 and both signs.
fn dense(degree: u8) -> Polynomial {
    let triples = (0..=degree).flat_map(|i| (0..=degree - i).flat_map(move |j| (0..=degree - i - j).map(move |k| [i, j, k])));
    let terms = triples.enumerate().map(|(index, powers)| ((index * 37 % 16) as f64 / 8.0 - 0.875, powers));
    Polynomial::new(DVec3::new(-0.2, 0.1, 1.0), terms).unwrap()
}

/// Nodes and weights of the Gauss-Legendre rule with five nodes on 24 panels of [0, 1].
fn rule() -> Vec<(f64, f64)> {
    let half = [
        (0.0, 64.0 / 225.0),
        (0.538_469_310_105_683_1, 0.239_314_335_249_683_24),
        (0.906_179_845_938_664, 0.118_463_442_528_094_54),
    ];
    let signed = half.iter().flat_map(|&(t, w)| if t == 0.0 { vec![(t, w)] } else { vec![(t, w), (-t, w)] });
    signed.flat_map(|(t, w)| (0..24).map(move |i| ((f64::from(i) + 0.5 * (1.0 + t)) / 24.0, w / 24.0))).collect()
}

/// Radiosity and gradient by quadrature over the part of the polygon above the horizon. That part's edge on the horizon moves with
/// x, but the strip it gains or loses is seen with `n1.r = 0`.
fn by_quadrature(receiver: &Receiver, emitter: &Emitter) -> (f64, DVec3) {
    let (x, n1, n2) = (receiver.position(), receiver.normal(), emitter.polygon().normal());
    let vertices = emitter.polygon().vertices();
    let height = |v: DVec3| n1.dot(v - x);
    let mut above = Vec::new();
    for (i, &from) in vertices.iter().enumerate() {
        let to = vertices[(i + 1) % vertices.len()];
        if height(from) > 0.0 {
            above.push(from);
        }
        if (height(from) > 0.0) != (height(to) > 0.0) {
            above.push(from + (to - from) * (height(from) / (height(from) - height(to))));
        }
    }
    let rule = rule();
    let (mut value, mut gradient) = (0.0, DVec3::ZERO);
    for pair in above[1..].windows(2) {
        let (a, b) = (pair[0] - above[0], pair[1] - above[0]);
        // Signed: the triangles of the fan may overlap.
        let twice_area = a.cross(b).dot(n2);
        for &(u, weight_u) in &rule {
            for &(v, weight_v) in &rule {
                let y = above[0] + (a + (b - a) * v) * u;
                let r = y - x;
                let (rr, up, down) = (r.length_squared(), n1.dot(r), -n2.dot(r));
                let weight = twice_area * u * weight_u * weight_v * emitter.emission_at(y) / (rr * rr);
                value += weight * up * down;
                gradient += weight * (n2 * up - n1 * down + r * (4.0 * up * down / rr));
            }
        }
    }
    let factor = receiver.reflectance() / PI;
    (factor * value, factor * gradient)
}

/// The same function as constant or linear emission and as a polynomial around another origin.
#[test]
fn low_degrees_agree_with_constant_and_linear_emission_to_rounding() {
    let polygon = facing_down(&TRIANGLE);
    let slope = DVec3::new(0.5, -0.25, 0.0);
    let origin = DVec3::new(0.5, 0.25, 2.0);
    let at_first = 2.0 + slope.dot(polygon.vertices()[0] - origin);
    let constant = (Emission::Constant(3.5), Polynomial::new(origin, [(3.5, [0, 0, 0])]));
    let terms = [(2.0, [0, 0, 0]), (slope.x, [1, 0, 0]), (slope.y, [0, 1, 0])];
    let linear = (Emission::gradient(at_first, slope), Polynomial::new(origin, terms));
    for (plain, polynomial) in [constant, linear] {
        let plain = Emitter::new(polygon.clone(), plain).unwrap();
        let polynomial = Emitter::new(polygon.clone(), Emission::Polynomial(polynomial.unwrap())).unwrap();
        assert!((plain.emission_gradient() - polynomial.emission_gradient()).length() < 1e-15);
        for normal in [DVec3::new(0.1, 0.2, 1.0), DVec3::new(1.0, -0.3, 0.2)] {
            let receiver = Receiver::new(DVec3::new(0.2, -0.1, 0.5), normal, 0.7).unwrap();
            let screen = facing_down(&[[0.0, -1.0, 0.6], [0.0, 1.0, 0.6], [-1.0, 1.0, 0.6], [-1.0, -1.0, 0.6]]);
            for occluders in [vec![], vec![screen]] {
                let [a, b] = [&plain, &polynomial].map(|emitter| evaluate(&receiver, emitter, &occluders).unwrap());
                assert!((a.radiosity - b.radiosity).abs() <= 1e-15, "{a:?} {b:?}");
                assert!((a.gradient - b.gradient).length() <= 2e-15, "{a:?} {b:?}");
                assert_eq!(b.method, Method::ClosedForm);
            }
        }
    }
}

/// From the origin a screen whose edge is at x = 0.25, z = 1 hides the part beyond x = 0.5 at z = 2.
#[test]
fn a_screen_leaves_the_radiosity_of_what_it_does_not_hide() {
    let ceiling =
        |left: f64, right: f64| facing_down(&[[left, -1.0, 2.0], [right, -1.0, 2.0], [right, 1.0, 2.0], [left, 1.0, 2.0]]);
    let screen = facing_down(&[[0.25, -3.0, 1.0], [5.0, -3.0, 1.0], [5.0, 3.0, 1.0], [0.25, 3.0, 1.0]]);
    let receiver = |x: DVec3| Receiver::new(x, DVec3::new(0.1, -0.2, 1.0), 0.8).unwrap();
    for degree in 0..=6 {
        let lamp = |polygon| Emitter::new(polygon, Emission::Polynomial(dense(degree))).unwrap();
        let whole = lamp(ceiling(-1.0, 1.0));
        let shadowed = evaluate_to(&receiver(DVec3::ZERO), &whole, std::slice::from_ref(&screen), 1e-15).unwrap();
        let unhidden = evaluate_to(&receiver(DVec3::ZERO), &lamp(ceiling(-1.0, 0.5)), &[], 1e-15).unwrap();
        assert!(
            (shadowed.radiosity - unhidden.radiosity).abs() <= shadowed.radiosity_error + unhidden.radiosity_error,
            "{shadowed:?} {unhidden:?}"
        );
        assert!(shadowed.meets(1e-15));
        let step = 1e-4;
        for (axis, expected) in DVec3::AXES.into_iter().zip(shadowed.gradient.to_array()) {
            let moved =
                |t: f64| evaluate_to(&receiver(axis * t), &whole, std::slice::from_ref(&screen), 1e-16).unwrap().radiosity;
            let difference = (8.0 * (moved(step) - moved(-step)) - (moved(2.0 * step) - moved(-2.0 * step))) / (12.0 * step);
            assert!((difference - expected).abs() <= 1e-11, "degree {degree}, {axis}: {difference} {expected}");
        }
    }
}

#[test]
fn a_far_origin_costs_digits_that_the_bound_owns_up_to() {
    let polygon = facing_down(&TRIANGLE);
    let receiver = Receiver::new(DVec3::new(0.2, -0.1, 0.0), DVec3::Z, 1.0).unwrap();
    // (x - 1000)^3 around the far origin, and multiplied out around zero.
    let near = Polynomial::new(DVec3::new(1000.0, 0.0, 0.0), [(1.0, [3, 0, 0])]).unwrap();
    let out = [(1.0, [3, 0, 0]), (-3e3, [2, 0, 0]), (3e6, [1, 0, 0]), (-1e9, [0, 0, 0])];
    let out = Polynomial::new(DVec3::ZERO, out).unwrap();
    let [a, b] = [near, out].map(|p| {
        let emitter = Emitter::new(polygon.clone(), Emission::Polynomial(p)).unwrap();
        (evaluate_to(&receiver, &emitter, &[], 1e-15).unwrap(), radiosity(&receiver, &emitter).unwrap())
    });
    assert!((a.0.radiosity - b.0.radiosity).abs() <= a.0.radiosity_error + b.0.radiosity_error, "{a:?} {b:?}");
    assert!(a.0.meets(1e-15) && b.0.meets(1e-15));
    assert!((a.1 - a.0.radiosity).abs() < 1e-12 * a.0.radiosity.abs());
}

/// 4 - u^2 - v^2 seen from ever farther away, over the emitter and beside it: the closed form would lose `(D/s)^2` twice.
#[test]
fn far_away_the_digits_stay() {
    let square = facing_down(&[[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]]);
    let bowl = Polynomial::new(DVec3::ZERO, [(4.0, [0, 0, 0]), (-1.0, [2, 0, 0]), (-1.0, [0, 2, 0])]).unwrap();
    let lamp = Emitter::new(square, Emission::Polynomial(bowl)).unwrap();
    // int B dA = 16 - 4/3 - 4/3.
    let power = 40.0 / 3.0;
    for exponent in 1..=15 {
        let distance = libm::exp10(f64::from(exponent));
        for direction in [DVec3::NEG_Z, DVec3::new(0.8, 0.0, -0.6)] {
            let receiver = Receiver::new(direction * distance, -direction, 1.0).unwrap();
            let answer = evaluate(&receiver, &lamp, &[]).unwrap();
            assert!(answer.meets(1e-12), "{answer:?}");
            assert_eq!(answer.method, Method::Quadrature);
            let expected = power * -direction.z / (PI * distance * distance);
            let error = (answer.radiosity / expected - 1.0).abs();
            assert!(error <= 4.0 / (distance * distance) + 1e-14, "1e{exponent}: off by {error:e}");
        }
    }
}

#[test]
fn no_emission_gives_exactly_zero() {
    let receiver = Receiver::new(DVec3::new(0.2, -0.1, 0.0), DVec3::Z, 1.0).unwrap();
    let none = [Polynomial::new(DVec3::ZERO, []).unwrap(), Polynomial::new(DVec3::ZERO, [(0.0, [3, 0, 0])]).unwrap()];
    for emission in
        none.map(Emission::Polynomial).into_iter().chain([Emission::Constant(0.0), Emission::gradient(0.0, DVec3::ZERO)])
    {
        let dark = evaluate(&receiver, &Emitter::new(facing_down(&TRIANGLE), emission).unwrap(), &[]).unwrap();
        assert_eq!((dark.radiosity, dark.gradient, dark.radiosity_error, dark.gradient_error), (0.0, DVec3::ZERO, 0.0, 0.0));
        assert_eq!(dark.method, Method::Zero);
    }
}

/// Emission of both signs that integrates to little: double-double does not reach the tolerance, and the best method says how
/// near it came.
#[test]
fn where_no_method_meets_the_tolerance_the_smallest_bound_answers() {
    let square = facing_down(&[[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]]);
    let waves = Polynomial::new(DVec3::ZERO, [(1.0, [12, 0, 0]), (-0.0769, [0, 0, 0])]).unwrap();
    let lamp = Emitter::new(square, Emission::Polynomial(waves)).unwrap();
    let receiver = Receiver::new(DVec3::new(0.0, 0.0, -1e9), DVec3::Z, 1.0).unwrap();
    let answer = evaluate_to(&receiver, &lamp, &[], 0.0).unwrap();
    let best = if cfg!(feature = "arbitrary-precision") { "arbitrary-precision" } else { "quadrature" };
    assert_eq!(answer.method.name(), best);
    assert!(answer.radiosity_error < 1e-8 * answer.radiosity.abs(), "{answer:?}");
    // int x^12 dA = 4/13.
    let expected = (4.0 / 13.0 - 4.0 * 0.0769) / (PI * 1e18);
    assert!((answer.radiosity - expected).abs() < 1e-10 * expected.abs(), "{answer:?} {expected}");
}

#[test]
fn high_degrees_have_certificates_too() {
    for degree in [20_u8, 40, 60] {
        let terms = [(1.0, [degree, 0, 0]), (-2.0, [degree / 2, degree / 2, 0]), (0.5, [0, 0, degree - 3]), (1.0, [1, 2, 1])];
        let polynomial = Polynomial::new(DVec3::new(-0.2, 0.1, 0.3), terms).unwrap();
        let emitter = Emitter::new(facing_down(&TRIANGLE), Emission::Polynomial(polynomial)).unwrap();
        for (position, normal) in
            [(DVec3::new(0.2, -0.1, 0.0), DVec3::new(0.1, 0.2, 1.0)), (DVec3::new(0.4, 0.1, 0.6), DVec3::new(1.0, -0.3, 0.2))]
        {
            let receiver = Receiver::new(position, normal, 0.7).unwrap();
            let answer = evaluate(&receiver, &emitter, &[]).unwrap();
            let (value, gradient) = by_quadrature(&receiver, &emitter);
            let case = format!("degree {degree}, normal {normal}, {answer:?}, {value} {gradient}");
            assert!((answer.radiosity - value).abs() <= 1e-12 * value.abs() + answer.radiosity_error, "{case}");
            assert!((answer.gradient - gradient).length() <= 1e-11 * gradient.length() + answer.gradient_error, "{case}");
            assert!(answer.meets(1e-12), "{case}");
        }
    }
}
