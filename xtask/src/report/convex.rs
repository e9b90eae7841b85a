//! Convex polygons of a plane: cut at a line, and the hull of points.

/// A point of a plane.
pub(super) type Point = (f64, f64);

/// The part of a convex polygon to the left of the line from `a` to `b`.
pub(super) fn left_of(polygon: &[Point], a: Point, b: Point) -> Vec<Point> {
    clipped(polygon, |p| turn(a, b, *p), |p, q, t| (p.0 + t * (q.0 - p.0), p.1 + t * (q.1 - p.1)))
}

/// The part of a closed line of points where a linear function is not negative; `between` gives the point at a fraction of the
/// way from one to the next.
pub(super) fn clipped<P: Copy>(points: &[P], inside: impl Fn(&P) -> f64, between: impl Fn(P, P, f64) -> P) -> Vec<P> {
    let mut clipped = Vec::with_capacity(points.len() + 1);
    for (index, &point) in points.iter().enumerate() {
        let next = points[(index + 1) % points.len()];
        let [here, there] = [inside(&point), inside(&next)];
        if here >= 0.0 {
            clipped.push(point);
        }
        if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
            clipped.push(between(point, next, here / (here - there)));
        }
    }
    clipped
}

/// The convex hull, counter-clockwise (A. M. Andrew 1979).
pub(super) fn hull(points: &[Point]) -> Vec<Point> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let chain = |points: &mut dyn Iterator<Item = &Point>| {
        let mut chain: Vec<Point> = Vec::new();
        for &point in points {
            while let [.., a, b] = *chain
                && turn(a, b, point) <= 0.0
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    [chain(&mut sorted.iter()), chain(&mut sorted.iter().rev())].concat()
}

/// Twice the area of a triangle, positive if it is counter-clockwise.
fn turn(a: Point, b: Point, c: Point) -> f64 {
    (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [Point; 4] = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];

    #[test]
    fn a_cut_leaves_the_left_side() {
        assert_eq!(left_of(&SQUARE, (0.5, 0.0), (0.5, 1.0)), [(0.0, 0.0), (0.5, 0.0), (0.5, 1.0), (0.0, 1.0)]);
        assert!(left_of(&SQUARE, (2.0, 1.0), (2.0, 0.0)).is_empty());
    }

    #[test]
    fn a_hull_leaves_out_what_is_inside_and_on_its_sides() {
        let points = [&SQUARE[..], &[(0.5, 0.5), (0.5, 0.0), (0.2, 0.9)]].concat();
        assert_eq!(hull(&points), SQUARE);
    }
}
