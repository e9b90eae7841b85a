//! Points at which the radiosity is asked for, and the answers, in their order: JSON Lines in, JSON Lines out, or a table in and CSV out.
//!
//! Lines are decoded before the scene is solved; one that is wrong costs itself only.

mod table;

use std::fmt::Write as _;
use std::io::{self, Read, Write};
use std::path::Path;

use radgrad_certificate::{Interval, Place, PointCertificate};
use radgrad_core::DVec3;
use radgrad_scene::case::Id;
use radgrad_scene::{Error, largest, read_file, smallest};
use radgrad_solver::{Gathered, Gradient, Ledger, Solution};
use rayon::prelude::*;
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};

use crate::certified::contradicts;
use crate::photometry::Photometry;

/// One line of the input.
#[derive(Debug, Deserialize)]
#[serde(
    deny_unknown_fields,
    expecting = "a point: {\"position\": [x, y, z], \"normal\": [x, y, z]}, and \"on\": \"face\" or \"free\""
)]
pub(crate) struct Point {
    #[serde(default)]
    id: Option<Id>,
    position: [f64; 3],
    normal: [f64; 3],
    #[serde(default)]
    on: Option<On>,
    #[serde(default, rename = "truth")]
    _truth: IgnoredAny,
    #[serde(default, rename = "family")]
    _family: IgnoredAny,
    #[serde(default, rename = "comment")]
    _comment: IgnoredAny,
}

/// Where a point is: on a face if one is there, unless the line says otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
enum On {
    Face,
    Free,
}

impl On {
    const fn name(self) -> &'static str {
        match self {
            Self::Face => "face",
            Self::Free => "free",
        }
    }
}

impl Point {
    const fn new(position: [f64; 3], normal: [f64; 3]) -> Self {
        let [_truth, _family, _comment] = [IgnoredAny; 3];
        Self { id: None, position, normal, on: None, _truth, _family, _comment }
    }

    /// Its position and normal.
    pub(crate) fn sensor(&self) -> (DVec3, DVec3) {
        (DVec3::from(self.position), DVec3::from(self.normal))
    }

    /// Where it is in a solution.
    fn place(&self, solution: &Solution) -> On {
        let found = || if solution.is_on_a_face(DVec3::from(self.position)) { On::Face } else { On::Free };
        self.on.unwrap_or_else(found)
    }
}

/// One line of the output, each number in each channel of the scene. A point in free space has no radiosity.
#[derive(Debug, Serialize)]
struct Answer<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    id: Option<&'a Id>,
    on: On,
    #[serde(flatten)]
    lit: Option<Lit>,
    #[serde(flatten)]
    reflected: Option<Reflected>,
    irradiance: Vec<f64>,
    irradiance_estimate: Vec<f64>,
    #[serde(flatten)]
    slope: Option<Slope>,
    /// Of the radiosity, or of the irradiance of a sensor in space: lower and upper end, which is null where it is infinite.
    #[serde(skip_serializing_if = "Option::is_none")]
    certified: Option<Vec<[f64; 2]>>,
    #[serde(skip)]
    place: Place,
}

/// Light as eyes see it, in lux, where that was asked for.
#[derive(Debug, Serialize)]
struct Lit {
    illuminance: f64,
    illuminance_estimate: f64,
}

/// The radiosity of a point of a face and an estimate of its error.
#[derive(Debug, Serialize)]
struct Reflected {
    radiosity: Vec<f64>,
    estimate: Vec<f64>,
    /// Within the face.
    #[serde(flatten)]
    slope: Option<FaceSlope>,
}

/// The gradient of the radiosity, within the face.
#[derive(Debug, Serialize)]
struct FaceSlope {
    gradient: Vec<[f64; 3]>,
    gradient_estimate: Vec<f64>,
}

/// The gradient of the irradiance.
#[derive(Debug, Serialize)]
struct Slope {
    irradiance_gradient: Vec<[f64; 3]>,
    irradiance_gradient_estimate: Vec<f64>,
}

