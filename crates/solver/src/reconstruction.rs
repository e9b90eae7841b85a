//! A continuous radiosity over each face: cubic Hermite patches on the leaves of a solution.
//!
//! At every vertex of the leaves the radiosity and its gradient are gathered exactly, each once, over the links of a leaf that is
//! there; on triangles the value at the centroid besides. Patches are those of [`crate::HermitePatch`]. A vertex that lies on the
//! middle of a larger leaf's edge, or on a quarter of it, takes the value and the slope along the edge from that edge's cubic: so
//! the patches on its other side are restrictions of that cubic, and meet it without a gap (M. Bastos et al. 1993 cut the larger
//! patch instead).
//!
//! What the patches err by against an exact gather is `O(h^4)` where the radiosity is smooth, and first order across a shadow's
//! edge. Where two faces meet the gradient has a logarithmic pole, and radiosity a limit that is not its value, what lies in an
//! emitter's plane receiving nothing: there a vertex is sampled at a 32nd of the way to the leaf's centre, and carried back along
//! the gradient. No bound is claimed; that of the solution ([`crate::Solution::bound_on`]) holds for the polynomials.

use std::collections::HashMap;

use radgrad_core::{DVec3, Receiver, evaluate_to, gradient};
use rayon::prelude::*;

use crate::Error;
use crate::basis::{Basis, Shape};
use crate::hermite::HermitePatch;
use crate::mesh::Sight;
use crate::rule::{self, Node};
use crate::solve::Solution;

/// How far towards the leaf's centre a vertex is sampled that lies on another face.
const INWARD: f64 = 1.0 / 32.0;

/// A vertex lies on a face within this fraction of the scene's extent.
const TOUCHES: f64 = 1e-9;

/// Cells a face's longest side has in the table of vertices.
const CELLS: f64 = (1_u64 << 32) as f64;

/// Nodes a side of the rule for gradients from afar, and the distance from the source in its radii from which it serves: there it
/// leaves about 1e-8 of the gradient.
const FAR_NODES: usize = 6;
const FAR: f64 = 4.0;

/// Cubic patches over the leaves of a solution.
#[derive(Debug, Clone)]
pub struct Reconstruction {
    /// For each element, if it is a leaf, channel after channel.
    patches: Vec<Vec<HermitePatch>>,
}

