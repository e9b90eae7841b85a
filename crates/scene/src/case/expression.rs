//! An emission written as an expression of the position: `1 + x*exp(-y)`.
//!
//! Numbers, `x`, `y`, `z`, `pi` and `e`, `+ - * / ^`, parentheses, and the functions of [`FUNCTIONS`] and [`OF_TWO`]. Powers bind
//! first and from the right, then signs, so that `-x^2` is `-(x^2)`. Functions are `libm`'s: the same digits on every machine.

use radgrad_core::DVec3;

use crate::error::Error;

/// Deeper than that nobody nests by hand, and the stack of a thread has room for it.
const DEEPEST: usize = 100;

/// Bytes that an expression may have, so that a long sum does not nest too deep either.
const LONGEST: usize = 1000;

type OfOne = fn(f64) -> f64;
type OfTwo = fn(f64, f64) -> f64;

/// Functions of one number.
const FUNCTIONS: [(&str, OfOne); 16] = [
    ("abs", f64::abs),
    ("acos", libm::acos),
    ("asin", libm::asin),
    ("atan", libm::atan),
    ("cos", libm::cos),
    ("cosh", libm::cosh),
    ("exp", libm::exp),
    ("ln", libm::log),
    ("log10", libm::log10),
    ("log2", libm::log2),
    ("sin", libm::sin),
    ("sinh", libm::sinh),
    ("sqrt", libm::sqrt),
    ("tan", libm::tan),
    ("tanh", libm::tanh),
    ("cbrt", libm::cbrt),
];

/// Functions of two.
const OF_TWO: [(&str, OfTwo); 4] =
    [("atan2", libm::atan2), ("max", crate::extremes::largest), ("min", crate::extremes::smallest), ("pow", libm::pow)];

/// An expression of the position.
#[derive(Debug, Clone)]
pub(super) struct Expression(Node);

#[derive(Debug, Clone)]
enum Node {
    Number(f64),
    Coordinate(usize),
    Of(OfOne, Box<Self>),
    OfTwo(OfTwo, Box<[Self; 2]>),
}

impl Node {
    fn evaluate(&self, point: [f64; 3]) -> f64 {
        match self {
            Self::Number(number) => *number,
            Self::Coordinate(axis) => point[*axis],
            Self::Of(function, inner) => function(inner.evaluate(point)),
            Self::OfTwo(function, pair) => function(pair[0].evaluate(point), pair[1].evaluate(point)),
        }
    }

    fn of_two(function: OfTwo, first: Self, second: Self) -> Self {
        Self::OfTwo(function, Box::new([first, second]))
    }
}

impl Expression {
    /// Reads an expression.
    pub(super) fn parse(text: &str) -> Result<Self, Error> {
        if text.len() > LONGEST {
            return Err(Error::Expression { column: LONGEST + 1, rule: format!("it has more than {LONGEST} bytes") });
        }
        let mut parser = Parser { text, at: 0, depth: 0 };
        let node = parser.sum()?;
        if parser.peek().is_some() {
            return Err(parser.wrong("an operator"));
        }
        Ok(Self(node))
    }

    /// The value at a point.
    pub(super) fn evaluate(&self, point: DVec3) -> Result<f64, Error> {
        let value = self.0.evaluate(point.to_array());
        if value.is_finite() { Ok(value) } else { Err(Error::ExpressionNotFinite { point, value }) }
    }
}

struct Parser<'a> {
    text: &'a str,
    /// Byte of the text.
    at: usize,
    depth: usize,
}

