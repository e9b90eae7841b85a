//! How much of the light arrives along a line over the floor of the Cornell box, past its two blocks.
//!
//! `cargo run -p radgrad-scene --example light_on_the_floor`

use std::error::Error;

use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, evaluate};
use radgrad_scene::{Beam, Degenerate, Occluders, Scene};

fn main() -> Result<(), Box<dyn Error>> {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/cornell.obj");
    let scene = Scene::read(file, Degenerate::Refuse)?;
    for note in scene.notes() {
        println!("{note}");
    }
    let polygon_of = |face: usize| scene.faces()[face].polygon();
    let first_face = |name| scene.surface_named(name).map(|surface| scene.surfaces()[surface].faces()[0]);
    let (floor, light) = (first_face("floor")?, first_face("light")?);
    let lamp = Emitter::new(polygon_of(light).clone(), Emission::Constant(1.0))?;
    let index = Occluders::new(scene.polygons());

    println!("{:>5} {:>10} {:>8} {:>10} {:>9}", "x, mm", "factor", "bound", "per mm", "occluders");
    for step in 1..11 {
        let point = DVec3::new(50.0 * f64::from(step), 0.0, 50.0);
        let Some(beam) = Beam::from_point_of(polygon_of(floor), point, polygon_of(light)) else { continue };
        let found = index.in_beam(&beam, &[floor, light]).polygons;
        let hiding: Vec<Polygon> = found.iter().map(|&face| polygon_of(face).clone()).collect();
        let answer = evaluate(&Receiver::new(point, polygon_of(floor).normal(), 1.0)?, &lamp, &hiding)?;
        let (factor, bound) = (answer.radiosity, answer.radiosity_error);
        println!("{:>5} {factor:>10.7} {bound:>8.0e} {:>10.7} {:>9}", point.x, answer.gradient.x, hiding.len());
    }
    Ok(())
}
