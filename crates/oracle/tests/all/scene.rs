//! Scenes: walks against exact solutions, and each kind of walk against the others.

use radgrad_core::{DVec3, Polygon};
use radgrad_oracle::scene::known::{FacingRectangles, furnace_emission};
use radgrad_oracle::scene::{Effort, Face, Kind, Known, Pattern, Point, Scene, Truth};

fn face(corners: &[[f64; 3]], reflectance: f64, emitted: f64) -> Face {
    let polygon = Polygon::new(corners.iter().map(|&v| v.into()).collect()).unwrap();
    Face { polygon, reflectance, emitted, exchanges: true, pattern: None }
}

/// The faces of a box, seen from inside or from outside.
fn cuboid([x, y, z]: [[f64; 2]; 3], inside: bool) -> Vec<Vec<[f64; 3]>> {
    let corner = |i: usize| [x[i & 1], y[i >> 1 & 1], z[i >> 2 & 1]];
    let quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let turned = |mut quad: [usize; 4]| {
        if !inside {
            quad.reverse();
        }
        quad.map(corner).to_vec()
    };
    quads.into_iter().map(turned).collect()
}

/// A room with a block in it and a lamp under the ceiling.
fn room(rho: f64) -> Vec<Face> {
    let room = cuboid([[0.0, 3.0], [0.0, 2.0], [0.0, 2.0]], true);
    let block = cuboid([[1.2, 1.8], [0.5, 1.0], [0.25, 1.1]], false);
    let mut faces: Vec<Face> = room.iter().map(|corners| face(corners, rho, 0.0)).collect();
    faces.extend(block.iter().map(|corners| face(corners, 0.3, 0.0)));
    let lamp = [[0.5, 0.5, 1.9], [0.5, 1.0, 1.9], [1.5, 1.0, 1.9], [1.5, 0.5, 1.9]];
    faces.push(face(&lamp, 0.0, 10.0));
    faces.push(face(&[lamp[3], lamp[2], lamp[1], lamp[0]], 0.5, 0.0));
    faces
}

fn overlap(a: &Known, b: &Known) -> bool {
    a.interval.low <= b.interval.high && b.interval.low <= a.interval.high
}

const KINDS: [Kind; 3] = [Kind::Particles, Kind::NextEvent, Kind::Plain];

#[test]
fn a_furnace_full_of_blocks_is_1_by_every_kind_of_walk() {
    let mut corners = cuboid([[0.0, 2.0], [0.0, 1.5], [0.0, 1.0]], true);
    corners.extend(cuboid([[0.3, 0.6], [0.2, 0.9], [0.1, 0.8]], false));
    corners.extend(cuboid([[1.3, 1.7], [0.7, 0.9], [0.4, 0.5]], false));
    for largest in [0.5, 0.98] {
        let rho = |i: usize| largest * [1.0, 0.3, 0.7, 0.9][i % 4];
        let faces: Vec<Face> = corners.iter().enumerate().map(|(i, c)| face(c, rho(i), furnace_emission(rho(i)))).collect();
        let scene = Scene::new(faces).unwrap();
        let points = [(0, [1.0, 0.7, 0.0]), (0, [0.001, 0.001, 0.0]), (1, [0.5, 0.5, 1.0])];
        let points = points.map(|(face, position)| Point { face, position: position.into() });
        for kind in KINDS {
            let effort = Effort { digits: 0, ..Effort::default() };
            let truth = scene.truth_of_kind(&points, &effort, kind).unwrap();
            let mean = truth.emitted + truth.reflected.value;
            let half = 0.5 * truth.reflected.interval.width();
            assert!((mean - 1.0).abs() < half && (mean - 1.0).abs() < 0.05, "{largest} {kind:?}: {truth:?}");
            for point in &truth.points {
                assert!(point.interval.contains(1.0), "{largest} {kind:?}: {point:?}");
            }
        }
    }
}

