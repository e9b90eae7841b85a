//! The exchange of two polygons with nothing in between, and of two edges, which it sums, held against truth and against itself.
//!
//! Pairs of edges have 36 digits in `data/reference/edges.txt`. Of polygons it is known that a tetrahedron's faces see nothing but each other, that parts
//! exchange what the whole does, that both ways are one number, and what points of one see of the other in closed form.

use glam::DVec3;
use radgrad_core::{Emission, Emitter, Polygon, Receiver, Tolerance, evaluate_value};
use radgrad_scene::{gauss_legendre, probes};

use crate::cases::sampler::Sampler;
use crate::measures::measure::is_worse;

/// Allowed truncations, from all digits to few.
const TRUNCATIONS: [f64; 4] = [4e-14, 1e-11, 1e-8, 1e-5];

/// The error over the smaller area up to which the sum over edges serves alone, and the one to which points are asked.
const BY_EDGES: f64 = f64::INFINITY;
const USUAL: f64 = 1e-9;
const BY_POINTS: f64 = 1e-13;

/// Axes and signs of some symmetries of the cube.
const SYMMETRIES: [([usize; 3], [f64; 3]); 4] =
    [([0, 1, 2], [1.0; 3]), ([1, 2, 0], [1.0; 3]), ([2, 0, 1], [-1.0, 1.0, 1.0]), ([1, 0, 2], [1.0, -1.0, -1.0])];

/// A point where a symmetry of the cube takes it: exactly.
pub(crate) fn moved(point: DVec3, (axes, signs): ([usize; 3], [f64; 3])) -> DVec3 {
    DVec3::from([0, 1, 2].map(|k| signs[k] * point[axes[k]]))
}

/// Violations by a pair of edges with known digits: a line of the file, which has a kind, the corners, and the integral as a sum of two doubles.
#[must_use]
pub fn of_edges(line: &str) -> Vec<String> {
    let numbers: Vec<f64> = line.split(' ').filter_map(|number| number.parse().ok()).collect();
    let [_, corners @ .., high, low] = &numbers[..] else { return vec![format!("no pair of edges: {line}")] };
    let p: Vec<DVec3> = corners.chunks_exact(3).map(DVec3::from_slice).collect();
    let &[a, b, c, d] = &p[..] else { return vec![format!("no two edges: {line}")] };
    let mut findings = Vec::new();
    for (sign, first, second) in [(1.0, [a, b], [c, d]), (-1.0, [c, d], [b, a]), (1.0, [d, c], [b, a]), (-1.0, [b, a], [c, d])] {
        for symmetry in SYMMETRIES {
            for truncation in [1e-16, 1e-12, 1e-9, 1e-6, 1e-3] {
                let [first, second] = [first, second].map(|edge| edge.map(|end| moved(end, symmetry)));
                let [found, error] = probes::mean_logarithm(first, second, truncation);
                let off = ((sign * found - high) - low).abs();
                if is_worse(off, error) {
                    findings.push(format!("edges to {truncation:e} are off by {off:e}, known to {error:e}: {line}"));
                }
            }
        }
    }
    findings
}

/// Violations by perpendicular edges so short that the product of their lengths is the least double: they exchange exactly 0.
#[must_use]
pub fn of_shortest_edges() -> Vec<String> {
    let length = 2.5e-162;
    let start = DVec3::new(1.0, 0.0, 0.5);
    let [first, second] = [[DVec3::ZERO, DVec3::X * length], [start, start + DVec3::Y * length]];
    let mut findings = Vec::new();
    for [a, b] in [[first, second], [second, first]] {
        for truncation in [1e-16, 1e-6] {
            let [exchange, error] = probes::mean_logarithm(a, b, truncation);
            if exchange != 0.0 || !(0.0..=1e-300).contains(&error) {
                findings.push(format!("perpendicular edges of {length:e} exchange {exchange:e}, known to {error:e}"));
            }
        }
    }
    findings
}

/// The pairs of edges with known digits.
pub fn edges() -> impl Iterator<Item = &'static str> {
    include_str!("../../../../data/reference/edges.txt").lines()
}

/// Two polygons in front of each other.
struct Pair {
    from: Polygon,
    to: Polygon,
    /// The distance between their middles over their size.
    distance: f64,
}

