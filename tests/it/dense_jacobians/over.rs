//! Jacobians over dual numbers, and over the lanes of a batch.

use super::forces::with_forces;
use super::{inputs, last_angle, laws, lower, simulator, with_narrow_stops, with_stiff_joints};
use dualbody::autodiff::VectorFunction;
use dualbody::autodiff::finite_difference::{Estimate, Options, estimate};
use dualbody::constraint::{Anchor, Constraint};
use dualbody::contact::{ContactLaw, Terrain};
use dualbody::linearize::{Linearization, LinearizeScratch};
use dualbody::model::samples;
use dualbody::scalar::{Dual, Lanes, Scalar};
use dualbody::sim::{
    BATCH_WIDTH, BatchScalar, BatchSimulator, ExternalForce, FrameActuator, Integrator,
};
use dualbody::spatial::{Force, Representation};
use dualbody::{Simulator, State};
use nalgebra::DVector;
use rand::SeedableRng;
use rand::rngs::Xoshiro256PlusPlus;

const INTEGRATORS: [Integrator; 3] = [
    Integrator::SemiImplicitEuler,
    Integrator::ImplicitVelocity,
    Integrator::RungeKutta4,
];

/// A state and an input, moved along a direction of both by some time.
struct Moved<'a> {
    simulator: &'a Simulator,
    state: &'a State,
}

impl Moved<'_> {
    fn by<T: Scalar>(&self, time: T) -> (State<T>, Vec<T>) {
        let model = self.simulator.model();
        let along = |k: usize| time * (1.0 + 2.0 * k as f64).cos();
        let lift = |x: &DVector<f64>| x.map(T::constant);
        let dq: Vec<T> = (0..model.nv()).map(along).collect();
        let mut state = State {
            q: model.integrate(lift(&self.state.q).as_slice(), &dq),
            v: lift(&self.state.v),
            contact: lift(&self.state.contact),
            activation: lift(&self.state.activation),
            sleep: lift(&self.state.sleep),
        };
        for (k, v) in state.v.iter_mut().enumerate() {
            *v += along(model.nv() + k);
        }
        for (k, m) in state.contact.iter_mut().enumerate() {
            *m += along(k) * 1e-3;
        }
        let u = inputs(self.simulator);
        let u = u.iter().enumerate().map(|(k, &u)| along(k) + u).collect();
        (state, u)
    }

    /// A and B there, entry after entry.
    fn jacobians(&self, time: f64) -> Vec<f64> {
        let (state, u) = self.by(time);
        entries(&self.simulator.linearize(&state, &u))
            .copied()
            .collect()
    }
}

fn entries<T: Scalar>(of: &Linearization<T>) -> impl Iterator<Item = &T> {
    of.a.iter().chain(&of.b)
}

/// A and B along the direction, so many entries, for finite differences.
struct Along<'a>(&'a Moved<'a>, usize);

impl VectorFunction for Along<'_> {
    fn n_outputs(&self) -> usize {
        self.1
    }

    fn eval<T: Scalar>(&self, time: &[T], out: &mut [T]) {
        let values = self.0.jacobians(time[0].value(0));
        let entries = out.iter_mut().zip(values);
        entries.for_each(|(out, x)| *out = T::constant(x));
    }
}

/// Asserts that derivatives of A and B along a direction equal finite differences of them.
fn assert_differentiated(simulator: &Simulator, state: &State, tolerance: f64) {
    let moved = Moved { simulator, state };
    let values = moved.jacobians(0.0);
    // Steps so short that no contact is lost.
    let options = Options {
        size_of_zero: 1e-5,
        ..Options::default()
    };
    let along = Along(&moved, values.len());
    let Estimate { jacobian, error } = estimate(&along, &[0.0], &options);
    let (state, u) = moved.by(Dual::<f64, 1>::variable(0.0, 0));
    let own = simulator.linearize(&state, &u);
    let name = simulator.model().name();
    let (size, slope) = (1.0 + largest(&values), 1.0 + jacobian.amax());
    for (i, own) in entries(&own).enumerate() {
        assert!(
            (own.re - values[i]).abs() < 1e-9 * size,
            "{name}, value {i}"
        );
        let difference = (own.eps[0] - jacobian[i]).abs();
        assert!(
            difference < tolerance * slope + 2.0 * error[i],
            "{name} {:?}, {i}: {} {}, {:e}",
            simulator.integrator(),
            own.eps[0],
            jacobian[i],
            error[i]
        );
    }
    // Where forces are redundant, or nearly, rounding leaves differences few digits.
    let certain = error.iter().filter(|x| **x < tolerance * slope).count();
    assert!(
        2 * certain > error.len(),
        "{name}: {certain} of {}",
        error.len()
    );
}

fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |most, x| x.abs().max(most))
}

/// Pushes and thrusters on the last link, along axes of all sorts.
fn with_thrusters(simulator: Simulator) -> Simulator {
    let model = simulator.model();
    let tip = model.link_names().last().copied().expect("a link");
    let tip = Anchor::frame(model, tip).expect("a link of the robot");
    let place = tip.moved([0.1, 0.2, -0.3]);
    let push = Force::from_array([1.0, -2.0, 3.0, 0.4, 0.5, -0.6]);
    let pushes = Representation::ALL.map(|r| ExternalForce::constant(place, push, r));
    let thrusters =
        Representation::ALL.map(|r| FrameActuator::new(format!("{r:?}"), place, push, r));
    simulator
        .with_external_forces(pushes.to_vec())
        .with_frame_actuators(thrusters.to_vec())
}

#[test]
fn second_derivatives_of_trees_equal_differences_of_jacobians() {
    for (seed, integrator) in (0..2).flat_map(|seed| INTEGRATORS.map(|by| (seed, by))) {
        let tree = samples::random_tree(7, seed);
        let plain = Simulator::new(tree.clone());
        // Explicit steps cannot follow stops as stiff as these.
        let stops = with_narrow_stops(tree.clone());
        let stops = Some(stops).filter(|_| integrator != Integrator::RungeKutta4);
        let others = [
            plain.clone(),
            with_stiff_joints(tree),
            with_thrusters(plain),
        ];
        for simulator in others.into_iter().chain(stops) {
            let simulator = simulator.with_time_step(0.01).with_integrator(integrator);
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
            let state = State::random(simulator.model(), &mut rng, 1.0);
            assert_differentiated(&simulator, &state, 1e-7);
        }
    }
}

#[test]
fn second_derivatives_where_something_whirls_equal_differences_of_jacobians() {
    let tree = Simulator::new(samples::random_tree(6, 1)).with_time_step(1e-3);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    for speed in [130.0, 170.0, 300.0] {
        let mut state = State::random(tree.model(), &mut rng, speed);
        let k = last_angle(tree.model());
        state.v[k] = -1.05 * speed;
        assert_differentiated(&tree, &state, 1e-6);
    }
}

#[test]
fn second_derivatives_in_contact_and_closed_loops_equal_differences_of_jacobians() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
    for (law, integrator) in laws()
        .iter()
        .flat_map(|&law| INTEGRATORS.map(|by| (law, by)))
    {
        let simulator = simulator("quadruped", &Terrain::incline(0.1), law);
        if integrator == Integrator::RungeKutta4 && !matches!(law, ContactLaw::Soft(_)) {
            continue; // the law acts over a step
        }
        let simulator = simulator.with_integrator(integrator);
        let mut state = simulator.neutral_state();
        let random = State::random(simulator.model(), &mut rng, 0.5);
        state.v.copy_from(&random.v);
        lower(&simulator, &mut state);
        let foot = |name: &str| Anchor::frame(simulator.model(), name).expect("a foot");
        let tied = Constraint::distance([foot("FL_foot"), foot("RL_foot")], 0.35);
        assert_differentiated(&simulator, &state, 1e-5);
        let tied = simulator.clone().with_constraints(vec![tied]);
        assert_differentiated(&tied, &state, 1e-5);
    }
}

