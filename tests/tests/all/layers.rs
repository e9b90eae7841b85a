//! A crate is a tower: a module imports from its own floor and from those below, so that one reads it from the ground up.
//!
//! An import is a `use` line, or a path in code that starts at `crate`, `super`, a child module or an imported module. Comments,
//! the inline module `tests` and lines under `#[cfg(test)]` or `#[cfg(doc)]` do not count: they are not built.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// A crate with its floors, the lowest first.
struct Tower {
    sources: &'static str,
    /// The modules of each floor, by the first name of their path. Those of one floor may import each other.
    floors: &'static [&'static [&'static str]],
    /// Imports that run upward, with the reason: from, to, why.
    upward: &'static [(&'static str, &'static str, &'static str)],
    /// How many of those there may be.
    most_upward: usize,
}

/// To add a crate, add its entry here.
const TOWERS: &[Tower] = &[
    Tower {
        sources: "../crates/numbers/src",
        floors: &[
            &["effort"],
            &["arithmetic", "power", "radius"],
            &["double_double"],
            &["exact", "series"],
            &["arc_tangent", "logarithm"],
            &["double_double_on_lanes"],
            &["number"],
            &["dilogarithm"],
            &["real"],
            &["ball", "vec3"],
            &["offset", "big"],
            &["lanes"],
            &["near_ties"],
            &["lib"],
        ],
        upward: &[],
        most_upward: 0,
    },
    Tower {
        sources: "../crates/core/src",
        floors: &[
            &["error"],
            &["problem"],
            &["boundary"],
            &["forms"],
            &["gauss"],
            &["ladder"],
            &["derivatives", "evaluate", "hessian"],
            &["batch", "closed_forms"],
            &["lib"],
        ],
        upward: &[],
        most_upward: 0,
    },
    Tower {
        sources: "../crates/scene/src",
        floors: &[
            &["digest", "extremes", "messages", "output", "placement", "warning"],
            &["place", "precision", "projection"],
            &["error"],
            &["host", "reading", "words"],
            &["occluders", "texture"],
            &["scene"],
            &["gltf", "obj", "ply", "stl", "view3d"],
            &["read"],
            &["factors"],
            &["heat"],
            &["case"],
            &["lib"],
        ],
        upward: &[],
        most_upward: 0,
    },
    Tower {
        sources: "../crates/solver/src",
        floors: &[
            &["error", "clock", "bytes", "once"],
            &["mesh"],
            &["field"],
            &["links"],
            &["gathering"],
            &["system"],
            &["estimate"],
            &["solve"],
            &["picture", "parts"],
            &["lib"],
        ],
        upward: &[],
        most_upward: 0,
    },
    Tower {
        sources: "../crates/audit/src",
        floors: &[&["cases"], &["measures"], &["bounds"], &["scenes"], &["gates"], &["checks"], &["comparison"], &["lib"]],
        upward: &[],
        most_upward: 0,
    },
    Tower {
        sources: "../xtask/src",
        floors: &[
            &["files", "plot", "summary"],
            &["record", "request"],
            &["bench", "bounds", "figures", "instructions", "mesh", "mutants", "prove", "scenes"],
            &["replay", "report", "verify"],
            &["lib"],
        ],
        upward: &[],
        most_upward: 0,
    },
];

/// Most files of which each imports the others, directly or through others.
const MOST_IN_A_CIRCLE: usize = 2;

/// Sources by the path of their module, `ladder/rungs`.
type Sources = BTreeMap<String, String>;

/// Which files each file imports from.
type Imports = BTreeMap<String, BTreeSet<String>>;

#[test]
fn imports_run_downward() {
    for tower in TOWERS {
        assert!(tower.upward.len() <= tower.most_upward, "{}: {} imports upward are listed", tower.sources, tower.upward.len());
        let upward_imports = upward(&imports(&read(Path::new(tower.sources))), tower.floors);
        let listed = |(from, to): &(String, String)| tower.upward.iter().any(|(f, t, _)| f == from && t == to);
        let new: Vec<_> = upward_imports.iter().filter(|import| !listed(import)).collect();
        assert!(new.is_empty(), "{}: these import from a floor above: {new:?}", tower.sources);
        let is_gone = |(from, to): (&str, &str)| !upward_imports.iter().any(|(f, t)| f == from && t == to);
        let gone: Vec<_> = tower.upward.iter().filter(|(from, to, _)| is_gone((from, to))).collect();
        assert!(gone.is_empty(), "{}: these are listed and do not occur: {gone:?}", tower.sources);
    }
}

#[test]
fn no_circle_of_imports_is_large() {
    for tower in TOWERS {
        let circles = circles(&imports(&read(Path::new(tower.sources))));
        let large: Vec<_> = circles.iter().filter(|circle| circle.len() > MOST_IN_A_CIRCLE).collect();
        assert!(large.is_empty(), "{}: files that import each other: {large:?}", tower.sources);
    }
}

