//! The exchange of two faces, one number for both ways: `E = A_i F_ij = A_j F_ji`.
//!
//! The value is the best known: in free sight the exchange as far as it is asked for, else that of the cells that are surely seen plus what points of
//! the others see ([`super::cubature`]). The bracket is proven ([`super::bracket`]), and the value lies in it. Pairs are computed
//! with the lower face first, and from nothing but the two faces and the faces between, so that each is the same to the last digit
//! whatever else is computed.

use radgrad_core::DVec3;
use serde::{Deserialize, Serialize};
use smallvec::SmallVec;

use super::bracket::{Bracket, Hider, Search, TwoFaces};
use super::cubature::{Goal, Hiding, Rule};
use super::culling::Wanted;
use super::exchange::areas::Exchange;
use super::exchange::{ALL_DIGITS, exchange, exchange_apart};
use super::neighbours::Place;
use super::point_factor::PointFactor;
use super::rule::{middle, nodes_of, patches};
use super::screen::{Cells, Screen, Sight, Undecided};
use super::{FactorSettings, FormFactors, Front, Sphere};
use crate::error::Error;
use crate::extremes::{largest as larger, smallest as smaller};
use crate::occluders::shape::Bounds;

/// A form factor with a proven bracket.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Factor {
    /// The factor, in the bracket.
    pub value: f64,
    /// Proven lower bound.
    pub lower: f64,
    /// Proven upper bound.
    pub upper: f64,
    /// The distance of the farther end of the bracket: a proven bound on the error.
    pub error: f64,
    /// The part of `error` that the rounding of the scene's coordinates takes: no effort narrows it.
    pub modelling: f64,
    /// Its error by all appearances: with free sight the bound, past occluders the difference of two rules.
    pub estimate: f64,
    /// Polygons that may hide a part of one face from the other: 0 where the sight is free.
    pub occluders: usize,
}

impl Factor {
    /// The part of `error` that effort narrows.
    #[must_use]
    pub const fn computed_error(&self) -> f64 {
        self.error - self.modelling
    }
}

/// The exchange of two faces, an area in the unit in which coordinates are up to 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Known {
    pub(super) value: f64,
    pub(super) least: f64,
    pub(super) most: f64,
    pub(super) estimate: f64,
    /// The part of the bracket, on either side, that the rounding of coordinates takes.
    pub(super) modelling: f64,
    pub(super) occluders: u32,
}

/// Shares of the estimate and of the bracket's tolerance that errors of cell exchanges may use, and the most for the bracket.
const OF_VALUE: f64 = 0.3;
const OF_BRACKET: f64 = 0.02;
const MOST_OF_BRACKET: f64 = 3e-3;

/// Share of the estimate up to which an exchange in free sight is not held against a second way to it.
const RESOLVED: f64 = 0.1;
const DIGITS: f64 = 1e-12;

/// The relative truncation error that an estimate with this relative error allows.
const fn truncation(wanted: f64) -> f64 {
    wanted.clamp(ALL_DIGITS, 1e-4)
}

/// A screen that may be between two faces, and its edges that segments may pass outside.
#[derive(Debug, Clone, Copy)]
struct Between {
    place: Place,
    open: Undecided,
}

/// The part of the sight between two faces that a screen leaves.
enum Left {
    All,
    Part(Undecided),
    Nothing,
}

/// All points nearer to a segment than a distance: around the hull of two spheres.
struct RoundBeam {
    from: DVec3,
    along: DVec3,
    /// One over the square of its length.
    inverse: f64,
    radius: f64,
}

impl RoundBeam {
    fn of(spheres: [Sphere; 2], unit: f64) -> Self {
        let (from, along) = (spheres[0].centre * unit, (spheres[1].centre - spheres[0].centre) * unit);
        let radius = larger(spheres[0].radius, spheres[1].radius) * unit + 1e-9 * unit;
        let square = along.length_squared();
        Self { from, along, inverse: if square > 0.0 { 1.0 / square } else { 0.0 }, radius }
    }

    /// Whether a sphere around a box has a point in it.
    fn meets(&self, bounds: &Bounds) -> bool {
        let (middle, half) = (0.5 * (bounds.low + bounds.high), 0.5 * (bounds.high - bounds.low));
        let to = middle - self.from;
        let share = (to.dot(self.along) * self.inverse).clamp(0.0, 1.0);
        let away = self.radius + half.length();
        (to - self.along * share).length_squared() <= away * away
    }
}

