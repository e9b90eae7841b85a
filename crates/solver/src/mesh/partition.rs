//! Faces cut where that makes polynomials fit best, along shadow lines above all.
//!
//! The light on a face is known at samples. What polynomials leave out of it on a part is the sum of squares of the least squares
//! fit's residuals. One part after another is cut, always the one whose best cut takes most of that away for each element that it
//! adds. Cuts are along the shadow lines that cross a part ([`crate::mesh::shadow`]), in two through the middle, and in four as
//! refinement does. So a line cuts elements as far as it counts for the light there, elements across which light changes little
//! in one direction stay long in that, and of the hundreds of lines of a scene none is taken that gains less than another cut does.

use radgrad_core::DVec3;
use radgrad_scene::largest;
use rayon::prelude::*;

use crate::mesh::basis::Basis;
use crate::mesh::contact::{halves, inside};
use crate::mesh::shape::{Shape, in_parent, is_parallelogram};

/// Fraction of a part's size within which corners are on a line.
const LEVEL: f64 = 1e-9;

/// A cut leaves no piece with less than this fraction of the part's area.
const LEAST_PIECE: f64 = 0.01;

/// The fraction of a line across a part that has to be shadow line.
const LEAST_ALONG: f64 = 0.25;

/// Samples in a part for each function of the basis, below which nothing is said of it.
const FEWEST: usize = 3;

/// Shares of a side at which a part is cut in two.
const SHARES: [f64; 3] = [0.5, 1.0 / 3.0, 2.0 / 3.0];

/// Longest side over the height on it beyond which no cut makes a part.
const LONGEST: f64 = 50.0;

/// The light at a point of a face: irradiance in each channel, in a unit of its mean.
#[derive(Debug, Clone)]
pub(crate) struct Sample {
    pub(crate) point: DVec3,
    pub(crate) light: Vec<f64>,
}

/// A face, its shadow lines and samples of its light.
#[derive(Debug)]
pub(crate) struct Known {
    pub(crate) normal: DVec3,
    /// Triangles and parallelograms.
    pub(crate) parts: Vec<Vec<DVec3>>,
    pub(crate) lines: Vec<[DVec3; 2]>,
    pub(crate) samples: Vec<Sample>,
}

/// A triangle or a parallelogram, with the samples in it.
#[derive(Debug, Clone)]
struct Part {
    face: usize,
    corners: Vec<DVec3>,
    samples: Vec<usize>,
    /// Sum of squares that polynomials leave.
    left: f64,
    /// What the best cut takes away for each part that it adds, and its pieces.
    best: Option<(f64, Vec<Self>)>,
}

/// The parts of each face, at most `most` together, or until the root mean square left is `error`.
pub(crate) fn partition(faces: &[Known], bases: &[Basis; 2], most: usize, error: f64) -> Vec<Vec<Vec<DVec3>>> {
    let cutting = Cutting { faces, bases };
    let count: usize = faces.iter().map(|face| face.samples.len()).sum();
    let enough = error * error * count as f64;
    let roots: Vec<(usize, &Vec<DVec3>)> =
        faces.iter().enumerate().flat_map(|(face, known)| known.parts.iter().map(move |part| (face, part))).collect();
    let mut parts: Vec<Part> = roots.par_iter().map(|(face, corners)| cutting.root(*face, corners)).collect();
    loop {
        let left: f64 = parts.iter().map(|part| part.left).sum();
        let score = |part: &Part| part.best.as_ref().map_or(0.0, |best| best.0);
        let next = (0..parts.len()).max_by(|&a, &b| score(&parts[a]).total_cmp(&score(&parts[b])).then(b.cmp(&a)));
        let Some((_, pieces)) = next.and_then(|next| parts[next].best.take().filter(|best| best.0 > 0.0)) else { break };
        if left <= enough || parts.len() + pieces.len() > most + 1 {
            break;
        }
        let pieces: Vec<Part> = pieces.into_par_iter().map(|piece| cutting.with_best(piece)).collect();
        if let Some(next) = next {
            parts.swap_remove(next);
        }
        parts.extend(pieces);
    }
    let mut of_face = vec![Vec::new(); faces.len()];
    parts.into_iter().for_each(|part| of_face[part.face].push(part.corners));
    of_face
}

struct Cutting<'a> {
    faces: &'a [Known],
    bases: &'a [Basis; 2],
}

