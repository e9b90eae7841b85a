//! Material libraries of OBJ files: `Kd` is the diffuse reflectance, `Ke` the emitted radiance, each 0 where it is not given. A
//! texture, `map_Kd` or `map_Ke`, multiplies them, and stands alone where they are not given.
//!
//! Other statements of a material do not concern a diffuse surface, and are noted; so are keywords that are unknown.
//!
//! A file without `newmtl` in its first statement is no library, and no message quotes from it: a scene may name any file.

use std::collections::HashMap;
use std::path::Path;

use super::for_each_statement;
use super::map::{Map, Textures};
use crate::scene::Intake;
use crate::texture::Quantity;
use crate::words::{Words, decode, quoted};
use crate::{Error, Place, Position};

/// A material of which not all is read yet.
struct Entry {
    name: String,
    reflectance: Colour,
    radiance: Colour,
    maps: [Option<Map>; 2],
}

/// Three values, and where they stand.
struct Colour {
    place: Place,
    values: Option<[f64; 3]>,
}

/// Reads a library into the scene of `intake`, and the index of each material into `materials`.
pub(super) fn parse(
    text: &[u8],
    file: &Path,
    intake: &mut Intake,
    materials: &mut HashMap<String, usize>,
    textures: &mut Textures,
) -> Result<(), Error> {
    let mut entry: Option<Entry> = None;
    for_each_statement(text, |line, statement| {
        let place = Place::new(file, Position::Line(line));
        let text = match decode(statement) {
            Err(_) if entry.is_none() => Err(no_library()),
            text => text,
        };
        let result = text.and_then(|text| {
            let mut words = Words::new(text);
            let keyword = words.next().unwrap_or_default();
            if keyword == "newmtl" {
                let name = words.rest().to_owned();
                if name.is_empty() {
                    return Err(Error::expected("the name of a material", quoted(None)));
                }
                let none = || Colour { place: place.clone(), values: None };
                let next = Entry { name, reflectance: none(), radiance: none(), maps: [None, None] };
                return entry.replace(next).map_or(Ok(()), |entry| add(entry, intake, materials, textures));
            }
            let Some(entry) = entry.as_mut() else { return Err(no_library()) };
            property(entry, keyword, words, intake, &place)
        });
        result.map_err(|error| if error.place().is_some() { error } else { error.at(place) })
    })?;
    entry.map_or(Ok(()), |entry| add(entry, intake, materials, textures))
}

fn no_library() -> Error {
    Error::expected("a material library, `newmtl` first", "another file")
}

fn property(entry: &mut Entry, keyword: &str, mut words: Words<'_>, intake: &mut Intake, place: &Place) -> Result<(), Error> {
    match keyword {
        "Kd" => entry.reflectance = Colour { place: place.clone(), values: Some(colour(words)?) },
        "Ke" => entry.radiance = Colour { place: place.clone(), values: Some(colour(words)?) },
        "d" | "Tr" => {
            if words.rest().starts_with("-halo") {
                words.next();
            }
            let opaque = if keyword == "d" { 1.0 } else { 0.0 };
            if words.number(keyword)? != opaque {
                intake.ignore(place.clone(), "transparency is not used: every face is opaque".to_owned());
            }
        }
        "map_Kd" => entry.maps[Quantity::Reflectance as usize] = Some(Map::parse(words, place, intake)?),
        "map_Ke" => entry.maps[Quantity::Radiance as usize] = Some(Map::parse(words, place, intake)?),
        "map_d" => intake.ignore(place.clone(), "texture `map_d` is not used: every face is opaque".to_owned()),
        "Ka" | "Ks" | "Ns" | "Ni" | "Tf" | "illum" | "sharpness" | "map_Ka" | "map_Ks" | "map_Ns" | "map_bump" | "map_Bump"
        | "bump" | "disp" | "decal" | "refl" | "map_refl" | "map_aat" | "norm" | "Pr" | "Pm" | "Ps" | "Pc" | "Pcr" | "aniso"
        | "anisor" | "map_Pr" | "map_Pm" | "map_Ps" => {
            intake.ignore(place.clone(), format!("property `{keyword}` is not used: surfaces are opaque and diffuse"));
        }
        _ => intake.ignore(place.clone(), format!("unknown property {} is not used", quoted(Some(keyword)))),
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
fn add(entry: Entry, intake: &mut Intake, materials: &mut HashMap<String, usize>, textures: &mut Textures) -> Result<(), Error> {
    let Entry { name, reflectance, radiance, maps } = &entry;
    let values = |colour: &Colour, map: &Option<Map>| colour.values.unwrap_or([if map.is_some() { 1.0 } else { 0.0 }; 3]);
    let [of_reflectance, of_radiance] = [values(reflectance, &maps[0]), values(radiance, &maps[1])];
    let index = intake.add_material(name, &of_reflectance, &of_radiance).map_err(|error| {
        let place =
            if matches!(error, Error::Material { quantity: "radiance", .. }) { &radiance.place } else { &reflectance.place };
        error.at(place.clone())
    })?;
    materials.insert(entry.name, index);
    textures.add(index, entry.maps);
    Ok(())
}
