//! Batches whose states have parameters of their own, steps of an action, and states set by a mask.

use dualbody::constraint::Anchor;
use dualbody::contact::{ContactLaw, Contacts, HeightField, RelaxedRigid, Rigid, Terrain};
use dualbody::model::{Base, Model, samples};
use dualbody::sim::{
    Actuation, Actuator, BatchSimulator, CoulombFriction, ExternalForce, RolloutStatus, Servo,
};
use dualbody::spatial::{Force, Representation};
use dualbody::{ModelOptions, Simulator, State};
use nalgebra::Vector3;
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

/// Not a multiple of the lanes.
const STATES: usize = 11;

/// A free ball of 2 kg, with a point of contact.
fn ball() -> Model {
    let xml = format!(
        "<robot name='ball'><link name='ball'><inertial><mass value='2'/><inertia ixx='0.02' iyy='0.02' izz='0.02' ixy='0' ixz='0' iyz='0'/></inertial>
        <collision><geometry><sphere radius='{RADIUS}'/></geometry></collision></link></robot>"
    );
    let options = ModelOptions::default().with_base(Base::Floating);
    options.load_urdf_str(&xml).expect("a ball").0
}
const RADIUS: f64 = 0.1;

fn on(terrain: Terrain, law: ContactLaw) -> Simulator {
    let model = ball();
    let contacts = Contacts::new(&model, terrain, law);
    Simulator::new(model)
        .with_time_step(2e-3)
        .with_contacts(contacts)
}

/// Rows of parameters, the named ones of which are set state by state.
fn rows(simulator: &Simulator, named: &[(&str, &dyn Fn(usize) -> f64)]) -> Vec<f64> {
    let layout = simulator.parameter_layout();
    let mut all = Vec::new();
    for i in 0..STATES {
        let mut row = simulator.parameters();
        for (name, value) in named {
            row[layout.find(name).expect("a parameter")] = value(i);
        }
        all.extend(row.iter());
    }
    all
}

/// Some steps of a batch have the bits of single simulators with the parameters of each state.
fn check(simulator: &Simulator, parameters: &[f64], start: &State) {
    let width = simulator.parameters().len();
    let batch = BatchSimulator::of_parameters(simulator, parameters);
    assert_eq!(batch.len(), STATES);
    for mut batch in [
        batch.clone().with_threads(1),
        batch.with_states_one_by_one(),
    ] {
        let mut states = batch.states(&vec![start.clone(); STATES]);
        let inputs: Vec<f64> = (0..STATES * batch.simulator(0).nu())
            .map(|k| (k as f64).cos())
            .collect();
        batch.step_times(&mut states, &inputs, 30);
        for (i, row) in parameters.chunks_exact(width).enumerate() {
            let alone = simulator.with_parameters(row);
            let u = &inputs[i * batch.simulator(0).nu()..(i + 1) * batch.simulator(0).nu()];
            let end = (0..30).fold(start.clone(), |state, _| alone.step(&state, u));
            assert_eq!(states.state(i), end, "state {i}");
            assert_eq!(states.status(i), RolloutStatus::Completed);
        }
    }
}

#[test]
fn states_with_all_parameters_changed_have_the_bits_of_single_simulators() {
    let model = samples::cartpole();
    let servo = Some(Servo::position(40.0, 3.0));
    let friction = Some(CoulombFriction::exact(0.3));
    let actuator = Actuator {
        servo,
        friction,
        ..Actuator::default()
    };
    let actuation = Actuation::from_model(&model);
    let actuation = actuation
        .with_actuator(&model, "linear", actuator)
        .expect("a joint");
    let cartpole = Simulator::new(model)
        .with_time_step(0.01)
        .with_actuation(actuation);
    let grid = HeightField::new([-1.0, -1.0], [0.5, 0.5], [5, 5], &[0.01; 25]);
    let rolling = on(
        Terrain::HeightField(grid),
        ContactLaw::RelaxedRigid(RelaxedRigid::default()),
    );
    let bouncing = on(
        Terrain::flat(0.0),
        ContactLaw::Rigid(Rigid {
            restitution: 0.5,
            ..Rigid::default()
        }),
    );
    for simulator in [cartpole, rolling, bouncing] {
        let own = simulator.parameters();
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
        let vary = |x: &f64| x * rng.random_range(0.9..1.0);
        let parameters: Vec<f64> = (0..STATES)
            .flat_map(|_| own.iter().collect::<Vec<_>>())
            .map(vary)
            .collect();
        let mut start = simulator.neutral_state();
        if start.q.len() == 7 {
            start.q[2] = RADIUS + 0.005;
            start.v[0] = 0.4;
        }
        check(&simulator, &parameters, &start);
    }
}

