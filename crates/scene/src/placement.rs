//! How a scene is moved and scaled before it is worked on.

use radgrad_core::DVec3;

/// How a scene was moved and scaled: `inward(x) = (x - centre) power`. Ordinary scenes stay as they are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    pub(crate) centre: DVec3,
    pub(crate) power: f64,
}

impl Default for Placement {
    /// Not at all.
    fn default() -> Self {
        Self { centre: DVec3::ZERO, power: 1.0 }
    }
}

impl Placement {
    /// Where a point of the scene is then.
    #[must_use]
    pub fn inward(&self, point: DVec3) -> DVec3 {
        (point - self.centre) * self.power
    }

    /// Where a point was in the scene.
    #[must_use]
    pub fn outward(&self, point: DVec3) -> DVec3 {
        point / self.power + self.centre
    }

    /// The power of two that multiplied lengths.
    #[must_use]
    pub const fn power(&self) -> f64 {
        self.power
    }
}
