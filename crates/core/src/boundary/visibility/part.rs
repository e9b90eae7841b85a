//! Convex parts of the emitter as the receiver sees them, and the sides that bound them.

use glam::DVec3;
use radgrad_numbers::radius::Radius;
use radgrad_numbers::real::{RadiusOf, Real};
use radgrad_numbers::vec3::Vec3;

use crate::boundary::arc::{Arc, Generator};
use crate::boundary::edge_name::EdgeName;
use crate::boundary::line::Sighted;
use crate::boundary::origin::Origin;
use crate::boundary::visibility::separation::{BoundingCone, UncertainVector};

/// A plane through the receiver: its generator, and its edge where it is one of the input.
#[derive(Debug, Clone, Copy)]
struct ConeSide<T> {
    generator: Generator<T>,
    name: Option<EdgeName>,
    /// The number of the occluder that casts it, where it is the side of a shadow.
    occluder: Option<usize>,
    /// Its normal in doubles, with a bound on the error.
    normal: UncertainVector,
}

/// All that bounds a part, each once.
#[derive(Debug)]
pub(super) struct Sides<T>(Vec<ConeSide<T>>);

/// One of the [`Sides`], by its number, as it is or run the other way: a cone is where `N . omega < 0` for the normals so turned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Facing {
    pub(super) side: usize,
    reversed: bool,
}

impl Facing {
    pub(super) const fn forward(side: usize) -> Self {
        Self { side, reversed: false }
    }

    pub(super) const fn reversed(self) -> Self {
        Self { reversed: !self.reversed, ..self }
    }
}

impl<T: Real> Sides<T> {
    pub(super) const fn new() -> Self {
        Self(Vec::new())
    }

    pub(super) fn add(&mut self, generator: Generator<T>, name: Option<EdgeName>) -> Facing {
        self.add_side(generator, name, None)
    }

    /// The side of a shadow of the occluder with that number.
    pub(super) fn add_shadow(&mut self, generator: Generator<T>, name: Option<EdgeName>, occluder: usize) -> Facing {
        self.add_side(generator, name, Some(occluder))
    }

    fn add_side(&mut self, generator: Generator<T>, name: Option<EdgeName>, occluder: Option<usize>) -> Facing {
        self.0.push(ConeSide { generator, name, occluder, normal: UncertainVector::from_direction(generator.normal()) });
        Facing::forward(self.0.len() - 1)
    }

    pub(super) fn origin(&self, facing: Facing) -> Origin {
        let side = &self.0[facing.side];
        match (side.name, side.occluder) {
            (Some(edge), occluder) => Origin::Edge { occluder, edge },
            (None, Some(occluder)) => Origin::Waterline(occluder),
            (None, None) => Origin::Horizon,
        }
    }

    /// The side of an edge of the emitter: of a diagonal, that of the neighbour who has it already.
    pub(super) fn add_emitter_edge(&mut self, generator: impl FnOnce() -> Generator<T>, name: EdgeName) -> Facing {
        match self.0.iter().position(|side| side.name == Some(name)) {
            Some(line) => Facing::forward(line).reversed(),
            None => self.add(generator(), Some(name)),
        }
    }

    pub(super) fn name(&self, facing: Facing) -> Option<EdgeName> {
        self.0[facing.side].name
    }

    /// The generator of a side, whichever way it is run.
    pub(super) fn unturned(&self, facing: Facing) -> &Generator<T> {
        &self.0[facing.side].generator
    }

    pub(super) fn generator(&self, facing: Facing) -> Generator<T> {
        let generator = self.0[facing.side].generator;
        if facing.reversed { generator.reversed() } else { generator }
    }

    pub(super) fn normal(&self, facing: Facing) -> Vec3<T> {
        let normal = self.0[facing.side].generator.normal();
        if facing.reversed { -normal } else { normal }
    }

    fn about(&self, facing: Facing) -> UncertainVector {
        let normal = self.0[facing.side].normal;
        if facing.reversed { normal.reversed() } else { normal }
    }
}

/// A convex part of the emitter, by its corners in the emitter's plane: it is where `N . omega < 0` on all sides.
#[derive(Debug, Clone)]
pub(super) struct VisiblePart<T> {
    pub(super) corners: Vec<PartCorner<Vec3<T>>>,
    /// A circular cone and rays around it, in doubles.
    pub(super) cone: BoundingCone,
}

/// A corner of a part, seen through a point P.
#[derive(Debug, Clone, Copy)]
pub(super) struct PartCorner<P> {
    pub(super) point: P,
    /// The vertex of the input that is seen there, where one is known to be.
    pub(super) vertex: Option<DVec3>,
    /// The side that starts there.
    pub(super) side: Facing,
}

impl<T: Real> VisiblePart<T> {
    pub(super) fn new(corners: Vec<PartCorner<Vec3<T>>>, sides: &Sides<T>) -> Self {
        let about = |corner: &PartCorner<Vec3<T>>| [UncertainVector::from_direction(corner.point), sides.about(corner.side)];
        let cone = BoundingCone::new(corners.iter().map(about).collect());
        Self { corners, cone }
    }

    pub(super) fn arcs(&self, sides: &Sides<T>) -> impl Iterator<Item = Arc<T>> {
        let sighted = |corner: &PartCorner<Vec3<T>>| Sighted::new(corner.point);
        pairs(&self.corners).map(move |(start, end)| Arc::between(sighted(start), sighted(end), sides.generator(start.side)))
    }

    /// Whether each side surely meets the next in space. Lines of the emitter's plane do wherever they seem to, and lines that
    /// share a point nowhere else.
    pub(super) fn meetings(&self, sides: &Sides<T>) -> impl Iterator<Item = bool> {
        let both = pairs(&self.corners).map(|(corner, next)| [&sides.0[corner.side.side], &sides.0[next.side.side]]);
        both.map(|[side, next]| match (&side.generator, &next.generator, side.name, next.name) {
            (Generator::Emitter(_), Generator::Emitter(_), ..) => true,
            (_, _, Some(a), Some(b)) => a.shared_end(b).is_some() || a.is_on_the_line_of(b),
            _ => false,
        })
    }
}

/// Each corner with the one after it.
pub(super) fn pairs<P>(corners: &[PartCorner<P>]) -> impl Iterator<Item = (&PartCorner<P>, &PartCorner<P>)> {
    corners.iter().zip(corners.iter().cycle().skip(1))
}

/// Bound on `1/S` of a generating line; the horizon has none.
pub(super) fn nearness<T: Real>(generator: &Generator<T>) -> RadiusOf<T> {
    match generator {
        Generator::Horizon(_) => 0.0.into(),
        Generator::Emitter(line) | Generator::Occluder(line) => {
            line.length.size() * 1.01 / (line.moment.size() - line.moment.error()).max(0.0.into())
        }
    }
}
