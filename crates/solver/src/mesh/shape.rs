//! The two reference shapes: the unit square and the triangle (0,0), (1,0), (0,1).

/// The shape of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Shape {
    /// The image of the unit square.
    Parallelogram,
    /// The image of the triangle (0,0), (1,0), (0,1).
    Triangle,
}

impl Shape {
    /// The reference coordinates of its corners, counter-clockwise.
    pub(crate) const fn corners(self) -> &'static [[f64; 2]] {
        match self {
            Self::Parallelogram => &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
            Self::Triangle => &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
        }
    }

    /// The reference coordinates of its centroid.
    pub(crate) const fn centre(self) -> [f64; 2] {
        match self {
            Self::Parallelogram => [0.5; 2],
            Self::Triangle => [1.0 / 3.0; 2],
        }
    }
}

/// Reference coordinates in the parent of a point of a child: the quarters of a square in order, the corner triangles of a
/// triangle and its middle, turned by half a turn.
pub(crate) fn in_parent(shape: Shape, child: usize, [s, t]: [f64; 2]) -> [f64; 2] {
    let shift = |[a, b]: [f64; 2]| [a + 0.5 * s, b + 0.5 * t];
    match (shape, child) {
        (Shape::Triangle, 3) => [0.5 - 0.5 * s, 0.5 - 0.5 * t],
        (Shape::Triangle, _) => shift([[0.0, 0.0], [0.5, 0.0], [0.0, 0.5]][child]),
        (Shape::Parallelogram, _) => shift([[0.0, 0.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]][child]),
    }
}

/// Mean of `s^i t^j` over the shape.
pub(crate) fn moment(shape: Shape, i: usize, j: usize) -> f64 {
    let factorial = |n: usize| (1..=n).map(|k| k as f64).product::<f64>();
    match shape {
        Shape::Parallelogram => 1.0 / ((i + 1) as f64 * (j + 1) as f64),
        Shape::Triangle => 2.0 * factorial(i) * factorial(j) / factorial(i + j + 2),
    }
}
