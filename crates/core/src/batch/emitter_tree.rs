//! A tree over emitters: which of them may be left out, or answered together, for a receiver and an error.
//!
//! Emitters with as many vertices are sorted so that those of a node are next to each other: first by the way they face, until a
//! node's normals are within [`FACING`] of their mean, then by place. Each node has the bounds of [`crate::batch::cluster`], and
//! those with enough emitters the far field of [`crate::batch::far_field`], which is found when the first receiver asks for it: few
//! nodes are ever asked.

use std::borrow::Cow;
use std::sync::OnceLock;

use glam::DVec3;

use crate::batch::cluster::{Cluster, fan};
use crate::batch::far_field::FarField;
use crate::batch::lamps::{Kind, Lamps, kinds};
use crate::batch::many_emitters::common_power;
use crate::problem::emission::Emitter;

/// Emitters of a leaf at most: two vectors of double precision.
const LEAF: usize = 16;

/// Fewest emitters of a node with a far field, and how many nodes of that an emitter is worth.
const FEWEST: usize = 12;
const WORTH: usize = 12;

/// Distance of a normal from the mean of a node's, up to which the node may have a far field.
const FACING: f64 = 0.5;

/// Emitters of a node from which on its children are built on two threads.
#[cfg(feature = "threads")]
const TO_SHARE: usize = 4096;

/// Emitters in a tree, made once for any number of receivers. Constant and linear emitters go into the tree; polynomial and concave
/// ones, and those beyond the range of double precision, are answered one by one for every receiver.
///
/// A far field is found when a receiver first asks for it, so that the first receivers take longer than those that follow.
///
/// ```
/// use radgrad_core::batch::{Answers, EmitterTree, Engine, Receivers};
/// // A square lamp of side 1, a length over the floor, as 50 x 50 emitters.
/// # use radgrad_core::{DVec3, Emission, Emitter, Polygon};
/// # let cell = |i: u32| {
/// #     let (x, y) = (f64::from(i % 50) * 0.02, f64::from(i / 50) * 0.02);
/// #     let corners = [(0.0, 0.0), (0.0, 0.02), (0.02, 0.02), (0.02, 0.0)].map(|(u, v)| DVec3::new(x + u, y + v, 1.0));
/// #     Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))
/// # };
/// # let ceiling = (0..2500).map(cell).collect::<Result<Vec<_>, _>>()?;
///
/// let tree = EmitterTree::new(&ceiling);
/// let corner = Receivers::new([&[0.0]; 3], [&[0.0], &[0.0], &[1.0]], &[1.0])?;
/// let mut answers = Answers::new();
/// Engine::new().total(&corner, &tree, 1e-4, &mut answers)?;
/// assert!((answers.radiosity[0] - 0.138_531_605_994_893).abs() <= answers.radiosity_error[0]);
/// assert!(answers.radiosity_error[0] <= 1e-4);
/// # Ok::<(), radgrad_core::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct EmitterTree<'a> {
    pub(super) emitters: Cow<'a, [Emitter]>,
    pub(super) groups: Vec<Grove>,
    /// Emitters that are in no group.
    pub(super) others: Vec<usize>,
    pub(super) power: f64,
}

/// Emitters of a kind with as many vertices, and the tree over them, a node before its children.
#[derive(Debug, Clone)]
pub(super) struct Grove {
    pub(super) lamps: Lamps,
    pub(super) nodes: Vec<Node>,
}

/// Some emitters of a group that are next to each other.
#[derive(Debug, Clone)]
pub(super) struct Node {
    pub(super) first: usize,
    pub(super) count: usize,
    pub(super) cluster: Cluster,
    /// Its far field, where it was asked for and is worth it.
    far: OnceLock<Option<Box<FarField>>>,
    /// How many nodes on the second child is; the first is the next node. None for a leaf.
    pub(super) second: Option<usize>,
}

impl Node {
    /// The far field, where it is worth it.
    pub(super) fn far_field(&self, lamps: &Lamps) -> Option<&FarField> {
        let find = || {
            let Self { first, count, cluster, .. } = self;
            if *count < FEWEST || cluster.spread > FACING {
                return None;
            }
            let degree = FarField::degree(cluster);
            let worth = degree.iter().map(|degree| degree + 1).product::<usize>() <= WORTH * count;
            worth.then(|| Box::new(FarField::new(cluster, degree, lamps, *first..first + count)))
        };
        self.far.get_or_init(find).as_deref()
    }
}

impl<'a> EmitterTree<'a> {
    /// Sorts emitters into a tree.
    #[must_use]
    pub fn new(emitters: &'a [Emitter]) -> Self {
        Self::over(Cow::Borrowed(emitters))
    }

