//! The copy of the workspace in which the drawn faults can be switched on.
//!
//! Only drawn places are written anew, each as `if fault::on(K) { faulty } else { original }`; all other code is as it was. A fault
//! that does not compile is none: the compiler says of which place it complains.

use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde::Deserialize;
use toml::{Table, Value};

use super::draw::{Drawn, Source};
use super::places::{Form, VALUE};
use crate::files::cargo;

/// What the audit is made of.
const CRATES: [&str; 8] = ["audit", "certificate", "core", "numbers", "oracle", "paper", "scene", "solver"];

/// A file with faults in it, and which bytes are whose.
#[derive(Debug, Default)]
pub(crate) struct Written {
    pub(crate) text: String,
    places: Vec<(Range<usize>, usize)>,
}

impl Written {
    /// `faults` are those of this source, by their numbers.
    pub(crate) fn new(source: &str, mut faults: Vec<(usize, &Drawn)>) -> Self {
        faults.sort_by_key(|(number, drawn)| (drawn.fault.range.start, usize::MAX - drawn.fault.range.end, *number));
        let mut written = Self::default();
        written.write(source, 0..source.len(), &faults);
        written
    }

    fn write(&mut self, source: &str, range: Range<usize>, mut faults: &[(usize, &Drawn)]) {
        let mut copied = range.start;
        while let [(number, Drawn { fault, .. }), rest @ ..] = faults {
            self.text += &source[copied..fault.range.start];
            copied = fault.range.end;
            let within = rest.iter().take_while(|(_, other)| other.fault.range.start < copied).count();
            let start = self.text.len();
            let (before, after) = match &fault.form {
                Form::LeftOut => (format!("if !::fault::on({number}) {{ "), " }".to_owned()),
                Form::Value => (format!("(if ::fault::on({number}) {{ {} }} else {{ ", fault.faulty), " })".to_owned()),
                Form::Told(differs) => (
                    format!("(if ::fault::on({number}) {{ {} }} else {{ match (", fault.faulty),
                    format!(
                        ") {{ {VALUE} => {{ if ::fault::records() {{ ::fault::differs({number}, {differs}); }} {VALUE} }} }} }})"
                    ),
                ),
            };
            self.text += &before;
            self.write(source, fault.range.clone(), &rest[..within]);
            self.text += &after;
            self.places.push((start..self.text.len(), *number));
            faults = &rest[within..];
        }
        self.text += &source[copied..range.end];
    }

    /// Whose these bytes are: the smallest place around them; else those among them, else the nearest.
    fn blamed(&self, bytes: &Range<usize>) -> Vec<usize> {
        let around = self.places.iter().filter(|(place, _)| place.start <= bytes.start && bytes.end <= place.end);
        if let Some((_, number)) = around.min_by_key(|(place, _)| place.len()) {
            return vec![*number];
        }
        let among: Vec<usize> = self
            .places
            .iter()
            .filter(|(place, _)| place.start < bytes.end && bytes.start < place.end)
            .map(|(_, number)| *number)
            .collect();
        if !among.is_empty() {
            return among;
        }
        let apart = |place: &Range<usize>| place.start.saturating_sub(bytes.end).max(bytes.start.saturating_sub(place.end));
        self.places.iter().min_by_key(|(place, _)| apart(place)).map(|(_, number)| *number).into_iter().collect()
    }
}

/// The copy.
#[derive(Debug)]
pub(crate) struct Copy {
    root: PathBuf,
    target: PathBuf,
    written: BTreeMap<String, Written>,
}

