//! The radiosity of receivers due to all emitters of a tree together, within an absolute error.
//!
//! From the root down each node is left out (below the horizon, facing away, or weaker than allowed), answered by its far field
//! where the bound on its error is allowed, or opened; the emitters of a leaf are answered on lanes. The error allowed to a single
//! node answers.

use std::ops::Range;

use fearless_simd::{Level, Simd};
use radgrad_numbers::lanes::lane::{Lanes, MOST_LANES, constant, load, same};
use radgrad_numbers::number::ROUNDOFF;
use radgrad_numbers::on_instruction_set;

use crate::batch::answers::Slots;
use crate::batch::cluster::UP;
use crate::batch::emitter_tree::{EmitterTree, Grove};
use crate::batch::far_field::Nodes;
use crate::batch::many_emitters::{SeenFrom, Work};
use crate::batch::receivers::Receivers;
use crate::batch::tile::{Goal, TILE};
use crate::error::Error;
use crate::evaluate::evaluate_to;
use crate::problem::receiver::Receiver;

/// How the emitters were answered, summed over receivers.
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
/// let (zero, half) = ([0.0; 2], [0.5; 2]);
/// let two = Receivers::new([&half, &half, &[0.0, 2.0]], [&zero, &zero, &[1.0, -1.0]], &[1.0])?; // under it, and over it
/// let mut answers = Answers::new();
/// let tally = Engine::new().total(&two, &EmitterTree::new(&ceiling), 1e-4, &mut answers)?;
/// assert_eq!(tally.below + tally.behind + tally.weak + tally.together + tally.alone, 2 * 2500);
/// assert_eq!(tally.behind, 2500); // they shine down, so the one above sees their backs
/// # Ok::<(), radgrad_core::Error>(())
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Tally {
    /// Emitters left out because all of their node is below the receiver's horizon.
    pub below: u64,
    /// Emitters left out because all of their node face away.
    pub behind: u64,
    /// Emitters left out because their node gives less than is allowed; the bound counts them.
    pub weak: u64,
    /// Emitters answered by the far field of their node.
    pub together: u64,
    /// Emitters answered by the closed form; among them those that it finds to give nothing.
    pub alone: u64,
    /// Far fields, and their nodes.
    pub far_fields: u64,
    /// Nodes of far fields: each costs about a tenth of a closed form.
    pub far_nodes: u64,
    /// Nodes of the tree that were looked at.
    pub looked_at: u64,
}

impl std::ops::AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.below += other.below;
        self.behind += other.behind;
        self.weak += other.weak;
        self.together += other.together;
        self.alone += other.alone;
        self.far_fields += other.far_fields;
        self.far_nodes += other.far_nodes;
        self.looked_at += other.looked_at;
    }
}

/// Share of the tolerance that a node may err by at first.
const SHARE: f64 = 1.0 / 32.0;

/// Relative tolerance for emitters that lanes leave to the scalar path.
const SINGLE_TOLERANCE: f64 = 1e-10;

/// A node that is left out or answered by its far field, with the bound on the error.
#[derive(Debug, Clone, Copy)]
struct Decided {
    place: usize,
    index: usize,
    bound: f64,
}

/// Buffers for one receiver, used again for the next. A node is named by its grove and its place there.
struct Room {
    work: Work<f64>,
    open: Vec<(usize, usize)>,
    weak: Vec<Decided>,
    far: Vec<Decided>,
    /// Grove, first emitter and number of those answered one by one.
    near: Vec<(usize, usize, usize)>,
    /// Nodes answered by their far fields, and the receivers of the tile that they answer.
    pairs: Vec<((usize, usize), usize)>,
}

impl Room {
    fn new() -> Self {
        Self { work: Work::new(), open: Vec::new(), weak: Vec::new(), far: Vec::new(), near: Vec::new(), pairs: Vec::new() }
    }

