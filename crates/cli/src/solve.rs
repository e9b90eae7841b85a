//! `radgrad solve`: a scene to an error, with its progress, its files and its summary.

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};
use radgrad_certificate::{Certificate, Interval};
use radgrad_core::DVec3;
use radgrad_scene::output::{self, Unwritten, write_whole};
use radgrad_scene::{Materials, Scene};
use radgrad_solver::{GradientRounds, MAX_DEGREE, Marking, Next, Options, Solution, solve_for};

use crate::certified::{self, Certifying};
use crate::export::Format;
use crate::grid::{self, Grid};
use crate::photometry::{self, Photometry};
use crate::places::{self, Same};
use crate::points::Points;
use crate::resume;
use crate::say::say;
use crate::scene::SceneFile;
use crate::summary::Summary;
use crate::view::{self, View};

/// The scene to solve, and the files to write.
#[derive(Debug, Args)]
pub(crate) struct Request {
    #[command(flatten)]
    scene: SceneFile,
    /// Error of the mean over the mean that is reflected, estimated.
    ///
    /// A percentage or a fraction, at most 100% [default: 0.1%]. With --points of JSON Lines and no --error, refinement goes on until the
    /// estimates of their gradients' errors are within 0.3%: of all light, to 0.02% or a sixth of --seconds, then of what the points see whose
    /// gradients are not, to 40% of --seconds.
    #[arg(long, value_parser = fraction)]
    error: Option<f64>,
    /// Seconds in which to be done.
    ///
    /// What is refined ends then, early in the first round, and no round is begun that would probably end later: the estimate says what was
    /// reached.
    #[arg(long, default_value = "60", value_parser = seconds)]
    seconds: Duration,
    #[command(flatten)]
    certifying: Certifying,
    /// Write the solution: .vtu for `ParaView`, .ply with colours.
    ///
    /// A .vtu has radiosity, gradient and estimates of their errors. It is written after every round too, so that a run that is interrupted
    /// leaves the last complete one.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Answer for points: JSON Lines, CSV, or six numbers a line.
    ///
    /// A line of JSON is {"position": [x, y, z], "normal": [x, y, z]}, one of a table is x y z nx ny nz, a header of a CSV names these columns;
    /// `-` is the standard input. JSON Lines are answered with JSON Lines: on a face `radiosity`, `estimate`, `gradient` within the face and
    /// `gradient_estimate`, and anywhere the same of the irradiance, as `irradiance_estimate`; each in each channel. Tables are answered with CSV,
    /// without gradients, and with least, mean, largest and uniformity on the standard error. A point that is near no face is a sensor in
    /// free space, and so is one with `"on": "free"`.
    #[arg(long, value_name = "FILE", group = "places")]
    points: Option<PathBuf>,
    /// Answer on a work plane: `z=0.75,step=0.5`, and `margin=0.5`.
    ///
    /// The points are inside the footprint of the scene, as far from both walls, the normal along the axis that is named; those inside a body
    /// are left out. Answers are CSV, with least, mean, largest and uniformity (least over mean) on the standard error.
    #[arg(long, value_name = "PLANE", value_parser = Grid::parse, group = "places")]
    grid: Option<Grid>,
    /// Write the answers here: .csv, or .jsonl.
    #[arg(long, value_name = "FILE", requires = "places")]
    answers: Option<PathBuf>,
    /// Lux and lumens too: radiances are luminances in cd/m2.
    ///
    /// With `--lux=179` they are in W/(m2 sr), of 179 lumens a watt. Of three channels r, g, b the weights are those of sRGB. Lumens are
    /// right where lengths are metres.
    #[arg(long, value_name = "LM", num_args = 0..=1, require_equals = true, default_missing_value = "1", value_parser = photometry::lumens)]
    lux: Option<f64>,
    /// Print one JSON object instead of a table.
    ///
    /// It has `seconds`, `elements`, `links`, `estimate`, `channels`, `surfaces` and `warnings`. A table is printed where nothing else is asked for.
    #[arg(long)]
    summary: bool,
    #[command(flatten)]
    view: View,
    /// Go on from this file, and keep it up to date.
    ///
    /// After every round it has which elements gather; what is divided for direct light alone is found again.
    #[arg(long, value_name = "FILE", help_heading = EXPERT)]
    resume: Option<PathBuf>,
    /// Make no reflectance larger than this.
    #[arg(long, value_name = "SHARE", value_parser = reflectance, help_heading = EXPERT)]
    max_reflectance: Option<f64>,
    /// What refinement serves.
    ///
    /// And what the error is of: the mean over all area; or the points of --points and what --camera sees of the scene, in the mean over
    /// them.
    #[arg(long = "for", value_enum, default_value_t, help_heading = EXPERT)]
    serve: Serve,
    /// Degree of polynomials, 0 to 4.
    ///
    /// By default 2; 1 from a thousand faces on, 0 from twenty thousand; 4 where few faces face each other at about their width.
    #[arg(long, value_parser = degree, help_heading = EXPERT)]
    degree: Option<usize>,
    /// Elements beyond which none is divided.
    ///
    /// Divided ones count too; where faces are a thousand or more, beside these.
    #[arg(long, value_name = "N", default_value_t = 20_000, help_heading = EXPERT)]
    most_elements: usize,
    /// Which elements to divide.
    ///
    /// Those that add most to the error of gathers; or those whose polynomials are off most by values and gradients, for few elements in
    /// files; or the same after faces were cut along shadow lines, for the fewest.
    #[arg(long, value_enum, default_value_t, help_heading = EXPERT)]
    divide: Divide,
}

