//! The emission of a case as written: one of five shapes, none by default.

use radgrad_core::{DVec3, Emission, Error, Polynomial};
use serde::{Deserialize, Serialize};

use super::point;
use super::point::Point;

/// `{"constant": b}`, `{"vertices": [b0, b1, ...]}`, `{"value": b0, "gradient": [x, y, z]}` `{"polynomial": {...}}`
/// or `{"expression": "1 + x*exp(-y)"}`.
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
    /// A polynomial of the position.
    Polynomial {
        /// `{"origin": [x, y, z], "terms": [{"coefficient": c, "powers": [i, j, k]}, ...]}`.
        polynomial: PolynomialRecord,
    },
    /// Any function of the position, which has no closed form.
    Expression {
        /// An expression of `x`, `y` and `z`.
        expression: String,
    },
}

/// A sum of `coefficient * dx^i dy^j dz^k`, `(dx, dy, dz)` the position less the origin.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PolynomialRecord {
    /// Where the coordinates start.
    #[serde(deserialize_with = "point::one")]
    pub origin: [f64; 3],
    /// The terms, in any order.
    pub terms: Vec<TermRecord>,
}

/// One term of a polynomial.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TermRecord {
    /// The factor.
    pub coefficient: f64,
    /// Exponents of the three coordinates.
    pub powers: [u8; 3],
}

impl TryFrom<&EmissionRecord> for Emission {
    type Error = Error;

    fn try_from(record: &EmissionRecord) -> Result<Self, Error> {
        Ok(match record {
            EmissionRecord::Constant { constant } => Self::Constant(*constant),
            EmissionRecord::Vertices { vertices } => Self::at_vertices(vertices.clone()),
            EmissionRecord::Gradient { value, gradient } => Self::gradient(*value, DVec3::from_array(*gradient)),
            EmissionRecord::Polynomial { polynomial: PolynomialRecord { origin, terms } } => {
                let terms = terms.iter().map(|term| (term.coefficient, term.powers));
                Self::Polynomial(Polynomial::new(DVec3::from_array(*origin), terms)?)
            }
            EmissionRecord::Expression { .. } => {
                let given = "an expression";
                return Err(Error::EmissionKind { quantity: "the radiosity", needed: "constant, linear or polynomial", given });
            }
        })
    }
}

/// Every field an emission may have; which of them stand together is decided in one place below.
#[derive(Deserialize)]
#[serde(
    deny_unknown_fields,
    expecting = "an emission: {\"constant\": b}, {\"vertices\": [b0, ...]}, {\"value\": b0, \"gradient\": [x, y, z]}, {\"polynomial\": {...}} or {\"expression\": \"...\"}"
)]
struct Fields {
    constant: Option<f64>,
    vertices: Option<Vec<f64>>,
    value: Option<f64>,
    gradient: Option<Point>,
    polynomial: Option<PolynomialRecord>,
    expression: Option<String>,
}

impl TryFrom<Fields> for EmissionRecord {
    type Error = &'static str;

    fn try_from(fields: Fields) -> Result<Self, Self::Error> {
        let Fields { constant, vertices, value, gradient, polynomial, expression } = fields;
        match (constant, vertices, value, gradient, polynomial, expression) {
            (Some(constant), None, None, None, None, None) => Ok(Self::Constant { constant }),
            (None, Some(vertices), None, None, None, None) => Ok(Self::Vertices { vertices }),
            (None, None, Some(value), Some(Point(gradient)), None, None) => Ok(Self::Gradient { value, gradient }),
            (None, None, None, None, Some(polynomial), None) => Ok(Self::Polynomial { polynomial }),
            (None, None, None, None, None, Some(expression)) => Ok(Self::Expression { expression }),
            _ => Err(
                "`emission` must have exactly one of `constant`, `vertices`, `value` with `gradient`, `polynomial`, or `expression`",
            ),
        }
    }
}
