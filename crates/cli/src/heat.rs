//! `radgrad heat`: the steady heat balance of grey surfaces, from factors and data of the surfaces.

use std::collections::HashMap;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use radgrad_scene::{Boundary, STEFAN_BOLTZMANN, SurfaceHeat, heat_balance, largest, read_file};
use serde::Deserialize;

use crate::say::say;

/// The options of `radgrad heat`.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Factors between faces, as `radgrad factors --out FILE.csv` writes them.
    ///
    /// Its columns `from`, `from_surface`, `to`, `factor` and `area`, that of `from`, are used; lines to `open` are passed over.
    #[arg(value_name = "FACTORS")]
    factors: PathBuf,
    /// Surfaces: `surface,emittance,temperature,flux`.
    ///
    /// Names are those in the factors, with the object's where the file has one: `oven/roof`. In kelvin and W/m2, with lengths of the scene in
    /// metres; one of the two is given and the other left empty. The flux is the net heat that a surface loses by radiation: 0 where it
    /// is insulated. A column `area` counts where the factors have none.
    #[arg(value_name = "SURFACES")]
    surfaces: PathBuf,
    /// Temperature in kelvin of what open faces see.
    ///
    /// It is black. Without it the scene must be closed: rows of factors that sum to 1, to 1 %.
    #[arg(long, value_name = "KELVIN")]
    surroundings: Option<f64>,
    /// A line for each face rather than for each surface.
    #[arg(long)]
    faces: bool,
    /// Size that a file may have: bytes, or as 256M.
    #[arg(long, value_name = "BYTES", default_value = "256M", value_parser = crate::scene::bytes)]
    budget: u64,
}

/// Why there is no balance.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error("{}: {source}: its columns are {columns}", file.display())]
    Csv { file: PathBuf, source: csv::Error, columns: &'static str },
    #[error("{}: cannot read: {source}", file.display())]
    Read { file: PathBuf, source: io::Error },
    #[error("{}: {said}", file.display())]
    Given { file: PathBuf, said: String },
    #[error("{said}")]
    Heat { said: String },
    #[error("cannot write the balance: {0}")]
    Output(csv::Error),
}

/// Columns that a file must have.
const OF_FACTORS: &str = "`from`, `to` and `factor`, as `radgrad factors` writes them";
const OF_SURFACES: &str = "`surface`, `emittance`, `temperature` and `flux`, one of the last two empty in each line";

/// Names that a message lists.
const NAMED: usize = 5;

/// A line of the factors.
#[derive(Debug, Deserialize)]
struct FactorLine {
    from: String,
    #[serde(default)]
    from_surface: Option<String>,
    to: String,
    factor: f64,
    #[serde(default)]
    area: Option<f64>,
}

/// A line of the surfaces.
#[derive(Debug, Deserialize)]
struct SurfaceLine {
    surface: String,
    emittance: f64,
    temperature: Option<f64>,
    flux: Option<f64>,
    #[serde(default)]
    area: Option<f64>,
}

/// The faces of the factors, in the order in which they are there.
#[derive(Debug, Default)]
struct Faces {
    names: Vec<String>,
    surfaces: Vec<String>,
    areas: Vec<Option<f64>>,
    rows: Vec<Vec<(usize, f64)>>,
    index: HashMap<String, usize>,
}

impl Faces {
    fn of(&mut self, name: &str) -> usize {
        if let Some(&face) = self.index.get(name) {
            return face;
        }
        self.index.insert(name.to_owned(), self.names.len());
        self.names.push(name.to_owned());
        self.surfaces.push(name.to_owned());
        self.areas.push(None);
        self.rows.push(Vec::new());
        self.names.len() - 1
    }

    fn said(&self, face: usize) -> String {
        match (self.names.get(face), self.surfaces.get(face)) {
            (Some(name), Some(surface)) => format!("face {name} of `{surface}`"),
            _ => format!("face {face}"),
        }
    }

    fn read(file: &Path, limit: u64) -> Result<Self, Failure> {
        let mut faces = Self::default();
        for line in lines::<FactorLine>(file, limit, OF_FACTORS)? {
            let from = faces.of(&line.from);
            if let Some(surface) = line.from_surface {
                faces.surfaces[from] = surface;
            }
            faces.areas[from] = faces.areas[from].or(line.area);
            if line.to != "open" {
                let to = faces.of(&line.to);
                faces.rows[from].push((to, line.factor));
            }
        }
        Ok(faces)
    }
}

/// The records of a CSV with a header.
fn lines<T: serde::de::DeserializeOwned>(file: &Path, limit: u64, columns: &'static str) -> Result<Vec<T>, Failure> {
    let text = read_file(file, limit).map_err(|source| Failure::Read { file: file.to_owned(), source })?;
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(&text[..]);
    reader.deserialize().collect::<Result<_, _>>().map_err(|source| Failure::Csv { file: file.to_owned(), source, columns })
}

