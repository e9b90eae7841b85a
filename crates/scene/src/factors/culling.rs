//! Faces that a face sees nothing of, found before anything is known of the two: boxes of faces at a time, by the index.
//!
//! The segment between the middles of two convex things says what probably hides them from each other: the first face that it meets. It is
//! proven by that face alone ([`Screen::between`]) or together with those that share its edges ([`fuse`]). Where the segment is hidden
//! and that does not prove it, the larger one of the two is halved, a few times.
//!
//! Of two faces the lower one looks, through the boxes of the index from the largest on. So whether a pair is found depends on the two and
//! on the scene alone, and not on what else is asked for.

use std::cell::RefCell;
use std::ops::Range;

use radgrad_core::DVec3;
use smallvec::SmallVec;

use super::FormFactors;
use super::bracket::{Partial, fuse};
use super::neighbours::Place;
use super::rule::{Patch, middle, patches};
use super::screen::Sight;
use crate::extremes::largest as larger;

/// Looks that are taken at a box, and at a face.
const LOOKS_AT_BOX: usize = 8;
const LOOKS_AT_FACE: usize = 32;

/// Parts that wait to be looked at, beyond those of the start, above which no proof is near: each part that is not hidden leaves one more.
const MOST_WAITING_AT_BOX: usize = 1;
const MOST_WAITING_AT_FACE: usize = 3;

/// Screens that hide something together, at most: in a look, and where all that may hide something is known.
const MOST_TOGETHER: usize = 8;
const MOST_KNOWN_TOGETHER: usize = 64;

/// Faces that are tried, at most, and how far inside their outline they are crossed at least, over the width of the beam.
const SEEDS: usize = 2;
const WORTHWHILE: f64 = 0.3;

/// The part of a box's size below which what looks at it is not halved.
const FINE: f64 = 0.3;

/// How far from the corners of a patch to its middle its first looks are.
const ASIDE: f64 = 0.05;

/// Faces that are asked for, by their places in the order of the index.
#[derive(Debug)]
pub(super) struct Wanted {
    is_wanted: Vec<bool>,
    /// One more than the last of them among so many places of the order from each place on, a power of two of them: 0 for none.
    last: Vec<Vec<usize>>,
}

impl Wanted {
    pub(super) fn new(order: &[usize], is_wanted: Vec<bool>) -> Self {
        let mut last: Vec<Vec<usize>> = vec![order.iter().map(|&face| if is_wanted[face] { face + 1 } else { 0 }).collect()];
        let mut width = 1;
        while 2 * width <= order.len() {
            let half = &last[last.len() - 1];
            let both = (width..half.len()).map(|place| half[place - width].max(half[place])).collect();
            last.push(both);
            width *= 2;
        }
        Self { is_wanted, last }
    }

    /// Whether a place of a range has one above `face`.
    fn any_above(&self, face: usize, range: Range<usize>) -> bool {
        let Some(level) = range.len().checked_ilog2() else { return false };
        let last = &self.last[level as usize];
        last[range.start].max(last[range.end - (1 << level)]) > face + 1
    }
}

/// Screens that were tried, as far as they are kept.
type Tried = [Option<Place>; SEEDS];
const NONE: Tried = [None; SEEDS];

/// A look at something convex.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Look {
    /// The segment between the middles is free.
    Free,
    Hidden,
    /// The segment is hidden, and the rest is not known.
    Unknown,
}

/// What is looked at: the corners, and the face that they are of, if any.
#[derive(Clone, Copy)]
struct Target<'a> {
    corners: &'a [DVec3],
    face: Option<usize>,
}

