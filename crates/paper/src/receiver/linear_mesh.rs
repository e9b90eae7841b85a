//! A receiver as triangles with a linear radiosity on each, sampled where the cubic through an edge's ends leaves its line most.
//!
//! The worst edge is cut where its criterion says, together with both triangles that it bounds, until no edge is off by more than
//! is allowed: neighbours always share their vertices, and the radiosity is continuous. After each sample edges are flipped until
//! no vertex is in the circle through a neighbouring triangle's (C. Lawson 1977): else samples near a peak would be joined to
//! corners far away, again and again. A sample that would come into the circle over an edge of the outline cuts that edge instead
//! (J. Ruppert 1995): else they would crowd along it. Of a quadratic function, three edges that are each off by e leave at most 4/3 e inside the
//! triangle (it is off by `|y - p|^2` less that at the corners, in the metric of its second derivatives); so edges get three
//! quarters of the allowed error.
//!
//! With the maximum first, the brightest place of each emitter is a vertex before any edge is looked at.

use std::collections::{BTreeSet, HashMap};

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::{smallest, triangulate};

use super::criteria::{Departure, departure};
use super::lighting::{Lighting, Sample};
use super::maximum::brightest;
use crate::error::Error;
use crate::receiver::refinement::Refinement;

/// Allowed error of an edge, as a part of that of a triangle.
const EDGE_PART: f64 = 0.75;

/// Two angles opposite an edge may sum to this much more than half a turn, so that rounding cannot flip it for ever.
const LEVEL: f64 = 1e-10;

/// A new vertex is an old one within this fraction of the receiver's size.
const SAME: f64 = 1e-9;

/// Triangles over a receiver, with a sample at each vertex.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon};
/// use radgrad_paper::receiver::{Lighting, Refinement, refine_linear};
/// let square = |half: f64, z: f64| [(-half, -half), (half, -half), (half, half), (-half, half)].map(|(x, y)| DVec3::new(x, y, z));
/// let (floor, mut lamp) = (Polygon::new(square(2.0, 0.0).to_vec())?, square(0.5, 1.0).to_vec());
/// lamp.reverse();
/// let lamps = [Emitter::new(Polygon::new(lamp)?, Emission::Constant(1.0))?];
/// let light = Lighting { emitters: &lamps, occluders: &[], reflectance: 1.0, tolerance: 1e-9 };
/// let mesh = refine_linear(&floor, &light, &Refinement { error: 0.01, ..Refinement::default() })?;
/// let centre = mesh.value(DVec3::ZERO).expect("it is on the floor");
/// assert!((centre - light.sample(DVec3::ZERO, DVec3::Z)?.value).abs() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct LinearMesh {
    samples: Vec<Sample>,
    triangles: Vec<[usize; 3]>,
    normal: DVec3,
    worst: f64,
}

impl LinearMesh {
    /// Samples at the vertices.
    #[must_use]
    pub fn samples(&self) -> &[Sample] {
        &self.samples
    }

    /// Indices of each triangle's vertices, counter-clockwise.
    #[must_use]
    pub fn triangles(&self) -> &[[usize; 3]] {
        &self.triangles
    }

    /// The largest estimated error along an edge, by the criterion; above the allowed one only if the number of elements ran out,
    /// and infinite if that left one longer than allowed.
    #[must_use]
    pub const fn worst(&self) -> f64 {
        self.worst
    }

    /// Radiosity at a point of the receiver, linear between the samples; `None` beside it.
    #[must_use]
    pub fn value(&self, point: DVec3) -> Option<f64> {
        let weights = |t: &[usize; 3]| {
            let [a, b, c] = t.map(|i| self.samples[i].position);
            let whole = self.normal.dot((b - a).cross(c - a));
            let part = |p: DVec3, q: DVec3| self.normal.dot((p - point).cross(q - point)) / whole;
            [part(b, c), part(c, a), part(a, b)]
        };
        let least = |w: &[f64; 3]| w.iter().copied().fold(f64::INFINITY, smallest);
        let containing = self.triangles.iter().map(|t| (t, weights(t)));
        let (triangle, weights) = containing.max_by(|a, b| least(&a.1).total_cmp(&least(&b.1)))?;
        (least(&weights) >= -1e-9).then(|| triangle.iter().zip(weights).map(|(&i, w)| self.samples[i].value * w).sum())
    }
}

