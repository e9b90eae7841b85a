//! The exchange of two faces, one number for both ways: `E = A_i F_ij = A_j F_ji`.
//!
//! The value is the best known: the exact exchange in free sight, else that of the cells that are surely seen plus what points of
//! the others see ([`super::cubature`]). The bracket is proven ([`super::bracket`]), and the value lies in it. Pairs are computed
//! with the lower face first, and from nothing but the two faces and what is between, so that each is the same to the last digit
//! whatever else is computed.

use serde::{Deserialize, Serialize};

use super::bracket::{Between, Bracket, Search};
use super::cubature::{Goal, Hiding, Rule};
use super::exchange::{ALL_DIGITS, Exchange, exchange};
use super::glance::Glance;
use super::hiding::Wanted;
use super::screen::{Screen, Undecided};
use super::{FactorSettings, FormFactors, larger, middle, smaller};
use crate::{Beam, Error};

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
    /// What its error is by all appearances: with free sight the bound, past occluders the difference of two rules.
    pub estimate: f64,
    /// Polygons that may hide a part of one face from the other: 0 where the sight is free and the value exact to rounding.
    pub occluders: usize,
}

/// The exchange of two faces, an area in the unit in which coordinates are up to 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Known {
    pub(super) value: f64,
    pub(super) least: f64,
    pub(super) most: f64,
    pub(super) estimate: f64,
    pub(super) occluders: u32,
}

/// Shares of the estimate and of the bracket's tolerance that errors of cell exchanges may use, and the most for the bracket.
const OF_VALUE: f64 = 0.3;
const OF_BRACKET: f64 = 0.02;
const MOST_OF_BRACKET: f64 = 3e-3;

/// The relative truncation error that an estimate with this relative error allows.
const fn truncation(wanted: f64) -> f64 {
    wanted.clamp(ALL_DIGITS, 1e-4)
}

/// Two faces that may see each other.
struct Sighted<'a> {
    /// The faces that may be between, and their convex parts.
    candidates: Vec<usize>,
    screens: Vec<&'a Screen>,
    /// Their exchange if nothing is.
    free: Exchange,
}

