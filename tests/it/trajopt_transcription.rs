//! Direct transcription against closed forms, against the other solvers, and on problems that have no solution.

use std::f64::consts::PI;

use dualbody::dynamics::centroidal_momentum;
use dualbody::model::samples;
use dualbody::trajopt::{
    Activation, Constraint, Cost, Curve, Ddp, DdpOptions, InitialState, InputError, Node, Problem,
    Residual, Robot, Scratch, StateError, Status, System, Trajectory, Transcription,
    TranscriptionOptions, TranscriptionSolution,
};
use dualbody::{Integrator, Scalar, Simulator, State};
use nalgebra::DVector;

use crate::common::{OTHER_ALGORITHM, SAME_ALGEBRA, floating_robot, generator, statue};

/// A mass of 1 kg pushed along a line, in steps of this length.
struct Mass(f64);

impl System for Mass {
    fn nx(&self) -> usize {
        2
    }
    fn nu(&self) -> usize {
        1
    }
    fn time_step(&self) -> f64 {
        self.0
    }
    fn step<T: Scalar>(&self, x: &[T], u: &[T], _: &mut Scratch, next: &mut [T]) {
        next[1] = x[1] + u[0] * self.0;
        next[0] = x[0] + x[1] * self.0 + u[0] * (0.5 * self.0 * self.0);
    }
    fn rate<T: Scalar>(&self, x: &[T], u: &[T], _: &mut Scratch, rate: &mut [T]) {
        (rate[0], rate[1]) = (x[1], u[0]);
    }
}

/// A number whose rate is the input, in steps of this length.
struct Tank(f64);

impl System for Tank {
    fn nx(&self) -> usize {
        1
    }
    fn nu(&self) -> usize {
        1
    }
    fn time_step(&self) -> f64 {
        self.0
    }
    fn step<T: Scalar>(&self, x: &[T], u: &[T], _: &mut Scratch, next: &mut [T]) {
        next[0] = x[0] + u[0] * self.0;
    }
    fn is_vector_space(&self) -> bool {
        true
    }
    fn rate<T: Scalar>(&self, _: &[T], u: &[T], _: &mut Scratch, rate: &mut [T]) {
        rate[0] = u[0];
    }
}

/// Tolerance where the scheme is exact: the accuracy of the quadratic programs.
const EXACT: f64 = 1e-6;

fn effort(dynamics: &impl System) -> Cost {
    Cost::new().with(1.0, Activation::Quadratic, InputError::to_zero(dynamics))
}

/// From rest at 0 to rest at `to` in 1 s with the least ½ ∫ u².
fn block_move(n: usize, to: f64) -> Problem {
    let mass = Mass(1.0 / n as f64);
    let arrive = Constraint::equal_to_zero(&mass, StateError::to(&[to, 0.0]));
    let cost = effort(&mass);
    Problem::new(mass, n, &[0.0; 2])
        .with_stage_cost(cost)
        .with_final_constraint(arrive)
}

fn pendulum(time_step: f64) -> Problem {
    let simulator = Simulator::new(samples::pendulum()).with_time_step(time_step);
    let horizon = (2.0 / time_step).round() as usize;
    let cost = effort(&simulator);
    let arrive = Constraint::equal_to_zero(&simulator, StateError::to(&[2.0, 0.0]));
    Problem::new(simulator, horizon, &[0.0, 0.0])
        .with_stage_cost(cost)
        .with_final_constraint(arrive)
}

fn solve(problem: &Problem) -> TranscriptionSolution {
    solve_by(&Transcription::new(), problem)
}

fn solve_by(solver: &Transcription, problem: &Problem) -> TranscriptionSolution {
    let solution = solver.solve(problem, &Trajectory::zero_input(problem));
    check_result(problem, &solution);
    solution
}

/// Asserts the properties of every result, good or bad.
fn check_result(problem: &Problem, solution: &TranscriptionSolution) {
    let curve = &solution.curve;
    for u in curve.inputs.iter().chain(&curve.middle_inputs) {
        for (i, u) in u.iter().enumerate() {
            let (lower, upper) = problem.input_bounds();
            let (lower, upper) = (lower[i], upper[i]);
            assert!((lower - 1e-9..=upper + 1e-9).contains(u), "{u}");
        }
    }
    let middles = curve.middle_states.iter().chain(&curve.middle_inputs);
    let nodes = curve.states.iter().chain(&curve.inputs);
    let all = middles.chain(nodes).flatten().all(|x| x.is_finite());
    assert!(all || solution.status == Status::Diverged);
    assert_eq!(solution.cost_history.len(), solution.iterations + 1);
    assert_eq!(solution.trajectory, curve.nodes());
    if problem.initial() == InitialState::Fixed {
        assert_eq!(curve.states[0], *problem.start());
    }
}

