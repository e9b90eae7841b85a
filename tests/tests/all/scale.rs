//! A unit of length or of emission that is another power of two changes no digit; an answer that then leaves the range of a double
//! is an error that says so.

use glam::DVec3;
use radgrad_audit::cases::family::Family;
use radgrad_core::{
    Answer, DMat3, Emission, Emitter, Error, Hessian, Linear, Method, Polygon, Polynomial, Receiver, evaluate_digits,
    evaluate_to, gradient, hessian, hessian_to, irradiance_vector, radiosity, radiosity_and_gradient,
};
use radgrad_scene::case::Problem;
use radgrad_tests::decimal::Decimal;

/// A scene in another unit of length, and with another of emission.
fn scaled(receiver: &Receiver, emitter: &Emitter, lengths: i32, emission: i32) -> (Receiver, Emitter) {
    let length = |v: DVec3| back(v, -lengths);
    let value = |b: f64| libm::scalbn(b, emission);
    let slope = |v: DVec3| back(v, lengths - emission);
    let emission = match emitter.emission() {
        Emission::Constant(b) => Emission::Constant(value(*b)),
        Emission::Linear(Linear::AtVertices(values)) => Emission::at_vertices(values.iter().map(|b| value(*b)).collect()),
        Emission::Linear(Linear::Gradient { value: b, gradient }) => Emission::gradient(value(*b), slope(*gradient)),
        Emission::Polynomial(polynomial) => {
            let terms = polynomial.terms().iter().map(|term| {
                let degree: i32 = term.powers.iter().map(|p| i32::from(*p)).sum();
                (libm::scalbn(term.coefficient, emission - degree * lengths), term.powers)
            });
            Emission::Polynomial(Polynomial::new(length(polynomial.origin()), terms).unwrap())
        }
    };
    let receiver = Receiver::new(length(receiver.position()), receiver.direction(), receiver.reflectance()).unwrap();
    (receiver, Emitter::new(scaled_polygon(emitter.polygon(), lengths), emission).unwrap())
}

fn scaled_polygon(polygon: &Polygon, lengths: i32) -> Polygon {
    polygon.map(libm::scalbn(1.0, lengths), |v| back(v, -lengths)).unwrap()
}

/// A vector in a unit larger by so many powers of two.
fn back(v: DVec3, exponent: i32) -> DVec3 {
    v.to_array().map(|c| libm::scalbn(c, -exponent)).into()
}

/// The answer in the units it had before.
fn unscaled(answer: Answer, lengths: i32, emission: i32) -> Answer {
    let gradient = emission - lengths;
    Answer {
        radiosity: libm::scalbn(answer.radiosity, -emission),
        radiosity_error: libm::scalbn(answer.radiosity_error, -emission),
        gradient: back(answer.gradient, gradient),
        gradient_error: libm::scalbn(answer.gradient_error, -gradient),
        ..answer
    }
}

/// Lengths and emission, such that all results and bounds stay normal numbers.
const UNITS: [(i32, i32); 8] = [(-900, -600), (-900, 0), (-300, -100), (-37, 0), (41, 0), (300, 100), (900, 200), (900, 600)];

/// Cases of all families, some with a cubic emission, some past a screen.
fn cases() -> impl Iterator<Item = (String, Receiver, Emitter, Vec<Polygon>)> {
    // At extreme scales already, or with coefficients of powers of lengths that would be out of range.
    let families = Family::ALL.into_iter().filter(|family| {
        let is_scaled = matches!(family, Family::Scale | Family::ContactScale | Family::GrazingScale | Family::ScreenScale);
        let is_extreme = matches!(family, Family::Subnormal | Family::MixedExponents);
        !is_scaled && !is_extreme && !matches!(family, Family::PolynomialFar | Family::PolynomialClipped)
    });
    families.flat_map(|family| (0..12).map(move |index| (family, index))).filter_map(|(family, index)| {
        let Problem { receiver, emitter, .. } = family.case(17, index).problem().ok()?;
        let polygon = emitter.polygon().clone();
        let vertices = polygon.vertices();
        let emitter = if index % 4 == 1 {
            let terms = [(2.0, [0, 0, 0]), (0.5, [1, 0, 0]), (-0.25, [0, 2, 0]), (0.125, [1, 0, 2])];
            Emitter::new(polygon.clone(), Emission::Polynomial(Polynomial::new(vertices[0], terms).unwrap())).unwrap()
        } else {
            emitter
        };
        let x = receiver.position();
        // Smaller than the emitter seems, and across the view to it.
        let middle = (vertices[0] + vertices[1] + vertices[2]) / 3.0;
        let screen = [0.5, 0.6, 0.7].iter().zip(vertices).map(|(share, v)| x + (v.lerp(middle, 0.37) - x) * *share).collect();
        let screens = if index % 4 == 2 { Polygon::new(screen).into_iter().collect() } else { Vec::new() };
        Some((format!("{family}:17:{index}"), receiver, emitter, screens))
    })
}