    /// Only the roots are open.
    fn start(&mut self, tree: &EmitterTree<'_>) {
        self.weak.clear();
        self.far.clear();
        self.near.clear();
        self.open.extend((0..tree.groups.len()).map(|place| (place, 0)));
    }

    fn left_out(&self) -> f64 {
        self.weak.iter().chain(&self.far).map(|decided| decided.bound).sum()
    }

    /// Opens the decided nodes again whose bound is above a share.
    fn open_above(&mut self, share: f64) {
        let open = &mut self.open;
        for list in [&mut self.weak, &mut self.far] {
            open.extend(list.iter().filter(|decided| decided.bound > share).map(|decided| (decided.place, decided.index)));
            list.retain(|decided| decided.bound <= share);
        }
    }

    /// Counts a receiver's decided nodes, notes its far fields, and joins neighbouring ones.
    fn count(&mut self, tree: &EmitterTree<'_>, entry: usize, tally: &mut Tally) {
        let node = |decided: &Decided| &tree.groups[decided.place].nodes[decided.index];
        tally.weak += self.weak.iter().map(|decided| node(decided).count as u64).sum::<u64>();
        for decided in &self.far {
            let Some(far) = node(decided).far_field(&tree.groups[decided.place].lamps) else { continue };
            tally.together += node(decided).count as u64;
            tally.far_fields += 1;
            tally.far_nodes += far.count() as u64;
            self.pairs.push(((decided.place, decided.index), entry));
        }
        tally.alone += self.near.iter().map(|(_, _, count)| *count as u64).sum::<u64>();
        self.near.sort_unstable();
        self.near.dedup_by(|next, last| {
            let joins = next.0 == last.0 && next.1 == last.1 + last.2;
            last.2 += if joins { next.2 } else { 0 };
            joins
        });
    }
}

/// Receivers and the emitters they see.
pub(super) struct TreeWalk<'a> {
    pub(super) receivers: Receivers<'a, f64>,
    pub(super) tree: &'a EmitterTree<'a>,
    pub(super) tolerance: f64,
    pub(super) level: Level,
}

/// A sum, the sum of the magnitudes of its terms, and a bound on its error.
#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    value: f64,
    size: f64,
    error: f64,
}

impl Sum {
    #[inline]
    fn add(&mut self, value: f64, error: f64) {
        self.value += value;
        self.size += value.abs();
        self.error += error;
    }
}

