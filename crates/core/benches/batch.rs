//! Cost of a batch for each receiver or emitter: by instruction set, precision, requested quantities, and regime. `scalar` is the
//! scalar path on the same receivers; `by_hand_f64` and `by_hand_f32` are the sums of a fully visible triangle, the same
//! operations to the same digits, written for AVX-512 alone: one normal, no clipping, no bound, and one answer whether all are
//! settled.

use divan::{Bencher, black_box, counter::ItemsCount};
#[cfg(target_arch = "x86_64")]
use fearless_simd::{Avx512, Level, f32x16, f64x8, prelude::*};
use radgrad_core::batch::{Answers, Emitters, Engine, Precision, Receivers};
use radgrad_core::{DVec3, Emission, Emitter, Error, Polygon, Receiver, radiosity_and_gradient};
#[cfg(target_arch = "x86_64")]
use radgrad_numbers::lanes::{angle::ArcTangent, lane::align_frame};

fn main() {
    divan::main();
}

const COUNT: usize = 4096;
const REGIMES: [&str; 4] = ["easy", "clipped", "near 1e-2", "far 1e2"];

/// A triangle about as wide as it is far in the easy regime, with corners that both precisions hold.
fn lamp(shift: f64) -> Emitter {
    let corners = [[0.0, 0.0, 1.0], [0.5, 0.75, 1.0], [1.0, 0.0, 1.0]].map(|corner| DVec3::from(corner) + DVec3::X * shift);
    Emitter::new(Polygon::new(corners.to_vec()).expect("a triangle"), Emission::Constant(2.0)).expect("a finite value")
}

/// Positions, normals and reflectance of a regime's receivers, on a lattice.
fn lattice<F>(regime: &str, round: impl Fn(f64) -> F) -> [Vec<F>; 7] {
    let receiver = |i: usize| {
        let (x, y) = ((i % 64) as f64 / 64.0, (i / 64) as f64 / 64.0);
        match regime {
            "easy" => [x, y, -0.5, 0.25, -0.125, 1.0, 0.75],
            "clipped" => [x, y, 0.0, 1.0, 0.25, 0.125, 0.75],
            "near 1e-2" => [x, y, 1.0 - 0.01, 0.25, -0.125, 1.0, 0.75],
            _ => [x, y, -1e2, 0.25, -0.125, 1.0, 0.75],
        }
    };
    std::array::from_fn(|axis| (0..COUNT).map(|i| round(receiver(i)[axis])).collect())
}

fn receivers<F: Precision>([x, y, z, nx, ny, nz, rho]: &[Vec<F>; 7]) -> Receivers<'_, F> {
    Receivers::new([x, y, z], [nx, ny, nz], rho).expect("receivers")
}

