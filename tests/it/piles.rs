//! Many bodies that rest on each other: every step finds its forces, they balance, and derivatives go through islands of many contacts.

use dualbody::cone::Status;
use dualbody::contact::{
    CollisionOptions, ContactLaw, RelaxedRigid, Rigid, SolverOptions, Terrain,
};
use dualbody::model::{Mass, Object, World};
use dualbody::sim::StepScratch;
use dualbody::spatial::Transform;
use dualbody::{Contacts, Lanes, Scalar, Simulator, State};
use nalgebra::DVector;

use crate::common::ground::difference;

fn at(x: f64, y: f64, z: f64) -> Transform<f64> {
    Transform::from_translation([x, y, z].into())
}

fn simulator(world: &World, law: ContactLaw, dt: f64) -> Simulator {
    simulator_with(world, law, dt, SolverOptions::default())
}

fn simulator_with(world: &World, law: ContactLaw, dt: f64, options: SolverOptions) -> Simulator {
    let model = world.build().expect("a world");
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law)
        .with_collisions(&model, law, &CollisionOptions::default())
        .expect("links")
        .with_solver_options(options);
    Simulator::new(model)
        .with_contacts(contacts)
        .with_time_step(dt)
}

fn stack(boxes: usize, apart: f64) -> World {
    let mut world = World::default();
    for k in 0..boxes {
        let z = 0.1 + (0.2 + apart) * k as f64;
        let object = Object::free(Mass::Kilograms(1.0)).at(at(0.0, 0.0, z));
        let name = format!("box {k:02}");
        world.add_box(&name, [0.2; 3], &object).expect("a box");
    }
    world
}

/// Spheres and boxes, in turn, that fall between four walls.
fn bin(bodies: usize) -> World {
    let mut world = World::default();
    let walls = [
        (0.5, 0.0, 0.1, 1.2),
        (-0.5, 0.0, 0.1, 1.2),
        (0.0, 0.5, 1.2, 0.1),
        (0.0, -0.5, 1.2, 0.1),
    ];
    for (k, (x, y, width, length)) in walls.into_iter().enumerate() {
        let object = Object::fixed().at(at(x, y, 0.5));
        let name = format!("wall {k}");
        world
            .add_box(&name, [width, length, 1.0], &object)
            .expect("a wall");
    }
    for k in 0..bodies {
        let (i, j, layer) = (k % 3, k / 3 % 3, k / 9);
        let x = 0.25 * i as f64 - 0.25 + 0.01 * (k % 7) as f64;
        let z = 0.2 + 0.22 * layer as f64 + 0.003 * (k % 9) as f64;
        let place = at(x, 0.25 * j as f64 - 0.25, z);
        let (name, object) = (
            format!("body {k:02}"),
            Object::free(Mass::Kilograms(1.0)).at(place),
        );
        let added = match k % 2 {
            0 => world.add_sphere(&name, 0.1, &object),
            _ => world.add_box(&name, [0.15; 3], &object),
        };
        added.expect("a body");
    }
    world
}

/// The state after so many steps, and the worst status on the way.
fn run(simulator: &Simulator, steps: usize) -> (State<f64>, Status) {
    let mut scratch = StepScratch::<f64>::new(simulator);
    let (mut state, mut next) = (simulator.neutral_state(), simulator.neutral_state());
    let mut worst = Status::Converged;
    for step in 0..steps {
        simulator.step_into(&state, &[], &mut scratch, &mut next);
        std::mem::swap(&mut state, &mut next);
        worst = worst.max(scratch.solver_status(0));
        assert!(state.v.iter().all(|v| v.is_finite()), "{step}");
    }
    (state, worst)
}

fn rigid() -> ContactLaw {
    ContactLaw::Rigid(Rigid::default())
}

fn relaxed() -> ContactLaw {
    ContactLaw::RelaxedRigid(RelaxedRigid::default())
}

#[test]
fn ten_boxes_stand_without_creep() {
    for dt in [1e-3, 5e-3] {
        let simulator = simulator(&stack(10, 0.0), rigid(), dt);
        let (state, status) = run(&simulator, 100);
        assert!(status <= Status::Acceptable, "{dt}: {status:?}");
        let moved = (&state.q - &simulator.neutral_state().q).amax();
        assert!(moved < 1e-6, "{dt}: {moved:e}");
    }
}

// Contact that gives way lets the boxes sink by millimetres; then nothing moves, and nothing has gone aside.
#[test]
fn ten_boxes_on_compliant_contact_come_to_rest_without_going_aside() {
    let simulator = simulator(&stack(10, 0.0), relaxed(), 5e-3);
    let (state, status) = run(&simulator, 320);
    assert_eq!(status, Status::Converged);
    assert!(state.v.amax() < 1e-6, "{:e}", state.v.amax());
    let moved = &state.q - &simulator.neutral_state().q;
    let aside = (0..10).flat_map(|k| [moved[7 * k], moved[7 * k + 1], moved[7 * k + 6]]);
    assert!(aside.fold(0.0, |most: f64, x| most.max(x.abs())) < 1e-12);
}

// Walls, redundant contacts and sliding bodies at once: also in hard steps the laws hold to 1e-9.
#[test]
fn every_step_of_a_pile_finds_its_forces() {
    for (law, bodies, dt, steps) in [
        (relaxed(), 30, 2e-3, 120),
        (rigid(), 18, 2e-3, 120),
        (rigid(), 36, 5e-3, 130),
    ] {
        let simulator = simulator(&bin(bodies), law, dt);
        let (state, status) = run(&simulator, steps);
        assert!(status <= Status::Acceptable, "{law:?} {bodies}: {status:?}");
        let certificate = simulator.contact_report(&state, &[]).certificate;
        assert!(certificate.residual < 1e-9, "{law:?}: {certificate:?}");
    }
}

