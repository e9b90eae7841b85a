//! The bounds of batches: the tables of `batch::bound` and `batch::linear::bound`.

use std::f64::consts::PI;

use glam::DVec3;
use radgrad_core::batch::{Answers, Engine, Precision, Receivers};
use radgrad_core::{Emission, Emitter, Receiver};

use super::boundary::{SAME, Seen, Told, U, apart, drawn};
use crate::cases::sampler::Sampler;
use crate::checks::batches::{Cast, entry};

/// Units of roundoff times this pay for terms of second order.
const SECOND_ORDER: f64 = 1.05;

/// An emitter from a receiver as the bounds of batches have it.
struct Extent {
    /// Number of edges, the sum of their angles, the inverse of the distance of the nearest line, and the distance of the farthest vertex.
    edges: f64,
    angles: f64,
    nearest: f64,
    farthest: f64,
    /// Where the horizon crosses: the largest inverse of a crossing's distance, and the square of the largest angle that one is off by in units of
    /// 30 roundoffs.
    crossing: Option<[f64; 2]>,
}

impl Extent {
    fn new(seen: &Seen) -> Self {
        let of_edges = || seen.pieces.iter().filter_map(|piece| Some((piece, piece.edge.as_ref()?)));
        let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
        let farthest = largest(&mut seen.vertices.iter().map(|r| r.length()));
        let horizon = seen.pieces.iter().find(|piece| piece.edge.is_none());
        let crossing = horizon.map(|horizon| {
            let slant = |point: DVec3| {
                let of = |(k, a): (usize, &DVec3)| {
                    let e = seen.vertices[(k + 1) % seen.vertices.len()] - *a;
                    let distance = (point - *a).cross(e).length() / e.length_squared();
                    (distance, e.length() / seen.n1.dot(e).abs())
                };
                // The edge that it is on.
                let on = seen.vertices.iter().enumerate().map(of).min_by(|a, b| a.0.total_cmp(&b.0));
                on.map_or(f64::NAN, |(_, slant)| slant / point.length())
            };
            let nearest = largest(&mut horizon.ends.iter().map(|end| 1.0 / end.length()));
            [nearest, (farthest * largest(&mut horizon.ends.iter().map(|end| slant(*end)))).powi(2)]
        });
        Self {
            edges: seen.vertices.len() as f64,
            angles: of_edges().map(|(piece, _)| piece.angle).sum(),
            nearest: largest(&mut of_edges().map(|(_, edge)| 1.0 / edge.distance)),
            farthest,
            crossing,
        }
    }

    /// Value and gradient of a unit emission over pi, in a unit of roundoff.
    fn of_constant(&self, roundoff: f64) -> [f64; 2] {
        let Self { edges: n, angles, nearest: k, farthest, crossing } = *self;
        let u = SECOND_ORDER * roundoff;
        let c = k * farthest;
        // Of an arc tangent's two ulps half counts in the value.
        let mut value = u * angles * (5.7 * c + 17.0 + 0.5 * n);
        let mut gradient = u * angles * (50.0 * c + 78.0 + n);
        if let Some([nearest, slant]) = crossing {
            let c = nearest * farthest;
            let eta = (30.0 * u).powi(2) * slant;
            value += 4.0 * u * angles * c + 3.2 * eta + u * (16.0 * c + 7.5 + 2.0 * PI);
            gradient += 44.0 * u * angles * c + eta;
        }
        [value, k * gradient]
    }

