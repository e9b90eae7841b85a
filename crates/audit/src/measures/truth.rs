//! Truth of a case: the oracle's enclosure, and the distance of an answer from it.

use glam::DVec3;
use radgrad_core::{Emitter, Polygon, Receiver};
use radgrad_oracle::{Arithmetic, Error, Interval, Request, Source, enclose_source_occluded};
use radgrad_scene::case::Problem;

use crate::measures::seen::reduced;

/// Radiosity and gradient, each enclosed.
///
/// ```
/// use radgrad_audit::cases::family::Family;
/// use radgrad_audit::measures::truth::Truth;
/// let problem = Family::Generic.case(1, 0).problem()?;
/// let truth = Truth::unoccluded(&problem.receiver, &problem.emitter)?;
/// let answer = radgrad_core::evaluate(&problem.receiver, &problem.emitter, &[])?;
/// assert!(truth.radiosity_error(answer.radiosity) <= answer.radiosity_error);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// Radiosity.
    pub radiosity: Interval,
    /// Gradient by component.
    pub gradient: [Interval; 3],
}

/// Digits asked of the oracle where double-double arithmetic has them: four more than a double has, so that half an ulp, which
/// the error of an answer of core's double-double rung, is known to a thousandth.
const SHARP: Request = Request { digits: 20, arithmetic: Some(Arithmetic::DoubleDouble), budget: 50_000_000 };

/// Digits asked of any arithmetic where it has not, mostly near contact: a tenth of an ulp. Three more would cost fifty times
/// as much.
const ENOUGH: Request = Request::digits(17);

impl Truth {
    /// Encloses a case to 20 digits, or to 17 where that would take more than double-double arithmetic.
    ///
    /// # Errors
    /// If the oracle cannot: no bound for a cell, or no budget for the cells it takes.
    pub fn unoccluded(receiver: &Receiver, emitter: &Emitter) -> Result<Self, Error> {
        Self::occluded(receiver, emitter, &[])
    }

    /// Encloses a case with occluders. If the visible part of the emitter is a polygon, it takes the emitter's place.
    ///
    /// # Errors
    /// As [`Self::unoccluded`].
    pub fn of_problem(problem: &Problem) -> Result<Self, Error> {
        let (emitter, occluders) = reduced(problem);
        Self::occluded(&problem.receiver, &emitter, occluders)
    }

    fn occluded(receiver: &Receiver, emitter: &Emitter, occluders: &[Polygon]) -> Result<Self, Error> {
        let source = Source::Emitter(emitter);
        let enclosure = match enclose_source_occluded(receiver, &source, occluders, &SHARP) {
            Err(Error::Rounding { .. }) => enclose_source_occluded(receiver, &source, occluders, &ENOUGH)?,
            result => result?,
        };
        Ok(Self { radiosity: enclosure.radiosity, gradient: enclosure.gradient })
    }

    /// Whether two enclosures have a point in common, component by component: if not, one of them is wrong.
    #[must_use]
    pub fn overlaps(&self, other: &Self) -> bool {
        self.radiosity.overlaps(&other.radiosity) && self.gradient.iter().zip(&other.gradient).all(|(a, b)| a.overlaps(b))
    }

    /// Upper bound on the error of `radiosity`; infinite if it is not finite.
    #[must_use]
    pub fn radiosity_error(&self, radiosity: f64) -> f64 {
        self.radiosity.error_of(radiosity)
    }

    /// Upper bound on the Euclidean norm of the error of `gradient`.
    #[must_use]
    pub fn gradient_error(&self, gradient: DVec3) -> f64 {
        let [x, y, z] = [0, 1, 2].map(|k| self.gradient[k].error_of(gradient[k]));
        norm_above(DVec3::new(x, y, z))
    }

