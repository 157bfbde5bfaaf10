//! External forces and actuators on frames against closed forms, Jᵀ F, finite differences, and one another.

use std::panic::{AssertUnwindSafe, catch_unwind};

use dualbody::autodiff::{VectorFunction, finite_difference, jacobian};
use dualbody::constraint::{Anchor, Constraint};
use dualbody::contact::{ContactLaw, Contacts, RelaxedRigid, Rigid, SoftContact, Terrain};
use dualbody::dynamics::{
    MomentumFrame, forward_dynamics, frame_jacobian, mass_matrix_inverse, momentum,
};
use dualbody::joint::JointKind;
use dualbody::model::{Base, JointSpec, LinkSpec, Model, ModelBuilder};
use dualbody::sim::{
    BATCH_WIDTH, BatchSimulator, ExternalForce, ForceFunction, FrameActuator, StepScratch,
};
use dualbody::spatial::{Force, Motion, Representation, Transform};
use dualbody::trajopt::{
    Activation, Cost, Ddp, DdpOptions, InputError, Problem, Robot, StateError, Trajectory,
};
use dualbody::view::Recording;
use dualbody::{Cast, Integrator, Scalar, Simulator, State};
use nalgebra::{DVector, Vector3, vector};

use crate::common::everything::{INTEGRATORS, REPRESENTATIONS};
use crate::common::{
    FINITE_DIFFERENCE, OTHER_ALGORITHM, ROUNDING, SAME_ALGEBRA, assert_close, assert_close_vector,
    asset, free_body, generator, random_point, relative_error, robots,
};

fn on(model: &Model, name: &str) -> Anchor {
    Anchor::frame(model, name).expect("a frame of the model")
}

/// A place beside the last link of a robot that moves.
fn tip(model: &Model) -> Option<Anchor> {
    let moves = |link: &&dualbody::model::Link| model.frames()[link.frame.0].body.is_some();
    let link = model.links().iter().rfind(moves)?;
    let place = Anchor::new(Some(link.frame), Transform::identity());
    Some(place.moved([0.1, -0.2, 0.3]))
}

const PUSH: [f64; 6] = [1.0, -2.0, 3.0, 0.4, 0.5, -0.6];

fn push() -> Force<f64> {
    Force::from_array(PUSH)
}

/// A spring and a damper to a place in the world, with the parameters stiffness, damping and the place.
struct Spring;

impl ForceFunction for Spring {
    fn force<T: Scalar>(
        &self,
        pose: &Transform<T>,
        velocity: &Motion<T>,
        parameters: &[T],
    ) -> Force<T> {
        let [k, d, x, y, z] = parameters else {
            unreachable!("five parameters")
        };
        let from = pose.translation - Vector3::new(*x, *y, *z);
        Force::new(from * -*k - velocity.linear * *d, velocity.angular * -*d)
    }
}

const SPRING: [f64; 5] = [7.0, 0.3, 0.1, -0.2, 0.4];

/// A force at a frame A, from a representation to the axes and origin of A.
fn in_body(r: Representation, X_WA: &Transform<f64>, force: &Force<f64>) -> Force<f64> {
    let about = match r {
        Representation::Body => return *force,
        Representation::Mixed => Transform::new(X_WA.rotation, Vector3::zeros()),
        Representation::Inertial => *X_WA,
    };
    about.inverse().force(force)
}

#[test]
fn acceleration_under_forces_on_a_frame_equals_forward_dynamics_under_their_joint_forces() {
    for model in robots() {
        let Some(place) = tip(&model) else { continue };
        let point = random_point(&model, 3);
        let (q, v) = (point.q.as_slice(), point.v.as_slice());
        for r in REPRESENTATIONS {
            // The Jacobian of a frame that stands where the force acts.
            let frame = place.frame.expect("a link");
            let J = frame_jacobian(&model, q, frame, Representation::Body);
            let X_WF = dualbody::dynamics::frame_pose(&model, q, frame);
            let X_WA = place.pose_in_world(&model, q);
            let F_A = in_body(r, &X_WA, &push());
            let F_F = place.placement.force(&F_A);
            let tau = J.transpose() * DVector::from_row_slice(&F_F.to_array());
            let passive = Simulator::new(model.clone());
            let mut scratch = StepScratch::new(&passive);
            let (state, u) = (State::new(q, v), vec![0.0; passive.nu()]);
            let unloaded = passive.acceleration_into(&state, &u, &mut scratch);
            let unloaded = DVector::from_column_slice(unloaded);
            let expected = unloaded + mass_matrix_inverse(&model, q) * tau;
            let what = format!("{} {r:?} at {:?}", model.name(), X_WF.translation);
            for simulator in loaded(&model, place, r) {
                let mut u = vec![0.0; simulator.nu()];
                if let Some(last) = u
                    .last_mut()
                    .filter(|_| !simulator.frame_actuators().is_empty())
                {
                    *last = 1.0;
                }
                let state = State::new(q, v);
                let mut scratch = StepScratch::new(&simulator);
                let a = simulator.acceleration_into(&state, &u, &mut scratch);
                let a = DVector::from_column_slice(a);
                assert_close_vector(&a, &expected, OTHER_ALGORITHM, &what);
            }
        }
    }
}

