//! The solution of a scene to an error: solve, estimate, divide where the estimate says that it pays, and again.
//!
//! Elements that receive gather reflected light, and may be divided into leaves for the sake of direct light alone, which is
//! cheap ([`crate::links::direct`]). Each round divides leaves until direct light is seen well enough, links the new receivers,
//! sweeps until the linear system is solved, refines links, and estimates the error. If the estimate of that of the mean over all area is not
//! within the error asked for, relative to the mean radiosity that is reflected, the receivers that add most to the magnitude of errors are
//! divided: those that together make up a given part of it (W. Dörfler 1996). Asked to go by the gradient it divides instead, leaves and receivers
//! alike, those that are off most in the mean square ([`crate::solve::marking`]), on faces that are first cut into squares, or where it is
//! asked for along shadow lines ([`crate::solve::shadows`]).

pub(crate) mod by_surface;
mod check;
pub(crate) mod derivative;
mod direct_light;
mod divide;
mod dual;
mod error_gradient;
mod error_samples;
pub(crate) mod gather;
mod goal;
mod goal_points;
pub(crate) mod gradient;
pub(crate) mod gradient_rounds;
mod layers;
mod linking;
mod lossless;
mod marking;
pub(crate) mod next_degree;
pub(crate) mod options;
mod queries;
mod residuals;
mod samples;
mod saved;
mod second_gather;
mod shadows;
pub(crate) mod solution;
mod sweep;
#[cfg(test)]
mod tests;
pub(crate) mod wedge;

use std::time::Duration;

use radgrad_core::DVec3;
use radgrad_scene::{Prepared, Quantity, Scene, largest, smallest};

use crate::clock::Clock;
use crate::error::Error;
use crate::estimate::ErrorEstimate;
use crate::estimate::unsampled::Edges;
use crate::field::Field;
use crate::links::cell::Rules;
use crate::links::direct::Lamps;
use crate::links::rays::cells_for;
use crate::mesh::Mesh;
use crate::mesh::clusters::FEWEST as MANY;
use crate::mesh::element::Element;
use crate::mesh::outline::Cut;
use crate::mesh::surfaces::Surfaces;
use crate::solve::goal_points::GoalPoints;
use crate::solve::options::{Marking, Next, Options, Progress};
use crate::solve::solution::{Budget, Caches, Radiosity, Refinement, Solution};
use crate::system::System;

/// Degree of the basis if none is given: in general; where there are clusters, of faces that are small already; where these are so many that
/// a value each is what there is time and memory for; and where leaves are few and apart, so that light is smooth, but so large that it varies on them.
const DEGREE: usize = 2;
const DEGREE_OF_MANY: usize = 1;
const DEGREE_OF_VERY_MANY: usize = 0;
const DEGREE_OF_FEW: usize = 4;

/// The part of the error asked for that links may neglect.
const LINK_PART: f64 = 0.1;

/// The same where leaves are apart and make up so few pairs that finer links cost nothing that is noticed: light is smooth there,
/// and the light that links neglect would be most of the error.
const LINK_PART_OF_FEW: f64 = 1e-9;
const FEW_PAIRS: usize = 10_000;

/// Faces from which on they are very many.
const VERY_MANY: usize = 20_000;

/// The distance of two leaves over the sum of their radii from which they are apart, and from which light hardly varies on them.
const APART: f64 = 0.9;
const FAR_APART: f64 = 2.0;

/// The part of the mean magnitude of errors before at which a round aims at least.
const STEP: f64 = 0.3;

/// The part of the error asked for that one evaluation may have, per unit of the source's radiosity.
const EVALUATION_PART: f64 = 2e-4;

/// The same where there are no lamps and no clusters: light may then be far more even than was asked for, and known as well. Past
/// a face that may hide a part of a source that is dear, and is asked for only if reflectances and emissions are those of even
/// light.
const GLOWING_PART: f64 = 2e-10;

/// The least error asked of an evaluation, about that of closed forms in double precision.
const FINEST: f64 = 1e-14;

/// The same past a face that may hide a part of a source: edges in line with each other leave about so much open, and to ask for
/// less is in vain, and dear.
const FINEST_PAST: f64 = 1e-11;

