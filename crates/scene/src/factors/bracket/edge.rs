//! The exchange that passes edges of screens, between two cells whose every segment is inside the other edges of these screens.
//!
//! # The share of pairs that pass an edge
//!
//! | symbol | meaning |
//! |---|---|
//! | a, E | the start of the edge, and the vector to its end |
//! | w | a vector, here the one between the centres of the cells |
//! | `N0 = E x w`, `N1 = E x N0` | normals of two planes through the edge, perpendicular to each other |
//! | `q(x) = N0.(x - a)`, `p(x) = N1.(x - a)` | the place of a point, seen along the edge |
//! | `s(x) = q(x)/p(x)` | the slope of the plane through the edge and x |
//! | A(s), B(s) | the share of the first and of the second cell at slopes below s |
//!
//! A segment from x to y passes outside the edge where `T(x, y) = E.((y - a) x (x - a))` is negative ([`crate::factors::screen`]). N0, N1 and E are perpendicular, so
//!
//! `T(x, y) = (q(y) p(x) - p(y) q(x)) E.E/N1.N1`.
//!
//! Where p is positive on all of the first cell and negative on all of the second one, `T < 0` where `s(y) > s(x)`: the share of all pairs that are
//! outside is `v = int A dB`. The points of a cell at slopes below s are on one side of the plane `q = s p`, so A and B are shares of a convex polygon
//! beside a line, in closed form. Both ascend from 0 to 1. So for any ascending slopes `s_0` to `s_n`, with `B = 0` before the first and `A = B = 1`
//! after the last one, v is between
//!
//! `sum A(s_(k-1)) (B(s_k) - B(s_(k-1)))` and `sum A(s_k) (B(s_k) - B(s_(k-1)))`.
//!
//! Rounding moves `q - s p` at corners by at most `32 eps |E| |w| |x - a| (1 + |s| |E|)`, called off: N0 errs by 6 roundings of `|E| |w|`, N1 by 12 of `|E|^2 |w|`,
//! and a product with `x - a` and the difference by 9 more. The chords of a convex polygon are concave along its range, so the density of an affine
//! function on it is at most 2 over its range, and a share errs by at most `2 off/range`. A and B ascend to 1, so the sums err by at most the error of
//! A and that of B.
//!
//! # The exchange
//!
//! Let the kernel k be between `k0` and `k1` on all pairs, E their exchange with nothing in between, and W the product of the areas. What
//! passes on a share v of them is at most `k1 v W`, and at most E less what the rest does at least, `k0 (1 - v) W`; so it is known to within
//! `(k1 - k0) v (1 - v) W`. The uncertainty of k is in proportion to the size of the cells over their distance. So the
//! undecided part is about E times that ratio; without this rule it would be all of E.
//!
//! A shadow is what is inside all of some edges. It is at least all but the sum of what is outside each, and at most what is inside any one of
//! them, or all but the sum of what is outside those that nothing passes outside two of. What all shadows hide is at most the sum, and at
//! least the sum over those that have nothing in common ([`super::nesting`]).

use radgrad_core::DVec3;

use super::cell::{Cell, Plane};
use super::nesting::Nested;
use crate::extremes::{largest as larger, smallest as smaller};
use crate::factors::exchange::areas::Exchange;
use crate::factors::screen::MOST_CORNERS;

/// Slopes between which the shares of two cells are compared, less one.
const SLICES: usize = 16;

/// Rounding of a share from which an edge says nothing.
const MOST_OFF: f64 = 1e-6;

/// Relative rounding of shares, areas and kernels: a few dozen operations.
const ROUNDING: f64 = 1e-12;

/// A kernel that varies by more than this over its least value says too little for what the exchange of so near cells costs.
const USEFUL: f64 = 5.0;

/// Lower bounds on the exchange of two cells that passes an edge, and on the part that the screen hides.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Passing {
    pub(super) seen: f64,
    pub(super) hidden: f64,
}

