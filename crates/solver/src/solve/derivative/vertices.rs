//! Derivatives of a weighted sum of radiosities by the vertices of faces, with estimates of their errors.
//!
//! They are sums of the integrals of [`crate::solve::derivative::sampled`], and of what comes in as the surfaces stretch whose means are
//! weighed. A first few samples of each domain say how its integrand varies; as many samples as pay by that are taken, in several shifted
//! copies of one pattern, whose differences estimate the error of their mean. They follow from the scene alone.

use radgrad_core::DVec3;
use radgrad_scene::{Scene, largest};
use rayon::prelude::*;

use crate::field::Field;
use crate::gathering::ratio;
use crate::links::cluster::sampled::Numbers;
use crate::mesh::basis::dot;
use crate::mesh::rule::rectangular;
use crate::solve::derivative::integrands::{Domain, Integrands, Place, Viewpoint};
use crate::solve::derivative::sampled::Sum;
use crate::solve::derivative::{Derivative, WeightedSum};
use crate::solve::solution::Solution;

/// Shifted copies of the samples.
const COPIES: usize = 16;

/// Samples of a domain that say how it varies.
const FIRST: usize = 128;

/// Samples for each gather of the solution, and the fewest: about as long as the solution took.
const PER_GATHER: f64 = 256.0;
const FEWEST: f64 = 2.5e5;

/// Gauss nodes of a piece of an outline, and pieces.
const NODES: usize = 4;
const PIECES: usize = 16;

/// Steps of a sequence that fills the cube evenly: powers of the root of `x^4 = x + 1` (M. Roberts 2018).
const STEPS: [f64; 3] = [0.819_172_513_396_164_5, 0.671_043_606_703_789_3, 0.549_700_477_901_970_1];

/// By each vertex, channel after channel.
struct ByVertex {
    channels: usize,
    values: Vec<DVec3>,
}

impl Sum for ByVertex {
    fn add(&mut self, vertex: usize, channel: usize, change: DVec3) {
        self.values[vertex * self.channels + channel] += change;
    }
}

/// The sum of the squares of all that is added.
struct Squares(f64);

impl Sum for Squares {
    fn add(&mut self, _: usize, _: usize, change: DVec3) {
        self.0 += change.length_squared();
    }
}

impl Solution {
    /// Adds the derivatives by vertices, with this importance as it is sent.
    pub(super) fn add_vertices(
        &self,
        scene: &Scene,
        sum: &WeightedSum,
        (sent, points): (&Field, Vec<Viewpoint>),
        derivative: &mut Derivative,
    ) {
        let integrands = Integrands::new(self, sent, self.densities(scene, &sum.surfaces), points);
        let channels = self.channels().len();
        let counts = self.counts(&integrands);
        let of_copy = |copy: usize| {
            let mut by_vertex = ByVertex { channels, values: vec![DVec3::ZERO; integrands.vertices() * channels] };
            for (index, &(domain, count)) in counts.iter().enumerate() {
                for unit in pattern(index, copy, count) {
                    integrands.add(domain, unit, 1.0 / count as f64, &mut by_vertex);
                }
            }
            by_vertex.values
        };
        let copies: Vec<Vec<DVec3>> = (0..COPIES).into_par_iter().map(of_copy).collect();
        let mut exact = ByVertex { channels, values: vec![DVec3::ZERO; integrands.vertices() * channels] };
        self.add_stretches(scene, &integrands, &mut exact);
        let (values, errors): (Vec<DVec3>, Vec<f64>) = (0..exact.values.len())
            .map(|index| {
                let mean = copies.iter().map(|copy| copy[index]).sum::<DVec3>() / COPIES as f64;
                let square = copies.iter().map(|copy| (copy[index] - mean).length_squared()).sum::<f64>();
                let value = mean + exact.values[index];
                let error = (square / (COPIES * (COPIES - 1)) as f64).sqrt();
                let by_solution = derivative.relative_estimate[index % channels] * value.length();
                (value * self.placement.power(), error.hypot(by_solution) * self.placement.power())
            })
            .unzip();
        let (mut values, mut errors) = (values.chunks_exact(channels), errors.chunks_exact(channels));
        for polygon in self.system.mesh.polygons() {
            let count = polygon.vertices().len();
            derivative.vertices.push(values.by_ref().take(count).map(<[DVec3]>::to_vec).collect());
            derivative.vertices_estimate.push(errors.by_ref().take(count).map(<[f64]>::to_vec).collect());
        }
    }