impl Pair {
    fn drawn(s: &mut Sampler) -> Option<Self> {
        let distance = [0.3, 1.0, 3.0, 8.0, 60.0, 4000.0][s.below(6) as usize] * s.between(1.0, 1.5);
        let slender = [1.0, 1.0, 1e-2, 1e-5][s.below(4) as usize];
        let mut polygon = |z: f64, slender: f64| {
            let tilt = [s.between(-0.15, 0.15), s.between(-0.15, 0.15)];
            let aside = DVec3::new(s.between(-0.3, 0.3), s.between(-0.3, 0.3), 0.0);
            let wide = s.between(0.7, 1.3);
            let flat = match s.below(3) {
                0 => vec![[0.0, 0.0], [1.0, 0.1], [0.3, 0.9]],
                1 => vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
                _ => vec![[0.0, 0.0], [1.0, 0.0], [1.2, 0.6], [0.5, 1.1], [-0.1, 0.5]],
            };
            let corner = |[x, y]: [f64; 2]| {
                let (x, y) = (wide * (x - 0.5), slender * (y - 0.5));
                aside + DVec3::new(x, y, z + tilt[0] * x + tilt[1] * y)
            };
            flat.into_iter().map(corner).collect::<Vec<_>>()
        };
        let (low, mut high) = (polygon(0.0, 1.0), polygon(distance, slender));
        high.reverse();
        Some(Self { from: Polygon::new(low).ok()?, to: Polygon::new(high).ok()?, distance })
    }

    /// Cut along a diagonal.
    fn parts(&self) -> Option<[Polygon; 2]> {
        let v = self.to.vertices();
        let half = |corners: Vec<DVec3>| Polygon::new(corners).ok();
        match v.len() {
            3 => None,
            _ => Some([half(v[..3].to_vec())?, half([&v[2..], &v[..1]].concat())?]),
        }
    }
}

/// The exchange of two polygons by form factors at points of one, by a Gauss rule on triangles: sharp where the two are far enough apart for their size.
fn by_points(from: &Polygon, to: &Polygon) -> Option<f64> {
    let emitter = Emitter::new(to.clone(), Emission::Constant(1.0)).ok()?;
    let corners = from.vertices();
    let rule = gauss_legendre(10);
    let mut sum = 0.0;
    for k in 2..corners.len() {
        let [a, b, c] = [corners[0], corners[k - 1], corners[k]];
        let twice = (b - a).cross(c - a).length();
        for &(v, weight_v) in rule {
            for &(u, weight_u) in rule {
                let (u, v) = (0.5 + 0.5 * u, 0.5 + 0.5 * v);
                let along = a + (b - a) * u;
                let receiver = Receiver::new(along + (c - along) * v, from.normal(), 1.0).ok()?;
                let tolerance = Tolerance { relative: 1e-14, absolute: 0.0 };
                let seen = evaluate_value(&receiver, &emitter, [], tolerance).ok()?.radiosity;
                sum += 0.25 * weight_u * weight_v * (1.0 - v) * twice * seen;
            }
        }
    }
    Some(sum)
}

/// Violations by a drawn pair: its parts, both ways, in another unit, turned, and what points see.
#[must_use]
pub fn of_pair(index: u64) -> Vec<String> {
    let Some(pair) = Pair::drawn(&mut Sampler::new(17, "exchanges", index)) else { return Vec::new() };
    let Pair { from, to, distance } = &pair;
    let mut findings = Vec::new();
    let first = probes::exchange(from, to, TRUNCATIONS[0], USUAL);
    let mut agree = |what: &str, [area, error]: [f64; 2], slack: f64| {
        let apart = (area - first[0]).abs();
        if is_worse(apart, error + first[1] + slack) {
            findings.push(format!("exchange {index} {what}: {area:e} to {error:e}, it is {:e} to {:e}", first[0], first[1]));
        }
    };
    for resolved in [BY_EDGES, BY_POINTS] {
        for truncation in TRUNCATIONS {
            agree(&format!("to {truncation:e}, {resolved:e}"), probes::exchange(from, to, truncation, resolved), 0.0);
        }
        agree("the other way", probes::exchange(to, from, TRUNCATIONS[0], resolved), 0.0);
        if let Some(parts) = pair.parts() {
            let of_parts = parts.map(|part| probes::exchange(from, &part, TRUNCATIONS[0], resolved));
            let [area, error] = [0, 1].map(|k| of_parts[0][k] + of_parts[1][k]);
            agree("by parts", [area, error], 4.0 * f64::EPSILON * area);
        }
    }
    for symmetry in &SYMMETRIES[1..] {
        let is_mirrored = {
            let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| moved(axis, *symmetry));
            x.cross(y).dot(z) < 0.0
        };
        let scaled = |polygon: &Polygon| {
            let mut corners: Vec<DVec3> = polygon.vertices().iter().map(|&corner| moved(corner, *symmetry)).collect();
            if is_mirrored {
                corners[1..].reverse();
            }
            Polygon::new(corners)
        };
        if let (Ok(from), Ok(to)) = (scaled(from), scaled(to)) {
            agree("by other axes", probes::exchange(&from, &to, TRUNCATIONS[0], USUAL), 0.0);
        }
    }
    if *distance > 0.5
        && let Some(seen) = by_points(from, to)
    {
        let rough = if *distance > 2.0 { 1e-14 } else { 1e-8 };
        agree("by points", [seen, 0.0], rough * seen);
    }
    for power in [2.0_f64.powi(-40), 2.0_f64.powi(33)] {
        let scaled = |polygon: &Polygon| Polygon::new(polygon.vertices().iter().map(|&corner| corner * power).collect());
        if let (Ok(from), Ok(to)) = (scaled(from), scaled(to)) {
            let found = probes::exchange(&from, &to, TRUNCATIONS[0], USUAL).map(|figure| figure / power / power);
            if found != first {
                findings.push(format!("exchange {index} times {power:e}: {found:?} instead of {first:?}"));
            }
        }
    }
    findings
}

