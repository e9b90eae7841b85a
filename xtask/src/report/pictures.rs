//! The pictures that need no audit, drawn from the code, and the files of their values.

use std::error::Error;

use super::Beside;
use super::plates::{Plate, plates};
use super::shadow::{Shadow, shadow};
use super::sight::{Sight, sight};
use super::solved::{Solved, solved};

#[derive(Clone)]
pub(super) struct Pictures {
    pub(super) plates: Vec<Plate>,
    pub(super) shadow: Shadow,
    pub(super) sight: Sight,
    pub(super) solved: Solved,
    /// The files of their values.
    pub(super) data: Vec<Beside>,
}

impl Pictures {
    pub(super) fn draw() -> Result<Self, Box<dyn Error>> {
        let (plates, values) = plates()?;
        let (mut shadow, mut sight, mut solved) = (shadow()?, sight()?, solved()?);
        let take = std::mem::take;
        let data = vec![
            ("plates.csv", values),
            ("shadow.csv", take(&mut shadow.floor)),
            ("shadow-cut.csv", take(&mut shadow.cut)),
            ("sight.csv", take(&mut sight.csv)),
            ("elements.csv", take(&mut solved.elements_csv)),
            ("effectivity.csv", take(&mut solved.effectivity_csv)),
            ("ledger.csv", take(&mut solved.ledger_csv)),
        ];
        Ok(Self { plates, shadow, sight, solved, data })
    }
}
