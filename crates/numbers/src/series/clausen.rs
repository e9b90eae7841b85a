//! Coefficients of the series of [`crate::dilogarithm`] as double-doubles: computed with 120 digits, rounded; its tests
//! hold the values that they give against others found without the series.

use crate::arithmetic::Arithmetic;
use crate::double_double::DoubleDouble;
use crate::series::four_terms;

/// `|B_2k| 2^(2k-1) / (2k+1)!`, k = 1..54.
pub const SERIES: [DoubleDouble; 54] = [
    DoubleDouble { hi: 0.05555555555555555, lo: 3.0839528461809902e-18 },
    DoubleDouble { hi: 0.0022222222222222222, lo: 1.927470528863119e-21 },
    DoubleDouble { hi: 0.0001511715797430083, lo: 1.4218373161469012e-21 },
    DoubleDouble { hi: 1.1757789535567314e-05, lo: -6.79976737292588e-22 },
    DoubleDouble { hi: 9.717181434353152e-07, lo: -7.544717337086947e-23 },
    DoubleDouble { hi: 8.324631849255374e-08, lo: -1.5721464449969858e-24 },
    DoubleDouble { hi: 7.308649283957926e-09, lo: 2.051349125934165e-25 },
    DoubleDouble { hi: 6.533708467641082e-10, lo: 4.105216607505688e-26 },
    DoubleDouble { hi: 5.923117504423419e-11, lo: -7.741133610152006e-28 },
    DoubleDouble { hi: 5.429797905855282e-12, lo: -8.540586176339315e-29 },
    DoubleDouble { hi: 5.02313752152231e-13, lo: -4.9658138510394975e-29 },
    DoubleDouble { hi: 4.6823413639649765e-14, lo: 2.968210870658863e-30 },
    DoubleDouble { hi: 4.392781000043269e-15, lo: 1.185385698542183e-31 },
    DoubleDouble { hi: 4.1438647126392597e-16, lo: 1.0118303039678668e-33 },
    DoubleDouble { hi: 3.927734520836027e-17, lo: 2.6565318080221014e-33 },
    DoubleDouble { hi: 3.73843758260183e-18, lo: -2.909588618765944e-34 },
    DoubleDouble { hi: 3.5713818244601157e-19, lo: -1.377645295519208e-35 },
    DoubleDouble { hi: 3.422968156406263e-20, lo: 1.43903132702318e-36 },
    DoubleDouble { hi: 3.2903358593367033e-21, lo: 1.121069013290003e-37 },
    DoubleDouble { hi: 3.1711824951386917e-22, lo: 2.1355012183729086e-38 },
    DoubleDouble { hi: 3.063634074901605e-23, lo: -1.218463622521359e-39 },
    DoubleDouble { hi: 2.966149849063772e-24, lo: 3.9565536731389547e-41 },
    DoubleDouble { hi: 2.877451406498969e-25, lo: 4.653678587559092e-42 },
    DoubleDouble { hi: 2.796469137112195e-26, lo: 2.8853858229307306e-43 },
    DoubleDouble { hi: 2.722301291486709e-27, lo: 1.221964481763306e-43 },
    DoubleDouble { hi: 2.6541823100583766e-28, lo: 1.3208949636627135e-44 },
    DoubleDouble { hi: 2.5914580623011744e-29, lo: -5.0035568625086285e-46 },
    DoubleDouble { hi: 2.5335662987282234e-30, lo: 1.4598968298828065e-46 },
    DoubleDouble { hi: 2.4800210787692166e-31, lo: 1.2655077840144517e-47 },
    DoubleDouble { hi: 2.4304002620281676e-32, lo: -8.179366591326979e-49 },
    DoubleDouble { hi: 2.3843353821704522e-33, lo: 1.5950759188569003e-49 },
    DoubleDouble { hi: 2.3415033902576012e-34, lo: 1.1936201691563398e-50 },
    DoubleDouble { hi: 2.3016198768991118e-35, lo: 4.8394699385424635e-52 },
    DoubleDouble { hi: 2.264433473171599e-36, lo: 8.929853970464598e-53 },
    DoubleDouble { hi: 2.229721197872432e-37, lo: -1.253275209745038e-53 },
    DoubleDouble { hi: 2.1972845696191877e-38, lo: -9.042581124529517e-55 },
    DoubleDouble { hi: 2.1669463410238452e-39, lo: 8.036294948380881e-56 },
    DoubleDouble { hi: 2.1385477418373594e-40, lo: 1.8158547790488644e-56 },
    DoubleDouble { hi: 2.1119461408674632e-41, lo: -5.073457017213607e-58 },
    DoubleDouble { hi: 2.087013054289277e-42, lo: 6.299299033670724e-59 },
    DoubleDouble { hi: 2.0636324419211577e-43, lo: -1.0323173869611855e-59 },
    DoubleDouble { hi: 2.0416992440363413e-44, lo: 1.0257631562294179e-60 },
    DoubleDouble { hi: 2.02111812000361e-45, lo: 1.5102618116249682e-61 },
    DoubleDouble { hi: 2.0018023570087164e-46, lo: 1.687616955895392e-62 },
    DoubleDouble { hi: 1.983672922690427e-47, lo: -1.1461906913921228e-63 },
    DoubleDouble { hi: 1.966657640026744e-48, lo: -1.489535152243159e-64 },
    DoubleDouble { hi: 1.9506904664556143e-49, lo: 1.6049429626386336e-65 },
    DoubleDouble { hi: 1.935710862186098e-50, lo: -2.4762876160843387e-67 },
    DoubleDouble { hi: 1.9216632350873216e-51, lo: 2.419881649695977e-68 },
    DoubleDouble { hi: 1.908496451540607e-52, lo: -6.521499446460746e-69 },
    DoubleDouble { hi: 1.8961634042890174e-53, lo: -1.140718978802939e-69 },
    DoubleDouble { hi: 1.8846206296847936e-54, lo: -6.1097209894422925e-71 },
    DoubleDouble { hi: 1.8738279678715212e-55, lo: 1.1974474559708814e-72 },
    DoubleDouble { hi: 1.8637482603865976e-56, lo: -8.612522832313225e-73 },
];

