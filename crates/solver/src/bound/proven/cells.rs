//! What a projection leaves out, cell by cell of the element.
//!
//! | symbol | meaning |
//! |---|---|
//! | `C`, `c` | a cell of the element that receives, and its centre |
//! | `S`, `T` | irradiance of sources that a polynomial on C, or on a cell around it, stands for, and of all others that C sees |
//! | `P H` | the projection that is judged, a polynomial |
//! | `Q`, `q` | projection from the nodes of a basis on a cell, and what Taylor's polynomial of its degree leaves of S |
//! | `W`, `U` | an element of the coarsest mesh, and the sources in it that are seen as a whole |
//! | `m` | about the radiosity of those of U that are near C |
//! | `v` | bound on `|T(x) - T(c)|` over C |
//!
//! An element is cut into cells, each into four, until little is left. A cell asks again what stands between it and each source:
//! it sees most of them as a whole, or not at all, and of the rest it knows all but a few outlines.
//!
//! **Sources seen as a whole.** `S - Q S = (S - p) - Q (S - p)` for any polynomial p of the degree of Q. Taylor's leaves at most q,
//! and Q does not raise the root mean square of samples: in the mean `|S - Q S| <= 2 q`, anywhere `(1 + L) q`, L the Lebesgue constant
//! of Q. The bounds of module [`super`] on q hold where C is less than a source's distance wide. Where faces meet they do not; but
//!
//! ```text
//! sum over U of B_j = m W - m (W without U) + sum over U of (B_j - m)
//! ```
//!
//! W as if nothing were before it: an edge in the plane of C adds nothing, what W has beyond U is not near C, and near C `B_j - m` is small.
//!
//! **All others.** Along the way from c to x `T` changes by what lines sweep and by the gradient of `B_j`: module [`super`], by how fast
//! light changes, with the lines that may still be seen against a source from C. Across an edge that two sources share the radiosity jumps by
//! no more than Bernstein's coefficients along it differ. Nor does T change by more than from the least to the largest of what it may be.
//! Where something stands on C only the latter counts.
//!
//! **Parts.** To ask what stands in between is most of the work of a cell, and all of v falls with the distance from c. So a cell that is cut
//! no further is cut into parts for T alone, each with its own centre and the outlines of the cell. On a part the sources that are seen
//! as a whole may be far enough away for a polynomial, where they were not on the cell.
//!
//! **What links neglect.** A link's source stands for all leaves below it. Here the leaves are gathered from, or elements above them of
//! which little is neglected: that remains, and comes on top.
//!
//! **Together.** `|H - P H| <= |p + T(c)| + v + ...` with p the sum of all `Q S` less `P H`, a polynomial on C: its root mean square is that
//! of its coefficients. Means over cells add up by area; the largest value on an element is that on one of its cells.

use std::collections::{BTreeMap, HashMap};

use radgrad_core::DVec3;
use radgrad_scene::{largest, smallest as least};

use super::edges::key;
use super::left::{Gathered, Kind, Left, Light, Polynomial, Proof, fill};
use super::nodes::{Nodes, ROUNDED};
use super::terms::Target;
use crate::error::Error;
use crate::links::station::Station;
use crate::links::transfer::Optics;
use crate::mesh::Sight;
use crate::mesh::basis::{Basis, MAX_DEGREE};
use crate::mesh::element::Element;
use crate::mesh::shape::Shape;

/// How often an element is cut into four at most to prove a bound that is asked for.
pub(super) const DEEPEST: usize = 6;

/// The same for the light of lamps.
pub(super) const DEEPEST_OF_LAMPS: usize = 2;

/// How often it is before it is asked how fast light changes, if it may be cut so often.
const FIRST: usize = 2;

/// How often a cell that is cut no further is cut into four for the light of open sources alone.
const PARTS: u32 = 2;

/// The degree of polynomials on parts.
const DEGREE_ON_PARTS: usize = 2;

/// Rounding of Bernstein's coefficients, and of their differences, over the sizes of polynomials.
const SIDES_ROUND: f64 = 1e-13;

/// Part of the aim that evaluations may be off by.
const EVALUATIONS: f64 = 1e-2;

/// Part of the aim that may be left of sources that are seen as a whole.
const PART: f64 = 0.1;

/// How much more than polynomials of the highest degree those of a lower one may leave.
const WORSE: f64 = 1.5;

/// Bases of all degrees of a shape, each with its Lebesgue constant.
#[derive(Debug)]
pub(super) struct Bases(Vec<(Basis, f64)>);

