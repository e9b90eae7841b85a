//! `A_i F_ij = int f dA`, over the smaller of two outlines, f the form factor from its points to the other: for slivers and for specks beside large
//! faces, of which the sum over edges leaves roundings of the large one.
//!
//! The closed form of f at a point, and the bound on its rounding, are those of core. The outline is divided into triangles, each a
//! square of two variables, so that areas are known however thin they are. Product Gauss rules integrate over cells of the square. With the other outline all in front, `f = (1/2 pi) sum over edges e of int n.(r x e)/r.r dt`,
//! analytic in x where `r.r` vanishes on no edge: that what is near is its inside does no harm.
//!
//! Let D be a lower bound of the distance of a cell from those edges, and a place be complex and off a point of the cell by at most `0.35 D`. With d
//! this difference, `r.r = p.p + 2 p.d + d.d` for a real p of length at least D, so that `|r.r| >= 0.177 |p|^2` and `|r| <= 1.35 |p|`; and `int |e| dt/|p| <=
//! 2 (1 + ln(1 + |e|/2D))`. So `|f| <= 2.43 sum (1 + ln(1 + |e|/2D)) =: M`. A cell of half-length m in one of its variables is so near itself for all of
//! the Bernstein ellipse of `R - 1/R = 0.7 D/m`; its Jacobian, affine and not negative on [-1, 1], grows there by a factor of at most `1 + (R + 1/R)/2` over its mean. In
//! each variable the rule of n nodes errs by at most `(32/15) M R^(-2n) / (1 - R^-2)` of that ([`super::far`]).
//!
//! The largest of the cells that no rule serves is halved next. What is left in the end exchanges between nothing and its area: its
//! share of the value is what its middle sees.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, Tolerance, evaluate_value};

use super::areas::{Exchange, ROUNDOFF};
use super::skew::segments_apart;
use crate::extremes::{largest as larger, smallest as smaller};
use crate::factors::rule::{gauss_legendre, patches};

/// Nodes to try in each variable.
const NODES: [usize; 6] = [2, 3, 4, 6, 10, 16];

/// How far an integration goes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Goal {
    /// Error over the area that is small enough.
    pub(super) error: f64,
    pub(super) most_points: usize,
}

/// What two outlines exchange, each in front of the other, in coordinates up to 1; `None` where core does not take one for a polygon. The first one's
/// points look.
pub(super) fn exchange([own, other]: [&[DVec3]; 2], normal: DVec3, goal: Goal) -> Option<Exchange> {
    let emitter = Emitter::new(Polygon::new(other.to_vec()).ok()?, Emission::Constant(1.0)).ok()?;
    let edges = (0..other.len()).map(|k| [other[k], other[(k + 1) % other.len()]]).collect();
    let seen = Seen { emitter, normal, edges };
    let whole = patches(own).iter().flat_map(|patch| in_triangles(patch.outline())).map(Cell::new).collect::<Option<Vec<_>>>()?;
    let mut left: f64 = whole.iter().map(Cell::area).sum();
    // What triangles leave out of the outline, or count twice.
    let missed = (Polygon::new(own.to_vec()).ok()?.area() - left).abs();
    let (mut open, mut found, mut points) = (BinaryHeap::from(whole), Exchange { area: 0.0, error: missed }, 0);
    let allowed = goal.error * left;
    let mut undecided = Vec::new();
    while left > allowed
        && let Some(cell) = open.pop()
    {
        match seen.rule(&cell, goal.error) {
            _ if points >= goal.most_points => {
                undecided.push(cell);
                break;
            }
            Rule::Nodes(nodes, truncation) => {
                points += nodes[0] * nodes[1];
                left -= cell.area();
                let part = seen.integral(&cell, nodes)?;
                found.area += part.area;
                found.error += part.error + truncation * cell.area() + ROUNDOFF * found.area;
            }
            Rule::Halve(direction) => {
                points += 1;
                open.extend(cell.halves(direction));
            }
        }
    }
    for cell in open.iter().chain(&undecided) {
        let value = cell.area() * smaller(seen.factor(cell.at(0.5, 0.5))?[0], 1.0);
        found.area += value;
        found.error += larger(value, cell.area() - value) + ROUNDOFF * found.area;
    }
    Some(Exchange { error: (found.error + 32.0 * ROUNDOFF * found.area) * 1.01, ..found })
}

/// An outline, as triangles, each with its shortest edge first.
fn in_triangles(outline: &[DVec3]) -> impl Iterator<Item = [DVec3; 3]> {
    (2..outline.len()).map(|k| {
        let [a, b, c] = [outline[0], outline[k - 1], outline[k]];
        let turned = [[a, b, c], [b, c, a], [c, a, b]];
        let length = |[a, b, _]: [DVec3; 3]| (b - a).length_squared();
        turned.into_iter().fold(turned[0], |least, next| if length(next) < length(least) { next } else { least })
    })
}

/// The part of an outline that points see.
struct Seen {
    emitter: Emitter,
    /// Of the plane of the points.
    normal: DVec3,
    edges: Vec<[DVec3; 2]>,
}

/// What to do with a cell.
enum Rule {
    /// Integrate with so many nodes, and this truncation over the area.
    Nodes([usize; 2], f64),
    /// Halve it in this variable.
    Halve(usize),
}

