//! The sleep of the trees of a state, two numbers each.
//!
//! | tree | first number | second number |
//! |---|---|---|
//! | awake | time for which it has been at rest, s | 0 |
//! | asleep | −1 − index of the first tree of its island | fingerprint of the tree as it fell asleep |
//!
//! Other values, from outside, count as awake without rest.

use nalgebra::DVector;

use crate::model::fingerprint::{FACTOR, START};
use crate::sim::sleeping::NUMBERS_OF_A_TREE as NUMBERS;

/// A tree in a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Record {
    /// With the time at rest, s.
    Awake(f64),
    /// With the first tree of its island.
    Asleep { island: usize, fingerprint: f64 },
}

impl Record {
    /// That of a tree. An empty list means awake.
    pub(super) fn of(sleep: &DVector<f64>, tree: usize) -> Self {
        let &[first, fingerprint] = sleep
            .as_slice()
            .as_chunks()
            .0
            .get(tree)
            .unwrap_or(&[0.0; NUMBERS]);
        let trees = sleep.len() / NUMBERS;
        let island = -1.0 - first;
        if island >= 0.0 && island < trees as f64 && island.fract() == 0.0 {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a whole number of that range"
            )]
            let island = island as usize;
            return Self::Asleep {
                island,
                fingerprint,
            };
        }
        let is_time = first > 0.0 && first.is_finite();
        Self::Awake(if is_time { first } else { 0.0 })
    }

    /// Writes that of a tree.
    pub(super) fn write(self, sleep: &mut DVector<f64>, tree: usize) {
        let numbers = match self {
            Self::Awake(time) => [time, 0.0],
            Self::Asleep {
                island,
                fingerprint,
            } => [-1.0 - island as f64, fingerprint],
        };
        sleep.as_mut_slice()[NUMBERS * tree..][..NUMBERS].copy_from_slice(&numbers);
    }
}

/// A number that tells lists of numbers apart, to the last bit: an integer below 2⁵³, which a state keeps exactly. The hash of [`Model::fingerprint`](crate::Model::fingerprint),
/// FNV-1a, of whole words in place of bytes.
pub(super) fn fingerprint<'a>(numbers: impl Iterator<Item = &'a f64>) -> f64 {
    let words = numbers.map(|x| x.to_bits());
    // Multiplication only carries upwards: the fold brings the high bits down, which differ where low ones of a word are zero.
    let hash = words.fold(START, |hash, word| {
        let mixed = (hash ^ word).wrapping_mul(FACTOR);
        mixed ^ (mixed >> 32)
    });
    (hash >> (u64::BITS - f64::MANTISSA_DIGITS)) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_come_back_and_strange_numbers_are_awake() {
        let mut sleep = DVector::zeros(6);
        let records = [
            Record::Awake(0.25),
            Record::Asleep {
                island: 2,
                fingerprint: 7.0,
            },
            Record::Asleep {
                island: 0,
                fingerprint: 9e15,
            },
        ];
        for (tree, record) in records.into_iter().enumerate() {
            record.write(&mut sleep, tree);
        }
        for (tree, record) in records.into_iter().enumerate() {
            assert_eq!(Record::of(&sleep, tree), record);
        }
        for strange in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.5, -4.0, -0.5] {
            sleep[0] = strange;
            assert_eq!(Record::of(&sleep, 0), Record::Awake(0.0), "{strange}");
        }
        assert_eq!(Record::of(&DVector::zeros(0), 5), Record::Awake(0.0));
    }

    // Each bit of each of seven numbers counts, their order too; all are whole numbers below 2⁵³.
    #[test]
    fn fingerprints_differ_by_any_bit() {
        let rest = [0.5, -1.25, 0.0, 1.0, 0.0, 0.0, 0.0];
        let mut seen = vec![fingerprint(rest.iter())];
        for k in 0..rest.len() {
            for bit in 0..64 {
                let mut other = rest;
                other[k] = f64::from_bits(rest[k].to_bits() ^ (1 << bit));
                seen.push(fingerprint(other.iter()));
            }
        }
        let swapped = [rest[1], rest[0], 0.0, 1.0, 0.0, 0.0, 0.0];
        seen.push(fingerprint(swapped.iter()));
        assert!(seen.iter().all(|x| x.fract() == 0.0 && *x < 2f64.powi(53)));
        let count = seen.len();
        seen.sort_by(f64::total_cmp);
        seen.dedup();
        assert_eq!(seen.len(), count);
    }
}
