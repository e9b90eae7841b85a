//! The paper's figures A to E from the closed form: radiosity and its gradient on a plane under a triangle, with arrows.

use std::error::Error;

use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, radiosity_and_gradient};
use serde::Serialize;

use super::map::{CELLS, Map};
use crate::figures::field::Field;
use crate::figures::{LINEAR, TRIANGLE, WINDOW, geometry_picture};
use crate::plot::Colours;

/// A description of figure E, for those who do not see it.
const SCENE: &str =
    "A triangle 1 m over a plane, with lines of equal radiosity, a receiver point and the vector to a point of the emitter.";

/// A figure with its caption.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Plate {
    pub(super) picture: String,
    pub(super) caption: String,
}

/// Radiosity and the gradient's two parts along the plane.
struct Sampled {
    value: Field,
    along: [Field; 2],
    norm: Field,
}

impl Sampled {
    fn sample(emission: Emission) -> Result<Self, radgrad_core::Error> {
        let emitter = Emitter::new(Polygon::new(TRIANGLE.to_vec())?, emission)?;
        let answer = |x: f64, y: f64| {
            let (value, gradient) = radiosity_and_gradient(&Receiver::new(DVec3::new(x, y, 0.0), DVec3::Z, 1.0)?, &emitter)?;
            Ok::<_, radgrad_core::Error>([value, gradient.x, gradient.y, gradient.truncate().length()])
        };
        let [value, along_x, along_y, norm] = Field::sample_each(WINDOW, [CELLS; 2], answer)?;
        Ok(Self { value, along: [along_x, along_y], norm })
    }
}

/// The plates, and the file of their values.
pub(super) fn plates() -> Result<(Vec<Plate>, Vec<u8>), Box<dyn Error>> {
    let (constant, linear) =
        (Sampled::sample(Emission::Constant(1.0))?, Sampled::sample(Emission::at_vertices(LINEAR.to_vec()))?);
    let mut plates = Vec::with_capacity(5);
    let outlines = [("outline", TRIANGLE.map(|v| (v.x, v.y)).to_vec())];
    let plate = |letter: &str, what: &str, unit: &str, field: &Field, colours: Colours, arrows: Option<&[Field; 2]>| {
        let heading = format!("{letter}   {what}");
        let map = Map { heading: &heading, unit, field, colours, arrows, outlines: &outlines };
        map.draw(&format!("Figure {letter}: {what} on the plane"))
    };
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

/// `x,y` and radiosity and gradient along the plane for the constant and for the linear emitter.
fn csv(constant: &Sampled, linear: &Sampled) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut rows = csv::Writer::from_writer(Vec::new());
    rows.write_record(["x", "y", "constant", "constant-dx", "constant-dy", "linear", "linear-dx", "linear-dy"])?;
    for row in 0..CELLS {
        for column in 0..CELLS {
            let (x, y) = constant.value.centre(column, row);
            let row_of = |sampled: &Sampled| {
                [&sampled.value, &sampled.along[0], &sampled.along[1]].map(|f| format!("{:.6e}", f.value(column, row)))
            };
            rows.write_record([format!("{x:.4}"), format!("{y:.4}")].iter().chain(&row_of(constant)).chain(&row_of(linear)))?;
        }
    }
    Ok(rows.into_inner()?)
}
