//! A receiver's view of an emitter past an occluder, above its horizon: the arcs around the visible part, each by the line that
//! generates it.
//!
//! Drawn as W. Nusselt (1928) has it: directions on the unit hemisphere over the receiver, seen along its normal. The visible area,
//! over that of the disc, is the form factor; the rim is the horizon. The arcs are found here on their own, and their sum `-(rho
//! B2/2 pi) sum g (n1.N)` (HS95, appendix A.1) is held against the answer of the library.

use std::error::Error;
use std::f64::consts::PI;

use radgrad_core::{Answer, DVec3, Emission, Emitter, Polygon, Receiver, evaluate};

use super::convex::{Point, clipped};
use super::sketch::Geometry;
use super::svg::{Anchor, Svg, around, through};
use super::table::{Cell, Table};

/// The emitter, lit downward; it emits 1.
const LAMP: [DVec3; 4] =
    [DVec3::new(-1.2, -0.9, 1.0), DVec3::new(-1.2, 1.1, 1.0), DVec3::new(1.3, 1.1, 1.0), DVec3::new(1.3, -0.9, 1.0)];
const SCREEN: [DVec3; 3] = [DVec3::new(0.05, -0.3, 0.5), DVec3::new(0.6, 0.0, 0.5), DVec3::new(0.25, 0.75, 0.5)];
/// The receiver's normal; it is in the origin.
const NORMAL: DVec3 = DVec3::new(0.8, 0.25, 0.55);

/// The line that generates an arc.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Line {
    Emitter(usize),
    Occluder(usize),
    Horizon,
}

impl Line {
    fn name(self) -> String {
        match self {
            Self::Emitter(edge) => format!("emitter, edge {}", edge + 1),
            Self::Occluder(edge) => format!("occluder, edge {}", edge + 1),
            Self::Horizon => "horizon".to_owned(),
        }
    }

    const fn class(self) -> &'static str {
        match self {
            Self::Emitter(_) => "by-emitter",
            Self::Occluder(_) => "by-occluder",
            Self::Horizon => "by-horizon",
        }
    }
}

/// A piece of the boundary of the visible part, between two unit directions.
#[derive(Debug, Clone, Copy)]
struct Arc {
    line: Line,
    from: DVec3,
    to: DVec3,
    /// The generating edge; none of the horizon.
    edge: Option<[DVec3; 2]>,
}

impl Arc {
    fn angle(&self) -> f64 {
        libm::atan2(self.from.cross(self.to).length(), self.from.dot(self.to))
    }

    /// Its part of the radiosity, with `rho = 1` and unit emission.
    fn value(&self, normal: DVec3) -> f64 {
        -self.angle() * normal.dot(self.from.cross(self.to).normalize()) / (2.0 * PI)
    }

    /// Its part of the gradient: `s (e x (M n1)) / (pi |w|)`, `M` the integral of `omega omega^T` over the arc.
    fn gradient(&self, normal: DVec3) -> DVec3 {
        let Some([a, b]) = self.edge else { return DVec3::ZERO };
        let (g, e) = (self.angle(), b - a);
        let (middle, along) = ((self.from + self.to).normalize(), (self.to - self.from).normalize());
        let [wide, slim] = [g + libm::sin(g), g - libm::sin(g)].map(|x| x / 2.0);
        let m = middle * (wide * middle.dot(normal)) + along * (slim * along.dot(normal));
        let w = a.cross(e);
        e.cross(m) * (w.dot(self.from.cross(self.to)).signum() / (PI * w.length()))
    }

    /// A direction between its ends, at a fraction of its angle.
    fn interpolate(&self, t: f64) -> DVec3 {
        let g = self.angle();
        (self.from * libm::sin((1.0 - t) * g) + self.to * libm::sin(t * g)) / libm::sin(g)
    }
}

