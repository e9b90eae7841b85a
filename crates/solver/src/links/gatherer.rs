//! Gatherers of light: an element at its nodes, or a point that may be on no face.

use crate::error::Error;
use crate::links::station::Station;
use crate::mesh::clusters::Cluster;
use crate::mesh::{Mesh, Sight};

/// A gatherer of light.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Gatherer<'a> {
    /// An element.
    Element(usize),
    /// A point.
    Point(&'a Station),
}

impl<'a> Gatherer<'a> {
    /// Where light is gathered.
    pub(crate) fn stations(self, mesh: &Mesh) -> Vec<Station> {
        match self {
            Self::Element(element) => Station::at_nodes(mesh, element),
            Self::Point(station) => vec![*station],
        }
    }

    /// How many stations there are.
    pub(crate) fn len(self, mesh: &Mesh) -> usize {
        match self {
            Self::Element(element) => mesh.basis(element).nodes().len(),
            Self::Point(_) => 1,
        }
    }

    /// Its sight of a source, all of it among `known` where the faces in between were found for a larger one.
    pub(crate) fn sight(self, mesh: &Mesh, source: usize, known: Option<&[usize]>) -> Result<Sight, Error> {
        Ok(match (self, known) {
            // Where nothing is between larger ones nothing is between these.
            (Self::Element(element), Some([])) if mesh.facing(element, source) => Sight::Clear,
            (Self::Element(_), Some([])) => Sight::Nothing(None),
            (Self::Element(element), _) => mesh.sight(element, source, known),
            (Self::Point(station), _) => station.sight(mesh, source, known)?,
        })
    }

    /// Whether something of a cluster may be seen.
    pub(crate) fn may_see(self, mesh: &Mesh, cluster: &Cluster) -> bool {
        match self {
            Self::Element(element) => cluster.faces(&mesh.elements()[element]),
            Self::Point(station) => cluster.view(station).factor > 0.0,
        }
    }
}
