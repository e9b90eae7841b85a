//! Ground of triangles whose faces see many others of the same surface: a crater with a rough floor, and hills.

/// A crater of radius 0.8 in a level square of side 2, its floor rough: `2 side^2` triangles.
pub(super) fn crater(side: usize) -> String {
    ground(side, |x, y| {
        let away = x.hypot(y) / 0.8;
        // A bowl, a raised rim, and level ground; stones on the floor and on the walls.
        let bowl = if away < 1.0 { 0.4 * (away * away - 1.0) } else { 0.0 };
        let rim = 0.08 * (-(8.0 * (away - 1.0)).powi(2)).exp();
        bowl + rim + if away < 1.0 { 0.03 * rough(x, y, 24.0) + 0.015 * rough(x, y, 48.0) } else { 0.0 }
    })
}

/// Hills in a square of side 2: `2 side^2` triangles.
pub(super) fn hills(side: usize) -> String {
    ground(side, |x, y| (1..6).map(|k| 0.5_f64.powi(k) * rough(x, y, 1.5 * 2.0_f64.powi(k))).sum())
}

/// Heights from -1/2 to 1/2 at the corners of a grid of so many cells to a unit, joined smoothly.
fn rough(x: f64, y: f64, cells: f64) -> f64 {
    let (u, v) = (x * cells, y * cells);
    let smooth = |t: f64| t * t * (3.0 - 2.0 * t);
    let (along, across) = (smooth(u - u.floor()), smooth(v - v.floor()));
    let at = |i: f64, j: f64| {
        // No two corners that are near have to do with each other.
        let mixed = (i * 12.9898 + j * 78.233 + cells).sin() * 43_758.545_3;
        mixed - mixed.floor() - 0.5
    };
    let [low, high] = [v.floor(), v.floor() + 1.0].map(|j| at(u.floor(), j) * (1.0 - along) + at(u.floor() + 1.0, j) * along);
    low * (1.0 - across) + high * across
}

/// Triangles that face up, over a grid of `side^2` squares, as OBJ.
fn ground(side: usize, height: impl Fn(f64, f64) -> f64) -> String {
    let mut text = String::new();
    let place = |k: usize| 2.0 * k as f64 / side as f64 - 1.0;
    for (i, j) in (0..=side).flat_map(|i| (0..=side).map(move |j| (i, j))) {
        let (x, y) = (place(i), place(j));
        text += &format!("v {x} {y} {}\n", height(x, y));
    }
    let corner = |i: usize, j: usize| i * (side + 1) + j + 1;
    for (i, j) in (0..side).flat_map(|i| (0..side).map(move |j| (i, j))) {
        let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
        text += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The numbers of a line after its first word.
    fn numbers<N: std::str::FromStr<Err: std::fmt::Debug>>(line: &str) -> Vec<N> {
        line.split(' ').skip(1).map(|word| word.parse().unwrap()).collect()
    }

    #[test]
    fn ground_faces_up_and_is_rough_where_it_is_said_to_be() {
        for text in [crater(20), hills(20)] {
            let (corners, faces): (Vec<&str>, Vec<&str>) = text.lines().partition(|line| line.starts_with('v'));
            let corners: Vec<Vec<f64>> = corners.into_iter().map(numbers).collect();
            let faces: Vec<Vec<usize>> = faces.into_iter().map(numbers).collect();
            assert_eq!([corners.len(), faces.len()], [21 * 21, 800]);
            for face in &faces {
                let [a, b, c] = [0, 1, 2].map(|k| &corners[face[k] - 1]);
                assert!((b[0] - a[0]) * (c[1] - a[1]) > (b[1] - a[1]) * (c[0] - a[0]), "{face:?}");
            }
        }
        let heights: Vec<f64> = crater(20)
            .lines()
            .filter(|line| line.starts_with('v'))
            .map(|line| line.rsplit(' ').next().unwrap().parse().unwrap())
            .collect();
        // Deep in the middle, level in a corner.
        assert!(heights[10 * 21 + 10] < -0.3 && heights[0].abs() < 1e-3, "{} {}", heights[10 * 21 + 10], heights[0]);
    }
}
