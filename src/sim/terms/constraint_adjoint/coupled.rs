//! Couplers: derivatives in the positions and rates of their two joints.

use super::HeldConstraint;
use crate::constraint::{Constraint, ConstraintKind, ConstraintRow, CoupledJoint};
use crate::dynamics::ParameterSlots;
use crate::model::Body;
use crate::scalar::{Dual, Scalar};
use crate::sim::parameter_slots::add_to_part;
use crate::sim::terms::adjoint::{AdjointPoint, StepSlopes};

/// Directions: position and rate of each joint, J ã and J μ of each, then the numbers of the coupler.
const RATE: usize = 2;
const SEEN: usize = 4;
const WEIGHT: usize = 6;
const NUMBERS: usize = 8;
/// Ratio, offset, time constant.
const OWN_NUMBERS: usize = 3;

/// A number with its derivatives in these directions.
type Number<T> = Dual<T, { NUMBERS + OWN_NUMBERS }>;

/// The two joints of a coupler.
pub(super) struct CoupledJoints<'a, T> {
    held: &'a HeldConstraint<'a, T>,
    indices: [usize; 2],
    bodies: [&'a Body<f64>; 2],
}

impl<'a, T: Scalar> CoupledJoints<'a, T> {
    /// `None` for a constraint between anchors.
    pub(super) fn of(held: &'a HeldConstraint<'a, T>) -> Option<Self> {
        let ConstraintKind::Coupler { bodies, .. } = held.constraint.kind() else {
            return None;
        };
        Some(Self {
            held,
            indices: bodies.map(|body| body.0),
            bodies: bodies.map(|body| held.model.body(body)),
        })
    }

    /// Adds the gradient of λ (J ã + bias) − f J μ.
    ///
    /// * `seen` – ã
    /// * `bias` – of a row
    pub(super) fn add(
        &self,
        at: &AdjointPoint<'_, T>,
        seen: &[T],
        bias: &dyn Fn(&ConstraintRow<Number<T>>) -> Number<T>,
        slots: &ParameterSlots,
        out: &mut StepSlopes<'_, T>,
    ) {
        let (q, v) = (at.moment.q(), at.moment.v());
        let constraint: Constraint<Number<T>> = self.held.constraint.seeded(NUMBERS);
        let moving = |x: T, direction| Number::variable(x, direction);
        let joints = std::array::from_fn(|i| {
            let own = CoupledJoint::of(self.bodies[i], q, v);
            CoupledJoint {
                position: moving(own.position, i),
                rate: moving(own.rate, RATE + i),
            }
        });
        // J is that of the rates.
        let along = |rates: &[T], first: usize| {
            let joints = std::array::from_fn(|i| CoupledJoint {
                position: Number::from(0.0),
                rate: moving(self.bodies[i].scaled(rates[self.bodies[i].v]), first + i),
            });
            constraint.row_of_joints(&joints).map(|row| row.rate)
        };
        let parts = (
            constraint.row_of_joints(&joints),
            along(seen, SEEN),
            along(at.mu, WEIGHT),
        );
        let (Some(row), Some(along_seen), Some(along_weights)) = parts else {
            return;
        };
        let (y, force) = (self.held.y[0], self.held.forces[0]);
        let sum = (along_seen + bias(&row)).each(|x| x * y) - along_weights.each(|x| x * force);
        add_to_part(
            out.parameters,
            self.held.slots,
            &sum.eps[NUMBERS..],
            T::one(),
        );
        for (i, body) in self.bodies.into_iter().enumerate() {
            let [by_position, by_rate] = [sum.eps[i], sum.eps[RATE + i]];
            out.q[body.v] += body.scaled(by_position);
            out.v[body.v] += body.scaled(by_rate);
            if let Some(ratio) = slots.coupling[self.indices[i]] {
                let k = body.v;
                let by_ratio = by_position * q[body.q]
                    + by_rate * v[k]
                    + sum.eps[SEEN + i] * seen[k]
                    + sum.eps[WEIGHT + i] * at.mu[k];
                let slopes = [by_ratio, by_position];
                add_to_part(out.parameters, &(ratio..ratio + 2), &slopes, T::one());
            }
        }
    }
}
