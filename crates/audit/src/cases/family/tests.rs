use super::*;
use crate::cases::name::BadName;
use crate::cases::sampler::{normalising_power, power_of_two};
use crate::measures::truth::Truth;
use glam::DVec3;
use radgrad_core::{Error as CoreError, Polygon};
use radgrad_oracle::Interval;
use radgrad_scene::Error;
use radgrad_scene::case::{EmissionRecord, Problem};

const COUNT: u64 = 300;

fn problems(family: Family) -> impl Iterator<Item = Problem> {
    (0..COUNT).map(move |index| {
        let case = family.case(1, index);
        case.problem().unwrap_or_else(|error| panic!("{}: {error}", case.id))
    })
}

fn lit_families() -> impl Iterator<Item = Family> {
    Family::ALL.into_iter().filter(|f| !f.is_refused())
}

/// Height over the emitter's plane and over its size, elevations of the vertices over the horizon, distance of the nearest
/// vertex.
struct Figures {
    height: f64,
    lowest: f64,
    highest: f64,
    distance: f64,
}

fn figures(problem: &Problem) -> Figures {
    let (x, polygon) = (problem.receiver.position(), problem.emitter.polygon());
    let (lowest, highest) = scene::elevations(problem.receiver.normal(), x, polygon.vertices());
    Figures {
        height: polygon.normal().dot(x - polygon.vertices()[0]) / polygon.size(),
        lowest,
        highest,
        distance: polygon.vertices().iter().map(|v| (*v - x).length()).fold(f64::INFINITY, f64::min) / polygon.size(),
    }
}

#[test]
fn every_case_but_those_to_be_refused_is_valid() {
    for family in lit_families() {
        assert_eq!(problems(family).count() as u64, COUNT);
    }
}

#[test]
fn cases_to_be_refused_are_refused_for_their_vertices() {
    for index in 0..COUNT {
        match Family::EqualVertices.case(1, index).problem() {
            Err(Error::Emitter(CoreError::RepeatedVertex { .. } | CoreError::NotSimple { .. } | CoreError::ZeroArea { .. })) => {}
            other => panic!("case {index}: {other:?}"),
        }
    }
}

#[test]
fn names_and_families_read_back() {
    for family in Family::ALL {
        let name = Name { family, seed: 12, index: 345 };
        assert_eq!(name.to_string().parse(), Ok(name));
    }
    assert_eq!("contact:1".parse::<Name>(), Err(BadName::Shape("contact:1".to_owned())));
    assert!("contakt:1:2".parse::<Name>().unwrap_err().to_string().contains("near-vertex"));
}

#[test]
fn a_case_depends_on_its_name_alone() {
    for family in Family::ALL {
        assert_eq!(family.case(1, 7), family.case(1, 7));
        assert_ne!(family.case(1, 7).receiver, family.case(1, 8).receiver);
        assert_ne!(family.case(1, 7).receiver, family.case(2, 7).receiver);
    }
}

#[test]
fn far_reaches_from_ten_to_a_hundred_million_sizes() {
    let distances: Vec<f64> = problems(Family::Far).map(|p| figures(&p).distance).collect();
    assert!(distances.iter().all(|d| (5.0..4e8).contains(d)));
    assert!(distances.iter().any(|d| *d < 20.0) && distances.iter().any(|d| *d > 5e7));
}

#[test]
fn near_families_reach_down_to_the_last_decade() {
    for family in [Family::Contact, Family::Grazing, Family::NearEdge] {
        let heights: Vec<f64> = problems(family).map(|p| figures(&p).height).collect();
        assert!(heights.iter().all(|h| h.abs() < 0.3), "{family}");
        assert!(heights.iter().any(|h| (1e-13..1e-11).contains(h)), "{family}");
    }
    let nearest = problems(Family::NearVertex).map(|p| figures(&p).distance).fold(f64::INFINITY, f64::min);
    assert!(nearest < 1e-11, "{nearest}");
}

