//! Emitters of one kind with as many vertices each, on lanes of double precision: constant or linear.

use std::ops::Range;

use fearless_simd::{Level, Simd};
use radgrad_numbers::lanes::lane::{Lanes, constant};

use crate::batch::linear::many;
use crate::batch::linear::many::LinearGroup;
use crate::batch::many_emitters::{Group, SeenFrom, Work, goes_on_lanes};
use crate::batch::tile::{Goal, Settled};
use crate::problem::emission::Emitter;

/// Some emitters of either kind.
#[derive(Debug, Clone)]
pub(super) enum Lamps {
    Constant(Group<f64>),
    Linear(LinearGroup),
}

/// A kind of emitters.
#[derive(Debug, Clone, Copy)]
pub(super) enum Kind {
    Constant,
    Linear,
}

/// Emitters of these indices that go on lanes of double precision, those of a kind with as many vertices together; and the
/// others.
pub(super) fn sorted(emitters: &[Emitter], indices: &[usize], power: f64) -> (Vec<Lamps>, Vec<usize>) {
    let (kinds, others) = kinds(emitters, indices, power);
    (kinds.into_iter().map(|(kind, index)| Lamps::new(kind, emitters, index, power)).collect(), others)
}

/// The indices of each kind, and those of the others.
pub(super) fn kinds(emitters: &[Emitter], indices: &[usize], power: f64) -> (Vec<(Kind, Vec<usize>)>, Vec<usize>) {
    let (constant, others): (Vec<_>, Vec<_>) = indices.iter().partition(|i| goes_on_lanes::<f64>(&emitters[**i], power));
    let (linear, others): (Vec<_>, Vec<_>) = others.into_iter().partition(|i| many::goes_on_lanes(&emitters[*i], power));
    let constant = by_edges(emitters, &constant).into_iter().map(|index| (Kind::Constant, index));
    let linear = by_edges(emitters, &linear).into_iter().map(|index| (Kind::Linear, index));
    (constant.chain(linear).collect(), others)
}

/// Indices of emitters with as many vertices together.
pub(super) fn by_edges(emitters: &[Emitter], indices: &[usize]) -> Vec<Vec<usize>> {
    let edges = |index: usize| emitters[index].polygon().vertices().len();
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for &index in indices {
        match groups.iter_mut().find(|group| edges(group[0]) == edges(index)) {
            Some(group) => group.push(index),
            None => groups.push(vec![index]),
        }
    }
    groups
}

impl Lamps {
    /// The emitters of these indices, in their order.
    pub(super) fn new(kind: Kind, emitters: &[Emitter], index: Vec<usize>, power: f64) -> Self {
        match kind {
            Kind::Constant => Self::Constant(Group::new(emitters, index, power)),
            Kind::Linear => Self::Linear(LinearGroup::new(emitters, index, power)),
        }
    }

    pub(super) const fn outlines(&self) -> &Group<f64> {
        match self {
            Self::Constant(group) => group,
            Self::Linear(group) => &group.outlines,
        }
    }

    /// Which emitters they are.
    pub(super) fn index(&self) -> &[usize] {
        &self.outlines().index
    }

    /// The answers for a range of emitters, at most a tile long.
    pub(super) fn answer(
        &self,
        level: Level,
        seen: &SeenFrom<f64>,
        range: Range<usize>,
        goal: Goal,
        work: &mut Work<f64>,
    ) -> Settled {
        match self {
            Self::Constant(group) => group.answer(level, seen, range, goal, work),
            Self::Linear(group) => group.answer(level, seen, range, goal, work),
        }
    }

    /// One above the degree of the emission.
    pub(super) const fn order(&self) -> usize {
        match self {
            Self::Constant(_) => 1,
            Self::Linear(_) => 2,
        }
    }

    /// The emission over triangle k of the fans from vertex 0 of a vector of emitters: `b + u (b_ab + v b_bc)` at
    /// `a + u (ab + v bc)`, in units of the brightness.
    #[inline(always)]
    pub(super) fn emission<S: Simd>(&self, simd: S, k: usize, entry: usize) -> [Lanes<S, f64>; 3] {
        match self {
            Self::Constant(_) => [constant(simd, 1.0), constant(simd, 0.0), constant(simd, 0.0)],
            Self::Linear(group) => {
                let vertex_emission = |vertex: usize| Lanes::load(simd, &group.at_vertex(vertex)[entry..]);
                let (a, b, c) = (vertex_emission(0), vertex_emission(k + 1), vertex_emission(k + 2));
                [a, b - a, c - b]
            }
        }
    }

    /// As [`Group::extent`]; a linear emission may err by 20u of its scale, which counts as much as the rounding of areas.
    pub(super) fn extent(&self, range: Range<usize>) -> (f64, f64) {
        match self {
            Self::Constant(group) => group.extent(range, |_| 1.0),
            Self::Linear(group) => group.outlines.extent(range, |i| 2.0 * group.scale(i)),
        }
    }
}
