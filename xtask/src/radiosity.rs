//! `cargo xtask radiosity`: the cost and the accuracy of radiosity solutions, as CSV and SVG under `target/radiosity`.
//!
//! - `transfer`: error of one transfer between two unit squares by degree, parallel at three gaps and perpendicular (Zatz 1993);
//! - `convergence`: error of a solution by the number of elements, for each degree, divided uniformly and where it pays;
//! - `refinement`: error in the Cornell box by the number of elements, divided alike, by the residual, by the gradient and along shadow lines;
//! - `shadow`: error past a shadow edge by the number of elements, with the floor whole and cut along shadow lines;
//! - `cost`: seconds, elements and links by the number of polygons of a scene.
//!
//! Times are those of this machine today; everything else is the same everywhere.

mod convergence;
mod cost;
mod graph;
mod refinement;
mod shadow;
mod squares;
mod terrain;
mod transfer;

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use crate::files;
use crate::plot::Picture;
use graph::Graph;

/// How many times fewer elements the gradient has to take than uniform division for the same error, and shadow lines than the gradient.
const FEWER_BY_GRADIENT: f64 = 3.0;
const FEWER_BY_SHADOWS: f64 = 2.0;

/// Draw error and cost of radiosity solutions
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Folder to write to
    #[arg(long, default_value = "target/radiosity")]
    out: PathBuf,
    /// Polygons of the largest scenes whose cost is measured: 10,000 take four minutes, 2000 half a minute
    #[arg(long, default_value_t = 10_000)]
    polygons: usize,
    /// Only write a closed city of this many blocks a side to FILE, as OBJ: 49 make 22,094 facets
    #[arg(long, value_name = "SIDE", requires = "file", value_parser = clap::value_parser!(u16).range(1..=500))]
    city: Option<u16>,
    /// Only write a crater with a rough floor, of twice the square of this many triangles, to FILE, as OBJ: 100 make 20,000
    #[arg(long, value_name = "SIDE", requires = "file", conflicts_with = "city", value_parser = clap::value_parser!(u16).range(1..=1000))]
    crater: Option<u16>,
    /// The same of hills
    #[arg(long, value_name = "SIDE", requires = "file", conflicts_with_all = ["city", "crater"], value_parser = clap::value_parser!(u16).range(1..=1000))]
    hills: Option<u16>,
    /// File for --city, --crater and --hills
    #[arg(long)]
    file: Option<PathBuf>,
}

impl Arguments {
    /// Whether anything is measured.
    pub(crate) const fn measures(&self) -> bool {
        self.city.is_none() && self.crater.is_none() && self.hills.is_none()
    }
}

/// Writes every table and picture and says where.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    if let Some(file) = &arguments.file {
        let scene = match (arguments.city, arguments.crater, arguments.hills) {
            (Some(side), ..) => cost::closed_city(side.into()),
            (_, Some(side), _) => terrain::crater(side.into()),
            (_, _, Some(side)) => terrain::hills(side.into()),
            _ => return Err("--file is of --city, --crater or --hills: give one of them".into()),
        };
        files::write(file, scene)?;
        println!("{}", file.display());
        return Ok(());
    }
    fs::create_dir_all(&arguments.out)?;
    let out = |name: &str| arguments.out.join(name);
    let transfers = transfer::measure()?;
    table(&out("transfer.csv"), &["case", "degree", "mean", "root_mean_square"], transfers.iter().map(transfer::Point::record))?;
    picture(&out("transfer.svg"), &transfer::graph(&transfers))?;
    let costs = cost::measure(arguments.polygons)?;
    table(
        &out("cost.csv"),
        &["scene", "polygons", "seconds", "elements", "links", "estimate"],
        costs.iter().map(cost::Point::record),
    )?;
    for kind in cost::Kind::ALL {
        for (scenes, exponent) in cost::exponents(kind, &costs) {
            println!("{}: links grow like the number of polygons to the power {exponent:.2} over {scenes}", kind.name());
        }
    }
    picture(&out("cost.svg"), &cost::graph(&costs))?;
    let points = refinement::measure()?;
    table(&out("refinement.csv"), &refinement::Point::HEADER, points.iter().map(refinement::Point::record))?;
    let mut too_many = Vec::new();
    for degree in refinement::degrees() {
        let counts = refinement::counts(&points, degree)
            .ok_or_else(|| format!("Cornell box, degree {degree}: no mesh is as good as the uniform one"))?;
        println!("Cornell box, degree {degree}: {counts}");
        let [by_gradient, by_shadows] = counts.ratios();
        if by_gradient < FEWER_BY_GRADIENT || by_shadows < FEWER_BY_SHADOWS {
            too_many.push(degree);
        }
        picture(&out(&format!("refinement-{degree}.svg")), &refinement::graph(&points, degree))?;
    }
    let points = shadow::measure()?;
    table(&out("shadow.csv"), &["degree", "division", "elements", "error"], points.iter().map(shadow::Point::record))?;
    for (degree, [whole, cut]) in shadow::orders(&points) {
        println!(
            "shadow, degree {degree}: error falls like the size of elements to the power {cut:.2} along shadow lines, {whole:.2} else"
        );
    }
    picture(&out("shadow.svg"), &shadow::graph(&points))?;
    for pair in [convergence::Pair::Opposed, convergence::Pair::Edge] {
        let points = convergence::measure(pair)?;
        let name = pair.name();
        let records = points.iter().map(convergence::Point::record);
        table(&out(&format!("convergence-{name}.csv")), &["degree", "division", "elements", "error", "estimate"], records)?;
        for (degree, order) in convergence::orders(&points) {
            println!("{name}, degree {degree}: error falls like the size of elements to the power {order:.2}");
        }
        picture(&out(&format!("convergence-{name}.svg")), &convergence::graph(pair, &points))?;
    }
    if too_many.is_empty() {
        return Ok(());
    }
    let limits = format!(
        "{FEWER_BY_GRADIENT} times fewer elements by the gradient and {FEWER_BY_SHADOWS} times fewer again along shadow lines"
    );
    Err(format!("Cornell box: {limits} are asked for, and missed at degrees {too_many:?}").into())
}

fn table(path: &Path, header: &[&str], records: impl Iterator<Item = Vec<String>>) -> Result<(), Box<dyn Error>> {
    files::table(path, |table| {
        table.write_record(header)?;
        for record in records {
            table.write_record(record)?;
        }
        Ok(())
    })?;
    println!("{}", path.display());
    Ok(())
}

fn picture(path: &Path, graph: &Graph) -> Result<(), Box<dyn Error>> {
    let picture: Picture = graph.draw();
    files::write(path, picture.svg())?;
    println!("{}", path.display());
    Ok(())
}