/// The arcs of the boundary, those of the emitter first.
fn arcs(normal: DVec3) -> Vec<Arc> {
    let lamp_middle = LAMP.iter().sum::<DVec3>();
    let screen_middle = SCREEN.iter().sum::<DVec3>();
    let above = |p: DVec3| normal.dot(p);
    // Planes through the receiver and an edge, as linear functions that are positive on the side of `within`.
    let sides = |corners: &'static [DVec3], within: DVec3| {
        (0..corners.len()).map(move |i| {
            let plane = corners[i].cross(corners[(i + 1) % corners.len()]);
            plane * plane.dot(within).signum()
        })
    };
    let in_screen: Vec<DVec3> = sides(&SCREEN, screen_middle).collect();
    let in_lamp: Vec<DVec3> = sides(&LAMP, lamp_middle).collect();
    let edges = |corners: &'static [DVec3]| (0..corners.len()).map(move |i| [corners[i], corners[(i + 1) % corners.len()]]);
    let mut arcs = Vec::new();
    let mut add = |line, [a, b]: [DVec3; 2], parts: Vec<[f64; 2]>, edge| {
        arcs.extend(parts.into_iter().map(|[s, t]| Arc {
            line,
            from: a.lerp(b, s).normalize(),
            to: a.lerp(b, t).normalize(),
            edge,
        }));
    };
    for (index, edge) in edges(&LAMP).enumerate() {
        let whole = cut([0.0, 1.0], edge, &[normal]);
        add(Line::Emitter(index), edge, without(whole, edge, &in_screen), Some(edge));
    }
    for (index, edge) in edges(&SCREEN).enumerate() {
        // The visible part is on the other side: the arc runs such that the occluder is where N.omega > 0.
        let [a, b] = edge;
        let edge = if a.cross(b).dot(screen_middle) > 0.0 { edge } else { [b, a] };
        let planes: Vec<DVec3> = in_lamp.iter().copied().chain([normal]).collect();
        add(Line::Occluder(index), edge, cut([0.0, 1.0], edge, &planes).into_iter().collect(), Some(edge));
    }
    let rim = clipped(&LAMP, |p| above(*p), |p, q, t| p.lerp(q, t));
    let on_rim: Vec<DVec3> = rim.into_iter().filter(|p| above(*p).abs() < 1e-12).collect();
    if let [a, b] = on_rim[..] {
        let ends = if a.cross(b).dot(normal) < 0.0 { [a, b] } else { [b, a] };
        add(Line::Horizon, ends, without(Some([0.0, 1.0]), ends, &in_screen), None);
    }
    arcs
}

/// The part of a stretch of the line from `a` to `b` that is on the positive side of all planes through the receiver.
fn cut(stretch: [f64; 2], [a, b]: [DVec3; 2], planes: &[DVec3]) -> Option<[f64; 2]> {
    let mut stretch = Some(stretch);
    for plane in planes {
        let [fa, fb] = [plane.dot(a), plane.dot(b)];
        let root = fa / (fa - fb);
        stretch = stretch.map(|[s, t]| if fa < fb { [s.max(root), t] } else { [s, t.min(root)] }).filter(|[s, t]| s < t);
    }
    stretch
}

/// The parts of a stretch that are outside a convex cone.
fn without(stretch: Option<[f64; 2]>, line: [DVec3; 2], cone: &[DVec3]) -> Vec<[f64; 2]> {
    let Some([s, t]) = stretch else { return Vec::new() };
    match cut([s, t], line, cone) {
        None => vec![[s, t]],
        Some([from, to]) => [[s, from], [to, t]].into_iter().filter(|[s, t]| s < t).collect(),
    }
}

/// The parts of it that are shown.
#[derive(Clone)]
pub(super) struct Sight {
    /// The hemisphere, and the scene.
    pub(super) pictures: [String; 2],
    pub(super) arcs: Table,
    /// The sum of the arcs, beside the certified answer.
    pub(super) told: String,
    /// `sight.csv`.
    pub(super) csv: Vec<u8>,
}

