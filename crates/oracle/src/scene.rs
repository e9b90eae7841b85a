//! The radiosity of whole scenes, one channel at a time: `B = E + rho G B` (HS95 Eq. 1 over all faces), by random walks with
//! limits that hold whatever the distribution, and in closed form where a scene has one ([`known`]).
//!
//! Faces give and take light on the side from which they are counter-clockwise, and are opaque from both: a ray that meets a back
//! ends there. Nothing here is shared with the solver or with core but polygons.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | `E_j`, `rho_j`, `A_j`, `n_j` | emitted radiosity, reflectance, area, unit normal of face j | |
//! | `Phi = sum E_j A_j` | power of all lamps | radiosity times area |
//! | `k(x, y) = (n_x.u)(-n_y.u) / (pi |y - x|^2)`, u from x to y | kernel | 1 / area |
//! | `D(x) = int k V E dy` | direct irradiance: [`Scene::direct`] encloses it | radiosity |
//! | `r_1 >= r_2` | the two largest reflectances of different faces | |
//! | `S = (r_1 + r_1 r_2) / (1 - r_1 r_2)`, `T = 1 + S` | bounds on sums of products of reflectances along a walk | |
//!
//! A plane face does not see itself, so of two bounces in a row one is at most `r_2`: `r_1 + r_1 r_2 + r_1^2 r_2 + ... = S`.
//!
//! # Three kinds of walks
//! They estimate `B - E - rho D` at a point, and the mean of `B - E` over all area. Each is a mean of independent contributions
//! from an interval that is known before the first is drawn; the limits rest on that interval.
//! - [`Kind::Particles`]: from a lamp (power-proportional, then uniform over its area, then by the cosine) from face to face; at
//!   each hit y with the weight `w = rho rho ... rho(y)` a contribution `Phi w / A` to the mean, and `Phi w rho_x k(x, y) V` to a
//!   point. At most `Phi S / A` and `Phi rho_x max_j(rho_j k_j) T` with `k_j` the largest kernel between x and face j, from their
//!   distance: no lamp is too small or too near to a face, but a point in a corner has a large `k_j`.
//! - [`Kind::NextEvent`]: from x by the cosine; at each hit a point of a lamp, by solid angle: `w (sum E Omega) cos / pi`, at most
//!   `rho_x max_j(rho_j c_j) T` with `c_j = sum_l E_l min(2, A_l / (pi d_jl^2))` and `d_jl` the distance of lamp and face.
//! - [`Kind::Plain`]: the same without lamps being sought: `w E` where one is hit, at most `rho_x max(E) S`.
//!
//! [`Scene::truth`] takes for each question the kind with the least interval. Below the weight [`LEAST_WEIGHT`] a walk goes on with
//! probability `w / LEAST_WEIGHT` and that weight; after so many bounces that the expected rest is below 1e-5 of `T` it ends, and
//! the rest is added to the upper limit.
//!
//! # Rays
//! A ray is sheared so that it is an axis (S. Woop, C. Benthin and I. Wald, JCGT 2013), and a polygon hit where the winding number
//! of its projected outline is not 0. An edge of two faces has the same two projected ends in both, and its crossing is decided by
//! one sign: no ray passes between them. At T-junctions a ray may, with a probability of about 1e-15. Of a face and one in the same
//! plane up to rounding neither hides anything from the other, and of two that meet a ray at the same place the one that faces it
//! counts.

mod caster;
mod direct;
mod distance;
mod form_factors;
pub mod known;
mod sampling;
mod walk;

use std::f64::consts::PI;
use std::fmt;
use std::sync::Arc;

use glam::DVec3;
use radgrad_core::Polygon;

use crate::Error;
use crate::confidence::ConfidenceInterval;
use caster::Caster;
use distance::{Corners3, between_triangles, to_point};
pub use form_factors::rays_for;
use sampling::LampTriangle;

/// Weight below which a walk goes on with a probability.
pub const LEAST_WEIGHT: f64 = 0.02;

/// Allowed mean truncation of a walk over the bound on its sum.
const REST: f64 = 1e-5;

/// Reflectance and emitted radiosity that vary over a face, at a point of it.
#[derive(Clone)]
pub struct Pattern(Arc<dyn Fn(DVec3) -> [f64; 2] + Send + Sync>);

