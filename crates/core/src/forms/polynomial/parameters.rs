//! How the irradiance of an emission that varies depends on the emission's parameters and on where the emitter's plane is.
//!
//! Where the plane moves, a direction sees another point of it. Under a motion of the vertices that keeps the polygon flat a point y
//! moves by `m(y) = sum lambda_k(y) v_k` ([`crate::forms::affine_weights`]), the plane along a direction omega by `-(n2.m)/c omega`,
//! `c = -n2.omega`. The emission seen there changes
//! - where vertex values hold it, by `-g.[m + omega (n2.m)/c]`, g its slope in the plane. With `E[f] = int f (n1.omega) domega` and
//!   `R[f] = int f (n1.r)/r^4 dA` the derivative by vertex k is `-g E[lambda_k] - n2 R[lambda_k g.r]`, and that by its value is
//!   `E[lambda_k]`;
//! - where it is a function F of the position, by `-(G.omega) (n2.m)/c`, `G = grad F` with all three components: `-n2 R[lambda_k G.r]`.
//!   At r = p - h n2, p from the foot point, `G.r = g.p - h n2.G`, so that `R[lambda_k G.r] = R[lambda_k g.p] - E[lambda_k n2.G]`.
//!   The derivative by a coefficient is `E` of its function. An affine F is given by its value at vertex 0, and moves with that.
//!
//! The terms that the edges add as they move are in [`crate::forms::hats`].

use glam::DVec3;
use radgrad_numbers::offset::offset;
use radgrad_numbers::real::{RadiusOf, Real};
use radgrad_numbers::vec3::Vec3;

use crate::forms::affine_weights::AffineWeight;
use crate::forms::polynomial::sum::SeenPolynomial;
use crate::forms::polynomial::within::Within;
use crate::problem::emission::{Emission, Emitter, Linear};
use crate::problem::polynomial::bivariate::Bivariate;
use crate::problem::receiver::Receiver;

/// Derivatives without the factor rho/pi.
pub(crate) struct ByParameters<T> {
    /// By each vertex, but for the terms that its edges add.
    pub(crate) vertices: Vec<Vec3<T>>,
    /// By each parameter of the emission.
    pub(crate) emission: Vec<Parameter<T>>,
}

/// The derivative by a parameter of the emission.
pub(crate) struct Parameter<T> {
    pub(crate) derivative: T,
    /// Whether it is one by a slope, in the unit of length.
    pub(crate) is_slope: bool,
}

/// Bounds over the emitter.
pub(crate) struct Largest<R> {
    /// On the magnitude of the factor that each parameter of the emission multiplies.
    pub(crate) parameters: Vec<R>,
    /// On the length of the emission's gradient.
    pub(crate) slope: R,
}

impl<T> Parameter<T> {
    pub(crate) const fn value(derivative: T) -> Self {
        Self { derivative, is_slope: false }
    }
}

/// An emission as a function around the foot point of x, with those parts of it that depend on parameters.
pub(crate) struct Parameters<'a, T> {
    receiver: &'a Receiver,
    emitter: &'a Emitter,
    power: f64,
    axes: [Vec3<T>; 2],
    n2: Vec3<T>,
    /// `lambda_k`.
    weights: Vec<Bivariate<T>>,
    slopes: [Bivariate<T>; 2],
    /// `g.p`.
    radial: Bivariate<T>,
}

impl<'a, T: Real> Parameters<'a, T> {
    /// Of an emission that is not constant.
    pub(crate) fn new(
        receiver: &'a Receiver,
        emitter: &'a Emitter,
        power: f64,
        seen: &SeenPolynomial<T>,
        weights: &[AffineWeight<T>],
    ) -> Self {
        let SeenPolynomial { n2, axes, emission, .. } = seen;
        let weight = |weight: &AffineWeight<T>| affine(weight.constant, axes.map(|axis| weight.slope.dot(axis)));
        let (slopes, radial) = (emission.gradient(), emission.radial());
        Self { receiver, emitter, power, axes: *axes, n2: *n2, weights: weights.iter().map(weight).collect(), slopes, radial }
    }

