//! How errors are distributed: a row a family, bars between neighbours of 1, 2, 5, 10, ... on a logarithmic axis.

use radgrad_audit::cases::family::Family;
use radgrad_audit::gates::Gates;
use radgrad_audit::measures::measure::Quantity;

use super::audit::{Audit, Bin, Figure};
use super::axis::Axis;
use super::svg::{Anchor, Svg};

const LEFT: f64 = 142.0;
const WIDTH: f64 = 560.0;
const ROW: f64 = 21.0;
const TOP: f64 = 34.0;
/// Where errors of exactly 0 stand, left of the axis.
const ZERO: f64 = LEFT + 12.0;
const START: f64 = LEFT + 38.0;

/// The distribution of a quantity in every family that has an error at all.
pub(super) fn plot(audit: &Audit, gates: &Gates, quantity: Quantity, what: &str) -> String {
    let families: Vec<&str> = audit.outcomes.iter().map(|row| row.family.as_str()).filter(|f| has_errors(audit, f)).collect();
    let bins = || audit.histogram.iter().filter(|bin| bin.quantity == quantity.name() && families.contains(&bin.family.as_str()));
    let exponents = bins().filter(|bin| bin.to > 0.0 && bin.to.is_finite()).map(|bin| libm::log10(bin.to).ceil());
    let highest = exponents.fold(-12.0, f64::max);
    let axis = Axis { base: 10.0, exponents: [-18.0, highest], places: [START, WIDTH - 18.0] };
    let bottom = TOP + ROW * families.len() as f64;
    let mut svg = Svg::new(WIDTH, bottom + 36.0);
    svg.text("title", (LEFT, 15.0), Anchor::Start, &format!("Relative error of the {what}"));
    axis.draw_below(&mut svg, [TOP - 8.0, bottom], 8.0, "tick");
    svg.text("tick", (ZERO, bottom + 13.0), Anchor::Middle, "0");
    svg.text("label", ((START + WIDTH) / 2.0 - 8.0, bottom + 29.0), Anchor::Middle, "relative error (no unit)");
    for (index, family) in families.iter().enumerate() {
        let base = TOP + ROW * (index as f64 + 1.0) - 3.0;
        svg.text("label", (LEFT - 8.0, base - 2.0), Anchor::End, family);
        svg.line("grid", (LEFT, base), (WIDTH - 18.0, base));
        bars(&mut svg, axis, base, &bins().filter(|bin| bin.family == *family).collect::<Vec<_>>());
        marks(&mut svg, axis, base, audit, gates, (family, quantity));
    }
    let worst =
        audit.figures.iter().filter(|f| f.quantity == quantity.name()).max_by(|a, b| value(&a.worst).total_cmp(&value(&b.worst)));
    let worst = worst.map_or_else(String::new, |f| format!(" The worst is {} in {}.", f.worst, f.family));
    let title = format!("Distribution of the relative error of the {what} by family");
    svg.finish("plot", &title, &format!("Histograms of {} families on a logarithmic axis from 1e-18.{worst}", families.len()))
}

/// Whether a family is neither dark nor refused: else every error is 0, or there is none.
pub(super) fn has_errors(audit: &Audit, family: &str) -> bool {
    let is_lit = family.parse::<Family>().is_ok_and(|family| !family.is_dark() && !family.is_refused());
    is_lit && audit.figure(family, "value").is_some()
}

fn bars(svg: &mut Svg, axis: Axis, base: f64, bins: &[&Bin]) {
    let largest = bins.iter().map(|bin| bin.count).max().unwrap_or(1) as f64;
    for bin in bins {
        let height = (ROW - 5.0) * bin.count as f64 / largest;
        let (from, to) = match bin.from {
            0.0 => (ZERO - 5.0, ZERO + 5.0),
            from => (axis.place(from), axis.place(bin.to).max(axis.place(from) + 1.0)),
        };
        svg.rectangle("bar", (from, base - height), (to - from - 0.4, height));
    }
}

fn marks(svg: &mut Svg, axis: Axis, base: f64, audit: &Audit, gates: &Gates, (family, quantity): (&str, Quantity)) {
    let Some(figure) = audit.figure(family, quantity.name()) else { return };
    let [median, worst] = [&figure.median, &figure.worst].map(|text| value(text));
    if median > 0.0 {
        svg.line("median", (axis.place(median), base - ROW + 5.0), (axis.place(median), base));
    }
    if worst > 0.0 {
        svg.circle("worst", (axis.place(worst), base - 3.0), 2.6);
    }
    if let Some(gate) = family.parse().ok().and_then(|family| gates.gate(family, quantity)).filter(|gate| *gate > 0.0) {
        svg.line("gate", (axis.place(gate), base - ROW + 5.0), (axis.place(gate), base));
    }
}

/// The worse of the worst errors of value and gradient of a family.
pub(super) fn worst<'a>(audit: &'a Audit, family: &str) -> Option<&'a Figure> {
    let of_family = ["value", "gradient"].into_iter().filter_map(|quantity| audit.figure(family, quantity));
    of_family.max_by(|a, b| value(&a.worst).total_cmp(&value(&b.worst)))
}

/// A number of a file; text that is none gives NaN.
pub(super) fn value(text: &str) -> f64 {
    text.parse().unwrap_or(f64::NAN)
}
