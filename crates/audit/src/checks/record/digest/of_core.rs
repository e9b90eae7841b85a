//! The blocks of core and of numbers.

use glam::DVec3;
use radgrad_core::batch::{Answers, EmitterTree, Emitters, Engine, Precision, ReadyEmitter, Receivers};
use radgrad_core::{
    Emission, Emitter, Monomial, Polygon, evaluate_digits, gradient, hessian, hessian_to, irradiance_vector,
    irradiance_vector_to, radiosity, radiosity_and_gradient,
};
use radgrad_numbers::ball::Ball;
use radgrad_numbers::big::{self, Big};
use radgrad_numbers::double_double::DoubleDouble;
use radgrad_numbers::exact;
use radgrad_numbers::radius::Radius;
use radgrad_numbers::real::Real;
use radgrad_scene::case::Problem;

use super::bits::{Digest, Question};
use crate::bounds::search;
use crate::bounds::witness::{self, Query};
use crate::cases::family::Family;
use crate::cases::sampler::Sampler;
use crate::checks::batches::{self, Cast};
use crate::checks::operations;

const ANSWERS: [Query; 10] = [
    Query::Answer(1.0),
    Query::Answer(1e-7),
    Query::Answer(1e-11),
    Query::Answer(1e-14),
    Query::Value(1.0),
    Query::Value(1e-8),
    Query::Value(1e-13),
    Query::Lanes(1.0),
    Query::Lanes(1e-9),
    Query::Lanes(1e-13),
];

/// Everything that core says of a problem.
fn of_problem(digest: &mut Digest, name: &str, problem: &Problem, digits: bool) {
    let Problem { receiver, emitter, occluders, .. } = problem;
    let (mut value, mut slope) = (Question::new(name), Question::new(name));
    for ask in ANSWERS {
        match ask.answer(problem) {
            Ok(Some((_, answer))) => {
                digest.text(answer.method.name());
                value.add(digest, ask, [answer.radiosity, 0.0, 0.0], answer.radiosity_error);
                if !matches!(ask, Query::Value(_)) {
                    slope.add(digest, ask, answer.gradient.to_array(), answer.gradient_error);
                }
            }
            Ok(None) => {}
            Err(_) => digest.refused(),
        }
    }
    value.close(digest);
    slope.close(digest);
    let (mut second, mut irradiance) = (Question::new(name), Question::new(name));
    for tolerance in [1.0, 1e-9] {
        if let Ok(hessian) = hessian_to(receiver, emitter, occluders, tolerance) {
            digest.text(hessian.method.name());
            for (column, value) in hessian.matrix.to_cols_array_2d().into_iter().enumerate() {
                digest.word(column as u64);
                if column == 0 {
                    second.add(digest, format_args!("hessian {tolerance:e}"), value, hessian.error);
                } else {
                    digest.numbers(&value);
                }
            }
        }
        if let Ok(vector) = irradiance_vector_to(receiver, emitter, occluders, tolerance) {
            digest.text(vector.method.name());
            irradiance.add(digest, format_args!("irradiance {tolerance:e}"), vector.vector.to_array(), vector.error);
        }
    }
    second.close(digest);
    irradiance.close(digest);
    if occluders.is_empty() {
        digest.say(radiosity(receiver, emitter).map(|value| vec![value]));
        digest.say(gradient(receiver, emitter).map(|slope| slope.to_array().to_vec()));
        digest.say(radiosity_and_gradient(receiver, emitter).map(|(value, slope)| [&[value], &slope.to_array()[..]].concat()));
        digest.say(irradiance_vector(receiver, emitter).map(|vector| vector.to_array().to_vec()));
        digest.say(hessian(receiver, emitter).map(|matrix| matrix.to_cols_array().to_vec()));
    }
    if digits {
        for count in [7, 40] {
            match evaluate_digits(receiver, emitter, occluders, count) {
                Ok(answer) => {
                    let texts = [&answer.radiosity, &answer.radiosity_error, &answer.gradient_error];
                    texts.into_iter().chain(&answer.gradient).for_each(|text| digest.text(text));
                }
                Err(_) => digest.refused(),
            }
        }
    }
    let mut rounded = problem.clone();
    if witness::round_to_single(&mut rounded) {
        for ask in [Query::SingleLanes(1.0), Query::SingleLanes(1e-4)] {
            let said = ask.answer(&rounded).map(|said| {
                said.map_or(Vec::new(), |(_, answer)| {
                    let numbers = [answer.radiosity, answer.radiosity_error, answer.gradient_error];
                    [&numbers[..], &answer.gradient.to_array()].concat()
                })
            });
            digest.say(said);
        }
    }
}

/// Cases of a family.
const CASES: u64 = 5;

pub(super) fn of_cases(digest: &mut Digest, index: u64) {
    let families = Family::ALL.into_iter().filter(|family| family.dearness() <= 4);
    let Some(family) = families.into_iter().nth(usize::try_from(index).unwrap_or(usize::MAX)) else { return };
    for k in 0..CASES / family.dearness() {
        let case = family.case(43, k);
        match case.problem() {
            Ok(problem) => of_problem(digest, &format!("{}:43:{k}", family.name()), &problem, k == 0),
            Err(_) => digest.refused(),
        }
    }
}

