//! The blocks of the oracle and of factors.

use radgrad_oracle::cubature::{self, Form};
use radgrad_oracle::monte_carlo::{self, Sampling, Sequence};
use radgrad_oracle::{Arithmetic, Request, Source, SourceFunction, enclose_source_occluded};
use radgrad_scene::case::Problem;
use radgrad_scene::{FactorMatrix, FactorSettings, FormFactors, Scene};

use super::bits::Digest;
use crate::cases::family::Family;
use crate::checks::{exchanges, screens};
use crate::measures::seen::reduced;
use crate::scenes::family::Family as Scenes;

pub(super) fn of_enclosures(digest: &mut Digest, index: u64) {
    const FAMILIES: [Family; 10] = [
        Family::Generic,
        Family::Clipped,
        Family::NGon,
        Family::OneScreen,
        Family::SteepExtension,
        Family::PolynomialClipped,
        Family::Far,
        Family::Concave,
        Family::HorizonSliver,
        Family::EdgeScreen,
    ];
    let Ok(problem) = FAMILIES[usize::try_from(index).unwrap_or(0) % FAMILIES.len()].case(50, index).problem() else { return };
    let (emitter, occluders) = reduced(&problem);
    let asked = [
        (15, Arithmetic::DoubleDouble, 60_000),
        (18, Arithmetic::DoubleDouble, 60_000),
        (22, Arithmetic::Limbs, 12_000),
        (30, Arithmetic::Limbs, 12_000),
        (17, Arithmetic::Astro, 1_000),
    ];
    for (digits, arithmetic, budget) in asked {
        let request = Request { digits, arithmetic: Some(arithmetic), budget };
        match enclose_source_occluded(&problem.receiver, &Source::Emitter(&emitter), occluders, &request) {
            Ok(found) => {
                for interval in std::iter::once(&found.radiosity).chain(&found.gradient) {
                    digest.numbers(&[interval.to_f64(), interval.radius(), interval.bounds().0, interval.bounds().1]);
                }
                digest.numbers(&found.rounding);
                digest.word(found.evaluations);
            }
            Err(_) => digest.refused(),
        }
    }
}

pub(super) fn of_estimates(digest: &mut Digest, index: u64) {
    const FAMILIES: [Family; 10] = [
        Family::Generic,
        Family::Clipped,
        Family::NGon,
        Family::Contact,
        Family::NearEdge,
        Family::PolynomialClipped,
        Family::OneScreen,
        Family::Far,
        Family::Concave,
        Family::SteepExtension,
    ];
    let Ok(problem) = FAMILIES[usize::try_from(index).unwrap_or(0) % FAMILIES.len()].case(51, index).problem() else { return };
    let Problem { receiver, emitter, occluders, .. } = &problem;
    for form in [Form::Surface, Form::Contour, Form::Boundary] {
        let source = SourceFunction::Emitter(emitter);
        let integral = cubature::integrate_form(receiver, emitter.polygon(), source, form, 1e-6, 40_000);
        digest.say(integral.map(|of| {
            let numbers = [of.radiosity, of.radiosity_error, of.gradient_error, of.evaluations as f64];
            [&numbers[..], &of.gradient.to_array()].concat()
        }));
    }
    let sequences = [Sequence::Independent { samples: 300, seed: 5 }, Sequence::Sobol { samples: 32, scramblings: 8, seed: 5 }];
    for (sampling, sequence) in [Sampling::SolidAngle, Sampling::Area].into_iter().zip(sequences) {
        let estimate = monte_carlo::integrate(receiver, emitter, occluders, sampling, sequence, 0.99);
        digest.say(estimate.map(|of| {
            let limits = std::iter::once(of.radiosity).chain(of.gradient);
            limits.flat_map(|of| [of.mean, of.student.low, of.student.high, of.distribution_free.low]).collect()
        }));
    }
}

pub(super) fn of_exchanges(digest: &mut Digest, index: u64) {
    let mut say = |said: Result<Vec<(f64, f64)>, String>| {
        digest.say(said.map(|pairs| pairs.into_iter().flat_map(|(a, b)| [a, b]).collect()));
    };
    for k in 0..6 {
        say(exchanges::recorded(1000 + 6 * index + k));
        say(screens::recorded_shares(1000 + 6 * index + k));
    }
    say(screens::recorded(1000 + index));
    say(Ok(exchanges::recorded_edges(index)));
}

pub(super) fn of_factors(digest: &mut Digest, index: u64) -> Result<(), String> {
    const FAMILIES: [Scenes; 14] = [
        Scenes::Clutter,
        Scenes::Furnace,
        Scenes::Downlight,
        Scenes::Slit,
        Scenes::Pinhole,
        Scenes::Grating,
        Scenes::Touching,
        Scenes::TJunctions,
        Scenes::Open,
        Scenes::Groove,
        Scenes::Odd,
        Scenes::Rounded,
        Scenes::Nested,
        Scenes::Sphere,
    ];
    let family = FAMILIES[usize::try_from(index).unwrap_or(0) % FAMILIES.len()];
    let said = |error: radgrad_scene::Error| error.to_string();
    let scene: Scene = family.model(52, index).scene().map_err(said)?;
    let factors = FormFactors::new(&scene).map_err(said)?;
    let settings =
        FactorSettings { tolerance: 0.1, most_cells: 20, estimate: 1e-2, most_points: 60, ..FactorSettings::default() };
    let mut matrix = factors.matrix(&settings, || ()).map_err(said)?;
    let feed = |digest: &mut Digest, matrix: &FactorMatrix| {
        for (from, entry) in matrix.entries() {
            digest.word(from as u64 ^ (entry.face as u64) << 32 ^ (entry.occluders as u64) << 48);
            digest.numbers(&[entry.factor, entry.lower, entry.upper, entry.error, entry.modelling]);
        }
        let unmet = matrix.unmet(&settings).count();
        digest.numbers(&[matrix.worst_closure(), matrix.worst_reciprocity(), matrix.worst_bound(), unmet as f64]);
    };
    feed(digest, &matrix);
    let narrowing = factors.narrow(&mut matrix, &settings, 300).map_err(said)?;
    digest.numbers(&[narrowing.wanted, narrowing.spent as f64]);
    feed(digest, &matrix);
    if let Ok(repaired) = matrix.repair(&settings) {
        digest.number(repaired.closure);
        feed(digest, &matrix);
    }
    Ok(())
}
