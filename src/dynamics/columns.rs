//! A force for each degree of freedom, which a sweep carries towards the world.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use crate::model::{Body, Model};
use crate::scalar::{Additive, Scalar};
use crate::spatial::Force;

/// The forces of single degrees of freedom on the body that the sweep has come to: one column for each that a body has, followers
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
        for (body, first) in bodies.iter().zip(&mut self.first[1..]) {
            for k in 0..body.joint.nv() {
                self.v[n + k] = body.v + k;
            }
            n += body.joint.nv();
            *first = n;
        }
    }
}
