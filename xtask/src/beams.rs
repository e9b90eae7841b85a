//! `cargo xtask beams`: the cost of one form factor in a scene of a hundred to ten thousand triangles, by counts.
//!
//! Two squares see each other through a cube of small triangles at random. Either the cube stays and there are more and smaller
//! ones, so that more are in the beam between the two; or the cube grows around the same beam. The search compares boxes and
//! polygons with the beam, and the closed form is evaluated past those it finds.

use std::error::Error;
use std::fs;
use std::path::PathBuf;

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::{Beam, Occluders};

use crate::files;
use crate::plot::{Anchor, FAINT, INK, Picture, Point, Rgb, Stroke, Type};

/// Count the cost of a form factor in scenes of a hundred to ten thousand triangles: a table and a diagram
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Folder to write to
    #[arg(long, default_value = "target/beams")]
    out: PathBuf,
}

/// How a scene gets more triangles.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Growth {
    Denser,
    Larger,
}

/// One scene.
struct Row {
    growth: Growth,
    triangles: usize,
    in_beam: usize,
    boxes: usize,
    polygons: usize,
}

/// A quantity counted in a scene.
type Count = fn(&Row) -> usize;

/// Triangles along an edge of the cube, in the mean.
const SIDES: [u32; 7] = [5, 7, 9, 12, 15, 18, 22];

/// Writes `beams.csv` and `beams.svg`.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let mut rows = Vec::new();
    for growth in [Growth::Denser, Growth::Larger] {
        for per_side in SIDES {
            rows.push(count(growth, per_side)?);
        }
    }
    fs::create_dir_all(&arguments.out)?;
    files::table(&arguments.out.join("beams.csv"), |table| {
        table.write_record(["scene", "triangles", "in_beam", "boxes_compared", "polygons_compared"])?;
        for row in &rows {
            let counts = [row.triangles, row.in_beam, row.boxes, row.polygons].map(|count| count.to_string());
            table.write_record([row.growth.name().to_owned()].into_iter().chain(counts))?;
        }
        Ok(())
    })?;
    files::write(&arguments.out.join("beams.svg"), diagram(&rows).svg())?;
    println!("{}", arguments.out.join("beams.svg").display());
    Ok(())
}

fn count(growth: Growth, per_side: u32) -> Result<Row, Box<dyn Error>> {
    let step = match growth {
        Growth::Denser => 1.0 / f64::from(per_side),
        Growth::Larger => 1.0 / f64::from(SIDES[0]),
    };
    let size = step * f64::from(per_side);
    // A linear congruential generator (D. E. Knuth, MMIX).
    let mut state = 1_u64;
    let mut uniform = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut triangles = Vec::new();
    for _ in 0..per_side.pow(3) {
        let corner = DVec3::splat(0.5 - 0.5 * size) + DVec3::new(uniform(), uniform(), uniform()) * size;
        let places = [[0.0, 0.0, 0.0], [0.5, 0.125, 0.25], [0.125, 0.5, 0.375]];
        triangles.push(Polygon::new(places.map(|place| corner + DVec3::from(place) * step).to_vec())?);
    }
    let square = |z: f64, corners: [(f64, f64); 4]| Polygon::new(corners.map(|(x, y)| DVec3::new(x, y, z)).to_vec());
    let from = square(0.0, [(0.4, 0.4), (0.6, 0.4), (0.6, 0.6), (0.4, 0.6)])?;
    let to = square(1.0, [(0.4, 0.4), (0.4, 0.6), (0.6, 0.6), (0.6, 0.4)])?;
    let beam = Beam::from_polygon(&from, &to).ok_or("the squares face each other")?;
    let search = Occluders::new(&triangles).in_beam(&beam, &[]);
    Ok(Row {
        growth,
        triangles: triangles.len(),
        in_beam: search.polygons.len(),
        boxes: search.boxes_tested,
        polygons: search.polygons_tested,
    })
}

impl Growth {
    const fn name(self) -> &'static str {
        match self {
            Self::Denser => "denser",
            Self::Larger => "larger",
        }
    }

    const fn colour(self) -> Rgb {
        match self {
            Self::Denser => (190, 78, 30),
            Self::Larger => (28, 96, 168),
        }
    }
}

/// Upper left corner and size of the axes.
const ORIGIN: Point = (64.0, 64.0);
const SIZE: Point = (440.0, 330.0);
/// Decades of the triangles and of the counts.
const ACROSS: [i32; 2] = [2, 4];
const UP: [i32; 2] = [0, 5];
const GRID: Rgb = (226, 226, 232);

