//! How accurate the library is in one family of cases: 40 needles, each against an enclosure of its exact value.
//!
//! `cargo run -p radgrad-audit --example one_family`
//!
//! ```text
//! needle: a triangle 1e-8 to 0.1 times as wide as long, 40 cases
//!   value                median 1.6e-16, worst 6.6e-15 at needle:1:28
//!   gradient             median 2.1e-16, worst 6.7e-15 at needle:1:0
//!   value-over-bound     median 1.4e-2, worst 4.9e-1 at needle:1:7
//!   gradient-over-bound  median 1.2e-2, worst 7.4e-1 at needle:1:7
//! ```

use radgrad_audit::cases::family::Family;
use radgrad_audit::measures::measure::Quantity;
use radgrad_audit::measures::run::Run;

fn main() {
    let table = Run::of_each(40, &[Family::Needle], 1).table(|_| ());
    for (family, figures) in table.families() {
        println!("{family}: {}, {} cases", family.description(), figures.cases());
        for quantity in [Quantity::Value, Quantity::Gradient, Quantity::ValueOverBound, Quantity::GradientOverBound] {
            let Some(distribution) = figures.figures().get(&quantity) else { continue };
            let (Some(median), Some(worst)) = (distribution.percentile(50), distribution.worst()) else { continue };
            println!("  {:20} median {median}, worst {:.1e} at {}", quantity.name(), worst.value, worst.case);
        }
    }
}