/// The push as an external force, and as the last input.
fn loaded(model: &Model, place: Anchor, r: Representation) -> [Simulator; 2] {
    let force = ExternalForce::constant(place, push(), r);
    let actuator = FrameActuator::new("push", place, push(), r);
    let simulator = Simulator::new(model.clone());
    [
        simulator.clone().with_external_forces(vec![force]),
        simulator.with_frame_actuators(vec![actuator]),
    ]
}

#[test]
fn momentum_of_a_free_body_under_a_force_of_the_world_equals_its_integral() {
    let model = free_body().with_gravity(Vector3::zeros());
    let (t, dt) = (1.0, 1e-3);
    // About the world's origin a force that is fixed there changes momentum at a constant rate, for any motion of the body.
    let force = ExternalForce::constant(on(&model, "body"), push(), Representation::Inertial);
    let mut start = State::new(
        &[0.3, 0.2, -0.1, 1.0, 0.0, 0.0, 0.0],
        &[0.5, -0.4, 0.3, 1.0, -2.0, 0.7],
    );
    start
        .q
        .rows_mut(3, 4)
        .copy_from_slice(&[0.5, 0.5, -0.5, 0.5]);
    let of = |s: &State| {
        let h = momentum(&model, s.q.as_slice(), s.v.as_slice(), MomentumFrame::World);
        DVector::from_row_slice(&h.to_array())
    };
    let expected = of(&start) + DVector::from_row_slice(&PUSH) * t;
    let error = |integrator: Integrator, dt: f64| {
        let simulator = Simulator::new(model.clone())
            .with_external_forces(vec![force.clone()])
            .with_integrator(integrator)
            .with_time_step(dt);
        let steps = (t / dt).round() as usize;
        let end = simulator.rollout(&start, steps, |_, _, _| {});
        (of(end.last()) - &expected).amax()
    };
    for integrator in INTEGRATORS {
        // Runge and Kutta's is of fourth order, those of Euler are of first order.
        let (long, short) = (error(integrator, dt), error(integrator, 0.5 * dt));
        let fourth = integrator == Integrator::RungeKutta4;
        let most = if fourth { long / 14.0 } else { 0.6 * long };
        let right = long < if fourth { 1e-7 } else { 0.5 };
        assert!(
            right && short < most,
            "{integrator:?}: {long:e}, then {short:e}"
        );
    }
}

#[test]
fn jet_at_the_centre_of_mass_and_reaction_wheel_have_their_closed_forms() {
    // At rest in space: a thrust that turns with nothing moves along a line, a torque about a principal axis spins
    // about it.
    let mut builder = ModelBuilder::new("probe").with_gravity([0.0; 3]);
    builder.add_link(LinkSpec::new("hull").with_mass(2.0, [0.0; 3], [0.1, 0.2, 0.3]));
    let model = builder.build().expect("a robot that is known to be right");
    let place = on(&model, "hull");
    let wheel = Force::from_array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    let actuators = vec![
        FrameActuator::thruster("jet", place, [0.0, 0.0, 3.0], 0.0),
        FrameActuator::new("wheel", place, wheel, Representation::Body),
    ];
    let probe = Simulator::new(model)
        .with_frame_actuators(actuators)
        .with_integrator(Integrator::RungeKutta4)
        .with_time_step(0.01);
    assert_eq!(probe.input_names(), ["jet", "wheel"]);
    let end = probe.rollout(&probe.neutral_state(), 100, |_, _, u| {
        u.copy_from_slice(&[4.0, 0.6]);
    });
    let end = end.last();
    // z = F t² / 2 m, ω = τ t / I
    assert!((end.q[2] - 1.0).abs() < SAME_ALGEBRA && (end.v[2] - 2.0).abs() < SAME_ALGEBRA);
    assert!((end.v[5] - 2.0).abs() < SAME_ALGEBRA);
}

