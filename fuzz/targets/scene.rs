//! A scene of a few faces on a coarse grid, so that planes, edges and corners meet: its factors, and its solution.
#![no_main]

use libfuzzer_sys::Corpus;
use radgrad_core::DVec3;
use radgrad_scene::{Degenerate, FactorSettings, FormFactors, GivenFace, Scene};
use radgrad_solver::{Options, solve};

const MOST_FACES: usize = 6;

/// The next face: a byte for its corners (3 to 6), its reflectance and emission, one for its unit of length, three for each corner.
fn face(bytes: &mut impl Iterator<Item = u8>) -> Option<GivenFace> {
    let (kind, unit) = (bytes.next()?, bytes.next()?);
    // Mostly 1; else a power of two, for faces of very different sizes in one scene.
    let unit = if unit < 200 { 1.0 } else { 2_f64.powi((i32::from(unit) - 228) * 3) };
    let mut vertices = Vec::new();
    for _ in 0..3 + kind % 4 {
        let mut coordinate = || bytes.next().map(|byte| f64::from(byte as i8) / 16.0 * unit);
        vertices.push(DVec3::new(coordinate()?, coordinate()?, coordinate()?));
    }
    let reflectance = f64::from(kind / 4 % 4) * 0.3;
    let radiance = f64::from(kind / 16 % 2);
    Some(GivenFace { vertices, surface: "faces".to_owned(), reflectance: vec![reflectance], radiance: vec![radiance] })
}

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| -> Corpus {
    let mut bytes = bytes.iter().copied();
    let faces: Vec<GivenFace> = std::iter::from_fn(|| face(&mut bytes)).take(MOST_FACES).collect();
    let refused = Scene::from_faces(["grey"], faces.clone(), Degenerate::Refuse);
    let Ok(scene) = Scene::from_faces(["grey"], faces, Degenerate::Drop) else {
        assert!(refused.is_err());
        return Corpus::Reject;
    };
    let settings = FactorSettings { tolerance: 0.1, most_cells: 200, most_points: 50, ..FactorSettings::default() };
    match FormFactors::new(&scene).and_then(|factors| factors.matrix(&settings, || ())) {
        Err(error) => assert!(!error.to_string().contains(char::is_control), "{error}"),
        Ok(matrix) => {
            for (from, entry) in matrix.entries() {
                assert!(0.0 <= entry.lower && entry.lower <= entry.factor, "{from}: {entry:?}");
                assert!(entry.factor <= entry.upper && entry.upper.is_finite() && entry.error.is_finite(), "{from}: {entry:?}");
                assert!(entry.upper <= 1.0 + 1e-12, "{from}: {entry:?}");
            }
        }
    }
    let options = Options { error: 1.0, degree: Some(0), first_elements: 1, most_elements: 24, ..Options::default() };
    match solve(&scene, &options, |_| false) {
        Err(error) => assert!(!error.to_string().contains(char::is_control), "{error}"),
        Ok(solution) => {
            for (mean, estimate) in solution.mean().iter().zip(solution.mean_estimate()) {
                assert!(mean.is_finite() && (0.0..f64::INFINITY).contains(&estimate.total()), "{mean} {estimate:?}");
            }
        }
    }
    Corpus::Keep
});