fn assert_converged(solution: &TranscriptionSolution) {
    assert!(
        solution.is_converged() && solution.gap <= 1e-7 && solution.violation <= 1e-6,
        "{} after {}, gap {:e}, violation {:e}",
        solution.status,
        solution.iterations,
        solution.gap,
        solution.violation
    );
}

// ẍ = u with the least ½ ∫ u² from rest to rest over d in T: by Euler and Lagrange x⁗ = 0, so x = d (3 s² − 2 s³) with
// s = t/T, u = 6 d/T² − 12 d t/T³, and the cost 6 d²/T³.
#[test]
fn block_move_of_least_energy_equals_closed_form_on_any_mesh() {
    for n in [1, 2, 7] {
        let problem = block_move(n, 0.8);
        let solution = solve(&problem);
        assert_converged(&solution);
        assert!(
            (solution.cost - 6.0 * 0.64).abs() < EXACT,
            "{}",
            solution.cost
        );
        for k in 0..=20 {
            let t = k as f64 / 20.0;
            let x = solution.curve.state(problem.dynamics(), t);
            let u = solution.curve.input(t);
            assert!(
                (x[0] - 0.8 * t * t * (3.0 - 2.0 * t)).abs() < EXACT,
                "{n}, {t}: {x}"
            );
            assert!((x[1] - 4.8 * t * (1.0 - t)).abs() < EXACT, "{n}, {t}: {x}");
            assert!((u[0] - 4.8 + 9.6 * t).abs() < 10.0 * EXACT, "{n}, {t}: {u}");
        }
    }
}

// With |u| ≤ 1 the parallel of it: u = 1 up to t = ¼, then down to −1 at ¾, and −1: that goes 11/48 far.
#[test]
fn bounded_block_move_equals_closed_form() {
    let problem = block_move(8, 11.0 / 48.0).with_input_bounds(&[-1.0], &[1.0]);
    let solution = solve(&problem);
    assert_converged(&solution);
    for k in 0..=16 {
        let t = k as f64 / 16.0;
        let u = solution.curve.input(t)[0];
        let expected = (2.0 - 4.0 * t).clamp(-1.0, 1.0);
        assert!((u - expected).abs() < 1e-4, "{t}: {u} {expected}");
    }
    // ½ (½ + ∫ (1 − 4 s)² ds over half a second)
    assert!((solution.cost - 0.5 * (0.5 + 1.0 / 6.0)).abs() < EXACT);
}

// [Bryson, Ho 1975, section 3.11]: x ≤ l on the way from (0, 1) to (0, −1) in 1 s. For l ≤ 1/6 the bound is reached at t = 3 l and
// left at 1 − 3 l; before, x = l (1 − (1 − t/3l)³) and u = −(2/3l) (1 − t/3l). The cost ½ ∫ u² is 4/(9 l).
#[test]
fn state_constraint_of_bryson_and_denham_equals_closed_form() {
    let (l, n) = (1.0 / 9.0, 12);
    let mass = Mass(1.0 / n as f64);
    let below = Constraint::within(
        StateError::to(&[0.0; 2]),
        &[f64::NEG_INFINITY; 2],
        &[l, f64::INFINITY],
    );
    let arrive = Constraint::equal_to_zero(&mass, StateError::to(&[0.0, -1.0]));
    let cost = effort(&mass);
    let problem = Problem::new(mass, n, &[0.0, 1.0])
        .with_stage_cost(cost)
        .with_constraint(below)
        .with_final_constraint(arrive);
    let solution = solve(&problem);
    assert_converged(&solution);
    assert!(
        (solution.cost - 4.0 / (9.0 * l)).abs() < 1e-5,
        "{}",
        solution.cost
    );
    for k in 0..=2 * n {
        let t = k as f64 / (2 * n) as f64;
        let x = solution.curve.state(problem.dynamics(), t)[0];
        let u = solution.curve.input(t)[0];
        let left = (1.0 - t.min(1.0 - t) / (3.0 * l)).max(0.0);
        assert!((x - l * (1.0 - left.powi(3))).abs() < 1e-5, "{t}: {x}");
        assert!((u + 2.0 / (3.0 * l) * left).abs() < 1e-2, "{t}: {u}");
        assert!(x <= l + 1e-6);
    }
}