/// All sorts of forces at once.
fn with_everything(simulator: Simulator) -> Simulator {
    let place = tip(simulator.model()).expect("a robot that moves");
    let both = |r| {
        [
            ExternalForce::constant(place, push(), r),
            ExternalForce::function(place, Spring, &SPRING, r),
        ]
    };
    let name = |r: Representation| format!("{r:?}");
    let actuators = REPRESENTATIONS.map(|r| FrameActuator::new(name(r), place, push(), r));
    let thruster = FrameActuator::thruster("thruster", place, [0.3, -0.2, 1.0], 0.05);
    simulator
        .with_external_forces(REPRESENTATIONS.into_iter().flat_map(both).collect())
        .with_frame_actuators([&actuators[..], &[thruster]].concat())
}

#[test]
fn jacobians_under_forces_on_frames_equal_finite_differences_with_every_integrator() {
    for model in robots() {
        if tip(&model).is_none() {
            continue;
        }
        for integrator in INTEGRATORS {
            let simulator = with_everything(Simulator::new(model.clone()));
            let simulator = simulator.with_integrator(integrator).with_time_step(0.01);
            let point = random_point(&model, 8);
            let state = State::new(point.q.as_slice(), point.v.as_slice());
            let u: Vec<f64> = (0..simulator.nu()).map(|k| (k as f64).cos()).collect();
            let exact = simulator.linearize(&state, &u);
            let numeric = simulator
                .estimate_linearization(&state, &u, &finite_difference::Options::default())
                .linearization;
            let what = format!("{} {integrator:?}", model.name());
            assert_close(&exact.a, &numeric.a, FINITE_DIFFERENCE, &what);
            assert_close(&exact.b, &numeric.b, FINITE_DIFFERENCE, &what);
        }
    }
}

/// A quadruped that touches the ground and holds two feet together.
fn standing(law: ContactLaw, integrator: Integrator) -> (Simulator, State) {
    let model = asset("quadruped.urdf");
    let feet = ["FR_foot", "FL_foot", "RR_foot", "RL_foot"];
    let contacts = Contacts::new(&model, Terrain::incline(0.1), law);
    let contacts = contacts.with_links(&model, &feet).expect("feet");
    let tied = Constraint::distance([on(&model, "FL_foot"), on(&model, "RL_foot")], 0.35);
    let simulator = Simulator::new(model)
        .with_contacts(contacts)
        .with_constraints(vec![tied])
        .with_integrator(integrator);
    let simulator = with_everything(simulator);
    let mut state: State = simulator.neutral_state();
    state.v[2] = -0.5;
    for _ in 0..20 {
        let (model, contacts) = (simulator.model(), simulator.contacts().expect("contact"));
        let points = contacts.states(model, state.q.as_slice(), state.v.as_slice());
        let depth = points.iter().map(|point| point.depth);
        state.q[2] += depth.fold(f64::NEG_INFINITY, f64::max) - 1e-3;
    }
    (simulator, state)
}

#[test]
fn jacobians_in_inputs_of_thrusters_with_contact_and_a_loop_equal_differences() {
    let laws = [
        ContactLaw::Soft(SoftContact::estimate(12.0, 4, 1e-3)),
        ContactLaw::RelaxedRigid(RelaxedRigid::default()),
        ContactLaw::Rigid(Rigid::default()),
    ];
    for (law, integrator) in laws.iter().flat_map(|&law| INTEGRATORS.map(|by| (law, by))) {
        if integrator == Integrator::RungeKutta4 && matches!(law, ContactLaw::Rigid(_)) {
            continue; // it acts over a step
        }
        let (simulator, state) = standing(law, integrator);
        let u = vec![0.1; simulator.nu()];
        let b = simulator.linearize(&state, &u).b;
        for input in simulator.nu() - simulator.frame_actuators().len()..simulator.nu() {
            let moved = |by: f64| {
                let mut u = u.clone();
                u[input] += by;
                let next = simulator.step(&state, &u);
                let start = simulator.step(&state, &vec![0.1; simulator.nu()]);
                next.deviation(simulator.model(), &start)
            };
            let size = 1e-4;
            let numeric = (moved(size) - moved(-size)) / (2.0 * size);
            let error = (b.column(input) - numeric).amax() / b.column(input).amax();
            assert!(
                error < 1e-5,
                "{law:?} {integrator:?} input {input}: {error:e}"
            );
        }
    }
}

