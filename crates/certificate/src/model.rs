//! The scene as walks see it: triangles to start from, reflectances and emissions at hits, and their largest values, which alone decide the
//! range of a walk's contribution.

use std::f64::consts::PI;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::Error;
use radgrad_core::DVec3;
use radgrad_scene::{Occluders, Prepared, Quantity, Scene, largest, triangulate};
use rand::RngExt;
use rand::rngs::ChaCha8Rng;

/// Faces of which all pairs are looked at for whether they may see each other.
const FEW: usize = 1_000;

/// Heights over a plane, relative to the lengths at hand, up to which a vertex is in the plane: rays that go so level are as rare.
const LEVEL: f64 = 1e-12;

/// The scene, moved and scaled as its index is.
#[derive(Debug)]
pub(crate) struct Model<'a> {
    scene: &'a Scene,
    pub(crate) index: &'a Occluders,
    pub(crate) faces: Vec<Face>,
    pub(crate) channels: usize,
    /// The area of all that exchanges light.
    pub(crate) area: f64,
    /// Mean radiosity over that area that is emitted, in each channel.
    pub(crate) emitted: Vec<f64>,
    /// Set where the work is to end.
    stop: Option<&'a AtomicBool>,
}

#[derive(Debug)]
pub(crate) struct Face {
    pub(crate) normal: DVec3,
    pub(crate) surface: usize,
    pub(crate) exchanges: bool,
    pub(crate) area: f64,
    pub(crate) triangles: Vec<Triangle>,
    /// Largest values over the face, in each channel.
    pub(crate) reflectance: Vec<f64>,
    pub(crate) emission: Vec<f64>,
    is_textured: [bool; 2],
}

impl Face {
    /// The largest emission of any channel.
    pub(crate) fn brightest(&self) -> f64 {
        self.emission.iter().copied().fold(0.0, largest)
    }

    /// Whether it emits the same everywhere.
    pub(crate) const fn emits_evenly(&self) -> bool {
        !self.is_textured[Quantity::Radiance as usize]
    }

    /// A point, uniform over the area.
    pub(crate) fn point(&self, generator: &mut ChaCha8Rng) -> DVec3 {
        let mut place = generator.random::<f64>() * self.triangles.iter().map(Triangle::area).sum::<f64>();
        for triangle in &self.triangles {
            if place < triangle.area() {
                return triangle.point(generator);
            }
            place -= triangle.area();
        }
        self.triangles[0].point(generator)
    }
}

/// A face, and a point of it.
pub(crate) type Hit = (usize, DVec3);

/// A triangle of a face.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Triangle {
    pub(crate) corners: [DVec3; 3],
}

impl Triangle {
    pub(crate) fn area(&self) -> f64 {
        let [a, b, c] = self.corners;
        0.5 * (b - a).cross(c - a).length()
    }

    pub(crate) fn centroid(&self) -> DVec3 {
        let [a, b, c] = self.corners;
        (a + b + c) / 3.0
    }

    /// A point, uniform over the area (G. Turk 1990).
    pub(crate) fn point(&self, generator: &mut ChaCha8Rng) -> DVec3 {
        let [a, b, c] = self.corners;
        let (root, v) = (generator.random::<f64>().sqrt(), generator.random::<f64>());
        a * (1.0 - root) + b * (root * (1.0 - v)) + c * (root * v)
    }

    /// Its four parts of half the size.
    pub(crate) fn parts(&self) -> [Self; 4] {
        let [a, b, c] = self.corners;
        let [ab, bc, ca] = [(a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5];
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]].map(|corners| Self { corners })
    }

    /// Whether a point of its plane is in it.
    pub(crate) fn contains(&self, point: DVec3, normal: DVec3) -> bool {
        let [a, b, c] = self.corners;
        [[a, b], [b, c], [c, a]].into_iter().all(|[from, to]| (to - from).cross(point - from).dot(normal) >= 0.0)
    }
}

impl<'a> Model<'a> {
    pub(crate) fn new(prepared: &'a Prepared) -> Self {
        let scene = &prepared.scene;
        let faces: Vec<Face> = scene.faces().iter().map(|face| model(scene, face)).collect();
        let exchanging = || (0..faces.len()).filter(|&face| faces[face].exchanges);
        let area = exchanging().map(|face| faces[face].area).sum();
        let emitted = |channel: usize| {
            let power = |face: usize| PI * scene.mean_over(face, Quantity::Radiance, channel) * faces[face].area;
            exchanging().map(power).sum::<f64>() / area
        };
        let channels = scene.channels().len();
        let emitted = (0..channels).map(emitted).collect();
        Self { scene, index: &prepared.index, channels, area, emitted, faces, stop: None }
    }

    /// The same, whose walks end soon after `stop` is set.
    pub(crate) fn until(self, stop: &'a AtomicBool) -> Self {
        Self { stop: Some(stop), ..self }
    }

    /// Refuses to go on where the work is to end.
    pub(crate) fn go_on(&self) -> Result<(), Error> {
        if self.stop.is_some_and(|stop| stop.load(Ordering::Relaxed)) {
            Err(radgrad_scene::Error::Stopped.into())
        } else {
            Ok(())
        }
    }

    pub(crate) fn surfaces(&self) -> usize {
        self.scene.surfaces().len()
    }

    /// The area of a surface.
    pub(crate) fn area_of(&self, surface: usize) -> f64 {
        self.scene.surfaces()[surface].faces().iter().map(|&face| self.faces[face].area).sum()
    }