/// Bounds on the exchange that passes some shadows. `is_all` says that nothing else hides anything. `whole` computes the cells'
/// exchange with nothing in between; it is called, and its result returned, unless the cells are so near each other that the bounds
/// would be empty.
pub(super) fn passing(
    cells: [&Cell; 2],
    planes: [&Plane; 2],
    shadows: &[Nested],
    is_all: bool,
    whole: impl FnOnce() -> Exchange,
) -> Option<(Passing, Exchange)> {
    let kernel = kernel(cells, planes)?;
    let is_useful = kernel[1] - kernel[0] <= USEFUL * kernel[0];
    // A kernel that is no number or not finite says nothing either.
    if shadows.is_empty() || !is_useful {
        return None;
    }
    let whole = whole();
    let mut found = Passing { seen: if is_all { whole.least() } else { 0.0 }, hidden: 0.0 };
    let mut parts: Vec<(f64, &Nested)> = Vec::with_capacity(shadows.len());
    for shadow in shadows {
        let [least, most] = inside_all(cells, shadow, kernel, whole);
        parts.push((least, shadow));
        found.seen -= most;
    }
    // Those that hide most first.
    parts.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut apart: Vec<&Nested> = Vec::new();
    for (least, shadow) in parts {
        if least > 0.0 && apart.iter().all(|other| shadow.is_apart_from(other)) {
            apart.push(shadow);
            found.hidden += least;
        }
    }
    found.seen = larger(found.seen, 0.0);
    Some((found, whole))
}

/// Bounds on the exchange inside all edges of a shadow.
fn inside_all(cells: [&Cell; 2], shadow: &Nested, kernel: [f64; 2], whole: Exchange) -> [f64; 2] {
    let beside = |&edge: &[DVec3; 2]| Beside::of(cells, share_outside(cells, edge), kernel, whole);
    let all: Vec<Beside> = shadow.edges.iter().map(beside).collect();
    if let [beside] = &all[..] {
        return beside.inside;
    }
    let most = all.iter().map(|beside| beside.inside[1]).fold(whole.most(), smaller);
    let least = whole.least() - all.iter().map(|beside| beside.outside).sum::<f64>();
    // Nothing passes outside two of these.
    let (mut apart, mut outside): (Vec<usize>, f64) = (Vec::new(), 0.0);
    for (k, beside) in all.iter().enumerate() {
        let least = whole.least() - beside.inside[1];
        if least > 0.0 && apart.iter().all(|&other| shadow.is_covered_by([k, other])) {
            apart.push(k);
            outside += least;
        }
    }
    [least, smaller(most, whole.most() - outside)]
}

/// Bounds on the exchange on the two sides of an edge.
struct Beside {
    /// Least and most.
    inside: [f64; 2],
    /// Most.
    outside: f64,
}

impl Beside {
    fn of([a, b]: [&Cell; 2], [below, above]: [f64; 2], [least, most]: [f64; 2], whole: Exchange) -> Self {
        let product = a.area * b.area;
        // At most the largest kernel on all of the share, and all but the least kernel on the rest.
        let at_most = |share: f64| {
            let by_rest = (whole.most() / product) * (1.0 + ROUNDING) - least * (1.0 - share);
            let by_kernel = smaller(most * share, by_rest);
            by_kernel * product + ROUNDING * (whole.most() + most * share * product)
        };
        let [inside, outside] = [at_most(1.0 - below), at_most(above)];
        Self { inside: [whole.least() - outside, inside], outside }
    }
}

