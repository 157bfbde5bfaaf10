//! Single shooting against finite differences, Riccati, differential dynamic programming, and on problems without a
//! solution.

use std::sync::{Arc, Mutex};

use dualbody::control::{FiniteHorizonLqr, LqrStage};
use dualbody::linearize::Linearization;
use dualbody::model::samples;
use dualbody::trajopt::argmin::core::checkpointing::{Checkpoint, CheckpointingFrequency};
use dualbody::trajopt::argmin::core::observers::{Observe, ObserverMode};
use dualbody::trajopt::argmin::core::{Error, Executor, IterState, KV, State as _};
use dualbody::trajopt::argmin::solver::linesearch::MoreThuenteLineSearch;
use dualbody::trajopt::argmin::solver::quasinewton::LBFGS;
use dualbody::trajopt::{
    Activation, Constraint, ConstraintOptions, Cost, Curvature, Ddp, DdpOptions, InitialState,
    InputError, Minimizer, Problem, Robot, Scratch, ShootingOptions, ShootingSolution,
    SingleShooting, StateError, Status, System, Trajectory,
};
use dualbody::{Simulator, State};
use nalgebra::{DMatrix, DVector};

use crate::common::problems::{Counter, Masses, counter, masses, swing, tree};
use crate::common::{OTHER_ALGORITHM, SAME_ALGEBRA, floating_robot};

const INF: f64 = f64::INFINITY;

/// From a state that is not neutral to the neutral one, with bounds of all kinds on the inputs and a bound on a state.
fn regulate(simulator: Simulator, horizon: usize) -> Problem {
    let (nv, nu, ndx) = (simulator.model().nv(), simulator.nu(), simulator.ndx());
    let neutral = State::neutral(simulator.model());
    let moved: Vec<f64> = (0..nv).map(|i| 0.4 * (1.0 + i as f64).sin()).collect();
    let q = simulator.model().integrate(neutral.q.as_slice(), &moved);
    let start = simulator.pack(&State::new(q.as_slice(), &moved));
    let upright = || StateError::to_neutral(&simulator);
    let running = Cost::new()
        .with(1.0, Activation::SmoothAbs { width: 0.5 }, upright())
        .with(1e-2, Activation::Quadratic, InputError::to_zero(&simulator));
    let last = Cost::new().with(1e1, Activation::Quadratic, upright());
    let cap: Vec<f64> = (0..ndx).map(|i| if i == 0 { 0.3 } else { INF }).collect();
    let cap = Constraint::within(upright(), &vec![-INF; ndx], &cap);
    let kinds = [(-5.0, 7.0), (-4.0, INF), (-INF, 3.0), (-INF, INF)];
    let bound = |i: usize| kinds[i % 4];
    let lower: Vec<f64> = (0..nu).map(|i| bound(i).0).collect();
    let upper: Vec<f64> = (0..nu).map(|i| bound(i).1).collect();
    Problem::new(simulator, horizon, start.as_slice())
        .with_stage_cost(running)
        .with_final_cost(last)
        .with_constraint(cap)
        .with_input_bounds(&lower, &upper)
}

fn robots() -> Vec<(&'static str, Simulator)> {
    let cartpole = Simulator::new(samples::cartpole()).with_actuated_joints(&["linear"]);
    let acrobot = samples::double_pendulum();
    let elbow = acrobot.joint_names()[1].to_owned();
    let acrobot = Simulator::new(acrobot).with_actuated_joints(&[&elbow]);
    vec![
        ("cartpole", cartpole.unwrap()),
        ("acrobot", acrobot.unwrap()),
        ("arm", Simulator::new(samples::arm())),
        ("floating", Simulator::new(floating_robot())),
    ]
}

/// Variables that are nowhere special.
fn somewhere(n: usize) -> Vec<f64> {
    (0..n).map(|i| 0.7 * (1.3 * i as f64).sin()).collect()
}

/// Differences of fourth order along variable `i`.
fn slope(f: impl Fn(&[f64]) -> DVector<f64>, z: &[f64], i: usize) -> DVector<f64> {
    const STEP: f64 = 2e-4;
    let at = |step: f64| {
        let mut moved = z.to_vec();
        moved[i] += step;
        f(&moved)
    };
    ((at(STEP) - at(-STEP)) * 8.0 - (at(2.0 * STEP) - at(-2.0 * STEP))) / (12.0 * STEP)
}

