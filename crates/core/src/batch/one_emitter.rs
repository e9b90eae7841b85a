//! Many receivers against one emitter: receivers on lanes, the outline the same on all.

use fearless_simd::Level;
use glam::DVec3;
use radgrad_numbers::in_library;
use radgrad_numbers::lanes::lane::Lane;

use crate::batch::answers::{Counts, Slots};
use crate::batch::emitting::{Outlined, Uniformly, brightness, lanes, padded};
use crate::batch::linear::LinearLamp;
use crate::batch::many_emitters::Work;
use crate::batch::receivers::Receivers;
use crate::batch::tile::{Entries, Goal, Settled, TILE, each, put};
use crate::error::Error;
use crate::ladder::answer::Method;
use crate::problem::affine::larger;
use crate::problem::emission::Emitter;
use crate::problem::polygon::Polygon;
use crate::problem::triangulate::Few;

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
    /// A constant emitter, for entries that single precision does not settle.
    Constant(Lamp<f64>),
    /// A linear emitter, in either precision.
    Linear(LinearLamp),
}

/// The function that answers the receivers of a tile.
type OnTile<F> = fn(&LinearLamp, Level, &Receivers<'_, F>, Goal, &mut Slots<'_, F>) -> Settled;

/// The precision of a batch.
pub(super) trait LinearOnLanes: Lane {
    /// How it takes linear emitters, if it does not cancel too much.
    const LINEAR: Option<OnTile<Self>>;
}

impl LinearOnLanes for f64 {
    const LINEAR: Option<OnTile<Self>> = Some(LinearLamp::on_lanes);
}

impl LinearOnLanes for f32 {
    const LINEAR: Option<OnTile<Self>> = None;
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

/// An emitter as lanes take it.
#[derive(Debug, Clone)]
pub(super) struct OnLanes<F> {
    lamp: Option<Lamp<F>>,
    /// The lamp in double precision, for entries that its lanes do not settle.
    double: Option<Double>,
}

impl<F: Lane> OnLanes<F> {
    pub(super) fn new(emitter: &Emitter) -> Self {
        Self { lamp: Lamp::new(emitter), double: Double::new::<F>(emitter) }
    }
}

/// Much above the root of the roundings of distances.
const MARGIN: f64 = 1e-6;

/// A sphere around a polygon.
#[derive(Debug, Clone, Copy)]
struct Sphere {
    centre: DVec3,
    radius: f64,
}

impl Sphere {
    fn around(polygon: &Polygon) -> Self {
        let vertices = polygon.vertices();
        let centre = vertices.iter().sum::<DVec3>() / vertices.len() as f64;
        let radius = vertices.iter().map(|v| v.distance(centre)).fold(0.0, larger);
        Self { centre, radius: radius * (1.0 + MARGIN) }
    }

    /// Whether two spheres are surely apart, seen from a point: the cosine of the angle between their centres is below that of the sum of the angles
    /// that they subtend. Distances in a range whose squares are far from that of doubles have all their digits but a few, and so has a square
    /// root of one less a square, but for the root of these.
    fn is_apart_from(&self, other: &Self, point: DVec3) -> bool {
        let [to, to_other] = [self, other].map(|sphere| sphere.centre - point);
        let [distance, distance_of_other] = [to, to_other].map(DVec3::length);
        if ![distance, distance_of_other].iter().all(|distance| (1e-140..1e140).contains(distance)) {
            return false;
        }
        let [sine, sine_of_other] = [self.radius / distance, other.radius / distance_of_other];
        let cosines = (1.0 - sine * sine).sqrt() * (1.0 - sine_of_other * sine_of_other).sqrt();
        to.dot(to_other) / (distance * distance_of_other) < cosines - sine * sine_of_other - MARGIN
    }
}

/// Occluders, and spheres around these and the emitter.
pub(super) struct Occluders<'a> {
    occluders: Vec<(&'a Polygon, Sphere)>,
    emitter: Sphere,
}

impl<'a> Occluders<'a> {
    /// `None` if there are none.
    pub(super) fn new(occluders: &[&'a Polygon], emitter: &Emitter) -> Option<Self> {
        let with_sphere = |polygon: &&'a Polygon| (*polygon, Sphere::around(polygon));
        let with_spheres =
            || Self { occluders: occluders.iter().map(with_sphere).collect(), emitter: Sphere::around(emitter.polygon()) };
        (!occluders.is_empty()).then(with_spheres)
    }

    /// Occluders that may hide something from a point: their spheres do not prove the contrary.
    fn near(&self, point: DVec3) -> impl Iterator<Item = &'a Polygon> {
        let near = self.occluders.iter().filter(move |(_, sphere)| !sphere.is_apart_from(&self.emitter, point));
        near.map(|(polygon, _)| *polygon)
    }
}

/// Many receivers and their emitter.
pub(super) struct OneEmitter<'a, F> {
    pub(super) receivers: Receivers<'a, F>,
    pub(super) emitter: &'a Emitter,
    pub(super) occluders: Option<Occluders<'a>>,
    pub(super) on_lanes: &'a OnLanes<F>,
    pub(super) goal: Goal,
    pub(super) level: Level,
}

