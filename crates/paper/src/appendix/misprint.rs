//! The errors of appendix A: the paper's own misprints, and errors that a programmer makes. A check of radiosity or its gradient
//! that lets one of them pass is too weak.

use radgrad_core::{DVec3, Emitter, Receiver};

/// One departure from the corrected appendix A.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver};
/// use radgrad_paper::appendix::{self, Misprint};
/// let triangle = Polygon::new(vec![DVec3::Z, DVec3::new(0.5, 0.8, 1.0), DVec3::new(1.0, 0.0, 1.0)])?;
/// let emitter = Emitter::new(triangle, Emission::Constant(1.0))?;
/// let receiver = Receiver::new(DVec3::new(0.5, 0.3, 0.0), DVec3::Z, 1.0)?;
/// let value = |misprint| appendix::radiosity_and_gradient(&receiver, &emitter, misprint).map(|(value, _)| value);
/// let ratio = value(Some(Misprint::ValueDoubled))? / value(None)?;
/// assert!((ratio - 2.0).abs() < 1e-14);
/// # Ok::<(), radgrad_core::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Misprint {
    /// Eq. 9 as printed: the left side without its minus.
    Equation9Sign,
    /// Eqs. 9 and 11 as printed: the second contour integrand is `(n1.r) (r x dy) / r^4` where `(n1.(r x dy)) r / r^4` is right.
    Equation11Integrand,
    /// J1 as printed: `+ (r_i.e_i) I1` where `-` is right.
    J1Sign,
    /// J1 as printed: the logarithm of `|e_{i+1}| / |e_i|` where `|r_{i+1}| / |r_i|` is right.
    J1Logarithm,
    /// K1 as printed: logarithms of `|e|^2` where `|r|^2` is right.
    K1Logarithm,
    /// Line `n1.n2` of the gradient as printed: `I1 r_1 + J1 e_1` in every term where `I1 r_i + J1 e_i` is right.
    FirstEdgeInGradient,
    /// Line `p x n2` of the gradient as printed: `sum I2 e_i` where `sum I1 e_i` is right.
    I2ForI1,
    /// k as printed, for a triangle; wrong for more vertices, where `k = grad B x n2` is right.
    TriangleK,
    /// K1 as printed, without its constant -1. It has no effect: `sum k.e_i = 0`.
    K1Constant,
    /// `pi/rho B` on the left of the value.
    ValueDoubled,
    /// `e_i x n1` in the first sum of the gradient.
    CrossProductReversed,
    /// The second contour sum of the gradient without its factor 2.
    SecondSumNotDoubled,
    /// I2 without its factor 1/2.
    I2NotHalved,
    /// J2 with its end points exchanged.
    J2EndsExchanged,
    /// K2 with `(r_i.e_i) J2` once instead of twice.
    K2NotDoubled,
    /// K1 with `|w_i| gamma_i` once instead of twice.
    K1AngleNotDoubled,
    /// `sin gamma_i` for the angle itself.
    SineForAngle,
    /// `delta B_i = B_i - B_{i+1}`.
    DeltaSign,
    /// `delta B_i = B_i - B_{i-1}`.
    DeltaOfPreviousEdge,
    /// Value and gradient without their X1 terms.
    X1Missing,
    /// The X2 term of the gradient without its factor 2.
    X2NotDoubled,
    /// The sums leave out the edge that closes the polygon.
    LastEdgeMissing,
    /// The sums run over the whole emitter where the horizon cuts it.
    HorizonIgnored,
    /// The sums are taken for a receiver behind the emitter too.
    BackFaceCounted,
}

impl Misprint {
    /// The misprints that change a number, in the order of the paper.
    pub const ERRATA: &[Self] = &[
        Self::Equation9Sign,
        Self::Equation11Integrand,
        Self::TriangleK,
        Self::FirstEdgeInGradient,
        Self::I2ForI1,
        Self::J1Sign,
        Self::J1Logarithm,
        Self::K1Logarithm,
    ];

