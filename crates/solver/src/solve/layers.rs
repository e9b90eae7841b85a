//! Light that falls off along the rim of an element, between its nodes.
//!
//! Over a source that is near, irradiance changes within a strip along the rim that is as wide as the gap: half of the source is beyond it.
//! If the gap is a small part of the element no node is in the strip, and samples say nothing of it. But in free sight the form factor
//! has a closed form. The *layer* of a source is its form factor less the polynomial of its samples; a rule whose panels are graded
//! towards the rim, down to the gap, integrates it and the product of two layers. A source counts by the mean of its light.

use radgrad_core::{Tolerance, evaluate_value};
use radgrad_scene::{gauss_legendre, smallest};

use crate::error::Error;
use crate::links::link::Link;
use crate::links::station::Station;
use crate::links::transfer::{Optics, Row};
use crate::mesh::Sight;
use crate::mesh::basis::{Basis, dot};
use crate::mesh::element::Element;
use crate::mesh::rule::Node;
use crate::mesh::shape::Shape;

/// There are layers where a source that faces the element, whose normals' cosine is below the second number, is closer than the first part
/// of its radius. Then those of all sources closer than the third part count, which may be seen past the rim of that one.
const NEAR: f64 = 0.5;
const FACING: f64 = -0.7;
const BESIDE: f64 = 2.0;

/// By how much panels become smaller towards the rim, and how often at most: down to a thousandth of the element.
const GRADED: f64 = 0.25;
const MOST_PANELS: u32 = 6;

/// Gauss nodes of a panel.
const ORDER: usize = 2;

/// Error that form factors of the rule may have.
const ROUGH: f64 = 1e-9;

/// Light of near sources in free sight that the nodes of an element miss.
pub(super) struct Layers<'a> {
    /// The rule: weights, and values of the functions up to the next degree.
    weights: Vec<f64>,
    functions: Vec<Vec<f64>>,
    layers: Vec<Layer<'a>>,
}

/// The form factor of a source less the polynomial of its samples, at the rule's places.
struct Layer<'a> {
    link: &'a Link,
    truncation: Vec<f64>,
}

impl<'a> Layers<'a> {
    /// Those of the sources that a receiver is linked to; `None` if none is near.
    pub(super) fn near_receiver(optics: &Optics<'_>, receiver: usize, links: &'a [Link]) -> Result<Option<Self>, Error> {
        let (mesh, element, basis) = (optics.mesh, &optics.mesh.elements()[receiver], optics.mesh.basis(receiver));
        let Some(above) = basis.above() else { return Ok(None) };
        let part = |link: &Link| element.distance_to(&mesh.elements()[link.source]) / element.radius();
        let near = links.iter().filter(|link| matches!(link.sight, Sight::Clear)).map(|link| (link, part(link)));
        let near: Vec<(&'a Link, f64)> = near.filter(|(_, part)| *part < BESIDE).collect();
        let faces = |link: &Link| element.polygon().normal().dot(mesh.elements()[link.source].polygon().normal()) < FACING;
        let nearest = near.iter().filter(|(link, part)| *part < NEAR && faces(link)).map(|(_, part)| *part).reduce(smallest);
        let Some(nearest) = nearest else { return Ok(None) };
        let rule = graded(element.shape(), nearest);
        let functions: Vec<Vec<f64>> = rule.iter().map(|node| above.values(node.at)).collect();
        let of_source = |(link, _): (&'a Link, f64)| {
            let samples: Vec<f64> = link.rows.iter().map(|row: &Row| row.values[0]).collect();
            let polynomial = above.project(&samples);
            let truncation = rule.iter().zip(&functions).map(|(node, functions)| {
                Ok(factor(element, node.at, &mesh.elements()[link.source], mesh.basis(link.source))?
                    - dot(&polynomial, functions))
            });
            Ok(Layer { link, truncation: truncation.collect::<Result<_, Error>>()? })
        };
        let layers = near.into_iter().map(of_source).collect::<Result<_, Error>>()?;
        Ok(Some(Self { weights: rule.into_iter().map(|node| node.weight).collect(), functions, layers }))
    }

    /// The sum of the layers of a light, of which the nodes gather `at_nodes`. Past the rim of a source the element is taken to see the mean
    /// brightness that nodes see beside the sources.
    pub(super) fn truncation(&self, at_nodes: &[f64], basis: &Basis, light: impl Fn(usize) -> &'a [f64]) -> Vec<f64> {
        let (mut others, mut beside) = (0.0, 0.0);
        for ((node, irradiance), place) in basis.nodes().iter().zip(at_nodes).zip(0..) {
            let near_and_factor = |layer: &Layer<'_>| {
                let row = &layer.link.rows[place];
                (dot(light(layer.link.source), &row.values), row.values[0])
            };
            let (near, factor) =
                self.layers.iter().map(near_and_factor).fold((0.0, 0.0), |sum, next| (sum.0 + next.0, sum.1 + next.1));
            others += node.weight * (irradiance - near);
            beside += node.weight * (1.0 - factor);
        }
        // Where the sources fill the view, the remainder is rounding.
        let past = if beside > ROUGH { others / beside } else { 0.0 };
        let mut values = vec![0.0; self.weights.len()];
        for layer in &self.layers {
            let more = light(layer.link.source)[0] - past;
            values.iter_mut().zip(&layer.truncation).for_each(|(value, truncation)| *value += more * truncation);
        }
        values
    }

