//! The audit: randomised case families, each case measured against truth, error tables, and the gates they must stay within.
//!
//! From the ground up: a module imports from those above it in this table.
//!
//! | module | does |
//! |---|---|
//! | [`cases`] | draws cases from their names, in families of difficulty; makes one that fails smaller |
//! | [`measures`] | holds core's answer to a case against the oracle's enclosure, and distributes the errors over tables |
//! | [`bounds`] | asks of millions of cases whether a stated bound is below the error, and climbs towards the largest error over bound |
//! | [`scenes`] | holds whole scenes to truth: every bound of `solve`, `factors` and `field` |
//! | [`gates`] | say what figures of all these may be at most |
//! | [`checks`] | hold one kind of answer each, by truth, by an identity or by a record; [`checks::bite`] is all of them in seconds; cases that once failed are kept |
//! | [`comparison`] | holds other ways of computing the same against ours, family by family and over planes of two parameters |
//!
//! A case goes from its name to a row of a table:
//!
//! ```text
//! family:seed:index -> Case          cases: family draws it by sampler and lattice
//!   -> Measurement                   measures: measure asks core, truth asks the oracle, of the part of the emitter that seen knows;
//!                                             condition says how far a rounding of the input moves the answer
//!   -> Tally -> Table -> gates       measures, gates: distributions over leading digits and decades; run does so on all cores, shard over machines
//!   -> a smaller case                cases: shrink; checks: regression, where a gate is broken
//! ```
//!
//! Two checks check the checks: [`checks::mutants`] plants misprints that the measurement must see, and [`checks::agreement`] lets the oracles
//! contradict each other. `cargo xtask mutants` runs [`checks::bite`] on shipped code with drawn faults.

pub mod bounds;
pub mod cases;
pub mod checks;
pub mod comparison;
pub mod gates;
pub mod measures;
pub mod scenes;
