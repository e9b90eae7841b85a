//! Derivatives of the light that a point receives from all of an element in free sight: by the point's place and normal, and by the
//! element's corners.
//!
//! The kernel `k = (n1.r)(-n2.r)/(pi r^4)`, `r = y - x`, has the slopes
//!
//! ```text
//! dk/dy = -dk/dx = ((-n2.r) n1 - (n1.r) n2)/(pi r^4) - 4 k r/r^2,   dk/dn1 = (-n2.r) r/(pi r^4),   dk/dn2 = -(n1.r) r/(pi r^4)
//! ```
//!
//! A corner that moves by d carries the points of the element by its hat `h(y) d`, stretches area by `dh.d` and turns n2 by
//! `-dh (n2.d)`; the polynomial stays where it is in space. So the derivative by a corner is
//! `int h (B dk/dy + k dB) + k B dh - B (dk/dn2 . dh) n2`. The integrals run over cells of the element that are small beside their
//! distance from the point.

use radgrad_core::DVec3;
use radgrad_scene::largest;

use crate::links::station::Station;
use crate::mesh::basis::{Basis, dot};
use crate::mesh::element::Element;
use crate::mesh::rule::{Node, collapsed, product};
use crate::mesh::shape::{Shape, in_parent};

/// Corners that an element has at most.
pub(super) const CORNERS: usize = 4;

/// The least distance of a cell's centre from the point over the cell's radius, and Gauss nodes a side: `3^-8` of a cell's light is 1e-4.
const FAR: f64 = 3.0;
const NODES: usize = 4;

/// How often an element is cut in four at most: a cell is then 1e-4 of it.
const MOST_CUTS: usize = 14;

/// Derivatives of the light from one element.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Slopes {
    pub(super) gradient: DVec3,
    pub(super) normal: DVec3,
    pub(super) corners: [DVec3; CORNERS],
}

/// Rules on cells of both shapes.
#[derive(Debug)]
pub(super) struct CellRules([Vec<Node>; 2]);

impl CellRules {
    pub(super) fn new() -> Self {
        Self([product(NODES), collapsed(NODES)])
    }

    fn rule(&self, shape: Shape) -> &[Node] {
        &self.0[usize::from(shape == Shape::Triangle)]
    }
}

/// The hats of an element's corners at a place, and their slopes in its coordinates.
fn hats(shape: Shape, [s, t]: [f64; 2]) -> [(f64, [f64; 2]); CORNERS] {
    match shape {
        Shape::Parallelogram => [
            ((1.0 - s) * (1.0 - t), [t - 1.0, s - 1.0]),
            (s * (1.0 - t), [1.0 - t, -s]),
            (s * t, [t, s]),
            ((1.0 - s) * t, [-t, 1.0 - s]),
        ],
        Shape::Triangle => [(1.0 - s - t, [-1.0, -1.0]), (s, [1.0, 0.0]), (t, [0.0, 1.0]), (0.0, [0.0, 0.0])],
    }
}

/// A point that receives from an element, with the polynomials of the element's light.
pub(super) struct Pair<'a> {
    pub(super) station: &'a Station,
    pub(super) element: &'a Element,
    pub(super) basis: &'a Basis,
    /// In each channel.
    pub(super) light: &'a [&'a [f64]],
}

impl Pair<'_> {
    /// In each channel.
    pub(super) fn slopes(&self, rules: &CellRules) -> Vec<Slopes> {
        let mut sums = vec![Slopes::default(); self.light.len()];
        let mut path = Vec::with_capacity(MOST_CUTS);
        self.add(rules, &mut path, &mut sums);
        sums
    }

    /// Adds the cell that is reached by these children.
    fn add(&self, rules: &CellRules, path: &mut Vec<usize>, sums: &mut [Slopes]) {
        let shape = self.element.shape();
        let place = |at: [f64; 2]| path.iter().rev().fold(at, |at, &child| in_parent(shape, child, at));
        let centre = place(if shape == Shape::Triangle { [1.0 / 3.0; 2] } else { [0.5; 2] });
        let middle = self.element.point(centre);
        let to_corner = |&corner: &[f64; 2]| (self.element.point(place(corner)) - middle).length();
        let radius = shape.corners().iter().map(to_corner).fold(0.0, largest);
        let is_near = (middle - self.station.point).length() < FAR * radius;
        if is_near && path.len() < MOST_CUTS {
            for child in 0..4 {
                path.push(child);
                self.add(rules, path, sums);
                path.pop();
            }
            return;
        }
        let part = self.element.area() * 0.25_f64.powi(path.len().try_into().unwrap_or(i32::MAX));
        let places: Vec<Node> =
            rules.rule(shape).iter().map(|node| Node { at: place(node.at), weight: part * node.weight }).collect();
        places.iter().for_each(|node| self.add_node(node, sums));
    }

    fn add_node(&self, node: &Node, sums: &mut [Slopes]) {
        let (element, [n1, n2]) = (self.element, [self.station.normal, self.element.polygon().normal()]);
        let r = element.point(node.at) - self.station.point;
        let square = r.length_squared();
        let [cos1, cos2] = [n1.dot(r), -n2.dot(r)];
        if cos1 <= 0.0 || cos2 <= 0.0 {
            return;
        }
        let unit = node.weight / (std::f64::consts::PI * square * square);
        let k = unit * cos1 * cos2;
        let by_y = (n1 * cos2 - n2 * cos1) * unit - r * (4.0 * k / square);
        let [by_n1, by_n2] = [r * (unit * cos2), r * (-unit * cos1)];
        let (values, slopes) = (self.basis.values(node.at), self.basis.slopes(node.at));
        let hats = hats(element.shape(), node.at).map(|(hat, slope)| (hat, element.gradient(slope)));
        for (sum, light) in sums.iter_mut().zip(self.light) {
            let b = dot(&values, light);
            let along = |axis: usize| light.iter().zip(&slopes).map(|(c, slope)| c * slope[axis]).sum::<f64>();
            let carried = by_y * b + element.gradient([along(0), along(1)]) * k;
            sum.gradient -= by_y * b;
            sum.normal += by_n1 * b;
            for (corner, (hat, slope)) in sum.corners.iter_mut().zip(hats) {
                *corner += carried * hat + slope * (k * b) - n2 * (b * by_n2.dot(slope));
            }
        }
    }
}
