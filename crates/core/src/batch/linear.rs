//! The sums over the boundary of a linear emitter, on lanes of double precision: [`crate::forms::linear`] in a form for lanes.
//!
//! With the emission `beta + gB.(y - x)` over the plane, `nu = n1.n2` and `gamma = gB.n1`, all that value and gradient take are
//! four scalar sums and a vector's:
//! - `P = sum g n1.N`, `G = sum g gB.N`, the angles' moments;
//! - `X1 = int dA/r^2`, by segments of the boundary as in [`crate::forms::segment`], whose lengths along, beside and from x all come
//!   times |e|, so that no root is taken of it;
//! - `C = n1 . contour`, of which an edge adds `(n1.m) [kappa g (gB.m) + L (gB.e)]/e^2`, `m = e x n2`, `L = ln |p'|/|p|`;
//! - the edges' part of the gradient, `w/m^2 {[cc T + cs V] b + [cs T + ss V] S g2}` in the symbols of [`crate::batch::edge`],
//!   `T` and `V` n1 along the two axes times |e|, b the emission at the line's point nearest to the receiver,
//!   `S g2 = m (gB.e)/e^2`.
//!
//! Then `Q = (X1 gamma - C)/2 + nu G/2`, radiosity `(rho/pi) (h Q - beta P/2)` and gradient `(rho/pi) (n2 Q - gB P/2 - edges/2)`.
//! The horizon's arc has `N = -n1` and its segment runs along `t = n1 x n2`: it adds `-g` to P, `-g gamma` to G,
//! `-(nu gamma g + L gB.t)` to C and a segment to X1. Nothing is divided by `|t|`, which is 0 for a receiver parallel to the
//! emitter.
//!
//! Single precision would cancel too much: its receivers are answered here in double precision.

mod bound;
pub(super) mod many;

use fearless_simd::{Level, Simd};
use radgrad_numbers::arithmetic::Arithmetic;
use radgrad_numbers::ball::Ball;
use radgrad_numbers::in_library;
use radgrad_numbers::lanes::angle::angle;
use radgrad_numbers::lanes::instruction_set::apart;
use radgrad_numbers::lanes::lane::{Lanes, Mask, constant, same};
use radgrad_numbers::number::ROUNDOFF;
use radgrad_numbers::real::Real;
use radgrad_numbers::vec3::Vec3;

use crate::batch::answers::Slots;
use crate::batch::emitting::{Emitting, Outlined, lanes, padded};
use crate::batch::linear::bound::Scales;
use crate::batch::receivers::Receivers;
use crate::batch::span::{EdgeTerms, Span};
use crate::batch::tile::{Goal, Settled};
use crate::batch::visible::{BoundarySums, BoundedTotal, Outline, SeenExtent};
use crate::forms::segment::X1End;
use crate::problem::emission::{Emission, Emitter};

/// Lanes of double precision, and vectors of them.
type Wide<S> = Lanes<S, f64>;
type Vector<S> = Vec3<Lanes<S, f64>>;

/// A linear emitter in normalised lengths, its emission brought to a size of about 1.
#[derive(Debug, Clone)]
pub(super) struct LinearLamp {
    outline: Outlined<f64>,
    emission: AffineEmission,
}

/// The emission of one emitter.
#[derive(Debug, Clone)]
pub(super) struct AffineEmission {
    at_vertices: Vec<f64>,
    gradient: [f64; 3],
    /// The largest of them; a bound on the gradient's length which, times 4u, bounds its error.
    largest: f64,
    steepness: f64,
    /// The largest emission plus the slope's change over the emitter: the emission anywhere on it is known to 20u of that.
    scale: f64,
    /// One over pi and the power that normalised the emission.
    brightness: f64,
}

