use radgrad_core::{DMat3, DVec3, Emission, Emitter, Polygon, Receiver, radiosity};

use super::exchange::areas::Exchange;
use super::exchange::{ALL_DIGITS, RESOLVED};
use super::screen::{Cells, Undecided};
use super::{FactorSettings, FormFactors};
use crate::error::Error;
use crate::extremes::{largest as larger, smallest as smaller};
use crate::scene::Scene;

fn exchange(from: &Polygon, to: &Polygon) -> Exchange {
    super::exchange::exchange(from, to, ALL_DIGITS, RESOLVED)
}

fn polygon(points: &[[f64; 3]]) -> Polygon {
    Polygon::new(points.iter().map(|&p| p.into()).collect()).unwrap()
}

fn floor() -> Polygon {
    polygon(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
}

fn ceiling(z: f64) -> Polygon {
    polygon(&[[0.0, 0.0, z], [0.0, 1.0, z], [1.0, 1.0, z], [1.0, 0.0, z]])
}

#[test]
fn squares_that_face_each_other_exchange_what_the_closed_form_says() {
    // Howell C-11, a = b = c.
    let expected = 0.199_824_895_698_387_4;
    let found = exchange(&floor(), &ceiling(1.0));
    assert!((found.area - expected).abs() <= 1e-15 + found.error && found.error < 1e-12, "{found:?}");
}

#[test]
fn squares_with_a_common_edge_exchange_what_the_closed_form_says() {
    // Howell C-14, l = w = h.
    let expected = 0.200_043_776_075_403_3;
    let wall = polygon(&[[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]]);
    let found = exchange(&floor(), &wall);
    assert!((found.area - expected).abs() <= 1e-15 + found.error && found.error < 1e-12, "{found:?}");
    // A wall that also goes down: its lower half exchanges nothing.
    let wall = polygon(&[[0.0, 0.0, -1.0], [0.0, 1.0, -1.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]]);
    let found = exchange(&floor(), &wall);
    assert!((found.area - expected).abs() <= 1e-15 + found.error && found.error < 1e-12, "{found:?}");
}

/// The faces of a tetrahedron, seen from inside, see nothing but each other, with errors below this part of their areas.
fn closes([a, b, c, d]: [[f64; 3]; 4], part: f64) {
    let faces = [[a, b, c], [a, d, b], [b, d, c], [c, d, a]].map(|face| polygon(&face));
    for i in 0..4 {
        let others = (0..4).filter(|&j| j != i).map(|j| exchange(&faces[i], &faces[j]));
        let (sum, error) = others.fold((0.0, 0.0), |(sum, error), found| (sum + found.area, error + found.error));
        let area = faces[i].area();
        assert!((sum - area).abs() <= error && error < part * area, "{d:?}: {sum} {area} {error:e}");
    }
}

/// Edges with a common end and a small angle take many cells near that end: none of the long ones may be left over.
#[test]
fn slivers_of_a_tetrahedron_see_nothing_but_each_other() {
    for height in [0.3, 0.1, 0.03] {
        let top = [0.9, 0.1 + 0.5 * height, 0.14 + height];
        closes([[0.0, 0.0, 0.0], [1.3, 0.1, 0.2], [0.3, 1.1, -0.1], top], 1e-8);
    }
}

/// No two faces are parallel or perpendicular, and all have common edges.
#[test]
fn faces_of_a_tetrahedron_see_nothing_but_each_other() {
    closes([[0.0, 0.0, 0.0], [1.3, 0.1, 0.2], [0.3, 1.1, -0.1], [0.4, 0.3, 0.9]], 1e-11);
}

#[test]
fn far_away_the_exchange_keeps_its_digits_and_joins_the_sum_over_edges() {
    for distance in [3.0, 5.0, 9.0, 17.0, 33.0, 1e3, 1e6] {
        let found = exchange(&floor(), &ceiling(distance));
        // Howell C-11, with the digits of the differences.
        let (x, s) = (1.0 / distance, (1.0 + 1.0 / (distance * distance)).sqrt());
        let series = libm::log1p(x * x * x * x / (1.0 + 2.0 * x * x)) * -0.5;
        let expected =
            2.0 / (std::f64::consts::PI * x * x) * (series.abs() + 2.0 * x * s * libm::atan(x / s) - 2.0 * x * libm::atan(x));
        let slack = 1e-15 / (x * x);
        assert!((found.area - expected).abs() <= found.error + slack, "{distance}: {found:?} {expected}");
        let digits = if distance > 10.0 { 3e-13 } else { 1e-9 };
        assert!(found.error <= digits * found.area, "{distance}: {found:?}");
    }
    let asymptotic = 1.0 / (std::f64::consts::PI * 1e12);
    assert!((exchange(&floor(), &ceiling(1e6)).area - asymptotic).abs() <= 1e-11 * asymptotic);
}

#[test]
fn any_two_triangles_exchange_the_same_both_ways_and_no_more_than_the_smaller() {
    let mut uniform = draws(7);
    let mut seen = 0;
    for _ in 0..300 {
        let mut triangle = || Polygon::new((0..3).map(|_| DVec3::new(uniform(), uniform(), uniform())).collect()).unwrap();
        let (a, b) = (triangle(), triangle());
        let (there, back) = (exchange(&a, &b), exchange(&b, &a));
        assert!((there.area - back.area).abs() <= there.error + back.error, "{there:?} {back:?}");
        assert!(there.least() <= smaller(a.area(), b.area()) && there.most() >= 0.0, "{there:?}");
        seen += usize::from(there.area > 0.0);
    }
    assert!(seen > 50, "{seen}");
}

#[test]
fn skew_triangles_exchange_what_their_points_see() {
    let mut draw = draws(11);
    let mut uniform = || draw() - 0.5;
    let mut compared = 0;
    for i in 0..200 {
        let distance = 2.0 + f64::from(i % 50);
        let mut triangle = |z: f64| {
            let mut corner = || DVec3::new(uniform(), uniform(), 0.4 * uniform() + z);
            let [a, b, c] = [corner(), corner(), corner()];
            // The lower one looks up, the upper one down.
            let up = (b - a).cross(c - a).z > 0.0;
            Polygon::new(if up == (z == 0.0) { vec![a, b, c] } else { vec![c, b, a] })
        };
        let (Ok(from), Ok(to)) = (triangle(0.0), triangle(distance)) else { continue };
        let in_front = |a: &Polygon, b: &Polygon| a.vertices().iter().all(|v| (*v - b.vertices()[0]).dot(b.normal()) > 0.0);
        if !in_front(&from, &to) || !in_front(&to, &from) || smaller(from.area(), to.area()) < 0.02 {
            continue;
        }
        let emitter = Emitter::new(to.clone(), Emission::Constant(1.0)).unwrap();
        let seen = |node: super::rule::Node| {
            let receiver = Receiver::new(node.point, from.normal(), 1.0).unwrap();
            node.share * from.area() * radiosity(&receiver, &emitter).unwrap()
        };
        let expected: f64 = super::rule::nodes(&from, 12).into_iter().map(seen).sum();
        let found = exchange(&from, &to);
        let slack = 1e-12 * expected;
        assert!((found.area - expected).abs() <= found.error + slack && found.error <= 1e-12, "{found:?} {expected}");
        compared += 1;
    }
    assert!(compared > 50, "{compared}");
}

/// Draws that are the same everywhere (D. E. Knuth, MMIX).
pub(super) fn draws(mut state: u64) -> impl FnMut() -> f64 {
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// One of so many.
fn choose(uniform: &mut impl FnMut() -> f64, count: usize) -> usize {
    let place = uniform() * count as f64;
    (1..count).take_while(|&k| k as f64 <= place).count()
}

/// A room of 4 by 4 by 4 with boxes on a lattice, which touch each other and the walls often, and a few triangles; turned out of the
/// axes, so that what touches does so only up to rounding, in every second one.
fn a_room(seed: u64) -> Scene {
    let mut uniform = draws(seed);
    let turn = if seed.is_multiple_of(2) {
        DMat3::IDENTITY
    } else {
        // A quaternion of small integers.
        let [a, b, c, d] = [2.0, 1.0, -1.0, 0.5];
        let norm = a * a + b * b + c * c + d * d;
        DMat3::from_cols(
            DVec3::new(a * a + b * b - c * c - d * d, 2.0 * (b * c + a * d), 2.0 * (b * d - a * c)),
            DVec3::new(2.0 * (b * c - a * d), a * a - b * b + c * c - d * d, 2.0 * (c * d + a * b)),
            DVec3::new(2.0 * (b * d + a * c), 2.0 * (c * d - a * b), a * a - b * b - c * c + d * d),
        ) * (1.0 / norm)
    };
    let mut scene = Scene::new(["grey"]).unwrap();
    let material = scene.add_material("white", [0.5], [0.0]).unwrap();
    let surface = scene.add_surface("all");
    let mut add = |points: Vec<DVec3>| {
        let polygon = Polygon::new(points.into_iter().map(|p| turn * p).collect()).unwrap();
        scene.add_face(surface, material, polygon, None).unwrap();
    };
    let mut block = |low: DVec3, high: DVec3, outwards: bool| {
        for axis in 0..3 {
            for (side, corner) in [(1.0, high), (-1.0, low)] {
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                let mut points = Vec::new();
                for (s, t) in [(0, 0), (1, 0), (1, 1), (0, 1)] {
                    let mut point = corner;
                    point[u] = if s == 0 { low[u] } else { high[u] };
                    point[v] = if t == 0 { low[v] } else { high[v] };
                    points.push(point);
                }
                if (side > 0.0) != outwards {
                    points.reverse();
                }
                add(points);
            }
        }
    };
    block(DVec3::ZERO, DVec3::splat(4.0), false);
    for _ in 0..=choose(&mut uniform, 3) {
        let mut place = |most: f64| (most * uniform()).floor() * 0.5;
        let low = DVec3::new(place(6.0), place(6.0), place(4.0));
        let size = DVec3::new(0.5 + place(4.0), 0.5 + place(4.0), 0.5 + place(4.0));
        block(low, (low + size).min(DVec3::splat(4.0)), true);
    }
    for _ in 0..2 {
        let mut corner = || DVec3::new(uniform(), uniform(), uniform()) * 3.0 + DVec3::splat(0.5);
        add(vec![corner(), corner(), corner()]);
    }
    scene
}

#[test]
fn brackets_hold_what_random_points_see_and_each_other() {
    let (mut pairs, mut narrow, mut overlapping) = (0, 0, 0);
    for seed in 0..24 {
        let scene = a_room(seed);
        // Blocks may stand in each other, with sides in one plane.
        let factors = match FormFactors::new(&scene) {
            Err(Error::Overlap { .. }) => {
                overlapping += 1;
                continue;
            }
            factors => factors.unwrap(),
        };
        let mut uniform = draws(1000 + seed);
        let count = scene.faces().len();
        for _ in 0..30 {
            let [from, to] = [(); 2].map(|()| choose(&mut uniform, count));
            let (polygon, other) = (factors.polygon(from), factors.polygon(to));
            // Faces that touch all over have no gap between them, but for a point an ulp off its face.
            if exchange(polygon, other) == Exchange::default() {
                continue;
            }
            let least_area = smaller(polygon.area(), other.area());
            let bounds = |from: usize, to: usize, most_cells: usize| {
                let settings = FactorSettings { most_cells, estimate: 1.0, ..FactorSettings::default() };
                let factor = factors.between(from, to, &settings).unwrap();
                assert!(factor.lower <= factor.value && factor.value <= factor.upper, "{factor:?}");
                [factor.lower, factor.upper].map(|bound| bound * factors.polygon(from).area())
            };
            // What the points of random places see, in the closed forms of core: not a line of the bracket's own.
            let (mut sum, mut squares, samples) = (0.0, 0.0, 150);
            let patches = super::rule::patches(polygon.vertices());
            for k in 0..samples {
                let (point, density) = patches[k % patches.len()].at(uniform(), uniform());
                let receiver = Receiver::new(point, polygon.normal(), 1.0).unwrap();
                let seen = factors.at_point(&receiver, Some(from), to, 1e-10).unwrap().radiosity;
                let seen = seen * density * patches.len() as f64;
                (sum, squares) = (sum + seen, squares + seen * seen);
            }
            let mean = sum / samples as f64;
            let deviation = (larger(squares / samples as f64 - mean * mean, 0.0) / samples as f64).sqrt();
            let mut before = [0.0, f64::INFINITY];
            for (most_cells, [a, b]) in [(1, [from, to]), (12, [to, from]), (60, [from, to]), (400, [to, from])] {
                let [least, most] = bounds(a, b, most_cells);
                assert!(
                    least <= most && least <= before[1] && most >= before[0],
                    "{seed}: {from} {to} {least} {most} {before:?}"
                );
                before = [least, most];
                // Six deviations, and what 150 points would not notice.
                let slack = 6.0 * deviation + 0.05 * larger(mean, most - least) + 1e-6 * least_area;
                assert!(
                    mean >= least - slack && mean <= most + slack,
                    "{seed}: {from} {to} {mean} +- {deviation}, {least} {most}"
                );
            }
            pairs += usize::from(before[1] > 0.0);
            narrow += usize::from(before[1] > 0.0 && before[1] - before[0] < 0.02 * least_area);
        }
    }
    assert!(pairs > 200 && 2 * narrow > pairs && overlapping < 8, "{pairs} {narrow} {overlapping}");
}

#[test]
fn a_matrix_is_reciprocal_and_what_is_not_met_is_named() {
    let scene = a_room(1);
    let factors = FormFactors::new(&scene).unwrap();
    let settings = FactorSettings { tolerance: 0.05, most_cells: 300, estimate: 1e-4, ..FactorSettings::default() };
    let matrix = factors.matrix(&settings, || ()).unwrap();
    let unmet: Vec<_> = matrix.unmet(&settings).collect();
    for (from, entry) in matrix.entries() {
        let (there, back) = (entry.factor * matrix.areas()[from], matrix.factor(entry.face, from) * matrix.areas()[entry.face]);
        assert!((there - back).abs() <= 4.0 * f64::EPSILON * there, "{from}: {entry:?}");
        assert!(entry.lower <= entry.factor && entry.factor <= entry.upper, "{from}: {entry:?}");
        assert!(entry.error >= entry.upper - entry.factor && entry.error >= entry.factor - entry.lower, "{from}: {entry:?}");
        assert_eq!(unmet.contains(&(from, entry)), entry.error > 0.05, "{from}: {entry:?}");
    }
    // Boxes and triangles go through each other: few cells leave many brackets wide.
    assert!(4 * unmet.len() < matrix.entries().count(), "{} of {}", unmet.len(), matrix.entries().count());
    assert!(matrix.worst_reciprocity() <= 1e-15);
}

#[test]
fn screens_decide_contacts_and_edges_on_edges() {
    use super::screen::{Screen, Sight};
    let square =
        |x: [f64; 2], y: [f64; 2], z: f64| [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| DVec3::new(x[i], y[j], z)).to_vec();
    let screen = &Screen::all_of(&Polygon::new(square([0.0, 1.0], [0.0, 1.0], 0.5)).unwrap())[0];
    let sight = |a: &[DVec3], b: &[DVec3]| screen.between(&Cells::new([a, b]), 1.0, Undecided::ALL).sight;
    let below = square([0.0, 1.0], [0.0, 1.0], 0.0);
    // Straight above all of it, beyond the edge's plane, and half of each.
    assert_eq!(sight(&below, &square([0.0, 1.0], [0.0, 1.0], 1.0)), Sight::Blocked);
    assert_eq!(sight(&below, &square([2.0, 3.0], [0.0, 1.0], 1.0)), Sight::Free);
    assert_eq!(sight(&below, &square([0.5, 1.5], [0.0, 1.0], 1.0)), Sight::Part);
    // Two walls on its plane, one joined to its edge and one beside it.
    let wall = |x: f64| vec![DVec3::new(x, 0.0, 0.5), DVec3::new(x, 1.0, 0.5), DVec3::new(x, 1.0, 0.9), DVec3::new(x, 0.0, 0.9)];
    assert_eq!(sight(&wall(0.0), &square([0.0, 1.0], [0.0, 1.0], 0.0)), Sight::Blocked);
    assert_eq!(sight(&wall(-1.0), &square([-2.0, -1.0], [0.0, 1.0], 0.0)), Sight::Free);
    // Both on one side, and one in the plane.
    assert_eq!(sight(&wall(0.0), &wall(1.0)), Sight::Free);
    assert_eq!(sight(&below, &square([0.0, 1.0], [0.0, 1.0], 0.5)), Sight::Free);
}

#[test]
fn a_lamp_that_is_level_with_a_face_up_to_rounding_gives_it_what_the_coordinates_say() {
    let (mut lit, mut dark) = (0, 0);
    for turn in 1..40 {
        let turned = DMat3::from_rotation_y(0.1 * f64::from(turn)) * DMat3::from_rotation_x(0.37);
        let at = |x: f64, y: f64| turned * DVec3::new(x, y, 0.3);
        let mut scene = Scene::new(["grey"]).unwrap();
        let white = scene.add_material("white", [0.5], [1.0]).unwrap();
        // Triangles, which are flat whatever the rounding is.
        let corners = [vec![at(0.0, 0.0), at(1.0, 0.0), at(0.2, 0.7)], vec![at(1.3, 0.1), at(2.3, 0.3), at(1.5, 1.1)]];
        for corners in corners {
            let surface = scene.add_surface("wall");
            scene.add_face(surface, white, Polygon::new(corners).unwrap(), None).unwrap();
        }
        let factors = FormFactors::new(&scene).unwrap();
        let lamp = Emitter::new(scene.faces()[1].polygon().clone(), Emission::Constant(1.0)).unwrap();
        for cell in factors.field(0, 2, &[(1, 1.0)], 1e-6, || ()).unwrap() {
            let receiver = Receiver::new(cell.centre, scene.faces()[0].polygon().normal(), 1.0).unwrap();
            let known = radgrad_core::evaluate(&receiver, &lamp, std::iter::empty()).unwrap();
            assert!((cell.value - known.radiosity).abs() <= cell.value_error + known.radiosity_error, "{cell:?} {known:?}");
            if known.radiosity > known.radiosity_error { lit += 1 } else { dark += 1 }
        }
    }
    assert!(lit > 3 && dark > 3, "{lit} {dark}");
}

/// A lamp whose sides are 400 roundings of its coordinates long sees the upper tenth of a wall beside it.
#[test]
fn a_face_of_few_roundings_sees_what_is_a_little_above_its_plane() {
    let wall = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.1], [1.6, 0.0, 1.1], [1.6, 0.0, 0.0]];
    let (x, y, z, side) = (0.44, 1.4, 1.0, 1e-13);
    let lamp = [[x, y, z], [x + side, y, z], [x + side, y + side, z], [x, y + side, z]];
    let mut scene = Scene::new(["grey"]).unwrap();
    let material = scene.add_material("white", [0.5], [0.0]).unwrap();
    for corners in [wall, lamp] {
        let surface = scene.add_surface("each");
        let polygon = Polygon::new(corners.map(DVec3::from).to_vec()).unwrap();
        scene.add_face(surface, material, polygon, None).unwrap();
    }
    let seen = FormFactors::new(&scene).unwrap().between(1, 0, &FactorSettings::default()).unwrap();
    let evaluated = {
        let receiver = Receiver::new(DVec3::new(x, y, z), DVec3::Z, 1.0).unwrap();
        let emitter = Emitter::new(Polygon::new(wall.map(DVec3::from).to_vec()).unwrap(), Emission::Constant(1.0)).unwrap();
        radgrad_core::evaluate(&receiver, &emitter, []).unwrap().radiosity
    };
    assert!(evaluated > 1e-4 && seen.lower <= evaluated && evaluated <= seen.upper, "{evaluated} {seen:?}");
}

