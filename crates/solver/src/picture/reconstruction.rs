//! A continuous radiosity over each face: cubic Hermite patches on the leaves of a solution.
//!
//! At every vertex of the leaves the radiosity and its gradient are gathered exactly, each once, over the links of a leaf that is
//! there; on triangles the value at the centroid besides. Patches are those of [`crate::picture::hermite::HermitePatch`]. A vertex
//! that lies on the middle of a larger leaf's edge, or on a quarter of it, takes the value and the slope along the edge from that
//! edge's cubic: so the patches on its other side are restrictions of that cubic, and meet it without a gap (M. Bastos et al. 1993
//! cut the larger patch instead).
//!
//! A cubic may leave the range of the values that it goes through, most where a gradient grows without limit, and a vertex in a
//! shadow that only just reaches the leaf may stand for too much of it. So each patch is held to the light on its leaf: the
//! polynomial and its detail ([`crate::solve::detail`]). Its Bernstein coefficients must be in the range of the values at its
//! corners and of these, by
//! no more than the detail beyond it, and not below 0; and at the nodes it must be no farther from them than the polynomial is, in the root mean square. Else the polynomial
//! stays, and where that may be negative it is drawn toward its mean (X. Zhang and C.-W. Shu 2010): there neighbours do not meet.
//!
//! What the patches err by against an exact gather is `O(h^4)` where the radiosity is smooth, and first order across a shadow's
//! edge. Where two faces meet the gradient has a logarithmic pole, and radiosity a limit that is not its value, what lies in an
//! emitter's plane receiving nothing: there a vertex is sampled at a 32nd of the way to the leaf's centre, and carried back along
//! the gradient. No bound is claimed; the estimate of the solution ([`crate::solve::solution::Solution::estimate_on`]) holds for the
//! polynomials.

use std::collections::HashMap;

use radgrad_core::DVec3;
use radgrad_scene::{largest, smallest};
use rayon::prelude::*;

use crate::error::Error;
use crate::mesh::TOUCHES;
use crate::mesh::basis::Basis;
use crate::mesh::shape::Shape;
use crate::picture::hermite::HermitePatch;
use crate::solve::solution::Solution;

/// How far towards the leaf's centre a vertex is sampled that lies on another face.
const INWARD: f64 = 1.0 / 32.0;

/// Cells a face's longest side has in the table of vertices.
const CELLS: f64 = (1_u64 << 32) as f64;

/// Cubic patches over the leaves of a solution.
#[derive(Debug, Clone)]
pub struct Reconstruction {
    /// For each element, if it is a leaf, channel after channel.
    pieces: Vec<Vec<Piece>>,
    bases: [Basis; 2],
}

/// The function that is drawn on a leaf.
#[derive(Debug, Clone)]
enum Piece {
    Patch(HermitePatch),
    Polynomial { shape: Shape, coefficients: Vec<f64> },
}

/// A vertex with its samples in each channel.
#[derive(Debug, Clone)]
struct Vertex {
    position: DVec3,
    leaf: usize,
    values: Vec<f64>,
    gradients: Vec<DVec3>,
}

