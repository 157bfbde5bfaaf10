//! The bibliography against the citations in the sources.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

const BIBLIOGRAPHY: &str = include_str!("../../src/references.md");

/// Appends the comments of all Rust sources below a folder; consecutive lines are one text.
fn collect_comments(folder: &Path, texts: &mut Vec<String>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            collect_comments(&path, texts);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let mut text = String::new();
            for line in fs::read_to_string(&path).expect("a source").lines() {
                if let Some(comment) = line.trim_start().strip_prefix("//") {
                    text.push_str(comment.trim_start_matches(['/', '!']));
                } else if !text.is_empty() {
                    texts.push(std::mem::take(&mut text));
                }
            }
            texts.push(text);
        }
    }
}

fn comments() -> Vec<String> {
    let mut texts = Vec::new();
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    collect_comments(&sources, &mut texts);
    texts
}

/// Texts between brackets, of nested ones the innermost.
fn in_brackets(text: &str) -> impl Iterator<Item = &str> {
    let after_opening = text.split('[').skip(1);
    after_opening.filter_map(|rest| Some(rest.split_once(']')?.0))
}

/// Four digits and at most one letter, as in 2008 or 2008a.
fn is_year(word: &str) -> bool {
    let word = word.trim_end_matches(',');
    let digits = word.trim_end_matches(|c: char| c.is_ascii_lowercase());
    digits.len() == 4 && word.len() <= 5 && digits.bytes().all(|b| b.is_ascii_digit())
}

/// Key of a citation: authors and year, without the section that follows. `None` for other texts.
fn key(citation: &str) -> Option<String> {
    let words: Vec<&str> = citation.split_whitespace().collect();
    let year = words.iter().position(|word| is_year(word))?;
    let is_of_name = |c: char| c.is_alphabetic() || ",.&-'".contains(c);
    let has_authors = year > 0 && words[..year].concat().chars().all(is_of_name);
    has_authors.then(|| words[..=year].join(" ").trim_end_matches(',').to_owned())
}

/// Keys of the bibliography, in bold there.
fn entries() -> Vec<String> {
    let entries = BIBLIOGRAPHY
        .lines()
        .filter_map(|line| line.strip_prefix("- **"));
    entries
        .map(|entry| entry.split_once("**").expect("the end of a key").0)
        .map(|key| key.replace('\\', ""))
        .collect()
}

#[test]
fn every_citation_has_an_entry() {
    let comments = comments();
    let cited: BTreeSet<String> = comments
        .iter()
        .flat_map(|text| in_brackets(text))
        .flat_map(|citations| citations.split(';'))
        .filter_map(key)
        .collect();
    assert!(cited.contains("Featherstone 2008") && cited.contains("Todorov 2014"));
    let entries = entries();
    let has_none = |key: &&String| !entries.contains(&format!("[{key}]"));
    let missing: Vec<&String> = cited.iter().filter(has_none).collect();
    assert!(missing.is_empty(), "not in references.md: {missing:?}");
}

#[test]
fn entries_are_cited_and_sorted_and_each_link_equals_its_doi() {
    let comments = comments().join("\n").to_lowercase();
    let keys: Vec<String> = entries()
        .iter()
        .map(|entry| entry.trim_matches(['[', ']']).to_lowercase())
        .collect();
    for key in &keys {
        assert!(comments.contains(key), "{key} is not cited");
    }
    assert!(keys.is_sorted_by(|a, b| a < b), "{keys:?}");
    for link in BIBLIOGRAPHY.split("[doi:").skip(1) {
        let (doi, rest) = link.split_once("](https://doi.org/").expect("a link");
        assert!(rest.starts_with(&format!("{doi})\n")), "{doi}");
    }
}