/// Changes relative to the mean radiosity below which the linear system is solved: where light may be even, as for evaluations,
/// and, over the error aimed at, in scenes with lamps.
const SOLVED: f64 = 1e-13;
const ROUGHLY_SOLVED: f64 = 1e-4;

/// How much longer than the round before one is expected to take at most.
const MOST_GROWTH: f64 = 2.0;

/// Solves a scene. `watch` sees the solution after each round and returns the next step ([`Next`]; `true` goes on, `false` ends).
/// The solution that was reached is returned.
///
/// ```
/// use radgrad_core::{DVec3, Polygon};
/// use radgrad_scene::Scene;
/// use radgrad_solver::{Options, solve};
/// // Two squares face each other; each reflects half and radiates 1 by itself.
/// let mut scene = Scene::new(["grey"])?;
/// let white = scene.add_material("white", [0.5], [std::f64::consts::FRAC_1_PI])?;
/// let surface = scene.add_surface("squares");
/// let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
/// let floor = Polygon::new(square.map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec()).unwrap();
/// let ceiling = Polygon::new(square.map(|(x, y)| DVec3::new(y, x, 1.0)).to_vec()).unwrap();
/// scene.add_face(surface, white, floor, None)?;
/// scene.add_face(surface, white, ceiling, None)?;
/// let solution = solve(&scene, &Options::default(), |_| true)?;
/// let centre = solution.gather(DVec3::new(0.5, 0.5, 0.0), DVec3::Z)?;
/// assert!((centre.radiosity[0] - 1.133_303_564_992_420_8).abs() <= 2.0 * centre.estimate[0].total());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the error asked for is not in (0, 1], the scene is refused as in [`Prepared::new`], a face cannot be cut into elements, light is emitted where it is
/// never lost or does not settle, or a radiosity is beyond the range of a double.
pub fn solve<N: Into<Next>>(scene: &Scene, options: &Options, watch: impl FnMut(&Solution) -> N) -> Result<Solution, Error> {
    solve_from(scene, options, &[], watch)
}

/// [`solve`] from a mesh that is divided already, as another solution's was ([`Solution::divisions`]) with the same [`Options::marking`], by
/// which faces are first cut: to go on where that one ended.
///
/// ```
/// # use radgrad_scene::{Degenerate, Scene};
/// use radgrad_solver::{Options, solve, solve_from};
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");
/// let scene = Scene::read(file, Degenerate::Refuse)?;
/// let options = Options { error: 1.0, degree: Some(0), first_elements: 1, ..Options::default() };
/// let before = solve(&scene, &options, |_| false)?;
/// let after = solve_from(&scene, &options, &before.divisions(), |_| false)?;
/// assert_eq!(before.progress().elements, after.progress().elements);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As for [`solve`], and if a division is of an element that is not there.
pub fn solve_from<N: Into<Next>>(
    scene: &Scene,
    options: &Options,
    divisions: &[usize],
    watch: impl FnMut(&Solution) -> N,
) -> Result<Solution, Error> {
    solve_for(scene, options, divisions, &[], watch)
}

