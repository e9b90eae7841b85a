//! Form factors: the fraction `F_ij` of the view of face i, weighted by the cosine, that is face j.
//!
//! - [`FormFactors::at_point`]: from a point, in closed form, with a proven bound.
//! - [`FormFactors::between`]: from a face to another.
//! - [`FormFactors::matrix`]: all of them, or a block of rows.
//! - [`FormFactors::by_rays`]: those of very many faces, with intervals that hold with a stated probability ([`rays`]).
//!
//! The exchange of two faces, `E = A_i F_ij = A_j F_ji`, is one number a pair ([`pair`]): computed once, divided by each area
//! last, so that factors are reciprocal to a rounding. Which rule serves a pair:
//!
//! | pair | rule | why |
//! |---|---|---|
//! | in free sight, apart by more than half the size of a face | product Gauss rule on both areas ([`exchange`]) | a few nodes are within the error asked for, by a bound known before |
//! | in free sight, nearer | sum over pairs of edges, closed or by a rule | the kernel is singular where faces touch, logarithms are not |
//! | past others, all of it within the tolerance and ten times the error that its value may have | four points of the smaller face | nothing to all is a bracket |
//! | past others, all of it within the tolerance | integral over points ([`cubature`]), in double precision ([`point_factor`]) | the same, and more is asked of the value |
//! | past others, else | pairs of cells that see each other wholly, not at all or in part ([`bracket`]), and that integral | the bracket narrows to the tolerance |
//!
//! The value lies in the bracket. Nothing is normalised: whether rows of a closed scene sum to 1 is evidence. [`crate::FactorMatrix::repair`] moves
//! factors within their brackets until they do, for programs that need it.
//!
//! Factors have no unit. Faces see by their lit side; faces of surfaces that only hide others have no factors.

pub(crate) mod block;
mod bracket;
mod cubature;
mod culling;
mod exchange;
pub(crate) mod field;
pub(crate) mod matrix;
pub(crate) mod narrow;
mod neighbours;
pub(crate) mod pair;
mod point_factor;
#[doc(hidden)]
pub mod probes;
pub(crate) mod rays;
pub(crate) mod repair;
pub(crate) mod rule;
mod screen;
#[cfg(test)]
mod tests;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use radgrad_core::{DVec3, Emission, Emitter, Method, Polygon, Receiver, Tolerance, Value, evaluate_value};
use smallvec::SmallVec;

use self::exchange::far::Part;
use self::neighbours::Neighbours;
use self::rule::{middle, patches};
use self::screen::{Cells, Screen, Sight};
use crate::error::Error;
use crate::extremes::{largest as larger, smallest as smaller};
use crate::occluders::Occluders;
use crate::occluders::beam::Beam;
use crate::occluders::level::may_hide;
use crate::occluders::overlap::perimeter;
use crate::occluders::tree::Tree;
use crate::placement::Placement;
use crate::projection::normalising_power;
use crate::scene::prepared::Prepared;
use crate::scene::{Face, Scene};
use crate::warning::Warning;

/// How factors are found.
///
/// ```
/// use radgrad_scene::FactorSettings;
/// let settings = FactorSettings { tolerance: 1e-3, relative: 0.01, ..FactorSettings::default() };
/// assert_eq!([settings.allowed(0.02), settings.allowed(0.5)], [1e-3, 5e-3]); // the larger of the two counts
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FactorSettings {
    /// Absolute bound that is asked of a factor: brackets past occluders are narrowed to it, while `most_cells` last. Time grows as it
    /// falls.
    pub tolerance: f64,
    /// Bound that is asked of a factor over itself; the larger of the two counts.
    pub relative: f64,
    /// Pairs of cells that the bracket of one obstructed factor may take.
    pub most_cells: usize,
    /// Error down to which an obstructed factor is integrated by two rules, by their difference, while `most_points` last.
    pub estimate: f64,
    /// The same over the factor that there would be with nothing in between; the larger counts. In free sight a third of this over the factor
    /// itself, or a few roundings where that is more, is the bound that the rule is chosen by. Where that factor is within `tolerance` and at most
    /// this, a few looks may give the value, if they differ by no more than a tenth of this.
    pub relative_estimate: f64,
    /// Points that this may take.
    pub most_points: usize,
}