    pub(crate) fn derivatives(&self, within: &Within<T>) -> ByParameters<T> {
        let moved = |weight: &Bivariate<T>| -self.n2 * within.radial(&product(&self.radial, weight));
        let mut vertices: Vec<Vec3<T>> = self.weights.iter().map(moved).collect();
        let emission = match self.emitter.emission() {
            Emission::Constant(_) | Emission::Linear(Linear::AtVertices(_)) => {
                let slope = self.axes[0] * self.slopes[0].coefficient(0, 0) + self.axes[1] * self.slopes[1].coefficient(0, 0);
                let shares: Vec<T> = self.weights.iter().map(|weight| within.irradiance(weight)).collect();
                for (vertex, share) in vertices.iter_mut().zip(&shares) {
                    *vertex = *vertex - slope * *share;
                }
                shares.into_iter().map(Parameter::value).collect()
            }
            Emission::Linear(Linear::Gradient { gradient, .. }) => {
                let irradiance = within.irradiance(&constant(T::exact(1.0)));
                let gradient = Vec3::from(*gradient).map(|c| T::exact(c).scaled(self.emitter.power()).scaled(1.0 / self.power));
                self.add_moved_across(&mut vertices, &constant(gradient.dot(self.n2)), within);
                vertices[0] = vertices[0] - gradient * irradiance;
                let first: Vec3<T> = offset(self.emitter.polygon().vertices()[0], self.receiver.position(), self.power);
                let (zero, one) = (T::exact(0.0), T::exact(1.0));
                let along = |axis: usize, slope| within.irradiance(&affine(-self.axes[axis].dot(first), slope));
                let Vec3 { x, y, z } = self.axes[0] * along(0, [one, zero]) + self.axes[1] * along(1, [zero, one]);
                let slopes = [x, y, z].map(|derivative| Parameter { derivative, is_slope: true });
                std::iter::once(Parameter::value(irradiance)).chain(slopes).collect()
            }
            Emission::Polynomial(_) => {
                let Some(plane) = self.emitter.polynomial() else { return ByParameters { vertices, emission: Vec::new() } };
                let polygon = self.emitter.polygon();
                let (coordinates, _) = plane.precise::<T>(polygon);
                let around_foot = |f: &Bivariate<T>, emission_power: f64| {
                    coordinates.around_foot(f, self.receiver.position(), self.power, emission_power)
                };
                let across = around_foot(&plane.slope_across(polygon, &coordinates), self.emitter.power());
                self.add_moved_across(&mut vertices, &across.map(|_, _, c| c.scaled(1.0 / self.power)), within);
                let term = |f: Bivariate<T>| Parameter::value(within.irradiance(&around_foot(&f, 1.0)));
                plane.monomials(&coordinates).map(term).collect()
            }
        };
        ByParameters { vertices, emission }
    }

    /// Bounds on the integrands of the derivatives, given one on the weights. A polygon's points are between its vertices, in the plane too.
    pub(crate) fn largest(&self, weight: RadiusOf<T>) -> Largest<RadiusOf<T>> {
        let (x, polygon) = (self.receiver.position(), self.emitter.polygon());
        let bound = |c: T| c.size() + c.error();
        let one = RadiusOf::<T>::from(1.0);
        let reach = self.axes.map(|axis| {
            let along = |&vertex: &DVec3| bound(axis.dot(offset(vertex, x, self.power)));
            // The sum of all, which is not a number where one is not.
            polygon.vertices().iter().map(along).fold(0.0.into(), |sum: RadiusOf<T>, reach| sum + reach)
        });
        let largest = |f: &Bivariate<T>| f.largest_within(reach);
        let in_plane = largest(&self.slopes[0]) + largest(&self.slopes[1]);
        match self.emitter.emission() {
            Emission::Constant(_) | Emission::Linear(Linear::AtVertices(_)) => {
                Largest { parameters: vec![weight; self.weights.len()], slope: in_plane }
            }
            Emission::Linear(Linear::Gradient { gradient, .. }) => {
                let arm = |&vertex: &DVec3| {
                    let arm: Vec3<T> = offset(vertex, polygon.vertices()[0], self.power);
                    bound(arm.x) + bound(arm.y) + bound(arm.z)
                };
                let farthest = polygon.vertices().iter().map(arm).fold(0.0.into(), |sum: RadiusOf<T>, arm| sum + arm);
                let [a, b, c] =
                    gradient.to_array().map(|c| bound(T::exact(c).scaled(self.emitter.power()).scaled(1.0 / self.power)));
                Largest { parameters: vec![one, farthest, farthest, farthest], slope: a + b + c }
            }
            Emission::Polynomial(_) => {
                let Some(plane) = self.emitter.polynomial() else { return Largest { parameters: Vec::new(), slope: in_plane } };
                let (coordinates, _) = plane.precise::<T>(polygon);
                let around_foot = |f: &Bivariate<T>, emission: f64| coordinates.around_foot(f, x, self.power, emission);
                let across = around_foot(&plane.slope_across(polygon, &coordinates), self.emitter.power());
                let across = across.map(|_, _, c| c.scaled(1.0 / self.power));
                let parameters = plane.monomials(&coordinates).map(|f| largest(&around_foot(&f, 1.0))).collect();
                Largest { parameters, slope: in_plane + largest(&across) }
            }
        }
    }

    /// Adds `n2 E[lambda_k n2.G]`.
    fn add_moved_across(&self, vertices: &mut [Vec3<T>], across: &Bivariate<T>, within: &Within<T>) {
        for (vertex, weight) in vertices.iter_mut().zip(&self.weights) {
            *vertex = *vertex + self.n2 * within.irradiance(&product(across, weight));
        }
    }
}

fn constant<T: Real>(value: T) -> Bivariate<T> {
    Bivariate::zero(0).map(|_, _, _: T| value)
}

fn affine<T: Real>(constant: T, slope: [T; 2]) -> Bivariate<T> {
    Bivariate::zero(1).map(|i, j, _: T| if i + j == 0 { constant } else { slope[j] })
}

/// A polynomial times an affine function.
fn product<T: Real>(f: &Bivariate<T>, affine: &Bivariate<T>) -> Bivariate<T> {
    f.times_linear(affine.coefficient(0, 0), [affine.coefficient(1, 0), affine.coefficient(0, 1)])
}
