//! The bound on the exchange of two edges: the tables of `exchange::edges`, `exchange::planar` and `exchange::skew`.

use std::f64::consts::PI;

use glam::DVec3;
use radgrad_scene::{gauss_legendre, probes};

use super::boundary::{self, U};
use crate::cases::sampler::Sampler;

/// Halvings of an edge, and the first of them before which singular places are asked for.
const MOST_HALVINGS: u32 = 50;
const FIRST_OF_PLACES: u32 = 3;

/// A decision that is nearer than this may be taken otherwise.
const CLOSE: f64 = 1e-6;

/// Two edges with the lengths of both.
struct Edges {
    a: [DVec3; 2],
    b: [DVec3; 2],
    lengths: [f64; 2],
}

/// Least distance of a point from a segment.
fn from_segment(p: DVec3, [from, to]: [DVec3; 2]) -> f64 {
    let along = to - from;
    (from + along * ((p - from).dot(along) / along.length_squared()).clamp(0.0, 1.0) - p).length()
}

/// Least distance of two segments that are not parallel.
fn apart([a, b]: [DVec3; 2], [c, d]: [DVec3; 2]) -> f64 {
    let (u, v) = (b - a, d - c);
    let normal = u.cross(v);
    // Places of the common perpendicular along both.
    let place = |across: DVec3| (c - a).cross(across).dot(normal) / normal.length_squared();
    let (s, t) = (place(v), place(u));
    let of_ends = [from_segment(a, [c, d]), from_segment(b, [c, d]), from_segment(c, [a, b]), from_segment(d, [a, b])];
    let between = (c - a).dot(normal).abs() / normal.length();
    let is_inside = (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t);
    if is_inside { between } else { of_ends.into_iter().fold(f64::INFINITY, f64::min) }
}

impl Edges {
    /// The mean of `|ln r|` is at most this.
    fn most(&self) -> f64 {
        4.0 + libm::log(2.0 / self.lengths[1]).abs()
    }

    /// The fewest nodes with which a rule errs by no more than is allowed, and how much; `None` if a decision is close.
    fn rule(ellipse: Option<[f64; 2]>, allowed: f64) -> Option<Option<(usize, f64)>> {
        let Some([radius, largest]) = ellipse else { return Some(None) };
        for nodes in [2, 3, 4, 6, 8, 12, 16] {
            let squared = radius * radius;
            let bound = 1.01 * 64.0 / 15.0 * largest * squared.powi(-nodes) / (1.0 - 1.0 / squared);
            if (bound / allowed - 1.0).abs() < CLOSE {
                return None;
            }
            if bound < allowed {
                return Some(Some((usize::try_from(nodes).unwrap_or(0), bound)));
            }
        }
        Some(None)
    }

    /// By the distance of a cell.
    fn by_distance(&self, cell: [DVec3; 2], half: f64) -> Option<[f64; 2]> {
        let distance = apart(cell, self.b) * (1.0 - 1e-9) - 8.0 * U;
        let radius = 1.0 + 0.75 * distance / half;
        let [real, imaginary] = [0.5 * (radius + 1.0 / radius), 0.5 * (radius - 1.0 / radius)];
        let least = (distance - (real - 1.0) * half).powi(2) - (imaginary * half).powi(2);
        let farthest = 4.0 + 2.0 * real * half;
        let largest = 0.5 * (libm::log(least).abs().max(2.0 * libm::log(farthest)) + PI);
        (distance > 0.0 && least > 0.0).then_some([radius, largest])
    }

