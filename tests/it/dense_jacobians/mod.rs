//! Jacobians by the implicit function theorem beside those of the step on dense dual numbers.

mod dense;
mod forces;
mod over;
mod rate;
mod runge_kutta_4;

use dualbody::constraint::{Anchor, Constraint};
use dualbody::contact::{
    ContactLaw, Contacts, HuntCrossley, RelaxedRigid, Rigid, SoftContact, Terrain,
};
use dualbody::model::{Spring, samples};
use dualbody::sim::{Actuation, Actuator, CoulombFriction, Integrator, PositionLimits, Servo};
use dualbody::{Model, Simulator, State};
use rand::SeedableRng;
use rand::rngs::Xoshiro256PlusPlus;

use crate::common::asset;

/// Largest difference of A and B, beside their largest entry.
pub(super) fn difference(simulator: &Simulator, state: &State, u: &[f64]) -> f64 {
    let actual = simulator.linearize(state, u);
    let expected = dense::linearize(simulator, state, u);
    let pairs = actual.a.iter().zip(&expected.a);
    let pairs: Vec<_> = pairs.chain(actual.b.iter().zip(&expected.b)).collect();
    let largest = |x: &dyn Fn(&(&f64, &f64)) -> f64| {
        let values = pairs.iter().map(x);
        values.fold(0.0, |most, x| if x > most || x.is_nan() { x } else { most })
    };
    largest(&|(a, b)| (*a - *b).abs()) / (1.0 + largest(&|(_, b)| b.abs()))
}

pub(super) fn inputs(simulator: &Simulator) -> Vec<f64> {
    (0..simulator.nu()).map(|k| (k as f64).sin()).collect()
}

pub(super) const EULER: [Integrator; 2] =
    [Integrator::SemiImplicitEuler, Integrator::ImplicitVelocity];

/// Servos, friction, smoothed and exact, and stops in all joints that can have them, springs and dampers.
fn with_stiff_joints(model: Model) -> Simulator {
    let spring = Spring {
        stiffness: 300.0,
        rest: 0.1,
    };
    let with_position = model
        .bodies()
        .iter()
        .filter(|body| body.coupling.is_none() && body.joint.nq() == 1);
    let joints: Vec<usize> = with_position.map(|body| body.v).collect();
    let model = joints.iter().fold(model, |model, &k| {
        model.with_damping(k, 3.0).with_spring(k, spring)
    });
    let ideal = Actuation::from_model(&model);
    let with_friction = ideal.actuators().iter().enumerate();
    let with_friction = with_friction.map(|(k, actuator)| Actuator {
        friction: Some(match k % 2 {
            0 => CoulombFriction::smoothed(0.5, 0.02),
            _ => CoulombFriction::exact(5.0),
        }),
        servo: match k % 5 {
            1 | 2 if joints.contains(&k) => Some(Servo::position(1e4, 30.0).with_gear(-0.7)),
            3 => Some(Servo::velocity(50.0)),
            _ => None,
        },
        effort: (k % 2 == 1).then_some(4.0),
        ..*actuator
    });
    let actuation = ideal.with_actuators(&with_friction.collect::<Vec<_>>());
    Simulator::new(model).with_actuation(actuation)
}

#[test]
fn jacobians_without_contact_equal_those_of_the_dense_step() {
    for (seed, integrator) in (0..8).flat_map(|seed| EULER.map(|integrator| (seed, integrator))) {
        let tree = samples::random_tree(12, seed);
        for simulator in [Simulator::new(tree.clone()), with_stiff_joints(tree)] {
            let simulator = simulator.with_time_step(0.01).with_integrator(integrator);
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
            let state = State::random(simulator.model(), &mut rng, 2.0);
            let error = difference(&simulator, &state, &inputs(&simulator));
            assert!(error < 1e-12, "seed {seed} {integrator:?}: {error:e}");
        }
    }
}

#[test]
fn jacobians_where_something_whirls_equal_those_of_the_dense_step() {
    let law = ContactLaw::RelaxedRigid(RelaxedRigid::default());
    for (seed, integrator) in (0..6).flat_map(|seed| EULER.map(|integrator| (seed, integrator))) {
        let tree = samples::random_tree(10, seed);
        let ground = Terrain::flat(-0.5);
        let on_ground = simulator("quadruped", &ground, law);
        for simulator in [
            Simulator::new(tree.clone()),
            with_narrow_stops(tree),
            on_ground,
        ] {
            let simulator = simulator.with_time_step(1e-3).with_integrator(integrator);
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
            // Angles in a step where velocity forces are those of the start, in between, and those of the middle.
            for speed in [90.0, 120.0, 150.0, 190.0, 300.0] {
                let mut state = State::random(simulator.model(), &mut rng, speed);
                let k = last_angle(simulator.model());
                state.v[k] = -speed;
                let error = difference(&simulator, &state, &inputs(&simulator));
                let name = simulator.model().name();
                assert!(
                    error < 1e-10,
                    "{name} {seed} {integrator:?} {speed}: {error:e}"
                );
            }
        }
    }
}

