//! Answers with their bounds, and what is asked of them.

use glam::DVec3;

use crate::scalar::vec3::Vec3;

/// Radiosity and its gradient with proven absolute error bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answer {
    /// Radiosity `B(x)`, in the unit of the emission.
    pub radiosity: f64,
    /// Gradient of `B` with respect to `x` at fixed normal, in that unit over the unit of length.
    pub gradient: DVec3,
    /// Proven bound on the error of `radiosity`.
    pub radiosity_error: f64,
    /// Proven bound on the Euclidean norm of the error of `gradient`.
    pub gradient_error: f64,
    /// What answered.
    pub method: Method,
}

impl Answer {
    pub(crate) const ZERO: Self =
        Self { radiosity: 0.0, gradient: DVec3::ZERO, radiosity_error: 0.0, gradient_error: 0.0, method: Method::Zero };

    /// Whether both bounds are within `tolerance`, relative.
    #[must_use]
    pub fn meets(&self, tolerance: f64) -> bool {
        let size = Vec3::from(self.gradient).length();
        self.radiosity_error <= tolerance * self.radiosity.abs() && self.gradient_error <= tolerance * size
    }
}

/// Radiosity with a proven absolute error bound.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Value {
    /// Radiosity `B(x)`, in the unit of the emission.
    pub radiosity: f64,
    /// Proven bound on the error of `radiosity`.
    pub radiosity_error: f64,
    /// What answered.
    pub method: Method,
}

impl Value {
    pub(crate) const ZERO: Self = Self { radiosity: 0.0, radiosity_error: 0.0, method: Method::Zero };
}

/// How large the error of a value may be: `relative` times the value, or `absolute`, whichever is larger.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Relative, in [0, 1].
    pub relative: f64,
    /// In the unit of the emission.
    pub absolute: f64,
}

/// What gave an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Method {
    /// Nothing to compute: the receiver is behind the emitter or in its plane, the emitter is below the horizon, or occluders
    /// hide all of it. Exactly 0.
    Zero,
    /// The receiver is on the surface of an emitter whose vertices are not exactly in one plane: the bound encloses what it would
    /// get in front and behind. That of the gradient is infinite where just in front the gradient has no bound: next to an edge,
    /// and over an emission that is not constant.
    OnSurface,
    /// A Gauss rule on the part of the emitter above the horizon, with an a-priori bound: far away, and wherever it is cheap.
    Quadrature,
    /// The closed form in double precision with a running error bound.
    ClosedForm,
    /// The same in double-double.
    DoubleDouble,
    /// The same with as many bits as it takes, rounded to doubles.
    #[cfg(feature = "arbitrary-precision")]
    ArbitraryPrecision,
}

impl Method {
    /// Name in files: `zero`, `on-surface`, `quadrature`, `closed-form`, `double-double`, `arbitrary-precision`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Zero => "zero",
            Self::OnSurface => "on-surface",
            Self::Quadrature => "quadrature",
            Self::ClosedForm => "closed-form",
            Self::DoubleDouble => "double-double",
            #[cfg(feature = "arbitrary-precision")]
            Self::ArbitraryPrecision => "arbitrary-precision",
        }
    }
}
