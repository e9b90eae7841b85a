//! No cubature that says it converged may be wrong: 116 cases that defeat adaptive integrators, three tolerances.

use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver};
use radgrad_oracle::Source;
use radgrad_oracle::cubature::{Form, Status, integrate_form};

struct Case {
    family: String,
    receiver: Receiver,
    emitter: Emitter,
    radiosity: f64,
    gradient: DVec3,
}

fn hard_cases() -> Vec<Case> {
    include_str!("data/hard_cases.txt").lines().filter(|line| !line.starts_with('#')).map(parse).collect()
}

fn parse(line: &str) -> Case {
    let mut words = line.split(' ');
    let family = words.next().unwrap().to_owned();
    let mut number = || words.next().unwrap().parse::<f64>().unwrap();
    let mut vector = || DVec3::new(number(), number(), number());
    let (position, normal) = (vector(), vector());
    let reflectance = number();
    let vertices = (0..number() as usize).map(|_| DVec3::new(number(), number(), number())).collect();
    let emission = match number() as usize {
        1 => Emission::Constant(number()),
        count => Emission::at_vertices((0..count).map(|_| number()).collect()),
    };
    Case {
        family,
        receiver: Receiver::new(position, normal, reflectance).unwrap(),
        emitter: Emitter::new(Polygon::new(vertices).unwrap(), emission).unwrap(),
        radiosity: number(),
        gradient: DVec3::new(number(), number(), number()),
    }
}

#[test]
fn probe() {
    for (form, tolerance) in [Form::Surface, Form::Contour, Form::Boundary].into_iter().flat_map(|form| [1e-3, 1e-6, 1e-10].map(|t| (form, t))) {
        let (mut silent, mut statuses, mut evaluations, mut worst) = (0, [0; 3], 0, 0.0f64);
        let start = std::time::Instant::now();
        for (line, case) in hard_cases().iter().enumerate() {
            let estimate = integrate_form(&case.receiver, case.emitter.polygon(), Source::Emitter(&case.emitter), form, tolerance, 2_000_000).unwrap();
            let value = (estimate.radiosity - case.radiosity).abs() / case.radiosity;
            let gradient = (estimate.gradient - case.gradient).length() / case.gradient.length();
            let over = value.max(gradient) / tolerance;
            statuses[estimate.status as usize] += 1;
            evaluations += estimate.evaluations;
            if estimate.status == Status::Converged {
                worst = worst.max(over);
                silent += usize::from(over > 10.0);
            }
            let v = estimate.radiosity_error / case.radiosity;
            let g = estimate.gradient_error / case.gradient.length();
            if over > 1.0 || value > v || gradient > g || estimate.status != Status::Converged {
                println!(
                    "{line} {} {tolerance:e} {:?} {} value {value:.1e} ({v:.1e}) gradient {gradient:.1e} ({g:.1e}) {}",
                    case.family,
                    estimate.status,
                    estimate.evaluations,
                    if value > v || gradient > g { "UNDER" } else { "" }
                );
            }
        }
        println!("== {form:?} {tolerance:e}: silent {silent}, worst {worst:.2e}, {statuses:?}, {evaluations} {:?}", start.elapsed());
    }
}