/// The heading of the options that few need.
pub(crate) const EXPERT: &str = "Expert";

/// The time of a solve that ends when it must, over that of its default certificate too.
const SOLVING: f64 = 0.75;

/// Faces from which on the rounds of a solve are said where there is no bar.
const MANY: usize = 20_000;

/// If no error is asked for, refinement goes on for points until the errors of their gradients are surely within this part of them.
const GRADIENT: f64 = 0.01;

/// [`Marking`] on the command line.
#[derive(Debug, Clone, Copy, Default, ValueEnum)]
enum Divide {
    #[default]
    Residual,
    Gradient,
    Shadows,
}

/// What is served.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
enum Serve {
    #[default]
    Mean,
    Points,
}

impl Request {
    /// Options of the solver, with this time.
    fn options(&self, time: Duration) -> Options {
        let marking = match self.divide {
            Divide::Residual => Marking::Residual,
            Divide::Gradient => Marking::Gradient,
            Divide::Shadows => Marking::Shadows,
        };
        let (degree, most_elements, time) = (self.degree, self.most_elements, Some(time));
        Options { error: self.error(), degree, most_elements, time, marking, ..Options::default() }
    }
}

impl Request {
    const fn has_points(&self) -> bool {
        self.points.is_some() || self.grid.is_some()
    }

    /// The error that is asked for.
    fn error(&self) -> f64 {
        self.error.unwrap_or(Options::default().error)
    }

    /// Files that are read and written must not be one.
    fn check_names(&self) -> Result<(), Same> {
        let written = [
            ("out", self.out.as_deref()),
            ("view", self.view.file()),
            ("answers", self.answers.as_deref()),
            ("resume", self.resume.as_deref()),
        ];
        let written: Vec<_> = written.into_iter().filter_map(|(option, file)| Some((option, file?.to_owned()))).collect();
        let read: Vec<_> = self.points.as_deref().map(|file| ("points", file)).into_iter().collect();
        places::check((&self.scene.path, self.scene.budget), &read, &written)
    }
}

