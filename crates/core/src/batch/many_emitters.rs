//! Emitters as a structure of arrays: outlines with as many edges each on lanes, seen from one receiver. With a brightness they
//! are constant emitters; `linear::many` adds the emission of linear ones.

use std::ops::Range;

use fearless_simd::{Level, Simd};
use glam::DVec3;
use radgrad_numbers::in_library;
use radgrad_numbers::lanes::lane::{Lane, Lanes, MOST_LANES, align_frame, constant, load, same};
use radgrad_numbers::vec3::Vec3;

use crate::batch::answers::{Asked, Slots};
use crate::batch::emitting::{Emitting, Uniformly, brightness, height_share, power};
use crate::batch::span::LaneEdge;
use crate::batch::tile::{Goal, Scale, Settled, TILE, settle};
use crate::batch::visible::{BoundarySums, Outline, find};
use crate::ladder::answer::{Answer, Method};
use crate::problem::emission::Emitter;
use crate::problem::polygon::Polygon;
use crate::problem::receiver::Receiver;

/// Outlines with as many vertices each and their brightness, in any order. Arrays go on for a vector's length after the last one,
/// which is repeated there.
#[derive(Debug, Clone)]
pub(super) struct Group<F> {
    /// Which emitters they are.
    pub(super) index: Vec<usize>,
    /// Coordinates of each vertex in turn, in normalised lengths.
    vertices: Vec<[Vec<F>; 3]>,
    /// One over the squared length of each edge in turn.
    inverse: Vec<Vec<F>>,
    normal: [Vec<F>; 3],
    height_share: Vec<F>,
    /// `B/pi` of constant emitters; of others, the unit of the emission over pi.
    brightness: Vec<F>,
}

/// The power of two that brings emitters to an ordinary size.
pub(super) fn common_power<F: Lane>(emitters: &[Emitter]) -> f64 {
    power::<F>(emitters.iter().map(|emitter| emitter.polygon().size()).fold(0.0, f64::max))
}

/// Whether an emitter can go on lanes: constant, not dark, and its vertices held by the precision.
pub(super) fn goes_on_lanes<F: Lane>(emitter: &Emitter, power: f64) -> bool {
    brightness::<F>(emitter).is_some() && fits::<F>(emitter, power)
}

/// Whether the precision holds an emitter's vertices, and its edges are not too short.
pub(super) fn fits<F: Lane>(emitter: &Emitter, power: f64) -> bool {
    let holds = |value: f64| F::nearest(value).to_double() == value;
    let vertices = emitter.polygon().vertices();
    vertices.iter().flat_map(|v| (*v * power).to_array()).chain([power, 1.0 / power]).all(holds)
        && edges(emitter.polygon(), power).all(|e| e.length_squared() >= F::SHORTEST * F::SHORTEST)
}

fn edges(polygon: &Polygon, power: f64) -> impl Iterator<Item = DVec3> {
    let vertices = polygon.vertices();
    (0..vertices.len()).map(move |i| (vertices[(i + 1) % vertices.len()] - vertices[i]) * power)
}

impl<F: Lane> Group<F> {
    /// The constant emitters of these indices, all with as many vertices and fit for lanes.
    pub(super) fn new(emitters: &[Emitter], index: Vec<usize>, power: f64) -> Self {
        let padded = index.iter().chain(std::iter::repeat_n(index.last(), MOST_LANES).flatten());
        let brightness = padded.map(|i| brightness(&emitters[*i]).unwrap_or_default()).collect();
        Self::with_brightness(emitters, index, power, brightness)
    }

    /// The same of any emission.
    pub(super) fn with_brightness(emitters: &[Emitter], index: Vec<usize>, power: f64, brightness: Vec<F>) -> Self {
        let count = index.first().map_or(0, |first| emitters[*first].polygon().vertices().len());
        let room = || Vec::with_capacity(index.len() + MOST_LANES);
        let rooms = || [room(), room(), room()];
        let mut group = Self {
            vertices: (0..count).map(|_| rooms()).collect(),
            inverse: (0..count).map(|_| room()).collect(),
            normal: rooms(),
            height_share: room(),
            brightness,
            index: Vec::new(),
        };
        for index in index.iter().chain(std::iter::repeat_n(index.last(), MOST_LANES).flatten()) {
            group.append(emitters[*index].polygon(), power);
        }
        group.index = index;
        group
    }

    /// Appends an outline to the arrays.
    fn append(&mut self, polygon: &Polygon, power: f64) {
        let append = |arrays: &mut [Vec<F>; 3], v: DVec3, factor: f64| {
            for (array, axis) in arrays.iter_mut().zip([DVec3::X, DVec3::Y, DVec3::Z]) {
                array.push(F::nearest(v.dot(axis) * factor));
            }
        };
        self.vertices.iter_mut().zip(polygon.vertices()).for_each(|(arrays, v)| append(arrays, *v, power));
        for (array, edge) in self.inverse.iter_mut().zip(edges(polygon, power)) {
            array.push(F::nearest(1.0 / edge.length_squared()));
        }
        append(&mut self.normal, polygon.normal(), 1.0);
        self.height_share.push(height_share(polygon, power));
    }

