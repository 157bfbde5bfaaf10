//! A free pendulum: the drift of its energy with two integrators.
//!
//! `cargo run --release --example pendulum` – writes a page with both to `out/pendulum/`.

use dualbody::dynamics::{kinetic_energy, potential_energy};
use dualbody::model::samples;
use dualbody::sim::Rollout;
use dualbody::view::{Recording, RecordingError};
use dualbody::{Integrator, Simulator, State};

const OUT: &str = "out/pendulum/index.html";

fn main() -> Result<(), RecordingError> {
    let mut drifts = Vec::new();
    let start = State::new(&[2.0], &[0.0]);
    println!("A rod of 1 kg and 1 m, let go at 2 rad, for 10 s in steps of 1 ms.\n");
    println!(
        "{:<20} {:>14} {:>14} {:>16}",
        "integrator", "max |ΔE| / J", "final ΔE / J", "turns at rad"
    );
    for (integrator, bound) in [
        (Integrator::SemiImplicitEuler, 2e-2),
        (Integrator::RungeKutta4, 1e-9),
    ] {
        let simulator = Simulator::new(samples::pendulum())
            .with_time_step(1e-3)
            .with_integrator(integrator);
        let model = simulator.model();
        let energy = |s: &State| {
            kinetic_energy(model, s.q.as_slice(), s.v.as_slice())
                + potential_energy(model, s.q.as_slice())
        };
        let rollout = simulator.rollout(&start, 10_000, |_, _, _| {});
        let drift: Vec<f64> = rollout
            .states
            .iter()
            .map(|s| energy(s) - energy(&start))
            .collect();
        let largest = drift.iter().fold(0.0_f64, |max, d| max.max(d.abs()));
        let amplitude = rollout
            .states
            .iter()
            .fold(0.0_f64, |max, s| max.max(s.q[0].abs()));
        println!(
            "{:<20} {largest:>14.2e} {:>14.2e} {amplitude:>16.9}",
            format!("{integrator:?}"),
            drift[drift.len() - 1]
        );
        assert!(largest < bound, "the energy drifts by {largest} J");
        assert!(
            (amplitude - 2.0).abs() < bound,
            "the pendulum swings to {amplitude} rad"
        );
        drifts.push((format!("{integrator:?} [J]"), drift, rollout));
    }
    println!(
        "\nSemi-implicit Euler errs within a period and returns; Runge-Kutta 4 stays on the energy to nine digits."
    );
    save(&drifts)
}

/// Writes a page with the pendulums side by side and their drifts of energy.
fn save(drifts: &[(String, Vec<f64>, Rollout)]) -> Result<(), RecordingError> {
    let model = samples::pendulum();
    let mut recording = Recording::of_robots(&[&model, &model]);
    let [a, b] = [0, 1].map(|i| &drifts[i].2);
    for (k, time) in a.times().enumerate() {
        recording.push_all(time, &[(&a.states[k], &[]), (&b.states[k], &[])]);
    }
    for (name, drift, _) in drifts {
        recording.add_series(name, drift.iter().copied());
    }
    recording.spread(1.5);
    recording.save_html(OUT)
}
