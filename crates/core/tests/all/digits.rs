//! Answers to many digits, against values known otherwise and against each other.
#![cfg(feature = "arbitrary-precision")]

use astro_float::{BigFloat, Consts, Radix, RoundingMode};
use radgrad_core::{
    DMat3, DVec3, Emission, Emitter, Error, MOST_DIGITS, Method, Polygon, PreciseAnswer, Receiver, effort, evaluate,
    evaluate_digits, evaluate_to,
};
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

/// Of an answer that many digits do not help.
const MOST_OPERATIONS: u64 = 1_000_000_000;

const BITS: usize = 2048;
const NEAREST: RoundingMode = RoundingMode::ToEven;

fn number(text: &str) -> BigFloat {
    let number = BigFloat::parse(text, Radix::Dec, BITS, NEAREST, &mut Consts::new().unwrap());
    assert!(!number.is_nan(), "{text}");
    number
}

fn sum(a: &BigFloat, b: &BigFloat) -> BigFloat {
    a.add(b, BITS, NEAREST)
}

fn difference(a: &BigFloat, b: &BigFloat) -> BigFloat {
    a.sub(b, BITS, NEAREST)
}

fn norm(v: &[BigFloat]) -> BigFloat {
    let squares = v.iter().fold(BigFloat::from_f64(0.0, BITS), |total, c| sum(&total, &c.mul(c, BITS, NEAREST)));
    squares.sqrt(BITS, NEAREST)
}

fn at_most(a: &BigFloat, b: &BigFloat) -> bool {
    a.cmp(b).is_some_and(|order| order <= 0)
}

fn gradient(answer: &PreciseAnswer) -> Vec<BigFloat> {
    answer.gradient.iter().map(|c| number(c)).collect()
}

/// Whether the bounds are as tight as was asked.
fn keeps_its_promise(answer: &PreciseAnswer, digits: u32) -> bool {
    let share = number(&format!("1e-{digits}"));
    let allowed = |size: &BigFloat| size.mul(&share, BITS, NEAREST);
    at_most(&number(&answer.radiosity_error), &allowed(&number(&answer.radiosity).abs()))
        && at_most(&number(&answer.gradient_error), &allowed(&norm(&gradient(answer))))
}

/// Whether value and gradient are within the sum of the bounds of each other.
fn agree(a: &PreciseAnswer, b: &PreciseAnswer) -> bool {
    let apart = difference(&number(&a.radiosity), &number(&b.radiosity)).abs();
    let turned: Vec<BigFloat> = gradient(a).iter().zip(gradient(b)).map(|(p, q)| difference(p, &q)).collect();
    at_most(&apart, &sum(&number(&a.radiosity_error), &number(&b.radiosity_error)))
        && at_most(&norm(&turned), &sum(&number(&a.gradient_error), &number(&b.gradient_error)))
}

fn polygon(points: &[[f64; 3]]) -> Polygon {
    Polygon::new(points.iter().map(|&p| p.into()).collect()).unwrap()
}

fn lamp(emission: Emission) -> Emitter {
    Emitter::new(polygon(&[[-0.9, 0.1, 1.2], [-0.1, 0.7, 1.3], [0.4, -0.9, 1.1]]), emission).unwrap()
}

fn linear() -> Emission {
    Emission::at_vertices(vec![1.0, 0.25, 2.5])
}

fn receiver(normal: [f64; 3]) -> Receiver {
    Receiver::new(DVec3::new(0.2, -0.1, 0.0), normal.into(), 0.7).unwrap()
}

const UP: [f64; 3] = [0.1, 0.2, 1.0];
const ASIDE: [f64; 3] = [1.0, -0.3, 0.1];

fn screens() -> [Polygon; 2] {
    [
        polygon(&[[-0.2, -0.3, 0.6], [0.1, 0.3, 0.6], [0.3, -0.2, 0.7]]),
        polygon(&[[-0.4, 0.1, 0.9], [-0.1, 0.2, 1.5], [0.0, 0.3, 0.8]]),
    ]
}

