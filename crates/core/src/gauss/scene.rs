//! The quantities that all triangles of a case share, and the sum of their integrals.

use radgrad_numbers::number::ROUNDOFF;
use radgrad_numbers::vec3::Vec3;

use crate::boundary::plan::{Horizon, Plan};
use crate::forms::edge_lanes::certain_height;
use crate::gauss::source::Source;
use crate::problem::emission::Emitter;
use crate::problem::receiver::{Receiver, unit_normal};

/// Value and gradient without the factor rho/pi, in normalised lengths and emission, with absolute error bounds.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Integral {
    pub(crate) value: f64,
    pub(crate) gradient: Vec3<f64>,
    pub(crate) value_error: f64,
    pub(crate) gradient_error: f64,
}

/// The quantities that all triangles of a case share.
#[derive(Debug)]
pub(super) struct Scene<'a> {
    pub(super) n1: Vec3<f64>,
    pub(super) n2: Vec3<f64>,
    pub(super) height: f64,
    pub(super) source: Source<'a>,
    /// Relative error that the input brings: the height rounded, vertices off the plane, values off the affine function.
    pub(super) input_error: f64,
    pub(super) is_clipped: bool,
    /// Truncation that is enough, relative.
    pub(super) enough: f64,
    /// Multiplies lengths.
    pub(super) power: f64,
}

impl Integral {
    pub(super) fn add(&mut self, other: Self, terms: usize) {
        let rounding = terms as f64 * ROUNDOFF;
        self.value += other.value;
        self.gradient = self.gradient + other.gradient;
        self.value_error += other.value_error + rounding * other.value.abs();
        self.gradient_error += other.gradient_error + rounding * other.gradient.norm();
    }
}

impl<'a> Scene<'a> {
    pub(super) fn new(receiver: &Receiver, emitter: &'a Emitter, plan: &Plan, enough: f64) -> Self {
        let polygon = emitter.polygon();
        let (height, height_error) = certain_height(receiver, polygon, plan.power);
        let is_clipped = plan.horizon == Horizon::Crossing;
        let source = Source::new(emitter, is_clipped);
        let input_error = mutant!(
            "gauss.input-error",
            8.0 * polygon.planarity_defect() * plan.power / height + height_error / height + source.input_error,
            |error| 0.01 * error
        );
        Self {
            n1: unit_normal(receiver),
            n2: polygon.normal().into(),
            height,
            source,
            input_error,
            is_clipped,
            enough,
            power: plan.power,
        }
    }
}
