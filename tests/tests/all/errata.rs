//! Every misprint of the paper fails as printed and passes as corrected; `ERRATA.md` states each with the effect measured here.
//!
//! The references are the published numbers of the paper's scene, and direct integration of Eq. 1 under tilted receivers, where
//! the surface integrals of the linear emitter count, and under a quadrilateral, where k does.

use glam::DVec3;
use radgrad_core::{Emission, Emitter, Polygon, Receiver};
use radgrad_paper::appendix::{self, Misprint};
use radgrad_tests::reference::paper_scene;
use radgrad_tests::{RelativeError, direct};

/// Errors allowed to the corrected form, which a misprint must exceed by far.
const ALLOWED: f64 = 1e-13;
/// The smallest effect of a misprint that is no rounding.
const NOTICED: f64 = 1e-4;

struct Scene {
    id: String,
    receiver: Receiver,
    emitter: Emitter,
    truth: (f64, DVec3),
}

fn scenes() -> Vec<Scene> {
    let quadrilateral = [(0.0, 0.0), (0.2, 0.9), (1.0, 0.8), (1.1, -0.1)].map(|(x, y)| DVec3::new(x, y, 1.0));
    let quadrilateral = Polygon::new(quadrilateral.to_vec()).unwrap();
    let emission = Emission::gradient(2.0, DVec3::new(1.0, 0.5, 0.0));
    let mut scenes: Vec<Scene> = paper_scene()
        .into_iter()
        .map(|case| Scene { truth: case.nearest(), id: case.id, receiver: case.receiver, emitter: case.emitter })
        .collect();
    let emitters = [scenes[0].emitter.clone(), scenes[4].emitter.clone(), Emitter::new(quadrilateral, emission).unwrap()];
    for (shape, emitter) in ["constant triangle", "linear triangle", "linear quadrilateral"].iter().zip(emitters) {
        for (position, normal) in [
            ([0.5, 0.3, 0.0], [0.3, 0.2, 0.9]),
            ([0.0, 0.0, 0.2], [0.2, 0.5, 0.8]),
            ([1.5, -0.25, 0.0], [-0.4, 0.1, 0.9]),
            ([0.25, 1.5, -0.5], [0.1, -0.6, 0.7]),
        ] {
            let receiver = Receiver::new(DVec3::from(position), DVec3::from(normal), 1.0).unwrap();
            let truth = direct::radiosity_and_gradient(&receiver, &emitter);
            scenes.push(Scene { id: format!("{shape} from {position:?}"), receiver, emitter: emitter.clone(), truth });
        }
    }
    scenes
}

/// Smallest and largest relative error over the scenes that have the term in question.
#[derive(Debug, Clone, Copy)]
struct Effect {
    scenes: usize,
    radiosity: [f64; 2],
    gradient: [f64; 2],
}

impl Effect {
    const NONE: Self = Self { scenes: 0, radiosity: [f64::INFINITY, 0.0], gradient: [f64::INFINITY, 0.0] };

    fn with(self, error: RelativeError) -> Self {
        let extend = |[low, high]: [f64; 2], e: f64| [low.min(e), high.max(e)];
        Self {
            scenes: self.scenes + 1,
            radiosity: extend(self.radiosity, error.radiosity),
            gradient: extend(self.gradient, error.gradient),
        }
    }

    fn row(&self, name: &str) -> String {
        let percent = |e: f64| if e < ALLOWED { "none".to_owned() } else { format!("{:.2} %", 100.0 * e) };
        let range = |[low, high]: [f64; 2]| {
            if percent(low) == percent(high) { percent(low) } else { format!("{} to {}", percent(low), percent(high)) }
        };
        format!("| `{name}` | {} | {} | {} |", self.scenes, range(self.radiosity), range(self.gradient))
    }
}

fn effect(slip: Misprint) -> Effect {
    scenes().iter().filter(|case| slip.shows_in(&case.receiver, &case.emitter)).fold(Effect::NONE, |effect, case| {
        let wrong = appendix::radiosity_and_gradient(&case.receiver, &case.emitter, Some(slip)).unwrap();
        effect.with(RelativeError::new(wrong, case.truth))
    })
}