#[test]
fn value_gradient_bounds_and_method_are_the_same_in_every_unit() {
    let (mut visible, mut past_screens) = (0, 0);
    for (number, (case, receiver, emitter, screens)) in cases().enumerate() {
        let tolerance = [1e-9, 1e-12, 1e-15][number % 3];
        let answer = evaluate_to(&receiver, &emitter, &screens, tolerance).unwrap();
        let plain = radiosity_and_gradient(&receiver, &emitter).unwrap();
        // The coefficients of a cubic are themselves in range.
        let widest = if let Emission::Polynomial(_) = emitter.emission() { 300 } else { 900 };
        for (lengths, emission) in UNITS.into_iter().filter(|(lengths, _)| lengths.abs() <= widest) {
            let case = format!("{case} times 2^{lengths}, emission times 2^{emission}");
            let (receiver, emitter) = scaled(&receiver, &emitter, lengths, emission);
            let screens: Vec<Polygon> = screens.iter().map(|screen| scaled_polygon(screen, lengths)).collect();
            let there = evaluate_to(&receiver, &emitter, &screens, tolerance).unwrap();
            let mut there = unscaled(there, lengths, emission);
            if case.starts_with("cancelling-values") {
                // Radii of many digits, as below.
                let bounds =
                    [(&mut there.radiosity_error, answer.radiosity_error), (&mut there.gradient_error, answer.gradient_error)];
                for (there, here) in bounds {
                    assert!((*there - here).abs() <= 1e-6 * here, "{case}: {there:e} for {here:e}");
                    *there = here;
                }
            }
            assert_eq!(there, answer, "{case}");
            let (value, slope) = radiosity_and_gradient(&receiver, &emitter).unwrap();
            assert_eq!((libm::scalbn(value, -emission), back(slope, emission - lengths)), plain, "{case}");
            let alone = (radiosity(&receiver, &emitter).unwrap(), gradient(&receiver, &emitter).unwrap());
            assert_eq!((value, slope), alone, "{case}");
            visible += usize::from(answer.method != Method::Zero);
            past_screens += usize::from(answer.method != Method::Zero && !screens.is_empty());
        }
    }
    assert!(visible > 1000 && past_screens > 100, "{visible} {past_screens}");
}

