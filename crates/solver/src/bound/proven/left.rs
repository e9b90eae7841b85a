//! What the projection of received light on an element's basis leaves out, bounded at every place of it and in the mean.

use std::collections::HashMap;

use radgrad_core::DVec3;
use radgrad_scene::{largest, smallest as least};

use super::edges::{Edges, key};
use super::finely::Finely;
use super::nodes::{Nodes, ROUNDED};
use super::terms::{Reach, Target};
use crate::field::Field;
use crate::links::transfer::Optics;
use crate::links::visible::{Visible, Window};
use crate::mesh::element::Element;
use crate::mesh::screen::LEVEL;
use crate::mesh::shape::Shape;
use crate::mesh::{Mesh, Sight};

/// Pieces of an outline, each of which may have something else behind it, by how long it is as seen from the element.
const PIECE: f64 = 0.4;
const MOST_PIECES: f64 = 8.0;

/// Faces before a source beyond which it is not asked whether an outline of theirs is between.
const MOST_FACES: usize = 24;

/// The same summed over all sources, beyond which it is not asked how fast light changes.
const MOST_IN_ALL: usize = 1500;

/// Cuts of an element by faces that stand on it, beyond which its parts are not asked one by one.
const MOST_CUTS: usize = 3;

/// The scene and its geometry, as the proof uses them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Proof<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) edges: &'a Edges,
    pub(super) nodes: &'a [Nodes; 2],
    pub(super) optics: Optics<'a>,
    pub(super) channels: usize,
}

/// A piecewise polynomial radiosity.
#[derive(Debug, Clone, Copy)]
pub(super) enum Light<'a> {
    /// On all elements, less a number for each channel where these are given.
    Field(&'a Field, &'a [f64]),
    /// Even, by faces: that of lamps.
    Even(&'a [Vec<f64>]),
}

/// The residual of a projection: its largest magnitude and its mean.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Left {
    pub(super) largest: f64,
    pub(super) mean: f64,
}

/// What an element gathers from, and what its nodes get of it.
pub(super) struct Gathered<'a> {
    pub(super) sources: Vec<(usize, &'a Sight)>,
    /// What a node gets of a source with some coefficients.
    pub(super) value: &'a dyn Fn(usize, usize, &[f64]) -> f64,
    /// Bound on the errors of form factors in that.
    pub(super) error: f64,
    /// Whether these are all that is seen in any direction.
    pub(super) all: bool,
}

/// A source, or an element above some, with the part of its polynomial that the element above it has not.
struct Part {
    element: usize,
    /// Whether nothing is before it.
    clear: bool,
    is_root: bool,
    reach: Reach,
    /// For each channel.
    polynomials: Vec<Polynomial>,
    taken: Taken,
}

/// What an element sees of a source.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Kind {
    /// Nothing.
    Dark,
    /// All, but for a part below the horizon or behind the source's plane.
    Clear,
    /// Something may be before a part of it.
    Cut,
}

/// Which bound a part counts by.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Taken {
    /// Taylor's polynomial.
    Smooth,
    /// How fast it changes.
    Slow,
    /// Its largest value.
    Most,
}

/// Bounds on a polynomial: on its mean's magnitude, its own, its difference from the mean, and its gradient.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Polynomial {
    mean: f64,
    size: f64,
    rest: f64,
    gradient: f64,
}

impl Light<'_> {
    /// Coefficients on an element.
    pub(super) fn of(&self, mesh: &Mesh, element: usize, channel: usize) -> Vec<f64> {
        let len = mesh.basis(element).len();
        match self {
            Self::Field(field, less) => {
                let mut of = field.of(element, channel, len).to_vec();
                of[0] -= less.get(channel).copied().unwrap_or(0.0);
                of
            }
            Self::Even(emitted) => {
                let mut even = vec![0.0; len];
                even[0] = emitted[mesh.elements()[element].face()][channel];
                even
            }
        }
    }

    /// What an element has beyond the polynomial of the one above it.
    fn beyond_parent(&self, mesh: &Mesh, element: usize, channel: usize) -> Vec<f64> {
        let mut of = self.of(mesh, element, channel);
        if let (Self::Field(..), Some(parent)) = (self, mesh.elements()[element].parent()) {
            let above = mesh.basis(element).restrict(mesh.child(element), &self.of(mesh, parent, channel));
            of.iter_mut().zip(above).for_each(|(c, above)| *c -= above);
        }
        of
    }
}

