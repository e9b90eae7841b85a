//! Lines through points, error or cost over something: both axes logarithmic, or the horizontal one in whole numbers.

use crate::plot::{Anchor, FAINT, INK, Picture, Point, Rgb, Stroke, Type};

const AXES: Point = (460.0, 380.0);
const LEFT: f64 = 74.0;
const TOP: f64 = 86.0;
const BELOW: f64 = 56.0;
const LEGEND: f64 = 210.0;
const GRID: Rgb = (226, 226, 232);
/// Colours that differ in brightness too.
const COLOURS: [Rgb; 6] = [(38, 38, 46), (0, 114, 178), (213, 94, 0), (0, 158, 115), (204, 121, 167), (150, 120, 20)];

/// One line.
pub(super) struct Series {
    pub(super) name: String,
    pub(super) points: Vec<Point>,
    /// Which colour, and whether it is drawn as dashes.
    pub(super) colour: usize,
    pub(super) dashed: bool,
}

/// A picture of some lines.
pub(super) struct Graph {
    pub(super) title: String,
    pub(super) under: String,
    pub(super) across: &'static str,
    pub(super) upward: &'static str,
    /// Whether the horizontal axis has whole numbers instead of powers of ten.
    pub(super) counts: bool,
    pub(super) series: Vec<Series>,
}

/// A range of an axis, in its own scale.
type Range = [f64; 2];

impl Graph {
    pub(super) fn draw(&self) -> Picture {
        let mut picture = Picture::new(LEFT + AXES.0 + 24.0 + LEGEND, TOP + AXES.1 + BELOW);
        picture.text((LEFT, 28.0), &self.title, Type { size: 17, colour: INK, anchor: Anchor::Start });
        picture.text((LEFT, 48.0), &self.under, Type { size: 11, colour: FAINT, anchor: Anchor::Start });
        let points = || self.series.iter().flat_map(|s| &s.points);
        let along: Range = if self.counts { range(points().map(|p| p.0)) } else { decades(points().map(|p| p.0)) };
        let upward = decades(points().map(|p| p.1));
        let x = |v: f64| {
            let v = if self.counts { v } else { v.log10() };
            LEFT + AXES.0 * (0.04 + 0.92 * (v - along[0]) / (along[1] - along[0]))
        };
        let y = |v: f64| TOP + AXES.1 * (1.0 - (v.log10() - upward[0]) / (upward[1] - upward[0]));
        let label = |anchor| Type { size: 11, colour: INK, anchor };
        let steps =
            |[low, high]: Range| std::iter::successors(Some(low), |v| Some(v + 1.0)).take_while(move |v| *v <= high + 1e-9);
        for step in steps(along) {
            let (value, name) = if self.counts { (step, format!("{step:.0}")) } else { (10_f64.powf(step), power(step)) };
            picture.line(&[(x(value), TOP), (x(value), TOP + AXES.1)], Stroke::solid(GRID, 0.8));
            picture.text((x(value), TOP + AXES.1 + 17.0), &name, label(Anchor::Middle));
        }
        for step in steps(upward) {
            let height = y(10_f64.powf(step));
            picture.line(&[(LEFT, height), (LEFT + AXES.0, height)], Stroke::solid(GRID, 0.8));
            picture.text((LEFT - 7.0, height + 4.0), &power(step), label(Anchor::End));
        }
        let (right, bottom) = (LEFT + AXES.0, TOP + AXES.1);
        picture.outline(&[(LEFT, TOP), (right, TOP), (right, bottom), (LEFT, bottom)], Stroke::solid(INK, 0.9));
        picture.text((LEFT + AXES.0 / 2.0, bottom + 38.0), self.across, Type { size: 12, ..label(Anchor::Middle) });
        picture.text((LEFT - 46.0, TOP - 12.0), self.upward, Type { size: 12, ..label(Anchor::Start) });
        for (row, series) in self.series.iter().enumerate() {
            let colour = COLOURS[series.colour % COLOURS.len()];
            let stroke = if series.dashed { Stroke::dashed(colour, 1.5) } else { Stroke::solid(colour, 1.5) };
            let line: Vec<Point> = series.points.iter().map(|p| (x(p.0), y(p.1))).collect();
            if line.len() > 1 {
                picture.line(&line, stroke);
            }
            line.iter().for_each(|&place| picture.disc(place, 3.0, colour));
            let (left, at) = (right + 20.0, TOP + 8.0 + 21.0 * row as f64);
            picture.line(&[(left, at), (left + 26.0, at)], stroke);
            picture.disc((left + 13.0, at), 3.0, colour);
            picture.text((left + 34.0, at + 4.0), &series.name, Type { size: 12, ..label(Anchor::Start) });
        }
        picture
    }
}

fn range(values: impl Iterator<Item = f64>) -> Range {
    let [low, high] = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)]);
    match (low < high, low.is_finite()) {
        (true, _) => [low, high],
        (false, true) => [low - 1.0, low + 1.0],
        (false, false) => [0.0, 1.0],
    }
}

/// Whole decades around positive values.
fn decades(values: impl Iterator<Item = f64>) -> Range {
    let [low, high] = range(values.filter(|v| *v > 0.0).map(f64::log10));
    [low.floor(), high.ceil()]
}

fn power(exponent: f64) -> String {
    let digits = "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().collect::<Vec<char>>();
    let raised = format!("{exponent:.0}").chars().map(|c| c.to_digit(10).map_or('⁻', |d| digits[d as usize])).collect::<String>();
    if exponent == 0.0 { "1".to_owned() } else { format!("10{raised}") }
}
