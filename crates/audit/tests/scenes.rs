//! The audit of whole scenes, part by part.

use glam::DVec3;
use radgrad_audit::scenes::family::{Family, Name};
use radgrad_audit::scenes::judge::{Ending, Judged, Verdict, judge};
use radgrad_audit::scenes::model::{Exact, Expected, Model, Probe, Ways};
use radgrad_audit::scenes::shrink::without;
use radgrad_audit::scenes::statement::{Quantum, Stated, Statement, Subject};
use radgrad_audit::scenes::table::{Requirement, Table};
use radgrad_core::Polygon;
use radgrad_oracle::confidence::ConfidenceInterval;
use radgrad_oracle::scene::{Effort, Known};

/// Less than a run of `verify` has.
const EFFORT: Effort = Effort { rays: 50_000, rays_a_point: 50_000, ..radgrad_audit::scenes::truth::EFFORT };

#[test]
fn every_family_draws_scenes_that_exist_and_the_same_ones_again() {
    for family in Family::ALL {
        for index in 0..20 {
            let name = Name { family, seed: 5, index };
            let model = name.model();
            assert_eq!(model, name.to_string().parse::<Name>().unwrap().model());
            let unchanged = Model { change: radgrad_audit::scenes::model::Change::None, ..model.clone() };
            let scene = unchanged.scene().unwrap_or_else(|error| panic!("{name}: {error}"));
            let faces = if family == Family::Plates { 1000..=1200 } else { 2..=200 };
            assert!(faces.contains(&scene.faces().len()), "{name}: {} faces", scene.faces().len());
            assert!(model.probes.len() >= 3 && model.parts.iter().any(|part| part.emitted[0] > 0.0), "{name}");
            for probe in &model.probes {
                let polygon = scene.faces()[probe.part].polygon();
                let distance = polygon.normal().dot(probe.position - polygon.vertices()[0]).abs();
                assert!(distance < 1e-14, "{name}: a point is {distance:e} off its face");
                assert!(model.parts[probe.part].reflectance[0] > 0.0, "{name}");
            }
        }
    }
}

#[test]
fn a_scene_is_the_same_from_its_file() {
    let model = Family::Clutter.model(1, 1);
    let [obj, mtl] = model.to_obj("m.mtl");
    let degenerate = radgrad_scene::Degenerate::Refuse;
    let file = std::path::Path::new("m.obj");
    let read = radgrad_scene::obj::parse(obj.as_bytes(), file, degenerate, |_| Ok(mtl.clone().into())).unwrap();
    let made = model.scene().unwrap();
    assert!(read.polygons().eq(made.polygons()));
    assert_eq!(read.emitted_power(0).to_bits(), made.emitted_power(0).to_bits());
}

#[test]
fn a_furnace_and_facing_rectangles_hold() {
    for family in [Family::Furnace, Family::Facing] {
        for index in 0..2 {
            let model = family.model(1, index);
            let outcome = judge(&model, Subject::Solve, &EFFORT);
            assert!(!outcome.fails(&model), "{family}:1:{index}: {:?}", outcome.faults(&model));
            let Ending::Judged(all) = outcome.ending else { panic!("{family}:1:{index} has no answer") };
            assert!(all.iter().all(|one| one.verdict == Verdict::Held));
        }
    }
}

/// Places of the unit square that leave no large gap (M. Roberts 2018).
fn places(count: u32) -> impl Iterator<Item = [f64; 2]> {
    (1..=count).map(|k| [0.754_877_666_246_693, 0.569_840_290_998_053_2].map(|step| (f64::from(k) * step).fract()))
}