/// The scene: receiver, lamp, occluder.
fn scene() -> Result<(Receiver, Emitter, Polygon), radgrad_core::Error> {
    let lamp = Emitter::new(Polygon::new(LAMP.to_vec())?, Emission::Constant(1.0))?;
    Ok((Receiver::new(DVec3::ZERO, NORMAL, 1.0)?, lamp, Polygon::new(SCREEN.to_vec())?))
}

pub(super) fn sight() -> Result<Sight, Box<dyn Error>> {
    let (receiver, lamp, screen) = scene()?;
    let normal = receiver.normal();
    let arcs = arcs(normal);
    let answer = evaluate(&receiver, &lamp, std::slice::from_ref(&screen))?;
    let geometry = Geometry::of_scene(&receiver, &lamp, &[screen]);
    Ok(Sight {
        pictures: [
            hemisphere(&arcs, normal, answer.radiosity),
            geometry.draw("The scene: a lamp, a triangle in front of it, and a tilted receiver"),
        ],
        arcs: table(&arcs, normal),
        told: told(&arcs, normal, &answer),
        csv: csv(&arcs, normal)?,
    })
}

fn told(arcs: &[Arc], normal: DVec3, answer: &Answer) -> String {
    let value: f64 = arcs.iter().map(|arc| arc.value(normal)).sum();
    format!(
        "{} arcs; their parts sum to {value:.12}. The certified answer is {:.12}, with a bound of {:.0e} on its error.",
        arcs.len(),
        answer.radiosity,
        answer.radiosity_error
    )
}

/// The disc: lamp, occluder and the arcs of the visible part.
fn hemisphere(arcs: &[Arc], normal: DVec3, form_factor: f64) -> String {
    const SIZE: (f64, f64) = (420.0, 400.0);
    const CENTRE: (f64, f64) = (208.0, 206.0);
    const RADIUS: f64 = 168.0;
    let across = normal.any_orthonormal_vector();
    let up = normal.cross(across);
    // The sheet is turned so that the lamp is above the middle; seen from over the receiver, right is -across.
    let place = |d: DVec3| (CENTRE.0 - RADIUS * d.dot(across), CENTRE.1 - RADIUS * d.dot(up));
    let outline = |corners: &[DVec3]| -> Vec<Point> {
        let corners = clipped(corners, |p| normal.dot(*p), |p, q, t| p.lerp(q, t));
        let arc = |i: usize| Arc {
            line: Line::Horizon,
            from: corners[i].normalize(),
            to: corners[(i + 1) % corners.len()].normalize(),
            edge: None,
        };
        (0..corners.len()).flat_map(|i| (0..24).map(move |k| place(arc(i).interpolate(f64::from(k) / 24.0)))).collect()
    };
    let mut svg = Svg::new(SIZE.0, SIZE.1);
    svg.text("title", (16.0, 18.0), Anchor::Start, "I   What the receiver sees");
    svg.circle("sky", CENTRE, RADIUS);
    for part in [1.0 / 3.0, 2.0 / 3.0] {
        // Circles of equal angle from the normal: 30 and 60 degrees.
        svg.circle("graticule", CENTRE, RADIUS * libm::sin(part * PI / 2.0));
    }
    svg.path("seen", &around(&outline(&LAMP)));
    svg.path("hidden", &around(&outline(&SCREEN)));
    for arc in arcs {
        let points: Vec<Point> = (0..=32).map(|k| place(arc.interpolate(f64::from(k) / 32.0))).collect();
        svg.path(arc.line.class(), &through(&points));
        svg.circle("end", place(arc.from), 2.4);
        svg.circle("end", place(arc.to), 2.4);
    }
    svg.circle("point", CENTRE, 2.2);
    svg.text("tick", (CENTRE.0, CENTRE.1 + 14.0), Anchor::Middle, "normal");
    for (part, label) in [(1.0 / 3.0, "30"), (2.0 / 3.0, "60"), (1.0, "90")] {
        let reach = RADIUS * libm::sin(part * PI / 2.0);
        svg.text("tick", (CENTRE.0 + 0.5 * reach + 2.0, CENTRE.1 + 0.866 * reach + 11.0), Anchor::Start, label);
    }
    svg.text("label", (SIZE.0 / 2.0 - 2.0, SIZE.1 - 6.0), Anchor::Middle, "circles: angle from the normal (degrees)");
    svg.finish(
        "plot",
        "Figure I: the visible part of the emitter on the unit hemisphere",
        &format!(
            "A lamp cut by the horizon and partly hidden by a triangle; {} arcs bound what is seen, generated by emitter edges, \
             occluder edges and the horizon. The form factor is {form_factor:.4}.",
            arcs.len()
        ),
    )
}

