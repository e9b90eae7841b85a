//! A pinhole camera.

use radgrad_core::DVec3;

/// Its place and direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Camera {
    pub(super) eye: DVec3,
    forward: DVec3,
    /// To the right and upward, as long as half the picture's height is seen at distance 1.
    right: DVec3,
    up: DVec3,
}

impl Camera {
    /// From ten numbers: eye, target, up, and the vertical field of view in degrees.
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        let words = text.split(|c: char| c.is_whitespace() || c == ',').filter(|word| !word.is_empty());
        let number =
            |word: &str| word.parse::<f64>().ok().filter(|n| n.is_finite()).ok_or_else(|| format!("`{word}` is no number"));
        let numbers = words.map(number).collect::<Result<Vec<f64>, String>>()?;
        let [a, b, c, d, e, f, g, h, i, degrees] = numbers[..] else {
            return Err(format!("{} numbers: expected ten, eye, target, up and field of view", numbers.len()));
        };
        let (eye, target, up) = (DVec3::new(a, b, c), DVec3::new(d, e, f), DVec3::new(g, h, i));
        if !(degrees > 0.0 && degrees < 180.0) {
            return Err(format!("the field of view is {degrees}: it must be above 0 and below 180 degrees"));
        }
        let forward = (target - eye).try_normalize().ok_or_else(|| format!("eye and target are both at {eye}"))?;
        let right = forward.cross(up).try_normalize().ok_or_else(|| format!("{up} is no upward direction for that view"))?;
        let half = (0.5 * degrees).to_radians().tan();
        Ok(Self { eye, forward, right: right * half, up: right.cross(forward) * half })
    }

    /// The direction through a place of a pixel, counted from the upper left one; the place from its upper left corner.
    pub(super) fn direction(&self, [column, row]: [usize; 2], [x, y]: [f64; 2], [width, height]: [usize; 2]) -> DVec3 {
        let half = 0.5 * height as f64;
        let across = (column as f64 + x - 0.5 * width as f64) / half;
        let upward = (half - row as f64 - y) / half;
        self.forward + self.right * across + self.up * upward
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_is_the_target_and_the_edge_half_the_field_of_view() {
        let camera = Camera::parse("0 0 0, 0 0 -2, 0 1 0, 90").unwrap();
        assert!((camera.direction([1, 1], [0.5; 2], [3, 3]) - DVec3::new(0.0, 0.0, -1.0)).length() < 1e-15);
        let corner = camera.direction([0, 0], [0.5; 2], [3, 3]);
        assert!((corner - DVec3::new(-2.0 / 3.0, 2.0 / 3.0, -1.0)).length() < 1e-15, "{corner}");
    }

    #[test]
    fn a_camera_that_sees_nothing_is_refused_with_the_reason() {
        for (text, reason) in [
            ("1 2 3", "3 numbers"),
            ("0 0 0 0 0 0 0 1 0 40", "eye and target"),
            ("0 0 0 0 1 0 0 1 0 40", "no upward direction"),
            ("0 0 0 0 0 1 0 1 0 180", "field of view is 180"),
            ("0 0 0 0 0 1 0 1 0 x", "`x` is no number"),
        ] {
            let error = Camera::parse(text).unwrap_err();
            assert!(error.contains(reason), "{text}: {error}");
        }
    }
}
