//! The table of kinds: pairs, misses, worst errors, times.

use std::time::Instant;

use dualbody::collision::nearest_features;
use rand::SeedableRng;

use super::check::{Errors, check};
use super::pairs::{KINDS, Pair, REGIMES, Random, kinds};

/// One of so many pairs is compared with differences, which cost a hundred distances each.
const WITH_DIFFERENCES: usize = 4;
/// Most misses that are printed.
const MAX_PRINTED: usize = 12;

/// Calls of which the shortest is the time of a pair.
const TRIES: usize = 3;

/// What was found of two kinds.
#[derive(Default)]
struct Row {
    pairs: usize,
    misses: [usize; REGIMES.len()],
    /// Misses in the distance.
    wrong: usize,
    unproved: usize,
    worst: Errors,
    nanoseconds: f64,
}

/// Prints the table of so many pairs of each two kinds and each regime, of two kinds only if these are named; returns the number of wrong distances.
pub(crate) fn report(count: usize, seed: u64, only: &[usize]) -> usize {
    let columns = REGIMES.map(|name| format!("{name:>8}")).concat();
    println!(
        "misses by regime{:6}{:>9}{columns}{:>10} |distance   points gradient differen onesided |  µs",
        "", "pairs", "unproved"
    );
    let chosen = kinds().filter(|pair| only.is_empty() || only == pair);
    let (mut pairs, mut misses, mut wrong) = (0, 0, 0);
    for [a, b] in chosen {
        let row = row([a, b], count, seed);
        let by_regime = row.misses.map(|n| format!("{n:>8}")).concat();
        let name = format!("{}–{}", KINDS[a], KINDS[b]);
        let w = row.worst;
        let worst = [w.distance, w.points, w.gradient, w.difference, w.one_sided];
        let worst = worst.map(|x| format!("{x:>9.1e}")).concat();
        let time = row.nanoseconds / row.pairs as f64 * 1e-3;
        println!(
            "{name:<22}{:>9}{by_regime}{:>10} |{worst} |{time:>6.2}",
            row.pairs, row.unproved
        );
        pairs += row.pairs;
        misses += row.misses.iter().sum::<usize>();
        wrong += row.wrong;
    }
    println!("{misses} misses of {pairs} pairs, {wrong} of them in the distance");
    wrong
}

fn row(kinds: [usize; 2], count: usize, seed: u64) -> Row {
    let mut row = Row::default();
    for regime in 0..REGIMES.len() {
        let mut rng = Random::seed_from_u64(
            seed.wrapping_mul(1000)
                .wrapping_add((kinds[0] * 8 + kinds[1]) as u64 * 10 + regime as u64),
        );
        let pairs: Vec<Pair> = (0..count)
            .map(|k| {
                // Every second one the other way round.
                let kinds = if k % 2 == 0 {
                    kinds
                } else {
                    [kinds[1], kinds[0]]
                };
                Pair::random(&mut rng, kinds, regime)
            })
            .collect();
        row.nanoseconds += time(&pairs);
        for (k, pair) in pairs.iter().enumerate() {
            row.add(pair, regime, check(pair, k % WITH_DIFFERENCES == 0));
        }
    }
    row
}

/// Time of the nearest features of all pairs, each the shortest of a few, ns.
fn time(pairs: &[Pair]) -> f64 {
    let once = |pair: &Pair| {
        let start = Instant::now();
        let Pair {
            shapes: [a, b],
            at: [x, y],
        } = pair;
        std::hint::black_box(nearest_features(a, x, b, y));
        start.elapsed().as_secs_f64() * 1e9
    };
    let shortest = |pair| (0..TRIES).map(|_| once(pair)).fold(f64::INFINITY, f64::min);
    pairs.iter().map(shortest).sum()
}

impl Row {
    fn add(&mut self, pair: &Pair, regime: usize, errors: Errors) {
        self.pairs += 1;
        self.wrong += usize::from(errors.is_wrong());
        self.unproved += usize::from(errors.unproved);
        if errors.is_miss() {
            if self.misses.iter().sum::<usize>() < MAX_PRINTED {
                let Pair {
                    shapes: [a, b],
                    at: [x, y],
                } = pair;
                let found = nearest_features(a, x, b, y);
                eprintln!("{}: {errors:?}\n  {pair:?}\n  {found:?}", REGIMES[regime]);
            }
            self.misses[regime] += 1;
        }
        let w = &mut self.worst;
        for (most, own) in [
            (&mut w.distance, errors.distance),
            (&mut w.points, errors.points),
            (&mut w.gradient, errors.gradient),
            (&mut w.difference, errors.difference),
            (&mut w.one_sided, errors.one_sided),
        ] {
            *most = most.max(own);
        }
    }
}
