//! Symmetric quadrature rules for the triangle: weights positive, points inside.
//!
//! A fully symmetric rule of degree `d` is exact on `e2^i e3^j`, `2i + 3j <= d` (elementary symmetric polynomials of the barycentric
//! coordinates), which are as many equations as the orbits below have unknowns. They were solved by Gauss-Newton from random starts,
//! then by Newton steps at 60 digits; the numbers of points are those of Dunavant 1985 (degrees 8 and 14) and of Xiao and Gimbutas 2010
//! (degree 20). The test checks every monomial against `2 i! j! k! / (i + j + k + 2)!`, so a wrong digit cannot stay.

use std::sync::LazyLock;

/// Points that share a weight under the permutations of the corners.
#[derive(Debug, Clone, Copy)]
enum Orbit {
    Centroid {
        weight: f64,
    },
    /// `(a, a, 1 - 2a)`.
    Median {
        weight: f64,
        a: f64,
    },
    /// `(a, b, 1 - a - b)`.
    General {
        weight: f64,
        a: f64,
        b: f64,
    },
}

/// A rule: `int f dA = area * sum weight f(point)`, exact for polynomials up to the total degree that names it.
#[derive(Debug)]
pub(crate) struct TriangleRule {
    /// Barycentric coordinates and weight; the weights sum to 1.
    pub(crate) points: Vec<([f64; 3], f64)>,
}

/// Degree 8, 16 points.
const DEGREE_8_ORBITS: [Orbit; 5] = [
    Orbit::Centroid { weight: 0.144_315_607_677_787_168_2 },
    Orbit::Median { weight: 0.032_458_497_623_198_080_3, a: 0.050_547_228_317_030_975_4 },
    Orbit::Median { weight: 0.103_217_370_534_718_250_2, a: 0.170_569_307_751_760_206_6 },
    Orbit::Median { weight: 0.095_091_634_267_284_624_7, a: 0.459_292_588_292_723_156_0 },
    Orbit::General { weight: 0.027_230_314_174_434_994_2, a: 0.008_394_777_409_957_605_3, b: 0.263_112_829_634_638_113_4 },
];

/// Degree 14, 42 points.
const DEGREE_14_ORBITS: [Orbit; 10] = [
    Orbit::Median { weight: 0.051_774_104_507_291_586_3, a: 0.273_477_528_308_838_659_7 },
    Orbit::Median { weight: 0.021_883_581_369_428_890_6, a: 0.488_963_910_362_178_638_6 },
    Orbit::Median { weight: 0.014_433_699_669_776_667_6, a: 0.061_799_883_090_872_601_2 },
    Orbit::Median { weight: 0.032_788_353_544_125_350_6, a: 0.417_644_719_340_453_922_5 },
    Orbit::Median { weight: 0.042_162_588_736_993_017_5, a: 0.177_205_532_412_543_436_9 },
    Orbit::Median { weight: 0.004_923_403_602_400_081_6, a: 0.019_390_961_248_701_048_1 },
    Orbit::General { weight: 0.038_571_510_787_060_683_2, a: 0.092_916_249_356_971_824_7, b: 0.336_861_459_796_345_001_7 },
    Orbit::General { weight: 0.014_436_308_113_533_840_4, a: 0.014_646_950_055_654_409_6, b: 0.298_372_882_136_257_752_9 },
    Orbit::General { weight: 0.024_665_753_212_563_673_9, a: 0.172_266_687_821_355_578_3, b: 0.057_124_757_403_647_939_0 },
    Orbit::General { weight: 0.005_010_228_838_500_671_7, a: 0.001_268_330_932_872_025_0, b: 0.118_974_497_696_956_845_4 },
];

/// 16 points.
pub(crate) static DEGREE_8: LazyLock<TriangleRule> = LazyLock::new(|| TriangleRule::new(&DEGREE_8_ORBITS));
/// 42 points.
pub(crate) static DEGREE_14: LazyLock<TriangleRule> = LazyLock::new(|| TriangleRule::new(&DEGREE_14_ORBITS));

impl TriangleRule {
    fn new(orbits: &[Orbit]) -> Self {
        Self { points: orbits.iter().flat_map(Orbit::points).collect() }
    }
}

impl Orbit {
    fn points(&self) -> Vec<([f64; 3], f64)> {
        match *self {
            Self::Centroid { weight } => vec![([1.0 / 3.0; 3], weight)],
            Self::Median { weight, a } => {
                let c = 1.0 - 2.0 * a;
                [[a, a, c], [a, c, a], [c, a, a]].map(|l| (l, weight)).to_vec()
            }
            Self::General { weight, a, b } => {
                let c = 1.0 - a - b;
                [[a, b, c], [b, c, a], [c, a, b], [b, a, c], [a, c, b], [c, b, a]].map(|l| (l, weight)).to_vec()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn factorial(n: u32) -> f64 {
        (1..=n).map(f64::from).product()
    }

    /// Largest relative error over the monomials of one total degree.
    fn worst(rule: &TriangleRule, total: u32) -> f64 {
        let power = |x: f64, n: u32| (0..n).fold(1.0, |product, _| product * x);
        let mut worst: f64 = 0.0;
        for i in 0..=total {
            for j in 0..=total - i {
                let k = total - i - j;
                let sum: f64 = rule.points.iter().map(|(l, w)| w * power(l[0], i) * power(l[1], j) * power(l[2], k)).sum();
                let exact = 2.0 * factorial(i) * factorial(j) * factorial(k) / factorial(total + 2);
                worst = worst.max((sum - exact).abs() / exact);
            }
        }
        worst
    }

    #[test]
    fn every_monomial_is_exact_up_to_the_degree_and_not_beyond() {
        for (degree, rule) in [(8, &DEGREE_8), (14, &DEGREE_14)] {
            for total in 0..=degree {
                let error = worst(rule, total);
                assert!(error < 1e-12, "degree {degree}: a monomial of degree {total} is off by {error}");
            }
            assert!(worst(rule, degree + 1) > 1e-6, "degree {degree}: the test cannot see an error");
        }
    }

    #[test]
    fn points_are_inside_and_weights_positive() {
        for rule in [&DEGREE_8, &DEGREE_14] {
            assert!(rule.points.iter().all(|(l, w)| *w > 0.0 && l.iter().all(|c| *c > 0.0)));
        }
    }
}
