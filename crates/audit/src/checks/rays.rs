//! Factors by rays: the factors, intervals and products that the counts of the rays make, worked out here from the counts alone; and the counts
//! against factors by brackets.
//!
//! Nothing here is by the code that it judges: multipliers are found one face after the other, and limits by their equations.

mod model;
mod products;

use glam::DVec3;
use radgrad_core::Polygon;
use radgrad_scene::{
    BlockOperator, FactorOperator, FactorSettings, FormFactors, RayFactors, RayRow, RaySettings, Scene, largest,
};

use crate::cases::sampler::Sampler;
use crate::measures::measure::is_worse;
use crate::scenes::draw::quad;
use crate::scenes::pieces::scene_of;
use model::{Counts, Model, ROUNDED};

/// How accurately the truth is known.
const TRUTH: f64 = 2e-5;

/// Rays from each face.
const RAYS: u32 = 1500;

/// Walls of a long room in tiles of unlike sizes, with a plate, a triangle and a pentagon in it.
fn room(index: u64) -> Result<Scene, String> {
    let s = &mut Sampler::new(41, "rays", index);
    let is_closed = index.is_multiple_of(2);
    let size = [1.0, s.between(0.9, 1.3), s.between(2.2, 3.0)];
    let (cut, half) = (s.between(0.27, 0.33), s.between(0.45, 0.55));
    let mut faces: Vec<Vec<DVec3>> = Vec::new();
    for axis in 0..3 {
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        for is_high in [false, true] {
            for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                if axis == 2 && is_high && i + j == 2 && !is_closed {
                    continue;
                }
                let [across, up] = [[0.0, cut, 1.0], [0.0, half, 1.0]];
                let corner = |k: usize, l: usize| {
                    let mut p = [0.0; 3];
                    (p[axis], p[u], p[v]) = (if is_high { size[axis] } else { 0.0 }, across[k] * size[u], up[l] * size[v]);
                    DVec3::from(p)
                };
                let mut outline = vec![corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
                if is_high {
                    outline.reverse();
                }
                faces.push(outline);
            }
        }
    }
    let middle = DVec3::new(0.5, 0.5, 1.1);
    let plate = [(-0.25, -0.2), (0.2, -0.25), (0.25, 0.2), (-0.2, 0.25)].map(|(x, y)| middle + DVec3::new(x, y, 0.1 * x));
    faces.push(plate.to_vec());
    faces.push(plate.into_iter().rev().collect());
    faces.push([(0.3, 0.2), (0.6, 0.3), (0.4, 0.7)].map(|(x, y)| DVec3::new(x, y, 0.4)).to_vec());
    let pentagon = [(0.3, 0.3), (0.6, 0.2), (0.8, 0.5), (0.5, 0.8), (0.25, 0.6)];
    faces.push(pentagon.map(|(x, y)| DVec3::new(x, y, 1.8 + 0.2 * y)).into_iter().rev().collect());
    scene_of(faces)
}

/// Everything that is wrong in so many scenes.
#[must_use]
pub fn all_wrong(scenes: u64) -> Vec<String> {
    let mut findings = grids();
    for told in [whole_block(), one_to_one()] {
        findings.extend(told.unwrap_or_else(|error| vec![error]));
    }
    for index in 0..scenes {
        let wrong = in_room(index).unwrap_or_else(|error| vec![error]);
        findings.extend(wrong.into_iter().map(|finding| format!("rays {index}: {finding}")));
    }
    findings
}

/// The rays of a face fill a grid: sides are the least and largest whole numbers that the rule names.
fn grids() -> Vec<String> {
    let mut findings = Vec::new();
    for (tolerance, confidence, faces) in [(0.01, 0.99, 1), (0.02, 0.99, 1000), (0.3, 0.5, 3), (0.004, 0.999, 70)] {
        let settings = RaySettings { tolerance, confidence, ..RaySettings::default() };
        let intervals = (faces * (faces + 1) / 2) as f64;
        let wanted = ((2.0 * intervals / (1.0 - confidence)).ln() / (2.0 * tolerance * tolerance)).ceil();
        findings.extend(grid(&settings, faces, wanted));
    }
    for rays in [1, 2, 63, 64, 65, 728, 729, 1000, 4096, 5000, 123_456] {
        findings.extend(grid(&RaySettings { rays: Some(rays), ..RaySettings::default() }, 10, f64::from(rays)));
    }
    findings
}

