//! Enclosures with occluders: against free sight where the seen part is a polygon, against themselves by differences, against
//! rays, and identities that hold for all.

use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver};
use radgrad_oracle::monte_carlo::{Sampling, Sequence, integrate};
use radgrad_oracle::{Enclosure, Interval, enclose, enclose_occluded};

fn polygon(points: &[[f64; 3]]) -> Polygon {
    Polygon::new(points.iter().map(|p| DVec3::from(*p)).collect()).unwrap()
}

/// A rectangle at height z, lit downward.
fn rectangle(x: [f64; 2], y: [f64; 2], z: f64) -> Polygon {
    polygon(&[[x[0], y[0], z], [x[0], y[1], z], [x[1], y[1], z], [x[1], y[0], z]])
}

/// One affine emission wherever the rectangle is.
fn lamp(x: [f64; 2], y: [f64; 2]) -> Emitter {
    let polygon = rectangle(x, y, 2.0);
    let values = polygon.vertices().iter().map(|v| 2.0 + 0.5 * v.x - 0.25 * v.y).collect();
    Emitter::new(polygon, Emission::at_vertices(values)).unwrap()
}

fn receiver(position: [f64; 3]) -> Receiver {
    Receiver::new(position.into(), DVec3::new(0.125, -0.25, 1.0), 0.8).unwrap()
}

fn assert_meet(a: &Enclosure, b: &Enclosure) {
    assert!(a.radiosity.overlaps(&b.radiosity), "{a:?} {b:?}");
    for axis in 0..3 {
        assert!(a.gradient[axis].overlaps(&b.gradient[axis]), "component {axis}: {a:?} {b:?}");
    }
}

/// A number of the interval to `digits` digits.
fn high(interval: &Interval) -> f64 {
    interval.bounds().1
}

const SQUARE: [f64; 2] = [-1.0, 1.0];
const WIDE: [f64; 2] = [-16.0, 16.0];

#[test]
fn what_a_half_plane_leaves_of_a_lamp_is_a_lamp() {
    let screen = rectangle([0.25, 16.0], WIDE, 1.0);
    let past = enclose_occluded(&receiver([0.0; 3]), &lamp(SQUARE, SQUARE), std::slice::from_ref(&screen), 20).unwrap();
    let free = enclose(&receiver([0.0; 3]), &lamp([-1.0, 0.5], SQUARE), 20).unwrap();
    assert!(past.radiosity.overlaps(&free.radiosity), "{past:?} {free:?}");
    assert!(free.gradient[0].error_of(past.gradient[0].to_f64()) > 0.01, "the shadow moves with the receiver");
}

#[test]
fn a_square_and_a_half_plane_leave_three_quarters_and_a_half() {
    let unit = [0.0, 1.0];
    let square = Emitter::new(rectangle(unit, unit, 1.0), Emission::Constant(1.0)).unwrap();
    // Symmetric about the axis through x, so that parts of the square are parts of the factor; the small screen is seen in
    // line with two edges of the square.
    let x = Receiver::new(DVec3::new(0.5, 0.5, 0.0), DVec3::Z, 1.0).unwrap();
    let free = enclose(&x, &square, 20).unwrap().radiosity.to_f64();
    for (part, screen) in [(0.75, rectangle([0.25, 0.5], [0.25, 0.5], 0.5)), (0.5, rectangle([-16.0, 0.5], WIDE, 0.5))] {
        let past = enclose_occluded(&x, &square, &[screen], 20).unwrap();
        assert!(past.radiosity.error_of(part * free) < 1e-16, "{part} {past:?}");
    }
}

#[test]
fn a_screen_that_stands_on_the_lamp_leaves_the_rest_and_its_gradient() {
    for x in [[0.25, 0.125, 0.0], [-0.75, 0.5, 1.5], [0.0, 0.0, -3.0]] {
        let screen = polygon(&[[0.5, -16.0, 2.0], [0.5, 16.0, 2.0], [16.0, 16.0, 1.75], [16.0, -16.0, 1.75]]);
        let past = enclose_occluded(&receiver(x), &lamp(SQUARE, SQUARE), &[screen], 18).unwrap();
        assert_meet(&past, &enclose(&receiver(x), &lamp([-1.0, 0.5], SQUARE), 18).unwrap());
    }
}

