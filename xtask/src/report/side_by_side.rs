//! The contenders on the same cases: a row a family, a mark each at the median, a line to the worst.

use radgrad_audit::comparison::contender::Contender;

use super::audit::Audit;
use super::axis::Axis;
use super::histogram::value;
use super::svg::{Anchor, Svg, around, through};

const LEFT: f64 = 142.0;
const WIDTH: f64 = 560.0;
const ROW: f64 = 33.0;
const TOP: f64 = 34.0;

/// The name of a contender on the page.
pub(super) const fn title(contender: Contender) -> &'static str {
    match contender {
        Contender::AsPrinted => "as printed in 1995",
        Contender::Corrected => "corrected",
        Contender::SinglePrecision => "single-precision fit",
        Contender::ClosedForm => "our closed form",
        Contender::Certified => "ours, certified",
    }
}

/// Medians and worst errors of one quantity.
pub(super) fn plot(audit: &Audit, quantity: &str, what: &str) -> String {
    let mut families: Vec<&str> = audit.comparison.iter().map(|row| row.family.as_str()).collect();
    families.dedup();
    let axis = Axis { base: 10.0, exponents: [-17.0, 3.0], places: [LEFT + 8.0, WIDTH - 14.0] };
    let bottom = TOP + ROW * families.len() as f64;
    let mut svg = Svg::new(WIDTH, bottom + 36.0);
    svg.text("title", (LEFT, 15.0), Anchor::Start, &format!("Relative error of the {what}"));
    axis.draw_below(&mut svg, [TOP - 8.0, bottom], 7.0, "tick");
    svg.text(
        "label",
        ((LEFT + WIDTH) / 2.0, bottom + 29.0),
        Anchor::Middle,
        "relative error (no unit); right edge: 1000 and more",
    );
    for (index, family) in families.iter().enumerate() {
        let top = TOP + ROW * index as f64;
        svg.text("label", (LEFT - 8.0, top + ROW / 2.0 + 3.0), Anchor::End, family);
        svg.line("grid", (LEFT, top), (WIDTH - 10.0, top));
        let rows = audit.comparison.iter().filter(|row| row.family == *family && row.quantity == quantity);
        for row in rows {
            let Some(rank) = Contender::ALL.iter().position(|c| c.name() == row.contender) else { continue };
            let y = top + 4.5 + 6.0 * rank as f64;
            let [median, worst] = [&row.median, &row.worst].map(|text| axis.place(value(text).max(1e-30)));
            svg.line(&format!("c{rank} span"), (median, y), (worst, y));
            mark(&mut svg, rank, (median, y));
        }
    }
    let description = format!(
        "{} families; the median of each of {} ways to compute it is marked, a line leads to its worst error.",
        families.len(),
        Contender::ALL.len()
    );
    svg.finish("plot", &format!("Relative error of the {what} by family and way to compute it"), &description)
}

/// A mark that differs by shape as well as by colour.
fn mark(svg: &mut Svg, rank: usize, (x, y): (f64, f64)) {
    let class = format!("c{rank} mark");
    let r = 2.9;
    match rank {
        0 => svg.path(&class, &(through(&[(x - r, y - r), (x + r, y + r)]) + &through(&[(x - r, y + r), (x + r, y - r)]))),
        1 => svg.path(&class, &around(&[(x - r, y - r), (x + r, y - r), (x + r, y + r), (x - r, y + r)])),
        2 => svg.path(&class, &around(&[(x, y - r - 0.6), (x + r + 0.4, y + r - 0.4), (x - r - 0.4, y + r - 0.4)])),
        3 => svg.path(&class, &around(&[(x, y - r - 0.7), (x + r + 0.7, y), (x, y + r + 0.7), (x - r - 0.7, y)])),
        _ => svg.circle(&class, (x, y), 3.1),
    }
}

/// The marks with their names.
pub(super) fn legend() -> String {
    Contender::ALL
        .iter()
        .enumerate()
        .map(|(rank, contender)| {
            let mut svg = Svg::new(26.0, 12.0);
            svg.line(&format!("c{rank} span"), (7.0, 6.0), (25.0, 6.0));
            mark(&mut svg, rank, (7.0, 6.0));
            let name = title(*contender);
            format!("<span class=\"key\">{} {name}</span>", svg.finish("swatch", name, "mark of the legend"))
        })
        .collect()
}
