//! Every kind of wrong line is refused with its place, and costs no other line.

use super::*;

const VALID: &str = r#"{"id":"a1","receiver":{"position":[0,0,0],"normal":[0,0,1]},"emitter":{"vertices":[[0,0,1],[0,1,1],[1,0,1]],"emission":{"constant":2}}}"#;

/// The valid line with one part replaced.
fn with(part: &str, replacement: &str) -> String {
    assert!(VALID.contains(part), "{part}");
    VALID.replacen(part, replacement, 1)
}

/// The answer to a line, in doubles.
fn doubles(line: &str) -> AnswerRecord {
    match Line::read(1, line.as_bytes()).unwrap().unwrap().answer() {
        Ok(Reply::Doubles(answer)) => answer,
        other => panic!("{other:?}"),
    }
}

fn problem(line: &str) -> Result<Problem, Error> {
    Case::from_json(line.as_bytes())?.problem()
}

#[test]
fn defaults_are_those_of_the_interface() {
    let case = Case::from_json(VALID.as_bytes()).unwrap();
    assert_eq!((case.receiver.reflectance, case.tolerance, case.occluders.len()), (1.0, 1e-12, 0));
    assert_eq!(case.id, Id::from("a1"));
}

#[test]
fn unknown_fields_are_refused_at_every_depth_but_for_remarks() {
    let remarks = r#""truth":{"radiosity":"0.1","gradient":[null]},"family":7,"comment":"x","receiver":{"#;
    assert_eq!(problem(&with(r#""receiver":{"#, remarks)).unwrap(), problem(VALID).unwrap());
    for (part, other, said) in [
        (r#""receiver":{"#, r#""ocluders":[],"receiver":{"#, "no field `ocluders`: did you mean `occluders`?"),
        (r#""receiver":{"#, r#""occluder":[],"receiver":{"#, "no field `occluder`: did you mean `occluders`?"),
        (r#""receiver":{"#, r#""receiver":{"reflectanse":0.5,"#, "no field `reflectanse`: did you mean `reflectance`?"),
        (r#""emission":{"#, r#""comment":1,"emission":{"#, "no field `comment`: there are `vertices`, `emission`"),
        (r#"{"constant":2}"#, r#"{"constant":2,"unit":"W/m2"}"#, "no field `unit`"),
    ] {
        let error = problem(&with(part, other)).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
}

#[test]
fn a_mark_before_the_first_line_is_passed_over() {
    let marked = ["\u{feff}", VALID, "\r\n"].concat();
    assert!(Line::read(1, marked.as_bytes()).unwrap().is_ok());
    assert!(Line::read(2, marked.as_bytes()).unwrap().is_err());
}

#[test]
fn the_three_emissions_are_read() {
    let emission = |text: &str| problem(&with(r#"{"constant":2}"#, text)).unwrap().emitter.emission().clone();
    assert_eq!(emission(r#"{"constant":-2.5}"#), Emission::Constant(-2.5));
    assert_eq!(emission(r#"{"vertices":[1,2,4]}"#), Emission::at_vertices(vec![1.0, 2.0, 4.0]));
    assert_eq!(emission(r#"{"value":1,"gradient":[0.5,3,7]}"#), Emission::gradient(1.0, DVec3::new(0.5, 3.0, 7.0)));
}

#[test]
fn a_precision_is_that_of_emitter_and_occluders() {
    let warped = |z: f64| format!("[[0,0,{z}],[0,1,{z}],[1,1,{}],[1,0,{z}]]", z + 1e-7);
    let line = |precision: &str| {
        let text = format!(
            r#"{{"id":1,"receiver":{{"position":[0,0,0],"normal":[0,0,1]}},
            "emitter":{{"vertices":{},"emission":{{"constant":1}}}},"occluders":[{}]{precision}}}"#,
            warped(1.0),
            warped(0.5)
        );
        Case::from_json(text.as_bytes()).unwrap()
    };
    let problem = line(r#","precision":1e-7"#).problem().unwrap();
    assert_eq!([problem.emitter.polygon(), &problem.occluders[0]].map(Polygon::precision), [1e-7; 2]);
    assert!(matches!(line("").problem(), Err(Error::Emitter(radgrad_core::Error::NotPlanar { .. }))));
    let message = line(r#","precision":-1"#).problem().unwrap_err().to_string();
    assert!(message.contains("precision is -1"), "{message}");
}

#[test]
fn doubles_survive_writing_and_reading_bit_for_bit() {
    // Awkward on purpose: subnormals, the ends of the range, a halfway case of decimal conversion, negative zero.
    let awkward =
        [5e-324, f64::MAX, -f64::MIN_POSITIVE, 2.225073858507201e-308, 0.1 + 0.2, -0.0, 9007199254740993.0, 1.0 / 3.0, 1e23];
    let case = Case {
        id: Id::Number(7.into()),
        receiver: ReceiverRecord {
            position: [awkward[0], awkward[1], awkward[2]],
            normal: [awkward[3], awkward[4], awkward[5]],
            reflectance: awkward[7],
        },
        emitter: EmitterRecord {
            vertices: vec![[awkward[6]; 3], [awkward[8]; 3]],
            emission: EmissionRecord::Gradient { value: awkward[8], gradient: [awkward[4], awkward[5], awkward[0]] },
        },
        occluders: vec![vec![[awkward[7]; 3]]],
        tolerance: 1e-300,
        precision: 5e-324,
    };
    let text = serde_json::to_string(&case).unwrap();
    let again = Case::from_json(text.as_bytes()).unwrap();
    assert_eq!(again, case);
    assert_eq!(serde_json::to_string(&again).unwrap(), text);
    assert!(again.receiver.normal[2].is_sign_negative());
}

#[test]
fn wrong_json_names_the_column_and_the_rule() {
    let refused = |line: &str, expected: &str| {
        let message = problem(line).unwrap_err().to_string();
        assert!(message.starts_with("column ") && message.contains(expected), "{line}\n{message}");
        assert!(!message.contains("line 1"), "{message}");
    };
    refused("nonsense", "expected");
    refused(&VALID[..VALID.len() - 5], "EOF");
    refused(&format!("{VALID} {{}}"), "trailing");
    refused("[1,2,3]", "expected a receiver");
    refused("null", "a case");
    refused(&with("[0,0,0]", "[1e999,0,0]"), "number out of range");
    refused(&with("[0,0,0]", "[NaN,0,0]"), "expected value");
    refused(&with("[0,0,0]", "[Infinity,0,0]"), "expected value");
    refused(&with("[0,0,0]", "[null,0,0]"), "null");
    refused(&with("[0,0,0]", "[0,0]"), "invalid length 2, expected three coordinates [x, y, z]");
    refused(&with("[0,0,0]", "[0,0,0,0]"), "invalid length 4, expected three coordinates [x, y, z]");
    refused(&with("[0,0,0]", r#"["0",0,0]"#), "string");
    refused(&with(r#""id":"a1""#, r#""id":null"#), "`id` must be a string or a number");
    refused(&with(r#""id":"a1""#, r#""id":"a1","id":"a2""#), "duplicate field `id`");
    refused(&with(r#","normal":[0,0,1]"#, ""), "missing field `normal`");
    refused(&with(r#","emission":{"constant":2}"#, ""), "missing field `emission`");
    refused(&with(r#"{"constant":2}"#, "2"), "an emission");
    refused(&with(r#"{"constant":2}"#, "{}"), "exactly one of");
    refused(&with(r#"{"constant":2}"#, r#"{"constant":null}"#), "exactly one of");
    refused(&with(r#"{"constant":2}"#, r#"{"constant":2,"vertices":[1,2,4]}"#), "exactly one of");
    refused(&with(r#"{"constant":2}"#, r#"{"value":2}"#), "exactly one of");
    refused(&with(r#"{"constant":2}"#, r#"{"polynomial":{"terms":[]}}"#), "missing field `origin`");
    let steep = r#"{"polynomial":{"origin":[0,0,0],"terms":[{"coefficient":1,"powers":[200,99,0]}]}}"#;
    let line = Line::read(3, with(r#"{"constant":2}"#, steep).as_bytes()).unwrap().unwrap();
    assert!(line.answer().unwrap_err().error.to_string().contains("degree 299"));
    refused(&with(r#""id":"a1","#, r#""id":"a1","occluders":[[0,0,0]],"#), "expected three coordinates");
}

#[test]
fn wrong_values_name_their_place() {
    let refused = |line: &str, expected: &str| assert_eq!(problem(line).unwrap_err().to_string(), expected, "{line}");
    refused(&with("[0,0,1]}", "[0,0,0]}"), "receiver normal is [0, 0, 0]: it must be finite and not zero");
    refused(&with("[0,0,1]}", r#"[0,0,1],"reflectance":1.5}"#), "reflectance is 1.5: it must be between 0 and 1");
    refused(&with("[0,0,1]}", r#"[0,0,1],"reflectance":-0.1}"#), "reflectance is -0.1: it must be between 0 and 1");
    refused(&with(",[1,0,1]", ""), "emitter: a polygon needs at least 3 vertices, this one has 2");
    refused(&with("[1,0,1]", "[0,1,1]"), "emitter: vertices 1 and 2 are the same point [0, 1, 1]: leave one out");
    refused(
        &with(r#"{"constant":2}"#, r#"{"vertices":[1,2]}"#),
        "emitter: emission has 2 values for 3 vertices: give one per vertex",
    );
    for tolerance in ["-1e-12", "1.5"] {
        let value: f64 = tolerance.parse().unwrap();
        refused(
            &with(r#""id":"a1","#, &format!(r#""id":"a1","tolerance":{tolerance},"#)),
            &format!("tolerance is {value}: it must be a relative error between 0 and 1"),
        );
    }
    let occluders = r#""occluders":[[[0,0,0],[1,0,0],[0,1,0]],[[0,0,0],[1,1,1],[2,2,2]]],"#;
    refused(
        &with(r#""id":"a1","#, &format!(r#""id":"a1",{occluders}"#)),
        "occluder 1: the polygon has no area: all 3 vertices are on one line",
    );
}

#[test]
fn a_tolerance_that_is_not_a_number_is_refused() {
    let case = Case { tolerance: f64::NAN, ..Case::from_json(VALID.as_bytes()).unwrap() };
    assert!(matches!(case.problem(), Err(Error::Tolerance(radgrad_core::Error::Tolerance { .. }))));
}

#[test]
fn a_bad_line_costs_no_other_and_keeps_its_place() {
    let file =
        [VALID.as_bytes(), b"  \r", br#"{"id":42,"receiver":{"position":[NaN"#, b"\xff\xfe", with("a1", "last").as_bytes()]
            .join(&b'\n');
    let read: Vec<_> = read(file.as_slice()).map(Result::unwrap).collect();
    let [Ok(first), Err(named), Err(nameless), Ok(last)] = read.as_slice() else { panic!("{read:?}") };
    assert_eq!((first.number, &first.case.id), (1, &Id::from("a1")));
    assert_eq!((named.line, &named.id), (3, &Some(Id::Number(42.into()))));
    assert_eq!((nameless.line, &nameless.id), (4, &None));
    assert_eq!((last.number, &last.case.id), (5, &Id::from("last")));
}

#[test]
fn a_line_without_id_has_its_number_as_one() {
    let line = Line::read(7, with(r#""id":"a1","#, "").as_bytes()).unwrap().unwrap();
    assert_eq!(line.case.id, Id::Number(7.into()));
}

#[test]
fn an_answer_is_that_of_core_to_the_tolerance_of_the_case() {
    // Far away, where a loose tolerance is met by double precision and a tight one is not.
    let far = with("[0,0,0]", "[0,0,-1e6]");
    let answer = |tolerance: &str| {
        let line = far.replacen('{', &format!("{{\"tolerance\":{tolerance},"), 1);
        let line = Line::read(3, line.as_bytes()).unwrap().unwrap();
        let Problem { receiver, emitter, occluders, tolerance } = line.case.problem().unwrap();
        let expected = radgrad_core::evaluate_to(&receiver, &emitter, &occluders, tolerance).unwrap();
        assert_eq!(line.answer().unwrap(), Reply::Doubles(AnswerRecord::new(Id::from("a1"), &expected)));
        expected.radiosity_error
    };
    assert!(answer("1e-15") < 0.2 * answer("1"));
}

#[test]
fn a_polynomial_of_degree_one_is_the_affine_function() {
    let answer = |emission: &str| doubles(&with(r#"{"constant":2}"#, emission));
    let affine = answer(r#"{"value":2,"gradient":[0.5,0,0]}"#);
    let polynomial = answer(
        r#"{"polynomial":{"origin":[0,0,1],"terms":[{"coefficient":2,"powers":[0,0,0]},{"coefficient":0.5,"powers":[1,0,0]}]}}"#,
    );
    assert!((affine.radiosity - polynomial.radiosity).abs() <= affine.radiosity_error + polynomial.radiosity_error);
    assert!(affine.radiosity > 0.0);
}

#[test]
fn a_refusal_keeps_the_id_and_the_line() {
    let line = Line::read(9, with("[0,0,1]}", "[0,0,0]}").as_bytes()).unwrap().unwrap();
    let refusal = line.answer().unwrap_err();
    assert_eq!((refusal.id, refusal.line), (Some(Id::from("a1")), 9));
    assert_eq!(Line::read(1, b" \t\r\n"), None);
}

/// A line that asks for more than doubles.
fn asking(what: &str) -> Result<Reply, Error> {
    let line = with(r#""id":"a1","#, &format!(r#""id":"a1",{what},"#));
    Line::read(1, line.as_bytes()).unwrap().map_err(|refusal| refusal.error)?.answer().map_err(|refusal| refusal.error)
}

#[test]
fn digits_are_decimal_strings_with_bounds_that_enclose_the_doubles() {
    let Ok(Reply::Digits(answer)) = asking(r#""digits":50"#) else { panic!() };
    let near = doubles(VALID);
    assert!(answer.radiosity.len() > 50 && answer.digits == 50 && answer.method == "arbitrary-precision");
    let [value, error] = [&answer.radiosity, &answer.radiosity_error].map(|text| text.parse::<f64>().unwrap());
    assert!((value - near.radiosity).abs() <= near.radiosity_error && error <= 1e-50 * value);
    for (digits, double) in answer.gradient.iter().zip(near.gradient) {
        assert!((digits.parse::<f64>().unwrap() - double).abs() <= near.gradient_error);
    }
    let text = serde_json::to_string(&Reply::Digits(answer)).unwrap();
    assert!(text.contains(r#""digits":50"#) && text.contains(r#""radiosity":""#), "{text}");
}

#[test]
fn a_tolerance_finer_than_doubles_asks_for_digits() {
    let said = |what: &str| asking(what).unwrap_err().to_string();
    assert_eq!(
        said(r#""tolerance":1e-100"#),
        "tolerance is 1e-100: doubles are rounded by 1.1e-16 of themselves, so ask for decimal digits, \"digits\": 100"
    );
    assert!(asking(r#""tolerance":1e-40,"digits":40"#).is_ok() && asking(r#""tolerance":0"#).is_ok());
    assert_eq!(said(r#""tolerance":1e-40,"digits":39"#), "39 digits do not meet the tolerance of 1e-40: leave one of them out");
    assert!(said(r#""digits":0"#).contains("it must be between 1 and 1000"));
    assert_eq!(said(r#""digits":20,"hessian":true"#), "digits and hessian do not go together: ask for one of them");
    assert!(said(r#""digits":-1"#).contains("invalid value"));
}

#[test]
fn a_hessian_is_that_of_core_and_stands_there_only_if_it_was_asked_for() {
    let Ok(Reply::Doubles(answer)) = asking(r#""hessian":true"#) else { panic!() };
    let Problem { receiver, emitter, occluders, tolerance } = problem(VALID).unwrap();
    let expected = radgrad_core::hessian_to(&receiver, &emitter, &occluders, tolerance).unwrap();
    assert_eq!((answer.hessian, answer.hessian_error), (Some(expected.matrix.to_cols_array_2d()), Some(expected.error)));
    assert!(!serde_json::to_string(&doubles(VALID)).unwrap().contains("hessian"));
}

#[test]
fn an_expression_is_answered_with_an_estimate_and_never_a_bound() {
    let line = with(r#"{"constant":2}"#, r#"{"expression":"2 + 0*x"}"#);
    let reply = Line::read(1, line.as_bytes()).unwrap().unwrap().answer().unwrap();
    let Reply::Estimate(found) = &reply else { panic!("{reply:?}") };
    let even = doubles(VALID);
    assert!(found.converged && (found.radiosity - even.radiosity).abs() <= 1e-12 * even.radiosity, "{found:?} {even:?}");
    let text = serde_json::to_string(&reply).unwrap();
    assert!(text.contains("radiosity_estimate") && !text.contains("_error"), "{text}");
    let line = with(r#"{"constant":2}"#, r#"{"expression":"2 +"}"#);
    let error = Line::read(1, line.as_bytes()).unwrap().unwrap().answer().unwrap_err().error.to_string();
    assert_eq!(error, "emission: column 4 of the expression: expected a number, a name or `(`, found its end");
    assert!(problem(&line).is_err(), "it is no problem for the closed forms");
}