impl<F: LinearOnLanes> OneEmitter<'_, F> {
    /// Answers the receivers from `start` on.
    pub(super) fn tile(&self, start: usize, mut slots: Slots<'_, F>) -> Result<Counts, Error> {
        let length = slots.radiosity.len();
        let receivers = self.receivers.part(start..start + length);
        let OnLanes { lamp, double } = self.on_lanes;
        let mut settled = match (lamp, double, F::LINEAR) {
            (Some(lamp), ..) => on_lanes(self.level, &receivers, lamp, self.goal, &mut slots),
            (None, Some(Double::Linear(lamp)), Some(linear)) => linear(lamp, self.level, &receivers, self.goal, &mut slots),
            _ => Settled::default(),
        };
        slots.on_lanes();
        slots.see_nothing(each(settled.zero));
        let past = self.past(&receivers, length) & !settled.zero;
        settled.good &= !past;
        let mut counts = settled.counts();
        let mut open = settled.open(length) & !past;
        if let Some(lamp) = double
            && F::IS_SINGLE
            && open != 0
        {
            open = self.doubled(&receivers, lamp, open, (&mut slots, &mut counts))?;
        }
        for entry in each(open | past) {
            let in_batch = |error| Error::InBatch { index: start + entry, error: Box::new(error) };
            let occluders: Few<&Polygon> = self.near(&receivers, entry).collect();
            let receiver = receivers.receiver(entry).map_err(in_batch)?;
            let answer = self.goal.single(&receiver, self.emitter, &occluders).map_err(in_batch)?;
            put(&mut slots, entry, &answer).map_err(in_batch)?;
            *if answer.method == Method::Zero { &mut counts.zero } else { &mut counts.single } += 1;
        }
        Ok(counts)
    }

    /// The entries from which an occluder may hide a part of the emitter.
    fn past(&self, receivers: &Receivers<'_, F>, length: usize) -> Entries {
        if self.occluders.is_none() {
            return 0;
        }
        let is_past = |entry: &usize| self.near(receivers, *entry).next().is_some();
        (0..length).filter(is_past).fold(0, |past, entry| past | 1 << entry)
    }

    /// The occluders that may hide a part of the emitter from an entry.
    fn near(&self, receivers: &Receivers<'_, F>, entry: usize) -> impl Iterator<Item = &Polygon> {
        let position = receivers.position(entry);
        self.occluders.iter().flat_map(move |occluders| occluders.near(position))
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
            let entry_of = |slice: &[F]| slice[if slice.len() == 1 { 0 } else { entry }].to_double();
            let slices = receivers.position.iter().chain(&receivers.normal).chain([&receivers.reflectance]);
            values.iter_mut().zip(slices).for_each(|(values, slice)| values[place] = entry_of(slice));
        }
        let [x, y, z, nx, ny, nz, reflectance] = values.each_ref().map(|values| &values[..count]);
        let receivers = Receivers { position: [x, y, z], normal: [nx, ny, nz], reflectance };
        let mut work = Work::new();
        let settled = lamp.on_lanes(self.level, &receivers, self.goal.doubled(), &mut work.slots(count, self.goal.asked));
        *counts += Counts { doubled: count, ..settled.counts() };
        let mut remaining = 0;
        let still_open = settled.open(count);
        for (place, entry) in each(open).enumerate() {
            if still_open >> place & 1 == 1 {
                remaining |= 1 << entry;
            } else {
                put(slots, entry, &work.answer(place, self.goal.asked))?;
            }
            if settled.zero >> place & 1 == 1 {
                slots.see_nothing([entry].into_iter());
            }
        }
        Ok(remaining)
    }
}

/// Receivers of a tile on lanes.
fn on_lanes<F: Lane>(
    level: Level,
    receivers: &Receivers<'_, F>,
    Lamp { outline, brightness }: &Lamp<F>,
    goal: Goal,
    slots: &mut Slots<'_, F>,
) -> Settled {
    padded(receivers, goal, slots, |receivers, slots| {
        let lamp = (outline, *brightness, Uniformly);
        if goal.asked.gradient {
            in_library!([as_avx512 as_avx2 as_sse2] level, simd => lanes::<_, F, _, true>(simd, receivers, lamp, goal, slots))
        } else {
            in_library!([as_avx512 as_avx2 as_sse2] level, simd => lanes::<_, F, _, false>(simd, receivers, lamp, goal, slots))
        }
    })
}
