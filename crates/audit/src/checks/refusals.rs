//! Rules of refusal, just within and just beyond: polygons that rounding has bent or crossed, emission at vertices that is no affine function,
//! and numbers out of range.
//!
//! Each rule is put to what is just within it and to what is beyond, by a computation of its own.

use glam::DVec3;
use radgrad_certificate::{Request, certify};
use radgrad_core::batch::{Answers, Engine, Receivers};
use radgrad_core::{
    DMat3, Emission, Emitter, Error, Polygon, Polynomial, Receiver, Tolerance, derivatives, evaluate_digits, evaluate_to,
    evaluate_value, hessian, hessian_to, irradiance_vector, irradiance_vector_to,
};

use crate::cases::sampler::Sampler;
use crate::checks::screens::of_faces;

/// A polygon of whole numbers over a coordinate plane, put into a tilted plane without rounding.
fn planar(sampler: &mut Sampler) -> Vec<DVec3> {
    let outlines: [&[[f64; 2]]; 5] = [
        &[[0.0, 0.0], [9.0, 1.0], [11.0, 7.0], [2.0, 8.0]],
        &[[0.0, 0.0], [5.0, -2.0], [9.0, 3.0], [6.0, 8.0], [-1.0, 5.0]],
        &[[0.0, 0.0], [64.0, 1.0], [65.0, 4.0], [3.0, 5.0]],
        // It turns inward where it starts, or elsewhere.
        &[[0.0, 0.0], [-4.0, -5.0], [12.0, 0.0], [-4.0, 5.0]],
        &[[0.0, 0.0], [9.0, 1.0], [4.0, 3.0], [2.0, 8.0]],
    ];
    let mut whole = || DVec3::from([(); 3].map(|()| sampler.integer(-7, 7) as f64 / 8.0));
    let (u, v, start) = (whole() + DVec3::X * 2.0, whole() + DVec3::Y * 2.0, whole() * 16.0);
    outlines[sampler.below(5) as usize].iter().map(|[x, y]| start + u * *x + v * *y).collect()
}

/// Height of vertex j over the plane through vertex 0 across the vector of the area.
fn height(vertices: &[DVec3], j: usize) -> f64 {
    let from = |i: usize| vertices[i] - vertices[0];
    let area: DVec3 = (1..vertices.len() - 1).map(|i| from(i).cross(from(i + 1))).sum();
    area.normalize().dot(from(j))
}

/// The vertices, each coordinate moved by `precision` so that vertex j comes as high as it can; and that height, to first order.
fn bent(vertices: &[DVec3], j: usize, precision: f64) -> (Vec<DVec3>, f64) {
    let (step, mut moved, mut most) = (1.0 / 1024.0, vertices.to_vec(), 0.0);
    for i in 0..vertices.len() {
        for axis in 0..3 {
            let at = |way: f64| {
                let mut vertices = vertices.to_vec();
                vertices[i][axis] += way * step;
                height(&vertices, j)
            };
            let slope = (at(1.0) - at(-1.0)) / (2.0 * step);
            moved[i][axis] += precision.copysign(slope);
            most += precision * slope.abs();
        }
    }
    (moved, most)
}

/// How many times what rounding explains is surely refused.
const TOO_MUCH: f64 = 2.6;

fn flatness(sampler: &mut Sampler) -> Vec<String> {
    let vertices = planar(sampler);
    // The plane of four vertices is along their diagonals, so that the third one is as high as the first.
    let (j, precision) = (1 + 2 * sampler.below(2) as usize, sampler.spread(-30, -8));
    let mut findings = Vec::new();
    let (moved, most) = bent(&vertices, j, precision * (1.0 - 1e-6));
    if let Err(error) = Polygon::from_rounded(moved, precision) {
        findings.push(format!("vertex {j} of {vertices:?} is {most:e} high by {precision:e} in each coordinate: {error}"));
    }
    let (moved, _) = bent(&vertices, j, precision * TOO_MUCH);
    if Polygon::from_rounded(moved, precision).is_ok() {
        findings.push(format!("vertex {j} of {vertices:?} is more than {most:e} high, which {precision:e} does not explain"));
    }
    findings
}

