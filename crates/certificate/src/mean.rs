//! The certificate of the mean.

use std::sync::atomic::AtomicBool;

use radgrad_scene::{Prepared, Scene};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

use crate::error::Error;
use crate::model::Model;
use crate::paths::{Tally, Walks};
use crate::sampling::{Block, Trial, Walker};
use crate::source::Source;
use crate::{Certificate, Interval, Request};

/// Walks of one stream of random numbers.
const BLOCK: usize = 64;

/// The part of the rays that walks from lamps may need, by their pilot, before pairs are tried.
const PATIENCE: f64 = 0.1;

/// Limits of a scene's mean radiosity.
///
/// ```
/// use radgrad_certificate::{Request, certify};
/// # use radgrad_scene::{Degenerate, Scene};
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");
/// let scene = Scene::read(file, Degenerate::Refuse)?;
/// let request = Request { width: 0.2, ..Request::default() };
/// // The same seed gives the same bytes.
/// assert_eq!(certify(&scene, &request)?, certify(&scene, &request)?);
/// # Ok::<(), radgrad_certificate::Error>(())
/// ```
///
/// # Errors
/// If the request is out of range, or the scene is refused as in [`Prepared::new`].
pub fn certify(scene: &Scene, request: &Request) -> Result<Certificate, Error> {
    certify_until(scene, request, &AtomicBool::new(false))
}

/// [`certify`] that ends with [`radgrad_scene::Error::Stopped`] soon after another thread sets `stop`: it is looked at between blocks of walks.
///
/// # Errors
/// As [`certify`], and if it was ended.
pub fn certify_until(scene: &Scene, request: &Request, stop: &AtomicBool) -> Result<Certificate, Error> {
    request.check()?;
    let prepared = Prepared::new(scene)?;
    let model = Model::new(&prepared).until(stop);
    let lamps = Source::lamps(&model);
    if lamps.power() == 0.0 {
        let dark = vec![Interval { lower: 0.0, upper: 0.0 }; model.channels];
        let surfaces = vec![vec![0.0; model.channels]; model.surfaces()];
        let Request { delta, seed, .. } = *request;
        return Ok(Certificate { mean: dark.clone(), reflected: dark, surfaces, delta, seed, walks: 0, rays: 0 });
    }
    let (trial, pilots) = best(&model, lamps, request)?;
    let outcome = trial.run()?;
    let unit = trial.walker.source.power() / model.area;
    let reflected: Vec<Interval> = outcome.limits.iter().map(|limits| limits.map(|limit| limit * unit)).collect();
    let means = |(surface, sums): (usize, &[f64])| {
        let each = unit * model.area / (outcome.walks as f64 * model.area_of(surface));
        sums.iter().map(|sum| if *sum == 0.0 { 0.0 } else { sum * each }).collect()
    };
    Ok(Certificate {
        mean: reflected.iter().zip(&model.emitted).map(|(interval, emitted)| interval.map(|value| value + emitted)).collect(),
        reflected,
        surfaces: outcome.surfaces.chunks(model.channels).enumerate().map(means).collect(),
        delta: request.delta,
        seed: request.seed,
        walks: outcome.walks,
        rays: outcome.rays + pilots - trial.rays,
    })
}

/// The walks that need the least work, by pilots, and the rays of all of these.
fn best<'a>(model: &'a Model<'a>, lamps: Source, request: &Request) -> Result<(Trial<FromLamps<'a>>, u64), Error> {
    let delta = request.delta / model.channels as f64;
    let trial = |walks: Walks<'a>, source: Source, kind: u64| Trial::new(FromLamps { walks, source }, request, delta, kind);
    let ending = Walks::ending(model);
    let mut best = trial(ending.clone(), lamps, 0)?;
    let mut rays = best.rays;
    if best.work() > PATIENCE * request.rays as f64
        && let Some(pairs) = Source::pairs(model)
    {
        let other = trial(ending.clone(), pairs, 1)?;
        rays += other.rays;
        if other.work() < best.work() {
            best = other;
        }
    }
    let cut = best.cut();
    if best.is_lit()
        && let Some(mut persistent) = ending.persistent()
    {
        persistent.cut.clone_from(&cut);
        let other = trial(persistent, best.walker.source.clone(), 2)?;
        rays += other.rays;
        if other.work() < best.work() {
            best = other;
        }
    }
    best.walker.walks.cut = cut;
    Ok((best, rays))
}

