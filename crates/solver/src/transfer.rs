//! What a point receives from an element: `G phi(x) = (1/pi) int phi(y) (n1.r)(-n2.r)/|r|^4 dA` over what it sees of it, for
//! each function of the element's basis.
//!
//! Near by and past occluders the closed forms of `radgrad-core` answer, with their bounds. Far away and in the clear a product
//! Gauss rule serves all functions at once: the integrand, continued to complex coordinates along one side of the element at a
//! time, is at most M inside a Bernstein ellipse of parameter R, so that n nodes leave `(32/15) M R^{-2(n-1)} / (1 - R^{-2})`
//! of the mean a side (L. N. Trefethen 2008, Theorem 4.5). There `|r.r| >= d^2 - tau^2 b^2` with b half the side, tau the
//! ellipse's smaller semi-axis and d the distance of the stretched element; `n2.r` is the same all over it; and a polynomial of
//! degree m grows by `R^m` at most.

use radgrad_core::{DVec3, Polygon, Receiver, Tolerance, evaluate_value};

use crate::Error;
use crate::basis::{Basis, Shape};
use crate::element::Element;
use crate::mesh::{Mesh, Sight};
use crate::rule::{self, Node};

/// Error that the far rule may have, per unit of the source's radiosity.
const FAR_TOLERANCE: f64 = 1e-12;

const FEWEST: usize = 2;
const MOST: usize = 10;

/// What the functions of an element give to a point.
#[derive(Debug, Clone, Default)]
pub(crate) struct Row {
    /// For each function.
    pub(crate) values: Vec<f64>,
    /// Bound on the error of the first function's value, the form factor.
    pub(crate) error: f64,
    /// Bound on the error of each of the other values.
    pub(crate) other_errors: f64,
    /// Largest value of the kernel over the element, in the clear, times its area: what it gives at most for a mean of 1.
    pub(crate) peak: f64,
    /// Largest slope of the kernel over the element, times its area; infinite where something may be between.
    pub(crate) slope: f64,
}

impl Row {
    /// Bound on the error of the sum of the functions with these coefficients.
    pub(crate) fn error_of(&self, coefficients: &[f64]) -> f64 {
        let of = |(i, c): (usize, &f64)| c.abs() * if i == 0 { self.error } else { self.other_errors };
        coefficients.iter().enumerate().map(of).sum()
    }
}

/// A point that receives.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Station {
    pub(crate) point: DVec3,
    pub(crate) normal: DVec3,
    pub(crate) face: usize,
}

/// A node of a far rule, with the basis there.
type FarNode = (Node, Vec<f64>);

/// Rules for the far field: for each shape and number of nodes a side.
#[derive(Debug)]
pub(crate) struct FarRules([Vec<Vec<FarNode>>; 2]);

impl FarRules {
    pub(crate) fn new(degree: usize) -> Self {
        Self([Shape::Parallelogram, Shape::Triangle].map(|shape| {
            let basis = Basis::new(shape, degree);
            let nodes = |count| match shape {
                Shape::Parallelogram => rule::product(count),
                Shape::Triangle => rule::collapsed(count),
            };
            let with_values = |node: Node| (node, basis.values(node.at));
            (0..=MOST).map(|count| nodes(count.max(1)).into_iter().map(with_values).collect()).collect()
        }))
    }
}

/// What computes transfers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Optics<'a> {
    pub(crate) mesh: &'a Mesh,
    pub(crate) far: &'a FarRules,
    /// Error that the evaluation of a function may have past occluders and near by.
    pub(crate) absolute: f64,
}

