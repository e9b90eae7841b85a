//! The scene that a command works on, and how far the work is.

use std::io::IsTerminal;
use std::path::PathBuf;

use indicatif::{ProgressBar, ProgressStyle};
use radgrad_scene::{Degenerate, Error, Scene};

/// Which scene to read, and how.
#[derive(Debug, clap::Args)]
pub(crate) struct SceneFile {
    /// Scene: .obj with its .mtl, .gltf, .glb, .vs3, .stl or .ply.
    #[arg(id = "scene", value_name = "SCENE")]
    pub(crate) path: PathBuf,
    /// Leave out faces that are no polygon with an area instead of refusing the file.
    #[arg(long)]
    drop_degenerate: bool,
}

impl SceneFile {
    /// Reads the scene, and says on the standard error what was changed in it.
    pub(crate) fn read(&self) -> Result<Scene, Error> {
        let degenerate = if self.drop_degenerate { Degenerate::Drop } else { Degenerate::Refuse };
        let scene = Scene::read(&self.path, degenerate)?;
        for note in scene.notes() {
            eprintln!("radgrad: {note}");
        }
        Ok(scene)
    }
}

/// A bar on the standard error, where someone looks at it.
pub(crate) fn progress(steps: usize) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style =
        ProgressStyle::with_template("{wide_bar} {percent:>3} %  {eta} left").unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(steps as u64).with_style(style)
}
