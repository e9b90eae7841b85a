//! The 7-point Gauss rule inside the 15-point Kronrod rule on `[0, 1]`: degrees 13 and 22 (Kronrod 1965; digits of QUADPACK,
//! 1983).

/// Node on `[-1, 1]`, Kronrod weight, Gauss weight; the negative nodes by symmetry. Weights sum to 2.
const HALF: [[f64; 3]; 8] = [
    [0.991_455_371_120_812_6, 0.022_935_322_010_529_224, 0.0],
    [0.949_107_912_342_758_5, 0.063_092_092_629_978_56, 0.129_484_966_168_869_7],
    [0.864_864_423_359_769_1, 0.104_790_010_322_250_19, 0.0],
    [0.741_531_185_599_394_5, 0.140_653_259_715_525_92, 0.279_705_391_489_276_64],
    [0.586_087_235_467_691_1, 0.169_004_726_639_267_9, 0.0],
    [0.405_845_151_377_397_2, 0.190_350_578_064_785_42, 0.381_830_050_505_118_9],
    [0.207_784_955_007_898_48, 0.204_432_940_075_298_89, 0.0],
    [0.0, 0.209_482_141_084_727_82, 0.417_959_183_673_469_4],
];

/// Points of the rule.
pub(crate) const POINTS: usize = 15;

/// Position on `[0, 1]`, Kronrod weight and Gauss weight; each set of weights sums to 1.
pub(crate) fn points() -> impl Iterator<Item = [f64; 3]> {
    HALF.into_iter().flat_map(|[node, kronrod, gauss]| {
        let both = [-node, node].map(|x| [0.5 + 0.5 * x, 0.5 * kronrod, 0.5 * gauss]);
        both.into_iter().take(if node == 0.0 { 1 } else { 2 })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_rules_are_exact_up_to_their_degrees_and_not_beyond() {
        assert_eq!(points().count(), POINTS);
        // Legendre polynomials on [0, 1] integrate to 0 (to 1 for degree 0) and do not cancel as powers would.
        let legendre = |degree: u32, t: f64| {
            let (x, mut before, mut now) = (2.0 * t - 1.0, 0.0, 1.0);
            for k in 0..degree {
                let k = f64::from(k);
                (before, now) = (now, ((2.0 * k + 1.0) * x * now - k * before) / (k + 1.0));
            }
            now
        };
        for (column, last) in [(1, 22), (2, 13)] {
            let error = |degree| {
                let sum: f64 = points().map(|point| point[column] * legendre(degree, point[0])).sum();
                (sum - f64::from(u8::from(degree == 0))).abs()
            };
            for degree in 0..=last {
                assert!(error(degree) < 1e-15, "weights {column} are off by {} at degree {degree}", error(degree));
            }
            assert!(error(24) > 1e-3 || error(14) > 1e-3);
        }
    }
}
