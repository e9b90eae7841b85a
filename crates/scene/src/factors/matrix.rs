//! All factors of a scene, sparse: pairs of faces that cannot see each other are not stored.

use std::ops::Range;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::culling::Wanted;
use super::pair::Known;
use super::{FactorSettings, FormFactors};
use crate::error::Error;
use crate::extremes::{largest as larger, smallest as smaller};
use crate::scene::Scene;

/// A factor of a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    /// The face that is seen.
    pub face: usize,
    /// The factor, in the bracket.
    pub factor: f64,
    /// Proven lower bound.
    pub lower: f64,
    /// Proven upper bound.
    pub upper: f64,
    /// The distance of the farther end of the bracket: a proven bound on the error.
    pub error: f64,
    /// The part of `error` that the rounding of the scene's coordinates takes: no effort narrows it.
    pub modelling: f64,
    /// Polygons that may hide a part of one face from the other.
    pub occluders: usize,
}

impl Entry {
    /// The part of `error` that effort narrows.
    #[must_use]
    pub const fn computed_error(&self) -> f64 {
        self.error - self.modelling
    }
}

/// Two faces and their exchange, stored once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pair {
    /// The lower one first.
    pub(super) faces: [u32; 2],
    pub(super) known: Known,
}

impl Pair {
    /// Ascending in the first face, then in the second.
    pub(super) fn key(&self) -> u64 {
        u64::from(self.faces[0]) << 32 | u64::from(self.faces[1])
    }
}

/// The factors between all faces that exchange light, or a block of their rows; those that are not there are exactly 0.
///
/// ```
/// use radgrad_scene::{Degenerate, FactorSettings, FormFactors, Scene};
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");
/// let scene = Scene::read(file, Degenerate::Refuse)?;
/// let settings = FactorSettings { tolerance: 0.1, ..FactorSettings::default() };
/// let matrix = FormFactors::new(&scene)?.matrix(&settings, || ())?;
/// for (face, entry) in matrix.entries() {
///     assert!(entry.lower <= entry.factor && entry.factor <= entry.upper);
///     // `A_i F_ij = A_j F_ji`
///     let back = matrix.factor(entry.face, face) * matrix.areas()[entry.face];
///     assert!((matrix.areas()[face] * entry.factor - back).abs() <= 1e-14 * back);
/// }
/// # Ok::<(), radgrad_scene::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct FactorMatrix {
    areas: Vec<f64>,
    /// The same in the unit of the pairs.
    pub(super) scaled_areas: Vec<f64>,
    /// Faces whose rows are here, ascending.
    faces: Vec<usize>,
    /// Ascending in the first face, then in the second.
    pub(super) pairs: Vec<Pair>,
    /// Pairs of each face of the scene, ascending in the other face; of faces without a row none.
    rows: Vec<Vec<u32>>,
}

/// The same between surfaces, which may have several faces each.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceMatrix {
    /// Surfaces of the scene that have a row, in its order.
    pub surfaces: Vec<usize>,
    /// Their areas.
    pub areas: Vec<f64>,
    /// The factors, row by row.
    pub rows: Vec<Vec<SurfaceFactor>>,
}

/// A factor between surfaces.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SurfaceFactor {
    /// The factor, in the bracket.
    pub factor: f64,
    /// Proven lower bound.
    pub lower: f64,
    /// Proven upper bound.
    pub upper: f64,
}

/// What a face exchanges with others, each pair in the row of one of the two: what an interrupted run keeps for the next one
/// ([`FormFactors::rows_from`]).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ComputedRow {
    face: u32,
    pairs: Vec<(u32, Known)>,
}

impl ComputedRow {
    /// The face.
    #[must_use]
    pub const fn face(&self) -> usize {
        self.face as usize
    }
}

/// A face's index where it is stored; there are fewer than 2^32.
fn index(face: usize) -> u32 {
    u32::try_from(face).unwrap_or(u32::MAX)
}

/// What a face does in a block of rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    /// It hides others, and has no factors.
    Hides,
    /// It has factors, in another block.
    Outside,
    HasRow,
}

