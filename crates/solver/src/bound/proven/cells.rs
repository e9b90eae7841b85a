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
//! light changes, with the lines that may still be seen against a source from C. Nor does it change by more than from the least to the largest
//! of what T may be. Where something stands on C only the latter counts.
//!
//! **Together.** `|H - P H| <= |p + T(c)| + v + ...` with p the sum of all `Q S` less `P H`, a polynomial on C: its root mean square is that
//! of its coefficients. Means over cells add up by area; the largest value on an element is that on one of its cells.

use std::collections::{BTreeMap, HashMap};

use radgrad_core::DVec3;
use radgrad_scene::{largest, smallest as least};

use super::edges::key;
use super::left::{Effort, Gathered, Kind, Left, Light, Polynomial, Proof, fill};
use super::nodes::{Nodes, ROUNDED};
use super::terms::Target;
use crate::clock::Clock;
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
const DEEPEST_OF_LAMPS: usize = 2;

/// How often it is before it is asked how fast light changes, if it may be cut so often.
const FIRST: usize = 2;

/// Part of the aim that evaluations may be off by.
const EVALUATIONS: f64 = 1e-3;

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
}

/// An element that is cut into cells.
struct Cells<'a> {
    proof: &'a Proof<'a>,
    /// It evaluates as precisely as the aim needs.
    optics: Optics<'a>,
    to: usize,
    sources: &'a [(usize, &'a Sight)],
    /// For each source and channel.
    glows: Vec<Vec<Glow>>,
    bases: &'a Bases,
    /// What is left in each channel that is little, and how often it is cut into four at most.
    aim: &'a [f64],
    deepest: usize,
    clock: Clock,
}

/// Bounds for each channel on what changes over a cell: at most and in the mean.
type Changes = Vec<Left>;

impl Proof<'_> {
    /// What is left out on an element, cell by cell; `held` are the coefficients of the projection, for each channel.
    pub(super) fn in_cells(
        &self,
        to: usize,
        light: &Light<'_>,
        gathered: &Gathered<'_>,
        kinds: &[Kind],
        held: &[Vec<f64>],
    ) -> Option<Vec<Left>> {
        let element = &self.mesh.elements()[to];
        let glow = |source: usize, channel: usize| {
            let coefficients = light.of(self.mesh, source, channel);
            let polynomial = self.polynomial(source, &coefficients);
            Glow { polynomial, range: self.mesh.basis(source).range(&coefficients), coefficients }
        };
        let glows: Vec<Vec<Glow>> =
            gathered.sources.iter().map(|(source, _)| (0..self.channels).map(|c| glow(*source, c)).collect()).collect();
        let bases = &self.bases[usize::from(element.shape() == Shape::Triangle)];
        let Effort { aim, deepest, clock } = self.effort;
        let deepest = if matches!(light, Light::Even(_)) { DEEPEST_OF_LAMPS } else { *deepest };
        let size = |channel: usize| glows.iter().map(|of| of[channel].polynomial.size()).sum::<f64>();
        let enough = aim.iter().enumerate().map(|(channel, aim)| EVALUATIONS * aim / size(channel)).fold(f64::INFINITY, least);
        let raised = |precise: f64| if enough.is_finite() { largest(precise, enough) } else { precise };
        let optics = Optics { absolute: raised(self.optics.absolute), past: raised(self.optics.past), ..self.optics };
        let cells = Cells { proof: self, optics, to, sources: &gathered.sources, glows, bases, aim, deepest, clock: *clock };
        let all = kinds.iter().zip(&gathered.sources).enumerate();
        let open = all
            .filter(|(_, (kind, _))| **kind != Kind::Dark)
            .map(|(index, (kind, (_, sight)))| Open {
                index,
                kind: *kind,
                faces: sight.faces().to_vec(),
                less: vec![0.0; self.channels],
            })
            .collect();
        let known = held.iter().map(|held| {
            let mut known = vec![0.0; bases.highest().len()];
            known.iter_mut().zip(held).for_each(|(known, held)| *known = -held);
            known
        });
        cells.left(element, known.collect(), open, 0).ok()
    }
}

