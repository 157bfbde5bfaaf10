//! Articulated inertias: the part of the articulated-body algorithm that depends on the configuration alone.
//!
//! From the leaves to the root, each joint is eliminated from the inertia that its parent feels. The factors of all joints are a factorisation of the
//! mass matrix in O(n), for any right-hand side.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use crate::joint::{Joint, MAX_NV};
use crate::linalg::small_matrix::{factorize, solve};
use crate::model::Body;
use crate::model::manifold::v_range;
use crate::scalar::{Over, Scalar};
use crate::spatial::{ArticulatedInertia, Force, Inertia, SPATIAL, Transform};

/// The factors, per body and per degree of freedom.
#[derive(Clone, Debug)]
pub(super) struct ArticulatedFactor<T> {
    sin_cos: Vec<(T, T)>,
    /// Joint transforms.
    pub(super) X_PB: Vec<Transform<T>>,
    /// Inertia of each body with what it carries, whose joints give way.
    pub(super) I: Vec<ArticulatedInertia<T>>,
    /// Per degree of freedom: the column of W = X* U D⁻¹, what the parent feels of the joint per joint force; of a body on the world none.
    W: Vec<Force<T>>,
    /// Per degree of freedom: the row of the factors of D = Sᵀ U + armature up to the diagonal, of one the reciprocal.
    D: Vec<Row<T>>,
}

impl<T: Scalar> ArticulatedFactor<T> {
    /// Memory for `n` bodies.
    pub(super) fn new(n: usize, nq: usize, nv: usize) -> Self {
        Self {
            sin_cos: vec![(T::zero(), T::one()); nq],
            X_PB: vec![Transform::identity(); n],
            I: vec![ArticulatedInertia::rigid(&Inertia::zero()); n],
            W: vec![Force::zero(); nv],
            D: vec![[T::zero(); MAX_NV]; nv],
        }
    }

    /// The sines and cosines that [`place`](Self::place) reads.
    #[inline(always)]
    pub(super) fn turn(&mut self, q: &[T]) {
        T::sin_cos_each(q, &mut self.sin_cos);
    }

    /// The joint transform of body i, whose articulated inertia starts as its own; `q` is what its joint has of it.
    #[inline(always)]
    pub(super) fn place<P: Scalar, J: Joint>(
        &mut self,
        i: usize,
        body: &Body<P>,
        joint: J,
        q: &[T],
    ) -> Transform<T>
    where
        T: Over<P>,
    {
        let X = joint.compose(&body.placement, q, || self.sin_cos[body.q]);
        self.X_PB[i] = X;
        self.I[i].set_rigid(&body.inertia);
        X
    }

    /// U = I S of body i.
    #[inline(always)]
    pub(super) fn columns<J: Joint>(&self, i: usize, joint: J) -> J::PerDof<Force<T>> {
        let I = &self.I[i];
        joint.per_dof(
            #[inline(always)]
            |k| {
                joint.axis(k).column(
                    #[inline(always)]
                    |axis| I.column(axis),
                )
            },
        )
    }

    /// The factors of D = Sᵀ U + R, which are kept as those of the coordinates from `v` on; `resistance` is the diagonal R of all.
    #[inline(always)]
    pub(super) fn factorize<J: Joint>(
        &mut self,
        joint: J,
        U: &J::PerDof<Force<T>>,
        v: usize,
        resistance: &[T],
    ) -> Square<J, T> {
        let mut D = joint.per_dof(
            #[inline(always)]
            |k| {
                let mut row = joint.per_dof(
                    #[inline(always)]
                    |m| match m <= k {
                        true => joint.axis(m).project(&U.as_ref()[k]),
                        false => T::zero(),
                    },
                );
                row.as_mut()[k] += resistance[v + k];
                row
            },
        );
        factorize(D.as_mut());
        for k in 0..joint.nv() {
            let (kept, row) = (&mut self.D[v + k], D.as_ref()[k].as_ref());
            for m in 0..=k {
                kept[m] = row[m];
            }
        }
        D
    }

    /// X* U and W = X* U D⁻¹, which is kept as that of the coordinates from `v` on: what the parent of body i feels of its joint.
    #[inline(always)]
    pub(super) fn felt<J: Joint>(
        &mut self,
        i: usize,
        joint: J,
        v: usize,
        U: &J::PerDof<Force<T>>,
        D: &Square<J, T>,
    ) -> Felt<J, T> {
        let X = &self.X_PB[i];
        let U_P = joint.per_dof(
            #[inline(always)]
            |k| X.force(&U.as_ref()[k]),
        );
        let W = times_inverse(joint, &U_P, D);
        for k in 0..joint.nv() {
            self.W[v + k] = W.as_ref()[k];
        }
        Felt { U_P, W }
    }

    /// Articulated force that the parent of body i feels of F on the body and of its joint under the forces u:  X* F + W u. Afterwards u is D⁻¹ u.
    pub(super) fn handed_on<P>(
        &self,
        i: usize,
        body: &Body<P>,
        u: &mut [T],
        F: &Force<T>,
    ) -> Force<T> {
        let columns = self.W[v_range(body)].iter().zip(&*u);
        let F_P = columns.fold(self.X_PB[i].force(F), |F, (W, &u)| F + W.scaled(u));
        solve(&self.D[v_range(body)], u);
        F_P
    }

    /// The columns of W.
    #[inline(always)]
    pub(super) fn W(&self) -> &[Force<T>] {
        &self.W
    }
}

/// A row of a small matrix, of which as many entries count as it has rows.
type Row<T> = [T; MAX_NV];

/// A matrix with a row and a column per degree of freedom.
pub(super) type Square<J, T> = <J as Joint>::PerDof<<J as Joint>::PerDof<T>>;

/// Force on the parent of a joint, per degree of freedom.
pub(super) struct Felt<J: Joint, T: Copy> {
    /// X* U.
    pub(super) U_P: J::PerDof<Force<T>>,
    /// X* U D⁻¹.
    pub(super) W: J::PerDof<Force<T>>,
}

/// U D⁻¹, row by row of U.
#[inline(always)]
fn times_inverse<J: Joint, T: Scalar>(
    joint: J,
    U: &J::PerDof<Force<T>>,
    D: &Square<J, T>,
) -> J::PerDof<Force<T>> {
    if let ([U], [D]) = (U.as_ref(), D.as_ref()) {
        let W = U.scaled(D.as_ref()[0]);
        return joint.per_dof(
            #[inline(always)]
            |_| W,
        );
    }
    let mut W = joint.per_dof(|_| [T::zero(); SPATIAL]);
    for row in 0..SPATIAL {
        let mut x = joint.per_dof(
            #[inline(always)]
            |k| U.as_ref()[k].coordinate(row),
        );
        solve(D.as_ref(), x.as_mut());
        for k in 0..joint.nv() {
            W.as_mut()[k][row] = x.as_ref()[k];
        }
    }
    joint.per_dof(
        #[inline(always)]
        |k| Force::from_array(W.as_ref()[k]),
    )
}
