//! Times of gradients of rollouts beside the rollouts themselves: in the start, all inputs and all parameters at once.
//!
//! ```sh
//! cargo bench --features full --bench gradients
//! ```
//!
//! 1000 steps of 1 ms under small torques, with a quadratic cost of all numbers at each step, whose slopes are written by hand, and the same by
//! dual numbers; then the product of the Hessian with a direction. Medians, and quotients of two of the same run.

mod common;

use std::slice::from_ref;

use common::clock::{Clock, is_test};
use common::robots::{asset, standing};
use dualbody::constraint::{Anchor, Constraint};
use dualbody::linearize::{
    Checkpoints, CostScratch, CostSlopes, RolloutCost, RolloutDirection, RolloutGradientOptions,
    StagePoint, WantedParameters,
};
use dualbody::model::samples;
use dualbody::sim::RolloutStatus;
use dualbody::{Scalar, Simulator, State};
use nalgebra::DVector;

const STEPS: usize = 1000;
/// Amplitude of the torques, N·m.
const TORQUE: f64 = 0.05;

/// Half the sum of the squares of all states and inputs, with derivatives by dual numbers.
struct ByDuals;

impl RolloutCost for ByDuals {
    fn stage<T: Scalar>(&self, _: usize, state: &State<T>, u: &[T]) -> T {
        let numbers = state.numbers().chain(u);
        numbers.fold(T::zero(), |sum, &x| x.mul_add(x * 0.5, sum))
    }
}

/// The same where q is a vector, with slopes by hand.
struct ByHand;

impl RolloutCost for ByHand {
    fn stage_slopes(
        &self,
        at: &StagePoint<'_>,
        _: &mut CostScratch,
        out: &mut CostSlopes<'_>,
    ) -> f64 {
        let mut value = 0.0;
        let nv = at.state.v.len();
        let pairs = [
            (&mut out.state[nv..2 * nv], at.state.v.as_slice()),
            (&mut *out.input, at.u),
        ];
        for (slopes, x) in pairs {
            for (slope, x) in slopes.iter_mut().zip(x) {
                *slope += x;
                value += 0.5 * x * x;
            }
        }
        value
    }
}

fn main() {
    let (clock, steps) = match is_test() || !std::env::args().any(|a| a == "--bench") {
        true => (Clock::ONCE, 3),
        false => (Clock::EXACT, STEPS),
    };
    let arm = Simulator::new(samples::arm());
    let on_rod = on_a_rod(&arm);
    let (quadruped, on_feet) = standing();
    let humanoid = Simulator::new(asset("humanoid"));
    let few = Clock {
        rounds: clock.rounds.min(FEW_ROUNDS),
    };
    for (name, simulator, start) in [
        ("arm", &arm, arm.neutral_state()),
        (
            "arm on a rod",
            &on_rod,
            State::new(&AWAY, &[0.0; AWAY.len()]),
        ),
        ("humanoid", &humanoid, humanoid.neutral_state()),
        ("quadruped, standing", &quadruped, on_feet),
    ] {
        measure(name, simulator, &start, steps, clock);
        measure_hessian(simulator, &start, steps, few);
    }
}

/// Rounds of long measurements.
const FEW_ROUNDS: usize = 7;

/// A configuration of the arm in which its last link is off the axis of the first joint, rad.
const AWAY: [f64; 7] = [0.1, -0.4, 0.3, 0.8, -0.2, 0.5, 0.0];

/// The arm with its last link on a rod that is fixed above it.
fn on_a_rod(arm: &Simulator) -> Simulator {
    let model = arm.model();
    let links = model.link_names();
    let tip = Anchor::frame(model, links[links.len() - 1]).expect("a link");
    let above = Anchor::world().moved([0.0, 0.0, 2.0]);
    let [p, q] = [tip, above].map(|anchor| anchor.pose_in_world(model, &AWAY).translation);
    let rod = Constraint::distance([tip, above], (p - q).norm());
    arm.clone().with_constraints(vec![rod])
}

fn torques(simulator: &Simulator, steps: usize) -> Vec<DVector<f64>> {
    let input = |k: usize| DVector::from_fn(simulator.nu(), |i, _| TORQUE * ((k + i) as f64).sin());
    (0..steps).map(input).collect()
}

/// Time of the rollout itself, s.
fn rollout_time(
    simulator: &Simulator,
    start: &State,
    inputs: &[DVector<f64>],
    clock: Clock,
) -> f64 {
    let mut step = 0;
    let mut roll = || {
        step = 0;
        simulator.rollout(start, inputs.len(), |_, _, u| {
            u.copy_from_slice(inputs[step].as_slice());
            step += 1;
        })
    };
    let status = roll().status;
    assert_eq!(status, RolloutStatus::Completed);
    clock.median(|| drop(roll()))
}

fn print(times: &[(&str, f64)], rollout: f64) {
    for (what, time) in times {
        println!(
            "  {what:28} {:8.3} ms  {:5.2} rollouts",
            time * 1e3,
            time / rollout
        );
    }
}

/// The Hessian along one direction.
fn measure_hessian(simulator: &Simulator, start: &State, steps: usize, clock: Clock) {
    let inputs = torques(simulator, steps);
    let rollout = rollout_time(simulator, start, &inputs, clock);
    let mut along = RolloutDirection::zeros(simulator, steps);
    along.start.fill(1.0);
    let hessian = || drop(simulator.rollout_hessian_product(start, &inputs, &ByDuals, &along));
    let times = [("Hessian along a direction", clock.median(hessian))];
    print(&times, rollout);
}

fn measure(name: &str, simulator: &Simulator, start: &State, steps: usize, clock: Clock) {
    let inputs = torques(simulator, steps);
    let rollout = rollout_time(simulator, start, &inputs, clock);
    let all = RolloutGradientOptions::default();
    let wanted = |parameters| RolloutGradientOptions { parameters, ..all };
    let gradient = |options: &RolloutGradientOptions| {
        clock.median(|| {
            drop(simulator.rollout_gradients(from_ref(start), &[&inputs], &ByHand, options));
        })
    };
    let times = [
        ("state, inputs, parameters", gradient(&all)),
        (
            "model's parameters only",
            gradient(&wanted(WantedParameters::Model)),
        ),
        (
            "without parameters",
            gradient(&wanted(WantedParameters::None)),
        ),
        (
            "checkpoints by square root",
            gradient(&RolloutGradientOptions {
                checkpoints: Checkpoints::SquareRoot,
                ..all
            }),
        ),
        (
            "slopes of the cost by duals",
            clock.median(|| drop(simulator.rollout_gradient(start, &inputs, &ByDuals))),
        ),
    ];
    println!(
        "{name}: {} inputs, {} parameters; rollout {:.3} ms",
        inputs.len() * simulator.nu(),
        simulator.parameters().len(),
        rollout * 1e3
    );
    print(&times, rollout);
}
