//! Whether the faces of a scene close: each edge of one must be that of another that runs the other way.
//!
//! Vertices nearer than the rounding of coordinates are one, and an edge ends where a vertex of another edge without counterpart is on it, so
//! that a long edge is met by several short ones.

use std::collections::{BTreeMap, HashMap};

use radgrad_core::DVec3;

use super::Scene;
use crate::extremes::{largest, smallest};

/// Vertices are one within this part of the scene's extent, if its rounding is less.
const SAME: f64 = 1e-9;

/// What is wrong with an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum SeamKind {
    /// Only one face has it.
    Open,
    /// Two faces have it, and run along it the same way: one of them is turned around.
    Turned,
    /// More than two faces have it, not as many one way as the other.
    Doubled,
}

/// An edge, or a part of one, at which faces do not close.
#[derive(Debug, Clone, PartialEq)]
pub struct Seam {
    /// What is wrong.
    pub kind: SeamKind,
    /// Its ends.
    pub ends: [DVec3; 2],
    /// The faces that have it.
    pub faces: Vec<usize>,
}

/// Faces that hang together by their edges.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// The faces, ascending.
    pub faces: Vec<usize>,
    /// Whether no edge of it is a [`Seam`].
    pub is_closed: bool,
    /// The volume that it encloses if it is closed: negative where faces look inward, as those of a room do.
    pub volume: f64,
}

/// How far the faces of a scene close.
#[derive(Debug, Clone, PartialEq)]
pub struct Closedness {
    /// Edges, those that two faces share counted once.
    pub edges: usize,
    /// Edges at which faces do not close.
    pub seams: Vec<Seam>,
    /// Faces that hang together, the largest extent first.
    pub parts: Vec<Part>,
}

impl Scene {
    /// Whether the faces close, at which edges they do not, and what hangs together.
    ///
    /// ```
    /// use radgrad_scene::{Degenerate, Scene};
    /// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");
    /// let found = Scene::read(file, Degenerate::Refuse)?.closedness();
    /// assert!(found.seams.is_empty() && found.parts[0].volume < 0.0);
    /// # Ok::<(), radgrad_scene::Error>(())
    /// ```
    #[must_use]
    pub fn closedness(&self) -> Closedness {
        let outlines: Vec<&[DVec3]> = self.polygons().map(radgrad_core::Polygon::vertices).collect();
        let extent = self.bounds().map_or(0.0, |(low, high)| (high - low).length());
        let near = largest(2.0 * self.modelling().precision, SAME * extent);
        let (points, corners) = welded(&outlines, near);
        let mut sides = Vec::new();
        for (face, corners) in corners.iter().enumerate() {
            let next = corners.iter().cycle().skip(1);
            sides.extend(corners.iter().zip(next).filter(|(from, to)| from != to).map(|(&from, &to)| Side { from, to, face }));
        }
        let runs = Runs::of(&sides);
        let single: Vec<Side> = sides.iter().copied().filter(|side| !runs.balances(*side)).collect();
        let cut = cut(&single, &points, near);
        let kept = sides.into_iter().filter(|side| runs.balances(*side));
        let all: Vec<Side> = kept.chain(cut).collect();
        let runs = Runs::of(&all);
        let seams: Vec<Seam> = runs.seams(&points).collect();
        let parts = self.parts(&runs, &seams);
        Closedness { edges: runs.0.len(), seams, parts }
    }

    fn parts(&self, runs: &Runs, seams: &[Seam]) -> Vec<Part> {
        let mut roots: Vec<usize> = (0..self.faces().len()).collect();
        for sides in runs.0.values() {
            let faces = sides.iter().map(|side| side.face);
            for (face, other) in faces.clone().zip(faces.skip(1)) {
                let [a, b] = [face, other].map(|face| root(&mut roots, face));
                roots[b] = a;
            }
        }
        let mut of_root: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for face in 0..roots.len() {
            of_root.entry(root(&mut roots, face)).or_default().push(face);
        }
        let mut open = vec![false; roots.len()];
        seams.iter().flat_map(|seam| &seam.faces).for_each(|&face| open[face] = true);
        let mut parts: Vec<(f64, Part)> = of_root
            .into_values()
            .map(|faces| {
                let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
                let outline = |face: usize| self.faces()[face].polygon().vertices();
                for vertex in faces.iter().flat_map(|&face| outline(face)) {
                    (low, high) = (low.min(*vertex), high.max(*vertex));
                }
                let middle = 0.5 * (low + high);
                let under = |face: &usize| {
                    let vertices = outline(*face);
                    let fan = vertices.windows(2).skip(1);
                    fan.map(|pair| (vertices[0] - middle).dot((pair[0] - middle).cross(pair[1] - middle))).sum::<f64>()
                };
                let volume = faces.iter().map(under).sum::<f64>() / 6.0;
                let is_closed = !faces.iter().any(|&face| open[face]);
                ((high - low).length(), Part { faces, is_closed, volume })
            })
            .collect();
        parts.sort_by(|a, b| b.0.total_cmp(&a.0));
        parts.into_iter().map(|(_, part)| part).collect()
    }
}

