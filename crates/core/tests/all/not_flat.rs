//! Emitters and occluders that are not flat: whatever surface spans their vertices, the answer encloses its radiosity.

use radgrad_core::{
    Answer, DVec3, Emission, Emitter, Linear, Method, Polygon, Receiver, Tolerance, evaluate, evaluate_digits, evaluate_to,
    evaluate_value,
};
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

/// The two ways to split four vertices into triangles.
fn splits(corners: [DVec3; 4]) -> [[Polygon; 2]; 2] {
    let triangle = |indices: [usize; 3]| Polygon::new(indices.map(|i| corners[i]).to_vec()).unwrap();
    [[[0, 1, 2], [0, 2, 3]], [[0, 1, 3], [1, 2, 3]]].map(|pair| pair.map(triangle))
}

struct Random(ChaCha8Rng);

impl Random {
    fn uniform(&mut self, low: f64, high: f64) -> f64 {
        self.0.random_range(low..high)
    }

    /// A rough square around a point, spanned by two vectors, its corners off its plane by at most `off`.
    fn square(&mut self, middle: DVec3, [u, v]: [DVec3; 2], defect: f64) -> [DVec3; 4] {
        let normal = u.cross(v).normalize();
        [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)].map(|(a, b)| {
            let corner = u * (a * self.uniform(0.8, 1.2)) + v * (b * self.uniform(0.8, 1.2));
            middle + corner + normal * (defect * self.uniform(-1.0, 1.0))
        })
    }

    fn direction(&mut self) -> DVec3 {
        DVec3::new(self.uniform(-1.0, 1.0), self.uniform(-1.0, 1.0), self.uniform(-1.0, 1.0)).normalize()
    }

    /// An occluder that meets the emitter: crossing it, standing on its plane, sharing an edge or a corner, flush with it, or seen
    /// edge-on.
    fn occluder(&mut self, kind: usize, lamp: [DVec3; 4], x: DVec3, defect: f64) -> [DVec3; 4] {
        let middle = (lamp[0] + lamp[2]) * 0.5 + (lamp[1] - lamp[0]) * self.uniform(-0.6, 0.6);
        let (along, down) = ((lamp[1] - lamp[0]).normalize(), (x - middle).normalize());
        let tilted = (down + self.direction() * 0.5).normalize();
        match kind {
            0 => self.square(middle, [along * 0.4, tilted * 0.3], defect),
            1 => self.square(middle + tilted * 0.2, [along * 0.3, tilted * 0.2], defect),
            2 => [lamp[0], lamp[1], lamp[1] + tilted * 0.3, lamp[0] + tilted * 0.3],
            3 => {
                let other = self.direction() * 0.2 + down * 0.3;
                [lamp[0], lamp[0] + tilted * 0.3, lamp[0] + tilted * 0.3 + other, lamp[0] + other]
            }
            4 => self.square(middle, [along * 0.2, (lamp[3] - lamp[0]) * 0.1], defect),
            _ => self.square(middle + (x - middle) * 0.5, [along * 0.2, (x - middle) * 0.1], defect),
        }
    }
}

/// The sum over triangles, each flat, past the triangles of the occluder.
fn by_triangles(receiver: &Receiver, lamp: &[Polygon; 2], occluder: &[Polygon; 2], scale: f64) -> Answer {
    let [a, b] = lamp
        .each_ref()
        .map(|triangle| evaluate(receiver, &Emitter::new(triangle.clone(), Emission::Constant(1.0)).unwrap(), occluder).unwrap());
    Answer {
        radiosity: a.radiosity + b.radiosity,
        gradient: a.gradient + b.gradient,
        radiosity_error: a.radiosity_error + b.radiosity_error + 1e-16,
        gradient_error: a.gradient_error + b.gradient_error + 1e-15 / scale,
        ..a
    }
}