    /// Triangle k of the fans from vertex 0 of a vector of emitters: `a + u (ab + v bc)`, and `2 A n2 B/pi`, which is 0 for
    /// emitters from `end` on.
    #[inline(always)]
    pub(super) fn triangle<S: Simd>(&self, simd: S, k: usize, entry: usize, end: usize) -> [Vec3<Lanes<S, F>>; 4] {
        let block = Block { group: self, first: entry };
        let (a, b, c) = (block.vertex(simd, 0), block.vertex(simd, k + 1), block.vertex(simd, k + 2));
        let mut brightness = [F::default(); MOST_LANES];
        let count = (end - entry).min(MOST_LANES);
        brightness[..count].copy_from_slice(&self.brightness[entry..entry + count]);
        [a, b - a, c - b, (b - a).cross(c - b) * Lanes::load(simd, &brightness)]
    }

    /// Triangles of a fan.
    pub(super) fn triangles(&self) -> usize {
        self.vertices.len() - 2
    }

    /// The largest distance of a vertex from its triangle's middle, in the fans over a range, and the sum over the triangles of
    /// `|B|/pi`, the brightness times an emission, times the product of two sides. Rounding of areas is relative to that product.
    pub(super) fn extent(&self, range: Range<usize>, emission: impl Fn(usize) -> f64) -> (f64, f64) {
        let vertex = |k: usize, i: usize| DVec3::from(self.vertices[k].each_ref().map(|array| array[i].to_double()));
        let (mut reach, mut sides) = (0.0f64, 0.0);
        for i in range {
            for k in 0..self.triangles() {
                let [a, b, c] = [vertex(0, i), vertex(k + 1, i), vertex(k + 2, i)];
                let middle = (a + b + c) / 3.0;
                reach = [a, b, c].iter().fold(reach, |reach, v| reach.max((*v - middle).length()));
                sides += self.brightness[i].to_double().abs() * emission(i) * (b - a).length() * (c - b).length();
            }
        }
        (reach * (1.0 + 1e-12), sides)
    }

    /// The answers for a range of emitters, at most a tile long.
    pub(super) fn answer(
        &self,
        level: Level,
        seen: &SeenFrom<F>,
        range: Range<usize>,
        goal: Goal,
        work: &mut Work<F>,
    ) -> Settled {
        work.answered(range, goal, |start, slots| {
            let tile = (self, start, Uniformly);
            if goal.asked.gradient {
                in_library!([as_avx512 as_avx2 as_sse2] level, simd => lanes::<_, F, _, true>(simd, tile, seen, goal, slots))
            } else {
                in_library!([as_avx512 as_avx2 as_sse2] level, simd => lanes::<_, F, _, false>(simd, tile, seen, goal, slots))
            }
        })
    }
}

/// A receiver in the precision of the lanes and the emitters' normalised lengths.
#[derive(Debug, Clone, Copy)]
pub(super) struct SeenFrom<F> {
    position: [F; 3],
    normal: [F; 3],
    reflectance: F,
    power: F,
}

impl<F: Lane> SeenFrom<F> {
    /// `None` where the precision does not hold the position.
    pub(super) fn new(receiver: &Receiver, power: f64) -> Option<Self> {
        let position = receiver.position() * power;
        let nearest = |v: DVec3| v.to_array().map(F::nearest);
        let held = position.to_array().iter().all(|c| F::nearest(*c).to_double() == *c);
        held.then(|| Self {
            position: nearest(position),
            normal: nearest(receiver.normal()),
            reflectance: F::nearest(receiver.reflectance()),
            power: F::nearest(power),
        })
    }
}

/// Room for the answers of a tile.
#[derive(Debug, Clone)]
pub(super) struct Work<F> {
    pub(super) radiosity: [F; TILE],
    pub(super) gradient: [[F; TILE]; 3],
    pub(super) radiosity_error: [F; TILE],
    pub(super) gradient_error: [F; TILE],
}

impl<F: Lane> Work<F> {
    pub(super) fn new() -> Self {
        let room = [F::default(); TILE];
        Self { radiosity: room, gradient: [room; 3], radiosity_error: room, gradient_error: room }
    }

