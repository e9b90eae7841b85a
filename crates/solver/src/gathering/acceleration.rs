//! Sweeps that go on where light is hardly lost.
//!
//! There one mode is left after some sweeps, nearly the same light everywhere, and each change is the one before times a number r
//! a little below 1. All changes to come sum to the last one times `r/(1 - r)`, and are added at once (L. A. Lyusternik 1947), if
//! the other modes in two changes, which count with `1/(1 - r)` too, are a small part of that. The sweeps after it mend the
//! remainder.

use crate::field::Field;
use crate::gathering::Equation;

/// The least r from which on changes are added before their time, and the largest: beyond that a sweep loses less than the error
/// of links, and its ratio has no significant digit.
const SLOW: f64 = 0.9;
const SLOWEST: f64 = 0.9995;

/// The part of the extrapolation that may be another mode's.
const OTHER: f64 = 0.1;

/// Coefficients of receivers after sweeps, and their change by the last one, channel after channel.
#[derive(Debug, Default)]
struct Acceleration {
    held: Option<Vec<Vec<f64>>>,
    change: Option<Vec<Vec<f64>>>,
}

impl Acceleration {
    /// After each sweep: adds the changes to come in the channels in which they are known.
    fn after_sweep(&mut self, equation: &Equation<'_>, field: &mut Field, own: &mut [Vec<f64>], channels: usize) {
        let held = self.held.replace(of_channels(equation, own, channels));
        let (Some(before), Some(now)) = (held, &self.held) else { return };
        let difference =
            |(now, before): (&Vec<f64>, &Vec<f64>)| now.iter().zip(before).map(|(now, before)| now - before).collect();
        let change: Vec<Vec<f64>> = now.iter().zip(&before).map(difference).collect();
        let Some(last) = self.change.replace(change.clone()) else { return };
        let factors: Vec<f64> = change.iter().zip(&last).map(|(change, last)| factor(change, last)).collect();
        if factors.iter().all(|factor| *factor == 0.0) {
            return;
        }
        for (channel, (factor, change)) in factors.iter().zip(&change).enumerate().filter(|(_, (factor, _))| **factor > 0.0) {
            let mut unread = &change[..];
            for &receiver in equation.receivers {
                let (of_receiver, after) = unread.split_at(equation.mesh.basis(receiver).len());
                unread = after;
                let more: Vec<f64> = of_receiver.iter().map(|change| factor * change).collect();
                let start = channel * more.len();
                own[receiver][start..start + more.len()].iter_mut().zip(&more).for_each(|(own, more)| *own += more);
                field.add(equation.mesh, receiver, channel, &more);
            }
        }
        *self = Self::default();
    }
}

impl Equation<'_> {
    /// Sweeps until a sweep changes no coefficient by more than a part of its channel's scale, which is found anew after each, or as often as
    /// may be. Returns the number of sweeps and the last change.
    pub(crate) fn solve(
        &self,
        (field, own): (&mut Field, &mut [Vec<f64>]),
        (until, most_sweeps): (f64, usize),
        mut scale: Vec<f64>,
        mut scaled: impl FnMut(&Field, &mut [f64]),
    ) -> (usize, f64) {
        let (mut acceleration, mut change) = (Acceleration::default(), f64::INFINITY);
        for sweep in 1..=most_sweeps {
            change = self.sweep(field, own, &scale);
            if change <= until || change.is_nan() {
                return (sweep, change);
            }
            acceleration.after_sweep(self, field, own, scale.len());
            scaled(field, &mut scale);
        }
        (most_sweeps, change)
    }
}

/// Coefficients of the receivers in each channel.
fn of_channels(equation: &Equation<'_>, own: &[Vec<f64>], channels: usize) -> Vec<Vec<f64>> {
    let in_channel = |channel: usize| {
        let of_receiver = |&receiver: &usize| {
            let len = equation.mesh.basis(receiver).len();
            own[receiver][channel * len..(channel + 1) * len].iter().copied()
        };
        equation.receivers.iter().flat_map(of_receiver).collect()
    };
    (0..channels).map(in_channel).collect()
}

/// The sum of the changes to come over this one, or 0 where it is not known.
fn factor(change: &[f64], last: &[f64]) -> f64 {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let r = dot(change, last) / dot(last, last);
    if !(SLOW..=SLOWEST).contains(&r) {
        return 0.0;
    }
    let other: f64 = change.iter().zip(last).map(|(change, last)| (change - r * last).powi(2)).sum();
    if other.sqrt() <= OTHER * (1.0 - r) * dot(change, change).sqrt() { r / (1.0 - r) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::factor;

    #[test]
    fn what_is_to_come_is_known_of_one_slow_mode_alone() {
        let last = [1.0, 2.0, -1.0];
        let times = |r: f64| last.map(|c| r * c);
        assert!((factor(&times(0.99), &last) - 99.0).abs() < 1e-9);
        // Fast, not falling, another mode beside it, nothing at all.
        assert_eq!(
            [times(0.5), times(1.0), times(1.1), [0.99, 1.98, -0.97], [f64::NAN; 3]].map(|change| factor(&change, &last)),
            [0.0; 5]
        );
        assert_eq!(factor(&[0.0; 3], &[0.0; 3]), 0.0);
    }
}
