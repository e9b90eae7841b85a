//! The pieces an integral is cut into: triangles of the emitter's plane and edges of their boundary, with the rules that serve
//! them.

use crate::cubature::gauss_kronrod;
use crate::cubature::triangle_rule::{DEGREE_8, DEGREE_14, DEGREE_17, TriangleRule};
use crate::region::plane::{Edge, Triangle, Vertex};

/// Rounding error of one evaluation relative to the magnitude of the integrand, with that of the rounded geometry.
pub(crate) const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// A value and the three components of its gradient, as one integrand.
pub(crate) type Four = [f64; 4];

/// A triangle or an edge.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Piece {
    Triangle(Triangle),
    Edge(Edge),
}

/// Rules of different degree on one piece.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Sums {
    /// The integral by the rule of highest degree.
    pub(crate) integral: Four,
    /// Estimated error of it, by the rules of lower degree: of the value, of the gradient.
    pub(crate) discrepancy: [f64; 2],
    /// Integral of the magnitude, likewise.
    pub(crate) magnitude: [f64; 2],
    /// Whether the rules do not converge with their degree: a jump or a kink, or detail too fine for this piece.
    pub(crate) is_rough: bool,
}

#[inline]
fn add(sum: &mut Four, weight: f64, f: Four) {
    for i in 0..4 {
        sum[i] += weight * f[i];
    }
}

/// Magnitude of the value and of the gradient.
pub(crate) fn lengths(f: Four) -> [f64; 2] {
    [f[0].abs(), (f[1] * f[1] + f[2] * f[2] + f[3] * f[3]).sqrt()]
}

fn apart(a: &Four, b: &Four) -> [f64; 2] {
    lengths([0, 1, 2, 3].map(|i| a[i] - b[i]))
}

impl Sums {
    #[inline]
    fn add(&mut self, weight: f64, f: Four) {
        add(&mut self.integral, weight, f);
        self.magnitude[0] += weight * f[0].abs();
        self.magnitude[1] += weight * (f[1].abs() + f[2].abs() + f[3].abs());
    }

    /// Takes the larger of two differences for the error where the last is not far below the one before, rounding aside.
    fn distrust(&mut self, last: [f64; 2], before: [f64; 2]) {
        for i in 0..2 {
            if last[i] > (SMOOTH * before[i]).max(ROUNDING * self.magnitude[i]) {
                self.is_rough = true;
                self.discrepancy[i] = CAUTION * last[i].max(before[i]);
            }
        }
    }
}

/// Which rules: the pair of higher degree reaches a tight tolerance with fewer points; all three tell whether a function is
/// smooth on a piece.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Degrees {
    Loose,
    Tight,
    Wary,
}

impl Degrees {
    /// The rules for triangles: that of highest degree, the next one, and one more.
    fn rules(self) -> (&'static TriangleRule, &'static TriangleRule, Option<&'static TriangleRule>) {
        match self {
            Self::Loose => (&DEGREE_14, &DEGREE_8, None),
            Self::Tight => (&DEGREE_17, &DEGREE_14, None),
            Self::Wary => (&DEGREE_17, &DEGREE_14, Some(&DEGREE_8)),
        }
    }
}

/// Factor from the difference of degrees 14 and 17 to the estimated error of the latter: on a needle, where the two resolve
/// almost the same detail, the plain difference was measured to be as small as 0.93 of the error.
const CAUTION: f64 = 4.0;

/// How far the difference falls from degrees 8 and 14 to degrees 14 and 17 where a function is smooth: like `R^-6`, Bernstein's
/// ellipse of parameter R being free of singularities, and pieces are cut until R is about 2.4 for the kernel.
const SMOOTH: f64 = 1.0 / 256.0;

impl Piece {
    /// Evaluations that [`Self::sums`] takes.
    pub(crate) fn cost(&self, degrees: Degrees) -> usize {
        match self {
            Self::Triangle(_) => {
                let (high, middle, low) = degrees.rules();
                high.points.len() + middle.points.len() + low.map_or(0, |rule| rule.points.len())
            }
            Self::Edge(_) => gauss_kronrod::POINTS,
        }
    }

    #[inline]
    pub(crate) fn sums(&self, degrees: Degrees, integrand: &impl Fn(&Self, &Vertex) -> Four) -> Sums {
        let mut sums = Sums::default();
        match self {
            Self::Triangle(triangle) => {
                let (high, middle, low) = degrees.rules();
                for (l, weight) in &high.points {
                    sums.add(triangle.area * weight, integrand(self, &triangle.point(*l)));
                }
                let by = |rule: &TriangleRule| {
                    let mut sum = [0.0; 4];
                    for (l, weight) in &rule.points {
                        add(&mut sum, triangle.area * weight, integrand(self, &triangle.point(*l)));
                    }
                    sum
                };
                let middle = by(middle);
                let last = apart(&sums.integral, &middle);
                sums.discrepancy = match degrees {
                    Degrees::Loose => last,
                    Degrees::Tight | Degrees::Wary => last.map(|difference| CAUTION * difference),
                };
                if let Some(low) = low {
                    sums.distrust(last, apart(&middle, &by(low)));
                }
            }
            Self::Edge(edge) => {
                let mut difference = [0.0; 4];
                for [t, kronrod, gauss] in gauss_kronrod::points() {
                    let f = integrand(self, &edge.point(t));
                    sums.add(kronrod, f);
                    add(&mut difference, kronrod - gauss, f);
                }
                sums.discrepancy = lengths(difference);
            }
        }
        sums
    }

    pub(crate) fn halves(&self) -> [Self; 2] {
        match self {
            Self::Triangle(triangle) => triangle.halves().map(Self::Triangle),
            Self::Edge(edge) => edge.halves().map(Self::Edge),
        }
    }

    pub(crate) fn squared_diameter(&self) -> f64 {
        match self {
            Self::Triangle(triangle) => triangle.squared_diameter(),
            Self::Edge(edge) => edge.squared_length(),
        }
    }

    pub(crate) fn squared_distance_to_foot(&self) -> f64 {
        match self {
            Self::Triangle(triangle) => triangle.squared_distance_to_foot(),
            Self::Edge(edge) => edge.squared_distance_to_foot(),
        }
    }
}
