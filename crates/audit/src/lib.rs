//! The audit: randomised case families, each case measured against truth, error tables, and the gates they must stay within.
//!
//! The way of the data: [`family`] draws a case from its name (by [`sampler`] and `lattice`); [`measure`] evaluates it by
//! core and holds the answer against [`truth`] (the oracle's enclosure, of the visible part of the emitter where [`seen`] knows
//! it), the case's [`condition`] and the bounds that the answer states; [`table`] is a [`tally`] of the figures by family, as
//! [`distribution`]s over [`leading`] digits and [`decade`]s; [`run`] does so on all cores, [`shard`] over machines; [`gates`]
//! limit the figures; [`shrink`] makes a case that breaks one smaller, and [`regression`] keeps it.
//!
//! [`bounds`] answers for millions of cases a question that [`measure`] cannot answer in time: whether any stated bound is below
//! the error.
//!
//! [`search`] climbs towards the largest error over bound, and [`witness`] keeps its cases; [`record`] keeps the statements with
//! any other bound. [`bite`] is all that in seconds, on shipped code as it is or with a fault planted in it.
//!
//! Some checks need no truth of their own: [`symmetry`] has the same case in other units, turned and mirrored, [`hulls`] polygons that are not flat
//! against their triangles, [`lamps`] a few lamps together against each alone, [`refusals`] what is just within a rule and just beyond;
//! [`operations`] has single operations against the same with more digits, [`estimates`] what the oracle says beside its enclosures.
//!
//! [`comparison`] and [`stability`] hold other ways of computing the same against ours: [`contender`]s, the paper's form and
//! `single_precision` among them, family by family and over planes of two parameters.
//!
//! [`scenes`] holds whole scenes to truth, every bound of `solve`, `factors` and `field`.
//!
//! [`precision`] asks core and the oracle for up to 100 digits; [`forms`] holds the paper's equations against each other; [`foreign`]
//! holds any program's answers to the same truth.
//!
//! Two checks of the checks: [`mutants`] plants slips that the measurement must see, [`agreement`] lets the oracles contradict
//! each other.

pub mod agreement;
pub mod batches;
pub mod bite;
pub mod bounds;
pub mod closed;
pub mod comparison;
pub mod condition;
pub mod contender;
pub mod decade;
pub mod derivatives;
pub mod derived;
pub mod distribution;
pub mod entries;
pub mod estimates;
pub mod exchanges;
pub mod family;
pub mod foreign;
pub mod forms;
pub mod gates;
pub mod hidden;
pub mod hulls;
pub mod lamps;
mod lattice;
pub mod leading;
pub mod long;
pub mod measure;
pub mod motions;
pub mod mutants;
pub mod name;
pub mod operations;
pub mod precision;
pub mod rays;
pub mod record;
pub mod refusals;
pub mod regression;
pub mod run;
pub mod sampler;
pub mod scenes;
pub mod screens;
pub mod search;
pub mod seen;
pub mod shadows;
pub mod shard;
pub mod shrink;
mod single_precision;
pub mod stability;
pub mod symmetry;
pub mod table;
pub mod tally;
pub mod truth;
pub mod witness;