impl Optics<'_> {
    /// Adds to `row` the functions of a source that it lacks, up to `count`.
    pub(crate) fn receive(
        &self,
        row: &mut Row,
        station: &Station,
        source: usize,
        sight: &Sight,
        count: usize,
    ) -> Result<(), Error> {
        let (element, basis) = (&self.mesh.elements()[source], self.mesh.basis(source));
        if row.values.len() >= count {
            return Ok(());
        }
        if *sight == Sight::Nothing {
            row.values.resize(count, 0.0);
            return Ok(());
        }
        if row.values.is_empty() {
            (row.peak, row.slope) = peak(station, element);
            if *sight != Sight::Clear {
                row.slope = f64::INFINITY;
            }
            if *sight == Sight::Clear
                && let Some((nodes, error)) = far_nodes(station, element, basis)
            {
                row.values = far_row(station, element, &self.far.0[usize::from(element.shape() == Shape::Triangle)][nodes]);
                (row.error, row.other_errors) = (error, error);
                return Ok(());
            }
        }
        let occluders: Vec<&Polygon> = match sight {
            Sight::Past(faces) => faces.iter().map(|&face| &self.mesh.polygons()[face]).collect(),
            _ => Vec::new(),
        };
        let refused = |source| Error::Evaluation { face: station.face, source };
        let receiver = Receiver::new(station.point, station.normal, 1.0).map_err(refused)?;
        let tolerance = Tolerance { relative: 0.0, absolute: self.absolute };
        for function in row.values.len()..count {
            let emitter = element.emitter(function, basis)?;
            let value = evaluate_value(&receiver, emitter, occluders.iter().copied(), tolerance).map_err(refused)?;
            row.values.push(value.radiosity);
            let error = if function == 0 { &mut row.error } else { &mut row.other_errors };
            *error = error.max(value.radiosity_error);
        }
        Ok(())
    }
}

/// Bounds on the kernel `k = h (n1.r) / pi r^4` over an element and on the length of its gradient there, at most `(cos2 / pi r^3)
/// (1 + 4 cos1)`, both times the area.
fn peak(station: &Station, element: &Element) -> (f64, f64) {
    let vertices = element.polygon().vertices();
    let height = element.polygon().normal().dot(station.point - vertices[0]).max(0.0);
    let above = vertices.iter().map(|v| station.normal.dot(*v - station.point)).fold(0.0, f64::max);
    // Less the rounding of coordinates.
    let distance =
        element.distance(station.point, height) - 1e-12 * (element.radius() + (station.point - element.centre()).length());
    if distance <= 0.0 {
        return (f64::INFINITY, f64::INFINITY);
    }
    let (cos1, cos2) = ((above / distance).min(1.0), (height / distance).min(1.0));
    // With the rounding of a few products.
    let scale = element.area() * cos2 / (std::f64::consts::PI * distance * distance) * (1.0 + 1e-12);
    (scale * cos1, scale * (1.0 + 4.0 * cos1) / distance)
}

/// Nodes a side that the far rule needs, and its bound; `None` where it does not serve.
fn far_nodes(station: &Station, element: &Element, basis: &Basis) -> Option<(usize, f64)> {
    let vertices = element.polygon().vertices();
    let normal = element.polygon().normal();
    let height = normal.dot(station.point - vertices[0]);
    let distance = (station.point - element.centre()).length();
    let nearest = distance - element.radius();
    let is_above = |v: &DVec3| station.normal.dot(*v - station.point) > 1e-9 * distance;
    if nearest < 0.75 * element.radius() || height <= 1e-9 * distance || !vertices.iter().all(is_above) {
        return None;
    }
    let [u, v] = element.axes();
    let (halves, jacobian) = match element.shape() {
        Shape::Parallelogram => ([0.5 * u.length(), 0.5 * v.length()], false),
        Shape::Triangle => ([0.5 * u.length().max((u - v).length()), 0.5 * v.length()], true),
    };
    let scale = element.area() / std::f64::consts::PI;
    let largest = basis.largest();
    let bound = |n: usize, ratio: f64| {
        let (major, minor) = (0.5 * (ratio + 1.0 / ratio), 0.5 * (ratio - 1.0 / ratio));
        let side = |half: f64, weighted: bool| {
            let near = nearest - (major - 1.0) * half;
            let squared = near * near - minor * minor * half * half;
            if near <= 0.0 || squared <= 0.0 {
                return f64::INFINITY;
            }
            let reach = distance + element.radius() + major * half;
            let weight = if weighted { 1.0 + major } else { 1.0 };
            let grown = largest * power(ratio, basis.degree());
            weight * grown * scale * reach * height / (squared * squared)
        };
        let most = side(halves[0], jacobian) + 2.0_f64.powi(i32::from(jacobian)) * side(halves[1], false);
        32.0 / 15.0 * most / power(ratio, 2 * n - 2) / (1.0 - 1.0 / (ratio * ratio))
    };
    const RATIOS: [f64; 9] = [1.5, 2.0, 2.7, 3.6, 5.0, 7.0, 10.0, 16.0, 30.0];
    let best = |n: usize| RATIOS.iter().map(|&r| bound(n, r)).fold(f64::INFINITY, f64::min);
    let rounding = 64.0 * f64::EPSILON * scale * largest / (nearest * nearest);
    (FEWEST.max(basis.degree() + 1)..=MOST).find_map(|n| {
        let bound = best(n);
        (bound <= FAR_TOLERANCE).then_some((n, bound + rounding))
    })
}

