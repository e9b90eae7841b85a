//! An edge and its visible piece, with the quantities in its terms; the symbols are those of [`super::edge`].

use fearless_simd::Simd;
use radgrad_numbers::lanes::lane::{Lane, Lanes, Mask, constant};
use radgrad_numbers::vec3::Vec3;

/// A point of the emitter's plane seen from the receivers.
pub(super) struct SeenPoint<S: Simd, F: Lane> {
    /// Offset from the receiver.
    pub(super) r: Vec3<Lanes<S, F>>,
    /// `|r|^2`.
    pub(super) square: Lanes<S, F>,
}

impl<S: Simd, F: Lane> Clone for SeenPoint<S, F> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<S: Simd, F: Lane> Copy for SeenPoint<S, F> {}

impl<S: Simd, F: Lane> SeenPoint<S, F> {
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

/// An edge from one vertex to the next.
pub(super) struct LaneEdge<S: Simd, F: Lane> {
    /// Which one, by the vertex where it starts.
    pub(super) index: usize,
    pub(super) e: Vec3<Lanes<S, F>>,
    /// `|e|^2`, and its inverse.
    pub(super) square: Lanes<S, F>,
    pub(super) inverse: Lanes<S, F>,
}

/// An edge, its visible piece from `start` to `end`, and the quantities that cost a square root.
pub(super) struct Span<S: Simd, F: Lane> {
    pub(super) edge: LaneEdge<S, F>,
    /// Offset of where the edge starts, and its height over the horizon.
    pub(super) r: Vec3<Lanes<S, F>>,
    height: Lanes<S, F>,
    pub(super) start: SeenPoint<S, F>,
    pub(super) end: SeenPoint<S, F>,
    pub(super) part: EdgePart<S, F>,
    /// `r x e`, its square and its length.
    pub(super) w: Vec3<Lanes<S, F>>,
    pub(super) square: Lanes<S, F>,
    pub(super) moment: Lanes<S, F>,
}

impl<S: Simd, F: Lane> Span<S, F> {
    /// A whole edge from a point at a height over the horizon.
    #[inline(always)]
    pub(super) fn whole(edge: LaneEdge<S, F>, (start, height): (SeenPoint<S, F>, Lanes<S, F>), end: SeenPoint<S, F>) -> Self {
        Self::piece(edge, (start.r, height), (start, end), EdgePart::Whole)
    }

    /// A piece of the edge that starts at an offset, at a height over the horizon.
    #[inline(always)]
    pub(super) fn piece(
        edge: LaneEdge<S, F>,
        (r, height): (Vec3<Lanes<S, F>>, Lanes<S, F>),
        (start, end): (SeenPoint<S, F>, SeenPoint<S, F>),
        part: EdgePart<S, F>,
    ) -> Self {
        let w = r.cross(edge.e);
        let square = w.norm_squared();
        Self { edge, r, height, start, end, part, w, square, moment: square.sqrt() }
    }
}

/// How much of an edge is visible.
pub(super) enum EdgePart<S: Simd, F: Lane> {
    /// All of it, in all lanes.
    Whole,
    /// A fraction of it, where there is any; the bounds count it in more lanes.
    Clipped { fraction: Lanes<S, F>, any: Mask<S, F>, bounds: Mask<S, F> },
}

impl<S: Simd, F: Lane> EdgePart<S, F> {
    /// The visible part of a length.
    #[inline(always)]
    pub(super) fn clip(&self, length: Lanes<S, F>) -> Lanes<S, F> {
        match self {
            Self::Whole => length,
            Self::Clipped { fraction, .. } => length * *fraction,
        }
    }

    /// Where there is any, unless it is there in all lanes.
    #[inline(always)]
    pub(super) fn mask(&self) -> Option<Mask<S, F>> {
        match self {
            Self::Whole => None,
            Self::Clipped { any, .. } => Some(*any),
        }
    }

    /// A term where there is any.
    #[inline(always)]
    pub(super) fn visible(&self, simd: S, term: Lanes<S, F>) -> Lanes<S, F> {
        match self.mask() {
            None => term,
            Some(any) => any.select(term, constant(simd, 0.0)),
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

/// The quantities that the terms of an edge's visible piece need besides its angle.
pub(super) struct EdgeTerms<S: Simd, F: Lane> {
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

impl<S: Simd, F: Lane> Clone for EdgeTerms<S, F> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<S: Simd, F: Lane> Copy for EdgeTerms<S, F> {}

impl<S: Simd, F: Lane> EdgeTerms<S, F> {
    #[inline(always)]
    pub(super) fn none(simd: S) -> Self {
        let zero = constant(simd, 0.0);
        Self { inline: zero, ends: zero, product: zero, lit: zero, reach: zero, level: zero, toward: zero }
    }

    /// Given `p.p'`.
    #[inline(always)]
    pub(super) fn new<const GRADIENT: bool>(
        simd: S,
        n1: Vec3<Lanes<S, F>>,
        Span { edge, r, height, start, end, part, w, square, .. }: &Span<S, F>,
        inline: Lanes<S, F>,
    ) -> Self {
        let ends = start.square * end.square;
        let product = constant(simd, 1.0) / (*square * ends);
        let terms = Self { inline, ends, product, lit: n1.dot(*w), ..Self::none(simd) };
        if !GRADIENT {
            return terms;
        }
        let along = start.r.dot(edge.e);
        let reach = (along + along + part.clip(edge.square)) * edge.inverse;
        let along = if matches!(part, EdgePart::Clipped { .. }) { r.dot(edge.e) } else { along };
        let level = n1.dot(edge.e);
        Self { reach, level, toward: *height * edge.square - along * level, ..terms }
    }
}

/// How the horizon's crossing points are conditioned, on lanes where there are any; zero elsewhere.
pub(super) struct Crossing<S: Simd, F: Lane> {
    /// The largest `1/|p|^2`.
    pub(super) nearest: Lanes<S, F>,
    /// The largest `|e|^2/(d^2 |p|^2)`.
    pub(super) slant: Lanes<S, F>,
}