/// Asserts that A and B over lanes are those of each state by itself.
fn assert_same_in_lanes(simulator: &Simulator, states: &[State; 4]) {
    let u = inputs(simulator);
    let mut state: State<BatchScalar> = simulator.neutral_state();
    let numbers = state
        .q
        .iter_mut()
        .chain(&mut state.v)
        .chain(&mut state.contact);
    let of = |state: &State| -> Vec<f64> {
        let rest = state.v.iter().chain(&state.contact);
        state.q.iter().chain(rest).copied().collect()
    };
    let given = states.each_ref().map(of);
    numbers
        .enumerate()
        .for_each(|(k, x)| *x = Lanes(std::array::from_fn(|lane| given[lane % 4][k])));
    let lanes: Vec<BatchScalar> = u.iter().map(|&u| Lanes::from(u)).collect();
    let all = simulator.linearize(&state, &lanes);
    for (lane, state) in states.iter().cycle().take(BATCH_WIDTH).enumerate() {
        let single = simulator.linearize(state, &u);
        let pairs = entries(&single).zip(entries(&all)).enumerate();
        for (i, (&single, x)) in pairs {
            let integrator = simulator.integrator();
            let name = simulator.model().name();
            assert_eq!(single, x.value(lane), "{name} {integrator:?}, {lane}, {i}");
        }
    }
}

#[test]
fn jacobians_in_lanes_have_the_bits_of_single_ones() {
    for (seed, integrator) in (0..3).flat_map(|seed| INTEGRATORS.map(|by| (seed, by))) {
        let tree = samples::random_tree(9, seed);
        let plain = Simulator::new(tree.clone());
        for simulator in [
            plain.clone(),
            with_stiff_joints(tree.clone()),
            with_narrow_stops(tree),
            with_forces(plain),
        ] {
            let simulator = simulator.with_time_step(0.01).with_integrator(integrator);
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
            let speeds = [0.0, 2.0, 20.0, 150.0];
            let states = speeds.map(|speed| State::random(simulator.model(), &mut rng, speed));
            assert_same_in_lanes(&simulator, &states);
        }
    }
}

#[test]
fn jacobians_in_lanes_in_soft_contact_have_the_bits_of_single_ones() {
    let [.., soft] = laws();
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(9);
    for integrator in [Integrator::SemiImplicitEuler, Integrator::RungeKutta4] {
        let simulator = simulator("quadruped", &Terrain::incline(0.1), soft);
        let simulator = simulator.with_integrator(integrator);
        let states = [0.0, 0.1, 0.5, 1.0].map(|height| {
            let mut state = simulator.neutral_state();
            let random = State::random(simulator.model(), &mut rng, 0.5);
            state.v.copy_from(&random.v);
            lower(&simulator, &mut state);
            state.q[2] += height * 1e-3;
            state
        });
        assert_same_in_lanes(&simulator, &states);
    }
}

#[test]
fn jacobians_of_a_batch_are_those_of_its_states_for_any_number_of_them() {
    let tree = Simulator::new(samples::random_tree(6, 4)).with_time_step(0.01);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(4);
    let (nu, mut scratch) = (tree.nu(), LinearizeScratch::new(&tree));
    let mut expected = Linearization::zeros(&tree);
    for (len, threads) in [(0, 1), (3, 1), (13, 2), (17, 3)] {
        let states: Vec<State> = (0..len)
            .map(|_| State::random(tree.model(), &mut rng, 1.0))
            .collect();
        let u: Vec<f64> = (0..len * nu).map(|k| (k as f64).sin()).collect();
        let batch = BatchSimulator::new(tree.clone(), len).with_threads(threads);
        let all = batch.linearize(&states, &u);
        assert_eq!(all.len(), len);
        for (i, (found, state)) in all.iter().zip(&states).enumerate() {
            let own = &u[i * nu..(i + 1) * nu];
            tree.linearize_into(state, own, &mut scratch, &mut expected);
            assert!(*found == expected, "{i} of {len}");
        }
    }
}
