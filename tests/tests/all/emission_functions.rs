//! Any emission by cubature: never converged and wrong, whatever it does between the points that are looked at.

use glam::DVec3;
use radgrad_audit::cases::sampler::Sampler;
use radgrad_core::{Emission, Emitter, Polynomial, Receiver, evaluate};
use radgrad_oracle::cubature::{Estimate, Status, integrate_function};
use radgrad_oracle::{EmissionFunction, Error};
use radgrad_tests::direct;
use radgrad_tests::patchwork::{Kind, Patchwork, receiver, square};

/// Heights of receivers as powers of two: about the size of the square, and in contact down to 1e-12.
const HEIGHTS: [(i64, i64); 2] = [(-3, 3), (-40, -3)];
const TOLERANCES: [f64; 3] = [1e-2, 1e-5, 1e-9];
const BUDGET: usize = 400_000;

/// Counts of cases by their outcome.
#[derive(Debug, Default, PartialEq, Eq)]
struct Tally {
    converged: usize,
    exhausted: usize,
    rounded: usize,
    contradictions: usize,
    /// The budget did not allow a first look at every detail, or a pole was hit.
    refused: usize,
    /// Converged, and off by more than the tolerance.
    silent: usize,
    /// Off by more than the stated error, whatever the status.
    underestimated: usize,
}

impl Tally {
    fn add(&mut self, estimate: Result<Estimate, Error>, truth: impl FnOnce() -> (f64, DVec3), tolerance: f64) {
        let estimate = match estimate {
            Err(Error::Evaluations { .. } | Error::NotFinite { .. }) => return self.refused += 1,
            estimate => estimate.unwrap(),
        };
        let (value, gradient) = truth();
        let (error, gradient_off) = ((estimate.radiosity - value).abs(), (estimate.gradient - gradient).length());
        let is_met = error <= tolerance * value.abs() && gradient_off <= tolerance * gradient.length();
        match estimate.status {
            Status::Converged => self.converged += 1,
            Status::BudgetExhausted => self.exhausted += 1,
            Status::RoundoffLimited => self.rounded += 1,
            Status::Contradiction => self.contradictions += 1,
        }
        self.silent += usize::from(estimate.status == Status::Converged && !is_met);
        // The truth itself is known to 1e-14 of its parts.
        let share = 1.0 + 1e-3;
        let is_under = error > estimate.radiosity_error * share || gradient_off > estimate.gradient_error * share;
        self.underestimated += usize::from(is_under && error.max(gradient_off) > 1e-12);
    }
}

fn tally(kind: Kind, count: u64, gradient: impl Fn(&Patchwork, DVec3) -> Option<DVec3>) -> Tally {
    let mut tally = Tally::default();
    for (low, high) in HEIGHTS {
        for index in 0..count {
            let sampler = &mut Sampler::new(7, "patchwork", index);
            let work = kind.patchwork(sampler);
            let receiver = receiver(sampler, low, high);
            let radiosity = |y| work.radiosity(y);
            let slope = |y| gradient(&work, y).unwrap_or(DVec3::NAN);
            let has_gradient = gradient(&work, DVec3::ZERO).is_some();
            let emission = EmissionFunction {
                radiosity: &radiosity,
                gradient: if has_gradient { Some(&slope) } else { None },
                detail: work.detail,
                bounds: None,
            };
            for tolerance in TOLERANCES {
                let truth = || {
                    let truth = work.truth(&receiver);
                    (truth.radiosity, truth.gradient)
                };
                tally.add(integrate_function(&receiver, &square(), &emission, tolerance, BUDGET), truth, tolerance);
            }
        }
    }
    println!("{kind:?}: {tally:?}");
    tally
}

#[test]
fn nothing_is_converged_and_wrong() {
    let mut cases = 0;
    for kind in Kind::ALL {
        let tally = tally(kind, 12, |work, y| work.is_continuous.then(|| work.gradient(y)));
        assert_eq!(tally.silent, 0, "{kind:?}: {tally:?}");
        // A cautious estimate, not a bound: of rough functions one may be short.
        assert!(tally.underestimated <= usize::from(kind != Kind::Smooth), "{kind:?}: {tally:?}");
        assert!(tally.converged >= if kind == Kind::Smooth { 60 } else { 10 }, "{kind:?}: {tally:?}");
        cases += 72 - tally.refused;
    }
    assert!(cases > 270, "{cases}");
}

