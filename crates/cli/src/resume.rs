//! A run that can be taken up again: which elements were divided, written after every round.
//!
//! The file is one JSON object, `{"scene": "..", "divisions": [..]}`. The scene's fingerprint is over all that the solution depends
//! on, so that a file is not taken for another scene's. What follows from the mesh, links and radiosities, is computed anew, in
//! one round instead of all those before.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use radgrad_scene::Scene;
use radgrad_solver::Solution;
use serde::{Deserialize, Serialize};

use crate::output::{Unwritten, write_whole};

#[derive(Debug, Serialize, Deserialize)]
struct Checkpoint {
    scene: String,
    divisions: Vec<usize>,
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
}

/// The divisions of a run before; none where there is no file yet.
pub(crate) fn read(file: &Path, scene: &Scene) -> Result<Vec<usize>, Failure> {
    let text = match std::fs::read_to_string(file) {
        Ok(text) => text,
        Err(source) if source.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(source) => return Err(Failure::Read { file: file.to_owned(), source }),
    };
    let checkpoint: Checkpoint =
        serde_json::from_str(&text).map_err(|source| Failure::Content { file: file.to_owned(), source })?;
    if checkpoint.scene != fingerprint(scene) {
        return Err(Failure::Scene { file: file.to_owned() });
    }
    Ok(checkpoint.divisions)
}

/// Writes what has been divided so far.
pub(crate) fn write(file: &Path, scene: &Scene, solution: &Solution) -> Result<(), Unwritten> {
    let checkpoint = Checkpoint { scene: fingerprint(scene), divisions: solution.divisions() };
    write_whole(file, |out| {
        serde_json::to_writer(&mut *out, &checkpoint)?;
        out.write_all(b"\n")
    })
}

/// FNV-1a over the coordinates, the materials and which face has which.
fn fingerprint(scene: &Scene) -> String {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    let mut take = |bits: u64| {
        for byte in bits.to_le_bytes() {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    };
    for face in scene.faces() {
        take(face.polygon().vertices().len() as u64);
        face.polygon().vertices().iter().flat_map(|v| v.to_array()).for_each(|c| take(c.to_bits()));
        take(u64::from(scene.surfaces()[face.surface()].exchanges()));
        let material = &scene.materials()[face.material()];
        material.reflectance().iter().for_each(|rho| take(rho.to_bits()));
        for channel in 0..scene.channels().len() {
            take(material.emitted_radiosity(channel).unwrap_or(0.0).to_bits());
        }
    }
    format!("{hash:016x}")
}
