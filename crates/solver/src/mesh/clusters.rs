//! Clusters: a tree of boxes over the coarsest elements, with bounds on a point's light from one (B. Smits, J. Arvo and D.
//! Greenberg 1994; F. Sillion 1995).
//!
//! A point x with normal n1 gets `int B k dA` from the elements in a box, with `k = cos1 cos2 / pi r^2` where it sees them and 0
//! where it does not. Let d be the distance of the box from x, and h the largest height of the box over the horizon, so that
//! `cos1 <= h/d`. The normals of the elements are in a box of their own, and the largest `-n2.r` over both boxes bounds cos2. So
//!
//! - `k <= (h/d) cos2 / pi d^2`, the peak: with the power of the cluster it bounds the light at x;
//! - all that x sees of it is seen through the sides of the box that face x, at most three, each of which has a form factor of at
//!   most `cos1 a A / pi d^3`, with a the height of x over the side, A its area and d its distance: with the largest radiosity in
//!   it these bound the light at x.
//!
//! Elements are put together whose normals are nearest to the same axis, among these those that emit by themselves and those that do not, and
//! among these those that are near each other: elements that face away from x are dismissed as one, those that glow overhead are not taken
//! together with those below, and a lamp of many faces not with the ceiling around it.

use std::ops::Range;

use radgrad_core::DVec3;
use radgrad_scene::largest;

use crate::mesh::element::{Element, around};
use crate::mesh::screen::LEVEL;

/// Elements below which there are no clusters. A few hundred are linked to all others quickly enough, and the light that clusters
/// neglect is known no better than was asked for: light in a closed room that glows evenly is even to all digits only by links.
pub(crate) const FEWEST: usize = 1000;

/// Factor of bounds, for the rounding of their products.
pub(crate) const ROUNDED: f64 = 1.0 + 1e-12;

/// The tree; empty over few elements.
#[derive(Debug, Default)]
pub(crate) struct Clusters {
    /// A cluster comes before its parts, with nothing else between them.
    all: Vec<Cluster>,
    /// For each cluster the index after that of the last one in it.
    ends: Vec<usize>,
    /// For each element the cluster that is it alone.
    singles: Vec<usize>,
    /// Whether no point can see two elements in one direction.
    apart: bool,
}

/// Some elements, and boxes around them and around their normals.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cluster {
    pub(crate) low: DVec3,
    pub(crate) high: DVec3,
    pub(crate) normals: [DVec3; 2],
    area: f64,
    /// Whether the first of its elements emits.
    emits: bool,
    pub(crate) parts: Parts,
}

/// The parts of a cluster.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Parts {
    /// One of the coarsest elements.
    Element(usize),
    /// Two clusters.
    Two([usize; 2]),
}

impl Cluster {
    fn single_element(index: usize, element: &Element, emits: bool) -> Self {
        let (normal, [low, high]) = (element.polygon().normal(), around(element.polygon().vertices()));
        Self { low, high, normals: [normal; 2], area: element.area(), emits, parts: Parts::Element(index) }
    }

    fn and(self, other: &Self) -> Self {
        let normals = [self.normals[0].min(other.normals[0]), self.normals[1].max(other.normals[1])];
        let (low, high) = (self.low.min(other.low), self.high.max(other.high));
        Self { low, high, normals, area: self.area + other.area, ..self }
    }

    /// The axis that the first of its normals is nearest to, and its sense.
    fn facing(&self) -> usize {
        let size = self.normals[0].abs();
        let axis = if size.x >= largest(size.y, size.z) { 0 } else { usize::from(size.z > size.y) + 1 };
        2 * axis + usize::from(self.normals[0][axis] < 0.0)
    }

    /// The element that it consists of, if it is only one.
    const fn element(&self) -> Option<usize> {
        if let Parts::Element(element) = self.parts { Some(element) } else { None }
    }

    /// Area of its elements.
    pub(crate) const fn area(&self) -> f64 {
        self.area
    }

    /// Whether it has a point in front of an element, and the element one that may be in front of it.
    pub(crate) fn faces(&self, element: &Element) -> bool {
        let (centre, normal, radius) = (element.centre(), element.polygon().normal(), element.radius());
        let (low, high) = (self.low - centre, self.high - centre);
        let reach = low.abs().max(high.abs()).length() + radius;
        // Toward all points of the element.
        let toward = most_toward(self.normals, low - radius, high + radius);
        highest(normal, low, high) > LEVEL * reach && toward > -LEVEL * reach
    }
}

/// The largest height of a box over a plane through the origin.
pub(crate) fn highest(normal: DVec3, low: DVec3, high: DVec3) -> f64 {
    let products = (normal * low).max(normal * high);
    products.x + products.y + products.z
}

/// The largest `-n.y` over a box of normals and a box of points.
pub(crate) fn most_toward([from, to]: [DVec3; 2], low: DVec3, high: DVec3) -> f64 {
    let least = (from * low).min(from * high).min(to * low).min(to * high);
    -(least.x + least.y + least.z)
}

