//! Derivatives of a weighted sum of radiosities by the vertices of faces: of lamps, walls and blockers.
//!
//! With the importance I of the sum, and with emission, reflectance and weights that stay as they are at each place of a face,
//!
//! ```text
//! dJ = int rho I dH + contour (w (B - mean)) v.n ds,   dH = (d kernel, d visibility) B
//! ```
//!
//! where dH is the change of the irradiance at the nodes of the discrete solution, source by source, and the contour is that of faces
//! whose mean is weighed, as their outline moves. Each face's light goes on smoothly beyond its outline, so that nothing else moves within its plane.
//! A receiver moves with its plane: `dH = g.dx + (dH/dn).dn`. A lamp is a constant emission, and so differentiated by
//! [`radgrad_core::derivatives`], past occluders too; so is the polynomial of a source that is seen in part, and one that is seen whole
//! is integrated ([`super::kernel`]).

use radgrad_core::{DVec3, Emission, Emitter, Polygon, derivatives};
use radgrad_scene::Scene;
use rayon::prelude::*;

use crate::error::Error;
use crate::field::Field;
use crate::field::gathering::ratio;
use crate::links::station::Station;
use crate::links::visible::{Visible, Window};
use crate::mesh::Sight;
use crate::mesh::basis::dot;
use crate::mesh::rule::rectangular;
use crate::solve::derivative::hats::{Outline, on_edge};
use crate::solve::derivative::kernel::{CellRules, Pair};
use crate::solve::derivative::{Derivative, WeightedSum};
use crate::solve::solution::Solution;

/// The error of a derivative at a point that is asked for, over the largest of its kind.
const AT_A_POINT: f64 = 1e-6;

/// Pieces of an edge along which a mean is integrated, and Gauss nodes on each.
const PIECES: usize = 16;
const NODES: usize = 3;

/// Elements whose sums are added up one after the other before they meet others: a number that does not depend on the machine.
const TOGETHER: usize = 8;

/// Derivatives of a [`WeightedSum`] by the vertices of faces.
#[derive(Debug, Clone, PartialEq)]
pub struct VertexDerivative {
    /// For each face asked for, each of its vertices and each channel: in the unit of the emission over the scene's unit of length.
    /// Vertices that several faces share, and those of a flat face of more than three, move together: add up their derivatives.
    pub vertices: Vec<Vec<Vec<DVec3>>>,
    /// Estimate of the length of the error of all of them together, in each channel.
    pub estimate: Vec<f64>,
}

/// A weight in each channel: of the importance as it is, and without its highest degree.
type Weights = Vec<[f64; 2]>;

/// The part of an element that a point sees.
enum Seen {
    /// Nothing: it is behind, or these faces hide all of it.
    Nothing(Vec<usize>),
    Whole,
    /// The part that these faces leave, above the horizon.
    Part(Vec<usize>),
}

impl Seen {
    /// The faces that may be between.
    fn between(self) -> Vec<usize> {
        match self {
            Self::Nothing(faces) | Self::Part(faces) => faces,
            Self::Whole => Vec::new(),
        }
    }
}

/// The faces that are asked for, and their shapes.
struct Asked {
    /// Of each face of the scene.
    slots: Vec<Option<usize>>,
    outlines: Vec<Outline>,
    channels: usize,
    rules: CellRules,
}

/// Derivatives by vertex after vertex of the faces asked for, in each channel.
#[derive(Clone)]
struct Sums(Vec<Vec<[DVec3; 2]>>);

impl Asked {
    fn dark(&self) -> Sums {
        Sums(self.outlines.iter().map(|of| vec![[DVec3::ZERO; 2]; of.len() * self.channels]).collect())
    }

    fn has(&self, face: usize) -> bool {
        self.slots[face].is_some()
    }

    /// Adds a derivative by a vertex of a face, times a weight.
    fn add(&self, sums: &mut Sums, (face, vertex, channel): (usize, usize, usize), weight: [f64; 2], by: DVec3) {
        if let Some(slot) = self.slots[face] {
            let sum = &mut sums.0[slot][vertex * self.channels + channel];
            *sum = [sum[0] + by * weight[0], sum[1] + by * weight[1]];
        }
    }

