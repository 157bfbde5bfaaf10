//! The time step as a parameter: its derivatives against forward mode, finite differences and closed forms, and other functions of it.

use std::panic::{AssertUnwindSafe, catch_unwind};

use dualbody::autodiff::{VectorFunction, finite_difference, gradient, jacobian};
use dualbody::constraint::{Anchor, Constraint};
use dualbody::contact::{
    ContactLaw, Impedance, RelaxedRigid, Rigid, Sigmoid, Smoothing, SoftContact, Terrain,
};
use dualbody::linearize::RolloutCost;
use dualbody::model::samples;
use dualbody::scalar::Lanes;
use dualbody::sim::{RolloutStatus, SimulatorParameterGroup};
use dualbody::{Cast, Integrator, Model, Scalar, Simulator, State, codegen};
use nalgebra::DVector;

use crate::common::everything::INTEGRATORS;
use crate::common::ground::{free, on};
use crate::common::{OTHER_ALGORITHM, SAME_ALGEBRA, asset, free_body};
use crate::step_adjoints::{Case, closed_loops, solved_contact, uneven_ground};
use crate::yielding_constraints::all_sorts;

/// Finite differences of a step.
const DIFFERENCES: f64 = 1e-6;

/// λᵀ x⁺ as a function of the time step.
struct Weighted<'a> {
    simulator: &'a Simulator,
    state: &'a State,
    u: &'a [f64],
    adjoint: &'a DVector<f64>,
}

/// The simulator with another time step.
fn with_step<T: Scalar>(simulator: &Simulator, dt: T) -> Simulator<T> {
    let mut parameters = simulator.parameters().map(T::constant);
    let last = parameters.len() - 1;
    parameters[last] = dt;
    simulator.with_parameters(parameters.as_slice())
}

impl VectorFunction for Weighted<'_> {
    fn n_outputs(&self) -> usize {
        1
    }

    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let variant = with_step(self.simulator, x[0]);
        let u: Vec<T> = self.u.iter().map(|&u| T::constant(u)).collect();
        let next = variant.step(&self.state.cast::<T>(), &u);
        let here = self.simulator.step(self.state, self.u).cast::<T>();
        let change = next.deviation(self.simulator.model(), &here);
        let products = change.iter().zip(self.adjoint);
        y[0] = products.fold(T::zero(), |sum, (&x, &weight)| sum + x * weight);
    }
}

/// The derivative of the step in the time step by adjoints, which must equal that of forward mode and, on request, of finite differences. Returns how far it
/// is from zero.
fn assert_slope(simulator: &Simulator, state: &State, u: &[f64], what: &str, differs: bool) -> f64 {
    let adjoint = DVector::from_fn(simulator.n_tangent(), |k, _| (k as f64 + 0.3).sin());
    let all = simulator.vjp(state, u, adjoint.as_slice()).parameters;
    let found = all[all.len() - 1];
    let weighted = Weighted {
        simulator,
        state,
        u,
        adjoint: &adjoint,
    };
    let dt = [simulator.time_step()];
    let forward = gradient(&weighted, &dt)[0];
    let error = (found - forward).abs() / (1.0 + forward.abs());
    assert!(error < OTHER_ALGORITHM, "{what}: {found}, not {forward}");
    if differs {
        let options = finite_difference::Options::default();
        let by = finite_difference::estimate(&weighted, &dt, &options);
        let (expected, doubt) = (by.jacobian[0], by.error[0]);
        let error = (found - expected).abs() / (1.0 + expected.abs());
        assert!(
            error < DIFFERENCES,
            "{what}: {found}, not {expected} ± {doubt:e}"
        );
    }
    found.abs()
}

fn assert_slopes(cases: Vec<Case>) {
    let mut moved = 0;
    for case in &cases {
        let (simulator, state, u) = (&case.simulator, &case.state, case.u.as_slice());
        let slope = assert_slope(simulator, state, u, &case.name, true);
        moved += usize::from(slope > 1e-3);
    }
    assert!(2 * moved > cases.len(), "{moved} of {}", cases.len());
}

#[test]
fn slope_in_the_time_step_of_every_robot_and_term_is_right() {
    assert_slopes(Case::all());
}

#[test]
fn slope_in_the_time_step_through_solved_contact_is_right() {
    assert_slopes(solved_contact());
}

#[test]
fn slope_in_the_time_step_over_uneven_ground_is_right() {
    assert_slopes(uneven_ground());
}

