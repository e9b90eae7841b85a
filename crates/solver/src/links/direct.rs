//! Direct light kept apart: the light of lamps is computed at points, and never approximated on the way to them.
//!
//! With the emission E of the lamps `B = E + rho G E + (light reflected twice or more)`. The middle part has the edges of shadows,
//! the last one has none that are sharp; but a sample of the middle part costs one closed form a lamp, and one of the last a gather
//! over the whole scene. So each has elements of its own: leaves, where direct light is projected, and receivers above them, where
//! the gathers are. Lamps are the faces that emit, if they are few and small: if all walls glow nothing is gained. Faces that emit
//! by a texture are none: their light is gathered as reflected light is.

use radgrad_scene::largest;

use crate::bytes::bytes_of;
use crate::error::Error;
use crate::links::station::Station;
use crate::links::transfer::Optics;
use crate::mesh::surfaces::Surfaces;
use crate::mesh::{Mesh, Sight};

/// The part of all area that lamps may have.
const SMALL: f64 = 0.1;

/// Elements of the coarsest mesh that lamps may have.
pub(crate) const FEW: usize = 32;

/// Error of a lamp's light, by that of other evaluations.
const FINER: f64 = 1e-2;

/// The lamps of a scene.
#[derive(Debug, Clone, Default)]
pub(crate) struct Lamps {
    /// Elements of the coarsest mesh.
    roots: Vec<usize>,
}

/// The light of lamps at a point.
#[derive(Debug, Clone, Default)]
pub(crate) struct Lit {
    /// Irradiance in each channel.
    pub(crate) irradiance: Vec<f64>,
    /// Estimate of its error, in the clear and past occluders.
    pub(crate) likely: Vec<[f64; 2]>,
    /// The part of that by rays.
    pub(crate) noise: Vec<f64>,
    /// The form factor of each lamp's root.
    pub(crate) factors: Vec<f64>,
    /// Form factors up to which nothing was seen.
    in_doubt: f64,
}

/// Direct light on a leaf.
#[derive(Debug, Clone, Default)]
pub(crate) struct Direct {
    /// At each node.
    pub(crate) nodes: Vec<Lit>,
    /// Sight of each lamp's root.
    sights: Vec<Sight>,
}

impl Direct {
    /// Sight of each lamp's root.
    pub(crate) fn sights(&self) -> &[Sight] {
        &self.sights
    }

    /// Whether it is that of so many lamps in so many channels.
    pub(crate) fn is_of(&self, lamps: usize, channels: usize) -> bool {
        let is_lit = |lit: &Lit| {
            lit.factors.len() == lamps
                && [lit.irradiance.len(), lit.likely.len(), lit.noise.len()].iter().all(|count| *count == channels)
        };
        (self.sights.len() == lamps || self.nodes.is_empty() && self.sights.is_empty()) && self.nodes.iter().all(is_lit)
    }

    /// The lamps of which no node sees anything, though something of the leaf may, with the faces that may be between.
    pub(crate) fn unseen<'a>(&'a self, lamps: &'a Lamps) -> impl Iterator<Item = (usize, &'a [usize])> {
        let sights = lamps.roots_with_sights(self).enumerate();
        let unseen = move |(lamp, (root, sight)): (usize, (usize, &'a Sight))| match sight {
            Sight::Past(faces) if self.nodes.iter().all(|lit| lit.factors[lamp] <= lit.in_doubt) => Some((root, &faces[..])),
            _ => None,
        };
        sights.filter_map(unseen)
    }
}

impl Lamps {
    pub(crate) fn find(mesh: &Mesh, surfaces: &Surfaces) -> Self {
        let emits = |root: &usize| {
            let face = mesh.elements()[*root].face();
            !surfaces.glows_by_texture(face) && surfaces.emitted[face].iter().any(|e| *e > 0.0)
        };
        let area = |roots: &[usize]| roots.iter().map(|&root| mesh.elements()[root].area()).sum::<f64>();
        let roots: Vec<usize> = mesh.roots().iter().copied().filter(emits).collect();
        if roots.len() <= FEW && area(&roots) <= SMALL * area(mesh.roots()) { Self { roots } } else { Self::default() }
    }