/// Walks from lamps.
struct FromLamps<'a> {
    walks: Walks<'a>,
    source: Source,
}

impl Walker for FromLamps<'_> {
    fn block(&self, seed: u64, stream: u64) -> Result<Block, Error> {
        let Walks { model, .. } = &self.walks;
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(stream);
        let mut tally =
            Tally { sums: vec![0.0; model.channels], rays: 0, surfaces: vec![0.0; model.surfaces() * model.channels] };
        let mut weights = vec![0.0; model.channels];
        let mut sums = Vec::with_capacity(BLOCK * model.channels);
        for _ in 0..BLOCK {
            self.walks.model.go_on()?;
            tally.sums.fill(0.0);
            self.source.walk(&self.walks, &mut generator, &mut weights, &mut tally);
            sums.extend(tally.sums.iter().map(|sum| [*sum; 2]));
        }
        Ok(Block { sums, rays: tally.rays, surfaces: tally.surfaces })
    }

    fn ranges(&self) -> Vec<f64> {
        self.source.ranges(&self.walks)
    }

    fn deterministic_part(&self) -> Vec<f64> {
        vec![0.0; self.walks.model.channels]
    }

    fn leaves_out(&self) -> Vec<f64> {
        self.walks.cut.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rooms::{self, Room};
    use crate::sampling::tests::limits;

    #[test]
    fn walks_of_every_kind_have_the_mean_and_no_sum_beyond_its_range() -> Result<(), Error> {
        for reflectances in [[0.5; 8], [0.0, 0.9, 0.3, 0.7, 0.5, 0.2, 0.8, 0.1]] {
            let Room { scene, reflected, .. } = rooms::furnace(reflectances, false);
            let prepared = Prepared::new(&scene)?;
            let model = Model::new(&prepared);
            let ending = Walks::ending(&model);
            let persistent = ending.persistent().expect("all reflectances are below 1");
            for (kind, source) in [Source::lamps(&model), Source::pairs(&model).expect("few faces")].into_iter().enumerate() {
                for (way, cut) in [(&ending, 0.0), (&persistent, 1e-3), (&persistent, 0.1)] {
                    let walker = FromLamps { walks: Walks { cut: vec![cut], ..way.clone() }, source: source.clone() };
                    let unit = walker.source.power() * walker.ranges()[0] / model.area;
                    let [_, [low, high]] = limits(&walker, 300)?[0];
                    let [low, high] = [low * unit, (high + walker.leaves_out()[0] / walker.ranges()[0]) * unit];
                    let survival = way.survival;
                    assert!(
                        low <= reflected && reflected <= high,
                        "source {kind}, survival {survival}, cut {cut}: {low} to {high} for {reflected}"
                    );
                    assert!(high - low < 0.4 + 2.0 * unit * cut, "source {kind}, survival {survival}: {low} to {high}");
                }
            }
        }
        Ok(())
    }

    #[test]
    fn in_a_cube_of_one_grey_walks_come_to_their_range() -> Result<(), Error> {
        let Room { scene, .. } = rooms::cube(0.5);
        let prepared = Prepared::new(&scene)?;
        let model = Model::new(&prepared);
        let ending = Walks::ending(&model);
        for (walks, least) in [(ending.persistent().expect("grey"), 0.999), (ending, 0.9)] {
            let walker = FromLamps { walks: Walks { cut: vec![1e-4], ..walks }, source: Source::lamps(&model) };
            let largest_sum = walker.block(1, 0)?.sums.iter().map(|[_, high]| *high).fold(0.0, radgrad_scene::largest);
            let range = walker.ranges()[0];
            assert!((least * range..=range * (1.0 + 1e-12)).contains(&largest_sum), "{largest_sum} of {range}");
        }
        Ok(())
    }
}
