//! The surface, contour and boundary forms are built differently and must give the same numbers, for any emission.

use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver};
use radgrad_oracle::cubature::{Estimate, Form, Status, integrate, integrate_form};
use radgrad_oracle::{EmissionFunction, Error, SourceFunction};

fn l_shape() -> Polygon {
    let corners = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)];
    // In the plane z = x/2 + y/4, lit from above.
    Polygon::new(corners.map(|(x, y)| DVec3::new(x, y, 0.5 * x + 0.25 * y)).to_vec()).unwrap()
}

fn receivers() -> [(&'static str, Receiver); 4] {
    let receiver = |p: [f64; 3], n: [f64; 3]| Receiver::new(p.into(), n.into(), 0.75).unwrap();
    [
        ("whole", receiver([0.7, 0.3, 4.0], [-0.1, 0.2, -1.0])),
        ("clipped", receiver([0.5, 0.6, 1.5], [1.0, 0.3, -0.2])),
        ("cut in two by the horizon", receiver([1.5, 1.5, 2.0], [-0.9, -1.1, 0.0])),
        ("near", receiver([0.4, 1.1, 0.5], [0.2, 0.1, -1.0])),
    ]
}

fn by_all_forms(receiver: &Receiver, polygon: &Polygon, source: SourceFunction<'_>) -> [Estimate; 3] {
    [Form::Surface, Form::Contour, Form::Boundary].map(|form| {
        let estimate = integrate_form(receiver, polygon, source, form, 1e-11, 5_000_000).unwrap();
        assert_eq!(estimate.status, Status::Converged, "{form:?}");
        estimate
    })
}

fn assert_agreement(name: &str, [surface, contour, boundary]: [Estimate; 3]) {
    assert!(surface.radiosity > 1e-3, "{name}: {}", surface.radiosity);
    for other in [contour, boundary] {
        let value = (other.radiosity / surface.radiosity - 1.0).abs();
        let gradient = (other.gradient - surface.gradient).length() / surface.gradient.length();
        assert!(value < 1e-9 && gradient < 1e-9, "{name}: value {value}, gradient {gradient}");
    }
}

#[test]
fn forms_agree_for_constant_emission() {
    let emitter = Emitter::new(l_shape(), Emission::Constant(1.5)).unwrap();
    for (name, receiver) in receivers() {
        assert_agreement(name, by_all_forms(&receiver, emitter.polygon(), SourceFunction::Emitter(&emitter)));
    }
}

#[test]
fn forms_agree_for_linear_emission() {
    let emission = Emission::gradient(1.5, DVec3::new(0.5, -0.25, 0.125));
    let emitter = Emitter::new(l_shape(), emission).unwrap();
    for (name, receiver) in receivers() {
        assert_agreement(name, by_all_forms(&receiver, emitter.polygon(), SourceFunction::Emitter(&emitter)));
    }
}

#[test]
fn forms_agree_for_cubic_emission() {
    let radiosity = |y: DVec3| 2.0 + y.x * y.x * y.y - 0.5 * y.y * y.z * y.z + 0.25 * y.x;
    let gradient = |y: DVec3| DVec3::new(2.0 * y.x * y.y + 0.25, y.x * y.x - 0.5 * y.z * y.z, -y.y * y.z);
    let function = EmissionFunction { radiosity: &radiosity, gradient: Some(&gradient), detail: f64::INFINITY, bounds: None };
    for (name, receiver) in receivers() {
        assert_agreement(name, by_all_forms(&receiver, &l_shape(), SourceFunction::Function(&function)));
    }
}

#[test]
fn a_linear_emission_is_the_same_as_a_function() {
    let slope = DVec3::new(0.5, -0.25, 0.125);
    let emitter = Emitter::new(l_shape(), Emission::gradient(1.5, slope)).unwrap();
    let (radiosity, gradient) = (|y: DVec3| 1.5 + slope.dot(y), |_| slope);
    let function = EmissionFunction { radiosity: &radiosity, gradient: Some(&gradient), detail: f64::INFINITY, bounds: None };
    for (name, receiver) in receivers() {
        let [affine, ..] = by_all_forms(&receiver, emitter.polygon(), SourceFunction::Emitter(&emitter));
        let forms = by_all_forms(&receiver, emitter.polygon(), SourceFunction::Function(&function));
        assert!((affine.radiosity / forms[0].radiosity - 1.0).abs() < 1e-10, "{name}");
        assert_agreement(name, forms);
    }
}

#[test]
fn the_gradient_is_the_slope_of_the_value() {
    let emission = Emission::gradient(1.5, DVec3::new(0.5, -0.25, 0.125));
    let emitter = Emitter::new(l_shape(), emission).unwrap();
    for (name, receiver) in receivers() {
        let answer = |offset: DVec3| {
            let moved = Receiver::new(receiver.position() + offset, receiver.normal(), 0.75).unwrap();
            by_all_forms(&moved, emitter.polygon(), SourceFunction::Emitter(&emitter))[0]
        };
        let step = 1e-4;
        let slope = DVec3::from_array(
            [DVec3::X, DVec3::Y, DVec3::Z]
                .map(|axis| (answer(axis * step).radiosity - answer(-axis * step).radiosity) / (2.0 * step)),
        );
        let gradient = answer(DVec3::ZERO).gradient;
        assert!((slope - gradient).length() < 1e-6 * gradient.length(), "{name}: {slope} against {gradient}");
    }
}

#[test]
fn behind_and_below_give_exactly_zero() {
    let emitter = Emitter::new(l_shape(), Emission::Constant(1.0)).unwrap();
    let behind = Receiver::new(DVec3::new(0.5, 0.5, -1.0), DVec3::Z, 1.0).unwrap();
    let below = Receiver::new(DVec3::new(0.5, 0.5, 3.0), DVec3::Z, 1.0).unwrap();
    for receiver in [behind, below] {
        for estimate in by_all_forms(&receiver, emitter.polygon(), SourceFunction::Emitter(&emitter)) {
            assert_eq!((estimate.radiosity, estimate.gradient, estimate.evaluations), (0.0, DVec3::ZERO, 0));
        }
    }
}

#[test]
fn a_power_of_two_scales_exactly() {
    for (name, receiver) in receivers() {
        let estimate = |power: f64| {
            let vertices = l_shape().vertices().iter().map(|vertex| *vertex * power).collect();
            let emission = Emission::gradient(1.5, DVec3::new(0.5, -0.25, 0.125) / power);
            let emitter = Emitter::new(Polygon::new(vertices).unwrap(), emission).unwrap();
            let receiver = Receiver::new(receiver.position() * power, receiver.normal(), 0.75).unwrap();
            by_all_forms(&receiver, emitter.polygon(), SourceFunction::Emitter(&emitter))
        };
        let power = 2.0_f64.powi(300);
        let [tiny, unit, huge] = [1.0 / power, 1.0, power].map(estimate);
        for form in 0..3 {
            for (scaled, power) in [(tiny[form], 1.0 / power), (huge[form], power)] {
                assert_eq!(scaled.radiosity, unit[form].radiosity, "{name}");
                assert_eq!(scaled.gradient * power, unit[form].gradient, "{name}");
            }
        }
    }
}

#[test]
fn wrong_settings_are_named() {
    let emitter = Emitter::new(l_shape(), Emission::Constant(1.0)).unwrap();
    let [(_, receiver), ..] = receivers();
    let with = |tolerance, budget| integrate(&receiver, &emitter, tolerance, budget);
    for tolerance in [0.0, -1e-3, f64::NAN, f64::INFINITY] {
        assert!(matches!(with(tolerance, 1000), Err(Error::Tolerance { .. })));
    }
    assert!(matches!(with(1e-3, 10), Err(Error::Evaluations { budget: 10, needed }) if needed > 10));
    let error = |radiosity: &dyn Fn(DVec3) -> f64, detail, form| {
        let function = EmissionFunction { radiosity, gradient: None, detail, bounds: None };
        integrate_form(&receiver, emitter.polygon(), SourceFunction::Function(&function), form, 1e-3, 100_000).unwrap_err()
    };
    assert!(matches!(error(&|_| f64::NAN, f64::INFINITY, Form::Surface), Error::NotFinite { .. }));
    for detail in [0.0, -1.0, f64::NAN] {
        assert!(matches!(error(&|_| 1.0, detail, Form::Surface), Error::Detail { .. }));
    }
    assert!(matches!(error(&|_| 1.0, 1e-6, Form::Surface), Error::Evaluations { budget: 100_000, .. }));
    let message = error(&|_| 1.0, 1.0, Form::Contour).to_string();
    assert_eq!(message, "the emission function has no gradient, which the contour form needs");
}