    /// By singular places.
    fn by_places(&self, cell: [DVec3; 2], half: f64) -> Option<[f64; 2]> {
        let ([a, b], [m, n]) = ([&self.a, &self.b].map(|[from, to]| *to - *from), self.lengths);
        let sine = a.cross(b).length() / (m * n) + 8.0 * U;
        let of_line = cell.map(|x| (x - self.b[0]).cross(b).length() / n / sine);
        let of_ends = self.b.map(|y| from_segment(y, cell));
        // The distance of a point that has these from the ends of the cell.
        let foot = 0.5 * ((of_line[0].powi(2) - of_line[1].powi(2)) / (2.0 * half) + 2.0 * half);
        let beside = if foot <= 0.0 || foot >= 2.0 * half {
            of_line[0].min(of_line[1])
        } else {
            (of_line[0].powi(2) - foot * foot).max(0.0).sqrt()
        };
        let away = 0.6 * beside.min(of_ends[0]).min(of_ends[1]) / half;
        let farthest = cell.iter().flat_map(|x| self.b.map(|y| (*x - y).length())).fold(0.0, f64::max);
        (away > 0.0).then_some([away + (away * away + 1.0).sqrt(), 20.0 * farthest / n])
    }

    /// The error on a cell of the first edge, as a share of the mean; `None` if a decision is close.
    fn of_cell(&self, [from, to]: [f64; 2], halvings: u32, truncation: f64) -> Option<f64> {
        let (along, n) = (self.a[1] - self.a[0], self.lengths[1]);
        let cell = [from, to].map(|s| self.a[0] + along * s);
        let half = 0.5 * (to - from) * self.lengths[0];
        let allowed = truncation.max(1e-15 / n.min(1.0));
        let mut rule = Self::rule(self.by_distance(cell, half), allowed)?;
        if rule.is_none() && halvings >= FIRST_OF_PLACES {
            rule = Self::rule(self.by_places(cell, half), allowed)?;
        }
        let Some((nodes, truncated)) = rule else {
            let bound = 2.0 * (to - from) * self.most();
            let middle = 0.5 * (from + to);
            if halvings == MOST_HALVINGS || bound <= truncation.max(1e-15) {
                return Some(bound);
            }
            let parts = [[from, middle], [middle, to]].map(|part| self.of_cell(part, halvings + 1, truncation));
            return Some(parts[0]? + parts[1]?);
        };
        let size = |&(node, weight): &(f64, f64)| {
            let x = self.a[0] + along * (0.5 * (from + to) + 0.5 * (to - from) * node);
            let logarithms: f64 = self.b.iter().map(|y| libm::log((*y - x).length()).abs()).sum();
            weight * (logarithms + PI) * (1.0 + 4.0 / n)
        };
        let rounding: f64 = gauss_legendre(nodes).iter().map(size).sum();
        Some(0.5 * (to - from) * (truncated + 32.0 * U * rounding))
    }

    /// The error of the mean by a rule.
    fn skew(&self, mean: f64, truncation: f64) -> Option<f64> {
        let [a, b] = [&self.a, &self.b].map(|[from, to]| *to - *from);
        let [m, n] = self.lengths;
        let enough = (16.0 * truncation).max(32.0 * U * self.most() * (1.0 + 4.0 / n));
        let between = self.a[0] - self.b[0];
        let height = a.cross(b).dot(between).abs() / (6.0 * (m * n).max(m.max(n) * between.length()));
        let error = self.of_cell([0.0, 1.0], 0, truncation)? + 32.0 * U * (mean.abs() + self.most());
        (height > 1.01 * enough && height * height > 65.0 * enough && error < enough * (1.0 - CLOSE)).then_some(error)
    }

    /// The error of the mean in the plane z = 0, where the lines do not meet near the edges.
    fn planar(&self, mean: f64, truncation: f64) -> Option<f64> {
        let [m, n] = self.lengths;
        let [a, b] = [&self.a, &self.b].map(|[from, to]| *to - *from);
        let enough = (16.0 * truncation).max(32.0 * U * self.most() * (1.0 + 4.0 / n));
        let corners: Vec<DVec3> = self.a.iter().flat_map(|x| self.b.map(|y| *x - y)).collect();
        let height = 8.0 * U * corners.iter().map(|z| z.length()).fold(0.0, f64::max);
        let middle = corners.iter().sum::<DVec3>();
        let of_corner = |z: &DVec3| {
            let argument = libm::atan2(middle.cross(*z).z, middle.dot(*z));
            24.0 * U * z.length() * (z.length() + height) * ((libm::log(z.length()) - 1.5).abs() + argument.abs() + 3.0)
        };
        let rounding: f64 = corners.iter().map(of_corner).sum();
        let turn = a.cross(b).z;
        let places = [b, a].map(|along| (self.b[0] - self.a[0]).cross(along).z / turn);
        let is_apart = places.iter().any(|place| !(-0.01..=1.01).contains(place));
        let error = (rounding + 8.0 * U * (mean.abs() * m * n + m * n)) / (m * n) + 0.5 * PI * height / m.max(n);
        (is_apart && error < enough * (1.0 - CLOSE)).then_some(error)
    }

