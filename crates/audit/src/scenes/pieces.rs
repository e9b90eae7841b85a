//! The pieces of a solution, each by itself against what it is by definition: what a point receives of an element, by core's closed forms and by
//! sums over points of the element; a point's view of a cluster; light that no node of an element sees; textures on an element; lines of shadows.
//!
//! A whole solution says little of these: its estimates are far above what most of them are off by, and what one loses another gives.

pub mod cuts;
pub mod hidden;
pub mod textures;

use std::f64::consts::PI;

use glam::DVec3;
use radgrad_core::{Polygon, Receiver, Tolerance, evaluate_value};
use radgrad_scene::{Scene, largest, smallest};
use radgrad_solver::parts::{self, Transfer};
use radgrad_solver::{Element, Mesh, Shape};

use crate::cases::sampler::Sampler;
use crate::scenes::draw::quad;

type Wrong = Result<Vec<String>, String>;

/// Findings on a case, or why it has none, each after the case's name and number.
fn named(name: &str, index: u64, outcome: Wrong) -> impl Iterator<Item = String> {
    outcome.unwrap_or_else(|why| vec![why]).into_iter().map(move |finding| format!("{name} {index}: {finding}"))
}

/// Findings on so many cases, each by itself.
fn named_findings(name: &str, cases: u64, outcome: impl Fn(u64) -> Wrong) -> Vec<String> {
    (0..cases).flat_map(|index| named(name, index, outcome(index))).collect()
}

/// Whether a number is not within a bound; if either is none, neither is known to be.
fn exceeds(value: f64, bound: f64) -> bool {
    value > bound || value.is_nan() || bound.is_nan()
}

