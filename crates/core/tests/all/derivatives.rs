//! Derivatives against differences of the radiosity, and against identities that must hold.

use radgrad_core::{
    DVec3, Derivative, Derivatives, Emission, Emitter, Linear, Method, Polygon, Polynomial, Receiver, derivatives, evaluate_to,
};
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

/// All that the radiosity at a point depends on.
#[derive(Clone)]
struct Problem {
    position: DVec3,
    normal: DVec3,
    reflectance: f64,
    lamp: Vec<DVec3>,
    emission: Emission,
    screens: Vec<Vec<DVec3>>,
}

impl Problem {
    fn with<R>(&self, call: impl FnOnce(&Receiver, &Emitter, &[Polygon]) -> R) -> R {
        let receiver = Receiver::new(self.position, self.normal, self.reflectance).unwrap();
        let lamp = Emitter::new(Polygon::new(self.lamp.clone()).unwrap(), self.emission.clone()).unwrap();
        let screens: Vec<Polygon> = self.screens.iter().map(|screen| Polygon::new(screen.clone()).unwrap()).collect();
        call(&receiver, &lamp, &screens)
    }

    fn derivatives(&self) -> Derivatives {
        self.with(|receiver, lamp, screens| derivatives(receiver, lamp, screens, 1e-12).unwrap())
    }

    fn radiosity(&self) -> f64 {
        self.with(|receiver, lamp, screens| evaluate_to(receiver, lamp, screens, 1e-14).unwrap().radiosity)
    }

    /// Central differences of orders 2, 4, 6 by Richardson's extrapolation.
    fn difference(&self, step: f64, change: impl Fn(&mut Self, f64)) -> f64 {
        let changed = |by: f64| {
            let mut other = self.clone();
            change(&mut other, by);
            other.radiosity()
        };
        let central = |step: f64| (changed(step) - changed(-step)) / (2.0 * step);
        let [one, two, four] = [step, 2.0 * step, 4.0 * step].map(central);
        let (fine, coarse) = ((4.0 * one - two) / 3.0, (4.0 * two - four) / 3.0);
        (16.0 * fine - coarse) / 15.0
    }

    fn by_vector(&self, step: f64, place: impl Fn(&mut Self) -> &mut DVec3) -> DVec3 {
        DVec3::from([DVec3::X, DVec3::Y, DVec3::Z].map(|axis| self.difference(step, |problem, by| *place(problem) += axis * by)))
    }
}

/// The parameters of an emission, to be changed.
fn parameter(emission: &Emission, index: usize, by: f64) -> Emission {
    match emission.clone() {
        Emission::Constant(value) => Emission::Constant(value + by),
        Emission::Linear(Linear::AtVertices(mut values)) => {
            values[index] += by;
            Emission::at_vertices(values)
        }
        Emission::Linear(Linear::Gradient { value, gradient }) if index == 0 => Emission::gradient(value + by, gradient),
        Emission::Linear(Linear::Gradient { value, mut gradient }) => {
            gradient[index - 1] += by;
            Emission::gradient(value, gradient)
        }
        Emission::Polynomial(polynomial) => {
            let terms = polynomial.terms().iter().enumerate();
            let terms = terms.map(|(i, term)| (term.coefficient + if i == index { by } else { 0.0 }, term.powers));
            Emission::Polynomial(Polynomial::new(polynomial.origin(), terms).unwrap())
        }
    }
}

/// Lamps of all emissions overhead, screens in between, some through the lamp's plane, and horizons across both.
fn random_problem(random: &mut ChaCha8Rng, round: usize) -> Problem {
    let mut vector = |size: f64| DVec3::from([(); 3].map(|()| random.random_range(-size..size)));
    let mut lamp: Vec<DVec3> = (0..3).map(|_| vector(1.0) * DVec3::new(1.0, 1.0, 0.3) + DVec3::Z).collect();
    if (lamp[1] - lamp[0]).cross(lamp[2] - lamp[0]).z > 0.0 {
        lamp.reverse();
    }
    let terms = [(1.0, [0, 0, 0]), (0.4, [1, 0, 0]), (-0.7, [0, 1, 2]), (0.3, [2, 0, 1])];
    let emission = [
        Emission::Constant(1.7),
        Emission::at_vertices(vec![1.0, 2.5, 0.5]),
        Emission::gradient(1.2, DVec3::new(0.4, -0.8, 0.6)),
        Emission::Polynomial(Polynomial::new(DVec3::new(0.1, 0.2, 0.8), terms).unwrap()),
    ][round % 4]
        .clone();
    let normal = if round.is_multiple_of(3) { vector(1.0) } else { vector(0.3) + DVec3::Z };
    let position = vector(0.5) - DVec3::Z * 0.3;
    let screens = (0..round / 4 % 3).map(|i| {
        let middle = vector(0.3) + DVec3::Z * if i == 0 { 0.4 } else { 0.9 };
        (0..3).map(|_| middle + vector(0.5)).collect()
    });
    let screens = screens.collect();
    Problem { position, normal, reflectance: 0.6, lamp, emission, screens }
}

