//! `cargo xtask bench`: run time against error of radiosity and gradient, by every method we have, in six regimes.
//!
//! Each point is a method at one setting. Its error is the larger of the worst relative errors of value and gradient over
//! sixteen cases, against the oracle's enclosures; its time the median of fifteen samples of a pass over the cases, on one thread.

mod area_rule;
mod clock;
mod contour_rule;
mod diagram;
mod lambert;
mod lanes;
mod legendre;
mod marker;
mod method;
mod output;
mod point;
mod ratios;
pub(crate) mod regime;
mod truth;
mod visible;

use std::error::Error;
use std::fs;
use std::path::PathBuf;

use method::Method;
use point::Point;
use regime::{Kind, Regime};
use truth::Truths;

use crate::files;

/// Time every method against its error: diagrams and a table for each regime
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Ratios of times only, held against data/speed.toml; the last line is a JSON object
    #[arg(long, conflicts_with = "regime")]
    ratios: bool,
    /// Only these regimes
    #[arg(long)]
    regime: Vec<Regime>,
    /// Folder to write to
    #[arg(long, default_value = "target/bench")]
    out: PathBuf,
}

/// Pixels to a unit of a PNG, and of the one for the front page.
const SCALE: f32 = 1.5;
const FRONT_SCALE: f32 = 1.2;

/// The regimes that the front page shows side by side.
const FRONT: [Regime; 2] = [Regime::Easy, Regime::Near2];

/// Measures and writes, and says where; with ratios, whether they are within their gates.
pub(crate) fn run(arguments: &Arguments) -> Result<bool, Box<dyn Error>> {
    if arguments.ratios {
        return ratios::run();
    }
    fs::create_dir_all(&arguments.out)?;
    let regimes = if arguments.regime.is_empty() { Regime::ALL.to_vec() } else { arguments.regime.clone() };
    let mut front = Vec::new();
    for regime in regimes {
        let mut points = Vec::new();
        for kind in Kind::ALL {
            points.extend(measured(regime, kind)?);
        }
        let path = |extension: &str| arguments.out.join(format!("{}.{extension}", regime.name()));
        files::write(&path("csv"), point::table(regime, &points))?;
        let diagram = diagram::of_regime(regime, &points);
        files::write(&path("svg"), diagram::svg_of_regime(regime, &points))?;
        files::write(&path("png"), diagram.png(SCALE)?)?;
        println!("{}, .png and .csv ({} points)", path("svg").display(), points.len());
        for better in point::better_than_the_closed_form(&points) {
            println!("  {better}");
        }
        if FRONT.contains(&regime) {
            front.push((regime, points));
        }
    }
    if front.len() == FRONT.len() {
        let path = arguments.out.join("run-time-against-error.png");
        files::write(&path, diagram::of_front_page(&front).png(FRONT_SCALE)?)?;
        println!("{}", path.display());
    }
    Ok(true)
}

/// Every method at every setting.
fn measured(regime: Regime, kind: Kind) -> Result<Vec<Point>, Box<dyn Error>> {
    let cases = regime.cases(kind)?;
    let truths = Truths::enclose(&cases)?;
    let runs = Method::ALL.into_iter().flat_map(|method| method.runs(&cases));
    runs.map(|run| Point::measured(run, kind, &truths)).collect()
}
