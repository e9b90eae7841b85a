//! The pieces an integral is cut into: triangles of the emitter's plane and edges of their boundary, with the rules that serve
//! them.

use crate::cubature::gauss_kronrod;
use crate::cubature::triangle_rule::{DEGREE_8, DEGREE_14, DEGREE_17, TriangleRule};
use crate::region::plane::{Edge, Triangle, Vertex};

/// A value and the three components of its gradient, as one integrand.
pub(crate) type Four = [f64; 4];

/// A triangle or an edge.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Piece {
    Triangle(Triangle),
    Edge(Edge),
}

/// Two rules of different degree on one piece.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Sums {
    /// By the rule of higher degree.
    pub(crate) integral: Four,
    /// Estimated error of it, by the rule of lower degree.
    pub(crate) difference: Four,
    /// Integral of the magnitude: of the value, of the gradient.
    pub(crate) magnitude: [f64; 2],
}

#[inline]
fn add(sum: &mut Four, weight: f64, f: Four) {
    for i in 0..4 {
        sum[i] += weight * f[i];
    }
}

impl Sums {
    #[inline]
    fn add(&mut self, weight: f64, f: Four) {
        add(&mut self.integral, weight, f);
        self.magnitude[0] += weight * f[0].abs();
        self.magnitude[1] += weight * (f[1].abs() + f[2].abs() + f[3].abs());
    }
}

/// Which rules: the pair of higher degree reaches a tight tolerance with fewer points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Degrees {
    Loose,
    Tight,
}

impl Degrees {
    /// Lower and higher rule for triangles.
    fn pair(self) -> [&'static TriangleRule; 2] {
        match self {
            Self::Loose => [&DEGREE_8, &DEGREE_14],
            Self::Tight => [&DEGREE_14, &DEGREE_17],
        }
    }
}

/// What the difference of degrees 14 and 17 is multiplied by to estimate the error of the latter: on a needle, where the two
/// differ little in what they resolve, the plain difference was measured to be as small as 0.93 of the error.
const CAUTION: f64 = 4.0;

impl Piece {
    /// Evaluations that [`Self::sums`] takes.
    pub(crate) fn cost(&self, degrees: Degrees) -> usize {
        match self {
            Self::Triangle(_) => degrees.pair().iter().map(|rule| rule.points.len()).sum(),
            Self::Edge(_) => gauss_kronrod::POINTS,
        }
    }

    #[inline]
    pub(crate) fn sums(&self, degrees: Degrees, integrand: &impl Fn(&Self, &Vertex) -> Four) -> Sums {
        match self {
            Self::Triangle(triangle) => {
                let [low, high] = degrees.pair();
                let (mut sums, mut coarse) = (Sums::default(), [0.0; 4]);
                for (l, weight) in &high.points {
                    sums.add(triangle.area * weight, integrand(self, &triangle.at(*l)));
                }
                for (l, weight) in &low.points {
                    add(&mut coarse, triangle.area * weight, integrand(self, &triangle.at(*l)));
                }
                let caution = if degrees == Degrees::Tight { CAUTION } else { 1.0 };
                sums.difference = [0, 1, 2, 3].map(|i| caution * (sums.integral[i] - coarse[i]));
                sums
            }
            Self::Edge(edge) => {
                let mut sums = Sums::default();
                for [t, kronrod, gauss] in gauss_kronrod::points() {
                    let f = integrand(self, &edge.at(t));
                    sums.add(kronrod, f);
                    add(&mut sums.difference, kronrod - gauss, f);
                }
                sums
            }
        }
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
