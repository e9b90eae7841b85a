//! Occluders, against the same light found without them.

use radgrad_core::{Answer, DVec3, Emission, Emitter, Method, Polygon, Receiver, evaluate};

fn polygon(points: &[[f64; 3]]) -> Polygon {
    Polygon::new(points.iter().map(|&p| p.into()).collect()).unwrap()
}

/// A rectangle at height `z`, lit downwards.
fn ceiling(x: [f64; 2], y: [f64; 2], z: f64) -> Polygon {
    polygon(&[[x[0], y[0], z], [x[0], y[1], z], [x[1], y[1], z], [x[1], y[0], z]])
}

fn linear(rectangle: Polygon) -> Emitter {
    // One affine function whatever the rectangle: value by position.
    let values = rectangle.vertices().iter().map(|v| 2.0 + 0.5 * v.x - 0.25 * v.y).collect();
    Emitter::new(rectangle, Emission::at_vertices(values)).unwrap()
}

fn receiver(position: [f64; 3]) -> Receiver {
    Receiver::new(position.into(), DVec3::new(0.1, -0.2, 1.0), 0.8).unwrap()
}

/// Sums of values and gradients agree to within their bounds, and those are small.
fn assert_same(answers: &[Answer], expected: &[Answer]) {
    let sum = |answers: &[Answer]| {
        answers.iter().fold((0.0, DVec3::ZERO, 0.0, 0.0), |(b, g, eb, eg), a| {
            (b + a.radiosity, g + a.gradient, eb + a.radiosity_error, eg + a.gradient_error)
        })
    };
    let (a, e) = (sum(answers), sum(expected));
    assert!((a.0 - e.0).abs() <= a.2 + e.2, "{a:?} {e:?}");
    assert!((a.1 - e.1).length() <= a.3 + e.3, "{a:?} {e:?}");
    assert!(a.2 + e.2 < 1e-10 && a.3 + e.3 < 1e-9, "{a:?} {e:?}");
}

#[test]
fn what_hides_nothing_changes_nothing() {
    let lamp = linear(ceiling([-1.0, 1.0], [-1.0, 1.0], 2.0));
    let x = receiver([0.1, 0.2, 0.0]);
    let free = evaluate(&x, &lamp, &[]).unwrap();
    let behind_lamp = ceiling([-1.0, 1.0], [-1.0, 1.0], 3.0);
    let behind_receiver = ceiling([-1.0, 1.0], [-1.0, 1.0], -1.0);
    let beside = ceiling([3.0, 4.0], [3.0, 4.0], 1.0);
    let in_the_lamp = ceiling([-0.5, 0.5], [-0.5, 0.5], 2.0);
    let edge_on = polygon(&[[0.1, 0.2, 0.5], [0.4, 0.2, 0.5], [0.4, 0.2, 1.0]]);
    let answer = evaluate(&x, &lamp, &[behind_lamp, behind_receiver, beside, in_the_lamp, edge_on]).unwrap();
    assert_same(&[answer], &[free]);
}

#[test]
fn a_screen_that_covers_all_leaves_exactly_nothing() {
    let lamp = linear(ceiling([-1.0, 1.0], [-1.0, 1.0], 2.0));
    let answer = evaluate(&receiver([0.1, 0.2, 0.0]), &lamp, &[ceiling([-3.0, 3.0], [-3.0, 3.0], 1.0)]).unwrap();
    assert_eq!((answer.radiosity, answer.gradient), (0.0, DVec3::ZERO));
    assert_eq!((answer.radiosity_error, answer.gradient_error), (0.0, 0.0));
}

#[test]
fn screens_on_either_side_of_a_line_hide_the_whole_together() {
    // The free answer is the part that screen A leaves plus the part that screen B leaves, when both fill the view.
    let lamp = linear(ceiling([-1.0, 1.0], [-1.0, 1.0], 2.0));
    let x = receiver([0.1, 0.2, 0.0]);
    let split = 0.3;
    let screens = [ceiling([-9.0, split], [-9.0, 9.0], 1.0), ceiling([split, 9.0], [-9.0, 9.0], 1.0)];
    let see = |screens: &[Polygon]| evaluate(&x, &lamp, screens).unwrap();
    assert_same(&[see(&screens[..1]), see(&screens[1..])], &[see(&[])]);
    assert_eq!(see(&screens).method, Method::Zero);
}