    fn over(all: Cow<'a, [Emitter]>) -> Self {
        let emitters = &*all;
        let power = common_power::<f64>(emitters);
        let (convex, concave): (Vec<_>, Vec<_>) = (0..emitters.len()).partition(|i| fans_out(&emitters[*i]));
        let (kinds, mut others) = kinds(emitters, &convex, power);
        others.extend(concave);
        let grove = |(kind, mut order): (Kind, Vec<usize>)| {
            let nodes = Builder { emitters, power }.nodes(0, &mut order);
            Grove { lamps: Lamps::new(kind, emitters, order, power), nodes }
        };
        let groups = kinds.into_iter().map(grove).collect();
        Self { emitters: all, groups, others, power }
    }

    /// Number of emitters.
    ///
    /// ```
    /// # use radgrad_core::{DVec3, Emission, Emitter, Polygon, batch::EmitterTree};
    /// let lamp = Emitter::new(Polygon::new(vec![DVec3::X, DVec3::Y, DVec3::Z])?, Emission::Constant(1.0))?;
    /// assert_eq!(EmitterTree::new(&[lamp.clone(), lamp]).count(), 2);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub fn count(&self) -> usize {
        self.emitters.len()
    }
}

impl EmitterTree<'static> {
    /// The same with emitters of its own.
    #[must_use]
    pub fn owning(emitters: Vec<Emitter>) -> Self {
        Self::over(Cow::Owned(emitters))
    }
}

/// Whether the fan of triangles from vertex 0 covers the polygon once, as it does a convex one.
fn fans_out(emitter: &Emitter) -> bool {
    let normal = emitter.polygon().normal();
    fan(emitter.polygon(), 1.0).all(|[a, b, c]| normal.dot((b - a).cross(c - a)) >= 0.0)
}

struct Builder<'a> {
    emitters: &'a [Emitter],
    power: f64,
}

impl Builder<'_> {
    /// A node with those below it: sorts its emitters, the first of which comes at `first`.
    fn nodes(&self, first: usize, order: &mut [usize]) -> Vec<Node> {
        #[cfg(feature = "threads")]
        if order.len() >= TO_SHARE {
            let (mut node, middle) = self.node(first, order);
            let (left, right) = order.split_at_mut(middle);
            let (mut left, mut right) = rayon::join(|| self.nodes(first, left), || self.nodes(first + middle, right));
            node.second = Some(1 + left.len());
            let mut nodes = Vec::with_capacity(1 + left.len() + right.len());
            nodes.push(node);
            nodes.append(&mut left);
            nodes.append(&mut right);
            return nodes;
        }
        let mut nodes = Vec::with_capacity(4 * order.len() / LEAF + 1);
        self.add(first, order, &mut nodes);
        nodes
    }

    /// Appends a node with those below it.
    fn add(&self, first: usize, order: &mut [usize], nodes: &mut Vec<Node>) {
        let place = nodes.len();
        let (node, middle) = self.node(first, order);
        nodes.push(node);
        if order.len() <= LEAF {
            return;
        }
        let (left, right) = order.split_at_mut(middle);
        self.add(first, left, nodes);
        nodes[place].second = Some(nodes.len() - place);
        self.add(first + middle, right, nodes);
    }

    /// A node alone, and where its emitters are cut; a leaf is not.
    fn node(&self, first: usize, order: &mut [usize]) -> (Node, usize) {
        let cluster = Cluster::new(self.emitters, order, self.power);
        let facing = cluster.spread <= FACING;
        let node = Node { first, count: order.len(), cluster, far: OnceLock::new(), second: None };
        let middle = if order.len() <= LEAF { 0 } else { self.split(facing, order) };
        (node, middle)
    }

    /// Orders the emitters along where their middles, or their normals, are spread most, and says where to cut.
    fn split(&self, facing: bool, order: &mut [usize]) -> usize {
        let key = |index: usize| {
            let polygon = self.emitters[index].polygon();
            if facing { polygon.vertices().iter().sum::<DVec3>() / polygon.vertices().len() as f64 } else { polygon.normal() }
        };
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for index in order.iter() {
            (low, high) = (low.min(key(*index)), high.max(key(*index)));
        }
        let extent = high - low;
        let axis = if extent.x >= extent.y && extent.x >= extent.z {
            0
        } else if extent.y >= extent.z {
            1
        } else {
            2
        };
        let along = |index: usize| key(index).to_array()[axis];
        let middle = order.len() / 2;
        if facing {
            order.select_nth_unstable_by(middle, |a, b| along(*a).total_cmp(&along(*b)).then(a.cmp(b)));
            return middle;
        }
        // Where the normals are farthest apart: at the middle of their range.
        let cut = 0.5 * (low + high).to_array()[axis];
        order.sort_unstable_by(|a, b| along(*a).total_cmp(&along(*b)).then(a.cmp(b)));
        order.partition_point(|index| along(*index) <= cut).clamp(1, order.len() - 1)
    }
}
