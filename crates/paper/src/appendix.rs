//! Appendix A of Holzschuch and Sillion 1995 (HS95): radiosity and gradient of a constant or linear emitter, unoccluded.
//!
//! Corrected, this is a second implementation of [`radgrad_core::radiosity_and_gradient`], with other sums in another order and with X1
//! and X2 by quadrature, so that the two may be compared. With a [`Misprint`] planted it is a fault that the audit must catch;
//! [`as_printed`] is the appendix to the letter. Symbols are the paper's: `r_i = E_i - x`, `e_i = E_{i+1} - E_i`, `w_i = r_i x
//! e_i`, `k = grad B(y) x n2`, and I1 I2 J1 J2 K1 K2 X1 X2. With `c = n2.(n1 x k)`:
//!
//! ```text
//!  2pi/rho B      = - n1.sum (B_i I1 + dB_i J1) w_i - (n1.n2) sum (k.e_i) K1 + c (n2.r_0) X1
//! -2pi/rho grad B =   sum (B_i I1 + dB_i J1) (n1 x e_i)
//!                   + 2 sum (n1.w_i) [B_i (I2 r_i + J2 e_i) + dB_i (J2 r_i + K2 e_i)]
//!                   - (n1.n2) sum (k.e_i) (I1 r_i + J1 e_i)
//!                   - c (n2.r_0) n2 x sum I1 e_i + c (X1 - 2 (n2.r_0)^2 X2) n2
//! ```
//!
//! The paper's emitter is above the receiver's horizon. Where the horizon cuts it the sums run over the part above: the integrand
//! vanishes on the cut, so that its moving with `x` adds nothing to the gradient.
//!
//! Units as in the paper: B in W/m2, its gradient in W/m3 with respect to `x` at fixed `n1`. Plain double precision with no
//! bound: 1e-15 where the distance D is about the size s of the emitter. Measured beyond, with u = 1e-16: far away, `u D/s` of
//! a constant emitter's value and `u (D/s)^2` of its gradient, `u (D/s)^3` of a linear one's both; at height h over the
//! emitter, tilted, `u (s/h)^2` of the gradient.

mod edge;
mod horizon;
mod misprint;
mod surface;

use radgrad_core::{DVec3, Emission, Emitter, Error, Receiver};
use radgrad_numbers::power::normalising_power;

pub use crate::appendix::misprint::Misprint;

use crate::appendix::edge::AppendixEdge;
use crate::appendix::horizon::Vertex;
use crate::appendix::misprint::Misprints;

/// Radiosity and gradient by appendix A, corrected, or with one `misprint` planted.
///
/// Both are 0 where the receiver is behind the emitter or in its plane, or the whole emitter is below the horizon.
///
/// # Errors
/// If the receiver is on the line of an edge to within rounding (the denominators vanish), or a result overflows.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver};
/// use radgrad_paper::appendix;
/// let triangle = Polygon::new(vec![DVec3::Z, DVec3::new(0.5, 0.8, 1.0), DVec3::new(1.0, 0.0, 1.0)])?;
/// let emitter = Emitter::new(triangle, Emission::Constant(1.0))?;
/// let receiver = Receiver::new(DVec3::new(0.5, 0.3, 0.0), DVec3::Z, 1.0)?;
/// let (radiosity, _) = appendix::radiosity_and_gradient(&receiver, &emitter, None)?;
/// assert!((radiosity - 0.1105071695519828).abs() < 1e-16);
/// # Ok::<(), radgrad_core::Error>(())
/// ```
pub fn radiosity_and_gradient(receiver: &Receiver, emitter: &Emitter, misprint: Option<Misprint>) -> Result<(f64, DVec3), Error> {
    evaluate(receiver, emitter, Misprints(misprint.as_slice()))
}

