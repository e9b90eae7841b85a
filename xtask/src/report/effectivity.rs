//! Two unit squares that face each other, whose radiosity is known at two points: its error, the stated estimate of it, and their ratio.

use std::error::Error;
use std::f64::consts::PI;

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::Scene;
use radgrad_solver::{Options, Solution, solve};

use super::axis::Axis;
use super::plates::Plate;
use super::svg::{Anchor, Svg};
use super::table::{Cell, Table};

/// Radiosity of two squares that reflect half and emit 1, at the centre and at a corner of either.
const KNOWN: [(&str, DVec3, f64); 2] = [
    ("centre", DVec3::new(0.5, 0.5, 0.0), 1.133_303_564_992_420_8),
    ("corner", DVec3::new(0.0, 0.0, 0.0), 1.076_981_393_145_044_5),
];
/// Errors asked for of the two squares.
const ASKED: [f64; 4] = [1e-2, 1e-3, 1e-4, 1e-6];
const MOST_ELEMENTS: usize = 150;

pub(super) fn squares() -> Result<Scene, Box<dyn Error>> {
    let mut scene = Scene::new(["grey"])?;
    let grey = scene.add_material("grey", [0.5], [1.0 / PI])?;
    let surface = scene.add_surface("squares");
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    for corners in [corners.map(|(x, y)| DVec3::new(x, y, 0.0)), corners.map(|(x, y)| DVec3::new(y, x, 1.0))] {
        scene.add_face(surface, grey, Polygon::new(corners.to_vec())?, None)?;
    }
    Ok(scene)
}

/// The finest of the trials of degree 2.
pub(super) fn finest(squares: &Scene) -> Result<Solution, Box<dyn Error>> {
    Ok(solve(squares, &Options { error: ASKED[3], degree: Some(2), first_elements: 1, ..Options::default() }, |_| true)?)
}

/// A solution of the squares beside the known values.
pub(super) struct Trial {
    degree: usize,
    asked: f64,
    elements: usize,
    place: &'static str,
    error: f64,
    estimate: f64,
}

pub(super) fn trials(squares: &Scene) -> Result<Vec<Trial>, Box<dyn Error>> {
    let mut trials = Vec::new();
    for (degree, asked) in (0..=3).flat_map(|degree| ASKED.map(|asked| (degree, asked))) {
        let options =
            Options { error: asked, degree: Some(degree), first_elements: 1, most_elements: MOST_ELEMENTS, ..Options::default() };
        let solution = solve(squares, &options, |_| true)?;
        // A solution that already met a coarser demand is the same one.
        if trials.last().is_some_and(|last: &Trial| last.degree == degree && last.elements == solution.progress().elements) {
            continue;
        }
        for (place, point, exact) in KNOWN {
            let gathered = solution.gather(point, DVec3::Z)?;
            let (error, estimate) = ((gathered.radiosity[0] - exact).abs(), gathered.estimate[0].total());
            trials.push(Trial { degree, asked, elements: solution.progress().elements, place, error, estimate });
        }
    }
    Ok(trials)
}

