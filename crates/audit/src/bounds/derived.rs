//! Stated bounds of closed forms in double precision, beside the bounds that their derivations give, computed a second time.
//!
//! Nothing comes near most terms of a derived bound, and a term of a hundredth that is wrong breaks none. But the derivation's bound of a
//! case is a number: here it is computed from the tables of symbols in core's documentation, one arc after the other, in plain numbers,
//! from a boundary that is found anew. Bounds that are stated must be this number, to the rounding of its sum.

mod edges;
mod lanes;
mod linear;

use glam::DVec3;
use radgrad_core::{Answer, Emission, Emitter, Error, Method, Polygon, Receiver, evaluate_to};
use rayon::prelude::*;

use crate::cases::sampler::Sampler;
use crate::checks::batches::{DOUBLE, SINGLE};

/// The unit roundoff.
const U: f64 = f64::EPSILON / 2.0;

/// Bounds are sums of some hundred rounded terms, of which a few cancel.
const SAME: f64 = 1e-9;

/// A linear emission's have X1 in them, here by quadrature.
const SAME_BY_QUADRATURE: f64 = 1e-6;

/// A visible piece of an edge, or of the horizon.
struct Piece {
    /// Its ends, and the unit normal of their plane.
    ends: [DVec3; 2],
    normal: DVec3,
    /// Its angle, at most pi.
    angle: f64,
    /// The edge; none of the horizon.
    edge: Option<Edge>,
    /// How far the ends are off that the horizon cuts, in units of roundoff of their distances.
    moved: [f64; 2],
}

/// The edge of a piece.
struct Edge {
    /// Its direction, and the distance of its line.
    along: DVec3,
    distance: f64,
    /// The relative error of its moment, in units of roundoff, where that is taken at the end that serves.
    of_moment: f64,
}

/// An emitter from a receiver.
struct Seen {
    /// The receiver's unit normal and the emitter's.
    n1: DVec3,
    n2: DVec3,
    height: f64,
    vertices: Vec<DVec3>,
    pieces: Vec<Piece>,
    /// The power of two that lengths are multiplied by.
    power: f64,
}

impl Seen {
    /// `None` where decisions are not clear, or where an edge passes nearer than the derivations in double precision go.
    fn new(receiver: &Receiver, polygon: &Polygon) -> Option<Self> {
        let farthest = polygon.vertices().iter().map(|v| (*v - receiver.position()).abs().max_element()).fold(0.0, f64::max);
        let power = libm::exp2(-libm::log2(farthest).floor());
        let (n1, n2) = (receiver.direction().normalize(), polygon.normal());
        let vertices: Vec<DVec3> = polygon.vertices().iter().map(|v| (*v - receiver.position()) * power).collect();
        let heights: Vec<f64> = vertices.iter().map(|r| n1.dot(*r)).collect();
        let height = -n2.dot(vertices[0]);
        if height < 1e-6 || heights.iter().any(|height| height.abs() < 1e-6) || heights.iter().all(|height| *height < 0.0) {
            return None;
        }
        let (mut pieces, mut crossings) = (Vec::new(), [Vec::new(), Vec::new()]);
        for (i, &a) in vertices.iter().enumerate() {
            let j = (i + 1) % vertices.len();
            let (b, e) = (vertices[j], vertices[j] - a);
            let (above, stays) = (heights[i] > 0.0, heights[j] > 0.0);
            if !above && !stays {
                continue;
            }
            let moment = a.cross(e).length();
            let at = if 4.0 * moment >= a.length() * e.length() || a.length() <= b.length() { a } else { b };
            let ratio = at.length() * e.length() / moment;
            if ratio >= 7.99 || (ratio - 4.0).abs() < 1e-9 {
                return None;
            }
            let (mut ends, mut moved) = ([a, b], [0.0; 2]);
            if above != stays {
                let share = heights[i] / (heights[i] - heights[j]);
                let (kept, part) = if above { (a, share) } else { (b, 1.0 - share) };
                let crossing = a + e * share;
                let which = usize::from(above);
                ends[which] = crossing;
                moved = [(kept.length() + 6.0 * part * e.length()) / crossing.length() + 1.0; 2];
                crossings[1 - which].push((crossing, moved[0]));
            }
            let normal = a.cross(e) / moment;
            let angle = libm::atan2(ends[0].cross(ends[1]).length(), ends[0].dot(ends[1]));
            let (along, distance) = (e.normalize(), moment / e.length());
            let edge = Edge { along, distance, of_moment: 3.5 * ratio + 1.0 };
            pieces.push(Piece { ends, normal, angle, edge: Some(edge), moved });
        }
        match crossings.each_ref().map(Vec::as_slice) {
            [[], []] => {}
            [[(exit, of_exit)], [(entry, of_entry)]] => {
                let angle = libm::atan2(-n1.dot(exit.cross(*entry)), exit.dot(*entry)).abs();
                let moved = [*of_exit, *of_entry];
                pieces.push(Piece { ends: [*exit, *entry], normal: -n1, angle, edge: None, moved });
            }
            _ => return None,
        }
        Some(Self { n1, n2, height, vertices, pieces, power })
    }