#[test]
fn what_hides_nothing_changes_nothing() {
    let x = receiver([0.125, 0.25, 0.0]);
    let lamp = lamp(SQUARE, SQUARE);
    let nothing = [
        rectangle(SQUARE, SQUARE, 3.0),
        rectangle(SQUARE, SQUARE, -1.0),
        rectangle([3.0, 4.0], [3.0, 4.0], 1.0),
        rectangle([-0.5, 0.5], [-0.5, 0.5], 2.0),
        rectangle(SQUARE, SQUARE, 0.0),
        polygon(&[[0.125, 0.25, 0.5], [0.5, 0.25, 0.5], [0.5, 0.25, 1.0]]),
        // Stands on an edge of the lamp, to the side.
        polygon(&[[1.0, -1.0, 1.0], [1.0, 1.0, 1.0], [1.0, 1.0, 2.0], [1.0, -1.0, 2.0]]),
    ];
    assert_eq!(enclose_occluded(&x, &lamp, &nothing, 18).unwrap(), enclose(&x, &lamp, 18).unwrap());
}

#[test]
fn screens_that_meet_in_a_t_leave_exactly_nothing() {
    let screens =
        [rectangle([-16.0, 0.3], WIDE, 1.0), rectangle([0.3, 16.0], [-16.0, 0.1], 1.0), rectangle([0.3, 16.0], [0.1, 16.0], 1.0)];
    let past = enclose_occluded(&receiver([0.1, 0.2, 0.0]), &lamp(SQUARE, SQUARE), &screens, 18).unwrap();
    assert_eq!((past.radiosity.to_f64(), past.radiosity.radius(), past.evaluations), (0.0, 0.0, 0));
    let two = enclose_occluded(&receiver([0.1, 0.2, 0.0]), &lamp(SQUARE, SQUARE), &screens[..2], 18).unwrap();
    assert!(two.radiosity.to_f64() > 0.0);
}

#[test]
fn meshed_turned_and_concave_screens_are_one() {
    let x = receiver([0.125, 0.25, 0.0]);
    let see = |screens: &[Polygon]| enclose_occluded(&x, &lamp(SQUARE, SQUARE), screens, 18).unwrap();
    let whole = rectangle([-0.25, 0.375], [-0.25, 0.5], 1.0);
    let v = whole.vertices();
    let mesh = [[0, 1, 2], [0, 2, 3]].map(|t| Polygon::new(t.map(|i: usize| v[i]).to_vec()).unwrap());
    let turned = Polygon::new(v.iter().rev().copied().collect()).unwrap();
    assert_meet(&see(&mesh), &see(std::slice::from_ref(&whole)));
    assert_meet(&see(&[turned]), &see(std::slice::from_ref(&whole)));
    let corners = [[-0.25, -0.25], [-0.25, 0.5], [0.0, 0.5], [0.0, 0.0], [0.375, 0.0], [0.375, -0.25]].map(|[x, y]| [x, y, 1.0]);
    let parts = [rectangle([-0.25, 0.0], [-0.25, 0.5], 1.0), rectangle([0.0, 0.375], [-0.25, 0.0], 1.0)];
    assert_meet(&see(&[polygon(&corners)]), &see(&parts));
    assert!(see(&parts).radiosity.to_f64() > high(&see(&[whole]).radiosity));
}

#[test]
fn a_screen_through_the_lamp_hides_what_its_near_part_does() {
    let x = receiver([0.125, 0.25, 0.0]);
    let see = |screen: Polygon| enclose_occluded(&x, &lamp(SQUARE, SQUARE), &[screen], 18).unwrap();
    let through = [[0.25, -0.5, 1.5], [0.25, 0.5, 1.5], [0.75, 0.5, 2.5], [0.75, -0.5, 2.5]];
    let near = [[0.25, -0.5, 1.5], [0.25, 0.5, 1.5], [0.5, 0.5, 2.0], [0.5, -0.5, 2.0]];
    assert_meet(&see(polygon(&through)), &see(polygon(&near)));
}