#[test]
fn they_are_the_differences_of_the_radiosity() {
    let mut random = ChaCha8Rng::seed_from_u64(17);
    let (mut seen, mut by_screens, mut missed) = (0, 0, Vec::new());
    for round in 0..120 {
        let problem = random_problem(&mut random, round);
        let answer = problem.derivatives();
        let largest =
            answer.vertices.iter().chain(answer.occluders.iter().flatten()).map(|v| v.value.length()).fold(0.0, f64::max);
        if answer.method == Method::Zero {
            continue;
        }
        seen += 1;
        // A difference spans a kink where a vertex is almost hidden: other steps then agree with each other no better.
        let mut check = |what: String, value: DVec3, difference: &dyn Fn(f64) -> DVec3| {
            let off = |step: f64| (difference(step) - value).length() / largest;
            let error = off(1e-4);
            if error > 1e-7 {
                missed.push(format!("{round}: {what} is {value}, by differences {}: {error:e}", difference(1e-4)));
            }
        };
        for k in 0..3 {
            let vertex = |problem: &Problem, step| problem.by_vector(step, |problem| &mut problem.lamp[k]);
            check(format!("vertex {k}"), answer.vertices[k].value, &|step| vertex(&problem, step));
            for (i, screen) in answer.occluders.iter().enumerate() {
                let vertex = |problem: &Problem, step| problem.by_vector(step, |problem| &mut problem.screens[i][k]);
                check(format!("vertex {k} of screen {i}"), screen[k].value, &|step| vertex(&problem, step));
                by_screens += usize::from(screen[k].value != DVec3::ZERO);
            }
        }
        for (i, derivative) in answer.emission.iter().enumerate() {
            let by = |problem: &mut Problem, by| problem.emission = parameter(&problem.emission, i, by);
            let difference = |step| DVec3::X * problem.difference(step, by);
            check(format!("parameter {i}"), DVec3::X * derivative.value, &difference);
        }
        let turned = problem.by_vector(1e-4, |problem| &mut problem.normal) * problem.normal.length();
        let across = answer.normal.value.reject_from(problem.normal);
        check("normal".into(), across, &|_| turned);
        let reflectance = |step| DVec3::X * problem.difference(step, |problem, by| problem.reflectance += by);
        check("reflectance".into(), DVec3::X * answer.reflectance.value, &reflectance);
    }
    println!("{seen} problems, {by_screens} vertices of screens that matter");
    assert!(seen > 100 && by_screens > 120, "{seen} {by_screens}");
    assert!(missed.is_empty(), "{} missed:\n{}", missed.len(), missed.join("\n"));
}

fn lengths<'a>(of: impl IntoIterator<Item = &'a Derivative<DVec3>>) -> f64 {
    of.into_iter().map(|derivative| derivative.value.length()).sum()
}

#[test]
fn cheap_answers_are_within_their_bounds_of_many_digits() {
    let mut random = ChaCha8Rng::seed_from_u64(23);
    let (mut closed, mut worst) = (0, 0.0f64);
    for round in 0..160 {
        let problem = Problem { emission: Emission::Constant(1.7), screens: Vec::new(), ..random_problem(&mut random, round) };
        // Near and far.
        let problem = Problem { position: problem.position - DVec3::Z * f64::from(u32::try_from(round % 5).unwrap()), ..problem };
        let [cheap, fine] = [1e-12, 0.0]
            .map(|tolerance| problem.with(|receiver, lamp, screens| derivatives(receiver, lamp, screens, tolerance).unwrap()));
        closed += usize::from(cheap.method == Method::ClosedForm);
        let mut hold = |error: f64, bounds: f64| {
            assert!(error <= bounds, "{round}: {error:e} {bounds:e}");
            worst = worst.max(if bounds > 0.0 { error / bounds } else { 0.0 });
        };
        let vectors = |of: &Derivatives| [vec![of.gradient, of.normal], of.vertices.clone()].concat();
        for (a, b) in vectors(&cheap).iter().zip(&vectors(&fine)) {
            hold((a.value - b.value).length(), a.error + b.error);
        }
        let numbers = |of: &Derivatives| [vec![of.radiosity, of.reflectance], of.emission.clone()].concat();
        for (a, b) in numbers(&cheap).iter().zip(&numbers(&fine)) {
            hold((a.value - b.value).abs(), a.error + b.error);
        }
    }
    println!("{closed} by the closed form in doubles, at most {worst:.2} of a bound");
    assert!(closed > 80 && worst > 0.02, "{closed} {worst}");
}

