//! Steps of Euler move free bodies by their centres of mass: linear momentum stays wherever the frame of a body is, and derivatives agree.

use dualbody::autodiff::{VectorFunction, gradient};
use dualbody::codegen::linearization;
use dualbody::constraint::{Anchor, Constraint};
use dualbody::contact::{ContactLaw, RelaxedRigid, Rigid, SoftContact, Terrain};
use dualbody::dynamics::{MomentumFrame, frame_pose, momentum};
use dualbody::joint::JointKind;
use dualbody::linearize::RolloutCost;
use dualbody::model::{Base, JointSpec, LinkSpec, Mass, ModelBuilder};
use dualbody::sim::BatchSimulator;
use dualbody::{Cast, Integrator, Model, Scalar, Simulator, State};
use nalgebra::{DVector, Vector3};

use crate::common::ground::{differences, on, run};
use crate::common::{
    OTHER_ALGORITHM, SAME_ALGEBRA, assert_close, assert_close_vector, floating_robot, generator,
};

const EULERS: [Integrator; 2] = [Integrator::SemiImplicitEuler, Integrator::ImplicitVelocity];
/// Kinds of joints of free bodies.
const FREE: [JointKind; 2] = [JointKind::Floating, JointKind::Planar];

/// A body of 1.5 kg whose centre of mass is 0.2 m beside its origin, without gravity.
fn offset_body(kind: JointKind) -> Model {
    let mut builder = ModelBuilder::new("offset").with_gravity([0.0; 3]);
    builder.add_link(LinkSpec::new("world"));
    builder.add_link(LinkSpec::new("body").with_mass(1.5, [0.2, 0.0, 0.0], [0.1, 0.2, 0.3]));
    builder.add_joint(JointSpec::new("free", kind, "world", "body").with_axis([0.0, 0.0, 1.0]));
    builder.build().expect("a body that is known to be right")
}

/// A state in which the body spins about all axes that it has.
fn spinning(kind: JointKind) -> State {
    match kind {
        JointKind::Planar => State::new(&[0.3, -0.2, 0.7], &[0.5, -1.0, 3.0]),
        // ω × c = (0, 1, −2), so v + ω × c = (0.5, 0, 0)
        _ => State::new(
            &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
            &[0.5, -1.0, 2.0, 2.0, 10.0, 5.0],
        ),
    }
}

/// The linear momentum of all bodies in the world.
fn linear_momentum(model: &Model, state: &State) -> Vector3<f64> {
    momentum(
        model,
        state.q.as_slice(),
        state.v.as_slice(),
        MomentumFrame::World,
    )
    .linear
}

/// The centre of mass of the body in the world.
fn center(model: &Model, state: &State) -> Vector3<f64> {
    dualbody::dynamics::center_of_mass(model, state.q.as_slice())
}

#[test]
fn spinning_body_keeps_its_linear_momentum_wherever_its_centre_of_mass_is() {
    for kind in FREE {
        let model = offset_body(kind);
        let start = spinning(kind);
        let before = linear_momentum(&model, &start);
        if kind == JointKind::Floating {
            assert!((before - Vector3::new(0.75, 0.0, 0.0)).amax() < SAME_ALGEBRA);
        }
        for integrator in EULERS {
            let simulator = Simulator::new(model.clone()).with_integrator(integrator);
            let simulator = simulator.with_time_step(0.01);
            let end = simulator.rollout(&start, 1000, |_, _, _| {});
            let drift = (linear_momentum(&model, end.last()) - before).norm() / before.norm();
            assert!(drift < 1e-12, "{kind}, {integrator:?}: {drift:e}");
            // It flies straight.
            let flown = center(&model, end.last()) - center(&model, &start);
            let off = (flown - before * (10.0 / 1.5)).norm() / flown.norm();
            assert!(off < 1e-12, "{kind}, {integrator:?}: {off:e}");
        }
    }
}

