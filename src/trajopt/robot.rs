//! Robots as systems: x = (q, v).

use nalgebra::DVector;

use super::dynamics::{Dynamics, Stepper};
use crate::linearize::{Linearization, LinearizeScratch};
use crate::model::Model;
use crate::scalar::Scalar;
use crate::sim::{Simulator, State, StepScratch};

/// A system whose state is that of a robot, x = (q, v): what the costs of robots are about.
///
/// A user who puts something around a [`Simulator`] (another actuation, a delay of its own) implements this to use them.
pub trait Robot: Dynamics {
    /// The robot.
    fn model(&self) -> &Model;

    /// x = (q, v) of a state. Allocates.
    fn pack(&self, state: &State) -> DVector<f64> {
        let both = state.q.iter().chain(&state.v).copied();
        DVector::from_iterator(state.q.len() + state.v.len(), both)
    }

    /// The state of x. Allocates.
    ///
    /// # Panics
    /// If `x` has not the length nq + nv.
    fn unpack(&self, x: &[f64]) -> State {
        let model = self.model();
        assert_eq!(x.len(), model.nq() + model.nv(), "x is (q, v)");
        let (q, v) = x.split_at(model.nq());
        State::new(q, v)
    }
}

impl Robot for Simulator {
    fn model(&self) -> &Model {
        Self::model(self)
    }
}

impl Dynamics for Simulator {
    fn nx(&self) -> usize {
        self.model().nq() + self.model().nv()
    }

    fn ndx(&self) -> usize {
        2 * self.model().nv()
    }

    fn nu(&self) -> usize {
        Self::nu(self)
    }

    fn time_step(&self) -> f64 {
        Self::time_step(self)
    }

    fn step<T: Scalar>(&self, x: &[T], u: &[T], next: &mut [T]) {
        let (q, v) = x.split_at(self.model().nq());
        let end = Self::step(self, &State::new(q, v), u);
        write_state(&end, next);
    }

    fn integrate<T: Scalar>(&self, x: &[T], dx: &[T], out: &mut [T]) {
        let (nq, nv) = (self.model().nq(), self.model().nv());
        self.model()
            .integrate_into(&x[..nq], &dx[..nv], &mut out[..nq]);
        for ((out, &v), &dv) in out[nq..].iter_mut().zip(&x[nq..]).zip(&dx[nv..]) {
            *out = v + dv;
        }
    }

    fn difference<T: Scalar>(&self, x0: &[T], x1: &[T], dx: &mut [T]) {
        let (nq, nv) = (self.model().nq(), self.model().nv());
        self.model()
            .difference_into(&x0[..nq], &x1[..nq], &mut dx[..nv]);
        for ((dv, &v0), &v1) in dx[nv..].iter_mut().zip(&x0[nq..]).zip(&x1[nq..]) {
            *dv = v1 - v0;
        }
    }

    fn is_vector_space(&self) -> bool {
        let mut joints = self.model().independent().map(|body| body.joint);
        joints.all(|joint| joint.nv() <= 1)
    }

    fn stepper(&self) -> Box<dyn Stepper<Self>> {
        let state = State::neutral(self.model());
        Box::new(SimulatorStepper {
            step: StepScratch::new(self.model()),
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
        read_state(x, &mut self.state);
        simulator.step_into(&self.state, u, &mut self.step, &mut self.next);
        write_state(&self.next, next);
    }

    fn linearize(&mut self, simulator: &Simulator, x: &[f64], u: &[f64], out: &mut Linearization) {
        read_state(x, &mut self.state);
        simulator.linearize_into(&self.state, u, &mut self.linearize, out);
    }
}

fn read_state(x: &[f64], state: &mut State) {
    let (q, v) = x.split_at(state.q.len());
    state.q.copy_from_slice(q);
    state.v.copy_from_slice(v);
}

fn write_state<T: Scalar>(state: &State<T>, x: &mut [T]) {
    let (q, v) = x.split_at_mut(state.q.len());
    q.copy_from_slice(state.q.as_slice());
    v.copy_from_slice(state.v.as_slice());
}