/// v²/2 μ g, for any mass, where a point slides without turning: the ball is held from turning by an inertia without bounds.
#[test]
fn a_box_slides_as_far_as_its_own_friction_lets_it() {
    let xml = "<robot name='box'><link name='box'><inertial><mass value='1'/><inertia ixx='1e6' iyy='1e6' izz='1e6' ixy='0' ixz='0' iyz='0'/></inertial>
        <collision><geometry><sphere radius='0.1'/></geometry></collision></link></robot>";
    let options = ModelOptions::default().with_base(Base::Floating);
    let model = options.load_urdf_str(xml).expect("a box").0;
    let law = ContactLaw::Rigid(Rigid {
        friction: 0.5,
        restitution: 0.0,
        ..Rigid::default()
    });
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
    let simulator = Simulator::new(model)
        .with_time_step(1e-3)
        .with_contacts(contacts);
    let friction = |i: usize| 0.1 + 0.05 * i as f64;
    let height = |i: usize| 0.02 * i as f64;
    let parameters = rows(
        &simulator,
        &[
            ("contact 0 of box: friction", &friction),
            ("terrain: height", &height),
        ],
    );
    let mut batch = BatchSimulator::of_parameters(&simulator, &parameters);
    let start = |i: usize| {
        let mut state: State = simulator.neutral_state();
        (state.q[2], state.v[0]) = (RADIUS + height(i), 1.0);
        state
    };
    let starts: Vec<State> = (0..STATES).map(start).collect();
    let mut states = batch.states(&starts);
    batch.step_times(
        &mut states,
        &vec![0.0; STATES * batch.simulator(0).nu()],
        1200,
    );
    for i in 0..STATES {
        let state = states.state(i);
        let expected = 1.0 / (2.0 * friction(i) * 9.81);
        assert!(
            (state.q[0] - expected).abs() < 2e-3 * expected.max(0.5),
            "{i}: {} {expected}",
            state.q[0]
        );
        assert!((state.q[2] - RADIUS - height(i)).abs() < 1e-3 && state.v[0].abs() < 1e-6);
    }
}

#[test]
fn forces_and_masses_are_those_of_each_state() {
    let model = ball().with_gravity(Vector3::zeros());
    let place = Anchor::frame(&model, "ball").expect("a link");
    let pull = Force::new(Vector3::x(), Vector3::zeros());
    let pull = ExternalForce::constant(place, pull, Representation::Mixed);
    let simulator = Simulator::new(model)
        .with_time_step(1e-3)
        .with_external_forces(vec![pull]);
    let newtons = |i: usize| 1.0 + i as f64;
    let mut batch = BatchSimulator::of_parameters(
        &simulator,
        &rows(&simulator, &[("external force 0: fx", &newtons)]),
    );
    let mut states = batch.states(&vec![simulator.neutral_state(); STATES]);
    batch.step_times(&mut states, &[], 500);
    for i in 0..STATES {
        assert!((states.state(i).v[0] - 0.25 * newtons(i)).abs() < 1e-12);
    }
}

#[test]
fn several_steps_are_as_many_single_ones() {
    let simulator = Simulator::new(samples::cartpole()).with_time_step(0.01);
    let mut batch = BatchSimulator::new(simulator.clone(), STATES);
    let starts = vec![State::new(&[0.1, 0.3], &[0.0, 0.2]); STATES];
    let inputs: Vec<f64> = (0..STATES * 2).map(|k| (k as f64).sin()).collect();
    let (mut one, mut other) = (batch.states(&starts), batch.states(&starts));
    batch.step_times(&mut one, &inputs, 7);
    (0..7).for_each(|_| batch.step(&mut other, &inputs));
    assert_eq!(one.to_vec(), other.to_vec());
    batch.step_times(&mut one, &inputs, 0);
    assert_eq!(one.to_vec(), other.to_vec());
}

#[test]
fn states_that_are_set_run_again_and_others_stay() {
    let simulator = Simulator::new(samples::pendulum()).with_divergence_bound(5.0);
    let mut batch = BatchSimulator::new(simulator.clone(), STATES);
    let mut states = batch.states(&vec![simulator.neutral_state(); STATES]);
    let mut inputs = vec![0.0; STATES];
    inputs[3] = 1e6;
    batch.step(&mut states, &inputs);
    assert!(matches!(states.status(3), RolloutStatus::Diverged { .. }));
    let before = states.to_vec();
    let mask: Vec<bool> = (0..STATES).map(|i| i % 3 == 0).collect();
    for i in (0..STATES).filter(|&i| mask[i]) {
        let mut state = states.state(i);
        state.q[0] = 0.1 * i as f64;
        states.set(i, &state);
    }
    for (i, before) in before.iter().enumerate() {
        let q = if mask[i] { 0.1 * i as f64 } else { before.q[0] };
        assert_eq!(
            (states.state(i).q[0], states.state(i).v[0]),
            (q, before.v[0])
        );
    }
    assert_eq!(states.status(3), RolloutStatus::Completed);
}

#[test]
#[should_panic(expected = "are not whole rows of the")]
fn rows_that_are_not_whole_are_refused() {
    let simulator = Simulator::new(samples::pendulum());
    let _ = BatchSimulator::of_parameters(&simulator, &[1.0; 7]);
}

#[test]
#[should_panic(expected = "mass")]
fn parameters_out_of_their_domain_are_refused() {
    let simulator = Simulator::new(samples::pendulum());
    let mut row = simulator.parameters().as_slice().to_vec();
    let mass = simulator
        .parameter_layout()
        .names()
        .iter()
        .position(|name| name.ends_with(": mass"));
    row[mass.expect("a mass")] = f64::NAN;
    let _ = BatchSimulator::of_parameters(&simulator, &row);
}
