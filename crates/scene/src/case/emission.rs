//! The emission of a case as written: one of three shapes, none by default.

use radgrad_core::{DVec3, Emission};
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};

use super::point::Point;

/// `{"constant": b}`, `{"vertices": [b0, b1, ...]}` or `{"value": b0, "gradient": [x, y, z]}`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged, try_from = "Fields")]
pub enum EmissionRecord {
    /// The same value everywhere.
    Constant {
        /// The value.
        constant: f64,
    },
    /// One value per vertex; for more than three they must lie on one affine function.
    Vertices {
        /// The values, in the order of the vertices.
        vertices: Vec<f64>,
    },
    /// An affine function.
    Gradient {
        /// Value at vertex 0.
        value: f64,
        /// Gradient over the emitter's plane.
        gradient: [f64; 3],
    },
}

impl From<&EmissionRecord> for Emission {
    fn from(record: &EmissionRecord) -> Self {
        match record {
            EmissionRecord::Constant { constant } => Self::Constant(*constant),
            EmissionRecord::Vertices { vertices } => Self::at_vertices(vertices.clone()),
            EmissionRecord::Gradient { value, gradient } => Self::gradient(*value, DVec3::from_array(*gradient)),
        }
    }
}

/// Every field an emission may have; which of them stand together is decided in one place below.
#[derive(Deserialize)]
#[serde(expecting = "an emission: {\"constant\": b}, {\"vertices\": [b0, ...]} or {\"value\": b0, \"gradient\": [x, y, z]}")]
struct Fields {
    constant: Option<f64>,
    vertices: Option<Vec<f64>>,
    value: Option<f64>,
    gradient: Option<Point>,
    polynomial: Option<IgnoredAny>,
}

impl TryFrom<Fields> for EmissionRecord {
    type Error = &'static str;

    fn try_from(fields: Fields) -> Result<Self, Self::Error> {
        match fields {
            Fields { polynomial: Some(_), .. } => Err("`polynomial` emission is not supported: give constant or linear emission"),
            Fields { constant: Some(constant), vertices: None, value: None, gradient: None, .. } => {
                Ok(Self::Constant { constant })
            }
            Fields { constant: None, vertices: Some(vertices), value: None, gradient: None, .. } => {
                Ok(Self::Vertices { vertices })
            }
            Fields { constant: None, vertices: None, value: Some(value), gradient: Some(Point(gradient)), .. } => {
                Ok(Self::Gradient { value, gradient })
            }
            _ => Err("`emission` must have exactly one of `constant`, `vertices`, or `value` with `gradient`"),
        }
    }
}
