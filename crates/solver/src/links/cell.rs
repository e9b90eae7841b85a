//! Quadrature of the kernel over cells of an element: Gauss rules with an a-priori bound, on smaller cells where it is near.
//!
//! The integrand, continued to complex coordinates along one side of a cell at a time, is at most M inside a Bernstein ellipse
//! of parameter R, so that n nodes leave `(32/15) M R^{-2(n-1)} / (1 - R^{-2})` of the mean a side (L. N. Trefethen 2008, Theorem
//! 4.5). There `|r.r| >= d^2 - tau^2 b^2` with b half the side, tau the ellipse's smaller semi-axis and d the distance of the
//! stretched cell; `n2.r` is the same all over it; and a polynomial of degree m grows by `R^m` at most. A cell for which no
//! rule at hand does is divided into four.

use std::sync::LazyLock;

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, f64x4};
use radgrad_core::DVec3;
use radgrad_numbers::lanes::vectors::number_plus_first;
use radgrad_numbers::on_instruction_set;
use radgrad_scene::{largest, smallest};

use crate::links::station::Station;
use crate::links::visible::VisiblePart;
use crate::mesh::basis::{Basis, MAX_DEGREE};
use crate::mesh::element::Element;
use crate::mesh::rule::{self, Node};
use crate::mesh::shape::{Shape, in_parent};

/// The best instruction set of this machine; here as in core, where it is used.
static INSTRUCTION_SET: LazyLock<Level> = LazyLock::new(Level::new);

const FEWEST: usize = 2;
const MOST: usize = 10;

/// Parameters of the ellipses that are tried, and `R^{-2(n - 1)}` of each by the number of nodes n.
const RATIOS: [f64; 9] = [1.5, 2.0, 2.7, 3.6, 5.0, 7.0, 10.0, 16.0, 30.0];
const FALLS: [[f64; MOST + 1]; RATIOS.len()] = falls();

const fn falls() -> [[f64; MOST + 1]; RATIOS.len()] {
    let (mut falls, mut row) = ([[1.0; MOST + 1]; RATIOS.len()], 0);
    while row < RATIOS.len() {
        let mut nodes = 2;
        while nodes <= MOST {
            falls[row][nodes] = falls[row][nodes - 1] / (RATIOS[row] * RATIOS[row]);
            nodes += 1;
        }
        row += 1;
    }
    falls
}

/// Largest error of a function over that of the first, the form factor: the radiosity of elements varies less over them than it is.
const ROUGHER: f64 = 20.0;

/// How often a cell is divided before the closed forms have to answer. They cost as much as hundreds of nodes: rules need about as
/// many near by for few digits, and more for many.
fn deepest(tolerance: f64) -> u32 {
    if tolerance < 1e-10 { 4 } else { 8 }
}

/// Four nodes of a rule, one a lane; the last of a rule may have no weight.
#[derive(Debug)]
struct FourNodes {
    a: [f64; 4],
    b: [f64; 4],
    weight: [f64; 4],
}

impl FourNodes {
    fn new(nodes: &[Node]) -> Self {
        let four = [0, 1, 2, 3].map(|i| nodes.get(i).copied().unwrap_or(Node { weight: 0.0, ..nodes[0] }));
        Self { a: four.map(|node| node.at[0]), b: four.map(|node| node.at[1]), weight: four.map(|node| node.weight) }
    }
}

/// Product rules and their images on the triangle, by the number of nodes a side.
#[derive(Debug)]
pub(crate) struct Rules([Vec<Vec<FourNodes>>; 2]);

impl Rules {
    pub(crate) fn new() -> Self {
        let fours = |rule: Vec<Node>| rule.chunks(4).map(FourNodes::new).collect();
        let by_count = |rule: fn(usize) -> Vec<Node>| (0..=MOST).map(|count| fours(rule(count.max(1)))).collect();
        Self([by_count(rule::product), by_count(rule::collapsed)])
    }
}

/// A parallelogram or a triangle in an element: its first corner and two sides, in the element's coordinates.
#[derive(Debug, Clone, Copy)]
struct Cell {
    origin: [f64; 2],
    sides: [[f64; 2]; 2],
    shape: Shape,
}

impl Cell {
    fn reference(&self, [a, b]: [f64; 2]) -> [f64; 2] {
        let [u, v] = self.sides;
        [self.origin[0] + a * u[0] + b * v[0], self.origin[1] + a * u[1] + b * v[1]]
    }