/// The last coordinate that is an angle.
pub(super) fn last_angle(model: &Model) -> usize {
    let axes = |body: &dualbody::model::Body<f64>| {
        let angular = body.joint.axes().enumerate();
        let angular = angular.filter(|(_, axis)| axis.is_angular());
        angular.map(|(k, _)| body.v + k).last()
    };
    let independent = model.bodies().iter().filter(|body| body.coupling.is_none());
    independent
        .rev()
        .find_map(axes)
        .expect("a joint that turns")
}

/// Narrow ends, so that a random state is beyond many of them, with stops that are far too stiff for the step to resolve.
fn with_narrow_stops(model: Model) -> Simulator {
    let simulator = with_stiff_joints(model);
    let actuation = simulator.actuation().unwrap();
    let positions = simulator.model().bodies().iter();
    let with_position: Vec<usize> = positions
        .filter(|body| body.joint.nq() == 1 && body.coupling.is_none())
        .map(|body| body.v)
        .collect();
    let actuators: Vec<_> = (actuation.actuators().iter().enumerate())
        .map(|(k, actuator)| Actuator {
            position: with_position.contains(&k).then_some(PositionLimits {
                lower: Some(-0.1),
                upper: Some(0.2),
                stop: HuntCrossley {
                    stiffness_exponent: 0.5,
                    damping_exponent: 0.5,
                    ..HuntCrossley::linear(1e6, 1e4)
                },
            }),
            ..*actuator
        })
        .collect();
    let actuation = actuation.with_actuators(&actuators);
    simulator.with_actuation(actuation)
}

/// Indices in q and v of the joints that have stops.
fn stopped(simulator: &Simulator) -> impl Iterator<Item = (usize, usize)> {
    let actuation = simulator.actuation().expect("stops");
    let bodies = simulator.model().bodies().iter();
    let with_stops = bodies.filter(|body| {
        body.coupling.is_none()
            && body.joint.nv() == 1
            && actuation.actuators()[body.v].position.is_some()
    });
    with_stops.map(|body| (body.q, body.v))
}

#[test]
fn jacobians_against_stops_that_push_or_are_let_go_equal_those_of_the_dense_step() {
    let (mut pushing, mut let_go) = (0, 0);
    for (seed, integrator) in (0..8).flat_map(|seed| EULER.map(|integrator| (seed, integrator))) {
        let simulator = with_narrow_stops(samples::random_tree(12, seed));
        let simulator = simulator.with_time_step(0.01).with_integrator(integrator);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        for speed in [0.0, 2.0, 20.0] {
            let mut state = State::random(simulator.model(), &mut rng, speed);
            for (q, v) in stopped(&simulator).skip(1).step_by(2) {
                // A little beyond an end, which a step may leave.
                state.q[q] = 0.205;
                state.v[v] = -state.v[v].abs();
            }
            let u = inputs(&simulator);
            let error = difference(&simulator, &state, &u);
            assert!(error < 1e-11, "seed {seed} {integrator:?}: {error:e}");
            for (q, v) in stopped(&simulator) {
                let (before, after) = (state.q[q], state.q[q] + 0.01 * state.v[v]);
                let inside = |q: f64| (-0.1..=0.2).contains(&q);
                pushing += usize::from(!inside(before) && !inside(after));
                let_go += usize::from(!inside(before) && inside(after));
            }
        }
    }
    assert!(pushing > 50 && let_go > 50, "{pushing} {let_go}");
}

pub(super) fn laws() -> [ContactLaw; 3] {
    [
        ContactLaw::Rigid(Rigid {
            restitution: 0.3,
            ..Rigid::default()
        }),
        ContactLaw::RelaxedRigid(RelaxedRigid::default()),
        ContactLaw::Soft(SoftContact::estimate(10.0, 4, 1e-3)),
    ]
}

