//! Intervals must contain the truth as often as they say, with occluders too, and never look converged where they are not.

use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver};
use radgrad_oracle::confidence::ConfidenceInterval;
use radgrad_oracle::monte_carlo::{Estimate, Limits, Sampling, Sequence, Status, integrate, integrate_source};
use radgrad_oracle::{EmissionBounds, EmissionFunction, Error, SourceFunction, cubature, enclose};
use rand::SeedableRng;
use rand::rngs::Xoshiro256PlusPlus;
use rand_distr::{Distribution, UnitSphere};

fn polygon(vertices: &[[f64; 3]]) -> Polygon {
    Polygon::new(vertices.iter().map(|&vertex| vertex.into()).collect()).unwrap()
}

/// A square ceiling at height 2 that shines down, brighter to one side.
fn ceiling() -> Emitter {
    let square = polygon(&[[-1.0, -1.0, 2.0], [-1.0, 1.0, 2.0], [1.0, 1.0, 2.0], [1.0, -1.0, 2.0]]);
    Emitter::new(square, Emission::gradient(1.0, DVec3::new(0.25, 0.5, 0.0))).unwrap()
}

fn receiver(position: DVec3) -> Receiver {
    Receiver::new(position, DVec3::new(0.2, -0.1, 1.0), 0.8).unwrap()
}

fn exact(receiver: &Receiver, emitter: &Emitter) -> cubature::Estimate {
    let (source, form) = (SourceFunction::Emitter(emitter), cubature::Form::Boundary);
    let estimate = cubature::integrate_form(receiver, emitter.polygon(), source, form, 1e-10, 10_000_000).unwrap();
    assert_eq!(estimate.status, cubature::Status::Converged);
    estimate
}

/// Radiosity of the ceiling less that of the shadow, a polygon through the shadows of `points` cast from `position`.
fn past_shadow(position: DVec3, points: &[DVec3]) -> f64 {
    let cast = |point: &DVec3| position + (point - position) * ((2.0 - position.z) / (point.z - position.z));
    // Lit from below, like the ceiling.
    let shadow: Vec<DVec3> = points.iter().rev().map(|point| cast(point).with_z(2.0)).collect();
    let emission = Emission::gradient(ceiling().emission_at(shadow[0]), ceiling().emission_gradient());
    let shadow = Emitter::new(Polygon::new(shadow).unwrap(), emission).unwrap();
    let receiver = receiver(position);
    exact(&receiver, &ceiling()).radiosity - exact(&receiver, &shadow).radiosity
}

/// Value and central differences.
fn truth_past_shadow(points: &[DVec3]) -> [f64; 4] {
    let step = 1e-4;
    let slope = |axis: DVec3| (past_shadow(axis * step, points) - past_shadow(-axis * step, points)) / (2.0 * step);
    [past_shadow(DVec3::ZERO, points), slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z)]
}

/// Shares of the seeds whose 99 % intervals contain the truth: Student's and the distribution-free ones, the worst of the
/// quantities. All have enough samples to be called so.
fn coverage(truth: [f64; 4], seeds: u64, estimate: impl Fn(u64) -> Estimate) -> [f64; 2] {
    coverage_whatever_the_status(truth, seeds, |seed| {
        let estimate = estimate(seed);
        assert!(all_limits(&estimate).iter().all(|limits| limits.status == Status::Sampled), "{estimate:?}");
        estimate
    })
}

fn all_limits(estimate: &Estimate) -> [Limits; 4] {
    [estimate.radiosity, estimate.gradient[0], estimate.gradient[1], estimate.gradient[2]]
}

fn coverage_whatever_the_status(truth: [f64; 4], seeds: u64, estimate: impl Fn(u64) -> Estimate) -> [f64; 2] {
    let mut inside = [[0; 2]; 4];
    for seed in 0..seeds {
        for (count, (limits, truth)) in inside.iter_mut().zip(all_limits(&estimate(seed)).iter().zip(truth)) {
            count[0] += u64::from(limits.student.contains(truth));
            count[1] += u64::from(limits.distribution_free.contains(truth));
        }
    }
    println!("coverage of {seeds} seeds: {inside:?}");
    [0, 1].map(|kind| inside.iter().map(|count| count[kind]).min().unwrap() as f64 / seeds as f64)
}

