//! The exchange that passes edges of screens, between two cells whose every segment is inside the other edges of these screens.
//!
//! A segment from x to y passes outside the edge where T(x, y) < 0 ([`crate::factors::screen`]), and T is affine in x and in y. With
//! c and d points of the two cells, `T(x, y) = T(x, d) + T(c, y) - T(c, d) + m(x, y)`, where m is largest at corners, since it is affine
//! in each as well: `|m| <= t`. So the share v of all pairs (x, y) that are outside is between those of pairs with `T(x, d) + T(c, y) -
//! T(c, d)` below -t and below t; a sum of two functions, of which it is known for either cell over what share it is below a value. In
//! slices of the second cell of equal T, the first one's share is between those at the two ends.
//!
//! Let the kernel k be between `k0 - e` and `k0 + e` on all pairs, E their exchange with nothing in between, and W the product of
//! the areas. The part that passes is `int k [T < 0] = v E + int (k - k0) ([T < 0] - v)`, and `int |[T < 0] - v| = 2 v (1 - v)
//! W`: so it is `v E` to within `2 e v (1 - v) W`. Both the uncertainty of v and e are in proportion to the size of the cells
//! over their distance. So the undecided part is E times that ratio; without this rule it would be all of E. Where k varies too much for
//! that, the part that passes is between `v W` times the least and times the largest kernel all the same, and so is the part that does
//! not: the better of the three counts.
//!
//! A shadow is what is inside all of some edges. It is at most what is inside any one of them, and at least all but the sum of what is
//! outside each. What all shadows hide is at least what any of them does, and at most the sum.

use radgrad_core::{DVec3, mutant};

use super::cell::{Cell, Plane};
use crate::factors::exchange::Exchange;
use crate::factors::{larger, smaller};

/// Slices of the second cell.
const SLICES: u32 = 16;

/// Relative rounding of shares, areas and kernels: a few dozen operations.
const ROUNDING: f64 = 1e-12;

/// A kernel that varies by more than this over its least value says too little for what the exchange of so near cells costs.
const USEFUL: f64 = 12.0;

/// Lower bounds on the exchange of two cells that passes an edge, and on the part that the screen hides.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Passing {
    pub(super) seen: f64,
    pub(super) hidden: f64,
}

/// Bounds on the exchange that passes some shadows, each given by its edges, which run counter-clockwise around their screens seen from
/// the first cell. `is_all` says that nothing else hides anything. `whole` computes the cells' exchange with nothing in between; it is
/// called, and its result returned, unless the cells are so near each other that the bounds would be empty.
pub(super) fn passing(
    cells: [&Cell; 2],
    planes: [&Plane; 2],
    shadows: &[Vec<[DVec3; 2]>],
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
    for shadow in shadows {
        let (mut inside, mut outside, mut least) = (whole.most(), 0.0, 0.0);
        for &edge in shadow {
            let beside = Beside::of(cells, share_outside(cells, edge), kernel, whole);
            inside = smaller(inside, beside.inside[1]);
            outside += beside.outside;
            least = beside.inside[0];
        }
        // Hidden is what any of them hides, seen what none does.
        found.hidden = larger(found.hidden, if shadow.len() == 1 { least } else { whole.least() - outside });
        found.seen -= inside;
    }
    found.seen = larger(found.seen, 0.0);
    Some((found, whole))
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
        // v (1 - v) is largest at a half.
        let v = if below > 0.5 {
            below
        } else if above < 0.5 {
            above
        } else {
            0.5
        };
        let off = mutant!(
            "factors.edge-off",
            (most - least) * v * (1.0 - v) * product * (1.0 + ROUNDING) + ROUNDING * whole.most(),
            |off| 0.1 * off
        );
        // At most a share of it all, by the mean and by the extremes of the kernel.
        let at_most = |share: f64| {
            let by_kernel = smaller(most * share, (whole.most() / product) * (1.0 + ROUNDING) - least * (1.0 - share)) * product;
            smaller(share * whole.most() + off, by_kernel + ROUNDING * (whole.most() + most * share * product))
        };
        let [inside, outside] = [at_most(1.0 - below), at_most(above)];
        let by_mean = (1.0 - above) * whole.least() - off;
        Self { inside: [larger(by_mean, whole.least() - outside), inside], outside }
    }
}

