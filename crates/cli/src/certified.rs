//! The certificates of a solve: which are asked for, how much work they may take, and whether one contradicts the solution.
//!
//! They are made of the scene alone, by random walks (`radgrad-certificate`). What work they take is counted in rays, from the work of the solve
//! and never from a clock, so that they are the same on every machine.

use std::str::FromStr;

use clap::Args;
use radgrad_certificate::{Certificate, Error, Interval, Place, PointCertificate, Request, certify, certify_points};
use radgrad_scene::Scene;
use radgrad_solver::Solution;

use crate::solve::fraction;

/// The half-width asked for unless a width is given, over the error asked of the solution.
const SHARPER: f64 = 1.0 / 3.0;

/// Rays for each link of the solution and for each of its elements, which take about a third of its time, and the least and the most of them.
const RAYS_A_LINK: u64 = 100;
const RAYS_AN_ELEMENT: u64 = 200;
const RAYS: [u64; 2] = [100_000, 20_000_000];

/// The most rays where a width is given.
const RAYS_FOR_WIDTH: u64 = 200_000_000;

/// Rays of each point that is certified.
pub const RAYS_A_POINT: u64 = 100_000;

/// Surfaces that a contradiction names.
const NAMED: usize = 5;

/// What rounding may change of a mean, over it.
const ROUNDING: f64 = 1e-12;

/// One of the words of `--certify`.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Word {
    Width(f64),
    Points,
    Off,
}

impl FromStr for Word {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "points" => Ok(Self::Points),
            "off" => Ok(Self::Off),
            width => fraction(width)
                .map(Self::Width)
                .map_err(|reason| format!("expected `points`, `off` or a half-width such as `0.5%`: {reason}")),
        }
    }
}

/// The options about certificates.
#[derive(Debug, Args)]
pub(crate) struct Certifying {
    /// Certify the mean to `0.5%`, or `points` too, or `off`.
    ///
    /// A width is the interval's half-width over the reflected mean, for 200 million rays at most; `points` are those of --points;
    /// `0.5%,points` is both. By default the mean is certified, for about a third of the solve's time.
    #[arg(long, value_name = "WHAT", value_delimiter = ',')]
    certify: Vec<Word>,
    /// Probability that a certificate fails.
    #[arg(long, value_name = "P", default_value_t = 1e-6, value_parser = probability, help_heading = crate::solve::EXPERT)]
    confidence: f64,
    /// Seed of the certificates.
    #[arg(long, value_name = "N", default_value_t = 1, help_heading = crate::solve::EXPERT)]
    seed: u64,
}

fn probability(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().map_err(|error| error.to_string())?;
    if value > 0.0 && value < 1.0 { Ok(value) } else { Err(format!("{value} is not above 0 and below 1")) }
}

impl Certifying {
    /// Refuses a request that is made twice, or of points that are not there.
    pub(crate) fn check(&self, has_points: bool) -> Result<(), String> {
        let count = |is: fn(&Word) -> bool| self.certify.iter().filter(|word| is(word)).count();
        if self.certify.contains(&Word::Off) && self.certify.len() > 1 {
            return Err("--certify off is with another --certify: leave one of them out".to_owned());
        }
        if count(|word| matches!(word, Word::Width(_))) > 1 {
            return Err("--certify has two widths: leave one of them out".to_owned());
        }
        if self.wants_points() && !has_points {
            return Err("--certify points has no points: give --points".to_owned());
        }
        Ok(())
    }

    pub(crate) fn is_off(&self) -> bool {
        self.certify.contains(&Word::Off)
    }

    pub(crate) fn wants_points(&self) -> bool {
        self.certify.contains(&Word::Points)
    }

    /// The half-width that is asked for.
    pub(crate) fn width(&self) -> Option<f64> {
        self.certify.iter().find_map(|word| if let Word::Width(width) = word { Some(*width) } else { None })
    }

    fn request(&self, solution: &Solution, error: f64) -> Request {
        // Points have the other half.
        let delta = if self.wants_points() { 0.5 * self.confidence } else { self.confidence };
        Request { delta, seed: self.seed, ..requested(solution, error, self.width()) }
    }

    /// The mean's certificate, unless it is off.
    pub(crate) fn mean(&self, scene: &Scene, solution: &Solution, error: f64) -> Result<Option<Certificate>, Error> {
        if self.is_off() {
            return Ok(None);
        }
        let certificate = certify(scene, &self.request(solution, error))?;
        Ok(Some(Certificate { delta: self.confidence, ..certificate }))
    }

    /// Those of points.
    pub(crate) fn points(
        &self,
        (scene, solution): (&Scene, &Solution),
        places: &[Place],
        error: f64,
    ) -> Result<Vec<Result<PointCertificate, Error>>, Error> {
        certify_points(scene, places, &Request { rays: RAYS_A_POINT, ..self.request(solution, error) })
    }
}

/// The request for a half-width; by default for one by the error asked of the solution, with the rays that its work allows.
pub(crate) fn requested(solution: &Solution, error: f64, width: Option<f64>) -> Request {
    let rays = if width.is_some() { RAYS_FOR_WIDTH } else { rays(solution) };
    Request { width: width.unwrap_or(SHARPER * error), rays, ..Request::default() }
}

