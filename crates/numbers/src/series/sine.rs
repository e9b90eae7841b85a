//! The series of `g - sin g`, and the functions made of it.

use crate::arithmetic::Arithmetic;
use crate::double_double::DoubleDouble;
use crate::series::{nine_terms, seven_terms};

/// `(-1)^k 6 / (2k + 3)!`: the series of `(g - sin g)/2` over `g^3/12`. For |g| <= 1 the ninth term is below 2^-55 of the
/// first, the fifteenth below 2^-110.
pub const SINE_SERIES: [DoubleDouble; 14] = DoubleDouble::table([
    (1.0, 0.0),
    (-0.05, 2.7755575615628915e-18),
    (0.0011904761904761906, -1.073876437509452e-19),
    (-1.6534391534391536e-05, 1.1150359644278832e-21),
    (1.5031265031265032e-07, -8.692884425615472e-24),
    (-9.635426302092969e-10, -2.3812979247948356e-26),
    (4.58829823909189e-12, 2.441807644005862e-28),
    (-1.6868743526073125e-14, 5.8719124659033765e-31),
    (4.932381147974598e-17, -1.7529742638433214e-33),
    (-1.1743764638034756e-19, -3.850959854367479e-36),
    (2.3209021023784102e-22, 1.8203980423156343e-38),
    (-3.868170170630684e-25, -1.1360631499275723e-41),
    (5.510213918277327e-28, 3.1002665667269464e-44),
    (-6.78597773186863e-31, -1.91975154676065e-47),
]);

/// [`SINE_SERIES`] over 12 on doubles.
const DOUBLE_SERIES: [f64; 8] = {
    let (mut series, mut k) = ([0.0; 8], 0);
    while k < 8 {
        series[k] = SINE_SERIES[k].hi / 12.0;
        k += 1;
    }
    series
};

/// Coefficients of `psi(g)/g` in powers of `g^2` up to `(pi/2)^2`, of least largest relative error by Remez's algorithm: 2^-54
/// with rounded coefficients, most of it the rounding of 1/12.
const PSI: [f64; 10] = [
    0.083_333_333_333_333_33,
    0.002_777_777_777_777_888_5,
    9.920_634_920_487_068e-5,
    3.306_878_314_529_27e-6,
    1.043_837_648_752_227_8e-7,
    3.170_544_222_560_070_5e-9,
    9.365_030_454_239_462e-11,
    2.727_115_302_175_878e-12,
    7.214_105_562_980_108e-14,
    3.093_407_690_573_923_5e-15,
];

/// Errors of the coefficients and of the truncation of `double_sum` and of `psi` over the angle, in units of roundoff of 1.
pub const REST: [f64; 2] = [0.1, 0.06];

/// `DOUBLE_SERIES`, the first term last, off by a rounding; the eight leave 2^-55 of it.
#[inline(always)]
pub fn double_sum<T: Arithmetic>(z: T) -> T {
    let [first, others @ ..] = &DOUBLE_SERIES;
    (z.like(*first) + z * seven_terms(others, z)).known_to(REST[0])
}

/// `(g - sin g)/2`, by its Taylor series where the difference would cancel.
#[inline(always)]
pub fn half_angle_minus_sine<T: Arithmetic>(angle: T, sin: T) -> T {
    T::choose_of(
        angle.abs().exceeds(angle.like(1.0)),
        #[inline(always)]
        || (angle - sin) * angle.like(0.5),
        #[inline(always)]
        || {
            let square = angle * angle;
            if T::IS_DOUBLE {
                angle * square * double_sum(square)
            } else {
                angle * square * T::sine_series(square) / angle.like(12.0)
            }
        },
    )
}

/// `(g - sin g)/4(1 - cos g)`, up to a quarter turn.
///
/// On doubles by `PSI`; else for small g by the series p of `6 (g - sin g)/g^3`, `sin g = g (1 - g^2 p/6)` and
/// `1 - cos g = sin^2 g/(1 + cos g)`.
#[inline(always)]
pub fn psi<T: Arithmetic>(angle: T, sin: T, cos: T, one_and_cos: T) -> T {
    let square = angle * angle;
    if T::IS_DOUBLE {
        let [first, others @ ..] = &PSI;
        return angle * (square.like(*first) + square * nine_terms(others, square)).known_to(REST[1]);
    }
    T::choose_of(
        angle.abs().exceeds(angle.like(1.0)),
        #[inline(always)]
        || (angle - sin) / ((angle.like(1.0) - cos) * angle.like(4.0)),
        #[inline(always)]
        || {
            let series = T::sine_series(square);
            let sine_over_angle = angle.like(1.0) - square * series / angle.like(6.0);
            angle * series * one_and_cos / (sine_over_angle * sine_over_angle * angle.like(24.0))
        },
    )
}
