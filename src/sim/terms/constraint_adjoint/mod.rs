//! Gradient of the weighted rows of kinematic constraints.
//!
//! Seen from the two bodies that carry its anchors, a row is a small function of their poses and motions: an evaluation on dual numbers gives its
//! derivatives in these (`carried.rs`), and the sweep along the tree takes them to joints and parameters. Rows that look ahead hold half of the bias at the
//! velocity after the step, which a second sweep, at that velocity, takes there (`ahead.rs`).

mod ahead;
mod carried;
mod coupled;

use std::ops::Range;

use super::adjoint::{AdjointPoint, StepSlopes, TermAdjoint};
use super::columns::turned_into;
use super::constraints::Constraints;
use super::held_rows::Bias;
use crate::constraint::{Constraint, ConstraintRow};
use crate::dynamics::Sweep;
use crate::model::Model;
use crate::scalar::Scalar;
use crate::sim::parameter_slots::PartSlots;
use crate::sim::simulator::Simulator;
use ahead::Ahead;
use coupled::CoupledJoints;

/// The gradient of the term.
#[derive(Clone, Debug)]
pub(crate) struct ConstraintAdjoint<T: Scalar> {
    /// Parameters of each constraint.
    slots: Vec<Range<usize>>,
    /// ã₀ along which rows look ahead.
    seen: Vec<T>,
    /// `None` without constraints.
    ahead: Option<Box<Ahead<T>>>,
    /// Weights of the velocity after the step, to which rows have looked ahead; zeros where none has.
    pub(crate) by_next_v: Vec<T>,
}

/// Rows with weights, at fixed forces and accelerations:  λᵀ y − μᵀ Jᵀ f.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HeldWeights<'a, T> {
    /// λ.
    pub(crate) y: &'a [T],
    /// f.
    pub(crate) forces: &'a [T],
    /// ã.
    pub(crate) seen: &'a [T],
    pub(crate) bias: Bias<'a, T>,
}

/// A constraint with the weights and forces of its rows.
struct HeldConstraint<'a, T> {
    constraint: &'a Constraint,
    model: &'a Model,
    /// Its own parameters.
    slots: &'a Range<usize>,
    y: &'a [T],
    forces: &'a [T],
}

impl<T: Scalar> ConstraintAdjoint<T> {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let nv = simulator.model().nv();
        let any = simulator.held_rows() > 0;
        Self {
            slots: PartSlots::new(simulator).constraints,
            seen: vec![T::zero(); nv],
            ahead: any.then(|| Box::new(Ahead::new(simulator.model()))),
            by_next_v: vec![T::zero(); nv],
        }
    }

    /// Adds the gradient of the first rows, those of constraints.
    ///
    /// * `sweep` – between its passes, with the motions that the rates μ give; it looks along ã
    pub(crate) fn add(
        &mut self,
        at: &AdjointPoint<'_, T>,
        weights: &HeldWeights<'_, T>,
        sweep: &mut Sweep<T>,
        out: &mut StepSlopes<'_, T>,
    ) {
        self.by_next_v.fill(T::zero());
        let Some(ahead) = &mut self.ahead else { return };
        let (moment, dt) = (at.moment, at.moment.dt());
        if let Bias::Ahead(seen) = weights.bias {
            ahead.start(moment, seen);
        }
        let mut row = 0;
        for (constraint, slots) in moment.simulator.constraints().iter().zip(&self.slots) {
            let rows = row..row + constraint.rows();
            row = rows.end;
            let held = HeldConstraint {
                constraint,
                model: moment.model(),
                slots,
                y: &weights.y[rows.clone()],
                forces: &weights.forces[rows],
            };
            if let Some(joints) = CoupledJoints::of(&held) {
                let stabilize = |row: &_| stabilized(row, &weights.bias, dt);
                joints.add(at, weights.seen, &stabilize, &sweep.slots, out);
                continue;
            }
            held.add(&|row| stabilized(row, &weights.bias, dt), sweep, out);
            if let Bias::Ahead(_) = weights.bias {
                held.add(&|row| row.bias * 0.5, &mut ahead.sweep, out);
            }
        }
        if let Bias::Ahead(_) = weights.bias {
            ahead.finish(moment, out, &mut self.by_next_v);
        }
    }
}

/// The bias of a row, but for the half of it that holds the velocity after a step.
fn stabilized<N: Scalar, T>(row: &ConstraintRow<N>, bias: &Bias<'_, T>, dt: f64) -> N {
    match bias {
        Bias::Moment => row.at_moment(dt),
        Bias::Start => row.over_step(row.bias, dt),
        Bias::Ahead(_) => row.over_step(N::zero(), dt),
    }
}

impl<T: Scalar> TermAdjoint<T> for ConstraintAdjoint<T> {
    type Term = Constraints<T>;

    fn add_forces(
        &mut self,
        _: &AdjointPoint<'_, T>,
        _: &Constraints<T>,
        _: &mut Sweep<T>,
        _: &mut StepSlopes<'_, T>,
    ) {
    }

    fn add_rows(
        &mut self,
        at: &AdjointPoint<'_, T>,
        _: &Constraints<T>,
        sweep: &mut Sweep<T>,
        out: &mut StepSlopes<'_, T>,
    ) {
        let moment = at.moment;
        let has_rows = !moment.simulator.constraints().is_empty();
        let Some(rows) = at.rows.filter(|_| has_rows) else {
            return;
        };
        let mut seen = std::mem::take(&mut self.seen);
        let bias = match rows.balance.gyroscopic() {
            None => Bias::Moment,
            Some(gyroscopic) => {
                turned_into(moment.model(), moment.v(), &gyroscopic.a, &mut seen);
                Bias::Ahead(&seen)
            }
        };
        let weights = HeldWeights {
            y: rows.y,
            forces: rows.balance.rows.forces(),
            seen: rows.seen,
            bias,
        };
        self.add(at, &weights, sweep, out);
        self.seen = seen;
    }
}
