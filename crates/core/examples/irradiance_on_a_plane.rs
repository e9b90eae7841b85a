//! Radiosity on a plane under a triangle, drawn in letters, and its brightest point, found by following the gradient.
//!
//! `cargo run --example irradiance_on_a_plane`

use radgrad_core::{DVec3, Emission, Emitter, Error, Polygon, Receiver, radiosity, radiosity_and_gradient};

/// From dark to bright.
const SHADES: [u8; 10] = *b" .:-=+*#%@";

fn main() -> Result<(), Error> {
    // The emitter of the paper: 1 m over the plane, 1 to 4 W/m2 at its vertices and linear between them.
    let vertices = vec![DVec3::new(0.0, 0.0, 1.0), DVec3::new(0.5, 0.8, 1.0), DVec3::new(1.0, 0.0, 1.0)];
    let emitter = Emitter::new(Polygon::new(vertices)?, Emission::at_vertices(vec![1.0, 2.0, 4.0]))?;
    let on_plane = |x: f64, y: f64| Receiver::new(DVec3::new(x, y, 0.0), DVec3::Z, 1.0);

    // Up the slope, by steps that shrink with it: at the brightest point the gradient has no part along the plane.
    let (mut x, mut y) = (-0.5, -0.5);
    let brightest = loop {
        let (value, gradient) = radiosity_and_gradient(&on_plane(x, y)?, &emitter)?;
        if gradient.truncate().length() < 1e-12 {
            break value;
        }
        (x, y) = (x + gradient.x, y + gradient.y);
    };

    for row in 0..20 {
        for column in 0..60 {
            let value = radiosity(&on_plane(-1.0 + f64::from(column) / 20.0, 1.7 - f64::from(row) * 0.15)?, &emitter)?;
            let shade = (1..10).take_while(|i| value / brightest >= f64::from(*i) / 9.5).count();
            print!("{}", char::from(SHADES[shade]));
        }
        println!();
    }
    println!("brightest at ({x:.9}, {y:.9}): {brightest:.12} W/m2");
    Ok(())
}
