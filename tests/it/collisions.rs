//! Bodies that touch each other: impacts by closed forms, momentum, friction, stacks, and derivatives beside finite differences.

use dualbody::contact::{
    CollisionOptions, ContactLaw, Contacts, Material, RelaxedRigid, Rigid, SoftContact, Terrain,
};
use dualbody::joint::JointKind;
use dualbody::model::{
    Base, Collision, FrameId, Geometry, JointSpec, LinkSpec, Mass, ModelBuilder,
};
use dualbody::spatial::Transform;
use dualbody::{Integrator, Model, Simulator, State};
use nalgebra::{DVector, UnitQuaternion, Vector3};

use crate::common::ground::differences;

/// Free bodies, each with seven coordinates.
fn free(links: Vec<LinkSpec>, gravity: [f64; 3]) -> Model {
    let mut builder = ModelBuilder::new("bodies")
        .with_base(Base::Fixed)
        .with_gravity(gravity);
    builder.add_link(LinkSpec::new("floor"));
    for link in links {
        let name = link.name.clone();
        builder.add_link(link);
        let joint = JointSpec::new(format!("{name} free"), JointKind::Floating, "floor", name);
        builder.add_joint(joint);
    }
    builder.build().expect("a model")
}

fn simulator(model: &Model, law: ContactLaw, dt: f64) -> Simulator {
    simulator_with(model, law, dt, &CollisionOptions::default())
}

fn simulator_with(
    model: &Model,
    law: ContactLaw,
    dt: f64,
    options: &CollisionOptions,
) -> Simulator {
    let contacts = Contacts::new(model, Terrain::flat(-10.0), law)
        .with_collisions(model, law, options)
        .expect("links");
    Simulator::new(model.clone())
        .with_actuated_joints(&[])
        .expect("joints")
        .with_contacts(contacts)
        .with_time_step(dt)
}

fn place(state: &mut State, k: usize, at: [f64; 3], turn: [f64; 3], v: [f64; 6]) {
    let turn = UnitQuaternion::from_scaled_axis(Vector3::from(turn));
    let q = state.q.rows_mut(7 * k, 7);
    let wxyz = [turn.w, turn.i, turn.j, turn.k];
    let all = at.into_iter().chain(wxyz);
    { q }.iter_mut().zip(all).for_each(|(q, x)| *q = x);
    state.v.rows_mut(6 * k, 6).copy_from_slice(&v);
}

fn rigid(friction: f64, restitution: f64) -> ContactLaw {
    ContactLaw::Rigid(Rigid {
        friction,
        restitution,
        ..Rigid::default()
    })
}

fn ball(name: &str, radius: f64, mass: f64) -> LinkSpec {
    LinkSpec::solid_sphere(name, radius, Mass::Kilograms(mass))
}

/// A ball on a box, both turned and moving, a capsule at the side of the box.
fn heap(law: ContactLaw, integrator: Integrator) -> (Simulator, State) {
    let model = free(
        vec![
            ball("ball", 0.15, 1.0),
            LinkSpec::solid_box("box", [0.3, 0.2, 0.4], Mass::Kilograms(2.0)),
            LinkSpec::solid_capsule("capsule", 0.1, 0.3, Mass::Kilograms(0.7)),
        ],
        [0.0, 0.0, -9.81],
    );
    let options = CollisionOptions::default()
        .with_material("box", material(0.35, 0.2))
        .with_material("capsule", material(0.8, 0.5));
    let simulator = simulator_with(&model, law, 2e-3, &options).with_integrator(integrator);
    let mut state = simulator.neutral_state();
    let v = [0.3, -0.2, -1.0, 1.0, 0.5, -0.7];
    place(&mut state, 0, [0.01, 0.02, 0.345], [0.2, -0.4, 0.6], v);
    let v = [0.0, 0.1, 0.2, -0.3, 0.4, 0.2];
    place(&mut state, 1, [0.0; 3], [0.04, -0.06, 0.2], v);
    let v = [-0.5, 0.1, 0.2, -0.3, 0.4, 0.2];
    place(&mut state, 2, [0.24, 0.03, -0.05], [0.3, 0.0, 0.1], v);
    (simulator, state)
}

