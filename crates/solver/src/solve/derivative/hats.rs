//! Hats of a face's vertices: how much of a vertex's motion a place of the face takes part in.
//!
//! Along an edge they are those of its ends. Within, they sum to 1 and reproduce all affine motions: mean value coordinates (M. Floater
//! 2003). Out of its plane a face moves affinely, as it stays flat: there the hats are the affine ones that come nearest, by least squares.

use radgrad_core::{DVec3, Polygon};

/// Places are on an edge if they are within this part of its length.
const ON_EDGE: f64 = 1e-9;

/// The outline of a face.
pub(super) struct Outline {
    corners: Vec<DVec3>,
    normal: DVec3,
    middle: DVec3,
    /// The slopes of the affine hats.
    slopes: Vec<DVec3>,
}

/// The hats of the ends of an edge at a part of its length, in an outline of so many vertices.
pub(super) fn on_edge(edge: usize, along: f64, count: usize) -> [(usize, f64); 2] {
    [(edge, 1.0 - along), ((edge + 1) % count, along)]
}

impl Outline {
    pub(super) fn from_polygon(polygon: &Polygon) -> Self {
        let (corners, normal) = (polygon.vertices().to_vec(), polygon.normal());
        let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
        let u = normal.any_orthonormal_vector();
        let v = normal.cross(u);
        let arms: Vec<[f64; 2]> = corners.iter().map(|corner| [(*corner - middle).dot(u), (*corner - middle).dot(v)]).collect();
        let moment = |a: usize, b: usize| arms.iter().map(|arm| arm[a] * arm[b]).sum::<f64>();
        let (uu, uv, vv) = (moment(0, 0), moment(0, 1), moment(1, 1));
        // A polygon has area, so that its corners are not on a line.
        let determinant = uu * vv - uv * uv;
        let slope = |[a, b]: &[f64; 2]| (u * (vv * a - uv * b) + v * (uu * b - uv * a)) / determinant;
        let slopes = arms.iter().map(slope).collect();
        Self { corners, normal, middle, slopes }
    }

    pub(super) const fn len(&self) -> usize {
        self.corners.len()
    }

    /// The affine hats at a place, and their slopes.
    pub(super) fn plane_hats(&self, place: DVec3) -> impl Iterator<Item = (f64, DVec3)> {
        let even = 1.0 / self.corners.len() as f64;
        self.slopes.iter().map(move |slope| (even + slope.dot(place - self.middle), *slope))
    }

    /// The hats at a place of the face.
    pub(super) fn hats(&self, place: DVec3) -> Vec<f64> {
        let count = self.corners.len();
        let arms: Vec<DVec3> = self.corners.iter().map(|corner| *corner - place).collect();
        let mut hats = vec![0.0; count];
        for (edge, arm) in arms.iter().enumerate() {
            let side = self.corners[(edge + 1) % count] - self.corners[edge];
            let along = -arm.dot(side) / side.length_squared();
            if (-ON_EDGE..=1.0 + ON_EDGE).contains(&along) && (*arm + side * along).length() <= ON_EDGE * side.length() {
                on_edge(edge, along.clamp(0.0, 1.0), count).into_iter().for_each(|(vertex, hat)| hats[vertex] += hat);
                return hats;
            }
        }
        // The tangent of half the angle under which an edge is seen.
        let half = |edge: usize| {
            let [a, b] = [arms[edge], arms[(edge + 1) % count]];
            let (sine, cosine) = (self.normal.dot(a.cross(b)), a.dot(b));
            (0.5 * sine.atan2(cosine)).tan()
        };
        let halves: Vec<f64> = (0..count).map(half).collect();
        for (vertex, hat) in hats.iter_mut().enumerate() {
            *hat = (halves[(vertex + count - 1) % count] + halves[vertex]) / arms[vertex].length();
        }
        let sum: f64 = hats.iter().sum();
        hats.iter_mut().for_each(|hat| *hat /= sum);
        hats
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hats_reproduce_affine_motions_and_are_linear_along_edges() {
        let tilted = |[x, y]: [f64; 2]| DVec3::new(x, y, 1.0 + 0.3 * x - 0.2 * y);
        let outline = [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]].map(tilted);
        let outline = Outline::from_polygon(&Polygon::new(outline.to_vec()).unwrap());
        for place in [[0.5, 0.5], [2.5, 0.25], [0.2, 2.9], [1.0, 1.0], [3.0, 0.5], [1.5, 1.0]].map(tilted) {
            let hats = outline.hats(place);
            let again: DVec3 = outline.corners.iter().zip(&hats).map(|(corner, hat)| *corner * *hat).sum();
            assert!((hats.iter().sum::<f64>() - 1.0).abs() < 1e-12 && (again - place).length() < 1e-12, "{place} {hats:?}");
            let affine: DVec3 =
                outline.corners.iter().zip(outline.plane_hats(place)).map(|(corner, (hat, _))| *corner * hat).sum();
            assert!((affine - place).length() < 1e-12);
        }
        let half = outline.hats(tilted([3.0, 0.5]));
        assert!((half[1] - 0.5).abs() < 1e-12 && (half[2] - 0.5).abs() < 1e-12);
    }
}
