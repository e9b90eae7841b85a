//! The integrals of appendix A along one edge, `r(t) = r_i + t e_i`, t in [0, 1]:
//!
//! ```text
//! I1 = int dt/r^2    J1 = int t dt/r^2    K1 = int ln r dt
//! I2 = int dt/r^4    J2 = int t dt/r^4    K2 = int t^2 dt/r^4
//! ```
//!
//! Lengths are in a unit near the distance (K1 depends on it, by a constant that the closed contour cancels). The closed forms
//! lose digits where the edge is short beside its distance, `(r/e)^2` in J1 and I2 and `(r/e)^4` in K2, and where `x` is near
//! the edge's line.

use radgrad_core::{DVec3, Error};

use crate::appendix::misprint::{Misprint, Misprints};

/// One edge as seen from the receiver, with its integrals.
#[derive(Debug)]
pub(super) struct AppendixEdge {
    /// `r_i = E_i - x`.
    pub(super) r: DVec3,
    /// `e_i = E_{i+1} - E_i`.
    pub(super) e: DVec3,
    /// `w_i = r_i x e_i`.
    pub(super) w: DVec3,
    pub(super) i1: f64,
    pub(super) i2: f64,
    pub(super) j1: f64,
    pub(super) j2: f64,
    pub(super) k1: f64,
    pub(super) k2: f64,
}

impl AppendixEdge {
    /// Edge `index`, from its start, its end and the vertex after it (which only a misprint needs), as seen from `x`.
    pub(super) fn new(index: usize, [r, r_next, r_after]: [DVec3; 3], misprints: Misprints<'_>) -> Result<Self, Error> {
        let (e, w) = (r_next - r, r.cross(r_next - r));
        let w_length = w.length();
        if w_length == 0.0 {
            return Err(Error::OnEdgeLine { edge: index });
        }
        let (rr, ss, ee) = (r.length_squared(), r_next.length_squared(), e.length_squared());
        let (re, se) = (r.dot(e), r_next.dot(e));
        let angle = libm::atan2(w_length, r.dot(r_next));
        let gamma = if misprints.planted(Misprint::SineForAngle) { libm::sin(angle) } else { angle };

        let i1 = gamma / w_length;
        let half = misprints.choose(Misprint::I2NotHalved, 0.5, 1.0);
        let i2 = half / (w_length * w_length) * (se / ss - re / rr + ee * i1);
        let ends = misprints.choose(Misprint::J2EndsExchanged, 1.0, -1.0) * (1.0 / rr - 1.0 / ss);
        let j2 = (ends - 2.0 * i2 * re) / (2.0 * ee);
        let k2 = (i1 - rr * i2 - misprints.choose(Misprint::K2NotDoubled, 2.0, 1.0) * re * j2) / ee;

        let printed = [ee, (r_after - r_next).length_squared()];
        let [near, far] = misprints.choose(Misprint::J1Logarithm, [rr, ss], printed);
        let sign = misprints.choose(Misprint::J1Sign, -1.0, 1.0);
        let j1 = (0.5 * libm::log(far / near) + sign * re * i1) / ee;
        let [near, far] = misprints.choose(Misprint::K1Logarithm, [rr, ss], printed);
        let double = misprints.choose(Misprint::K1AngleNotDoubled, 2.0, 1.0);
        let constant = misprints.choose(Misprint::K1Constant, 1.0, 0.0);
        let k1 = (se * libm::log(far) - re * libm::log(near) + double * w_length * gamma) / (2.0 * ee) - constant;
        Ok(Self { r, e, w, i1, i2, j1, j2, k1, k2 })
    }
}
