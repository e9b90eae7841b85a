//! Gatherers of light: an element at its nodes, or a point that may be on no face.

use crate::error::Error;
use crate::links::station::Station;
use crate::mesh::basis::Basis;
use crate::mesh::clusters::Cluster;
use crate::mesh::{Mesh, Sight};

/// A gatherer of light.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Gatherer<'a> {
    /// An element, at the nodes of its basis.
    Element(usize),
    /// An element, at the nodes of another basis.
    Finer(usize, &'a Basis),
    /// A point.
    Point(&'a Station),
}

impl<'a> Gatherer<'a> {
    /// The basis of an element's gather.
    pub(crate) fn basis(self, mesh: &'a Mesh) -> Option<&'a Basis> {
        match self {
            Self::Element(element) => Some(mesh.basis(element)),
            Self::Finer(_, basis) => Some(basis),
            Self::Point(_) => None,
        }
    }

    /// Where light is gathered.
    pub(crate) fn stations(self, mesh: &Mesh) -> Vec<Station> {
        match self {
            Self::Element(element) => Station::at_nodes(mesh, element),
            Self::Finer(element, basis) => Station::at_nodes_of(basis, &mesh.elements()[element]),
            Self::Point(station) => vec![*station],
        }
    }

    /// How many stations there are.
    pub(crate) fn len(self, mesh: &Mesh) -> usize {
        self.basis(mesh).map_or(1, |basis| basis.nodes().len())
    }

    /// Its sight of a source, all of it among `known` where the faces in between were found for a larger one.
    pub(crate) fn sight(self, mesh: &Mesh, source: usize, known: Option<&[usize]>) -> Result<Sight, Error> {
        Ok(match (self, known) {
            // Where nothing is between larger ones nothing is between these.
            (Self::Element(element) | Self::Finer(element, _), Some([])) if mesh.facing(element, source) => Sight::Clear,
            (Self::Element(_) | Self::Finer(..), Some([])) => Sight::Nothing(None),
            (Self::Element(element) | Self::Finer(element, _), _) => mesh.sight(element, source, known),
            (Self::Point(station), _) => station.sight(mesh, source, known)?,
        })
    }

    /// Whether something of a cluster may be seen.
    pub(crate) fn may_see(self, mesh: &Mesh, cluster: &Cluster) -> bool {
        match self {
            Self::Element(element) | Self::Finer(element, _) => cluster.faces(&mesh.elements()[element]),
            Self::Point(station) => cluster.view(station).factor > 0.0,
        }
    }
}
