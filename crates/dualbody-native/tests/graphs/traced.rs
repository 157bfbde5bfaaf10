//! Recorded computations against the computations themselves, at points where they were not recorded.

use std::panic::{AssertUnwindSafe, catch_unwind};

use dualbody::autodiff::{Dual, VectorFunction, jacobian};
use dualbody::contact::{ContactLaw, Contacts, Rigid, SoftContact, Terrain};
use dualbody::dynamics::{
    forward_dynamics, forward_dynamics_derivatives, inverse_dynamics, kinetic_energy,
};
use dualbody::model::samples;
use dualbody::scalar::traced::{Graph, Port, trace};
use dualbody::sim::{Actuation, Actuator, CoulombFriction};
use dualbody::{Integrator, Lanes, Model, Scalar, Simulator, State, codegen};
use nalgebra::{DMatrix, DVector};

use crate::common::everything::{INTEGRATORS, everything};
use crate::common::{
    OTHER_ALGORITHM, Point, SAME_ALGEBRA, assert_close, asset, random_point, robots,
};

/// Robots of every sort, and the largest of the assets.
fn all_robots() -> Vec<Model> {
    let mut out = robots();
    out.extend(["quadruped.urdf", "humanoid.urdf"].map(asset));
    out
}

fn numbers(point: &Point) -> Vec<f64> {
    point
        .q
        .iter()
        .chain(&point.v)
        .chain(&point.w)
        .copied()
        .collect()
}

/// Asserts that numbers are equal up to rounding, relative to the largest of them or to one.
#[track_caller]
pub(crate) fn assert_equal(actual: &[f64], expected: &[f64], tolerance: f64, what: &str) {
    assert_eq!(actual.len(), expected.len(), "{what}");
    let largest = expected.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
    for (k, (a, e)) in actual.iter().zip(expected).enumerate() {
        let off = (a - e).abs();
        assert!(off <= tolerance * largest, "{what}, {k}: {a}, not {e}");
    }
}

/// Traces all functions of the dynamics.
fn trace_everything(model: &Model) -> (Vec<&'static str>, Graph) {
    let mut names = Vec::new();
    let graph = trace(|t| {
        let q = t.input(Port::vector("q", model.nq()));
        let [v, w] = ["v", "w"].map(|name| t.input(Port::vector(name, model.nv())));
        let found = everything(model, &q, &v, &w);
        names = found.names;
        t.output(Port::vector("all", found.numbers.len()), &found.numbers);
    });
    (names, graph)
}

#[test]
fn traced_dynamics_equal_the_dynamics_at_any_point() {
    for model in all_robots() {
        let (names, graph) = trace_everything(&model);
        for seed in 0..3 {
            let point = random_point(&model, seed);
            let (q, v, w) = (&point.q, &point.v, &point.w);
            let expected = everything(&model, q.as_slice(), v.as_slice(), w.as_slice()).numbers;
            let actual = graph.evaluate(&numbers(&point)).expect("slow motion");
            for (k, name) in names.iter().enumerate() {
                let off = (actual[k] - expected[k]).abs();
                assert!(
                    off <= 10.0 * SAME_ALGEBRA * expected[k].abs().max(1.0),
                    "{}, seed {seed}, {name}: {}, not {}",
                    model.name(),
                    actual[k],
                    expected[k]
                );
            }
        }
    }
}

/// State and input of a simulator as the inputs of its traced step.
pub(crate) fn step_inputs(simulator: &Simulator, seed: u64) -> (State, Vec<f64>, Vec<f64>) {
    let point = random_point(simulator.model(), seed);
    let mut state = simulator.state(point.q.as_slice(), point.v.as_slice());
    for (k, m) in state.contact.iter_mut().enumerate() {
        *m = 1e-3 * (k as f64).sin();
    }
    let u: Vec<f64> = (0..simulator.nu())
        .map(|k| (1.0 + k as f64).cos())
        .collect();
    let all = state.numbers().chain(&u).copied().collect();
    (state, u, all)
}

#[track_caller]
pub(crate) fn assert_step(simulator: &Simulator, graph: &Graph, seed: u64, what: &str) {
    let (state, u, all) = step_inputs(simulator, seed);
    let next = simulator.step(&state, &u);
    let expected: Vec<f64> = next.numbers().copied().collect();
    let actual = graph.evaluate(&all).expect("slow motion");
    assert_equal(&actual, &expected, 10.0 * SAME_ALGEBRA, what);
}

#[track_caller]
pub(crate) fn assert_linearization(simulator: &Simulator, graph: &Graph, seed: u64, what: &str) {
    let (state, u, all) = step_inputs(simulator, seed);
    let expected = simulator.linearize(&state, &u);
    let expected: Vec<f64> = expected.a.iter().chain(&expected.b).copied().collect();
    let actual = graph.evaluate(&all).expect("slow motion");
    assert_equal(&actual, &expected, OTHER_ALGORITHM, what);
}

