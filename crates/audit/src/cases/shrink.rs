//! Makes a failing case small: the fewest vertices, the simplest emission, the shortest numbers that still fail.
//!
//! A candidate is taken if it still fails and its [`weight`] is smaller, until none is: the weight, an integer, falls with each
//! step, so this ends. The caller defines "fails"; it should hold on to the property that makes the case its family's, or the
//! result will fail for another reason.

use radgrad_scene::case::{Case, EmissionRecord};

/// The smallest case that `fails` found from `case`, in steps each of which fails.
pub fn shrink(case: &Case, fails: impl Fn(&Case) -> bool) -> Case {
    let mut smallest = case.clone();
    loop {
        let least = weight(&smallest);
        let smaller = candidates(&smallest).find(|candidate| weight(candidate) < least && fails(candidate));
        match smaller {
            Some(smaller) => smallest = smaller,
            None => return smallest,
        }
    }
}

/// The size that shrinking reduces: a number counts its significant bits, a vertex or an occluder 1000, varying emission 200, so
/// that the fewest vertices come first.
#[must_use]
pub fn weight(case: &Case) -> u32 {
    let mut probe = case.clone();
    let digits: u32 = numbers(&mut probe).into_iter().map(|x| significant_bits(*x)).sum();
    let vertices = u32::try_from(case.emitter.vertices.len()).unwrap_or(u32::MAX / 2000);
    let varies = !matches!(case.emitter.emission, EmissionRecord::Constant { .. });
    let occluders = u32::try_from(case.occluders.len()).unwrap_or(u32::MAX / 2000);
    digits + 1000 * (vertices + occluders) + 200 * u32::from(varies)
}

/// Smaller cases to try, the boldest first.
fn candidates(case: &Case) -> impl Iterator<Item = Case> + '_ {
    let removed = without_an_occluder(case).chain(without_a_vertex(case));
    plainer(case).into_iter().chain(removed).chain(shifted(case)).chain(all_shorter(case)).chain(one_shorter(case))
}

/// With constant emission, and with reflectance 1.
fn plainer(case: &Case) -> [Case; 2] {
    let (mut constant, mut white) = (case.clone(), case.clone());
    constant.emitter.emission = EmissionRecord::Constant { constant: 1.0 };
    white.receiver.reflectance = 1.0;
    [constant, white]
}

fn without_an_occluder(case: &Case) -> impl Iterator<Item = Case> + '_ {
    (0..case.occluders.len()).map(|index| {
        let mut smaller = case.clone();
        smaller.occluders.remove(index);
        smaller
    })
}

fn without_a_vertex(case: &Case) -> impl Iterator<Item = Case> + '_ {
    (0..case.emitter.vertices.len()).map(|index| {
        let mut smaller = case.clone();
        smaller.emitter.vertices.remove(index);
        if let EmissionRecord::Vertices { vertices } = &mut smaller.emitter.emission
            && index < vertices.len()
        {
            vertices.remove(index);
        }
        smaller
    })
}

/// The receiver or vertex 0 moved to the origin.
fn shifted(case: &Case) -> impl Iterator<Item = Case> + '_ {
    let origins = [Some(case.receiver.position), case.emitter.vertices.first().copied()];
    origins.into_iter().flatten().map(|origin| {
        let mut moved = case.clone();
        let anchor = match &mut moved.emitter.emission {
            EmissionRecord::Polynomial { polynomial } => Some(&mut polynomial.origin),
            EmissionRecord::Constant { .. }
            | EmissionRecord::Vertices { .. }
            | EmissionRecord::Gradient { .. }
            | EmissionRecord::Expression { .. } => None,
        };
        let occluders = moved.occluders.iter_mut().flatten();
        for point in
            std::iter::once(&mut moved.receiver.position).chain(&mut moved.emitter.vertices).chain(anchor).chain(occluders)
        {
            *point = [0, 1, 2].map(|axis| point[axis] - origin[axis]);
        }
        moved
    })
}

const FEW: [u32; 10] = [0, 1, 2, 4, 8, 16, 24, 32, 40, 48];

fn all_shorter(case: &Case) -> impl Iterator<Item = Case> + '_ {
    FEW.into_iter().map(|bits| {
        let mut shorter = case.clone();
        for x in numbers(&mut shorter) {
            *x = rounded(*x, bits);
        }
        shorter
    })
}