#[test]
fn slope_in_the_time_step_of_closed_loops_is_right() {
    assert_slopes(closed_loops());
}

// T = max(T₀, 2 Δt): with the constant of the tests the step does not reach it, with short ones it does.
#[test]
fn slope_in_the_time_step_is_right_on_both_sides_of_the_shortest_time_constant() {
    for case in closed_loops() {
        for time_constant in [1e-3, 3e-3, 0.1] {
            let constraints = case.simulator.constraints().iter();
            let constraints = constraints.map(|c| c.clone().with_time_constant(time_constant));
            let simulator = case.simulator.clone();
            let simulator = simulator.with_constraints(constraints.collect());
            let what = format!("{}, {time_constant} s", case.name);
            assert_slope(&simulator, &case.state, case.u.as_slice(), &what, true);
        }
    }
}

#[test]
fn slope_in_the_time_step_of_constraints_that_give_way_is_right() {
    for integrator in INTEGRATORS {
        for (which, (simulator, state)) in all_sorts().into_iter().enumerate() {
            let simulator = simulator.with_integrator(integrator).with_time_step(0.002);
            let u = vec![0.1; simulator.nu()];
            let what = format!("{integrator:?}, {which}");
            assert_slope(&simulator, &state, &u, &what, true);
        }
    }
}

// A bound is not a force of the path, and scales with the others.
#[test]
fn slope_in_the_time_step_of_bounded_forces_beside_smoothed_contact_is_right() {
    for (what, simulator, state) in balls(0.01, -0.2) {
        let model = simulator.model();
        let link = Anchor::frame(model, model.link_names()[0]).expect("a link");
        let nail = Anchor::world().moved([0.1, 0.2, 0.3]);
        for bound in [0.5, 1e6] {
            let tied = Constraint::ball([link, nail]).with_largest_force(bound);
            let simulator = simulator.clone().with_constraints(vec![tied]);
            let what = format!("{what}, {bound} N");
            assert_slope(&simulator, &state, &[], &what, true);
        }
    }
}

/// A ball near an incline, with every law, exact and smoothed.
fn balls(height: f64, v: f64) -> Vec<(String, Simulator, State)> {
    let shaped = RelaxedRigid {
        impedance: Impedance {
            sigmoid: Sigmoid::new(0.4, 3.0),
            ..Impedance::default()
        },
        ..RelaxedRigid::default()
    };
    let rigid = Rigid {
        restitution: 0.4,
        ..Rigid::default()
    };
    let mut all = Vec::new();
    for integrator in [Integrator::SemiImplicitEuler, Integrator::ImplicitVelocity] {
        for law in [
            ContactLaw::Soft(SoftContact::estimate(1.0, 1, 1e-3)),
            ContactLaw::RelaxedRigid(RelaxedRigid::default()),
            ContactLaw::RelaxedRigid(shaped),
            ContactLaw::Rigid(rigid),
        ] {
            let ball = on(asset("sphere.urdf"), Terrain::incline(0.05), law);
            let exact = ball.with_integrator(integrator);
            let mut simulators = vec![exact.clone()];
            if !matches!(law, ContactLaw::Soft(_)) {
                let contacts = exact.contacts().expect("contacts").clone();
                let smoothed = contacts.with_smoothing(Smoothing::new(0.5));
                simulators.push(exact.with_contacts(smoothed));
            }
            for simulator in simulators {
                let velocity = [0.3, -0.1, v, 0.2, 0.5, -0.4];
                let state = free(&simulator, [0.0, 0.0, 0.1 + height], 0.0, velocity);
                let smoothing = simulator.contacts().and_then(|c| c.smoothing());
                let what = format!("{law:?}, {smoothing:?}, {integrator:?}, {height}, {v}");
                all.push((what, simulator, state));
            }
        }
    }
    all
}

// Impacts with restitution, error reduction, closing on the ground, and smoothed forces above it.
#[test]
fn slope_in_the_time_step_of_impacts_and_of_smoothed_contact_is_right() {
    for (height, v) in [(-1e-3, -0.5), (-1e-3, 0.0), (2e-4, -2.0), (0.01, -0.2)] {
        for (what, simulator, state) in balls(height, v) {
            assert_slope(&simulator, &state, &[], &what, true);
        }
    }
}

