//! Faces cut where that makes polynomials fit best, along shadow lines above all.
//!
//! The light on a part is known at samples; each part gets its own before cuts of it are judged. The residual of polynomials on
//! it is the part's area times the mean square residual of the least squares fit. One part after another is cut, always the one
//! whose best cut takes most of that away for each element that it adds. Cuts are along the shadow lines that cross a part
//! ([`crate::mesh::shadow`]), in two through the middle, and in four as refinement does. So a line cuts elements as far as it
//! counts for the light there, elements across which light changes little in one direction stay long in that, and of the hundreds
//! of lines of a scene none is taken that gains less than another cut does.

use radgrad_core::DVec3;
use radgrad_scene::{is_parallelogram, largest};
use rayon::prelude::*;

use crate::error::Error;
use crate::mesh::basis::Basis;
use crate::mesh::contact::{halves, inside};
use crate::mesh::rule::STEPS;
use crate::mesh::shape::{Shape, in_parent};

/// Fraction of a part's size within which corners are on a line.
const LEVEL: f64 = 1e-9;

/// A cut leaves no piece with less than this fraction of the part's area.
const LEAST_PIECE: f64 = 0.01;

/// The fraction of a line across a part that has to be shadow line.
const LEAST_ALONG: f64 = 0.25;

/// Samples in a part for each function of the basis, below which nothing is said of it.
const FEWEST: usize = 3;

/// The least samples over all faces together and in a part when cuts are judged.
const SAMPLES: f64 = 30_000.0;
const ENOUGH: f64 = 360.0;

/// Shares of a side at which a part is cut in two.
const SHARES: [f64; 3] = [0.5, 1.0 / 3.0, 2.0 / 3.0];

/// Longest side over the height on it beyond which no cut makes a part.
const LONGEST: f64 = 50.0;

/// The light at a point of a face: radiosity in each channel, in a unit of its mean.
#[derive(Debug, Clone)]
pub(crate) struct Sample {
    pub(crate) point: DVec3,
    pub(crate) light: Vec<f64>,
}

/// A face and its shadow lines.
#[derive(Debug)]
pub(crate) struct Known {
    pub(crate) normal: DVec3,
    /// Triangles and parallelograms.
    pub(crate) parts: Vec<Vec<DVec3>>,
    pub(crate) lines: Vec<[DVec3; 2]>,
    /// Whether it stays as it is.
    pub(crate) stays: bool,
}

/// The light at places of a face; nothing when there is no time for more.
pub(crate) type Light<'a> = dyn Fn(usize, &[DVec3]) -> Result<Option<Vec<Sample>>, Error> + Sync + 'a;

/// A triangle or a parallelogram, with the samples in it.
#[derive(Debug, Clone)]
struct Part {
    face: usize,
    corners: Vec<DVec3>,
    samples: Vec<usize>,
    /// Mean square that polynomials leave, times the area.
    left: f64,
    /// The residual that the best cut takes away for each part that it adds, and its pieces.
    best: Option<(f64, Vec<Self>)>,
}

/// The parts of each face, at most `most` together, until the root mean square left is `error`, or as long as there is time.
pub(crate) fn partition(
    faces: &[Known],
    bases: &[Basis; 2],
    (most, error): (usize, f64),
    light: &Light<'_>,
) -> Result<Vec<Vec<Vec<DVec3>>>, Error> {
    let roots = || faces.iter().enumerate().flat_map(|(face, known)| known.parts.iter().map(move |part| (face, part)));
    let total: f64 = roots().map(|(_, corners)| area(corners)).sum();
    let mut cutting = Cutting { faces, bases, light, samples: vec![Vec::new(); faces.len()], density: SAMPLES / total };
    let root = |(face, corners): (usize, &Vec<DVec3>)| {
        cutting.judged(Part { face, corners: corners.clone(), samples: Vec::new(), left: 0.0, best: None })
    };
    let mut parts: Vec<Part> = roots().map(root).collect::<Result<_, Error>>()?;
    loop {
        let residual: f64 = parts.iter().map(|part| part.left).sum();
        let score = |part: &Part| part.best.as_ref().map_or(0.0, |best| best.0);
        let next = (0..parts.len()).max_by(|&a, &b| score(&parts[a]).total_cmp(&score(&parts[b])).then(b.cmp(&a)));
        let Some(next) = next else { break };
        let Some((_, pieces)) = parts[next].best.take().filter(|best| best.0 > 0.0) else { break };
        if residual <= error * error * total || parts.len() + pieces.len() > most + 1 {
            break;
        }
        parts.swap_remove(next);
        for piece in pieces {
            parts.push(cutting.judged(piece)?);
        }
    }
    let mut of_face = vec![Vec::new(); faces.len()];
    parts.into_iter().for_each(|part| of_face[part.face].push(part.corners));
    Ok(of_face)
}