// ẋ = u with ½ ∫ x² + u²: by Riccati's equation x = cosh(T − t) / cosh T and the cost is ½ tanh T.
#[test]
fn error_of_the_linear_regulator_falls_with_the_fourth_power_of_the_step() {
    let solver = Transcription::with_options(TranscriptionOptions {
        tolerance: 1e-9,
        ..TranscriptionOptions::default()
    });
    let error = |n: usize| {
        let tank = Tank(2.0 / n as f64);
        let cost = effort(&tank).with(1.0, Activation::Quadratic, StateError::to(&[0.0]));
        let problem = Problem::new(tank, n, &[1.0]).with_stage_cost(cost);
        let solution = solve_by(&solver, &problem);
        assert_converged(&solution);
        let of_node = |(k, x): (usize, &DVector<f64>)| {
            let t = 2.0 * k as f64 / n as f64;
            (x[0] - (2.0 - t).cosh() / 2.0_f64.cosh()).abs()
        };
        let largest = solution.curve.states.iter().enumerate().map(of_node);
        let cost = (solution.cost - 0.5 * 2.0_f64.tanh()).abs();
        (largest.fold(0.0, f64::max), cost)
    };
    let (coarse, fine) = (error(4), error(8));
    let order = (coarse.0 / fine.0).log2();
    assert!((3.7..4.6).contains(&order), "{order}: {coarse:?} {fine:?}");
    assert!(fine.1 < coarse.1 / 12.0, "{coarse:?} {fine:?}");
}

// Inputs without a choice leave the dynamics alone: the scheme is an integrator.
#[test]
fn states_of_a_driven_robot_converge_with_fourth_order_to_those_of_a_fine_rollout() {
    for model in [samples::double_pendulum(), samples::random_tree(5, 5)] {
        let base = Simulator::new(model);
        let nu = base.nu();
        let push: Vec<f64> = (0..nu).map(|k| 0.5 * (1.0 + k as f64).sin()).collect();
        let start = State::random(base.model(), &mut generator(4), 0.5);
        let fine = base.clone().with_integrator(Integrator::RungeKutta4);
        let fine = fine.with_time_step(1e-3).rollout(&start, 400, |_, _, u| {
            u.copy_from_slice(&push);
        });
        let end = base.pack(fine.last());
        let error = |n: usize| {
            let simulator = base.clone().with_time_step(0.4 / n as f64);
            let start = simulator.pack(&start);
            let problem =
                Problem::new(simulator, n, start.as_slice()).with_input_bounds(&push, &push);
            let solution = solve(&problem);
            assert_converged(&solution);
            let mut dx = vec![0.0; problem.dynamics().ndx()];
            let last = solution.curve.states[n].as_slice();
            problem.dynamics().difference(end.as_slice(), last, &mut dx);
            dx.iter().fold(0.0, |max: f64, dx| max.max(dx.abs()))
        };
        let (coarse, finer) = (error(4), error(8));
        let order = (coarse / finer).log2();
        let name = base.model().name();
        assert!(
            (3.5..5.0).contains(&order),
            "{name}: {order}, {coarse:e} {finer:e}"
        );
    }
}

#[test]
fn optimum_of_a_robot_converges_with_fourth_order_to_that_of_a_fine_mesh() {
    let solver = Transcription::with_options(TranscriptionOptions {
        tolerance: 1e-9,
        ..TranscriptionOptions::default()
    });
    let [coarse, finer, fine] = [0.2, 0.1, 0.025].map(|h| {
        let problem = pendulum(h);
        let solution = solve_by(&solver, &problem);
        assert_converged(&solution);
        solution
    });
    let error = |from: &TranscriptionSolution, every: usize| {
        let both = from
            .curve
            .states
            .iter()
            .zip(fine.curve.states.iter().step_by(every));
        both.map(|(x, y)| (x - y).amax()).fold(0.0, f64::max)
    };
    let order = (error(&coarse, 8) / error(&finer, 4)).log2();
    assert!(
        (3.5..4.7).contains(&order),
        "{order}: {:e}",
        error(&finer, 4)
    );
}