impl FormFactors<'_> {
    /// All factors, on all cores. `progress` is called once a row.
    ///
    /// # Errors
    /// If a point's factor is out of range.
    pub fn matrix(&self, settings: &FactorSettings, progress: impl Fn() + Sync) -> Result<FactorMatrix, Error> {
        self.rows(0..self.faces().len(), settings, progress)
    }

    /// The faces that have factors, ascending.
    #[must_use]
    pub fn faces(&self) -> Vec<usize> {
        let scene = self.scene();
        let exchanges = |face: &usize| scene.surfaces()[scene.faces()[*face].surface()].exchanges();
        (0..scene.faces().len()).filter(exchanges).collect()
    }

    /// The pairs of a face with others.
    pub(super) fn pairs_of(&self, from: usize, others: &[usize], settings: &FactorSettings) -> Result<Vec<Pair>, Error> {
        let of = |&to: &usize| {
            let pair = [from.min(to), from.max(to)];
            Ok(self.pair(pair, settings)?.map(|known| Pair { faces: pair.map(index), known }))
        };
        // One pair may take a thousand times what another does.
        let found: Vec<Option<Pair>> = others.par_iter().with_max_len(4).map(of).collect::<Result<_, Error>>()?;
        let mut pairs: Vec<Pair> = found.into_iter().flatten().collect();
        pairs.sort_unstable_by_key(Pair::key);
        Ok(pairs)
    }

    /// The faces below those of some rows that see them, row by row: of two faces the lower one looks.
    fn seen_from_below(&self, rows: &[usize], is_below: impl Fn(usize) -> bool + Sync) -> Vec<Vec<usize>> {
        let mut seen = vec![Vec::new(); self.emitters.len()];
        let Some(&last) = rows.last() else { return seen };
        let mut is_wanted = vec![false; self.emitters.len()];
        rows.iter().for_each(|&row| is_wanted[row] = true);
        let wanted = Wanted::new(self.index.order(), is_wanted);
        let found: Vec<(usize, Vec<usize>)> = (0..last)
            .into_par_iter()
            .with_max_len(1)
            .filter(|&face| is_below(face))
            .map(|face| (face, self.may_see(face, &wanted)))
            .collect();
        for (face, rows) in found {
            rows.into_iter().for_each(|row| seen[row].push(face));
        }
        seen
    }

    /// The rows of some of [`Self::faces`], a range of places in it: each is the same to the last digit whatever rows are asked for,
    /// and a pair of faces in two blocks is computed in both. `progress` is called once a row.
    ///
    /// # Errors
    /// If there are not so many rows, or a point's factor is out of range.
    pub fn rows(
        &self,
        block: Range<usize>,
        settings: &FactorSettings,
        progress: impl Fn() + Sync,
    ) -> Result<FactorMatrix, Error> {
        self.rows_from(block, settings, Vec::new(), |_| progress())
    }

    /// The same, of which a run before has `computed` some, with the same scene, block and settings: every digit is that of a run at
    /// once. `keep` is called with each row that is new, in any order: what a later run can start from.
    ///
    /// ```
    /// # use radgrad_core::{DVec3, Polygon};
    /// # use radgrad_scene::{FactorSettings, FormFactors, Scene};
    /// # let mut scene = Scene::new(["grey"])?;
    /// # let white = scene.add_material("white", [0.8], [0.0])?;
    /// # for (z, up) in [(0.0, true), (1.0, false)] {
    /// #     let mut corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, z));
    /// #     if !up { corners.reverse() }
    /// #     let surface = scene.add_surface(format!("{z}"));
    /// #     scene.add_face(surface, white, Polygon::new(corners.to_vec()).unwrap(), None)?;
    /// # }
    /// let factors = FormFactors::new(&scene)?;
    /// let (settings, kept) = (FactorSettings::default(), std::sync::Mutex::new(Vec::new()));
    /// let all = factors.rows_from(0..2, &settings, Vec::new(), |row| kept.lock().unwrap().push(row.clone()))?;
    /// let mut before = kept.into_inner().unwrap();
    /// before.truncate(1); // an interrupted run
    /// assert_eq!(factors.rows_from(0..2, &settings, before, |_| ())?, all);
    /// # Ok::<(), radgrad_scene::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Self::rows`], or if what was computed is not of these rows.
    pub fn rows_from(
        &self,
        block: Range<usize>,
        settings: &FactorSettings,
        computed: Vec<ComputedRow>,
        keep: impl Fn(&ComputedRow) + Sync,
    ) -> Result<FactorMatrix, Error> {
        let all = self.faces();
        let faces = all.get(block.clone()).ok_or_else(|| {
            Error::expected(format!("a range of the {} rows", all.len()), format!("{} to {}", block.start, block.end))
        })?;
        let mut role = vec![Role::Hides; self.emitters.len()];
        all.iter().for_each(|&face| role[face] = Role::Outside);
        faces.iter().for_each(|&face| role[face] = Role::HasRow);
        let mut is_computed = vec![false; self.emitters.len()];
        for row in &computed {
            let is_new = role.get(row.face()) == Some(&Role::HasRow) && !is_computed[row.face()];
            if !is_new {
                let found = format!("a row of face {}, twice or of another block", row.face);
                return Err(Error::expected("computed rows of this block, each once", found));
            }
            self.check(row, &role)?;
            is_computed[row.face()] = true;
        }
        let rest: Vec<usize> = faces.iter().copied().filter(|&face| !is_computed[face]).collect();
        // Pairs within the block belong to the lower face.
        let below = self.seen_from_below(&rest, |face| role[face] == Role::Outside);
        let wanted = Wanted::new(self.index.order(), role.iter().map(|&role| role != Role::Hides).collect());
        let of_row = |&from: &usize| -> Result<ComputedRow, Error> {
            let mut others = self.may_see(from, &wanted);
            others.extend(&below[from]);
            let found = self.pairs_of(from, &others, settings)?;
            self.go_on()?;
            let face = index(from);
            let other = |pair: &Pair| if pair.faces[0] == face { pair.faces[1] } else { pair.faces[0] };
            let row = ComputedRow { face, pairs: found.iter().map(|pair| (other(pair), pair.known)).collect() };
            keep(&row);
            Ok(row)
        };
        let found: Vec<ComputedRow> = rest.par_iter().with_max_len(1).map(of_row).collect::<Result<_, _>>()?;
        let of_row = |ComputedRow { face, pairs }: ComputedRow| {
            pairs.into_iter().map(move |(other, known)| Pair { faces: [face.min(other), face.max(other)], known })
        };
        let mut pairs: Vec<Pair> = Vec::with_capacity(computed.iter().chain(&found).map(|row| row.pairs.len()).sum());
        pairs.extend(computed.into_iter().chain(found).flat_map(of_row));
        // A stable sort takes rows that are in order as they are.
        pairs.par_sort_by_key(Pair::key);
        self.of_pairs(faces.to_vec(), pairs)
    }

    /// Refuses a computed row with a pair that a run does not leave: of another row, twice, or with figures that are none of an
    /// exchange.
    fn check(&self, row: &ComputedRow, role: &[Role]) -> Result<(), Error> {
        let from = row.face();
        let mut others = Vec::with_capacity(row.pairs.len());
        for &(other, known) in &row.pairs {
            let to = other as usize;
            let refuse = |rule: &str, found: String| {
                Err(Error::expected(rule, format!("{found} in the row of face {from}, to face {to}")))
            };
            // Pairs within the block belong to the lower face.
            match role.get(to) {
                Some(Role::Outside) => {}
                Some(Role::HasRow) if to > from => {}
                _ => return refuse("a computed row with the pairs that belong to it", "another".to_owned()),
            }
            self.check_known([from, to], known)?;
            others.push(other);
        }
        others.sort_unstable();
        match others.windows(2).find(|two| two[0] == two[1]) {
            Some(two) => {
                Err(Error::expected("each pair of a computed row once", format!("face {} twice in that of face {from}", two[0])))
            }
            None => Ok(()),
        }
    }

    /// Refuses figures that are none of an exchange of two faces.
    pub(super) fn check_known(&self, [from, to]: [usize; 2], known: Known) -> Result<(), Error> {
        let Known { value, least, most, estimate, modelling, .. } = known;
        let area = smaller(self.scaled(from).area(), self.scaled(to).area());
        let is_bracket = 0.0 <= least && least <= value && value <= most && most <= area * (1.0 + 1e-14);
        let is_off = |by: f64| by >= 0.0 && by.is_finite();
        if is_bracket && is_off(estimate) && is_off(modelling) {
            return Ok(());
        }
        let rule = format!("a computed exchange inside its bracket, from 0 to the smaller area, {area}, with its estimate");
        let found = format!("{value} in [{least}, {most}], off by {estimate} and {modelling}");
        Err(Error::expected(rule, format!("{found} in the row of face {from}, to face {to}")))
    }

    /// The matrix of these rows and pairs, which are sorted.
    pub(super) fn of_pairs(&self, faces: Vec<usize>, pairs: Vec<Pair>) -> Result<FactorMatrix, Error> {
        let areas = (0..self.emitters.len()).map(|face| self.polygon(face).area()).collect();
        let scaled_areas = self.scaled.iter().map(radgrad_core::Polygon::area).collect();
        let matrix = FactorMatrix::new(areas, scaled_areas, faces, pairs);
        match matrix.covered() {
            Some((face, sum)) => Err(Error::Covered { face: self.scene().name_of(face), sum }),
            None => Ok(matrix),
        }
    }
}