fn all_ways(seed: u64) -> [(Sampling, Sequence); 4] {
    let independent = Sequence::Independent { samples: 2400, seed };
    let sobol = Sequence::Sobol { samples: 128, scramblings: 16, seed };
    [Sampling::Area, Sampling::SolidAngle]
        .map(|sampling| [(sampling, independent), (sampling, sobol)])
        .concat()
        .try_into()
        .unwrap()
}

fn assert_coverage(truth: [f64; 4], emitter: &Emitter, receiver: &Receiver, occluders: &[Polygon]) {
    for way in 0..4 {
        let [student, free] = coverage(truth, 200, |seed| {
            let (sampling, sequence) = all_ways(seed)[way];
            integrate(receiver, emitter, occluders, sampling, sequence, 0.99).unwrap()
        });
        assert!(student >= 0.97, "{:?}: {student}", all_ways(0)[way]);
        assert!(free >= 0.999, "{:?}: {free}", all_ways(0)[way]);
    }
}

#[test]
fn limits_contain_the_truth_as_often_as_they_say() {
    // In full view; cut by the horizon; near.
    for (position, normal) in
        [([0.3, -0.2, 0.0], [0.1, 0.2, 1.0]), ([0.5, 0.4, 0.5], [1.0, 0.5, 0.25]), ([0.8, -0.7, 1.0], [0.0, 0.25, 1.0])]
    {
        let receiver = Receiver::new(position.into(), normal.into(), 0.8).unwrap();
        let truth = exact(&receiver, &ceiling());
        let truth = [truth.radiosity, truth.gradient.x, truth.gradient.y, truth.gradient.z];
        assert_coverage(truth, &ceiling(), &receiver, &[]);
    }
}

/// The first direction from the seed that is well toward `toward`.
fn looking(toward: DVec3, seed: u64) -> DVec3 {
    let generator = Xoshiro256PlusPlus::seed_from_u64(seed);
    let directions = UnitSphere.sample_iter(generator).map(|direction: [f64; 3]| DVec3::from(direction));
    directions.take(1000).find(|n| n.dot(toward) > 0.2 * toward.length()).unwrap()
}

/// Coverage over receivers at `position` with normals of their own.
fn assert_coverage_from(position: DVec3, emitter: &Emitter) {
    let vertices = emitter.polygon().vertices();
    let centroid = vertices.iter().sum::<DVec3>() / vertices.len() as f64;
    for seed in 0..4 {
        let receiver = Receiver::new(position, looking(centroid - position, seed), 0.8).unwrap();
        let truth = enclose(&receiver, emitter, 16).unwrap();
        let [x, y, z] = truth.gradient.map(|component| component.to_f64());
        let [student, free] = coverage([truth.radiosity.to_f64(), x, y, z], 200, |seed| {
            let sequence = Sequence::Independent { samples: 2400, seed };
            integrate(&receiver, emitter, &[], Sampling::SolidAngle, sequence, 0.99).unwrap()
        });
        assert!(student >= 0.97, "from {position}: {student}");
        assert!(free >= 0.999, "from {position}: {free}");
    }
}

/// A triangle like no axis.
const TILTED: [[f64; 3]; 3] = [[0.1, -0.2, 0.3], [0.9, 0.3, 0.1], [0.2, 0.8, 0.7]];

#[test]
fn limits_contain_the_truth_just_above_the_plane_of_the_emitter() {
    let emitter = Emitter::new(polygon(&TILTED), Emission::at_vertices(vec![1.0, 2.0, 0.5])).unwrap();
    let [a, b, c] = TILTED.map(DVec3::from);
    for height in [1e-4, 1e-8, 1e-12, 2e-15] {
        assert_coverage_from(a + (a - b) * 0.7 + (a - c) * 0.4 + emitter.polygon().normal() * height, &emitter);
    }
}