/// The reply to a point that has no answer.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Refusal {
    #[serde(skip_serializing_if = "Option::is_none")]
    id: Option<Id>,
    line: usize,
    error: String,
}

/// The lines of a file of points that are not blank, or the points of a grid.
#[derive(Debug)]
pub(crate) struct Points {
    lines: Vec<(usize, Result<Point, Refusal>)>,
    /// Whether they are a table, which is answered with another and without gradients.
    is_table: bool,
}

impl Points {
    /// Reads a file, or `-` for the standard input, of at most `limit` bytes.
    pub(crate) fn read(file: &Path, limit: u64) -> io::Result<Self> {
        if file != Path::new("-") {
            return Self::parse(&read_file(file, limit)?);
        }
        let mut text = Vec::new();
        io::stdin().lock().take(limit.saturating_add(1)).read_to_end(&mut text)?;
        if text.len() as u64 > limit {
            return Err(io::Error::new(io::ErrorKind::FileTooLarge, format!("more than {limit} bytes: give more with --budget")));
        }
        Self::parse(&text)
    }

    /// Of positions and normals.
    pub(crate) fn of_grid(points: &[(DVec3, DVec3)]) -> Self {
        let point = |(position, normal): &(DVec3, DVec3)| Point::new(position.to_array(), normal.to_array());
        Self { lines: points.iter().enumerate().map(|(line, of)| (line + 1, Ok(point(of)))).collect(), is_table: true }
    }

    /// Whether gradients are asked for.
    pub(crate) const fn wants_gradients(&self) -> bool {
        !self.is_table
    }

    fn parse(text: &[u8]) -> io::Result<Self> {
        let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
        if table::is_table(text) {
            return Ok(Self { lines: table::parse(text)?, is_table: true });
        }
        let lines = text.split(|&byte| byte == b'\n').enumerate().map(|(index, text)| (index + 1, text));
        let point = |(line, text): (usize, &[u8])| {
            let refusal = |error| Refusal { id: Id::find(text), line, error: Error::from(error).to_string() };
            (line, serde_json::from_slice(text).map_err(refusal))
        };
        Ok(Self { lines: lines.filter(|(_, text)| !text.trim_ascii().is_empty()).map(point).collect(), is_table: false })
    }

    /// Positions and normals, of lines that are points.
    pub(crate) fn places(&self) -> impl Iterator<Item = (DVec3, DVec3)> {
        self.lines.iter().filter_map(|(_, point)| point.as_ref().ok()).map(Point::sensor)
    }

    /// Answers every line.
    pub(crate) fn answered(&self, solution: &Solution, photometry: Option<Photometry>) -> Answers<'_> {
        let asked = Asked { gradients: self.wants_gradients(), photometry: photometry.as_ref() };
        let lines = self.lines.par_iter().map(|line| (line.0, answer(solution, line, asked))).collect();
        Answers { lines, points: &self.lines, photometry, is_table: self.is_table }
    }
}

/// What is asked beside irradiance and radiosity.
#[derive(Debug, Clone, Copy)]
struct Asked<'a> {
    gradients: bool,
    photometry: Option<&'a Photometry>,
}

/// The answers, with the numbers of their lines.
pub(crate) struct Answers<'a> {
    lines: Vec<(usize, Result<Answer<'a>, Refusal>)>,
    points: &'a [(usize, Result<Point, Refusal>)],
    photometry: Option<Photometry>,
    is_table: bool,
}

