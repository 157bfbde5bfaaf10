//! A cart-pole from its URDF file to its stabilisation: free motion, then LQR from the exact Jacobians of the step.
//!
//! `cargo run --release --example cartpole` – writes tables and pages of the motions to `out/cartpole/`.

use std::error::Error;

use dualbody::autodiff::finite_difference;
use dualbody::control::Lqr;
use dualbody::dynamics::{bias_forces, center_of_mass, mass_matrix};
use dualbody::sim::{Rollout, RolloutStatus};
use dualbody::view::{Camera, Recording};
use dualbody::{Integrator, Model, Simulator, State};
use nalgebra::{DMatrix, Vector3, dmatrix, dvector};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/cartpole.urdf");
const OUT: &str = "out/cartpole";
const DT: f64 = 0.01;
const STEPS: usize = 500;
const CAMERA: Camera = Camera {
    look_at: [0.0, -0.2, 1.5],
    distance: 2.6,
    azimuth: 25.0,
    elevation: 12.0,
};

type Outcome = Result<(), Box<dyn Error>>;

fn main() -> Outcome {
    let model = Model::from_urdf_file(FILE)?;
    println!("{}: joints {:?}", model.name(), model.joint_names());
    let simulator = Simulator::new(model).with_time_step(DT);
    open_loop(simulator.clone().with_integrator(Integrator::RungeKutta4))?;
    lqr(&simulator.with_actuated_joints(&["linear"])?)
}

/// Lets go from q = (0.5 m, −0.7 rad) at rest; prints the equations of motion there.
fn open_loop(simulator: Simulator) -> Outcome {
    let (model, start) = (simulator.model(), State::new(&[0.5, -0.7], &[0.0, 0.0]));
    let (q, v) = (start.q.as_slice(), start.v.as_slice());
    println!("\nM v̇ + h = τ at q = {q:?}: M{:.6}", mass_matrix(model, q));
    println!("h = {:.6?} N, N·m", bias_forces(model, q, v).as_slice());
    let rollout = simulator.rollout(&start, STEPS, |_, _, _| {});
    report("open loop", &simulator, &rollout)?;
    // Nothing pushes along the rail, so the common centre of mass stays where it is.
    let along = |s: &State| center_of_mass(model, s.q.as_slice()).y;
    let shift = largest(rollout.states.iter().map(|s| along(s) - along(&start)));
    println!("the centre of mass moves by {shift:.1e} m along the rail");
    assert!(shift < 1e-6);
    Ok(())
}

/// Balances the pole upright with a force on the cart alone.
fn lqr(simulator: &Simulator) -> Outcome {
    let (model, upright) = (simulator.model(), State::neutral(simulator.model()));
    let step = simulator.linearize(&upright, &[0.0]);
    println!("\nδx⁺ = A δx + B δu upright: A{:.8}B{:.8}", step.a, step.b);
    let numeric = simulator
        .estimate_linearization(&upright, &[0.0], &finite_difference::Options::default())
        .linearization;
    let error = (&step.a - &numeric.a)
        .amax()
        .max((&step.b - &numeric.b).amax());
    println!("largest difference to central differences: {error:.1e}");
    assert!(error < 1e-10);

    let weights = DMatrix::from_diagonal(&dvector![10.0, 10.0, 1.0, 1.0]);
    let lqr = Lqr::discrete(&step.a, &step.b, &weights, &dmatrix![0.01]);
    println!("LQR: {}, gain {:.5?}", lqr.status, lqr.gain.as_slice());
    lqr.closed_loop_eigenvalues
        .iter()
        .for_each(|eigenvalue| println!("    {eigenvalue:.6}"));
    assert!(lqr.is_stabilized() && lqr.spectral_radius() < 1.0);

    let limits = model.limits(model.find_joint("linear")?);
    let below = |x: f64, limit: Option<f64>| limit.is_none_or(|limit| x < limit);
    for degrees in [10.0_f64, 25.0] {
        let start = State::new(&[0.0, degrees.to_radians()], &[0.0, 0.0]);
        let rollout = simulator.rollout(&start, STEPS, |_, state, u| {
            u.copy_from_slice(lqr.control(&state.deviation(model, &upright)).as_slice());
        });
        report(&format!("LQR from {degrees} degrees"), simulator, &rollout)?;
        let far = largest(rollout.states.iter().map(|s| s.q[0]));
        let fast = largest(rollout.states.iter().map(|s| s.v[0]));
        let strong = largest(rollout.inputs.iter().map(|u| u[0]));
        assert!(below(far, limits.upper) && below(fast, limits.velocity));
        assert!(below(strong, limits.effort));
        let end = rollout.last().deviation(model, &upright);
        assert!(end.norm() < 1e-3, "the pole stands");
    }
    Ok(())
}

/// Prints a short table and writes the whole trajectory as CSV.
fn report(name: &str, simulator: &Simulator, rollout: &Rollout) -> Outcome {
    assert_eq!(rollout.status, RolloutStatus::Completed);
    println!("\n{name}\n   t / s   cart / m  pole / rad        m/s      rad/s");
    for (time, s) in rollout.times().zip(&rollout.states).step_by(STEPS / 5) {
        println!(
            "{time:8.2} {:10.5} {:11.5} {:10.5} {:10.5}",
            s.q[0], s.q[1], s.v[0], s.v[1]
        );
    }
    let mut recording = Recording::from_rollout(simulator.model(), rollout)
        .with_title(format!("Cart-pole: {name}"))
        .with_camera(CAMERA);
    let push = rollout.inputs.iter().map(|u| Vector3::y() * u[0]);
    let forces = push.chain([Vector3::zeros()]);
    recording.robot_mut(0).add_force("cart", forces)?;
    let file = name.replace(' ', "_");
    recording.save_csv(format!("{OUT}/{file}.csv"))?;
    recording.save_html(format!("{OUT}/{file}.html"))?;
    // The page of the example shows the last one.
    Ok(recording.save_html(format!("{OUT}/index.html"))?)
}

fn largest(numbers: impl Iterator<Item = f64>) -> f64 {
    numbers.fold(0.0, |max, x| max.max(x.abs()))
}
