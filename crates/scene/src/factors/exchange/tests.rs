//! Exchanges in free sight of edges and faces that almost touch, are almost in one plane or are almost nothing.

use radgrad_core::{DMat3, DVec3, Emission, Emitter, Polygon, Receiver, radiosity};

use super::areas::Exchange;
use super::edges::mean_logarithm;
use super::far::Part;
use super::{ALL_DIGITS, RESOLVED, contour, exchange, exchange_apart};
use crate::extremes::{largest as larger, smallest as smaller};
use crate::factors::rule::{gauss_legendre, patches};
use crate::factors::tests::draws;

fn free(from: &Polygon, to: &Polygon) -> Exchange {
    exchange(from, to, ALL_DIGITS, RESOLVED)
}

fn polygon(points: &[[f64; 3]]) -> Polygon {
    Polygon::new(points.iter().map(|&p| p.into()).collect()).unwrap()
}

const WALL: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, 0.0]];

/// Howell C-14, l = w = h.
const BESIDE: f64 = 0.200_043_776_075_403_3;

/// Each line has a kind, two edges and what they are held against: an integral of 36 digits, as the sum of two doubles.
#[test]
fn pairs_of_edges_are_what_many_digits_say() {
    let lines = include_str!("../../../../../data/reference/edges.txt").lines();
    let mut count = 0;
    for line in lines {
        let numbers: Vec<f64> = line.split(' ').map(|number| number.parse().unwrap()).collect();
        let [_, corners @ .., high, low] = &numbers[..] else { unreachable!("{line}") };
        let p: Vec<DVec3> = corners.chunks(3).map(DVec3::from_slice).collect();
        for (sign, [a, b]) in [(1.0, [[p[0], p[1]], [p[2], p[3]]]), (-1.0, [[p[2], p[3]], [p[1], p[0]]])] {
            let (found, error) = mean_logarithm(a, b, 1e-16);
            let off = ((sign * found - high) - low).abs();
            assert!(off <= error && error <= 2e-12, "{off:e} {error:e}: {line}");
        }
        count += 1;
    }
    assert!(count > 150, "{count}");
}

