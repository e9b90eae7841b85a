//! Ratios of batches: on the best instruction set of the machine, one thread unless said otherwise.

use std::error::Error;
use std::hint::black_box;

use radgrad_core::batch::{Answers, EmitterTree, Emitters, Engine};
use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, evaluate_to, radiosity_and_gradient};

use super::pair::{Ratio, pair, pair_of_long};
use super::varied;
use crate::bench::clock::Spread;
use crate::bench::lambert::bare_radiosity_and_gradient;
use crate::bench::lanes::Columns;
use crate::bench::regime::{Case, Kind, single};

/// Receivers of a batch: many times a vector's lanes, and few enough for a cache.
pub(super) const BATCH: usize = 1024;
/// And enough for two threads to share.
const SHARED: usize = 262_144;

/// Speed of a batch in double precision over the bare scalar sums, of one in single precision over that, and of two threads over one:
/// value and gradient at many receivers due to one triangle.
pub(crate) fn speedups() -> Result<Vec<Ratio>, Box<dyn Error>> {
    let cases = one_emitter(Kind::Constant)?;
    let emitter = &cases[0].emitter;
    let (double, single) = (Columns::repeat(&cases, BATCH, |number| number), Columns::repeat(&cases, BATCH, single));
    let many = Columns::repeat(&cases, SHARED, |number| number);
    let (double, single, many) = (double.receivers()?, single.receivers()?, many.receivers()?);
    let (mut answers, mut fewer_digits, mut shared) = (Answers::new(), Answers::<f32>::new(), Answers::new());
    let engine = Engine::new();
    engine.radiosity_and_gradient(&double, emitter, &mut answers)?;
    engine.radiosity_and_gradient(&single, emitter, &mut fewer_digits)?;
    engine.radiosity_and_gradient(&many, emitter, &mut shared)?;
    let two = rayon::ThreadPoolBuilder::new().num_threads(2).build()?;

    let bare = |case: &Case| black_box(bare_radiosity_and_gradient(black_box(case))).0;
    // Both sides answer as many receivers.
    let scalar = || _ = black_box((0..BATCH / cases.len()).map(|_| cases.iter().map(bare).sum::<f64>()).sum::<f64>());
    let mut in_double = || answered(engine.radiosity_and_gradient(black_box(&double), emitter, &mut answers));
    let mut in_single = || answered(engine.radiosity_and_gradient(black_box(&single), emitter, &mut fewer_digits));
    let mut one_thread = shared.clone();
    let mut ratios =
        vec![pair("batch_f64_speedup", scalar, &mut in_double), pair("batch_f32_over_f64", &mut in_double, &mut in_single)];
    let cores = two.install(two_cores);
    if cores.spread.median >= FREE {
        ratios.push(two.install(|| {
            pair_of_long(
                "threads_2_speedup",
                || answered(engine.radiosity_and_gradient(black_box(&many), emitter, &mut one_thread)),
                || answered(engine.threads().radiosity_and_gradient(black_box(&many), emitter, &mut shared)),
            )
        }));
    } else {
        println!(
            "SKIPPED threads_2_speedup: two threads do {:.2} times what one does where nothing is shared, so that there is no second core free",
            cores.spread.median
        );
    }
    Ok(ratios)
}

/// Least speed of two threads over one of additions alone, where two cores are free.
const FREE: f64 = 1.9;

/// The speed of two threads over one, of additions that each waits for.
fn two_cores() -> Ratio {
    let additions = || _ = black_box((0..ADDITIONS).fold(black_box(0.5), |sum: f64, _| sum + black_box(1e-9)));
    let in_turn = || {
        additions();
        additions();
    };
    pair_of_long("two_cores", in_turn, || _ = rayon::join(additions, additions))
}

/// Some milliseconds of them.
const ADDITIONS: u32 = 2_000_000;

/// Speed of a batch over one receiver after the other, value and gradient due to one linear triangle: plain, and with bounds to 1e-8.
pub(crate) fn linear_speedups() -> Result<Vec<Ratio>, Box<dyn Error>> {
    let cases = one_emitter(Kind::Linear)?;
    let emitter = &cases[0].emitter;
    let columns = Columns::repeat(&cases, BATCH, |number| number);
    let (receivers, engine) = (columns.receivers()?, Engine::new());
    let (mut plain, mut bounded) = (Answers::new(), Answers::new());
    engine.radiosity_and_gradient(&receivers, emitter, &mut plain)?;
    engine.evaluate_to(&receivers, emitter, CERTIFIED, &mut bounded)?;
    let in_turn = |one: &dyn Fn(&Case) -> f64| _ = black_box(cases.iter().map(|case| one(black_box(case))).sum::<f64>());
    let both = |case: &Case| radiosity_and_gradient(&case.receiver, &case.emitter).map_or(f64::NAN, |(value, _)| value);
    let certified = |case: &Case| evaluate_to(&case.receiver, &case.emitter, &[], CERTIFIED).map_or(f64::NAN, |a| a.radiosity);
    let ratios = [
        pair(
            "batch_linear_speedup",
            || in_turn(&both),
            || answered(engine.radiosity_and_gradient(black_box(&receivers), emitter, &mut plain)),
        ),
        pair(
            "batch_linear_certified_speedup",
            || in_turn(&certified),
            || answered(engine.evaluate_to(black_box(&receivers), emitter, CERTIFIED, &mut bounded)),
        ),
    ];
    // A batch answers its receivers many times over.
    let per_answer = |Ratio { name, spread }| Ratio { name, spread: spread.scaled(BATCH as f64 / cases.len() as f64) };
    Ok(ratios.map(per_answer).into())
}

