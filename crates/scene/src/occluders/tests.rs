//! A polygon that is not found hides nothing, and only the polygons near the beam are searched.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use radgrad_core::{Answer, DVec3, Emission, Emitter, Receiver, evaluate};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{Rng, SeedableRng};

use super::*;

fn polygon(vertices: &[[f64; 3]]) -> Polygon {
    Polygon::new(vertices.iter().copied().map(DVec3::from).collect()).unwrap()
}

/// A square of side 2 about the axis at height z, lit from below.
fn lamp(z: f64) -> Polygon {
    polygon(&[[-1.0, -1.0, z], [-1.0, 1.0, z], [1.0, 1.0, z], [1.0, -1.0, z]])
}

fn origin() -> Receiver {
    Receiver::new(DVec3::ZERO, DVec3::Z, 1.0).unwrap()
}

/// An emitter of constant radiosity 1.
fn emitter(polygon: &Polygon) -> Emitter {
    Emitter::new(polygon.clone(), Emission::Constant(1.0)).unwrap()
}

/// Whether two answers agree within their bounds. Where edges coincide the gradient has one value on either side, and the polygons
/// found may decide between them: there `values_only` are compared.
fn same(all: &Answer, found: &Answer, values_only: bool) -> bool {
    (all.radiosity - found.radiosity).abs() <= all.radiosity_error + found.radiosity_error
        && (values_only || (all.gradient - found.gradient).length() <= all.gradient_error + found.gradient_error)
}

/// Points of a lattice, where edges and planes coincide, or anywhere.
fn point(lattice: bool) -> BoxedStrategy<DVec3> {
    if lattice {
        [-2_i32..=2, -2..=2, -2..=2].prop_map(|c| DVec3::from(c.map(|c| f64::from(c) * 0.5))).boxed()
    } else {
        [-1.0..1.0, -1.0..1.0, -1.0..1.0].prop_map(DVec3::from).boxed()
    }
}

/// Triangles, and the parallelograms and notched quadrilaterals that they extend to.
fn shape(lattice: bool) -> impl Strategy<Value = Polygon> {
    let corners = [point(lattice), point(lattice), point(lattice)];
    (corners, 0..3).prop_filter_map("no polygon", |([a, b, c], kind)| {
        Polygon::new(match kind {
            0 => vec![a, b, c],
            1 => vec![a, b, c, a + c - b],
            _ => vec![a, b, c, a * 0.5 + (b + c) * 0.25],
        })
        .ok()
    })
}

fn problem() -> impl Strategy<Value = (bool, Receiver, Polygon, Vec<Polygon>)> {
    any::<bool>().prop_flat_map(|lattice| {
        let receiver = (point(lattice), point(lattice)).prop_filter_map("no direction", |(x, n)| Receiver::new(x, n, 1.0).ok());
        (Just(lattice), receiver, shape(lattice), prop::collection::vec(shape(lattice), 1..40))
    })
}

fn config(cases: u32) -> ProptestConfig {
    ProptestConfig { rng_seed: RngSeed::Fixed(1995), failure_persistence: None, ..ProptestConfig::with_cases(cases) }
}

/// The found polygons themselves.
fn pick<'a>(polygons: &'a [Polygon], found: &Found) -> Vec<&'a Polygon> {
    found.polygons.iter().map(|&i| &polygons[i]).collect()
}

