//! The gradient of one exact gather: within the plane of an element, or of the irradiance in space with the normal kept. It has no bound.
//!
//! For pictures it is taken over the links that there are. A point that is asked for gets links of its own, as if the error asked
//! for were a tenth, which open clusters too; and an estimate of the error. By far the most of the error is that of the
//! polynomials on sources, `grad G r`. [`crate::solve::next_degree`] knows the next degree of r with its sign, and
//! [`crate::solve::second_gather`] its term in the light of sources: both are gathered and added, and the size of the first is one part
//! of the estimate. The others have a size and no sign: the samples beyond the next degree, whose squares add up, and the light
//! that links and clusters neglect. These count by `4/d` of the most that they give, d the distance: `|grad k|` is at most that
//! times the kernel k where neither cosine is small. Beside an edge where two faces meet, [`crate::solve::wedge`] finds the error
//! of the other face near the point: its slope across the edge is added, and the other face's own parts of the estimate are left
//! out there. Of other leaves near the point [`crate::solve::error_gradient`] samples the error, but for leaves whose errors are likely to
//! be little together.

use std::sync::OnceLock;

use radgrad_core::{DVec3, evaluate_to, gradient};

use crate::clock::Clock;
use crate::error::Error;
use crate::gathering::ratio;
use crate::links::cluster::far::Far;
use crate::links::gatherer::Gatherer;
use crate::links::link::Link;
use crate::links::refine::{Need, WITHOUT_ORDER};
use crate::links::station::Station;
use crate::links::transfer::Kernel;
use crate::links::visible::{Visible, Window};
use crate::mesh::Sight;
use crate::mesh::basis::Basis;
use crate::mesh::element::Element;
use crate::mesh::rule::{self, Node};
use crate::mesh::shape::Shape;
use crate::solve::error_gradient::{NEAR, Sampled};
use crate::solve::next_degree::Detail;
use crate::solve::solution::Solution;
use crate::solve::wedge::Lacking;
use radgrad_scene::{largest, smallest};

/// Nodes a side of the rule for gradients from afar, and the distance from the source in its radii from which it serves: there it
/// leaves about 1e-8 of the gradient.
const FAR_NODES: usize = 8;
const FAR: f64 = 2.0;

/// The part of a source's area that is a sliver.
const SLIVER: f64 = 1e-7;

/// Where a shadow line is just on the border between two sources, the one is seen as a whole and the other not at all, and the gradient of
/// neither has the line. So gradients are taken a little aside, in an odd direction, or toward such a place of the leaf: so far over the
/// extent of the scene, and at most over the distance from an edge.
const ASIDE: f64 = 1e-6;
const ASIDE_AT_EDGE: f64 = 1e-3;
const ODD: DVec3 = DVec3::new(0.37, 0.29, 0.23);

/// The part of links for a gradient at a point in the light that links may neglect.
const FINER: f64 = 0.1;

/// Bound on the length of the kernel's gradient over the kernel, times the distance, where both cosines are near 1.
const STEEPNESS: f64 = 4.0;

/// Leaves near a point are not sampled that together leave less of the gradient, over the error asked for.
const LITTLE: f64 = 1.5;

/// A gradient in each channel, with respect to the position, the normal kept: in the unit of radiosity over the scene's unit of length.
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
/// let slope = solution.irradiance_gradient_at(0.5 * (low + high), DVec3::Y)?;
/// assert!(slope.gradient[0].is_finite() && slope.estimate[0] >= 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Gradient {
    /// The gradient.
    pub gradient: Vec<DVec3>,
    /// Estimate of the length of its error; no bound is proven.
    pub estimate: Vec<f64>,
}

/// A gradient and the parts of its estimate, in each channel.
struct Parts {
    /// Whether the known detail is in the gradient.
    adds_details: bool,
    /// Leaves near the point, of which more may be known.
    near: Vec<LeafError>,
    /// That of the polynomials on sources, and of their known error.
    gradient: Vec<DVec3>,
    /// That of the detail.
    detail: Vec<DVec3>,
    /// The square of the gradient's error from degrees beyond the detail.
    truncation: Vec<f64>,
    neglected: Vec<f64>,
}