#[test]
fn screens_that_meet_in_a_t_leave_exactly_nothing_from_anywhere() {
    let screens =
        [ceiling([-9.0, 0.3], [-9.0, 9.0], 1.0), ceiling([0.3, 9.0], [-9.0, 0.1], 1.0), ceiling([0.3, 9.0], [0.1, 9.0], 1.0)];
    for distance in [0.5, 1e3, 1e8] {
        let lamp = linear(ceiling([-1.0, 1.0], [-1.0, 1.0], 1.0 + distance));
        for position in [[0.1, 0.2, 0.0], [0.3, 0.1, 0.7], [0.3, -0.4, -0.2]] {
            let answer = evaluate(&receiver(position), &lamp, &screens).unwrap();
            assert_eq!((answer.radiosity_error, answer.gradient_error, answer.method), (0.0, 0.0, Method::Zero));
        }
    }
}

#[cfg(feature = "arbitrary-precision")]
#[test]
fn a_screen_seen_in_line_with_the_lamp_leaves_nothing_and_a_gradient_of_either_side() {
    let receiver = Receiver::new(DVec3::ZERO, DVec3::new(0.1, -0.2, 1.0), 0.8).unwrap();
    let (lamp, screen) = (linear(ceiling([-1.0, 1.0], [-1.0, 1.0], 4.0)), ceiling([-0.5, 0.5], [-0.5, 0.5], 2.0));
    let answer = evaluate(&receiver, &lamp, std::slice::from_ref(&screen)).unwrap();
    assert!(answer.radiosity == 0.0 && answer.radiosity_error < 1e-300, "{answer:?}");
    // To one side the edge of the lamp shows, to the other it does not.
    let step = 1e-6;
    for axis in [DVec3::X, DVec3::Y, -DVec3::X, -DVec3::Y] {
        let aside = Receiver::new(axis * step, DVec3::new(0.1, -0.2, 1.0), 0.8).unwrap();
        let slope = evaluate(&aside, &lamp, std::slice::from_ref(&screen)).unwrap().radiosity / step;
        assert!(slope > 1e-3 && slope <= answer.gradient_error, "{slope} {answer:?}");
    }
}

#[test]
fn the_value_past_a_screen_is_that_of_the_part_of_the_lamp_it_leaves() {
    let x = receiver([0.0, 0.0, 0.0]);
    let lamp = linear(ceiling([-1.0, 1.0], [-1.0, 1.0], 2.0));
    let screen = ceiling([0.25, 9.0], [-9.0, 9.0], 1.0);
    let past = evaluate(&x, &lamp, &[screen]).unwrap();
    let unhidden = evaluate(&x, &linear(ceiling([-1.0, 0.5], [-1.0, 1.0], 2.0)), &[]).unwrap();
    assert!((past.radiosity - unhidden.radiosity).abs() <= past.radiosity_error + unhidden.radiosity_error);
}

#[test]
fn a_meshed_or_concave_screen_is_its_whole() {
    let lamp = linear(ceiling([-1.0, 1.0], [-1.0, 1.0], 2.0));
    let x = receiver([0.1, 0.2, 0.0]);
    let see = |screens: &[Polygon]| evaluate(&x, &lamp, screens).unwrap();
    let whole = ceiling([-0.2, 0.4], [-0.3, 0.5], 1.0);
    let v = whole.vertices();
    let mesh = [[v[0], v[1], v[2]], [v[0], v[2], v[3]]].map(|t| Polygon::new(t.to_vec()).unwrap());
    assert_same(&[see(&mesh)], &[see(std::slice::from_ref(&whole))]);
    let reversed = Polygon::new(v.iter().rev().copied().collect()).unwrap();
    assert_same(&[see(&[reversed])], &[see(&[whole])]);
    let bent =
        polygon(&[[-0.2, -0.3, 1.0], [-0.2, 0.5, 1.0], [0.0, 0.5, 1.0], [0.0, 0.0, 1.0], [0.4, 0.0, 1.0], [0.4, -0.3, 1.0]]);
    let parts = [ceiling([-0.2, 0.0], [-0.3, 0.5], 1.0), ceiling([-0.0, 0.4], [-0.3, 0.0], 1.0)];
    assert_same(&[see(&[bent])], &[see(&parts)]);
}

#[test]
fn a_concave_lamp_past_a_screen_is_the_sum_of_its_parts() {
    let screen = polygon(&[[-0.2, -0.3, 0.9], [0.1, 0.5, 1.1], [0.4, -0.2, 1.0]]);
    let x = receiver([0.1, 0.2, 0.0]);
    let bent =
        polygon(&[[-1.0, -1.0, 2.0], [-1.0, 1.0, 2.0], [0.0, 1.0, 2.0], [0.0, 0.0, 2.0], [1.0, 0.0, 2.0], [1.0, -1.0, 2.0]]);
    let parts = [ceiling([-1.0, 0.0], [-1.0, 1.0], 2.0), ceiling([0.0, 1.0], [-1.0, 0.0], 2.0)];
    let see = |lamp: Polygon| evaluate(&x, &linear(lamp), std::slice::from_ref(&screen)).unwrap();
    assert_same(&[see(bent)], &parts.map(see));
}

