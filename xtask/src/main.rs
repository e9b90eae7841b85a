//! Project tasks, run as `cargo xtask TASK`.

mod figures;
mod plot;

use std::process::ExitCode;

use clap::Parser;

/// Project tasks.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask")]
enum Task {
    Figures(figures::Arguments),
}

fn main() -> ExitCode {
    let result = match Task::parse() {
        Task::Figures(arguments) => figures::run(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