impl Seen {
    /// The factor from a point, and its error.
    fn factor(&self, point: DVec3) -> Option<[f64; 2]> {
        let receiver = Receiver::new(point, self.normal, 1.0).ok()?;
        let value = evaluate_value(&receiver, &self.emitter, [], Tolerance { relative: 1e-14, absolute: 1e-15 }).ok()?;
        Some([value.radiosity, value.radiosity_error])
    }

    fn rule(&self, cell: &Cell, allowed: f64) -> Rule {
        let distance = self.distance(cell);
        let most = self.most(distance);
        let halves = cell.halves_of_lengths();
        let nodes = halves.map(|half| {
            let within = 0.35 * distance / half;
            let radius = within + (within * within + 1.0).sqrt();
            let growth = 1.0 + 0.5 * (radius + 1.0 / radius);
            let bound = |nodes: usize| {
                let power = (0..nodes).fold(1.0, |power, _| power / (radius * radius));
                32.0 / 15.0 * most * growth * power / (1.0 - 1.0 / (radius * radius)) * 1.01
            };
            NODES.into_iter().map(|nodes| (nodes, bound(nodes))).find(|(_, bound)| *bound <= 0.5 * allowed)
        });
        match nodes {
            [Some((u, off_u)), Some((v, off_v))] => Rule::Nodes([u, v], off_u + off_v),
            _ => Rule::Halve(usize::from(halves[1] > halves[0])),
        }
    }

    /// M at this distance from the edges.
    fn most(&self, distance: f64) -> f64 {
        self.edges.iter().map(|[a, b]| 2.43 * (1.0 + libm::log1p((*b - *a).length() / (2.0 * distance)))).sum()
    }

    /// A bound from below on the distance of a cell from the edges.
    fn distance(&self, cell: &Cell) -> f64 {
        let corners = cell.corners();
        let sides = [0, 1, 2, 3].map(|k| [corners[k], corners[(k + 1) % 4]]);
        let mut least = f64::INFINITY;
        for edge in &self.edges {
            for side in sides.iter().filter(|[a, b]| a != b) {
                least = smaller(least, segments_apart(*side, *edge) * (1.0 - 1e-9));
            }
            // An end over the inside is nearest to that; roundings may put it there.
            for &end in edge {
                let turn = |[a, b]: [DVec3; 2]| self.normal.dot((b - a).cross(end - a)) >= -1e-12 * (b - a).length();
                if sides.iter().all(|&side| turn(side)) {
                    least = smaller(least, self.normal.dot(end - corners[0]).abs());
                }
            }
        }
        larger(least - 32.0 * ROUNDOFF, 0.0)
    }

    fn integral(&self, cell: &Cell, [nodes_u, nodes_v]: [usize; 2]) -> Option<Exchange> {
        let mut found = Exchange::default();
        for &(v, weight_v) in gauss_legendre(nodes_v) {
            for &(u, weight_u) in gauss_legendre(nodes_u) {
                let (u, v) = (0.5 + 0.5 * u, 0.5 + 0.5 * v);
                let [value, error] = self.factor(cell.at(u, v))?;
                let share = 0.25 * weight_u * weight_v * cell.density(v);
                found.area += share * value;
                found.error += share * (error + 32.0 * ROUNDOFF * value);
            }
        }
        // Places and the normal are off by roundings of coordinates up to 1.
        let distance = self.distance(cell);
        let moved = 8.0 * ROUNDOFF * (1.0 + self.most(distance) / (0.35 * distance));
        Some(Exchange { error: found.error + moved * cell.area(), ..found })
    }
}

/// A part of a triangle: from u along the first edge, and from v towards its last corner.
#[derive(Debug, Clone, Copy)]
struct Cell {
    triangle: [DVec3; 3],
    of_triangle: f64,
    low: [f64; 2],
    size: [f64; 2],
}

impl Cell {
    /// All of a triangle, if it is one.
    fn new(triangle: [DVec3; 3]) -> Option<Self> {
        let area = Polygon::new(triangle.to_vec()).ok()?.area();
        Some(Self { triangle, of_triangle: area, low: [0.0; 2], size: [1.0; 2] })
    }

    fn at(&self, u: f64, v: f64) -> DVec3 {
        let [a, b, c] = self.triangle;
        let [u, v] = [self.low[0] + u * self.size[0], self.low[1] + v * self.size[1]];
        let along = a + (b - a) * u;
        along + (c - along) * v
    }

    /// The area for a unit of both variables.
    fn density(&self, v: f64) -> f64 {
        2.0 * self.of_triangle * self.size[0] * self.size[1] * (1.0 - self.low[1] - v * self.size[1])
    }

    fn area(&self) -> f64 {
        self.density(0.5)
    }

    fn corners(&self) -> [DVec3; 4] {
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[u, v]| self.at(u, v))
    }

    /// Bounds on half of its length in each variable.
    fn halves_of_lengths(&self) -> [f64; 2] {
        let [a, b, c] = self.triangle;
        let [along, across] = [(b - a).length() * (1.0 - self.low[1]), larger((c - a).length(), (c - b).length())];
        [0.5 * along * self.size[0], 0.5 * across * self.size[1]].map(|half| half * (1.0 + 1e-12))
    }

    fn halves(&self, direction: usize) -> [Self; 2] {
        let mut halves = [*self; 2];
        let half = 0.5 * self.size[direction];
        for part in &mut halves {
            part.size[direction] = half;
        }
        halves[1].low[direction] += half;
        halves
    }
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Cell {}

impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Cell {
    fn cmp(&self, other: &Self) -> Ordering {
        self.area().total_cmp(&other.area())
    }
}
