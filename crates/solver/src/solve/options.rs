//! The options of a solution, and how far it has come.

use crate::bytes::bytes_of;
use std::time::Duration;

use radgrad_core::DVec3;

/// The rule by which elements are divided.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Marking {
    /// Indicator: the residual's part in the error of gathers, the quickest way to a good mean.
    #[default]
    Residual,
    /// Indicator: the mean square error of the polynomials, by samples and gradients of exact gathers: few elements for a given
    /// error of the polynomials. Faces are first cut into parallelograms about as long as wide.
    Gradient,
    /// The same on faces that are cut beforehand where polynomials then fit the light best: along the lines where the edges of
    /// lamps and of occluders throw their shadows, and in two where light changes in one direction.
    Shadows,
}

/// Accuracy, effort and ways of a solution.
///
/// ```
/// use radgrad_solver::{Marking, Options};
/// use std::time::Duration;
/// let options = Options { error: 0.01, time: Some(Duration::from_secs(5)), ..Options::default() };
/// assert_eq!(options.marking, Marking::Residual);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Estimate of the error of the mean radiosity over all area, over the mean that is reflected, at most, in every channel. Where
    /// points are served it is the mean magnitude of the error at them, and with [`Marking::Gradient`] that of gathers all over.
    pub error: f64,
    /// Degree of the basis, 0 to 4. If none is given 2; 1 from a thousand faces on, 0 from twenty thousand; 4 where elements are few and of faces that are apart, by up to
    /// twice the sum of their radii, with [`Marking::Residual`].
    pub degree: Option<usize>,
    /// All faces are divided alike until there are this many elements; then the first round begins.
    pub first_elements: usize,
    /// Elements, divided ones too, beyond which nothing is divided any more: the estimate then states the error reached. Where
    /// faces are cut into a thousand or more, these do not count.
    pub most_elements: usize,
    /// Time in which to be done: no round is begun that, by the time of those before, would end later, light is divided and links
    /// are refined no more when it is over, in the first round early. Steps that must be done once are; from a second after the
    /// time on, form factors err by up to 1e-5, and estimates include that.
    pub time: Option<Duration>,
    /// Divide the elements that add most to the estimate, or those whose polynomials are off most.
    pub marking: Marking,
}

impl Default for Options {
    fn default() -> Self {
        Self { error: 0.001, degree: None, first_elements: 32, most_elements: 20_000, time: None, marking: Marking::Residual }
    }
}

/// The step after a round. `true` is [`Self::Round`] and `false` [`Self::End`].
///
/// ```
/// use radgrad_solver::{Next, Options, solve};
/// # use radgrad_core::DVec3;
/// # use radgrad_scene::{Degenerate, Scene};
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");
/// let scene = Scene::read(file, Degenerate::Refuse)?;
/// let options = Options { error: 0.1, degree: Some(1), ..Options::default() };
/// let point = (DVec3::new(2.0, 0.5, 0.0), DVec3::Z);
/// let mean = solve(&scene, &options, |_| true)?;
/// // Once the mean is found, the view of this point is refined in two rounds.
/// let mut rounds = 0;
/// let both = solve(&scene, &options, |solution| match rounds {
///     0 if solution.progress().estimate > options.error => Next::Round,
///     2 => Next::End,
///     _ => {
///         rounds += 1;
///         Next::Serve(vec![point])
///     }
/// })?;
/// assert!(both.progress().estimate <= options.error && both.progress().elements > mean.progress().elements);
/// let [there, before] = [&both, &mean].map(|solution| solution.gather(point.0, point.1));
/// assert!(there?.estimate[0].total() < 0.5 * before?.estimate[0].total());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub enum Next {
    /// No other round.
    End,
    /// Another round, unless the solution has reached the error asked for.
    Round,
    /// Another round in any case. It serves these points, each with the direction that it faces, and aims at a third of the estimate of their mean
    /// error. From now on refinement does not serve the mean; all else stays as fine as it is.
    Serve(Vec<(DVec3, DVec3)>),
}

impl From<bool> for Next {
    fn from(goes_on: bool) -> Self {
        if goes_on { Self::Round } else { Self::End }
    }
}

/// How far a solution has come.
///
/// ```
/// use radgrad_solver::{Options, solve};
/// # use radgrad_scene::{Degenerate, Scene};
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");
/// # let scene = Scene::read(file, Degenerate::Refuse)?;
/// let options = Options { error: 0.5, degree: Some(1), first_elements: 1, ..Options::default() };
/// let solution = solve(&scene, &options, |solution| {
///     let progress = solution.progress();
///     println!("round {}: {} elements, {:.1} % by the estimate", progress.round, progress.elements, 100.0 * progress.estimate);
///     progress.elements < 500 // else it ends here
/// })?;
/// assert!(solution.progress().round >= 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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
    /// Estimate of the error that [`Options::error`] bounds, relative to the mean radiosity that is reflected, the largest of the
    /// channels.
    pub estimate: f64,
}

bytes_of!(Progress { round, elements, links, gathers, estimate });