#[test]
fn limits_contain_the_truth_of_a_needle() {
    let [a, b, c] = TILTED.map(DVec3::from);
    for width in [1e-4, 1e-8, 1e-12] {
        let needle = Polygon::new(vec![a, b, a.lerp(b, 0.3) + (c - a) * width]).unwrap();
        let position = a + needle.normal() * 0.6 + (c - a) * 0.2;
        assert_coverage_from(position, &Emitter::new(needle, Emission::Constant(1.5)).unwrap());
    }
}

#[test]
fn limits_contain_the_truth_from_far_away() {
    let emitter = Emitter::new(polygon(&TILTED), Emission::at_vertices(vec![1.0, 2.0, 0.5])).unwrap();
    for distance in [1e2, 1e5, 1e8] {
        assert_coverage_from((emitter.polygon().normal() + DVec3::X * 0.5) * distance, &emitter);
    }
}

#[test]
fn limits_contain_the_truth_where_samples_differ_by_their_rounding_only() {
    let emitter = Emitter::new(polygon(&TILTED), Emission::Constant(1.0)).unwrap();
    for distance in [1e6, 1e9, 1e12] {
        let position = emitter.polygon().normal() * distance;
        let receiver = Receiver::new(position, -position, 1.0).unwrap();
        let truth = enclose(&receiver, &emitter, 16).unwrap().radiosity.to_f64();
        for seed in 0..100 {
            let sequence = Sequence::Independent { samples: 2400, seed };
            let limits = integrate(&receiver, &emitter, &[], Sampling::SolidAngle, sequence, 0.99).unwrap().radiosity;
            assert!(limits.student.contains(truth) && limits.distribution_free.contains(truth), "{distance}: {truth} {limits:?}");
            assert!(limits.student.width() < 1e-11 * truth);
        }
    }
}

#[test]
fn limits_contain_the_truth_past_an_occluder() {
    let corners = [[0.1, -0.2, 1.0], [0.45, -0.15, 1.1], [0.4, 0.3, 1.2], [0.05, 0.25, 1.1]];
    // The fourth corner brought into the plane of the others.
    let points = corners.map(DVec3::from);
    let normal = (points[1] - points[0]).cross(points[2] - points[0]);
    let lift = normal.dot(points[0] - points[3]) / normal.z;
    let points = [points[0], points[1], points[2], points[3] + DVec3::Z * lift];
    let truth = truth_past_shadow(&points);
    let blind = exact(&receiver(DVec3::ZERO), &ceiling()).radiosity;
    assert!(truth[0] < 0.95 * blind);
    let whole = [Polygon::new(points.to_vec()).unwrap()];
    assert_coverage(truth, &ceiling(), &receiver(DVec3::ZERO), &whole);
    // In two triangles, one of them turned over: their common edge must not count.
    let halves = [[points[0], points[1], points[2]], [points[0], points[3], points[2]]];
    let halves = halves.map(|half| Polygon::new(half.to_vec()).unwrap());
    assert_coverage(truth, &ceiling(), &receiver(DVec3::ZERO), &halves);
}

#[test]
fn limits_contain_the_truth_past_a_box() {
    let corner = |i: usize| {
        let side = |bit: usize| if i >> bit & 1 == 0 { 0.1 } else { 0.4 };
        DVec3::new(side(0), side(1), 1.0 + if i >> 2 & 1 == 0 { 0.0 } else { 0.3 })
    };
    let faces = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    let faces = faces.map(|face| Polygon::new(face.map(corner).to_vec()).unwrap());
    // Seen from the origin: the near face, and the two sides that face the axis.
    let truth = truth_past_shadow(&[4, 5, 1, 3, 2, 6].map(corner));
    assert_coverage(truth, &ceiling(), &receiver(DVec3::ZERO), &faces);
}

