//! The sums over the edges of a constant emitter, on lanes: HS95 Eq. 8 and A.1 in a form that needs one square root, two
//! divisions and one arc tangent an edge.
//!
//! For an edge e from `r` to `r'` (offsets from the receiver) and its visible part from p to p', the fraction f of it: `w = r x
//! e`, `m = |w|`, `S = m/|e|` the distance of the line, `N = w/m`, `g` the angle from p to p', and psi the angle from the nearest
//! point of the line,
//! - value: `-1/2 sum g n1.N`, `g = atan2(f m, p.p')`;
//! - gradient: `-sum (N/S) (cc p1 + cs p2)`, as in [`crate::constant`], with `2 cc = g + sin g cos(psi + psi')` and `2 cs = sin g
//!   sin(psi + psi')`. Since `|p| cos psi = S` and `|p| sin psi |e| = p.e`, no end direction is normalised: `sin g = f m/(|p||p'|)`,
//!   `cos(psi + psi') |p||p'| = 2 S^2 - p.p'`, `sin(psi + psi') |p||p'| = S (p + p').e/|e|`; and `p1 = n1.toward = t/(m |e|)`, `t = h
//!   e^2 - (r.e) (n1.e)`, h = n1.r, `p2 = n1.e/|e|`. With `m = S |e|` and `q = f/(p^2 p'^2)` an edge adds, twice over, w times
//!   `t [g/m^3 + q (2/e^2 - p.p'/m^2)]` and times `q (n1.e) (p + p').e/e^2`. Lengths of edges occur squared only.
//!
//! Nothing is recomputed for the whole edge of an unclipped lane: f = 1, p = r, p' = r', to the last digit.

use fearless_simd::Simd;

use super::arc_tangent::angle;
use super::bound::{bound, conditioned};
use super::lanes::{Lane, Lanes, Mask, constant};
use super::visible::{BoundarySums, SeenExtent, Total};
use crate::vec3::Vec3;

/// A point of the emitter's plane seen from the receivers.
pub(super) struct Seen<S: Simd, F: Lane> {
    /// Offset from the receiver.
    pub(super) r: Vec3<Lanes<S, F>>,
    /// `|r|^2`.
    pub(super) square: Lanes<S, F>,
}

/// An edge from one vertex to the next.
pub(super) struct Edge<S: Simd, F: Lane> {
    /// Which one, by the vertex where it starts.
    pub(super) index: usize,
    pub(super) e: Vec3<Lanes<S, F>>,
    /// `|e|^2`, and its inverse.
    pub(super) square: Lanes<S, F>,
    pub(super) inverse: Lanes<S, F>,
}

/// An edge, its visible piece from `start` to `end`, and what costs a square root.
pub(super) struct Span<S: Simd, F: Lane> {
    pub(super) edge: Edge<S, F>,
    /// Offset of where the edge starts, and its height over the horizon.
    pub(super) r: Vec3<Lanes<S, F>>,
    height: Lanes<S, F>,
    pub(super) start: Seen<S, F>,
    pub(super) end: Seen<S, F>,
    pub(super) part: Part<S, F>,
    /// `r x e`, its square and its length.
    pub(super) w: Vec3<Lanes<S, F>>,
    pub(super) square: Lanes<S, F>,
    pub(super) moment: Lanes<S, F>,
}

/// How much of an edge is visible.
pub(super) enum Part<S: Simd, F: Lane> {
    /// All of it, in all lanes.
    Whole,
    /// A fraction of it, where there is any; the bounds count it in more lanes.
    Clipped { fraction: Lanes<S, F>, any: Mask<S, F>, bounds: Mask<S, F> },
}

impl<S: Simd, F: Lane> Part<S, F> {
    /// That part of a length.
    #[inline(always)]
    pub(super) fn of(&self, length: Lanes<S, F>) -> Lanes<S, F> {
        match self {
            Self::Whole => length,
            Self::Clipped { fraction, .. } => length * *fraction,
        }
    }

    /// A term where there is any.
    #[inline(always)]
    pub(super) fn visible(&self, simd: S, term: Lanes<S, F>) -> Lanes<S, F> {
        match self {
            Self::Whole => term,
            Self::Clipped { any, .. } => any.select(term, constant(simd, 0.0)),
        }
    }

    /// A term of a bound where it counts.
    #[inline(always)]
    pub(super) fn counted(&self, simd: S, term: Lanes<S, F>) -> Lanes<S, F> {
        match self {
            Self::Whole => term,
            Self::Clipped { bounds, .. } => bounds.select(term, constant(simd, 0.0)),
        }
    }
}

/// The sums over the edges.
pub(super) struct Sums<S: Simd, F: Lane> {
    /// `sum g n1.N`.
    pub(super) value: Lanes<S, F>,
    /// `sum (N/S) 2 (cc p1 + cs p2)`.
    pub(super) gradient: Vec3<Lanes<S, F>>,
    /// `sum g`.
    pub(super) angles: Lanes<S, F>,
    /// The largest `1/S^2`.
    pub(super) nearest: Lanes<S, F>,
}

impl<S: Simd, F: Lane> Clone for Seen<S, F> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<S: Simd, F: Lane> Copy for Seen<S, F> {}

impl<S: Simd, F: Lane> Seen<S, F> {
    #[inline(always)]
    pub(super) fn new(r: Vec3<Lanes<S, F>>) -> Self {
        Self { r, square: r.norm_squared() }
    }

    /// This point where the mask is set, the other where it is not.
    #[inline(always)]
    pub(super) fn or(&self, mask: Mask<S, F>, other: &Self) -> Self {
        Self { r: mask.select_vector(self.r, other.r), square: mask.select(self.square, other.square) }
    }
}