/// A robot on two feet, whose base frame is that of its torso or one that is shifted to the centre of mass of the torso.
fn walker(base: JointKind, is_shifted: bool) -> Model {
    let c = [0.08, -0.05, 0.12];
    let mut builder = ModelBuilder::new("walker");
    builder.add_link(LinkSpec::new("world"));
    let root = if is_shifted { "hub" } else { "torso" };
    builder.add_joint(JointSpec::new("base", base, "world", root).with_axis([0.0, 0.0, 1.0]));
    if is_shifted {
        builder.add_link(LinkSpec::new("hub"));
        let shift = JointSpec::new("shift", JointKind::Fixed, "hub", "torso");
        let height = if base == JointKind::Planar { 0.0 } else { c[2] };
        builder.add_joint(shift.with_translation([-c[0], -c[1], -height]));
    }
    builder.add_link(LinkSpec::new("torso").with_mass(4.0, c, [0.3, 0.25, 0.2]));
    let legs = [
        ("left", JointKind::Spherical, 0.2),
        ("right", JointKind::Revolute, -0.2),
    ];
    for (name, kind, y) in legs {
        let foot = LinkSpec::solid_sphere(name, 0.06, Mass::Kilograms(0.8));
        builder.add_link(foot);
        let hip = JointSpec::new(format!("{name} hip"), kind, "torso", name);
        let hip = hip.with_translation([0.05, y, -0.3]).with_damping(0.1);
        builder.add_joint(hip.with_axis([0.0, 0.6, 0.8]));
    }
    builder.build().expect("a robot that is known to be right")
}

/// The state of the shifted robot in which the torso and the joints of another one move as they do there.
fn shifted_state(own: &Model, state: &State, shifted: &Model) -> State {
    let (q, v) = (state.q.as_slice(), state.v.as_slice());
    let pose = frame_pose(own, q, own.frame("torso").expect("a link"));
    let c = frame_pose(
        shifted,
        shifted.neutral().as_slice(),
        shifted.frame("torso").expect("a link"),
    );
    let c = -c.translation;
    let (mut out, origin) = (state.clone(), pose.translation + pose.rotation * c);
    // All three coordinates of free motion, or those in the plane.
    let n = if own.nv() == 10 { 3 } else { 2 };
    let omega = match n {
        3 => Vector3::new(v[3], v[4], v[5]),
        _ => Vector3::new(0.0, 0.0, v[2]),
    };
    let around = omega.cross(&c);
    for k in 0..n {
        out.q[k] = origin[k];
        out.v[k] += around[k];
    }
    out
}

/// A walker, spinning, with feet that press into the ground.
fn landing(model: &Model) -> State {
    let (q, v) = match model.nv() {
        10 => (
            vec![0.1, 0.2, 0.0, 0.2_f64.cos(), 0.2_f64.sin(), 0.0, 0.0],
            vec![0.5, -0.3, -0.4, 3.0, -4.0, 6.0],
        ),
        _ => (vec![0.1, 0.2, 0.4], vec![0.5, -0.3, 6.0]),
    };
    let mut state = State::new(model.neutral().as_slice(), &vec![0.0; model.nv()]);
    state.q.rows_mut(0, q.len()).copy_from_slice(&q);
    state.v.rows_mut(0, v.len()).copy_from_slice(&v);
    let joints = model.nv() - 4;
    state
        .v
        .rows_mut(joints, 4)
        .copy_from_slice(&[0.5, -0.6, 0.7, 1.5]);
    state
}

/// Everything that can act on a walker in a step.
fn acting(model: &Model) -> Vec<(&'static str, Simulator)> {
    let soft = ContactLaw::Soft(SoftContact::estimate(5.6, 2, 0.01));
    let relaxed = ContactLaw::RelaxedRigid(RelaxedRigid::default());
    let rigid = ContactLaw::Rigid(Rigid::default());
    let rod = || {
        let end = Anchor::frame(model, "torso")
            .expect("a link")
            .moved([0.3, 0.1, 0.2]);
        vec![Constraint::distance(
            [end, Anchor::world().moved([0.2, 0.3, 0.86])],
            0.9,
        )]
    };
    let flat = |law| on(model.clone(), Terrain::flat(-0.34), law).with_time_step(5e-3);
    let free = Simulator::new(model.clone()).with_time_step(5e-3);
    vec![
        ("free", free.clone()),
        ("rod", free.with_constraints(rod())),
        ("soft", flat(soft)),
        ("relaxed", flat(relaxed)),
        ("rigid", flat(rigid)),
        ("relaxed and rod", flat(relaxed).with_constraints(rod())),
    ]
}

