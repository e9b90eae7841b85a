//! The options of a solution, and how far it has come.

use std::time::Duration;

use radgrad_scene::Placement;

use crate::field::order::Order;
use crate::links::linking::Linking;

/// What elements are divided by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Marking {
    /// What their residual adds to the bound on gathers: the quickest way to a bound.
    #[default]
    Residual,
    /// What their polynomials are off by in the mean square, by samples and gradients of exact gathers: the fewest elements for a
    /// given error of the polynomials.
    Gradient,
}

/// What errors are relative to: a mean over all area.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum RelativeTo {
    /// The mean of the radiosity that is reflected: what faces emit is given, and has no error.
    #[default]
    Reflected,
    /// The mean radiosity, with what faces emit.
    All,
}

/// Accuracy, effort and ways of a solution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Estimate of the mean error of gathers over all area, over what [`Self::relative_to`] says, at most, in every channel.
    pub error: f64,
    /// Proven bound on the mean error of the polynomials over all area, over the same, at most, in every channel: in the place of the
    /// estimate.
    pub bound: Option<f64>,
    /// What errors are relative to.
    pub relative_to: RelativeTo,
    /// Degree of the basis, 0 to 4; 2 if none is given.
    pub degree: Option<usize>,
    /// All faces are divided alike until there are this many elements; then the first round begins.
    pub first_elements: usize,
    /// Elements, divided ones too, beyond which nothing is divided any more: the bound then says what was reached.
    pub most_elements: usize,
    /// Divide everything rather than what pays.
    pub uniform: bool,
    /// Time in which to be done: no round is begun that, by the time of those before, would end later. The first one always is.
    pub time: Option<Duration>,
    /// What pays: what adds most to the bound, or the polynomials that are off most.
    pub marking: Marking,
    /// How finely elements are linked. With thresholds there is one round, in which nothing is divided for the error asked for: set
    /// `first_elements` to 1 for a mesh that follows from them alone.
    pub linking: Linking,
    /// The order in which receivers gather.
    pub order: Order,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            error: 0.005,
            bound: None,
            relative_to: RelativeTo::Reflected,
            degree: None,
            first_elements: 32,
            most_elements: 20_000,
            uniform: false,
            time: None,
            marking: Marking::Residual,
            linking: Linking::Error,
            order: Order::GaussSeidel,
        }
    }
}

impl Options {
    /// The same where a scene was moved and scaled.
    pub(crate) fn inward(&self, placement: &Placement) -> Self {
        let linking = match self.linking {
            Linking::Thresholds { form_factor, area } => {
                Linking::Thresholds { form_factor, area: area * placement.power() * placement.power() }
            }
            Linking::Error => Linking::Error,
        };
        Self { linking, ..*self }
    }
}

/// How far a solution has come.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Round, from 1.
    pub round: usize,
    /// Leaves.
    pub elements: usize,
    /// Links.
    pub links: usize,
    /// Gathers of receivers so far.
    pub gathers: usize,
    /// Proven bound on the mean error, relative as [`Options::relative_to`] says, the largest of the channels: known after the
    /// last round, and after every round if [`Options::bound`] asks for it; infinite until then.
    pub bound: f64,
    /// Estimate of the same.
    pub estimate: f64,
}
