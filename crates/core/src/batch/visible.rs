//! The part of an emitter that each receiver sees, on lanes: none of it, all of it, or the part above the receiver's horizon.
//!
//! The decisions of [`crate::boundary::plan`], taken where the precision of the lanes is sure of them: heights err by less than
//! 8.5u of the distance R of the farthest vertex, and 16u R decide. Which side of the plane the receiver is on, and whether
//! anything is above the horizon, must be sure; lanes where it is not are left to the scalar path, as are those where too many
//! digits are lost. A single vertex within 16u R of the horizon is taken to be on it, and the bound covers that it is not: so a
//! wall that stands on the receiver's floor is answered here. The side of a plane across an axis is exact.

use fearless_simd::Simd;
use radgrad_numbers::lanes::angle::Quotients;
use radgrad_numbers::lanes::lane::{Lane, Lanes, Mask, constant};
use radgrad_numbers::vec3::Vec3;

use crate::batch::bound::LaneBound;
use crate::batch::span::{Crossing, EdgePart, EdgeTerms, LaneEdge, SeenPoint, Span};

/// Polygons with as many edges each, one a lane or the same on all lanes, in normalised lengths.
pub(super) trait Outline<S: Simd, F: Lane> {
    /// Number of vertices and edges.
    fn count(&self) -> usize;
    fn vertex(&self, simd: S, index: usize) -> Vec3<Lanes<S, F>>;
    /// Edge `index` starts at that vertex.
    fn edge(&self, simd: S, index: usize) -> LaneEdge<S, F>;
    /// Unit normal `n2`.
    fn normal(&self, simd: S) -> Vec3<Lanes<S, F>>;
    /// Bound on the error of the receiver's height over the plane, a share of the distance, squared; 0 where it is exact.
    fn height_share(&self, simd: S) -> Lanes<S, F>;
}

/// The sums over the boundary of the visible part.
pub(super) trait BoundarySums<S: Simd, F: Lane> {
    /// Value and gradient are their sums times this.
    const FACTOR: f64;

    /// Adds the visible pieces of edges, one after the other; the slow operations are done for all of them side by side, and terms
    /// without an angle while others wait for one.
    #[inline(always)]
    fn add<const GRADIENT: bool, const N: usize>(&mut self, simd: S, n1: Vec3<Lanes<S, F>>, spans: &[Span<S, F>; N]) {
        let (mut across, mut inline) = ([constant(simd, 0.0); N], [constant(simd, 0.0); N]);
        for (k, Span { start, end, part, moment, .. }) in spans.iter().enumerate() {
            (across[k], inline[k]) = (part.clip(*moment), start.r.dot(end.r));
        }
        let quotients = Quotients::new(simd, across, inline);
        let mut terms = [EdgeTerms::none(simd); N];
        for (k, span) in spans.iter().enumerate() {
            terms[k] = EdgeTerms::new::<GRADIENT>(simd, n1, span, inline[k]);
        }
        let angles = quotients.angles(simd);
        for k in 0..N {
            self.add_one::<GRADIENT>(simd, n1, &spans[k], &terms[k], angles[k]);
        }
    }

    /// Adds the visible piece of an edge, seen at the angle g.
    fn add_one<const GRADIENT: bool>(
        &mut self,
        simd: S,
        n1: Vec3<Lanes<S, F>>,
        span: &Span<S, F>,
        terms: &EdgeTerms<S, F>,
        g: Lanes<S, F>,
    );

    /// Adds the horizon's arc, where the boundary leaves the upper half-space at `exit` and comes back at `entry`.
    fn close(&mut self, simd: S, n1: Vec3<Lanes<S, F>>, has_left: Mask<S, F>, exit: Vec3<Lanes<S, F>>, entry: Vec3<Lanes<S, F>>);

    /// The sums' value and gradient, their bounds, tight where they are requested, and where those hold.
    fn total<const GRADIENT: bool>(self, simd: S, extent: &SeenExtent<S, F>) -> (BoundedTotal<S, F>, Mask<S, F>);
}

/// Where receivers are, and their unit normals.
pub(super) type Placed<S, F> = (Vec3<Lanes<S, F>>, Vec3<Lanes<S, F>>);