fn grid(settings: &RaySettings, faces: usize, wanted: f64) -> Option<String> {
    let origins = (1..100).map(f64::from).take_while(|side| side.powi(6) <= wanted).fold(1.0, largest);
    let directions = (1..100_000).map(f64::from).find(|side| (side * origins).powi(2) >= wanted)?;
    let expected = (origins * directions).powi(2);
    match settings.rays_for(faces) {
        Ok(rays) if rays as f64 == expected => None,
        other => Some(format!("{wanted} rays are wanted of each of {faces} faces: {other:?}, the grid has {expected}")),
    }
}

fn in_room(index: u64) -> Result<Vec<String>, String> {
    let said = |error: radgrad_scene::Error| error.to_string();
    let scene = room(index)?;
    let factors = FormFactors::new(&scene).map_err(said)?;
    let settings = RaySettings { rays: Some(RAYS), seed: 3 + index, ..RaySettings::default() };
    let rows = factors.faces().len();
    // In two parts, as of two machines.
    let mut counted = factors.count_rays(rows / 3..rows, &settings, |_| ()).map_err(said)?;
    counted.extend(factors.count_rays(0..rows / 3, &settings, |_| ()).map_err(said)?);
    let truth =
        factors.matrix(&FactorSettings { tolerance: 0.1, estimate: 1e-5, ..FactorSettings::default() }, || ()).map_err(said)?;
    let asked = Counts { scene: &scene, factors: &factors, settings, counted, truth };
    let whole = asked.made(settings)?;
    let mut findings = asked.judged(&whole, 0.0)?;
    findings.extend(near(&asked, &whole).map_err(said)?);
    findings.extend(products::wrong(&asked, &whole)?);
    findings.extend(read_back(&whole));
    let least = 4e-3;
    let fewer = whole.clone().without_below(least);
    if fewer.stored() >= whole.stored() {
        findings.push(format!("no factor is below {least}"));
    }
    findings.extend(asked.judged(&fewer, least)?.into_iter().map(|finding| format!("of those from {least} on, {finding}")));
    findings.extend(rare(&asked)?);
    Ok(findings)
}

impl Counts<'_> {
    fn made(&self, settings: RaySettings) -> Result<RayFactors, String> {
        self.factors.by_rays(self.counted.clone(), &settings).map_err(|error| error.to_string())
    }

    /// Rows against those of the counts, and against the truth.
    fn judged(&self, factors: &RayFactors, least: f64) -> Result<Vec<String>, String> {
        let rows = factors.rows(0..factors.faces().len());
        let model = Model::new(self, &rows, least)?;
        let mut findings = model.differences(factors, &rows);
        let mut one_by_one = Vec::new();
        let each = factors.each_row(|row| -> Result<(), ()> {
            one_by_one.push(row);
            Ok(())
        });
        if each.is_err() || one_by_one != rows {
            findings.push("rows one by one are not those at once".to_owned());
        }
        let some = 3..factors.faces().len() - 5;
        if factors.rows(some.clone()) != rows[some] {
            findings.push("some rows are not those of all".to_owned());
        }
        if least == 0.0 {
            findings.extend(self.off(factors, &rows));
        }
        Ok(findings)
    }

    /// Intervals that miss the truth, and errors of factors beside their deviation by chance.
    fn off(&self, factors: &RayFactors, rows: &[RayRow]) -> Vec<String> {
        let mut findings = Vec::new();
        let (mut squares, mut expected, mut widest) = (0.0, 0.0, 0.0);
        for RayRow { face, entries, open } in rows {
            for entry in entries {
                let truth = self.truth.factor(*face, entry.face);
                if !(entry.lower - TRUTH <= truth && truth <= entry.upper + TRUTH) {
                    findings.push(format!("the factor {face} to {} is {truth}, the interval {entry:?}", entry.face));
                }
                if !entry.is_exact {
                    // Of this face's trials alone: those of both deviate less.
                    let ratio = largest(1.0, self.truth.areas()[entry.face] / self.truth.areas()[*face]);
                    squares += (entry.factor - truth).powi(2);
                    expected += truth * (1.0 - truth) * ratio / factors.rays() as f64;
                    if self.truth.areas()[*face] <= self.truth.areas()[entry.face] {
                        widest = largest(widest, 0.5 * (entry.upper - entry.lower));
                    }
                }
            }
            let truth = 1.0 - self.truth.sum(*face).factor;
            if !(open.lower - 1e-4 <= truth && truth <= open.upper + 1e-4) {
                findings.push(format!("face {face} is open to {truth}, the interval is {open:?}"));
            }
        }
        // One ray a cell of a grid: there is no less chance than a few in a hundred of it.
        if !(0.05..=1.0).contains(&(squares / expected)) {
            findings.push(format!("the squares of the errors are {squares:e}, by chance {expected:e}"));
        }
        if is_worse((factors.widest() - widest).abs(), ROUNDED * widest) {
            findings.push(format!("the widest interval has {}, that of the rows {widest}", factors.widest()));
        }
        findings
    }
}

