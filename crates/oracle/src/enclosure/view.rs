//! The visible part of the emitter: convex pieces of its triangles, and the lines that bound them all.
//!
//! In free sight a piece is a triangle's part above the horizon. Past occluders it is cut further ([`crate::enclosure::cone`],
//! [`crate::enclosure::shadow`]); cuts between two seen pieces are no boundary and are found by counting along each plane which
//! stretches have a piece on one side only.
//!
//! A boundary moves with the receiver. On a line of the emitter's plane - an edge, or where an occluder meets that plane - the
//! gradient of HS95 Eq. 1 has the integral of `B (n1.r) (dr x r)/|r|^4`, which is that of `B (n1.w)(e x w)/|r|^2 dt` along the
//! edge e. On the edge of an occluder, seen in the same directions w at `l r`, the second form is the first one on the shadow, over
//! `l`: with `m.y = k` along the edge's line, `1/l = m.r / k` is affine, and the emission there is `B (m.r)/k`.

use std::rc::Rc;

use crate::enclosure::cone::{Cone, Corner, Direction, Planes};
use crate::enclosure::exact::{Exact, ExactVector, cross, dot};
use crate::enclosure::outline::{Point, Stretch};
use crate::enclosure::shadow::{Generator, Occluder, occluders};
use crate::enclosure::surface::{Body, Frame, Triangle, outline};

/// A convex part of a triangle, by its outline.
#[derive(Debug)]
pub(crate) struct Piece {
    pub(crate) triangle: usize,
    pub(crate) outline: Vec<Stretch>,
}

/// A stretch of the boundary of the visible part, which lies on its left.
#[derive(Debug)]
pub(crate) struct Border {
    pub(crate) triangle: usize,
    pub(crate) stretch: Stretch,
    /// `m` and `k` of the occluder's edge that casts it.
    pub(crate) cast: Option<(ExactVector, Exact)>,
}

/// The pieces and their common boundary but for the horizon.
#[derive(Debug)]
pub(crate) struct View {
    pub(crate) pieces: Vec<Piece>,
    pub(crate) borders: Vec<Border>,
}

impl View {
    /// The view without occluders.
    pub(crate) fn free(frame: &Frame) -> Self {
        let piece = |(triangle, t)| Piece { triangle, outline: outline(frame, t) };
        let pieces = frame.triangles.iter().enumerate().map(piece).collect();
        let border = |[i, j]: [usize; 2]| {
            let owner = |t: &Triangle| (0..3).any(|m| t.corners[m] == i && t.corners[(m + 1) % 3] == j);
            let triangle = frame.triangles.iter().position(owner)?;
            Some(Border { triangle, stretch: Stretch::of_edge(frame, [i, j])?, cast: None })
        };
        Self { pieces, borders: frame.boundary().into_iter().filter_map(border).collect() }
    }

