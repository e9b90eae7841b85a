//! The page of a small audit, made here: it stands by itself, tells the outcome, and is the same every time.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use radgrad_audit::bounds::campaign;
use radgrad_audit::cases::family::Family;
use radgrad_audit::checks::mutants::{self, mutants};
use radgrad_audit::comparison::Comparison;
use radgrad_audit::comparison::stability::Stability;
use radgrad_audit::measures::run::{Part, Run};
use radgrad_paper::appendix::Misprint;

use super::Report;
use crate::record::Record;

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

type Ended = Result<(), Box<dyn Error>>;

/// The files of `cargo xtask verify`, of few cases: their names and texts, made once for all tests.
fn few() -> Result<Vec<(&'static str, String)>, Box<dyn Error>> {
    let mut files = Vec::new();
    let mut keep = |name, written: &dyn Fn(&mut Vec<u8>) -> Ended| -> Ended {
        let mut bytes = Vec::new();
        written(&mut bytes)?;
        files.push((name, String::from_utf8(bytes)?));
        Ok(())
    };
    let table = Run::of_each(3, &FAMILIES, 1).table(|_| ());
    keep("errors.csv", &|out| Ok(table.write_errors(out)?))?;
    keep("outcomes.csv", &|out| Ok(table.write_outcomes(out)?))?;
    keep("figures.csv", &|out| Ok(table.write_figures(out)?))?;
    keep("histogram.csv", &|out| Ok(table.write_histogram(out)?))?;
    let bounds = campaign::table(&campaign::run(200, &FAMILIES, 1, Part::WHOLE), || ());
    keep("bounds.csv", &|out| Ok(bounds.write_bounds(out)?))?;
    keep("bounds-figures.csv", &|out| Ok(bounds.write_figures(out)?))?;
    keep("mutants.csv", &|out| Ok(mutants::write(&mutants(1, 3, 1e-9).0, 1e-9, out)?))?;
    keep("comparison.csv", &|out| Ok(Comparison::compute(1, &FAMILIES, 3).write(out)?))?;
    keep("stability.csv", &|out| Ok(Stability::compute([3, 2], || ()).write(out)?))?;
    let scenes = "family,subject,scenes,held,broken,rough,refused,failed,median_bound_over_error,median_estimate_over_error,seconds_an_answer,\
                  seconds_a_truth\nclutter,solve,10,56,0,0,0,0,2.049e2,7.310e0,0.499,0.275\n";
    files.push(("scenes.csv", scenes.to_owned()));
    Ok(files)
}

/// A folder with these files and the records of the runs.
fn audit(folder: &Folder, violation: Option<&str>) -> Result<(), Box<dyn Error>> {
    static FEW: OnceLock<Vec<(&str, String)>> = OnceLock::new();
    for (name, text) in FEW.get_or_init(|| few().unwrap()) {
        fs::write(folder.join(name), text)?;
    }
    let mut record = Record::new("bounds", 1, 200);
    record.note("broken", 0);
    record.note("answers", 1800);
    record.write(&folder.0)?;
    let mut record = Record::new("scenes", 1, 10);
    record.note("judged", 56);
    record.note("broken_or_failed", 0);
    record.write(&folder.0)?;
    let mut record = Record::new("verify", 1, 9);
    record.note("families", FAMILIES.len());
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
    let [first, second] = [(); 2].map(|()| Report::read(&folder.0, nothing()).unwrap());
    assert_eq!(first.html, second.html);
    assert_eq!(first.data, second.data);
    assert!(first.html.contains("Passed: 9 cases"), "no verdict");
}

#[test]
fn the_page_needs_nothing_from_elsewhere_and_every_file_it_names_lies_beside_it() {
    let folder = Folder::new("alone");
    audit(&folder, None).unwrap();
    let Report { html, data, copied } = Report::read(&folder.0, nothing()).unwrap();
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
    let html = Report::read(&folder.0, nothing()).unwrap().html;
    let top = &html[..html.find("id=\"accuracy\"").unwrap()];
    assert!(top.contains("FAILED: 9 cases") && top.contains("class=\"verdict failed\""), "{top}");
    assert!(top.contains("value is 1 &amp; the gate is &lt; 1: <code>cargo xtask replay generic:1:0</code>"), "{top}");
}