#[test]
fn the_corner_of_a_square_has_its_known_form_factor_to_a_hundred_digits() {
    // atan(1/sqrt 2) / (pi sqrt 2)
    let published =
        "0.138531605994892996780769708634475679730737394849014117310118299684577711776783544865953863908507945798889146788683";
    let square = polygon(&[[0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [1.0, 1.0, 1.0], [1.0, 0.0, 1.0]]);
    let corner = Receiver::new(DVec3::ZERO, DVec3::Z, 1.0).unwrap();
    let answer = evaluate_digits(&corner, &Emitter::new(square, Emission::Constant(1.0)).unwrap(), &[], 100).unwrap();
    let error = difference(&number(&answer.radiosity), &number(published)).abs();
    assert!(at_most(&error, &number(&answer.radiosity_error)) && at_most(&error, &number("1.4e-101")));
    assert!(keeps_its_promise(&answer, 100));
}

#[test]
fn answers_to_fewer_digits_are_those_to_more_within_their_bounds() {
    for normal in [UP, ASIDE] {
        for emission in [Emission::Constant(3.2), linear(), Emission::gradient(0.3, DVec3::new(0.5, -0.25, 0.125))] {
            for screens in [&screens()[..], &[]] {
                let (receiver, lamp) = (receiver(normal), lamp(emission.clone()));
                let answers: Vec<PreciseAnswer> = [1, 20, 50, 100, 330]
                    .into_iter()
                    .map(|digits| {
                        let answer = evaluate_digits(&receiver, &lamp, screens, digits).unwrap();
                        assert!(keeps_its_promise(&answer, digits), "{digits} digits: {answer:?}");
                        answer
                    })
                    .collect();
                for pair in answers.windows(2) {
                    assert!(agree(&pair[0], &pair[1]), "{pair:?}");
                }
            }
        }
    }
}

#[test]
fn doubles_are_within_their_bounds_of_the_digits() {
    for normal in [UP, ASIDE] {
        for emission in [Emission::Constant(3.2), linear()] {
            let (receiver, lamp) = (receiver(normal), lamp(emission));
            let exact = evaluate_digits(&receiver, &lamp, &screens(), 40).unwrap();
            for tolerance in [1e-3, 1e-12, 1e-15, 0.0] {
                let answer = evaluate_to(&receiver, &lamp, &screens(), tolerance).unwrap();
                let error = difference(&BigFloat::from_f64(answer.radiosity, BITS), &number(&exact.radiosity)).abs();
                assert!(at_most(&error, &BigFloat::from_f64(answer.radiosity_error, BITS)), "{answer:?}");
                let components = answer.gradient.to_array().into_iter().zip(gradient(&exact));
                let errors: Vec<BigFloat> = components.map(|(c, e)| difference(&BigFloat::from_f64(c, BITS), &e)).collect();
                assert!(at_most(&norm(&errors), &BigFloat::from_f64(answer.gradient_error, BITS)), "{answer:?}");
            }
        }
    }
}

#[test]
fn the_last_rung_gives_the_nearest_doubles() {
    // Beside a lamp in contact, where double-double is not enough for a linear emission.
    let lamp = Emitter::new(polygon(&[[0.0, 0.0, 1e-20], [0.0, 1.0, 1e-20], [1.0, 0.0, 1e-20]]), linear()).unwrap();
    assert!(lamp.polygon().normal().z < 0.0);
    let receiver = Receiver::new(DVec3::new(2.0, 0.3, 0.0), DVec3::new(-1.0, 0.1, 0.5), 0.5).unwrap();
    let exact = evaluate_digits(&receiver, &lamp, &[], 40).unwrap();
    let answer = evaluate_to(&receiver, &lamp, &[], 0.0).unwrap();
    assert_eq!(answer.method, Method::ArbitraryPrecision);
    assert_eq!(answer.radiosity, exact.radiosity.parse::<f64>().unwrap());
    assert_eq!(answer.gradient.to_array(), exact.gradient.clone().map(|c| c.parse().unwrap()));
    assert!(answer.meets(2f64.powi(-52)) && !answer.meets(0.0));
}

#[test]
fn hard_cases_meet_a_tight_tolerance_on_the_last_rung() {
    // A needle far away, grazing; a receiver in contact, next to an edge and clipped by its horizon.
    let needle = polygon(&[[1e7, 0.0, 1.0], [1e7, 1.0, 1.0 + 1e-9], [1e7, 0.5, 1.0 + 3e-8]]);
    let far = Receiver::new(DVec3::ZERO, DVec3::new(-1e-9, 0.0, 1.0), 1.0).unwrap();
    let touched = polygon(&[[0.0, 0.0, 1e-11], [0.0, 1.0, 1e-11], [1.0, 0.0, 1e-11]]);
    let near = Receiver::new(DVec3::new(1e-13, 0.3, 0.0), DVec3::new(-1.0, 1e-3, 1e-6), 0.5).unwrap();
    let facing = |polygon: Polygon, receiver: &Receiver| {
        let reversed = Polygon::new(polygon.vertices().iter().rev().copied().collect()).unwrap();
        let to_receiver = receiver.position() - polygon.vertices()[0];
        if polygon.normal().dot(to_receiver) > 0.0 { polygon } else { reversed }
    };
    let mut last_rung = 0;
    for (polygon, receiver) in [(needle, far), (touched, near)] {
        for emission in [Emission::Constant(1.0), linear()] {
            let lamp = Emitter::new(facing(polygon.clone(), &receiver), emission).unwrap();
            let answer = evaluate_to(&receiver, &lamp, &[], 1e-15).unwrap();
            assert!(answer.meets(1e-15) && answer.radiosity > 0.0, "{answer:?}");
            last_rung += usize::from(answer.method == Method::ArbitraryPrecision);
            assert!(keeps_its_promise(&evaluate_digits(&receiver, &lamp, &[], 60).unwrap(), 60));
        }
    }
    assert!(last_rung > 0);
}

#[test]
fn in_contact_inside_the_lamp_everything_above_the_horizon_is_lit() {
    // The projected solid angle of half a sphere cut at an angle t, over pi: (1 + cos t)/2, here with cos t = 1/sqrt 2.
    let expected = number("0.85355339059327376220042218105242451964241796884423701829416993450");
    for height in [1e-9, 1e-60, 1e-150] {
        let lamp = polygon(&[[0.0, 0.0, height], [0.3, 1.0, height], [1.0, 0.1, height]]);
        let lamp = Emitter::new(lamp, Emission::Constant(1.0)).unwrap();
        let receiver = Receiver::new(DVec3::new(0.4, 0.3, 0.0), DVec3::new(0.0, 1.0, 1.0), 1.0).unwrap();
        let near = difference(&number(&evaluate_digits(&receiver, &lamp, &[], 50).unwrap().radiosity), &expected).abs();
        assert!(at_most(&near, &number(&format!("{}", height * 20.0 + 1e-50))), "{height}");
        let answer = evaluate_to(&receiver, &lamp, &[], 1e-6).unwrap();
        assert!((answer.radiosity - 0.853_553_390_593_273_8).abs() <= 1e-7, "{answer:?}");
    }
}

#[test]
fn straight_below_a_vertex_and_an_edge_of_a_linear_lamp_digits_are_to_be_had() {
    let lamp = Emitter::new(polygon(&[[0.0, 0.0, 0.1], [0.0, 1.0, 0.1], [1.0, 0.5, 0.1]]), linear()).unwrap();
    assert!(lamp.polygon().normal().z < 0.0);
    for position in [[0.0, 0.0], [0.0, 0.5], [0.5, 0.25], [0.0, 2.0]] {
        let [x, y] = position;
        let receiver = |x: f64| Receiver::new(DVec3::new(x, y, 0.0), DVec3::new(0.1, -0.2, 1.0), 1.0).unwrap();
        let answer = evaluate_digits(&receiver(x), &lamp, &[], 60).unwrap();
        assert!(keeps_its_promise(&answer, 60));
        // The value is continuous: a step of 1e-40 aside changes it by about that.
        let aside = evaluate_digits(&receiver(x + 1e-40), &lamp, &[], 60).unwrap();
        let change = difference(&number(&answer.radiosity), &number(&aside.radiosity)).abs();
        assert!(at_most(&change, &number("1e-37")), "{position:?}");
        let rough = evaluate_to(&receiver(x), &lamp, &[], 1e-12).unwrap();
        assert!(rough.meets(1e-12) && rough.method != Method::ArbitraryPrecision, "{rough:?}");
    }
}

#[test]
fn a_power_of_two_scales_the_digits_exactly() {
    let scaled = |exponent: i32| {
        let power = 2f64.powi(exponent);
        let by = |polygon: &Polygon| Polygon::new(polygon.vertices().iter().map(|&v| v * power).collect()).unwrap();
        let lamp = lamp(linear());
        let lamp = Emitter::new(by(lamp.polygon()), linear()).unwrap();
        let receiver = Receiver::new(receiver(ASIDE).position() * power, ASIDE.into(), 0.7).unwrap();
        evaluate_digits(&receiver, &lamp, &screens().each_ref().map(by), 50).unwrap()
    };
    let answer = scaled(0);
    for exponent in [-300, 300, 900] {
        let other = scaled(exponent);
        assert_eq!((&other.radiosity, &other.radiosity_error), (&answer.radiosity, &answer.radiosity_error));
        let power = BigFloat::from_f64(2f64.powi(exponent), BITS);
        let turned: Vec<BigFloat> =
            gradient(&answer).iter().zip(gradient(&other)).map(|(a, b)| difference(a, &b.mul(&power, BITS, NEAREST))).collect();
        assert!(at_most(&norm(&turned), &norm(&gradient(&answer)).mul(&number("2e-50"), BITS, NEAREST)), "{exponent}");
    }
}

#[test]
fn four_vertices_exactly_in_one_plane_have_all_digits_and_others_say_that_they_have_not() {
    // A plane with coefficients that are sums of few powers of two, and emission by an affine function of that kind.
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.5, 1.0], [-1.0, 0.5]];
    let lifted = |height: f64| {
        let vertices = corners.map(|[x, y]| DVec3::new(x, y, 2.0 + 0.25 * x - 0.125 * y));
        let mut vertices: Vec<DVec3> = vertices.into_iter().rev().collect();
        vertices[0].z += height;
        let values = vertices.iter().map(|v| 1.0 + 0.5 * v.x + 0.25 * v.y).collect();
        Emitter::new(Polygon::new(vertices).unwrap(), Emission::at_vertices(values)).unwrap()
    };
    let receiver = Receiver::new(DVec3::new(0.2, -0.1, 0.0), UP.into(), 1.0).unwrap();
    assert!(keeps_its_promise(&evaluate_digits(&receiver, &lifted(0.0), &[], 200).unwrap(), 200));
    let warped = lifted(f64::EPSILON);
    assert!(keeps_its_promise(&evaluate_digits(&receiver, &warped, &[], 12).unwrap(), 12));
    assert!(matches!(evaluate_digits(&receiver, &warped, &[], 30), Err(Error::Undecided { digits: 30, .. })));
}

