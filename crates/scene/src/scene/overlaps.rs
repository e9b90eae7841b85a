//! Faces that lie in one plane, face the same way and overlap: light from there would count twice.
//!
//! Files have a window drawn on a wall, a lamp on a ceiling, a rug on a floor, and faces twice. The smaller one is visible: a
//! larger one is cut around all smaller ones that overlap it, so that each point of the plane is of the smallest face there.
//! Smaller means first that of the smaller whole, where a whole is the faces of a surface and a material that meet in a plane: a
//! lamp of two triangles lies on a ceiling of a hundred, however small these are. Of wholes of one size the one that emits light
//! is kept, else the first.
//!
//! A face is **nested** if it lies in another one, or in several that do not overlap each other: a lamp across the diagonal of
//! its ceiling. Faces that overlap and are not nested are not known to be meant, and are refused unless [`Overlaps::Cut`] says
//! otherwise.
//!
//! With coordinates rounded by at most q:
//! - Two faces are in one plane if the points that they have in common are apart by no more than rounding explains: `2 q |n|_1` along the
//!   normal n, since within its corners a face is off by no more than these are. Where a face is not, and where its plane would be if it
//!   went on, does not matter: the normal of a needle means nothing.
//! - Edges that coincided are up to `2 sqrt(3) q` apart. So an overlap whose area is at most `2 q` times its own perimeter is explained.
//! - Without rounding, coordinates are off by that of doubles, `d = 4 eps C` with C the largest of them: two edges of length l overlap by at
//!   most `2 sqrt(2) d l`, and l is at most half the sum P of the two perimeters, which gives `1.5 d P`. Clipping rounds by less than d again.

pub(crate) mod flat;
#[cfg(test)]
mod tests;

use std::cell::OnceCell;
use std::collections::{BTreeMap, HashMap, HashSet};

use radgrad_core::{DVec3, Polygon};
use smallvec::SmallVec;

use self::flat::{Corner, Frame, Part, convex_parts, is_convex, lies_beside, root, tolerance};
use super::note::Note;
use super::{Face, Scene};
use crate::error::{Error, Overlapping};
use crate::extremes::{largest, smallest};
use crate::occluders::Occluders;
use crate::occluders::half_space::Level;
use crate::place::Place;
use crate::projection::normalising_power;
use crate::reading::Overlaps;
use crate::texture::Quantity;

/// Slivers of this area, over the perimeters' sum and the largest coordinate, are left by the rounding of doubles: twice 1.5 times 4 eps.
const SLIVER: f64 = 12.0 * f64::EPSILON;

/// Pairs that are looked at. More are no scene: that many faces lie on each other.
const MOST_PAIRS: usize = 1 << 20;

/// Pairs that an error names.
const MOST_NAMED: usize = 20;

/// Two faces that overlap by more than rounding explains.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pair {
    /// Their indices, the lower one first.
    faces: [usize; 2],
    /// The area of both.
    area: f64,
    /// A point that both have.
    at: DVec3,
    /// The part of the smaller one that both have.
    share: f64,
}

impl Pair {
    pub(super) fn named(&self, scene: &Scene, outward: impl Fn(DVec3) -> DVec3) -> Overlapping {
        Overlapping { faces: self.faces.map(|face| scene.name_of(face)), at: outward(self.at), share: self.share }
    }
}

/// The error that names pairs, if there are any.
pub(super) fn refused(pairs: impl ExactSizeIterator<Item = Overlapping>) -> Result<(), Error> {
    match pairs.len() {
        0 => Ok(()),
        count => Err(Error::Overlap { pairs: pairs.take(MOST_NAMED).collect(), more: count.saturating_sub(MOST_NAMED) }),
    }
}

/// A face in its own plane.
struct Sheet<'a> {
    polygon: &'a Polygon,
    frame: Frame,
    /// Its outline, which need not be convex.
    whole: Part,
    area: f64,
    perimeter: f64,
    /// The largest coordinate.
    largest: f64,
    level: Level,
    is_convex: bool,
    /// Vertices of its convex parts, none if there are no such.
    parts: OnceCell<Vec<Vec<usize>>>,
}