#[test]
fn gradient_of_the_whole_objective_equals_finite_differences() {
    for (name, simulator) in robots() {
        for initial in [InitialState::Fixed, InitialState::Free] {
            let problem = regulate(simulator.clone(), 12).with_initial_state(initial);
            let shooting = SingleShooting::new(&problem);
            let z = somewhere(shooting.dim());
            let gradient = shooting.gradient(&z);
            let value = |z: &[f64]| DVector::from_element(1, shooting.value(z));
            let scale = gradient.amax();
            assert!(scale.is_finite() && scale > 1e-3, "{name}: {scale}");
            for i in (0..z.len()).step_by(z.len() / 12) {
                let (is, expected) = (gradient[i], slope(value, &z, i)[0]);
                let far = (is - expected).abs();
                assert!(
                    far < 1e-8 * scale,
                    "{name}, {initial:?}, {i}: {is} {expected}"
                );
            }
        }
    }
}

#[cfg(feature = "second-order")]
#[test]
fn exact_hessian_equals_differences_of_the_gradient() {
    for (name, simulator) in robots() {
        let problem = regulate(simulator, 4);
        let options = ShootingOptions {
            curvature: Curvature::Exact,
            // The penalty keeps the Hessian of Gauss and Newton.
            constraints: ConstraintOptions {
                penalty: 1e-12,
                ..ConstraintOptions::default()
            },
            ..ShootingOptions::default()
        };
        let shooting = SingleShooting::with_options(&problem, options);
        let z = somewhere(shooting.dim());
        let hessian = shooting.hessian(&z);
        let scale = hessian.amax();
        assert!(
            (&hessian - hessian.transpose()).amax() < SAME_ALGEBRA * scale,
            "{name}"
        );
        // Its memory is not used as the expansion of the costs.
        assert_eq!(hessian, shooting.hessian(&z), "{name}");
        for i in (0..z.len()).step_by(z.len() / 4) {
            let expected = slope(|z| shooting.gradient(z), &z, i);
            let far = (hessian.column(i) - expected).amax();
            assert!(
                far < 1e-7 * scale,
                "{name}, column {i}: {far:e} of {scale:e}"
            );
        }
    }
}

#[test]
fn gauss_newton_hessian_equals_differences_of_the_gradient_where_the_system_is_linear() {
    for initial in [InitialState::Fixed, InitialState::Free] {
        let problem = masses(6).with_initial_state(initial);
        let problem = problem.with_input_bounds(&[-2.0, -INF], &[3.0, 1.0]);
        let shooting = SingleShooting::new(&problem);
        let z = somewhere(shooting.dim());
        let hessian = shooting.hessian(&z);
        for i in 0..z.len() {
            let expected = slope(|z| shooting.gradient(z), &z, i);
            let far = (hessian.column(i) - expected).amax();
            assert!(
                far < 1e-8 * hessian.amax(),
                "{initial:?}, column {i}: {far:e}"
            );
        }
    }
}

fn riccati(horizon: usize) -> FiniteHorizonLqr {
    let mut step = Linearization {
        a: DMatrix::zeros(4, 4),
        b: DMatrix::zeros(4, 2),
    };
    Masses.linearize(&[0.0; 4], &[0.0; 2], &mut Scratch::new(), &mut step);
    let stage = LqrStage {
        a: step.a,
        b: step.b,
        q: DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 2.0, 0.1, 0.2])),
        r: DMatrix::identity(2, 2) * 0.5,
    };
    FiniteHorizonLqr::discrete(&vec![stage; horizon], &(DMatrix::identity(4, 4) * 10.0))
}

fn solve(problem: &Problem, minimizer: Minimizer) -> ShootingSolution {
    let solution = SingleShooting::new(problem).solve(&Trajectory::zero_input(problem), minimizer);
    check_result(problem, minimizer, &solution);
    solution
}

/// Properties of every result, good or bad.
fn check_result(problem: &Problem, minimizer: Minimizer, solution: &ShootingSolution) {
    let (history, trajectory) = (&solution.cost_history, &solution.trajectory);
    assert_eq!(history.len(), solution.iterations + 1, "{minimizer:?}");
    for u in &trajectory.inputs {
        for i in 0..u.len() {
            let (lower, upper) = problem.input_bounds();
            let (lower, upper) = (lower[i], upper[i]);
            assert!((lower..=upper).contains(&u[i]), "{minimizer:?}: {u}");
        }
    }
    if solution.status == Status::Diverged {
        return;
    }
    let numbers = trajectory.states.iter().chain(&trajectory.inputs).flatten();
    let are_finite = numbers.into_iter().all(|x| x.is_finite());
    assert!(are_finite, "{minimizer:?}: {}", solution.status);
    assert!((solution.cost - trajectory.cost(problem)).abs() <= SAME_ALGEBRA * solution.cost.abs());
    if problem.constraints().is_empty() && problem.final_constraints().is_empty() {
        assert!(
            history.is_sorted_by(|before, after| before >= after),
            "{minimizer:?}"
        );
        let last = history.last().unwrap();
        assert!(
            (solution.cost - last).abs() <= SAME_ALGEBRA * (1.0 + last.abs()),
            "{minimizer:?}"
        );
    }
}