/// Screens that overlap, cut the lamp, come near the receiver and cross its horizon.
fn tangle() -> Vec<Polygon> {
    vec![
        polygon(&[[-0.25, -0.375, 0.875], [0.125, 0.5, 1.125], [0.4375, -0.25, 1.0]]),
        polygon(&[[0.25, -0.5, 1.5], [0.25, 0.5, 1.75], [0.75, 0.5, 2.5], [0.75, -0.5, 2.25]]),
        polygon(&[[-0.125, 0.0, 0.5], [0.0, 0.25, 0.25], [-1.0, 0.75, -0.5]]),
        polygon(&[[-0.0625, -0.25, 0.75], [-0.5, -0.375, 1.25], [0.0, -0.5, 1.5]]),
    ]
}

#[test]
fn the_gradient_is_that_of_the_values_to_fifteen_digits() {
    let screens = tangle();
    let emissions = [Emission::Constant(1.0), Emission::at_vertices(vec![1.0, 2.0, 4.0, 3.0])];
    for emission in emissions {
        let lamp = Emitter::new(rectangle(SQUARE, SQUARE, 2.0), emission).unwrap();
        for count in [1, 2, 4] {
            let x = [0.125, 0.0625, 0.0];
            let truth = enclose_occluded(&receiver(x), &lamp, &screens[..count], 30).unwrap();
            for axis in 0..3 {
                let step = 2f64.powi(-30);
                let shifted = |sign: f64| {
                    let mut moved = x;
                    moved[axis] += sign * step;
                    enclose_occluded(&receiver(moved), &lamp, &screens[..count], 30).unwrap().radiosity
                };
                let (above, below) = (shifted(1.0), shifted(-1.0));
                let difference = above.less(&below).to_f64() / (2.0 * step);
                let error = truth.gradient[axis].error_of(difference);
                assert!(error < 2e-16, "{count} {axis}: {difference} {}, {error:e}", truth.gradient[axis].to_f64());
            }
        }
    }
}

#[test]
fn rays_agree_and_more_screens_leave_less() {
    let screens = tangle();
    let (x, lamp) = (receiver([0.125, 0.0625, 0.0]), lamp(SQUARE, SQUARE));
    let mut last = f64::INFINITY;
    for count in 0..=screens.len() {
        let enclosure = enclose_occluded(&x, &lamp, &screens[..count], 16).unwrap();
        let radiosity = enclosure.radiosity.to_f64();
        assert!(radiosity > 0.0 && radiosity < last, "screen {count} hides a part");
        last = radiosity;
        let sequence = Sequence::Independent { seed: 7, samples: 40_000 };
        let rays = integrate(&x, &lamp, &screens[..count], Sampling::SolidAngle, sequence, 0.999).unwrap();
        let limits = rays.radiosity.student;
        assert!(limits.low < radiosity && radiosity < limits.high, "{count}: {radiosity} {limits:?}");
    }
}

/// The faces of a box, counter-clockwise from outside or from inside.
fn faces(low: [f64; 3], high: [f64; 3], outward: bool) -> Vec<Polygon> {
    let face = |axis: usize, side: usize| {
        let corner = |u: usize, v: usize| {
            let mut point = [0.0; 3];
            point[axis] = [low, high][side][axis];
            point[(axis + 1) % 3] = [low, high][u][(axis + 1) % 3];
            point[(axis + 2) % 3] = [low, high][v][(axis + 2) % 3];
            point
        };
        let mut corners = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
        if (side == 1) != outward {
            corners.reverse();
        }
        polygon(&corners)
    };
    (0..3).flat_map(|axis| [face(axis, 0), face(axis, 1)]).collect()
}