impl Pattern {
    /// A pattern from the function that gives reflectance and emitted radiosity; neither may be above those of its face.
    pub fn new(at: impl Fn(DVec3) -> [f64; 2] + Send + Sync + 'static) -> Self {
        Self(Arc::new(at))
    }
}

impl fmt::Debug for Pattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Pattern")
    }
}

/// A face of a scene in one channel.
#[derive(Debug, Clone)]
pub struct Face {
    /// Counter-clockwise seen from the side that gives and takes light.
    pub polygon: Polygon,
    /// Reflectance; with a pattern the largest.
    pub reflectance: f64,
    /// Emitted radiosity; with a pattern the largest.
    pub emitted: f64,
    /// Whether it gives and takes light and counts in the mean; else it only hides others.
    pub exchanges: bool,
    /// How reflectance and emission vary over it.
    pub pattern: Option<Pattern>,
}

impl Face {
    fn reflectance_and_emission(&self, point: DVec3) -> [f64; 2] {
        self.pattern.as_ref().map_or([self.reflectance, self.emitted], |pattern| (pattern.0)(point))
    }
}

/// A scene for walks that estimate its radiosity.
#[derive(Debug)]
pub struct Scene {
    faces: Vec<Face>,
    areas: Vec<f64>,
    caster: Caster,
    /// Triangles of each face.
    triangles: Vec<Vec<Corners3>>,
    lamps: Vec<LampTriangle>,
    /// Sums of the power of lamps' triangles up to and with each.
    power: Vec<f64>,
    /// `c_j` of each face.
    light: Vec<f64>,
    /// Products of reflectances.
    series: Series,
}

/// A point of a face at which walks estimate the radiosity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Index of the face.
    pub face: usize,
    /// A point of it.
    pub position: DVec3,
}

/// How a number is sampled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Walks from lamps.
    Particles,
    /// Walks from points, with a look at lamps at each hit.
    NextEvent,
    /// Walks from points.
    Plain,
}

/// The number of rays and walks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effort {
    /// Rays for the mean.
    pub rays: usize,
    /// Rays for each point.
    pub rays_a_point: usize,
    /// Digits of direct light at points: 0 samples it, 15 and more enclose it.
    pub digits: u32,
    /// Seed.
    pub seed: u64,
    /// Confidence of each interval.
    pub confidence: f64,
}

impl Default for Effort {
    /// 400,000 rays and 200,000 a point, direct light to 15 digits, a confidence of all but 1e-7.
    fn default() -> Self {
        Self { rays: 400_000, rays_a_point: 200_000, digits: 15, seed: 1, confidence: 1.0 - 1e-7 }
    }
}

/// A number and its confidence interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Known {
    /// Mean of the samples, plus the parts known exactly.
    pub value: f64,
    /// Interval at the stated confidence, whatever the distribution.
    pub interval: ConfidenceInterval,
}

/// The answers of walks on a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// Mean of `B - E` over all area that exchanges light.
    pub reflected: Known,
    /// Mean of `E` over it.
    pub emitted: f64,
    /// `B` at the requested points.
    pub points: Vec<Known>,
}

/// Sums of products of reflectances along a walk.
#[derive(Debug, Clone, Copy)]
struct Series {
    /// `S`, the part that the rule of survival may add included.
    reflected: f64,
    /// `T`, the same.
    whole: f64,
    bounces: usize,
    /// Expected weight after the last bounce, at most.
    rest: f64,
}

impl Series {
    fn new(faces: &[Face]) -> Result<Self, Error> {
        let mut rho: Vec<f64> = faces.iter().filter(|face| face.exchanges).map(|face| face.reflectance).collect();
        rho.sort_by(|a, b| b.total_cmp(a));
        let [first, second] = [0, 1].map(|i| rho.get(i).copied().unwrap_or(0.0));
        let pair = first * second;
        if pair >= 1.0 {
            return Err(Error::Lossless { reflectance: first });
        }
        let sum = (first + pair) / (1.0 - pair);
        let (mut bounces, mut rest) = (2, pair);
        while rest > REST {
            bounces += 2;
            rest *= pair;
        }
        // Each of these bounces has at most the least weight times a reflectance, once the weights of `sum` are used up.
        let survival = if pair > 0.0 { bounces as f64 * LEAST_WEIGHT * first } else { 0.0 };
        Ok(Self { reflected: sum + survival, whole: 1.0 + sum + survival, bounces, rest })
    }
}