/// Relative error of `dilogarithm::clausen_rest` on doubles, in units of roundoff: the square of x and two
/// products cost 3, the last sum 1, the first coefficient and the polynomial's own error 1/2, and the other terms, at most 11 %
/// of the sum, less than 1.
pub const DOUBLE_UNITS: f64 = 6.0;

/// Largest relative error of the polynomial on doubles, 2^-54.0 as below, rounded up.
pub const DOUBLE_TRUNCATION: f64 = 0.26 * f64::EPSILON;

/// The same on double-doubles and beyond.
pub const UNITS: f64 = 12.0;

/// `J(x)/x^3` in powers of `x^2` up to `(pi/2)^2`, of least largest relative error by Remez's algorithm: 2^-56.3, with rounded
/// coefficients 2^-54.0, most of it the rounding of 1/18.
const DOUBLE_SERIES: [f64; 14] = [
    0.055_555_555_555_555_55,
    0.002_222_222_222_222_317_6,
    0.000_151_171_579_740_527_1,
    1.175_778_956_096_658_6e-5,
    9.717_180_080_452_028e-7,
    8.324_674_961_609_544e-8,
    7.307_763_135_226_125_5e-9,
    6.546_010_760_018_613e-10,
    5.804_915_719_980_628e-11,
    6.221_792_516_728_831e-12,
    1.357_631_665_206_615_7e-13,
    1.602_253_675_050_409_4e-13,
    -1.735_363_904_965_277e-14,
    2.548_816_255_574_815e-15,
];

/// The polynomial, its first term last and the others by Estrin's scheme.
#[inline(always)]
pub fn double_sum<T: Arithmetic>(z: T) -> T {
    let c = &DOUBLE_SERIES;
    let z2 = z * z;
    let z4 = z2 * z2;
    let low = four_terms(&[c[1], c[2], c[3], c[4]], z, z2) + four_terms(&[c[5], c[6], c[7], c[8]], z, z2) * z4;
    let high = four_terms(&[c[9], c[10], c[11], c[12]], z, z2) + z.like(c[13]) * z4;
    z.like(c[0]) + z * (low + high * (z4 * z4))
}
