//! The radiosity of a point by one exact gather: `E + rho G B_h`, and the irradiance `G B_h` of a point anywhere, with estimates of their
//! errors.
//!
//! The gather runs over the links of the leaf that the point is on, with closed forms at the point itself. Its error is the
//! reflectance times the gather of the error of `B_h`, an average, and so is smaller than that of `B_h`. [`crate::solve::second_gather`]
//! finds a part of that error with its sign: an answer at a point adds this part.
//!
//! A point that is on no face is linked by itself, as finely as receivers are ([`crate::links::refine`]).

use radgrad_core::{DVec3, Receiver};
use radgrad_scene::largest;

use crate::clock::Clock;
use crate::error::Error;
use crate::estimate::ledger::Ledger;
use crate::links::cluster::far::Far;
use crate::links::direct::{Direct, Lit};
use crate::links::gatherer::Gatherer;
use crate::links::link::Link;
use crate::links::refine::{Need, WITHOUT_ORDER};
use crate::links::station::Station;
use crate::links::transfer::{Optics, Row};
use crate::mesh::{Sight, TOUCHES};
use crate::solve::second_gather::{KnownError, Term};
use crate::solve::solution::Solution;

/// Points may be off their face by this fraction of the scene's extent.
const REACH: f64 = 1e-6;

/// Points at another face are taken to be in front of it by so much of their leaf's radius: in its plane they would see nothing of it.
const IN_FRONT: f64 = 1e-8;

/// A source hangs close over a point where it is nearly parallel to it, with normals of this cosine at most, and nearer than this
/// part of its leaf's radius. A face that meets the point's face at an angle is in no gap with it: [`crate::solve::wedge`] has
/// that.
const FACING: f64 = -0.99;
const CLOSE: f64 = 0.25;

/// Irradiance at a point and the estimate of its error, in each channel: the light of all that it sees above its horizon.
/// Irradiance has the unit of radiosity, pi times that of the scene's radiances; a white surface there would have it for its
/// radiosity.
///
/// ```
/// use radgrad_core::DVec3;
/// use radgrad_solver::{Options, solve};
/// # use radgrad_scene::{Degenerate, Scene};
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");
/// # let scene = Scene::read(file, Degenerate::Refuse)?;
/// let options = Options { error: 0.5, degree: Some(1), first_elements: 1, ..Options::default() };
/// let solution = solve(&scene, &options, |_| true)?;
/// let (low, high) = scene.bounds().ok_or("no faces")?;
/// let sensor = solution.irradiance_at(0.5 * (low + high), DVec3::Y)?;
/// assert!(sensor.irradiance[0] >= 0.0 && sensor.estimate[0].total() >= 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Irradiance {
    /// Irradiance.
    pub irradiance: Vec<f64>,
    /// Estimate of its error, by its sources.
    pub estimate: Vec<Ledger>,
}

/// Radiosity at a point of a face and the estimate of its error.
#[derive(Debug, Clone, PartialEq)]
pub struct Gathered {
    /// Face that the point is on.
    pub face: usize,
    /// Leaf that the point is on.
    pub leaf: usize,
    /// Radiosity in each channel.
    pub radiosity: Vec<f64>,
    /// Estimate of the error of the radiosity, by its sources, in each channel.
    pub estimate: Vec<Ledger>,
    /// Irradiance in each channel, of which the face reflects its part.
    pub irradiance: Irradiance,
}

/// The gather of a point from a source.
struct Gather {
    source: usize,
    row: Row,
    sight: Sight,
}

/// All that a point gathers but for clusters.
struct Gathers {
    lit: Option<Lit>,
    from_links: Vec<Gather>,
}

/// The irradiance of a point in each channel, the errors of evaluations and links, and its terms.
pub(super) struct Sum {
    pub(super) sums: Vec<f64>,
    errors: Vec<Ledger>,
    pub(super) rows: Vec<(usize, Row)>,
    /// Sights of the sources of rows.
    sights: Vec<Sight>,
    pub(super) far: Far,
    /// The light of lamps that are kept apart.
    pub(super) lit: Option<Lit>,
}

