//! The implicit midpoint rule: order, derivatives by other means, and conserved quantities.

use dualbody::autodiff::Dual;
use dualbody::autodiff::finite_difference;
use dualbody::cone::Status;
use dualbody::dynamics::{
    MomentumFrame, elastic_energy, kinetic_energy, momentum, potential_energy,
};
use dualbody::joint::JointKind;
use dualbody::model::{JointSpec, LinkSpec, ModelBuilder, samples};
use dualbody::sim::{BATCH_WIDTH, StepScratch};
use dualbody::{Integrator, Lanes, Model, Simulator, State};
use nalgebra::{DVector, Vector3};

use crate::common::{asset, generator};
use crate::constraints::{four_bar, tangled};
use crate::integrators;

fn midpoint(model: Model, dt: f64) -> Simulator {
    Simulator::new(model)
        .with_integrator(Integrator::ImplicitMidpoint)
        .with_time_step(dt)
}

fn random_state(model: &Model, seed: u64, speed: f64) -> State {
    let mut rng = generator(seed);
    let q = model.random_configuration(&mut rng);
    let v = model.random_velocity(&mut rng, speed);
    State::new(q.as_slice(), v.as_slice())
}

fn lift<const N: usize>(x: &DVector<f64>) -> Vec<Dual<f64, N>> {
    x.iter().map(|&x| Dual::from(x)).collect()
}

/// The state after some steps with an input that is held, each of which must have been found.
fn go(simulator: &Simulator, start: &State, u: f64, steps: usize) -> State {
    let u = vec![u; simulator.nu()];
    let (mut x, mut next) = (start.clone(), start.clone());
    let mut scratch = StepScratch::new(simulator);
    for _ in 0..steps {
        simulator.step_into(&x, &u, &mut scratch, &mut next);
        assert_eq!(scratch.solver_status(0), Status::Converged);
        std::mem::swap(&mut x, &mut next);
    }
    x
}

#[test]
fn error_falls_with_the_square_of_the_step() {
    for seed in 0..4 {
        let model = samples::random_tree(6, seed).with_damping(0, 0.1);
        let start = random_state(&model, seed, 1.0);
        let fine = Simulator::new(model.clone())
            .with_integrator(Integrator::RungeKutta4)
            .with_time_step(5e-4);
        let exact = go(&fine, &start, 0.3, 400);
        let error = |steps: usize| {
            let simulator = midpoint(model.clone(), 0.2 / steps as f64);
            let end = go(&simulator, &start, 0.3, steps);
            end.deviation(&model, &exact).amax()
        };
        let ratio = error(20) / error(40);
        assert!((3.7..4.3).contains(&ratio), "seed {seed}: {ratio}");
    }
}

#[test]
fn jacobians_equal_differences_and_gradients_equal_them() {
    for seed in 0..6 {
        let model = samples::random_tree(6, seed).with_damping(0, 0.1);
        let state = random_state(&model, seed, 1.0);
        let simulator = midpoint(model, 0.02);
        let u = vec![0.3; simulator.nu()];
        let found = simulator.linearize(&state, &u);
        let expected = simulator
            .estimate_linearization(&state, &u, &finite_difference::Options::default())
            .linearization;
        let error = (&found.a - &expected.a)
            .amax()
            .max((&found.b - &expected.b).amax());
        assert!(error < 5e-8, "seed {seed}: {error:e}");
        let weights = |k: usize| ((k * 7 + 3) % 11) as f64 / 5.0 - 1.0;
        let weights = DVector::from_fn(simulator.n_tangent(), |k, _| weights(k));
        let gradient = simulator.vjp(&state, &u, weights.as_slice());
        let error = (found.a.transpose() * &weights - &gradient.state).amax();
        assert!(error < 1e-11, "seed {seed}, state: {error:e}");
        let error = (found.b.transpose() * &weights - &gradient.input).amax();
        assert!(error < 1e-12, "seed {seed}, input: {error:e}");
    }
}