/// Bounds on the kernel `k = u v / (pi r^4)` of all pairs of points, with `u = n1.r` and `v = -n2.r`. Both are affine in each point, `r.r` is
/// convex.
///
/// `sqrt(u v)` is concave where neither is negative. So `sqrt(pi k)`, its quotient by `r.r`, is at least any c in a convex set of r: it is least
/// at a pair of corners. And for any `r0` it is at most the quotient of tangents, `(a u + v / a) / 2` with `a^2 = v0 / u0` over `2 r0.r - r0.r0`, which is
/// largest at corners where that is positive. With the `r0` between the corners where k is largest this is k there, if k is largest at corners, as it
/// mostly is; else the one between the centres says more.
fn kernel([a, b]: [&Cell; 2], planes: [&Plane; 2]) -> Option<[f64; 2]> {
    let centres = [a, b].map(Cell::centre);
    let radius = |cell: &Cell, centre: DVec3| cell.points.iter().map(|&p| (p - centre).length_squared()).fold(0.0, larger).sqrt();
    let between = centres[1] - centres[0];
    let distance = between.length();
    let apart = distance - radius(a, centres[0]) - radius(b, centres[1]);
    let sides = |r: DVec3| [planes[0].normal.dot(r), -planes[1].normal.dot(r)];
    let (mut rise, mut fall) = ([f64::INFINITY, 0.0], [f64::INFINITY, 0.0]);
    let (mut ahead, mut least, mut largest) = (f64::INFINITY, f64::INFINITY, (0.0, between));
    for &x in &a.points {
        for &y in &b.points {
            let r = y - x;
            let [up, down] = sides(r);
            rise = [smaller(rise[0], up), larger(rise[1], up)];
            fall = [smaller(fall[0], down), larger(fall[1], down)];
            let (along, length) = (between.dot(r), r.length_squared());
            let square = larger(up, 0.0) * larger(down, 0.0) / (length * length);
            least = smaller(least, square);
            if square > largest.0 {
                largest = (square, r);
            }
            ahead = smaller(ahead, along);
        }
    }
    let tangent = smaller(tangent([a, b], sides, between), tangent([a, b], sides, largest.1));
    // The distance along any direction is a lower bound, but for roundings of coordinates up to 1.
    let ahead = if distance > 0.0 { ahead / distance } else { 0.0 };
    let nearest = larger(larger(apart, ahead), larger(rise[0], fall[0])) * (1.0 - ROUNDING) - 16.0 * f64::EPSILON;
    if nearest <= 0.0 || nearest.is_nan() {
        return None;
    }
    let near = nearest * nearest;
    let facing = 1.0 / (std::f64::consts::PI * near);
    let by_distance = smaller(rise[1] * fall[1] / near, 1.0) * facing;
    let by_tangent = tangent * tangent / std::f64::consts::PI;
    let most = if by_tangent < by_distance { by_tangent } else { by_distance };
    // Heights over the planes err by roundings of distances, however low they are.
    Some([larger(least / std::f64::consts::PI - ROUNDING * facing, 0.0), most + ROUNDING * facing])
}

/// The most that the quotient of tangents at `r0` is at the corners of two cells.
fn tangent([a, b]: [&Cell; 2], sides: impl Fn(DVec3) -> [f64; 2], r0: DVec3) -> f64 {
    let [u, v] = sides(r0);
    let square = r0.length_squared();
    let tilt = if u > 0.0 && v > 0.0 { (v / u).sqrt() } else { f64::INFINITY };
    let mut most = 0.0;
    for &x in &a.points {
        for &y in &b.points {
            let r = y - x;
            let ([up, down], length) = (sides(r), r.length_squared());
            // Heights err by roundings of the distance.
            let above = 0.5 * (tilt * up + down / tilt) + ROUNDING * (tilt + 1.0 / tilt) * length.sqrt();
            let below = 2.0 * r0.dot(r) - square * (1.0 + ROUNDING) - ROUNDING * length;
            most = larger(most, if below > 0.0 { above / below } else { f64::INFINITY });
        }
    }
    most
}

/// Bounds on the share of all pairs whose segment passes outside the edge: from nothing to all where the cells are not on two sides of a plane
/// through it.
pub(in crate::factors) fn share_outside(cells: [&Cell; 2], edge: [DVec3; 2]) -> [f64; 2] {
    by_slopes(cells, edge).unwrap_or([0.0, 1.0])
}

fn by_slopes([a, b]: [&Cell; 2], [from, to]: [DVec3; 2]) -> Option<[f64; 2]> {
    let (along, between) = (to - from, b.centre() - a.centre());
    let upright = along.cross(between);
    let [n0, n1] = [upright, along.cross(upright)];
    let size = [along.length(), between.length()];
    let (first, second) = (Slopes::new(a, from, [n0, n1], size)?, Slopes::new(b, from, [-n0, -n1], size)?);
    let (low, high) = (larger(first.range[0], second.range[0]), smaller(first.range[1], second.range[1]));
    let (mut least, mut most, mut off) = (0.0, 0.0, [0.0; 2]);
    let mut before = [0.0; 2];
    for k in 0..=SLICES {
        let slope = low + (high - low) * (k as f64 / SLICES as f64);
        let [(share, error), (other, error_of_other)] = [first.share_below(slope), second.share_below(slope)];
        off = [larger(off[0], error), larger(off[1], error_of_other)];
        least += before[0] * (other - before[1]);
        most += share * (other - before[1]);
        before = [share, other];
    }
    let [share, other] = before;
    let (least, most) = (least + share * (1.0 - other), most + (1.0 - other));
    // The second one counts twice, so that products of errors are in it.
    let off = off[0] + 2.0 * off[1] + ROUNDING;
    (low < high && off <= MOST_OFF).then_some([larger(least - off, 0.0), smaller(most + off, 1.0)])
}

