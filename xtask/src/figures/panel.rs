//! A field as colours with level lines, axes and a colour bar whose ticks are the levels.

use super::field::Field;
use crate::plot::{Anchor, Colours, FAINT, INK, Picture, Point, Stroke, Type};

/// Room of a panel in a picture: field, axes, titles and colour bar.
pub(crate) const SIZE: Point = (486.0, 478.0);

/// Upper left corner of the field in the panel.
const CORNER: Point = (58.0, 76.0);
/// Side of the field: one unit a cell makes the sampling exactly that of the picture.
pub(crate) const SIDE: u32 = 350;
const BAR_GAP: f64 = 16.0;
const BAR_WIDTH: f64 = 16.0;

/// The contents of a panel.
pub(crate) struct Panel<'a> {
    /// Its letter and the name of the field.
    pub(crate) title: &'a str,
    /// The scene, in a smaller line.
    pub(crate) subtitle: &'a str,
    /// Name and unit of the values, at the colour bar.
    pub(crate) quantity: &'a str,
    /// The values.
    pub(crate) field: &'a Field,
    /// Their colours, from 0 to the largest.
    pub(crate) colours: Colours,
    /// An outline drawn over the field.
    pub(crate) outline: &'a [Point],
    /// A point to mark with a cross.
    pub(crate) mark: Point,
}

impl Panel<'_> {
    /// Draws the panel with its upper left corner at `origin`.
    pub(crate) fn draw(&self, picture: &mut Picture, origin: Point) {
        let frame = Frame { left: origin.0 + CORNER.0, top: origin.1 + CORNER.1, side: f64::from(SIDE), field: self.field };
        let (top, _) = self.field.largest();
        let levels = ticks(0.0, top, 8);
        self.paint(picture, &frame, top);
        for &level in &levels.values {
            let stroke = Stroke::solid(self.line_colour(level / top), 0.9);
            for segment in self.field.level_line(level) {
                picture.line(&segment.map(|p| frame.place(p)), stroke);
            }
        }
        let outline: Vec<Point> = self.outline.iter().map(|&p| frame.place(p)).collect();
        picture.outline(&outline, Stroke::dashed((255, 255, 255), 1.1));
        cross(picture, frame.place(self.mark));
        axes(picture, &frame);
        self.bar(picture, &frame, top, &levels);
        picture.text((frame.left, frame.top - 44.0), self.title, Type { size: 17, colour: INK, anchor: Anchor::Start });
        picture.text((frame.left, frame.top - 27.0), self.subtitle, Type { size: 11, colour: FAINT, anchor: Anchor::Start });
    }

    fn paint(&self, picture: &mut Picture, frame: &Frame<'_>, top: f64) {
        let field = self.field;
        let size = (frame.side / f64::from(field.columns), frame.side / f64::from(field.rows));
        let cells = (0..field.rows).flat_map(|row| (0..field.columns).map(move |column| (column, row)));
        let cells = cells.map(|(column, row)| {
            let (x, y) = frame.place(field.centre(column, row));
            ((x - size.0 / 2.0, y - size.1 / 2.0), self.colours.colour(field.value(column, row) / top))
        });
        picture.cells(size, cells);
    }

    /// Level lines are light on dark colours and dark on light ones.
    fn line_colour(&self, t: f64) -> (u8, u8, u8) {
        let (red, green, blue) = self.colours.colour(t);
        let toward = |c: u8, goal: u16| u8::try_from((u16::from(c) * 5 + goal * 4) / 9).unwrap_or(u8::MAX);
        let brightness = 2 * u16::from(red) + 5 * u16::from(green) + u16::from(blue);
        let goal = if brightness > 8 * 110 { 0 } else { 255 };
        (toward(red, goal), toward(green, goal), toward(blue, goal))
    }

    fn bar(&self, picture: &mut Picture, frame: &Frame<'_>, top: f64, levels: &Ticks) {
        let (left, bottom) = (frame.left + frame.side + BAR_GAP, frame.top + frame.side);
        let height = |value: f64| bottom - frame.side * value / top;
        let strips = (0..SIDE).map(|i| {
            let t = (f64::from(i) + 0.5) / f64::from(SIDE);
            ((left, bottom - f64::from(i) - 1.0), self.colours.colour(t))
        });
        picture.cells((BAR_WIDTH, 1.0), strips);
        rectangle(picture, (left, frame.top), (BAR_WIDTH, frame.side));
        for &level in &levels.values {
            let (colour, y) = (self.line_colour(level / top), height(level));
            if level > 0.0 {
                picture.line(&[(left + 0.5, y), (left + BAR_WIDTH - 0.5, y)], Stroke::solid(colour, 0.9));
            }
            picture.line(&[(left + BAR_WIDTH, y), (left + BAR_WIDTH + 4.0, y)], Stroke::solid(INK, 0.8));
            picture.text(
                (left + BAR_WIDTH + 8.0, y + 4.0),
                &levels.label(level),
                Type { size: 11, colour: INK, anchor: Anchor::Start },
            );
        }
        let name = Type { size: 12, colour: INK, anchor: Anchor::End };
        picture.text((left + BAR_WIDTH + 36.0, frame.top - 9.0), self.quantity, name);
    }
}

