//! A problem behind a pointer: the numbers that solvers ask for, whatever the system; so solvers are compiled once.

use nalgebra::DVector;

use super::{InitialState, Problem};
use crate::trajopt::constraint::ConstraintVisitor;
use crate::trajopt::cost::terms::TermVisitor;
use crate::trajopt::system::{AnySystem, System};

/// Data of a problem besides its system, costs and constraints.
#[derive(Clone, Debug)]
pub(in crate::trajopt) struct Setting {
    pub(in crate::trajopt) horizon: usize,
    /// The stage of a longer motion that the problem begins at.
    pub(in crate::trajopt) first_stage: usize,
    pub(in crate::trajopt) start: DVector<f64>,
    pub(in crate::trajopt) initial: InitialState,
    /// Bounds of the inputs, length `nu`.
    pub(in crate::trajopt) lower: DVector<f64>,
    pub(in crate::trajopt) upper: DVector<f64>,
}

/// A problem of any system. Stages count from its own beginning.
pub(in crate::trajopt) trait AnyProblem: Sync {
    fn system(&self) -> &dyn AnySystem;

    fn setting(&self) -> &Setting;

    /// Hands out the terms of the cost that counts at a stage: that of the last state at the end of the horizon.
    fn each_cost_term(&self, stage: usize, visit: &mut TermVisitor<'_>);

    /// Hands out the constraints of a stage: those of the last state at the end of the horizon.
    fn each_constraint(&self, stage: usize, visit: &mut ConstraintVisitor<'_>);

    /// The longest residual of costs and constraints.
    fn largest_dim(&self) -> usize;
}

impl<D: System> AnyProblem for Problem<D> {
    fn system(&self) -> &dyn AnySystem {
        self.dynamics().face()
    }

    fn setting(&self) -> &Setting {
        Self::setting(self)
    }

    fn each_cost_term(&self, stage: usize, visit: &mut TermVisitor<'_>) {
        let is_end = stage == self.horizon();
        let cost = if is_end {
            self.final_cost()
        } else {
            self.stage_cost()
        };
        cost.each_term(self.dynamics(), visit);
    }

    fn each_constraint(&self, stage: usize, visit: &mut ConstraintVisitor<'_>) {
        let constraints = match stage == self.horizon() {
            true => self.final_constraints(),
            false => self.constraints(),
        };
        for constraint in constraints {
            constraint.visit(self.dynamics(), visit);
        }
    }

    fn largest_dim(&self) -> usize {
        let costs = [self.stage_cost(), self.final_cost()];
        let costs = costs.map(|cost| cost.largest_dim(self.dynamics()));
        let constraints = self.constraints().iter().chain(self.final_constraints());
        let dims = constraints.map(|constraint| constraint.dim());
        dims.chain(costs).max().unwrap_or(0)
    }
}

impl<'a> dyn AnyProblem + 'a {
    pub(in crate::trajopt) fn horizon(&self) -> usize {
        self.setting().horizon
    }

    pub(in crate::trajopt) fn start(&self) -> &[f64] {
        self.setting().start.as_slice()
    }

    pub(in crate::trajopt) fn initial(&self) -> InitialState {
        self.setting().initial
    }

    pub(in crate::trajopt) fn input_lower(&self) -> &[f64] {
        self.setting().lower.as_slice()
    }

    pub(in crate::trajopt) fn input_upper(&self) -> &[f64] {
        self.setting().upper.as_slice()
    }

    /// The stage as residuals count it: that of a longer motion.
    pub(in crate::trajopt) fn stage_of_motion(&self, stage: usize) -> usize {
        self.setting().first_stage + stage
    }

    /// Factor of the cost of a stage: running costs are per unit of time.
    pub(in crate::trajopt) fn cost_factor(&self, stage: usize) -> f64 {
        if stage == self.horizon() {
            1.0
        } else {
            self.system().time_step()
        }
    }

    /// Whether any input is bounded.
    pub(in crate::trajopt) fn has_input_bounds(&self) -> bool {
        let mut bounds = self.input_lower().iter().chain(self.input_upper());
        bounds.any(|bound| bound.is_finite())
    }

    /// Whether there is any constraint.
    pub(in crate::trajopt) fn is_constrained(&self) -> bool {
        let mut any = false;
        // Where the horizon is zero there are no stages but the last.
        for stage in [0, self.horizon()] {
            self.each_constraint(stage, &mut |_, _| any = true);
        }
        any
    }

    pub(in crate::trajopt) fn clamp_input(&self, u: &mut [f64]) {
        self.setting().clamp_input(u);
    }
}

impl Setting {
    pub(in crate::trajopt) fn clamp_input(&self, u: &mut [f64]) {
        for (u, (&lower, &upper)) in u.iter_mut().zip(self.lower.iter().zip(&self.upper)) {
            *u = u.clamp(lower, upper);
        }
    }
}
