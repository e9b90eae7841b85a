//! Which elements a round divides: those whose residual adds most to the error of gathers, or those whose polynomials are off most.
//!
//! Gathers average the residuals of polynomials; by the gradient it is the polynomials themselves that are
//! made good, `B_h` as it is drawn and exported, in the root mean square: an element counts by its area times the mean square of
//! its projection residual. An equidistributed error asks for the division of the largest of these; a division gains
//! nearly all of it.
//!
//! That mean square is estimated twice, and the mean of both counts: the larger alone marks those elements first where one of
//! them happens to have met the edge of a shadow. The samples at the nodes have a part of the next degree, and one beyond
//! ([`crate::mesh::basis`]). The gradient adds the light's variation between them (N. Holzschuch and F. X. Sillion 1995, 3.2):
//! along each edge the cubic through exact values and gradients of its ends leaves the polynomials of the basis' degree by a mean
//! square in closed form, so that neither is built ([`truncation`]). Those of a square's two directions add up, of a triangle's three
//! edges the mean counts: for quadratic light on linear elements that is exact on squares, and 5/6 to 4/3 of it on triangles.
//! From degree 3 on a cubic says nothing, and the nodes decide. Corners are moved inward, those of a square to its four Gauss
//! nodes: at an edge between two faces gradients are infinite, and there a cubic through the corners says nothing.
//!
//! Direct and reflected light are judged together where an element has both, since their residuals add up with their signs.
//! Samples are taken once: after the first round light changes by little. The detail of textures does not count: no division
//! above the size of texels takes it away, and [`Solution::textured_on`] has it.

use radgrad_core::DVec3;

use crate::error::Error;
use crate::field::Field;
use crate::links::station::Station;
use crate::mesh::shape::Shape;
use crate::solve::samples::Samples;
use crate::solve::solution::Solution;

/// Part of the way to the centre at which a corner is sampled: `1 - 1/sqrt(3)`.
const INWARD: f64 = 0.422_649_730_810_374_2;

/// Degree of the polynomial that values and gradients at two ends determine.
const CUBIC: usize = 3;

impl Solution {
    /// Samples of direct light on a leaf.
    pub(crate) fn direct_on(&self, leaf: usize) -> Result<Samples, Error> {
        let lit = &self.radiosity.direct[leaf].nodes;
        let nodes = (0..self.channels().len()).map(|channel| lit.iter().map(|lit| lit.irradiance[channel]).collect());
        let corner = |point| Ok((self.direct_at(leaf, point)?, self.direct_gradient_at(leaf, point)?));
        Ok(Samples { nodes: nodes.collect(), corners: self.at_corners(leaf, corner)? })
    }

    /// Samples of reflected light on a receiver.
    pub(crate) fn reflected_on(&self, receiver: usize) -> Result<Samples, Error> {
        let at_nodes = |channel| self.system.irradiance(&self.radiosity.field, receiver, channel);
        let weight = self.whole_weight();
        let corner = |point| {
            Ok((
                self.gathered_at((&self.radiosity.field, &weight), receiver, point)?,
                self.reflected_gradient_at(receiver, point)?,
            ))
        };
        let nodes = (0..self.channels().len()).map(at_nodes).collect();
        Ok(Samples { nodes, corners: self.at_corners(receiver, corner)? })
    }

    fn at_corners<T>(&self, element: usize, of: impl Fn(DVec3) -> Result<T, Error>) -> Result<Vec<T>, Error> {
        if self.basis(element).degree() >= CUBIC {
            return Ok(Vec::new());
        }
        let element = self.element(element);
        element.polygon().vertices().iter().map(|&corner| of(corner + (element.centre() - corner) * INWARD)).collect()
    }

    /// Mean square over an element of the projection residual of a light, relative to the mean radiosity, summed over channels.
    pub(crate) fn mean_square_residual(&self, element: usize, light: &Samples) -> f64 {
        let (basis, element) = (self.basis(element), self.element(element));
        let (lines, part): (&[[usize; 2]], f64) = match element.shape() {
            Shape::Parallelogram => (&[[0, 1], [2, 3], [1, 2], [3, 0]], 0.5),
            Shape::Triangle => (&[[0, 1], [1, 2], [2, 0]], 1.0 / 3.0),
        };
        let vertices = element.polygon().vertices();
        let of_channel = |(channel, rho): (usize, &f64)| {
            let of_line = |&[a, b]: &[usize; 2]| {
                let between = (vertices[b] - vertices[a]) * (1.0 - INWARD);
                let values = [a, b].map(|end| light.corners[end].0[channel]);
                truncation(basis.degree(), values, [a, b].map(|end| light.corners[end].1[channel].dot(between)))
            };
            let excess = basis.excess(&light.nodes[channel]);
            let by_nodes = excess.next.powi(2) + excess.spread.powi(2);
            let by_gradient = || part * lines.iter().map(of_line).sum::<f64>();
            let square = rho * rho * if light.corners.is_empty() { by_nodes } else { 0.5 * (by_gradient() + by_nodes) };
            if square > 0.0 { square / self.mean()[channel].powi(2) } else { 0.0 }
        };
        self.system.surfaces.reflectance[element.face()].iter().enumerate().map(of_channel).sum()
    }