impl FactorMatrix {
    fn new(areas: Vec<f64>, scaled_areas: Vec<f64>, faces: Vec<usize>, pairs: Vec<Pair>) -> Self {
        let mut rows = vec![Vec::new(); areas.len()];
        for (place, pair) in pairs.iter().enumerate() {
            for face in pair.faces.map(|face| face as usize) {
                if faces.binary_search(&face).is_ok() {
                    rows[face].push(u32::try_from(place).unwrap_or(u32::MAX));
                }
            }
        }
        Self { areas, scaled_areas, faces, pairs, rows }
    }

    /// A face that sees more than everything, whatever the errors of its factors are, and how much: faces before it overlap.
    fn covered(&self) -> Option<(usize, f64)> {
        // What rounding leaves of faces that overlap by no more than it.
        let least = |face: usize| self.row(face).map(|entry| entry.lower).sum::<f64>();
        self.faces.iter().map(|&face| (face, least(face))).find(|(_, sum)| *sum > 1.0 + 1e-9)
    }

    /// Area of each face of the scene, in the unit of length of [`FormFactors::placement`]: an ordinary scene's own.
    #[must_use]
    pub fn areas(&self) -> &[f64] {
        &self.areas
    }

    /// The faces whose rows are here, ascending.
    #[must_use]
    pub fn faces(&self) -> &[usize] {
        &self.faces
    }

