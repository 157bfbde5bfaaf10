//! The solver against other solutions of the same problems, and on problems that have none.

use crate::common::{OTHER_ALGORITHM, ROUNDING, SAME_ALGEBRA};
use dualbody::control::{FiniteHorizonLqr, LqrStage};
use dualbody::model::samples;
use dualbody::trajopt::{
    Activation, Constraint, Cost, Curvature, Ddp, DdpOptions, DdpSolution, InitialState,
    InputError, Node, Problem, RecedingHorizon, RegularizationOptions, Residual, Schedule, Scratch,
    StateError, Status, System, Trajectory,
};
use dualbody::{Scalar, Simulator};
use nalgebra::{DMatrix, DVector, dmatrix};

use crate::common::problems::{
    Counter, Masses, counter, flight, masses, reach, reach_by_steps, swing, tree,
};

fn solve(problem: &Problem, options: DdpOptions) -> DdpSolution {
    let mut ddp = Ddp::with_options(problem, options);
    let solution = ddp.solve(problem, &Trajectory::zero_input(problem)).clone();
    check_result(problem, &solution);
    solution
}

/// Asserts the properties of every result, good or bad.
fn check_result(problem: &Problem, solution: &DdpSolution) {
    let trajectory = &solution.trajectory;
    for u in &trajectory.inputs {
        for i in 0..u.len() {
            let (lower, upper) = problem.input_bounds();
            let (lower, upper) = (lower[i], upper[i]);
            assert!((lower - 1e-9..=upper + 1e-9).contains(&u[i]), "{u}");
        }
    }
    if solution.status == Status::Diverged {
        return;
    }
    let numbers = trajectory.states.iter().chain(&trajectory.inputs).flatten();
    assert!(
        numbers.into_iter().all(|x| x.is_finite()),
        "{}",
        solution.status
    );
    if solution.gap == 0.0 {
        let mut again = Trajectory::rollout(problem, &trajectory.inputs);
        if problem.initial() == InitialState::Free {
            return;
        }
        for (x, y) in again.states.iter_mut().zip(&trajectory.states) {
            assert!(
                (&*x - y).amax() < SAME_ALGEBRA * y.amax().max(1.0),
                "{}",
                (&*x - y).amax()
            );
        }
    }
    let cost = trajectory.cost(problem);
    assert!((cost - solution.cost).abs() <= SAME_ALGEBRA * cost.abs().max(1.0));
}