#[test]
fn horizon_families_are_cut_where_they_say() {
    assert!(problems(Family::Generic).all(|p| figures(&p).lowest > 0.0));
    assert!(problems(Family::Clipped).all(|p| figures(&p).lowest < -0.009 && figures(&p).highest > 0.009));
    for (index, f) in problems(Family::HorizonSliver).map(|p| figures(&p)).enumerate() {
        assert!(f.lowest < -0.04 && f.highest < 0.2, "{index}: {} {}", f.lowest, f.highest);
    }
    assert!(problems(Family::HorizonSliver).any(|p| (1e-13..1e-11).contains(&figures(&p).highest)));
    assert!(problems(Family::BelowHorizon).all(|p| figures(&p).highest < 0.0));
}

#[test]
fn receivers_in_the_plane_are_so_exactly() {
    for family in [Family::InPlaneInside, Family::InPlaneOutside] {
        for problem in problems(family) {
            let [a, b, c] = [0, 1, 2].map(|k| problem.emitter.polygon().vertices()[k]);
            let integer = |v: DVec3| v.to_array().map(crate::cases::lattice::tests::in_units);
            let minus = |u: DVec3, v: DVec3| std::array::from_fn::<i128, 3, _>(|k| integer(u)[k] - integer(v)[k]);
            let (u, v, w) = (minus(b, a), minus(c, a), minus(problem.receiver.position(), a));
            let determinant =
                u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) + u[2] * (v[0] * w[1] - v[1] * w[0]);
            assert_eq!(determinant, 0, "{family}");
        }
    }
}

#[test]
fn back_facing_receivers_are_behind_the_emitter() {
    assert!(problems(Family::BackFacing).all(|p| figures(&p).height < 0.0));
}

#[test]
fn scaling_and_shifting_leave_the_shape() {
    for problem in problems(Family::Scale) {
        assert!((0.1..20.0).contains(&figures(&problem).distance));
    }
    let sizes: Vec<f64> = problems(Family::Scale).map(|p| p.emitter.polygon().size()).collect();
    assert!(sizes.iter().any(|s| *s < 1e-80) && sizes.iter().any(|s| *s > 1e80));
    let shifts: Vec<f64> = problems(Family::FarOrigin).map(|p| p.receiver.position().length()).collect();
    assert!(shifts.iter().any(|s| *s > 1e11), "{shifts:?}");
}

/// Which of constant, vertex values, gradient and polynomial a family draws.
const fn kinds_of(family: Family) -> [bool; 4] {
    match family {
        Family::PolynomialFar | Family::PolynomialClipped => [false, false, false, true],
        Family::SteepExtension => [false, true, true, false],
        Family::CancellingValues => [false, true, false, false],
        Family::SteepNormal => [true, false, false, false],
        Family::NearCoincidentVertices | Family::Single => [true, false, true, false],
        _ => [true, true, true, false],
    }
}

#[test]
fn every_emission_is_positive_over_the_emitter_and_every_kind_occurs() {
    for family in lit_families() {
        let mut kinds = [false; 4];
        for index in 0..COUNT {
            let case = family.case(1, index);
            kinds[match case.emitter.emission {
                EmissionRecord::Constant { .. } => 0,
                EmissionRecord::Vertices { .. } => 1,
                EmissionRecord::Gradient { .. } => 2,
                EmissionRecord::Polynomial { .. } => 3,
                EmissionRecord::Expression { .. } => panic!("{}: it has no closed form", case.id),
            }] = true;
            let problem = case.problem().expect("valid");
            let vertices = problem.emitter.polygon().vertices();
            // Of both signs, or of such different sizes that a slope does not give the small ones back.
            let is_any = matches!(family, Family::CancellingValues | Family::MixedExponents);
            assert!(is_any || vertices.iter().all(|v| problem.emitter.emission_at(*v) > 0.0), "{}", case.id);
        }
        assert_eq!(kinds, kinds_of(family), "{family}");
    }
}