/// The error of a leaf: in each channel, the gradient of the detail, and the square of the truncation.
struct LeafError {
    leaf: usize,
    sight: Sight,
    detail: Vec<DVec3>,
    truncation: Vec<f64>,
}

impl Parts {
    /// Adds the error of a leaf to the estimate.
    fn leave(&mut self, leaf_error: LeafError) {
        self.detail.iter_mut().zip(leaf_error.detail).for_each(|(sum, of)| *sum += of);
        self.truncation.iter_mut().zip(leaf_error.truncation).for_each(|(sum, of)| *sum += of);
    }

    fn joined(self) -> Gradient {
        let size = |c: usize| self.detail[c].length().hypot(self.truncation[c].sqrt()) + self.neglected[c];
        let estimate = (0..self.gradient.len()).map(size).collect();
        Gradient { gradient: self.gradient, estimate }
    }
}

impl Gradient {
    fn times(mut self, factor: f64) -> Self {
        self.gradient.iter_mut().for_each(|of| *of *= factor);
        self.estimate.iter_mut().for_each(|of| *of *= factor);
        self
    }

    fn reflected(&self, rho: &[f64]) -> Self {
        let gradient = self.gradient.iter().zip(rho).map(|(of, rho)| *of * *rho).collect();
        Self { gradient, estimate: self.estimate.iter().zip(rho).map(|(of, rho)| of * rho).collect() }
    }
}

/// Gradients at a point of a face.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceGradient {
    /// Of the radiosity.
    pub radiosity: Gradient,
    /// Of the irradiance.
    pub irradiance: Gradient,
}

impl Solution {
    /// Gradients of radiosity and irradiance at a point on the face that is there and faces along `normal`, within the face's plane.
    /// Textures do not change within a texel: the gradient of the radiosity is that of the irradiance times the reflectance there.
    /// Gradients are off by more than values are: in the Cornell box by less than 1 % at 95 of a hundred places if it is solved to an error
    /// of 1e-3, and at 99 with 2e-4.
    ///
    /// # Errors
    /// As for [`Self::gather`].
    pub fn gradient(&self, point: DVec3, normal: DVec3) -> Result<SurfaceGradient, Error> {
        let (leaf, foot) = self.leaf_of(point, normal)?;
        let irradiance = self.gradient_in_plane(leaf, foot)?.times(self.placement.power());
        let [rho, _] = self.system.surfaces.reflectance_and_emission(self.element(leaf).face(), foot);
        Ok(SurfaceGradient { radiosity: irradiance.reflected(&rho), irradiance })
    }

    /// Gradient of the irradiance at a point anywhere, as [`Self::irradiance_at`] has it, in all directions.
    ///
    /// ```
    /// use radgrad_core::{DVec3, Polygon};
    /// use radgrad_scene::Scene;
    /// use radgrad_solver::{Options, solve};
    /// // A disc's worth of light: under the middle of a glowing square the irradiance changes upward alone.
    /// let mut scene = Scene::new(["grey"])?;
    /// let (glowing, lamp) = (scene.add_material("glowing", [0.0], [1.0])?, scene.add_surface("lamp"));
    /// let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
    /// scene.add_face(lamp, glowing, Polygon::new(corners.to_vec())?, None)?;
    /// let solution = solve(&scene, &Options::default(), |_| true)?;
    /// let gradient = solution.irradiance_gradient_at(DVec3::ZERO, DVec3::Z)?.gradient[0];
    /// let irradiance = |z: f64| solution.irradiance_at(DVec3::new(0.0, 0.0, z), DVec3::Z).map(|gather| gather.irradiance[0]);
    /// let difference = (irradiance(1e-4)? - irradiance(-1e-4)?) / 2e-4;
    /// assert!(gradient.x.abs() < 1e-9 && gradient.y.abs() < 1e-9 && (gradient.z - difference).abs() < 1e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As for [`Self::irradiance_at`].
    pub fn irradiance_gradient_at(&self, position: DVec3, normal: DVec3) -> Result<Gradient, Error> {
        let mut station = self.station_in_space(position, normal)?;
        let aside = ASIDE * self.system.extent;
        if self.has_shadows() && !self.system.mesh.is_near_a_face(station.point, aside / ASIDE_AT_EDGE) {
            station.point += aside * ODD.normalize();
        }
        let parts = self.gradient_of_station(&station, None, &[]).map_err(|error| error.at_position(position))?;
        Ok(parts.joined().times(self.placement.power()))
    }

