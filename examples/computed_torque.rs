//! Computed torque: a cart-pole with motors at both joints is brought to rest from a fast motion.
//!
//! `cargo run --release --example computed_torque` – writes a page of the motion to `out/computed_torque/`.

use std::error::Error;

use dualbody::control::ComputedTorque;
use dualbody::view::Recording;
use dualbody::{Model, Simulator, State};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/cartpole.urdf");
const OUT: &str = "out/computed_torque/index.html";
const DT: f64 = 0.01;

fn main() -> Result<(), Box<dyn Error>> {
    let simulator = Simulator::new(Model::from_urdf_file(FILE)?).with_time_step(DT);
    let model = simulator.model();
    // The errors of both joints obey ë + 6 ė + 10 e = 0.
    let controller = ComputedTorque::new(model, 10.0, 6.0);
    // −0.25 m, 160°, 3 m/s, 10° per time step
    let (angle, rate) = (160_f64.to_radians(), 10_f64.to_radians() / DT);
    let start = State::new(&[-0.25, angle], &[3.0, rate]);
    let target = State::neutral(model);
    let rollout = simulator.rollout(&start, 500, |_, state, u| {
        u.copy_from_slice(controller.torque(model, state, &target).as_slice());
    });

    println!("   t / s   cart / m  pole / rad    force / N  torque / N·m");
    let rows = rollout.times().zip(&rollout.states).zip(&rollout.inputs);
    for ((time, s), u) in rows.step_by(50) {
        let (q, u) = (&s.q, &u);
        println!(
            "{time:8.2} {:10.5} {:11.5} {:12.5} {:13.5}",
            q[0], q[1], u[0], u[1]
        );
    }
    // Values of an independent engine.
    assert_close(rollout.inputs[0].as_slice(), [-28.36506, -26.58803]);
    assert_close(rollout.states[1].q.as_slice(), [-0.22155, 2.95380]);
    assert_close(rollout.states[1].v.as_slice(), [2.845, 16.12684]);
    assert!(rollout.last().deviation(model, &target).norm() < 1e-4);

    let mut recording = Recording::from_rollout(model, &rollout);
    let from_target = |s: &State| s.deviation(model, &target).norm();
    recording.add_series(
        "distance from the target",
        rollout.states.iter().map(from_target),
    );
    Ok(recording.save_html(OUT)?)
}

fn assert_close(actual: &[f64], expected: [f64; 2]) {
    let differences = actual.iter().zip(expected).map(|(a, e)| (a - e).abs());
    assert!(
        differences.fold(0.0, f64::max) < 1e-5,
        "{actual:?}, not {expected:?}"
    );
}
