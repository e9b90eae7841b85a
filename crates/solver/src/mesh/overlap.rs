//! Elements that lie on each other: where two of them face the same way in one plane, a point sees both at one place, and form
//! factors sum to more than 1. Scenes have such faces by mistake, as a carpet in the floor's plane.

use radgrad_core::DVec3;

use crate::mesh::clusters::{Clusters, Parts};
use crate::mesh::element::{Element, around};

/// Fraction of the size within which planes are the same, or outlines only touch: wider than the tolerance of visibility.
const SAME: f64 = 1e-9;

impl Clusters {
    /// Whether any two of the elements do.
    pub(crate) fn any_overlap(&self, elements: &[Element]) -> bool {
        elements.iter().enumerate().any(|(index, element)| self.overlaps(elements, index, element))
    }

    fn overlaps(&self, elements: &[Element], index: usize, element: &Element) -> bool {
        let [low, high] = around(element.polygon().vertices());
        let reach = SAME * (element.radius() + (-low).max(high).max_element());
        let mut open: Vec<usize> = self.root().into_iter().collect();
        while let Some(at) = open.pop() {
            let cluster = &self.clusters()[at];
            let apart = cluster.low.cmpgt(high + reach).any() || cluster.high.cmplt(low - reach).any();
            if apart {
                continue;
            }
            match cluster.parts {
                Parts::Two(parts) => open.extend(parts),
                Parts::Element(other) if other > index && lie_on_each_other(element, &elements[other], reach) => return true,
                Parts::Element(_) => {}
            }
        }
        false
    }
}

fn lie_on_each_other(a: &Element, b: &Element, reach: f64) -> bool {
    let normal = a.polygon().normal();
    let reach = reach + SAME * b.radius();
    let level = |p: &DVec3| normal.dot(*p - a.centre()).abs() <= reach;
    normal.dot(b.polygon().normal()) > 0.0
        && b.polygon().vertices().iter().all(level)
        && !are_beside(a.polygon().vertices(), normal, b.polygon().vertices(), reach)
        && !are_beside(b.polygon().vertices(), b.polygon().normal(), a.polygon().vertices(), reach)
}

/// Whether an edge of the first of two convex polygons, which turns around a normal, has all of the second on its outer side.
pub(crate) fn are_beside(v: &[DVec3], normal: DVec3, other: &[DVec3], reach: f64) -> bool {
    (0..v.len()).any(|i| {
        let inward = normal.cross(v[(i + 1) % v.len()] - v[i]).normalize_or_zero();
        other.iter().all(|p| inward.dot(*p - v[i]) <= reach)
    })
}
