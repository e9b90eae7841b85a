//! The cases of the campaign, and the checks made of each.

use crate::bounds::check::{Effort, check};
use crate::bounds::digits::MANY;
use crate::bounds::table::Table;
use crate::cases::family::{Family, Name};
use crate::measures::run::{Part, Run};

/// Loose tolerances, in turn: to 1 the first rung answers with whatever bound it has.
const LOOSE: [f64; 4] = [1.0, 1e-3, 1e-6, 1e-9];

/// One case of so many of a family is held against 22 digits; prime, so that every loose tolerance is among them.
pub const DIGITS_EVERY: u64 = 17;

/// One of so many is held against the oracle.
pub const ORACLE_EVERY: u64 = 19;

/// In one of so many, 30, 50 or 100 digits are held against twice as many.
pub const MANY_EVERY: u64 = 1009;

/// In one of so many, also against the oracle.
pub const MANY_BY_ORACLE_EVERY: u64 = 20_011;

/// Cases of a family in proportion to the others: fewer of cases that take the dear rungs, where a case costs 50 times as much.
/// Where nothing is computed, or the input is refused, few do. 0 where each takes a second: see [`run`].
#[must_use]
pub const fn share(family: Family) -> u64 {
    match family {
        Family::Generic
        | Family::Clipped
        | Family::Contact
        | Family::NearEdge
        | Family::NearVertex
        | Family::Scale
        | Family::ContactScale => 48,
        Family::NearExtension
        | Family::Grazing
        | Family::FarOrigin
        | Family::Concave
        | Family::NGon
        | Family::GrazingScale
        | Family::SteepExtension
        | Family::PolynomialClipped => 12,
        Family::ShortNormal => 12,
        Family::Far | Family::Needle => 6,
        Family::OnSurface
        | Family::Subnormal
        | Family::MixedExponents
        | Family::CancellingValues
        | Family::NearCoincidentVertices
        | Family::OccludersInPlane => 3,
        Family::HorizonSliver
        | Family::FarNeedle
        | Family::FarClipped
        | Family::ContactSliver
        | Family::InPlaneInside
        | Family::InPlaneOutside
        | Family::BackFacing
        | Family::BelowHorizon => 3,
        Family::OneScreen
        | Family::EdgeScreen
        | Family::DippingScreen
        | Family::OtherScale
        | Family::Standing
        | Family::IdleScreens
        | Family::NearScreen
        | Family::SilhouetteScreen => 3,
        Family::FarScreen
        | Family::ScreenScale
        | Family::PolynomialFar
        | Family::SteepNormal
        | Family::Single
        | Family::EqualVertices
        | Family::HundredVertices
        | Family::TenScreens
        | Family::Boxes
        | Family::Thicket => 1,
        Family::ThousandTriangles => 0,
    }
}

/// About `cases` cases of these families, by their shares, at least one of each; of a family without a share one in 40,000.
#[must_use]
pub fn run(cases: u64, families: &[Family], seed: u64, part: Part) -> Run {
    let shares: u64 = families.iter().map(|&family| share(family)).sum();
    let count = |family: Family| match share(family) {
        0 => cases / 40_000,
        share => (cases * share).div_ceil(shares),
    };
    let cases_of = |family: Family| (family, count(family).max(1));
    Run { seed, cases: families.iter().map(|&family| cases_of(family)).collect(), part }
}

/// The checks of a case beyond the usual ones, by its index: the dear ones fall on few cases.
#[must_use]
pub(crate) fn effort(name: Name) -> Effort {
    let turn = |every: u64, count: usize| usize::try_from(name.index / every).unwrap_or(0) % count;
    // The first case of each kind is among the first ten, so that a small run has some of all.
    let [oracle, digits, many, many_by_oracle] =
        [(ORACLE_EVERY, 3), (DIGITS_EVERY, 5), (MANY_EVERY, 7), (MANY_BY_ORACLE_EVERY, 7)]
            .map(|(every, at)| name.index % every == at);
    let many = if many_by_oracle {
        vec![(MANY[turn(MANY_BY_ORACLE_EVERY, 3)], true)]
    } else if many || name.family == Family::Standing && digits {
        vec![(MANY[turn(MANY_EVERY, 3)], false)]
    } else {
        Vec::new()
    };
    Effort { loose: vec![LOOSE[turn(1, LOOSE.len())]], digits, oracle, many }
}

/// All that can be done with a case in little time: for one that is looked at, or that failed once.
#[must_use]
pub fn full_effort() -> Effort {
    Effort { loose: LOOSE.to_vec(), digits: true, oracle: true, many: vec![(MANY[0], true)] }
}

/// Checks every case. `done` is called after each, from any thread.
pub fn table(run: &Run, done: impl Fn() + Sync) -> Table {
    run.tally(|table: &mut Table, name| {
        table.record(name, &check(&name.case(), &effort(name)));
        done();
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cases_are_shared_out_and_none_goes_without() {
        let run = run(1000, &Family::ALL, 1, Part::WHOLE);
        assert_eq!(run.cases.len(), Family::ALL.len());
        assert!(run.cases.iter().all(|(_, count)| *count > 0));
        let count_of = |family| run.cases.iter().find(|(f, _)| *f == family).map_or(0, |(_, count)| *count);
        assert!((1000..1030).contains(&run.count()) && count_of(Family::Generic) > 15 * count_of(Family::FarScreen));
    }

    #[test]
    fn every_loose_tolerance_meets_every_truth() {
        let efforts: Vec<Effort> =
            (0..3 * ORACLE_EVERY * 4).map(|index| effort(Name { family: Family::Far, seed: 1, index })).collect();
        for loose in LOOSE {
            assert!(
                efforts.iter().any(|e| e.loose == [loose] && e.oracle) && efforts.iter().any(|e| e.loose == [loose] && e.digits)
            );
        }
        assert_eq!(efforts.iter().filter(|e| e.oracle).count(), 12);
    }
}