/// Prints the state of every surface.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let faces = Faces::read(&arguments.factors, arguments.budget)?;
    let given = lines::<SurfaceLine>(&arguments.surfaces, arguments.budget, OF_SURFACES)?;
    let wrong = |said: String| Failure::Given { file: arguments.surfaces.clone(), said };
    let mut of_surface: HashMap<&str, (usize, Boundary)> = HashMap::new();
    for (line, of) in given.iter().enumerate() {
        let boundary = match (of.temperature, of.flux) {
            (Some(kelvin), None) => Boundary::Temperature(kelvin),
            (None, Some(flux)) => Boundary::Flux(flux),
            _ => return Err(wrong(format!("`{}`: give a temperature or a flux, and leave the other one empty", of.surface))),
        };
        if of_surface.insert(&of.surface, (line, boundary)).is_some() {
            return Err(wrong(format!("`{}` is there twice", of.surface)));
        }
    }
    let (mut known, mut areas) = (Vec::new(), Vec::new());
    for (face, surface) in faces.surfaces.iter().enumerate() {
        let found = of_surface.get(surface.as_str()).or_else(|| of_surface.get(faces.names[face].as_str()));
        let &(line, boundary) = found.ok_or_else(|| {
            let named: Vec<String> = given.iter().take(NAMED).map(|of| format!("`{}`", of.surface)).collect();
            let more = if given.len() > NAMED { " and others" } else { "" };
            wrong(format!(
                "no line of surface `{surface}`, which {} has: give its emittance, and its temperature or flux (lines are of {}{more})",
                arguments.factors.display(),
                named.join(", ")
            ))
        })?;
        let area = faces.areas[face].or(given[line].area);
        areas.push(area.ok_or_else(|| wrong(format!("`{surface}` has no area: add a column `area`, as the factors have none")))?);
        known.push((line, boundary));
    }
    if let Some(unused) = (0..given.len()).find(|line| !known.iter().any(|of| of.0 == *line)) {
        return Err(wrong(format!("surface `{}` has no face in {}", given[unused].surface, arguments.factors.display())));
    }
    let emittances: Vec<f64> = known.iter().map(|of| given[of.0].emittance).collect();
    let boundary: Vec<Boundary> = known.iter().map(|of| of.1).collect();
    let states = heat_balance(&faces.rows, &areas, &emittances, &boundary, arguments.surroundings)
        .map_err(|error| Failure::Heat { said: error.named(|face| faces.said(face)) })?;
    let groups: Vec<(String, Vec<usize>)> = if arguments.faces {
        faces.names.iter().enumerate().map(|(face, name)| (name.clone(), vec![face])).collect()
    } else {
        let of_line = |line: usize| (0..known.len()).filter(|&face| known[face].0 == line).collect();
        given.iter().enumerate().map(|(line, of)| (of.surface.clone(), of_line(line))).collect()
    };
    write(&groups, &areas, &states, io::stdout().lock()).map_err(Failure::Output)?;
    let heat: f64 = states.iter().zip(&areas).map(|(state, area)| state.flux * area).sum();
    let lack = faces.rows.iter().map(|row| (1.0 - row.iter().map(|of| of.1).sum::<f64>()).abs()).fold(0.0, largest);
    say(format_args!(
        "{} faces: all surfaces together lose {heat:.3e} W; rows of factors sum to 1 within {lack:.1e}",
        areas.len()
    ));
    Ok(())
}

/// Of each group its area, the mean of its emissive power as a temperature, and the means of its fluxes.
fn write(groups: &[(String, Vec<usize>)], areas: &[f64], states: &[SurfaceHeat], out: impl Write) -> Result<(), csv::Error> {
    let mut table = csv::Writer::from_writer(out);
    table.write_record(["surface", "area", "temperature", "flux", "power", "radiosity", "irradiance"])?;
    for (name, faces) in groups {
        let area: f64 = faces.iter().map(|&face| areas[face]).sum();
        let mean =
            |of: &dyn Fn(&SurfaceHeat) -> f64| faces.iter().map(|&face| areas[face] * of(&states[face])).sum::<f64>() / area;
        let power = mean(&|state| STEFAN_BOLTZMANN * state.temperature.powi(4));
        let flux = mean(&|state| state.flux);
        let numbers = [
            area,
            (power / STEFAN_BOLTZMANN).sqrt().sqrt(),
            flux,
            flux * area,
            mean(&|state| state.radiosity),
            mean(&|state| state.irradiance),
        ];
        let shown = |number: f64| format!("{number:.6}");
        table.write_record(std::iter::once(name.clone()).chain(numbers.map(shown)))?;
    }
    table.flush()?;
    Ok(())
}