    /// Adds the change of a receiver's light by its place and its normal, as its plane moves.
    fn add_receiver(
        &self,
        sums: &mut Sums,
        (station, channel): (&Station, usize),
        weight: [f64; 2],
        [gradient, by_normal]: [DVec3; 2],
    ) {
        let Some((face, slot)) = station.face.and_then(|face| Some((face, self.slots[face]?))) else { return };
        for (vertex, (hat, slope)) in self.outlines[slot].plane_hats(station.point).enumerate() {
            let by = station.normal * (hat * gradient.dot(station.normal) - by_normal.dot(slope));
            self.add(sums, (face, vertex, channel), weight, by);
        }
    }

    /// Adds derivatives by the corners of a part of a face.
    fn add_corners(
        &self,
        sums: &mut Sums,
        (face, channel): (usize, usize),
        weight: [f64; 2],
        corners: impl Iterator<Item = (DVec3, DVec3)>,
    ) {
        let Some(slot) = self.slots[face] else { return };
        for (corner, by) in corners {
            for (vertex, hat) in self.outlines[slot].hats(corner).into_iter().enumerate() {
                self.add(sums, (face, vertex, channel), weight, by * hat);
            }
        }
    }
}

impl Sums {
    fn add_all(&mut self, other: &Self) {
        for (sum, other) in self.0.iter_mut().flatten().zip(other.0.iter().flatten()) {
            *sum = [sum[0] + other[0], sum[1] + other[1]];
        }
    }
}

impl Solution {
    /// Derivatives of a weighted sum of radiosities by the vertices of some faces, in the scene's order or any other; the cost goes with
    /// the light that these send, receive or hide. Emission and reflectance stay as they are, a texture where it is, and the points of the sum,
    /// too: those on a face move with its plane. A mean is that of the face as it becomes.
    ///
    /// A face that leaves another one, on which it stood, opens a gap, at which there is no derivative: faces that meet move together.
    ///
    /// ```
    /// use radgrad_core::{DVec3, Polygon};
    /// use radgrad_scene::Scene;
    /// use radgrad_solver::{Options, WeightedSum, solve};
    /// // A lamp that radiates 1 hangs over a square of a floor that reflects half.
    /// let mut scene = Scene::new(["grey"])?;
    /// let grey = scene.add_material("grey", [0.5], [0.0])?;
    /// let glowing = scene.add_material("glowing", [0.0], [std::f64::consts::FRAC_1_PI])?;
    /// let (floor, lamp) = (scene.add_surface("floor"), scene.add_surface("lamp"));
    /// let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    /// let below = corners.map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec();
    /// let above = corners.map(|(x, y)| DVec3::new(0.2 * y, 0.2 * x, 1.0)).to_vec();
    /// scene.add_face(floor, grey, Polygon::new(below)?, None)?;
    /// scene.add_face(lamp, glowing, Polygon::new(above)?, None)?;
    /// let solution = solve(&scene, &Options { error: 0.01, ..Options::default() }, |_| true)?;
    /// let sum = WeightedSum { surfaces: vec![vec![1.0], vec![0.0]], points: Vec::new() };
    /// let by = solution.derivative_by_vertices(&scene, &sum, &[1])?;
    /// // The lamp gives less as it is raised, and moving it aside takes nothing from the middle.
    /// let raised: DVec3 = by.vertices[0].iter().map(|vertex| vertex[0]).sum();
    /// assert!(raised.z < 0.0 && raised.x.abs() < 1e-3 * raised.z.abs());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As for [`Self::derivative`]; if a face is not there; or if the scene has so many faces that distant light is gathered from clusters of them.
    pub fn derivative_by_vertices(&self, scene: &Scene, sum: &WeightedSum, faces: &[usize]) -> Result<VertexDerivative, Error> {
        let asked = self.asked(faces)?;
        let mut derivative = Derivative::nothing(scene, self.channels().len());
        let (importance, views) = self.importance_with_views(scene, sum, &mut derivative)?;
        let mut sums = asked.dark();
        self.add_outlines(scene, &asked, &sum.surfaces, &mut sums);
        for (point, view) in sum.points.iter().zip(&views) {
            let of_channel = |(weight, rho): (&f64, &f64)| [weight * rho; 2];
            let weights: Weights = point.weights.iter().zip(&view.rho).map(of_channel).collect();
            let sights = match self.system.lamps.is_empty() {
                true => Vec::new(),
                false => self.system.lamps.sights_from(&self.system.mesh, &view.station)?,
            };
            self.add_lamps(&asked, &mut sums, (&view.station, &weights), &sights)?;
            for ((source, _), sight) in view.sum.rows.iter().zip(&view.sum.sights) {
                self.add_source(&asked, &mut sums, (&view.station, &weights), *source, sight)?;
            }
        }
        let elements: Vec<usize> = (0..self.system.mesh.elements().len()).collect();
        let of_some = |elements: &[usize]| -> Result<Sums, Error> {
            let mut sums = asked.dark();
            elements.iter().try_for_each(|&element| self.add_element(&asked, &mut sums, &importance.sent, element))?;
            Ok(sums)
        };
        let parts = elements.par_chunks(TOGETHER).map(of_some).collect::<Result<Vec<_>, Error>>()?;
        parts.iter().for_each(|part| sums.add_all(part));
        let again = self.add_reflected(&importance, &mut derivative);
        let relative = self.relative_estimates(&derivative, &again);
        Ok(self.vertex_derivative(&asked, &sums, &relative))
    }