fn soft() -> ContactLaw {
    ContactLaw::Soft(SoftContact::estimate(1.0, 1, 5e-3))
}

fn heaps() -> Vec<(Simulator, State)> {
    let relaxed = ContactLaw::RelaxedRigid(RelaxedRigid::default());
    [
        (rigid(0.4, 0.3), Integrator::SemiImplicitEuler),
        (rigid(0.4, 0.3), Integrator::ImplicitVelocity),
        (relaxed, Integrator::SemiImplicitEuler),
        (relaxed, Integrator::ImplicitVelocity),
        (relaxed, Integrator::RungeKutta4),
        (soft(), Integrator::SemiImplicitEuler),
        (soft(), Integrator::ImplicitVelocity),
        (soft(), Integrator::RungeKutta4),
    ]
    .map(|(law, integrator)| heap(law, integrator))
    .into()
}

// Equal masses and restitution 1: the balls exchange their velocities, at the time at which they meet.
#[test]
fn equal_balls_exchange_their_velocities() {
    let model = free(vec![ball("a", 0.15, 1.0), ball("b", 0.15, 1.0)], [0.0; 3]);
    for dt in [1e-4, 1e-3, 1e-2] {
        let simulator = simulator(&model, rigid(0.0, 1.0), dt);
        let mut state = simulator.neutral_state();
        let v = [1.6, 0.0, 0.0, 0.0, 0.0, 0.0];
        place(&mut state, 0, [-0.3, 0.0, 0.0], [0.0; 3], v);
        place(&mut state, 1, [0.5, 0.0, 0.0], [0.0; 3], [0.0; 6]);
        for _ in 0..(1.0 / dt).round() as usize {
            state = simulator.step(&state, &[]);
        }
        assert!(state.v[0].abs() < 1e-12 && (state.v[6] - 1.6).abs() < 1e-12);
        assert!((state.q[7] - 1.6).abs() < 1e-9, "{dt}: {}", state.q[7]);
    }
}

// Forces between bodies are equal and opposite, on one line: the sum of all, as wrenches in the world, is zero.
#[test]
fn forces_between_bodies_have_no_net_wrench() {
    for (simulator, state) in heaps() {
        let report = simulator.contact_report(&state, &[]);
        assert!(report.pairs.iter().any(|pair| pair.force.norm() > 1.0));
        let model = simulator.model();
        let kinematics =
            dualbody::dynamics::forward_kinematics(model, state.q.as_slice(), state.v.as_slice());
        let mut sum = dualbody::spatial::Force::zero();
        for (link, force) in model.links().iter().zip(&report.links) {
            let frame = &model.frames()[link.frame.0];
            let X_WL: Transform<f64> = kinematics.pose(frame.body) * frame.placement;
            sum += X_WL.force(force);
        }
        let size = report
            .pairs
            .iter()
            .map(|pair| pair.force.norm())
            .sum::<f64>();
        let rest = sum
            .to_array()
            .into_iter()
            .fold(0.0, |a: f64, x| a.max(x.abs()));
        assert!(rest < 1e-13 * size, "{rest} {size}");
    }
}

#[test]
fn jacobians_through_contact_of_bodies_equal_finite_differences() {
    for (simulator, state) in heaps() {
        assert_slopes(&simulator, &state);
    }
}

fn assert_slopes(simulator: &Simulator, state: &State) {
    // Soft contact at a millimetre has a third derivative that 1e-6 shows.
    const BY: f64 = 2e-7;
    let a = simulator.linearize(state, &[]).a;
    let error = (&a - differences(simulator, state, BY)).amax();
    assert!(error < 1e-7 * a.amax(), "{error:e} of {}", a.amax());
}

#[test]
fn adjoints_equal_jacobians_and_finite_differences_in_sizes_and_laws() {
    for (simulator, state) in heaps() {
        let n = 2 * state.v.len() + state.contact.len();
        let weights: Vec<f64> = (0..n).map(|k| (1.0 + k as f64).sin()).collect();
        let a = simulator.linearize(&state, &[]).a;
        let found = simulator.vjp(&state, &[], &weights);
        let expected = a.transpose() * DVector::from(weights.clone());
        let state_error = (&found.state - &expected).amax();
        assert!(state_error < 1e-12 * expected.amax(), "{state_error}");
        assert_parameters(&simulator, &state, &weights, found.parameters.as_slice(), 7);
    }
}

