//! Reflectance or emission of a patch: one number, or a function of the position.

use std::fmt;
use std::sync::Arc;

use radgrad_core::DVec3;

use crate::error::Error;

/// A quantity on a patch.
#[derive(Clone)]
pub enum Value {
    /// The same everywhere.
    Constant(f64),
    /// A function of the position, from 0 to a largest value that it is held to.
    Function {
        /// The function.
        function: Arc<dyn Fn(DVec3) -> f64 + Send + Sync>,
        /// Its largest value, or one above it.
        largest: f64,
    },
}

impl fmt::Debug for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Constant(value) => write!(f, "Constant({value})"),
            Self::Function { largest, .. } => write!(f, "Function {{ largest: {largest} }}"),
        }
    }
}

impl From<f64> for Value {
    fn from(value: f64) -> Self {
        Self::Constant(value)
    }
}

impl Value {
    /// A function that is between 0 and `largest`.
    pub fn function(largest: f64, function: impl Fn(DVec3) -> f64 + Send + Sync + 'static) -> Self {
        Self::Function { function: Arc::new(function), largest }
    }

    /// The largest value.
    #[must_use]
    pub const fn largest(&self) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Function { largest, .. } => *largest,
        }
    }

    pub(crate) fn value_at(&self, point: DVec3, patch: usize, quantity: &'static str) -> Result<f64, Error> {
        match self {
            Self::Constant(value) => Ok(*value),
            Self::Function { function, largest } => {
                let value = function(point);
                if (0.0..=*largest).contains(&value) {
                    Ok(value)
                } else {
                    Err(Error::Value { patch, quantity, value, point, largest: *largest })
                }
            }
        }
    }
}
