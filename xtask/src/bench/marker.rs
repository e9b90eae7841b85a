//! One marker a method. The colour says the kind of method and is of the palette of Okabe and Ito (2008), which colour-blind eyes
//! tell apart; the shape tells methods of a kind apart, so that no pair rests on colour alone.

use super::method::Method;
use crate::plot::{Picture, Point, Rgb, Stroke};

const BLUE: Rgb = (0, 114, 178);
const SKY: Rgb = (86, 180, 233);
const ORANGE: Rgb = (230, 159, 0);
const VERMILLION: Rgb = (213, 94, 0);
const GREEN: Rgb = (0, 158, 115);
const PURPLE: Rgb = (204, 121, 167);
const WHITE: Rgb = (255, 255, 255);

/// A shape of about 9 across.
#[derive(Debug, Clone, Copy)]
enum Shape {
    /// A regular polygon with a corner up: corners.
    Polygon(u32),
    /// A square on its side.
    Square,
    /// A triangle with a corner down.
    Down,
    /// A cross of two strokes.
    Cross,
    /// A plus of two strokes.
    Plus,
}

/// Colour of a method's line and marker.
pub(crate) const fn colour(method: Method) -> Rgb {
    match method {
        Method::ClosedForm | Method::Certified | Method::Digits => BLUE,
        Method::BatchDouble | Method::BatchCertified | Method::BatchSingle => SKY,
        Method::DualNumbers | Method::CentralDifferences => PURPLE,
        Method::ContourRule | Method::AreaRule => ORANGE,
        Method::AdaptiveContour | Method::AdaptiveArea => VERMILLION,
        Method::QuasiMonteCarlo | Method::MonteCarlo => GREEN,
    }
}

const fn shape(method: Method) -> Shape {
    match method {
        Method::ClosedForm => Shape::Polygon(24),
        Method::Certified | Method::BatchCertified | Method::AdaptiveContour | Method::QuasiMonteCarlo => Shape::Polygon(4),
        Method::Digits | Method::ContourRule => Shape::Polygon(3),
        Method::DualNumbers => Shape::Plus,
        Method::CentralDifferences | Method::MonteCarlo => Shape::Cross,
        Method::AreaRule | Method::BatchSingle => Shape::Down,
        Method::AdaptiveArea | Method::BatchDouble => Shape::Square,
    }
}

/// Draws a method's marker, hollow where the method gave up.
pub(crate) fn draw(picture: &mut Picture, method: Method, place: Point, hollow: bool) {
    let (colour, (x, y)) = (colour(method), place);
    let ring = |corners: u32, turn: f64, radius: f64| -> Vec<Point> {
        let angle = |i: u32| std::f64::consts::TAU * (f64::from(i) / f64::from(corners) + turn);
        (0..corners).map(|i| (x + radius * libm::sin(angle(i)), y - radius * libm::cos(angle(i)))).collect()
    };
    let corners = match shape(method) {
        Shape::Polygon(24) => ring(24, 0.0, 4.3),
        Shape::Polygon(corners) => ring(corners, 0.0, 5.2),
        Shape::Square => ring(4, 0.125, 5.2),
        Shape::Down => ring(3, 0.5, 5.2),
        Shape::Cross | Shape::Plus => {
            let turn = if matches!(shape(method), Shape::Plus) { 0.0 } else { 0.125 };
            let ends = ring(4, turn, 4.8);
            for pair in [[ends[0], ends[2]], [ends[1], ends[3]]] {
                picture.line(&pair, Stroke::solid(colour, if hollow { 1.0 } else { 2.2 }));
            }
            return;
        }
    };
    picture.fill(&corners, if hollow { WHITE } else { colour }, 1.0);
    picture.outline(&corners, Stroke::solid(if hollow { colour } else { WHITE }, if hollow { 1.5 } else { 0.7 }));
}
