//! The six kinds of cases that the methods are tried on: one triangle, sixteen receivers each, constant or linear emission.
//!
//! The triangle is about 1 across and lies 1 over the origin, lit downward. Lengths are in its unit. All numbers are of single
//! precision, so that batches in single precision answer the same cases.

use clap::ValueEnum;
use radgrad_core::{DVec3, Emission, Emitter, Error, Polygon, Receiver};

/// Where the receivers are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Regime {
    /// One and a half below the triangle, all of it above the horizon.
    Easy,
    /// A hundredth below its plane, tilted.
    #[value(name = "near-1e-2")]
    Near2,
    /// 1e-5 below its plane, tilted.
    #[value(name = "near-1e-5")]
    Near5,
    /// A thousand sizes away.
    #[value(name = "far-1e3")]
    Far,
    /// Beside it and 1e-6 below its plane: it is seen almost edge-on.
    Grazing,
    /// Looking along it: the horizon cuts it.
    Clipped,
}

impl Regime {
    /// All, in the order of the diagrams.
    pub(crate) const ALL: [Self; 6] = [Self::Easy, Self::Near2, Self::Near5, Self::Far, Self::Grazing, Self::Clipped];

    /// Name of its files.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Easy => "easy",
            Self::Near2 => "near-1e-2",
            Self::Near5 => "near-1e-5",
            Self::Far => "far-1e3",
            Self::Grazing => "grazing",
            Self::Clipped => "clipped",
        }
    }

    /// The regime in a few words.
    pub(crate) const fn label(self) -> &'static str {
        match self {
            Self::Easy => "seen whole, 1.5 away",
            Self::Near2 => "0.01 from its plane",
            Self::Near5 => "1e-5 from its plane",
            Self::Far => "1000 away",
            Self::Grazing => "almost edge-on",
            Self::Clipped => "cut by the horizon",
        }
    }

    /// The regime in a line.
    pub(crate) const fn title(self) -> &'static str {
        match self {
            Self::Easy => "Easy: a triangle seen whole, one and a half sizes away",
            Self::Near2 => "Near: 0.01 from the emitter's plane, cut by the horizon",
            Self::Near5 => "Very near: 1e-5 from the emitter's plane, cut by the horizon",
            Self::Far => "Far: a thousand sizes away",
            Self::Grazing => "Grazing: beside the emitter, 1e-6 from its plane",
            Self::Clipped => "Clipped: the horizon cuts the emitter",
        }
    }

    /// Sixteen cases, on a lattice that meets no vertex and no edge.
    pub(crate) fn cases(self, kind: Kind) -> Result<Vec<Case>, Error> {
        let triangle = [[0.0, 0.0, 1.0], [0.5, 0.75, 1.0], [1.0, 0.0, 1.0]].map(DVec3::from);
        let emitter = Emitter::new(Polygon::new(triangle.to_vec())?, kind.emission())?;
        let lattice = (0..16u32).map(|i| (0.13 + 0.21 * f64::from(i % 4), 0.07 + 0.17 * f64::from(i / 4)));
        lattice.map(|(x, y)| Ok(Case { receiver: self.receiver(x, y)?, emitter: emitter.clone() })).collect()
    }

    fn receiver(self, x: f64, y: f64) -> Result<Receiver, Error> {
        let tilted = DVec3::new(0.2, -0.1, 1.0);
        let (position, normal) = match self {
            Self::Easy => (DVec3::new(x, y, -0.5), tilted),
            Self::Near2 => (DVec3::new(x, y, 0.99), tilted),
            Self::Near5 => (DVec3::new(x, y, 1.0 - 1e-5), tilted),
            Self::Far => (DVec3::new(x, y, -1e3), tilted),
            Self::Grazing => (DVec3::new(x + 2.0, y, 1.0 - 1e-6), DVec3::new(-1.0, 0.1, 0.3)),
            Self::Clipped => (DVec3::new(x, y, 0.0), DVec3::new(1.0, 0.3, 0.1)),
        };
        let rounded = |v: DVec3| DVec3::from(v.to_array().map(|coordinate| f64::from(single(coordinate))));
        Receiver::new(rounded(position), rounded(normal), 0.75)
    }
}

/// How the triangle emits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// The same everywhere.
    Constant,
    /// Between 1, 2 and 4 at its vertices.
    Linear,
}

impl Kind {
    /// Both, in the order of a diagram's panels.
    pub(crate) const ALL: [Self; 2] = [Self::Constant, Self::Linear];

    /// Name in tables.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::Linear => "linear",
        }
    }

    /// The emission of a triangle.
    pub(crate) fn emission(self) -> Emission {
        match self {
            Self::Constant => Emission::Constant(2.0),
            Self::Linear => Emission::at_vertices(vec![1.0, 2.0, 4.0]),
        }
    }
}

/// One receiver and one emitter.
#[derive(Debug, Clone)]
pub(crate) struct Case {
    pub(crate) receiver: Receiver,
    pub(crate) emitter: Emitter,
}

/// The nearest number of single precision.
#[allow(clippy::cast_possible_truncation, reason = "to the nearest is what is wanted")]
pub(crate) const fn single(number: f64) -> f32 {
    number as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_regime_is_what_its_name_says() {
        let cut = |case: &Case| {
            let above = |v: &&DVec3| case.receiver.normal().dot(**v - case.receiver.position()) > 0.0;
            let above = case.emitter.polygon().vertices().iter().filter(above).count();
            above > 0 && above < 3
        };
        let height = |case: &Case| 1.0 - case.receiver.position().z;
        for regime in Regime::ALL {
            let cases = regime.cases(Kind::Constant).unwrap();
            assert_eq!(cases.len(), 16);
            let expected_height = match regime {
                Regime::Easy => 1.5,
                Regime::Near2 => 1e-2,
                Regime::Near5 => 1e-5,
                Regime::Far => 1001.0,
                Regime::Grazing => 1e-6,
                Regime::Clipped => 1.0,
            };
            for case in &cases {
                assert!((height(case) / expected_height - 1.0).abs() < 0.03, "{regime:?}");
                assert!(radgrad_core::radiosity(&case.receiver, &case.emitter).unwrap() > 0.0, "{regime:?} is dark");
            }
            let crossing = cases.iter().filter(|case| cut(case)).count();
            match regime {
                Regime::Easy | Regime::Far => assert_eq!(crossing, 0, "{regime:?}"),
                Regime::Near2 | Regime::Near5 | Regime::Clipped => assert!(crossing > 12, "{regime:?}: {crossing}"),
                Regime::Grazing => {}
            }
        }
    }
}
