//! Emissions that no closed form serves, by cubature: a Gaussian spot, a ripple, and a texture that jumps from texel to texel.
//! Each answer comes with estimates of its errors and says how it ended.
//!
//! `cargo run --release --package radgrad-oracle --example spot_light`
//!
//! ```text
//! spot     to 1e-3: 0.68445907634 +- 2e-15 W/m2, Converged after 6924444 evaluations
//!                  gradient [-0.266257219, -0.532514438, 0.689602280] +- 4e-15 W/m3
//! spot     to 1e-9: 0.68445907634 +- 2e-15 W/m2, Converged after 6924444 evaluations
//!                  gradient [-0.266257219, -0.532514438, 0.689602280] +- 4e-15 W/m3
//! ripple   to 1e-3: 0.50852954164 +- 5e-13 W/m2, Converged after 90148 evaluations
//!                  gradient [-0.099213116, -0.189554225, 0.404377684] +- 1e-12 W/m3
//! ripple   to 1e-9: 0.50852954164 +- 5e-13 W/m2, Converged after 90148 evaluations
//!                  gradient [-0.099213116, -0.189554225, 0.404377684] +- 1e-12 W/m3
//! texture  to 1e-3: 0.51069673278 +- 5e-3 W/m2, BudgetExhausted after 2999990 evaluations
//!                  gradient [-0.090866049, -0.189786180, 0.407135800] +- 6e-3 W/m3
//! texture  to 1e-9: 0.51069673278 +- 5e-3 W/m2, BudgetExhausted after 2999990 evaluations
//!                  gradient [-0.090866049, -0.189786180, 0.407135800] +- 6e-3 W/m3
//! slip     to 1e-3: 0.50852954164 +- 5e-13 W/m2, Contradiction after 90148 evaluations
//!                  gradient [-0.099213116, -0.189554225, 0.404377684] +- 1e-12 W/m3
//! slip     to 1e-9: 0.50852954164 +- 5e-13 W/m2, Contradiction after 90148 evaluations
//!                  gradient [-0.099213116, -0.189554225, 0.404377684] +- 1e-12 W/m3
//! ```

use radgrad_core::{DVec3, Polygon, Receiver};
use radgrad_oracle::cubature::integrate_function;
use radgrad_oracle::{EmissionFunction, Error};

/// Radius of the spot at 1/e of its middle, in metres.
const SPOT: f64 = 0.05;
/// Wavelength of the ripple.
const RIPPLE: f64 = 0.25;
/// Width of a texel.
const TEXEL: f64 = 0.25;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A screen of 2 m x 2 m at 1.5 m over a point of the floor.
    let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)].map(|(x, y)| DVec3::new(x, y, 1.5));
    let screen = Polygon::new(corners.to_vec())?;
    let floor = Receiver::new(DVec3::new(0.25, 0.5, 0.0), DVec3::Z, 0.8)?;

    let spot = |y: DVec3| 1e3 * libm::exp(-(y.x * y.x + y.y * y.y) / (SPOT * SPOT));
    let spot_slope = |y: DVec3| spot(y) * -2.0 / (SPOT * SPOT) * y.with_z(0.0);
    report("spot", &floor, &screen, spot, Some(&spot_slope), SPOT, 10_000_000)?;

    let k = std::f64::consts::TAU / RIPPLE;
    let ripple = |y: DVec3| 2.0 + libm::sin(k * y.x);
    let ripple_slope = |y: DVec3| DVec3::X * k * libm::cos(k * y.x);
    report("ripple", &floor, &screen, ripple, Some(&ripple_slope), RIPPLE, 10_000_000)?;

    // It jumps and so has no gradient, and cubature of it is slow. Texels as emitters of their own are exact: `evaluate` of core.
    let texture = |y: DVec3| if ((y.x / TEXEL).floor() + (y.y / TEXEL).floor()).rem_euclid(2.0) == 0.0 { 3.0 } else { 1.0 };
    report("texture", &floor, &screen, texture, None, TEXEL, 3_000_000)?;

    // Its gradient is not that of the ripple, and that is seen.
    report("slip", &floor, &screen, ripple, Some(&|y| -ripple_slope(y)), RIPPLE, 10_000_000)
}

fn report(
    name: &str,
    receiver: &Receiver,
    screen: &Polygon,
    radiosity: impl Fn(DVec3) -> f64,
    gradient: Option<&dyn Fn(DVec3) -> DVec3>,
    detail: f64,
    budget: usize,
) -> Result<(), Box<dyn std::error::Error>> {
    let emission = EmissionFunction { radiosity: &radiosity, gradient, detail, bounds: None };
    for tolerance in [1e-3, 1e-9] {
        match integrate_function(receiver, screen, &emission, tolerance, budget) {
            Ok(estimate) => println!(
                "{name:8} to {tolerance:e}: {:.11} +- {:.0e} W/m2, {:?} after {} evaluations\n{:17}gradient {:.9} +- {:.0e} W/m3",
                estimate.radiosity,
                estimate.radiosity_error,
                estimate.status,
                estimate.evaluations,
                "",
                estimate.gradient,
                estimate.gradient_error
            ),
            Err(error @ Error::Evaluations { .. }) => println!("{name:8} to {tolerance:e}: {error}"),
            Err(error) => return Err(error.into()),
        }
    }
    Ok(())
}
