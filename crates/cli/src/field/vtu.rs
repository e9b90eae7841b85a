//! The field as an unstructured grid of VTK, in text: a quadrilateral a cell, with value, gradient and bounds.

use std::io::{self, Write};

use radgrad_scene::FieldCell;

/// VTK's number of a quadrilateral.
const QUADRILATERAL: u8 = 9;

pub(super) fn write(out: &mut impl Write, cells: &[FieldCell]) -> io::Result<()> {
    let count = cells.len();
    writeln!(out, r#"<?xml version="1.0"?>"#)?;
    writeln!(out, r#"<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian">"#)?;
    writeln!(out, "<UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{count}\">", 4 * count)?;
    writeln!(out, "<Points>")?;
    let points = cells.iter().flat_map(|cell| cell.corners).map(|p| vector(p.to_array()));
    array(out, r#"type="Float64" Name="Points" NumberOfComponents="3""#, points)?;
    writeln!(out, "</Points>\n<Cells>")?;
    array(out, r#"type="Int64" Name="connectivity""#, (0..4 * count).map(|i| i.to_string()))?;
    array(out, r#"type="Int64" Name="offsets""#, (1..=count).map(|i| (4 * i).to_string()))?;
    array(out, r#"type="UInt8" Name="types""#, cells.iter().map(|_| QUADRILATERAL.to_string()))?;
    writeln!(out, "</Cells>\n<CellData Scalars=\"value\" Vectors=\"gradient\">")?;
    let scalar = |name: &str| format!(r#"type="Float64" Name="{name}""#);
    array(out, &scalar("value"), cells.iter().map(|cell| number(cell.value)))?;
    array(out, &scalar("value_error"), cells.iter().map(|cell| number(cell.value_error)))?;
    let gradients = cells.iter().map(|cell| vector(cell.gradient.to_array()));
    array(out, r#"type="Float64" Name="gradient" NumberOfComponents="3""#, gradients)?;
    array(out, &scalar("gradient_error"), cells.iter().map(|cell| number(cell.gradient_error)))?;
    writeln!(out, "</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>")
}

fn array(out: &mut impl Write, head: &str, entries: impl Iterator<Item = String>) -> io::Result<()> {
    writeln!(out, r#"<DataArray {head} format="ascii">"#)?;
    for entry in entries {
        writeln!(out, "{entry}")?;
    }
    writeln!(out, "</DataArray>")
}

fn vector(components: [f64; 3]) -> String {
    components.map(number).join(" ")
}

fn number(value: f64) -> String {
    format!("{value:?}")
}
