//! Textures of glTF materials: images out of files, URIs and buffers, and where they lie on faces.

use std::borrow::Cow;
use std::sync::Arc;

use super::document::{Document, TextureUse, Transform};
use super::{buffer, document};
use crate::error::Error;
use crate::place::Position;
use crate::reading::ReadFile;
use crate::scene::intake::Intake;
use crate::texture;
use crate::texture::{Quantity, Texture, Wrap};

/// The maps of a material: of the reflectance and of the radiance.
pub(super) type Maps = [Option<Map>; 2];

/// Where a texture lies.
#[derive(Debug, Clone)]
pub(super) struct Map {
    /// Number of the set of texture coordinates.
    pub(super) set: usize,
    transform: Option<Transform>,
}

impl Map {
    /// The texture's coordinates at a vertex with these.
    pub(super) fn apply(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let Some(Transform { offset, rotation, scale, .. }) = &self.transform else { return [u, v] };
        let (sin, cos) = (libm::sin(*rotation), libm::cos(*rotation));
        let [u, v] = [scale[0] * u, scale[1] * v];
        [offset[0] + cos * u + sin * v, offset[1] - sin * u + cos * v]
    }
}

/// An image: read, or noted as not used.
type Loaded = Option<Arc<Texture>>;

/// Gives the materials their textures and says where these lie.
pub(super) fn of_materials(
    document: &Document,
    buffers: &[Cow<'_, [u8]>],
    materials: &[usize],
    intake: &mut Intake,
    read: &mut ReadFile<'_>,
) -> Result<Vec<Maps>, Error> {
    let mut images: Vec<Option<Loaded>> = vec![None; document.images.len()];
    let mut every_map = Vec::with_capacity(document.materials.len());
    for (index, (material, &in_scene)) in document.materials.iter().zip(materials).enumerate() {
        let surface = material.pbr_metallic_roughness.as_ref();
        let uses = [surface.and_then(|surface| surface.base_color_texture.as_ref()), material.emissive_texture.as_ref()];
        let mut maps = [None, None];
        for (quantity, used) in Quantity::ALL.into_iter().zip(uses) {
            let Some(used) = used else { continue };
            let place = intake.place(Position::Member(format!("materials[{index}]")));
            let loaded = load(document, buffers, used, &mut images, intake, read);
            let loaded = loaded.map_err(|(member, error)| error.at_place(intake.place(Position::Member(member))));
            let set = loaded.and_then(|texture| {
                let set =
                    |texture| intake.scene().set_texture(in_scene, quantity, texture).map_err(|error| error.at_place(place));
                texture.map(set).transpose()
            });
            let set = match set {
                Err(error) if !intake.needs_materials() => {
                    intake.ignore_fault(error, "the texture is not used");
                    None
                }
                set => set?,
            };
            if set.is_some() {
                let transform = used.extensions.transform.clone();
                let set = transform.as_ref().and_then(|transform| transform.tex_coord).unwrap_or(used.tex_coord);
                maps[quantity as usize] = Some(Map { set, transform });
            }
        }
        every_map.push(maps);
    }
    Ok(every_map)
}

fn load(
    document: &Document,
    buffers: &[Cow<'_, [u8]>],
    used: &TextureUse,
    images: &mut [Option<Loaded>],
    intake: &mut Intake,
    read: &mut ReadFile<'_>,
) -> Result<Loaded, document::Fault> {
    let member = format!("textures[{}]", used.index);
    let Some(texture) = document.textures.get(used.index) else {
        return Err((member, document::no_such("texture", used.index, document.textures.len())));
    };
    // Without a source an extension has it.
    let Some(source) = texture.source else {
        let place = intake.place(Position::Member(member));
        intake.ignore(place, "a texture without a source is not used: factors hold all over the face".to_owned());
        return Ok(None);
    };
    let Some(image) = images.get(source) else {
        return Err((member, document::no_such("image", source, images.len())));
    };
    let loaded = match image {
        Some(loaded) => loaded.clone(),
        None => {
            let loaded = open(document, buffers, source, intake, read)?;
            images[source] = Some(loaded.clone());
            loaded
        }
    };
    let wrap = match texture.sampler.map(|sampler| document.samplers.get(sampler)) {
        None => [Wrap::Repeat; 2],
        Some(Some(sampler)) => {
            let wrap = |number| wrap_of(number).map_err(|error| (member.clone(), error));
            [wrap(sampler.wrap_s)?, wrap(sampler.wrap_t)?]
        }
        Some(None) => {
            return Err((member, document::no_such("sampler", texture.sampler.unwrap_or(0), document.samplers.len())));
        }
    };
    Ok(loaded.map(|texture| if wrap == [Wrap::Repeat; 2] { texture } else { Arc::new(Texture::clone(&texture).wrapped(wrap)) }))
}

/// By the numbers of the format.
fn wrap_of(number: Option<u64>) -> Result<Wrap, Error> {
    match number {
        None | Some(10497) => Ok(Wrap::Repeat),
        Some(33648) => Ok(Wrap::Mirror),
        Some(33071) => Ok(Wrap::Clamp),
        Some(other) => Err(Error::expected("a way to wrap: 10497, 33648 or 33071", other.to_string())),
    }
}

fn open(
    document: &Document,
    buffers: &[Cow<'_, [u8]>],
    index: usize,
    intake: &mut Intake,
    read: &mut ReadFile<'_>,
) -> Result<Loaded, document::Fault> {
    let (image, member) = (&document.images[index], format!("images[{index}]"));
    let place = intake.place(Position::Member(member.clone()));
    let content = match (&image.uri, image.buffer_view) {
        (Some(uri), _) => match buffer::of_uri(uri, intake.budget(), read) {
            Ok(content) => Cow::Owned(content),
            Err(error @ Error::Unreadable { .. }) => {
                intake.ignore(place, format!("a texture is not used, {error}: factors hold all over the face"));
                return Ok(None);
            }
            Err(error) => return Err((member, error)),
        },
        (None, Some(view)) => Cow::Borrowed(buffer::view(document, buffers, view)?),
        (None, None) => return Err((member, Error::expected("a `uri` or a `bufferView`", "none"))),
    };
    if !texture::image::is_png(&content) {
        let format = texture::image::format_of(&content);
        intake.ignore(place, format!("a texture is {format} and would have to be a PNG: factors hold all over the face"));
        return Ok(None);
    }
    let (texture, transparent) = texture::image::decode(&content, &member, intake.budget()).map_err(|error| (member, error))?;
    if transparent {
        intake.ignore(place, "transparency is not used: every face is opaque".to_owned());
    }
    Ok(Some(Arc::new(texture)))
}
