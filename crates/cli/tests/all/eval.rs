//! `radgrad eval` as a user or another program sees it: text in, text out, an exit status.

use std::io::{BufRead, BufReader, Write};
use std::process::{Command, Output, Stdio};

use radgrad_scene::case::{Case, Problem};
use serde_json::Value;

/// A unit square at height 1 with a corner over the receiver, whose point factor is Howell's B-3 with a = b = c:
/// `atan(1/sqrt 2) / (sqrt 2 pi)`.
const CORNER: &str = r#"{"id":"corner","receiver":{"position":[0,0,0],"normal":[0,0,1]},"emitter":{"vertices":[[0,0,1],[0,1,1],[1,1,1],[1,0,1]],"emission":{"constant":1}}}"#;
const CORNER_FACTOR: f64 = 0.138_531_605_994_893;

fn radgrad(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_radgrad"));
    command.args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Runs `radgrad eval -` on `input`, written from another thread so that neither side waits for the other.
fn eval(input: &[u8]) -> Output {
    let mut child = radgrad(&["eval", "-"]).spawn().unwrap();
    let mut stdin = child.stdin.take().unwrap();
    std::thread::scope(|scope| {
        scope.spawn(move || stdin.write_all(input).unwrap());
        child.wait_with_output().unwrap()
    })
}

fn objects(output: &Output) -> Vec<Value> {
    let text = std::str::from_utf8(&output.stdout).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

/// [`CORNER`] with another id and emission.
fn corner(id: &str, emission: f64) -> String {
    CORNER.replace("\"corner\"", id).replace("\"constant\":1", &format!("\"constant\":{emission:?}"))
}

#[test]
fn an_answer_has_the_fields_of_the_interface_in_order() {
    let output = eval(CORNER.as_bytes());
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stderr.is_empty());
    let text = String::from_utf8(output.stdout).unwrap();
    let fields = [
        "{\"id\":\"corner\",\"radiosity\":",
        ",\"gradient\":[",
        "],\"radiosity_error\":",
        ",\"gradient_error\":",
        ",\"method\":\"",
    ];
    let places: Vec<_> = fields.iter().map(|field| text.find(field).unwrap_or_else(|| panic!("{field} in {text}"))).collect();
    assert!(places.is_sorted() && places[0] == 0 && text.ends_with("\"}\n"), "{text}");
}

#[test]
fn the_point_factor_of_a_square_over_its_corner_is_within_its_bound() {
    let answers = objects(&eval(CORNER.as_bytes()));
    let (value, bound) = (answers[0]["radiosity"].as_f64().unwrap(), answers[0]["radiosity_error"].as_f64().unwrap());
    let error = (value - CORNER_FACTOR).abs();
    assert!(error <= 1e-15, "{value}");
    assert!(error <= bound + CORNER_FACTOR * f64::EPSILON && bound <= 1e-13, "{bound}");
    let gradient = numbers(&answers[0]["gradient"]);
    assert!(gradient[0] > 0.0 && (gradient[0] - gradient[1]).abs() <= 1e-15, "{gradient:?}");
}

#[test]
fn bad_lines_keep_their_place_and_cost_no_other() {
    let input = format!(
        "{}\n\nnonsense\r\n{}\n{}\n{}",
        corner("1", 1.0),
        CORNER.replace("\"normal\":[0,0,1]", "\"normal\":[0,0,0]"),
        CORNER.replace("[1,0,1]]", "[1,0,NaN]]"),
        corner("\"last\"", 2.0),
    );
    let output = eval(input.as_bytes());
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(String::from_utf8(output.stderr.clone()).unwrap(), "radgrad: 3 of 5 cases refused: see their `error`\n");
    let [first, nonsense, normal, nan, last] = objects(&output).try_into().unwrap();
    assert_eq!((&first["id"], first["error"].as_str()), (&Value::from(1), None));
    assert!(nonsense["id"].is_null() && nonsense["error"].as_str().unwrap().starts_with("line 3: column 2"), "{nonsense}");
    assert_eq!(normal["id"], "corner");
    assert_eq!(normal["error"], "receiver normal is [0, 0, 0]: it must be finite and not zero");
    assert!(nan["id"] == "corner" && nan["error"].as_str().unwrap().starts_with("column "), "{nan}");
    assert_eq!((&last["id"], last["error"].as_str()), (&Value::from("last"), None));
}

#[test]
fn a_long_stream_keeps_its_order_and_its_duplicates() {
    let count = 5_000;
    let input: String = (0..count).map(|i| corner(&(i / 2).to_string(), f64::from(i)) + "\n").collect();
    let output = eval(input.as_bytes());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let answers = objects(&output);
    assert_eq!(answers.len(), usize::try_from(count).unwrap());
    for (i, answer) in (0..count).zip(&answers) {
        let expected = CORNER_FACTOR * f64::from(i);
        assert_eq!(answer["id"], i / 2);
        assert!((answer["radiosity"].as_f64().unwrap() - expected).abs() <= 1e-14 * expected, "{answer}");
    }
}

#[test]
fn answers_read_back_as_the_doubles_that_core_gives() {
    let line = corner("7", 1.0 / 3.0);
    let Problem { receiver, emitter, .. } = Case::from_json(line.as_bytes()).unwrap().problem().unwrap();
    let expected = radgrad_core::evaluate(&receiver, &emitter, &[]).unwrap();
    let [answer] = objects(&eval(line.as_bytes())).try_into().unwrap();
    assert_eq!(answer["radiosity"].as_f64(), Some(expected.radiosity));
    assert_eq!(numbers(&answer["gradient"]), expected.gradient.to_array());
    assert_eq!(answer["radiosity_error"].as_f64(), Some(expected.radiosity_error));
    assert_eq!(answer["gradient_error"].as_f64(), Some(expected.gradient_error));
}

#[test]
fn a_program_that_waits_for_each_answer_gets_it() {
    let mut child = radgrad(&["eval", "-"]).spawn().unwrap();
    let (mut cases, mut answers) = (child.stdin.take().unwrap(), BufReader::new(child.stdout.take().unwrap()).lines());
    for id in ["1", "2", "3"] {
        writeln!(cases, "{}", corner(id, 1.0)).unwrap();
        let answer: Value = serde_json::from_str(&answers.next().unwrap().unwrap()).unwrap();
        assert_eq!(answer["id"].to_string(), id);
    }
    drop(cases);
    assert!(answers.next().is_none());
    assert_eq!(child.wait().unwrap().code(), Some(0));
}

#[test]
fn a_reader_that_has_seen_enough_ends_the_work_quietly() {
    let mut child = radgrad(&["eval", "-"]).spawn().unwrap();
    let mut cases = child.stdin.take().unwrap();
    let mut answers = BufReader::new(child.stdout.take().unwrap());
    writeln!(cases, "{CORNER}").unwrap();
    answers.read_line(&mut String::new()).unwrap();
    drop(answers);
    // The program closes its input when it stops, which ends this loop with an error.
    while writeln!(cases, "{CORNER}").is_ok() {}
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn a_file_is_read_and_a_missing_one_is_named() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR"));
    let file = folder.join("corner.jsonl");
    std::fs::write(&file, CORNER).unwrap();
    let output = radgrad(&["eval", file.to_str().unwrap()]).output().unwrap();
    assert_eq!(output.stdout, eval(CORNER.as_bytes()).stdout);

    let missing = folder.join("missing.jsonl");
    let output = radgrad(&["eval", missing.to_str().unwrap()]).output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0));
    assert!(message.contains("missing.jsonl: cannot read: "), "{message}");
}