/// An edge shorter than the precision, whose ends rounding has exchanged or made one.
fn short_edges(sampler: &mut Sampler) -> Vec<String> {
    let mut vertices = planar(sampler);
    let precision = sampler.spread(-20, -8);
    let place = sampler.below(4) as usize % vertices.len();
    let way = (vertices[(place + 1) % vertices.len()] - vertices[place]).normalize();
    let back = if sampler.one_in(2) { DVec3::ZERO } else { way * (precision * 0.4) };
    vertices.insert(place + 1, vertices[place] - back);
    let area = |vertices: &[DVec3]| {
        let from = |i: usize| vertices[i] - vertices[0];
        0.5 * (1..vertices.len() - 1).map(|i| from(i).cross(from(i + 1))).sum::<DVec3>().length()
    };
    let polygon = match Polygon::from_rounded(vertices.clone(), precision) {
        Ok(polygon) => polygon,
        Err(error) => return vec![format!("{vertices:?}, each coordinate off by {precision:e}: {error}")],
    };
    let far = vertices.iter().zip(polygon.vertices()).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f64::max);
    let room = 400.0 * precision;
    let is_off = far > precision * (1.0 + 1e-9) + 1e-12 || (polygon.area() - area(&vertices)).abs() > room;
    is_off
        .then(|| format!("vertices of {vertices:?} moved by {far:e}, the area by {:e}", polygon.area() - area(&vertices)))
        .into_iter()
        .collect()
}

/// Values at vertices, affine but for one.
fn affinity(sampler: &mut Sampler) -> Vec<String> {
    let vertices = planar(sampler);
    let Ok(polygon) = Polygon::new(vertices.clone()) else { return vec![format!("{vertices:?} is refused")] };
    let (slope, least) = (sampler.cube(), sampler.between(3.0, 9.0));
    let mut values: Vec<f64> = vertices.iter().map(|v| least + slope.dot(*v)).collect();
    let mut findings = Vec::new();
    match Emitter::new(polygon.clone(), Emission::at_vertices(values.clone())) {
        Ok(emitter) => {
            let along = slope - polygon.normal() * slope.dot(polygon.normal());
            if (emitter.emission_gradient() - along).length() > 1e-12 * (1.0 + least) {
                findings.push(format!("the gradient of {values:?} is {}, not {along}", emitter.emission_gradient()));
            }
            // Of three corners in another unit, near both ends of the range.
            let of_three = |unit: f64| {
                let values = values[..3].iter().map(|value| value * unit).collect();
                Ok(Emitter::new(Polygon::new(vertices[..3].to_vec())?, Emission::at_vertices(values))?.emission_gradient() / unit)
            };
            let slopes: [Result<DVec3, Error>; 3] = [0, 1000, -900].map(|power| of_three(libm::ldexp(1.0, power)));
            if slopes[1..].iter().any(|slope| *slope != slopes[0]) {
                findings.push(format!("the gradient of the first of {values:?} is {slopes:?} in other units"));
            }
        }
        Err(error) => findings.push(format!("{values:?} is affine but for rounding: {error}")),
    }
    let odd = sampler.below(4) as usize;
    values[odd] += sampler.sign() * sampler.between(0.5, 2.0);
    // In a unit in which all coordinates are far below those of a room.
    let small = vertices.iter().map(|v| *v * libm::ldexp(1.0, -200)).collect();
    let said = Polygon::new(small).and_then(|polygon| Emitter::new(polygon, Emission::at_vertices(values.clone())));
    if !matches!(said, Err(Error::EmissionNotAffine { .. })) {
        findings.push(format!("{values:?} is not affine in another unit either: {said:?}"));
    }
    // By the mean along each edge.
    let next = |i: usize| (i + 1) % vertices.len();
    let across = |i: usize| (vertices[next(i)] - vertices[i]).cross(polygon.normal()) * (0.5 * (values[i] + values[next(i)]));
    let slope = (0..vertices.len()).map(across).sum::<DVec3>() / polygon.area();
    let there = |i: usize| values[0] + slope.dot(vertices[i] - vertices[0]);
    match Emitter::new(polygon, Emission::at_vertices(values.clone())) {
        Err(Error::EmissionNotAffine { index, value, expected, allowed }) => {
            let most = (0..values.len()).map(|i| (values[i] - there(i)).abs()).fold(0.0, f64::max);
            let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * (1.0 + b.abs());
            if value != values[index]
                || !near(expected, there(index))
                || !near((value - expected).abs(), most)
                || allowed > 1e-6 * most
            {
                findings.push(format!("{values:?}: vertex {index} has {value}, {expected} is expected to {allowed:e}"));
            }
        }
        other => findings.push(format!("{values:?} is not affine: {other:?}")),
    }
    findings
}

