//! A batch with contact: nine spheres fall from random heights onto the ground, roll and come to rest.
//!
//! `cargo run --release --example falling_spheres` – writes the motion of the first to
//! `out/falling_spheres/rollout.csv` and a page with all of them beside it.

use std::error::Error;
use std::fs::File;

use dualbody::contact::{ContactLaw, Contacts, SoftContact, Terrain};
use dualbody::dynamics::{kinetic_energy, potential_energy};
use dualbody::sim::{BatchSimulator, Rollout, RolloutStatus};
use dualbody::view::Recording;
use dualbody::{Integrator, Model, Simulator, State};
use rand::{RngExt, SeedableRng, rngs::Xoshiro256PlusPlus};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/sphere.urdf");
const SPHERES: usize = 9;
const SECONDS: f64 = 4.0;
const RADIUS: f64 = 0.1;
/// Depth of a resting sphere in the ground, m.
const DEPTH: f64 = 1e-3;

fn main() -> Result<(), Box<dyn Error>> {
    let model = Model::from_urdf_file(FILE)?;
    let law = ContactLaw::Soft(SoftContact::estimate(model.total_mass(), 1, DEPTH));
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
    let simulator = Simulator::new(model)
        .with_contacts(contacts)
        .with_integrator(Integrator::ImplicitVelocity)
        .with_time_step(1e-3);

    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
    let starts: Vec<State> = (0..SPHERES)
        .map(|k| {
            let (x, y) = (0.4 * (k % 3) as f64, 0.4 * (k / 3) as f64);
            let height = rng.random_range(0.3..1.5);
            let q = [x, y, height, 1.0, 0.0, 0.0, 0.0];
            simulator.state(&q, &[rng.random_range(-0.2..0.2), 0.0, 0.0, 0.0, 0.0, 0.0])
        })
        .collect();
    let steps = (SECONDS / simulator.time_step()) as usize;
    let mut batch = BatchSimulator::new(simulator.clone(), SPHERES);
    let rollout = batch.rollout(&starts, steps, |_, _, _| {});

    for (i, start) in starts.iter().enumerate() {
        let end = rollout.last(i);
        let energy = |state: &State| {
            let (q, v) = (state.q.as_slice(), state.v.as_slice());
            kinetic_energy(simulator.model(), q, v) + potential_energy(simulator.model(), q)
        };
        println!(
            "from {:.2} m: at rest at {:.4} m, {:.2} J of {:.2} J left",
            start.q[2],
            end.q[2],
            energy(&end),
            energy(start)
        );
        assert_eq!(rollout.status(i), RolloutStatus::Completed);
        assert!(
            (end.q[2] - (RADIUS - DEPTH)).abs() < 1e-5,
            "it lies as deep as its weight presses it"
        );
        assert!(energy(&end) < energy(start));
    }

    let states = (0..rollout.n_states(0)).map(|k| rollout.state(0, k));
    let (model, time_step) = (simulator.model(), simulator.time_step());
    let first = Rollout::new(model, time_step, states.collect(), Vec::new());
    std::fs::create_dir_all("out/falling_spheres")?;
    first.write_csv(
        simulator.model(),
        File::create("out/falling_spheres/rollout.csv")?,
    )?;
    let recording = Recording::from_batch(&batch, &rollout, &Vec::from_iter(0..SPHERES));
    Ok(recording
        .with_title("falling spheres")
        .save_html("out/falling_spheres/index.html")?)
}
