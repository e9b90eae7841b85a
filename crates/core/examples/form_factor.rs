//! The form factor from a point to a square, with its proven error and its gradient.
//!
//! `cargo run --example form_factor`
//!
//! ```text
//! form factor  0.13853160599489300 +- 1e-15  (closed-form)
//! catalogue    0.13853160599489300
//! gradient     [0.1434187461985752, 0.1434187461985752, 0.12231745069474492] per m +- 4e-15
//! a step of (1, 1, 1) mm: 4.091549e-4 foreseen, 4.098832e-4 found
//! ```

use radgrad_core::{DVec3, Emission, Emitter, Error, Polygon, Receiver, evaluate};

fn main() -> Result<(), Error> {
    // A unit square 1 m over the receiver, one corner straight above it; counter-clockwise seen from below, so lit downward.
    let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
    let square = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))?;

    // With emission 1 and reflectance 1 the radiosity is the form factor.
    let receiver = Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?;
    let answer = evaluate(&receiver, &square, &[])?;

    // Howell's catalogue, B-3, with a = b = c = 1.
    let catalogue = 0.5_f64.sqrt().atan() / (2.0_f64.sqrt() * std::f64::consts::PI);
    println!("form factor  {:.17} +- {:.0e}  ({})", answer.radiosity, answer.radiosity_error, answer.method.name());
    println!("catalogue    {catalogue:.17}");

    // The gradient predicts the change by a step of 1 mm in each direction, before the step is taken.
    let moved = Receiver::new(DVec3::new(1e-3, 1e-3, 1e-3), DVec3::Z, 1.0)?;
    let change = radgrad_core::radiosity(&moved, &square)? - answer.radiosity;
    println!("gradient     {} per m +- {:.0e}", answer.gradient, answer.gradient_error);
    println!("a step of (1, 1, 1) mm: {:.6e} foreseen, {change:.6e} found", answer.gradient.dot(DVec3::splat(1e-3)));
    Ok(())
}