    /// The faces that a face sees, ascending; empty if it only hides others, or there is none of this index.
    pub fn row(&self, face: usize) -> impl Iterator<Item = Entry> {
        let pairs = self.rows.get(face).map_or(&[][..], Vec::as_slice);
        pairs.iter().map(move |&place| self.entry(face, &self.pairs[place as usize]))
    }

    fn entry(&self, from: usize, pair: &Pair) -> Entry {
        let factor = pair.known.over(self.scaled_areas[from]);
        let [a, b] = pair.faces;
        Entry {
            face: if a as usize == from { b } else { a } as usize,
            factor: factor.value,
            lower: factor.lower,
            upper: factor.upper,
            error: factor.error,
            modelling: factor.modelling,
            occluders: factor.occluders,
        }
    }

    /// The factor between two faces; 0 where one sees nothing of the other.
    #[must_use]
    pub fn factor(&self, from: usize, to: usize) -> f64 {
        let Some(row) = self.rows.get(from) else { return 0.0 };
        let other = |place: &u32| {
            let [a, b] = self.pairs[*place as usize].faces.map(|face| face as usize);
            if a == from { b } else { a }
        };
        let place = row.binary_search_by_key(&to, other);
        place.map_or(0.0, |place| self.entry(from, &self.pairs[row[place] as usize]).factor)
    }

    /// The sum of a row, and what the proven brackets of its factors leave between them: in a closed scene 1 is between the two.
    #[must_use]
    pub fn sum(&self, face: usize) -> SurfaceFactor {
        self.row(face).fold(SurfaceFactor::default(), |sum, entry| SurfaceFactor {
            factor: sum.factor + entry.factor,
            lower: sum.lower + entry.lower,
            upper: sum.upper + entry.upper,
        })
    }

