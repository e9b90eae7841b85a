//! One receiver against each of many emitters.

use fearless_simd::Level;
use radgrad_numbers::lanes::lane::Lane;
use radgrad_numbers::lanes::lane::MOST_LANES;

use crate::batch::answers::{Answers, Counts, Slots};
use crate::batch::lamps::{Lamps, by_edges, sorted};
use crate::batch::many_emitters::{Group, SeenFrom, Work, common_power, goes_on_lanes};
use crate::batch::tile;
use crate::batch::tile::{Entries, Goal, Settled, TILE, put};
use crate::error::Error;
use crate::ladder::answer::Method;
use crate::problem::emission::Emitter;
use crate::problem::receiver::Receiver;

/// Emitters as a structure of arrays, made once for any number of receivers. Constant or linear emitters with as many vertices go
/// on lanes together, linear ones in double precision; polynomial ones are kept as they are and answered one by one.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver};
/// use radgrad_core::batch::{Answers, Emitters, Engine};
/// let lamp = |x: f64| {
///     let corners = [(0.0, 0.0), (0.0, 0.5), (0.5, 0.0)].map(|(u, v)| DVec3::new(x + u, v, 2.0));
///     Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))
/// };
/// let lamps = (0..100).map(|i| lamp(f64::from(i))).collect::<Result<Vec<_>, _>>()?;
/// let lamps: Emitters<'_> = Emitters::new(&lamps);
/// let floor = Receiver::new(DVec3::ZERO, DVec3::Z, 0.8)?;
/// let mut answers = Answers::new();
/// Engine::new().each_to(&floor, &lamps, 1e-10, &mut answers)?;
/// assert!(answers.radiosity[0] > 2.0 * answers.radiosity[3]);
/// # Ok::<(), radgrad_core::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Emitters<'a, F = f64> {
    emitters: &'a [Emitter],
    sets: Vec<Set<F>>,
    /// Indices of the emitters that the scalar path answers.
    others: Vec<usize>,
    power: f64,
}

/// Emitters of one kind with as many vertices.
#[derive(Debug, Clone)]
struct Set<F> {
    /// Which emitters they are.
    index: Vec<usize>,
    /// Constant ones in the requested precision.
    group: Option<Group<F>>,
    /// The emitters in double precision, for linear emission and for entries that single precision does not settle.
    double: Option<Lamps>,
}

impl<'a, F: Lane> Emitters<'a, F> {
    /// Puts emitters on lanes.
    #[must_use]
    pub fn new(emitters: &'a [Emitter]) -> Self {
        let power = common_power::<F>(emitters);
        let (fit, unfit): (Vec<_>, Vec<_>) = (0..emitters.len()).partition(|i| goes_on_lanes::<F>(&emitters[*i], power));
        let (double, others) = sorted(emitters, &unfit, power);
        let fit = by_edges(emitters, &fit).into_iter().map(|index| Set {
            group: Some(Group::new(emitters, index.clone(), power)),
            double: F::IS_SINGLE.then(|| Lamps::Constant(Group::new(emitters, index.clone(), power))),
            index,
        });
        let double = double.into_iter().map(|lamps| Set { index: lamps.index().to_vec(), group: None, double: Some(lamps) });
        Self { emitters, sets: fit.chain(double).collect(), others, power }
    }

    /// Number of emitters.
    ///
    /// ```
    /// # use radgrad_core::{DVec3, Emission, Emitter, Polygon, batch::Emitters};
    /// let lamp = Emitter::new(Polygon::new(vec![DVec3::X, DVec3::Y, DVec3::Z])?, Emission::Constant(1.0))?;
    /// assert_eq!(Emitters::<f32>::new(&[lamp.clone(), lamp]).count(), 2);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub const fn count(&self) -> usize {
        self.emitters.len()
    }
}

/// One receiver and its emitters.
pub(super) struct OneReceiver<'a, F> {
    receiver: &'a Receiver,
    emitters: &'a Emitters<'a, F>,
    seen: Option<SeenFrom<F>>,
    double: Option<SeenFrom<f64>>,
    goal: Goal,
    level: Level,
}

