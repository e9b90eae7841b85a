//! Whole scenes held to truth: every number that `solve`, `factors` and `field` state with a bound or an estimate, against walks, enclosures and
//! exact solutions of the oracle that share no code with them.
//!
//! ```text
//! family:seed:index -> Model          family, draw: faces with materials, points to ask at, an exact solution if there is one
//!   -> Statement                      statement: a value of the solver or of the form factors, with its bound or estimate
//!   -> Known                          truth: limits at a confidence of all but 1e-7, or an enclosure, or the exact solution
//!   -> Verdict                        judge: held, broken, or the truth is too rough to say
//!   -> Row of a family and a subject  table: counts, medians, time; gates
//!   certificates: limits that hold with a stated probability, against the truth of the solution beside them
//!   brackets: factors pair by pair, many thousands, against few rays each
//!   shrink: the fewest faces that still break a bound
//! ```
//!
//! A bound is **broken** only if `|stated - truth|` is above the bound and half the width of the truth's interval together. Where
//! that half-width is above both the bound and [`judge::ROUGH`] of the mean reflected radiosity, the truth is **rough**, which is
//! counted by itself: the gates demand a share of statements that was judged.

pub mod alike;
pub mod brackets;
mod certificates;
pub mod draw;
pub mod family;
pub mod gradients;
pub mod identities;
pub mod judge;
pub mod model;
pub mod pieces;
pub mod shrink;
pub mod statement;
pub mod table;
pub mod truth;
mod workers;
pub mod written;
