//! Faults that are planted, to see that the audit finds them: the scene that the solver is given differs from the one that the
//! oracle is given, or its answer is changed on the way. Nothing of this is in shipped code.

use glam::DVec3;
use radgrad_oracle::scene::Effort;

use super::family::{Family, Name};
use super::judge::{Ending, Judged, Verdict, judge};
use super::model::{Expected, Model, Part};
use super::statement::{Quantum, Response, Stated, Statement, Subject, ask};
use super::workers::on_all_cores;

/// A fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// The strongest lamp is not seen.
    LampSkipped,
    /// The weakest lamp is not seen.
    WeakLampSkipped,
    /// The light of the strongest lamp counts twice.
    LampTwice,
    /// A lamp shines from its back too.
    LampBothSides,
    /// A lamp is a tenth of its size aside.
    LampAside,
    /// Slats in the way are not seen to be.
    OccluderSkipped,
    /// A face is taken for its back.
    FaceTurned,
    /// One face reflects half of its reflectance.
    ReflectanceHalved,
    /// Nothing is reflected twice.
    NoReflection,
    /// Every face reflects a tenth less.
    Lossy,
    /// The channels change places.
    ChannelsSwapped,
    /// A texture is turned by one texel.
    TextureShifted,
    /// Estimates are divided by 100.
    EstimateHundredth,
    /// Values are a fifth too large.
    ValueLarge,
    /// Points change places.
    PointsSwapped,
    /// The mean has the value of a point.
    MeanOfPoint,
    /// A value is not a number.
    NotANumber,
    /// Rooms are 4 % higher.
    Stretched,
    /// Pairs of factors are off each other by five times their bounds.
    FactorsNotReciprocal,
    /// Rows are those of the transposed matrix.
    FactorsTransposed,
    /// Brackets of factors are narrowed to 1e-4 of their width.
    BracketsNarrow,
    /// Factors past slats are those of free sight.
    FactorsFree,
    /// One in a hundred factors is 0.
    FactorsDropped,
    /// Fields see through slats.
    FieldFree,
    /// Fields do not see the strongest lamp.
    FieldLampSkipped,
    /// Values of a field are 1e-6 too large.
    FieldOff,
}

impl Fault {
    /// All of them.
    pub const ALL: [Self; 26] = [
        Self::LampSkipped,
        Self::WeakLampSkipped,
        Self::LampTwice,
        Self::LampBothSides,
        Self::LampAside,
        Self::OccluderSkipped,
        Self::FaceTurned,
        Self::ReflectanceHalved,
        Self::NoReflection,
        Self::Lossy,
        Self::ChannelsSwapped,
        Self::TextureShifted,
        Self::EstimateHundredth,
        Self::ValueLarge,
        Self::PointsSwapped,
        Self::MeanOfPoint,
        Self::NotANumber,
        Self::Stretched,
        Self::FactorsNotReciprocal,
        Self::FactorsTransposed,
        Self::BracketsNarrow,
        Self::FactorsFree,
        Self::FactorsDropped,
        Self::FieldFree,
        Self::FieldLampSkipped,
        Self::FieldOff,
    ];