/// Weighted next states at other parameters, beside a gradient in them.
fn assert_parameters(
    simulator: &Simulator,
    state: &State,
    weights: &[f64],
    slopes: &[f64],
    least: usize,
) {
    let layout = simulator.parameter_layout();
    let (all, n) = (simulator.parameters(), state.v.len());
    let base = simulator.step(state, &[]);
    let at = |k: usize, by: f64| {
        let mut moved = all.clone();
        moved[k] += by;
        let next = simulator
            .with_parameters::<f64>(moved.as_slice())
            .step(state, &[]);
        let dq = simulator
            .model()
            .difference(base.q.as_slice(), next.q.as_slice());
        let q: f64 = dq.iter().zip(weights).map(|(x, w)| x * w).sum();
        let v: f64 = next.v.iter().zip(&weights[n..]).map(|(x, w)| x * w).sum();
        q + v
    };
    let wanted = [
        "radius",
        "half",
        "friction",
        "restitution",
        "mass",
        "time",
        "width",
    ];
    let size = slopes.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
    let mut found = 0;
    for (k, name) in layout.names().iter().enumerate() {
        if !wanted.iter().any(|part| name.contains(part)) || all[k] == 0.0 {
            continue;
        }
        let by = 1e-6 * all[k].abs();
        let expected = (at(k, by) - at(k, -by)) / (2.0 * by);
        let error = (slopes[k] - expected).abs();
        assert!(
            error < 1e-6 * slopes[k].abs().max(1e-2 * size),
            "{name}: {} {expected}",
            slopes[k]
        );
        found += usize::from(slopes[k] != 0.0);
    }
    assert!(found >= least, "{found}");
}

/// A slope of 20° about y, a fixed box of 4 m × 2 m × 0.2 m, with a free box of 2 kg.
struct Slope {
    turn: Transform<f64>,
    simulator: Simulator,
    state: State,
}

const SLOPE: f64 = 20.0 / 180.0 * std::f64::consts::PI;

impl Slope {
    fn new(law: ContactLaw, options: &CollisionOptions) -> Self {
        let turn = UnitQuaternion::from_scaled_axis(Vector3::y() * SLOPE);
        let turn = Transform::new(*turn.to_rotation_matrix().matrix(), Vector3::zeros());
        let mut builder = ModelBuilder::new("slope").with_base(Base::Fixed);
        builder.add_link(LinkSpec::new("world"));
        let ramp = LinkSpec::solid_box("ramp", [4.0, 2.0, 0.2], Mass::Kilograms(1.0));
        builder.add_link(ramp);
        let fixed = JointSpec::new("held", JointKind::Fixed, "world", "ramp");
        builder.add_joint(fixed.with_placement(turn));
        let free = LinkSpec::solid_box("box", [0.4, 0.3, 0.2], Mass::Kilograms(2.0));
        builder.add_link(free);
        builder.add_joint(JointSpec::new("free", JointKind::Floating, "world", "box"));
        let model = builder.build().expect("a model");
        let simulator = simulator_with(&model, law, 1e-3, options);
        let mut state = simulator.neutral_state();
        let start = turn.point(&Vector3::new(0.0, 0.0, 0.2));
        place(&mut state, 0, start.into(), [0.0, SLOPE, 0.0], [0.0; 6]);
        Self {
            turn,
            simulator,
            state,
        }
    }

    /// The way along the slope, and out of it, after some steps, m.
    fn moved(&self, steps: usize) -> [f64; 2] {
        let mut state = self.state.clone();
        for _ in 0..steps {
            state = self.simulator.step(&state, &[]);
        }
        let moved = state.q.fixed_rows::<3>(0) - self.state.q.fixed_rows::<3>(0);
        [0, 2].map(|axis| self.turn.rotation.column(axis).dot(&moved))
    }
}

fn material(friction: f64, restitution: f64) -> Material {
    Material {
        friction,
        restitution,
        ..Material::default()
    }
}

