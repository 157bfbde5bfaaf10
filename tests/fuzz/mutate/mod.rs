//! Changes to files, each at a level at which the file keeps a structure: a tree of elements, a table, a tree of values, bytes.

pub(crate) mod bytes;
pub(crate) mod json;
pub(crate) mod lines;
pub(crate) mod xml;

use rand::RngExt;

use crate::input::Random;

/// Numbers at the ends of their range, and texts that are nearly numbers.
pub(crate) const NUMBERS: [&str; 28] = [
    "0",
    "-0",
    "1",
    "-1",
    "2",
    "0.1",
    "3.141592653589793",
    "1e-9",
    "1e9",
    "1e308",
    "-1e308",
    "1e-308",
    "5e-324",
    "1e999",
    "nan",
    "inf",
    "-inf",
    "",
    " ",
    "1 2",
    "1,5",
    "0x10",
    "+1",
    "4294967295",
    "-2147483648",
    "18446744073709551615",
    "1e",
    "٣",
];

/// Names with a meaning in some format, and texts that control terminals or pages.
pub(crate) const TEXTS: [&str; 22] = [
    "world",
    "__model__",
    "a::b",
    "::",
    "..",
    "../../x",
    "model://x",
    "package://x/y.stl",
    "file:///dev/null",
    "http://x/y",
    "true",
    "z",
    "x y",
    "\u{1b}[2J",
    "\0",
    "\u{202e}abc",
    "a\nb",
    "a\r\nb",
    "\u{9b}31m",
    "=1+1",
    "é漢",
    "<&>\"'",
];

/// At how many places a file is changed: often at one, so that the rest still means something.
pub(crate) fn places(random: &mut Random) -> usize {
    match random.random_range(0..8) {
        0..4 => 1,
        4..6 => 2,
        _ => random.random_range(3..8),
    }
}

/// Any of them.
pub(crate) fn any<'a, T>(items: &'a [T], random: &mut Random) -> Option<&'a T> {
    (!items.is_empty()).then(|| &items[random.random_range(0..items.len())])
}

/// A text to put in the place of another: a number at an end, a text that means something, a word of the seeds, or a long one.
pub(crate) fn value(words: &[String], random: &mut Random) -> String {
    let from =
        |texts: &[&str], random: &mut Random| any(texts, random).map(|text| (*text).to_owned());
    let own = match random.random_range(0..16) {
        0..8 => from(&NUMBERS, random),
        8..11 => from(&TEXTS, random),
        11 => any(words, random).map(|word| word.repeat(random.random_range(1..300))),
        _ => any(words, random).cloned(),
    };
    own.unwrap_or_default()
}

/// A text with one of its words replaced by a number at an end or by itself times a power of ten.
pub(crate) fn with_other_word(text: &str, words: &[String], random: &mut Random) -> String {
    let mut parts: Vec<String> = text.split_whitespace().map(Into::into).collect();
    if parts.is_empty() {
        return value(words, random);
    }
    let k = random.random_range(0..parts.len());
    parts[k] = match parts[k].parse::<f64>() {
        Ok(x) if random.random_range(0..2) == 0 => {
            let factor = 10_f64.powi(random.random_range(-12..13));
            let sign = if random.random_range(0..2) == 0 {
                1.0
            } else {
                -1.0
            };
            (sign * factor * x).to_string()
        }
        _ => value(words, random),
    };
    parts.join(" ")
}
