//! What can be wrong with a case.

/// Every way in which a case is refused. Messages say where: the column of the line, or the part of the case.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The text is not JSON, a number does not fit a double, a field is missing or has another shape than its own.
    #[error("column {column}: {rule}")]
    Json {
        /// Column of the line, in bytes from 1, where reading stopped.
        column: usize,
        /// What was found and what was expected.
        rule: String,
    },
    /// The receiver is refused.
    #[error(transparent)]
    Receiver(radgrad_core::Error),
    /// The emitter's polygon or its emission is refused.
    #[error("emitter: {0}")]
    Emitter(#[source] radgrad_core::Error),
    /// An occluder is refused.
    #[error("occluder {index}: {source}")]
    Occluder {
        /// Its index in `occluders`, from 0.
        index: usize,
        /// What is wrong with its polygon.
        source: radgrad_core::Error,
    },
    /// The tolerance is not a number in [0, 1].
    #[error(transparent)]
    Tolerance(radgrad_core::Error),
    /// The case is valid, but its answer cannot be represented.
    #[error(transparent)]
    Evaluation(radgrad_core::Error),
}

impl From<serde_json::Error> for Error {
    /// Only the column is kept: to `serde_json` every line is line 1.
    fn from(error: serde_json::Error) -> Self {
        let text = error.to_string();
        let place = format!(" at line {} column {}", error.line(), error.column());
        let rule = text.strip_suffix(&place).unwrap_or(&text).to_owned();
        Self::Json { column: error.column(), rule }
    }
}
