//! Occluders from 1e-300 to 1e300 of the emitter's distance: each answer encloses that of an occluder of ordinary size that hides the
//! same, or the case is refused.

use radgrad_core::{Answer, DVec3, Emission, Emitter, Error, Polygon, Receiver, evaluate, evaluate_digits};
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

/// So many cases of a kind, unless the environment says another number.
fn cases(usual: usize) -> usize {
    std::env::var("RADGRAD_SCALES_CASES").map_or(usual, |count| count.parse().unwrap())
}

struct Random(ChaCha8Rng);

impl Random {
    fn uniform(&mut self, low: f64, high: f64) -> f64 {
        self.0.random_range(low..high)
    }

    /// A power of two that is spread over the decades.
    fn power(&mut self, low: i32, high: i32) -> f64 {
        2f64.powi(self.0.random_range(low..=high))
    }

    /// A length from 16 to 1e200 or so.
    fn far(&mut self, exponent: i32) -> f64 {
        self.power(4, exponent) * self.uniform(1.0, 2.0)
    }

    /// An emitter over the origin, lit downward, a receiver there, and the slope of the emission, if any.
    fn scene(&mut self, emission: usize) -> (Receiver, Vec<DVec3>, Option<DVec3>) {
        let corner = |a: f64, b: f64, random: &mut Self| {
            DVec3::new(a * random.uniform(0.3, 1.0), b * random.uniform(0.3, 1.0), 2.0 + random.uniform(0.0, 0.5))
        };
        let vertices = vec![corner(-1.0, -1.0, self), corner(-1.0, 1.0, self), corner(1.0, 0.5, self)];
        let normal = DVec3::new(self.uniform(-1.0, 1.0), self.uniform(-1.0, 1.0), 1.0);
        let slope = (emission == 0).then(|| DVec3::new(self.uniform(-1.0, 1.0), self.uniform(-1.0, 1.0), 0.0));
        (Receiver::new(DVec3::ZERO, normal, 1.0).unwrap(), vertices, slope)
    }
}

fn scaled(points: &[DVec3], scale: f64) -> Polygon {
    Polygon::new(points.iter().map(|p| *p * scale).collect()).unwrap()
}

fn lamp_of(vertices: &[DVec3], slope: Option<DVec3>, scale: f64) -> Emitter {
    let emission = slope.map_or(Emission::Constant(1.0), |slope| Emission::gradient(3.0, slope / scale));
    Emitter::new(scaled(vertices, scale), emission).unwrap()
}

/// The answer where all lengths are multiplied by a power of two, in the unit before.
fn answer(receiver: &Receiver, lamp: &Emitter, occluder: &[DVec3], scale: f64) -> Result<Answer, Error> {
    let scaled_answer = evaluate(receiver, lamp, &[scaled(occluder, scale)])?;
    Ok(Answer { gradient: scaled_answer.gradient * scale, gradient_error: scaled_answer.gradient_error * scale, ..scaled_answer })
}

/// Whether an error names the quantity that is out of range.
fn names_the_range(error: &Error) -> bool {
    matches!(error, Error::Overflow { .. } | Error::Underflow { .. } | Error::Scales { .. })
}

#[test]
fn what_reaches_far_beyond_the_emitter_hides_as_what_just_does() {
    let mut random = Random(ChaCha8Rng::seed_from_u64(1));
    let (count, mut answered) = (cases(1500), 0);
    for case in 0..count {
        let (receiver, lamp, slope) = random.scene(case % 3);
        let (a, c) = (random.uniform(-0.4, 0.6), random.uniform(0.5, 1.8));
        let edge = |from: f64, to: f64| [DVec3::new(a, -from, c), DVec3::new(a, to, c)];
        let screen = |ends: [DVec3; 2], third: DVec3| vec![ends[0], ends[1], third];
        let far = random.far(960);
        let down = if random.uniform(0.0, 1.0) < 0.5 { 0.0 } else { far };
        let third = DVec3::new(far, far * random.uniform(-0.2, 0.2), c - down);
        let mut end = || far * random.power(0, 30);
        let large = screen(edge(end(), end()), third);
        let usual = screen(edge(64.0, 64.0), DVec3::new(64.0, 0.0, c));
        // Not so far that lengths overflow.
        let scale = if far > 1e120 { 1.0 } else { random.power(-500, 300) };
        let truth = answer(&receiver, &lamp_of(&lamp, slope, 1.0), &usual, 1.0).unwrap();
        match answer(&receiver, &lamp_of(&lamp, slope, scale), &large, scale) {
            Ok(scaled_answer) => {
                answered += 1;
                let (value, gradient) =
                    (scaled_answer.radiosity - truth.radiosity, (scaled_answer.gradient - truth.gradient).length());
                let bounds =
                    [scaled_answer.radiosity_error + truth.radiosity_error, scaled_answer.gradient_error + truth.gradient_error];
                assert!(
                    value.abs() <= bounds[0] * 1.01,
                    "case {case}, far {far:e}, scale {scale:e}: {scaled_answer:?}, truth {truth:?}"
                );
                assert!(
                    gradient <= bounds[1] * 1.01,
                    "case {case}, far {far:e}, scale {scale:e}: {scaled_answer:?}, truth {truth:?}"
                );
                assert!(bounds[0] < 1e-9, "case {case}, far {far:e}: {scaled_answer:?}");
            }
            Err(error) => assert!(names_the_range(&error), "case {case}: {error}"),
        }
    }
    assert!(answered * 100 > 99 * count, "{answered} of {count}");
}

