//! Material libraries of OBJ files: `Kd` is the diffuse reflectance, `Ke` the emitted radiance, each 0 where it is not given.
//!
//! What else a material says does not concern a diffuse surface. Where it would change the diffuse part, a texture or
//! transparency, that is noted; keywords that are unknown are noted too.

use std::collections::HashMap;
use std::path::Path;

use super::for_each_statement;
use crate::scene::Intake;
use crate::words::{Words, decode, quoted};
use crate::{Error, Place, Position};

/// A material of which not all is read yet.
struct Entry {
    name: String,
    reflectance: Colour,
    radiance: Colour,
}

/// Three values, and where they stand.
struct Colour {
    place: Place,
    values: [f64; 3],
}

/// Reads a library into the scene of `intake`, and the index of each material into `materials`.
pub(super) fn parse(text: &[u8], file: &Path, intake: &mut Intake, materials: &mut HashMap<String, usize>) -> Result<(), Error> {
    let mut entry: Option<Entry> = None;
    for_each_statement(text, |line, statement| {
        let place = Place::new(file, Position::Line(line));
        let result = decode(statement).and_then(|text| {
            let mut words = Words::new(text);
            let keyword = words.next().unwrap_or_default();
            if keyword == "newmtl" {
                let name = words.rest().to_owned();
                if name.is_empty() {
                    return Err(Error::expected("the name of a material", quoted(None)));
                }
                let black = || Colour { place: place.clone(), values: [0.0; 3] };
                let next = Entry { name, reflectance: black(), radiance: black() };
                return entry.replace(next).map_or(Ok(()), |entry| add(entry, intake, materials));
            }
            let Some(entry) = entry.as_mut() else {
                return Err(Error::expected("`newmtl` before any property", quoted(Some(keyword))));
            };
            property(entry, keyword, words, intake, &place)
        });
        result.map_err(|error| if error.place().is_some() { error } else { error.at(place) })
    })?;
    entry.map_or(Ok(()), |entry| add(entry, intake, materials))
}

fn property(entry: &mut Entry, keyword: &str, mut words: Words<'_>, intake: &mut Intake, place: &Place) -> Result<(), Error> {
    match keyword {
        "Kd" => entry.reflectance = Colour { place: place.clone(), values: colour(words)? },
        "Ke" => entry.radiance = Colour { place: place.clone(), values: colour(words)? },
        "d" | "Tr" => {
            if words.rest().starts_with("-halo") {
                words.next();
            }
            let opaque = if keyword == "d" { 1.0 } else { 0.0 };
            if words.number(keyword)? != opaque {
                intake.ignore(place.clone(), "transparency is not used: every face is opaque".to_owned());
            }
        }
        "map_Kd" | "map_Ke" | "map_d" => {
            let instead = if keyword == "map_Ke" { "Ke" } else { "Kd" };
            intake.ignore(place.clone(), format!("texture `{keyword}` is not used: `{instead}` holds all over the face"));
        }
        "Ka" | "Ks" | "Ns" | "Ni" | "Tf" | "illum" | "sharpness" | "map_Ka" | "map_Ks" | "map_Ns" | "map_bump" | "map_Bump"
        | "bump" | "disp" | "decal" | "refl" | "map_refl" | "map_aat" | "norm" | "Pr" | "Pm" | "Ps" | "Pc" | "Pcr" | "aniso"
        | "anisor" | "map_Pr" | "map_Pm" | "map_Ps" => {}
        _ => intake.ignore(place.clone(), format!("unknown property `{keyword}` is not used")),
    }
    Ok(())
}

/// Three numbers, or one for all three.
fn colour(mut words: Words<'_>) -> Result<[f64; 3], Error> {
    if words.rest().starts_with("spectral") || words.rest().starts_with("xyz") {
        return Err(Error::Unsupported {
            what: format!("a colour given as {}", quoted(words.next())),
            instead: "give red, green and blue",
        });
    }
    let red = words.number("red")?;
    if words.is_empty() {
        return Ok([red; 3]);
    }
    let colour = [red, words.number("green")?, words.number("blue")?];
    words.end()?;
    Ok(colour)
}

/// Adds a material to the scene. Of two with one name the later counts, as for whoever reads one line at a time.
fn add(entry: Entry, intake: &mut Intake, materials: &mut HashMap<String, usize>) -> Result<(), Error> {
    let Entry { name, reflectance, radiance } = &entry;
    let index = intake.scene().add_material(name, reflectance.values, radiance.values).map_err(|error| {
        let place =
            if matches!(error, Error::Material { quantity: "radiance", .. }) { &radiance.place } else { &reflectance.place };
        error.at(place.clone())
    })?;
    materials.insert(entry.name, index);
    Ok(())
}