impl TreeWalk<'_> {
    /// Answers the receivers from `start` on. Far fields come last, each for all receivers in turn: they are the most to read.
    pub(super) fn tile(&self, start: usize, slots: Slots<'_, f64>) -> Result<Tally, Error> {
        let (mut room, mut tally) = (Room::new(), Tally::default());
        let mut receivers = Vec::with_capacity(slots.radiosity.len());
        for i in 0..slots.radiosity.len() {
            let in_batch = |error| Error::InBatch { index: start + i, error: Box::new(error) };
            let receiver = self.receivers.receiver(start + i).map_err(in_batch)?;
            let sum = self.decide(&receiver, i, &mut room, &mut tally).map_err(in_batch)?;
            receivers.push((receiver, sum));
        }
        let lanes = self.far(&receivers, &mut room.pairs);
        for (i, ((receiver, mut sum), lanes)) in receivers.into_iter().zip(lanes).enumerate() {
            let in_batch = |error| Error::InBatch { index: start + i, error: Box::new(error) };
            let [value, size] = lanes.sums.map(|lanes| -lanes.iter().sum::<f64>());
            sum.add(value, (lanes.blocks + 64) as f64 * ROUNDOFF * size.abs());
            let total = self.finish(&receiver, sum, &mut tally).map_err(in_batch)?;
            (slots.radiosity[i], slots.radiosity_error[i]) = (total.value, total.error);
        }
        Ok(tally)
    }

    /// The bound on the neglected light, and the sum over the emitters that are answered one by one; notes the far fields. Without
    /// rho.
    fn decide(&self, receiver: &Receiver, entry: usize, room: &mut Room, tally: &mut Tally) -> Result<Sum, Error> {
        let rho = receiver.reflectance();
        if rho == 0.0 {
            return Ok(Sum::default());
        }
        let allowed = self.tolerance / rho;
        let mut share = SHARE * allowed;
        room.start(self.tree);
        loop {
            self.walk(receiver, share, room, tally);
            let left_out = room.left_out() * UP;
            if left_out <= 0.75 * allowed || share <= allowed * 1e-9 {
                room.count(self.tree, entry, tally);
                let mut sum = self.near(receiver, allowed, room)?;
                sum.error += left_out;
                return Ok(sum);
            }
            share *= 0.25;
            room.open_above(share);
        }
    }

    /// Decides about all nodes that are open.
    fn walk(&self, receiver: &Receiver, share: f64, room: &mut Room, tally: &mut Tally) {
        let (x, n1) = (receiver.position() * self.tree.power, receiver.normal());
        while let Some((place, index)) = room.open.pop() {
            let grove = &self.tree.groups[place];
            let node = &grove.nodes[index];
            let sight = node.cluster.sight(x, n1);
            tally.looked_at += 1;
            if sight.below {
                tally.below += node.count as u64;
            } else if sight.behind {
                tally.behind += node.count as u64;
            } else if sight.largest_value <= share {
                room.weak.push(Decided { place, index, bound: sight.largest_value });
            } else if sight.whole
                && let Some(far) = node.far_field(&grove.lamps)
                && let bound = far.error(&node.cluster, &sight)
                && bound <= share
            {
                room.far.push(Decided { place, index, bound });
            } else if let Some(second) = node.second {
                room.open.push((place, index + second));
                room.open.push((place, index + 1));
            } else {
                room.near.push((place, node.first, node.count));
            }
        }
    }

    /// The sum over the emitters that are answered one by one.
    fn near(&self, receiver: &Receiver, allowed: f64, room: &mut Room) -> Result<Sum, Error> {
        let one = Receiver::new(receiver.position(), receiver.given_normal(), 1.0)?;
        let mut sum = Sum::default();
        let Some(seen) = SeenFrom::new(&one, self.tree.power) else { return Ok(sum) };
        let count: usize = room.near.iter().map(|(_, _, count)| count).sum();
        let goal = Goal::absolute(0.1 * allowed / (count + 1) as f64);
        for &(place, first, count) in &room.near {
            for start in (first..first + count).step_by(TILE) {
                let range = start..(first + count).min(start + TILE);
                self.range(&self.tree.groups[place], (&one, &seen), range, goal, (&mut room.work, &mut sum))?;
            }
        }
        sum.error += (count + 64) as f64 * ROUNDOFF * sum.size;
        Ok(sum)
    }

    /// Adds a range of emitters of a grove, one by one.
    fn range(
        &self,
        grove: &Grove,
        (receiver, seen): (&Receiver, &SeenFrom<f64>),
        range: Range<usize>,
        goal: Goal,
        (work, sum): (&mut Work<f64>, &mut Sum),
    ) -> Result<(), Error> {
        let settled = grove.lamps.answer(self.level, seen, range.clone(), goal, work);
        let open = settled.open(range.len());
        for (entry, index) in grove.lamps.index()[range].iter().enumerate() {
            if open >> entry & 1 == 0 {
                sum.add(work.radiosity[entry], work.radiosity_error[entry]);
            } else {
                let answer = evaluate_to(receiver, &self.tree.emitters[*index], &[], SINGLE_TOLERANCE)?;
                sum.add(answer.radiosity, answer.radiosity_error);
            }
        }
        Ok(())
    }

    /// The far fields' sums for each receiver.
    fn far(&self, receivers: &[(Receiver, Sum)], pairs: &mut [((usize, usize), usize)]) -> Vec<FarSum> {
        pairs.sort_unstable();
        let mut sums = vec![FarSum { sums: [[0.0; MOST_LANES]; 2], blocks: 0 }; receivers.len()];
        for &mut ((place, index), entry) in pairs {
            let Grove { lamps, nodes } = &self.tree.groups[place];
            let node = &nodes[index];
            let Some(far) = node.far_field(lamps) else { continue };
            let far = far.nodes(&node.cluster, lamps, node.first..node.first + node.count, self.level);
            let receiver = &receivers[entry].0;
            let (x, n1) = ((receiver.position() * self.tree.power).to_array(), receiver.normal().to_array());
            sums[entry].blocks += far.place[0].len() / MOST_LANES;
            let sums = &mut sums[entry].sums;
            on_instruction_set!(self.level, simd => far_sum(simd, far, (x, n1), sums));
        }
        sums
    }

    /// The sum times rho, with the emitters that are in no tree.
    fn finish(&self, receiver: &Receiver, sum: Sum, tally: &mut Tally) -> Result<Sum, Error> {
        let rho = receiver.reflectance();
        let mut total = Sum { value: sum.value * rho, size: sum.size * rho, error: sum.error * rho };
        for &index in &self.tree.others {
            let answer = evaluate_to(receiver, &self.tree.emitters[index], &[], SINGLE_TOLERANCE)?;
            total.add(answer.radiosity, answer.radiosity_error);
        }
        tally.alone += self.tree.others.len() as u64;
        total.error = (total.error + (self.tree.others.len() + 4) as f64 * ROUNDOFF * total.size) * UP;
        if !total.value.is_finite() {
            return Err(Error::Overflow { quantity: "radiosity" });
        }
        Ok(Sum { error: if total.size == 0.0 && total.error == 0.0 { 0.0 } else { total.error + f64::MIN_POSITIVE }, ..total })
    }
}