#[test]
fn at_two_hundred_points_of_scenes_that_are_known_errors_are_within_three_estimates() {
    let hold = |name: &str| {
        let mut model = name.parse::<Name>().unwrap().model();
        model.ways = Ways::default();
        let count = model.parts.len();
        let probe = |(index, [s, t]): (usize, [f64; 2])| {
            let corners = &model.parts[index % count].corners;
            let position = corners[0] + (corners[1] - corners[0]) * s + (corners[3] - corners[0]) * t;
            Probe { part: index % count, position }
        };
        model.probes = places(200).enumerate().map(probe).collect();
        let outcome = judge(&model, Subject::Solve, &EFFORT);
        assert!(!outcome.fails(&model), "{name}: {:?}", outcome.faults(&model));
        let Ending::Judged(all) = outcome.ending else { panic!("{name} has no answer") };
        assert!(all.len() >= 200 && all.iter().all(|one| one.verdict == Verdict::Held), "{name}: {} points", all.len());
        let widest = all.iter().map(|one| one.statement.stated.size()).fold(0.0, f64::max);
        println!("{name}, degree {:?}: estimates of at most {widest:e}", model.degree);
        assert!(model.exact != Exact::Even(1.0) || widest < 1e-6, "{name}: {widest:e}");
    };
    std::thread::scope(|scope| {
        for name in ["furnace:1:0", "facing:1:0", "facing:1:1", "facing:1:2", "facing:1:3"] {
            scope.spawn(move || hold(name));
        }
    });
}

#[test]
fn what_was_not_judged_is_counted_and_gated() {
    // A truth that is wider than the bound and than a thirtieth of its value judges nothing.
    let stated = |stated: Stated| Statement { of: Quantum::Mean(0), value: 1.0, stated };
    let within = |low: f64, high: f64| Known { value: 0.5 * (low + high), interval: ConfidenceInterval { low, high } };
    let verdicts =
        |of: Stated, truths: [(f64, f64); 3]| truths.map(|(low, high)| Judged::new(stated(of), within(low, high), 1.0).verdict);
    assert_eq!(
        verdicts(Stated::Bound(0.1), [(0.0, 3.0), (0.95, 1.2), (1.2, 1.3)]),
        [Verdict::Rough, Verdict::Rough, Verdict::Broken]
    );
    // An estimate may be a third of the error.
    assert_eq!(
        verdicts(Stated::Estimate(0.1), [(0.0, 3.0), (1.2, 1.3), (1.4, 1.5)]),
        [Verdict::Rough, Verdict::Held, Verdict::Off]
    );
    assert_eq!(verdicts(Stated::Estimate(f64::NAN), [(0.0, 3.0), (0.9, 1.1), (1.2, 1.3)]), [Verdict::Broken; 3]);
    let mut table = Table::measure(&[Family::Facing], 1, 1, &EFFORT, |_, _| ());
    assert!(table.hardly_judged(&Requirement::default()).is_empty());
    let row = table.rows.get_mut(&(Family::Facing, Subject::Solve)).unwrap();
    (row.held, row.rough) = (row.rough, row.held);
    assert!(!table.hardly_judged(&Requirement::default()).is_empty());
}

/// Scenes whose light is known exactly: `RADGRAD_CERTIFICATES` is how many, at each of the two probabilities.
#[test]
fn certificates_fail_no_more_often_than_they_say() {
    let count: usize = std::env::var("RADGRAD_CERTIFICATES").ok().map_or(20, |count| count.parse().expect("a number of scenes"));
    let families = [Family::Facing, Family::Strips, Family::Furnace, Family::Sphere, Family::Manufactured];
    let names = (0..).flat_map(|index| families.map(|family| Name { family, seed: 11, index }));
    let (mut missed, mut certificates) = (0_u32, 0);
    for name in names.filter(|name| name.model().exact != Exact::Nothing).take(count) {
        let model = name.model();
        let outcome = judge(&model, Subject::Certificate, &EFFORT);
        assert!(!outcome.fails(&model), "{name}: {:?}", outcome.faults(&model));
        let Ending::Judged(all) = outcome.ending else { panic!("{name} has no certificate") };
        certificates += 1;
        if let Some(one) = all.iter().find(|one| one.verdict == Verdict::Missed) {
            println!("{name}: {one:?}");
            missed += 1;
        }
    }
    println!("{missed} of {certificates} certificates at 0.01 failed, none of as many at 1e-6");
    assert!(certificates == count as u64 && f64::from(missed) <= Requirement::default().may_miss(certificates));
}