#[test]
fn linear_quadratic_problem_is_solved_in_one_iteration_by_the_riccati_gains() {
    let problem = masses(30);
    let solution = solve(
        &problem,
        DdpOptions {
            regularization: RegularizationOptions::none(),
            ..DdpOptions::default()
        },
    );
    assert_eq!(
        (solution.status, solution.iterations),
        (Status::Converged, 1)
    );
    let mut step = dualbody::Linearization {
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
    let riccati = FiniteHorizonLqr::discrete(&vec![stage; 30], &(DMatrix::identity(4, 4) * 10.0));
    for k in 0..30 {
        assert!(
            (&solution.gains[k] - &riccati.gains[k]).amax() < SAME_ALGEBRA,
            "stage {k}"
        );
        let u = riccati.control(k, &solution.trajectory.states[k]);
        assert!(
            (&solution.trajectory.inputs[k] - u).amax() < SAME_ALGEBRA,
            "stage {k}"
        );
    }
    let x = problem.start();
    let expected = 0.5 * x.dot(&(&riccati.costs_to_go[0] * x));
    assert!((solution.cost - expected).abs() < SAME_ALGEBRA * expected);
}

// At the optimum the gradient of the cost in every input, by the adjoint, vanishes.
#[test]
fn gradient_of_the_whole_cost_vanishes_at_the_solution() {
    for problem in [swing(40), reach(25), tree(10)] {
        let solution = solve(
            &problem,
            DdpOptions {
                tolerance: 1e-14,
                ..DdpOptions::default()
            },
        );
        assert!(solution.is_converged(), "{}", solution.status);
        let name = problem.dynamics().robot().expect("a robot").name();
        let inputs = &solution.trajectory.inputs;
        let at = |k: usize, i: usize, step: f64| {
            let mut inputs = inputs.clone();
            inputs[k][i] += step;
            Trajectory::rollout(&problem, &inputs).cost(&problem)
        };
        const STEP: f64 = 1e-4;
        for k in (0..inputs.len()).step_by(7) {
            let slope = (at(k, 0, STEP) - at(k, 0, -STEP)) / (2.0 * STEP);
            let curvature =
                (at(k, 0, STEP) + at(k, 0, -STEP) - 2.0 * solution.cost) / (STEP * STEP);
            let newton_step = slope / curvature;
            assert!(
                curvature > 0.0 && newton_step.abs() < 1e-4,
                "{name}, stage {k}: {newton_step:e}"
            );
        }
    }
}

#[cfg(feature = "second-order")]
#[test]
fn exact_curvature_and_gauss_newton_find_the_same_optimum() {
    for problem in [swing(40), tree(5)] {
        let first = solve(
            &problem,
            DdpOptions {
                tolerance: 1e-13,
                ..DdpOptions::default()
            },
        );
        let exact = DdpOptions {
            tolerance: 1e-13,
            curvature: Curvature::Exact,
            ..DdpOptions::default()
        };
        let mut ddp = Ddp::with_options(&problem, exact);
        // From near the first: another start may lead to another optimum.
        let mut guess = first.trajectory.clone();
        guess.inputs.iter_mut().flatten().for_each(|u| *u += 0.01);
        let second = ddp.solve(&problem, &guess);
        assert!(
            first.is_converged() && second.is_converged(),
            "{}",
            second.status
        );
        assert!(
            (first.cost - second.cost).abs() < OTHER_ALGORITHM * first.cost,
            "{} {}",
            first.cost,
            second.cost
        );
        assert!(second.iterations <= 6, "{}", second.iterations);
    }
}

#[cfg(feature = "second-order")]
// Near an optimum, where the exact model is right to second order, its predicted decrease equals that of the cost.
#[test]
fn promised_change_equals_the_actual_one_with_exact_curvature() {
    let problem = tree(3);
    let curvature = Curvature::Exact;
    let options = DdpOptions {
        max_iterations: 1,
        curvature,
        ..DdpOptions::default()
    };
    let optimum = solve(&problem, DdpOptions::default()).trajectory;
    let mut inputs = optimum.inputs;
    inputs.iter_mut().flatten().for_each(|u| *u += 0.01);
    let guess = Trajectory::rollout(&problem, &inputs);
    let mut promised = 0.0;
    let mut ddp = Ddp::with_options(&problem, options);
    let solution = ddp.solve_with(&problem, &guess, |progress| {
        promised = -progress.predicted_reduction.expect("Ddp predicts");
    });
    let actual = solution.cost_history[1] - solution.cost_history[0];
    assert!(actual < -1e-6, "{actual:e}");
    assert!(
        (promised / actual - 1.0).abs() < 1e-4,
        "{promised:e} {actual:e}"
    );
}

#[test]
fn guess_that_does_not_obey_the_dynamics_leads_to_the_same_optimum() {
    let problem = reach(25);
    let expected = solve(&problem, DdpOptions::default());
    let mut guess = Trajectory::zero_input(&problem);
    for (k, x) in guess.states.iter_mut().enumerate() {
        x.iter_mut()
            .enumerate()
            .for_each(|(i, x)| *x += 0.1 * ((k * 5 + i) as f64).sin());
    }
    let mut ddp = Ddp::new(&problem);
    let solution = ddp.solve(&problem, &guess);
    check_result(&problem, solution);
    assert!(solution.is_converged() && solution.gap == 0.0);
    assert!((solution.cost / expected.cost - 1.0).abs() < 1e-6);
}

#[test]
fn input_bounds_hold_and_the_rest_is_optimal() {
    let problem = swing(60).with_input_bounds(&[-2.5], &[2.0]);
    let solution = solve(
        &problem,
        DdpOptions {
            max_iterations: 300,
            ..DdpOptions::default()
        },
    );
    assert!(solution.is_converged(), "{}", solution.status);
    let inputs = &solution.trajectory.inputs;
    let (at_bound, free): (Vec<usize>, Vec<usize>) =
        (0..60).partition(|&k| inputs[k][0] <= -2.5 || inputs[k][0] >= 2.0);
    assert!(
        at_bound.len() > 5 && free.len() > 5,
        "{} at a bound",
        at_bound.len()
    );
    let slope = |k: usize| {
        const STEP: f64 = 1e-4;
        let at = |step: f64| {
            let mut moved = inputs.clone();
            moved[k][0] += step;
            let unbounded = swing(60);
            Trajectory::rollout(&unbounded, &moved).cost(&unbounded)
        };
        (at(STEP) - at(-STEP)) / (2.0 * STEP)
    };
    for k in free {
        assert!(slope(k).abs() < 2e-3, "stage {k}: {:e}", slope(k));
    }
    for k in at_bound {
        assert!(
            slope(k) * inputs[k][0] < 1e-3,
            "stage {k}: pushed against its bound"
        );
    }
}

#[test]
fn box_of_no_width_leaves_only_its_input() {
    let problem = swing(10).with_input_bounds(&[0.7], &[0.7]);
    let solution = solve(&problem, DdpOptions::default());
    assert!(solution.is_converged());
    assert!(solution.trajectory.inputs.iter().all(|u| u[0] == 0.7));
}

// x₂ = x₀ + u₀ + u₁: with the end fixed and ½ (u₀² + u₁²) both inputs are half the way.
#[test]
fn terminal_constraint_equals_closed_form() {
    let arrive = Constraint::equal_to_zero(&Counter, StateError::to(&[3.0]));
    let solution = solve(
        &counter(2, 1.0).with_final_constraint(arrive),
        DdpOptions::default(),
    );
    assert!(
        solution.is_converged() && solution.violation <= 1e-6,
        "{}",
        solution.status
    );
    for u in &solution.trajectory.inputs {
        assert!((u[0] - 1.5).abs() < 1e-6, "{}", u[0]);
    }
}

// Bounds that hardly matter at the optimum, but far from it: the zero-input guess has gaps wherever there is gravity.
#[test]
fn bounded_reach_from_rest_ends_where_the_one_from_the_unbounded_optimum_does() {
    let free = reach_by_steps(100, 0.01);
    let unbounded = solve(&free, DdpOptions::default());
    for bound in [40.0, 30.0, 25.0] {
        let problem = reach_by_steps(100, 0.01).with_input_bounds(&[-bound; 7], &[bound; 7]);
        let options = DdpOptions {
            max_iterations: 130,
            ..DdpOptions::default()
        };
        let from_rest = solve(&problem, options.clone());
        assert!(from_rest.is_converged(), "{bound}: {}", from_rest.status);
        let mut ddp = Ddp::with_options(&problem, options);
        let near = ddp.solve(&problem, &unbounded.trajectory);
        let ratio = from_rest.cost / near.cost;
        assert!((ratio - 1.0).abs() < 1e-5, "{bound}: {ratio}");
        assert!(unbounded.cost <= near.cost * (1.0 + 1e-9), "{bound}");
    }
}

// Here the first policy without bounds leads nowhere; bounds are kept from the start.
// Crocoddyl's BoxFDDP takes 8 iterations from a guess like this if it does not assume that the guess obeys the dynamics, 26 if
// it may.
#[test]
fn bounded_flight_from_a_guess_that_obeys_the_dynamics_takes_as_few_iterations_as_from_one_that_does_not()
 {
    for most in [3.5, 5.0, 10.0] {
        let (problem, hovering) = flight(most);
        let mut torn = hovering.clone();
        torn.states[50][0] += 1e-3;
        let zero_input = Trajectory::zero_input(&problem);
        let mut costs = Vec::new();
        for (name, guess) in [
            ("hovering", hovering),
            ("torn", torn),
            ("zero input", zero_input),
        ] {
            let mut ddp = Ddp::new(&problem);
            let solution = ddp.solve(&problem, &guess);
            check_result(&problem, solution);
            assert!(
                solution.is_converged(),
                "{most} N, {name}: {}",
                solution.status
            );
            let iterations = solution.iterations;
            assert!(
                iterations <= 20,
                "{most} N, {name}: {iterations} iterations"
            );
            costs.push(solution.cost);
        }
        let (low, high) = (
            costs[0].min(costs[1]).min(costs[2]),
            costs[0].max(costs[1]).max(costs[2]),
        );
        assert!(high - low < 1e-8 * high, "{most} N: {costs:?}");
    }
}

#[test]
fn bounds_below_the_inputs_of_the_guess_are_met() {
    let unbounded = solve(&reach(50), DdpOptions::default());
    let problem = reach(50).with_input_bounds(&[-10.0; 7], &[10.0; 7]);
    let options = DdpOptions {
        max_iterations: 300,
        ..DdpOptions::default()
    };
    let mut ddp = Ddp::with_options(&problem, options);
    let solution = ddp.solve(&problem, &unbounded.trajectory);
    check_result(&problem, solution);
    assert!(solution.is_converged(), "{}", solution.status);
    assert!(solution.cost > unbounded.cost && solution.cost < 2.0 * unbounded.cost);
}

// The way there is barred at 1 until the last step.
#[test]
fn state_bounds_equal_closed_form() {
    let bar = Constraint::within(StateError::to(&[0.0]), &[f64::NEG_INFINITY], &[1.0]);
    let arrive = Constraint::equal_to_zero(&Counter, StateError::to(&[4.0]));
    let problem = counter(4, 1.0)
        .with_constraint(bar)
        .with_final_constraint(arrive);
    let solution = solve(&problem, DdpOptions::default());
    assert!(solution.is_converged(), "{}", solution.status);
    let expected = [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 3.0];
    for (u, expected) in solution.trajectory.inputs.iter().zip(expected) {
        assert!((u[0] - expected).abs() < 1e-5, "{} {expected}", u[0]);
    }
}

#[test]
fn constraints_on_a_robot_hold_to_their_tolerance() {
    let still = Constraint::equal_to_zero(
        &Simulator::new(samples::pendulum()),
        StateError::to(&[3.0, 0.0]),
    );
    let slow = Constraint::within(
        StateError::to(&[0.0; 2]),
        &[f64::NEG_INFINITY, -2.5],
        &[f64::INFINITY, 2.5],
    );
    let problem = swing(60).with_final_constraint(still).with_constraint(slow);
    let solution = solve(
        &problem,
        DdpOptions {
            max_iterations: 500,
            ..DdpOptions::default()
        },
    );
    assert!(
        solution.is_converged(),
        "{} {}",
        solution.status,
        solution.violation
    );
    assert!(
        solution.violation <= 1e-6 && solution.trajectory.violation(&problem) == solution.violation
    );
    let fastest = solution
        .trajectory
        .states
        .iter()
        .map(|x| x[1].abs())
        .fold(0.0, f64::max);
    assert!((2.49..2.5 + 1e-6).contains(&fastest), "{fastest}");
}

// The cheapest first state for ½ Σ x² is where the input has nothing to do.
#[test]
fn free_initial_state_equals_closed_form() {
    let cost = Cost::new()
        .with(1.0, Activation::Quadratic, InputError::to_zero(&Counter))
        .with(1.0, Activation::Quadratic, StateError::to(&[2.0]));
    let problem = Problem::new(Counter, 5, &[0.0])
        .with_stage_cost(cost)
        .with_initial_state(InitialState::Free);
    let solution = solve(&problem, DdpOptions::default());
    assert!(solution.is_converged());
    assert!((solution.trajectory.states[0][0] - 2.0).abs() < 1e-8);
    assert!(solution.cost < ROUNDING);
}

/// Two numbers that fall by themselves: x⁺ = x + v / 10, v⁺ = v − 1.
struct Falling;
impl System for Falling {
    fn nx(&self) -> usize {
        2
    }
    fn nu(&self) -> usize {
        0
    }
    fn step<T: Scalar>(&self, x: &[T], _: &[T], _: &mut Scratch, next: &mut [T]) {
        next[0] = x[0] + x[1] * 0.1;
        next[1] = x[1] - 1.0;
    }
}

// v₄ = v₀ − 4 and x₄ = x₀ + (4 v₀ − 6) / 10.
#[test]
fn start_of_a_system_without_inputs_is_found_from_its_end() {
    let end = Cost::new().with(1.0, Activation::Quadratic, StateError::to(&[2.0, 1.0]));
    let problem = Problem::new(Falling, 4, &[0.0; 2]).with_final_cost(end);
    let given = solve(&problem, DdpOptions::default());
    assert!(given.is_converged(), "{}", given.status);
    assert!((given.trajectory.states[4][0] + 0.6).abs() < SAME_ALGEBRA);
    let problem = problem.with_initial_state(InitialState::Free);
    let free = solve(&problem, DdpOptions::default());
    assert!(free.is_converged(), "{}", free.status);
    let start = &free.trajectory.states[0];
    assert!(
        (start[0] - 0.6).abs() < 1e-7 && (start[1] - 5.0).abs() < 1e-7,
        "{start}"
    );
}

#[test]
fn constraints_that_contradict_each_other_are_reported() {
    let [at_one, at_two] =
        [1.0, 2.0].map(|x| Constraint::equal_to_zero(&Counter, StateError::to(&[x])));
    let problem = counter(3, 1.0)
        .with_final_constraint(at_one)
        .with_final_constraint(at_two);
    let solution = solve(
        &problem,
        DdpOptions {
            max_iterations: 1000,
            ..DdpOptions::default()
        },
    );
    assert_eq!(solution.status, Status::Infeasible);
    assert!(
        (solution.violation - 0.5).abs() < 0.01,
        "{}",
        solution.violation
    );
    // Out of reach of the inputs
    let far = Constraint::equal_to_zero(&Counter, StateError::to(&[10.0]));
    let problem = counter(3, 1.0)
        .with_final_constraint(far)
        .with_input_bounds(&[-1.0], &[1.0]);
    let solution = solve(
        &problem,
        DdpOptions {
            max_iterations: 1000,
            ..DdpOptions::default()
        },
    );
    assert_eq!(solution.status, Status::Infeasible);
    assert!(
        (solution.violation - 7.0).abs() < 1e-6,
        "{}",
        solution.violation
    );
}

#[test]
fn cost_without_a_minimum_is_reported() {
    // The end is paid for, the more the farther.
    let rewarded = || Cost::new().with(-1.0, Activation::Quadratic, StateError::to(&[-1.0]));
    let problem = counter(3, 1e-3).with_final_cost(rewarded());
    let solution = solve(
        &problem,
        DdpOptions {
            max_iterations: 500,
            ..DdpOptions::default()
        },
    );
    assert!(
        matches!(
            solution.status,
            Status::Diverged | Status::LineSearchStalled
        ),
        "{}",
        solution.status
    );
    let stopped = solve(
        &problem,
        DdpOptions {
            max_iterations: 2,
            ..DdpOptions::default()
        },
    );
    assert_eq!(stopped.status, Status::IterationLimit);
}

/// 1 + |x|: a step beyond the nonsmooth point is not accepted.
struct Kinked;
impl Residual for Kinked {
    fn dim(&self, _: &Node<'_>) -> usize {
        1
    }
    fn eval<T: Scalar>(&self, _: &Node<'_, T>, x: &[T], _: &[T], r: &mut [T]) {
        r[0] = T::one() + x[0].select_lt(T::zero(), -x[0], x[0]);
    }
}

#[test]
fn change_that_only_strong_regularization_makes_small_is_no_convergence() {
    // From the nonsmooth point x₁ = 0 every step leads uphill, but x₂ is far from 2, where it costs nothing.
    let first = Cost::new().with_during(1..2, 1.0, Activation::Quadratic, Kinked);
    let last = Cost::new().with(0.09, Activation::Quadratic, StateError::to(&[2.0]));
    let problem = Problem::new(Counter, 2, &[1e-12])
        .with_stage_cost(first)
        .with_final_cost(last);
    let solution = solve(&problem, DdpOptions::default());
    assert!(solution.trajectory.states[2][0].abs() < 0.1);
    assert_eq!(solution.status, Status::LineSearchStalled);
}

/// Not a number from the second stage on.
struct Broken;
impl Residual for Broken {
    fn dim(&self, _: &Node<'_>) -> usize {
        1
    }
    fn eval<T: Scalar>(&self, node: &Node<'_, T>, x: &[T], _: &[T], r: &mut [T]) {
        r[0] = if node.stage < 2 {
            x[0]
        } else {
            x[0] * f64::NAN
        };
    }
}

#[test]
fn numbers_that_are_not_finite_are_reported() {
    let problem =
        counter(4, 1.0).with_final_cost(Cost::new().with(1.0, Activation::Quadratic, Broken));
    assert_eq!(
        solve(&problem, DdpOptions::default()).status,
        Status::Diverged
    );
    let problem = counter(4, 1.0);
    let mut guess = Trajectory::zero_input(&problem);
    guess.states[2][0] = f64::NAN;
    let mut ddp = Ddp::new(&problem);
    assert_eq!(ddp.solve(&problem, &guess).status, Status::Diverged);
    assert!(
        ddp.solve(&problem, &Trajectory::zero_input(&problem))
            .is_converged(),
        "it recovers"
    );
}

#[test]
fn problem_without_cost_or_horizon_is_solved_at_once() {
    let problem = Problem::new(Counter, 0, &[1.0]);
    assert!(solve(&problem, DdpOptions::default()).is_converged());
    let problem = Problem::new(Counter, 4, &[1.0]);
    let solution = solve(&problem, DdpOptions::default());
    assert!(solution.is_converged() && solution.cost == 0.0);
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let problem = reach(25);
    // Of more threads than stages some have nothing to do.
    let [one, three, many] = [1, 3, usize::MAX].map(|threads| {
        solve(
            &problem,
            DdpOptions {
                threads,
                ..DdpOptions::default()
            },
        )
    });
    for other in [three, many] {
        assert_eq!(one.trajectory, other.trajectory);
        assert_eq!(
            (&one.cost_history, &one.gains),
            (&other.cost_history, &other.gains)
        );
    }
}

#[test]
fn feedback_along_the_trajectory_equals_its_inputs_there_and_corrects_away_from_it() {
    let problem = swing(40);
    let solution = solve(&problem, DdpOptions::default());
    let (x, u) = (
        &solution.trajectory.states[3],
        &solution.trajectory.inputs[3],
    );
    assert_eq!(solution.control(&problem, 3, x.as_slice()), *u);
    let off = DVector::from_vec(vec![0.1, -0.3]);
    let expected = u - &solution.gains[3] * &off;
    let control = solution.control(&problem, 3, (x + off).as_slice());
    assert!((control - expected).amax() < SAME_ALGEBRA);
    // Within the bounds at any state
    let bounded = swing(40).with_input_bounds(&[-4.0], &[4.0]);
    let within = solve(&bounded, DdpOptions::default());
    for k in 0..40 {
        let u = within.control(&bounded, k, &[-50.0, 30.0]);
        assert!((-4.0..=4.0).contains(&u[0]), "stage {k}: {}", u[0]);
    }
    // Pushed off at the start, feedback pays less than the plan without it.
    let follow = |feedback: bool| {
        let mut x = problem.start() + DVector::from_vec(vec![0.2, 0.0]);
        let mut scratch = Scratch::new();
        for k in 0..40 {
            let u = match feedback {
                true => solution.control(&problem, k, x.as_slice()),
                false => solution.trajectory.inputs[k].clone(),
            };
            let mut next = x.clone();
            let (at, input) = (x.as_slice(), u.as_slice());
            let dynamics = problem.dynamics();
            dynamics.step(at, input, &mut scratch, next.as_mut_slice());
            x = next;
        }
        (x[0] - 3.1).abs()
    };
    assert!(follow(true) < 0.1 * follow(false));
}

#[test]
fn callback_sees_the_cost_history() {
    let problem = swing(40);
    let mut seen = Vec::new();
    let mut ddp = Ddp::new(&problem);
    let solution = ddp.solve_with(&problem, &Trajectory::zero_input(&problem), |progress| {
        seen.push(*progress);
    });
    assert_eq!(seen.len(), solution.iterations);
    for (k, progress) in seen.iter().enumerate() {
        assert_eq!(
            (progress.iteration, progress.cost),
            (k + 1, solution.cost_history[k + 1])
        );
    }
}

#[test]
fn warm_start_at_the_solution_takes_no_iteration() {
    let problem = reach(25);
    let solution = solve(&problem, DdpOptions::default());
    let mut ddp = Ddp::new(&problem);
    let again = ddp.solve(&problem, &solution.trajectory);
    assert_eq!((again.status, again.iterations), (Status::Converged, 0));
}

// For a linear system and a quadratic cost whose end is the infinite-horizon one, looking ahead is the LQR.
#[test]
fn receding_horizon_of_a_linear_system_equals_lqr() {
    let one = dmatrix![1.0];
    let lqr = dualbody::control::Lqr::discrete(&one, &one, &one, &one);
    let running = Cost::new()
        .with(1.0, Activation::Quadratic, StateError::to(&[0.0]))
        .with(1.0, Activation::Quadratic, InputError::to_zero(&Counter));
    let last = Cost::new().with(
        lqr.cost_to_go[0],
        Activation::Quadratic,
        StateError::to(&[0.0]),
    );
    let problem = Problem::new(Counter, 7, &[0.0])
        .with_stage_cost(running)
        .with_final_cost(last);
    let mut controller = RecedingHorizon::new(problem, 2);
    let mut x = 3.0;
    for _ in 0..10 {
        let mut reported = 0;
        let u = controller.control_with(&[x], |progress| reported = progress.iteration)[0];
        assert_eq!(reported, controller.solution().iterations);
        assert!((u + lqr.gain[0] * x).abs() < 1e-8, "{u}");
        x += u;
    }
}

#[test]
fn receding_horizon_with_moving_references_equals_one_with_new_costs_at_every_step() {
    const STEPS: usize = 15;
    let wave = |k: usize| [(0.3 * k as f64).sin()];
    let whole: Vec<_> = (0..2 * STEPS).map(wave).collect();
    let scheduled = || Schedule::new(whole.iter().map(|x| StateError::to(x)));
    let cost = |error: StateError, input: InputError| {
        Cost::new()
            .with(1.0, Activation::Quadratic, error)
            .with(0.1, Activation::Quadratic, input)
    };
    let problem = || Problem::new(Counter, 5, &[0.0]);
    let all = cost(StateError::along(&whole), InputError::along(&whole));
    let last = Cost::new().with(2.0, Activation::Quadratic, scheduled());
    let moving = problem().with_stage_cost(all).with_final_cost(last);
    let (mut moving, mut rebuilt) = (
        RecedingHorizon::new(moving, 3),
        RecedingHorizon::new(problem(), 3),
    );
    let mut x = 0.5;
    for k in 0..STEPS {
        moving.problem_mut().set_first_stage(k);
        let own = cost(
            StateError::along(&whole[k..]),
            InputError::along(&whole[k..]),
        );
        let last = Cost::new().with(2.0, Activation::Quadratic, StateError::to(&wave(k + 5)));
        rebuilt.problem_mut().set_stage_cost(own);
        rebuilt.problem_mut().set_final_cost(last);
        let u = moving.control(&[x])[0];
        assert_eq!(u, rebuilt.control(&[x])[0], "step {k}");
        x += u;
    }
    assert!((x - wave(STEPS)[0]).abs() < 0.2, "{x}");
}

#[test]
#[should_panic(expected = "of stage 1 of a schedule")]
fn schedule_of_residuals_of_several_dimensions_panics() {
    let pieces = [StateAndZeros { zeros: 0 }, StateAndZeros { zeros: 1 }];
    let cost = Cost::new().with(1.0, Activation::Quadratic, Schedule::new(pieces));
    let _ = solve(
        &counter(3, 1.0).with_stage_cost(cost),
        DdpOptions::default(),
    );
}

/// The state and so many zeros after it.
struct StateAndZeros {
    zeros: usize,
}
impl Residual for StateAndZeros {
    fn dim(&self, node: &Node<'_>) -> usize {
        node.dynamics.nx() + self.zeros
    }
    fn eval<T: Scalar>(&self, _: &Node<'_, T>, x: &[T], _: &[T], r: &mut [T]) {
        r.fill(T::zero());
        r[..x.len()].copy_from_slice(x);
    }
}

#[test]
fn receding_horizon_without_iterations_plays_its_guess_stage_by_stage() {
    let problem = counter(3, 1.0);
    let mut guess = Trajectory::zero_input(&problem);
    for (k, u) in guess.inputs.iter_mut().enumerate() {
        u[0] = k as f64 + 1.0;
    }
    let options = DdpOptions {
        max_iterations: 0,
        ..DdpOptions::default()
    };
    let mut controller = RecedingHorizon::from_guess(problem, options, guess);
    let played: Vec<f64> = (0..5).map(|_| controller.control(&[0.0])[0]).collect();
    assert_eq!(played, [1.0, 2.0, 3.0, 3.0, 3.0]);
}

#[test]
#[should_panic(expected = "about the input")]
fn input_cost_at_the_end_panics() {
    let _ = counter(3, 1.0).with_final_cost(Cost::new().with(
        1.0,
        Activation::Quadratic,
        InputError::to(&[0.0]),
    ));
}