fn root(roots: &mut [usize], mut face: usize) -> usize {
    while roots[face] != face {
        roots[face] = roots[roots[face]];
        face = roots[face];
    }
    face
}

/// A side of a face, between two points.
#[derive(Debug, Clone, Copy)]
struct Side {
    from: usize,
    to: usize,
    face: usize,
}

/// The sides between each two points.
struct Runs(BTreeMap<[usize; 2], Vec<Side>>);

impl Runs {
    fn of(sides: &[Side]) -> Self {
        let mut runs: BTreeMap<[usize; 2], Vec<Side>> = BTreeMap::new();
        for side in sides {
            runs.entry([side.from.min(side.to), side.from.max(side.to)]).or_default().push(*side);
        }
        Self(runs)
    }

    /// Sides one way and the other.
    fn ways(sides: &[Side]) -> [usize; 2] {
        let upward = sides.iter().filter(|side| side.from < side.to).count();
        [upward, sides.len() - upward]
    }

    fn balances(&self, side: Side) -> bool {
        let [one, other] = Self::ways(&self.0[&[side.from.min(side.to), side.from.max(side.to)]]);
        one == other
    }

    fn seams(&self, points: &[DVec3]) -> impl Iterator<Item = Seam> {
        self.0.iter().filter_map(|(ends, sides)| {
            let kind = match Self::ways(sides) {
                [one, other] if one == other => return None,
                [1, 0] | [0, 1] => SeamKind::Open,
                [2, 0] | [0, 2] => SeamKind::Turned,
                _ => SeamKind::Doubled,
            };
            Some(Seam { kind, ends: ends.map(|end| points[end]), faces: sides.iter().map(|side| side.face).collect() })
        })
    }
}

/// The points of all outlines, those that are near each other once, and those of each outline.
fn welded(outlines: &[&[DVec3]], near: f64) -> (Vec<DVec3>, Vec<Vec<usize>>) {
    // Cells of twice the distance: what is near a point is in its cell or one beside it.
    let scale = if near > 0.0 { 0.5 / near } else { 0.0 };
    #[expect(clippy::cast_possible_truncation, reason = "a floor within 2^53, or saturated")]
    let cell = |point: DVec3| (point * scale).floor().to_array().map(|x| x as i64);
    let (mut points, mut cells): (Vec<DVec3>, HashMap<[i64; 3], Vec<usize>>) = (Vec::new(), HashMap::new());
    let mut index_of = |point: DVec3| {
        let [x, y, z] = cell(point);
        for place in
            (0..27_i64).map(|k| [x.saturating_add(k % 3 - 1), y.saturating_add(k / 3 % 3 - 1), z.saturating_add(k / 9 - 1)])
        {
            let found = cells.get(&place).and_then(|of| of.iter().find(|&&other| (points[other] - point).length() <= near));
            if let Some(&found) = found {
                return found;
            }
        }
        points.push(point);
        cells.entry([x, y, z]).or_default().push(points.len() - 1);
        points.len() - 1
    };
    let corners = outlines.iter().map(|outline| outline.iter().map(|&point| index_of(point)).collect()).collect();
    (points, corners)
}

