//! The diagrams of run time against error that `cargo xtask bench` leaves, taken in as they are.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::svg::base64;

/// A diagram as a picture of its own, so that its names and colours stay its own.
#[derive(Debug, Serialize)]
pub(super) struct Diagram {
    /// Address with the data in it.
    source: String,
    title: String,
    /// Alternative text.
    description: String,
    file: String,
}

/// The diagrams of a folder in the order of their names, and the tables beside them; none if there is no such folder.
pub(super) fn read(folder: &Path) -> Result<(Vec<Diagram>, Vec<PathBuf>), Box<dyn Error>> {
    let mut files: Vec<PathBuf> = match fs::read_dir(folder) {
        Ok(entries) => entries.map(|entry| Ok(entry?.path())).collect::<Result<_, std::io::Error>>()?,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Vec::new(),
        Err(error) => return Err(format!("{}: {error}", folder.display()).into()),
    };
    files.sort();
    let of = |extension: &str| -> Vec<PathBuf> {
        files.iter().filter(|path| path.extension().is_some_and(|e| e == extension)).cloned().collect()
    };
    let diagrams = of("svg").iter().map(|path| diagram(path)).collect::<Result<_, _>>()?;
    Ok((diagrams, [of("svg"), of("csv")].concat()))
}

fn diagram(path: &Path) -> Result<Diagram, Box<dyn Error>> {
    let text = fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let name = path.file_stem().unwrap_or_default().to_string_lossy().replace(['-', '_'], " ");
    let title = element(&text, "title").unwrap_or_else(|| format!("Run time against error: {name}"));
    let description = element(&text, "desc").unwrap_or_else(|| format!("Work-precision diagram {name}."));
    Ok(Diagram { source: format!("data:image/svg+xml;base64,{}", base64(text.as_bytes())), title, description, file })
}

/// The text of the first element of a name.
fn element(text: &str, name: &str) -> Option<String> {
    let start = text.find(&format!("<{name}"))?;
    let inside = text[start..].split_once('>')?.1;
    let text = inside.split_once(&format!("</{name}>"))?.0.trim();
    (!text.is_empty()).then(|| text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&amp;", "&"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_diagram_names_itself_and_no_folder_is_no_diagram() {
        assert_eq!(element("<svg><title id=\"t\">far &amp; near</title></svg>", "title").as_deref(), Some("far & near"));
        assert_eq!(element("<svg></svg>", "desc"), None);
        assert!(read(Path::new("no/such/folder")).unwrap().0.is_empty());
    }
}
