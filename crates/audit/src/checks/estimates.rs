//! Estimates of the oracle, beside its enclosures, against closed forms: cubature of functions, known rectangles, counts of rays, intervals,
//! polynomials, slopes and samples of an edge seen end-on.

use glam::DVec3;
use radgrad_core::{Emission, Emitter, Polygon, Receiver, evaluate_to};
use radgrad_oracle::cubature::{Status, integrate_function};
use radgrad_oracle::monte_carlo::{Sampling, Sequence, integrate};
use radgrad_oracle::scene::known::FacingRectangles;
use radgrad_oracle::scene::rays_for;
use radgrad_oracle::{EmissionFunction, Error, Interval, Polynomial, enclose, slope_along};

use crate::cases::sampler::Sampler;

type Told = Result<Vec<String>, Box<dyn std::error::Error>>;

/// An affine function with its gradient, without, and with another one, against the closed form.
fn functions() -> Told {
    let sampler = &mut Sampler::new(21, "functions", 0);
    let mut findings = Vec::new();
    for _ in 0..4 {
        let place = |sampler: &mut Sampler| sampler.cube() + DVec3::Z * 2.0;
        let polygon = Polygon::new(vec![place(sampler), place(sampler), place(sampler)])?;
        let (slope, least) = (sampler.cube(), 4.0);
        let along = slope - polygon.normal() * slope.dot(polygon.normal());
        let start = polygon.vertices()[0];
        let emitter = Emitter::new(polygon.clone(), Emission::gradient(least + slope.dot(start), along))?;
        let receiver =
            Receiver::new(start + polygon.normal() * 2.0 + sampler.cube() * 0.2, sampler.cube() * 0.2 - polygon.normal(), 1.0)?;
        let truth = evaluate_to(&receiver, &emitter, &[], 1e-13)?;
        let radiosity = |y: DVec3| least + slope.dot(y);
        let (right, wrong) = (|_: DVec3| along, |_: DVec3| along * 1.5 + polygon.normal().any_orthonormal_vector());
        let gradients: [Option<&dyn Fn(DVec3) -> DVec3>; 3] = [None, Some(&right), Some(&wrong)];
        let integrated = |gradient, detail: f64| {
            let emission = EmissionFunction { radiosity: &radiosity, gradient, detail, bounds: None };
            integrate_function(&receiver, &polygon, &emission, 1e-8, 200_000)
        };
        let [alone, both, contradicted] = gradients.map(|gradient| integrated(gradient, f64::INFINITY));
        for estimate in [alone?, both?, integrated(None, 0.75)?] {
            let error = [(estimate.radiosity - truth.radiosity).abs(), (estimate.gradient - truth.gradient).length()];
            let room = [estimate.radiosity_error + truth.radiosity_error, estimate.gradient_error + truth.gradient_error];
            if estimate.status != Status::Converged || !(error[0] <= room[0] && error[1] <= room[1]) {
                findings.push(format!("a function is off by {error:?}, estimated to {room:?}: {:?}", estimate.status));
            }
        }
        if [0.0, -1.0, f64::NAN].into_iter().any(|detail| integrated(None, detail).is_ok()) {
            findings.push("a function is integrated whose details have no size".to_owned());
        }
        let contradicted = contradicted?.status;
        if contradicted != Status::Contradiction {
            findings.push(format!("a gradient that is another function's is {contradicted:?}"));
        }
    }
    Ok(findings)
}

/// Rectangles of a constant radiosity, against the closed form.
fn rectangles() -> Told {
    let mut findings = Vec::new();
    for (gap, width) in [(1.0, 2.0), (0.3, 1.0), (2.5, 0.7)] {
        let rectangles = FacingRectangles {
            low: [[0.0, 0.0], [0.25, -0.5]],
            high: [[1.5, 1.0], [0.25 + width, 1.25]],
            gap,
            reflectance: [0.0, 0.0],
            emitted: [2.0, 3.0],
        };
        let [lower, upper] = rectangles.polygons()?;
        for (which, at, other, b) in [(0, [0.5, 0.25], &upper, 3.0), (1, [0.75, 0.125], &lower, 2.0)] {
            let (z, way) = if which == 0 { (0.0, DVec3::Z) } else { (gap, -DVec3::Z) };
            let receiver = Receiver::new(DVec3::new(at[0], at[1], z), way, 1.0)?;
            let truth = evaluate_to(&receiver, &Emitter::new(other.clone(), Emission::Constant(b))?, &[], 1e-13)?;
            let [dx, dy] = rectangles.slopes(&[(which, at)])[0];
            let mirrors = FacingRectangles { reflectance: [0.5, 0.25], ..rectangles };
            // The radiosity 1 of both, chosen, takes an emission of 1 - rho E.
            let chosen = mirrors.manufactured(which, at, |_, _| 1.0);
            let rho = mirrors.reflectance[which];
            let error = [dx - truth.gradient.x, dy - truth.gradient.y, chosen - (1.0 - rho * truth.radiosity / b)];
            if !error.iter().all(|error| error.abs() <= 1e-9) {
                findings.push(format!("rectangles {gap} apart: slopes and emission are off by {error:?}"));
            }
        }
    }
    Ok(findings)
}

