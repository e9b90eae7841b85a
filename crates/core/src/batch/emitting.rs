//! An outline in the precision of the lanes, how it emits, and receivers of it a vector at a time.

use fearless_simd::Simd;
use radgrad_numbers::lanes::lane::{Lane, Lanes, MOST_LANES, align_frame, constant, load, same};
use radgrad_numbers::number::ROUNDOFF;
use radgrad_numbers::power::normalising_power;
use radgrad_numbers::vec3::Vec3;

use crate::batch::answers::Slots;
use crate::batch::many_emitters::Work;
use crate::batch::receivers::Receivers;
use crate::batch::span::LaneEdge;
use crate::batch::sums::ConstantSums;
use crate::batch::tile::{Goal, Scale, Settled, settle, windows};
use crate::batch::visible::{BoundarySums, Outline, find};
use crate::problem::emission::{Emission, Emitter};
use crate::problem::polygon::Polygon;

/// An emitter's outline in the precision of the lanes, in normalised lengths.
#[derive(Debug, Clone)]
pub(super) struct Outlined<F> {
    corners: Vec<EmitterCorner<F>>,
    normal: [F; 3],
    height_share: F,
    /// Multiplies all lengths.
    pub(super) power: F,
}

/// A vertex, and the edge that starts there with its squared length.
#[derive(Debug, Clone, Copy)]
struct EmitterCorner<F> {
    vertex: [F; 3],
    e: [F; 3],
    square: F,
    inverse: F,
}

impl<F: Lane> Outlined<F> {
    /// `None` where the precision cannot hold the vertices as they are.
    pub(super) fn new(polygon: &Polygon) -> Option<Self> {
        let power = power::<F>(polygon.size());
        let vertices = polygon.vertices();
        let holds = |value: f64| F::nearest(value).to_double() == value;
        let held = vertices.iter().flat_map(|v| (*v * power).to_array()).chain([power, 1.0 / power]).all(holds);
        let corner = |i: usize| {
            let e = (vertices[(i + 1) % vertices.len()] - vertices[i]) * power;
            let square = e.length_squared();
            EmitterCorner {
                vertex: (vertices[i] * power).to_array().map(F::nearest),
                e: e.to_array().map(F::nearest),
                square: F::nearest(square),
                inverse: F::nearest(1.0 / square),
            }
        };
        let corners: Vec<EmitterCorner<F>> = (0..vertices.len()).map(corner).collect();
        let long = corners.iter().all(|corner| corner.square.to_double() >= F::SHORTEST * F::SHORTEST);
        (held && long).then(|| Self {
            corners,
            normal: polygon.normal().to_array().map(F::nearest),
            height_share: height_share(polygon, power),
            power: F::nearest(power),
        })
    }
}

/// Bound on the error of a height over the polygon's plane, as a share of the distance, squared: 16 units of roundoff, the error of
/// the normal, and the vertices' distances from the plane. Over a plane across an axis it is a difference of two coordinates, with
/// the right sign.
pub(super) fn height_share<F: Lane>(polygon: &Polygon, power: f64) -> F {
    let first = polygon.vertices()[0].to_array();
    let across = |axis: usize| polygon.vertices().iter().all(|v| v.to_array()[axis] == first[axis]);
    let along_axis = polygon.normal().abs().to_array().iter().filter(|c| **c == 0.0).count() == 2;
    if power == 1.0 && along_axis && (0..3).any(across) {
        return F::default();
    }
    // The farthest vertex is at half the size at least.
    let slab = 2.0 * polygon.half_slab() / polygon.size();
    let share = 16.0 * F::ROUNDOFF + 2.0 * polygon.normal_error() + 4.0 * ROUNDOFF + slab * (1.0 + 1e-6);
    F::nearest(share * share)
}

/// The power of two that lengths are multiplied by: 1 for emitters of an ordinary size.
pub(super) fn power<F: Lane>(size: f64) -> f64 {
    if 1.0 / F::UNSCALED <= size && size <= F::UNSCALED { 1.0 } else { normalising_power(size) }
}

impl<S: Simd, F: Lane> Outline<S, F> for Outlined<F> {
    #[inline(always)]
    fn count(&self) -> usize {
        self.corners.len()
    }
    #[inline(always)]
    fn vertex(&self, simd: S, index: usize) -> Vec3<Lanes<S, F>> {
        same(simd, self.corners[index].vertex)
    }
    #[inline(always)]
    fn edge(&self, simd: S, index: usize) -> LaneEdge<S, F> {
        let EmitterCorner { e, square, inverse, .. } = &self.corners[index];
        LaneEdge { index, e: same(simd, *e), square: Lanes::splat(simd, *square), inverse: Lanes::splat(simd, *inverse) }
    }
    #[inline(always)]
    fn normal(&self, simd: S) -> Vec3<Lanes<S, F>> {
        same(simd, self.normal)
    }
    #[inline(always)]
    fn height_share(&self, simd: S) -> Lanes<S, F> {
        Lanes::splat(simd, self.height_share)
    }
}