/// Subnormal coordinates have no smaller unit, and emission of 2^900 over numbers of 2^-900 no larger one.
#[test]
fn extreme_scenes_are_refused_in_units_that_take_them_out_of_range_and_answered_in_others() {
    let (mut same, mut repeated, mut beyond) = (0, 0, 0);
    for index in 0..40 {
        let Problem { receiver, emitter, .. } = Family::Subnormal.case(17, index).problem().unwrap();
        let vertices = |exponent: i32| emitter.polygon().vertices().iter().map(|v| back(*v, -exponent)).collect();
        assert!(matches!(Polygon::new(vertices(-400)), Err(Error::RepeatedVertex { .. })), "{index}");
        repeated += 1;
        let answer = evaluate_to(&receiver, &emitter, &[], 1e-12).unwrap();
        for lengths in [40, 300, 900] {
            let (receiver, emitter) = scaled(&receiver, &emitter, lengths, 0);
            let there = unscaled(evaluate_to(&receiver, &emitter, &[], 1e-12).unwrap(), lengths, 0);
            assert!((there.radiosity - answer.radiosity).abs() <= there.radiosity_error + answer.radiosity_error, "{index}");
            let apart = (there.gradient - answer.gradient).abs().max_element();
            assert!(apart <= there.gradient_error + answer.gradient_error, "{index}");
            same += usize::from(answer.method != Method::Zero);
        }
        let Problem { receiver, emitter, .. } = Family::MixedExponents.case(17, index).problem().unwrap();
        if let Emission::Constant(value) = emitter.emission() {
            let shift = if *value > 1.0 { 1030 } else { -1030 };
            let there = Emitter::new(emitter.polygon().clone(), Emission::Constant(libm::scalbn(*value, shift)));
            let is_refused = there.as_ref().map_or_else(
                |error| matches!(error, Error::EmissionNotFinite { .. }),
                |emitter| emitter.largest_emission() == 0.0,
            );
            let answer = there.and_then(|emitter| evaluate_to(&receiver, &emitter, &[], 1e-12));
            assert!(is_refused || matches!(answer, Err(Error::Overflow { .. } | Error::Underflow { .. })), "{index}: {answer:?}");
            beyond += 1;
        }
    }
    assert!(same > 60 && repeated == 40 && beyond > 5, "{same} {repeated} {beyond}");
}

#[test]
fn second_derivatives_and_the_irradiance_vector_are_the_same_in_every_unit() {
    for (case, receiver, emitter, _) in cases() {
        let Emission::Constant(_) = emitter.emission() else { continue };
        // A component of 1e-34 beside others of 1 consists of their roundings, and those of sums of subnormal products differ.
        if case.to_string().starts_with("steep-normal") {
            continue;
        }
        let here = hessian_to(&receiver, &emitter, &[], 1e-12).unwrap();
        let vector = irradiance_vector(&receiver, &emitter).unwrap();
        for (lengths, emission) in [(-900, -930), (-300, -100), (-37, 0), (300, 100), (900, 930)] {
            let (receiver, emitter) = scaled(&receiver, &emitter, lengths, emission);
            let there = hessian_to(&receiver, &emitter, &[], 1e-12).unwrap();
            let matrix = DMat3::from_cols_array(&there.matrix.to_cols_array().map(|c| libm::scalbn(c, 2 * lengths - emission)));
            let error = libm::scalbn(there.error, 2 * lengths - emission);
            // Radii of many digits are kept as coarse floats with an exponent, which rounds them at other places.
            assert!((error - here.error).abs() <= 1e-6 * here.error, "{case} times 2^{lengths}");
            assert_eq!(Hessian { matrix, error: here.error, ..there }, here, "{case} times 2^{lengths}");
            assert_eq!(back(irradiance_vector(&receiver, &emitter).unwrap(), emission), vector, "{case} times 2^{lengths}");
        }
    }
}

/// A triangle that shines down on the origin from a height of 2.
fn lamp(emission: f64) -> Emitter {
    let corners = [[-0.5, -0.5, 2.0], [0.25, 0.75, 2.25], [0.75, -0.25, 1.75]].map(DVec3::from);
    Emitter::new(Polygon::new(corners.to_vec()).unwrap(), Emission::Constant(emission)).unwrap()
}

fn floor() -> Receiver {
    Receiver::new(DVec3::ZERO, DVec3::new(0.1, 0.2, 1.0), 0.8).unwrap()
}