#[test]
fn a_screen_through_the_lamp_hides_only_its_near_part() {
    let lamp = linear(ceiling([-1.0, 1.0], [-1.0, 1.0], 2.0));
    let x = receiver([0.1, 0.2, 0.0]);
    let through = polygon(&[[0.3, -0.4, 1.5], [0.3, 0.4, 1.5], [0.6, 0.4, 3.0], [0.6, -0.4, 3.0]]);
    let near = polygon(&[[0.3, -0.4, 1.5], [0.3, 0.4, 1.5], [0.4, 0.4, 2.0], [0.4, -0.4, 2.0]]);
    let see = |screen: Polygon| evaluate(&x, &lamp, &[screen]).unwrap();
    assert_same(&[see(through)], &[see(near)]);
}

#[test]
fn the_gradient_past_a_screen_is_that_of_the_values() {
    let screens = [polygon(&[[-0.2, -0.3, 0.9], [0.1, 0.5, 1.1], [0.4, -0.2, 1.0]])];
    let lamp = linear(ceiling([-1.0, 1.0], [-1.0, 1.0], 2.0));
    let position = DVec3::new(0.1, 0.2, 0.0);
    let value = |p: DVec3| evaluate(&receiver(p.to_array()), &lamp, &screens).unwrap().radiosity;
    let gradient = evaluate(&receiver(position.to_array()), &lamp, &screens).unwrap().gradient;
    let step = 1e-3;
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        let central = |s: f64| (value(position + axis * s) - value(position - axis * s)) / (2.0 * s);
        let richardson = (4.0 * central(step / 2.0) - central(step)) / 3.0;
        assert!((richardson - gradient.dot(axis)).abs() < 1e-10, "{axis}: {richardson} {gradient}");
    }
}

#[test]
fn a_screen_that_only_touches_the_view_of_an_edge_leaves_the_gradient_as_it_is() {
    // The screen stands below the horizon; its upright through (-1, 1) is seen in the plane of the lamp's edge to that point.
    let triangle = polygon(&[[-1.0, 1.0, 0.0], [0.0, 0.5, 0.0], [0.0, 1.0, -0.5]]);
    let screen = polygon(&[[-1.0, 1.0, 0.0], [0.0, -0.5, 0.0], [0.0, -0.5, 0.5], [-1.0, 1.0, 0.5]]);
    let x = Receiver::new(DVec3::new(0.0, 1.0, 0.0), DVec3::NEG_Z, 1.0).unwrap();
    let reversed = Polygon::new(triangle.vertices().iter().rev().copied().collect()).unwrap();
    let answers = [triangle, reversed].map(|lamp| {
        let lamp = Emitter::new(lamp, Emission::Constant(1.0)).unwrap();
        let [free, beside] = [vec![], vec![screen.clone()]].map(|screens| evaluate(&x, &lamp, &screens).unwrap());
        assert_same(&[beside], &[free]);
        free.radiosity
    });
    assert!(answers[0].max(answers[1]) > 0.01);
}

#[test]
fn hundreds_of_screens_leave_the_same_in_any_order() {
    let mut state = 3_u64;
    let mut uniform = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let mut screen = || {
        let middle = DVec3::new(2.0 * uniform(), 2.0 * uniform(), 2.0 + uniform());
        let mut corner = || middle + DVec3::new(uniform(), uniform(), uniform()) * 0.15;
        Polygon::new(vec![corner(), corner(), corner()]).unwrap()
    };
    let screens: Vec<Polygon> = (0..300).map(|_| screen()).collect();
    let (x, lamp) = (receiver([0.1, 0.2, 0.0]), linear(ceiling([-1.0, 1.0], [-1.0, 1.0], 4.0)));
    let there = evaluate(&x, &lamp, &screens).unwrap();
    let back = evaluate(&x, &lamp, screens.iter().rev()).unwrap();
    assert!(there.meets(1e-12) && back.meets(1e-12) && there.radiosity > 0.0, "{there:?} {back:?}");
    assert!((there.radiosity - back.radiosity).abs() <= there.radiosity_error + back.radiosity_error, "{there:?} {back:?}");
    assert!((there.gradient - back.gradient).length() <= there.gradient_error + back.gradient_error, "{there:?} {back:?}");
    // One more hides no less, and twice the same no more.
    let fewer = evaluate(&x, &lamp, &screens[1..]).unwrap();
    assert!(there.radiosity <= fewer.radiosity + there.radiosity_error + fewer.radiosity_error, "{there:?} {fewer:?}");
    let doubled = evaluate(&x, &lamp, screens.iter().chain(&screens)).unwrap();
    assert!((there.radiosity - doubled.radiosity).abs() <= there.radiosity_error + doubled.radiosity_error, "{doubled:?}");
}