/// Gradients beside dual numbers, in every so many parameters, and in the time step, which comes last.
///
/// * `limits` – every so many, and the largest error
fn check_parameters(
    simulator: &Simulator,
    state: &State,
    u: &DVector<f64>,
    weights: &[f64],
    (every, tolerance): (usize, f64),
) {
    let gradient = simulator.vjp(state, u.as_slice(), weights);
    let next = simulator.step(state, u.as_slice());
    let next = State::new(&lift::<1>(&next.q), &lift(&next.v));
    let parameters = simulator.parameters();
    let last = parameters.len() - 1;
    for k in (0..parameters.len()).step_by(every).chain([last]) {
        let mut moved = lift::<1>(&parameters);
        moved[k].eps[0] = 1.0;
        let start = State::new(&lift(&state.q), &lift(&state.v));
        let end = simulator.with_parameters(&moved).step(&start, &lift(u));
        let slopes = end.deviation(simulator.model(), &next);
        let expected: f64 = slopes.iter().zip(weights).map(|(x, w)| x.eps[0] * w).sum();
        let error = (gradient.parameters[k] - expected).abs() / (1.0 + expected.abs());
        assert!(error < tolerance, "parameter {k}: {error:e}");
    }
}

#[test]
fn gradients_in_parameters_equal_those_by_dual_numbers() {
    for seed in [0, 3] {
        let model = samples::random_tree(6, seed).with_damping(0, 0.1);
        let state = random_state(&model, seed, 1.0);
        let simulator = midpoint(model, 0.02);
        let u = DVector::from_element(simulator.nu(), 0.3);
        let weights = |k: usize| ((k * 7 + 3) % 11) as f64 / 5.0 - 1.0;
        let weights: Vec<f64> = (0..simulator.n_tangent()).map(weights).collect();
        check_parameters(&simulator, &state, &u, &weights, (5, 1e-9));
    }
}

#[test]
fn lanes_are_steps_one_by_one() {
    let model = samples::random_tree(5, 2);
    let simulator = midpoint(model.clone(), 0.01);
    let states: Vec<State> = (0..BATCH_WIDTH as u64)
        .map(|seed| random_state(&model, seed, 1.0))
        .collect();
    let side_by_side = |n: usize, x: &dyn Fn(&State) -> &DVector<f64>| -> Vec<Lanes<BATCH_WIDTH>> {
        (0..n)
            .map(|k| Lanes(std::array::from_fn(|lane| x(&states[lane])[k])))
            .collect()
    };
    let all = State::new(
        &side_by_side(model.nq(), &|state| &state.q),
        &side_by_side(model.nv(), &|state| &state.v),
    );
    let next = simulator.step(&all, &vec![Lanes([0.2; BATCH_WIDTH]); simulator.nu()]);
    for (lane, state) in states.iter().enumerate() {
        let expected = simulator.step(state, &vec![0.2; simulator.nu()]);
        let q: Vec<f64> = next.q.iter().map(|x| x.0[lane]).collect();
        let v: Vec<f64> = next.v.iter().map(|x| x.0[lane]).collect();
        assert_eq!(
            (&q[..], &v[..]),
            (expected.q.as_slice(), expected.v.as_slice())
        );
    }
}

fn energy(model: &Model, x: &State) -> f64 {
    let (q, v) = (x.q.as_slice(), x.v.as_slice());
    kinetic_energy(model, q, v) + potential_energy(model, q) + elastic_energy(model, q)
}

fn undamped(model: Model) -> Model {
    let nv = model.nv();
    (0..nv).fold(model, |model, k| model.with_damping(k, 0.0))
}

/// A free robot without gravity keeps its linear and angular momentum.
#[test]
fn momentum_of_a_free_robot_is_kept_to_rounding() {
    let model = asset("quadruped.urdf");
    let model = undamped(model).with_gravity(Vector3::zeros());
    let start = random_state(&model, 1, 3.0);
    let of = |x: &State| {
        let (q, v) = (x.q.as_slice(), x.v.as_slice());
        DVector::from_row_slice(&momentum(&model, q, v, MomentumFrame::World).to_array())
    };
    let (before, simulator) = (of(&start), midpoint(model.clone(), 0.01));
    let end = go(&simulator, &start, 0.0, 300);
    let error = (of(&end) - &before).amax() / before.amax();
    assert!(error < 1e-11, "{error:e}");
    // Its joints turn by a third of a radian and more in half of a step.
    let drift = (energy(&model, &end) - energy(&model, &start)).abs();
    assert!(drift < 0.02 * energy(&model, &start), "{drift}");
}

