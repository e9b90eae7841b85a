//! Checks of one kind of answer each, by truth, by an identity or by a record; [`bite`] is all of them in seconds.

pub mod agreement;
pub mod batches;
pub mod bite;
pub mod closed;
pub mod derivatives;
pub mod derived;
pub mod entries;
pub mod estimates;
pub mod exchanges;
pub mod foreign;
pub mod forms;
pub mod hidden;
pub mod hulls;
pub mod lamps;
pub mod long;
pub mod motions;
pub mod mutants;
pub mod operations;
pub mod precision;
pub mod rays;
pub mod record;
pub mod refusals;
pub mod regression;
pub mod screens;
pub mod shadows;
pub mod symmetry;
