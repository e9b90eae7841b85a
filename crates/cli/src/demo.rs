//! `radgrad demo`: scenes to begin with, and the commands that use them.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use radgrad_scene::output::{Unwritten, write_whole};

/// The options of `radgrad demo`.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Which scene.
    #[arg(value_enum)]
    scene: Demo,
    /// The folder that its files are written to.
    #[arg(long, value_name = "FOLDER", default_value = ".")]
    out: PathBuf,
}

/// A scene of the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Demo {
    /// A room with two lamps and furniture, in metres and cd/m2.
    Office,
    /// A living room with a window, a lamp and furniture, in colours, in metres and cd/m2.
    Room,
    /// The Cornell box, in millimetres.
    Cornell,
    /// A street between two blocks under a sky.
    Canyon,
    /// A furnace with a billet, for its heat balance.
    Furnace,
}

impl Demo {
    const fn files(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::Office => &[("office.obj", include_str!("demo/office.obj")), ("office.mtl", include_str!("demo/office.mtl"))],
            Self::Cornell => {
                &[("cornell.obj", include_str!("demo/cornell.obj")), ("cornell.mtl", include_str!("demo/cornell.mtl"))]
            }
            Self::Room => &[("room.obj", include_str!("demo/room.obj")), ("room.mtl", include_str!("demo/room.mtl"))],
            Self::Canyon => &[("canyon.obj", include_str!("demo/canyon.obj")), ("canyon.mtl", include_str!("demo/canyon.mtl"))],
            Self::Furnace => &[
                ("furnace.obj", include_str!("demo/furnace.obj")),
                ("furnace.mtl", include_str!("demo/furnace.mtl")),
                ("surfaces.csv", include_str!("demo/surfaces.csv")),
            ],
        }
    }

    const fn commands(self) -> &'static [&'static str] {
        match self {
            Self::Office => &[
                "radgrad check office.obj",
                "radgrad solve office.obj --error 1% --lux --grid z=0.75,step=0.5,margin=0.5 --answers office.csv",
                "radgrad solve office.obj --error 1% --view office.png --camera \"0.3 3.8 1.7  5 1 1  0 0 1  60\"",
            ],
            Self::Cornell => &[
                "radgrad solve cornell.obj --error 1%",
                "radgrad solve cornell.obj --error 1% --view cornell.png --camera \"278 273 -800  278 273 0  0 1 0  39\"",
            ],
            Self::Room => &[
                "radgrad check room.obj",
                "radgrad solve room.obj --error 2% --lux --grid z=0.8,step=0.5,margin=0.5 --answers room.csv",
                "radgrad solve room.obj --error 2% --view room.png --camera \"0.4 0.3 1.7  3.2 2.4 0.9  0 0 1  65\"",
            ],
            Self::Canyon => &[
                "radgrad check canyon.obj",
                "radgrad factors canyon.obj --from street --to sky",
                "radgrad solve canyon.obj --error 1% --view canyon.png --camera \"3 23.5 17  40 18.5 3  0 0 1  60\"",
            ],
            Self::Furnace => &[
                "radgrad check furnace.obj",
                "radgrad factors furnace.obj --out factors.csv",
                "radgrad heat factors.csv surfaces.csv",
            ],
        }
    }
}

/// Why there is no scene.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error(transparent)]
    Unwritten(#[from] Unwritten),
    #[error("`{}` is there already: remove it, or name another folder with --out", .0.display())]
    There(PathBuf),
    #[error("cannot write the commands: {0}")]
    Output(#[from] io::Error),
}

/// Writes the files, and prints the commands.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let files: Vec<(PathBuf, &str)> =
        arguments.scene.files().iter().map(|(name, text)| (arguments.out.join(name), *text)).collect();
    let differs = |(file, text): &&(PathBuf, &str)| {
        file.exists() && radgrad_scene::read_file(file, text.len() as u64).ok().as_deref() != Some(text.as_bytes())
    };
    if let Some((file, _)) = files.iter().find(differs) {
        return Err(Failure::There(file.clone()));
    }
    for (file, text) in &files {
        write_whole(file, |out| out.write_all(text.as_bytes()))?;
    }
    let mut out = io::stdout().lock();
    let names: Vec<String> = files.iter().map(|(file, _)| file.display().to_string()).collect();
    writeln!(out, "{} {} written. Now try", names.join(", "), if names.len() == 1 { "is" } else { "are" })?;
    if arguments.out != Path::new(".") {
        writeln!(out, "  cd {}", arguments.out.display())?;
    }
    arguments.scene.commands().iter().try_for_each(|command| writeln!(out, "  {command}"))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cornell_box_is_that_of_the_project() {
        for (name, text) in Demo::Cornell.files() {
            let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/scenes").join(name);
            assert_eq!(&std::fs::read_to_string(file).unwrap(), text);
        }
    }
}