#[test]
fn no_input_gives_no_output() {
    for input in [&b""[..], b"\n", b" \n\t\r\n"] {
        let output = eval(input);
        assert_eq!((output.status.code(), output.stdout.len()), (Some(0), 0));
    }
}

#[test]
fn a_result_beyond_the_range_of_a_double_is_an_error_of_its_line() {
    let far = CORNER.replace("[0,0,1],[0,1,1],[1,1,1],[1,0,1]", "[0,0,1e160],[0,1,1e160],[1,1,1e160],[1,0,1e160]");
    let near = CORNER.replace("[0,0,1],[0,1,1],[1,1,1],[1,0,1]", "[0,0,1e-200],[0,1e-200,1e-200],[1e-200,0,1e-200]");
    let input = [far, corner("1", 1e-308), near.replace("\"constant\":1", "\"constant\":1e150"), corner("2", 1.0)].join("\n");
    let output = eval(input.as_bytes());
    assert_eq!(output.status.code(), Some(1));
    let answers = objects(&output);
    let error = |i: usize| answers[i]["error"].as_str().unwrap();
    assert!(
        error(0).contains("the radiosity underflows: its magnitude is not 0 but below 2.2250738585072014e-308"),
        "{answers:?}"
    );
    assert!(error(1).contains("the radiosity underflows") && error(2).contains("the gradient overflows"), "{answers:?}");
    assert!(answers[3]["radiosity"].as_f64().unwrap() > 0.1, "{answers:?}");
}

/// Runs `radgrad eval` with arguments on `input`.
fn eval_with(arguments: &[&str], input: &str) -> Output {
    let mut child = radgrad(&[&["eval", "-"], arguments].concat()).spawn().unwrap();
    child.stdin.take().unwrap().write_all(input.as_bytes()).unwrap();
    child.wait_with_output().unwrap()
}

