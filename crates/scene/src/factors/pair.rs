//! The factor from one face to another.

use radgrad_core::Receiver;

use super::bracket::{Between, Bracket};
use super::exchange::{Exchange, exchange};
use super::rule::nodes;
use super::{FactorSettings, FormFactors};
use crate::{Beam, Error};

/// A form factor with a proven bound.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Factor {
    /// The factor.
    pub value: f64,
    /// Proven bound on its error.
    pub error: f64,
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
            Some(bracket) => [bracket.least(), bracket.most().min(self.free.most())],
            None => [self.free.least(), self.free.most()],
        }
    }
}

impl FormFactors<'_> {
    /// Factor from face `from` to face `to`.
    ///
    /// With free sight between the two it is exact to rounding. Else the parts that are surely seen count as they are, and
    /// the rest, where a shadow's edge runs, by the share that the points of a rule see of it: that estimate is inside the
    /// bracket, and the bound is its distance from the farther end.
    ///
    /// # Errors
    /// If there is no such face, or a point's factor is out of range.
    pub fn between(&self, from: usize, to: usize, settings: &FactorSettings) -> Result<Factor, Error> {
        let area = self.emitter(from)?.polygon().area();
        self.emitter(to)?;
        let Some(pair) = self.pair(from, to, settings, area.min(self.polygon(to).area())) else {
            return Ok(Factor { value: 0.0, error: 0.0, occluders: 0 });
        };
        let [least, most] = pair.bounds();
        let value = match &pair.bracket {
            None => pair.free.area,
            Some(bracket) => self.estimate(from, to, &pair.candidates, bracket, settings)?,
        };
        let error = (most - value).max(value - least) * (1.0 + 4.0 * f64::EPSILON) / area;
        Ok(Factor { value: value / area, error: error + f64::EPSILON * value / area, occluders: pair.candidates.len() })
    }

    /// What is known of two faces; `None` where neither has a point in front of the other. The bracket is narrowed to its share
    /// of `area`.
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
        let bracket = (!candidates.is_empty()).then(|| {
            let occluders = self.polygons(&candidates);
            let between = Between { index: &self.index, faces, polygons, candidates: &candidates, occluders: &occluders };
            between.bracket(settings.bracket * area, settings.most_cells)
        });
        Some(Pair { candidates, free, bracket })
    }

    /// The exchange, with each mixed pair of cells weighted by what points of the one see of the other.
    fn estimate(
        &self,
        from: usize,
        to: usize,
        candidates: &[usize],
        bracket: &Bracket,
        settings: &FactorSettings,
    ) -> Result<f64, Error> {
        let mut sum = bracket.seen.area;
        for mixed in &bracket.mixed {
            let [cell, _] = &mixed.cells;
            let (mut seen, mut free) = (0.0, 0.0);
            for node in nodes(&cell.polygon, settings.points_per_side) {
                let receiver = Receiver::new(node.point, self.polygon(from).normal(), 1.0).map_err(Error::Receiver)?;
                let tolerance = settings.point_tolerance;
                seen += node.share * self.at_node(&receiver, from, to, candidates, tolerance)?.radiosity;
                free += node.share * self.at_node(&receiver, from, to, &[], tolerance)?.radiosity;
            }
            // The share that the points see stands for that of the cell; what they hardly see without occluders has no share.
            if free > settings.point_tolerance.sqrt() {
                sum += mixed.free.area * (seen / free);
            }
        }
        Ok(sum)
    }
}
