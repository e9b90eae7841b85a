//! `radgrad check`: whether the faces of a scene close, and at which edges they do not.

use std::io::{self, Write};

use radgrad_scene::{Closedness, Error, Materials, Part, Scene, Seam, SeamKind, printable};

use crate::scene::SceneFile;

/// Edges of a kind, and parts, that are listed one by one.
const LISTED: usize = 10;

/// The options of `radgrad check`.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    scene: SceneFile,
}

/// Why there is no answer.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error(transparent)]
    Scene(#[from] Error),
    #[error("cannot write what was found: {0}")]
    Output(#[from] io::Error),
}

/// Prints the findings; whether every edge has its counterpart.
pub(crate) fn run(arguments: &Arguments) -> Result<bool, Failure> {
    let scene = arguments.scene.read(Materials::Optional)?;
    let found = scene.closedness();
    print(&scene, &found, &mut io::stdout().lock())?;
    Ok(found.seams.is_empty())
}

fn print(scene: &Scene, found: &Closedness, out: &mut impl Write) -> io::Result<()> {
    let Closedness { edges, seams, parts } = found;
    let closed = parts.iter().filter(|part| part.is_closed).count();
    writeln!(out, "{} faces of {} surfaces, {edges} edges", scene.faces().len(), scene.surfaces().len())?;
    let verdict = if seams.is_empty() { "closed" } else { "not closed" };
    writeln!(out, "{verdict}: {closed} of {} parts are closed", parts.len())?;
    for (kind, meaning) in [
        (SeamKind::Open, "open, a side of one face alone"),
        (SeamKind::Turned, "turned, sides of two faces one of which is turned around"),
        (SeamKind::Doubled, "doubled, sides of more than two faces"),
    ] {
        let of_kind: Vec<&Seam> = seams.iter().filter(|seam| seam.kind == kind).collect();
        if of_kind.is_empty() {
            continue;
        }
        writeln!(out, "{} edges are {meaning}:", of_kind.len())?;
        for Seam { ends: [from, to], faces, .. } in of_kind.iter().take(LISTED) {
            let names: Vec<String> = faces.iter().map(|&face| named(scene, face)).collect();
            writeln!(out, "  {from} to {to}: {}", names.join(", "))?;
        }
        if let Some(more @ 1..) = of_kind.len().checked_sub(LISTED) {
            writeln!(out, "  and {more} more")?;
        }
    }
    for (index, Part { faces, is_closed, volume }) in parts.iter().enumerate().take(LISTED) {
        let first = named(scene, faces[0]);
        let state = match (is_closed, *volume < 0.0) {
            (false, _) => "is not closed".to_owned(),
            (true, true) => format!("is a room of volume {:.6}, seen from inside", -volume),
            (true, false) if index == 0 && parts.len() > 1 => {
                format!("is a body of volume {volume:.6}, seen from outside: if it is the room, turn it around with --flip")
            }
            (true, false) => format!("is a body of volume {volume:.6}, seen from outside"),
        };
        let count = faces.len();
        writeln!(out, "part of {count} face{} from {first} on {state}", if count == 1 { "" } else { "s" })?;
    }
    if let Some(more @ 1..) = parts.len().checked_sub(LISTED) {
        writeln!(out, "and {more} parts more")?;
    }
    Ok(())
}

/// A face, its surface and its place in the file.
fn named(scene: &Scene, face: usize) -> String {
    let of = &scene.faces()[face];
    let name = scene.surfaces()[of.surface()].name();
    match of.place() {
        Some(place) => format!("face {face} of `{}` ({place})", printable(name)),
        None => format!("face {face} of `{}`", printable(name)),
    }
}