/// A cart-pole swung up in 2 s with at most 20 N.
fn swing_up(time_step: f64, integrator: Integrator) -> Problem {
    let simulator = Simulator::new(samples::cartpole()).with_time_step(time_step);
    let simulator = simulator.with_integrator(integrator);
    let simulator = simulator.with_actuated_joints(&["linear"]).unwrap();
    let horizon = (2.0 / time_step).round() as usize;
    let upright = || StateError::to_neutral(&simulator);
    let running = Cost::new()
        .with(0.1, Activation::Quadratic, upright())
        .with(1e-2, Activation::Quadratic, InputError::to_zero(&simulator));
    let arrive = Constraint::equal_to_zero(&simulator, upright());
    Problem::new(simulator.clone(), horizon, &[0.0, PI, 0.0, 0.0])
        .with_stage_cost(running)
        .with_final_constraint(arrive)
        .with_input_bounds(&[-20.0], &[20.0])
}

/// The cost of the solution of differential dynamic programming near a curve, with this step.
fn cost_by_steps(curve: &Curve, time_step: f64) -> f64 {
    let problem = swing_up(time_step, Integrator::RungeKutta4);
    let mut guess = Trajectory::zero_input(&problem);
    for (k, x) in guess.states.iter_mut().enumerate() {
        *x = curve.state(problem.dynamics(), k as f64 * time_step);
    }
    for (k, u) in guess.inputs.iter_mut().enumerate() {
        *u = curve.input((k as f64 + 0.5) * time_step);
    }
    let options = DdpOptions {
        max_iterations: 300,
        ..DdpOptions::default()
    };
    let mut ddp = Ddp::with_options(&problem, options);
    let solution = ddp.solve(&problem, &guess);
    assert!(solution.is_converged(), "{}", solution.status);
    solution.cost
}

// The sum of the costs of the stages is of first order in the step; three steps give its limit up to terms of third
// order.
#[test]
fn swing_up_costs_what_ddp_finds_in_the_limit_of_small_steps() {
    let solution = solve(&swing_up(0.05, Integrator::RungeKutta4));
    assert_converged(&solution);
    let [long, middle, short] = [0.02, 0.01, 0.005].map(|h| cost_by_steps(&solution.curve, h));
    let limit = (long - 6.0 * middle + 8.0 * short) / 3.0;
    let error = (solution.cost - limit).abs();
    assert!(error < 1e-5 * limit, "{} {limit}", solution.cost);
    assert!(error < 1e-2 * (short - limit).abs());
}

// Only gravity acts from outside: the angular momentum about the centre of mass is constant up to the error of the
// mesh.
#[test]
fn momentum_of_a_floating_robot_is_conserved_to_fourth_order() {
    let base = Simulator::new(floating_robot());
    let (model, nv) = (base.model(), base.model().nv());
    let joints: Vec<&str> = model.joint_names().to_vec();
    let base = base.clone().with_actuated_joints(&joints).unwrap();
    let mut start = State::neutral(model);
    start.v[nv - 1] = 1.0;
    let momentum = |x: &DVector<f64>| {
        let (q, v) = x.as_slice().split_at(model.nq());
        centroidal_momentum(model, q, v).angular
    };
    let drift = |n: usize| {
        let simulator = base.clone().with_time_step(0.6 / n as f64);
        let start = simulator.pack(&start);
        // The last joint is to come to rest, against the others.
        let mut goal = start.clone();
        goal[model.nq() + nv - 1] = 0.0;
        let rest = StateError::to(goal.as_slice());
        let mut weights = vec![0.0; 2 * nv];
        weights[2 * nv - 1] = 10.0;
        let last = Cost::new().with(1.0, Activation::Weighted(weights), rest);
        let cost = effort(&simulator);
        let problem = Problem::new(simulator, n, start.as_slice())
            .with_stage_cost(cost)
            .with_final_cost(last);
        let solution = solve(&problem);
        assert_converged(&solution);
        let states = &solution.curve.states;
        let last = states[n].as_slice();
        assert!(last[model.nq() + nv - 1] < 0.9, "it does something");
        let initial = momentum(&states[0]);
        assert!(initial.norm() > 1e-3, "there is momentum");
        let all = states.iter().map(|x| (momentum(x) - initial).norm());
        all.fold(0.0, f64::max)
    };
    // Coarser meshes are still far from the limit, finer ones come near the tolerance of the solver.
    let (coarse, fine) = (drift(6), drift(12));
    let order = (coarse / fine).log2();
    assert!((3.8..4.2).contains(&order), "{order}: {coarse:e} {fine:e}");
}