struct Cutting<'a> {
    faces: &'a [Known],
    bases: &'a [Basis; 2],
    light: &'a Light<'a>,
    /// Those of each face so far.
    samples: Vec<Vec<Sample>>,
    /// Samples per area, at least.
    density: f64,
}

impl Cutting<'_> {
    /// The part with as many samples as it needs, and its best cut.
    fn judged(&mut self, mut part: Part) -> Result<Part, Error> {
        if self.faces[part.face].stays {
            return Ok(part);
        }
        let of_face = &mut self.samples[part.face];
        let enough = largest(ENOUGH, self.density * area(&part.corners));
        let Some(more) = (self.light)(part.face, &places(&part.corners, part.samples.len(), enough))? else { return Ok(part) };
        part.samples.extend(of_face.len()..of_face.len() + more.len());
        of_face.extend(more);
        part.left = self.expected_residual(part.face, &part.corners, &part.samples).unwrap_or(0.0);
        Ok(self.with_best(part))
    }

    /// The part with its best cut.
    fn with_best(&self, mut part: Part) -> Part {
        let cuts = self.cuts(&part);
        let scored = cuts.into_par_iter().filter_map(|pieces| {
            let added = pieces.len() - 1;
            let pieces = self.pieces(&part, pieces)?;
            let residual: f64 = pieces.iter().map(|piece| piece.left).sum();
            Some(((part.left - residual) / added as f64, pieces))
        });
        let scored: Vec<(f64, Vec<Part>)> = scored.collect();
        part.best = scored.into_iter().reduce(|best, next| if next.0 > best.0 { next } else { best });
        part
    }

    /// The outlines of pieces of a part, for each way to cut it.
    fn cuts(&self, part: &Part) -> Vec<Vec<Vec<DVec3>>> {
        let (known, corners) = (&self.faces[part.face], &part.corners);
        if part.left <= 0.0 {
            return Vec::new();
        }
        let mut cuts = in_two(corners);
        cuts.push(in_four(corners));
        let size = (corners[1] - corners[0]).length() + (corners[2] - corners[1]).length();
        for line in &known.lines {
            let length = (line[1] - line[0]).length();
            let Some([from, to]) = inside(corners, *line, known.normal, 0.0) else { continue };
            let reach = (line[1] - line[0]) * (2.0 * size / length);
            let whole = [line[0].midpoint(line[1]) - reach, line[0].midpoint(line[1]) + reach];
            let across = inside(corners, whole, known.normal, 0.0).map_or(0.0, |[from, to]| 4.0 * size * (to - from));
            if (to - from) * length <= LEAST_ALONG * across {
                continue;
            }
            let halves = halves(corners, *line, known.normal, LEVEL * size);
            if let [a, b] = &halves[..] {
                let (of_a, of_b) = (shapes(a), shapes(b));
                cuts.extend(of_a.iter().flat_map(|a| of_b.iter().map(move |b| [&a[..], &b[..]].concat())));
            }
        }
        cuts
    }

    /// Pieces with the samples of a part; none if one is too small or too long, or has too few samples.
    fn pieces(&self, part: &Part, outlines: Vec<Vec<DVec3>>) -> Option<Vec<Part>> {
        let (known, whole) = (&self.faces[part.face], area(&part.corners));
        let long = |corners: &[DVec3]| longest(corners) > largest(LONGEST, longest(&part.corners));
        if outlines.iter().any(|corners| area(corners) < LEAST_PIECE * whole || long(corners)) {
            return None;
        }
        let mut samples = vec![Vec::new(); outlines.len()];
        for &sample in &part.samples {
            let point = self.samples[part.face][sample].point;
            let excess = |corners: &Vec<DVec3>| outside(corners, known.normal, point);
            let nearest = (0..outlines.len()).min_by(|&a, &b| excess(&outlines[a]).total_cmp(&excess(&outlines[b])))?;
            samples[nearest].push(sample);
        }
        let piece = |(corners, samples): (Vec<DVec3>, Vec<usize>)| {
            let residual = self.expected_residual(part.face, &corners, &samples)?;
            Some(Part { face: part.face, corners, samples, left: residual, best: None })
        };
        outlines.into_iter().zip(samples).map(piece).collect()
    }

    /// Mean square residual of polynomials, times the area, expected of all places rather than of the samples that they fit;
    /// `None` if these are too few.
    fn expected_residual(&self, face: usize, corners: &[DVec3], samples: &[usize]) -> Option<f64> {
        let (known, samples_of_face) = (&self.faces[face], &self.samples[face]);
        let basis = &self.bases[usize::from(corners.len() == 3)];
        let (len, count) = (basis.len(), samples.len());
        if count < FEWEST * len {
            return None;
        }
        let channels = samples_of_face[samples[0]].light.len();
        let (u, v) = (corners[1] - corners[0], corners[corners.len() - 1] - corners[0]);
        let across = [u, v].map(|side| side.cross(known.normal));
        let dual = [across[1] / across[1].dot(u), across[0] / across[0].dot(v)];
        let mut products = vec![0.0; len * len];
        let mut moments = vec![0.0; len * channels];
        let mut squares = vec![0.0; channels];
        let mut values = vec![0.0; len];
        for sample in samples.iter().map(|&s| &samples_of_face[s]) {
            basis.fill(dual.map(|d| d.dot(sample.point - corners[0])), &mut values);
            for i in 0..len {
                for k in 0..=i {
                    products[i * len + k] += values[i] * values[k];
                }
                for (channel, light) in sample.light.iter().enumerate() {
                    moments[channel * len + i] += values[i] * light;
                }
            }
            squares.iter_mut().zip(&sample.light).for_each(|(square, light)| *square += light * light);
        }
        let factor = cholesky(products, len)?;
        let taken =
            |channel: usize| forward(&factor, &moments[channel * len..(channel + 1) * len]).iter().map(|c| c * c).sum::<f64>();
        let residual: f64 = (0..channels).map(|channel| largest(squares[channel] - taken(channel), 0.0)).sum();
        Some(area(corners) * residual / ((count - len) * channels) as f64)
    }
}