impl<'a> Sheet<'a> {
    fn new(polygon: &'a Polygon, power: f64) -> Self {
        let outline = polygon.vertices();
        let frame = Frame::new(outline, polygon.normal(), power);
        let whole = Part::new(outline.iter().map(|&v| frame.corner(v)).collect());
        let (perimeter, largest) = (whole.perimeter(), power * outline.iter().map(|v| v.abs().max_element()).fold(0.0, largest));
        let level = Level::new(largest, perimeter / whole.area());
        let is_convex = is_convex(&whole.corners);
        Self { polygon, frame, area: whole.area(), whole, perimeter, largest, level, is_convex, parts: OnceCell::new() }
    }

    /// Its convex parts in another plane.
    fn parts(&self, frame: &Frame, tolerance: f64) -> Vec<Part> {
        let vertices = self.polygon.vertices();
        let parts = self.parts.get_or_init(|| convex_parts(vertices, &self.frame, tolerance).unwrap_or_default());
        parts.iter().map(|part| Part::new(part.iter().map(|&i| frame.corner(vertices[i])).collect())).collect()
    }
}

/// The faces of a scene that give and take light, in a unit in which the scene is about 1, and the rounding of its coordinates.
struct Sheets<'a> {
    scene: &'a Scene,
    sheets: Vec<Sheet<'a>>,
    power: f64,
    rounding: f64,
}

/// The corners of a face in the plane of another.
type Outline = SmallVec<[Corner; 4]>;

/// The intersection of two faces.
struct Common {
    area: f64,
    perimeter: f64,
    at: DVec3,
}

/// How two faces are to each other.
enum Relation {
    Apart,
    /// In one plane, without a common area.
    Level,
    Explained,
    Overlap(Pair),
}

/// The overlaps to resolve.
pub(super) struct Found {
    pub(super) pairs: Vec<Pair>,
    /// Pairs whose overlap is explained by the rounding of the file: how many, and the first.
    explained: usize,
    first_explained: Option<usize>,
    /// A face of the whole that each face is of.
    wholes: Vec<usize>,
}

impl<'a> Sheets<'a> {
    fn new(scene: &'a Scene, rounding: f64) -> Self {
        let (low, high) = scene.bounds().unwrap_or((DVec3::ZERO, DVec3::ZERO));
        let power = normalising_power(low.abs().max(high.abs()).max_element());
        let sheets = scene.polygons().map(|polygon| Sheet::new(polygon, power)).collect();
        Self { scene, sheets, power, rounding: power * rounding }
    }

    /// The area of two that coincided which may be of one of them only.
    fn margin(&self, face: usize, other: usize) -> f64 {
        let (face, other) = (&self.sheets[face], &self.sheets[other]);
        SLIVER * (face.perimeter + other.perimeter) * largest(face.largest, other.largest) + 2.0 * self.rounding * face.perimeter
    }