    /// Writes the first answers to slots.
    pub(super) fn copy_to(&self, slots: &mut Slots<'_, F>) {
        let copy = |slot: &mut [F], array: &[F; TILE]| slot.copy_from_slice(&array[..slot.len()]);
        copy(slots.radiosity, &self.radiosity);
        slots.gradient.iter_mut().zip(&self.gradient).for_each(|(slot, array)| copy(slot, array));
        copy(slots.radiosity_error, &self.radiosity_error);
        copy(slots.gradient_error, &self.gradient_error);
    }

    /// One answer.
    pub(super) fn answer(&self, entry: usize, asked: Asked) -> Answer {
        let value = |array: &[F; TILE], wanted: bool| if wanted { array[entry].to_double() } else { 0.0 };
        Answer {
            radiosity: value(&self.radiosity, true),
            gradient: DVec3::from(self.gradient.each_ref().map(|array| value(array, asked.gradient))),
            radiosity_error: value(&self.radiosity_error, asked.errors),
            gradient_error: value(&self.gradient_error, asked.gradient && asked.errors),
            method: Method::ClosedForm,
        }
    }

    /// Runs `answer`, which writes a range of entries at most a tile long in whole vectors.
    pub(super) fn answered(
        &mut self,
        range: Range<usize>,
        goal: Goal,
        answer: impl FnOnce(usize, &mut Slots<'_, F>) -> Settled,
    ) -> Settled {
        let count = range.len();
        answer(range.start, &mut self.slots(count.next_multiple_of(F::WIDEST), goal.asked)).first(count)
    }

    /// The first slots.
    pub(super) fn slots(&mut self, count: usize, asked: Asked) -> Slots<'_, F> {
        let [gradient, errors, gradient_errors] =
            [asked.gradient, asked.errors, asked.gradient && asked.errors].map(|wanted| if wanted { count } else { 0 });
        Slots {
            radiosity: &mut self.radiosity[..count],
            gradient: self.gradient.each_mut().map(|array| &mut array[..gradient]),
            radiosity_error: &mut self.radiosity_error[..errors],
            gradient_error: &mut self.gradient_error[..gradient_errors],
            method: &mut [],
        }
    }
}

/// A vector of emitters of a group.
struct Block<'a, F> {
    group: &'a Group<F>,
    first: usize,
}

impl<S: Simd, F: Lane> Outline<S, F> for Block<'_, F> {
    #[inline(always)]
    fn count(&self) -> usize {
        self.group.vertices.len()
    }
    #[inline(always)]
    fn vertex(&self, simd: S, index: usize) -> Vec3<Lanes<S, F>> {
        let [x, y, z] = &self.group.vertices[index];
        load(simd, [&x[self.first..], &y[self.first..], &z[self.first..]])
    }
    #[inline(always)]
    fn edge(&self, simd: S, index: usize) -> LaneEdge<S, F> {
        let next = if index + 1 == self.group.vertices.len() { 0 } else { index + 1 };
        let e = self.vertex(simd, next) - self.vertex(simd, index);
        LaneEdge { index, e, square: e.norm_squared(), inverse: Lanes::load(simd, &self.group.inverse[index][self.first..]) }
    }
    #[inline(always)]
    fn normal(&self, simd: S) -> Vec3<Lanes<S, F>> {
        let [x, y, z] = &self.group.normal;
        load(simd, [&x[self.first..], &y[self.first..], &z[self.first..]])
    }
    #[inline(always)]
    fn height_share(&self, simd: S) -> Lanes<S, F> {
        Lanes::load(simd, &self.group.height_share[self.first..])
    }
}

/// Emitters from `start` on, a vector at a time, and how they emit.
#[inline(always)]
pub(super) fn lanes<S: Simd, F: Lane, E: Emitting<S, F>, const GRADIENT: bool>(
    simd: S,
    (group, start, emitting): (&Group<F>, usize, E),
    seen: &SeenFrom<F>,
    goal: Goal,
    slots: &mut Slots<'_, F>,
) -> Settled {
    align_frame();
    let mut settled = Settled::default();
    let (x, n1) = (same(simd, seen.position), same(simd, seen.normal));
    let always = constant::<S, F>(simd, 0.0).at_most(constant(simd, 0.0));
    let (rho, power) = (Lanes::splat(simd, seen.reflectance), Lanes::splat(simd, seen.power));
    for first in (0..slots.radiosity.len()).step_by(Lanes::<S, F>::COUNT) {
        let block = Block { group, first: start + first };
        let sums = emitting.sums(simd, block.first, &block, x, n1);
        let visible = find::<S, F, _, _, GRADIENT>(simd, &block, ((x, n1), always), goal.asked.errors, sums);
        let brightness = Lanes::load(simd, &group.brightness[block.first..]) * constant(simd, E::Sums::FACTOR);
        let scale = Scale::new(simd, brightness, rho, power);
        settle::<S, F, GRADIENT>(simd, &visible, &scale, goal.tolerance, (slots, first), &mut settled);
    }
    settled
}