// With its base frame at the centre of mass of the base, a robot takes the same steps.
#[test]
fn steps_of_a_robot_do_not_depend_on_where_its_base_frame_is() {
    let mut pressed = 0;
    for (kind, integrator) in FREE
        .into_iter()
        .flat_map(|kind| EULERS.map(|own| (kind, own)))
    {
        let [own, shifted] = [false, true].map(|is_shifted| walker(kind, is_shifted));
        let landing = landing(&own);
        for ((name, one), (_, other)) in acting(&own).into_iter().zip(acting(&shifted)) {
            let [one, other] = [one, other].map(|all| all.with_integrator(integrator));
            let start = one.state(landing.q.as_slice(), landing.v.as_slice());
            let start_of_other = shifted_state(&own, &start, &shifted);
            let touching = one.contact_report(&start, &vec![0.0; one.nu()]).forces;
            pressed += touching.iter().filter(|force| force.norm() > 0.0).count();
            let end = run(&one, &start, 0.2);
            let found = run(&other, &start_of_other, 0.2);
            let expected = shifted_state(&own, &end, &shifted);
            let what = format!("{kind}, {name}, {integrator:?}");
            assert_close_vector(&found.q, &expected.q, OTHER_ALGORITHM, &what);
            assert_close_vector(&found.v, &expected.v, OTHER_ALGORITHM, &what);
        }
    }
    assert!(pressed > 10, "{pressed} feet that press");
}

/// Simulators with fast free bodies, and a state of each.
fn spinning_robots() -> Vec<(String, Simulator, State)> {
    let mut all = Vec::new();
    for integrator in EULERS {
        let named = |name: &str| format!("{name}, {integrator:?}");
        for kind in FREE {
            let simulator = Simulator::new(offset_body(kind)).with_integrator(integrator);
            let simulator = simulator.with_time_step(0.01);
            all.push((named(&kind.to_string()), simulator.clone(), spinning(kind)));
            let end = Anchor::frame(simulator.model(), "body").expect("a link");
            let far = Anchor::world().moved([0.4, 0.1, 0.0]);
            let rod = Constraint::distance([end.moved([-0.1, 0.2, 0.0]), far], 0.5);
            let held = simulator.with_constraints(vec![rod]);
            all.push((named(&format!("{kind} on a rod")), held, spinning(kind)));
            let model = walker(kind, false);
            let start = landing(&model);
            // Feet of a base that cannot rise are pressed too hard for differences.
            let most = if kind == JointKind::Planar { 2 } else { 6 };
            for (name, simulator) in acting(&model).into_iter().take(most) {
                let simulator = simulator.with_integrator(integrator);
                let state = simulator.state(start.q.as_slice(), start.v.as_slice());
                all.push((named(&format!("{kind} walker, {name}")), simulator, state));
            }
        }
    }
    // In fast rotation the forces of the middle of the step are mixed in.
    let simulator = Simulator::new(offset_body(JointKind::Floating)).with_time_step(1e-3);
    let mut state = spinning(JointKind::Floating);
    state.v.rows_mut(3, 3).scale_mut(15.0);
    all.push(("whirling".into(), simulator, state));
    all
}

#[test]
fn jacobians_of_spinning_bodies_equal_central_differences() {
    for (name, simulator, state) in spinning_robots() {
        let found = simulator.linearize(&state, &vec![0.0; simulator.nu()]).a;
        let expected = differences(&simulator, &state, 1e-6);
        assert_close(&found, &expected, 1e-6, &name);
    }
}

/// λᵀ x⁺ as a function of all parameters.
struct Weighted<'a> {
    simulator: &'a Simulator,
    state: &'a State,
    weights: &'a DVector<f64>,
}

impl VectorFunction for Weighted<'_> {
    fn n_outputs(&self) -> usize {
        1
    }

    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let variant = self.simulator.with_parameters(x);
        let u = vec![T::zero(); self.simulator.nu()];
        let next = variant.step(&self.state.cast::<T>(), &u);
        let here = self
            .simulator
            .step(self.state, &vec![0.0; u.len()])
            .cast::<T>();
        let change = next.deviation(self.simulator.model(), &here);
        let products = change.iter().zip(self.weights);
        y[0] = products.fold(T::zero(), |sum, (&x, &weight)| sum + x * weight);
    }
}