impl Solution {
    /// Radiosity at a point on the face that is there and faces along `normal`: one exact gather of the polynomials, corrected by the
    /// part of its error whose sign is known.
    ///
    /// # Errors
    /// If there is no such face within a millionth of the scene's extent.
    pub fn gather(&self, point: DVec3, normal: DVec3) -> Result<Gathered, Error> {
        let (leaf, foot) = self.leaf_of(point, normal)?;
        self.gather_on(leaf, foot)
    }

    /// The leaf of the face that is at a point and faces along `normal`, and the point of its plane in the coordinates of
    /// [`Self::placement`].
    pub(super) fn leaf_of(&self, point: DVec3, normal: DVec3) -> Result<(usize, DVec3), Error> {
        let reach = REACH * self.system.extent;
        let none = Error::NoFace { position: point, normal, reach: reach / self.placement.power() };
        let (face, foot) = self.system.mesh.face_at(self.placement.inward(point), normal, reach).ok_or(none.clone())?;
        let leaf = self.system.mesh.leaf_at(face, foot).ok_or(none.clone())?;
        let before = self.in_front_of_others(leaf, foot);
        Ok((if before == foot { leaf } else { self.system.mesh.leaf_at(face, before).ok_or(none)? }, before))
    }

    /// A point of a leaf, or one in front of the faces that are at it and can light it.
    fn in_front_of_others(&self, leaf: usize, point: DVec3) -> DVec3 {
        let element = self.element(leaf);
        let normal = element.polygon().normal();
        let mut touching = self.system.mesh.touching(point, element.face(), TOUCHES * self.system.extent).peekable();
        if touching.peek().is_none() {
            return point;
        }
        let along = |other: DVec3| (other - normal * other.dot(normal)).normalize_or_zero();
        element.inside(point) + touching.map(along).sum::<DVec3>() * (IN_FRONT * element.radius())
    }

    /// Whether a point is within a millionth of the scene's extent of a face, whichever way that faces.
    #[must_use]
    pub fn is_on_a_face(&self, point: DVec3) -> bool {
        self.system.mesh.is_near_a_face(self.placement.inward(point), REACH * self.system.extent)
    }

    /// Irradiance at a point anywhere, from the half space that `normal`, of any length, points into: the reading of a sensor
    /// that is there and hides nothing. Faces are exactly where their vertices say, and a face in the sensor's plane gives
    /// nothing; ask [`Self::gather`] for points on faces, which takes them for points of the face's plane.
    ///
    /// ```
    /// use radgrad_core::{DVec3, Polygon};
    /// use radgrad_scene::Scene;
    /// use radgrad_solver::{Options, solve};
    /// // A ceiling of 4 m x 4 m glows with a radiance of 1 at a height of 2.85 m, over a floor that reflects nothing.
    /// let mut scene = Scene::new(["grey"])?;
    /// let (black, glowing) = (scene.add_material("black", [0.0], [0.0])?, scene.add_material("glowing", [0.0], [1.0])?);
    /// let room = scene.add_surface("room");
    /// let corners = [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0)];
    /// let level = |z: f64| corners.map(|(x, y)| DVec3::new(x, y, z)).to_vec();
    /// scene.add_face(room, black, Polygon::new(level(0.0))?, None)?;
    /// scene.add_face(room, glowing, Polygon::new(level(2.85).into_iter().rev().collect())?, None)?;
    /// let solution = solve(&scene, &Options::default(), |_| true)?;
    /// // On the work plane, 0.85 m above the floor: pi times the form factor of a square from below its middle at half its side.
    /// let sensor = solution.irradiance_at(DVec3::new(0.0, 0.0, 0.85), DVec3::Z)?;
    /// let exact = 4.0 * 0.5_f64.sqrt() * 0.5_f64.sqrt().atan();
    /// assert!((sensor.irradiance[0] - exact).abs() <= sensor.estimate[0].total() && sensor.estimate[0].total() < 1e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If the position is not finite, the normal is no direction, or an irradiance cannot be represented.
    pub fn irradiance_at(&self, position: DVec3, normal: DVec3) -> Result<Irradiance, Error> {
        let station = self.station_in_space(position, normal)?;
        self.irradiance_in_space(&station).map_err(|error| error.at_position(position))
    }

    /// A point anywhere, in the coordinates of [`Self::placement`].
    pub(super) fn station_in_space(&self, position: DVec3, normal: DVec3) -> Result<Station, Error> {
        let receiver = Receiver::new(self.placement.inward(position), normal, 1.0);
        Ok(Station::in_space(&receiver.map_err(|source| Error::Sample { position, source })?))
    }

