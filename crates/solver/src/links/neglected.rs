//! The light that links neglect of a field.

use radgrad_scene::smallest;

use crate::field::Field;
use crate::links::transfer::{Kernel, Row};
use crate::mesh::Mesh;

impl Field {
    /// Bound on the light that a link to `source` neglects, at the node of `row`: the part of the leaves' radiosity beyond the
    /// source's polynomial, to which all polynomials of the basis are orthogonal.
    ///
    /// With m its largest magnitude and s its root mean square the gather of it is at most `F m`; `(k_max - k_min) s/2`, since a
    /// constant may be taken from the kernel k; and s times the remainder of the best polynomial for k, by `|D^j k|/j!` for j up to
    /// `degree + 1` ([`crate::mesh::remainder`]).
    pub(crate) fn neglected(&self, mesh: &Mesh, source: usize, channel: usize, row: &Row) -> f64 {
        let (most, rms) = (self.left_out(source, channel), self.left_out_rms(source, channel));
        if most == 0.0 || rms == 0.0 || row.factor() == 0.0 {
            return 0.0;
        }
        let smoothly = self.smoothly_neglected(mesh, source, channel, &row.kernel);
        smallest(smallest(row.factor() * most, smoothly), row.truncation() * rms)
    }

    /// The same for a source that has no row, by a bound on its form factor and by its kernel.
    pub(crate) fn neglected_by(&self, mesh: &Mesh, source: usize, channel: usize, (factor, kernel): (f64, &Kernel)) -> f64 {
        let smoothly = self.smoothly_neglected(mesh, source, channel, kernel);
        smallest(factor * self.left_out(source, channel), smoothly)
    }

    /// The same by the kernel alone.
    pub(crate) fn smoothly_neglected(&self, mesh: &Mesh, source: usize, channel: usize, kernel: &Kernel) -> f64 {
        let rms = self.left_out_rms(source, channel);
        if rms == 0.0 {
            return 0.0;
        }
        let (basis, element) = (mesh.basis(source), &mesh.elements()[source]);
        let mut least = 0.5 * (kernel.peak - kernel.least) * rms;
        if kernel.smooth {
            for order in 1..=basis.degree() + 1 {
                least = smallest(least, kernel.derivative(order) * element.remainder(order) * rms);
            }
        }
        least
    }
}
