//! Cost of an answer: by requested quantities, by tolerance, by regime. Times are per answer, each over the same hundred receivers.

use divan::{Bencher, black_box, counter::ItemsCount};
use radgrad_core::{
    DVec3, Emission, Emitter, Polygon, Receiver, derivatives, evaluate_to, gradient, radiosity, radiosity_and_gradient,
};

fn main() {
    divan::main();
}

/// A triangle about as wide as it is far in the easy regime.
fn lamp(emission: &str) -> Emitter {
    let corners = [[0.0, 0.0, 1.0], [0.5, 0.8, 1.0], [1.0, 0.0, 1.0]].map(DVec3::from);
    let emission = match emission {
        "constant" => Emission::Constant(2.0),
        _ => Emission::at_vertices(vec![1.0, 2.0, 4.0]),
    };
    Emitter::new(Polygon::new(corners.to_vec()).expect("a triangle"), emission).expect("finite values")
}

/// A hundred receivers of a regime, on a lattice.
fn receivers(regime: &str) -> Vec<Receiver> {
    let places = (0..100).map(|i| (f64::from(i % 10) * 0.1, f64::from(i / 10) * 0.1));
    let receiver = |position: DVec3, normal: DVec3| Receiver::new(position, normal, 0.8).expect("a receiver");
    let tilted = DVec3::new(0.2, -0.1, 1.0);
    places
        .map(|(x, y)| match regime {
            "easy" => receiver(DVec3::new(x, y, -0.5), tilted),
            "clipped" => receiver(DVec3::new(x, y, 0.0), DVec3::new(1.0, 0.3, 0.1)),
            "near 1e-2" => receiver(DVec3::new(x, y, 0.99), tilted),
            "near 1e-5" => receiver(DVec3::new(x, y, 1.0 - 1e-5), tilted),
            "grazing" => receiver(DVec3::new(x + 2.0, y, 1.0 - 1e-6), DVec3::new(-1.0, 0.1, 0.3)),
            _ => receiver(DVec3::new(x, y, -1e3), tilted),
        })
        .collect()
}

fn each(bencher: Bencher<'_, '_>, regime: &str, emission: &str, answer: impl Fn(&Receiver, &Emitter) -> f64 + Sync) {
    let (lamp, receivers) = (lamp(emission), receivers(regime));
    let sum = || receivers.iter().map(|receiver| answer(black_box(receiver), &lamp)).sum::<f64>();
    bencher.counter(ItemsCount::new(receivers.len())).bench(sum);
}

const EMISSIONS: [&str; 2] = ["constant", "linear"];
const REGIMES: [&str; 6] = ["easy", "clipped", "near 1e-2", "near 1e-5", "grazing", "far 1e3"];

#[divan::bench(args = EMISSIONS)]
fn value_alone(bencher: Bencher<'_, '_>, emission: &str) {
    each(bencher, "easy", emission, |receiver, lamp| radiosity(receiver, lamp).expect("finite"));
}

#[divan::bench(args = EMISSIONS)]
fn gradient_alone(bencher: Bencher<'_, '_>, emission: &str) {
    each(bencher, "easy", emission, |receiver, lamp| gradient(receiver, lamp).expect("finite").x);
}

#[divan::bench(args = EMISSIONS)]
fn value_and_gradient(bencher: Bencher<'_, '_>, emission: &str) {
    each(bencher, "easy", emission, |receiver, lamp| radiosity_and_gradient(receiver, lamp).expect("finite").0);
}

#[divan::bench(args = REGIMES, consts = [12, 15])]
fn certified_constant<const DIGITS: i32>(bencher: Bencher<'_, '_>, regime: &str) {
    certified(bencher, regime, "constant", DIGITS);
}

#[divan::bench(args = REGIMES, consts = [12, 15])]
fn certified_linear<const DIGITS: i32>(bencher: Bencher<'_, '_>, regime: &str) {
    certified(bencher, regime, "linear", DIGITS);
}

#[divan::bench(args = EMISSIONS)]
fn all_derivatives(bencher: Bencher<'_, '_>, emission: &str) {
    each(bencher, "easy", emission, |receiver, lamp| derivatives(receiver, lamp, &[], 1e-12).expect("finite").radiosity.value);
}

fn certified(bencher: Bencher<'_, '_>, regime: &str, emission: &str, digits: i32) {
    let tolerance = 10f64.powi(-digits);
    each(bencher, regime, emission, |receiver, lamp| evaluate_to(receiver, lamp, &[], tolerance).expect("finite").radiosity);
}