impl<'a, F: Lane> OneReceiver<'a, F> {
    pub(super) fn new(receiver: &'a Receiver, emitters: &'a Emitters<'a, F>, goal: Goal, level: Level) -> Self {
        let (seen, double) = (SeenFrom::new(receiver, emitters.power), SeenFrom::new(receiver, emitters.power));
        Self { receiver, emitters, seen, double, goal, level }
    }

    /// Answers all emitters, in their order.
    pub(super) fn answer_all(&self, threads: bool, answers: &mut Answers<F>) -> Result<Counts, Error> {
        let mut counts = Counts::default();
        let mut sorted = Answers::new();
        for set in &self.emitters.sets {
            let in_order = set.index.iter().enumerate().all(|(i, index)| i == *index);
            let count = set.index.len();
            let target = if in_order { &mut *answers } else { &mut sorted };
            let slots = target.sized(if in_order { self.emitters.count() } else { count }, self.goal.asked).split_at(count).0;
            counts += tile::run(threads, 0, slots, &|start, slots| self.tile(set, start, slots))?;
            if !in_order {
                let mut slots = answers.sized(self.emitters.count(), self.goal.asked);
                set.index.iter().enumerate().try_for_each(|(i, index)| put(&mut slots, *index, &sorted.answer(i)))?;
            }
        }
        let mut slots = answers.sized(self.emitters.count(), self.goal.asked);
        for &index in &self.emitters.others {
            self.single(index, (&mut slots, index), &mut counts)?;
        }
        Ok(counts)
    }

    /// Answers emitters of a set from `start` on.
    fn tile(&self, set: &Set<F>, start: usize, mut slots: Slots<'_, F>) -> Result<Counts, Error> {
        let length = slots.radiosity.len();
        let mut settled = Settled::default();
        if let (Some(group), Some(seen)) = (&set.group, &self.seen) {
            let mut work = Work::new();
            settled = group.answer(self.level, seen, start..start + length, self.goal, &mut work);
            work.copy_to(&mut slots);
        }
        slots.on_lanes();
        slots.see_nothing(tile::each(settled.zero));
        let mut counts = settled.counts();
        let mut open = settled.open(length);
        if let (Some(lamps), Some(seen)) = (&set.double, &self.double) {
            open = self.doubled((lamps, seen), start, open, (&mut slots, &mut counts))?;
        }
        for entry in tile::each(open) {
            self.single(set.index[start + entry], (&mut slots, entry), &mut counts)?;
        }
        Ok(counts)
    }

    /// Answers open entries on lanes of double precision, with their neighbours; returns those that are still open.
    fn doubled(
        &self,
        (lamps, seen): (&Lamps, &SeenFrom<f64>),
        start: usize,
        open: Entries,
        (slots, counts): (&mut Slots<'_, F>, &mut Counts),
    ) -> Result<Entries, Error> {
        let mut work = Work::new();
        let mut still_open = 0;
        for first in (0..TILE).step_by(MOST_LANES) {
            let wanted = open >> first & ((1 << MOST_LANES) - 1);
            if wanted == 0 {
                continue;
            }
            let end = (start + first + MOST_LANES).min(lamps.index().len());
            let settled = lamps.answer(self.level, seen, start + first..end, self.goal.doubled(), &mut work);
            let settled = Settled { zero: settled.zero & wanted, good: settled.good & wanted, clipped: settled.clipped };
            let doubled = if F::IS_SINGLE { wanted.count_ones() as usize } else { 0 };
            *counts += Counts { doubled, ..settled.counts() };
            for entry in tile::each(settled.zero | settled.good) {
                put(slots, first + entry, &work.answer(entry, self.goal.asked))?;
            }
            slots.see_nothing(tile::each(settled.zero).map(|entry| first + entry));
            still_open |= (wanted & !(settled.zero | settled.good)) << first;
        }
        Ok(still_open)
    }

    /// Answers one emitter on the scalar path.
    fn single(&self, index: usize, (slots, entry): (&mut Slots<'_, F>, usize), counts: &mut Counts) -> Result<(), Error> {
        let in_batch = |error| Error::InBatch { index, error: Box::new(error) };
        let answer = self.goal.single(self.receiver, &self.emitters.emitters[index], &[]).map_err(in_batch)?;
        put(slots, entry, &answer).map_err(in_batch)?;
        *if answer.method == Method::Zero { &mut counts.zero } else { &mut counts.single } += 1;
        Ok(())
    }
}