proptest! {
    #![proptest_config(config(500))]

    #[test]
    fn what_is_not_found_hides_nothing((lattice, receiver, lamp, others) in problem()) {
        let emitter = emitter(&lamp);
        let all = evaluate(&receiver, &emitter, &others).unwrap();
        match Beam::from_receiver(&receiver, &lamp) {
            None => prop_assert_eq!((all.radiosity, all.radiosity_error), (0.0, 0.0)),
            Some(beam) => {
                let hiding = pick(&others, &Occluders::new(&others).in_beam(&beam, &[]));
                let some = evaluate(&receiver, &emitter, hiding.iter().copied()).unwrap();
                prop_assert!(same(&all, &some, lattice), "{} of {}: {all:?} {some:?}", hiding.len(), others.len());
            }
        }
    }

    #[test]
    fn what_the_beam_from_a_polygon_does_not_find_hides_nothing_from_its_points(
        (_, _, lamp, others) in problem(), surface in shape(true), heavier in 0_usize..3
    ) {
        let emitter = emitter(&lamp);
        let index = Occluders::new(&others);
        let whole = Beam::from_polygon(&surface, &lamp).map(|beam| index.in_beam(&beam, &[]));
        let vertices = surface.vertices();
        // A point of the plane, exactly.
        let point = (vertices[0] + vertices[1] + vertices[2] + vertices[heavier]) / 4.0;
        let receiver = Receiver::new(point, surface.normal(), 1.0).unwrap();
        let all = evaluate(&receiver, &emitter, &others).unwrap();
        let Some(whole) = &whole else {
            prop_assert_eq!(all.radiosity, 0.0);
            return Ok(());
        };
        let some = evaluate(&receiver, &emitter, pick(&others, whole)).unwrap();
        prop_assert!(same(&all, &some, true), "{all:?} {some:?}");
        let Some(beam) = Beam::from_point_of(&surface, point, &lamp) else {
            prop_assert_eq!(all.radiosity, 0.0);
            return Ok(());
        };
        let few = index.among(&beam, &whole.polygons, &[]);
        let few = evaluate(&receiver, &emitter, pick(&others, &few)).unwrap();
        prop_assert!(same(&all, &few, true), "{all:?} {few:?}");
    }

    #[test]
    fn the_tree_finds_what_a_comparison_with_every_polygon_finds((_, receiver, lamp, others) in problem()) {
        let Some(beam) = Beam::from_receiver(&receiver, &lamp) else { return Ok(()) };
        let every = others.iter().map(|polygon| beam.misses_polygon(&Shape::of(polygon)));
        let every: Vec<usize> = every.enumerate().filter(|(_, misses)| !misses).map(|(i, _)| i).collect();
        prop_assert_eq!(Occluders::new(&others).in_beam(&beam, &[]).polygons, every);
    }

    #[test]
    fn a_change_of_unit_changes_nothing((_, receiver, lamp, others) in problem(), exponent in prop::sample::select(vec![-300, -40, 200])) {
        let scaled = |p: &Polygon| Polygon::new(p.vertices().iter().map(|&v| v * 2_f64.powi(exponent)).collect()).unwrap();
        let far = Receiver::new(receiver.position() * 2_f64.powi(exponent), receiver.normal(), 1.0).unwrap();
        let found = |receiver: &Receiver, lamp: &Polygon, others: &[Polygon]| {
            Beam::from_receiver(receiver, lamp).map(|beam| Occluders::new(others).in_beam(&beam, &[]))
        };
        let others_scaled: Vec<Polygon> = others.iter().map(scaled).collect();
        let receiver = Receiver::new(receiver.position(), receiver.normal(), 1.0).unwrap();
        prop_assert_eq!(found(&receiver, &lamp, &others), found(&far, &scaled(&lamp), &others_scaled));
    }
}

