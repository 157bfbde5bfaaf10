//! A joint whose kind is known at run time: each function is that of the kind.
//!
//! Frequent kinds are compiled into the algorithms. The other kinds go this way, so that an algorithm is compiled once for all of them; what it
//! does at such a joint loops over the degrees of freedom.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;
use rand::Rng;

use super::{Coordinate, Joint, JointKind, MAX_NV, with_joint};
use crate::scalar::{Over, Scalar};
use crate::spatial::Transform;

/// As many `X` as a joint has degrees of freedom.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Few<X> {
    /// The first `n` count.
    items: [X; MAX_NV],
    n: usize,
}

impl<X> AsRef<[X]> for Few<X> {
    #[inline(always)]
    fn as_ref(&self) -> &[X] {
        &self.items[..self.n]
    }
}

impl<X> AsMut<[X]> for Few<X> {
    #[inline(always)]
    fn as_mut(&mut self) -> &mut [X] {
        &mut self.items[..self.n]
    }
}

impl Joint for JointKind {
    #[inline(always)]
    fn nq(self) -> usize {
        Self::nq(self)
    }

    #[inline(always)]
    fn nv(self) -> usize {
        Self::nv(self)
    }

    type PerDof<X: Copy> = Few<X>;

    /// Of a kind with a degree of freedom.
    #[inline(always)]
    fn per_dof<X: Copy>(self, mut f: impl FnMut(usize) -> X) -> Few<X> {
        let (n, first) = (self.nv(), f(0));
        let mut items = [first; MAX_NV];
        for k in 1..n {
            items[k] = f(k);
        }
        Few { items, n }
    }

    #[inline(always)]
    fn coordinates(self) -> &'static [usize] {
        with_joint!(self, joint => joint.coordinates())
    }

    #[inline(always)]
    fn pitch(self) -> f64 {
        match self {
            Self::Screw(pitch) => pitch.metres_per_radian(),
            _ => 0.0,
        }
    }

    fn measures(self, k: usize) -> Coordinate {
        with_joint!(self, joint => joint.measures(k))
    }

    #[inline(always)]
    fn turns_with_body(self) -> bool {
        with_joint!(self, joint => joint.turns_with_body())
    }

    #[inline(always)]
    fn transform<T: Scalar>(self, q: &[T]) -> Transform<T> {
        Self::transform(self, q)
    }

    #[inline(always)]
    fn compose<P: Scalar, T: Over<P>>(
        self,
        X_PJ: &Transform<P>,
        q: &[T],
        sin_cos: impl FnOnce() -> (T, T),
    ) -> Transform<T> {
        self.compose_turned(X_PJ, q, sin_cos)
    }

    fn integrate<T: Scalar>(self, q: &[T], dv: &[T], out: &mut [T]) {
        Self::integrate(self, q, dv, out);
    }

    fn difference<T: Scalar>(self, q0: &[T], q1: &[T], out: &mut [T]) {
        Self::difference(self, q0, q1, out);
    }

    fn advance<D: Scalar, T: Over<D>>(
        self,
        center: &Vector3<T>,
        q: &[T],
        dt: D,
        next_q: &mut [T],
        next_v: &mut [T],
    ) {
        self.move_on(center, q, dt, next_q, next_v);
    }

    fn neutral<T: Scalar>(self, out: &mut [T]) {
        Self::neutral(self, out);
    }

    fn random<R: Rng + ?Sized>(self, rng: &mut R, out: &mut [f64]) {
        Self::random(self, rng, out);
    }
}