/// Whether the ground pushes at a state of [`step_inputs`].
pub(crate) fn touches(simulator: &Simulator, seed: u64) -> bool {
    let (state, u, _) = step_inputs(simulator, seed);
    let report = simulator.contact_report(&state, &u);
    report.forces.iter().any(|f| f.norm() > 0.0)
}

#[test]
fn traced_steps_equal_steps_of_all_integrators() {
    for model in all_robots() {
        for integrator in INTEGRATORS {
            let simulator = Simulator::new(model.clone())
                .with_integrator(integrator)
                .with_time_step(2e-3);
            let graph = codegen::step(&simulator);
            for seed in 0..3 {
                let what = format!("{}, {integrator:?}, seed {seed}", model.name());
                assert_step(&simulator, &graph, seed, &what);
            }
        }
    }
}

#[test]
fn traced_steps_on_soft_ground_equal_steps() {
    for robot in ["box", "quadruped", "sphere"] {
        let model = asset(&format!("{robot}.urdf"));
        let law = ContactLaw::Soft(SoftContact::estimate(10.0, 4, 1e-2));
        let contacts = Contacts::new(&model, Terrain::incline(0.2), law);
        for integrator in [Integrator::SemiImplicitEuler, Integrator::RungeKutta4] {
            let simulator = Simulator::new(model.clone())
                .with_contacts(contacts.clone())
                .with_integrator(integrator);
            let graph = codegen::step(&simulator);
            let mut touched = 0;
            for seed in 0..20 {
                touched += usize::from(touches(&simulator, seed));
                let what = format!("{robot}, {integrator:?}, seed {seed}");
                assert_step(&simulator, &graph, seed, &what);
            }
            assert!((1..20).contains(&touched), "{robot}: {touched} of 20 touch");
        }
    }
}

/// A Panda with dry friction and motors, but without stops.
fn with_motors() -> Simulator {
    let model = asset("panda.urdf");
    let actuator = Actuator {
        friction: Some(CoulombFriction::smoothed(0.4, 0.05)),
        ..Actuator::default()
    };
    let actuation = Actuation::ideal(&model).with_actuators(&vec![actuator; model.nv()]);
    Simulator::new(model).with_actuation(actuation)
}

#[test]
fn traced_steps_with_friction_equal_steps() {
    for integrator in INTEGRATORS {
        let simulator = with_motors()
            .with_integrator(integrator)
            .with_time_step(1e-4);
        let graph = codegen::step(&simulator);
        for seed in 0..3 {
            let what = format!("{integrator:?}, seed {seed}");
            assert_step(&simulator, &graph, seed, &what);
        }
    }
}

/// A cart-pole whose rail ends at 2.4 m, and states at its end: before and beyond it, on the way there and back.
fn at_the_stop() -> (Simulator, Vec<Vec<f64>>) {
    let model = samples::cartpole();
    let actuation = Actuation::from_model(&model);
    let simulator = Simulator::new(model)
        .with_actuation(actuation)
        .with_time_step(0.01);
    let at = |k: i32| {
        let k = f64::from(k);
        vec![
            2.4 + 0.02 * k.sin(),
            k,
            3.0 * (2.0 * k).cos(),
            1.0 - 0.2 * k,
            8.0 * k.cos(),
            0.0,
        ]
    };
    (simulator, (0..60).map(at).collect())
}

#[test]
fn traced_steps_at_a_stop_equal_steps() {
    let (simulator, states) = at_the_stop();
    let (step, slopes) = (
        codegen::step(&simulator),
        codegen::linearization(&simulator),
    );
    let free = codegen::step(&Simulator::new(samples::cartpole()).with_time_step(0.01));
    let mut pushed = 0;
    for (k, x) in states.iter().enumerate() {
        let (state, u) = (State::new(&x[..2], &x[2..4]), &x[4..]);
        let expected: Vec<f64> = simulator.step(&state, u).numbers().copied().collect();
        let actual = step.evaluate(x).expect("a stop that is let go once");
        assert_equal(
            &actual,
            &expected,
            10.0 * SAME_ALGEBRA,
            &format!("state {k}"),
        );
        let alone = free.evaluate(x).expect("slow motion");
        pushed += usize::from((alone[2] - expected[2]).abs() > 1e-3);
        let exact = simulator.linearize(&state, u);
        let exact: Vec<f64> = exact.a.iter().chain(&exact.b).copied().collect();
        let own = slopes.evaluate(x).expect("a stop that is let go once");
        assert_equal(
            &own,
            &exact,
            OTHER_ALGORITHM,
            &format!("slopes at state {k}"),
        );
    }
    assert!((10..60).contains(&pushed), "{pushed} of 60 pushed");
}