impl FormFactors<'_> {
    /// The faces above `from` that are wanted and not proven hidden from it: all that it may exchange light with.
    pub(super) fn may_see(&self, from: usize, wanted: &Wanted) -> Vec<usize> {
        let mut found = Vec::new();
        let cells = patches(self.scaled(from).vertices());
        // The boxes around the last one, and what was tried for each.
        let around: RefCell<Vec<(Range<usize>, Tried)>> = RefCell::default();
        let enter = |range: Range<usize>, corners: [DVec3; 8]| {
            if self.is_stopped() || !wanted.any_above(from, range.clone()) {
                return false;
            }
            let mut around = around.borrow_mut();
            while around.last().is_some_and(|(outer, _)| range.start < outer.start || range.end > outer.end) {
                around.pop();
            }
            let mut tried = around.last().map_or(NONE, |(_, tried)| *tried);
            let corners = corners.map(|corner| corner * self.power);
            // A face that cannot be cut into patches looks at all.
            let may_see = cells.is_empty() || self.hiders.is_empty() || self.may_see_box(from, &cells, &corners, &mut tried);
            around.push((range, tried));
            may_see
        };
        self.index.facing(from, enter, |to| {
            let tried = around.borrow().last().map_or(NONE, |(_, tried)| *tried);
            if to > from && wanted.is_wanted[to] && !self.is_behind([from, to]) && self.may_see_face(from, &cells, to, tried) {
                found.push(to);
            }
        });
        found
    }

    /// Whether a box is not proven hidden from all patches of a face.
    fn may_see_box(&self, from: usize, cells: &[Patch], corners: &[DVec3], tried: &mut Tried) -> bool {
        let fine = FINE * (corners[7] - corners[0]).length();
        let (mut looks, most) = (0, cells.len() + MOST_WAITING_AT_BOX);
        let mut open = cells.to_vec();
        while let Some(cell) = open.pop() {
            looks += 1;
            match self.look(from, cell.outline(), Target { corners, face: None }, tried) {
                Look::Hidden => {}
                Look::Unknown if looks < LOOKS_AT_BOX && open.len() < most && size(&cell) > fine => open.extend(halves(&cell)),
                Look::Unknown | Look::Free => return true,
            }
        }
        false
    }

    /// Whether a face is not proven hidden from all patches of another.
    fn may_see_face(&self, from: usize, cells: &[Patch], to: usize, mut tried: Tried) -> bool {
        if self.hiders.is_empty() {
            return true;
        }
        let targets = patches(self.scaled(to).vertices());
        let mut open: Vec<[Patch; 2]> =
            cells.iter().flat_map(|&cell| targets.iter().map(move |&target| [cell, target])).collect();
        if open.is_empty() {
            return true;
        }
        let (mut looks, most) = (0, open.len() + MOST_WAITING_AT_FACE);
        while let Some([cell, target]) = open.pop() {
            looks += 1;
            match self.look(from, cell.outline(), Target { corners: target.outline(), face: Some(to) }, &mut tried) {
                Look::Hidden => {}
                Look::Unknown if looks == 1 && self.is_sight_between([from, to], [cell.outline(), target.outline()]) => {
                    return true;
                }
                Look::Unknown if looks < LOOKS_AT_FACE && open.len() < most => {
                    if size(&cell) > size(&target) {
                        open.extend(halves(&cell).map(|half| [half, target]));
                    } else {
                        open.extend(halves(&target).map(|half| [cell, half]));
                    }
                }
                Look::Unknown | Look::Free => return true,
            }
        }
        false
    }

    /// Whether a segment from near a corner of one convex thing to near one of another is free.
    fn is_sight_between(&self, own: [usize; 2], outlines: [&[DVec3]; 2]) -> bool {
        let [cell, target] = outlines.map(|outline| (outline, middle(outline)));
        let near = |(outline, middle): (&[DVec3], DVec3), k: usize| (outline[k] + (middle - outline[k]) * ASIDE) / self.power;
        (0..cell.0.len()).any(|i| {
            (0..target.0.len()).any(|j| !self.index.is_any_between(&self.hiders, [near(cell, i), near(target, j)], &own))
        })
    }

    /// A look. What was tried where the target is a part of is tried first, and is what this one tried then.
    fn look(&self, from: usize, cell: &[DVec3], target: Target<'_>, tried: &mut Tried) -> Look {
        let middles = [middle(cell), middle(target.corners)];
        let own = [from, target.face.unwrap_or(from)];
        let is_hidden_by = |seed: Place| self.hide([cell, target.corners], middles, own, (seed, MOST_TOGETHER), target.face);
        // Of a box's faces none is tried whose plane has a part of the box before it.
        let may_be_tried =
            |face: usize| !own.contains(&face) && (target.face.is_some() || self.is_before(face, middles[0], target.corners));
        let before = tried.map(|seed| seed.filter(|seed| may_be_tried(seed.0)));
        if before.iter().flatten().any(|&seed| is_hidden_by(seed)) {
            return Look::Hidden;
        }
        let mut crossing = self.index.all_between(&self.hiders, middles.map(|point| point / self.power), &own);
        crossing.retain(|&(face, _)| may_be_tried(face));
        if crossing.is_empty() {
            return Look::Free;
        }
        let radius = |points: &[DVec3], middle: DVec3| points.iter().map(|&p| (p - middle).length()).fold(0.0, larger);
        let [near, far] = [radius(cell, middles[0]), radius(target.corners, middles[1])];
        let along = (middles[1] - middles[0]).normalize_or_zero();
        // How far inside its outline a face is crossed, for the width of the beam there.
        let worth = |(face, share): (usize, f64)| {
            let point = middles[0] + (middles[1] - middles[0]) * share;
            let clear = self.neighbours().clearance((face, self.scaled(face).normal()), point, along);
            (face, clear / (near + (far - near) * share))
        };
        let mut worths: Vec<(usize, f64)> = crossing.into_iter().map(worth).filter(|(_, worth)| *worth > WORTHWHILE).collect();
        worths.sort_unstable_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let seeds = worths.iter().take(SEEDS).flat_map(|&(face, _)| (0..self.screens[face].len()).map(move |part| (face, part)));
        *tried = NONE;
        for (k, seed) in seeds.enumerate() {
            if !before.contains(&Some(seed)) && is_hidden_by(seed) {
                return Look::Hidden;
            }
            if let Some(tried) = tried.get_mut(k) {
                *tried = Some(seed);
            }
        }
        Look::Unknown
    }

    /// Whether a face's plane has a point on one side and all the others on the other.
    fn is_before(&self, face: usize, point: DVec3, others: &[DVec3]) -> bool {
        let (normal, origin) = (self.scaled(face).normal(), self.scaled(face).vertices()[0]);
        let own = normal.dot(point - origin);
        others.iter().all(|&other| own * normal.dot(other - origin) < 0.0)
    }

    /// Whether a screen between the middles of patches of two faces hides the patches from each other, alone or with others.
    pub(super) fn hide_by(&self, cells: [&[DVec3]; 2], middles: [DVec3; 2], faces: [usize; 2], screen: Place) -> bool {
        self.screens[screen.0][screen.1].is_met(middles)
            && self.hide(cells, middles, faces, (screen, MOST_KNOWN_TOGETHER), Some(faces[1]))
    }

    /// Whether a screen hides two convex things from each other, alone or with those that share its edges, so many at most.
    fn hide(
        &self,
        cells: [&[DVec3]; 2],
        middles: [DVec3; 2],
        own: [usize; 2],
        (seed, most): (Place, usize),
        to: Option<usize>,
    ) -> bool {
        let mut partials: SmallVec<[Partial<'_>; MOST_TOGETHER]> = SmallVec::new();
        let mut known: SmallVec<[Place; MOST_TOGETHER]> = SmallVec::new();
        // Edges that are not decided, and what is on the other side of them.
        let mut open: SmallVec<[(Option<[DVec3; 2]>, Place); MOST_TOGETHER]> = SmallVec::new();
        open.push((None, seed));
        let screen_at = |(face, part): Place| &self.screens[face][part];
        let mut next = 0;
        while let Some(&(edge, place)) = open.get(next) {
            next += 1;
            if known.contains(&place) {
                continue;
            }
            known.push(place);
            if known.len() > most {
                return false;
            }
            let screen = screen_at(place);
            // A box that touches its plane may have a face there that stands back to back with it, and is seen.
            if to.is_none() && cells[1].iter().any(|&corner| screen.height(corner) == 0.0) {
                return false;
            }
            let Some(verdict) = screen.parting(cells, 1.0) else { return false };
            match (verdict.sight, verdict.edges) {
                _ if verdict.is_displaced => return false,
                (Sight::Blocked, _) => return true,
                (Sight::Part, Some(undecided)) => {
                    let edges = || screen.undecided(undecided);
                    let before: usize = self.screens[place.0][..place.1].iter().map(|part| part.outline().len()).sum();
                    // An outline ends here.
                    if edge.is_some_and(|[a, b]| !edges().any(|edge| edge == [b, a])) {
                        return false;
                    }
                    for (k, [a, b]) in screen.numbered(undecided) {
                        let is_joined = partials.iter().any(|other| other.edges().any(|edge| edge == [b, a]));
                        if is_joined {
                            continue;
                        }
                        let beyond = self.neighbours().beyond(place.0, before + k).filter(|other| !own.contains(&other.0));
                        let count = open.len();
                        open.extend(beyond.map(|other| (Some([a, b]), other)));
                        if open.len() == count {
                            return false;
                        }
                    }
                    partials.push(Partial { screen, name: 0, open: undecided });
                }
                _ => return false,
            }
        }
        fuse(&partials, middles).is_all_hidden
    }
}

