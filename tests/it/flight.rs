//! Robots with contacts in states in which nothing touches: they move as robots without contacts do, and as they do beside a ball on the ground, for whose sake a
//! solver finds all forces.

use dualbody::contact::{ContactLaw, Contacts, RelaxedRigid, Rigid, Terrain};
use dualbody::linearize::LinearizeScratch;
use dualbody::model::{Mass, Object, World};
use dualbody::sim::{
    Actuation, Actuator, BatchSimulator, CoulombFriction, Sensor, SensorScratch, Sensors, Servo,
    StepScratch,
};
use dualbody::spatial::Transform;
use dualbody::{Integrator, Linearization, Model, Simulator, State};
use nalgebra::{DMatrix, DVector};

use crate::common::quadruped::{FEET, crouching};
use crate::common::{OTHER_ALGORITHM, SAME_ALGEBRA, asset, generator, relative_error};

/// First coordinate of the legs.
const LEGS: usize = 6;

fn laws() -> [ContactLaw; 2] {
    [
        ContactLaw::RelaxedRigid(RelaxedRigid::default()),
        ContactLaw::Rigid(Rigid::default()),
    ]
}

/// Contact models with integrators; rigid contact acts over a step.
fn methods() -> [(ContactLaw, Integrator); 3] {
    let [relaxed, rigid] = laws();
    [
        (relaxed, Integrator::SemiImplicitEuler),
        (relaxed, Integrator::RungeKutta4),
        (rigid, Integrator::SemiImplicitEuler),
    ]
}

/// Joint limits alone; with servos that reach their motor limits; with dry friction besides.
fn actuations(model: &Model) -> [Actuation; 3] {
    let own = Actuation::from_model(model);
    let servo = Servo::position(60.0, 2.0).with_force_range(-14.0, 9.0);
    let with = |servo: Option<Servo>, friction: Option<CoulombFriction>| {
        let mut actuators = own.actuators().to_vec();
        for own in &mut actuators[LEGS..LEGS + 12] {
            let position = own.position;
            *own = Actuator {
                servo,
                friction,
                position,
                ..Actuator::default()
            };
        }
        own.clone().with_actuators(&actuators)
    };
    let friction = CoulombFriction::exact(0.6);
    [
        with(None, None),
        with(Some(servo), None),
        with(Some(servo), Some(friction)),
    ]
}

fn feet(model: &Model, prefix: &str, law: ContactLaw) -> Contacts {
    let names = FEET.map(|foot| format!("{prefix}{foot}"));
    let mut names: Vec<&str> = names.iter().map(String::as_str).collect();
    names.extend((!prefix.is_empty()).then_some("z"));
    let contacts = Contacts::new(model, Terrain::flat(0.0), law);
    contacts.with_links(model, &names).expect("feet")
}

/// Simulators of the quadruped without contacts and with them.
fn pairs(law: ContactLaw, integrator: Integrator) -> Vec<[Simulator; 2]> {
    let model = asset("quadruped.urdf");
    let contacts = feet(&model, "", law);
    let pair = |actuation| {
        let plain = Simulator::new(model.clone())
            .with_actuation(actuation)
            .with_integrator(integrator)
            .with_time_step(2e-3);
        let with = plain.clone().with_contacts(contacts.clone());
        [plain, with]
    };
    actuations(&model).map(pair).into()
}

/// A state with feet at least so high, m; joints are beyond their limits or on the way there.
fn flying(simulator: &Simulator, seed: u64, height: f64) -> (State, DVector<f64>) {
    let mut state = State::random(simulator.model(), &mut generator(seed), 3.0);
    state.q[2] = 1.0 + height;
    let near = |k: usize| 0.3 * ((7 * k) as f64 + seed as f64).sin();
    let u = DVector::from_fn(12, |k, _| [0.0, 0.8, -1.6][k % 3] + near(k));
    let actuators = simulator.actuation().expect("limits").actuators();
    for (k, own) in actuators[LEGS..].iter().enumerate().step_by(2) {
        let limits = own.position.expect("limits");
        let (end, inward) = match (k as u64 + seed) % 4 {
            0 => (limits.lower, 1.0),
            _ => (limits.upper, -1.0),
        };
        state.q[7 + k] = end.expect("an end") + inward * 0.02 * near(k);
    }
    (simulator.state(state.q.as_slice(), state.v.as_slice()), u)
}