/// Divides a receiver into triangles on which the radiosity is linear to the allowed error.
///
/// # Errors
/// If the error or the length allowed is not positive, the receiver's outline touches itself, or a sample cannot be computed.
pub fn refine_linear(receiver: &Polygon, light: &Lighting<'_>, refinement: &Refinement) -> Result<LinearMesh, Error> {
    refinement.check()?;
    let mut building = Building::new(receiver, *light, refinement.longest)?;
    if refinement.maximum_first {
        for emitter in light.emitters {
            if let Some(maximum) = brightest(receiver, emitter)? {
                building.insert(maximum.position)?;
            }
        }
    }
    let allowed = EDGE_PART * refinement.error;
    while let Some((worst, edge)) = building.worst() {
        if worst <= allowed || building.mesh.triangles.len() >= refinement.most_elements {
            building.mesh.worst = worst;
            break;
        }
        let fraction = building.edges[&edge].departure.at;
        match building.too_near(edge, fraction) {
            Some((outer, fraction)) => building.cut(outer, fraction)?,
            None => building.cut(edge, fraction)?,
        }
    }
    Ok(building.mesh)
}

/// Vertices of an edge, the smaller index first.
type Ends = [usize; 2];

struct MeshEdge {
    departure: Departure,
    triangles: Vec<usize>,
}

struct Building<'a> {
    mesh: LinearMesh,
    light: Lighting<'a>,
    longest: f64,
    size: f64,
    edges: HashMap<Ends, MeshEdge>,
    /// Edges by their error: bits of positive numbers are in their order.
    queue: BTreeSet<(u64, Ends)>,
    /// Edges of the outline.
    outline: BTreeSet<Ends>,
}

const fn ends(a: usize, b: usize) -> Ends {
    if a < b { [a, b] } else { [b, a] }
}

impl<'a> Building<'a> {
    fn new(receiver: &Polygon, light: Lighting<'a>, longest: f64) -> Result<Self, Error> {
        let triangles = triangulate(receiver.vertices()).ok_or(Error::Outline)?;
        let normal = receiver.normal();
        let samples = receiver.vertices().iter().map(|&v| light.sample(v, normal)).collect::<Result<_, Error>>()?;
        let count = receiver.vertices().len();
        let outline = (0..count).map(|i| ends(i, (i + 1) % count)).collect();
        let mesh = LinearMesh { samples, triangles: Vec::new(), normal, worst: 0.0 };
        let mut building =
            Self { mesh, light, longest, size: receiver.size(), edges: HashMap::new(), queue: BTreeSet::new(), outline };
        for triangle in triangles {
            building.mesh.triangles.push(triangle);
            building.link(building.mesh.triangles.len() - 1);
        }
        let edges = building.edges.keys().copied().collect::<BTreeSet<Ends>>();
        building.flip(edges.into_iter().collect());
        Ok(building)
    }

    fn worst(&self) -> Option<(f64, Ends)> {
        self.queue.last().map(|&(bits, edge)| (f64::from_bits(bits), edge))
    }

    /// Enters a triangle at its edges.
    fn link(&mut self, triangle: usize) {
        let [a, b, c] = self.mesh.triangles[triangle];
        for [p, q] in [ends(a, b), ends(b, c), ends(c, a)] {
            let (samples, longest) = (&self.mesh.samples, self.longest);
            let queue = &mut self.queue;
            let edge = self.edges.entry([p, q]).or_insert_with(|| {
                let along = samples[q].position - samples[p].position;
                let slopes = [p, q].map(|i| samples[i].gradient.dot(along));
                let departure = if along.length() > longest {
                    Departure { largest: f64::INFINITY, at: 0.5 }
                } else {
                    departure([samples[p].value, samples[q].value], slopes)
                };
                queue.insert((departure.largest.to_bits(), [p, q]));
                MeshEdge { departure, triangles: Vec::with_capacity(2) }
            });
            edge.triangles.push(triangle);
        }
    }

    /// Takes a triangle from its edges; those that bound nothing any more are gone.
    fn unlink(&mut self, triangle: usize) {
        let [a, b, c] = self.mesh.triangles[triangle];
        for edge in [ends(a, b), ends(b, c), ends(c, a)] {
            if let Some(entry) = self.edges.get_mut(&edge) {
                entry.triangles.retain(|&t| t != triangle);
                if entry.triangles.is_empty() {
                    self.queue.remove(&(entry.departure.largest.to_bits(), edge));
                    self.edges.remove(&edge);
                }
            }
        }
    }

    fn sample(&mut self, position: DVec3) -> Result<usize, Error> {
        let sample = self.light.sample(position, self.mesh.normal)?;
        self.mesh.samples.push(sample);
        Ok(self.mesh.samples.len() - 1)
    }

    /// Replaces a triangle by others.
    fn replace(&mut self, triangle: usize, by: &[[usize; 3]]) {
        self.unlink(triangle);
        for (index, &corners) in by.iter().enumerate() {
            let place = if index == 0 { triangle } else { self.mesh.triangles.len() };
            if index == 0 {
                self.mesh.triangles[place] = corners;
            } else {
                self.mesh.triangles.push(corners);
            }
            self.link(place);
        }
    }