    /// Gradient of the irradiance within the plane of a leaf, by links of the point's own.
    fn gradient_in_plane(&self, leaf: usize, point: DVec3) -> Result<Gradient, Error> {
        let element = self.element(leaf);
        let near_edges = self.lacking_near_edges(leaf, point)?;
        let mut station = Station::on(element, point);
        if self.has_shadows() {
            let to_edge = near_edges.iter().map(|edge| edge.other.distance_of(point)).fold(f64::INFINITY, smallest);
            let way = (element.point(ODD.truncate().to_array()) - point).normalize_or_zero();
            station.point += smallest(ASIDE * self.system.extent, ASIDE_AT_EDGE * to_edge) * way;
        }
        let mut parts = self.gradient_of_station(&station, Some(leaf), &near_edges)?;
        let normal = element.polygon().normal();
        let within = |of: &mut DVec3| *of = of.reject_from_normalized(normal);
        parts.gradient.iter_mut().chain(&mut parts.detail).for_each(within);
        let mut joined = parts.joined();
        if let Some(Lacking { away, slope, .. }) = near_edges.into_iter().find(|edge| edge.is_beside) {
            for (channel, [slope, error]) in slope.into_iter().enumerate() {
                joined.gradient[channel] += away * slope;
                joined.estimate[channel] += error;
            }
        }
        Ok(joined)
    }

    /// Gradient of the irradiance of a point, which may be one of a leaf, near edges of its face or not.
    fn gradient_of_station(&self, station: &Station, leaf: Option<usize>, near_edges: &[Lacking]) -> Result<Parts, Error> {
        let (optics, channels) = (self.optics(), self.channels().len());
        let weight = self.whole_weight();
        let need = Need {
            field: &self.radiosity.field,
            weight: &weight,
            without_order: WITHOUT_ORDER,
            of_rays: WITHOUT_ORDER,
            allowed: FINER * self.budget.allowed,
            clock: Clock::started(),
        };
        let gatherer = Gatherer::Point(station);
        let receiver = leaf.map(|leaf| self.receiver_of(leaf));
        let linked = receiver.map(|receiver| (&self.system.links[receiver][..], &self.system.far[receiver]));
        let (mut links, mut far) = optics.first_links(gatherer, linked, &need)?;
        optics.refine(gatherer, (&mut links, &mut far), &need)?;
        let lamps = match leaf.and_then(|leaf| self.radiosity.direct.get(leaf)) {
            Some(direct) => direct.sights().to_vec(),
            None => self.system.lamps.sights_from(&self.system.mesh, station)?,
        };
        let mut parts = Parts {
            adds_details: self.has_sure_details(),
            near: Vec::new(),
            gradient: vec![DVec3::ZERO; channels],
            detail: vec![DVec3::ZERO; channels],
            truncation: vec![0.0; channels],
            neglected: vec![0.0; channels],
        };
        for (root, sight) in self.system.lamps.roots().iter().zip(&lamps) {
            let emitted = &self.system.surfaces.emitted[self.element(*root).face()];
            let coefficients: Vec<&[f64]> = emitted.chunks_exact(1).collect();
            let of_lamp = self.gradients_from((*root, self.basis(*root)), sight, station, &coefficients)?;
            parts.gradient.iter_mut().zip(of_lamp).for_each(|(sum, of)| *sum += of);
        }
        links.iter().try_for_each(|link| self.add_gradient_of(station, link, &mut parts))?;
        self.sample_near(station, near_edges, &mut parts)?;
        let near = self.nearest_of(station, &far);
        for (channel, sum) in parts.neglected.iter_mut().enumerate() {
            let neglected = far.likely(&self.radiosity.field, channel, 0);
            *sum += if neglected > 0.0 { STEEPNESS * neglected / near } else { 0.0 };
        }
        Ok(parts)
    }

