//! Logarithmic axes.

use super::svg::{Anchor, Svg};

/// An axis of powers, along `x` or `y` of a picture.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis {
    /// 10 or 2.
    pub(super) base: f64,
    /// Exponents at its ends.
    pub(super) exponents: [f64; 2],
    /// Where its ends are in the picture.
    pub(super) places: [f64; 2],
}

impl Axis {
    /// The exponent of a positive number, as `libm` has it on every machine.
    pub(super) fn exponent(self, value: f64) -> f64 {
        if self.base == 2.0 { libm::log2(value) } else { libm::log10(value) }
    }

    /// The place of a number, that of the nearer end beyond the ends.
    pub(super) fn place(self, value: f64) -> f64 {
        self.place_of_exponent(self.exponent(value))
    }

    fn place_of_exponent(self, exponent: f64) -> f64 {
        let ([low, high], [start, end]) = (self.exponents, self.places);
        start + (end - start) * ((exponent - low) / (high - low)).clamp(0.0, 1.0)
    }

    /// Places and labels of the powers, about so many.
    pub(super) fn ticks(self, about: f64) -> Vec<(f64, String)> {
        let [low, high] = self.exponents;
        let steps = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 10.0, 50.0, 100.0, 150.0, 200.0, 300.0, 450.0, 600.0];
        let step = steps.into_iter().find(|step| (high - low) / step <= about).unwrap_or(high - low);
        let first = (low / step - 1e-9).ceil();
        let exponents = std::iter::successors(Some(first), |i| Some(i + 1.0)).map(|i| i * step);
        exponents.take_while(|e| *e <= high + 1e-9).map(|e| (self.place_of_exponent(e), power(self.base, e))).collect()
    }

    /// Ticks, labels and grid lines below a plot from `top` to `bottom`.
    pub(super) fn draw_below(self, svg: &mut Svg, [top, bottom]: [f64; 2], about: f64, class: &str) {
        for (x, label) in self.ticks(about) {
            svg.line("grid", (x, top), (x, bottom));
            svg.line("axis", (x, bottom), (x, bottom + 3.0));
            svg.text(class, (x, bottom + 13.0), Anchor::Middle, &label);
        }
    }

    /// Ticks and labels left of a plot.
    pub(super) fn draw_left(self, svg: &mut Svg, left: f64, about: f64, class: &str) {
        for (y, label) in self.ticks(about) {
            svg.line("axis", (left - 3.0, y), (left, y));
            svg.text(class, (left - 5.0, y + 3.0), Anchor::End, &label);
        }
    }
}

/// `10⁻¹²`.
pub(super) fn power(base: f64, exponent: f64) -> String {
    let raised = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32(u32::from('⁰') + u32::from(digit) - u32::from('0')).unwrap_or(digit),
    };
    match exponent {
        0.0 => "1".to_owned(),
        _ => format!("{base}{}", format!("{exponent:.0}").chars().map(raised).collect::<String>()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_powers_at_their_places() {
        let axis = Axis { base: 10.0, exponents: [-12.0, 4.0], places: [100.0, 20.0] };
        let labels: Vec<String> = axis.ticks(5.0).into_iter().map(|(_, label)| label).collect();
        assert_eq!(labels, ["10⁻¹²", "10⁻⁸", "10⁻⁴", "1", "10⁴"]);
        assert_eq!([1e-12, 1e-4, 1e4, 1e9].map(|x| axis.place(x)), [100.0, 60.0, 20.0, 20.0]);
        assert_eq!(power(2.0, -890.0), "2⁻⁸⁹⁰");
    }
}
