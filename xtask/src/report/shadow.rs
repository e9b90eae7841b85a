//! Light past an occluder: radiosity and its gradient on a floor, with the umbra, the penumbra and the lines where the slope of
//! the gradient jumps; and a cut across the shadow.
//!
//! Emitter, occluder and floor are parallel, at heights `H`, `G` and 0: a point `v` of the emitter casts the occluder's point `o`
//! to `t o + (1 - t) v`, `t = H/(H - G)`. For convex polygons the umbra is the intersection of the shadows of all emitter vertices,
//! the penumbra the hull of all such points, and the lines are seen where an edge of one passes a vertex of the other.

use std::error::Error;

use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, evaluate};

use super::convex::{Point, hull, left_of};
use super::map::{CELLS, Map};
use super::plates::Plate;
use super::svg::{Anchor, Svg, through};
use crate::figures::field::{Field, Window};
use crate::figures::panel::ticks;
use crate::plot::Colours;

/// The emitter, lit downward, in m.
const LAMP: [DVec3; 4] = [DVec3::new(-0.3, -0.3, H), DVec3::new(-0.3, 0.3, H), DVec3::new(0.3, 0.3, H), DVec3::new(0.3, -0.3, H)];
const SCREEN: [DVec3; 3] = [DVec3::new(-0.5, -0.4, G), DVec3::new(0.5, -0.3, G), DVec3::new(0.0, 0.55, G)];
const H: f64 = 2.0;
const G: f64 = 1.0;
/// In W/m2.
const EMISSION: f64 = 100.0;
/// The part of the floor shown, in m.
const WINDOW: Window = Window { x: [-1.6, 1.6], y: [-1.4, 1.8] };
/// The cut, along `x` at this `y`.
const CUT: f64 = -0.2;
const CUT_POINTS: u32 = 320;

/// The figures and the files of their values.
#[derive(Clone)]
pub(super) struct Shadow {
    pub(super) plates: Vec<Plate>,
    /// `shadow.csv`: on the floor.
    pub(super) floor: Vec<u8>,
    /// `shadow-cut.csv`.
    pub(super) cut: Vec<u8>,
}

/// Where the boundaries of the shadow are.
struct Outlines {
    umbra: Vec<Point>,
    penumbra: Vec<Point>,
    /// Shadows of the occluder from a vertex of the lamp, and images of the lamp through a vertex of the occluder.
    lines: Vec<Vec<Point>>,
}

impl Outlines {
    fn new() -> Self {
        let t = H / (H - G);
        let cast = |v: DVec3, o: DVec3| (t * o.x + (1.0 - t) * v.x, t * o.y + (1.0 - t) * v.y);
        let from_lamp = LAMP.map(|v| SCREEN.map(|o| cast(v, o)).to_vec());
        let through_screen = SCREEN.map(|o| LAMP.map(|v| cast(v, o)).to_vec());
        let common = |left: Vec<Point>, shadow: &Vec<Point>| {
            let sides = shadow.iter().zip(shadow.iter().cycle().skip(1));
            sides.fold(left, |left, (a, b)| left_of(&left, *a, *b))
        };
        Self {
            umbra: from_lamp[1..].iter().fold(from_lamp[0].clone(), common),
            penumbra: hull(&from_lamp.concat()),
            lines: from_lamp.into_iter().chain(through_screen).collect(),
        }
    }
}

/// Radiosity, gradient and their bounds at a point of the floor.
fn evaluate_floor(x: f64, y: f64) -> Result<[f64; 6], radgrad_core::Error> {
    let lamp = Emitter::new(Polygon::new(LAMP.to_vec())?, Emission::Constant(EMISSION))?;
    let screen = Polygon::new(SCREEN.to_vec())?;
    let answer = evaluate(&Receiver::new(DVec3::new(x, y, 0.0), DVec3::Z, 1.0)?, &lamp, &[screen])?;
    let g = answer.gradient;
    Ok([answer.radiosity, g.x, g.y, g.truncate().length(), answer.radiosity_error, answer.gradient_error])
}

