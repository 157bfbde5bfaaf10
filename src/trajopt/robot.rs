//! Robots as systems: x = (q, v).

use nalgebra::DVector;

use super::dynamics::{Dynamics, Stepper};
use crate::linearize::{Linearization, LinearizeScratch};
use crate::model::Model;
use crate::scalar::Scalar;
use crate::sim::{Simulator, State, StepScratch};

/// A system whose state is that of a robot, x = (q, v, m) with the state of contact m: what the costs of robots are about.
///
/// A user who puts something around a [`Simulator`] (another actuation, a delay of its own) implements this to use them.
pub trait Robot: Dynamics {
    /// The robot.
    fn model(&self) -> &Model;

    /// x = (q, v, m) of a state. Allocates.
    fn pack(&self, state: &State) -> DVector<f64> {
        DVector::from_iterator(state.len(), state.numbers().copied())
    }

    /// The state of x. Allocates.
    ///
    /// # Panics
    /// If `x` has not the length `nx`.
    fn unpack(&self, x: &[f64]) -> State {
        assert_eq!(x.len(), self.nx(), "x is (q, v, m)");
        let model = self.model();
        let (q, rest) = x.split_at(model.nq());
        let (v, contact) = rest.split_at(model.nv());
        State::new(q, v).with_contact(DVector::from_column_slice(contact))
    }
}

impl Robot for Simulator {
    fn model(&self) -> &Model {
        Self::model(self)
    }
}

impl Dynamics for Simulator {
    fn nx(&self) -> usize {
        self.model().nq() + self.model().nv() + self.n_contact()
    }

    fn ndx(&self) -> usize {
        self.n_tangent()
    }

    fn ndq(&self) -> usize {
        self.model().nv()
    }

    fn nu(&self) -> usize {
        Self::nu(self)
    }

    fn time_step(&self) -> f64 {
        Self::time_step(self)
    }

    fn step<T: Scalar>(&self, x: &[T], u: &[T], next: &mut [T]) {
        let mut state = self.neutral_state();
        state.copy_from_slice(x);
        Self::step(self, &state, u).copy_to_slice(next);
    }

    fn integrate<T: Scalar>(&self, x: &[T], dx: &[T], out: &mut [T]) {
        let (nq, nv) = (self.model().nq(), self.model().nv());
        self.model()
            .integrate_into(&x[..nq], &dx[..nv], &mut out[..nq]);
        for ((out, &x), &dx) in out[nq..].iter_mut().zip(&x[nq..]).zip(&dx[nv..]) {
            *out = x + dx;
        }
    }

    fn difference<T: Scalar>(&self, x0: &[T], x1: &[T], dx: &mut [T]) {
        let (nq, nv) = (self.model().nq(), self.model().nv());
        self.model()
            .difference_into(&x0[..nq], &x1[..nq], &mut dx[..nv]);
        for ((dx, &x0), &x1) in dx[nv..].iter_mut().zip(&x0[nq..]).zip(&x1[nq..]) {
            *dx = x1 - x0;
        }
    }

    fn is_vector_space(&self) -> bool {
        let mut joints = self.model().independent().map(|body| body.joint);
        joints.all(|joint| joint.nv() <= 1)
    }

    fn stepper(&self) -> Box<dyn Stepper<Self>> {
        let state: State = self.neutral_state();
        Box::new(SimulatorStepper {
            step: StepScratch::new(self),
            linearize: LinearizeScratch::new(self),
            next: state.clone(),
            state,
        })
    }
}

/// Steps by the simulator, their Jacobians along the tree.
struct SimulatorStepper {
    step: StepScratch<f64>,
    linearize: LinearizeScratch,
    state: State,
    next: State,
}

impl Stepper<Simulator> for SimulatorStepper {
    fn step(&mut self, simulator: &Simulator, x: &[f64], u: &[f64], next: &mut [f64]) {
        self.state.copy_from_slice(x);
        simulator.step_into(&self.state, u, &mut self.step, &mut self.next);
        self.next.copy_to_slice(next);
    }

    fn linearize(&mut self, simulator: &Simulator, x: &[f64], u: &[f64], out: &mut Linearization) {
        self.state.copy_from_slice(x);
        simulator.linearize_into(&self.state, u, &mut self.linearize, out);
    }
}
