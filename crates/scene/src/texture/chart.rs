//! Texture coordinates on a face: an affine function of the position.
//!
//! Of a triangle with coordinates at its vertices there is one such function. The vertices of a larger polygon may be off it by
//! as much as files round: a millionth of a texture.

use radgrad_core::{DVec3, Polygon};

use super::Texture;
use crate::error::Error;
use crate::extremes::{largest, smallest};
use crate::placement::Placement;

/// How far a vertex' coordinates may be off the affine function, in units of the texture: six decimals of a file.
const ROUNDED: f64 = 1e-6;

/// Texels that a face may have, counted as often as they repeat: more are noise, and would take all memory.
const MOST_TEXELS: f64 = 16_777_216.0;

/// Columns and rows are counted from the texture's origin up to here: beyond, doubles do not tell points of one texel apart.
const FARTHEST_TEXEL: f64 = 1e12;

/// `u` and `v` at each point of a face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chart {
    origin: DVec3,
    at_origin: [f64; 2],
    gradients: [DVec3; 2],
}

impl Chart {
    /// The chart with these coordinates at the vertices of a polygon.
    ///
    /// # Errors
    /// If there is not one pair for each vertex, a coordinate is not finite, or no affine function has them.
    pub fn new(polygon: &Polygon, coordinates: &[[f64; 2]]) -> Result<Self, Error> {
        let vertices = polygon.vertices();
        if coordinates.len() != vertices.len() {
            return Err(Error::Count { what: "texture coordinates", found: coordinates.len(), expected: vertices.len() });
        }
        if let Some(vertex) = coordinates.iter().position(|uv| !(uv[0].is_finite() && uv[1].is_finite())) {
            let given = format!("{:?} at vertex {vertex}", coordinates[vertex]);
            return Err(Error::expected("finite texture coordinates", given));
        }
        // The triangle of the largest area at the first vertex decides, so that the others are inside or not far out.
        let origin = vertices[0];
        let across = |i: usize| (vertices[i] - origin).cross(vertices[i + 1] - origin).length_squared();
        let widest = (1..vertices.len() - 1).max_by(|&a, &b| across(a).total_cmp(&across(b))).unwrap_or(1);
        let (a, b) = (vertices[widest] - origin, vertices[widest + 1] - origin);
        let normal = a.cross(b);
        let dual = [b.cross(normal) / normal.length_squared(), normal.cross(a) / normal.length_squared()];
        let gradient = |k: usize| {
            let rise = |vertex: usize| coordinates[vertex][k] - coordinates[0][k];
            dual[0] * rise(widest) + dual[1] * rise(widest + 1)
        };
        let chart = Self { origin, at_origin: coordinates[0], gradients: [gradient(0), gradient(1)] };
        let difference = |(vertex, uv): (&DVec3, &[f64; 2])| {
            let here = chart.coordinates(*vertex);
            largest((here[0] - uv[0]).abs(), (here[1] - uv[1]).abs())
        };
        let (worst, error) = vertices
            .iter()
            .zip(coordinates)
            .map(difference)
            .enumerate()
            .fold((0, 0.0), |most, next| if next.1 > most.1 || next.1.is_nan() { next } else { most });
        if error <= ROUNDED { Ok(chart) } else { Err(Error::Chart { vertex: worst, off: error, allowed: ROUNDED }) }
    }

    /// The numbers that make it: origin, `u` and `v` there, and their gradients.
    pub(crate) fn numbers(self) -> [[f64; 3]; 4] {
        let [u, v] = self.at_origin;
        let [along, across] = self.gradients.map(|gradient| gradient.to_array());
        [self.origin.to_array(), [u, v, 0.0], along, across]
    }

    /// The chart that these numbers make.
    pub(crate) fn from_numbers([origin, [u, v, _], along, across]: [[f64; 3]; 4]) -> Self {
        Self { origin: origin.into(), at_origin: [u, v], gradients: [along.into(), across.into()] }
    }

    /// `u` and `v` at a point.
    #[must_use]
    pub fn coordinates(&self, point: DVec3) -> [f64; 2] {
        [0, 1].map(|k| self.at_origin[k] + self.gradients[k].dot(point - self.origin))
    }

    /// The same where the scene was moved and scaled.
    pub(crate) fn placed(&self, placement: &Placement) -> Self {
        let gradients = self.gradients.map(|gradient| gradient / placement.power());
        Self { origin: placement.inward(self.origin), gradients, ..*self }
    }

    /// Whether a texture has no more texels on the polygon than can be summed.
    pub(crate) fn check(&self, polygon: &Polygon, texture: &Texture) -> Result<(), Error> {
        let extent = |k: usize| {
            let texels = polygon.vertices().iter().map(|&v| self.coordinates(v)[k] * texture.size()[k] as f64);
            texels.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], c| [smallest(low, c), largest(high, c)])
        };
        let extents = [extent(0), extent(1)];
        let far = extents.as_flattened().iter().map(|end| end.abs()).fold(0.0, largest);
        // NaN is not near either.
        if far.is_nan() || far > FARTHEST_TEXEL {
            let rule = format!("a face has it {far:.3e} texels from its origin: at most {FARTHEST_TEXEL:e} are told apart");
            return Err(Error::Texture { texture: texture.name().to_owned(), rule });
        }
        let texels: f64 = extents.iter().map(|[low, high]| high - low + 1.0).product();
        if texels <= MOST_TEXELS {
            return Ok(());
        }
        let rule =
            format!("it has {texels:.3e} texels on one face: at most {MOST_TEXELS:e} are summed, so let it repeat less often");
        Err(Error::Texture { texture: texture.name().to_owned(), rule })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(points: &[[f64; 3]]) -> Polygon {
        Polygon::new(points.iter().map(|&p| p.into()).collect()).unwrap()
    }

    #[test]
    fn coordinates_at_the_vertices_are_those_given() {
        let tilted = polygon(&[[0.0, 0.0, 1.0], [2.0, 0.0, 2.0], [2.0, 1.0, 2.0], [0.0, 1.0, 1.0]]);
        let given = [[0.25, 0.5], [1.25, 0.5], [1.5, 2.5], [0.5, 2.5]];
        let chart = Chart::new(&tilted, &given).unwrap();
        for (vertex, given) in tilted.vertices().iter().zip(given) {
            let computed = chart.coordinates(*vertex);
            assert!((computed[0] - given[0]).abs() + (computed[1] - given[1]).abs() < 1e-14, "{computed:?} {given:?}");
        }
        let error = Chart::new(&tilted, &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.5]]).unwrap_err();
        assert!(matches!(error, Error::Chart { .. }), "{error}");
        assert!(matches!(Chart::new(&tilted, &given[..3]), Err(Error::Count { found: 3, expected: 4, .. })));
    }

    #[test]
    fn a_texture_that_repeats_without_end_is_refused() {
        let square = polygon(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
        let texture = Texture::new("dots", [64, 64], 1, vec![0.5; 64 * 64]).unwrap();
        let chart = |times: f64| Chart::new(&square, &[[0.0, 0.0], [times, 0.0], [times, times], [0.0, times]]).unwrap();
        assert!(chart(10.0).check(&square, &texture).is_ok());
        assert!(chart(1e6).check(&square, &texture).unwrap_err().to_string().contains("texels on one face"));
    }
}
