//! Problems without a solution, or with a way into numbers that are not finite: every solver ends with the right status
//! and a trajectory that is finite and within the bounds of its inputs.

use crate::common::OTHER_ALGORITHM;
use dualbody::Scalar;
use dualbody::trajopt::{
    Activation, Constraint, Cost, Curvature, Ddp, DdpOptions, InputError, Minimizer, Node, Problem,
    Residual, Scratch, ShootingOptions, SingleShooting, StateError, Status, System, Trajectory,
};
use nalgebra::dvector;

use crate::common::problems::{Counter, counter, swing};

/// How one way of solving ended.
struct Outcome {
    solver: String,
    status: Status,
    trajectory: Trajectory,
    cost: f64,
    violation: f64,
}

const ITERATIONS: usize = 300;

/// Curvatures of this build of the library.
const CURVATURES: &[Curvature] = match cfg!(feature = "second-order") {
    true => &[Curvature::GaussNewton, Curvature::Exact],
    false => &[Curvature::GaussNewton],
};

/// All ways of solving a problem from a guess; the properties of every result are checked.
fn outcomes(problem: &Problem, guess: &Trajectory) -> Vec<Outcome> {
    let mut all = Vec::new();
    for curvature in CURVATURES {
        let options = DdpOptions {
            max_iterations: ITERATIONS,
            curvature: *curvature,
            ..DdpOptions::default()
        };
        let mut ddp = Ddp::with_options(problem, options);
        let solution = ddp.solve(problem, guess);
        all.push(Outcome {
            solver: format!("Ddp, {curvature:?}"),
            status: solution.status,
            trajectory: solution.trajectory.clone(),
            cost: solution.cost,
            violation: solution.violation,
        });
    }
    for minimizer in Minimizer::ALL {
        let options = ShootingOptions {
            max_iterations: ITERATIONS,
            ..ShootingOptions::default()
        };
        let solution = SingleShooting::with_options(problem, options).solve(guess, minimizer);
        all.push(Outcome {
            solver: format!("{minimizer:?}"),
            status: solution.status,
            trajectory: solution.trajectory,
            cost: solution.cost,
            violation: solution.violation,
        });
    }
    for outcome in &all {
        check(problem, outcome);
    }
    all
}

fn check(problem: &Problem, outcome: &Outcome) {
    let (solver, trajectory) = (&outcome.solver, &outcome.trajectory);
    let (lower, upper) = problem.input_bounds();
    for u in &trajectory.inputs {
        let beyond = (u - upper).sup(&(lower - u)).max();
        // A guess that is not a number does not change.
        let is_lost = outcome.status == Status::Diverged;
        assert!(
            beyond <= OTHER_ALGORITHM || is_lost && beyond.is_nan(),
            "{solver}: {beyond:e} beyond a bound"
        );
    }
    if outcome.status == Status::Diverged {
        return;
    }
    let numbers = trajectory.states.iter().chain(&trajectory.inputs).flatten();
    let are_finite = numbers.into_iter().all(|x| x.is_finite());
    assert!(
        are_finite && outcome.cost.is_finite(),
        "{solver}: {}",
        outcome.status
    );
}

fn expect(outcomes: Vec<Outcome>, right: impl Fn(&Outcome) -> bool) {
    for outcome in outcomes {
        let Outcome { solver, status, .. } = &outcome;
        let (cost, violation) = (outcome.cost, outcome.violation);
        assert!(
            right(&outcome),
            "{solver}: {status}, cost {cost}, violation {violation}"
        );
    }
}

fn at(x: f64) -> Constraint {
    Constraint::equal_to_zero(&Counter, StateError::to(&[x]))
}

#[test]
fn constraints_that_contradict_each_other_are_infeasible() {
    let problem = counter(3, 1.0)
        .with_final_constraint(at(1.0))
        .with_final_constraint(at(2.0));
    expect(outcomes(&problem, &Trajectory::zero_input(&problem)), |o| {
        o.status == Status::Infeasible && (o.violation - 0.5).abs() < 0.01
    });
}

