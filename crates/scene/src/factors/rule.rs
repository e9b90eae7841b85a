//! The points of a receiver that stand for all of it, and Gauss-Legendre rules.

use std::sync::OnceLock;

use radgrad_core::DVec3;

use crate::projection::Projection;
use crate::scene::split::triangles;

/// Most nodes of a rule on an interval.
pub(super) const MOST_NODES: usize = 16;

/// Nodes, ascending, and weights of the Gauss-Legendre rule on [-1, 1]: exact for polynomials of degree `2 nodes - 1`. From 1 to 16
/// nodes; a number outside of that gives the nearer of the two.
///
/// ```
/// let square: f64 = radgrad_scene::gauss_legendre(2).iter().map(|(x, weight)| weight * x * x).sum();
/// assert!((square - 2.0 / 3.0).abs() < 1e-15);
/// ```
#[must_use]
pub fn gauss_legendre(nodes: usize) -> &'static [(f64, f64)] {
    static RULES: OnceLock<Vec<Vec<(f64, f64)>>> = OnceLock::new();
    &RULES.get_or_init(|| (0..=MOST_NODES).map(newton).collect())[nodes.clamp(1, MOST_NODES)]
}

/// The roots of the Legendre polynomial by Newton's method, to a rounding or two.
fn newton(count: usize) -> Vec<(f64, f64)> {
    let n = count as f64;
    let root = |i: usize| {
        let mut x = libm::cos(std::f64::consts::PI * (i as f64 + 0.75) / (n + 0.5));
        let mut slope = 1.0;
        for _ in 0..8 {
            let (mut before, mut here) = (1.0, x);
            for k in 2..=count {
                let k = k as f64;
                (before, here) = (here, ((2.0 * k - 1.0) * x * here - (k - 1.0) * before) / k);
            }
            slope = n * (x * here - before) / (x * x - 1.0);
            x -= here / slope;
        }
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    };
    // The lower half, mirrored: then the rule is exactly symmetric.
    let lower: Vec<(f64, f64)> = (0..count / 2).map(root).collect();
    let middle = if count % 2 == 1 { Some((0.0, root(count / 2).1)) } else { None };
    let negative = lower.iter().map(|&(x, w)| (-x, w));
    negative.chain(middle).chain(lower.iter().rev().copied()).collect()
}

/// A planar part of a polygon that a product rule fits: a triangle or a convex quadrilateral.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Patch {
    /// A triangle has its last corner twice.
    pub(super) corners: [DVec3; 4],
}

/// The patches that a polygon is made of.
pub(super) fn patches(vertices: &[DVec3]) -> Vec<Patch> {
    if let [a, b, c] = *vertices {
        return vec![Patch { corners: [a, b, c, c] }];
    }
    if let [a, b, c, d] = *vertices
        && is_convex(vertices)
    {
        return vec![Patch { corners: [a, b, c, d] }];
    }
    let all = triangles(vertices).unwrap_or_default();
    all.into_iter().map(|[a, b, c]| Patch { corners: [vertices[a], vertices[b], vertices[c], vertices[c]] }).collect()
}

fn is_convex(vertices: &[DVec3]) -> bool {
    let projection = Projection::onto_largest(vertices);
    let points: Vec<_> = vertices.iter().map(|&v| projection.point(v)).collect();
    let count = points.len();
    (0..count).all(|i| robust::orient2d(points[i], points[(i + 1) % count], points[(i + 2) % count]) > 0.0)
}

impl Patch {
    /// The point at u, v in [0, 1], and its area for a unit of u v. Affine in each of u and v.
    pub(super) fn at(&self, u: f64, v: f64) -> (DVec3, f64) {
        let [a, b, c, d] = self.corners;
        let (low, high) = (a + (b - a) * u, d + (c - d) * u);
        let along = (b - a) * (1.0 - v) + (c - d) * v;
        (low + (high - low) * v, along.cross(high - low).length())
    }

    /// Its corners, each once.
    pub(super) fn outline(&self) -> &[DVec3] {
        if self.is_triangle() { &self.corners[..3] } else { &self.corners }
    }

    fn is_triangle(&self) -> bool {
        self.corners[2] == self.corners[3]
    }

