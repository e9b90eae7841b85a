//! Bounds on the error due to decisions that no precision at hand could take for sure.

use radgrad_numbers::radius::Radius;
use radgrad_numbers::real::{RadiusOf, Real};
use radgrad_numbers::vec3::Vec3;

use crate::boundary::arc::Generator;
use crate::boundary::visibility::not_flat::Doubt;
use crate::boundary::visibility::part::{Facing, VisiblePart, nearness};
use crate::boundary::visibility::shadow::Shadow;
use crate::boundary::visibility::subtract::Subtraction;

/// Bounds on the changes from undecided signs, in the sums without the factor rho/pi.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Uncertainty<R> {
    pub(crate) irradiance: R,
    pub(crate) gradient: R,
    /// Of the irradiance of a unit emission.
    pub(crate) solid_angle: R,
    /// Of the sum over the arcs of one polygon, weighed as in the gradient, for a unit emission: what two lines weigh that are seen
    /// in one place does not cancel, as it may in the gradient.
    pub(crate) edges: R,
}

impl<R: Radius> Uncertainty<R> {
    pub(crate) fn none() -> Self {
        let zero: R = 0.0.into();
        Self { irradiance: zero, gradient: zero, solid_angle: zero, edges: zero }
    }

    /// Whether every decision was certain, and the gradient has one value.
    pub(crate) fn is_none(&self) -> bool {
        self.irradiance == 0.0.into() && self.gradient == 0.0.into()
    }
}

impl<T: Real> Subtraction<'_, T> {
    /// Bounds the change that the other decision would make, for corners whose depth may have either sign.
    ///
    /// The region in question is within `depth/h` of the cutting plane, in a hemisphere. Its boundary runs along the edges at the
    /// corner as far as the depth may vanish, and back along the cut.
    pub(super) fn add_uncertainty(&mut self, part: &VisiblePart<T>, depths: &[T], cutting: Facing) {
        let count = part.corners.len();
        let possible = |i: usize| depths[i].size() + depths[i].error();
        let half_turn = RadiusOf::<T>::from(std::f64::consts::PI);
        for i in 0..count {
            let j = (i + 1) % count;
            let is_open = [i, j].map(|k| is_doubtful(depths[k]));
            if is_open == [false; 2] {
                continue;
            }
            let [own, cut] = [part.corners[i].side, cutting].map(|facing| self.sides.unturned(facing));
            let start = part.corners[i].point;
            let end = part.corners[j].point;
            let length = || (end - start).norm_squared().size().sqrt() * 1.01 / self.height;
            let both = || nearness(own) + nearness(cut);
            let (depth, weight, edges) = match is_open {
                [true, true] => {
                    let (depth, length) = (larger(possible(i), possible(j)), length().min(half_turn));
                    (depth, length * exchange(own, cut, depth / self.height), length * both())
                }
                [first, _] => {
                    let (doubtful, other) = if first { (i, j) } else { (j, i) };
                    let depth = possible(doubtful);
                    let clear = depths[other].size() - depths[other].error() - depth;
                    let fraction = if clear > depth { depth / clear } else { 1.0.into() };
                    let weight = (length() * fraction).min(half_turn) * both();
                    (depth, weight, weight)
                }
            };
            let area = (depth / self.height).min(1.0.into()) * std::f64::consts::TAU;
            self.uncertainty.solid_angle = self.uncertainty.solid_angle + area;
            self.uncertainty.edges = self.uncertainty.edges + edges;
            self.uncertainty.irradiance = self.uncertainty.irradiance + area * self.emission;
            self.uncertainty.gradient = self.uncertainty.gradient + (self.steepness * area + weight * self.emission);
        }
    }

    /// Bounds how far the gradient is from its other value where the side `own` of a part, between two points, is seen exactly along the side `cut`
    /// of a shadow: at a place beside, the one or the other bounds the visible part, as far as the shadow goes.
    pub(super) fn add_kink(&mut self, ends: [Vec3<T>; 2], [own, cut]: [Facing; 2], shadow: &Shadow<T>) {
        let mut range = [0.0, 1.0];
        for &side in shadow.lines.iter().filter(|&&side| side != cut) {
            let normal = self.sides.normal(side);
            // The most that an end may be inside of the shadow's other sides.
            let [start, end] = ends.map(|point| {
                let depth = -normal.dot(point);
                depth.value() + depth.error().to_double() + 2.0 * f64::EPSILON * depth.value().abs()
            });
            match (start < 0.0, end < 0.0) {
                (true, true) => return,
                (true, false) => range[0] = larger(range[0], start / (start - end)),
                (false, true) => range[1] = -larger(-range[1], -start / (start - end)),
                (false, false) => {}
            }
        }
        if range[1] <= range[0] {
            return;
        }
        let [own, cut] = [own, cut].map(|facing| self.sides.unturned(facing));
        let half_turn = RadiusOf::<T>::from(std::f64::consts::PI);
        let whole = (ends[1] - ends[0]).norm_squared().size().sqrt() * 1.01 / self.height;
        let length = whole.min(half_turn) * (range[1] - range[0]).min(1.0);
        self.uncertainty.edges = self.uncertainty.edges + length * (nearness(own) + nearness(cut));
        self.uncertainty.gradient = self.uncertainty.gradient + length * exchange(own, cut, 0.0.into()) * self.emission;
    }

    /// Bounds the change that other surfaces through the vertices would make.
    pub(super) fn add_doubt<'a>(&mut self, doubt: &Doubt, parts: impl Iterator<Item = &'a VisiblePart<T>>)
    where
        T: 'a,
    {
        let height = self.height.to_double() * (1.0 - 8.0 * f64::EPSILON);
        for bounds in parts.filter_map(|part| doubt.bounds(part, &self.sides, height)) {
            let [irradiance, moving] = bounds.map(RadiusOf::<T>::from);
            self.uncertainty.solid_angle = self.uncertainty.solid_angle + irradiance;
            // Where an occluder meets the emitter's plane is not known.
            self.uncertainty.edges = f64::INFINITY.into();
            self.uncertainty.irradiance = self.uncertainty.irradiance + irradiance * self.emission;
            self.uncertainty.gradient = self.uncertainty.gradient + self.steepness * irradiance + moving * self.emission;
        }
    }
}