/// `B/pi` of a constant emitter, where that is a normal number.
pub(super) fn brightness<F: Lane>(emitter: &Emitter) -> Option<F> {
    let Emission::Constant(value) = emitter.emission() else { return None };
    let brightness = F::nearest(value / std::f64::consts::PI);
    let size = brightness.to_double().abs();
    (F::TINY <= size && size <= F::LARGEST).then_some(brightness)
}

/// How outlines emit.
pub(super) trait Emitting<S: Simd, F: Lane> {
    /// The sums over the boundary.
    type Sums: BoundarySums<S, F>;

    /// No terms yet, for receivers at `x` with unit normals n1 and the emitters from `first` on: one on all lanes, or one a lane.
    fn sums<O: Outline<S, F>>(
        &self,
        simd: S,
        first: usize,
        outline: &O,
        x: Vec3<Lanes<S, F>>,
        n1: Vec3<Lanes<S, F>>,
    ) -> Self::Sums;
}

/// The same everywhere, as much as the brightness says.
pub(super) struct Uniformly;

impl<S: Simd, F: Lane> Emitting<S, F> for Uniformly {
    type Sums = ConstantSums<S, F>;

    #[inline(always)]
    fn sums<O: Outline<S, F>>(&self, simd: S, _: usize, _: &O, _: Vec3<Lanes<S, F>>, _: Vec3<Lanes<S, F>>) -> ConstantSums<S, F> {
        ConstantSums::new(simd)
    }
}

/// Answers receivers; where they are fewer than fill a vector, with the last one again and again.
pub(super) fn padded<F: Lane>(
    receivers: &Receivers<'_, F>,
    goal: Goal,
    slots: &mut Slots<'_, F>,
    answer: impl FnOnce(&Receivers<'_, F>, &mut Slots<'_, F>) -> Settled,
) -> Settled {
    let count = receivers.count();
    if count >= MOST_LANES {
        return answer(receivers, slots);
    }
    let pad = |slice: &[F]| -> [F; MOST_LANES] { std::array::from_fn(|i| slice[i.min(slice.len() - 1)]) };
    let (position, normal) = (receivers.position.map(pad), receivers.normal.map(pad));
    let reflectance = pad(receivers.reflectance);
    let more = Receivers {
        position: position.each_ref().map(<[F; MOST_LANES]>::as_slice),
        normal: normal.each_ref().map(<[F; MOST_LANES]>::as_slice),
        reflectance: &reflectance,
    };
    let mut work = Work::new();
    let settled = answer(&more, &mut work.slots(MOST_LANES, goal.asked));
    work.copy_to(slots);
    settled.first(count)
}

/// Receivers, a vector at a time, of an outline with its brightness and how it emits.
#[inline(always)]
pub(super) fn lanes<S: Simd, F: Lane, E: Emitting<S, F>, const GRADIENT: bool>(
    simd: S,
    receivers: &Receivers<'_, F>,
    (outline, brightness, emitting): (&Outlined<F>, F, E),
    goal: Goal,
    slots: &mut Slots<'_, F>,
) -> Settled {
    align_frame();
    let mut settled = Settled::default();
    let power = Lanes::splat(simd, outline.power);
    let brightness = Lanes::splat(simd, brightness) * constant(simd, E::Sums::FACTOR);
    let Receivers { position: [x, y, z], normal: [nx, ny, nz], reflectance } = *receivers;
    // As long as each other, which is seen once for all.
    let (y, z, nx, ny, nz) = (&y[..x.len()], &z[..x.len()], &nx[..x.len()], &ny[..x.len()], &nz[..x.len()]);
    let reflectance = if reflectance.len() == 1 { reflectance } else { &reflectance[..x.len()] };
    for first in windows(x.len(), Lanes::<S, F>::COUNT) {
        let position = load(simd, [&x[first..], &y[first..], &z[first..]]) * power;
        let normal = load(simd, [&nx[first..], &ny[first..], &nz[first..]]);
        let square = normal.norm_squared();
        let n1 = normal * (constant(simd, 1.0) / square.sqrt());
        let rho =
            if reflectance.len() == 1 { Lanes::splat(simd, reflectance[0]) } else { Lanes::load(simd, &reflectance[first..]) };
        let sums = emitting.sums(simd, 0, outline, position, n1);
        // Squares that were not rounded to a subnormal number, nor infinite: else the normal has no digits, and the scalar path
        // divides by a power of two first.
        let has_digits = constant(simd, F::TINY / (F::ROUNDOFF * F::ROUNDOFF)).at_most(square);
        let visible = find::<S, F, _, _, GRADIENT>(simd, outline, ((position, n1), has_digits), goal.asked.errors, sums);
        let scale = Scale::new(simd, brightness, rho, power);
        settle::<S, F, GRADIENT>(simd, &visible, &scale, goal.tolerance, (slots, first), &mut settled);
    }
    settled
}
