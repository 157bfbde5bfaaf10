//! What the benches share: robots, random states, the functions that are measured, and a clock.

#![allow(
    dead_code,
    reason = "every bench is a program of its own and uses a part of this"
)]

pub(crate) mod clock;
pub(crate) mod functions;
pub(crate) mod points;
pub(crate) mod robots;

use criterion::Criterion;
use dualbody::Over;

use points::Point;

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