/// The longer diagonal.
fn size(patch: &Patch) -> f64 {
    let [a, b, c, d] = patch.corners;
    larger((c - a).length(), (d - b).length())
}

fn halves(patch: &Patch) -> [Patch; 2] {
    let [along, across] = patch.sides();
    patch.halves(usize::from(across > along))
}

#[cfg(test)]
mod tests {
    use radgrad_core::Polygon;

    use super::*;
    use crate::Scene;
    use crate::factors::tests::draws;

    /// Blocks in rows with streets between them, on a ground.
    fn town(side: u8) -> Scene {
        let mut scene = Scene::new(["grey"]).unwrap();
        let material = scene.add_material("white", [0.5], [0.0]).unwrap();
        let surface = scene.add_surface("all");
        let mut add = |corners: [[f64; 3]; 4]| {
            let polygon = Polygon::new(corners.map(DVec3::from).to_vec()).unwrap();
            scene.add_face(surface, material, polygon, None).unwrap();
        };
        for (i, j) in (0..side).flat_map(|i| (0..side).map(move |j| (i, j))) {
            let height = 1.0 + 0.3 * f64::from((3 * i + 5 * j) % 4);
            let ([x, y], [u, v]) = ([f64::from(i), f64::from(j)], [f64::from(i) + 0.6, f64::from(j) + 0.6]);
            for ([p, q], [r, s]) in [([x, y], [u, y]), ([u, y], [u, v]), ([u, v], [x, v]), ([x, v], [x, y])] {
                add([[p, q, 0.0], [r, s, 0.0], [r, s, height], [p, q, height]]);
            }
            add([[x, y, height], [u, y, height], [u, v, height], [x, v, height]]);
        }
        scene
    }