#[test]
fn what_moves_together_is_what_the_receiver_sees_move() {
    let mut random = ChaCha8Rng::seed_from_u64(29);
    let mut seen = 0;
    for round in (0..200).filter(|round| round % 4 < 2) {
        let problem = random_problem(&mut random, round);
        let answer = problem.derivatives();
        let all = || answer.vertices.iter().chain(answer.occluders.iter().flatten());
        let places = problem.lamp.iter().chain(problem.screens.iter().flatten());
        let room = 1e-12 * lengths(all());
        let about = DVec3::new(0.4, -0.7, 0.2);
        let (mut shift, mut turn, mut scale) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        for (place, derivative) in places.zip(all()) {
            let arm = *place - about;
            shift += derivative.value;
            turn += arm.cross(derivative.value);
            scale += arm.dot(derivative.value);
        }
        assert!((shift - answer.translation().value).length() <= room, "{round}: {shift} {answer:?}");
        assert!((turn - answer.rotation(about).value).length() <= 3.0 * room, "{round}: {turn}");
        assert!((scale - answer.scale(about).value).abs() <= 3.0 * room, "{round}: {scale}");
        seen += usize::from(answer.method != Method::Zero);
    }
    assert!(seen > 40, "{seen}");
}

#[test]
fn an_edge_seen_along_another_has_a_bound_as_large_as_the_jump() {
    let point = |x, y, z| DVec3::new(x, y, z);
    let lamp = vec![point(-1.0, -1.0, 2.0), point(-1.0, 1.0, 2.0), point(1.0, 1.0, 2.0), point(1.0, -1.0, 2.0)];
    // Its edge is in the plane of the receiver and the lamp's edge at x = 1.
    let screen = |x: f64| vec![point(x, -2.0, 1.0), point(x, 2.0, 1.0), point(2.0, 0.0, 1.0)];
    let problem = |x| Problem {
        position: DVec3::ZERO,
        normal: DVec3::Z,
        reflectance: 1.0,
        lamp: lamp.clone(),
        emission: Emission::Constant(1.0),
        screens: vec![screen(x)],
    };
    let [before, at, after] = [0.5 - 1e-9, 0.5, 0.5 + 1e-9].map(|x| problem(x).derivatives());
    let jump = (before.occluders[0][0].value - after.occluders[0][0].value).length();
    assert!(jump > 0.01 && after.occluders[0][0].value.length() < 1e-9);
    assert!(at.occluders[0].iter().chain(&at.vertices).any(|vertex| vertex.error >= jump), "{at:?}");
    for side in [before, after] {
        for (found, other) in at.occluders[0].iter().zip(&side.occluders[0]).chain(at.vertices.iter().zip(&side.vertices)) {
            assert!((found.value - other.value).length() <= found.error + 1e-7, "{found:?} {other:?}");
        }
    }
}

/// A lamp at the height of 2 over the origin, and a wall that stands through its plane.
fn lamp_and_wall(position: DVec3, wall: [[f64; 2]; 2]) -> Problem {
    let point = |x, y, z| DVec3::new(x, y, z);
    let [from, to] = wall.map(|[x, y]| DVec3::new(x, y, 0.0));
    Problem {
        position,
        normal: DVec3::Z,
        reflectance: 1.0,
        lamp: vec![point(-1.0, -1.0, 2.0), point(-1.0, 1.0, 2.0), point(1.0, 1.0, 2.0), point(1.0, -1.0, 2.0)],
        emission: Emission::Constant(1.0),
        screens: vec![[(from, 1.0), (to, 1.0), (to, 3.0), (from, 3.0)].map(|(v, z)| v + DVec3::Z * z).to_vec()],
    }
}

