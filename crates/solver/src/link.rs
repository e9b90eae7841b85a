//! Links: what a leaf gathers from, and how roughly (P. Hanrahan, D. Salzman and L. Aupperle 1991).
//!
//! A leaf gathers from every element that it sees through one link, either to the element or to each of its children. A link
//! takes the first functions of its source's basis, whose values at the leaf's nodes it keeps. What it neglects is known, the
//! radiosity of the leaves below the source less the functions taken, and has the mean 0 over the source. With F the form factor
//! of a node, and P and S the largest value and slope of the kernel times the source's area (S infinite past occluders), its
//! gather errs by at most `F m`, m the largest magnitude of the neglected part; by `P s/2`, s the root mean square of that part,
//! since a constant may be taken from the kernel; and by `S R s`, R the source's radius, since its value at the centre may be.
//! The smallest counts.
//!
//! Links are refined where that error, times the reflectance, is too large: Hanrahan's brightness-weighted refinement, with a
//! bound in the place of the brightness.

use rayon::prelude::*;

use crate::Error;
use crate::field::Field;
use crate::mesh::Sight;
use crate::transfer::{Optics, Row, Station};

/// A leaf's link to a source.
#[derive(Debug, Clone)]
pub(crate) struct Link {
    pub(crate) source: usize,
    /// Number of the source's functions that are gathered.
    pub(crate) count: usize,
    pub(crate) sight: Sight,
    /// For each node of the leaf.
    pub(crate) rows: Vec<Row>,
}

impl Optics<'_> {
    /// The nodes of an element, as points that receive.
    pub(crate) fn stations(&self, leaf: usize) -> Vec<Station> {
        let element = &self.mesh.elements()[leaf];
        let station = |at| Station { point: element.point(at), normal: element.polygon().normal(), face: element.face() };
        self.mesh.basis(leaf).nodes().iter().map(|node| station(node.at)).collect()
    }

    /// Links a leaf to the elements of `sources`, each with the number of functions and the faces that may be between.
    fn links(&self, leaf: usize, sources: &[(usize, usize, Option<&[usize]>)]) -> Result<Vec<Link>, Error> {
        let stations = self.stations(leaf);
        let mut links = Vec::with_capacity(sources.len());
        for &(source, count, known) in sources {
            let sight = self.mesh.sight(leaf, source, known);
            if sight != Sight::Nothing {
                let mut link = Link { source, count: 0, sight, rows: vec![Row::default(); stations.len()] };
                // In the clear all functions cost little more than one.
                let count = if link.sight == Sight::Clear { self.mesh.basis(source).len() } else { count };
                self.extend(&mut link, &stations, count)?;
                links.push(link);
            }
        }
        Ok(links)
    }

    /// Takes more functions into a link.
    fn extend(&self, link: &mut Link, stations: &[Station], count: usize) -> Result<(), Error> {
        let Link { source, sight, rows, .. } = link;
        for (row, station) in rows.iter_mut().zip(stations) {
            let sight = match &*sight {
                Sight::Past(known) => &self.mesh.sight_of_point(station.face, station.point, *source, Some(known)),
                other => other,
            };
            self.receive(row, station, *source, sight, count)?;
        }
        link.count = link.rows.iter().map(|row| row.values.len()).min().unwrap_or(count);
        Ok(())
    }

    /// The links of a leaf without any: to all roots, or to the sources of its parent.
    pub(crate) fn first_links(&self, leaf: usize, of_parent: Option<&[Link]>) -> Result<Vec<Link>, Error> {
        match of_parent {
            Some(links) => {
                let source = |link: &'_ Link| (link.source, link.count, link.sight.clone());
                let sources: Vec<_> = links.iter().map(source).collect();
                let known = |sight: &Sight| if let Sight::Past(known) = sight { known.clone() } else { Vec::new() };
                let known: Vec<Vec<usize>> = sources.iter().map(|s| known(&s.2)).collect();
                let sources: Vec<_> = sources.iter().zip(&known).map(|(s, known)| (s.0, s.1, Some(&known[..]))).collect();
                self.links(leaf, &sources)
            }
            None => {
                let sources: Vec<_> = self.mesh.roots().iter().map(|&root| (root, 1, None)).collect();
                self.links(leaf, &sources)
            }
        }
    }

    /// Refines the links of a leaf until the sum of their errors, each channel times its weight, is at most `allowed` or
    /// nothing is left to refine. Returns whether any was.
    pub(crate) fn refine(
        &self,
        leaf: usize,
        links: &mut Vec<Link>,
        field: &Field,
        weight: &[f64],
        allowed: f64,
    ) -> Result<bool, Error> {
        let stations = self.stations(leaf);
        let mut errors: Vec<f64> = links.iter().map(|link| self.weighted_error(link, field, weight)).collect();
        let mut changed = false;
        loop {
            let worst = (0..links.len()).max_by(|&a, &b| errors[a].total_cmp(&errors[b]));
            let Some(worst) = worst.filter(|&w| errors[w] > 0.0 && errors.iter().sum::<f64>() > allowed) else {
                return Ok(changed);
            };
            changed = true;
            let (source, count) = (links[worst].source, links[worst].count);
            let (basis, element) = (self.mesh.basis(source), &self.mesh.elements()[source]);
            let degree = (0..=basis.degree()).find(|&d| basis.count(d) >= count).unwrap_or(basis.degree());
            let divides = element.children().filter(|_| {
                count == basis.len()
                    || field.rms_beyond(source, basis.len(), weight) > 0.5 * field.rms_beyond(source, count, weight)
            });
            if let Some(first) = divides {
                let link = links.swap_remove(worst);
                errors.swap_remove(worst);
                let known = if let Sight::Past(known) = &link.sight { &known[..] } else { &[] };
                let sources: Vec<_> = (first..first + 4).map(|child| (child, count, Some(known))).collect();
                for link in self.links(leaf, &sources)? {
                    errors.push(self.weighted_error(&link, field, weight));
                    links.push(link);
                }
            } else if count < basis.len() {
                self.extend(&mut links[worst], &stations, basis.count(degree + 1))?;
                errors[worst] = self.weighted_error(&links[worst], field, weight);
            } else {
                errors[worst] = 0.0;
            }
        }
    }

    /// Bound on what a link neglects at any node, the largest of the channels after each is multiplied by its weight.
    fn weighted_error(&self, link: &Link, field: &Field, weight: &[f64]) -> f64 {
        let neglected = |channel: usize| {
            let errors = link.rows.iter().map(|row| field.neglected(self.mesh, link.source, link.count, channel, row));
            weight[channel] * errors.fold(0.0, f64::max)
        };
        (0..weight.len()).map(neglected).fold(0.0, f64::max)
    }
}

/// Computes something for each leaf on all cores, in their order.
pub(crate) fn for_leaves<T: Send>(leaves: &[usize], f: impl Fn(usize) -> Result<T, Error> + Sync) -> Result<Vec<T>, Error> {
    leaves.par_iter().map(|&leaf| f(leaf)).collect()
}
