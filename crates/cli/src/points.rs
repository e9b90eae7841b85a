//! Points at which the radiosity is asked for, and the answers: JSON Lines in, JSON Lines out, in their order.

use std::io::{self, BufRead, Write};

use radgrad_core::DVec3;
use radgrad_solver::Solution;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// One line of the input; other fields are passed over.
#[derive(Debug, Deserialize)]
struct Point {
    #[serde(default)]
    id: Option<serde_json::Value>,
    position: [f64; 3],
    normal: [f64; 3],
}

/// One line of the output: radiosity, the bound on its error and an estimate of that in each channel of the scene.
#[derive(Debug, Serialize)]
struct Answer {
    #[serde(skip_serializing_if = "Option::is_none")]
    id: Option<serde_json::Value>,
    radiosity: Vec<f64>,
    /// Proven.
    bound: Vec<f64>,
    estimate: Vec<f64>,
}

/// What stands in the place of an answer.
#[derive(Debug, Serialize)]
struct Refusal {
    #[serde(skip_serializing_if = "Option::is_none")]
    id: Option<serde_json::Value>,
    line: usize,
    error: String,
}

/// Answers every line that is not blank. Returns the number of those that were refused.
pub(crate) fn answer_all(solution: &Solution, input: impl BufRead, mut output: impl Write) -> io::Result<usize> {
    let lines: Vec<String> = input.lines().collect::<io::Result<_>>()?;
    let numbered: Vec<(usize, &String)> =
        lines.iter().enumerate().map(|(i, l)| (i + 1, l)).filter(|(_, l)| !l.trim().is_empty()).collect();
    let answers: Vec<Result<Answer, Refusal>> = numbered.par_iter().map(|&(line, text)| answer(solution, line, text)).collect();
    let mut refused = 0;
    for answer in answers {
        match answer {
            Ok(answer) => serde_json::to_writer(&mut output, &answer)?,
            Err(refusal) => {
                refused += 1;
                serde_json::to_writer(&mut output, &refusal)?;
            }
        }
        output.write_all(b"\n")?;
    }
    output.flush()?;
    Ok(refused)
}

fn answer(solution: &Solution, line: usize, text: &str) -> Result<Answer, Refusal> {
    let point: Point = serde_json::from_str(text).map_err(|e| Refusal { id: None, line, error: e.to_string() })?;
    match solution.gather(DVec3::from(point.position), DVec3::from(point.normal)) {
        Ok(gathered) => {
            let [bound, estimate] =
                [&gathered.ledger, &gathered.estimate].map(|of| of.iter().map(radgrad_solver::Ledger::total).collect());
            Ok(Answer { id: point.id, radiosity: gathered.radiosity, bound, estimate })
        }
        Err(error) => Err(Refusal { id: point.id, line, error: error.to_string() }),
    }
}