/// Pairs that are near and in free sight: exact, with the bounds of a factor of so many digits, and among them all that share a corner and have
/// nothing in between.
fn near(asked: &Counts<'_>, factors: &RayFactors) -> Result<Vec<String>, radgrad_scene::Error> {
    let mut findings = Vec::new();
    let settings = FactorSettings { relative_estimate: 1e-6, estimate: 1e-6, ..FactorSettings::default() };
    let polygons: Vec<&Polygon> = asked.scene.polygons().collect();
    for RayRow { face, entries, .. } in factors.rows(0..factors.faces().len()) {
        for entry in entries {
            let [from, to] = [polygons[face], polygons[entry.face]];
            let is_free = asked.truth.row(face).any(|other| other.face == entry.face && other.occluders == 0);
            let touch = is_free && from.vertices().iter().any(|a| to.vertices().contains(a));
            let truth = asked.truth.factor(face, entry.face);
            if touch && !entry.is_exact {
                findings.push(format!("the factor {face} to {} of neighbours is by rays", entry.face));
            }
            if entry.is_exact && is_worse((entry.factor - truth).abs(), entry.upper - entry.factor + TRUTH) {
                findings.push(format!("the factor {face} to {} is {truth}, not {}", entry.face, entry.factor));
            }
            if entry.is_exact && face < entry.face {
                let bound = asked.factors.between(face, entry.face, &settings)?;
                let room = 1e-3 * (bound.upper - bound.lower);
                if is_worse(entry.lower, bound.lower + room) || is_worse(bound.upper - room, entry.upper) {
                    findings.push(format!("the factor {face} to {} is {entry:?}, proven is {bound:?}", entry.face));
                }
            }
        }
    }
    Ok(findings)
}

/// Factors as bytes, whole and in part.
fn read_back(factors: &RayFactors) -> Vec<String> {
    let bytes = factors.to_bytes();
    let mut findings = Vec::new();
    if RayFactors::from_bytes(&bytes).ok().as_ref() != Some(factors) {
        findings.push("factors that were kept are others".to_owned());
    }
    // The logarithm, the confidence, the first area and the first multiplier.
    let first = 64 + 4 * factors.faces().len();
    let places = [(40, false), (48, false), (first, false), (first + 8 * factors.len(), true)];
    findings.extend(products::damaged(&bytes, 32, &places, |bytes| RayFactors::from_bytes(bytes).is_ok()));
    let longer = [&bytes[..], &[0]].concat();
    let parts = [0, 15, 16, 40, bytes.len() / 3, bytes.len() - 1].map(|end| &bytes[..end]);
    for part in parts.into_iter().chain([&longer[..], &bytes[1..]]) {
        if RayFactors::from_bytes(part).is_ok() {
            findings.push(format!("{} bytes of {} are taken for factors", part.len(), bytes.len()));
        }
    }
    findings
}