/// A cell as one sees it along an edge.
struct Slopes {
    /// Of each corner.
    p: [f64; MOST_CORNERS],
    q: [f64; MOST_CORNERS],
    count: usize,
    /// The shares of the triangles between the first corner and two next ones.
    shares: [f64; MOST_CORNERS],
    /// Least and largest slope, roughly.
    range: [f64; 2],
    /// Bounds on the error of q and of p.
    off: [f64; 2],
}

impl Slopes {
    /// `None` where p is not positive on all of the cell. `size` has `|E|` and `|w|`.
    fn new(cell: &Cell, from: DVec3, [n0, n1]: [DVec3; 2], size: [f64; 2]) -> Option<Self> {
        let (points, count) = (&cell.points, cell.points.len());
        if count > MOST_CORNERS {
            return None;
        }
        let [mut p, mut q, mut shares] = [[0.0; MOST_CORNERS]; 3];
        let (mut nearest, mut reach, mut range) = (f64::INFINITY, 0.0, [f64::INFINITY, f64::NEG_INFINITY]);
        for (k, &x) in points.iter().enumerate() {
            let r = x - from;
            (p[k], q[k]) = (n1.dot(r), n0.dot(r));
            (nearest, reach) = (smaller(nearest, p[k]), larger(reach, r.length_squared()));
            range = [smaller(range[0], q[k] / p[k]), larger(range[1], q[k] / p[k])];
        }
        let off = 32.0 * f64::EPSILON * size[0] * size[1] * reach.sqrt() + f64::MIN_POSITIVE;
        let off = [off, off * size[0] + f64::MIN_POSITIVE];
        let mut whole = 0.0;
        for k in 0..count - 2 {
            shares[k] = (points[k + 1] - points[0]).cross(points[k + 2] - points[0]).length();
            whole += shares[k];
        }
        shares.iter_mut().for_each(|share| *share /= whole);
        (nearest > 2.0 * off[1]).then_some(Self { p, q, count, shares, range, off })
    }

    /// The share of the cell at slopes below this one, and a bound on its error.
    fn share_below(&self, slope: f64) -> (f64, f64) {
        let mut heights = [0.0; MOST_CORNERS];
        let [mut low, mut high] = [f64::INFINITY, f64::NEG_INFINITY];
        for (k, height) in heights[..self.count].iter_mut().enumerate() {
            *height = self.q[k] - slope * self.p[k];
            (low, high) = (smaller(low, *height), larger(high, *height));
        }
        let of_triangle = |k: usize| self.shares[k] * share_below([heights[0], heights[k + 1], heights[k + 2]]);
        let share = (0..self.count - 2).map(of_triangle).sum();
        let off = self.off[0] + slope.abs() * self.off[1];
        let range = high - low - 2.0 * off;
        (share, if range > 0.0 { 2.0 * off / range } else { f64::INFINITY })
    }
}

