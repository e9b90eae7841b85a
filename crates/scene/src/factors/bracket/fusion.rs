//! Screens with common edges, which hide more together than one by one.
//!
//! Of screens that two cells are wholly on the two sides of, a segment meets a screen where it passes inside all of its edges. Let N be
//! the number of screens of a group that it meets. As the segment moves, N changes only where it passes through an edge that is not
//! decided between the two cells, and there by one for each screen of that edge: up for those that have it on one side, down for
//! those on the other. So an edge that two screens have, running opposite ways seen from the first cell, leaves N as it is, and
//! does not count: over all segments but a set of no measure, since segments through two edges at once are one.
//!
//! - If no edge of a group is left, N is the same for all segments, and one of them says whether the group hides all or nothing.
//! - If one is left, it passes through all of the beam or no segment passes it: an edge that ended in the beam would go on in another, as the
//!   boundary of a sum of screens is closed. Then the group hides all if it does so on both sides of that edge. Else it hides what passes inside, if
//!   the screens of that edge have no other one that is not decided: T changes its sign beyond the end of an edge too, where N does not change, as
//!   beside a corner of a block that is beside the beam.
//! - If two groups have the same edges left, running the same way and as often, their numbers N differ by the same for all segments.
//!   Where one segment meets as many of both, they hide the same, and one is left out: the near walls of a block, or its far ones.
//!
//! Groups are screens connected by edges that do not count, so that what one leaves open does not spoil another.

use radgrad_core::DVec3;

use crate::factors::screen::{Screen, Undecided};

/// A screen that hides a part, as far as it alone says.
#[derive(Debug, Clone, Copy)]
pub(in crate::factors) struct Partial<'a> {
    pub(in crate::factors) screen: &'a Screen,
    /// A number by which the caller knows it.
    pub(in crate::factors) name: u32,
    /// Its edges that are not decided.
    pub(in crate::factors) open: Undecided,
}

impl Partial<'_> {
    /// The edges that are not decided, counter-clockwise seen from the first cell.
    pub(in crate::factors) fn edges(&self) -> impl Iterator<Item = [DVec3; 2]> + Clone {
        self.screen.undecided(self.open)
    }
}

/// Edges, and how often a group has each.
type Left = Vec<([DVec3; 2], i32)>;

/// The region inside all of some edges.
pub(in crate::factors) type Shadow = Vec<[DVec3; 2]>;

/// The groups of screens that hide together.
#[derive(Debug, Default)]
pub(in crate::factors) struct Fused {
    /// Whether one hides all.
    pub(in crate::factors) is_all_hidden: bool,
    /// Those that hide something.
    pub(in crate::factors) groups: Vec<Group>,
}

/// Screens that hide something together.
#[derive(Debug, Default)]
pub(in crate::factors) struct Group {
    /// By their places.
    pub(in crate::factors) members: Vec<usize>,
    /// What they hide is what these hide.
    pub(in crate::factors) shadows: Vec<Shadow>,
}

/// Edges above which groups are not looked for: pairs of them are compared.
const MOST_EDGES: usize = 160;