#[test]
fn what_is_dark_is_exactly_zero_and_what_cannot_be_told_is_an_error() {
    let lamp = lamp(Emission::Constant(1.0));
    let below = Receiver::new(DVec3::new(0.2, -0.1, 0.0), DVec3::NEG_Z, 1.0).unwrap();
    let dark = evaluate_digits(&below, &lamp, &[], 1000).unwrap();
    assert_eq!((dark.radiosity.as_str(), dark.radiosity_error.as_str(), dark.gradient[2].as_str()), ("0", "0", "0"));
    // Two screens that meet along a line of which their edges are different parts.
    let half = |x: [f64; 2], y: [f64; 2]| polygon(&[[x[0], y[0], 0.5], [x[1], y[0], 0.5], [x[1], y[1], 0.5], [x[0], y[1], 0.5]]);
    let screens = [half([-9.0, 0.15], [-9.0, 9.0]), half([0.15, 9.0], [-8.0, 8.0])];
    assert_eq!(evaluate_digits(&receiver(UP), &lamp, &screens, 5).unwrap().radiosity_error, "0");
    // A screen whose edges are seen in line with the lamp's: moved by a hair it lets light past, and nothing says on which side.
    let square = |half: f64, z: f64| polygon(&[[-half, -half, z], [-half, half, z], [half, half, z], [half, -half, z]]);
    let level = Receiver::new(DVec3::ZERO, DVec3::new(0.1, 0.2, 1.0), 0.7).unwrap();
    let hidden = evaluate_digits(&level, &Emitter::new(square(1.0, 4.0), linear_ramp()).unwrap(), &[square(0.5, 2.0)], 5);
    assert!(matches!(hidden, Err(Error::Undecided { digits: 5, .. })), "{hidden:?}");
    assert!(hidden.unwrap_err().to_string().contains("5 digits are out of reach"));
}

