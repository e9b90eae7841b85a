//! Stated bounds of closed forms in double precision, beside the bounds that their derivations give, computed a second time.
//!
//! Nothing comes near most terms of a derived bound, and a term of a hundredth that is wrong breaks none. But the derivation's bound of a
//! case is a number: here it is computed from the tables of symbols in core's documentation, one arc after the other, in plain numbers,
//! from a boundary that is found anew. Bounds that are stated must be this number, to the rounding of its sum.

mod boundary;
mod edges;
mod lanes;
mod linear;

use glam::DVec3;
use radgrad_core::{Answer, Emission, Emitter, Method, evaluate_to};
use rayon::prelude::*;

use crate::cases::sampler::Sampler;
use crate::checks::batches::{DOUBLE, SINGLE};
use boundary::{Edge, Piece, SAME, Seen, Told, U, apart, drawn, is_narrow};

/// A linear emission's have X1 in them, here by quadrature.
const SAME_BY_QUADRATURE: f64 = 1e-6;

/// The bounds on value and gradient of a unit emission, of the same over pi: `constant_bound`, given the gradient's size.
fn of_constant(seen: &Seen, gradient: f64) -> [f64; 2] {
    let additions = seen.additions();
    let (mut of_angles, mut along, mut across) = (0.0, DVec3::ZERO, 0.0);
    for Piece { ends, normal, angle: g, edge, .. } in &seen.pieces {
        let [q1, q2] = ends.map(|end| 1.0 / end.length());
        let Some(Edge { distance, of_moment: ew, .. }) = edge else {
            let [eta1, eta2] = [q1, q2].map(|q| 3.0 + 10.4 * q);
            let [xi1, xi2] = [q1, q2].map(|q| U * (4.1 + 13.9 * q));
            of_angles +=
                U * (eta1 + eta2 + 3.5 + 9.0 * g.min(1.0) + 4.0 * g + 5.5 * g + additions * g) + xi1.powi(3) + xi2.powi(3);
            across += 0.5 * (xi1 * xi1 * q1 + xi2 * xi2 * q2);
            continue;
        };
        // Of uncut polygons neither the fraction nor a displacement counts.
        let (eta, fraction) = if seen.is_cut() { (3.0 + 10.4 * q1.max(q2), 1.0) } else { (0.0, 0.0) };
        let dg = g.min(1.0) * (ew + 8.0 + fraction + 2.0 * eta) + 4.0 * g;
        let dsin = g * (ew + 14.0 + fraction + 2.0 * eta);
        let facing = seen.n1.dot(*normal).abs();
        of_angles += U * (facing * (dg + 3.5 * g) + g * ew + 2.0 * g + additions * g);
        let (size, error) = if is_narrow(ends) {
            let s: f64 = ends.iter().map(|end| seen.n1.dot(*end).abs() / end.length()).sum();
            let quarter = 0.25 / (1.0 + libm::cos(*g));
            let sum = g + libm::sin(*g);
            let dc = 10.0 + 6.5 * s + 4.0 * eta;
            let first = quarter * (s * (dg + dsin) + sum * (s * (19.0 + 5.0 * eta) + dc));
            let second = g * (0.11 * dg + 0.9 * g + 0.091 * (eta * g + dc));
            let size = (q1 + q2) * (quarter * sum * s + 0.091 * g * g.min(s));
            (size, (q1 + q2) * (first + second) + 6.5 * size)
        } else {
            let en = ew + 5.0;
            let db = 0.71 * (2.0 * en + 54.0 + 2.0 * eta);
            let column = 0.5 * dg + dsin + 2.0 * g * db + 28.0 * g;
            (g / distance, (column + g * (2.0 * en + 32.0)) / distance)
        };
        along += normal.abs() * (U * error);
        across += U * size * (ew + additions);
    }
    let products = 8.0 * U;
    [1.001 * (0.5 * of_angles + products * seen.phi().length()), 1.001 * (along.length() + across + products * gradient)]
}

fn one_by_one(index: u64) -> Told {
    let s = &mut Sampler::new(61, "derived", index);
    let (polygon, receiver) = drawn(s, 7)?;
    let value = s.sign() * s.between(0.5, 2.0);
    let slope = s.cube() * DVec3::new(1.0, 1.0, 0.0) * (s.spread(-8, 4) / polygon.size());
    let Some(seen) = Seen::new(&receiver, &polygon) else { return Ok((0, Vec::new())) };
    let share = receiver.reflectance() / std::f64::consts::PI;
    let mut told = Vec::new();
    let mut compared = 0;
    let mut compare = |what: &str, answer: &Answer, same: f64, derived: [f64; 2]| {
        compared += 1;
        let stated = [answer.radiosity_error, answer.gradient_error];
        told.extend(apart(&format!("derived:{index}, {what}"), same, stated, derived));
    };
    let answer = evaluate_to(&receiver, &Emitter::new(polygon.clone(), Emission::Constant(value))?, &[], 1.0)?;
    if answer.method == Method::ClosedForm {
        let share = share * value.abs();
        let [radiosity, gradient] = of_constant(&seen, answer.gradient.length() / (share * seen.power));
        compare("constant", &answer, SAME, [share * radiosity, share * seen.power * gradient]);
    }
    let answer = evaluate_to(&receiver, &Emitter::new(polygon.clone(), Emission::gradient(value, slope))?, &[], 1.0)?;
    if answer.method == Method::ClosedForm
        && let Some([radiosity, gradient]) =
            linear::bounds(&seen, [value, answer.gradient.length() / (share * seen.power)], slope / seen.power)
    {
        compare("linear", &answer, SAME_BY_QUADRATURE, [share * radiosity, share * seen.power * gradient]);
    }
    Ok((compared, told))
}

/// Bounds of so many cases that are not those derived.
#[must_use]
pub fn all_wrong(count: u64) -> Vec<String> {
    let ask = |index: u64| {
        let of_double = lanes::of_precision::<f64>(index, &DOUBLE);
        let answers = [one_by_one(index), of_double, lanes::of_precision::<f32>(index, &SINGLE), Ok(edges::of_pair(index))];
        answers.map(|told| told.unwrap_or_else(|error| (0, vec![format!("derived:{index}: {error}")])))
    };
    let told: Vec<_> = (0..count).into_par_iter().map(ask).collect();
    let compared: [usize; 4] = [0, 1, 2, 3].map(|way| told.iter().map(|told| told[way].0).sum());
    let mut findings: Vec<String> = told.into_iter().flatten().flat_map(|(_, findings)| findings).collect();
    if compared.iter().any(|&compared| 2 * compared < usize::try_from(count).unwrap_or(usize::MAX)) {
        findings.push(format!("of {count} cases only {compared:?} bounds have a derivation to compare with"));
    }
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_those_derived_and_another_is_another() {
        assert_eq!(all_wrong(400), Vec::<String>::new());
        assert!(
            apart("", SAME, [1.0, 1.0], [1.0, 1.0 + 1e-6]).is_some() && apart("", SAME, [f64::NAN, 1.0], [1.0, 1.0]).is_some()
        );
    }
}