    /// The mean over the element of a polynomial times a sum of layers.
    pub(super) fn times(&self, polynomial: &[f64], truncation: &[f64]) -> f64 {
        let terms = self.weights.iter().zip(&self.functions).zip(truncation);
        terms.map(|((weight, functions), truncation)| weight * dot(polynomial, functions) * truncation).sum()
    }

    /// The mean over the element of the product of two sums of layers.
    pub(super) fn product(&self, a: &[f64], b: &[f64]) -> f64 {
        self.weights.iter().zip(a).zip(b).map(|((weight, a), b)| weight * a * b).sum()
    }
}

/// The form factor of a source in free sight from a place of an element.
fn factor(element: &Element, at: [f64; 2], source: &Element, basis: &Basis) -> Result<f64, Error> {
    let station = Station::on(element, element.point(at));
    let tolerance = Tolerance { relative: 0.0, absolute: ROUGH };
    let value = evaluate_value(&station.receiver()?, source.emitter(0, basis)?, [], tolerance);
    Ok(value.map_err(|source| station.refused(source))?.radiosity)
}

/// A rule over a shape, graded towards the rim down to this part of it: on the triangles between its centre and its
/// edges, graded towards the edge and along that towards both ends.
fn graded(shape: Shape, part: f64) -> Vec<Node> {
    let across = towards_zero(part);
    let along: Vec<(f64, f64)> =
        across.iter().flat_map(|&(x, weight)| [(0.5 * x, 0.5 * weight), (1.0 - 0.5 * x, 0.5 * weight)]).collect();
    let (corners, [s, t]) = (shape.corners(), shape.centre());
    let part = 1.0 / corners.len() as f64;
    let mut rule = Vec::new();
    for (i, from) in corners.iter().enumerate() {
        let to = corners[(i + 1) % corners.len()];
        for &(u, of_u) in &along {
            let on_rim = [0, 1].map(|axis| from[axis] + u * (to[axis] - from[axis]));
            for &(v, of_v) in &across {
                let place = [on_rim[0] + v * (s - on_rim[0]), on_rim[1] + v * (t - on_rim[1])];
                rule.push(Node { at: place, weight: part * 2.0 * (1.0 - v) * of_u * of_v });
            }
        }
    }
    rule
}

/// Gauss rules on panels of [0, 1] that become smaller towards 0, down to this part.
fn towards_zero(part: f64) -> Vec<(f64, f64)> {
    let (mut rule, mut to) = (Vec::new(), 1.0);
    for panel in 0..=MOST_PANELS {
        let is_last = panel == MOST_PANELS || panel > 0 && to <= part;
        let from = if is_last { 0.0 } else { GRADED * to };
        let on_panel = |(x, weight): &(f64, f64)| (from + (to - from) * (0.5 + 0.5 * x), 0.5 * weight * (to - from));
        rule.extend(gauss_legendre(ORDER).iter().map(on_panel));
        if is_last {
            break;
        }
        to = from;
    }
    rule
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shape::moment;

    #[test]
    fn the_graded_rule_is_exact_for_cubics_and_sees_a_strip_along_the_rim() {
        for shape in [Shape::Parallelogram, Shape::Triangle] {
            for part in [0.0, 1e-3, 0.05, 0.4] {
                let rule = graded(shape, part);
                let mean = |f: &dyn Fn([f64; 2]) -> f64| rule.iter().map(|node| node.weight * f(node.at)).sum::<f64>();
                for [i, j] in [[0_u8, 0], [1, 0], [0, 2], [1, 1]] {
                    let computed = mean(&|[s, t]| s.powi(i.into()) * t.powi(j.into()));
                    let exact = moment(shape, i.into(), j.into());
                    assert!((computed - exact).abs() < 1e-14, "{shape:?} {part} {i} {j}: {computed} {exact}");
                }
                // Over one edge of a half-plane at that height.
                if part > 0.0 {
                    let computed = mean(&|[_, t]| 1.0 - t / t.hypot(part));
                    let exact = match shape {
                        Shape::Parallelogram => 1.0 - (1.0_f64.hypot(part) - part),
                        Shape::Triangle => {
                            let root = 1.0_f64.hypot(part);
                            1.0 - 2.0 * ((root - part) - 0.5 * (root - part * part * (1.0 / part).asinh()))
                        }
                    };
                    assert!((computed / exact - 1.0).abs() < 0.02, "{shape:?} {part}: {computed} {exact}");
                }
            }
        }
    }
}
