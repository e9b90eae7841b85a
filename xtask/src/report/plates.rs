//! The paper's figures A to E from the closed form: radiosity and its gradient on a plane under a triangle, with arrows.

use std::error::Error;

use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, radiosity_and_gradient};
use serde::Serialize;

use super::sketch::head;
use super::svg::{Anchor, Svg, around, through};
use crate::figures::field::Field;
use crate::figures::panel::ticks;
use crate::figures::{LINEAR, TRIANGLE, WINDOW, geometry_picture};
use crate::plot::{Colours, Picture};

/// Cells along a side.
const CELLS: u32 = 120;
/// An arrow every so many cells.
const EVERY: u32 = 8;

const SIZE: (f64, f64) = (420.0, 384.0);
const LEFT: f64 = 46.0;
const TOP: f64 = 40.0;
const SIDE: f64 = 300.0;

/// What figure E shows, for those who do not see it.
const SCENE: &str =
    "A triangle 1 m over a plane, with lines of equal radiosity, a receiver point and the vector to a point of the emitter.";

/// A figure with its caption.
#[derive(Debug, Serialize)]
pub(super) struct Plate {
    picture: String,
    caption: String,
}

/// Radiosity and the gradient's two parts along the plane.
struct Sampled {
    value: Field,
    along: [Field; 2],
    norm: Field,
}

impl Sampled {
    fn of(emission: Emission) -> Result<Self, radgrad_core::Error> {
        let emitter = Emitter::new(Polygon::new(TRIANGLE.to_vec())?, emission)?;
        let answer = |x: f64, y: f64| radiosity_and_gradient(&Receiver::new(DVec3::new(x, y, 0.0), DVec3::Z, 1.0)?, &emitter);
        let field = |of: fn((f64, DVec3)) -> f64| Field::sample(WINDOW, [CELLS; 2], |x, y| answer(x, y).map(of));
        Ok(Self {
            value: field(|(b, _)| b)?,
            along: [field(|(_, g)| g.x)?, field(|(_, g)| g.y)?],
            norm: field(|(_, g)| g.truncate().length())?,
        })
    }
}

/// The plates, and the file of their values.
pub(super) fn plates() -> Result<(Vec<Plate>, Vec<u8>), Box<dyn Error>> {
    let (constant, linear) = (Sampled::of(Emission::Constant(1.0))?, Sampled::of(Emission::at_vertices(LINEAR.to_vec()))?);
    let mut plates = Vec::with_capacity(5);
    for (letters, sampled, emission) in
        [(["A", "B"], &constant, "1 W/m² all over"), (["C", "D"], &linear, "1, 2 and 4 W/m² at its vertices, linear between")]
    {
        let (largest, (x, y)) = sampled.value.largest();
        plates.push(Plate {
            picture: plate(letters[0], "Radiosity", "B (W/m²)", &sampled.value, Colours::Viridis, Some(&sampled.along))?,
            caption: format!(
                "{}. Radiosity on the plane; emitter {emission}. Largest near ({x:.2}, {y:.2}) m: {largest:.4} W/m². Arrows: the \
                 gradient along the plane, as long as it is steep.",
                letters[0]
            ),
        });
        plates.push(Plate {
            picture: plate(letters[1], "Gradient norm", "|∇B| (W/m³)", &sampled.norm, Colours::Inferno, None)?,
            caption: format!("{}. Norm of that gradient; at most {:.4} W/m³.", letters[1], sampled.norm.largest().0),
        });
    }
    plates.push(Plate {
        picture: geometry_picture(&constant.value).svg_element("plot paper", "E. Geometry of the scene", SCENE),
        caption: "E. The scene: a triangular emitter 1 m over a parallel plane of reflectance 1.".to_owned(),
    });
    Ok((plates, csv(&constant, &linear)?))
}

