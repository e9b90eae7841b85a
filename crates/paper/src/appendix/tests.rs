//! Tests of appendix A: the numbers of the paper's scene, and Eq. 1 with its gradient integrated directly elsewhere.

use super::*;
use radgrad_core::{Emission, Polygon};

/// The emitter of the paper's figures A to D.
fn triangle(emission: Emission) -> Emitter {
    let vertices = vec![DVec3::new(0.0, 0.0, 1.0), DVec3::new(0.5, 0.8, 1.0), DVec3::new(1.0, 0.0, 1.0)];
    Emitter::new(Polygon::new(vertices).unwrap(), emission).unwrap()
}

fn receiver(position: [f64; 3], normal: [f64; 3]) -> Receiver {
    Receiver::new(DVec3::from(position), DVec3::from(normal), 1.0).unwrap()
}

fn assert_close(computed: (f64, DVec3), expected: (f64, DVec3), tolerance: f64) {
    let value = (computed.0 / expected.0 - 1.0).abs();
    let gradient = (computed.1 - expected.1).length() / expected.1.length();
    assert!(value < tolerance && gradient < tolerance, "{computed:?} for {expected:?}: {value:e}, {gradient:e}");
}

/// Eq. 1 and its gradient over a triangle by a midpoint rule and its Richardson extrapolation, seen part only.
fn midpoint(receiver: &Receiver, emitter: &Emitter, cells: u32) -> (f64, DVec3) {
    let [a, b, c] = [0, 1, 2].map(|i| emitter.polygon().vertices()[i]);
    let n = f64::from(cells);
    let (n1, n2) = (receiver.normal(), emitter.polygon().normal());
    let mut sum = (0.0, DVec3::ZERO);
    for i in 0..cells {
        for j in 0..2 * (cells - i) - 1 {
            let (u, v) = (f64::from(i), f64::from(j / 2));
            let centre = if j % 2 == 0 { 1.0 / 3.0 } else { 2.0 / 3.0 };
            let y = a + (b - a) * ((u + centre) / n) + (c - a) * ((v + centre) / n);
            let r = y - receiver.position();
            let (cos_1, cos_2, rr) = (n1.dot(r), -n2.dot(r), r.length_squared());
            if cos_1 <= 0.0 {
                continue;
            }
            let emission = emitter.emission_at(y) / (rr * rr);
            sum.0 += emission * cos_1 * cos_2;
            sum.1 += emission * (n2 * cos_1 - n1 * cos_2 + r * (4.0 * cos_1 * cos_2 / rr));
        }
    }
    let factor = receiver.reflectance() * emitter.polygon().area() / (n * n) / std::f64::consts::PI;
    (sum.0 * factor, sum.1 * factor)
}

#[test]
fn the_papers_scene_has_its_published_numbers() {
    let point = receiver([1.5, -0.25, 0.0], [0.0, 0.0, 1.0]);
    let constant = radiosity_and_gradient(&point, &triangle(Emission::Constant(1.0)), None).unwrap();
    let gradient = DVec3::new(-0.04520425179658418, 0.023560506696805802, -0.001214360601731962);
    assert_close(constant, (0.02637794117665325, gradient), 1e-14);
    let linear = radiosity_and_gradient(&point, &triangle(Emission::at_vertices(vec![1.0, 2.0, 4.0])), None).unwrap();
    let gradient = DVec3::new(-0.11710523712879814, 0.06221522306742276, 0.004040475169840118);
    assert_close(linear, (0.0685765925811236, gradient), 1e-14);
}

#[test]
fn a_tilted_receiver_agrees_with_direct_integration() {
    // Here n2.(n1 x k) is not 0: the only place where X1 and X2 count.
    let emitter = triangle(Emission::at_vertices(vec![1.0, 2.0, 4.0]));
    let point = receiver([0.9, -0.4, 0.1], [0.3, 0.5, 0.8]);
    let [coarse, fine] = [200, 400].map(|cells| midpoint(&point, &emitter, cells));
    let extrapolated = ((4.0 * fine.0 - coarse.0) / 3.0, (4.0 * fine.1 - coarse.1) / 3.0);
    assert_close(radiosity_and_gradient(&point, &emitter, None).unwrap(), extrapolated, 1e-9);
}

#[test]
fn what_is_below_the_horizon_does_not_count() {
    let emitter = triangle(Emission::at_vertices(vec![1.0, 2.0, 4.0]));
    let point = receiver([0.6, 0.3, 0.2], [0.9, -0.3, 0.2]);
    assert_close(radiosity_and_gradient(&point, &emitter, None).unwrap(), midpoint(&point, &emitter, 1000), 2e-5);
    let below = receiver([0.6, 0.3, 0.2], [0.0, 0.0, -1.0]);
    assert_eq!(radiosity_and_gradient(&below, &emitter, None).unwrap(), (0.0, DVec3::ZERO));
}

#[test]
fn behind_the_emitter_and_in_its_plane_there_is_nothing() {
    let emitter = triangle(Emission::Constant(1.0));
    for position in [[0.5, 0.3, 2.0], [0.5, 0.3, 1.0], [0.5, 0.0, 1.0], [0.0, 0.0, 1.0], [7.0, 0.0, 1.0]] {
        let answer = radiosity_and_gradient(&receiver(position, [0.3, 0.2, 0.9]), &emitter, None).unwrap();
        assert_eq!(answer, (0.0, DVec3::ZERO), "at {position:?}");
    }
}

#[test]
fn every_misprint_changes_what_it_shows_in_and_nothing_else() {
    let quad = [(0.0, 0.0), (0.2, 0.9), (1.0, 0.8), (1.1, -0.1)].map(|(x, y)| DVec3::new(x, y, 1.0));
    let quad = Emitter::new(Polygon::new(quad.to_vec()).unwrap(), Emission::gradient(2.0, DVec3::new(1.0, 0.5, 0.0))).unwrap();
    let constant = triangle(Emission::Constant(1.0));
    let places = [
        receiver([0.4, -0.2, 0.1], [0.1, 0.2, 0.9]),
        receiver([0.4, 0.2, 0.1], [0.9, 0.1, 0.1]),
        receiver([0.4, -0.2, 1.7], [0.1, 0.2, -0.9]),
        receiver([0.4, -0.2, 0.1], [0.0, 0.0, 1.0]),
    ];
    let mut shown = Vec::new();
    for emitter in [&quad, &constant] {
        for receiver in &places {
            let right = radiosity_and_gradient(receiver, emitter, None).unwrap();
            for &misprint in Misprint::ALL {
                let wrong = radiosity_and_gradient(receiver, emitter, Some(misprint)).unwrap();
                let change = (wrong.0 - right.0).abs() + (wrong.1 - right.1).length();
                let shows = misprint.shows_in(receiver, emitter);
                assert_eq!(shows, change > 1e-6, "{}: {change:e} at {receiver:?} under {emitter:?}", misprint.name());
                shown.extend(shows.then_some(misprint));
            }
        }
    }
    assert!(Misprint::ALL.iter().all(|misprint| shown.contains(misprint)), "only {shown:?}");
}
