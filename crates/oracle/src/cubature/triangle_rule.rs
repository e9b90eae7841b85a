//! Symmetric quadrature rules for the triangle: weights positive, points inside.
//!
//! A fully symmetric rule of degree `d` is exact on `e2^i e3^j`, `2i + 3j <= d` (elementary symmetric polynomials of the
//! barycentric coordinates): 10, 24 and 33 equations for the 10, 24 and 35 unknowns of the orbits below. They were solved by
//! Gauss-Newton from random starts, then by Newton steps at 60 digits; the numbers of points are those of Dunavant 1985
//! (degrees 8, 14, 17). The test checks every monomial against `2 i! j! k! / (i + j + k + 2)!`, so a wrong digit cannot stay.

use std::sync::LazyLock;

/// Points that share a weight under the permutations of the corners: the weight, and `[]` for the centroid, `[a]` for `(a, a, 1 - 2a)`, `[a, b]`
/// for `(a, b, 1 - a - b)`.
type Orbit = (f64, &'static [f64]);

/// A rule: `int f dA = area * sum weight f(point)`, exact for polynomials up to the total degree that names it.
#[derive(Debug)]
pub(crate) struct TriangleRule {
    /// Barycentric coordinates and weight; the weights sum to 1.
    pub(crate) points: Vec<([f64; 3], f64)>,
}

/// Degree 8, 16 points.
const DEGREE_8_ORBITS: [Orbit; 5] = [
    (0.144_315_607_677_787_17, &[]),
    (0.032_458_497_623_198_08, &[0.050_547_228_317_030_98]),
    (0.103_217_370_534_718_24, &[0.170_569_307_751_760_2]),
    (0.095_091_634_267_284_62, &[0.459_292_588_292_723_2]),
    (0.027_230_314_174_434_993, &[0.008_394_777_409_957_605, 0.263_112_829_634_638_1]),
];

/// Degree 14, 42 points.
const DEGREE_14_ORBITS: [Orbit; 10] = [
    (0.051_774_104_507_291_585, &[0.273_477_528_308_838_65]),
    (0.021_883_581_369_428_89, &[0.488_963_910_362_178_6]),
    (0.014_433_699_669_776_668, &[0.061_799_883_090_872_6]),
    (0.032_788_353_544_125_35, &[0.417_644_719_340_453_94]),
    (0.042_162_588_736_993_016, &[0.177_205_532_412_543_44]),
    (0.004_923_403_602_400_082, &[0.019_390_961_248_701_048]),
    (0.038_571_510_787_060_684, &[0.092_916_249_356_971_82, 0.336_861_459_796_345]),
    (0.014_436_308_113_533_84, &[0.014_646_950_055_654_41, 0.298_372_882_136_257_73]),
    (0.024_665_753_212_563_674, &[0.172_266_687_821_355_57, 0.057_124_757_403_647_94]),
    (0.005_010_228_838_500_672, &[0.001_268_330_932_872_025, 0.118_974_497_696_956_85]),
];

/// Degree 17, 61 points.
const DEGREE_17_ORBITS: [Orbit; 15] = [
    (0.034_472_970_820_117_63, &[]),
    (0.033_224_474_836_142_23, &[0.257_593_296_207_076_27]),
    (0.003_130_757_035_438_486_4, &[0.015_473_446_206_470_228]),
    (0.028_779_607_189_361_654, &[0.185_815_852_887_428_9]),
    (0.019_319_988_741_925_46, &[0.114_826_141_919_368_9]),
    (0.023_744_517_030_681_065, &[0.473_572_037_969_784_7]),
    (0.010_555_850_236_848_926, &[0.059_083_850_503_816_96]),
    (0.031_872_239_165_352_58, &[0.407_187_088_927_420_45]),
    (0.004_946_031_159_325_822, &[0.499_107_722_129_055_4]),
    (0.019_656_488_701_633_803, &[0.072_825_058_452_561, 0.235_967_455_771_235_48]),
    (0.028_852_768_275_030_242, &[0.116_541_335_042_313_45, 0.333_708_332_668_685_77]),
    (0.003_306_031_524_706_004_4, &[0.001_262_997_409_091_473_7, 0.231_825_453_632_147_02]),
    (0.004_394_951_679_551_023, &[0.008_595_325_523_428_178, 0.082_268_916_283_039_3]),
    (0.015_075_346_042_931_448, &[0.021_606_530_225_485_06, 0.343_891_400_647_468_54]),
    (0.011_848_852_608_589_762, &[0.029_779_955_999_709_83, 0.162_645_881_911_036_2]),
];

/// 16 points.
pub(crate) static DEGREE_8: LazyLock<TriangleRule> = LazyLock::new(|| TriangleRule::new(&DEGREE_8_ORBITS));
/// 42 points.
pub(crate) static DEGREE_14: LazyLock<TriangleRule> = LazyLock::new(|| TriangleRule::new(&DEGREE_14_ORBITS));
/// 61 points.
pub(crate) static DEGREE_17: LazyLock<TriangleRule> = LazyLock::new(|| TriangleRule::new(&DEGREE_17_ORBITS));

impl TriangleRule {
    fn new(orbits: &[Orbit]) -> Self {
        let points = |&(weight, coordinates): &Orbit| {
            let places = match *coordinates {
                [a, b, ..] => {
                    let c = 1.0 - a - b;
                    vec![[a, b, c], [b, c, a], [c, a, b], [b, a, c], [a, c, b], [c, b, a]]
                }
                [a] => {
                    let c = 1.0 - 2.0 * a;
                    vec![[a, a, c], [a, c, a], [c, a, a]]
                }
                [] => vec![[1.0 / 3.0; 3]],
            };
            places.into_iter().map(move |place| (place, weight))
        };
        Self { points: orbits.iter().flat_map(points).collect() }
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
        for (degree, rule) in [(8, &DEGREE_8), (14, &DEGREE_14), (17, &DEGREE_17)] {
            for total in 0..=degree {
                let error = worst(rule, total);
                assert!(error < 1e-12, "degree {degree}: a monomial of degree {total} is off by {error}");
            }
            assert!(worst(rule, degree + 1) > 1e-6, "degree {degree}: the test cannot see an error");
        }
    }

    #[test]
    fn points_are_inside_and_weights_positive() {
        for rule in [&DEGREE_8, &DEGREE_14, &DEGREE_17] {
            assert!(rule.points.iter().all(|(l, w)| *w > 0.0 && l.iter().all(|c| *c > 0.0)));
        }
    }
}