fn one_shorter(case: &Case) -> impl Iterator<Item = Case> + '_ {
    let count = numbers(&mut case.clone()).len();
    (0..count).flat_map(move |index| {
        FEW.into_iter().map(move |bits| {
            let mut shorter = case.clone();
            if let Some(x) = numbers(&mut shorter).into_iter().nth(index) {
                *x = rounded(*x, bits);
            }
            shorter
        })
    })
}

/// Every number of a case.
fn numbers(case: &mut Case) -> Vec<&mut f64> {
    let receiver = &mut case.receiver;
    let mut coordinates: Vec<&mut f64> = receiver.position.iter_mut().chain(&mut receiver.normal).collect();
    coordinates.push(&mut receiver.reflectance);
    coordinates.extend(case.emitter.vertices.iter_mut().flatten());
    coordinates.extend(case.occluders.iter_mut().flatten().flatten());
    match &mut case.emitter.emission {
        EmissionRecord::Constant { constant } => coordinates.push(constant),
        EmissionRecord::Vertices { vertices } => coordinates.extend(vertices),
        EmissionRecord::Gradient { value, gradient } => {
            coordinates.push(value);
            coordinates.extend(gradient);
        }
        EmissionRecord::Polynomial { polynomial } => {
            coordinates.extend(&mut polynomial.origin);
            coordinates.extend(polynomial.terms.iter_mut().map(|term| &mut term.coefficient));
        }
        EmissionRecord::Expression { .. } => {}
    }
    coordinates
}

/// Bits from the first 1 to the last.
const fn significant_bits(x: f64) -> u32 {
    let mantissa = x.to_bits() & ((1 << 52) - 1);
    if x == 0.0 { 0 } else { 53 - if mantissa == 0 { 52 } else { mantissa.trailing_zeros() } }
}

/// `x` to so many significant bits, the rest cut off; 0 to none.
const fn rounded(x: f64, bits: u32) -> f64 {
    if bits == 0 { 0.0 } else { f64::from_bits(x.to_bits() & !((1 << (53 - bits)) - 1)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases::family::{Family, Name};
    use proptest::prelude::*;

    #[test]
    fn bits_are_counted_from_the_first_1_to_the_last() {
        assert_eq!([0.0, 1.0, -8.0, 1.5, 0.1].map(significant_bits), [0, 1, 1, 2, 52]);
        assert_eq!([rounded(0.1, 2), rounded(-1.75, 1), rounded(3.0, 0)], [0.09375, -1.0, 0.0]);
    }

    #[test]
    fn what_fails_always_becomes_as_small_as_cases_are() {
        let case = shrink(&Family::Concave.case(1, 3), |candidate| candidate.problem().is_ok());
        assert_eq!(case.emitter.vertices.len(), 3);
        assert_eq!(case.emitter.emission, EmissionRecord::Constant { constant: 0.0 });
        assert!(weight(&case) < 3020, "{case:?}");
    }

    #[test]
    fn the_reason_to_fail_is_kept_and_the_rest_is_not() {
        let reason =
            |case: &Case| case.problem().is_ok_and(|p| p.receiver.position().x > 0.3 && p.emitter.polygon().vertices().len() > 4);
        let start = (0..).map(|index| Family::NGon.case(1, index)).find(&reason).expect("one in two is");
        let case = shrink(&start, reason);
        assert_eq!(case.emitter.vertices.len(), 5);
        assert!(significant_bits(case.receiver.position[0]) <= 4, "{case:?}");
        assert_eq!(case.receiver.position[1..], [0.0, 0.0]);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        fn the_result_fails_and_is_no_larger_and_cannot_be_shrunk(family in prop::sample::select(Family::ALL.to_vec()), index in 0..100u64, limit in 0.0..2.0) {
            let start = Name { family, seed: 1, index }.case();
            let fails = |case: &Case| case.emitter.vertices.iter().flatten().any(|x| x.abs() > limit);
            prop_assume!(fails(&start));
            let case = shrink(&start, fails);
            prop_assert!(fails(&case));
            prop_assert!(weight(&case) <= weight(&start));
            prop_assert_eq!(shrink(&case, fails), case);
        }
    }
}
