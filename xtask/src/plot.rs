//! Drawing in units of a picture, `y` downward, written as PNG or SVG: the only place that knows the plotting crate.

use kuva::PngBackend;
use kuva::backend::svg::SvgBackend;
use kuva::plot::ColorMap;
use kuva::render::color::Color;
use kuva::render::render::{PathData, Primitive, Scene, TextAnchor};

/// A place in a picture.
pub(crate) type Point = (f64, f64);

/// Red, green, blue.
pub(crate) type Rgb = (u8, u8, u8);

/// Black that is kind to the eye.
pub(crate) const INK: Rgb = (38, 38, 46);
/// For explanations.
pub(crate) const FAINT: Rgb = (112, 112, 122);

/// A scale of colours from dark to light, equal steps of which look equal.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Colours {
    /// Blue to yellow.
    Viridis,
    /// Black over red to yellow.
    Inferno,
}

impl Colours {
    /// The colour at `t` in [0, 1], in steps no eye can tell apart: neighbours that are equal make a file a quarter smaller.
    pub(crate) fn colour(self, t: f64) -> Rgb {
        const STEPS: f64 = 192.0;
        let map = match self {
            Self::Viridis => ColorMap::Viridis,
            Self::Inferno => ColorMap::Inferno,
        };
        map.map_rgb((STEPS * t).round() / STEPS).unwrap_or(INK)
    }
}

/// How a line is drawn.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stroke {
    /// Colour.
    pub(crate) colour: Rgb,
    /// Width.
    pub(crate) width: f64,
    /// Drawn as dashes.
    pub(crate) dashed: bool,
}

impl Stroke {
    /// A whole line.
    pub(crate) const fn solid(colour: Rgb, width: f64) -> Self {
        Self { colour, width, dashed: false }
    }

    /// A line of dashes.
    pub(crate) const fn dashed(colour: Rgb, width: f64) -> Self {
        Self { colour, width, dashed: true }
    }
}

/// Which part of a text stands at its place.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Anchor {
    /// Its start.
    Start,
    /// Its middle.
    Middle,
    /// Its end.
    End,
}

/// How a text is set.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Type {
    /// Height of the letters' box.
    pub(crate) size: u32,
    /// Colour.
    pub(crate) colour: Rgb,
    /// Which part stands at the given place.
    pub(crate) anchor: Anchor,
}

/// A picture under construction.
pub(crate) struct Picture {
    scene: Scene,
}

impl Picture {
    /// An empty white picture.
    pub(crate) fn new(width: f64, height: f64) -> Self {
        let mut scene = Scene::new(width, height);
        scene.font_family = Some("DejaVu Sans, Verdana, sans-serif".to_owned());
        Self { scene }
    }

    /// A line through `points`.
    pub(crate) fn line(&mut self, points: &[Point], stroke: Stroke) {
        if stroke.dashed {
            for (from, to) in points.windows(2).flat_map(|ends| dashes(ends[0], ends[1])) {
                self.line(&[from, to], Stroke { dashed: false, ..stroke });
            }
            return;
        }
        let (points, colour) = (points.to_vec(), rgb(stroke.colour));
        self.scene.elements.push(Primitive::PolyLine {
            points,
            stroke: colour,
            stroke_width: stroke.width,
            stroke_dasharray: None,
        });
    }

    /// The outline of a polygon.
    pub(crate) fn outline(&mut self, corners: &[Point], stroke: Stroke) {
        self.line(&[corners, &corners[..1]].concat(), stroke);
    }

    /// The inside of a polygon.
    pub(crate) fn fill(&mut self, corners: &[Point], colour: Rgb, opacity: f64) {
        let path: Vec<String> = corners.iter().map(|(x, y)| format!("{x:.3} {y:.3}")).collect();
        self.scene.elements.push(Primitive::Path(Box::new(PathData {
            d: format!("M {} Z", path.join(" L ")),
            fill: Some(rgb(colour)),
            stroke: Color::None,
            stroke_width: 0.0,
            opacity: Some(opacity),
            stroke_dasharray: None,
        })));
    }