/// How much a unit of arc weighs more or less in the gradient when it lies on the other of two lines that are seen within the
/// angle `near` of each other: an arc weighs `-(N/S) (toward.V)`, with `|V|` at most its length, and V itself moves by at most
/// four times `near`. Lines in space that coincide (edges with a T-junction) weigh the same; an edge in the horizon is seen
/// with `n1.omega` at most `near`.
fn exchange<T: Real>(own: &Generator<T>, cut: &Generator<T>, near: RadiusOf<T>) -> RadiusOf<T> {
    let moved = near * (nearness(own) + nearness(cut)) * 4.0;
    let (Generator::Emitter(own) | Generator::Occluder(own), Generator::Emitter(cut) | Generator::Occluder(cut)) = (own, cut)
    else {
        return moved;
    };
    let bound = |v: Vec3<T>| {
        let v = v.map(|c| c.size() + c.error());
        (v.x * v.x + v.y * v.y + v.z * v.z).sqrt()
    };
    let (own, cut) = (own.frame(), cut.frame());
    let facing = if own.normal.dot(cut.normal).value() < 0.0 { T::exact(-1.0) } else { T::exact(1.0) };
    let [own_weight, cut_weight] = [&own, &cut].map(|frame| frame.normal * (T::exact(1.0) / frame.distance));
    (bound(own_weight - cut_weight * facing) + bound(own.toward - cut.toward) * bound(cut_weight)) * 1.01 + moved
}

/// The larger of two; NaN if either is.
fn larger<R: Radius>(a: R, b: R) -> R {
    if a >= b || a.partial_cmp(&a).is_none() { a } else { b }
}

/// Whether the sign is not known, as of NaN. An exact zero is no doubt: a corner on the horizon.
pub(super) fn is_doubtful<T: Real>(depth: T) -> bool {
    let is_sure = depth.size() > depth.error() || is_exactly_0(depth);
    !is_sure
}

pub(super) fn is_exactly_0<T: Real>(depth: T) -> bool {
    depth.size() == 0.0.into() && depth.error() == 0.0.into()
}
