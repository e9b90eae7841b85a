//! Integrals of polynomials over the visible region of the emitter's plane.

use radgrad_numbers::real::Real;

use crate::forms::polynomial::moments::Moments;
use crate::problem::polynomial::bivariate::Bivariate;

/// The moments, with the parts of n1 in the plane and along n2.
pub(crate) struct Within<T> {
    moments: Moments<T>,
    in_plane: [T; 2],
    facing: T,
    height: T,
}

impl<T: Real> Within<T> {
    pub(in crate::forms) const fn new(moments: Moments<T>, in_plane: [T; 2], facing: T, height: T) -> Self {
        Self { moments, in_plane, facing, height }
    }

    fn toward(&self, f: &Bivariate<T>) -> T {
        let [along_u, along_v] = self.moments.in_plane(f);
        self.in_plane[0] * along_u + self.in_plane[1] * along_v
    }

    /// `int f (n1.omega) domega`.
    pub(crate) fn irradiance(&self, f: &Bivariate<T>) -> T {
        self.height * self.toward(f) - self.facing * self.moments.facing(f)
    }

    /// The same over h, of an f that is 0 at the foot point: `int f (n1.omega)/r^3 dA`.
    pub(crate) fn radial(&self, f: &Bivariate<T>) -> T {
        self.toward(f) - self.facing * self.height * self.moments.without_constant(f)
    }
}