#[test]
fn mixtures_are_difficult_in_both_ways() {
    let width = |p: &Problem| p.emitter.polygon().area() / (p.emitter.polygon().size() * p.emitter.polygon().size());
    assert!(problems(Family::FarNeedle).all(|p| figures(&p).distance > 4.0 && width(&p) < 0.2));
    assert!(problems(Family::FarNeedle).any(|p| figures(&p).distance > 1e7 && width(&p) < 1e-6));
    let tilt = |p: &Problem| figures(p).highest.max(-figures(p).lowest);
    assert!(problems(Family::FarClipped).all(|p| figures(&p).lowest < 0.0 && figures(&p).highest > 0.0));
    assert!(problems(Family::FarClipped).any(|p| tilt(&p) < 1e-7));
    assert!(problems(Family::FarScreen).all(|p| p.occluders.len() == 1 && figures(&p).distance > 3.0));
    // The horizon passes within the height of the receiver, which is itself small.
    assert!(problems(Family::ContactSliver).all(|p| figures(&p).height < 0.2 && figures(&p).highest < figures(&p).height));
    assert!(problems(Family::ContactSliver).any(|p| figures(&p).height < 1e-6 && figures(&p).highest < 1e-11));
    for family in [Family::ContactScale, Family::GrazingScale, Family::ScreenScale] {
        let sizes: Vec<f64> = problems(family).map(|p| p.emitter.polygon().size()).collect();
        assert!(sizes.iter().all(|s| *s < 1e-180 || *s > 1e180), "{family}");
        assert!(sizes.iter().any(|s| *s < 1e-240) && sizes.iter().any(|s| *s > 1e240), "{family}");
    }
    let contrast = |p: &Problem| {
        let values: Vec<f64> = p.emitter.polygon().vertices().iter().map(|v| p.emitter.emission_at(*v)).collect();
        values.iter().copied().fold(0.0, f64::max) / values.iter().copied().fold(f64::INFINITY, f64::min)
    };
    assert!(problems(Family::SteepExtension).any(|p| contrast(&p) > 1e8));
}

#[test]
fn screens_hide_what_they_are_meant_to() {
    let see = |p: &Problem, count: usize| {
        radgrad_core::evaluate_to(&p.receiver, &p.emitter, &p.occluders[..count], 1e-6).expect("an answer").radiosity
    };
    let share = |p: &Problem| see(p, p.occluders.len()) / see(p, 0);
    for family in [
        Family::OneScreen,
        Family::OtherScale,
        Family::Standing,
        Family::TenScreens,
        Family::NearScreen,
        Family::Boxes,
        Family::Thicket,
    ] {
        let shares: Vec<f64> = problems(family).take(20).map(|p| share(&p)).collect();
        // A wall that stands aside hides nothing.
        let is_share = |s: &f64| (0.0..1.0).contains(s) || (family == Family::Standing && *s == 1.0);
        assert!(shares.iter().all(is_share) && shares.iter().any(|s| *s > 0.1 && *s < 1.0), "{family}: {shares:?}");
    }
    assert!(problems(Family::IdleScreens).take(60).all(|p| (share(&p) - 1.0).abs() < 1e-6));
    for family in [Family::SilhouetteScreen, Family::EdgeScreen] {
        let shares: Vec<f64> = problems(family).take(100).map(|p| share(&p)).collect();
        assert!(shares.iter().any(|s| *s < 0.999) && shares.iter().any(|s| *s > 0.001), "{family}");
    }
    let slivers = problems(Family::SilhouetteScreen).take(100).filter(|p| (1e-14..1e-4).contains(&(1.0 - share(p)))).count();
    assert!(slivers > 10, "{slivers}");
}