#[test]
fn a_gradient_that_is_not_that_of_the_emission_is_seen() {
    for kind in Kind::ALL {
        let wrong: [fn(&Patchwork, DVec3) -> DVec3; 3] = [
            |work, y| work.gradient(y) * if work.is_continuous { 1.1 } else { 1.0 },
            |work, y| work.gradient(y) + DVec3::new(0.1, 0.2, 0.0),
            |_, _| DVec3::ZERO,
        ];
        for wrong in wrong {
            let tally = tally(kind, 5, |work, y| Some(wrong(work, y)));
            assert_eq!(tally.silent, 0, "{kind:?}: {tally:?}");
            assert!(tally.contradictions > 0, "{kind:?}: {tally:?}");
        }
    }
}

#[test]
fn a_polynomial_is_what_its_closed_form_says() {
    let mut runs = 0;
    for index in 0..30 {
        let sampler = &mut Sampler::new(11, "polynomial", index);
        let terms: Vec<(f64, [u8; 3])> =
            (0..8).map(|_| (sampler.between(-1.0, 1.0), [0; 3].map(|_| u8::try_from(sampler.below(4)).unwrap()))).collect();
        let polynomial = Polynomial::new(DVec3::new(0.5, 0.5, -0.5), [(4.0, [0; 3])].into_iter().chain(terms)).unwrap();
        let receiver = receiver(sampler, -6, 3);
        let exact = evaluate(&receiver, &Emitter::new(square(), Emission::Polynomial(polynomial.clone())).unwrap(), &[]).unwrap();
        let emission = EmissionFunction {
            radiosity: &|y| polynomial.value_at(y),
            gradient: Some(&|y| polynomial.gradient_at(y)),
            detail: f64::INFINITY,
            bounds: None,
        };
        for tolerance in [1e-3, 1e-6, 1e-10] {
            let estimate = integrate_function(&receiver, &square(), &emission, tolerance, 1_000_000).unwrap();
            assert_eq!(estimate.status, Status::Converged, "{index} to {tolerance:e}: {estimate:?}");
            let (value, gradient) = ((estimate.radiosity - exact.radiosity).abs(), (estimate.gradient - exact.gradient).length());
            assert!(value <= tolerance * exact.radiosity.abs(), "{index}: {estimate:?} for {exact:?}");
            assert!(gradient <= tolerance * exact.gradient.length(), "{index}: {estimate:?} for {exact:?}");
            assert!(
                value <= estimate.radiosity_error && gradient <= estimate.gradient_error,
                "{index}: {estimate:?} for {exact:?}"
            );
            runs += 1;
        }
    }
    assert_eq!(runs, 90);
}

/// Radiosity and gradient of an emission with a peak at `peak`, from heights about the size of the square: four triangles with a
/// corner there, on which powers of the distance become smooth.
fn around_peak(receiver: &Receiver, peak: DVec3, emission: impl Fn(f64) -> f64) -> (f64, DVec3) {
    let (rule, corners) = (direct::gauss_legendre(60), square().vertices().to_vec());
    let mut sum = (0.0, DVec3::ZERO);
    for i in 0..4 {
        let (a, b) = (corners[i] - peak, corners[(i + 1) % 4] - peak);
        let twice_area = a.cross(b).z;
        for &(t, weight_t) in &rule {
            for &(v, weight_v) in &rule {
                let u = t * t * t * t;
                let from_peak = u * (a + v * (b - a));
                let r = peak + from_peak - receiver.position();
                let (s, h, rr) = (receiver.normal().dot(r), receiver.position().z, r.length_squared());
                let weight = weight_t * weight_v * 4.0 * t * t * t * u * twice_area * emission(from_peak.length()) / (rr * rr);
                sum.0 += weight * s * h;
                sum.1 += weight * (DVec3::Z * s - receiver.normal() * h + r * (4.0 * s * h / rr));
            }
        }
    }
    let factor = receiver.reflectance() / std::f64::consts::PI;
    (factor * sum.0, factor * sum.1)
}