    /// Rectangles of one size, each with the place of its upper left corner and its colour.
    pub(crate) fn cells(&mut self, size: Point, cells: impl Iterator<Item = (Point, Rgb)>) {
        let (places, fills): (Vec<Point>, Vec<Color>) = cells.map(|(place, colour)| (place, rgb(colour))).unzip();
        let (x, y): (Vec<f64>, Vec<f64>) = places.into_iter().unzip();
        let (w, h) = (vec![size.0; x.len()], vec![size.1; x.len()]);
        self.scene.elements.push(Primitive::RectBatch { x, y, w, h, fills });
    }

    /// A disc.
    pub(crate) fn disc(&mut self, centre: Point, radius: f64, colour: Rgb) {
        self.scene.elements.push(Primitive::Circle {
            cx: centre.0,
            cy: centre.1,
            r: radius,
            fill: rgb(colour),
            fill_opacity: None,
            stroke: None,
            stroke_width: None,
        });
    }

    /// A line from `tail` with an arrow head at `tip`.
    pub(crate) fn arrow(&mut self, tail: Point, tip: Point, stroke: Stroke) {
        let (dx, dy) = (tip.0 - tail.0, tip.1 - tail.1);
        let length = (dx * dx + dy * dy).sqrt();
        let (ux, uy) = (dx / length, dy / length);
        let (long, wide) = (5.0 + 3.0 * stroke.width, 2.0 + 1.5 * stroke.width);
        let base = (tip.0 - long * ux, tip.1 - long * uy);
        self.line(&[tail, base], stroke);
        self.fill(&[tip, (base.0 - wide * uy, base.1 + wide * ux), (base.0 + wide * uy, base.1 - wide * ux)], stroke.colour, 1.0);
    }

    /// A line of text on the base line through `place`.
    pub(crate) fn text(&mut self, (x, y): Point, text: &str, of: Type) {
        let anchor = match of.anchor {
            Anchor::Start => TextAnchor::Start,
            Anchor::Middle => TextAnchor::Middle,
            Anchor::End => TextAnchor::End,
        };
        let (content, size, color) = (text.to_owned(), of.size, Some(rgb(of.colour)));
        self.scene.elements.push(Primitive::Text { x, y, content, size, anchor, rotate: None, bold: false, color });
    }

    /// The picture as the text of an SVG file, with a title and a description for those who do not see it, neither with characters that XML knows otherwise.
    pub(crate) fn svg_of(&self, title: &str, description: &str) -> String {
        let text = SvgBackend::new().render_scene(&self.scene);
        let Some((start, inside)) = text.split_once('>') else { return text };
        format!("{start} role=\"img\"><title>{title}</title><desc>{description}</desc>{inside}")
    }

    /// The picture as the bytes of a PNG file, `scale` pixels to a unit.
    ///
    /// # Errors
    /// The encoder's message.
    pub(crate) fn png(&self, scale: f32) -> Result<Vec<u8>, String> {
        PngBackend::new().with_scale(scale).render_scene(&self.scene)
    }
}

/// The dashes of a line, the last one whole: the plotting crate's own are lost at more than one pixel to a unit.
fn dashes(from: Point, to: Point) -> impl Iterator<Item = (Point, Point)> {
    const DASH: f64 = 4.0;
    const PERIOD: f64 = 7.0;
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let length = (dx * dx + dy * dy).sqrt();
    let periods = ((length - DASH) / PERIOD).round().max(1.0);
    let period = (length - DASH) / periods;
    let point = move |s: f64| (from.0 + dx * s / length, from.1 + dy * s / length);
    std::iter::successors(Some(0.0), |i| Some(i + 1.0))
        .take_while(move |i| *i <= periods)
        .map(move |i| (point(i * period), point(i * period + DASH)))
}

const fn rgb((red, green, blue): Rgb) -> Color {
    Color::Rgb(red, green, blue)
}
