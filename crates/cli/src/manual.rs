//! Completions for shells and pages for `man`, from the program's arguments.

use std::io::{self, Write};
use std::path::Path;

use clap::Command;
use clap_complete::{Shell, generate};
use clap_mangen::Man;
use radgrad_scene::output::write_whole;

/// Prints the script that completes arguments in a shell.
pub(crate) fn completions(mut program: Command, shell: Shell) -> io::Result<()> {
    let mut text = Vec::new();
    generate(shell, &mut program, "radgrad", &mut text);
    io::stdout().lock().write_all(&text)
}

/// Prints the manual page of the program with those of its commands, or writes `radgrad.1`, `radgrad-solve.1`, ... to a folder.
pub(crate) fn write(program: Command, folder: Option<&Path>) -> Result<(), String> {
    // Commands then have the names of their pages.
    let mut program = program.flatten_help(true).disable_help_subcommand(true);
    program.build();
    let mut pages = vec![("radgrad".to_owned(), program.clone())];
    for command in program.get_subcommands() {
        let name = format!("radgrad-{}", command.get_name());
        pages.push((name, command.clone()));
    }
    for (name, page) in pages {
        let mut text = Vec::new();
        Man::new(page).title(&name).render(&mut text).map_err(|error| error.to_string())?;
        match folder {
            Some(folder) => {
                write_whole(&folder.join(format!("{name}.1")), |out| out.write_all(&text)).map_err(|error| error.to_string())?;
            }
            None => io::stdout().lock().write_all(&text).map_err(|error| error.to_string())?,
        }
    }
    Ok(())
}
