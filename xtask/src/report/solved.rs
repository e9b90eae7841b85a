//! Solved scenes: two squares whose radiosity is known ([`effectivity`]), a room with a block ([`room`]), and where the errors of
//! both come from ([`ledger`]).

use std::error::Error;

use super::plates::Plate;
use super::room::Cells;
use super::table::Table;
use super::{effectivity, ledger, room};

/// The parts of them that are shown.
#[derive(Clone)]
pub(super) struct Solved {
    pub(super) plates: Vec<Plate>,
    pub(super) ledger: Plate,
    pub(super) known: Table,
    /// `effectivity.csv`.
    pub(super) effectivity_csv: Vec<u8>,
    /// `elements.csv`: of the room.
    pub(super) elements_csv: Vec<u8>,
    /// `ledger.csv`.
    pub(super) ledger_csv: Vec<u8>,
}

/// Solves and draws.
pub(super) fn solved() -> Result<Solved, Box<dyn Error>> {
    let squares = effectivity::squares()?;
    let (trials, finest) = (effectivity::trials(&squares)?, effectivity::finest(&squares)?);
    let room = room::solution()?;
    let cells = Cells::visible(&room)?;
    Ok(Solved {
        plates: vec![cells.radiosity(&room)?, cells.estimate(&room)?, effectivity::picture(&trials)],
        ledger: ledger::picture([&finest, &room]),
        known: effectivity::table(&trials),
        effectivity_csv: effectivity::csv(&trials)?,
        elements_csv: cells.csv(&room)?,
        ledger_csv: ledger::csv([&finest, &room])?,
    })
}