    #[test]
    fn what_is_proven_hidden_is_seen_from_no_point_and_by_whichever_way_it_is_asked_for() {
        let scene = town(5);
        let factors = FormFactors::new(&scene).unwrap();
        let count = scene.faces().len();
        let all = Wanted::new(factors.index.order(), vec![true; count]);
        let mut uniform = draws(3);
        let (mut hidden, mut seen) = (0, 0);
        for from in (0..count).step_by(3) {
            let found = factors.may_see(from, &all);
            for to in from + 1..count {
                let faces_it = |a: usize, b: usize| {
                    let (plane, other) = (factors.polygon(a), factors.polygon(b));
                    other.vertices().iter().any(|&v| plane.normal().dot(v - plane.vertices()[0]) > 1e-9)
                };
                if !faces_it(from, to) || !faces_it(to, from) {
                    continue;
                }
                let is_found = found.contains(&to);
                if to % 7 == 0 {
                    let one = Wanted::new(factors.index.order(), (0..count).map(|face| face == to).collect());
                    assert_eq!(!factors.may_see(from, &one).is_empty(), is_found, "{from} {to}");
                }
                (hidden, seen) = (hidden + usize::from(!is_found), seen + usize::from(is_found));
                if is_found {
                    continue;
                }
                for _ in 0..40 {
                    let segment = [from, to].map(|face| patches(factors.polygon(face).vertices())[0].at(uniform(), uniform()).0);
                    let is_in_front = [(from, 1), (to, 0)].iter().all(|&(face, end)| {
                        let plane = factors.polygon(face);
                        plane.normal().dot(segment[end] - plane.vertices()[0]) > 1e-9
                    });
                    assert!(!is_in_front || factors.index.is_between(segment, &[from, to]), "{from} {to} {segment:?}");
                }
            }
        }
        assert!(hidden > 50 && seen > 50, "{hidden} {seen}");
    }
}
