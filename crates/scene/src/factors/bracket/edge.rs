//! The exchange that passes edges of screens, between two cells whose every segment is inside the other edges of these screens.
//!
//! A segment from x to y passes outside the edge where T(x, y) < 0 ([`crate::factors::screen`]), and T is affine in x and in y. With
//! c and d points of the two cells, `T(x, y) = T(x, d) + T(c, y) - T(c, d) + m(x, y)`, where m is largest at corners, since it is affine
//! in each as well: `|m| <= t`. So the share v of all pairs (x, y) that are outside is between those of pairs with `T(x, d) + T(c, y) -
//! T(c, d)` below -t and below t: a sum of two functions, of which it is known for either cell over what share it is below a value. The
//! density of the one and the share of the other are polynomials of degree 1 and 2 between the values at corners, and the integral of their
//! product is exact by Gauss' rule of two nodes.
//!
//! Let the kernel k be between `k0` and `k1` on all pairs, E their exchange with nothing in between, and W the product of the areas. What
//! passes on a share v of them is at most `k1 v W`, and at most E less what the rest does at least, `k0 (1 - v) W`; so it is known to within
//! `(k1 - k0) v (1 - v) W`. Both the uncertainty of v and that of k are in proportion to the size of the cells over their distance. So the
//! undecided part is E times that ratio; without this rule it would be all of E.
//!
//! A shadow is what is inside all of some edges. It is at least all but the sum of what is outside each, and at most what is inside any one of
//! them, or all but the sum of what is outside those that nothing passes outside two of. What all shadows hide is at most the sum, and at
//! least the sum over those that have nothing in common ([`super::nesting`]).

use radgrad_core::{DVec3, mutant};

use super::cell::{Cell, Plane};
use super::nesting::Nested;
use crate::factors::exchange::Exchange;
use crate::factors::screen::MOST_CORNERS;
use crate::factors::{larger, smaller};

/// The node of Gauss' rule of two nodes, `1/sqrt 3`.
const NODE: f64 = 0.577_350_269_189_625_8;

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
    if shadows.is_empty() || !is_useful || kernel.iter().any(|k| !k.is_finite()) {
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
            let by_kernel = mutant!("factors.edge-off", smaller(most * share, by_rest), |most| 0.9 * most);
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

/// Bounds on the share of all pairs whose segment passes outside the edge.
fn share_outside([a, b]: [&Cell; 2], [from, to]: [DVec3; 2]) -> [f64; 2] {
    if a.points.len().max(b.points.len()) > MOST_CORNERS {
        return [0.0, 1.0];
    }
    let normal = |x: DVec3| mutant!("factors.edge-sign", (to - x).cross(from - x), |normal: DVec3| -normal);
    let (c, d) = (a.centre(), b.centre());
    let of_centre = normal(c);
    let middle = (d - c).dot(of_centre);
    let mut turns = [[0.0; MOST_CORNERS]; 2];
    for (turn, &y) in turns[1].iter_mut().zip(&b.points) {
        *turn = (y - c).dot(of_centre) - middle;
    }
    let (mut rest, mut size) = (0.0, 0.0);
    for (i, &x) in a.points.iter().enumerate() {
        let normal = normal(x);
        let own = (d - x).dot(normal);
        turns[0][i] = own;
        let mut farthest = 0.0;
        for (&y, w) in b.points.iter().zip(&turns[1]) {
            let r = y - x;
            rest = larger(rest, (r.dot(normal) - own - w).abs());
            farthest = larger(farthest, r.length_squared());
        }
        size = larger(size, farthest * (to - x).length_squared() * (from - x).length_squared());
    }
    let off = 65.0 * f64::EPSILON * size.sqrt() + f64::MIN_POSITIVE;
    let rest = mutant!("factors.edge-rest", rest + off, |rest| 0.1 * rest);
    if !rest.is_finite() {
        return [0.0, 1.0];
    }
    let first = Shares::new(a, &turns[0][..a.points.len()]);
    let second = Shares::new(b, &turns[1][..b.points.len()]);
    let [narrow, wide] = if first.reach() < second.reach() { [&first, &second] } else { [&second, &first] };
    let [below, above] = [-rest, rest].map(|value| narrow.sum_below(wide, value));
    [larger(below - ROUNDING, 0.0), smaller(above + ROUNDING, 1.0)]
}

/// Over what share of a cell an affine function is below a value.
struct Shares<'a> {
    triangles: [Triangle; MOST_CORNERS],
    count: usize,
    /// Its values at the corners: between two next ones the share is a polynomial of degree 2.
    values: &'a [f64],
    range: [f64; 2],
}

