//! A receiver as elements with a constant radiosity on each, divided across the gradient.
//!
//! An element is sampled at its centroid. Over a parallelogram with the sides u and v the radiosity is off its value there by
//! `(|grad B . u| + |grad B . v|)/2` to first order, and the side that has more of it is halved; of a triangle by the largest
//! `|grad B . (corner - centroid)|`, and the edge along which the gradient changes it most is halved. So elements get long where
//! the light changes in one direction only.
//!
//! At its maximum the gradient is zero, and on both flanks of a peak it is nearly so: a centroid there says nothing. With the
//! maximum first, the receiver is cut at the brightest place of the first emitter that lights it, and an element that has the
//! brightest place of any emitter has at least the difference from the value there as its error.

use std::collections::BTreeSet;

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::{is_parallelogram, largest, smallest, triangulate};

use super::criteria::variation;
use super::lighting::{Lighting, Sample};
use super::maximum::brightest;
use crate::error::Error;
use crate::receiver::refinement::Refinement;

/// Fraction of the size by which a point may be outside of an element that it belongs to.
const TOUCHES: f64 = 1e-9;

/// The part of the rise to a maximum that a gradient sees at least if its direction is to count.
const UNSEEN: f64 = 0.25;

/// A part of a receiver with one radiosity.
#[derive(Debug, Clone, PartialEq)]
pub struct ConstantElement {
    /// Corners, counter-clockwise: three, or the four of a parallelogram.
    pub corners: Vec<DVec3>,
    /// The sample at the centroid.
    pub sample: Sample,
    /// Estimated error of the sample's radiosity over the element, by the criterion; infinite if a side is longer than allowed.
    pub off: f64,
    /// The side whose half is next, if any is: from this corner to the next one.
    side: usize,
}

/// Elements over a receiver.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon};
/// use radgrad_paper::receiver::{Lighting, Refinement, refine_constant};
/// let point = |x, y, z| DVec3::new(x, y, z);
/// let floor = Polygon::new(vec![point(0.0, 0.0, 0.0), point(9.0, 0.0, 0.0), point(9.0, 1.0, 0.0), point(0.0, 1.0, 0.0)])?;
/// // A long lamp beside it: light changes along x.
/// let lamp = Polygon::new(vec![point(-1.0, -50.0, 1.0), point(-1.0, 50.0, 1.0), point(0.0, 50.0, 1.0), point(0.0, -50.0, 1.0)])?;
/// let lamps = [Emitter::new(lamp, Emission::Constant(1.0))?];
/// let light = Lighting { emitters: &lamps, occluders: &[], reflectance: 1.0, tolerance: 1e-9 };
/// let mesh = refine_constant(&floor, &light, &Refinement { error: 0.01, ..Refinement::default() })?;
/// assert!(mesh.elements().iter().all(|e| (e.corners[2].y - e.corners[0].y).abs() == 1.0), "never divided across");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct ConstantMesh {
    elements: Vec<ConstantElement>,
    normal: DVec3,
}

impl ConstantMesh {
    /// The elements.
    #[must_use]
    pub fn elements(&self) -> &[ConstantElement] {
        &self.elements
    }

    /// The largest estimated error of an element, by the criterion; above the allowed one only if the number of elements ran out.
    #[must_use]
    pub fn worst(&self) -> f64 {
        self.elements.iter().map(|e| e.off).fold(0.0, largest)
    }

    /// Radiosity at a point of the receiver; `None` beside it.
    #[must_use]
    pub fn value(&self, point: DVec3) -> Option<f64> {
        let room = |e: &&ConstantElement| e.room(point, self.normal);
        let element = self.elements.iter().max_by(|a, b| room(a).total_cmp(&room(b)))?;
        (room(&element) >= -TOUCHES * element.size()).then_some(element.sample.value)
    }
}

impl ConstantElement {
    fn new(corners: Vec<DVec3>, light: &Lighting<'_>, normal: DVec3, brightest: &[Sample], longest: f64) -> Result<Self, Error> {
        let centre = corners.iter().sum::<DVec3>() / corners.len() as f64;
        let sample = light.sample(centre, normal)?;
        let mut element = Self { corners, sample, off: 0.0, side: 0 };
        element.judge(sample.gradient);
        for most in brightest {
            let error = (most.value - sample.value).abs();
            let to = most.position - centre;
            if element.room(most.position, normal) >= -TOUCHES * element.size() && error > element.off && to.length() > 0.0 {
                // Where the gradient does not see the rise, it is along the way there.
                if element.off < UNSEEN * error {
                    element.judge(to * (error / to.length_squared()));
                }
                element.off = error;
            }
        }
        let sides = |i: usize| (element.corners[(i + 1) % element.corners.len()] - element.corners[i]).length();
        let long = (0..element.corners.len().min(3)).max_by(|&i, &j| sides(i).total_cmp(&sides(j)));
        if let Some(long) = long.filter(|&i| sides(i) > longest) {
            // Sides of a parallelogram that face each other are halved together.
            let side = if element.corners.len() == 4 { long % 2 } else { long };
            (element.off, element.side) = (f64::INFINITY, side);
        }
        Ok(element)
    }

    fn judge(&mut self, gradient: DVec3) {
        if let [a, b, _, d] = self.corners[..] {
            let [along, across] = variation(gradient, [b - a, d - a]);
            self.off = 0.5 * (along + across);
            self.side = usize::from(across > along);
        } else {
            let change = |&corner: &DVec3| gradient.dot(corner - self.sample.position).abs();
            self.off = self.corners.iter().map(change).fold(0.0, largest);
            let along = |i: usize| gradient.dot(self.corners[(i + 1) % 3] - self.corners[i]).abs();
            self.side = (0..3).max_by(|&i, &j| along(i).total_cmp(&along(j))).unwrap_or(0);
        }
    }

