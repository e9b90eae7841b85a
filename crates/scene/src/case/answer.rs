//! The output for a line: its answer, or the reason why it has none.

use serde::ser::{Serialize, SerializeStruct, Serializer};

use super::Id;
use crate::Error;

/// Radiosity and gradient of one case with their proven bounds.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct AnswerRecord {
    /// Name of the case.
    pub id: Id,
    /// Radiosity, in the unit of the emission.
    pub radiosity: f64,
    /// Gradient, in that unit over the unit of length.
    pub gradient: [f64; 3],
    /// Proven bound on the error of `radiosity`.
    pub radiosity_error: f64,
    /// Proven bound on the Euclidean norm of the error of `gradient`.
    pub gradient_error: f64,
    /// The method that answered.
    pub method: &'static str,
}

impl AnswerRecord {
    /// The record of `answer` to the case `id`.
    #[must_use]
    pub fn new(id: Id, answer: &radgrad_core::Answer) -> Self {
        Self {
            id,
            radiosity: answer.radiosity,
            gradient: answer.gradient.to_array(),
            radiosity_error: answer.radiosity_error,
            gradient_error: answer.gradient_error,
            method: answer.method.name(),
        }
    }
}

/// A line without an answer: `{"id": .., "error": ".."}`. Where the id cannot be read it is null, and the line number stands both
/// in `line` and before the message.
#[derive(Debug, Clone, PartialEq)]
pub struct Refusal {
    /// Name of the case, if it can be read.
    pub id: Option<Id>,
    /// Number of the line, from 1, blank lines counted.
    pub line: usize,
    /// The reason.
    pub error: Error,
}

impl Serialize for Refusal {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut object = serializer.serialize_struct("Refusal", 3)?;
        object.serialize_field("id", &self.id)?;
        if self.id.is_some() {
            object.skip_field("line")?;
            object.serialize_field("error", &self.error.to_string())?;
        } else {
            object.serialize_field("line", &self.line)?;
            object.serialize_field("error", &format!("line {}: {}", self.line, self.error))?;
        }
        object.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_number_stands_in_for_a_missing_id() {
        let error = Error::Json { column: 3, rule: "expected value".to_owned() };
        let nameless = Refusal { id: None, line: 7, error: error.clone() };
        assert_eq!(
            serde_json::to_string(&nameless).unwrap(),
            r#"{"id":null,"line":7,"error":"line 7: column 3: expected value"}"#
        );
        let named = Refusal { id: Some(Id::from("a1")), line: 7, error };
        assert_eq!(serde_json::to_string(&named).unwrap(), r#"{"id":"a1","error":"column 3: expected value"}"#);
    }
}
