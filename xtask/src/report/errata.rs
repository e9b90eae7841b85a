//! The paper's misprints as `ERRATA.md` has them, which a test holds to the measured effects.

use std::error::Error;

/// One misprint.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Misprint {
    pub(super) place: String,
    pub(super) name: String,
    pub(super) printed: String,
    pub(super) right: String,
    /// Relative error that it causes: of the radiosity, of the gradient; empty where the document states none.
    pub(super) harm: [String; 2],
}

/// Reads the two tables of the document.
pub(super) fn read(document: &str) -> Result<Vec<Misprint>, Box<dyn Error>> {
    let rows: Vec<Vec<String>> = document.lines().filter(|line| line.starts_with("| ")).map(cells).collect();
    let harm = |name: &str| {
        let row = rows.iter().find(|row| row.len() == 4 && row[0] == name);
        row.map_or_else(Default::default, |row| [row[2].clone(), row[3].clone()])
    };
    let misprints: Vec<Misprint> = rows
        .iter()
        .filter(|row| row.len() == 5 && row[0] != "place")
        .map(|row| Misprint {
            place: row[0].clone(),
            name: row[1].clone(),
            printed: row[2].clone(),
            right: row[3].clone(),
            harm: harm(&row[1]),
        })
        .collect();
    match radgrad_paper::appendix::Misprint::ERRATA.iter().find(|slip| !misprints.iter().any(|m| m.name == slip.name())) {
        Some(missing) => Err(format!("ERRATA.md has no row for {}", missing.name()).into()),
        None => Ok(misprints),
    }
}

fn cells(line: &str) -> Vec<String> {
    line.trim_matches('|').split(" | ").map(|cell| cell.replace('`', "").trim().to_owned()).collect()
}

/// `place,name,printed,right,radiosity,gradient`.
pub(super) fn csv(misprints: &[Misprint]) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut rows = csv::Writer::from_writer(Vec::new());
    rows.write_record(["place", "name", "printed", "right", "radiosity", "gradient"])?;
    for Misprint { place, name, printed, right, harm: [radiosity, gradient] } in misprints {
        rows.write_record([place, name, printed, right, radiosity, gradient])?;
    }
    Ok(rows.into_inner()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_misprint_of_the_document_is_read_with_its_harm() {
        let misprints = read(include_str!("../../../ERRATA.md")).unwrap();
        let misprint = |name: &str| misprints.iter().find(|m| m.name == name).unwrap();
        assert_eq!(misprint("j1-sign").harm[0], "7.47 % to 1829.29 %");
        assert_eq!(misprint("i2-for-i1").printed, "sum I2(i) e_i");
        assert!(misprints.iter().all(|m| m.name == "k1-constant" || !m.harm[0].is_empty()), "{misprints:?}");
        assert!(read("| a | b |").is_err());
    }
}
