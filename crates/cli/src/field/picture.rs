//! The field as a picture of three panels, each with a scale of colours below it: the value from 0, the length of the gradient
//! from 0 to the size that a fiftieth of the cells exceed, with arrows along its part in the face, and the decades of the value's
//! proven bound. The first row of cells is at the bottom, the face's first side runs to the right. The numbers at the ends of the
//! scales are in text chunks as well, to all digits.

mod canvas;
mod glyphs;

use std::io::Write;

use radgrad_scene::{FieldCell, largest, smallest};

use canvas::{Canvas, INK, colour};

/// Decades of a scale, at most: next to a point in the dark a bound is as good as 0.
const MOST_DECADES: i32 = 6;

/// Pixels along a panel, at least.
const PANEL: usize = 320;
const MARGIN: usize = 16;
const TITLE: usize = 28;
/// Height of a scale of colours and of the numbers below it.
const SCALE: usize = 12;
const NUMBERS: usize = 34;
/// Arrows along a panel.
const ARROWS: usize = 16;

/// A quantity over the grid, and the ends of its scale.
struct Panel {
    title: &'static str,
    shares: Vec<f64>,
    ends: [f64; 2],
}

impl Panel {
    /// From 0 to the largest value but for a share of all; larger ones look like it.
    fn from_zero(title: &'static str, figures: Vec<f64>, beyond: f64) -> Self {
        let mut known: Vec<f64> = figures.iter().copied().filter(|figure| figure.is_finite()).collect();
        known.sort_by(f64::total_cmp);
        let most = known.iter().rev().nth(count_of(known.len(), beyond)).copied().unwrap_or(0.0);
        let share = |figure: f64| if most > 0.0 { figure / most } else { 0.0 };
        Self { title, shares: figures.into_iter().map(share).collect(), ends: [0.0, most] }
    }

    /// By decades, from the smallest that is not 0, or a millionth of the largest, to that.
    fn of_decades(title: &'static str, figures: &[f64]) -> Self {
        let known = || figures.iter().copied().filter(|figure| *figure > 0.0 && figure.is_finite());
        let most = known().fold(0.0, largest);
        let least = largest(known().fold(most, smallest), most * 10.0_f64.powi(-MOST_DECADES));
        let span = (most / least).log10();
        let share = |figure: &f64| if *figure > least && span > 0.0 { (figure / least).log10() / span } else { 0.0 };
        Self { title, shares: figures.iter().map(share).collect(), ends: [least, most] }
    }
}

pub(super) fn write(out: impl Write, cells: &[FieldCell], grid: usize) -> Result<(), png::EncodingError> {
    let value = Panel::from_zero("value", cells.iter().map(|cell| cell.value).collect(), 0.0);
    let gradient = Panel::from_zero("gradient", cells.iter().map(|cell| cell.gradient.length()).collect(), 0.02);
    let bound = Panel::of_decades("bound", &cells.iter().map(|cell| cell.value_error).collect::<Vec<_>>());
    let cell = PANEL.div_ceil(grid);
    let side = cell * grid;
    let panels = [&value, &gradient, &bound];
    let mut canvas = Canvas::new(MARGIN + panels.len() * (side + MARGIN), TITLE + side + MARGIN / 2 + SCALE + NUMBERS);
    for (place, panel) in panels.iter().enumerate() {
        let left = MARGIN + place * (side + MARGIN);
        canvas.text([left, 8], panel.title);
        for (k, share) in panel.shares.iter().enumerate() {
            canvas.fill([left + k % grid * cell, TITLE + (grid - 1 - k / grid) * cell], [cell, cell], colour(*share));
        }
        let top = TITLE + side + MARGIN / 2;
        for x in 0..side {
            canvas.fill([left + x, top], [1, SCALE], colour(x as f64 / side as f64));
        }
        let [least, most] = panel.ends.map(number);
        canvas.text([left, top + SCALE + 6], &least);
        canvas.text([left + side - Canvas::width_of(&most), top + SCALE + 6], &most);
    }
    draw_arrows(&mut canvas, [2 * MARGIN + side, TITLE], cells, [grid, cell], gradient.ends[1]);
    let chunks = panels.map(|panel| (panel.title.to_owned(), format!("{:?} to {:?}", panel.ends[0], panel.ends[1])));
    canvas.encode(out, chunks)
}

/// Arrows along the part of the gradient in the face: as long as they are apart where it is `most`, and no longer.
fn draw_arrows(canvas: &mut Canvas, [left, top]: [usize; 2], cells: &[FieldCell], [grid, cell]: [usize; 2], most: f64) {
    let along = |cell: &FieldCell| {
        let [right, up] = [cell.corners[1] - cell.corners[0], cell.corners[3] - cell.corners[0]];
        [cell.gradient.dot(right.normalize_or_zero()), cell.gradient.dot(up.normalize_or_zero())]
    };
    if most <= 0.0 || !most.is_finite() {
        return;
    }
    let step = grid.div_ceil(ARROWS);
    let longest = (step * cell) as f64;
    for row in (step / 2..grid).step_by(step) {
        for column in (step / 2..grid).step_by(step) {
            let [x, y] = along(&cells[row * grid + column]).map(|part| part / most);
            let scale = longest / largest(x.hypot(y), 1.0);
            let middle = [left + column * cell + cell / 2, top + (grid - 1 - row) * cell + cell / 2].map(|place| place as f64);
            canvas.arrow(middle, [x * scale, -y * scale], INK);
        }
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a count")]
fn count_of(all: usize, share: f64) -> usize {
    (all as f64 * share) as usize
}

/// Three digits.
fn number(figure: f64) -> String {
    if figure == 0.0 || (1e-3..1e4).contains(&figure) { format!("{figure:.3}") } else { format!("{figure:.2e}") }
}