/// [`solve_from`] for the sake of some points, each with the direction that it faces: refinement serves gathers there, and the
/// estimate that has to reach [`Options::error`] is that of their mean error over the mean reflected radiosity there. A point
/// that is on no face is a sensor in free space. Without points the mean over all area is served.
///
/// ```
/// # use radgrad_core::DVec3;
/// # use radgrad_scene::{Degenerate, Scene};
/// use radgrad_solver::{Options, solve, solve_for};
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");
/// let scene = Scene::read(file, Degenerate::Refuse)?;
/// let options = Options { error: 0.2, degree: Some(1), ..Options::default() };
/// let for_mean = solve(&scene, &options, |_| true)?;
/// let leaf = for_mean.mesh().leaves().next().unwrap();
/// let element = &for_mean.mesh().elements()[leaf];
/// let point = (element.centre(), element.polygon().normal());
/// let served = solve_for(&scene, &options, &[], &[point], |_| true)?;
/// let [of_all, of_served] = [&for_mean, &served].map(|of| of.gather(point.0, point.1));
/// let (of_all, of_served) = (of_all?, of_served?);
/// assert!((of_all.radiosity[0] - of_served.radiosity[0]).abs() <= of_all.estimate[0].total() + of_served.estimate[0].total());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As for [`solve_from`].
pub fn solve_for<N: Into<Next>>(
    scene: &Scene,
    options: &Options,
    divisions: &[usize],
    points: &[(DVec3, DVec3)],
    watch: impl FnMut(&Solution) -> N,
) -> Result<Solution, Error> {
    if !(options.error > 0.0 && options.error <= 1.0) {
        return Err(Error::Tolerance { value: options.error });
    }
    let started = Clock::started();
    let ready = Prepared::new(scene)?;
    let mut options = *options;
    let degree = options.degree.map_or_else(|| degree_for(&ready.scene, &options), Ok)?;
    let mut mesh = match options.marking {
        Marking::Shadows => shadows::mesh(&ready, &options, degree)?,
        Marking::Gradient if ready.scene.faces().len() < MANY => Mesh::cut(&ready.scene, degree, Cut::Squares)?,
        Marking::Residual | Marking::Gradient => Mesh::new(&ready.scene, degree)?,
    };
    if options.marking == Marking::Shadows {
        // The time of the cuts.
        options.time = options.time.map(|time| time.saturating_sub(started.elapsed()));
    }
    for (index, &element) in divisions.iter().enumerate() {
        let count = mesh.elements().len();
        if element >= count {
            return Err(Error::Division { index, element, count });
        }
        mesh.divide(element)?;
    }
    solve_on(&ready, &options, (mesh, GoalPoints::at_points(points)), watch)
}

/// The same on a mesh of a scene that is ready, with options in its unit.
pub(crate) fn solve_on<N: Into<Next>>(
    ready: &Prepared,
    options: &Options,
    (mut mesh, served): (Mesh, GoalPoints),
    mut watch: impl FnMut(&Solution) -> N,
) -> Result<Solution, Error> {
    let scene = &ready.scene;
    let clock = Clock::started();
    let mut options = *options;
    divide_evenly(&mut mesh, options.first_elements)?;
    let mut solution = dark(ready, &options, (mesh, served), clock)?;
    let (mut before, mut expected) = (Duration::ZERO, Duration::ZERO);
    let mut reached = None;
    loop {
        let began = clock.elapsed();
        let refined = solution.round(&options, expected)?;
        // A round that finds nothing to divide or to link finds nothing the next time.
        let sizes = Some((solution.system.mesh.elements().len(), solution.progress.links));
        let is_idle = std::mem::replace(&mut reached, sizes) == sizes;
        solution.check(scene)?;
        let took = clock.elapsed().saturating_sub(began + refined);
        expected = expected_after(took, before);
        let next = watch(&solution).into();
        let may_go_on = !solution.is_full(&options) && clock.has_time_for(options.time, expected);
        let goes_on = may_go_on
            && match next {
                Next::End => false,
                Next::Round => !is_idle && !solution.reached(&options),
                Next::Serve(points) => {
                    solution.serve(&points)?;
                    options.error = STEP * solution.progress.estimate;
                    // Where nothing is reflected nothing is known relative to it.
                    options.error.is_finite()
                }
            };
        if !goes_on {
            solution.end_service();
            // Who asks for a point has time for it.
            (solution.budget.precise, solution.budget.late) = (clock, clock);
            return Ok(solution);
        }
        before = took;
        solution.divide(&options)?;
    }
}

/// The degree of the basis where none is given.
fn degree_for(scene: &Scene, options: &Options) -> Result<usize, Error> {
    if scene.faces().len() >= VERY_MANY {
        return Ok(DEGREE_OF_VERY_MANY);
    }
    if scene.faces().len() >= MANY {
        return Ok(DEGREE_OF_MANY);
    }
    if options.marking != Marking::Residual {
        return Ok(DEGREE);
    }
    // Each has a leaf at least.
    let exchanging = scene.faces().iter().filter(|face| scene.surfaces()[face.surface()].exchanges()).count();
    if exchanging * exchanging > FEW_PAIRS {
        return Ok(DEGREE);
    }
    let mut mesh = Mesh::new(scene, DEGREE)?;
    divide_evenly(&mut mesh, options.first_elements)?;
    Ok(if nearest_of_few(&mesh).is_some_and(|nearest| (APART..FAR_APART).contains(&nearest)) { DEGREE_OF_FEW } else { DEGREE })
}

