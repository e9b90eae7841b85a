//! What two faces exchange, one number for both ways: `E = A_i F_ij = A_j F_ji`.
//!
//! The value is the best known: the exact exchange in free sight, else that of the cells that are surely seen plus what points of
//! the others see ([`super::cubature`]). The bracket is proven ([`super::bracket`]), and the value lies in it. Pairs are computed
//! with the lower face first, and from nothing but the two faces and what is between, so that each is the same to the last digit
//! whatever else is computed.

use super::bracket::{Between, Bracket, Search};
use super::cubature::{Goal, Rule};
use super::exchange::{Exchange, exchange};
use super::screen::Sight;
use super::{FactorSettings, FormFactors, larger, smaller};
use crate::{Beam, Error};

/// A form factor with a proven bracket.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Factor {
    /// The factor, in the bracket.
    pub value: f64,
    /// What it is at least, proven.
    pub lower: f64,
    /// What it is at most, proven.
    pub upper: f64,
    /// The distance of the farther end of the bracket: a proven bound on the error.
    pub error: f64,
    /// What its error is by all appearances: with free sight the bound, past occluders the difference of two rules.
    pub estimate: f64,
    /// Polygons that may hide a part of one face from the other: 0 where the sight is free and the value exact to rounding.
    pub occluders: usize,
}

/// What two faces exchange, an area in the unit in which coordinates are up to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Known {
    pub(super) value: f64,
    pub(super) least: f64,
    pub(super) most: f64,
    pub(super) estimate: f64,
    pub(super) occluders: u32,
}

/// Pairs of cells, and the width over what is allowed, with which an integration starts.
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
        let known = if from == to { None } else { self.pair([from.min(to), from.max(to)], settings)? };
        let nothing = Factor { value: 0.0, lower: 0.0, upper: 0.0, error: 0.0, estimate: 0.0, occluders: 0 };
        Ok(known.map_or(nothing, |known| known.over(self.scaled(from).area())))
    }

    /// What two faces exchange, the lower one first; `None` where neither has a point in front of the other, or all is proven hidden.
    pub(super) fn pair(&self, faces: [usize; 2], settings: &FactorSettings) -> Result<Option<Known>, Error> {
        let Some((mut search, candidates, free)) = self.search(faces, settings.estimate) else { return Ok(None) };
        let Some(mut search) = search.take() else {
            let known = Known {
                value: free.area,
                least: larger(free.least(), 0.0),
                most: free.most(),
                estimate: free.error,
                occluders: 0,
            };
            return known.checked().map(Some);
        };
        let area = smaller(self.scaled(faces[0]).area(), self.scaled(faces[1]).area());
        let goal =
            Goal { difference: settings.estimate * area, most_points: settings.most_points, at_point: 0.01 * settings.estimate };
        let owners: Vec<usize> = candidates.iter().flat_map(|&k| self.screens[k].iter().map(move |_| k)).collect();
        let integrate = |search: &Search<'_>, rule: Rule| {
            let hiding: Vec<Vec<usize>> = search
                .undecided()
                .map(|mixed| {
                    let mut faces: Vec<usize> = mixed.screens.iter().map(|&k| owners[k as usize]).collect();
                    faces.dedup();
                    faces
                })
                .collect();
            let pairs = search.undecided().zip(hiding.iter().map(Vec::as_slice));
            self.integrate(faces, pairs, rule, goal)
        };
        let allowed = |bracket: Bracket| larger(settings.tolerance * area, settings.relative * bracket.least);
        // Many digits want few and large cells: those from which the search starts. Few digits want those that are undecided for good.
        let is_precise = settings.estimate < MANY_DIGITS;
        if !is_precise {
            search.narrow(|bracket| bracket.width() <= ROUGHLY * allowed(bracket), settings.most_cells.min(A_LOOK));
        }
        let found = integrate(&search, if is_precise { Rule::PRECISE } else { Rule::PLAIN })?;
        let value = search.seen() + found.area;
        search.narrow(|bracket| bracket.error_of(value) <= allowed(bracket), settings.most_cells);
        let bracket = search.bracket();
        // What is proven hidden has no factor.
        if bracket.most == 0.0 {
            return Ok(None);
        }
        let nearest = bracket.nearest(value);
        let known = Known {
            value: nearest,
            least: bracket.least,
            most: bracket.most,
            estimate: larger(found.difference, (nearest - value).abs()),
            occluders: u32::try_from(candidates.len()).unwrap_or(u32::MAX),
        };
        known.checked().map(Some)
    }

    /// Where the search for what two faces exchange starts, what may be in between, and what they exchange if nothing is; no search
    /// where nothing may be in between.
    #[expect(clippy::type_complexity, reason = "three things that go together once")]
    fn search(&self, faces: [usize; 2], estimate: f64) -> Option<(Option<Search<'_>>, Vec<usize>, Exchange)> {
        let polygons = faces.map(|face| self.scaled(face));
        if self.is_behind(faces) {
            return None;
        }
        let beam = Beam::from_polygon(self.polygon(faces[0]), self.polygon(faces[1]))?;
        let candidates = self.index.in_beam(&beam, &faces).polygons;
        let screens: Vec<_> = candidates.iter().flat_map(|&k| &self.screens[k]).collect();
        if polygons.iter().all(|polygon| super::rule::patches(polygon.vertices()).len() == 1) {
            let outlines = polygons.map(radgrad_core::Polygon::vertices);
            let hides = |screen: &&super::Screen| {
                let verdict = screen.between(outlines, 1.0);
                verdict.sight == Sight::Blocked && !verdict.is_displaced
            };
            if screens.iter().any(hides) {
                return None;
            }
        }
        let free = exchange(polygons[0], polygons[1]);
        if free == Exchange::default() {
            return None;
        }
        // A small part of the estimate's error, of what at most is the free exchange.
        let area = smaller(polygons[0].area(), polygons[1].area());
        let truncation = (0.02 * estimate * area / free.area).clamp(1e-15, 3e-6);
        let search = (!screens.is_empty()).then(|| Search::new(Between { polygons, screens, free, truncation }));
        Some((search, candidates, free))
    }
}