    fn irradiance_in_space(&self, station: &Station) -> Result<Irradiance, Error> {
        let sum = self.sum_in_space(station)?;
        let mut irradiance = self.estimated_sum(station, &sum, None);
        irradiance.correct(&self.lacking_in_gaps(station, &sum.rows)?);
        Ok(irradiance.not_below_zero())
    }

    /// The gather of a point of a leaf.
    pub(super) fn sum_on(&self, leaf: usize, point: DVec3) -> Result<(Station, Sum), Error> {
        let (station, gathers) = self.gathers_on(leaf, point)?;
        let sum = self.sum(&station, gathers, &self.system.far[self.receiver_of(leaf)]);
        Ok((station, sum))
    }

    /// The gather of a point that is on no face.
    pub(super) fn sum_in_space(&self, station: &Station) -> Result<Sum, Error> {
        let optics = self.optics();
        let lit = match self.system.lamps.is_empty() {
            true => None,
            false => {
                let sights = self.system.lamps.sights_from(&self.system.mesh, station)?;
                Some(self.system.lamps.irradiance(&optics, &self.system.surfaces, station, &sights)?)
            }
        };
        let weight = self.whole_weight();
        let need = Need {
            field: &self.radiosity.field,
            weight: &weight,
            allowed: self.budget.allowed,
            without_order: WITHOUT_ORDER,
            of_rays: WITHOUT_ORDER,
            clock: Clock::started(),
        };
        let gatherer = Gatherer::Point(station);
        let (mut links, mut far) = optics.first_links(gatherer, None, &need)?;
        optics.refine(gatherer, (&mut links, &mut far), &need)?;
        let gathers = links.into_iter().flat_map(|link| {
            let (source, sight) = (link.source, link.sight);
            link.rows.into_iter().map(move |row| Gather { source, row, sight: sight.clone() })
        });
        Ok(self.sum(station, Gathers { lit, from_links: gathers.collect() }, &far))
    }

    /// Radiosity at a point of a leaf, in the coordinates of [`Self::placement`].
    ///
    /// # Errors
    /// If it cannot be represented.
    pub fn gather_on(&self, leaf: usize, point: DVec3) -> Result<Gathered, Error> {
        let lacking = self.lacking_beside_edge(leaf, point)?.map(|lacking| (lacking.other.face, lacking.irradiance));
        self.gather_by(&self.optics(), (leaf, point), lacking)
    }

    /// The same by these optics, with the light that it lacks beside an edge of another face.
    pub(crate) fn gather_by(
        &self,
        optics: &Optics<'_>,
        (leaf, point): (usize, DVec3),
        lacking: Option<(usize, Vec<[f64; 2]>)>,
    ) -> Result<Gathered, Error> {
        let (face, channels) = (self.element(leaf).face(), self.channels().len());
        let (station, gathers) = self.gathers_by(optics, leaf, point)?;
        let sum = self.sum(&station, gathers, &self.system.far[self.receiver_of(leaf)]);
        let mut irradiance = self.estimated_sum(&station, &sum, lacking.as_ref().map(|(face, _)| *face));
        irradiance.correct(&self.lacking_in_gaps(&station, &sum.rows)?);
        if let Some((_, lacking)) = lacking {
            irradiance.correct(&lacking);
        }
        irradiance = irradiance.not_below_zero();
        let [rho, emitted] = self.system.surfaces.reflectance_and_emission(face, point);
        let estimate = |c: usize| {
            let rounding = 4.0 * f64::EPSILON * (rho[c] * irradiance.irradiance[c].abs() + emitted[c]);
            irradiance.estimate[c] * rho[c] + Ledger { computation: rounding, ..Ledger::default() }
        };
        Ok(Gathered {
            face,
            leaf,
            radiosity: (0..channels).map(|c| emitted[c] + rho[c] * irradiance.irradiance[c]).collect(),
            estimate: (0..channels).map(estimate).collect(),
            irradiance,
        })
    }