    /// How many samples each copy has of each domain: a third where the integrand varies
    /// most, a third evenly for the faces, and a third evenly, as what is rare may not be among the first.
    fn counts(&self, integrands: &Integrands<'_>) -> Vec<(Domain, usize)> {
        let domains = integrands.domains();
        let variation = |(index, &domain): (usize, &Domain)| {
            let mut squares = Squares(0.0);
            for unit in pattern(index, COPIES, FIRST) {
                integrands.add(domain, unit, 1.0, &mut squares);
            }
            (squares.0 / FIRST as f64).sqrt()
        };
        let variations: Vec<f64> = domains.par_iter().enumerate().map(variation).collect();
        let whole: f64 = variations.iter().sum();
        let mut faces = vec![0.0; self.system.mesh.polygons().len() + 1];
        let group = |domain: Domain| integrands.face_of(domain).unwrap_or(self.system.mesh.polygons().len());
        domains.iter().zip(&variations).for_each(|(domain, variation)| faces[group(*domain)] += variation);
        let groups = faces.iter().filter(|variation| **variation > 0.0).count() as f64;
        let samples = largest(FEWEST, PER_GATHER * self.progress.gathers as f64) / COPIES as f64;
        let even = 1.0 / domains.len() as f64;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a cast saturates, and the numbers are above 0"
        )]
        let count = |(domain, variation): (Domain, f64)| {
            let parts = [ratio(variation, whole), ratio(variation, faces[group(domain)] * groups), even];
            (domain, 1 + (samples * parts.iter().sum::<f64>() / 3.0) as usize)
        };
        domains.into_iter().zip(variations).map(count).collect()
    }

    /// Of each face the weight of its light in means of surfaces, over the area that has it.
    fn densities(&self, scene: &Scene, weights: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let (mesh, channels) = (&self.system.mesh, self.channels().len());
        let mut areas = vec![0.0; scene.surfaces().len()];
        for element in mesh.roots().iter().map(|&root| &mesh.elements()[root]) {
            areas[scene.faces()[element.face()].surface()] += element.area();
        }
        let of_surface = |surface: usize| match weights.get(surface) {
            Some(weights) => weights.iter().map(|weight| ratio(*weight, areas[surface])).collect(),
            None => vec![0.0; channels],
        };
        scene.faces().iter().map(|face| of_surface(face.surface())).collect()
    }

    /// Adds the change of means as their faces stretch, by affine motions and beside these along their outlines: by the light there, less
    /// the mean.
    fn add_stretches(&self, scene: &Scene, integrands: &Integrands<'_>, by_vertex: &mut ByVertex) {
        let (mesh, channels) = (&self.system.mesh, by_vertex.channels);
        // Of faces and of surfaces, the area and in each channel the power.
        let mut faces = vec![vec![0.0; 1 + channels]; mesh.polygons().len()];
        let mut surfaces = vec![vec![0.0; 1 + channels]; scene.surfaces().len()];
        for (root, element) in mesh.roots().iter().map(|&root| (root, &mesh.elements()[root])) {
            for sums in [&mut faces[element.face()], &mut surfaces[scene.faces()[element.face()].surface()]] {
                sums[0] += element.area();
                (0..channels).for_each(|channel| sums[1 + channel] += element.area() * self.coefficients_on(root, channel)[0]);
            }
        }
        let mean = |face: usize, channel: usize| {
            let surface = &surfaces[scene.faces()[face].surface()];
            ratio(surface[1 + channel], surface[0])
        };
        let weighted =
            |face: usize| integrands.densities[face].iter().copied().enumerate().filter(|(_, density)| *density != 0.0);
        for (face, of_face) in faces.iter().enumerate() {
            for (channel, density) in weighted(face) {
                let change = density * (of_face[1 + channel] - mean(face, channel) * of_face[0]);
                for (vertex, slope) in integrands.planes[face].slopes().iter().enumerate() {
                    by_vertex.add(integrands.vertex(face, vertex), channel, *slope * change);
                }
            }
        }
        for edge in integrands.edges.iter().filter(|edge| weighted(edge.face).next().is_some()) {
            let outward = edge.direction.cross(integrands.planes[edge.face].normal);
            for (piece, node) in (0..PIECES).flat_map(|piece| rectangular(NODES, 1).into_iter().map(move |node| (piece, node))) {
                let part = (piece as f64 + node.at[0]) / PIECES as f64;
                let at = edge.place(part);
                let Some(leaf) = mesh.leaf_at(edge.face, at) else { continue };
                let values = self.basis(leaf).values(mesh.elements()[leaf].reference(at));
                for (channel, density) in weighted(edge.face) {
                    let light = dot(&self.coefficients_on(leaf, channel), &values) - mean(edge.face, channel);
                    let change = outward * (density * light * edge.length * node.weight / PIECES as f64);
                    integrands.add_edge((edge, part), channel, change, by_vertex);
                    integrands.add_place(Place { face: edge.face, at }, channel, -change, by_vertex);
                }
            }
        }
    }
}