impl Answers<'_> {
    /// How many lines were refused.
    pub(crate) fn refused(&self) -> usize {
        self.lines.iter().filter(|(_, answer)| answer.is_err()).count()
    }

    fn answered(&self) -> impl Iterator<Item = &Answer<'_>> {
        self.lines.iter().filter_map(|(_, answer)| answer.as_ref().ok())
    }

    /// Of a table the least, mean and largest irradiance, a line a channel, or illuminance, and its uniformity: least over mean.
    pub(crate) fn spread(&self, channels: &[String]) -> Vec<String> {
        let count = self.answered().count();
        if !self.is_table || count == 0 {
            return Vec::new();
        }
        let said = |what: &str, of: &dyn Fn(&Answer<'_>) -> f64| {
            let least = self.answered().map(of).fold(f64::INFINITY, smallest);
            let most = self.answered().map(of).fold(0.0, largest);
            let mean = self.answered().map(of).sum::<f64>() / count as f64;
            let mut text = format!("{what} at {count} points: least {least:.4}, mean {mean:.4}, largest {most:.4}");
            if mean > 0.0 {
                let _ = write!(text, ", uniformity {:.3}", least / mean);
            }
            text
        };
        if self.photometry.is_some() {
            return vec![said("illuminance (lux)", &|answer| answer.lit.as_ref().map_or(f64::NAN, |lit| lit.illuminance))];
        }
        let of_channel = |(channel, name): (usize, &String)| {
            let what = if channels.len() == 1 { "irradiance".to_owned() } else { format!("irradiance, {name}") };
            said(&what, &|answer| answer.irradiance[channel])
        };
        channels.iter().enumerate().map(of_channel).collect()
    }

    /// The places of lines that were answered.
    pub(crate) fn places(&self) -> Vec<Place> {
        self.answered().map(|answer| answer.place).collect()
    }

    /// Adds the certificates of [`Self::places`]. Returns a sentence for each that is missing or contradicts its answer.
    pub(crate) fn certify(&mut self, certificates: Vec<Result<PointCertificate, radgrad_certificate::Error>>) -> Vec<String> {
        let answers = self.lines.iter_mut().filter_map(|(line, answer)| Some((*line, answer.as_mut().ok()?)));
        let mut said = Vec::new();
        for ((line, answer), certificate) in answers.zip(certificates) {
            let intervals = match certificate {
                Ok(PointCertificate { radiosity, irradiance, .. }) => radiosity.unwrap_or(irradiance),
                Err(error) => {
                    said.push(format!("line {line}: no certificate: {error}"));
                    continue;
                }
            };
            let of_face = answer.reflected.as_ref().map(|of| (&of.radiosity, &of.estimate));
            let (values, estimates) = of_face.unwrap_or((&answer.irradiance, &answer.irradiance_estimate));
            let each = values.iter().zip(estimates).zip(&intervals);
            for ((value, estimate), interval) in each.filter(|((value, estimate), of)| contradicts(**value, **estimate, of)) {
                let Interval { lower, upper } = interval;
                said.push(format!(
                    "line {line}: {value:.6e} with its estimate {estimate:.1e} contradicts its certificate, from {lower:.6e} to {upper:.6e}: do \
                     not trust it"
                ));
            }
            answer.certified = Some(intervals.iter().map(|of| [of.lower, of.upper]).collect());
        }
        said
    }

    /// As CSV where the points are a table, unless the name of the file says otherwise.
    pub(crate) fn write(&self, channels: &[String], extension: &str, mut output: impl Write) -> io::Result<()> {
        if extension == "csv" || (self.is_table && !matches!(extension, "json" | "jsonl")) {
            return table::write(self, channels, output).map_err(io::Error::from);
        }
        for (_, answer) in &self.lines {
            match answer {
                Ok(answer) => serde_json::to_writer(&mut output, &answer)?,
                Err(refusal) => serde_json::to_writer(&mut output, &refusal)?,
            }
            output.write_all(b"\n")?;
        }
        output.flush()
    }
}

