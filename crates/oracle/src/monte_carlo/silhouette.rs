//! The edges along which the seen part of an emitter ends, for the gradient with occluders.
//!
//! The part of the gradient that comes from the motion of the visible region is an integral along the generating edges, of the
//! emitter and of the occluders (their real edges, not their shadows), each taken with the visible region on its left: `(rho/pi)
//! sum int B(y) (n1.omega) (e x omega) / |r|^2 dt`, `r` the point of the edge at `t`, `omega = r/|r|`, `y` the emitter's point
//! behind.
//!
//! The emitter's own edges are those of its region: which side of one is the emitter, and `n1.r` and `B` along it, are known
//! there, however close the receiver is to the plane, however narrow or far the emitter; only occluders in front of them are to be
//! looked for. An edge of an occluder counts where it is seen against the emitter on either side, nothing hides the emitter just
//! left of it, and its own polygon hides it just right of it. Polygons that share an edge as seen from `x` (the faces of a box)
//! would both count it: the first in the list does. Not sampled is the line in which an occluder crosses the emitter itself: it
//! bounds the visible part and is an edge of neither, so that gradients there lack its term, and values do not.

use glam::DVec3;

use crate::Error;
use crate::cubature::integrand::Integrand;
use crate::monte_carlo::arc::Arc;
use crate::monte_carlo::visibility::{Occluders, SeenPolygon};
use crate::region::plane::{Edge, Vertex};
use crate::region::{FrameVector, Region};

/// Distance beside an edge at which visibility is decided: this share of the edge's length or of its distance, whichever
/// is less,
const BESIDE: f64 = 1e-8;

/// but this share of the distance at least, since a direction is known to 1e-15.
const LEAST_BESIDE: f64 = 1e-11;

/// Occluders hide nothing that is less than this part of the way beside an edge in front of the emitter, so that one that lies in
/// its plane does not hide it, and one that stands on it does unless it leans by less than that.
const AGAINST: f64 = 0.01;

/// An edge with the visible part on its left.
#[derive(Debug)]
struct GeneratingEdge {
    arc: Arc,
    length: f64,
    /// `r x e`, the same all along it.
    moment: DVec3,
    along: DVec3,
    owner: Owner,
}

/// The polygon of an edge.
#[derive(Debug)]
enum Owner {
    Emitter(Edge),
    Occluder { index: usize, ends: [DVec3; 2] },
}

/// The edges of an emitter and of occluders as a distribution to sample.
#[derive(Debug)]
pub(crate) struct Silhouette<'a> {
    edges: Vec<GeneratingEdge>,
    /// Sums of the measures `int dl/r^2` of the edges up to and with each.
    cumulated: Vec<f64>,
    occluders: &'a Occluders,
    region: &'a Region,
    integrand: Integrand<'a>,
}

impl<'a> Silhouette<'a> {
    pub(crate) fn new(region: &'a Region, integrand: Integrand<'a>, occluders: &'a Occluders) -> Result<Self, Error> {
        // On the horizon, `n1.r = 0`, nothing is gained or lost.
        let lit = |edge: &&Edge| edge.ends.iter().any(|end| end.s > 0.0);
        let own = |edge: &Edge| GeneratingEdge::of_emitter(region, integrand.moment(edge), edge);
        let mut edges: Vec<_> = region.outline.iter().filter(lit).map(own).collect();
        for (index, occluder) in occluders.polygons.iter().enumerate() {
            edges.extend(occluder_edges(occluder, index));
        }
        let mut total = 0.0;
        let cumulate = |edge: &GeneratingEdge| {
            total += edge.arc.measure;
            total
        };
        let cumulated: Vec<f64> = edges.iter().map(cumulate).collect();
        if !total.is_finite() {
            return Err(Error::Touching { position: region.position, what: "an edge" });
        }
        Ok(Self { edges, cumulated, occluders, region, integrand })
    }

    /// Bound on the length of a contribution over the emission: its `|r x e| (n1.r) / (|r|^2 |e|)` is at most 1.
    pub(crate) fn total(&self) -> f64 {
        self.cumulated.last().copied().unwrap_or(0.0)
    }

    /// The contribution of the edge and place that belong to `(u, v)` of the unit square, divided by their density `1 / (|r|^2
    /// total)` with respect to length; zero without edges.
    pub(crate) fn sample(&self, [u, v]: [f64; 2]) -> DVec3 {
        let place = u * self.total();
        let index = self.cumulated.partition_point(|sum| *sum <= place).min(self.edges.len().saturating_sub(1));
        let Some(edge) = self.edges.get(index) else { return DVec3::ZERO };
        let weights = edge.arc.weights(v);
        let sample = match &edge.owner {
            Owner::Emitter(border) => self.at_emitter(edge, &border.between(weights)),
            Owner::Occluder { index, ends } => self.at_occluder(edge, *index, ends[0] * weights[0] + ends[1] * weights[1]),
        };
        let Some((emission, incidence, squared)) = sample else { return DVec3::ZERO };
        edge.moment * (-emission * incidence * self.total() / (squared * edge.length))
    }