fn place(triangles: f64, count: f64) -> Point {
    let share = |figure: f64, [low, high]: [i32; 2]| (libm::log10(figure) - f64::from(low)) / f64::from(high - low);
    // A tenth of a decade is left on the right for the last scene.
    (ORIGIN.0 + SIZE.0 * share(triangles, ACROSS) / 1.05, ORIGIN.1 + SIZE.1 * (1.0 - share(count, UP)))
}

fn diagram(rows: &[Row]) -> Picture {
    let mut picture = Picture::new(ORIGIN.0 + SIZE.0 + 190.0, ORIGIN.1 + SIZE.1 + 52.0);
    let text = |size, colour, anchor| Type { size, colour, anchor };
    picture.text((ORIGIN.0, 26.0), "One form factor in a larger and larger scene", text(16, INK, Anchor::Start));
    picture.text((ORIGIN.0, 45.0), "What is compared with the beam, and what is in it", text(11, FAINT, Anchor::Start));
    let (left, right, top, floor) = (ORIGIN.0, ORIGIN.0 + SIZE.0, ORIGIN.1, ORIGIN.1 + SIZE.1);
    for decade in ACROSS[0]..=ACROSS[1] {
        let (x, _) = place(libm::exp10(f64::from(decade)), 1.0);
        picture.line(&[(x, top), (x, floor)], Stroke::solid(GRID, 0.8));
        picture.text((x, floor + 17.0), &10u64.pow(decade.unsigned_abs()).to_string(), text(11, INK, Anchor::Middle));
    }
    for decade in UP[0]..=UP[1] {
        let (_, y) = place(100.0, libm::exp10(f64::from(decade)));
        picture.line(&[(left, y), (right, y)], Stroke::solid(GRID, 0.8));
        picture.text((left - 7.0, y + 4.0), &10u64.pow(decade.unsigned_abs()).to_string(), text(11, INK, Anchor::End));
    }
    picture.outline(&[(left, top), (right, top), (right, floor), (left, floor)], Stroke::solid(INK, 0.9));
    picture.text((left + SIZE.0 / 2.0, floor + 37.0), "triangles in the scene", text(12, INK, Anchor::Middle));
    let last = |rows: &[&Row], count: Count| rows.last().map_or((right, floor), |row| point(row, count(row)));
    let label = |picture: &mut Picture, (x, y): Point, words: &str, colour| {
        picture.text((x + 20.0, y + 4.0), words, text(12, colour, Anchor::Start));
    };
    let finer: Vec<&Row> = rows.iter().filter(|row| row.growth == Growth::Denser).collect();
    let every_triangle: Vec<Point> = finer.iter().map(|r| point(r, r.triangles)).collect();
    picture.line(&every_triangle, Stroke::dashed(FAINT, 1.0));
    label(&mut picture, last(&finer, |row| row.triangles), "every triangle", FAINT);
    for growth in [Growth::Denser, Growth::Larger] {
        let rows: Vec<&Row> = rows.iter().filter(|row| row.growth == growth).collect();
        let counts: [(&str, Count, bool); 2] =
            [("compared", |row| row.boxes + row.polygons, false), ("in the beam", |row| row.in_beam, true)];
        for (what, count, dashed) in counts {
            let points: Vec<Point> = rows.iter().map(|row| point(row, count(row))).collect();
            picture.line(&points, Stroke { colour: growth.colour(), width: 1.4, dashed });
            points.iter().for_each(|point| picture.disc(*point, 2.6, growth.colour()));
            label(&mut picture, last(&rows, count), &format!("{what}, {} scene", growth.name()), growth.colour());
        }
    }
    picture
}

fn point(row: &Row, count: usize) -> Point {
    place(row.triangles as f64, count as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_factor_costs_what_is_in_its_beam() {
        let [few, many] = [SIDES[0], SIDES[6]].map(|side| count(Growth::Larger, side).unwrap());
        assert!(many.triangles > 80 * few.triangles && many.in_beam < 4 * few.in_beam.max(4));
        assert!(many.boxes + many.polygons < 8 * (few.boxes + few.polygons));
        let denser = count(Growth::Denser, SIDES[6]).unwrap();
        assert!(denser.in_beam > 10 * few.in_beam && denser.boxes + denser.polygons < 40 * denser.in_beam);
    }
}
