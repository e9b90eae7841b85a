//! The part of a glTF document that is read, by the names of the format.

use std::collections::HashMap;

use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::error::Error;
use crate::messages::printable;

/// An error, with the member in which it is.
pub(super) type Fault = (String, Error);

/// The extension that lets materials emit more than 1.
pub(super) const EMISSIVE_STRENGTH: &str = "KHR_materials_emissive_strength";

/// The extension that moves and turns textures.
pub(super) const TEXTURE_TRANSFORM: &str = "KHR_texture_transform";

/// Extensions that are read.
pub(super) const USED: [&str; 2] = [EMISSIVE_STRENGTH, TEXTURE_TRANSFORM];

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", expecting = "a glTF document")]
pub(super) struct Document {
    pub(super) asset: Asset,
    pub(super) scene: Option<usize>,
    #[serde(default)]
    pub(super) scenes: Vec<Roots>,
    #[serde(default)]
    pub(super) nodes: Vec<Node>,
    #[serde(default)]
    pub(super) meshes: Vec<Mesh>,
    #[serde(default)]
    pub(super) materials: Vec<Material>,
    #[serde(default)]
    pub(super) textures: Vec<Texture>,
    #[serde(default)]
    pub(super) images: Vec<Image>,
    #[serde(default)]
    pub(super) samplers: Vec<Sampler>,
    #[serde(default)]
    pub(super) accessors: Vec<Accessor>,
    #[serde(default)]
    pub(super) buffer_views: Vec<BufferView>,
    #[serde(default)]
    pub(super) buffers: Vec<Buffer>,
    #[serde(default)]
    pub(super) extensions_used: Vec<String>,
    #[serde(default)]
    pub(super) extensions_required: Vec<String>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Asset {
    version: String,
}

#[derive(Debug, Deserialize)]
pub(super) struct Roots {
    #[serde(default)]
    pub(super) nodes: Vec<usize>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Node {
    pub(super) name: Option<String>,
    pub(super) mesh: Option<usize>,
    pub(super) skin: Option<usize>,
    #[serde(default)]
    pub(super) children: Vec<usize>,
    /// By columns.
    pub(super) matrix: Option<[f64; 16]>,
    #[serde(default)]
    pub(super) translation: [f64; 3],
    /// A quaternion, the scalar last.
    #[serde(default = "no_rotation")]
    pub(super) rotation: [f64; 4],
    #[serde(default = "no_scale")]
    pub(super) scale: [f64; 3],
}

#[derive(Debug, Deserialize)]
pub(super) struct Mesh {
    pub(super) name: Option<String>,
    pub(super) primitives: Vec<Primitive>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Primitive {
    pub(super) attributes: Attributes,
    pub(super) indices: Option<usize>,
    pub(super) material: Option<usize>,
    #[serde(default = "triangles")]
    pub(super) mode: u64,
    #[serde(default)]
    pub(super) targets: Vec<IgnoredAny>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Attributes {
    #[serde(rename = "POSITION")]
    pub(super) position: Option<usize>,
    /// The others, `TEXCOORD_0` among them.
    #[serde(flatten)]
    pub(super) others: HashMap<String, usize>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Material {
    pub(super) name: Option<String>,
    pub(super) pbr_metallic_roughness: Option<MetallicRoughness>,
    #[serde(default)]
    pub(super) emissive_factor: [f64; 3],
    pub(super) emissive_texture: Option<TextureUse>,
    pub(super) alpha_mode: Option<String>,
    #[serde(default)]
    pub(super) double_sided: bool,
    #[serde(default)]
    pub(super) extensions: MaterialExtensions,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct MetallicRoughness {
    #[serde(default = "white")]
    pub(super) base_color_factor: [f64; 4],
    pub(super) base_color_texture: Option<TextureUse>,
}

/// A texture as a material uses it.
#[derive(Debug, Clone, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct TextureUse {
    pub(super) index: usize,
    #[serde(default)]
    pub(super) tex_coord: usize,
    #[serde(default)]
    pub(super) extensions: TextureExtensions,
}

#[derive(Debug, Clone, Default, Deserialize)]
pub(super) struct TextureExtensions {
    #[serde(rename = "KHR_texture_transform")]
    pub(super) transform: Option<Transform>,
}

/// `(u, v)` becomes offset + rotation scale `(u, v)`; the rotation turns from v to u, counter-clockwise as v points downwards. That
/// is how the extension's example, its implementations and its test model have it; its listing of a matrix turns the other way
/// (KhronosGroup/glTF, issue 1563).
#[derive(Debug, Clone, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Transform {
    #[serde(default)]
    pub(super) offset: [f64; 2],
    #[serde(default)]
    pub(super) rotation: f64,
    #[serde(default = "no_stretch")]
    pub(super) scale: [f64; 2],
    pub(super) tex_coord: Option<usize>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Texture {
    pub(super) sampler: Option<usize>,
    pub(super) source: Option<usize>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Image {
    pub(super) uri: Option<String>,
    pub(super) buffer_view: Option<usize>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Sampler {
    pub(super) wrap_s: Option<u64>,
    pub(super) wrap_t: Option<u64>,
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct MaterialExtensions {
    #[serde(rename = "KHR_materials_emissive_strength")]
    pub(super) emissive_strength: Option<EmissiveStrength>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct EmissiveStrength {
    #[serde(default = "one")]
    pub(super) emissive_strength: f64,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub(super) buffer_view: Option<usize>,
    #[serde(default)]
    pub(super) byte_offset: usize,
    pub(super) component_type: u64,
    #[serde(rename = "type")]
    pub(super) shape: String,
    pub(super) count: usize,
    pub(super) sparse: Option<IgnoredAny>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub(super) buffer: usize,
    #[serde(default)]
    pub(super) byte_offset: usize,
    pub(super) byte_length: usize,
    pub(super) byte_stride: Option<usize>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer {
    pub(super) uri: Option<String>,
    pub(super) byte_length: usize,
}

/// Bytes that a document takes in memory, at most: of each object the largest struct, of each entry of a list a number, in lists
/// that grow by doubling.
pub(super) fn memory_of(json: &[u8]) -> u64 {
    let count = |byte: u8| json.iter().filter(|&&b| b == byte).count();
    let largest = size_of::<Node>().max(size_of::<Material>()).max(size_of::<Accessor>()).max(size_of::<Primitive>());
    let bytes = |count: usize, size: usize| (count as u64).saturating_mul(2 * size as u64);
    bytes(count(b'{'), largest).saturating_add(bytes(count(b','), size_of::<String>()))
}

const fn no_rotation() -> [f64; 4] {
    [0.0, 0.0, 0.0, 1.0]
}

const fn no_scale() -> [f64; 3] {
    [1.0; 3]
}

const fn no_stretch() -> [f64; 2] {
    [1.0; 2]
}

const fn white() -> [f64; 4] {
    [1.0; 4]
}

const fn one() -> f64 {
    1.0
}

const fn triangles() -> u64 {
    4
}

impl Document {
    /// Whether this is a version, and asks for no extension, that is not read here; the error comes with its member.
    pub(super) fn check(&self) -> Result<(), Fault> {
        if self.asset.version.split('.').next() != Some("2") {
            return Err(("asset.version".to_owned(), other_version(&self.asset.version)));
        }
        match self.extensions_required.iter().find(|name| !USED.contains(&name.as_str())) {
            None => Ok(()),
            Some(name) => {
                let instead = "export without it";
                Err(("extensionsRequired".to_owned(), Error::Unsupported { what: format!("the extension `{name}`"), instead }))
            }
        }
    }
}

/// The error for a version of glTF that is not read.
pub(super) fn other_version(version: &str) -> Error {
    let remedy = "convert the file, for example with gltf-pipeline or by saving it from Blender";
    Error::expected("glTF 2.0, the only version that is read", format!("glTF {}: {remedy}", printable(version)))
}

/// The version of a document that may be of another one, where it is not 2: objects of glTF 1.0 have names where those of 2.0 have
/// numbers.
pub(super) fn version_other_than_2(json: &str) -> Option<String> {
    #[derive(Deserialize)]
    struct Version {
        asset: Option<AnyAsset>,
    }
    #[derive(Deserialize)]
    struct AnyAsset {
        version: Option<Number>,
    }
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Number {
        Text(String),
        Number(f64),
    }
    let Version { asset } = serde_json::from_str(json).ok()?;
    let version = match asset?.version? {
        Number::Text(version) => version,
        Number::Number(version) => format!("{version:?}"),
    };
    (version.split('.').next() != Some("2")).then_some(version)
}

/// An index that is too large.
pub(super) fn no_such(what: &str, index: usize, count: usize) -> Error {
    Error::expected(format!("an index below {count} ({what})"), index.to_string())
}
