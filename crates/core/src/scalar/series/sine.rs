//! Coefficients of the series of `g - sin g`.

use crate::scalar::double_double::DoubleDouble;

/// `(-1)^k 6 / (2k + 3)!`: the series of `(g - sin g)/2` over `g^3/12`. For |g| <= 1 the ninth term is below 2^-55 of the
/// first, the fifteenth below 2^-110.
pub(crate) const SINE_SERIES: [DoubleDouble; 14] = [
    DoubleDouble { hi: 1.0, lo: 0.0 },
    DoubleDouble { hi: -0.05, lo: 2.7755575615628915e-18 },
    DoubleDouble { hi: 0.0011904761904761906, lo: -1.073876437509452e-19 },
    DoubleDouble { hi: -1.6534391534391536e-05, lo: 1.1150359644278832e-21 },
    DoubleDouble { hi: 1.5031265031265032e-07, lo: -8.692884425615472e-24 },
    DoubleDouble { hi: -9.635426302092969e-10, lo: -2.3812979247948356e-26 },
    DoubleDouble { hi: 4.58829823909189e-12, lo: 2.441807644005862e-28 },
    DoubleDouble { hi: -1.6868743526073125e-14, lo: 5.8719124659033765e-31 },
    DoubleDouble { hi: 4.932381147974598e-17, lo: -1.7529742638433214e-33 },
    DoubleDouble { hi: -1.1743764638034756e-19, lo: -3.850959854367479e-36 },
    DoubleDouble { hi: 2.3209021023784102e-22, lo: 1.8203980423156343e-38 },
    DoubleDouble { hi: -3.868170170630684e-25, lo: -1.1360631499275723e-41 },
    DoubleDouble { hi: 5.510213918277327e-28, lo: 3.1002665667269464e-44 },
    DoubleDouble { hi: -6.78597773186863e-31, lo: -1.91975154676065e-47 },
];

/// [`SINE_SERIES`] over 12 on doubles.
pub(crate) const DOUBLE_SERIES: [f64; 8] = {
    let (mut series, mut k) = ([0.0; 8], 0);
    while k < 8 {
        series[k] = SINE_SERIES[k].hi / 12.0;
        k += 1;
    }
    series
};
