//! Random walks, and the contribution of each.
//!
//! A walk carries a weight for each channel. Where it arrives the weights are multiplied by the reflectance there, and the products
//! are reflected light. After that it goes on with probability [`Walks::survival`], whatever its weight, and weights are divided
//! by that: the sum over all arrivals has the same expectation whatever the survival is, and if its square is above the largest
//! weight after two reflections, a range that is known before the first draw. A walk whose weights are so small that all that it
//! may still add is below [`Walks::cut`] ends, and the cut is added to the upper limit. Where light comes to the same wherever it
//! goes, a survival of 1 leaves no variance.

use std::f64::consts::PI;

use radgrad_core::DVec3;
use radgrad_scene::largest;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;

use crate::model::{Hit, Model};

/// The rules of all walks.
#[derive(Debug, Clone)]
pub(crate) struct Walks<'a> {
    pub(crate) model: &'a Model<'a>,
    /// The probability with which a walk goes on after each reflection.
    pub(crate) survival: f64,
    /// Bounds in each channel on the sum of the weights that a walk of weight 1 reflects: at all its reflections, and at those after
    /// the first.
    pub(crate) weight_limits: Vec<f64>,
    pub(crate) more: Vec<f64>,
    /// Bound in each channel on the truncation of a walk that ends.
    pub(crate) cut: Vec<f64>,
}

/// The sums over the reflections of a walk.
#[derive(Debug, Clone, Default)]
pub(crate) struct Tally {
    /// The sum in each channel.
    pub(crate) sums: Vec<f64>,
    /// Rays so far.
    pub(crate) rays: u64,
    /// The reflected weights so far, surface by surface and channel by channel.
    pub(crate) surfaces: Vec<f64>,
}

impl<'a> Walks<'a> {
    /// Walks of a range that is about twice as wide as without an end, and that are about as long.
    pub(crate) fn ending(model: &'a Model<'a>) -> Self {
        let bounds = model.largest_reflectances();
        let double = bounds.iter().map(|[_, double]| *double).fold(0.0, largest);
        Self::new(model, &bounds, double.min(WHITEST).powf(0.25))
    }

    /// Walks that take the light of lamps where they meet them, and so go on after a reflection on the only face that reflects.
    pub(crate) fn meeting(model: &'a Model<'a>) -> Self {
        let bounds = model.largest_reflectances();
        let single = bounds.iter().map(|[single, _]| *single).fold(0.0, largest);
        Self::new(model, &bounds, (single * single).min(WHITEST).powf(0.25))
    }

    /// The same walks until little is left of their weights, if they come to that.
    pub(crate) fn persistent(&self) -> Option<Self> {
        let walks = Self::new(self.model, &self.model.largest_reflectances(), 1.0);
        walks.more.iter().all(|more| more.is_finite()).then_some(walks)
    }

    fn new(model: &'a Model<'a>, bounds: &[[f64; 2]], survival: f64) -> Self {
        let weight_limits: Vec<f64> = bounds.iter().map(|[single, double]| series(*single, *double, survival)).collect();
        let more = weight_limits.iter().map(|limit| if *limit == 0.0 { 0.0 } else { limit / survival }).collect();
        Self { model, survival, weight_limits, more, cut: vec![0.0; model.channels] }
    }

    /// Adds the reflected part of light that arrives on a face, and all its further reflections.
    pub(crate) fn arrive(&self, (mut face, mut point): Hit, weights: &mut [f64], generator: &mut ChaCha8Rng, tally: &mut Tally) {
        loop {
            self.model.reflect(face, point, weights);
            let surface = self.model.faces[face].surface * self.model.channels;
            for (channel, weight) in weights.iter().enumerate() {
                tally.sums[channel] += weight;
                tally.surfaces[surface + channel] += weight;
            }
            match self.go_on(face, point, weights, generator, &mut tally.rays) {
                Some(hit) => (face, point) = hit,
                None => return,
            }
        }
    }

    /// Where a walk goes after a reflection, if it does.
    pub(crate) fn go_on(
        &self,
        face: usize,
        point: DVec3,
        weights: &mut [f64],
        generator: &mut ChaCha8Rng,
        rays: &mut u64,
    ) -> Option<Hit> {
        let is_little = |((weight, more), cut): ((&f64, &f64), &f64)| *weight == 0.0 || weight * more <= *cut;
        if weights.iter().zip(&self.more).zip(&self.cut).all(is_little) || generator.random::<f64>() >= self.survival {
            return None;
        }
        weights.iter_mut().for_each(|weight| *weight /= self.survival);
        *rays += 1;
        self.model.hit(Some(face), point, by_cosine(self.model.faces[face].normal, generator))
    }
}

/// The product of the reflectances of two faces that see each other above which survival does not rise: walks are then 10,000 reflections long.
const WHITEST: f64 = 0.9996;

/// Bound on the sum of the weights after each reflection, where one leaves at most `single` and two at most `double`.
fn series(single: f64, double: f64, survival: f64) -> f64 {
    let pair = double / (survival * survival);
    if double == 0.0 {
        single
    } else if pair < 1.0 {
        (single + double / survival) / (1.0 - pair)
    } else {
        f64::INFINITY
    }
}

/// A direction with the density `cos / pi` around a unit normal: a uniform point of the disk, raised to the hemisphere.
pub(crate) fn by_cosine(normal: DVec3, generator: &mut ChaCha8Rng) -> DVec3 {
    let radius = generator.random::<f64>();
    let (sin, cos) = (2.0 * PI * generator.random::<f64>()).sin_cos();
    let [tangent, other] = tangents(normal);
    (tangent * cos + other * sin) * radius.sqrt() + normal * (1.0 - radius).sqrt()
}

/// Two unit vectors that make a right-handed frame with a unit normal (T. Duff et al., JCGT 2017).
fn tangents(normal: DVec3) -> [DVec3; 2] {
    let sign = 1.0_f64.copysign(normal.z);
    let a = -1.0 / (sign + normal.z);
    let b = normal.x * normal.y * a;
    [
        DVec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
        DVec3::new(b, sign + normal.y * normal.y * a, -normal.y),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn directions_have_the_density_of_the_cosine() {
        let mut generator = ChaCha8Rng::seed_from_u64(1);
        let normal = DVec3::new(0.48, -0.6, 0.64);
        let [tangent, _] = tangents(normal);
        let (mut first, mut second, mut side) = (0.0, 0.0, 0.0);
        let count = 40_000;
        for _ in 0..count {
            let direction = by_cosine(normal, &mut generator);
            let [cos, along] = [normal, tangent].map(|axis| axis.dot(direction));
            assert!(cos >= 0.0 && (direction.length() - 1.0).abs() < 1e-14);
            (first, second, side) = (first + cos, second + cos * cos, side + along * along);
        }
        // Means 2/3, 1/2 and 1/4; five standard deviations are at most 0.008.
        let [first, second, side] = [first, second, side].map(|sum| sum / f64::from(count));
        assert!(
            (first - 2.0 / 3.0).abs() < 0.008 && (second - 0.5).abs() < 0.008 && (side - 0.25).abs() < 0.008,
            "{first} {second} {side}"
        );
    }
}
