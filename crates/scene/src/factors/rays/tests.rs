use radgrad_core::DVec3;

use super::*;
use crate::scene::Scene;
use crate::{BlockOperator, Certified, FactorOperator, RayRow};

/// A closed room of tiles, or one without a part of its ceiling, with a thin plate in the middle.
fn room(side: u8, is_closed: bool) -> Scene {
    let mut scene = Scene::new(["grey"]).unwrap();
    let material = scene.add_material("white", [0.5], [0.0]).unwrap();
    let surface = scene.add_surface("all");
    let mut add = |corners: [DVec3; 4]| {
        scene.add_face(surface, material, Polygon::new(corners.to_vec()).unwrap(), None).unwrap();
    };
    let at = |k: u8| f64::from(k) / f64::from(side);
    for (i, j) in (0..side).flat_map(|i| (0..side).map(move |j| (i, j))) {
        let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
        for axis in 0..3 {
            for is_high in [false, true] {
                if axis == 0 && is_high && i == 0 && !is_closed {
                    continue;
                }
                // Seen from inside; turned so that the first axis is each of the three.
                let mut outline = corners.map(|(u, v)| {
                    let [x, y, z] = [at(u), at(v), f64::from(u8::from(is_high))];
                    match axis {
                        0 => DVec3::new(x, y, z),
                        1 => DVec3::new(z, x, y),
                        _ => DVec3::new(y, z, x),
                    }
                });
                if is_high {
                    outline.reverse();
                }
                add(outline);
            }
        }
    }
    let mut plate = [(0.3, 0.2), (0.8, 0.2), (0.8, 0.7), (0.3, 0.7)].map(|(x, y)| DVec3::new(x, y, 0.4));
    add(plate);
    plate.reverse();
    add(plate);
    scene
}

fn of(factors: &FormFactors<'_>, rays: u32, seed: u64) -> RayFactors {
    let settings = RaySettings { rays: Some(rays), seed, ..RaySettings::default() };
    factors.by_rays(factors.count_rays(0..factors.faces().len(), &settings, |_| ()).unwrap(), &settings).unwrap()
}

fn all(factors: &RayFactors) -> Vec<RayRow> {
    factors.rows(0..factors.faces().len())
}

#[test]
fn intervals_miss_the_truth_no_more_often_than_stated() {
    let scene = room(3, false);
    let factors = FormFactors::new(&scene).unwrap();
    let truth = factors.matrix(&FactorSettings { tolerance: 1e-2, estimate: 1e-6, ..FactorSettings::default() }, || ()).unwrap();
    let count = scene.faces().len();
    // As if each interval may fail with this probability: they do, but not more often.
    let delta = 0.1;
    let (mut intervals, mut misses, mut open_misses, mut widest) = (0, 0, 0, 0.0);
    for seed in 1..=8 {
        let mut estimates = of(&factors, 2000, seed);
        estimates.known.logarithm = libm::log(2.0 / delta);
        let absent = estimates.absent();
        for RayRow { face, entries, open } in all(&estimates) {
            let mut is_there = vec![false; count];
            for entry in &entries {
                is_there[entry.face] = true;
                let expected = truth.factor(face, entry.face);
                let slack = 2e-6;
                let is_missed = expected < entry.lower - slack || expected > entry.upper + slack;
                assert!(!(is_missed && entry.is_exact), "{face} {entry:?} {expected}");
                if !entry.is_exact {
                    (intervals, misses) = (intervals + 1, misses + usize::from(is_missed));
                    widest = larger(widest, 0.5 * (entry.upper - entry.lower));
                }
            }
            let is_absent = |other: usize| !is_there[other] && truth.areas()[face] <= truth.areas()[other];
            for other in (0..count).filter(|&other| is_absent(other)) {
                (intervals, misses) = (intervals + 1, misses + usize::from(truth.factor(face, other) > absent));
            }
            let expected = 1.0 - truth.sum(face).factor;
            open_misses += usize::from(expected < open.lower - 1e-5 || expected > open.upper + 1e-5);
        }
    }
    assert!(intervals > 5000 && misses > 0 && misses as f64 <= delta * intervals as f64, "{misses} of {intervals}");
    assert!(open_misses as f64 <= delta * 8.0 * count as f64, "{open_misses}");
    // They say something: less than Hoeffding's.
    assert!(widest <= (libm::log(2.0 / delta) / 4000.0).sqrt(), "{widest}");
}

