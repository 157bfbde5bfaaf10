//! A system behind a pointer, on the scalars that solvers use: so that solvers are compiled once, whatever the system.

use nalgebra::DMatrix;
use num_dual::HyperDual64;

use super::scratch::Scratch;
use super::system::System;
use crate::autodiff::{CHUNK, Dual};
use crate::linearize::Linearization;
use crate::scalar::Scalar;

/// The sizes of a system; see [`System`] for each.
pub trait Sizes: Sync {
    fn nx(&self) -> usize;
    fn ndx(&self) -> usize;
    fn ndq(&self) -> usize;
    fn nu(&self) -> usize;
    fn time_step(&self) -> f64;
    fn is_vector_space(&self) -> bool;
}

/// A system on one scalar; see [`System`] for each function.
pub trait On<T>: Sizes {
    fn step(&self, x: &[T], u: &[T], scratch: &mut Scratch, next: &mut [T]);
    fn integrate(&self, x: &[T], dx: &[T], out: &mut [T]);
    fn difference(&self, x0: &[T], x1: &[T], dx: &mut [T]);
    fn rate(&self, x: &[T], u: &[T], scratch: &mut Scratch, rate: &mut [T]);
    fn chart_rate(&self, xi: &[T], rate: &[T], out: &mut [T]);
}

/// A system on plain numbers, on dual numbers for first and on hyper-dual ones for second derivatives, with its
/// Jacobians.
pub trait AnySystem: On<f64> + On<Dual<f64, CHUNK>> + On<HyperDual64> {
    fn linearize(&self, x: &[f64], u: &[f64], scratch: &mut Scratch, out: &mut Linearization);
    fn linearize_rate(&self, x: &[f64], u: &[f64], scratch: &mut Scratch, out: &mut Linearization);
    fn prepare(&self, scratch: &mut Scratch);
}

impl<S: System> Sizes for S {
    fn nx(&self) -> usize {
        System::nx(self)
    }

    fn ndx(&self) -> usize {
        System::ndx(self)
    }

    fn ndq(&self) -> usize {
        System::ndq(self)
    }

    fn nu(&self) -> usize {
        System::nu(self)
    }

    fn time_step(&self) -> f64 {
        System::time_step(self)
    }

    fn is_vector_space(&self) -> bool {
        System::is_vector_space(self)
    }
}

impl<T: Scalar, S: System> On<T> for S {
    fn step(&self, x: &[T], u: &[T], scratch: &mut Scratch, next: &mut [T]) {
        System::step(self, x, u, scratch, next);
    }

    fn integrate(&self, x: &[T], dx: &[T], out: &mut [T]) {
        System::integrate(self, x, dx, out);
    }

    fn difference(&self, x0: &[T], x1: &[T], dx: &mut [T]) {
        System::difference(self, x0, x1, dx);
    }

    fn rate(&self, x: &[T], u: &[T], scratch: &mut Scratch, rate: &mut [T]) {
        System::rate(self, x, u, scratch, rate);
    }

    fn chart_rate(&self, xi: &[T], rate: &[T], out: &mut [T]) {
        System::chart_rate(self, xi, rate, out);
    }
}

impl<S: System> AnySystem for S {
    fn linearize(&self, x: &[f64], u: &[f64], scratch: &mut Scratch, out: &mut Linearization) {
        System::linearize(self, x, u, scratch, out);
    }

    fn linearize_rate(&self, x: &[f64], u: &[f64], scratch: &mut Scratch, out: &mut Linearization) {
        System::linearize_rate(self, x, u, scratch, out);
    }

    fn prepare(&self, scratch: &mut Scratch) {
        System::prepare(self, scratch);
    }
}

/// Jacobians of a step or a rate of the right size.
pub(super) fn zero_linearization(system: &dyn AnySystem) -> Linearization {
    let (ndx, nu) = (system.ndx(), system.nu());
    Linearization {
        a: DMatrix::zeros(ndx, ndx),
        b: DMatrix::zeros(ndx, nu),
    }
}
