//! A tree over emitters: which of them may be left out, or answered together, for a receiver and an error.
//!
//! Emitters with as many vertices are sorted so that those of a node are next to each other: first by the way they face, until a
//! node's normals are within [`FACING`] of their mean, then by place. Each node has the bounds of [`crate::batch::cluster`], and
//! those with enough emitters the far field of [`crate::batch::far_field`].

use std::borrow::Cow;

use fearless_simd::Level;
use glam::DVec3;

use crate::batch::cluster::{Cluster, fan};
use crate::batch::far_field::{FarField, Nodes};
use crate::batch::lamps::{Lamps, sorted};
use crate::batch::many_emitters::common_power;
use crate::problem::emission::Emitter;

/// Emitters of a leaf at most: two vectors of double precision.
const LEAF: usize = 16;

/// Fewest emitters of a node with a far field, and how many nodes of that an emitter is worth.
const FEWEST: usize = 12;
const WORTH: usize = 12;

/// Distance of a normal from the mean of a node's, up to which the node may have a far field.
const FACING: f64 = 0.5;

/// Emitters in a tree, made once for any number of receivers. Constant and linear emitters go into the tree; polynomial and concave
/// ones, and those beyond the range of double precision, are answered one by one for every receiver.
///
/// Making it takes about as long as a hundred receivers take without it.
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
    pub(super) far_fields: Vec<FarField>,
    /// Their nodes.
    pub(super) nodes: Nodes,
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
    /// Its far field, where it has one.
    pub(super) far: Option<usize>,
    /// The second child; the first is the next node. None for a leaf.
    pub(super) second: Option<usize>,
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
        let (kinds, mut others) = sorted(emitters, &convex, power);
        others.extend(concave);
        let mut groups: Vec<Grove> = Vec::new();
        let (mut far_fields, mut far_nodes) = (Vec::new(), Nodes::default());
        for lamps in kinds {
            let (mut nodes, mut order) = (Vec::new(), lamps.index().to_vec());
            Builder { emitters, power, nodes: &mut nodes }.add(0, &mut order);
            let lamps = lamps.reordered(emitters, order, power);
            for node in &mut nodes {
                if let Some(far) = far_field(node, &lamps, &mut far_nodes) {
                    node.far = Some(far_fields.len());
                    far_fields.push(far);
                }
            }
            groups.push(Grove { lamps, nodes });
        }
        Self { emitters: all, groups, far_fields, nodes: far_nodes, others, power }
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

/// The far field of a node where it is worth it.
fn far_field(node: &Node, lamps: &Lamps, nodes: &mut Nodes) -> Option<FarField> {
    let Node { first, count, cluster, .. } = node;
    if *count < FEWEST || cluster.spread > FACING {
        return None;
    }
    let degree = FarField::degree(cluster);
    let worth = degree.iter().map(|degree| degree + 1).product::<usize>() <= WORTH * count;
    worth.then(|| FarField::new(cluster, degree, (lamps, *first..first + count), Level::new(), nodes))
}

struct Builder<'a, 'b> {
    emitters: &'a [Emitter],
    power: f64,
    nodes: &'b mut Vec<Node>,
}

impl Builder<'_, '_> {
    /// Sorts the emitters of a node, the first of which comes at `first`, and appends it with its children.
    fn add(&mut self, first: usize, order: &mut [usize]) {
        let cluster = Cluster::new(self.emitters, order, self.power);
        let place = self.nodes.len();
        let facing = cluster.spread <= FACING;
        self.nodes.push(Node { first, count: order.len(), cluster, far: None, second: None });
        if order.len() <= LEAF {
            return;
        }
        let middle = self.split(facing, order);
        let (left, right) = order.split_at_mut(middle);
        self.add(first, left);
        self.nodes[place].second = Some(self.nodes.len());
        self.add(first + middle, right);
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
