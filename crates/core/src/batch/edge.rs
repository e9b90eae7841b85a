//! The sums over the edges of a constant emitter, on lanes: HS95 Eqs. 10, 11 and A.1 in a form that needs one square root, two
//! divisions and one arc tangent an edge.
//!
//! For an edge e from `r` to `r'` (offsets from the receiver) and its visible part from p to p', the fraction f of it: `w = r x
//! e`, `m = |w|`, `S = m/|e|` the distance of the line, `N = w/m`, `g` the angle from p to p', and psi the angle from the nearest
//! point of the line,
//! - value: `-1/2 sum g n1.N`, `g = atan2(f m, p.p')`;
//! - gradient: `-sum (N/S) (cc p1 + cs p2)`, as in [`crate::forms::constant`], with `2 cc = g + sin g cos(psi + psi')` and
//!   `2 cs = sin g sin(psi + psi')`. Since `|p| cos psi = S` and `|p| sin psi |e| = p.e`, no end direction is normalised:
//!   `sin g = f m/(|p||p'|)`, `cos(psi + psi') |p||p'| = 2 S^2 - p.p'`, `sin(psi + psi') |p||p'| = S (p + p').e/|e|`; and
//!   `p1 = n1.toward = t/(m |e|)`, `t = h e^2 - (r.e) (n1.e)`, h = n1.r, `p2 = n1.e/|e|`. With `m = S |e|` and `q = f/(p^2 p'^2)`
//!   an edge adds, twice over, w times `t [g/m^3 + q (2/e^2 - p.p'/m^2)]` and times `q (n1.e) (p + p').e/e^2`. Lengths of edges
//!   occur squared only.
//!
//! Nothing is recomputed for the whole edge of an unclipped lane: f = 1, p = r, p' = r', to the last digit.

use fearless_simd::Simd;
use radgrad_numbers::lanes::angle::angle;
use radgrad_numbers::lanes::lane::{Lane, Lanes, Mask, constant};
use radgrad_numbers::vec3::Vec3;

use crate::batch::bound::{bound, conditioned};
use crate::batch::span::{EdgeTerms, Span};
use crate::batch::sums::ConstantSums;
use crate::batch::visible::{BoundarySums, BoundedTotal, SeenExtent};

impl<S: Simd, F: Lane> BoundarySums<S, F> for ConstantSums<S, F> {
    const FACTOR: f64 = -0.5;

    #[inline(always)]
    fn add_one<const GRADIENT: bool>(
        &mut self,
        simd: S,
        _: Vec3<Lanes<S, F>>,
        Span { edge, part, w, square, moment, .. }: &Span<S, F>,
        EdgeTerms { inline, ends, product, lit, reach, level, toward }: &EdgeTerms<S, F>,
        g: Lanes<S, F>,
    ) {
        let inverse_square = *product * *ends;
        let turn = g * (*moment * inverse_square);
        self.value = self.value + part.visible(simd, turn * *lit);
        if GRADIENT {
            let between = part.clip(*product * *square);
            let straight = (edge.inverse + edge.inverse) - *inline * inverse_square;
            let term = *toward * (inverse_square * turn + between * straight) + (between * *reach) * *level;
            self.gradient = self.gradient + *w * part.visible(simd, term);
        }
        self.nearest = self.nearest.max(part.counted(simd, edge.square * inverse_square));
        self.angles = self.angles + part.counted(simd, g);
    }

    /// The horizon's `n1.N` is -1.
    #[inline(always)]
    fn close(&mut self, simd: S, n1: Vec3<Lanes<S, F>>, has_left: Mask<S, F>, exit: Vec3<Lanes<S, F>>, entry: Vec3<Lanes<S, F>>) {
        let closed = angle(simd, -n1.dot(exit.cross(entry)), exit.dot(entry));
        self.value = self.value - has_left.select(closed, constant(simd, 0.0));
    }

    #[inline(always)]
    fn total<const GRADIENT: bool>(self, simd: S, extent: &SeenExtent<S, F>) -> (BoundedTotal<S, F>, Mask<S, F>) {
        let SeenExtent { edges, tight, farthest_square, crossing } = extent;
        let crossing = crossing.as_ref().map(|(crossing, _)| crossing);
        let holds = conditioned(simd, &self, crossing, *farthest_square);
        let bound = bound::<S, F, GRADIENT>(simd, (*edges, *tight), &self, crossing, *farthest_square);
        ((self.value, self.gradient, bound), holds)
    }
}