/// The share of a triangle on which an affine function of these values at its corners is negative.
fn share_below([a, b, c]: [f64; 3]) -> f64 {
    // The share at the first of three corners, beyond the line between it and the others.
    let corner = |a: f64, b: f64, c: f64| a / (a - b) * (a / (a - c));
    match [a < 0.0, b < 0.0, c < 0.0] {
        [false, false, false] => 0.0,
        [true, false, false] => corner(a, b, c),
        [false, true, false] => corner(b, c, a),
        [false, false, true] => corner(c, a, b),
        [false, true, true] => 1.0 - corner(a, b, c),
        [true, false, true] => 1.0 - corner(b, c, a),
        [true, true, false] => 1.0 - corner(c, a, b),
        [true, true, true] => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use radgrad_core::{Emission, Emitter, Polygon, Receiver, evaluate};

    use super::*;
    use crate::factors::exchange::exchange_parts;
    use crate::factors::rule::{nodes_of, patches};
    use crate::factors::tests::draws;

    /// Points of two triangles, drawn, and pairs of them beside a drawn edge between the two.
    #[test]
    fn the_share_beside_an_edge_is_that_of_pairs_of_points() {
        let mut draw = draws(9);
        let mut uniform = || draw() - 0.5;
        let mut narrow = 0;
        for case in 0..200 {
            let mut corner = |z: f64| DVec3::new(uniform(), uniform(), z + 0.4 * uniform());
            let triangles = [0.0, 1.0].map(|z| [(); 3].map(|()| corner(z)));
            let cells = triangles.map(|points| Cell { points: points.to_vec(), area: 1.0 });
            let edge = [corner(0.5), corner(0.5)];
            // The middles of parts of the same area.
            let place = |[a, b, c]: [DVec3; 3], i: u8, j: u8| {
                let (u, v) = (((f64::from(i) + 0.5) / 12.0).sqrt(), (f64::from(j) + 0.5) / 12.0);
                a + (b - a) * (u * (1.0 - v)) + (c - a) * (u * v)
            };
            let [from, to] = triangles.map(|corners| (0..144).map(move |k| place(corners, k / 12, k % 12)));
            let turns = from.flat_map(|x| to.clone().map(move |y| (y - x).dot((edge[1] - x).cross(edge[0] - x))));
            let outside = turns.filter(|turn| *turn < 0.0).count() as f64 / (144.0 * 144.0);
            let [least, most] = share_outside([&cells[0], &cells[1]], edge);
            assert!(least - 0.02 <= outside && outside <= most + 0.02, "{case}: {outside} in [{least}, {most}]");
            narrow += usize::from(outside > 0.1 && outside < 0.9 && most - least < 0.07);
        }
        assert!(narrow > 40, "{narrow}");
    }

    /// What points see past a screen that reaches far on the other sides of the edge.
    #[test]
    fn what_passes_an_edge_is_what_points_see() {
        let mut draw = draws(3);
        let mut uniform = || draw() - 0.5;
        let mut narrow = 0;
        for case in 0..200 {
            let size = [0.3, 0.1, 0.03][case % 3];
            let mut cell = |z: f64, up: bool| {
                let tilt = [0.3 * uniform(), 0.3 * uniform()];
                let at = [0.5 * uniform(), 0.5 * uniform()];
                let mut corners: Vec<DVec3> = [(0.0, 0.0), (1.0, 0.1), (0.9, 1.2), (-0.2, 0.8)]
                    .iter()
                    .map(|(x, y)| DVec3::new(at[0] + size * x, at[1] + size * y, z + size * (tilt[0] * x + tilt[1] * y)))
                    .collect();
                if !up {
                    corners.reverse();
                }
                Polygon::new(corners)
            };
            let (Ok(a), Ok(b)) = (cell(0.0, true), cell(1.0, false)) else { continue };
            // The edge passes near the middle of the beam.
            let along = DVec3::new(uniform(), uniform(), 0.2 * uniform()).normalize();
            let middle = 0.25 * (a.vertices()[0] + a.vertices()[2] + b.vertices()[0] + b.vertices()[2])
                + DVec3::new(uniform(), uniform(), 0.3 * uniform()) * size;
            let inwards = DVec3::new(-along.y, along.x, 0.0).normalize();
            let [from, to] = [middle - along * 4.0, middle + along * 4.0];
            let corners = vec![from, to, to + inwards * 6.0, from + inwards * 6.0];
            let Ok(screen) = Polygon::new(corners.clone()) else { continue };
            // Counter-clockwise seen from the first cell, which is below.
            let edge = if screen.normal().z < 0.0 { [from, to] } else { [to, from] };
            let planes = [&a, &b].map(|p| Plane { normal: p.normal(), slope: 10.0 / size, defect: p.planarity_defect() });
            let cells = [&a, &b].map(|p| Cell { points: p.vertices().to_vec(), area: p.area() });
            let whole = || exchange_parts([&cells[0].part(&planes[0]), &cells[1].part(&planes[1])], 1e-12);
            let cells = [&cells[0], &cells[1]];
            let Some((found, _)) = passing(cells, [&planes[0], &planes[1]], &[Nested::alone(edge)], true, whole) else {
                continue;
            };
            let emitter = Emitter::new(b.clone(), Emission::Constant(1.0)).unwrap();
            let mut seen = 0.0;
            for patch in patches(a.vertices()) {
                for quarter in patch.halves(0).iter().flat_map(|half| half.halves(1)) {
                    for node in nodes_of(&quarter, 8) {
                        let receiver = Receiver::new(node.point, a.normal(), 1.0).unwrap();
                        seen += node.share * evaluate(&receiver, &emitter, [&screen]).unwrap().radiosity;
                    }
                }
            }
            let (all, slack) = (whole().area, 2e-4 * whole().area);
            assert!(found.seen <= seen + slack && all - found.hidden >= seen - slack, "{case}: {found:?} {seen} of {all}");
            narrow += usize::from(found.seen + found.hidden > 0.5 * all && found.seen > 0.0 && found.hidden > 0.0);
        }
        assert!(narrow > 20, "{narrow}");
    }
}
