//! The edges along which the seen part of an emitter ends, for the gradient past occluders.
//!
//! The part of the gradient that comes from the motion of what is seen is an integral along the generating edges, of the
//! emitter and of the occluders (their real edges, not their shadows), each taken with what is seen on its left: `(rho/pi) sum
//! int B(y) (n1.omega) (e x omega) / |r|^2 dt`, `r` the point of the edge at `t`, `omega = r/|r|`, `y` the emitter's point
//! behind. An edge counts where what is just left of it is seen and what is just right of it is not. Polygons that share an
//! edge as seen from `x` (the faces of a box) would both count it: the first in the list does.

use glam::DVec3;
use radgrad_core::Polygon;

use crate::Error;
use crate::monte_carlo::visibility::{Occluders, SeenPolygon};
use crate::region::Region;
use crate::source_function::SourceFunction;

/// How far beside an edge, over the distance, it is decided what is seen there.
const BESIDE: f64 = 1e-8;

/// An edge as a ray and a direction, with what is seen on its left.
#[derive(Debug)]
struct GeneratingEdge {
    from: DVec3,
    along: DVec3,
    /// Index of its occluder; none for the emitter.
    occluder: Option<usize>,
}

/// The edges of an emitter and of occluders as a distribution to sample.
#[derive(Debug)]
pub(crate) struct Silhouette<'a> {
    edges: Vec<GeneratingEdge>,
    /// Sums of the bounds `|e| / distance^2` of the edges up to and with each.
    cumulated: Vec<f64>,
    emitter: SeenPolygon,
    occluders: &'a Occluders,
    region: &'a Region,
    source: SourceFunction<'a>,
    normal: DVec3,
}

impl<'a> Silhouette<'a> {
    pub(crate) fn new(
        region: &'a Region,
        polygon: &Polygon,
        source: SourceFunction<'a>,
        occluders: &'a Occluders,
    ) -> Result<Self, Error> {
        let emitter = SeenPolygon::new(region.position, region.unit, polygon);
        let mut edges = generating_edges(&emitter, None);
        for (index, occluder) in occluders.polygons.iter().enumerate() {
            edges.extend(generating_edges(occluder, Some(index)));
        }
        let mut total = 0.0;
        let cumulate = |edge: &GeneratingEdge| {
            total += edge.along.length() / edge.squared_distance();
            total
        };
        let cumulated: Vec<f64> = edges.iter().map(cumulate).collect();
        if !total.is_finite() {
            return Err(Error::Touching { position: region.position, what: "an edge" });
        }
        let normal = region.to_space(region.normal);
        Ok(Self { edges, cumulated, emitter, occluders, region, source, normal })
    }

    /// Bound on `|e| (n1.omega) / |r|^2` over the edge drawn, divided by the probability to draw it.
    pub(crate) fn total(&self) -> f64 {
        self.cumulated.last().copied().unwrap_or(0.0)
    }

    /// The contribution of the edge and place that belong to `(u, v)` of the unit square, divided by their density.
    pub(crate) fn sample(&self, [u, v]: [f64; 2]) -> DVec3 {
        let place = u * self.total();
        let index = self.cumulated.partition_point(|sum| *sum <= place).min(self.edges.len() - 1);
        let edge = &self.edges[index];
        let probability = edge.along.length() / edge.squared_distance() / self.total();
        let ray = edge.from + edge.along * v;
        let incidence = self.normal.dot(ray);
        if incidence <= 0.0 || !self.is_border(edge, ray) {
            return DVec3::ZERO;
        }
        let Some(seen) = self.to_plane(ray) else { return DVec3::ZERO };
        let emission = self.source.at(self.region.position + seen / self.region.unit);
        let squared = ray.length_squared();
        edge.along.cross(ray) * (emission * incidence / (squared * squared) / probability)
    }

    /// Whether the emitter is seen just left of the edge and not just right of it.
    fn is_border(&self, edge: &GeneratingEdge, ray: DVec3) -> bool {
        let left = edge.along.cross(ray);
        let beside = left * (BESIDE * ray.length() / left.length());
        let seen = self.to_plane(ray + beside).is_some_and(|to| self.emitter.covers(to) && !self.occluders.block(to));
        let Some(index) = edge.occluder else { return seen };
        let hidden = |to: DVec3| {
            let earlier = self.occluders.polygons[..index].iter().any(|other| other.blocks(to));
            self.occluders.polygons[index].blocks(to) && !earlier
        };
        seen && self.to_plane(ray - beside).is_some_and(hidden)
    }

    /// The ray lengthened or shortened to the emitter's plane.
    fn to_plane(&self, ray: DVec3) -> Option<DVec3> {
        let descent = -self.region.axes[2].dot(ray);
        (descent > 0.0).then(|| ray * (self.region.height / descent))
    }
}

/// The edges of a polygon: counter-clockwise as seen from the receiver for the emitter, clockwise for an occluder, none if
/// edge-on.
fn generating_edges(polygon: &SeenPolygon, occluder: Option<usize>) -> Vec<GeneratingEdge> {
    if polygon.offset == 0.0 {
        return Vec::new();
    }
    // The vertices are counter-clockwise seen from where the normal points to: from the receiver if offset < 0.
    let keep = (polygon.offset < 0.0) == occluder.is_none();
    let count = polygon.rays.len();
    let edge = |i: usize| {
        let (from, to) = (polygon.rays[i], polygon.rays[(i + 1) % count]);
        let (from, to) = if keep { (from, to) } else { (to, from) };
        GeneratingEdge { from, along: to - from, occluder }
    };
    (0..count).map(edge).collect()
}

impl GeneratingEdge {
    /// Square of the distance from the receiver.
    fn squared_distance(&self) -> f64 {
        let t = -self.from.dot(self.along) / self.along.length_squared();
        (self.from + self.along * t.clamp(0.0, 1.0)).length_squared()
    }
}
