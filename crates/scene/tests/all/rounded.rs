//! Closed boxes in files whose coordinates are rounded: the factors of the exact boxes, and no face sees its own wall.

use std::collections::HashMap;
use std::fmt::Write;
use std::io;
use std::path::Path;

use radgrad_core::{DMat3, DVec3};
use radgrad_scene::{FactorMatrix, FactorSettings, FormFactors, Materials, Note, Reading, Scene, largest, obj, smallest};
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

/// How coordinates are written.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Rounding {
    Not,
    Single,
    SixDecimals,
    Millimetres,
}

impl Rounding {
    #[expect(clippy::cast_possible_truncation, reason = "rounding is meant")]
    fn text(self, x: f64) -> String {
        match self {
            Self::Not => format!("{x:?}"),
            Self::Single => (x as f32).to_string(),
            Self::SixDecimals => format!("{x:.6}"),
            Self::Millimetres => format!("{x:.3}"),
        }
    }

    fn unit(self, largest: f64) -> f64 {
        match self {
            Self::Not => 0.0,
            Self::Single => largest / 16_777_216.0,
            Self::SixDecimals => 5e-7,
            Self::Millimetres => 5e-4,
        }
    }
}

/// A wall of these sides in parts: whole, with vertices where nothing ends, in rectangles, in triangles, or with a needle.
fn parts(random: &mut ChaCha8Rng, [width, height]: [f64; 2]) -> Vec<Vec<[f64; 2]>> {
    let mut share = || random.random_range(0.05..0.95);
    let (a, b, c, d) = (share() * width, share() * height, share() * width, share() * height);
    let needle = 10_f64.powf(-1.5 - 1.5 * share());
    match random.random_range(0..5) {
        0 => vec![vec![[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]]],
        1 => {
            let low = smallest(b, d);
            vec![vec![[0.0, 0.0], [a, 0.0], [width, 0.0], [width, low], [width, height], [c, height], [0.0, height]]]
        }
        2 => {
            let rectangle = |x: [f64; 2], y: [f64; 2]| vec![[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]];
            let cuts = [rectangle([0.0, a], [0.0, b]), rectangle([0.0, a], [b, height]), rectangle([a, width], [0.0, d])];
            cuts.into_iter().chain([rectangle([a, width], [d, height])]).collect()
        }
        3 => vec![
            vec![[0.0, 0.0], [a, 0.0], [0.0, height]],
            vec![[a, 0.0], [width, 0.0], [width, height]],
            vec![[a, 0.0], [width, height], [0.0, height]],
        ],
        _ => vec![
            vec![[0.0, 0.0], [width, 0.0], [a, needle]],
            vec![[0.0, 0.0], [a, needle], [0.0, height]],
            vec![[a, needle], [width, 0.0], [width, height]],
            vec![[a, needle], [width, height], [0.0, height]],
        ],
    }
}

/// The parts of the walls of a box, each with the number of its wall, seen from inside.
fn walls(random: &mut ChaCha8Rng) -> Vec<(usize, Vec<DVec3>)> {
    let size = [(); 3].map(|()| random.random_range(1.0..6.0));
    let mut faces = Vec::new();
    for (wall, (axis, far)) in [0, 1, 2].into_iter().flat_map(|axis| [(axis, false), (axis, true)]).enumerate() {
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        let [u, v] = if far { [v, u] } else { [u, v] };
        let place = |[a, b]: [f64; 2]| {
            let mut point = [0.0; 3];
            (point[axis], point[u], point[v]) = (if far { size[axis] } else { 0.0 }, a, b);
            DVec3::from(point)
        };
        faces.extend(parts(random, [size[u], size[v]]).into_iter().map(|part| (wall, part.into_iter().map(place).collect())));
    }
    faces
}

