//! Do the bounds hold? A campaign over millions of cases: the answers of core at several tolerances, each against a much tighter
//! enclosure of the truth.
//!
//! Every case is answered to 1e-12, to 1e-15 and to a loose tolerance, which the first rung meets with whatever bound it has
//! ([`campaign`]). The truth is to be cheap, so there are three of them ([`reference`](mod@reference)):
//! - core's own answer to a tolerance of 0, in every case: the enclosure of its dearer rungs, to half an ulp. It tells whether the
//!   *rounding* bounds of the cheaper rungs hold, not whether the formulas are right, and of answers that are themselves good to
//!   half an ulp it tells little: those are counted as *blunt*;
//! - core's [`evaluate_digits`](radgrad_core::evaluate_digits) to 22 digits, in one case of 17: sharp for every bound of a
//!   double, and it judges the answer to a tolerance of 0 too;
//! - the oracle's enclosure, in one case of 19: it shares no formula with core, so it tells whether the formulas are right.
//!
//! All three come with a radius, and a bound is *broken* only if the error is above it for every truth within that radius:
//! `|answer - truth| > bound + radius`. A check is *sharp* if the radius is at most a hundredth of the bound.
//!
//! Answers to 30, 50 and 100 digits ([`digits`]) are held against twice as many in one case of 1009, and against the oracle's
//! enclosure to more digits in one of 20,011: the enclosures must overlap.
//!
//! A case yields marks and figures ([`mark`]); their tally is the bounds [`table`]; [`requirements`] hold the limits on them.

pub mod campaign;
pub mod check;
pub mod digits;
pub mod mark;
pub mod reference;
pub mod requirements;
pub mod search;
pub mod table;
pub mod witness;

#[cfg(test)]
mod tests;