// A box on a box that is fixed at 20°: it slides with g (sin α − μ cos α) if tan α > μ, else it stays. Of materials of 0.2 and 0.6, μ = 0.3; of one of 0.2 on
// the 0.6 of the law the same.
#[test]
fn a_box_on_a_tilted_box_slides_beyond_the_angle_of_friction() {
    let sliding = 9.81 * (SLOPE.sin() - 0.3 * SLOPE.cos());
    let (ice, wood) = (material(0.2, 0.0), material(0.6, 0.0));
    let none = CollisionOptions::default;
    let both = none().with_material("box", wood).with_material("ramp", ice);
    let one = none().with_material("box", ice);
    for (friction, options, a) in [
        (0.3, none(), sliding),
        (0.5, none(), 0.0),
        (0.9, both, sliding),
        (0.6, one, sliding),
    ] {
        let [along, out] = Slope::new(rigid(friction, 0.0), &options).moved(500);
        let expected = 0.5 * a * 0.25;
        assert!(
            (along - expected).abs() < 2e-3 * expected.max(1e-6),
            "{friction}: {along} {expected}"
        );
        assert!(out.abs() < 1e-6);
    }
}

// Soft contact between bodies has no bristle: four corners at the depth δ with K δ¹⁺ᵖ = m g cos α / 4 hold m g sin α by dampers c = D δ^q, and so creep at
// m g sin α / 4 c; in steps that are implicit in velocity, at m g sin α / 4 (c + s Δt).
#[test]
fn what_soft_friction_between_bodies_holds_creeps_at_force_by_damping() {
    let law = SoftContact::estimate(2.0, 4, 2e-3);
    let options = CollisionOptions::default();
    let normal = law.normal;
    let weight = 2.0 * 9.81;
    let depth = (weight * SLOPE.cos() / 4.0 / normal.stiffness)
        .powf(1.0 / (1.0 + normal.stiffness_exponent));
    let damper = normal.damping * depth.powf(normal.damping_exponent);
    let spring = normal.stiffness * depth.powf(normal.stiffness_exponent);
    for (integrator, damper) in [
        (Integrator::SemiImplicitEuler, damper),
        (Integrator::RungeKutta4, damper),
        (Integrator::ImplicitVelocity, damper + 1e-3 * spring),
    ] {
        let mut slope = Slope::new(ContactLaw::Soft(law), &options);
        slope.simulator = slope.simulator.with_integrator(integrator);
        let sunk = slope.turn.rotation.column(2) * -depth;
        let at = Vector3::from_column_slice(&slope.state.q.as_slice()[..3]);
        slope.state.q.rows_mut(0, 3).copy_from(&(at + sunk));
        let ([before, _], [after, out]) = (slope.moved(60), slope.moved(80));
        let (found, expected) = ((after - before) / 0.02, weight * SLOPE.sin() / 4.0 / damper);
        assert!((found / expected - 1.0).abs() < 1e-2, "{found} {expected}");
        assert!(out.abs() < 1e-2 * depth, "{out} {depth}");
    }
}

