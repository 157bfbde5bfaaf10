//! The rows of constraints at a state: errors, their rates, and Jacobians.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{DMatrix, Vector3};

use super::anchor::{AnchorMotion, turn_between};
use super::{Constraint, ConstraintKind};
use crate::model::manifold::v_range;
use crate::model::{Body, BodyId, Model};
use crate::scalar::{Over, Scalar};
use crate::spatial::SPATIAL;
use crate::spatial::linear::{dot, scale};

/// A row at a state, for accelerations ã in which the linear velocity of floating and planar joints is seen from their joint frame:
/// φ̈ = J ã + b.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ConstraintRow<T> {
    /// φ.
    pub(crate) error: T,
    /// φ̇ = J v.
    pub(crate) rate: T,
    /// b, of second degree in the velocity.
    pub(crate) bias: T,
    /// J (ω × v), by which J ã is more than J v̇.
    pub(crate) turning: T,
    /// T, s.
    pub(crate) time_constant: T,
}

impl<T: Scalar> ConstraintRow<T> {
    /// Stabilised bias at a moment, which J ã has to cancel so that errors decay:  b + (2 / T) φ̇ + φ / T²,  T at least twice the time
    /// step.
    pub(crate) fn at_moment(&self, dt: f64) -> T {
        self.stabilized(self.bias, self.rate, dt)
    }

    /// Stabilised bias over a step of Euler, which J ã has to cancel:  ½ (b + b⁺) + (2 / T) (φ̇ − ½ Δt b) + φ / T²,  with the bias b⁺ at
    /// the velocity after the step. A step moves along that velocity, so φ changed by Δt (φ̇ − ½ Δt b) in the one before.
    pub(crate) fn over_step(&self, after: T, dt: f64) -> T {
        let rate = self.rate - self.bias * (0.5 * dt);
        self.stabilized((self.bias + after) * 0.5, rate, dt)
    }

    fn stabilized(&self, bias: T, rate: T, dt: f64) -> T {
        let often = T::one() / self.time_constant.max(T::constant(2.0 * dt));
        bias + often * (rate * 2.0 + often * self.error)
    }
}

/// Rows of several constraints.
#[derive(Clone, Debug)]
pub(crate) struct ConstraintRows<T> {
    pub(crate) rows: Vec<ConstraintRow<T>>,
    /// J, row after row, `nv` numbers each.
    pub(crate) jacobian: Vec<T>,
    /// The rows at another velocity.
    after: Vec<ConstraintRow<T>>,
    /// Jacobians of one anchor, and of the second relative to the first, 6 × `nv`.
    own: DMatrix<T>,
    relative: DMatrix<T>,
}

/// Distances below this have no direction, m.
const NO_DISTANCE: f64 = 1e-9;

impl<T: Scalar> ConstraintRows<T> {
    /// Memory for so many rows.
    pub(crate) fn new(rows: usize, nv: usize) -> Self {
        Self {
            rows: Vec::with_capacity(rows),
            jacobian: Vec::with_capacity(rows * nv),
            after: Vec::with_capacity(rows),
            own: DMatrix::zeros(SPATIAL, nv),
            relative: DMatrix::zeros(SPATIAL, nv),
        }
    }

    /// Computes all rows at a state; does not allocate.
    pub(crate) fn evaluate<P: Scalar>(
        &mut self,
        model: &Model<P>,
        constraints: &[Constraint<P>],
        (q, v): (&[T], &[T]),
    ) where
        T: Over<P>,
    {
        self.rows.clear();
        self.jacobian.clear();
        for constraint in constraints {
            let motions = constraint.kind().motions(model, (q, v));
            push_rows(&mut self.rows, model, constraint, &motions, (q, v));
            self.push_jacobian(model, constraint.kind(), &motions, q);
        }
        turn(&mut self.rows, model, &self.jacobian, v);
    }

    /// Computes the biases at the velocity after a step, at the configuration of [`evaluate`](Self::evaluate); does not allocate.
    pub(crate) fn look_ahead<P: Scalar>(
        &mut self,
        model: &Model<P>,
        constraints: &[Constraint<P>],
        (q, v): (&[T], &[T]),
    ) where
        T: Over<P>,
    {
        self.after.clear();
        for constraint in constraints {
            let motions = constraint.kind().motions(model, (q, v));
            push_rows(&mut self.after, model, constraint, &motions, (q, v));
        }
        turn(&mut self.after, model, &self.jacobian, v);
    }

    /// b⁺ of a row, from [`look_ahead`](Self::look_ahead).
    pub(crate) fn bias_after(&self, row: usize) -> T {
        self.after[row].bias
    }