/// A body that tumbles about its middle axis for a very long time, and a top.
#[test]
fn energy_of_spinning_bodies_does_not_drift() {
    let free = samples::random_tree_of(&[JointKind::Floating], 1, 3).with_gravity(Vector3::zeros());
    let point = samples::random_tree_of(&[JointKind::Spherical], 1, 3);
    for model in [undamped(free), undamped(point)] {
        let simulator = midpoint(model.clone(), 0.01);
        let start = random_state(&model, 2, 6.0);
        let whole = kinetic_energy(&model, start.q.as_slice(), start.v.as_slice());
        let first = energy(&model, &go(&simulator, &start, 0.0, 1_000));
        let last = energy(&model, &go(&simulator, &start, 0.0, 20_000));
        assert!(
            (first - last).abs() < 1e-3 * whole,
            "{first} {last} of {whole}"
        );
    }
}

/// A body on three joints about z, x and y without mass between them. At a right angle of the second one the others have one axis.
fn light_hip() -> Model {
    let mut builder = ModelBuilder::new("hip");
    for link in ["world", "first", "second"] {
        builder.add_link(LinkSpec::new(link));
    }
    let body = LinkSpec::new("body").with_mass(1.0, [0.1, 0.05, -0.2], [0.02, 0.03, 0.01]);
    builder.add_link(body);
    for (name, parent, child, axis) in [
        ("z", "world", "first", [0.0, 0.0, 1.0]),
        ("x", "first", "second", [1.0, 0.0, 0.0]),
        ("y", "second", "body", [0.0, 1.0, 0.0]),
    ] {
        let joint = JointSpec::new(name, JointKind::Continuous, parent, child);
        builder.add_joint(joint.with_axis(axis));
    }
    builder.build().unwrap()
}

/// Near that angle, with the first and last joint fast against each other: the body turns by less than 40 rad/s.
fn near_the_lock(away: f64) -> State {
    let right = std::f64::consts::FRAC_PI_2;
    State::new(&[0.3, right - away, -0.2], &[600.0, 4.0, -590.0])
}

/// Joints turn by a third of a circle in a step, which a whole step does not take well.
#[test]
fn steps_in_which_axes_come_into_line_are_divided() {
    let model = light_hip();
    for away in [0.06, 0.03, -0.04] {
        let start = near_the_lock(away);
        let end = go(&midpoint(model.clone(), 1e-3), &start, 0.0, 20);
        let fine = Simulator::new(model.clone())
            .with_integrator(Integrator::RungeKutta4)
            .with_time_step(1e-6);
        let exact = go(&fine, &start, 0.0, 20_000);
        let whole = kinetic_energy(&model, start.q.as_slice(), start.v.as_slice());
        let drift = (energy(&model, &end) - energy(&model, &start)).abs();
        assert!(drift < 0.005 * whole, "{away}: {drift} of {whole}");
        let error = (&end.q - &exact.q).amax();
        assert!(error < 0.01, "{away}: {error}");
    }
}

/// Jacobians, gradient, and gradient in parameters of a step that is divided, each against another.
#[test]
fn derivatives_go_through_the_parts_of_a_step() {
    let simulator = midpoint(light_hip(), 1e-3);
    let state = near_the_lock(0.06);
    let u = DVector::from_column_slice(&[0.3, -0.2, 0.5]);
    let found = simulator.linearize(&state, u.as_slice());
    let expected = simulator
        .estimate_linearization(&state, u.as_slice(), &finite_difference::Options::default())
        .linearization;
    let error = (&found.a - &expected.a).amax() / expected.a.amax();
    assert!(error < 1e-6, "A: {error:e}");
    let error = (&found.b - &expected.b).amax() / expected.b.amax();
    assert!(error < 1e-6, "B: {error:e}");

    let weights = DVector::from_column_slice(&[0.4, -1.0, 0.7, 0.002, -0.001, 0.003]);
    let gradient = simulator.vjp(&state, u.as_slice(), weights.as_slice());
    let expected = found.a.transpose() * &weights;
    let error = (&expected - &gradient.state).amax() / expected.amax();
    assert!(error < 1e-10, "state: {error:e}");
    let expected = found.b.transpose() * &weights;
    let error = (&expected - &gradient.input).amax() / expected.amax();
    assert!(error < 1e-10, "input: {error:e}");

    check_parameters(&simulator, &state, &u, weights.as_slice(), (4, 1e-8));
}

