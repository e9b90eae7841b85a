//! Elements: affine images of the unit square or of a triangle, in a tree over each face of a scene.
//!
//! A point of an element is `o + s u + t v`. A face that is a parallelogram is one element, any other one is cut into triangles;
//! an element is divided into four of its own shape and half its size, so that all elements of a tree have the same angles.

use std::sync::OnceLock;

use radgrad_core::{DVec3, Emission, Emitter, Linear, Polygon, Polynomial};
use radgrad_scene::{is_parallelogram, largest, smallest, triangulate};

use crate::error::Error;
use crate::mesh::basis::{Basis, POWERS};
use crate::mesh::remainder;
use crate::mesh::rule;
use crate::mesh::shape::{Shape, in_parent};

/// A part of a face, with a polynomial radiosity.
#[derive(Debug)]
pub struct Element {
    polygon: Polygon,
    shape: Shape,
    origin: DVec3,
    axes: [DVec3; 2],
    /// Vectors in the plane that give `s` and `t`.
    dual: [DVec3; 2],
    area: f64,
    centre: DVec3,
    /// Largest distance of a corner from the centre.
    radius: f64,
    /// Root mean square of the distance from the centre to powers from 0 on.
    arms: [f64; POWERS],
    /// Remainders of polynomial approximation, by a bound on a function's derivatives ([`crate::mesh::remainder`]).
    remainders: [f64; POWERS],
    face: usize,
    parent: Option<usize>,
    /// The first of the four children; they follow each other.
    pub(crate) children: Option<usize>,
    level: u32,
    /// Emitters with the functions of the basis as their emission.
    emitters: Vec<OnceLock<Emitter>>,
}

impl Element {
    fn new(polygon: Polygon, shape: Shape, face: usize, basis: &Basis) -> Result<Self, Error> {
        let v = polygon.vertices();
        let (origin, axes) = (v[0], [v[1] - v[0], v[v.len() - 1] - v[0]]);
        let normal = polygon.normal();
        let across = axes.map(|a| a.cross(normal));
        let dual = [across[1] / across[1].dot(axes[0]), across[0] / across[0].dot(axes[1])];
        let centre = match shape {
            Shape::Parallelogram => origin + 0.5 * (axes[0] + axes[1]),
            Shape::Triangle => origin + (axes[0] + axes[1]) / 3.0,
        };
        // Exact for polynomials of twice the largest power.
        let rule = match shape {
            Shape::Parallelogram => rule::product(POWERS),
            Shape::Triangle => rule::collapsed(POWERS),
        };
        let squares = rule.iter().map(|n| (n.weight, (origin + axes[0] * n.at[0] + axes[1] * n.at[1] - centre).length_squared()));
        let squares: Vec<(f64, f64)> = squares.collect();
        let mut powers = squares.clone();
        powers.iter_mut().for_each(|p| p.1 = 1.0);
        let mut arms = [1.0; POWERS];
        for arm in &mut arms {
            *arm = powers.iter().map(|(weight, power)| weight * power).sum::<f64>().sqrt();
            powers.iter_mut().zip(&squares).for_each(|(p, s)| p.1 *= s.1);
        }
        Ok(Self {
            shape,
            arms,
            remainders: remainder::bounds(shape, axes, basis.degree()),
            origin,
            axes,
            dual,
            area: polygon.area(),
            centre,
            radius: v.iter().map(|v| (*v - centre).length()).fold(0.0, largest),
            face,
            parent: None,
            children: None,
            level: 0,
            emitters: std::iter::repeat_with(OnceLock::new).take(basis.len()).collect(),
            polygon,
        })
    }

    /// The elements that a face is made of: itself if it is a parallelogram, else triangles. `face` is its index, `bases` are that
    /// of parallelograms and that of triangles.
    ///
    /// ```
    /// use radgrad_core::{DVec3, Polygon};
    /// use radgrad_solver::{Basis, Element, Shape};
    /// let bases = [Shape::Parallelogram, Shape::Triangle].map(|shape| Basis::new(shape, 1));
    /// let square = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
    /// let elements = Element::of_face(&Polygon::new(square.to_vec())?, 0, &bases)?;
    /// let quarters = elements[0].divided(0, &bases[0])?;
    /// assert_eq!((elements.len(), quarters.len(), quarters[3].area()), (1, 4, 1.0));
    /// // The first function is 1.
    /// assert_eq!(elements[0].emitter(0, &bases[0])?.polygon().area(), 4.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If the polygon cannot be cut into triangles, or these are too small for their coordinates.
    pub fn of_face(polygon: &Polygon, face: usize, bases: &[Basis; 2]) -> Result<Vec<Self>, Error> {
        let v = polygon.vertices();
        if is_parallelogram(v) {
            return Self::new(polygon.clone(), Shape::Parallelogram, face, &bases[0]).map(|element| vec![element]);
        }
        let triangles = triangulate(v).ok_or(Error::Face { face })?;
        let element = |corners: [usize; 3]| {
            let polygon = Polygon::new(corners.map(|i| v[i]).to_vec()).map_err(|source| Error::Element { face, source })?;
            Self::new(polygon, Shape::Triangle, face, &bases[1])
        };
        triangles.into_iter().map(element).collect()
    }

