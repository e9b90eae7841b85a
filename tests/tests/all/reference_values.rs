//! Published numbers are met to 1e-14, by both implementations.

use radgrad_tests::FORMS;
use radgrad_tests::reference::{paper_scene, point_factors};

const ALLOWED: f64 = 1e-14;

#[test]
fn the_papers_scene_is_met_to_1e_14() {
    let cases = paper_scene();
    assert_eq!(cases.len(), 8);
    for (name, form) in FORMS {
        for case in &cases {
            let error = case.error_of(form(&case.receiver, &case.emitter).unwrap());
            println!("{name}, {}: {:.1e} {:.1e}", case.id, error.radiosity, error.gradient);
            assert!(error.largest() < ALLOWED, "{name}, {}: {error:?}", case.id);
        }
    }
}

#[test]
fn point_factors_of_rectangles_are_met_to_1e_14() {
    let factors = point_factors();
    assert_eq!(factors.len(), 9);
    for (name, form) in FORMS {
        for factor in &factors {
            let (computed, _) = form(&factor.receiver, &factor.emitter).unwrap();
            let error = factor.factor.error_of(computed) / factor.factor.high;
            println!("{name}, {}: {error:.1e}", factor.id);
            assert!(error < ALLOWED, "{name}, {}: {computed} for {:?}", factor.id, factor.factor);
        }
    }
}
