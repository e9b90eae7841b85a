//! A function sampled on a grid, and its level lines by marching squares.

use rayon::prelude::*;

/// The rectangle `[x0, x1] x [y0, y1]` of a plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Window {
    /// Ends of the first coordinate.
    pub(crate) x: [f64; 2],
    /// Ends of the second coordinate.
    pub(crate) y: [f64; 2],
}

/// Values at the centres of `columns` times `rows` equal cells of a window.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Field {
    /// The window.
    pub(crate) window: Window,
    /// Cells along `x`.
    pub(crate) columns: u32,
    /// Cells along `y`.
    pub(crate) rows: u32,
    values: Vec<f64>,
}

impl Field {
    /// Samples `function`, on all cores.
    ///
    /// # Errors
    /// The first error of `function`.
    pub(crate) fn sample<E: Send>(
        window: Window,
        [columns, rows]: [u32; 2],
        function: impl Fn(f64, f64) -> Result<f64, E> + Sync,
    ) -> Result<Self, E> {
        let empty = Self { window, columns, rows, values: Vec::new() };
        let centres = (0..rows).into_par_iter().flat_map_iter(|row| (0..columns).map(move |column| (column, row)));
        let values = centres.map(|(column, row)| empty.centre(column, row)).map(|(x, y)| function(x, y));
        Ok(Self { values: values.collect::<Result<_, E>>()?, ..empty })
    }

    /// Value of a cell.
    pub(crate) fn value(&self, column: u32, row: u32) -> f64 {
        self.values[row as usize * self.columns as usize + column as usize]
    }

    /// Centre of a cell.
    pub(crate) fn centre(&self, column: u32, row: u32) -> (f64, f64) {
        let along =
            |[low, high]: [f64; 2], index: u32, count: u32| low + (high - low) * (f64::from(index) + 0.5) / f64::from(count);
        (along(self.window.x, column, self.columns), along(self.window.y, row, self.rows))
    }

    /// The largest value and the centre of its cell.
    pub(crate) fn largest(&self) -> (f64, (f64, f64)) {
        let cells = (0..self.rows).flat_map(|row| (0..self.columns).map(move |column| (column, row)));
        let (column, row) =
            cells.fold((0, 0), |best, cell| if self.value(cell.0, cell.1) > self.value(best.0, best.1) { cell } else { best });
        (self.value(column, row), self.centre(column, row))
    }

    /// The line on which the function is `level`, as segments.
    pub(crate) fn level_line(&self, level: f64) -> Vec<[(f64, f64); 2]> {
        let squares = (1..self.rows).flat_map(|row| (1..self.columns).map(move |column| (column, row)));
        squares.flat_map(|(column, row)| self.segments_in(column, row, level)).collect()
    }

    /// The segments of a level line between four neighbouring centres, of which the last is (`column`, `row`): where two opposite
    /// corners are above the level and two below, the mean of the four decides which of them are joined.
    fn segments_in(&self, column: u32, row: u32, level: f64) -> Vec<[(f64, f64); 2]> {
        let corners = [(column - 1, row - 1), (column, row - 1), (column, row), (column - 1, row)];
        let values = corners.map(|(i, j)| self.value(i, j));
        let above = values.map(|value| value > level);
        let crossings: Vec<(f64, f64)> = (0..4)
            .map(|i| (i, (i + 1) % 4))
            .filter(|&(i, k)| above[i] != above[k])
            .map(|(i, k)| {
                let t = (level - values[i]) / (values[k] - values[i]);
                let (from, to) = (self.centre(corners[i].0, corners[i].1), self.centre(corners[k].0, corners[k].1));
                (from.0 + t * (to.0 - from.0), from.1 + t * (to.1 - from.1))
            })
            .collect();
        match *crossings {
            [a, b] => vec![[a, b]],
            [a, b, c, d] if (values.iter().sum::<f64>() > 4.0 * level) == above[0] => vec![[a, b], [c, d]],
            [a, b, c, d] => vec![[d, a], [b, c]],
            _ => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WINDOW: Window = Window { x: [-1.0, 1.0], y: [-1.0, 1.0] };

    fn sample(count: u32, function: impl Fn(f64, f64) -> f64 + Sync) -> Field {
        Field::sample::<()>(WINDOW, [count, count], |x, y| Ok(function(x, y))).unwrap()
    }

    #[test]
    fn a_circle_has_its_length_and_its_radius() {
        let lines = sample(200, |x, y| x * x + y * y).level_line(0.25);
        let length: f64 = lines.iter().map(|[a, b]| ((a.0 - b.0) * (a.0 - b.0) + (a.1 - b.1) * (a.1 - b.1)).sqrt()).sum();
        assert!((length - std::f64::consts::PI).abs() < 1e-3, "{length}");
        assert!(lines.iter().flatten().all(|(x, y)| (x * x + y * y - 0.25).abs() < 1e-4));
    }

    #[test]
    fn a_saddle_joins_the_corners_on_the_side_of_its_middle() {
        for level in [-0.05, 0.05] {
            let lines = sample(2, |x, y| x * y).level_line(level);
            assert_eq!(lines.len(), 2);
            // The middle, 0, is on the side of the corners that are joined: no segment comes between it and them.
            let cut_off = |[a, b]: &[(f64, f64); 2]| (a.0 + b.0) * (a.1 + b.1);
            assert!(lines.iter().all(|segment| cut_off(segment) * level > 0.0), "{lines:?}");
        }
    }

    #[test]
    fn the_largest_value_is_found_where_it_is() {
        let (largest, (x, y)) = sample(101, |x, y| x - 2.0 * y).largest();
        assert!(x > 0.98 && y < -0.98 && (largest - (x - 2.0 * y)).abs() < 1e-15);
    }

    #[test]
    fn an_error_of_the_function_is_the_error_of_the_field() {
        let failing = |x: f64, _: f64| if x > 0.5 { Err("too far") } else { Ok(x) };
        assert_eq!(Field::sample(WINDOW, [4, 4], failing), Err("too far"));
    }
}
