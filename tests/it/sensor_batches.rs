//! Sensors of batches: bit-identical to single states, for all lanes, threads and variants.

use dualbody::contact::{ContactLaw, Contacts, Rigid, Terrain};
use dualbody::model::{Model, samples};
use dualbody::sim::{BatchSimulator, Sensor, Sensors};
use dualbody::{Integrator, Simulator, State};
use rand::SeedableRng;
use rand::rngs::Xoshiro256PlusPlus;

/// Not a multiple of the lanes.
const STATES: usize = 11;

fn sensors(model: &Model) -> Sensors {
    let links = model.link_frames();
    let last = links[links.len() - 1];
    let joint = model.find_joint(model.joint_names()[0]).expect("a joint");
    let (direction, range) = ([0.0, 0.3, -1.0], 5.0);
    Sensors::new(
        model,
        [
            ("encoder", Sensor::JointPosition(joint)),
            ("imu", Sensor::Accelerometer(last)),
            ("wrench", Sensor::Wrench(last)),
            ("touch", Sensor::Touch(last)),
            ("momentum", Sensor::Momentum),
            (
                "distance",
                Sensor::RangeFinder {
                    frame: last,
                    direction,
                    range,
                },
            ),
        ],
    )
}

/// Steps a batch three times, and compares all readings with those of single states.
fn check(what: &str, mut batch: BatchSimulator, starts: &[State]) {
    let sensors = sensors(batch.simulator(0).model());
    let nu = batch.simulator(0).nu();
    let inputs: Vec<f64> = (0..STATES * nu).map(|k| 0.1 * (k as f64).sin()).collect();
    let (mut states, mut plain) = (batch.states(starts), batch.states(starts));
    let mut y = vec![f64::NAN; STATES * sensors.len()];
    let mut rows = vec![0.0; STATES * starts[0].len()];
    for step in 0..3 {
        let before = states.to_vec();
        batch.step_and_read(&mut states, &inputs, &sensors, &mut y);
        batch.step(&mut plain, &inputs);
        states.copy_rows_to(&mut rows);
        for (i, state) in before.iter().enumerate() {
            let u = &inputs[i * nu..(i + 1) * nu];
            let alone = sensors.read(batch.simulator(i), state, u);
            let row = &y[i * sensors.len()..(i + 1) * sensors.len()];
            assert_eq!(row, alone.as_slice(), "{what}, step {step}, state {i}");
            assert_eq!(states.state(i), plain.state(i), "{what}, step {step}");
            let own: Vec<f64> = states.state(i).numbers().copied().collect();
            assert_eq!(rows[i * own.len()..(i + 1) * own.len()], own, "{what}");
        }
    }
}

fn random_states(model: &Model) -> Vec<State> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    (0..STATES)
        .map(|_| State::random(model, &mut rng, 1.0))
        .collect()
}

#[test]
fn readings_of_a_batch_are_those_of_single_states() {
    let model = samples::arm();
    let starts = random_states(&model);
    for integrator in [Integrator::SemiImplicitEuler, Integrator::RungeKutta4] {
        let simulator = Simulator::new(model.clone()).with_integrator(integrator);
        let batch = BatchSimulator::new(simulator, STATES);
        check("one thread", batch.clone().with_threads(1), &starts);
        check("two threads", batch.clone().with_threads(2), &starts);
        check("one by one", batch.with_states_one_by_one(), &starts);
    }
}

#[test]
fn readings_of_variants_are_those_of_their_own_robots() {
    let model = samples::arm();
    let variant = |k: usize| {
        model
            .clone()
            .with_damping(1, 0.1 * k as f64)
            .with_armature(0, 0.02 * k as f64)
    };
    let simulator = Simulator::new(model.clone());
    let models = (0..STATES).map(variant).collect();
    let batch = BatchSimulator::of_variants(&simulator, models).expect("variants");
    let starts = random_states(&model);
    check("variants", batch.clone(), &starts);
    check(
        "variants one by one",
        batch.with_states_one_by_one(),
        &starts,
    );
}

#[test]
fn readings_in_contact_are_those_of_single_states() {
    let path = format!("{}/assets/quadruped.urdf", env!("CARGO_MANIFEST_DIR"));
    let model = Model::from_urdf_file(path).expect("a robot");
    let contacts = Contacts::new(
        &model,
        Terrain::flat(0.0),
        ContactLaw::Rigid(Rigid::default()),
    );
    let simulator = Simulator::new(model.clone()).with_contacts(contacts);
    let mut starts = random_states(&model);
    for (k, state) in starts.iter_mut().enumerate() {
        state.q[2] = 0.05 * k as f64;
    }
    check("contact", BatchSimulator::new(simulator, STATES), &starts);
}