    /// The four children, `index` being that of this element.
    ///
    /// # Errors
    /// If they are too small for their coordinates.
    pub fn divided(&self, index: usize, basis: &Basis) -> Result<Vec<Self>, Error> {
        let child = |which: usize| {
            let vertices = self.shape.corners().iter().map(|&at| self.point(in_parent(self.shape, which, at))).collect();
            let polygon = Polygon::new(vertices).map_err(|source| Error::Element { face: self.face, source })?;
            let child = Self::new(polygon, self.shape, self.face, basis)?;
            Ok(Self { parent: Some(index), level: self.level + 1, ..child })
        };
        (0..4).map(child).collect()
    }

    /// Its polygon.
    #[must_use]
    pub const fn polygon(&self) -> &Polygon {
        &self.polygon
    }

    /// Its shape.
    #[must_use]
    pub const fn shape(&self) -> Shape {
        self.shape
    }

    /// Its area.
    #[must_use]
    pub const fn area(&self) -> f64 {
        self.area
    }

    /// Index of the face of the scene that it is a part of.
    #[must_use]
    pub const fn face(&self) -> usize {
        self.face
    }

    /// The element that it is a quarter of.
    #[must_use]
    pub const fn parent(&self) -> Option<usize> {
        self.parent
    }

    /// The first of its four children, which follow each other.
    #[must_use]
    pub const fn children(&self) -> Option<usize> {
        self.children
    }

    /// How often its face was divided to get it.
    #[must_use]
    pub const fn level(&self) -> u32 {
        self.level
    }

    /// Whether it is not divided.
    #[must_use]
    pub const fn is_leaf(&self) -> bool {
        self.children.is_none()
    }

    /// Centroid.
    #[must_use]
    pub const fn centre(&self) -> DVec3 {
        self.centre
    }

    pub(crate) const fn radius(&self) -> f64 {
        self.radius
    }

