//! Plots of a balanced cart-pole as SVG and PNG: the trajectory, the phase portrait of the pole, the remaining cost, and the cost of a plan over the
//! iterations of its optimisation.
//!
//! `cargo run --release --features plot --example plots` – writes to `out/plots/`.

use std::error::Error;
use std::f64::consts::PI;

use dualbody::control::Lqr;
use dualbody::trajopt::{Activation, Cost, Ddp, InputError, Problem, StateError, Trajectory};
use dualbody::view::{Plot, Recording};
use dualbody::{Model, Simulator, State};
use nalgebra::{DMatrix, DVector};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/cartpole.urdf");
const OUT: &str = "out/plots";
const STEPS: usize = 600;

fn main() -> Result<(), Box<dyn Error>> {
    let model = Model::from_urdf_file(FILE)?;
    let simulator = Simulator::new(model)
        .with_time_step(0.01)
        .with_actuated_joints(&["linear"])?;
    let upright = State::neutral(simulator.model());
    let step = simulator.linearize(&upright, &[0.0]);
    let (q, r) = (DMatrix::identity(4, 4), DMatrix::identity(1, 1).scale(0.01));
    let lqr = Lqr::discrete(&step.a, &step.b, &q, &r);
    let deviation = |state: &State| state.deviation(simulator.model(), &upright);
    let rollout = simulator.rollout(&State::new(&[0.0, 0.4], &[0.0; 2]), STEPS, |_, state, u| {
        u.copy_from_slice(lqr.control(&deviation(state)).as_slice());
    });

    // Cost of the rest of the motion: Σ xᵀ Q x + uᵀ R u from each step on.
    let cost = |(state, u): (&State, &DVector<f64>)| {
        deviation(state).norm_squared() + 0.01 * u.norm_squared()
    };
    let costs: Vec<f64> = rollout
        .states
        .iter()
        .zip(&rollout.inputs)
        .map(cost)
        .collect();
    let mut left = costs.clone();
    (0..STEPS - 1).rev().for_each(|k| left[k] += left[k + 1]);

    let recording =
        Recording::from_rollout(simulator.model(), &rollout).with_title("Cart-pole under LQR");
    recording.save_html(format!("{OUT}/index.html"))?;
    let history = rollout.times().zip(left.iter().copied());
    let cost = Plot::new("Cost left to pay")
        .with_axes("t [s]", "cost")
        .with_line("cost", history);
    let plots = [
        (
            "trajectory",
            recording.plot(&["q.linear", "q.pivot", "v.linear", "v.pivot"])?,
        ),
        ("phase", recording.phase_plot("q.pivot", "v.pivot")?),
        ("cost", cost),
        ("history", cost_history(&simulator)),
    ];
    for (name, plot) in plots {
        plot.save_svg(format!("{OUT}/{name}.svg"))?;
        plot.save_png(format!("{OUT}/{name}.png"))?;
        println!("{OUT}/{name}.svg and .png");
    }

    // For a linear robot the cost left would be xᵀ P x; this one is linear at the end.
    let x = deviation(&rollout.states[STEPS / 2]);
    let expected = (x.transpose() * &lqr.cost_to_go * &x)[0];
    println!(
        "cost of the second half: {:.6e}, xᵀ P x = {expected:.6e}",
        left[STEPS / 2]
    );
    assert!((left[STEPS / 2] / expected - 1.0).abs() < 0.02);
    Ok(())
}

/// The cost of a plan that brings the pole up from hanging, iteration by iteration.
fn cost_history(simulator: &Simulator) -> Plot {
    let upright = || StateError::to_neutral(simulator);
    let running = Cost::new()
        .with(0.1, Activation::Quadratic, upright())
        .with(1e-2, Activation::Quadratic, InputError::to_zero(simulator));
    let last = Cost::new().with(10.0, Activation::Quadratic, upright());
    let problem = Problem::new(simulator.clone(), 200, &[0.0, PI, 0.0, 0.0])
        .with_stage_cost(running)
        .with_final_cost(last);
    let mut ddp = Ddp::new(&problem);
    let plan = ddp.solve(&problem, &Trajectory::zero_input(&problem));
    let history = &plan.cost_history;
    println!(
        "swing-up: {} after {} iterations",
        plan.status, plan.iterations
    );
    assert!(history[plan.iterations] < 0.5 * history[0]);
    let costs = history
        .iter()
        .enumerate()
        .map(|(k, &cost)| (k as f64, cost));
    Plot::new("Cost of a plan")
        .with_axes("iteration", "cost")
        .with_line("cost", costs)
}