fn bits(state: &State) -> Vec<u64> {
    state.numbers().map(|x| x.to_bits()).collect()
}

#[test]
fn steps_are_those_of_the_robot_without_contacts_bit_for_bit() {
    for (law, integrator) in methods() {
        for [plain, with] in pairs(law, integrator) {
            let mut scratch = StepScratch::new(&with);
            for seed in 0..30 {
                let (state, u) = flying(&plain, seed, 0.5);
                let mut next = with.neutral_state();
                with.step_into(&state, u.as_slice(), &mut scratch, &mut next);
                let expected = plain.step(&state, u.as_slice());
                assert_eq!(bits(&next), bits(&expected), "{law:?}, {seed}");
            }
        }
    }
}

/// The quadruped above a ball that lies on the ground.
fn beside_a_ball(law: ContactLaw, which: usize) -> Simulator {
    let mut world = World::new("world");
    let on_ground = Transform::from_translation([5.0, 0.0, 0.0999].into());
    let ball = Object::free(Mass::Kilograms(1.0)).at(on_ground);
    let robot = asset("quadruped.urdf");
    world.add(&robot, "a/", &Transform::identity()).unwrap();
    world.add_sphere("z", 0.1, &ball).unwrap();
    let model = world.build().unwrap();
    let contacts = feet(&model, "a/", law);
    let [actuation, ..] = actuations(&model);
    let mut actuators = actuation.actuators().to_vec();
    let own = &actuations(&robot)[which];
    actuators[..LEGS + 12].copy_from_slice(own.actuators());
    Simulator::new(model)
        .with_actuation(actuation.with_actuators(&actuators))
        .with_contacts(contacts)
        .with_time_step(2e-3)
}

#[test]
fn forward_dynamics_and_the_solver_find_the_same_motion() {
    let mut pushed = 0;
    for law in laws() {
        let all = pairs(law, Integrator::SemiImplicitEuler);
        for (which, [_, alone]) in all.into_iter().enumerate() {
            let both = beside_a_ball(law, which);
            let free = alone
                .clone()
                .with_actuation(Actuation::ideal(alone.model()));
            for seed in 0..20 {
                let (state, u) = flying(&alone, seed, 0.5);
                let mut start = both.neutral_state();
                start.q.rows_mut(0, 19).copy_from(&state.q);
                start.v.rows_mut(0, 18).copy_from(&state.v);
                let report = both.contact_report(&start, u.as_slice());
                assert!(report.forces.iter().any(|f| f.z > 1.0), "the ball");
                let (one, two) = (
                    alone.step(&state, u.as_slice()),
                    both.step(&start, u.as_slice()),
                );
                let error = (&one.v - two.v.rows(0, 18)).amax() / (1.0 + one.v.amax());
                assert!(
                    error < OTHER_ALGORITHM,
                    "{law:?}, {which}, {seed}: {error:e}"
                );
                let without = free.step(&state, &[0.0; 12]);
                pushed += usize::from((&one.v - without.v).amax() > 0.1);
            }
        }
    }
    assert!(pushed > 60, "{pushed}");
}

// The memory has been used for states on the ground, and is used for them again.
#[test]
fn derivatives_are_those_of_the_robot_without_contacts() {
    for (law, integrator) in methods() {
        for [plain, with] in pairs(law, integrator) {
            let mut scratch = LinearizeScratch::new(&with);
            let mut out = Linearization::zeros(&with);
            for seed in 0..6 {
                let (state, u) = flying(&plain, seed, 0.5);
                let ground = crouching(&with, 0.25);
                with.linearize_into(&ground, u.as_slice(), &mut scratch, &mut out);
                assert_eq!(out, with.linearize(&ground, u.as_slice()));
                with.linearize_into(&state, u.as_slice(), &mut scratch, &mut out);
                let expected = plain.linearize(&state, u.as_slice());
                for (own, expected) in [(&out.a, &expected.a), (&out.b, &expected.b)] {
                    let error = relative_error(own, expected);
                    assert!(error < SAME_ALGEBRA, "{law:?}, {seed}: {error:e}");
                }
                assert_gradient(&plain, &with, &state, &u, &out.a);
            }
        }
    }
}

