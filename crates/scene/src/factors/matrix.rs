//! All factors of a scene, a row a face.

use rayon::prelude::*;

use super::bracket::Bracket;
use super::pair::Pair;
use super::rule::MOST_NODES;
use super::{FactorSettings, FormFactors};
use crate::{Error, Scene, largest};

/// Pairs of cells that every bracket may take; those that it leaves too wide may take more.
const A_LOOK: usize = 32;

/// A factor of a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    /// The face that is seen.
    pub face: usize,
    /// The factor.
    pub factor: f64,
    /// Proven bound on its error, that of the rule of points included.
    pub error: f64,
    /// Polygons that may hide a part of one face from the other.
    pub occluders: usize,
}

/// The factors between all faces that exchange light; those that are not there are exactly 0.
#[derive(Debug, Clone, PartialEq)]
pub struct FactorMatrix {
    areas: Vec<f64>,
    /// Faces that have a row.
    faces: Vec<usize>,
    /// One for each face of the scene, ascending in the face seen.
    rows: Vec<Vec<Entry>>,
}

/// The same between surfaces, which may have several faces each.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceMatrix {
    /// Surfaces of the scene that have a row, in its order.
    pub surfaces: Vec<usize>,
    /// Their areas.
    pub areas: Vec<f64>,
    /// The factors, row by row.
    pub rows: Vec<Vec<f64>>,
}

impl FormFactors<'_> {
    /// All factors, on all cores. `progress` is called once a row and once for what can be said of it without points: twice the
    /// number of rows in all.
    ///
    /// # Errors
    /// If `points_per_side` is not in 1 to 16, or a point's factor is out of range.
    pub fn matrix(&self, settings: &FactorSettings, progress: impl Fn() + Sync) -> Result<FactorMatrix, Error> {
        if !(1..=MOST_NODES).contains(&settings.points_per_side) {
            let found = settings.points_per_side.to_string();
            return Err(Error::expected(format!("1 to {} points per side", MOST_NODES), found));
        }
        let scene = self.scene();
        let areas: Vec<f64> = (0..scene.faces().len()).map(|face| self.polygon(face).area()).collect();
        let exchanges = |face: &usize| scene.surfaces()[scene.faces()[*face].surface()].exchanges();
        let faces: Vec<usize> = (0..areas.len()).filter(exchanges).collect();
        // Each pair once, with the lower face; a look at each first.
        let first = FactorSettings { most_cells: settings.most_cells.min(A_LOOK), ..*settings };
        let mut pairs: Vec<Vec<(usize, Pair)>> = faces
            .par_iter()
            .enumerate()
            .map(|(place, &from)| {
                let pair = |&to: &usize| Some((to, self.pair(from, to, &first, areas[from].min(areas[to]))?));
                let found = faces[place + 1..].iter().filter_map(pair).collect();
                progress();
                found
            })
            .collect();
        self.narrow(&faces, &mut pairs, &areas, settings);
        let mut of_face: Vec<Vec<(usize, &Pair)>> = vec![Vec::new(); areas.len()];
        for (&from, found) in faces.iter().zip(&pairs) {
            for (to, pair) in found {
                of_face[from].push((*to, pair));
                of_face[*to].push((from, pair));
            }
        }
        let rows = of_face
            .par_iter_mut()
            .enumerate()
            .map(|(from, pairs)| {
                pairs.sort_unstable_by_key(|(to, _)| *to);
                let row = self.row(from, pairs, settings);
                if faces.binary_search(&from).is_ok() {
                    progress();
                }
                row
            })
            .collect::<Result<_, _>>()?;
        let matrix = FactorMatrix { areas, faces, rows };
        match matrix.covered() {
            Some((face, sum)) => Err(Error::Covered { face: scene.name_of(face), sum }),
            None => Ok(matrix),
        }
    }

    /// Narrows the brackets that are too wide, with more and more cells, and by what rows leave: no face sees more than all around.
    fn narrow(&self, faces: &[usize], pairs: &mut [Vec<(usize, Pair)>], areas: &[f64], settings: &FactorSettings) {
        let mut cells = A_LOOK;
        loop {
            let mut least = vec![0.0; areas.len()];
            for (&from, found) in faces.iter().zip(&*pairs) {
                for (to, pair) in found {
                    let [low, _] = pair.bounds();
                    least[from] += low;
                    least[*to] += low;
                }
            }
            let is_wide =
                |from: usize, to: usize, bracket: Bracket| bracket.width() > settings.tolerance * areas[from].min(areas[to]);
            for (&from, found) in faces.iter().zip(&mut *pairs) {
                for (to, pair) in found {
                    if let Some(bracket) = &mut pair.bracket {
                        // Sums of up to n terms lose n roundings of the area.
                        let rest = |face: usize| {
                            (areas[face] - least[face]) + bracket.least + areas.len() as f64 * f64::EPSILON * areas[face]
                        };
                        bracket.most = bracket.most.min(rest(from)).min(rest(*to)).max(bracket.least);
                    }
                }
            }
            if cells >= settings.most_cells {
                break;
            }
            cells = (4 * cells).min(settings.most_cells);
            faces.par_iter().zip(&mut *pairs).for_each(|(&from, found)| {
                for (to, pair) in found {
                    if let Some(bracket) = pair.bracket
                        && is_wide(from, *to, bracket)
                    {
                        let width = settings.tolerance * areas[from].min(areas[*to]);
                        let narrower = self.bracket([from, *to], pair, width, cells);
                        pair.bracket = Some(bracket.and(narrower));
                    }
                }
            });
        }
    }
}

