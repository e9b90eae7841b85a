//! Textures on elements, and the light on elements beyond their polynomials.

use std::f64::consts::PI;

use glam::DVec3;
use radgrad_core::{Polygon, Receiver};
use radgrad_scene::{Quantity, Scene, Texture, largest, smallest};
use radgrad_solver::{Mesh, parts};

use super::{Wrong, exceeds, kernel_at, named_findings, over, scene_of};
use crate::cases::sampler::Sampler;

/// Findings on textures on elements, in so many cases.
#[must_use]
pub fn textures(cases: u64) -> Vec<String> {
    let turned = named_findings("turned texture", 2 * cases, turned_of);
    [named_findings("texture", cases, textures_of), turned].concat()
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
    // With polynomials of degree 0 the largest detail is that of a texel, of another one for each irradiance.
    let degree = if index.is_multiple_of(4) { 0 } else { s.below(4) as usize };
    let mesh = Mesh::new(&scene, degree).map_err(|error| error.to_string())?;
    let irradiances: &[f64] = if degree == 0 { &[1.5, 0.1, 0.5, 5.0, 20.0, -0.5, -1.5, -20.0] } else { &[1.5] };
    let mut findings = Vec::new();
    for (&root, &even) in mesh.roots().iter().flat_map(|root| irradiances.iter().map(move |even| (root, even))) {
        let (element, basis) = (&mesh.elements()[root], mesh.basis(root));
        let irradiance: Vec<f64> = (0..basis.len()).map(|i| if i == 0 { even } else { s.between(-0.5, 0.5) }).collect();
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
        let room = largest(1.0, even.abs()) * if is_along { 1e-9 } else { 0.02 };
        let dim = 1.0 / (1u64 << 40) as f64;
        let dimmed = parts::textures(&scene, &mesh, root, &irradiance.iter().map(|h| h * dim).collect::<Vec<_>>());
        for (texture, dimmed) in parts::textures(&scene, &mesh, root, &irradiance).iter().zip(&dimmed) {
            if !is_lamp && dimmed.detail != texture.detail.map(|detail| detail * dim) {
                findings
                    .push(format!("of light times {dim:e} {:?} is left out, of the whole {:?}", dimmed.detail, texture.detail));
            }
            if degree == 0 && is_along {
                let detail = here.iter().map(|(of, _, phi)| left(*of, phi).abs()).fold(0.0, largest);
                if exceeds(texture.detail[0], detail + room) {
                    findings.push(format!("{detail:e} is left out, {:e} is said", texture.detail[0]));
                }
            }
        }
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

/// Findings on the mean of a texture that is turned on its face: the first coefficients of the elements against the scene's own mean.
fn turned_of(index: u64) -> Wrong {
    let s = &mut Sampler::new(29, "turned textures", index);
    let said = |error: radgrad_scene::Error| error.to_string();
    let mut scene = Scene::new(["grey"]).map_err(said)?;
    let material = scene.add_material("textured", [0.9], [1.0]).map_err(said)?;
    let surface = scene.add_surface("all");
    let size = [3 + s.below(6) as usize, 3 + s.below(6) as usize];
    for quantity in Quantity::ALL {
        let texels: Vec<f64> = (0..size[0] * size[1]).map(|_| s.uniform()).collect();
        let texture = Texture::from_fn("grid", size, 1, |column, row| vec![texels[row * size[0] + column]]).map_err(said)?;
        scene.set_texture(material, quantity, texture).map_err(said)?;
    }
    let (sine, cosine) = libm::sincos(s.between(0.0, std::f64::consts::TAU));
    let corners: &[[f64; 2]] =
        if index % 2 == 1 { &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]] } else { &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] };
    let (u, v) = (DVec3::new(s.between(0.5, 2.0), 0.1, 0.2), DVec3::new(-0.2, s.between(0.5, 2.0), 0.1));
    let polygon = corners.iter().map(|[a, b]| u * *a + v * *b).collect();
    let polygon = Polygon::new(polygon).map_err(|error| error.to_string())?;
    let chart: Vec<[f64; 2]> = corners.iter().map(|[a, b]| [0.1 + cosine * a - sine * b, 0.2 + sine * a + cosine * b]).collect();
    let face = scene.add_textured_face(surface, material, polygon, &chart, None).map_err(said)?;
    let mesh = Mesh::new(&scene, (index / 2 % 3) as usize).map_err(|error| error.to_string())?;
    let mut sums = [0.0; 3];
    for &root in mesh.roots() {
        let (area, len) = (mesh.elements()[root].area(), mesh.basis(root).len());
        let irradiance: Vec<f64> = (0..len).map(|i| if i == 0 { 1.0 } else { 0.0 }).collect();
        for texture in parts::textures(&scene, &mesh, root, &irradiance) {
            sums = [sums[0] + area, sums[1] + area * texture.emitted[0], sums[2] + area * texture.reflected[0]];
        }
    }
    let [emitted, reflected] = [sums[1] / sums[0], sums[2] / sums[0]];
    let [radiance, reflectance] = [Quantity::Radiance, Quantity::Reflectance].map(|of| scene.mean_over(face, of, 0));
    let mut findings = Vec::new();
    if exceeds((emitted - PI * radiance).abs(), 1e-9) || exceeds((reflected - reflectance).abs(), 1e-9) {
        findings.push(format!("means are {emitted} and {reflected}, of the scene {} and {reflectance}", PI * radiance));
    }
    Ok(findings)
}