#[test]
fn slope_in_the_time_step_of_smoothed_contact_of_a_moment_is_right() {
    let law = ContactLaw::RelaxedRigid(RelaxedRigid::default());
    let ball = on(asset("sphere.urdf"), Terrain::flat(0.0), law);
    let contacts = ball.contacts().expect("contacts").clone();
    let simulator = ball
        .with_contacts(contacts.with_smoothing(Smoothing::new(1.0)))
        .with_integrator(Integrator::RungeKutta4);
    let state = free(
        &simulator,
        [0.0, 0.0, 0.102],
        0.0,
        [0.1, 0.0, -0.3, 0.0, 0.2, 0.0],
    );
    assert_slope(&simulator, &state, &[], "smoothed", true);
}

/// The sum of the coordinates and the speeds at the end, with weights.
struct End;

impl RolloutCost for End {
    fn end<T: Scalar>(&self, last: &State<T>) -> T {
        let numbers = last.numbers().enumerate();
        numbers.fold(T::zero(), |sum, (k, &x)| {
            sum + x.sin_cos().0 * (k as f64 + 0.4).cos()
        })
    }
}

/// That of a rollout without input as a function of the time step.
struct Total<'a>(&'a Simulator, &'a State, usize);

impl VectorFunction for Total<'_> {
    fn n_outputs(&self) -> usize {
        1
    }

    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let Self(simulator, start, steps) = self;
        let variant = with_step(simulator, x[0]);
        let trajectory = variant.rollout_over(&start.cast::<T>(), *steps, |_, _, _| {});
        y[0] = End.end(trajectory.last());
    }
}

#[test]
fn slope_of_rollouts_in_the_time_step_is_that_of_forward_mode_and_finite_differences() {
    const STEPS: usize = 8;
    let of = |case: Case| (case.name, case.simulator, case.state);
    let mut all: Vec<_> = balls(-5e-4, -0.1);
    all.extend(Case::all().into_iter().step_by(3).map(of));
    all.extend(closed_loops().into_iter().step_by(2).map(of));
    // Derivatives of a fast rotation grow without bounds.
    all.retain(|(what, ..)| !what.contains("whirling"));
    for (what, simulator, start) in all {
        // The gradient of a rollout that ends early is none.
        let rollout = simulator.rollout(&start, STEPS, |_, _, _| {});
        if rollout.status != RolloutStatus::Completed {
            continue;
        }
        let total = Total(&simulator, &start, STEPS);
        let inputs = vec![DVector::zeros(simulator.nu()); STEPS];
        let gradient = simulator.rollout_gradient(&start, &inputs, &End).parameters;
        let adjoint = gradient[gradient.len() - 1];
        let forward = jacobian(&total, &[simulator.time_step()])[0];
        let size = 1.0 + forward.abs();
        assert!(
            (adjoint - forward).abs() < 1e-8 * size,
            "{what}: {adjoint}, not {forward}"
        );
        let options = finite_difference::Options::default();
        let by = finite_difference::estimate(&total, &[simulator.time_step()], &options);
        let error = (adjoint - by.jacobian[0]).abs();
        assert!(
            error < 1e-5 * size + 4.0 * by.error[0],
            "{what}: {adjoint}, not {} ± {:e}",
            by.jacobian[0],
            by.error[0]
        );
    }
}

// z = z₀ − g Δt² n (n + 1) / 2 after n steps of free fall.
#[test]
fn slope_of_a_free_fall_in_the_time_step_equals_the_closed_form() {
    const STEPS: usize = 20;
    struct Height;
    impl RolloutCost for Height {
        fn end<T: Scalar>(&self, last: &State<T>) -> T {
            last.q[2]
        }
    }
    let simulator = Simulator::new(free_body()).with_time_step(0.01);
    let mut start = simulator.neutral_state();
    start.v[0] = 3.0;
    let inputs = vec![DVector::zeros(simulator.nu()); STEPS];
    let found = simulator.rollout_gradient(&start, &inputs, &Height);
    let n = STEPS as f64;
    let expected = -9.81 * 0.01 * n * (n + 1.0);
    let slope = found.parameters[found.parameters.len() - 1];
    assert!((slope - expected).abs() < 1e-12, "{slope} {expected}");
}

