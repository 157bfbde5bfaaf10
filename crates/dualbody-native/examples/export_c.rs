//! A controlled cart-pole as C: the step, its Jacobians and an LQR as three functions without dependencies, compiled and
//! run beside the library.
//!
//! `cargo run --release -p dualbody-native --example export_c` – writes the code to `out/export_c/`; needs a C compiler `cc` to run it.

use std::error::Error;
use std::fs;
use std::process::Command;

use dualbody::codegen::{self, Precision};
use dualbody::control::Lqr;
use dualbody::scalar::traced::{Graph, Port, Traced, trace};
use dualbody::{Model, Simulator, State};
use nalgebra::{DMatrix, DVector, dmatrix, dvector};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/cartpole.urdf");
const OUT: &str = "out/export_c";
const STEPS: usize = 500;
/// Largest difference between a state of the program and one of the library (m, rad, m/s, rad/s).
const TOLERANCE: f64 = 1e-12;

/// Balances the pole, printing every state; then A and B at the end.
const MAIN: &str = r#"#include <stdio.h>
#include "cartpole_control.h"
#include "cartpole_jacobians.h"
#include "cartpole_step.h"

int main(void)
{
    /* q, v, u: the state is also the input of the controller */
    double x[CARTPOLE_STEP_IN_SIZE] = { 0.0, 0.2, 0.0, 0.0, 0.0 };
    double next[CARTPOLE_STEP_OUT_SIZE];
    double ab[CARTPOLE_JACOBIANS_OUT_SIZE];
    for (int step = 0; step < 500; ++step) {
        cartpole_control(x, x + CARTPOLE_STEP_IN_U);
        if (cartpole_step(x, next)) return 1;
        for (int i = 0; i < CARTPOLE_STEP_OUT_SIZE; ++i) {
            x[i] = next[i];
            printf("%.17g ", x[i]);
        }
        printf("\n");
    }
    x[CARTPOLE_STEP_IN_U] = 0.0;
    if (cartpole_jacobians(x, ab)) return 1;
    for (int i = 0; i < CARTPOLE_JACOBIANS_OUT_SIZE; ++i) printf("%.17g ", ab[i]);
    printf("\n");
    return 0;
}
"#;

fn main() -> Result<(), Box<dyn Error>> {
    let simulator = Simulator::new(Model::from_urdf_file(FILE)?)
        .with_time_step(0.01)
        .with_actuated_joints(&["linear"])?;
    let upright = State::neutral(simulator.model());
    let at_rest = simulator.linearize(&upright, &[0.0]);
    let weights = DMatrix::from_diagonal(&dvector![10.0, 10.0, 1.0, 1.0]);
    let lqr = Lqr::discrete(&at_rest.a, &at_rest.b, &weights, &dmatrix![0.01]);

    let functions = [
        ("cartpole_step", codegen::step(&simulator)),
        ("cartpole_jacobians", codegen::linearization(&simulator)),
        ("cartpole_control", controller(&lqr)),
    ];
    for (name, graph) in &functions {
        graph.to_c(name, Precision::Double)?.save(OUT)?;
        println!("{OUT}/{name}.c: {} operations", graph.counts().operations());
    }
    fs::write(format!("{OUT}/main.c"), MAIN)?;
    let Some(printed) = compile_and_run()? else {
        println!("there is no C compiler `cc` here: the code was written, and not run");
        return Ok(());
    };
    compare(&simulator, &lqr, &printed)
}

/// u = −K x as a graph, of a state whose coordinates are its deviation from upright.
fn controller(lqr: &Lqr) -> Graph {
    trace(|t| {
        let x = t.input(Port::vector("x", lqr.gain.ncols()).with_unit("m, rad, m/s, rad/s"));
        let gain: DMatrix<Traced> = lqr.gain.map(Traced::from);
        let u: DVector<Traced> = -(gain * DVector::from_vec(x));
        t.output(Port::vector("u", u.len()).with_unit("N"), &u);
    })
}

/// The lines that the program prints; `None` if there is no compiler.
fn compile_and_run() -> Result<Option<Vec<Vec<f64>>>, Box<dyn Error>> {
    let files = [
        "main.c",
        "cartpole_step.c",
        "cartpole_jacobians.c",
        "cartpole_control.c",
    ];
    let mut cc = Command::new("cc");
    cc.current_dir(OUT)
        .args(["-std=c99", "-O2", "-Wall", "-Werror", "-pedantic"]);
    let Ok(compiled) = cc.args(files).args(["-o", "main", "-lm"]).output() else {
        return Ok(None);
    };
    let errors = String::from_utf8_lossy(&compiled.stderr);
    assert!(
        compiled.status.success(),
        "the code compiles without a warning: {errors}"
    );
    let run = Command::new(format!("{OUT}/main")).output()?;
    assert!(run.status.success(), "no condition of the step is broken");
    let text = String::from_utf8(run.stdout)?;
    let line = |line: &str| line.split_whitespace().map(str::parse).collect();
    Ok(Some(text.lines().map(line).collect::<Result<_, _>>()?))
}

/// Compares the printed motion, and A and B at its end, with those of the library.
fn compare(simulator: &Simulator, lqr: &Lqr, printed: &[Vec<f64>]) -> Result<(), Box<dyn Error>> {
    let upright = State::neutral(simulator.model());
    let start = State::new(&[0.0, 0.2], &[0.0, 0.0]);
    let rollout = simulator.rollout(&start, STEPS, |_, state, u| {
        let deviation = state.deviation(simulator.model(), &upright);
        u.copy_from_slice(lqr.control(&deviation).as_slice());
    });
    let largest = |one: &[f64], other: &mut dyn Iterator<Item = &f64>| {
        let differences = one.iter().zip(other).map(|(a, b)| (a - b).abs());
        differences.fold(0.0, f64::max)
    };
    let (jacobians, states) = printed.split_last().ok_or("the program printed nothing")?;
    assert_eq!(states.len(), STEPS);
    let pairs = states.iter().zip(&rollout.states[1..]);
    let off = pairs
        .map(|(own, state)| largest(own, &mut state.numbers()))
        .fold(0.0, f64::max);
    let last = rollout.last();
    let ab = simulator.linearize(last, &[0.0]);
    let off_ab = largest(jacobians, &mut ab.a.iter().chain(&ab.b));
    println!(
        "{STEPS} steps in C differ from those of the library by {off:.1e}, A and B by {off_ab:.1e}"
    );
    println!(
        "the pole stands: {:.1e}",
        last.deviation(simulator.model(), &upright).norm()
    );
    assert!(off < TOLERANCE && off_ab < TOLERANCE);
    assert!(last.deviation(simulator.model(), &upright).norm() < 1e-3);
    Ok(())
}