/// An affine function on a triangle.
#[derive(Debug, Clone, Copy, Default)]
struct Triangle {
    /// The least of its values at corners, and one over their range: finite.
    low: f64,
    scale: f64,
    /// The place of the middle one, from 0 to 1 of the range.
    middle: f64,
    /// The share of the triangle.
    share: f64,
}

impl Triangle {
    fn below(&self, value: f64) -> f64 {
        let place = (value - self.low) * self.scale;
        if place <= 0.0 {
            0.0
        } else if place >= 1.0 {
            self.share
        } else if place <= self.middle {
            self.share * place * (place / self.middle)
        } else {
            self.share * (1.0 - (1.0 - place) * ((1.0 - place) / (1.0 - self.middle)))
        }
    }

    fn density(&self, value: f64) -> f64 {
        let place = (value - self.low) * self.scale;
        let height = if place <= 0.0 || place >= 1.0 {
            0.0
        } else if place <= self.middle {
            place / self.middle
        } else {
            (1.0 - place) / (1.0 - self.middle)
        };
        2.0 * self.share * self.scale * height
    }
}

impl<'a> Shares<'a> {
    /// Of at most [`MOST_CORNERS`] corners.
    fn new(cell: &Cell, values: &'a [f64]) -> Self {
        let points = &cell.points;
        let mut whole = 0.0;
        let mut triangles = [Triangle::default(); MOST_CORNERS];
        let count = points.len() - 2;
        for (k, triangle) in triangles[..count].iter_mut().enumerate() {
            let area = (points[k + 1] - points[0]).cross(points[k + 2] - points[0]).length();
            let mut corners = [values[0], values[k + 1], values[k + 2]];
            corners.sort_unstable_by(f64::total_cmp);
            let [low, middle, high] = corners;
            // A range of hardly any width is a step.
            let scale = 1.0 / larger(high - low, 1e-300);
            *triangle = Triangle { low, scale, middle: (middle - low) * scale, share: area };
            whole += area;
        }
        triangles[..count].iter_mut().for_each(|triangle| triangle.share /= whole);
        let range = values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &v| [smaller(low, v), larger(high, v)]);
        Self { triangles, count, values, range }
    }

    fn reach(&self) -> f64 {
        self.range[1] - self.range[0]
    }

    fn below(&self, value: f64) -> f64 {
        self.triangles[..self.count].iter().map(|triangle| triangle.below(value)).sum()
    }

    fn density(&self, value: f64) -> f64 {
        self.triangles[..self.count].iter().map(|triangle| triangle.density(value)).sum()
    }

    /// The share of pairs over which the sum of this function and one that reaches as far is below a value: between two knots the density of the
    /// one times the share of the other is of degree 3, for which Gauss' rule of two nodes is exact.
    fn sum_below(&self, wide: &Self, value: f64) -> f64 {
        let ([least, most], [low, high]) = (wide.range, self.range);
        if value - high >= most {
            return 1.0;
        }
        if value - low <= least {
            return 0.0;
        }
        // Below this all of this one counts, above the end nothing.
        let (start, end) = (larger(value - high, least), smaller(value - low, most));
        let mut sum = if start > least { wide.below(start) } else { 0.0 };
        let mut knots = [end; 2 * MOST_CORNERS + 2];
        knots[0] = start;
        let mut count = 1;
        for knot in wide.values.iter().copied().chain(self.values.iter().map(|knot| value - knot)) {
            if knot > start && knot < end {
                knots[count] = knot;
                count += 1;
            }
        }
        knots[..count].sort_unstable_by(f64::total_cmp);
        for piece in knots[..=count].windows(2) {
            let (half, middle) = (0.5 * (piece[1] - piece[0]), 0.5 * (piece[0] + piece[1]));
            if half > 0.0 {
                let at = |w: f64| wide.density(w) * self.below(value - w);
                sum += half * (at(middle - NODE * half) + at(middle + NODE * half));
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use radgrad_core::{Emission, Emitter, Polygon, Receiver, evaluate};

    use super::*;
    use crate::factors::exchange::exchange_parts;
    use crate::factors::rule::{nodes_of, patches};
    use crate::factors::tests::draws;

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