    /// Whether any face hides anything.
    fn has_shadows(&self) -> bool {
        let is_past = |sight: &Sight| matches!(sight, Sight::Past(_));
        let of_links = || self.system.links.iter().flatten().any(|link| is_past(&link.sight));
        of_links() || self.radiosity.direct.iter().any(|direct| direct.sights().iter().any(is_past))
    }

    /// Adds the parts of a link: of its source, or if the point is near of the source's descendants.
    fn add_gradient_of(&self, station: &Station, link: &Link, parts: &mut Parts) -> Result<(), Error> {
        let (row, mut open) = (&link.rows[0], vec![link.source]);
        while let Some(source) = open.pop() {
            let element = self.element(source);
            if let Some(first) = element.children().filter(|_| element.nearness_to(station.point) > NEAR) {
                open.extend(first..first + 4);
                continue;
            }
            let steep = STEEPNESS / (element.centre() - station.point).length();
            // The link has a row for the whole alone.
            let kernel = (source != link.source).then(|| Kernel::bound(station, element));
            let factor = kernel.as_ref().map_or(row.factor(), |kernel| smallest(kernel.peak, row.factor()));
            for (channel, sum) in parts.neglected.iter_mut().enumerate() {
                let neglected = match &kernel {
                    None => self.radiosity.field.neglected(&self.system.mesh, source, channel, row),
                    Some(kernel) => self.radiosity.field.neglected_by(&self.system.mesh, source, channel, (factor, kernel)),
                };
                *sum += steep * neglected;
            }
            self.add_gradient_of_source(station, (source, &link.sight), steep * factor, parts)?;
        }
        Ok(())
    }

    /// Adds those of a source, whose kernel's gradient is so long at most.
    fn add_gradient_of_source(
        &self,
        station: &Station,
        (source, sight): (usize, &Sight),
        steep: f64,
        parts: &mut Parts,
    ) -> Result<(), Error> {
        let (basis, element) = (self.basis(source), self.element(source));
        let sight = self.sight_from(station, source, sight)?;
        let with_error = |channel: usize| -> Vec<f64> {
            let held = self.radiosity.field.coefficients(source, channel);
            let field_error = self.known_error().map(|error| error.coefficients(source, channel));
            field_error.map_or_else(
                || held.to_vec(),
                |field_error| held.iter().zip(field_error).map(|(held, field_error)| held + field_error).collect(),
            )
        };
        let coefficients: Vec<Vec<f64>> = (0..parts.gradient.len()).map(with_error).collect();
        let coefficients: Vec<&[f64]> = coefficients.iter().map(|of| &of[..]).collect();
        let gradients = self.gradients_of((element, basis), &sight, station, &coefficients)?;
        parts.gradient.iter_mut().zip(gradients).for_each(|(sum, of)| *sum += of);
        let details = &self.details()[source];
        let (None, Some(above)) = (element.children(), basis.above()) else { return Ok(()) };
        let near = element.nearness_to(station.point);
        let coefficients: Vec<&[f64]> = details.iter().map(|of| &of.coefficients[..]).collect();
        let gradients = self.gradients_of((element, above), &sight, station, &coefficients)?;
        for (channel, of) in gradients.iter().enumerate().filter(|_| parts.adds_details) {
            parts.gradient[channel] += *of * details[channel].sure();
        }
        // A residual orthogonal to the polynomials counts by the kernel's part beyond them, or by its own part along them as
        // far as the samples allow one.
        let falls: f64 = std::iter::repeat_n(near, above.degree() + 1).product();
        let part = largest(falls, 1.0 / (above.degree() + 1) as f64);
        let truncation = |of: &Detail| {
            let size = steep * (part * of.truncation).hypot(of.neglected);
            size * size
        };
        let leaf_error =
            LeafError { leaf: source, sight, detail: gradients, truncation: details.iter().map(truncation).collect() };
        if parts.adds_details && near > NEAR {
            parts.near.push(leaf_error);
        } else {
            parts.leave(leaf_error);
        }
        Ok(())
    }

