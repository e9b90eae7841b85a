//! The scene that a family draws, before it has a name.

use glam::DVec3;
use radgrad_scene::case::{Case, EmissionRecord, EmitterRecord, Id, ReceiverRecord};

use crate::cases::sampler::Sampler;

/// A receiver and an emitter, and the occluders between.
#[derive(Debug, Clone)]
pub(super) struct Scene {
    pub(super) position: DVec3,
    pub(super) normal: DVec3,
    pub(super) vertices: Vec<DVec3>,
    pub(super) emission: EmissionRecord,
    pub(super) occluders: Vec<Vec<DVec3>>,
    /// Length by which each coordinate of a vertex may be off.
    pub(super) precision: f64,
}

impl Scene {
    /// In free sight.
    pub(super) const fn open(position: DVec3, normal: DVec3, vertices: Vec<DVec3>, emission: EmissionRecord) -> Self {
        Self { position, normal, vertices, emission, occluders: Vec::new(), precision: 0.0 }
    }

    /// The case of this scene, with a reflectance: 1 for one in two, else 0.1 to 1.
    pub(super) fn into_case(self, name: String, sampler: &mut Sampler) -> Case {
        let reflectance = if sampler.one_in(2) { 1.0 } else { sampler.between(0.1, 1.0) };
        Case {
            id: Id::Text(name),
            receiver: ReceiverRecord { position: self.position.to_array(), normal: self.normal.to_array(), reflectance },
            emitter: EmitterRecord { vertices: arrays(&self.vertices), emission: self.emission },
            occluders: self.occluders.iter().map(|occluder| arrays(occluder)).collect(),
            tolerance: 1e-12,
            precision: self.precision,
        }
    }

    /// The emitter turned over: its lit side is where its dark side was.
    pub(super) fn reversed(mut self) -> Self {
        self.vertices.reverse();
        match &mut self.emission {
            EmissionRecord::Vertices { vertices } => vertices.reverse(),
            EmissionRecord::Constant { .. }
            | EmissionRecord::Gradient { .. }
            | EmissionRecord::Polynomial { .. }
            | EmissionRecord::Expression { .. } => (),
        }
        self
    }
}

fn arrays(points: &[DVec3]) -> Vec<[f64; 3]> {
    points.iter().map(DVec3::to_array).collect()
}

/// Least and largest of `normal.(v - x)` over the vertices, each over its distance: the sines of the elevations over the horizon.
pub(super) fn elevations(normal: DVec3, position: DVec3, vertices: &[DVec3]) -> (f64, f64) {
    let sines = vertices.iter().map(|v| normal.dot(*v - position) / (*v - position).length());
    sines.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), sine| (low.min(sine), high.max(sine)))
}

/// A random unit normal whose lowest and highest elevation of a vertex please.
pub(super) fn normal_where(
    sampler: &mut Sampler,
    position: DVec3,
    vertices: &[DVec3],
    pleases: impl Fn(f64, f64) -> bool,
) -> DVec3 {
    loop {
        let normal = sampler.direction();
        let (low, high) = elevations(normal, position, vertices);
        if pleases(low, high) {
            return normal;
        }
    }
}