fn linear_ramp() -> Emission {
    Emission::gradient(1.0, DVec3::new(0.25, 0.0, 0.0))
}

#[test]
fn a_number_of_digits_that_is_not_served_is_refused() {
    for digits in [0, MOST_DIGITS + 1] {
        let refused = evaluate_digits(&receiver(UP), &lamp(linear()), &[], digits);
        assert_eq!(refused, Err(Error::Digits { value: digits, most: MOST_DIGITS }));
    }
    let thousand = evaluate_digits(&receiver(UP), &lamp(Emission::Constant(1.0)), &[], MOST_DIGITS).unwrap();
    assert!(thousand.radiosity.len() > 1000 && thousand.bits >= 3322);
}

/// Emission that is odd over a square above a receiver in the middle: nothing is left of the value, all of the gradient.
#[test]
fn what_cancels_by_symmetry_is_zero_within_next_to_nothing_and_soon() {
    let corners = [[-1.0, -1.0, 1.0], [-1.0, 1.0, 1.0], [1.0, 1.0, 1.0], [1.0, -1.0, 1.0]].map(DVec3::from);
    let square = Polygon::new(corners.to_vec()).unwrap();
    let odd = Emitter::new(square, Emission::gradient(-1.0, DVec3::X)).unwrap();
    let receiver = Receiver::new(DVec3::new(0.0, 0.2, 0.0), DVec3::Z, 1.0).unwrap();
    // With all the bits it took 25 s, and 1e11 operations.
    let (answer, operations) = effort::within(MOST_OPERATIONS, || evaluate(&receiver, &odd, &[]).unwrap());
    let answer = answer.unwrap_or_else(|| panic!("{operations} operations"));
    assert!(answer.radiosity == 0.0 && answer.radiosity_error < 1e-100 && answer.gradient.x > 0.1, "{answer:?}");
    for digits in [10, 50, 200] {
        let answer = evaluate_digits(&receiver, &odd, &[], digits).unwrap();
        assert_eq!(answer.radiosity, "0");
        assert!(answer.radiosity_error.parse::<f64>().unwrap() < 1e-100 && answer.bits <= 2048, "{answer:?}");
        assert!(answer.gradient[0].len() > digits as usize && answer.gradient_error.parse::<f64>().unwrap() > 0.0, "{answer:?}");
    }
}

