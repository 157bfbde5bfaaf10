//! How cost grows with the size of a robot: times of chains and bushes of 4 to 1024 bodies, as CSV and as a plot.
//!
//! `cargo bench --features plot --bench growth` – writes `out/growth.csv` and `out/growth.svg`, prints exponents.
//!
//! Expected, with n bodies: RNEA, ABA and a step go through the tree once, so n¹ in a chain and in a bush. The Jacobian of a step has
//! 2n × 3n entries and multiplies with M⁻¹, so at least n² for any tree; for the deepest chains n³ in the limit. An
//! exponent between two sizes next to each other that is far above the fit is a cliff: of a cache, or of a chunk of directions. So
//! some sizes are one above a multiple of a chunk.

mod common;

use std::error::Error;
use std::fmt::Write as _;

use common::clock::{Clock, is_test};
use common::functions::{aba, linearize, rnea, step};
use common::points::points;
use common::robots::{bush, chain};
use dualbody::view::{Plot, RecordingError};
use dualbody::{Model, Simulator};

const SIZES: [usize; 21] = [
    4, 5, 8, 9, 12, 16, 17, 24, 32, 33, 48, 64, 65, 96, 128, 192, 256, 384, 512, 768, 1024,
];
const FUNCTIONS: [&str; 4] = ["rnea", "aba", "step", "linearize"];
/// Builds a tree of so many bodies.
type Build = fn(usize) -> Model;
const TREES: [(&str, Build); 2] = [("chain", chain), ("bush", bush)];
/// All sizes are measured so often and the best time is kept: other work of the machine would look like a cliff.
const PASSES: usize = 5;
/// The exponent is fitted from here: below it the constant part of a call shows.
const LARGE: usize = 16;
/// Growth between two sizes by an exponent so far above the fit is called a cliff.
const CLIFF: f64 = 0.5;
/// Where results go.
const OUT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../out");

/// A function on a kind of tree, with (bodies, seconds) for every size.
struct Series {
    name: String,
    times: Vec<(usize, f64)>,
}

fn main() -> Result<(), Box<dyn Error>> {
    if is_test() {
        measure(&SIZES[..4], 1, Clock::ONCE);
        return Ok(());
    }
    let all = measure(&SIZES, PASSES, Clock { rounds: 5 });
    println!("{:18} {:>8}  steepest step", "function/tree", "exponent");
    all.iter().for_each(report);
    std::fs::create_dir_all(OUT)?;
    std::fs::write(format!("{OUT}/growth.csv"), csv(&all))?;
    Ok(plot(&all, &format!("{OUT}/growth.svg"))?)
}

fn measure(sizes: &[usize], passes: usize, clock: Clock) -> Vec<Series> {
    TREES
        .iter()
        .flat_map(|&(tree, build)| measure_tree(tree, build, sizes, passes, clock))
        .collect()
}

fn measure_tree(
    tree: &str,
    build: Build,
    sizes: &[usize],
    passes: usize,
    clock: Clock,
) -> [Series; FUNCTIONS.len()] {
    let mut all = FUNCTIONS.map(|function| Series {
        name: format!("{function}/{tree}"),
        times: sizes.iter().map(|&n| (n, f64::INFINITY)).collect(),
    });
    for _ in 0..passes {
        for (k, &n) in sizes.iter().enumerate() {
            for (series, time) in all.iter_mut().zip(times(build(n), clock)) {
                series.times[k].1 = series.times[k].1.min(time);
            }
        }
    }
    all
}

/// Times of [`FUNCTIONS`], s.
fn times(model: Model, clock: Clock) -> [f64; FUNCTIONS.len()] {
    let simulator = Simulator::new(model);
    let points = points(&simulator);
    [
        clock.over(&points, rnea(&simulator)),
        clock.over(&points, aba(&simulator)),
        clock.over(&points, step(&simulator)),
        clock.over(&points, linearize(&simulator)),
    ]
}

/// Prints the exponent of growth, and where the time grows fastest from one size to one at least a fifth larger.
fn report(series: &Series) {
    let large: Vec<_> = series.times.iter().filter(|(n, _)| *n >= LARGE).collect();
    let exponent = slope(large.iter().map(|&&(n, time)| ((n as f64).ln(), time.ln())));
    let steps = large.windows(2).filter(|w| w[1].0 * 5 >= w[0].0 * 6);
    let steps = steps.map(|w| {
        let local = (w[1].1 / w[0].1).ln() / (w[1].0 as f64 / w[0].0 as f64).ln();
        (local, w[0].0, w[1].0)
    });
    let (local, from, to) = steps
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .unwrap_or((exponent, 0, 0));
    let verdict = if local > exponent + CLIFF {
        "  CLIFF"
    } else {
        ""
    };
    println!(
        "{:18} {exponent:8.2}  {local:.2} from {from} to {to} bodies{verdict}",
        series.name
    );
}

/// The slope of the straight line through points by least squares.
fn slope(points: impl Iterator<Item = (f64, f64)> + Clone) -> f64 {
    let n = points.clone().count() as f64;
    let (x, y) = points
        .clone()
        .fold((0.0, 0.0), |(x, y), p| (x + p.0 / n, y + p.1 / n));
    let (xy, xx) = points.fold((0.0, 0.0), |(xy, xx), p| {
        (xy + (p.0 - x) * (p.1 - y), xx + (p.0 - x).powi(2))
    });
    xy / xx
}

fn csv(all: &[Series]) -> String {
    let mut out = "function,tree,bodies,seconds\n".to_owned();
    for series in all {
        for (n, time) in &series.times {
            let name = series.name.replace('/', ",");
            let _ = writeln!(out, "{name},{n},{time:.4e}");
        }
    }
    out
}

/// Times over bodies, both logarithmic: a straight line is a power.
fn plot(all: &[Series], path: &str) -> Result<(), RecordingError> {
    let mut plot = Plot::new("Time of a call")
        .with_axes("bodies", "microseconds")
        .with_logarithmic_axes();
    for series in all {
        let line = series.times.iter().map(|&(n, t)| (n as f64, t * 1e6));
        plot = plot.with_line(&series.name, line);
    }
    plot.save_svg(path)
}