    fn push_jacobian<P: Scalar>(
        &mut self,
        model: &Model<P>,
        kind: &ConstraintKind<P>,
        motions: &[AnchorMotion<T>; 2],
        q: &[T],
    ) where
        T: Over<P>,
    {
        self.relative.fill(T::zero());
        for ((anchor, at), sign) in kind.anchors().iter().zip(motions).zip([-1.0, 1.0]) {
            anchor.add_jacobian(model, (q, at), sign, &mut self.own, &mut self.relative);
        }
        match kind {
            ConstraintKind::Weld(_) | ConstraintKind::Ball(_) => {
                for row in self.relative.row_iter().take(kind.rows()) {
                    self.jacobian.extend(row.iter());
                }
            }
            ConstraintKind::Distance { .. } => {
                let n = Direction::between(motions).n;
                let columns = self.relative.column_iter();
                let along = columns.map(|c| n.x * c[0] + n.y * c[1] + n.z * c[2]);
                self.jacobian.extend(along);
            }
            ConstraintKind::Coupler { bodies, ratio, .. } => {
                let [first, second] = bodies.map(|body| model.body(body));
                let row = self.jacobian.len();
                let ratio: T = (*ratio).into();
                self.jacobian.resize(row + model.nv(), T::zero());
                self.jacobian[row + first.v] += first.scaled(T::one());
                self.jacobian[row + second.v] -= second.scaled(ratio);
            }
        }
    }
}

/// Adds the rows of one constraint, without what its axes turn.
fn push_rows<P: Scalar, T: Over<P>>(
    rows: &mut Vec<ConstraintRow<T>>,
    model: &Model<P>,
    constraint: &Constraint<P>,
    motions: &[AnchorMotion<T>; 2],
    at: (&[T], &[T]),
) {
    let time_constant = constraint.time_constant().into();
    let mut push = |error, rate, bias| {
        rows.push(ConstraintRow {
            error,
            rate,
            bias,
            turning: T::zero(),
            time_constant,
        });
    };
    let [from, to] = motions;
    let (V, A) = (to.V - from.V, to.A - from.A);
    if let ConstraintKind::Weld(_) | ConstraintKind::Ball(_) = constraint.kind() {
        let error = to.X.translation - from.X.translation;
        (0..3).for_each(|k| push(error[k], V.linear[k], A.linear[k]));
    }
    match constraint.kind() {
        ConstraintKind::Ball(_) => {}
        ConstraintKind::Weld(_) => {
            let turn = turn_between(&from.X, &to.X);
            (0..3).for_each(|k| push(turn[k], V.angular[k], A.angular[k]));
        }
        // With d = ‖p‖ and n = p / d:  ḋ = n · ṗ,  d̈ = n · p̈ + (ṗ · ṗ − ḋ²) / d.
        ConstraintKind::Distance { length, .. } => {
            let Direction { n, d } = Direction::between(motions);
            let rate = dot(&n, &V.linear);
            let across = dot(&V.linear, &V.linear) - rate * rate;
            let length: T = (*length).into();
            push(d - length, rate, dot(&n, &A.linear) + across / d);
        }
        ConstraintKind::Coupler {
            bodies,
            ratio,
            offset,
        } => {
            let [error, rate] = couple(model, *bodies, ((*ratio).into(), (*offset).into()), at);
            push(error, rate, T::zero());
        }
    }
}

/// Takes what the axes of floating and planar joints turn from the biases.
fn turn<P: Scalar, T: Over<P>>(
    rows: &mut [ConstraintRow<T>],
    model: &Model<P>,
    jacobian: &[T],
    v: &[T],
) {
    for body in model.independent() {
        let own = v_range(body);
        body.joint.turning(&v[own.clone()], |k, x| {
            let entries = jacobian.iter().skip(own.start + k).step_by(v.len());
            for (row, &entry) in rows.iter_mut().zip(entries) {
                row.turning += entry * x;
                row.bias -= entry * x;
            }
        });
    }
}

/// From the origin of one anchor to that of the other.
struct Direction<T> {
    n: Vector3<T>,
    /// m.
    d: T,
}

impl<T: Scalar> Direction<T> {
    fn between([from, to]: &[AnchorMotion<T>; 2]) -> Self {
        let p = to.X.translation - from.X.translation;
        let least = T::constant(NO_DISTANCE * NO_DISTANCE);
        let square = dot(&p, &p);
        let d = square.select_lt(least, least, square).sqrt();
        Self {
            n: scale(&p, T::one() / d),
            d,
        }
    }
}

/// φ and φ̇ of a coupler.
fn couple<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    bodies: [BodyId; 2],
    (ratio, offset): (T, T),
    (q, v): (&[T], &[T]),
) -> [T; 2] {
    let position = |body: &Body<P>| {
        let shift = body.coupling.map_or(0.0, |coupling| coupling.offset);
        body.scaled(q[body.q]) + shift
    };
    let [first, second] = bodies.map(|body| model.body(body));
    [
        position(first) - ratio * position(second) - offset,
        first.scaled(v[first.v]) - ratio * second.scaled(v[second.v]),
    ]
}