    /// Past opaque polygons.
    pub(crate) fn past(frame: &Frame, bodies: &[Body<'_>]) -> Self {
        let mut planes = Planes::new();
        let mut generators = Vec::new();
        let Some(horizon) = Direction::new(&frame.normal) else { return Self::free(frame) };
        planes.push(horizon);
        generators.push(Generator::Horizon);
        let occluders: Vec<Occluder> =
            bodies.iter().flat_map(|body| occluders(frame, body, &mut planes, &mut generators)).collect();
        let mut view = Self { pieces: Vec::new(), borders: Vec::new() };
        let mut sides = Vec::new();
        let mut is_hidden = false;
        for (index, triangle) in frame.triangles.iter().enumerate() {
            let Some(facing) = Direction::new(&triangle.normal) else { continue };
            let whole = cone(frame, triangle, &mut planes, &mut generators);
            let mut cones: Vec<Cone> = whole.and_then(|cone| cone.cut(&planes, 0, true, &facing)).into_iter().collect();
            for occluder in &occluders {
                let Some(shadow) = occluder.shadow(triangle, &mut planes, &mut generators) else { continue };
                is_hidden |= occluder.hide(&mut cones, &shadow, &planes, &facing);
            }
            for cone in cones {
                let points: Vec<Point> = cone.0.iter().map(|corner| point(frame, triangle, &corner.direction)).collect();
                let next = points.iter().cycle().skip(1);
                let outline = points.iter().zip(next).map(|(a, b)| Stretch::between([a.clone(), b.clone()])).collect();
                view.pieces.push(Piece { triangle: index, outline });
                let next = cone.0.iter().cycle().skip(1).map(|corner| Rc::clone(&corner.direction));
                sides.extend(cone.0.iter().cloned().zip(next).map(|(from, to)| Bound { triangle: index, from, to }));
            }
        }
        if !is_hidden {
            return Self::free(frame);
        }
        view.borders = borders(frame, &sides, &planes, &generators);
        view
    }
}

/// The cone of a triangle.
fn cone(frame: &Frame, triangle: &Triangle, planes: &mut Planes, generators: &mut Vec<Generator>) -> Option<Cone> {
    let mut corners = Vec::with_capacity(3);
    for m in 0..3 {
        let (i, j) = (triangle.corners[m], triangle.corners[(m + 1) % 3]);
        let edge = [i.min(j), i.max(j)];
        let existing = generators.iter().position(|g| matches!(g, Generator::Edge(other) if *other == edge));
        let plane = match existing {
            Some(plane) => plane,
            None => {
                planes.push(Direction::new(&cross(&frame.vertices[edge[1]], &frame.vertices[edge[0]]))?);
                generators.push(Generator::Edge(edge));
                planes.len() - 1
            }
        };
        corners.push(Corner { direction: Rc::new(Direction::new(&frame.vertices[i])?), plane, inward: i < j });
    }
    Some(Cone(corners))
}

/// Where a direction meets a triangle's plane.
fn point(frame: &Frame, triangle: &Triangle, direction: &Direction) -> Point {
    let advance = -&dot(&triangle.normal, &direction.exact);
    Point::on_plane(&direction.exact, &triangle.height, &advance, &dot(&frame.normal, &direction.exact))
}

/// A side of a piece.
struct Bound {
    triangle: usize,
    from: Corner,
    to: Rc<Direction>,
}

/// The stretches along each plane that have a piece on one side only. Along an edge of the emitter the pieces of two triangles
/// meet, elsewhere those of one.
fn borders(frame: &Frame, sides: &[Bound], planes: &Planes, generators: &[Generator]) -> Vec<Border> {
    let line = |side: &Bound| match generators[side.from.plane] {
        Generator::Edge(_) => (side.from.plane, usize::MAX),
        _ => (side.from.plane, side.triangle),
    };
    let mut order: Vec<&Bound> = sides.iter().filter(|s| !matches!(generators[s.from.plane], Generator::Horizon)).collect();
    order.sort_by_key(|side| line(side));
    let along = order.chunk_by(|a, b| line(a) == line(b));
    along.flat_map(|sides| net(frame, sides, &planes[sides[0].from.plane], &generators[sides[0].from.plane])).collect()
}

/// An end of a side, its term of the count there, and the side's triangle.
type End<'a> = (&'a Rc<Direction>, i32, usize);

/// The borders on one line: at each end of a side the count of pieces to the left of `+normal` less those to the right changes.
fn net(frame: &Frame, sides: &[&Bound], normal: &Direction, generator: &Generator) -> Vec<Border> {
    // A side whose piece is where the normal points runs the way in which the ends are sorted here, as the loop of a piece
    // turns counter-clockwise for the receiver, about minus its own direction.
    let mut ends: Vec<End<'_>> = Vec::with_capacity(2 * sides.len());
    for side in sides {
        let step = if side.from.inward { 1 } else { -1 };
        let (low, high) = if side.from.inward { (&side.from.direction, &side.to) } else { (&side.to, &side.from.direction) };
        ends.extend([(low, step, side.triangle), (high, -step, side.triangle)]);
    }
    let order = |a: &Direction, b: &Direction| match b.cross(a) {
        None => std::cmp::Ordering::Equal,
        Some(turn) => 0.cmp(&turn.side(normal)),
    };
    ends.sort_by(|a, b| order(a.0, b.0));
    let cast = match generator {
        Generator::Occluder(line) => Some((**line).clone()),
        _ => None,
    };
    let mut borders = Vec::new();
    let (mut count, mut start): (i32, Option<End<'_>>) = (0, None);
    for place in ends.chunk_by(|a, b| order(a.0, b.0).is_eq()) {
        count += place.iter().map(|(_, step, _)| step).sum::<i32>();
        if start.is_some_and(|(_, sense, _)| sense == count) {
            continue;
        }
        if let Some((low, sense, triangle)) = start.take() {
            let owner = &frame.triangles[triangle];
            let [low, high] = [low, place[0].0].map(|direction| point(frame, owner, direction));
            let ends = if sense > 0 { [low, high] } else { [high, low] };
            borders.push(Border { triangle, stretch: Stretch::between(ends), cast: cast.clone() });
        }
        if count != 0 {
            let owner = place.iter().find(|(_, step, _)| step.signum() == count.signum()).map_or(place[0].2, |p| p.2);
            start = Some((place[0].0, count.signum(), owner));
        }
    }
    borders
}