fn rays(solution: &Solution) -> u64 {
    let progress = solution.progress();
    let [links, elements] = [progress.links, progress.elements].map(|count| count as u64);
    let counted = links.saturating_mul(RAYS_A_LINK).saturating_add(elements.saturating_mul(RAYS_AN_ELEMENT));
    counted.clamp(RAYS[0], RAYS[1])
}

/// Whether a value within its estimate, and rounding, is nowhere in an interval.
pub(crate) fn contradicts(value: f64, estimate: f64, certified: &Interval) -> bool {
    let off = estimate + ROUNDING * value.abs();
    value + off < certified.lower || value - off > certified.upper
}

/// A sentence for each channel in which the mean within its estimate is not in its certificate.
pub(crate) fn contradictions(scene: &Scene, solution: &Solution, certificate: &Certificate) -> Vec<String> {
    let estimates = solution.mean_estimate();
    let values = solution.mean().iter().zip(&estimates).map(|(mean, estimate)| (*mean, estimate.total()));
    let found = values.zip(&certificate.mean).enumerate();
    let contradicted = found.filter(|(_, ((mean, estimate), certified))| contradicts(*mean, *estimate, certified));
    contradicted
        .map(|(channel, ((mean, estimate), Interval { lower, upper }))| {
            format!(
                "channel `{}`: the mean radiosity {mean:.6e} with its estimate {estimate:.1e} contradicts its certificate, from {lower:.6e} to \
                 {upper:.6e} but for a probability of {:e}: do not trust it; reflected means differ most on {}",
                solution.channels()[channel],
                certificate.delta,
                differing(scene, solution, certificate, channel),
            )
        })
        .collect()
}

/// The surfaces that make up most of the difference of the means, with both of theirs.
fn differing(scene: &Scene, solution: &Solution, certificate: &Certificate, channel: usize) -> String {
    let found = solution.by_surface(scene);
    let each = scene.surfaces().iter().zip(&found).zip(&certificate.surfaces);
    let both = each.filter_map(|((surface, of), walks)| {
        let [solved, walked] = [*of.reflected.get(channel)?, *walks.get(channel)?];
        Some((of.area * (solved - walked).abs(), surface.name(), solved, walked))
    });
    let mut differing: Vec<_> = both.filter(|(by, ..)| *by > 0.0).collect();
    differing.sort_by(|a, b| b.0.total_cmp(&a.0));
    let named =
        differing.iter().take(NAMED).map(|(_, name, solved, walked)| format!("`{name}` ({solved:.4e}, by walks {walked:.4e})"));
    named.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use radgrad_core::{DVec3, Polygon};
    use radgrad_solver::{Options, solve};

    use super::*;

    /// A unit cube whose ceiling emits, and whose floor reflects so much.
    fn cube(floor: f64) -> Scene {
        let mut scene = Scene::new(["grey", "dark"]).unwrap();
        let [floor, grey, lamp] = [("floor", floor, 0.0), ("grey", 0.5, 0.0), ("lamp", 0.5, 1.0)]
            .map(|(name, rho, radiance)| scene.add_material(name, [rho, 0.5], [radiance, 0.0]).unwrap());
        let [o, x, y, z] = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let faces = [("floor", floor, o, x, y), ("ceiling", lamp, z, y, x), ("front", grey, o, z, x), ("back", grey, y, x, z)];
        for (name, material, origin, a, b) in faces.into_iter().chain([("left", grey, o, y, z), ("right", grey, x, z, y)]) {
            let surface = scene.add_surface(name);
            let polygon = Polygon::new(vec![origin, origin + a, origin + a + b, origin + b]).unwrap();
            scene.add_face(surface, material, polygon, None).unwrap();
        }
        scene
    }

    #[test]
    fn a_contradiction_is_said_with_the_surface_that_differs_most() {
        let (solved, walked) = (cube(0.5), cube(0.9));
        let solution = solve(&solved, &Options { error: 0.01, ..Options::default() }, |_| true).unwrap();
        let of = |scene: &Scene| certify(scene, &Request { width: 0.02, ..Request::default() }).unwrap();
        assert!(contradictions(&solved, &solution, &of(&solved)).is_empty());
        let said = contradictions(&solved, &solution, &of(&walked));
        assert_eq!(said.len(), 1, "nothing is wrong in the dark channel: {said:?}");
        let (both, surfaces) = said[0].split_once("differ most on ").unwrap();
        assert!(both.contains("channel `grey`") && both.contains(&format!("{:.6e}", solution.mean()[0])), "{both}");
        assert!(surfaces.starts_with("`floor`") && surfaces.matches("by walks").count() == NAMED, "{surfaces}");
    }

    #[test]
    fn an_interval_is_contradicted_from_beside_it_alone() {
        let interval = Interval { lower: 1.0, upper: 2.0 };
        for (value, estimate, is) in
            [(0.8, 0.1, true), (0.8, 0.3, false), (1.5, 0.0, false), (2.2, 0.1, true), (2.0 + 1e-15, 0.0, false)]
        {
            assert_eq!(contradicts(value, estimate, &interval), is, "{value} {estimate}");
        }
        assert!(!contradicts(f64::MAX, 0.0, &Interval { lower: 1.0, upper: f64::INFINITY }));
    }

    #[test]
    fn words_are_a_width_points_or_off() {
        assert_eq!(["0.5%", "points", "off"].map(str::parse), [Ok(Word::Width(0.005)), Ok(Word::Points), Ok(Word::Off)]);
        assert!("all".parse::<Word>().unwrap_err().contains("expected `points`, `off` or a half-width"));
    }
}
