//! A run that can be taken up again: which elements were divided, written after every round.
//!
//! The file is one JSON object, `{"scene": "..", "divisions": [..]}`, with `"squares": true` where faces were first cut into squares, as
//! `--divide gradient` does. The scene's fingerprint is over all that the solution depends on, so that a file is not taken for another
//! scene's. Links and radiosities follow from the mesh and are computed anew, in one round instead of all those before.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use radgrad_scene::output::{Held, Unwritten};
use radgrad_scene::{Quantity, Scene, Texture, fnv1a, read_file};
use radgrad_solver::Solution;
use serde::{Deserialize, Serialize};

#[derive(Debug, Serialize, Deserialize)]
struct Checkpoint {
    scene: String,
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    squares: bool,
    divisions: Vec<usize>,
}

/// What a run has to be of to be taken up: a scene by its fingerprint, first cut into squares or not.
pub(crate) struct Run {
    pub(crate) scene: String,
    pub(crate) squares: bool,
}

/// Why a run cannot be taken up.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error("{}: cannot read: {source}", file.display())]
    Read { file: PathBuf, source: io::Error },
    #[error("{}: no file of --resume: {source}", file.display())]
    Content { file: PathBuf, source: serde_json::Error },
    #[error("{}: it was written for another scene, or for this one before it was changed", file.display())]
    Scene { file: PathBuf },
    #[error("{}: it was written {} --divide gradient, whose first elements are others: go on as it began", file.display(), if *with { "with" } else { "without" })]
    Squares { file: PathBuf, with: bool },
}

/// The divisions of a run before; none where there is no file yet, or an empty one as who is killed at once leaves it.
pub(crate) fn read(file: &Path, run: &Run, limit: u64) -> Result<Vec<usize>, Failure> {
    let text = match read_file(file, limit) {
        Ok(text) => text,
        Err(source) if source.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(source) => return Err(Failure::Read { file: file.to_owned(), source }),
    };
    if text.is_empty() {
        return Ok(Vec::new());
    }
    let checkpoint: Checkpoint =
        serde_json::from_slice(&text).map_err(|source| Failure::Content { file: file.to_owned(), source })?;
    if checkpoint.scene != run.scene {
        return Err(Failure::Scene { file: file.to_owned() });
    }
    if checkpoint.squares != run.squares {
        return Err(Failure::Squares { file: file.to_owned(), with: checkpoint.squares });
    }
    Ok(checkpoint.divisions)
}

/// Writes the divisions so far.
pub(crate) fn write(held: &mut Held, run: &Run, solution: &Solution) -> Result<(), Unwritten> {
    let checkpoint = Checkpoint { scene: run.scene.clone(), squares: run.squares, divisions: solution.divisions() };
    held.write(|out| {
        serde_json::to_writer(&mut *out, &checkpoint)?;
        out.write_all(b"\n")
    })
}

/// A digest of the coordinates, the materials and which face has which, and the textures with where faces have them.
pub(crate) fn fingerprint(scene: &Scene) -> String {
    // Of each texture once: materials share them, and faces materials.
    let textures = scene.materials().iter().map(|material| Quantity::ALL.map(|q| material.texture(q).map(|texture| of(texture))));
    let textures: Vec<[Option<u64>; 2]> = textures.collect();
    let mut words = Vec::new();
    for face in scene.faces() {
        words.push(face.polygon().vertices().len() as u64);
        words.extend(face.polygon().vertices().iter().flat_map(|v| v.to_array()).map(f64::to_bits));
        words.push(u64::from(scene.surfaces()[face.surface()].exchanges()));
        let material = &scene.materials()[face.material()];
        words.extend(material.reflectance().iter().map(|rho| rho.to_bits()));
        let emitted = (0..scene.channels().len()).map(|channel| material.emitted_radiosity(channel).unwrap_or(0.0));
        words.extend(emitted.map(f64::to_bits));
        for (which, (quantity, texture)) in Quantity::ALL.into_iter().zip(textures[face.material()]).enumerate() {
            let (Some(texture), Some(chart)) = (texture, face.chart(quantity)) else { continue };
            words.extend([which as u64, texture]);
            // A chart is affine: it is known from where it has the corners.
            words.extend(face.polygon().vertices().iter().flat_map(|v| chart.coordinates(*v)).map(f64::to_bits));
        }
    }
    format!("{:016x}", digest(words))
}

/// The fingerprint of a texture.
fn of(texture: &Texture) -> u64 {
    let sizes = texture.size().into_iter().map(|count| count as u64);
    let wraps = texture.wrap().into_iter().map(|wrap| wrap as u64);
    digest(sizes.chain(wraps).chain(texture.texels().iter().map(|value| value.to_bits())))
}

fn digest(words: impl IntoIterator<Item = u64>) -> u64 {
    fnv1a(words.into_iter().flat_map(u64::to_le_bytes))
}
