//! Points as a table, six numbers a line or columns under a header, and answers as CSV.

use std::io::{self, Write};

use radgrad_scene::case::Id;

use super::{Answers, Point, Refusal};

/// The columns of a point, in the order of a line without header.
const COLUMNS: [&str; 6] = ["x", "y", "z", "nx", "ny", "nz"];

/// Whether a text is a table and no JSON Lines: its first line that says something does not begin with a brace.
pub(super) fn is_table(text: &[u8]) -> bool {
    let first = text.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii).find(|line| !line.is_empty());
    first.is_some_and(|line| {
        line.is_ascii() && matches!(line[0], b'0'..=b'9' | b'+' | b'-' | b'.' | b'#' | b'"' | b'a'..=b'z' | b'A'..=b'Z')
    })
}

/// Its points, one a line; blank lines and those that begin with `#` are passed over.
///
/// # Errors
/// If a header has not the columns of a point.
pub(super) fn parse(text: &[u8]) -> io::Result<Vec<(usize, Result<Point, Refusal>)>> {
    let lines = text.split(|&byte| byte == b'\n').enumerate().map(|(index, line)| (index + 1, line.trim_ascii()));
    let mut lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with(b"#")).peekable();
    let mut columns: Vec<String> = COLUMNS.map(str::to_owned).to_vec();
    if let Some((number, line)) = lines.peek() {
        let words = words(line);
        if words.iter().all(|word| word.parse::<f64>().is_err()) {
            let found: Vec<String> = words.iter().map(|word| word.to_ascii_lowercase()).collect();
            if let Some(missing) = COLUMNS.iter().find(|column| !found.iter().any(|name| name == *column)) {
                let said = format!(
                    "line {number}: no column `{missing}` in `{}`: a table of points has the columns x,y,z,nx,ny,nz and may have id",
                    found.join(",")
                );
                return Err(io::Error::new(io::ErrorKind::InvalidData, said));
            }
            columns = found;
            lines.next();
        }
    }
    Ok(lines.map(|(line, text)| (line, point(&columns, line, &words(text)))).collect())
}

/// The fields of a line: between commas or semicolons, quoted or not, else between spaces.
fn words(line: &[u8]) -> Vec<String> {
    let delimiter = [b',', b';', b'\t'].into_iter().find(|delimiter| line.contains(delimiter));
    let Some(delimiter) = delimiter else {
        return String::from_utf8_lossy(line).split_whitespace().map(str::to_owned).collect();
    };
    let mut reader = csv::ReaderBuilder::new().has_headers(false).delimiter(delimiter).trim(csv::Trim::All).from_reader(line);
    let record = reader.byte_records().next().and_then(Result::ok).unwrap_or_default();
    record.iter().map(|field| String::from_utf8_lossy(field).into_owned()).collect()
}

fn point(columns: &[String], line: usize, words: &[String]) -> Result<Point, Refusal> {
    let of = |name: &str| columns.iter().position(|column| column == name).and_then(|place| words.get(place));
    let id = of("id").map(|id| Id::from(id.as_str()));
    let refused = |error: String| Refusal { id: id.clone(), line, error };
    if words.len() != columns.len() {
        let said = format!("{} values, expected {}: {}", words.len(), columns.len(), columns.join(", "));
        return Err(refused(said));
    }
    let mut numbers = [0.0; 6];
    for (number, name) in numbers.iter_mut().zip(COLUMNS) {
        let word = of(name).map_or("", String::as_str);
        *number = word
            .parse()
            .ok()
            .filter(|value: &f64| value.is_finite())
            .ok_or_else(|| refused(format!("{name} is `{word}`: expected a finite number")))?;
    }
    let [x, y, z, nx, ny, nz] = numbers;
    Ok(Point { id, ..Point::new([x, y, z], [nx, ny, nz]) })
}