impl Proof<'_> {
    pub(super) fn nodes_of(&self, element: usize) -> &Nodes {
        &self.nodes[usize::from(self.mesh.elements()[element].shape() == Shape::Triangle)]
    }

    pub(super) fn polynomial(&self, element: usize, coefficients: &[f64]) -> Polynomial {
        let (basis, geometry) = (self.mesh.basis(element), &self.mesh.elements()[element]);
        let bernstein = basis.bernstein(coefficients);
        let off = |from: f64| bernstein.iter().fold(0.0, |most, b| largest(most, (b - from).abs()));
        let [s, t] = self.nodes_of(element).slopes(&bernstein);
        let gradient = s * geometry.gradient([1.0, 0.0]).length() + t * geometry.gradient([0.0, 1.0]).length();
        // Sums round.
        let rounding = 1e-14 * off(0.0);
        Polynomial {
            mean: coefficients[0],
            size: off(0.0) + rounding,
            rest: off(coefficients[0]) + rounding,
            gradient: gradient * ROUNDED,
        }
    }

    /// How an element sees a source past some faces, each solid of them by itself: a solid without an outline between the two
    /// hides all of the source from all of the element or nothing, as sight changes only across outlines.
    pub(super) fn kind(&self, to: usize, source: usize, faces: &[usize]) -> Kind {
        if faces.len() > MOST_FACES {
            return Kind::Cut;
        }
        let mut left: Vec<usize> = faces.to_vec();
        let mut kind = Kind::Clear;
        while let Some(&first) = left.first() {
            let solid = self.edges.solid(first);
            let (of_solid, others) = left.into_iter().partition(|&face| self.edges.solid(face) == solid);
            left = others;
            match self.hides(to, self.mesh.elements()[to].polygon().vertices(), source, &of_solid, MOST_CUTS) {
                Some(true) => return Kind::Dark,
                Some(false) => {}
                None => kind = Kind::Cut,
            }
        }
        kind
    }

    /// Whether some faces hide all of a source from all of a part of an element (`true`), or nothing of it; `None` if neither is
    /// sure. Where one of them stands on that part, the pieces on its two sides are asked, and must agree.
    fn hides(&self, to: usize, from: &[DVec3], source: usize, faces: &Vec<usize>, cuts: usize) -> Option<bool> {
        let (element, of_source) = (&self.mesh.elements()[to], &self.mesh.elements()[source]);
        if let Some(face) = self.edges.standing(element.face(), from, Some(faces)) {
            let rest = cuts.checked_sub(1)?;
            let of_side = |sign: f64| self.hides(to, &self.edges.beside(face, sign, from), source, faces, rest);
            return of_side(1.0).filter(|of| of_side(-1.0) == Some(*of));
        }
        let normal = element.polygon().normal();
        let crossing = self.edges.of_face(of_source.face()).iter().filter(|&&line| self.edges.crosses(line));
        let mut lines = faces.iter().flat_map(|&face| self.edges.of_face(face)).chain(crossing);
        let is_cut = lines.any(|&line| {
            let ends = self.edges.all[line].ends;
            ends.iter().any(|&end| normal.dot(end - element.centre()) > 0.0)
                && self.edges.outlined_from(line, from).iter().any(|from| in_beam(from, of_source, ends))
        });
        if is_cut || from.is_empty() {
            return None;
        }
        let middle = from.iter().sum::<DVec3>() / from.len() as f64;
        let (window, shape) = (Window::of(of_source), of_source.shape());
        let convex = faces.iter().flat_map(|&face| self.mesh.convex_parts(face)).map(|part| &part[..]);
        let [free, past] =
            [Visible::of(middle, normal, &window, std::iter::empty())?, Visible::of(middle, normal, &window, convex)?];
        let [[least, _], [seen, most]] = [free, past].map(|of| [of.share(shape) - 2.0 * of.doubt, of.share(shape)]);
        // Some of it is surely hidden, or surely seen.
        if most < 0.5 * least { Some(true) } else { (seen > 0.0).then_some(false) }
    }

    /// What each source is to an element.
    fn kinds(&self, to: usize, gathered: &Gathered<'_>) -> Vec<Kind> {
        let of = |&(source, sight): &(usize, &Sight)| match sight {
            Sight::Clear => Kind::Clear,
            Sight::Nothing(_) => Kind::Dark,
            Sight::Past(faces) => self.kind(to, source, faces),
        };
        gathered.sources.iter().map(of).collect()
    }

    /// The residual of the light that an element gathers, in each channel, and bounds on the form factors of all sources from
    /// anywhere on it.
    pub(super) fn left(&self, to: usize, light: &Light<'_>, gathered: &Gathered<'_>) -> (Vec<Left>, Vec<f64>) {
        let (mesh, channels) = (self.mesh, self.channels);
        let (element, basis) = (&mesh.elements()[to], mesh.basis(to));
        let places: Vec<[f64; 2]> = basis.nodes().iter().map(|node| node.at).collect();
        let target = Target::of(element, &places, self.nodes_of(to));
        let kinds = self.kinds(to, gathered);
        let less: Vec<f64> = (0..channels).map(|channel| self.seen(to, light, gathered, channel)).collect();
        let light = &match light {
            // Where form factors sum to 1 a constant may be subtracted: every place gathers the same of it.
            Light::Field(field, _) if gathered.all => Light::Field(field, &less),
            other => *other,
        };
        let alone = |index: usize| -> f64 {
            let source = gathered.sources[index].0;
            (0..channels).map(|channel| self.alone(&target, to, source, &light.of(mesh, source, channel)).mean).sum()
        };
        let finely = self.finely(to, &target, light, gathered, &kinds, &alone);
        let (mut parts, hides_by_contact) = self.parts(&target, light, &gathered.sources, &kinds);
        let seams = self.choose(&target, &mut parts, basis.degree());

        // The light of the slow parts at the nodes, and their ranges on the sources.
        let places: HashMap<usize, usize> = parts.iter().enumerate().map(|(place, part)| (part.element, place)).collect();
        let mut at_nodes = vec![vec![0.0; basis.nodes().len()]; channels];
        let mut ranges: Vec<Vec<[f64; 2]>> = Vec::with_capacity(gathered.sources.len());
        for (index, &(source, _)) in gathered.sources.iter().enumerate() {
            let path: Vec<usize> = mesh.above(source).collect();
            let mut of_source = Vec::with_capacity(channels);
            for (channel, at_nodes) in at_nodes.iter_mut().enumerate() {
                let mut slow = light.of(mesh, source, channel);
                let is_other = |at: &usize| places.get(at).is_some_and(|&place| parts[place].taken != Taken::Slow);
                if path.iter().any(is_other) {
                    let mut others = vec![0.0; slow.len()];
                    for &at in path.iter().rev() {
                        if at != path[path.len() - 1] {
                            others = mesh.basis(at).restrict(mesh.child(at), &others);
                        }
                        if is_other(&at) {
                            others.iter_mut().zip(light.beyond_parent(mesh, at, channel)).for_each(|(sum, c)| *sum += c);
                        }
                    }
                    slow.iter_mut().zip(others).for_each(|(c, other)| *c -= other);
                }
                if slow.iter().any(|c| *c != 0.0) {
                    at_nodes.iter_mut().enumerate().for_each(|(node, sum)| *sum += (gathered.value)(index, node, &slow));
                }
                of_source.push(mesh.basis(source).range(&slow));
            }
            ranges.push(of_source);
        }
        let before: usize = gathered.sources.iter().map(|(_, sight)| sight.faces().len()).sum();
        let jumps = if before > MOST_IN_ALL { Vec::new() } else { self.jumps(to, &target, &gathered.sources, &kinds, &ranges) };
        let crossed = before > MOST_IN_ALL
            || hides_by_contact
            || self.edges.standing(element.face(), element.polygon().vertices(), None).is_some();

        let of_channel = |channel: usize| {
            let mut left = Left::default();
            for part in &parts {
                let p = &part.polynomials[channel];
                match part.taken {
                    Taken::Smooth => {
                        let beyond = self.smooth(&target, part.element, p, basis.degree());
                        left.largest += (1.0 + target.nodes.lebesgue) * beyond;
                        left.mean += 2.0 * beyond;
                    }
                    Taken::Most => {
                        left.largest += (1.0 + target.nodes.lebesgue) * p.size * part.reach.factor;
                        left.mean += 2.0 * p.size * part.reach.factor;
                    }
                    Taken::Slow => {
                        let source = &mesh.elements()[part.element];
                        if p.gradient > 0.0 {
                            left.largest += p.gradient * target.drift(source, &part.reach, target.most);
                            left.mean += p.gradient * target.drift(source, &part.reach, target.mean);
                        }
                        if !part.is_root && p.size > 0.0 {
                            let [most, mean] = self.own(&target, part.element);
                            left.largest += p.size * most;
                            left.mean += p.size * mean;
                        }
                    }
                }
            }
            let slow = basis.project(&at_nodes[channel]);
            let slopes = target.nodes.slopes(&basis.bernstein(&slow));
            let (mut most, mut mean) = (0.0, 0.0);
            for (near, disc) in target.nodes.near.iter().zip(&target.discs) {
                let held: f64 = basis.at_node(near.node).iter().zip(&slow).map(|(f, c)| f * c).sum();
                let here = (at_nodes[channel][near.node] - held).abs();
                let varies = |by: [f64; 2]| slopes[0] * by[0] + slopes[1] * by[1];
                let (mut at_most, mut in_mean) = (here + varies(near.most), here + varies(near.mean));
                let mut add = |segment: [DVec3; 2], jump: f64| {
                    if jump > 0.0 {
                        let [u, v] = target.rates(*disc, segment);
                        let swept =
                            |by: [f64; 2]| if u.is_finite() && v.is_finite() { least(u * by[0] + v * by[1], 1.0) } else { 1.0 };
                        at_most += jump * swept(near.most);
                        in_mean += jump * swept(near.mean);
                    }
                };
                seams.iter().for_each(|(segment, jumps)| add(*segment, jumps[channel]));
                jumps.iter().for_each(|(segment, jumps)| add(*segment, jumps[channel]));
                most = largest(most, at_most);
                mean += near.share * in_mean;
            }
            let by_rates = Left { largest: left.largest + most, mean: left.mean + mean };
            let simply = self.simply(to, &target, light, gathered, channel);
            let lesser = |a: Left, b: Left| Left { largest: least(a.largest, b.largest), mean: least(a.mean, b.mean) };
            let mut both = lesser(simply, self.by_sources(to, &target, light, gathered, (&kinds, &finely), channel));
            if !crossed {
                both = lesser(both, by_rates);
            }
            Left { largest: both.largest * ROUNDED, mean: least(both.mean, both.largest) * ROUNDED }
        };
        let left = (0..channels).map(of_channel).collect();
        (left, kinds.iter().enumerate().map(|(index, kind)| self.factor(&target, gathered, index, *kind)).collect())
    }

    /// About what an element sees in the mean.
    fn seen(&self, to: usize, light: &Light<'_>, gathered: &Gathered<'_>, channel: usize) -> f64 {
        let (mut sum, mut factors) = (0.0, 0.0);
        for (index, &(source, _)) in gathered.sources.iter().enumerate() {
            let mean = light.of(self.mesh, source, channel)[0];
            let mut unit = vec![0.0; self.mesh.basis(source).len()];
            unit[0] = 1.0;
            let nodes = self.mesh.basis(to).nodes().len();
            let factor: f64 = (0..nodes).map(|node| (gathered.value)(index, node, &unit)).sum();
            (sum, factors) = (sum + factor * mean, factors + factor);
        }
        if factors > 0.0 { sum / factors } else { 0.0 }
    }

    /// A bound on the form factor of a source from anywhere on an element: no more than at the nearest node and what it changes by from
    /// there.
    fn factor(&self, target: &Target<'_>, gathered: &Gathered<'_>, index: usize, kind: Kind) -> f64 {
        let source = gathered.sources[index].0;
        let simply = target.reach(&self.mesh.elements()[source]).factor;
        match kind {
            Kind::Dark => 0.0,
            Kind::Cut => simply,
            Kind::Clear => {
                let mut unit = vec![0.0; self.mesh.basis(source).len()];
                unit[0] = 1.0;
                let near = target.nodes.near.iter().zip(&target.discs);
                let around = near
                    .map(|(near, disc)| (gathered.value)(index, near.node, &unit) + self.swept(target, *disc, source, near.most));
                least(simply, (around.fold(0.0, largest) + gathered.error) * ROUNDED)
            }
        }
    }

    /// The sources and the elements above them, and whether some are left out that something on their face hides.
    fn parts(&self, target: &Target<'_>, light: &Light<'_>, sources: &[(usize, &Sight)], kinds: &[Kind]) -> (Vec<Part>, bool) {
        let mesh = self.mesh;
        let mut by_contact = false;
        // Of each element whether all that is seen of it is in the clear.
        let mut clear: HashMap<usize, bool> = HashMap::new();
        let mut order: Vec<usize> = Vec::new();
        for (&(source, _), kind) in sources.iter().zip(kinds) {
            let is_clear = *kind == Kind::Clear;
            for at in mesh.above(source) {
                match clear.entry(at) {
                    std::collections::hash_map::Entry::Occupied(mut known) => {
                        if is_clear || !*known.get() {
                            break;
                        }
                        known.insert(false);
                    }
                    std::collections::hash_map::Entry::Vacant(free) => {
                        free.insert(is_clear);
                        order.push(at);
                    }
                }
            }
        }
        let is_source: HashMap<usize, ()> = sources.iter().map(|&(source, _)| (source, ())).collect();
        // Parts of which nothing is known are hidden, or below the horizon.
        let below = |element: usize| {
            let reach = target.element.radius() + (mesh.elements()[element].centre() - target.element.centre()).length();
            mesh.elements()[element].polygon().vertices().iter().all(|&v| target.height(v) <= LEVEL * reach)
        };
        let known: Vec<usize> = order.clone();
        for at in known {
            if is_source.contains_key(&at) {
                continue;
            }
            let Some(first) = mesh.elements()[at].children() else { continue };
            if (first..first + 4).any(|child| !clear.contains_key(&child) && !below(child)) {
                // Where a face stands on another, a hidden part may end with an element.
                by_contact |= self.edges.has_feet(mesh.elements()[at].face());
                for above in mesh.above(at) {
                    clear.insert(above, false);
                }
            }
        }
        order.sort_unstable();
        let of = |element: usize| {
            let source = &mesh.elements()[element];
            Part {
                element,
                clear: clear[&element],
                is_root: source.parent().is_none(),
                reach: target.reach(source),
                polynomials: (0..self.channels)
                    .map(|channel| self.polynomial(element, &light.beyond_parent(mesh, element, channel)))
                    .collect(),
                taken: Taken::Slow,
            }
        };
        (order.into_iter().map(of).collect(), by_contact)
    }

    /// What Taylor's polynomial leaves of what a part gives.
    pub(super) fn smooth(&self, target: &Target<'_>, source: usize, p: &Polynomial, degree: usize) -> f64 {
        let source = &self.mesh.elements()[source];
        let mut sum = 0.0;
        if p.mean != 0.0 {
            sum += p.mean.abs() * target.beyond_of_even(source.polygon().vertices(), degree);
        }
        if p.rest > 0.0 {
            sum += p.rest * target.beyond_of_any(source, degree);
        }
        sum
    }

    /// How much what a part gives changes by its own boundary, for a radiosity of 1: at most and in the mean.
    fn own(&self, target: &Target<'_>, source: usize) -> [f64; 2] {
        [target.most, target.mean].map(|by| self.own_by(target, source, by))
    }

    fn own_by(&self, target: &Target<'_>, source: usize, by: [f64; 2]) -> f64 {
        self.swept(target, (target.element.centre(), target.element.radius()), source, by)
    }

    /// How much the form factor of a source that is wholly seen changes by its edges between places of a disc that are so far apart.
    fn swept(&self, target: &Target<'_>, disc: (DVec3, f64), source: usize, by: [f64; 2]) -> f64 {
        let vertices = self.mesh.elements()[source].polygon().vertices();
        let swept = |i: usize| {
            let [u, v] = target.rates(disc, [vertices[i], vertices[(i + 1) % vertices.len()]]);
            if u.is_finite() && v.is_finite() { least(u * by[0] + v * by[1], 1.0) } else { 1.0 }
        };
        (0..vertices.len()).map(swept).sum()
    }

    /// Decides which bound each part counts by; returns the edges of the coarsest parts that count by how fast they change, with
    /// the jump across each in each channel.
    fn choose(&self, target: &Target<'_>, parts: &mut [Part], degree: usize) -> Vec<([DVec3; 2], Vec<f64>)> {
        let sum = |of: &dyn Fn(&Polynomial) -> f64, part: &Part| part.polynomials.iter().map(of).sum::<f64>();
        for part in &mut *parts {
            let source = &self.mesh.elements()[part.element];
            let drift = sum(&|p| p.gradient, part);
            let drift = if drift > 0.0 { drift * target.drift(source, &part.reach, target.mean) } else { 0.0 };
            let slow = sum(&|p| p.size, part) * self.own(target, part.element)[1] + drift;
            let most = 2.0 * sum(&|p| p.size, part) * part.reach.factor;
            let smooth = if part.clear && self.in_front(target, part.element) {
                2.0 * sum(&|p| self.smooth(target, part.element, p, degree), part)
            } else {
                f64::INFINITY
            };
            part.taken = if smooth <= slow && smooth <= most {
                Taken::Smooth
            } else if slow <= most || part.is_root {
                Taken::Slow
            } else {
                Taken::Most
            };
        }
        // The coarsest parts together may have no jumps between them.
        let cost = |parts: &[Part], seams: &[([DVec3; 2], Vec<f64>)]| {
            let of_part = |part: &Part| match part.taken {
                Taken::Smooth => 2.0 * sum(&|p| self.smooth(target, part.element, p, degree), part),
                Taken::Most => 2.0 * sum(&|p| p.size, part) * part.reach.factor,
                Taken::Slow => {
                    let gradient = sum(&|p| p.gradient, part);
                    let source = &self.mesh.elements()[part.element];
                    if gradient > 0.0 { gradient * target.drift(source, &part.reach, target.mean) } else { 0.0 }
                }
            };
            let of_seam = |(segment, jumps): &([DVec3; 2], Vec<f64>)| {
                let jump: f64 = jumps.iter().sum();
                if jump == 0.0 {
                    return 0.0;
                }
                let of_disc = |(near, disc): (&super::nodes::Near, &(DVec3, f64))| {
                    let [u, v] = target.rates(*disc, *segment);
                    let by = near.mean;
                    near.share * if u.is_finite() && v.is_finite() { least(u * by[0] + v * by[1], 1.0) } else { 1.0 }
                };
                jump * target.nodes.near.iter().zip(&target.discs).map(of_disc).sum::<f64>()
            };
            parts.iter().filter(|part| part.is_root).map(of_part).sum::<f64>() + seams.iter().map(of_seam).sum::<f64>()
        };
        let seams = self.seams(target, parts);
        if parts.iter().any(|part| part.is_root && part.taken == Taken::Smooth) {
            let before: Vec<Taken> = parts.iter().map(|part| part.taken).collect();
            let apart = cost(parts, &seams);
            parts.iter_mut().filter(|part| part.is_root).for_each(|part| part.taken = Taken::Slow);
            let together = self.seams(target, parts);
            if cost(parts, &together) < apart {
                return together;
            }
            parts.iter_mut().zip(before).for_each(|(part, taken)| part.taken = taken);
        }
        seams
    }

    /// The edges of the coarsest parts that change slowly, and the jump of their polynomials across each.
    fn seams(&self, target: &Target<'_>, parts: &[Part]) -> Vec<([DVec3; 2], Vec<f64>)> {
        let mut known: HashMap<_, Vec<(usize, bool)>> = HashMap::new();
        let mut order = Vec::new();
        for (place, part) in parts.iter().enumerate().filter(|(_, part)| part.is_root && part.taken == Taken::Slow) {
            let v = self.mesh.elements()[part.element].polygon().vertices();
            for (i, &a) in v.iter().enumerate() {
                let ends = [a, v[(i + 1) % v.len()]];
                let (key, forward) = key(ends);
                let of = known.entry(key).or_default();
                if of.is_empty() {
                    order.push((key, ends));
                }
                of.push((place, forward));
            }
        }
        let in_front = |place: usize| self.in_front(target, parts[place].element);
        let of_edge = |(key, ends): &(_, [DVec3; 2])| {
            let sides: &[(usize, bool)] = &known[key];
            let alone = |channel: usize| sides.iter().map(|side| parts[side.0].polynomials[channel].size).sum::<f64>();
            let jump = |channel: usize| match *sides {
                [(a, along), (b, other)] if along != other && in_front(a) && in_front(b) => {
                    let (a, b) = (&parts[a].polynomials[channel], &parts[b].polynomials[channel]);
                    least((a.mean - b.mean).abs() + a.rest + b.rest, alone(channel))
                }
                _ => alone(channel),
            };
            (*ends, (0..self.channels).map(jump).collect())
        };
        order.iter().map(of_edge).collect()
    }

    /// Pieces of the outlines of what may hide sources, and what the radiosity seen may jump by across each in each channel.
    fn jumps(
        &self,
        to: usize,
        target: &Target<'_>,
        sources: &[(usize, &Sight)],
        kinds: &[Kind],
        ranges: &[Vec<[f64; 2]>],
    ) -> Vec<([DVec3; 2], Vec<f64>)> {
        let mesh = self.mesh;
        let mut hidden: Vec<usize> = (0..sources.len()).filter(|&index| kinds[index] == Kind::Cut).collect();
        if hidden.is_empty() {
            return Vec::new();
        }
        let brightness = |index: usize| ranges[index].iter().map(|[low, high]| largest(high.abs(), low.abs())).fold(0.0, largest);
        let bright: Vec<f64> = (0..sources.len()).map(brightness).collect();
        hidden.sort_by(|&a, &b| bright[b].total_cmp(&bright[a]));
        let mut lines: HashMap<usize, Vec<usize>> = HashMap::new();
        for &index in &hidden {
            let mut of_source: Vec<usize> =
                sources[index].1.faces().iter().flat_map(|&face| self.edges.of_face(face)).copied().collect();
            of_source.extend(
                self.edges.of_face(mesh.elements()[sources[index].0].face()).iter().filter(|&&line| self.edges.crosses(line)),
            );
            of_source.sort_unstable();
            of_source.dedup();
            for line in of_source {
                lines.entry(line).or_default().push(index);
            }
        }
        let mut lines: Vec<(usize, Vec<usize>)> = lines.into_iter().collect();
        lines.sort_unstable();
        let from = mesh.elements()[to].polygon().vertices();
        let mut pieces = Vec::new();
        for (line, behind) in lines {
            let [a, b] = self.edges.all[line].ends;
            let from = self.edges.outlined_from(line, from);
            if target.height(a).max(target.height(b)) <= 0.0 || from.is_empty() {
                continue;
            }
            let away = ((a + b) * 0.5 - target.element.centre()).length() - 0.5 * (b - a).length();
            let count = ((b - a).length() / (PIECE * away.max(target.element.radius()))).ceil().clamp(1.0, MOST_PIECES);
            let at = |part: f64| a + (b - a) * (part / count);
            let mut start = 0.0;
            while start < count {
                let piece = [at(start), at(start + 1.0)];
                start += 1.0;
                let mut range = vec![[0.0_f64; 2]; self.channels];
                for &index in &behind {
                    let wider = ranges[index].iter().zip(&range).any(|(of, known)| of[0] < known[0] || of[1] > known[1]);
                    let source = &mesh.elements()[sources[index].0];
                    if wider && from.iter().any(|from| in_beam(from, source, piece)) {
                        for (known, of) in range.iter_mut().zip(&ranges[index]) {
                            *known = [least(known[0], of[0]), largest(known[1], of[1])];
                        }
                    }
                }
                let jumps: Vec<f64> = range.iter().map(|[low, high]| high - low).collect();
                if jumps.iter().any(|jump| *jump > 0.0) {
                    pieces.push((piece, jumps));
                }
            }
        }
        pieces
    }

    /// Bound on the residual of a source that is wholly seen.
    fn alone(&self, target: &Target<'_>, to: usize, source: usize, coefficients: &[f64]) -> Left {
        let (of, p) = (&self.mesh.elements()[source], self.polynomial(source, coefficients));
        let reach = target.reach(of);
        let by = [2.0 / 3.0; 2];
        let drift = if p.gradient > 0.0 { p.gradient * target.drift(of, &reach, by) } else { 0.0 };
        let is_smooth = self.in_front(target, source);
        let smooth = if is_smooth { self.smooth(target, source, &p, self.mesh.basis(to).degree()) } else { f64::INFINITY };
        let smooth = least(smooth, p.size * reach.factor);
        // Of what changes by so much, no polynomial by least squares is off by more than twice that, in the mean.
        // From the centre to a corner.
        let changes = p.size * self.own_by(target, source, by) + drift;
        let twice = 1.0 + target.nodes.lebesgue;
        Left { largest: twice * least(smooth, changes), mean: 2.0 * least(smooth, changes) }
    }

    /// The residual, source by source: wholly seen sources count by the rest of their Taylor series, all others by the most that
    /// they can give from the part of the hemisphere that is left.
    fn by_sources(
        &self,
        to: usize,
        target: &Target<'_>,
        light: &Light<'_>,
        gathered: &Gathered<'_>,
        (kinds, finely): (&[Kind], &Finely),
        channel: usize,
    ) -> Left {
        let (mesh, element, basis) = (self.mesh, target.element, self.mesh.basis(to));
        let (mut left, mut covered, mut taken) = (finely.left.get(channel).copied().unwrap_or_default(), 0.0, 0.0);
        let (mut bounds, mut at_nodes) = (Vec::new(), vec![0.0; basis.nodes().len()]);
        for (index, &(source, _)) in gathered.sources.iter().enumerate() {
            let of = &mesh.elements()[source];
            let coefficients = light.of(mesh, source, channel);
            match kinds[index] {
                Kind::Dark => {}
                Kind::Clear => {
                    if !finely.takes[index] {
                        let alone = self.alone(target, to, source, &coefficients);
                        left.largest += alone.largest;
                        left.mean += alone.mean;
                    }
                    let own = self.own(target, source);
                    let mut unit = vec![0.0; coefficients.len()];
                    unit[0] = 1.0;
                    let least_seen =
                        (0..basis.nodes().len()).map(|node| (gathered.value)(index, node, &unit)).fold(f64::INFINITY, least);
                    let surely = least_seen - own[0] - gathered.error - 1e-6;
                    covered += if surely > 0.0 { surely } else { 0.0 };
                }
                Kind::Cut => {
                    let [low, high] = mesh.basis(source).range(&coefficients);
                    let factor = target.reach(of).factor;
                    bounds.push((factor, low, high));
                    taken += largest(low.abs(), high.abs()) * least(factor, of.area() / element.area());
                    at_nodes.iter_mut().enumerate().for_each(|(node, sum)| *sum += (gathered.value)(index, node, &coefficients));
                }
            }
        }
        if bounds.is_empty() {
            return left;
        }
        let rest = if covered < 1.0 { 1.0 - covered + 1e-6 } else { 1e-6 };
        let high = fill_rest(rest, bounds.iter().map(|&(factor, _, high)| (factor, high)).collect());
        let low = -fill_rest(rest, bounds.iter().map(|&(factor, low, _)| (factor, -low)).collect());
        let held = basis.project(&at_nodes);
        let range = basis.range(&held);
        let off = largest(high - range[0], range[1] - low);
        let rms = held.iter().map(|c| c * c).sum::<f64>().sqrt();
        Left { largest: left.largest + off, mean: left.mean + least(off, taken + rms) }
    }

    /// Whether an element is in front of a source.
    pub(super) fn in_front(&self, target: &Target<'_>, source: usize) -> bool {
        let source = &self.mesh.elements()[source];
        target.element.polygon().vertices().iter().all(|v| {
            let reach = (*v - source.centre()).length() + source.radius();
            source.polygon().normal().dot(*v - source.centre()) >= -LEVEL * reach
        })
    }

    /// Bound on the residual whatever is hidden: the light is between the most and the least that the sources can give.
    fn simply(&self, to: usize, target: &Target<'_>, light: &Light<'_>, gathered: &Gathered<'_>, channel: usize) -> Left {
        let (mesh, element, basis) = (self.mesh, target.element, self.mesh.basis(to));
        let mut bounds: Vec<(f64, f64, f64)> = Vec::with_capacity(gathered.sources.len());
        let mut taken = 0.0;
        let mut at_nodes = vec![0.0; basis.nodes().len()];
        for (index, &(source, _)) in gathered.sources.iter().enumerate() {
            let coefficients = light.of(mesh, source, channel);
            let [low, high] = mesh.basis(source).range(&coefficients);
            let of = &mesh.elements()[source];
            let factor = target.reach(of).factor;
            bounds.push((factor, low, high));
            taken += largest(low.abs(), high.abs()) * least(factor, of.area() / element.area());
            at_nodes.iter_mut().enumerate().for_each(|(node, sum)| *sum += (gathered.value)(index, node, &coefficients));
        }
        let high = fill(bounds.iter().map(|&(factor, _, high)| (factor, high)).collect());
        let low = -fill(bounds.iter().map(|&(factor, low, _)| (factor, -low)).collect());
        let held = basis.project(&at_nodes);
        let range = basis.range(&held);
        let largest_off = largest(high - range[0], range[1] - low);
        let rms = held.iter().map(|c| c * c).sum::<f64>().sqrt();
        Left { largest: largest_off, mean: least(largest_off, taken + rms) }
    }
}

