//! Changes of bytes, independent of their meaning.

use rand::RngExt;

use super::{any, places};
use crate::input::Random;

/// Pieces that start or end something in one of the formats.
const PIECES: [&[u8]; 20] = [
    b"<",
    b">",
    b"\"",
    b"/>",
    b"<!--",
    b"]]>",
    b"<![CDATA[",
    b"&amp;",
    b"&#27;",
    b"\0",
    b"\xff",
    b"\xef\xbb\xbf",
    b"\xff\xfe",
    b"[[[[",
    b"}",
    b",",
    b"\r",
    b"\n",
    b"1e999",
    b"\x1b",
];

/// Counts and indices at the ends of their ranges.
const WORDS: [u32; 8] = [
    0,
    1,
    2,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_ffff,
    10_000_000,
    0x7fc0_0000,
];

/// The most that a stretch is repeated.
const MAX_COPIES: usize = 40;

/// Changes a few places.
pub(crate) fn mutate(bytes: &mut Vec<u8>, random: &mut Random) {
    for _ in 0..places(random) {
        if bytes.is_empty() {
            return;
        }
        let at = random.random_range(0..bytes.len());
        let end = (at + random.random_range(1..64)).min(bytes.len());
        match random.random_range(0..9) {
            0 => bytes[at] ^= 1 << random.random_range(0..8),
            1 => bytes[at] = random.random_range(0..=255),
            2 => drop(bytes.drain(at..end)),
            3 => bytes.truncate(at),
            4 => {
                let copies = bytes[at..end].repeat(random.random_range(1..MAX_COPIES));
                bytes.splice(at..at, copies);
            }
            5 | 6 => put_word(bytes, at, random),
            _ => {
                let piece = any(&PIECES, random).copied().unwrap_or_default();
                bytes.splice(at..at, piece.iter().copied());
            }
        }
    }
}

/// Overwrites four bytes by a count.
fn put_word(bytes: &mut [u8], at: usize, random: &mut Random) {
    let word = any(&WORDS, random)
        .copied()
        .unwrap_or_default()
        .to_le_bytes();
    let own = bytes[at..].iter_mut().zip(word);
    own.for_each(|(byte, own)| *byte = own);
}
