//! Textures of MTL: `map_Kd` and `map_Ke` with their options, read when the first face needs them.
//!
//! `(u, v)` of a face becomes `s (u, v) + o` with the options `-s` and `-o`. A texture repeats, or with `-clamp on` continues with
//! its last texels. v = 0 is the lowest row of the image.
//!
//! A texture whose file is missing or is no PNG is noted by its name and not used; options that would change its values are noted.

use std::collections::HashMap;
use std::io;
use std::path::PathBuf;
use std::sync::Arc;

use crate::error::Error;
use crate::messages::{printable, quoted};
use crate::place::Place;
use crate::reading::ReadFile;
use crate::scene::intake::Intake;
use crate::texture;
use crate::texture::{Quantity, Texture, Wrap};
use crate::words::Words;

/// A texture as a library names it.
#[derive(Debug)]
pub(super) struct Map {
    place: Place,
    file: PathBuf,
    clamp: bool,
    mapping: Mapping,
}

/// A change of texture coordinates.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mapping {
    scale: [f64; 2],
    offset: [f64; 2],
}

impl Mapping {
    pub(super) fn apply(self, uv: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|k| self.scale[k] * uv[k] + self.offset[k])
    }
}

impl Map {
    /// Options, then the name of a file, which may have spaces; none without a name.
    pub(super) fn parse(mut words: Words<'_>, place: &Place, intake: &mut Intake) -> Result<Option<Self>, Error> {
        let (mut clamp, mut mapping) = (false, Mapping { scale: [1.0; 2], offset: [0.0; 2] });
        while words.remainder().starts_with('-') {
            let option = words.next().unwrap_or_default();
            match option {
                "-s" => mapping.scale = pair(&mut words, 1.0)?,
                "-o" => mapping.offset = pair(&mut words, 0.0)?,
                "-clamp" => clamp = words.next() == Some("on"),
                // These only filter the image.
                "-blendu" | "-blendv" | "-boost" | "-texres" | "-bm" | "-type" => drop(words.next()),
                _ => {
                    // Of these, and of those that are unknown, the arguments are numbers, or one word of a few.
                    if matches!(option, "-cc" | "-imfchan" | "-colorspace" | "-colourspace") {
                        words.next();
                    }
                    skip_arguments(&mut words);
                    intake.ignore(place.clone(), format!("option {} of a texture is not used", quoted(Some(option))));
                }
            }
        }
        let file = words.remainder();
        if file.is_empty() {
            intake.ignore(place.clone(), "a texture without the name of a file is not used".to_owned());
            return Ok(None);
        }
        Ok(Some(Self { place: place.clone(), file: file.replace('\\', "/").into(), clamp, mapping }))
    }
}

/// Skips numbers, `on` and `off`, unless nothing follows them.
fn skip_arguments(words: &mut Words<'_>) {
    let mut ahead = words.clone();
    while ahead.next().is_some_and(|word| matches!(word, "on" | "off") || word.parse::<f64>().is_ok()) && !ahead.is_empty() {
        *words = ahead.clone();
    }
}

/// One to three numbers, of which two count.
fn pair(words: &mut Words<'_>, absent: f64) -> Result<[f64; 2], Error> {
    let mut pair = [words.number("u")?, absent];
    for index in 1..3 {
        let mut ahead = words.clone();
        if ahead.next().is_none_or(|word| word.parse::<f64>().is_err()) {
            break;
        }
        let value = words.number(if index == 1 { "v" } else { "w" })?;
        if index == 1 {
            pair[1] = value;
        }
    }
    Ok(pair)
}

/// Textures of the materials.
#[derive(Debug, Default)]
pub(super) struct Textures {
    /// Of each material that has any.
    maps: HashMap<usize, [Option<Map>; 2]>,
    /// The textures read, by the name of their file.
    read: HashMap<PathBuf, Option<Arc<Texture>>>,
    mappings: HashMap<usize, [Option<Mapping>; 2]>,
}

impl Textures {
    pub(super) fn add(&mut self, material: usize, maps: [Option<Map>; 2]) {
        if maps.iter().any(Option::is_some) {
            self.maps.insert(material, maps);
        }
    }

    /// The change of coordinates on a material's faces, for each texture that it has.
    pub(super) fn mappings(&self, material: usize) -> [Option<Mapping>; 2] {
        self.mappings.get(&material).copied().unwrap_or_default()
    }

    /// Gives a material its textures, if it has not got them yet.
    pub(super) fn load(&mut self, material: usize, intake: &mut Intake, read: &mut ReadFile<'_>) -> Result<(), Error> {
        let Some(maps) = self.maps.remove(&material) else { return Ok(()) };
        let mut mappings = [None; 2];
        for (quantity, map) in Quantity::ALL.into_iter().zip(maps) {
            let Some(map) = map else { continue };
            let texture = match self.read.get(&map.file) {
                Some(texture) => texture.clone(),
                None => {
                    let texture = match open(&map, quantity, intake, read) {
                        Err(error) if !intake.needs_materials() => {
                            intake.ignore_fault(error, "the texture is not used");
                            None
                        }
                        texture => texture?,
                    };
                    self.read.insert(map.file.clone(), texture.clone());
                    texture
                }
            };
            if let Some(texture) = texture {
                // The texels stay shared.
                let texture = if map.clamp { Arc::new(Texture::clone(&texture).wrapped([Wrap::Clamp; 2])) } else { texture };
                match intake.scene().set_texture(material, quantity, texture).map_err(|error| error.at_place(map.place)) {
                    Ok(()) => mappings[quantity as usize] = Some(map.mapping),
                    Err(error) if intake.needs_materials() => return Err(error),
                    Err(error) => intake.ignore_fault(error, "the texture is not used"),
                }
            }
        }
        self.mappings.insert(material, mappings);
        Ok(())
    }
}

/// Reads a texture; a file that is no PNG is noted.
fn open(map: &Map, quantity: Quantity, intake: &mut Intake, read: &mut ReadFile<'_>) -> Result<Option<Arc<Texture>>, Error> {
    let name = map.file.display().to_string();
    let content = read(&map.file);
    let why = match content {
        Ok(content) if texture::image::is_png(&content) => {
            let decoded = texture::image::decode(&content, &name, intake.budget());
            let (texture, transparent) = decoded.map_err(|error| error.at_place(map.place.clone()))?;
            if transparent {
                intake.ignore(map.place.clone(), "transparency is not used: every face is opaque".to_owned());
            }
            return Ok(Some(Arc::new(texture.turned_over())));
        }
        Ok(content) => format!("is {} and would have to be a PNG", texture::image::format_of(&content)),
        Err(error) if error.kind() == io::ErrorKind::FileTooLarge => {
            return Err(intake.budget().exceeded(&format!("`{}`", printable(&name))).at_place(map.place.clone()));
        }
        Err(error) => format!("cannot be read: {error}"),
    };
    let instead = if quantity == Quantity::Radiance { "Ke" } else { "Kd" };
    let what = format!("texture `map_{instead}` is not used, `{name}` {why}: `{instead}` holds all over the face");
    intake.ignore(map.place.clone(), what);
    Ok(None)
}
