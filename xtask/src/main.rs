//! Project tasks, run as `cargo xtask TASK`.

mod bench;
mod bounds;
mod figures;
mod files;
mod instructions;
mod mesh;
mod mutants;
mod plot;
mod prove;
mod record;
mod replay;
mod report;
mod request;
mod scenes;
mod summary;
mod verify;

use std::env;
use std::error::Error;
use std::process::{Command, ExitCode};

use clap::Parser;

use files::{cargo, in_workspace};

/// Project tasks.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask")]
enum Task {
    Verify(request::Arguments),
    Mutants(mutants::Arguments),
    Prove(prove::Arguments),
    Replay(replay::Arguments),
    Report(report::Arguments),
    Figures(figures::Arguments),
    Bench(bench::Arguments),
    Instructions(instructions::Arguments),
    Mesh(mesh::Arguments),
}

impl Task {
    /// Whether its output depends on the speed of this program.
    const fn takes_times(&self) -> bool {
        matches!(self, Self::Bench(_))
    }
}

fn main() -> ExitCode {
    let task = Task::parse();
    let passed: Result<bool, Box<dyn Error>> = match task {
        // The profile shared with the tests has checks that a release has not.
        task if cfg!(debug_assertions) && task.takes_times() => in_release(),
        Task::Verify(arguments) => verify::run(&arguments),
        Task::Mutants(arguments) => mutants::run(&arguments),
        Task::Prove(arguments) => prove::run(&arguments),
        Task::Replay(arguments) => replay::run(&arguments),
        Task::Bench(arguments) => bench::run(&arguments),
        Task::Instructions(arguments) => instructions::run(&arguments),
        Task::Mesh(arguments) => mesh::run(&arguments).map(|()| true),
        Task::Report(arguments) => report::run(&arguments).map(|()| true),
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

/// Runs the same task in a release build of this program.
fn in_release() -> Result<bool, Box<dyn Error>> {
    let status = Command::new(cargo())
        .args(["run", "--release", "--manifest-path"])
        .arg(in_workspace("xtask/Cargo.toml"))
        .arg("--")
        .args(env::args_os().skip(1))
        .status()?;
    Ok(status.success())
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::Task;

    #[test]
    fn every_task_says_what_it_does_and_takes() {
        let mut tasks = Task::command();
        tasks.build();
        let mut said = tasks.render_long_help().to_string();
        for task in tasks.get_subcommands_mut().filter(|task| task.get_name() != "help") {
            said += &format!("\n$ cargo xtask {} --help\n{}", task.get_name(), task.clone().render_long_help());
        }
        insta::assert_snapshot!(said);
    }
}
