//! Heat radiation between the surfaces of a closed room: from form factors to net heat, for grey surfaces of given temperature.
//!
//! With F the factors by surface, e the emittances and r = 1 - e, a part `B = (I - F r)^-1 F e` of one surface's emission is
//! absorbed by another in the end, reflections included (B. Gebhart 1961), and `e_i B_ij` is the effective factor of `q_i = sum_j
//! e_i B_ij sigma (T_i^4 - T_j^4)`. Rows of F that sum to 1 give rows of B that do, and reciprocal factors give heat that adds up
//! to nothing: this is the purpose of the repair.
//!
//! `cargo run -p radgrad-scene --example grey_bodies`
//!
//! ```text
//! rows off by less than 1e-3 before the repair, and factors moved by less: true
//! surface        area     W/m2 effective to floor
//! room_top      12.00     -8.1              0.151
//! room_south    10.00     -8.1              0.151
//! room_north    10.00     -7.8              0.144
//! room_west      7.50     -7.6              0.141
//! room_east      7.50     -8.0              0.148
//! floor         10.00     47.6              0.016
//! low_top        1.00     -0.8              0.015
//! low_south      0.75    -10.6              0.196
//! low_north      0.75    -15.8              0.294
//! low_west       0.75    -10.5              0.195
//! low_east       0.75    -16.1              0.300
//! tall_top       1.00     -0.8              0.015
//! tall_south     1.75    -10.9              0.202
//! tall_north     1.75     -5.9              0.109
//! tall_west      1.75    -10.9              0.203
//! tall_east      1.75     -7.6              0.141
//! all together gain less than a millionth of a watt: true
//! ```

use std::error::Error;

use nalgebra::{DMatrix, DVector};
use radgrad_scene::{Degenerate, FactorSettings, FormFactors, STEFAN_BOLTZMANN, Scene};

const EMITTANCE: f64 = 0.9;

fn main() -> Result<(), Box<dyn Error>> {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");
    let scene = Scene::read(file, Degenerate::Refuse)?;
    let settings = FactorSettings { tolerance: 0.01, estimate: 1e-6, ..FactorSettings::default() };
    let mut matrix = FormFactors::new(&scene)?.matrix(&settings, || ())?;
    let repaired = matrix.repair(&settings)?;
    let is_small = repaired.closure_before < 1e-3 && repaired.largest < 1e-3;
    println!("rows off by less than 1e-3 before the repair, and factors moved by less: {is_small}");

    let by_surface = matrix.by_surface(&scene);
    let count = by_surface.surfaces.len();
    let factors = DMatrix::from_fn(count, count, |i, j| by_surface.rows[i][j].factor);
    let name = |i: usize| scene.surfaces()[by_surface.surfaces[i]].name();
    // The floor is heated to 29 degrees Celsius, the rest is at 20.
    let kelvin = |i: usize| if name(i) == "floor" { 302.15 } else { 293.15_f64 };
    let emitted = DVector::from_fn(count, |i, _| STEFAN_BOLTZMANN * kelvin(i).powi(4));

    let reflected = DMatrix::identity(count, count) - &factors * (1.0 - EMITTANCE);
    let absorbed = reflected.lu().solve(&(&factors * EMITTANCE)).ok_or("a system without a solution")?;
    let effective = absorbed * EMITTANCE;
    let net = |i: usize| (0..count).map(|j| effective[(i, j)] * (emitted[i] - emitted[j])).sum::<f64>();

    println!("{:<12} {:>6} {:>8} {:>18}", "surface", "area", "W/m2", "effective to floor");
    let floor = (0..count).find(|&i| name(i) == "floor").ok_or("no floor")?;
    for i in 0..count {
        println!("{:<12} {:>6.2} {:>8.1} {:>18.3}", name(i), by_surface.areas[i], net(i), effective[(i, floor)]);
    }
    let sum: f64 = (0..count).map(|i| by_surface.areas[i] * net(i)).sum();
    println!("all together gain less than a millionth of a watt: {}", sum.abs() < 1e-6);
    Ok(())
}