    /// Samples the errors of leaves near a station, but for those that together add little.
    fn sample_near(&self, station: &Station, near_edges: &[Lacking], parts: &mut Parts) -> Result<(), Error> {
        let projected = |v: DVec3| station.face.map_or(v, |_| v.reject_from_normalized(station.normal));
        let whole: Vec<f64> = parts.gradient.iter().map(|of| projected(*of).length_squared()).collect();
        let size = |leaf_error: LeafError| {
            let relative_square =
                |c: usize| ratio(projected(leaf_error.detail[c]).length_squared() + leaf_error.truncation[c], whole[c]);
            ((0..whole.len()).map(relative_square).fold(0.0, largest), leaf_error)
        };
        let mut near: Vec<(f64, LeafError)> = std::mem::take(&mut parts.near).into_iter().map(size).collect();
        near.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        let beside = near_edges.iter().find(|edge| edge.is_beside).map(|edge| edge.other.face);
        let little = LITTLE * self.budget.asked;
        let mut total = 0.0;
        for (size, leaf_error) in near {
            total += size;
            let element = self.element(leaf_error.leaf);
            if total > little * little {
                let sampled = self.gradient_of_samples(station, (leaf_error.leaf, &leaf_error.sight), near_edges)?;
                for (channel, Sampled { gradient, squared_error }) in sampled.into_iter().enumerate() {
                    parts.gradient[channel] += gradient;
                    parts.truncation[channel] += squared_error;
                }
            } else if beside != Some(element.face()) || element.nearness_to(station.point) < 1.0 {
                parts.leave(leaf_error);
            }
        }
        Ok(())
    }

    /// Distance from a point to the nearest cluster's box that is more than nothing.
    fn nearest_of(&self, station: &Station, far: &Far) -> f64 {
        let distance = |&cluster: &usize| {
            let cluster = &self.system.mesh.clusters().clusters()[cluster];
            let (low, high) = (cluster.low - station.point, cluster.high - station.point);
            (low.max(DVec3::ZERO) + high.min(DVec3::ZERO)).length()
        };
        far.clusters().iter().map(distance).fold(f64::INFINITY, smallest)
    }

    /// Gradient of one exact gather within the leaf's plane, in each channel: the closed forms' at nearby and half hidden sources,
    /// without bound. Point and gradient have the coordinates of [`Self::placement`]. For light through clusters it is the
    /// gradient of the receiver's polynomial. Within a texel the reflectance is constant, so a texture's gradient is that of the
    /// irradiance times the reflectance there.
    ///
    /// # Errors
    /// If it cannot be represented.
    pub fn gradient_at(&self, leaf: usize, point: DVec3) -> Result<Vec<DVec3>, Error> {
        let mut sums = self.reflected_gradient_at(self.receiver_of(leaf), point)?;
        sums.iter_mut().zip(self.direct_gradient_at(leaf, point)?).for_each(|(sum, direct)| *sum += direct);
        let receiver = self.receiver_of(leaf);
        sums.iter_mut().enumerate().for_each(|(channel, sum)| *sum += self.gradient_of_clusters(receiver, channel, point));
        let [rho, _] = self.system.surfaces.reflectance_and_emission(self.mesh().elements()[leaf].face(), point);
        Ok(sums.iter().zip(&rho).map(|(sum, rho)| *sum * *rho).collect())
    }

