//! Material libraries of OBJ files: `Kd` is the diffuse reflectance, `Ke` the emitted radiance, each 0 where it is not given. A
//! texture, `map_Kd` or `map_Ke`, multiplies them, and stands alone where they are not given.
//!
//! Other statements of a material do not concern a diffuse surface, and are noted; so are keywords that are unknown.
//!
//! A wrong value is a fault of its material, not of the library: who has a face of it decides.
//!
//! Statements before the first `newmtl` are not read, and a file without it is no library: no message quotes from there, as a scene
//! may name any file.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::Path;

use super::map::{Map, Textures};
use super::statements::for_each_statement;
use crate::error::Error;
use crate::messages::{candidates, quoted};
use crate::place::{Place, Position};
use crate::scene::intake::Intake;
use crate::texture::Quantity;
use crate::words::Words;

/// A material of which not all is read yet.
struct Entry {
    name: String,
    reflectance: Colour,
    radiance: Colour,
    maps: [Option<Map>; 2],
    /// The first wrong value, with its place.
    fault: Option<Error>,
}

/// Three values, and where they stand.
struct Colour {
    place: Place,
    values: Option<[f64; 3]>,
}

/// Reads a library into the scene of `intake`, and the index of each material into `library`.
pub(super) fn parse(
    content: &[u8],
    file: &Path,
    intake: &mut Intake,
    library: &mut Library,
    textures: &mut Textures,
) -> Result<(), Error> {
    let text = intake.decode(content, file)?;
    let (mut entry, mut before): (Option<Entry>, Option<Place>) = (None, None);
    for_each_statement(&text, |line, statement| {
        let place = Place::new(file, Position::Line(line));
        let mut words = Words::new(statement);
        let keyword = words.next().unwrap_or_default();
        if keyword == "newmtl" {
            let name = words.remainder().to_owned();
            if name.is_empty() {
                intake.ignore(place.clone(), "`newmtl` must name a material: its name is taken as empty".to_owned());
            }
            let none = || Colour { place: place.clone(), values: None };
            let next = Entry { name, reflectance: none(), radiance: none(), maps: [None, None], fault: None };
            return entry.replace(next).map_or(Ok(()), |entry| add(entry, intake, library, textures));
        }
        match &mut entry {
            Some(entry) => {
                if let Err(error) = property(entry, keyword, words, intake, &place) {
                    entry.fault.get_or_insert(error.at_place(place));
                }
            }
            None => drop(before.get_or_insert(place)),
        }
        Ok(())
    })?;
    match (entry, before) {
        (None, place) => {
            let place = place.unwrap_or_else(|| Place::new(file, Position::File));
            Err(Error::expected("a material library, `newmtl` first", "another file").at_place(place))
        }
        (Some(entry), before) => {
            if let Some(place) = before {
                intake.ignore(place, "statements before the first `newmtl` are not used".to_owned());
            }
            add(entry, intake, library, textures)
        }
    }
}

