//! A native simulator as a system of trajectory optimisation.

use std::any::TypeId;

use dualbody::linearize::Linearization;
use dualbody::trajopt::{Robot, Scratch, System};
use dualbody::{Model, Scalar};

use crate::numbers::Numbers;
use crate::simulator::NativeSimulator;

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

    fn robot(&self) -> Option<&Model> {
        self.own.robot()
    }

    fn step<T: Scalar>(&self, x: &[T], u: &[T], scratch: &mut Scratch, next: &mut [T]) {
        if self.functions.step.is_some() && TypeId::of::<T>() == TypeId::of::<f64>() {
            let numbers = scratch.get(|| Numbers::new(&self.own, &self.functions));
            numbers.set(x.iter().chain(u).map(|x| x.value(0)));
            if let Some(own) = numbers.step(&self.functions) {
                next.iter_mut().zip(own).for_each(|(to, &x)| *to = x.into());
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
        let numbers = scratch.get(|| Numbers::new(&self.own, &self.functions));
        numbers.set(x.iter().chain(u).copied());
        if !numbers.linearize(&self.functions, out) {
            System::linearize(&self.own, x, u, scratch, out);
        }
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
        scratch.get(|| Numbers::new(&self.own, &self.functions));
    }
}

impl Robot for NativeSimulator {}
