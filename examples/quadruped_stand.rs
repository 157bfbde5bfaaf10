//! A quadruped stands on soft ground by LQR about an equilibrium, linearised with its contact. It returns after a push.
//!
//! `cargo run --release --example quadruped_stand` – writes `out/quadruped_stand/rollout.csv` and a page beside it.

use std::error::Error;
use std::fs::File;

use dualbody::contact::{ContactLaw, Contacts, SoftContact, Terrain};
use dualbody::control::{Equilibrium, EquilibriumLqr};
use dualbody::sim::{Actuation, Rollout, RolloutStatus};
use dualbody::view::Recording;
use dualbody::{Integrator, Model, Simulator, State, UnknownName};
use nalgebra::{DMatrix, DVector};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/quadruped.urdf");
const FEET: [&str; 4] = ["FR_foot", "FL_foot", "RR_foot", "RL_foot"];
/// Time step, s. It can be long though a foot is light and the ground stiff, since the integrator is implicit in velocity.
const TIME_STEP: f64 = 2e-3;
/// Steps from one that is shown to the next.
const SHOWN: usize = 5;

fn main() -> Result<(), Box<dyn Error>> {
    let simulator = on_the_ground(Model::from_urdf_file(FILE)?)?;
    let balance = balance(&simulator);
    let stood = stand(&simulator, &balance);
    save(simulator.model(), stood)
}

/// The robot with motors as the file has them, and soft ground under its feet.
fn on_the_ground(model: Model) -> Result<Simulator, UnknownName> {
    let law = ContactLaw::Soft(SoftContact::estimate(model.total_mass(), 4, 2e-3));
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law).with_links(&model, &FEET)?;
    let actuation = Actuation::from_model(&model);
    Ok(Simulator::new(model)
        .with_contacts(contacts)
        .with_actuation(actuation)
        .with_integrator(Integrator::ImplicitVelocity)
        .with_time_step(TIME_STEP))
}

/// Torques that hold the crouching robot on its feet, and the gain of the LQR about it, contact included.
fn balance(simulator: &Simulator) -> EquilibriumLqr {
    let rest = Equilibrium::find(simulator, &crouching(simulator), &[0.0; 12]);
    let (height, torque) = (rest.state.q[2], rest.input.amax());
    println!(
        "equilibrium {}: the trunk is {height:.4} m high, torques up to {torque:.3} N·m",
        rest.status
    );
    assert!(rest.is_found());
    let report = simulator.contact_report(&rest.state, rest.input.as_slice());
    let carried: f64 = report.forces.iter().map(|f| f.z).sum();
    let weight = simulator.model().total_mass() * 9.81;
    println!("the feet carry {carried:.3} N of {weight:.3} N");
    assert!((carried - weight).abs() < 1e-6 * weight);
    let r = DMatrix::identity(12, 12).scale(1e-1);
    let balance = rest.lqr(simulator, &weights(simulator), &r);
    println!(
        "LQR: spectral radius {:.5}; {}",
        balance.lqr.spectral_radius(),
        balance.dropped
    );
    assert!(balance.is_stabilized());
    balance
}

/// Pushes the robot aside, and lets it come back.
fn stand(simulator: &Simulator, balance: &EquilibriumLqr) -> Rollout {
    let (model, rest) = (simulator.model(), &balance.at.state);
    let mut pushed = rest.clone();
    pushed.v[1] += 0.1;
    pushed.v[3] += 0.2;
    let stood = simulator.rollout(&pushed, steps(3.0), |_, state, u| {
        u.copy_from_slice(balance.control(model, state).as_slice());
    });
    assert!(stood.status == RolloutStatus::Completed);
    let left = stood.last().deviation(model, rest);
    println!(
        "pushed aside at 0.1 m/s and 0.2 rad/s, {:.1e} from its pose three seconds later",
        left.amax()
    );
    assert!(left.rows(0, 36).amax() < 1e-2);
    stood
}

fn save(model: &Model, stood: Rollout) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all("out/quadruped_stand")?;
    let states = stood.states.into_iter().step_by(SHOWN).collect();
    let inputs = stood.inputs.into_iter().step_by(SHOWN).collect();
    let mut shown = Rollout::new(model, TIME_STEP * SHOWN as f64, states, inputs);
    shown.input_names = stood.input_names;
    shown.write_csv(model, File::create("out/quadruped_stand/rollout.csv")?)?;
    let recording = Recording::from_rollout(model, &shown).with_title("quadruped stand");
    Ok(recording.save_html("out/quadruped_stand/index.html")?)
}

fn steps(seconds: f64) -> usize {
    (seconds / TIME_STEP) as usize
}

/// Legs bent; how high it stands is found.
fn crouching(simulator: &Simulator) -> State {
    let mut state: State = simulator.neutral_state();
    for leg in 0..4 {
        state.q[7 + 3 * leg + 1] = 0.8;
        state.q[7 + 3 * leg + 2] = -1.6;
    }
    state
}

/// The pose of the trunk counts most.
fn weights(simulator: &Simulator) -> DMatrix<f64> {
    let nv = simulator.model().nv();
    let weight = |k: usize| match k {
        k if k < 6 => 100.0,
        k if k < nv => 1.0,
        _ => 0.1,
    };
    DMatrix::from_diagonal(&DVector::from_fn(2 * nv, |k, _| weight(k)))
}
