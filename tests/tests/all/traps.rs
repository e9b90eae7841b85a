//! Places where programs of this kind have given NaN, a wrong sign or a silent wrong value.
//!
//! Zero is exact, with a zero bound; limits are met; an invalid input is refused with its value, place and rule.

use glam::DVec3;
use radgrad_core::{Answer, Emission, Emitter, Error, Method, Polygon, Receiver, evaluate};
use radgrad_tests::{FORMS, direct};

const fn point(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// The square [-1, 1]^2 in the plane z = 0, lit from above.
const SQUARE: [DVec3; 4] = [point(-1.0, -1.0, 0.0), point(1.0, -1.0, 0.0), point(1.0, 1.0, 0.0), point(-1.0, 1.0, 0.0)];

/// A triangle whose plane, x + 2y + 4z = 8, has no component 0 but holds points with few bits.
const TILTED: [DVec3; 3] = [point(8.0, 0.0, 0.0), point(0.0, 4.0, 0.0), point(0.0, 0.0, 2.0)];

fn emitters(vertices: &[DVec3]) -> [Emitter; 2] {
    [Emission::Constant(2.0), Emission::gradient(2.0, point(0.25, -0.5, 0.125))]
        .map(|emission| Emitter::new(Polygon::new(vertices.to_vec()).unwrap(), emission).unwrap())
}

fn receiver(position: DVec3, normal: DVec3) -> Receiver {
    Receiver::new(position, normal, 1.0).unwrap()
}

const ZERO: Answer =
    Answer { radiosity: 0.0, gradient: DVec3::ZERO, radiosity_error: 0.0, gradient_error: 0.0, method: Method::Zero };

fn assert_exactly_zero(receiver: &Receiver, emitter: &Emitter) {
    assert_eq!(evaluate(receiver, emitter, &[]).unwrap(), ZERO, "{receiver:?}");
    for (name, form) in FORMS {
        assert_eq!(form(receiver, emitter).unwrap(), (0.0, DVec3::ZERO), "{name} at {receiver:?}");
    }
}

/// Normals along, across and askew to the planes of both emitters.
fn normals() -> [DVec3; 6] {
    [DVec3::Z, -DVec3::Z, DVec3::X, point(1.0, 2.0, 4.0), point(-1.0, -2.0, -4.0), point(0.3, -0.2, -0.5)]
}

#[test]
fn in_the_emitters_plane_there_is_exactly_nothing() {
    // Two vertices, two on edges, one inside, one outside, one outside on the line of an edge.
    let square = [
        SQUARE[0],
        SQUARE[2],
        point(0.25, -1.0, 0.0),
        point(1.0, 0.0, 0.0),
        point(0.5, 0.25, 0.0),
        point(3.0, 0.5, 0.0),
        point(5.0, 1.0, 0.0),
    ];
    let tilted = [
        TILTED[0],
        TILTED[1],
        point(4.0, 2.0, 0.0),
        point(0.0, 2.0, 1.0),
        point(2.0, 1.0, 1.0),
        point(-4.0, 4.0, 1.0),
        point(16.0, -4.0, 0.0),
    ];
    for (emitters, positions) in [(emitters(&SQUARE), square), (emitters(&TILTED), tilted)] {
        for (emitter, position) in emitters.iter().flat_map(|e| positions.map(|p| (e, p))) {
            for normal in normals() {
                assert_exactly_zero(&receiver(position, normal), emitter);
            }
        }
    }
}

#[test]
fn behind_the_emitter_there_is_exactly_nothing() {
    for (emitter, normal) in emitters(&SQUARE).iter().flat_map(|e| normals().map(|n| (e, n))) {
        for position in [point(0.3, 0.1, -1e-300), point(0.3, 0.1, -0.5), point(1.0, 1.0, -1e-12), point(4.0, 0.0, -1e5)] {
            assert_exactly_zero(&receiver(position, normal), emitter);
        }
    }
}

#[test]
fn an_emitter_below_the_horizon_or_touching_it_gives_exactly_nothing() {
    for emitter in emitters(&SQUARE) {
        assert_exactly_zero(&receiver(point(0.25, 0.5, 1.0), DVec3::Z), &emitter);
        // The horizon runs along the edge x = 1, then through the vertex (1, 1).
        assert_exactly_zero(&receiver(point(1.0, 0.5, 1.0), DVec3::X), &emitter);
        assert_exactly_zero(&receiver(point(1.0, 1.0, 1.0), point(1.0, 1.0, 0.0)), &emitter);
    }
}

#[test]
fn a_horizon_along_a_diagonal_leaves_the_triangle() {
    let triangle = [SQUARE[0], SQUARE[1], SQUARE[2]];
    for (whole, half) in emitters(&SQUARE).iter().zip(emitters(&triangle)) {
        let receiver = receiver(point(0.5, 0.5, 1.0), point(1.0, -1.0, 0.0));
        let expected = direct::radiosity_and_gradient(&receiver, &half);
        for (name, form) in FORMS {
            for emitter in [whole, &half] {
                let computed = form(&receiver, emitter).unwrap();
                let error = (computed.0 - expected.0).abs() + (computed.1 - expected.1).length();
                assert!(error < 1e-13 * expected.1.length(), "{name}: {computed:?} for {expected:?}");
            }
        }
    }
}

#[test]
fn edges_seen_at_nearly_pi_leave_the_limit() {
    // Facing the emitter from just above it, x sees it fill the hemisphere, half of it from an edge, a quarter from a corner.
    for (position, share) in [(point(0.25, 0.5, 0.0), 1.0), (point(1.0, 0.5, 0.0), 0.5), (point(1.0, 1.0, 0.0), 0.25)] {
        for height in [1e-3, 1e-6, 1e-9, 1e-12, 1e-100] {
            for emitter in emitters(&SQUARE) {
                let receiver = receiver(position + height * DVec3::Z, -DVec3::Z);
                let answer = evaluate(&receiver, &emitter, &[]).unwrap();
                let limit = share * emitter.emission_at(position);
                // The difference is the part of the hemisphere beyond the emitter, and the change of linear emission near x: O(h).
                let error = (answer.radiosity - limit).abs();
                assert!(error < 100.0 * height + 4e-15, "{answer:?} for {limit} at height {height:e}");
                // At 1e-100 no bound is proven and it may be infinite; the value is right all the same.
                assert!(answer.radiosity_error < 1e-12 || height < 1e-12, "{answer:?} at height {height:e}");
                assert!(answer.gradient.is_finite(), "{answer:?} at height {height:e}");
            }
        }
    }
}

#[test]
fn a_vertex_on_an_edge_is_no_degeneracy() {
    let with_middle = [SQUARE[0], point(0.25, -1.0, 0.0), SQUARE[1], SQUARE[2], point(0.0, 1.0, 0.0), SQUARE[3]];
    for (plain, split) in emitters(&SQUARE).iter().zip(emitters(&with_middle)) {
        // The last is over the added vertex.
        for position in [point(0.3, 0.2, 1.0), point(3.0, -1.0, 0.5), point(0.25, -1.0, 0.5)] {
            let receiver = receiver(position, point(-0.25, 0.125, -1.0));
            for (name, form) in FORMS {
                let [a, b] = [plain, &split].map(|emitter| form(&receiver, emitter).unwrap());
                assert!((a.0 - b.0).abs() < 1e-14 * a.0, "{name}: {a:?} and {b:?}");
                assert!((a.1 - b.1).length() < 1e-13 * a.1.length(), "{name}: {a:?} and {b:?}");
            }
        }
    }
}

#[test]
fn a_concave_emitter_counts_its_own_area_only() {
    // An L: the square [0, 2]^2 without [1, 2]^2. Its hull is too large, and so are the triangles from vertex 0 unless they
    // have signs.
    let l = [
        point(0.0, 2.0, 0.0),
        point(0.0, 0.0, 0.0),
        point(2.0, 0.0, 0.0),
        point(2.0, 1.0, 0.0),
        point(1.0, 1.0, 0.0),
        point(1.0, 2.0, 0.0),
    ];
    for emitter in emitters(&l) {
        for normal in [point(0.1, -0.2, -1.0), point(1.0, 0.2, -0.1), point(-0.5, 1.0, -0.2)] {
            let receiver = receiver(point(1.25, 1.5, 0.75), normal);
            let expected = direct::radiosity_and_gradient(&receiver, &emitter);
            for (name, form) in FORMS {
                let computed = form(&receiver, &emitter).unwrap();
                let error =
                    [(computed.0 - expected.0).abs() / expected.0, (computed.1 - expected.1).length() / expected.1.length()];
                assert!(error.iter().all(|e| *e < 2e-13), "{name}: {computed:?} for {expected:?}");
            }
        }
    }
}

#[test]
fn a_gradient_too_large_for_a_double_is_refused_and_the_value_is_not_lost() {
    let tiny = SQUARE.map(|v| v * 1e-200);
    let emitter = Emitter::new(Polygon::new(tiny.to_vec()).unwrap(), Emission::Constant(1e200)).unwrap();
    let receiver = receiver(point(0.0, 0.0, 1e-200), -DVec3::Z);
    for (name, form) in FORMS {
        assert_eq!(form(&receiver, &emitter), Err(Error::Overflow { quantity: "gradient" }), "{name}");
    }
    let value = radgrad_core::radiosity(&receiver, &emitter).unwrap();
    assert!((value / 1e200 - 0.554_0).abs() < 1e-3, "{value:e}");
}

fn polygon_error(vertices: &[DVec3]) -> String {
    Polygon::new(vertices.to_vec()).unwrap_err().to_string()
}

#[test]
fn wrong_polygons_are_refused_with_value_and_place() {
    let [a, b, c, d] = SQUARE;
    let cases: [(&[DVec3], &str); 10] = [
        (&[a, b], "a polygon needs at least 3 vertices, this one has 2"),
        (&[a, b, point(f64::NAN, 1.0, 0.0)], "vertex 2 is [NaN, 1, 0]: coordinates must be finite"),
        (&[a, point(0.0, f64::INFINITY, 0.0), c], "vertex 1 is [0, inf, 0]: coordinates must be finite"),
        (&[a, b, b, c], "vertices 1 and 2 are the same point [1, -1, 0]: leave one out"),
        (&[a, b, c, a], "vertices 3 and 0 are the same point [-1, -1, 0]: leave one out"),
        (&[a, DVec3::ZERO, c], "the polygon has no area: all 3 vertices are on one line"),
        (&[a, point(1.0, 2.0, 0.0), b, d], "edges 0 and 2 meet: the polygon must be simple"),
        (&[a, b, c, point(1.0, 0.0, 0.0), d], "edges 1 and 2 meet: the polygon must be simple"),
        (&[a, b, DVec3::ZERO, c, d, DVec3::ZERO], "edges 1 and 4 meet: the polygon must be simple"),
        (&[a, b, c, point(-1.0, 1.0, 0.5)], "off the plane of the polygon (allowed "),
    ];
    for (vertices, expected) in cases {
        let message = polygon_error(vertices);
        assert!(message.contains(expected), "{message}\nfor {expected}");
    }
}

#[test]
fn wrong_receivers_are_refused_with_value_and_rule() {
    let cases = [
        (point(0.0, f64::NAN, 0.0), DVec3::Z, 1.0, "receiver position is [0, NaN, 0]: coordinates must be finite"),
        (DVec3::ZERO, DVec3::ZERO, 1.0, "receiver normal is [0, 0, 0]: it must be finite and not zero"),
        (DVec3::ZERO, point(0.0, 0.0, f64::INFINITY), 1.0, "receiver normal is [0, 0, inf]: it must be finite and not zero"),
        (DVec3::ZERO, DVec3::Z, -0.25, "reflectance is -0.25: it must be between 0 and 1"),
        (DVec3::ZERO, DVec3::Z, 1.5, "reflectance is 1.5: it must be between 0 and 1"),
        (DVec3::ZERO, DVec3::Z, f64::NAN, "reflectance is NaN: it must be between 0 and 1"),
    ];
    for (position, normal, reflectance, expected) in cases {
        assert_eq!(Receiver::new(position, normal, reflectance).unwrap_err().to_string(), expected);
    }
}

#[test]
fn wrong_emissions_are_refused_with_value_and_place() {
    let cases = [
        (Emission::Constant(f64::NAN), "emission value is NaN: it must be finite"),
        (Emission::gradient(f64::INFINITY, DVec3::X), "emission value at vertex 0 is inf: it must be finite"),
        (Emission::gradient(1.0, point(0.0, f64::NAN, 0.0)), "emission gradient component 1 is NaN: it must be finite"),
        (Emission::at_vertices(vec![1.0, 2.0, f64::NAN, 1.0]), "emission at vertex 2 is NaN: it must be finite"),
        (Emission::at_vertices(vec![1.0, 2.0, 3.0]), "emission has 3 values for 4 vertices: give one per vertex"),
        (Emission::at_vertices(vec![1.0, 2.0, 3.0, 2.5]), "but the affine function through the vertices gives "),
    ];
    for (emission, expected) in cases {
        let message = Emitter::new(Polygon::new(SQUARE.to_vec()).unwrap(), emission).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}\nfor {expected}");
    }
}