/// Far fields' sums of terms and of their magnitudes, node i in sum i modulo 16 whatever the width of vectors, and how many terms
/// a sum has.
#[derive(Debug, Clone, Copy)]
struct FarSum {
    sums: [[f64; MOST_LANES]; 2],
    blocks: usize,
}

/// The radiosity that a far field gives a receiver of reflectance 1.
#[cfg(test)]
pub(super) fn far_value(level: Level, nodes: &Nodes, receiver: &Receiver) -> f64 {
    let mut sums = [[0.0; MOST_LANES]; 2];
    let position_and_normal = (receiver.position().to_array(), receiver.normal().to_array());
    on_instruction_set!(level, simd => far_sum(simd, nodes, position_and_normal, &mut sums));
    -sums[0].iter().sum::<f64>()
}

/// Adds `(n1.r) (W.r)/r^4` of nodes, and its magnitude.
#[inline(always)]
fn far_sum<S: Simd>(simd: S, nodes: &Nodes, (x, n1): ([f64; 3], [f64; 3]), sums: &mut [[f64; MOST_LANES]; 2]) {
    let (x, n1) = (same::<S, f64>(simd, x), same(simd, n1));
    let one = constant(simd, 1.0);
    let [px, py, pz] = &nodes.place;
    let [wx, wy, wz] = &nodes.weight;
    let [values, sizes] = sums;
    for block in (0..px.len()).step_by(MOST_LANES) {
        for lane in (0..MOST_LANES).step_by(Lanes::<S, f64>::COUNT) {
            let i = block + lane;
            let r = load(simd, [&px[i..], &py[i..], &pz[i..]]) - x;
            let weight = load(simd, [&wx[i..], &wy[i..], &wz[i..]]);
            let square = r.norm_squared();
            let term = n1.dot(r) * weight.dot(r) * (one / (square * square));
            (Lanes::load(simd, &values[lane..]) + term).store(&mut values[lane..]);
            (Lanes::load(simd, &sizes[lane..]) + term.abs()).store(&mut sizes[lane..]);
        }
    }
}
