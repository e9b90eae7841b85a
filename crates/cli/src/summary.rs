//! The result: as one JSON object, or as a table by surface.

use std::fmt;

use radgrad_certificate::Certificate;
use radgrad_scene::{Modelling, Scene, printable};
use radgrad_solver::{Solution, SurfaceRadiosity};
use serde::Serialize;

use crate::photometry::Photometry;

/// The widest name that stands in the line of its numbers.
const NAME: usize = 26;

/// The output of `--summary`.
#[derive(Debug, Serialize)]
pub(crate) struct Summary {
    /// From the start of reading to the end of solving.
    seconds: f64,
    rounds: usize,
    elements: usize,
    links: usize,
    /// Estimate of the error of the mean over the mean radiosity that is reflected, the largest of the channels.
    estimate: f64,
    /// The estimate asked for.
    error: f64,
    /// The probability that a certificate fails, and the seed of their random numbers.
    #[serde(skip_serializing_if = "Option::is_none")]
    confidence: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    seed: Option<u64>,
    /// In the unit of the scene.
    channels: Vec<Channel>,
    surfaces: Vec<Surface>,
    /// The rounding of the scene's coordinates, and the changes that reading made for it.
    modelling: Modelling,
    /// Properties of the scene that are probably not meant.
    warnings: Vec<String>,
}

#[derive(Debug, Serialize)]
struct Channel {
    name: String,
    /// Over all area, with the emission of faces.
    mean: f64,
    /// The part of it that is reflected.
    reflected: f64,
    estimate: f64,
    /// The ends of the interval that has the mean; an infinite one is written as null.
    #[serde(skip_serializing_if = "Option::is_none")]
    certified: Option<[f64; 2]>,
    /// The same of the part that is reflected.
    #[serde(skip)]
    certified_reflected: Option<[f64; 2]>,
}

/// A surface's radiosity, a number for each channel; none where it exchanges no light.
#[derive(Debug, Serialize)]
struct Surface {
    name: String,
    /// None if it is beyond the range of a double.
    #[serde(skip_serializing_if = "Option::is_none")]
    area: Option<f64>,
    mean: Vec<f64>,
    least: Vec<f64>,
    largest: Vec<f64>,
    /// The luminous flux that leaves it, where that was asked for and lengths are metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    lumens: Option<f64>,
}

impl Summary {
    /// With the luminous flux of surfaces.
    pub(crate) fn lit(mut self, photometry: &Photometry) -> Self {
        for surface in self.surfaces.iter_mut().filter(|surface| !surface.mean.is_empty()) {
            surface.lumens = surface.area.map(|area| area * photometry.of(&surface.mean));
        }
        self
    }

    pub(crate) fn of(solution: &Solution, scene: &Scene, certificate: Option<&Certificate>, error: f64, seconds: f64) -> Self {
        let progress = solution.progress();
        let estimates = solution.mean_estimate();
        let channel = |(index, name): (usize, &String)| {
            let ends = |of: &[radgrad_certificate::Interval]| of.get(index).map(|of| [of.lower, of.upper]);
            Channel {
                name: name.clone(),
                mean: solution.mean()[index],
                reflected: solution.reflected()[index],
                estimate: estimates[index].total(),
                certified: certificate.and_then(|of| ends(&of.mean)),
                certified_reflected: certificate.and_then(|of| ends(&of.reflected)),
            }
        };
        let channels: Vec<Channel> = solution.channels().iter().enumerate().map(channel).collect();
        let surface = |(surface, of): (&radgrad_scene::Surface, SurfaceRadiosity)| {
            let SurfaceRadiosity { area, mean, least, largest, .. } = of;
            let area = Some(area).filter(|area| area.is_finite());
            Surface { name: surface.name().to_owned(), area, mean, least, largest, lumens: None }
        };
        Self {
            seconds,
            rounds: progress.round,
            elements: progress.elements,
            links: progress.links,
            estimate: progress.estimate,
            error,
            confidence: certificate.map(|of| of.delta),
            seed: certificate.map(|of| of.seed),
            channels,
            surfaces: scene.surfaces().iter().zip(solution.by_surface(scene)).map(surface).collect(),
            modelling: scene.modelling(),
            warnings: solution.warnings().iter().map(ToString::to_string).collect(),
        }
    }

    /// A line for each surface in a channel.
    fn surfaces(&self, f: &mut fmt::Formatter<'_>, channel: usize) -> fmt::Result {
        let heads = ["area", "mean", "least", "largest"].map(|head| format!("{head:>11}")).join("  ");
        writeln!(f, "{:NAME$}  {heads}", format!("radiosity, {}", printable(&self.channels[channel].name)))?;
        for Surface { name, area, mean, least, largest, .. } in &self.surfaces {
            let name = printable(name).to_string();
            if name.chars().count() > NAME {
                write!(f, "{name}\n{:NAME$}", "")?;
            } else {
                write!(f, "{name:NAME$}")?;
            }
            for of in [*area, mean.get(channel).copied(), least.get(channel).copied(), largest.get(channel).copied()] {
                match of {
                    Some(value) => write!(f, "  {value:>11.4e}")?,
                    None => write!(f, "  {:>11}", "-")?,
                }
            }
            writeln!(f)?;
        }
        writeln!(f)
    }

    /// A line for each surface with its luminous flux.
    fn lumens(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{:NAME$}  {:>11}  {:>11}", "luminous flux", "lm/m2", "lumens")?;
        for Surface { name, area, lumens, .. } in &self.surfaces {
            if let (Some(area), Some(lumens)) = (area, lumens) {
                writeln!(f, "{:NAME$}  {:>11.4e}  {lumens:>11.4e}", printable(name).to_string(), lumens / area)?;
            }
        }
        writeln!(f)
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { seconds, rounds, elements, links, estimate, error, .. } = self;
        writeln!(f, "{elements} elements, {links} links, {rounds} rounds, {seconds:.3} s")?;
        let [estimate, error] = [*estimate, *error].map(|share| 100.0 * share);
        writeln!(f, "error of the mean: estimated {estimate:.3} %; {error:.3} % asked for\n")?;
        (0..self.channels.len()).try_for_each(|channel| self.surfaces(f, channel))?;
        if self.surfaces.iter().any(|surface| surface.lumens.is_some()) {
            self.lumens(f)?;
        }
        let heads = ["reflected", "estimate"].map(|head| format!("{head:>11}")).join("  ");
        write!(f, "{:NAME$}  {heads}", "mean of all, by channel")?;
        writeln!(f, "{}", if self.confidence.is_some() { "    certified           to" } else { "" })?;
        for Channel { name, reflected, estimate, certified_reflected, .. } in &self.channels {
            write!(f, "{:NAME$}  {reflected:>11.4e}  {estimate:>11.1e}", printable(name).to_string())?;
            match certified_reflected {
                Some([lower, upper]) => writeln!(f, "  {lower:>11.4e}  {upper:>11.4e}")?,
                None => writeln!(f)?,
            }
        }
        match (self.confidence, self.seed) {
            (Some(confidence), Some(seed)) => writeln!(f, "certified but for a probability of {confidence:e}, seed {seed}"),
            _ => Ok(()),
        }
    }
}
