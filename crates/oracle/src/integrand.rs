//! Eq. 1 (HS95) and its gradient as integrands over the plane of the emitter.
//!
//! `B(x) = (rho/pi) int B(y) s h / r^4 dA`, `s = n1.r`, `h = -n2.r`, `r = y - x`. Differentiating the kernel with respect to `x`, the region
//! held fixed (`s = 0` on the horizon, so its motion adds nothing):
//! `grad B(x) = (rho/pi) int B(y) { (s n2 - h n1)/r^4 + 4 s h r/r^6 } dA`.
//! All factors of the first are positive where the emitter is seen, so it keeps its digits; the second changes sign, and near contact its
//! integral is smaller than that of its magnitude by the factor `h / size`: that many digits are lost, and the caller counts them.

use crate::region::{Region, Vertex};
use crate::source_function::Source;

/// The integrand of Eq. 1 and the three components of its gradient in the frame `(u, v, n2)`, without the factor `rho/pi`, in scaled lengths.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Integrand<'a> {
    height: f64,
    squared_height: f64,
    normal: [f64; 3],
    region: &'a Region,
    source: Source<'a>,
}

impl<'a> Integrand<'a> {
    pub(crate) fn new(region: &'a Region, source: Source<'a>) -> Self {
        let height = region.height;
        Self { height, squared_height: height * height, normal: region.normal, region, source }
    }

    /// Emission at a point of the plane.
    #[inline]
    pub(crate) fn emission(&self, at: &Vertex) -> f64 {
        match self.source {
            Source::Emitter(_) => at.b,
            Source::Function { radiosity, .. } => radiosity(self.region.point(at.p, at.q)),
        }
    }

    /// Value and gradient at a point of the plane.
    #[inline]
    pub(crate) fn at(&self, at: &Vertex) -> [f64; 4] {
        let h = self.height;
        let inverse = 1.0 / (at.p * at.p + at.q * at.q + self.squared_height);
        let weight = self.emission(at) * inverse * inverse;
        let pull = 4.0 * at.s * h * inverse;
        let [a, b, c] = self.normal;
        [
            weight * (at.s * h),
            weight * (pull * at.p - h * a),
            weight * (pull * at.q - h * b),
            weight * (at.s - pull * h - h * c),
        ]
    }
}