/// Samples and draws.
pub(super) fn shadow() -> Result<Shadow, Box<dyn Error>> {
    let [value, along_x, along_y, norm, value_bound, gradient_bound] = Field::sample_each(WINDOW, [CELLS; 2], evaluate_floor)?;
    let outlines = Outlines::new();
    let bounds = [&value_bound, &gradient_bound].map(|field| field.largest().0);
    let along = [along_x, along_y];
    let edges = [("outline", outlines.penumbra.clone()), ("outline umbra", outlines.umbra.clone())];
    let lines: Vec<(&'static str, Vec<Point>)> = outlines.lines.iter().map(|line| ("critical", line.clone())).collect();
    let map = |heading, unit, field, colours, arrows, outlines| Map { heading, unit, field, colours, arrows, outlines };
    let radiosity = map("F   Radiosity", "B (W/m²)", &value, Colours::Viridis, Some(&along), &edges);
    let gradient = map("G   Gradient norm", "|∇B| (W/m³)", &norm, Colours::Inferno, None, &lines);
    let rows: Vec<CutPoint> = cut_places().map(|x| evaluate_floor(x, CUT).map(|values| (x, values))).collect::<Result<_, _>>()?;
    let (largest, _) = value.largest();
    let plates = vec![
        Plate {
            picture: radiosity.draw("Figure F: radiosity on a floor past an occluder")?,
            caption: format!(
                "F. A lamp of 0.6 m by 0.6 m, {EMISSION} W/m², {H} m over the floor; a triangle {G} m over it is in the way. Dashed: where \
                 the penumbra begins; solid: the umbra, where the answer is exactly 0. At most {largest:.3} W/m². Every value \
                 is certified: the largest bound is {:.0e} W/m².",
                bounds[0]
            ),
        },
        Plate {
            picture: gradient.draw("Figure G: norm of the gradient on a floor past an occluder")?,
            caption: format!(
                "G. Norm of the gradient along the floor. Lines: where an edge of the lamp or of the occluder is seen to pass a vertex \
                 of the other. The gradient is continuous there; its slope is not. The largest bound is {:.0e} W/m³.",
                bounds[1]
            ),
        },
        Plate {
            picture: cut_picture(&rows, &outlines),
            caption: format!(
                "H. The cut at y = {} m: the radiosity and its derivative along x, across both sides of the shadow.",
                format!("{CUT}").replace('-', "−")
            ),
        },
    ];
    Ok(Shadow { plates, floor: floor_csv(&value, &along, [&value_bound, &gradient_bound])?, cut: cut_csv(&rows)? })
}

/// The lines over the maps with their names.
pub(super) fn legend() -> String {
    let lines = [("penumbra", "penumbra begins"), ("umbra", "umbra"), ("critical", "the slope of the gradient jumps")];
    lines
        .map(|(class, name)| {
            let mut svg = Svg::new(28.0, 12.0);
            svg.rectangle("ground", (0.0, 0.0), (28.0, 12.0));
            svg.line(
                if class == "penumbra" {
                    "outline"
                } else if class == "umbra" {
                    "outline umbra"
                } else {
                    class
                },
                (2.0, 6.0),
                (26.0, 6.0),
            );
            format!("<span class=\"key\">{} {name}</span>", svg.finish("swatch", name, "line of the legend"))
        })
        .concat()
}

/// `x` and the values of [`evaluate_floor`] there.
type CutPoint = (f64, [f64; 6]);

fn cut_places() -> impl Iterator<Item = f64> {
    let [from, to] = WINDOW.x;
    (0..=CUT_POINTS).map(move |i| from + (to - from) * f64::from(i) / f64::from(CUT_POINTS))
}

/// Where the cut crosses a closed line, from left to right.
fn crossings(outline: &[Point]) -> Vec<f64> {
    let sides = outline.iter().zip(outline.iter().cycle().skip(1));
    let crossing = sides.filter(|(a, b)| (a.1 > CUT) != (b.1 > CUT)).map(|(a, b)| a.0 + (b.0 - a.0) * (CUT - a.1) / (b.1 - a.1));
    let mut crossings: Vec<f64> = crossing.collect();
    crossings.sort_by(f64::total_cmp);
    crossings
}

/// Two panels over one axis: radiosity, and its derivative along the cut.
fn cut_picture(rows: &[CutPoint], outlines: &Outlines) -> String {
    const SIZE: (f64, f64) = (860.0, 330.0);
    const SIDES: [f64; 2] = [64.0, 844.0];
    let x_at = |x: f64| SIDES[0] + (SIDES[1] - SIDES[0]) * (x - WINDOW.x[0]) / (WINDOW.x[1] - WINDOW.x[0]);
    let mut svg = Svg::new(SIZE.0, SIZE.1);
    svg.text("title", (SIDES[0], 18.0), Anchor::Start, &format!("H   Cut at y = {} m", format!("{CUT}").replace('-', "−")));
    let dark = crossings(&outlines.umbra);
    let half = crossings(&outlines.penumbra);
    for (index, (title, [top, bottom])) in [("B (W/m²)", [36.0, 150.0]), ("∂B/∂x (W/m³)", [172.0, 286.0])].into_iter().enumerate()
    {
        let values: Vec<f64> = rows.iter().map(|(_, of)| of[index]).collect();
        let [low, high] = [values.iter().copied().fold(0.0, f64::min), values.iter().copied().fold(0.0, f64::max)];
        let (low, high) = (low - 0.05 * (high - low), high + 0.08 * (high - low));
        let y_at = |y: f64| bottom - (bottom - top) * (y - low) / (high - low);
        for (class, ends) in [("penumbra", &half), ("dark", &dark)] {
            if let [from, .., to] = ends[..] {
                svg.rectangle(class, (x_at(from), top), (x_at(to) - x_at(from), bottom - top));
            }
        }
        let levels = ticks(low, high, 6);
        for &level in &levels.values {
            svg.line("grid", (SIDES[0], y_at(level)), (SIDES[1], y_at(level)));
            svg.text("tick", (SIDES[0] - 6.0, y_at(level) + 3.5), Anchor::End, &levels.label(level));
        }
        let line: Vec<Point> = rows.iter().map(|(x, of)| (x_at(*x), y_at(of[index]))).collect();
        svg.path("curve", &through(&line));
        svg.rectangle("frame", (SIDES[0], top), (SIDES[1] - SIDES[0], bottom - top));
        svg.text_upward("label", (14.0, (top + bottom) / 2.0), title);
        if index == 0 {
            let over = |svg: &mut Svg, ends: &[f64], what| {
                if let [from, .., to] = *ends {
                    svg.text("label", (x_at((from + to) / 2.0), top + 13.0), Anchor::Middle, what);
                }
            };
            over(&mut svg, &dark, "umbra");
            if let ([from, ..], [to, ..]) = (&half[..], &dark[..]) {
                over(&mut svg, &[*from, *to], "penumbra");
            }
            if let ([.., from], [.., to]) = (&dark[..], &half[..]) {
                over(&mut svg, &[*from, *to], "penumbra");
            }
        }
    }
    for x in ticks(WINDOW.x[0], WINDOW.x[1], 8).values {
        svg.line("axis", (x_at(x), 286.0), (x_at(x), 290.0));
        svg.text("tick", (x_at(x), 302.0), Anchor::Middle, &format!("{x:.1}").replace('-', "−"));
    }
    svg.text("label", ((SIDES[0] + SIDES[1]) / 2.0, 320.0), Anchor::Middle, "x (m)");
    svg.finish(
        "plot wide",
        "Figure H: a cut across the shadow",
        "Radiosity falls to 0 in the umbra and rises again; its derivative is 0 there and continuous, with kinks in the penumbra.",
    )
}

/// `x,y,radiosity,dx,dy,radiosity-bound,gradient-bound`.
fn floor_csv(value: &Field, along: &[Field; 2], bounds: [&Field; 2]) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut rows = csv::Writer::from_writer(Vec::new());
    rows.write_record(["x", "y", "radiosity", "dx", "dy", "radiosity-bound", "gradient-bound"])?;
    for (column, row) in (0..CELLS).flat_map(|row| (0..CELLS).map(move |column| (column, row))) {
        let (x, y) = value.centre(column, row);
        let values = [value, &along[0], &along[1]].map(|f| format!("{:.6e}", f.value(column, row)));
        let bounds = bounds.map(|f| format!("{:.0e}", f.value(column, row)));
        rows.write_record([format!("{x:.4}"), format!("{y:.4}")].iter().chain(&values).chain(&bounds))?;
    }
    Ok(rows.into_inner()?)
}