    /// Two patches that are this one together, cut across its first or its second direction.
    pub(super) fn halves(&self, direction: usize) -> [Self; 2] {
        let [a, b, c, d] = self.corners;
        let middle = |p: DVec3, q: DVec3| if p == q { p } else { p + (q - p) * 0.5 };
        let halves = if direction == 0 {
            let (low, high) = (middle(a, b), middle(d, c));
            [[a, low, high, d], [low, b, c, high]]
        } else {
            let (left, right) = (middle(a, d), middle(b, c));
            [[a, b, right, left], [left, right, c, d]]
        };
        halves.map(|corners| Self { corners })
    }

    /// About how long it is in its two directions.
    pub(super) fn sides(&self) -> [f64; 2] {
        let [a, b, c, d] = self.corners;
        [(b + c - a - d).length(), (c + d - a - b).length()]
    }
}

/// A point that stands for a part of a polygon.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Node {
    pub(super) point: DVec3,
    /// The share it stands for, of a polygon's area, or the area itself, of a patch.
    pub(super) share: f64,
    /// Its place in the patch, from -1 to 1 each way.
    pub(super) place: [f64; 2],
}

/// The mean of some points.
pub(super) fn middle(points: &[DVec3]) -> DVec3 {
    points.iter().sum::<DVec3>() / points.len() as f64
}

/// A product Gauss rule of `per_side` squared points on each patch of a polygon.
///
/// The shares sum to 1 up to rounding by construction, since the Jacobian of a patch is of degree 1 in each variable: nothing is
/// normalised.
#[cfg(test)]
pub(super) fn nodes(polygon: &radgrad_core::Polygon, per_side: usize) -> Vec<Node> {
    let area = polygon.area();
    let share = |node: Node| Node { share: node.share / area, ..node };
    patches(polygon.vertices()).iter().flat_map(|patch| nodes_of(patch, per_side)).map(share).collect()
}

/// The same on one patch, each with the area it stands for.
pub(super) fn nodes_of(patch: &Patch, per_side: usize) -> Vec<Node> {
    let rule = gauss_legendre(per_side);
    let mut nodes = Vec::with_capacity(rule.len() * rule.len());
    for &(v, weight_v) in rule {
        for &(u, weight_u) in rule {
            let (point, density) = patch.at(0.5 + 0.5 * u, 0.5 + 0.5 * v);
            nodes.push(Node { point, share: density * (0.5 * weight_u) * (0.5 * weight_v), place: [u, v] });
        }
    }
    nodes
}

#[cfg(test)]
mod tests {
    use radgrad_core::Polygon;

    use super::*;

    #[test]
    fn rules_integrate_polynomials_up_to_their_degree() {
        for count in 1..=MOST_NODES {
            let rule = gauss_legendre(count);
            let power = |degree: i32| rule.iter().map(|(x, w)| w * x.powi(degree)).sum::<f64>();
            let highest = i32::try_from(2 * count).unwrap();
            for degree in 0..highest {
                let exact = if degree % 2 == 1 { 0.0 } else { 2.0 / f64::from(degree + 1) };
                assert!((power(degree) - exact).abs() < 4e-15, "{count} nodes, degree {degree}");
            }
            assert!((power(highest) - 2.0 / f64::from(highest + 1)).abs() > 1e-12 * libm::ldexp(1.0, -highest), "{count}");
        }
    }

    #[test]
    fn shares_sum_to_one_and_points_have_the_centroid_of_the_polygon() {
        let l = [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
        let kite = [[0.0, 0.0], [2.0, 0.1], [2.5, 2.0], [0.1, 1.0]];
        let triangle = [[0.0, 0.0], [2.0, 0.5], [0.3, 1.0]];
        for outline in [&l[..], &kite[..], &triangle[..]] {
            let polygon = Polygon::new(outline.iter().map(|&[x, y]| DVec3::new(x, y, 1.0 + x - y)).collect()).unwrap();
            for per_side in [2, 3, 5] {
                let nodes = nodes(&polygon, per_side);
                assert!((nodes.iter().map(|node| node.share).sum::<f64>() - 1.0).abs() < 1e-15);
                let centre: DVec3 = nodes.iter().map(|node| node.point * node.share).sum();
                let [first, ..] = *polygon.vertices() else { unreachable!() };
                assert!((centre - first).dot(polygon.normal()).abs() < 1e-15);
            }
        }
    }
}
