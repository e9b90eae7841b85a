//! `cargo xtask mesh`: scenes of any size, as OBJ: a closed city, high blocks on the ground under a sky of tiles, between walls; a crater
//! with a rough floor; hills; a furnished room under a lamp.

mod room;
mod terrain;

use std::error::Error;
use std::path::{Path, PathBuf};

use crate::files;

/// Write a scene of any size as OBJ
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// The kind of scene
    kind: Kind,
    /// Blocks of the city along its side, squares of two triangles along the side of the ground, or squares along a wall
    #[arg(value_parser = clap::value_parser!(u16).range(1..=1000))]
    side: u16,
    /// File to write
    file: PathBuf,
}

/// What the scene is of.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum Kind {
    /// A closed city: 49 blocks a side make 22,094 facets
    City,
    /// A crater with a rough floor: 100 squares a side make 20,000 triangles
    Crater,
    /// Hills: as many triangles as the crater
    Hills,
    /// A closed room with a lamp and a block: 122 squares a wall make 99,390. Its materials are in a file `.mtl` beside it
    Room,
}

/// Writes the scene and says where.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let side = arguments.side.into();
    let scene = match arguments.kind {
        Kind::City => closed_city(side),
        Kind::Crater => terrain::crater(side),
        Kind::Hills => terrain::hills(side),
        Kind::Room => {
            let materials = arguments.file.with_extension("mtl");
            files::write(&materials, room::MATERIALS)?;
            let name = materials.file_name().map(Path::new).unwrap_or(&materials);
            room::room(side, &name.display().to_string())
        }
    };
    files::write(&arguments.file, scene)?;
    println!("{}", arguments.file.display());
    Ok(())
}

/// Four corners.
type Quad = [[f64; 3]; 4];

/// Blocks along a side of a tile of the sky, and its height.
const SKY: usize = 3;
const SKY_HEIGHT: f64 = 2.5;

/// Faces up.
fn level([a, c]: [f64; 2], [b, d]: [f64; 2], height: f64) -> Quad {
    [[a, c, height], [b, c, height], [b, d, height], [a, d, height]]
}

/// Upright, and faces to the right of the way from one to the other.
const fn wall([p, q]: [f64; 2], [r, s]: [f64; 2], height: f64) -> Quad {
    [[p, q, 0.0], [r, s, 0.0], [r, s, height], [p, q, height]]
}

fn reversed([a, b, c, d]: Quad) -> Quad {
    [a, d, c, b]
}

/// The sides and the top of a box that stands on the ground.
fn block([a, c]: [f64; 2], [b, d]: [f64; 2], height: f64) -> [Quad; 5] {
    let sides = [[[a, c], [b, c]], [[b, c], [b, d]], [[b, d], [a, d]], [[a, d], [a, c]]].map(|[p, q]| wall(p, q, height));
    [sides[0], sides[1], sides[2], sides[3], level([a, c], [b, d], height)]
}

/// A number from 0 to 1 that does not repeat along a row.
fn scattered(index: usize) -> f64 {
    (0.618_033_988_749_894_9 * index as f64).fract()
}

/// The faces are seen from inside and leave no gap: the ground is cut out under the blocks, and walls stand around it up to the sky.
fn closed_city(side: usize) -> String {
    let cells = || (0..side).flat_map(|i| (0..side).map(move |j| (i, j)));
    let corner = |(i, j): (usize, usize)| [i as f64, j as f64];
    let blocks = cells().flat_map(|(i, j)| {
        let [x, y] = corner((i, j));
        block([x + 0.2, y + 0.2], [x + 0.8, y + 0.8], 1.2 + 0.8 * scattered(i * side + j))
    });
    let sky = cells().filter(|(i, j)| i % SKY == 0 && j % SKY == 0).map(|(i, j)| {
        let end = [i, j].map(|from| (from + SKY).min(side) as f64);
        reversed(level(corner((i, j)), end, SKY_HEIGHT))
    });
    let ground = cells().flat_map(|(i, j)| {
        let ([x, y], [u, v]) = (corner((i, j)), corner((i + 1, j + 1)));
        let ([a, c], [b, d]) = ([x + 0.2, y + 0.2], [x + 0.8, y + 0.8]);
        [([x, y], [u, c]), ([x, d], [u, v]), ([x, c], [a, d]), ([b, c], [u, d])].map(|(p, q)| level(p, q, 0.0))
    });
    let end = side as f64;
    let walls = (0..side).flat_map(|k| {
        let (k, next) = (k as f64, (k + 1) as f64);
        let around = [[[next, 0.0], [k, 0.0]], [[end, next], [end, k]], [[k, end], [next, end]], [[0.0, k], [0.0, next]]];
        around.map(|[p, q]| wall(p, q, SKY_HEIGHT))
    });
    let quads: Vec<Quad> = blocks.chain(sky).chain(ground).chain(walls).collect();
    let mut text = String::new();
    for [x, y, z] in quads.iter().flatten() {
        text += &format!("v {x} {y} {z}\n");
    }
    for first in (1..=4 * quads.len()).step_by(4) {
        text += &format!("f {first} {} {} {}\n", first + 1, first + 2, first + 3);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_city_has_the_faces_that_close_it() {
        for (side, faces) in [(6, 352), (10, 956)] {
            assert_eq!(closed_city(side).lines().filter(|line| line.starts_with('f')).count(), faces, "{side} blocks a side");
        }
    }
}