/// An answer for a bench to repeat.
type Answering<'a, F> = &'a dyn Fn(&Receivers<'_, F>, &Emitter, &mut Answers<F>) -> Result<(), Error>;

fn each<F: Precision>(bencher: Bencher<'_, '_>, regime: &[Vec<F>; 7], answer: Answering<'_, F>) {
    let (receivers, lamp, mut answers) = (receivers(regime), lamp(0.0), Answers::new());
    answer(&receivers, &lamp, &mut answers).expect("finite");
    bencher.counter(ItemsCount::new(COUNT)).bench_local(|| answer(black_box(&receivers), &lamp, &mut answers).expect("finite"));
}

fn double(regime: &str) -> [Vec<f64>; 7] {
    lattice(regime, |v| v)
}

fn single(regime: &str) -> [Vec<f32>; 7] {
    #[allow(clippy::cast_possible_truncation, reason = "to the nearest")]
    lattice(regime, |v| v as f32)
}

#[divan::bench(args = REGIMES)]
fn scalar(bencher: Bencher<'_, '_>, regime: &str) {
    let [x, y, z, nx, ny, nz, rho] = double(regime);
    let receiver =
        |i: usize| Receiver::new(DVec3::new(x[i], y[i], z[i]), DVec3::new(nx[i], ny[i], nz[i]), rho[i]).expect("a receiver");
    let (receivers, lamp): (Vec<_>, _) = ((0..COUNT).map(receiver).collect(), lamp(0.0));
    let sum =
        || receivers.iter().map(|receiver| radiosity_and_gradient(black_box(receiver), &lamp).expect("finite").0).sum::<f64>();
    bencher.counter(ItemsCount::new(COUNT)).bench_local(sum);
}

#[divan::bench(args = Engine::all())]
fn value_f64(bencher: Bencher<'_, '_>, engine: &Engine) {
    each(bencher, &double("easy"), &|receivers, lamp, answers| engine.radiosity(receivers, lamp, answers));
}

#[divan::bench(args = Engine::all())]
fn value_and_gradient_f64(bencher: Bencher<'_, '_>, engine: &Engine) {
    each(bencher, &double("easy"), &|receivers, lamp, answers| engine.radiosity_and_gradient(receivers, lamp, answers));
}

#[divan::bench(args = Engine::all())]
fn value_and_gradient_f32(bencher: Bencher<'_, '_>, engine: &Engine) {
    each(bencher, &single("easy"), &|receivers, lamp, answers| engine.radiosity_and_gradient(receivers, lamp, answers));
}

#[divan::bench(args = REGIMES)]
fn certified_f64(bencher: Bencher<'_, '_>, regime: &str) {
    let engine = Engine::new();
    each(bencher, &double(regime), &|receivers, lamp, answers| engine.evaluate_to(receivers, lamp, 1e-10, answers));
}

#[divan::bench(args = REGIMES)]
fn plain_f32(bencher: Bencher<'_, '_>, regime: &str) {
    let engine = Engine::new();
    each(bencher, &single(regime), &|receivers, lamp, answers| engine.radiosity_and_gradient(receivers, lamp, answers));
}

#[divan::bench(args = Engine::all())]
fn many_emitters_f64(bencher: Bencher<'_, '_>, engine: &Engine) {
    let lamps: Vec<Emitter> = (0..COUNT).map(|i| lamp(i as f64 / COUNT as f64)).collect();
    let (lamps, mut answers) = (Emitters::<f64>::new(&lamps), Answers::new());
    let receiver = Receiver::new(DVec3::new(0.5, 0.5, -0.5), DVec3::new(0.25, -0.125, 1.0), 0.75).expect("a receiver");
    engine.each(&receiver, &lamps, &mut answers).expect("finite");
    bencher
        .counter(ItemsCount::new(COUNT))
        .bench_local(|| engine.each(black_box(&receiver), &lamps, &mut answers).expect("finite"));
}

/// Value and gradient of a unit emission times `scale` at receivers that see all of a triangle, by the formulas of the crate's
/// `batch::edge` and `radgrad_numbers::lanes::angle`; whether all of it is above the horizon of all of them.
#[cfg(target_arch = "x86_64")]
macro_rules! by_hand {
    ($name:ident, $number:ty, $vector:ident, $lanes:literal, $constants:expr) => {
        fearless_simd::kernel!(
            #[inline(never)]
            fn $name(
                avx512: Avx512,
                receivers: [&[$number]; 6],
                corners: [[$number; 3]; 3],
                scale: $number,
                answers: &mut [Vec<$number>; 4],
            ) -> bool {
                align_frame();
                type V = $vector<Avx512>;
                let splat = |v: $number| V::splat(avx512, v);
                let dot = |a: [V; 3], b: [V; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
                let cross =
                    |a: [V; 3], b: [V; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
                let ArcTangent { polynomial: series, half_pi, half } = $constants;
                let edges = [0, 1, 2].map(|i: usize| [0, 1, 2].map(|k: usize| corners[(i + 1) % 3][k] - corners[i][k]));
                let squares = edges.map(|e| e[0] * e[0] + e[1] * e[1] + e[2] * e[2]);
                let (zero, mut is_above) = (splat(0.0), true);
                for first in (0..receivers[0].len()).step_by($lanes) {
                    let load = |k: usize| V::from_slice(avx512, &receivers[k][first..first + $lanes]);
                    let (x, n) = ([load(0), load(1), load(2)], [load(3), load(4), load(5)]);
                    let inverse = splat(1.0) / dot(n, n).sqrt();
                    let n = [n[0] * inverse, n[1] * inverse, n[2] * inverse];
                    let offset = |c: [$number; 3]| [splat(c[0]) - x[0], splat(c[1]) - x[1], splat(c[2]) - x[2]];
                    let r = [offset(corners[0]), offset(corners[1]), offset(corners[2])];
                    let square = [dot(r[0], r[0]), dot(r[1], r[1]), dot(r[2], r[2])];
                    let height = [dot(n, r[0]), dot(n, r[1]), dot(n, r[2])];
                    is_above &= zero.simd_lt(height[0].min(height[1]).min(height[2])).all_true();
                    let mut w = [[zero; 3]; 3];
                    let (mut own, mut moment, mut inline, mut product) = ([zero; 3], [zero; 3], [zero; 3], [zero; 3]);
                    for k in 0..3 {
                        w[k] = cross(r[k], [splat(edges[k][0]), splat(edges[k][1]), splat(edges[k][2])]);
                        own[k] = dot(w[k], w[k]);
                        moment[k] = own[k].sqrt();
                        inline[k] = dot(r[k], r[(k + 1) % 3]);
                        product[k] = splat(1.0) / (own[k] * (square[k] * square[(k + 1) % 3]));
                    }
                    let (mut z, mut shifted) = ([zero; 3], [zero.simd_lt(zero); 3]);
                    for k in 0..3 {
                        let width = inline[k].abs();
                        let (least, most) = (moment[k].min(width), moment[k].max(width));
                        let (half_least, half_most) = (least * splat(0.5), most * splat(0.5));
                        shifted[k] = half_most.simd_lt(least + half_least);
                        z[k] = shifted[k].select(least - half_most, least) / shifted[k].select(most + half_least, most);
                    }
                    let q = [z[0] * z[0], z[1] * z[1], z[2] * z[2]];
                    let last = series.len() - 1;
                    let (mut sum, mut other) = ([splat(series[last]); 3], [splat(series[last - 1]); 3]);
                    for c in series[..last - 1].iter().rev() {
                        for k in 0..3 {
                            (sum[k], other[k]) = (other[k], sum[k] * (q[k] * q[k]) + splat(*c));
                        }
                    }
                    let (mut value, mut gradient) = (zero, [zero; 3]);
                    for k in 0..3 {
                        let small = z[k] + z[k] * (q[k] * (sum[k] * q[k] + other[k]));
                        let (steep, leftward) = (inline[k].abs().simd_lt(moment[k]), inline[k].simd_lt(zero));
                        let part =
                            |i: usize| steep.select(splat(half_pi[i]), leftward.select(splat(half_pi[i] + half_pi[i]), zero));
                        let turned = steep ^ leftward;
                        let shift = shifted[k].select(turned.select(splat(-half[0]), splat(half[0])), zero);
                        let near = shifted[k].select(splat(half[1]), zero) + small;
                        let high = part(0) + shift;
                        let angle = high + ((((part(0) - high) + shift) + part(1)) + turned.select(-near, near));
                        let e = [splat(edges[k][0]), splat(edges[k][1]), splat(edges[k][2])];
                        let (e_square, e_inverse) = (splat(squares[k]), splat(1.0 / squares[k]));
                        let inverse_square = product[k] * (square[k] * square[(k + 1) % 3]);
                        let turn = angle * (moment[k] * inverse_square);
                        value += turn * dot(n, w[k]);
                        let (along, level) = (dot(r[k], e), dot(n, e));
                        let reach = (along + along + e_square) * e_inverse;
                        let toward = height[k] * e_square - along * level;
                        let between = product[k] * own[k];
                        let straight = (e_inverse + e_inverse) - inline[k] * inverse_square;
                        let term = toward * (inverse_square * turn + between * straight) + (between * reach) * level;
                        for axis in 0..3 {
                            gradient[axis] += w[k][axis] * term;
                        }
                    }
                    let scale = splat(scale);
                    (value * scale).store_slice(&mut answers[0][first..first + $lanes]);
                    for axis in 0..3 {
                        (gradient[axis] * scale).store_slice(&mut answers[1 + axis][first..first + $lanes]);
                    }
                }
                is_above
            }
        );
    };
}

#[cfg(target_arch = "x86_64")]
by_hand!(sums_f64, f64, f64x8, 8, ArcTangent::DOUBLE);

#[cfg(target_arch = "x86_64")]
by_hand!(sums_f32, f32, f32x16, 16, ArcTangent::SINGLE);

/// A bench of the sums, which are those of a batch but for the rounding of one factor.
#[cfg(target_arch = "x86_64")]
macro_rules! bench_by_hand {
    ($name:ident, $sums:ident, $number:ty, $pi:expr, $lattice:ident, $allowed:expr) => {
        #[divan::bench]
        fn $name(bencher: Bencher<'_, '_>) {
            let Some(avx512) = Level::new().as_avx512() else { return };
            let lattice = $lattice("easy");
            let [x, y, z, nx, ny, nz, _] = lattice.each_ref().map(Vec::as_slice);
            let corners = [[0.0, 0.0, 1.0], [0.5, 0.75, 1.0], [1.0, 0.0, 1.0]];
            let scale = -0.5 * 2.0 * 0.75 / $pi;
            let mut answered: [Vec<$number>; 4] = std::array::from_fn(|_| vec![0.0; COUNT]);
            let mut run = || $sums(avx512, black_box([x, y, z, nx, ny, nz]), black_box(corners), scale, &mut answered);
            assert!(run());
            bencher.counter(ItemsCount::new(COUNT)).bench_local(run);
            let mut answers = Answers::new();
            Engine::new().radiosity_and_gradient(&receivers(&lattice), &lamp(0.0), &mut answers).expect("finite");
            assert!(answered[0].iter().zip(&answers.radiosity).all(|(a, b)| (a - b).abs() <= $allowed * b));
        }
    };
}

#[cfg(target_arch = "x86_64")]
bench_by_hand!(by_hand_f64, sums_f64, f64, std::f64::consts::PI, double, 1e-14);
#[cfg(target_arch = "x86_64")]
bench_by_hand!(by_hand_f32, sums_f32, f32, std::f32::consts::PI, single, 1e-6);

/// Enough receivers for the threads to start.
#[divan::bench(args = [false, true])]
fn on_all_threads(bencher: Bencher<'_, '_>, threads: bool) {
    let engine = if threads { Engine::new().threads() } else { Engine::new() };
    let many = double("easy").map(|array| array.repeat(64));
    let (receivers, lamp, mut answers) = (receivers(&many), lamp(0.0), Answers::new());
    engine.radiosity_and_gradient(&receivers, &lamp, &mut answers).expect("finite");
    let run = || engine.radiosity_and_gradient(black_box(&receivers), &lamp, &mut answers).expect("finite");
    bencher.counter(ItemsCount::new(64 * COUNT)).bench_local(run);
}