#[test]
fn limits_contain_the_truth_past_a_screen_that_stands_on_the_emitter() {
    // It hides the corner that a diagonal cuts off; the rest is a triangle that keeps its border when the receiver moves.
    let corners = [[-1.0, -1.0, 2.0], [-1.0, 1.0, 2.0], [1.0, 1.0, 2.0], [1.0, -1.0, 2.0]];
    let visible = Emitter::new(polygon(&corners[..3]), Emission::gradient(1.0, ceiling().emission_gradient())).unwrap();
    for distance in [3.0, 1e2, 1e5] {
        let receiver = receiver(DVec3::new(-0.6, 0.5, -1.0) * distance);
        // Its shadow ends well beyond the corner, and it leans low or rises far.
        for rise in [0.2, 1.0] {
            let beyond = DVec3::new(2.5, -2.5, 2.0);
            let top = beyond + (receiver.position() - beyond).normalize() * rise;
            let screen = Polygon::new(vec![corners[0].into(), corners[2].into(), top]).unwrap();
            let truth = enclose(&receiver, &visible, 16).unwrap();
            let [x, y, z] = truth.gradient.map(|component| component.to_f64());
            let truth = [truth.radiosity.to_f64(), x, y, z];
            let [student, free] = coverage_whatever_the_status(truth, 200, |seed| {
                let sequence = Sequence::Independent { samples: 2400, seed };
                integrate(&receiver, &ceiling(), std::slice::from_ref(&screen), Sampling::SolidAngle, sequence, 0.99).unwrap()
            });
            assert!(student >= 0.97 && free >= 0.999, "from {distance}, {rise} high: {student}, {free}");
        }
    }
}

#[test]
fn nothing_seen_does_not_look_converged() {
    let lid = polygon(&[[-1.0, -1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, 1.0], [-1.0, 1.0, 1.0]]);
    let keyhole = polygon(&[[-1.0, -1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, 1.0], [-0.45, 1.0, 1.0]]);
    for lid in [lid, keyhole] {
        for (sampling, sequence) in all_ways(1) {
            let estimate =
                integrate(&receiver(DVec3::ZERO), &ceiling(), std::slice::from_ref(&lid), sampling, sequence, 0.99).unwrap();
            if estimate.hits < 20 {
                assert_eq!(estimate.radiosity.status, Status::TooFewHits);
                let limits = estimate.radiosity.student;
                assert!(limits.low == 0.0 && limits.high > 1e-4, "{limits:?}");
                assert_eq!(limits, estimate.radiosity.distribution_free);
            }
        }
    }
}

#[test]
fn a_peak_that_area_sampling_misses_is_not_called_sampled() {
    let over = |height: f64| Receiver::new(DVec3::new(0.3, 0.1, 2.0 - height), DVec3::Z, 1.0).unwrap();
    for height in [1e-2, 1e-3, 1e-5, 1e-9] {
        let truth = exact(&over(height), &ceiling()).radiosity;
        for seed in 0..20 {
            let sequence = Sequence::Independent { samples: 2000, seed };
            let by_area = integrate(&over(height), &ceiling(), &[], Sampling::Area, sequence, 0.99).unwrap().radiosity;
            assert_eq!(by_area.status, Status::TooFewHits, "height {height}");
            assert!(by_area.student.contains(truth));
            let by_angle = integrate(&over(height), &ceiling(), &[], Sampling::SolidAngle, sequence, 0.99).unwrap().radiosity;
            assert_eq!(by_angle.status, Status::Sampled, "height {height}");
            assert!((by_angle.mean / truth - 1.0).abs() < 0.1 && by_angle.distribution_free.contains(truth));
        }
    }
}

#[test]
fn a_receiver_on_the_emitter_is_refused() {
    let sequence = Sequence::Independent { samples: 100, seed: 1 };
    for position in [[0.3, 0.1, 2.0], [1.0, 0.2, 2.0], [-1.0, -1.0, 2.0]] {
        let on_it = Receiver::new(position.into(), DVec3::Z, 1.0).unwrap();
        let error = integrate(&on_it, &ceiling(), &[], Sampling::Area, sequence, 0.99).unwrap_err();
        assert!(matches!(error, Error::Touching { .. }), "{error}");
    }
    let beside = Receiver::new(DVec3::new(1.5, 0.1, 2.0), DVec3::Z, 1.0).unwrap();
    let estimate = integrate(&beside, &ceiling(), &[], Sampling::Area, sequence, 0.99).unwrap();
    assert_eq!((estimate.radiosity.status, estimate.radiosity.mean), (Status::Zero, 0.0));
    let on_edge_of_occluder = polygon(&[[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 0.0, 1.0]]);
    let lifted = polygon(&[[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 1.0, 1.0]]);
    let with = |occluder| integrate(&receiver(DVec3::ZERO), &ceiling(), &[occluder], Sampling::Area, sequence, 0.99);
    assert!(with(on_edge_of_occluder).is_ok(), "seen edge-on it hides nothing");
    assert!(with(lifted).is_ok(), "its plane holds the receiver");
}

