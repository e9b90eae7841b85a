//! The Cornell box linked by form factors and areas (Hanrahan, Salzman and Aupperle 1991): rougher or finer than by the error, and
//! inside its estimate all the same.

use radgrad_scene::{Degenerate, Scene, largest};
use radgrad_solver::{Error, Linking, Options, Solution, solve};

fn cornell() -> Scene {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/cornell.obj");
    Scene::read(file, Degenerate::Refuse).unwrap()
}

fn options(form_factor: f64, area: f64) -> Options {
    let linking = Linking::Thresholds { form_factor, area };
    Options { degree: Some(1), first_elements: 1, most_elements: 2000, linking, ..Options::default() }
}

/// The centres of all roots of a mesh.
fn gathers(solution: &Solution, at: &Solution) -> Vec<(Vec<f64>, Vec<f64>)> {
    let centre = |&root: &usize| {
        let element = &at.mesh().elements()[root];
        let gathered = solution.gather(element.centre(), element.polygon().normal()).unwrap();
        (gathered.radiosity, gathered.estimate.iter().map(radgrad_solver::Ledger::total).collect())
    };
    at.mesh().roots().iter().map(centre).collect()
}

#[test]
fn thresholds_give_more_links_the_smaller_they_are_and_estimates_that_hold() {
    let scene = cornell();
    let by_error = Options { error: 0.02, degree: Some(2), ..Options::default() };
    let exact = solve(&scene, &by_error, |_| true).unwrap();
    let expected = gathers(&exact, &exact);
    let mut before = 0;
    for (form_factor, area) in [(0.5, 1e5), (0.2, 2e4), (0.1, 1e4)] {
        let solution = solve(&scene, &options(form_factor, area), |_| true).unwrap();
        let progress = *solution.progress();
        println!("form factors of {form_factor}, areas of {area}: {progress:?}");
        assert_eq!(progress.round, 1, "thresholds are met in one round");
        assert!(progress.links > before, "{progress:?} after {before} links");
        before = progress.links;
        for ((value, estimate), (reference, its)) in gathers(&solution, &exact).iter().zip(&expected) {
            for channel in 0..3 {
                let (off, likely) = ((value[channel] - reference[channel]).abs(), estimate[channel] + its[channel]);
                assert!(off <= 2.0 * likely, "{off} against {} and {}", estimate[channel], its[channel]);
            }
        }
    }
}

#[test]
fn elements_divided_by_thresholds_are_not_below_the_area() {
    let solution = solve(&cornell(), &options(1e-3, 4e4), |_| true).unwrap();
    for element in solution.mesh().elements().iter().filter(|element| !element.is_leaf()) {
        assert!(element.area() >= 4e4, "{}", element.area());
    }
    let largest = solution.mesh().leaves().map(|leaf| solution.mesh().elements()[leaf].area()).fold(0.0, largest);
    assert!(largest < 4e4, "with form factors this small all are divided as far as may be, but one has {largest}");
}

#[test]
fn thresholds_that_are_none_are_refused_by_name() {
    let scene = cornell();
    for value in [0.0, -1.0, 1.5, f64::NAN] {
        let refused = solve(&scene, &options(value, 1.0), |_| true);
        assert!(matches!(refused, Err(Error::FormFactorThreshold { .. })), "{value}");
    }
    for value in [0.0, -1.0, f64::INFINITY, f64::NAN] {
        let refused = solve(&scene, &options(0.1, value), |_| true);
        assert!(matches!(refused, Err(Error::AreaThreshold { .. })), "{value}");
    }
}
