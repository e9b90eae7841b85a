//! A polygon as a fan of signed triangles around a vertex: the quantities that do not depend on the receiver, computed once.

use glam::DVec3;
use radgrad_numbers::number::ROUNDOFF;
use radgrad_numbers::vec3::Vec3;

/// A triangle `P + a (e1 + b e)` of the fan, e the side opposite the apex P, in some unit of length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Shape {
    /// `e1` and `e`.
    pub(crate) first: Vec3<f64>,
    pub(crate) side: Vec3<f64>,
    /// Of `e1`, `e1 + e` and e.
    pub(crate) lengths: [f64; 3],
    /// Signed, and a bound on its error.
    pub(crate) twice_area: f64,
    pub(crate) twice_area_error: f64,
    /// Bounds on the errors of `e1` and e together, and on the area by which displaced corners change the domain.
    pub(crate) sides_error: f64,
    pub(crate) misplaced_area: f64,
}

/// A triangle of a whole polygon's fan, in lengths times the polygon's power of two.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FanTriangle {
    /// Vertices, the apex first.
    pub(crate) corners: [usize; 3],
    pub(crate) shape: Shape,
    /// Offset of the centroid from the apex, and a bound on the distance of a corner from the centroid: to 8u of the longest side.
    pub(crate) middle: Vec3<f64>,
    pub(crate) reach: f64,
}

impl Shape {
    /// The triangle with the sides e1, `e1 + e` and e, each with an error of at most `side_error`, of a polygon with the normal n2.
    pub(crate) fn new([first, last, side]: [Vec3<f64>; 3], lengths: [f64; 3], n2: Vec3<f64>, side_error: f64) -> Self {
        let rounding = side_error * (lengths[0] + lengths[1]) + 12.0 * ROUNDOFF * lengths[0] * lengths[1];
        Self {
            first,
            side,
            lengths,
            twice_area: n2.dot(first.cross(last)),
            twice_area_error: rounding,
            sides_error: 2.0 * side_error,
            misplaced_area: 0.0,
        }
    }

    /// After all lengths were multiplied by a power of two.
    #[inline]
    pub(crate) fn scaled(&self, power: f64) -> Self {
        let square = power * power;
        Self {
            first: self.first * power,
            side: self.side * power,
            lengths: self.lengths.map(|length| length * power),
            twice_area: self.twice_area * square,
            twice_area_error: self.twice_area_error * square,
            sides_error: self.sides_error * power,
            misplaced_area: self.misplaced_area * square,
        }
    }
}

impl FanTriangle {
    /// The fan of a polygon with normal n2 whose normal errs by `normal_error`, in lengths times `power`; of a triangle, around
    /// the vertex opposite its shortest side, and with its area, known to that error and a rounding.
    pub(crate) fn triangulate(vertices: &[DVec3], n2: Vec3<f64>, power: f64, area: f64, normal_error: f64) -> Vec<Self> {
        let from_to = |i: usize, j: usize| Vec3::from(vertices[j] - vertices[i]) * power;
        if let [_, _, _] = vertices {
            let sides = [(0, 1), (1, 2), (2, 0)].map(|(i, j)| from_to(i, j).norm_squared());
            let mut whole = Self::new(apex_first([0, 1, 2], sides), n2, from_to);
            whole.shape.twice_area = 2.0 * area;
            whole.shape.twice_area_error = (1.1 * ROUNDOFF + normal_error) * 2.0 * area;
            return vec![whole];
        }
        (1..vertices.len() - 1).map(|i| Self::new([0, i, i + 1], n2, from_to)).collect()
    }

    fn new([a, b, c]: [usize; 3], n2: Vec3<f64>, from_to: impl Fn(usize, usize) -> Vec3<f64>) -> Self {
        let [first, last, side] = [from_to(a, b), from_to(a, c), from_to(b, c)];
        let lengths = [first, last, side].map(Vec3::norm);
        let longest = lengths.into_iter().fold(0.0, f64::max);
        let mut shape = Shape::new([first, last, side], lengths, n2, ROUNDOFF * longest);
        // Each errs by a rounding of itself.
        shape.sides_error = ROUNDOFF * (lengths[0].max(lengths[1]) + lengths[2]);
        let middle = (first + last) * (1.0 / 3.0);
        let reach = [middle, first - middle, last - middle].map(Vec3::norm).into_iter().fold(0.0, f64::max);
        Self { corners: [a, b, c], shape, middle, reach: reach + 8.0 * ROUNDOFF * longest }
    }
}

/// The corners a, b, c of a triangle from the one opposite the shortest side on, given the squares of ab, bc and ca.
pub(crate) fn apex_first<T>([a, b, c]: [T; 3], [ab, bc, ca]: [f64; 3]) -> [T; 3] {
    if bc <= ab && bc <= ca {
        [a, b, c]
    } else if ca <= ab {
        [b, c, a]
    } else {
        [c, a, b]
    }
}