fn answer<'a>(
    solution: &Solution,
    (line, point): &'a (usize, Result<Point, Refusal>),
    asked: Asked<'_>,
) -> Result<Answer<'a>, Refusal> {
    let point = point.as_ref().map_err(Refusal::clone)?;
    let refused = |error: String| Refusal { id: point.id.clone(), line: *line, error };
    let (position, normal) = point.sensor();
    let total = |of: &[Ledger]| of.iter().map(Ledger::total).collect::<Vec<f64>>();
    let on = point.place(solution);
    let vectors = |of: &Gradient| of.gradient.iter().map(DVec3::to_array).collect::<Vec<[f64; 3]>>();
    let in_space = || {
        let slope = asked.gradients.then(|| solution.irradiance_gradient_at(position, normal)).transpose()?;
        Ok((None, solution.irradiance_at(position, normal)?, slope))
    };
    let on_face = || {
        let Gathered { face, radiosity, estimate, irradiance, .. } = solution.gather(position, normal)?;
        let slopes = asked.gradients.then(|| solution.gradient(position, normal)).transpose()?;
        let (slope, of_irradiance) = slopes.map(|of| (of.radiosity, of.irradiance)).unzip();
        let slope = slope.map(|of| FaceSlope { gradient: vectors(&of), gradient_estimate: of.estimate });
        Ok((Some((face, Reflected { radiosity, estimate: total(&estimate), slope })), irradiance, of_irradiance))
    };
    let found: Result<_, radgrad_solver::Error> = if on == On::Free { in_space() } else { on_face() };
    let (reflected, received, slope) = found.map_err(|error| refused(error.to_string()))?;
    let (face, reflected) = reflected.unzip();
    let irradiance_estimate = total(&received.estimate);
    let lit = asked.photometry.map(|photometry| Lit {
        illuminance: photometry.of(&received.irradiance),
        illuminance_estimate: photometry.of(&irradiance_estimate),
    });
    let answer = Answer {
        id: point.id.as_ref(),
        on,
        lit,
        reflected,
        irradiance: received.irradiance,
        irradiance_estimate,
        slope: slope.map(|of| Slope { irradiance_gradient: vectors(&of), irradiance_gradient_estimate: of.estimate }),
        certified: None,
        place: Place { position, normal, face },
    };
    let not_finite = answer.numbers().find(|number| !number.is_finite()).copied();
    match not_finite {
        Some(value) => Err(refused(Error::NotFinite { what: "a number of the answer".to_owned(), value }.to_string())),
        None => Ok(answer),
    }
}

impl<'a> Answer<'a> {
    fn numbers(&'a self) -> impl Iterator<Item = &'a f64> {
        let of_face = self.reflected.iter().flat_map(|of| {
            let slope = of.slope.iter().flat_map(|of| of.gradient.as_flattened().iter().chain(&of.gradient_estimate));
            of.radiosity.iter().chain(&of.estimate).chain(slope)
        });
        let slope =
            self.slope.iter().flat_map(|of| of.irradiance_gradient.as_flattened().iter().chain(&of.irradiance_gradient_estimate));
        let lit = self.lit.iter().flat_map(|lit| [&lit.illuminance, &lit.illuminance_estimate]);
        of_face.chain(&self.irradiance).chain(&self.irradiance_estimate).chain(slope).chain(lit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bad_line_costs_itself_only() {
        let text = b"\xef\xbb\xbf{\"position\":[0,0,0],\"normal\":[0,0,1]}\r\n\xff\xfe\n \r\n{\"id\":\"b\",\"position\":[0,0,0],\"norml\":[0,0,1]}\n\
            {\"position\":[0,0,1],\"normal\":[0,0,1],\"comment\":\"c\"}";
        let Points { lines, .. } = Points::parse(text).unwrap();
        assert_eq!(
            lines.iter().map(|(line, point)| (*line, point.is_ok())).collect::<Vec<_>>(),
            [(1, true), (2, false), (4, false), (5, true)]
        );
        let refusal = lines[2].1.as_ref().unwrap_err();
        assert_eq!(refusal.id, Some(Id::from("b")));
        assert!(refusal.error.contains("no field `norml`: did you mean `normal`?"), "{}", refusal.error);
    }
}