/// The form with the misprint must be off wherever the misprinted term is there.
fn assert_fails_as_printed(slip: Misprint) {
    let mut shown = 0;
    for case in scenes().iter().filter(|case| slip.shows_in(&case.receiver, &case.emitter)) {
        let wrong = appendix::radiosity_and_gradient(&case.receiver, &case.emitter, Some(slip)).unwrap();
        let error = RelativeError::new(wrong, case.truth);
        println!("{}: {} {:.2e} {:.2e}", slip.name(), case.id, error.radiosity, error.gradient);
        assert!(error.largest() > NOTICED, "{} passes at {}: {error:?}", slip.name(), case.id);
        shown += 1;
    }
    assert!(shown > 0, "{} shows in no scene", slip.name());
}

#[test]
fn the_corrected_appendix_passes_everywhere() {
    for case in scenes() {
        let right = appendix::radiosity_and_gradient(&case.receiver, &case.emitter, None).unwrap();
        let error = RelativeError::new(right, case.truth);
        assert!(error.largest() < ALLOWED, "{}: {error:?}", case.id);
    }
}

#[test]
fn the_sign_of_equation_9_fails_as_printed() {
    assert_fails_as_printed(Misprint::Equation9Sign);
}

#[test]
fn the_second_integrand_of_equations_9_and_11_fails_as_printed() {
    assert_fails_as_printed(Misprint::Equation11Integrand);
}

#[test]
fn k_of_a_triangle_fails_for_a_quadrilateral() {
    assert_fails_as_printed(Misprint::TriangleK);
}

#[test]
fn the_plus_in_j1_fails_as_printed() {
    assert_fails_as_printed(Misprint::J1Sign);
}

#[test]
fn the_logarithm_in_j1_fails_as_printed() {
    assert_fails_as_printed(Misprint::J1Logarithm);
}

#[test]
fn the_logarithms_in_k1_fail_as_printed() {
    assert_fails_as_printed(Misprint::K1Logarithm);
}

#[test]
fn the_first_edge_in_every_term_of_the_gradient_fails_as_printed() {
    assert_fails_as_printed(Misprint::FirstEdgeInGradient);
}

#[test]
fn i2_in_the_place_of_i1_fails_as_printed() {
    assert_fails_as_printed(Misprint::I2ForI1);
}

#[test]
fn the_missing_constant_of_k1_changes_nothing() {
    for case in scenes() {
        let printed = appendix::radiosity_and_gradient(&case.receiver, &case.emitter, Some(Misprint::K1Constant)).unwrap();
        let error = RelativeError::new(printed, case.truth);
        assert!(error.largest() < ALLOWED, "{}: {error:?}", case.id);
    }
}

#[test]
fn the_appendix_as_printed_fails_for_every_linear_emitter() {
    for case in scenes().iter().filter(|case| case.emitter.emission_gradient() != DVec3::ZERO) {
        let printed = appendix::as_printed(&case.receiver, &case.emitter).unwrap();
        let error = RelativeError::new(printed, case.truth);
        println!("as printed: {} {:.2e} {:.2e}", case.id, error.radiosity, error.gradient);
        assert!(error.radiosity > NOTICED && error.gradient > NOTICED, "passes at {}: {error:?}", case.id);
    }
}

#[test]
fn every_planted_slip_fails() {
    let behind = Receiver::new(DVec3::new(0.5, 0.3, 2.0), DVec3::new(0.3, 0.2, -0.9), 1.0).unwrap();
    let level = Receiver::new(DVec3::new(0.6, 0.3, 0.2), DVec3::new(0.9, -0.3, 0.2), 1.0).unwrap();
    let emitter = paper_scene().swap_remove(4).emitter;
    let mut scenes = scenes();
    for receiver in [behind, level] {
        let truth = direct::radiosity_and_gradient(&receiver, &emitter);
        scenes.push(Scene { id: format!("from {}", receiver.position()), receiver, emitter: emitter.clone(), truth });
    }
    for &slip in Misprint::ALL {
        let errors = scenes.iter().filter(|case| slip.shows_in(&case.receiver, &case.emitter)).map(|case| {
            let wrong = appendix::radiosity_and_gradient(&case.receiver, &case.emitter, Some(slip)).unwrap();
            RelativeError::new(wrong, case.truth)
        });
        let effect = errors.fold(Effect::NONE, Effect::with);
        println!("{}", effect.row(slip.name()));
        let largest = effect.radiosity[1].max(effect.gradient[1]);
        assert!(effect.scenes > 0 && largest > NOTICED, "{}: {effect:?}", slip.name());
    }
}

#[test]
fn the_document_states_the_measured_effects() {
    let document = include_str!("../../../ERRATA.md");
    for &slip in Misprint::ERRATA {
        let row = effect(slip).row(slip.name());
        assert!(document.lines().any(|line| line == row), "ERRATA.md has no line\n{row}");
    }
}
