//! Medians of times, for programs that print a table of their own.

use std::time::{Duration, Instant};

use dualbody::Over;

use super::points::Point;

/// A round lasts about this long: far above the resolution of the clock, far below the time between two interruptions.
const ROUND: Duration = Duration::from_micros(500);

/// How exactly to measure.
#[derive(Clone, Copy)]
pub(crate) struct Clock {
    /// The result is the median of so many rounds.
    pub(crate) rounds: usize,
}

impl Clock {
    /// For tables.
    pub(crate) const EXACT: Self = Self { rounds: 41 };
    /// For tests: everything is called, nothing is known.
    pub(crate) const ONCE: Self = Self { rounds: 1 };

    /// Median time of a call, s, over the points in turn.
    pub(crate) fn over<T: Over<f64>>(
        self,
        points: &[Point<T>],
        mut function: impl FnMut(&Point<T>),
    ) -> f64 {
        let mut turn = points.iter().cycle();
        self.median(|| turn.next().map_or((), &mut function))
    }

    /// Median time of a call, s.
    pub(crate) fn median(self, mut function: impl FnMut()) -> f64 {
        let first = time(&mut function, 1);
        let calls = match self.rounds {
            1 => 1,
            _ => calls_in_a_round(&mut function, first),
        };
        let mut times: Vec<f64> = (0..self.rounds)
            .map(|_| time(&mut function, calls) / f64::from(calls))
            .collect();
        times.sort_unstable_by(f64::total_cmp);
        times[times.len() / 2]
    }
}

/// After as many calls as fit into a round when caches are cold.
fn calls_in_a_round(function: &mut impl FnMut(), first: f64) -> u32 {
    let fit = |seconds: f64| ((ROUND.as_secs_f64() / seconds).ceil() as u32).max(1);
    let warm = fit(first);
    fit(time(function, warm) / f64::from(warm))
}

/// Seconds that so many calls take.
fn time(function: &mut impl FnMut(), calls: u32) -> f64 {
    let start = Instant::now();
    for _ in 0..calls {
        function();
    }
    start.elapsed().as_secs_f64()
}

/// Whether the program only runs once as a test: the option `--test`, like criterion's.
pub(crate) fn is_test() -> bool {
    std::env::args().any(|argument| argument == "--test")
}

/// The arguments of the program without options, among which are those of criterion and of `cargo bench`.
pub(crate) fn arguments() -> Vec<String> {
    let all = std::env::args().skip(1);
    all.filter(|argument| !argument.starts_with("--")).collect()
}
