//! A quadruped is dropped onto its feet, catches itself with springs and dampers at its joints, and then stands by LQR
//! about the pose in which it has come to rest, linearised with its contact: pushed, it comes back.
//!
//! `cargo run --release --example quadruped_stand` – writes `out/quadruped_stand/rollout.csv` and a page beside it.

use std::error::Error;
use std::fs::File;

use dualbody::contact::{ContactLaw, Contacts, SoftContact, Terrain};
use dualbody::control::Lqr;
use dualbody::sim::{Actuation, Rollout, RolloutStatus};
use dualbody::view::Recording;
use dualbody::{Integrator, Model, Simulator, State, UnknownName};
use nalgebra::{DMatrix, DVector};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/quadruped.urdf");
const FEET: [&str; 4] = ["FR_foot", "FL_foot", "RR_foot", "RL_foot"];
/// Springs and dampers at the joints, N·m/rad and N·m·s/rad.
const STIFFNESS: f64 = 60.0;
const DAMPING: f64 = 2.0;
/// A foot is light and the ground under it stiff: implicit in velocity, the step may be long all the same, s.
const TIME_STEP: f64 = 2e-3;
/// Steps from one that is shown to the next.
const SHOWN: usize = 5;

fn main() -> Result<(), Box<dyn Error>> {
    let simulator = on_the_ground(Model::from_urdf_file(FILE)?)?;
    let (rest, held) = land(&simulator);
    let gain = balance(&simulator, &rest, &held);
    let stood = stand(&simulator, &rest, |state| {
        let off = state.deviation(simulator.model(), &rest);
        &held - &gain * off.rows(0, gain.ncols())
    });
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

/// Drops the robot onto its feet, held by springs and dampers at the joints; gives the pose in which it comes to rest,
/// and the torques that hold it there.
fn land(simulator: &Simulator) -> (State, DVector<f64>) {
    let start = crouching(simulator);
    let wanted = start.q.rows(7, 12).into_owned();
    let caught = simulator.rollout(&start, steps(10.0), |_, state, u| {
        for k in 0..12 {
            u[k] = STIFFNESS * (wanted[k] - state.q[7 + k]) - DAMPING * state.v[6 + k];
        }
    });
    let rest = caught.last().clone();
    let held = caught.inputs[caught.inputs.len() - 1].clone();
    let (height, speed) = (rest.q[2], rest.v.amax());
    println!("caught: the trunk rests {height:.4} m high, {speed:.1e} from rest");
    assert!(caught.status == RolloutStatus::Completed && speed < 1e-3);
    let weight = simulator.model().total_mass() * 9.81;
    let report = simulator.contact_report(&rest, held.as_slice());
    let carried: f64 = report.forces.iter().map(|f| f.z).sum();
    println!("the feet carry {carried:.3} N of {weight:.3} N");
    assert!((carried - weight).abs() < 1e-3 * weight);
    (rest, held)
}

/// The gain of the LQR about a pose, contact included.
fn balance(simulator: &Simulator, rest: &State, held: &DVector<f64>) -> DMatrix<f64> {
    let step = simulator.linearize(rest, held.as_slice());
    let (anchored, n) = (anchored(simulator, rest), 2 * simulator.model().nv());
    let (a, b) = (step.a.rows(0, n) * anchored, step.b.rows(0, n));
    let r = DMatrix::identity(12, 12).scale(1e-1);
    let lqr = Lqr::discrete(&a, &b.into(), &weights(simulator), &r);
    println!("LQR: spectral radius {:.5}", lqr.spectral_radius());
    assert!(lqr.is_stabilized());
    lqr.gain
}

/// Pushes the robot aside, and lets it come back.
fn stand(
    simulator: &Simulator,
    rest: &State,
    feedback: impl Fn(&State) -> DVector<f64>,
) -> Rollout {
    let mut pushed = rest.clone();
    pushed.v[1] += 0.1;
    pushed.v[3] += 0.2;
    let stood = simulator.rollout(&pushed, steps(3.0), |_, state, u| {
        u.copy_from_slice(feedback(state).as_slice());
    });
    let left = stood.last().deviation(simulator.model(), rest);
    println!(
        "pushed aside at 0.1 m/s and 0.2 rad/s, {:.1e} from its pose three seconds later",
        left.amax()
    );
    assert!(left.rows(0, 36).amax() < 1e-2);
    stood
}

fn save(model: &Model, stood: Rollout) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all("out/quadruped_stand")?;
    let names = stood.input_names().to_vec();
    let states = stood.states.into_iter().step_by(SHOWN).collect();
    let inputs = stood.inputs.into_iter().step_by(SHOWN).collect();
    let shown = Rollout::new(model, TIME_STEP * SHOWN as f64, states, inputs);
    let shown = shown.with_input_names(names);
    shown.write_csv(model, File::create("out/quadruped_stand/rollout.csv")?)?;
    let recording = Recording::from_rollout(model, &shown).with_title("quadruped stand");
    Ok(recording.save_html("out/quadruped_stand/index.html")?)
}

fn steps(seconds: f64) -> usize {
    (seconds / TIME_STEP) as usize
}

/// Legs bent, a hand's breadth above the ground.
fn crouching(simulator: &Simulator) -> State {
    let mut state: State = simulator.neutral_state();
    state.q[2] = 0.4;
    for leg in 0..4 {
        state.q[7 + 3 * leg + 1] = 0.8;
        state.q[7 + 3 * leg + 2] = -1.6;
    }
    state
}

/// The states (δq, δv, δm) of feet that stick where they are: a bristle bends as far as its foot moves. What no input
/// can move, the places to which the bristles hold the feet, is no state of this system.
fn anchored(simulator: &Simulator, at: &State) -> DMatrix<f64> {
    let (model, nv) = (simulator.model(), simulator.model().nv());
    let mut out = DMatrix::identity(simulator.n_tangent(), 2 * nv);
    let contacts = simulator.contacts().expect("feet on the ground");
    for foot in 0..FEET.len() {
        let jacobian = contacts.jacobian(model, at.q.as_slice(), foot);
        out.view_mut((2 * nv + 3 * foot, 0), (2, nv))
            .copy_from(&jacobian.rows(0, 2));
    }
    out
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