/// The slope that a polynomial has at vertex 0, by its coefficients in the plane and by its terms.
fn slopes(sampler: &mut Sampler) -> Vec<String> {
    let Ok(polygon) = Polygon::new(planar(sampler)) else { return vec!["a plane polygon is refused".to_owned()] };
    let mut term = |powers: [u8; 3]| (sampler.between(-2.0, 2.0), powers);
    let terms = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [2, 0, 1], [1, 1, 1]].map(&mut term);
    let emitter = Polynomial::new(sampler.cube(), terms).and_then(|sum| Emitter::new(polygon, Emission::Polynomial(sum)));
    let Ok(emitter) = emitter else { return vec!["a polynomial is refused".to_owned()] };
    let [slope, by_terms] = [emitter.emission_gradient(), emitter.emission_gradient_at(emitter.polygon().vertices()[0])];
    let holds = (slope - by_terms).length() <= 1e-10 * (1.0 + by_terms.length());
    (!holds).then(|| format!("a polynomial has the slope {slope} at vertex 0, by its terms {by_terms}")).into_iter().collect()
}

/// Counts, degrees and numbers out of range, each with its neighbour that is within.
fn limits() -> Vec<String> {
    let triangle = || Polygon::new(vec![DVec3::Z, DVec3::Z + DVec3::Y, DVec3::Z + DVec3::X]);
    let lamp = |emission| triangle().and_then(|polygon| Emitter::new(polygon, emission));
    let mut findings = Vec::new();
    let mut hold = |what: &str, holds: bool| {
        if !holds {
            findings.push(what.to_owned());
        }
    };
    let count = |count: usize| lamp(Emission::at_vertices(vec![1.0; count])).err();
    let refused = |values: usize| Some(Error::EmissionCount { values, vertices: 3 });
    hold("as many values as vertices", [count(2), count(3), count(4)] == [refused(2), None, refused(4)]);
    let sum = |c: f64| Polynomial::new(DVec3::ZERO, [(c, [0; 3]); 2]).and_then(|sum| lamp(Emission::Polynomial(sum)));
    hold("sums that products hold", sum(1e290).is_ok() && sum(1e300).is_err());
    let degree = |power: u8| Polynomial::new(DVec3::ZERO, [(1.0, [power, 128, 0])]).is_ok();
    hold("degrees up to the highest", [degree(126), degree(127), degree(128)] == [true, true, false]);
    hold(
        "finite values",
        lamp(Emission::at_vertices(vec![1.0, f64::NAN, 1.0])).is_err() && lamp(Emission::Constant(f64::INFINITY)).is_err(),
    );
    // What single precision does not hold is refused, not infinite.
    let of_single = |value: f64| -> Result<bool, Error> {
        let mut answers = Answers::<f32>::new();
        let receivers = Receivers::new([&[0.1f32], &[0.1], &[0.5]], [&[0.0], &[0.0], &[1.0]], &[1.0])?;
        Engine::new().evaluate_to(&receivers, &lamp(Emission::Constant(value))?, 1.0, &mut answers)?;
        Ok(answers.radiosity[0].is_finite() && answers.radiosity[0] > 0.0 && answers.radiosity_error[0].is_finite())
    };
    hold("what single precision holds", [1e36, 1.0, 1e-30].iter().all(|value| of_single(*value) == Ok(true)));
    hold("what single precision does not hold", [1e40, 1e300].iter().all(|value| of_single(*value).is_err()));
    // The value is in range, its slope is not.
    let steep = |power: i32| -> Result<bool, Error> {
        let unit = libm::ldexp(1.0, power);
        let corners = [DVec3::Z, DVec3::Z + DVec3::Y, DVec3::Z + DVec3::X].map(|v| v * unit);
        let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1e20))?;
        #[allow(clippy::cast_possible_truncation, reason = "three bits are held by single precision")]
        let place = [0.125, 0.125, 0.5].map(|c: f64| [(c * unit) as f32]);
        let receivers = Receivers::new([&place[0][..], &place[1], &place[2]], [&[0.0f32], &[0.0], &[1.0]], &[1.0])?;
        let mut answers = Answers::<f32>::new();
        Engine::new().evaluate_to(&receivers, &lamp, 1.0, &mut answers)?;
        Ok(answers.gradient.iter().all(|component| component[0].is_finite()))
    };
    hold("slopes that single precision holds", [0, -40].iter().all(|power| steep(*power) == Ok(true)));
    hold("slopes that single precision does not hold", steep(-100).is_err());
    // A light of which there is no doubt that it is none.
    let receiver = Receiver::new(DVec3::ZERO, -DVec3::Z, 1.0);
    let dark = receiver.clone().and_then(|receiver| evaluate_to(&receiver, &lamp(Emission::Constant(1.0))?, &[], 0.0));
    hold(
        "nothing below the horizon",
        dark.is_ok_and(|a| a.radiosity == 0.0 && a.radiosity_error == 0.0 && a.gradient_error == 0.0),
    );
    let digits = receiver.and_then(|receiver| evaluate_digits(&receiver, &lamp(Emission::Constant(1.0))?, &[], 30));
    hold("no digits below the horizon", digits.is_ok_and(|a| a.radiosity == "0" && a.radiosity_error == "0"));
    hold("relative tolerances from none to all", tolerances([0.0, 1.0, -1e-9, 1.0 + 1e-9, f64::NAN]) == Ok([5, 5, 0, 0, 0]));
    let value = |absolute: f64| {
        let receiver = Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?;
        evaluate_value(&receiver, &lamp(Emission::Constant(1.0))?, [], Tolerance { relative: 0.0, absolute })
    };
    let are_answered = [0.0, 1e300, -1e-9, f64::INFINITY, f64::NAN].map(|absolute| value(absolute).is_ok());
    hold("absolute tolerances from none on", are_answered == [true, true, false, false, false]);
    for odd in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for index in 0..3 {
            let mut corners = vec![DVec3::Z, DVec3::Y, DVec3::X];
            corners[index].y = odd;
            let said = [Polygon::new(corners.clone()), Polygon::from_rounded(corners, 1e-3)];
            let is_named = |said: &Result<_, Error>| matches!(said, Err(Error::VertexNotFinite { index: i, .. }) if *i == index);
            hold("a corner that is no number", said.iter().all(is_named));
        }
    }
    let bow = [[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 3.0]].map(|[x, y]| DVec3::new(x, y, 1.0)).to_vec();
    let said =
        [Polygon::new(bow.clone()), Polygon::from_rounded(bow, 1e-3)].map(|said| said.err().map(|error| error.to_string()));
    let speaks_of_precision = said.map(|said| said.map(|said| said.contains("the precision")));
    hold("edges that meet, and how precisely they are known", speaks_of_precision == [Some(false), Some(true)]);
    hold("nothing from what is dark, wherever it is", darkness() == Ok((true, true)));
    hold("any probability of failure but none and one", certificates() == Some([true, true, true, false, false, false, false]));
    findings
}

