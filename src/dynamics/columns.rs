//! A force for each degree of freedom, which a sweep carries towards the world.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use crate::joint::{Axis, Joint};
use crate::model::{Body, Model};
use crate::scalar::{Additive, Linear, Scalar, pairs};
use crate::spatial::{Force, Transform};

/// The forces of single degrees of freedom on the body that the sweep has come to: one column for each that a body has, mimic joints
/// too, in the order of bodies, so that those of a subtree lie side by side. They do not depend on one another, other than the steps
/// of one of them towards the world.
#[derive(Clone, Debug)]
pub(crate) struct Columns<T> {
    pub(crate) F: Vec<Force<T>>,
    /// Per column: the velocity coordinate.
    pub(crate) v: Vec<usize>,
    /// Per body, and at the end: the first column.
    pub(crate) first: Vec<usize>,
}

impl<T: Additive> Columns<T> {
    pub(crate) fn new<P: Scalar>(model: &Model<P>) -> Self {
        let n = model.bodies().iter().map(|body| body.joint.nv()).sum();
        Self {
            F: vec![Force::zero(); n],
            v: vec![0; n],
            first: vec![0; model.n_bodies() + 1],
        }
    }

    /// Gives each body its columns. Every time, so that nothing here is of another model.
    #[inline(always)]
    pub(crate) fn number<P>(&mut self, bodies: &[Body<P>]) {
        let mut n = 0;
        for (body, first) in pairs(bodies, &mut self.first[1..]) {
            for k in 0..body.joint.nv() {
                self.v[n + k] = body.v + k;
            }
            n += body.joint.nv();
            *first = n;
        }
    }
}

/// Work of an algorithm on the columns at a joint.
pub(crate) trait Payload<X> {
    /// The column of the joint's k-th degree of freedom at its own body; `axis` is its axis.
    fn start(&self, k: usize, axis: Axis) -> Force<X>;

    /// Takes the entry of a column of the joint itself: its part along the axis of row `row`, another or the same coordinate of the joint.
    fn own(&mut self, row: usize, column: usize, entry: X);

    /// Takes the entry of a column that the joint carries; `k` is the joint's degree of freedom, whose coordinate is `row`.
    fn carried(&mut self, k: usize, row: usize, column: usize, entry: X, F: &Force<X>);

    /// Changes a column of the joint itself that leaves for the parent.
    fn leave(&self, k: usize, F: &mut Force<X>);
}

impl<X: Additive> Columns<X> {
    /// At the joint of body i: hands what each column of the subtree has along its axes to the payload, and propagates the columns to the
    /// parent.
    ///
    /// * `X_PB` – pose of the body in its parent; `None` if that is the world, where columns end
    #[inline(always)]
    pub(crate) fn propagate<P, T: Scalar, J: Joint>(
        &mut self,
        i: usize,
        body: &Body<P>,
        joint: J,
        X_PB: Option<&Transform<T>>,
        payload: &mut impl Payload<X>,
    ) where
        X: Linear<T>,
    {
        let (first, end) = (self.first[i], self.first[body.subtree_end]);
        for k in 0..joint.nv() {
            let mut F = payload.start(k, joint.axis(k));
            for m in 0..joint.nv() {
                let entry = along::<X, T>(joint.axis(m), &F);
                payload.own(body.v + m, body.v + k, entry);
            }
            if let Some(X_PB) = X_PB {
                payload.leave(k, &mut F);
                self.F[first + k] = X_PB.force(&F);
            }
        }
        let (all, columns) = (&mut self.F[..end], &self.v[..end]);
        for m in first + joint.nv()..end {
            let (F, column) = (&mut all[m], columns[m]);
            for k in 0..joint.nv() {
                let entry = along::<X, T>(joint.axis(k), F);
                payload.carried(k, body.v + k, column, entry, F);
            }
            if let Some(X_PB) = X_PB {
                *F = X_PB.force(F);
            }
        }
    }
}

/// The part of a column along an axis.
#[inline(always)]
fn along<X: Linear<T>, T: Scalar>(axis: Axis, F: &Force<X>) -> X {
    axis.combine(
        #[inline(always)]
        |k| F.coordinate(k),
        #[inline(always)]
        |about, along, pitch| along.times_plus(T::constant(pitch), about),
    )
}
