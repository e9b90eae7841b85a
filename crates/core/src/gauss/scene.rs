//! The quantities that all triangles of a case share, and the sum of their integrals.

use radgrad_numbers::number::ROUNDOFF;
use radgrad_numbers::offset::offset;
use radgrad_numbers::vec3::Vec3;

use crate::boundary::plan::{Horizon, Plan};
use crate::forms::edge_lanes::certain_height;
use crate::gauss::source::Source;
use crate::problem::emission::Emitter;
use crate::problem::polygon::Polygon;
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
        let input_error = 8.0 * polygon.planarity_defect() * plan.power / height + height_error / height + source.input_error;
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

    /// The integral with a bound on the change of `n1.r` by a polygon that is not flat.
    ///
    /// Points of the polygon lie off its plane by at most the defect on either side, so `n1.r` is known to `delta`, twice the defect times
    /// `|n1.n2|`. Let A be the polygon's area, d its least distance, `I(A) = sup|B| int dA/r^4`.
    ///
    /// - The positive part of `n1.r` changes by no more than `n1.r` does: the value changes by at most `h delta I(A)`.
    /// - The gradient's two terms with `n1.r` change by at most `(1 + 2h/d) delta I(A)`, and d is no less than half of h.
    /// - The gradient's other term is all there or not at all. Where `|n1.r| <= delta`, a strip of the polygon, the horizon may pass on
    ///   either side: the gradient changes by at most `h I(strip)`.
    ///
    /// `int dA/r^4` is at most `A/d^4`, and over all of the plane `pi/h^2`.
    pub(super) fn off_plane(&self, receiver: &Receiver, polygon: &Polygon, mut integral: Integral) -> Integral {
        let delta = 2.0 * polygon.planarity_defect() * self.power * (self.n1.dot(self.n2).abs() + 8.0 * ROUNDOFF);
        let across = 2.0 * polygon.size() * self.power;
        let (mut nearest, mut lowest) = (f64::INFINITY, f64::INFINITY);
        for vertex in polygon.vertices() {
            let from_receiver: Vec3<f64> = offset(*vertex, receiver.position(), self.power);
            let distance = from_receiver.norm();
            nearest = nearest.min(distance);
            lowest = lowest.min(self.n1.dot(from_receiver) - 16.0 * ROUNDOFF * distance);
        }
        // The height is known to a few defects.
        let (height, least_height) = (self.height * (1.0 + self.input_error), 0.5 * self.height);
        let distance = least_height.max(nearest - across);
        let whole_plane = std::f64::consts::PI / (least_height * least_height);
        let over = |area: f64| self.source.largest * whole_plane.min(area / (distance * distance * distance * distance));
        let area = polygon.area_scaled(self.power);
        let strip = (lowest <= delta).then(|| area.min(2.0 * delta * across / self.n1.cross(self.n2).norm()));
        // Areas, distances and their powers are rounded.
        let raised = 1.0 + 1e-9;
        integral.value_error += raised * height * delta * over(area);
        integral.gradient_error += raised * (5.0 * delta * over(area) + strip.map_or(0.0, |strip| height * over(strip)));
        integral
    }
}
