//! The residual of a piecewise polynomial radiosity, `r = E + rho G B_h - B_h`, over a leaf.
//!
//! `B_h` is the projection of `E + rho G B_h`, sampled at the leaf's nodes, so r has three parts. What the links neglect and the
//! bounds of the evaluations are proven at the nodes, and are taken to be the same between them. What the solver left, the
//! difference of two polynomials, is proven all over the leaf. The third part, what the projection leaves out, is estimated.
//! The samples have a part of the next degree beyond the basis, exactly seen: its magnitude over the leaf is bounded by its
//! Bernstein coefficients. A rule that is exact for as much as it can be may see nothing at all of the degree after that, its
//! nodes being where those polynomials vanish; so three more samples are taken at other places, and what all samples have beyond
//! the polynomials seen stands for all the degrees above. It counts twice, since the samples are not where it is largest. That
//! is an estimate: light with a feature smaller than an element, between its nodes, is not seen.
//!
//! The third part oscillates: its mean over the leaf is 0 up to the error of the nodes' rule, which is exact for two degrees
//! more than the square of the basis. With q the ratio of the last two degrees seen, that mean is taken to be the part's size
//! times `q^(degree + 2)`. Where nothing falls off, as where a shadow's edge crosses the leaf, an interval between two nodes
//! decides: the size times `1/(degree + 2)`.
//!
//! On a leaf with textures r is `rho` times what the projection of the irradiance leaves out, and the texture's detail, which is
//! known (module `texture`). The mean of the first is that of the product with what the projection of rho leaves out, since the
//! irradiance's rest has no part along the basis.

use crate::field::Field;
use crate::gathering::irradiance;
use crate::ledger::Ledger;
use crate::link::Link;
use crate::mesh::{Mesh, Sight};
use crate::surfaces::Surfaces;
use crate::texture::Detail;

/// Bounds on the residual over an element; of one that is divided, over the leaves below it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Residual {
    /// Largest magnitude.
    pub(crate) largest: Ledger,
    /// Mean magnitude of what the projection leaves out.
    pub(crate) mean: f64,
    /// The same, each leaf times the radius of the leaf.
    pub(crate) arm: f64,
    /// Magnitude of its mean over each leaf.
    pub(crate) bias: f64,
    /// What of it is the detail of textures.
    pub(crate) texture: Detail,
}

impl Residual {
    /// Bounds over a leaf in a channel.
    pub(crate) fn of(mesh: &Mesh, surfaces: &Surfaces, links: &[Link], field: &Field, leaf: usize, channel: usize) -> Self {
        let (element, basis) = (&mesh.elements()[leaf], mesh.basis(leaf));
        let [_, rho] = surfaces.reflectance_on(mesh, leaf, channel);
        let emitted = surfaces.emitted[element.face()][channel];
        let at_nodes = irradiance(mesh, field, links, channel, basis.nodes().len());
        let samples: Vec<f64> = at_nodes.iter().map(|h| rho * h).collect();

        let held = field.of(leaf, channel, basis.len());
        let projected = surfaces.radiosity(mesh, leaf, channel, &at_nodes);
        let left: Vec<f64> = projected.iter().zip(held).map(|(p, b)| p - b).collect();

        let excess = basis.excess(&samples);
        let ratio = if excess.next < excess.last { excess.next / excess.last } else { 1.0 };
        let mut discretisation = excess.largest + 2.0 * excess.beyond;
        let mut mean = excess.next.hypot(2.0 * excess.spread);
        let falls = std::iter::repeat_n(ratio, basis.degree() + 2).product::<f64>();
        let mut bias = mean * falls.min(1.0 / (basis.degree() + 2) as f64);

        let mut texture = Detail::default();
        if let Some(pattern) = surfaces.pattern(leaf, channel) {
            texture = pattern.detail(basis, &basis.project(&at_nodes), &projected);
            if rho > 0.0 {
                // What was sampled is the irradiance times the largest reflectance.
                let [rms, beyond] = pattern.spread_of_reflectance().map(|spread| spread / rho);
                (mean, bias) = (rms * mean, bias + beyond * mean);
            }
            discretisation += texture.largest;
            mean += texture.mean;
        }

        let (mut computation, mut visibility): (f64, f64) = (0.0, 0.0);
        for (node, sample) in samples.iter().enumerate() {
            let (mut neglected, mut clear, mut past) = (0.0, 0.0, 0.0);
            for link in links {
                let row = &link.rows[node];
                neglected += field.neglected(mesh, link.source, link.count, channel, row);
                let coefficients = &field.of(link.source, channel, mesh.basis(link.source).len())[..link.count];
                let size = row.error_of(coefficients);
                if matches!(link.sight, Sight::Past(_)) { past += size } else { clear += size }
            }
            // The sums themselves round.
            let summed = 2.0 * f64::EPSILON * (links.len() + 2) as f64 * (sample.abs() + emitted);
            computation = computation.max(rho * (neglected + clear) + summed);
            visibility = visibility.max(rho * past);
        }
        let largest = Ledger { modelling: 0.0, discretisation, computation, visibility, solver: basis.magnitude(&left) };
        Self { largest, mean, arm: mean * element.radius(), bias, texture }
    }

    /// The bounds over four children of one size.
    pub(crate) fn over(children: &[Self]) -> Self {
        let part = 1.0 / children.len() as f64;
        let join = |sum: Self, child: &Self| Self {
            largest: sum.largest.zip(child.largest, f64::max),
            mean: sum.mean + part * child.mean,
            arm: sum.arm + part * child.arm,
            bias: sum.bias + part * child.bias,
            texture: Detail {
                largest: sum.texture.largest.max(child.texture.largest),
                mean: sum.texture.mean + part * child.texture.mean,
            },
        };
        children.iter().fold(Self::default(), join)
    }
}
