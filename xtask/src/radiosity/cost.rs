//! The cost of a solution by the number of polygons, in two kinds of scenes that grow by more of the same: the surroundings that
//! any place sees well stay the same. Far or hidden elements are taken together, and links are nearly in proportion to the
//! polygons.
//!
//! - a city: high blocks on tiles of the ground, under a sky of tiles that glow, open to the sides;
//! - a house: rooms on one floor, with doors between them, a box in each, and ceilings that glow.
//!
//! One round of constant elements, links and clusters refined to the same part of the mean radiosity that is reflected.

use std::error::Error;
use std::time::Instant;

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::Scene;
use radgrad_solver::{Options, solve};

use super::graph::{Graph, Series};
use super::squares::Quad;

/// The kind of a growing scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    City,
    House,
}

impl Kind {
    pub(super) const ALL: [Self; 2] = [Self::City, Self::House];

    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::City => "city",
            Self::House => "house",
        }
    }
}

/// A scene.
pub(super) struct Point {
    kind: Kind,
    polygons: usize,
    seconds: f64,
    elements: usize,
    links: usize,
    estimate: f64,
}

impl Point {
    pub(super) fn record(&self) -> Vec<String> {
        let [polygons, elements, links] = [self.polygons, self.elements, self.links].map(|n| n.to_string());
        let (seconds, estimate) = (format!("{:.3}", self.seconds), format!("{:.3}", self.estimate));
        vec![self.kind.name().to_owned(), polygons, seconds, elements, links, estimate]
    }
}

/// Error asked for; the first round refines links to a tenth of it.
const ERROR: f64 = 1.0;

/// Sides in blocks or rooms, of which those are taken that give few enough polygons.
const SIDES: [usize; 8] = [3, 4, 6, 8, 11, 18, 25, 40];

/// Blocks along a side of a tile of the city's sky.
const SKY: usize = 3;

/// Height of that.
const SKY_HEIGHT: f64 = 2.5;

/// Elements from which on the solver links to clusters too: before, links grow with the square of the visible elements.
const CLUSTERED: usize = 1000;

/// Polygons of the smallest scene.
const LEAST: usize = 100;

pub(super) fn measure(most: usize) -> Result<Vec<Point>, Box<dyn Error>> {
    let mut points = Vec::new();
    for kind in Kind::ALL {
        for side in SIDES {
            let scene = scene(kind, side)?;
            if !(LEAST..=most).contains(&scene.faces().len()) {
                continue;
            }
            let options = Options { error: ERROR, degree: Some(0), first_elements: 1, most_elements: 1, ..Options::default() };
            let start = Instant::now();
            let solution = solve(&scene, &options, |_| true)?;
            let (seconds, progress) = (start.elapsed().as_secs_f64(), solution.progress());
            let (polygons, elements) = (scene.faces().len(), progress.elements);
            let (links, estimate) = (progress.links, progress.estimate);
            println!(
                "{}, {polygons} polygons: {seconds:.2} s, {elements} elements, {links} links, estimate {:.0} %",
                kind.name(),
                100.0 * estimate
            );
            points.push(Point { kind, polygons, seconds, elements, links, estimate });
        }
    }
    Ok(points)
}

/// A scene of about `side * side` blocks or rooms.
fn scene(kind: Kind, side: usize) -> Result<Scene, Box<dyn Error>> {
    let mut scene = Scene::new(["grey"])?;
    let (white, surface) = (scene.add_material("white", [0.6], [0.0])?, scene.add_surface("all"));
    let lamp = scene.add_material("lamp", [0.6], [1.0])?;
    let (surfaces, lamps) = match kind {
        Kind::City => city(side),
        Kind::House => house(side),
    };
    for (quads, material) in [(surfaces, white), (lamps, lamp)] {
        for quad in quads {
            scene.add_face(surface, material, Polygon::new(quad.map(DVec3::from).to_vec())?, None)?;
        }
    }
    Ok(scene)
}

/// Faces up.
fn level([a, c]: [f64; 2], [b, d]: [f64; 2], height: f64) -> Quad {
    [[a, c, height], [b, c, height], [b, d, height], [a, d, height]]
}

/// Upright, and faces to the right of the way from one to the other.
const fn wall([p, q]: [f64; 2], [r, s]: [f64; 2], height: f64) -> Quad {
    [[p, q, 0.0], [r, s, 0.0], [r, s, height], [p, q, height]]
}

fn reversed([a, b, c, d]: Quad) -> Quad {
    [a, d, c, b]
}

/// The sides and the top of a box that stands on the ground.
fn block([a, c]: [f64; 2], [b, d]: [f64; 2], height: f64) -> [Quad; 5] {
    let sides = [[[a, c], [b, c]], [[b, c], [b, d]], [[b, d], [a, d]], [[a, d], [a, c]]].map(|[p, q]| wall(p, q, height));
    [sides[0], sides[1], sides[2], sides[3], level([a, c], [b, d], height)]
}

/// A number from 0 to 1 that does not repeat along a row.
fn scattered(index: usize) -> f64 {
    (0.618_033_988_749_894_9 * index as f64).fract()
}

fn city(side: usize) -> (Vec<Quad>, Vec<Quad>) {
    let (mut surfaces, mut lamps) = (Vec::new(), Vec::new());
    for i in 0..side {
        for j in 0..side {
            let (x, y) = (i as f64, j as f64);
            surfaces.push(level([x, y], [x + 1.0, y + 1.0], 0.0));
            surfaces.extend(block([x + 0.2, y + 0.2], [x + 0.8, y + 0.8], 1.2 + 0.8 * scattered(i * side + j)));
            if i % SKY == 0 && j % SKY == 0 {
                let end = |from: usize| (from + SKY).min(side) as f64;
                lamps.push(reversed(level([x, y], [end(i), end(j)], SKY_HEIGHT)));
            }
        }
    }
    (surfaces, lamps)
}