/// So many places of the unit cube, for a copy of the samples of a domain.
fn pattern(domain: usize, copy: usize, count: usize) -> impl Iterator<Item = [f64; 4]> {
    let mut numbers = Numbers::from_seed((domain * (COPIES + 1) + copy) as u64);
    let shifts = [(); 4].map(|()| numbers.next());
    (0..count).map(move |index| {
        let first = (index as f64 + shifts[0]) / count as f64;
        let [a, b, c] = [0, 1, 2].map(|k| (shifts[k + 1] + STEPS[k] * index as f64).fract());
        [first, a, b, c]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Options, WeightedPoint, solve};
    use radgrad_core::{Emission, Emitter, Polygon, Receiver, derivatives};

    fn level(low: [f64; 2], high: [f64; 2], z: f64, is_up: bool) -> Vec<DVec3> {
        let mut corners = [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]]
            .map(|[x, y]| DVec3::new(x, y, z))
            .to_vec();
        if !is_up {
            corners.reverse();
        }
        corners
    }

    /// A scene of faces with reflectances and radiances, each a surface of its own.
    fn scene_of(faces: &[(Vec<DVec3>, f64, f64)]) -> Scene {
        let mut scene = Scene::new(["grey"]).unwrap();
        for (index, (corners, rho, lit)) in faces.iter().enumerate() {
            let (material, surface) = (scene.add_material("", [*rho], [*lit]).unwrap(), scene.add_surface(index.to_string()));
            scene.add_face(surface, material, Polygon::new(corners.clone()).unwrap(), None).unwrap();
        }
        scene
    }

    #[test]
    fn a_sensor_under_a_lamp_and_a_screen_has_the_derivatives_of_the_closed_forms() {
        let (lamp, screen) = (level([-0.4, -0.3], [0.5, 0.4], 2.0, false), level([0.1, -1.0], [1.0, 1.0], 1.2, true));
        let scene = scene_of(&[(lamp.clone(), 0.0, 3.0), (screen.clone(), 0.0, 0.0)]);
        let solution = solve(&scene, &Options::default(), |_| true).unwrap();
        let (position, normal) = (DVec3::new(0.3, 0.1, 0.0), DVec3::new(0.2, 0.1, 1.0));
        let points = vec![WeightedPoint { position, normal, weights: vec![2.0] }];
        let by = solution.derivative_with_vertices(&scene, &WeightedSum { surfaces: Vec::new(), points }).unwrap();
        let emitter = Emitter::new(Polygon::new(lamp).unwrap(), Emission::Constant(3.0 * std::f64::consts::PI)).unwrap();
        let receiver = Receiver::new(position, normal, 1.0).unwrap();
        let exact = derivatives(&receiver, &emitter, [&Polygon::new(screen).unwrap()], 1e-10).unwrap();
        for vertex in 0..4 {
            for (face, exact) in [(0, exact.vertices[vertex].value), (1, exact.occluders[0][vertex].value)] {
                let (value, estimate) = (by.vertices[face][vertex][0], by.vertices_estimate[face][vertex][0]);
                let error = (value - 2.0 * exact).length();
                assert!(error < 3e-4 && error <= 4.0 * estimate && estimate < 1e-3, "{face} {vertex} {value} {exact} {estimate}");
            }
        }
    }

    /// A closed room with a lamp and a plate that hang in it.
    fn room() -> Vec<(Vec<DVec3>, f64, f64)> {
        let wall = |corners: [[f64; 3]; 4]| corners.map(DVec3::from).to_vec();
        let (a, b, c) = (2.0, 3.0, 2.5);
        vec![
            (level([0.0; 2], [a, b], 0.0, true), 0.3, 0.0),
            (level([0.0; 2], [a, b], c, false), 0.7, 0.0),
            (wall([[0.0, 0.0, 0.0], [0.0, 0.0, c], [a, 0.0, c], [a, 0.0, 0.0]]), 0.5, 0.0),
            (wall([[0.0, b, 0.0], [a, b, 0.0], [a, b, c], [0.0, b, c]]), 0.6, 0.0),
            (wall([[0.0, 0.0, 0.0], [0.0, b, 0.0], [0.0, b, c], [0.0, 0.0, c]]), 0.4, 0.0),
            (wall([[a, 0.0, 0.0], [a, 0.0, c], [a, b, c], [a, b, 0.0]]), 0.5, 0.0),
            (level([0.8, 1.3], [1.2, 1.7], 2.3, false), 0.2, 10.0),
            (level([0.3, 0.5], [1.1, 1.2], 1.0, true), 0.6, 0.0),
        ]
    }

    #[test]
    fn derivatives_by_motions_are_those_of_differences_and_nothing_comes_of_moving_all() {
        let mean = |face: usize| WeightedSum {
            surfaces: (0..8).map(|of| vec![f64::from(u8::from(of == face))]).collect(),
            points: Vec::new(),
        };
        let solved = |moved: &dyn Fn(usize, DVec3) -> DVec3, error: f64| {
            let mut faces = room();
            faces.iter_mut().enumerate().for_each(|(face, of)| of.0.iter_mut().for_each(|at| *at += moved(face, *at)));
            let scene = scene_of(&faces);
            let solution = solve(&scene, &Options { error, ..Options::default() }, |_| true).unwrap();
            (scene, solution)
        };
        let (scene, solution) = solved(&|_, _| DVec3::ZERO, 5e-3);
        let by: Vec<Derivative> =
            [0, 7].iter().map(|&face| solution.derivative_with_vertices(&scene, &mean(face)).unwrap()).collect();
        // Along a motion, and the size of the parts, both with the estimate.
        let along = |by: &Derivative, motion: &dyn Fn(usize, DVec3) -> DVec3| {
            let (mut sum, mut size, mut estimate) = (0.0, 0.0, 0.0);
            for (face, polygon) in scene.polygons().enumerate() {
                for (vertex, at) in polygon.vertices().iter().enumerate() {
                    let motion = motion(face, *at);
                    sum += by.vertices[face][vertex][0].dot(motion);
                    size += by.vertices[face][vertex][0].length() * motion.length();
                    estimate += by.vertices_estimate[face][vertex][0] * motion.length();
                }
            }
            (sum, size, estimate)
        };
        for by in &by {
            for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                let rigid: [&dyn Fn(usize, DVec3) -> DVec3; 3] = [&|_, _| axis, &|_, at| axis.cross(at), &|_, at| at];
                for motion in rigid {
                    let (sum, size, estimate) = along(by, motion);
                    println!("all {axis} {sum:.5} {size:.5} {estimate:.5}");
                    assert!(sum.abs() < 0.02 * size && sum.abs() < estimate, "{sum} {size} {estimate}");
                }
            }
        }
        let middle = DVec3::new(1.0, 1.5, 2.3);
        let motions: [&dyn Fn(usize, DVec3) -> DVec3; 3] = [
            &|face, at| if face == 6 { DVec3::new(0.2, 0.1, -0.3) + DVec3::X.cross(at - middle) } else { DVec3::ZERO },
            &|face, at| if face == 6 { at - middle } else { DVec3::ZERO },
            &|face, _| if face == 7 { DVec3::new(0.2, 0.1, 0.5) } else { DVec3::ZERO },
        ];
        let step = 0.06;
        for motion in motions {
            let values = [step, -step].map(|step| {
                let (scene, solution) = solved(&|face, at| step * motion(face, at), 2e-3);
                [0, 7].map(|face| solution.derivative(&scene, &mean(face)).unwrap().value[0])
            });
            for (index, by) in by.iter().enumerate() {
                let difference = (values[0][index] - values[1][index]) / (2.0 * step);
                let (slope, size, estimate) = along(by, motion);
                println!("{slope:.5} {difference:.5} {size:.5} {estimate:.5}");
                assert!((slope - difference).abs() < 0.02 * size, "{slope} {difference} {size}");
            }
        }
    }

    #[test]
    fn a_plate_that_slides_over_the_floor_covers_what_is_in_front_of_it() {
        let scene = |moved: f64| {
            let upright = [[0.5, 0.7, 0.0], [1.5, 0.9, 0.0], [1.5, 0.9, 1.0], [0.5, 0.7, 1.0]].map(DVec3::from);
            let upright = upright.iter().map(|at| *at + DVec3::Y * moved).collect();
            let faces = [(level([0.0; 2], [2.0; 2], 0.0, true), 0.5, 0.0), (upright, 0.0, 1.0)];
            scene_of(&[&faces[..], &[(level([0.2, 0.2], [0.6, 0.5], 1.5, false), 0.0, 20.0)]].concat())
        };
        let sum = WeightedSum { surfaces: vec![vec![1.0], vec![0.0], vec![0.0]], points: Vec::new() };
        let solved = |moved: f64| {
            let scene = scene(moved);
            let solution = solve(&scene, &Options { error: 1e-4, ..Options::default() }, |_| true).unwrap();
            solution.derivative_with_vertices(&scene, &sum).unwrap()
        };
        let [ahead, behind] = [0.01, -0.01].map(|moved| solved(moved).value[0]);
        let by = solved(0.0);
        let slope: f64 = by.vertices[1].iter().map(|by| by[0].y).sum();
        let size: f64 = by.vertices[1].iter().map(|by| by[0].length()).sum();
        let difference = (ahead - behind) / 0.02;
        println!("{slope:.5} {difference:.5} {size:.5} {:?}", by.vertices_estimate[1]);
        assert!((slope - difference).abs() < 0.01 * size, "{slope} {difference} {size}");
    }
}