    fn relation(&self, faces: [usize; 2]) -> Relation {
        let [a, b] = faces.map(|face| &self.sheets[face]);
        if a.frame.normal().dot(b.frame.normal()) <= 0.5 {
            return Relation::Apart;
        }
        let (below, above) = if a.area >= b.area { (a, b) } else { (b, a) };
        let farthest = largest(a.largest, b.largest);
        let reach = a.perimeter + b.perimeter;
        let level = largest(a.level.at(reach), b.level.at(reach));
        let defects = self.power * (a.polygon.planarity_defect() + b.polygon.planarity_defect());
        let allowed = 2.0 * self.rounding * below.frame.normal().abs().element_sum() + defects + level;
        let outline: Outline = above.polygon.vertices().iter().map(|&v| below.frame.corner(v)).collect();
        let heights = || outline.iter().map(|corner| corner.height);
        if heights().all(|height| height > allowed) || heights().all(|height| height < -allowed) {
            return Relation::Apart;
        }
        let touching = if heights().all(|height| height.abs() <= allowed) { Relation::Level } else { Relation::Apart };
        // A strip along an edge of such a width is less than the rounding of doubles explains.
        let beside = |of: &[Corner], others: &[Corner]| lies_beside(of, others, 8.0 * f64::EPSILON * farthest);
        if below.is_convex && beside(&below.whole.corners, &outline) || above.is_convex && beside(&outline, &below.whole.corners)
        {
            return touching;
        }
        let tolerance = tolerance(self.rounding, farthest);
        let Some(common) = common(below, above, tolerance, allowed) else { return Relation::Apart };
        let by_doubles = SLIVER * (a.perimeter + b.perimeter) * farthest;
        if common.area <= by_doubles {
            return touching;
        }
        if common.area <= by_doubles + 2.0 * self.rounding * common.perimeter {
            return Relation::Explained;
        }
        let share = common.area / smallest(a.area, b.area);
        Relation::Overlap(Pair { faces, area: common.area, at: common.at, share })
    }

    fn find_pairs(&self, index: &Occluders) -> Found {
        let mut wholes: Vec<usize> = (0..self.sheets.len()).collect();
        let (mut pairs, mut explained, mut first_explained) = (Vec::new(), 0, None);
        let surface_and_material = |face: usize| (self.scene.faces[face].surface, self.scene.faces[face].material);
        for face in (0..self.sheets.len()).filter(|&face| self.scene.exchanges(face)) {
            let sheet = &self.sheets[face];
            let reach = (4.0 * self.rounding + sheet.level.at(sheet.perimeter)) / self.power;
            let mut near = Vec::new();
            let counts = |other: usize| other > face && self.scene.exchanges(other);
            index.around(face, reach, |other| near.extend(Some(other).filter(|&other| counts(other))));
            near.sort_unstable();
            for other in near {
                let relation = self.relation([face, other]);
                if surface_and_material(face) == surface_and_material(other) && !matches!(relation, Relation::Apart) {
                    let [one, joined] = [face, other].map(|face| root(&mut wholes, face));
                    wholes[joined] = one;
                }
                match relation {
                    Relation::Apart | Relation::Level => {}
                    Relation::Explained => {
                        explained += 1;
                        first_explained = first_explained.or(Some(face));
                    }
                    Relation::Overlap(pair) => pairs.push(pair),
                }
            }
            if pairs.len() > MOST_PAIRS {
                break;
            }
        }
        let wholes = (0..wholes.len()).map(|face| root(&mut wholes, face)).collect();
        Found { pairs, explained, first_explained, wholes }
    }

    /// Parts of a face that are in none of others.
    fn without(&self, face: usize, others: &[usize]) -> Vec<Part> {
        let sheet = &self.sheets[face];
        let farthest = others.iter().map(|&other| self.sheets[other].largest).fold(sheet.largest, largest);
        let tolerance = tolerance(self.rounding, farthest);
        let holes: Vec<Part> = others.iter().flat_map(|&other| self.sheets[other].parts(&sheet.frame, tolerance)).collect();
        sheet.parts(&sheet.frame, tolerance).into_iter().flat_map(|part| part.without(&holes, tolerance)).collect()
    }

    /// Whether others cover all of a face.
    fn is_in(&self, face: usize, others: &[usize]) -> bool {
        let margin = others.iter().map(|&other| self.margin(face, other)).fold(0.0, largest);
        self.without(face, others).iter().map(Part::area).sum::<f64>() <= margin
    }

    fn emits(&self, face: usize) -> bool {
        (0..self.scene.channels.len()).any(|channel| self.scene.mean_over(face, Quantity::Radiance, channel) > 0.0)
    }
}