    /// Every departure that changes a number: the misprints first.
    pub const ALL: &[Self] = &[
        Self::Equation9Sign,
        Self::Equation11Integrand,
        Self::TriangleK,
        Self::FirstEdgeInGradient,
        Self::I2ForI1,
        Self::J1Sign,
        Self::J1Logarithm,
        Self::K1Logarithm,
        Self::ValueDoubled,
        Self::CrossProductReversed,
        Self::SecondSumNotDoubled,
        Self::I2NotHalved,
        Self::J2EndsExchanged,
        Self::K2NotDoubled,
        Self::K1AngleNotDoubled,
        Self::SineForAngle,
        Self::DeltaSign,
        Self::DeltaOfPreviousEdge,
        Self::X1Missing,
        Self::X2NotDoubled,
        Self::LastEdgeMissing,
        Self::HorizonIgnored,
        Self::BackFaceCounted,
    ];

    /// The misprints of appendix A's own sums, the harmless one too.
    pub(super) const APPENDIX: &[Self] = &[
        Self::TriangleK,
        Self::FirstEdgeInGradient,
        Self::I2ForI1,
        Self::J1Sign,
        Self::J1Logarithm,
        Self::K1Logarithm,
        Self::K1Constant,
    ];

    /// Short name for tables: `j1-sign`.
    ///
    /// ```
    /// # use radgrad_paper::appendix::Misprint;
    /// assert_eq!(Misprint::I2NotHalved.name(), "i2-not-halved");
    /// ```
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Equation9Sign => "equation-9-sign",
            Self::Equation11Integrand => "equation-11-integrand",
            Self::J1Sign => "j1-sign",
            Self::J1Logarithm => "j1-logarithm",
            Self::K1Logarithm => "k1-logarithm",
            Self::FirstEdgeInGradient => "first-edge-in-gradient",
            Self::I2ForI1 => "i2-for-i1",
            Self::TriangleK => "triangle-k",
            Self::K1Constant => "k1-constant",
            Self::ValueDoubled => "value-doubled",
            Self::CrossProductReversed => "cross-product-reversed",
            Self::SecondSumNotDoubled => "second-sum-not-doubled",
            Self::I2NotHalved => "i2-not-halved",
            Self::J2EndsExchanged => "j2-ends-exchanged",
            Self::K2NotDoubled => "k2-not-doubled",
            Self::K1AngleNotDoubled => "k1-angle-not-doubled",
            Self::SineForAngle => "sine-for-angle",
            Self::DeltaSign => "delta-sign",
            Self::DeltaOfPreviousEdge => "delta-of-previous-edge",
            Self::X1Missing => "x1-missing",
            Self::X2NotDoubled => "x2-not-doubled",
            Self::LastEdgeMissing => "last-edge-missing",
            Self::HorizonIgnored => "horizon-ignored",
            Self::BackFaceCounted => "back-face-counted",
        }
    }

    /// The error, in one line.
    ///
    /// ```
    /// # use radgrad_paper::appendix::Misprint;
    /// assert_eq!(Misprint::I2NotHalved.description(), "factor 1/2 missing in I2");
    /// ```
    #[must_use]
    pub const fn description(self) -> &'static str {
        match self {
            Self::Equation9Sign => "Eq. 9 as printed: +2pi/rho grad B on the left, the gradient reversed",
            Self::Equation11Integrand => "Eqs. 9 and 11 as printed: (n1.r)(r x dy)/r^4 for (n1.(r x dy)) r/r^4",
            Self::J1Sign => "A.2 as printed: J1 with + (r_i.e_i) I1 for -",
            Self::J1Logarithm => "A.2 as printed: J1 with the logarithm of |e_(i+1)|/|e_i| for |r_(i+1)|/|r_i|",
            Self::K1Logarithm => "A.2 as printed: K1 with logarithms of |e|^2 for |r|^2",
            Self::FirstEdgeInGradient => "A.2 as printed: I1 r_1 + J1 e_1 for I1 r_i + J1 e_i in the n1.n2 line of the gradient",
            Self::I2ForI1 => "A.2 as printed: n2 x sum I2 e_i for n2 x sum I1 e_i",
            Self::TriangleK => "A.2 as printed: k of a triangle, used for a polygon with more vertices",
            Self::K1Constant => "A.2 as printed: K1 without its constant -1 (no effect)",
            Self::ValueDoubled => "pi/rho for 2pi/rho before the value",
            Self::CrossProductReversed => "e_i x n1 for n1 x e_i in the first sum of the gradient",
            Self::SecondSumNotDoubled => "factor 2 missing before the second sum of the gradient",
            Self::I2NotHalved => "factor 1/2 missing in I2",
            Self::J2EndsExchanged => "1/r_(i+1)^2 - 1/r_i^2 for 1/r_i^2 - 1/r_(i+1)^2 in J2",
            Self::K2NotDoubled => "factor 2 missing before (r_i.e_i) J2 in K2",
            Self::K1AngleNotDoubled => "factor 2 missing before |w_i| gamma_i in K1",
            Self::SineForAngle => "sin(gamma_i) for gamma_i in I1",
            Self::DeltaSign => "B_i - B_(i+1) for delta B_i",
            Self::DeltaOfPreviousEdge => "B_i - B_(i-1) for delta B_i",
            Self::X1Missing => "the terms with X1 missing",
            Self::X2NotDoubled => "factor 2 missing before (n2.r_0)^2 X2",
            Self::LastEdgeMissing => "the edge from the last vertex to the first missing from the sums",
            Self::HorizonIgnored => "the emitter not clipped by the receiver's horizon",
            Self::BackFaceCounted => "a receiver behind the emitter not answered by 0",
        }
    }

    /// Whether the term that the misprint is in is there at all: a constant emitter has no J1, parallel planes have no X1.
    #[must_use]
    pub fn shows_in(self, receiver: &Receiver, emitter: &Emitter) -> bool {
        let (n1, polygon) = (receiver.normal(), emitter.polygon());
        let (n2, vertices) = (polygon.normal(), polygon.vertices());
        let from_receiver = || vertices.iter().map(|v| *v - receiver.position());
        let linear = emitter.emission_gradient() != DVec3::ZERO;
        let (height, above) = (-n2.dot(vertices[0] - receiver.position()), from_receiver().any(|r| n1.dot(r) > 0.0));
        let lit = height > 0.0 && above;
        match self {
            Self::K1Constant => false,
            Self::J1Sign | Self::J1Logarithm | Self::K2NotDoubled | Self::DeltaSign | Self::DeltaOfPreviousEdge => lit && linear,
            Self::TriangleK => lit && linear && vertices.len() > 3,
            Self::FirstEdgeInGradient | Self::K1Logarithm | Self::K1AngleNotDoubled => lit && linear && n1.dot(n2) != 0.0,
            Self::I2ForI1 | Self::X1Missing | Self::X2NotDoubled => {
                lit && n2.dot(n1.cross(emitter.emission_gradient().cross(n2))) != 0.0
            }
            Self::HorizonIgnored => lit && from_receiver().any(|r| n1.dot(r) < 0.0),
            Self::BackFaceCounted => height < 0.0 && above,
            _ => lit,
        }
    }
}

/// The misprints planted in one evaluation.
#[derive(Debug, Clone, Copy)]
pub(super) struct Misprints<'a>(pub(super) &'a [Misprint]);

impl Misprints<'_> {
    pub(super) fn planted(self, misprint: Misprint) -> bool {
        self.0.contains(&misprint)
    }

    pub(super) fn choose<T>(self, misprint: Misprint, right: T, wrong: T) -> T {
        if self.planted(misprint) { wrong } else { right }
    }
}
