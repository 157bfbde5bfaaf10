//! The problem: a system, a horizon, costs, bounds, constraints.

use std::fmt;

use nalgebra::DVector;

use super::constraint::{Constraint, check_bounds};
use super::cost::Cost;
use super::system::{AnySystem, System};
use crate::error::OutOfMemory;
use crate::memory;
use crate::scalar::MapEach;

/// Initial state of a trajectory: given or free.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InitialState {
    /// The first state is given.
    #[default]
    Fixed,
    /// The first state is optimised, starting from the given one.
    Free,
}

/// Minimise  `l_N`(`x_N`) + Δt Σₖ lₖ(xₖ, uₖ)  over k = 0 … N − 1 subject to xₖ₊₁ = f(xₖ, uₖ), bounds on the inputs, and
/// constraints.
///
/// # Examples
/// ```
/// use dualbody::{Simulator, model::samples, trajopt::{Activation, Cost, Ddp, InputError, Problem, StateError, Trajectory}};
///
/// let pendulum = Simulator::new(samples::pendulum()).with_time_step(0.05);
/// let effort = Cost::new().with(1e-2, Activation::Quadratic, InputError::to_zero(&pendulum));
/// let arrive = Cost::new().with(1e3, Activation::Quadratic, StateError::to(&[3.14, 0.0]));
/// let problem = Problem::new(pendulum, 40, &[0.0, 0.0])
///     .with_stage_cost(effort)
///     .with_final_cost(arrive)
///     .with_input_bounds(&[-3.0], &[3.0]);
/// let mut ddp = Ddp::new(&problem);
/// let swing = ddp.solve(&problem, &Trajectory::zero_input(&problem));
/// assert!(swing.is_converged() && (swing.trajectory.states[40][0] - 3.14).abs() < 0.05);
/// ```
pub struct Problem {
    dynamics: Box<dyn AnySystem>,
    horizon: usize,
    first_stage: usize,
    start: DVector<f64>,
    initial: InitialState,
    lower: DVector<f64>,
    upper: DVector<f64>,
    stage_cost: Cost,
    final_cost: Cost,
    constraints: Vec<Constraint>,
    final_constraints: Vec<Constraint>,
}

impl Problem {
    /// Makes a problem of `horizon` steps from the state `start`, without costs, bounds or constraints.
    ///
    /// # Panics
    /// If `start` does not have length `nx`.
    pub fn new(dynamics: impl System, horizon: usize, start: &[f64]) -> Self {
        let dynamics = dynamics.boxed();
        check_start(&*dynamics, start);
        let nu = dynamics.nu();
        Self {
            dynamics,
            horizon,
            first_stage: 0,
            start: DVector::from_column_slice(start),
            initial: InitialState::Fixed,
            lower: DVector::from_element(nu, f64::NEG_INFINITY),
            upper: DVector::from_element(nu, f64::INFINITY),
            stage_cost: Cost::new(),
            final_cost: Cost::new(),
            constraints: Vec::new(),
            final_constraints: Vec::new(),
        }
    }

    /// Sets lₖ, the cost per unit of time of all stages: it is multiplied by the time step.
    ///
    /// # Panics
    /// If an activation is not made for its residual.
    #[must_use]
    pub fn with_stage_cost(mut self, cost: Cost) -> Self {
        self.set_stage_cost(cost);
        self
    }

    /// Sets `l_N`, the cost of the last state.
    ///
    /// # Panics
    /// If an activation is not made for its residual, or if a term is about the input.
    #[must_use]
    pub fn with_final_cost(mut self, cost: Cost) -> Self {
        self.set_final_cost(cost);
        self
    }

    /// Bounds the inputs of all stages; infinite for no bound. Solutions satisfy the bounds exactly.
    ///
    /// # Panics
    /// If a bound does not have length `nu` or is NaN, or if a lower one is above its upper one.
    #[must_use]
    pub fn with_input_bounds(mut self, lower: &[f64], upper: &[f64]) -> Self {
        let nu = self.dynamics.nu();
        assert!(lower.len() == nu && upper.len() == nu, "nu = {nu} bounds");
        check_bounds(lower, upper);
        self.lower.copy_from_slice(lower);
        self.upper.copy_from_slice(upper);
        self
    }

    /// Adds a constraint on state and input of all stages (not on the last state), for example hard bounds on states.
    ///
    /// # Panics
    /// If its bounds are not as many as its residual has entries.
    #[must_use]
    pub fn with_constraint(mut self, constraint: Constraint) -> Self {
        constraint.check(self.dynamics(), false);
        self.constraints.push(constraint);
        self
    }

    /// Adds a constraint on the last state.
    ///
    /// # Panics
    /// If its bounds are not as many as its residual has entries, or if it is about the input.
    #[must_use]
    pub fn with_final_constraint(mut self, constraint: Constraint) -> Self {
        constraint.check(self.dynamics(), true);
        self.final_constraints.push(constraint);
        self
    }

    /// Sets whether the first state is given or optimised.
    #[must_use]
    pub fn with_initial_state(mut self, initial: InitialState) -> Self {
        self.initial = initial;
        self
    }

    /// Changes the initial state.
    ///
    /// # Panics
    /// If it does not have length `nx`.
    pub(crate) fn set_start(&mut self, start: &[f64]) {
        check_start(self.dynamics(), start);
        self.start.copy_from_slice(start);
    }

