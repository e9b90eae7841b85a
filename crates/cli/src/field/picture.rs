//! The field as a picture of three panels, each with a scale of colours below it: the value from 0, the length of the gradient
//! from 0 to the size that a fiftieth of the cells exceed, with arrows along its part in the face, and the decades of the value's
//! proven bound. Panels have the proportions of the face. The first row of cells is at the bottom, the face's first side runs to the right. Above stands what is shown, on which
//! surface and in which unit, along the sides how long they are; a scale that is cut says so, with the largest or least value there is.
//! The numbers at the ends of the scales are in text chunks as well, to all digits.

mod canvas;
mod glyphs;

use std::io::Write;

use radgrad_scene::{FieldCell, largest, smallest};

use canvas::INK;
pub(crate) use canvas::{Canvas, colour};

/// Decades of a scale, at most: next to a point in the dark a bound is as good as 0.
const MOST_DECADES: i32 = 6;

/// Pixels along the longer side of a panel, at least; and of the scale below it.
const PANEL: usize = 320;
const LEAST: usize = 200;
const MARGIN: usize = 16;
const TITLE: usize = 52;
/// Left of a panel: the length of its side.
const LENGTHS: usize = 80;
/// Height of a scale of colours and of the numbers below it.
const SCALE: usize = 12;
const NUMBERS: usize = 60;
/// Arrows along a panel.
const ARROWS: usize = 16;

/// A quantity over the grid, and the ends of its scale.
struct Panel {
    title: &'static str,
    unit: &'static str,
    shares: Vec<f64>,
    ends: [f64; 2],
    /// What is beyond an end.
    beyond: [Option<f64>; 2],
}

/// What the picture is of.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shown<'a> {
    /// Irradiance, or the factor to a surface.
    pub(super) quantity: &'a str,
    pub(super) surface: &'a str,
    /// Units of the value and of its gradient.
    pub(super) units: [&'static str; 2],
}

impl Panel {
    /// From 0 to the largest value but for a share of all; larger ones look like it.
    fn from_zero(title: &'static str, unit: &'static str, figures: Vec<f64>, beyond: f64) -> Self {
        let mut known: Vec<f64> = figures.iter().copied().filter(|figure| figure.is_finite()).collect();
        known.sort_by(f64::total_cmp);
        let most = known.iter().rev().nth(count_of(known.len(), beyond)).copied().unwrap_or(0.0);
        let share = |figure: f64| if most > 0.0 { figure / most } else { 0.0 };
        let past = known.last().copied().filter(|last| *last > most);
        Self { title, unit, shares: figures.into_iter().map(share).collect(), ends: [0.0, most], beyond: [None, past] }
    }

    /// By decades, from the smallest that is not 0, or a millionth of the largest, to that.
    fn of_decades(title: &'static str, unit: &'static str, figures: &[f64]) -> Self {
        let known = || figures.iter().copied().filter(|figure| *figure > 0.0 && figure.is_finite());
        let most = known().fold(0.0, largest);
        let least = largest(known().fold(most, smallest), most * 10.0_f64.powi(-MOST_DECADES));
        let span = (most / least).log10();
        let share = |figure: &f64| if *figure > least && span > 0.0 { (figure / least).log10() / span } else { 0.0 };
        let smallest_one = figures.iter().copied().filter(|figure| figure.is_finite()).fold(most, smallest);
        let below = Some(smallest_one).filter(|figure| *figure < least);
        Self { title, unit, shares: figures.iter().map(share).collect(), ends: [least, most], beyond: [below, None] }
    }
}

