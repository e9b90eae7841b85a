//! The gradient of one exact gather within the plane of an element, without bound.

use radgrad_core::{DVec3, Receiver, evaluate_to, gradient};

use crate::error::Error;
use crate::mesh::Sight;
use crate::mesh::basis::Basis;
use crate::mesh::element::Element;
use crate::mesh::rule::{self, Node};
use crate::mesh::shape::Shape;
use crate::solve::solution::Solution;

/// Nodes a side of the rule for gradients from afar, and the distance from the source in its radii from which it serves: there it
/// leaves about 1e-8 of the gradient.
const FAR_NODES: usize = 6;
const FAR: f64 = 4.0;

impl Solution {
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
fn from_afar(point: DVec3, normal: DVec3, source: &Element, basis: &Basis, count: usize) -> Vec<DVec3> {
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