#[test]
fn every_way_to_split_emitter_and_occluder_is_enclosed() {
    let mut random = Random(ChaCha8Rng::seed_from_u64(12));
    let cases: usize = std::env::var("RADGRAD_NOT_FLAT_CASES").map_or(600, |n| n.parse().unwrap());
    let mut worst = [[0.0_f64; 2]; 6];
    let mut tried = 0;
    for case in 0..cases {
        // Half of them so far off as rounded coordinates are.
        let defect = [1e-12, 1e-13, 1e-14, 1e-16, 1e-2, 1e-4, 1e-6, 1e-9][case / 6 % 8];
        let (along, across) = (random.direction(), random.direction());
        let across = along.cross(across).normalize();
        let lamp = random.square(random_middle(), [along * 0.5, across * 0.5], defect);
        let polygon = Polygon::from_rounded(lamp.to_vec(), defect).unwrap();
        let x = lamp[0].midpoint(lamp[2]) + polygon.normal() * random.uniform(0.3, 1.5) + random.direction() * 0.2;
        let screen = random.occluder(case % 6, lamp, x, defect);
        let normal = (random_middle() - x).normalize() + random.direction() * 0.3;
        // Squares of such lengths are beyond the range of doubles.
        let scale = [1.0, 2f64.powi(600), 2f64.powi(-600)][case / 48 % 3];
        let [lamp, screen] = [lamp, screen].map(|corners| corners.map(|corner| corner * scale));
        let rounded = |corners: [DVec3; 4]| Polygon::from_rounded(corners.to_vec(), defect * scale);
        let (polygon, x) = (rounded(lamp).unwrap(), x * scale);
        let Ok(occluder) = rounded(screen) else { continue };
        let receiver = Receiver::new(x, normal, 1.0).unwrap();
        let emitter = Emitter::new(polygon, Emission::Constant(1.0)).unwrap();
        let answer = evaluate(&receiver, &emitter, [&occluder]).unwrap();
        tried += 1;
        for lamp in &splits(lamp) {
            for occluder in &splits(screen) {
                let truth = by_triangles(&receiver, lamp, occluder, scale);
                let value = (answer.radiosity - truth.radiosity).abs() / (answer.radiosity_error + truth.radiosity_error);
                let gradient = ((answer.gradient - truth.gradient) * scale).length()
                    / ((answer.gradient_error + truth.gradient_error) * scale);
                let kind = &mut worst[case % 6];
                *kind = [kind[0].max(value), kind[1].max(gradient)];
                assert!(value <= 1.0 && gradient <= 1.0, "case {case}, off {defect:e}: {answer:?}, by triangles {truth:?}");
            }
        }
    }
    println!("{tried} cases, largest error over bound by kind of occluder, value and gradient: {worst:.3?}");
    assert!(tried > cases / 2);
}

fn random_middle() -> DVec3 {
    DVec3::new(0.3, -0.2, 0.7)
}

/// A linear emission is that of its affine function on every surface.
#[test]
fn every_surface_of_a_rounded_linear_emitter_is_enclosed() {
    let mut random = Random(ChaCha8Rng::seed_from_u64(51));
    let mut answered = 0;
    for case in 0..400 {
        let defect = [1e-2, 1e-4, 1e-7, 1e-10][case % 4];
        let (along, across) = (random.direction(), random.direction());
        let lamp = random.square(random_middle(), [along * 0.5, along.cross(across).normalize() * 0.5], defect);
        let polygon = Polygon::from_rounded(lamp.to_vec(), defect).unwrap();
        let x = lamp[0].midpoint(lamp[2]) + polygon.normal() * random.uniform(0.1, 20.0) + random.direction() * 0.2;
        let receiver = Receiver::new(x, random_middle() - x + random.direction() * 0.5, 1.0).unwrap();
        let slope = random.direction();
        let slope = slope - polygon.normal() * polygon.normal().dot(slope);
        let linear = |polygon: Polygon| {
            let value = 3.0 + slope.dot(polygon.vertices()[0] - lamp[0]);
            Emitter::new(polygon, Emission::gradient(value, slope)).unwrap()
        };
        let Ok(answer) = evaluate(&receiver, &linear(polygon), []) else { continue };
        answered += 1;
        for pair in splits(lamp) {
            let parts = pair.map(|triangle| evaluate(&receiver, &linear(triangle), []).unwrap());
            let off_value = answer.radiosity - parts[0].radiosity - parts[1].radiosity;
            let off_gradient = answer.gradient - parts[0].gradient - parts[1].gradient;
            assert!(off_value.abs() <= answer.radiosity_error + 1e-15, "case {case}, off {defect:e}: {off_value:e}, {answer:?}");
            assert!(
                off_gradient.length() <= answer.gradient_error + 1e-13,
                "case {case}, off {defect:e}: {off_gradient}, {answer:?}"
            );
        }
    }
    assert!(answered > 390, "{answered}");
}

