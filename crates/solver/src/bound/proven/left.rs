//! What the projection of received light on an element's basis leaves out, bounded at every place of it and in the mean.

use std::collections::HashMap;

use radgrad_core::{DVec3, mutant};
use radgrad_scene::{largest, smallest as least};

use super::cells::Bases;
use super::continued::Continued;
use super::edges::Edges;
use super::finely::Finely;
use super::nodes::{Nodes, ROUNDED};
use super::terms::Target;
use crate::clock::Clock;
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

/// What cells leave at least over what is left without them; each cut in four halves it.
const WITHIN_REACH: f64 = 0.3;

/// Degrees above that of a basis up to which its nodes' rule projects exactly.
const BEYOND: usize = 2;

/// Part of a source that may be hidden where nothing is, or seen where all is hidden, by the rounding of its parts.
const NONE: f64 = 0.05;

/// The scene and its geometry, as the proof uses them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Proof<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) edges: &'a Edges,
    pub(super) nodes: &'a [Nodes; 2],
    pub(super) optics: Optics<'a>,
    pub(super) channels: usize,
    pub(super) bases: &'a [Bases; 2],
    pub(super) effort: &'a Effort,
    /// How often an element is cut into four at most to find out what it leaves out.
    pub(super) deepest: usize,
}

/// How much work the proof may be.
#[derive(Debug)]
pub(super) struct Effort {
    /// For each channel, what of the irradiance is little.
    pub(super) aim: Vec<f64>,
    /// At its end elements are cut no further: the bound is then wider.
    pub(super) clock: Clock,
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

/// The residual of a projection in three parts: the root mean square of one that is orthogonal to all polynomials of the basis, the coefficients
/// of one that is such a polynomial, if any is known, and the mean of the rest.
#[derive(Debug, Clone, Default)]
pub(super) struct Split {
    pub(super) orthogonal: f64,
    pub(super) along: Vec<f64>,
    pub(super) loose: f64,
}

/// The residual of a projection as a whole and in parts, and what is neglected beside if it is that in cells.
pub(super) type LeftOut = (Left, Split, Option<f64>);

/// What an element gathers from, and what its nodes get of it.
pub(super) struct Gathered<'a> {
    pub(super) sources: Vec<(usize, &'a Sight)>,
    /// What a node gets of a source with some coefficients.
    pub(super) value: &'a dyn Fn(usize, usize, &[f64]) -> f64,
    /// Bound on the errors of form factors in that.
    pub(super) error: f64,
    /// Whether these are all that is seen in any direction.
    pub(super) all: bool,
    /// What is neglected anywhere of a source in a channel, if it is gathered from by its polynomial, by whether it is wholly seen.
    pub(super) neglected: &'a dyn Fn(usize, bool, usize) -> f64,
    /// The same of all sources.
    pub(super) neglected_of_all: Vec<f64>,
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

/// A source that something may hide a part of: with the faces that may, and bounds on its radiosity in each channel.
pub(super) type Hidden<'a> = (usize, &'a [usize], Vec<[f64; 2]>);

/// Bounds on a polynomial: on its mean's magnitude, its own, its difference from the mean, and its gradient.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Polynomial {
    mean: f64,
    size: f64,
    rest: f64,
    gradient: f64,
}

impl Left {
    pub(super) fn and(self, other: Self) -> Self {
        Self { largest: self.largest + other.largest, mean: self.mean + other.mean }
    }

    pub(super) fn times(self, factor: f64) -> Self {
        if factor > 0.0 { Self { largest: self.largest * factor, mean: self.mean * factor } } else { Self::default() }
    }

    pub(super) fn lesser(self, other: Self) -> Self {
        Self { largest: least(self.largest, other.largest), mean: least(self.mean, other.mean) }
    }
}

impl Polynomial {
    pub(super) fn even(value: f64) -> Self {
        Self { mean: value, size: value.abs(), ..Self::default() }
    }