/// A ball of 5 cm, or a plate of 2 mm, that flies at a fixed wall of 2 cm at 60 m/s, 0.3 m in a step: the velocity along its way in the end.
fn after_the_wall(thing: &LinkSpec, law: ContactLaw, options: &CollisionOptions) -> [f64; 2] {
    let mut builder = ModelBuilder::new("wall")
        .with_base(Base::Fixed)
        .with_gravity([0.0; 3]);
    builder.add_link(LinkSpec::new("world"));
    builder.add_link(LinkSpec::solid_box(
        "wall",
        [0.02, 2.0, 2.0],
        Mass::Kilograms(1.0),
    ));
    builder.add_joint(JointSpec::new("held", JointKind::Fixed, "world", "wall"));
    builder.add_link(thing.clone());
    let name = thing.name.clone();
    builder.add_joint(JointSpec::new("free", JointKind::Floating, "world", name));
    let model = builder.build().expect("a model");
    let integrator = match law {
        ContactLaw::Rigid(_) => Integrator::SemiImplicitEuler,
        _ => Integrator::ImplicitVelocity,
    };
    let simulator = simulator_with(&model, law, 5e-3, options).with_integrator(integrator);
    let mut state = simulator.neutral_state();
    let v = [60.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    place(&mut state, 0, [-1.0, 0.3, 0.2], [0.0; 3], v);
    for _ in 0..20 {
        state = simulator.step(&state, &[]);
    }
    [state.q[0], state.v[0]]
}

#[test]
fn fast_thin_things_are_stopped_by_contact_that_meets_what_would_arrive() {
    let plate = LinkSpec::solid_box("plate", [0.002, 0.3, 0.2], Mass::Kilograms(0.5));
    let relaxed = ContactLaw::RelaxedRigid(RelaxedRigid::default());
    let (none, met) = (
        CollisionOptions::default(),
        CollisionOptions::default().with_speculative_contact(),
    );
    for thing in [ball("ball", 0.05, 1.0), plate] {
        for (law, options) in [(relaxed, &met), (rigid(0.5, 0.0), &none)] {
            let [x, v] = after_the_wall(&thing, law, options);
            assert!(x < -0.01 && v < 1e-6, "{}: {x} {v}", thing.name);
        }
        let [x, v] = after_the_wall(&thing, relaxed, &none);
        assert!(x > 0.0 && v > 0.0, "{}: {x} {v}", thing.name);
    }
}

// Balls that would meet within a step: they push each other along the normal, and derivatives are those of that.
#[test]
fn contact_ahead_of_time_has_exact_derivatives_and_no_friction() {
    let law = ContactLaw::RelaxedRigid(RelaxedRigid::default());
    let model = free(vec![ball("a", 0.15, 1.0), ball("b", 0.15, 2.0)], [0.0; 3]);
    let met = CollisionOptions::default().with_speculative_contact();
    let simulator = simulator_with(&model, law, 1e-2, &met);
    let mut state = simulator.neutral_state();
    let v = [5.0, 1.0, -3.0, 0.3, 2.0, 0.1];
    place(&mut state, 0, [-0.3, 0.02, 0.01], [0.2, 0.1, 0.0], v);
    place(&mut state, 1, [0.03, 0.0, 0.0], [0.0; 3], [0.0; 6]);
    let report = simulator.contact_report(&state, &[]);
    let [pair] = report.pairs.as_slice() else {
        panic!("one pair")
    };
    assert!(pair.point.depth < -0.02 && pair.force.norm() > 10.0);
    assert!(pair.force.cross(&pair.point.normal).norm() < 1e-12 * pair.force.norm());
    assert_slopes(&simulator, &state);
    let n = 2 * state.v.len();
    let weights: Vec<f64> = (0..n).map(|k| (1.0 + k as f64).cos()).collect();
    let found = simulator.vjp(&state, &[], &weights);
    assert_parameters(&simulator, &state, &weights, found.parameters.as_slice(), 3);
}

// Four boxes on each other and on the ground, let go at rest: none moves by a micrometre in two seconds.
#[test]
fn a_stack_stands_still() {
    let names = ["a", "b", "c", "d"];
    let one = |name: &&str| LinkSpec::solid_box(*name, [0.2; 3], Mass::Kilograms(1.0));
    let model = free(names.iter().map(one).collect(), [0.0, 0.0, -9.81]);
    let law = rigid(0.5, 0.0);
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law)
        .with_collisions(&model, law, &CollisionOptions::default())
        .expect("links");
    let simulator = Simulator::new(model)
        .with_actuated_joints(&[])
        .expect("joints")
        .with_contacts(contacts)
        .with_time_step(5e-3);
    let mut state = simulator.neutral_state();
    for k in 0..4 {
        let at = [0.0, 0.0, 0.1 + 0.2 * k as f64];
        place(&mut state, k, at, [0.0; 3], [0.0; 6]);
    }
    let start = state.q.clone();
    for _ in 0..400 {
        state = simulator.step(&state, &[]);
    }
    assert!((state.q - start).amax() < 1e-6 && state.v.amax() < 1e-6);
}