/// A corner of the occluder lies in the emitter's plane up to rounding: in doubles nothing tells which way the line runs in which
/// the two planes meet.
#[test]
fn an_occluder_that_just_dips_below_the_emitter_hides_what_is_in_front() {
    let mut random = Random(ChaCha8Rng::seed_from_u64(5));
    let mut hidden = 0;
    for case in 0..400 {
        let [a, b, c] = [(); 3].map(|()| random_middle() + random.direction());
        let Ok(lamp) = Polygon::new(vec![a, b, c]) else { continue };
        let x = (a + b + c) / 3.0 + lamp.normal() * random.uniform(0.5, 1.5) + random.direction() * 0.2;
        let [s, t] = [random.uniform(-0.2, 0.9), random.uniform(-0.2, 0.9)];
        let dips = a + (b - a) * s + (c - a) * t - lamp.normal() * [0.0, 1e-15, 1e-12][case % 3];
        let others = [(); 2].map(|()| dips + (x - dips) * random.uniform(0.1, 0.4) + random.direction() * 0.3);
        let Ok(occluder) = Polygon::new(vec![dips, others[0], others[1]]) else { continue };
        let receiver = Receiver::new(x, dips - x, 1.0).unwrap();
        let emitter = Emitter::new(lamp, Emission::Constant(1.0)).unwrap();
        let answer = evaluate(&receiver, &emitter, [&occluder]).unwrap();
        let truth: f64 = evaluate_digits(&receiver, &emitter, &[occluder], 20).unwrap().radiosity.parse().unwrap();
        let error = (answer.radiosity - truth).abs();
        assert!(error <= answer.radiosity_error + 1e-16 * truth, "case {case}: {answer:?}, truth {truth}");
        hidden += usize::from(truth < evaluate(&receiver, &emitter, &[]).unwrap().radiosity * 0.999);
    }
    assert!(hidden > 200, "{hidden}");
}

#[test]
fn digits_that_the_input_does_not_have_are_not_computed() {
    let mut random = Random(ChaCha8Rng::seed_from_u64(9));
    for defect in [1e-16, 1e-15, 1e-14] {
        for _ in 0..20 {
            let corners = random.square(DVec3::new(0.3, 0.2, 2.0), [DVec3::X, DVec3::new(0.1, 1.0, 0.3)], defect);
            let polygon = Polygon::new(corners.to_vec()).unwrap();
            if polygon.planarity_defect() < 1e-17 {
                continue;
            }
            let gradient = random.direction();
            let lamp = Emitter::new(polygon, Emission::Linear(Linear::Gradient { value: 5.0, gradient })).unwrap();
            let receiver = Receiver::new(DVec3::ZERO, DVec3::Z, 0.5).unwrap();
            let answer = evaluate_to(&receiver, &lamp, [], 0.0).unwrap();
            let value = evaluate_value(&receiver, &lamp, [], Tolerance { relative: 0.0, absolute: 0.0 }).unwrap();
            assert_ne!(answer.method, Method::ArbitraryPrecision, "{defect:e}");
            assert_ne!(value.method, Method::ArbitraryPrecision, "{defect:e}");
            // Such a surface may change the answer by a hundred times the defect.
            let limit = 100.0 * lamp.polygon().planarity_defect() + 1e-15;
            assert!(answer.radiosity_error < limit && value.radiosity_error < limit, "{defect:e}: {answer:?}");
        }
    }
}