pub(super) fn simulator(robot: &str, terrain: &Terrain, law: ContactLaw) -> Simulator {
    let model = asset(&format!("{robot}.urdf"));
    let name = |link: &dualbody::model::Link| model.frames()[link.frame.0].name.clone();
    let names: Vec<String> = model.links().iter().map(name).collect();
    let feet = |link: &&str| link.contains("foot") || link.contains("ankle");
    let feet: Vec<&str> = names.iter().map(String::as_str).filter(feet).collect();
    let contacts = Contacts::new(&model, terrain.clone(), law);
    let contacts = if feet.is_empty() {
        contacts
    } else {
        contacts.with_links(&model, &feet).unwrap()
    };
    let stiff = robot == "quadruped";
    let simulator = if stiff {
        with_stiff_joints(model)
    } else {
        Simulator::new(model)
    };
    simulator.with_contacts(contacts)
}

/// The robot lowered until its lowest point is a little in the ground.
pub(super) fn lower(simulator: &Simulator, state: &mut State) {
    let (model, contacts) = (simulator.model(), simulator.contacts().unwrap());
    for _ in 0..20 {
        let points = contacts.states(model, state.q.as_slice(), state.v.as_slice());
        let depths = points.iter().map(|point| point.depth);
        state.q[2] += depths.fold(f64::NEG_INFINITY, f64::max) - 5e-4;
    }
}

#[test]
fn jacobians_with_contact_equal_those_of_the_dense_step() {
    /// Robots with tolerances. Where forces are redundant, the ridge that makes them unique magnifies rounding.
    const ROBOTS: [(&str, f64); 4] = [
        ("sphere", 1e-12),
        ("box", 1e-6),
        ("quadruped", 1e-12),
        ("humanoid", 1e-11),
    ];
    let terrains = [Terrain::flat(0.0), Terrain::incline(0.2)];
    for (robot, tolerance) in ROBOTS {
        let (mut touching, mut rng) = (0, Xoshiro256PlusPlus::seed_from_u64(7));
        let kinds = terrains.iter().flat_map(|t| laws().map(|law| (t, law)));
        for (terrain, law) in kinds {
            for integrator in EULER {
                let simulator = simulator(robot, terrain, law).with_integrator(integrator);
                let u = inputs(&simulator);
                let moments = [(0.0, false), (0.05, false), (0.0, true), (2.0, true)];
                for (of, (speed, tilted)) in moments.into_iter().enumerate() {
                    let mut state = simulator.neutral_state();
                    let random = State::random(simulator.model(), &mut rng, speed);
                    state.v.copy_from(&random.v);
                    if tilted {
                        state.q.copy_from(&random.q);
                    }
                    lower(&simulator, &mut state);
                    state.q[2] += if of == 3 && robot == "box" { 1.0 } else { 0.0 }; // in flight
                    let bristles = state.contact.iter_mut().enumerate();
                    bristles.for_each(|(k, m)| *m = 1e-5 * (k as f64).sin());
                    let forces = simulator.contact_report(&state, &u).forces;
                    touching += forces.iter().filter(|f| f.norm() > 0.0).count();
                    let error = difference(&simulator, &state, &u);
                    let case = format!("{robot} {terrain:?} {law:?} {integrator:?}");
                    assert!(error < tolerance, "{case} at {speed}, {tilted}: {error:e}");
                }
            }
        }
        assert!(touching > 30, "{robot}: {touching}");
    }
}

#[test]
fn jacobians_with_constraints_equal_those_of_the_dense_step() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
    for (law, integrator) in laws().iter().flat_map(|&law| EULER.map(|by| (law, by))) {
        let simulator = simulator("quadruped", &Terrain::incline(0.1), law);
        let model = simulator.model();
        let mut state = simulator.neutral_state();
        let random = State::random(model, &mut rng, 0.5);
        state.v.copy_from(&random.v);
        lower(&simulator, &mut state);
        let foot = |name: &str| Anchor::frame(model, name).unwrap();
        let world = Anchor::world();
        let place = world.brought_to(&foot("FR_foot"), model, state.q.as_slice());
        let tied = [
            Constraint::weld([foot("FR_foot"), place.moved([1e-3, 0.0, 0.0])]),
            Constraint::distance([foot("FL_foot"), foot("RL_foot")], 0.35),
            Constraint::coupler(model, ["RR_hip_joint", "RL_hip_joint"], -0.5, 0.1).unwrap(),
        ];
        let [weld, rod, coupler] = tied.clone();
        let yielding = [
            weld.with_spring(2e3, 30.0),
            rod.with_largest_force(20.0),
            coupler.with_spring(50.0, 1.0).with_largest_force(1.0),
        ];
        for tied in [tied, yielding] {
            let simulator = simulator.clone().with_constraints(tied.to_vec());
            let simulator = simulator.with_integrator(integrator);
            let error = difference(&simulator, &state, &inputs(&simulator));
            assert!(error < 1e-9, "{law:?} {integrator:?}: {error:e}");
        }
    }
}
