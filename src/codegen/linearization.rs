//! The Jacobians of the step as a graph.

use nalgebra::DVector;

use super::along_tree::{Acceleration, Number};
use super::origin::origin;
use super::ports::state_and_input;
use crate::autodiff::CHUNK;
use crate::scalar::traced::{Graph, Port, trace};
use crate::scalar::{Over, Scalar, Traced};
use crate::sim::{Simulator, State, StepScratch};

/// Traces the Jacobians of the step, δx⁺ = A δx + B δu in tangent coordinates: inputs as those of [`step`](super::step()), outputs `A`
/// and `B`, those of [`Simulator::linearize`].
///
/// Where all forces are along joints, a step of semi-implicit Euler is differentiated along the tree. Otherwise dual
/// numbers go along with the step, some directions at a time, which takes several times as many operations; through the
/// solver of contact and constraints they go in its last step alone.
///
/// # Panics
/// If the step decides on values, with the place: see [what can be traced](crate::scalar::traced).
#[inline]
pub fn linearization(simulator: &Simulator) -> Graph {
    let (n, nu) = (simulator.n_tangent(), simulator.nu());
    let graph = trace(|t| {
        let (state, u) = state_and_input(t, simulator);
        let mut columns = Vec::with_capacity(n * (n + nu));
        let mut way = match Acceleration::of(simulator, &state, &u) {
            Some(found) => Way::AlongTree(Box::new(found)),
            None => Way::Dense(Box::new(StepScratch::new(simulator))),
        };
        for first in (0..n + nu).step_by(CHUNK) {
            let directions = Directions {
                simulator,
                state: &state,
                u: &u,
                first,
            };
            let changes = match &mut way {
                Way::AlongTree(found) => directions.advance(&found.along(first)),
                Way::Dense(scratch) => directions.step(scratch),
            };
            for direction in 0..CHUNK.min(n + nu - first) {
                columns.extend(changes.iter().map(|x| x.eps[direction]));
            }
        }
        let (a, b) = columns.split_at(n * n);
        t.output(Port::matrix("A", n, n), a);
        t.output(Port::matrix("B", n, nu), b);
    });
    graph.with_origin(origin(simulator.model()))
}

/// Way to the derivatives of a step.
enum Way {
    AlongTree(Box<Acceleration>),
    Dense(Box<StepScratch<Number>>),
}

/// Some directions in which a step is differentiated, from `first` on, of state and input together.
struct Directions<'a, P> {
    simulator: &'a Simulator<P>,
    state: &'a State<Traced>,
    u: &'a [Traced],
    first: usize,
}

impl<P: Scalar> Directions<'_, P>
where
    Number: Over<P>,
{
    /// δ of the k-th number.
    fn along(&self, k: usize) -> Number {
        match k.checked_sub(self.first) {
            Some(direction) if direction < CHUNK => Number::variable(Traced::from(0.0), direction),
            _ => Number::constant_of(Traced::from(0.0)),
        }
    }

    /// x ⊕ δx
    fn moved(&self) -> State<Number> {
        let model = self.simulator.model();
        let lift = |x: &DVector<Traced>| x.map(Number::constant_of);
        let dq: Vec<Number> = (0..model.nv()).map(|k| self.along(k)).collect();
        let mut out = State {
            q: model.integrate(lift(&self.state.q).as_slice(), &dq),
            v: lift(&self.state.v),
            contact: lift(&self.state.contact),
        };
        let rest = out.v.iter_mut().chain(&mut out.contact);
        for (k, x) in rest.enumerate() {
            *x += self.along(model.nv() + k);
        }
        out
    }

    /// δx⁺ of a step, in tangent coordinates.
    fn step(&self, scratch: &mut StepScratch<Number>) -> Vec<Number> {
        let (n, moved) = (self.simulator.n_tangent(), self.moved());
        let moved_u = |(k, &u): (usize, &Traced)| self.along(n + k) + Number::constant_of(u);
        let u: Vec<Number> = self.u.iter().enumerate().map(moved_u).collect();
        let mut next = moved.clone();
        self.simulator.step_into(&moved, &u, scratch, &mut next);
        self.change(&next)
    }

    /// δx⁺ of a step with a given acceleration.
    fn advance(&self, a: &[Number]) -> Vec<Number> {
        let (moved, dt) = (self.moved(), self.simulator.time_step());
        let mut next = moved.clone();
        let (q, v) = (moved.q.as_slice(), moved.v.as_slice());
        let (next_q, next_v) = (next.q.as_mut_slice(), next.v.as_mut_slice());
        let model = self.simulator.model();
        model.advance_into(q, v, a, dt, next_q, next_v);
        self.change(&next)
    }

    /// The difference of a state from its value.
    fn change(&self, next: &State<Number>) -> Vec<Number> {
        let mut value = next.clone();
        let numbers = value.numbers_mut();
        numbers.for_each(|x| *x = Number::constant_of(x.re));
        let change = next.deviation(self.simulator.model(), &value);
        change.as_slice().to_vec()
    }
}
