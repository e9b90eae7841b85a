//! Form factors pair by pair: the proven bracket of each against rays of the oracle, over the families of scenes.
//!
//! [`super::judge`] compares a sample of the factors of a scene sharply; here all pairs of a scene are compared with few rays, so that
//! many thousands are. From each face go [`RAYS`] rays by the cosine law from uniformly drawn points; the exact interval of the share that meets another
//! face first contains the factor with [`CONFIDENCE`]. A bracket is **outside** if it has no point in common with that interval.
//! A factor that the matrix does not store is exactly 0: its pair is tried if a ray went from one face to the other.
//!
//! The error over the bound is the distance of the value from that interval, the least that its error can be, over its bound.

use std::collections::BTreeMap;
use std::io::Write;

use radgrad_oracle::scene::Known;
use radgrad_scene::{Entry, FactorSettings, FormFactors, largest};

use super::family::{Family, Name};
use super::model::{Change, Model};
use super::table::write_rows;
use super::workers::on_all_cores;

/// Rays from each face.
pub const RAYS: u32 = 16_384;

/// That an interval contains its factor.
pub const CONFIDENCE: f64 = 1.0 - 1e-9;

/// Tolerance and effort of the brackets.
const SETTINGS: FactorSettings = FactorSettings {
    tolerance: 0.01,
    relative: 0.0,
    most_cells: 3000,
    estimate: 1e-4,
    relative_estimate: 0.0,
    most_points: 2000,
};

/// Rounding of a value of 1 or less, and of its bracket.
const ROUNDING: f64 = 1e-12;

/// The pairs of a family.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Row {
    /// Scenes.
    pub scenes: u64,
    /// Scenes without factors: refused by the program or by the oracle.
    pub refused: u64,
    /// Ordered pairs of faces.
    pub pairs: u64,
    /// Those with a face that may be in between.
    pub past_occluders: u64,
    /// Those whose bracket rays refute.
    pub outside: u64,
    /// Those whose bound is above the tolerance.
    pub unmet: u64,
    /// Largest error that rays prove, over the bound.
    pub error_over_bound: f64,
}

/// A bracket that rays refute.
#[derive(Debug, Clone, PartialEq)]
pub struct Outside {
    /// The scene.
    pub name: Name,
    /// The two faces, the bracket and the interval that rays give.
    pub said: String,
}

/// All pairs of a run.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Brackets {
    /// By family.
    pub rows: BTreeMap<Family, Row>,
    /// In the order of the scenes.
    pub outside: Vec<Outside>,
}

impl Brackets {
    /// At least so many pairs, of as many scenes of each family, on all cores. `done` is called after each scene, from any thread.
    pub fn measure(families: &[Family], pairs: u64, seed: u64, done: impl Fn(Name, &Row) + Sync) -> Self {
        let mut brackets = Self::default();
        // Each scene has a pair, but for families that have none at all.
        for index in (0..).take_while(|index| index <= &pairs) {
            if brackets.pairs() >= pairs {
                break;
            }
            let names: Vec<Name> = families.iter().map(|&family| Name { family, seed, index }).collect();
            let rows = on_all_cores(&names, |&name| {
                let judgement = judged(&name.model(), seed, |entry| entry);
                done(name, &judgement.0);
                judgement
            });
            for (name, (row, outside)) in names.into_iter().zip(rows) {
                brackets.rows.entry(name.family).or_default().add(&row);
                brackets.outside.extend(outside.into_iter().map(|said| Outside { name, said }));
            }
        }
        brackets
    }

    /// Pairs tried.
    #[must_use]
    pub fn pairs(&self) -> u64 {
        self.rows.values().map(|row| row.pairs).sum()
    }

    /// The rows as CSV.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, out: impl Write) -> Result<(), csv::Error> {
        write_rows(out, &HEADER, self.rows.iter().map(|(family, row)| row.cells(*family)))
    }
}

/// Columns of the table.
pub const HEADER: [&str; 8] = ["family", "scenes", "refused", "pairs", "past_occluders", "outside", "unmet", "error_over_bound"];

impl Row {
    /// The cells of a line of the table.
    #[must_use]
    pub fn cells(&self, family: Family) -> [String; 8] {
        let Self { scenes, refused, pairs, past_occluders, outside, unmet, error_over_bound } = *self;
        let [scenes, refused, pairs, past, outside, unmet] =
            [scenes, refused, pairs, past_occluders, outside, unmet].map(|count| count.to_string());
        [family.name().to_owned(), scenes, refused, pairs, past, outside, unmet, format!("{error_over_bound:.2}")]
    }

