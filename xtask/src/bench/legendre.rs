//! Gauss-Legendre rules on [0, 1] in double precision: roots of `P_n` by Newton's method from Tricomi's estimate, weights
//! `2 (1 - x^2) / (n P_{n-1}(x))^2` (Abramowitz and Stegun 25.4.29). Nodes are good to an ulp or two, weights to `n` of them.

/// Nodes in (0, 1) with their weights, which sum to 1.
pub(crate) fn rule(count: u32) -> Vec<(f64, f64)> {
    (1..=count).map(|k| node(count, k)).collect()
}

fn node(count: u32, k: u32) -> (f64, f64) {
    let n = f64::from(count);
    let mut x = -libm::cos(std::f64::consts::PI * (f64::from(k) - 0.25) / (n + 0.5));
    for _ in 0..8 {
        let (value, before) = legendre(count, x);
        x -= value * (x * x - 1.0) / (n * (x * value - before));
    }
    let (_, before) = legendre(count, x);
    (0.5 + 0.5 * x, (1.0 - x * x) / (n * before * n * before))
}

/// `P_n` and `P_{n-1}` at `x` by their recurrence.
fn legendre(n: u32, x: f64) -> (f64, f64) {
    let (mut now, mut before) = (1.0, 0.0);
    for k in 0..n {
        let k = f64::from(k);
        (now, before) = (((2.0 * k + 1.0) * x * now - k * before) / (k + 1.0), now);
    }
    (now, before)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_are_exact_up_to_twice_the_nodes_less_one_and_not_beyond() {
        for count in [1, 2, 3, 8, 17, 64] {
            let rule = rule(count);
            let error = |degree: u32| {
                // P_degree on [0, 1] integrates to 0, and does not cancel as powers do.
                let sum: f64 = rule.iter().map(|(t, w)| w * legendre(degree, 2.0 * t - 1.0).0).sum();
                (sum - f64::from(u8::from(degree == 0))).abs()
            };
            assert!((0..2 * count).all(|degree| error(degree) < 1e-14), "{count} nodes");
            assert!(error(2 * count) > 1e-3, "{count} nodes");
        }
    }
}