    /// The faces that emit.
    pub(crate) fn lamps(&self) -> impl Iterator<Item = (usize, &Face)> {
        self.faces.iter().enumerate().filter(|(_, face)| face.exchanges && face.brightest() > 0.0)
    }

    /// Multiplies a weight of each channel by the reflectance at a point.
    pub(crate) fn reflect(&self, face: usize, point: DVec3, weights: &mut [f64]) {
        self.weigh(Quantity::Reflectance, 1.0, face, point, weights);
    }

    /// Multiplies a weight of each channel by the radiosity that is emitted at a point.
    pub(crate) fn emit(&self, face: usize, point: DVec3, weights: &mut [f64]) {
        self.weigh(Quantity::Radiance, PI, face, point, weights);
    }

    fn weigh(&self, quantity: Quantity, unit: f64, face: usize, point: DVec3, weights: &mut [f64]) {
        if self.faces[face].is_textured[quantity as usize] {
            let values = self.scene.value_at(face, quantity, point);
            weights.iter_mut().zip(values).for_each(|(weight, value)| *weight *= unit * value);
        } else {
            let Face { reflectance, emission, .. } = &self.faces[face];
            let values = if quantity == Quantity::Reflectance { reflectance } else { emission };
            weights.iter_mut().zip(values).for_each(|(weight, value)| *weight *= value);
        }
    }

    /// The face and the point that a ray from a face, or from a point in space, meets from the front, if it exchanges light.
    pub(crate) fn hit(&self, from: Option<usize>, origin: DVec3, toward: DVec3) -> Option<Hit> {
        let (face, point) = self.index.first_along(origin, toward, from.as_slice())?;
        let Face { exchanges, normal, .. } = &self.faces[face];
        (*exchanges && normal.dot(toward) < 0.0).then_some((face, point))
    }

    /// Bounds in each channel on the reflectance of a face, and on the product of those of two faces that may see each other.
    pub(crate) fn largest_reflectances(&self) -> Vec<[f64; 2]> {
        let faces: Vec<usize> = (0..self.faces.len()).filter(|&face| self.faces[face].exchanges).collect();
        let mut bounds = vec![[0.0; 2]; self.channels];
        let reflectance = |face: usize, channel: usize| self.faces[face].reflectance[channel];
        for (channel, [single, double]) in bounds.iter_mut().enumerate() {
            *single = faces.iter().map(|&face| reflectance(face, channel)).fold(0.0, largest);
            if faces.len() > FEW {
                *double = *single * *single;
            }
        }
        if faces.len() <= FEW {
            for (place, &a) in faces.iter().enumerate() {
                for &b in &faces[..place] {
                    let products = (0..self.channels).map(|channel| reflectance(a, channel) * reflectance(b, channel));
                    if products.clone().zip(&bounds).any(|(product, [_, double])| product > *double) && self.may_see(a, b) {
                        bounds.iter_mut().zip(products).for_each(|([_, double], product)| *double = largest(*double, product));
                    }
                }
            }
        }
        bounds
    }

    /// The vertices of a face.
    pub(crate) fn outline(&self, face: usize) -> &[DVec3] {
        self.scene.faces()[face].polygon().vertices()
    }

    /// Whether a face is convex.
    pub(crate) fn is_convex(&self, face: usize) -> bool {
        let (outline, normal) = (self.outline(face), self.faces[face].normal);
        let count = outline.len();
        let turn = |k: usize| {
            let [a, b, c] = [k, k + 1, k + 2].map(|k| outline[k % count]);
            normal.dot((b - a).cross(c - b))
        };
        (0..count).all(|k| turn(k) >= 0.0)
    }

    /// Whether any part of each of two faces may be in front of the other.
    fn may_see(&self, a: usize, b: usize) -> bool {
        let is_before = |other: usize, from: usize| {
            let Face { normal, triangles, .. } = &self.faces[from];
            let origin = triangles[0].corners[0];
            let above = |corner: &DVec3| normal.dot(*corner - origin) > LEVEL * (*corner - origin).length();
            self.faces[other].triangles.iter().flat_map(|triangle| &triangle.corners).any(above)
        };
        is_before(a, b) && is_before(b, a)
    }
}

fn model(scene: &Scene, face: &radgrad_scene::Face) -> Face {
    let polygon = face.polygon();
    let vertices = polygon.vertices();
    let fan = || (1..vertices.len() - 1).map(|k| [0, k, k + 1]).collect();
    let triangles =
        triangulate(vertices).unwrap_or_else(fan).into_iter().map(|corners| Triangle { corners: corners.map(|k| vertices[k]) });
    let material = &scene.materials()[face.material()];
    let values = |quantity: Quantity, unit: f64| {
        let texture = face.chart(quantity).and_then(|_| material.texture(quantity));
        let factors = material.factors(quantity).iter().enumerate();
        factors.map(|(channel, factor)| unit * factor * texture.map_or(1.0, |texture| texture.largest(channel))).collect()
    };
    Face {
        normal: polygon.normal(),
        surface: face.surface(),
        exchanges: scene.surfaces()[face.surface()].exchanges(),
        area: polygon.area(),
        triangles: triangles.collect(),
        reflectance: values(Quantity::Reflectance, 1.0),
        emission: values(Quantity::Radiance, PI),
        is_textured: [Quantity::Reflectance, Quantity::Radiance]
            .map(|quantity| face.chart(quantity).is_some() && material.texture(quantity).is_some()),
    }
}
