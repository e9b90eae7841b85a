//! `cargo xtask prove`: has gappa prove, from the code that runs, the steps of the bounds that core states.
//!
//! Core's closed forms are run on a scalar that records ([`tape`]), and written as scripts ([`script`]). A lemma states a constant that
//! core's bounds are made of, read from core ([`lemma`]; [`function`], [`arc`]). To see that a proof can fail, each lemma is tried
//! again with half of that constant, and where the code has coefficients with one of them off by a millionth: both must be refused.

mod arc;
mod function;
mod lemma;
mod paper;
mod script;
mod tape;

use std::error::Error;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use crate::prove::lemma::{Case, Lemma, Stated};
use crate::summary::with_header;

/// Have gappa prove the steps of core's bounds from recorded code, and refuse them with wrong constants
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Only these lemmas
    names: Vec<String>,
    /// Where scripts go
    #[arg(long, default_value = "target/prove")]
    out: PathBuf,
}

/// A case that takes more seconds of a processor is not proved. Those that are proved take less than one.
const PATIENCE: u32 = 10;

/// Whether all is proved that should be, and nothing else; true where there is no gappa.
pub(crate) fn run(arguments: &Arguments) -> Result<bool, Box<dyn Error>> {
    let lemmas: Vec<&Lemma> = every_lemma()
        .filter(|lemma| arguments.names.is_empty() || arguments.names.iter().any(|name| name == lemma.name))
        .collect();
    if let Some(unknown) = arguments.names.iter().find(|name| every_lemma().all(|lemma| lemma.name != name.as_str())) {
        let names: Vec<_> = every_lemma().map(|lemma| lemma.name).collect();
        return Err(format!("no lemma is called {unknown:?}; these are: {}", names.join(", ")).into());
    }
    fs::create_dir_all(&arguments.out)?;
    if let Err(error) = Command::new("gappa").arg("--version").output() {
        skip(&arguments.out, &lemmas, &error)?;
        return Ok(true);
    }
    let start = Instant::now();
    let mut table = with_header(&["lemma", "stated", "proved", "paths", "seconds", "half of it", "coefficient off", "what"]);
    let (mut proved, mut planted, mut refused) = (0, 0, 0);
    for lemma in &lemmas {
        let begun = Instant::now();
        let cases = (lemma.cases)(&Stated::as_is(lemma));
        let refusal = refusal(&arguments.out, lemma, "", &cases)?;
        let seconds = begun.elapsed().as_secs_f64();
        proved += usize::from(refusal.is_none());
        let faults = [("half", Some(Stated::half(lemma))), ("coefficient", Stated::coefficient_off(lemma))];
        let mut told = Vec::new();
        for (name, fault) in faults {
            let Some(fault) = fault else {
                told.push("-");
                continue;
            };
            planted += 1;
            // Where the lemma itself is not proved a refusal says nothing.
            let is_refused = refusal.is_none() && self::refusal(&arguments.out, lemma, name, &(lemma.cases)(&fault))?.is_some();
            refused += usize::from(is_refused);
            told.push(if is_refused { "refused" } else { "PROVED" });
        }
        table.add_row([
            lemma.name,
            &lemma.stated.to_string(),
            if refusal.is_none() { "yes" } else { "NO" },
            &cases.len().to_string(),
            &format!("{seconds:.2}"),
            told[0],
            told[1],
            lemma.says,
        ]);
        if let Some(refusal) = refusal {
            eprintln!("VIOLATED {}: {refusal}", lemma.name);
        }
    }
    println!("{table}\n\n{}", paper::table());
    println!(
        "{proved} of {} lemmas proved from recorded code; {refused} of {planted} wrong constants refused; {:.0} s",
        lemmas.len(),
        start.elapsed().as_secs_f64()
    );
    Ok(proved == lemmas.len() && refused == planted)
}

/// Writes the scripts, and says that none was run.
fn skip(out: &Path, lemmas: &[&Lemma], why: &io::Error) -> Result<(), Box<dyn Error>> {
    for lemma in lemmas {
        for case in (lemma.cases)(&Stated::as_is(lemma)) {
            write(out, lemma, "", &case)?;
        }
    }
    let out = out.display();
    println!("SKIPPED, nothing is proved: gappa cannot be run ({why}; Debian has it: apt-get install gappa). Scripts: {out}");
    Ok(())
}

fn every_lemma() -> impl Iterator<Item = &'static Lemma> {
    function::LEMMAS.iter().chain(arc::LEMMAS)
}

/// The first case that gappa does not prove, and its message.
fn refusal(out: &Path, lemma: &Lemma, fault: &str, cases: &[Case]) -> Result<Option<String>, Box<dyn Error>> {
    for case in cases {
        let path = write(out, lemma, fault, case)?;
        if let Some(said) = said_against(&path)? {
            return Ok(Some(format!("{}{said} ({})", case.name, path.display())));
        }
    }
    Ok(None)
}