impl Scene {
    /// A scene of these faces.
    ///
    /// # Errors
    /// If a reflectance is not in [0, 1], an emission not finite or negative, or two faces reflect everything.
    pub fn new(faces: Vec<Face>) -> Result<Self, Error> {
        for (index, face) in faces.iter().enumerate() {
            if !(0.0..=1.0).contains(&face.reflectance) || !(0.0..f64::INFINITY).contains(&face.emitted) {
                return Err(Error::Face { index, reflectance: face.reflectance, emitted: face.emitted });
            }
        }
        let series = Series::new(&faces)?;
        let areas: Vec<f64> = faces.iter().map(|face| face.polygon.area()).collect();
        let triangles: Vec<Vec<Corners3>> = faces.iter().map(|face| distance::triangles(&face.polygon)).collect();
        let mut lamps = Vec::new();
        for (index, face) in faces.iter().enumerate().filter(|(_, face)| face.exchanges && face.emitted > 0.0) {
            lamps.extend(triangles[index].iter().map(|corners| LampTriangle::new(index, *corners, face)));
        }
        let mut sum = 0.0;
        let power = lamps.iter().map(|lamp| {
            sum += lamp.power();
            sum
        });
        let power = power.collect();
        let mut scene = Self { caster: Caster::new(&faces), areas, triangles, lamps, power, light: Vec::new(), series, faces };
        scene.light = (0..scene.faces.len()).map(|face| scene.most_light(face)).collect();
        Ok(scene)
    }

    /// The faces.
    #[must_use]
    pub fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// Area of all faces that exchange light.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.faces.iter().zip(&self.areas).filter(|(face, _)| face.exchanges).map(|(_, area)| area).sum()
    }

    /// `Phi`; with patterns as if they emitted most everywhere.
    fn whole_power(&self) -> f64 {
        self.power.last().copied().unwrap_or(0.0)
    }

    /// Whether a part of face `b` is in front of face `a`, rounding on the safe side.
    fn may_face(&self, a: usize, b: usize) -> bool {
        let (normal, origin) = (self.faces[a].polygon.normal(), self.faces[a].polygon.vertices()[0]);
        let slack = self.caster.slack();
        self.faces[b].polygon.vertices().iter().any(|vertex| normal.dot(*vertex - origin) > -slack)
    }

    fn distance(&self, a: usize, b: usize) -> f64 {
        let pairs = self.triangles[a].iter().flat_map(|s| self.triangles[b].iter().map(move |t| between_triangles(s, t)));
        (pairs.fold(f64::INFINITY, f64::min) - self.caster.slack()).max(0.0)
    }

    /// `c_j`: no look at the lamps from a point of the face gives more.
    fn most_light(&self, face: usize) -> f64 {
        let light_from = |(lamp, other): (usize, &Face)| {
            let lit =
                other.exchanges && other.emitted > 0.0 && lamp != face && self.may_face(lamp, face) && self.may_face(face, lamp);
            if !lit {
                return 0.0;
            }
            let distance = self.distance(lamp, face);
            other.emitted * (self.areas[lamp] / (PI * distance * distance)).min(2.0)
        };
        self.faces.iter().enumerate().map(light_from).sum()
    }

    /// `max_j rho_j k_j` for a point: of the kernel `(n_x.u)(-n_y.u) / (pi d^2)`, the product of cosines is at most `(1 -
    /// n_x.n_y) / 2`, and the second at most `h / d` with the height h of x over the plane of j.
    fn largest_kernel(&self, point: &Point) -> f64 {
        let normal = self.faces[point.face].polygon.normal();
        let slack = self.caster.slack();
        let kernel_bound = |(index, face): (usize, &Face)| {
            let other = face.polygon.normal();
            let height = other.dot(point.position - face.polygon.vertices()[0]) + slack;
            let dark = index == point.face || !face.exchanges || height <= 0.0 || !self.may_face(point.face, index);
            if dark {
                return 0.0;
            }
            let nearest = self.triangles[index].iter().map(|triangle| to_point(triangle, point.position));
            let distance = (nearest.fold(f64::INFINITY, f64::min) - slack).max(0.0);
            let cosines = (0.5 * (1.0 - normal.dot(other)) + 1e-12).min(height / distance).min(1.0);
            face.reflectance * cosines / (PI * distance * distance)
        };
        self.faces.iter().enumerate().map(kernel_bound).fold(0.0, f64::max)
    }
}