#[test]
fn limits_that_may_fail_are_counted_and_others_are_broken() {
    let within = |low: f64, high: f64| Known { value: 0.5 * (low + high), interval: ConfidenceInterval { low, high } };
    let verdict = |[low, high]: [f64; 2], delta: f64, truth: Known| {
        let statement = Statement { of: Quantum::Mean(0), value: low, stated: Stated::Limits { low, high, delta } };
        Judged::new(statement, truth, 1.0).verdict
    };
    let truth = within(1.0, 1.01);
    assert_eq!(verdict([0.9, 1.001], 1e-2, truth), Verdict::Held);
    assert_eq!(verdict([1.02, 1.1], 1e-2, truth), Verdict::Missed);
    assert_eq!(verdict([0.8, 0.99], 1e-6, truth), Verdict::Broken);
    // Without an upper end, and of no number.
    assert_eq!(verdict([0.9, f64::INFINITY], 1e-6, truth), Verdict::Held);
    assert_eq!(verdict([1.1, f64::INFINITY], 1e-6, truth), Verdict::Broken);
    assert_eq!(verdict([0.9, f64::NAN], 1e-2, truth), Verdict::Broken);
    assert_eq!(verdict([0.999, 1.001], 1e-2, within(0.9, 1.1)), Verdict::Rough);
    let allowed = |of: u64| Requirement::default().may_miss(of).floor();
    assert_eq!([1, 30, 100, 2000].map(allowed), [0.0, 1.0, 3.0, 30.0]);
}

#[test]
fn a_plate_of_a_thousand_faces_that_glows_too_little_is_noticed() {
    let mut model = Family::Plates.model(1, 0);
    let outcome = judge(&model, Subject::Solve, &EFFORT);
    assert!(!outcome.fails(&model), "{:?}", outcome.faults(&model));
    // The bound, of faces that are divided no further, does not tell.
    model.parts.last_mut().unwrap().emitted[0] *= 0.9;
    let Ending::Judged(all) = judge(&model, Subject::Solve, &EFFORT).ending else { panic!("no answer") };
    assert!(all.iter().any(|one| one.verdict == Verdict::Broken));
}

#[test]
fn of_faces_on_faces_each_place_is_seen_once_in_the_scene_in_smaller_ones_and_in_the_file() {
    let area = |outline: &[DVec3]| Polygon::new(outline.to_vec()).unwrap().area();
    let visible_area = |model: &Model| model.visible_pieces().iter().map(|(_, outline)| area(outline)).sum::<f64>();
    // The faces that lie on nothing, the smaller faces included that lie on them.
    let lowest = |model: &Model| {
        let lowest = model.parts.iter().filter(|part| part.lies.is_none());
        lowest.map(|part| area(&part.corners)).sum::<f64>()
    };
    for index in 0..12 {
        let model = Family::Nested.model(3, index);
        let whole = lowest(&model);
        let smaller = (0..model.parts.len()).map(|part| without(&model, part));
        for model in smaller.chain([model.clone()]) {
            assert!((visible_area(&model) - lowest(&model)).abs() < 1e-12 * whole, "nested:3:{index}");
        }
        let scene = model.scene().unwrap_or_else(|error| panic!("nested:3:{index}: {error}"));
        let read: f64 = scene.polygons().map(Polygon::area).sum();
        assert!((read - whole).abs() < 1e-3 * whole, "nested:3:{index}: {read} of {whole}");
        assert!(scene.surfaces().len() < model.parts.len(), "nested:3:{index}: a face that is there twice stayed");
    }
}

#[test]
fn what_overlaps_is_expected_to_be_refused() {
    assert!((0..5).all(|index| Family::Overlap.model(1, index).expected == Expected::Refusal));
}
