//! The program `radgrad`.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(radgrad_cli::run(std::env::args_os()))
}