    /// A bound from below on the distance to another element: the widest gap along a few directions.
    pub(crate) fn distance_to(&self, other: &Self) -> f64 {
        let (v, w) = (self.polygon().vertices(), other.polygon().vertices());
        let gap = |direction: DVec3| {
            let range = |of: &[DVec3]| {
                of.iter()
                    .map(|p| direction.dot(*p))
                    .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h): (f64, f64), x| (smallest(l, x), largest(h, x)))
            };
            let ((a0, a1), (b0, b1)) = (range(v), range(w));
            largest(b0 - a1, a0 - b1)
        };
        let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| largest(gap(axis), 0.0));
        let boxes = DVec3::from(axes).length();
        let between = (other.centre() - self.centre()).normalize_or_zero();
        let others = [self.polygon().normal(), other.polygon().normal(), between].map(gap);
        let size = v.iter().chain(w).map(|p| p.length()).fold(0.0, largest);
        others.into_iter().fold(boxes, largest) - 1e-14 * size
    }

    /// Root mean square of the distance from the centre to a power of at most 4.
    pub(crate) const fn arm(&self, power: usize) -> f64 {
        self.arms[power]
    }

    /// The radius to a power.
    pub(crate) fn radius_to(&self, power: usize) -> f64 {
        std::iter::repeat_n(self.radius, power).product()
    }

    /// Root mean square of a function less its projection on the basis, over a bound on `|D^m f|/m!` along all directions, for m up
    /// to the basis' degree and one.
    pub(crate) const fn remainder(&self, order: usize) -> f64 {
        self.remainders[order]
    }

    pub(crate) const fn axes(&self) -> [DVec3; 2] {
        self.axes
    }

    /// The point with these reference coordinates.
    #[must_use]
    pub fn point(&self, [s, t]: [f64; 2]) -> DVec3 {
        self.origin + self.axes[0] * s + self.axes[1] * t
    }

    /// Reference coordinates of a point of the plane.
    #[must_use]
    pub fn reference(&self, point: DVec3) -> [f64; 2] {
        self.dual.map(|d| d.dot(point - self.origin))
    }

    /// By how much reference coordinates are outside the shape: at most 0 in the element.
    #[must_use]
    pub fn excess(&self, [s, t]: [f64; 2]) -> f64 {
        match self.shape {
            Shape::Parallelogram => largest(largest(largest(-s, -t), s - 1.0), t - 1.0),
            Shape::Triangle => largest(largest(-s, -t), s + t - 1.0),
        }
    }

    /// The element's radius over the distance of its centre from a point, and at most 1: there it may touch the point.
    pub(crate) fn nearness_to(&self, point: DVec3) -> f64 {
        smallest(self.radius() / (self.centre() - point).length(), 1.0)
    }

    /// Whether a point of the plane is in the element, or outside it by no more than `reach`.
    pub(crate) fn is_at(&self, point: DVec3, reach: f64) -> bool {
        self.excess(self.reference(point)) * 2.0 * self.radius() <= reach
    }

    /// A point of the plane, or from outside the one on the border on the way to the centre.
    pub(crate) fn inside(&self, point: DVec3) -> DVec3 {
        let excess = self.excess(self.reference(point));
        if excess <= 0.0 {
            return point;
        }
        // All sides are as far from the centre.
        let to_side = match self.shape {
            Shape::Parallelogram => 0.5,
            Shape::Triangle => 1.0 / 3.0,
        };
        self.centre + (point - self.centre) * (to_side / (to_side + excess))
    }

    /// Distance of a point that is `height` over the plane.
    pub(crate) fn distance(&self, point: DVec3, height: f64) -> f64 {
        if self.excess(self.reference(point)) <= 0.0 {
            return height;
        }
        let v = self.polygon.vertices();
        let to_edge = |i: usize| {
            let (a, edge) = (v[i], v[(i + 1) % v.len()] - v[i]);
            let along = ((point - a).dot(edge) / edge.length_squared()).clamp(0.0, 1.0);
            (point - a - edge * along).length()
        };
        (0..v.len()).map(to_edge).fold(f64::INFINITY, smallest)
    }

    /// Gradient over the plane of a function with these derivatives in `s` and `t`.
    #[must_use]
    pub fn gradient(&self, [along, across]: [f64; 2]) -> DVec3 {
        self.dual[0] * along + self.dual[1] * across
    }

    /// An emitter with function number `function` of the element's basis as its emission, which is one of [`Basis::len`].
    ///
    /// # Errors
    /// If the function's coefficients in space cannot be represented.
    pub fn emitter(&self, function: usize, basis: &Basis) -> Result<&Emitter, Error> {
        if let Some(emitter) = self.emitters[function].get() {
            return Ok(emitter);
        }
        let terms: Vec<(f64, [usize; 2])> = basis.monomials(function).collect();
        let emission = self.emission(&terms);
        let emitter = emission.and_then(|emission| Emitter::new(self.polygon.clone(), emission));
        let emitter = emitter.map_err(|source| Error::Element { face: self.face, source })?;
        Ok(self.emitters[function].get_or_init(|| emitter))
    }

    /// An emitter with the sum of the functions with these coefficients as its emission; absent ones are 0.
    pub(crate) fn emitter_of(&self, coefficients: &[f64], basis: &Basis) -> Result<Emitter, Error> {
        let scaled_terms =
            |(function, c): (usize, &f64)| basis.monomials(function).map(|(m, at)| (m * c, at)).collect::<Vec<_>>();
        let terms: Vec<(f64, [usize; 2])> = coefficients.iter().enumerate().flat_map(scaled_terms).collect();
        let emitter = self.emission(&terms).and_then(|emission| Emitter::new(self.polygon.clone(), emission));
        emitter.map_err(|source| Error::Element { face: self.face, source })
    }

    /// A sum of `c s^i t^j` in coordinates of space: `s = dual_0 . (y - o)`, `t = dual_1 . (y - o)`.
    fn emission(&self, terms: &[(f64, [usize; 2])]) -> Result<Emission, radgrad_core::Error> {
        let degree = terms.iter().map(|(_, [i, j])| i + j).max().unwrap_or(0);
        if degree == 0 {
            return Ok(Emission::Constant(terms.iter().map(|term| term.0).sum()));
        }
        if degree == 1 {
            let (mut value, mut gradient) = (0.0, DVec3::ZERO);
            for &(c, [i, j]) in terms {
                match (i, j) {
                    (1, 0) => gradient += c * self.dual[0],
                    (0, 1) => gradient += c * self.dual[1],
                    _ => value += c,
                }
            }
            return Ok(Emission::Linear(Linear::Gradient { value, gradient }));
        }
        let mut products: Vec<(f64, [u8; 3])> = Vec::new();
        for &(c, [i, j]) in terms {
            let factors = std::iter::repeat_n(self.dual[0], i).chain(std::iter::repeat_n(self.dual[1], j));
            let mut product = vec![(c, [0_u8; 3])];
            for factor in factors {
                product = times(&product, factor);
            }
            products.extend(product);
        }
        Ok(Emission::Polynomial(Polynomial::new(self.origin, collected(products))?))
    }
}

