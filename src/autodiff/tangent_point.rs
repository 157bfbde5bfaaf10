//! A point of a manifold that moves along its tangent, seeded in some directions at a time.

use std::ops::Range;

use nalgebra::DMatrix;
use num_dual::HyperDual64;

use super::Dual;
use crate::scalar::Scalar;

/// (x ⊕ δ, u) as a function of z = (δ, u): x on a manifold, whatever its ⊕ is, and plain numbers u beside it.
#[derive(Clone, Debug)]
pub(crate) struct TangentPoint<S> {
    /// x, without derivatives.
    base: Vec<S>,
    /// x ⊕ δ.
    x: Vec<S>,
    /// (δ, u).
    z: Vec<S>,
    /// Length of δ.
    n_tangent: usize,
}

impl<S: Scalar> TangentPoint<S> {
    /// Memory for a manifold of `nx` numbers and `n_tangent` dimensions, with `nu` numbers beside it.
    pub(crate) fn new(nx: usize, n_tangent: usize, nu: usize) -> Self {
        Self {
            base: vec![S::zero(); nx],
            x: vec![S::zero(); nx],
            z: vec![S::zero(); n_tangent + nu],
            n_tangent,
        }
    }

    /// Takes x, with δ = 0, and u.
    pub(crate) fn set(&mut self, x: &[f64], u: &[f64]) {
        let zeros = std::iter::repeat_n(S::zero(), self.n_tangent);
        let u = u.iter().map(|&u| S::constant(u));
        self.set_to(x.iter().map(|&x| S::constant(x)), zeros.chain(u));
    }

    /// Takes x and z.
    pub(crate) fn set_to(
        &mut self,
        x: impl IntoIterator<Item = S>,
        z: impl IntoIterator<Item = S>,
    ) {
        self.base.iter_mut().zip(x).for_each(|(own, x)| *own = x);
        self.z.clear();
        self.z.extend(z);
    }

    /// (x ⊕ δ, u).
    pub(crate) fn moved(&mut self, mut integrate: impl FnMut(&[S], &[S], &mut [S])) -> [&[S]; 2] {
        let (delta, u) = self.z.split_at(self.n_tangent);
        integrate(&self.base, delta, &mut self.x);
        [&self.x, u]
    }
}

impl<T: Scalar, const N: usize> TangentPoint<Dual<T, N>> {
    /// Hands over (x ⊕ δ, u) with unit derivatives in `N` of the directions at a time, and which.
    ///
    /// * `integrate` – ⊕ of the manifold
    pub(crate) fn each(
        &mut self,
        directions: Range<usize>,
        mut integrate: impl FnMut(&[Dual<T, N>], &[Dual<T, N>], &mut [Dual<T, N>]),
        mut f: impl FnMut(&[Dual<T, N>], &[Dual<T, N>], Range<usize>),
    ) {
        let end = directions.end;
        for first in directions.step_by(N) {
            let seeded = first..end.min(first + N);
            seed(&mut self.z, &seeded, T::one());
            let [x, u] = self.moved(&mut integrate);
            f(x, u, seeded.clone());
            seed(&mut self.z, &seeded, T::zero());
        }
    }

    /// Fills `out` with the Jacobian of f(x ⊕ δ, u) in all directions, outputs × directions.
    ///
    /// * `y` – outputs of `f`
    pub(crate) fn jacobian_into(
        &mut self,
        integrate: impl FnMut(&[Dual<T, N>], &[Dual<T, N>], &mut [Dual<T, N>]),
        mut f: impl FnMut(&[Dual<T, N>], &[Dual<T, N>], &mut [Dual<T, N>]),
        y: &mut [Dual<T, N>],
        out: &mut DMatrix<T>,
    ) {
        self.each(0..self.z.len(), integrate, |x, u, seeded| {
            f(x, u, y);
            for (row, y) in y.iter().enumerate() {
                for (column, &eps) in seeded.clone().zip(&y.eps) {
                    out[(row, column)] = eps;
                }
            }
        });
    }
}

impl TangentPoint<HyperDual64> {
    /// Hands over (x ⊕ δ, u) with a unit derivative in one direction and in another one.
    #[inline]
    pub(crate) fn in_pair<R>(
        &mut self,
        [first, second]: [usize; 2],
        integrate: impl FnMut(&[HyperDual64], &[HyperDual64], &mut [HyperDual64]),
        f: impl FnOnce(&[HyperDual64], &[HyperDual64]) -> R,
    ) -> R {
        (self.z[first].eps1, self.z[second].eps2) = (1.0, 1.0);
        let [x, u] = self.moved(integrate);
        let out = f(x, u);
        (self.z[first].eps1, self.z[second].eps2) = (0.0, 0.0);
        out
    }
}

/// Gives those of some numbers this derivative, each in a direction of its own.
pub(crate) fn seed<'a, T: Scalar, const N: usize>(
    numbers: impl IntoIterator<Item = &'a mut Dual<T, N>>,
    seeded: &Range<usize>,
    derivative: T,
) {
    let numbers = numbers.into_iter().skip(seeded.start);
    for (k, x) in numbers.take(seeded.len()).enumerate() {
        x.eps[k] = derivative;
    }
}