/// Why there is no result.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error(transparent)]
    Scene(#[from] radgrad_scene::Error),
    #[error(transparent)]
    Solve(#[from] radgrad_solver::Error),
    #[error("{}: expected a name ending in .vtu or .ply", file.display())]
    Format { file: PathBuf },
    #[error("{}: cannot read: {source}", file.display())]
    Read { file: PathBuf, source: io::Error },
    #[error(
        "--divide shadows cannot go on from a file of --resume, which has divisions and not the cuts before them: leave one of them out"
    )]
    Cut,
    #[error(transparent)]
    Certificate(#[from] radgrad_certificate::Error),
    #[error("{0}")]
    Certify(String),
    #[error("--for points has no points: give --points or --camera")]
    Nothing,
    #[error(transparent)]
    Same(#[from] Same),
    #[error(transparent)]
    Write(#[from] Unwritten),
    #[error(transparent)]
    Resume(#[from] resume::Failure),
    #[error(transparent)]
    View(#[from] view::Failure),
    #[error("cannot write the answers: {0}")]
    Output(#[from] io::Error),
    #[error(transparent)]
    Grid(#[from] grid::Failure),
    #[error("{0}")]
    Lux(String),
}

/// Solves and writes. Returns whether the error asked for was reached and every point answered.
pub(crate) fn run(request: &Request, mut output: impl Write) -> Result<bool, Failure> {
    let start = Instant::now();
    // What can be refused is refused before the work.
    let out = request.out.as_deref().map(|file| match Format::of(file) {
        Some(format) => Ok((file, format)),
        None => Err(Failure::Format { file: file.to_owned() }),
    });
    let out = out.transpose()?;
    if request.resume.is_some() && matches!(request.divide, Divide::Shadows) {
        return Err(Failure::Cut);
    }
    request.certifying.check(request.has_points()).map_err(Failure::Certify)?;
    request.view.check(&request.scene)?;
    request.check_names()?;
    [&request.out, &request.answers, &request.resume].into_iter().flatten().try_for_each(|file| output::check(file))?;
    let points = request
        .points
        .as_deref()
        .map(|file| Points::read(file, request.scene.budget).map_err(|source| Failure::Read { file: file.to_owned(), source }));
    let points = points.transpose()?;
    let mut scene = request.scene.read(Materials::Required)?;
    if let Some(most) = request.max_reflectance {
        let read = scene.notes().len();
        scene.cap_reflectance(most);
        scene.notes().iter().skip(read).for_each(say);
    }

    let points = match &request.grid {
        Some(grid) => Some(Points::of_grid(&grid.points(&scene)?)),
        None => points,
    };
    let served = served(request, &scene, points.as_ref())?;
    let solution = solved(request, &scene, (&served, points.as_ref()), start, out)?;
    let seconds = start.elapsed().as_secs_f64();
    solution.warnings().iter().for_each(say);
    let certificate = request.certifying.mean(&scene, &solution, request.error())?;
    if let (Some((file, format)), Some(_)) = (out, &certificate) {
        write_whole(file, |output| format.write(&solution, &scene, certificate.as_ref(), output))?;
    }
    let photometry = request.lux.map(|lumens| Photometry::new(lumens, &solution).map_err(Failure::Lux)).transpose()?;
    request.view.write(&solution, photometry.as_ref())?;
    let is_answered = match points {
        Some(points) => answer(request, (&scene, &solution), &points, photometry.clone(), &mut output)?,
        None => true,
    };
    let summary = Summary::of(&solution, &scene, certificate.as_ref(), request.error(), seconds);
    let summary = photometry.iter().fold(summary, Summary::lit);
    if request.summary {
        serde_json::to_writer(&mut output, &summary).map_err(io::Error::from)?;
        output.write_all(b"\n")?;
    } else if request.out.is_none() && !request.has_points() && request.view.file().is_none() {
        write!(output, "{summary}")?;
    }
    let is_certified = certificate.is_none_or(|certificate| holds(request, &scene, &solution, &certificate));
    Ok(reached(request, &solution) && is_answered && is_certified)
}

/// Whether the mean's certificate is as narrow as asked and agrees with the solution; says so where it is not.
fn holds(request: &Request, scene: &Scene, solution: &Solution, certificate: &Certificate) -> bool {
    let contradictions = certified::contradictions(scene, solution, certificate);
    contradictions.iter().for_each(say);
    let asked = request.certifying.width().unwrap_or(f64::INFINITY);
    // A width is relative to the mean, which is not above the upper end.
    let is_wide = |of: &Interval| asked.is_finite() && !(of.upper.is_finite() && of.half_width() <= asked * of.upper);
    let wide = solution.channels().iter().zip(&certificate.reflected).find(|(_, of)| is_wide(of));
    if let Some((channel, Interval { lower, upper })) = wide {
        let (asked, rays) = (100.0 * asked, certificate.rays);
        say(format_args!(
            "channel `{channel}`: {rays} rays certify a reflected mean from {lower:.6e} to {upper:.6e}, and not to the {asked:.3} % asked for"
        ));
    }
    contradictions.is_empty() && wide.is_none()
}

/// The points that refinement serves; none where it serves the mean.
fn served(request: &Request, scene: &Scene, points: Option<&Points>) -> Result<Vec<(DVec3, DVec3)>, Failure> {
    if request.serve != Serve::Points {
        return Ok(Vec::new());
    }
    let mut served: Vec<_> = points.into_iter().flat_map(Points::places).collect();
    served.extend(request.view.places(scene));
    if served.is_empty() { Err(Failure::Nothing) } else { Ok(served) }
}

/// Writes the answers of points, into their file or as lines. Returns whether all were answered, and certified where that is asked for.
fn answer(
    request: &Request,
    (scene, solution): (&Scene, &Solution),
    points: &Points,
    photometry: Option<Photometry>,
    output: impl Write,
) -> Result<bool, Failure> {
    let mut answers = points.answered(solution, photometry);
    let mut is_certified = true;
    if request.certifying.wants_points() {
        let (places, certifying) = (answers.places(), &request.certifying);
        let said = answers.certify(certifying.points((scene, solution), &places, request.error())?);
        is_certified = said.is_empty();
        said.iter().for_each(say);
    }
    match &request.answers {
        Some(file) => write_whole(file, |output| answers.write(solution.channels(), &output::extension(file), output))?,
        None => answers.write(solution.channels(), "", BufWriter::new(output))?,
    }
    answers.spread(solution.channels()).iter().for_each(say);
    let refused = answers.refused();
    if refused > 0 {
        say(format_args!("{refused} points refused: see their `error`"));
    }
    Ok(refused == 0 && is_certified)
}

/// Whether the error asked for was reached; says so where it was not.
fn reached(request: &Request, solution: &Solution) -> bool {
    let (found, asked) = (solution.progress().estimate, request.error());
    let reached = found <= asked;
    if !reached {
        let [found, asked] = [found, asked].map(|share| 100.0 * share);
        say(format_args!(
            "stopped at an estimate of {found:.3} %, above the {asked:.3} % asked for: give more --seconds, or ask for a larger --error"
        ));
    }
    reached
}

/// The solution, with its progress on the standard error and a file of it after every round.
fn solved(
    request: &Request,
    scene: &Scene,
    (served, points): (&[(DVec3, DVec3)], Option<&Points>),
    start: Instant,
    out: Option<(&Path, Format)>,
) -> Result<Solution, Failure> {
    // Reading has taken its part, and the certificate by default will.
    let left = request.seconds.saturating_sub(start.elapsed());
    let is_default = !request.certifying.is_off() && request.certifying.width().is_none();
    let time = if is_default { left.mul_f64(SOLVING) } else { left };
    let mut options = request.options(time);
    let mut rounds = points.filter(|points| request.error.is_none() && points.wants_gradients()).map(|points| {
        let points: Vec<_> = points.places().collect();
        let rounds = GradientRounds::new(&points, GRADIENT, request.error(), time);
        if request.serve == Serve::Points { rounds.of_served() } else { rounds }
    });
    if let Some(rounds) = &rounds {
        options.error = rounds.error();
    }
    let bar = ProgressBar::new_spinner();
    if let Ok(style) = ProgressStyle::with_template("{spinner} {elapsed} {msg}") {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(100));
    let squares = matches!(request.divide, Divide::Gradient);
    let run = resume::Run { scene: resume::fingerprint(scene), squares };
    let mut held = request.resume.as_deref().map(output::Held::take).transpose()?;
    let divisions = match &request.resume {
        Some(file) => resume::read(file, &run, request.scene.budget)?,
        None => Vec::new(),
    };
    let mut failure: Option<Failure> = None;
    let solution = solve_for(scene, &options, &divisions, served, |solution| {
        let p = solution.progress();
        let estimate = 100.0 * p.estimate;
        let reached = format!("round {}: {} elements, {} links, estimate {estimate:.3} %", p.round, p.elements, p.links);
        if bar.is_hidden() && scene.faces().len() >= MANY {
            // Where no bar is seen these are the early answers.
            let means =
                solution.channels().iter().zip(solution.reflected()).map(|(channel, mean)| format!("{mean:.4e} ({channel})"));
            let (seconds, means) = (start.elapsed().as_secs_f64(), means.collect::<Vec<_>>().join(", "));
            say(format_args!("after {seconds:.1} s, {reached}, reflected mean {means}"));
        }
        bar.set_message(reached);
        let mut watched = || -> Result<(), Failure> {
            if let Some((file, format)) = out {
                write_whole(file, |output| format.write(solution, scene, None, output))?;
            }
            if let Some(held) = &mut held {
                resume::write(held, &run, solution)?;
            }
            Ok(())
        };
        failure = watched().err();
        match &mut rounds {
            Some(rounds) if failure.is_none() => rounds.next(solution),
            _ => Next::from(failure.is_none()),
        }
    });
    bar.finish_and_clear();
    if let Some(failure) = failure {
        return Err(failure);
    }
    Ok(solution?)
}

/// `0.5%` or `0.005`.
pub(crate) fn fraction(text: &str) -> Result<f64, String> {
    let (number, unit) = text.strip_suffix('%').map_or((text, 1.0), |number| (number, 0.01));
    let value = unit * number.trim().parse::<f64>().map_err(|error| error.to_string())?;
    if value > 0.0 && value <= 1.0 { Ok(value) } else { Err(format!("{value} is not above 0 and at most 1 (100%)")) }
}

fn reflectance(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().map_err(|error| error.to_string())?;
    if (0.0..1.0).contains(&value) { Ok(value) } else { Err(format!("{value} is not from 0 to below 1")) }
}

pub(crate) fn seconds(text: &str) -> Result<Duration, String> {
    let value = text.parse::<f64>().map_err(|error| error.to_string())?;
    Duration::try_from_secs_f64(value).map_err(|error| error.to_string())
}

fn degree(text: &str) -> Result<usize, String> {
    let value = text.parse::<usize>().map_err(|error| error.to_string())?;
    if value <= MAX_DEGREE { Ok(value) } else { Err(format!("{value} is above {MAX_DEGREE}")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_is_a_percentage_or_a_fraction() {
        assert_eq!(fraction("0.5%"), Ok(0.005));
        assert_eq!(fraction("0.005"), Ok(0.005));
        for wrong in ["0", "-1%", "101%", "nan", "half"] {
            assert!(fraction(wrong).is_err(), "{wrong}");
        }
    }
}
