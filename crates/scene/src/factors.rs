//! Form factors: the fraction `F_ij` of what face i sees, weighted by the cosine, that is face j.
//!
//! - [`FormFactors::at_point`]: from a point, in closed form, with a proven bound.
//! - [`FormFactors::between`]: from a face to another. Where nothing may stand between, it is what [`exchange`] finds, to a
//!   rounding or so. Else it is integrated over the points of the face ([`cubature`]), and pairs of cells of the two, seen, hidden or
//!   mixed, bracket it ([`bracket`]).
//! - [`FormFactors::matrix`]: all of them, by one rule of points on each face for all that it sees ([`row`]). What a point of a closed
//!   scene sees sums to 1 to the last digits, and so does each row, whatever the rule; the rule is refined where a factor is off what is
//!   proven, and its own error is in each entry's bound, which is proven, from the exact exchange or from its bracket. Nothing is
//!   normalised, clamped or made reciprocal: defects are reported as they are.
//!
//! Factors have no unit. Faces see by their lit side; faces of surfaces that only hide others have no factors.

mod bracket;
mod cubature;
mod exchange;
mod field;
mod matrix;
mod pair;
mod row;
mod rule;
mod screen;
#[cfg(test)]
mod tests;

use radgrad_core::{DVec3, Emission, Emitter, Method, Polygon, Receiver, Tolerance, Value, evaluate_value};

pub use field::FieldCell;
pub use matrix::{Entry, FactorMatrix, SurfaceMatrix};
pub use pair::Factor;
pub use rule::gauss_legendre;

use self::screen::{Screen, Sight};
use crate::projection::normalising_power;
use crate::{Beam, Error, Occluders, Placement, Prepared, Scene, Warning};

/// How factors are found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FactorSettings {
    /// Absolute bound that is asked of a factor, while `most_cells` and `most_points_a_face` last: brackets past occluders are narrowed to
    /// it, and the rule of a face is refined until its factors are off what is proven by no more than about that. Time grows as it
    /// falls.
    pub tolerance: f64,
    /// Pairs of cells that the bracket of one obstructed factor may take.
    pub most_cells: usize,
    /// Points along each side of a cell of a face, from 1 to 16; below 3 no cell is divided.
    pub points_per_side: usize,
    /// Points that a face may have in all.
    pub most_points_a_face: usize,
    /// Absolute error that is allowed of what a point sees of a face.
    pub point_tolerance: f64,
    /// Error down to which [`FormFactors::between`] integrates an obstructed factor by two rules, by their difference, while
    /// `most_points` last. Of no effect on [`FormFactors::matrix`].
    pub estimate: f64,
    /// Points that this may take.
    pub most_points: usize,
}

impl Default for FactorSettings {
    /// 0.01, from up to 4000 pairs of cells a factor and 900 points a face, nine a cell; 1e-12 at a point; an estimate of 1e-10
    /// from up to 20,000 points.
    fn default() -> Self {
        Self {
            tolerance: 0.01,
            most_cells: 4000,
            points_per_side: 3,
            most_points_a_face: 900,
            point_tolerance: 1e-12,
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
    /// How its faces were moved and scaled; all that follows is in those coordinates.
    placement: Placement,
    warnings: Vec<Warning>,
    emitters: Vec<Emitter>,
    index: Occluders,
    /// What hides, face by face, with coordinates multiplied by `power`.
    screens: Vec<Vec<Screen>>,
    /// Vertices of the faces, multiplied as well.
    outlines: Vec<Vec<DVec3>>,
    power: f64,
}

impl<'a> FormFactors<'a> {
    /// Builds the index of what may hide what.
    ///
    /// # Errors
    /// If the scene is refused as in [`Prepared::of`].
    pub fn new(scene: &'a Scene) -> Result<Self, Error> {
        let emitter = |polygon: &Polygon| Emitter::new(polygon.clone(), Emission::Constant(1.0)).map_err(Error::Emitter);
        let Prepared { scene: ready, placement, index, warnings } = Prepared::of(scene)?;
        let emitters = ready.polygons().map(emitter).collect::<Result<_, _>>()?;
        let coordinates = ready.polygons().flat_map(Polygon::vertices).map(|v| v.abs().max_element());
        let power = normalising_power(coordinates.fold(0.0, f64::max));
        let screens = ready.polygons().map(|polygon| Screen::all_of(polygon, power)).collect();
        let outlines = ready.polygons().map(|polygon| polygon.vertices().iter().map(|&v| v * power).collect()).collect();
        Ok(Self { scene, placement, warnings, emitters, index, screens, outlines, power })
    }

    /// The scene.
    #[must_use]
    pub const fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// What is probably not meant in it; whether it has lamps is of no concern to factors.
    pub fn warnings(&self) -> impl Iterator<Item = &Warning> {
        self.warnings.iter().filter(|warning| **warning != Warning::Dark)
    }

    /// How it was moved and scaled.
    #[must_use]
    pub const fn placement(&self) -> &Placement {
        &self.placement
    }

    /// The index of its polygons, in those coordinates.
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
        let position = self.placement.inward(receiver.position());
        let receiver = &Receiver::new(position, receiver.direction(), receiver.reflectance()).map_err(Error::Receiver)?;
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

    /// What a point of face `from` sees of face `to` past `candidates`. `at.hider` is where to look first for one that hides all, and
    /// is set to the one that does.
    fn at_node(&self, node: &Receiver, to: usize, candidates: &[usize], at: &mut Sighting) -> Result<Value, Error> {
        let (point, outline) = (node.position() * self.power, &self.outlines[to]);
        let mut hiding = Vec::new();
        for &k in at.hider.iter().chain(candidates) {
            let sights = self.screens[k].iter().map(|screen| screen.before(point, outline));
            // The least of it that any of its convex parts leaves.
            match sights.max() {
                Some(Sight::Blocked) => {
                    at.hider = Some(k);
                    return Ok(Value { radiosity: 0.0, radiosity_error: 0.0, method: Method::Zero });
                }
                Some(Sight::Part) if at.hider != Some(k) || !hiding.contains(&k) => hiding.push(k),
                _ => {}
            }
        }
        evaluate(node, &self.emitters[to], self.polygons(&hiding), at.tolerance)
    }
}

/// How the points of a face look at another.
#[derive(Debug, Clone, Copy)]
struct Sighting {
    /// Absolute error that is allowed.
    tolerance: f64,
    /// What hid all of it from the last point that saw nothing.
    hider: Option<usize>,
}

fn evaluate(receiver: &Receiver, emitter: &Emitter, hiding: Vec<&Polygon>, tolerance: f64) -> Result<Value, Error> {
    let tolerance = Tolerance { relative: 0.0, absolute: tolerance };
    evaluate_value(receiver, emitter, hiding, tolerance).map_err(Error::Evaluation)
}