/// A city as OBJ whose faces are seen from inside and leave no gap: the ground is cut out under the blocks, and walls stand around it
/// up to the sky.
pub(super) fn closed_city(side: usize) -> String {
    let (surfaces, sky) = city(side);
    let is_ground = |quad: &Quad| quad.iter().all(|corner| corner[2] == 0.0);
    let mut quads: Vec<Quad> = surfaces.into_iter().filter(|quad| !is_ground(quad)).chain(sky).collect();
    for (i, j) in (0..side).flat_map(|i| (0..side).map(move |j| (i, j))) {
        let ([x, y], [u, v]) = ([i as f64, j as f64], [(i + 1) as f64, (j + 1) as f64]);
        let ([a, c], [b, d]) = ([x + 0.2, y + 0.2], [x + 0.8, y + 0.8]);
        quads.extend([([x, y], [u, c]), ([x, d], [u, v]), ([x, c], [a, d]), ([b, c], [u, d])].map(|(p, q)| level(p, q, 0.0)));
    }
    let end = side as f64;
    for k in 0..side {
        let (k, next) = (k as f64, (k + 1) as f64);
        let around = [[[next, 0.0], [k, 0.0]], [[end, next], [end, k]], [[k, end], [next, end]], [[0.0, k], [0.0, next]]];
        quads.extend(around.map(|[p, q]| wall(p, q, SKY_HEIGHT)));
    }
    let mut text = String::new();
    for [x, y, z] in quads.iter().flatten() {
        text += &format!("v {x} {y} {z}\n");
    }
    for first in (1..=4 * quads.len()).step_by(4) {
        text += &format!("f {first} {} {} {}\n", first + 1, first + 2, first + 3);
    }
    text
}

fn house(side: usize) -> (Vec<Quad>, Vec<Quad>) {
    let (mut surfaces, mut lamps) = (Vec::new(), Vec::new());
    let height = 0.8;
    for i in 0..=side {
        for j in 0..=side {
            let (x, y) = (i as f64, j as f64);
            // Doors are not in a row.
            let door = |index: usize| 0.1 + 0.6 * scattered(index);
            // Walls at the low sides of the room, with a door unless they are the house's own.
            let mut add = |along: bool, inner: bool, index: usize| {
                let point = |t: f64| if along { [x + t, y] } else { [x, y + t] };
                let parts = if inner { vec![[0.0, door(index)], [door(index) + 0.2, 1.0]] } else { vec![[0.0, 1.0]] };
                for [from, to] in parts {
                    let one = wall(point(from), point(to), height);
                    surfaces.extend([one, reversed(one)]);
                }
            };
            if i < side {
                add(true, j > 0 && j < side, 2 * (i * side + j));
            }
            if j < side {
                add(false, i > 0 && i < side, 2 * (i * side + j) + 1);
            }
            if i < side && j < side {
                let place = 0.15 + 0.3 * scattered(3 * (i * side + j));
                surfaces.push(level([x, y], [x + 1.0, y + 1.0], 0.0));
                surfaces.extend(block([x + place, y + 0.3], [x + place + 0.3, y + 0.6], 0.3));
                lamps.push(reversed(level([x, y], [x + 1.0, y + 1.0], height)));
            }
        }
    }
    (surfaces, lamps)
}

/// The powers of the number of polygons that links grow with, over all scenes of a kind and over those with clusters, if there are
/// two at least.
pub(super) fn exponents(kind: Kind, points: &[Point]) -> Vec<(&'static str, f64)> {
    let over = |(scenes, least): (&'static str, usize)| {
        let chosen = points.iter().filter(|p| p.kind == kind && p.elements >= least);
        slope(&chosen.map(|p| [p.polygons, p.links].map(|n| (n as f64).ln())).collect::<Vec<_>>()).map(|slope| (scenes, slope))
    };
    [("all scenes", 0), ("scenes with clusters", CLUSTERED)].into_iter().filter_map(over).collect()
}

/// Slope of the line through points that leaves the least squares.
fn slope(points: &[[f64; 2]]) -> Option<f64> {
    let mean = |axis: usize| points.iter().map(|p| p[axis]).sum::<f64>() / points.len() as f64;
    let (x, y) = (mean(0), mean(1));
    let along: f64 = points.iter().map(|p| (p[0] - x).powi(2)).sum();
    (points.len() > 1).then(|| points.iter().map(|p| (p[0] - x) * (p[1] - y)).sum::<f64>() / along)
}

pub(super) fn graph(points: &[Point]) -> Graph {
    let line = |kind: Kind, name: &str, colour: usize, value: fn(&Point) -> f64| Series {
        name: format!("{name}, {}", kind.name()),
        points: points.iter().filter(|p| p.kind == kind).map(|p| (p.polygons as f64, value(p))).collect(),
        colour,
        dashed: kind == Kind::House,
    };
    let lines = |kind: Kind| {
        [
            line(kind, "links", 3, |p| p.links as f64),
            line(kind, "elements", 1, |p| p.elements as f64),
            line(kind, "seconds", 2, |p| p.seconds),
        ]
    };
    Graph {
        title: "Cost of a round by the number of polygons".to_owned(),
        under: "Constant elements; links and clusters neglect at most 10 % of the mean radiosity.".to_owned(),
        across: "polygons",
        upward: "seconds, or numbers",
        counts: false,
        series: Kind::ALL.into_iter().flat_map(lines).collect(),
    }
}
