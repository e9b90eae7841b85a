//! Enclosures against values from elsewhere, against themselves, and against exact identities.

use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver};
use radgrad_oracle::{Arithmetic, Enclosure, Error, Interval, Polynomial, Request, Source, enclose, enclose_source};
use serde_json::Value;

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn vector(value: &Value) -> DVec3 {
    DVec3::new(number(&value[0]), number(&value[1]), number(&value[2]))
}

fn polygon(points: &[[f64; 3]]) -> Polygon {
    Polygon::new(points.iter().map(|p| DVec3::from(*p)).collect()).unwrap()
}

fn receiver(position: [f64; 3], normal: [f64; 3]) -> Receiver {
    Receiver::new(position.into(), normal.into(), 1.0).unwrap()
}

/// The points of `data/points.jsonl`: two of each family, truth to 30 digits from a closed form in 60-digit arithmetic.
fn points() -> Vec<(Receiver, Emitter, Value)> {
    include_str!("data/points.jsonl")
        .lines()
        .map(|line| {
            let point: Value = serde_json::from_str(line).unwrap();
            let r = &point["receiver"];
            let receiver = Receiver::new(vector(&r["position"]), vector(&r["normal"]), number(&r["reflectance"])).unwrap();
            let vertices = point["emitter"]["vertices"].as_array().unwrap().iter().map(vector).collect();
            let emission = match &point["emitter"]["emission"] {
                e if e.get("constant").is_some() => Emission::Constant(number(&e["constant"])),
                e => Emission::at_vertices(e["vertices"].as_array().unwrap().iter().map(number).collect()),
            };
            let emitter = Emitter::new(Polygon::new(vertices).unwrap(), emission).unwrap();
            (receiver, emitter, point)
        })
        .collect()
}

fn meets(interval: &Interval, truth: &Value) -> bool {
    interval.overlaps(&Interval::from_decimal(truth.as_str().unwrap()).unwrap())
}

fn relative_radii(enclosure: &Enclosure) -> [f64; 2] {
    let norm = DVec3::from(enclosure.gradient.each_ref().map(Interval::to_f64)).length();
    let widest = enclosure.gradient.iter().map(Interval::radius).fold(0.0, f64::max);
    [enclosure.radiosity.radius() / enclosure.radiosity.to_f64().abs(), widest / norm]
}

#[test]
fn every_family_of_points_is_enclosed_to_the_digits_asked() {
    for digits in [15, 20, 28] {
        for (receiver, emitter, point) in points() {
            let enclosure = enclose(&receiver, &emitter, digits).unwrap_or_else(|error| panic!("{}: {error}", point["id"]));
            let truth = &point["truth"];
            assert!(meets(&enclosure.radiosity, &truth["radiosity"]), "{} at {digits} digits", point["id"]);
            for axis in 0..3 {
                assert!(meets(&enclosure.gradient[axis], &truth["gradient"][axis]), "{} component {axis}", point["id"]);
            }
            let goal = 10f64.powi(-digits.cast_signed()) * 1.0001;
            let dark = enclosure.evaluations == 0;
            assert!(
                dark || relative_radii(&enclosure).iter().all(|r| *r <= goal),
                "{}: {:?}",
                point["id"],
                relative_radii(&enclosure)
            );
        }
    }
}

#[test]
fn classical_form_factors_are_enclosed() {
    // Howell, Menguc, Daun and Siegel, configuration factors B-3 (parallel) and B-4 (perpendicular), evaluated to 30 digits.
    let parallel = [
        ([1.0, 1.0, 1.0], "0.138531605994892996780769708634"),
        ([1.0, 2.0, 1.0], "0.167375009914383767416089274212"),
        ([10.0, 10.0, 1.0], "0.24797140829531015078053493237"),
        ([3.0, 0.5, 2.0], "0.0556410974807182158151480500255"),
    ];
    for ([a, b, c], value) in parallel {
        let rectangle = polygon(&[[0.0, 0.0, c], [0.0, b, c], [a, b, c], [a, 0.0, c]]);
        let emitter = Emitter::new(rectangle, Emission::Constant(1.0)).unwrap();
        let enclosure = enclose(&receiver([0.0; 3], [0.0, 0.0, 3.0]), &emitter, 27).unwrap();
        assert!(meets(&enclosure.radiosity, &Value::from(value)), "{a} {b} {c}");
    }
    let perpendicular = [
        ([1.0, 1.0, 1.0], "0.0557341970025535016096151456828"),
        ([2.0, 1.0, 1.0], "0.0950679411924033076468684809985"),
        ([0.5, 3.0, 0.25], "0.138076789901041240610088103532"),
    ];
    for ([a, b, c], value) in perpendicular {
        // Also lowered below the horizon, where nothing is seen of it.
        for low in [0.0, -0.7] {
            let rectangle = polygon(&[[c, 0.0, low], [c, 0.0, a], [c, b, a], [c, b, low]]);
            let emitter = Emitter::new(rectangle, Emission::Constant(1.0)).unwrap();
            let enclosure = enclose(&receiver([0.0; 3], [0.0, 0.0, 1.0]), &emitter, 27).unwrap();
            assert!(meets(&enclosure.radiosity, &Value::from(value)), "{a} {b} {c} from {low}");
        }
    }
}

