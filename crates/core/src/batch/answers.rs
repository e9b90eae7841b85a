//! The results of a batch, as a structure of arrays.

use glam::DVec3;
use radgrad_numbers::lanes::lane::Lane;

use crate::ladder::answer::{Answer, Method};

/// One entry of each array a receiver, or an emitter. Arrays that were not requested are empty. Kept from one batch to the next
/// it is not allocated again.
///
/// ```
/// use radgrad_core::batch::{Answers, Engine, Receivers};
/// // A square lamp of side 1 over two receivers: a length under its corner, and under its middle.
/// # use radgrad_core::{DVec3, Emission, Emitter, Polygon};
/// # let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
/// # let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))?;
/// # let (x, zero, one) = ([0.0, 0.5], [0.0_f64; 2], [1.0; 2]);
/// # let floor = Receivers::new([&x, &x, &zero], [&zero, &zero, &one], &[1.0])?; // under a corner and under the middle
///
/// let mut answers = Answers::new();
/// Engine::new().radiosity_to(&floor, &lamp, 1e-9, &mut answers)?;
/// assert_eq!((answers.radiosity.len(), answers.radiosity_error.len()), (2, 2));
/// assert!(answers.gradient[0].is_empty()); // not requested
/// # Ok::<(), radgrad_core::Error>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Answers<F = f64> {
    /// Radiosity `B(x)`, in the unit of the emission.
    pub radiosity: Vec<F>,
    /// Gradient of `B` with respect to `x` at fixed normal: its x, y and z components.
    pub gradient: [Vec<F>; 3],
    /// Proven bounds on the errors of `radiosity`.
    pub radiosity_error: Vec<F>,
    /// Proven bounds on the Euclidean norms of the errors of `gradient`.
    pub gradient_error: Vec<F>,
    /// The method of each entry, where bounds were requested: [`Method::ClosedForm`] of lanes.
    pub method: Vec<Method>,
    /// How the entries were answered.
    pub counts: Counts,
}

/// How many entries were answered in each way.
///
/// ```
/// use radgrad_core::batch::{Answers, Counts, Engine, Receivers};
/// // A square lamp of side 1 over two receivers: a length under its corner, and under its middle.
/// # use radgrad_core::{DVec3, Emission, Emitter, Polygon};
/// # let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
/// # let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))?;
/// # let (x, zero, one) = ([0.0, 0.5], [0.0_f64; 2], [1.0; 2]);
/// # let floor = Receivers::new([&x, &x, &zero], [&zero, &zero, &one], &[1.0])?; // under a corner and under the middle
///
/// let away = Receivers::new([&x, &x, &zero], [&zero, &zero, &[1.0, -1.0]], &[1.0])?; // one up, one down
/// let mut answers = Answers::new();
/// Engine::new().radiosity(&away, &lamp, &mut answers)?;
/// assert_eq!(answers.counts, Counts { whole: 1, zero: 1, ..Counts::default() });
/// # Ok::<(), radgrad_core::Error>(())
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Nothing to compute: behind the emitter or in its plane, or all of it below the horizon. Exactly 0.
    pub zero: usize,
    /// The closed form on lanes, of the whole emitter.
    pub whole: usize,
    /// The closed form on lanes, of the part above the horizon.
    pub clipped: usize,
    /// Lanes of single precision that cancel, done again in double precision; they are among `whole` and `clipped` too where
    /// that sufficed.
    pub doubled: usize,
    /// One by one: too near an edge or its extension, too close to call, a tolerance that double precision does not reach, or an occluder that
    /// may hide something.
    pub single: usize,
}

impl std::ops::AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.zero += other.zero;
        self.whole += other.whole;
        self.clipped += other.clipped;
        self.doubled += other.doubled;
        self.single += other.single;
    }
}

/// Which arrays are requested.
#[derive(Debug, Clone, Copy)]
pub(super) struct Asked {
    pub(super) gradient: bool,
    pub(super) errors: bool,
    pub(super) methods: bool,
}

impl<F: Lane> Answers<F> {
    /// Empty arrays, to be filled.
    ///
    /// ```
    /// # use radgrad_core::batch::Answers;
    /// assert!(Answers::<f32>::new().radiosity.is_empty());
    /// ```
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// One entry; a quantity that was not requested is 0.
    pub(super) fn answer(&self, index: usize) -> Answer {
        let value = |array: &[F]| array.get(index).map_or(0.0, |value| value.to_double());
        let of_lanes = if value(&self.radiosity) == 0.0 { Method::Zero } else { Method::ClosedForm };
        let method = self.method.get(index).copied().unwrap_or(of_lanes);
        Answer {
            radiosity: value(&self.radiosity),
            gradient: DVec3::from(self.gradient.each_ref().map(|array| value(array))),
            radiosity_error: value(&self.radiosity_error),
            gradient_error: value(&self.gradient_error),
            method,
        }
    }

    /// Arrays of `count` entries, as slots to write to.
    pub(super) fn sized(&mut self, count: usize, asked: Asked) -> Slots<'_, F> {
        let size = |array: &mut Vec<F>, wanted: bool| array.resize(if wanted { count } else { 0 }, F::default());
        size(&mut self.radiosity, true);
        self.gradient.iter_mut().for_each(|array| size(array, asked.gradient));
        size(&mut self.radiosity_error, asked.errors);
        size(&mut self.gradient_error, asked.errors && asked.gradient);
        self.method.resize(if asked.methods { count } else { 0 }, Method::ClosedForm);
        let Self { radiosity, gradient, radiosity_error, gradient_error, method, .. } = self;
        Slots { radiosity, gradient: gradient.each_mut().map(Vec::as_mut_slice), radiosity_error, gradient_error, method }
    }
}

/// A stretch of the arrays, to be written.
pub(super) struct Slots<'a, F> {
    pub(super) radiosity: &'a mut [F],
    pub(super) gradient: [&'a mut [F]; 3],
    pub(super) radiosity_error: &'a mut [F],
    pub(super) gradient_error: &'a mut [F],
    pub(super) method: &'a mut [Method],
}

impl<F> Slots<'_, F> {
    /// Records the entries that lanes are about to answer.
    pub(super) fn on_lanes(&mut self) {
        self.method.fill(Method::ClosedForm);
    }

    /// Notes entries that see nothing.
    pub(super) fn see_nothing(&mut self, entries: impl Iterator<Item = usize>) {
        if !self.method.is_empty() {
            entries.for_each(|entry| self.method[entry] = Method::Zero);
        }
    }

    /// The first `middle` entries, and the others.
    pub(super) fn split_at(self, middle: usize) -> (Self, Self) {
        fn halves<F>(slice: &mut [F], middle: usize) -> (&mut [F], &mut [F]) {
            slice.split_at_mut(middle.min(slice.len()))
        }
        let Self { radiosity, gradient: [x, y, z], radiosity_error, gradient_error, method } = self;
        let (radiosity, radiosity_rest) = halves(radiosity, middle);
        let ((x, x_rest), (y, y_rest), (z, z_rest)) = (halves(x, middle), halves(y, middle), halves(z, middle));
        let (radiosity_error, radiosity_error_rest) = halves(radiosity_error, middle);
        let (gradient_error, gradient_error_rest) = halves(gradient_error, middle);
        let (method, method_rest) = halves(method, middle);
        (
            Self { radiosity, gradient: [x, y, z], radiosity_error, gradient_error, method },
            Self {
                radiosity: radiosity_rest,
                gradient: [x_rest, y_rest, z_rest],
                radiosity_error: radiosity_error_rest,
                gradient_error: gradient_error_rest,
                method: method_rest,
            },
        )
    }
}
