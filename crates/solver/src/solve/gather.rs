//! The radiosity of a point by one exact gather: `E + rho G B_h`, and its bound `rho |G r| + rho G w` with what links neglect.
//!
//! The gather runs over the links of the leaf that the point is on, with closed forms at the point itself. Its error is the
//! reflectance times what reaches the point of the error of `B_h`, an average, and so is smaller than that of `B_h`.

use radgrad_core::DVec3;

use crate::bound::ledger::Ledger;
use crate::error::Error;
use crate::links::station::Station;
use crate::mesh::Sight;
use crate::solve::solution::Solution;

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
    /// Proven bound on the error of the radiosity, by its sources, in each channel.
    pub ledger: Vec<Ledger>,
    /// Estimate of the same.
    pub estimate: Vec<Ledger>,
}

impl Solution {
    /// Radiosity at a point on the face that is there and faces along `normal`.
    ///
    /// # Errors
    /// If there is no such face within a millionth of the scene's extent.
    pub fn gather(&self, point: DVec3, normal: DVec3) -> Result<Gathered, Error> {
        let reach = REACH * self.extent;
        let none = Error::NoFace { position: point, normal, reach: reach / self.placement.power() };
        let (face, foot) = self.mesh.face_at(self.placement.inward(point), normal, reach).ok_or(none.clone())?;
        let leaf = self.mesh.leaf_at(face, foot).ok_or(none)?;
        self.gather_on(leaf, foot)
    }

    /// Radiosity at a point of a leaf, in the coordinates of [`Self::placement`].
    ///
    /// # Errors
    /// If it cannot be represented.
    pub fn gather_on(&self, leaf: usize, point: DVec3) -> Result<Gathered, Error> {
        let element = &self.mesh.elements()[leaf];
        let (face, channels) = (element.face(), self.channels.len());
        let station = Station::on(element, point);
        let (mut sums, mut ledger) = (vec![0.0; channels], vec![Ledger::default(); channels]);
        if let Some(direct) = self.direct.get(leaf) {
            let lit = self.lamps.light_at(&self.optics(), &self.surfaces, &station, direct)?;
            for (channel, [clear, past]) in lit.error.into_iter().enumerate() {
                sums[channel] += lit.irradiance[channel];
                ledger[channel] += Ledger { computation: clear, visibility: past, ..Ledger::default() };
            }
        }
        let links = &self.links[self.receiver_of(leaf)];
        let mut rows = Vec::with_capacity(links.len());
        for link in links {
            let count = self.mesh.basis(link.source).len();
            let row = self.optics().receive(&station, link.source, &link.sight, count)?;
            for channel in 0..channels {
                let coefficients = self.field.of(link.source, channel, count);
                sums[channel] += coefficients.iter().zip(&row.values).map(|(c, v)| c * v).sum::<f64>();
                let size = row.error_of(coefficients);
                ledger[channel].computation += self.field.neglected(&self.mesh, link.source, channel, &row);
                if matches!(link.sight, Sight::Past(_)) {
                    ledger[channel].visibility += size;
                } else {
                    ledger[channel].computation += size;
                }
            }
            rows.push((link.source, row));
        }
        let far = self.far[self.receiver_of(leaf)].of_point((&self.mesh, &self.field), &station, &rows);
        for channel in 0..channels {
            sums[channel] += far.value(&self.field, channel, 0);
            ledger[channel].computation += far.neglected(&self.field, channel, 0);
        }
        let [rho, emitted] = self.surfaces.at(face, point);
        let estimated = self.points().at(self.bounded(), &self.bounds, &station, (&rows, &far), &rho);
        let proven = match self.proven() {
            Some(proven) => proven.at(&rows, &far, &rho),
            None => vec![Ledger::unknown(); channels],
        };
        let rounding = |c: usize| 2.0 * f64::EPSILON * (links.len() + 2) as f64 * (rho[c] * sums[c].abs() + emitted[c]);
        let with = |beyond: &[Ledger]| -> Vec<Ledger> {
            let of = |c: usize| beyond[c] + ledger[c] * rho[c] + Ledger { computation: rounding(c), ..Ledger::default() };
            (0..channels).map(of).collect()
        };
        Ok(Gathered {
            face,
            leaf,
            radiosity: (0..channels).map(|c| emitted[c] + rho[c] * sums[c]).collect(),
            ledger: with(&proven),
            estimate: with(&estimated),
        })
    }
}
