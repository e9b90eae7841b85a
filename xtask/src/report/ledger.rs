//! The estimate of solved scenes by its sources.

use std::error::Error;

use radgrad_solver::{Ledger, Solution};

use super::axis::Axis;
use super::plates::Plate;
use super::rungs::swatch;
use super::svg::{Anchor, Svg};

/// The names of the scenes, in the order of their colours.
const SCENES: [&str; 2] = ["two squares, degree 2", "room, degree 1"];

/// The estimate of the error of the mean over the mean radiosity, by its sources, a bar each.
pub(super) fn picture(of: [&Solution; 2]) -> Plate {
    const SIZE: (f64, f64) = (560.0, 330.0);
    let (left, right, top, row) = (104.0, 500.0, 40.0, 39.0);
    let bottom = top + row * 6.0;
    let axis = Axis { base: 10.0, exponents: [-18.0, 0.0], places: [left, right] };
    let mut svg = Svg::new(SIZE.0, SIZE.1);
    svg.text("title", (left, 18.0), Anchor::Start, "M   Where the error comes from");
    axis.draw_below(&mut svg, [top - 8.0, bottom], 6.0, "tick");
    for (index, name) in Ledger::NAMES.into_iter().chain(["all"]).enumerate() {
        let y = top + row * index as f64;
        svg.text("label", (left - 8.0, y + row / 2.0), Anchor::End, name);
        for (rank, solution) in of.into_iter().enumerate() {
            let part = share(solution, index);
            let upper = y + 3.0 + 16.0 * rank as f64;
            svg.rectangle(&format!("l{rank}"), (left, upper), (axis.place(part.max(1e-18)) - left, 13.0));
            let label = if part == 0.0 { "0".to_owned() } else { format!("{part:.1e}") };
            svg.text("tick", (axis.place(part.max(1e-18)) + 5.0, upper + 10.0), Anchor::Start, &label);
        }
    }
    svg.text("label", ((left + right) / 2.0, bottom + 31.0), Anchor::Middle, "estimate over mean radiosity (no unit)");
    let title = "Figure M: the estimate by its sources";
    Plate {
        picture: svg.finish("plot", title, "What of the estimate of the mean's error is due to what."),
        caption: "M. The ledger: what of the estimate is due to the scene read otherwise than given, to polynomials on elements, to links and \
                  rounding, to what is hidden, and to the linear system."
            .to_owned(),
    }
}

/// The scenes of the ledger with their colours.
pub(super) fn legend() -> String {
    [swatch("l0", SCENES[0]), swatch("l1", SCENES[1])].concat()
}

/// An entry of the ledger, the sum after the last, over the mean radiosity.
fn share(solution: &Solution, index: usize) -> f64 {
    let ledger = solution.mean_estimate()[0];
    ledger.entries().get(index).copied().unwrap_or_else(|| ledger.total()) / solution.mean()[0]
}

pub(super) fn csv(of: [&Solution; 2]) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut rows = csv::Writer::from_writer(Vec::new());
    rows.write_record(["scene", "elements", "links", "mean-radiosity"].iter().chain(&Ledger::NAMES).chain(&["all"]))?;
    for (name, solution) in SCENES.into_iter().zip(of) {
        let progress = solution.progress();
        let counts = [progress.elements, progress.links].map(|count| count.to_string());
        let parts = (0..=Ledger::NAMES.len()).map(|index| format!("{:.3e}", share(solution, index)));
        let mean = format!("{:.6}", solution.mean()[0]);
        rows.write_record([name.to_owned()].into_iter().chain(counts).chain([mean]).chain(parts))?;
    }
    Ok(rows.into_inner()?)
}
