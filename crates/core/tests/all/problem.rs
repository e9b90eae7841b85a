//! Polygons, emissions and receivers: which exist, and which are refused.

use radgrad_core::{DVec3, Emission, Emitter, Error, Polygon, Polynomial, Receiver};
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

fn polygon(points: &[[f64; 3]]) -> Result<Polygon, Error> {
    Polygon::new(points.iter().map(|&p| p.into()).collect())
}

#[test]
fn wrong_polygons_are_named() {
    assert!(matches!(polygon(&[[0.0; 3], [1.0, 0.0, 0.0]]), Err(Error::TooFewVertices { count: 2 })));
    assert!(matches!(polygon(&[[0.0; 3], [1.0, f64::NAN, 0.0], [0.0, 1.0, 0.0]]), Err(Error::VertexNotFinite { index: 1, .. })));
    assert!(matches!(
        polygon(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3]]),
        Err(Error::RepeatedVertex { first: 3, second: 0, .. })
    ));
    assert!(matches!(polygon(&[[0.0; 3], [1.0; 3], [3.0; 3]]), Err(Error::ZeroArea { count: 3 })));
    let warped = [[0.0; 3], [549.0, 0.0, 0.0], [549.0, 559.0, 0.0032], [0.0, 559.0, 0.0]];
    let message = polygon(&warped).unwrap_err().to_string();
    assert!(message.contains("off the plane") && message.contains("5.59e2"), "{message}");
    let bow_tie = [[0.0; 3], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
    assert!(matches!(polygon(&bow_tie), Err(Error::NotSimple { first: 0, second: 2, .. })));
    let even_bow_tie = [[0.0; 3], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    assert!(matches!(polygon(&even_bow_tie), Err(Error::NotSimple { first: 0, second: 2, .. })));
    let spike = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.5, 0.0]];
    assert!(matches!(polygon(&spike), Err(Error::NotSimple { .. })));
}

#[test]
fn tolerances_follow_unit_and_origin() {
    let square = [[0.1, 0.2, 0.3], [1.1, 0.2, 0.4], [1.1, 1.2, 0.5], [0.1, 1.2, 0.4]];
    for scale in [1.0, 1e-200, 1e150, 3.7e-9] {
        for shift in [0.0, 1e6] {
            let moved = square.map(|p| p.map(|c| (c + shift) * scale));
            let p = polygon(&moved).unwrap();
            assert!(p.planarity_defect() <= 1e-9 * p.size());
        }
    }
    let needle = [[0.0; 3], [1.0, 0.0, 0.0], [0.5, 1e-12, 0.0]];
    assert_eq!(polygon(&needle).unwrap().normal(), DVec3::Z);
}

/// Polygons that were flat and simple: convex ones, thin ones, T-vertices, at any place and in any direction.
#[test]
fn what_rounding_explains_is_never_refused() {
    let mut random = ChaCha8Rng::seed_from_u64(511);
    let mut warped = 0;
    for case in 0..3000 {
        let mut uniform = |low: f64, high: f64| random.random_range(low..high);
        let width = libm::pow(10.0, uniform(-4.0, 0.0));
        let outline: &[[f64; 2]] = match case % 4 {
            0 => &[[0.0, 0.0], [1.0, 0.0], [1.0, width], [0.0, width]],
            1 => &[[0.0, 0.0], [1.0, 0.0], [1.0, width], [width, width], [width, 1.0], [0.0, 1.0]],
            2 => &[[0.0, 0.0], [0.3, 0.0], [0.3 + 1e-6, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 1.0], [0.0, 1.0]],
            _ => &[[0.0, 0.0], [1.0, -width], [1.0 + width, 0.0], [2.0, 0.1], [1.0, width]],
        };
        let (u, v) = DVec3::new(uniform(-1.0, 1.0), uniform(-1.0, 1.0), uniform(-1.0, 1.0)).normalize().any_orthonormal_pair();
        let place = DVec3::new(uniform(-1.0, 1.0), uniform(-1.0, 1.0), uniform(-1.0, 1.0)) * [1.0, 100.0][case / 4 % 2];
        let largest = place.abs().max_element() + 3.0;
        let precision = largest * 2f64.powi(-24);
        // Where the outline is thinner than its rounding it may be any.
        if width < 8.0 * precision {
            continue;
        }
        let vertices: Vec<DVec3> = outline.iter().map(|p| (place + u * p[0] + v * p[1]).as_vec3().as_dvec3()).collect();
        let polygon = Polygon::from_rounded(vertices.clone(), precision);
        let polygon = polygon.unwrap_or_else(|error| panic!("case {case}, width {width}: {error}, {vertices:?}"));
        for (given, vertex) in vertices.iter().zip(polygon.vertices()) {
            assert!((*given - *vertex).abs().max_element() <= precision * 1.01, "case {case}");
        }
        warped += usize::from(Polygon::new(vertices).is_err());
    }
    assert!(warped > 1500, "{warped}");
}

#[test]
fn what_rounding_does_not_explain_is_refused() {
    let warped = |z: f64| vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, z), DVec3::Y];
    assert!(Polygon::from_rounded(warped(2e-7), 1e-7).is_ok());
    assert!(matches!(Polygon::from_rounded(warped(2e-6), 1e-7), Err(Error::NotPlanar { .. })));
    // As far across a needle, which rounding turns about its length only.
    let twisted = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1e-3, 0.0], [0.0, 1e-3, 2e-6]].map(DVec3::from).to_vec();
    assert!(matches!(Polygon::from_rounded(twisted, 1e-7), Err(Error::NotPlanar { .. })));
    for precision in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(Polygon::from_rounded(warped(0.0), precision), Err(Error::Precision { .. })));
    }
    assert!(Polygon::from_rounded(warped(0.1), 1e300).is_ok());
}

