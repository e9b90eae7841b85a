//! The request to `cargo xtask verify`: cases or scenes, their families, the whole run or a part of it.

use std::error::Error;
use std::fs;
use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use radgrad_audit::cases::family::Family;
use radgrad_audit::cases::name::UnknownFamily;
use radgrad_audit::measures::run::Part;
use radgrad_audit::measures::shard::Shard;
use radgrad_audit::scenes;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Measure random cases of every family against arbitrary-precision truth; fail if an error is beyond its gate
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Cases in all, by default 42,000 shared among the families; with --bounds 10,000,000, fewer of dear families
    #[arg(long)]
    pub(crate) cases: Option<u64>,
    /// Seed: the same seed gives the same cases on every machine
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Only these families
    #[arg(long)]
    pub(crate) family: Vec<AnyFamily>,
    /// A twentieth of the cases; with --bounds 100,000
    #[arg(long)]
    pub(crate) quick: bool,
    /// Look for bounds below their errors instead, in millions of cases
    #[arg(long)]
    pub(crate) bounds: bool,
    /// Whole scenes instead: bounds of `solve`, `factors` and `field` against truth; 800 scenes unless a number is given
    #[arg(long, conflicts_with = "bounds")]
    pub(crate) scenes: bool,
    /// Factors instead: proven brackets of at least so many pairs of faces against rays, over the families of scenes
    #[arg(long, value_name = "PAIRS", conflicts_with_all = ["bounds", "scenes", "cases"])]
    pub(crate) factors: Option<u64>,
    /// Gradients instead: as `solve --points` finds them by default, at the points of at least so many scenes, against exact slopes and finer solutions
    #[arg(long, value_name = "SCENES", conflicts_with_all = ["bounds", "scenes", "cases", "factors"])]
    pub(crate) gradients: Option<u64>,
    /// Derivatives instead: by vertices, emission, normal and reflectance, of at least so many cases against slopes of the oracle
    #[arg(long, value_name = "CASES", conflicts_with_all = ["bounds", "scenes", "cases", "factors", "gradients"])]
    pub(crate) derivatives: Option<u64>,
    /// With --derivatives: against identities alone, which takes a small part of the time
    #[arg(long, requires = "derivatives")]
    pub(crate) identities: bool,
    /// Print every row of every table, not the worst alone; the files have all rows in any case
    #[arg(long)]
    pub(crate) tables: bool,
    /// Only part I of N, counted from 1, written to OUT as shard-I-of-N.json (bounds-I-of-N.json)
    #[arg(long, value_name = "I/N", value_parser = parse_part, conflicts_with = "merge")]
    pub(crate) shard: Option<Part>,
    /// Measure nothing: merge these shards to the table of the whole run
    #[arg(long, num_args = 1.., value_name = "FILES")]
    pub(crate) merge: Vec<PathBuf>,
    /// Where the tables go
    #[arg(long, default_value = "target/verify")]
    pub(crate) out: PathBuf,
}

impl Arguments {
    pub(crate) fn families(&self) -> Vec<Family> {
        let named = |family: &AnyFamily| if let AnyFamily::Case(family) = family { Some(*family) } else { None };
        if self.family.is_empty() { Family::ALL.to_vec() } else { self.family.iter().filter_map(named).collect() }
    }

    /// The families of scenes asked for: all of them if none is named.
    pub(crate) fn scene_families(&self) -> Vec<scenes::family::Family> {
        let named = |family: &AnyFamily| if let AnyFamily::Scene(family) = family { Some(*family) } else { None };
        let named: Vec<_> = self.family.iter().filter_map(named).collect();
        if named.is_empty() { scenes::family::Family::ALL.to_vec() } else { named }
    }

    /// Refuses a family of scenes where cases are asked for, and the other way round.
    pub(crate) fn check(&self) -> Result<(), String> {
        if self.cases == Some(0) {
            return Err("--cases 0: a run without cases shows nothing; ask for 1 or more".to_owned());
        }
        let of_scenes = self.scenes || self.factors.is_some() || self.gradients.is_some();
        let fits = |family: &AnyFamily| matches!(family, AnyFamily::Scene(_)) == of_scenes;
        match self.family.iter().find(|family| !fits(family)) {
            Some(AnyFamily::Scene(family)) => {
                Err(format!("{family} is a family of scenes: add --scenes, --factors or --gradients"))
            }
            Some(AnyFamily::Case(family)) => {
                Err(format!("{family} is no family of scenes: leave out --scenes, --factors and --gradients"))
            }
            None => Ok(()),
        }
    }

    pub(crate) fn part(&self) -> Part {
        self.shard.unwrap_or(Part::WHOLE)
    }
}

/// A family of points or of scenes.
#[derive(Debug, Clone, Copy)]
pub(crate) enum AnyFamily {
    /// Of cases of one emitter.
    Case(Family),
    /// Of scenes.
    Scene(scenes::family::Family),
}

impl FromStr for AnyFamily {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let of_case = || text.parse().map(Self::Case).map_err(|error: UnknownFamily<_>| error.to_string());
        text.parse().map(Self::Scene).or_else(|no_scene| of_case().map_err(|no_case| format!("{no_case}; {no_scene}")))
    }
}

fn parse_part(text: &str) -> Result<Part, String> {
    let part = text.split_once('/').and_then(|(index, of)| Some((index.parse().ok()?, of.parse().ok()?)));
    match part {
        Some((index, of)) if (1..=of).contains(&index) => Ok(Part { index: index - 1, of }),
        _ => Err(format!("{text:?} is no part: 1/4 to 4/4 are the four quarters")),
    }
}

pub(crate) fn merged<K, Q>(paths: &[PathBuf]) -> Result<Shard<K, Q>, Box<dyn Error>>
where
    K: Ord + Copy + Serialize + DeserializeOwned,
    Q: Ord + Copy + Serialize + DeserializeOwned,
{
    let read = |path: &PathBuf| -> Result<Shard<K, Q>, Box<dyn Error>> {
        let text = fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(Shard::from_json(&text).map_err(|error| format!("{}: {error}", path.display()))?)
    };
    let shards: Vec<Shard<K, Q>> = paths.iter().map(read).collect::<Result<_, _>>()?;
    Ok(Shard::merge(&shards)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_count_from_1_and_end_at_n() {
        assert_eq!(parse_part("1/4"), Ok(Part { index: 0, of: 4 }));
        assert_eq!(parse_part("4/4"), Ok(Part { index: 3, of: 4 }));
        for text in ["0/4", "5/4", "1", "1/0", "a/b"] {
            assert!(parse_part(text).is_err(), "{text}");
        }
    }
}