/// Lines of the three kinds with their names.
pub(super) fn legend() -> String {
    [
        (Line::Emitter(0), "generated by an edge of the emitter"),
        (Line::Occluder(0), "by an edge of the occluder"),
        (Line::Horizon, "by the horizon"),
    ]
    .map(|(line, name)| {
        let mut svg = Svg::new(28.0, 12.0);
        svg.line(line.class(), (2.0, 6.0), (26.0, 6.0));
        format!("<span class=\"key\">{} {name}</span>", svg.finish("swatch", name, "line of the legend"))
    })
    .concat()
}

fn table(arcs: &[Arc], normal: DVec3) -> Table {
    let titles = ["generating line", "#angle (rad)", "#part of the form factor", "#part of dB/dx (1/m)", "#dB/dy", "#dB/dz"];
    let mut table = Table::new("The arcs of figure I and what each gives", &["sight.csv"], &titles);
    for arc in arcs {
        let numbers = [arc.angle(), arc.value(normal)].into_iter().chain(arc.gradient(normal).to_array());
        let cells = numbers.map(|x| Cell::from(&format!("{x:.6}").replace('-', "−")).by(x));
        table.push([Cell::from(&arc.line.name())].into_iter().chain(cells));
    }
    table
}

/// `line,angle,value,dx,dy,dz` and the unit directions of both ends.
fn csv(arcs: &[Arc], normal: DVec3) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut rows = csv::Writer::from_writer(Vec::new());
    rows.write_record(["line", "angle", "value", "dx", "dy", "dz", "from-x", "from-y", "from-z", "to-x", "to-y", "to-z"])?;
    for arc in arcs {
        let numbers = [arc.angle(), arc.value(normal)].into_iter().chain(arc.gradient(normal).to_array());
        let ends = arc.from.to_array().into_iter().chain(arc.to.to_array());
        rows.write_record([arc.line.name()].into_iter().chain(numbers.chain(ends).map(|x| format!("{x:.12}"))))?;
    }
    Ok(rows.into_inner()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_arcs_sum_to_the_certified_answer_and_every_kind_of_line_is_among_them() {
        let (receiver, lamp, screen) = scene().unwrap();
        let (normal, answer) = (receiver.normal(), evaluate(&receiver, &lamp, &[screen]).unwrap());
        let arcs = arcs(normal);
        let value: f64 = arcs.iter().map(|arc| arc.value(normal)).sum();
        let gradient: DVec3 = arcs.iter().map(|arc| arc.gradient(normal)).sum();
        assert!((value - answer.radiosity).abs() < 1e-14 + answer.radiosity_error, "{value} {answer:?}");
        assert!((gradient - answer.gradient).length() < 1e-13 + answer.gradient_error, "{gradient} {answer:?}");
        for kind in ["by-emitter", "by-occluder", "by-horizon"] {
            assert!(arcs.iter().any(|arc| arc.line.class() == kind), "{kind}: {arcs:?}");
        }
    }
}
