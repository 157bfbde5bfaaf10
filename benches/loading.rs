//! Time to load a URDF, which is to check the text, to read it into the types of urdf-rs, and to build the robot, beside that of urdf-rs to parse
//! the same text.
//!
//! `cargo bench --bench loading` prints a table. Both sides take turns, so that a busy machine slows both. Where the
//! allocator gives memory back after each call, large robots take longer by the time to get it again (glibc:
//! `MALLOC_TRIM_THRESHOLD_` and `MALLOC_TOP_PAD_` keep it).

mod common;

use std::hint::black_box;

use common::clock::{Clock, is_test};
use common::robots::{ASSETS, chain, path};
use dualbody::ModelOptions;

/// A robot of many links: no cost may grow faster than the text.
const CHAINS: [usize; 3] = [16, 128, 1024];
/// Both sides take so many turns.
const ROUNDS: usize = 15;

fn main() {
    let (clock, rounds) = if is_test() {
        (Clock::ONCE, 1)
    } else {
        (Clock { rounds: 5 }, ROUNDS)
    };
    println!(
        "{:12} {:>8} {:>12} {:>12} {:>7}",
        "robot", "kB", "dualbody/ms", "urdf-rs/ms", "ratio"
    );
    for (name, text) in texts() {
        let (ours, theirs) = compare(&text, clock, rounds);
        println!(
            "{name:12} {:8.1} {:12.4} {:12.4} {:7.2}",
            text.len() as f64 / 1e3,
            ours * 1e3,
            theirs * 1e3,
            ours / theirs
        );
    }
}

fn texts() -> Vec<(String, String)> {
    let assets = ASSETS.map(|name| {
        let text = std::fs::read_to_string(path(name)).expect("the assets can be read");
        (name.to_owned(), text)
    });
    let chains = CHAINS.map(|n| {
        let text = chain(n).to_urdf().expect("a chain can be written");
        (format!("chain{n}"), text)
    });
    assets.into_iter().chain(chains).collect()
}

/// Best times of loading and of parsing, s: other work of the machine only adds to them.
fn compare(text: &str, clock: Clock, rounds: usize) -> (f64, f64) {
    let options = ModelOptions::default();
    (0..rounds).fold((f64::INFINITY, f64::INFINITY), |(ours, theirs), _| {
        let load = clock.median(|| drop(black_box(options.load_urdf_str(black_box(text)))));
        let parse = clock.median(|| drop(black_box(urdf_rs::read_from_string(black_box(text)))));
        (ours.min(load), theirs.min(parse))
    })
}