impl AffineEmission {
    /// The emission with lengths times a power of two. `None` for other emissions, and where the plane or the emission over it is
    /// not known to a few roundings: the bound counts no more.
    pub(super) fn new(emitter: &Emitter, power: f64) -> Option<Self> {
        let (polygon, affine) = (emitter.polygon(), emitter.affine());
        let Emission::Linear(_) = emitter.emission() else { return None };
        let vertices = polygon.vertices();
        let slope = emitter.precise_gradient::<Ball<f64>>().map(|c| c.scaled(1.0 / power));
        let gradient = slope.map(|c| c.value());
        let at_vertices: Vec<f64> = (0..vertices.len()).map(|i| emitter.vertex_value(i)).collect();
        let largest = at_vertices.iter().fold(0.0, |largest: f64, b| largest.max(b.abs()));
        let slope_error = [slope.x, slope.y, slope.z].map(|c| c.error()).into_iter().fold(0.0, f64::max);
        // A slope that is known to less than 4u, as of a level emission in a tilted plane, counts as one that is.
        let steepness = (gradient.length() * (1.0 + 8.0 * ROUNDOFF)).max(slope_error / (4.0 * ROUNDOFF));
        let scale = largest + steepness * polygon.size() * power;
        let deviation = |i: usize| {
            let there = gradient.dot(Vec3::from((vertices[i] - vertices[0]) * power));
            (at_vertices[i] - at_vertices[0] - there).abs()
        };
        let is_known = emitter.vertex_error() + affine.residual <= 4.0 * ROUNDOFF * scale
            && (0..vertices.len()).all(|i| deviation(i) <= 16.0 * ROUNDOFF * scale)
            && polygon.normal_error() <= 2.0 * ROUNDOFF
            && polygon.planarity_defect() <= 4.0 * ROUNDOFF * polygon.size();
        let brightness = std::f64::consts::FRAC_1_PI / emitter.power();
        let is_ordinary = steepness == 0.0 || (2f64.powi(-400)..2f64.powi(400)).contains(&steepness);
        let in_range = brightness.is_normal() && is_ordinary && largest > 0.0;
        let gradient = [gradient.x, gradient.y, gradient.z];
        (is_known && in_range).then_some(Self { at_vertices, gradient, largest, steepness, scale, brightness })
    }
}

/// The emission of an emitter on all lanes, or of one a lane.
pub(super) trait EmissionOnLanes<S: Simd> {
    /// Where edge `index` starts and where it ends.
    fn ends(&self, simd: S, index: usize) -> [Wide<S>; 2];
    /// `gB`, its length, and the largest magnitude at a vertex.
    fn gradient(&self, simd: S) -> Vector<S>;
    fn steepness(&self, simd: S) -> Wide<S>;
    fn largest(&self, simd: S) -> Wide<S>;
}

impl<S: Simd> EmissionOnLanes<S> for &AffineEmission {
    #[inline(always)]
    fn ends(&self, simd: S, index: usize) -> [Wide<S>; 2] {
        let next = if index + 1 == self.at_vertices.len() { 0 } else { index + 1 };
        [Wide::splat(simd, self.at_vertices[index]), Wide::splat(simd, self.at_vertices[next])]
    }
    #[inline(always)]
    fn gradient(&self, simd: S) -> Vector<S> {
        same(simd, self.gradient)
    }
    #[inline(always)]
    fn steepness(&self, simd: S) -> Wide<S> {
        Wide::splat(simd, self.steepness)
    }
    #[inline(always)]
    fn largest(&self, simd: S) -> Wide<S> {
        Wide::splat(simd, self.largest)
    }
}

impl LinearLamp {
    /// `None` where [`Outlined::new`] or [`AffineEmission::new`] gives none.
    pub(super) fn new(emitter: &Emitter) -> Option<Self> {
        let Emission::Linear(_) = emitter.emission() else { return None };
        let outline = Outlined::new(emitter.polygon())?;
        let emission = AffineEmission::new(emitter, outline.power)?;
        Some(Self { outline, emission })
    }