    /// Largest `|1 - sum_j F_ij|`: in a closed scene the error of a row; in an open one also the share of a face's view that
    /// leaves it.
    #[must_use]
    pub fn worst_closure(&self) -> f64 {
        self.faces.iter().map(|&face| (1.0 - self.sum(face).factor).abs()).fold(0.0, larger)
    }

    /// Rows whose brackets do not allow a sum of 1: none in a closed scene. A row below is of a face that sees out of the scene; one
    /// above, of one that sees two faces in one place.
    pub fn unclosed(&self) -> impl Iterator<Item = usize> {
        self.faces.iter().copied().filter(|&face| {
            let sum = self.sum(face);
            let slack = 1e-14 * (1.0 + self.row(face).count() as f64);
            sum.lower > 1.0 + slack || sum.upper < 1.0 - slack || sum.lower.is_nan() || sum.upper.is_nan()
        })
    }

    /// Largest `|A_i F_ij - A_j F_ji|` over the smaller of the two areas: a few roundings.
    #[must_use]
    pub fn worst_reciprocity(&self) -> f64 {
        let defect = |pair: &Pair| {
            let areas = pair.faces.map(|face| self.scaled_areas[face as usize]);
            let [there, back] = areas.map(|area| pair.known.over(area).value * area);
            (there - back).abs() / if areas[0] < areas[1] { areas[0] } else { areas[1] }
        };
        self.pairs.iter().map(defect).fold(0.0, larger)
    }

    /// Largest bound of a factor.
    #[must_use]
    pub fn worst_bound(&self) -> f64 {
        self.entries().map(|(_, entry)| entry.error).fold(0.0, larger)
    }

    /// All entries, each with the face that sees.
    pub fn entries(&self) -> impl Iterator<Item = (usize, Entry)> {
        self.faces.iter().flat_map(|&from| self.row(from).map(move |entry| (from, entry)))
    }

    /// Those whose bound is not what was asked for.
    pub fn unmet(&self, settings: &FactorSettings) -> impl Iterator<Item = (usize, Entry)> {
        self.entries().filter(|(_, entry)| entry.computed_error() > settings.allowed(entry.lower) || entry.error.is_nan())
    }

    /// The factors between surfaces: `A_S F_ST = sum A_i F_ij`, of those that have rows here. `scene` is the one that the matrix is of.
    #[must_use]
    pub fn by_surface(&self, scene: &Scene) -> SurfaceMatrix {
        let surfaces: Vec<usize> = (0..scene.surfaces().len()).filter(|&surface| scene.surfaces()[surface].exchanges()).collect();
        let mut place = vec![0; scene.surfaces().len()];
        surfaces.iter().enumerate().for_each(|(row, &surface)| place[surface] = row);
        let areas: Vec<f64> = surfaces.iter().map(|&surface| scene.area_of(surface)).collect();
        let surface_of = |face: usize| place[scene.faces()[face].surface()];
        let mut scaled = vec![0.0; surfaces.len()];
        scene.faces().iter().enumerate().filter(|(_, face)| scene.surfaces()[face.surface()].exchanges()).for_each(
            |(face, _)| {
                scaled[surface_of(face)] += self.scaled_areas[face];
            },
        );
        // What surfaces exchange, each sum once: it is reciprocal as the pairs are.
        let mut rows = vec![vec![SurfaceFactor::default(); surfaces.len()]; surfaces.len()];
        for pair in &self.pairs {
            let [a, b] = pair.faces.map(|face| surface_of(face as usize));
            let both = if a == b { 2.0 } else { 1.0 };
            let sum = &mut rows[a.min(b)][a.max(b)];
            sum.factor += both * pair.known.value;
            sum.lower += both * pair.known.least;
            sum.upper += both * pair.known.most;
        }
        for a in 0..surfaces.len() {
            for b in a..surfaces.len() {
                let exchanged = rows[a][b];
                let roundings = 1e-15 * self.pairs.len() as f64;
                let over = |area: f64| SurfaceFactor {
                    factor: exchanged.factor / area,
                    lower: exchanged.lower / area * (1.0 - roundings),
                    upper: exchanged.upper / area * (1.0 + roundings),
                };
                (rows[a][b], rows[b][a]) = (over(scaled[a]), over(scaled[b]));
            }
        }
        SurfaceMatrix { surfaces, areas, rows }
    }
}
