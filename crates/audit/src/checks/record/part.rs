//! Records of parts of factors.

use super::statement::{Recorded, Statement};
use crate::checks::{exchanges, hidden, screens};

/// A part of the computation of factors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// The sum over two edges.
    Edges,
    /// The exchange of two polygons with nothing in between.
    Exchange,
    /// Brackets past screens.
    Screens,
    /// Shares beside an edge.
    Share,
    /// The largest distance up to which a decision allows for rounding.
    Reach,
    /// The work of searches.
    Work,
}

impl Part {
    pub(super) const ALL: [(&str, Self); 6] = [
        ("edges", Self::Edges),
        ("exchange", Self::Exchange),
        ("screens", Self::Screens),
        ("share", Self::Share),
        ("reach", Self::Reach),
        ("work", Self::Work),
    ];

    pub(super) fn name(self) -> &'static str {
        Self::ALL.into_iter().find(|(_, part)| *part == self).map_or("other", |(name, _)| name)
    }

    /// The statements on a drawn case of this part.
    pub(super) fn asked(self, index: u64) -> Result<Recorded, String> {
        let reached = |reaches: Vec<f64>| reaches.into_iter().map(|reach| Statement::new(&[], reach)).collect();
        Ok(match self {
            Self::Edges => Recorded::of_pairs(&exchanges::recorded_edges(index)),
            Self::Exchange => Recorded::of_pairs(&exchanges::recorded(index)?),
            Self::Screens => Recorded::of_pairs(&screens::recorded(index)?),
            Self::Share => Recorded::of_pairs(&screens::recorded_shares(index)?),
            Self::Reach => Recorded { statements: reached(hidden::recorded(index)?), wrong: Vec::new() },
            Self::Work => Recorded { statements: reached(hidden::recorded_work(index)?), wrong: Vec::new() },
        })
    }
}
