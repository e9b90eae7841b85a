//! The time of an enclosure, by digits and by regime. Anchor: a general rigorous integrator takes 0.4 to 11 s a point for 50
//! digits.

use divan::Bencher;
use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver};
use radgrad_oracle::enclose;

fn main() {
    divan::main();
}

fn case(position: [f64; 3], normal: [f64; 3], vertices: [[f64; 3]; 3], emission: Emission) -> (Receiver, Emitter) {
    let polygon = Polygon::new(vertices.map(DVec3::from).to_vec()).expect("a triangle");
    let receiver = Receiver::new(position.into(), normal.into(), 1.0).expect("a receiver");
    (receiver, Emitter::new(polygon, emission).expect("an emission"))
}

const TRIANGLE: [[f64; 3]; 3] = [[-1.0, -1.0, 1.5], [0.3, 1.1, 1.5], [1.2, -0.7, 1.5]];

fn run(bencher: Bencher<'_, '_>, (receiver, emitter): (Receiver, Emitter), digits: u32) {
    bencher.bench_local(|| enclose(divan::black_box(&receiver), divan::black_box(&emitter), digits));
}

#[divan::bench(args = [15, 20, 30, 50, 100], sample_count = 10)]
fn easy_constant(bencher: Bencher<'_, '_>, digits: u32) {
    run(bencher, case([0.0, 0.1, 0.0], [0.1, 0.2, 1.0], TRIANGLE, Emission::Constant(1.0)), digits);
}

#[divan::bench(args = [15, 20, 30, 50, 100], sample_count = 10)]
fn easy_linear(bencher: Bencher<'_, '_>, digits: u32) {
    run(bencher, case([0.0, 0.1, 0.0], [0.1, 0.2, 1.0], TRIANGLE, Emission::at_vertices(vec![1.0, 2.0, 4.0])), digits);
}

#[divan::bench(args = [1e-3, 1e-6, 1e-9, 1e-12], sample_count = 10)]
fn contact_20_digits(bencher: Bencher<'_, '_>, height: f64) {
    let low = TRIANGLE.map(|[x, y, _]| [x, y, height]);
    run(bencher, case([0.1, -0.1, 0.0], [0.3, 0.8, 0.5], low, Emission::at_vertices(vec![1.0, 2.0, 4.0])), 20);
}

#[divan::bench(args = [1e1, 1e4, 1e8], sample_count = 10)]
fn far_20_digits(bencher: Bencher<'_, '_>, distance: f64) {
    let far = TRIANGLE.map(|[x, y, _]| [x, y, distance]);
    run(bencher, case([0.0; 3], [0.2, 0.1, 1.0], far, Emission::Constant(1.0)), 20);
}

#[divan::bench(args = [1e-2, 1e-5, 1e-8], sample_count = 10)]
fn needle_20_digits(bencher: Bencher<'_, '_>, width: f64) {
    let needle = [[-1.0, -1.0, 1.5], [1.0, 1.0, 1.5], [1.0 + width, 1.0 - width, 1.5]];
    run(bencher, case([0.0; 3], [0.2, 0.1, 1.0], needle, Emission::Constant(1.0)), 20);
}

#[divan::bench(args = [1e-3, 1e-6, 1e-12], sample_count = 10)]
fn horizon_sliver_20_digits(bencher: Bencher<'_, '_>, width: f64) {
    run(bencher, case([0.0; 3], [0.0, 1.0, width - 1.1 / 1.5], TRIANGLE, Emission::Constant(1.0)), 20);
}