/// Six hundred vertices of a lamp in contact at 1e-300: more bits than would be found in a few seconds.
#[test]
fn what_costs_much_takes_no_more_than_is_allowed() {
    let count = 600;
    let vertex = |i: i32| {
        let turn = std::f64::consts::TAU * f64::from(i) / f64::from(count);
        DVec3::new(libm::cos(turn), -libm::sin(turn), 0.0)
    };
    let disc = Polygon::new((0..count).map(vertex).collect()).unwrap();
    let lamp = Emitter::new(disc, Emission::gradient(1e-280, DVec3::new(1.0, 0.5, 0.0))).unwrap();
    let receiver = Receiver::new(DVec3::new(0.0, 0.0, -1e-300), DVec3::new(1.0, 1e-290, 1e-300), 1.0).unwrap();
    // As much as there may be for an answer, and two thousandth parts more for doubles; and where less is allowed it takes less.
    for limit in [16_032_000_000, MOST_OPERATIONS] {
        let (answer, operations) = effort::within(limit, || evaluate_to(&receiver, &lamp, &[], 1e-15).unwrap());
        let answer = answer.unwrap_or_else(|| panic!("{operations} operations of {limit}"));
        assert!(answer.radiosity_error.is_finite(), "{operations} operations: {answer:?}");
    }
}

