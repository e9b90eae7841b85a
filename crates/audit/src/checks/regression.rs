//! Cases that once failed, kept small in `data/regressions/`: a file each, one line of JSON, read as any other case.
//!
//! The `id` is the name of the case it was shrunk from, so its family tells which gates hold for it.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use radgrad_scene::case::{Case, Id};
use radgrad_scene::output::write_whole;

use crate::bounds::campaign;
use crate::bounds::check::{Effort, check};
use crate::bounds::requirements::Breach;
use crate::cases::family::{Family, Name};
use crate::cases::name::BadName;
use crate::cases::shrink::shrink;
use crate::gates::{Fault, Violation};
use crate::measures::measure::{Outcome, measure};
use crate::measures::table::Table;

/// A case in a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Regression {
    /// The case it was shrunk from.
    pub name: Name,
    /// The case.
    pub case: Case,
}

/// Why a file is no regression.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// It cannot be read or written.
    #[error("{path}: {source}", path = path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// It does not hold a case.
    #[error("{path}: {source}", path = path.display())]
    Case {
        /// Which.
        path: PathBuf,
        /// Why.
        source: radgrad_scene::Error,
    },
    /// Its id does not name a case.
    #[error("{path}: {source}", path = path.display())]
    Name {
        /// Which.
        path: PathBuf,
        /// Why.
        source: BadName<Family>,
    },
}

impl Regression {
    /// A case that violates, shrunk as long as it does so in the same way and for the same cause: a figure beyond the gate must
    /// stay half as large against the case's condition, or the search would end in some case that deserves its error.
    #[must_use]
    pub fn shrunk(violation: &Violation) -> Self {
        let name = violation.case;
        let original = measure(&name.case());
        let fails = |case: &Case| same_fault(violation, &original, &measure(case));
        let mut case = shrink(&name.case(), fails);
        case.id = Id::Text(name.to_string());
        Self { name, case }
    }

    /// A case of the bounds campaign to blame for a breach, shrunk as long as it has the same mark; `None` where no single case
    /// is to blame, or this one no longer does it.
    #[must_use]
    pub fn of_breach(breach: &Breach) -> Option<Self> {
        let (name, mark) = (breach.case, breach.mark?);
        let mut effort = campaign::effort(name);
        let fails = |case: &Case| check(case, &effort).has(mark);
        if !fails(&name.case()) {
            return None;
        }
        // Without parts that it does not take, shrinking is quicker.
        let lighter = [
            Effort { oracle: false, digits: false, many: Vec::new(), ..effort.clone() },
            Effort { oracle: false, many: Vec::new(), ..effort.clone() },
            Effort { many: Vec::new(), ..effort.clone() },
        ];
        if let Some(light) = lighter.into_iter().find(|effort| check(&name.case(), effort).has(mark)) {
            effort = light;
        }
        let mut case = shrink(&name.case(), |case| check(case, &effort).has(mark));
        case.id = Id::Text(name.to_string());
        Some(Self { name, case })
    }

    /// Reads a file.
    ///
    /// # Errors
    /// If it cannot be read, does not hold a case, or the case is not named for one of a family.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let path_buf = || path.to_path_buf();
        let text = fs::read(path).map_err(|source| Error::File { path: path_buf(), source })?;
        let case = Case::from_json(&text).map_err(|source| Error::Case { path: path_buf(), source })?;
        let name = case.id.to_string().parse().map_err(|source| Error::Name { path: path_buf(), source })?;
        Ok(Self { name, case })
    }

    /// All in a folder, by file name.
    ///
    /// # Errors
    /// If the folder or a file in it cannot be read, or is no regression.
    pub fn read_all(folder: &Path) -> Result<Vec<Self>, Error> {
        let failed = |source| Error::File { path: folder.to_path_buf(), source };
        let entries = fs::read_dir(folder).map_err(failed)?;
        let mut paths = entries.map(|entry| Ok(entry?.path())).collect::<io::Result<Vec<_>>>().map_err(failed)?;
        paths.retain(|path| path.extension().is_some_and(|extension| extension == "json"));
        paths.sort();
        paths.iter().map(|path| Self::read(path)).collect()
    }

    /// Writes the case into a folder, as `family-seed-index.json`.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, folder: &Path) -> Result<PathBuf, Error> {
        let path = folder.join(format!("{}.json", self.name.to_string().replace(':', "-")));
        let write = || {
            fs::create_dir_all(folder)?;
            let line = serde_json::to_string(&self.case)?;
            write_whole(&path, |out| writeln!(out, "{line}")).map_err(io::Error::other)
        };
        write().map_err(|source| Error::File { path: path.clone(), source })?;
        Ok(path)
    }

    /// Its outcome as a table of one, to be held against the gates.
    #[must_use]
    pub fn table(&self) -> Table {
        Table::single(self.name, &measure(&self.case))
    }
}

fn same_fault(violation: &Violation, original: &Outcome, now: &Outcome) -> bool {
    match violation.fault {
        Fault::Ended { kind, .. } => now.kind() == kind,
        Fault::Beyond { quantity, gate, .. } => {
            let conditioned = |outcome: &Outcome| outcome.figure(quantity.over_condition());
            let beyond = now.figure(quantity).is_some_and(|figure| figure > gate);
            beyond && conditioned(now) >= conditioned(original).map(|figure| 0.5 * figure)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases::family::Family;
    use crate::measures::measure::Kind;

    #[test]
    fn a_regression_reads_back_as_written() {
        let folder = std::env::temp_dir().join(format!("radgrad-regression-{}", std::process::id()));
        let violation = Violation {
            case: Name { family: Family::EqualVertices, seed: 1, index: 2 },
            fault: Fault::Ended { kind: Kind::Refused, count: 1 },
        };
        let regression = Regression::shrunk(&violation);
        let path = regression.write(&folder).unwrap();
        assert!(path.ends_with("equal-vertices-1-2.json"));
        assert_eq!(Regression::read_all(&folder).unwrap(), std::slice::from_ref(&regression));
        fs::remove_dir_all(&folder).unwrap();
        assert_eq!(regression.table().families()[&Family::EqualVertices].count(Kind::Refused), 1);
    }

    #[test]
    fn a_file_that_is_no_regression_is_named() {
        let path = std::env::temp_dir().join(format!("radgrad-none-{}.json", std::process::id()));
        assert!(Regression::read(&path).unwrap_err().to_string().contains("radgrad-none"));
    }
}