#[test]
fn occluders_are_of_any_scale_and_walls_stand_on_the_floor() {
    let largest_coordinate = |p: &Problem| p.occluders[0].vertices().iter().map(|v| v.abs().max_element()).fold(0.0, f64::max);
    let sizes: Vec<f64> = problems(Family::OtherScale).map(|p| largest_coordinate(&p)).collect();
    assert!(sizes.iter().any(|size| *size < 1e-40) && sizes.iter().any(|size| *size > 1e40));
    let feet = |p: &Problem| p.occluders[0].vertices().iter().filter(|v| v.z == p.receiver.position().z).count();
    assert!(problems(Family::Standing).all(|p| (1..=2).contains(&feet(&p)) && p.receiver.normal() == DVec3::Z));
    assert!(problems(Family::Standing).any(|p| feet(&p) == 1) && problems(Family::Standing).any(|p| feet(&p) == 2));
}

#[test]
fn vertices_in_single_precision_are_so_and_bend_most_polygons() {
    let (mut bent, mut screened) = (0, 0);
    for problem in problems(Family::Single) {
        let polygon = problem.emitter.polygon();
        let outlines = || problem.occluders.iter().chain([polygon]);
        assert!(outlines().flat_map(Polygon::vertices).all(|v| v.as_vec3().as_dvec3() == *v && polygon.precision() > 0.0));
        let plain = |polygon: &Polygon| Polygon::new(polygon.vertices().to_vec());
        bent += usize::from(matches!(plain(polygon), Err(CoreError::NotPlanar { .. })));
        screened += usize::from(problem.occluders.iter().any(|screen| matches!(plain(screen), Err(CoreError::NotPlanar { .. }))));
        assert!(figures(&problem).height > 8.0 * polygon.planarity_defect() / polygon.size());
    }
    assert!(bent > 200 && screened > 100, "{bent} {screened}");
}

#[test]
fn components_of_normals_are_far_apart_and_none_is_lost() {
    let mut ratios = Vec::new();
    for index in 0..COUNT {
        let mut sizes = Family::SteepNormal.case(1, index).receiver.normal;
        sizes.sort_by(f64::total_cmp);
        assert!(sizes[0] == 0.0 && sizes[1] >= f64::MIN_POSITIVE && sizes[2].is_finite(), "{sizes:?}");
        ratios.push(sizes[1] / sizes[2]);
    }
    assert!(ratios.iter().any(|ratio| *ratio < 1e-60) && ratios.iter().any(|ratio| *ratio > 1e-30));
}

/// At distances for which the enclosure has no truth. An occluder of a part of the emitter hides the same part at any distance
/// from the receiver; the gradient is that of the emitter's edges and, over the distance, that of the occluder's, both known from
/// two distances.
#[test]
fn an_occluder_hides_the_same_at_every_distance_and_its_gradient_is_inverse() {
    let mut held = 0;
    for problem in problems(Family::OtherScale) {
        let size = problem.occluders[0].vertices().iter().map(|v| v.abs().max_element()).fold(0.0, f64::max);
        if size > 1.0 || held == 12 {
            continue;
        }
        let scaled_to = |times: f64| {
            let scaled = |v: &DVec3| *v * normalising_power(size) * times;
            let occluder = Polygon::new(problem.occluders[0].vertices().iter().map(scaled).collect()).expect("valid");
            Problem { occluders: vec![occluder], ..problem.clone() }
        };
        let [far, near] = [-10, -11].map(|power| Truth::of_problem(&scaled_to(power_of_two(power))).expect("enclosed"));
        let gradient = |truth: &Truth| DVec3::from_array(truth.gradient.each_ref().map(Interval::to_f64));
        let of_occluder = gradient(&near) - gradient(&far);
        let of_emitter = gradient(&far) - of_occluder;
        for power in [60, 260, 660] {
            let Problem { receiver, emitter, occluders, .. } = &scaled_to(power_of_two(-10 - power));
            let answer = radgrad_core::evaluate_to(receiver, emitter, occluders, 1e-12).expect("an answer");
            let (least, _) = far.errors_at_least(answer.radiosity, answer.gradient);
            assert!(least <= answer.radiosity_error, "{answer:?}");
            let unit = power_of_two(-power);
            let error = (answer.gradient * unit - (of_emitter * unit + of_occluder)).length();
            assert!(error <= answer.gradient_error * unit + 1e-13 * of_occluder.length(), "{answer:?}");
        }
        held += 1;
    }
    assert_eq!(held, 12);
}

