//! Links: the elements that an element gathers from, and how roughly (P. Hanrahan, D. Salzman and L. Aupperle 1991).
//!
//! A receiver gathers from every element that it sees through one link, either to the element or to each of its children. A link
//! takes the polynomial that its source holds, and keeps the irradiance of its functions at the receiver's nodes. The light that it
//! neglects is known: the radiosity of the leaves below the source less that polynomial,
//! [`Field::neglected`](crate::field::Field::neglected).

use crate::bytes::bytes_of;
use crate::links::transfer::Row;
use crate::mesh::Sight;
use crate::mesh::basis::Basis;

/// A receiver's link to a source.
#[derive(Debug, Clone)]
pub(crate) struct Link {
    pub(crate) source: usize,
    pub(crate) sight: Sight,
    /// For each node of the receiver.
    pub(crate) rows: Vec<Row>,
    /// The projection of the rows: for each of the receiver's functions, the light of each of the source's.
    pub(crate) matrix: Vec<f64>,
}

impl Link {
    /// Whether it is one from elements with such bases.
    pub(crate) fn is_of(&self, receiver: &Basis, source: &Basis) -> bool {
        self.rows.len() == receiver.nodes().len()
            && self.rows.iter().all(|row| row.values.len() == source.len())
            && self.matrix.len() == receiver.len() * source.len()
    }
}

/// The rows of links.
pub(crate) fn rows(links: &[Link]) -> impl Iterator<Item = &[Row]> {
    links.iter().map(|link| &link.rows[..])
}

bytes_of!(Link { source, sight, rows, matrix });