fn file(faces: &[(usize, Vec<DVec3>)], place: impl Fn(DVec3) -> DVec3, rounding: Rounding) -> (String, f64) {
    let (mut text, mut farthest, mut count) = (String::new(), 0.0, 0);
    for (index, (_, vertices)) in faces.iter().enumerate() {
        for vertex in vertices.iter().map(|&vertex| place(vertex)) {
            farthest = largest(farthest, vertex.abs().max_element());
            let [x, y, z] = vertex.to_array().map(|x| rounding.text(x));
            writeln!(text, "v {x} {y} {z}").unwrap();
        }
        let places: Vec<String> = (1..=vertices.len()).map(|i| (count + i).to_string()).collect();
        writeln!(text, "g {index}\nf {}", places.join(" ")).unwrap();
        count += vertices.len();
    }
    (text, rounding.unit(farthest))
}

fn read(text: &str) -> Scene {
    let reading = Reading { materials: Materials::Optional, ..Reading::default() };
    let none = |_: &Path| Err(io::Error::from(io::ErrorKind::NotFound));
    obj::parse(text.as_bytes(), Path::new("box.obj"), reading, none).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Factors by the names of surfaces, which are the numbers of faces in the file.
fn factors(scene: &Scene) -> (FactorMatrix, HashMap<[usize; 2], (f64, f64)>) {
    let matrix = FormFactors::new(scene).unwrap().matrix(&FactorSettings::default(), || ()).unwrap();
    let name = |face: usize| scene.surfaces()[scene.faces()[face].surface()].name().parse::<usize>().unwrap();
    let named = matrix.entries().map(|(from, entry)| ([name(from), name(entry.face)], (entry.factor, entry.error))).collect();
    (matrix, named)
}

#[test]
fn boxes_in_files_have_the_factors_of_the_boxes_that_they_were_rounded_from() {
    let count: u64 = std::env::var("RADGRAD_BOXES").map_or(12, |count| count.parse().unwrap());
    let (mut healed, mut thin) = (0, 0);
    for seed in 0..count {
        let random = &mut ChaCha8Rng::seed_from_u64(seed);
        let faces = walls(random);
        let exact = read(&file(&faces, |vertex| vertex, Rounding::Not).0);
        let (_, truth) = factors(&exact);
        let axis = DVec3::new(random.random_range(-1.0..1.0), random.random_range(-1.0..1.0), 1.0).normalize();
        let turn = DMat3::from_axis_angle(axis, random.random_range(0.0..6.0));
        let reach = 10_f64.powf(random.random_range(-1.0..4.0));
        let shift = DVec3::from([(); 3].map(|()| random.random_range(-reach..reach)));
        for rounding in [Rounding::Not, Rounding::Single, Rounding::SixDecimals, Rounding::Millimetres] {
            let (text, unit) = file(&faces, |vertex| turn * vertex + shift, rounding);
            let scene = read(&text);
            let (matrix, found) = factors(&scene);
            let unmet = matrix.unmet(&FactorSettings::default()).count();
            assert_eq!(unmet, 0, "box {seed}, {rounding:?}:\n{text}");
            for (&[from, to], &(factor, error)) in &found {
                let exact = truth.get(&[from, to]).map_or(0.0, |exact| exact.0);
                let difference = (factor - exact).abs();
                assert!(difference <= 1e-3 + 8.0 * unit, "box {seed}, {rounding:?}: {from} to {to}: {factor} for {exact}");
                assert!(difference <= error + 1e-9, "box {seed}, {rounding:?}: {from} to {to}: {factor} +- {error} for {exact}");
                assert!(
                    faces[from].0 != faces[to].0 || factor <= 1e-9 + 8.0 * unit,
                    "box {seed}: {from} sees its wall: {factor}"
                );
            }
            let has = |wanted: fn(&Note) -> bool| scene.notes().iter().any(wanted);
            healed += usize::from(has(|note| matches!(note, Note::Healed { .. })));
            thin += usize::from(has(|note| matches!(note, Note::LeftOut { .. })));
        }
    }
    assert!(healed as u64 >= 2 * count && thin as u64 <= count, "{healed} healed, {thin} with faces left out");
}