/// Intervals of decimal numbers that doubles hold.
fn intervals() -> Told {
    let [wide, near, exact] =
        [("1.5", 0.25), ("2.25", 0.5), ("0", 0.0)].map(|(text, radius)| Interval::around_decimal(text, radius));
    let (wide, near, exact) = (wide?, near?, exact?);
    let mut findings = Vec::new();
    let mut hold = |what: &str, holds: bool| {
        if !holds {
            findings.push(format!("{what} of intervals"));
        }
    };
    let is_about = |value: f64, of: f64| (of..=of + 1e-12).contains(&value);
    let (low, high) = wide.bounds();
    hold("bounds", is_about(-low, -1.25) && is_about(high, 1.75) && exact.bounds() == (0.0, 0.0));
    hold(
        "members",
        [1.25, 1.5, 1.75].iter().all(|v| wide.contains(*v)) && ![1.2, 1.76, f64::NAN].iter().any(|v| wide.contains(*v)),
    );
    hold("errors", is_about(wide.error_of(2.0), 0.75) && exact.error_of(0.0) == 0.0 && exact.error_of(1.0) >= 1.0);
    hold("common points", wide.overlaps(&near) && !wide.overlaps(&exact) && exact.overlaps(&exact));
    hold("distances", (wide.share_apart(&near) - 1.0).abs() < 1e-12 && exact.share_apart(&exact) == 0.0);
    let less = near.less(&wide);
    hold("differences", less.to_f64() == 0.75 && is_about(less.radius(), 0.75) && exact.less(&exact).radius() == 0.0);
    Ok(findings)
}

/// By Hoeffding's inequality, with one ray less it is not enough.
fn counts() -> Told {
    let mut findings = Vec::new();
    for (error, confidence) in [(0.01, 0.99), (0.5, 0.9), (0.03, 1.0 - 1e-7)] {
        let rays = f64::from(rays_for(error, confidence)?);
        let doubt = |rays: f64| 2.0 * (-2.0 * rays * error * error).exp();
        if !(doubt(rays) <= (1.0 - confidence) * (1.0 + 1e-9) && doubt(rays - 1.0) > 1.0 - confidence) {
            findings.push(format!("{rays} rays for {error} at {confidence}"));
        }
    }
    let is_refused = |error: f64| rays_for(error, 0.99).is_err();
    if ![0.0, -0.1, 1.0, 1e-9, f64::NAN].into_iter().all(is_refused) {
        findings.push("rays for no error, for a whole one or for more than can be counted".to_owned());
    }
    Ok(findings)
}

/// Of a constant that is known to a radius the slope is known to what the ends of the radius allow: `(64 c(1/2) - 20 c(1) + c(2))/45` of
/// central differences, each off by the radius over its step.
fn slopes_of_rough_values() -> Told {
    let mut findings = Vec::new();
    for (radius, step) in [(1.0 / 1024.0, 0.25), (1e-9, 1.0 / 64.0), (0.5, 2.0)] {
        let constant = Interval::around_decimal("1", radius)?;
        let slope = slope_along(|_| Ok(constant.clone()), step)?;
        let least = (64.0 * 2.0 + 20.0 + 0.5) / 45.0 * radius / step;
        let holds = slope.value.abs() <= 1e-12 && slope.error >= least;
        if !holds {
            findings.push(format!("a constant known to {radius:e} has the slope {slope:?} over {step}, off by {least:e}"));
        }
    }
    Ok(findings)
}

/// Values and slopes of polynomials against powers and differences.
fn polynomials() -> Told {
    let sampler = &mut Sampler::new(21, "polynomials", 0);
    let mut findings = Vec::new();
    for _ in 0..8 {
        let terms: Vec<(f64, [u32; 3])> =
            (0..5).map(|_| (sampler.between(-2.0, 2.0), [(); 3].map(|()| sampler.below(4)))).collect();
        let polynomial = Polynomial::new(terms.clone())?;
        let value = |y: DVec3| -> f64 {
            let power = |axis: usize, power: u32| (0..power).map(|_| y[axis]).product::<f64>();
            terms.iter().map(|(c, [i, j, k])| c * power(0, *i) * power(1, *j) * power(2, *k)).sum()
        };
        let (y, step) = (sampler.cube() * 1.5, 1.0 / 4096.0);
        let slope = DVec3::AXES.map(|axis| (value(y + axis * step) - value(y - axis * step)) / (2.0 * step));
        let errors = [(polynomial.value_at(y) - value(y)).abs(), (polynomial.gradient_at(y) - DVec3::from(slope)).length()];
        // The third derivative is at most a thousand.
        if !(errors[0] <= 1e-12 && errors[1] <= 1e-4) {
            findings.push(format!("{terms:?} at {y}: value and slope are off by {errors:?}"));
        }
    }
    Ok(findings)
}