/// The answers as CSV: a line a point, and for each channel its numbers.
pub(super) fn write(answers: &Answers<'_>, channels: &[String], output: impl Write) -> Result<(), csv::Error> {
    let mut table = csv::Writer::from_writer(output);
    let id_of = |point: &Result<Point, Refusal>| match point {
        Ok(point) => point.id.clone(),
        Err(refusal) => refusal.id.clone(),
    };
    let has_id = answers.points.iter().any(|(_, point)| id_of(point).is_some());
    let has_certificates = answers.lines.iter().any(|(_, line)| line.as_ref().is_ok_and(|answer| answer.certified.is_some()));
    let has_lux = answers.photometry.is_some();
    let mut header: Vec<String> = has_id.then(|| "id".to_owned()).into_iter().collect();
    header.extend(COLUMNS.into_iter().chain(["on"]).map(str::to_owned));
    if has_lux {
        header.extend(["illuminance", "illuminance_estimate"].map(str::to_owned));
    }
    let suffix = |name: &str| if channels.len() == 1 { String::new() } else { format!("_{name}") };
    for name in channels {
        let certified = ["certified_lower", "certified_upper"].into_iter().filter(|_| has_certificates);
        let each = ["irradiance", "irradiance_estimate", "radiosity", "radiosity_estimate"].into_iter().chain(certified);
        header.extend(each.map(|column| format!("{column}{}", suffix(name))));
    }
    header.push("error".to_owned());
    table.write_record(&header)?;
    for ((_, point), (_, line)) in answers.points.iter().zip(&answers.lines) {
        let mut row: Vec<String> = Vec::new();
        if has_id {
            row.push(id_of(point).map_or_else(String::new, |id| id.to_string()));
        }
        if let Ok(point) = point {
            row.extend(point.position.iter().chain(&point.normal).map(|number| format!("{number:?}")));
        }
        match line {
            Ok(answer) => {
                row.push(answer.on.name().to_owned());
                if let Some(lit) = &answer.lit {
                    row.extend([lit.illuminance, lit.illuminance_estimate].map(|number| format!("{number:?}")));
                }
                for channel in 0..channels.len() {
                    let of_face = answer.reflected.as_ref().map(|of| [of.radiosity[channel], of.estimate[channel]]);
                    let numbers = [answer.irradiance[channel], answer.irradiance_estimate[channel]].map(Some).into_iter();
                    let numbers = numbers.chain(of_face.map_or([None; 2], |of| of.map(Some)));
                    let ends = answer.certified.as_ref().map(|of| of[channel]);
                    let certified = ends.map_or([None; 2], |of| of.map(Some)).into_iter().filter(|_| has_certificates);
                    row.extend(numbers.chain(certified).map(|number| number.map_or_else(String::new, |x| format!("{x:?}"))));
                }
                row.push(String::new());
            }
            Err(refusal) => {
                row.resize(header.len() - 1, String::new());
                row.push(refusal.error.clone());
            }
        }
        table.write_record(&row)?;
    }
    table.flush()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_has_six_numbers_a_line_or_a_header_and_a_bad_line_costs_itself_only() {
        for text in ["0 0 .75 0 0 1\n1,0,0.75, 0,0,1\n", "nx,ny,nz,x,y,z\n0,0,1,0,0,0.75\n\n# none\n0;0;1;1;0;.75\n"] {
            assert!(is_table(text.as_bytes()));
            let points: Vec<Point> = parse(text.as_bytes()).unwrap().into_iter().map(|(_, point)| point.unwrap()).collect();
            let places: Vec<_> = points.iter().map(|point| (point.position, point.normal)).collect();
            assert_eq!(places, [([0.0, 0.0, 0.75], [0.0, 0.0, 1.0]), ([1.0, 0.0, 0.75], [0.0, 0.0, 1.0])]);
        }
        let named = parse(b"ID,X,Y,Z,NX,NY,NZ\n\"a, b\",0,0,0,0,0,1\nc,0,0,0,0,1\nd,0,0,nan,0,0,1\n").unwrap();
        assert_eq!(named[0].1.as_ref().unwrap().id, Some(Id::from("a, b")));
        let errors: Vec<&str> = named[1..].iter().map(|(_, point)| point.as_ref().unwrap_err().error.as_str()).collect();
        assert!(errors[0].starts_with("6 values, expected 7") && errors[1].starts_with("z is `nan`"), "{errors:?}");
        assert!(parse(b"x,y,z\n0,0,0\n").unwrap_err().to_string().contains("no column `nx`"));
        assert!(!is_table(b"\n {\"position\":[0,0,0]}") && !is_table(b""));
    }
}