/// What screens hide together; `segment` runs between the middles of the two cells.
pub(in crate::factors) fn fuse(partials: &[Partial<'_>], segment: [DVec3; 2]) -> Fused {
    let mut fused = Fused::default();
    // A single screen hides what is inside its edges.
    if let [partial] = partials {
        fused.groups.push(Group { members: vec![0], shadows: vec![partial.edges().collect()] });
        return fused;
    }
    let edges: Vec<(usize, [DVec3; 2])> =
        partials.iter().enumerate().flat_map(|(k, partial)| partial.edges().map(move |edge| (k, edge))).collect();
    let mut group: Vec<usize> = (0..partials.len()).collect();
    let mut is_left = vec![true; edges.len()];
    if edges.len() <= MOST_EDGES {
        let keys: Vec<u64> = edges.iter().map(|(_, edge)| key(edge)).collect();
        for i in 0..edges.len() {
            let (k, [a, b]) = edges[i];
            if !is_left[i] {
                continue;
            }
            let mut others = (i + 1..edges.len()).filter(|&j| keys[j] == keys[i]);
            let opposite = others.find(|&j| is_left[j] && edges[j].0 != k && edges[j].1 == [b, a]);
            if let Some(j) = opposite {
                (is_left[i], is_left[j]) = (false, false);
                let [from, to] = [group[k], group[edges[j].0]];
                group.iter_mut().filter(|name| **name == from).for_each(|name| *name = to);
            }
        }
    }
    // What groups have left, and how many of each the segment meets.
    let mut others: Vec<(Left, i32)> = Vec::new();
    for name in 0..partials.len() {
        let members: Vec<usize> = (0..partials.len()).filter(|&k| group[k] == name).collect();
        if members.is_empty() {
            continue;
        }
        // The group's edges without those that two members share, each once, and how often.
        let mut left: Left = Vec::new();
        for (_, edge) in edges.iter().zip(&is_left).filter(|((k, _), left)| **left && group[*k] == name).map(|(edge, _)| edge) {
            match left.iter_mut().find(|(other, _)| other == edge) {
                Some((_, times)) => *times += 1,
                None => left.push((*edge, 1)),
            }
        }
        let met = met(partials, &members, segment);
        let outside = match left[..] {
            [] => met,
            [(edge, times)] => passes_inside(edge, segment).and_then(|is_inside| Some(met? - if is_inside { times } else { 0 })),
            _ => None,
        };
        match (outside, &left[..]) {
            (Some(1..), _) => return Fused { is_all_hidden: true, ..fused },
            (Some(_), []) => continue,
            _ => {}
        }
        if let Some(met) = met {
            let is_same = |other: &Left| other.len() == left.len() && left.iter().all(|edge| other.contains(edge));
            if others.iter().any(|(other, count)| *count == met && is_same(other)) {
                continue;
            }
            others.push((left.clone(), met));
        }
        let shadows = match (outside, &left[..]) {
            (Some(_), [(edge, _)]) if members.iter().all(|&k| is_open_alone(&partials[k], *edge)) => vec![vec![*edge]],
            // Each screen for itself.
            _ => members.iter().map(|&k| partials[k].edges().collect()).collect(),
        };
        fused.groups.push(Group { members, shadows });
    }
    fused
}

/// Whether a screen that has this edge has no other one that is not decided: then segments pass the edge wherever T changes its sign.
fn is_open_alone(partial: &Partial<'_>, edge: [DVec3; 2]) -> bool {
    let mut edges = partial.edges();
    edges.clone().all(|other| other != edge) || edges.all(|other| other == edge)
}

/// A number that an edge has either way.
fn key([a, b]: &[DVec3; 2]) -> u64 {
    // Zeros of either sign are one.
    let sum = *a + *b + DVec3::ZERO;
    sum.x.to_bits() ^ sum.y.to_bits().rotate_left(21) ^ sum.z.to_bits().rotate_left(42)
}

/// How many of some screens a segment meets, if it passes all their edges clearly.
fn met(partials: &[Partial<'_>], members: &[usize], segment: [DVec3; 2]) -> Option<i32> {
    members.iter().try_fold(0, |count, &k| {
        let mut is_met = true;
        for edge in partials[k].edges() {
            is_met &= passes_inside(edge, segment)?;
        }
        Some(count + i32::from(is_met))
    })
}

/// Whether a segment passes inside an edge, if that is clear of rounding: a term of T passes through ten roundings
/// ([`crate::factors::screen`]).
fn passes_inside([a, b]: [DVec3; 2], [x, y]: [DVec3; 2]) -> Option<bool> {
    let (r, to_a, to_b) = (y - x, a - x, b - x);
    let turn = r.dot(to_b.cross(to_a));
    let error = 64.0 * f64::EPSILON * r.length() * to_a.length() * to_b.length() + f64::MIN_POSITIVE;
    if turn.abs() > error { Some(turn > 0.0) } else { None }
}

#[cfg(test)]
mod tests {
    use radgrad_core::Polygon;

    use super::*;
    use crate::factors::screen::{Cells, Screen, Sight};
    use crate::factors::tests::draws;

    /// Two squares side by side at height 0.5, as one sees them from below, and the sight that they leave between small cells
    /// above and below.
    #[test]
    fn neighbours_hide_all_behind_their_common_edge_and_one_edge_is_left_at_their_end() {
        let square = |low: [f64; 2], z: f64, size: f64| {
            [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
                .map(|(x, y)| DVec3::new(low[0] + size * x, low[1] + size * y, z))
                .to_vec()
        };
        // One of them faces up, the other down.
        let mut other = square([1.0, 0.0], 0.5, 1.0);
        other.reverse();
        let screens: Vec<Screen> = [square([0.0, 0.0], 0.5, 1.0), other]
            .into_iter()
            .flat_map(|corners| Screen::all_of(&Polygon::new(corners).unwrap()))
            .collect();
        let fused = |low: [f64; 2]| {
            let cells = [square(low, 0.0, 0.2), square(low, 1.0, 0.2)];
            let mut partials = Vec::new();
            for (k, screen) in (0..).zip(&screens) {
                let verdict = screen.between(&Cells::new([&cells[0], &cells[1]]), 1.0, Undecided::ALL);
                if verdict.sight == Sight::Part {
                    partials.push(Partial { screen, name: k, open: verdict.edges.unwrap() });
                }
            }
            let middle = |cell: &[DVec3]| cell.iter().sum::<DVec3>() / 4.0 + DVec3::new(0.01, 0.003, 0.0);
            let found = fuse(&partials, [middle(&cells[0]), middle(&cells[1])]);
            // By their names.
            let name = |&place: &usize| partials[place].name as usize;
            let named = |group: Group| Group { members: group.members.iter().map(name).collect(), ..group };
            (found.is_all_hidden, found.groups.into_iter().map(named).collect::<Vec<_>>())
        };
        assert!(fused([0.9, 0.4]).0);
        // At the end of the common edge: two edges go on in one line.
        let (is_all_hidden, end) = fused([0.9, -0.1]);
        let [end] = &end[..] else { panic!("{end:?}") };
        assert!(!is_all_hidden && end.members == [0, 1] && end.shadows.iter().all(|shadow| shadow.len() == 2));
        // At the outer end of one.
        let (is_all_hidden, side) = fused([1.9, 0.4]);
        let [side] = &side[..] else { panic!("{side:?}") };
        assert!(!is_all_hidden && side.shadows.len() == 1 && side.members == [1]);
        let [[a, b]] = side.shadows[0][..] else { panic!("{side:?}") };
        assert!(a.x == 2.0 && b.x == 2.0);
    }

    /// A closed box that hides a part.
    #[test]
    fn of_near_and_far_walls_one_kind_counts() {
        let corner = |k: usize| DVec3::new((k & 1) as f64, (k >> 1 & 1) as f64, 0.4 + 0.2 * (k >> 2 & 1) as f64);
        let walls = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let screens: Vec<Screen> =
            walls.iter().flat_map(|wall| Screen::all_of(&Polygon::new(wall.map(corner).to_vec()).unwrap())).collect();
        let square = |x: f64, z: f64| [(0.0, 0.3), (0.1, 0.3), (0.1, 0.4), (0.0, 0.4)].map(|(u, y)| DVec3::new(x + u, y, z));
        let cells = [square(1.05, 0.0), square(0.82, 1.0)];
        let mut partials = Vec::new();
        for (k, screen) in (0..).zip(&screens) {
            let verdict = screen.between(&Cells::new([&cells[0], &cells[1]]), 1.0, Undecided::ALL);
            assert!(verdict.sight != Sight::Part || verdict.edges.is_some());
            partials.extend(verdict.edges.map(|open| Partial { screen, name: k, open }));
        }
        let fused = fuse(&partials, [DVec3::new(1.1, 0.35, 0.0), DVec3::new(0.87, 0.35, 1.0)]);
        // The lower wall and the one beside are near, the upper one is far: it hides what those hide.
        let members = fused.groups.iter().flat_map(|group| &group.members);
        let names: Vec<u32> = members.map(|&place| partials[place].name).collect();
        assert!(partials.len() == 3 && !fused.is_all_hidden && names == [1], "{fused:?}");
    }

    /// Cells on two sides of some walls of a drawn block, near one of its corners, and drawn segments between them: one meets a screen if and only
    /// if it is inside a shadow.
    #[test]
    fn shadows_hide_what_screens_hide() {
        let mut draw = draws(11);
        let mut uniform = || draw() - 0.5;
        let (mut fewer, mut inside) = (0, 0);
        for _ in 0..20_000 {
            let size = DVec3::new(0.3 + 0.2 * uniform(), 0.3 + 0.2 * uniform(), 0.3 + 0.2 * uniform());
            let corner = |k: usize| size * DVec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2 & 1) as f64);
            let walls = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
            let some: Vec<_> = walls.iter().filter(|_| uniform() < 0.1).collect();
            let screens: Vec<Screen> =
                some.iter().flat_map(|wall| Screen::all_of(&Polygon::new(wall.map(corner).to_vec()).unwrap())).collect();
            let mut drawn = || DVec3::new(uniform(), uniform(), uniform());
            let (along, near) = (drawn().normalize(), size + drawn() * 0.3);
            let mut cell = |middle: DVec3| {
                let [a, b] = [drawn(), drawn()].map(|axis| axis * 0.3);
                [middle - a - b, middle + a - b, middle + a + b, middle - a + b]
            };
            let cells = [cell(near - along), cell(near + along)];
            let mut partials = Vec::new();
            let mut is_known = true;
            for (k, screen) in (0..).zip(&screens) {
                let verdict = screen.between(&Cells::new([&cells[0], &cells[1]]), 2.0, Undecided::ALL);
                is_known &= verdict.sight != Sight::Blocked && (verdict.sight == Sight::Free || verdict.edges.is_some());
                partials.extend(verdict.edges.map(|open| Partial { screen, name: k, open }));
            }
            let at = |[a, b, c, d]: [DVec3; 4], u: f64, v: f64| a.lerp(b, u).lerp(d.lerp(c, u), v);
            let middles = cells.map(|cell| at(cell, 0.5, 0.5));
            // What is not known of one screen alone is not asked of several.
            if !is_known || partials.len() < 2 {
                continue;
            }
            let fused = fuse(&partials, middles);
            let count: usize = fused.groups.iter().map(|group| group.shadows.len()).sum();
            fewer += usize::from(count < partials.len());
            for _ in 0..40 {
                let mut place = || uniform() + 0.5;
                let segment = cells.map(|cell| at(cell, place(), place()));
                let is_inside = |edges: &Shadow| edges.iter().all(|&edge| passes_inside(edge, segment) == Some(true));
                let is_hidden = partials.iter().any(|partial| is_inside(&partial.edges().collect()));
                let is_in_shadow = fused.groups.iter().flat_map(|group| &group.shadows).any(is_inside);
                assert_eq!(is_hidden, fused.is_all_hidden || is_in_shadow, "{cells:?} {size} {segment:?} {fused:?}");
                inside += usize::from(is_hidden);
            }
        }
        assert!(fewer > 200 && inside > 2000, "{fewer} {inside}");
    }
}