/// The most of `sum F_j u_j` for `0 <= F_j <= f_j` and `sum F_j <= 1`, from pairs of `f_j` and `u_j`.
pub(super) fn fill(pairs: Vec<(f64, f64)>) -> f64 {
    fill_rest(1.0, pairs)
}

/// The same where the factors sum to at most `rest`.
fn fill_rest(mut rest: f64, mut pairs: Vec<(f64, f64)>) -> f64 {
    pairs.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut sum = 0.0;
    for (factor, value) in pairs {
        if value <= 0.0 || value.is_nan() || rest <= 0.0 {
            if value.is_nan() {
                return f64::NAN;
            }
            break;
        }
        let part = least(factor, rest);
        sum += part * value;
        rest -= part;
    }
    sum
}

/// Whether a segment may be between points `x` of a convex polygon and a source.
///
/// With heights over the source's plane, `h` of x and `g` of a point p of the segment, the line of sight meets that plane at
/// `(h p - g x)/(h - g)`. On which side of a line `n.y = d` of the plane that is says the sign of `h (n.p - d) - g (n.x - d)`, linear in
/// x and in p: if it is negative at all corners and ends, and no corner of the source is on that side of the line, nothing of the
/// source is past the segment. The lines are the sides of the source, and those of the hull of the crossings: in a plane with the
/// segment and a corner, or with a side and an end.
fn in_beam(from: &[DVec3], source: &Element, piece: [DVec3; 2]) -> bool {
    let (normal, corner, corners) = (source.polygon().normal(), source.centre(), source.polygon().vertices());
    let height = |p: DVec3| normal.dot(p - corner);
    let (of_piece, of_from) = (piece.map(height), from.iter().map(|&x| height(x)));
    let of_from: Vec<f64> = of_from.collect();
    let reach = source.radius() + from.iter().chain(&piece).map(|p| (*p - corner).length()).fold(0.0, largest);
    let level = 1e-9 * reach;
    let highest = of_from.iter().copied().fold(f64::NEG_INFINITY, largest);
    if of_piece.iter().all(|h| *h < -level) || of_piece.iter().all(|h| *h > highest + level) {
        return false;
    }
    let beyond = |n: DVec3| {
        let d = corners.iter().map(|&v| n.dot(v - corner)).fold(f64::INFINITY, least);
        let across = |x: DVec3| n.dot(x - corner) - d;
        let of_piece = [(across(piece[0]), of_piece[0]), (across(piece[1]), of_piece[1])];
        from.iter().zip(&of_from).all(|(&x, h)| {
            let of_x = across(x);
            of_piece.iter().all(|(of_p, g)| h * of_p - g * of_x < -level * reach)
        })
    };
    let separates = |n: DVec3| {
        let n = n.normalize_or_zero();
        n != DVec3::ZERO && (beyond(n) || beyond(-n))
    };
    let count = from.len();
    let sides = (0..corners.len()).map(|i| normal.cross(corners[(i + 1) % corners.len()] - corners[i]));
    let along = from.iter().map(|&x| (piece[0] - x).cross(piece[1] - x));
    let across = (0..count).flat_map(|i| piece.map(|p| (from[i] - p).cross(from[(i + 1) % count] - p)));
    // The line in which such a plane meets that of the source has the direction `normal x n`.
    let others = along.chain(across).map(|n| n - normal * n.dot(normal));
    !sides.chain(others).any(separates)
}