#[test]
fn batch_under_forces_on_frames_equals_single_simulators_to_the_bit() {
    let n = BATCH_WIDTH + 3;
    for (model, integrator) in robots()
        .into_iter()
        .flat_map(|m| INTEGRATORS.map(|by| (m.clone(), by)))
    {
        if tip(&model).is_none() {
            continue;
        }
        let simulator = with_everything(Simulator::new(model).with_integrator(integrator));
        let mut rng = generator(4);
        let random = |_| State::random(simulator.model(), &mut rng, 1.0);
        let starts: Vec<State> = (0..n).map(random).collect();
        let nu = simulator.nu();
        let inputs: Vec<f64> = (0..n * nu).map(|k| (k as f64).sin()).collect();
        let mut batch = BatchSimulator::new(simulator.clone(), n);
        let mut states = batch.states(&starts);
        batch.step(&mut states, &inputs);
        for (i, start) in starts.iter().enumerate() {
            let own = simulator.step(start, &inputs[i * nu..(i + 1) * nu]);
            let name = simulator.model().name();
            assert_eq!(states.state(i), own, "{name} {integrator:?} state {i}");
        }
    }
}

#[test]
fn floating_joint_with_a_name_takes_a_force_and_a_torque_in_its_body() {
    let mut builder = ModelBuilder::new("probe");
    builder.add_link(LinkSpec::new("world"));
    builder.add_link(LinkSpec::new("hull").with_mass(2.0, [0.1, 0.0, 0.2], [0.1, 0.2, 0.3]));
    builder.add_joint(JointSpec::new("free", JointKind::Floating, "world", "hull"));
    let model = builder.build().expect("a robot that is known to be right");
    let point = random_point(&model, 1);
    let state = State::new(point.q.as_slice(), point.v.as_slice());
    let by_joint = Simulator::new(model.clone());
    assert_eq!(by_joint.input_names()[5], "free.5");
    let wrench = FrameActuator::wrench("hull", on(&model, "hull"), Representation::Body);
    let by_frame = Simulator::new(model)
        .with_actuated_joints(&[])
        .expect("no joint");
    let by_frame = by_frame.with_frame_actuators(wrench.to_vec());
    let (one, two) = (by_joint.step(&state, &PUSH), by_frame.step(&state, &PUSH));
    assert!(one.deviation(by_joint.model(), &two).amax() < 10.0 * ROUNDING);
}

#[test]
fn thrust_beyond_a_limit_is_that_of_the_limit_and_derivatives_at_it_are_those_inside() {
    let model = free_body();
    let place = on(&model, "body");
    let jet = FrameActuator::thruster("jet", place, [0.0, 0.0, 1.0], 0.0);
    let free = Simulator::new(model.clone()).with_frame_actuators(vec![jet.clone()]);
    let limited = Simulator::new(model).with_frame_actuators(vec![jet.with_limits(-1.0, 5.0)]);
    let state = limited.neutral_state();
    for (asked, given) in [(9.0, 5.0), (-2.0, -1.0), (3.0, 3.0)] {
        assert_eq!(limited.step(&state, &[asked]), free.step(&state, &[given]));
    }
    let b = |simulator: &Simulator, u: f64| simulator.linearize(&state, &[u]).b;
    for at in [-1.0, 0.0, 5.0] {
        assert_eq!(b(&limited, at), b(&free, at));
    }
    assert_eq!(b(&limited, 5.1).amax(), 0.0);
    assert_eq!(limited.effort_bounds(), (vec![-1.0], vec![5.0]));
}

/// Where a body is after some steps, as a function of a push and the parameters of a spring.
struct Pulled(Simulator, State);

