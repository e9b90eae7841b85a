//! What a projection leaves out of light that is smooth, from more places than its nodes.
//!
//! | symbol | meaning |
//! |---|---|
//! | `S` | the irradiance of sources that are wholly seen from all of an element |
//! | `P S`, `r` | its projection from the element's nodes, and `S - P S` |
//! | `Q` | interpolation by Legendre polynomials of degree n in s and in t at `(n + 1)^2` Gauss nodes |
//! | `q` | what Taylor's polynomial of degree n leaves of S: module [`super`], by sources |
//! | `d` | bound on the errors of the evaluations at the nodes of Q |
//!
//! `Q p = p` for polynomials p of degree n, and so for P S. Taylor's polynomial p of S has `S - Q S = (S - p) - Q (S - p)`; and
//! `r = Q r + (S - Q S)`.
//!
//! The nodes' rule is exact for the square of what Q gives, so that the root mean square of `Q g` is that of g at the nodes: in the mean
//! `|r|` is at most that of r at the nodes, and `2 q + d` more. As for all p of that degree
//! `|p(x)|^2 <= sum_k (2k + 1) sum_l (2l + 1) mean p^2 = (n + 1)^4 mean p^2`, `|Q g|` is at most `(n + 1)^2` times the largest `|g|` at
//! the nodes, so that `|r|` is at most the sum of the magnitudes of the Legendre series of Q r, and `q + (n + 1)^2 (q + d)` more.
//! Sources count together, with their signs; q and d add up. The part of r along the polynomials of P is that of Q r, which the rule of the
//! nodes gives exactly, and in the mean square `2 q + d` more.

use radgrad_core::mutant;
use radgrad_scene::{gauss_legendre, largest};

use super::left::{Gathered, Kind, Left, Light, Proof};
use super::nodes::ROUNDED;
use super::terms::Target;
use crate::links::station::Station;
use crate::mesh::Sight;
use crate::mesh::shape::Shape;

/// Degrees that are tried.
const DEGREES: [usize; 4] = [3, 5, 7, 11];

/// Share of the residual at the nodes up to which the rest of Taylor's series may go; above it a higher degree is tried.
const PART: f64 = 0.01;

/// Sources that count together: which do, and their residual in each channel.
#[derive(Debug, Default)]
pub(super) struct Finely {
    pub(super) takes: Vec<bool>,
    pub(super) left: Vec<Left>,
    /// For each channel, the root mean square of the residual's part along the element's polynomials.
    pub(super) along: Vec<f64>,
}