#[test]
fn more_digits_nest_inside_fewer() {
    for (receiver, emitter, point) in points().into_iter().step_by(5) {
        let chain: Vec<Enclosure> = [15, 22, 30, 45].map(|digits| enclose(&receiver, &emitter, digits).unwrap()).into();
        for pair in chain.windows(2) {
            assert!(pair[0].radiosity.overlaps(&pair[1].radiosity), "{}", point["id"]);
            assert!((0..3).all(|i| pair[0].gradient[i].overlaps(&pair[1].gradient[i])), "{}", point["id"]);
            assert!(pair[0].radiosity.radius() > pair[1].radiosity.radius() || pair[1].evaluations == 0);
        }
    }
}

#[test]
fn scaling_by_a_power_of_two_is_exact() {
    let triangle = [[-0.3, 0.1, 0.9], [0.2, 0.8, 1.1], [0.7, -0.4, 1.0]];
    let scaled_by = |power: f64| {
        let emitter =
            Emitter::new(polygon(&triangle.map(|p| p.map(|c| c * power))), Emission::at_vertices(vec![1.0, 2.0, 0.5])).unwrap();
        enclose(&receiver([0.125 * power, 0.25 * power, 0.0], [0.1, 0.9, 0.2]), &emitter, 20).unwrap()
    };
    let plain = scaled_by(1.0);
    for power in [2f64.powi(300), 2f64.powi(-300), 2.0] {
        let scaled = scaled_by(power);
        assert_eq!(scaled.radiosity, plain.radiosity);
        for axis in 0..3 {
            assert_eq!(scaled.gradient[axis].bounds().0 * power, plain.gradient[axis].bounds().0);
            assert_eq!(scaled.gradient[axis].bounds().1 * power, plain.gradient[axis].bounds().1);
        }
    }
}

/// Central differences of fourth order of the value, at 45 digits.
fn difference(position: DVec3, normal: [f64; 3], source: &Source<'_>, axis: usize) -> f64 {
    let step = 2f64.powi(-16);
    let value = |count: f64| {
        let mut moved = position;
        moved[axis] += count * step;
        let receiver = Receiver::new(moved, normal.into(), 1.0).unwrap();
        enclose_source(&receiver, source, &Request::digits(45)).unwrap().radiosity
    };
    // The values agree in their leading digits, so each difference is taken against the middle one, exactly.
    let middle = value(0.0);
    let part = |count: f64| {
        let (value, reference) = (value(count).to_decimal().unwrap(), middle.to_decimal().unwrap());
        let [value, reference] = [value, reference].map(|text| decimal(&text));
        (value - reference) as f64 / 1e36
    };
    let [far_below, below, above, far_above] = [-2.0, -1.0, 1.0, 2.0].map(part);
    (far_below - 8.0 * below + 8.0 * above - far_above) / (12.0 * step)
}

/// A decimal number in units of 1e-36.
fn decimal(text: &str) -> i128 {
    let (mantissa, exponent) = text.split_once('e').unwrap();
    let (negative, mantissa) = mantissa.strip_prefix('-').map_or((false, mantissa), |rest| (true, rest));
    let (whole, fraction) = mantissa.split_once('.').unwrap();
    let digits: String = whole.chars().chain(fraction.chars()).chain(std::iter::repeat('0')).take(60).collect();
    let keep = usize::try_from(36 + exponent.parse::<i32>().unwrap() + 1).unwrap();
    let value: i128 = digits[..keep].parse().unwrap();
    if negative { -value } else { value }
}

#[test]
fn the_gradient_is_the_derivative_of_the_value() {
    let concave = polygon(&[[-1.0, -1.0, 1.0], [-0.8, 1.2, 1.0], [0.1, 0.2, 1.0], [1.3, 0.9, 1.0], [0.9, -1.1, 1.0]]);
    let cubic =
        Polynomial::new(vec![(0.7, [0; 3]), (0.3, [1, 0, 0]), (-0.2, [0, 1, 1]), (0.15, [2, 1, 0]), (0.4, [0, 0, 3])]).unwrap();
    let linear = Emitter::new(concave.clone(), Emission::gradient(1.5, DVec3::new(0.3, -0.4, 0.7))).unwrap();
    let constant = Emitter::new(concave.clone(), Emission::Constant(2.0)).unwrap();
    let cubic = Source::Polynomial { polygon: &concave, emission: &cubic };
    // The second normal puts part of the emitter below the horizon.
    for normal in [[0.1, 0.2, 0.9], [0.9, -0.3, 0.1]] {
        for source in [Source::Emitter(&constant), Source::Emitter(&linear), cubic] {
            let position = DVec3::new(0.25, -0.125, 0.5);
            let moved = Receiver::new(position, normal.into(), 1.0).unwrap();
            let enclosure = enclose_source(&moved, &source, &Request::digits(20)).unwrap();
            for axis in 0..3 {
                let expected = difference(position, normal, &source, axis);
                // Fourth-order differences with this step err by a few 2^-64, their rounding by an ulp.
                let error = enclosure.gradient[axis].error_of(expected);
                assert!(error < 4e-16, "{source:?} {normal:?} {axis}: {expected} {error:e}");
            }
        }
    }
}