/// Value, gradient and their bounds.
pub(super) type BoundedTotal<S, F> = (Lanes<S, F>, Vec3<Lanes<S, F>>, LaneBound<S, F>);

/// The inputs of the bounds besides the sums.
pub(super) struct SeenExtent<S: Simd, F: Lane> {
    pub(super) edges: f64,
    pub(super) tight: bool,
    /// Square of the distance of the farthest vertex.
    pub(super) farthest_square: Lanes<S, F>,
    /// Where the horizon crosses, in any lane; and in which.
    pub(super) crossing: Option<(Crossing<S, F>, Mask<S, F>)>,
}

/// The sums that lanes found, without the factor of emission and reflectance.
pub(super) struct VisibleSums<S: Simd, F: Lane> {
    /// Where nothing is seen, for sure.
    pub(super) zero: Mask<S, F>,
    /// Where something is seen, and the sums hold within the bounds.
    pub(super) good: Mask<S, F>,
    /// Where that was cut by the horizon.
    pub(super) clipped: Mask<S, F>,
    /// `n1.Phi`.
    pub(super) value: Lanes<S, F>,
    pub(super) gradient: Vec3<Lanes<S, F>>,
    pub(super) bound: LaneBound<S, F>,
}

/// The visible part that each lane sees from x along the unit normal n1, where that is known, with bounds that are tight where asked
/// for.
#[inline(always)]
pub(super) fn find<S: Simd, F: Lane, O: Outline<S, F>, B: BoundarySums<S, F>, const GRADIENT: bool>(
    simd: S,
    outline: &O,
    ((x, n1), has_digits): (Placed<S, F>, Mask<S, F>),
    tight: bool,
    sums: B,
) -> VisibleSums<S, F> {
    let first = corner(simd, outline, 0, (x, n1));
    let extent = Extent::of_corner(first);
    // Of a triangle all corners are at hand for its edges.
    if outline.count() == 3 {
        let corners = [first, corner(simd, outline, 1, (x, n1)), corner(simd, outline, 2, (x, n1))];
        return decide::<S, F, O, B, GRADIENT>(
            simd,
            outline,
            ((x, n1), has_digits),
            (first, extent.and(corners[1]).and(corners[2])),
            (tight, sums),
            #[inline(always)]
            |sums| triangle::<S, F, O, B, GRADIENT>(simd, outline, corners, n1, sums),
        );
    }
    let extent = (1..outline.count()).fold(extent, |extent, index| extent.and(corner(simd, outline, index, (x, n1))));
    decide::<S, F, O, B, GRADIENT>(
        simd,
        outline,
        ((x, n1), has_digits),
        (first, extent),
        (tight, sums),
        #[inline(always)]
        |sums| whole::<S, F, O, B, GRADIENT>(simd, outline, x, n1, sums),
    )
}

/// The same from the first corner and the extent, with the sums over an outline that is fully visible.
#[inline(always)]
fn decide<S: Simd, F: Lane, O: Outline<S, F>, B: BoundarySums<S, F>, const GRADIENT: bool>(
    simd: S,
    outline: &O,
    ((x, n1), has_digits): (Placed<S, F>, Mask<S, F>),
    (first, Extent { lowest, highest, farthest_square }): (SeenCorner<S, F>, Extent<S, F>),
    (tight, mut sums): (bool, B),
    seen_whole: impl FnOnce(&mut B),
) -> VisibleSums<S, F> {
    let zero = constant(simd, 0.0);
    let in_range = has_digits & farthest_square.at_most(constant(simd, F::FARTHEST * F::FARTHEST));
    // Squares of the heights with their signs, against the squares of the least heights whose sign is sure.
    let signed = |height: Lanes<S, F>| height * height.abs();
    let sure = farthest_square * constant(simd, (16.0 * F::ROUNDOFF) * (16.0 * F::ROUNDOFF));
    let sure_side = farthest_square * outline.height_share(simd);
    // An exact depth has a sign though its square underflows, or is 0.
    let depth = outline.normal(simd).dot(first.point.r);
    let (is_sure, ahead) = (sure_side.at_most(depth * depth), depth.below(zero));
    let (behind, in_front) = (is_sure & !ahead, is_sure & ahead);
    let (above, below) = (sure.below(signed(lowest)), signed(highest).below(-sure));
    let nothing = in_range & (behind | below);
    let is_visible = in_range & in_front & sure.below(signed(highest));
    let none = LaneBound { value: zero, gradient_square: zero };
    let mut visible = VisibleSums {
        zero: nothing,
        good: is_visible & above,
        clipped: is_visible & !above,
        value: zero,
        gradient: Vec3::new(zero, zero, zero),
        bound: none,
    };
    if !is_visible.any() {
        return visible;
    }
    let edges = outline.count() as f64;
    let crossing = if visible.clipped.any() {
        let (crossing, once) = clipped::<S, F, O, B, GRADIENT>(simd, outline, x, n1, sure, &mut sums);
        visible.good = visible.good | (visible.clipped & once);
        Some((crossing, visible.clipped))
    } else {
        seen_whole(&mut sums);
        None
    };
    let ((value, gradient, bound), holds) = sums.total::<GRADIENT>(simd, &SeenExtent { edges, tight, farthest_square, crossing });
    VisibleSums { good: visible.good & holds, value, gradient, bound, ..visible }
}