/// The intersection of a face with another, if that is in one plane: within the distance allowed.
fn common(below: &Sheet<'_>, above: &Sheet<'_>, tolerance: f64, allowed: f64) -> Option<Common> {
    let (mut common, mut widest) = (Common { area: 0.0, perimeter: 0.0, at: DVec3::ZERO }, 0.0);
    let others = below.parts(&below.frame, tolerance);
    for part in above.parts(&below.frame, tolerance) {
        for other in &others {
            let both = part.common(other);
            let area = both.area();
            if both.corners.len() < 3 || area <= 0.0 {
                continue;
            }
            if both.is_wide(tolerance) && !both.corners.iter().all(|corner| corner.height.abs() <= allowed) {
                return None;
            }
            common.area += area;
            common.perimeter += both.perimeter();
            if area > widest {
                widest = area;
                // Weights before the sum, which would overflow.
                common.at = both.corners.iter().map(|corner| corner.point / both.corners.len() as f64).sum();
            }
        }
    }
    Some(common)
}

/// The pairs of faces of a scene that overlap by more than this rounding explains.
pub(super) fn pairs(scene: &Scene, index: &Occluders, rounding: f64) -> Vec<Pair> {
    Sheets::new(scene, rounding).find_pairs(index).pairs
}

/// Changes to a scene: the polygons in the place of faces, and notes.
#[derive(Default)]
struct Changes {
    polygons: BTreeMap<usize, Vec<Polygon>>,
    notes: Vec<Note>,
}

/// Resolves the overlaps of a scene whose coordinates are rounded by at most `rounding`.
pub(crate) fn resolve(scene: &mut Scene, rounding: f64, overlaps: Overlaps) -> Result<(), Error> {
    if !(0.0..f64::INFINITY).contains(&rounding) {
        return Err(Error::expected("a rounding of coordinates that is finite and not negative", rounding.to_string()));
    }
    let index = Occluders::new(scene.polygons());
    let sheets = Sheets::new(scene, rounding);
    let changes = changes(&sheets, &sheets.find_pairs(&index), rounding, overlaps)?;
    scene.apply(changes);
    Ok(())
}

fn changes(sheets: &Sheets<'_>, found: &Found, rounding: f64, overlaps: Overlaps) -> Result<Changes, Error> {
    let (scene, mut changes) = (sheets.scene, Changes::default());
    let refuse = |pairs: &[Pair]| refused(pairs.iter().map(|pair| pair.named(scene, |at| at)));
    if overlaps == Overlaps::Refuse || found.pairs.len() > MOST_PAIRS {
        refuse(&found.pairs)?;
    }
    leave_out_doubles(sheets, &found.pairs, &mut changes);
    let is_there = |face: &usize| !changes.polygons.contains_key(face);
    let pairs: Vec<Pair> = found.pairs.iter().filter(|pair| pair.faces.iter().all(is_there)).copied().collect();
    let order = Order::by_area(sheets, found, &pairs);
    let ordered: Vec<[usize; 2]> = pairs.iter().map(|pair| order.sorted(pair.faces)).collect();
    if overlaps != Overlaps::Cut {
        let nested = nested(sheets, &ordered);
        let partial: Vec<Pair> =
            pairs.iter().zip(&ordered).filter(|(_, pair)| !nested.contains(*pair)).map(|(pair, _)| *pair).collect();
        refuse(&partial)?;
    }
    let mut above: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for [upper, lower] in ordered {
        above.entry(lower).or_default().push(upper);
    }
    for (face, others) in above {
        cut(sheets, face, &others, &mut changes)?;
    }
    if let Some(face) = found.first_explained {
        let (place, pairs) = (scene.faces[face].place.clone(), found.explained);
        changes.notes.push(Note::SmallOverlaps { place, pairs, precision: rounding });
    }
    Ok(changes)
}