pub(super) fn of_brinks(digest: &mut Digest, index: u64) {
    for k in 0..12 {
        let sampler = &mut Sampler::new(44, "digest of brinks", 12 * index + k);
        let case = if k % 2 == 0 { search::brink(sampler) } else { search::awkward(sampler) };
        if let Ok(problem) = case.problem() {
            of_problem(digest, &format!("brinks {index} {k}"), &problem, false);
        }
    }
}

/// All answers of a batch in one precision.
fn of_batch<F: Precision>(digest: &mut Digest, name: &str, problem: &Problem, of: &[[DVec3; 2]], cast: &Cast<F>) {
    let ready = ReadyEmitter::<F>::new(problem.emitter.clone());
    let mut values: Vec<Question<'_>> = of.iter().map(|_| Question::new(name)).collect();
    let mut slopes: Vec<Question<'_>> = of.iter().map(|_| Question::new(name)).collect();
    for way in 0..batches::WAYS {
        let Ok(answers) = batches::asked(Engine::new(), (problem, &ready), of, cast, way) else {
            digest.refused();
            continue;
        };
        let counts = answers.counts;
        let counts = [counts.zero, counts.whole, counts.clipped, counts.doubled, counts.single];
        counts.into_iter().for_each(|count| digest.word(count as u64));
        answers.method.iter().for_each(|method| digest.text(method.name()));
        for k in 0..of.len() {
            let (value, slope, [of_value, of_slope]) = batches::entry(&answers, cast, k);
            // Without its occluders it is another question.
            let is_held = !of_value.is_nan() && (problem.occluders.is_empty() || way >= batches::PAST_OCCLUDERS);
            if is_held {
                values[k].add(digest, format_args!("receiver {k}, way {way}"), [value, 0.0, 0.0], of_value);
            } else {
                digest.numbers(&[value, of_value]);
            }
            if is_held && !of_slope.is_nan() {
                slopes[k].add(digest, format_args!("receiver {k}, way {way}, gradient"), slope.to_array(), of_slope);
            } else {
                digest.vector(slope);
                digest.number(of_slope);
            }
        }
    }
    values.into_iter().chain(slopes).for_each(|question| question.close(digest));
}

pub(super) fn of_batches(digest: &mut Digest, index: u64) {
    let sampler = &mut Sampler::new(45, "digest of batches", index);
    let Ok(problem) = batches::case(45, index).problem() else { return digest.refused() };
    let name = format!("batches {index}");
    let places = batches::receivers(sampler, &problem, 21);
    of_batch(digest, &name, &problem, &places, &batches::DOUBLE);
    of_batch(digest, &name, &problem, &places, &batches::SINGLE);
    // Seen from one receiver, with others.
    let lamps: Vec<Emitter> = (0..9)
        .filter_map(|k| Some(batches::case(46, index + k).problem().ok()?.emitter))
        .chain([problem.emitter.clone()])
        .collect();
    let mut answers = Answers::new();
    let said = |answers: &Answers| {
        let arrays = answers.gradient.iter().chain([&answers.radiosity, &answers.radiosity_error, &answers.gradient_error]);
        arrays.flatten().copied().collect::<Vec<f64>>()
    };
    for tolerance in [None, Some(1.0), Some(1e-8), Some(1e-12)] {
        let emitters = Emitters::<f64>::new(&lamps);
        let asked = match tolerance {
            None => Engine::new().each(&problem.receiver, &emitters, &mut answers),
            Some(tolerance) => Engine::new().each_to(&problem.receiver, &emitters, tolerance, &mut answers),
        };
        digest.say(asked.map(|()| said(&answers)));
    }
    let mut singles = Answers::<f32>::new();
    let asked = Engine::new().each_to(&problem.receiver, &Emitters::<f32>::new(&lamps), 1e-3, &mut singles);
    let numbers = || singles.radiosity.iter().chain(&singles.radiosity_error).chain(&singles.gradient_error);
    digest.say(asked.map(|()| numbers().map(|number| f64::from(*number)).collect()));
    // All of them by a tree.
    let (x, n) = (problem.receiver.position().to_array().map(|c| [c]), problem.receiver.direction().to_array().map(|c| [c]));
    let Ok(one) = Receivers::new([&x[0], &x[1], &x[2]], [&n[0], &n[1], &n[2]], &[1.0]) else { return };
    for tolerance in [1.0, 1e-6] {
        let asked = Engine::new().total(&one, &EmitterTree::new(&lamps), tolerance, &mut answers);
        digest.say(asked.map(|tally| [said(&answers), vec![tally.looked_at as f64, tally.far_nodes as f64]].concat()));
    }
}