    fn is_cut(&self) -> bool {
        self.pieces.iter().any(|piece| piece.edge.is_none())
    }

    /// The irradiance vector of a unit emission over pi.
    fn phi(&self) -> DVec3 {
        self.pieces.iter().map(|piece| piece.normal * (-0.5 * piece.angle)).sum()
    }

    /// How many sums over arcs round: a polygon of up to four edges that is cut counts all of them.
    fn additions(&self) -> f64 {
        let count = self.vertices.len();
        (if self.is_cut() && count <= 4 { count } else { self.pieces.len() - 1 }) as f64
    }
}

/// Whether an arc is up to a quarter turn.
fn is_narrow(ends: &[DVec3; 2]) -> bool {
    ends[0].dot(ends[1]) >= 0.0
}

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

/// A convex polygon of few bits in the plane z = 0 that faces down, and a receiver below it.
fn drawn(s: &mut Sampler, most: u32) -> Result<(Polygon, Receiver), Error> {
    let few = |x: f64| (1024.0 * x).round() / 1024.0;
    let count = 3 + s.below(most - 2);
    let size = [1.0, 1.0, 0.25, 1024.0][s.below(4) as usize];
    let first = s.between(0.0, 1.0);
    let corner = |k: u32| {
        let turn = std::f64::consts::TAU * (first - (f64::from(k) + s.between(-0.2, 0.2)) / f64::from(count));
        DVec3::new(few(libm::cos(turn)), few(libm::sin(turn)), 0.0) * size
    };
    let vertices = (0..count).map(corner).collect();
    let depth = [0.15, 0.5, 1.0, 1.8][s.below(4) as usize];
    let place = s.cube() * DVec3::new(0.8, 0.8, 0.1) - DVec3::Z * depth;
    let lean = if s.one_in(2) { 0.1 } else { 1.5 };
    let receiver = Receiver::new(place.map(few) * size, DVec3::Z + s.cube() * lean, [1.0, 0.5, 0.3][s.below(3) as usize])?;
    Ok((Polygon::new(vertices)?, receiver))
}

/// The finding about stated bounds that are not those derived.
fn apart(what: &str, same: f64, stated: [f64; 2], derived: [f64; 2]) -> Option<String> {
    let is_same = |(stated, derived): (f64, f64)| (stated / derived - 1.0).abs() <= same;
    let is_off = !stated.into_iter().zip(derived).all(is_same);
    is_off.then(|| format!("{what}: the bounds {stated:?} are not {derived:?}"))
}

/// A case: how many bounds were compared, and the findings.
type Told = Result<(usize, Vec<String>), Error>;

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
