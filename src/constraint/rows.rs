//! The rows of constraints at a state: errors, their rates, and Jacobians.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::DMatrix;

use super::anchor::{Anchor, AnchorMotion, turn_between};
use super::{Constraint, ConstraintKind};
use crate::model::{Body, Model};
use crate::scalar::{Over, Scalar};
use crate::spatial::SPATIAL;
use crate::spatial::linear::{dot, scale};

/// A row at a state.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ConstraintRow<T> {
    /// φ.
    pub(crate) error: T,
    /// φ̇ = J v.
    pub(crate) rate: T,
    /// J̇ v.
    pub(crate) bias: T,
    /// T, s.
    pub(crate) time_constant: T,
}

impl<T: Scalar> ConstraintRow<T> {
    /// The second derivative of φ that is wanted: −(2 / T) φ̇ − φ / T², T at least twice the time step.
    pub(crate) fn wanted(&self, dt: f64) -> T {
        let rate = T::one() / self.time_constant.max(T::constant(2.0 * dt));
        -(rate * (self.rate * 2.0 + rate * self.error))
    }
}

/// Rows of several constraints.
#[derive(Clone, Debug)]
pub(crate) struct ConstraintRows<T> {
    pub(crate) rows: Vec<ConstraintRow<T>>,
    /// J, row after row, `nv` numbers each.
    pub(crate) jacobian: Vec<T>,
    /// Of one anchor, and of the second seen from the first, 6 × `nv`.
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
            let time_constant = constraint.time_constant().into();
            let first = self.rows.len();
            match constraint.kind() {
                ConstraintKind::Weld(anchors) => self.weld(model, anchors, (q, v)),
                ConstraintKind::Ball(anchors) => {
                    let [from, to] = self.place(model, anchors, (q, v));
                    self.push_points(&from, &to);
                }
                ConstraintKind::Distance { anchors, length } => {
                    self.distance(model, anchors, (*length).into(), (q, v));
                }
                ConstraintKind::Coupler {
                    bodies,
                    ratio,
                    offset,
                } => {
                    let [one, other] = bodies.map(|body| model.body(body));
                    self.couple([one, other], ((*ratio).into(), (*offset).into()), (q, v));
                }
            }
            let own = &mut self.rows[first..];
            own.iter_mut()
                .for_each(|row| row.time_constant = time_constant);
        }
    }

    /// The motion of the first anchor, and of the second; the Jacobian of the second seen from the first.
    fn place<P: Scalar>(
        &mut self,
        model: &Model<P>,
        anchors: &[Anchor<P>; 2],
        (q, v): (&[T], &[T]),
    ) -> [AnchorMotion<T>; 2]
    where
        T: Over<P>,
    {
        self.relative.fill(T::zero());
        let signs = [-1.0, 1.0];
        std::array::from_fn(|i| {
            let at = anchors[i].motion(model, (q, v));
            let (own, out) = (&mut self.own, &mut self.relative);
            anchors[i].add_jacobian(model, (q, &at), signs[i], own, out);
            at
        })
    }

    /// Three rows: from the origin of one to that of the other.
    fn push_points(&mut self, from: &AnchorMotion<T>, to: &AnchorMotion<T>) {
        let error = to.X.translation - from.X.translation;
        let (V, A) = (to.V - from.V, to.A - from.A);
        for k in 0..3 {
            self.push(error[k], V.linear[k], A.linear[k]);
            self.jacobian.extend(self.relative.row(k).iter());
        }
    }

    fn weld<P: Scalar>(&mut self, model: &Model<P>, anchors: &[Anchor<P>; 2], at: (&[T], &[T]))
    where
        T: Over<P>,
    {
        let [from, to] = self.place(model, anchors, at);
        self.push_points(&from, &to);
        let turn = turn_between(&from.X, &to.X);
        let (V, A) = (to.V - from.V, to.A - from.A);
        for k in 0..3 {
            self.push(turn[k], V.angular[k], A.angular[k]);
            self.jacobian.extend(self.relative.row(3 + k).iter());
        }
    }

    /// With d = ‖p‖ and n = p / d:  ḋ = n · ṗ,  d̈ = n · p̈ + (ṗ · ṗ − ḋ²) / d.
    fn distance<P: Scalar>(
        &mut self,
        model: &Model<P>,
        anchors: &[Anchor<P>; 2],
        length: T,
        at: (&[T], &[T]),
    ) where
        T: Over<P>,
    {
        let [from, to] = self.place(model, anchors, at);
        let p = to.X.translation - from.X.translation;
        let (V, A) = (to.V - from.V, to.A - from.A);
        let least = T::constant(NO_DISTANCE * NO_DISTANCE);
        let square = dot(&p, &p);
        let d = square.select_lt(least, least, square).sqrt();
        let n = scale(&p, T::one() / d);
        let rate = dot(&n, &V.linear);
        let across = dot(&V.linear, &V.linear) - rate * rate;
        self.push(d - length, rate, dot(&n, &A.linear) + across / d);
        let columns = self.relative.column_iter();
        let along = columns.map(|column| n.x * column[0] + n.y * column[1] + n.z * column[2]);
        self.jacobian.extend(along);
    }

    fn couple<P: Scalar>(
        &mut self,
        bodies: [&Body<P>; 2],
        (ratio, offset): (T, T),
        (q, v): (&[T], &[T]),
    ) {
        let position = |body: &Body<P>| {
            let shift = body.coupling.map_or(0.0, |coupling| coupling.offset);
            body.scaled(q[body.q]) + shift
        };
        let [first, second] = bodies;
        let error = position(first) - ratio * position(second) - offset;
        let rate = first.scaled(v[first.v]) - ratio * second.scaled(v[second.v]);
        self.push(error, rate, T::zero());
        let row = self.jacobian.len();
        self.jacobian.resize(row + v.len(), T::zero());
        self.jacobian[row + first.v] += first.scaled(T::one());
        self.jacobian[row + second.v] -= second.scaled(ratio);
    }

    fn push(&mut self, error: T, rate: T, bias: T) {
        self.rows.push(ConstraintRow {
            error,
            rate,
            bias,
            time_constant: T::zero(),
        });
    }
}
