//! Derivatives of a weighted sum of radiosities by the emission and the reflectance of every face, from one importance.
//!
//! For `J = int w B` with `B = E + rho G B` and the importance `I = w + G rho I`,
//!
//! ```text
//! dJ/dE_f = int_f I        dJ/drho_f = int_f I H,   H = G B the irradiance
//! ```
//!
//! as G is the same both ways (B. Smits, J. Arvo and D. Salesin 1992). Both integrals run over the polynomials of the solution, on its
//! links; the light of a lamp that is kept apart is `int I rho H_1` with its direct light `H_1` at the nodes of leaves. J is linear in
//! the emission, so that `sum E_f dJ/dE_f` is J once more: the difference of the two is the error that links, clusters and polynomials
//! make in I.

mod integrands;
mod outline;
mod sampled;
mod vertices;

use radgrad_core::DVec3;
use radgrad_scene::Scene;
use rayon::prelude::*;

use crate::error::Error;
use crate::field::Field;
use crate::gathering::{MOST_SWEEPS, ratio};
use crate::links::station::Station;
use crate::mesh::basis::dot;
use crate::solve::derivative::integrands::Viewpoint;
use crate::solve::gather::Sum;
use crate::solve::solution::Solution;

/// Changes, relative to the mean, below which the importance is solved.
const SOLVED: f64 = 1e-10;

/// The estimate of a derivative over the errors of the sum by the importance and of the solution: single faces are off by more than all
/// together. In the Cornell box derivatives by reflectance were off by 0.5 to 4.7 times the latter.
const OF_ONE_FACE: f64 = 2.0;

/// A sum of radiosities with weights.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WeightedSum {
    /// For each surface of the scene, in each channel, the weight of its mean radiosity; empty for none.
    pub surfaces: Vec<Vec<f64>>,
    /// Points: of a face there, the radiosity; elsewhere the irradiance, as [`Solution::irradiance_at`].
    pub points: Vec<WeightedPoint>,
}

/// A point of a [`WeightedSum`].
#[derive(Debug, Clone, PartialEq)]
pub struct WeightedPoint {
    /// Position, in the coordinates of the scene.
    pub position: DVec3,
    /// Normal, of any length.
    pub normal: DVec3,
    /// The weight in each channel.
    pub weights: Vec<f64>,
}

/// Derivatives of a [`WeightedSum`], channel by channel: light of one channel makes none in another.
#[derive(Debug, Clone, PartialEq)]
pub struct Derivative {
    /// The sum in each channel, of the polynomials and gathers as they are, without corrections.
    pub value: Vec<f64>,
    /// For each face of the scene and channel, by the radiosity that the face emits evenly, pi times its radiance.
    pub emission: Vec<Vec<f64>>,
    /// For each face of the scene and channel, by an even change of its reflectance.
    pub reflectance: Vec<Vec<f64>>,
    /// Estimate of the error of each derivative relative to it, in each channel: by how much the sum that the importance gives differs
    /// from the sum, and the estimate of the solution.
    pub relative_estimate: Vec<f64>,
    /// For each face of the scene, each vertex of it and channel, by the vertex's place: the gradient, per unit of length of the scene. Empty
    /// but of [`Solution::derivative_with_vertices`].
    pub vertices: Vec<Vec<Vec<DVec3>>>,
    /// Estimates of the lengths of their errors.
    pub vertices_estimate: Vec<Vec<Vec<f64>>>,
}

/// The importance: the part that comes at once, and all of it as it is sent.
struct Importance {
    first: Field,
    sent: Field,
}

/// A point of a sum, and all that it gathers.
struct View {
    station: Station,
    sum: Sum,
    face: Option<usize>,
    rho: Vec<f64>,
    emitted: Vec<f64>,
}

impl Solution {
    /// Derivatives of a weighted sum of radiosities by the emission and the reflectance of every face. Their cost is that of one
    /// solution of the linear system, however many faces there are.
    ///
    /// ```
    /// use radgrad_solver::{Options, WeightedSum, solve};
    /// # use radgrad_scene::{Degenerate, Scene};
    /// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");
    /// # let scene = Scene::read(file, Degenerate::Refuse)?;
    /// let options = Options { error: 0.5, degree: Some(1), first_elements: 1, ..Options::default() };
    /// let solution = solve(&scene, &options, |_| true)?;
    /// // The mean radiosity of the first surface.
    /// let mut surfaces = vec![vec![0.0; scene.channels().len()]; scene.surfaces().len()];
    /// surfaces[0].fill(1.0);
    /// let derivative = solution.derivative(&scene, &WeightedSum { surfaces, points: Vec::new() })?;
    /// // A brighter wall lights it, and so does a lamp.
    /// assert!(derivative.reflectance.iter().flatten().all(|by| *by >= 0.0));
    /// assert!(derivative.emission.iter().flatten().any(|by| *by > 0.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If weights are not one for each surface and channel or not finite, a point is nowhere, or the importance does not settle.
    pub fn derivative(&self, scene: &Scene, sum: &WeightedSum) -> Result<Derivative, Error> {
        Ok(self.derivative_by_importance(scene, sum)?.0)
    }

