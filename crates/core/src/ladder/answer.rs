//! Answers with their bounds, and the tolerances they are asked to.

use glam::DVec3;
use radgrad_numbers::vec3::Vec3;

/// Radiosity and its gradient with proven absolute error bounds.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, evaluate};
/// let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
/// let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))?;
/// let answer = evaluate(&Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?, &lamp, &[])?;
/// let exact = 0.138_531_605_994_892_996_78; // atan(1/sqrt 2) / (pi sqrt 2)
/// assert!((answer.radiosity - exact).abs() <= answer.radiosity_error + 1e-17);
/// assert!((answer.gradient.x - answer.gradient.y).abs() <= 2.0 * answer.gradient_error); // by symmetry
/// # Ok::<(), radgrad_core::Error>(())
/// ```
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
    /// The method that answered.
    pub method: Method,
}

impl Answer {
    pub(crate) const ZERO: Self =
        Self { radiosity: 0.0, gradient: DVec3::ZERO, radiosity_error: 0.0, gradient_error: 0.0, method: Method::Zero };

    /// Whether both bounds are within `tolerance`, relative.
    ///
    /// ```
    /// use radgrad_core::{Answer, DVec3, Method};
    /// let (gradient, method) = (DVec3::new(3.0, 0.0, 4.0), Method::ClosedForm);
    /// let answer = Answer { radiosity: 2.0, gradient, radiosity_error: 1e-12, gradient_error: 4e-12, method };
    /// assert!(answer.meets(1e-12)); // 5e-13 of the radiosity, 8e-13 of the gradient's length
    /// assert!(!answer.meets(6e-13));
    /// ```
    #[must_use]
    pub fn meets(&self, tolerance: f64) -> bool {
        let size = Vec3::from(self.gradient).length();
        self.radiosity_error <= tolerance * self.radiosity.abs() && self.gradient_error <= tolerance * size
    }
}

/// Radiosity with a proven absolute error bound.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, Tolerance, evaluate_value};
/// let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
/// let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))?;
/// let tolerance = Tolerance { relative: 1e-10, absolute: 0.0 };
/// let value = evaluate_value(&Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?, &lamp, &[], tolerance)?;
/// assert!((value.radiosity - 0.138_531_605_994_892_996_78).abs() <= value.radiosity_error + 1e-17);
/// # Ok::<(), radgrad_core::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Value {
    /// Radiosity `B(x)`, in the unit of the emission.
    pub radiosity: f64,
    /// Proven bound on the error of `radiosity`.
    pub radiosity_error: f64,
    /// The method that answered.
    pub method: Method,
}

impl Value {
    pub(crate) const ZERO: Self = Self { radiosity: 0.0, radiosity_error: 0.0, method: Method::Zero };
}

/// How large the error of a value may be: `relative` times the value, or `absolute`, whichever is larger.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Error, Polygon, Receiver, Tolerance, evaluate_value};
/// let triangle = Polygon::new(vec![DVec3::Z, DVec3::new(0.0, 1.0, 1.0), DVec3::new(1.0, 0.0, 1.0)])?;
/// let lamp = Emitter::new(triangle, Emission::Constant(1.0))?;
/// let floor = Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?;
/// let either = evaluate_value(&floor, &lamp, &[], Tolerance { relative: 1e-9, absolute: 1e-12 })?;
/// assert!(either.radiosity_error <= f64::max(1e-9 * either.radiosity, 1e-12));
/// let wrong = evaluate_value(&floor, &lamp, &[], Tolerance { relative: 0.0, absolute: -1.0 });
/// assert_eq!(wrong, Err(Error::AbsoluteTolerance { value: -1.0 }));
/// # Ok::<(), radgrad_core::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Relative, in [0, 1].
    pub relative: f64,
    /// The absolute tolerance, in the unit of the emission.
    pub absolute: f64,
}

/// The methods that give answers.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Method, Polygon, Receiver, evaluate};
/// let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
/// let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))?;
/// let answer = |z: f64, normal| evaluate(&Receiver::new(DVec3::Z * z, normal, 1.0)?, &lamp, &[]);
/// assert_eq!(answer(0.0, DVec3::Z)?.method, Method::ClosedForm);
/// assert_eq!(answer(-1000.0, DVec3::Z)?.method, Method::Quadrature);
/// assert_eq!(answer(0.0, DVec3::NEG_Z)?.method, Method::Zero); // it faces away
/// # Ok::<(), radgrad_core::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Method {
    /// Nothing to compute: the receiver is behind the emitter or in its plane, the emitter is below the horizon, or occluders
    /// hide all of it. Exactly 0.
    Zero,
    /// The receiver is on the surface of an emitter whose vertices are not exactly in one plane: the bound encloses its radiosity
    /// in front and behind. That of the gradient is infinite where just in front the gradient has no bound: next to an edge,
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
    ///
    /// ```
    /// # use radgrad_core::Method;
    /// assert_eq!(Method::DoubleDouble.name(), "double-double");
    /// ```
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