    /// Radiosity at a point of a leaf by one exact gather of the polynomials, not corrected as [`Self::gather_on`] is.
    /// [`Self::gradient_at`] is its gradient.
    ///
    /// # Errors
    /// If it cannot be represented.
    pub fn radiosity_on(&self, leaf: usize, point: DVec3) -> Result<Vec<f64>, Error> {
        let (station, gathers) = self.gathers_on(leaf, point)?;
        let sums = self.sum(&station, gathers, &self.system.far[self.receiver_of(leaf)]).sums;
        let [rho, emitted] = self.system.surfaces.reflectance_and_emission(self.element(leaf).face(), point);
        Ok(sums.iter().zip(&rho).zip(emitted).map(|((sum, rho), emitted)| emitted + rho * sum).collect())
    }

    /// The light that a point lacks in each channel of sources that hang close over it, with an estimate of the error of that.
    /// Such a source fills the view from the place nearest to the point, and an element far larger than the gap has no polynomial
    /// that follows the light at its rim: the point lacks the error of the polynomial at that place, which a gather finds there,
    /// times the source's form factor.
    fn lacking_in_gaps(&self, station: &Station, rows: &[(usize, Row)]) -> Result<Vec<[f64; 2]>, Error> {
        let mut lacking = vec![[0.0; 2]; self.channels().len()];
        for (source, row) in rows {
            let element = self.element(*source);
            let (normal, corner) = (element.polygon().normal(), element.polygon().vertices()[0]);
            let height = normal.dot(station.point - corner);
            if normal.dot(station.normal) > FACING || height <= 0.0 {
                continue;
            }
            let nearest = element.inside(station.point - normal * height);
            let Some(leaf) = self.system.mesh.leaf_at(element.face(), nearest) else { continue };
            if (nearest - station.point).length() > CLOSE * self.element(leaf).radius() {
                continue;
            }
            for (lacking, error) in lacking.iter_mut().zip(self.defect_at(leaf, nearest, &[])?.into_iter().flatten()) {
                let lacks = row.likely_factor() * error;
                *lacking = [lacking[0] + lacks, lacking[1] + lacks.abs()];
            }
        }
        Ok(lacking)
    }

    /// The gather of a point of a leaf, over the links that there are.
    fn gathers_on(&self, leaf: usize, point: DVec3) -> Result<(Station, Gathers), Error> {
        self.gathers_by(&self.optics(), leaf, point)
    }

    fn gathers_by(&self, optics: &Optics<'_>, leaf: usize, point: DVec3) -> Result<(Station, Gathers), Error> {
        let station = Station::on(self.element(leaf), point);
        let lit = self.lit_by(optics, leaf, &station)?;
        let weight = self.whole_weight();
        let gather = |link: &Link| {
            let count = self.basis(link.source).len();
            let optics = optics.for_light(&self.radiosity.field, link.source, &weight);
            let row = optics.receive(&station, link.source, &link.sight, count)?;
            Ok(Gather { source: link.source, row, sight: link.sight.clone() })
        };
        let from_links = self.system.links[self.receiver_of(leaf)].iter().map(gather).collect::<Result<Vec<Gather>, Error>>()?;
        Ok((station, Gathers { lit, from_links }))
    }

    /// The light of lamps that are kept apart, at a point of a leaf.
    pub(crate) fn lit_by(&self, optics: &Optics<'_>, leaf: usize, station: &Station) -> Result<Option<Lit>, Error> {
        let lit = |direct: &Direct| self.system.lamps.irradiance(optics, &self.system.surfaces, station, direct.sights());
        self.radiosity.direct.get(leaf).map(lit).transpose()
    }