    /// The same with the derivatives by the vertices of every face: of lamps that move, of screens, of the room.
    ///
    /// # Errors
    /// As for [`Self::derivative`].
    pub fn derivative_with_vertices(&self, scene: &Scene, sum: &WeightedSum) -> Result<Derivative, Error> {
        let (mut derivative, Importance { sent, .. }, views) = self.derivative_by_importance(scene, sum)?;
        let viewpoint = |(View { station, rho, .. }, point): (View, &WeightedPoint)| Viewpoint {
            station,
            weights: point.weights.iter().zip(rho).map(|(weight, rho)| weight * rho).collect(),
        };
        let points = views.into_iter().zip(&sum.points).map(viewpoint).collect();
        self.add_vertices(scene, sum, (&sent, points), &mut derivative);
        Ok(derivative)
    }

    /// Derivatives by emission and reflectance, the importance that they are made of, and the views of the points.
    fn derivative_by_importance(&self, scene: &Scene, sum: &WeightedSum) -> Result<(Derivative, Importance, Vec<View>), Error> {
        self.check_weights(scene, sum)?;
        let (channels, faces) = (self.system.channels.len(), scene.faces().len());
        let mut derivative = Derivative {
            value: vec![0.0; channels],
            emission: vec![vec![0.0; channels]; faces],
            reflectance: vec![vec![0.0; channels]; faces],
            relative_estimate: vec![0.0; channels],
            vertices: Vec::new(),
            vertices_estimate: Vec::new(),
        };
        let mut first = Field::dark(&self.system.mesh, channels);
        self.weigh_surfaces(scene, &sum.surfaces, &mut first, &mut derivative);
        let views = sum.points.par_iter().map(|point| self.view(point)).collect::<Result<Vec<_>, Error>>()?;
        self.weigh_points(&sum.points, &views, &mut first, &mut derivative);
        let importance = self.importance_from(first)?;
        let again = self.add_reflected(&importance, &mut derivative);
        for (channel, again) in again.into_iter().enumerate() {
            let value = derivative.value[channel];
            let of_all = ratio((again - value).abs(), value.abs()) + self.progress.estimate;
            derivative.relative_estimate[channel] = OF_ONE_FACE * of_all;
        }
        Ok((derivative, importance, views))
    }

    fn check_weights(&self, scene: &Scene, sum: &WeightedSum) -> Result<(), Error> {
        let channels = self.system.channels.len();
        let refused = |rule: String| Err(Error::Weights { rule });
        if !sum.surfaces.is_empty() && sum.surfaces.len() != scene.surfaces().len() {
            let (given, surfaces) = (sum.surfaces.len(), scene.surfaces().len());
            return refused(format!("{given} lists are given, and the scene has {surfaces} surfaces: give one for each"));
        }
        let surfaces = sum.surfaces.iter().enumerate().map(|(index, weights)| ("surface", index, weights));
        let points = sum.points.iter().enumerate().map(|(index, point)| ("point", index, &point.weights));
        for (kind, index, weights) in surfaces.chain(points) {
            if weights.len() != channels {
                return refused(format!(
                    "{kind} {index} has {}, and the scene {channels} channels: give one for each",
                    weights.len()
                ));
            }
            if let Some(weight) = weights.iter().find(|weight| !weight.is_finite()) {
                return refused(format!("{kind} {index} has {weight}: a weight is a finite number"));
            }
        }
        Ok(())
    }