/// Violations by the faces of a drawn tetrahedron, which see nothing but each other.
#[must_use]
pub fn of_tetrahedron(index: u64) -> Vec<String> {
    let s = &mut Sampler::new(17, "tetrahedra", index);
    let flat = [1.0, 1.0, 0.1, 1e-3, 1e-6][s.below(5) as usize];
    let mut corner = |scale: f64| s.cube() * DVec3::new(1.0, 1.0, scale);
    let [a, b, c, d] = [corner(flat), corner(flat), corner(flat), corner(1.0)];
    // Counter-clockwise seen from inside.
    let [b, c] = if (b - a).cross(c - a).dot(d - a) > 0.0 { [b, c] } else { [c, b] };
    let faces = [[a, b, c], [a, d, b], [b, d, c], [c, d, a]].map(|face| Polygon::new(face.to_vec()));
    let [Ok(a), Ok(b), Ok(c), Ok(d)] = faces else { return Vec::new() };
    let faces = [a, b, c, d];
    let mut findings = Vec::new();
    for resolved in [BY_EDGES, USUAL] {
        for (k, face) in faces.iter().enumerate() {
            let others = faces.iter().enumerate().filter(|(other, _)| *other != k);
            let seen = others.map(|(_, other)| probes::exchange(face, other, TRUNCATIONS[0], resolved));
            let [sum, error] = seen.fold([0.0; 2], |sum, of| [sum[0] + of[0], sum[1] + of[1]]);
            let (area, slack) = (face.area(), 4.0 * f64::EPSILON * face.area());
            if is_worse((sum - area).abs(), error + slack) {
                findings.push(format!("tetrahedron {index}: face {k} of {area:e} exchanges {sum:e} to {error:e}"));
            }
        }
    }
    findings
}

/// Values and bounds of some pairs of edges with known digits, for the record.
pub(crate) fn recorded_edges(index: u64) -> Vec<(f64, f64)> {
    let of_line = |line: &str| {
        let numbers: Vec<f64> = line.split(' ').filter_map(|number| number.parse().ok()).collect();
        let p: Vec<DVec3> = numbers.get(1..13).unwrap_or_default().chunks_exact(3).map(DVec3::from_slice).collect();
        let [a, b, c, d] = p[..] else { return Vec::new() };
        [1e-16, 1e-8].map(|truncation| probes::mean_logarithm([a, b], [c, d], truncation).into()).to_vec()
    };
    edges().skip(usize::try_from(index).unwrap_or(usize::MAX)).step_by(16).flat_map(of_line).collect()
}

/// Values and bounds of a drawn pair, with every truncation, by edges and by points, for the record.
///
/// # Errors
/// If there is no such pair.
pub(crate) fn recorded(index: u64) -> Result<Vec<(f64, f64)>, String> {
    let s = &mut Sampler::new(18, "exchanges", index);
    let pair = Pair::drawn(s).ok_or("no polygons")?;
    let exchange = |resolved: f64, truncation: f64| probes::exchange(&pair.from, &pair.to, truncation, resolved).into();
    Ok([BY_EDGES, BY_POINTS]
        .into_iter()
        .flat_map(|resolved| TRUNCATIONS.map(|truncation| exchange(resolved, truncation)))
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exchanges_are_what_is_known_of_them_and_others_are_not() {
        let findings =
            edges().flat_map(of_edges).chain((0..24).flat_map(|index| [of_pair(index), of_tetrahedron(index)]).flatten());
        assert_eq!(findings.collect::<Vec<_>>(), Vec::<String>::new());
        let first = edges().next().unwrap();
        let (start, low) = first.rsplit_once(' ').unwrap();
        let (start, _) = start.rsplit_once(' ').unwrap();
        assert!(of_edges(&format!("{start} 0.1182 {low}")).len() > 40);
    }
}
