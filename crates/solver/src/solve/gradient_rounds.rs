//! Rounds for the sake of gradients at points.
//!
//! Gradients are off by more than the mean is, each by its own. So refinement first serves the mean, beyond the error asked for, until the
//! estimates of all gradients' errors are small parts of the gradients, it has gone far enough, or a part of the time is over; and then in a
//! few rounds those points whose gradients are not known as well by then.

use std::time::Duration;

use radgrad_core::DVec3;
use rayon::prelude::*;

use crate::clock::Clock;
use crate::solve::options::Next;
use crate::solve::solution::Solution;

/// The error of the mean that ends its refinement, and the part of the time after which it is left as it is.
const MEAN: f64 = 2e-4;
const TIME_FOR_MEAN: f64 = 1.0 / 6.0;

/// The part of the time after which no points are served.
const TIME_FOR_POINTS: f64 = 0.4;

/// Rounds that serve points: where light is even a gradient may be 0, and is never known to a part of that.
const MOST_SERVICES: usize = 2;

/// Some errors are thrice their estimates: an error is surely within the allowed one if its estimate is within this part of that.
const SURE: f64 = 0.3;

/// Stopping rule for [`crate::solve`] that refines until gradients at given points reach a relative accuracy.
///
/// ```
/// use radgrad_core::DVec3;
/// use radgrad_solver::{GradientRounds, Options, solve};
/// use std::time::Duration;
/// # use radgrad_scene::{Degenerate, Scene};
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");
/// # let scene = Scene::read(file, Degenerate::Refuse)?;
/// let points = [(DVec3::new(0.1, 0.0, 0.1), DVec3::Y)];
/// let time = Duration::from_secs(10);
/// let options = Options { error: 0.05, time: Some(time), ..Options::default() };
/// let mut rounds = GradientRounds::new(&points, 0.05, options.error, time);
/// let options = Options { error: rounds.error(), ..options };
/// let solution = solve(&scene, &options, |solution| rounds.next(solution))?;
/// assert!(solution.progress().estimate <= 0.05);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct GradientRounds {
    /// Those that may be served.
    points: Vec<(DVec3, DVec3)>,
    within: f64,
    asked: f64,
    clock: Clock,
    time: Duration,
    /// The mean is served no more.
    has_mean: bool,
    services: usize,
}

impl GradientRounds {
    /// For points, each with the direction that it faces, the part of each gradient that its error is to be within surely, the error asked of
    /// the mean, and the time that there is in all.
    #[must_use]
    pub fn new(points: &[(DVec3, DVec3)], within: f64, error: f64, time: Duration) -> Self {
        let (points, clock) = (points.to_vec(), Clock::started());
        Self { points, within, asked: error, clock, time, has_mean: false, services: 0 }
    }

    /// The same for points that are served already ([`crate::solve_for`]), in place of the mean.
    #[must_use]
    pub const fn of_served(mut self) -> Self {
        self.services = MOST_SERVICES;
        self
    }

    /// The error to ask the solver for, so that it goes on beyond the one asked for.
    #[must_use]
    pub fn error(&self) -> f64 {
        if self.asked < MEAN { self.asked } else { MEAN }
    }

    /// The step after a round.
    pub fn next(&mut self, solution: &Solution) -> Next {
        let estimate = solution.progress().estimate;
        if !self.has_mean {
            let is_late = self.is_late(TIME_FOR_MEAN);
            if estimate > self.asked || estimate > self.error() && !is_late {
                let is_known = || self.points.par_iter().all(|&point| solution.has_gradient_within(point, self.within));
                return Next::from(estimate > self.asked || !is_known());
            }
            self.has_mean = true;
        }
        if self.services == MOST_SERVICES || self.services > 0 && self.is_late(TIME_FOR_POINTS) {
            return Next::End;
        }
        self.services += 1;
        let points = std::mem::take(&mut self.points);
        self.points = points.into_par_iter().filter(|&point| !solution.has_gradient_within(point, self.within)).collect();
        if self.points.is_empty() { Next::End } else { Next::Serve(self.points.clone()) }
    }

    fn is_late(&self, part: f64) -> bool {
        self.clock.elapsed() >= self.time.mul_f64(part)
    }
}

impl Solution {
    /// Whether the error of the gradient of the irradiance at a point is surely within this part of it, in each channel. Of a point that is
    /// refused nothing more can be known, and the answer is yes.
    fn has_gradient_within(&self, (point, normal): (DVec3, DVec3), part: f64) -> bool {
        let gather = match self.is_on_a_face(point) {
            true => self.gradient(point, normal).map(|surface| surface.irradiance),
            false => self.irradiance_gradient_at(point, normal),
        };
        gather.ok().is_none_or(|gradient| {
            gradient.gradient.iter().zip(&gradient.estimate).all(|(slope, error)| *error <= SURE * part * slope.length())
        })
    }
}