/// Pairs of cells, and width of the bracket over its tolerance, at which the integration starts.
const A_LOOK: usize = 32;
const ROUGHLY: f64 = 4.0;

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
        Factor { value, lower, upper, error, estimate: self.estimate / area, occluders: self.occluders as usize }
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
    /// With free sight between the two it is exact to rounding. Else the estimate of its error is that of an integration, narrow but
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
        let known = if may_see { self.pair([low, high], settings)? } else { None };
        let nothing = Factor { value: 0.0, lower: 0.0, upper: 0.0, error: 0.0, estimate: 0.0, occluders: 0 };
        Ok(known.map_or(nothing, |known| known.over(self.scaled(from).area())))
    }

    /// What two faces exchange, the lower one first; `None` where neither has a point in front of the other, or all is proven hidden.
    pub(super) fn pair(&self, faces: [usize; 2], settings: &FactorSettings) -> Result<Option<Known>, Error> {
        let polygons = faces.map(|face| self.scaled(face));
        let area = smaller(polygons[0].area(), polygons[1].area());
        let Some(Sighted { candidates, screens, free }) = self.sighted(faces, settings) else { return Ok(None) };
        // No face exchanges more than its area.
        let most = smaller(free.most(), area * (1.0 + 8.0 * f64::EPSILON));
        let least = smaller(larger(free.least(), 0.0), most);
        let occluders = u32::try_from(candidates.len()).unwrap_or(u32::MAX);
        if screens.is_empty() {
            let bracket = Bracket { least, most };
            let (value, estimate) = (bracket.nearest(free.area), smaller(free.error, bracket.width()));
            return Known { value, least, most, estimate, occluders }.checked().map(Some);
        }
        let allowed = |bracket: Bracket| larger(settings.tolerance * area, settings.relative * bracket.least);
        let difference = settings.estimate * area;
        if most <= smaller(difference, allowed(Bracket { least: 0.0, most })) {
            // The whole exchange is within the tolerance.
            let value = free.area * self.share_seen(faces, &screens);
            if value == 0.0 && self.is_hidden(faces, &screens) {
                return Ok(None);
            }
            let bracket = Bracket { least: 0.0, most };
            let nearest = bracket.nearest(value);
            return Known { value: nearest, least: 0.0, most, estimate: bracket.error_of(nearest), occluders }
                .checked()
                .map(Some);
        }
        // Errors of cell exchanges may use a small share of the tolerances, relative to the free exchange, which is at least as
        // large.
        let of_value = truncation(OF_VALUE * settings.estimate * area / free.area);
        let of_bracket = larger(OF_BRACKET * larger(settings.tolerance * area / free.area, settings.relative), of_value);
        // Of faces that are few roundings of their coordinates wide the sum over edges says less than their areas.
        let all = if free.most() > most { Exchange::within([least, most]) } else { free };
        let mut search = Search::new(Between { polygons, screens, free: all, accuracy: of_value });
        let difference = larger(difference, settings.relative_estimate * free.area);
        let goal = Goal { difference, most_points: settings.most_points, at_point: 0.01 * settings.estimate };
        let owners: Vec<usize> = candidates.iter().flat_map(|&k| self.screens[k].iter().map(move |_| k)).collect();
        // Many digits want few and large cells: those from which the search starts. Few digits want those that are undecided for good.
        let is_precise = settings.estimate < MANY_DIGITS;
        if !is_precise {
            search.narrow(|bracket| bracket.width() <= ROUGHLY * allowed(bracket), settings.most_cells.min(A_LOOK));
        }
        let bracket = search.bracket();
        let (value, off) = if bracket.width() <= 2.0 * difference {
            (bracket.least + 0.5 * bracket.width(), 0.5 * bracket.width())
        } else {
            let rule = if is_precise { Rule::PRECISE } else { Rule::PLAIN };
            let hiding = Hiding { screens: search.screens(), owners: &owners };
            let found = self.integrate(faces, search.undecided(), hiding, rule, goal)?;
            (search.seen() + found.area, found.difference)
        };
        search.only_bracket(smaller(of_bracket, MOST_OF_BRACKET));
        search.narrow(|bracket| bracket.error_of(value) <= allowed(bracket), settings.most_cells);
        let bracket = search.bracket();
        // A pair that is proven hidden has no factor.
        if bracket.most == 0.0 {
            return Ok(None);
        }
        let nearest = bracket.nearest(value);
        let estimate = larger(off, (nearest - value).abs());
        Known { value: nearest, least: bracket.least, most: bracket.most, estimate, occluders }.checked().map(Some)
    }

    /// The faces that may be between two faces, and the exchange of the two without them; `None` where they see nothing of each
    /// other.
    fn sighted(&self, faces: [usize; 2], settings: &FactorSettings) -> Option<Sighted<'_>> {
        let polygons = faces.map(|face| self.scaled(face));
        if self.is_behind(faces) {
            return None;
        }
        let beam = Beam::from_polygon(self.polygon(faces[0]), self.polygon(faces[1]))?;
        let candidates = self.index.in_beam(&beam, &faces).polygons;
        let screens: Vec<&Screen> = candidates.iter().flat_map(|&k| &self.screens[k]).collect();
        // Past others the estimate has fewer digits.
        let truncation = if screens.is_empty() { ALL_DIGITS } else { truncation(OF_VALUE * settings.estimate) };
        let free = exchange(polygons[0], polygons[1], truncation);
        (free != Exchange::default()).then_some(Sighted { candidates, screens, free })
    }

    /// Whether each part of one face is hidden from each part of the other by one screen.
    fn is_hidden(&self, faces: [usize; 2], screens: &[&Screen]) -> bool {
        let [from, to] = faces.map(|face| super::rule::patches(self.scaled(face).vertices()));
        let mut pairs = from.iter().flat_map(|from| to.iter().map(move |to| [from.outline(), to.outline()]));
        !from.is_empty() && !to.is_empty() && pairs.all(|outlines| screens.iter().any(|screen| screen.hides(outlines)))
    }

    /// The share of one face that the middle of the other sees, of the smaller one's middle: a look, no more.
    fn share_seen(&self, faces: [usize; 2], screens: &[&Screen]) -> f64 {
        let from = usize::from(self.scaled(faces[1]).area() < self.scaled(faces[0]).area());
        let [own, other] = [from, 1 - from].map(|k| self.scaled(faces[k]));
        let points = super::rule::patches(own.vertices());
        let Some(patch) = points.first() else { return 0.0 };
        let point = middle(patch.outline());
        let mut glance = Glance::default();
        let mut share = |screens: &[&Screen]| -> f64 {
            let cells = super::rule::patches(other.vertices());
            let at = (point, own.normal());
            let screens = || screens.iter().map(|&screen| (screen, Undecided::ALL));
            cells.iter().map(|cell| glance.factor(at, (cell.outline(), other.normal()), screens())).sum()
        };
        let (all, seen) = (share(&[]), share(screens));
        if all > 0.0 { seen / all } else { 0.0 }
    }
}