#[test]
fn a_broken_bound_of_a_scene_fails_the_page_and_a_run_without_scenes_is_said() {
    let folder = Folder::new("scenes");
    audit(&folder, None).unwrap();
    let mut record = Record::new("scenes", 1, 10);
    record.violated("downlight:1:6: field", "cargo xtask replay downlight:1:6");
    record.write(&folder.0).unwrap();
    let html = Report::read(&folder.0, nothing()).unwrap().html;
    let top = &html[..html.find("id=\"accuracy\"").unwrap()];
    assert!(top.contains("FAILED: 9 cases") && top.contains("cargo xtask replay downlight:1:6"), "{top}");
    fs::remove_file(folder.join("scenes-run.csv")).unwrap();
    let html = Report::read(&folder.0, nothing()).unwrap().html;
    assert!(html.contains("Passed: 9 cases") && html.contains("No scenes were audited"));
}

#[test]
fn diagrams_of_a_benchmark_are_taken_in_and_their_absence_is_said() {
    let (folder, bench) = (Folder::new("bench"), Folder::new("diagrams"));
    audit(&folder, None).unwrap();
    assert!(Report::read(&folder.0, nothing()).unwrap().html.contains("the benchmark has not been run"));
    fs::write(bench.join("far.svg"), "<svg xmlns=\"http://www.w3.org/2000/svg\"><title>Far away</title></svg>").unwrap();
    fs::write(bench.join("far.csv"), "method,error,ns\n").unwrap();
    let Report { html, copied, .. } = Report::read(&folder.0, &bench.0).unwrap();
    assert!(html.contains("alt=\"Far away. ") && html.contains("data:image/svg+xml;base64,") && !html.contains("no-bench"));
    assert!(copied.contains(&bench.join("far.csv")));
}

/// The text after each occurrence of `start`, up to `end`.
fn pieces<'a>(html: &'a str, start: &str, end: &str) -> Vec<&'a str> {
    html.split(start).skip(1).map(|rest| rest.split(end).next().unwrap()).collect()
}

/// A small page with the diagram of a benchmark, and the bytes of the tables beside it.
fn page(name: &str) -> (String, Vec<(String, String)>) {
    let (folder, bench) = (Folder::new(name), Folder::new(&format!("{name}-diagrams")));
    audit(&folder, None).unwrap();
    fs::write(bench.join("far.svg"), "<svg xmlns=\"http://www.w3.org/2000/svg\"><text>Far away</text></svg>").unwrap();
    let row = "emission,method,value error worst,gradient error worst,ns median\nconstant,closed form,1e-16,1e-15,65.4\n";
    fs::write(bench.join("far.csv"), row).unwrap();
    let Report { html, data, copied } = Report::read(&folder.0, &bench.0).unwrap();
    let mut files: Vec<(String, String)> =
        data.into_iter().map(|(name, bytes)| (name.to_owned(), String::from_utf8(bytes).unwrap())).collect();
    let name = |path: &PathBuf| path.file_name().unwrap().to_string_lossy().into_owned();
    files.extend(copied.iter().map(|path| (name(path), fs::read_to_string(path).unwrap())));
    (html, files)
}

/// The page without its numbers: sections, plots, tables with the titles of their columns, and the first line of every file beside it.
#[test]
fn the_page_has_the_recorded_structure() {
    let (html, files) = page("structure");
    let mut said = String::new();
    let text = |html: &str| {
        let text: String = html.split('<').map(|part| part.split_once('>').map_or(part, |(_, text)| text)).collect();
        // Numbers are of the run.
        text.chars().map(|c| if c.is_ascii_digit() { '0' } else { c }).collect::<String>().trim().to_owned()
    };
    for section in html.split("<h2 ").skip(1) {
        let (title, rest) = section.split_once('>').unwrap().1.split_once("</h2>").unwrap();
        said += &format!("# {}\n", text(title));
        for name in pieces(rest, "<svg class=\"plot", "</svg>") {
            said += &format!("plot: {}\n", text(pieces(name, "<title>", "</title>")[0]));
        }
        for table in pieces(rest, "<table", "</table>") {
            let titles: Vec<String> = pieces(table, "<th scope=\"col\"", "</th>")
                .into_iter()
                .map(|th| text(&th[th.find('>').unwrap() + 1..]))
                .collect();
            said += &format!("table: {}\n", titles.join(" | "));
        }
    }
    for (name, text) in files.iter().filter(|(name, _)| name.ends_with(".csv")) {
        said += &format!("{name}: {}\n", text.lines().next().unwrap_or_default());
    }
    insta::assert_snapshot!(said);
}