#[test]
fn rows_close_and_pairs_are_reciprocal_also_where_small_factors_are_left_out() {
    for is_closed in [true, false] {
        let scene = room(4, is_closed);
        let factors = FormFactors::new(&scene).unwrap();
        let areas: Vec<f64> = scene.polygons().map(Polygon::area).collect();
        let whole = of(&factors, 1000, 1);
        let fewer = whole.clone().without_below(5e-3);
        assert!(fewer.stored() < whole.stored() && fewer.absent() >= 5e-3);
        for found in [&whole, &fewer] {
            let dense = all(found);
            let at = |i: usize, j: usize| dense[i].entries.iter().find(|entry| entry.face == j).map_or(0.0, |entry| entry.factor);
            assert_eq!(dense.iter().map(|row| row.entries.len()).sum::<usize>(), found.stored());
            let mut most_open = 0.0;
            for RayRow { face, entries, open } in &dense {
                let sum: f64 = entries.iter().map(|entry| entry.factor).sum();
                assert!(open.factor >= 0.0 && (sum + open.factor - 1.0).abs() < 1e-14, "{face}: {sum}");
                assert!((found.open(*face) - open.factor).abs() < 1e-12);
                most_open = larger(most_open, open.factor);
                for entry in entries {
                    let [here, there] = [areas[*face] * entry.factor, areas[entry.face] * at(entry.face, *face)];
                    assert!((here - there).abs() <= 1e-14 * here, "{face} {entry:?}");
                    assert!(entry.lower <= entry.factor && entry.factor <= entry.upper);
                }
            }
            assert_eq!(most_open < 1e-7, is_closed, "{most_open}");
        }
    }
}

#[test]
fn a_face_that_only_near_faces_are_before_closes_too() {
    // A cube of six faces: all are near each other. And blocks in a room, one face of which sees little else.
    let read = Scene::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj"), crate::Degenerate::Refuse);
    for scene in [room(1, true), read.unwrap()] {
        let factors = FormFactors::new(&scene).unwrap();
        let estimates = of(&factors, 1000, 1);
        assert!(factors.faces().into_iter().all(|face| (0.0..1e-6).contains(&estimates.open(face))));
        assert!(FactorOperator::new(estimates).error() < 1.0);
    }
}

#[test]
fn values_are_nearer_the_truth_with_more_rays_and_near_pairs_are_exact() {
    let scene = room(3, true);
    let factors = FormFactors::new(&scene).unwrap();
    let settings = FactorSettings { tolerance: 1e-2, estimate: 1e-6, ..FactorSettings::default() };
    let truth = factors.matrix(&settings, || ()).unwrap();
    let error = |rays: u32| {
        let (mut sum, mut exact) = (0.0, 0);
        for RayRow { face, entries, .. } in all(&of(&factors, rays, 3)) {
            for entry in entries {
                let deviation = (entry.factor - truth.factor(face, entry.face)).abs();
                sum += deviation * deviation;
                exact += usize::from(entry.is_exact);
                assert!(!entry.is_exact || deviation < 1e-6, "{face} {entry:?}");
            }
        }
        assert!(exact > 100, "{exact}");
        sum.sqrt()
    };
    let [few, many] = [error(400), error(40_000)];
    // A hundredfold is a tenth by chance alone.
    assert!(many < 0.12 * few, "{few} {many}");
}

#[test]
fn answers_depend_on_no_division_of_the_work() {
    let scene = room(3, false);
    let factors = FormFactors::new(&scene).unwrap();
    let settings = RaySettings { rays: Some(300), ..RaySettings::default() };
    let rows = factors.faces().len();
    let whole = of(&factors, 300, 1);
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let parts = pool.install(|| {
            let mut parts = factors.count_rays(rows / 3..rows, &settings, |_| ()).unwrap();
            parts.extend(factors.count_rays(0..rows / 3, &settings, |_| ()).unwrap());
            let estimates = factors.by_rays(parts, &settings).unwrap();
            let q: Vec<f64> = (0..scene.faces().len()).map(|face| (face as f64).sin()).collect();
            (FactorOperator::new(estimates.clone()).apply(&q).unwrap(), estimates)
        });
        assert_eq!(parts.1, whole);
        let q: Vec<f64> = (0..scene.faces().len()).map(|face| (face as f64).sin()).collect();
        assert_eq!(parts.0, FactorOperator::new(whole.clone()).apply(&q).unwrap());
        // And not on how many rows are asked for at once.
        let one_by_one: Vec<RayRow> = (0..rows).flat_map(|row| whole.rows(row..row + 1)).collect();
        assert_eq!(one_by_one, all(&whole));
    }
    assert_ne!(of(&factors, 300, 2), whole);
}