/// Narrower than the narrowest strip that the enclosure has a truth for: a strip seen over the horizon 2^580 times as narrow, at
/// 2^580 times the emission, gives 2^-580 times the radiosity and the same gradient.
#[test]
fn what_a_small_component_lets_see_is_as_its_square() {
    for index in 0..12 {
        let mut case = Family::SteepNormal.case(1, index);
        let truth = Truth::of_problem(&case.problem().expect("valid")).expect("enclosed");
        let largest = case.receiver.normal.into_iter().fold(0.0, f64::max);
        let times = |c: f64| c / largest * if c == largest { 1.0 } else { power_of_two(-580) };
        case.receiver.normal = case.receiver.normal.map(|c| times(c) * power_of_two(1000));
        let EmissionRecord::Constant { constant } = &mut case.emitter.emission else { panic!("{}", case.id) };
        *constant *= power_of_two(580);
        let Problem { receiver, emitter, .. } = &case.problem().expect("valid");
        let answer = radgrad_core::evaluate_to(receiver, emitter, &[], 1e-12).expect("an answer");
        let value_error = truth.radiosity_error(answer.radiosity * power_of_two(580));
        assert!(
            value_error <= answer.radiosity_error * power_of_two(580) + 1e-15 * truth.radiosity_magnitude(),
            "{}: {answer:?}",
            case.id
        );
        let gradient_error = truth.gradient_error(answer.gradient);
        assert!(gradient_error <= answer.gradient_error + 1e-15 * truth.gradient_magnitude(), "{}: {answer:?}", case.id);
    }
}

#[test]
fn extremes_are_as_extreme_as_they_say() {
    assert!(problems(Family::OnSurface).all(|p| figures(&p).height.abs() < 1e-14));
    assert!(problems(Family::OnSurface).any(|p| figures(&p).height > 0.0));
    let length = |p: &Problem| p.receiver.direction().length();
    let cases: Vec<_> = (0..COUNT).map(|index| Family::ShortNormal.case(1, index)).collect();
    assert!(cases.iter().all(|case| case.receiver.normal.iter().all(|c| c.abs() < 1e-28)));
    assert!(cases.iter().any(|case| case.receiver.normal.iter().all(|c| c.abs() < f64::MIN_POSITIVE)));
    assert!(problems(Family::ShortNormal).all(|p| length(&p) > 0.0));
    assert!(problems(Family::Subnormal).all(|p| p.emitter.polygon().size() < 1e-303));
    assert!(problems(Family::Subnormal).any(|p| p.emitter.polygon().size() < f64::MIN_POSITIVE));
    let tiny = |p: &Problem| p.emitter.polygon().vertices().iter().any(|v| v.abs().min_element() < 1e-60);
    assert!(problems(Family::MixedExponents).filter(tiny).count() as u64 > COUNT / 2);
    let share = |p: &Problem| {
        let value = |emitter| radgrad_core::evaluate_to(&p.receiver, emitter, &[], 1e-6).expect("an answer").radiosity.abs();
        let even = radgrad_core::Emission::Constant(p.emitter.largest_emission());
        let even = radgrad_core::Emitter::new(p.emitter.polygon().clone(), even).expect("finite");
        value(&p.emitter) / value(&even)
    };
    assert!(problems(Family::CancellingValues).take(100).any(|p| share(&p) < 1e-12));
    assert!(problems(Family::HundredVertices).take(20).all(|p| p.emitter.polygon().vertices().len() == 100));
    let answer =
        |p: &Problem, occluders: &[_]| radgrad_core::evaluate_to(&p.receiver, &p.emitter, occluders, 1e-9).expect("an answer");
    for problem in problems(Family::OccludersInPlane).take(100) {
        let [free, past] = [&[][..], &problem.occluders].map(|occluders| answer(&problem, occluders));
        assert!((free.radiosity - past.radiosity).abs() <= free.radiosity_error + past.radiosity_error);
    }
}