    /// In words.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::LampSkipped => "the strongest lamp skipped",
            Self::WeakLampSkipped => "the weakest lamp skipped",
            Self::LampTwice => "the strongest lamp counted twice",
            Self::LampBothSides => "a lamp that shines from both sides",
            Self::LampAside => "a lamp a tenth of its size aside",
            Self::OccluderSkipped => "slats that hide nothing",
            Self::FaceTurned => "a face taken for its back",
            Self::ReflectanceHalved => "the reflectance of a face halved",
            Self::NoReflection => "no second reflection",
            Self::Lossy => "a tenth of each reflection lost",
            Self::ChannelsSwapped => "channels swapped",
            Self::TextureShifted => "a texture shifted by a texel",
            Self::EstimateHundredth => "estimates times 0.01",
            Self::ValueLarge => "values a fifth too large",
            Self::PointsSwapped => "points swapped",
            Self::MeanOfPoint => "a point for the mean",
            Self::NotANumber => "a value that is not a number",
            Self::Stretched => "a room 4 % higher",
            Self::FactorsNotReciprocal => "reciprocity off by five bounds",
            Self::FactorsTransposed => "factors transposed",
            Self::BracketsNarrow => "brackets of factors times 1e-4",
            Self::FactorsFree => "factors through slats",
            Self::FactorsDropped => "one factor in a hundred dropped",
            Self::FieldFree => "a field through slats",
            Self::FieldLampSkipped => "a field without the strongest lamp",
            Self::FieldOff => "a field 1e-6 too large",
        }
    }

    /// Whether it changes the answers and not the scene.
    const fn of_statements(self) -> bool {
        matches!(
            self,
            Self::EstimateHundredth
                | Self::ValueLarge
                | Self::PointsSwapped
                | Self::MeanOfPoint
                | Self::NotANumber
                | Self::FactorsNotReciprocal
                | Self::FactorsTransposed
                | Self::BracketsNarrow
                | Self::FactorsDropped
                | Self::FieldOff
        )
    }

    /// The subject that must find it.
    #[must_use]
    pub const fn subject(self) -> Subject {
        match self {
            Self::FactorsNotReciprocal
            | Self::FactorsTransposed
            | Self::BracketsNarrow
            | Self::FactorsFree
            | Self::FactorsDropped => Subject::Factors,
            Self::FieldFree | Self::FieldLampSkipped | Self::FieldOff => Subject::Field,
            _ => Subject::Solve,
        }
    }

    /// The families that it is looked for in.
    #[must_use]
    pub const fn families(self) -> &'static [Family] {
        match self {
            Self::TextureShifted => &[Family::Textured],
            Self::WeakLampSkipped => &[Family::Facing, Family::ManyLamps],
            Self::EstimateHundredth | Self::LampAside => &[Family::Facing, Family::Clutter],
            Self::OccluderSkipped | Self::FactorsFree | Self::FieldFree => &[Family::Grating],
            Self::ChannelsSwapped => &[Family::Clutter],
            Self::BracketsNarrow => &[Family::Clutter, Family::Grating, Family::Open],
            _ => &[Family::Clutter, Family::Facing],
        }
    }

    /// How many times as many scenes are searched for it: a shifted texture can stay within the estimates of four scenes.
    const fn patience(self) -> usize {
        match self {
            Self::TextureShifted => 3,
            _ => 1,
        }
    }

    /// The scene that the solver is given.
    #[must_use]
    pub fn scene(self, model: &Model) -> Model {
        let mut given = model.clone();
        let power = |part: &Part| part.emitted[0];
        let lamps: Vec<usize> = (0..given.parts.len()).filter(|&k| power(&given.parts[k]) > 0.0).collect();
        let strongest = lamps.iter().copied().max_by(|&a, &b| power(&given.parts[a]).total_cmp(&power(&given.parts[b])));
        let weakest = lamps.iter().copied().min_by(|&a, &b| power(&given.parts[a]).total_cmp(&power(&given.parts[b])));
        // Of the faces that reflect, the last is a box's where there is one.
        let reflects = |k: &usize| given.parts[*k].reflectance[0] > 0.0;
        let last = (0..given.parts.len()).rfind(reflects);
        match self {
            Self::LampSkipped | Self::FieldLampSkipped => scale_emission(&mut given, strongest, 0.0),
            Self::WeakLampSkipped => scale_emission(&mut given, weakest, 0.0),
            Self::LampTwice => scale_emission(&mut given, strongest, 2.0),
            Self::LampBothSides => {
                if let Some(lamp) = strongest {
                    light_the_back(&mut given, lamp);
                }
            }
            Self::LampAside => {
                if let Some(lamp) = strongest {
                    move_aside(&mut given, lamp);
                }
            }
            Self::OccluderSkipped | Self::FactorsFree | Self::FieldFree => {
                for occluder in occluders(model) {
                    given.parts[occluder].corners.iter_mut().for_each(|p| *p += FAR_AWAY);
                }
            }
            Self::FaceTurned => {
                if let Some(face) = last {
                    given.parts[face].corners.reverse();
                }
            }
            Self::ReflectanceHalved => {
                if let Some(face) = last {
                    given.parts[face].reflectance.iter_mut().for_each(|rho| *rho *= 0.5);
                }
            }
            Self::NoReflection => {
                let asked: Vec<usize> = given.probes.iter().map(|probe| probe.part).collect();
                let others = given.parts.iter_mut().enumerate().filter(|(index, _)| !asked.contains(index));
                others.flat_map(|(_, part)| &mut part.reflectance).for_each(|rho| *rho = 0.0);
            }
            Self::Lossy => {
                given.parts.iter_mut().flat_map(|part| &mut part.reflectance).for_each(|rho| *rho *= 0.9);
            }
            Self::ChannelsSwapped => {
                for part in &mut given.parts {
                    part.reflectance.reverse();
                    part.emitted.reverse();
                }
            }
            Self::TextureShifted => {
                for grid in given.parts.iter_mut().flat_map(|part| &mut part.grids) {
                    grid.texels.rotate_left(1);
                }
            }
            Self::Stretched => {
                let corners = given.parts.iter_mut().flat_map(|part| &mut part.corners);
                corners.chain(given.probes.iter_mut().map(|probe| &mut probe.position)).for_each(|p| p.z *= 1.04);
            }
            _ => {}
        }
        given
    }

    /// The statements with the fault in them.
    #[must_use]
    pub fn statements(self, said: &[Statement]) -> Vec<Statement> {
        let mut faulty = said.to_vec();
        let stated =
            |faulty: &mut [Statement], factor: f64| faulty.iter_mut().for_each(|one| one.stated = one.stated.times(factor));
        match self {
            Self::EstimateHundredth => stated(&mut faulty, 0.01),
            Self::BracketsNarrow => stated(&mut faulty, 1e-4),
            Self::ValueLarge => faulty.iter_mut().for_each(|one| one.value *= 1.2),
            Self::FieldOff => faulty.iter_mut().for_each(|one| one.value *= 1.0 + 1e-6),
            Self::NotANumber => {
                if let Some(one) = faulty.last_mut() {
                    one.value = f64::NAN;
                }
            }
            Self::PointsSwapped | Self::MeanOfPoint => {
                let points: Vec<usize> = (0..faulty.len()).filter(|&i| matches!(faulty[i].of, Quantum::Point(..))).collect();
                let [from, to] = match (self, points.first(), points.last()) {
                    (Self::PointsSwapped, Some(&first), Some(&last)) => [first, last],
                    (_, Some(&first), _) => [first, 0],
                    _ => return faulty,
                };
                (faulty[to].value, faulty[from].value) = (faulty[from].value, faulty[to].value);
            }
            Self::FactorsNotReciprocal => {
                for one in faulty.iter_mut().filter(|one| matches!(one.of, Quantum::Reciprocity(..))) {
                    one.value += 5.0 * one.stated.size() + 1e-6;
                }
            }
            Self::FactorsTransposed => {
                let before = faulty.clone();
                for one in &mut faulty {
                    if let Quantum::Factor(from, to) = one.of
                        && let Some(other) = before.iter().find(|other| other.of == Quantum::Factor(to, from))
                    {
                        (one.value, one.stated) = (other.value, other.stated);
                    }
                }
            }
            Self::FactorsDropped => {
                let of_factors = faulty.iter_mut().filter(|one| matches!(one.of, Quantum::Factor(..)) && one.value > 0.0);
                for one in of_factors.step_by(100) {
                    (one.value, one.stated) = (0.0, Stated::Bound(0.0));
                }
            }
            _ => {}
        }
        faulty
    }
}

