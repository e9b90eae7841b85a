//! Factors and fields do not depend on where a scene lies and on its unit, and faces that overlap have none.

use radgrad_core::{DVec3, Polygon, Receiver};
use radgrad_scene::{Error, FactorSettings, FormFactors, Scene};

/// Opposite unit squares, and a small one between them that hides a part.
fn scene(to: impl Fn(f64) -> f64) -> Scene {
    let mut scene = Scene::new(["grey"]).unwrap();
    let white = scene.add_material("white", [0.5], [1.0]).unwrap();
    let square = |low: f64, high: f64, z: f64| [[low, low, z], [high, low, z], [high, high, z], [low, high, z]];
    let mut down = square(0.0, 1.0, 1.0);
    down.reverse();
    for (name, corners) in [("floor", square(0.0, 1.0, 0.0)), ("ceiling", down), ("screen", square(0.25, 0.5, 0.5))] {
        let surface = scene.add_surface(name);
        let polygon = Polygon::new(corners.map(|v| DVec3::from(v.map(&to))).to_vec()).unwrap();
        scene.add_face(surface, white, polygon, None).unwrap();
    }
    scene
}

#[test]
fn factors_and_fields_of_a_scene_far_away_are_those_at_the_origin_within_their_bounds() {
    let (here, settings) = (scene(|x| x), FactorSettings::default());
    let at_origin = FormFactors::new(&here).unwrap();
    let (matrix, field) = (at_origin.matrix(&settings, || ()).unwrap(), at_origin.field(0, 4, &[(1, 1.0)], 1e-9, || ()).unwrap());
    for shift in [1e9, 1e10, 1e14, 1e15] {
        let there = scene(|x| x + shift);
        let factors = FormFactors::new(&there).unwrap();
        let moved_matrix = factors.matrix(&settings, || ()).unwrap();
        assert_eq!(moved_matrix.entries().count(), matrix.entries().count());
        for ((_, a), (_, b)) in matrix.entries().zip(moved_matrix.entries()) {
            assert!(a.face == b.face && (a.factor - b.factor).abs() <= a.error + b.error, "{shift:e}: {a:?} {b:?}");
        }
        let cells = factors.field(0, 4, &[(1, 1.0)], 1e-9, || ()).unwrap();
        for (a, b) in field.iter().zip(&cells) {
            assert!((a.value - b.value).abs() <= a.value_error + b.value_error && b.value > 0.1, "{shift:e}: {a:?} {b:?}");
            assert!((a.gradient - b.gradient).length() <= a.gradient_error + b.gradient_error, "{shift:e}: {a:?} {b:?}");
            assert_eq!(b.centre, a.centre + shift);
        }
    }
}

#[test]
fn a_field_far_away_is_that_at_the_centres_that_it_states() {
    // Sixths of a side are no multiples of 2^-12, the spacing of doubles there.
    let (here, shift) = (scene(|x| x), 2f64.powi(40));
    let (there, known) = (scene(|x| x + shift), FormFactors::new(&here).unwrap());
    let mut moved = 0;
    for cell in FormFactors::new(&there).unwrap().field(0, 3, &[(1, 1.0)], 1e-12, || ()).unwrap() {
        let receiver = Receiver::new(cell.centre - shift, DVec3::Z, 1.0).unwrap();
        let expected = known.at_point(&receiver, Some(0), 1, 1e-12).unwrap();
        assert!((cell.value - expected.radiosity).abs() <= cell.value_error + expected.radiosity_error, "{cell:?} {expected:?}");
        moved += usize::from((cell.centre.x - shift) * 6.0 % 1.0 != 0.0);
    }
    assert!(moved > 0);
}

#[test]
fn a_unit_that_is_another_power_of_two_changes_no_digit_of_factors() {
    let (here, settings) = (scene(|x| x), FactorSettings::default());
    let in_metres = FormFactors::new(&here).unwrap();
    let (matrix, field) = (in_metres.matrix(&settings, || ()).unwrap(), in_metres.field(0, 3, &[(1, 1.0)], 1e-9, || ()).unwrap());
    let answer = |factors: &FormFactors<'_>, unit: f64| {
        let receiver = Receiver::new(DVec3::new(0.3, 0.4, 0.0) * unit, DVec3::Z, 1.0).unwrap();
        factors.at_point(&receiver, Some(0), 1, 1e-12).unwrap()
    };
    for exponent in [-700, -520, -400, 300, 400, 520, 700] {
        let unit = 2f64.powi(exponent);
        let there = scene(|x| x * unit);
        let factors = FormFactors::new(&there).unwrap();
        let scaled = factors.matrix(&settings, || ()).unwrap();
        assert!(scaled.entries().eq(matrix.entries()), "2^{exponent}");
        assert_eq!(scaled.by_surface(&there).rows, matrix.by_surface(&here).rows);
        assert_eq!(answer(&factors, unit), answer(&in_metres, 1.0));
        for (a, b) in field.iter().zip(factors.field(0, 3, &[(1, 1.0)], 1e-9, || ()).unwrap()) {
            assert_eq!(
                (a.value, a.value_error, a.gradient, a.centre),
                (b.value, b.value_error, b.gradient * unit, b.centre / unit)
            );
        }
    }
}

#[test]
fn faces_that_overlap_have_no_factors() {
    let mut twice = scene(|x| x);
    let again = twice.add_surface("again");
    let floor = twice.faces()[0].polygon().clone();
    twice.add_face(again, 0, floor, None).unwrap();
    let error = FormFactors::new(&twice).unwrap_err();
    assert!(
        matches!(&error, Error::Overlap { pairs, .. } if pairs[0].faces == ["face 0 of `floor`", "face 3 of `again`"]),
        "{error}"
    );
}

#[test]
fn the_back_of_a_plate_gives_its_front_nothing() {
    let (along, up) = (DVec3::new(0.6, 0.3, 0.1), DVec3::new(-0.2, 0.5, 0.4));
    let corner = DVec3::new(0.8, 0.5, 0.4);
    let side = |along: DVec3, up: DVec3| Polygon::new(vec![corner, corner + along, corner + along + up, corner + up]).unwrap();
    let mut scene = Scene::new(["grey"]).unwrap();
    let (white, plate) = (scene.add_material("white", [0.5], [0.0]).unwrap(), scene.add_surface("plate"));
    for polygon in [side(along, up), side(up, along)] {
        scene.add_face(plate, white, polygon, None).unwrap();
    }
    let factors = FormFactors::new(&scene).unwrap();
    for k in 0..200 {
        let [s, t] = [f64::from(k % 20) / 20.0, f64::from(k / 20) / 10.0];
        let point = corner + along * s + up * t;
        for face in [0, 1] {
            let receiver = Receiver::new(point, scene.faces()[face].polygon().normal(), 1.0).unwrap();
            assert_eq!(factors.at_point(&receiver, Some(face), 1 - face, 1e-9).unwrap().radiosity, 0.0, "{s} {t}");
        }
    }
}
