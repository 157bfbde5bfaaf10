//! Items shared by the benches: robots, random states, the functions that are measured, and a clock.

#![allow(
    dead_code,
    reason = "every bench is a program of its own and uses a part of this"
)]

pub(crate) mod clock;
pub(crate) mod functions;
pub(crate) mod points;
pub(crate) mod robots;

use std::time::Duration;

use criterion::Criterion;
use dualbody::Over;

use points::Point;

/// Shorter than by default, since there are many functions, scalars and robots.
pub(crate) fn criterion() -> Criterion {
    Criterion::default()
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1))
}

/// Measures a function over the points in turn.
pub(crate) fn bench<T: Over<f64>>(
    c: &mut Criterion,
    name: &str,
    points: &[Point<T>],
    mut function: impl FnMut(&Point<T>),
) {
    let mut turn = points.iter().cycle();
    c.bench_function(name, |b| b.iter(|| turn.next().map(&mut function)));
}
