//! Surfaces of geometry `F 3a`: a shape in a plane of its own.
//!
//! The plane has an origin P, an azimuth a, clockwise from y (north), and a tilt t from facing upward: its normal is
//! `(sin t sin a, sin t cos a, cos t)`. Seen from in front, u runs to the right and v up the plane:
//! `P + u (-cos a, sin a, 0) + v (-cos t sin a, -cos t cos a, sin t)`. A rectangle `R` is given by width and height from P, a
//! quadrilateral `Q` and a triangle `T` by pairs u, v. Angles are degrees; whole quarters of a turn are exact.

use radgrad_core::DVec3;

use crate::error::Error;
use crate::place::Position;
use crate::precision::{Digits, Written};
use crate::scene::intake::Intake;
use crate::words::{Words, number};

/// A shape by its letter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shape {
    Rectangle,
    Quadrilateral,
    Triangle,
}

impl Shape {
    pub(super) fn named(word: &str) -> Option<Self> {
        match word {
            "R" | "r" => Some(Self::Rectangle),
            "Q" | "q" => Some(Self::Quadrilateral),
            "T" | "t" => Some(Self::Triangle),
            _ => None,
        }
    }

    /// Reads the numbers of the plane and of the shape, which stand in as many of the next lines as it takes.
    pub(super) fn vertices<'a>(
        self,
        lines: &mut impl Iterator<Item = (usize, &'a str)>,
        intake: &mut Intake,
    ) -> Result<Vec<DVec3>, Error> {
        const PLANE: [&str; 5] = ["x of the plane", "y of the plane", "z of the plane", "azimuth", "tilt"];
        let of_shape: &[&str] = match self {
            Self::Rectangle => &["width", "height"],
            Self::Quadrilateral => &["u", "v", "u", "v", "u", "v", "u", "v"],
            Self::Triangle => &["u", "v", "u", "v", "u", "v"],
        };
        let mut wanted = PLANE.iter().chain(of_shape).peekable();
        let mut numbers = Vec::with_capacity(PLANE.len() + of_shape.len());
        while let Some(first) = wanted.peek() {
            let Some((line, text)) = lines.next() else {
                return Err(Error::expected(format!("a number ({first})"), "the end of the file"));
            };
            let mut read = || {
                let mut words = Words::separated(data_of(text), is_separator);
                while !words.is_empty() {
                    let Some(what) = wanted.next() else { return words.end() };
                    let word = words.next();
                    let value = number(word, what)?;
                    if !matches!(*what, "azimuth" | "tilt") {
                        intake.written().add(Written::Text(Digits::parse(word.unwrap_or_default())), value);
                    }
                    numbers.push(value);
                }
                Ok(())
            };
            read().map_err(|error: Error| error.at_place(intake.place(Position::Line(line))))?;
        }
        let (plane, shape) = numbers.split_at(PLANE.len());
        let pairs: Vec<[f64; 2]> = match self {
            Self::Rectangle => vec![[0.0, shape[1]], [0.0, 0.0], [shape[0], 0.0], [shape[0], shape[1]]],
            _ => shape.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect(),
        };
        let ([sin_a, cos_a], [sin_t, cos_t]) = (sine_and_cosine(plane[3]), sine_and_cosine(plane[4]));
        let origin = DVec3::new(plane[0], plane[1], plane[2]);
        let (right, up) = (DVec3::new(-cos_a, sin_a, 0.0), DVec3::new(-cos_t * sin_a, -cos_t * cos_a, sin_t));
        Ok(pairs.into_iter().map(|[u, v]| origin + right * u + up * v).collect())
    }
}

/// Sine and cosine of an angle in degrees.
fn sine_and_cosine(degrees: f64) -> [f64; 2] {
    let within = degrees.rem_euclid(360.0);
    match within {
        0.0 => [0.0, 1.0],
        90.0 => [1.0, 0.0],
        180.0 => [0.0, -1.0],
        270.0 => [-1.0, 0.0],
        _ => [libm::sin(within.to_radians()), libm::cos(within.to_radians())],
    }
}

pub(super) const fn is_separator(c: char) -> bool {
    matches!(c, ' ' | ',' | '\t' | '\r')
}

/// The line up to a comment: a word that starts with `!` or `/`.
pub(super) fn data_of(line: &str) -> &str {
    let bytes = line.as_bytes();
    let starts_word = |i: usize| i == 0 || is_separator(char::from(bytes[i - 1]));
    let comment = (0..bytes.len()).find(|&i| matches!(bytes[i], b'!' | b'/') && starts_word(i));
    line[..comment.unwrap_or(line.len())].trim_ascii()
}
