//! Tables of the page: sortable, each with the file that its numbers are from.

use serde::Serialize;

/// A table.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Table {
    /// A line on its contents.
    caption: String,
    /// The files beside the page that its numbers are from.
    files: Vec<&'static str>,
    columns: Vec<Column>,
    rows: Vec<Vec<Cell>>,
}

#[derive(Debug, Clone, Serialize)]
struct Column {
    title: &'static str,
    is_number: bool,
    /// Sentences, which need room to be broken into lines.
    is_prose: bool,
}

/// A cell: a text, and its key for sorting where that is another.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Cell {
    text: String,
    key: Option<String>,
    is_code: bool,
}

impl Table {
    /// An empty table. A column's title that begins with `#` is of numbers, with `~` of sentences.
    pub(super) fn new(caption: &str, files: &[&'static str], titles: &[&'static str]) -> Self {
        let column = |title: &&'static str| Column {
            title: title.trim_start_matches(['#', '~']),
            is_number: title.starts_with('#'),
            is_prose: title.starts_with('~'),
        };
        Self {
            caption: caption.to_owned(),
            files: files.to_vec(),
            columns: titles.iter().map(column).collect(),
            rows: Vec::new(),
        }
    }

    pub(super) fn push(&mut self, row: impl IntoIterator<Item = Cell>) {
        self.rows.push(row.into_iter().collect());
    }
}

impl Cell {
    /// A command or a name of the code.
    pub(super) fn code(text: &str) -> Self {
        Self { is_code: true, ..Self::from(text) }
    }

    /// The same with a key for sorting.
    pub(super) fn by(self, key: f64) -> Self {
        Self { key: Some(format!("{key:e}")), ..self }
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self { text: text.to_owned(), key: None, is_code: false }
    }
}

impl From<&String> for Cell {
    fn from(text: &String) -> Self {
        Self::from(text.as_str())
    }
}

impl From<u64> for Cell {
    fn from(count: u64) -> Self {
        Self { text: super::audit::thousands(&count.to_string()), key: Some(count.to_string()), is_code: false }
    }
}