#[test]
fn time_step_is_the_last_parameter_and_goes_round() {
    let simulator = Simulator::new(samples::arm()).with_time_step(0.02);
    let (p, layout) = (simulator.parameters(), simulator.parameter_layout());
    let last = p.len() - 1;
    assert_eq!(layout.find("time step").ok(), Some(last));
    assert_eq!(p[last], 0.02);
    let range = layout.range(SimulatorParameterGroup::TimeStep);
    assert_eq!(range, Some(last..last + 1));
    assert_eq!(with_step(&simulator, 0.03).time_step(), 0.03);
    assert_eq!(with_step(&simulator, 0.03).parameters()[last], 0.03);
    assert_eq!(simulator.cast::<Lanes<2>>().time_step(), Lanes([0.02; 2]));
    let state = simulator.state(&[0.1; 7], &[0.2; 7]);
    let by_parameter = with_step(&simulator, 0.03).step(&state, &[0.0; 7]);
    let set = simulator.with_time_step(0.03);
    assert_eq!(set.step(&state, &[0.0; 7]), by_parameter);
}

#[test]
fn time_step_that_is_not_positive_is_refused_by_its_name() {
    let simulator = Simulator::new(samples::pendulum());
    for dt in [0.0, -1e-3, f64::NAN, f64::INFINITY] {
        let refused = catch_unwind(AssertUnwindSafe(|| with_step(&simulator, dt)));
        let message = refused.expect_err("a time step that makes no sense");
        let message = message.downcast_ref::<String>().expect("a message");
        let expected = format!("the time step is {dt}: not positive and finite");
        assert!(message.contains(&expected), "{message}");
    }
}

// Each lane with its own step, as if by itself.
#[test]
fn lanes_may_have_time_steps_of_their_own() {
    let mut all: Vec<(String, Simulator, State)> = balls(-5e-4, -0.1);
    let of = |case: Case| (case.name, case.simulator, case.state);
    all.extend(Case::all().into_iter().step_by(3).map(of));
    all.extend(closed_loops().into_iter().step_by(5).map(of));
    for (what, simulator, state) in all {
        let u: Vec<f64> = (0..simulator.nu()).map(|k| (k as f64).cos()).collect();
        let steps = [1.0, 0.5, 1.7, 0.9].map(|x| x * simulator.time_step());
        let variant = with_step(&simulator, Lanes(steps));
        let lanes = |x: f64| Lanes::<4>::constant(x);
        let over: Vec<_> = u.iter().map(|&u| lanes(u)).collect();
        let next = variant.step(&state.cast(), &over);
        for (lane, dt) in steps.into_iter().enumerate() {
            let expected = simulator.clone().with_time_step(dt).step(&state, &u);
            for (found, expected) in next.numbers().zip(expected.numbers()) {
                let error = (found.0[lane] - expected).abs() / (1.0 + expected.abs());
                assert!(error < 1e-10, "{what}, lane {lane}: {found:?} {expected}");
            }
        }
    }
}

fn graph_of_variants(model: Model, integrator: Integrator, state: &State) {
    let simulator = Simulator::new(model)
        .with_integrator(integrator)
        .with_time_step(0.01);
    let graph = codegen::step_of_variants(&simulator, &["time step"]).expect("a parameter");
    let u: Vec<f64> = (0..simulator.nu()).map(|k| (k as f64).cos()).collect();
    for dt in [0.01, 0.004] {
        let inputs: Vec<f64> = state.numbers().chain(&u).copied().chain([dt]).collect();
        let found = graph.evaluate(&inputs).expect("slow motion");
        let expected = simulator.clone().with_time_step(dt).step(state, &u);
        for (found, expected) in found.iter().zip(expected.numbers()) {
            let error = (found - expected).abs() / (1.0 + expected.abs());
            assert!(error < SAME_ALGEBRA, "{integrator:?}: {found} {expected}");
        }
    }
    // The graph assumes slow rotation: the same at a step in which it would be fast, or not.
    let fast = State::new(state.q.as_slice(), state.v.map(|_| 1e3).as_slice());
    let inputs: Vec<f64> = fast.numbers().chain(&u).copied().chain([0.01]).collect();
    let holds = graph.evaluate(&inputs).is_ok();
    assert_eq!(holds, integrator != Integrator::SemiImplicitEuler);
}

#[test]
fn graphs_of_steps_have_the_time_step_as_an_input() {
    let model = samples::arm().with_damping(2, 0.3);
    let state = Simulator::new(model.clone()).state(&[0.1; 7], &[0.2; 7]);
    for integrator in [
        Integrator::SemiImplicitEuler,
        Integrator::ImplicitVelocity,
        Integrator::RungeKutta4,
    ] {
        graph_of_variants(model.clone(), integrator, &state);
    }
}