/// Radiosity and gradient by appendix A with all its misprints at once. Those of Eqs. 9 and 11 are not among them: the
/// appendix's sums do not repeat them.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, radiosity};
/// use radgrad_paper::appendix;
/// let triangle = Polygon::new(vec![DVec3::Z, DVec3::new(0.5, 0.8, 1.0), DVec3::new(1.0, 0.0, 1.0)])?;
/// let emitter = Emitter::new(triangle, Emission::at_vertices(vec![1.0, 2.0, 4.0]))?;
/// let receiver = Receiver::new(DVec3::new(0.5, 0.3, 0.0), DVec3::new(0.2, 0.0, 1.0), 1.0)?;
/// let (printed, exact) = (appendix::as_printed(&receiver, &emitter)?.0, radiosity(&receiver, &emitter)?);
/// assert!((printed - exact).abs() > 0.01 * exact, "the misprints of J1 and K1 show");
/// # Ok::<(), radgrad_core::Error>(())
/// ```
///
/// # Errors
/// As [`radiosity_and_gradient`].
pub fn as_printed(receiver: &Receiver, emitter: &Emitter) -> Result<(f64, DVec3), Error> {
    evaluate(receiver, emitter, Misprints(Misprint::APPENDIX))
}

fn evaluate(receiver: &Receiver, emitter: &Emitter, misprints: Misprints<'_>) -> Result<(f64, DVec3), Error> {
    if let Emission::Polynomial(_) = emitter.emission() {
        return Err(Error::EmissionKind { quantity: "appendix A", needed: "constant or linear", given: "polynomial" });
    }
    let vertices = emitter.polygon().vertices();
    let x = receiver.position();
    let height = emitter.polygon().normal().dot(x - vertices[0]);
    if height == 0.0 || (height < 0.0 && !misprints.planted(Misprint::BackFaceCounted)) {
        return Ok((0.0, DVec3::ZERO));
    }
    // Lengths in a unit near the distance: r^-4 then keeps its exponent range at any scale, and powers of two cost no digits.
    let power = normalising_power(vertices.iter().map(|v| (*v - x).abs().max_element()).fold(0.0, f64::max));
    let whole: Vec<Vertex> = vertices.iter().map(|v| Vertex { r: (*v - x) * power, b: emitter.emission_at(*v) }).collect();
    let visible =
        if misprints.planted(Misprint::HorizonIgnored) { whole } else { horizon::part_above(&whole, receiver.normal()) };
    if visible.is_empty() {
        return Ok((0.0, DVec3::ZERO));
    }
    let k = if misprints.planted(Misprint::TriangleK) { printed_k(emitter) } else { k(emitter) };
    let sums = AppendixSums::new([receiver.normal(), emitter.polygon().normal(), k / power], &visible, misprints)?;
    let factor = receiver.reflectance() / misprints.choose(Misprint::ValueDoubled, 2.0, 1.0) / std::f64::consts::PI;
    let radiosity = factor * sums.value();
    let sign = misprints.choose(Misprint::Equation9Sign, 1.0, -1.0);
    let gradient = sign * receiver.reflectance() / (2.0 * std::f64::consts::PI) * sums.gradient() * power;
    match (radiosity.is_finite(), gradient.is_finite()) {
        (true, true) => Ok((radiosity, gradient)),
        (false, _) => Err(Error::Overflow { quantity: "radiosity" }),
        (_, false) => Err(Error::Overflow { quantity: "gradient" }),
    }
}

/// `k = grad B x n2`, so that `grad B = n2 x k`.
fn k(emitter: &Emitter) -> DVec3 {
    emitter.emission_gradient().cross(emitter.polygon().normal())
}

/// `k = [(B_2 - B_0) e_0 + (B_1 - B_0) e_2] / 2A`: the same for three vertices only.
fn printed_k(emitter: &Emitter) -> DVec3 {
    let vertices = emitter.polygon().vertices();
    let [b_0, b_1, b_2] = [0, 1, 2].map(|i| emitter.emission_at(vertices[i]));
    let [e_0, e_2] = [0, 2].map(|i| vertices[(i + 1) % vertices.len()] - vertices[i]);
    let twice_area = 2.0 * emitter.polygon().area();
    (b_2 - b_0) / twice_area * e_0 + (b_1 - b_0) / twice_area * e_2
}

/// The edges and constants of the appendix's sums, lengths in the normalised unit.
struct AppendixSums<'a> {
    n1: DVec3,
    n2: DVec3,
    k: DVec3,
    /// `c = n2.(n1 x k)`: where it is 0 there are no surface integrals.
    c: f64,
    x1: f64,
    x2: f64,
    edges: Vec<AppendixEdge>,
    /// `B_i`, emission at vertex i.
    b: Vec<f64>,
    misprints: Misprints<'a>,
}