    /// `B`, `n1.r` and `r^2` at a point of the emitter's border, if it is seen.
    fn at_emitter(&self, edge: &GeneratingEdge, at: &Vertex) -> Option<(f64, f64, f64)> {
        let (ray, inverse) = self.integrand.ray(at);
        let ray = self.region.to_space(ray);
        (!self.occluders.block(edge.beside(self.region, ray, ray))).then(|| (self.integrand.emission(at), at.s, 1.0 / inverse))
    }

    /// `B` of the emitter behind a point of an occluder's edge, `n1.r` and `r^2` of the point itself, if the emitter is seen
    /// just left of it and not just right.
    fn at_occluder(&self, edge: &GeneratingEdge, index: usize, ray: DVec3) -> Option<(f64, f64, f64)> {
        let [u, v, n2] = self.region.axes;
        let lengthening = -self.region.height / n2.dot(ray);
        if !(lengthening > 0.0 && lengthening.is_finite()) {
            return None;
        }
        let behind = ray * lengthening;
        let vertex = self.region.vertex(u.dot(behind), v.dot(behind))?;
        let [left, right] = [ray, -ray].map(|through| edge.beside(self.region, behind, through));
        // Where the emitter's own border passes by, that border bounds the visible part, and the occluder's edge does not.
        let is_border = [left, right].iter().any(|beside| self.region.vertex(u.dot(*beside), v.dot(*beside)).is_none());
        let hidden = !is_border
            && self.occluders.polygons[index].blocks(right)
            && !self.occluders.polygons[..index].iter().any(|earlier| earlier.blocks(right));
        let counts = hidden && !self.occluders.block(left);
        counts.then(|| (self.integrand.emission(&vertex), vertex.s / lengthening, ray.length_squared()))
    }
}

/// The edges of an occluder, clockwise as seen from the receiver; none if it is edge-on.
fn occluder_edges(polygon: &SeenPolygon, index: usize) -> Vec<GeneratingEdge> {
    if polygon.offset == 0.0 {
        return Vec::new();
    }
    let count = polygon.rays.len();
    let edge = |i: usize| {
        let (from, to) = (polygon.rays[i], polygon.rays[(i + 1) % count]);
        // The vertices are counter-clockwise seen from where the normal points to: from the receiver if offset < 0.
        GeneratingEdge::of_occluder(index, if polygon.offset < 0.0 { [to, from] } else { [from, to] })
    };
    (0..count).map(edge).collect()
}

impl GeneratingEdge {
    fn of_emitter(region: &Region, moment: FrameVector, edge: &Edge) -> Self {
        let [a, b] = edge.ends.map(|end| FrameVector::new(end.p, end.q, -region.height));
        let along = FrameVector::new(edge.along[0], edge.along[1], 0.0);
        let arc = Arc::new([a.norm(), b.norm()], a.dot(&b), along.norm(), moment.norm());
        let [moment, space_along] = [moment, along].map(|v| region.to_space(v));
        Self { arc, length: along.norm(), moment, along: space_along, owner: Owner::Emitter(*edge) }
    }

    fn of_occluder(index: usize, ends: [DVec3; 2]) -> Self {
        let [from, to] = ends;
        let (moment, along) = (from.cross(to), to - from);
        let arc = Arc::new([from.length(), to.length()], from.dot(to), along.length(), moment.length());
        Self { arc, length: along.length(), moment, along, owner: Owner::Occluder { index, ends } }
    }

    /// A ray just left of `ray`, or just right with `through` reversed, that ends just short of the emitter's plane.
    fn beside(&self, region: &Region, ray: DVec3, through: DVec3) -> DVec3 {
        let across = self.along.cross(through);
        let (length, distance) = (across.length(), ray.length());
        let share = (BESIDE * self.length / distance).clamp(LEAST_BESIDE, BESIDE);
        let aside = if length > 0.0 { ray + across * (share * distance / length) } else { ray };
        // The step aside is across the ray, which leaves the plane where that is seen at a slant.
        let onto = -region.height / region.axes[2].dot(aside);
        let onto = if (0.5..2.0).contains(&onto) { onto } else { 1.0 };
        aside * (onto * (1.0 - AGAINST * share))
    }
}
