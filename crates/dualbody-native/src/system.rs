//! A native simulator as a system of trajectory optimisation.

use std::any::TypeId;

use dualbody::linearize::Linearization;
use dualbody::trajopt::{Robot, Scratch, System};
use dualbody::{Model, Scalar};

use crate::simulator::{NativeSimulator, write_jacobians};

/// Inputs and outputs of the compiled functions.
struct Numbers {
    inputs: Vec<f64>,
    next: Vec<f64>,
    jacobians: Vec<f64>,
}

impl Numbers {
    fn new(native: &NativeSimulator) -> Self {
        let (nx, nu, ndx) = (native.nx(), native.nu(), native.ndx());
        Self {
            inputs: vec![0.0; nx + nu],
            next: vec![0.0; nx],
            jacobians: vec![0.0; ndx * (ndx + nu)],
        }
    }
}

/// Steps and Jacobians on `f64` are compiled; what is over dual numbers is the library's own.
impl System for NativeSimulator {
    fn nx(&self) -> usize {
        self.own.nx()
    }

    fn ndx(&self) -> usize {
        self.own.ndx()
    }

    fn ndq(&self) -> usize {
        self.own.ndq()
    }

    fn nu(&self) -> usize {
        self.own.nu()
    }

    fn time_step(&self) -> f64 {
        self.own.time_step()
    }

    fn step<T: Scalar>(&self, x: &[T], u: &[T], scratch: &mut Scratch, next: &mut [T]) {
        if let Some(step) = &self.step
            && TypeId::of::<T>() == TypeId::of::<f64>()
        {
            let numbers = scratch.get(|| Numbers::new(self));
            for (out, x) in numbers.inputs.iter_mut().zip(x.iter().chain(u)) {
                *out = x.value(0);
            }
            if step.holds(&numbers.inputs, &mut numbers.next) {
                for (out, &x) in next.iter_mut().zip(&numbers.next) {
                    *out = x.into();
                }
                return;
            }
        }
        System::step(&self.own, x, u, scratch, next);
    }

    fn integrate<T: Scalar>(&self, x: &[T], dx: &[T], out: &mut [T]) {
        self.own.integrate(x, dx, out);
    }

    fn difference<T: Scalar>(&self, x0: &[T], x1: &[T], dx: &mut [T]) {
        self.own.difference(x0, x1, dx);
    }

    fn is_vector_space(&self) -> bool {
        self.own.is_vector_space()
    }

    fn rate<T: Scalar>(&self, x: &[T], u: &[T], scratch: &mut Scratch, rate: &mut [T]) {
        self.own.rate(x, u, scratch, rate);
    }

    fn chart_rate<T: Scalar>(&self, xi: &[T], rate: &[T], out: &mut [T]) {
        self.own.chart_rate(xi, rate, out);
    }

    fn linearize(&self, x: &[f64], u: &[f64], scratch: &mut Scratch, out: &mut Linearization) {
        if let Some(jacobians) = &self.jacobians {
            let numbers = scratch.get(|| Numbers::new(self));
            let (of_state, of_input) = numbers.inputs.split_at_mut(x.len());
            of_state.copy_from_slice(x);
            of_input.copy_from_slice(u);
            if jacobians.holds(&numbers.inputs, &mut numbers.jacobians) {
                return write_jacobians(&numbers.jacobians, out);
            }
        }
        System::linearize(&self.own, x, u, scratch, out);
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
        System::vjp(&self.own, x, u, lambda, scratch, dx, du);
    }

    fn linearize_rate(&self, x: &[f64], u: &[f64], scratch: &mut Scratch, out: &mut Linearization) {
        System::linearize_rate(&self.own, x, u, scratch, out);
    }

    fn prepare(&self, scratch: &mut Scratch) {
        System::prepare(&self.own, scratch);
        scratch.get(|| Numbers::new(self));
    }
}

impl Robot for NativeSimulator {
    fn model(&self) -> &Model {
        self.own.model()
    }
}