fn write(out: &Path, lemma: &Lemma, fault: &str, case: &Case) -> io::Result<PathBuf> {
    let words = [lemma.name, &case.name, fault].join(" ");
    // Names are told apart by their sizes' bars too.
    let letter = |c: char| {
        if c.is_alphanumeric() {
            c
        } else if c == '|' {
            'I'
        } else {
            '-'
        }
    };
    let path = out.join(words.trim().chars().map(letter).collect::<String>() + ".g");
    fs::write(&path, format!("# {}: {}. {}\n{}", lemma.name, lemma.says, case.name, case.script))?;
    Ok(path)
}

/// The message of gappa against a script; nothing where it proves it, each of the hints included.
fn said_against(path: &Path) -> Result<Option<String>, Box<dyn Error>> {
    let said = path.with_extension("said");
    // The shell limits the time of the processor, so that a busy machine refuses nothing.
    let status = Command::new("sh")
        .args(["-c", &format!("ulimit -t {PATIENCE} && exec gappa \"$@\""), "gappa", "-Eprecision=120", "-Eno-auto-dichotomy"])
        .arg(path)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(fs::File::create(&said)?)
        .status()?;
    if status.code().is_none() {
        return Ok(Some(format!(": no proof in {PATIENCE} s of a processor")));
    }
    let text = fs::read_to_string(&said)?;
    // A hint must hold wherever its conditions do.
    let trusted = text.lines().find(|line| line.contains("assumed to be nonzero") || line.contains("trivially equal"));
    if status.success() && trusted.is_none() {
        return Ok(None);
    }
    if text.contains("syntax error") {
        return Err(format!("{}: gappa does not read it: {text}", path.display()).into());
    }
    let lines: Vec<&str> = text.lines().skip_while(|line| !line.starts_with("Error")).map(str::trim).collect();
    Ok(Some(format!(": {}", trusted.map_or_else(|| lines.join(" "), str::to_owned))))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use radgrad_core::closed_forms;

    use super::*;
    use crate::prove::tape::Tape;

    #[test]
    fn a_program_recorded_at_one_point_gives_the_digits_of_the_code_at_others() {
        let points: Vec<[f64; 2]> =
            (1..400).map(|k| [f64::from(k) * 0.0123, f64::from((k * k) % 97) * 0.05 - 2.4]).filter(|[_, x]| *x != 0.0).collect();
        let mut compared = 0;
        for pair in points.windows(9) {
            let ([y, x], [v, u]) = (pair[0], pair[8]);
            let (tape, other) = (Tape::default(), Tape::default());
            let [a, b] = [(&tape, [y, x]), (&other, [v, u])].map(|(tape, inputs)| {
                let [y, x] = tape.inputs(inputs);
                let numbers = [closed_forms::arc_tangent(y, x), closed_forms::logarithm(y), closed_forms::psi(x)];
                numbers.map(|number| number.place)
            });
            if tape.decisions() == other.decisions() {
                let replayed = tape.replay(&[v, u]);
                let direct = [closed_forms::arc_tangent(v, u), closed_forms::logarithm(v), closed_forms::psi(u)];
                assert_eq!((a, a.map(|place| replayed[place])), (b, direct), "{v} {u}");
                compared += 1;
            }
        }
        assert!(compared > 50, "{compared}");
    }

    /// A name that is neither defined nor constrained would be any number.
    #[test]
    fn every_number_of_a_script_is_defined_or_has_a_hypothesis() {
        let mut names = BTreeSet::new();
        for lemma in every_lemma() {
            let cases = (lemma.cases)(&Stated::as_is(lemma));
            let wrong = (lemma.cases)(&Stated::half(lemma));
            assert!(!cases.is_empty() && cases.len() == wrong.len(), "{}", lemma.name);
            for (case, wrong) in cases.iter().zip(&wrong) {
                assert_ne!(case.script, wrong.script, "{}", lemma.name);
                assert!(names.insert(format!("{} {}", lemma.name, case.name)), "{} {}", lemma.name, case.name);
                let script = case.script.lines().filter(|line| !line.starts_with('#')).collect::<Vec<_>>().join("\n");
                let (definitions, rest) = script.split_once("\n{ ").expect("one statement");
                let premise = rest.split_once("->\n").map_or("", |(premise, _)| premise);
                let defined: BTreeSet<&str> = definitions.lines().filter_map(|line| line.split(" = ").next()).collect();
                for word in script.split(|c: char| !c.is_alphanumeric()) {
                    let is_number = word.len() > 1 && "ceq".contains(&word[..1]) && word[1..].chars().all(|c| c.is_ascii_digit());
                    let said = || premise.split(|c: char| !c.is_alphanumeric()).any(|other| other == word);
                    assert!(!is_number || defined.contains(word) || said(), "{} {}: {word}", lemma.name, case.name);
                }
            }
        }
    }
}
