//! Far away: a product Gauss-Legendre rule on the part of the emitter above the horizon, with its error bound. For emitters
//! that nothing occludes.
//!
//! The closed form cancels like the distance over the size, this rule not at all: from a few sizes away a handful of nodes
//! gives `B = (rho/pi) h int B(y) (n1.r)/r^4 dA` and `grad B = (rho/pi) int B(y) [n2 (n1.r) - n1 h + 4 h (n1.r) r/r^2]/r^4 dA`
//! (HS95 Eq. 1 differentiated; the horizon adds nothing, `n1.r` being zero there) to rounding. The polygon is a fan of signed
//! triangles ([`triangle`]), clipped first where the horizon crosses it ([`outline`]); `n1.r` is interpolated from the corners,
//! where it is known to full relative accuracy, so that slivers along the horizon lose nothing.
//!
//! The bound is that of each triangle's truncation ([`triangle`]) and rounding ([`sums`]). Polygons off one plane by their
//! planarity defect, and vertex values off one affine function, add 8 defects over the height and the residual, relative.

mod outline;
mod rules;
mod source;
mod sums;
mod triangle;

use crate::number::ROUNDOFF;
use crate::plan::{Horizon, Plan, height_over_plane, unit_normal};
use crate::vec3::Vec3;
use crate::{Emitter, Receiver};
use outline::Corner;
use source::Source;
use triangle::Triangle;

/// Value and gradient without the factor rho/pi, in normalised lengths and emission, with absolute error bounds.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Integral {
    pub(crate) value: f64,
    pub(crate) gradient: Vec3<f64>,
    pub(crate) value_error: f64,
    pub(crate) gradient_error: f64,
}

/// What all triangles of a case share.
#[derive(Debug)]
struct Scene<'a> {
    n1: Vec3<f64>,
    n2: Vec3<f64>,
    height: f64,
    source: Source<'a>,
    /// Relative error that the input brings: vertices off the plane, values off the affine function.
    input_error: f64,
    is_clipped: bool,
    /// Multiplies lengths.
    power: f64,
}

/// The rule for a case: how many nodes where, and what they leave.
#[derive(Debug)]
pub(crate) struct Rule<'a> {
    scene: Scene<'a>,
    first: Triangle,
    /// Of outlines that are no triangle.
    others: Vec<Triangle>,
}

impl<'a> Rule<'a> {
    /// The rule that a case needs for full precision; `None` where the emitter is too near for any.
    pub(crate) fn new(receiver: &Receiver, emitter: &'a Emitter, plan: &Plan) -> Option<Self> {
        let scene = Scene::new(receiver, emitter, plan);
        let polygon = emitter.polygon();
        let spread = |corners: &[Corner]| corners.iter().fold(0.0, |most: f64, c| most.max(c.local.norm_squared().sqrt()));
        if !scene.is_clipped && polygon.vertices().len() == 3 {
            let corners = scene.corners_of_triangle(receiver, polygon, plan);
            let twice_area = 2.0 * polygon.area_scaled(plan.power);
            let first = scene.triangle(apex_first(corners), spread(&corners), Some(twice_area))?;
            return Some(Self { scene, first, others: Vec::new() });
        }
        let outline = scene.outline(receiver, polygon, plan);
        let spread = spread(&outline);
        if let &[a, b, c] = &outline[..] {
            let first = scene.triangle(apex_first([a, b, c]), spread, None)?;
            return Some(Self { scene, first, others: Vec::new() });
        }
        let middle = 1..outline.len().saturating_sub(1);
        let mut fan = middle.map(|i| scene.triangle([outline[0], outline[i], outline[i + 1]], spread, None));
        let first = fan.next()??;
        let others = fan.collect::<Option<_>>()?;
        Some(Self { scene, first, others })
    }

    /// Number of nodes in all.
    pub(crate) fn nodes(&self) -> usize {
        self.triangles().map(Triangle::nodes).sum()
    }

    pub(crate) fn integrate(&self) -> Integral {
        let mut sum = Integral::default();
        for triangle in self.triangles() {
            sum.add(self.scene.integral(triangle), self.others.len());
        }
        sum
    }

    fn triangles(&self) -> impl Iterator<Item = &Triangle> {
        std::iter::once(&self.first).chain(&self.others)
    }
}

impl Integral {
    fn add(&mut self, other: Self, terms: usize) {
        let rounding = terms as f64 * ROUNDOFF;
        self.value += other.value;
        self.gradient = self.gradient + other.gradient;
        self.value_error += other.value_error + rounding * other.value.abs();
        self.gradient_error += other.gradient_error + rounding * other.gradient.norm_squared().sqrt();
    }
}

impl<'a> Scene<'a> {
    fn new(receiver: &Receiver, emitter: &'a Emitter, plan: &Plan) -> Self {
        let polygon = emitter.polygon();
        let height: f64 = height_over_plane(receiver.position(), polygon, plan.power);
        let is_clipped = plan.horizon == Horizon::Crossing;
        let source = Source::new(emitter, is_clipped);
        let input_error = 8.0 * polygon.planarity_defect() * plan.power / height + source.input_error;
        Self {
            n1: unit_normal(receiver),
            n2: polygon.normal().into(),
            height,
            source,
            input_error,
            is_clipped,
            power: plan.power,
        }
    }
}

/// The corners from the one opposite the shortest side on.
fn apex_first([a, b, c]: [Corner; 3]) -> [Corner; 3] {
    let side = |from: &Corner, to: &Corner| (to.local - from.local).norm_squared();
    let [ab, bc, ca] = [side(&a, &b), side(&b, &c), side(&c, &a)];
    if bc <= ab && bc <= ca {
        [a, b, c]
    } else if ca <= ab {
        [b, c, a]
    } else {
        [c, a, b]
    }
}
