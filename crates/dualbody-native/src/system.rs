//! A native simulator as a system of trajectory optimisation.

use std::any::TypeId;

use dualbody::Scalar;
use dualbody::linearize::Linearization;
use dualbody::trajopt::{Robot, Scratch, System};

use crate::numbers::Numbers;
use crate::simulator::NativeSimulator;

/// Steps and Jacobians on `f64` are compiled; functions over dual numbers are the library's own.
impl System for NativeSimulator {
    dualbody::forward_system!(
        own: nx, ndx, ndq, nu, time_step, robot, is_vector_space, integrate, difference, rate, chart_rate, vjp,
        linearize_rate
    );

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

    fn linearize(&self, x: &[f64], u: &[f64], scratch: &mut Scratch, out: &mut Linearization) {
        let numbers = scratch.get(|| Numbers::new(&self.own, &self.functions));
        numbers.set(x.iter().chain(u).copied());
        if !numbers.linearize(&self.functions, out) {
            System::linearize(&self.own, x, u, scratch, out);
        }
    }

    fn prepare(&self, scratch: &mut Scratch) {
        System::prepare(&self.own, scratch);
        scratch.get(|| Numbers::new(&self.own, &self.functions));
    }
}

impl Robot for NativeSimulator {}
