//! What a solution costs by the number of polygons: blocks of different heights on a floor under a lamp, 5 faces each, all of them
//! in each other's way.
//!
//! One round of constant elements, links refined to half of the mean radiosity. A face is linked to every face that it sees, there
//! being no clusters of faces: links grow with the square of the number of polygons, as far as blocks do not hide each other.

use std::error::Error;
use std::time::Instant;

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::Scene;
use radgrad_solver::{Options, solve};

use super::graph::{Graph, Series};

/// A scene.
pub(super) struct Point {
    polygons: usize,
    seconds: f64,
    elements: usize,
    links: usize,
    bound: f64,
}

impl Point {
    pub(super) fn record(&self) -> Vec<String> {
        let whole = [self.elements, self.links].map(|n| n.to_string());
        let [elements, links] = whole;
        vec![self.polygons.to_string(), format!("{:.3}", self.seconds), elements, links, format!("{:.3}", self.bound)]
    }
}

pub(super) fn measure(most: usize) -> Result<Vec<Point>, Box<dyn Error>> {
    let sides = [2, 3, 4, 6, 9, 13, 19, 28, 44];
    let mut points = Vec::new();
    for side in sides.into_iter().filter(|&side| polygons(side) <= most) {
        let scene = blocks(side)?;
        let options = Options { error: 0.5, degree: Some(0), first_elements: 1, most_elements: 1, ..Options::default() };
        let start = Instant::now();
        let solution = solve(&scene, &options, |_| true)?;
        let (seconds, progress) = (start.elapsed().as_secs_f64(), solution.progress());
        println!("{} polygons: {seconds:.2} s, {} links", scene.faces().len(), progress.links);
        let (elements, links, bound) = (progress.elements, progress.links, progress.bound);
        points.push(Point { polygons: scene.faces().len(), seconds, elements, links, bound });
    }
    Ok(points)
}

const fn polygons(side: usize) -> usize {
    5 * side * side + 2
}

fn blocks(side: usize) -> Result<Scene, Box<dyn Error>> {
    let mut scene = Scene::new(["grey"])?;
    let (white, surface) = (scene.add_material("white", [0.6], [0.0])?, scene.add_surface("all"));
    let lamp = scene.add_material("lamp", [0.0], [1.0])?;
    let extent = side as f64;
    let mut add = |material: usize, corners: [[f64; 3]; 4]| -> Result<(), Box<dyn Error>> {
        scene.add_face(surface, material, Polygon::new(corners.map(DVec3::from).to_vec())?, None)?;
        Ok(())
    };
    add(white, [[0.0, 0.0, 0.0], [extent, 0.0, 0.0], [extent, extent, 0.0], [0.0, extent, 0.0]])?;
    let above = 3.0;
    add(lamp, [[0.0, 0.0, above], [0.0, extent, above], [extent, extent, above], [extent, 0.0, above]])?;
    for i in 0..side {
        for j in 0..side {
            // Heights from 0.3 to 1.3 that do not repeat along a row.
            let height = 0.3 + (0.618_033_988_749_894_9 * (i * side + j) as f64).fract();
            let [a, b] = [i as f64 + 0.2, i as f64 + 0.8];
            let [c, d] = [j as f64 + 0.2, j as f64 + 0.8];
            add(white, [[a, c, height], [b, c, height], [b, d, height], [a, d, height]])?;
            for [[x0, y0], [x1, y1]] in [[[a, c], [b, c]], [[b, c], [b, d]], [[b, d], [a, d]], [[a, d], [a, c]]] {
                add(white, [[x0, y0, 0.0], [x1, y1, 0.0], [x1, y1, height], [x0, y0, height]])?;
            }
        }
    }
    Ok(scene)
}

pub(super) fn graph(points: &[Point]) -> Graph {
    let line = |name: &str, colour: usize, value: &dyn Fn(&Point) -> f64| Series {
        name: name.to_owned(),
        points: points.iter().map(|p| (p.polygons as f64, value(p))).collect(),
        colour,
        dashed: false,
    };
    Graph {
        title: "Cost of a round by the number of polygons".to_owned(),
        under: "Blocks on a floor under a lamp; constant elements, links refined to half of the mean radiosity.".to_owned(),
        across: "polygons",
        upward: "seconds, or numbers",
        counts: false,
        series: vec![
            line("seconds", 2, &|p| p.seconds),
            line("elements", 1, &|p| p.elements as f64),
            line("links", 3, &|p| p.links as f64),
        ],
    }
}