#[test]
fn traced_linearizations_equal_those_of_the_simulator() {
    let mut simulators = vec![with_motors()];
    for model in robots().into_iter().chain([asset("quadruped.urdf")]) {
        let of = |integrator| Simulator::new(model.clone()).with_integrator(integrator);
        simulators.extend(INTEGRATORS.map(of));
    }
    for simulator in simulators {
        let graph = codegen::linearization(&simulator);
        for seed in 0..2 {
            let (name, integrator) = (simulator.model().name(), simulator.integrator());
            let what = format!("{name}, {integrator:?}, seed {seed}");
            assert_linearization(&simulator, &graph, seed, &what);
        }
    }
}

/// Blocks of a graph's outputs as matrices.
fn blocks(graph: &Graph, x: &[f64]) -> Vec<DMatrix<f64>> {
    let found = graph.evaluate(x).expect("slow motion");
    let mut rest = &found[..];
    let take = |port: &Port| {
        let (own, after) = rest.split_at(port.len());
        rest = after;
        DMatrix::from_column_slice(port.rows, port.columns, own)
    };
    graph.outputs().iter().map(take).collect()
}

#[test]
fn jacobians_of_graphs_equal_derivatives_along_the_tree() {
    for model in [samples::arm(), samples::cartpole(), asset("ur5.urdf")] {
        let graph = codegen::forward_dynamics(&model);
        let slopes = graph.jacobian(&["a"], &["q", "v", "tau"]).expect("ports");
        let names: Vec<_> = slopes
            .outputs()
            .iter()
            .map(|port| port.name.as_str())
            .collect();
        assert_eq!(names, ["da_dq", "da_dv", "da_dtau"]);
        let point = random_point(&model, 6);
        let (q, v, tau) = (point.q.as_slice(), point.v.as_slice(), point.w.as_slice());
        let exact = forward_dynamics_derivatives(&model, q, v, tau);
        let own = blocks(&slopes, &numbers(&point));
        for (own, exact) in own.iter().zip([exact.dq, exact.dv, exact.dtau]) {
            assert_close(own, &exact, OTHER_ALGORITHM, model.name());
        }
    }
}

/// Kinetic energy as a function of q and v.
struct Energy<'a>(&'a Model);

impl VectorFunction for Energy<'_> {
    fn n_outputs(&self) -> usize {
        1
    }

    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let (q, v) = x.split_at(self.0.nq());
        y[0] = kinetic_energy(self.0, q, v);
    }
}

#[test]
fn gradients_by_one_reverse_sweep_equal_dual_numbers() {
    for model in robots() {
        let graph = trace(|t| {
            let q = t.input(Port::vector("q", model.nq()));
            let v = t.input(Port::vector("v", model.nv()));
            let x: Vec<_> = q.into_iter().chain(v).collect();
            let mut energy = [0.0.into()];
            Energy(&model).eval(&x, &mut energy);
            t.output(Port::number("T"), &energy);
        });
        let gradient = graph.gradient("T", &["q", "v"]).expect("ports");
        let point = random_point(&model, 7);
        let x: Vec<f64> = point.q.iter().chain(&point.v).copied().collect();
        let exact = jacobian(&Energy(&model), &x);
        let own = gradient.evaluate(&x).expect("no conditions");
        assert_equal(&own, exact.as_slice(), SAME_ALGEBRA, model.name());
    }
}

/// Accelerations in all parameters of a robot.
struct InParameters<'a>(&'a Model, &'a Point);

impl VectorFunction for InParameters<'_> {
    fn n_outputs(&self) -> usize {
        self.0.nv()
    }

    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let model = self.0.cast::<T>().with_parameters(x);
        let lift = |x: &DVector<f64>| x.map(T::constant);
        let (q, v, tau) = (lift(&self.1.q), lift(&self.1.v), lift(&self.1.w));
        let a = forward_dynamics(&model, q.as_slice(), v.as_slice(), tau.as_slice());
        y.copy_from_slice(a.as_slice());
    }
}

#[test]
fn adjoints_in_all_parameters_equal_dual_numbers() {
    for model in [
        samples::cartpole(),
        asset("ur5.urdf"),
        asset("quadruped.urdf"),
    ] {
        let point = random_point(&model, 8);
        let f = InParameters(&model, &point);
        let theta = model.parameters();
        let graph = trace(|t| {
            let x = t.input(Port::vector("theta", theta.len()));
            let mut a = vec![0.0.into(); model.nv()];
            f.eval(&x, &mut a);
            t.output(Port::vector("a", model.nv()), &a);
        });
        let adjoint = graph.adjoint(&["theta"]).expect("a port");
        let weights: Vec<f64> = (0..model.nv()).map(|k| (k as f64).cos()).collect();
        let x: Vec<f64> = theta.iter().chain(&weights).copied().collect();
        let own = adjoint.evaluate(&x).expect("no conditions");
        let exact = jacobian(&f, theta.as_slice()).tr_mul(&DVector::from_vec(weights));
        assert_equal(&own, exact.as_slice(), OTHER_ALGORITHM, model.name());
        // A few times the function itself, for any number of parameters.
        let (one, both) = (graph.counts().operations(), adjoint.counts().operations());
        assert!(both < 5 * one, "{}: {one}, {both}", model.name());
    }
}