#[inline(always)]
fn corner<S: Simd, F: Lane, O: Outline<S, F>>(simd: S, outline: &O, index: usize, (x, n1): Placed<S, F>) -> SeenCorner<S, F> {
    let point = SeenPoint::new(outline.vertex(simd, index) - x);
    SeenCorner { point, height: n1.dot(point.r) }
}

/// A whole edge between two corners.
#[inline(always)]
fn edge<S: Simd, F: Lane, O: Outline<S, F>>(
    simd: S,
    outline: &O,
    index: usize,
    from: SeenCorner<S, F>,
    to: SeenCorner<S, F>,
) -> Span<S, F> {
    Span::whole(outline.edge(simd, index), (from.point, from.height), to.point)
}

/// A vertex seen from x, and its height over the horizon.
struct SeenCorner<S: Simd, F: Lane> {
    point: SeenPoint<S, F>,
    height: Lanes<S, F>,
}

impl<S: Simd, F: Lane> Clone for SeenCorner<S, F> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<S: Simd, F: Lane> Copy for SeenCorner<S, F> {}

/// Where vertices are.
struct Extent<S: Simd, F: Lane> {
    lowest: Lanes<S, F>,
    highest: Lanes<S, F>,
    farthest_square: Lanes<S, F>,
}

impl<S: Simd, F: Lane> Extent<S, F> {
    #[inline(always)]
    fn of_corner(corner: SeenCorner<S, F>) -> Self {
        Self { lowest: corner.height, highest: corner.height, farthest_square: corner.point.square }
    }

    #[inline(always)]
    fn and(self, SeenCorner { point, height }: SeenCorner<S, F>) -> Self {
        Self {
            lowest: self.lowest.min(height),
            highest: self.highest.max(height),
            farthest_square: self.farthest_square.max(point.square),
        }
    }
}

/// The next vertex of an outline.
#[inline(always)]
fn after<S: Simd, F: Lane, O: Outline<S, F>>(outline: &O, index: usize) -> usize {
    if index + 1 == outline.count() { 0 } else { index + 1 }
}

/// The edges of a triangle side by side, so that none waits for the root of the one before.
#[inline(always)]
fn triangle<S: Simd, F: Lane, O: Outline<S, F>, B: BoundarySums<S, F>, const GRADIENT: bool>(
    simd: S,
    outline: &O,
    [a, b, c]: [SeenCorner<S, F>; 3],
    n1: Vec3<Lanes<S, F>>,
    sums: &mut B,
) {
    sums.add::<GRADIENT, 3>(
        simd,
        n1,
        &[edge(simd, outline, 0, a, b), edge(simd, outline, 1, b, c), edge(simd, outline, 2, c, a)],
    );
}

