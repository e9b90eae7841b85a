//! A quantity over a square of a plane: colours with level lines, arrows of the gradient, outlines, axes and a scale.

use std::error::Error;

use super::convex::Point;
use super::sketch::head;
use super::svg::{Anchor, Svg, around, through};
use crate::figures::field::Field;
use crate::figures::panel::ticks;
use crate::plot::{Colours, Picture};

/// Cells along a side.
pub(super) const CELLS: u32 = 120;
/// An arrow every so many cells.
const EVERY: u32 = 8;

const SIZE: (f64, f64) = (420.0, 384.0);
const LEFT: f64 = 46.0;
const TOP: f64 = 40.0;
const SIDE: f64 = 300.0;

/// The contents of a map.
pub(super) struct Map<'a> {
    /// Over the map.
    pub(super) heading: &'a str,
    /// Name and unit of the quantity, over its scale.
    pub(super) unit: &'a str,
    /// The quantity, `CELLS` by `CELLS`.
    pub(super) field: &'a Field,
    pub(super) colours: Colours,
    /// The gradient along the plane, drawn as arrows.
    pub(super) arrows: Option<&'a [Field; 2]>,
    /// Closed lines, each with its class.
    pub(super) outlines: &'a [(&'static str, Vec<Point>)],
}

impl Map<'_> {
    /// The picture, called `title` for those who do not see it.
    pub(super) fn draw(&self, title: &str) -> Result<String, Box<dyn Error>> {
        let (field, unit) = (self.field, self.unit);
        let (top, _) = field.largest();
        let mut svg = Svg::new(SIZE.0, SIZE.1);
        svg.text("title", (LEFT, 18.0), Anchor::Start, self.heading);
        svg.image(&self.raster(top)?, (LEFT, TOP), (SIDE, SIDE));
        let levels = ticks(0.0, top, 8);
        for &level in levels.values.iter().filter(|level| **level > 0.0) {
            let commands: String =
                field.level_line(level).into_iter().map(|ends| through(&ends.map(|p| self.place(p)))).collect();
            svg.path(if level > 0.55 * top { "level dark" } else { "level" }, &commands);
        }
        for (class, outline) in self.outlines {
            svg.path(class, &around(&outline.iter().map(|p| self.place(*p)).collect::<Vec<_>>()));
        }
        if let Some(along) = self.arrows {
            let commands = arrow_heads(along);
            svg.path("arrow rim", &commands);
            svg.path("arrow", &commands);
        }
        self.axes(&mut svg);
        self.scale(&mut svg, top, &levels.values.iter().map(|v| (*v, levels.label(*v))).collect::<Vec<_>>());
        let [across, up] = [field.window.x, field.window.y].map(|[from, to]| to - from);
        let description = format!(
            "{unit} from 0 to {top:.4} over {across} m by {up} m, with level lines{}.",
            if self.arrows.is_some() { " and arrows of the gradient" } else { "" }
        );
        Ok(svg.finish("plot", title, &description))
    }

    fn place(&self, (x, y): Point) -> Point {
        let ([x0, x1], [y0, y1]) = (self.field.window.x, self.field.window.y);
        (LEFT + SIDE * (x - x0) / (x1 - x0), TOP + SIDE * (y1 - y) / (y1 - y0))
    }

    /// The field as a PNG, a point a cell.
    fn raster(&self, top: f64) -> Result<Vec<u8>, String> {
        let mut picture = Picture::new(f64::from(CELLS), f64::from(CELLS));
        let cells = (0..CELLS).flat_map(|row| (0..CELLS).map(move |column| (column, row)));
        let colour = |(column, row)| {
            ((f64::from(column), f64::from(CELLS - 1 - row)), self.colours.colour(self.field.value(column, row) / top))
        };
        picture.cells((1.0, 1.0), cells.map(colour));
        picture.png(1.0)
    }

    fn axes(&self, svg: &mut Svg) {
        let window = self.field.window;
        svg.rectangle("frame", (LEFT, TOP), (SIDE, SIDE));
        for x in ticks(window.x[0], window.x[1], 6).values {
            let (at, _) = self.place((x, 0.0));
            svg.line("axis", (at, TOP + SIDE), (at, TOP + SIDE + 4.0));
            svg.text("tick", (at, TOP + SIDE + 16.0), Anchor::Middle, &format!("{x}").replace('-', "−"));
        }
        for y in ticks(window.y[0], window.y[1], 6).values {
            let (_, at) = self.place((0.0, y));
            svg.line("axis", (LEFT - 4.0, at), (LEFT, at));
            svg.text("tick", (LEFT - 7.0, at + 3.5), Anchor::End, &format!("{y}").replace('-', "−"));
        }
        svg.text("label", (LEFT + SIDE / 2.0, TOP + SIDE + 34.0), Anchor::Middle, "x (m)");
        svg.text_upward("label", (12.0, TOP + SIDE / 2.0), "y (m)");
    }

    fn scale(&self, svg: &mut Svg, top: f64, levels: &[(f64, String)]) {
        let (left, steps) = (LEFT + SIDE + 14.0, 60u32);
        let height = SIDE / f64::from(steps);
        for step in 0..steps {
            let (t, y) = ((f64::from(step) + 0.5) / f64::from(steps), TOP + SIDE - height * (f64::from(step) + 0.5));
            svg.painted("bar-step", self.colours.colour(t), &through(&[(left, y), (left + 14.0, y)]));
        }
        svg.rectangle("frame", (left, TOP), (14.0, SIDE));
        for (level, label) in levels {
            let y = TOP + SIDE * (1.0 - level / top);
            svg.line("axis", (left + 14.0, y), (left + 18.0, y));
            svg.text("tick", (left + 21.0, y + 3.5), Anchor::Start, label);
        }
        svg.text("label", (left + 40.0, TOP - 8.0), Anchor::End, self.unit);
    }
}

/// Arrows up the slope, the steepest as long as they are apart.
fn arrow_heads([along_x, along_y]: &[Field; 2]) -> String {
    let spacing = SIDE * f64::from(EVERY) / f64::from(CELLS);
    let places = || {
        (EVERY / 2..CELLS).step_by(EVERY as usize).flat_map(|j| (EVERY / 2..CELLS).step_by(EVERY as usize).map(move |i| (i, j)))
    };
    let slope = |(i, j)| (along_x.value(i, j), along_y.value(i, j));
    let norm = |(x, y): Point| (x * x + y * y).sqrt();
    let steepest = places().map(|place| norm(slope(place))).fold(0.0, f64::max);
    let arrow = |(i, j)| {
        let (gx, gy) = slope((i, j));
        let centre = |index: u32| SIDE * (f64::from(index) + 0.5) / f64::from(CELLS);
        let (x, y) = (LEFT + centre(i), TOP + SIDE - centre(j));
        let reach = 0.5 * 1.25 * spacing / steepest;
        let (tail, tip) = ((x - reach * gx, y + reach * gy), (x + reach * gx, y - reach * gy));
        through(&[tail, tip]) + &head(tail, tip)
    };
    places().filter(|place| norm(slope(*place)) > 0.02 * steepest).map(arrow).collect()
}