#[test]
fn the_same_seed_gives_the_same_digits() {
    for (sampling, sequence) in all_ways(7) {
        let run = |sequence| integrate(&receiver(DVec3::ZERO), &ceiling(), &[], sampling, sequence, 0.9).unwrap();
        assert_eq!(run(sequence), run(sequence));
        let other = match sequence {
            Sequence::Independent { samples, .. } => Sequence::Independent { samples, seed: 8 },
            Sequence::Sobol { samples, scramblings, .. } => Sequence::Sobol { samples, scramblings, seed: 8 },
        };
        assert_ne!(run(sequence).radiosity.mean, run(other).radiosity.mean);
    }
}

#[test]
fn scrambled_sobol_is_narrower_than_independent_points() {
    for sampling in [Sampling::Area, Sampling::SolidAngle] {
        let width = |sequence| {
            let estimate = integrate(&receiver(DVec3::ZERO), &ceiling(), &[], sampling, sequence, 0.99).unwrap();
            estimate.radiosity.student.width()
        };
        let independent = width(Sequence::Independent { samples: 16 * 1024, seed: 3 });
        let sobol = width(Sequence::Sobol { samples: 1024, scramblings: 16, seed: 3 });
        assert!(sobol < 0.05 * independent, "{sampling:?}: {sobol} against {independent}");
    }
}

#[test]
fn wrong_settings_are_named() {
    let with = |sequence, confidence| integrate(&receiver(DVec3::ZERO), &ceiling(), &[], Sampling::Area, sequence, confidence);
    let independent = |samples| Sequence::Independent { samples, seed: 1 };
    assert_eq!(with(independent(1), 0.9), Err(Error::TooFewSamples { what: "samples", value: 1, least: 2 }));
    assert!(matches!(with(independent(9), 1.0), Err(Error::Confidence { value: 1.0 })));
    let sobol = Sequence::Sobol { samples: 16, scramblings: 1, seed: 1 };
    assert_eq!(with(sobol, 0.9), Err(Error::TooFewSamples { what: "scramblings", value: 1, least: 2 }));
}

#[test]
fn an_emission_function_past_an_occluder_is_sampled_within_its_bounds() {
    let emitter = ceiling();
    let corners = [DVec3::new(-0.3, -0.3, 1.0), DVec3::new(0.3, -0.3, 1.0), DVec3::new(0.0, 0.4, 1.0)];
    let (radiosity, gradient) = (|y: DVec3| emitter.emission_at(y), |_| emitter.emission_gradient());
    let bounds = EmissionBounds { range: ConfidenceInterval { low: 0.25, high: 1.75 }, steepest: 0.6 };
    let with = |gradient, bounds| {
        let function = EmissionFunction { radiosity: &radiosity, gradient, detail: f64::INFINITY, bounds };
        let screen = [Polygon::new(corners.to_vec()).unwrap()];
        let source = SourceFunction::Function(&function);
        let sequence = Sequence::Independent { samples: 20_000, seed: 3 };
        let point = receiver(DVec3::new(0.1, 0.2, 0.0));
        integrate_source(&point, emitter.polygon(), source, &screen, Sampling::SolidAngle, sequence, 0.999)
    };
    let estimate = with(Some(&gradient), Some(bounds)).unwrap();
    let exact = past_shadow(DVec3::new(0.1, 0.2, 0.0), &corners);
    assert!(
        estimate.radiosity.student.contains(exact) && estimate.radiosity.distribution_free.contains(exact),
        "{estimate:?} for {exact}"
    );
    for (missing, estimate) in [("gradient", with(None, Some(bounds))), ("bounds", with(Some(&gradient), None))] {
        assert_eq!(estimate, Err(Error::EmissionPart { missing, asker: "Monte Carlo" }));
    }
}