#[test]
fn every_plot_has_a_name_a_description_and_axes_with_units() {
    let (html, _) = page("plots");
    let plots = pieces(&html, "<svg class=\"plot", "</svg>");
    assert!(plots.len() > 20, "{}", plots.len());
    for plot in plots {
        let [title, description] = ["title", "desc"].map(|of| pieces(plot, &format!("<{of}>"), "</")[0]);
        assert!(title.len() > 10 && description.len() > 20, "{title}: {description}");
        assert!(plot.contains(&format!("aria-label=\"{title}")), "{title}");
        let texts = pieces(plot, "<text", "</text>");
        let units = texts.iter().filter(|text| text.split_once('>').is_some_and(|(_, text)| text.contains('('))).count();
        assert!(units > 0, "{title} has no axis with its unit");
    }
    for image in pieces(&html, "<img", ">") {
        let alternative =
            "alt=\"Far away. Relative error over the time of an answer, both logarithmic. 1 methods at 1 settings. Quickest";
        assert!(image.contains(alternative), "{image}");
    }
}

#[test]
fn every_section_with_a_plot_or_a_table_names_its_files() {
    let (html, files) = page("sections");
    let (mut shown, mut named) = (0, Vec::new());
    for section in pieces(&html, "<h2 id=\"", "<h2 id=\"") {
        let id = section.split('"').next().unwrap();
        if id != "data"
            && ["<svg class=\"plot", "<svg class=\"sketch", "<table", "<img"].iter().any(|what| section.contains(what))
        {
            shown += 1;
            let of_section: Vec<&str> =
                pieces(section, "href=\"", "\"").into_iter().filter(|file| file.ends_with(".csv")).collect();
            assert!(!of_section.is_empty(), "{id} names no file");
            named.extend(of_section);
        }
    }
    assert!(shown >= 10, "{shown}");
    // Nothing made here lies beside the page unmentioned.
    for (name, _) in
        files.iter().filter(|(name, _)| name.ends_with(".csv") && !name.contains("-run") && !name.contains("violations"))
    {
        let is_of_command_line = ["bounds-times.csv", "errors.csv"].contains(&name.as_str());
        assert!(is_of_command_line || named.contains(&name.as_str()), "no section names {name}");
    }
}

#[test]
fn every_number_of_a_table_is_in_a_file_that_it_names_and_every_table_sorts() {
    let (html, files) = page("numbers");
    let numbers = |name: &str| -> Vec<f64> {
        let text = &files.iter().find(|(file, _)| file == name).unwrap_or_else(|| panic!("{name} is not there")).1;
        let mut reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(text.as_bytes());
        let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        rows.iter().flat_map(|row| row.iter().filter_map(|field| field.trim_start_matches('<').parse().ok())).collect()
    };
    let tables = pieces(&html, "<p class=\"note of-table\">", "</table>");
    assert_eq!(tables.len(), html.matches("<table").count(), "a table without a caption");
    let mut checked = 0;
    for table in tables {
        let (caption, body) = table.split_once("</p>").unwrap();
        assert!(
            body.contains("<table class=\"sortable\"") && pieces(body, "<th ", "</th>").iter().all(|th| th.contains("<button"))
        );
        let there: Vec<f64> = pieces(caption, "href=\"", "\"").into_iter().flat_map(numbers).collect();
        for key in pieces(body, "<td class=\"number\" data-key=\"", "\"") {
            let number: f64 = key.parse().unwrap();
            let near = |other: &f64| {
                *other == number || (other - number).abs() <= 1e-3 * number.abs() || (number.abs() < 1e-12 && other.abs() < 1e-12)
            };
            assert!(there.iter().any(near), "{key} is not in a file of the table: {caption}");
            checked += 1;
        }
    }
    assert!(checked > 200, "{checked}");
}

#[test]
fn the_numbers_of_the_verdict_are_in_the_records_of_the_run() {
    let (html, files) = page("verdict");
    // Thousands are set apart on the page only.
    let verdict = pieces(&html, "id=\"verdict\">", "</p>")[0].replace(',', "");
    let records: String = files.iter().filter(|(name, _)| name.ends_with(".csv")).map(|(_, text)| text.as_str()).collect();
    let words = verdict.split(|c: char| c.is_whitespace() || ";()".contains(c)).map(|word| word.trim_end_matches(['.', ':']));
    let numbers: Vec<&str> = words.filter(|word| word.parse::<f64>().is_ok()).collect();
    // The caught slips are counted from their rows.
    let slips = numbers.len() - 2;
    assert!(numbers.len() >= 8, "{verdict}");
    let fields: Vec<&str> = records.split([',', '\n']).collect();
    for number in &numbers[..slips] {
        assert!(fields.contains(number), "{number} of \"{verdict}\" is in no file");
    }
    let caught = records.lines().filter(|line| line.contains(",caught")).count();
    assert_eq!(numbers[slips..], [caught.to_string(), Misprint::ALL.len().to_string()], "{verdict}");
}