#[test]
fn graphs_over_lanes_and_dual_numbers_equal_those_over_numbers() {
    let model = asset("ur5.urdf");
    let graph = codegen::inverse_dynamics(&model);
    let points = [1, 2].map(|seed| numbers(&random_point(&model, seed)));
    let lanes: Vec<_> = (0..points[0].len())
        .map(|k| Lanes([points[0][k], points[1][k]]))
        .collect();
    let side_by_side = graph.evaluate(&lanes).expect("no conditions");
    for (lane, point) in points.iter().enumerate() {
        let alone = graph.evaluate(point).expect("no conditions");
        let own: Vec<f64> = side_by_side.iter().map(|x| x.0[lane]).collect();
        assert_eq!(own, alone);
    }
    let duals = points[0].iter().enumerate();
    let duals: Vec<Dual<f64, 1>> = duals
        .map(|(k, &x)| Dual::new(x, [(k as f64).sin()]))
        .collect();
    let (nq, nv) = (model.nq(), model.nv());
    let [q, v, a] = [&duals[..nq], &duals[nq..nq + nv], &duals[nq + nv..]];
    let expected = inverse_dynamics(&model, q, v, a);
    for (own, expected) in graph
        .evaluate(&duals)
        .expect("no conditions")
        .iter()
        .zip(&expected)
    {
        assert!(
            (own.eps[0] - expected.eps[0]).abs() < SAME_ALGEBRA * expected.eps[0].abs().max(1.0)
        );
    }
}

#[test]
fn tracing_twice_gives_the_same_graph() {
    let model = asset("quadruped.urdf");
    let [one, other] = [(), ()].map(|()| codegen::forward_dynamics(&model).to_string());
    assert_eq!(one, other);
}

/// Message of the panic of a computation.
fn panic_of(work: impl FnOnce()) -> String {
    let cause = catch_unwind(AssertUnwindSafe(work)).expect_err("a panic");
    let fixed = cause.downcast_ref::<&str>().map(|&text| text.to_owned());
    let text = cause.downcast_ref::<String>().cloned().or(fixed);
    text.unwrap_or_else(|| "no text".to_owned())
}

#[test]
fn decisions_on_values_cannot_be_traced_and_name_their_place() {
    let quadruped = asset("quadruped.urdf");
    let soft = ContactLaw::Soft(SoftContact::estimate(10.0, 4, 1e-2));
    let on_ground = |law| Contacts::new(&quadruped, Terrain::flat(0.0), law);
    let robot = Simulator::new(quadruped.clone());
    let rigid = ContactLaw::Rigid(Rigid::default());
    let implicit = Integrator::ImplicitVelocity;
    let cases = [
        robot.clone().with_contacts(on_ground(rigid)),
        robot
            .with_contacts(on_ground(soft))
            .with_integrator(implicit),
    ];
    for simulator in cases {
        let text = panic_of(|| drop(codegen::step(&simulator)));
        let of_physics = ["src/sim/", "src/contact/", "src/cone/"]
            .iter()
            .any(|folder| text.starts_with(folder));
        let at = of_physics && text.contains("on the value");
        assert!(at, "{text}");
    }
    // A trace that fails leaves nothing behind, and constants have values.
    let graph = trace(|t| {
        let x = t.input(Port::number("x"));
        assert_eq!((x[0] * 0.0 + 3.0).value(0), 3.0);
        t.output(Port::number("y"), [&(x[0] + 1.0)]);
    });
    assert_eq!(graph.evaluate(&[1.0]).expect("no conditions"), [2.0]);
}

#[test]
fn a_step_says_where_something_whirls() {
    let simulator = Simulator::new(samples::double_pendulum());
    let graph = codegen::step(&simulator);
    assert_eq!(graph.conditions().len(), 1);
    assert!(graph.evaluate(&[0.1, 0.2, 60.0, -60.0, 0.0, 0.0]).is_ok());
    let error = graph
        .evaluate(&[0.1, 0.2, 90.0, -90.0, 0.0, 0.0])
        .expect_err("fast");
    assert!(error.to_string().contains("rotates fast"), "{error}");
}
