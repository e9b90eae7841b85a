//! The page of a small audit, made here: it stands by itself, says what happened, and is the same every time.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use radgrad_audit::bounds::campaign;
use radgrad_audit::comparison::Comparison;
use radgrad_audit::family::Family;
use radgrad_audit::mutants::{self, mutants};
use radgrad_audit::run::{Part, Run};
use radgrad_audit::stability::Stability;

use super::Report;
use crate::verify::record::Record;

const FAMILIES: [Family; 3] = [Family::Generic, Family::Far, Family::EqualVertices];

/// A folder of its own, gone in the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("radgrad-report-{name}-{}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn join(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// What `cargo xtask verify` leaves, of few cases.
fn audit(folder: &Folder, violation: Option<&str>) -> Result<(), Box<dyn Error>> {
    let create = |name: &str| fs::File::create(folder.join(name));
    let table = Run::of_each(3, &FAMILIES, 1).table(|_| ());
    table.write_outcomes(create("outcomes.csv")?)?;
    table.write_figures(create("figures.csv")?)?;
    table.write_histogram(create("histogram.csv")?)?;
    let bounds = campaign::table(&campaign::run(200, &FAMILIES, 1, Part::WHOLE), || ());
    bounds.write_bounds(create("bounds.csv")?)?;
    bounds.write_figures(create("bounds-figures.csv")?)?;
    mutants::write(&mutants(1, 3, 1e-9), 1e-9, create("mutants.csv")?)?;
    Comparison::compute(1, &FAMILIES, 3).write(create("comparison.csv")?)?;
    Stability::compute([3, 2], || ()).write(create("stability.csv")?)?;
    Record::new("bounds", 1, 200).write(&folder.0)?;
    let mut record = Record::new("verify", 1, table.cases());
    if let Some(what) = violation {
        record.violated(what, "cargo xtask replay generic:1:0");
    }
    record.write(&folder.0)?;
    Ok(())
}

fn nothing() -> &'static Path {
    Path::new("no/such/folder")
}

#[test]
fn the_same_audit_gives_the_same_bytes() {
    let folder = Folder::new("twice");
    audit(&folder, None).unwrap();
    let [first, second] = [(); 2].map(|()| Report::of(&folder.0, nothing()).unwrap());
    assert_eq!(first.html, second.html);
    assert_eq!(first.data, second.data);
    assert!(first.html.contains("Passed: 9 cases"), "no verdict");
}

#[test]
fn the_page_needs_nothing_from_elsewhere_and_every_file_it_names_lies_beside_it() {
    let folder = Folder::new("alone");
    audit(&folder, None).unwrap();
    let Report { html, data, copied } = Report::of(&folder.0, nothing()).unwrap();
    let mut beside: Vec<String> = data.iter().map(|(name, _)| (*name).to_owned()).collect();
    beside.extend(copied.iter().map(|path| path.file_name().unwrap().to_string_lossy().into_owned()));
    for address in
        ["href=\"", "src=\""].iter().flat_map(|key| html.split(*key).skip(1)).map(|rest| rest.split('"').next().unwrap())
    {
        let is_here = address.starts_with('#') || address.starts_with("data:") || beside.iter().any(|name| name == address);
        assert!(is_here, "{address} is neither in the page nor beside it");
    }
    assert!(!html.contains("url(") && !html.contains("@import"));
    let (plots, _script) = html.split_once("<script>").unwrap();
    assert!(!plots.contains("NaN"));
    assert_eq!(html.matches("<svg").count(), html.matches("role=\"img\"").count());
}

#[test]
fn a_violation_stands_at_the_top_with_its_command() {
    let folder = Folder::new("failed");
    audit(&folder, Some("value is 1 & the gate is < 1")).unwrap();
    let html = Report::of(&folder.0, nothing()).unwrap().html;
    let top = &html[..html.find("id=\"accuracy\"").unwrap()];
    assert!(top.contains("FAILED: 9 cases") && top.contains("class=\"verdict failed\""), "{top}");
    assert!(top.contains("value is 1 &amp; the gate is &lt; 1: <code>cargo xtask replay generic:1:0</code>"), "{top}");
}

#[test]
fn diagrams_of_a_benchmark_are_taken_in_and_their_absence_is_said() {
    let (folder, bench) = (Folder::new("bench"), Folder::new("diagrams"));
    audit(&folder, None).unwrap();
    assert!(Report::of(&folder.0, nothing()).unwrap().html.contains("the benchmark has not been run"));
    fs::write(bench.join("far.svg"), "<svg xmlns=\"http://www.w3.org/2000/svg\"><title>Far away</title></svg>").unwrap();
    fs::write(bench.join("far.csv"), "method,error,ns\n").unwrap();
    let Report { html, copied, .. } = Report::of(&folder.0, &bench.0).unwrap();
    assert!(html.contains("alt=\"Far away. ") && html.contains("data:image/svg+xml;base64,") && !html.contains("no-bench"));
    assert!(copied.contains(&bench.join("far.csv")));
}