/// The gradient in state, input and parameters of the robot against that without contacts; in those of contacts it is zero.
fn assert_gradient(
    plain: &Simulator,
    with: &Simulator,
    state: &State,
    u: &DVector<f64>,
    a: &DMatrix<f64>,
) {
    let weights = DVector::from_fn(a.nrows(), |k, _| (1.3 * k as f64).sin());
    let own = with.vjp(state, u.as_slice(), weights.as_slice());
    let expected = plain.vjp(state, u.as_slice(), weights.as_slice());
    let close = |x: &DVector<f64>, y: &DVector<f64>| {
        let error = (x - y).amax() / (1.0 + y.amax());
        assert!(error < SAME_ALGEBRA, "{error:e}");
    };
    close(&own.state, &a.tr_mul(&weights));
    close(&own.state, &expected.state);
    close(&own.input, &expected.input);
    let (names, expected_names) = (with.parameter_layout(), plain.parameter_layout());
    let mut shared = 0;
    for (k, &x) in own.parameters.iter().enumerate() {
        let name = &names.names()[k];
        let same = expected_names.find(name).ok();
        let y = same.map_or(0.0, |k| expected.parameters[k]);
        assert!(
            (x - y).abs() < SAME_ALGEBRA * (1.0 + y.abs()),
            "{name}: {x}, not {y}"
        );
        shared += usize::from(same.is_some());
    }
    assert_eq!(shared, expected.parameters.len());
}

// Groups of lanes with states in flight, on the ground, and at heights between.
#[test]
fn lanes_that_fly_beside_lanes_that_touch_give_the_bits_of_single_steps() {
    for law in laws() {
        for [_, own] in pairs(law, Integrator::SemiImplicitEuler) {
            let start = |k: usize| match k % 3 {
                0 => flying(&own, k as u64, 0.3),
                k => (crouching(&own, 0.22 + 0.05 * k as f64), DVector::zeros(12)),
            };
            let all: Vec<_> = (0..11).map(start).collect();
            let starts: Vec<State> = all.iter().map(|(state, _)| state.clone()).collect();
            let inputs: Vec<f64> = all.iter().flat_map(|(_, u)| u.iter().copied()).collect();
            let link = |name: &str| own.model().frame(name).expect("a link");
            let sensors = [
                Sensor::Accelerometer(link("trunk")),
                Sensor::ContactForce(link("FR_foot")),
                Sensor::Wrench(link("FR_calf")),
            ];
            let sensors = Sensors::new(own.model(), ["a", "b", "c"].into_iter().zip(sensors));
            let mut batch = BatchSimulator::new(own.clone(), starts.len());
            let mut states = batch.states(&starts);
            let mut readings = vec![0.0; sensors.len() * starts.len()];
            let mut before = starts;
            let (mut scratch, mut memory) = (StepScratch::new(&own), SensorScratch::new(&own));
            for step in 0..25 {
                batch.step_and_read(&mut states, &inputs, &sensors, &mut readings);
                for (k, state) in before.iter_mut().enumerate() {
                    let (u, mut next) = (&inputs[12 * k..][..12], own.neutral_state());
                    own.step_into(state, u, &mut scratch, &mut next);
                    let mut y = vec![0.0; sensors.len()];
                    sensors.read_step_into(&own, state, u, &scratch, &mut memory, &mut y);
                    assert_eq!(bits(&states.state(k)), bits(&next), "{law:?}, {k}, {step}");
                    let read = &readings[sensors.len() * k..][..sensors.len()];
                    assert_eq!(read, y, "{law:?}, {k}, {step}");
                    *state = next;
                }
            }
        }
    }
}