fn property(entry: &mut Entry, keyword: &str, mut words: Words<'_>, intake: &mut Intake, place: &Place) -> Result<(), Error> {
    match keyword {
        "Kd" => {
            entry.reflectance = Colour { place: place.clone(), values: Some(colour(keyword, words, intake, place)?) };
        }
        "Ke" => {
            entry.radiance = Colour { place: place.clone(), values: Some(colour(keyword, words, intake, place)?) };
        }
        "d" | "Tr" => {
            if words.remainder().starts_with("-halo") {
                words.next();
            }
            let opaque = if keyword == "d" { 1.0 } else { 0.0 };
            if words.number(keyword) != Ok(opaque) {
                intake.ignore(place.clone(), "transparency is not used: every face is opaque".to_owned());
            }
        }
        "map_Kd" => entry.maps[Quantity::Reflectance as usize] = Map::parse(words, place, intake)?,
        "map_Ke" => entry.maps[Quantity::Radiance as usize] = Map::parse(words, place, intake)?,
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

/// Three numbers, or one for all three. Commas between them are noted; decimal commas are wrong.
fn colour(keyword: &str, words: Words<'_>, intake: &mut Intake, place: &Place) -> Result<[f64; 3], Error> {
    let text = words.remainder();
    if text.starts_with("spectral") || text.starts_with("xyz") {
        return Err(Error::Unsupported {
            what: format!("a colour given as {}", quoted(text.split_ascii_whitespace().next())),
            instead: "give red, green and blue",
        });
    }
    let mut words = Words::separated(text, |c| c == ',' || c.is_ascii_whitespace());
    let mut counted = words.clone();
    let count = std::iter::from_fn(|| counted.next()).count();
    if text.contains(',') {
        if count != 1 && count != 3 {
            return Err(Error::expected("three numbers with decimal points", format!("{}, with commas", quoted(Some(text)))));
        }
        intake.ignore(place.clone(), format!("numbers of `{keyword}` are parted by spaces in MTL: commas are taken for these"));
    }
    let red = words.number("red")?;
    if words.is_empty() {
        return Ok([red; 3]);
    }
    let colour = [red, words.number("green")?, words.number("blue")?];
    if !words.is_empty() {
        intake.ignore(place.clone(), format!("what follows the three numbers of `{keyword}` is not used"));
    }
    Ok(colour)
}

/// Adds a material to the scene. Of two with one name the later counts, as for whoever reads one line at a time.
fn add(entry: Entry, intake: &mut Intake, library: &mut Library, textures: &mut Textures) -> Result<(), Error> {
    let Entry { name, reflectance, radiance, maps, fault } = entry;
    if let Some(fault) = fault {
        return library.add_unknown(&name, fault, intake).map(|_| ());
    }
    let values = |colour: &Colour, map: &Option<Map>| colour.values.unwrap_or([if map.is_some() { 1.0 } else { 0.0 }; 3]);
    let [of_reflectance, of_radiance] = [values(&reflectance, &maps[0]), values(&radiance, &maps[1])];
    match intake.add_material(&name, &of_reflectance, &of_radiance) {
        Ok(index) => {
            library.names.insert(name, index);
            textures.add(index, maps);
            Ok(())
        }
        Err(error @ Error::Material { quantity, .. }) => {
            let place = if quantity == "radiance" { radiance.place } else { reflectance.place };
            library.add_unknown(&name, error.at_place(place), intake).map(|_| ())
        }
        Err(error) => Err(error.at_place(reflectance.place)),
    }
}

/// Unknown materials whose names are compared with all others, to say which was probably meant.
const MOST_COMPARED: usize = 64;

/// Materials by their names, those of libraries and those that are only asked for.
#[derive(Default)]
pub(super) struct Library {
    /// Index of each by its name.
    pub(super) names: HashMap<String, usize>,
    /// Those that are black for want of their values; a name may be given again.
    pub(super) unknown: BTreeSet<usize>,
    /// Of these, where materials are required: why. The first face of one is refused.
    pub(super) faults: BTreeMap<usize, Error>,
}

impl Library {
    /// The materials of libraries that there are in place of one that is not.
    pub(super) fn candidates(&self, name: &str) -> String {
        // The first face of one is refused: those after very many are compared with no name.
        if self.unknown.len() >= MOST_COMPARED {
            return "no library has a material of this name".to_owned();
        }
        let mut names: Vec<(usize, &str)> = self.names.iter().map(|(name, &index)| (index, name.as_str())).collect();
        names.retain(|(index, _)| !self.unknown.contains(index));
        if names.is_empty() {
            return "no library names one: `mtllib FILE` before it reads a library".to_owned();
        }
        names.sort_unstable();
        candidates(name, names.into_iter().map(|(_, name)| name))
    }

    /// Adds a black material in place of one that is not known: where materials are optional, that is noted.
    pub(super) fn add_unknown(&mut self, name: &str, error: Error, intake: &mut Intake) -> Result<usize, Error> {
        let black = intake.add_material(name, &[0.0; 3], &[0.0; 3])?;
        if intake.needs_materials() {
            intake.budget().take_many("materials", 1, 4 * size_of::<Error>())?;
            self.faults.insert(black, error);
        } else {
            intake.ignore_fault(error, "taken as black");
        }
        self.names.insert(name.to_owned(), black);
        self.unknown.insert(black);
        Ok(black)
    }
}