    /// Value and gradient over pi of an emission whose largest size at a vertex and whose slope are known, at a height over the plane, with the
    /// sine of the angle between the two normals.
    fn of_linear(&self, [largest, steep]: [f64; 2], [h, sine]: [f64; 2]) -> [f64; 2] {
        let Self { edges, angles, nearest: k, farthest, crossing } = *self;
        let size = largest + steep * farthest;
        let (mut n, mut theta, mut c, mut crossed, mut eta) = (edges, angles, k * farthest, 0.0, 0.0);
        if let Some([nearest, slant]) = crossing {
            c = c.max(nearest * farthest).max(1.0 / sine);
            (n, theta, crossed, eta) = (n + 2.0, theta + PI, c, (30.0 * SECOND_ORDER * U).powi(2) * slant);
        }
        let by_angle = 31.0 * c + 116.0 + 3.0 * n + 0.5 * n * c + 40.0 * crossed;
        // 94.15, and 5 times 0.6 and 1.1 for the last products.
        let by_edge = 91.15 + 3.0 + 0.6 * n + (66.0 + 5.5 + 1.1 * n) * h / farthest + 98.0 * crossed;
        let units = theta * by_angle + n * by_edge;
        let beside = theta * (132.0 * c + 275.0 + 3.0 * n + 90.0 * crossed);
        let unit = SECOND_ORDER * U * size;
        [unit * units + 3.2 * size * eta, unit * (k * beside + units / h) + size * eta * (k + 6.3 / h)]
    }
}

/// Bounds of a drawn case on lanes of a precision, where lanes answer it.
pub(super) fn of_precision<F: Precision>(index: u64, cast: &Cast<F>) -> Told {
    let s = &mut Sampler::new(62, "derived", index);
    let (polygon, receiver) = drawn(s, 7)?;
    let round = |v: DVec3| v.map(|c| (cast.from)((cast.to)(c)));
    let receiver = Receiver::new(receiver.position(), round(receiver.direction()), receiver.reflectance())?;
    let Some(mut seen) = Seen::new(&receiver, &polygon) else { return Ok((0, Vec::new())) };
    // Lengths as they are.
    let power = seen.power;
    for piece in &mut seen.pieces {
        piece.ends = piece.ends.map(|end| end / power);
        if let Some(edge) = &mut piece.edge {
            edge.distance /= power;
        }
    }
    seen.vertices.iter_mut().for_each(|vertex| *vertex /= power);
    let (extent, height) = (Extent::new(&seen), seen.height / power);
    let value = [1.0, -0.75, 1.5][s.below(3) as usize];
    let slope = s.cube() * DVec3::new(1.0, 1.0, 0.0) * (s.spread(-8, 4) / polygon.size());
    let rho = (cast.from)((cast.to)(receiver.reflectance()));
    let roundoff = if cast.is_single() { f64::from(f32::EPSILON) / 2.0 } else { U };
    let mut told = (0, Vec::new());
    let mut ask = |name: &str, emission: Emission, derived: [f64; 2]| -> Result<(), radgrad_core::Error> {
        let emitter = Emitter::new(polygon.clone(), emission)?;
        let of = |v: DVec3| v.to_array().map(|c| [(cast.to)(c)]);
        let (x, n, rho_of) = (of(receiver.position()), of(receiver.direction()), [(cast.to)(receiver.reflectance())]);
        let receivers = Receivers::new([&x[0], &x[1], &x[2]], [&n[0], &n[1], &n[2]], &rho_of)?;
        let mut answers = Answers::<F>::default();
        Engine::new().evaluate_to(&receivers, &emitter, 1.0, &mut answers)?;
        if answers.counts.whole + answers.counts.clipped == 1 && answers.counts.doubled == 0 {
            let (_, _, stated) = entry(&answers, cast, 0);
            told.0 += 1;
            let same = if cast.is_single() { 1e-4 } else { SAME };
            told.1.extend(apart(&format!("derived:{index}, {name}"), same, stated, derived.map(|bound| rho / PI * bound)));
        }
        Ok(())
    };
    let [of_value, of_gradient] = extent.of_constant(roundoff);
    ask("constant, on lanes", Emission::Constant(value), [of_value, of_gradient].map(|bound| value.abs() * bound))?;
    if !cast.is_single() {
        let vertices = polygon.vertices();
        let largest = vertices.iter().map(|v| (value + slope.dot(*v - vertices[0])).abs()).fold(0.0, f64::max);
        let derived = extent.of_linear([largest, slope.length()], [height, seen.n1.cross(seen.n2).length()]);
        ask("linear, on lanes", Emission::gradient(value, slope), derived)?;
    }
    Ok(told)
}