    /// Receivers of a tile on lanes.
    pub(super) fn on_lanes(
        &self,
        level: Level,
        receivers: &Receivers<'_, f64>,
        goal: Goal,
        slots: &mut Slots<'_, f64>,
    ) -> Settled {
        padded(receivers, goal, slots, |receivers, slots| {
            let lamp = (&self.outline, self.emission.brightness, &self.emission);
            if goal.asked.gradient {
                in_library!([as_avx512 as_avx2 as_sse2] level, simd => lanes::<_, f64, _, true>(simd, receivers, lamp, goal, slots))
            } else {
                in_library!([as_avx512 as_avx2 as_sse2] level, simd => lanes::<_, f64, _, false>(simd, receivers, lamp, goal, slots))
            }
        })
    }
}

impl<'a, S: Simd> Emitting<S, f64> for &'a AffineEmission {
    type Sums = LinearSums<S, &'a AffineEmission>;

    #[inline(always)]
    fn sums<O: Outline<S, f64>>(&self, simd: S, _: usize, outline: &O, x: Vector<S>, n1: Vector<S>) -> Self::Sums {
        LinearSums::new(simd, *self, outline, x, n1)
    }
}

/// The sums, with the receiver and the emission as they enter.
pub(super) struct LinearSums<S: Simd, G> {
    emission: G,
    n2: Vector<S>,
    /// `gB`.
    gradient: Vector<S>,
    height: Wide<S>,
    beta: Wide<S>,
    /// `nu` and `gamma`.
    tilt: Wide<S>,
    slope: Wide<S>,
    /// `P`, `G`, `C` and `X1`, the last but for `pi/4` times the logarithm of the quotient.
    lit: Wide<S>,
    aimed: Wide<S>,
    contour: Wide<S>,
    x1: Wide<S>,
    quotient: Wide<S>,
    /// How many segments X1 has.
    gathered: usize,
    /// Where the first span starts, and where the last one ends.
    first: Met<S>,
    last: Met<S>,
    /// `sum 2 w/m^2 {..}`.
    edges: Vector<S>,
    /// `sum g`, and the largest `1/S^2`.
    angles: Wide<S>,
    nearest: Wide<S>,
    /// `1/|t|^2` where the horizon crosses.
    slant: Wide<S>,
}

impl<S: Simd, G: EmissionOnLanes<S>> LinearSums<S, G> {
    #[inline(always)]
    fn new<O: Outline<S, f64>>(simd: S, emission: G, outline: &O, x: Vector<S>, n1: Vector<S>) -> Self {
        let (n2, first) = (outline.normal(simd), outline.vertex(simd, 0) - x);
        let gradient = emission.gradient(simd);
        let [here, _] = emission.ends(simd, 0);
        let zero = constant(simd, 0.0);
        Self {
            emission,
            n2,
            gradient,
            height: -n2.dot(first),
            beta: here - gradient.dot(first),
            tilt: n1.dot(n2),
            slope: gradient.dot(n1),
            lit: zero,
            aimed: zero,
            contour: zero,
            x1: zero,
            quotient: constant(simd, 1.0),
            gathered: 0,
            first: Met::nowhere(simd),
            last: Met::nowhere(simd),
            edges: Vec3::new(zero, zero, zero),
            angles: zero,
            nearest: zero,
            slant: zero,
        }
    }

    /// `ln(r/h)` of the ends of a span, each computed once where the spans are joined.
    #[inline(always)]
    fn logarithms(&mut self, simd: S, [from, to]: [Wide<S>; 2]) -> [Wide<S>; 2] {
        let start = self.met(simd, from, self.last);
        if self.gathered == 0 {
            self.first = start;
        }
        self.last = self.met(simd, to, self.first);
        [start.logarithm, self.last.logarithm]
    }

    /// A point at a distance, known already if it is where another one is.
    #[inline(always)]
    fn met(&self, simd: S, square: Wide<S>, computed: Met<S>) -> Met<S> {
        let is_known = square.at_most(computed.square) & computed.square.at_most(square);
        if (!is_known).any() {
            let height = self.height * self.height;
            return Met { square, logarithm: (square / height).ln() * constant(simd, 0.5) };
        }
        computed
    }

