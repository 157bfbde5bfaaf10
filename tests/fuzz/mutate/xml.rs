//! Trees of elements.

use std::fmt::Write;

use rand::RngExt;

use super::{any, places, value, with_other_word};
use crate::input::Random;

/// An element.
#[derive(Clone, Debug, Default)]
pub(crate) struct Element {
    name: String,
    attributes: Vec<(String, String)>,
    children: Vec<Node>,
    /// How many more of its kind are around it, to be written only: so deep a tree would be a burden here.
    shells: usize,
}

#[derive(Clone, Debug)]
enum Node {
    Element(Element),
    Text(String),
    /// Written without change.
    Raw(&'static str),
}

/// Parts of XML other than elements, well-formed and not.
const RAW: [&str; 12] = [
    "<!-- - -->",
    "<![CDATA[]]>",
    "<![CDATA[1 <2> 3]]>",
    "<?xml version='1.0'?>",
    "<?p i?>",
    "&#0;",
    "&#x1b;",
    "&#13;&#10;",
    "&e;",
    "]]>",
    "<!DOCTYPE r [<!ENTITY e 'x'>]>",
    "<x:y xmlns:x='u'/>",
];

/// The deepest nesting that is written.
const MAX_SHELLS: usize = 5_000;

impl Element {
    pub(crate) fn parse(text: &str) -> Self {
        let document = roxmltree::Document::parse(text);
        let document = document.unwrap_or_else(|error| panic!("a seed is well-formed: {error}"));
        Self::of(document.root_element())
    }

    fn of(node: roxmltree::Node<'_, '_>) -> Self {
        let attributes = node.attributes();
        let children = node.children().filter_map(|child| match child.text() {
            _ if child.is_element() => Some(Node::Element(Self::of(child))),
            Some(text) if !text.trim().is_empty() => Some(Node::Text(text.into())),
            _ => None,
        });
        Self {
            name: node.tag_name().name().into(),
            attributes: attributes
                .map(|a| (a.name().into(), a.value().into()))
                .collect(),
            children: children.collect(),
            shells: 0,
        }
    }

    /// Names and values in it.
    pub(crate) fn words(&self) -> Vec<String> {
        let own = self
            .attributes
            .iter()
            .flat_map(|(name, value)| [name, value]);
        let mut out: Vec<String> = own.chain([&self.name]).cloned().collect();
        for child in &self.children {
            match child {
                Node::Element(element) => out.extend(element.words()),
                Node::Text(text) => out.push(text.clone()),
                Node::Raw(_) => {}
            }
        }
        out
    }

    fn count(&self) -> usize {
        let elements = self.children.iter().filter_map(Node::element);
        1 + elements.map(Self::count).sum::<usize>()
    }

    /// The n-th element in the order of the text.
    fn nth(&mut self, mut n: usize) -> Option<&mut Self> {
        if n == 0 {
            return Some(self);
        }
        n -= 1;
        for child in self.children.iter_mut().filter_map(Node::element_mut) {
            let size = child.count();
            if n < size {
                return child.nth(n);
            }
            n -= size;
        }
        None
    }

    fn any(&mut self, random: &mut Random) -> &mut Self {
        let n = random.random_range(0..self.count());
        self.nth(n)
            .unwrap_or_else(|| unreachable!("there are more than {n} elements"))
    }

    fn write(&self, out: &mut String) {
        for _ in 0..=self.shells {
            let _ = write!(out, "<{}", self.name);
            for (name, value) in &self.attributes {
                let _ = write!(out, " {name}=\"{}\"", escaped(value));
            }
            out.push('>');
        }
        for child in &self.children {
            match child {
                Node::Element(element) => element.write(out),
                Node::Text(text) => out.push_str(&escaped(text)),
                Node::Raw(text) => out.push_str(text),
            }
        }
        for _ in 0..=self.shells {
            let _ = write!(out, "</{}>", self.name);
        }
    }
}

impl Node {
    fn element(&self) -> Option<&Element> {
        match self {
            Self::Element(element) => Some(element),
            _ => None,
        }
    }

    fn element_mut(&mut self) -> Option<&mut Element> {
        match self {
            Self::Element(element) => Some(element),
            _ => None,
        }
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('"', "&quot;")
}

/// The text of a tree that is changed at a few places.
pub(crate) fn mutated(
    root: &Element,
    others: &[&Element],
    words: &[String],
    random: &mut Random,
) -> String {
    let mut root = root.clone();
    for _ in 0..places(random) {
        mutate(&mut root, others, words, random);
    }
    let mut out = String::new();
    root.write(&mut out);
    out
}

fn mutate(root: &mut Element, others: &[&Element], words: &[String], random: &mut Random) {
    match random.random_range(0..20) {
        0..4 => change_structure(root.any(random), random),
        4 => {
            let taken = root.any(random).clone();
            root.any(random).children.push(Node::Element(taken));
        }
        5 => {
            if let Some(&other) = any(others, random) {
                let taken = other.clone().any(random).clone();
                root.any(random).children.push(Node::Element(taken));
            }
        }
        6 => root.any(random).name = any(words, random).cloned().unwrap_or_default(),
        7 => root.any(random).shells = random.random_range(1..MAX_SHELLS),
        8 => {
            let raw = any(&RAW, random).copied().unwrap_or_default();
            root.any(random).children.insert(0, Node::Raw(raw));
        }
        9 => swap_values(root, random),
        _ => change_value(root.any(random), words, random),
    }
}

/// Drops, repeats or reorders the content of an element.
fn change_structure(element: &mut Element, random: &mut Random) {
    let n = element.children.len();
    if n == 0 {
        return;
    }
    let (i, j) = (random.random_range(0..n), random.random_range(0..n));
    match random.random_range(0..8) {
        0..3 => drop(element.children.remove(i)),
        3 | 4 => element.children.swap(i, j),
        5 | 6 => element.children.insert(j, element.children[i].clone()),
        _ => {
            let copies = random.random_range(2..200);
            let copies = vec![element.children[i].clone(); copies];
            element.children.extend(copies);
        }
    }
}

/// Changes, adds or drops an attribute or the text.
fn change_value(element: &mut Element, words: &[String], random: &mut Random) {
    let n = element.attributes.len();
    let texts = element.children.iter_mut().filter_map(|child| match child {
        Node::Text(text) => Some(text),
        _ => None,
    });
    if let Some(text) = texts
        .last()
        .filter(|_| n == 0 || random.random_range(0..2) == 0)
    {
        *text = with_other_word(text, words, random);
        return;
    }
    let name = any(words, random).cloned().unwrap_or_default();
    match random.random_range(0..8) {
        0 => element.attributes.push((name, value(words, random))),
        1 => element.children.push(Node::Text(value(words, random))),
        _ if n == 0 => {}
        2 => drop(element.attributes.swap_remove(random.random_range(0..n))),
        3 => element.attributes[random.random_range(0..n)].0 = name,
        4 => element.attributes[random.random_range(0..n)].1 = value(words, random),
        _ => {
            let own = &mut element.attributes[random.random_range(0..n)].1;
            *own = with_other_word(own, words, random);
        }
    }
}

/// Gives an attribute the value of the same one of another element: a link becomes the child of another joint, and so on.
fn swap_values(root: &mut Element, random: &mut Random) {
    let from = root.any(random).attributes.clone();
    let to = &mut root.any(random).attributes;
    for (name, value) in from {
        if let Some(own) = to.iter_mut().find(|own| own.0 == name) {
            own.1 = value;
        }
    }
}