impl Clusters {
    /// The tree over elements that are no part of another, of faces of which these emit.
    pub(crate) fn over(elements: &[Element], emits: &[bool]) -> Self {
        if elements.len() < FEWEST { Self::default() } else { Self::always_over(elements, emits) }
    }

    /// The same over few elements too.
    pub(crate) fn always_over(elements: &[Element], emits: &[bool]) -> Self {
        let single = |(index, element): (usize, &Element)| Cluster::single_element(index, element, emits[element.face()]);
        let mut singles: Vec<Cluster> = elements.iter().enumerate().map(single).collect();
        let mut clusters = Self { all: Vec::with_capacity(2 * singles.len()), ..Self::default() };
        if !singles.is_empty() {
            build(&mut clusters.all, &mut singles);
        }
        clusters.ends = vec![0; clusters.all.len()];
        clusters.singles = vec![0; elements.len()];
        for (index, cluster) in clusters.all.iter().enumerate().rev() {
            clusters.ends[index] = match cluster.parts {
                Parts::Two([_, last]) => clusters.ends[last],
                Parts::Element(element) => {
                    clusters.singles[element] = index;
                    index + 1
                }
            };
        }
        clusters.apart = !clusters.any_overlap(elements);
        clusters
    }

    /// The cluster of all elements, if there are any.
    pub(crate) fn root(&self) -> Option<usize> {
        (!self.all.is_empty()).then_some(0)
    }

    pub(crate) fn clusters(&self) -> &[Cluster] {
        &self.all
    }

    /// The cluster that is one element alone.
    pub(crate) fn single(&self, element: usize) -> usize {
        self.singles[element]
    }

    /// A cluster and all in it.
    pub(crate) fn within(&self, cluster: usize) -> Range<usize> {
        cluster..self.ends[cluster]
    }

    /// Whether no point can see two elements in one direction, so that form factors sum to at most 1.
    pub(crate) const fn are_apart(&self) -> bool {
        self.apart
    }

    /// For each cluster the value joined from its elements.
    pub(crate) fn pull<T: Copy>(&self, of_element: impl Fn(usize) -> T, join: impl Fn(T, T) -> T) -> Vec<T> {
        // The last cluster first: so the parts of each are there before it.
        let mut pulled: Vec<T> = Vec::with_capacity(self.all.len());
        for cluster in self.all.iter().rev() {
            let value = match cluster.parts {
                Parts::Element(element) => of_element(element),
                Parts::Two(parts) => {
                    let [a, b] = parts.map(|part| pulled[self.all.len() - 1 - part]);
                    join(a, b)
                }
            };
            pulled.push(value);
        }
        pulled.reverse();
        pulled
    }
}

/// Adds the cluster of some and all below it; returns its index.
fn build(all: &mut Vec<Cluster>, singles: &mut [Cluster]) -> usize {
    let index = all.len();
    let whole = singles[1..].iter().fold(singles[0], |whole, single| whole.and(single));
    all.push(whole);
    if singles.len() > 1 {
        let middle = by_facing(singles).or_else(|| by_emission(singles)).unwrap_or_else(|| by_place(singles));
        let (lower, upper) = singles.split_at_mut(middle);
        let lower = build(all, lower);
        let upper = build(all, upper);
        all[index].parts = Parts::Two([lower, upper]);
    }
    index
}

/// Sorts by the way they face; the start of the second half, if they do not all face the same.
fn by_facing(singles: &mut [Cluster]) -> Option<usize> {
    singles.sort_by_key(|single| (single.facing(), single.element()));
    let (first, last) = (singles[0].facing(), singles[singles.len() - 1].facing());
    (first != last).then(|| singles.partition_point(|single| 2 * single.facing() < first + last))
}

/// Sorts by whether they emit; the first that does, if they are not all alike.
fn by_emission(singles: &mut [Cluster]) -> Option<usize> {
    let dark = singles.iter().filter(|single| !single.emits).count();
    if dark == 0 || dark == singles.len() {
        return None;
    }
    singles.sort_by_key(|single| (single.emits, single.element()));
    Some(dark)
}

/// Halves them along the axis on which they are farthest apart.
fn by_place(singles: &mut [Cluster]) -> usize {
    let middle = singles.len() / 2;
    let around = |[low, high]: [DVec3; 2], single: &Cluster| {
        let centre = single.low + single.high;
        [low.min(centre), high.max(centre)]
    };
    let [low, high] = singles.iter().fold([DVec3::INFINITY, DVec3::NEG_INFINITY], around);
    let size = high - low;
    let axis = if size.x >= largest(size.y, size.z) { 0 } else { usize::from(size.z > size.y) + 1 };
    let place = |single: &Cluster| single.low[axis] + single.high[axis];
    singles.select_nth_unstable_by(middle, |a, b| place(a).total_cmp(&place(b)).then(a.element().cmp(&b.element())));
    middle
}
