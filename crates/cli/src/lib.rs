//! The program `radgrad`, as a library: [`run`] is all of it, for whoever starts it (`src/bin`, the Python package), and [`mod@file`] writes
//! what it writes of a solution.

#[cfg(feature = "audit")]
mod audit;
mod certified;
mod check;
mod demo;
mod eval;
mod export;
mod factors;
mod field;
pub mod file;
mod grid;
mod heat;
mod manual;
mod photometry;
mod places;
mod points;
mod resume;
mod say;
mod scene;
mod solve;
mod summary;
#[cfg(test)]
mod tests;
mod view;

use std::ffi::OsString;
use std::fmt::Display;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use clap::{Arg, ArgAction, CommandFactory, FromArgMatches, Parser, Subcommand};
use clap_complete::Shell;

use eval::{Asked, Failure, Tally};
use say::say;

/// Where words and units are explained.
const UNITS: &str = "Units: radiance L, radiosity and emission pi L, irradiance, illuminance and
factors are set side by side in docs/guide/units.md.";

/// The end of a command's help: the meanings of its exit statuses.
macro_rules! statuses {
    ($zero:literal, $one:literal, $two:literal) => {
        concat!("Exit status:\n  0  ", $zero, "\n  1  ", $one, "\n  2  ", $two)
    };
    ($zero:literal, $two:literal) => {
        concat!("Exit status:\n  0  ", $zero, "\n  2  ", $two)
    };
}

const ALL: &str = statuses!(
    "all was answered",
    "there is an answer, and it is not all that was asked for: each command's
     help says what",
    "there is no answer: the input cannot be read, the output cannot be written,
     a number is not finite, or the arguments are wrong"
);
const EVAL: &str = statuses!(
    "every line was answered",
    "lines were refused: see their `error`",
    "the input cannot be read, the output not written, or arguments are wrong"
);
const FACTORS: &str = statuses!(
    "every factor is within its bound",
    "factors are not: they are listed",
    "the scene cannot be read, the output not written, or arguments are wrong"
);
const SOLVE: &str = statuses!(
    "the error was reached, and every point answered",
    "the estimate is above --error, the certificate wider than asked or against
     the solution, or points were refused",
    "the scene has no solution, cannot be read, the output not written, or
     arguments are wrong"
);
const CHECK: &str = statuses!(
    "the scene is closed",
    "it is not: edges are open, turned or doubled",
    "the scene cannot be read, or arguments are wrong"
);
#[cfg(feature = "audit")]
const AUDIT: &str = statuses!("every gate held", "a gate was violated", "the program cannot be asked, or arguments are wrong");
const OTHERS: &str = statuses!("done", "the input cannot be read, the output not written, or arguments are wrong");

/// Radiosity and its gradient from polygonal emitters, with error bounds.
#[derive(Debug, Parser)]
#[command(version, after_help = concat_after(), term_width = 80)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

fn concat_after() -> String {
    format!("`radgrad help COMMAND` says all of a command.\n\n{UNITS}\n\n{ALL}")
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Light of a lamp at a point: a JSON object a line.
    ///
    /// A line has a receiver, an emitter and occluders, and is answered with radiosity, gradient and proven bounds, in the same order. A line that is wrong gives {"id": .., "error": ".."}, costs no other line, and the exit status is 1 at the end. In a line,
    /// "digits": 50 asks for decimal digits, and "emission": {"expression": "1 + x*exp(-y)"} is answered with an estimate.
    #[command(after_help = EVAL)]
    Eval {
        /// File of cases, `-` for the standard input.
        file: PathBuf,
        /// Operations that one line may take.
        ///
        /// A line that takes more is refused, and the next ones are answered; a billion takes up to a second.
        #[arg(long, value_name = "OPERATIONS", default_value = "8e9", value_parser = operations)]
        effort: u64,
        /// Second derivatives too, in every line.
        ///
        /// As `"hessian": true` asks for them in one.
        #[arg(long)]
        hessian: bool,
    },
    /// Hold any program's answers to exact values.
    ///
    /// Draws the audit's families of cases, and fails beyond the gates.
    #[cfg(feature = "audit")]
    #[command(after_help = AUDIT)]
    Audit(audit::Arguments),
    /// Hold any program's answers to exact values.
    ///
    /// Not in this program, but in one built with `--features audit`.
    #[cfg(not(feature = "audit"))]
    #[command(disable_help_flag = true)]
    Audit {
        /// What that program is told.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
        arguments: Vec<OsString>,
    },
    /// Form factors (view factors) between faces, with proven bounds.
    ///
    /// Defects of rows are reported, never normalised away.
    #[command(after_help = FACTORS)]
    Factors(factors::Arguments),
    /// Direct irradiance of a surface on a grid, with proven bounds.
    ///
    /// With its gradient, from the lamps alone.
    #[command(after_help = OTHERS)]
    Field(field::Arguments),
    /// Solve a scene for the light everywhere, with reflections.
    ///
    /// The error of the radiosity's mean is estimated, and certified. Progress goes to the standard error; answers to --points, one line each, and then the
    /// summary to the standard output.
    #[command(after_help = SOLVE)]
    Solve(Box<solve::Request>),
    /// Heat balance of grey surfaces, from factors and temperatures.
    ///
    /// Prints CSV: of each surface area, temperature in kelvin, net flux that it loses in W/m2, power in W, radiosity and irradiance.
    #[command(after_help = OTHERS)]
    Heat(heat::Arguments),
    /// Tell whether a scene is closed, and which edges are not.
    #[command(after_help = CHECK)]
    Check(check::Arguments),
    /// Write a scene to begin with, and print its commands.
    #[command(after_help = OTHERS)]
    Demo(demo::Arguments),
    /// Print what completes arguments in a shell.
    ///
    /// As in `radgrad completions bash > ~/.local/share/bash-completion/completions/radgrad`.
    #[command(after_help = OTHERS)]
    Completions {
        /// Which shell.
        shell: Shell,
    },
    /// Print the manual, or write a page for each command.
    #[command(after_help = OTHERS)]
    Man {
        /// The folder.
        #[arg(long, value_name = "FOLDER")]
        out: Option<PathBuf>,
    },
}

/// The program's arguments. `--help` prints a line or two for each, and `help COMMAND` all that there is to say.
fn program() -> clap::Command {
    let help =
        || Arg::new("help").short('h').long("help").action(ArgAction::HelpShort).help("Print this help").display_order(1000);
    let brief = |command: clap::Command| {
        let has_own = command.is_disable_help_flag_set();
        if has_own { command } else { command.disable_help_flag(true).arg(help()) }
    };
    brief(Arguments::command()).mut_subcommands(brief)
}

/// Runs the program with its arguments, the first of which is its name, and returns its exit status.
#[must_use]
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let parsed = program().try_get_matches_from(arguments).and_then(|matches| Arguments::from_arg_matches(&matches));
    let arguments = match parsed {
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
        Command::Heat(arguments) => heat::run(&arguments).map_or_else(refused, |()| 0),
        Command::Check(arguments) => check::run(&arguments).map_or_else(refused, |closed| u8::from(!closed)),
        Command::Demo(arguments) => demo::run(&arguments).map_or_else(refused, |()| 0),
        Command::Completions { shell } => manual::completions(program(), shell).map_or_else(refused, |()| 0),
        Command::Man { out } => manual::write(program(), out.as_deref()).map_or_else(refused, |()| 0),
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