/// Errors and estimates over the number of elements, at the centre.
pub(super) fn picture(trials: &[Trial]) -> Plate {
    const SIZE: (f64, f64) = (560.0, 330.0);
    let (left, right, top, bottom) = (58.0, 548.0, 34.0, 276.0);
    let shown = || trials.iter().filter(|trial| trial.place == KNOWN[0].0);
    let largest_count = shown().map(|trial| trial.elements as f64).fold(10.0, f64::max);
    let across = Axis { base: 10.0, exponents: [0.0, libm::log10(largest_count).ceil()], places: [left, right] };
    let lowest = shown().map(|trial| trial.error.max(1e-17)).fold(1.0, f64::min);
    let highest = shown().map(|trial| trial.estimate).fold(lowest, f64::max);
    let exponents = [libm::log10(lowest).floor(), libm::log10(highest).ceil()];
    let up = Axis { base: 10.0, exponents, places: [bottom, top] };
    let mut svg = Svg::new(SIZE.0, SIZE.1);
    svg.text("title", (left, 18.0), Anchor::Start, "L   Error and estimate at the centre of a square");
    across.draw_below(&mut svg, [top, bottom], 5.0, "tick");
    up.draw_left(&mut svg, left, 8.0, "tick");
    for trial in shown() {
        // Degrees stand beside each other where they have as many elements.
        let x = across.place(trial.elements as f64) + 11.0 * (trial.degree as f64 - 1.5);
        let [error, estimate] = [trial.error.max(1e-17), trial.estimate].map(|of| up.place(of));
        let class = format!("d{}", trial.degree);
        svg.line(&format!("{class} reach"), (x, error), (x, estimate));
        svg.circle(&format!("{class} error"), (x, error), 3.4);
        svg.line(&format!("{class} bound"), (x - 5.0, estimate), (x + 5.0, estimate));
        svg.text("tick", (x, estimate - 4.0), Anchor::Middle, &trial.degree.to_string());
    }
    svg.rectangle("frame", (left, top), (right - left, bottom - top));
    svg.text("label", ((left + right) / 2.0, bottom + 30.0), Anchor::Middle, "elements (count)");
    svg.text_upward("label", (14.0, (top + bottom) / 2.0), "error and estimate (W/m²)");
    svg.text(
        "label",
        ((left + right) / 2.0, bottom + 48.0),
        Anchor::Middle,
        "dot: error; bar: estimate; number and colour: degree",
    );
    let title = "Figure L: error and estimate of two squares by number of elements";
    Plate {
        picture: svg.finish("plot", title, "For degrees 0 to 3: the error and what it was estimated to be."),
        caption: format!(
            "L. Two unit squares 1 m apart, each reflects half and emits 1 W/m²: {:.16} W/m² at the centre. The estimate over the error is the \
             effectivity: at 1 it says what the error is.",
            KNOWN[0].2
        ),
    }
}

pub(super) fn table(trials: &[Trial]) -> Table {
    let titles = ["where", "#degree", "#asked", "#elements", "#error (W/m²)", "#estimate (W/m²)", "#estimate / error"];
    let mut table =
        Table::new("Two squares: what is known of the error, what is stated, and their ratio", &["effectivity.csv"], &titles);
    for trial in trials {
        let number = |x: f64, text: String| Cell::from(&text).by(x);
        table.push([
            Cell::from(trial.place),
            number(trial.degree as f64, trial.degree.to_string()),
            number(trial.asked, format!("{:.0e}", trial.asked)),
            number(trial.elements as f64, trial.elements.to_string()),
            number(trial.error, format!("{:.1e}", trial.error)),
            number(trial.estimate, format!("{:.1e}", trial.estimate)),
            number(trial.estimate / trial.error, format!("{:.1}", trial.estimate / trial.error)),
        ]);
    }
    table
}

pub(super) fn csv(trials: &[Trial]) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut rows = csv::Writer::from_writer(Vec::new());
    rows.write_record(["where", "degree", "asked", "elements", "error", "estimate", "effectivity"])?;
    for Trial { degree, asked, elements, place, error, estimate } in trials {
        let [asked, error, estimate, effectivity] = [*asked, *error, *estimate, estimate / error].map(|x| format!("{x:.3e}"));
        rows.write_record([*place, &degree.to_string(), &asked, &elements.to_string(), &error, &estimate, &effectivity])?;
    }
    Ok(rows.into_inner()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_error_is_beyond_three_estimates_and_finer_is_nearer() {
        let trials = trials(&squares().unwrap()).unwrap();
        for trial in &trials {
            assert!(
                trial.error <= 3.0 * trial.estimate,
                "{}, {:e}: {:e} off, estimated {:e}",
                trial.place,
                trial.asked,
                trial.error,
                trial.estimate
            );
        }
        let worst = |asked: f64| trials.iter().filter(|t| t.asked == asked).map(|t| t.error).fold(0.0, f64::max);
        assert!(worst(1e-6) > 0.0 && worst(1e-6) < worst(1e-2), "{} {}", worst(1e-6), worst(1e-2));
    }
}