/// Slopes along paths of light that is a function of the parameter. The rule takes 14/45 of what a corner rises in a step for its error.
fn slopes() -> Told {
    let polygon = Polygon::new([[0.2, -0.3, 1.0], [-0.5, 1.0, 1.5], [1.0, 0.5, 1.0]].map(DVec3::from).to_vec())?;
    let receiver = Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?;
    let lit = |light: f64| {
        let emitter = Emitter::new(polygon.clone(), Emission::Constant(light)).map_err(Error::Problem)?;
        Ok(enclose(&receiver, &emitter, 20)?.radiosity)
    };
    let unit = lit(1.0)?.to_f64();
    // The light is 2 + slope t + bend t^2 + corner |t|.
    let paths = [[1.0, 0.0, 0.0], [-3.0, 1.0, 0.0], [1.0, 0.0, 1.0], [0.0, 0.5, -2.0]];
    let mut findings = Vec::new();
    for [value, bend, corner] in paths {
        let slope = slope_along(|t| lit(2.0 + value * t + bend * t * t + corner * t.abs()), 1.0 / 64.0)?;
        let error = 14.0 / 45.0 * f64::abs(corner);
        if !((slope.value / unit - value).abs() <= 1e-12 && (slope.error / unit - error).abs() <= 1e-9) {
            findings.push(format!("a slope of {value:e} with an error of {error:e}, times {unit:e}, is {slope:?}"));
        }
    }
    Ok(findings)
}

/// From a receiver on the line of an edge, and at one corner's height.
fn edges_end_on() -> Told {
    let polygon = Polygon::new([[1.0, 0.0, 1.0], [2.0, 0.0, 1.0], [2.0, 1.0, 2.0], [1.0, 1.0, 2.0]].map(DVec3::from).to_vec())?;
    let mut findings = Vec::new();
    for position in [DVec3::new(0.0, 0.0, 1.0), DVec3::new(1.0, -1.0, 0.0), DVec3::new(1.5, 0.5, 3.0), DVec3::new(1.5, 0.5, 0.0)]
    {
        let toward = DVec3::new(1.5, 0.5, 1.5) - position;
        let receiver = Receiver::new(position, toward, 1.0)?;
        let emitter = Emitter::new(polygon.clone(), Emission::at_vertices(vec![1.0, 2.0, 2.0, 1.0]))?;
        let truth = evaluate_to(&receiver, &emitter, &[], 1e-12)?;
        for (sampling, sequence) in [
            (Sampling::SolidAngle, Sequence::Independent { samples: 2000, seed: 5 }),
            (Sampling::Area, Sequence::Sobol { samples: 256, scramblings: 16, seed: 5 }),
        ] {
            let sampled = integrate(&receiver, &emitter, &[], sampling, sequence, 1.0 - 1e-6)?;
            let limits = std::iter::once((sampled.radiosity, truth.radiosity))
                .chain(sampled.gradient.into_iter().zip(truth.gradient.to_array()));
            for (limits, truth) in limits {
                let free = limits.distribution_free;
                if !(free.low <= truth + 1e-12 && truth - 1e-12 <= free.high && free.width() < 10.0) {
                    findings.push(format!("{sampling:?} from {position}: {truth} is not in {free:?}"));
                }
            }
        }
    }
    Ok(findings)
}

/// Who allows as many evaluations as a refusal names is not refused again for as many.
fn budgets() -> Told {
    let polygon = Polygon::new([[-1.0, -0.5, 0.0], [1.5, -0.5, 0.0], [0.25, 1.25, 0.0]].map(DVec3::from).to_vec())?;
    let receiver = Receiver::new(DVec3::new(0.1, 0.2, 0.5), -DVec3::Z, 1.0)?;
    let emission =
        EmissionFunction { radiosity: &|_| 1.0, gradient: Some(&|_| DVec3::ZERO), detail: f64::INFINITY, bounds: None };
    let mut allowed = 1;
    loop {
        match integrate_function(&receiver, &polygon, &emission, 1e-3, allowed) {
            Err(Error::Evaluations { budget, needed }) if budget == allowed && needed > allowed => allowed = needed,
            Ok(_) => return Ok(Vec::new()),
            other => return Ok(vec![format!("with {allowed} evaluations allowed: {other:?}")]),
        }
    }
}

