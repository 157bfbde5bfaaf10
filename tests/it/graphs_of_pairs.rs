//! Steps with contact between bodies as graphs, beside those of the library: pairs of all kinds, apart, touching and deep, turned and nearly flat.

use std::f64::consts::FRAC_PI_2;

use dualbody::collision::Shape;
use dualbody::contact::{
    CollisionOptions, ContactLaw, Contacts, LinkShapes, RelaxedRigid, Rigid, Smoothing,
    SoftContact, Terrain,
};
use dualbody::joint::JointKind;
use dualbody::model::{Base, JointSpec, LinkSpec, Mass, ModelBuilder};
use dualbody::scalar::traced::Graph;
use dualbody::{Integrator, Model, Simulator, State, codegen};
use nalgebra::{UnitQuaternion, Vector3};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

/// How far velocities may be from those of the library, relative to the largest change of velocity in the step: sums in another order.
const ROUNDING: f64 = 1e-9;
/// How far entries of A and B may be, relative to the largest one.
const ROUNDING_OF_DERIVATIVES: f64 = 1e-8;
/// How far velocities of a solver with a fixed number of steps may be.
const SOLVED: f64 = 2e-6;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Sphere,
    Capsule,
    Box,
    Plate,
    HalfSpace,
}
use Kind::{Box as Cuboid, Capsule, HalfSpace, Plate, Sphere};

const MASS: Mass = Mass::Kilograms(1.0);

fn link(name: &str, kind: Kind, size: f64) -> LinkSpec {
    match kind {
        Sphere => LinkSpec::solid_sphere(name, 0.12 * size, MASS),
        Capsule => LinkSpec::solid_capsule(name, 0.05 * size, 0.3 * size, MASS),
        Cuboid => LinkSpec::solid_box(name, [0.3 * size, 0.2 * size, 0.25 * size], MASS),
        Plate | HalfSpace => LinkSpec::solid_box(name, [0.4 * size, 0.3 * size, 0.08 * size], MASS),
    }
}

/// Two bodies that float, of which a half-space is fixed to the world.
fn pair(kinds: [Kind; 2], law: ContactLaw) -> Simulator {
    let builder = ModelBuilder::new("pair").with_base(Base::Fixed);
    let mut builder = builder.with_gravity([0.0, 0.0, -9.81]);
    builder.add_link(LinkSpec::new("world"));
    for (k, kind) in kinds.into_iter().enumerate() {
        let name = ["first", "second"][k];
        builder.add_link(link(name, kind, 1.0 + 0.3 * k as f64));
        let joint = match kind {
            HalfSpace => JointKind::Fixed,
            _ => JointKind::Floating,
        };
        builder.add_joint(JointSpec::new(format!("to {name}"), joint, "world", name));
    }
    let model = builder.build().expect("a model");
    let mut shapes = LinkShapes::without_meshes(&model);
    for (own, kind) in shapes.shapes_mut().iter_mut().zip(kinds) {
        if kind == HalfSpace {
            own.shape = Shape::HalfSpace;
        }
    }
    simulator(model, law, shapes, &CollisionOptions::default())
}

fn simulator(
    model: Model,
    law: ContactLaw,
    shapes: LinkShapes,
    options: &CollisionOptions,
) -> Simulator {
    let contacts = Contacts::new(&model, Terrain::flat(-10.0), law)
        .with_links(&model, &[])
        .expect("no links")
        .with_link_shapes(&model, law, shapes, options)
        .expect("links");
    Simulator::new(model)
        .with_actuated_joints(&[])
        .expect("joints")
        .with_contacts(contacts)
        .with_time_step(1e-3)
}

fn soft() -> ContactLaw {
    ContactLaw::Soft(SoftContact::estimate(1.0, 1, 5e-3))
}

fn relaxed() -> ContactLaw {
    ContactLaw::RelaxedRigid(RelaxedRigid::default())
}