    /// Sets the stage of a longer motion at which the problem begins; 0 by default. References along a trajectory
    /// ([`StateError::along`](super::StateError::along), [`Schedule`](super::Schedule)) and costs of some stages are looked up from there. So the
    /// references of a [`RecedingHorizon`](super::RecedingHorizon) move without new costs.
    pub fn set_first_stage(&mut self, stage: usize) {
        self.first_stage = stage;
    }

    /// Changes the cost of the stages; see [`with_stage_cost`](Self::with_stage_cost).
    ///
    /// # Panics
    /// If an activation is not made for its residual.
    pub fn set_stage_cost(&mut self, cost: Cost) {
        cost.check(self.dynamics(), false);
        self.stage_cost = cost;
    }

    /// Changes the cost of the last state; see [`with_final_cost`](Self::with_final_cost).
    ///
    /// # Panics
    /// If an activation is not made for its residual, or if a term is about the input.
    pub fn set_final_cost(&mut self, cost: Cost) {
        cost.check(self.dynamics(), true);
        self.final_cost = cost;
    }

    /// System of the problem, with its time step and sizes.
    pub fn dynamics(&self) -> &dyn AnySystem {
        &*self.dynamics
    }

    /// Checks the memory of a solver for its stages: about four matrices of the size of state and input each.
    ///
    /// # Errors
    /// If they would need more memory than the [limit](crate::memory). Solvers panic with the message.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, model::samples, trajopt::Problem};
    ///
    /// let problem = |horizon| Problem::new(Simulator::new(samples::pendulum()), horizon, &[0.0; 2]);
    /// assert!(problem(1000).check_memory().is_ok());
    /// let error = problem(usize::MAX).check_memory().unwrap_err();
    /// assert!(error.to_string().starts_with("a solver's 18446744073709551615 stages need"));
    /// ```
    pub fn check_memory(&self) -> Result<(), OutOfMemory> {
        let width = self.dynamics.ndx() + self.dynamics.nu();
        let stage = 4 * width * (width + 4) * size_of::<f64>();
        let stages = self.horizon.saturating_add(1);
        let what = format_args!("a solver's {stages} stages");
        memory::check(what, stages.saturating_mul(stage))
    }

    /// Panics with the message of [`check_memory`](Self::check_memory), if it fails.
    pub(super) fn assert_memory(&self) {
        memory::granted(self.check_memory());
    }

    /// Number of steps N.
    pub fn horizon(&self) -> usize {
        self.horizon
    }

    /// The initial state, length `nx`.
    pub fn start(&self) -> &DVector<f64> {
        &self.start
    }

    /// Whether the first state is given or free.
    pub fn initial(&self) -> InitialState {
        self.initial
    }

    /// Lower and upper bounds of the inputs, length `nu` each; infinite for no bound.
    pub fn input_bounds(&self) -> (&DVector<f64>, &DVector<f64>) {
        (&self.lower, &self.upper)
    }

    /// Constraints of every stage.
    pub fn constraints(&self) -> &[Constraint] {
        &self.constraints
    }

    /// Constraints of the last state.
    pub fn final_constraints(&self) -> &[Constraint] {
        &self.final_constraints
    }

    /// The stage as residuals count it: that of a longer motion.
    pub(super) fn stage_of_motion(&self, stage: usize) -> usize {
        self.first_stage + stage
    }

    /// The cost that counts at a stage: that of the last state at the end of the horizon.
    pub(super) fn cost_at(&self, stage: usize) -> &Cost {
        match stage == self.horizon {
            true => &self.final_cost,
            false => &self.stage_cost,
        }
    }

    /// Factor of the cost of a stage: running costs are per unit of time.
    pub(super) fn cost_factor(&self, stage: usize) -> f64 {
        match stage == self.horizon {
            true => 1.0,
            false => self.dynamics.time_step(),
        }
    }

    /// The constraints of a stage: those of the last state at the end of the horizon.
    pub(super) fn constraints_at(&self, stage: usize) -> &[Constraint] {
        match stage == self.horizon {
            true => &self.final_constraints,
            false => &self.constraints,
        }
    }

    /// Whether there is any constraint.
    pub(super) fn is_constrained(&self) -> bool {
        // Where the horizon is zero there are no stages but the last.
        let stages = [0, self.horizon];
        stages
            .iter()
            .any(|&stage| !self.constraints_at(stage).is_empty())
    }

    /// The longest residual of costs and constraints.
    pub(super) fn largest_dim(&self) -> usize {
        let costs = [&self.stage_cost, &self.final_cost];
        let costs = costs.map_each(|cost| cost.largest_dim(self.dynamics()));
        let constraints = self.constraints.iter().chain(&self.final_constraints);
        let dims = constraints.map(Constraint::dim);
        dims.chain(costs).max().unwrap_or(0)
    }

    /// Whether any input is bounded.
    pub(super) fn has_input_bounds(&self) -> bool {
        let mut bounds = self.lower.iter().chain(&self.upper);
        bounds.any(|bound| bound.is_finite())
    }

    pub(super) fn clamp_input(&self, u: &mut [f64]) {
        for (u, (&lower, &upper)) in u.iter_mut().zip(self.lower.iter().zip(&self.upper)) {
            *u = u.clamp(lower, upper);
        }
    }
}

impl fmt::Debug for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Problem")
            .field("horizon", &self.horizon)
            .field("stage_cost", &self.stage_cost)
            .field("final_cost", &self.final_cost)
            .field("constraints", &self.constraints)
            .field("final_constraints", &self.final_constraints)
            .finish_non_exhaustive()
    }
}

fn check_start(dynamics: &dyn AnySystem, start: &[f64]) {
    let nx = dynamics.nx();
    assert_eq!(start.len(), nx, "a state has nx = {nx} numbers");
}