#[test]
fn only_what_is_between_is_found() {
    let tilted = |x: f64, y: f64, z: f64| polygon(&[[x - 0.1, y, z - 0.1], [x + 0.1, y, z], [x, y + 0.1, z + 0.1]]);
    let scene = [
        lamp(2.0),
        tilted(0.0, 0.0, 1.0),                                           // between
        tilted(0.0, 0.0, 2.5),                                           // behind the lamp
        tilted(0.0, 0.0, -0.5),                                          // below the horizon
        tilted(1.5, 0.0, 1.0),                                           // beside
        tilted(0.9, 0.9, 1.0),                                           // beside, though in the box around the beam
        tilted(0.8, 0.7, 2.0),                                           // through the lamp
        polygon(&[[1.0, -1.0, 2.0], [1.0, 1.0, 2.0], [3.0, 0.0, 2.0]]),  // beside the lamp, in its plane
        polygon(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),   // the receiver's own
        polygon(&[[0.5, 0.0, 1.0], [0.5, 0.1, 1.0], [0.8, 0.0, 1.0]]),   // beside, with an edge seen on the lamp's
        polygon(&[[0.0, 0.0, -1.0], [1.0, 0.0, -1.0], [0.0, 0.0, 1.0]]), // seen edge-on
        polygon(&[[1.0, 1.0, 2.0], [2.0, 2.2, 1.0], [2.0, 2.1, 0.5]]),   // beside, with a corner of the lamp's
    ];
    let index = Occluders::new(&scene);
    let beam = Beam::from_receiver(&origin(), &scene[0]).unwrap();
    assert_eq!(index.in_beam(&beam, &[]).polygons, [1, 6, 9]);
    assert_eq!(index.in_beam(&beam, &[6, 1]).polygons, [9]);
    let behind = Receiver::new(DVec3::new(0.0, 0.0, 3.0), DVec3::NEG_Z, 1.0).unwrap();
    let away = Receiver::new(DVec3::ZERO, DVec3::NEG_Z, 1.0).unwrap();
    let in_plane = Receiver::new(DVec3::new(3.0, 0.0, 2.0), DVec3::NEG_X, 1.0).unwrap();
    assert!([behind, away, in_plane].iter().all(|receiver| Beam::from_receiver(receiver, &scene[0]).is_none()));
    assert!(Occluders::new(&[]).in_beam(&beam, &[]) == Found::default());
}

/// A box with every wall in `n` times `n` squares, or in pairs of triangles, seen from inside and turned so that no wall is along
/// an axis.
fn room(n: i32, triangles: bool) -> Vec<Polygon> {
    // Rational entries of a rotation: exact but for the division.
    let turn = |[x, y, z]: [f64; 3]| DVec3::new(2.0 * x - 2.0 * y + z, x + 2.0 * y + 2.0 * z, -2.0 * x - y + 2.0 * z) / 3.0;
    let cell = |axis: usize, end: i32, i: i32, j: i32| {
        let mut corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(u, v)| {
            let mut p = [0.0; 3];
            p[axis] = f64::from(end * n);
            p[(axis + 1) % 3] = f64::from(u);
            p[(axis + 2) % 3] = f64::from(v);
            turn(p)
        });
        if end == 1 {
            corners.reverse();
        }
        let [a, b, c, d] = corners;
        if triangles { vec![vec![a, b, c], vec![a, c, d]] } else { vec![corners.to_vec()] }
    };
    let walls = (0..3).flat_map(|axis| [0, 1].map(|end| (axis, end)));
    let cells = walls.flat_map(|(axis, end)| (0..n * n).flat_map(move |k| cell(axis, end, k / n, k % n)));
    cells.map(|vertices| Polygon::new(vertices).unwrap()).collect()
}

#[test]
fn in_an_empty_room_nothing_is_found() {
    for triangles in [false, true] {
        let room = room(4, triangles);
        let index = Occluders::new(&room);
        let mut searches = 0;
        for (i, receiver) in room.iter().enumerate() {
            let vertices = receiver.vertices();
            let middle = vertices.iter().sum::<DVec3>() / vertices.len() as f64;
            for (j, emitter) in room.iter().enumerate().filter(|(j, _)| *j != i) {
                let beams = [Beam::from_point_of(receiver, middle, emitter), Beam::from_polygon(receiver, emitter)];
                for beam in beams.iter().flatten() {
                    searches += 1;
                    assert_eq!(index.in_beam(beam, &[i, j]).polygons, [0; 0], "{receiver:?} {emitter:?}");
                }
            }
        }
        // All pairs but those in one wall.
        assert_eq!(searches, 2 * room.len() * room.len() * 5 / 6);
    }
}