/// Places that cover a triangle or a parallelogram evenly, points of the additive recurrence of the plastic number: from one of them on,
/// until there are enough.
fn places(corners: &[DVec3], from: usize, enough: f64) -> Vec<DVec3> {
    let (origin, u, v) = (corners[0], corners[1] - corners[0], corners[corners.len() - 1] - corners[0]);
    let place = |k: f64| {
        let [s, t] = STEPS.map(|step| (step * (k + 0.5)).fract());
        let [s, t] = if corners.len() == 3 && s + t > 1.0 { [1.0 - s, 1.0 - t] } else { [s, t] };
        origin + u * s + v * t
    };
    (from..).map(|k| k as f64).take_while(|&k| k < enough).map(place).collect()
}

/// Cholesky's factor L of a matrix `L L^T`, row by row, from its lower half (G. H. Golub and C. F. Van Loan 2013, 4.2); `None` if it has
/// none.
fn cholesky(mut a: Vec<f64>, len: usize) -> Option<Vec<f64>> {
    for i in 0..len {
        for k in 0..=i {
            let sum: f64 = (0..k).map(|j| a[i * len + j] * a[k * len + j]).sum();
            let remainder = a[i * len + k] - sum;
            if k < i {
                a[i * len + k] = remainder / a[k * len + k];
            } else if remainder > 1e-9 * a[i * len + i] {
                a[i * len + i] = remainder.sqrt();
            } else {
                return None;
            }
        }
    }
    Some(a)
}