#[test]
fn faces_of_a_few_roundings_exchange_between_nothing_and_their_area() {
    let mut draw = draws(7);
    let mut uniform = || draw() - 0.5;
    let holds = |name: &str, [tiny, large]: [&Polygon; 2]| {
        let mut seen = 0;
        for pair in [[tiny, large], [large, tiny]] {
            for truncation in [ALL_DIGITS, 1e-6] {
                let found = super::exchange::exchange(pair[0], pair[1], truncation, RESOLVED);
                let allowed = tiny.area() * (1.0 + 1e-12);
                assert!(found.most() >= 0.0 && found.least() <= allowed, "{name}: {found:?}, {allowed:e}");
                seen += usize::from(found.area != 0.0);
            }
        }
        seen
    };
    // Of edges this short the directions count as parallel to any other, and the other's are the better known.
    let tiny = polygon(&[[0.0, 0.0, 2_f64.powi(-45)], [0.0, 2_f64.powi(-49), 0.0], [0.0, 0.0, 0.0]]);
    let large = [[53.0, 49.0, 50.0], [54.0, -1.0, -1.0], [-1.0, -1.0, -1.0]].map(|corner| corner.map(|x: f64| x / 128.0));
    holds("found by fuzzing", [&tiny, &polygon(&large)]);
    let mut seen = 0;
    for case in 0..3000 {
        // Exactly in a plane of the axes, or anywhere.
        let size = 2_f64.powi(-20 - case % 40);
        let flat = f64::from(case % 2);
        let mut corner = |reach: f64, flat: f64| DVec3::new(uniform() * flat, uniform(), uniform()) * reach;
        let tiny = Polygon::new((0..3).map(|_| corner(size, flat)).collect());
        let large = Polygon::new((0..3).map(|_| corner(1.0, 1.0)).collect());
        let (Ok(tiny), Ok(large)) = (tiny, large) else { continue };
        seen += holds(&case.to_string(), [&tiny, &large]);
    }
    assert!(seen > 4000, "{seen}");
}