fn far_row(station: &Station, element: &Element, rule: &[(Node, Vec<f64>)]) -> Vec<f64> {
    let height = element.polygon().normal().dot(station.point - element.polygon().vertices()[0]);
    let scale = element.area() * height / std::f64::consts::PI;
    let mut values = vec![0.0; rule[0].1.len()];
    for (node, functions) in rule {
        let r = element.point(node.at) - station.point;
        let inverse = 1.0 / r.length_squared();
        let kernel = node.weight * scale * inverse * inverse * station.normal.dot(r);
        values.iter_mut().zip(functions).for_each(|(sum, f)| *sum += f * kernel);
    }
    values
}

fn power(x: f64, n: usize) -> f64 {
    std::iter::repeat_n(x, n).product()
}

#[cfg(test)]
mod tests {
    use super::*;
    use radgrad_scene::Scene;

    #[test]
    fn the_far_rule_is_within_its_bound_of_the_closed_form() {
        let mut scene = Scene::new(["grey"]).unwrap();
        let (white, surface) = (scene.add_material("white", [0.5], [0.0]).unwrap(), scene.add_surface("all"));
        let lamps = [
            vec![[0.0, 0.0, 1.0], [0.2, 1.0, 1.1], [1.2, 1.1, 1.2], [1.0, 0.1, 1.1]],
            vec![[0.0, 0.0, 1.0], [0.2, 1.0, 1.1], [1.0, 0.1, 1.1]],
        ];
        for lamp in lamps {
            scene.add_face(surface, white, Polygon::new(lamp.into_iter().map(DVec3::from).collect()).unwrap(), None).unwrap();
        }
        let mesh = Mesh::new(&scene, 2).unwrap();
        let far = &FarRules::new(2);
        let optics = Optics { mesh: &mesh, far, absolute: 1e-9 };
        let mut far_rows = 0;
        for source in 0..2 {
            for (x, z) in [(0.3, -0.3), (2.0, -0.7), (-4.0, -1.0), (3.0, -30.0)] {
                let normal = DVec3::new(-0.05 * x, 0.1, 1.0).normalize();
                let point = DVec3::new(x, 0.4, z);
                let station = Station { point, normal, face: 7 };
                let count = mesh.basis(source).len();
                let row = |sight: Sight| {
                    let mut row = Row::default();
                    optics.receive(&mut row, &station, source, &sight, count).unwrap();
                    row
                };
                // A face that is behind the lamp leaves the closed form in place.
                let (fast, exact) = (row(Sight::Clear), row(Sight::Past(Vec::new())));
                far_rows += usize::from(fast.values != exact.values);
                for (a, b) in fast.values.iter().zip(&exact.values) {
                    assert!((a - b).abs() <= fast.error + exact.error + exact.other_errors, "{x} {z} {a:?} {b:?} {}", fast.error);
                }
                assert!(exact.values[0] <= exact.peak && exact.slope.is_infinite() && fast.slope.is_finite());
                assert!(fast.error <= 1e-9);
            }
        }
        assert!(far_rows >= 2, "{far_rows}");
    }
}