impl FactorSettings {
    /// The bound that is asked of a factor that is at least this.
    #[must_use]
    pub fn allowed(&self, lower: f64) -> f64 {
        larger(self.tolerance, self.relative * lower)
    }
}

impl Default for FactorSettings {
    /// An error of 1e-3, from up to 40,000 pairs of cells a factor; an estimate of 3e-6 from up to 2000 points.
    fn default() -> Self {
        Self { tolerance: 1e-3, relative: 0.0, most_cells: 40_000, estimate: 3e-6, relative_estimate: 0.0, most_points: 2000 }
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
    index: Arc<Occluders>,
    /// Its polygons that may hide a face from another.
    hiders: Tree,
    /// The faces with coordinates up to 1, multiplied by this power of two: factors do not depend on the unit.
    power: f64,
    scaled: Vec<Polygon>,
    /// The convex parts of each, for the rule in free sight.
    parts: Vec<SmallVec<[Part; 1]>>,
    /// The parts that hide, face by face, in that unit.
    screens: Vec<Vec<Screen>>,
    /// Which of them share edges, once that is asked.
    neighbours: OnceLock<Neighbours>,
    /// Spheres around the faces, in that unit.
    spheres: Vec<Sphere>,
    /// The areas by which the rounding of coordinates may change the exchange or the shadow of the faces.
    bands: Vec<f64>,
    /// Set where the work is to end.
    stop: Option<&'a AtomicBool>,
}

/// A sphere around a face.
#[derive(Debug, Clone, Copy)]
struct Sphere {
    centre: DVec3,
    radius: f64,
}

impl<'a> FormFactors<'a> {
    /// Builds the index of the faces that may hide others.
    ///
    /// # Errors
    /// If the scene is refused as in [`Prepared::new`], or a face is too small beside it to be a polygon in its unit.
    pub fn new(scene: &'a Scene) -> Result<Self, Error> {
        let emitter = |polygon: &Polygon| Emitter::new(polygon.clone(), Emission::Constant(1.0)).map_err(Error::Emitter);
        let Prepared { scene: ready, placement, index, warnings } = Prepared::new(scene)?;
        let emitters = ready.polygons().map(emitter).collect::<Result<_, _>>()?;
        let coordinates = ready.polygons().flat_map(Polygon::vertices).map(|v| v.abs().max_element());
        let power = normalising_power(coordinates.fold(0.0, larger));
        let scale = |polygon: &Polygon| polygon.map(power, |v| v * power).map_err(Error::Face);
        let scaled = ready.polygons().map(scale).collect::<Result<Vec<_>, _>>()?;
        let screens: Vec<Vec<Screen>> = scaled.iter().map(Screen::all_of).collect();
        let parts_of =
            |polygon: &Polygon| patches(polygon.vertices()).iter().map(|patch| Part::of(patch, polygon.normal())).collect();
        let (parts, hiders) = (scaled.iter().map(parts_of).collect(), index.hiders());
        let spheres = scaled.iter().map(Sphere::around).collect();
        // A vertex is off by up to the rounding in each coordinate, and by the distance that it was moved.
        let reach = |face: &Face| (face.moved() + 3.0_f64.sqrt() * ready.modelling().precision) * power;
        let bands =
            ready.faces().iter().zip(&scaled).map(|(face, polygon)| reach(face) * perimeter(polygon.vertices())).collect();
        Ok(Self {
            scene,
            placement,
            warnings,
            emitters,
            index,
            hiders,
            power,
            scaled,
            parts,
            screens,
            neighbours: OnceLock::new(),
            spheres,
            bands,
            stop: None,
        })
    }

    /// The same, whose work ends with [`Error::Stopped`] soon after another thread sets `stop`: it is looked at between pairs of cells and points.
    #[must_use]
    pub fn until(self, stop: &'a AtomicBool) -> Self {
        Self { stop: Some(stop), ..self }
    }

    fn is_stopped(&self) -> bool {
        self.stop.is_some_and(|stop| stop.load(Ordering::Relaxed))
    }

