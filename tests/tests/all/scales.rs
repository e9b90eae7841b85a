//! The cases of `data/reference/scales.jsonl`: occluders far smaller and larger than the emitter's distance, and walls on the receiver's
//! floor; and normals of components far apart.

use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, evaluate, evaluate_digits};
use radgrad_oracle::enclose;
use radgrad_scene::case::Case;
use radgrad_tests::decimal::Decimal;
use radgrad_tests::reference::scale_cases;

#[test]
fn occluders_of_any_scale_hide_what_they_do() {
    for (line, truth) in scale_cases() {
        let case = Case::from_json(line.as_bytes()).unwrap();
        let problem = case.problem().unwrap();
        let answer = evaluate(&problem.receiver, &problem.emitter, &problem.occluders).unwrap();
        let digits = evaluate_digits(&problem.receiver, &problem.emitter, &problem.occluders, 50).unwrap();
        let apart = |text: &str, found: &str| {
            let [truth, found]: [Decimal; 2] = [text, found].map(|text| text.parse().unwrap());
            ((truth.high - found.high) + (truth.low - found.low)).abs() / truth.high.abs()
        };
        let radiosity: Decimal = truth.radiosity.parse().unwrap();
        assert!(radiosity.error_of(answer.radiosity) <= answer.radiosity_error, "{}: {answer:?}", case.id);
        assert!(apart(&truth.radiosity, &digits.radiosity) < 2e-15, "{}: {digits:?}", case.id);
        let Some(gradient) = truth.gradient else { continue };
        let off = DVec3::from([0, 1, 2].map(|axis| gradient[axis].parse::<Decimal>().unwrap().error_of(answer.gradient[axis])));
        assert!(off.length() <= answer.gradient_error, "{}: {answer:?}", case.id);
    }
}

/// The truth takes the normal as given, in arithmetic of its own.
#[test]
fn components_of_a_normal_far_below_the_largest_count() {
    let wall = [[1.0, -1.0, -1.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, -1.0]].map(DVec3::from);
    let emitter = Emitter::new(Polygon::new(wall.to_vec()).unwrap(), Emission::Constant(1e307)).unwrap();
    for (small, large) in [(1.25e-14, 1e308), (1.25e-24, 1e298), (5e-324, 1.7e308), (1e-17, 1e308), (1e-160, 1e150), (1e-17, 1.0)]
    {
        for small in [small, -small] {
            let receiver = Receiver::new(DVec3::ZERO, DVec3::new(small, 0.0, large), 1.0).unwrap();
            let Ok(answer) = evaluate(&receiver, &emitter, &[]) else { continue };
            let truth = enclose(&receiver, &emitter, 20).unwrap();
            let off = [0, 1, 2].map(|axis| truth.gradient[axis].error_of(answer.gradient[axis]));
            assert!(truth.radiosity.error_of(answer.radiosity) <= answer.radiosity_error, "{small:e} {large:e}: {answer:?}");
            assert!(DVec3::from(off).length() <= answer.gradient_error * 1.01, "{small:e} {large:e}: {answer:?}, {truth:?}");
            if small > 0.0
                && let Ok(digits) = evaluate_digits(&receiver, &emitter, &[], 20)
            {
                let slope = digits.gradient[2].parse::<f64>().unwrap();
                assert!((slope - truth.gradient[2].to_f64()).abs() <= 1e-14 * slope.abs(), "{digits:?}, {truth:?}");
            }
        }
    }
}