    /// The gradient of the light through clusters, projected on a receiver.
    fn gradient_of_clusters(&self, receiver: usize, channel: usize, point: DVec3) -> DVec3 {
        let (far, basis, element) = (&self.system.far[receiver], self.basis(receiver), self.element(receiver));
        if far.is_empty() {
            return DVec3::ZERO;
        }
        let at_nodes: Vec<f64> = (0..basis.nodes().len()).map(|node| far.value(&self.radiosity.field, channel, node)).collect();
        let (coefficients, slopes) = (basis.project(&at_nodes), basis.slopes(element.reference(point)));
        element.gradient([0, 1].map(|k| coefficients.iter().zip(&slopes).map(|(c, s)| c * s[k]).sum()))
    }

    /// The part of the irradiance of lamps, at a point of a leaf.
    pub(crate) fn direct_gradient_at(&self, leaf: usize, point: DVec3) -> Result<Vec<DVec3>, Error> {
        let emitted = |lamp: usize| self.system.surfaces.emitted[self.mesh().elements()[lamp].face()].chunks_exact(1).collect();
        let lamps = self.radiosity.direct.get(leaf).into_iter().flat_map(|direct| self.system.lamps.roots_with_sights(direct));
        self.gradient_of(leaf, point, lamps.map(|(lamp, sight)| (lamp, sight, emitted(lamp))))
    }

    /// The part of the irradiance of all else, at a point of a receiver.
    pub(crate) fn reflected_gradient_at(&self, receiver: usize, point: DVec3) -> Result<Vec<DVec3>, Error> {
        let coefficients = |source: usize| {
            (0..self.channels().len()).map(|channel| self.radiosity.field.coefficients(source, channel)).collect()
        };
        let links = self.system.links[receiver].iter();
        self.gradient_of(receiver, point, links.map(|link| (link.source, &link.sight, coefficients(link.source))))
    }

    /// Gradient within an element's plane of the irradiance of sources with the coefficients of each channel.
    fn gradient_of<'a>(
        &self,
        element: usize,
        point: DVec3,
        sources: impl Iterator<Item = (usize, &'a Sight, Vec<&'a [f64]>)>,
    ) -> Result<Vec<DVec3>, Error> {
        let element = &self.mesh().elements()[element];
        let (station, normal) = (Station::on(element, point), element.polygon().normal());
        let mut sums = vec![DVec3::ZERO; self.channels().len()];
        for (source, sight, coefficients) in sources {
            let gradients = self.gradients_from((source, self.basis(source)), sight, &station, &coefficients)?;
            sums.iter_mut().zip(gradients).for_each(|(sum, gradient)| *sum += gradient.reject_from_normalized(normal));
        }
        Ok(sums)
    }

    /// Gradient of the light of a source at a point with the coefficients of each channel. All functions together: that of one
    /// alone is zero where it is symmetric, and no number of digits tells zero from nearly so.
    fn gradients_from(
        &self,
        (source_index, basis): (usize, &Basis),
        sight: &Sight,
        station: &Station,
        coefficients: &[&[f64]],
    ) -> Result<Vec<DVec3>, Error> {
        let source = self.element(source_index);
        self.gradients_of((source, basis), &self.sight_from(station, source_index, sight)?, station, coefficients)
    }

    /// A station's own sight of a source that is known to be seen past some faces.
    fn sight_from(&self, station: &Station, source: usize, sight: &Sight) -> Result<Sight, Error> {
        match sight {
            Sight::Past(known) => station.sight(&self.system.mesh, source, Some(known)),
            other => Ok(other.clone()),
        }
    }

    /// The same of an element that need not be of the mesh, as the station sees it.
    pub(super) fn gradients_of(
        &self,
        (source, basis): (&Element, &Basis),
        sight: &Sight,
        station: &Station,
        coefficients: &[&[f64]],
    ) -> Result<Vec<DVec3>, Error> {
        let (mesh, point, normal) = (self.mesh(), station.point, station.normal);
        let refused = |source| station.refused(source);
        if matches!(sight, Sight::Nothing(_)) {
            return Ok(vec![DVec3::ZERO; coefficients.len()]);
        }
        let whole = |v: &DVec3| normal.dot(*v - point) > 1e-9 * (*v - point).length();
        let (of_source, distance) = (source.polygon(), (point - source.centre()).length() - source.radius());
        let in_front = of_source.normal().dot(point - of_source.vertices()[0]) > 0.0;
        if *sight == Sight::Clear && in_front && distance >= FAR * source.radius() && of_source.vertices().iter().all(whole) {
            let count = coefficients.first().map_or(0, |c| c.len());
            let of_functions = from_afar(point, normal, source, basis, count);
            let sum = |c: &&[f64]| c.iter().zip(&of_functions).map(|(c, g)| *g * *c).sum();
            return Ok(coefficients.iter().map(sum).collect());
        }
        if matches!(sight, Sight::Past(_)) && self.is_sliver(station, source, sight.faces()) {
            return Ok(vec![DVec3::ZERO; coefficients.len()]);
        }
        let receiver = station.receiver()?;
        let occluders: Vec<_> = match &sight {
            Sight::Past(faces) => faces.iter().map(|&f| mesh.polygons()[f].clone()).collect(),
            _ => Vec::new(),
        };
        let of_channel = |coefficients: &&[f64]| {
            if coefficients.iter().all(|c| *c == 0.0) {
                return Ok(DVec3::ZERO);
            }
            let emitter = source.emitter_of(coefficients, basis)?;
            if occluders.is_empty() {
                return gradient(&receiver, &emitter).map_err(refused);
            }
            // The first rung's digits are more than the choice of elements to divide needs.
            evaluate_to(&receiver, &emitter, &occluders, 1.0).map(|answer| answer.gradient).map_err(refused)
        };
        // Channels that are alike, as where all is grey, are evaluated once.
        let mut gradients: Vec<DVec3> = Vec::with_capacity(coefficients.len());
        for (channel, of) in coefficients.iter().enumerate() {
            let alike = coefficients[..channel].iter().position(|other| other == of);
            gradients.push(alike.map_or_else(|| of_channel(of), |alike| Ok(gradients[alike]))?);
        }
        Ok(gradients)
    }
}

