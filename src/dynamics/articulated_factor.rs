//! Articulated inertias: the part of the articulated-body algorithm that depends on the configuration alone.
//!
//! Going from the tips to the world, each joint is eliminated from the inertia that its parent feels. What is kept of every joint
//! is a factorisation of the mass matrix in O(n), which then serves any right-hand side.
//!
//! Nearly all joints have one axis, which is the local z. They need no small matrix; the functions for them know the axis when
//! they are compiled.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::small_matrix::{factorize, solve};
use crate::joint::{JointKind, MAX_NV};
use crate::model::Body;
use crate::model::manifold::v_range;
use crate::scalar::{Over, Scalar};
use crate::spatial::{ArticulatedInertia, Force, Inertia, Motion, SPATIAL, Transform};

/// The coordinate axis along which revolute and continuous joints move.
pub(crate) const TURN: usize = 5;
/// The coordinate axis along which prismatic joints move.
pub(crate) const SLIDE: usize = 2;

/// The factors, per body and per degree of freedom.
#[derive(Clone, Debug)]
pub(super) struct ArticulatedFactor<T> {
    sin_cos: Vec<(T, T)>,
    /// Joint transforms.
    pub(super) X_PB: Vec<Transform<T>>,
    /// Inertia of each body with what it carries, whose joints give way.
    pub(super) I: Vec<ArticulatedInertia<T>>,
    /// Per degree of freedom: the column of U = I S; for a single axis W = X* U D⁻¹, which the parent feels.
    U: Vec<Force<T>>,
    /// Per degree of freedom: the row of the factors of D = Sᵀ U + armature; for a single axis its reciprocal.
    D: Vec<[T; MAX_NV]>,
}