    /// Adds the mean radiosities of surfaces.
    fn weigh_surfaces(&self, scene: &Scene, weights: &[Vec<f64>], first: &mut Field, derivative: &mut Derivative) {
        if weights.is_empty() {
            return;
        }
        let mesh = &self.system.mesh;
        let of_root = |root: usize| (scene.faces()[mesh.elements()[root].face()].surface(), mesh.elements()[root].area());
        let mut areas = vec![0.0; weights.len()];
        for (surface, area) in mesh.roots().iter().map(|&root| of_root(root)) {
            areas[surface] += area;
        }
        for &root in mesh.roots() {
            let (surface, area) = of_root(root);
            for (channel, weight) in weights[surface].iter().enumerate() {
                let density = weight / areas[surface];
                first.add(mesh, root, channel, &self.even(root, density));
                derivative.value[channel] += density * area * self.coefficients_on(root, channel)[0];
                if self.system.lamps.roots().contains(&root) {
                    derivative.emission[mesh.elements()[root].face()][channel] += density * area;
                }
            }
        }
    }

    /// The light that a point of a sum gathers.
    fn view(&self, point: &WeightedPoint) -> Result<View, Error> {
        let (mesh, channels) = (&self.system.mesh, self.channels().len());
        match self.leaf_of(point.position, point.normal) {
            Ok((leaf, foot)) => {
                let face = mesh.elements()[leaf].face();
                let [rho, emitted] = self.system.surfaces.reflectance_and_emission(face, foot);
                let (station, sum) = self.sum_on(leaf, foot)?;
                Ok(View { station, sum, face: Some(face), rho, emitted })
            }
            Err(error) if self.is_on_a_face(point.position) => Err(error),
            Err(_) => {
                let station = self.station_in_space(point.position, point.normal)?;
                let sum = self.sum_in_space(&station)?;
                Ok(View { station, sum, face: None, rho: vec![1.0; channels], emitted: vec![0.0; channels] })
            }
        }
    }

    /// Adds the light at points.
    fn weigh_points(&self, points: &[WeightedPoint], views: &[View], first: &mut Field, derivative: &mut Derivative) {
        let (mesh, channels) = (&self.system.mesh, self.channels().len());
        let mut on_clusters = vec![vec![0.0; mesh.clusters().clusters().len()]; channels];
        for (point, View { sum: Sum { sums, rows, far, lit, .. }, face, rho, emitted, .. }) in points.iter().zip(views) {
            for (channel, &weight) in point.weights.iter().enumerate() {
                derivative.value[channel] += weight * (emitted[channel] + rho[channel] * sums[channel]);
                if let Some(face) = *face {
                    derivative.emission[face][channel] += weight;
                    derivative.reflectance[face][channel] += weight * sums[channel];
                }
                let reflected = weight * rho[channel];
                for (source, row) in rows {
                    let density = reflected / mesh.elements()[*source].area();
                    let kernel: Vec<f64> = row.values.iter().map(|value| density * value).collect();
                    first.add(mesh, *source, channel, &kernel);
                }
                for (index, &cluster) in far.clusters().iter().enumerate() {
                    on_clusters[channel][cluster] += reflected * far.view(index, 0).weight;
                }
                for (&root, factor) in self.system.lamps.roots().iter().zip(lit.iter().flat_map(|lit| &lit.factors)) {
                    derivative.emission[mesh.elements()[root].face()][channel] += reflected * factor;
                }
            }
        }
        for (channel, on_clusters) in on_clusters.iter().enumerate() {
            let add = |element, density| first.add(mesh, element, channel, &self.even(element, density));
            mesh.clusters().push(on_clusters, |a, b| a + b, add);
        }
    }

    /// Solves for the importance by the part that comes at once, which is reflected on leaves as the light of lamps is.
    fn importance_from(&self, first: Field) -> Result<Importance, Error> {
        let (mesh, channels) = (&self.system.mesh, self.system.channels.len());
        let mut sent = Field::dark(mesh, channels);
        let mut scale = vec![0.0; channels];
        for leaf in mesh.leaves() {
            for (channel, scale) in scale.iter_mut().enumerate() {
                let mut reflected = first.coefficients(leaf, channel).to_vec();
                self.system.surfaces.reflect(mesh, leaf, channel, &mut reflected);
                *scale += mesh.elements()[leaf].area() / mesh.area() * reflected[0].abs();
                sent.add(mesh, leaf, channel, &reflected);
            }
        }
        let dark = |element: usize| vec![0.0; if self.gathers(element) { channels * mesh.basis(element).len() } else { 0 }];
        let source: Vec<Vec<f64>> = (0..mesh.elements().len()).map(dark).collect();
        let mut own = source.clone();
        let equation = self.system.equation(&source);
        sent.pull(mesh);
        let (sweeps, change) = equation.solve((&mut sent, &mut own), (SOLVED, MOST_SWEEPS), scale, |_, _| {});
        if change > SOLVED || change.is_nan() {
            return Err(Error::Unsettled { sweeps, change });
        }
        sent.pull(mesh);
        Ok(Importance { first, sent })
    }

