//! The Hessian against differences of gradients, family by family: of the oracle's enclosures, and of the closed form's digits
//! where there are many cases or extreme ones.

use std::collections::BTreeMap;

use glam::DVec3;
use radgrad_audit::cases::family::Family;
use radgrad_audit::cases::sampler::Sampler;
use radgrad_core::{Emission, Emitter, Error, Hessian, Method, Polygon, Receiver, evaluate_digits, hessian_to};
use radgrad_oracle::enclose;
use radgrad_tests::second_derivatives::{Matrix, Seen};

const TOLERANCES: [f64; 3] = [1e-12, 1e-15, 0.0];

/// Cases of a family from which something is seen; one of a hundred edges.
fn cases(family: Family, count: u64) -> impl Iterator<Item = (u64, Seen)> {
    (0..if family == Family::HundredVertices { 1 } else { count }).filter_map(move |index| {
        let problem = family.case(5, index).problem().ok()?;
        let scene = Seen::moved(&problem.receiver, &problem.emitter).filter(|scene| scene.smooth_range() > 0.0)?;
        let rough = hessian_to(&scene.receiver(DVec3::ZERO), &scene.emitter, &[], 1.0);
        if family == Family::Subnormal {
            // Emission of 2^-1000 over the square of such a length; and no step is a normal number.
            assert!(matches!(rough, Ok(_) | Err(Error::Overflow { quantity: "Hessian" })), "{family}:5:{index}: {rough:?}");
            return None;
        }
        (rough.unwrap().method != Method::Zero).then_some((index, scene))
    })
}

/// Gradients of so many digits by the closed form.
fn by_closed_form(scene: &Seen, digits: u32) -> impl Fn(&Receiver) -> [String; 3] {
    move |receiver| evaluate_digits(receiver, &scene.emitter, &scene.occluders, digits).unwrap().gradient
}

/// Relative error of the answer to 1e-12, after every tolerance was seen to be met and every bound to hold.
fn checked(scene: &Seen, truth: &Matrix, case: &str) -> (f64, Hessian) {
    let answers = TOLERANCES.map(|tolerance| {
        let answer = hessian_to(&scene.receiver(DVec3::ZERO), &scene.emitter, &scene.occluders, tolerance).unwrap();
        let error = truth.distance(&answer.matrix);
        assert!(error <= answer.error, "{case} to {tolerance:e}: off by {error:e}, {answer:?}");
        assert!(answer.meets(tolerance.max(1.2e-16)), "{case} to {tolerance:e}: {answer:?}");
        (error / truth.norm(), answer)
    });
    answers[0]
}

#[test]
fn it_is_the_difference_of_enclosed_gradients() {
    for family in Family::ALL {
        for (index, scene) in cases(family, 3) {
            // Half of 50 digits go into the step, which leaves an error of 1e-28 by the order of the difference.
            let truth = scene.hessian(1e-14, |receiver| {
                let enclosed = enclose(receiver, &scene.emitter, 50).unwrap();
                enclosed.gradient.map(|component| component.to_decimal().unwrap())
            });
            checked(&scene, &truth, &format!("{family}:5:{index}"));
        }
    }
}

#[test]
fn every_family_meets_every_tolerance_and_keeps_its_bound() {
    for family in Family::ALL {
        let (mut worst, mut untold) = (0.0_f64, 0);
        let mut rungs = BTreeMap::new();
        for (index, scene) in cases(family, 24) {
            let gradient = by_closed_form(&scene, 80);
            let [truth, coarse] = [1e-20, 1e-19].map(|part| scene.hessian(part, &gradient));
            if truth.distance_to(&coarse) > 1e-30 * truth.norm() {
                // Lengths of 2^900 beside such of 2^-900 leave gradients of 80 digits none that their differences have.
                assert!(family == Family::MixedExponents, "{family}:5:{index}: the difference has no digits");
                untold += 1;
                continue;
            }
            let (error, answer) = checked(&scene, &truth, &format!("{family}:5:{index}"));
            worst = worst.max(error);
            *rungs.entry(answer.method.name()).or_insert(0) += 1;
        }
        println!("{family:16} worst {worst:.1e}, {rungs:?}, {untold} not told");
        assert!(untold <= 9, "{family}: {untold}");
        assert!(worst < 1e-13, "{family}: {worst:e}");
    }
}

/// A random polygon around `middle` in the plane across `axis`, convex or not.
fn polygon(sampler: &mut Sampler, middle: DVec3, axis: DVec3, size: f64) -> Polygon {
    loop {
        let along = sampler.perpendicular(axis.normalize());
        let across = axis.normalize().cross(along);
        let count = 3 + sampler.below(4);
        let corner = |k: u32| {
            let angle = std::f64::consts::TAU * (f64::from(k) + sampler.between(0.0, 0.7)) / f64::from(count);
            let radius = size * sampler.between(0.3, 1.0);
            middle + (along * libm::cos(angle) + across * libm::sin(angle)) * radius
        };
        if let Ok(polygon) = Polygon::new((0..count).map(corner).collect()) {
            return polygon;
        }
    }
}