/// Both bodies anywhere near each other; of four states three are nearly flat, so that faces lie on one another.
fn random_state(simulator: &Simulator, rng: &mut Xoshiro256PlusPlus, is_flat: bool) -> State {
    let mut state = simulator.neutral_state();
    for first in (0..simulator.model().nq()).step_by(7) {
        let mut random = |size: f64| Vector3::from_fn(|_, _| rng.random_range(-size..size));
        let at = random(if first == 0 { 0.3 } else { 0.02 });
        let mut turn = UnitQuaternion::from_scaled_axis(random(if is_flat { 0.06 } else { 3.0 }));
        if is_flat {
            let mut side = Vector3::zeros();
            side[rng.random_range(0..3)] = FRAC_PI_2 * f64::from(rng.random_range(0..4));
            let about_z = Vector3::z() * rng.random_range(-1.0..1.0);
            for next in [about_z, side] {
                turn *= UnitQuaternion::from_scaled_axis(next);
            }
        }
        let q = [at.x, at.y, at.z, turn.w, turn.i, turn.j, turn.k];
        state.q.rows_mut(first, 7).copy_from_slice(&q);
    }
    let v = state.v.iter_mut();
    v.for_each(|v| *v = rng.random_range(-1.0..1.0));
    state
}

fn inputs(state: &State) -> Vec<f64> {
    state.numbers().copied().collect()
}

/// How far velocities of the graph are from those of the library, relative to the change of velocity in the step.
fn error(simulator: &Simulator, graph: &Graph, state: &State) -> f64 {
    let next = simulator.step(state, &[]);
    let found = graph.evaluate(&inputs(state)).expect("slow motion");
    let found = &found[simulator.model().nq()..];
    let change = (&next.v - &state.v).amax();
    let off = next.v.iter().zip(found).map(|(a, b)| (a - b).abs());
    off.fold(0.0, f64::max) / change
}

/// Compares steps at random states; some of them touch.
#[track_caller]
fn assert_equal_steps(kinds: [Kind; 2], states: usize) {
    let simulator = pair(kinds, soft());
    let graph = codegen::step(&simulator);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
    let (mut touching, mut apart) = (0, 0);
    for k in 0..states {
        let state = random_state(&simulator, &mut rng, k % 4 > 0);
        let report = simulator.contact_report(&state, &[]);
        let touches = report.pairs.iter().any(|own| own.force.norm() > 0.0);
        touching += usize::from(touches);
        apart += usize::from(!touches);
        let off = error(&simulator, &graph, &state);
        assert!(off < ROUNDING, "{kinds:?}, state {k}: {off:e} {state:?}");
    }
    let count = graph.counts().operations();
    println!("{kinds:?}: {count} operations, {touching} of {states} touch");
    assert!(touching > states / 20 && apart > states / 20, "{kinds:?}");
}

#[test]
fn steps_of_spheres_and_capsules_equal_those_of_the_library() {
    for kinds in [
        [Sphere, Sphere],
        [Sphere, Capsule],
        [Capsule, Sphere],
        [Capsule, Capsule],
    ] {
        assert_equal_steps(kinds, 2000);
    }
}

#[test]
fn steps_on_a_half_space_equal_those_of_the_library() {
    for kind in [Sphere, Capsule, Cuboid, Plate] {
        assert_equal_steps([kind, HalfSpace], 1000);
        assert_equal_steps([HalfSpace, kind], 1000);
    }
}

#[test]
fn steps_of_round_shapes_and_boxes_equal_those_of_the_library() {
    for kinds in [
        [Sphere, Cuboid],
        [Cuboid, Sphere],
        [Capsule, Cuboid],
        [Plate, Capsule],
    ] {
        assert_equal_steps(kinds, 2000);
    }
}

#[test]
fn steps_of_two_boxes_equal_those_of_the_library() {
    for kinds in [[Cuboid, Cuboid], [Plate, Cuboid], [Plate, Plate]] {
        assert_equal_steps(kinds, 2000);
    }
}

/// A and B of the graph and of the library, and the largest entry.
fn jacobians(simulator: &Simulator, graph: &Graph, state: &State) -> (Vec<f64>, Vec<f64>, f64) {
    let found = graph.evaluate(&inputs(state)).expect("slow motion");
    let step = simulator.linearize(state, &[]);
    let expected: Vec<f64> = step.a.iter().chain(&step.b).copied().collect();
    let largest = expected.iter().fold(1.0, |most: f64, x| x.abs().max(most));
    (found, expected, largest)
}