impl<T: Scalar> ArticulatedFactor<T> {
    /// Memory for `n` bodies.
    pub(super) fn new(n: usize, nq: usize, nv: usize) -> Self {
        Self {
            sin_cos: vec![(T::zero(), T::one()); nq],
            X_PB: vec![Transform::identity(); n],
            I: vec![ArticulatedInertia::rigid(&Inertia::zero()); n],
            U: vec![Force::zero(); nv],
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
    pub(super) fn place<P: Scalar>(
        &mut self,
        i: usize,
        body: &Body<P>,
        joint: JointKind,
        q: &[T],
    ) -> Transform<T>
    where
        T: Over<P>,
    {
        let X = joint.compose_turned(&body.placement, q, || self.sin_cos[body.q]);
        self.X_PB[i] = X;
        self.I[i].set_rigid(&body.inertia);
        X
    }

    /// U, X* U, W = X* U D⁻¹ and D⁻¹ of body i, whose joint has one axis; `resistance` is what the joint itself adds to D.
    #[inline(always)]
    pub(super) fn eliminate_one<const AXIS: usize>(
        &mut self,
        i: usize,
        v: usize,
        resistance: T,
    ) -> ([Force<T>; 3], T) {
        let U = self.I[i].column(AXIS);
        let reciprocal = T::one() / (U.coordinate(AXIS) + resistance);
        let U_P = self.X_PB[i].force(&U);
        let W = U_P.scaled(reciprocal);
        self.U[v] = W;
        self.D[v][0] = reciprocal;
        ([U, U_P, W], reciprocal)
    }

    /// Articulated inertia of body i seen by its parent through a joint with one axis:  X* I X⁻¹ − X* U Wᵀ.
    ///
    /// The inertia is moved before the joint is taken out of it, so that nothing waits for the division.
    #[inline(always)]
    pub(super) fn felt_through_one(
        &self,
        i: usize,
        U_P: &Force<T>,
        W: &Force<T>,
    ) -> ArticulatedInertia<T> {
        self.I[i].moved(&self.X_PB[i]).minus_outer(U_P, W)
    }

    /// U and the factors of D of body i, whose joint has none or several axes; `resistance` is what each coordinate of the robot itself adds to D.
    #[inline(always)]
    pub(super) fn eliminate_several<P>(&mut self, i: usize, body: &Body<P>, resistance: &[T]) {
        let axes = body.joint.axes();
        for (k, &column) in v_range(body).zip(axes) {
            self.U[k] = self.I[i].column(column);
            let U = self.U[k].to_array();
            axes.iter()
                .zip(&mut self.D[k])
                .for_each(|(&axis, D)| *D = U[axis]);
        }
        for (row, k) in v_range(body).enumerate() {
            self.D[k][row] += resistance[k];
        }
        factorize(&mut self.D[v_range(body)]);
    }

    /// Articulated inertia of body i seen through a joint with none or several axes, in the body:  `I_a` = I − U D⁻¹ Uᵀ.
    #[inline(always)]
    pub(super) fn felt_through_several<P>(
        &self,
        i: usize,
        body: &Body<P>,
    ) -> ArticulatedInertia<T> {
        let U = &self.U[v_range(body)];
        // The columns of W = U D⁻¹, row by row of U
        let mut W = [[T::zero(); SPATIAL]; MAX_NV];
        for row in 0..SPATIAL {
            let mut x = [T::zero(); MAX_NV];
            x.iter_mut()
                .zip(U)
                .for_each(|(x, U)| *x = U.coordinate(row));
            self.solve(body, &mut x[..U.len()]);
            W.iter_mut().zip(x).for_each(|(W, x)| W[row] = x);
        }
        let pairs = U.iter().zip(W);
        pairs.fold(self.I[i], |I, (U, W)| {
            I.minus_outer(U, &Force::from_array(W))
        })
    }

    /// D⁻¹ x in place.
    #[inline(always)]
    pub(super) fn solve<P>(&self, body: &Body<P>, x: &mut [T]) {
        solve(&self.D[v_range(body)], x);
    }

    /// X* (F + U D⁻¹ u): what the parent feels of F on body i and of its joint, which has none or several axes and gives way to u.
    #[inline(always)]
    pub(super) fn handed_on_by_several<P>(
        &self,
        i: usize,
        body: &Body<P>,
        u: &[T],
        F: Force<T>,
    ) -> Force<T> {
        let mut x = [T::zero(); MAX_NV];
        let x = &mut x[..u.len()];
        x.copy_from_slice(u);
        self.solve(body, x);
        let columns = self.U[v_range(body)].iter().zip(x);
        self.X_PB[i].force(&columns.fold(F, |F, (U, x)| F + U.scaled(*x)))
    }

    /// Articulated force that the parent sees through any joint:  X* (F + U D⁻¹ u). For a single axis u becomes D⁻¹ u.
    pub(super) fn handed_on<P>(
        &self,
        i: usize,
        body: &Body<P>,
        u: &mut [T],
        F: Force<T>,
    ) -> Force<T> {
        if let [u] = u {
            let F_P = self.X_PB[i].force(&F) + self.U[body.v].scaled(*u);
            *u *= self.D[body.v][0];
            F_P
        } else {
            self.handed_on_by_several(i, body, u, F)
        }
    }

    /// The joints, to be solved with.
    pub(super) fn joints(&self) -> Joints<'_, T> {
        Joints {
            U: &self.U,
            D: &self.D,
        }
    }
}

/// The factors of the joints.
#[derive(Clone, Copy, Debug)]
pub(super) struct Joints<'a, T> {
    U: &'a [Force<T>],
    D: &'a [[T; MAX_NV]],
}

impl<T: Scalar> Joints<'_, T> {
    /// D⁻¹ u − Wᵀ `A_P`: how a joint with one axis accelerates whose parent accelerates by `A_P`.
    #[inline(always)]
    pub(super) fn acceleration(self, v: usize, pushed: &[T], A_P: &Motion<T>) -> T {
        pushed[v] - A_P.power(&self.U[v])
    }

    /// Writes the acceleration  D⁻¹ (u − Uᵀ A)  of a joint with none or several axes to `a`; returns the acceleration of the body.
    #[inline(never)]
    pub(super) fn accelerate<P: Scalar>(
        self,
        body: &Body<P>,
        u: &[T],
        mut A: Motion<T>,
        a: &mut [T],
    ) -> Motion<T> {
        let own = v_range(body);
        T::vectorized(
            #[inline(always)]
            || {
                let x = &mut a[own.clone()];
                for ((x, &u), U) in x.iter_mut().zip(&u[own.clone()]).zip(&self.U[own.clone()]) {
                    *x = u - A.power(U);
                }
                solve(&self.D[own], x);
            },
        );
        body.add_motion(a, &mut A);
        A
    }
}