    /// Adds the part of a segment to X1 where it counts.
    #[inline(always)]
    fn add_x1(&mut self, simd: S, (term, quotient): (Wide<S>, Wide<S>), counts: Option<Mask<S, f64>>) {
        let (term, quotient) = match counts {
            None => (term, quotient),
            Some(mask) => (mask.select(term, constant(simd, 0.0)), mask.select(quotient, constant(simd, 1.0))),
        };
        self.x1 = self.x1 + term;
        self.quotient = self.quotient * quotient;
        self.gathered += 1;
        if self.gathered.is_multiple_of(MOST_QUOTIENTS) {
            self.take_quotient(simd);
        }
    }

    /// Adds the logarithm of the quotients gathered to X1.
    #[inline(always)]
    fn take_quotient(&mut self, simd: S) {
        self.x1 = self.x1 + self.quotient.ln() * constant(simd, std::f64::consts::FRAC_PI_4);
        self.quotient = constant(simd, 1.0);
    }
}

/// Quotients whose product is a normal number: each is between `2^-33` and `2^33` on lanes that count, as an end's is
/// `(2 sin(phi + psi))^2` where that is past a right angle, and the sine at least h/R.
const MOST_QUOTIENTS: usize = 16;

/// `|p|^2` and `ln(|p|/h)` of a point.
struct Met<S: Simd> {
    square: Wide<S>,
    logarithm: Wide<S>,
}

impl<S: Simd> Clone for Met<S> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<S: Simd> Copy for Met<S> {}

impl<S: Simd> Met<S> {
    #[inline(always)]
    fn nowhere(simd: S) -> Self {
        Self { square: constant(simd, f64::NAN), logarithm: constant(simd, f64::NAN) }
    }
}

/// As [`x1_between`](crate::forms::segment::x1_between) but for the logarithm: X1 is the term and `pi/4` times that of the quotient.
#[inline(always)]
fn x1_unjoined<T: Arithmetic>([start, end]: [[T; 3]; 2], signed: T) -> (T, T) {
    let (term, back) = (end[0] - start[0], signed.like(0.0).exceeds(signed));
    let (forward, backward) = (end[1] * start[2], end[2] * start[1]);
    (T::choose(back, -term, term), T::choose(back, backward, forward) / T::choose(back, forward, backward))
}

/// A segment's part of X1 between two places along it, as [`x1_unjoined`] gives it, from the distance of its line from x, that of
/// x's foot beside it, `ln(r/h)` there, and the angle between them seen from x, which is that between their psi.
#[inline(always)]
fn x1<S: Simd>(
    simd: S,
    places: [Wide<S>; 2],
    distances: [Wide<S>; 2],
    logarithms: [Wide<S>; 2],
    g: Wide<S>,
) -> (Wide<S>, Wide<S>) {
    apart(
        simd,
        ([places, distances, logarithms], g),
        #[inline(always)]
        |([[from, to], [distance, beside], [here, there]], g): ([[Wide<S>; 2]; 3], Wide<S>)| {
            // A foot at the end of a segment has no direction: any will do.
            let d = beside.abs().max(constant(simd, f64::MIN_POSITIVE));
            let distances = [d, distance, distance + d];
            let psi = from.abs().atan2_right(distance);
            let start = X1End::at_angle(from.abs(), psi, distances, here).on_side_of(from);
            let end = X1End::at_angle(to.abs(), (psi.copysign(from) + g).abs(), distances, there).on_side_of(to);
            x1_unjoined([start, end], beside)
        },
    )
}

impl<S: Simd, G: EmissionOnLanes<S>> BoundarySums<S, f64> for LinearSums<S, G> {
    const FACTOR: f64 = 1.0;