impl VectorFunction for Pulled {
    fn n_outputs(&self) -> usize {
        self.1.len()
    }

    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let forces = self.0.external_forces();
        let push = Force::from_array(std::array::from_fn(|k| x[k]));
        let forces = vec![
            forces[0].with_force(push),
            forces[1].with_parameters(&x[6..]),
        ];
        let simulator = self.0.cast::<T>().with_external_forces(forces);
        let mut state = self.1.cast::<T>();
        for _ in 0..5 {
            state = simulator.step(&state, &[]);
        }
        state.copy_to_slice(y);
    }
}

#[test]
fn derivatives_in_forces_and_parameters_of_functions_equal_finite_differences() {
    let model = free_body();
    let place = on(&model, "body").moved([0.1, 0.0, 0.2]);
    let point = random_point(&model, 2);
    for r in REPRESENTATIONS {
        let forces = vec![
            ExternalForce::constant(place, push(), r),
            ExternalForce::function(place, Spring, &SPRING, r),
        ];
        let simulator = Simulator::new(model.clone()).with_time_step(0.02);
        let simulator = simulator.with_external_forces(forces);
        let state = State::new(point.q.as_slice(), point.v.as_slice());
        let f = Pulled(simulator, state);
        let x = [&PUSH[..], &SPRING].concat();
        let (exact, numeric) = (jacobian(&f, &x), finite_difference::jacobian(&f, &x));
        let error = relative_error(&exact, &numeric);
        assert!(
            exact.amax() > 1e-3 && error < FINITE_DIFFERENCE,
            "{r:?}: {error:e}"
        );
    }
}

#[test]
fn places_and_numbers_that_make_no_sense_are_refused_by_name() {
    fn message(act: impl FnOnce()) -> String {
        let panic = catch_unwind(AssertUnwindSafe(act)).expect_err("it is refused");
        let text = panic.downcast_ref::<String>().cloned();
        text.or(panic.downcast_ref::<&str>().map(|&s| s.to_owned()))
            .expect("a message")
    }
    let model = free_body();
    let unknown = Anchor::frame(&model, "rotor").expect_err("there is none");
    assert!(unknown.to_string().contains("\"rotor\""));
    let place = on(&model, "body");
    let jet = |direction, ratio| FrameActuator::thruster("jet", place, direction, ratio);
    let cases: [(&str, &dyn Fn()); 6] = [
        (
            "the direction [0.0, 0.0, 0.0] of \"jet\" has no length",
            &|| drop(jet([0.0; 3], 0.0)),
        ),
        ("NaN] (N, N·m) is not finite", &|| {
            drop(jet([0.0, 0.0, 1.0], f64::NAN));
        }),
        ("the limits 2 and 1 of \"jet\" are not in order", &|| {
            drop(jet([0.0, 0.0, 1.0], 0.0).with_limits(2.0, 1.0));
        }),
        ("two frame actuators are called \"jet\"", &|| {
            let both = vec![jet([0.0, 0.0, 1.0], 0.0), jet([1.0, 0.0, 0.0], 0.0)];
            drop(Simulator::new(model.clone()).with_frame_actuators(both));
        }),
        (
            "\"jet\" acts on \"body\", which is fixed to the world in \"free_body\"",
            &|| {
                let mut builder = model.to_builder();
                builder = builder.with_base(Base::Fixed);
                let fixed = builder.build().expect("a statue");
                let place = on(&fixed, "body");
                let jet = FrameActuator::thruster("jet", place, [0.0, 0.0, 1.0], 0.0);
                drop(Simulator::new(fixed).with_frame_actuators(vec![jet]));
            },
        ),
        ("an external force acts on \"the world\"", &|| {
            let force = ExternalForce::constant(Anchor::world(), push(), Representation::Mixed);
            drop(Simulator::new(model.clone()).with_external_forces(vec![force]));
        }),
    ];
    for (expected, act) in cases {
        let text = message(act);
        assert!(text.contains(expected), "{text}");
    }
}

