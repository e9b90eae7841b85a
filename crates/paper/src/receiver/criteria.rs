//! Whether the samples of an element say that it should be divided (HS95 3.2).
//!
//! - **Constant elements.** Along a vector v the radiosity changes by `grad B . v`, to first order; so over the widths of an
//!   element ([`variation`]). The largest says by how much, and in which direction first.
//! - **Linear elements.** Along an edge of length L with values B0, B1 and slopes B0', B1' at its ends, the cubic through all four
//!   leaves the straight line by `t(1-t)[(1-t) a - t b]`, `a = L B0' - (B1 - B0)`, `b = L B1' - (B1 - B0)`, at the fraction t of
//!   the edge ([`departure`]). Neither curve is built. Where that is largest is the best next sample.
//!
//! Units: those of the radiosity. Both compute their formula to rounding, and estimate the error of an element: the first leaves
//! out second derivatives, the second the fourth ones, which leave `L^4 B''''/384` at most.

use radgrad_core::DVec3;
use radgrad_scene::largest;

/// The change of a function with this gradient along each of two widths of an element, to first order.
///
/// ```
/// use radgrad_core::DVec3;
/// use radgrad_paper::receiver::variation;
/// let along = variation(DVec3::new(3.0, -1.0, 9.0), [DVec3::X, 2.0 * DVec3::Y]);
/// assert_eq!(along, [3.0, 2.0], "divide the first width; the part along the normal does not count");
/// ```
#[must_use]
pub fn variation(gradient: DVec3, widths: [DVec3; 2]) -> [f64; 2] {
    widths.map(|width| gradient.dot(width).abs())
}

/// Where the cubic through values and slopes of an edge leaves the straight line most, and by how much.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Departure {
    /// Magnitude of the difference there.
    pub largest: f64,
    /// Fraction of the edge, between `1/2 - 1/sqrt(12) = 0.211` and 0.789: the best next sample.
    pub at: f64,
}

/// Compares the cubic with the straight line through the ends of an edge: `values` there, `slopes` the gradients times the edge,
/// in the unit of the values.
///
/// The extrema of `t(1-t)(a - c t)`, `c = a + b`, are the roots of `a - 2 (a + c) t + 3 c t^2`, whose discriminant is
/// `a^2 + a b + b^2`: both real, and one at least inside. They come from the sum that does not cancel.
///
/// ```
/// use radgrad_paper::receiver::departure;
/// // t^2 from 0 to 1: a parabola leaves its chord by 1/4, in the middle.
/// let parabola = departure([0.0, 1.0], [0.0, 2.0]);
/// assert_eq!((parabola.largest, parabola.at), (0.25, 0.5));
/// assert_eq!(departure([1.0, 3.0], [2.0, 2.0]).largest, 0.0, "a straight line");
/// ```
#[must_use]
pub fn departure(values: [f64; 2], slopes: [f64; 2]) -> Departure {
    let rise = values[1] - values[0];
    let (a, b) = (slopes[0] - rise, slopes[1] - rise);
    let unit = largest(a.abs(), b.abs());
    if unit == 0.0 {
        return Departure { largest: 0.0, at: 0.5 };
    }
    let (a, b) = (a / unit, b / unit);
    let c = a + b;
    let half = a + c;
    let q = half + (a * a + a * b + b * b).sqrt().copysign(half);
    let difference = |t: f64| (t * (1.0 - t) * (a - c * t)).abs();
    let inside = [a / q, q / (3.0 * c)].into_iter().filter(|t| (0.0..=1.0).contains(t));
    let root = inside.max_by(|s, t| difference(*s).total_cmp(&difference(*t))).unwrap_or(0.5);
    Departure { largest: unit * difference(root), at: root }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The cubic through the data less the line, from the Hermite basis: the long way.
    fn built([p, q]: [f64; 2], [m, n]: [f64; 2], t: f64) -> f64 {
        let cubic = (1.0 + 2.0 * t) * (1.0 - t) * (1.0 - t) * p
            + t * (1.0 - t) * (1.0 - t) * m
            + t * t * (3.0 - 2.0 * t) * q
            + t * t * (t - 1.0) * n;
        cubic - (p + (q - p) * t)
    }

    #[test]
    fn the_largest_departure_is_that_of_the_cubic_that_is_not_built() {
        let data = [-3.0, -1.0, -0.2, 0.0, 0.5, 1.0, 4.0];
        let mut curved = 0;
        for p in data {
            for q in data {
                for m in data {
                    for n in data {
                        let chord = departure([p, q], [m, n]);
                        let grid = (0..=2000).map(|i| built([p, q], [m, n], f64::from(i) / 2000.0).abs()).fold(0.0, largest);
                        assert!((chord.largest - grid).abs() <= 1e-5 * (1.0 + grid), "{p} {q} {m} {n}: {chord:?} {grid}");
                        assert!((built([p, q], [m, n], chord.at).abs() - chord.largest).abs() < 1e-13);
                        if chord.largest > 0.0 {
                            assert!(chord.at > 0.2113 && chord.at < 0.7887, "{p} {q} {m} {n}: {chord:?}");
                            curved += 1;
                        }
                    }
                }
            }
        }
        assert!(curved > 2000);
    }

    #[test]
    fn scaling_by_a_power_of_two_scales_the_departure_exactly() {
        let power = 2.0_f64.powi(900);
        let (one, large) =
            (departure([0.3, 1.1], [2.0, -0.7]), departure([0.3 * power, 1.1 * power], [2.0 * power, -0.7 * power]));
        assert_eq!((one.largest * power, one.at), (large.largest, large.at));
        let small = departure([0.3 / power, 1.1 / power], [2.0 / power, -0.7 / power]);
        assert!((small.at - one.at).abs() < 1e-15 && small.largest == one.largest / power);
    }
}
