//! The inputs that a heat balance refuses.

/// Why there is no heat balance. Surfaces are numbered from 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HeatError {
    /// Areas, emittances, boundaries and rows of factors are not as many.
    #[error("{count} {what}, and {rows} rows of factors: give one for each surface")]
    Count {
        /// Their name.
        what: &'static str,
        /// How many there are.
        count: usize,
        /// Rows of factors.
        rows: usize,
    },
    /// A number is outside its range.
    #[error("surface {surface}: {what} is {value:?}: it must be {range}")]
    Range {
        /// The surface.
        surface: usize,
        /// The name of the number.
        what: &'static str,
        /// The number.
        value: f64,
        /// The range of the number.
        range: &'static str,
    },
    /// The temperature of the surroundings is outside its range.
    #[error("the surroundings' temperature is {value:e}: it must be finite and at least 0 K")]
    Surroundings {
        /// The temperature.
        value: f64,
    },
    /// A factor to a surface that is not there, or a second factor to one.
    #[error("surface {from}: a factor to surface {to}, which {defect}")]
    Column {
        /// The surface of the row.
        from: usize,
        /// The surface it sees.
        to: usize,
        /// The defect.
        defect: &'static str,
    },
    /// `A_i F_ij` is not `A_j F_ji`.
    #[error(
        "surfaces {from} and {to}: area times factor is {there:e} one way and {back:e} the other, but exchange is reciprocal: \
         check that areas belong to these factors"
    )]
    Reciprocity {
        /// One surface.
        from: usize,
        /// The other one.
        to: usize,
        /// Area times factor from the first.
        there: f64,
        /// The same from the second.
        back: f64,
    },
    /// A row sums to more than 1.
    #[error("surface {surface}: its factors sum to {sum:.6}, above 1: faces lie in one place, or a factor is there twice")]
    MoreThanAll {
        /// The surface.
        surface: usize,
        /// The sum.
        sum: f64,
    },
    /// A row sums to less than 1, and the surroundings have no temperature.
    #[error(
        "surface {surface}: its factors sum to {sum:.6}, so it sees the surroundings: give surroundings=KELVIN, their temperature, or close the scene"
    )]
    Open {
        /// The surface.
        surface: usize,
        /// The sum.
        sum: f64,
    },
    /// Neither a temperature nor the surroundings fix the level of a surface.
    #[error("surface {surface}: no temperature is known of what it sees, not even past others: give one of these a temperature")]
    NoLevel {
        /// The surface.
        surface: usize,
    },
    /// A surface that absorbs nothing was given a flux.
    #[error(
        "surface {surface}: with an emittance of 0 it is a perfect mirror, which neither gives nor takes heat: its flux must be 0"
    )]
    Mirror {
        /// The surface.
        surface: usize,
    },
    /// A surface would have to be colder than 0 K.
    #[error(
        "surface {surface}: it would have to be below absolute zero to take the flux that it is given: its emissive power would be {power:e} W/m2"
    )]
    BelowZero {
        /// The surface.
        surface: usize,
        /// The power that it would have to emit if black.
        power: f64,
    },
    /// The system is too close to one without a solution.
    #[error(
        "surface {surface}: its heat is out of balance by {residual:e} of what it exchanges: some emittance is next to 0, or a number too large"
    )]
    Unsettled {
        /// The surface.
        surface: usize,
        /// Heat out of balance over heat exchanged.
        residual: f64,
    },
}

impl HeatError {
    /// The one surface that it is about; none if it is about two, or about all.
    #[must_use]
    pub const fn surface(&self) -> Option<usize> {
        match *self {
            Self::Range { surface, .. }
            | Self::Column { from: surface, .. }
            | Self::MoreThanAll { surface, .. }
            | Self::Open { surface, .. }
            | Self::NoLevel { surface }
            | Self::Mirror { surface }
            | Self::BelowZero { surface, .. }
            | Self::Unsettled { surface, .. } => Some(surface),
            Self::Count { .. } | Self::Surroundings { .. } | Self::Reciprocity { .. } => None,
        }
    }

    /// The message with the name that the caller has for its surface.
    #[must_use]
    pub fn named(&self, name: impl FnOnce(usize) -> String) -> String {
        let said = self.to_string();
        match self.surface() {
            Some(surface) => said.replacen(&format!("surface {surface}"), &name(surface), 1),
            None => said,
        }
    }
}