/// Two edges at a time.
#[inline(always)]
fn whole<S: Simd, F: Lane, O: Outline<S, F>, B: BoundarySums<S, F>, const GRADIENT: bool>(
    simd: S,
    outline: &O,
    x: Vec3<Lanes<S, F>>,
    n1: Vec3<Lanes<S, F>>,
    sums: &mut B,
) {
    let count = outline.count();
    let mut from = corner(simd, outline, 0, (x, n1));
    for index in (0..count - 1).step_by(2) {
        let (middle, to) = (corner(simd, outline, index + 1, (x, n1)), corner(simd, outline, after(outline, index + 1), (x, n1)));
        sums.add::<GRADIENT, 2>(
            simd,
            n1,
            &[edge(simd, outline, index, from, middle), edge(simd, outline, index + 1, middle, to)],
        );
        from = to;
    }
    if count % 2 == 1 {
        sums.add::<GRADIENT, 1>(simd, n1, &[edge(simd, outline, count - 1, from, corner(simd, outline, 0, (x, n1)))]);
    }
}

/// The part of an outline above the horizon, and where its boundary leaves the upper half-space once only, as that of a convex
/// polygon does. An arc of the horizon then joins that point with the one where it comes back; its `n1.N` is -1.
#[inline(always)]
fn clipped<S: Simd, F: Lane, O: Outline<S, F>, B: BoundarySums<S, F>, const GRADIENT: bool>(
    simd: S,
    outline: &O,
    x: Vec3<Lanes<S, F>>,
    n1: Vec3<Lanes<S, F>>,
    sure: Lanes<S, F>,
    sums: &mut B,
) -> (Crossing<S, F>, Mask<S, F>) {
    let (zero, one) = (constant(simd, 0.0), constant(simd, 1.0));
    let origin = Vec3::new(zero, zero, zero);
    // Where the boundary leaves the upper half-space and where it comes back, with |e|^2 over the square of how much it drops there.
    let (mut exit, mut entry) = ((origin, zero), (origin, zero));
    let mut from = corner(simd, outline, 0, (x, n1));
    let mut before = level(simd, from.height, sure);
    let mut has_left = zero.below(zero);
    let mut twice = has_left;
    for index in 0..outline.count() {
        let to = corner(simd, outline, after(outline, index), (x, n1));
        let after = level(simd, to.height, sure);
        let edge = outline.edge(simd, index);
        let (starts, ends) = (zero.below(before), zero.below(after));
        let (leaves, comes) = (starts & !ends, ends & !starts);
        twice = twice | (leaves & has_left);
        has_left = has_left | leaves;
        let crosses = leaves | comes;
        // From the end that is above.
        let inverse_drop = one / crosses.select((before - after).abs(), one);
        let fraction = crosses.select(starts.select(before, after) * inverse_drop, one);
        let point = SeenPoint::new(starts.select_vector(from.point.r, to.point.r) + edge.e * starts.select(fraction, -fraction));
        let slant = edge.square * (inverse_drop * inverse_drop);
        exit = (leaves.select_vector(point.r, exit.0), leaves.select(slant, exit.1));
        entry = (comes.select_vector(point.r, entry.0), comes.select(slant, entry.1));
        // An edge on the horizon adds nothing but to the bound.
        let (any, flat) =
            (starts | ends, before.at_most(zero) & zero.at_most(before) & after.at_most(zero) & zero.at_most(after));
        let part = EdgePart::Clipped { fraction, any, bounds: any | flat };
        let ends = (point.or(comes, &from.point), point.or(leaves, &to.point));
        sums.add::<GRADIENT, 1>(simd, n1, &[Span::piece(edge, (from.point.r, from.height), ends, part)]);
        (from, before) = (to, after);
    }
    sums.close(simd, n1, has_left, exit.0, entry.0);
    let mut crossing = Crossing { nearest: zero, slant: zero };
    for (point, slant) in [exit, entry] {
        let nearest = has_left.select(one / point.norm_squared(), zero);
        crossing.nearest = crossing.nearest.max(nearest);
        crossing.slant = crossing.slant.max(nearest * slant);
    }
    (crossing, !twice)
}

/// Height over the horizon; 0 where its sign is not sure.
#[inline(always)]
fn level<S: Simd, F: Lane>(simd: S, height: Lanes<S, F>, sure: Lanes<S, F>) -> Lanes<S, F> {
    sure.below(height * height).select(height, constant(simd, 0.0))
}