#[test]
fn kinds_of_walks_agree_with_each_other() {
    let scene = Scene::new(room(0.8)).unwrap();
    // The second is under the block.
    let points = [(0, [2.4, 1.1, 0.0]), (0, [1.5, 0.75, 0.0]), (4, [0.0, 0.2, 1.7]), (7, [1.3, 0.6, 1.1])];
    let points = points.map(|(face, position)| Point { face, position: position.into() });
    let truths: Vec<Truth> = KINDS
        .iter()
        .enumerate()
        .map(|(seed, &kind)| {
            let digits = if kind == Kind::Plain { 15 } else { 0 };
            let effort = Effort { digits, seed: seed as u64, ..Effort::default() };
            scene.truth_of_kind(&points, &effort, kind).unwrap()
        })
        .collect();
    for (i, a) in truths.iter().enumerate() {
        for b in &truths[..i] {
            assert!(overlap(&a.reflected, &b.reflected), "{:?} {:?}", a.reflected, b.reflected);
            assert!((a.reflected.value - b.reflected.value).abs() < 0.03 * b.reflected.value, "{a:?} {b:?}");
            for (p, q) in a.points.iter().zip(&b.points) {
                assert!(overlap(p, q), "{p:?} {q:?}");
            }
        }
    }
    // The same by another seed, and not when a lamp is a fifth brighter.
    let other = |emitted: f64| {
        let mut faces = room(0.8);
        faces[12].emitted = emitted;
        let effort = Effort { seed: 9, ..Effort::default() };
        Scene::new(faces).unwrap().truth(&points, &effort).unwrap()
    };
    let first = scene.truth(&points, &Effort::default()).unwrap();
    assert!(overlap(&first.reflected, &other(10.0).reflected));
    assert!(!overlap(&first.reflected, &other(12.0).reflected));
    assert!(first.reflected.interval.width() < 0.1 * first.reflected.value, "{:?}", first.reflected);
    for (p, q) in first.points.iter().zip(&other(10.0).points) {
        assert!(overlap(p, q), "{p:?} {q:?}");
    }
    assert!(first.points[0].interval.width() < 0.2 * first.points[0].value, "{:?}", first.points);
}

#[test]
fn walks_between_two_squares_find_the_known_radiosity() {
    let squares = FacingRectangles {
        low: [[0.0; 2], [0.25, 0.5]],
        high: [[1.0; 2], [1.0, 2.0]],
        gap: 0.5,
        reflectance: [0.9, 0.6],
        emitted: [0.0, 1.0],
    };
    let faces: Vec<Face> = squares
        .polygons()
        .unwrap()
        .into_iter()
        .zip([0, 1])
        .map(|(polygon, i)| Face {
            polygon,
            reflectance: squares.reflectance[i],
            emitted: squares.emitted[i],
            exchanges: true,
            pattern: None,
        })
        .collect();
    let scene = Scene::new(faces).unwrap();
    let places = [(0, [0.5, 0.5]), (0, [0.01, 0.02]), (1, [0.3, 1.9])];
    let (mean, values) = squares.truth(&places);
    let points = places.map(|(face, [x, y])| Point { face, position: DVec3::new(x, y, squares.gap * face as f64) });
    for kind in KINDS {
        let truth = scene.truth_of_kind(&points, &Effort::default(), kind).unwrap();
        assert!(overlap(&truth.reflected, &mean), "{kind:?} {truth:?} {mean:?}");
        assert!((truth.reflected.value - mean.value).abs() < 0.02 * mean.value, "{kind:?} {truth:?}");
        for (walked, exact) in truth.points.iter().zip(&values) {
            assert!(overlap(walked, exact), "{kind:?} {walked:?} {exact:?}");
        }
    }
}

