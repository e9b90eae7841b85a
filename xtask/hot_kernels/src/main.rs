//! Fixed work for `cargo xtask instructions`, which runs this under callgrind and counts the instructions of [`measured`].
//!
//! A line on standard output for each kernel, in the order in which they are measured: its name and how many answers it gives. With a
//! number only those from there on, counted from 0.

use std::hint::black_box;
use std::sync::atomic::{AtomicUsize, Ordering};

use radgrad_core::batch::{Answers, Engine, Precision, Receivers};
use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, evaluate_to, radiosity, radiosity_and_gradient};

/// Receivers of a regime.
const COUNT: usize = 64;

/// Kernels that are left out before the next one that is measured.
static LEFT_OUT: AtomicUsize = AtomicUsize::new(0);

fn main() {
    LEFT_OUT.store(std::env::args().nth(1).and_then(|number| number.parse().ok()).unwrap_or(0), Ordering::Relaxed);
    let [constant, linear] = [Emission::Constant(2.0), Emission::at_vertices(vec![1.0, 2.0, 4.0])].map(lamp);
    let [easy, clipped, near, far] = ["easy", "clipped", "near", "far"].map(receivers);
    let plain = |receiver: &Receiver, lamp: &Emitter| radiosity_and_gradient(receiver, lamp).map_or(f64::NAN, |(value, _)| value);
    let to = |tolerance| {
        move |receiver: &Receiver, lamp: &Emitter| evaluate_to(receiver, lamp, &[], tolerance).map_or(f64::NAN, |a| a.radiosity)
    };
    let value = |receiver: &Receiver, lamp: &Emitter| radiosity(receiver, lamp).unwrap_or(f64::NAN);
    each("constant-value", &easy, &constant, value);
    each("constant", &easy, &constant, plain);
    each("constant-clipped", &clipped, &constant, plain);
    each("linear-value", &easy, &linear, value);
    each("linear", &easy, &linear, plain);
    each("linear-clipped", &clipped, &linear, plain);
    each("constant-to-1e-12", &easy, &constant, to(1e-12));
    each("constant-clipped-to-1e-12", &clipped, &constant, to(1e-12));
    each("constant-near-to-1e-12", &near, &constant, to(1e-12));
    each("constant-far-to-1e-12", &far, &constant, to(1e-12));
    each("linear-to-1e-12", &easy, &linear, to(1e-12));
    each("constant-to-1e-15", &easy, &constant, to(1e-15));
    let screens = screens();
    for (name, occluders) in [("one-occluder", vec![&screens[0]]), ("hundred-occluders", screens.iter().collect())] {
        let past = |receiver: &Receiver, lamp: &Emitter| {
            evaluate_to(receiver, lamp, occluders.iter().copied(), 1e-10).map_or(f64::NAN, |a| a.radiosity)
        };
        each(name, &easy[..16], &constant, past);
    }
    // Not AVX-512, which not every version of valgrind knows.
    for engine in Engine::all() {
        let name = engine.to_string().to_lowercase();
        if ["avx2", "sse2"].contains(&name.as_str()) {
            batch(&format!("batch-f64-{name}"), engine, &constant, |number| number);
            batch(&format!("batch-f32-{name}"), engine, &constant, single);
        }
    }
}

/// The function that callgrind counts, from each call to its return: not a jump, which would not be seen as one.
#[inline(never)]
fn measured(work: &mut dyn FnMut()) {
    work();
    black_box(());
}

/// Work done once for all, such as finding the instruction set, is not measured.
fn measure(name: &str, answers: usize, work: &mut dyn FnMut()) {
    if LEFT_OUT.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |count| count.checked_sub(1)).is_ok() {
        return;
    }
    work();
    println!("{name} {answers}");
    measured(work);
}

fn each(name: &str, receivers: &[Receiver], lamp: &Emitter, answer: impl Fn(&Receiver, &Emitter) -> f64) {
    let mut work = || _ = black_box(receivers.iter().map(|receiver| answer(black_box(receiver), lamp)).sum::<f64>());
    measure(name, receivers.len(), &mut work);
}

fn batch<F: Precision>(name: &str, engine: Engine, lamp: &Emitter, round: impl Fn(f64) -> F) {
    const BATCH: usize = 16 * COUNT;
    let numbers = |i: usize| {
        let ([x, y, z], [nx, ny, nz]) = place("easy", i % COUNT);
        [x, y, z, nx, ny, nz]
    };
    let [x, y, z, nx, ny, nz]: [Vec<F>; 6] =
        std::array::from_fn(|column| (0..BATCH).map(|i| round(numbers(i)[column])).collect());
    let reflectance = [round(0.75)];
    let Ok(receivers) = Receivers::new([&x, &y, &z], [&nx, &ny, &nz], &reflectance) else { return };
    let mut answers = Answers::new();
    let mut work = || _ = black_box(engine.radiosity_and_gradient(black_box(&receivers), lamp, &mut answers));
    measure(name, BATCH, &mut work);
}

#[allow(clippy::cast_possible_truncation, reason = "to the nearest is what is wanted")]
const fn single(number: f64) -> f32 {
    number as f32
}

fn lamp(emission: Emission) -> Emitter {
    let corners = [[0.0, 0.0, 1.0], [0.5, 0.75, 1.0], [1.0, 0.0, 1.0]].map(DVec3::from);
    Emitter::new(Polygon::new(corners.to_vec()).expect("a triangle"), emission).expect("finite values")
}

/// Triangles half-way to the lamp, the first of them large; no two edges are seen in line.
fn screens() -> Vec<Polygon> {
    let triangle = |i: usize| {
        let [x, y, z] = [0.618_034, 0.754_878, 0.569_84].map(|step| ((i + 1) as f64 * step).fract());
        let ([x, y], size) = if i == 0 { ([0.21, 0.13], 0.5) } else { ([x, y], 0.06) };
        let corners = [[x, y, 0.25 * z], [x + size, y + 0.25 * size, 0.3 * z], [x + 0.5 * size, y + size, 0.2 * z]];
        Polygon::new(corners.map(DVec3::from).to_vec()).expect("a triangle")
    };
    (0..100).map(triangle).collect()
}

fn receivers(regime: &str) -> Vec<Receiver> {
    let receiver = |i| {
        let (position, normal) = place(regime, i);
        Receiver::new(position.into(), normal.into(), 0.75).expect("a receiver")
    };
    (0..COUNT).map(receiver).collect()
}

/// Position and normal on a lattice.
fn place(regime: &str, i: usize) -> ([f64; 3], [f64; 3]) {
    let (x, y) = ((i % 8) as f64 * 0.125 + 0.0625, (i / 8) as f64 * 0.125 + 0.0625);
    match regime {
        "clipped" => ([x, y, 0.0], [1.0, 0.25, 0.125]),
        "near" => ([x, y, 1.0 - 0.0078125], [0.25, -0.125, 1.0]),
        "far" => ([x, y, -1024.0], [0.25, -0.125, 1.0]),
        _ => ([x, y, -0.5], [0.25, -0.125, 1.0]),
    }
}