#[test]
fn recorded_arrows_equal_the_thrust_along_the_axis_of_the_rotor() {
    let model = asset("quadrotor.urdf");
    let actuators = ["front", "rear"].map(|name| {
        FrameActuator::thruster(name, on(&model, name), [0.0, 0.0, 1.0], 0.01).with_limits(0.0, 3.0)
    });
    let drone = Simulator::new(model).with_frame_actuators(actuators.to_vec());
    let start = State::new(&[0.0, 0.0, 0.0, 0.5, 0.5, 0.5, 0.5], &[0.0; 6]); // its z along the world's x
    let flight = drone.rollout(&start, 3, |_, _, u| u.copy_from_slice(&[2.0, 4.0]));
    let mut recording = Recording::from_rollout(drone.model(), &flight);
    recording.robot_mut(0).add_applied_forces(&drone);
    let forces = recording.robots()[0].forces();
    assert_eq!(forces.len(), 2);
    for (force, thrust) in forces.iter().zip([2.0, 3.0]) {
        assert!((force.values[0] - vector![thrust, 0.0, 0.0]).norm() < SAME_ALGEBRA);
        assert_eq!(force.values.len(), 4);
        assert!((force.values[3].norm() - thrust).abs() < SAME_ALGEBRA);
    }
    let page = recording.to_html();
    assert!(page.contains("\"forces\":[{\"frame\":"));
}

#[test]
fn forward_dynamics_of_gravity_and_lift_leaves_a_balloon_at_rest() {
    let model = free_body();
    let weight = model.total_mass() * 9.81;
    // Lift at the centre of mass, which is not the origin of the link.
    let place = on(&model, "body").moved([0.1, -0.2, 0.05]);
    let lift = Force::from_array([0.0, 0.0, weight, 0.0, 0.0, 0.0]);
    let lift = ExternalForce::constant(place, lift, Representation::Mixed);
    let balloon = Simulator::new(model.clone()).with_external_forces(vec![lift]);
    let point = random_point(&model, 6);
    let start = State::new(point.q.as_slice(), &[0.0; 6]);
    let end = balloon.rollout(&start, 500, |_, _, _| {});
    assert!(end.last().deviation(&model, &start).amax() < OTHER_ALGORITHM);
    let fall = forward_dynamics(&model, point.q.as_slice(), &[0.0; 6], &[0.0; 6]);
    assert!((fall.rows(0, 3).norm() - 9.81).abs() < OTHER_ALGORITHM);
}

#[test]
fn planned_flight_to_a_waypoint_obeys_dynamics_and_limits_from_any_guess() {
    let model = asset("quadrotor.urdf");
    let rotors = [
        ("front", 0.016),
        ("left", -0.016),
        ("rear", 0.016),
        ("right", -0.016),
    ];
    let rotors = rotors.map(|(name, ratio)| {
        let rotor = FrameActuator::thruster(name, on(&model, name), [0.0, 0.0, 1.0], ratio);
        rotor.with_limits(0.1, 5.0)
    });
    let drone = Simulator::new(model)
        .with_frame_actuators(rotors.to_vec())
        .with_time_step(0.03);
    let mut goal: State = drone.neutral_state();
    (goal.q[0], goal.q[2]) = (1.0, 1.0);
    let start = drone.pack(&drone.neutral_state());
    let weights = Activation::Weighted([[1.0; 6], [0.1; 6]].concat());
    let to = || StateError::to(drone.pack(&goal).as_slice());
    let hover = 9.81 / 4.0;
    let running = Cost::new().with(0.1, weights.clone(), to()).with(
        1e-2,
        Activation::Quadratic,
        InputError::to(&[hover; 4]),
    );
    let (lower, upper) = drone.effort_bounds();
    let problem = Problem::new(drone.clone(), 33, start.as_slice())
        .with_stage_cost(running)
        .with_final_cost(Cost::new().with(3.0, weights, to()))
        .with_input_bounds(&lower, &upper);
    let costs = [0.1, 2.0, hover].map(|thrust| {
        let mut guess = Trajectory::zero_input(&problem);
        guess.inputs.iter_mut().for_each(|u| u.fill(thrust));
        let options = DdpOptions {
            max_iterations: 200,
            ..DdpOptions::default()
        };
        let plan = Ddp::with_options(&problem, options)
            .solve(&problem, &guess)
            .clone();
        assert!(plan.is_converged(), "{}", plan.status);
        let all = plan.trajectory.inputs.iter().flatten();
        assert!(all.into_iter().all(|u| (0.1..=5.0).contains(u)));
        let flown = Trajectory::rollout(&problem, &plan.trajectory.inputs);
        let end = drone.unpack(flown.states[33].as_slice());
        assert!(end.deviation(drone.model(), &goal).amax() < 0.2);
        plan.cost
    });
    assert!(
        costs
            .iter()
            .all(|cost| (cost - costs[0]).abs() < 1e-6 * costs[0]),
        "{costs:?}"
    );
}