#[test]
fn every_way_to_import_is_seen() {
    let sources = |files: &[(&str, &str)]| files.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned())).collect();
    let imported = imports(&sources(&[
        ("low", "mod part;\nuse crate::{high::{self as h, deep::Thing}, Name};\nfn f() { h::other::g(); part::g() }"),
        (
            "low/part",
            "// crate::high\n#[cfg(doc)]\nuse crate::high;\nstruct S(super::T, \"crate::high // \\\"\", '\"');\npub(in crate::high) fn f() {}",
        ),
        ("high", "#[cfg(test)]\nmod tests {\n    use crate::low;\n}"),
        ("high/deep", ""),
        ("high/other", ""),
        ("model", "fn assert_used() -> impl Copy + use<> { crate::high::f() }\nuse super::low;"),
        ("lib", "mod low; mod high;"),
    ]));
    let names = |name: &str| imported[name].iter().map(String::as_str).collect::<Vec<_>>();
    assert_eq!(names("low"), ["high", "high/deep", "high/other", "lib", "low/part"]);
    assert_eq!(names("low/part"), ["low"]);
    assert!(imported["high"].is_empty());
    assert_eq!(names("model"), ["high", "low"]);
    let up = upward(&imported, &[&["low"], &["high", "model"], &["lib"]]);
    assert_eq!(up.len(), 4, "{up:?}");
    assert!(up.contains(&("low".to_owned(), "high/deep".to_owned())));
    let ring =
        sources(&[("a", "use crate::b::B;"), ("b", "use crate::c::C;"), ("c", "use crate::a::A; use crate::d::D;"), ("d", "")]);
    assert_eq!(circles(&imports(&ring)).iter().map(Vec::len).max(), Some(3));
}

fn read(root: &Path) -> Sources {
    let mut sources = Sources::new();
    let mut folders = vec![root.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let name = path.strip_prefix(root).unwrap().with_extension("");
                let name = name.to_str().unwrap().replace('\\', "/");
                // The root of a program has the name of one of a library here. Tests are not built.
                let name = if name == "main" { "lib".to_owned() } else { name };
                if !name.ends_with("/tests") {
                    sources.insert(name, fs::read_to_string(&path).unwrap());
                }
            }
        }
    }
    assert!(sources.contains_key("lib"), "no crate at {}", root.display());
    sources
}

/// The imports that run from a floor to one above. The root imports from all.
fn upward(imports: &Imports, floors: &[&[&str]]) -> Vec<(String, String)> {
    let floor = |file: &str| {
        let room = file.split('/').next().unwrap_or(file);
        let place = floors.iter().position(|floor| floor.contains(&room));
        place.unwrap_or_else(|| panic!("{file} is on no floor: add {room} to the table"))
    };
    let edges = imports.iter().flat_map(|(from, to)| to.iter().map(move |to| (from.clone(), to.clone())));
    edges.filter(|(from, to)| floor(to) > floor(from)).collect()
}

/// The sets of at least two files that reach each other.
fn circles(imports: &Imports) -> Vec<Vec<String>> {
    let reached = |from: &str| {
        let (mut reached, mut open) = (BTreeSet::new(), vec![from.to_owned()]);
        while let Some(file) = open.pop() {
            let next = imports.get(&file).into_iter().flatten();
            open.extend(next.filter(|to| reached.insert((*to).clone())).cloned());
        }
        reached
    };
    let reach: BTreeMap<&String, BTreeSet<String>> = imports.keys().map(|file| (file, reached(file))).collect();
    let circle = |file: &String| -> Vec<String> {
        reach[file].iter().filter(|other| reach.get(other).is_some_and(|back| back.contains(file))).cloned().collect()
    };
    let components: BTreeSet<Vec<String>> = imports.keys().map(circle).filter(|circle| circle.len() > 1).collect();
    components.into_iter().collect()
}

fn imports(sources: &Sources) -> Imports {
    sources.iter().map(|(file, text)| (file.clone(), imports_of(file, text, sources))).collect()
}

fn imports_of(file: &str, text: &str, sources: &Sources) -> BTreeSet<String> {
    let module: Vec<String> = if file == "lib" { Vec::new() } else { file.split('/').map(str::to_owned).collect() };
    let tokens = tokens(&built(text));
    let (mut paths, mut scope) = (Vec::new(), BTreeMap::new());
    let mut i = 0;
    while i < tokens.len() {
        match tokens[i].as_str() {
            "mod" if tokens.get(i + 2).is_some_and(|t| t == ";") => {
                scope.insert(tokens[i + 1].clone(), [module.clone(), vec![tokens[i + 1].clone()]].concat());
                i += 3;
            }
            // Not the lifetimes that a type uses.
            "use" if tokens.get(i + 1).is_some_and(|t| t != "<") => {
                let mut used = Vec::new();
                i = tree(&tokens, i + 1, &[], &mut used);
                for (path, name) in used {
                    if let Some(absolute) = absolute(&path, &module, &scope) {
                        scope.insert(name, absolute);
                    }
                    paths.push(path);
                }
            }
            // A visibility.
            "in" if i > 0 && tokens[i - 1] == "(" => {
                let mut path = Vec::new();
                i = segments(&tokens, i + 1, &mut path);
            }
            _ => {
                let mut path = Vec::new();
                i = segments(&tokens, i, &mut path).max(i + 1);
                if path.len() > 1 {
                    paths.push(path);
                }
            }
        }
    }
    let targets = paths.iter().filter_map(|path| absolute(path, &module, &scope)).map(|path| target(&path, sources));
    targets.filter(|to| to != file && file != "lib").collect()
}