impl Parser<'_> {
    /// The next character that is no space.
    fn peek(&mut self) -> Option<char> {
        let remainder = &self.text[self.at..];
        self.at += remainder.len() - remainder.trim_start().len();
        self.text[self.at..].chars().next()
    }

    /// Passes over a character, if it is the next one.
    fn takes(&mut self, wanted: char) -> bool {
        let is_next = self.peek() == Some(wanted);
        if is_next {
            self.at += wanted.len_utf8();
        }
        is_next
    }

    fn expects(&mut self, wanted: char) -> Result<(), Error> {
        if self.takes(wanted) { Ok(()) } else { Err(self.wrong(&format!("`{wanted}`"))) }
    }

    fn wrong(&mut self, expected: &str) -> Error {
        let shown = self.peek().map_or_else(|| "its end".to_owned(), |c| format!("`{}`", c.escape_debug()));
        Error::Expression { column: self.at + 1, rule: format!("expected {expected}, found {shown}") }
    }

    fn sum(&mut self) -> Result<Node, Error> {
        let mut node = self.product()?;
        loop {
            node = if self.takes('+') {
                Node::of_two(|a, b| a + b, node, self.product()?)
            } else if self.takes('-') {
                Node::of_two(|a, b| a - b, node, self.product()?)
            } else {
                return Ok(node);
            };
        }
    }

    fn product(&mut self) -> Result<Node, Error> {
        let mut node = self.signed()?;
        loop {
            node = if self.takes('*') {
                Node::of_two(|a, b| a * b, node, self.signed()?)
            } else if self.takes('/') {
                Node::of_two(|a, b| a / b, node, self.signed()?)
            } else {
                return Ok(node);
            };
        }
    }

    /// Every way down passes here.
    fn signed(&mut self) -> Result<Node, Error> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(Error::Expression { column: self.at + 1, rule: format!("it is nested more than {DEEPEST} deep") });
        }
        let node = if self.takes('-') {
            Node::Of(|a| -a, Box::new(self.signed()?))
        } else if self.takes('+') {
            self.signed()?
        } else {
            let base = self.atom()?;
            if self.takes('^') { Node::of_two(libm::pow, base, self.signed()?) } else { base }
        };
        self.depth -= 1;
        Ok(node)
    }

    fn atom(&mut self) -> Result<Node, Error> {
        match self.peek() {
            Some('(') => {
                self.at += 1;
                let node = self.sum()?;
                self.expects(')')?;
                Ok(node)
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_ascii_alphabetic() => self.name(),
            _ => Err(self.wrong("a number, a name or `(`")),
        }
    }

    /// The longest run of digits, with a point and an exponent.
    fn number(&mut self) -> Result<Node, Error> {
        let remainder = &self.text.as_bytes()[self.at..];
        let mut end = 0;
        let digits = |mut end: usize| {
            while remainder.get(end).is_some_and(u8::is_ascii_digit) {
                end += 1;
            }
            end
        };
        end = digits(end);
        if remainder.get(end) == Some(&b'.') {
            end = digits(end + 1);
        }
        if let Some(b'e' | b'E') = remainder.get(end) {
            let sign = usize::from(matches!(remainder.get(end + 1), Some(b'+' | b'-')));
            let exponent = digits(end + 1 + sign);
            end = if exponent > end + 1 + sign { exponent } else { end };
        }
        let text = &self.text[self.at..self.at + end];
        match text.parse::<f64>() {
            Ok(number) if number.is_finite() => {
                self.at += end;
                Ok(Node::Number(number))
            }
            _ => Err(Error::Expression { column: self.at + 1, rule: format!("`{text}` is no number of a double") }),
        }
    }

    fn name(&mut self) -> Result<Node, Error> {
        let remainder = &self.text[self.at..];
        let end = remainder.find(|c: char| !c.is_ascii_alphanumeric()).unwrap_or(remainder.len());
        let (name, column) = (&remainder[..end], self.at + 1);
        self.at += end;
        match name {
            "x" => return Ok(Node::Coordinate(0)),
            "y" => return Ok(Node::Coordinate(1)),
            "z" => return Ok(Node::Coordinate(2)),
            "pi" => return Ok(Node::Number(std::f64::consts::PI)),
            "e" => return Ok(Node::Number(std::f64::consts::E)),
            _ => {}
        }
        if let Some((_, function)) = FUNCTIONS.iter().find(|(known, _)| *known == name) {
            self.expects('(')?;
            let argument = self.sum()?;
            self.expects(')')?;
            return Ok(Node::Of(*function, Box::new(argument)));
        }
        if let Some((_, function)) = OF_TWO.iter().find(|(known, _)| *known == name) {
            self.expects('(')?;
            let first = self.sum()?;
            self.expects(',')?;
            let second = self.sum()?;
            self.expects(')')?;
            return Ok(Node::of_two(*function, first, second));
        }
        let names: Vec<&str> = FUNCTIONS.iter().map(|f| f.0).chain(OF_TWO.iter().map(|f| f.0)).collect();
        let rule = format!("`{name}` is not known: there are x, y, z, pi, e, and the functions {}", names.join(", "));
        Err(Error::Expression { column, rule })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expressions_are_read_as_in_the_books() {
        let point = DVec3::new(3.0, 2.0, 0.5);
        for (text, expected) in [
            ("1 + x*exp(-y)", 1.0 + 3.0 * libm::exp(-2.0)),
            ("-x^2", -9.0),
            ("2^3^2", 512.0),
            ("x^-y", 1.0 / 9.0),
            ("8/4/2 - 3 - 4", -6.0),
            ("2*-x + +y", -4.0),
            ("1.5e-3*x + .5 + 1.", 1.5045),
            ("max(x, y)*min(x, y)^z", 3.0 * libm::sqrt(2.0)),
            ("atan2(y, x) + pi/e", libm::atan2(2.0, 3.0) + std::f64::consts::PI / std::f64::consts::E),
            ("exp(-(x^2 + y^2)/2)", libm::exp(-6.5)),
            ("((((x))))", 3.0),
        ] {
            assert_eq!(Expression::parse(text).unwrap().evaluate(point).unwrap(), expected, "{text}");
        }
    }

    #[test]
    fn what_is_wrong_is_named_with_its_column() {
        let deep = format!("{}x{}", "(".repeat(400), ")".repeat(400));
        for (text, said) in [
            ("", "column 1 of the expression: expected a number, a name or `(`, found its end"),
            ("1 + ", "column 5 of the expression: expected a number"),
            ("2x", "column 2 of the expression: expected an operator, found `x`"),
            ("sin x", "column 5 of the expression: expected `(`, found `x`"),
            ("(x", "column 3 of the expression: expected `)`, found its end"),
            ("x + radius", "column 5 of the expression: `radius` is not known: there are x, y, z, pi, e"),
            ("1e999", "column 1 of the expression: `1e999` is no number"),
            ("1..2", "column 3 of the expression: expected an operator, found `.`"),
            ("x²", "column 2 of the expression: expected an operator, found `²`"),
            ("\u{0}", "found `\\0`"),
            (&deep, "nested more than 100 deep"),
            (&"-".repeat(500), "nested more than 100 deep"),
            (&"x+".repeat(5000), "column 1001 of the expression: it has more than 1000 bytes"),
        ] {
            let message = Expression::parse(text).unwrap_err().to_string();
            assert!(message.contains(said), "{message}");
        }
        let error = Expression::parse("ln(x)").unwrap().evaluate(DVec3::new(-1.0, 2.0, 3.0)).unwrap_err();
        assert_eq!(error.to_string(), "emission is NaN at [-1, 2, 3]: it must be finite all over the emitter");
    }
}