#[test]
fn vjp_of_spinning_bodies_equals_jacobians_forward_mode_and_central_differences() {
    for (name, simulator, state) in spinning_robots() {
        let u = vec![0.0; simulator.nu()];
        let n = simulator.n_tangent();
        let weights = DVector::from_fn(n, |k, _| (k as f64 + 1.0).sin());
        let found = simulator.vjp(&state, &u, weights.as_slice());
        let jacobians = simulator.linearize(&state, &u);
        let expected = jacobians.a.tr_mul(&weights);
        assert_close_vector(&found.state, &expected, OTHER_ALGORITHM, &name);
        let expected = jacobians.b.tr_mul(&weights);
        assert_close_vector(&found.input, &expected, OTHER_ALGORITHM, &name);
        let function = Weighted {
            simulator: &simulator,
            state: &state,
            weights: &weights,
        };
        let parameters = simulator.parameters();
        let expected = gradient(&function, parameters.as_slice());
        assert_close_vector(&found.parameters, &expected, OTHER_ALGORITHM, &name);
        // Mass and first moment of the base, which determine its centre of mass.
        for k in 0..4 {
            let value = |by: f64| {
                let (mut moved, mut out) = (parameters.clone(), [0.0]);
                moved[k] += by;
                function.eval(moved.as_slice(), &mut out);
                out[0]
            };
            let slope = (value(1e-5) - value(-1e-5)) / 2e-5;
            let error = (slope - found.parameters[k]).abs() / slope.abs().max(1.0);
            assert!(error < 1e-5, "{name}, parameter {k}: {slope} {error:e}");
        }
    }
}

/// Squares of all entries of the last state.
struct Squares;

impl RolloutCost for Squares {
    fn end<T: Scalar>(&self, state: &State<T>) -> T {
        let all = state.q.iter().chain(&state.v);
        all.fold(T::zero(), |sum, &x| sum + x * x)
    }
}

#[test]
fn gradient_of_a_rollout_in_the_centre_of_mass_equals_central_differences() {
    for integrator in EULERS {
        let simulator = Simulator::new(offset_body(JointKind::Floating)).with_time_step(0.01);
        let simulator = simulator.with_integrator(integrator);
        let start = spinning(JointKind::Floating);
        let inputs = vec![DVector::zeros(simulator.nu()); 20];
        let found = simulator.rollout_gradient(&start, &inputs, &Squares);
        let parameters = simulator.parameters();
        for k in 0..4 {
            let value = |by: f64| {
                let mut moved = parameters.clone();
                moved[k] += by;
                let variant = simulator.with_parameters(moved.as_slice());
                let end = variant.rollout(&start, 20, |_, _, _| {});
                Squares.end(end.last())
            };
            let slope = (value(1e-5) - value(-1e-5)) / 2e-5;
            let error = (slope - found.parameters[k]).abs() / slope.abs().max(1.0);
            assert!(error < 1e-6, "{integrator:?}, parameter {k}: {error:e}");
        }
    }
}

#[test]
fn lanes_step_spinning_bodies_as_singles_do_bit_for_bit() {
    for (name, simulator, state) in spinning_robots() {
        let mut rng = generator(4);
        let starts: Vec<State> = (0..9)
            .map(|_| {
                let mut own = state.clone();
                let change = State::random(simulator.model(), &mut rng, 0.3).v;
                own.v += change;
                own
            })
            .collect();
        let u = vec![0.0; simulator.nu()];
        let singles: Vec<State> = starts.iter().map(|x| simulator.step(x, &u)).collect();
        let mut batch = BatchSimulator::new(simulator, starts.len());
        let mut states = batch.states(&starts);
        batch.step(&mut states, &vec![0.0; 9 * u.len()]);
        for (i, expected) in singles.iter().enumerate() {
            let bits = |x: &State| x.numbers().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&states.state(i)), bits(expected), "{name}");
        }
    }
}

#[test]
fn graphs_step_spinning_bodies_as_the_library_does() {
    for (name, simulator, state) in spinning_robots() {
        if simulator.model().nv() > 6 || name == "whirling" {
            continue;
        }
        let inputs: Vec<f64> = state
            .numbers()
            .chain(&vec![0.0; simulator.nu()])
            .copied()
            .collect();
        let graph = linearization(&simulator);
        let found = graph
            .evaluate(&inputs)
            .expect("the motion that it was made for");
        let step = simulator.linearize(&state, &vec![0.0; simulator.nu()]);
        let expected = DVector::from_iterator(found.len(), step.a.iter().chain(&step.b).copied());
        assert_close_vector(&DVector::from_vec(found), &expected, OTHER_ALGORITHM, &name);
    }
}