    #[inline(always)]
    fn add_one<const GRADIENT: bool>(
        &mut self,
        simd: S,
        n1: Vector<S>,
        span: &Span<S, f64>,
        terms: &EdgeTerms<S, f64>,
        g: Wide<S>,
    ) {
        let Span { edge, r, start, end, part, w, square, moment, .. } = span;
        let EdgeTerms { inline, ends, product, lit, reach, level, toward } = *terms;
        let inverse_square = product * ends;
        let inverse = *moment * inverse_square;
        let turn = g * inverse;
        let beside = self.n2.dot(*w);
        let places = [start.r.dot(edge.e), end.r.dot(edge.e)];
        let logarithms = self.logarithms(simd, [start.square, end.square]);
        let outward = edge.e.cross(self.n2);
        let [here, next] = self.emission.ends(simd, edge.index);
        let rise = next - here;
        let flux = beside * turn * self.gradient.dot(outward) + (logarithms[1] - logarithms[0]) * rise;
        self.lit = self.lit + part.visible(simd, turn * lit);
        self.aimed = self.aimed + part.visible(simd, turn * self.gradient.dot(*w));
        self.contour = self.contour + part.visible(simd, n1.dot(outward) * edge.inverse * flux);
        self.add_x1(simd, x1(simd, places, [*moment, beside], logarithms, g), part.mask());
        if GRADIENT {
            let sine = part.clip(*moment) * (product * *square);
            let nearest = *square * edge.inverse;
            let cc = g + sine * ((nearest + nearest) - inline);
            let cs = (sine * *moment) * reach;
            let ss = (g + g) - cc;
            let toward = toward * inverse;
            let steps = rise * edge.inverse;
            let emitted = here - steps * r.dot(edge.e);
            let along = steps * *moment;
            let weight = (cc * toward + cs * level) * emitted + (cs * toward + ss * level) * along;
            self.edges = self.edges + *w * part.visible(simd, weight * inverse_square);
        }
        self.nearest = self.nearest.max(part.counted(simd, edge.square * inverse_square));
        self.angles = self.angles + part.counted(simd, g);
    }

    #[inline(always)]
    fn close(&mut self, simd: S, n1: Vector<S>, has_left: Mask<S, f64>, exit: Vector<S>, entry: Vector<S>) {
        let (zero, one) = (constant(simd, 0.0), constant(simd, 1.0));
        let g = has_left.select(angle(simd, -n1.dot(exit.cross(entry)), exit.dot(entry)), zero);
        let t = n1.cross(self.n2);
        let square = self.height * self.height;
        let logarithms =
            self.logarithms(simd, [has_left.select(exit.norm_squared(), square), has_left.select(entry.norm_squared(), square)]);
        self.lit = self.lit - g;
        self.aimed = self.aimed - g * self.slope;
        self.contour = self.contour - (self.tilt * self.slope * g + (logarithms[1] - logarithms[0]) * self.gradient.dot(t));
        let distances = [self.height, -(self.height * self.tilt)];
        self.add_x1(simd, x1(simd, [exit.dot(t), entry.dot(t)], distances, logarithms, g), Some(has_left));
        self.slant = has_left.select(one / has_left.select(t.norm_squared(), one), zero);
    }

    #[inline(always)]
    fn total<const GRADIENT: bool>(mut self, simd: S, extent: &SeenExtent<S, f64>) -> (BoundedTotal<S, f64>, Mask<S, f64>) {
        self.take_quotient(simd);
        let half = constant(simd, 0.5);
        let lit = self.lit * half;
        let q = (self.x1 * self.slope - self.contour + self.tilt * self.aimed) * half;
        let value = self.height * q - self.beta * lit;
        let mut gradient = self.edges;
        if GRADIENT {
            gradient = self.n2 * q - self.gradient * lit - self.edges * half;
        }
        let scales = Scales::new(simd, &self, extent);
        let holds = scales.conditioned(simd, value);
        ((value, gradient, scales.bound::<GRADIENT>(simd)), holds)
    }
}
