//! The first elements of faces. A constant leaves a third more of light that rises evenly on a triangle than on a square of the same area,
//! and more on a long rectangle than on a square: so faces can be cut into parallelograms that are nearly squares.

use radgrad_core::DVec3;
use radgrad_scene::{is_parallelogram, largest, smallest};

/// Most parts that a long parallelogram is cut into.
pub(crate) const MOST_SLICES: usize = 16;

/// A parallelogram is long from so many times its width on: a face near one part of it is far from the others, and to divide it
/// into four again and again makes parts that are as long. It is cut if its face has this part of all area; legs of a table, say,
/// stay whole.
const LONG: f64 = 8.0;
pub(crate) const LARGE: f64 = 0.02;

/// The least part of an outline that a parallelogram in it has to make up.
const LEAST_PARALLELOGRAM: f64 = 0.75;

/// The part of an outline below which a triangle is rounding.
const LEAST_TRIANGLE: f64 = 1e-9;

/// How faces are first cut into elements.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Cut<'a> {
    /// Into as few as can be.
    Few,
    /// Into parallelograms about as long as wide, and triangles where there are none.
    Squares,
    /// Into these parts of each face.
    Parts(&'a [Vec<Vec<DVec3>>]),
}

/// The same, kept: whether into squares, and the parts of each face if they were given.
pub(crate) type Given = (bool, Option<Vec<Vec<Vec<DVec3>>>>);

impl<'a> Cut<'a> {
    /// The part of it that is kept.
    pub(crate) fn given(self) -> Given {
        (matches!(self, Self::Squares), if let Self::Parts(parts) = self { Some(parts.to_vec()) } else { None })
    }

    /// The part that was kept.
    pub(crate) fn of(given: &'a Given) -> Self {
        match given {
            (_, Some(parts)) => Self::Parts(parts),
            (true, None) => Self::Squares,
            (false, None) => Self::Few,
        }
    }
}

/// A parallelogram that is at least one and a half times as long as wide, cut across into parts that are about as long as wide; `None` for any
/// other outline.
pub(crate) fn slices(outline: &[DVec3]) -> Option<Vec<Vec<DVec3>>> {
    if !is_parallelogram(outline) {
        return None;
    }
    let &[p, q, r, s] = outline else { return None };
    let [a, b, c, d] = if (q - p).length() >= (s - p).length() { [p, q, r, s] } else { [q, r, s, p] };
    let (along, across) = (b - a, d - a);
    let is_nearest = |count: &usize| along.length() < (*count as f64 + 0.5) * across.length();
    let count = (1..=MOST_SLICES).find(is_nearest).unwrap_or(MOST_SLICES);
    if count == 1 {
        return None;
    }
    let point = |index: usize, [from, to]: [DVec3; 2]| from.lerp(to, index as f64 / count as f64);
    let slice = |index: usize| {
        let [start, end] = [index, index + 1];
        vec![point(start, [a, b]), point(end, [a, b]), point(end, [d, c]), point(start, [d, c])]
    };
    Some((0..count).map(slice).collect())
}

/// Whether an outline is a long parallelogram.
pub(crate) fn is_long(outline: &[DVec3]) -> bool {
    let &[p, q, _, s] = outline else { return false };
    let [a, b] = [(q - p).length(), (s - p).length()];
    is_parallelogram(outline) && largest(a, b) >= LONG * smallest(a, b)
}

