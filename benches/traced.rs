//! Expression graphs of robots, and C made of them, beside the library: sizes, times to trace and to compile, times of a call.
//!
//! `RUSTFLAGS='-C target-cpu=native' cargo bench --features codegen-tests --bench traced` – prints a table; needs a C compiler `cc` for the last columns.
//! Compiled with `cc -O2 -march=native`. Times of calls are the least of some rounds, in the library and in C alike, one call after the other
//! over the same points.

mod common;

use std::error::Error;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use common::clock::is_test;
use common::functions::{linearize, rnea, step};
use common::points::{Point, points};
use common::robots::asset;
use dualbody::codegen::{self, Precision};
use dualbody::scalar::Graph;
use dualbody::{Model, Simulator};

const ROBOTS: [&str; 4] = ["ur5", "panda", "quadruped", "humanoid"];
/// Rounds of which the fastest counts.
const ROUNDS: usize = 40;
/// Calls of a round.
const CALLS: usize = 1000;

/// A function of a robot, traced.
struct Traced {
    name: String,
    graph: Graph,
    /// Seconds that tracing took, with all simplification.
    tracing: f64,
    /// Seconds of a call in the library.
    library: f64,
    inputs: Vec<Vec<f64>>,
}

fn main() -> Result<(), Box<dyn Error>> {
    println!(
        "| function | operations | of these fused | alive | traced, ms | interpreted, µs | library, µs | C, µs | C / library | cc, s |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    let robots = if is_test() { &ROBOTS[..1] } else { &ROBOTS };
    for robot in robots {
        for function in traced(robot, &Simulator::new(asset(robot))) {
            report(&function)?;
        }
    }
    Ok(())
}

/// RNEA, the step, and its Jacobians.
fn traced(robot: &str, simulator: &Simulator) -> [Traced; 3] {
    let (model, all): (&Model, _) = (simulator.model(), points::<f64>(simulator));
    let numbers = |p: &Point<f64>, last: &[f64]| {
        let state = p.state.q.iter().chain(&p.state.v);
        state.chain(last).copied().collect::<Vec<f64>>()
    };
    let of_rnea = all.iter().map(|p| numbers(p, &p.a)).collect();
    let of_step: Vec<Vec<f64>> = all.iter().map(|p| numbers(p, &p.u)).collect();
    let times = [
        fastest(&all, rnea(simulator)),
        fastest(&all, step(simulator)),
        fastest(&all, linearize(simulator)),
    ];
    let new = |name: &str, trace: &dyn Fn() -> Graph, library: f64, inputs| {
        let start = Instant::now();
        let graph = trace();
        Traced {
            name: format!("{robot}_{name}"),
            graph,
            tracing: start.elapsed().as_secs_f64(),
            library,
            inputs,
        }
    };
    [
        new(
            "rnea",
            &|| codegen::inverse_dynamics(model),
            times[0],
            of_rnea,
        ),
        new(
            "step",
            &|| codegen::step(simulator),
            times[1],
            of_step.clone(),
        ),
        new(
            "ab",
            &|| codegen::linearization(simulator),
            times[2],
            of_step,
        ),
    ]
}

/// Least time of a call, s, over the points in turn.
fn fastest(points: &[Point<f64>], mut call: impl FnMut(&Point<f64>)) -> f64 {
    let (rounds, calls) = if is_test() { (1, 1) } else { (ROUNDS, CALLS) };
    let mut turn = points.iter().cycle();
    let mut round = || {
        let start = Instant::now();
        (0..calls).for_each(|_| turn.next().map_or((), &mut call));
        start.elapsed().as_secs_f64() / calls as f64
    };
    (0..rounds).map(|_| round()).fold(f64::INFINITY, f64::min)
}

fn report(function: &Traced) -> Result<(), Box<dyn Error>> {
    let (graph, library) = (&function.graph, function.library);
    let (mut scratch, mut out) = (graph.scratch(), vec![0.0; graph.n_outputs()]);
    let mut turn = function.inputs.iter().cycle();
    let mut interpreted = f64::INFINITY;
    for _ in 0..if is_test() { 1 } else { 10 * ROUNDS } {
        let start = Instant::now();
        if let Some(x) = turn.next() {
            graph.evaluate_into(x, &mut scratch, &mut out)?;
        }
        interpreted = interpreted.min(start.elapsed().as_secs_f64());
    }
    let counts = graph.counts();
    print!(
        "| {} | {} | {} | {} | {:.1} | {:.1} | {:.3} |",
        function.name.replace('_', " "),
        counts.operations(),
        counts.fused_products,
        graph.live_values(),
        1e3 * function.tracing,
        1e6 * interpreted,
        1e6 * library
    );
    match compiled(function)? {
        Some((call, cc)) => println!(" {:.3} | {:.2} | {cc:.1} |", 1e6 * call, call / library),
        None => println!(" no cc | | |"),
    }
    Ok(())
}

/// Seconds of a call in C, and of the compiler; `None` without one.
fn compiled(function: &Traced) -> Result<Option<(f64, f64)>, Box<dyn Error>> {
    let folder: PathBuf =
        std::env::temp_dir().join(format!("dualbody-bench-{}", std::process::id()));
    function
        .graph
        .to_c(&function.name, Precision::Double)?
        .save(&folder)?;
    std::fs::write(folder.join("main.c"), program(function)?)?;
    let start = Instant::now();
    let object = format!("{}.c", function.name);
    if !cc(&folder, &["-c", &object, "-o", "function.o"])? {
        return Ok(None);
    }
    let time = start.elapsed().as_secs_f64();
    cc(&folder, &["main.c", "function.o", "-o", "main", "-lm"])?;
    let printed = Command::new(folder.join("main")).output()?;
    std::fs::remove_dir_all(&folder)?;
    let seconds: f64 = String::from_utf8(printed.stdout)?.trim().parse()?;
    Ok(Some((seconds, time)))
}

/// Whether there is a compiler.
fn cc(folder: &Path, arguments: &[&str]) -> Result<bool, Box<dyn Error>> {
    let flags = ["-std=gnu99", "-O2", "-march=native", "-Wall", "-Werror"];
    let mut command = Command::new("cc");
    let Ok(output) = command
        .current_dir(folder)
        .args(flags)
        .args(arguments)
        .output()
    else {
        return Ok(false);
    };
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    Ok(true)
}

/// A program that prints the least time of a call.
fn program(function: &Traced) -> Result<String, std::fmt::Error> {
    let (name, points, n) = (
        &function.name,
        function.inputs.len(),
        function.graph.n_inputs(),
    );
    let mut numbers = String::new();
    for x in function.inputs.iter().flatten() {
        write!(numbers, "{x:e},")?;
    }
    let (rounds, calls) = if is_test() { (1, 1) } else { (ROUNDS, CALLS) };
    let outputs = function.graph.n_outputs();
    Ok(format!(
        r#"#include <stdio.h>
#include <time.h>
#include "{name}.h"
static const double in[] = {{ {numbers} }};
static double out[{outputs}];
static double now(void) {{ struct timespec t; clock_gettime(CLOCK_MONOTONIC, &t); return t.tv_sec + 1e-9 * t.tv_nsec; }}
int main(void) {{
    double best = 1e9;
    for (int round = 0, k = 0; round < {rounds}; ++round) {{
        const double start = now();
        for (int call = 0; call < {calls}; ++call) {{ {name}(in + {n} * k, out); k = (k + 1) % {points}; }}
        const double time = (now() - start) / {calls};
        if (time < best) best = time;
    }}
    printf("%.9g\n", best);
    return 0;
}}
"#
    ))
}