#[test]
fn end_out_of_reach_of_the_inputs_is_infeasible() {
    let problem = counter(3, 1.0).with_final_constraint(at(10.0));
    let problem = problem.with_input_bounds(&[-1.0], &[1.0]);
    expect(outcomes(&problem, &Trajectory::zero_input(&problem)), |o| {
        o.status == Status::Infeasible && (o.violation - 7.0).abs() < 1e-3
    });
}

#[test]
fn start_outside_its_own_constraint_is_infeasible() {
    let low = Constraint::within(StateError::to(&[0.0]), &[f64::NEG_INFINITY], &[-1.0]);
    let problem = counter(4, 1.0).with_constraint(low);
    expect(outcomes(&problem, &Trajectory::zero_input(&problem)), |o| {
        o.status == Status::Infeasible && (o.violation - 1.0).abs() < OTHER_ALGORITHM
    });
}

#[test]
fn cost_without_a_minimum_is_not_converged() {
    // The end is paid for, the more the farther.
    let rewarded = Cost::new().with(-1.0, Activation::Quadratic, StateError::to(&[-1.0]));
    let problem = counter(3, 1e-3).with_final_cost(rewarded);
    expect(outcomes(&problem, &Trajectory::zero_input(&problem)), |o| {
        let cut = matches!(o.status, Status::LineSearchStalled | Status::IterationLimit);
        o.status == Status::Diverged || cut && o.cost < -1e3
    });
    // Bounds give it one: as far as they allow.
    let bounded = counter(3, 1e-3)
        .with_final_cost(Cost::new().with(-1.0, Activation::Quadratic, StateError::to(&[-1.0])))
        .with_input_bounds(&[-2.0], &[2.0]);
    let mut guess = Trajectory::zero_input(&bounded);
    guess.inputs.iter_mut().for_each(|u| u[0] = 0.5);
    expect(outcomes(&bounded, &guess), |o| {
        // ½ (3 · 10⁻³ · 2² − (±6 + 1)²)
        let ends = [-24.494, -12.494].map(|end| (o.cost - end).abs());
        o.status != Status::Converged || ends.iter().any(|far| *far < OTHER_ALGORITHM)
    });
}

/// Not a number where x is above one.
struct RootBelowOne;
impl Residual for RootBelowOne {
    fn dim(&self, _: &Node<'_>) -> usize {
        1
    }
    fn eval<T: Scalar>(&self, _: &Node<'_, T>, x: &[T], _: &[T], r: &mut [T]) {
        r[0] = (-x[0] + 1.0).sqrt();
    }
}

#[test]
fn cost_that_is_not_a_number_nearby_does_not_spoil_the_solution() {
    // The cheapest end, at x = 1, is where numbers end, and every long step leads beyond.
    let end = Cost::new().with(1.0, Activation::Quadratic, RootBelowOne);
    let problem = counter(3, 1e-2).with_final_cost(end);
    let guess = Trajectory::zero_input(&problem);
    let before = guess.cost(&problem);
    expect(outcomes(&problem, &guess), |o| {
        o.status != Status::Diverged && o.cost <= before && o.trajectory.states[3][0] <= 1.0
    });
}

#[test]
fn cost_or_constraint_that_is_never_a_number_diverges() {
    let beyond = || StateError::to(&[f64::NAN]);
    let cost = Cost::new().with(1.0, Activation::Quadratic, beyond());
    let problem = counter(3, 1.0).with_final_cost(cost);
    expect(outcomes(&problem, &Trajectory::zero_input(&problem)), |o| {
        o.status == Status::Diverged
    });
    let problem = counter(3, 1.0).with_constraint(Constraint::equal_to_zero(&Counter, beyond()));
    expect(outcomes(&problem, &Trajectory::zero_input(&problem)), |o| {
        o.status == Status::Diverged && o.violation == f64::INFINITY
    });
}