pub(super) fn of_operations(digest: &mut Digest, index: u64) {
    let (at, radii) = operations::operands(&mut Sampler::new(47, "digest of operations", index));
    let mut feed = |middle: [f64; 2], error: f64| {
        digest.numbers(&middle);
        digest.number(error);
    };
    for ball in operations::results([0, 1, 2].map(|k| Ball::<f64>::approximate(at[k], radii[k]))) {
        feed([ball.middle(), 0.0], ball.error().to_double());
    }
    for ball in operations::results([0, 1, 2].map(|k| Ball::<DoubleDouble>::approximate(at[k].into(), radii[k]))) {
        feed([ball.middle().hi, ball.middle().lo], ball.error().to_double());
    }
    if index.is_multiple_of(16) {
        let told = || {
            let balls = operations::results(at.map(Ball::<Big>::exact));
            balls.map(|ball| (ball.middle().to_float().to_string(), ball.error().to_double()))
        };
        let bits = [128, 256, 1024][(index / 16 % 3) as usize];
        if let Some(all) = big::within(bits, u64::MAX, told).0 {
            for (middle, error) in all {
                digest.text(middle);
                digest.number(error);
            }
        }
    }
    // Signs of nearly flat things, and heights.
    let s = &mut Sampler::new(48, "digest of signs", index);
    let few = |v: DVec3| v.map(|c| (c * 4.0).round());
    let points = if s.one_in(2) { [0; 4].map(|_| few(s.cube())) } else { [0; 4].map(|_| s.cube()) };
    digest.number(exact::orientation(points).signum());
    digest.word(u64::from(exact::are_in_line([points[0], points[1], (points[0] + points[1]) * 0.5])));
    let height = exact::height((points[3], 0.5), points[0], points[1], 2.0);
    digest.numbers(&[height.hi, height.lo]);
}

pub(super) fn of_problems(digest: &mut Digest, index: u64) {
    let s = &mut Sampler::new(49, "digest of problems", index);
    let count = 3 + s.below(5);
    let size = [1.0, 1e-9, 1e12, libm::ldexp(1.0, 700)][s.below(4) as usize];
    let (u, v) = s.direction().any_orthonormal_pair();
    let centre = s.cube() * s.spread(-4, 20);
    let bent = [0.0, 1e-12, 1e-6, 1e-3][s.below(4) as usize];
    let corner = |k: u32| {
        let turn = std::f64::consts::TAU * f64::from(k) / f64::from(count);
        let far = s.between(0.5, 1.0);
        (centre + (u * libm::cos(turn) + v * libm::sin(turn)) * far + s.cube() * bent) * size
    };
    let corners: Vec<DVec3> = (0..count).map(corner).collect();
    let polygon = if bent == 0.0 && count == 3 {
        Polygon::new(corners)
    } else {
        Polygon::from_rounded(corners, 4.0 * size * (bent + 1e-15 * centre.length()))
    };
    let Ok(polygon) = polygon else { return digest.refused() };
    let of_polygon = |digest: &mut Digest, polygon: &Polygon| {
        digest.vector(polygon.normal());
        digest.numbers(&[polygon.area(), polygon.planarity_defect(), polygon.precision()]);
        polygon.vertices().iter().for_each(|vertex| digest.vector(*vertex));
    };
    of_polygon(digest, &polygon);
    if let Ok(image) = polygon.map(2.0, |p| (p - corner_of(&polygon)) * 2.0) {
        of_polygon(digest, &image);
    }
    let (at, unit) = (corner_of(&polygon), polygon.area().sqrt());
    let slope = s.cube();
    let along = (slope - polygon.normal() * slope.dot(polygon.normal())) / unit;
    let values = (0..count).map(|_| s.between(-0.5, 2.0)).collect::<Vec<_>>();
    // Those that an affine function has are taken for any number of vertices.
    let affine = polygon.vertices().iter().map(|v| 1.0 + along.dot(*v - at)).collect::<Vec<_>>();
    let monomials = [(1.0, [0, 0, 0]), (s.between(-1.0, 1.0) / unit, [1, 0, 0]), (0.5 / unit / unit, [0, 1, 1])];
    let emissions = [
        Some(Emission::Constant(s.between(0.5, 2.0))),
        Some(Emission::at_vertices(values)),
        Some(Emission::at_vertices(affine)),
        Some(Emission::gradient(1.0, along)),
        radgrad_core::Polynomial::new(at, monomials).ok().map(Emission::Polynomial),
    ];
    for emission in emissions.into_iter().flatten() {
        let Ok(emitter) = Emitter::new(polygon.clone(), emission) else {
            digest.refused();
            continue;
        };
        digest.numbers(&[emitter.largest_emission(), emitter.steepest_emission(), emitter.emission_at(at + along)]);
        digest.vector(emitter.emission_gradient_at(at));
        if let Emission::Polynomial(polynomial) = emitter.emission() {
            let of = |term: &Monomial| digest.number(term.coefficient);
            polynomial.terms().iter().for_each(of);
        }
    }
}

fn corner_of(polygon: &Polygon) -> DVec3 {
    polygon.vertices()[0]
}
