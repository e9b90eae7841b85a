//! Bounds on the projection residual over an element, from the samples of its projection.
//!
//! The samples have a part of the next degree beyond the basis, exactly seen: its magnitude over the element is bounded by its
//! Bernstein coefficients. A rule that is exact for as much as it can be may see nothing at all of the degree after that, its
//! nodes being where those polynomials vanish; so three more samples are taken at other places, and the part of all samples
//! beyond the polynomials seen stands for all the degrees above. It counts twice, since the samples are not where it is largest.
//! That is an estimate: light with a feature smaller than an element, between its nodes, is not seen.
//!
//! That part oscillates: it is orthogonal to the basis up to the error of the nodes' rule, which is exact for two degrees more
//! than the square of the basis. With q the ratio of the last two degrees seen, its mean is taken to be its size times
//! `q^(degree + 2)`. Where nothing falls off, as where a shadow's edge crosses the element, an interval between two nodes
//! decides: the size times `1/(degree + 2)`.
//!
//! # The gather of the residual at a point
//! From a source, at a point with form factor F, with k the kernel times the area: `|G r|` is at most `F max|r|`; `k_max mean|r|`;
//! `(k_max - k_min)/2 mean|r| + (k_max + k_min)/2 |mean r|`, since a constant may be taken from the kernel; and
//! the rest of k after its Taylor polynomial of a degree below m at each leaf's centre. Against that rest r counts with the part
//! that polynomials of the basis leave, at most `|D^m k|/m!` times a number of the element ([`crate::mesh::remainder`]); and as
//! far as r is not orthogonal to the basis, the polynomials count too: `|D^l k|/l! d^l` for l up to m, d the distance from the
//! centre. The least counts: an oscillating residual counts for little.
//!
//! # Textures
//! With a texture r is `rho x + t`: x the projection residual of the irradiance, and the detail `t = E + rho H_h - B_h`, which is
//! known ([`crate::mesh::texture`]) and orthogonal to the basis, so that its biases are 0. Each is gathered for itself. By
//! Schwarz `mean |rho x|` is at most rho's root mean square times x's; and since x has no part along the basis `mean(rho x)` is
//! that of rho's projection residual times x, `mean(rho x d^m)` that of `(rho - mean rho) x d^m`.

use crate::bytes::bytes_of;
use crate::estimate::ledger::Ledger;
use crate::links::transfer::Kernel;
use crate::mesh::Mesh;
use crate::mesh::basis::{Basis, POWERS};
use crate::mesh::element::Element;
use crate::mesh::texture::{Detail, Pattern};
use radgrad_scene::{largest as larger, smallest as smaller};

/// Estimates of the residual over an element; of one that is divided, over those below it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Residual {
    /// Largest magnitude.
    pub(crate) largest: Ledger,
    /// Mean magnitude of the projection residual; and for each m from 1 on a bound on its gather at a point, over
    /// `|D^m k|/m!`, beside lower powers.
    pub(crate) arms: [f64; POWERS],
    /// Magnitude of the mean of the projection residual times the distance along some direction to a power.
    biases: [f64; POWERS],
    /// Root mean squares: of it, and of its part along the basis.
    rms: f64,
    along: f64,
    /// The detail of textures, which is beside all that: its largest magnitude, root mean square, and the rest as above.
    detail: f64,
    detail_rms: f64,
    detail_arms: [f64; POWERS],
    /// The mean of light that no sample saw, as far as it is expected to be there.
    pub(crate) unseen: f64,
}

/// Projection residuals on each element, by channel.
pub(crate) type Residuals = Vec<Vec<Residual>>;

impl Residual {
    /// The projection residual of samples at an element's nodes.
    pub(crate) fn project(element: &Element, basis: &Basis, samples: &[f64]) -> Self {
        let excess = basis.excess(samples);
        let discretisation = excess.magnitude();
        let mean = excess.next.hypot(2.0 * excess.spread);
        let unseen_part = basis.seen_of(&excess);
        let biases: [f64; POWERS] = std::array::from_fn(|power| unseen_part * mean * element.arm(power));
        let of_power = |power: usize| match power {
            0 => mean,
            _ => smaller(mean * element.remainder(power) + biases[power], mean * element.arm(power)),
        };
        let largest = Ledger { discretisation, ..Ledger::default() };
        Self { largest, arms: std::array::from_fn(of_power), biases, rms: mean, along: unseen_part * mean, ..Self::default() }
    }

