//! A tree over emitters: which of them may be left out, or answered together, for a receiver and an error.
//!
//! Emitters with as many vertices are sorted so that those of a node are next to each other: first by the way they face, until a
//! node's normals are within [`FACING`] of their mean, then by place. Each node has the bounds of [`crate::batch::cluster`], and
//! those with enough emitters the far field of [`crate::batch::far_field`], which is found when the first receiver asks for it: few
//! nodes are ever asked.

use std::borrow::Cow;
use std::cmp::Ordering;
use std::sync::OnceLock;

use glam::DVec3;

use crate::batch::cluster::Cluster;
use crate::batch::far_field::FarField;
use crate::batch::lamps::{Kind, Lamps, kinds};
use crate::batch::many_emitters::common_power;
use crate::batch::shapes::{Shapes, fan};
use crate::batch::tile::join;
use crate::problem::emission::Emitter;

/// Emitters of a leaf at most: two vectors of double precision.
const LEAF: usize = 16;

/// Fewest emitters of a node with a far field, and how many nodes of that an emitter is worth.
const FEWEST: usize = 12;
const WORTH: usize = 12;

/// Distance of a normal from the mean of a node's, up to which the node may have a far field.
const FACING: f64 = 0.5;

/// Emitters of a node from which on its children are built on two threads.
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
    /// Its far field, where it was requested and is worth it.
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

    fn over(given: Cow<'a, [Emitter]>) -> Self {
        let emitters = &*given;
        let power = common_power::<f64>(emitters);
        let (convex, concave): (Vec<_>, Vec<_>) = (0..emitters.len()).partition(|i| fans_out(&emitters[*i]));
        let (kinds, mut others) = kinds(emitters, &convex, power);
        others.extend(concave);
        let grove = |(kind, mut order): (Kind, Vec<usize>)| {
            let shapes = Shapes::new(emitters, &order, power);
            let nodes = Branch { first: 0, order: &mut order, shapes }.nodes();
            Grove { lamps: Lamps::new(kind, emitters, order, power), nodes }
        };
        let groups = kinds.into_iter().map(grove).collect();
        Self { emitters: given, groups, others, power }
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

/// The emitters of a node while the tree is built.
struct Branch<'a> {
    /// Where the first comes in the tree.
    first: usize,
    order: &'a mut [usize],
    /// Their shapes, in that order.
    shapes: Shapes,
}

impl Branch<'_> {
    /// The node with those below it.
    fn nodes(self) -> Vec<Node> {
        let count = self.order.len();
        if count < TO_SHARE {
            let mut nodes = Vec::with_capacity(4 * count / LEAF + 1);
            self.add(&mut nodes);
            return nodes;
        }
        let mut node = self.node();
        let [left, right] = self.halves(&node);
        let (mut left, mut right) = both(count, || left.nodes(), || right.nodes());
        node.second = Some(1 + left.len());
        let mut nodes = Vec::with_capacity(1 + left.len() + right.len());
        nodes.push(node);
        nodes.append(&mut left);
        nodes.append(&mut right);
        nodes
    }

    /// Appends the node with those below it.
    fn add(self, nodes: &mut Vec<Node>) {
        let (place, node) = (nodes.len(), self.node());
        if self.order.len() <= LEAF {
            nodes.push(node);
            return;
        }
        let [left, right] = self.halves(&node);
        nodes.push(node);
        left.add(nodes);
        nodes[place].second = Some(nodes.len() - place);
        right.add(nodes);
    }

    /// The node alone.
    fn node(&self) -> Node {
        let Self { first, shapes, .. } = self;
        Node { first: *first, count: shapes.count(), cluster: Cluster::new(shapes), far: OnceLock::new(), second: None }
    }
}

impl<'a> Branch<'a> {
    /// Sorts the emitters of a node along where their middles, or their normals, are spread most, and cuts them in two.
    fn halves(self, node: &Node) -> [Self; 2] {
        let Self { first, order, shapes } = self;
        let (ranks, middle) = ranked(node.cluster.spread <= FACING, order, &shapes);
        for (index, rank) in order.iter_mut().zip(&ranks) {
            *index = rank.index;
        }
        let gather = |ranks: &[Rank]| shapes.gather(ranks.iter().map(|rank| rank.place));
        let (here, there) = both(ranks.len(), || gather(&ranks[..middle]), || gather(&ranks[middle..]));
        let (left, right) = order.split_at_mut(middle);
        [Self { first, order: left, shapes: here }, Self { first: first + middle, order: right, shapes: there }]
    }
}

/// An emitter, its sort key, and the place of its shape.
struct Rank {
    along: f64,
    index: usize,
    place: usize,
}

impl Rank {
    fn compare(&self, other: &Self) -> Ordering {
        self.along.total_cmp(&other.along).then(self.index.cmp(&other.index))
    }
}

/// The emitters of a node in the order of those below it, and where to cut.
fn ranked(facing: bool, order: &[usize], shapes: &Shapes) -> (Vec<Rank>, usize) {
    let key = |place: usize| if facing { shapes.middle(place) } else { shapes.normals[place] };
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for key in (0..order.len()).map(key) {
        (low, high) = (low.min(key), high.max(key));
    }
    let extent = high - low;
    let axis = if extent.x >= extent.y && extent.x >= extent.z {
        0
    } else if extent.y >= extent.z {
        1
    } else {
        2
    };
    let rank = |(place, index): (usize, &usize)| Rank { along: key(place).to_array()[axis], index: *index, place };
    let mut ranks: Vec<Rank> = order.iter().enumerate().map(rank).collect();
    if facing {
        let middle = ranks.len() / 2;
        ranks.select_nth_unstable_by(middle, Rank::compare);
        return (ranks, middle);
    }
    // Where the normals are farthest apart: at the middle of their range.
    let cut = 0.5 * (low + high).to_array()[axis];
    ranks.sort_unstable_by(Rank::compare);
    let middle = ranks.partition_point(|rank| rank.along <= cut).clamp(1, ranks.len() - 1);
    (ranks, middle)
}

/// Does two things for so many emitters, on two threads where it is worth it.
fn both<A: Send, B: Send>(count: usize, one: impl FnOnce() -> A + Send, other: impl FnOnce() -> B + Send) -> (A, B) {
    if count >= TO_SHARE { join(one, other) } else { (one(), other()) }
}