/// Divides all leaves alike until there are so many.
fn divide_evenly(mesh: &mut Mesh, elements: usize) -> Result<(), Error> {
    while !mesh.roots().is_empty() && mesh.leaves().count() < elements {
        let leaves: Vec<usize> = mesh.leaves().collect();
        leaves.into_iter().try_for_each(|leaf| mesh.divide(leaf))?;
    }
    Ok(())
}

/// The distance of the two nearest leaves of different faces, over the sum of their radii, if leaves make up few pairs.
fn nearest_of_few(mesh: &Mesh) -> Option<f64> {
    let leaves: Vec<&Element> = mesh.leaves().map(|leaf| &mesh.elements()[leaf]).collect();
    if leaves.len() * leaves.len() > FEW_PAIRS {
        return None;
    }
    let pairs = leaves.iter().flat_map(|a| leaves.iter().map(move |b| (a, b))).filter(|(a, b)| a.face() != b.face());
    let distance = |(a, b): (&&Element, &&Element)| (a.centre() - b.centre()).length() / (a.radius() + b.radius());
    Some(pairs.map(distance).fold(f64::INFINITY, smallest))
}

/// The solution before the first round: no light yet.
fn dark(ready: &Prepared, options: &Options, (mesh, served): (Mesh, GoalPoints), clock: Clock) -> Result<Solution, Error> {
    let scene = &ready.scene;
    let channels = scene.channels().to_vec();
    let mut surfaces = Surfaces::from_scene(scene);
    let (low, high) = scene.bounds().unwrap_or((DVec3::ZERO, DVec3::ZERO));
    let progress = Progress { round: 0, elements: 0, links: 0, gathers: 0, estimate: f64::INFINITY };
    let receivers: Vec<usize> = mesh.leaves().collect();
    let lamps = Lamps::find(&mesh, &surfaces);
    let precision = |is_even: bool| largest(options.error * if is_even { GLOWING_PART } else { EVALUATION_PART }, FINEST);
    let may_be_even = may_be_even(&mesh, &lamps);
    surfaces.check(&channels)?;
    lossless::settle(scene, &mesh, &mut surfaces)?;
    let radiosity = Radiosity {
        field: Field::dark(&mesh, channels.len()),
        own: Vec::new(),
        direct: Vec::new(),
        unseen: Vec::new(),
        mean: vec![0.0; channels.len()],
        reflected: vec![0.0; channels.len()],
        emitted: emitted(scene, &mesh, &lamps, &surfaces),
    };
    let budget = Budget {
        asked: options.error,
        allowed: LINK_PART * options.error,
        absolute: precision(may_be_even),
        past: [may_be_even && surfaces.may_be_even(&mesh), false].map(|is_even| largest(precision(is_even), FINEST_PAST)),
        cells: cells_for(options.error),
        precise: clock.for_precision(options.time),
        late: clock.for_all(options.time),
        clock: clock.for_estimate(options.time, mesh.clusters().root().is_some()),
    };
    let edges = Edges::find(&mesh);
    let system = System {
        rules: Rules::new(),
        links: Vec::new(),
        far: Vec::new(),
        extent: (high - low).max_element(),
        mesh,
        surfaces,
        lamps,
        receivers,
        channels,
    };
    Ok(Solution {
        system,
        edges,
        radiosity,
        error_estimate: ErrorEstimate::default(),
        refinement: Refinement { served, judged: Vec::new(), direct_residual: f64::INFINITY },
        budget,
        caches: Caches::default(),
        progress,
        placement: ready.placement,
        warnings: ready.warnings.clone(),
    })
}

impl Solution {
    /// Whether there are as many elements as there may be.
    pub(super) fn is_full(&self, options: &Options) -> bool {
        let given = if self.system.mesh.clusters().root().is_some() { self.system.mesh.undivided() } else { 0 };
        self.system.mesh.elements().len() >= options.most_elements.saturating_add(given)
    }