    /// Elements of the coarsest mesh.
    pub(crate) fn roots(&self) -> &[usize] {
        &self.roots
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.roots.is_empty()
    }

    /// The power of all lamps in a channel.
    pub(crate) fn power(&self, mesh: &Mesh, surfaces: &Surfaces, channel: usize) -> f64 {
        let root_power = |&root: &usize| mesh.elements()[root].area() * surfaces.emitted[mesh.elements()[root].face()][channel];
        self.roots.iter().map(root_power).sum()
    }

    /// An element's sight of each lamp; `above` is that of a larger one around it.
    fn sights(&self, mesh: &Mesh, element: usize, above: Option<&Direct>) -> Vec<Sight> {
        let sight = |(lamp, &root): (usize, &usize)| match above.map(|direct| &direct.sights[lamp]) {
            Some(&Sight::Nothing(face)) => Sight::Nothing(face),
            Some(Sight::Clear) => Sight::Clear,
            Some(Sight::Past(known)) => mesh.sight(element, root, Some(known)),
            None => mesh.sight(element, root, None),
        };
        self.roots.iter().enumerate().map(sight).collect()
    }

    /// Direct light on an element.
    pub(crate) fn light(
        &self,
        optics: &Optics<'_>,
        surfaces: &Surfaces,
        element: usize,
        above: Option<&Direct>,
    ) -> Result<Direct, Error> {
        let sights = self.sights(optics.mesh, element, above);
        let stations = Station::at_nodes(optics.mesh, element);
        let nodes =
            stations.iter().map(|station| self.irradiance(optics, surfaces, station, &sights)).collect::<Result<_, _>>()?;
        Ok(Direct { nodes, sights })
    }

    /// Each lamp's root with a leaf's sight of it.
    pub(crate) fn roots_with_sights<'a>(&'a self, leaf: &'a Direct) -> impl Iterator<Item = (usize, &'a Sight)> {
        self.roots.iter().copied().zip(&leaf.sights)
    }

    /// A point's sight of each lamp's root.
    pub(crate) fn sights_from(&self, mesh: &Mesh, station: &Station) -> Result<Vec<Sight>, Error> {
        self.roots.iter().map(|&root| station.sight(mesh, root, None)).collect()
    }

    /// Direct light at a point that sees this of each lamp's root.
    pub(crate) fn irradiance(
        &self,
        optics: &Optics<'_>,
        surfaces: &Surfaces,
        station: &Station,
        sights: &[Sight],
    ) -> Result<Lit, Error> {
        let channels = surfaces.emitted[0].len();
        let factors = Vec::with_capacity(self.roots.len());
        let none = vec![[0.0; 2]; channels];
        let dark = vec![0.0; channels];
        let mut lit = Lit { irradiance: dark.clone(), likely: none, noise: dark, factors, in_doubt: 0.0 };
        let optics = Optics { absolute: FINER * optics.absolute, past: FINER * optics.past, ..*optics };
        for (&root, sight) in self.roots.iter().zip(sights) {
            let row = optics.receive(station, root, sight, 1)?;
            let emitted = &surfaces.emitted[optics.mesh.elements()[root].face()];
            lit.factors.push(row.values[0]);
            lit.in_doubt = largest(lit.in_doubt, if row.likely.is_some() { 0.0 } else { row.error });
            for (channel, emitted) in emitted.iter().enumerate() {
                lit.irradiance[channel] += emitted * row.values[0];
                let kind = usize::from(matches!(sight, Sight::Past(_)));
                lit.likely[channel][kind] += emitted * row.likely.unwrap_or(row.error);
                lit.noise[channel] += emitted * row.likely.unwrap_or(0.0);
            }
        }
        Ok(lit)
    }
}

bytes_of!(Lit { irradiance, likely, noise, factors, in_doubt });
bytes_of!(Direct { nodes, sights });