    /// Adds the integrals of the importance over each face, and returns the sum again, by the emission.
    fn add_reflected(&self, importance: &Importance, derivative: &mut Derivative) -> Vec<f64> {
        let (mesh, channels, lamps) = (&self.system.mesh, self.system.channels.len(), self.system.lamps.roots());
        let leaves: Vec<usize> = mesh.leaves().collect();
        let faces = &mut derivative.emission;
        let of_lamps: Vec<usize> = lamps.iter().map(|&root| mesh.elements()[root].face()).collect();
        // The importance and the light that each receiver gathers, once for all leaves below it.
        let received = |receiver: usize| {
            let of_channel =
                |channel| [&importance.sent, &self.radiosity.field].map(|light| self.gathered_by(receiver, light, channel));
            if self.gathers(receiver) { (0..channels).map(of_channel).collect() } else { Vec::new() }
        };
        let gathered: Vec<Vec<[Vec<f64>; 2]>> = (0..mesh.elements().len()).into_par_iter().map(received).collect();
        // Of a leaf and channel: the integrals of the importance, and of it times the irradiance, the emission and each lamp's light.
        let integrals = |&leaf: &usize| {
            let (basis, area) = (mesh.basis(leaf), mesh.elements()[leaf].area());
            let of_channel = |channel: usize| {
                let receiver = self.receiver_of(leaf);
                let [mut whole, received] =
                    gathered[receiver][channel].each_ref().map(|of| self.brought_down(of, receiver, leaf));
                let received = self.with_direct(received, leaf, channel);
                let first = importance.first.coefficients(leaf, channel);
                whole.iter_mut().zip(first).for_each(|(whole, first)| *whole += first);
                let lamp = |lamp: usize| {
                    let at_nodes: Vec<f64> = self.radiosity.direct[leaf].nodes.iter().map(|lit| lit.factors[lamp]).collect();
                    let mut reflected = basis.project(&at_nodes);
                    self.system.surfaces.reflect(mesh, leaf, channel, &mut reflected);
                    area * dot(&whole, &reflected)
                };
                let lit: Vec<f64> = (0..lamps.len()).map(lamp).collect();
                let emitted = self.emitted_on(leaf, channel);
                ([area * whole[0], area * dot(&whole, &received), area * dot(&whole, &emitted)], lit)
            };
            (0..channels).map(of_channel).collect::<Vec<_>>()
        };
        let integrals: Vec<_> = leaves.par_iter().map(integrals).collect();
        let mut again = vec![0.0; channels];
        for (leaf, integrals) in leaves.into_iter().zip(integrals) {
            let face = mesh.elements()[leaf].face();
            let is_lamp = of_lamps.contains(&face);
            for (channel, ([sent, received, emitted], lit)) in integrals.into_iter().enumerate() {
                faces[face][channel] += if is_lamp { 0.0 } else { sent };
                derivative.reflectance[face][channel] += received;
                again[channel] += emitted;
                of_lamps.iter().zip(lit).for_each(|(&lamp, lit)| faces[lamp][channel] += lit);
            }
        }
        let mut of_lamps = of_lamps;
        of_lamps.dedup();
        for (channel, again) in again.iter_mut().enumerate() {
            *again +=
                of_lamps.iter().map(|&lamp| faces[lamp][channel] * self.system.surfaces.emitted[lamp][channel]).sum::<f64>();
        }
        again
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Options, solve};
    use radgrad_core::Polygon;

