//! Meshes that are cut along shadow lines, and along the outlines of their faces: elements cover their faces and no more, lie along lines of
//! shadows that are known in closed form, and their polynomials come as near to the light as they ought to.

use glam::DVec3;
use radgrad_core::{Emission, Emitter, Polygon, Receiver, Tolerance, evaluate_value};
use radgrad_scene::{Scene, largest, smallest};
use radgrad_solver::{Marking, Mesh, Options, Solution, solve};

use crate::measures::measure::is_worse;
use crate::scenes::alike::uncovered;

/// The error that cuts are asked for, and the elements that they may make.
const ERROR: f64 = 0.01;
const MOST: usize = 40;

/// The part of the light that polynomials may be off by, as a root of mean squares: on a square floor past a straight edge, and on a triangle past
/// an edge that is aslant.
const OFF: [f64; 2] = [0.02, 0.04];

/// The distance of a side that lies on a line.
const ON: f64 = 1e-9;

/// A polygon at a height, facing up or down.
fn level(corners: &[[f64; 2]], z: f64, is_up: bool) -> Vec<DVec3> {
    let mut v: Vec<DVec3> = corners.iter().map(|[x, y]| DVec3::new(*x, *y, z)).collect();
    if !is_up {
        v.reverse();
    }
    v
}

/// A floor that reflects half, a lamp over it, and a black screen at half the height of which one edge is over the floor.
fn faces(index: u64) -> [Vec<DVec3>; 3] {
    let (floor, lamp, screen) = if index == 0 {
        (
            vec![[-4.0, -4.0], [4.0, -4.0], [4.0, 4.0], [-4.0, 4.0]],
            vec![[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]],
            vec![[0.3, -9.0], [9.0, -9.0], [9.0, 9.0], [0.3, 9.0]],
        )
    } else {
        (
            vec![[-4.0, -3.0], [4.0, -4.0], [0.5, 4.5]],
            vec![[-0.4, -0.3], [0.5, -0.2], [0.1, 0.5]],
            vec![[-9.0, -9.0], [0.9, -9.0], [-0.2, 9.0]],
        )
    };
    [level(&floor, 0.0, true), level(&lamp, 2.0, false), level(&screen, 1.0, true)]
}

fn scene(faces: &[Vec<DVec3>], materials: &[(f64, f64)]) -> Result<Scene, String> {
    let said = |error: radgrad_scene::Error| error.to_string();
    let mut scene = Scene::new(["grey"]).map_err(said)?;
    let surface = scene.add_surface("every");
    for (index, (corners, &(reflectance, radiance))) in faces.iter().zip(materials).enumerate() {
        let polygon = Polygon::new(corners.clone()).map_err(|error| error.to_string())?;
        let material = scene.add_material(format!("{index}"), [reflectance], [radiance]).map_err(said)?;
        scene.add_face(surface, material, polygon, None).map_err(said)?;
    }
    Ok(scene)
}

/// Everything that is wrong with such meshes.
#[must_use]
pub fn all_wrong() -> Vec<String> {
    let past = (0..2).map(|index| (format!("past a screen {index}"), past_a_screen(index)));
    let outlines = (0..4).map(|index| (format!("outline {index}"), outlined(index)));
    let named = |(name, wrong): (String, Result<Vec<String>, String>)| {
        let wrong = wrong.unwrap_or_else(|error| vec![error]);
        wrong.into_iter().map(move |finding| format!("{name}: {finding}"))
    };
    past.chain(outlines).flat_map(named).collect()
}

fn past_a_screen(index: u64) -> Result<Vec<String>, String> {
    let faces = faces(index);
    let scene = scene(&faces, &[(0.5, 0.0), (0.0, std::f64::consts::FRAC_1_PI), (0.0, 0.0)])?;
    let options = Options {
        error: ERROR,
        degree: Some(2),
        first_elements: 1,
        most_elements: MOST,
        marking: Marking::Shadows,
        ..Options::default()
    };
    let solution = solve(&scene, &options, |_| false).map_err(|error| error.to_string())?;
    let mesh = solution.mesh();
    let mut findings = uncovered(&solution);
    if mesh.roots().len() > MOST {
        findings.push(format!("{} elements, at most {MOST} were asked for", mesh.roots().len()));
    }
    let light = light(&faces)?;
    let square = |values: &mut dyn Iterator<Item = f64>| values.map(|value| value * value).sum::<f64>().sqrt();
    let deviation = |(place, value): &(DVec3, f64)| {
        let value_on = |leaf: usize| solution.value_on(leaf, 0, mesh.elements()[leaf].reference(*place));
        mesh.leaf_at(0, *place).map_or(f64::NAN, |leaf| value_on(leaf) - value)
    };
    let share = square(&mut light.iter().map(deviation)) / square(&mut light.iter().map(|(_, value)| *value));
    if is_worse(share, OFF[usize::from(index > 0)]) {
        findings.push(format!("{} elements are off by {share:e} of the light", mesh.roots().len()));
    }
    if index == 0 {
        // The edge is halfway between: its shadow from either side of the lamp is twice its place less that of the side.
        for x in [2.0 * 0.3 - 0.5, 2.0 * 0.3 + 0.5] {
            let covered = along(mesh, x);
            if is_worse(8.0 - covered, 0.01) {
                findings.push(format!("sides of elements have {covered} of the 8 of the line at {x}"));
            }
        }
    }
    Ok(findings)
}