/// Walls that stand on the receiver's floor, touch it with a corner, or go through it: exactly in its plane, or where rounding has put
/// them.
#[test]
fn walls_on_the_floor_of_the_receiver_have_all_digits() {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let cases: usize = std::env::var("RADGRAD_WALL_CASES").map_or(96, |count| count.parse().unwrap());
    let mut shaded = 0;
    for case in 0..cases {
        let mut tenth = |low: i32, high: i32| f64::from(random.random_range(low..=high));
        let lamp = [(); 3].map(|()| DVec3::new(tenth(-40, 40), tenth(-40, 40), tenth(-15, 45)));
        let (p, q) = (DVec3::new(tenth(-10, 10), tenth(-10, 10), 0.0), DVec3::new(tenth(-10, 10), tenth(-10, 10), 0.0));
        let (up, down) = (DVec3::Z * tenth(1, 6), DVec3::Z * tenth(1, 6));
        let r = DVec3::new(tenth(-10, 10), tenth(-10, 10), 0.0);
        let wall = match case % 4 {
            0 => vec![p, q, q + up, p + up],
            1 => vec![p, q + up, p + up],
            2 => vec![p, q, (p + q) * 0.5 + up + DVec3::X],
            _ => vec![p - down, q - down, q + up, p + up],
        };
        // Whole numbers, turned exactly; or tenths, turned as rounding lets it.
        let turn = DMat3::from_axis_angle(DVec3::new(tenth(-9, 9), tenth(-9, 9), 1.0).normalize(), tenth(1, 30) * 0.1);
        let exact = DMat3::from_cols(DVec3::new(3.0, 4.0, 0.0), DVec3::new(-4.0, 3.0, 0.0), DVec3::Z * 5.0);
        let exact = exact * DMat3::from_cols(DVec3::new(5.0, 0.0, 12.0), DVec3::Y * 13.0, DVec3::new(-12.0, 0.0, 5.0));
        let place = |v: DVec3| match case / 4 % 3 {
            0 => v * 0.1,
            1 => exact * v,
            _ => turn * (v * 0.1),
        };
        let polygon = |vertices: &[DVec3]| Polygon::new(vertices.iter().map(|v| place(*v)).collect());
        let (Ok(lamp), Ok(wall)) = (polygon(&lamp), polygon(&wall)) else { continue };
        // One that stands beside it, every other time.
        let beside = if case / 12 % 2 == 0 { None } else { polygon(&[q, r, r + up, q + up]).ok() };
        let walls: Vec<&Polygon> = std::iter::once(&wall).chain(&beside).collect();
        // The shadow of a wall that is not flat depends on the choice of its surface where it meets the lamp's plane, or is seen
        // edge-on.
        let height = |v: &DVec3| lamp.normal().dot(*v - lamp.vertices()[0]);
        let is_open = |wall: &&Polygon| {
            let heights = || wall.vertices().iter().map(height);
            let is_edge_on = wall.normal().dot(wall.vertices()[0]).abs() < 1e-9;
            let is_met = heights().any(|h| h > -1e-9) && heights().any(|h| h < 1e-9);
            wall.planarity_defect() > 0.0 && (is_met || is_edge_on)
        };
        if walls.iter().any(is_open) {
            continue;
        }
        let receiver = Receiver::new(DVec3::ZERO, place(DVec3::Z), 1.0).unwrap();
        let emission = if case / 24 % 2 == 0 { Emission::Constant(1.0) } else { Emission::at_vertices(vec![1.0, 2.0, 4.0]) };
        let lamp = Emitter::new(lamp, emission).unwrap();
        let digits = evaluate_digits(&receiver, &lamp, walls.iter().copied(), 50);
        let digits = digits.unwrap_or_else(|error| panic!("case {case}: {error}, {lamp:?}, {walls:?}"));
        let answer = evaluate(&receiver, &lamp, walls).unwrap();
        let truth: f64 = digits.radiosity.parse().unwrap();
        assert!(
            (answer.radiosity - truth).abs() <= answer.radiosity_error + 1e-16 * truth,
            "case {case}: {answer:?}, {digits:?}"
        );
        let slope = DVec3::from([0, 1, 2].map(|axis| digits.gradient[axis].parse::<f64>().unwrap()));
        let error = (answer.gradient - slope).length();
        assert!(error <= answer.gradient_error + 1e-15 * slope.length(), "case {case}: {answer:?}, {digits:?}");
        shaded += usize::from(truth < 0.999 * evaluate(&receiver, &lamp, []).unwrap().radiosity);
    }
    assert!(shaded * 20 > cases, "{shaded} of {cases}");
}