/// An emitter past one to five screens, some that meet, pierce each other or stand on it, some cut by the horizon.
fn screened(index: u64) -> Seen {
    let sampler = &mut Sampler::new(3, "screened", index);
    let middle = sampler.direction() * sampler.spread(-1, 3);
    let tilt = (sampler.direction() * 0.6 - middle.normalize()).normalize();
    let lamp = polygon(sampler, middle, tilt, 1.0);
    let screens = (0..1 + sampler.below(5)).map(|_| {
        let share = sampler.between(0.2, 1.05);
        let place = (middle + sampler.direction() * 0.5) * share;
        let axis = sampler.direction() * 0.9 + middle.normalize();
        polygon(sampler, place, axis, 0.7 * share)
    });
    let mut occluders: Vec<Polygon> = screens.collect();
    if sampler.one_in(3) {
        let [a, b] = [lamp.vertices()[0], lamp.vertices()[1]];
        let standing = vec![a, b, b + (tilt * 0.4 - middle * 0.1), a + (tilt * 0.3 - middle * 0.05)];
        occluders.extend(Polygon::new(standing));
    }
    let normal = middle.normalize() * 0.4 + sampler.direction();
    Seen { normal, emitter: Emitter::new(lamp, Emission::Constant(1.5)).unwrap(), occluders }
}

#[test]
fn past_screens_it_is_the_difference_of_gradients_too() {
    let (mut compared, mut hidden, mut open) = (0, 0, 0);
    let mut worst: f64 = 0.0;
    for index in 0..200 {
        let scene = screened(index);
        let rough = hessian_to(&scene.receiver(DVec3::ZERO), &scene.emitter, &scene.occluders, 1.0).unwrap();
        let free = hessian_to(&scene.receiver(DVec3::ZERO), &scene.emitter, &[], 1.0).unwrap();
        if rough.method == Method::Zero {
            hidden += usize::from(free.method != Method::Zero);
            continue;
        }
        // Where polygons meet that are flat up to rounding only, no gradient has 80 digits.
        let digits = evaluate_digits(&scene.receiver(DVec3::ZERO), &scene.emitter, &scene.occluders, 80);
        let is_flat = |polygon: &Polygon| polygon.planarity_defect() == 0.0;
        if digits.is_err() && !(is_flat(scene.emitter.polygon()) && scene.occluders.iter().all(is_flat)) {
            open += 1;
            continue;
        }
        let gradient = by_closed_form(&scene, 80);
        let [truth, coarse] = [1e-20, 1e-19].map(|part| scene.hessian(part, &gradient));
        assert!(truth.distance_to(&coarse) <= 1e-30 * truth.norm(), "{index}: the difference has no digits");
        let (error, _) = checked(&scene, &truth, &format!("scene {index}"));
        worst = worst.max(error);
        compared += usize::from(truth.distance(&free.matrix) > 1e-6 * truth.norm());
    }
    println!("{compared} partly hidden, {hidden} wholly, {open} open, worst {worst:.1e}");
    assert!(compared > 75 && worst < 1e-12, "{compared}, {worst:e}");
}

/// In contact down to 1e-290, over the inside, beside an edge and beside a corner, in scenes of three sizes.
#[test]
fn contact_at_any_height_and_scale_has_all_its_digits() {
    let corners = [[0.3, 0.2], [-0.4, -0.8], [-0.7, 0.9]];
    let (mut answered, mut overflown) = (0, 0);
    for foot in [[0.0, 0.0], [0.3, 0.2 + 1e-9], [0.3, 0.2], [-0.2, 0.55], [2.0, 0.1]] {
        for normal in [DVec3::new(0.1, 0.2, 1.0), DVec3::new(1.0, -0.3, 0.2), DVec3::new(1.0, 0.3, -1e-3)] {
            for (height, exponent) in [1e-9, 1e-60, 1e-150, 1e-290].into_iter().flat_map(|h| [0, -850, 850].map(|e| (h, e))) {
                let scale = 2f64.powi(exponent);
                let vertices = corners.map(|[x, y]| DVec3::new(x - foot[0], y - foot[1], height) * scale);
                let emission = 2f64.powi((2 * exponent).clamp(-1000, 1000));
                let polygon = Polygon::new(vertices.to_vec()).unwrap();
                let emitter = Emitter::new(polygon, Emission::Constant(emission)).unwrap();
                let scene = Seen { normal, emitter, occluders: Vec::new() };
                let case = format!("{foot:?} {normal} at {height:e} times 2^{exponent}");
                match hessian_to(&scene.receiver(DVec3::ZERO), &scene.emitter, &[], 1e-12) {
                    Err(Error::Overflow { quantity: "Hessian" }) => overflown += 1,
                    Err(error) => panic!("{case}: {error}"),
                    // Nothing above the horizon, or no height left below the range of doubles.
                    Ok(answer) if answer.method == Method::Zero => {}
                    Ok(_) => {
                        answered += 1;
                        let range = scene.smooth_range();
                        // A step is a normal number.
                        if range < 1e-285 {
                            continue;
                        }
                        let digits = 80 + u32::try_from(-libm::ilogb(range / scale)).unwrap_or(0) / 3;
                        let truth = scene.hessian(1e-20, by_closed_form(&scene, digits));
                        checked(&scene, &truth, &case);
                    }
                }
            }
        }
    }
    println!("{answered} answered, {overflown} beyond a double");
    assert!(answered >= 90 && overflown > 0);
}
