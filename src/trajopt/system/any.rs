//! A system behind a pointer, on the scalars that solvers use: so that solvers are compiled once, whatever the system.

use num_dual::HyperDual64;

use super::System;
use crate::autodiff::{CHUNK, Dual};
use crate::linearize::Linearization;
use crate::scalar::Scalar;
use crate::trajopt::scratch::Scratch;

/// The sizes of a system; see [`System`] for each.
pub trait Sizes: Sync {
    fn nx(&self) -> usize;
    fn ndx(&self) -> usize;
    fn ndq(&self) -> usize;
    fn nu(&self) -> usize;
    fn time_step(&self) -> f64;
    fn is_vector_space(&self) -> bool;
}

/// The manifold of a system's states on one scalar; see [`System`] for each function.
pub trait On<T>: Sizes {
    fn integrate(&self, x: &[T], dx: &[T], out: &mut [T]);
    fn difference(&self, x0: &[T], x1: &[T], dx: &mut [T]);
    fn chart_rate(&self, xi: &[T], rate: &[T], out: &mut [T]);
}

/// A system on plain numbers with its derivatives, and its manifold on dual numbers too, for first derivatives of what stands on it, and on
/// hyper-dual ones for second ones. A system that gives derivatives of its own is not compiled on dual numbers here.
pub trait AnySystem: On<f64> + On<Dual<f64, CHUNK>> + On<HyperDual64> {
    fn step(&self, x: &[f64], u: &[f64], scratch: &mut Scratch, next: &mut [f64]);
    fn rate(&self, x: &[f64], u: &[f64], scratch: &mut Scratch, rate: &mut [f64]);
    fn linearize(&self, x: &[f64], u: &[f64], scratch: &mut Scratch, out: &mut Linearization);
    fn linearize_rate(&self, x: &[f64], u: &[f64], scratch: &mut Scratch, out: &mut Linearization);
    fn vjp(
        &self,
        x: &[f64],
        u: &[f64],
        lambda: &[f64],
        scratch: &mut Scratch,
        dx: &mut [f64],
        du: &mut [f64],
    );
    fn has_step_hessian(&self) -> bool;
    fn add_step_hessian(&self, x: &[f64], u: &[f64], lambda: &[f64], hessian: &mut [f64]);
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
    fn integrate(&self, x: &[T], dx: &[T], out: &mut [T]) {
        System::integrate(self, x, dx, out);
    }

    fn difference(&self, x0: &[T], x1: &[T], dx: &mut [T]) {
        System::difference(self, x0, x1, dx);
    }

    fn chart_rate(&self, xi: &[T], rate: &[T], out: &mut [T]) {
        System::chart_rate(self, xi, rate, out);
    }
}

impl<S: System> AnySystem for S {
    fn step(&self, x: &[f64], u: &[f64], scratch: &mut Scratch, next: &mut [f64]) {
        System::step(self, x, u, scratch, next);
    }

    fn rate(&self, x: &[f64], u: &[f64], scratch: &mut Scratch, rate: &mut [f64]) {
        System::rate(self, x, u, scratch, rate);
    }

    fn has_step_hessian(&self) -> bool {
        System::has_step_hessian(self)
    }

    fn add_step_hessian(&self, x: &[f64], u: &[f64], lambda: &[f64], hessian: &mut [f64]) {
        System::add_step_hessian(self, x, u, lambda, hessian);
    }

    fn linearize(&self, x: &[f64], u: &[f64], scratch: &mut Scratch, out: &mut Linearization) {
        System::linearize(self, x, u, scratch, out);
    }

    fn linearize_rate(&self, x: &[f64], u: &[f64], scratch: &mut Scratch, out: &mut Linearization) {
        System::linearize_rate(self, x, u, scratch, out);
    }

    fn vjp(
        &self,
        x: &[f64],
        u: &[f64],
        lambda: &[f64],
        scratch: &mut Scratch,
        dx: &mut [f64],
        du: &mut [f64],
    ) {
        System::vjp(self, x, u, lambda, scratch, dx, du);
    }

    fn prepare(&self, scratch: &mut Scratch) {
        System::prepare(self, scratch);
    }
}