/// Leaves one of two faces out that are the same: the later one, but none that emits light for one that does not.
fn leave_out_doubles(sheets: &Sheets<'_>, pairs: &[Pair], changes: &mut Changes) {
    let scene = sheets.scene;
    for Pair { faces: [first, second], area, .. } in pairs.iter().copied() {
        let is_all = |face: usize, other: usize| sheets.sheets[face].area - area <= sheets.margin(face, other);
        let is_gone = [first, second].iter().any(|face| changes.polygons.contains_key(face));
        if is_gone || !is_all(first, second) || !is_all(second, first) {
            continue;
        }
        let emits = sheets.emits(second) && !sheets.emits(first);
        let (kept, left_out) = if emits { (second, first) } else { (first, second) };
        let materials = [left_out, kept].map(|face| scene.faces[face].material);
        let unused = (materials[0] != materials[1]).then(|| scene.materials[materials[0]].name().to_owned());
        let (place, face) = scene.subject(left_out);
        changes.notes.push(Note::SameFace { place, face, kept: scene.object(kept), emits, unused });
        changes.polygons.insert(left_out, Vec::new());
    }
}

/// The order in which faces lie on each other.
struct Order {
    /// Sort key of each face: a larger face lies below.
    keys: HashMap<usize, [f64; 3]>,
}

impl Order {
    fn by_area(sheets: &Sheets<'_>, found: &Found, pairs: &[Pair]) -> Self {
        let mut areas = vec![0.0; found.wholes.len()];
        for (face, &whole) in found.wholes.iter().enumerate() {
            areas[whole] += sheets.sheets[face].area;
        }
        // Areas that differ by less than a thousandth are one, or nearly always: then emission and order decide.
        let step = |area: f64| (1024.0 * libm::log2(area)).round();
        let key = |face: usize| {
            let dark = f64::from(u8::from(!sheets.emits(face)));
            [step(areas[found.wholes[face]]), dark, step(sheets.sheets[face].area)]
        };
        Self { keys: pairs.iter().flat_map(|pair| pair.faces).map(|face| (face, key(face))).collect() }
    }

    /// Two faces, the upper one first. The first of two of one kind is the upper one.
    fn sorted(&self, [first, second]: [usize; 2]) -> [usize; 2] {
        let [a, b] = [first, second].map(|face| &self.keys[&face]);
        let order = a.iter().zip(b).map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne());
        if order.is_some_and(std::cmp::Ordering::is_gt) { [second, first] } else { [first, second] }
    }
}

/// The pairs whose upper face lies in the lower one, or in that and others that overlap none of these.
fn nested(sheets: &Sheets<'_>, pairs: &[[usize; 2]]) -> HashSet<[usize; 2]> {
    let overlapping: HashSet<[usize; 2]> = pairs.iter().flat_map(|&[a, b]| [[a, b], [b, a]]).collect();
    let mut below: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for &[upper, lower] in pairs {
        below.entry(upper).or_default().push(lower);
    }
    let mut nested = HashSet::new();
    for (upper, lowers) in below {
        for &lower in &lowers {
            if nested.contains(&[upper, lower]) {
                continue;
            }
            let mut side_by_side = vec![lower];
            for &other in &lowers {
                if side_by_side.iter().all(|&one| one != other && !overlapping.contains(&[one, other])) {
                    side_by_side.push(other);
                }
            }
            if sheets.is_in(upper, &side_by_side[..1]) {
                nested.insert([upper, lower]);
            } else if side_by_side.len() > 1 && sheets.is_in(upper, &side_by_side) {
                nested.extend(side_by_side.iter().map(|&lower| [upper, lower]));
            }
        }
    }
    nested
}

/// Cuts a face around others.
fn cut(sheets: &Sheets<'_>, face: usize, others: &[usize], changes: &mut Changes) -> Result<(), Error> {
    let (scene, sheet) = (sheets.scene, &sheets.sheets[face]);
    let mut pieces = Vec::new();
    for part in sheets.without(face, others) {
        match piece(&part, &sheet.frame) {
            Ok(polygon) => pieces.push(polygon),
            Err(radgrad_core::Error::ZeroArea { .. }) => {}
            Err(error) => {
                let fault = Error::Face(error);
                return Err(scene.faces[face].place.clone().map_or(fault.clone(), |place| fault.at_place(place)));
            }
        }
    }
    let first = others.iter().copied().min().unwrap_or(face);
    let ((place, face_name), around, more) = (scene.subject(face), scene.object(first), others.len().saturating_sub(1));
    changes.notes.push(match pieces.len() {
        0 => Note::Covered { place, face: face_name, by: around, more },
        count => Note::Cut { place, face: face_name, pieces: count, around, more },
    });
    changes.polygons.insert(face, pieces);
    Ok(())
}

