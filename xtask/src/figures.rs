//! `cargo xtask figures`: the colour plates of HS95 (its figures A to E) from the closed form.
//!
//! The scene: a triangle 1 m over a plane that it is parallel to, reflectance 1. A and B: radiosity on the plane and the norm
//! of its gradient along the plane, emitter constant at 1 W/m2; C and D: the same for an emitter linear between 1, 2 and 4 W/m2
//! at its vertices; E: the geometry. The gradient's part along the normal is left out: a surface does not see it, and a
//! refinement along the surface asks for the rest.

pub(crate) mod field;
mod geometry;
pub(crate) mod panel;

use std::fs;
use std::path::PathBuf;

use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver};
use radgrad_scene::output::Unwritten;

use crate::files;
use crate::plot::{Colours, Picture};
use field::{Field, Window};
use panel::Panel;

/// Vertices of the emitter, lit downward.
pub(crate) const TRIANGLE: [DVec3; 3] = [DVec3::new(0.0, 0.0, 1.0), DVec3::new(0.5, 0.8, 1.0), DVec3::new(1.0, 0.0, 1.0)];
/// Emission of the linear emitter at its vertices, in W/m2.
pub(crate) const LINEAR: [f64; 3] = [1.0, 2.0, 4.0];
/// The part of the plane shown, in m.
pub(crate) const WINDOW: Window = Window { x: [-1.0, 2.0], y: [-1.2, 1.8] };
/// Receiver point and emitter point shown in figure E.
const JOINED: (DVec3, DVec3) = (DVec3::new(1.7, -0.45, 0.0), DVec3::new(0.72, 0.22, 1.0));
/// Pixels to a unit: of the figures, and of the one for the front page.
const SCALES: (f32, f32) = (2.0, 1.0);

/// Draw the figures of the paper as PNG
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Folder to write to
    #[arg(long, default_value = "target/figures")]
    out: PathBuf,
}

/// Why there are no figures.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Error {
    /// A point of the plane has no answer.
    #[error(transparent)]
    Core(#[from] radgrad_core::Error),
    /// The picture cannot be encoded.
    #[error("{figure}: {reason}")]
    Encode {
        /// Name of the figure's file.
        figure: String,
        /// The encoder's message.
        reason: String,
    },
    /// The folder cannot be made.
    #[error("{}: {source}", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// A file cannot be written.
    #[error(transparent)]
    Unwritten(#[from] Unwritten),
}

/// The four fields of one emission each.
struct Plates {
    value: Field,
    gradient: Field,
}

impl Plates {
    fn sample(emission: Emission) -> Result<Self, radgrad_core::Error> {
        let emitter = Emitter::new(Polygon::new(TRIANGLE.to_vec())?, emission)?;
        let receiver = |x: f64, y: f64| Receiver::new(DVec3::new(x, y, 0.0), DVec3::Z, 1.0);
        let value = |x: f64, y: f64| radgrad_core::radiosity(&receiver(x, y)?, &emitter);
        let gradient = |x: f64, y: f64| {
            let gradient = radgrad_core::gradient(&receiver(x, y)?, &emitter)?;
            Ok(gradient.truncate().length())
        };
        let cells = [panel::SIDE; 2];
        Ok(Self { value: Field::sample(WINDOW, cells, value)?, gradient: Field::sample(WINDOW, cells, gradient)? })
    }
}

/// Writes every figure and says where.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Error> {
    fs::create_dir_all(&arguments.out).map_err(|source| Error::Folder { path: arguments.out.clone(), source })?;
    let (constant, linear) = (Plates::sample(Emission::Constant(1.0))?, Plates::sample(Emission::at_vertices(LINEAR.to_vec()))?);
    for (name, picture, scale) in pictures(&constant, &linear) {
        let path = arguments.out.join(&name);
        let bytes = picture.png(scale).map_err(|reason| Error::Encode { figure: name, reason })?;
        files::write(&path, &bytes)?;
        println!("{} ({} kB)", path.display(), bytes.len().div_ceil(1000));
    }
    Ok(())
}

/// The figures one by one, and C beside D in one picture for the front page.
fn pictures(constant: &Plates, linear: &Plates) -> Vec<(String, Picture, f32)> {
    let outline = TRIANGLE.map(|v| (v.x, v.y));
    let panel = |title, subtitle, quantity, field, colours, mark| Panel {
        title,
        subtitle,
        quantity,
        field,
        colours,
        outline: &outline,
        mark,
    };
    let under = |emission: &str, plates: &Plates| {
        let (largest, place) = plates.value.largest();
        (format!("emitter {emission}; largest at +: {largest:.4} W/m²"), place)
    };
    let ((a, a_top), (c, c_top)) = (under("1 W/m²", constant), under("1, 2, 4 W/m² at its vertices", linear));
    let (value, slope) = ("B (W/m²)", "|∇B| (W/m³)");
    let along = "of its part along the plane; 0 at +, where B is largest";
    let panels = [
        ("A", panel("A   Radiosity, constant emitter", &a, value, &constant.value, Colours::Viridis, a_top)),
        ("B", panel("B   Gradient norm, constant emitter", along, slope, &constant.gradient, Colours::Inferno, a_top)),
        ("C", panel("C   Radiosity, linear emitter", &c, value, &linear.value, Colours::Viridis, c_top)),
        ("D", panel("D   Gradient norm, linear emitter", along, slope, &linear.gradient, Colours::Inferno, c_top)),
    ];
    let mut pictures: Vec<_> =
        panels.iter().map(|(name, panel)| (format!("{name}.png"), side_by_side(&[panel]), SCALES.0)).collect();
    pictures.push(("E.png".to_owned(), geometry_picture(&constant.value), SCALES.0));
    pictures.push(("linear-emitter.png".to_owned(), side_by_side(&[&panels[2].1, &panels[3].1]), SCALES.1));
    pictures
}

/// Figure E, with the lines of equal `radiosity`.
pub(crate) fn geometry_picture(radiosity: &Field) -> Picture {
    let mut scene = Picture::new(geometry::SIZE.0, geometry::SIZE.1);
    geometry::draw(&mut scene, &TRIANGLE, radiosity, JOINED.0, JOINED.1);
    scene
}

/// Panels from left to right in one picture.
fn side_by_side(panels: &[&Panel<'_>]) -> Picture {
    let (width, height) = panel::SIZE;
    let lefts = || std::iter::successors(Some(0.0), |left| Some(left + width)).take(panels.len());
    let mut picture = Picture::new(lefts().map(|_| width).sum(), height);
    for (panel, left) in panels.iter().zip(lefts()) {
        panel.draw(&mut picture, (left, 0.0));
    }
    picture
}
