//! Rows that a run keeps as it goes, so that the next one goes on where it was interrupted.
//!
//! The first line of the file is a JSON object that says of what it is: the scene's fingerprint and what was asked of its factors. Each
//! further line is a computed row. A line that has no end, as a kill leaves it, is taken off and computed again. A file that begins
//! with anything else is none of ours, and is left as it is.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// Of what the rows are.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Head {
    factors_of: String,
    asked: String,
    version: String,
}

impl Head {
    fn of(scene: &str, asked: String) -> Self {
        Self { factors_of: scene.to_owned(), asked, version: env!("CARGO_PKG_VERSION").to_owned() }
    }
}

/// Why rows cannot be kept.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error("{}: {source}", file.display())]
    Unusable { file: PathBuf, source: io::Error },
    #[error("`{}` is no file of --resume, and is left as it is: name another one, or remove it", file.display())]
    Foreign { file: PathBuf },
    #[error("{}: another run keeps its rows there", file.display())]
    Taken { file: PathBuf },
    #[error("{}: line {line} is no row of --resume: {source}", file.display())]
    Content { file: PathBuf, line: usize, source: serde_json::Error },
    #[error("{}: it was written for another scene or other settings, or by another version: name another one, or remove it", file.display())]
    Other { file: PathBuf },
}

/// A file that rows are added to.
pub(crate) struct Kept {
    file: PathBuf,
    out: Mutex<Out>,
}

struct Out {
    file: File,
    /// The first thing that went wrong.
    failed: Option<io::Error>,
}

impl Kept {
    /// Opens the file of a run for this scene and these settings, and reads what it has.
    pub(crate) fn open<Row: DeserializeOwned>(file: &Path, scene: &str, asked: String) -> Result<(Self, Vec<Row>), Failure> {
        let unusable = |source: io::Error| Failure::Unusable { file: file.to_owned(), source };
        let head = Head::of(scene, asked);
        // Nothing is opened for writing before it is known for a file of ours.
        match std::fs::metadata(file) {
            Ok(metadata) if !metadata.is_file() => {
                return Err(unusable(io::Error::new(io::ErrorKind::InvalidInput, "it is no file that can be taken up")));
            }
            Ok(_) => check(file, &File::open(file).map_err(unusable)?, &head)?,
            Err(source) if source.kind() == io::ErrorKind::NotFound => {}
            Err(source) => return Err(unusable(source)),
        }
        let opened = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(file).map_err(unusable)?;
        // Where files cannot be locked, a second run is not noticed.
        if let Err(TryLockError::WouldBlock) = opened.try_lock() {
            return Err(Failure::Taken { file: file.to_owned() });
        }
        check(file, &opened, &head)?;
        let (rows, end) = read(file, &opened)?;
        opened.set_len(end).map_err(unusable)?;
        let mut out = opened;
        out.seek(SeekFrom::End(0)).map_err(unusable)?;
        if end == 0 {
            out.write_all(&line(&head)).map_err(unusable)?;
        }
        Ok((Self { file: file.to_owned(), out: Mutex::new(Out { file: out, failed: None }) }, rows))
    }

    /// Adds a row.
    pub(crate) fn keep(&self, row: &impl Serialize) {
        let line = line(row);
        let mut out = self.out.lock().unwrap_or_else(PoisonError::into_inner);
        if out.failed.is_none() {
            out.failed = out.file.write_all(&line).err();
        }
    }

    /// Whether all rows were kept.
    pub(crate) fn close(self) -> Result<(), Failure> {
        let out = self.out.into_inner().unwrap_or_else(PoisonError::into_inner);
        out.failed.map_or(Ok(()), |source| Err(Failure::Unusable { file: self.file, source }))
    }
}

/// The rows that another run kept, for this scene and these settings.
pub(super) fn rows<Row: DeserializeOwned>(file: &Path, scene: &str, asked: &str) -> Result<Vec<Row>, Failure> {
    let unusable = |source| Failure::Unusable { file: file.to_owned(), source };
    if !std::fs::metadata(file).map_err(unusable)?.is_file() {
        return Err(unusable(io::Error::new(io::ErrorKind::InvalidInput, "it is no file that can be taken up")));
    }
    let opened = File::open(file).map_err(unusable)?;
    check(file, &opened, &Head::of(scene, asked.to_owned()))?;
    read(file, &opened).map(|(rows, _)| rows)
}

/// A line of JSON.
fn line(of: &impl Serialize) -> Vec<u8> {
    // Numbers, texts and lists of them are always JSON.
    let mut line = serde_json::to_vec(of).unwrap_or_default();
    line.push(b'\n');
    line
}

/// Refuses a file whose first line is not that of this run, or a part of it that a kill left, or nothing.
fn check(file: &Path, mut opened: &File, expected: &Head) -> Result<(), Failure> {
    const LONGEST: u64 = 1 << 16;
    let unusable = |source| Failure::Unusable { file: file.to_owned(), source };
    let mut first = Vec::new();
    BufReader::new(opened.take(LONGEST)).read_until(b'\n', &mut first).map_err(unusable)?;
    opened.rewind().map_err(unusable)?;
    if line(expected).starts_with(&first) {
        return Ok(());
    }
    match serde_json::from_slice::<Head>(&first) {
        Ok(_) if first.ends_with(b"\n") => Err(Failure::Other { file: file.to_owned() }),
        _ => Err(Failure::Foreign { file: file.to_owned() }),
    }
}

/// The rows of a file after its first line, and where its last whole line ends.
fn read<Row: DeserializeOwned>(file: &Path, opened: &File) -> Result<(Vec<Row>, u64), Failure> {
    let mut lines = BufReader::new(opened);
    let (mut rows, mut end, mut text) = (Vec::new(), 0, Vec::new());
    for number in 1.. {
        text.clear();
        let count = lines.read_until(b'\n', &mut text).map_err(|source| Failure::Unusable { file: file.to_owned(), source })?;
        if text.last() != Some(&b'\n') {
            break;
        }
        if number > 1 {
            let wrong = |source| Failure::Content { file: file.to_owned(), line: number, source };
            rows.push(serde_json::from_slice(&text).map_err(wrong)?);
        }
        end += count as u64;
    }
    Ok((rows, end))
}