    fn add(&mut self, other: &Self) {
        self.scenes += other.scenes;
        self.refused += other.refused;
        self.pairs += other.pairs;
        self.past_occluders += other.past_occluders;
        self.outside += other.outside;
        self.unmet += other.unmet;
        self.error_over_bound = largest(self.error_over_bound, other.error_over_bound);
    }
}

/// The pairs of a scene, and a sentence for each one that rays refute. `changed` alters an entry before it is compared: a test plants
/// faults by it.
fn judged(model: &Model, seed: u64, changed: impl Fn(Entry) -> Entry) -> (Row, Vec<String>) {
    let model = Model { change: Change::None, ..model.clone() };
    let (mut row, mut wrong) = (Row { scenes: 1, ..Row::default() }, Vec::new());
    let refused = Row { refused: 1, ..row };
    let (Ok(scene), Ok(oracle)) = (model.scene(), model.oracle(0)) else { return (refused, wrong) };
    let Ok(matrix) = FormFactors::new(&scene).and_then(|factors| factors.matrix(&SETTINGS, || ())) else {
        // Scenes that must have an answer are held to it by the campaign of scenes.
        return (refused, wrong);
    };
    for from in 0..model.parts.len() {
        let Ok(seen) = oracle.sights(from, RAYS, seed, CONFIDENCE) else { return (refused, wrong) };
        let mut entries: Vec<Option<Entry>> = vec![None; seen.len()];
        matrix.row(from).map(&changed).for_each(|entry| entries[entry.face] = Some(entry));
        for (to, (known, entry)) in seen.iter().zip(entries).enumerate().filter(|(to, _)| *to != from) {
            if entry.is_none() && known.value == 0.0 {
                continue;
            }
            let [value, lower, upper, error] =
                entry.map_or([0.0; 4], |entry| [entry.factor, entry.lower, entry.upper, entry.error]);
            row.pairs += 1;
            row.past_occluders += u64::from(entry.is_some_and(|entry| entry.occluders > 0));
            row.unmet += u64::from(error > SETTINGS.tolerance);
            let over_bound = least_error(value, known) / (error + ROUNDING);
            row.error_over_bound = largest(row.error_over_bound, over_bound);
            let is_held = lower <= known.interval.high + ROUNDING && upper >= known.interval.low - ROUNDING;
            // A bracket or a bound that is no number holds nothing.
            if !(is_held && over_bound <= 1.0) {
                row.outside += 1;
                let interval = known.interval;
                wrong.push(format!(
                    "from face {from} to face {to}: {value:e} in [{lower:e}, {upper:e}], by rays in [{:e}, {:e}]",
                    interval.low, interval.high
                ));
            }
        }
    }
    (row, wrong)
}

/// The distance of a value from the interval that rays give.
fn least_error(value: f64, known: &Known) -> f64 {
    largest(largest(known.interval.low - value, value - known.interval.high), 0.0)
}

#[cfg(test)]
mod tests {
    use super::super::model::Expected;
    use super::*;

    #[test]
    fn brackets_contain_what_rays_say_and_moved_ones_do_not() {
        let (mut pairs, mut refuted) = (0, 0);
        for family in [Family::ALL[0], Family::ALL[1]] {
            let model = Name { family, seed: 5, index: 0 }.model();
            if model.expected == Expected::Refusal {
                continue;
            }
            let (row, wrong) = judged(&model, 1, |entry| entry);
            assert!(wrong.is_empty() && row.outside == 0 && row.error_over_bound <= 1.0, "{row:?} {wrong:?}");
            pairs += row.pairs;
            let moved =
                |entry: Entry| Entry { factor: entry.factor + 0.2, lower: entry.lower + 0.2, upper: entry.upper + 0.2, ..entry };
            let none = |entry: Entry| Entry { factor: f64::NAN, lower: f64::NAN, upper: f64::NAN, ..entry };
            refuted += judged(&model, 1, moved).0.outside;
            let (row, wrong) = judged(&model, 1, none);
            assert!(row.outside > 0 && row.outside == wrong.len() as u64);
        }
        assert!(pairs > 0 && refuted > 0, "{pairs} {refuted}");
    }
}
