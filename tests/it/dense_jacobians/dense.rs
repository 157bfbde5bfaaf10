//! Jacobians of any step as the step on dual numbers, some directions at a time: the reference for those of the library.

use dualbody::autodiff::{VectorFunction, jacobian};
use dualbody::linearize::Linearization;
use dualbody::{Cast, Scalar, Simulator, State};
use nalgebra::DVector;

/// The step as a function (δq, δv, δm, δu) ↦ (δq⁺, δv⁺, δm⁺) that maps zero to zero.
struct TangentStep<'a> {
    simulator: &'a Simulator,
    state: &'a State,
    u: &'a [f64],
    next: State,
}

impl VectorFunction for TangentStep<'_> {
    fn n_outputs(&self) -> usize {
        self.simulator.n_tangent()
    }

    fn eval<T: Scalar>(&self, dx: &[T], dy: &mut [T]) {
        let (model, nv) = (self.simulator.model(), self.simulator.model().nv());
        let (dq, rest) = dx.split_at(nv);
        let (dv, rest) = rest.split_at(nv);
        let (dm, du) = rest.split_at(self.simulator.n_contact());
        let start: State<T> = self.state.cast();
        let moved = |x: &DVector<T>, dx: &[T]| DVector::from_fn(x.len(), |i, _| x[i] + dx[i]);
        let state = State {
            q: model.integrate(start.q.as_slice(), dq),
            v: moved(&start.v, dv),
            contact: moved(&start.contact, dm),
            activation: start.activation.clone(),
            sleep: start.sleep.clone(),
        };
        let u: Vec<T> = self.u.iter().zip(du).map(|(&u, &du)| du + u).collect();
        let next = self.simulator.step(&state, &u);
        dy.copy_from_slice(next.deviation(model, &self.next.cast()).as_slice());
    }
}

/// The Jacobians of the step from a state.
pub(super) fn linearize(simulator: &Simulator, state: &State, u: &[f64]) -> Linearization {
    let n = simulator.n_tangent();
    let next = simulator.step(state, u);
    let step = TangentStep {
        simulator,
        state,
        u,
        next,
    };
    let all = jacobian(&step, &vec![0.0; n + u.len()]);
    Linearization {
        a: all.columns(0, n).into(),
        b: all.columns(n, u.len()).into(),
    }
}