/// Where the window of a field stands in the picture.
struct Frame<'a> {
    left: f64,
    top: f64,
    side: f64,
    field: &'a Field,
}

impl Frame<'_> {
    fn place(&self, (x, y): Point) -> Point {
        let ([x0, x1], [y0, y1]) = (self.field.window.x, self.field.window.y);
        (self.left + self.side * (x - x0) / (x1 - x0), self.top + self.side * (y1 - y) / (y1 - y0))
    }
}

fn axes(picture: &mut Picture, frame: &Frame<'_>) {
    let label = |anchor| Type { size: 11, colour: INK, anchor };
    let (window, bottom) = (frame.field.window, frame.top + frame.side);
    rectangle(picture, (frame.left, frame.top), (frame.side, frame.side));
    let along_x = ticks(window.x[0], window.x[1], 7);
    for &x in &along_x.values {
        let (place, _) = frame.place((x, window.y[0]));
        picture.line(&[(place, bottom), (place, bottom + 4.0)], Stroke::solid(INK, 0.8));
        picture.text((place, bottom + 17.0), &along_x.label(x), label(Anchor::Middle));
    }
    let along_y = ticks(window.y[0], window.y[1], 7);
    for &y in &along_y.values {
        let (_, place) = frame.place((window.x[0], y));
        picture.line(&[(frame.left - 4.0, place), (frame.left, place)], Stroke::solid(INK, 0.8));
        picture.text((frame.left - 8.0, place + 4.0), &along_y.label(y), label(Anchor::End));
    }
    picture.text((frame.left + frame.side / 2.0, bottom + 34.0), "x (m)", Type { size: 12, ..label(Anchor::Middle) });
    picture.text((frame.left - 8.0, frame.top - 9.0), "y (m)", Type { size: 12, ..label(Anchor::End) });
}

fn rectangle(picture: &mut Picture, (x, y): Point, (width, height): Point) {
    picture.outline(&[(x, y), (x + width, y), (x + width, y + height), (x, y + height)], Stroke::solid(INK, 0.8));
}

/// A white cross with a dark rim, to be seen on any colour.
fn cross(picture: &mut Picture, (x, y): Point) {
    for (stroke, reach) in [(Stroke::solid(INK, 2.6), 5.0), (Stroke::solid((255, 255, 255), 1.2), 4.4)] {
        picture.line(&[(x - reach, y), (x + reach, y)], stroke);
        picture.line(&[(x, y - reach), (x, y + reach)], stroke);
    }
}

/// Round numbers over a range.
pub(crate) struct Ticks {
    /// The numbers, rising.
    pub(crate) values: Vec<f64>,
    decimals: usize,
}

impl Ticks {
    /// A number with the digits that tell it from its neighbours.
    pub(crate) fn label(&self, value: f64) -> String {
        format!("{value:.*}", self.decimals).replace('-', "\u{2212}")
    }
}

/// The multiples of 1, 2 or 5 times a power of ten in [`low`, `high`], about `count` of them.
pub(crate) fn ticks(low: f64, high: f64, count: u32) -> Ticks {
    let rough = (high - low) / f64::from(count);
    let (mut power, mut decimals) = (1.0, 0);
    while power > rough {
        (power, decimals) = (power / 10.0, decimals + 1);
    }
    while power * 10.0 <= rough {
        power *= 10.0;
    }
    let (step, finer) = [(1.0, 0), (2.0, 0), (5.0, 0), (10.0, 1)]
        .map(|(m, finer)| (m * power, finer))
        .into_iter()
        .find(|(step, _)| *step >= rough)
        .unwrap_or((rough, 0));
    let (first, last) = ((low / step - 1e-9).ceil(), (high / step + 1e-9).floor());
    // Multiples of the step, not sums of it, so that 0 is 0.
    let values =
        std::iter::successors(Some(first), |i| Some(i + 1.0)).take_while(|i| *i <= last).map(|i| i * step + 0.0).collect();
    Ticks { values, decimals: usize::saturating_sub(decimals, finer) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        let labels = |low, high, count| {
            let ticks = ticks(low, high, count);
            ticks.values.iter().map(|v| ticks.label(*v)).collect::<Vec<_>>().join(" ")
        };
        assert_eq!(labels(0.0, 0.1123, 8), "0.00 0.02 0.04 0.06 0.08 0.10");
        assert_eq!(labels(-1.0, 2.0, 7), "−1.0 −0.5 0.0 0.5 1.0 1.5 2.0");
        assert_eq!(labels(0.0, 80.0, 8), "0 10 20 30 40 50 60 70 80");
        assert_eq!(labels(0.0, 7.9, 1), "0");
    }
}