#[test]
fn far_along_a_wall_its_faces_are_still_in_its_plane() {
    let room = room(40, true);
    let index = Occluders::new(&room);
    for (i, receiver) in room.iter().enumerate().step_by(1511) {
        let middle = receiver.vertices().iter().sum::<DVec3>() / 3.0;
        for (j, emitter) in room.iter().enumerate().step_by(17).filter(|(j, _)| *j != i) {
            let Some(beam) = Beam::from_point_of(receiver, middle, emitter) else { continue };
            assert_eq!(index.in_beam(&beam, &[i, j]).polygons, [0; 0], "{receiver:?} {emitter:?}");
        }
    }
}

#[test]
fn the_beam_from_a_polygon_is_no_wider_than_both() {
    // A wide square below, a narrow one above, and the other way round: half-way up the beam is 0.625 wide to either side.
    let square = |half: f64, z: f64| [[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]];
    let reversed = |mut vertices: [[f64; 3]; 4]| {
        vertices.reverse();
        polygon(&vertices)
    };
    let leaf = |x: f64, y: f64| polygon(&[[x, y, 1.0], [x + 0.01, y, 1.0], [x, y + 0.01, 1.01]]);
    let leaves = [leaf(0.6, 0.0), leaf(0.64, 0.0), leaf(-0.7, 0.0), leaf(0.0, 0.64), leaf(0.0, -0.66), leaf(0.5, -0.5)];
    let index = Occluders::new(&leaves);
    for (below, above) in [(1.0, 0.25), (0.25, 1.0)] {
        let (floor, lamp) = (polygon(&square(below, 0.0)), reversed(square(above, 2.0)));
        let beam = Beam::from_polygon(&floor, &lamp).unwrap();
        assert_eq!(index.in_beam(&beam, &[]).polygons, [0, 5]);
    }
}

#[test]
fn an_emitter_cut_by_the_horizon_is_hidden_from_above_it_only() {
    let wall = polygon(&[[2.0, -1.0, -1.0], [2.0, -1.0, 1.0], [2.0, 1.0, 1.0], [2.0, 1.0, -1.0]]);
    let sheet = |x: f64, z: f64| polygon(&[[x, -0.2, 0.0], [x, 0.2, 0.0], [x + 0.1, 0.0, z]]);
    let sheets = [sheet(1.0, -0.5), sheet(1.0, 0.5), sheet(-1.0, 0.5)];
    let beam = Beam::from_receiver(&origin(), &wall).unwrap();
    assert_eq!(Occluders::new(&sheets).in_beam(&beam, &[]).polygons, [1]);
}

#[test]
fn a_receiver_that_is_no_part_of_the_scene_sees_planes_exactly() {
    // A sheet an ulp over the lamp's plane hides all of it; to the surfaces of a scene it is in the plane.
    let lamp = lamp(1.0);
    let nearer = lamp.vertices().iter().map(|v| DVec3::new(v.x, v.y, 1.0_f64.next_down())).collect();
    let scene = [lamp.clone(), Polygon::new(nearer).unwrap()];
    let index = Occluders::new(&scene);
    let exact = Beam::from_receiver(&origin(), &lamp).unwrap();
    assert_eq!(index.in_beam(&exact, &[0]).polygons, [1]);
    let floor = polygon(&[[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]]);
    let surfaces = Beam::from_point_of(&floor, DVec3::ZERO, &lamp).unwrap();
    assert_eq!(index.in_beam(&surfaces, &[0]).polygons, [0; 0]);
}

#[test]
fn polygons_in_one_place_and_far_apart_are_indexed() {
    let between = polygon(&[[-0.1, 0.0, 1.0], [0.1, 0.0, 1.0], [0.0, 0.1, 1.0]]);
    let beam = Beam::from_receiver(&origin(), &lamp(2.0)).unwrap();
    let same = vec![between.clone(); 100];
    assert_eq!(Occluders::new(&same).in_beam(&beam, &[3]).polygons.len(), 99);
    let apart = |k: i32| Polygon::new(between.vertices().iter().map(|&v| v * 2_f64.powi(k)).collect()).unwrap();
    let apart: Vec<Polygon> = (-500..500).map(apart).collect();
    // Heights 2^k: those below the lamp. The one at the lamp's height is in its plane.
    assert_eq!(Occluders::new(&apart).in_beam(&beam, &[]).polygons, (0..501).collect::<Vec<_>>());
}