    /// A box of six faces, 2 by 3 by 2.5, with a lamp below its ceiling, and a plate beside it, of these reflectances and
    /// emissions.
    fn room(reflectance: &[f64; 8], emission: &[f64; 8]) -> Scene {
        let mut scene = Scene::new(["grey"]).unwrap();
        let surface = |scene: &mut Scene, index: usize, corners: [[f64; 3]; 4]| {
            let material = scene.add_material(format!("m{index}"), [reflectance[index]], [emission[index]]).unwrap();
            let surface = scene.add_surface(format!("s{index}"));
            let polygon = Polygon::new(corners.map(DVec3::from).to_vec()).unwrap();
            scene.add_face(surface, material, polygon, None).unwrap();
        };
        let (a, b, c) = (2.0, 3.0, 2.5);
        surface(&mut scene, 0, [[0.0, 0.0, 0.0], [a, 0.0, 0.0], [a, b, 0.0], [0.0, b, 0.0]]);
        surface(&mut scene, 1, [[0.0, 0.0, c], [0.0, b, c], [a, b, c], [a, 0.0, c]]);
        surface(&mut scene, 2, [[0.0, 0.0, 0.0], [0.0, 0.0, c], [a, 0.0, c], [a, 0.0, 0.0]]);
        surface(&mut scene, 3, [[0.0, b, 0.0], [a, b, 0.0], [a, b, c], [0.0, b, c]]);
        surface(&mut scene, 4, [[0.0, 0.0, 0.0], [0.0, b, 0.0], [0.0, b, c], [0.0, 0.0, c]]);
        surface(&mut scene, 5, [[a, 0.0, 0.0], [a, 0.0, c], [a, b, c], [a, b, 0.0]]);
        surface(&mut scene, 6, [[0.8, 1.3, 2.3], [0.8, 1.7, 2.3], [1.2, 1.7, 2.3], [1.2, 1.3, 2.3]]);
        surface(&mut scene, 7, [[0.3, 0.5, 1.0], [1.1, 0.5, 1.0], [1.1, 1.2, 1.0], [0.3, 1.2, 1.0]]);
        scene
    }

    /// Weights of surfaces and points.
    fn sums() -> [WeightedSum; 2] {
        let surfaces = (0..8).map(|index| vec![if index == 0 { 1.0 } else { 0.25 * f64::from(index % 3) }]).collect();
        let point = |x: f64, y: f64, z: f64, weight: f64| WeightedPoint {
            position: DVec3::new(x, y, z),
            normal: DVec3::Z,
            weights: vec![weight],
        };
        let points = vec![point(1.4, 2.1, 0.0, 1.0), point(0.6, 0.8, 0.0, 0.5), point(1.0, 1.6, 0.8, 0.25)];
        [WeightedSum { surfaces, points: Vec::new() }, WeightedSum { surfaces: Vec::new(), points }]
    }

    #[test]
    fn derivatives_are_those_of_solutions_of_other_materials() {
        let (rho, lit) = ([0.3, 0.7, 0.5, 0.6, 0.4, 0.5, 0.2, 0.6], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 10.0, 0.0]);
        let glowing = [0.0, 1.0, 0.5, 0.0, 2.0, 0.0, 10.0, 0.0];
        let solved = |rho: &[f64; 8], emission: &[f64; 8], error: f64| {
            let scene = room(rho, emission);
            let solution = solve(&scene, &Options { error, ..Options::default() }, |_| true).unwrap();
            sums().map(|sum| solution.derivative(&scene, &sum).unwrap())
        };
        for (emission, error, face) in [(lit, 2e-4, 1), (glowing, 1e-3, 6)] {
            let derivatives = solved(&rho, &emission, error);
            let changed = |values: &[f64; 8], face: usize, step: f64| {
                let mut values = *values;
                values[face] += step;
                values
            };
            let steps = [0.05, -0.05].map(|step| solved(&changed(&rho, face, step), &emission, error));
            let brighter = solved(&rho, &changed(&emission, face, 5.0), error);
            for (index, derivative) in derivatives.iter().enumerate() {
                let value = derivative.value[0];
                let differences = [
                    (derivative.reflectance[face][0], (steps[0][index].value[0] - steps[1][index].value[0]) / 0.1),
                    (derivative.emission[face][0], (brighter[index].value[0] - value) / (5.0 * std::f64::consts::PI)),
                ];
                println!("{face} {index} {value:.4} {differences:.5?} {:.1e}", derivative.relative_estimate[0]);
                for (by, difference) in differences {
                    assert!((by - difference).abs() <= 0.002 * difference.abs() + 2e-3 * value.abs(), "{face} {by} {difference}");
                }
            }
            for derivative in derivatives {
                assert!(derivative.relative_estimate[0] < 4.0 * error, "{derivative:?}");
            }
        }
    }

    #[test]
    fn wrong_weights_are_refused_by_place() {
        let scene = room(&[0.5; 8], &[1.0; 8]);
        let solution = solve(&scene, &Options { error: 0.5, ..Options::default() }, |_| true).unwrap();
        let refused = |surfaces: Vec<Vec<f64>>| {
            solution.derivative(&scene, &WeightedSum { surfaces, points: Vec::new() }).unwrap_err().to_string()
        };
        assert!(refused(vec![vec![1.0]]).contains("8 surfaces"));
        assert!(refused(vec![vec![1.0, 2.0]; 8]).contains("surface 0 has 2"));
        assert!(refused(vec![vec![f64::NAN]; 8]).contains("surface 0 has NaN"));
    }
}