#[test]
fn optimum_of_a_linear_quadratic_problem_equals_the_riccati_solution() {
    let (problem, riccati) = (masses(20), riccati(20));
    let x = problem.start();
    let expected = 0.5 * x.dot(&(&riccati.costs_to_go[0] * x));
    for minimizer in Minimizer::ALL {
        let solution = solve(&problem, minimizer);
        assert!(
            solution.is_converged(),
            "{minimizer:?}: {}",
            solution.status
        );
        assert!(
            (solution.cost - expected).abs() < 1e-10 * expected,
            "{minimizer:?}"
        );
        for (k, u) in solution.trajectory.inputs.iter().enumerate() {
            let far = (u - riccati.control(k, &solution.trajectory.states[k])).amax();
            assert!(far < 1e-5, "{minimizer:?}, stage {k}: {far:e}");
        }
    }
}

/// All but steepest descent, which takes too many iterations where a problem is not well conditioned.
const FAST: [Minimizer; 3] = [
    Minimizer::Lbfgs,
    Minimizer::NewtonCg,
    Minimizer::TrustRegion,
];

#[test]
fn every_minimizer_finds_the_optimum_of_differential_dynamic_programming() {
    let bounded = masses(20).with_input_bounds(&[-1.0, -0.3], &[0.5, 1.0]);
    compare_with_ddp("masses", &masses(20), &Minimizer::ALL);
    compare_with_ddp("bounded masses", &bounded, &Minimizer::ALL);
    compare_with_ddp("swing", &swing(20), &FAST);
    compare_with_ddp("tree", &tree(5), &FAST);
}

fn compare_with_ddp(name: &str, problem: &Problem, minimizers: &[Minimizer]) {
    let tight = DdpOptions {
        tolerance: 1e-13,
        ..DdpOptions::default()
    };
    let mut ddp = Ddp::with_options(problem, tight);
    let expected = ddp.solve(problem, &Trajectory::zero_input(problem));
    assert!(expected.is_converged());
    for &minimizer in minimizers {
        let options = ShootingOptions {
            max_iterations: 1000,
            ..ShootingOptions::default()
        };
        let mut shooting = SingleShooting::with_options(problem, options);
        let solution = shooting.solve(&Trajectory::zero_input(problem), minimizer);
        check_result(problem, minimizer, &solution);
        let what = format!("{name}, {minimizer:?}: {}", solution.status);
        assert!(solution.is_converged(), "{what}");
        let far = (solution.cost / expected.cost - 1.0).abs();
        assert!(far < OTHER_ALGORITHM, "{what}: {far:e}");
    }
}

#[test]
fn bounds_of_inputs_are_reached_where_the_optimum_is_there() {
    let problem = masses(20).with_input_bounds(&[-1.0, -0.3], &[0.5, 1.0]);
    let solution = solve(&problem, Minimizer::NewtonCg);
    let inputs = solution.trajectory.inputs.iter();
    let at_bound = inputs.filter(|u| (u[0] + 1.0).abs() < 1e-9 || (u[1] + 0.3).abs() < 1e-9);
    assert!(at_bound.count() > 3);
}

#[test]
fn free_first_state_of_the_cheapest_trajectory_equals_the_reference() {
    let problem = masses(10).with_initial_state(InitialState::Free);
    for minimizer in FAST {
        let solution = solve(&problem, minimizer);
        assert!(
            solution.is_converged(),
            "{minimizer:?}: {}",
            solution.status
        );
        assert!(solution.trajectory.states[0].amax() < 1e-6, "{minimizer:?}");
    }
}

#[test]
fn constrained_end_is_met_by_equal_inputs() {
    let end = || Constraint::equal_to_zero(&Counter, StateError::to(&[1.0]));
    let problem = counter(5, 1.0).with_final_constraint(end());
    for minimizer in Minimizer::ALL {
        let solution = solve(&problem, minimizer);
        let what = format!("{minimizer:?}: {}", solution.status);
        assert!(
            solution.is_converged() && solution.violation <= 1e-6,
            "{what}"
        );
        let inputs = solution.trajectory.inputs.iter();
        assert!(
            inputs.into_iter().all(|u| (u[0] - 0.2).abs() < 1e-5),
            "{what}"
        );
    }
    let out_of_reach = counter(5, 1.0).with_final_constraint(end());
    let out_of_reach = out_of_reach.with_input_bounds(&[-0.1], &[0.1]);
    for minimizer in Minimizer::ALL {
        let solution = solve(&out_of_reach, minimizer);
        let status = solution.status;
        assert_eq!(status, Status::Infeasible, "{minimizer:?}");
        assert!((solution.violation - 0.5).abs() < 1e-3, "{minimizer:?}");
    }
}