impl Solution {
    /// Joins the leaves by cubic patches through exact values and gradients.
    ///
    /// ```
    /// use radgrad_core::{DVec3, Polygon};
    /// use radgrad_scene::Scene;
    /// use radgrad_solver::{Options, solve};
    /// let mut scene = Scene::new(["grey"])?;
    /// let (white, surface) = (scene.add_material("white", [0.5], [std::f64::consts::FRAC_1_PI])?, scene.add_surface("squares"));
    /// let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    /// scene.add_face(surface, white, Polygon::new(square.map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec()).unwrap(), None)?;
    /// scene.add_face(surface, white, Polygon::new(square.map(|(x, y)| DVec3::new(y, x, 1.0)).to_vec()).unwrap(), None)?;
    /// let solution = solve(&scene, &Options::default(), |_| true)?;
    /// let smooth = solution.reconstruct()?;
    /// let centre = solution.gather(DVec3::new(0.5, 0.5, 0.0), DVec3::Z)?;
    /// let at = solution.mesh().elements()[centre.leaf].reference(DVec3::new(0.5, 0.5, 0.0));
    /// assert!((smooth.value_on(centre.leaf, 0, at) - centre.radiosity[0]).abs() < 1e-4);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If a radiosity or a gradient cannot be represented.
    pub fn reconstruct(&self) -> Result<Reconstruction, Error> {
        let mut vertices = Vertices::of(self);
        vertices.all = vertices.all.par_iter().map(|v| self.sampled(v)).collect::<Result<Vec<Vertex>, Error>>()?;
        let mesh = self.mesh();
        let middles: Vec<Option<Vec<f64>>> = (0..mesh.elements().len())
            .into_par_iter()
            .map(|leaf| {
                let element = &mesh.elements()[leaf];
                if !element.is_leaf() || element.shape() != Shape::Triangle {
                    return Ok(None);
                }
                self.radiosity_on(leaf, element.centre()).map(Some)
            })
            .collect::<Result<_, Error>>()?;
        vertices.join(self);
        let piece = |leaf: usize, channel: usize| {
            let middle = middles[leaf].as_ref().map(|middle| middle[channel]);
            let patch = self.patch(&vertices, leaf, channel, middle);
            let corners = vertices.of_leaf[leaf].iter().map(|&vertex| vertices.all[vertex].values[channel]);
            if self.is_close(&patch, corners.chain(middle), leaf, channel) {
                Piece::Patch(patch)
            } else {
                self.polynomial_drawn(leaf, channel)
            }
        };
        Ok(self.drawn(piece))
    }

    /// The polynomials of the leaves, drawn toward their means where they would be negative: beside the edge of a shadow, most often.
    ///
    /// That keeps the mean of each. A negative mean becomes 0.
    #[must_use]
    pub fn not_negative(&self) -> Reconstruction {
        self.drawn(|leaf, channel| self.polynomial_drawn(leaf, channel))
    }

    /// The function of each leaf in each channel.
    fn drawn(&self, piece: impl Fn(usize, usize) -> Piece + Sync) -> Reconstruction {
        let of_leaf = |leaf: usize| {
            let channels = if self.mesh().elements()[leaf].is_leaf() { self.channels().len() } else { 0 };
            (0..channels).map(|channel| piece(leaf, channel)).collect()
        };
        let pieces = (0..self.mesh().elements().len()).into_par_iter().map(of_leaf).collect();
        Reconstruction { pieces, bases: self.mesh().bases().clone() }
    }

    /// The cubic patch of a leaf.
    fn patch(&self, vertices: &Vertices, leaf: usize, channel: usize, middle: Option<f64>) -> HermitePatch {
        let [u, v] = self.mesh().elements()[leaf].axes();
        let corners: Vec<&Vertex> = vertices.of_leaf[leaf].iter().map(|&v| &vertices.all[v]).collect();
        let value = |k: usize| corners[k].values[channel];
        let slopes = |k: usize| [u, v].map(|axis| corners[k].gradients[channel].dot(axis));
        match middle {
            Some(middle) => HermitePatch::on_triangle([0, 1, 2].map(value), [0, 1, 2].map(slopes), middle),
            None => HermitePatch::on_parallelogram([0, 1, 2, 3].map(value), [0, 1, 2, 3].map(slopes)),
        }
    }