/// The solution y of `L y = b`.
fn forward(factor: &[f64], b: &[f64]) -> Vec<f64> {
    let len = b.len();
    let mut y = b.to_vec();
    for i in 0..len {
        let sum: f64 = (0..i).map(|j| factor[i * len + j] * y[j]).sum();
        y[i] = (y[i] - sum) / factor[i * len + i];
    }
    y
}

/// A triangle or a parallelogram cut in two, at some shares of its sides.
fn in_two(c: &[DVec3]) -> Vec<Vec<Vec<DVec3>>> {
    let mut cuts = Vec::new();
    for share in SHARES {
        if let &[a, b, c, d] = c {
            let [ab, bc, dc, ad] = [(a, b), (b, c), (d, c), (a, d)].map(|(from, to)| from + (to - from) * share);
            cuts.push(vec![vec![a, ab, dc, d], vec![ab, b, c, dc]]);
            cuts.push(vec![vec![a, b, bc, ad], vec![ad, bc, c, d]]);
        } else if let &[a, b, c] = c {
            for [a, b, c] in [[a, b, c], [b, c, a], [c, a, b]] {
                let between = b + (c - b) * share;
                cuts.push(vec![vec![a, b, between], vec![a, between, c]]);
            }
        }
    }
    if let &[a, b, c, d] = c {
        cuts.push(vec![vec![a, b, c], vec![a, c, d]]);
        cuts.push(vec![vec![b, c, d], vec![b, d, a]]);
    }
    cuts
}

/// The quarters of a triangle or a parallelogram.
fn in_four(corners: &[DVec3]) -> Vec<Vec<DVec3>> {
    let shape = if corners.len() == 3 { Shape::Triangle } else { Shape::Parallelogram };
    let (origin, u, v) = (corners[0], corners[1] - corners[0], corners[corners.len() - 1] - corners[0]);
    let point = |[s, t]: [f64; 2]| origin + u * s + v * t;
    (0..4).map(|child| shape.corners().iter().map(|&corner| point(in_parent(shape, child, corner))).collect()).collect()
}

/// The ways to make a convex polygon of triangles and parallelograms, as few as there can be.
fn shapes(v: &[DVec3]) -> Vec<Vec<Vec<DVec3>>> {
    let vertex = |i: usize| v[i % v.len()];
    if v.len() == 3 || is_parallelogram(v) {
        return vec![vec![v.to_vec()]];
    }
    let fan = |from: usize| (1..v.len() - 1).map(|i| vec![vertex(from), vertex(from + i), vertex(from + i + 1)]).collect();
    let mut ways: Vec<Vec<Vec<DVec3>>> = (0..if v.len() == 4 { 2 } else { v.len() }).map(fan).collect();
    // A trapezoid: the parallelogram on its shorter side, and the remaining triangle.
    for i in 0..if v.len() == 4 { 4 } else { 0 } {
        let [a, b, c, d] = [vertex(i), vertex(i + 1), vertex(i + 2), vertex(i + 3)];
        let (longer, shorter) = (b - a, c - d);
        if longer.cross(shorter).length() <= 1e-9 * longer.length() * shorter.length() && longer.length() > shorter.length() {
            let (from, to) = (a + shorter, b - shorter);
            ways.push(vec![vec![a, from, c, d], vec![from, b, c]]);
            ways.push(vec![vec![to, b, c, d], vec![a, to, d]]);
        }
    }
    ways
}

/// Area of a triangle or a parallelogram.
fn area(corners: &[DVec3]) -> f64 {
    let twice = (corners[1] - corners[0]).cross(corners[2] - corners[0]).length();
    if corners.len() == 3 { 0.5 * twice } else { twice }
}

/// The longest side or diagonal over the height on it.
fn longest(corners: &[DVec3]) -> f64 {
    let lengths = corners.iter().flat_map(|a| corners.iter().map(move |b| (*b - *a).length_squared()));
    lengths.fold(0.0, largest) / area(corners)
}

/// How far a point is outside the outline of a convex part, at most; negative inside.
fn outside(corners: &[DVec3], normal: DVec3, point: DVec3) -> f64 {
    let of_side = |i: usize| {
        let side = corners[(i + 1) % corners.len()] - corners[i];
        -normal.cross(side).dot(point - corners[i])
    };
    (0..corners.len()).map(of_side).fold(f64::NEG_INFINITY, largest)
}
