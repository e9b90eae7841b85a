//! Functions of single precision on every number that there is: angles and square roots of lanes.
//!
//! `cargo run --release -p radgrad-numbers --example all_of_single -- 1` takes all 2^32 of them, some minutes; for a larger number it
//! takes one in so many. `docs/guide/trust.md` records the errors of all. Angles are those of (y, 1), (y, -1) and (1, y), which
//! are all quotients but for their rounding, against `arc_tangent::atan2` of doubles, whose error Gappa proves to be below 3.91 of its own
//! roundings. Where the quotient of the smaller by the larger coordinate is no normal number an error is in units of the smallest number.
//! Every instruction set of the machine is asked.
//!
//! One in 4097, unless told:
//!
//! ```text
//! 1044225 numbers of single precision, one in 4097
//! 3132675 angles: the largest error 1.427 ulp; where the quotient is not normal 0.500
//! 522113 square roots: 0 not the nearest number
//! 0 results that differ between instruction sets
//! ```

use std::thread;

use fearless_simd::{Level, Simd};
use radgrad_numbers::arc_tangent::atan2;
use radgrad_numbers::lanes::angle::{ANGLE_ULP, angle};
use radgrad_numbers::lanes::instruction_set::instruction_sets;
use radgrad_numbers::lanes::lane::Lanes;
use radgrad_numbers::on_instruction_set;

/// Numbers that are taken together.
const TILE: usize = 1 << 12;

/// Numbers that there are.
const ALL: u64 = 1 << 32;

/// Errors and counts over some numbers.
#[derive(Clone, Copy, Default)]
struct Tally {
    numbers: u64,
    angles: u64,
    /// Largest errors of angles, in units in the last place where the quotient is normal, and where not.
    worst: [f64; 2],
    roots: u64,
    /// Square roots that are not the nearest number.
    wrong_roots: u64,
    /// Results that are not those of the best instruction set.
    differ: u64,
}

/// The larger, and no number where one is none.
fn larger(a: f64, b: f64) -> f64 {
    if a >= b || a.is_nan() { a } else { b }
}

impl Tally {
    fn with(self, other: Self) -> Self {
        Self {
            numbers: self.numbers + other.numbers,
            angles: self.angles + other.angles,
            worst: [0, 1].map(|k| larger(self.worst[k], other.worst[k])),
            roots: self.roots + other.roots,
            wrong_roots: self.wrong_roots + other.wrong_roots,
            differ: self.differ + other.differ,
        }
    }
}

#[inline(always)]
fn angles_and_roots<S: Simd>(simd: S, y: &[f32], x: &[f32], angles: &mut [f32], roots: &mut [f32]) {
    let width = Lanes::<S, f32>::COUNT;
    for (k, (y, x)) in y.chunks_exact(width).zip(x.chunks_exact(width)).enumerate() {
        let (y, x) = (Lanes::load(simd, y), Lanes::load(simd, x));
        angle(simd, y, x).store(&mut angles[k * width..]);
        y.sqrt().store(&mut roots[k * width..]);
    }
}

fn on(level: Level, y: &[f32], x: &[f32]) -> [Vec<f32>; 2] {
    let (mut angles, mut roots) = (vec![0.0; TILE], vec![0.0; TILE]);
    on_instruction_set!(level, simd => angles_and_roots(simd, y, x, &mut angles, &mut roots));
    [angles, roots]
}

/// Error of an angle in units in the last place, and whether the quotient is no normal number.
fn error(angle: f32, y: f32, x: f32) -> (f64, bool) {
    let truth = atan2(f64::from(y), f64::from(x));
    let quotient = f64::from(y.abs().min(x.abs())) / f64::from(y.abs().max(x.abs()));
    let is_small = quotient < f64::from(f32::MIN_POSITIVE);
    let unit = angle.abs().next_up() - angle.abs();
    ((f64::from(angle) - truth).abs() / f64::from(unit), is_small)
}

