//! Cost of a batch for each receiver or emitter: by instruction set, precision, quantities asked for, and regime. `scalar` is the
//! scalar path on the same receivers.

use divan::{Bencher, black_box, counter::ItemsCount};
use radgrad_core::batch::{Answers, Emitters, Engine, Precision, Receivers};
use radgrad_core::{DVec3, Emission, Emitter, Error, Polygon, Receiver, radiosity_and_gradient};

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