/// Two faces that may see each other.
struct Sighted<'a> {
    /// The faces that may be between.
    candidates: Vec<usize>,
    /// Their convex parts that hide something, each with its face, and the facts known of their edges.
    screens: Vec<&'a Screen>,
    owners: Vec<usize>,
    hiders: Vec<Hider>,
    /// Their exchange if nothing is.
    free: Exchange,
}

/// The share of the exchange of two faces with nothing in between that some points of one see, and by how much these differ.
struct Looks {
    share: f64,
    spread: f64,
}

/// The whole exchange over the error that the value may have, up to which a few looks may do.
const FEW_LOOKS: f64 = 10.0;

/// Screens above which a pair that looks see nothing of is not searched for a proof.
const MANY_SCREENS: usize = 64;

/// Their value may be off by this part of the relative estimate, if `estimate` is less.
const BY_LOOKS: f64 = 0.1;

/// Where a face is looked at from that no other look sees anything of: beside its corners, as those may be in the planes of screens.
const CORNERS: [[f64; 2]; 4] = [[ASIDE, ASIDE], [1.0 - ASIDE, ASIDE], [1.0 - ASIDE, 1.0 - ASIDE], [ASIDE, 1.0 - ASIDE]];
const ASIDE: f64 = 0.01;

/// Pairs of cells, and width of the bracket over its tolerance, at which the integration starts.
const A_LOOK: usize = 32;
const ROUGHLY: f64 = 2.0;

/// Below this estimate cells are cut along events, and rules have many points.
const MANY_DIGITS: f64 = 1e-7;

impl Known {
    /// The factor of the face of this area.
    pub(super) fn over(&self, area: f64) -> Factor {
        let value = self.value / area;
        // The area and the division err by a few roundings.
        let lower = self.least / area * (1.0 - 8.0 * f64::EPSILON);
        let upper = self.most / area * (1.0 + 8.0 * f64::EPSILON);
        let error = larger(upper - value, value - lower) * (1.0 + f64::EPSILON);
        let (modelling, estimate) = (self.modelling / area, self.estimate / area);
        Factor { value, lower, upper, error, modelling, estimate, occluders: self.occluders as usize }
    }

    /// The same with a bracket that is wider by the effect of rounded coordinates, between 0 and `most`.
    fn widened(self, modelling: f64, most: f64) -> Self {
        let error = |least: f64, most: f64| larger(most - self.value, self.value - least);
        let least = smaller(larger(self.least - modelling, 0.0), self.least);
        let upper = larger(smaller(self.most + modelling, most), self.most);
        let modelling = larger(error(least, upper) - error(self.least, self.most), 0.0);
        Self { least, most: upper, modelling, ..self }
    }

    /// Itself, if its figures are numbers.
    fn checked(self) -> Result<Self, Error> {
        if [self.value, self.least, self.most].iter().all(|number| number.is_finite()) {
            return Ok(self);
        }
        Err(Error::expected("an exchange that is a number", format!("{} in [{}, {}]", self.value, self.least, self.most)))
    }
}