impl Bases {
    pub(super) fn of(shape: Shape) -> Self {
        let of = |degree: usize| {
            let basis = Basis::of_fewest_nodes(shape, degree);
            let lebesgue = Nodes::of(&basis).lebesgue;
            (basis, lebesgue)
        };
        Self((0..=MAX_DEGREE).map(of).collect())
    }

    fn highest(&self) -> &Basis {
        &self.0[MAX_DEGREE].0
    }

    /// What a projection of a degree leaves out over what Taylor's polynomial does, at most and in the mean.
    fn times(&self, degree: usize) -> [f64; 2] {
        // The node of degree 0 is where Taylor's polynomial is.
        if degree == 0 { [1.0; 2] } else { [1.0 + self.0[degree].1, 2.0] }
    }
}

/// A source of which not all is known on a cell.
#[derive(Debug, Clone)]
struct Open {
    /// Its place among all that are gathered.
    index: usize,
    kind: Kind,
    /// The faces that may hide some of it.
    faces: Vec<usize>,
    /// For each channel, the part of its radiosity that polynomials stand for, which is even.
    less: Vec<f64>,
}

/// Sources of a root that a polynomial stands for.
#[derive(Debug)]
struct Group {
    root: usize,
    members: Vec<usize>,
    /// Those of which only what is even counts, if anything does.
    near: Vec<usize>,
    /// For each channel, about what the members near the cell radiate, if the root is taken for a whole.
    even: Option<Vec<f64>>,
}

/// What is known of a source's radiosity in a channel.
#[derive(Debug)]
struct Glow {
    coefficients: Vec<f64>,
    polynomial: Polynomial,
    range: [f64; 2],
    bernstein: Vec<f64>,
}

/// A segment across which the radiosity seen may jump, by so much in each channel.
#[derive(Debug)]
struct Line {
    ends: [DVec3; 2],
    jumps: Vec<f64>,
}

/// An edge of a source, by its place among the source's.
#[derive(Debug, Clone, Copy)]
struct Side<'a> {
    open: &'a Open,
    side: usize,
}

/// An element that is cut into cells.
struct Cells<'a> {
    proof: &'a Proof<'a>,
    /// It evaluates as precisely as the aim needs.
    optics: Optics<'a>,
    to: usize,
    sources: &'a [(usize, Kind, &'a Sight)],
    /// For each source and channel.
    glows: Vec<Vec<Glow>>,
    bases: &'a Bases,
    /// What is left in each channel that is little.
    aim: &'a [f64],
}

/// Bounds for each channel on what changes over a cell: at most and in the mean.
type Changes = Vec<Left>;

impl Proof<'_> {
    /// What is left out on an element, cell by cell, and what is neglected beside, in each channel; `held` are the coefficients of the
    /// projection, and `aim` says what is little.
    pub(super) fn in_cells(
        &self,
        to: usize,
        light: &Light<'_>,
        gathered: &Gathered<'_>,
        kinds: &[Kind],
        held: &[Vec<f64>],
        aim: &[f64],
    ) -> Option<Vec<(Left, f64)>> {
        let element = &self.mesh.elements()[to];
        let (sources, neglected) = self.finer(gathered, kinds, aim);
        let glow = |source: usize, channel: usize| {
            let coefficients = light.of(self.mesh, source, channel);
            let polynomial = self.polynomial(source, &coefficients);
            let basis = self.mesh.basis(source);
            Glow { polynomial, range: basis.range(&coefficients), bernstein: basis.bernstein(&coefficients), coefficients }
        };
        let glows: Vec<Vec<Glow>> =
            sources.iter().map(|(source, _, _)| (0..self.channels).map(|c| glow(*source, c)).collect()).collect();
        let bases = &self.bases[usize::from(element.shape() == Shape::Triangle)];
        let size = |channel: usize| glows.iter().map(|of| of[channel].polynomial.size()).sum::<f64>();
        let enough = aim.iter().enumerate().map(|(channel, aim)| EVALUATIONS * aim / size(channel)).fold(f64::INFINITY, least);
        let raised = |precise: f64| if enough.is_finite() { largest(precise, enough) } else { precise };
        let optics = Optics { absolute: raised(self.optics.absolute), past: raised(self.optics.past), ..self.optics };
        let cells = Cells { proof: self, optics, to, sources: &sources, glows, bases, aim };
        let of = |(index, (_, kind, sight)): (usize, &(usize, Kind, &Sight))| Open {
            index,
            kind: *kind,
            faces: sight.faces().to_vec(),
            less: vec![0.0; self.channels],
        };
        let open = sources.iter().enumerate().map(of).collect();
        let known = held.iter().map(|held| {
            let mut known = vec![0.0; bases.highest().len()];
            known.iter_mut().zip(held).for_each(|(known, held)| *known = -held);
            known
        });
        Some(cells.left(element, known.collect(), open, 0).ok()?.into_iter().zip(neglected).collect())
    }

    /// The sources of which anything is seen, with what they are, each in parts if little is to be neglected; and what still is, in each
    /// channel.
    fn finer<'g>(&self, gathered: &Gathered<'g>, kinds: &[Kind], aim: &[f64]) -> (Vec<(usize, Kind, &'g Sight)>, Vec<f64>) {
        let share = PART / gathered.sources.len() as f64;
        let mut open: Vec<(usize, Kind, &Sight)> =
            gathered.sources.iter().zip(kinds).map(|((source, sight), kind)| (*source, *kind, *sight)).collect();
        let (mut kept, mut neglected) = (Vec::with_capacity(open.len()), vec![0.0; self.channels]);
        while let Some((source, kind, sight)) = open.pop() {
            let of = |channel: usize| (gathered.neglected)(source, kind == Kind::Clear, channel);
            let left: Vec<f64> = (0..self.channels).map(of).collect();
            let is_little = left.iter().zip(aim).all(|(left, aim)| *left <= share * aim);
            match self.mesh.elements()[source].children() {
                _ if kind == Kind::Dark => {}
                Some(first) if !is_little && self.deepest > 0 => {
                    open.extend((first..first + 4).map(|child| (child, kind, sight)));
                }
                _ => {
                    neglected.iter_mut().zip(left).for_each(|(sum, of)| *sum += of);
                    kept.push((source, kind, sight));
                }
            }
        }
        (kept, neglected)
    }
}