/// A convex outline of four corners that is no parallelogram, cut into the largest parallelogram at a corner of it and the triangles beside
/// it; `None` for any other outline, and where there is none that makes up most of it.
pub(crate) fn with_parallelogram(outline: &[DVec3], normal: DVec3) -> Option<Vec<Vec<DVec3>>> {
    if outline.len() != 4 || is_parallelogram(outline) {
        return None;
    }
    let area = |[a, b, c]: [DVec3; 3]| 0.5 * normal.dot((b - a).cross(c - a));
    let whole = area([outline[0], outline[1], outline[2]]) + area([outline[0], outline[2], outline[3]]);
    let split = |first: usize| {
        let [a, b, c, d] = [0, 1, 2, 3].map(|next| outline[(first + next) % 4]);
        let inner = b + d - a;
        let beside = [[b, c, inner], [inner, c, d]];
        let is_inside = beside.iter().all(|&triangle| area(triangle) >= -LEAST_TRIANGLE * whole);
        let part = 2.0 * area([a, b, d]) / whole;
        let triangles =
            beside.into_iter().filter(|&triangle| area(triangle) > LEAST_TRIANGLE * whole).map(|corners| corners.to_vec());
        (is_inside && part >= LEAST_PARALLELOGRAM)
            .then(|| (part, std::iter::once(vec![a, b, inner, d]).chain(triangles).collect::<Vec<_>>()))
    };
    (0..4).filter_map(split).max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, parts)| parts)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(outline: &[DVec3]) -> f64 {
        (1..outline.len() - 1).map(|i| 0.5 * (outline[i] - outline[0]).cross(outline[i + 1] - outline[0]).z).sum()
    }

    fn outline(corners: &[[f64; 2]]) -> Vec<DVec3> {
        corners.iter().map(|&[x, y]| DVec3::new(x, y, 0.0)).collect()
    }

    #[test]
    fn a_skew_wall_is_a_parallelogram_and_slivers_beside_it() {
        for (corners, count) in [
            ([[0.0, 0.0], [5.5, 0.0], [5.6, 5.5], [0.0, 5.5]], 2),
            ([[0.0, 0.0], [5.5, 0.1], [5.6, 5.5], [0.0, 5.3]], 3),
            ([[0.0, 0.0], [5.6, 0.0], [5.4, 5.5], [-0.1, 5.3]], 3),
        ] {
            let wall = outline(&corners);
            let parts = with_parallelogram(&wall, DVec3::Z).unwrap();
            assert_eq!(parts.len(), count, "{corners:?}");
            assert!(is_parallelogram(&parts[0]));
            assert!(parts.iter().all(|part| area(part) > 0.0), "{parts:?}");
            assert!((parts.iter().map(|part| area(part)).sum::<f64>() - area(&wall)).abs() < 1e-12);
        }
    }

    #[test]
    fn what_is_far_from_a_parallelogram_is_not_cut_so() {
        let kite = outline(&[[0.0, 0.0], [1.0, -0.2], [4.0, 0.0], [1.0, 0.2]]);
        assert_eq!(with_parallelogram(&kite, DVec3::Z), None);
        let square = outline(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        assert_eq!(with_parallelogram(&square, DVec3::Z), None);
    }

    #[test]
    fn slices_are_about_as_long_as_wide() {
        let strip = outline(&[[0.0, 0.0], [1.0, 0.0], [1.0, 3.4], [0.0, 3.4]]);
        let parts = slices(&strip).unwrap();
        assert_eq!(parts.len(), 3);
        assert!((parts.iter().map(|part| area(part)).sum::<f64>() - 3.4).abs() < 1e-12);
        assert_eq!(slices(&outline(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.4], [0.0, 1.4]])), None);
    }

    #[test]
    fn a_long_parallelogram_is_cut_into_no_more_parts_than_are_allowed() {
        let strip = |length: f64| outline(&[[0.0, 0.0], [length, 0.0], [length, 1.0], [0.0, 1.0]]);
        assert!(!is_long(&strip(7.9)) && is_long(&strip(8.1)) && is_long(&strip(0.1)) && !is_long(&strip(3.0)[..3]));
        let counts = [1.4, 3.2, 50.0].map(|length| slices(&strip(length)).map(|parts| parts.len()));
        assert_eq!(counts, [None, Some(3), Some(MOST_SLICES)]);
    }
}