impl FormFactors<'_> {
    /// Factor from face `from` to face `to`.
    ///
    /// With free sight between the two its error is at most `relative_estimate` of it, and a few roundings where that is 0. Else the estimate of its error is that of an integration, narrow but
    /// not proven, as far as `estimate` and `most_points` of the settings go; the bracket is proven, and narrowed as far as
    /// `tolerance`, `relative` and `most_cells` go.
    ///
    /// # Errors
    /// If there is no such face, or a point's factor is out of range.
    pub fn between(&self, from: usize, to: usize, settings: &FactorSettings) -> Result<Factor, Error> {
        self.emitter(from)?;
        self.emitter(to)?;
        let [low, high] = [from.min(to), from.max(to)];
        let wanted = Wanted::new(self.index.order(), (0..self.emitters.len()).map(|face| face == high).collect());
        let may_see = low != high && !self.may_see(low, &wanted).is_empty();
        self.go_on()?;
        let pair = if may_see { self.pair([low, high], settings)? } else { None };
        let nothing = Factor { value: 0.0, lower: 0.0, upper: 0.0, error: 0.0, modelling: 0.0, estimate: 0.0, occluders: 0 };
        Ok(pair.map_or(nothing, |known| known.over(self.scaled(from).area())))
    }

    /// The exchange of two faces, the lower one first; `None` where neither has a point in front of the other, or all is proven hidden.
    ///
    /// An outline whose points are off by at most d adds or loses a band of at most d times its perimeter, and two surfaces exchange at
    /// most the area of either: so much do the rounded outlines of the two faces and of those between them change the exchange.
    pub(super) fn pair(&self, faces: [usize; 2], settings: &FactorSettings) -> Result<Option<Known>, Error> {
        self.go_on()?;
        let Some(sighted) = self.sighted(faces, settings) else { return Ok(None) };
        let modelling: f64 = faces.iter().chain(&sighted.candidates).map(|&face| self.bands[face]).sum();
        let exchange = self.exchanged(faces, sighted, settings)?;
        self.go_on()?;
        Ok(exchange.map(|known| known.widened(modelling, self.smaller_area(faces))))
    }

    /// No face exchanges more than its area.
    fn smaller_area(&self, faces: [usize; 2]) -> f64 {
        let [a, b] = faces.map(|face| self.scaled(face).area());
        smaller(a, b)
    }

    /// The same of the outlines as they are.
    fn exchanged(&self, faces: [usize; 2], sighted: Sighted<'_>, settings: &FactorSettings) -> Result<Option<Known>, Error> {
        let polygons = faces.map(|face| self.scaled(face));
        let area = self.smaller_area(faces);
        let Sighted { candidates, screens, owners, hiders, free } = sighted;
        let upper = smaller(free.most(), area * (1.0 + 8.0 * f64::EPSILON));
        let least = smaller(larger(free.least(), 0.0), upper);
        let occluders = u32::try_from(candidates.len()).unwrap_or(u32::MAX);
        if screens.is_empty() {
            let bracket = Bracket { least, most: upper };
            let (value, estimate) = (bracket.nearest(free.area), smaller(free.error, bracket.width()));
            return Known { value, least, most: upper, estimate, modelling: 0.0, occluders }.checked().map(Some);
        }
        let allowed = |bracket: Bracket| larger(settings.tolerance * area, settings.relative * bracket.least);
        let difference = settings.estimate * area;
        let nothing_to_all = Bracket { least: 0.0, most: upper };
        let by_looks = larger(difference, BY_LOOKS * settings.relative_estimate * area);
        if upper <= smaller(FEW_LOOKS * by_looks, allowed(nothing_to_all)) {
            // The whole exchange is within the tolerance, and little is asked of the value.
            let Looks { share, spread } = self.looks(faces, (&screens, &hiders), 0.5 * upper > by_looks);
            let (value, estimate) = (nothing_to_all.nearest(free.area * share), 0.5 * spread * upper);
            if value == 0.0 && self.is_hidden(faces, &candidates) {
                return Ok(None);
            }
            // The search proves more, and takes the longer the more there is between.
            if estimate <= by_looks && (value > 0.0 || screens.len() > MANY_SCREENS) {
                return Known { value, least: 0.0, most: upper, estimate, modelling: 0.0, occluders }.checked().map(Some);
            }
        }
        // Errors of cell exchanges may use a small share of the tolerances, relative to the free exchange, which is at least as
        // large.
        let of_value = truncation(OF_VALUE * settings.estimate * area / free.area);
        let of_bracket = larger(OF_BRACKET * larger(settings.tolerance * area / free.area, settings.relative), of_value);
        // Of faces that are few roundings of their coordinates wide the sum over edges says less than their areas.
        let whole = if free.most() > upper { Exchange::within([least, upper]) } else { free };
        // Many digits want few and large cells: those from which the search starts. Few digits want those that are undecided for good.
        let is_precise = settings.estimate < MANY_DIGITS;
        // Where nothing to all is narrow enough, it serves the value alone.
        let is_met = !is_precise && upper <= allowed(nothing_to_all);
        let mut search = Search::new(TwoFaces { polygons, screens, free: whole, accuracy: of_value, is_met }, &hiders);
        let difference = larger(difference, settings.relative_estimate * free.area);
        let goal = Goal { difference, most_points: settings.most_points, at_point: 0.01 * settings.estimate };
        if !is_precise {
            search.narrow(
                |bracket| self.is_stopped() || bracket.width() <= ROUGHLY * allowed(bracket),
                settings.most_cells.min(A_LOOK),
            );
        }
        let bracket = search.bracket();
        let (value, off) = if bracket.width() <= 2.0 * difference {
            (bracket.least + 0.5 * bracket.width(), 0.5 * bracket.width())
        } else {
            let rule = if is_precise { Rule::PRECISE } else { Rule::PLAIN };
            let hiding = Hiding { screens: search.screens(), owners: &owners };
            let integral = self.integrate(faces, search.undecided(), hiding, rule, goal)?;
            (search.seen() + integral.area, integral.difference)
        };
        search.only_bracket(smaller(of_bracket, MOST_OF_BRACKET));
        search.narrow(|bracket| self.is_stopped() || bracket.error_of(value) <= allowed(bracket), settings.most_cells);
        let bracket = search.bracket();
        // A pair that is proven hidden has no factor.
        if bracket.most == 0.0 {
            return Ok(None);
        }
        let nearest = bracket.nearest(value);
        let estimate = larger(off, (nearest - value).abs());
        Known { value: nearest, least: bracket.least, most: bracket.most, estimate, modelling: 0.0, occluders }
            .checked()
            .map(Some)
    }

    /// The exchange of two faces and a bound on its error, 0 where they see nothing of each other; `None` where something may be between them.
    pub(super) fn free_exchange(&self, faces: [usize; 2], settings: &FactorSettings) -> Option<[f64; 2]> {
        let Some(Sighted { screens, free, .. }) = self.sighted(faces, settings) else { return Some([0.0; 2]) };
        let (area, bands) = (larger(free.area, 0.0), faces.map(|face| self.bands[face]).iter().sum::<f64>());
        let error = free.error + (area - free.area) + bands;
        (screens.is_empty() && area.is_finite() && error.is_finite()).then_some([area, error])
    }

    /// The faces that may be between two faces, and the exchange of the two without them; `None` where they see nothing of each
    /// other.
    fn sighted(&self, faces: [usize; 2], settings: &FactorSettings) -> Option<Sighted<'_>> {
        let polygons = faces.map(|face| self.scaled(face));
        if self.is_behind(faces) {
            return None;
        }
        let between = self.between_faces(faces)?;
        let owners: Vec<usize> = between.iter().map(|between| between.place.0).collect();
        let screens: Vec<&Screen> = between.iter().map(|between| &self.screens[between.place.0][between.place.1]).collect();
        let hiders: Vec<Hider> = (0..).zip(&between).map(|(screen, between)| Hider { screen, open: between.open }).collect();
        let mut candidates = owners.clone();
        candidates.dedup();
        // Past others the estimate has fewer digits.
        let truncation = truncation(OF_VALUE * if screens.is_empty() { settings.relative_estimate } else { settings.estimate });
        let apart = || {
            let are_before = self.front(faces[0], faces[1]) == Front::All && self.front(faces[1], faces[0]) == Front::All;
            let parts = || faces.map(|face| (&self.parts[face][..], self.scaled(face)));
            let exchange = if are_before { exchange_apart(parts(), truncation) } else { None };
            // The other way has fewer roundings.
            exchange.filter(|found| found.error <= 2.0 * truncation * found.area)
        };
        let any = || exchange(polygons[0], polygons[1], truncation, larger(RESOLVED * settings.estimate, DIGITS));
        let free = apart().unwrap_or_else(any);
        (free != Exchange::default()).then_some(Sighted { candidates, screens, owners, hiders, free })
    }

    /// The parts that may hide a part of one face from the other, by face; `None` where one screen hides all. Boxes around the two, and a
    /// round beam, pass over most of all; of the others each screen decides for itself.
    fn between_faces(&self, faces: [usize; 2]) -> Option<Vec<Between>> {
        let mut parts: Vec<Between> = Vec::new();
        if self.hiders.is_empty() {
            return Some(parts);
        }
        let outlines = faces.map(|face| &self.screens[face]);
        let pairs = outlines[0].iter().flat_map(|a| outlines[1].iter().map(move |b| Cells::new([a.outline(), b.outline()])));
        let cells: SmallVec<[Cells<'_>; 1]> = pairs.collect();
        let round = RoundBeam::of(faces.map(|face| self.spheres[face]), 1.0 / self.power);
        let bounds = Bounds::of(self.polygon(faces[0]).vertices()).and(&Bounds::of(self.polygon(faces[1]).vertices()));
        let meets = |other: &Bounds| other.common(&bounds).is_some() && round.meets(other);
        let mut is_hidden = false;
        self.index.visit_of(&self.hiders, meets, |face| {
            if faces.contains(&face) {
                return false;
            }
            for (part, screen) in self.screens[face].iter().enumerate() {
                match Self::left_by(screen, &cells) {
                    Left::All => {}
                    Left::Nothing => is_hidden = true,
                    Left::Part(open) => {
                        // A part that is not before a surface hides nothing of it.
                        if parts.last().is_some_and(|last| last.place.0 == face) || !self.is_aside(face, faces) {
                            parts.push(Between { place: (face, part), open });
                        }
                    }
                }
            }
            is_hidden
        });
        parts.sort_unstable_by_key(|between| between.place);
        (!is_hidden).then_some(parts)
    }

    /// Whether a face is nowhere before one of two.
    fn is_aside(&self, face: usize, of: [usize; 2]) -> bool {
        of.iter().any(|&of| match self.front(of, face) {
            Front::All | Front::Part => false,
            Front::None => true,
            Front::Unclear => self.index.is_behind(face, of),
        })
    }

    /// The part of the sight between all parts of two faces that a screen leaves.
    fn left_by(screen: &Screen, cells: &[Cells<'_>]) -> Left {
        let (mut is_all, mut is_nothing, mut left) = (true, true, Undecided::ALL);
        for cells in cells {
            let verdict = screen.between(cells, 1.0, Undecided::ALL);
            is_all &= verdict.sight == Sight::Free && !verdict.is_displaced;
            is_nothing &= verdict.sight == Sight::Blocked && !verdict.is_displaced;
            // The search takes account of edges that were displaced.
            left = verdict.edges.filter(|_| !verdict.is_displaced).unwrap_or(Undecided::ALL);
        }
        match (cells.len(), is_all, is_nothing) {
            (0, ..) => Left::Part(Undecided::ALL),
            (_, true, _) => Left::All,
            (_, _, true) => Left::Nothing,
            (1, ..) => Left::Part(left),
            _ => Left::Part(Undecided::ALL),
        }
    }

    /// Whether each part of one face is proven hidden from each part of the other by a screen between their middles, alone or with those that it
    /// shares edges with.
    fn is_hidden(&self, faces: [usize; 2], candidates: &[usize]) -> bool {
        let [from, to] = faces.map(|face| patches(self.scaled(face).vertices()));
        let mut pairs = from.iter().flat_map(|from| to.iter().map(move |to| [from.outline(), to.outline()]));
        let places = candidates.iter().flat_map(|&face| (0..self.screens[face].len()).map(move |part| (face, part)));
        let is_hidden = |outlines: [&[DVec3]; 2]| {
            let middles = outlines.map(middle);
            places.clone().any(|place| self.hide_by(outlines, middles, faces, place))
        };
        !from.is_empty() && !to.is_empty() && pairs.all(is_hidden)
    }

    /// The share of the other face that four points of each patch of the smaller one see: looks, no more. Where they see nothing,
    /// points beside the corners say by how much that differs, if it is asked for.
    fn looks(&self, faces: [usize; 2], (screens, hiders): (&[&Screen], &[Hider]), asks_corners: bool) -> Looks {
        let from = usize::from(self.scaled(faces[1]).area() < self.scaled(faces[0]).area());
        let [own, other] = [from, 1 - from].map(|k| self.scaled(faces[k]));
        let cells = patches(other.vertices());
        let mut view = PointFactor::default();
        let mut from_point = |point: DVec3, hiders: &[Hider]| -> f64 {
            let at = (point, own.normal());
            let screens = || hiders.iter().map(|hider| (screens[hider.screen as usize], hider.open));
            cells.iter().map(|cell| view.factor(at, (cell.outline(), other.normal()), screens())).sum()
        };
        let (mut sums, mut range) = ([0.0; 2], [f64::INFINITY, 0.0]);
        for node in patches(own.vertices()).iter().flat_map(|patch| nodes_of(patch, 2)) {
            let whole = from_point(node.point, &[]);
            if whole > 0.0 {
                let seen = from_point(node.point, hiders);
                sums = [sums[0] + node.share * whole, sums[1] + node.share * seen];
                range = [smaller(range[0], seen / whole), larger(range[1], seen / whole)];
            }
        }
        let [all, seen] = sums;
        if seen == 0.0 && asks_corners {
            for point in patches(own.vertices()).iter().flat_map(|patch| CORNERS.map(|[u, v]| patch.at(u, v).0)) {
                let seen = from_point(point, hiders);
                range[1] = larger(range[1], if seen > 0.0 { seen / from_point(point, &[]) } else { 0.0 });
            }
        }
        if all > 0.0 { Looks { share: seen / all, spread: range[1] - range[0] } } else { Looks { share: 0.0, spread: 1.0 } }
    }
}