/// Nodes and weights on the unit interval: five of C. F. Gauss in each of so many parts.
fn on_interval(parts: usize) -> Vec<(f64, f64)> {
    let five = [
        (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
        (-0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
        (0.0, 0.568_888_888_888_888_9),
        (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
        (0.906_179_845_938_664, 0.236_926_885_056_189_1),
    ];
    let unit = 1.0 / parts as f64;
    (0..parts).flat_map(|part| five.map(|(x, w)| ((part as f64 + 0.5 * (1.0 + x)) * unit, 0.5 * w * unit))).collect()
}

/// Reference coordinates of points of a shape, with weights that sum to 1.
fn over(shape: Shape, parts: usize) -> Vec<([f64; 2], f64)> {
    let line = on_interval(parts);
    let pair = |&(s, v): &(f64, f64)| {
        let of = move |&(t, w): &(f64, f64)| match shape {
            Shape::Parallelogram => ([s, t], v * w),
            Shape::Triangle => ([s, (1.0 - s) * t], 2.0 * (1.0 - s) * v * w),
        };
        line.iter().map(of).collect::<Vec<_>>()
    };
    line.iter().flat_map(pair).collect()
}

/// A random point of a shape.
fn within(shape: Shape, s: &mut Sampler) -> [f64; 2] {
    let [a, b] = [s.uniform(), s.uniform()];
    if shape == Shape::Triangle && a + b > 1.0 { [1.0 - a, 1.0 - b] } else { [a, b] }
}

/// A drawn rotation.
fn turned(s: &mut Sampler) -> impl Fn(DVec3) -> DVec3 + use<> {
    let x = s.direction();
    let y = s.perpendicular(x);
    let z = x.cross(y);
    move |p: DVec3| x * p.x + y * p.y + z * p.z
}

/// The unit of a case: one of three is small, so that nothing depends on absolute lengths.
fn unit(index: u64) -> f64 {
    if index % 3 == 2 { libm::ldexp(1.0, -40) } else { 1.0 }
}

/// A scene of faces that are one surface.
pub(crate) fn scene_of(faces: Vec<Vec<DVec3>>) -> Result<Scene, String> {
    let said = |error: radgrad_scene::Error| error.to_string();
    let mut scene = Scene::new(["grey"]).map_err(said)?;
    let (grey, surface) = (scene.add_material("grey", [0.5], [0.0]).map_err(said)?, scene.add_surface("all"));
    for corners in faces {
        let polygon = Polygon::new(corners).map_err(|error| error.to_string())?;
        scene.add_face(surface, grey, polygon, None).map_err(said)?;
    }
    Ok(scene)
}

/// Faces of which the first is looked at by a point in the clear, past a few faces, or past very many; in the case of an odd number a triangle.
struct Looked {
    scene: Scene,
    receiver: Receiver,
    degree: usize,
}

/// Faces from which on a rough answer is by rays.
const MANY: u64 = 26;

/// The corners of a screen that is round.
const ROUND: u32 = 30;

/// A screen with a dent, and the cases that have it.
const DENT: [[f64; 2]; 5] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [0.0, 0.5], [-1.0, 1.0]];
const DENTED: [u64; 3] = [6, 14, 17];

fn looked(index: u64) -> Result<Looked, String> {
    let s = &mut Sampler::new(18, "transfers", index);
    let (u, v) = (
        DVec3::new(s.between(0.3, 2.0), 0.2 * s.between(-1.0, 1.0), 0.0),
        DVec3::new(0.5 * s.between(-1.0, 1.0), s.between(0.3, 2.0), 0.0),
    );
    let face = if index % 2 == 1 { vec![DVec3::ZERO, u, v] } else { vec![DVec3::ZERO, u, u + v, v] };
    let at = |[a, b]: [f64; 2]| u * a + v * b;
    let shape = if index % 2 == 1 { Shape::Triangle } else { Shape::Parallelogram };
    let height = if s.one_in(3) { s.between(0.03, 0.3) } else { s.between(0.3, 3.0) };
    let aside = if s.one_in(2) { within(shape, s) } else { [s.between(-1.5, 2.5), s.between(-1.5, 2.5)] };
    // Some are close beside the third side of a triangle.
    let (aside, height) = if index % 4 == 3 {
        let (along, beside) = (s.between(0.2, 0.8), s.spread(-5, -2));
        ([along + beside, 1.0 - along + beside], s.between(0.2, 2.0) * beside)
    } else {
        (aside, height)
    };
    let point = at(aside) + DVec3::Z * height;
    let toward = at(within(shape, s)) - point;
    // Some look past the horizon.
    let normal = toward / toward.length() + s.cube() * if s.one_in(3) { 1.5 } else { 0.4 };
    let mut faces = vec![face];
    let count = [0, 0, 1, 2, MANY][(index / 2 % 5) as usize];
    for _ in 0..count {
        let middle = point.lerp(at(within(shape, s)), s.between(0.3, 0.7));
        let size = if count == MANY { 0.1 } else { 0.6 } * s.between(0.1, 0.7) * height;
        let (a, b) = (s.cube() * size, s.cube() * size);
        let around = |k: u32| f64::from(k) * std::f64::consts::TAU / f64::from(ROUND);
        // More corners than are kept of a shadow.
        let round = || (0..ROUND).map(|k| middle + a * around(k).cos() + b * around(k).sin()).collect();
        let dent = || DENT.map(|[x, y]| middle + a * x + b * y).to_vec();
        let corners = if index == 4 { round() } else { vec![middle - a, middle + a - b, middle + b] };
        faces.push(if DENTED.contains(&index) { dent() } else { corners });
    }
    if s.one_in(4) {
        // One that is in part below the face's plane.
        let foot = at([1.2, 0.4]);
        faces.push(vec![foot - DVec3::Z * 0.3, foot + DVec3::new(0.1, 0.5, -0.1), foot + DVec3::new(-0.1, 0.2, 0.4)]);
    }
    let (turn, unit) = (turned(s), unit(index));
    let faces = faces.into_iter().map(|corners| corners.into_iter().map(|p| turn(p) * unit).collect()).collect();
    let receiver = Receiver::new(turn(point) * unit, turn(normal), 1.0).map_err(|error| error.to_string())?;
    Ok(Looked { scene: scene_of(faces)?, receiver, degree: if count == MANY { 0 } else { s.below(4) as usize } })
}

/// Errors of the transfers of a case over their bounds, and the broken ones.
#[derive(Debug, Clone, Copy, Default)]
struct Figures {
    /// Squares of errors by rays over their estimates, and how many.
    by_rays: [f64; 2],
}

/// The accuracy of the evaluations that transfers are held against.
const FINE: f64 = 1e-13;

/// Findings on transfers from elements to points, in so many cases.
#[must_use]
pub fn transfers(cases: u64) -> Vec<String> {
    let (mut findings, mut sum) = (Vec::new(), Figures::default());
    for index in 0..cases {
        for error in [1e-9, 1e-4] {
            match transfers_of(index, error) {
                Ok((wrong, figures)) => {
                    findings.extend(wrong.into_iter().map(|what| format!("transfer {index} to {error:e}: {what}")));
                    sum.by_rays = [0, 1].map(|k| sum.by_rays[k] + figures.by_rays[k]);
                }
                Err(why) => findings.push(format!("transfer {index}: {why}")),
            }
        }
    }
    let [squares, count] = sum.by_rays;
    if count > 0.0 && !(0.02..=1.5).contains(&(squares / count)) {
        findings.push(format!("errors by rays are {:e} of their estimates in the mean square", squares / count));
    }
    findings
}

fn transfers_of(index: u64, error: f64) -> Result<(Vec<String>, Figures), String> {
    let said = |error: radgrad_solver::Error| error.to_string();
    let Looked { scene, receiver, degree } = looked(index)?;
    let mesh = Mesh::new(&scene, degree).map_err(said)?;
    let cells = if error > 1e-6 { 16 } else { 0 };
    let (mut findings, mut figures) = (Vec::new(), Figures::default());
    for transfer in parts::transfers(&mesh, &receiver, error, cells).map_err(said)? {
        let element = &mesh.elements()[transfer.source];
        if element.face() != 0 {
            continue;
        }
        let screens: Vec<&Polygon> = mesh.polygons().iter().skip(1).collect();
        let [first, others] = transfer.errors;
        for (function, value) in transfer.values.iter().enumerate() {
            let emitter = element.emitter(function, mesh.basis(transfer.source)).map_err(said)?;
            let tolerance = Tolerance { relative: 0.0, absolute: FINE };
            let truth =
                evaluate_value(&receiver, emitter, screens.iter().copied(), tolerance).map_err(|error| error.to_string())?;
            let (off, bound) = ((value - truth.radiosity).abs(), if function == 0 { first } else { others });
            if exceeds(off, bound + truth.radiosity_error) {
                findings.push(format!("function {function} is off by {off:e}, the bound is {bound:e}"));
            }
            if let Some(likely) = transfer.likely.filter(|_| function == 0) {
                figures.by_rays[0] += (off / likely).powi(2);
                figures.by_rays[1] += 1.0;
            } else if function == 0 && bound > 10.0 * error {
                findings.push(format!("{error:e} was asked for, {bound:e} is stated"));
            }
        }
        findings.extend(kernel(&mesh, &receiver, &transfer, error, &mut Sampler::new(19, "kernels", index)));
    }
    Ok((findings, figures))
}

/// Findings on the receivers below an element that is divided unevenly, and on its share of their values, of which each is the largest in turn.
fn uneven() -> Wrong {
    let said = |error: radgrad_solver::Error| error.to_string();
    let mut findings = Vec::new();
    for deep in 0..4 {
        let mut mesh = Mesh::new(&scene_of(vec![quad(DVec3::ZERO, DVec3::X, DVec3::Y)])?, 0).map_err(said)?;
        mesh.divide(0).map_err(said)?;
        let first = mesh.elements()[0].children().ok_or("no quarters")?;
        mesh.divide(first + deep).map_err(said)?;
        let receives: Vec<bool> = mesh.elements().iter().map(|element| element.children().is_none()).collect();
        let leaves: Vec<usize> = mesh.leaves().collect();
        let mut below = parts::receivers_below(&mesh, &receives, 0);
        below.sort_unstable();
        if below != leaves {
            findings.push(format!("the leaves are {leaves:?}, said {below:?}"));
        }
        for brightest in &leaves {
            // Whole numbers and areas that are powers of two: all sums are exact.
            let value = |element: usize| if element == *brightest { 64.0 } else { element as f64 };
            let of_leaf = |(element, is_leaf): (usize, &bool)| if *is_leaf { value(element) } else { 0.0 };
            let values: Vec<f64> = receives.iter().enumerate().map(of_leaf).collect();
            let [means, maxima] = parts::pulled(&mesh, &receives, &values);
            let mean: f64 = leaves.iter().map(|&leaf| value(leaf) * mesh.elements()[leaf].area()).sum();
            if means[0] != mean || maxima[0] != 64.0 {
                findings.push(format!("of {values:?} the mean is {mean}, the largest 64, said {} and {}", means[0], maxima[0]));
            }
        }
    }
    Ok(findings)
}

/// The kernel `n1.r n2.r / pi r^4` times the area, at a point of an element.
fn kernel_at(receiver: &Receiver, element: &Element, at: [f64; 2]) -> f64 {
    let r = element.point(at) - receiver.position();
    let (over, toward, square) = (receiver.normal().dot(r), -element.polygon().normal().dot(r), r.length_squared());
    if over > 0.0 && toward > 0.0 { element.area() * over * toward / (PI * square * square) } else { 0.0 }
}

/// Whether a segment passes through a polygon, by the sides of its fan.
fn is_hidden(from: DVec3, to: DVec3, screen: &Polygon) -> bool {
    let v = screen.vertices();
    let side = |p: DVec3| screen.normal().dot(p - v[0]);
    if side(from) * side(to) >= 0.0 {
        return false;
    }
    let at = from.lerp(to, side(from) / (side(from) - side(to)));
    (0..v.len()).all(|k| screen.normal().dot((v[(k + 1) % v.len()] - v[k]).cross(at - v[k])) > 0.0)
}

/// Findings on bounds on the kernel.
fn kernel(mesh: &Mesh, receiver: &Receiver, transfer: &Transfer, error: f64, s: &mut Sampler) -> Vec<String> {
    let (element, basis) = (&mesh.elements()[transfer.source], mesh.basis(transfer.source));
    let (shape, [least, peak]) = (element.shape(), transfer.kernel);
    let mut findings = Vec::new();
    let screens: Vec<&Polygon> = mesh.polygons().iter().skip(1).collect();
    let is_seen = |at: [f64; 2]| !screens.iter().any(|screen| is_hidden(receiver.position(), element.point(at), screen));
    let corners: &[[f64; 2]] = if shape == Shape::Triangle {
        &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
    } else {
        &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
    };
    let some: Vec<[f64; 2]> = corners.iter().copied().chain((0..40).map(|_| within(shape, s))).collect();
    for &at in &some {
        let value = kernel_at(receiver, element, at);
        if exceeds(value, peak * (1.0 + 1e-12)) || exceeds(least, value * (1.0 + 1e-12)) {
            findings.push(format!("the kernel is {value:e} at {at:?}, between {least:e} and {peak:e}"));
        }
        if let Some(bounds) = transfer.derivatives {
            let x = (element.point([1.0, 0.0]) - element.point([0.0; 2])).normalize();
            let along = (x + element.polygon().normal().cross(x) * s.between(-3.0, 3.0)).normalize();
            let found = taylor(receiver, element, at, along);
            if let Some(order) = (0..found.len()).find(|&order| exceeds(found[order].abs(), bounds[order] * (1.0 + 1e-9))) {
                findings.push(format!("derivative {order} of the kernel is {:e}, the bound {:e}", found[order], bounds[order]));
            }
        }
    }
    findings.extend(loose(receiver, element, corners, transfer));
    let Some([square, beyond]) = transfer.beyond else { return findings };
    let values: f64 = transfer.values.iter().map(|v| v * v).sum();
    let is_smooth = transfer.derivatives.is_some();
    let nodes = over(shape, 4);
    let nearest = nodes.iter().map(|(at, _)| element.point(*at).distance(receiver.position())).fold(f64::INFINITY, smallest);
    let radius = corners.iter().map(|&at| element.point(at).distance(element.centre())).fold(0.0, largest);
    if is_smooth && nearest > radius {
        let (mut whole, mut taken) = (0.0, vec![0.0; basis.len()]);
        for &(at, weight) in &nodes {
            let value = kernel_at(receiver, element, at);
            whole += weight * value * value;
            taken.iter_mut().zip(basis.values(at)).for_each(|(sum, phi)| *sum += weight * value * phi);
        }
        let left = largest(whole - taken.iter().map(|v| v * v).sum::<f64>(), 0.0).sqrt();
        // As much of the root of a difference of squares is their rounding.
        let room = 1e-6 * whole.sqrt() + 1e-2 * (whole.sqrt() * error).sqrt();
        if exceeds(whole, square + 1e-6 * whole) || exceeds(left, beyond + room) {
            findings.push(format!(
                "the kernel's mean square is {whole:e}, at most {square:e}; beyond is {left:e}, at most {beyond:e}"
            ));
        }
        // With as many digits nothing is left but what there is.
        if error < 1e-8 && (exceeds(square, whole + 1e-4 * peak * peak) || exceeds(beyond, left + 1e-3 * peak + 100.0 * room)) {
            findings.push(format!("the kernel's mean square is {whole:e}, said {square:e}; beyond is {left:e}, said {beyond:e}"));
        }
    } else if !is_smooth {
        let count = 2000;
        let (sum, squares) = (0..count).fold((0.0, 0.0), |(sum, squares), _| {
            let at = within(shape, s);
            let of = if is_seen(at) { kernel_at(receiver, element, at).powi(2) } else { 0.0 };
            (sum + of, squares + of * of)
        });
        let mean = sum / f64::from(count);
        let deviation = largest(squares / f64::from(count) - mean * mean, 0.0).sqrt() / f64::from(count).sqrt();
        if exceeds(mean, square + 6.0 * deviation) || error < 1e-8 && exceeds(square, mean + 6.0 * deviation + 1e-3 * peak * peak)
        {
            findings.push(format!("the visible kernel's mean square is {mean:e} by samples, said {square:e}"));
        }
        if exceeds(values, square * (1.0 + 1e-6) + 1e-12) {
            findings.push(format!("the values' squares sum to {values:e}, the kernel's mean square is {square:e}"));
        }
    }
    findings
}

/// The least kernel where that is said to be less than distances allow: of the corner that is lowest over the receiver's plane, with the farthest
/// distance in place of its own.
fn loose(receiver: &Receiver, element: &Element, corners: &[[f64; 2]], transfer: &Transfer) -> Option<String> {
    transfer.derivatives?;
    let points = || corners.iter().map(|&at| element.point(at) - receiver.position());
    let farthest = points().map(|r| r.length()).fold(0.0, largest);
    let allowed = |(&at, r): (&[f64; 2], DVec3)| kernel_at(receiver, element, at) * (r.length() / farthest).powi(4);
    let least = corners.iter().zip(points()).map(allowed).fold(f64::INFINITY, smallest);
    let [said, _] = transfer.kernel;
    exceeds(least, said * (1.0 + 1e-9) + 1e-12).then(|| format!("the kernel is {least:e} or more, that it is {said:e} is said"))
}

/// Findings on bounds on the derivatives of the kernel of a small element that is looked at askance by receivers which are turned ever more:
/// along the way to them all terms have one sign, so that the bounds are reached.
fn derivatives() -> Wrong {
    let corners = [[-0.01, -0.01], [0.01, -0.01], [0.01, 0.01], [-0.01, 0.01]].map(|[x, y]| DVec3::new(x, y, 0.0));
    let mesh = Mesh::new(&scene_of(vec![corners.to_vec()])?, 0).map_err(|error| error.to_string())?;
    let element = &mesh.elements()[0];
    let mut findings = Vec::new();
    for turn in [0.0, 0.1, 0.2, 0.4] {
        let receiver =
            Receiver::new(DVec3::new(1.8, 0.0, 0.872), DVec3::new(turn, 0.0, -1.0), 1.0).map_err(|error| error.to_string())?;
        for transfer in parts::transfers(&mesh, &receiver, 1e-9, 0).map_err(|error| error.to_string())? {
            let series = corners.map(|corner| taylor(&receiver, element, element.reference(corner), DVec3::X));
            for (order, bound) in transfer.derivatives.into_iter().flatten().enumerate() {
                let largest_term = series.iter().map(|terms| terms[order].abs()).fold(0.0, largest);
                if exceeds(largest_term, bound * (1.0 + 1e-9)) || exceeds(bound, 1.2 * largest_term) {
                    findings.push(format!("turned by {turn}, derivative {order} is {largest_term:e}, the bound is {bound:e}"));
                }
            }
            if transfer.derivatives.is_none() {
                findings.push(format!("turned by {turn}, the kernel is not smooth"));
            }
        }
    }
    Ok(findings)
}

/// Findings on bounds on the kernel of an element that a point nearly touches.
fn close() -> Wrong {
    let square = quad(DVec3::ZERO, DVec3::X, DVec3::Y);
    let mesh = Mesh::new(&scene_of(vec![square])?, 0).map_err(|error| error.to_string())?;
    let (element, mut findings) = (&mesh.elements()[0], Vec::new());
    for power in [10, 20, 30, 36, 44] {
        let point = DVec3::new(0.25, 0.625, 1.0 / (1u64 << power) as f64);
        let receiver = Receiver::new(point, DVec3::NEG_Z, 1.0).map_err(|error| error.to_string())?;
        for transfer in parts::transfers(&mesh, &receiver, 1e-9, 0).map_err(|error| error.to_string())? {
            let (value, [_, peak]) = (kernel_at(&receiver, element, element.reference(point)), transfer.kernel);
            if exceeds(value, peak * (1.0 + 1e-12)) {
                findings.push(format!("2^-{power} over an element the kernel is {value:e}, the bound {peak:e}"));
            }
        }
    }
    Ok(findings)
}

/// Findings on derivatives of kernels, on the cells that rays are sent to, on boxes of normals and points, and on the brightest light that fills a
/// hemisphere.
#[must_use]
pub fn rules() -> Vec<String> {
    let s = &mut Sampler::new(26, "rules", 0);
    let mut findings: Vec<String> =
        [derivatives(), close(), uneven()].into_iter().flat_map(|told| told.unwrap_or_else(|why| vec![why])).collect();
    for (shape, side) in
        [Shape::Parallelogram, Shape::Triangle].into_iter().flat_map(|shape| (1..6).map(move |side| (shape, side)))
    {
        let cells = parts::cells(shape, side);
        // Of equal area, each at its middle: so linear functions are integrated exactly; and each next to the one before.
        let middle = [0, 1].map(|k| cells.iter().map(|at| at[k]).sum::<f64>() / cells.len() as f64);
        let centre = if shape == Shape::Triangle { 1.0 / 3.0 } else { 0.5 };
        let apart = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) * side as f64;
        let farthest = cells.windows(2).map(|pair| apart(&pair[0], &pair[1])).fold(0.0, largest);
        let pairs = cells.iter().enumerate().flat_map(|(i, a)| cells[..i].iter().map(move |b| apart(a, b)));
        let nearest = pairs.fold(f64::INFINITY, smallest);
        if cells.len() != side * side
            || middle.iter().any(|m| exceeds((m - centre).abs(), 1e-14))
            || farthest > 1.5
            || nearest < 0.47
        {
            findings.push(format!("{side} cells a side of {shape:?} are about {middle:?}, {nearest} to {farthest} apart"));
        }
    }
    for _ in 0..64 {
        let mut range = |size: f64| {
            let (a, b) = (s.cube() * size, s.cube() * size);
            [a.min(b), a.max(b)]
        };
        let (normals, corners) = (range(1.0), range(3.0));
        let pick = |of: [DVec3; 2], k: usize| DVec3::new(of[k & 1].x, of[k >> 1 & 1].y, of[k >> 2 & 1].z);
        let products = (0..64).map(|k| -pick(normals, k >> 3).dot(pick(corners, k & 7)));
        let truth = products.fold(f64::NEG_INFINITY, largest);
        let said = parts::most_toward(normals, corners);
        if exceeds((said - truth).abs(), 1e-14) {
            findings.push(format!("the largest product of normals {normals:?} with points {corners:?} is {truth}, said {said}"));
        }
        // One order is the best: all are tried.
        let sources: Vec<(f64, f64)> = (0..4).map(|_| (s.between(0.05, 0.6), s.between(-0.2, 2.0))).collect();
        let order = |code: usize| {
            let mut unused = sources.clone();
            let (mut free, mut sum) = (1.0, 0.0);
            for (count, divisor) in [(4, 1), (3, 4), (2, 12), (1, 24)] {
                let (factor, value) = unused.remove(code / divisor % count);
                let part = smallest(factor, free);
                (free, sum) = (free - part, sum + part * largest(value, 0.0));
            }
            sum
        };
        let (truth, said) = ((0..24).map(order).fold(0.0, largest), parts::filled(sources.clone()));
        if exceeds((said - truth).abs(), 1e-14) {
            findings.push(format!("{sources:?} fill a hemisphere with {truth}, said {said}"));
        }
    }
    if !parts::filled(vec![(0.5, 1.0), (0.5, f64::NAN)]).is_nan() {
        findings.push("a radiosity that is no number fills a hemisphere with a number".to_owned());
    }
    findings
}

/// Coefficients of the kernel times the area in the distance along a direction of the plane, by products of series.
fn taylor(receiver: &Receiver, element: &Element, at: [f64; 2], along: DVec3) -> [f64; 6] {
    let r = element.point(at) - receiver.position();
    let height = -element.polygon().normal().dot(r);
    let [a, b, c] = [r.length_squared(), 2.0 * r.dot(along), 1.0];
    // 1/q and then its square, of q = a + b t + c t^2.
    let mut inverse = [0.0; 6];
    for k in 0..6 {
        let one = if k == 0 { 1.0 } else { 0.0 };
        let before = |j: usize| if k >= j { inverse[k - j] } else { 0.0 };
        inverse[k] = (one - b * before(1) - c * before(2)) / a;
    }
    let square: [f64; 6] = std::array::from_fn(|k| (0..=k).map(|j| inverse[j] * inverse[k - j]).sum());
    let [over, slope] = [receiver.normal().dot(r), receiver.normal().dot(along)];
    let unit = element.area() * height / PI;
    std::array::from_fn(|k| unit * (over * square[k] + if k > 0 { slope * square[k - 1] } else { 0.0 }))
}

#[cfg(test)]
mod tests {
    use super::cuts::{partitions, shadow_lines};
    use super::hidden::{sights, unseen, views};
    use super::textures::{gathers, textures};
    use super::*;

    #[test]
    fn pieces_are_what_they_are_by_definition() {
        let told = [transfers(12), views(4), unseen(10), sights(16), textures(8), gathers(8), shadow_lines(12), partitions(4)];
        assert_eq!([told.concat(), rules()].concat(), Vec::<String>::new());
    }

    #[test]
    fn sums_over_shapes_and_series_of_kernels_are_right() {
        for (shape, exact) in [(Shape::Parallelogram, 1.0 / 24.0), (Shape::Triangle, 2.0 * 120.0 * 6.0 / 3_628_800.0)] {
            let mean: f64 = over(shape, 2).iter().map(|([s, t], weight)| weight * s.powi(5) * t.powi(3)).sum();
            assert!((mean - exact).abs() < 1e-15, "{shape:?} {mean}");
        }
        let Looked { scene, receiver, .. } = looked(0).unwrap();
        let mesh = Mesh::new(&scene, 1).unwrap();
        let element = &mesh.elements()[0];
        let along = (element.point([1.0, 0.0]) - element.point([0.0; 2])).normalize();
        let (at, step) = ([0.5, 0.5], 1e-3);
        let there = element.reference(element.point(at) + along * step);
        let series = taylor(&receiver, element, at, along);
        let sum: f64 = (0..6).map(|k| series[k as usize] * step.powi(k)).sum();
        assert!((sum - kernel_at(&receiver, element, there)).abs() < 1e-12 * sum.abs(), "{sum}");
    }

    #[test]
    fn no_number_is_within_a_bound_that_is_none() {
        assert!(exceeds(f64::NAN, 1.0) && exceeds(1.0, f64::NAN) && exceeds(1.1, 1.0) && !exceeds(1.0, 1.0));
    }
}