impl Cells<'_> {
    /// What is left out on a cell of what is known, a polynomial for each channel, and of open sources.
    fn left(&self, cell: &Element, mut known: Vec<Vec<f64>>, open: Vec<Open>, depth: usize) -> Result<Vec<Left>, Error> {
        let target = &self.proof.target(self.to, cell);
        let open = if depth == 0 { open } else { self.seen(cell, open) };
        let is_last = depth >= self.proof.deepest || self.proof.effort.clock.is_over();
        let (groups, rest, mut beyond) = self.smooth(target, open, is_last);
        if !groups.is_empty() {
            let all = groups.iter().flat_map(|group| group.members.iter().map(move |index| (*index, group)));
            let taken: Vec<(usize, Vec<Vec<f64>>)> =
                all.filter_map(|(index, group)| Some((index, self.taken(index, group)?))).collect();
            self.add_smooth(cell, &taken, &mut beyond, &mut known)?;
        }
        let with = |left: Vec<Left>| -> Vec<Left> { left.iter().zip(&beyond.left).map(|(a, b)| a.and(*b)).collect() };
        if is_last || rest.is_empty() {
            let outlines = self.outlines(target, &rest);
            let cuts = if self.proof.effort.clock.is_over() { 0 } else { self.proof.deepest.min(PARTS as usize) };
            return Ok(with(self.in_parts(cell, known, &rest, &outlines, cuts)?));
        }
        let changes = self.by_range(target, &rest);
        let changes = if depth >= FIRST && !self.is_aimed(&changes) {
            self.by_rates(target, &rest, &self.outlines(target, &rest), changes)
        } else {
            changes
        };
        if self.is_aimed(&changes) {
            return Ok(with(self.at_centre(cell, known, &rest, &changes)?));
        }
        self.in_quarters(cell, &known, |quarter, below| self.left(quarter, below, rest.clone(), depth + 1)).map(with)
    }

    /// Whether so little is left.
    fn is_aimed(&self, changes: &Changes) -> bool {
        changes.iter().zip(self.aim).all(|(changes, aim)| changes.mean <= *aim)
    }

    /// What is left on the quarters of a cell, with what is known on each.
    fn in_quarters(
        &self,
        cell: &Element,
        known: &[Vec<f64>],
        left: impl Fn(&Element, Vec<Vec<f64>>) -> Result<Vec<Left>, Error>,
    ) -> Result<Vec<Left>, Error> {
        let mut sums = vec![Left::default(); known.len()];
        for (child, quarter) in cell.divided(0, self.proof.mesh.basis(self.to))?.iter().enumerate() {
            let below = known.iter().map(|known| self.bases.highest().restrict(child, known)).collect();
            for (sum, left) in sums.iter_mut().zip(left(quarter, below)?) {
                *sum = Left { largest: largest(sum.largest, left.largest), mean: sum.mean + 0.25 * left.mean };
            }
        }
        Ok(sums)
    }

    /// What is left of open sources on a part of a cell, and of what is known; it is cut into four so often, and what may be between is not
    /// asked again: the outlines are those of the cell.
    fn in_parts(
        &self,
        part: &Element,
        known: Vec<Vec<f64>>,
        open: &[Open],
        outlines: &[Line],
        cuts: usize,
    ) -> Result<Vec<Left>, Error> {
        let target = &self.proof.target(self.to, part);
        let changes = self.by_range(target, open);
        let changes = if self.is_aimed(&changes) { changes } else { self.by_rates(target, open, outlines, changes) };
        if self.is_aimed(&changes) {
            return self.at_centre(part, known, open, &changes);
        }
        if cuts > 0 {
            return self.in_quarters(part, &known, |quarter, below| self.in_parts(quarter, below, open, outlines, cuts - 1));
        }
        self.on_part(target, known, open, outlines, &changes)
    }

    /// The same on a part that is cut no further, where sources count by a polynomial if that leaves less than they change by.
    fn on_part(
        &self,
        target: &Target<'_>,
        mut known: Vec<Vec<f64>>,
        open: &[Open],
        outlines: &[Line],
        changes: &Changes,
    ) -> Result<Vec<Left>, Error> {
        let mut beyond = Beyond { degree: DEGREE_ON_PARTS, left: vec![Left::default(); self.proof.channels] };
        let times = self.bases.times(DEGREE_ON_PARTS);
        let is_smooth = |open: &&Open| {
            let Some(left) = self.smooth_on_part(target, open) else { return false };
            beyond
                .left
                .iter_mut()
                .zip(left)
                .for_each(|(sum, of)| *sum = sum.and(Left { largest: times[0] * of, mean: times[1] * of }));
            true
        };
        let (smooth, rest): (Vec<&Open>, Vec<&Open>) = open.iter().partition(is_smooth);
        if smooth.is_empty() {
            return self.at_centre(target.element, known, open, changes);
        }
        let taken: Vec<(usize, Vec<Vec<f64>>)> = smooth.into_iter().map(|open| (open.index, self.coefficients(open))).collect();
        self.add_smooth(target.element, &taken, &mut beyond, &mut known)?;
        let rest: Vec<Open> = rest.into_iter().cloned().collect();
        let changes = self.by_rates(target, &rest, outlines, self.by_range(target, &rest));
        let left = self.at_centre(target.element, known, &rest, &changes)?;
        Ok(left.iter().zip(&beyond.left).map(|(a, b)| a.and(*b)).collect())
    }

    /// What Taylor's polynomial of the degree on parts leaves of a source in each channel, if that is less than what the source changes by.
    fn smooth_on_part(&self, target: &Target<'_>, open: &Open) -> Option<Vec<f64>> {
        let source = self.sources[open.index].0;
        if open.kind != Kind::Clear || !self.proof.in_front(target, source) {
            return None;
        }
        let geometry = Geometry::of(self.proof, target, source, DEGREE_ON_PARTS);
        let left: Vec<f64> = (0..self.proof.channels).map(|channel| geometry.left(&self.glow(open, channel))).collect();
        let size = self.over_aim(&left).sum::<f64>();
        (2.0 * size < self.changes(target, open.index, &open.less)).then_some(left)
    }

    /// About what a source changes by on a part, over what is aimed at, in all channels; `less` is what of its radiosity does not count.
    fn changes(&self, target: &Target<'_>, index: usize, less: &[f64]) -> f64 {
        let (source, mean) = (self.sources[index].0, mean_distance(target.element.shape()));
        let element = &self.proof.mesh.elements()[source];
        let edges = least(self.proof.own_by(target, source, mean), 1.0);
        let drift = target.drift(element, &target.reach(element), mean);
        let of = |(glow, less): (&Glow, &f64)| {
            let p = glow.polynomial.less(*less);
            times(p.size(), edges) + times(p.gradient(), drift)
        };
        let changes: Vec<f64> = self.glows[index].iter().zip(less).map(of).collect();
        self.over_aim(&changes).sum()
    }

    /// The sources that a cell sees anything of.
    fn seen(&self, cell: &Element, open: Vec<Open>) -> Vec<Open> {
        let (proof, from) = (self.proof, cell.polygon().vertices());
        let of = |open: Open| {
            if open.kind == Kind::Clear {
                return Some(open);
            }
            let source = self.sources[open.index].0;
            let (kind, faces) = match proof.mesh.sight_of_part(cell, source, &open.faces) {
                Sight::Nothing(_) => return None,
                Sight::Clear => (Kind::Clear, Vec::new()),
                Sight::Past(faces) => (proof.kind_from(self.to, from, source, &faces), faces),
            };
            (kind != Kind::Dark).then_some(Open { kind, faces, ..open })
        };
        open.into_iter().filter_map(of).collect()
    }

    /// Takes those sources apart that polynomials stand for on a cell, and says what these leave out of them.
    fn smooth(&self, target: &Target<'_>, mut open: Vec<Open>, is_last: bool) -> (Vec<Group>, Vec<Open>, Beyond) {
        let proof = self.proof;
        let mut roots: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for open in open.iter().filter(|open| open.kind == Kind::Clear) {
            let source = self.sources[open.index].0;
            if proof.in_front(target, source) {
                let root = proof.mesh.above(source).last().unwrap_or(source);
                roots.entry(root).or_default().push(open.index);
            }
        }
        let size = |of: &[f64]| self.over_aim(of).fold(0.0, largest);
        let share = PART / roots.len() as f64;
        let mut lowest = vec![0.0; proof.channels];
        let mut groups = Vec::new();
        for (root, members) in roots {
            let (group, left) = self.group(target, root, members, is_last);
            if is_last || size(&left) <= share {
                lowest.iter_mut().zip(&left).for_each(|(sum, of)| *sum += of);
                groups.push(group);
            }
        }
        let all = |degree: usize| {
            let mut sums = vec![0.0; proof.channels];
            for group in &groups {
                sums.iter_mut().zip(self.beyond(target, group, degree)).for_each(|(sum, of)| *sum += of);
                if size(&sums) * if degree == 0 { 0.5 } else { 1.0 } > PART + WORSE * size(&lowest) {
                    return None;
                }
            }
            Some(sums)
        };
        let (degree, q) = (0..MAX_DEGREE).find_map(|d| Some((d, all(d)?))).unwrap_or((MAX_DEGREE, lowest));
        let times = self.bases.times(degree);
        let left = q.iter().map(|q| Left { largest: times[0] * q, mean: times[1] * q }).collect();
        open.retain_mut(|open| {
            let Some(group) = groups.iter().find(|group| group.members.contains(&open.index)) else { return true };
            let is_near = group.near.contains(&open.index);
            if let (true, Some(even)) = (is_near, &group.even) {
                open.less.clone_from(even);
            }
            is_near
        });
        (groups, open, Beyond { degree, left })
    }

    /// The sources of a root as they count for least, those near a cell apart if it is cut no further; and what Taylor's polynomial of the
    /// highest degree leaves of them.
    fn group(&self, target: &Target<'_>, root: usize, members: Vec<usize>, is_last: bool) -> (Group, Vec<f64>) {
        let (proof, elements) = (self.proof, self.proof.mesh.elements());
        let element = |index: usize| &elements[self.sources[index].0];
        let factor = |index: usize| target.reach(element(index)).factor;
        let nearest = members.iter().copied().max_by(|&a, &b| factor(a).total_cmp(&factor(b))).unwrap_or(0);
        let even: Vec<f64> = self.glows[nearest].iter().map(|glow| glow.polynomial.mean()).collect();
        let nothing = vec![0.0; even.len()];
        let size = |of: &[f64]| self.over_aim(of).sum::<f64>();
        // About what a source changes by on parts of the cell.
        let changes = |index: usize, less: &[f64]| self.changes(target, index, less) / f64::from(1 << PARTS);
        let is_near = |&index: &usize| {
            let geometry = Geometry::of(proof, target, self.sources[index].0, MAX_DEGREE);
            let left: Vec<f64> = self.glows[index].iter().map(|glow| geometry.left(&glow.polynomial)).collect();
            target.is_near(element(index)) || 2.0 * size(&left) > least(changes(index, &nothing), changes(index, &even))
        };
        let near: Vec<usize> = members.iter().copied().filter(|index| is_last && is_near(index)).collect();
        let changes = |less: &[f64]| near.iter().map(|&index| changes(index, less)).sum::<f64>();
        let apart = Group { root, members, near: near.clone(), even: None };
        let left = self.beyond(target, &apart, MAX_DEGREE);
        let cost = 2.0 * size(&left) + changes(&nothing);
        if cost <= 1e-2 * PART {
            return (apart, left);
        }
        let together = Group { even: Some(even.clone()), members: apart.members.clone(), near: apart.near.clone(), root };
        let left_together = self.beyond(target, &together, MAX_DEGREE);
        if 2.0 * size(&left_together) + changes(&even) < cost { (together, left_together) } else { (apart, left) }
    }

    /// Errors in each channel over what is aimed at.
    fn over_aim(&self, errors: &[f64]) -> impl Iterator<Item = f64> {
        errors.iter().zip(self.aim).map(|(error, aim)| if *error > 0.0 { error / aim } else { 0.0 })
    }

    /// What Taylor's polynomial of a degree leaves at most of what a polynomial stands for, in each channel.
    fn beyond(&self, target: &Target<'_>, group: &Group, degree: usize) -> Vec<f64> {
        let elements = self.proof.mesh.elements();
        let of_others = if group.even.is_some() {
            let is_member: HashMap<usize, ()> = group.members.iter().map(|&index| (self.sources[index].0, ())).collect();
            let mut others = Vec::new();
            self.without(group.root, &is_member, &mut others);
            let of = |other: usize| Geometry::of(self.proof, target, other, degree).left(&Polynomial::even(1.0));
            let of_root = target.beyond_of_even(elements[group.root].polygon().vertices(), degree);
            of_root + others.into_iter().map(of).sum::<f64>()
        } else {
            0.0
        };
        let m = |channel: usize| group.even.as_ref().map_or(0.0, |even| even[channel]);
        let of_even = |channel: usize| if m(channel) == 0.0 { 0.0 } else { m(channel).abs() * of_others };
        let mut sums: Vec<f64> = (0..self.proof.channels).map(of_even).collect();
        for index in group.members.iter().filter(|index| !group.near.contains(index)) {
            let geometry = Geometry::of(self.proof, target, self.sources[*index].0, degree);
            for (channel, sum) in sums.iter_mut().enumerate() {
                *sum += geometry.left(&self.glows[*index][channel].polynomial.less(m(channel)));
            }
        }
        sums
    }

    /// The elements that make up what an element has beside some members; true if it has any of these.
    fn without(&self, element: usize, members: &HashMap<usize, ()>, others: &mut Vec<usize>) -> bool {
        if members.contains_key(&element) {
            return true;
        }
        let before = others.len();
        let mut has_any = false;
        if let Some(first) = self.proof.mesh.elements()[element].children() {
            for child in first..first + 4 {
                has_any |= self.without(child, members, others);
            }
        }
        if !has_any {
            others.truncate(before);
            others.push(element);
        }
        has_any
    }

    /// Adds the projection of what sources with these coefficients in each channel give.
    fn add_smooth(
        &self,
        cell: &Element,
        taken: &[(usize, Vec<Vec<f64>>)],
        beyond: &mut Beyond,
        known: &mut [Vec<f64>],
    ) -> Result<(), Error> {
        let (basis, lebesgue) = &self.bases.0[beyond.degree];
        let mut samples = vec![vec![0.0; basis.nodes().len()]; known.len()];
        let mut errors = vec![0.0; known.len()];
        for (place, node) in basis.nodes().iter().enumerate().filter(|(_, node)| node.weight != 0.0) {
            let station = Station::on(cell, cell.point(node.at));
            let found = self.gathered(&station, taken.iter().map(|(index, of)| (*index, &Sight::Clear, &of[..])))?;
            for (channel, [sum, error]) in found.into_iter().enumerate() {
                samples[channel][place] = sum;
                errors[channel] = largest(errors[channel], error);
            }
        }
        for (channel, known) in known.iter_mut().enumerate() {
            known.iter_mut().zip(basis.project(&samples[channel])).for_each(|(known, of)| *known += of);
            let error = errors[channel];
            beyond.left[channel] = beyond.left[channel].and(Left { largest: lebesgue * error, mean: error });
        }
        Ok(())
    }

    /// The coefficients of a source for which a polynomial stands, in each channel; `None` if it does for none.
    fn taken(&self, index: usize, group: &Group) -> Option<Vec<Vec<f64>>> {
        if !group.near.contains(&index) {
            return Some(self.glows[index].iter().map(|glow| glow.coefficients.clone()).collect());
        }
        Some(group.even.as_ref()?.iter().map(|even| vec![*even]).collect())
    }

    /// What a point gathers of sources with some coefficients in each channel, and a bound on its error.
    fn gathered<'s>(
        &self,
        station: &Station,
        sources: impl Iterator<Item = (usize, &'s Sight, &'s [Vec<f64>])>,
    ) -> Result<Vec<[f64; 2]>, Error> {
        let mut sums = vec![[0.0; 2]; self.proof.channels];
        for (index, sight, of) in sources {
            let row = self.optics.receive(station, self.sources[index].0, sight, of[0].len())?;
            for ([sum, error], coefficients) in sums.iter_mut().zip(of) {
                let size = row.values.iter().zip(coefficients).map(|(v, c)| (v * c).abs()).sum::<f64>();
                *sum += row.values.iter().zip(coefficients).map(|(v, c)| v * c).sum::<f64>();
                // Sums, and polynomials on cells, round.
                *error += row.error_of(coefficients) + 1e-12 * size;
            }
        }
        Ok(sums)
    }

    /// How far what sources give is from what they give at the centre, whatever is hidden.
    fn by_range(&self, target: &Target<'_>, open: &[Open]) -> Changes {
        let elements = self.proof.mesh.elements();
        let factors: Vec<f64> = open.iter().map(|open| target.reach(&elements[self.sources[open.index].0]).factor).collect();
        let of = |channel: usize| {
            let range = |of: &Open| self.glows[of.index][channel].range.map(|value| value - of.less[channel]);
            let bounds =
                |sign: usize| open.iter().zip(&factors).map(|(of, factor)| (*factor, range(of)[sign])).collect::<Vec<_>>();
            let low = fill(bounds(0).into_iter().map(|(factor, low)| (factor, -low)).collect());
            let all = fill(bounds(1)) + low;
            Left { largest: all, mean: all }
        };
        (0..self.proof.channels).map(of).collect()
    }

    /// The outlines across which what a cell sees of sources may jump.
    fn outlines(&self, target: &Target<'_>, open: &[Open]) -> Vec<Line> {
        let hidden: Vec<_> = open
            .iter()
            .filter(|open| open.kind == Kind::Cut)
            .map(|open| {
                let ranges: Vec<[f64; 2]> = self.glows[open.index].iter().map(|glow| glow.range).collect();
                (self.sources[open.index].0, &open.faces[..], ranges)
            })
            .collect();
        self.proof.jumps(target, &hidden).into_iter().map(|(ends, jumps)| Line { ends, jumps }).collect()
    }

    /// The edges of sources, each once.
    fn edges(&self, target: &Target<'_>, open: &[Open]) -> Vec<Line> {
        let (proof, elements) = (self.proof, self.proof.mesh.elements());
        let mut known: BTreeMap<_, Vec<(Side<'_>, bool)>> = BTreeMap::new();
        for open in open {
            let v = elements[self.sources[open.index].0].polygon().vertices();
            for (side, &a) in v.iter().enumerate() {
                let (key, forward) = key([a, v[(side + 1) % v.len()]]);
                known.entry(key).or_default().push((Side { open, side }, forward));
            }
        }
        let line = |(key, sides): (_, Vec<(Side<'_>, bool)>)| {
            let in_front = |of: &Side<'_>| proof.in_front(target, self.sources[of.open.index].0);
            let jump = |channel: usize| {
                let alone = sides.iter().map(|(of, _)| self.glow(of.open, channel).size()).sum::<f64>();
                match &sides[..] {
                    [(a, along), (b, other)] if along != other && in_front(a) && in_front(b) => {
                        least(alone, self.apart([*a, *b], channel))
                    }
                    _ => alone,
                }
            };
            let ends = <[[u64; 3]; 2]>::map(key, |bits| DVec3::from(bits.map(f64::from_bits)));
            Line { ends, jumps: (0..proof.channels).map(jump).collect() }
        };
        known.into_iter().map(line).collect()
    }

    /// How much the radiosities of two sources differ at most where they share an edge, along which they run in opposite ways.
    fn apart(&self, [a, b]: [Side<'_>; 2], channel: usize) -> f64 {
        let values = |of: Side<'_>| -> Vec<f64> {
            let bernstein = &self.glows[of.open.index][channel].bernstein;
            let nodes = self.proof.nodes_of(self.sources[of.open.index].0);
            nodes.along_side(of.side, bernstein).map(|b| b - of.open.less[channel]).collect()
        };
        let (of_a, of_b) = (values(a), values(b));
        let most = of_a.iter().zip(of_b.iter().rev()).map(|(a, b)| (a - b).abs()).fold(0.0, largest);
        most + SIDES_ROUND * (self.glow(a.open, channel).size() + self.glow(b.open, channel).size())
    }

    /// How far what sources give is from what they give at the centre of a part of a cell with these outlines, by how fast it changes on the
    /// way; or `by_range` where that is less.
    fn by_rates(&self, target: &Target<'_>, open: &[Open], outlines: &[Line], by_range: Changes) -> Changes {
        let (proof, part) = (self.proof, target.element);
        if proof.edges.standing(part.face(), part.polygon().vertices(), None).is_some() {
            return by_range;
        }
        let (mean, most) = (mean_distance(part.shape()), largest_distance(part.shape()));
        let mut sums = vec![Left::default(); proof.channels];
        let disc = (part.centre(), part.radius());
        for line in outlines.iter().chain(&self.edges(target, open)) {
            let [u, v] = target.rates(disc, line.ends);
            let swept = |by: [f64; 2]| if u.is_finite() && v.is_finite() { least(u * by[0] + v * by[1], 1.0) } else { 1.0 };
            let swept = Left { largest: swept(most), mean: swept(mean) };
            for (sum, jump) in sums.iter_mut().zip(&line.jumps) {
                *sum = sum.and(swept.times(*jump));
            }
        }
        for open in open {
            let source = &proof.mesh.elements()[self.sources[open.index].0];
            let reach = target.reach(source);
            let drift = Left { largest: target.drift(source, &reach, most), mean: target.drift(source, &reach, mean) };
            for (sum, glow) in sums.iter_mut().zip(&self.glows[open.index]) {
                if glow.polynomial.gradient() > 0.0 {
                    *sum = sum.and(drift.times(glow.polynomial.gradient()));
                }
            }
        }
        sums.into_iter().zip(by_range).map(|(a, b)| a.lesser(b)).collect()
    }

    /// What counts of a source.
    fn glow(&self, open: &Open, channel: usize) -> Polynomial {
        self.glows[open.index][channel].polynomial.less(open.less[channel])
    }

    /// Its coefficients in each channel.
    fn coefficients(&self, open: &Open) -> Vec<Vec<f64>> {
        let mut coefficients: Vec<Vec<f64>> = self.glows[open.index].iter().map(|glow| glow.coefficients.clone()).collect();
        coefficients.iter_mut().zip(&open.less).for_each(|(of, less)| of[0] -= less);
        coefficients
    }

    /// What is left out by what is known, the light of open sources at the centre, and how far it is from that elsewhere.
    fn at_centre(&self, cell: &Element, known: Vec<Vec<f64>>, open: &[Open], changes: &Changes) -> Result<Vec<Left>, Error> {
        let station = Station::on(cell, cell.centre());
        let of = |open: &Open| {
            let sight = if open.kind == Kind::Cut { Sight::Past(open.faces.clone()) } else { Sight::Clear };
            (open.index, sight, self.coefficients(open))
        };
        let open: Vec<(usize, Sight, Vec<Vec<f64>>)> = open.iter().map(of).collect();
        let here = self.gathered(&station, open.iter().map(|(index, sight, of)| (*index, sight, &of[..])))?;
        let of = |((mut known, [value, error]), changes): ((Vec<f64>, [f64; 2]), &Left)| {
            known[0] += value;
            let rms = known.iter().map(|c| c * c).sum::<f64>().sqrt();
            let most = self.bases.highest().magnitude(&known);
            changes.and(Left { largest: most + error, mean: rms + error })
        };
        Ok(known.into_iter().zip(here).zip(changes).map(of).collect())
    }
}

/// Their product; 0 if the first is, whatever the second.
fn times(value: f64, of: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value * of }
}