/// As many faces as a block has places on a side, of which few meet each other's rays: they stay one block, which is read back.
fn whole_block() -> Result<Vec<String>, String> {
    let said = |error: radgrad_scene::Error| error.to_string();
    let tile = |k: u32| quad(DVec3::new(f64::from(k % 16), f64::from(k / 16), 0.0), DVec3::X * 0.5, DVec3::Y * 0.5);
    let mut above = quad(DVec3::new(7.0, 7.0, 8.0), DVec3::X, DVec3::Y);
    above.reverse();
    let scene = scene_of((0..255).map(tile).chain([above]).collect())?;
    let factors = FormFactors::new(&scene).map_err(said)?;
    let settings = RaySettings { rays: Some(4), seed: 5, ..RaySettings::default() };
    let counted = factors.count_rays(0..256, &settings, |_| ()).map_err(said)?;
    let operator = FactorOperator::new(factors.by_rays(counted, &settings).map_err(said)?);
    let blocks = operator.blocks(&factors.middles(), 1e-9).map_err(said)?;
    let back = BlockOperator::from_bytes(&blocks.to_bytes());
    Ok((back.ok().as_ref() != Some(&blocks)).then(|| "a block of 256 faces is another one".to_owned()).into_iter().collect())
}

/// Sixteen tiles, each close under one of sixteen others, in a block that has their sums alone: all of them get the light of one.
fn one_to_one() -> Result<Vec<String>, String> {
    const TILES: u32 = 16;
    let said = |error: radgrad_scene::Error| error.to_string();
    let tile = |k: u32, z: f64| quad(DVec3::new(1.25 * f64::from(k), 0.0, z), DVec3::X, DVec3::Y);
    let above = (0..TILES).map(|k| tile(k, 0.1).into_iter().rev().collect());
    let scene = scene_of((0..TILES).map(|k| tile(k, 0.0)).chain(above).collect())?;
    let factors = FormFactors::new(&scene).map_err(said)?;
    let settings = RaySettings { rays: Some(4000), seed: 6, ..RaySettings::default() };
    let counted = factors.count_rays(0..2 * TILES as usize, &settings, |_| ()).map_err(said)?;
    let operator = FactorOperator::new(factors.by_rays(counted, &settings).map_err(said)?);
    // Not where they are: four that are side by side below are over four quarters.
    let middles: Vec<DVec3> = (0..TILES)
        .map(|k| DVec3::new(f64::from(k), 0.0, 0.0))
        .chain((0..TILES).map(|k| DVec3::new(f64::from(4 * (k % 4) + k / 4), 0.0, 100.0)))
        .collect();
    let blocks = operator.blocks(&middles, 0.8).map_err(said)?;
    let mut findings = Vec::new();
    for sends in [16, 21, 31] {
        let q: Vec<f64> = (0..2 * TILES).map(|face| f64::from(u8::from(face == sends))).collect();
        let (plain, in_blocks) = (operator.certified(&q).map_err(said)?, blocks.certified(&q).map_err(said)?);
        for face in 0..q.len() {
            let apart = (in_blocks.product[face] - plain.product[face]).abs();
            let more = in_blocks.error[face] - plain.error[face];
            if is_worse(apart, more + 2e-6) {
                findings
                    .push(format!("of what {sends} sends {face} gets {apart} less or more in blocks, the error is {more} more"));
            }
        }
    }
    Ok(findings)
}

/// A few rays a face: an unseen factor then has the upper limit of both directions together.
fn rare(asked: &Counts<'_>) -> Result<Vec<String>, String> {
    let said = |error: radgrad_scene::Error| error.to_string();
    let mut findings = Vec::new();
    for rays in [1, 4, 40] {
        let settings = RaySettings { rays: Some(rays), ..asked.settings };
        let rows = asked.factors.faces().len();
        let counted = asked.factors.count_rays(0..rows, &settings, |_| ()).map_err(said)?;
        let factors = asked.factors.by_rays(counted, &settings).map_err(said)?;
        let expected = model::absent(factors.rays() as f64, model::logarithm(rows, settings.confidence));
        if is_worse((factors.absent() - expected).abs(), ROUNDED) {
            findings.push(format!("with {rays} rays a factor that is not there is {} at most, not {expected}", factors.absent()));
        }
    }
    Ok(findings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_by_rays_are_those_of_their_counts() {
        assert_eq!(all_wrong(2), Vec::<String>::new());
    }
}