/// The polygon of a part, with the corners of its neighbours where these are flat enough, else with their feet in the plane.
fn piece(part: &Part, frame: &Frame) -> Result<Polygon, radgrad_core::Error> {
    match Polygon::new(part.corners.iter().map(|corner| corner.point).collect()) {
        Err(radgrad_core::Error::NotPlanar { .. }) => {
            Polygon::new(part.corners.iter().map(|corner| frame.foot(corner)).collect())
        }
        polygon => polygon,
    }
}

impl Scene {
    /// Resolves faces that lie in one plane, face the same way and overlap, as reading a file does. `rounding` is the largest error of a
    /// coordinate: overlaps that it explains are left as they are. Faces are numbered anew; surfaces stay, even without faces.
    ///
    /// ```
    /// use radgrad_core::{DVec3, Polygon};
    /// use radgrad_scene::{Overlaps, Prepared, Scene};
    /// let mut scene = Scene::new(["grey"])?;
    /// let white = scene.add_material("white", [0.8], [0.0])?;
    /// let [wall, window] = ["wall", "window"].map(|name| scene.add_surface(name));
    /// let square = |low: f64, high: f64| {
    ///     let corners = [(low, low), (high, low), (high, high), (low, high)];
    ///     Polygon::new(corners.map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec()).unwrap()
    /// };
    /// scene.add_face(wall, white, square(0.0, 4.0), None)?;
    /// scene.add_face(window, white, square(1.0, 2.0), None)?;
    /// assert!(Prepared::new(&scene).is_err());
    /// scene.resolve_overlaps(0.0, Overlaps::Nested)?;
    /// assert!(Prepared::new(&scene).is_ok());
    /// assert_eq!((scene.area_of(wall), scene.area_of(window)), (15.0, 1.0));
    /// assert_eq!(scene.notes()[0].to_string(), "face 0 of `wall` is cut into 4 pieces around face 1 of `window`");
    /// # Ok::<(), radgrad_scene::Error>(())
    /// ```
    ///
    /// # Errors
    /// If faces overlap in a way that `overlaps` refuses, all pairs up to twenty; or `rounding` is negative or no number.
    pub fn resolve_overlaps(&mut self, rounding: f64, overlaps: Overlaps) -> Result<(), Error> {
        resolve(self, rounding, overlaps)
    }

    fn apply(&mut self, mut changes: Changes) {
        self.notes.append(&mut changes.notes);
        if changes.polygons.is_empty() {
            return;
        }
        self.surfaces.iter_mut().for_each(|surface| surface.faces.clear());
        for (index, face) in std::mem::take(&mut self.faces).into_iter().enumerate() {
            let faces: Vec<Face> = match changes.polygons.remove(&index) {
                None => vec![face],
                Some(pieces) => pieces.into_iter().map(|polygon| Face { polygon, ..face.clone() }).collect(),
            };
            for face in faces {
                self.surfaces[face.surface].faces.push(self.faces.len());
                self.faces.push(face);
            }
        }
    }

    /// A face at the head of a note: its place, and its name.
    fn subject(&self, face: usize) -> (Option<Place>, String) {
        let Face { surface, place, .. } = &self.faces[face];
        let name = &self.surfaces[*surface].name;
        let which = place.as_ref().map_or_else(|| format!("face {face} of `{name}`"), |_| format!("a face of `{name}`"));
        (place.clone(), which)
    }

    /// A face inside a note.
    fn object(&self, face: usize) -> String {
        let (place, name) = self.subject(face);
        place.map_or_else(|| name.clone(), |place| format!("{name} ({place})"))
    }
}