#[test]
fn a_floor_cut_at_any_angle_from_the_walls_edge_exchanges_what_it_did_whole() {
    let wall = polygon(&WALL);
    for digit in 1..=12 {
        let end = 10_f64.powi(-digit);
        let sliver = polygon(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, end, 0.0]]);
        let rest = polygon(&[[0.0, 0.0, 0.0], [1.0, end, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
        let parts = [free(&sliver, &wall), free(&rest, &wall)];
        let (sum, error) = (parts[0].area + parts[1].area, parts[0].error + parts[1].error);
        assert!((sum - BESIDE).abs() <= error + 1e-16 && error < 1e-11, "{end:e}: {parts:?}");
        // A strip along the edge sees half a hemisphere of wall, but at its ends.
        let share = parts[0].area / sliver.area();
        // A hundred roundings of an edge's length, over the sliver's width.
        assert!(parts[0].error < 1e-3 * sliver.area() || digit > 10, "{end:e}: {parts:?}");
        assert!(digit < 3 || (share - 0.5).abs() < 10.0 * end + parts[0].error / sliver.area(), "{end:e}: {share}");
    }
}

/// What points of the first polygon's rectangle, `corner + s u + t v`, see of the second, on cells graded towards the side t = 0 and both ends of it.
fn by_points([corner, u, v]: [DVec3; 3], to: &Polygon) -> f64 {
    let emitter = Emitter::new(to.clone(), Emission::Constant(1.0)).unwrap();
    let normal = u.cross(v).normalize();
    let graded: Vec<f64> = std::iter::once(0.0).chain((0..34).rev().map(|k| 0.5_f64.powi(k))).collect();
    let half: Vec<f64> = graded.iter().map(|x| 0.5 * x).collect();
    let both: Vec<f64> = half.iter().copied().chain(half.iter().rev().skip(1).map(|x| 1.0 - x)).collect();
    let nodes = |breaks: &[f64]| -> Vec<(f64, f64)> {
        let cell = |ends: &[f64]| {
            let (from, size) = (ends[0], ends[1] - ends[0]);
            gauss_legendre(6).iter().map(move |&(x, w)| (from + size * (0.5 + 0.5 * x), 0.5 * w * size))
        };
        breaks.windows(2).flat_map(cell).collect()
    };
    let (along, across) = (nodes(&both), nodes(&graded));
    let mut sum = 0.0;
    for &(t, w) in &across {
        for &(s, z) in &along {
            let receiver = Receiver::new(corner + u * s + v * t, normal, 1.0).unwrap();
            sum += w * z * radiosity(&receiver, &emitter).unwrap();
        }
    }
    sum * u.cross(v).length()
}

#[test]
fn a_wall_that_almost_meets_a_floor_exchanges_what_its_points_see() {
    let floor = polygon(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
    for (gap, height, turn) in [
        (0.0, 0.0, 1e-2),
        (0.0, 0.0, 1e-4),
        (1e-3, 1e-3, 0.0),
        (1e-4, 0.0, 1e-3),
        (0.0, 1e-5, 1e-4),
        (1e-6, 1e-7, 1e-6),
        (1e-8, 1e-4, 1e-9),
        (0.0, 1e-9, 1e-3),
    ] {
        // Beside the floor's edge, over it, and turned away from it.
        let corner = DVec3::new(0.0, -gap, height);
        let (u, v) = (DVec3::new(1.0, -turn, 0.5 * turn), DVec3::Z);
        // Turned about its lower edge, so that it is a rectangle seen by the floor.
        let v = (v - u * (u.dot(v) / u.dot(u))).normalize();
        let wall = Polygon::new(vec![corner, corner + v, corner + u + v, corner + u]).unwrap();
        let expected = by_points([corner + u, -u, v], &floor);
        let found = free(&floor, &wall);
        assert!((found.area - expected).abs() < 1e-9 && found.error < 1e-9, "{gap:e} {height:e} {turn:e}: {found:?} {expected}");
    }
}

/// A cube whose faces are cut into needles by lines from a corner, at small angles to an edge.
#[test]
fn needles_of_a_cube_see_nothing_but_its_other_faces() {
    let turn = DMat3::from_rotation_y(0.7) * DMat3::from_rotation_x(0.37);
    for width in [1e-1, 1e-3, 1e-5, 1e-7, 1e-9] {
        let mut faces = Vec::new();
        for axis in 0..3 {
            for side in [0.0, 1.0] {
                let at = |u: f64, v: f64| {
                    let mut point = DVec3::splat(side);
                    point[(axis + 1) % 3] = u;
                    point[(axis + 2) % 3] = v;
                    turn * (point - DVec3::splat(0.5))
                };
                let parts = [
                    vec![at(0.0, 0.0), at(1.0, 0.0), at(1.0, width)],
                    vec![at(0.0, 0.0), at(1.0, width), at(1.0, 1.0)],
                    vec![at(0.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)],
                ];
                for mut part in parts {
                    if side > 0.5 {
                        part.reverse();
                    }
                    faces.push((2 * axis + usize::from(side > 0.5), Polygon::new(part).unwrap()));
                }
            }
        }
        for (plane, face) in &faces {
            let others = faces.iter().filter(|(other, _)| other != plane).map(|(_, other)| free(face, other));
            let (sum, error) = others.fold((0.0, 0.0), |(sum, error), found| (sum + found.area, error + found.error));
            // Corners are where they are but for roundings.
            let slack = 1e-15;
            assert!((sum - face.area()).abs() <= error + slack && error < 1e-10, "{width:e}: {sum} {error:e} {face:?}");
            assert!(error < 1e-3 * face.area(), "{width:e}: {error:e} {:e}", face.area());
        }
    }
}

#[test]
fn any_two_triangles_almost_in_one_plane_exchange_what_the_parts_of_one_do() {
    let mut uniform = draws(23);
    let mut seen = 0;
    for case in 0..100 {
        let mut small = |least: f64| libm::exp10(least * uniform());
        let (width, angle, gap, lift) = (small(-12.0), small(-15.0), small(-15.0), small(-15.0));
        let [gap, lift] = [[0.0, 0.0], [gap, 0.0], [0.0, lift], [gap, lift]][case % 4];
        let [x, y, share] = [uniform() - 0.5, uniform(), uniform()];
        // One in a plane, the other on an edge that is nearly the first one's, facing it.
        let a = [DVec3::ZERO, DVec3::X, DVec3::new(y, width, 0.0)];
        let start = DVec3::new(x, -gap, lift);
        let b = [start, start + DVec3::new(0.3, -angle, 1.0) * width.sqrt(), start + DVec3::new(1.0, -angle, 0.5 * angle)];
        let (Ok(from), Ok(to)) = (Polygon::new(a.to_vec()), Polygon::new(b.to_vec())) else { continue };
        let whole = free(&from, &to);
        // What is level with a sliver, as its plane is known, it does not see.
        if whole == Exchange::default() {
            continue;
        }
        let allowed = smaller(from.area(), to.area());
        assert!(whole.area >= -whole.error && whole.area <= allowed + whole.error, "{case}: {whole:?} {allowed:e}");
        assert!(whole.error <= 1e-9 && whole.error <= 1.01 * allowed, "{case}: {whole:?} {allowed:e}");
        let back = free(&to, &from);
        assert!((whole.area - back.area).abs() <= whole.error + back.error, "{case}: {whole:?} {back:?}");
        let cut = a[1] + (a[2] - a[1]) * share;
        let halves = [[a[0], a[1], cut], [a[0], cut, a[2]]].map(|part| Polygon::new(part.to_vec()));
        let [Ok(first), Ok(second)] = halves else { continue };
        let parts = [free(&first, &to), free(&second, &to)];
        if parts.contains(&Exchange::default()) {
            continue;
        }
        // The cut is a rounding off the edge.
        let error = whole.error + parts[0].error + parts[1].error + 1e-16;
        assert!((whole.area - parts[0].area - parts[1].area).abs() <= error, "{case}: {whole:?} {parts:?}");
        seen += usize::from(whole.area > whole.error);
    }
    assert!(seen > 30, "{seen}");
}

/// Drawn triangles and quadrilaterals, wide and narrow, apart by half their size to ten times it: the bound of the rule holds against the sum over edges
/// whatever is allowed, and is not a hundred times what the rule errs by.
#[test]
fn few_nodes_are_within_the_bound_that_chose_them() {
    let mut uniform = draws(31);
    let (mut compared, mut sharpest) = (0, 0.0_f64);
    for round in 0..4_000 {
        let mut face = |up: f64| {
            let (width, slant) = (0.05 + 0.3 * uniform(), 0.5 * uniform());
            let away = DVec3::new(uniform() - 0.5, uniform() - 0.5, up * 0.9);
            let tilt = DMat3::from_rotation_y(1.5 * (uniform() - 0.5)) * DMat3::from_rotation_z(6.0 * uniform());
            let corners = [[-0.2, -width], [0.2, -width], [0.2 - 0.3 * slant, width], [-0.2 + 0.2 * slant, width]];
            let corners = if round % 3 == 0 { &corners[..3] } else { &corners[..] };
            let outline = corners.iter().map(|&[x, y]| away + tilt * DVec3::new(x, y, 0.0));
            Polygon::new(if up < 0.0 { outline.collect() } else { outline.rev().collect() })
        };
        let (Ok(a), Ok(b)) = (face(-0.5), face(0.5)) else { continue };
        let heights = |of: &Polygon, over: &Polygon| {
            of.vertices().iter().map(|&v| over.normal().dot(v - over.vertices()[0])).fold(f64::INFINITY, smaller)
        };
        if heights(&a, &b) < 0.0 || heights(&b, &a) < 0.0 {
            continue;
        }
        let parts =
            |polygon: &Polygon| patches(polygon.vertices()).iter().map(|patch| Part::of(patch, polygon.normal())).collect();
        let [from, to]: [Vec<Part>; 2] = [parts(&a), parts(&b)];
        let exact = contour([a.vertices(), b.vertices()], 1e-16);
        for allowed in [1e-1, 1e-2, 1e-4, 1e-6] {
            let Some(found) = exchange_apart([(&from, &a), (&to, &b)], allowed) else { continue };
            let off = (found.area - exact.area).abs();
            assert!(off <= found.error + exact.error, "{allowed}: {off:e} {found:?} {exact:?} {a:?} {b:?}");
            compared += 1;
            sharpest = larger(sharpest, (off - exact.error) / found.error);
        }
    }
    assert!(compared > 2_000 && sharpest > 0.01, "{compared} {sharpest}");
}
