//! Digests: of many thousands of answers every bit, bounds, methods and counts of work with them, as one number a block.
//!
//! Whatever changes changes the digest, however far it is below every bound. Core, the oracle and factors give the same bits on every
//! machine and on every number of threads; solutions and certificates do not, and have records of their own. The statements of a block
//! are held against each other too: all answers to one question have a point in common.

mod bits;
mod of_core;
mod of_others;

use super::statement::{Asked, Recorded, Statement};
use crate::checks::{hidden, lamps};
use bits::Digest;

/// The subject of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Block {
    /// Cases of a family, asked in every way.
    Cases,
    /// Cases on the brink of decisions.
    Brinks,
    /// Receivers in batches, with and without occluders, and emitters from one receiver.
    Batches,
    /// Totals of trees of a few lamps.
    Trees,
    /// Single operations in every arithmetic.
    Operations,
    /// Polygons and emissions.
    Problems,
    /// The oracle's enclosures.
    Enclosures,
    /// The oracle's cubature and samples.
    Estimates,
    /// Edges, exchanges and screens.
    Exchanges,
    /// The index of occluders.
    Index,
    /// Matrices of form factors.
    Factors,
}

impl Block {
    pub(super) const ALL: [(&str, Self); 11] = [
        ("cases", Self::Cases),
        ("brinks", Self::Brinks),
        ("batches", Self::Batches),
        ("trees", Self::Trees),
        ("operations", Self::Operations),
        ("problems", Self::Problems),
        ("enclosures", Self::Enclosures),
        ("estimates", Self::Estimates),
        ("exchanges", Self::Exchanges),
        ("index", Self::Index),
        ("factors", Self::Factors),
    ];

    /// Its name.
    pub(super) fn name(self) -> &'static str {
        Self::ALL.into_iter().find(|(_, block)| *block == self).map_or("other", |(name, _)| name)
    }

    /// Who is asked.
    pub(super) const fn asks(self) -> Asked {
        match self {
            Self::Enclosures | Self::Estimates => Asked::Oracle,
            Self::Exchanges | Self::Index | Self::Factors => Asked::Scenes,
            _ => Asked::Core,
        }
    }

    /// The digest of a block, and the contradictions in it.
    pub(super) fn asked(self, index: u64) -> Result<Recorded, String> {
        let mut digest = Digest::default();
        match self {
            Self::Cases => of_core::of_cases(&mut digest, index),
            Self::Brinks => of_core::of_brinks(&mut digest, index),
            Self::Batches => of_core::of_batches(&mut digest, index),
            Self::Trees => (0..20).for_each(|k| digest.say(lamps::recorded(20 * index + k))),
            Self::Operations => (0..400).for_each(|k| of_core::of_operations(&mut digest, 400 * index + k)),
            Self::Problems => (0..60).for_each(|k| of_core::of_problems(&mut digest, 60 * index + k)),
            Self::Enclosures => of_others::of_enclosures(&mut digest, index),
            Self::Estimates => of_others::of_estimates(&mut digest, index),
            Self::Exchanges => of_others::of_exchanges(&mut digest, index),
            Self::Index => {
                digest.numbers(&hidden::recorded(100 + index)?);
                digest.numbers(&hidden::recorded_work(100 + index)?);
            }
            Self::Factors => of_others::of_factors(&mut digest, index)?,
        }
        if digest.said < 4 * digest.refused && !matches!(self, Self::Cases) {
            digest.wrong.push(format!("{} answers of {} numbers are refused", digest.refused, digest.said));
        }
        // The upper bits, which a double holds.
        let statements = vec![Statement::new(&[], (digest.bits >> 12) as f64)];
        Ok(Recorded { statements, wrong: digest.wrong })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_says_the_same_twice() {
        for (_, block) in Block::ALL {
            assert_eq!(block.asked(1), block.asked(1), "{}", block.name());
        }
    }
}