/// Change of the linear momentum of a floating robot with joints after a second without gravity, relative to it.
fn drift(integrator: Integrator, dt: f64) -> f64 {
    let model = floating_robot().with_gravity(Vector3::zeros());
    let simulator = Simulator::new(model.clone()).with_time_step(dt);
    let simulator = simulator.with_integrator(integrator);
    let mut start = State::new(model.neutral().as_slice(), &vec![0.0; model.nv()]);
    let v = DVector::from_fn(model.nv(), |k, _| 2.0 * (k as f64 + 1.0).sin());
    start.v.copy_from(&v);
    let before = linear_momentum(&model, &start);
    let end = run(&simulator, &start, 1.0);
    (linear_momentum(&model, &end) - before).norm() / before.norm()
}

#[test]
fn drift_of_the_momentum_of_a_robot_with_joints_halves_with_the_step() {
    for integrator in EULERS {
        let [coarse, fine] = [2e-3, 1e-3].map(|dt| drift(integrator, dt));
        let ratio = coarse / fine;
        println!("{integrator:?}: {coarse:e} {fine:e}");
        assert!(
            (1.8..2.2).contains(&ratio),
            "{integrator:?}: {coarse:e} {fine:e}"
        );
    }
}

#[test]
fn rod_on_a_spinning_body_stays_closed_wherever_the_frame_is() {
    let largest = |offset: f64, integrator: Integrator| {
        let mut builder = ModelBuilder::new("thrown").with_gravity([0.0; 3]);
        let body = LinkSpec::new("body").with_mass(1.5, [offset, 0.0, 0.0], [0.1, 0.2, 0.3]);
        builder.add_link(body);
        let model = builder.build().expect("a body");
        let end = Anchor::frame(&model, "body").expect("a link");
        let rod = Constraint::distance([end.moved([offset - 0.1, 0.2, 0.1]), Anchor::world()], 0.5);
        let simulator = Simulator::new(model).with_constraints(vec![rod]);
        let simulator = simulator.with_integrator(integrator).with_time_step(2e-3);
        // The rod is along x, and the velocity of its end across it.
        let origin = [0.5 - (offset - 0.1), -0.2, -0.1, 1.0, 0.0, 0.0, 0.0];
        let omega = Vector3::new(2.0, 10.0, 5.0);
        let arm = Vector3::new(offset - 0.1, 0.2, 0.1);
        let v = Vector3::new(0.0, 1.0, 0.5) - omega.cross(&arm);
        let start = simulator.state(&origin, &[v.x, v.y, v.z, 2.0, 10.0, 5.0]);
        let run = simulator.rollout(&start, 1000, |_, _, _| {});
        let errors = run.states.iter().map(|state| {
            let body = simulator.model().frame("body").expect("a link");
            let pose = frame_pose(simulator.model(), state.q.as_slice(), body);
            ((pose.translation + pose.rotation * arm).norm() - 0.5).abs()
        });
        errors.fold(0.0, f64::max)
    };
    for integrator in EULERS {
        let [at_center, beside] = [0.0, 0.2].map(|offset| largest(offset, integrator));
        println!("{integrator:?}: {at_center:e} {beside:e}");
        assert!(
            beside < 1.001 * at_center,
            "{integrator:?}: {at_center:e} {beside:e}"
        );
    }
}

// The base has no centre of mass: it is moved by its origin.
#[test]
fn base_without_mass_steps_and_has_derivatives() {
    let mut builder = ModelBuilder::new("bare").with_base(Base::Floating);
    builder.add_link(LinkSpec::new("frame"));
    builder.add_link(LinkSpec::new("rotor").with_mass(1.0, [0.1, 0.0, 0.2], [0.1; 3]));
    let joint = JointSpec::new("axle", JointKind::Revolute, "frame", "rotor");
    builder.add_joint(joint.with_armature(0.1));
    let model = builder.build().expect("a robot that is known to be right");
    for integrator in EULERS {
        let simulator = Simulator::new(model.clone()).with_integrator(integrator);
        let mut state = State::new(
            model.neutral().as_slice(),
            &[0.1, 0.2, 0.3, 1.0, 2.0, -1.0, 3.0],
        );
        state.q[7] = 0.4;
        let found = simulator.linearize(&state, &[0.0]);
        let expected = differences(&simulator, &state, 1e-6);
        assert_close(&found.a, &expected, 1e-6, &format!("{integrator:?}"));
        let gradient = simulator.vjp(&state, &[0.0], &[1.0; 14]);
        assert!(gradient.parameters.iter().all(|x| x.is_finite()));
    }
}