/// The lowest and the highest coordinates of a polygon's vertices.
pub(crate) fn around(v: &[DVec3]) -> [DVec3; 2] {
    v[1..].iter().fold([v[0]; 2], |[low, high], p| [low.min(*p), high.max(*p)])
}

/// A polynomial times `factor . r`.
fn times(terms: &[(f64, [u8; 3])], factor: DVec3) -> Vec<(f64, [u8; 3])> {
    let along = |axis: usize, component: f64| {
        terms.iter().filter(move |_| component != 0.0).map(move |&(c, mut powers)| {
            powers[axis] += 1;
            (c * component, powers)
        })
    };
    collected(factor.to_array().into_iter().enumerate().flat_map(|(axis, c)| along(axis, c)).collect())
}

/// One term for each exponent.
fn collected(mut terms: Vec<(f64, [u8; 3])>) -> Vec<(f64, [u8; 3])> {
    terms.sort_by_key(|term| term.1);
    terms.dedup_by(|next, kept| {
        let same = next.1 == kept.1;
        if same {
            kept.0 += next.0;
        }
        same
    });
    terms
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::basis::MAX_DEGREE;

    fn elements(points: &[[f64; 3]]) -> (Vec<Element>, [Basis; 2]) {
        let bases = [Shape::Parallelogram, Shape::Triangle].map(|shape| Basis::new(shape, MAX_DEGREE));
        let polygon = Polygon::new(points.iter().map(|&p| p.into()).collect()).unwrap();
        (Element::of_face(&polygon, 0, &bases).unwrap(), bases)
    }

    #[test]
    fn emitters_radiate_as_the_functions_do() {
        let tilted = [[0.0, 0.0, 1.0], [2.0, 0.0, 2.0], [2.5, 1.0, 2.25 + 0.7], [0.5, 1.0, 1.95]];
        for points in [&tilted[..], &tilted[..3]] {
            let (elements, bases) = elements(points);
            assert_eq!(elements.len(), 1);
            let (element, at) = (&elements[0], [0.31, 0.47]);
            let basis = &bases[usize::from(points.len() == 3)];
            for (function, value) in basis.values(at).into_iter().enumerate() {
                let emitted = element.emitter(function, basis).unwrap().emission_at(element.point(at));
                assert!((emitted - value).abs() < 1e-11, "{function}: {emitted} {value}");
            }
            let back = element.reference(element.point(at));
            assert!((back[0] - at[0]).abs() + (back[1] - at[1]).abs() < 1e-14);
        }
    }

    #[test]
    fn the_distance_is_that_of_the_nearest_point() {
        let (elements, _) = elements(&[[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        for point in [[0.5, 0.25, 3.0], [-3.0, 0.5, 4.0], [1.0, -2.0, 0.0], [2.0, 1.5, 0.1]].map(DVec3::from) {
            let computed = elements[0].distance(point, point.z);
            let step = |i: u32| f64::from(i) / 400.0;
            let grid = (0..=400).flat_map(|i| (0..=400 - i).map(move |j| [step(i), step(j)]));
            let nearest = grid.map(|at| (elements[0].point(at) - point).length()).fold(f64::INFINITY, smallest);
            assert!(computed <= nearest + 1e-12 && nearest - computed < 1e-4, "{point}: {computed} {nearest}");
        }
    }

    #[test]
    fn a_face_is_covered_by_its_elements_and_an_element_by_its_children() {
        let l = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 3.0, 0.0], [0.0, 3.0, 0.0]];
        let (elements, bases) = elements(&l);
        assert_eq!(elements.len(), 4);
        assert_eq!(elements.iter().map(Element::area).sum::<f64>(), 5.0);
        let children = elements[0].divided(0, &bases[1]).unwrap();
        assert!((children.iter().map(Element::area).sum::<f64>() - elements[0].area()).abs() < 1e-15);
        assert!(children.iter().all(|c| c.polygon().normal() == DVec3::Z && c.parent() == Some(0) && c.level() == 1));
    }
}