    /// The same with a texture: samples were the irradiance times `rho`, the largest reflectance of the face.
    pub(crate) fn textured(mut self, element: &Element, pattern: &Pattern, rho: f64, detail: Detail) -> Self {
        if rho > 0.0 {
            let [rms, varies, truncation] = pattern.spread_of_reflectance().map(|spread| spread / rho);
            let (mean, mut reach) = (self.arms[0], 1.0);
            // Not orthogonal to the basis any more.
            self.along = self.rms;
            self.arms = std::array::from_fn(|power| mean * element.arm(power));
            for power in 0..POWERS {
                let beside = if power == 0 { truncation } else { varies * reach };
                self.biases[power] = smaller(self.biases[power] + beside * mean, self.arms[power]);
                reach *= element.radius();
            }
            self.arms[0] = smaller(rms, 1.0) * mean;
            self.biases[0] = smaller(self.biases[0], self.arms[0]);
        }
        self.detail = detail.largest;
        self.detail_rms = detail.mean;
        self.detail_arms = std::array::from_fn(|power| detail.mean * element.remainder(power));
        self
    }

    /// The same with light that none of `samples` samples saw, of at most this and of at most this mean. The share of the element
    /// that is lit is taken to be the expectation by the rule of succession (P. S. Laplace 1774): one over two more than the
    /// samples.
    pub(crate) fn with_unseen(mut self, element: &Element, samples: usize, [largest, mean]: [f64; 2]) -> Self {
        let mean = mean / (samples + 2) as f64;
        self.largest.discretisation += largest;
        for power in 0..POWERS {
            let more = mean * element.radius_to(power);
            self.arms[power] += more;
            self.biases[power] += more;
        }
        self.unseen += mean;
        self.rms += (mean * largest).sqrt();
        self.along += (mean * largest).sqrt();
        self
    }

    /// Mean magnitude of the detail of textures.
    pub(crate) const fn mean_detail(&self) -> f64 {
        self.detail_arms[0]
    }

    /// Largest magnitude of the detail of textures.
    pub(crate) const fn largest_detail(&self) -> f64 {
        self.detail
    }

    /// Root mean square of the detail of textures.
    pub(crate) const fn detail_rms(&self) -> f64 {
        self.detail_rms
    }

    /// Largest magnitude, with the detail of textures.
    pub(crate) fn whole(&self) -> Ledger {
        Ledger { discretisation: self.largest.discretisation + self.detail, ..self.largest }
    }

    /// Mean magnitude of the projection residual, without the detail of textures.
    pub(crate) const fn mean(&self) -> f64 {
        self.arms[0]
    }

    /// The estimates over four children of one size.
    pub(crate) fn over(children: &[Self]) -> Self {
        let part = 1.0 / children.len() as f64;
        let square = |a: f64, b: f64| (a * a + part * b * b).sqrt();
        let add = |a: [f64; POWERS], b: [f64; POWERS]| std::array::from_fn(|power| a[power] + part * b[power]);
        let join = |sum: Self, child: &Self| Self {
            largest: sum.largest.zip(child.largest, larger),
            arms: add(sum.arms, child.arms),
            biases: add(sum.biases, child.biases),
            rms: square(sum.rms, child.rms),
            along: square(sum.along, child.along),
            detail: larger(sum.detail, child.detail),
            detail_rms: square(sum.detail_rms, child.detail_rms),
            detail_arms: add(sum.detail_arms, child.detail_arms),
            unseen: sum.unseen + part * child.unseen,
        };
        children.iter().fold(Self::default(), join)
    }