impl Cells<'_> {
    /// What is left out on a cell of what is known, a polynomial for each channel, and of open sources.
    fn left(&self, cell: &Element, mut known: Vec<Vec<f64>>, open: Vec<Open>, depth: usize) -> Result<Vec<Left>, Error> {
        let proof = self.proof;
        let basis = proof.mesh.basis(self.to);
        let places: Vec<[f64; 2]> = basis.nodes().iter().map(|node| node.at).collect();
        let target = &Target::of(cell, &places, proof.nodes_of(self.to));
        let open = if depth == 0 { open } else { self.seen(cell, open) };
        let is_last = depth >= self.deepest || self.clock.is_over();
        let (groups, rest, mut beyond) = self.smooth(target, open, is_last);
        if !groups.is_empty() {
            self.add_smooth(cell, &groups, &mut beyond, &mut known)?;
        }
        let with = |left: Vec<Left>| -> Vec<Left> { left.iter().zip(&beyond.left).map(|(a, b)| a.and(*b)).collect() };
        let by_range = self.by_range(target, &rest);
        let aimed = |changes: &Changes| changes.iter().zip(self.aim).all(|(changes, aim)| changes.mean <= *aim);
        let is_open = !rest.is_empty() && !aimed(&by_range);
        let changes = if is_open && (is_last || depth >= FIRST) { self.by_rates(target, &rest, by_range) } else { by_range };
        if is_last || aimed(&changes) {
            return Ok(with(self.at_centre(cell, known, &rest, &changes)?));
        }
        let mut sums = vec![Left::default(); known.len()];
        let quarters = cell.divided(0, basis)?;
        for (child, quarter) in quarters.iter().enumerate() {
            let below = known.iter().map(|known| self.bases.highest().restrict(child, known)).collect();
            for (sum, left) in sums.iter_mut().zip(self.left(quarter, below, rest.clone(), depth + 1)?) {
                *sum = Left { largest: largest(sum.largest, left.largest), mean: sum.mean + 0.25 * left.mean };
            }
        }
        Ok(with(sums))
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
        let lebesgue = self.bases.0[degree].1;
        // The node of degree 0 is where Taylor's polynomial is.
        let times = if degree == 0 { [1.0; 2] } else { [1.0 + lebesgue, 2.0] };
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
        let near: Vec<usize> = members.iter().copied().filter(|&index| is_last && target.is_near(element(index))).collect();
        let factor = |index: usize| target.reach(element(index)).factor;
        let nearest = members.iter().copied().max_by(|&a, &b| factor(a).total_cmp(&factor(b))).unwrap_or(0);
        let even: Vec<f64> = self.glows[nearest].iter().map(|glow| glow.polynomial.mean()).collect();
        let mean = mean_distance(target.element.shape());
        let size = |of: &[f64]| self.over_aim(of).sum::<f64>();
        let changes = |less: &[f64]| -> f64 {
            let of = |&index: &usize| {
                let source = self.sources[index].0;
                let edges = least(proof.own_by(target, source, mean), 1.0);
                let drift = target.drift(element(index), &target.reach(element(index)), mean);
                let of = |(glow, less): (&Glow, &f64)| {
                    let p = glow.polynomial.less(*less);
                    times(p.size(), edges) + times(p.gradient(), drift)
                };
                size(&self.glows[index].iter().zip(less).map(of).collect::<Vec<f64>>())
            };
            near.iter().map(of).sum()
        };
        let apart = Group { root, members, near: near.clone(), even: None };
        let left = self.beyond(target, &apart, MAX_DEGREE);
        let cost = 2.0 * size(&left) + changes(&vec![0.0; even.len()]);
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

    /// Adds the projection of what sources give.
    fn add_smooth(&self, cell: &Element, groups: &[Group], beyond: &mut Beyond, known: &mut [Vec<f64>]) -> Result<(), Error> {
        let (basis, lebesgue) = &self.bases.0[beyond.degree];
        let mut samples = vec![vec![0.0; basis.nodes().len()]; known.len()];
        let mut errors = vec![0.0; known.len()];
        let all = groups.iter().flat_map(|group| group.members.iter().map(move |index| (*index, group)));
        let taken: Vec<(usize, Vec<Vec<f64>>)> =
            all.filter_map(|(index, group)| Some((index, self.taken(index, group)?))).collect();
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

    /// The same by how fast it changes on the way, where that is less.
    fn by_rates(&self, target: &Target<'_>, open: &[Open], by_range: Changes) -> Changes {
        let (proof, cell) = (self.proof, target.element);
        let elements = proof.mesh.elements();
        if proof.edges.standing(cell.face(), cell.polygon().vertices(), None).is_some() {
            return by_range;
        }
        let (mean, most) = (mean_distance(cell.shape()), largest_distance(cell.shape()));
        let mut sums = vec![Left::default(); proof.channels];
        let disc = (cell.centre(), cell.radius());
        let mut sweep = |segment: [DVec3; 2], jump: &dyn Fn(usize) -> f64| {
            let [u, v] = target.rates(disc, segment);
            let swept = |by: [f64; 2]| if u.is_finite() && v.is_finite() { least(u * by[0] + v * by[1], 1.0) } else { 1.0 };
            let swept = Left { largest: swept(most), mean: swept(mean) };
            for (channel, sum) in sums.iter_mut().enumerate() {
                *sum = sum.and(swept.times(jump(channel)));
            }
        };
        let hidden: Vec<_> = open
            .iter()
            .filter(|open| open.kind == Kind::Cut)
            .map(|open| {
                let ranges: Vec<[f64; 2]> = self.glows[open.index].iter().map(|glow| glow.range).collect();
                (self.sources[open.index].0, &open.faces[..], ranges)
            })
            .collect();
        for (piece, jumps) in proof.jumps(target, &hidden) {
            sweep(piece, &|channel| jumps[channel]);
        }
        // Edges of sources, each once.
        let mut known: BTreeMap<_, Vec<(usize, bool)>> = BTreeMap::new();
        for (place, open) in open.iter().enumerate() {
            let v = elements[self.sources[open.index].0].polygon().vertices();
            for (i, &a) in v.iter().enumerate() {
                let (key, forward) = key([a, v[(i + 1) % v.len()]]);
                known.entry(key).or_default().push((place, forward));
            }
        }
        for (key, sides) in known {
            let of = |place: usize, channel: usize| self.glow(&open[place], channel);
            let in_front = |place: usize| proof.in_front(target, self.sources[open[place].index].0);
            let both = matches!(sides[..], [(a, along), (b, other)] if along != other && in_front(a) && in_front(b));
            let jump = |channel: usize| {
                let alone = sides.iter().map(|side| of(side.0, channel).size()).sum::<f64>();
                if both { least(alone, of(sides[0].0, channel).apart(&of(sides[1].0, channel))) } else { alone }
            };
            sweep(key.map(|bits| DVec3::from(bits.map(f64::from_bits))), &jump);
        }
        for open in open {
            let source = &elements[self.sources[open.index].0];
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

    /// What is left out by what is known, the light of open sources at the centre, and how far it is from that elsewhere.
    fn at_centre(&self, cell: &Element, known: Vec<Vec<f64>>, open: &[Open], changes: &Changes) -> Result<Vec<Left>, Error> {
        let station = Station::on(cell, cell.centre());
        let of = |open: &Open| {
            let sight = if open.kind == Kind::Cut { Sight::Past(open.faces.clone()) } else { Sight::Clear };
            let mut coefficients: Vec<Vec<f64>> = self.glows[open.index].iter().map(|glow| glow.coefficients.clone()).collect();
            coefficients.iter_mut().zip(&open.less).for_each(|(of, less)| of[0] -= less);
            (open.index, sight, coefficients)
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
