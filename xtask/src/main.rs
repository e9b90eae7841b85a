//! Project tasks, run as `cargo xtask TASK`.

mod beams;
mod bench;
mod bounds;
mod figures;
mod instructions;
mod plot;
mod radiosity;
mod replay;
mod report;
mod scenes;
mod summary;
mod verify;

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;

/// Project tasks.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask")]
enum Task {
    Verify(verify::Arguments),
    Replay(replay::Arguments),
    Report(report::Arguments),
    Figures(figures::Arguments),
    Bench(bench::Arguments),
    Beams(beams::Arguments),
    Instructions(instructions::Arguments),
    Radiosity(radiosity::Arguments),
}

fn main() -> ExitCode {
    let passed: Result<bool, Box<dyn Error>> = match Task::parse() {
        Task::Verify(arguments) => verify::run(&arguments),
        Task::Replay(arguments) => replay::run(&arguments),
        Task::Bench(arguments) => bench::run(&arguments),
        Task::Instructions(arguments) => instructions::run(&arguments),
        Task::Radiosity(arguments) => radiosity::run(&arguments).map(|()| true),
        Task::Report(arguments) => report::run(&arguments).map(|()| true),
        Task::Beams(arguments) => beams::run(&arguments).map(|()| true),
        Task::Figures(arguments) => figures::run(&arguments).map(|()| true).map_err(Into::into),
    };
    match passed {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// A path in the workspace, wherever the task was called from.
fn in_workspace(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path)
}
