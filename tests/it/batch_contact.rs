//! Contact in batches: the same bits as alone, independent of contacts in other lanes.

use dualbody::constraint::Constraint;
use dualbody::contact::{ContactLaw, Contacts, RelaxedRigid, Rigid, SoftContact, Terrain};
use dualbody::model::{LinkSpec, Mass};
use dualbody::sim::{Actuation, BATCH_WIDTH, BatchSimulator};
use dualbody::{Integrator, Model, Simulator, State};
use nalgebra::{UnitQuaternion, Vector3};

use crate::common::ground::{body, hills, waves};
use crate::common::{asset, generator};

const STATES: usize = BATCH_WIDTH + 3;
const STEPS: usize = 60;
/// Edge or diameter of the bodies, m.
const SIZE: f64 = 0.1;

fn bodies() -> [Model; 4] {
    let mass = Mass::Kilograms(1.0);
    [
        LinkSpec::solid_sphere("ball", SIZE, mass),
        LinkSpec::solid_capsule("capsule", SIZE, 3.0 * SIZE, mass),
        LinkSpec::solid_cylinder("cylinder", SIZE, SIZE, mass),
        LinkSpec::solid_box("box", [SIZE, 2.0 * SIZE, SIZE], mass),
    ]
    .map(body)
}

fn laws() -> [ContactLaw; 3] {
    [
        ContactLaw::Soft(SoftContact::estimate(1.0, 4, 1e-3)),
        ContactLaw::RelaxedRigid(RelaxedRigid::default()),
        ContactLaw::Rigid(Rigid {
            restitution: 0.3,
            ..Rigid::default()
        }),
    ]
}

/// Standing, lying and leaning, some just above the ground, some on its very surface, some in it, and some so high that
/// they never touch.
fn starts(simulator: &Simulator) -> Vec<State> {
    let (model, contacts) = (simulator.model(), simulator.contacts().expect("contacts"));
    let start = |k: usize| {
        let at = k as f64;
        let axis = Vector3::new((1.3 * at).sin(), (0.7 * at).cos(), 0.2);
        let angle = [0.0, 0.3 * at, std::f64::consts::FRAC_PI_2][k % 3];
        let turn = UnitQuaternion::new(axis.normalize() * angle);
        let v = [0.3, -0.2, 0.1 * at.sin(), 2.0 * at.cos(), 0.5, -1.0];
        let (x, y) = (0.03 * at, -0.05 * at);
        let mut q = [x, y, 0.3, turn.w, turn.i, turn.j, turn.k];
        let depth = [1e-3, 0.0, -1e-3, -10.0][k % 4];
        for _ in 0..3 {
            let points = contacts.states(model, &q, &v);
            let deepest = points.iter().map(|p| p.depth).fold(f64::MIN, f64::max);
            q[2] += deepest - depth;
        }
        simulator.state(&q, &v)
    };
    (0..STATES).map(start).collect()
}

fn bits(state: &State) -> Vec<u64> {
    let numbers = state.q.iter().chain(&state.v).chain(&state.contact);
    numbers.map(|x| x.to_bits()).collect()
}

fn assert_same_bits(simulator: &Simulator, what: &str) {
    assert_same_bits_from(simulator, &starts(simulator), what);
}

fn assert_same_bits_from(simulator: &Simulator, starts: &[State], what: &str) {
    let mut batch = BatchSimulator::new(simulator.clone(), starts.len()).with_threads(1);
    let rollout = batch.rollout(starts, STEPS, |_, _, _| {});
    for (i, start) in starts.iter().enumerate() {
        let alone = simulator.rollout(start, STEPS, |_, _, _| {});
        for (k, state) in alone.states.iter().enumerate() {
            let abreast = rollout.state(i, k);
            let same = bits(&abreast) == bits(state);
            assert!(
                same,
                "{what}, state {i}, step {k}: {abreast:?}, not {state:?}"
            );
        }
    }
}

/// Robots whose joints come to their stops while they touch the ground, or while a loop is closed.
fn stopped() -> Vec<Simulator> {
    let quadruped = asset("quadruped.urdf");
    let feet = ["FR_foot", "FL_foot", "RR_foot", "RL_foot", "trunk"];
    let with = |law: ContactLaw| {
        let contacts = Contacts::new(&quadruped, Terrain::flat(0.0), law);
        let contacts = contacts.with_links(&quadruped, &feet).expect("links");
        Simulator::new(quadruped.clone())
            .with_actuation(Actuation::from_model(&quadruped))
            .with_contacts(contacts)
    };
    let mut all: Vec<Simulator> = laws().map(with).into();
    let names = quadruped.joint_names();
    let coupler = Constraint::coupler(&quadruped, [names[0], names[3]], 1.0, 0.0);
    let coupled = all[1]
        .clone()
        .with_constraints(vec![coupler.expect("joints")]);
    all.push(coupled);
    all
}

#[test]
fn stops_beside_contact_and_constraints_in_a_batch_equal_those_alone_bit_for_bit() {
    for simulator in stopped() {
        for integrator in [Integrator::SemiImplicitEuler, Integrator::ImplicitVelocity] {
            let simulator = simulator.clone().with_integrator(integrator);
            let starts = (0..STATES).map(|k| {
                let mut start = State::random(simulator.model(), &mut generator(k as u64), 1.0);
                start.q[2] = 0.1 * (k % 5) as f64;
                start.v *= 5.0;
                simulator.state(start.q.as_slice(), start.v.as_slice())
            });
            assert_same_bits_from(&simulator, &starts.collect::<Vec<_>>(), "quadruped");
        }
    }
}

fn assert_on_all_grounds(shape: usize) {
    let grounds = [
        ("plane", Terrain::flat(0.0)),
        ("incline", Terrain::incline(0.2)),
        ("grid", hills()),
        ("function", waves()),
    ];
    let model = &bodies()[shape];
    for (name, ground) in grounds {
        for law in laws() {
            let contacts = Contacts::new(model, ground.clone(), law);
            for integrator in [Integrator::SemiImplicitEuler, Integrator::ImplicitVelocity] {
                let simulator = Simulator::new(model.clone())
                    .with_contacts(contacts.clone())
                    .with_integrator(integrator);
                assert_same_bits(&simulator, &format!("{name}, {law:?}, {integrator:?}"));
            }
        }
    }
}

#[test]
fn spheres_in_a_batch_equal_spheres_alone_bit_for_bit() {
    assert_on_all_grounds(0);
}

#[test]
fn capsules_in_a_batch_equal_capsules_alone_bit_for_bit() {
    assert_on_all_grounds(1);
}

#[test]
fn cylinders_in_a_batch_equal_cylinders_alone_bit_for_bit() {
    assert_on_all_grounds(2);
}

#[test]
fn boxes_in_a_batch_equal_boxes_alone_bit_for_bit() {
    assert_on_all_grounds(3);
}
