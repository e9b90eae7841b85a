//! The program `radgrad`, as a library: [`run`] is all of it, for whoever starts it (`src/bin`, the Python package), and [`mod@file`] writes
//! what it writes of a solution.

#[cfg(feature = "audit")]
mod audit;
mod certified;
mod eval;
mod export;
mod factors;
mod field;
pub mod file;
mod manual;
mod places;
mod points;
mod resume;
mod say;
mod scene;
mod solve;
mod summary;
mod view;

use std::ffi::OsString;
use std::fmt::Display;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use clap::{CommandFactory, Parser, Subcommand};
use clap_complete::Shell;

use eval::{Asked, Failure, Tally};
use say::say;

const EXIT_STATUS: &str = "Exit status:
  0  all was answered
  1  lines of `eval` or points of `solve` were refused, `solve` stopped above
     the error or the width asked for or contradicts its certificate, or `audit`
     found a violated gate
  2  the input cannot be read, an answer is no finite number, the output cannot be written, or the arguments are wrong";

/// Radiosity and its gradient from polygonal emitters, with error bounds.
#[derive(Debug, Parser)]
#[command(version, after_help = EXIT_STATUS, term_width = 80)]
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
        /// Operations that one line may take: a line that takes more is refused, and the next ones are answered; a billion takes up to a
        /// second.
        #[arg(long, value_name = "OPERATIONS", default_value = "8e9", value_parser = operations)]
        effort: u64,
        /// Second derivatives too, in every line, as `"hessian": true` asks for them in one.
        #[arg(long)]
        hessian: bool,
    },
    /// Hold any program's answers to exact values: draws the audit's families of cases, and fails beyond the gates.
    #[cfg(feature = "audit")]
    Audit(audit::Arguments),
    /// Hold any program's answers to exact values: not in this program, but in one built with `--features audit`.
    #[cfg(not(feature = "audit"))]
    #[command(disable_help_flag = true)]
    Audit {
        /// What that program is told.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
        arguments: Vec<OsString>,
    },
    /// Form factors between all faces of a scene, each with a proven bound; defects are reported, never normalised away.
    Factors(factors::Arguments),
    /// Irradiance of a surface straight from the lamps, with gradient and bounds, on a grid.
    Field(field::Arguments),
    /// Solve a scene (.obj, .gltf, .glb, .vs3) for the radiosity everywhere, with an estimate of its error.
    ///
    /// Progress goes to the standard error; answers to --points, one line each, and then the summary to the standard output.
    Solve(Box<solve::Request>),
    /// Print what completes this program's arguments in a shell.
    ///
    /// As in `radgrad completions bash > ~/.local/share/bash-completion/completions/radgrad`.
    Completions {
        /// Which shell.
        shell: Shell,
    },
    /// Print the manual page of this program and its commands, or write one page for each to a folder.
    Man {
        /// The folder.
        #[arg(long, value_name = "FOLDER")]
        out: Option<PathBuf>,
    },
}

/// Runs the program with its arguments, the first of which is its name, and returns its exit status.
#[must_use]
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let arguments = match Arguments::try_parse_from(arguments) {
        Ok(arguments) => arguments,
        Err(error) => {
            let printed = error.print();
            return if error.use_stderr() || printed.is_err() { 2 } else { 0 };
        }
    };
    if let Err(error) = radgrad_scene::check_host() {
        return refused(error);
    }
    match arguments.command {
        Command::Eval { file, effort, hessian } => answer(&file, Asked { effort, hessian }),
        #[cfg(feature = "audit")]
        Command::Audit(arguments) => audit::run(&arguments).map_or_else(refused, |held| u8::from(!held)),
        #[cfg(not(feature = "audit"))]
        Command::Audit { .. } => refused("`audit` is not in this program, but in one built with `--features audit`"),
        Command::Factors(arguments) => factors::run(&arguments).map_or_else(refused, |met| u8::from(!met)),
        Command::Field(arguments) => field::run(&arguments).map_or_else(refused, |()| 0),
        Command::Completions { shell } => manual::completions(Arguments::command(), shell).map_or_else(refused, |()| 0),
        Command::Man { out } => manual::write(Arguments::command(), out.as_deref()).map_or_else(refused, |()| 0),
        Command::Solve(request) => solve::run(&request, io::stdout().lock()).map_or_else(refused, |complete| u8::from(!complete)),
    }
}

fn refused(failure: impl Display) -> u8 {
    say(failure);
    2
}

fn answer(file: &Path, asked: Asked) -> u8 {
    match eval(file, asked) {
        Ok(tally) => {
            if tally.refused > 0 {
                say(format_args!("{} of {} cases refused: see their `error`", tally.refused, tally.lines));
            }
            u8::from(tally.refused > 0)
        }
        Err(failure) => {
            say(format_args!("{}: {failure}", file.display()));
            2
        }
    }
}

/// A count of operations, as `8e9` too.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the range of counts")]
fn operations(text: &str) -> Result<u64, String> {
    let value: f64 = text.parse().map_err(|_| format!("expected a number of operations, such as 8e9, found `{text}`"))?;
    if (1.0..=1e18).contains(&value) {
        Ok(value as u64)
    } else {
        Err(format!("{value:e} operations: they are between 1 and 1e18"))
    }
}

fn eval(file: &Path, asked: Asked) -> Result<Tally, Failure> {
    let input: Box<dyn Read> =
        if file == Path::new("-") { Box::new(io::stdin().lock()) } else { Box::new(File::open(file).map_err(Failure::Read)?) };
    eval::answer_all(input, io::stdout().lock(), asked)
}