/// The same along the cut, without bounds.
fn cut_csv(points: &[CutPoint]) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut rows = csv::Writer::from_writer(Vec::new());
    rows.write_record(["x", "y", "radiosity", "dx", "dy"])?;
    for (x, [value, dx, dy, ..]) in points {
        let values = [value, dx, dy].map(|f| format!("{f:.6e}"));
        rows.write_record([format!("{x:.4}"), format!("{CUT:.4}")].iter().chain(&values))?;
    }
    Ok(rows.into_inner()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_inside(outline: &[Point], (x, y): Point) -> bool {
        let sides = outline.iter().zip(outline.iter().cycle().skip(1));
        sides.into_iter().all(|(a, b)| (b.0 - a.0) * (y - a.1) > (b.1 - a.1) * (x - a.0))
    }

    #[test]
    fn the_umbra_is_dark_the_penumbra_dimmer_than_without_the_occluder_and_all_else_as_bright() {
        let outlines = Outlines::new();
        let free = |x: f64, y: f64| {
            let lamp = Emitter::new(Polygon::new(LAMP.to_vec()).unwrap(), Emission::Constant(EMISSION)).unwrap();
            let receiver = Receiver::new(DVec3::new(x, y, 0.0), DVec3::Z, 1.0).unwrap();
            evaluate(&receiver, &lamp, &[]).unwrap()
        };
        let mut counts = [0; 3];
        for (x, y) in (0..40).flat_map(|i| (0..40).map(move |j| (-1.57 + 0.08 * f64::from(i), -1.37 + 0.08 * f64::from(j)))) {
            let ([value, .., bound, _], free) = (evaluate_floor(x, y).unwrap(), free(x, y));
            let within = bound + free.radiosity_error;
            let region = if is_inside(&outlines.umbra, (x, y)) {
                assert_eq!(value, 0.0, "({x}, {y}) is in the umbra");
                0
            } else if is_inside(&outlines.penumbra, (x, y)) {
                assert!(value > 0.0 && value < free.radiosity - within, "({x}, {y}) is in the penumbra: {value}");
                1
            } else {
                assert!((value - free.radiosity).abs() <= within, "({x}, {y}) is in the light: {value}");
                2
            };
            counts[region] += 1;
        }
        assert!(counts.iter().all(|count| *count > 20), "{counts:?}");
    }
}