/// Triangles of about unit size, `count` of them in a cube of a unit of volume each.
fn crowd(count: u32) -> Vec<Polygon> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(u64::from(count));
    let mut uniform = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let side = libm::cbrt(f64::from(count));
    let mut triangle = || {
        let middle = DVec3::new(uniform(), uniform(), uniform()) * side;
        Polygon::new((0..3).map(|_| middle + DVec3::new(uniform(), uniform(), uniform()) - 0.5).collect()).unwrap()
    };
    (0..count).map(|_| triangle()).collect()
}

#[test]
fn a_search_costs_what_is_in_the_beam_and_not_what_is_in_the_scene() {
    for count in [100_u32, 1000, 10_000] {
        let crowd = crowd(count);
        let index = Occluders::new(&crowd);
        let side = libm::cbrt(f64::from(count));
        let receiver = Receiver::new(DVec3::new(0.5 * side, 0.5 * side, 0.0), DVec3::Z, 1.0).unwrap();
        // A square lamp above, up to as wide as the scene.
        for width in [0.05, 0.2, 1.0, 0.5 * side, side] {
            let lamp = lamp(1.0)
                .vertices()
                .iter()
                .map(|v| DVec3::new(v.x * width + side, v.y * width + side, 2.0 * side) * 0.5)
                .collect();
            let beam = Beam::from_receiver(&receiver, &Polygon::new(lamp).unwrap()).unwrap();
            let found = index.in_beam(&beam, &[]);
            let depth = f64::from(count).log2();
            let size = found.polygons.len() as f64;
            assert!(found.polygons_tested as f64 <= 4.0 * (size + depth), "{count} {width}: {found:?}");
            assert!(found.boxes_tested as f64 <= 8.0 * (size + 4.0 * depth), "{count} {width}: {found:?}");
        }
    }
}

/// A square of side 2 about the origin, its upper side in squares and its lower side in triangles of another size, turned and moved by `place`.
fn plate(place: impl Fn(DVec3) -> DVec3) -> Vec<Polygon> {
    let at = |count: usize, k: usize| 2.0 * k as f64 / count as f64 - 1.0;
    let corners = |count: usize, i: usize, j: usize| {
        [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| place(DVec3::new(at(count, i), at(count, j), 0.0)))
    };
    let cells = |count: usize| (0..count * count).map(move |k| (k / count, k % count));
    let above = cells(UPPER).map(|(i, j)| corners(UPPER, i, j).to_vec());
    let below = cells(LOWER).flat_map(|(i, j)| {
        let [a, b, c, d] = corners(LOWER, i, j);
        [vec![a, c, b], vec![a, d, c]]
    });
    above.chain(below).map(|vertices| Polygon::new(vertices).unwrap()).collect()
}

const UPPER: usize = 23;
const LOWER: usize = 19;