    /// Whether a patch is as near to the light that is known on its leaf as the polynomial, and in its range.
    fn is_close(&self, patch: &HermitePatch, through: impl Iterator<Item = f64>, leaf: usize, channel: usize) -> bool {
        let (basis, detail) = (self.mesh().basis(leaf), &self.details()[leaf][channel]);
        let Some(above) = basis.above() else { return false };
        let mut known = detail.coefficients.clone();
        known.iter_mut().zip(self.coefficients_on(leaf, channel)).for_each(|(sum, c)| *sum += c);
        let [low, high] = above.range(&known);
        // Light differs from both together by no more than from the polynomial alone, and by what samples have beyond them.
        let slack = above.magnitude(&detail.coefficients) + detail.beyond;
        let known_range = [largest(low - slack, 0.0), high + slack];
        let [low, high] = through.fold(known_range, |[low, high], value| [smallest(low, value), largest(high, value)]);
        let [from, to] = patch.range();
        let square = |coefficients: &[f64], of: &dyn Fn([f64; 2]) -> f64| -> f64 {
            let at = |place: [f64; 2]| above.values(place).iter().zip(coefficients).map(|(v, c)| v * c).sum::<f64>() - of(place);
            basis.nodes().iter().map(|node| node.weight * at(node.at).powi(2)).sum()
        };
        // Light itself differs from the detail by the degrees above it, and a patch may be that light.
        let by_polynomial = square(&detail.coefficients, &|_| 0.0) + 2.0 * detail.beyond * detail.beyond;
        low <= from && to <= high && square(&known, &|place| patch.value(place)) <= by_polynomial
    }

    /// The polynomial on a leaf, drawn toward its mean as far as it may be negative.
    fn polynomial_drawn(&self, leaf: usize, channel: usize) -> Piece {
        let mut coefficients = self.coefficients_on(leaf, channel);
        let [low, _] = self.mesh().basis(leaf).range(&coefficients);
        if low < 0.0 {
            let mean = largest(coefficients[0], 0.0);
            let part = mean / (mean - low);
            coefficients.iter_mut().for_each(|c| *c *= part);
            coefficients[0] = mean;
        }
        Piece::Polynomial { shape: self.mesh().elements()[leaf].shape(), coefficients }
    }

    fn sampled(&self, vertex: &Vertex) -> Result<Vertex, Error> {
        let (element, reach) = (&self.mesh().elements()[vertex.leaf], TOUCHES * self.extent);
        let touches = self.mesh().touches(vertex.position, element.face(), reach);
        let inward = if touches { (element.centre() - vertex.position) * INWARD } else { DVec3::ZERO };
        let values = self.radiosity_on(vertex.leaf, vertex.position + inward)?;
        let gradients = self.gradient_at(vertex.leaf, vertex.position + inward)?;
        // Where light falls to nothing within that way it cannot be carried on.
        let carried =
            |(value, gradient): (&f64, &DVec3)| Some(value - gradient.dot(inward)).filter(|back| *back >= 0.0).unwrap_or(*value);
        let back = values.iter().zip(&gradients).map(carried);
        Ok(Vertex { values: back.collect(), gradients, ..vertex.clone() })
    }
}

impl Reconstruction {
    /// Radiosity on a leaf in a channel; 0 if the element is no leaf.
    #[must_use]
    pub fn value_on(&self, leaf: usize, channel: usize, reference: [f64; 2]) -> f64 {
        match self.pieces.get(leaf).and_then(|of| of.get(channel)) {
            Some(Piece::Patch(patch)) => patch.value(reference),
            Some(Piece::Polynomial { shape, coefficients }) => {
                let values = self.bases[usize::from(*shape == Shape::Triangle)].values(reference);
                coefficients.iter().zip(values).map(|(c, v)| c * v).sum()
            }
            None => 0.0,
        }
    }

    /// The patch on a leaf in a channel; none where the leaf keeps its polynomial.
    #[must_use]
    pub fn patch(&self, leaf: usize, channel: usize) -> Option<&HermitePatch> {
        match self.pieces.get(leaf)?.get(channel)? {
            Piece::Patch(patch) => Some(patch),
            Piece::Polynomial { .. } => None,
        }
    }
}

/// All vertices of the leaves, those that lie in one place of a face once.
struct Vertices {
    all: Vec<Vertex>,
    of_leaf: Vec<Vec<usize>>,
    /// By the coarsest element that they are on: faces are cut where others stand on them, and there the light jumps.
    cells: HashMap<(usize, [i64; 2]), usize>,
    frames: Vec<Frame>,
}

/// Coordinates in the plane of a face.
#[derive(Clone, Copy)]
struct Frame {
    origin: DVec3,
    axes: [DVec3; 2],
}