#[test]
fn jacobians_with_pairs_equal_those_of_the_library() {
    for kinds in [[Sphere, Capsule], [Capsule, Cuboid], [Cuboid, Plate]] {
        for integrator in [Integrator::SemiImplicitEuler, Integrator::RungeKutta4] {
            if integrator == Integrator::RungeKutta4 && kinds[0] != Sphere {
                continue;
            }
            let simulator = pair(kinds, soft()).with_integrator(integrator);
            let graph = codegen::linearization(&simulator);
            let count = graph.counts().operations();
            println!("{kinds:?}, {integrator:?}: A and B {count} operations");
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(11);
            for k in 0..100 {
                let state = random_state(&simulator, &mut rng, k % 4 > 0);
                let (found, expected, largest) = jacobians(&simulator, &graph, &state);
                for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
                    let off = (found - expected).abs() / largest;
                    let close = off < ROUNDING_OF_DERIVATIVES;
                    assert!(close, "{kinds:?}, state {k}, entry {i}: {off:e}");
                }
            }
        }
    }
}

/// A robot of capsules on a torso, whose limbs touch each other and the torso.
fn limbs() -> Simulator {
    let mut builder = ModelBuilder::new("limbs").with_base(Base::Floating);
    builder.add_link(LinkSpec::solid_capsule("torso", 0.12, 0.4, MASS));
    for (k, [x, z]) in [[0.2, 0.2], [-0.2, 0.2], [0.1, -0.3], [-0.1, -0.3]]
        .into_iter()
        .enumerate()
    {
        let [upper, lower] = ["upper", "lower"].map(|part| format!("{part} {k}"));
        builder.add_link(LinkSpec::solid_capsule(&upper, 0.05, 0.2, MASS));
        builder.add_link(LinkSpec::solid_capsule(&lower, 0.04, 0.2, MASS));
        let shoulder = JointSpec::new(
            format!("shoulder {k}"),
            JointKind::Spherical,
            "torso",
            &upper,
        );
        builder.add_joint(shoulder.with_translation([x, 0.0, z]));
        let elbow = JointSpec::new(format!("elbow {k}"), JointKind::Spherical, &upper, &lower);
        builder.add_joint(elbow.with_translation([0.0, 0.0, -0.25]));
    }
    let model = builder.build().expect("a model");
    let shapes = LinkShapes::without_meshes(&model);
    let options = CollisionOptions::default().with_self_collision();
    simulator(model, soft(), shapes, &options)
}

#[test]
fn steps_of_a_robot_that_touches_itself_equal_those_of_the_library() {
    let robot = limbs();
    let graph = codegen::step(&robot);
    println!("limbs: {} operations", graph.counts().operations());
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
    let mut touching = 0;
    for k in 0..200 {
        let state = State::random(robot.model(), &mut rng, 1.0);
        let report = robot.contact_report(&state, &[]);
        touching += usize::from(report.pairs.iter().any(|own| own.force.norm() > 0.0));
        let off = error(&robot, &graph, &state);
        assert!(off < ROUNDING, "state {k}: {off:e}");
    }
    assert!(touching > 50, "{touching}");
}

/// Follows a motion of the library, and compares each step; how many steps touch.
fn follow(simulator: &Simulator, start: State, steps: usize) -> usize {
    let graph = codegen::step(simulator);
    println!("motion: {} operations", graph.counts().operations());
    let (mut state, mut touching) = (start, 0);
    for k in 0..steps {
        let report = simulator.contact_report(&state, &[]);
        touching += usize::from(report.pairs.iter().any(|own| own.force.norm() > 0.0));
        let off = error(simulator, &graph, &state);
        assert!(off < SOLVED, "step {k}: {off:e}");
        state = simulator.step(&state, &[]);
    }
    touching
}

// Regularised contact: forces by a fixed number of steps of the solver. The capsule rolls down the sphere, the box pushes it aside.
#[test]
fn steps_of_regularised_contact_between_bodies_equal_those_of_the_library() {
    for (kinds, at) in [
        ([Sphere, Sphere], [0.02, 0.01, 0.285]),
        ([Capsule, Sphere], [0.02, 0.01, 0.36]),
        ([Sphere, HalfSpace], [0.0, 0.0, 0.125]),
        ([Sphere, Cuboid], [0.05, 0.03, 0.29]),
    ] {
        let simulator = pair(kinds, relaxed());
        let mut start = simulator.neutral_state();
        start.q.rows_mut(0, 3).copy_from_slice(&at);
        start.v.rows_mut(0, 3).copy_from_slice(&[0.1, -0.2, -0.5]);
        if simulator.model().nv() > 6 {
            start.v[8] = 0.8;
        }
        let touching = follow(&simulator, start, 60);
        assert!(touching > 2, "{kinds:?}: {touching}");
    }
}

