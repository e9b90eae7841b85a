//! The solution as a file: VTU for `ParaView`, PLY with colours at vertices.
//!
//! Every leaf has vertices of its own, since the polynomials of neighbours need not meet.

use std::io::{self, Write};

use radgrad_certificate::{Certificate, Interval};
use radgrad_core::DVec3;
use radgrad_scene::{Scene, largest, printable};
use radgrad_solver::{Ledger, Shape, Solution};

/// A format of a solution.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Format {
    /// XML of VTK: radiosity, gradient and estimates of their errors at vertices; surfaces, and the estimate by its sources, on cells.
    Vtu,
    /// Polygons with sRGB colours.
    Ply,
}

impl Format {
    /// By the ending of a file's name.
    pub(crate) fn of(file: &std::path::Path) -> Option<Self> {
        match file.extension()?.to_string_lossy().to_ascii_lowercase().as_str() {
            "vtu" => Some(Self::Vtu),
            "ply" => Some(Self::Ply),
            _ => None,
        }
    }

    /// With the certificate of the mean where there is one.
    pub(crate) fn write(
        self,
        solution: &Solution,
        scene: &Scene,
        certificate: Option<&Certificate>,
        output: &mut dyn Write,
    ) -> io::Result<()> {
        match self {
            Self::Vtu => vtu(solution, scene, certificate, output),
            Self::Ply => ply(solution, certificate, output),
        }
    }
}

/// A leaf and the reference coordinates of its corners.
struct Cell {
    leaf: usize,
    corners: &'static [[f64; 2]],
}

fn cells(solution: &Solution) -> Vec<Cell> {
    let corners = |shape| -> &'static [[f64; 2]] {
        match shape {
            Shape::Parallelogram => &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
            Shape::Triangle => &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
        }
    };
    let mesh = solution.mesh();
    mesh.leaves().map(|leaf| Cell { leaf, corners: corners(mesh.elements()[leaf].shape()) }).collect()
}

/// The unit of the numbers in the file, for those who read the file alone.
pub(crate) const UNIT: &str = "radiosity: pi times the unit of the scene's radiance";