#[test]
fn walks_find_a_manufactured_radiosity() {
    let squares =
        FacingRectangles { low: [[0.0; 2]; 2], high: [[1.0; 2]; 2], gap: 1.0, reflectance: [0.7, 0.4], emitted: [0.0; 2] };
    let radiosity = |which: usize, [x, y]: [f64; 2]| if which == 0 { 2.0 + x * y - x * x } else { 1.5 + y };
    let faces: Vec<Face> = squares
        .polygons()
        .unwrap()
        .into_iter()
        .zip([0, 1])
        .map(|(polygon, which)| {
            let rho = squares.reflectance[which];
            let emitted = move |at: DVec3| [rho, squares.manufactured(which, [at.x, at.y], radiosity)];
            Face { polygon, reflectance: rho, emitted: 3.0, exchanges: true, pattern: Some(Pattern::new(emitted)) }
        })
        .collect();
    let scene = Scene::new(faces).unwrap();
    let places = [(0, [0.5, 0.5]), (0, [0.0, 0.9]), (1, [0.3, 0.8])];
    let points = places.map(|(face, [x, y])| Point { face, position: DVec3::new(x, y, face as f64) });
    for kind in KINDS {
        let effort = Effort { rays: 20_000, rays_a_point: 20_000, ..Effort::default() };
        let truth = scene.truth_of_kind(&points, &effort, kind).unwrap();
        for (point, (which, place)) in truth.points.iter().zip(places) {
            let exact = radiosity(which, place);
            assert!(point.interval.contains(exact), "{kind:?} {point:?} {exact}");
            assert!(point.interval.width() < 0.4, "{kind:?} {point:?}");
        }
    }
}

#[test]
fn a_lamp_that_almost_touches_the_floor_is_no_trouble_to_particles() {
    for gap in [1e-3, 1e-6] {
        let mut faces: Vec<Face> =
            cuboid([[0.0, 1.0], [0.0, 1.0], [0.0, 1.0]], true).iter().map(|corners| face(corners, 0.5, 0.0)).collect();
        let side = 1e-3;
        let [low, high] = [0.4, 0.4 + side];
        let lamp = [[low, low, gap], [low, high, gap], [high, high, gap], [high, low, gap]];
        faces.push(face(&lamp, 0.0, 1.0 / (side * side)));
        let scene = Scene::new(faces).unwrap();
        let points = [Point { face: 1, position: DVec3::new(0.3, 0.6, 1.0) }];
        let truth = scene.truth(&points, &Effort::default()).unwrap();
        assert!(truth.reflected.interval.width() < 0.1 * truth.reflected.value, "{truth:?}");
        assert!(truth.points[0].interval.width() < 0.1 * truth.reflected.value, "{truth:?}");
    }
}

#[test]
fn what_cannot_be_a_scene_is_refused() {
    let mirror = |rho| vec![face(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], rho, 0.0)];
    assert!(Scene::new(mirror(1.5)).is_err() && Scene::new(mirror(f64::NAN)).is_err());
    let two = [mirror(1.0), mirror(1.0)].concat();
    assert!(Scene::new(two).unwrap_err().to_string().contains("must be below 1"));
    let scene = Scene::new(mirror(0.5)).unwrap();
    assert!(scene.truth(&[Point { face: 3, position: DVec3::ZERO }], &Effort::default()).is_err());
    assert!(scene.truth(&[], &Effort { confidence: 1.0, ..Effort::default() }).is_err());
}

#[test]
fn what_a_face_sees_is_the_published_factor() {
    let squares =
        FacingRectangles { low: [[0.0; 2]; 2], high: [[1.0; 2]; 2], gap: 1.0, reflectance: [0.0; 2], emitted: [0.0; 2] };
    let faces = squares.polygons().unwrap().map(|polygon| Face {
        polygon,
        reflectance: 0.0,
        emitted: 0.0,
        exchanges: true,
        pattern: None,
    });
    let scene = Scene::new(faces.to_vec()).unwrap();
    let factors = scene.sights(0, 100_000, 1, 0.999_999).unwrap();
    assert!(factors[1].interval.contains(0.199_824_895_698_387) && factors[1].interval.width() < 0.02, "{factors:?}");
    assert_eq!(factors[0].value, 0.0);
}