/// One lane of two is divided.
#[test]
fn lanes_are_divided_one_by_one() {
    let simulator = midpoint(light_hip(), 1e-3);
    let slow = State::new(&[0.3, 0.5, -0.2], &[1.0, 2.0, -1.0]);
    let states = [slow, near_the_lock(0.06)];
    let pair = |x: &dyn Fn(&State) -> &DVector<f64>| -> Vec<Lanes<2>> {
        (0..3)
            .map(|k| Lanes([x(&states[0])[k], x(&states[1])[k]]))
            .collect()
    };
    let all = State::new(&pair(&|x| &x.q), &pair(&|x| &x.v));
    let next = simulator.step(&all, &[Lanes([0.0; 2]); 3]);
    for (lane, state) in states.iter().enumerate() {
        let expected = simulator.step(state, &[0.0; 3]);
        for k in 0..3 {
            assert_eq!(next.q[k].0[lane], expected.q[k]);
            assert_eq!(next.v[k].0[lane], expected.v[k]);
        }
    }
}

/// Status and velocity of a step from a state or with an input that may not be finite.
fn try_step(simulator: &Simulator, q: f64, v: f64, u: f64) -> (Status, f64) {
    let start = State::new(&[0.3, 0.2, q], &[1.0, v, -1.0]);
    let (mut next, mut scratch) = (start.clone(), StepScratch::new(simulator));
    simulator.step_into(&start, &[0.1, 0.1, u], &mut scratch, &mut next);
    (scratch.solver_status(0), next.v.sum())
}

#[test]
fn states_and_inputs_that_are_not_finite_are_reported() {
    let simulator = midpoint(light_hip(), 1e-3);
    let (status, v) = try_step(&simulator, 0.1, 1.0, 0.1);
    assert!(status == Status::Converged && v.is_finite());
    for bad in [f64::NAN, f64::INFINITY] {
        for (q, v, u) in [(bad, 1.0, 0.1), (0.1, bad, 0.1), (0.1, 1.0, bad)] {
            let (status, end) = try_step(&simulator, q, v, u);
            assert_eq!(status, Status::NotFinite, "q {q}, v {v}, u {u}");
            assert!(!end.is_finite(), "q {q}, v {v}, u {u}: {end}");
        }
    }
}

fn turning_crank() -> (Simulator, State) {
    let (crank, start) = integrators::turning_crank();
    (crank.with_integrator(Integrator::ImplicitMidpoint), start)
}

#[test]
fn loops_stay_closed_and_their_error_falls_with_the_square_of_the_step() {
    let (crank, start) = turning_crank();
    let fine = (crank.clone())
        .with_integrator(Integrator::RungeKutta4)
        .with_time_step(1e-4);
    let exact = go(&fine, &start, 0.02, 2_000);
    let error = |steps: usize| {
        let simulator = crank.clone().with_time_step(0.2 / steps as f64);
        let end = go(&simulator, &start, 0.02, steps);
        let open = simulator.constraint_errors(&end);
        assert!(open.iter().all(|x| x.abs() < 1e-11), "{open:?}");
        let along: Vec<_> = end.v.iter().map(|&v| Dual::new(0.0, [v])).collect();
        let moving = crank.model().integrate(&lift::<1>(&end.q), &along);
        let moving = State::new(moving.as_slice(), &lift(&end.v));
        let errors = simulator.constraint_errors(&moving);
        let across: Vec<f64> = errors.iter().map(|x| x.eps[0]).collect();
        assert!(across.iter().all(|x| x.abs() < 1e-11), "{across:?}");
        end.deviation(crank.model(), &exact).amax()
    };
    let ratio = error(100) / error(200);
    assert!((3.7..4.3).contains(&ratio), "{ratio}");
}