/// Places of the floor that are spread evenly, with the radiosity there.
fn light(faces: &[Vec<DVec3>; 3]) -> Result<Vec<(DVec3, f64)>, String> {
    let said = |error: radgrad_core::Error| error.to_string();
    let polygon = |face: &Vec<DVec3>| Polygon::new(face.clone()).map_err(said);
    let (lamp, screen) = (Emitter::new(polygon(&faces[1])?, Emission::Constant(1.0)).map_err(said)?, polygon(&faces[2])?);
    let v = &faces[0];
    let is_inside = |p: &DVec3| (0..v.len()).all(|i| (v[(i + 1) % v.len()] - v[i]).cross(*p - v[i]).z > 0.0);
    let place = |k: u32| {
        let [a, b] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2].map(|step: f64| (step * (f64::from(k) + 0.5)).fract());
        DVec3::new(9.0 * a - 4.5, 9.0 * b - 4.5, 0.0)
    };
    let value = |place: DVec3| {
        let receiver = Receiver::new(place, DVec3::Z, 0.5).map_err(said)?;
        let tolerance = Tolerance { relative: 0.0, absolute: 1e-9 };
        evaluate_value(&receiver, &lamp, [&screen], tolerance).map(|answer| (place, answer.radiosity)).map_err(said)
    };
    (0..600).map(place).filter(is_inside).map(value).collect()
}

/// The length that sides of the floor's elements have on a line along y, each place once.
fn along(mesh: &Mesh, x: f64) -> f64 {
    let mut parts: Vec<[f64; 2]> = Vec::new();
    for &root in mesh.roots() {
        let element = &mesh.elements()[root];
        let v = element.polygon().vertices();
        let sides = (0..v.len()).map(|i| [v[i], v[(i + 1) % v.len()]]);
        let on_line = sides.filter(|side| element.face() == 0 && side.iter().all(|p| (p.x - x).abs() <= ON));
        parts.extend(on_line.map(|[a, b]| [smallest(a.y, b.y), largest(a.y, b.y)]));
    }
    parts.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let (mut sum, mut end) = (0.0, f64::NEG_INFINITY);
    for [from, to] in parts {
        sum += largest(to - largest(from, end), 0.0);
        end = largest(end, to);
    }
    sum
}

/// A lamp over a floor of four sides that is no parallelogram, or of more: the first elements.
fn outlined(index: u64) -> Result<Vec<String>, String> {
    let floor = match index {
        // As far from a parallelogram as to have most of one in it, from either corner.
        0 => vec![[0.0, 0.0], [5.6, 0.0], [5.4, 5.5], [-0.1, 5.3]],
        1 => vec![[0.1, 0.0], [3.2, 0.1], [3.0, 1.0], [0.0, 1.1]],
        2 => vec![[0.0, 0.0], [4.0, 0.0], [3.1, 2.0], [0.4, 2.0]],
        _ => vec![[0.0, 0.0], [3.0, 0.0], [3.6, 1.2], [2.0, 2.4], [-0.3, 1.4]],
    };
    let faces = [level(&floor, 0.0, true), level(&[[0.5, 0.2], [1.0, 0.2], [1.0, 0.7], [0.5, 0.7]], 3.0, false)];
    let scene = scene(&faces, &[(0.5, 0.0), (0.0, 1.0)])?;
    let mut findings = Vec::new();
    for degree in [0, 1] {
        let options = Options {
            error: 0.5,
            degree: Some(degree),
            first_elements: 1,
            most_elements: MOST,
            marking: Marking::Gradient,
            ..Options::default()
        };
        let solution: Solution = solve(&scene, &options, |_| false).map_err(|error| error.to_string())?;
        findings.extend(uncovered(&solution));
    }
    Ok(findings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_cover_their_faces_and_lie_along_shadow_lines() {
        assert_eq!(all_wrong(), Vec::<String>::new());
    }
}