/// The head of a VTU file: the quantities that its numbers are of, and their units.
fn names_and_units(
    channels: &[String],
    scene: &Scene,
    certificate: Option<&Certificate>,
    output: &mut dyn Write,
) -> io::Result<()> {
    writeln!(output, r#"<?xml version="1.0"?>"#)?;
    writeln!(output, r#"<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian">"#)?;
    writeln!(output, "<UnstructuredGrid>\n<FieldData>")?;
    for (index, surface) in scene.surfaces().iter().enumerate() {
        field(output, &format!("surface {}", surface.name()), index)?;
    }
    for (index, name) in channels.iter().enumerate() {
        field(output, &format!("channel {name}"), index)?;
    }
    if let Some(Certificate { mean, delta, .. }) = certificate {
        array(output, "confidence", &["probability of failure"], &[vec![*delta]])?;
        for (name, Interval { lower, upper }) in channels.iter().zip(mean) {
            // Readers of the format know no infinite number: an interval without upper end has one component.
            let ends = [("lower", *lower), ("upper", *upper)].into_iter().filter(|(_, end)| end.is_finite());
            let (names, ends): (Vec<&str>, Vec<f64>) = ends.unzip();
            array(output, &format!("certified {name}"), &names, &[ends])?;
        }
    }
    for unit in [UNIT, "gradient: that over the unit of position", "position: the scene's unit of length"] {
        field(output, &format!("unit of {unit}"), 1)?;
    }
    writeln!(output, "</FieldData>")
}

/// Arrays have a component for each channel, named for it, and gradients three.
fn vtu(solution: &Solution, scene: &Scene, certificate: Option<&Certificate>, output: &mut dyn Write) -> io::Result<()> {
    let cells = cells(solution);
    let count: usize = cells.iter().map(|cell| cell.corners.len()).sum();
    let channels = solution.channels();
    let each = 0..channels.len();
    names_and_units(channels, scene, certificate, output)?;
    writeln!(output, "<Piece NumberOfPoints=\"{count}\" NumberOfCells=\"{}\">", cells.len())?;
    let points = |f: &dyn Fn(&Cell, [f64; 2]) -> Vec<f64>| -> Vec<Vec<f64>> {
        cells.iter().flat_map(|cell| cell.corners.iter().map(move |&at| f(cell, at))).collect()
    };
    let elements = solution.mesh().elements();
    let placement = solution.placement();
    let positions = points(&|cell, at| placement.outward(elements[cell.leaf].point(at)).to_array().to_vec());
    writeln!(output, "<Points>")?;
    array(output, "position", &["x", "y", "z"], &positions)?;
    writeln!(output, "</Points>\n<Cells>")?;
    let sizes: Vec<usize> = cells.iter().map(|cell| cell.corners.len()).collect();
    let ends = sizes.iter().scan(0, |end, size| {
        *end += size;
        Some(*end)
    });
    whole(output, "Int64", "connectivity", 0..count)?;
    whole(output, "Int64", "offsets", ends)?;
    whole(output, "UInt8", "types", sizes.iter().map(|&size| if size == 4 { 9 } else { 5 }))?;
    writeln!(output, "</Cells>\n<PointData>")?;
    let names: Vec<&str> = channels.iter().map(String::as_str).collect();
    let value = |cell: &Cell, at: [f64; 2]| each.clone().map(|c| solution.value_on(cell.leaf, c, at)).collect();
    array(output, "radiosity", &names, &points(&value))?;
    let gradient = |cell: &Cell, at: [f64; 2]| {
        let of_channel = |c: usize| (solution.gradient_on(cell.leaf, c, at) * placement.power()).to_array();
        each.clone().flat_map(of_channel).collect()
    };
    let along: Vec<String> = names.iter().flat_map(|name| ["x", "y", "z"].map(|axis| format!("{name} {axis}"))).collect();
    array(output, "gradient", &along.iter().map(String::as_str).collect::<Vec<_>>(), &points(&gradient))?;
    let slack = |cell: &Cell, at: [f64; 2]| {
        each.clone().map(|c| solution.gradient_estimate_on(cell.leaf, c, at) * placement.power()).collect()
    };
    array(output, "gradient_estimate", &names, &points(&slack))?;
    let estimates: Vec<Vec<Ledger>> = cells.iter().map(|cell| solution.estimate_on(cell.leaf)).collect();
    let at_vertices = cells.iter().zip(&estimates).flat_map(|(cell, of)| cell.corners.iter().map(move |_| of));
    let totals = |of: &Vec<Ledger>| of.iter().map(Ledger::total).collect();
    array(output, "estimate", &names, &at_vertices.map(totals).collect::<Vec<Vec<f64>>>())?;
    writeln!(output, "</PointData>\n<CellData>")?;
    whole(output, "Int64", "face", cells.iter().map(|cell| elements[cell.leaf].face()))?;
    whole(output, "Int64", "surface", cells.iter().map(|cell| scene.faces()[elements[cell.leaf].face()].surface()))?;
    for (entry, source) in Ledger::NAMES.iter().enumerate() {
        let of_cell = |of: &Vec<Ledger>| each.clone().map(|c| of[c].entries()[entry]).collect();
        array(output, source, &names, &estimates.iter().map(of_cell).collect::<Vec<Vec<f64>>>())?;
    }
    writeln!(output, "</CellData>\n</Piece></UnstructuredGrid></VTKFile>")
}

/// An array of tuples with a name for each component.
fn array(output: &mut dyn Write, name: &str, components: &[&str], tuples: &[Vec<f64>]) -> io::Result<()> {
    let named = |(k, name): (usize, &&str)| format!(r#" ComponentName{k}="{}""#, escaped(name));
    let names: String = components.iter().enumerate().map(named).collect();
    let (count, tuples_of) = (components.len(), tuples.len());
    let name = escaped(name);
    writeln!(
        output,
        r#"<DataArray type="Float64" Name="{name}" NumberOfComponents="{count}"{names} NumberOfTuples="{tuples_of}" format="ascii">"#
    )?;
    for tuple in tuples {
        writeln!(output, "{}", tuple.iter().map(|c| format!("{c:e}")).collect::<Vec<_>>().join(" "))?;
    }
    writeln!(output, "</DataArray>")
}

/// A number for a name. Texts have arrays of their own kind, which not every reader of the format knows.
fn field(output: &mut dyn Write, name: &str, number: usize) -> io::Result<()> {
    let name = escaped(name);
    writeln!(output, r#"<DataArray type="Int64" Name="{name}" NumberOfTuples="1" format="ascii">{number}</DataArray>"#)
}

fn whole(output: &mut dyn Write, kind: &str, name: &str, numbers: impl Iterator<Item = usize>) -> io::Result<()> {
    writeln!(output, r#"<DataArray type="{kind}" Name="{name}" format="ascii">"#)?;
    writeln!(output, "{}", numbers.map(|n| n.to_string()).collect::<Vec<_>>().join(" "))?;
    writeln!(output, "</DataArray>")
}

fn escaped(name: &str) -> String {
    name.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

/// Colours are `B/(B + 2 m)`, m the mean radiosity of the scene over all channels, with the transfer curve of sRGB: the first
/// three channels, or the only one.
fn ply(solution: &Solution, certificate: Option<&Certificate>, output: &mut dyn Write) -> io::Result<()> {
    let cells = cells(solution);
    let count: usize = cells.iter().map(|cell| cell.corners.len()).sum();
    writeln!(output, "ply\nformat ascii 1.0\ncomment radiosity, tone-mapped")?;
    if let Some(Certificate { mean, delta, .. }) = certificate {
        for (name, Interval { lower, upper }) in solution.channels().iter().zip(mean) {
            let name = printable(name);
            writeln!(
                output,
                "comment mean radiosity of {name}: certified from {lower:e} to {upper:e} but for a probability of {delta:e}"
            )?;
        }
    }
    writeln!(output, "element vertex {count}")?;
    writeln!(output, "property double x\nproperty double y\nproperty double z")?;
    writeln!(output, "property uchar red\nproperty uchar green\nproperty uchar blue")?;
    writeln!(output, "element face {}\nproperty list uchar int vertex_indices\nend_header", cells.len())?;
    let channels = solution.channels().len();
    let middle = 2.0 * solution.mean().iter().sum::<f64>() / channels as f64;
    for cell in &cells {
        for &at in cell.corners {
            let DVec3 { x, y, z } = solution.placement().outward(solution.mesh().elements()[cell.leaf].point(at));
            let colour = [0, 1, 2].map(|c| {
                let value = solution.value_on(cell.leaf, if channels < 3 { 0 } else { c }, at);
                srgb(shade(value, middle))
            });
            writeln!(output, "{x} {y} {z} {} {} {}", colour[0], colour[1], colour[2])?;
        }
    }
    let mut first = 0;
    for cell in &cells {
        let indices = (first..first + cell.corners.len()).map(|i| i.to_string()).collect::<Vec<_>>().join(" ");
        writeln!(output, "{} {indices}", cell.corners.len())?;
        first += cell.corners.len();
    }
    Ok(())
}

/// `B/(B + m)`, 0 where B is not positive.
pub(crate) fn shade(value: f64, middle: f64) -> f64 {
    let value = largest(value, 0.0);
    value / largest(value + middle, f64::MIN_POSITIVE)
}

/// The byte of sRGB for a linear value in [0, 1].
pub(crate) fn srgb(linear: f64) -> u8 {
    let encoded = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    let level = (255.0 * encoded).round();
    (0..=u8::MAX).find(|&byte| f64::from(byte) >= level).unwrap_or(u8::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_has_its_ends_and_its_middle() {
        assert_eq!([0.0, 0.215_861, 1.0].map(srgb), [0, 128, 255]);
    }
}