/// Sides cut at the points of others that are on them.
fn cut(sides: &[Side], points: &[DVec3], near: f64) -> Vec<Side> {
    let mut ends: Vec<usize> = sides.iter().flat_map(|side| [side.from, side.to]).collect();
    ends.sort_by(|&a, &b| points[a].x.total_cmp(&points[b].x).then(a.cmp(&b)));
    ends.dedup();
    let mut found = Vec::new();
    for side in sides {
        let (from, to) = (points[side.from], points[side.to]);
        let along = (to - from).normalize_or_zero();
        let length = (to - from).length();
        let first = ends.partition_point(|&end| points[end].x < smallest(from.x, to.x) - near);
        let within = ends[first..].iter().take_while(|&&end| points[end].x <= largest(from.x, to.x) + near);
        let on = within.filter_map(|&end| {
            let reach = points[end] - from;
            let place = reach.dot(along);
            let is_on = place > near && place < length - near && (reach - along * place).length() <= near;
            is_on.then_some((place, end))
        });
        let mut stops: Vec<(f64, usize)> = on.collect();
        stops.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut last = side.from;
        for next in stops.into_iter().map(|(_, end)| end).chain([side.to]) {
            found.push(Side { from: last, to: next, face: side.face });
            last = next;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use radgrad_core::Polygon;

    use super::*;

    /// A cube from 0 to 1 whose faces look inward, some of them left out, turned around or added twice; the ceiling is cut in two.
    fn cube(without: &[usize], turned: &[usize], twice: &[usize]) -> Closedness {
        let faces: [&[[f64; 3]]; 7] = [
            &[[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]],
            &[[0., 0., 1.], [0., 1., 1.], [0.3, 1., 1.], [0.3, 0., 1.]],
            &[[0.3, 0., 1.], [0.3, 1., 1.], [1., 1., 1.], [1., 0., 1.]],
            &[[0., 0., 0.], [0., 0., 1.], [1., 0., 1.], [1., 0., 0.]],
            &[[0., 1., 0.], [1., 1., 0.], [1., 1., 1.], [0., 1., 1.]],
            &[[0., 0., 0.], [0., 1., 0.], [0., 1., 1.], [0., 0., 1.]],
            &[[1., 0., 0.], [1., 0., 1.], [1., 1., 1.], [1., 1., 0.]],
        ];
        let mut scene = Scene::new(["grey"]).unwrap();
        let grey = scene.add_material("grey", [0.5], [0.0]).unwrap();
        let walls = scene.add_surface("walls");
        for (index, face) in faces.iter().enumerate().filter(|(index, _)| !without.contains(index)) {
            let mut corners: Vec<DVec3> = face.iter().map(|&corner| DVec3::from(corner)).collect();
            if turned.contains(&index) {
                corners.reverse();
            }
            for _ in 0..=usize::from(twice.contains(&index)) {
                scene.add_face(walls, grey, Polygon::new(corners.clone()).unwrap(), None).unwrap();
            }
        }
        scene.closedness()
    }

    #[test]
    fn a_room_with_a_divided_ceiling_is_closed_and_its_volume_is_negative() {
        let found = cube(&[], &[], &[]);
        assert_eq!((found.seams.len(), found.parts.len()), (0, 1));
        assert!(found.parts[0].is_closed && (found.parts[0].volume + 1.0).abs() < 1e-12, "{found:?}");
        // Turned around altogether it is closed too, and seen from outside.
        let outward = cube(&[], &[0, 1, 2, 3, 4, 5, 6], &[]);
        assert!(outward.seams.is_empty() && (outward.parts[0].volume - 1.0).abs() < 1e-12);
    }

    #[test]
    fn edges_that_are_open_turned_or_doubled_are_told_apart_and_name_their_faces() {
        let kinds = |found: &Closedness| {
            let mut kinds: Vec<SeamKind> = found.seams.iter().map(|seam| seam.kind).collect();
            kinds.sort();
            kinds.dedup();
            (kinds, found.seams.len())
        };
        // The floor has four edges, and the smaller half of the ceiling four, two of them parts of the walls' edges.
        assert_eq!(kinds(&cube(&[0], &[], &[])), (vec![SeamKind::Open], 4));
        assert_eq!(kinds(&cube(&[1], &[], &[])), (vec![SeamKind::Open], 4));
        let turned = cube(&[], &[1], &[]);
        assert_eq!(kinds(&turned), (vec![SeamKind::Turned], 4));
        assert!(turned.seams.iter().all(|seam| seam.faces.contains(&1)) && !turned.parts[0].is_closed);
        assert_eq!(kinds(&cube(&[], &[], &[0])), (vec![SeamKind::Doubled], 4));
    }
}
