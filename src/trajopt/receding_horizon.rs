//! Model-predictive control: solves the problem at each step, from the current state.

use std::fmt;

use super::ddp::{Ddp, DdpOptions, DdpSolution};
use super::problem::Problem;
use super::progress::Progress;
use super::trajectory::Trajectory;

/// A model-predictive controller: warm-started [`Ddp`](super::Ddp) at each step, from the last plan shifted by one stage.
///
/// A fixed number of iterations bounds the time of a call; the plan improves from call to call. To follow a reference that is longer than the
/// horizon, call `controller.problem_mut().set_first_stage(k)` before step k.
///
/// # Examples
/// ```
/// use dualbody::{Simulator, State, model::samples};
/// use dualbody::trajopt::{Activation, Cost, InputError, Problem, RecedingHorizon, StateError};
///
/// let pendulum = Simulator::new(samples::pendulum()).with_time_step(0.05);
/// let cost = Cost::new()
///     .with(1.0, Activation::Quadratic, StateError::to(&[0.5, 0.0]))
///     .with(1e-3, Activation::Quadratic, InputError::to_zero(&pendulum));
/// let problem = Problem::new(pendulum.clone(), 20, &[0.0, 0.0]).with_stage_cost(cost);
/// let mut controller = RecedingHorizon::new(problem, 2);
/// let swing = pendulum.rollout(&State::new(&[0.0], &[0.0]), 60, |_, state, u| {
///     u.copy_from_slice(controller.control(&[state.q[0], state.v[0]]));
/// });
/// assert!((swing.last().q[0] - 0.5).abs() < 0.1);
/// ```
pub struct RecedingHorizon {
    problem: Problem,
    ddp: Ddp,
    plan: Trajectory,
    is_first: bool,
}

impl RecedingHorizon {
    /// Makes a controller with up to `iterations` iterations per step.
    pub fn new(problem: Problem, iterations: usize) -> Self {
        let options = DdpOptions {
            max_iterations: iterations,
            ..DdpOptions::default()
        };
        let plan = Trajectory::zero_input(&problem);
        Self::from_guess(problem, options, plan)
    }

    /// Makes a controller with options, whose first plan starts from a guess; `max_iterations` applies to each step.
    ///
    /// # Panics
    /// If the guess does not have the shape of the problem, or if its horizon has no steps.
    pub fn from_guess(problem: Problem, options: DdpOptions, guess: Trajectory) -> Self {
        guess.check(&problem);
        assert!(
            problem.horizon() > 0,
            "the horizon is 0 steps, expected at least 1"
        );
        Self {
            ddp: Ddp::with_options(&problem, options),
            plan: guess,
            problem,
            is_first: true,
        }
    }

    /// Returns the input at the state `x`: the first input of a plan from there. If no plan is found, that of the last plan.
    ///
    /// * `x` – state, length `nx`
    ///
    /// # Panics
    /// If `x` has the wrong length.
    pub fn control(&mut self, x: &[f64]) -> &[f64] {
        self.control_with(x, |_| {})
    }

    /// [`control`](Self::control) with a report of each iteration.
    ///
    /// # Panics
    /// If `x` has the wrong length.
    pub fn control_with(&mut self, x: &[f64], report: impl FnMut(&Progress)) -> &[f64] {
        self.problem.set_start(x);
        if !self.is_first {
            self.plan.shift();
        }
        self.is_first = false;
        let solution = self.ddp.solve_with(&self.problem, &self.plan, report);
        let all = solution
            .trajectory
            .states
            .iter()
            .chain(&solution.trajectory.inputs);
        if all.into_iter().flatten().all(|x| x.is_finite()) {
            self.plan.copy_from(&solution.trajectory);
        }
        self.plan.inputs[0].as_slice()
    }

    /// The last solution: plan, gains, status.
    pub fn solution(&self) -> &DdpSolution {
        self.ddp.solution()
    }

    /// The problem, mutable, to change its references: [`Problem::set_first_stage`] for references along a trajectory, new costs for others. Horizon
    /// and system are fixed.
    pub fn problem_mut(&mut self) -> &mut Problem {
        &mut self.problem
    }

    /// The problem.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }
}

impl fmt::Debug for RecedingHorizon {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("RecedingHorizon")
            .field("plan", &self.plan)
            .finish_non_exhaustive()
    }
}