    fn asked(&self, faces: &[usize]) -> Result<Asked, Error> {
        let mesh = &self.system.mesh;
        if mesh.clusters().root().is_some() {
            let rule = format!(
                "{} faces are so many that distant light comes from clusters of them: vertices are for fewer",
                mesh.polygons().len()
            );
            return Err(Error::Weights { rule });
        }
        let mut slots = vec![None; mesh.polygons().len()];
        for (slot, &face) in faces.iter().enumerate() {
            let count = slots.len();
            let Some(entry) = slots.get_mut(face) else {
                return Err(Error::Weights { rule: format!("face {face} is asked for, and the scene has {count}, from 0") });
            };
            if entry.replace(slot).is_some() {
                return Err(Error::Weights { rule: format!("face {face} is asked for twice: ask once") });
            }
        }
        let outlines = faces.iter().map(|&face| Outline::from_polygon(&mesh.polygons()[face])).collect();
        Ok(Asked { slots, outlines, channels: self.channels().len(), rules: CellRules::new() })
    }

    /// The derivatives in the coordinates of the scene, and the length of their errors.
    fn vertex_derivative(&self, asked: &Asked, sums: &Sums, relative: &[f64]) -> VertexDerivative {
        let (channels, power) = (asked.channels, self.placement.power());
        let of_face =
            |of: &Vec<[DVec3; 2]>| of.chunks_exact(channels).map(|of| of.iter().map(|[by, _]| *by * power).collect()).collect();
        let estimate = |channel: usize| {
            let pairs = || sums.0.iter().flat_map(move |of| of.iter().skip(channel).step_by(channels));
            let length = |squares: f64| power * squares.sqrt();
            let whole = length(pairs().map(|[by, _]| by.length_squared()).sum());
            length(pairs().map(|[by, lower]| (*by - *lower).length_squared()).sum()) + relative[channel] * whole
        };
        VertexDerivative { vertices: sums.0.iter().map(of_face).collect(), estimate: (0..channels).map(estimate).collect() }
    }

    /// Adds the light that the nodes of an element receive: direct light on a leaf, light of links on a receiver.
    fn add_element(&self, asked: &Asked, sums: &mut Sums, sent: &Field, index: usize) -> Result<(), Error> {
        let (element, basis) = (self.element(index), self.basis(index));
        let direct = self.radiosity.direct.get(index).filter(|_| element.is_leaf());
        let links = self.system.links.get(index).map_or(&[][..], Vec::as_slice);
        if direct.is_none() && links.is_empty() {
            return Ok(());
        }
        let lower = basis.degree().checked_sub(1).map_or(0, |degree| basis.count(degree));
        for (node, (at, values)) in basis.nodes().iter().zip((0..).map(|node| basis.at_node(node))).enumerate() {
            if at.weight == 0.0 {
                continue;
            }
            let part = element.area() * at.weight;
            let of_channel = |channel: usize| {
                let coefficients = sent.coefficients(index, channel);
                [part * dot(coefficients, values), part * dot(&coefficients[..lower], &values[..lower])]
            };
            let weights: Weights = (0..asked.channels).map(of_channel).collect();
            if weights.iter().all(|weight| *weight == [0.0; 2]) {
                continue;
            }
            let station = Station::on(element, element.point(at.at));
            if let Some(direct) = direct {
                self.add_lamps(asked, sums, (&station, &weights), direct.sights())?;
            }
            for link in links {
                let is_dark = link.rows[node].values.iter().all(|value| *value == 0.0);
                if !is_dark {
                    self.add_source(asked, sums, (&station, &weights), link.source, &link.sight)?;
                }
            }
        }
        Ok(())
    }