    /// Refuses to go on where the work is to end: the answers found since may be partial.
    fn go_on(&self) -> Result<(), Error> {
        if self.is_stopped() { Err(Error::Stopped) } else { Ok(()) }
    }

    /// The scene.
    #[must_use]
    pub const fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// Warnings about properties that a modeller probably did not mean. Factors need no lamps, so a scene without any is not
    /// warned of.
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
    pub fn index(&self) -> &Occluders {
        &self.index
    }

    /// Factor from a point to a face, times the receiver's reflectance. `on` is the face that the receiver is a point of, if any:
    /// neither it nor a face level with it up to rounding hides anything, and one that is level with it and faces the other way, as the back of
    /// a plate, gives it nothing. Where the emitter is level with that face otherwise, or the receiver with the emitter, coordinates as they are
    /// decide which faces hide it.
    ///
    /// # Errors
    /// If there is no such face, the tolerance is not finite or negative, or the factor underflows.
    pub fn at_point(&self, receiver: &Receiver, on: Option<usize>, to: usize, tolerance: f64) -> Result<Value, Error> {
        let emitter = self.emitter(to)?;
        let position = self.placement.inward(receiver.position());
        let receiver = &Receiver::new(position, receiver.given_normal(), receiver.reflectance()).map_err(Error::Receiver)?;
        let hiding = match on {
            Some(face) => {
                let own = self.emitter(face)?.polygon();
                // Of two faces in one plane, back to back, which one is before the other is a matter of rounding.
                let is_opposed = own.normal().dot(emitter.polygon().normal()) < 0.0;
                if is_opposed && Beam::from_point_of(own, receiver.position(), emitter.polygon()).is_none() {
                    return Ok(Value { radiosity: 0.0, radiosity_error: 0.0, method: Method::Zero });
                }
                self.hiding(receiver, face, to)
            }
            None => Beam::from_receiver(receiver, emitter.polygon()).map(|beam| self.in_beam(&beam, [to, to])),
        };
        let Hiding { found, left_out } = hiding.unwrap_or_default();
        let mut value = evaluate(receiver, emitter, self.polygons(&found), tolerance)?;
        value.radiosity_error += receiver.reflectance() * left_out;
        Ok(value)
    }

    /// The faces that may hide a face from a point of another one. Where nothing is seen by the planes of surfaces, as they are level up to rounding, the
    /// coordinates as they are decide: the little that they let see is not 0. `None` if by these nothing is seen either.
    fn hiding(&self, receiver: &Receiver, on: usize, to: usize) -> Option<Hiding> {
        let [own, emitter] = [on, to].map(|face| self.polygon(face));
        let exact = Beam::from_receiver(receiver, emitter).map(|beam| self.in_beam(&beam, [on, to]));
        let Some(beam) = Beam::from_point_of(own, receiver.position(), emitter) else { return exact };
        let mut hiding = self.in_beam(&beam, [on, to]);
        let point = receiver.position();
        for other in exact.unwrap_or_default().found.into_iter().filter(|other| hiding.found.binary_search(other).is_err()) {
            hiding.left_out += may_hide(point, own, emitter, self.polygon(other));
        }
        Some(hiding)
    }

    fn in_beam(&self, beam: &Beam, without: [usize; 2]) -> Hiding {
        Hiding { found: self.index.in_beam(beam, &without).polygons, left_out: 0.0 }
    }

    fn emitter(&self, face: usize) -> Result<&Emitter, Error> {
        self.emitters.get(face).ok_or_else(|| Error::Missing {
            what: "face",
            which: face.to_string(),
            known: format!("they are numbered from 0, and there are {}", self.emitters.len()),
        })
    }

    /// Which convex parts share edges, found when it is first asked: rays do without.
    fn neighbours(&self) -> &Neighbours {
        self.neighbours.get_or_init(|| Neighbours::new(&self.screens))
    }

    fn polygon(&self, face: usize) -> &Polygon {
        self.emitters[face].polygon()
    }

    fn polygons(&self, faces: &[usize]) -> Vec<&Polygon> {
        faces.iter().map(|&face| self.polygon(face)).collect()
    }

