//! Points that receive light.

use radgrad_core::DVec3;

use crate::mesh::Mesh;
use crate::mesh::element::Element;

/// A point that receives.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Station {
    pub(crate) point: DVec3,
    pub(crate) normal: DVec3,
    pub(crate) face: usize,
}

impl Station {
    /// A point of an element's plane.
    pub(crate) fn on(element: &Element, point: DVec3) -> Self {
        Self { point, normal: element.polygon().normal(), face: element.face() }
    }

    /// The nodes of an element.
    pub(crate) fn at_nodes(mesh: &Mesh, element: usize) -> Vec<Self> {
        let (basis, element) = (mesh.basis(element), &mesh.elements()[element]);
        basis.nodes().iter().map(|node| Self::on(element, element.point(node.at))).collect()
    }
}