    /// Its four quarters, or two halves of a long parallelogram, whose sides have these squares.
    fn divided(&self, along: f64, across: f64) -> [Option<Self>; 4] {
        let [u, v] = self.sides;
        if self.shape == Shape::Parallelogram && largest(along, across) > 4.0 * smallest(along, across) {
            let halved = |side: [f64; 2]| side.map(|c| 0.5 * c);
            let sides = if along > across { [halved(u), v] } else { [u, halved(v)] };
            let other = self.reference(if along > across { [0.5, 0.0] } else { [0.0, 0.5] });
            return [Some(Self { sides, ..*self }), Some(Self { sides, origin: other, ..*self }), None, None];
        }
        let child = |which: usize| {
            let turned = if self.shape == Shape::Triangle && which == 3 { -0.5 } else { 0.5 };
            let sides = self.sides.map(|side| side.map(|c| turned * c));
            Some(Self { origin: self.reference(in_parent(self.shape, which, [0.0, 0.0])), sides, shape: self.shape })
        };
        [0, 1, 2, 3].map(child)
    }
}

/// Sums of the kernel times monomials over an element, from a point.
#[derive(Debug)]
pub(crate) struct KernelSums<'a> {
    station: &'a Station,
    element: &'a Element,
    basis: &'a Basis,
    rules: &'a Rules,
    /// Height of the point over the element's plane.
    height: f64,
    largest: f64,
    /// Whether all cells are of the element's own shape.
    whole: bool,
    /// Moments of the kernel, one for each function.
    pub(crate) moments: Vec<f64>,
    /// Bound on the rounding of the kernel's integral: a function's value has as much for each of its monomials, times their coefficients.
    rounding: f64,
    /// Bound on the error of each function's value, but for rounding, over [`ROUGHER`] but for the first.
    error: f64,
    /// Mean square of the kernel times the area, where it is seen, at most.
    pub(crate) square: f64,
    /// Bounds on the error of a function by its degree along a side, over its largest value.
    errors: [f64; 2 * (MAX_DEGREE + 1) + 1],
}

/// The kernel over a cell, seen from a point: `n1.r` is linear in the coordinates of a rule, and `r.r` quadratic.
struct KernelOverCell {
    /// Offset of the cell's first corner, and its sides.
    first: DVec3,
    along: DVec3,
    across: DVec3,
    /// n1 along them.
    above: [f64; 3],
    /// The element's area times the height over its plane and `1/pi`, and the cell's share in it.
    area: f64,
    share: f64,
}

impl KernelOverCell {
    /// Sums over the nodes of a rule, of the kernel times `s^i t^j` in row j, and of its square.
    #[inline(always)]
    fn sums<S: Simd, const N: usize>(&self, simd: S, cell: &Cell, rule: &[FourNodes]) -> ([[f64; N]; N], f64) {
        let Self { first, along, across, above, area, share } = *self;
        let [[s_along, t_along], [s_across, t_across]] = cell.sides;
        let zero = f64x4::splat(simd, 0.0);
        let (mut sums, mut square) = ([[zero; N]; N], zero);
        for four in rule {
            let (a, b) = (f64x4::load_array(simd, four.a), f64x4::load_array(simd, four.b));
            let (x, y, z) = (
                a * along.x + b * across.x + first.x,
                a * along.y + b * across.y + first.y,
                a * along.z + b * across.z + first.z,
            );
            let inverse = f64x4::splat(simd, 1.0) / (x * x + y * y + z * z);
            let density = inverse * area * inverse * (a * above[1] + b * above[2] + above[0]);
            let mut of_row = f64x4::load_array(simd, four.weight) * share * density;
            square += of_row * density;
            let s = a * s_along + b * s_across + cell.origin[0];
            let t = a * t_along + b * t_across + cell.origin[1];
            for row in &mut sums {
                let mut product = of_row;
                for sum in row {
                    *sum += product;
                    product *= s;
                }
                of_row *= t;
            }
        }
        let mut totals = [[0.0; N]; N];
        for (row, sums) in totals.iter_mut().zip(&sums) {
            for (sum, lanes) in row.iter_mut().zip(sums) {
                *sum = number_plus_first(0.0, *lanes, 4);
            }
        }
        (totals, number_plus_first(0.0, square, 4))
    }
}

/// A rule that does for a cell.
#[derive(Debug, Clone, Copy)]
struct Enough {
    /// Nodes a side.
    nodes: usize,
    /// Bound on the error of the functions' values, and of the kernel's integral; and on the rounding of that.
    bound: f64,
    unit: f64,
    rounding: f64,
    /// The ellipse's parameter, and the largest kernel times the area there.
    ratio: f64,
    most: f64,
}

impl<'a> KernelSums<'a> {
    pub(crate) fn new(station: &'a Station, element: &'a Element, basis: &'a Basis, count: usize, rules: &'a Rules) -> Self {
        let height = element.polygon().normal().dot(station.point - element.polygon().vertices()[0]);
        Self {
            station,
            element,
            basis,
            rules,
            height,
            largest: basis.largest(),
            whole: true,
            moments: vec![0.0; count],
            rounding: 0.0,
            error: 0.0,
            square: 0.0,
            errors: [0.0; 2 * (MAX_DEGREE + 1) + 1],
        }
    }

