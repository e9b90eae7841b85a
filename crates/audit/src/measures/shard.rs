//! A part of a run in a file, to be merged with the others wherever they were computed.
//!
//! JSON. Numbers that may be infinite are written as text, shortest digits that read back as the same double.

use std::collections::BTreeMap;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::cases::family::Name;
use crate::measures::distribution::{Bin, Distribution, Extreme};
use crate::measures::leading::Leading;
use crate::measures::run::{Part, Run};
use crate::measures::tally::{FamilyTally, Tally};

/// The tally of a part, with the run that it is a part of.
#[derive(Debug, Clone, PartialEq)]
pub struct Shard<K, Q> {
    /// The part.
    pub run: Run,
    /// Its tally.
    pub table: Tally<K, Q>,
}

/// Why shards cannot be read or do not make a whole.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Not a shard.
    #[error("not a shard: {0}")]
    Json(#[from] serde_json::Error),
    /// A text in the file has not the expected form.
    #[error("not a shard: {0}")]
    Text(String),
    /// There is none.
    #[error("there is no shard to merge")]
    None,
    /// Two shards are of different runs.
    #[error("shards of different runs: {first:?} and {other:?}")]
    Different {
        /// The run of the first shard.
        first: Run,
        /// Another one's.
        other: Run,
    },
    /// A part is there twice or not at all.
    #[error("part {index} of {of} is there {times} times, not once")]
    Parts {
        /// Which part.
        index: u64,
        /// Of how many.
        of: u64,
        /// How often it is there.
        times: usize,
    },
}

impl<K, Q> Shard<K, Q>
where
    K: Ord + Copy + Serialize + DeserializeOwned,
    Q: Ord + Copy + Serialize + DeserializeOwned,
{
    /// As JSON.
    ///
    /// # Errors
    /// If memory is exhausted.
    pub fn to_json(&self) -> Result<String, Error> {
        Ok(serde_json::to_string(&File::from(self))?)
    }

    /// From JSON.
    ///
    /// # Errors
    /// If it is not JSON, or not a shard.
    pub fn from_json(text: &str) -> Result<Self, Error> {
        serde_json::from_str::<File<K, Q>>(text)?.try_into()
    }

    /// The whole that the shards are the parts of.
    ///
    /// # Errors
    /// If they are of different runs, or a part is missing or there twice.
    pub fn merge(shards: &[Self]) -> Result<Self, Error> {
        let first = &shards.first().ok_or(Error::None)?.run;
        let parts = first.part.of;
        if let Some(other) =
            shards.iter().map(|s| &s.run).find(|run| Run { part: first.part, ..(*run).clone() } != *first || run.part.of != parts)
        {
            return Err(Error::Different { first: first.clone(), other: other.clone() });
        }
        for index in 0..parts {
            let times = shards.iter().filter(|s| s.run.part.index == index).count();
            if times != 1 {
                return Err(Error::Parts { index, of: parts, times });
            }
        }
        let table = shards.iter().map(|s| s.table.clone()).collect();
        Ok(Self { run: Run { part: Part::WHOLE, ..first.clone() }, table })
    }
}

/// The file as it is written.
#[derive(Serialize, Deserialize)]
#[serde(bound(deserialize = "K: Ord + DeserializeOwned, Q: Ord + DeserializeOwned"))]
struct File<K, Q> {
    seed: u64,
    cases: Vec<(String, u64)>,
    part: Part,
    table: BTreeMap<String, FamilyFile<K, Q>>,
}

#[derive(Serialize, Deserialize)]
#[serde(bound(deserialize = "K: Ord + DeserializeOwned, Q: Ord + DeserializeOwned"))]
struct FamilyFile<K, Q> {
    counts: BTreeMap<K, BinFile>,
    figures: BTreeMap<Q, DistributionFile>,
}

#[derive(Serialize, Deserialize)]
struct DistributionFile {
    bins: BTreeMap<String, BinFile>,
    worst: String,
    worst_case: String,
}

#[derive(Serialize, Deserialize)]
struct BinFile {
    count: u64,
    first: String,
}

impl From<&Bin> for BinFile {
    fn from(bin: &Bin) -> Self {
        Self { count: bin.count, first: bin.first.to_string() }
    }
}

impl TryFrom<&BinFile> for Bin {
    type Error = Error;

    fn try_from(file: &BinFile) -> Result<Self, Error> {
        Ok(Self { count: file.count, first: text(&file.first)? })
    }
}