impl Cutting<'_> {
    /// A part that the face was cut into before, with its samples.
    fn root(&self, face: usize, corners: &[DVec3]) -> Part {
        let known = &self.faces[face];
        let inside = |s: &usize| outside(corners, known.normal, known.samples[*s].point) <= 0.0;
        let samples: Vec<usize> = (0..known.samples.len()).filter(inside).collect();
        let left = self.left(face, corners, &samples).unwrap_or(0.0);
        self.with_best(Part { face, corners: corners.to_vec(), samples, left, best: None })
    }

    /// The part with its best cut.
    fn with_best(&self, mut part: Part) -> Part {
        let cuts = self.cuts(&part);
        let scored = cuts.into_par_iter().filter_map(|pieces| {
            let added = pieces.len() - 1;
            let pieces = self.pieces(&part, pieces)?;
            let left: f64 = pieces.iter().map(|piece| piece.left).sum();
            Some(((part.left - left) / added as f64, pieces))
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
            if (to - from) * length < LEAST_ALONG * across || to <= from {
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
            let point = known.samples[sample].point;
            let excess = |corners: &Vec<DVec3>| outside(corners, known.normal, point);
            let nearest = (0..outlines.len()).min_by(|&a, &b| excess(&outlines[a]).total_cmp(&excess(&outlines[b])))?;
            samples[nearest].push(sample);
        }
        let piece = |(corners, samples): (Vec<DVec3>, Vec<usize>)| {
            let left = self.left(part.face, &corners, &samples)?;
            Some(Part { face: part.face, corners, samples, left, best: None })
        };
        outlines.into_iter().zip(samples).map(piece).collect()
    }

    /// Sum of squares over samples of what polynomials leave of the light, expected of all places rather than of the samples that they
    /// fit; `None` if these are too few.
    fn left(&self, face: usize, corners: &[DVec3], samples: &[usize]) -> Option<f64> {
        let known = &self.faces[face];
        let basis = &self.bases[usize::from(corners.len() == 3)];
        let (len, count) = (basis.len(), samples.len());
        if count < FEWEST * len {
            return None;
        }
        let channels = known.samples[samples[0]].light.len();
        let (u, v) = (corners[1] - corners[0], corners[corners.len() - 1] - corners[0]);
        let across = [u, v].map(|side| side.cross(known.normal));
        let dual = [across[1] / across[1].dot(u), across[0] / across[0].dot(v)];
        let mut products = vec![0.0; len * len];
        let mut moments = vec![0.0; len * channels];
        let mut squares = vec![0.0; channels];
        let mut values = vec![0.0; len];
        for sample in samples.iter().map(|&s| &known.samples[s]) {
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
        let left: f64 = (0..channels).map(|channel| largest(squares[channel] - taken(channel), 0.0)).sum();
        Some(left * count as f64 / ((count - len) * channels) as f64)
    }
}

/// Cholesky's factor L of a matrix `L L^T`, row by row, from its lower half (G. H. Golub and C. F. Van Loan 2013, 4.2); `None` if it has
/// none.
fn cholesky(mut a: Vec<f64>, len: usize) -> Option<Vec<f64>> {
    for i in 0..len {
        for k in 0..=i {
            let sum: f64 = (0..k).map(|j| a[i * len + j] * a[k * len + j]).sum();
            let rest = a[i * len + k] - sum;
            if k < i {
                a[i * len + k] = rest / a[k * len + k];
            } else if rest > 1e-9 * a[i * len + i] {
                a[i * len + i] = rest.sqrt();
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
    let at = |[s, t]: [f64; 2]| origin + u * s + v * t;
    (0..4).map(|child| shape.corners().iter().map(|&corner| at(in_parent(shape, child, corner))).collect()).collect()
}

/// The ways to make a convex polygon of triangles and parallelograms, as few as there can be.
fn shapes(v: &[DVec3]) -> Vec<Vec<Vec<DVec3>>> {
    let at = |i: usize| v[i % v.len()];
    if v.len() == 3 || is_parallelogram(v) {
        return vec![vec![v.to_vec()]];
    }
    let fan = |from: usize| (1..v.len() - 1).map(|i| vec![at(from), at(from + i), at(from + i + 1)]).collect();
    let mut ways: Vec<Vec<Vec<DVec3>>> = (0..if v.len() == 4 { 2 } else { v.len() }).map(fan).collect();
    // A trapezoid: the parallelogram on its shorter side, and what is left.
    for i in 0..if v.len() == 4 { 4 } else { 0 } {
        let [a, b, c, d] = [at(i), at(i + 1), at(i + 2), at(i + 3)];
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
