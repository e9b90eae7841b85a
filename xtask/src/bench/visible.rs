//! The visible part for the benchmark's own methods: a triangle from the receiver, cut by its horizon by the walk of Sutherland and
//! Hodgman (1974). Generic, so that dual numbers pass through it.

use nalgebra::Vector3;
use num_dual::DualNum;
use radgrad_core::DVec3;

/// A double, or one that carries derivatives.
pub(crate) trait Scalar: DualNum<Primitive = f64> + Copy {}
impl<T: DualNum<Primitive = f64> + Copy> Scalar for T {}

/// A convex polygon of at most four corners, as seen from the receiver.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Corners<D> {
    at: [Vector3<D>; 4],
    /// Whether the edge from a corner is on the horizon.
    on_horizon: [bool; 4],
    count: usize,
}

impl<D: Scalar> Corners<D> {
    /// The corners in their order.
    pub(crate) fn as_slice(&self) -> &[Vector3<D>] {
        &self.at[..self.count]
    }

    /// Start and end of each edge, and whether it is on the horizon.
    pub(crate) fn edges(&self) -> impl Iterator<Item = (Vector3<D>, Vector3<D>, bool)> + '_ {
        (0..self.count).map(|i| (self.at[i], self.at[if i + 1 == self.count { 0 } else { i + 1 }], self.on_horizon[i]))
    }

    fn push(&mut self, corner: Vector3<D>, on_horizon: bool) {
        (self.at[self.count], self.on_horizon[self.count]) = (corner, on_horizon);
        self.count += 1;
    }
}

/// The whole triangle as seen from `x`.
pub(crate) fn relative_to<D: Scalar>(triangle: &[DVec3], x: Vector3<D>) -> [Vector3<D>; 3] {
    [0, 1, 2].map(|i| constant(triangle[i]) - x)
}

/// The part of it above the horizon of the normal `n1`.
pub(crate) fn above<D: Scalar>(triangle: [Vector3<D>; 3], n1: DVec3) -> Corners<D> {
    let n1 = constant(n1);
    let heights = triangle.map(|corner| corner.dot(&n1));
    let is_above = heights.map(|height| height.re() >= 0.0);
    let mut part = Corners { at: [Vector3::from([D::from(0.0); 3]); 4], on_horizon: [false; 4], count: 0 };
    for i in 0..3 {
        let j = (i + 1) % 3;
        if is_above[i] {
            part.push(triangle[i], false);
        }
        if is_above[i] != is_above[j] {
            let along = heights[i] / (heights[i] - heights[j]);
            let crossing = triangle[i] * (D::from(1.0) - along) + triangle[j] * along;
            part.push(crossing, is_above[i]);
        }
    }
    part
}

/// A vector that does not depend on the receiver.
pub(crate) fn constant<D: Scalar>(v: DVec3) -> Vector3<D> {
    Vector3::new(D::from(v.x), D::from(v.y), D::from(v.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_horizon_leaves_a_quadrilateral_a_triangle_or_nothing() {
        let triangle = [[0.0, 0.0, -1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]].map(DVec3::from);
        let relative = relative_to(&triangle, Vector3::zeros());
        let part = above::<f64>(relative, DVec3::Z);
        let cut: Vec<bool> = part.edges().map(|(_, _, on_horizon)| on_horizon).collect();
        assert_eq!((part.as_slice().len(), cut), (4, vec![false, false, false, true]));
        for (from, to, on_horizon) in part.edges() {
            assert_eq!(from.z == 0.0 && to.z == 0.0, on_horizon);
        }
        assert_eq!(above(relative, -DVec3::Z).as_slice().len(), 3);
        assert_eq!(above(relative, DVec3::new(-1.0, -1.0, -2.0)).as_slice().len(), 3);
        let beneath = triangle.map(|corner| Vector3::new(corner.x, corner.y, -2.0));
        assert_eq!(above(beneath, DVec3::Z).as_slice().len(), 0);
    }
}
