//! The program `radgrad`.
//!
//! [`EXIT_STATUS`] says how it ends.

mod audit;
mod eval;
mod export;
mod factors;
mod field;
mod lamps;
mod output;
mod points;
mod resume;
mod say;
mod scene;
mod solve;
mod summary;
mod view;

use std::fmt::Display;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use clap::{Parser, Subcommand};

use eval::{Failure, Tally};
use say::say;

const EXIT_STATUS: &str = "Exit status:
  0  all was answered
  1  lines of `eval` or points of `solve` were refused, `solve` stopped above the error asked for,
     or `audit` found a violated gate
  2  the input cannot be read, an answer is no finite number, the output cannot be written, or the arguments are wrong";

/// Radiosity and its gradient from polygonal emitters, with error bounds.
#[derive(Debug, Parser)]
#[command(version, after_help = EXIT_STATUS)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Answer the cases of a JSON Lines file, one object a line, in the same order.
    ///
    /// A line that is wrong gives {"id": .., "error": ".."}, costs no other line, and the exit status is 1 at the end. In a line,
    /// "digits": 50 asks for decimal digits, and "emission": {"expression": "1 + x*exp(-y)"} is answered with an estimate.
    Eval {
        /// File of cases, `-` for the standard input.
        file: PathBuf,
        /// Seconds that one line may take: then it is refused, and the next ones are answered.
        #[arg(long, default_value = "2", value_parser = solve::seconds)]
        seconds: Duration,
        /// Second derivatives too, in every line, as `"hessian": true` asks for them in one.
        #[arg(long)]
        hessian: bool,
    },
    /// Hold any program's answers to exact values: draws the audit's families of cases, and fails beyond the gates.
    Audit(audit::Arguments),
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
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            let printed = error.print();
            return ExitCode::from(if error.use_stderr() || printed.is_err() { 2 } else { 0 });
        }
    };
    if let Err(error) = radgrad_scene::check_host() {
        return refused(error);
    }
    match arguments.command {
        Command::Eval { file, seconds, hessian } => answer(&file, seconds, hessian),
        Command::Audit(arguments) => match audit::run(&arguments) {
            Ok(held) => ExitCode::from(u8::from(!held)),
            Err(failure) => refused(failure),
        },
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
    say(failure);
    ExitCode::from(2)
}

fn answer(file: &Path, seconds: Duration, hessian: bool) -> ExitCode {
    match eval(file, seconds, hessian) {
        Ok(tally) => {
            if tally.refused > 0 {
                say(format_args!("{} of {} cases refused: see their `error`", tally.refused, tally.lines));
            }
            ExitCode::from(u8::from(tally.refused > 0))
        }
        Err(failure) => {
            say(format_args!("{}: {failure}", file.display()));
            ExitCode::from(2)
        }
    }
}

fn eval(file: &Path, seconds: Duration, hessian: bool) -> Result<Tally, Failure> {
    let input: Box<dyn Read> =
        if file == Path::new("-") { Box::new(io::stdin().lock()) } else { Box::new(File::open(file).map_err(Failure::Read)?) };
    eval::answer_all(input, io::stdout().lock(), seconds, hessian)
}