/// What is known of a vertex, in each channel.
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
        let sampled = vertices.all.par_iter().map(|v| self.sampled(v)).collect::<Result<Vec<Vertex>, Error>>()?;
        vertices.all = sampled;
        vertices.join(self);
        let mesh = self.mesh();
        let middles: Vec<Option<Vec<f64>>> = (0..mesh.elements().len())
            .into_par_iter()
            .map(|leaf| {
                let element = &mesh.elements()[leaf];
                if !element.is_leaf() || element.shape() != Shape::Triangle {
                    return Ok(None);
                }
                self.gather_on(leaf, element.centre()).map(|gathered| Some(gathered.radiosity))
            })
            .collect::<Result<_, Error>>()?;
        let patch = |leaf: usize, channel: usize| {
            let [u, v] = mesh.elements()[leaf].axes();
            let corners: Vec<&Vertex> = vertices.of_leaf[leaf].iter().map(|&v| &vertices.all[v]).collect();
            let value = |k: usize| corners[k].values[channel];
            let slopes = |k: usize| [u, v].map(|axis| corners[k].gradients[channel].dot(axis));
            match &middles[leaf] {
                Some(middle) => HermitePatch::on_triangle([0, 1, 2].map(value), [0, 1, 2].map(slopes), middle[channel]),
                None => HermitePatch::on_parallelogram([0, 1, 2, 3].map(value), [0, 1, 2, 3].map(slopes)),
            }
        };
        let of_leaf = |leaf: usize| {
            let channels = if mesh.elements()[leaf].is_leaf() { self.channels().len() } else { 0 };
            (0..channels).map(|channel| patch(leaf, channel)).collect()
        };
        Ok(Reconstruction { patches: (0..mesh.elements().len()).map(of_leaf).collect() })
    }

    fn sampled(&self, vertex: &Vertex) -> Result<Vertex, Error> {
        let (element, reach) = (&self.mesh().elements()[vertex.leaf], TOUCHES * self.extent);
        let touches = self.mesh().touches(vertex.position, element.face(), reach);
        let inward = if touches { (element.centre() - vertex.position) * INWARD } else { DVec3::ZERO };
        let gathered = self.gather_on(vertex.leaf, vertex.position + inward)?;
        let gradients = self.gradient_at(vertex.leaf, vertex.position + inward)?;
        let back = gathered.radiosity.iter().zip(&gradients).map(|(value, gradient)| value - gradient.dot(inward));
        Ok(Vertex { values: back.collect(), gradients, ..vertex.clone() })
    }

    /// Gradient of one exact gather within the leaf's plane, in each channel: the closed forms' at nearby and half hidden sources,
    /// without bound. Of what is seen through clusters none is known. A texture has none within a texel: its gradient is that of the irradiance times the reflectance there.
    ///
    /// # Errors
    /// If it cannot be represented.
    pub fn gradient_at(&self, leaf: usize, point: DVec3) -> Result<Vec<DVec3>, Error> {
        let mut sums = self.reflected_gradient_at(self.receiver_of(leaf), point)?;
        sums.iter_mut().zip(self.direct_gradient_at(leaf, point)?).for_each(|(sum, direct)| *sum += direct);
        let [rho, _] = self.surfaces.at(self.mesh().elements()[leaf].face(), point);
        Ok(sums.iter().zip(&rho).map(|(sum, rho)| *sum * *rho).collect())
    }

    /// The part of the irradiance of lamps, at a point of a leaf.
    pub(crate) fn direct_gradient_at(&self, leaf: usize, point: DVec3) -> Result<Vec<DVec3>, Error> {
        let emitted = |lamp: usize| self.surfaces.emitted[self.mesh().elements()[lamp].face()].chunks_exact(1).collect();
        let lamps = self.direct.get(leaf).into_iter().flat_map(|direct| self.lamps.seen(direct));
        self.gradient_of(leaf, point, lamps.map(|(lamp, sight)| (lamp, sight, emitted(lamp))))
    }

    /// The part of the irradiance of all else, at a point of a receiver.
    pub(crate) fn reflected_gradient_at(&self, receiver: usize, point: DVec3) -> Result<Vec<DVec3>, Error> {
        let coefficients = |source: usize| {
            let len = self.mesh().basis(source).len();
            (0..self.channels().len()).map(|channel| self.field.of(source, channel, len)).collect()
        };
        let links = self.links[receiver].iter();
        self.gradient_of(receiver, point, links.map(|link| (link.source, &link.sight, coefficients(link.source))))
    }

    /// Gradient within an element's plane of the irradiance of sources with the coefficients of each channel.
    fn gradient_of<'a>(
        &self,
        element: usize,
        point: DVec3,
        sources: impl Iterator<Item = (usize, &'a Sight, Vec<&'a [f64]>)>,
    ) -> Result<Vec<DVec3>, Error> {
        let element = &self.mesh().elements()[element];
        let normal = element.polygon().normal();
        let mut sums = vec![DVec3::ZERO; self.channels().len()];
        for (source, sight, coefficients) in sources {
            let sight = match sight {
                Sight::Past(known) => self.mesh().sight_of_point(element.face(), point, source, Some(known)),
                other => other.clone(),
            };
            let gradients = self.gradients_from(source, &sight, point, normal, element.face(), &coefficients)?;
            sums.iter_mut().zip(gradients).for_each(|(sum, gradient)| *sum += gradient.reject_from_normalized(normal));
        }
        Ok(sums)
    }

    /// Gradient of what a source gives to a point with the coefficients of each channel. All functions together: that of one
    /// alone is zero where it is symmetric, and no number of digits tells zero from nearly so.
    fn gradients_from(
        &self,
        source_index: usize,
        sight: &Sight,
        point: DVec3,
        normal: DVec3,
        face: usize,
        coefficients: &[&[f64]],
    ) -> Result<Vec<DVec3>, Error> {
        let mesh = self.mesh();
        let (source, basis) = (&mesh.elements()[source_index], mesh.basis(source_index));
        let refused = |source| Error::Evaluation { face, source };
        if matches!(sight, Sight::Nothing(_)) {
            return Ok(vec![DVec3::ZERO; coefficients.len()]);
        }
        let whole = |v: &DVec3| normal.dot(*v - point) > 1e-9 * (*v - point).length();
        let (of_source, distance) = (source.polygon(), (point - source.centre()).length() - source.radius());
        let in_front = of_source.normal().dot(point - of_source.vertices()[0]) > 0.0;
        if *sight == Sight::Clear && in_front && distance >= FAR * source.radius() && of_source.vertices().iter().all(whole) {
            let count = coefficients.first().map_or(0, |c| c.len());
            let of_functions = from_afar(point, normal, source, basis, count);
            let sum = |c: &&[f64]| c.iter().zip(&of_functions).map(|(c, g)| *g * *c).sum();
            return Ok(coefficients.iter().map(sum).collect());
        }
        let receiver = Receiver::new(point, normal, 1.0).map_err(refused)?;
        let occluders: Vec<_> = match sight {
            Sight::Past(faces) => faces.iter().map(|&f| mesh.polygons()[f].clone()).collect(),
            _ => Vec::new(),
        };
        let of_channel = |coefficients: &&[f64]| {
            if coefficients.iter().all(|c| *c == 0.0) {
                return Ok(DVec3::ZERO);
            }
            let emitter = source.emitter_of(coefficients, basis)?;
            if occluders.is_empty() {
                return gradient(&receiver, &emitter).map_err(refused);
            }
            // The first rung's digits are more than a reconstruction needs.
            evaluate_to(&receiver, &emitter, &occluders, 1.0).map(|answer| answer.gradient).map_err(refused)
        };
        coefficients.iter().map(of_channel).collect()
    }
}