/// By how many of the ways to ask each tolerance is accepted.
fn tolerances(asked: [f64; 5]) -> Result<[usize; 5], Error> {
    let receiver = Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?;
    let emitter = Emitter::new(Polygon::new(vec![DVec3::Z, DVec3::Z + DVec3::Y, DVec3::Z + DVec3::X])?, Emission::Constant(1.0))?;
    let none: [&Polygon; 0] = [];
    let ways = |relative: f64| {
        [
            evaluate_to(&receiver, &emitter, none, relative).is_ok(),
            evaluate_value(&receiver, &emitter, none, Tolerance { relative, absolute: 0.0 }).is_ok(),
            hessian_to(&receiver, &emitter, none, relative).is_ok(),
            irradiance_vector_to(&receiver, &emitter, none, relative).is_ok(),
            derivatives(&receiver, &emitter, none, relative).is_ok(),
        ]
    };
    Ok(asked.map(|relative| ways(relative).into_iter().filter(|accepted| *accepted).count()))
}

/// Whether a receiver on the surface of an emitter that is not flat gets nothing where the emitter is dark, and else no vector.
fn darkness() -> Result<(bool, bool), Error> {
    let corners = [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]].map(|[x, y]| DVec3::new(x, y, 1e-9 * x * y));
    let polygon = Polygon::from_rounded(corners.to_vec(), 1e-9)?;
    let receiver = Receiver::new(DVec3::new(0.5, 0.5, 0.25e-9), DVec3::X, 1.0)?;
    let none: [&Polygon; 0] = [];
    let [dark, lit] = [0.0, 1.0].map(|value| Emitter::new(polygon.clone(), Emission::Constant(value)));
    let (dark, lit) = (dark?, lit?);
    let is_nothing = hessian(&receiver, &dark)? == DMat3::ZERO
        && irradiance_vector(&receiver, &dark)? == DVec3::ZERO
        && hessian_to(&receiver, &dark, none, 1.0).is_ok_and(|answer| answer.matrix == DMat3::ZERO && answer.error == 0.0)
        && irradiance_vector_to(&receiver, &dark, none, 1.0)
            .is_ok_and(|answer| answer.vector == DVec3::ZERO && answer.error == 0.0)
        && evaluate_to(&receiver, &dark, none, 0.0).is_ok_and(|answer| answer.radiosity == 0.0 && answer.radiosity_error == 0.0);
    let is_refused = |error: Option<Error>| matches!(error, Some(Error::OnSurface { .. }));
    Ok((is_nothing, is_refused(hessian(&receiver, &lit).err()) && is_refused(irradiance_vector(&receiver, &lit).err())))
}