#[test]
fn path_constraint_holds_at_nodes_and_middles() {
    let fastest = 2.5;
    let slow = Constraint::within(
        StateError::to(&[0.0; 2]),
        &[f64::NEG_INFINITY, -fastest],
        &[f64::INFINITY, fastest],
    );
    let free = solve(&pendulum(0.1));
    let problem = pendulum(0.1).with_constraint(slow);
    let solution = solve(&problem);
    assert_converged(&solution);
    let curve = &solution.curve;
    let largest = |curve: &Curve| {
        let all = curve.states.iter().chain(&curve.middle_states);
        all.map(|x| x[1].abs()).fold(0.0, f64::max)
    };
    assert!(
        largest(&free.curve) > 1.1 * fastest,
        "the constraint matters"
    );
    assert!((fastest - 1e-4..fastest + 1e-6).contains(&largest(curve)));
    assert!(solution.cost > free.cost);
    assert!((largest(curve) - fastest).max(0.0) <= solution.violation + 1e-15);
}

#[test]
fn free_initial_state_equals_closed_form() {
    let tank = Tank(0.2);
    let cost = effort(&tank).with(1.0, Activation::Quadratic, StateError::to(&[2.0]));
    let problem = Problem::new(tank, 5, &[0.0])
        .with_stage_cost(cost)
        .with_initial_state(InitialState::Free);
    let solution = solve(&problem);
    assert_converged(&solution);
    assert!((solution.curve.states[0][0] - 2.0).abs() < 1e-5);
    assert!(solution.cost < 1e-10);
}

#[test]
fn constraints_that_cannot_be_met_are_reported() {
    // At 1 N the mass gets 1/4 m far and back to rest in 1 s.
    let problem = block_move(10, 0.5).with_input_bounds(&[-1.0], &[1.0]);
    let solution = solve(&problem);
    assert_eq!(solution.status, Status::Infeasible);
    assert!(solution.gap < 1e-7 && solution.violation > 1e-2);
    let tank = Tank(0.1);
    let [at_one, at_two] =
        [1.0, 2.0].map(|x| Constraint::equal_to_zero(&tank, StateError::to(&[x])));
    let problem = Problem::new(tank, 3, &[0.0])
        .with_final_constraint(at_one)
        .with_final_constraint(at_two);
    let solution = solve(&problem);
    assert_eq!(solution.status, Status::Infeasible);
    // Together they are violated by at least 1; the larger by half of that.
    assert!(
        (0.5 - 1e-6..=1.0 + 1e-6).contains(&solution.violation),
        "{}",
        solution.violation
    );
}

#[test]
fn cost_without_a_minimum_is_reported() {
    let tank = Tank(10.0);
    let rewarded = Cost::new().with(-1.0, Activation::Quadratic, StateError::to(&[-1.0]));
    let problem = Problem::new(tank, 1, &[0.0]).with_final_cost(rewarded);
    let patient = TranscriptionOptions {
        max_iterations: 3000,
        ..TranscriptionOptions::default()
    };
    let solution = solve_by(&Transcription::with_options(patient), &problem);
    let status = solution.status;
    assert!(
        matches!(status, Status::Diverged | Status::LineSearchStalled),
        "{status}"
    );
    let stopped = TranscriptionOptions {
        max_iterations: 1,
        ..TranscriptionOptions::default()
    };
    let solution = solve_by(&Transcription::with_options(stopped), &pendulum(0.1));
    assert_eq!(
        (solution.status, solution.iterations),
        (Status::IterationLimit, 1)
    );
}

/// Not a number.
struct Broken;
impl Residual for Broken {
    fn dim(&self, _: &Node<'_>) -> usize {
        1
    }
    fn eval<T: Scalar>(&self, _: &Node<'_, T>, x: &[T], _: &[T], r: &mut [T]) {
        r[0] = x[0] * f64::NAN;
    }
}

#[test]
fn numbers_that_are_not_finite_are_reported() {
    let broken = Cost::new().with(1.0, Activation::Quadratic, Broken);
    let problem = block_move(4, 1.0).with_final_cost(broken);
    assert_eq!(solve(&problem).status, Status::Diverged);
    let problem = block_move(4, 1.0).with_constraint(Constraint::within(Broken, &[0.0], &[1.0]));
    assert_eq!(solve(&problem).status, Status::Diverged);
    let problem = block_move(4, 1.0);
    let mut guess = Trajectory::zero_input(&problem);
    guess.states[2][0] = f64::NAN;
    let solution = Transcription::new().solve(&problem, &guess);
    assert_eq!(
        (solution.status, solution.iterations),
        (Status::Diverged, 0)
    );
}