/// A function that jumps along a line, against the two parts on which it is constant: the estimates hold, and that of the value is not made of
/// the slope's, which is larger by one over the height.
fn jumps() -> Told {
    let corners = [[-1.25, -0.75, 0.0], [1.5, -0.5, 0.0], [0.25, 1.25, 0.0]].map(DVec3::from);
    let receiver = Receiver::new(DVec3::Z / 32.0, -DVec3::Z, 1.0)?;
    let side = |y: DVec3| 0.8 * y.x + 0.6 * y.y - 0.3;
    let radiosity = |y: DVec3| if side(y) >= 0.0 { 3.0 } else { 1.0 };
    let emission = EmissionFunction { radiosity: &radiosity, gradient: None, detail: f64::INFINITY, bounds: None };
    let estimate = integrate_function(&receiver, &Polygon::new(corners.to_vec())?, &emission, 0.02, 200_000)?;
    // The first corner is on the one side of the line, the others are on the other.
    let crossing = |i: usize| corners[0].lerp(corners[i], side(corners[0]) / (side(corners[0]) - side(corners[i])));
    let (a, b) = (crossing(1), crossing(2));
    let (mut value, mut slope) = (0.0, DVec3::ZERO);
    for (part, light) in [(vec![corners[0], a, b], 1.0), (vec![a, corners[1], corners[2], b], 3.0)] {
        let truth = evaluate_to(&receiver, &Emitter::new(Polygon::new(part)?, Emission::Constant(light))?, &[], 1e-12)?;
        value += truth.radiosity;
        slope += truth.gradient;
    }
    let error = [(estimate.radiosity - value).abs(), (estimate.gradient - slope).length()];
    let holds = error[0] <= estimate.radiosity_error && error[1] <= estimate.gradient_error;
    let is_tight = estimate.radiosity_error <= 2e-4 * value && estimate.gradient_error <= 0.02 * slope.length();
    let is_right = estimate.status == Status::Converged && holds && is_tight;
    Ok(if is_right { Vec::new() } else { vec![format!("past a jump off by {error:?}: {estimate:?}")] })
}

/// Slopes by samples from just over a floor that reaches behind the receiver too, and from just over the plane of a lamp with a screen beyond it.
fn beside_edges() -> Told {
    const OVER: f64 = 1.0 / (1u64 << 30) as f64;
    let polygon = |corners: [[f64; 3]; 4]| Polygon::new(corners.map(DVec3::from).to_vec());
    let wall = polygon([[1.0, -0.9, -0.5], [1.0, -0.9, 1.0], [1.0, 0.9, 1.0], [1.0, 0.9, -0.5]])?;
    let floor = polygon([[-2.0, -2.0, -OVER], [0.9, -2.0, -OVER], [0.9, 2.0, -OVER], [-2.0, 2.0, -OVER]])?;
    let lamp = polygon([[1.0, -1.0, -OVER], [2.0, -1.0, -OVER], [2.0, 1.0, -OVER], [1.0, 1.0, -OVER]])?;
    let screen = polygon([[2.25, -3.0, -0.5], [2.25, 3.0, -0.5], [2.25, 3.0, 0.5], [2.25, -3.0, 0.5]])?;
    let receiver = Receiver::new(DVec3::ZERO, DVec3::X, 1.0)?;
    let mut findings = Vec::new();
    for (emitter, occluder) in [(wall, floor), (lamp, screen)] {
        let emitter = Emitter::new(emitter, Emission::Constant(1.0))?;
        let truth = evaluate_to(&receiver, &emitter, [&occluder], 1e-9)?;
        let sequence = Sequence::Independent { samples: 20_000, seed: 5 };
        let sampled = integrate(&receiver, &emitter, &[occluder], Sampling::SolidAngle, sequence, 1.0 - 1e-6)?;
        for (limits, truth) in sampled.gradient.into_iter().zip(truth.gradient.to_array()) {
            let free = limits.distribution_free;
            if !(free.low <= truth + 1e-8 && truth - 1e-8 <= free.high && free.width() < 0.25) {
                findings.push(format!("beside an edge a slope of {truth} is not in {free:?}"));
            }
        }
    }
    Ok(findings)
}

/// All findings of these checks.
#[must_use]
pub fn all_wrong() -> Vec<String> {
    let asked = [functions, rectangles, intervals, counts, polynomials, slopes, slopes_of_rough_values, edges_end_on];
    let asked = asked.into_iter().chain([budgets, jumps, beside_edges]);
    asked.flat_map(|ask| ask().unwrap_or_else(|error| vec![error.to_string()])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_wrong() {
        assert_eq!(all_wrong(), Vec::<String>::new());
    }
}