/// Whether a certificate of a dark scene is made that fails with some probabilities.
fn certificates() -> Option<[bool; 7]> {
    let wall = |z: f64| vec![DVec3::new(0.0, 0.0, z), DVec3::new(1.0, 0.0, z), DVec3::new(0.0, 1.0, z)];
    let scene = of_faces([0.0, 1.0].map(wall).into_iter()).ok()?;
    let of = |delta: f64| certify(&scene, &Request { delta, ..Request::default() }).is_ok();
    Some([1e-300, 1e-12, 1.0 - 1e-12, 0.0, 1.0, -0.5, f64::NAN].map(of))
}

/// A rule by its name: what is wrong with what is drawn.
type Rule = (&'static str, fn(&mut Sampler) -> Vec<String>);

const RULES: [Rule; 4] = [("flatness", flatness), ("short edges", short_edges), ("affinity", affinity), ("slopes", slopes)];

/// Violations of the rules.
#[must_use]
pub fn all_wrong() -> Vec<String> {
    let ask = |(name, rule): Rule| (0..100).flat_map(move |index| rule(&mut Sampler::new(20, name, index)));
    RULES.into_iter().flat_map(ask).chain(limits()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_bent_is_as_high_as_it_is_said_to_be() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
        let (moved, most) = bent(&square, 1, 1e-3);
        assert!((height(&moved, 1) - most).abs() < 1e-5 * 1e-3 && (most - 2e-3).abs() < 1e-8, "{most}");
        assert_eq!(all_wrong(), Vec::<String>::new());
    }
}