    /// Adds the light of lamps that are kept apart, face by face.
    fn add_lamps(
        &self,
        asked: &Asked,
        sums: &mut Sums,
        (station, weights): (&Station, &Weights),
        sights: &[Sight],
    ) -> Result<(), Error> {
        let mesh = &self.system.mesh;
        let roots: Vec<(usize, &Sight)> = self.system.lamps.roots().iter().copied().zip(sights).collect();
        let face_of = |(root, _): &(usize, &Sight)| mesh.elements()[*root].face();
        for roots in roots.chunk_by(|a, b| face_of(a) == face_of(b)) {
            let face = face_of(&roots[0]);
            let views = roots.iter().map(|(root, sight)| self.view_of(station, *root, sight));
            let views = views.collect::<Result<Vec<_>, Error>>()?;
            if views.iter().all(|view| matches!(view, Seen::Nothing(_))) {
                continue;
            }
            let mut between: Vec<usize> = views.into_iter().flat_map(Seen::between).collect();
            between.sort_unstable();
            between.dedup();
            let emitted = &self.system.surfaces.emitted[face];
            let weights: Weights =
                weights.iter().zip(emitted).map(|([all, lower], emitted)| [all * emitted, lower * emitted]).collect();
            if self.moves(asked, station, face, &between) {
                let emitter = Emitter::new(mesh.polygons()[face].clone(), Emission::Constant(1.0));
                let emitter = emitter.map_err(|source| station.refused(source))?;
                let light = weights.into_iter().enumerate().collect::<Vec<_>>();
                self.add_seen(asked, sums, (station, &light), (face, &emitter), &between)?;
            }
        }
        Ok(())
    }

    /// The part of an element that a point sees.
    fn view_of(&self, station: &Station, source: usize, sight: &Sight) -> Result<Seen, Error> {
        let mesh = &self.system.mesh;
        let candidates = match sight {
            Sight::Nothing(hidden_by) => return Ok(Seen::Nothing(hidden_by.iter().copied().collect())),
            Sight::Clear => &[][..],
            Sight::Past(faces) => faces,
        };
        let between = match station.sight(mesh, source, Some(candidates))? {
            Sight::Nothing(hidden_by) => return Ok(Seen::Nothing(hidden_by.into_iter().collect())),
            Sight::Clear => Vec::new(),
            Sight::Past(faces) => faces,
        };
        let convex = between.iter().flat_map(|&face| mesh.convex_parts(face)).map(|part| &part[..]);
        let window = Window::on_element(&mesh.elements()[source]);
        let visible = Visible::from_point(station.point, station.normal, &window, convex);
        Ok(match visible.filter(|visible| visible.doubt == 0.0) {
            Some(visible) if visible.whole => Seen::Whole,
            Some(visible) if visible.is_hidden() => Seen::Nothing(between),
            _ => Seen::Part(between),
        })
    }

    /// Whether a face asked for receives, sends or may hide this light.
    fn moves(&self, asked: &Asked, station: &Station, source: usize, between: &[usize]) -> bool {
        asked.has(source) || station.face.is_some_and(|face| asked.has(face)) || between.iter().any(|&face| asked.has(face))
    }