    /// An edge of the outline whose circle a point of another edge is in, and where to cut it instead.
    fn too_near(&self, edge: Ends, at: f64) -> Option<(Ends, f64)> {
        if self.outline.contains(&edge) {
            return None;
        }
        let [from, to] = edge.map(|i| self.mesh.samples[i].position);
        let point = from + (to - from) * at;
        self.outline.iter().find_map(|&outer| {
            let [a, b] = outer.map(|i| self.mesh.samples[i].position);
            let along = (point - a).dot(b - a) / (b - a).length_squared();
            ((a - point).dot(b - point) < 0.0).then(|| (outer, along.clamp(0.25, 0.75)))
        })
    }

    /// Cuts an edge and the triangles that it bounds.
    fn cut(&mut self, edge: Ends, at: f64) -> Result<(), Error> {
        let [from, to] = edge.map(|i| self.mesh.samples[i].position);
        let new = self.sample(from + (to - from) * at)?;
        let mut around = Vec::with_capacity(4);
        for triangle in self.edges[&edge].triangles.clone() {
            let mut corners = self.mesh.triangles[triangle];
            while ends(corners[0], corners[1]) != edge {
                corners.rotate_left(1);
            }
            let [a, b, c] = corners;
            self.replace(triangle, &[[a, new, c], [new, b, c]]);
            around.extend([ends(b, c), ends(c, a)]);
        }
        self.flip(around);
        if self.outline.remove(&edge) {
            self.outline.extend(edge.map(|end| ends(end, new)));
        }
        Ok(())
    }

    /// Flips edges, and those around flipped ones, until every triangle's circle is empty of its neighbours.
    fn flip(&mut self, mut suspects: Vec<Ends>) {
        while let Some(edge) = suspects.pop() {
            let Some([one, other]) = self.edges.get(&edge).and_then(|e| <[usize; 2]>::try_from(&e.triangles[..]).ok()) else {
                continue;
            };
            let opposite = |t: usize| {
                let mut corners = self.mesh.triangles[t];
                while ends(corners[0], corners[1]) != edge {
                    corners.rotate_left(1);
                }
                corners
            };
            let ([a, b, c], [.., d]) = (opposite(one), opposite(other));
            // Sine and cosine of the angle under which the edge is seen from a vertex.
            let angle = |from: usize, p: usize, q: usize| {
                let [x, p, q] = [from, p, q].map(|i| self.mesh.samples[i].position);
                let (p, q) = (p - x, q - x);
                let length = (p.length_squared() * q.length_squared()).sqrt();
                [self.mesh.normal.dot(p.cross(q)) / length, p.dot(q) / length]
            };
            let ([sin_c, cos_c], [sin_d, cos_d]) = (angle(c, a, b), angle(d, b, a));
            if sin_c * cos_d + cos_c * sin_d < -LEVEL {
                self.unlink(one);
                self.unlink(other);
                self.mesh.triangles[one] = [a, d, c];
                self.mesh.triangles[other] = [d, b, c];
                self.link(one);
                self.link(other);
                suspects.extend([ends(a, d), ends(d, b), ends(b, c), ends(c, a)]);
            }
        }
    }

    /// Makes a point of the receiver a vertex.
    fn insert(&mut self, point: DVec3) -> Result<(), Error> {
        let near = |p: DVec3| (p - point).length() <= SAME * self.size;
        if self.mesh.samples.iter().any(|s| near(s.position)) {
            return Ok(());
        }
        // The side of a triangle that the point is outside of or nearest to, and its distance, inward.
        let room = |t: &[usize; 3]| {
            let side = |i: usize| {
                let [a, b] = [t[i], t[(i + 1) % 3]].map(|v| self.mesh.samples[v].position);
                let inward = self.mesh.normal.cross((b - a).normalize());
                (inward.dot(point - a), i)
            };
            (0..3).map(side).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::NEG_INFINITY, 0))
        };
        let rooms = self.mesh.triangles.iter().map(room).enumerate();
        let Some((triangle, (least, side))) = rooms.max_by(|a, b| a.1.0.total_cmp(&b.1.0)) else { return Ok(()) };
        let [a, b, c] = self.mesh.triangles[triangle];
        if least <= SAME * self.size {
            let corners = [a, b, c];
            let edge = ends(corners[side], corners[(side + 1) % 3]);
            let [from, to] = edge.map(|i| self.mesh.samples[i].position);
            let fraction = (point - from).dot(to - from) / (to - from).length_squared();
            return self.cut(edge, fraction);
        }
        let new = self.sample(point)?;
        self.replace(triangle, &[[a, b, new], [b, c, new], [c, a, new]]);
        self.flip(vec![ends(a, b), ends(b, c), ends(c, a)]);
        Ok(())
    }
}