    /// One round: direct light, links, sweeps, finer links, estimates. Beside the parts that end with the time it is expected to
    /// take so long. Returns how long that was refined, leaves and links.
    fn round(&mut self, options: &Options, expected: Duration) -> Result<Duration, Error> {
        // A step that a round cannot end anyway is not paid for, if there may be another one.
        let is_last = self.is_full(options);
        let [light, links] = self.budget.clock.for_round(self.progress.round == 0, options.time, expected);
        let [aim, of_direct] = if is_last { [options.error; 2] } else { self.aims(options.error) };
        let are_apart = nearest_of_few(&self.system.mesh).is_some_and(|nearest| nearest >= APART);
        self.budget.allowed = aim * if are_apart { LINK_PART_OF_FEW } else { LINK_PART };
        let began = self.budget.clock.elapsed();
        self.light(of_direct, options, light)?;
        let mut refined = self.budget.clock.elapsed().saturating_sub(began);
        self.link(self.budget.allowed, links)?;
        self.budget.clock = self.budget.clock.for_estimate(options.time, self.system.mesh.clusters().root().is_some());
        if self.progress.round == 0 && self.system.mesh.clusters().root().is_some() {
            self.fill_evenly();
        } else {
            self.sweep(1e-2 * aim)?;
        }
        for _ in 0..8 {
            let began = self.budget.clock.elapsed();
            let changed = self.refine(self.budget.allowed, links)?;
            refined += self.budget.clock.elapsed().saturating_sub(began);
            self.sweep(1e-2 * aim)?;
            if !changed {
                break;
            }
        }
        self.sweep(if may_be_even(&self.system.mesh, &self.system.lamps) { SOLVED } else { ROUGHLY_SOLVED * aim })?;
        self.error_estimate = ErrorEstimate::solve(&self.system, [self.residuals_of_direct(), self.residuals_of_reflected()])?;
        let links = self
            .system
            .receivers
            .iter()
            .map(|&receiver| self.system.links[receiver].len() + self.system.far[receiver].len())
            .sum();
        self.caches = Caches::default();
        self.find_importance()?;
        let estimate = match (self.estimate_at_points(), options.marking) {
            (Some(at_points), _) => at_points,
            (None, Marking::Residual) => {
                self.correct_mean();
                self.relative(&self.mean_estimate())
            }
            (None, Marking::Gradient | Marking::Shadows) => self.magnitude(),
        };
        let (round, gathers) = (self.progress.round + 1, self.progress.gathers);
        self.progress = Progress { round, elements: self.system.mesh.leaves().count(), links, gathers, estimate };
        Ok(refined)
    }

    /// The mean magnitude of errors that a round aims at: as much less than that of the round before as the estimate is to be, but for
    /// [`STEP`]. An error of the mean is a small part of it. And the one for direct light: where this leaves out more than the error asked
    /// for, as much less than before.
    fn aims(&self, error: f64) -> [f64; 2] {
        if self.progress.round == 0 {
            return [largest(error, STEP); 2];
        }
        let step = largest(STEP, smallest(error / self.progress.estimate, 1.0));
        let aim = largest(error, step * smallest(self.magnitude(), 1.0));
        [aim, largest(error, smallest(aim, step * self.refinement.direct_residual))]
    }

    /// Estimate of the mean magnitude of the error of gathers, relative as errors are.
    fn magnitude(&self) -> f64 {
        self.relative(&self.error_estimate.mean)
    }
}

/// Means over all area of the faces' emission, in each channel: of lamps kept apart, and of others.
fn emitted(scene: &Scene, mesh: &Mesh, lamps: &Lamps, surfaces: &Surfaces) -> [Vec<f64>; 2] {
    [true, false].map(|apart| {
        let is_meant = |face: usize| apart != (lamps.is_empty() || surfaces.glows_by_texture(face));
        let emission = |face: usize, channel: usize| match is_meant(face) {
            true => std::f64::consts::PI * scene.mean_over(face, Quantity::Radiance, channel),
            false => 0.0,
        };
        (0..scene.channels().len()).map(|channel| mesh.mean(|root| emission(mesh.elements()[root].face(), channel))).collect()
    })
}

/// Whether light may be far more even than was asked for: where there are no lamps and no clusters.
fn may_be_even(mesh: &Mesh, lamps: &Lamps) -> bool {
    lamps.is_empty() && mesh.clusters().root().is_none()
}

/// The time of a round, beside refining leaves and links, after one that took so long, and one before that.
fn expected_after(last: Duration, before: Duration) -> Duration {
    let growth = if before.is_zero() { MOST_GROWTH } else { (last.as_secs_f64() / before.as_secs_f64()).clamp(1.0, MOST_GROWTH) };
    last.mul_f64(growth)
}