    /// Adds the light of an element's polynomials.
    fn add_source(
        &self,
        asked: &Asked,
        sums: &mut Sums,
        (station, weights): (&Station, &Weights),
        source: usize,
        sight: &Sight,
    ) -> Result<(), Error> {
        let mesh = &self.system.mesh;
        let element = &mesh.elements()[source];
        let face = element.face();
        let between = match sight {
            Sight::Nothing(_) => return Ok(()),
            Sight::Clear => &[][..],
            Sight::Past(faces) => faces,
        };
        if !self.moves(asked, station, face, between) {
            return Ok(());
        }
        let basis = mesh.basis(source);
        let light: Vec<&[f64]> = (0..asked.channels).map(|channel| self.radiosity.field.coefficients(source, channel)).collect();
        let between = match self.view_of(station, source, sight)? {
            Seen::Nothing(_) => return Ok(()),
            Seen::Part(between) => between,
            Seen::Whole => {
                if self.moves(asked, station, face, &[]) {
                    let slopes = Pair { station, element, basis, light: &light }.slopes(&asked.rules);
                    for (channel, (slopes, weight)) in slopes.into_iter().zip(weights).enumerate() {
                        asked.add_receiver(sums, (station, channel), *weight, [slopes.gradient, slopes.normal]);
                        let corners = element.polygon().vertices().iter().copied().zip(slopes.corners);
                        asked.add_corners(sums, (face, channel), *weight, corners);
                    }
                }
                return Ok(());
            }
        };
        for (channel, weight) in weights.iter().enumerate() {
            if *weight != [0.0; 2] && light[channel].iter().any(|c| *c != 0.0) {
                let emitter = element.emitter_of(light[channel], basis)?;
                self.add_seen(asked, sums, (station, &[(channel, *weight)]), (face, &emitter), &between)?;
            }
        }
        Ok(())
    }

    /// Adds the light of an emitter past some faces, in the channels given.
    fn add_seen(
        &self,
        asked: &Asked,
        sums: &mut Sums,
        (station, weights): (&Station, &[(usize, [f64; 2])]),
        (face, emitter): (usize, &Emitter),
        between: &[usize],
    ) -> Result<(), Error> {
        let polygons = self.system.mesh.polygons();
        let occluders: Vec<&Polygon> = between.iter().map(|&face| &polygons[face]).collect();
        let slopes =
            derivatives(&station.receiver()?, emitter, occluders, AT_A_POINT).map_err(|source| station.refused(source))?;
        for &(channel, weight) in weights {
            asked.add_receiver(sums, (station, channel), weight, [slopes.gradient.value, slopes.normal.value]);
            let corners = emitter.polygon().vertices().iter().copied().zip(slopes.vertices.iter().map(|of| of.value));
            asked.add_corners(sums, (face, channel), weight, corners);
            for (&other, by_vertices) in between.iter().zip(&slopes.occluders) {
                for (vertex, by) in by_vertices.iter().enumerate() {
                    asked.add(sums, (other, vertex, channel), weight, by.value);
                }
            }
        }
        Ok(())
    }

    /// Adds the change of means as the outlines of their faces move: the light that comes in at an edge, less the mean.
    fn add_outlines(&self, scene: &Scene, asked: &Asked, weights: &[Vec<f64>], sums: &mut Sums) {
        let mesh = &self.system.mesh;
        for (face, weights) in scene.faces().iter().map(|face| weights.get(face.surface())).enumerate() {
            let Some(weights) = weights.filter(|weights| asked.has(face) && weights.iter().any(|weight| *weight != 0.0)) else {
                continue;
            };
            let surface = scene.faces()[face].surface();
            let of_surface =
                || mesh.roots().iter().filter(|root| scene.faces()[mesh.elements()[**root].face()].surface() == surface);
            let area: f64 = of_surface().map(|&root| mesh.elements()[root].area()).sum();
            let polygon = &mesh.polygons()[face];
            let corners = polygon.vertices();
            for (channel, weight) in weights.iter().enumerate() {
                let power = of_surface().map(|&root| mesh.elements()[root].area() * self.coefficients_on(root, channel)[0]);
                let mean = ratio(power.sum::<f64>(), area);
                for (edge, (from, to)) in (0..).zip(corners.iter().zip(corners.iter().cycle().skip(1))) {
                    let out = (*to - *from).cross(polygon.normal());
                    let pieces = (0..PIECES).flat_map(|piece| rectangular(NODES, 1).into_iter().map(move |node| (piece, node)));
                    for (piece, node) in pieces {
                        let along = (piece as f64 + node.at[0]) / PIECES as f64;
                        let place = *from + (*to - *from) * along;
                        let Some(leaf) = mesh.leaf_at(face, place) else { continue };
                        let values = self.basis(leaf).values(mesh.elements()[leaf].reference(place));
                        let light = dot(&self.coefficients_on(leaf, channel), &values);
                        let density = weight * ratio(light - mean, area) * node.weight / PIECES as f64;
                        for (vertex, hat) in on_edge(edge, along, corners.len()) {
                            asked.add(sums, (face, vertex, channel), [density; 2], out * hat);
                        }
                    }
                }
            }
        }
    }
}