// The last digits show that the start was another one.
#[test]
fn rollouts_with_a_warm_start_are_near_those_without_and_depend_on_nothing_else() {
    let mut same = 0;
    for law in [rigid(), relaxed()] {
        let rollout = |warm_start| {
            let options = SolverOptions {
                warm_start,
                ..SolverOptions::default()
            };
            let simulator = simulator_with(&stack(6, 1e-3), law, 2e-3, options);
            let rollout = simulator.rollout(&simulator.neutral_state(), 40, |_, _, _| {});
            rollout.last().clone()
        };
        let (cold, warm) = (rollout(false), rollout(true));
        let apart = (&cold.q - &warm.q).amax();
        assert!(apart < 1e-6, "{law:?}: {apart:e}");
        assert_eq!(rollout(true), warm);
        same += usize::from(cold == warm);
    }
    assert!(same < 2);
}

// The ground carries the weight of all, and each pair the weight of the boxes above it.
#[test]
fn forces_in_a_stack_are_the_weights_above() {
    let simulator = simulator(&stack(8, 0.0), rigid(), 2e-3);
    let (state, _) = run(&simulator, 3);
    let report = simulator.contact_report(&state, &[]);
    let weight = 9.81;
    let on_ground: f64 = report.forces.iter().map(|force| force.z).sum();
    assert!((on_ground - 8.0 * weight).abs() < 1e-5, "{on_ground}");
    let between: f64 = report.pairs.iter().map(|pair| pair.force.norm()).sum();
    assert!((between - 28.0 * weight).abs() < 1e-4, "{between}");
}

// Six boxes have 24 points, so many that their forces are found by blocks. They are turned and shifted, so that no edges are aligned.
#[test]
fn derivatives_through_many_contacts_equal_finite_differences() {
    let simulator = simulator(&stack(6, -1e-3), relaxed(), 2e-3);
    let mut state = simulator.neutral_state();
    let uneven = |k: usize| (1.7 * k as f64 + 0.3).sin();
    let change: Vec<f64> = (0..36)
        .map(|k| match k % 6 {
            0 | 1 => 0.01 * uneven(k),
            5 => 0.1 * uneven(k),
            _ => 1e-4 * uneven(k),
        })
        .collect();
    state.q = DVector::from(simulator.model().integrate(state.q.as_slice(), &change));
    let report = simulator.contact_report(&state, &[]);
    assert!(
        report
            .pairs
            .iter()
            .filter(|pair| pair.force.norm() > 0.1)
            .count()
            > 16
    );
    let a = simulator.linearize(&state, &[]).a;
    for k in [0, 8, 16, 21, 38, 43, 52, 71] {
        let error = (a.column(k) - difference(&simulator, &state, k, 1e-6)).amax();
        assert!(error < 1e-6 * a.amax(), "{k}: {error:e} of {}", a.amax());
    }
    let weights: Vec<f64> = (0..a.nrows()).map(|k| (1.0 + k as f64).sin()).collect();
    let found = simulator.vjp(&state, &[], &weights).state;
    let expected = a.transpose() * DVector::from(weights);
    assert!((&found - &expected).amax() < 1e-10 * expected.amax());
}

// More points in all than one robot may have.
#[test]
fn points_of_many_bodies_all_take_part() {
    let mut world = World::default();
    for k in 0..300 {
        let (x, y) = (0.3 * (k % 20) as f64, 0.3 * (k / 20) as f64);
        let object = Object::free(Mass::Kilograms(1.0)).at(at(x, y, 0.1));
        let name = format!("ball {k:03}");
        world.add_sphere(&name, 0.1, &object).expect("a ball");
    }
    let simulator = simulator(&world, rigid(), 2e-3);
    let (state, status) = run(&simulator, 2);
    assert_eq!(status, Status::Converged);
    assert!(state.v.amax() < 1e-12, "{:e}", state.v.amax());
}

#[test]
fn bodies_in_one_place_end_in_a_status() {
    let mut world = World::default();
    for k in 0..12 {
        let object = Object::free(Mass::Kilograms(1.0)).at(at(0.0, 0.0, 0.1));
        let name = format!("body {k:02}");
        let added = match k % 2 {
            0 => world.add_sphere(&name, 0.1, &object),
            _ => world.add_box(&name, [0.2; 3], &object),
        };
        added.expect("a body");
    }
    for law in [rigid(), relaxed()] {
        let _ = run(&simulator(&world, law, 1e-3), 20);
    }
}

/// Bodies touch in some lanes and are apart in others.
#[test]
fn boxes_in_lanes_step_as_single_ones() {
    type L = Lanes<4>;
    let simulator = simulator(
        &stack(2, 0.0),
        ContactLaw::RelaxedRigid(RelaxedRigid::default()),
        1e-3,
    );
    let start = simulator.neutral_state();
    let (nq, nv) = (start.q.len(), start.v.len());
    let lifted = |lane: usize| {
        let mut q = start.q.clone();
        // The height of the upper box.
        q[nq / 2 + 2] += [0.0, -1e-3, 0.01, 0.3][lane];
        q
    };
    let q: Vec<L> = (0..nq)
        .map(|k| L::from_values(|lane| lifted(lane)[k]))
        .collect();
    let still = vec![L::from(0.0); nv];
    let together = simulator.step(&State::new(&q, &still), &[]);
    for lane in 0..4 {
        let state = State::new(lifted(lane).as_slice(), &vec![0.0; nv]);
        let single = simulator.step(&state, &[]);
        for (together, single) in together.v.iter().zip(&single.v) {
            let error = (together.value(lane) - single).abs();
            assert!(error < 1e-9, "lane {lane}: {error:e}");
        }
    }
}
