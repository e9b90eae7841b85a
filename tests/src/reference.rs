//! Reference numbers under `data/reference/`: decimal strings of 30 digits from integrations in high precision.
//!
//! Read as [`Decimal`]s, so that the errors seen are those of the doubles compared with them and not of the reading.

use std::collections::HashMap;

use glam::DVec3;
use radgrad_core::{Emission, Emitter, Polygon, Receiver};
use serde::Deserialize;
use serde::de::DeserializeOwned;

use crate::RelativeError;
use crate::decimal::Decimal;

/// A problem with its answer.
#[derive(Debug, Clone)]
pub struct Case {
    /// Name in the file.
    pub id: String,
    /// The receiver.
    pub receiver: Receiver,
    /// The emitter.
    pub emitter: Emitter,
    /// Radiosity.
    pub radiosity: Decimal,
    /// Gradient.
    pub gradient: [Decimal; 3],
}

impl Case {
    /// Relative errors of radiosity and gradient.
    #[must_use]
    pub fn error_of(&self, (radiosity, gradient): (f64, DVec3)) -> RelativeError {
        let components = [0, 1, 2].map(|axis| self.gradient[axis].error_of(gradient[axis]));
        let (_, norm) = self.nearest();
        RelativeError {
            radiosity: self.radiosity.error_of(radiosity) / self.radiosity.high.abs(),
            gradient: DVec3::from(components).length() / norm.length(),
        }
    }

    /// The nearest doubles.
    #[must_use]
    pub fn nearest(&self) -> (f64, DVec3) {
        (self.radiosity.high, DVec3::from(self.gradient.map(|component| component.high)))
    }
}

#[derive(Deserialize)]
struct SceneCase {
    id: String,
    emitter: Vec<[String; 3]>,
    #[serde(rename = "B_vertices")]
    emission: Vec<String>,
    receiver_normal: [f64; 3],
    x: [String; 3],
    #[serde(rename = "irradiance_over_Bunit")]
    radiosity: String,
    grad: [String; 3],
}

/// A point form factor: radiosity at reflectance 1 of an emitter of radiosity 1.
#[derive(Debug, Clone)]
pub struct PointFactor {
    /// Name in the file.
    pub id: String,
    /// An element at the origin, facing along z.
    pub receiver: Receiver,
    /// A rectangle of radiosity 1.
    pub emitter: Emitter,
    /// The factor.
    pub factor: Decimal,
}

#[derive(Deserialize)]
struct Factor {
    id: String,
    params: HashMap<String, String>,
    value: String,
}

/// The triangle of the paper's figures A to D at four points, of constant and of linear emission.
///
/// # Panics
/// If the file is missing or has another shape, as all here.
#[must_use]
pub fn paper_scene() -> Vec<Case> {
    let cases: Vec<SceneCase> = read("paper_scene.json");
    cases
        .into_iter()
        .map(|case| {
            let polygon = Polygon::new(case.emitter.iter().map(vector).collect()).unwrap();
            let emission = Emission::at_vertices(case.emission.iter().map(|b| number(b)).collect());
            Case {
                id: case.id,
                receiver: Receiver::new(vector(&case.x), DVec3::from(case.receiver_normal), 1.0).unwrap(),
                emitter: Emitter::new(polygon, emission).unwrap(),
                radiosity: decimal(&case.radiosity),
                gradient: case.grad.each_ref().map(|component| decimal(component)),
            }
        })
        .collect()
}

/// The factors from an element to a rectangle: parallel (`pt_par`) or perpendicular (`pt_perp`), a corner over the element or
/// beside it, and one on the axis of a square.
///
/// # Panics
/// If the file is missing or has another shape.
#[must_use]
pub fn point_factors() -> Vec<PointFactor> {
    let factors: Vec<Factor> = read("form_factors.json");
    factors.into_iter().filter(|f| f.id.starts_with("pt_par") || f.id.starts_with("pt_perp")).map(point_factor).collect()
}

fn point_factor(factor: Factor) -> PointFactor {
    let parameter = |name: &str| number(&factor.params[name]);
    let rectangle = if factor.id == "pt_par_centre_square" {
        let (half, h) = (0.5 * parameter("side"), parameter("h"));
        [(-half, -half), (-half, half), (half, half), (half, -half)].map(|(x, y)| DVec3::new(x, y, h))
    } else {
        let [a, b, c] = ["a", "b", "c"].map(parameter);
        if factor.id.starts_with("pt_par") {
            [(0.0, 0.0), (0.0, b), (a, b), (a, 0.0)].map(|(x, y)| DVec3::new(x, y, c))
        } else {
            [(0.0, 0.0), (0.0, a), (b, a), (b, 0.0)].map(|(y, z)| DVec3::new(c, y, z))
        }
    };
    let polygon = Polygon::new(rectangle.to_vec()).unwrap();
    PointFactor {
        receiver: Receiver::new(DVec3::ZERO, DVec3::Z, 1.0).unwrap(),
        emitter: Emitter::new(polygon, Emission::Constant(1.0)).unwrap(),
        factor: decimal(&factor.value),
        id: factor.id,
    }
}

fn read<T: DeserializeOwned>(file: &str) -> T {
    let path = format!("{}/../data/reference/{file}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{path}: {error}"))
}

fn decimal(text: &str) -> Decimal {
    text.parse().unwrap_or_else(|error| panic!("{error}"))
}

fn number(text: &str) -> f64 {
    decimal(text).high
}

fn vector(components: &[String; 3]) -> DVec3 {
    DVec3::from(components.each_ref().map(|c| number(c)))
}

/// The truth of a case of `data/reference/public.jsonl`, to 30 digits.
#[derive(Debug, Clone, Deserialize)]
pub struct PublicTruth {
    /// Radiosity.
    pub radiosity: String,
    /// Gradient.
    pub gradient: [String; 3],
}

/// The lines of `data/reference/public.jsonl`, each with the truth it states.
///
/// # Panics
/// If the file cannot be read.
#[must_use]
pub fn public_cases() -> Vec<(String, PublicTruth)> {
    #[derive(Deserialize)]
    struct Line {
        truth: PublicTruth,
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../data/reference/public.jsonl");
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{path}: {error}"));
    let read = |line: &str| {
        let Line { truth } = serde_json::from_str(line).unwrap_or_else(|error| panic!("{path}: {error}"));
        (line.to_owned(), truth)
    };
    text.lines().map(read).collect()
}
