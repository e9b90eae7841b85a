//! The errors: inputs that are refused, and results that a double cannot hold.

use std::fmt;

use glam::DVec3;

/// Every way in which this crate refuses an input. Messages give the value, its place and the rule it breaks.
///
/// ```
/// use radgrad_core::{DVec3, Error, Polygon};
/// let error = Polygon::new(vec![DVec3::ZERO, DVec3::X, DVec3::NAN]).unwrap_err();
/// assert!(matches!(error, Error::VertexNotFinite { index: 2, .. }));
/// assert_eq!(error.to_string(), "vertex 2 is [NaN, NaN, NaN]: coordinates must be finite");
/// ```
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// A polygon needs three vertices.
    TooFewVertices {
        /// Vertices given.
        count: usize,
    },
    /// A vertex has a coordinate that is NaN or infinite.
    VertexNotFinite {
        /// Index of the vertex.
        index: usize,
        /// The vertex as given.
        value: DVec3,
    },
    /// Two consecutive vertices are the same point.
    RepeatedVertex {
        /// Index of the first of the two.
        first: usize,
        /// Index of the second of the two.
        second: usize,
        /// The point.
        value: DVec3,
    },
    /// All vertices are on one line.
    ZeroArea {
        /// Vertices given.
        count: usize,
    },
    /// A vertex is off the plane of the polygon.
    NotPlanar {
        /// Index of the vertex farthest off the plane.
        index: usize,
        /// Its distance from the plane, in the unit of the vertices.
        distance: f64,
        /// The distance allowed.
        allowed: f64,
        /// The polygon's largest extent along a coordinate axis.
        size: f64,
    },
    /// Two edges that are not neighbours meet, or two neighbours overlap.
    NotSimple {
        /// Index of the first edge (edge `i` starts at vertex `i`).
        first: usize,
        /// Index of the second edge.
        second: usize,
        /// The distance by which each coordinate may be off.
        precision: f64,
    },
    /// A precision is negative, or not finite.
    Precision {
        /// The precision as given.
        value: f64,
    },
    /// The receiver's position has a coordinate that is NaN or infinite.
    PositionNotFinite {
        /// The position as given.
        value: DVec3,
    },
    /// The receiver's normal is zero, NaN or infinite.
    Normal {
        /// The normal as given.
        value: DVec3,
    },
    /// The reflectance is outside [0, 1].
    Reflectance {
        /// The reflectance as given.
        value: f64,
    },
    /// An emission value is NaN or infinite.
    EmissionNotFinite {
        /// Which value, for people: `value`, `at vertex 2`, `gradient component 0`.
        place: String,
        /// The value as given.
        value: f64,
    },
    /// The number of emission values differs from the number of vertices.
    EmissionCount {
        /// Values given.
        values: usize,
        /// Vertices of the polygon.
        vertices: usize,
    },
    /// Emission values at more than three vertices are not one affine function.
    EmissionNotAffine {
        /// Vertex with the largest difference.
        index: usize,
        /// Value given there.
        value: f64,
        /// Value of the affine function there.
        expected: f64,
        /// Difference allowed.
        allowed: f64,
    },
    /// A term of a polynomial emission has too high a degree.
    EmissionDegree {
        /// Index of the term.
        index: usize,
        /// Its degree, the sum of the exponents.
        degree: u32,
        /// Highest degree allowed.
        allowed: u32,
    },
    /// The closed form of a quantity does not serve this kind of emission.
    EmissionKind {
        /// The requested quantity.
        quantity: &'static str,
        /// The emission that it needs: `constant`, `constant or linear`.
        needed: &'static str,
        /// The emission given: `linear`, `polynomial`.
        given: &'static str,
    },
    /// A tolerance is not a number in [0, 1].
    Tolerance {
        /// The tolerance as given.
        value: f64,
    },
    /// An absolute tolerance is no finite number of at least 0.
    AbsoluteTolerance {
        /// The tolerance as given.
        value: f64,
    },
    /// The receiver is on the line through an edge, where a formula divides by its distance from it.
    OnEdgeLine {
        /// Index of the edge, of the part of the polygon that is above the receiver's horizon.
        edge: usize,
    },
    /// The receiver is on the surface of an emitter whose vertices are not exactly in one plane, where it may be in front or
    /// behind.
    OnSurface {
        /// Height of the receiver over the emitter's plane, rounded.
        height: f64,
        /// The emitter's planarity defect.
        defect: f64,
    },
    /// The requested number of digits is not served.
    Digits {
        /// Requested digits.
        value: u32,
        /// The most that are served.
        most: u32,
    },
    /// The error bound stays above the tolerance.
    Undecided {
        /// Requested digits.
        digits: u32,
        /// Bits of the last attempt.
        bits: usize,
    },
    /// The arrays of a batch differ in length.
    Lengths {
        /// Entries that are needed.
        expected: usize,
        /// Entries given.
        given: usize,
    },
    /// One entry of a batch is wrong.
    InBatch {
        /// Index of the entry.
        index: usize,
        /// The error of that entry.
        error: Box<Self>,
    },
    /// Lengths are so far apart that nothing is known of the result.
    Scales {
        /// The quantity that was computed, such as `radiosity` or `gradient`.
        quantity: &'static str,
    },
    /// The result is too large for a double.
    Overflow {
        /// The quantity that was computed, such as `radiosity` or `gradient`.
        quantity: &'static str,
    },
    /// The result is not 0 but too small for a double of full precision.
    Underflow {
        /// The quantity that was computed, such as `radiosity` or `gradient`.
        quantity: &'static str,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFewVertices { count } => write!(f, "a polygon needs at least 3 vertices, this one has {count}"),
            Self::VertexNotFinite { index, value } => write!(f, "vertex {index} is {value}: coordinates must be finite"),
            Self::RepeatedVertex { first, second, value } => {
                write!(f, "vertices {first} and {second} are the same point {value}: leave one out")
            }
            Self::ZeroArea { count } => write!(f, "the polygon has no area: all {count} vertices are on one line"),
            Self::NotPlanar { index, distance, allowed, size } => {
                write!(f, "vertex {index} is {distance:e} off the plane of the polygon (allowed {allowed:e} at size {size:e})")
            }
            Self::NotSimple { first, second, precision } => {
                write!(f, "edges {first} and {second} meet{}", rule_for_meeting(precision))
            }
            Self::Precision { value } => {
                write!(f, "precision is {value}: it is a length by which coordinates may be off, finite and not negative")
            }
            Self::PositionNotFinite { value } => write!(f, "receiver position is {value}: coordinates must be finite"),
            Self::Normal { value } => write!(f, "receiver normal is {value}: it must be finite and not zero"),
            Self::Reflectance { value } => write!(f, "reflectance is {value}: it must be between 0 and 1"),
            Self::EmissionNotFinite { place, value } => write!(f, "emission {place} is {value}: it must be finite"),
            Self::EmissionCount { values, vertices } => {
                write!(f, "emission has {values} values for {vertices} vertices: give one per vertex")
            }
            Self::EmissionNotAffine { index, value, expected, allowed } => write!(
                f,
                "emission at vertex {index} is {value}, but the affine function through the vertices gives {expected} there (allowed difference {allowed:e})"
            ),
            Self::EmissionDegree { index, degree, allowed } => {
                write!(f, "emission term {index} has degree {degree}: at most {allowed} is allowed")
            }
            Self::EmissionKind { quantity, needed, given } => {
                write!(f, "{quantity} has a closed form for {needed} emission only, this one is {given}")
            }
            Self::Tolerance { value } => write!(f, "tolerance is {value}: it must be a relative error between 0 and 1"),
            Self::AbsoluteTolerance { value } => {
                write!(f, "absolute tolerance is {value}: it must be finite and not negative, and above 0 for a tree of emitters")
            }
            Self::OnEdgeLine { edge } => write!(f, "the receiver is on the line of edge {edge}, where this form divides by zero"),
            Self::OnSurface { height, defect } => write!(
                f,
                "the receiver is {height:e} over the emitter's plane, and vertices are up to {defect:e} off it: it may be in front or behind"
            ),
            Self::Digits { value, most } => write!(f, "{value} digits were asked for: it must be between 1 and {most}"),
            Self::Undecided { digits, bits } => write!(
                f,
                "{digits} digits are out of reach with {bits} bits: the exact value may be zero, undefined because vertices are off one plane, or take too long"
            ),
            Self::Lengths { expected, given } => write!(f, "an array of {given} entries was given where {expected} are needed"),
            Self::InBatch { index, error } => write!(f, "entry {index}: {error}"),
            Self::Scales { quantity } => write!(
                f,
                "the {quantity} is lost: lengths of the scene are too far apart for its formula; leave out occluders that are far smaller or larger than the emitter's distance"
            ),
            Self::Overflow { quantity } => write!(f, "the {quantity} overflows: its magnitude is above {:e}", f64::MAX),
            Self::Underflow { quantity } => {
                write!(f, "the {quantity} underflows: its magnitude is not 0 but below {:e}", f64::MIN_POSITIVE)
            }
        }
    }
}

impl std::error::Error for Error {}

fn rule_for_meeting(precision: &f64) -> String {
    if *precision == 0.0 {
        return ": the polygon must be simple".into();
    }
    format!(", also where neighbours are moved by the precision {precision:e}: the polygon must be simple")
}
