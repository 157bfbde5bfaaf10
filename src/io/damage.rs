//! Damage to files, for tests of their readers.

use proptest::prelude::*;

/// The stack of a thread that Rust starts, less than that of the main thread.
const SMALL_STACK: usize = 2 << 20;

/// Runs something where deep recursion would overflow.
pub(super) fn on_small_stack<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> T {
    let thread = std::thread::Builder::new().stack_size(SMALL_STACK);
    thread.spawn(work).unwrap().join().unwrap()
}

/// A change of a text, at positions given as fractions of its length.
#[derive(Clone, Debug)]
pub(super) enum Change {
    Delete(f64, usize),
    Duplicate(f64, usize, f64),
    Overwrite(f64, Vec<u8>),
    Insert(f64, &'static str),
    Rename(&'static str, &'static str),
}

/// A few changes: bytes lost, doubled or overwritten; snippets put anywhere; words exchanged.
pub(super) fn changes(
    snippets: &'static [&'static str],
    words: &'static [&'static str],
) -> impl Strategy<Value = Vec<Change>> {
    let word = || prop::sample::select(words);
    let change = prop_oneof![
        (0.0..1.0, 1..200_usize).prop_map(|(at, n)| Change::Delete(at, n)),
        (0.0..1.0, 1..400_usize, 0.0..1.0).prop_map(|(at, n, to)| Change::Duplicate(at, n, to)),
        (0.0..1.0, prop::collection::vec(any::<u8>(), 1..8))
            .prop_map(|(at, bytes)| Change::Overwrite(at, bytes)),
        (0.0..1.0, prop::sample::select(snippets))
            .prop_map(|(at, snippet)| Change::Insert(at, snippet)),
        (word(), word()).prop_map(|(from, to)| Change::Rename(from, to)),
    ];
    prop::collection::vec(change, 1..5)
}

/// The text after some changes.
pub(super) fn damaged(text: &str, changes: Vec<Change>) -> String {
    let mut bytes = text.as_bytes().to_vec();
    for change in changes {
        apply(&mut bytes, change);
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

fn apply(text: &mut Vec<u8>, change: Change) {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a place in a short text"
    )]
    let place = |text: &[u8], part: f64| (part * text.len() as f64) as usize;
    let span = |text: &[u8], at: usize, n: usize| at..(at + n).min(text.len());
    match change {
        Change::Delete(at, n) => {
            let at = place(text, at);
            text.drain(span(text, at, n));
        }
        Change::Duplicate(at, n, to) => {
            let (at, to) = (place(text, at), place(text, to));
            let copy = text[span(text, at, n)].to_vec();
            text.splice(to..to, copy);
        }
        Change::Overwrite(at, bytes) => {
            let at = place(text, at);
            text.splice(span(text, at, bytes.len()), bytes);
        }
        Change::Insert(at, snippet) => {
            let at = place(text, at);
            text.splice(at..at, snippet.bytes());
        }
        Change::Rename(from, to) => {
            let renamed = String::from_utf8_lossy(text).replacen(from, to, 1);
            *text = renamed.into_bytes();
        }
    }
}