/// A tolerance that the first bound of either side meets.
const CERTIFIED: f64 = 1e-8;

/// The receivers of the varied cases, over one triangle.
fn one_emitter(kind: Kind) -> Result<Vec<Case>, radgrad_core::Error> {
    let corners = [[-0.5, -0.5, 1.5], [0.0, 0.75, 1.5], [0.5, -0.25, 1.5]].map(DVec3::from);
    let emitter = Emitter::new(Polygon::new(corners.to_vec())?, kind.emission())?;
    Ok(varied::cases(kind)?.into_iter().map(|case| Case { emitter: emitter.clone(), ..case }).collect())
}

/// The same receivers were answered before anything is timed, so that there is no failure to be fast.
fn answered(result: Result<(), radgrad_core::Error>) {
    black_box(result.is_ok());
}

/// Quadrilaterals along a wall's side, on six walls: 101,400 emitters.
const CELLS: u32 = 130;
const RECEIVERS: u32 = 1000;
/// Receivers whose sum is compared with that of all emitters one by one.
const COMPARED: usize = 8;
/// Absolute tolerance over the mean total.
const TOLERANCE: f64 = 1e-6;

/// The cost of a point of a far field over that of a closed form. With it the ratio is that of the times too, 22 where it is 21.
const FAR_NODE: f64 = 0.1;

/// How many fewer evaluations of the closed form, or their worth, the tree over emitters takes than all pairs: receivers in a lit
/// room of 5 by 4 by 3.
pub(crate) fn many_emitters() -> Result<Ratio, Box<dyn Error>> {
    let lamps = room()?;
    let (tree, emitters) = (EmitterTree::new(&lamps), Emitters::<f64>::new(&lamps));
    let columns = Columns::repeat(&receivers()?, RECEIVERS as usize, |number| number);
    let (receivers, mut answers) = (columns.receivers()?, Answers::new());
    let engine = Engine::new();
    let truths = one_by_one(&emitters)?;
    let tolerance = TOLERANCE * truths.iter().sum::<f64>() / truths.len() as f64;
    let tally = engine.total(&receivers, &tree, tolerance, &mut answers)?;
    for (index, truth) in truths.iter().enumerate() {
        let (value, bound) = (answers.radiosity[index], answers.radiosity_error[index]);
        // The sum one by one has the rounding of doubles itself.
        if bound > tolerance || (value - truth).abs() > bound + 1e-12 * truth {
            return Err(format!("receiver {index}: {value} +- {bound:e} of {tolerance:e}, one by one {truth}").into());
        }
    }
    let pairs = lamps.len() as f64 * f64::from(RECEIVERS);
    let evaluations = tally.alone as f64 + FAR_NODE * tally.far_nodes as f64;
    Ok(Ratio { name: "many_emitters_saving", spread: Spread::quartiles(vec![pairs / evaluations]) })
}

fn room() -> Result<Vec<Emitter>, radgrad_core::Error> {
    let (x, y, z) = (DVec3::X * 5.0, DVec3::Y * 4.0, DVec3::Z * 3.0);
    let walls = [(DVec3::ZERO, x, y), (z, y, x), (DVec3::ZERO, y, z), (x, z, y), (DVec3::ZERO, z, x), (y, x, z)];
    let cells = walls.into_iter().flat_map(|wall| (0..CELLS * CELLS).map(move |cell| (wall, cell)));
    let lamp = |((corner, a, b), cell): ((DVec3, DVec3, DVec3), u32)| {
        let corner = |i: u32, j: u32| corner + (a * f64::from(i) + b * f64::from(j)) / f64::from(CELLS);
        let (i, j) = (cell % CELLS, cell / CELLS);
        let polygon = Polygon::new(vec![corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)])?;
        Emitter::new(polygon, Emission::Constant(0.1 + varied::between_0_and_1(cell, 0)))
    };
    cells.map(lamp).collect()
}

/// In the room, each facing its own way.
fn receivers() -> Result<Vec<Case>, radgrad_core::Error> {
    let emitter = one_emitter(Kind::Constant)?.swap_remove(0).emitter;
    let number = varied::between_0_and_1;
    let receiver = |i: u32| {
        let position = DVec3::new(5.0 * number(i, 0), 4.0 * number(i, 1), 3.0 * number(i, 2));
        let normal = DVec3::new(number(i, 3), number(i, 4), number(i, 5)) - 0.5;
        Ok(Case { receiver: Receiver::new(position, normal, 0.5)?, emitter: emitter.clone() })
    };
    (0..RECEIVERS).map(receiver).collect()
}

fn one_by_one(emitters: &Emitters<'_>) -> Result<Vec<f64>, radgrad_core::Error> {
    let mut each = Answers::new();
    let sum = |case: &Case| {
        Engine::new().each_to(&case.receiver, emitters, 1e-10, &mut each)?;
        Ok(each.radiosity.iter().sum())
    };
    receivers()?[..COMPARED].iter().map(sum).collect()
}
