//! The oracle's errors: inputs that it refuses, and integrals that it cannot enclose.

use std::fmt;

use glam::DVec3;

/// Every way in which an oracle refuses a question; one that the cubature cannot answer well enough gets a status instead.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The number of digits is outside the range of an arithmetic.
    #[error("{digits} digits asked of {arithmetic} arithmetic, which offers {least} to {most}")]
    Digits {
        /// The requested digits.
        digits: u32,
        /// The requested arithmetic.
        arithmetic: &'static str,
        /// Fewest digits it offers.
        least: u32,
        /// Most digits it offers.
        most: u32,
    },
    /// The evaluations allowed do not suffice.
    #[error("at least {needed} evaluations of the integrand needed for {digits} digits, {allowed} allowed; {reached}")]
    Budget {
        /// Evaluations of the next pass, at least.
        needed: u64,
        /// Evaluations allowed.
        allowed: u64,
        /// The requested digits.
        digits: u32,
        /// The enclosure by the passes so far.
        reached: Reached,
    },
    /// The rounding error is above the tolerance in the requested arithmetic.
    #[error("rounding in {bits} bits leaves too wide a radius for {digits} digits; {reached}")]
    Rounding {
        /// Bits of the arithmetic.
        bits: usize,
        /// The requested digits.
        digits: u32,
        /// The enclosure reached.
        reached: Reached,
    },
    /// A cell cannot be bounded: the receiver is on the boundary of the emitter within rounding, or the numbers leave the range
    /// of a double.
    #[error(
        "no bound for the integrand on a cell of width {width:e} (relative to its triangle) at distance {distance:e} from the receiver"
    )]
    Cell {
        /// Width of the cell relative to its triangle.
        width: f64,
        /// Distance of its nearest point from the receiver, the farthest vertex being at 1 to 2.
        distance: f64,
    },
    /// A term of a polynomial emission is not usable.
    #[error("coefficient of term {index} of the emission is {value}, which is not finite")]
    Coefficient {
        /// Place of the term.
        index: usize,
        /// Its coefficient.
        value: f64,
    },
    /// The polynomial's degree is too high.
    #[error("the emission has degree {degree}, at most {most} is allowed")]
    Degree {
        /// Its degree.
        degree: u32,
        /// Largest degree allowed.
        most: u32,
    },
    /// The result is outside the range of a double.
    #[error("{quantity} is outside the range of a double")]
    Range {
        /// The quantity that overflows.
        quantity: &'static str,
    },
    /// A decimal number cannot be read.
    #[error("{text:?} is not a decimal number")]
    Decimal {
        /// The text.
        text: String,
    },
    /// A relative tolerance must be positive.
    #[error("tolerance is {value}: a relative tolerance must be positive and finite")]
    Tolerance {
        /// As given.
        value: f64,
    },
    /// The width of the smallest feature of an emission must be positive.
    #[error("the detail of the emission is {value}: it must be a positive length, or infinite")]
    Detail {
        /// As given.
        value: f64,
    },
    /// An emission function lacks a part that the method needs.
    #[error("the emission function has no {missing}, which {asker} needs")]
    EmissionPart {
        /// `gradient` or `bounds`.
        missing: &'static str,
        /// Who asks for it.
        asker: &'static str,
    },
    /// The budget does not allow the first pass.
    #[error("the budget is {budget} evaluations: the first pass alone needs {needed}")]
    Evaluations {
        /// Evaluations allowed.
        budget: usize,
        /// Evaluations of the first pass.
        needed: usize,
    },
    /// The error asked of form factors is not one that rays can have.
    #[error("the error of form factors is {value}: it must be above 0 and below 1, and take no more rays than 2^32")]
    FactorError {
        /// The error.
        value: f64,
    },
    /// A confidence level must be between 0 and 1.
    #[error("confidence is {value}: it must be above 0 and below 1")]
    Confidence {
        /// As given.
        value: f64,
    },
    /// Too few samples for a standard error.
    #[error("{what} is {value}: at least {least} are needed for an interval")]
    TooFewSamples {
        /// Which number.
        what: &'static str,
        /// As given.
        value: usize,
        /// The least allowed.
        least: usize,
    },
    /// The receiver touches the emitter or an edge: a sample's contribution has no finite variance there.
    #[error("the receiver at {position} touches {what}: no mean of samples has a finite variance")]
    Touching {
        /// Position of the receiver.
        position: DVec3,
        /// The line or point that it touches.
        what: &'static str,
    },
    /// The receiver is in front of the emitter's plane, by less than doubled precision resolves.
    #[error(
        "the receiver at {position} is on the lit side of the emitter's plane, but by less than 2^-100 of the distance of the farthest vertex: no height to integrate with"
    )]
    Height {
        /// Position of the receiver.
        position: DVec3,
    },
    /// The polygon could not be triangulated.
    #[error("no ear found among the last {remaining} vertices of the polygon: it is not simple as seen in its plane")]
    Triangulation {
        /// Vertices not yet cut off.
        remaining: usize,
    },
    /// Reflectance or emission of a face of a scene is out of range.
    #[error(
        "face {index} reflects {reflectance} and emits {emitted}: a reflectance is in [0, 1], an emission finite and not negative"
    )]
    Face {
        /// Index of the face, from 0.
        index: usize,
        /// Its reflectance.
        reflectance: f64,
        /// Its emitted radiosity.
        emitted: f64,
    },
    /// Two faces reflect everything, so that walks need not end.
    #[error("the two largest reflectances are {reflectance} and as much: their product must be below 1")]
    Lossless {
        /// The largest reflectance.
        reflectance: f64,
    },
    /// A point is of a face that does not exist.
    #[error("there is no face {face}: they are numbered from 0, and there are {count}")]
    NoFace {
        /// The index given.
        face: usize,
        /// How many there are.
        count: usize,
    },
    /// The light of a lamp with a pattern is not enclosed.
    #[error("face {face} emits by a pattern: only constant emission is enclosed")]
    Patterned {
        /// Index of the face, from 0.
        face: usize,
    },
    /// A receiver or an emitter that does not exist.
    #[error("no such problem: {0}")]
    Problem(radgrad_core::Error),
    /// A result or an integrand is not a finite number.
    #[error("{quantity} is {value}: not representable, or the source function gave it")]
    NotFinite {
        /// Which one.
        quantity: &'static str,
        /// Its value.
        value: f64,
    },
}

/// The midpoints and radii a computation ended with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reached {
    /// Midpoint of the radiosity.
    pub radiosity: f64,
    /// Its radius.
    pub radiosity_radius: f64,
    /// Norm of the gradient's midpoint.
    pub gradient: f64,
    /// Largest radius of a component.
    pub gradient_radius: f64,
}

impl fmt::Display for Reached {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "reached radiosity {:e} +- {:e}, gradient norm {:e} +- {:e}",
            self.radiosity, self.radiosity_radius, self.gradient, self.gradient_radius
        )
    }
}
