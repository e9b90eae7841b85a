//! Many receivers against one emitter: receivers on lanes, the outline the same on all.

use fearless_simd::{Level, Simd};

use super::answers::{Answers, Counts, Slots};
use super::edge::{Edge, Sums};
use super::lanes::{Lane, Lanes, MOST_LANES, align_frame, constant, load, on_level, same};
use super::linear::LinearLamp;
use super::tile::{Entries, Goal, Scale, Settled, TILE, each, put, settle, windows};
use super::visible::{BoundarySums, Outline, find};
use super::{Precision, Receivers};
use crate::evaluate::Method;
use crate::geometry::normalising_power;
use crate::number::ROUNDOFF;
use crate::vec3::Vec3;
use crate::{Emission, Emitter, Error, Polygon};

/// An emitter's outline in the precision of the lanes, in normalised lengths.
#[derive(Debug, Clone)]
pub(super) struct Outlined<F> {
    corners: Vec<Corner<F>>,
    normal: [F; 3],
    height_share: F,
    /// Multiplies all lengths.
    pub(super) power: F,
}

/// A vertex, and the edge that starts there with its squared length.
#[derive(Debug, Clone, Copy)]
struct Corner<F> {
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
            Corner {
                vertex: (vertices[i] * power).to_array().map(F::nearest),
                e: e.to_array().map(F::nearest),
                square: F::nearest(square),
                inverse: F::nearest(1.0 / square),
            }
        };
        let corners: Vec<Corner<F>> = (0..vertices.len()).map(corner).collect();
        let long = corners.iter().all(|corner| corner.square.to_double() >= F::SHORTEST * F::SHORTEST);
        (held && long).then(|| Self {
            corners,
            normal: polygon.normal().to_array().map(F::nearest),
            height_share: height_share(polygon, power),
            power: F::nearest(power),
        })
    }
}

/// What a height over the polygon's plane may err by, as a share of the distance, squared: 16 units of roundoff and what the normal
/// errs by. Over a plane across an axis it is a difference of two coordinates, with the right sign.
pub(super) fn height_share<F: Lane>(polygon: &Polygon, power: f64) -> F {
    let first = polygon.vertices()[0].to_array();
    let across = |axis: usize| polygon.vertices().iter().all(|v| v.to_array()[axis] == first[axis]);
    let along_axis = polygon.normal().abs().to_array().iter().filter(|c| **c == 0.0).count() == 2;
    if power == 1.0 && along_axis && (0..3).any(across) {
        return F::default();
    }
    let share = 16.0 * F::ROUNDOFF + 2.0 * polygon.normal_error() + 4.0 * ROUNDOFF;
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
    fn edge(&self, simd: S, index: usize) -> Edge<S, F> {
        let Corner { e, square, inverse, .. } = &self.corners[index];
        Edge { index, e: same(simd, *e), square: Lanes::all(simd, *square), inverse: Lanes::all(simd, *inverse) }
    }
    #[inline(always)]
    fn normal(&self, simd: S) -> Vec3<Lanes<S, F>> {
        same(simd, self.normal)
    }
    #[inline(always)]
    fn height_share(&self, simd: S) -> Lanes<S, F> {
        Lanes::all(simd, self.height_share)
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
    /// What their boundary is summed by.
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
    type Sums = Sums<S, F>;

    #[inline(always)]
    fn sums<O: Outline<S, F>>(&self, simd: S, _: usize, _: &O, _: Vec3<Lanes<S, F>>, _: Vec3<Lanes<S, F>>) -> Sums<S, F> {
        Sums::new(simd)
    }
}

/// A constant emitter in the precision of the lanes.
#[derive(Debug, Clone)]
struct Lamp<F> {
    outline: Outlined<F>,
    brightness: F,
}

impl<F: Lane> Lamp<F> {
    fn new(emitter: &Emitter) -> Option<Self> {
        let brightness = brightness(emitter)?;
        Outlined::new(emitter.polygon()).map(|outline| Self { outline, brightness })
    }
}

/// An emitter on lanes of double precision.
#[derive(Debug, Clone)]
enum Double {
    /// For what single precision does not settle.
    Constant(Lamp<f64>),
    /// In either precision.
    Linear(LinearLamp),
}

impl Double {
    fn new<F: Lane>(emitter: &Emitter) -> Option<Self> {
        let constant = if F::IS_SINGLE { Lamp::new(emitter) } else { None };
        constant.map(Self::Constant).or_else(|| LinearLamp::new(emitter).map(Self::Linear))
    }

    fn on_lanes(&self, level: Level, receivers: &Receivers<'_, f64>, goal: Goal, slots: &mut Slots<'_, f64>) -> Settled {
        match self {
            Self::Constant(lamp) => on_lanes(level, receivers, lamp, goal, slots),
            Self::Linear(lamp) => lamp.on_lanes(level, receivers, goal, slots),
        }
    }
}

/// Many receivers and their emitter.
pub(super) struct OneEmitter<'a, F> {
    receivers: Receivers<'a, F>,
    emitter: &'a Emitter,
    lamp: Option<Lamp<F>>,
    /// For what the lanes of that do not settle.
    double: Option<Double>,
    goal: Goal,
    level: Level,
}