/// Bounds on the kernel `(n1.r) (-n2.r) / (pi r^4)` of all pairs of points: `n1.r` and `n2.r` are affine in each, `r.r` is convex.
fn kernel([a, b]: [&Cell; 2], planes: [&Plane; 2]) -> Option<[f64; 2]> {
    let centres = [a, b].map(Cell::centre);
    let radius = |cell: &Cell, centre: DVec3| cell.points.iter().map(|&p| (p - centre).length()).fold(0.0, larger);
    let between = centres[1] - centres[0];
    let along = between.normalize_or_zero();
    let apart = between.length() - radius(a, centres[0]) - radius(b, centres[1]);
    let (mut rise, mut fall, mut farthest) = ([f64::INFINITY, 0.0], [f64::INFINITY, 0.0], 0.0);
    let mut ahead = f64::INFINITY;
    for &x in &a.points {
        for &y in &b.points {
            let r = y - x;
            let (up, down) = (planes[0].normal.dot(r), -planes[1].normal.dot(r));
            rise = [smaller(rise[0], up), larger(rise[1], up)];
            fall = [smaller(fall[0], down), larger(fall[1], down)];
            farthest = larger(farthest, r.length_squared());
            ahead = smaller(ahead, along.dot(r));
        }
    }
    // The distance along any direction is a lower bound, but for roundings of coordinates up to 1.
    let nearest = larger(larger(apart, ahead), larger(rise[0], fall[0])) * (1.0 - ROUNDING) - 16.0 * f64::EPSILON;
    if nearest <= 0.0 || nearest.is_nan() {
        return None;
    }
    let near = nearest * nearest;
    let least = larger(rise[0], 0.0) * larger(fall[0], 0.0) / (std::f64::consts::PI * farthest * farthest);
    let largest = 1.0 / (std::f64::consts::PI * near);
    let most = smaller(rise[1] * fall[1] / near, 1.0) * largest;
    // Heights over the planes err by roundings of distances, however low they are.
    Some([larger(least - ROUNDING * largest, 0.0), most + ROUNDING * largest])
}

/// Bounds on the share of all pairs whose segment passes outside the edge.
fn share_outside([a, b]: [&Cell; 2], [from, to]: [DVec3; 2]) -> [f64; 2] {
    let turn = |x: DVec3, y: DVec3| (y - x).dot(mutant!("factors.edge-sign", (to - x).cross(from - x), |normal: DVec3| -normal));
    let (c, d) = (a.centre(), b.centre());
    let middle = turn(c, d);
    let first: Vec<f64> = a.points.iter().map(|&x| turn(x, d)).collect();
    let second: Vec<f64> = b.points.iter().map(|&y| turn(c, y) - middle).collect();
    let (mut rest, mut size) = (0.0, 0.0);
    for (&x, u) in a.points.iter().zip(&first) {
        for (&y, w) in b.points.iter().zip(&second) {
            rest = larger(rest, (turn(x, y) - u - w).abs());
            size = larger(size, (y - x).length() * (to - x).length() * (from - x).length());
        }
    }
    let rest = mutant!("factors.edge-rest", rest + 64.0 * f64::EPSILON * size, |rest| 0.1 * rest);
    let (first, second) = (Shares::new(a, &first), Shares::new(b, &second));
    let [low, high] = second.range;
    let (mut below, mut above) = (0.0, 0.0);
    let mut start = (low, 0.0);
    for slice in 1..=SLICES {
        let place = if slice == SLICES { high } else { low + (high - low) * f64::from(slice) / f64::from(SLICES) };
        let end = (place, if slice == SLICES { 1.0 } else { second.below(place) });
        let share = end.1 - start.1;
        below += share * first.below(-rest - end.0);
        above += share * first.below(rest - start.0);
        start = end;
    }
    [larger(below - ROUNDING, 0.0), smaller(above + ROUNDING, 1.0)]
}

/// Over what share of a cell an affine function is below a value.
struct Shares {
    /// Triangles: the values at their corners, ascending, and their share.
    triangles: Vec<([f64; 3], f64)>,
    range: [f64; 2],
}

impl Shares {
    fn new(cell: &Cell, values: &[f64]) -> Self {
        let points = &cell.points;
        let mut whole = 0.0;
        let mut triangles = Vec::with_capacity(points.len());
        for i in 2..points.len() {
            let area = (points[i - 1] - points[0]).cross(points[i] - points[0]).length();
            let mut corners = [values[0], values[i - 1], values[i]];
            corners.sort_unstable_by(f64::total_cmp);
            whole += area;
            triangles.push((corners, area));
        }
        triangles.iter_mut().for_each(|(_, area)| *area /= whole);
        let range = values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &v| [smaller(low, v), larger(high, v)]);
        Self { triangles, range }
    }

    fn below(&self, value: f64) -> f64 {
        let of = |&([low, middle, high], share): &([f64; 3], f64)| {
            if value <= low {
                0.0
            } else if value >= high {
                share
            } else if value <= middle {
                share * ((value - low) / (middle - low)) * ((value - low) / (high - low))
            } else {
                share * (1.0 - ((high - value) / (high - low)) * ((high - value) / (high - middle)))
            }
        };
        self.triangles.iter().map(of).sum()
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
            let Some((found, _)) = passing(cells, [&planes[0], &planes[1]], &[vec![edge]], true, whole) else { continue };
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