impl Solution {
    /// Whether no more of a source is visible past some faces than rounding explains. Its light is about to appear or to be gone:
    /// of the two gradients there that of the dark is taken. To decide between them would take hundreds of digits.
    fn is_sliver(&self, station: &Station, source: &Element, faces: &[usize]) -> bool {
        let parts = faces.iter().flat_map(|&face| self.mesh().convex_parts(face)).map(|part| &part[..]);
        let visible = Visible::from_point(station.point, station.normal, &Window::on_element(source), parts);
        visible.is_some_and(|visible| visible.share(source.shape()) <= SLIVER + 2.0 * visible.doubt)
    }
}

/// The gradient of the kernel `k = h (n1.r) / pi r^4`, `(n2 (n1.r) - h n1) / r^4 + 4 h (n1.r) r / r^6` over pi, by a product rule.
fn from_afar(point: DVec3, normal: DVec3, source: &Element, basis: &Basis, count: usize) -> Vec<DVec3> {
    static RULES: OnceLock<[Vec<Node>; 2]> = OnceLock::new();
    let [on_squares, on_triangles] = RULES.get_or_init(|| [rule::product(FAR_NODES), rule::collapsed(FAR_NODES)]);
    let nodes = match source.shape() {
        Shape::Parallelogram => on_squares,
        Shape::Triangle => on_triangles,
    };
    let mut values = vec![0.0; basis.len()];
    let height = source.polygon().normal().dot(point - source.polygon().vertices()[0]);
    let scale = source.area() / std::f64::consts::PI;
    let mut gradients = vec![DVec3::ZERO; count];
    for node in nodes {
        let r = source.point(node.at) - point;
        let inverse = 1.0 / r.length_squared();
        let cosine = normal.dot(r);
        let slope = source.polygon().normal() * cosine - normal * height + r * (4.0 * height * cosine * inverse);
        let slope = slope * (node.weight * scale * inverse * inverse);
        basis.fill(node.at, &mut values);
        for (sum, value) in gradients.iter_mut().zip(&values) {
            *sum += slope * *value;
        }
    }
    gradients
}
