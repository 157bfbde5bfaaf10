//! The order of modules: imports go up one list only, and files of a module do not go round in circles.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Modules, lowest first; those of one floor do not import each other.
const FLOORS: [&[&str]; 22] = [
    &["nested", "sorting"],
    &["error", "stop"],
    &["scalar"],
    &[
        "autodiff", "input", "linalg", "memory", "numbers", "parallel", "special",
    ],
    &["cone", "least_squares", "minimize"],
    &["spatial"],
    &["joint"],
    &["model"],
    &["dynamics"],
    &["collision"],
    &["constraint"],
    &["contact"],
    &["sim"],
    &["linearize"],
    &["control"],
    &["trajopt"],
    &["identify"],
    &["io"],
    &["view"],
    &["codegen"],
    &["command"],
    &["bin"],
];

fn sources(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, out);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            out.push(path);
        }
    }
}

/// Code of a file, without comments and without tests, whose helpers may come from anywhere.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).expect("a source");
    let body = text.split("#[cfg(test)]\nmod tests").next().unwrap_or("");
    let lines = body
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"));
    lines.collect::<Vec<_>>().join("\n")
}

/// The names that follow `start` in a text, also from within braces: `super::a`, `super::{b::C, d}`.
fn names_after<'a>(text: &'a str, start: &str) -> BTreeSet<&'a str> {
    let word = |rest: &'a str| {
        rest.split(|c: char| !c.is_alphanumeric() && c != '_')
            .next()
    };
    let mut out = BTreeSet::new();
    for rest in text.split(start).skip(1) {
        match rest.strip_prefix('{') {
            None => out.extend(word(rest)),
            Some(list) => {
                let (mut depth, mut item_starts) = (0, true);
                for (at, c) in list.char_indices() {
                    match c {
                        '{' => depth += 1,
                        '}' if depth == 0 => break,
                        '}' => depth -= 1,
                        ',' if depth == 0 => item_starts = true,
                        c if item_starts && !c.is_whitespace() => {
                            out.extend(word(&list[at..]));
                            item_starts = false;
                        }
                        _ => {}
                    }
                }
            }
        }
    }
    out
}

/// The folders of sources of all packages of the workspace, the library first.
fn roots() -> Vec<PathBuf> {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    let crates = fs::read_dir(own.join("crates")).into_iter().flatten();
    let crates = crates.map(|entry| entry.expect("an entry").path());
    let folders = [own.to_owned()].into_iter().chain(crates);
    let folders = folders.chain([own.join("python")]);
    let sources = folders.map(|folder| folder.join("src"));
    sources.filter(|folder| folder.is_dir()).collect()
}

/// All files below a folder but those of tests, with their paths in it.
fn files(root: &Path) -> Vec<(PathBuf, String)> {
    let mut paths = Vec::new();
    sources(root, &mut paths);
    let below = |path: PathBuf| {
        let text = code(&path);
        (path.strip_prefix(root).expect("below").to_owned(), text)
    };
    let files = paths.into_iter().map(below);
    let files = files
        .filter(|(path, _)| !path.components().any(|part| part.as_os_str() == "tests"))
        .filter(|(path, _)| path.file_stem().is_none_or(|stem| stem != "tests"));
    without_prelude(files.collect())
}

/// Files that import what they use of a prelude from where the prelude has it, so that no circle hides behind it.
fn without_prelude(mut files: Vec<(PathBuf, String)>) -> Vec<(PathBuf, String)> {
    let is_prelude = |(path, _): &(PathBuf, String)| path == Path::new("prelude.rs");
    let Some(at) = files.iter().position(is_prelude) else {
        return files;
    };
    let (_, prelude) = files.swap_remove(at);
    let modules = names_after(&prelude, "crate::");
    let items: Vec<(&str, BTreeSet<&str>)> = modules
        .iter()
        .map(|module| {
            (
                *module,
                names_after(&prelude, &format!("crate::{module}::")),
            )
        })
        .collect();
    for (_, text) in &mut files {
        if !text.contains("crate::prelude::") {
            continue;
        }
        *text = text.replace("crate::prelude::", "");
        let words: BTreeSet<&str> = text
            .split(|c: char| !c.is_alphanumeric() && c != '_')
            .collect();
        let used = items.iter().filter(|(_, items)| !items.is_disjoint(&words));
        let imports: String = used
            .map(|(module, _)| format!("\nuse crate::{module}::_;"))
            .collect();
        text.push_str(&imports);
    }
    files
}