/// Drawn together about the receiver an occluder hides the same, and its share of the gradient grows with its nearness.
#[test]
fn what_is_near_the_receiver_hides_as_its_image_before_the_emitter() {
    let mut random = Random(ChaCha8Rng::seed_from_u64(2));
    let (count, mut answered) = (cases(1500), 0);
    for case in 0..count {
        let (receiver, lamp, slope) = random.scene(case % 3);
        let mut corner =
            |x: f64, y: f64| DVec3::new(x + random.uniform(-0.4, 0.4), y + random.uniform(-0.4, 0.4), random.uniform(0.3, 1.2));
        let screen = [corner(0.0, -0.5), corner(0.5, 0.3), corner(-0.5, 0.3)];
        let near = random.power(-990, -1);
        let scale = if near < 1e-120 { 1.0 } else { random.power(-300, 500) };
        let scaled_answer =
            |near: f64, scale: f64| answer(&receiver, &lamp_of(&lamp, slope, scale), &screen.map(|v| v * near), scale);
        let [whole, half] = [1.0, 0.5].map(|near| scaled_answer(near, 1.0).unwrap());
        match scaled_answer(near, scale) {
            Ok(near_answer) => {
                answered += 1;
                let value = (near_answer.radiosity - whole.radiosity).abs();
                let own = half.gradient - whole.gradient;
                let gradient = (near_answer.gradient - (whole.gradient - own) - own / near) * near;
                let bound = 4.0 * (whole.gradient_error + half.gradient_error) + near_answer.gradient_error * near;
                assert!(
                    value <= near_answer.radiosity_error + whole.radiosity_error,
                    "case {case}, near {near:e}: {near_answer:?}, truth {whole:?}"
                );
                assert!(gradient.length() <= bound, "case {case}, near {near:e}: {near_answer:?}, {gradient} of {bound:e}");
                assert!(near_answer.radiosity_error < 1e-9, "case {case}, near {near:e}: {near_answer:?}");
            }
            Err(error) => assert!(names_the_range(&error), "case {case}: {error}"),
        }
    }
    assert!(answered * 100 > 99 * count, "{answered} of {count}");
}

/// Coordinates of every size in one scene: each evaluation ends, and the bounds enclose the value of many bits.
#[test]
fn coordinates_of_all_sizes_end_in_an_answer_or_a_refusal() {
    let mut random = Random(ChaCha8Rng::seed_from_u64(3));
    let (count, mut dark) = (cases(600), 0);
    for case in 0..count {
        let (receiver, lamp, slope) = random.scene(case % 3);
        let mut corner = || {
            let mut coordinate = || match random.uniform(0.0, 4.0) {
                choice if choice < 1.0 => random.uniform(-1.0, 1.0),
                choice if choice < 1.5 => 0.0,
                _ => random.uniform(-1.0, 1.0) * random.power(-660, 660),
            };
            DVec3::new(coordinate(), coordinate(), coordinate())
        };
        let Ok(screen) = Polygon::new(vec![corner(), corner(), corner()]) else { continue };
        let lamp = lamp_of(&lamp, slope, 1.0);
        let free = evaluate(&receiver, &lamp, &[]).unwrap();
        let hidden = match evaluate(&receiver, &lamp, [&screen]) {
            Ok(hidden) => hidden,
            Err(error) => {
                assert!(names_the_range(&error), "case {case}: {error}");
                continue;
            }
        };
        assert!(hidden.radiosity - hidden.radiosity_error <= free.radiosity + free.radiosity_error, "case {case}: {hidden:?}");
        dark += usize::from(hidden.radiosity == 0.0);
        if case % 4 == 0
            && let Ok(digits) = evaluate_digits(&receiver, &lamp, [&screen], 20)
        {
            let truth: f64 = digits.radiosity.parse().unwrap();
            let bound = hidden.radiosity_error + 1e-15 * truth.abs();
            assert!((hidden.radiosity - truth).abs() <= bound, "case {case}: {hidden:?}, {digits:?}, {screen:?}");
        }
    }
    // A triangle that hides all of it is a rare thing.
    assert!(dark * 4 < count, "{dark} of {count}");
}