#[test]
fn the_factors_of_a_closed_scene_sum_to_one_and_its_gradients_to_zero() {
    let mut scene = faces([-1.0, -1.0, 0.0], [1.5, 1.25, 2.0], false);
    scene.extend(faces([-0.5, 0.1, 0.0], [0.25, 0.7, 0.9], true));
    scene.extend(faces([0.3, -0.7, 0.6], [0.9, -0.2, 1.1], true));
    for (position, normal) in [([0.5, 0.3, 0.0], [0.0, 0.0, 1.0]), ([-0.8, 0.2, 1.3], [0.7, -0.1, -0.4])] {
        let x = Receiver::new(position.into(), normal.into(), 1.0).unwrap();
        let (mut sum, mut gradient, mut shadowed) = (-1.0, [0.0; 3], 0);
        for face in &scene {
            let emitter = Emitter::new(face.clone(), Emission::Constant(1.0)).unwrap();
            let past = enclose_occluded(&x, &emitter, &scene, 18).unwrap();
            let free = enclose(&x, &emitter, 18).unwrap();
            assert!(past.radiosity.bounds().0 >= 0.0 && past.radiosity.bounds().0 <= free.radiosity.bounds().1);
            shadowed += usize::from(!past.radiosity.overlaps(&free.radiosity));
            sum += past.radiosity.to_f64();
            (0..3).for_each(|axis| gradient[axis] += past.gradient[axis].to_f64());
        }
        assert!(sum.abs() < 1e-15 && shadowed > 3, "{sum:e} {shadowed}");
        assert!(gradient.iter().all(|g| g.abs() < 1e-14), "{gradient:?}");
    }
}

#[test]
fn rays_agree_past_two_hundred_triangles() {
    let mut state = 1u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / 2f64.powi(53)
    };
    let triangles: Vec<Polygon> = (0..200)
        .map(|_| {
            let middle = [0, 1, 2].map(|_| 0.3 + 1.6 * random());
            polygon(&[0, 1, 2].map(|_| [0, 1, 2].map(|axis| middle[axis] + 0.25 * (random() - 0.5))))
        })
        .collect();
    let x = Receiver::new(DVec3::new(1.0, 1.0, 0.0), DVec3::Z, 1.0).unwrap();
    let lamp = Emitter::new(rectangle([0.0, 2.0], [0.0, 2.0], 2.0), Emission::Constant(1.0)).unwrap();
    let past = enclose_occluded(&x, &lamp, &triangles, 15).unwrap();
    let sequence = Sequence::Independent { seed: 3, samples: 20_000 };
    let rays = integrate(&x, &lamp, &triangles, Sampling::SolidAngle, sequence, 0.999).unwrap().radiosity.student;
    let radiosity = past.radiosity.to_f64();
    assert!(rays.low < radiosity && radiosity < rays.high, "{radiosity} {rays:?}");
    let first = enclose_occluded(&x, &lamp, &triangles[..100], 15).unwrap();
    assert!(
        radiosity < first.radiosity.to_f64() && first.radiosity.to_f64() < enclose(&x, &lamp, 15).unwrap().radiosity.to_f64()
    );
}

#[test]
fn rays_agree_past_a_screen_on_the_border_and_one_in_the_plane_of_the_lamp() {
    let corners = [[-0.35, 0.3, 2.1], [-0.9, 0.75, 1.5], [-0.7, -0.3, 1.05]];
    let lamp = Emitter::new(polygon(&corners), Emission::Constant(1.0)).unwrap();
    let position = lamp.polygon().normal() * 1.7 - DVec3::new(0.6, -0.2, -1.6);
    let x = Receiver::new(position, DVec3::from(corners[0]) - position, 1.0).unwrap();
    let [a, b, c] = corners.map(DVec3::from);
    let aside = (a + b) * 0.5 + ((a + b) * 0.5 - c) * 0.3 + (x.position() - c) * 0.2;
    for screen in [vec![a, b, aside], vec![a, b, c]] {
        let screen = Polygon::new(screen).unwrap();
        let past = enclose_occluded(&x, &lamp, std::slice::from_ref(&screen), 16).unwrap();
        let sequence = Sequence::Independent { seed: 11, samples: 20_000 };
        let rays = integrate(&x, &lamp, &[screen], Sampling::SolidAngle, sequence, 0.9999).unwrap();
        let limits = [rays.radiosity, rays.gradient[0], rays.gradient[1], rays.gradient[2]];
        for (truth, limits) in [&past.radiosity].into_iter().chain(&past.gradient).zip(limits) {
            assert!(limits.student.contains(truth.to_f64()), "{} {limits:?}", truth.to_f64());
        }
    }
}
