//! All factors of a scene, a row a face.

use radgrad_core::Receiver;
use rayon::prelude::*;

use super::pair::Pair;
use super::rule::{MOST_NODES, Node, nodes};
use super::{FactorSettings, FormFactors};
use crate::{Error, Scene};

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
        let areas: Vec<f64> = scene.polygons().map(radgrad_core::Polygon::area).collect();
        let exchanges = |face: &usize| scene.surfaces()[scene.faces()[*face].surface()].exchanges();
        let faces: Vec<usize> = (0..areas.len()).filter(exchanges).collect();
        // Each pair once, with the lower face.
        let pairs: Vec<Vec<(usize, Pair)>> = faces
            .par_iter()
            .enumerate()
            .map(|(place, &from)| {
                let pair = |&to: &usize| Some((to, self.pair(from, to, settings, areas[from].min(areas[to]))?));
                let found = faces[place + 1..].iter().filter_map(pair).collect();
                progress();
                found
            })
            .collect();
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
        Ok(FactorMatrix { areas, faces, rows })
    }

    /// One rule of points for all that the face sees.
    fn row(&self, from: usize, pairs: &[(usize, &Pair)], settings: &FactorSettings) -> Result<Vec<Entry>, Error> {
        let area = self.polygon(from).area();
        let (rule, mut sums) = self.rule_for(from, pairs, settings)?;
        let is_obstructed = |k: &usize| pairs[*k].1.bracket.is_some();
        for k in (0..pairs.len()).filter(is_obstructed) {
            let (to, pair) = pairs[k];
            let seen = |(receiver, share): &(Receiver, f64)| -> Result<f64, Error> {
                let value = self.at_node(receiver, from, to, &pair.candidates, settings.point_tolerance)?;
                Ok(share * value.radiosity)
            };
            sums[k] = rule.iter().map(seen).sum::<Result<f64, Error>>()?;
        }
        let entry = |(&(face, pair), factor): (&(usize, &Pair), f64)| {
            let [least, most] = pair.bounds().map(|bound| bound / area);
            // The truth is in the bracket, wherever the points are.
            let error = (most - factor).max(factor - least) * (1.0 + 8.0 * f64::EPSILON) + 8.0 * f64::EPSILON * factor.abs();
            Entry { face, factor, error, occluders: pair.candidates.len() }
        };
        Ok(pairs.iter().zip(sums).map(entry).collect())
    }
}

/// The points of a rule, each with its share of the face.
type Rule = Vec<(Receiver, f64)>;

impl FormFactors<'_> {
    /// The cheapest rule of a face that gives its factors with nothing in between well enough, and what it gives.
    fn rule_for(&self, from: usize, pairs: &[(usize, &Pair)], settings: &FactorSettings) -> Result<(Rule, Vec<f64>), Error> {
        let polygon = self.polygon(from);
        if pairs.is_empty() {
            return Ok((Vec::new(), Vec::new()));
        }
        let mut per_side = settings.points_per_side;
        loop {
            let point = |node: Node| {
                let receiver = Receiver::new(node.point, polygon.normal(), 1.0).map_err(Error::Receiver)?;
                Ok((receiver, node.share))
            };
            let rule: Rule = nodes(polygon, per_side).into_iter().map(point).collect::<Result<_, Error>>()?;
            let free = |to: usize| -> Result<f64, Error> {
                let seen = |(receiver, share): &(Receiver, f64)| -> Result<f64, Error> {
                    Ok(share * self.at_node(receiver, from, to, &[], settings.point_tolerance)?.radiosity)
                };
                rule.iter().map(seen).sum()
            };
            let sums: Vec<f64> = pairs.iter().map(|(to, _)| free(*to)).collect::<Result<_, Error>>()?;
            let is_off =
                |((_, pair), sum): (&(usize, &Pair), &f64)| (sum - pair.free.area / polygon.area()).abs() > settings.rule_error;
            if per_side == MOST_NODES || !pairs.iter().zip(&sums).any(is_off) {
                return Ok((rule, sums));
            }
            // Nine points become 16, 36, 81, 196 and 256.
            per_side = (per_side + per_side.div_ceil(3)).min(MOST_NODES);
        }
    }
}

impl FactorMatrix {
    /// Area of each face of the scene.
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

    /// Largest `|F_ij - F_ji A_j/A_i|`: the error of the rule of points, as far as the two ways differ in it.
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
        for (from, entry) in self.entries() {
            let (row, column) = (surface_of(from), surface_of(entry.face));
            rows[row][column] += self.areas[from] / areas[row] * entry.factor;
        }
        SurfaceMatrix { surfaces, areas, rows }
    }
}