#[test]
fn a_product_is_that_of_the_rows_and_its_error_holds() {
    for is_closed in [true, false] {
        let scene = room(3, is_closed);
        let factors = FormFactors::new(&scene).unwrap();
        let truth =
            factors.matrix(&FactorSettings { tolerance: 1e-2, estimate: 1e-6, ..FactorSettings::default() }, || ()).unwrap();
        let q: Vec<f64> = scene.polygons().map(|polygon| polygon.vertices()[0].x - 0.3).collect();
        let rays = 4000;
        for seed in 1..4 {
            let operator = FactorOperator::new(of(&factors, rays, seed));
            let Certified { product, error } = operator.certified(&q).unwrap();
            for RayRow { face, entries, .. } in all(operator.factors()) {
                let by_row: f64 = entries.iter().map(|entry| entry.factor * q[entry.face]).sum();
                let expected: f64 = truth.row(face).map(|entry| entry.factor * q[entry.face]).sum();
                assert!((product[face] - by_row).abs() < 1e-13, "{face}");
                assert!((product[face] - expected).abs() <= error[face], "{face}: {} {expected} {}", product[face], error[face]);
                assert!((product[face] - expected).abs() < 0.03, "{face}: {} {expected}", product[face]);
                assert!(error[face] <= operator.error() && operator.error() < 1.0, "{} {}", error[face], operator.error());
            }
        }
        assert!(FactorOperator::new(of(&factors, 10, 1)).apply(&q[1..]).is_err());
        assert!(FactorOperator::new(of(&factors, 10, 1)).apply(&vec![f64::NAN; q.len()]).is_err());
    }
}

#[test]
fn what_no_rays_can_have_met_and_what_cannot_be_asked_for_is_refused() {
    let scene = room(2, true);
    let factors = FormFactors::new(&scene).unwrap();
    let settings = RaySettings { rays: Some(100), ..RaySettings::default() };
    let counted = factors.count_rays(0..factors.faces().len(), &settings, |_| ()).unwrap();
    let spoils: [fn(&mut Vec<Counted>); 7] = [
        |rows| rows[0].met[0].1 = 1000,
        |rows| rows[0].met[0].1 = 0,
        |rows| rows[1].met.swap(0, 1),
        |rows| rows[1].met[0].0 = 1_000_000,
        |rows| rows[0].met.insert(0, (0, 1)),
        |rows| rows.truncate(3),
        |rows| rows[4] = rows[3].clone(),
    ];
    assert!(factors.by_rays(counted.clone(), &settings).is_ok());
    for (index, spoil) in spoils.iter().enumerate() {
        let mut rows = counted.clone();
        spoil(&mut rows);
        assert!(factors.by_rays(rows, &settings).is_err(), "{index}");
    }
    let usual = RaySettings::default();
    for tolerance in [0.0, 1.0, f64::NAN, 1e-6] {
        assert!(RaySettings { tolerance, ..usual }.rays_for(10).is_err(), "{tolerance}");
    }
    for confidence in [0.0, 1.0, f64::NAN] {
        assert!(RaySettings { confidence, ..usual }.rays_for(10).is_err(), "{confidence}");
    }
    assert!(RaySettings { rays: Some(0), ..usual }.rays_for(10).is_err());
    assert!(factors.count_rays(0..1000, &settings, |_| ()).is_err());
}

#[test]
fn factors_are_kept_to_the_last_bit_and_damaged_bytes_are_refused() {
    let scene = room(3, false);
    let estimates = of(&FormFactors::new(&scene).unwrap(), 3000, 1).without_below(1e-3);
    let bytes = estimates.to_bytes();
    assert_eq!(RayFactors::from_bytes(&bytes).unwrap(), estimates);
    assert!(bytes.len() < 12 * estimates.stored(), "{}", bytes.len());
    for end in (0..bytes.len()).step_by(97) {
        assert!(RayFactors::from_bytes(&bytes[..end]).is_err(), "{end}");
    }
    // Changed bytes are refused, or are other factors whose rows can be asked for.
    for at in (0..bytes.len()).step_by(23) {
        let mut changed = bytes.clone();
        changed[at] ^= 0x80;
        if let Ok(factors) = RayFactors::from_bytes(&changed) {
            assert_eq!(factors.rows(0..usize::MAX), [], "{at}");
            assert_eq!(factors.rows(0..factors.faces().len()).len(), factors.faces().len(), "{at}");
        }
    }
}

/// The product of factors with numbers of faces, in blocks as well.
fn in_blocks(factors: &FormFactors<'_>, rays: u32, tolerance: f64) -> (FactorOperator, BlockOperator) {
    let operator = FactorOperator::new(of(factors, rays, 1));
    let blocks = operator.blocks(&factors.middles(), tolerance).unwrap();
    (operator, blocks)
}