/// Where a face goes that is to hide nothing: it keeps its index.
const FAR_AWAY: DVec3 = DVec3::new(100.0, 200.0, 400.0);

/// Both sides of the slats in a room, which come after its six walls and before the two sides of its lamp; not those with points.
fn occluders(model: &Model) -> Vec<usize> {
    let asked = |part: &usize| model.probes.iter().any(|probe| probe.part == *part);
    (6..model.parts.len().saturating_sub(2)).filter(|part| !asked(part)).collect()
}

fn scale_emission(model: &mut Model, lamp: Option<usize>, factor: f64) {
    if let Some(lamp) = lamp {
        model.parts[lamp].emitted.iter_mut().for_each(|emitted| *emitted *= factor);
    }
}

/// The lamp shines from its back too. In rooms a lamp has a back already: that one shines.
fn light_the_back(model: &mut Model, lamp: usize) {
    let part = &model.parts[lamp];
    let corners: Vec<_> = part.corners.iter().rev().copied().collect();
    let emitted = part.emitted.clone();
    match model.parts.iter_mut().find(|other| other.corners == corners) {
        Some(back) => back.emitted = emitted,
        None => model.parts.push(Part { corners, emitted, ..model.parts[lamp].clone() }),
    }
}

/// The lamp, with its back, by a tenth of its first edge.
fn move_aside(model: &mut Model, lamp: usize) {
    let corners = model.parts[lamp].corners.clone();
    let by = (corners[1] - corners[0]) * 0.1;
    let back: Vec<_> = corners.iter().rev().copied().collect();
    for part in model.parts.iter_mut().filter(|part| part.corners == corners || part.corners == back) {
        part.corners.iter_mut().for_each(|p| *p += by);
    }
}