/// Means over a shape of the distances from its centre in reference coordinates.
const fn mean_distance(shape: Shape) -> [f64; 2] {
    match shape {
        Shape::Parallelogram => [0.25; 2],
        Shape::Triangle => [16.0 / 81.0; 2],
    }
}

/// The largest ones.
const fn largest_distance(shape: Shape) -> [f64; 2] {
    match shape {
        Shape::Parallelogram => [0.5; 2],
        Shape::Triangle => [2.0 / 3.0; 2],
    }
}

/// What polynomials leave out of the sources that they stand for.
#[derive(Debug, Default)]
struct Beyond {
    degree: usize,
    left: Vec<Left>,
}

/// What Taylor's polynomial leaves of a source that is seen as a whole.
struct Geometry {
    /// For an even radiosity of 1, and for any of at most 1.
    even: f64,
    any: f64,
    /// For any of at most 1, at most, and by its edges; and for a gradient of 1.
    most: f64,
    edges: f64,
    drift: f64,
}

impl Geometry {
    fn of(proof: &Proof<'_>, target: &Target<'_>, source: usize, degree: usize) -> Self {
        let of = &proof.mesh.elements()[source];
        let reach = target.reach(of);
        let (even, any) = (target.beyond_of_even(of.polygon().vertices(), degree), target.beyond_of_any(of, degree));
        let is_near = even.is_infinite() || any.is_infinite();
        let by = [2.0 / 3.0; 2];
        let [edges, drift] =
            if is_near { [proof.own_by(target, source, by), target.drift(of, &reach, by)] } else { [f64::INFINITY; 2] };
        Self { even, any, most: reach.factor, edges, drift }
    }

    fn left(&self, p: &Polynomial) -> f64 {
        let smooth = times(p.mean().abs(), self.even) + times(p.rest(), self.any);
        let changes = times(p.size(), self.edges) + times(p.gradient(), self.drift);
        least(least(smooth, times(p.size(), self.any)), least(changes, times(p.size(), self.most))) * ROUNDED
    }
}