    /// Adds all of the element, to a tolerance. Returns whether it could.
    pub(crate) fn add_whole(&mut self, tolerance: f64) -> bool {
        let cell = Cell { origin: [0.0; 2], sides: [[1.0, 0.0], [0.0, 1.0]], shape: self.element.shape() };
        self.height > 0.0 && self.add(&cell, tolerance, deepest(tolerance))
    }

    /// Adds a convex part.
    pub(crate) fn add_part(&mut self, part: &VisiblePart, tolerance: f64) -> bool {
        let c = part.corners();
        let to = |i: usize| [c[i][0] - c[0][0], c[i][1] - c[0][1]];
        let cells = (1..c.len() - 1).map(|i| Cell { origin: c[0], sides: [to(i), to(i + 1)], shape: Shape::Triangle });
        let cells: Vec<Cell> = cells.collect();
        let tolerance = tolerance / cells.len() as f64;
        self.whole = false;
        self.height > 0.0 && cells.iter().all(|cell| self.add(cell, tolerance, deepest(tolerance)))
    }

    fn add(&mut self, cell: &Cell, tolerance: f64, depth: u32) -> bool {
        let [u, v] = self.element.axes();
        let [[s_along, t_along], [s_across, t_across]] = cell.sides;
        let (along, across) = (u * s_along + v * t_along, u * s_across + v * t_across);
        let first = self.element.point(cell.origin) - self.station.point;
        let det = (cell.sides[0][0] * cell.sides[1][1] - cell.sides[0][1] * cell.sides[1][0]).abs();
        let share = match (cell.shape, self.element.shape()) {
            (Shape::Triangle, Shape::Parallelogram) => 0.5 * det,
            _ => det,
        };
        let Some(rule) = self.nodes(cell.shape, first, [along, across], share, tolerance) else {
            let parts = cell.divided(along.length_squared(), across.length_squared());
            return depth > 0 && parts.iter().flatten().all(|part| self.add(part, 0.5 * tolerance, depth - 1));
        };
        self.error += rule.bound;
        self.rounding += rule.rounding;
        self.square += (rule.unit + rule.rounding) * rule.most;
        let mut grown = rule.unit;
        for error in &mut self.errors {
            *error += grown;
            grown *= rule.ratio;
        }
        match if self.moments.len() == 1 { 0 } else { self.basis.degree() } {
            0 => self.sum::<1>(cell, first, [along, across], share, rule.nodes),
            1 => self.sum::<2>(cell, first, [along, across], share, rule.nodes),
            2 => self.sum::<3>(cell, first, [along, across], share, rule.nodes),
            3 => self.sum::<4>(cell, first, [along, across], share, rule.nodes),
            MAX_DEGREE => self.sum::<{ MAX_DEGREE + 1 }>(cell, first, [along, across], share, rule.nodes),
            _ => self.sum::<{ MAX_DEGREE + 2 }>(cell, first, [along, across], share, rule.nodes),
        }
        true
    }

    /// Adds the sums over a cell, of monomials with less than N powers a side.
    fn sum<const N: usize>(&mut self, cell: &Cell, first: DVec3, [along, across]: [DVec3; 2], share: f64, nodes: usize) {
        let above = [first, along, across].map(|side| self.station.normal.dot(side));
        let area = self.element.area() / std::f64::consts::PI * self.height;
        let kernel = KernelOverCell { first, along, across, above, area, share };
        let rule = &self.rules.0[usize::from(cell.shape == Shape::Triangle)][nodes];
        let (sums, square) = on_instruction_set!(*INSTRUCTION_SET, simd => kernel.sums::<_, N>(simd, cell, rule));
        self.square += square;
        for (moment, &[i, j]) in self.moments.iter_mut().zip(self.basis.powers()) {
            *moment += sums[j][i];
        }
    }

    /// Distance of the point from a cell.
    fn distance(&self, shape: Shape, first: DVec3, [u, v]: [DVec3; 2]) -> f64 {
        // Coordinates of the foot, by Gram's matrix.
        let [uu, uv, vv] = [u.dot(u), u.dot(v), v.dot(v)];
        let [fu, fv] = [-first.dot(u), -first.dot(v)];
        let det = uu * vv - uv * uv;
        let (a, b) = (fu * vv - fv * uv, fv * uu - fu * uv);
        let inside = match shape {
            Shape::Parallelogram => a >= 0.0 && b >= 0.0 && a <= det && b <= det,
            Shape::Triangle => a >= 0.0 && b >= 0.0 && a + b <= det,
        };
        if inside {
            return self.height * (1.0 - 1e-9);
        }
        let to_edge = |start: DVec3, edge: DVec3, squared: f64| {
            let along = (-start.dot(edge) / squared).clamp(0.0, 1.0);
            (start + edge * along).length_squared()
        };
        let mut least = smallest(to_edge(first, u, uu), to_edge(first, v, vv));
        match shape {
            Shape::Triangle => least = smallest(least, to_edge(first + u, v - u, (v - u).length_squared())),
            Shape::Parallelogram => least = smallest(smallest(least, to_edge(first + v, u, uu)), to_edge(first + u, v, vv)),
        }
        least.sqrt() * (1.0 - 1e-9)
    }

