//! OBJ files.
#![no_main]

#[allow(dead_code, reason = "each target uses a part")]
#[path = "../../crates/scene/tests/all/hostile/rules.rs"]
mod rules;

use std::path::Path;

libfuzzer_sys::fuzz_target!(|file: &[u8]| {
    rules::judge(|reading| radgrad_scene::obj::parse(file, Path::new("a.obj"), reading, rules::beside(rules::MTL.as_bytes(), &rules::png())));
});
