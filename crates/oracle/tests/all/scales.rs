//! Answers and bounds of core with occluders of any size, and with walls on the receiver's floor, against enclosures.

use radgrad_core::{Answer, DVec3, Emission, Emitter, Polygon, Receiver, evaluate, evaluate_digits};
use radgrad_oracle::{Enclosure, enclose, enclose_occluded};
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

fn cases(usual: usize) -> usize {
    std::env::var("RADGRAD_SCALES_CASES").map_or(usual, |count| count.parse().unwrap())
}

fn lamp(vertices: [[f64; 3]; 3]) -> Result<Emitter, radgrad_core::Error> {
    Emitter::new(Polygon::new(vertices.map(DVec3::from).to_vec())?, Emission::Constant(1.0))
}

/// Whether a value and its gradient hold the truth within their bounds.
fn holds(answer: &Answer, truth: &Enclosure) -> bool {
    let errors = [0, 1, 2].map(|axis| truth.gradient[axis].error_of(answer.gradient[axis]));
    truth.radiosity.error_of(answer.radiosity) <= answer.radiosity_error
        && DVec3::from(errors).length() <= answer.gradient_error * (1.0 + 1e-12)
}

#[test]
fn occluders_with_coordinates_of_all_sizes_are_answered() {
    let mut random = ChaCha8Rng::seed_from_u64(4);
    let (mut shaded, count) = (0, cases(60));
    for case in 0..count {
        let mut coordinate = || {
            let size = if random.random_range(0..3) == 0 { 2f64.powi(random.random_range(-660..660)) } else { 1.0 };
            random.random_range(-1.0..1.0) * size
        };
        let mut corner = || DVec3::new(coordinate(), coordinate(), coordinate().abs());
        let Ok(screen) = Polygon::new(vec![corner(), corner(), corner()]) else { continue };
        let lamp = lamp([[-1.0, -1.0, 2.0], [-0.9, 1.0, 2.1], [1.0, 0.25, 2.2]]).unwrap();
        let receiver = Receiver::new(DVec3::ZERO, DVec3::new(0.3, -0.2, 1.0), 1.0).unwrap();
        let free = evaluate(&receiver, &lamp, []).unwrap();
        let Ok(answer) = evaluate(&receiver, &lamp, [&screen]) else { continue };
        let truth = enclose_occluded(&receiver, &lamp, std::slice::from_ref(&screen), 22).unwrap();
        assert!(holds(&answer, &truth), "case {case}: {answer:?}, {truth:?}, {screen:?}");
        assert!(answer.radiosity_error <= 1e-9, "case {case}: {answer:?}, {screen:?}");
        shaded += usize::from(answer.radiosity < 0.999 * free.radiosity);
    }
    assert!(shaded * 10 > count, "{shaded} of {count}");
}

#[test]
fn walls_on_the_floor_of_the_receiver_are_answered() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let (mut tried, count) = (0, cases(40));
    for case in 0..count {
        let mut tenth = |low: i32, high: i32| f64::from(random.random_range(low..=high)) * 0.1;
        let vertices = [(); 3].map(|()| [tenth(-40, 40), tenth(-40, 40), tenth(-15, 45)]);
        let ends = [[tenth(-10, 10), tenth(-10, 10)], [tenth(-10, 10), tenth(-10, 10)]];
        let height = tenth(1, 6);
        let [p, q] = ends.map(|[x, y]| DVec3::new(x, y, 0.0));
        let up = DVec3::Z * height;
        let Ok(wall) = Polygon::new(vec![p, q, q + up, p + up]) else { continue };
        let Ok(lamp) = lamp(vertices) else { continue };
        let receiver = Receiver::new(DVec3::ZERO, DVec3::Z, 1.0).unwrap();
        let truth = enclose_occluded(&receiver, &lamp, std::slice::from_ref(&wall), 22).unwrap();
        let digits = evaluate_digits(&receiver, &lamp, [&wall], 50).unwrap_or_else(|error| panic!("case {case}: {error}"));
        let radiosity: f64 = digits.radiosity.parse().unwrap();
        assert!(truth.radiosity.error_of(radiosity) <= 2e-16 * radiosity, "case {case}: {digits:?}, {truth:?}");
        assert!(holds(&evaluate(&receiver, &lamp, [&wall]).unwrap(), &truth), "case {case}: {truth:?}");
        tried += usize::from(radiosity > 0.0);
    }
    assert!(tried * 4 > count, "{tried} of {count}");
}

/// The truth takes the normal as given, in arithmetic of its own.
#[test]
fn components_of_a_normal_far_below_the_largest_count() {
    let wall = [[1.0, -1.0, -1.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, -1.0]].map(DVec3::from);
    let emitter = Emitter::new(Polygon::new(wall.to_vec()).unwrap(), Emission::Constant(1e307)).unwrap();
    let mut answered = 0;
    for (small, large) in [(1.25e-14, 1e308), (1.25e-24, 1e298), (5e-324, 1.7e308), (1e-17, 1e308), (1e-160, 1e150), (1e-17, 1.0)]
    {
        for small in [small, -small] {
            let receiver = Receiver::new(DVec3::ZERO, DVec3::new(small, 0.0, large), 1.0).unwrap();
            let Ok(answer) = evaluate(&receiver, &emitter, &[]) else { continue };
            let truth = enclose(&receiver, &emitter, 20).unwrap();
            let errors = [0, 1, 2].map(|axis| truth.gradient[axis].error_of(answer.gradient[axis]));
            assert!(truth.radiosity.error_of(answer.radiosity) <= answer.radiosity_error, "{small:e} {large:e}: {answer:?}");
            // Squares of 1e270 are beyond the range of doubles.
            let errors = DVec3::from(errors).max_element();
            assert!(errors <= answer.gradient_error, "{small:e} {large:e}: {answer:?}, {truth:?}");
            answered += 1;
            if small > 0.0
                && let Ok(digits) = evaluate_digits(&receiver, &emitter, &[], 20)
            {
                let slope = digits.gradient[2].parse::<f64>().unwrap();
                assert!((slope - truth.gradient[2].to_f64()).abs() <= 1e-14 * slope.abs(), "{digits:?}, {truth:?}");
            }
        }
    }
    assert!(answered >= 4, "{answered}");
}