impl FactorMatrix {
    /// A face that sees more than everything, whatever the errors of its factors are, and how much: faces before it overlap.
    fn covered(&self) -> Option<(usize, f64)> {
        let least = |row: &[Entry]| row.iter().map(|entry| largest(entry.factor - entry.error, 0.0)).sum::<f64>();
        // What rounding leaves of faces that overlap by no more than it.
        self.faces.iter().map(|&face| (face, least(self.row(face)))).find(|(_, sum)| *sum > 1.0 + 1e-9)
    }

    /// Area of each face of the scene, in the unit of length of [`FormFactors::placement`]: an ordinary scene's own.
    #[must_use]
    pub fn areas(&self) -> &[f64] {
        &self.areas
    }

    /// The faces that exchange light, ascending.
    #[must_use]
    pub fn faces(&self) -> &[usize] {
        &self.faces
    }

    /// What a face sees, ascending; empty if it only hides others, or there is none of this index.
    #[must_use]
    pub fn row(&self, face: usize) -> &[Entry] {
        self.rows.get(face).map_or(&[], Vec::as_slice)
    }

    /// The factor between two faces; 0 where one sees nothing of the other.
    #[must_use]
    pub fn factor(&self, from: usize, to: usize) -> f64 {
        let row = self.row(from);
        row.binary_search_by_key(&to, |entry| entry.face).map_or(0.0, |place| row[place].factor)
    }

    /// Largest `|1 - sum_j F_ij|`: what of a face's sight ends nowhere. Of a closed scene, the error that no rule of points has.
    #[must_use]
    pub fn worst_closure(&self) -> f64 {
        let sum = |face: &usize| self.row(*face).iter().map(|entry| entry.factor).sum::<f64>();
        self.faces.iter().map(|face| (1.0 - sum(face)).abs()).fold(0.0, f64::max)
    }

    /// Largest `|A_i F_ij - A_j F_ji|` over the smaller of the two areas: by how much the two ways differ, as a part of what the
    /// smaller face sees. It is the error of the rules of points as they are; nothing has been made reciprocal.
    #[must_use]
    pub fn worst_reciprocity(&self) -> f64 {
        let defect = |from: usize, entry: &Entry| {
            (entry.factor - self.factor(entry.face, from) * self.areas[entry.face] / self.areas[from]).abs()
        };
        self.entries().map(|(from, entry)| defect(from, entry)).fold(0.0, f64::max)
    }

    /// Largest bound of a factor.
    #[must_use]
    pub fn worst_bound(&self) -> f64 {
        self.entries().map(|(_, entry)| entry.error).fold(0.0, f64::max)
    }

    /// All entries, each with the face that sees.
    pub fn entries(&self) -> impl Iterator<Item = (usize, &Entry)> {
        self.rows.iter().enumerate().flat_map(|(from, row)| row.iter().map(move |entry| (from, entry)))
    }

    /// The factors between surfaces: `A_S F_ST = sum A_i F_ij`. `scene` is the one that the matrix is of.
    #[must_use]
    pub fn by_surface(&self, scene: &Scene) -> SurfaceMatrix {
        let surfaces: Vec<usize> = (0..scene.surfaces().len()).filter(|&surface| scene.surfaces()[surface].exchanges()).collect();
        let mut place = vec![0; scene.surfaces().len()];
        surfaces.iter().enumerate().for_each(|(row, &surface)| place[surface] = row);
        let areas: Vec<f64> = surfaces.iter().map(|&surface| scene.area_of(surface)).collect();
        let mut rows = vec![vec![0.0; surfaces.len()]; surfaces.len()];
        let surface_of = |face: usize| place[scene.faces()[face].surface()];
        let mut wholes = vec![0.0; surfaces.len()];
        self.faces.iter().for_each(|&face| wholes[surface_of(face)] += self.areas[face]);
        for (from, entry) in self.entries() {
            let (row, column) = (surface_of(from), surface_of(entry.face));
            rows[row][column] += self.areas[from] / wholes[row] * entry.factor;
        }
        SurfaceMatrix { surfaces, areas, rows }
    }
}