impl Proof<'_> {
    /// The residual of the sources that count for less together than each by itself; `alone` is the mean residual of a source by
    /// itself, summed over the channels.
    pub(super) fn finely(
        &self,
        to: usize,
        target: &Target<'_>,
        light: &Light<'_>,
        gathered: &Gathered<'_>,
        kinds: &[Kind],
        alone: &dyn Fn(usize) -> f64,
    ) -> Finely {
        let (element, basis) = (&self.mesh.elements()[to], self.mesh.basis(to));
        let none = Finely { takes: vec![false; kinds.len()], ..Finely::default() };
        let highest = DEGREES[DEGREES.len() - 1];
        if element.shape() != Shape::Parallelogram || basis.degree() > DEGREES[0] {
            return none;
        }
        let coefficients =
            |source: usize| -> Vec<Vec<f64>> { (0..self.channels).map(|channel| light.of(self.mesh, source, channel)).collect() };
        let beyond = |source: usize, degree: usize| -> Vec<f64> {
            let of = |held: &Vec<f64>| self.smooth(target, source, &self.polynomial(source, held), degree);
            coefficients(source).iter().map(of).collect()
        };
        let takes: Vec<bool> = (gathered.sources.iter().zip(kinds).enumerate())
            .map(|(index, ((source, _), kind))| {
                let by_itself = || 2.0 * beyond(*source, highest).iter().sum::<f64>();
                *kind == Kind::Clear && self.in_front(target, *source) && 2.0 * by_itself() < alone(index)
            })
            .collect();
        let taken: Vec<usize> =
            gathered.sources.iter().zip(&takes).filter(|(_, takes)| **takes).map(|((source, _), _)| *source).collect();
        if taken.is_empty() {
            return none;
        }
        // What their projection is off at the nodes that it is made of.
        let held: Vec<Vec<f64>> = (0..self.channels)
            .map(|channel| {
                let mut at_nodes = vec![0.0; basis.nodes().len()];
                for (index, (source, _)) in gathered.sources.iter().enumerate().filter(|(index, _)| takes[*index]) {
                    let held = light.of(self.mesh, *source, channel);
                    at_nodes.iter_mut().enumerate().for_each(|(node, sum)| *sum += (gathered.value)(index, node, &held));
                }
                let held = basis.project(&at_nodes);
                let off = |node: usize| at_nodes[node] - basis.at_node(node).iter().zip(&held).map(|(f, c)| f * c).sum::<f64>();
                let most = (0..at_nodes.len()).map(|node| off(node).abs()).fold(0.0, largest);
                held.into_iter().chain([most]).collect()
            })
            .collect();
        let left_by = |degree: usize| -> Vec<f64> {
            let mut sums = vec![0.0; self.channels];
            taken.iter().for_each(|&source| sums.iter_mut().zip(beyond(source, degree)).for_each(|(sum, of)| *sum += of));
            sums
        };
        let enough = |degree: &usize| left_by(*degree).iter().zip(&held).all(|(left, held)| *left <= PART * held[basis.len()]);
        let degree = DEGREES.into_iter().find(enough).unwrap_or(highest);
        let beyond = left_by(degree);

        let sources: Vec<(usize, Vec<Vec<f64>>)> = taken.iter().map(|&source| (source, coefficients(source))).collect();
        let rule: Vec<(f64, f64)> = gauss_legendre(degree + 1).iter().map(|(x, weight)| (0.5 + 0.5 * x, 0.5 * weight)).collect();
        let mut off = vec![vec![0.0; rule.len() * rule.len()]; self.channels];
        let mut error = vec![0.0_f64; self.channels];
        let mut size = vec![0.0_f64; self.channels];
        let mut along = vec![vec![0.0_f64; basis.len()]; self.channels];
        for (a, (s, weight_s)) in rule.iter().enumerate() {
            for (b, (t, weight_t)) in rule.iter().enumerate() {
                let station = Station::on(element, element.point([*s, *t]));
                let values = basis.values([*s, *t]);
                let (mut errors, mut sums, mut sizes) =
                    (vec![0.0; self.channels], vec![0.0; self.channels], vec![0.0; self.channels]);
                for (source, held) in &sources {
                    let Ok(row) = self.optics.receive(&station, *source, &Sight::Clear, held[0].len()) else { return none };
                    for (channel, held) in held.iter().enumerate() {
                        sums[channel] += row.values.iter().zip(held).map(|(v, c)| v * c).sum::<f64>();
                        sizes[channel] += row.values.iter().zip(held).map(|(v, c)| (v * c).abs()).sum::<f64>();
                        errors[channel] += row.error_of(held);
                    }
                }
                for channel in 0..self.channels {
                    let polynomial: f64 = held[channel].iter().zip(&values).map(|(c, v)| c * v).sum();
                    let left = sums[channel] - polynomial;
                    off[channel][a * rule.len() + b] = left;
                    along[channel].iter_mut().zip(&values).for_each(|(sum, value)| *sum += weight_s * weight_t * left * value);
                    error[channel] = largest(error[channel], errors[channel]);
                    size[channel] = largest(size[channel], sizes[channel]);
                }
            }
        }
        let places = (rule.len() * rule.len()) as f64;
        let of_channel = |channel: usize| {
            let off = &off[channel];
            let weight = |place: usize| rule[place / rule.len()].1 * rule[place % rule.len()].1;
            let rms = off.iter().enumerate().map(|(place, off)| weight(place) * off * off).sum::<f64>().sqrt();
            // Sums, and the polynomial's values, round.
            let error = error[channel] + 1e-13 * size[channel];
            let beyond = beyond[channel];
            let mean = rms + 2.0 * beyond + error;
            let most = legendre_sum(&rule, off) + beyond + places * (beyond + error);
            let held = along[channel].iter().map(|c| c.powi(2)).sum::<f64>().sqrt();
            (
                Left { largest: most * ROUNDED, mean: mean * ROUNDED },
                mutant!("solver.along-finely", (held + 2.0 * beyond + error) * ROUNDED, |_| 0.0),
            )
        };
        let (left, along) = (0..self.channels).map(of_channel).unzip();
        Finely { takes, left, along }
    }
}

/// The sum of the magnitudes of the Legendre series of what has these values at the nodes of a rule's square.
fn legendre_sum(rule: &[(f64, f64)], values: &[f64]) -> f64 {
    let count = rule.len();
    // For each place the polynomials of degree 0, 1 and so on, of a mean square of 1; at the ends they are the largest.
    let at: Vec<Vec<f64>> = rule
        .iter()
        .map(|(s, _)| {
            let x = 2.0 * s - 1.0;
            let mut of = vec![1.0, x];
            for k in 1..count {
                let k_f = k as f64;
                of.push(((2.0 * k_f + 1.0) * x * of[k] - k_f * of[k - 1]) / (k_f + 1.0));
            }
            of.iter().enumerate().take(count).map(|(k, p)| p * ((2 * k + 1) as f64).sqrt()).collect()
        })
        .collect();
    let most = |k: usize| ((2 * k + 1) as f64).sqrt();
    let along = |row: &[f64], k: usize| row.iter().enumerate().map(|(b, v)| rule[b].1 * at[b][k] * v).sum::<f64>();
    let rows: Vec<Vec<f64>> = values.chunks_exact(count).map(|row| (0..count).map(|k| along(row, k)).collect()).collect();
    let of = |j: usize, k: usize| (0..count).map(|a| rule[a].1 * at[a][j] * rows[a][k]).sum::<f64>();
    (0..count).flat_map(|j| (0..count).map(move |k| (j, k))).map(|(j, k)| of(j, k).abs() * most(j) * most(k)).sum()
}
