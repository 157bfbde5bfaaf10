//! The activation of an input of a simulator: its place in the state, its signal, and their derivatives.

use std::ops::Range;

use super::{Activation, Arguments, MAX_ACTUATOR_STATES};
use crate::numbers::{Numbers, numbers};
use crate::scalar::{CHUNK, Dual, Over, Scalar};
use crate::sim::state::State;

/// An activation with the input that it belongs to.
#[derive(Clone, Debug)]
pub(crate) struct PlacedActivation<P> {
    /// Name of the input.
    pub(crate) name: String,
    pub(crate) input: usize,
    /// The first of its numbers of state.
    pub(crate) first: usize,
    /// The coordinate of its joint, where that has one.
    pub(crate) joint: Option<JointCoordinate>,
    pub(crate) own: Activation<P>,
}

numbers! { struct PlacedActivation {
    name: kept(), input: kept(), first: kept(), joint: kept(), own: part(Activation),
} }

/// Places of a coordinate in q and in v.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct JointCoordinate {
    pub(crate) q: usize,
    pub(crate) v: usize,
}

/// A number that signal and next state of an activation depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Variable {
    /// The input after its delay.
    Input,
    /// A number of state after the delay.
    State(usize),
    Position,
    Velocity,
    Parameter(usize),
    TimeStep,
}

impl<P: Scalar> PlacedActivation<P> {
    /// Places of its numbers among all of the state.
    pub(crate) fn range(&self) -> Range<usize> {
        self.first..self.first + self.own.states()
    }

    /// Its numbers among all of the state.
    pub(crate) fn states<'a, T>(&self, all: &'a [T]) -> &'a [T] {
        &all[self.range()]
    }

    /// Input after the delay, and the motion of the joint.
    fn arguments<T: Scalar>(&self, state: &State<T>, w: &[T], u: &[T]) -> Arguments<T> {
        let arrived = match self.own.delay_steps() {
            0 => u[self.input],
            _ => w[0],
        };
        let [q, v] = match self.joint {
            Some(joint) => [state.q[joint.q], state.v[joint.v]],
            None => [T::zero(); 2],
        };
        Arguments { u: arrived, q, v }
    }

    /// The signal over a step, and the next state.
    pub(crate) fn step<T: Over<P>>(
        &self,
        dt: P,
        state: &State<T>,
        w: &[T],
        u: &[T],
        next: &mut [T],
    ) -> T {
        let at = self.arguments(state, w, u);
        let (waiting, next) = next.split_at_mut(self.own.delay_steps());
        let (late, w) = w.split_at(waiting.len());
        if let [before @ .., last] = waiting {
            before.copy_from_slice(&late[1..]);
            *last = u[self.input];
        }
        self.own.respond(&at, dt, w, next)
    }
}

/// A number with its derivatives in some of the variables.
type Chunk<T> = Dual<T, CHUNK>;

impl PlacedActivation<f64> {
    /// Hands the derivatives of the signal, which is the first output, and of each entry of the next state after the delay, to `each`, variable by variable.
    ///
    /// * `with_numbers` – whether those in parameters and the time step are wanted
    pub(crate) fn each_derivative<T: Scalar>(
        &self,
        dt: f64,
        state: &State<T>,
        u: &[T],
        with_numbers: bool,
        mut each: impl FnMut(Variable, usize, T),
    ) {
        let w = self.states(state.activation.as_slice());
        let at = self.arguments(state, w, u);
        let w = &w[self.own.delay_steps()..];
        let mut variables = Variables::new(self, w.len());
        if with_numbers {
            variables.parameters = self.own.to_vec().len();
            variables.has_time_step = true;
        }
        for first in (0..variables.len()).step_by(CHUNK) {
            let seed = |x: T, k: usize| seeded(x, k, first);
            let [q, v] = variables.motion(w.len());
            let at = Arguments {
                u: seed(at.u, 0),
                q: seed(at.q, q),
                v: seed(at.v, v),
            };
            let mut lifted = [Chunk::from(0.0); MAX_ACTUATOR_STATES];
            for (k, (out, &w)) in lifted.iter_mut().zip(w).enumerate() {
                *out = seed(w, 1 + k);
            }
            let mut next = [Chunk::from(0.0); MAX_ACTUATOR_STATES];
            let (w, next) = (&lifted[..w.len()], &mut next[..w.len()]);
            let signal = match with_numbers {
                false => self.own.respond(&at, dt, w, next),
                true => {
                    let numbers = variables.first_parameter();
                    let mut own: Activation<Chunk<T>> = self.own.lift();
                    for_each_number(&mut own, numbers, first);
                    let dt = seed(T::constant(dt), variables.len() - 1);
                    own.respond(&at, dt, w, next)
                }
            };
            let outputs = std::iter::once(&signal).chain(&*next).enumerate();
            for (output, y) in outputs {
                for (k, &slope) in (first..variables.len()).zip(&y.eps) {
                    each(variables.at(k), output, slope);
                }
            }
        }
    }
}

/// A number that is a variable if it is one of the chunk from `first` on.
fn seeded<T: Scalar>(x: T, k: usize, first: usize) -> Chunk<T> {
    match k.checked_sub(first) {
        Some(direction) if direction < CHUNK => Dual::variable(x, direction),
        _ => Dual::constant_of(x),
    }
}

/// Makes those parameters variables that are in the chunk from `first` on.
fn for_each_number<T: Scalar>(own: &mut Activation<Chunk<T>>, mut k: usize, first: usize) {
    own.each_number(&mut |_, x: &mut Chunk<T>| {
        *x = seeded(x.re, k, first);
        k += 1;
    });
}

/// The variables in their order: input, state, position and velocity where they count, parameters, time step.
#[derive(Clone, Copy)]
struct Variables {
    states: usize,
    has_motion: bool,
    parameters: usize,
    has_time_step: bool,
}

impl Variables {
    fn new(of: &PlacedActivation<f64>, states: usize) -> Self {
        Self {
            states,
            has_motion: of.own.needs_motion(),
            parameters: 0,
            has_time_step: false,
        }
    }

    fn first_parameter(self) -> usize {
        1 + self.states + 2 * usize::from(self.has_motion)
    }

    fn len(self) -> usize {
        self.first_parameter() + self.parameters + usize::from(self.has_time_step)
    }

    /// Places of position and velocity; past the end where they do not count.
    fn motion(self, states: usize) -> [usize; 2] {
        match self.has_motion {
            true => [1 + states, 2 + states],
            false => [usize::MAX; 2],
        }
    }

    fn at(self, k: usize) -> Variable {
        let motion = 1 + self.states;
        let parameter = self.first_parameter();
        match k {
            0 => Variable::Input,
            k if k < motion => Variable::State(k - 1),
            k if k < parameter && k == motion => Variable::Position,
            k if k < parameter => Variable::Velocity,
            k if k < parameter + self.parameters => Variable::Parameter(k - parameter),
            _ => Variable::TimeStep,
        }
    }
}
