//! The cart-pole from its description to its stabilisation: open loop, computed torque, and LQR on
//! the exact Jacobians of the step.
//!
//! `cargo run --release --example cartpole` – writes the trajectories to `out/cartpole/`.

use std::{error::Error, fs::File, io::BufWriter};

use dualbody::control::{ComputedTorque, Lqr};
use dualbody::dynamics::{bias_forces, center_of_mass, mass_matrix};
use dualbody::sim::{Rollout, RolloutStatus};
use dualbody::{Integrator, Model, Simulator, State};
use nalgebra::{DMatrix, dmatrix, dvector};

const DT: f64 = 0.01;
const STEPS: usize = 500;
const OUT: &str = "out/cartpole";

type Outcome = Result<(), Box<dyn Error>>;

fn main() -> Outcome {
    let model =
        Model::from_urdf_file(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/cartpole.urdf"))?;
    println!(
        "{}: joints {:?}, links {:?}",
        model.name(),
        model.joint_names(),
        model.link_names()
    );
    std::fs::create_dir_all(OUT)?;
    open_loop(&model)?;
    computed_torque(&model)?;
    lqr(&model)
}

/// Lets go from q = (0.5 m, −0.7 rad) at rest; prints the equations of motion there.
fn open_loop(model: &Model) -> Outcome {
    let start = State::new(&[0.5, -0.7], &[0.0, 0.0]);
    println!(
        "\nM v̇ + h = τ at q = (0.5 m, −0.7 rad): M{:.6}",
        mass_matrix(model, start.q.as_slice())
    );
    println!(
        "h = {:.6?} N, N·m",
        bias_forces(model, start.q.as_slice(), &[0.0; 2]).as_slice()
    );
    let simulator = Simulator::new(model.clone())
        .with_time_step(DT)
        .with_integrator(Integrator::RungeKutta4);
    let rollout = simulator.rollout(&start, STEPS, |_, _, _| {});
    report("open loop", model, &rollout)?;
    // Nothing pushes along the rail, so the common centre of mass stays where it is.
    let along = |s: &State| center_of_mass(model, s.q.as_slice()).y;
    let shift = rollout
        .states
        .iter()
        .map(|s| (along(s) - along(&start)).abs())
        .fold(0.0, f64::max);
    println!("the centre of mass strays by {shift:.1e} m along the rail");
    assert!(shift < 1e-4);
    Ok(())
}

/// Drives both joints to zero with `k_p` = 10, `k_d` = 6.
fn computed_torque(model: &Model) -> Outcome {
    let simulator = Simulator::new(model.clone()).with_time_step(DT);
    let controller = ComputedTorque::new(model, 10.0, 6.0);
    // −0.25 m, 160°, 3 m/s, 10° per time step
    let start = State::new(
        &[-0.25, 160_f64.to_radians()],
        &[3.0, 10_f64.to_radians() / DT],
    );
    let target = State::neutral(model);
    let rollout = simulator.rollout(&start, STEPS, |_, state, u| {
        u.copy_from_slice(controller.torque(model, state, &target).as_slice());
    });
    report("computed torque", model, &rollout)?;
    println!("first torque {:.5?}", rollout.inputs[0].as_slice());
    // Values of an independent engine.
    assert_close(rollout.inputs[0].as_slice(), &[-28.36506, -26.58803]);
    assert_close(rollout.states[1].q.as_slice(), &[-0.22155, 2.95380]);
    assert_close(rollout.states[1].v.as_slice(), &[2.845, 16.12684]);
    assert!(distance(rollout.last()) < 1e-4, "the target is reached");
    Ok(())
}

/// Balances the pole upright with a force on the cart alone.
fn lqr(model: &Model) -> Outcome {
    let simulator = Simulator::new(model.clone())
        .with_time_step(DT)
        .with_actuated_joints(&["linear"])?;
    let upright = State::neutral(model);
    let step = simulator.linearize(&upright, &[0.0]);
    println!(
        "\nδx⁺ = A δx + B δu about the upright pole: A{:.8}B{:.8}",
        step.a, step.b
    );
    let numeric = simulator.linearize_by_finite_differences(&upright, &[0.0]);
    let error = (&step.a - &numeric.a)
        .amax()
        .max((&step.b - &numeric.b).amax());
    println!("largest difference to central differences: {error:.1e}");
    assert!(error < 1e-10);

    let weights = DMatrix::from_diagonal(&dvector![10.0, 10.0, 1.0, 1.0]);
    let lqr = Lqr::discrete(&step.a, &step.b, &weights, &dmatrix![0.01]);
    println!(
        "LQR: {}, gain {:.5?}, closed-loop eigenvalues",
        lqr.status,
        lqr.gain.as_slice()
    );
    lqr.closed_loop_eigenvalues
        .iter()
        .for_each(|eigenvalue| println!("    {eigenvalue:.6}"));
    assert!(lqr.is_stabilized() && lqr.spectral_radius() < 1.0);

    let limits = model.limits(model.find_joint("linear")?);
    let within = |x: f64, limit: Option<f64>| limit.is_none_or(|limit| x.abs() < limit);
    for degrees in [10.0_f64, 25.0] {
        let start = State::new(&[0.0, degrees.to_radians()], &[0.0, 0.0]);
        let rollout = simulator.rollout(&start, STEPS, |_, state, u| {
            u.copy_from_slice(lqr.control(&state.deviation(model, &upright)).as_slice());
        });
        report(&format!("LQR from {degrees} degrees"), model, &rollout)?;
        assert!(
            rollout
                .states
                .iter()
                .all(|s| within(s.q[0], limits.upper) && within(s.v[0], limits.velocity))
        );
        assert!(
            rollout.inputs.iter().all(|u| within(u[0], limits.effort)),
            "the force keeps its limit"
        );
        assert!(distance(rollout.last()) < 0.02, "the pole stands");
    }
    Ok(())
}

/// Prints a short table and writes the whole trajectory as CSV.
fn report(name: &str, model: &Model, rollout: &Rollout) -> Outcome {
    assert_eq!(rollout.status, RolloutStatus::Completed);
    println!("\n{name}\n   t / s   cart / m  pole / rad        m/s      rad/s");
    for (k, s) in rollout.states.iter().enumerate().step_by(STEPS / 5) {
        println!(
            "{:8.2} {:10.5} {:11.5} {:10.5} {:10.5}",
            k as f64 * DT,
            s.q[0],
            s.q[1],
            s.v[0],
            s.v[1]
        );
    }
    let path = format!("{OUT}/{}.csv", name.replace(' ', "_"));
    Ok(rollout.write_csv(model, BufWriter::new(File::create(path)?))?)
}

/// Distance from the upright pole at rest.
fn distance(state: &State) -> f64 {
    state.q.norm().hypot(state.v.norm())
}

fn assert_close(actual: &[f64], expected: &[f64]) {
    assert!(
        actual
            .iter()
            .zip(expected)
            .all(|(a, e)| (a - e).abs() < 1e-5),
        "{actual:?}, not {expected:?}"
    );
}