#[test]
fn far_blocks_keep_the_sums_of_rows_and_reciprocity_and_take_few_bytes() {
    let scene = room(8, false);
    let factors = FormFactors::new(&scene).unwrap();
    let (operator, blocks) = in_blocks(&factors, 4000, 0.02);
    let count = scene.faces().len();
    assert!(5 * blocks.bytes() < 12 * operator.factors().stored(), "{} {}", blocks.bytes(), operator.factors().stored());
    let ones = vec![1.0; count];
    for (all, few) in operator.apply(&ones).unwrap().into_iter().zip(blocks.apply(&ones).unwrap()) {
        assert!((all - few).abs() < 1e-6, "{all} {few}");
    }
    let areas: Vec<f64> = scene.polygons().map(Polygon::area).collect();
    let column = |face: usize| blocks.apply(&(0..count).map(|k| f64::from(u8::from(k == face))).collect::<Vec<_>>()).unwrap();
    for (i, j) in [(0, 1), (3, 200), (17, 300), (count - 1, 5)] {
        let [from_i, from_j] = [column(j)[i] * areas[i], column(i)[j] * areas[j]];
        assert!(from_i >= 0.0 && (from_i - from_j).abs() <= 1e-14 * from_i, "{i} {j}: {from_i} {from_j}");
    }
}

#[test]
fn a_product_in_blocks_errs_by_no_more_than_it_says() {
    let scene = room(4, false);
    let factors = FormFactors::new(&scene).unwrap();
    let truth = factors.matrix(&FactorSettings { tolerance: 1e-2, estimate: 1e-6, ..FactorSettings::default() }, || ()).unwrap();
    let smooth = |polygon: &Polygon| polygon.vertices()[0].x - 0.3;
    let steep = |polygon: &Polygon| f64::from(u8::from(polygon.vertices()[0].y > 0.4));
    for q in [scene.polygons().map(smooth).collect::<Vec<_>>(), scene.polygons().map(steep).collect()] {
        let errors = [0.01, 0.9].map(|tolerance| {
            let (operator, blocks) = in_blocks(&factors, 4000, tolerance);
            let (Certified { product, error }, undivided) = (blocks.certified(&q).unwrap(), operator.apply(&q).unwrap());
            let mut largest = 0.0;
            for (face, (product, error)) in product.into_iter().zip(error).enumerate() {
                let expected: f64 = truth.row(face).map(|entry| entry.factor * q[entry.face]).sum();
                assert!((product - expected).abs() <= error, "{face}: {product} {expected} {error}");
                largest = larger(largest, (product - undivided[face]).abs());
            }
            largest
        });
        // The tolerance that is asked for shows.
        assert!(errors[0] < 0.02 && errors[1] > errors[0], "{errors:?}");
    }
}

#[test]
fn columns_at_once_are_those_one_after_the_other_on_any_number_of_threads() {
    let scene = room(4, true);
    let factors = FormFactors::new(&scene).unwrap();
    let (operator, blocks) = in_blocks(&factors, 2000, 0.05);
    let count = scene.faces().len();
    for columns in [0, 2, 11] {
        let q: Vec<f64> = (0..count * columns).map(|k| (k as f64).sin()).collect();
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let answers = pool.install(|| [operator.apply_many(&q, columns).unwrap(), blocks.apply_many(&q, columns).unwrap()]);
            for column in 0..columns {
                let of = |all: &[f64]| (0..count).map(|face| all[face * columns + column]).collect::<Vec<f64>>();
                assert_eq!(of(&answers[0]), operator.apply(&of(&q)).unwrap(), "{columns} {column}");
                assert_eq!(of(&answers[1]), blocks.apply(&of(&q)).unwrap(), "{columns} {column}");
            }
        }
        assert!(columns == 0 || operator.apply_many(&q[1..], columns).is_err() && blocks.apply_many(&q[1..], columns).is_err());
    }
    assert!(blocks.apply(&vec![f64::NAN; count]).is_err());
    for tolerance in [0.0, 1.0, f64::NAN] {
        assert!(operator.blocks(&factors.middles(), tolerance).is_err(), "{tolerance}");
    }
    assert!(operator.blocks(&factors.middles()[1..], 0.1).is_err());
}

#[test]
fn blocks_are_kept_to_the_last_bit_and_damaged_bytes_are_refused() {
    let scene = room(4, true);
    let (_, blocks) = in_blocks(&FormFactors::new(&scene).unwrap(), 2000, 0.05);
    let bytes = blocks.to_bytes();
    assert_eq!(BlockOperator::from_bytes(&bytes).unwrap(), blocks);
    for end in (0..bytes.len()).step_by(97) {
        assert!(BlockOperator::from_bytes(&bytes[..end]).is_err(), "{end}");
    }
    // Changed bytes are refused, or are other products that can be asked for.
    let ones = vec![1.0; blocks.len()];
    for at in (0..bytes.len()).step_by(7) {
        let mut changed = bytes.clone();
        changed[at] ^= 0x80;
        if let Ok(changed) = BlockOperator::from_bytes(&changed) {
            assert!(changed.apply(&ones).unwrap().into_iter().all(|sum| sum <= 1.0 + 1e-5), "{at}");
        }
    }
}