pub(super) fn write(out: impl Write, cells: &[FieldCell], grid: usize, shown: Shown<'_>) -> Result<(), png::EncodingError> {
    let [unit, steepness] = shown.units;
    let value = Panel::from_zero("value", unit, cells.iter().map(|cell| cell.value).collect(), 0.0);
    let gradient = Panel::from_zero("gradient", steepness, cells.iter().map(|cell| cell.gradient.length()).collect(), 0.02);
    let bound = Panel::of_decades("bound", unit, &cells.iter().map(|cell| cell.value_error).collect::<Vec<_>>());
    let lengths = [1, 3].map(|corner| cells.first().map_or(0.0, |first| (first.corners[corner] - first.corners[0]).length()));
    let cell = cell_of(lengths, grid);
    let side = cell.map(|pixels| pixels * grid);
    let panels = [&value, &gradient, &bound];
    // The numbers below a scale take room too.
    let step = LENGTHS + side[0].max(LEAST) + MARGIN;
    let head = format!("{} on {}", shown.quantity, shown.surface);
    let width = (panels.len() * step).max(2 * MARGIN + Canvas::width_of(&head));
    let mut canvas = Canvas::new(width, TITLE + side[1] + MARGIN / 2 + 2 * NUMBERS + SCALE);
    canvas.text([MARGIN, 8], &head);
    let [across, up] = lengths.map(|length| number(length * grid as f64));
    for (place, panel) in panels.iter().enumerate() {
        let left = LENGTHS + place * step;
        canvas.text([left, TITLE - 22], &format!("{}: {}", panel.title, panel.unit));
        for (k, share) in panel.shares.iter().enumerate() {
            canvas.fill([left + k % grid * cell[0], TITLE + (grid - 1 - k / grid) * cell[1]], cell, colour(*share));
        }
        // The axes, from the face's first corner.
        let below = TITLE + side[1] + 6;
        canvas.text([left, below], "0");
        canvas.text([(left + side[0]).saturating_sub(Canvas::width_of(&across)), below], &across);
        canvas.text([left - Canvas::width_of("0") - 2, TITLE + side[1] - 16], "0");
        canvas.text([(left - 2).saturating_sub(Canvas::width_of(&up)), TITLE], &up);
        let top = TITLE + side[1] + NUMBERS / 2 + MARGIN / 2;
        let scale = side[0].max(LEAST);
        for x in 0..scale {
            canvas.fill([left + x, top], [1, SCALE], colour(x as f64 / scale as f64));
        }
        let [least, most] = panel.ends.map(number);
        let least = if panel.beyond[0].is_some() { format!("<={least}") } else { least };
        let most = if panel.beyond[1].is_some() { format!(">={most}") } else { most };
        canvas.text([left, top + SCALE + 6], &least);
        canvas.text([left + scale - Canvas::width_of(&most), top + SCALE + 6], &most);
        let said = match panel.beyond {
            [Some(least), _] => format!("cut: least is {}", number(least)),
            [_, Some(most)] => format!("cut: largest is {}", number(most)),
            _ => String::new(),
        };
        canvas.text([left, top + SCALE + 28], &said);
    }
    draw_arrows(&mut canvas, [LENGTHS + step, TITLE], cells, (grid, cell), gradient.ends[1]);
    let chunk = |panel: &Panel| {
        let cut = panel.beyond.iter().flatten().map(|figure| format!(", cut: {figure:?}")).collect::<String>();
        (panel.title.to_owned(), format!("{:?} to {:?}{cut}", panel.ends[0], panel.ends[1]))
    };
    canvas.encode(out, panels.map(chunk))
}

/// The pixels of a cell of a face whose cells have sides of these lengths.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most as many as along the longer side")]
fn cell_of(lengths: [f64; 2], grid: usize) -> [usize; 2] {
    let longer = largest(lengths[0], lengths[1]);
    // Cells of a narrow face have more pixels along, so that those across are few roundings off.
    let narrow = smallest(lengths[0], lengths[1]) / longer;
    let pixels = PANEL.div_ceil(grid).max(if narrow > 0.0 { (0.75 / narrow).min(4.0).ceil() as usize } else { 1 });
    lengths.map(|length| if longer > 0.0 { ((length / longer * pixels as f64).round() as usize).max(1) } else { pixels })
}

/// Arrows along the part of the gradient in the face: as long as they are apart where it is `most`, and no longer.
fn draw_arrows(
    canvas: &mut Canvas,
    [left, top]: [usize; 2],
    cells: &[FieldCell],
    (grid, [width, height]): (usize, [usize; 2]),
    most: f64,
) {
    let along = |cell: &FieldCell| {
        let [right, up] = [cell.corners[1] - cell.corners[0], cell.corners[3] - cell.corners[0]];
        [cell.gradient.dot(right.normalize_or_zero()), cell.gradient.dot(up.normalize_or_zero())]
    };
    if most <= 0.0 || !most.is_finite() {
        return;
    }
    // As far apart both ways.
    let steps = [width, height].map(|pixels| (width.max(height) * grid).div_ceil(ARROWS * pixels).min(grid));
    let longest = (steps[0] * width).min(steps[1] * height) as f64;
    for row in (steps[1] / 2..grid).step_by(steps[1]) {
        for column in (steps[0] / 2..grid).step_by(steps[0]) {
            let [x, y] = along(&cells[row * grid + column]).map(|part| part / most);
            let scale = longest / largest(x.hypot(y), 1.0);
            let middle =
                [left + column * width + width / 2, top + (grid - 1 - row) * height + height / 2].map(|place| place as f64);
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