    /// The same less a number.
    pub(super) fn less(&self, number: f64) -> Self {
        let mean = self.mean - number;
        Self { mean, size: least(self.size + number.abs(), mean.abs() + self.rest), ..*self }
    }

    pub(super) const fn mean(&self) -> f64 {
        self.mean
    }

    pub(super) const fn size(&self) -> f64 {
        self.size
    }

    pub(super) const fn rest(&self) -> f64 {
        self.rest
    }

    pub(super) const fn gradient(&self) -> f64 {
        self.gradient
    }
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
}

impl Proof<'_> {
    pub(super) fn nodes_of(&self, element: usize) -> &Nodes {
        &self.nodes[usize::from(self.mesh.elements()[element].shape() == Shape::Triangle)]
    }

    /// A part of an element, or all of it, that receives.
    pub(super) fn target<'t>(&'t self, element: usize, part: &'t Element) -> Target<'t> {
        let places: Vec<[f64; 2]> = self.mesh.basis(element).nodes().iter().map(|node| node.at).collect();
        Target::of(part, &places, self.nodes_of(element))
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
        self.kind_from(to, self.mesh.elements()[to].polygon().vertices(), source, faces)
    }

    /// The same from a part of the element.
    pub(super) fn kind_from(&self, to: usize, from: &[DVec3], source: usize, faces: &[usize]) -> Kind {
        if faces.len() > MOST_FACES {
            return Kind::Cut;
        }
        let mut left: Vec<usize> = faces.to_vec();
        let mut kind = Kind::Clear;
        while let Some(&first) = left.first() {
            let solid = self.edges.solid(first);
            let (of_solid, others) = left.into_iter().partition(|&face| self.edges.solid(face) == solid);
            left = others;
            match self.hides(to, from, source, &of_solid, MOST_CUTS) {
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
        let [[least, whole], [seen, most]] = [free, past].map(|of| [of.share(shape) - 2.0 * of.doubt, of.share(shape)]);
        // All of it is hidden, or all of it is seen; if neither is sure there may be an outline after all.
        if most < NONE * least { Some(true) } else { (seen > (1.0 - NONE) * whole).then_some(false) }
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

    /// The residual of the light that an element gathers, in each channel, as a whole and in parts; and bounds on the form factors of all
    /// sources from anywhere on it. What links neglect comes on top: all of it, or so much if the residual is that in cells.
    pub(super) fn left(&self, to: usize, light: &Light<'_>, gathered: &Gathered<'_>) -> (Vec<LeftOut>, Vec<f64>) {
        let (mesh, channels) = (self.mesh, self.channels);
        let (element, basis) = (&mesh.elements()[to], mesh.basis(to));
        let target = self.target(to, element);
        let kinds = self.kinds(to, gathered);
        let sizes: Vec<f64> = (0..channels).map(|channel| self.size(light, gathered, basis.nodes().len(), channel)).collect();
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
        let finely = self.finely(to, light, gathered, &kinds, &alone);
        let held: Vec<Vec<f64>> = (0..channels).map(|channel| self.held(to, light, gathered, channel)).collect();
        let simply = |channel: usize| {
            let simply = self.simply(to, &target, light, gathered, channel);
            let (left, split) = self.by_sources(to, &target, light, gathered, (&kinds, &finely), channel);
            (simply.lesser(left), split)
        };
        let simply: Vec<(Left, Split)> = (0..channels).map(simply).collect();
        let is_little = simply.iter().zip(&self.effort.aim).all(|((left, _), aim)| left.mean <= *aim);
        let before: usize = gathered.sources.iter().map(|(_, sight)| sight.faces().len()).sum();
        let is_cheap = before <= MOST_IN_ALL;
        let aim: Vec<f64> =
            simply.iter().zip(&self.effort.aim).map(|((left, _), aim)| self.within_reach(light, left, *aim)).collect();
        let in_cells = if is_little || !is_cheap { None } else { self.in_cells(to, light, gathered, &kinds, &held, &aim) };
        let of_channel = |(channel, (left, split)): (usize, &(Left, Split))| {
            let in_cells = in_cells.as_ref().map(|in_cells| (in_cells[channel], gathered.neglected_of_all[channel]));
            let (left, neglected) = match in_cells {
                Some(((found, neglected), all)) if found.mean + neglected < left.mean + all => {
                    let simply = left.largest + largest(all - neglected, 0.0);
                    (Left { largest: least(found.largest, simply), ..found }, Some(neglected))
                }
                _ => (*left, None),
            };
            let [most, mean] = target.nodes.rounding.map(|rounding| rounding * f64::EPSILON * sizes[channel]);
            let left = Left { largest: left.largest * ROUNDED + most, mean: least(left.mean, left.largest) * ROUNDED + mean };
            let (orthogonal, loose) = (split.orthogonal * ROUNDED, split.loose * ROUNDED + mean);
            (left, Split { orthogonal, loose, along: split.along.clone() }, neglected)
        };
        let left = simply.iter().enumerate().map(of_channel).collect();
        (left, kinds.iter().enumerate().map(|(index, kind)| self.factor(&target, gathered, index, *kind)).collect())
    }

    /// What is little in cells: of reflected light no less than these may come to, from what is left without them.
    fn within_reach(&self, light: &Light<'_>, simply: &Left, aim: f64) -> f64 {
        match light {
            Light::Field(..) => largest(aim, simply.mean * WITHIN_REACH / 2_f64.powf(self.deepest as f64)),
            Light::Even(_) => aim,
        }
    }

    /// The projection of what an element gathers, from its nodes.
    fn held(&self, to: usize, light: &Light<'_>, gathered: &Gathered<'_>, channel: usize) -> Vec<f64> {
        let basis = self.mesh.basis(to);
        let mut at_nodes = vec![0.0; basis.nodes().len()];
        for (index, &(source, _)) in gathered.sources.iter().enumerate() {
            let of = light.of(self.mesh, source, channel);
            at_nodes.iter_mut().enumerate().for_each(|(node, sum)| *sum += (gathered.value)(index, node, &of));
        }
        basis.project(&at_nodes)
    }

    /// The largest that the samples at an element's nodes may be of which its projection is made, by magnitudes.
    fn size(&self, light: &Light<'_>, gathered: &Gathered<'_>, nodes: usize, channel: usize) -> f64 {
        let mut at_nodes = vec![0.0; nodes];
        for (index, &(source, _)) in gathered.sources.iter().enumerate() {
            let of = light.of(self.mesh, source, channel);
            at_nodes.iter_mut().enumerate().for_each(|(node, sum)| *sum += (gathered.value)(index, node, &of).abs());
        }
        at_nodes.into_iter().fold(0.0, largest)
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

    /// What a polynomial leaves of what a part gives: Taylor's, or on a parallelogram another.
    pub(super) fn smooth(&self, target: &Target<'_>, source: usize, p: &Polynomial, degree: usize) -> f64 {
        let source = &self.mesh.elements()[source];
        let mut sum = 0.0;
        if p.mean != 0.0 {
            sum += p.mean.abs() * target.beyond_of_even(source.polygon().vertices(), degree);
        }
        if p.rest > 0.0 {
            sum += p.rest * target.beyond_of_any(source, degree);
        }
        if sum == 0.0 || target.element.shape() == Shape::Triangle {
            return sum;
        }
        least(sum, p.size * Continued::of(target, source).beyond(degree))
    }

    /// How much the form factor of a source changes by its own edges between places that are so far apart.
    pub(super) fn own_by(&self, target: &Target<'_>, source: usize, by: [f64; 2]) -> f64 {
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

    /// Pieces of the outlines of what may hide sources, and what the radiosity seen may jump by across each in each channel.
    pub(super) fn jumps(&self, target: &Target<'_>, sources: &[Hidden<'_>]) -> Vec<([DVec3; 2], Vec<f64>)> {
        let mesh = self.mesh;
        let brightness = |of: &Hidden<'_>| of.2.iter().map(|[low, high]| largest(high.abs(), low.abs())).fold(0.0, largest);
        let bright: Vec<f64> = sources.iter().map(brightness).collect();
        let mut hidden: Vec<usize> = (0..sources.len()).collect();
        hidden.sort_by(|&a, &b| bright[b].total_cmp(&bright[a]));
        let mut lines: HashMap<usize, Vec<usize>> = HashMap::new();
        for &index in &hidden {
            let mut of_source: Vec<usize> = sources[index].1.iter().flat_map(|&face| self.edges.of_face(face)).copied().collect();
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
        let from = target.element.polygon().vertices();
        let mut pieces = Vec::new();
        for (line, behind) in lines {
            let [a, b] = self.edges.all[line].ends;
            let from = self.edges.outlined_from(line, from);
            if largest(target.height(a), target.height(b)) <= 0.0 || from.is_empty() {
                continue;
            }
            let away = ((a + b) * 0.5 - target.element.centre()).length() - 0.5 * (b - a).length();
            let count = ((b - a).length() / (PIECE * largest(away, target.element.radius()))).ceil().clamp(1.0, MOST_PIECES);
            let at = |part: f64| a + (b - a) * (part / count);
            let mut start = 0.0;
            while start < count {
                let piece = [at(start), at(start + 1.0)];
                start += 1.0;
                let mut range = vec![[0.0_f64; 2]; self.channels];
                for &index in &behind {
                    let wider = sources[index].2.iter().zip(&range).any(|(of, known)| of[0] < known[0] || of[1] > known[1]);
                    let source = &mesh.elements()[sources[index].0];
                    if wider && from.iter().any(|from| in_beam(from, source, piece)) {
                        for (known, of) in range.iter_mut().zip(&sources[index].2) {
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
    ) -> (Left, Split) {
        let (mesh, element, basis) = (self.mesh, target.element, self.mesh.basis(to));
        let (mut left, mut covered, mut taken) = (finely.left.get(channel).copied().unwrap_or_default(), 0.0, 0.0);
        let (along, loose) = finely.along.get(channel).cloned().unwrap_or_default();
        let mut split = Split { orthogonal: left.mean, along, loose };
        let (mut bounds, mut at_nodes) = (Vec::new(), vec![0.0; basis.nodes().len()]);
        for (index, &(source, _)) in gathered.sources.iter().enumerate() {
            let of = &mesh.elements()[source];
            let coefficients = light.of(mesh, source, channel);
            match kinds[index] {
                Kind::Dark => {}
                Kind::Clear => {
                    if !finely.takes[index] {
                        let along = self.along(target, to, source, &coefficients);
                        let alone = self.alone(target, to, source, &coefficients);
                        left = left.and(alone);
                        if along < alone.mean {
                            split.orthogonal += alone.mean;
                            split.loose += along;
                        } else {
                            split.loose += alone.mean;
                        }
                    }
                    let farthest = |k: usize| target.nodes.near.iter().map(|near| near.most[k]).fold(0.0, largest);
                    let own = self.own_by(target, source, [farthest(0), farthest(1)]);
                    let mut unit = vec![0.0; coefficients.len()];
                    unit[0] = 1.0;
                    let least_seen =
                        (0..basis.nodes().len()).map(|node| (gathered.value)(index, node, &unit)).fold(f64::INFINITY, least);
                    let surely = least_seen - own - gathered.error - 1e-6;
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
            return (left, split);
        }
        let rest = if covered < 1.0 { 1.0 - covered + 1e-6 } else { 1e-6 };
        let high = fill_rest(rest, bounds.iter().map(|&(factor, _, high)| (factor, high)).collect());
        let low = -fill_rest(rest, bounds.iter().map(|&(factor, low, _)| (factor, -low)).collect());
        let held = basis.project(&at_nodes);
        let range = basis.range(&held);
        let off = largest(high - range[0], range[1] - low);
        let rms = held.iter().map(|c| c * c).sum::<f64>().sqrt();
        let mean = least(off, taken + rms);
        split.loose += mean;
        (left.and(Left { largest: off, mean }), split)
    }

    /// Root mean square of the part along polynomials that the residual of a source that is wholly seen may have.
    fn along(&self, target: &Target<'_>, to: usize, source: usize, coefficients: &[f64]) -> f64 {
        if !self.in_front(target, source) {
            return f64::INFINITY;
        }
        let beyond = self.smooth(target, source, &self.polynomial(source, coefficients), self.mesh.basis(to).degree() + BEYOND);
        mutant!("solver.along", 2.0 * beyond, |_| 0.0)
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
/// segment and a corner, or with a side and an end. A segment that no more than touches the way to the source, as where a shade meets its
/// lamp, is not between: less than `s (h - g)` will do, which leaves a strip of the source of the width s, [`LEVEL`] of its radius.
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
    let strip = LEVEL * source.radius();
    let beyond = |n: DVec3| {
        let d = corners.iter().map(|&v| n.dot(v - corner)).fold(f64::INFINITY, least);
        let across = |x: DVec3| n.dot(x - corner) - d;
        let of_piece = [(across(piece[0]), of_piece[0]), (across(piece[1]), of_piece[1])];
        from.iter().zip(&of_from).all(|(&x, h)| {
            let of_x = across(x);
            of_piece.iter().all(|(of_p, g)| {
                let rounding = 8.0 * f64::EPSILON * ((h * of_p).abs() + (g * of_x).abs());
                h * of_p - g * of_x + rounding <= strip * (h - g)
            })
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

#[cfg(test)]
mod tests {
    use radgrad_core::Polygon;

    use super::*;
    use crate::mesh::basis::Basis;

    /// A lamp over a floor, and an edge that comes down from one of its corners.
    #[test]
    fn an_edge_that_touches_the_way_to_a_lamp_is_not_between_and_one_that_reaches_into_it_is() {
        let bases = [Shape::Parallelogram, Shape::Triangle].map(|shape| Basis::new(shape, 0));
        let corners = [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]];
        let lamp = Polygon::new(corners.map(|[x, y]| DVec3::new(x, y, 1.0)).to_vec()).unwrap();
        let lamp = &Element::of_face(&lamp, 0, &bases).unwrap()[0];
        let floor = |x: f64, y: f64| [[0.0, 0.0], [0.1, 0.0], [0.1, 0.1], [0.0, 0.1]].map(|[s, t]| DVec3::new(x + s, y + t, 0.0));
        let edge = |x: f64, y: f64| [DVec3::new(x, y, 1.0), DVec3::new(x, y, 0.5)];
        // Past the edge one sees what is beyond the lamp, and from the corner's other side the lamp.
        for (x, y) in [(3.0, 0.4), (0.4, 3.0), (3.0, 3.0), (0.4, 0.4)] {
            assert!(!in_beam(&floor(x, y), lamp, edge(0.0, 0.0)), "({x}, {y})");
        }
        assert!(in_beam(&floor(-2.0, -2.0), lamp, edge(0.0, 0.0)));
        for into in [1e-9, 1e-3, 0.5] {
            assert!(in_beam(&floor(3.0, 0.4), lamp, edge(into, into)), "{into}");
        }
        // A side is touched all along, or passed.
        assert!(!in_beam(&floor(3.0, 0.4), lamp, [DVec3::new(-1.0, 0.0, 1.0), DVec3::new(2.0, 0.0, 1.0)]));
        assert!(in_beam(&floor(3.0, 0.4), lamp, [DVec3::new(-1.0, 1e-6, 1.0), DVec3::new(2.0, 1e-6, 1.0)]));
    }
}
