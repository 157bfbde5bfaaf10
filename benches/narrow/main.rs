//! Distances of random pairs of shapes of every two kinds against a proof that no gap is wider, with their derivatives, and the time of each.
//!
//! ```sh
//! cargo bench --bench narrow -- COUNT [SEED [KIND [KIND]]]   # COUNT pairs of each two kinds and each regime; 5715 make a million
//! ```

mod check;
mod differences;
mod pairs;
mod proof;
mod report;
mod support;

use pairs::KINDS;

/// Pairs of each two kinds and each regime where the program is only to be seen to run.
const FEW: usize = 4;

fn main() {
    let is_test = std::env::args().any(|argument| argument == "--test");
    let all = std::env::args().skip(1);
    let arguments: Vec<String> = all.filter(|argument| !argument.starts_with("--")).collect();
    let number = |k: usize, otherwise: u64| {
        arguments.get(k).map_or(otherwise, |text| {
            text.parse().expect("a number of pairs, and a seed")
        })
    };
    let kinds: Vec<usize> = arguments.iter().skip(2).map(|name| kind(name)).collect();
    let count = number(0, FEW as u64) as usize;
    let wrong = report::report(count, number(1, 1), &kinds);
    assert!(!is_test || wrong == 0, "{wrong} wrong distances");
}

fn kind(name: &str) -> usize {
    let found = KINDS.iter().position(|known| *known == name);
    found.unwrap_or_else(|| panic!("the kind {name:?} is not one of {KINDS:?}"))
}