/// A fault and where it was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// The fault.
    pub fault: Fault,
    /// Scenes that it was looked for in, whose unchanged answers hold.
    pub scenes: usize,
    /// The first scene that shows it.
    pub by: Option<Name>,
}

/// Scenes of a family among which those are looked for that a fault changes.
const SEARCHED: u64 = 40;

/// A scene with its statements, all of which hold or are too rough to judge.
struct Control {
    name: Name,
    subject: Subject,
    model: Model,
    judged: Vec<Judged>,
}

/// Looks for each fault in so many scenes of each of its families, or a few times as many, until one shows it. A statement
/// counts only where it holds without the fault. The truth is that of the scene without it.
#[must_use]
pub fn find(faults: &[Fault], seed: u64, most: usize, effort: &Effort) -> Vec<Found> {
    let mut wanted: Vec<(Name, Subject)> = Vec::new();
    for fault in faults {
        for &family in fault.families() {
            let names = (0..SEARCHED).map(|index| Name { family, seed, index });
            // Faults of scenes need one that they change, those of statements any.
            let changed = names.filter(|name| fault.of_statements() || fault.scene(&name.model()) != name.model());
            wanted.extend(changed.take(most * fault.patience()).map(|name| (name, fault.subject())));
        }
    }
    wanted.sort_unstable();
    wanted.dedup();
    let control = |&(name, subject): &(Name, Subject)| {
        let model = name.model();
        match judge(&model, subject, effort).ending {
            Ending::Judged(judged) if model.expected == Expected::Answer => Some(Control { name, subject, model, judged }),
            _ => None,
        }
    };
    let controls: Vec<Control> = on_all_cores(&wanted, control).into_iter().flatten().collect();
    on_all_cores(faults, |&fault| look(fault, &controls))
}

fn look(fault: Fault, controls: &[Control]) -> Found {
    let mut scenes = 0;
    for family in fault.families() {
        let of_family = controls.iter().filter(|of| of.name.family == *family && of.subject == fault.subject());
        for control in of_family {
            let given = fault.scene(&control.model);
            if given == control.model && !fault.of_statements() {
                continue;
            }
            let said: Vec<Statement> = control.judged.iter().map(|one| one.statement).collect();
            let said = if given == control.model {
                said
            } else if let Response::Statements(said) = ask(&given, control.subject) {
                said
            } else {
                continue;
            };
            let said = fault.statements(&said);
            scenes += 1;
            if shows(fault, control, &said) {
                return Found { fault, scenes, by: Some(control.name) };
            }
        }
    }
    Found { fault, scenes, by: None }
}

/// Whether a statement that held does no longer.
fn shows(fault: Fault, control: &Control, said: &[Statement]) -> bool {
    // A face that was put elsewhere shows that by itself.
    let moves = matches!(fault, Fault::OccluderSkipped | Fault::FactorsFree | Fault::FieldFree);
    let put = if moves { occluders(&control.model) } else { Vec::new() };
    let elsewhere = |of: Quantum| match of {
        Quantum::Factor(from, to) | Quantum::Reciprocity(from, to) => put.contains(&from) || put.contains(&to),
        // The factor that such a face showed it shows no longer.
        Quantum::RowSum(_) => !put.is_empty(),
        Quantum::Cell(face, _) => put.contains(&face),
        Quantum::Mean(_) | Quantum::Point(..) => false,
    };
    let broken = |statement: &Statement| {
        let held = |one: &&Judged| one.verdict == Verdict::Held && one.statement.of == statement.of && !elsewhere(statement.of);
        let judged = control.judged.iter().find(held);
        judged.is_some_and(|one| matches!(Judged::new(*statement, one.known, 1.0).verdict, Verdict::Broken | Verdict::Off))
    };
    said.iter().any(broken)
}
