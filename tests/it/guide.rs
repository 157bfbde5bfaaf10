//! The guide: its contents, its links, its pictures. Its listings run as documentation tests.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Beginning of links to the sources.
const SOURCES: &str = "../../src/";

/// Texts that are part of the library's documentation too, where names in brackets are links.
const SHARED: [&str; 2] = ["all_conventions.md", "glossary.md"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn chapters_folder() -> PathBuf {
    root().join("guide/src")
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Names of the files of a folder that end so.
fn names(folder: &Path, ending: &str) -> BTreeSet<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let names = entries.map(|entry| entry.expect("an entry").file_name().into_string());
    let names = names.map(|name| name.expect("a name in Unicode"));
    names.filter(|name| name.ends_with(ending)).collect()
}

/// A text without its blocks of code.
fn prose(text: &str) -> String {
    let outside = text.split("```").step_by(2);
    outside.collect()
}

/// Definitions `[label]: target` at the start of a line: label and target.
fn definitions(prose: &str) -> impl Iterator<Item = (&str, &str)> {
    let labelled = prose.lines().filter_map(|line| line.strip_prefix('['));
    let split = labelled.filter_map(|line| line.split_once("]: "));
    split.filter(|(label, target)| !label.contains(']') && !target.contains(' '))
}

/// Targets of links and pictures: `](target)`, and those of definitions.
fn targets(prose: &str) -> Vec<String> {
    let inline = prose.split("](").skip(1);
    let inline = inline.filter_map(|rest| Some(rest.split_once(')')?.0));
    let defined = definitions(prose).map(|(_, target)| target);
    inline.chain(defined).map(str::to_owned).collect()
}

/// Anchors of the headings of a chapter, as mdBook makes them.
fn anchors(text: &str) -> Vec<String> {
    let prose = prose(text);
    let headings = prose.lines().filter(|line| line.starts_with('#'));
    let letter = |c: char| match c {
        c if c.is_whitespace() => Some('-'),
        c => (c.is_alphanumeric() || "-_".contains(c)).then(|| c.to_ascii_lowercase()),
    };
    let slug = |line: &str| {
        line.trim_start_matches('#')
            .trim()
            .chars()
            .filter_map(letter)
            .collect()
    };
    headings.map(slug).collect()
}

/// `true` if the text holds a word that begins so, to its end.
fn declares(source: &str, declaration: &str) -> bool {
    let mut after = source.split(declaration).skip(1);
    after.any(|rest| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_'))
}

/// `true` if a source is, or declares, the item that a label names: `` `Type::method` ``, `` `module` ``; a label in other words names nothing.
fn has_named(target: &str, source: &str, label: &str) -> bool {
    let inner = label
        .strip_prefix('`')
        .and_then(|rest| rest.strip_suffix('`'));
    let Some(name) = inner.and_then(|inner| inner.rsplit("::").next()) else {
        return true;
    };
    let kinds = ["fn", "const fn", "struct", "enum", "trait", "const", "type"];
    let is_item = |kind: &str| declares(source, &format!("pub {kind} {name}"));
    let modules = [format!("/{name}.rs"), format!("/{name}/mod.rs")];
    kinds.iter().any(|kind| is_item(kind)) || modules.iter().any(|end| target.ends_with(end))
}

/// The reason why a link of a chapter leads nowhere.
fn flaw(file: &Path, target: &str) -> Option<String> {
    if target.starts_with("https://") {
        return None;
    }
    let (path, anchor) = target.split_once('#').unwrap_or((target, ""));
    let path = if path.is_empty() {
        file.to_owned()
    } else {
        file.with_file_name(path)
    };
    if !path.exists() {
        return Some(format!("no such file: {target}"));
    }
    let is_there = anchor.is_empty() || anchors(&read(&path)).iter().any(|own| own == anchor);
    (!is_there).then(|| format!("no such heading: {target}"))
}

#[test]
fn every_link_of_the_guide_leads_somewhere() {
    let folder = chapters_folder();
    let mut files: Vec<PathBuf> = names(&folder, ".md")
        .iter()
        .map(|name| folder.join(name))
        .collect();
    let others = ["guide", "python", "examples", "assets", "."];
    files.extend(others.map(|folder| root().join(folder).join("README.md")));
    files.push(root().join("CONTRIBUTING.md"));
    let (mut flaws, mut links) = (Vec::new(), 0);
    for file in &files {
        let prose = prose(&read(file));
        let targets = targets(&prose);
        links += targets.len();
        let found = targets.iter().filter_map(|target| flaw(file, target));
        flaws.extend(found.map(|flaw| format!("{}: {flaw}", file.display())));
    }
    assert!(flaws.is_empty(), "{}", flaws.join("\n"));
    assert!(links > 100, "only {links} links were found");
}

// So that the test above can fail.
#[test]
fn links_that_lead_nowhere_are_found() {
    let file = chapters_folder().join("contact.md");
    for target in [
        "nowhere.md",
        "pictures/nothing.svg",
        "#no-such-heading",
        "../../src/contact/nothing.rs",
    ] {
        assert!(flaw(&file, target).is_some(), "{target}");
    }
    for target in ["#gradients", "../../README.md", "../../src/contact/mod.rs"] {
        assert_eq!(flaw(&file, target), None);
    }
}

#[test]
fn links_to_sources_lead_to_what_they_name() {
    let folder = chapters_folder();
    let mut links = 0;
    for name in names(&folder, ".md") {
        let prose = prose(&read(&folder.join(&name)));
        let own = definitions(&prose).filter(|(_, target)| target.starts_with(SOURCES));
        for (label, target) in own {
            links += 1;
            let source = read(&folder.join(target));
            assert!(
                has_named(target, &source, label),
                "{name}: {label} is not in {target}"
            );
        }
    }
    assert!(links > 100, "only {links} links were found");
    let (target, source) = ("../../src/a/b.rs", "pub fn of() {}");
    assert!(has_named(target, source, "`B::of`") && has_named(target, source, "`a::b`"));
    assert!(!has_named(target, source, "`B::o`") && !has_named(target, source, "`B`"));
}

#[test]
fn each_listing_in_rust_has_one_in_python_or_says_that_there_is_none() {
    let folder = chapters_folder();
    let mut pairs = 0;
    for name in names(&folder, ".md") {
        let text = read(&folder.join(&name));
        let parts: Vec<&str> = text.split("```").collect();
        for part in parts
            .windows(3)
            .filter(|part| part[0].starts_with("rust\n"))
        {
            let is_pair = part[1].trim().is_empty() && part[2].starts_with("python\n");
            let after = part[1].trim_start();
            assert!(
                is_pair || after.starts_with("*Rust only"),
                "{name}: {}",
                part[0]
            );
            pairs += usize::from(is_pair);
        }
    }
    assert!(pairs > 30, "only {pairs} pairs");
}

#[test]
fn names_in_brackets_are_links() {
    let folder = chapters_folder();
    let own = |name: &String| !SHARED.contains(&name.as_str());
    for name in names(&folder, ".md").into_iter().filter(own) {
        let prose = prose(&read(&folder.join(&name)));
        let defined: Vec<&str> = definitions(&prose).map(|(label, _)| label).collect();
        for rest in prose.split("[`").skip(1) {
            let (label, after) = rest.split_once("`]").expect("the end of a label");
            let own = format!("`{label}`");
            // [text](target), [text][label], or a label by itself; a label that is a name in brackets comes next.
            let other = after
                .strip_prefix('[')
                .and_then(|rest| rest.split_once(']'));
            let label = other.map_or(own.as_str(), |(label, _)| label);
            let leads = after.starts_with('(') || after.is_empty() || defined.contains(&label);
            assert!(leads, "{name}: [{label}] leads nowhere");
        }
    }
}

#[test]
fn contents_equal_the_chapters_and_the_listings_that_run() {
    let folder = chapters_folder();
    let summary = read(&folder.join("SUMMARY.md"));
    let listed = BTreeSet::from_iter(targets(&summary));
    let mut there = names(&folder, ".md");
    there.remove("SUMMARY.md");
    assert_eq!(listed, there);
    let run = read(&root().join("src/guide.rs"));
    for name in &there {
        let has_listings = read(&folder.join(name)).contains("```rust");
        let runs = run.contains(&format!("\"../guide/src/{name}\""));
        assert_eq!(has_listings, runs, "{name}");
        assert!(
            !read(&folder.join(name)).contains("```rust,"),
            "{name}: a listing that does not run"
        );
    }
}

#[test]
fn pictures_of_the_guide_are_shown_and_equal_those_of_the_examples() {
    let folder = chapters_folder();
    let text: String = names(&folder, ".md")
        .iter()
        .map(|name| read(&folder.join(name)))
        .collect();
    for name in names(&folder.join("pictures"), "g") {
        assert!(
            text.contains(&format!("](pictures/{name})")),
            "{name} is not shown"
        );
        if name.ends_with(".png") {
            let [own, gallery] = [folder.join("pictures"), root().join("assets/gallery")]
                .map(|folder| fs::read(folder.join(&name)).expect("a picture"));
            assert!(own == gallery, "{name} is not that of the examples");
        }
    }
}

// Where it is, rustdoc checks: the places are links in the library's documentation.
#[test]
fn every_entry_of_the_glossary_has_a_meaning_and_a_place() {
    let glossary = read(&chapters_folder().join("glossary.md"));
    let rows = glossary.lines().filter(|line| line.starts_with("| "));
    let entries = rows.filter(|row| !row.starts_with("| term "));
    let mut terms = BTreeSet::new();
    for entry in entries {
        let cells: Vec<&str> = entry.split('|').map(str::trim).collect();
        let [_, term, _, _, meaning, place, _] = cells[..] else {
            panic!("not five columns: {entry}");
        };
        assert!(terms.insert(term), "{term} stands there twice");
        let is_linked = place.starts_with("[`") && place.ends_with("`]");
        assert!(!meaning.is_empty() && is_linked, "{entry}");
    }
    assert!(terms.len() > 60, "{} terms", terms.len());
}

#[test]
fn every_example_is_in_the_tables() {
    let readmes = ["README.md", "examples/README.md"].map(|path| read(&root().join(path)));
    for name in names(&root().join("examples"), ".rs") {
        let name = format!("`{}`", name.trim_end_matches(".rs"));
        // Those with features of their own are in the longer table only.
        let rare = ["`plots`", "`rerun`"].contains(&name.as_str());
        assert!(rare || readmes[0].contains(&name), "README.md: {name}");
        assert!(readmes[1].contains(&name), "examples/README.md: {name}");
    }
}