fn plate(
    letter: &str,
    what: &str,
    unit: &str,
    field: &Field,
    colours: Colours,
    arrows: Option<&[Field; 2]>,
) -> Result<String, Box<dyn Error>> {
    let (top, _) = field.largest();
    let mut svg = Svg::new(SIZE.0, SIZE.1);
    svg.text("title", (LEFT, 18.0), Anchor::Start, &format!("{letter}   {what}"));
    let place = |(x, y): (f64, f64)| {
        let ([x0, x1], [y0, y1]) = (WINDOW.x, WINDOW.y);
        (LEFT + SIDE * (x - x0) / (x1 - x0), TOP + SIDE * (y1 - y) / (y1 - y0))
    };
    svg.image(&raster(field, colours, top)?, (LEFT, TOP), (SIDE, SIDE));
    let levels = ticks(0.0, top, 8);
    for &level in levels.values.iter().filter(|level| **level > 0.0) {
        let commands: String = field.level_line(level).into_iter().map(|ends| through(&ends.map(place))).collect();
        svg.path(if level > 0.55 * top { "level dark" } else { "level" }, &commands);
    }
    svg.path("outline", &around(&TRIANGLE.map(|v| place((v.x, v.y)))));
    if let Some(along) = arrows {
        let commands = arrow_heads(along);
        svg.path("arrow rim", &commands);
        svg.path("arrow", &commands);
    }
    svg.rectangle("frame", (LEFT, TOP), (SIDE, SIDE));
    for x in ticks(WINDOW.x[0], WINDOW.x[1], 6).values {
        let (at, _) = place((x, 0.0));
        svg.line("axis", (at, TOP + SIDE), (at, TOP + SIDE + 4.0));
        svg.text("tick", (at, TOP + SIDE + 16.0), Anchor::Middle, &format!("{x}").replace('-', "−"));
    }
    for y in ticks(WINDOW.y[0], WINDOW.y[1], 6).values {
        let (_, at) = place((0.0, y));
        svg.line("axis", (LEFT - 4.0, at), (LEFT, at));
        svg.text("tick", (LEFT - 7.0, at + 3.5), Anchor::End, &format!("{y}").replace('-', "−"));
    }
    svg.text("label", (LEFT + SIDE / 2.0, TOP + SIDE + 34.0), Anchor::Middle, "x (m)");
    svg.text_upward("label", (12.0, TOP + SIDE / 2.0), "y (m)");
    bar(&mut svg, colours, top, &levels.values.iter().map(|v| (*v, levels.label(*v))).collect::<Vec<_>>(), unit);
    Ok(svg.finish(
        "plot",
        &format!("Figure {letter}: {what} on the plane"),
        &format!(
            "{unit} from 0 to {top:.4} over 3 m by 3 m, with level lines{}.",
            if arrows.is_some() { " and arrows of the gradient" } else { "" }
        ),
    ))
}

/// The field as a PNG, a point a cell.
fn raster(field: &Field, colours: Colours, top: f64) -> Result<Vec<u8>, String> {
    let mut picture = Picture::new(f64::from(CELLS), f64::from(CELLS));
    let cells = (0..CELLS).flat_map(|row| (0..CELLS).map(move |column| (column, row)));
    let colour = |(column, row)| ((f64::from(column), f64::from(CELLS - 1 - row)), colours.at(field.at(column, row) / top));
    picture.cells((1.0, 1.0), cells.map(colour));
    picture.png(1.0)
}

/// Arrows up the slope, the steepest as long as they are apart.
fn arrow_heads([along_x, along_y]: &[Field; 2]) -> String {
    let spacing = SIDE * f64::from(EVERY) / f64::from(CELLS);
    let places = || {
        (EVERY / 2..CELLS).step_by(EVERY as usize).flat_map(|j| (EVERY / 2..CELLS).step_by(EVERY as usize).map(move |i| (i, j)))
    };
    let slope = |(i, j)| (along_x.at(i, j), along_y.at(i, j));
    let norm = |(x, y): (f64, f64)| (x * x + y * y).sqrt();
    let steepest = places().map(|place| norm(slope(place))).fold(0.0, f64::max);
    let arrow = |(i, j)| {
        let (gx, gy) = slope((i, j));
        let at = |index: u32| SIDE * (f64::from(index) + 0.5) / f64::from(CELLS);
        let (x, y) = (LEFT + at(i), TOP + SIDE - at(j));
        let reach = 0.5 * 1.25 * spacing / steepest;
        let (tail, tip) = ((x - reach * gx, y + reach * gy), (x + reach * gx, y - reach * gy));
        through(&[tail, tip]) + &head(tail, tip)
    };
    places().filter(|place| norm(slope(*place)) > 0.02 * steepest).map(arrow).collect()
}

fn bar(svg: &mut Svg, colours: Colours, top: f64, levels: &[(f64, String)], unit: &str) {
    let (left, steps) = (LEFT + SIDE + 14.0, 60u32);
    let height = SIDE / f64::from(steps);
    for step in 0..steps {
        let (t, y) = ((f64::from(step) + 0.5) / f64::from(steps), TOP + SIDE - height * (f64::from(step) + 0.5));
        svg.painted("bar-step", colours.at(t), &through(&[(left, y), (left + 14.0, y)]));
    }
    svg.rectangle("frame", (left, TOP), (14.0, SIDE));
    for (level, label) in levels {
        let y = TOP + SIDE * (1.0 - level / top);
        svg.line("axis", (left + 14.0, y), (left + 18.0, y));
        svg.text("tick", (left + 21.0, y + 3.5), Anchor::Start, label);
    }
    svg.text("label", (left + 40.0, TOP - 8.0), Anchor::End, unit);
}

/// `x,y` and radiosity and gradient along the plane for the constant and for the linear emitter.
fn csv(constant: &Sampled, linear: &Sampled) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut rows = csv::Writer::from_writer(Vec::new());
    rows.write_record(["x", "y", "constant", "constant-dx", "constant-dy", "linear", "linear-dx", "linear-dy"])?;
    for row in 0..CELLS {
        for column in 0..CELLS {
            let (x, y) = constant.value.centre(column, row);
            let of = |sampled: &Sampled| {
                [&sampled.value, &sampled.along[0], &sampled.along[1]].map(|f| format!("{:.6e}", f.at(column, row)))
            };
            rows.write_record([format!("{x:.4}"), format!("{y:.4}")].iter().chain(&of(constant)).chain(&of(linear)))?;
        }
    }
    Ok(rows.into_inner()?)
}