    /// The rule that a cell needs, if there are any of so many nodes.
    fn nodes(&self, shape: Shape, first: DVec3, [u, v]: [DVec3; 2], share: f64, tolerance: f64) -> Option<Enough> {
        let (centre, halves, jacobian) = match shape {
            Shape::Parallelogram => (first + 0.5 * (u + v), [0.5 * u.length(), 0.5 * v.length()], false),
            Shape::Triangle => (first + (u + v) / 3.0, [0.5 * largest(u.length(), (u - v).length()), 0.5 * v.length()], true),
        };
        let radius = match shape {
            Shape::Parallelogram => 0.5 * largest((u + v).length(), (u - v).length()),
            Shape::Triangle => [first, first + u, first + v].iter().map(|p| (*p - centre).length()).fold(0.0, largest),
        };
        let area = self.element.area() / std::f64::consts::PI;
        let distance = centre.length();
        let nearest = self.distance(shape, first, [u, v]);
        if nearest <= 0.25 * radius {
            return None;
        }
        // Across a triangle both coordinates of a square vary.
        let products = shape == Shape::Triangle && self.element.shape() == Shape::Parallelogram;
        let degree = if products { 2 * self.basis.degree() } else { self.basis.degree() };
        let rounding = 64.0 * f64::EPSILON * share * area / (nearest * nearest);
        let mut best: Option<Enough> = None;
        for (ratio, falls) in RATIOS.into_iter().zip(&FALLS) {
            let (major, minor) = (0.5 * (ratio + 1.0 / ratio), 0.5 * (ratio - 1.0 / ratio));
            let grown = if self.moments.len() == 1 { 1.0 } else { largest(self.largest * power(ratio, degree) / ROUGHER, 1.0) };
            let side = |half: f64| {
                let near = nearest - (major - 1.0) * half;
                let squared = near * near - minor * minor * half * half;
                if near <= 0.0 || squared <= 0.0 {
                    return f64::INFINITY;
                }
                let reach = distance + radius + major * half;
                area * reach * self.height / (squared * squared)
            };
            let sides = [side(halves[0]), side(halves[1])];
            // The first side with the Jacobian of the map to a triangle.
            let sum = if jacobian { (1.0 + major) * sides[0] + 2.0 * sides[1] } else { sides[0] + sides[1] };
            // A cell may be a line, of no share in the element.
            let first = 32.0 / 15.0 * grown * (share * sum) / (1.0 - falls[2]);
            if !first.is_finite() {
                break;
            }
            let limit = best.map_or(MOST, |best| best.nodes);
            if first * falls[limit] > tolerance {
                continue;
            }
            let Some(nodes) = (FEWEST..=limit).find(|&nodes| first * falls[nodes] <= tolerance) else { continue };
            let bound = first * falls[nodes];
            if best.is_none_or(|best| nodes < best.nodes || bound < best.bound) {
                best = Some(Enough { nodes, bound, unit: bound / grown, rounding, ratio, most: largest(sides[0], sides[1]) });
            }
        }
        best
    }

    /// Bound on the error of the first function's value, the form factor.
    pub(crate) const fn error(&self) -> f64 {
        self.error + self.rounding
    }

    /// Bound on the error of each of the other functions' values.
    pub(crate) const fn other_errors(&self) -> f64 {
        ROUGHER * self.error + self.basis.conditioning() * self.rounding
    }

    /// Bound on the error of all functions' values together, the root of the sum of squares, with `doubt` for each over its
    /// largest value.
    pub(crate) fn likely_error(&self, doubt: f64) -> f64 {
        let products = self.element.shape() == Shape::Parallelogram;
        let coefficient_error = |(&[i, j], size): (&[usize; 2], &f64)| {
            // Across a triangle both coordinates of a square vary.
            let degree = if products && self.whole { i.max(j) } else { i + j };
            size * (self.errors[degree] + doubt) + self.basis.conditioning() * self.rounding
        };
        self.basis.powers().iter().zip(self.basis.sizes()).map(coefficient_error).map(|e| e * e).sum::<f64>().sqrt()
    }

    /// Values of the functions.
    pub(crate) fn values(&self) -> Vec<f64> {
        self.basis.of_moments(&self.moments)
    }
}

fn power(x: f64, n: usize) -> f64 {
    std::iter::repeat_n(x, n).product()
}