#[test]
fn a_ray_meets_the_side_of_a_plate_that_it_faces_and_from_a_side_none() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(8);
    let mut uniform = |low: f64, high: f64| low + (high - low) * (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    for _ in 0..20 {
        let turn =
            glam::DQuat::from_xyzw(uniform(-1.0, 1.0), uniform(-1.0, 1.0), uniform(-1.0, 1.0), uniform(-1.0, 1.0)).normalize();
        let shift = DVec3::new(uniform(-9.0, 9.0), uniform(-9.0, 9.0), uniform(-9.0, 9.0));
        let place = |p: DVec3| turn * p + shift;
        let plate = plate(place);
        assert!(plate.len() > 1000);
        let index = Occluders::new(&plate);
        for _ in 0..500 {
            let end = DVec3::new(uniform(-1.0, 1.0), uniform(-1.0, 1.0), 0.0);
            for side in [1.0, -1.0] {
                // As often nearly along the plate as across it.
                let height = 10.0_f64.powf(uniform(-3.0, 0.5));
                let start = DVec3::new(uniform(-2.0, 2.0), uniform(-2.0, 2.0), side * height);
                let (from, toward) = (place(start), turn * (end - start));
                let (face, point) = index.first_along(from, toward, &[]).expect("a plate without gaps");
                assert_eq!(face < UPPER * UPPER, side > 0.0, "{start} {end}");
                assert!((point - place(end)).length() < 1e-9, "{start} {end}");
                // Whoever starts on one side sees neither that nor the other.
                assert_eq!(index.first_along(point, -toward, &[face]), None, "{start} {end}");
                assert_eq!(index.first_along(place(end), -toward, &[]), None, "{start} {end}");
            }
        }
    }
}

#[test]
fn the_back_of_a_sheet_before_another_face_is_met() {
    // However little before it, unless that is rounding.
    for (gap, expected) in [(1e-3, 1), (1e-8, 1), (1e-14, 0), (0.0, 0), (-1e-14, 0), (-1e-3, 0)] {
        let back = polygon(&[[-1.0, -1.0, 1.0 - gap], [1.0, -1.0, 1.0 - gap], [1.0, 1.0, 1.0 - gap], [-1.0, 1.0, 1.0 - gap]]);
        for order in [false, true] {
            let mut faces = vec![lamp(1.0), back.clone()];
            if order {
                faces.reverse();
            }
            let first = Occluders::new(&faces).first_along(DVec3::new(0.1, 0.2, 0.0), DVec3::new(0.3, 0.2, 1.0), &[]).unwrap().0;
            assert_eq!(first, expected ^ usize::from(order), "{gap} {order}");
        }
    }
}

#[test]
fn no_ray_leaves_a_closed_surface_along_its_edges() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(5);
    let mut uniform = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    // A ball with a rough surface: rings of triangles, and of quadrilaterals in planes through an axis none.
    let (rings, around) = (24_u32, 40_u32);
    let pole = |up: f64| DVec3::new(0.0, 0.0, up);
    let corners: Vec<Vec<DVec3>> = (1..rings)
        .map(|ring| {
            let (sin, cos) = libm::sincos(std::f64::consts::PI * f64::from(ring) / f64::from(rings));
            let at = |k: u32| libm::sincos(std::f64::consts::TAU * f64::from(k) / f64::from(around));
            (0..around).map(|k| DVec3::new(sin * at(k).1, sin * at(k).0, cos) * (0.8 + 0.2 * uniform())).collect()
        })
        .collect();
    let next = |k: usize| (k + 1) % around as usize;
    let mut triangles = Vec::new();
    for k in 0..around as usize {
        triangles.push([pole(1.0), corners[0][k], corners[0][next(k)]]);
        triangles.push([pole(-1.0), corners[corners.len() - 1][next(k)], corners[corners.len() - 1][k]]);
        for two in corners.windows(2) {
            triangles.push([two[0][k], two[1][k], two[1][next(k)]]);
            triangles.push([two[0][k], two[1][next(k)], two[0][next(k)]]);
        }
    }
    for unit in [1.0, 2.0_f64.powi(-300), 2.0_f64.powi(300)] {
        let faces: Vec<Polygon> =
            triangles.iter().map(|corners| Polygon::new(corners.map(|v| v * unit).to_vec()).unwrap()).collect();
        let index = Occluders::new(&faces);
        for [a, b, c] in &triangles {
            let from = DVec3::new(uniform() - 0.5, uniform() - 0.5, uniform() - 0.5) * 0.3;
            for (a, b) in [(a, b), (b, c), (c, a)] {
                for share in [0.0, uniform(), uniform()] {
                    let toward = *a + (*b - *a) * share - from;
                    assert!(index.first_along(from * unit, toward, &[]).is_some(), "{from} {toward}");
                }
            }
        }
    }
}