    fn size(&self) -> f64 {
        self.corners.iter().map(|&c| (c - self.corners[0]).length()).fold(0.0, largest)
    }

    /// Distance of a point from the nearest edge, inward.
    fn room(&self, point: DVec3, normal: DVec3) -> f64 {
        let count = self.corners.len();
        let side = |i: usize| {
            let (a, b) = (self.corners[i], self.corners[(i + 1) % count]);
            normal.cross((b - a).normalize_or_zero()).dot(point - a)
        };
        (0..count).map(side).fold(f64::INFINITY, smallest)
    }

    /// The outlines of both parts.
    fn halves(&self) -> [Vec<DVec3>; 2] {
        if let [a, b, c, d] = self.corners[..] {
            let [a, b, c, d] = if self.side == 0 { [a, b, c, d] } else { [b, c, d, a] };
            let (low, high) = (0.5 * (a + b), 0.5 * (c + d));
            return [vec![a, low, high, d], vec![low, b, c, high]].map(|mut part| {
                // The first corner stays one of the first side's.
                if self.side == 1 {
                    part.rotate_right(1);
                }
                part
            });
        }
        let [a, b, c] = [0, 1, 2].map(|k| self.corners[(self.side + k) % 3]);
        let middle = 0.5 * (a + b);
        [vec![a, middle, c], vec![middle, b, c]]
    }
}

/// Divides a receiver into elements on which the radiosity is constant to the allowed error.
///
/// # Errors
/// If the error or the length allowed is not positive, the receiver's outline touches itself, or a sample cannot be computed.
pub fn refine_constant(receiver: &Polygon, light: &Lighting<'_>, refinement: &Refinement) -> Result<ConstantMesh, Error> {
    refinement.check()?;
    let normal = receiver.normal();
    let mut maxima: Vec<Sample> = Vec::new();
    if refinement.maximum_first {
        for emitter in light.emitters {
            if let Some(maximum) = brightest(receiver, emitter)? {
                maxima.push(light.sample(maximum.position, normal)?);
            }
        }
    }
    let vertices = receiver.vertices();
    let pieces: Vec<Vec<DVec3>> = if is_parallelogram(vertices) {
        vec![vertices.to_vec()]
    } else {
        let triangles = triangulate(vertices).ok_or(Error::Outline)?;
        triangles.into_iter().map(|corners| corners.map(|i| vertices[i]).to_vec()).collect()
    };
    let outlines = pieces.into_iter().flat_map(|piece| match maxima.first() {
        Some(first) => cut_at(piece, first.position, normal, receiver.size()),
        None => vec![piece],
    });
    let element = |corners| ConstantElement::new(corners, light, normal, &maxima, refinement.longest);
    let mut mesh = ConstantMesh { elements: outlines.map(element).collect::<Result<_, Error>>()?, normal };
    // The worst first, so that the mesh is the best for its number of elements where that number ends. Bits of positive numbers
    // are in their order.
    let entry = |mesh: &ConstantMesh, index: usize| (mesh.elements[index].off.to_bits(), index);
    let mut queue: BTreeSet<(u64, usize)> = (0..mesh.elements.len()).map(|index| entry(&mesh, index)).collect();
    while mesh.elements.len() < refinement.most_elements {
        let Some((_, worst)) = queue.pop_last().filter(|&(off, _)| f64::from_bits(off) > refinement.error) else { break };
        let [first, second] = mesh.elements[worst].halves();
        mesh.elements[worst] = element(first)?;
        mesh.elements.push(element(second)?);
        queue.extend([worst, mesh.elements.len() - 1].map(|index| entry(&mesh, index)));
    }
    Ok(mesh)
}

/// A piece cut at a point inside: a parallelogram into four of its kind, a triangle into three.
fn cut_at(piece: Vec<DVec3>, point: DVec3, normal: DVec3, size: f64) -> Vec<Vec<DVec3>> {
    if let [a, b, _, d] = piece[..] {
        let (u, v) = (b - a, d - a);
        let across = [v.cross(normal), u.cross(normal)];
        let [s, t] = [across[0].dot(point - a) / across[0].dot(u), across[1].dot(point - a) / across[1].dot(v)];
        let parts = |at: f64| if at > TOUCHES && at < 1.0 - TOUCHES { vec![[0.0, at], [at, 1.0]] } else { vec![[0.0, 1.0]] };
        let (along, upward) = (parts(s), parts(t));
        let corner = |s: f64, t: f64| a + u * s + v * t;
        let cell = |[s, p]: [f64; 2], [t, q]: [f64; 2]| vec![corner(s, t), corner(p, t), corner(p, q), corner(s, q)];
        return along.iter().flat_map(|&s| upward.iter().map(move |&t| cell(s, t))).collect();
    }
    let count = piece.len();
    let side = |i: usize| {
        let (a, b) = (piece[i], piece[(i + 1) % count]);
        (vec![a, b, point], normal.cross((b - a).normalize_or_zero()).dot(point - a))
    };
    let parts: Vec<(Vec<DVec3>, f64)> = (0..count).map(side).collect();
    if parts.iter().any(|(_, room)| *room < -TOUCHES * size) {
        return vec![piece];
    }
    parts.into_iter().filter(|(_, room)| *room > TOUCHES * size).map(|(outline, _)| outline).collect()
}