#[test]
fn where_a_wall_meets_the_lamp_in_its_corners_derivatives_have_bounds() {
    for emission in [Emission::Constant(1.0), Emission::at_vertices(vec![1.0, 2.0, 3.0, 2.0])] {
        let problem = Problem { emission, ..lamp_and_wall(DVec3::new(0.3, -0.2, 0.0), [[-2.0, -2.0], [2.0, 2.0]]) };
        let found = problem.derivatives();
        let size = lengths(found.vertices.iter().chain(&found.occluders[0]));
        assert!(found.vertices.iter().chain(&found.occluders[0]).all(|vertex| vertex.error <= 1e-12 * size), "{found:?}");
        // It cuts the lamp more or less as it is moved across.
        let across = DVec3::new(1.0, -1.0, 0.0);
        let shift: DVec3 = found.occluders[0].iter().map(|vertex| vertex.value).sum();
        let difference = problem.difference(1e-6, |moved, step| moved.screens[0].iter_mut().for_each(|v| *v += across * step));
        assert!((shift.dot(across) - difference).abs() < 1e-5 && difference.abs() > 0.01, "{shift} {difference}");
    }
}

#[test]
fn where_a_wall_meets_the_lamp_along_its_edge_the_bound_is_finite_and_as_large_as_the_jump() {
    let problem = |x| lamp_and_wall(DVec3::ZERO, [[x, -2.0], [x, 2.0]]);
    let [before, at, after] = [1.0 - 1e-9, 1.0, 1.0 + 1e-9].map(|x| problem(x).derivatives());
    let shift = |found: &Derivatives| found.occluders[0].iter().map(|vertex| vertex.value).sum::<DVec3>().x;
    assert!((shift(&before) - shift(&after)).abs() > 0.01, "{before:?} {after:?}");
    for side in [before, after] {
        for (found, other) in at.occluders[0].iter().zip(&side.occluders[0]).chain(at.vertices.iter().zip(&side.vertices)) {
            assert!(found.error.is_finite() && (found.value - other.value).length() <= found.error + 1e-7, "{found:?} {other:?}");
        }
    }
}

#[test]
fn what_does_not_emit_or_reflect_still_says_what_it_would_give() {
    let mut problem = random_problem(&mut ChaCha8Rng::seed_from_u64(31), 1);
    problem.emission = Emission::Constant(0.0);
    let dark = problem.derivatives();
    problem.emission = Emission::Constant(1.0);
    let unit = problem.derivatives();
    assert!(unit.emission[0].value > 0.0 && (dark.emission[0].value - unit.radiosity.value).abs() < 1e-15);
    assert!(dark.vertices.iter().all(|vertex| vertex.value == DVec3::ZERO) && dark.radiosity.value == 0.0);
    problem.reflectance = 0.0;
    let black = problem.derivatives();
    assert!((black.reflectance.value - unit.reflectance.value).abs() < 1e-15 && black.radiosity.value == 0.0);
    problem.position = DVec3::Z * 9.0;
    let behind = problem.derivatives();
    assert!(behind.method == Method::Zero && behind.vertices.len() == 3 && behind.reflectance.value == 0.0);
}

#[test]
fn an_occluder_seen_edge_on_has_no_derivative_and_the_bound_says_so() {
    let lamp = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)].map(|(x, y)| DVec3::new(x, y, 2.0)).to_vec();
    let blade = |tilt: f64| {
        vec![DVec3::new(-0.5, 0.0, 1.0), DVec3::new(0.5, 0.0, 1.0), DVec3::new(0.5, tilt, 1.5), DVec3::new(-0.5, tilt, 1.5)]
    };
    let problem = |tilt: f64, aside: f64| Problem {
        position: DVec3::new(0.0, aside, 0.0),
        normal: DVec3::Z,
        reflectance: 1.0,
        lamp: lamp.clone(),
        emission: Emission::Constant(1.0),
        screens: vec![blade(tilt)],
    };
    // The light falls whichever way the blade tilts.
    let lost = [1e-6, -1e-6].map(|tilt| (problem(0.0, 0.0).radiosity() - problem(tilt, 0.0).radiosity()) / 1e-6);
    assert!(lost[0] > 0.01 && (lost[0] - lost[1]).abs() < 1e-3 * lost[0], "{lost:?}");
    let edge_on = problem(0.0, 0.0).derivatives();
    assert!(edge_on.occluders[0].iter().all(|vertex| vertex.error == f64::INFINITY), "{edge_on:?}");
    assert!(edge_on.vertices.iter().all(|vertex| vertex.error < 1e-12), "{edge_on:?}");
    // Beside its plane the derivatives are there, and where its plane passes the lamp by.
    let far = Problem { lamp: lamp.iter().map(|vertex| *vertex + DVec3::Y * 1.5).collect(), ..problem(0.0, 0.0) };
    for other in [problem(0.0, 0.1), far] {
        let answer = other.derivatives();
        assert!(answer.occluders[0].iter().all(|vertex| vertex.error < 1e-9), "{answer:?}");
    }
}