/// A loop that is open by a centimetre, or moves across its rows, closes in one whole step; the next step is like any other.
#[test]
fn open_loops_are_closed_in_one_step() {
    let (crank, mut start) = turning_crank();
    start.q[2] += 0.01;
    start.v[2] += 0.3;
    let crank = crank.with_time_step(1e-3);
    let next = go(&crank, &start, 0.0, 1);
    let open = crank.constraint_errors(&next);
    assert!(open.iter().all(|x| x.abs() < 1e-10), "{open:?}");
    let later = go(&crank, &next, 0.0, 100);
    let [before, after] = [&next, &later].map(|x| energy(crank.model(), x));
    assert!((before - after).abs() < 1e-3 * before, "{before} {after}");
}

/// With every kind of constraint on a floating robot, and redundant rows in a plane linkage.
#[test]
fn gradients_with_constraints_equal_jacobians_and_dual_numbers() {
    let (loose, off) = tangled(Integrator::ImplicitMidpoint);
    let closed = loose.assemble(&off).expect("in reach").state;
    let plane = four_bar()
        .with_integrator(Integrator::ImplicitMidpoint)
        .with_time_step(5e-3);
    let turning = State::new(&[0.4, 0.3, 0.2], &[3.0, 0.0, 0.0]);
    let turning = plane.assemble(&turning).expect("in reach").state;
    for (simulator, state) in [(&loose, &off), (&loose, &closed), (&plane, &turning)] {
        let u = DVector::from_element(simulator.nu(), 0.3);
        let found = simulator.linearize(state, u.as_slice());
        let weights = |k: usize, _: usize| ((k * 7 + 3) % 11) as f64 / 5.0 - 1.0;
        let weights = DVector::from_fn(simulator.n_tangent(), weights);
        let gradient = simulator.vjp(state, u.as_slice(), weights.as_slice());
        let scale = found.a.amax();
        let error = (found.a.transpose() * &weights - &gradient.state).amax() / scale;
        assert!(error < 1e-11, "state: {error:e}");
        let error = (found.b.transpose() * &weights - &gradient.input).amax() / scale;
        assert!(error < 1e-12, "input: {error:e}");
        check_parameters(simulator, state, &u, weights.as_slice(), (3, 1e-8));
    }
}

#[test]
fn lanes_of_closed_loops_are_steps_one_by_one() {
    let (crank, start) = turning_crank();
    let crank = crank.with_time_step(1e-3);
    let other = go(&crank, &start, 0.0, 30);
    let pair = |x: &dyn Fn(&State) -> &DVector<f64>| -> Vec<Lanes<2>> {
        (0..3)
            .map(|k| Lanes([x(&start)[k], x(&other)[k]]))
            .collect()
    };
    let all = State::new(&pair(&|x| &x.q), &pair(&|x| &x.v));
    let next = crank.step(&all, &[Lanes([0.1; 2]); 3]);
    for (lane, state) in [&start, &other].into_iter().enumerate() {
        let expected = crank.step(state, &[0.1; 3]);
        for k in 0..3 {
            assert_eq!(next.q[k].0[lane], expected.q[k]);
            assert_eq!(next.v[k].0[lane], expected.v[k]);
        }
    }
}

#[test]
#[should_panic(
    expected = "constraints that are springs, regularised or have a largest force, which the"
)]
fn constraints_that_give_way_are_refused() {
    let (crank, _) = turning_crank();
    let soft = crank.constraints()[0].clone().with_spring(1e3, 1.0);
    let _ = crank.with_constraints(vec![soft]);
}

#[test]
#[should_panic(expected = "which the implicit midpoint rule does not simulate")]
fn contacts_are_refused() {
    use dualbody::contact::{ContactLaw, Contacts, SoftContact, Terrain};
    let model = asset("quadruped.urdf");
    let law = ContactLaw::Soft(SoftContact::estimate(1.0, 4, 1e-3));
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
    let _ = midpoint(model, 0.01).with_contacts(contacts);
}