/// Findings on gathers of textured elements by points, in so many cases.
#[must_use]
pub fn gathers(cases: u64) -> Vec<String> {
    named_findings("gather", cases, gathers_of)
}

/// A parallelogram of six texels that a point looks at: in the clear, past a screen that hides a quarter of it, or as near as can be.
fn gathers_of(index: u64) -> Wrong {
    let s = &mut Sampler::new(28, "gathers", index);
    let said = |error: radgrad_scene::Error| error.to_string();
    let mut scene = Scene::new(["grey"]).map_err(said)?;
    let material = scene.add_material("textured", [s.between(0.3, 0.9)], [0.0]).map_err(said)?;
    let black = scene.add_material("black", [0.0], [0.0]).map_err(said)?;
    let surface = scene.add_surface("all");
    // Of one kind as well as another, or one bright among dark ones.
    let is_sparse = s.one_in(2);
    let texels: Vec<f64> = (0..6).map(|k| if is_sparse { if k == 2 { 0.9 } else { 0.02 } } else { s.uniform() }).collect();
    let texture = Texture::from_fn("grid", [3, 2], 1, |column, row| vec![texels[row * 3 + column]]).map_err(said)?;
    scene.set_texture(material, Quantity::Reflectance, texture).map_err(said)?;
    let (u, v) = (DVec3::new(s.between(0.8, 1.2), 0.1, 0.0), DVec3::new(-0.1, s.between(0.8, 1.2), 0.0));
    let quad = |low: [f64; 2], size: f64, z: f64| {
        let origin = u * low[0] + v * low[1] + DVec3::Z * z;
        Polygon::new(vec![origin, origin + u * size, origin + (u + v) * size, origin + v * size])
            .map_err(|error| error.to_string())
    };
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let face = scene.add_textured_face(surface, material, quad([0.0; 2], 1.0, 0.0)?, &corners, None).map_err(said)?;
    let way = ["clear", "screened", "near"][(index % 3) as usize];
    let aside = [s.uniform(), s.uniform()];
    // Close to a texel one sees nothing else.
    let (height, tilt) = if way == "near" { (2.0_f64.powi(-44), DVec3::ZERO) } else { (s.between(1.0, 4.0), s.cube() * 0.2) };
    let point = u * aside[0] + v * aside[1] + DVec3::Z * height;
    let receiver = Receiver::new(point, DVec3::NEG_Z + tilt, 1.0);
    if way == "screened" {
        // Halfway, and as large as just to hide the quarter.
        let quarter = quad([-1e-9; 2], 0.5 + 2e-9, 0.0)?;
        let screen = quarter.vertices().iter().map(|p| p.midpoint(point)).collect();
        scene.add_face(surface, black, Polygon::new(screen).map_err(|error| error.to_string())?, None).map_err(said)?;
    }
    let mut mesh = Mesh::new(&scene, (index / 3 % 4) as usize).map_err(|error| error.to_string())?;
    mesh.divide(0).map_err(|error| error.to_string())?;
    let receiver = receiver.map_err(|error| error.to_string())?;
    let (element, basis) = (&mesh.elements()[0], mesh.basis(0));
    let brightness = |at: [f64; 2]| scene.value_at(face, Quantity::Reflectance, element.point(at))[0];
    let points = over(element.shape(), 6);
    let largest_value = points.iter().map(|(at, _)| brightness(*at)).fold(0.0, largest);
    let mean = |f: &dyn Fn([f64; 2]) -> f64| points.iter().map(|(at, weight)| weight * f(*at)).sum::<f64>();
    let mean_value = mean(&brightness);
    let said = parts::gathers(&scene, &mesh, &receiver, 0, 1e-10, [largest_value; 2]).map_err(|error| error.to_string())?;
    let mut findings = Vec::new();
    for (name, said) in ["one link", "links to quarters"].into_iter().zip(said) {
        if way == "near" {
            let below = brightness(aside);
            if exceeds(below, said.gathered * (1.0 + 1e-6)) || exceeds((said.factor - 1.0).abs(), 1e-6) {
                findings.push(format!("by {name} {below} is seen everywhere, {said:?}"));
            }
            continue;
        }
        let is_seen = |[a, b]: [f64; 2]| way == "clear" || a > 0.5 || b > 0.5;
        let kernel = |at: [f64; 2]| if is_seen(at) { kernel_at(&receiver, element, at) } else { 0.0 };
        let [factor, gathered] = [mean(&kernel), mean(&|at| kernel(at) * brightness(at))];
        let taken: Vec<f64> = (0..basis.len()).map(|i| mean(&|at| kernel(at) * basis.values(at)[i])).collect();
        let polynomial = |at: [f64; 2]| basis.values(at).iter().zip(&taken).map(|(phi, value)| phi * value).sum::<f64>();
        let truncation = mean(&|at| (kernel(at) - polynomial(at)).powi(2)).sqrt();
        let [least, peak] = [smallest, largest].map(|pick: fn(f64, f64) -> f64| {
            points.iter().map(|(at, _)| kernel_at(&receiver, element, *at)).reduce(pick).unwrap_or(f64::NAN)
        });
        let deviation = mean(&|at| (brightness(at) - mean_value).powi(2)).sqrt();
        // What is uneven is gathered unevenly by no more than that, where all is seen.
        let uneven = smallest(factor * mean_value + 0.55 * (peak - least) * deviation, peak * mean_value);
        let limit = if way == "clear" { uneven } else { factor * largest_value };
        let room = 1e-6 * peak;
        if exceeds((said.factor - factor).abs(), room)
            || exceeds(gathered, said.gathered + room)
            || exceeds(said.gathered, largest(limit, gathered) + 0.02 * peak)
            || exceeds(truncation, said.truncation + room)
            || exceeds(said.truncation, truncation + 1e-3 * peak)
        {
            findings.push(format!("by {name} {gathered} is gathered with the factor {factor}, {truncation:e} left: {said:?}"));
        }
    }
    Ok(findings)
}

