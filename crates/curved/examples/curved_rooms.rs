//! Rooms of curved patches whose radiosity is known: error, bound and effort.
//!
//! `cargo run --release -p radgrad-solver --example curved_rooms`

use std::error::Error;
use std::f64::consts::{PI, TAU};

use radgrad_core::DVec3;
use radgrad_curved::{CurvedOptions, CurvedScene, Patch, Side, Value, solve};

/// A room, where it is looked at, and the radiosity there.
struct Room {
    name: &'static str,
    scene: CurvedScene,
    options: CurvedOptions,
    at: [f64; 2],
    exact: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("{:<42} {:>5} {:>9} {:>9}", "room", "parts", "error", "bound");
    for room in [sphere()?, bowl()?, nested()?] {
        let solution = solve(room.scene, &room.options)?;
        let answer = solution.gather(0, room.at)?;
        let error = (answer.radiosity - room.exact).abs();
        println!("{:<42} {:>5} {error:>9.1e} {:>9.1e}", room.name, solution.parts(), answer.bound);
    }
    Ok(())
}

/// A sphere whose emission and reflectance vary with the height z: the irradiance is `mean E / (1 - mean rho)` everywhere.
fn sphere() -> Result<Room, radgrad_curved::Error> {
    let mut scene = CurvedScene::new();
    let (reflectance, emitted) = (Value::function(0.8, |x| 0.8 * x.z * x.z), Value::function(2.0, |x| 1.0 + x.z));
    scene.add(Patch::whole_sphere(DVec3::ZERO, 1.0, Side::Inside)?, reflectance, emitted)?;
    let z = (0.25 * PI).cos();
    let exact = 1.0 + z + 0.8 * z * z / (1.0 - 0.8 / 3.0);
    Ok(Room { name: "sphere, E and rho functions of height", scene, options: CurvedOptions::default(), at: [0.4, 0.25], exact })
}

/// The lower fifth of a sphere: `E / (1 - rho A / 4 pi R^2)`.
fn bowl() -> Result<Room, radgrad_curved::Error> {
    let mut scene = CurvedScene::new();
    let part = 0.2_f64;
    let brim = (2.0 * part - 1.0).acos();
    scene.add(Patch::sphere(DVec3::ZERO, 2.0, [brim, PI], [0.0, TAU], Side::Inside)?, 0.9, 1.0)?;
    let exact = 1.0 / (1.0 - 0.9 * part);
    Ok(Room { name: "bowl, a fifth of a sphere", scene, options: CurvedOptions::default(), at: [0.4, 0.25], exact })
}

/// A sphere within another: the outer one sees itself past the inner one.
fn nested() -> Result<Room, radgrad_curved::Error> {
    let mut scene = CurvedScene::new();
    scene.add(Patch::whole_sphere(DVec3::ZERO, 2.0, Side::Inside)?, 0.5, 0.0)?;
    scene.add(Patch::whole_sphere(DVec3::ZERO, 1.0, Side::Outside)?, 0.5, 1.0)?;
    // A quarter of the outer sphere's view is the inner one, whose radiosity is 1 + B/2.
    let exact = 0.5 * 0.25 / (1.0 - 0.5 * 0.75 - 0.5 * 0.25 * 0.5);
    let options = CurvedOptions { degree: 0, most_parts: 2, most_cells: 2000, ..CurvedOptions::default() };
    Ok(Room { name: "sphere in a sphere", scene, options, at: [0.4, 0.25], exact })
}