    /// Irradiance of lamps at a point of a leaf.
    pub(super) fn direct_at(&self, leaf: usize, point: DVec3) -> Result<Vec<f64>, Error> {
        let station = Station::on(self.element(leaf), point);
        Ok(self
            .system
            .lamps
            .irradiance(&self.optics(), &self.system.surfaces, &station, self.radiosity.direct[leaf].sights())?
            .irradiance)
    }

    /// Irradiance of a light at a point of a receiver, by its links, the errors of which have these weights; like the gradient without light
    /// through clusters.
    pub(super) fn gathered_at(
        &self,
        (light, weight): (&Field, &[f64]),
        receiver: usize,
        point: DVec3,
    ) -> Result<Vec<f64>, Error> {
        let (optics, station) = (self.optics(), Station::on(self.element(receiver), point));
        let mut sums = vec![0.0; self.channels().len()];
        for link in &self.system.links[receiver] {
            let count = self.basis(link.source).len();
            let row = optics.for_light(light, link.source, weight).receive(&station, link.source, &link.sight, count)?;
            for (channel, sum) in sums.iter_mut().enumerate() {
                *sum += light.coefficients(link.source, channel).iter().zip(&row.values).map(|(c, v)| c * v).sum::<f64>();
            }
        }
        Ok(sums)
    }
}

/// Mean square over an edge of the part of a cubic above a degree. The cubic goes through values and slopes at the edge's two
/// Gauss nodes, a slope being the gradient times the way from one to the other.
///
/// With `a`, `b` as in `departure` of `radgrad-paper` and `c = (a + b)/20` the cubic's Legendre coefficients between the nodes are
/// `c1 = rise/2 - c`, `c2 = (b - a)/12` and `c3 = c`. On the edge, `sqrt(3)` times as long, the squares of those are
/// `3 (c1 + 3 c3)^2`, `9 c2^2` and `27 c3^2`; and the mean square of the Legendre polynomial of degree n is `1/(2n + 1)`.
fn truncation(degree: usize, values: [f64; 2], slopes: [f64; 2]) -> f64 {
    let rise = values[1] - values[0];
    let (a, b) = (slopes[0] - rise, slopes[1] - rise);
    let (square, cubic) = ((b - a) / 12.0, (a + b) / 20.0);
    let linear = 0.5 * rise + 2.0 * cubic;
    [linear * linear, 9.0 / 5.0 * square * square, 27.0 / 7.0 * cubic * cubic].iter().skip(degree).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_cubic_has_beyond_a_degree_is_what_its_projection_leaves_out() {
        // 2 - t + 3 t^2 + 5 t^3 on [0, 1], by 2000 midpoints and Legendre polynomials.
        let cubic = |t: f64| 2.0 - t + 3.0 * t * t + 5.0 * t * t * t;
        let slope = |t: f64| -1.0 + 6.0 * t + 15.0 * t * t;
        let ends = [0.5 * INWARD, 1.0 - 0.5 * INWARD];
        let legendre = |n: usize, x: f64| [1.0, x, 0.5 * (3.0 * x * x - 1.0), 0.5 * (5.0 * x * x * x - 3.0 * x)][n];
        let mean = |f: &dyn Fn(f64) -> f64| (0..2000).map(|k| f((f64::from(k) + 0.5) / 2000.0)).sum::<f64>() / 2000.0;
        let coefficient = |n: usize| (2 * n + 1) as f64 * mean(&|t| cubic(t) * legendre(n, 2.0 * t - 1.0));
        for degree in 0..5 {
            let expected = (degree + 1..4).map(|n| coefficient(n).powi(2) / (2 * n + 1) as f64).sum::<f64>();
            let computed = truncation(degree, ends.map(cubic), ends.map(|t| slope(t) * (1.0 - INWARD)));
            assert!((computed - expected).abs() <= 1e-4 * expected, "degree {degree}: {computed} against {expected}");
        }
    }
}