/// x⁺ = x + x³ + u: beyond one it runs away within few steps.
struct RunAway;
impl System for RunAway {
    fn nx(&self) -> usize {
        1
    }
    fn nu(&self) -> usize {
        1
    }
    fn step<T: Scalar>(&self, x: &[T], u: &[T], _: &mut Scratch, next: &mut [T]) {
        next[0] = x[0] + x[0] * x[0] * x[0] + u[0];
    }
}

#[test]
fn system_that_runs_away_ends_with_a_finite_trajectory_or_says_that_it_diverged() {
    let stay = Cost::new()
        .with(1.0, Activation::Quadratic, StateError::to(&[0.0]))
        .with(1.0, Activation::Quadratic, InputError::to(&[0.0]));
    let problem = Problem::new(RunAway, 30, &[2.0]).with_stage_cost(stay);
    let guess = Trajectory::zero_input(&problem);
    let runs_away = Trajectory::rollout(&problem, &guess.inputs);
    assert!(!runs_away.states[30][0].is_finite());
    for outcome in outcomes(&problem, &guess) {
        // A rollout of zeros is all that single shooting has; the guess of the other obeys no dynamics, and is finite.
        let shoots = !outcome.solver.starts_with("Ddp");
        assert_eq!(
            outcome.status == Status::Diverged,
            shoots,
            "{}",
            outcome.solver
        );
    }
    // From inputs that hold it, all find the same.
    let mut holding = guess;
    holding.inputs[0][0] = -10.0;
    expect(outcomes(&problem, &holding), |o| {
        o.status != Status::Diverged
            && o.cost < Trajectory::rollout(&problem, &holding.inputs).cost(&problem)
    });
}

#[test]
fn guess_that_is_not_finite_diverges() {
    let problem: Problem = swing(20);
    let mut guess = Trajectory::zero_input(&problem);
    guess.inputs[3] = dvector![f64::NAN];
    expect(outcomes(&problem, &guess), |o| o.status == Status::Diverged);
}

/// x⁺ = x + u, without second derivatives.
struct FirstOrder;
impl System for FirstOrder {
    fn nx(&self) -> usize {
        1
    }
    fn nu(&self) -> usize {
        1
    }
    fn step<T: Scalar>(&self, x: &[T], u: &[T], _: &mut Scratch, next: &mut [T]) {
        next[0] = x[0] + u[0];
    }
    fn has_step_hessian(&self) -> bool {
        false
    }
}

#[test]
fn exact_curvature_of_a_system_without_it_is_an_error_that_names_the_feature() {
    let stay = Cost::new().with(1.0, Activation::Quadratic, StateError::to(&[0.0]));
    let problem = Problem::new(FirstOrder, 3, &[2.0]).with_final_cost(stay);
    let guess = Trajectory::zero_input(&problem);
    let options = DdpOptions {
        curvature: Curvature::Exact,
        ..DdpOptions::default()
    };
    let mut ddp = Ddp::with_options(&problem, options);
    let by_ddp = ddp.solve(&problem, &guess);
    let options = ShootingOptions {
        curvature: Curvature::Exact,
        ..ShootingOptions::default()
    };
    let shooting = SingleShooting::with_options(&problem, options);
    let z = shooting.variables(&guess);
    let refused = argmin::core::Hessian::hessian(&shooting, &z).unwrap_err();
    let by_shooting = SingleShooting::with_options(&problem, shooting.options().clone())
        .solve(&guess, Minimizer::NewtonCg);
    assert_eq!(
        (by_ddp.status, by_shooting.status),
        (Status::NoStepHessian, Status::NoStepHessian)
    );
    assert_eq!(by_ddp.trajectory.inputs, guess.inputs);
    for message in [refused.to_string(), by_ddp.status.to_string()] {
        assert!(message.contains("feature `second-order`"), "{message}");
    }
}