/// The gradient of the kernel `k = h (n1.r) / pi r^4`, `(n2 (n1.r) - h n1) / r^4 + 4 h (n1.r) r / r^6` over pi, by a product rule.
fn from_afar(point: DVec3, normal: DVec3, source: &crate::Element, basis: &Basis, count: usize) -> Vec<DVec3> {
    let nodes: Vec<Node> = match source.shape() {
        Shape::Parallelogram => rule::product(FAR_NODES),
        Shape::Triangle => rule::collapsed(FAR_NODES),
    };
    let height = source.polygon().normal().dot(point - source.polygon().vertices()[0]);
    let scale = source.area() / std::f64::consts::PI;
    let mut gradients = vec![DVec3::ZERO; count];
    for node in nodes {
        let r = source.point(node.at) - point;
        let inverse = 1.0 / r.length_squared();
        let cosine = normal.dot(r);
        let slope = source.polygon().normal() * cosine - normal * height + r * (4.0 * height * cosine * inverse);
        let slope = slope * (node.weight * scale * inverse * inverse);
        for (sum, value) in gradients.iter_mut().zip(basis.values(node.at)) {
            *sum += slope * value;
        }
    }
    gradients
}

impl Reconstruction {
    /// Radiosity on a leaf in a channel; 0 on what is no leaf.
    #[must_use]
    pub fn value_on(&self, leaf: usize, channel: usize, reference: [f64; 2]) -> f64 {
        self.patch(leaf, channel).map_or(0.0, |patch| patch.value(reference))
    }

    /// The patch on a leaf in a channel.
    #[must_use]
    pub fn patch(&self, leaf: usize, channel: usize) -> Option<&HermitePatch> {
        self.patches.get(leaf)?.get(channel)
    }
}

/// All vertices of the leaves, those that lie in one place of a face once.
struct Vertices {
    all: Vec<Vertex>,
    of_leaf: Vec<Vec<usize>>,
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
            for &position in element.polygon().vertices() {
                let vertex = vertices.at(element.face(), position).unwrap_or_else(|| {
                    let cell = vertices.frames[element.face()].cell(position);
                    vertices.cells.insert((element.face(), cell), vertices.all.len());
                    vertices.all.push(Vertex { position, leaf, values: Vec::new(), gradients: Vec::new() });
                    vertices.all.len() - 1
                });
                vertices.of_leaf[leaf].push(vertex);
            }
        }
        vertices
    }

    /// The vertex at a place, in its cell or in one beside it.
    fn at(&self, face: usize, position: DVec3) -> Option<usize> {
        let [i, j] = self.frames[face].cell(position);
        let near = (-1..=1).flat_map(|a| (-1..=1).map(move |b| [i + a, j + b]));
        near.into_iter().find_map(|cell| self.cells.get(&(face, cell)).copied())
    }

    /// Gives vertices on a leaf's edge what the edge's cubic has there, those of the longest edges first: their ends are done then.
    fn join(&mut self, solution: &Solution) {
        let mesh = solution.mesh();
        let mut edges: Vec<(f64, usize, [usize; 2])> = Vec::new();
        for leaf in mesh.leaves() {
            let corners = &self.of_leaf[leaf];
            for k in 0..corners.len() {
                let ends = [corners[k], corners[(k + 1) % corners.len()]];
                let [a, b] = ends.map(|v| self.all[v].position);
                edges.push(((b - a).length(), mesh.elements()[leaf].face(), ends));
            }
        }
        edges.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (_, face, [from, to]) in edges {
            let (low, high) = (self.all[from].clone(), self.all[to].clone());
            let mut open = vec![[0.0, 1.0]];
            while let Some([s, t]) = open.pop() {
                let middle: f64 = 0.5 * (s + t);
                let Some(found) = self.at(face, low.position + (high.position - low.position) * middle) else { continue };
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