#[test]
fn problem_without_cost_or_horizon_is_solved_at_once() {
    assert!(solve(&Problem::new(Tank(0.1), 0, &[1.0])).is_converged());
    assert!(solve(&Problem::new(Simulator::new(statue()), 3, &[])).is_converged());
    let solution = solve(&Problem::new(Tank(0.1), 4, &[1.0]));
    assert!(solution.is_converged() && solution.cost == 0.0);
}

#[test]
fn solution_as_a_guess_takes_no_iteration() {
    let problem = pendulum(0.1);
    let solver = Transcription::new();
    let solution = solve(&problem);
    assert!(solution.iterations > 0);
    let again = solver.resume_with(&problem, &solution.curve, |_| {});
    assert_eq!((again.status, again.iterations), (Status::Converged, 0));
    assert_eq!(again.curve, solution.curve);
    // The nodes alone know nothing of the inputs between them.
    let nodes = solver.solve(&problem, &solution.trajectory);
    assert!(nodes.is_converged() && nodes.iterations < solution.iterations);
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let [one, three, many] = [1, 3, usize::MAX].map(|threads| {
        let options = TranscriptionOptions {
            threads,
            ..TranscriptionOptions::default()
        };
        solve_by(&Transcription::with_options(options), &pendulum(0.1))
    });
    for other in [three, many] {
        assert_eq!(
            (&one.curve, &one.cost_history),
            (&other.curve, &other.cost_history)
        );
    }
}

#[test]
fn callback_sees_the_cost_history() {
    let problem = pendulum(0.1);
    let mut seen = Vec::new();
    let guess = Trajectory::zero_input(&problem);
    let solution = Transcription::new().solve_with(&problem, &guess, |progress| {
        seen.push(*progress);
    });
    assert_eq!(seen.len(), solution.iterations);
    for (k, progress) in seen.iter().enumerate() {
        assert_eq!(
            (progress.iteration, progress.cost),
            (k + 1, solution.cost_history[k + 1])
        );
        assert!(progress.predicted_reduction >= Some(0.0));
    }
    let last = seen.last().unwrap();
    assert_eq!(
        (last.gap, last.violation),
        (solution.gap, solution.violation)
    );
}

#[test]
fn curve_passes_through_its_points_and_its_rate_is_that_of_the_dynamics() {
    const STEP: f64 = 1e-4;
    let problem = pendulum(0.1);
    let (dynamics, curve) = (problem.dynamics(), solve(&problem).own.curve);
    assert!((curve.duration() - 2.0).abs() < SAME_ALGEBRA);
    for k in 0..20 {
        let (node, middle) = (0.1 * k as f64, 0.1 * k as f64 + 0.05);
        let points = [
            (node, &curve.states[k], &curve.inputs[k]),
            (middle, &curve.middle_states[k], &curve.middle_inputs[k]),
        ];
        for (time, x, u) in points {
            assert!((curve.state(dynamics, time) - x).amax() < 1e-7, "{time}");
            assert!((curve.input(time) - u).amax() < OTHER_ALGORITHM, "{time}");
        }
        let mut rate = vec![0.0; 2];
        let (x, u) = (curve.state(dynamics, middle), curve.input(middle));
        let mut scratch = Scratch::new();
        dynamics.rate(x.as_slice(), u.as_slice(), &mut scratch, &mut rate);
        let [before, after] = [-STEP, STEP].map(|step| curve.state(dynamics, middle + step));
        let slope = (after - before) / (2.0 * STEP);
        assert!((slope - DVector::from_vec(rate)).amax() < 1e-4, "{middle}");
    }
    assert_eq!(curve.state(dynamics, -1.0), curve.states[0]);
    assert_eq!(curve.input(9.0), curve.inputs[20]);
    let held = curve.held();
    assert_eq!((held.states.len(), held.inputs.len()), (21, 20));
}

#[test]
#[should_panic(expected = "a horizon of 20")]
fn guess_of_another_shape_panics() {
    let guess = Trajectory::zero_input(&pendulum(0.2));
    Transcription::new().solve(&pendulum(0.1), &guess);
}