    /// Those at some elements, and from there those over the elements above and for the elements below.
    pub(crate) fn everywhere(mesh: &Mesh, at: &[usize], of: Vec<Vec<Self>>, channels: usize) -> Residuals {
        let mut residuals: Vec<Option<Vec<Self>>> = vec![None; mesh.elements().len()];
        for (&element, of) in at.iter().zip(of) {
            residuals[element] = Some(of);
        }
        for index in (0..residuals.len()).rev() {
            if let (None, Some(first)) = (&residuals[index], mesh.elements()[index].children()) {
                let children: Vec<&Vec<Self>> = residuals[first..first + 4].iter().flatten().collect();
                if children.len() == 4 {
                    let merged = |channel: usize| Self::over(&[0, 1, 2, 3].map(|child| children[child][channel]));
                    residuals[index] = Some((0..channels).map(merged).collect());
                }
            }
        }
        residuals.into_iter().map(|of| of.unwrap_or_else(|| vec![Self::default(); channels])).collect()
    }

    /// The mean magnitude, but for the detail of textures.
    pub(crate) fn mean_ledger(&self) -> Ledger {
        Ledger { discretisation: smaller(self.arms[0], self.largest.discretisation), ..self.largest }
    }

    /// Bound on the gather of the residual at a point.
    pub(crate) fn gathered(&self, degree: usize, found: &Found) -> Ledger {
        let others = Ledger { discretisation: 0.0, ..self.largest } * found.factor;
        let discretisation = self.gathered_beside_detail(degree, found) + self.gathered_detail(degree, found);
        Ledger { discretisation, ..others }
    }

    /// Bound on the gather at a point of the projection residual, without the detail of textures.
    pub(crate) fn gathered_beside_detail(&self, degree: usize, found: &Found) -> f64 {
        let least = found.least(degree, self.largest.discretisation, &self.arms, &self.biases);
        if least > 0.0 && found.truncation.is_finite() {
            smaller(least, found.truncation * self.rms + found.peak * self.along)
        } else {
            least
        }
    }

    /// Bound on the gather at a point of the detail of textures.
    pub(crate) fn gathered_detail(&self, degree: usize, found: &Found) -> f64 {
        let least = found.least(degree, self.detail, &self.detail_arms, &[0.0; POWERS]);
        if least > 0.0 && found.truncation.is_finite() { smaller(least, found.truncation * self.detail_rms) } else { least }
    }
}

/// Bounds on the form factor of a source at a point, on the kernel and on its derivatives.
#[derive(Debug)]
pub(crate) struct Found {
    factor: f64,
    peak: f64,
    least: f64,
    /// Root mean square of the kernel's truncation by the source's polynomials.
    truncation: f64,
    /// Where the kernel is smooth.
    derivatives: Option<[f64; POWERS]>,
}

impl Found {
    pub(crate) fn by(factor: f64, kernel: &Kernel, truncation: f64) -> Self {
        let derivatives = (kernel.smooth && kernel.peak.is_finite()).then(|| kernel.derivatives());
        Self { factor, peak: kernel.peak, least: kernel.least, truncation, derivatives }
    }

    /// The least of the bounds on the gather.
    fn least(&self, degree: usize, largest: f64, arms: &[f64; POWERS], biases: &[f64; POWERS]) -> f64 {
        if largest == 0.0 || self.factor == 0.0 {
            return 0.0;
        }
        let (mut least, mean) = (self.factor * largest, arms[0]);
        if self.peak.is_finite() {
            let halved = 0.5 * ((self.peak - self.least) * mean + (self.peak + self.least) * biases[0]);
            least = smaller(smaller(least, self.peak * mean), halved);
        }
        if let Some(derivatives) = &self.derivatives {
            let mut lower = self.peak * biases[0];
            for order in 1..=degree + 1 {
                least = smaller(least, lower + derivatives[order] * arms[order]);
                lower += derivatives[order] * biases[order];
            }
        }
        least
    }
}

bytes_of!(Residual { largest, arms, biases, rms, along, detail, detail_rms, detail_arms, unseen });
