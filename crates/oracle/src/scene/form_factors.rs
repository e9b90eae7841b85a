//! Form factors by rays, with an error that is chosen before the first is drawn.
//!
//! A ray leaves face i at a point uniform over it, by the cosine, and meets the front of face j before any other with probability
//! `F_ij`. So the part of n rays that does is off by more than `e` with a probability of at most `2 exp(-2 n e^2)`, whatever the
//! scene (W. Hoeffding 1963): `n = ln(2 / (1 - c)) / (2 e^2)` rays give each factor the error e with the confidence c. That the
//! number follows from error and confidence alone is the point of M. Pellegrini, "Monte Carlo approximation of form factors with
//! error bounded a priori" (Symposium on Computational Geometry, 1995). For m factors at once, each to have it, c is to be
//! `1 - (1 - c') / m`.
//!
//! The interval that comes back is H. Chernoff's, which is inside of that one always, and far narrower for small factors.

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

use super::{Known, Scene, sampling};
use crate::Error;
use crate::confidence::{check_confidence, of_successes};

/// Rays from a face that give each of its factors an error of at most `error` with this confidence.
///
/// ```
/// let rays = radgrad_oracle::scene::rays_for(0.01, 0.99)?;
/// assert_eq!(rays, 26_492); // ln(200) / 2e-4
/// # Ok::<(), radgrad_oracle::Error>(())
/// ```
///
/// # Errors
/// If error or confidence is not between 0 and 1, or so many rays cannot be counted.
pub fn rays_for(error: f64, confidence: f64) -> Result<u32, Error> {
    check_confidence(confidence)?;
    let rays = (libm::log(2.0 / (1.0 - confidence)) / (2.0 * error * error)).ceil();
    let can_be_drawn = error > 0.0 && error < 1.0 && rays <= f64::from(u32::MAX);
    if !can_be_drawn {
        return Err(Error::FactorError { value: error });
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a whole number from 0 to u32::MAX")]
    Ok(rays as u32)
}

impl Scene {
    /// The form factor from a face to each, with an error of at most `error` and this confidence for each of them.
    ///
    /// ```
    /// use radgrad_core::{DVec3, Polygon};
    /// use radgrad_oracle::scene::{Face, Scene};
    /// let face = |z: f64, up: bool| {
    ///     let mut corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, z));
    ///     if !up { corners.reverse() }
    ///     let polygon = Polygon::new(corners.to_vec())?;
    ///     Ok::<_, radgrad_core::Error>(Face { polygon, reflectance: 0.5, emitted: 0.0, exchanges: true, pattern: None })
    /// };
    /// let squares = Scene::new(vec![face(0.0, true)?, face(1.0, false)?])?;
    /// let factors = squares.form_factors(0, 0.01, 1, 0.999)?;
    /// assert!((factors[1].value - 0.199_824_895_698).abs() < 0.01); // Howell C-11
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`rays_for`], or if there is no such face.
    pub fn form_factors(&self, face: usize, error: f64, seed: u64, confidence: f64) -> Result<Vec<Known>, Error> {
        self.sights(face, rays_for(error, confidence)?, seed, confidence)
    }

    /// Form factors from a face: that to each face, by so many rays from it.
    ///
    /// # Errors
    /// If the confidence is not between 0 and 1, there is no such face, or no ray is allowed.
    pub fn sights(&self, face: usize, rays: u32, seed: u64, confidence: f64) -> Result<Vec<Known>, Error> {
        check_confidence(confidence)?;
        let count = self.faces.len();
        let triangles = self.triangles.get(face).ok_or(Error::NoFace { face, count })?;
        if rays == 0 {
            return Err(Error::TooFewSamples { what: "rays", value: 0, least: 1 });
        }
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(face as u64);
        let (normal, area) = (self.faces[face].polygon.normal(), self.areas[face]);
        let mut hits = vec![0_u32; count];
        for _ in 0..rays {
            let mut place = sampling::uniform(&mut generator) * area;
            let mut chosen = &triangles[0];
            for triangle in triangles {
                chosen = triangle;
                place -= sampling::area(triangle);
                if place < 0.0 {
                    break;
                }
            }
            let origin = sampling::on_triangle(chosen, &mut generator);
            let direction = sampling::by_cosine(normal, &mut generator);
            if let Some(hit) = self.caster.first(face, origin, direction).filter(|hit| hit.front) {
                hits[hit.face] += 1;
            }
        }
        let fraction =
            |hits: u32| Known { value: f64::from(hits) / f64::from(rays), interval: of_successes(hits, rays, confidence) };
        Ok(hits.into_iter().map(fraction).collect())
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use radgrad_core::Polygon;

    use super::*;
    use crate::scene::Face;

    /// Two unit squares at distance 1, and one of half the side in the middle.
    fn squares() -> Scene {
        let square = |low: f64, high: f64, z: f64, up: bool| {
            let mut corners = [(low, low), (high, low), (high, high), (low, high)].map(|(x, y)| DVec3::new(x, y, z));
            if !up {
                corners.reverse();
            }
            let polygon = Polygon::new(corners.to_vec()).unwrap();
            Face { polygon, reflectance: 0.5, emitted: 0.0, exchanges: true, pattern: None }
        };
        Scene::new(vec![square(0.0, 1.0, 0.0, true), square(0.0, 1.0, 1.0, false), square(0.25, 0.75, 0.5, true)]).unwrap()
    }

    #[test]
    fn the_error_asked_for_is_kept_as_often_as_asked() {
        let scene = squares();
        // The centred screen, by integrals of closed forms. Of 200 runs 20 may be off by more, and hardly any are: Hoeffding holds
        // whatever the factor.
        let (error, expected) = (0.02, 0.099_506_294_6);
        let deviation = |seed: u64| (scene.form_factors(0, error, seed, 0.9).unwrap()[1].value - expected).abs();
        let beyond = (0..200).filter(|&seed| deviation(seed) > error).count();
        assert!(beyond <= 20, "{beyond}");
        // The limits are narrower than requested, and hold as often.
        let within = (0..200).filter(|&seed| {
            let interval = scene.form_factors(0, error, seed, 0.9).unwrap()[1].interval;
            assert!(interval.width() <= 2.0 * error);
            interval.contains(expected)
        });
        assert!(within.count() >= 180);
    }

    #[test]
    fn what_cannot_be_asked_is_refused() {
        let scene = squares();
        for (error, confidence) in [(0.0, 0.9), (1.0, 0.9), (f64::NAN, 0.9), (1e-9, 0.9), (0.1, 1.0), (0.1, 0.0)] {
            assert!(scene.form_factors(0, error, 1, confidence).is_err(), "{error} {confidence}");
        }
        assert!(scene.form_factors(3, 0.1, 1, 0.9).is_err());
    }
}
