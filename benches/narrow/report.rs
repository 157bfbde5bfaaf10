//! The table of kinds: pairs, misses, worst errors, times.

use std::fmt;
use std::time::Instant;

use dualbody::collision::nearest_features;
use rand::SeedableRng;

use super::check::{Errors, check};
use super::pairs::{KINDS, Pair, REGIMES, Random, kinds};

/// Most misses that are printed.
const MAX_PRINTED: usize = 12;

/// Calls of which the shortest is the time of a pair.
const TRIES: usize = 3;

/// What was found of two kinds.
#[derive(Default)]
struct Row {
    name: String,
    pairs: usize,
    misses: [usize; REGIMES.len()],
    /// Misses in the distance.
    wrong: usize,
    unproved: usize,
    /// Pairs whose features switch where they are, and those of which differences told nothing.
    switches: usize,
    unknown: usize,
    broken: usize,
    worst: Errors,
    nanoseconds: f64,
}

/// Prints the table of so many pairs of each two kinds and each regime, of the kinds named only; returns the number of wrong distances.
pub(crate) fn report(count: usize, seed: u64, only: &[usize]) -> usize {
    let columns = REGIMES.map(|name| format!("{name:>8}")).concat();
    println!(
        "misses by regime{:6}{:>9}{columns}{:>9}{:>9}{:>9}{:>5} |distance   points gradient differen   beyond onesided |  µs",
        "", "pairs", "unproved", "switches", "unknown", "NaN"
    );
    let is_chosen = |[a, b]: &[usize; 2]| match only {
        [] => true,
        [one] => one == a || one == b,
        both => both == [*a, *b] || both == [*b, *a],
    };
    let mut all = Row::default();
    for pair in kinds().filter(is_chosen) {
        let row = row(pair, count, seed);
        println!("{row}");
        all.add_row(&row);
    }
    println!("{all}");
    all.wrong
}

fn row(kinds: [usize; 2], count: usize, seed: u64) -> Row {
    let mut row = Row {
        name: kinds.map(|kind| KINDS[kind]).join("–"),
        ..Row::default()
    };
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
        for pair in &pairs {
            row.add(pair, regime, check(pair, &mut rng));
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
        self.switches += usize::from(errors.switches);
        self.unknown += usize::from(errors.unknown);
        self.broken += usize::from(errors.broken);
        if errors.is_miss() {
            if self.misses.iter().sum::<usize>() < MAX_PRINTED {
                print(pair, regime, &errors);
            }
            self.misses[regime] += 1;
        }
        self.note_worst(&errors);
    }

    fn note_worst(&mut self, errors: &Errors) {
        let w = &mut self.worst;
        for (most, own) in [
            (&mut w.distance, errors.distance),
            (&mut w.points, errors.points),
            (&mut w.gradient, errors.gradient),
            (&mut w.difference, errors.difference),
            (&mut w.beyond, errors.beyond),
            (&mut w.one_sided, errors.one_sided),
        ] {
            *most = most.max(own);
        }
    }

    fn add_row(&mut self, row: &Self) {
        self.name = "all".to_owned();
        self.pairs += row.pairs;
        self.wrong += row.wrong;
        self.unproved += row.unproved;
        self.switches += row.switches;
        self.unknown += row.unknown;
        self.broken += row.broken;
        self.nanoseconds += row.nanoseconds;
        for (all, own) in self.misses.iter_mut().zip(row.misses) {
            *all += own;
        }
        self.note_worst(&row.worst);
    }
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let by_regime = self.misses.map(|n| format!("{n:>8}")).concat();
        let w = self.worst;
        let worst = [
            w.distance,
            w.points,
            w.gradient,
            w.difference,
            w.beyond,
            w.one_sided,
        ];
        let worst = worst.map(|x| format!("{x:>9.1e}")).concat();
        let time = self.nanoseconds / self.pairs as f64 * 1e-3;
        let Self {
            name,
            pairs,
            unproved,
            switches,
            unknown,
            broken,
            ..
        } = self;
        write!(
            f,
            "{name:<22}{pairs:>9}{by_regime}{unproved:>9}{switches:>9}{unknown:>9}{broken:>5} |{worst} |{time:>6.2}"
        )
    }
}

fn print(pair: &Pair, regime: usize, errors: &Errors) {
    let Pair {
        shapes: [a, b],
        at: [x, y],
    } = pair;
    let found = nearest_features(a, x, b, y);
    eprintln!("{}: {errors:?}\n  {pair:?}\n  {found:?}", REGIMES[regime]);
}