    /// The sum of a point's gathers, with the errors of evaluations and links.
    fn sum(&self, station: &Station, Gathers { lit, from_links }: Gathers, far: &Far) -> Sum {
        let channels = self.channels().len();
        let (mut sums, mut errors) = (vec![0.0; channels], vec![Ledger::default(); channels]);
        // Of one sign as often as of the other: they add up by squares.
        let square = |x: f64| x * x;
        if let Some(lit) = &lit {
            for (sum, light) in sums.iter_mut().zip(&lit.irradiance) {
                *sum += light;
            }
            for (sum, &[clear, past]) in errors.iter_mut().zip(&lit.likely) {
                *sum += Ledger { computation: square(clear), visibility: square(past), ..Ledger::default() };
            }
        }
        let (mut rows, mut sights) = (Vec::with_capacity(from_links.len()), Vec::with_capacity(from_links.len()));
        for Gather { source, row, sight } in from_links {
            let is_past = matches!(sight, Sight::Past(_));
            for channel in 0..channels {
                let coefficients = self.radiosity.field.coefficients(source, channel);
                sums[channel] += coefficients.iter().zip(&row.values).map(|(c, v)| c * v).sum::<f64>();
                let (size, sum) = (square(row.likely_error_of(coefficients)), &mut errors[channel]);
                if is_past { sum.visibility += size } else { sum.computation += size }
            }
            rows.push((source, row));
            sights.push(sight);
        }
        let far = far.of_point(&self.optics(), station, &rows);
        for channel in 0..channels {
            sums[channel] += far.value(&self.radiosity.field, channel, 0);
            errors[channel].computation += square(far.likely(&self.radiosity.field, channel, 0));
            errors[channel] = errors[channel].map(f64::sqrt);
        }
        Sum { sums, errors, rows, sights, far, lit }
    }

    /// The irradiance of a point of a leaf with the part of its error whose sign is known.
    pub(super) fn corrected_on(&self, leaf: usize, point: DVec3) -> Result<Vec<f64>, Error> {
        let (station, gathers) = self.gathers_on(leaf, point)?;
        let Sum { sums, rows, sights, far, .. } = self.sum(&station, gathers, &self.system.far[self.receiver_of(leaf)]);
        let known_error = self.error_at(&station, terms(&rows, &sights), &far, None).map(|error| error.known);
        Ok(sums
            .iter()
            .zip(known_error.unwrap_or_else(|| vec![0.0; sums.len()]))
            .map(|(sum, known_error)| sum + known_error)
            .collect())
    }

    /// The sum with its estimate; sources that touch the point of a face that it is `beside` are no part of this.
    fn estimated_sum(
        &self,
        station: &Station,
        Sum { sums, errors, rows, sights, far, .. }: &Sum,
        beside: Option<usize>,
    ) -> Irradiance {
        let channels = self.channels().len();
        // Where no error is known with its sign, its magnitude is estimated, too.
        let without_sign = || {
            let mut truncation =
                self.points().estimate(&self.system, &self.error_estimate, station, (rows, far), &vec![1.0; channels]);
            for (channel, sum) in truncation.iter_mut().enumerate() {
                let neglected =
                    |(source, row): &(usize, Row)| self.radiosity.field.neglected(&self.system.mesh, *source, channel, row);
                sum.computation += rows.iter().map(neglected).sum::<f64>();
            }
            truncation
        };
        let without_sign = || KnownError { known: vec![0.0; channels], left: without_sign() };
        let KnownError { known: correction, left: estimated } =
            self.error_at(station, terms(rows, sights), far, beside).unwrap_or_else(without_sign);
        let rounding = |c: usize| 2.0 * f64::EPSILON * (rows.len() + 2) as f64 * (sums[c].abs() + correction[c].abs());
        let total_estimate = |c: usize| estimated[c] + errors[c] + Ledger { computation: rounding(c), ..Ledger::default() };
        let estimate = (0..channels).map(total_estimate).collect();
        let irradiance = sums.iter().zip(&correction).map(|(sum, correction)| sum + correction).collect();
        Irradiance { irradiance, estimate }.not_below_zero()
    }
}

impl Irradiance {
    /// With 0 in the place of less, which an estimate then covers.
    fn not_below_zero(mut self) -> Self {
        for (irradiance, estimate) in self.irradiance.iter_mut().zip(&mut self.estimate) {
            if *irradiance < 0.0 {
                estimate.discretisation += largest(-*irradiance - estimate.total(), 0.0);
                *irradiance = 0.0;
            }
        }
        self
    }

    /// Adds a correction in each channel, given with an estimate of its error.
    fn correct(&mut self, lacking: &[[f64; 2]]) {
        for (channel, &[lacking, error]) in lacking.iter().enumerate() {
            self.irradiance[channel] += lacking;
            self.estimate[channel].discretisation += error;
        }
    }
}

/// The gather of a point, source by source.
fn terms<'a>(rows: &'a [(usize, Row)], sights: &'a [Sight]) -> impl Iterator<Item = Term<'a>> + Clone {
    rows.iter().zip(sights).map(|((source, row), sight)| Term { source: *source, sight, row })
}