/// Findings on polynomials of elements over the light of their leaves, in so many cases.
#[must_use]
pub fn projections(cases: u64) -> Vec<String> {
    named_findings("projection", cases, projections_of)
}

/// A face, one of its quarters and one of that one's are divided, and each leaf has a light of its own.
fn projections_of(index: u64) -> Wrong {
    let s = &mut Sampler::new(33, "projections", index);
    let (u, v) = (DVec3::new(s.between(0.5, 2.0), 0.2, 0.0), DVec3::new(-0.3, s.between(0.5, 2.0), 0.1));
    let corners = if index.is_multiple_of(2) { vec![DVec3::ZERO, u, v] } else { vec![DVec3::ZERO, u, u + v, v] };
    let said = |error: radgrad_solver::Error| error.to_string();
    let mut mesh = Mesh::new(&scene_of(vec![corners])?, (index / 2 % 4) as usize).map_err(said)?;
    let mut divided = 0;
    for _ in 0..3 {
        mesh.divide(divided).map_err(said)?;
        divided = mesh.elements()[divided].children().unwrap_or(0) + s.below(4) as usize;
    }
    let leaves: Vec<usize> = mesh.leaves().collect();
    let mut of_leaf = |&leaf: &usize| (0..mesh.basis(leaf).len()).map(|_| s.between(-1.0, 1.0)).collect::<Vec<f64>>();
    let light: Vec<Vec<f64>> = leaves.iter().map(&mut of_leaf).collect();
    let value = |element: usize, coefficients: &[f64], place: [f64; 2]| {
        mesh.basis(element).values(place).iter().zip(coefficients).map(|(phi, c)| phi * c).sum::<f64>()
    };
    let mut findings = Vec::new();
    for (element, said) in parts::projections(&mesh, &light).into_iter().enumerate() {
        let is_below =
            |leaf: usize| std::iter::successors(Some(leaf), |&at| mesh.elements()[at].parent()).any(|at| at == element);
        let (mut furthest, mut square) = (0.0, 0.0);
        for (&leaf, light) in leaves.iter().zip(&light).filter(|(leaf, _)| is_below(**leaf)) {
            let share = mesh.elements()[leaf].area() / mesh.elements()[element].area();
            for (at, weight) in over(mesh.elements()[leaf].shape(), 2) {
                let of_element = mesh.elements()[element].reference(mesh.elements()[leaf].point(at));
                let beyond = value(leaf, light, at) - value(element, &said.coefficients, of_element);
                furthest = largest(furthest, beyond.abs());
                square += share * weight * beyond * beyond;
            }
        }
        let [largest_beyond, rms] = said.beyond;
        if exceeds(furthest, largest_beyond + 1e-10) || exceeds((square.sqrt() - rms).abs(), 1e-6) {
            findings.push(format!(
                "beyond the polynomial of element {element} is {furthest:e}, {:e} in the mean square, said {:?}",
                square.sqrt(),
                said.beyond
            ));
        }
    }
    Ok(findings)
}