// A size of a shape as an input of the graph.
#[test]
fn sizes_of_shapes_can_be_inputs() {
    let simulator = pair([Sphere, Cuboid], soft());
    let layout = simulator.parameter_layout();
    let names = layout.names();
    let sizes = names.iter().map(String::as_str);
    let sizes: Vec<&str> = sizes.filter(|name| name.contains("half extent")).collect();
    assert_eq!(sizes.len(), 3, "{names:?}");
    let graph = codegen::step_of_variants(&simulator, &sizes).expect("parameters");
    let mut numbers = simulator.parameters();
    let places: Vec<usize> = sizes
        .iter()
        .map(|name| layout.find(name).expect("a parameter"))
        .collect();
    for (&place, size) in places.iter().zip([0.1, 0.25, 0.2]) {
        numbers[place] = size;
    }
    let variant = simulator.with_parameters(numbers.as_slice());
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
    for k in 0..300 {
        let state = random_state(&simulator, &mut rng, k % 4 > 0);
        let next = variant.step(&state, &[]);
        let given = state.numbers().copied().chain([0.1, 0.25, 0.2]);
        let found = graph.evaluate(&given.collect::<Vec<_>>());
        let found = found.expect("slow motion");
        let off = next.v.iter().zip(&found[simulator.model().nq()..]);
        let off = off.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < ROUNDING * (1.0 + next.v.amax()), "state {k}: {off:e}");
    }
}

#[test]
fn pairs_are_written_as_cuda() {
    let graph = codegen::step(&pair([Sphere, Cuboid], soft()));
    let text = graph.to_cuda("pair", codegen::Precision::Double, &[]);
    let kernels = text.expect("a name").kernels;
    assert!(kernels.iter().any(|kernel| kernel.text().contains("sqrt")));
}

#[test]
#[should_panic(
    expected = "contact between the cylinder of link \"can\" and the box of link \"table\" cannot be recorded"
)]
fn shapes_that_cannot_be_recorded_are_named() {
    let mut builder = ModelBuilder::new("table").with_base(Base::Fixed);
    builder.add_link(LinkSpec::solid_box("table", [1.0, 1.0, 0.1], MASS));
    builder.add_link(LinkSpec::solid_cylinder("can", 0.1, 0.2, MASS));
    builder.add_joint(JointSpec::new("free", JointKind::Floating, "table", "can"));
    let model = builder.build().expect("a model");
    let shapes = LinkShapes::without_meshes(&model);
    let options = CollisionOptions::default().with_self_collision();
    let _ = codegen::step(&simulator(model, soft(), shapes, &options));
}

// Nine boxes: 36 pairs of eight points.
#[test]
#[should_panic(expected = "together have 288 points, but a graph has at most 32")]
fn graphs_with_too_many_points_are_refused() {
    let mut builder = ModelBuilder::new("boxes").with_base(Base::Fixed);
    builder.add_link(LinkSpec::new("world"));
    for k in 0..9 {
        let name = format!("box {k}");
        builder.add_link(link(&name, Cuboid, 1.0));
        builder.add_joint(JointSpec::new(
            format!("to {k}"),
            JointKind::Floating,
            "world",
            &name,
        ));
    }
    let model = builder.build().expect("a model");
    let shapes = LinkShapes::without_meshes(&model);
    let _ = codegen::step(&simulator(
        model,
        relaxed(),
        shapes,
        &CollisionOptions::default(),
    ));
}

#[test]
#[should_panic(expected = "with smoothing or speculative contact")]
fn smoothed_pairs_are_refused() {
    let own = pair([Sphere, Sphere], relaxed());
    let contacts = own.contacts().expect("contacts").clone();
    let smoothed = contacts.with_smoothing(Smoothing::new(1.0));
    let _ = codegen::step(&own.with_contacts(smoothed));
}

#[test]
#[should_panic(expected = "on the value")]
fn rigid_pairs_are_refused() {
    let law = ContactLaw::Rigid(Rigid::default());
    let _ = codegen::step(&pair([Sphere, Sphere], law));
}
