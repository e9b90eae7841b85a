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
//! planarity defect, and vertex values off one affine function, add 8 defects over the height and the residual, relative. The defect
//! also moves polygons along the receiver's normal, against the horizon: [`Scene::off_plane`] bounds the change.

mod outline;
mod rules;
mod scene;
mod source;
mod square;
mod sums;
mod triangle;

use radgrad_numbers::effort;
use radgrad_numbers::number::ROUNDOFF;

use crate::boundary::plan::{Horizon, Plan};
use crate::gauss::scene::{Integral, Scene};
use crate::gauss::triangle::{SeenTriangle, Triangle};
use crate::problem::emission::Emitter;
use crate::problem::fan::{Shape, apex_first};
use crate::problem::polygon::Polygon;
use crate::problem::receiver::Receiver;

/// The truncation of a triangle, relative to its expected value and gradient, that is not worth another node: a quarter of a roundoff.
pub(crate) const FULL_PRECISION: f64 = 0.25 * ROUNDOFF;

/// Nodes whose cost is negligible beside the rest of an answer, and the operations of one.
const MANY: usize = 1 << 14;
const OF_A_NODE: u64 = 16;

/// The integral by a rule with at most `most` nodes, of which the truncation is about `enough` or less, relative, where the emission
/// is nowhere negative, and of [`FULL_PRECISION`] elsewhere; `None` if it takes more nodes, or the emitter is too near for any rule.
pub(crate) fn integral(receiver: &Receiver, emitter: &Emitter, plan: &Plan, node_limit: usize, enough: f64) -> Option<Integral> {
    let (scene, polygon) = (Scene::new(receiver, emitter, plan, enough), emitter.polygon());
    if polygon.planarity_defect() > 0.0 {
        scene.not_flat(receiver, polygon, plan, node_limit)
    } else {
        scene.flat(receiver, polygon, plan, node_limit)
    }
}

impl<'a> Scene<'a> {
    /// The integral over a polygon that is not quite in one plane.
    #[inline(never)]
    fn not_flat(&self, receiver: &Receiver, polygon: &Polygon, plan: &Plan, node_limit: usize) -> Option<Integral> {
        self.flat(receiver, polygon, plan, node_limit).map(|integral| self.off_plane(receiver, polygon, integral))
    }

    /// The integral over a polygon in one plane.
    #[inline]
    fn flat(&self, receiver: &Receiver, polygon: &Polygon, plan: &Plan, node_limit: usize) -> Option<Integral> {
        if plan.horizon == Horizon::Above {
            let (fan, power) = polygon.fan();
            let power = plan.power / power;
            return self.over(fan.iter(), node_limit, |triangle| self.plain_triangle(receiver, triangle, power));
        }
        let outline = self.outline(receiver, polygon, plan);
        let spread = outline.iter().map(|corner| corner.local.norm()).fold(0.0, f64::max);
        if let &[a, b, c] = &outline[..] {
            let sides = [(a, b), (b, c), (c, a)].map(|(from, to)| (to.local - from.local).norm_squared());
            let corners = apex_first([a, b, c], sides);
            return self.over(std::iter::once(corners), node_limit, |corners| self.clipped_triangle(corners, spread));
        }
        let fan = (1..outline.len().saturating_sub(1)).map(|i| [outline[0], outline[i], outline[i + 1]]);
        self.over(fan, node_limit, |corners| self.clipped_triangle(corners, spread))
    }

    /// The integral over a fan, made of triangles one by one.
    #[inline]
    fn over<T>(
        &self,
        fan: impl ExactSizeIterator<Item = T>,
        node_limit: usize,
        triangle: impl Fn(T) -> (Shape, SeenTriangle),
    ) -> Option<Integral> {
        let additions = fan.len().checked_sub(1)?;
        let (mut sum, mut nodes) = (Integral::default(), 0);
        for corners in fan {
            let (shape, seen) = triangle(corners);
            let rule = self.rule(&shape, &seen)?;
            nodes += rule.nodes();
            if nodes > node_limit || nodes > MANY && !effort::spend(OF_A_NODE * rule.nodes() as u64) {
                return None;
            }
            sum.add(self.integral(&Triangle { shape: &shape, seen: &seen, rule }), additions);
        }
        Some(sum)
    }
}