impl Copy {
    /// The workspace as it is.
    pub(crate) fn new(workspace: &Path, out: &Path) -> Result<Self, Box<dyn Error>> {
        let root = std::path::absolute(out)?.join("source");
        let target = root.with_file_name("target");
        fs::create_dir_all(root.join("crates/fault/src"))?;
        let mut manifest: Table = toml::from_str(&fs::read_to_string(workspace.join("Cargo.toml"))?)?;
        if let Some(Value::Table(workspace)) = manifest.get_mut("workspace") {
            let members = CRATES.iter().chain(&["fault"]).map(|name| Value::String(format!("crates/{name}")));
            workspace.insert("members".to_owned(), Value::Array(members.collect()));
        }
        if let Some(Value::Table(dev)) = manifest.get_mut("profile").and_then(|profiles| profiles.get_mut("dev"))
            && let Some(Value::Table(packages)) = dev.get_mut("package")
        {
            packages.retain(|name, _| name != "xtask" && name != "radgrad" && name != "radgrad-c");
        }
        write(&root.join("Cargo.toml"), &toml::to_string(&manifest)?)?;
        fs::copy(workspace.join("Cargo.lock"), root.join("Cargo.lock"))?;
        write(
            &root.join("crates/fault/Cargo.toml"),
            "[package]\nname = \"fault\"\nversion = \"0.1.0\"\nedition = \"2024\"\npublish = false\n",
        )?;
        write(&root.join("crates/fault/src/lib.rs"), include_str!("fault.rs"))?;
        copy(&workspace.join("data"), &root.join("data"))?;
        fs::copy(workspace.join("README.md"), root.join("README.md"))?;
        for name in CRATES {
            let [from, to] = [workspace, &root].map(|root| root.join("crates").join(name));
            copy(&from, &to)?;
            let mut manifest: Table = toml::from_str(&fs::read_to_string(from.join("Cargo.toml"))?)?;
            manifest.remove("dev-dependencies");
            // What the compiler proves wrong of a fault may be said when it is run.
            let allowed =
                ["arithmetic_overflow", "unconditional_panic"].map(|lint| (lint.to_owned(), Value::String("allow".to_owned())));
            let lints = Table::from_iter([("rust".to_owned(), Value::Table(allowed.into_iter().collect()))]);
            manifest.insert("lints".to_owned(), Value::Table(lints));
            if let Some(Value::Table(needs)) = manifest.get_mut("dependencies") {
                let path = Table::from_iter([("path".to_owned(), Value::String("../fault".to_owned()))]);
                needs.insert("fault".to_owned(), Value::Table(path));
            }
            write(&to.join("Cargo.toml"), &toml::to_string(&manifest)?)?;
        }
        Ok(Self { root, target, written: BTreeMap::new() })
    }

    /// Puts these faults into the copy, by their numbers, and no others.
    pub(crate) fn plant<'a>(
        &mut self,
        sources: &[Source],
        faults: impl IntoIterator<Item = (usize, &'a Drawn)>,
    ) -> Result<(), Box<dyn Error>> {
        let mut of_files: BTreeMap<usize, Vec<(usize, &Drawn)>> = BTreeMap::new();
        for (number, drawn) in faults {
            of_files.entry(drawn.file).or_default().push((number, drawn));
        }
        self.written.clear();
        for (file, source) in sources.iter().enumerate() {
            let written = Written::new(&source.text, of_files.remove(&file).unwrap_or_default());
            write(&self.root.join(&source.path), &written.text)?;
            self.written.insert(source.path.clone(), written);
        }
        Ok(())
    }

    /// The numbers of the faults that the compiler complains of; none if it made what is asked for.
    pub(crate) fn refused(&self, arguments: &[&str]) -> Result<BTreeSet<usize>, Box<dyn Error>> {
        let output = Command::new(cargo())
            .args(arguments)
            .args(["--package", "radgrad-audit", "--message-format", "json", "--manifest-path"])
            .arg(self.root.join("Cargo.toml"))
            .arg("--target-dir")
            .arg(&self.target)
            .current_dir(&self.root)
            .stderr(Stdio::inherit())
            .output()?;
        if output.status.success() {
            return Ok(BTreeSet::new());
        }
        let text = String::from_utf8_lossy(&output.stdout);
        let messages = text.lines().filter_map(|line| serde_json::from_str::<Line>(line).ok()).filter_map(|line| line.message);
        let (mut refused, mut unknown) = (BTreeSet::new(), String::new());
        for message in messages.filter(|message| message.level == "error" && !message.spans.is_empty()) {
            let mut spans = message.spans.iter().collect::<Vec<_>>();
            spans.sort_by_key(|span| !span.is_primary);
            let blamed = spans.into_iter().flat_map(Span::with_callers).find_map(|span| {
                let blamed = self.written.get(&span.file_name)?.blamed(&(span.byte_start..span.byte_end));
                (!blamed.is_empty()).then_some(blamed)
            });
            match blamed {
                Some(blamed) => refused.extend(blamed),
                None => unknown += &message.rendered.unwrap_or(message.message),
            }
        }
        if refused.is_empty() { Err(format!("the copy with faults does not compile: {unknown}").into()) } else { Ok(refused) }
    }