impl<'a> AppendixSums<'a> {
    fn new([n1, n2, k]: [DVec3; 3], visible: &[Vertex], misprints: Misprints<'a>) -> Result<Self, Error> {
        let count = visible.len();
        let r = |i: usize| visible[i % count].r;
        let summed = count - misprints.choose(Misprint::LastEdgeMissing, 0, 1);
        let edges: Vec<AppendixEdge> =
            (0..summed).map(|i| AppendixEdge::new(i, [r(i), r(i + 1), r(i + 2)], misprints)).collect::<Result<_, _>>()?;
        let c = n2.dot(n1.cross(k));
        let (x1, x2) = if c == 0.0 { (0.0, 0.0) } else { surface::x1_x2(&edges, n2) };
        let x1 = misprints.choose(Misprint::X1Missing, x1, 0.0);
        Ok(Self { n1, n2, k, c, x1, x2, edges, b: visible.iter().map(|v| v.b).collect(), misprints })
    }

    /// `delta B_i = B_{i+1} - B_i`.
    fn delta(&self, i: usize) -> f64 {
        let value = |j: usize| self.b[j % self.b.len()];
        if self.misprints.planted(Misprint::DeltaOfPreviousEdge) {
            return value(i) - value(i + self.b.len() - 1);
        }
        self.misprints.choose(Misprint::DeltaSign, 1.0, -1.0) * (value(i + 1) - value(i))
    }

    /// `B_i I1(i) + delta B_i J1(i)`, the emission integrated along edge i over the squared distance.
    fn emission_over_square(&self, i: usize, edge: &AppendixEdge) -> f64 {
        self.b[i] * edge.i1 + self.delta(i) * edge.j1
    }

    fn over_edges<T: std::iter::Sum>(&self, term: impl Fn(usize, &AppendixEdge) -> T) -> T {
        self.edges.iter().enumerate().map(|(i, edge)| term(i, edge)).sum()
    }

    /// `2 pi/rho B(x)`.
    fn value(&self) -> f64 {
        let contour = self.over_edges(|i, edge| self.emission_over_square(i, edge) * self.n1.dot(edge.w));
        let logarithm = self.over_edges(|_, edge| self.k.dot(edge.e) * edge.k1);
        -contour - self.n1.dot(self.n2) * logarithm + self.c * self.n2.dot(self.edges[0].r) * self.x1
    }

    /// `2 pi/rho grad B(x)`; the appendix prints its negative.
    fn gradient(&self) -> DVec3 {
        let first: DVec3 = self.over_edges(|i, edge| self.emission_over_square(i, edge) * self.n1.cross(edge.e));
        let second: DVec3 = self.over_edges(|i, edge| self.inverse_fourth(i, edge));
        let third: DVec3 = self.over_edges(|_, edge| {
            let first = if self.misprints.planted(Misprint::FirstEdgeInGradient) { &self.edges[1] } else { edge };
            self.k.dot(edge.e) * (edge.i1 * first.r + edge.j1 * first.e)
        });
        let first = self.misprints.choose(Misprint::CrossProductReversed, 1.0, -1.0) * first;
        let doubled = self.misprints.choose(Misprint::SecondSumNotDoubled, 2.0, 1.0);
        -(first + doubled * second - self.n1.dot(self.n2) * third + self.surface_gradient())
    }

    /// Term i of the second contour sum, `(n1.w_i) int B r / r^4 dt`.
    fn inverse_fourth(&self, i: usize, edge: &AppendixEdge) -> DVec3 {
        let integral = self.b[i] * (edge.i2 * edge.r + edge.j2 * edge.e) + self.delta(i) * (edge.j2 * edge.r + edge.k2 * edge.e);
        if self.misprints.planted(Misprint::Equation11Integrand) {
            return self.n1.dot(integral) * edge.w;
        }
        self.n1.dot(edge.w) * integral
    }

    /// The two lines of the gradient that come from the surface integrals.
    fn surface_gradient(&self) -> DVec3 {
        let height = self.n2.dot(self.edges[0].r);
        let along: DVec3 = self.over_edges(|_, edge| self.misprints.choose(Misprint::I2ForI1, edge.i1, edge.i2) * edge.e);
        let doubled = self.misprints.choose(Misprint::X2NotDoubled, 2.0, 1.0);
        self.c * ((self.x1 - doubled * height * height * self.x2) * self.n2 - height * self.n2.cross(along))
    }
}

#[cfg(test)]
mod tests;