    /// A face in the unit in which coordinates are up to 1.
    fn scaled(&self, face: usize) -> &Polygon {
        &self.scaled[face]
    }

    /// Whether one of two faces is nowhere in front of the other, as surfaces: then they see nothing of each other.
    fn is_behind(&self, faces: [usize; 2]) -> bool {
        let both = [faces, [faces[1], faces[0]]];
        let fronts = both.map(|[a, b]| self.front(a, b));
        fronts.contains(&Front::None) || fronts.contains(&Front::Unclear) && both.iter().any(|&[a, b]| self.index.is_behind(b, a))
    }

    /// How much of a face is in front of another, where that is clear of all rounding.
    fn front(&self, face: usize, other: usize) -> Front {
        // Planes are known to far better than this.
        const MARGIN: f64 = 1e-6;
        let (polygon, sphere) = (self.scaled(face), self.spheres[other]);
        let (normal, origin) = (polygon.normal(), polygon.vertices()[0]);
        let height = normal.dot(sphere.centre - origin);
        if polygon.planarity_defect() > MARGIN {
            Front::Unclear
        } else if height < -sphere.radius - 2.0 * MARGIN {
            Front::None
        } else if height > sphere.radius {
            Front::All
        } else {
            let heights = self.scaled(other).vertices().iter().map(|&v| normal.dot(v - origin));
            let (least, most) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), h| (smaller(a, h), larger(b, h)));
            match (least >= -LEVEL, most > 2.0 * MARGIN) {
                (true, true) => Front::All,
                (false, true) => Front::Part,
                _ if most < -2.0 * MARGIN => Front::None,
                _ => Front::Unclear,
            }
        }
    }

    /// What a point sees of an emitter past `candidates`, in the unit in which coordinates are up to 1. `at.hider` is where to look
    /// first for one that hides all, and is set to the one that does.
    fn at_node(&self, node: &Receiver, emitter: &Emitter, candidates: &[usize], at: &mut Sighting) -> Result<Value, Error> {
        let point = [node.position()];
        let cells = Cells::new([&point, emitter.polygon().vertices()]);
        let mut hiding = Vec::new();
        for &k in at.hider.iter().chain(candidates) {
            let sights = self.screens[k].iter().map(|screen| screen.before(&cells));
            // The least of it that any of its convex parts leaves.
            match sights.max() {
                Some(Sight::Blocked) => {
                    at.hider = Some(k);
                    return Ok(Value { radiosity: 0.0, radiosity_error: 0.0, method: Method::Zero });
                }
                Some(Sight::Part) if !hiding.contains(&k) => hiding.push(k),
                _ => {}
            }
        }
        evaluate(node, emitter, hiding.iter().map(|&k| self.scaled(k)).collect(), at.tolerance)
    }
}

/// Heights over a plane below which a point is in it: some roundings of coordinates up to 1.
const LEVEL: f64 = 16.0 * f64::EPSILON;

/// How much of a face is in front of another's plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Front {
    /// All, up to some roundings, and clearly something.
    All,
    /// Clearly something.
    Part,
    None,
    Unclear,
}

impl Sphere {
    fn around(polygon: &Polygon) -> Self {
        let centre = middle(polygon.vertices());
        let radius = polygon.vertices().iter().map(|&v| (v - centre).length()).fold(0.0, larger);
        Self { centre, radius }
    }
}

/// How the points of a face look at another.
#[derive(Debug, Clone, Copy)]
struct Sighting {
    /// Absolute error that is allowed.
    tolerance: f64,
    /// The part that hid all of it from the last point that saw nothing.
    hider: Option<usize>,
}

/// The polygons that may hide a part of an emitter from a point of a face.
#[derive(Debug, Default)]
struct Hiding {
    found: Vec<usize>,
    /// A bound on the form factor of the parts that others hide, which do so by rounding alone.
    left_out: f64,
}

fn evaluate(receiver: &Receiver, emitter: &Emitter, hiding: Vec<&Polygon>, tolerance: f64) -> Result<Value, Error> {
    let tolerance = Tolerance { relative: 0.0, absolute: tolerance };
    evaluate_value(receiver, emitter, hiding, tolerance).map_err(Error::Evaluation)
}
