//! What is drawn from: all faults of the code that decides, evaluates or bounds.

use std::collections::HashMap;
use std::error::Error;
use std::fs;
use std::path::Path;

use radgrad_audit::cases::sampler::Sampler;

use super::places::{self, Fault};

/// That code: folders, and files of modules.
const CODE: [&str; 16] = [
    "crates/core/src",
    "crates/numbers/src",
    "crates/oracle/src",
    "crates/certificate/src",
    "crates/scene/src/factors.rs",
    "crates/scene/src/factors",
    "crates/scene/src/occluders.rs",
    "crates/scene/src/occluders",
    "crates/scene/src/projection.rs",
    "crates/scene/src/extremes.rs",
    "crates/solver/src/links.rs",
    "crates/solver/src/links",
    "crates/solver/src/mesh.rs",
    "crates/solver/src/mesh",
    "crates/solver/src/estimate.rs",
    "crates/solver/src/estimate",
];

/// Modules that are compiled for tests alone.
const ONLY_OF_TESTS: [&str; 3] = ["near_ties.rs", "edge_lanes/random.rs", "certificate/src/rooms.rs"];

/// A source file.
#[derive(Debug)]
pub(crate) struct Source {
    /// In the workspace.
    pub(crate) path: String,
    pub(crate) text: String,
}

/// A fault of a file.
#[derive(Debug, Clone)]
pub(crate) struct Drawn {
    /// Which of the sources.
    pub(crate) file: usize,
    pub(crate) fault: Fault,
}

impl Drawn {
    /// The line that the place begins in, from 1, and its text.
    pub(crate) fn line<'a>(&self, sources: &'a [Source]) -> (usize, &'a str) {
        let text = &sources[self.file].text;
        let before = &text[..self.fault.range.start];
        let number = before.matches('\n').count();
        (number + 1, text.lines().nth(number).unwrap_or_default().trim())
    }

    /// What is its own wherever its line stands in the file: the file, the texts of line and place, and what it does.
    fn name(&self, sources: &[Source]) -> String {
        let Source { path, text } = &sources[self.file];
        let start = text[..self.fault.range.start].rfind('\n').map_or(0, |end| end + 1);
        let line = text[start..].lines().next().unwrap_or_default().trim();
        [path, line, &self.text(sources), self.fault.operator].join("\n")
    }

    /// The text of the place, in one line.
    pub(crate) fn text(&self, sources: &[Source]) -> String {
        sources[self.file].text[self.fault.range.clone()].split_whitespace().collect::<Vec<_>>().join(" ")
    }
}

/// The sources, and all their faults in an order that the seed gives. Each has a random number that follows from the seed, the file, and the
/// texts of its line and place: so what changes elsewhere leaves a sample nearly what it was, and what was learned of its survivors holds.
pub(crate) fn shuffled(workspace: &Path, seed: u64) -> Result<(Vec<Source>, Vec<Drawn>), Box<dyn Error>> {
    let (sources, mut all) = read(workspace)?;
    shuffle(&sources, &mut all, seed);
    Ok((sources, all))
}

fn shuffle(sources: &[Source], all: &mut [Drawn], seed: u64) {
    let mut alike: HashMap<String, u64> = HashMap::new();
    all.sort_by_cached_key(|drawn| {
        let name = drawn.name(sources);
        let before = alike.entry(name.clone()).or_default();
        *before += 1;
        let mut sampler = Sampler::new(seed, &name, *before);
        [(); 2].map(|()| sampler.below(u32::MAX))
    });
}

/// In the order of the files.
fn read(workspace: &Path) -> Result<(Vec<Source>, Vec<Drawn>), Box<dyn Error>> {
    let mut paths = Vec::new();
    for place in CODE {
        sources_below(workspace, place, &mut paths)?;
    }
    paths.sort();
    let (mut sources, mut all) = (Vec::new(), Vec::new());
    for (file, path) in paths.into_iter().enumerate() {
        let text = fs::read_to_string(workspace.join(&path)).map_err(|error| format!("{path}: {error}"))?;
        let faults = places::faults(&text).map_err(|error| format!("{path}: {error}"))?;
        all.extend(faults.into_iter().map(|fault| Drawn { file, fault }));
        sources.push(Source { path, text });
    }
    Ok((sources, all))
}

/// All but tests, and what only tests call.
fn sources_below(workspace: &Path, place: &str, found: &mut Vec<String>) -> Result<(), Box<dyn Error>> {
    let path = workspace.join(place);
    if path.is_dir() {
        for entry in fs::read_dir(&path)? {
            let name = entry?.file_name();
            sources_below(workspace, &format!("{place}/{}", name.to_string_lossy()), found)?;
        }
    } else if place.ends_with(".rs") && !place.contains("/tests") && !ONLY_OF_TESTS.iter().any(|file| place.ends_with(file)) {
        found.push(place.to_owned());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::in_workspace;

    #[test]
    fn a_seed_draws_the_same_faults_of_all_of_the_code_and_another_seed_others() {
        let (sources, all) = read(&in_workspace(".")).unwrap();
        assert!(all.len() > 10_000 && CODE.iter().all(|place| sources.iter().any(|source| source.path.starts_with(place))));
        let first = |seed| {
            let mut few: Vec<Drawn> = all.iter().step_by(20).cloned().collect();
            shuffle(&sources, &mut few, seed);
            few[..20].iter().map(|drawn| drawn.name(&sources)).collect::<Vec<_>>()
        };
        assert_eq!(first(1), first(1));
        assert_ne!(first(1), first(2));
    }
}