#[test]
fn imports_between_modules_go_up() {
    let floor = |module: &str| FLOORS.iter().position(|floor| floor.contains(&module));
    let mut against = Vec::new();
    for (path, text) in files(&roots()[0]) {
        let own = path.components().next().expect("a part").as_os_str();
        let own = own.to_string_lossy().replace(".rs", "");
        if ["lib", "guide"].contains(&&*own) {
            continue;
        }
        let own_floor = floor(&own).unwrap_or_else(|| panic!("src/{own} has no floor"));
        for module in names_after(&text, "crate::") {
            if module != own && floor(module).is_some_and(|floor| floor >= own_floor) {
                against.push(format!("{} imports {module}", path.display()));
            }
        }
    }
    assert!(
        against.is_empty(),
        "against the order:\n{}",
        against.join("\n")
    );
}

/// Files that can be reached from each, within one folder.
fn reached(imports: &BTreeMap<String, BTreeSet<String>>) -> BTreeMap<String, BTreeSet<String>> {
    let mut out = imports.clone();
    for via in imports.keys() {
        let further = out[via].clone();
        for to in out.values_mut().filter(|to| to.contains(via)) {
            to.extend(further.iter().cloned());
        }
    }
    out
}

/// Imports of the files and folders in a folder from each other.
fn imports_in(folder: &Path, files: &[(PathBuf, String)]) -> BTreeMap<String, BTreeSet<String>> {
    let full: String = folder
        .iter()
        .map(|part| format!("{}::", part.to_string_lossy()))
        .collect();
    let full = format!("crate::{full}");
    let mut out: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (path, text) in files {
        let Ok(below) = path.strip_prefix(folder) else {
            continue;
        };
        let parts: Vec<_> = below
            .with_extension("")
            .iter()
            .map(|p| p.to_string_lossy().into_owned())
            .collect();
        if ["mod", "lib", "main"].contains(&&*parts[0]) {
            continue;
        }
        let up = "super::".repeat(if parts.last().is_some_and(|last| last == "mod") {
            parts.len() - 1
        } else {
            parts.len()
        });
        let names = names_after(text, &up)
            .into_iter()
            .chain(names_after(text, &full));
        let own = names.filter(|&name| name != parts[0]).map(str::to_owned);
        out.entry(parts[0].clone()).or_default().extend(own);
    }
    let all: BTreeSet<String> = out.keys().cloned().collect();
    out.values_mut()
        .for_each(|names| names.retain(|name| all.contains(name)));
    out
}

#[test]
fn files_of_a_folder_do_not_import_each_other_in_circles() {
    let mut found = BTreeMap::new();
    for (k, root) in roots().iter().enumerate() {
        let files = files(root);
        let folders: BTreeSet<&Path> = files.iter().filter_map(|(path, _)| path.parent()).collect();
        // The modules of the library are on floors.
        for folder in folders.into_iter().skip(usize::from(k == 0)) {
            let reached = reached(&imports_in(folder, &files));
            let round = reached.iter().filter(|(name, to)| to.contains(*name));
            let round: Vec<&str> = round.map(|(name, _)| name.as_str()).collect();
            if !round.is_empty() {
                found.insert(root.join(folder), round.join(" "));
            }
        }
    }
    assert!(found.is_empty(), "circles: {found:?}");
}