#[test]
fn an_affine_polynomial_is_the_linear_emission() {
    let square = polygon(&[[0.0, 0.0, 2.0], [0.0, 1.0, 2.0], [1.0, 1.0, 2.0], [1.0, 0.0, 2.0]]);
    let emission = Polynomial::new(vec![(0.5, [0; 3]), (2.0, [1, 0, 0]), (-0.25, [0, 1, 0]), (0.125, [0, 0, 1])]).unwrap();
    let linear = Emitter::new(square.clone(), Emission::gradient(0.75, DVec3::new(2.0, -0.25, 0.0))).unwrap();
    let point = receiver([0.3, 0.1, 0.0], [0.2, 0.1, 1.0]);
    let one =
        enclose_source(&point, &Source::Polynomial { polygon: &square, emission: &emission }, &Request::digits(24)).unwrap();
    let other = enclose(&point, &linear, 24).unwrap();
    assert!(one.radiosity.overlaps(&other.radiosity));
    assert!((0..3).all(|axis| one.gradient[axis].overlaps(&other.gradient[axis])));
}

#[test]
fn nothing_is_seen_from_behind_in_the_plane_or_below_the_horizon() {
    let triangle = [[0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [1.0, 0.0, 1.0]];
    let emitter = Emitter::new(polygon(&triangle), Emission::Constant(1.0)).unwrap();
    for at in [
        receiver([0.2, 0.2, 2.0], [0.0, 0.0, -1.0]),
        receiver([0.2, 0.2, 1.0], [1.0, 0.0, -1.0]),
        receiver([0.0, 0.0, 1.0], [1.0, 0.0, 1.0]),
        receiver([0.2, 0.2, 0.0], [0.0, 0.0, -1.0]),
        receiver([0.0, 0.0, 1.0f64.next_up()], [0.0, 1.0, -1.0]),
    ] {
        let enclosure = enclose(&at, &emitter, 20).unwrap();
        assert_eq!(enclosure.radiosity.bounds(), (0.0, 0.0));
        assert!(enclosure.gradient.iter().all(|g| g.bounds() == (0.0, 0.0)));
    }
    let near = enclose(&receiver([0.2, 0.2, 1.0f64.next_down()], [0.1, 0.2, 1.0]), &emitter, 15).unwrap();
    assert!(near.radiosity.bounds().0 > 0.9, "one ulp before the emitter it fills the view: {:?}", near.radiosity.bounds());
}

#[test]
fn a_spent_budget_says_what_was_reached() {
    let (receiver, emitter, _) = points().swap_remove(0);
    let request = Request { budget: 200, ..Request::digits(20) };
    let error = enclose_source(&receiver, &Source::Emitter(&emitter), &request).unwrap_err();
    let Error::Budget { needed, allowed: 200, digits: 20, reached } = error else { panic!("{error}") };
    assert!(needed > 200 && reached.radiosity_radius.is_finite(), "{error}");
    assert!(matches!(enclose(&receiver, &emitter, 14), Err(Error::Digits { digits: 14, least: 15, .. })));
    assert!(matches!(enclose(&receiver, &emitter, 201), Err(Error::Digits { most: 200, .. })));
    let request = Request { arithmetic: Some(Arithmetic::DoubleDouble), ..Request::digits(25) };
    assert!(matches!(enclose_source(&receiver, &Source::Emitter(&emitter), &request), Err(Error::Digits { most: 24, .. })));
}

#[test]
fn two_hundred_digits_of_a_distant_triangle() {
    let emitter =
        Emitter::new(polygon(&[[0.0, 0.0, 40.0], [0.0, 1.0, 40.0], [1.0, 0.0, 40.0]]), Emission::Constant(1.0)).unwrap();
    let point = receiver([0.0; 3], [0.0, 0.0, 1.0]);
    let (coarse, fine) = (enclose(&point, &emitter, 20).unwrap(), enclose(&point, &emitter, 200).unwrap());
    assert!(coarse.radiosity.overlaps(&fine.radiosity));
    assert!(relative_radii(&fine).iter().all(|r| *r < 1e-199));
    assert!(fine.radiosity.to_decimal().unwrap().len() > 200);
}

#[cfg(feature = "mpfr")]
#[test]
fn astro_and_mpfr_agree_bit_for_bit() {
    for (receiver, emitter, point) in points().into_iter().step_by(3) {
        let [astro, mpfr] = [Arithmetic::Astro, Arithmetic::Mpfr].map(|arithmetic| {
            let request = Request { arithmetic: Some(arithmetic), ..Request::digits(30) };
            enclose_source(&receiver, &Source::Emitter(&emitter), &request).unwrap()
        });
        assert_eq!(astro.radiosity, mpfr.radiosity, "{}", point["id"]);
        assert_eq!(astro.gradient, mpfr.gradient, "{}", point["id"]);
        assert_eq!(astro.evaluations, mpfr.evaluations, "{}", point["id"]);
    }
}