    /// The program that was made.
    pub(crate) fn program(&self) -> PathBuf {
        self.target.join(format!("debug/examples/bite{}", std::env::consts::EXE_SUFFIX))
    }
}

/// A line of cargo's.
#[derive(Deserialize)]
struct Line {
    message: Option<Message>,
}

#[derive(Deserialize)]
struct Message {
    level: String,
    message: String,
    rendered: Option<String>,
    spans: Vec<Span>,
}

#[derive(Deserialize)]
struct Span {
    file_name: String,
    byte_start: usize,
    byte_end: usize,
    is_primary: bool,
    expansion: Option<Box<Expansion>>,
}

#[derive(Deserialize)]
struct Expansion {
    span: Span,
}

impl Span {
    /// It, and where the macro that wrote it was called.
    fn with_callers(&self) -> Vec<&Self> {
        let mut spans = vec![self];
        spans.extend(self.expansion.iter().flat_map(|expansion| expansion.span.with_callers()));
        spans
    }
}

/// Unless the file has that content: what does not change is not compiled anew.
fn write(file: &Path, content: &str) -> Result<(), Box<dyn Error>> {
    if fs::read_to_string(file).is_ok_and(|there| there == content) {
        return Ok(());
    }
    Ok(fs::write(file, content)?)
}

/// A folder, but for sources, which are written with their faults, where there are such.
fn copy(from: &Path, to: &Path) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let from = entry?.path();
        let Some(name) = from.file_name() else { continue };
        let to = to.join(name);
        if from.is_dir() {
            copy(&from, &to)?;
        } else if name != "Cargo.toml" {
            let content = fs::read(&from)?;
            if !fs::read(&to).is_ok_and(|there| there == content) {
                fs::write(&to, content)?;
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mutants::places;

    #[test]
    fn a_place_within_another_is_switched_where_that_one_is_not() {
        let source = "fn f(a: f64) -> bool { if 2.0 * a < 1.0 { return true; } false }";
        let drawn = |operator| {
            let fault = places::faults(source).unwrap().into_iter().find(|fault| fault.operator == operator).unwrap();
            Drawn { file: 0, fault }
        };
        let [condition, compared, literal, left] = ["negated", "< to <=", "doubled", "left out"].map(drawn);
        let written = Written::new(source, vec![(0, &condition), (1, &compared), (2, &literal), (3, &left)]);
        let told = format!(
            "(if ::fault::on(1) {{ 2.0 * a <= 1.0 }} else {{ match ((if ::fault::on(2) {{ (2.0 * 2.0) }} else {{ 2.0 }}) * a < 1.0) \
             {{ {VALUE} => {{ if ::fault::records() {{ ::fault::differs(1, {VALUE} != (2.0 * a <= 1.0)); }} {VALUE} }} }} }})"
        );
        let wanted = format!(
            "fn f(a: f64) -> bool {{ if (if ::fault::on(0) {{ !(2.0 * a < 1.0) }} else {{ {told} }}) {{ if !::fault::on(3) {{ return \
             true }}; }} false }}"
        );
        assert_eq!(written.text, wanted);
        let start = written.text.find("2.0 }").unwrap();
        assert_eq!(written.blamed(&(start..start + 3)), [2]);
        assert_eq!(written.blamed(&(0..written.text.len())).len(), 4);
        syn::parse_file(&written.text).unwrap();
    }
}