impl<S: Simd, F: Lane> Span<S, F> {
    /// A whole edge from a point at a height over the horizon.
    #[inline(always)]
    pub(super) fn whole(edge: Edge<S, F>, (start, height): (Seen<S, F>, Lanes<S, F>), end: Seen<S, F>) -> Self {
        Self::piece(edge, (start.r, height), (start, end), Part::Whole)
    }

    /// A piece of the edge that starts at an offset, at a height over the horizon.
    #[inline(always)]
    pub(super) fn piece(
        edge: Edge<S, F>,
        (r, height): (Vec3<Lanes<S, F>>, Lanes<S, F>),
        (start, end): (Seen<S, F>, Seen<S, F>),
        part: Part<S, F>,
    ) -> Self {
        let w = r.cross(edge.e);
        let square = w.norm_squared();
        Self { edge, r, height, start, end, part, w, square, moment: square.sqrt() }
    }
}

impl<S: Simd, F: Lane> Sums<S, F> {
    #[inline(always)]
    pub(super) fn new(simd: S) -> Self {
        let zero = constant(simd, 0.0);
        Self { value: zero, gradient: Vec3::new(zero, zero, zero), angles: zero, nearest: zero }
    }
}

impl<S: Simd, F: Lane> BoundarySums<S, F> for Sums<S, F> {
    const FACTOR: f64 = -0.5;

    #[inline(always)]
    fn add_one<const GRADIENT: bool>(
        &mut self,
        simd: S,
        _: Vec3<Lanes<S, F>>,
        Span { edge, part, w, square, moment, .. }: &Span<S, F>,
        Terms { inline, ends, product, lit, reach, level, toward }: &Terms<S, F>,
        g: Lanes<S, F>,
    ) {
        let inverse_square = *product * *ends;
        let turn = g * (*moment * inverse_square);
        self.value = self.value + part.visible(simd, turn * *lit);
        if GRADIENT {
            let between = part.of(*product * *square);
            let straight = (edge.inverse + edge.inverse) - *inline * inverse_square;
            let term = *toward * (inverse_square * turn + between * straight) + (between * *reach) * *level;
            self.gradient = self.gradient + *w * part.visible(simd, term);
        }
        self.nearest = self.nearest.max(part.counted(simd, edge.square * inverse_square));
        self.angles = self.angles + part.counted(simd, g);
    }

    /// The horizon's `n1.N` is -1.
    #[inline(always)]
    fn close(&mut self, simd: S, n1: Vec3<Lanes<S, F>>, left: Mask<S, F>, exit: Vec3<Lanes<S, F>>, entry: Vec3<Lanes<S, F>>) {
        let closed = angle(simd, -n1.dot(exit.cross(entry)), exit.dot(entry));
        self.value = self.value - left.select(closed, constant(simd, 0.0));
    }

    #[inline(always)]
    fn total<const GRADIENT: bool>(self, simd: S, extent: &SeenExtent<S, F>) -> (Total<S, F>, Mask<S, F>) {
        let SeenExtent { edges, tight, farthest_square, crossing } = extent;
        let crossing = crossing.as_ref().map(|(crossing, _)| crossing);
        let holds = conditioned(simd, &self, crossing, *farthest_square);
        let bound = bound::<S, F, GRADIENT>(simd, (*edges, *tight), &self, crossing, *farthest_square);
        ((self.value, self.gradient, bound), holds)
    }
}

/// What the terms of an edge's visible piece need besides its angle.
pub(super) struct Terms<S: Simd, F: Lane> {
    /// `p.p'` and `p^2 p'^2`.
    pub(super) inline: Lanes<S, F>,
    pub(super) ends: Lanes<S, F>,
    /// One division for `1/m^2` and `1/(p^2 p'^2)`: `1/(m^2 p^2 p'^2)`.
    pub(super) product: Lanes<S, F>,
    /// `n1.w`.
    pub(super) lit: Lanes<S, F>,
    /// `(p + p').e/e^2`.
    pub(super) reach: Lanes<S, F>,
    /// `n1.e`, and `h e^2 - (r.e) (n1.e)`.
    pub(super) level: Lanes<S, F>,
    pub(super) toward: Lanes<S, F>,
}

impl<S: Simd, F: Lane> Clone for Terms<S, F> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<S: Simd, F: Lane> Copy for Terms<S, F> {}

impl<S: Simd, F: Lane> Terms<S, F> {
    #[inline(always)]
    pub(super) fn none(simd: S) -> Self {
        let zero = constant(simd, 0.0);
        Self { inline: zero, ends: zero, product: zero, lit: zero, reach: zero, level: zero, toward: zero }
    }

    #[inline(always)]
    pub(super) fn new<const GRADIENT: bool>(
        simd: S,
        n1: Vec3<Lanes<S, F>>,
        Span { edge, r, height, start, end, part, w, square, .. }: &Span<S, F>,
    ) -> Self {
        let ends = start.square * end.square;
        let product = constant(simd, 1.0) / (*square * ends);
        let terms = Self { inline: start.r.dot(end.r), ends, product, lit: n1.dot(*w), ..Self::none(simd) };
        if !GRADIENT {
            return terms;
        }
        let along = start.r.dot(edge.e);
        let reach = (along + along + part.of(edge.square)) * edge.inverse;
        let along = if matches!(part, Part::Clipped { .. }) { r.dot(edge.e) } else { along };
        let level = n1.dot(edge.e);
        Self { reach, level, toward: *height * edge.square - along * level, ..terms }
    }
}