#[test]
fn cost_without_a_minimum_diverges() {
    let problem = counter(5, -1.0);
    let mut guess = Trajectory::zero_input(&problem);
    guess.inputs[2][0] = 1.0;
    for minimizer in [
        Minimizer::Lbfgs,
        Minimizer::SteepestDescent,
        Minimizer::NewtonCg,
    ] {
        let solution = SingleShooting::new(&problem).solve(&guess, minimizer);
        assert_eq!(solution.status, Status::Diverged, "{minimizer:?}");
        assert!(solution.cost < -1e25, "{minimizer:?}");
    }
    // A trust radius grows too slowly for a check within the iterations.
    let solution = SingleShooting::new(&problem).solve(&guess, Minimizer::TrustRegion);
    assert!(
        !solution.is_converged() && solution.cost < -1.0,
        "{}",
        solution.status
    );
}

#[test]
fn guess_that_is_not_finite_diverges_and_few_iterations_are_kept() {
    let problem = swing(20);
    let mut guess = Trajectory::zero_input(&problem);
    for minimizer in Minimizer::ALL {
        let few = ShootingOptions {
            max_iterations: 3,
            ..ShootingOptions::default()
        };
        let mut reports = Vec::new();
        let solution =
            SingleShooting::with_options(&problem, few)
                .solve_with(&guess, minimizer, |progress| reports.push(*progress));
        check_result(&problem, minimizer, &solution);
        assert_eq!(
            (solution.status, solution.iterations),
            (Status::IterationLimit, 3)
        );
        let reported: Vec<f64> = reports.iter().map(|progress| progress.cost).collect();
        assert_eq!(reported, solution.cost_history[1..], "{minimizer:?}");
    }
    guess.inputs[3][0] = f64::NAN;
    for minimizer in Minimizer::ALL {
        let solution = SingleShooting::new(&problem).solve(&guess, minimizer);
        assert_eq!(solution.status, Status::Diverged, "{minimizer:?}");
    }
}

#[test]
fn horizon_without_steps_is_converged() {
    for minimizer in Minimizer::ALL {
        let solution = solve(&masses(0), minimizer);
        assert!(solution.is_converged() && solution.iterations == 0);
    }
}

type Iterate = IterState<Vec<f64>, Vec<f64>, (), (), (), f64>;
type Method = LBFGS<MoreThuenteLineSearch<Vec<f64>, Vec<f64>, f64>, Vec<f64>, Vec<f64>, f64>;

/// Keeps the costs it sees.
struct Costs(Arc<Mutex<Vec<f64>>>);
impl Observe<Iterate> for Costs {
    fn observe_iter(&mut self, state: &Iterate, _: &KV) -> Result<(), Error> {
        self.0.lock().unwrap().push(state.get_cost());
        Ok(())
    }
}

/// The last method and state, in memory; resumed for 20 iterations in all.
#[derive(Clone, Default)]
struct Kept(Arc<Mutex<Option<(Method, Iterate)>>>);
impl Checkpoint<Method, Iterate> for Kept {
    fn save(&self, method: &Method, state: &Iterate) -> Result<(), Error> {
        *self.0.lock().unwrap() = Some((method.clone(), state.clone()));
        Ok(())
    }
    fn load(&self) -> Result<Option<(Method, Iterate)>, Error> {
        let kept = self.0.lock().unwrap().clone();
        Ok(kept.map(|(method, state)| (method, state.max_iters(20))))
    }
    fn frequency(&self) -> CheckpointingFrequency {
        CheckpointingFrequency::Every(5)
    }
}

#[test]
fn run_of_argmin_resumed_from_a_checkpoint_equals_one_that_went_through() {
    let problem = swing(20);
    let shooting = SingleShooting::new(&problem);
    let (costs, kept) = (Arc::new(Mutex::new(Vec::new())), Kept::default());
    let run = |iterations: u64, kept: Kept| {
        let z = shooting.variables(&Trajectory::zero_input(&problem));
        let run = Executor::new(&shooting, LBFGS::new(MoreThuenteLineSearch::new(), 5))
            .configure(|state| state.param(z).max_iters(iterations))
            .add_observer(Costs(costs.clone()), ObserverMode::Always)
            .checkpointing(kept)
            .run();
        run.unwrap().state().get_best_param().unwrap().clone()
    };
    let through = run(20, Kept::default());
    run(7, kept.clone());
    let resumed = run(20, kept);
    assert_eq!(through, resumed);
    let costs = costs.lock().unwrap();
    // 20 iterations, 7, and those from the fifth on.
    assert_eq!(costs.len(), 20 + 7 + 15);
    assert_eq!(costs[5..20], costs[27..]);
    let expected = shooting.trajectory(&through).cost(&problem);
    assert!((costs[19] - expected).abs() < SAME_ALGEBRA * expected);
}
