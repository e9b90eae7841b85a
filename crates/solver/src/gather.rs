//! The radiosity of a point by one exact gather: `E + rho G B_h`, and its bound `rho |G r| + rho G w` with what links neglect.
//!
//! The gather runs over the links of the leaf that the point is on, with closed forms at the point itself. Its error is the
//! reflectance times what reaches the point of the error of `B_h`, an average, and so is smaller than that of `B_h`.

use radgrad_core::DVec3;

use crate::Error;
use crate::ledger::Ledger;
use crate::mesh::Sight;
use crate::solve::Solution;
use crate::transfer::{Row, Station};

/// Points may be off their face by this fraction of the scene's extent.
const REACH: f64 = 1e-6;

/// Radiosity and bound at a point.
#[derive(Debug, Clone, PartialEq)]
pub struct Gathered {
    /// Face that the point is on.
    pub face: usize,
    /// Leaf that the point is on.
    pub leaf: usize,
    /// Radiosity in each channel.
    pub radiosity: Vec<f64>,
    /// Bound on the error of the radiosity, by its sources, in each channel.
    pub ledger: Vec<Ledger>,
}

impl Solution {
    /// Radiosity at a point on the face that is there and faces along `normal`.
    ///
    /// # Errors
    /// If there is no such face within a millionth of the scene's extent.
    pub fn gather(&self, point: DVec3, normal: DVec3) -> Result<Gathered, Error> {
        let reach = REACH * self.extent;
        let none = Error::NoFace { position: point, normal, reach };
        let (face, foot) = self.mesh.face_at(point, normal, reach).ok_or(none.clone())?;
        let leaf = self.mesh.leaf_at(face, foot).ok_or(none)?;
        self.gather_on(leaf, foot)
    }

    /// Radiosity at a point of a leaf.
    ///
    /// # Errors
    /// If it cannot be represented.
    pub fn gather_on(&self, leaf: usize, point: DVec3) -> Result<Gathered, Error> {
        let element = &self.mesh.elements()[leaf];
        let (face, channels) = (element.face(), self.channels.len());
        let normal = element.polygon().normal();
        let station = Station { point, normal, face };
        let mut sums = vec![0.0; channels];
        let mut ledger = vec![Ledger::default(); channels];
        for link in &self.links[leaf] {
            let sight = match &link.sight {
                Sight::Past(known) => self.mesh.sight_of_point(face, point, link.source, Some(known)),
                other => other.clone(),
            };
            let mut row = Row::default();
            self.optics().receive(&mut row, &station, link.source, &sight, link.count)?;
            for channel in 0..channels {
                let len = self.mesh.basis(link.source).len();
                let coefficients = &self.field.of(link.source, channel, len)[..link.count];
                for (c, v) in coefficients.iter().zip(&row.values) {
                    sums[channel] += c * v;
                }
                let size = row.error_of(coefficients);
                let neglected = self.field.neglected(&self.mesh, link.source, link.count, channel, &row);
                ledger[channel] += self.bounds.gathered(link.source, channel, &row);
                ledger[channel].computation += neglected;
                if matches!(sight, Sight::Past(_)) {
                    ledger[channel].visibility += size;
                } else {
                    ledger[channel].computation += size;
                }
            }
        }
        let [rho, emitted] = self.surfaces.at(face, point);
        let rounding =
            |c: usize| 2.0 * f64::EPSILON * (self.links[leaf].len() + 2) as f64 * (rho[c] * sums[c].abs() + emitted[c]);
        Ok(Gathered {
            face,
            leaf,
            radiosity: (0..channels).map(|c| emitted[c] + rho[c] * sums[c]).collect(),
            ledger: (0..channels)
                .map(|c| ledger[c] * rho[c] + Ledger { computation: rounding(c), ..Ledger::default() })
                .collect(),
        })
    }
}
