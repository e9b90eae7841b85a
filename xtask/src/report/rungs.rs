//! Who answered: a bar a family, shared out among the rungs of the ladder.

use super::audit::{Audit, Bounds};
use super::svg::{Anchor, Svg};

const LEFT: f64 = 142.0;
const WIDTH: f64 = 560.0;
const ROW: f64 = 17.0;
const TOP: f64 = 30.0;

/// Rungs from the cheap to the dear: name in the files, and on the page.
pub(super) const RUNGS: [(&str, &str); 4] = [
    ("quadrature", "Gauss rule"),
    ("closed-form", "closed form, double precision"),
    ("double-double", "closed form, double-double"),
    ("arbitrary-precision", "closed form, 256 bits and more"),
];

/// Shares of the answers to 1e-12 that are not 0.
pub(super) fn plot(audit: &Audit) -> String {
    let lit: Vec<&Bounds> = audit.bounds.iter().filter(|row| row.nonzero > 0).collect();
    let bottom = TOP + ROW * lit.len() as f64;
    let mut svg = Svg::new(WIDTH, bottom + 34.0);
    let across = WIDTH - 20.0 - LEFT;
    svg.text("title", (LEFT, 15.0), Anchor::Start, "Which method answered to 1e-12");
    for percent in [0.0, 25.0, 50.0, 75.0, 100.0] {
        let x = LEFT + across * percent / 100.0;
        svg.line("grid", (x, TOP - 4.0), (x, bottom));
        svg.text("tick", (x, bottom + 13.0), Anchor::Middle, &format!("{percent}"));
    }
    svg.text("label", (LEFT + across / 2.0, bottom + 28.0), Anchor::Middle, "share of the answers (%)");
    for (index, row) in lit.iter().enumerate() {
        let top = TOP + ROW * index as f64;
        svg.text("label", (LEFT - 8.0, top + 11.0), Anchor::End, &row.family);
        let counts = [row.by_quadrature, row.by_closed_form, row.by_double_double, row.by_arbitrary_precision];
        let total = counts.iter().sum::<u64>().max(1) as f64;
        let mut x = LEFT;
        for (rung, count) in counts.into_iter().enumerate().filter(|(_, count)| *count > 0) {
            let width = across * count as f64 / total;
            svg.rectangle(&format!("r{rung}"), (x, top + 2.0), (width, ROW - 4.0));
            x += width;
        }
    }
    let description =
        "A bar a family, shared among Gauss rule, closed form in double precision, in double-double, and with more bits.";
    svg.finish("plot", "Which method answered, by family", description)
}

/// The colours with their names.
pub(super) fn legend() -> String {
    RUNGS.iter().enumerate().map(|(rung, (_, name))| swatch(&format!("r{rung}"), name)).collect()
}

/// A square of a colour with its name.
pub(super) fn swatch(class: &str, name: &str) -> String {
    let mut svg = Svg::new(14.0, 12.0);
    svg.rectangle(class, (1.0, 0.5), (12.0, 11.0));
    format!("<span class=\"key\">{} {name}</span>", svg.finish("swatch", name, "colour of the legend"))
}
