//! Points that receive light.

use radgrad_core::{DVec3, Receiver};

use crate::error::Error;
use crate::mesh::basis::Basis;
use crate::mesh::element::Element;
use crate::mesh::{Mesh, Sight};

/// A point that receives.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Station {
    pub(crate) point: DVec3,
    pub(crate) normal: DVec3,
    /// The face that it is on, if it is on one.
    pub(crate) face: Option<usize>,
}

impl Station {
    /// A point of an element's plane.
    pub(crate) fn on(element: &Element, point: DVec3) -> Self {
        Self { point, normal: element.polygon().normal(), face: Some(element.face()) }
    }

    /// A point that is on no face.
    pub(crate) const fn in_space(receiver: &Receiver) -> Self {
        Self { point: receiver.position(), normal: receiver.normal(), face: None }
    }

    /// It as a receiver that reflects everything, so that its radiosity is its irradiance.
    pub(crate) fn receiver(&self) -> Result<Receiver, Error> {
        Receiver::new(self.point, self.normal, 1.0).map_err(|source| self.refused(source))
    }

    /// Its sight of an element, among `known`.
    pub(crate) fn sight(&self, mesh: &Mesh, source: usize, known: Option<&[usize]>) -> Result<Sight, Error> {
        Ok(match self.face {
            Some(face) => mesh.sight_of_point(face, self.point, source, known),
            None => mesh.sight_in_space(&self.receiver()?, source, known),
        })
    }

    /// The error if the light it receives cannot be represented.
    pub(crate) const fn refused(&self, source: radgrad_core::Error) -> Error {
        match self.face {
            Some(face) => Error::Evaluation { face, source },
            None => Error::Sample { position: self.point, source },
        }
    }

    /// The nodes of an element.
    pub(crate) fn at_nodes(mesh: &Mesh, element: usize) -> Vec<Self> {
        Self::at_nodes_of(mesh.basis(element), &mesh.elements()[element])
    }

    /// The nodes of a basis on an element.
    pub(crate) fn at_nodes_of(basis: &Basis, element: &Element) -> Vec<Self> {
        basis.nodes().iter().map(|node| Self::on(element, element.point(node.at))).collect()
    }
}