    /// Lower bounds on the two errors: a stated bound must be no less. Beside an error of half an ulp, the digits of the
    /// truth count.
    #[must_use]
    pub(crate) fn errors_at_least(&self, radiosity: f64, gradient: DVec3) -> (f64, f64) {
        let below = |interval: &Interval, value: f64| {
            let within = interval.error_of(value) * (1.0 - f64::EPSILON) - 2.0 * interval.radius();
            if within > 0.0 { within } else { 0.0 }
        };
        let components = DVec3::from_array([0, 1, 2].map(|k| below(&self.gradient[k], gradient[k])));
        (below(&self.radiosity, radiosity), norm_above(components) * (1.0 - 8.0 * f64::EPSILON))
    }

    /// Magnitude of the radiosity.
    #[must_use]
    pub fn radiosity_magnitude(&self) -> f64 {
        self.radiosity.to_f64().abs()
    }

    /// Norm of the gradient.
    #[must_use]
    pub fn gradient_magnitude(&self) -> f64 {
        let v = DVec3::from_array([0, 1, 2].map(|k| self.gradient[k].to_f64()));
        norm_above(v)
    }
}

/// The Euclidean norm. The largest component is taken out, since the square of an error or of a gradient may leave the range of a
/// double.
pub(crate) fn norm(v: DVec3) -> f64 {
    let largest = v.abs().max_element();
    if largest == 0.0 || !largest.is_finite() { largest } else { largest * (v / largest).length() }
}

/// The same rounded up.
pub(crate) fn norm_above(v: DVec3) -> f64 {
    norm(v) * (1.0 + 4.0 * f64::EPSILON)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases::family::Family;

    fn truth() -> Truth {
        let read = |text| Interval::from_decimal(text).expect("a number");
        let gradient = ["0.3333333333333333333333", "0.2500000000000000000000", "-0.0010000000000000000000"].map(read);
        Truth { radiosity: read("0.3333333333333333333333"), gradient }
    }

    #[test]
    fn the_error_of_the_nearest_double_is_below_half_an_ulp_and_not_0() {
        let error = truth().radiosity_error(1.0 / 3.0);
        assert!(error > 1.8e-17 && error < 1.9e-17, "{error:e}");
    }

    #[test]
    fn errors_lie_between_their_two_bounds() {
        let (value, gradient) = (1.0 / 3.0, DVec3::new(1.0 / 3.0, 0.25, -1e-3));
        let (least, least_of_gradient) = truth().errors_at_least(value, gradient);
        let half_third = 1.850_371_707_708_594e-17;
        assert!(least < half_third && least > 0.999 * half_third, "{least:e}");
        assert!(truth().radiosity_error(value) > half_third);
        assert!(least_of_gradient <= truth().gradient_error(gradient) && least_of_gradient >= least);
    }

    #[test]
    fn past_a_screen_on_the_emitter_is_the_truth_of_what_it_leaves() {
        for (family, index) in [Family::FarScreen, Family::ScreenScale].into_iter().flat_map(|f| (0..20).map(move |i| (f, i))) {
            let problem = family.case(1, index).problem().expect("valid");
            let visible = Truth::of_problem(&problem).expect("enclosed");
            let past = Truth::occluded(&problem.receiver, &problem.emitter, &problem.occluders).expect("enclosed");
            assert!(past.radiosity.overlaps(&visible.radiosity), "{family}:1:{index} {past:?} {visible:?}");
            assert!((0..3).all(|k| past.gradient[k].overlaps(&visible.gradient[k])), "{family}:1:{index} {past:?} {visible:?}");
        }
    }

    #[test]
    fn the_gradients_error_is_the_norm_of_the_difference() {
        let error = truth().gradient_error(DVec3::new(1.0 / 3.0, 0.25 + 3e-9, -1e-3 + 4e-9));
        assert!((error - 5e-9).abs() < 1e-16, "{error:e}");
        assert_eq!(truth().gradient_error(DVec3::NAN), f64::INFINITY);
    }

    #[test]
    fn a_norm_below_the_root_of_the_smallest_double_is_still_one() {
        assert!(norm_above(DVec3::new(3e-200, 4e-200, 0.0)) >= 5e-200);
    }
}