#[test]
fn a_line_asks_for_digits_for_second_derivatives_or_for_an_estimate() {
    let with = |id: &str, more: &str| CORNER.replacen("\"id\":\"corner\"", &format!("\"id\":\"{id}\",{more}"), 1);
    let expression = CORNER.replace("{\"constant\":1}", "{\"expression\":\"1 + x*exp(-y)\"}");
    let input = [
        with("digits", "\"digits\":40"),
        with("hessian", "\"hessian\":true"),
        with("fine", "\"tolerance\":1e-100"),
        expression.replace("corner", "expression"),
    ];
    let output = eval_with(&[], &input.join("\n"));
    assert_eq!(output.status.code(), Some(1), "{}", String::from_utf8_lossy(&output.stderr));
    let [digits, hessian, fine, expression] = objects(&output).try_into().unwrap();
    // atan(1/sqrt 2) / (pi sqrt 2)
    assert!(digits["radiosity"].as_str().unwrap().starts_with("1.385316059948929967807697086344756797307"), "{digits}");
    assert!(digits["radiosity_error"].as_str().unwrap().parse::<f64>().unwrap() < 1e-40);
    let rows: Vec<Vec<f64>> = hessian["hessian"].as_array().unwrap().iter().map(numbers).collect();
    assert!((0..3).all(|i| (0..3).all(|j| rows[i][j] == rows[j][i])) && hessian["hessian_error"].as_f64().unwrap() < 1e-12);
    assert!(fine["error"].as_str().unwrap().contains("\"digits\": 100"), "{fine}");
    assert_eq!((&expression["method"], &expression["converged"]), (&"estimate".into(), &true.into()), "{expression}");
    assert!(expression["radiosity_error"].is_null() && expression["radiosity"].as_f64().unwrap() > CORNER_FACTOR);
}

#[test]
fn a_line_asks_for_derivatives_by_everything_that_shapes_it() {
    let with = |more: &str| CORNER.replacen("\"id\":\"corner\"", &format!("\"id\":\"a\",\"derivatives\":true{more}"), 1);
    let expression = with("").replace("{\"constant\":1}", "{\"expression\":\"1 + x\"}");
    let screen = ",\"occluders\":[[[0.05,0.05,0.5],[0.3,0.05,0.5],[0.05,0.4,0.5]]]";
    let output = eval_with(&[], &[with(""), with(screen), with(",\"digits\":20"), expression].join("\n"));
    let [free, hidden, digits, expression] = objects(&output).try_into().unwrap();
    for answer in [&free, &hidden] {
        let derivatives = &answer["derivatives"];
        let list = |name: &str| derivatives[name].as_array().unwrap().clone();
        let screens = list("occluders");
        let vertices: Vec<_> =
            list("vertices").into_iter().chain(screens.iter().flat_map(|s| s.as_array().unwrap().clone())).collect();
        let gradient = numbers(&answer["gradient"]);
        for axis in 0..3 {
            // Moving all is moving the receiver the other way.
            let sum: f64 = vertices.iter().map(|vertex| numbers(&vertex["value"])[axis]).sum();
            assert!((sum + gradient[axis]).abs() < 1e-12, "{axis} {sum} {gradient:?}");
        }
        let radiosity = answer["radiosity"].as_f64().unwrap();
        assert!((list("emission")[0]["value"].as_f64().unwrap() - radiosity).abs() < 1e-15);
        assert!((derivatives["reflectance"]["value"].as_f64().unwrap() - radiosity).abs() < 1e-15);
        assert!((numbers(&derivatives["normal"]["value"])[2] - radiosity).abs() < 1e-15);
        assert!(vertices.iter().all(|vertex| vertex["error"].as_f64().unwrap() < 1e-12), "{vertices:?}");
    }
    let counts = [&free, &hidden].map(|answer| answer["derivatives"]["occluders"].as_array().unwrap().len());
    assert_eq!(counts, [0, 1]);
    let refused =
        [&digits, &expression].map(|refusal| refusal["error"].as_str().unwrap().contains("derivatives do not go together"));
    assert_eq!(refused, [true; 2], "{digits} {expression}");
}

#[test]
fn second_derivatives_are_asked_for_in_every_line_by_an_argument() {
    let input = [corner("1", 1.0), corner("2", 2.0)].join("\n");
    let answers = objects(&eval_with(&["--hessian"], &input));
    let trace = |i: usize| (0..3).map(|k| answers[i]["hessian"][k][k].as_f64().unwrap()).sum::<f64>();
    assert!(trace(0) != 0.0 && trace(1) == 2.0 * trace(0), "{answers:?}");
}
