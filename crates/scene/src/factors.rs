//! Form factors: the fraction `F_ij` of what face i sees, weighted by the cosine, that is face j.
//!
//! - [`FormFactors::at_point`]: from a point, in closed form, with a proven bound.
//! - [`FormFactors::between`]: from a face to another. Where nothing may stand between, it is what [`exchange`] finds, to a
//!   rounding or so. Else it is integrated over the points of the face ([`cubature`]), and pairs of cells of the two, seen, hidden or
//!   mixed, bracket it ([`bracket`]).
//! - [`FormFactors::matrix`]: all of them, by one rule of points on each face for all that it sees. What a point of a closed scene
//!   sees sums to 1 to the last digits, and so does each row, whatever the rule; the rule's own error is in each entry's bound,
//!   which is proven, from the exact exchange or from its bracket. Nothing is normalised, clamped or made reciprocal: defects
//!   are reported as they are.
//!
//! Factors have no unit. Faces see by their lit side; faces of surfaces that only hide others have no factors.

mod bracket;
mod cubature;
mod exchange;
mod field;
mod matrix;
mod pair;
mod rule;
#[cfg(test)]
mod tests;

use radgrad_core::{Emission, Emitter, Polygon, Receiver, Tolerance, Value, evaluate_value};

pub use field::FieldCell;
pub use matrix::{Entry, FactorMatrix, SurfaceMatrix};
pub use pair::Factor;
pub use rule::gauss_legendre;

use crate::{Beam, Error, Occluders, Scene};

/// How factors are found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FactorSettings {
    /// Points along each side of a face, or of each triangle of one with more than four corners, at least: from 1 to 16.
    pub points_per_side: usize,
    /// Points are added, up to 16 along each side, until the rule of a face gives each of its factors with nothing in between to
    /// within this.
    pub rule_error: f64,
    /// Absolute error that is allowed of what a point sees of a face.
    pub point_tolerance: f64,
    /// Width to which the bracket of an obstructed factor is narrowed, while `most_cells` lasts.
    pub bracket: f64,
    /// Pairs of cells that the bracket of one obstructed factor may take.
    pub most_cells: usize,
    /// Error down to which [`FormFactors::between`] integrates an obstructed factor by two rules, by their difference, while
    /// `most_points` last. Of no effect on [`FormFactors::matrix`].
    pub estimate: f64,
    /// Points that this may take.
    pub most_points: usize,
}

impl Default for FactorSettings {
    /// Nine points a face or more, to 0.002; 1e-12 at a point; brackets of 0.02, from up to 256 pairs of cells; an
    /// estimate of 1e-10 from up to 20,000 points.
    fn default() -> Self {
        Self {
            points_per_side: 3,
            rule_error: 0.002,
            point_tolerance: 1e-12,
            bracket: 0.02,
            most_cells: 256,
            estimate: 1e-10,
            most_points: 20_000,
        }
    }
}

/// The faces of a scene, ready to be asked for their factors.
///
/// ```
/// use radgrad_core::{DVec3, Polygon};
/// use radgrad_scene::{FactorSettings, FormFactors, Scene};
/// let mut scene = Scene::new(["grey"])?;
/// let white = scene.add_material("white", [0.8], [0.0])?;
/// let square = |low: f64, high: f64, z: f64| {
///     [(low, low), (high, low), (high, high), (low, high)].map(|(x, y)| DVec3::new(x, y, z)).to_vec()
/// };
/// let mut add = |name: &str, outline: Vec<DVec3>| {
///     let surface = scene.add_surface(name);
///     scene.add_face(surface, white, Polygon::new(outline).unwrap(), None)
/// };
/// let floor = add("floor", square(0.0, 1.0, 0.0))?;
/// let ceiling = add("ceiling", square(0.0, 1.0, 1.0).into_iter().rev().collect())?;
/// let factors = FormFactors::new(&scene)?;
/// let free = factors.between(floor, ceiling, &FactorSettings::default())?;
/// assert!((free.value - 0.199_824_895_698_387).abs() <= free.error && free.error < 1e-12);
/// # Ok::<(), radgrad_scene::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct FormFactors<'a> {
    scene: &'a Scene,
    emitters: Vec<Emitter>,
    index: Occluders,
}

impl<'a> FormFactors<'a> {
    /// Builds the index of what may hide what.
    ///
    /// # Errors
    /// If a face cannot emit, which no face of a scene is known to do.
    pub fn new(scene: &'a Scene) -> Result<Self, Error> {
        let emitter = |polygon: &Polygon| Emitter::new(polygon.clone(), Emission::Constant(1.0)).map_err(Error::Emitter);
        let emitters = scene.polygons().map(emitter).collect::<Result<_, _>>()?;
        Ok(Self { scene, emitters, index: Occluders::new(scene.polygons()) })
    }

    /// The scene.
    #[must_use]
    pub const fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// The index of its polygons.
    #[must_use]
    pub const fn index(&self) -> &Occluders {
        &self.index
    }

    /// Factor from a point to a face, times the receiver's reflectance. `on` is the face that the receiver is a point of, if any: it
    /// hides nothing, nor does what is level with it up to rounding.
    ///
    /// # Errors
    /// If there is no such face, the tolerance is not finite or negative, or the factor underflows.
    pub fn at_point(&self, receiver: &Receiver, on: Option<usize>, to: usize, tolerance: f64) -> Result<Value, Error> {
        let emitter = self.emitter(to)?;
        let beam = match on {
            Some(face) => Beam::from_point_of(self.emitter(face)?.polygon(), receiver.position(), emitter.polygon()),
            None => Beam::from_receiver(receiver, emitter.polygon()),
        };
        let hiding = beam.map_or_else(Vec::new, |beam| self.index.in_beam(&beam, &[to, on.unwrap_or(to)]).polygons);
        evaluate(receiver, emitter, self.polygons(&hiding), tolerance)
    }

    fn emitter(&self, face: usize) -> Result<&Emitter, Error> {
        self.emitters.get(face).ok_or_else(|| Error::Missing {
            what: "face",
            which: face.to_string(),
            known: format!("they are numbered from 0, and there are {}", self.emitters.len()),
        })
    }

    fn polygon(&self, face: usize) -> &Polygon {
        self.emitters[face].polygon()
    }

    fn polygons(&self, faces: &[usize]) -> Vec<&Polygon> {
        faces.iter().map(|&face| self.polygon(face)).collect()
    }

    /// What a point of face `from` sees of face `to` past `candidates`.
    fn at_node(&self, receiver: &Receiver, from: usize, to: usize, candidates: &[usize], tolerance: f64) -> Result<Value, Error> {
        let emitter = &self.emitters[to];
        let mut hiding = Vec::new();
        if !candidates.is_empty() {
            let beam = Beam::from_point_of(self.polygon(from), receiver.position(), emitter.polygon());
            hiding = beam.map_or_else(Vec::new, |beam| self.index.among(&beam, candidates, &[from, to]).polygons);
        }
        evaluate(receiver, emitter, self.polygons(&hiding), tolerance)
    }
}

fn evaluate(receiver: &Receiver, emitter: &Emitter, hiding: Vec<&Polygon>, tolerance: f64) -> Result<Value, Error> {
    let tolerance = Tolerance { relative: 0.0, absolute: tolerance };
    evaluate_value(receiver, emitter, hiding, tolerance).map_err(Error::Evaluation)
}