impl<K: Ord + Copy, Q: Ord + Copy> From<&Shard<K, Q>> for File<K, Q> {
    fn from(Shard { run, table }: &Shard<K, Q>) -> Self {
        let families = table.families().iter().map(|(family, table)| {
            let counts = table.counts().iter().map(|(kind, bin)| (*kind, bin.into())).collect();
            let figures =
                table.figures().iter().filter_map(|(q, d)| Some((*q, DistributionFile::from_distribution(d)?))).collect();
            (family.to_string(), FamilyFile { counts, figures })
        });
        Self {
            seed: run.seed,
            cases: run.cases.iter().map(|(family, count)| (family.to_string(), *count)).collect(),
            part: run.part,
            table: families.collect(),
        }
    }
}

impl DistributionFile {
    /// `None` of the empty distribution, which no table holds.
    fn from_distribution(distribution: &Distribution) -> Option<Self> {
        let worst = distribution.worst()?;
        let bins = distribution.bins().iter().map(|(step, bin)| (step.to_string(), bin.into())).collect();
        Some(Self { bins, worst: worst.value.to_string(), worst_case: worst.case.to_string() })
    }

    fn read(&self) -> Result<Distribution, Error> {
        let bin = |(step, bin): (&String, &BinFile)| Ok((text::<Leading>(step)?, bin.try_into()?));
        let bins = self.bins.iter().map(bin).collect::<Result<_, Error>>()?;
        Ok(Distribution::from_parts(bins, Some(Extreme { value: text(&self.worst)?, case: text::<Name>(&self.worst_case)? })))
    }
}

impl<K: Ord + Copy, Q: Ord + Copy> TryFrom<File<K, Q>> for Shard<K, Q> {
    type Error = Error;

    fn try_from(file: File<K, Q>) -> Result<Self, Error> {
        let cases = file.cases.iter().map(|(name, count)| Ok((text(name)?, *count))).collect::<Result<_, Error>>()?;
        let run = Run { seed: file.seed, cases, part: file.part };
        let family = |(name, file): (&String, &FamilyFile<K, Q>)| {
            let counts = file.counts.iter().map(|(kind, bin)| Ok((*kind, bin.try_into()?)));
            let figures = file.figures.iter().map(|(figure, d)| Ok((*figure, d.read()?)));
            let counts = counts.collect::<Result<_, Error>>()?;
            let figures = figures.collect::<Result<_, Error>>()?;
            Ok((text(name)?, FamilyTally::from_parts(counts, figures)))
        };
        let table = Tally::from_parts(file.table.iter().map(family).collect::<Result<_, Error>>()?);
        Ok(Self { run, table })
    }
}

fn text<T: std::str::FromStr>(text: &str) -> Result<T, Error>
where
    T::Err: std::fmt::Display,
{
    text.parse().map_err(|error: T::Err| Error::Text(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases::family::Family;
    use crate::measures::measure::{Kind, Outcome, Quantity};
    use crate::measures::table::Table;

    type Shard = super::Shard<Kind, Quantity>;

    fn shard(index: u64, of: u64) -> Shard {
        let run = Run { part: Part { index, of }, ..Run::of_each(6, &[Family::Far, Family::NGon], 1) };
        let outcome = |name: Name| match name.index {
            4 => Outcome::Refused("why".to_owned()),
            5 => Outcome::Measured([f64::INFINITY; 6]),
            _ => Outcome::Measured([0.0, 1e-17 / 3.0, name.index as f64, 0.1, 0.2, 0.3]),
        };
        let table = run.names().map(|name| Table::single(name, &outcome(name))).collect();
        Shard { run, table }
    }

    #[test]
    fn a_shard_reads_back_bit_for_bit() {
        let shard = shard(1, 3);
        assert_eq!(Shard::from_json(&shard.to_json().unwrap()).unwrap(), shard);
    }

    #[test]
    fn shards_from_files_merge_to_exactly_the_whole() {
        let parts: Vec<Shard> = [2, 0, 1].map(|index| Shard::from_json(&shard(index, 3).to_json().unwrap()).unwrap()).into();
        assert_eq!(Shard::merge(&parts).unwrap(), shard(0, 1));
    }

    #[test]
    fn what_does_not_make_a_whole_is_refused() {
        let message = |shards: &[Shard]| Shard::merge(shards).unwrap_err().to_string();
        assert_eq!(message(&[shard(0, 3), shard(2, 3)]), "part 1 of 3 is there 0 times, not once");
        assert_eq!(message(&[shard(0, 2), shard(1, 2), shard(1, 2)]), "part 1 of 2 is there 2 times, not once");
        let mut other = shard(1, 2);
        other.run.seed = 2;
        assert!(message(&[shard(0, 2), other]).contains("different runs"));
        assert!(message(&[]).contains("no shard"));
    }

    #[test]
    fn damage_is_named() {
        let text = shard(0, 1).to_json().unwrap().replace("n-gon:1:0", "m-gon:1:0");
        assert!(Shard::from_json(&text).unwrap_err().to_string().contains("m-gon"));
    }
}
