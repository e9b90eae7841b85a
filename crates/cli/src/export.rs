//! The solution as a file: VTU for `ParaView`, PLY with colours at vertices.
//!
//! Every leaf has vertices of its own, since the polynomials of neighbours need not meet.

use std::io::{self, Write};

use radgrad_core::DVec3;
use radgrad_scene::largest;
use radgrad_solver::{Ledger, Shape, Solution};

/// A format of a solution.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Format {
    /// XML of VTK: radiosity, gradient, lower and upper bound at vertices; the ledger on cells.
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

    pub(crate) fn write(self, solution: &Solution, output: &mut dyn Write) -> io::Result<()> {
        match self {
            Self::Vtu => vtu(solution, output),
            Self::Ply => ply(solution, output),
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

fn vtu(solution: &Solution, output: &mut dyn Write) -> io::Result<()> {
    let cells = cells(solution);
    let count: usize = cells.iter().map(|cell| cell.corners.len()).sum();
    writeln!(output, r#"<?xml version="1.0"?>"#)?;
    writeln!(output, r#"<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian">"#)?;
    writeln!(output, r#"<UnstructuredGrid><Piece NumberOfPoints="{count}" NumberOfCells="{}">"#, cells.len())?;
    let points = |f: &dyn Fn(&Cell, [f64; 2]) -> Vec<f64>| -> Vec<Vec<f64>> {
        cells.iter().flat_map(|cell| cell.corners.iter().map(move |&at| f(cell, at))).collect()
    };
    let elements = solution.mesh().elements();
    let positions = points(&|cell, at| elements[cell.leaf].point(at).to_array().to_vec());
    writeln!(output, "<Points>")?;
    array(output, "position", &positions)?;
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
    let bounds: Vec<Vec<Ledger>> = cells.iter().map(|cell| solution.bound_on(cell.leaf)).collect();
    for (channel, name) in solution.channels().iter().enumerate() {
        let name = escaped(name);
        array(output, &format!("radiosity {name}"), &points(&|cell, at| vec![solution.value_on(cell.leaf, channel, at)]))?;
        let gradient = points(&|cell, at| solution.gradient_on(cell.leaf, channel, at).to_array().to_vec());
        array(output, &format!("gradient {name}"), &gradient)?;
        for (side, sign) in [("lower", -1.0), ("upper", 1.0)] {
            let values = cells.iter().zip(&bounds).flat_map(|(cell, bound)| {
                let bound = sign * bound[channel].total();
                cell.corners.iter().map(move |&at| vec![solution.value_on(cell.leaf, channel, at) + bound])
            });
            array(output, &format!("{side} {name}"), &values.collect::<Vec<_>>())?;
        }
    }
    writeln!(output, "</PointData>\n<CellData>")?;
    whole(output, "Int64", "face", cells.iter().map(|cell| elements[cell.leaf].face()))?;
    for (channel, name) in solution.channels().iter().enumerate() {
        for (entry, source) in Ledger::NAMES.iter().enumerate() {
            let values: Vec<Vec<f64>> = bounds.iter().map(|bound| vec![bound[channel].entries()[entry]]).collect();
            array(output, &format!("{source} {}", escaped(name)), &values)?;
        }
    }
    writeln!(output, "</CellData>\n</Piece></UnstructuredGrid></VTKFile>")
}

/// An array of tuples of one length.
fn array(output: &mut dyn Write, name: &str, tuples: &[Vec<f64>]) -> io::Result<()> {
    let components = tuples.first().map_or(1, Vec::len);
    writeln!(output, r#"<DataArray type="Float64" Name="{name}" NumberOfComponents="{components}" format="ascii">"#)?;
    for tuple in tuples {
        writeln!(output, "{}", tuple.iter().map(|c| format!("{c:e}")).collect::<Vec<_>>().join(" "))?;
    }
    writeln!(output, "</DataArray>")
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
fn ply(solution: &Solution, output: &mut dyn Write) -> io::Result<()> {
    let cells = cells(solution);
    let count: usize = cells.iter().map(|cell| cell.corners.len()).sum();
    writeln!(output, "ply\nformat ascii 1.0\ncomment radiosity, tone-mapped\nelement vertex {count}")?;
    writeln!(output, "property double x\nproperty double y\nproperty double z")?;
    writeln!(output, "property uchar red\nproperty uchar green\nproperty uchar blue")?;
    writeln!(output, "element face {}\nproperty list uchar int vertex_indices\nend_header", cells.len())?;
    let channels = solution.channels().len();
    let middle = 2.0 * solution.mean().iter().sum::<f64>() / channels as f64;
    for cell in &cells {
        for &at in cell.corners {
            let DVec3 { x, y, z } = solution.mesh().elements()[cell.leaf].point(at);
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
