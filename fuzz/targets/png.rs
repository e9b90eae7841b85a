//! Textures of an OBJ file's materials.
#![no_main]

#[allow(dead_code, reason = "each target uses a part")]
#[path = "../../crates/scene/tests/all/hostile/rules.rs"]
mod rules;

use std::path::Path;

libfuzzer_sys::fuzz_target!(|texture: &[u8]| {
    let scene = include_bytes!("../seeds/obj/room.obj");
    rules::judge(|reading| radgrad_scene::obj::parse(scene, Path::new("a.obj"), reading, rules::beside(rules::MTL.as_bytes(), texture)));
});