#[test]
fn what_is_too_small_for_a_double_is_an_error_and_what_is_not_meets_its_tolerance() {
    let whole = evaluate_digits(&floor(), &lamp(1.0), &[], 30).unwrap();
    let exact: Decimal = whole.radiosity.parse().unwrap();
    let (mut met, mut refused) = (0, 0);
    for tolerance in [1e-3, 1e-12, 1e-15] {
        for exponent in -1074..=-900 {
            let (receiver, emitter) = (floor(), lamp(libm::scalbn(1.0, exponent)));
            match evaluate_to(&receiver, &emitter, &[], tolerance) {
                Ok(answer) => {
                    assert!(answer.meets(tolerance), "2^{exponent} to {tolerance:e}: {answer:?}");
                    assert!(answer.radiosity >= f64::MIN_POSITIVE && answer.gradient.abs().max_element() >= f64::MIN_POSITIVE);
                    let error = exact.error_of(libm::scalbn(answer.radiosity, -exponent));
                    assert!(error <= libm::scalbn(answer.radiosity_error, -exponent), "2^{exponent}: {error:e}, {answer:?}");
                    assert!(radiosity(&receiver, &emitter).is_ok() && gradient(&receiver, &emitter).is_ok());
                    met += 1;
                }
                Err(error) => {
                    let Error::Underflow { quantity } = error else { panic!("{error}") };
                    let alone = match quantity {
                        "radiosity" => radiosity(&receiver, &emitter).map(|_| ()),
                        _ => gradient(&receiver, &emitter).map(|_| ()),
                    };
                    assert_eq!(alone, Err(error.clone()), "2^{exponent}");
                    assert_eq!(radiosity_and_gradient(&receiver, &emitter), Err(error), "2^{exponent}");
                    refused += 1;
                }
            }
        }
    }
    assert!(met > 300 && refused > 100, "{met} {refused}");
}

#[test]
fn the_value_is_not_lost_where_a_derivative_leaves_the_range() {
    for (lengths, over) in [(-700, true), (1000, false)] {
        // Emission of 2^400 from near by; of 2^-20 from a thousand times as far.
        let (receiver, emitter) = scaled(&floor(), &lamp(1.0), lengths, if over { 400 } else { -20 });
        let error = |quantity| if over { Error::Overflow { quantity } } else { Error::Underflow { quantity } };
        assert!(radiosity(&receiver, &emitter).unwrap() > 0.0);
        assert!(irradiance_vector(&receiver, &emitter).unwrap().z > 0.0);
        assert_eq!(gradient(&receiver, &emitter), Err(error("gradient")));
        assert_eq!(evaluate_to(&receiver, &emitter, &[], 1e-9), Err(error("gradient")));
        assert_eq!(hessian_to(&receiver, &emitter, &[], 1e-9), Err(error("Hessian")));
        assert_eq!(hessian(&receiver, &emitter), Err(error("Hessian")));
        let digits = evaluate_digits(&receiver, &emitter, &[], 20).unwrap();
        assert!(digits.gradient.iter().all(|c| c.contains('e')), "{digits:?}");
    }
    let message = Error::Underflow { quantity: "gradient" }.to_string();
    assert_eq!(message, "the gradient underflows: its magnitude is not 0 but below 2.2250738585072014e-308");
}

#[test]
fn however_far_the_emitter_the_answer_has_its_digits_or_is_an_error() {
    for exponent in (0..1000).step_by(25) {
        let distance = 2f64.powi(exponent);
        for emission in [Emission::Constant(1.0), Emission::at_vertices(vec![1.0, 2.0, 0.5])] {
            let corners = [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0]].map(|[x, y]| DVec3::new(x, y, distance));
            let emitter = Emitter::new(Polygon::new(corners.to_vec()).unwrap(), emission).unwrap();
            let (receiver, emitter) = scaled(&floor(), &emitter, 0, 600);
            let digits = evaluate_digits(&receiver, &emitter, &[], 20).unwrap();
            match evaluate_to(&receiver, &emitter, &[], 1e-12) {
                Ok(answer) => {
                    let value: f64 = digits.radiosity.parse().unwrap();
                    assert!(answer.meets(1e-12) && (answer.radiosity - value).abs() <= 1e-12 * value, "2^{exponent}: {answer:?}");
                }
                Err(Error::Underflow { quantity }) => {
                    let smallest = if quantity == "radiosity" { digits.radiosity } else { digits.gradient[2].clone() };
                    assert!(smallest.parse::<f64>().unwrap().abs() < f64::MIN_POSITIVE, "2^{exponent}: {quantity} {smallest}");
                }
                Err(error) => panic!("2^{exponent}: {error}"),
            }
        }
    }
}