fn tile(numbers: &[f32]) -> Tally {
    let mut tally = Tally { numbers: numbers.len() as u64, ..Tally::default() };
    // Filled up, and not counted there.
    let mut filled = numbers.to_vec();
    filled.resize(TILE, 1.0);
    let ones = [1.0, -1.0].map(|one| vec![one; TILE]);
    for (case, (y, x)) in [(&filled, &ones[0]), (&filled, &ones[1]), (&ones[0], &filled)].into_iter().enumerate() {
        let sets: Vec<[Vec<f32>; 2]> = instruction_sets().into_iter().map(|level| on(level, y, x)).collect();
        let [angles, roots] = &sets[0];
        for k in 0..numbers.len() {
            let bits = |set: &[Vec<f32>; 2]| [set[0][k].to_bits(), set[1][k].to_bits()];
            // No numbers, the roots of negative ones, may differ in their bits.
            let differs = |set: &[Vec<f32>; 2]| bits(set) != bits(&sets[0]) && !(set[1][k].is_nan() && roots[k].is_nan());
            tally.differ += u64::from(sets.iter().any(differs));
            let (error_in_units, is_small) = error(angles[k], y[k], x[k]);
            tally.angles += 1;
            let worst = &mut tally.worst[usize::from(is_small)];
            *worst = larger(error_in_units, *worst);
            if case == 0 && y[k] >= 0.0 {
                // Rounded twice, and as if once: a double has more than twice as many bits and two.
                #[allow(clippy::cast_possible_truncation, reason = "to the nearest is what it is for")]
                let nearest = f64::from(y[k]).sqrt() as f32;
                tally.roots += 1;
                tally.wrong_roots += u64::from(nearest.to_bits() != roots[k].to_bits());
            }
        }
    }
    tally
}

/// Every so many-th number, in the tiles of one worker of so many.
fn of_worker(step: u64, worker: u64, workers: u64) -> Tally {
    let width = step * TILE as u64;
    let mut tally = Tally::default();
    for start in (0..).map(|round| (worker + round * workers) * width).take_while(|start| *start < ALL) {
        let bits = (0..TILE as u64).map(|k| start + k * step).filter(|bits| *bits < ALL);
        let numbers: Vec<f32> = bits.filter_map(|bits| u32::try_from(bits).ok()).map(f32::from_bits).collect();
        let numbers: Vec<f32> = numbers.into_iter().filter(|number| !number.is_nan()).collect();
        tally = tally.with(tile(&numbers));
    }
    tally
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let step: u64 = std::env::args().nth(1).map_or(Ok(4097), |text| text.parse())?;
    if !(1..1 << 30).contains(&step) {
        return Err(format!("one in {step}: it must be between 1 and 2^30").into());
    }
    let workers = thread::available_parallelism()?.get() as u64;
    let tallies: Vec<Tally> = thread::scope(|scope| {
        let running: Vec<_> = (0..workers).map(|worker| scope.spawn(move || of_worker(step, worker, workers))).collect();
        running.into_iter().map(|thread| thread.join().map_err(|_| "a worker has panicked")).collect::<Result<_, _>>()
    })?;
    let Tally { numbers, angles, worst, roots, wrong_roots, differ } = tallies.into_iter().fold(Tally::default(), Tally::with);
    println!("{numbers} numbers of single precision, one in {step}");
    println!("{angles} angles: the largest error {:.3} ulp; where the quotient is not normal {:.3}", worst[0], worst[1]);
    println!("{roots} square roots: {wrong_roots} not the nearest number");
    println!("{differ} results that differ between instruction sets");
    let is_held = worst.iter().all(|worst| *worst <= ANGLE_ULP) && wrong_roots == 0 && differ == 0;
    if is_held { Ok(()) } else { Err(format!("more than {ANGLE_ULP} ulp, or another digit").into()) }
}
