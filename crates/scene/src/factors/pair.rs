//! The factor from one face to another.

use super::bracket::{Between, Bracket};
use super::exchange::{Exchange, exchange};
use super::{FactorSettings, FormFactors};
use crate::{Beam, Error};

/// A form factor with a proven bound.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Factor {
    /// The factor.
    pub value: f64,
    /// Proven bound on its error.
    pub error: f64,
    /// What its error is by all appearances: with free sight the bound, past occluders the difference of two rules.
    pub estimate: f64,
    /// Polygons that may hide a part of one face from the other: 0 where the sight is free and the value exact to rounding.
    pub occluders: usize,
}

/// What is known of two faces, both ways.
#[derive(Debug, Clone)]
pub(super) struct Pair {
    pub(super) candidates: Vec<usize>,
    /// What they exchange with nothing in between.
    pub(super) free: Exchange,
    /// What they exchange past the candidates, if there are any.
    pub(super) bracket: Option<Bracket>,
}

impl Pair {
    /// Bounds on what they exchange.
    pub(super) fn bounds(&self) -> [f64; 2] {
        match &self.bracket {
            Some(bracket) => [bracket.least, bracket.most],
            None => [self.free.least(), self.free.most()],
        }
    }
}

impl FormFactors<'_> {
    /// Factor from face `from` to face `to`.
    ///
    /// With free sight between the two it is exact to rounding. Else it is integrated over what the points of `from` see (cells
    /// cut along the shadows' edges), as far as `estimate` and `most_points` of the settings go; the bound is its distance from
    /// the farther end of the bracket, proven but wide, and the estimate of the error is that of the integration, narrow but
    /// not proven.
    ///
    /// # Errors
    /// If there is no such face, or a point's factor is out of range.
    pub fn between(&self, from: usize, to: usize, settings: &FactorSettings) -> Result<Factor, Error> {
        let area = self.emitter(from)?.polygon().area();
        self.emitter(to)?;
        let Some(pair) = self.pair(from, to, settings, area.min(self.polygon(to).area())) else {
            return Ok(Factor { value: 0.0, error: 0.0, estimate: 0.0, occluders: 0 });
        };
        let [least, most] = pair.bounds();
        let (value, estimate) = match &pair.bracket {
            None => (pair.free.area / area, pair.free.error / area),
            Some(_) => self.integrate(from, to, &pair.candidates, settings)?,
        };
        let error =
            (most / area - value).max(value - least / area) * (1.0 + 4.0 * f64::EPSILON) + 2.0 * f64::EPSILON * value.abs();
        Ok(Factor { value, error, estimate, occluders: pair.candidates.len() })
    }

    /// What is known of two faces; `None` where neither has a point in front of the other, or all is proven hidden. The bracket
    /// is narrowed to its share of `area`.
    pub(super) fn pair(&self, from: usize, to: usize, settings: &FactorSettings, area: f64) -> Option<Pair> {
        if from == to {
            return None;
        }
        let (faces, polygons) = ([from, to], [self.polygon(from), self.polygon(to)]);
        let beam = Beam::from_polygon(polygons[0], polygons[1])?;
        let free = exchange(polygons[0], polygons[1]);
        if free == Exchange::default() {
            return None;
        }
        let candidates = self.index.in_beam(&beam, &faces).polygons;
        let mut pair = Pair { candidates, free, bracket: None };
        if !pair.candidates.is_empty() {
            let bracket = self.bracket(faces, &pair, settings.tolerance * area, settings.most_cells);
            // What is proven hidden has no factor.
            if bracket.most == 0.0 {
                return None;
            }
            pair.bracket = Some(bracket);
        }
        Some(pair)
    }

    /// The bracket of a pair, narrowed to a width, an area.
    pub(super) fn bracket(&self, [from, to]: [usize; 2], pair: &Pair, width: f64, most_cells: usize) -> Bracket {
        let screens = pair.candidates.iter().flat_map(|&k| &self.screens[k]).collect();
        let polygons = [self.polygon(from), self.polygon(to)];
        Between { polygons, power: self.power, screens, free: pair.free }.bracket(width, most_cells)
    }
}