#[test]
fn a_peak_without_end_is_resolved_or_said_to_be_out_of_reach() {
    let powers: [(&str, &dyn Fn(f64) -> f64); 4] = [
        ("root", &|d| 1.0 / d.sqrt()),
        ("logarithm", &|d| 1.0 - libm::log(d)),
        ("inverse", &|d| 1.0 / d),
        ("steep", &|d| 1.0 / (d * d.sqrt())),
    ];
    for (name, emission) in powers {
        let mut tally = Tally::default();
        for index in 0..20 {
            let sampler = &mut Sampler::new(13, "peak", index);
            let peak = DVec3::new(sampler.between(0.2, 0.8), sampler.between(0.2, 0.8), 0.0);
            let position = DVec3::new(sampler.between(-0.5, 1.5), sampler.between(-0.5, 1.5), sampler.between(0.7, 2.0));
            // Facing down, so that all of the square is in view.
            let receiver = Receiver::new(position, DVec3::NEG_Z, 0.8).unwrap();
            let radiosity = |y: DVec3| emission(y.distance(peak));
            let function = EmissionFunction { radiosity: &radiosity, gradient: None, detail: 0.2, bounds: None };
            for tolerance in TOLERANCES {
                let estimate = integrate_function(&receiver, &square(), &function, tolerance, BUDGET);
                tally.add(estimate, || around_peak(&receiver, peak, emission), tolerance);
            }
        }
        println!("{name}: {tally:?}");
        assert_eq!((tally.silent, tally.underestimated), (0, 0), "{name}: {tally:?}");
        assert!(tally.converged >= 15 && tally.refused <= 20, "{name}: {tally:?}");
    }
}

#[test]
fn a_pole_that_is_hit_is_an_error() {
    let receiver = Receiver::new(DVec3::new(0.4, 0.3, 0.7), DVec3::NEG_Z, 1.0).unwrap();
    let function = EmissionFunction { radiosity: &|y| 1.0 / (y.x - y.x), gradient: None, detail: 1.0, bounds: None };
    let error = integrate_function(&receiver, &square(), &function, 1e-3, BUDGET).unwrap_err();
    assert!(matches!(error, Error::NotFinite { .. }), "{error}");
}

#[test]
fn in_contact_a_spot_fills_the_view_with_what_it_emits_there() {
    let spot = |y: DVec3| libm::exp(-(y - DVec3::new(0.5, 0.5, 0.0)).length_squared() / 0.08);
    let slope = |y: DVec3| (y - DVec3::new(0.5, 0.5, 0.0)) * (-2.0 / 0.08) * spot(y);
    let function = EmissionFunction { radiosity: &spot, gradient: Some(&slope), detail: 0.2, bounds: None };
    for height in [1e-4, 1e-8, 1e-12] {
        let foot = DVec3::new(0.6, 0.45, 0.0);
        let receiver = Receiver::new(foot.with_z(height), DVec3::NEG_Z, 1.0).unwrap();
        let estimate = integrate_function(&receiver, &square(), &function, 1e-8, 4_000_000).unwrap();
        // The difference is the change of the spot over distances of the height, with its logarithm.
        let error = (estimate.radiosity - spot(foot)).abs();
        assert!(estimate.status == Status::Converged && estimate.radiosity_error <= 1e-8, "{height:e}: {estimate:?}");
        assert!(error <= 40.0 * height * -libm::log(height) + 1e-8, "{height:e}: off by {error:e}, {estimate:?}");
        // Along the plane the radiosity follows the emission.
        let along = (estimate.gradient - slope(foot)).truncate().length();
        assert!(along <= 400.0 * height * -libm::log(height) + 1e-7, "{height:e}: off by {along:e}, {estimate:?}");
    }
}
