//! The output for a line: its answer, or the reason why it has none.

use serde::ser::{Serialize, SerializeStruct, Serializer};

use super::derivatives::{DerivativesRecord, finite};
use super::id::Id;
use crate::error::Error;

/// The output for a case that has an answer.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[serde(untagged)]
pub enum Reply {
    /// In doubles, with proven bounds.
    Doubles(AnswerRecord),
    /// In decimal digits, with proven bounds.
    Digits(DigitsRecord),
    /// Of an emission without a closed form, with an estimate of the error.
    Estimate(EstimateRecord),
}

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
    /// Second derivatives, if they were asked for: rows of a symmetric matrix.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hessian: Option<[[f64; 3]; 3]>,
    /// Proven bound on the Frobenius norm of the error of `hessian`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hessian_error: Option<f64>,
    /// Derivatives by everything that shapes the radiosity, if they were asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub derivatives: Option<DerivativesRecord>,
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
            hessian: None,
            hessian_error: None,
            derivatives: None,
            method: answer.method.name(),
        }
    }

    pub(super) fn with_hessian(self, hessian: &radgrad_core::Hessian) -> Self {
        Self { hessian: Some(hessian.matrix.to_cols_array_2d()), hessian_error: Some(hessian.error), ..self }
    }

    /// Whether all numbers are: JSON has no others.
    pub(super) fn check_finite(&self) -> Result<(), Error> {
        let [x, y, z] = self.gradient;
        let named = [
            ("the radiosity", self.radiosity),
            ("the gradient along x", x),
            ("the gradient along y", y),
            ("the gradient along z", z),
            ("the bound on the radiosity", self.radiosity_error),
            ("the bound on the gradient", self.gradient_error),
        ];
        let second = self.hessian.into_iter().flatten().flatten().map(|c| ("the Hessian", c));
        let bound = self.hessian_error.map(|error| ("the bound on the Hessian", error));
        named.into_iter().chain(second).chain(bound).try_for_each(|(what, value)| finite(what, value))
    }
}

/// Radiosity and gradient in decimal digits with their proven bounds, all of them strings.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct DigitsRecord {
    /// Name of the case.
    pub id: Id,
    /// Radiosity, in the unit of the emission.
    pub radiosity: String,
    /// Gradient, in that unit over the unit of length.
    pub gradient: [String; 3],
    /// Proven bound on the error of `radiosity`.
    pub radiosity_error: String,
    /// Proven bound on the Euclidean norm of the error of `gradient`.
    pub gradient_error: String,
    /// Digits that were asked for.
    pub digits: u32,
    /// Bits of the numbers that gave the answer.
    pub bits: usize,
    /// The method that answered.
    pub method: &'static str,
}

impl DigitsRecord {
    /// The record of `answer` to the case `id`.
    #[must_use]
    pub fn new(id: Id, answer: radgrad_core::PreciseAnswer, digits: u32) -> Self {
        let radgrad_core::PreciseAnswer { radiosity, gradient, radiosity_error, gradient_error, bits } = answer;
        let method = if bits == 0 { radgrad_core::Method::Zero } else { radgrad_core::Method::ArbitraryPrecision };
        Self { id, radiosity, gradient, radiosity_error, gradient_error, digits, bits, method: method.name() }
    }
}

/// Radiosity and gradient of an emission without a closed form. The errors beside them are estimates, not bounds.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct EstimateRecord {
    /// Name of the case.
    pub id: Id,
    /// Radiosity, in the unit of the emission.
    pub radiosity: f64,
    /// Gradient, in that unit over the unit of length.
    pub gradient: [f64; 3],
    /// By how much `radiosity` is estimated to be off.
    pub radiosity_estimate: f64,
    /// By how much `gradient` is estimated to be off, in its Euclidean norm.
    pub gradient_estimate: f64,
    /// Whether both are within the tolerance.
    pub converged: bool,
    /// `estimate`.
    pub method: &'static str,
}

impl EstimateRecord {
    pub(super) fn new(id: Id, found: &super::estimate::Estimate) -> Result<Self, Error> {
        let gradient = found.gradient.to_array();
        let [x, y, z] = gradient;
        for (what, value) in [("the radiosity", found.radiosity), ("the gradient", x), ("the gradient", y), ("the gradient", z)] {
            finite(what, value)?;
        }
        finite("the estimate of the radiosity's error", found.radiosity_estimate)?;
        finite("the estimate of the gradient's error", found.gradient_estimate)?;
        Ok(Self {
            id,
            radiosity: found.radiosity,
            gradient,
            radiosity_estimate: found.radiosity_estimate,
            gradient_estimate: found.gradient_estimate,
            converged: found.converged,
            method: "estimate",
        })
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