impl Frame {
    #[expect(clippy::cast_possible_truncation, reason = "a face has at most as many cells a side as fit, and casts saturate")]
    fn cell(&self, point: DVec3) -> [i64; 2] {
        self.axes.map(|axis| axis.dot(point - self.origin).round() as i64)
    }
}

impl Vertices {
    fn of(solution: &Solution) -> Self {
        let mesh = solution.mesh();
        let frame = |polygon: &radgrad_core::Polygon| {
            let (u, v) = polygon.normal().any_orthonormal_pair();
            let unit = CELLS / polygon.size();
            Frame { origin: polygon.vertices()[0], axes: [u * unit, v * unit] }
        };
        let frames = mesh.polygons().iter().map(frame).collect();
        let mut vertices =
            Self { all: Vec::new(), of_leaf: vec![Vec::new(); mesh.elements().len()], cells: HashMap::new(), frames };
        for leaf in mesh.leaves() {
            let element = &mesh.elements()[leaf];
            let root = mesh.root_of(leaf);
            for &position in element.polygon().vertices() {
                let vertex = vertices.at(root, element.face(), position).unwrap_or_else(|| {
                    let cell = vertices.frames[element.face()].cell(position);
                    vertices.cells.insert((root, cell), vertices.all.len());
                    vertices.all.push(Vertex { position, leaf, values: Vec::new(), gradients: Vec::new() });
                    vertices.all.len() - 1
                });
                vertices.of_leaf[leaf].push(vertex);
            }
        }
        vertices
    }

    /// The vertex at a place, in its cell or in one beside it.
    fn at(&self, root: usize, face: usize, position: DVec3) -> Option<usize> {
        let [i, j] = self.frames[face].cell(position);
        let near = (-1..=1).flat_map(|a| (-1..=1).map(move |b| [i + a, j + b]));
        near.into_iter().find_map(|cell| self.cells.get(&(root, cell)).copied())
    }

    /// Gives vertices on a leaf's edge what the edge's cubic has there, those of the longest edges first: their ends are done then.
    fn join(&mut self, solution: &Solution) {
        let mesh = solution.mesh();
        let mut edges: Vec<(f64, [usize; 2], [usize; 2])> = Vec::new();
        for leaf in mesh.leaves() {
            let corners = &self.of_leaf[leaf];
            for k in 0..corners.len() {
                let ends = [corners[k], corners[(k + 1) % corners.len()]];
                let [a, b] = ends.map(|v| self.all[v].position);
                edges.push(((b - a).length(), [mesh.root_of(leaf), mesh.elements()[leaf].face()], ends));
            }
        }
        edges.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (_, [root, face], [from, to]) in edges {
            let (low, high) = (self.all[from].clone(), self.all[to].clone());
            let mut open = vec![[0.0, 1.0]];
            while let Some([s, t]) = open.pop() {
                let middle: f64 = 0.5 * (s + t);
                let Some(found) = self.at(root, face, low.position + (high.position - low.position) * middle) else { continue };
                self.all[found].take(middle, &low, &high);
                // A vertex on a part of the edge is an end of a half of it.
                open.extend([[s, middle], [middle, t]]);
            }
        }
    }
}

impl Vertex {
    /// Takes value and slope along an edge from its cubic at the fraction `t`.
    fn take(&mut self, t: f64, low: &Self, high: &Self) {
        let along = high.position - low.position;
        for channel in 0..self.values.len() {
            let [p, q] = [low, high].map(|end| end.values[channel]);
            let [m, n] = [low, high].map(|end| end.gradients[channel].dot(along));
            let u = 1.0 - t;
            self.values[channel] = u * u * (1.0 + 2.0 * t) * p + t * t * (1.0 + 2.0 * u) * q + t * u * (u * m - t * n);
            let slope = 6.0 * t * u * (q - p) + u * (1.0 - 3.0 * t) * m + t * (3.0 * t - 2.0) * n;
            let gradient = &mut self.gradients[channel];
            *gradient += along * ((slope - gradient.dot(along)) / along.length_squared());
        }
    }
}