    /// The error of the mean where both have one direction exactly.
    fn parallel(&self) -> f64 {
        let [m, n] = self.lengths;
        let is_second_longer = n > m;
        let (first, second) = if is_second_longer { (&self.b, &self.a) } else { (&self.a, &self.b) };
        let direction = (first[1] - first[0]).normalize();
        let h = (second[0] - first[0]).cross(direction).length();
        let places = second.map(|y| (y - first[0]).dot(direction));
        let ([z, end], longer) = ([places[0].min(places[1]), places[0].max(places[1])], m.max(n));
        let size = |z: f64| {
            let turn = if h == 0.0 { 0.0 } else { h * z * libm::atan(z / h) };
            let square = z * z + h * h;
            if square == 0.0 { 0.0 } else { (0.25 * (z * z - h * h) * libm::log(square) - 0.75 * z * z + turn).abs() }
        };
        let sizes = size(end) + size(z - longer) + size(end - longer) + size(z);
        let reach = z.abs() + m + n + h;
        16.0 * U * (sizes + 2.0 * reach * reach) / (m * n)
    }
}

/// How many bounds of a drawn pair were compared, and those that are not derived.
pub(super) fn of_pair(index: u64) -> (usize, Vec<String>) {
    let s = &mut Sampler::new(65, "derived", index);
    let kind = index % 4;
    let size = [1.0, 0.3, 0.05][s.below(3) as usize];
    let few = |v: DVec3| (v * 32.0).round() / 32.0;
    let flat = DVec3::new(1.0, 1.0, if kind == 1 { 0.0 } else { 1.0 });
    let (start, other) = (s.cube() * flat, s.cube() * flat);
    let (mut along, mut beside) = (s.cube() * flat * size, s.cube() * flat);
    let mut starts = [start, other];
    if kind == 2 {
        // Of few bits: differences are exact.
        starts = starts.map(few);
        along = DVec3::new(f64::from(1 + s.below(5)), f64::from(s.below(5)), -f64::from(s.below(5))) / 32.0;
        beside = along * [1.0, -2.0, 3.0, -1.0][s.below(4) as usize];
    } else if kind == 3 {
        along = DVec3::new(f64::from(1 + s.below(5)), f64::from(s.below(5)), 0.0) / 32.0;
        starts = starts.map(few);
        beside = DVec3::new(-along.y, along.x, f64::from(s.below(3)) / 32.0);
    }
    let edges = Edges {
        a: [starts[0], starts[0] + along],
        b: [starts[1], starts[1] + beside],
        lengths: [along.length(), beside.length()],
    };
    let product = edges.lengths[0] * edges.lengths[1];
    let (mut compared, mut told) = (0, Vec::new());
    for truncation in [1e-16, 1e-12, 1e-9, 1e-7] {
        let [weighted, stated] = probes::mean_logarithm(edges.a, edges.b, truncation);
        let weight = along.dot(beside);
        let mean = weighted / weight;
        let derived = match kind {
            0 => edges.skew(mean, truncation),
            1 => edges.planar(mean, truncation),
            2 => Some(edges.parallel()),
            _ => None,
        };
        let derived = match derived {
            Some(error) => weight.abs() * error + 4.0 * U * weighted.abs() * product / weight.abs(),
            None if kind == 3 => 8.0 * U * product * edges.most(),
            None => continue,
        };
        compared += 1;
        told.extend(boundary::apart(&format!("derived:{index}, edges to {truncation:e}"), CLOSE, [stated; 2], [derived; 2]));
    }
    (compared, told)
}
