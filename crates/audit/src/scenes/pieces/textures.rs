//! Textures on elements.

use std::f64::consts::PI;

use glam::DVec3;
use radgrad_core::Polygon;
use radgrad_scene::{Quantity, Scene, Texture, largest, smallest};
use radgrad_solver::{Mesh, parts};

use super::{Wrong, exceeds, over};
use crate::cases::sampler::Sampler;

/// Findings on textures on elements, in so many cases.
#[must_use]
pub fn textures(cases: u64) -> Vec<String> {
    let of = |index: u64| match textures_of(index) {
        Ok(wrong) => wrong.into_iter().map(|what| format!("texture {index}: {what}")).collect(),
        Err(why) => vec![format!("texture {index}: {why}")],
    };
    (0..cases).flat_map(of).collect()
}

fn textures_of(index: u64) -> Wrong {
    let s = &mut Sampler::new(22, "textures", index);
    let said = |error: radgrad_scene::Error| error.to_string();
    let mut scene = Scene::new(["grey"]).map_err(said)?;
    let [rho, radiance] = [s.between(0.3, 1.0), s.between(0.5, 2.0)];
    let material = scene.add_material("textured", [rho], [radiance]).map_err(said)?;
    let surface = scene.add_surface("all");
    // Texels along the sides of a parallelogram, or across those of any face.
    let is_along = index.is_multiple_of(2);
    let u = DVec3::new(s.between(0.5, 2.0), s.between(-0.3, 0.3), s.between(-0.3, 0.3));
    let v = DVec3::new(s.between(-0.3, 0.3), s.between(0.5, 2.0), s.between(-0.3, 0.3));
    let (corners, coordinates) = if is_along {
        (vec![DVec3::ZERO, u, u + v, v], vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    } else if index % 4 == 1 {
        (vec![DVec3::ZERO, u, v], vec![[s.between(-0.2, 0.2), 0.1], [1.3, s.between(0.0, 0.5)], [0.4, 1.2]])
    } else {
        (vec![DVec3::ZERO, u, u + v, v], vec![[0.2, 0.0], [1.1, 0.4], [0.7, 1.3], [-0.2, 0.9]])
    };
    for quantity in [Quantity::Reflectance, Quantity::Radiance] {
        if s.one_in(4) {
            continue;
        }
        let size = [1 + s.below(3) as usize, 2 + s.below(2) as usize];
        let texels: Vec<f64> = (0..size[0] * size[1]).map(|_| s.uniform()).collect();
        let texture = Texture::from_fn("grid", size, 1, |column, row| vec![texels[row * size[0] + column]]).map_err(said)?;
        scene.set_texture(material, quantity, texture).map_err(said)?;
    }
    let polygon = Polygon::new(corners).map_err(|error| error.to_string())?;
    let face = scene.add_textured_face(surface, material, polygon, &coordinates, None).map_err(said)?;
    let mesh = Mesh::new(&scene, s.below(4) as usize).map_err(|error| error.to_string())?;
    let mut findings = Vec::new();
    for &root in mesh.roots() {
        let (element, basis) = (&mesh.elements()[root], mesh.basis(root));
        let irradiance: Vec<f64> = (0..basis.len()).map(|i| if i == 0 { 1.5 } else { s.between(-0.5, 0.5) }).collect();
        // Six parts a side have all edges of texels along the sides among theirs.
        let points = if is_along { over(element.shape(), 6) } else { over(element.shape(), 20) };
        let here: Vec<([f64; 2], f64, Vec<f64>)> = points
            .iter()
            .map(|&(at, weight)| {
                let point = element.point(at);
                let of = |quantity| scene.value_at(face, quantity, point)[0];
                ([of(Quantity::Reflectance), PI * of(Quantity::Radiance)], weight, basis.values(at))
            })
            .collect();
        let is_lamp = scene.materials()[material].texture(Quantity::Radiance).is_some();
        let mean = |f: &dyn Fn([f64; 2], &[f64]) -> f64| here.iter().map(|(of, weight, phi)| weight * f(*of, phi)).sum::<f64>();
        let h = |phi: &[f64]| irradiance.iter().zip(phi).map(|(h, phi)| h * phi).sum::<f64>();
        let [reflected, emitted, reflectance] = [0, 1, 2].map(|which| {
            let of = |i: usize| {
                mean(&|[rho, e], phi| {
                    phi[i]
                        * match which {
                            0 => rho * h(phi),
                            1 => e,
                            _ => rho,
                        }
                })
            };
            (0..basis.len()).map(of).collect::<Vec<f64>>()
        });
        let lit = if is_lamp { 1.0 } else { 0.0 };
        let left = |[rho, e]: [f64; 2], phi: &[f64]| {
            let held: f64 = reflected.iter().zip(&emitted).zip(phi).map(|((r, e), phi)| (r + lit * e) * phi).sum();
            lit * e + rho * h(phi) - held
        };
        let room = if is_along { 1e-9 } else { 0.02 };
        for texture in parts::textures(&scene, &mesh, root, &irradiance) {
            let apart = |a: &[f64], b: &[f64], unit: f64| a.iter().zip(b).map(|(a, b)| (a - unit * b).abs()).fold(0.0, largest);
            let [off, off_emitted] = [apart(&texture.reflected, &reflected, 1.0), apart(&texture.emitted, &emitted, lit)];
            // Even emission is no texture's.
            let is_more = !is_lamp && texture.emitted.iter().any(|emitted| *emitted != 0.0);
            if exceeds(off, 2.0 * room) || exceeds(off_emitted, 6.0 * room) || is_more {
                findings.push(format!("projections are off by {off:e} and {off_emitted:e}"));
            }
            let most = here.iter().map(|(of, _, phi)| left(*of, phi).abs()).fold(0.0, largest);
            let square = mean(&|of, phi| left(of, phi).powi(2)).sqrt();
            let [largest_left, mean_left] = texture.detail;
            if exceeds(most, largest_left + 8.0 * room)
                || exceeds(square, mean_left + 4.0 * room)
                || exceeds(mean_left, smallest(square, largest_left) + 4.0 * room + 1e-6)
            {
                findings.push(format!("{most:e} is left out, {square:e} in the mean; said {largest_left:e} and {mean_left:e}"));
            }
            let whole = mean(&|[rho, _], _| rho * rho);
            let without = |count: usize| largest(whole - reflectance.iter().take(count).map(|c| c * c).sum::<f64>(), 0.0).sqrt();
            let spread = apart(&texture.spread, &[whole.sqrt(), without(1), without(basis.len())], 1.0);
            if exceeds(spread, if is_along { 1e-6 } else { 0.03 }) {
                findings.push(format!("the reflectance varies otherwise than {:?}, by {spread:e}", texture.spread));
            }
        }
    }
    Ok(findings)
}