#[test]
fn neighbours_that_rounding_exchanged_are_put_in_order() {
    let chain = |a: DVec3, b: DVec3| vec![DVec3::ZERO, a, b, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
    for aside in [0.0, 2e-8, -2e-8] {
        let folded = chain(DVec3::new(0.5, 0.0, 0.0), DVec3::new(0.5 - 1e-7, aside, 0.0));
        let polygon = Polygon::from_rounded(folded.clone(), 1e-7).unwrap();
        assert!(polygon.vertices().windows(2).take(3).all(|pair| pair[0].x < pair[1].x) || Polygon::new(folded).is_ok());
        assert!((polygon.area() - 1.0).abs() < 1e-7);
    }
    let doubled = Polygon::from_rounded(vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Y], 1e-7).unwrap();
    assert!((doubled.area() - 0.5).abs() < 1e-6);
    let folded = chain(DVec3::new(0.5, 0.0, 0.0), DVec3::new(0.5 - 1e-5, 0.0, 0.0));
    let message = Polygon::from_rounded(folded, 1e-7).unwrap_err().to_string();
    assert!(message.contains("meet") && message.contains("1e-7"), "{message}");
}

#[test]
fn a_vertex_on_an_edge_line_is_allowed() {
    let t_junction = [[0.0; 3], [0.5, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    assert_eq!(polygon(&t_junction).unwrap().area(), 0.5);
}

#[test]
fn wrong_receivers_are_named() {
    assert!(matches!(Receiver::new(DVec3::NAN, DVec3::Z, 1.0), Err(Error::PositionNotFinite { .. })));
    assert!(matches!(Receiver::new(DVec3::ZERO, DVec3::ZERO, 1.0), Err(Error::Normal { .. })));
    for reflectance in [-0.1, 1.1, f64::NAN] {
        assert!(matches!(Receiver::new(DVec3::ZERO, DVec3::Z, reflectance), Err(Error::Reflectance { .. })));
    }
    let tiny = Receiver::new(DVec3::ZERO, DVec3::new(3e-310, 0.0, 4e-310), 1.0).unwrap();
    assert!((tiny.normal() - DVec3::new(0.6, 0.0, 0.8)).length() < 1e-12);
}

fn quad() -> Polygon {
    Polygon::new([(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 5.0)).to_vec()).unwrap()
}

#[test]
fn vertex_values_give_the_gradient() {
    let emitter = Emitter::new(quad(), Emission::at_vertices(vec![1.0, 2.0, 5.0, 4.0])).unwrap();
    assert_eq!(emitter.emission_gradient(), DVec3::new(0.5, 3.0, 0.0));
    assert_eq!(emitter.largest_emission(), 5.0);
}

#[test]
fn inconsistent_values_are_refused() {
    let error = Emitter::new(quad(), Emission::at_vertices(vec![1.0, 2.0, 5.0, 4.1])).unwrap_err();
    assert!(matches!(error, Error::EmissionNotAffine { .. }), "{error}");
    let error = Emitter::new(quad(), Emission::at_vertices(vec![1.0, 2.0, 5.0])).unwrap_err();
    assert_eq!(error, Error::EmissionCount { values: 3, vertices: 4 });
    let error = Emitter::new(quad(), Emission::Constant(f64::INFINITY)).unwrap_err();
    assert!(error.to_string().contains("value is inf"), "{error}");
}

#[test]
fn a_gradient_along_the_normal_has_no_effect() {
    let emitter = Emitter::new(quad(), Emission::gradient(1.0, DVec3::new(0.5, 3.0, 7.0))).unwrap();
    assert_eq!(emitter.emission_gradient(), DVec3::new(0.5, 3.0, 0.0));
}

#[test]
fn values_and_gradients_are_those_of_the_terms() {
    let p = Polynomial::new(DVec3::new(1.0, 0.0, 0.0), [(3.0, [2, 1, 0]), (-1.0, [0, 0, 1]), (0.5, [0, 0, 0])]).unwrap();
    assert_eq!(p.degree(), 3);
    assert_eq!(p.value_at(DVec3::new(3.0, 2.0, 5.0)), 3.0 * 4.0 * 2.0 - 5.0 + 0.5);
    assert_eq!(p.gradient_at(DVec3::new(3.0, 2.0, 5.0)), DVec3::new(24.0, 12.0, -1.0));
}

#[test]
fn wrong_polynomials_are_named() {
    let error = Polynomial::new(DVec3::ZERO, [(1.0, [0, 0, 0]), (1.0, [100, 100, 56])]).unwrap_err();
    assert_eq!(error.to_string(), "emission term 1 has degree 256: at most 255 is allowed");
    let error = Polynomial::new(DVec3::ZERO, [(f64::NAN, [0, 0, 1])]).unwrap_err();
    assert_eq!(error.to_string(), "emission coefficient of term 0 is NaN: it must be finite");
    let error = Polynomial::new(DVec3::new(0.0, f64::INFINITY, 0.0), []).unwrap_err();
    assert_eq!(error.to_string(), "emission origin component 1 is inf: it must be finite");
}
