//! How much of the light arrives along a line over the floor of the Cornell box, past its two blocks.
//!
//! `cargo run -p radgrad-scene --example light_on_the_floor`
//!
//! ```text
//! data/scenes/cornell.obj:65: a face of `left` has a vertex 8.000e-1 off its plane (size 5.592e2): split into 2 triangles
//! x, mm     factor    bound     per mm occluders
//!    50  0.0033020    6e-16 -0.0001403         2
//!   100  0.0000000      0e0  0.0000000         3
//!   150  0.0000000      0e0  0.0000000         2
//!   200  0.0000000      0e0  0.0000000         3
//!   250  0.0007536    7e-16  0.0000461         3
//!   300  0.0075942    5e-16  0.0001725         3
//!   350  0.0100730    2e-16 -0.0000079         0
//!   400  0.0095620    2e-16 -0.0000124         0
//!   450  0.0088579    2e-16 -0.0000156         0
//!   500  0.0080288    2e-16 -0.0000174         0
//! ```

use std::error::Error;

use radgrad_core::{DVec3, Emission, Emitter, Receiver, evaluate};
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
        let between = index.in_beam(&beam, &[floor, light]).polygons;
        let hiding = between.iter().map(|&face| polygon_of(face));
        let answer = evaluate(&Receiver::new(point, polygon_of(floor).normal(), 1.0)?, &lamp, hiding)?;
        let (factor, bound) = (answer.radiosity, answer.radiosity_error);
        println!("{:>5} {factor:>10.7} {bound:>8.0e} {:>10.7} {:>9}", point.x, answer.gradient.x, between.len());
    }
    Ok(())
}