/// Three rods of 1 m on top of each other, with joints about y between them.
fn three_rods() -> Model {
    let mut builder = ModelBuilder::new("rods").with_base(Base::Fixed);
    builder.add_link(LinkSpec::new("world"));
    let mut parent = "world";
    for (name, height) in [("a", 0.0), ("b", 1.0), ("c", 1.0)] {
        let middle = Transform::from_translation(Vector3::new(0.0, 0.0, 0.5));
        let geometry = Geometry::Capsule {
            radius: 0.05,
            length: 1.0,
        };
        let link = LinkSpec::new(name).with_mass(1.0, [0.0, 0.0, 0.5], [0.1, 0.1, 0.01]);
        builder.add_link(link.with_collision(Collision {
            name: None,
            placement: middle,
            geometry,
        }));
        let joint = JointSpec::new(format!("to {name}"), JointKind::Revolute, parent, name);
        let joint = joint.with_axis([0.0, 1.0, 0.0]);
        builder.add_joint(joint.with_translation([0.0, 0.0, height]));
        parent = name;
    }
    builder.build().expect("a model")
}

// Folded to a triangle: the first and the last rod touch, where they may; those that a joint connects never do.
#[test]
fn links_of_one_robot_collide_where_asked() {
    let (model, law) = (three_rods(), rigid(0.5, 0.0));
    let near = |options: CollisionOptions| {
        let contacts = Contacts::new(&model, Terrain::flat(-9.0), law)
            .with_collisions(&model, law, &options)
            .expect("links");
        let simulator = Simulator::new(model.clone()).with_contacts(contacts);
        let state = simulator.state(&[0.0, 2.1, 2.1], &[0.0; 3]);
        let report = simulator.contact_report(&state, &[0.0; 3]);
        let name = |id: FrameId| model.frames()[id.0].name.clone();
        let pairs = report.pairs.into_iter().map(|pair| pair.links.map(name));
        pairs.collect::<Vec<_>>()
    };
    assert!(near(CollisionOptions::default()).is_empty());
    let own = CollisionOptions::default().with_self_collision();
    assert_eq!(near(own.clone()), [["a", "c"]]);
    assert!(near(own.without("c", "a")).is_empty());
    let unknown = CollisionOptions::default().without("a", "nobody");
    let contacts = Contacts::new(&model, Terrain::flat(-9.0), law);
    let refused = contacts.with_collisions(&model, law, &unknown);
    assert!(refused.expect_err("a name").to_string().contains("nobody"));
}

#[test]
fn batches_of_touching_bodies_give_the_bits_of_single_steps() {
    let (simulator, state) = heap(rigid(0.4, 0.3), Integrator::SemiImplicitEuler);
    let mut batch = dualbody::sim::BatchSimulator::new(simulator.clone(), 5);
    let states: Vec<State> = (0..5)
        .map(|k| {
            let mut state = state.clone();
            state.v[2] -= 0.1 * k as f64;
            state
        })
        .collect();
    let moved = batch.rollout(&states, 20, |_, _, _| {});
    for (k, start) in states.iter().enumerate() {
        let mut single = start.clone();
        for _ in 0..20 {
            single = simulator.step(&single, &[]);
        }
        assert_eq!(moved.state(k, 20), single, "{k}");
    }
}

// Sizes are parameters: balls whose radius is set to twice as much touch where those do.
#[test]
fn shapes_with_other_sizes_touch_where_these_do() {
    let model = free(vec![ball("a", 0.15, 1.0), ball("b", 0.15, 1.0)], [0.0; 3]);
    let small = simulator(&model, rigid(0.0, 0.0), 1e-3);
    let layout = small.parameter_layout();
    let mut parameters = small.parameters();
    let sizes = layout.names().iter().enumerate();
    let radii = sizes.filter(|(_, name)| name.contains("shape") && name.contains("radius"));
    radii.for_each(|(k, _)| parameters[k] *= 2.0);
    let large = small.with_parameters::<f64>(parameters.as_slice());
    let mut state = small.neutral_state();
    place(&mut state, 1, [0.5, 0.0, 0.0], [0.0; 3], [0.0; 6]);
    assert!(small.contact_report(&state, &[]).pairs.is_empty());
    let pairs = large.contact_report(&state, &[]).pairs;
    assert!((pairs[0].point.depth - 0.1).abs() < 1e-12 && pairs[0].force.norm() > 1.0);
}