impl<'a, F: Precision> OneEmitter<'a, F> {
    pub(super) fn new(receivers: Receivers<'a, F>, emitter: &'a Emitter, goal: Goal, level: Level) -> Self {
        Self { receivers, emitter, lamp: Lamp::new(emitter), double: Double::new::<F>(emitter), goal, level }
    }

    /// Answers the receivers from `start` on.
    pub(super) fn tile(&self, start: usize, mut slots: Slots<'_, F>) -> Result<Counts, Error> {
        let length = slots.radiosity.len();
        let receivers = self.receivers.part(start..start + length);
        let on_lanes = |lamp| on_lanes(self.level, &receivers, lamp, self.goal, &mut slots);
        let settled = self.lamp.as_ref().map_or_else(Settled::default, on_lanes);
        let mut counts = settled.counts();
        let mut open = settled.open(length);
        if let Some(lamp) = &self.double
            && open != 0
        {
            open = self.doubled(&receivers, lamp, open, (&mut slots, &mut counts))?;
        }
        for entry in each(open) {
            let in_batch = |error| Error::InBatch { index: start + entry, error: Box::new(error) };
            let answer = self.goal.single(&receivers.receiver(entry).map_err(in_batch)?, self.emitter).map_err(in_batch)?;
            put(&mut slots, entry, &answer).map_err(in_batch)?;
            *if answer.method == Method::Zero { &mut counts.zero } else { &mut counts.single } += 1;
        }
        Ok(counts)
    }

    /// Answers open entries on lanes of double precision; returns those that are still open.
    #[cold]
    fn doubled(
        &self,
        receivers: &Receivers<'_, F>,
        lamp: &Double,
        open: Entries,
        (slots, counts): (&mut Slots<'_, F>, &mut Counts),
    ) -> Result<Entries, Error> {
        let mut values = [[0.0; TILE]; 7];
        let count = open.count_ones() as usize;
        for (place, entry) in each(open).enumerate() {
            let at = |slice: &[F]| slice[if slice.len() == 1 { 0 } else { entry }].to_double();
            let all = receivers.position.iter().chain(&receivers.normal).chain([&receivers.reflectance]);
            values.iter_mut().zip(all).for_each(|(values, slice)| values[place] = at(slice));
        }
        let [x, y, z, nx, ny, nz, reflectance] = values.each_ref().map(|values| &values[..count]);
        let receivers = Receivers { position: [x, y, z], normal: [nx, ny, nz], reflectance };
        let mut answers = Answers::new();
        let settled = {
            let mut slots = answers.sized(count, self.goal.asked);
            lamp.on_lanes(self.level, &receivers, self.goal.doubled(), &mut slots)
        };
        *counts += Counts { doubled: if F::IS_SINGLE { count } else { 0 }, ..settled.counts() };
        let mut left = 0;
        let still_open = settled.open(count);
        for (place, entry) in each(open).enumerate() {
            if still_open >> place & 1 == 1 {
                left |= 1 << entry;
            } else {
                put(slots, entry, &answers.answer(place))?;
            }
        }
        Ok(left)
    }
}

/// Receivers of a tile on lanes.
fn on_lanes<F: Precision>(
    level: Level,
    receivers: &Receivers<'_, F>,
    Lamp { outline, brightness }: &Lamp<F>,
    goal: Goal,
    slots: &mut Slots<'_, F>,
) -> Settled {
    padded(receivers, goal, slots, |receivers, slots| {
        let lamp = (outline, *brightness, Uniformly);
        if goal.asked.gradient {
            on_level!(level, simd => lanes::<_, F, _, true>(simd, receivers, lamp, goal, slots))
        } else {
            on_level!(level, simd => lanes::<_, F, _, false>(simd, receivers, lamp, goal, slots))
        }
    })
}

/// Answers receivers; where they are fewer than fill a vector, with the last one again and again.
pub(super) fn padded<F: Precision>(
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
    let mut answers = Answers::new();
    let settled = answer(&more, &mut answers.sized(MOST_LANES, goal.asked));
    slots.copy_first(&answers);
    settled.first(count)
}

/// Receivers, a vector at a time, of an outline with its brightness and how it emits.
#[inline(always)]
pub(super) fn lanes<S: Simd, F: Precision, E: Emitting<S, F>, const GRADIENT: bool>(
    simd: S,
    receivers: &Receivers<'_, F>,
    (outline, brightness, emitting): (&Outlined<F>, F, E),
    goal: Goal,
    slots: &mut Slots<'_, F>,
) -> Settled {
    align_frame();
    let mut settled = Settled::default();
    let power = Lanes::all(simd, outline.power);
    let brightness = Lanes::all(simd, brightness) * constant(simd, E::Sums::FACTOR);
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
            if reflectance.len() == 1 { Lanes::all(simd, reflectance[0]) } else { Lanes::load(simd, &reflectance[first..]) };
        let sums = emitting.sums(simd, 0, outline, position, n1);
        let mut found = find::<S, F, _, _, GRADIENT>(simd, outline, (position, n1), goal.asked.errors, sums);
        // Squares that were not rounded to a subnormal number, nor infinite.
        found.good = found.good & constant(simd, F::TINY / (F::ROUNDOFF * F::ROUNDOFF)).at_most(square);
        let scale = Scale::new(simd, brightness, rho, power);
        settle::<S, F, GRADIENT>(simd, &found, &scale, goal.tolerance, (slots, first), &mut settled);
    }
    settled
}
