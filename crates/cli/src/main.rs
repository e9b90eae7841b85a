//! The program `radgrad`.
//!
//! Exit status: 0 if all was answered, 1 if lines of `eval` were refused, or `solve` or `factors` did not reach what was asked for,
//! 2 if the input cannot be read, the output cannot be written or the arguments are wrong.

mod eval;
mod export;
mod factors;
mod field;
mod output;
mod points;
mod resume;
mod scene;
mod solve;
mod summary;
mod view;

use std::fmt::Display;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use eval::{Failure, Tally};

/// Radiosity and its gradient from polygonal emitters, with error bounds.
#[derive(Debug, Parser)]
#[command(version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Answer the cases of a JSON Lines file, one object a line, in the same order.
    ///
    /// A line that is wrong gives {"id": .., "error": ".."}, costs no other line, and the exit status is 1 at the end.
    Eval {
        /// File of cases, `-` for the standard input.
        file: PathBuf,
    },
    /// Form factors between all faces of a scene, each with a proven bound; defects are reported, never normalised away.
    Factors(factors::Arguments),
    /// Irradiance of a surface straight from the lamps, with gradient and bounds, on a grid.
    Field(field::Arguments),
    /// Solve a scene (.obj, .gltf, .glb, .vs3) for the radiosity everywhere, with a bound on its error.
    ///
    /// Progress goes to the standard error; answers to --points, one line each, and then the summary to the standard output.
    Solve(Box<solve::Request>),
}

fn main() -> ExitCode {
    match Arguments::parse().command {
        Command::Eval { file } => answer(&file),
        Command::Factors(arguments) => match factors::run(&arguments) {
            Ok(met) => ExitCode::from(u8::from(!met)),
            Err(failure) => refused(failure),
        },
        Command::Field(arguments) => status(field::run(&arguments)),
        Command::Solve(request) => match solve::run(&request, io::stdout().lock()) {
            Ok(complete) => ExitCode::from(u8::from(!complete)),
            Err(failure) => refused(failure),
        },
    }
}

fn status(result: Result<(), impl Display>) -> ExitCode {
    result.map_or_else(refused, |()| ExitCode::SUCCESS)
}

fn refused(failure: impl Display) -> ExitCode {
    eprintln!("radgrad: {failure}");
    ExitCode::from(2)
}

fn answer(file: &Path) -> ExitCode {
    match eval(file) {
        Ok(tally) => {
            if tally.refused > 0 {
                eprintln!("radgrad: {} of {} cases refused: see their `error`", tally.refused, tally.lines);
            }
            ExitCode::from(u8::from(tally.refused > 0))
        }
        Err(failure) => {
            eprintln!("radgrad: {}: {failure}", file.display());
            ExitCode::from(2)
        }
    }
}
fn eval(file: &Path) -> Result<Tally, Failure> {
    let input: Box<dyn Read> =
        if file == Path::new("-") { Box::new(io::stdin().lock()) } else { Box::new(File::open(file).map_err(Failure::Read)?) };
    eval::answer_all(input, io::stdout().lock())
}
