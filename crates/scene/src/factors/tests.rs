use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, radiosity};

use super::exchange::exchange;

fn polygon(points: &[[f64; 3]]) -> Polygon {
    Polygon::new(points.iter().map(|&p| p.into()).collect()).unwrap()
}

fn floor() -> Polygon {
    polygon(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
}

fn ceiling(z: f64) -> Polygon {
    polygon(&[[0.0, 0.0, z], [0.0, 1.0, z], [1.0, 1.0, z], [1.0, 0.0, z]])
}

#[test]
fn squares_that_face_each_other_exchange_what_the_closed_form_says() {
    // Howell C-11, a = b = c.
    let expected = 0.199_824_895_698_387_4;
    let found = exchange(&floor(), &ceiling(1.0));
    assert!((found.area - expected).abs() <= 1e-15 + found.error && found.error < 1e-12, "{found:?}");
}

#[test]
fn squares_with_a_common_edge_exchange_what_the_closed_form_says() {
    // Howell C-14, l = w = h.
    let expected = 0.200_043_776_075_403_3;
    let wall = polygon(&[[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]]);
    let found = exchange(&floor(), &wall);
    assert!((found.area - expected).abs() <= 1e-15 + found.error && found.error < 1e-12, "{found:?}");
    // A wall that also goes down: its lower half exchanges nothing.
    let wall = polygon(&[[0.0, 0.0, -1.0], [0.0, 1.0, -1.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]]);
    let found = exchange(&floor(), &wall);
    assert!((found.area - expected).abs() <= 1e-15 + found.error && found.error < 1e-12, "{found:?}");
}

/// Faces of a tetrahedron, seen from inside: no two are parallel or perpendicular, and all have common edges.
#[test]
fn faces_of_a_tetrahedron_see_nothing_but_each_other() {
    let [a, b, c, d] = [[0.0, 0.0, 0.0], [1.3, 0.1, 0.2], [0.3, 1.1, -0.1], [0.4, 0.3, 0.9]];
    let faces = [[a, b, c], [a, d, b], [b, d, c], [c, d, a]].map(|face| polygon(&face));
    for i in 0..4 {
        let others = (0..4).filter(|&j| j != i).map(|j| exchange(&faces[i], &faces[j]));
        let (sum, error) = others.fold((0.0, 0.0), |(sum, error), found| (sum + found.area, error + found.error));
        let area = faces[i].area();
        assert!((sum - area).abs() <= error && error < 1e-11 * area, "{sum} {area} {error:e}");
    }
}

#[test]
fn far_away_the_exchange_keeps_its_digits_and_joins_the_sum_over_edges() {
    for distance in [3.0, 5.0, 9.0, 17.0, 33.0, 1e3, 1e6] {
        let found = exchange(&floor(), &ceiling(distance));
        // Howell C-11, with the digits of the differences.
        let (x, s) = (1.0 / distance, (1.0 + 1.0 / (distance * distance)).sqrt());
        let series = libm::log1p(x * x * x * x / (1.0 + 2.0 * x * x)) * -0.5;
        let expected =
            2.0 / (std::f64::consts::PI * x * x) * (series.abs() + 2.0 * x * s * libm::atan(x / s) - 2.0 * x * libm::atan(x));
        let slack = 1e-15 / (x * x);
        assert!((found.area - expected).abs() <= found.error + slack, "{distance}: {found:?} {expected}");
        let digits = if distance > 10.0 { 3e-13 } else { 1e-9 };
        assert!(found.error <= digits * found.area, "{distance}: {found:?}");
    }
    let asymptotic = 1.0 / (std::f64::consts::PI * 1e12);
    assert!((exchange(&floor(), &ceiling(1e6)).area - asymptotic).abs() <= 1e-11 * asymptotic);
}

#[test]
fn any_two_triangles_exchange_the_same_both_ways_and_no_more_than_the_smaller() {
    let mut state = 7_u64;
    let mut uniform = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut seen = 0;
    for _ in 0..300 {
        let mut triangle = || Polygon::new((0..3).map(|_| DVec3::new(uniform(), uniform(), uniform())).collect()).unwrap();
        let (a, b) = (triangle(), triangle());
        let (there, back) = (exchange(&a, &b), exchange(&b, &a));
        assert!((there.area - back.area).abs() <= there.error + back.error, "{there:?} {back:?}");
        assert!(there.least() <= a.area().min(b.area()) && there.most() >= 0.0, "{there:?}");
        seen += usize::from(there.area > 0.0);
    }
    assert!(seen > 50, "{seen}");
}

#[test]
fn skew_triangles_exchange_what_their_points_see() {
    let mut state = 11_u64;
    let mut uniform = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let mut compared = 0;
    for i in 0..200 {
        let distance = 2.0 + f64::from(i % 50);
        let mut triangle = |z: f64| {
            let mut corner = || DVec3::new(uniform(), uniform(), 0.4 * uniform() + z);
            let [a, b, c] = [corner(), corner(), corner()];
            // The lower one looks up, the upper one down.
            let up = (b - a).cross(c - a).z > 0.0;
            Polygon::new(if up == (z == 0.0) { vec![a, b, c] } else { vec![c, b, a] })
        };
        let (Ok(from), Ok(to)) = (triangle(0.0), triangle(distance)) else { continue };
        let in_front = |a: &Polygon, b: &Polygon| a.vertices().iter().all(|v| (*v - b.vertices()[0]).dot(b.normal()) > 0.0);
        if !in_front(&from, &to) || !in_front(&to, &from) || from.area().min(to.area()) < 0.02 {
            continue;
        }
        let emitter = Emitter::new(to.clone(), Emission::Constant(1.0)).unwrap();
        let seen = |node: super::rule::Node| {
            let receiver = Receiver::new(node.point, from.normal(), 1.0).unwrap();
            node.share * from.area() * radiosity(&receiver, &emitter).unwrap()
        };
        let expected: f64 = super::rule::nodes(&from, 12).into_iter().map(seen).sum();
        let found = exchange(&from, &to);
        let slack = 1e-12 * expected;
        assert!((found.area - expected).abs() <= found.error + slack && found.error <= 1e-12, "{found:?} {expected}");
        compared += 1;
    }
    assert!(compared > 50, "{compared}");
}