/// The file that a path leads to: the longest part of it that is one, or the root.
fn target(path: &[String], sources: &Sources) -> String {
    let files = (1..=path.len()).rev().map(|length| path[..length].join("/"));
    files.into_iter().find(|file| sources.contains_key(file)).unwrap_or_else(|| "lib".to_owned())
}

/// A path from the root of the crate; `None` for one into another crate or a type.
fn absolute(path: &[String], module: &[String], scope: &BTreeMap<String, Vec<String>>) -> Option<Vec<String>> {
    let (first, tail) = path.split_first()?;
    match first.as_str() {
        "crate" => Some(tail.to_vec()),
        "self" => Some([module, tail].concat()),
        "super" => {
            let ups = path.iter().take_while(|name| *name == "super").count();
            Some([&module[..module.len().checked_sub(ups)?], &path[ups..]].concat())
        }
        name => scope.get(name).map(|from| [from.as_slice(), tail].concat()),
    }
}

/// `a::b::c` from a token on; returns the place behind it.
fn segments(tokens: &[String], mut i: usize, path: &mut Vec<String>) -> usize {
    while tokens.get(i).is_some_and(|t| is_name(t)) {
        path.push(tokens[i].clone());
        if tokens.get(i + 1).is_none_or(|t| t != "::") || tokens.get(i + 2).is_none_or(|t| !is_name(t) && t != "{") {
            return i + 1;
        }
        i += 2;
    }
    i
}

/// The paths of a `use`, each with the name it brings into scope; returns the place behind it.
fn tree(tokens: &[String], i: usize, prefix: &[String], used: &mut Vec<(Vec<String>, String)>) -> usize {
    let mut path = prefix.to_vec();
    let mut i = segments(tokens, i, &mut path);
    if tokens[i] == "{" {
        i += 1;
        while tokens[i] != "}" {
            i = tree(tokens, i, &path, used);
            i += usize::from(tokens[i] == ",");
        }
        return i + 1;
    }
    if path.last().is_some_and(|name| name == "self") && path.len() > 1 {
        path.pop();
    }
    let mut name = path.last().cloned().unwrap_or_default();
    while ![",", "}", ";"].contains(&tokens[i].as_str()) {
        name.clone_from(&tokens[i]);
        i += 1;
    }
    used.push((path, name));
    i
}

fn is_name(token: &str) -> bool {
    token.starts_with(|c: char| c.is_alphabetic() || c == '_') && !["use", "mod", "as"].contains(&token)
}

/// The source without comments, strings, the module `tests` and lines under `#[cfg(test)]` or `#[cfg(doc)]`.
fn built(text: &str) -> String {
    let (text, mut code, mut skip) = (without_strings(text), String::new(), false);
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        let is_left_out = ["#[cfg(test)]", "#[cfg(doc)]"].contains(&line.trim());
        if skip && line.trim_start().starts_with("mod ") && line.trim_end().ends_with('{') {
            let end = format!("{}}}", &line[..line.len() - line.trim_start().len()]);
            lines.by_ref().take_while(|line| *line != end).for_each(drop);
        } else if !skip && !is_left_out {
            code.push_str(line);
            code.push('\n');
        }
        skip = is_left_out;
    }
    code
}

/// The source without comments and without text in quotes. A quote may be escaped, or a character.
fn without_strings(text: &str) -> String {
    let (mut code, mut tail) = (String::new(), text);
    while let Some(start) = tail.find(['"', '\'', '/']) {
        code.push_str(&tail[..start]);
        tail = &tail[start..];
        let (end, stands_for) = if tail.starts_with("//") {
            (tail.find('\n').unwrap_or(tail.len()), "")
        } else if tail.starts_with("'\"'") {
            (3, " ")
        } else if let Some(quoted) = tail.strip_prefix('"') {
            let mut is_escaped = false;
            let closes = |c: char| {
                let closes = c == '"' && !is_escaped;
                is_escaped = c == '\\' && !is_escaped;
                closes
            };
            (1 + quoted.find(closes).map_or(quoted.len(), |end| end + 1), " ")
        } else {
            (1, &tail[..1])
        };
        code.push_str(stands_for);
        tail = &tail[end..];
    }
    code + tail
}

/// Names, `::` and single characters.
fn tokens(text: &str) -> Vec<String> {
    let mut tokens: Vec<String> = Vec::new();
    let mut joins = false;
    for c in text.chars() {
        let is_part = |c: char| c.is_alphanumeric() || c == '_';
        match tokens.last_mut() {
            Some(last) if joins && is_part(c) && last.starts_with(is_part) => last.push(c),
            Some(last) if joins && c == ':' && last == ":" => last.push(c),
            _ if c.is_whitespace() => {}
            _ => tokens.push(c.to_string()),
        }
        joins = !c.is_whitespace();
    }
    tokens
}
