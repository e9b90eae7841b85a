//! glTF as exporters write it, and every kind of wrong file.

use serde_json::{Value, json};

use super::*;
use crate::reading::Degenerate;
use crate::texture::Quantity;

/// Bytes of a square of side 1 in z = 0 and of its two triangles, counter-clockwise from above: 4 positions, 6 short indices.
fn square() -> Vec<u8> {
    let positions = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let indices = [0_u16, 1, 2, 0, 2, 3];
    positions.iter().flatten().flat_map(|c| c.to_le_bytes()).chain(indices.iter().flat_map(|i| i.to_le_bytes())).collect()
}

/// A document with that square as one mesh under one node; its buffer is `square.bin`.
fn document() -> Value {
    json!({
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "floor", "mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 7}, "indices": 1, "material": 0}]}],
        "materials": [{"name": "white", "pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.7, 0.6, 1.0]}}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}
        ],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
        "buffers": [{"uri": "square.bin", "byteLength": 60}]
    })
}

/// The document with the value at a JSON pointer replaced, or added to its object.
fn with(pointer: &str, value: Value) -> Value {
    let mut document = document();
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    match document.pointer_mut(parent).unwrap() {
        Value::Object(object) => drop(object.insert(key.to_owned(), value)),
        Value::Array(array) => array[key.parse::<usize>().unwrap()] = value,
        _ => panic!("{parent}"),
    }
    document
}

fn scene(document: &Value) -> Result<Scene, Error> {
    parse(document.to_string().as_bytes(), Path::new("a.gltf"), Degenerate::Refuse, |name| match name.to_str() {
        Some("square.bin") => Ok(square()),
        _ => Err(io::Error::new(io::ErrorKind::NotFound, "no such file")),
    })
}

fn message(pointer: &str, value: Value) -> String {
    scene(&with(pointer, value)).unwrap_err().to_string()
}

fn glb(document: &Value) -> Vec<u8> {
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let chunk = |kind: &[u8], data: &[u8]| [&u32::try_from(data.len()).unwrap().to_le_bytes(), kind, data].concat();
    let chunks = [chunk(b"JSON", &json), chunk(b"BIN\0", &square())].concat();
    let length = u32::try_from(12 + chunks.len()).unwrap();
    [b"glTF", &2_u32.to_le_bytes()[..], &length.to_le_bytes(), &chunks].concat()
}

#[test]
fn triangles_have_their_front_material_name_and_place() {
    let read = scene(&document()).unwrap();
    assert_eq!((read.faces().len(), read.surfaces()[0].name(), read.area_of(0)), (2, "floor", 1.0));
    assert!(read.polygons().all(|polygon| polygon.normal() == DVec3::Z));
    let face = &read.faces()[1];
    assert_eq!(read.materials()[face.material()].reflectance(), [0.8, 0.7, 0.6]);
    assert_eq!(face.place().unwrap().to_string(), "a.gltf: meshes[0].primitives[0], triangle 1");
    assert!(read.notes().is_empty());
}

#[test]
fn a_buffer_may_be_in_the_file_in_a_uri_or_beside_it() {
    let beside = scene(&document()).unwrap();
    let data = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAAAAAAAAAAgD8AAAAAAAABAAIAAAACAAMA";
    let in_uri = scene(&with("/buffers/0/uri", json!(format!("data:application/octet-stream;base64,{data}")))).unwrap();
    let binary = with("/buffers/0", json!({"byteLength": 60}));
    let none = |_: &Path| -> io::Result<Vec<u8>> { panic!("no other file") };
    let inside = parse(&glb(&binary), Path::new("a.glb"), Degenerate::Refuse, none).unwrap();
    for other in [in_uri, inside] {
        assert_eq!(beside.polygons().collect::<Vec<_>>(), other.polygons().collect::<Vec<_>>());
    }
}

#[test]
fn nodes_are_placed_by_their_transformations_in_double_precision() {
    let half = 0.5_f64.sqrt();
    let nodes = json!([
        {"children": [1], "translation": [0.1, 0.0, 0.0], "scale": [2.0, 2.0, 2.0]},
        {"mesh": 0, "rotation": [half, 0.0, 0.0, half]},
        {"mesh": 0, "matrix": [0.0, 0.0, 3.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.25, 1.0]}
    ]);
    let mut document = with("/nodes", nodes);
    document["scenes"] = json!([{"nodes": [0, 2]}]);
    let read = scene(&document).unwrap();
    assert_eq!(read.surfaces().iter().map(|s| s.name()).collect::<Vec<_>>(), ["node 1", "node 2"]);
    let first = read.faces()[0].polygon();
    // Turned by a right angle about x, twice as large, and moved by the double 0.1.
    assert!((first.normal() - DVec3::NEG_Y).length() < 1e-15 && first.vertices()[0].x == 0.1);
    assert!((read.area_of(0) - 4.0).abs() < 1e-14);
    // Columns z*3, x, y: the square is in the plane of z and x, and raised by a quarter.
    let second = read.faces()[2].polygon();
    assert_eq!((second.vertices()[1], second.normal(), read.area_of(1)), (DVec3::new(0.0, 0.0, 3.25), DVec3::Y, 3.0));
}

#[test]
fn a_mirroring_node_keeps_the_front_in_front() {
    let read = scene(&with("/nodes/0/scale", json!([-1.0, 1.0, 1.0]))).unwrap();
    assert!(read.polygons().all(|polygon| polygon.normal() == DVec3::Z && polygon.vertices().iter().all(|v| v.x <= 0.0)));
}

#[test]
fn a_double_sided_material_gives_every_triangle_a_twin() {
    let read = scene(&with("/materials/0/doubleSided", json!(true))).unwrap();
    let normals: Vec<DVec3> = read.polygons().map(|polygon| polygon.normal()).collect();
    assert_eq!(normals, [DVec3::Z, DVec3::NEG_Z, DVec3::Z, DVec3::NEG_Z]);
}

#[test]
fn emission_is_the_factor_times_the_strength() {
    let mut document = with("/materials/0/emissiveFactor", json!([1.0, 0.5, 0.25]));
    assert_eq!(scene(&document).unwrap().materials()[0].radiance(), [1.0, 0.5, 0.25]);
    document["materials"][0]["extensions"] = json!({"KHR_materials_emissive_strength": {"emissiveStrength": 12.0}});
    document["extensionsUsed"] = json!(["KHR_materials_emissive_strength"]);
    document["extensionsRequired"] = json!(["KHR_materials_emissive_strength"]);
    let read = scene(&document).unwrap();
    assert_eq!((read.materials()[0].radiance(), read.notes().len()), (&[12.0, 6.0, 3.0][..], 0));
    let white = scene(&with("/meshes/0/primitives/0", json!({"attributes": {"POSITION": 0}, "mode": 6}))).unwrap();
    assert_eq!(white.materials()[white.faces()[0].material()].reflectance(), [1.0; 3], "the material of the format");
}

#[test]
fn strips_and_fans_are_the_triangles_of_the_format() {
    assert_eq!(triangles(5, &[0, 1, 2, 3, 3, 4, 5]).unwrap().unwrap(), [[0, 1, 2], [2, 1, 3], [3, 4, 5]]);
    assert_eq!(triangles(6, &[7, 1, 2, 3]).unwrap().unwrap(), [[1, 2, 7], [2, 3, 7]]);
    assert_eq!(triangles(6, &[]).unwrap().unwrap(), [[0; 3]; 0]);
    assert_eq!(triangles(1, &[0, 1]), Ok(None));
    let points = scene(&with("/meshes/0/primitives/0/mode", json!(0))).unwrap_err().to_string();
    assert_eq!(points, "a.gltf: expected at least one face, found none");
}

#[test]
fn what_is_not_used_is_noted_once() {
    let mut document = document();
    let texture = json!({"index": 0});
    document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = texture.clone();
    document["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!([1, 1, 1, 0.5]);
    document["materials"][0]["alphaMode"] = json!("BLEND");
    document["materials"].as_array_mut().unwrap().push(json!({"emissiveTexture": texture}));
    document["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    document["textures"] = json!([{"source": 0}]);
    document["images"] = json!([{"uri": "wood.png"}]);
    document["nodes"][0]["skin"] = json!(0);
    let notes: Vec<String> = scene(&document).unwrap().notes().iter().map(ToString::to_string).collect();
    assert_eq!(
        notes,
        [
            "a.gltf: extensionsUsed: extension `KHR_lights_punctual` is not used",
            "a.gltf: skins: skins are not used: meshes keep the shape in which they are stored",
            "a.gltf: materials[0]: transparency is not used: every face is opaque",
            "a.gltf: images[0]: a texture is not used, `wood.png` cannot be read: no such file: factors hold all over the face",
        ]
    );
}

#[test]
fn wrong_members_are_named_with_what_was_expected() {
    let nan = [f32::NAN.to_le_bytes().to_vec(), vec![0; 44], square()[48..].to_vec()].concat();
    let error = parse(document().to_string().as_bytes(), Path::new("a.gltf"), Degenerate::Refuse, |_| Ok(nan.clone()));
    assert_eq!(
        error.unwrap_err().to_string(),
        "a.gltf: meshes[0].primitives[0], triangle 0: expected finite positions, found [NaN, 0, 0] at index 0, [NaN, NaN, NaN] in the world"
    );
    for (pointer, value, expected) in [
        (
            "/asset/version",
            json!("1.0"),
            "asset.version: expected glTF 2.0, the only version that is read, found glTF 1.0: convert",
        ),
        (
            "/extensionsRequired",
            json!(["KHR_draco_mesh_compression"]),
            "extensionsRequired: the extension `KHR_draco_mesh_compression`",
        ),
        ("/scene", json!(3), "scene: expected an index below 1 (scene), found 3"),
        ("/scenes/0/nodes", json!([4]), "nodes: expected an index below 1 (node), found 4"),
        ("/nodes/0/children", json!([0]), "nodes[0]: expected a node with one parent, found one that is reached twice"),
        ("/nodes/0/rotation", json!([0, 0, 0, 0]), "nodes[0]: expected an affine transformation"),
        ("/nodes/0/matrix", json!([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]), "nodes[0]: expected an affine"),
        ("/nodes/0/mesh", json!(1), "nodes[0].mesh: expected an index below 1 (mesh), found 1"),
        ("/meshes/0/primitives/0/material", json!(1), "meshes[0].primitives[0]: expected an index below 1 (material), found 1"),
        ("/meshes/0/primitives/0/mode", json!(9), "meshes[0].primitives[0]: expected a mode from 0 to 6, found 9"),
        ("/meshes/0/primitives/0/indices", json!(5), "accessors[5]: expected an index below 2 (accessor)"),
        ("/accessors/1/count", json!(5), "meshes[0].primitives[0]: expected three indices a triangle, found 5 indices"),
        ("/accessors/0/count", json!(3), "accessors[1]: expected an index below 3 (vertex), found 3"),
        ("/accessors/0/count", json!(5), "accessors[0]: expected elements within the 48 bytes of the buffer view"),
        ("/accessors/0/count", json!(u64::MAX / 2), "accessors[0]: expected elements within the 48 bytes"),
        ("/accessors/0/byteOffset", json!(4), "accessors[0]: expected elements within"),
        (
            "/accessors/0/componentType",
            json!(5120),
            "accessors[0]: expected VEC3 of component type 5126, found `VEC3` of component type 5120",
        ),
        (
            "/accessors/0/type",
            json!("VEC\u{8}"),
            "accessors[0]: expected VEC3 of component type 5126, found `VEC\\u{8}` of component type 5126",
        ),
        ("/accessors/0/sparse", json!({}), "accessors[0]: a sparse accessor cannot be represented"),
        ("/bufferViews/0/byteStride", json!(8), "accessors[0]: expected elements within"),
        (
            "/bufferViews/0/byteLength",
            json!(480),
            "bufferViews[0]: expected bytes within the 60 of the buffer, found 480 bytes from 0",
        ),
        ("/bufferViews/0/buffer", json!(1), "bufferViews[0]: expected an index below 1 (buffer), found 1"),
        ("/buffers/0/byteLength", json!(61), "buffers[0]: expected 61 bytes, found 60 bytes"),
        ("/buffers/0/uri", json!("none.bin"), "buffers[0]: `none.bin` cannot be read: no such file"),
        ("/buffers/0/uri", json!("data:,x"), "buffers[0]: expected `;base64,` in a data URI"),
        ("/buffers/0/uri", json!(null), "buffers[0]: expected a `uri`, found none"),
        ("/materials/0/emissiveFactor", json!([0, -1, 0]), "materials[0]: material `white`: radiance is -1 in channel `g`"),
    ] {
        let message = message(pointer, value);
        assert!(message.starts_with(&format!("a.gltf: {expected}")), "{pointer}: {message}");
    }
}

#[test]
fn a_triangle_without_area_is_named_with_its_place() {
    let message = scene(&with("/nodes/0/scale", json!([1.0, 0.0, 1.0]))).unwrap_err().to_string();
    assert!(
        message.starts_with("a.gltf: meshes[0].primitives[0], triangle 0: expected at least one face, found none: "),
        "{message}"
    );
}

#[test]
fn a_binary_file_cut_off_anywhere_is_refused() {
    let whole = glb(&with("/buffers/0", json!({"byteLength": 60})));
    let read = |content: &[u8]| parse(content, Path::new("a.glb"), Degenerate::Refuse, |_| Ok(Vec::new()));
    assert!(read(&whole).is_ok());
    for length in 0..whole.len() {
        assert!(read(&whole[..length]).unwrap_err().to_string().starts_with("a.glb"), "{length}");
    }
    let mut wrong = whole.clone();
    wrong[4] = 1;
    assert_eq!(
        read(&wrong).unwrap_err().to_string(),
        "a.glb: expected glTF 2.0, the only version that is read, found glTF 1: convert the file, for example with gltf-pipeline or by \
         saving it from Blender"
    );
}

#[test]
fn gltf_1_is_named_whatever_else_breaks_the_format() {
    for version in ["\"1.0\"", "\"1.0.1\"", "0.8"] {
        let text = format!(r#"{{"asset":{{"version":{version}}},"scene":"s","scenes":{{"s":{{}}}},"nodes":{{}},"meshes":{{}}}}"#);
        let error = parse(text.as_bytes(), Path::new("a.gltf"), Degenerate::Refuse, |_| Ok(Vec::new())).unwrap_err().to_string();
        let version = version.trim_matches('"');
        let named =
            format!("a.gltf: asset.version: expected glTF 2.0, the only version that is read, found glTF {version}: convert");
        assert!(error.starts_with(&named), "{error}");
    }
}

#[test]
fn what_no_triangle_needs_is_noted() {
    let mut document = document();
    document["materials"].as_array_mut().unwrap().push(json!({"emissiveFactor": [-1, 0, 0]}));
    document["meshes"][0]["name"] = json!("Fu\u{1}");
    let text: Vec<u8> = document.to_string().replace("\\u0001", "\u{1}").bytes().map(|b| if b == 1 { 0xdf } else { b }).collect();
    let read = |text: &[u8], materials| {
        let reading = Reading { materials, ..Reading::default() };
        let notes = parse(text, Path::new("a.gltf"), reading, |_| Ok(square())).unwrap();
        notes.notes().iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    let notes = read(&text, crate::Materials::Required);
    assert_eq!(notes[0], "a.gltf:1: the text is no UTF-8 (byte 0xdf): read as Latin-1");
    let negative =
        "a.gltf: materials[1]: material `material 1`: radiance is -1 in channel `r`: it must be finite and not negative";
    assert!(notes[1].starts_with(negative) && notes[1].ends_with(": no triangle has the material"), "{}", notes[1]);
    // The square's own material: black, where nobody asks.
    let wrong = with("/materials/0/emissiveFactor", json!([0, -1, 0])).to_string();
    assert!(read(wrong.as_bytes(), crate::Materials::Optional)[0].ends_with(": taken as black"));
}

#[test]
fn positions_are_as_exact_as_single_precision_and_the_transformation() {
    let rounding = |document: &Value| {
        let content = document.to_string();
        let mut read = [0.0; 2];
        for (read, scale) in read.iter_mut().zip([1.0_f32, 0.3]) {
            let bytes: Vec<u8> = square()[..48]
                .chunks(4)
                .flat_map(|b| (scale * f32::from_le_bytes([b[0], b[1], b[2], b[3]])).to_le_bytes())
                .collect();
            let bytes = [bytes, square()[48..].to_vec()].concat();
            let reading = Reading::default();
            let budget = Budget::new(reading.budget);
            let intake = Intake::new(Scene::new(["r", "g", "b"]).unwrap(), Path::new("a.gltf"), reading, &budget);
            *read = parse_within(content.as_bytes(), intake, &mut |_| Ok(bytes.clone())).unwrap().written().rounding();
        }
        read.map(|q| q * f64::from(1 << 24))
    };
    let near = |[a, b]: [f64; 2], [c, d]: [f64; 2]| assert!((a - c).abs() + (b - d).abs() < 1e-6, "{a} {b}");
    near(rounding(&document()), [0.0, 0.3]);
    near(rounding(&with("/nodes/0/scale", json!([2.0, 5.0, 1.0]))), [0.0, 1.5]);
    near(rounding(&with("/nodes/0/translation", json!([10.100000381469727, 0.0, 0.0]))), [11.1, 10.7]);
}

#[test]
fn json_that_is_wrong_is_named_with_its_line() {
    let error = parse(b"{\n\"asset\": {},\n}", Path::new("a.gltf"), Degenerate::Refuse, |_| Ok(Vec::new())).unwrap_err();
    assert_eq!(error.to_string(), "a.gltf:2: column 11: missing field `version`");
}

/// The square with texture coordinates, one whole texture over it, and an image of 2 x 2 linear greys: 0 and 1 above, 2/3 and 1/3
/// below. In glTF v = 0 is the highest row.
fn textured(change: impl FnOnce(&mut Value)) -> Result<Scene, Error> {
    let coordinates = [[0.0_f32, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
    let mut image = Vec::new();
    let mut encoder = png::Encoder::new(&mut image, 2, 2);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_gamma(png::ScaledFloat::from_scaled(100_000));
    encoder.write_header().unwrap().write_image_data(&[0, 255, 170, 85]).unwrap();
    let bytes: Vec<u8> = [square(), coordinates.iter().flatten().flat_map(|c| c.to_le_bytes()).collect(), image.clone()].concat();
    let mut document = document();
    document["buffers"][0]["byteLength"] = json!(bytes.len());
    let views = document["bufferViews"].as_array_mut().unwrap();
    views.push(json!({"buffer": 0, "byteOffset": 60, "byteLength": 32}));
    views.push(json!({"buffer": 0, "byteOffset": 92, "byteLength": image.len()}));
    let accessor = json!({"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"});
    document["accessors"].as_array_mut().unwrap().push(accessor);
    document["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(2);
    document["images"] = json!([{"bufferView": 3, "mimeType": "image/png"}]);
    document["textures"] = json!([{"source": 0, "sampler": 0}]);
    document["samplers"] = json!([{"wrapS": 33071, "wrapT": 10497}]);
    document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": 0});
    change(&mut document);
    parse(document.to_string().as_bytes(), Path::new("a.gltf"), Degenerate::Refuse, |name| match name.to_str() {
        Some("square.bin") => Ok(bytes.clone()),
        _ => Err(io::Error::new(io::ErrorKind::NotFound, "no such file")),
    })
}

#[test]
fn textures_lie_as_coordinates_samplers_and_transformations_say() {
    let read = textured(|_| ()).unwrap();
    assert!(read.notes().is_empty(), "{:?}", read.notes());
    // Face 0 is the triangle below the diagonal.
    let relative =
        |read: &Scene, face: usize, x: f64, y: f64| read.value_at(face, Quantity::Reflectance, DVec3::new(x, y, 0.0))[0] / 0.8;
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
    near(relative(&read, 0, 0.3, 0.1), 170.0 / 255.0);
    near(relative(&read, 0, 0.9, 0.1), 85.0 / 255.0);
    near(relative(&read, 1, 0.7, 0.9), 1.0);
    let turned = textured(|document| {
        let transform = json!({"offset": [0.0, 1.0], "rotation": std::f64::consts::FRAC_PI_2, "scale": [1.0, 1.0]});
        document["materials"][0]["emissiveFactor"] = json!([1, 1, 1]);
        document["materials"][0]["emissiveTexture"] = json!({"index": 0, "extensions": {"KHR_texture_transform": transform}});
        document["extensionsRequired"] = json!(["KHR_texture_transform"]);
    });
    // (u, v) = (0.9, 0.9) becomes (v, 1 - u): the upper row, on the right.
    near(turned.unwrap().value_at(0, Quantity::Radiance, DVec3::new(0.9, 0.1, 0.0))[0], 1.0);
    let error = |pointer: &str, value: Value| {
        textured(|document| *document.pointer_mut(pointer).unwrap() = value).unwrap_err().to_string()
    };
    assert_eq!(error("/textures/0/source", json!(3)), "a.gltf: textures[0]: expected an index below 1 (image), found 3");
    let wrap = error("/samplers/0/wrapS", json!(1));
    assert_eq!(wrap, "a.gltf: textures[0]: expected a way to wrap: 10497, 33648 or 33071, found 1");
    let count = error("/accessors/2/count", json!(3));
    assert_eq!(count, "a.gltf: meshes[0].primitives[0]: expected texture coordinates of all positions, found 3 of 4 positions");
}
