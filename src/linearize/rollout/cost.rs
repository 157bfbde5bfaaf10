//! Costs of rollouts and their gradients.

use crate::autodiff::{CHUNK, seed};
use crate::model::Model;
use crate::scalar::{Dual, Scalar};
use crate::sim::{Simulator, State};

/// A cost of a trajectory, J = Σₖ lₖ(xₖ, uₖ) + l(xₙ), over any scalar. Both parts are zero by default.
///
/// By default gradients come from dual numbers, [`CHUNK`] directions at a time, which costs (number of state and input coordinates) / [`CHUNK`]
/// evaluations. For a robot with many joints this can cost more than its steps: implement [`stage_slopes`](Self::stage_slopes) then.
///
/// # Examples
/// ```
/// use dualbody::{Scalar, State, linearize::RolloutCost};
///
/// /// Effort, and the distance of the first joint from a place at the end.
/// struct Reach(f64);
/// impl RolloutCost for Reach {
///     fn stage<T: Scalar>(&self, _: usize, _: &State<T>, u: &[T]) -> T {
///         u.iter().fold(T::zero(), |sum, &u| sum + u * u * 1e-3)
///     }
///     fn end<T: Scalar>(&self, last: &State<T>) -> T {
///         (last.q[0] - self.0) * (last.q[0] - self.0)
///     }
/// }
/// assert_eq!(Reach(1.0).end(&State::new(&[3.0], &[0.0])), 4.0);
/// ```
pub trait RolloutCost: Sized {
    /// The cost lₖ of the step with this index from a state, under an input.
    fn stage<T: Scalar>(&self, step: usize, state: &State<T>, u: &[T]) -> T {
        let _ = (step, state, u);
        T::zero()
    }

    /// The cost l of the last state.
    fn end<T: Scalar>(&self, state: &State<T>) -> T {
        let _ = state;
        T::zero()
    }

    /// Adds the gradient of lₖ to `out` and returns its value. The default uses dual numbers.
    fn stage_slopes(
        &self,
        at: &StagePoint<'_>,
        scratch: &mut CostScratch,
        out: &mut CostSlopes<'_>,
    ) -> f64 {
        scratch.add_slopes(at, out, |state, u| self.stage(at.step, state, u))
    }
}

/// One step of a rollout: arguments of a stage cost.
#[derive(Clone, Copy, Debug)]
pub struct StagePoint<'a> {
    /// The simulator that takes it.
    pub simulator: &'a Simulator,
    /// Its index, from 0.
    pub step: usize,
    /// The state before it.
    pub state: &'a State,
    /// The input, length `nu`.
    pub u: &'a [f64],
}

/// Accumulated gradient of a stage cost.
#[derive(Debug)]
pub struct CostSlopes<'a> {
    /// In the state, along its tangent (δq, δv, and the contact state where there is one), length [`Simulator::n_tangent`].
    pub state: &'a mut [f64],
    /// In the input, length `nu`.
    pub input: &'a mut [f64],
}

/// Working memory of [`RolloutCost::stage_slopes`].
#[derive(Clone, Debug)]
pub struct CostScratch(SeededState<f64>);

impl CostScratch {
    /// Makes memory for a simulator.
    pub fn new(simulator: &Simulator) -> Self {
        Self(SeededState::new(simulator))
    }

    /// Adds the gradient of a function of a step's state and input by dual numbers. Returns its value.
    fn add_slopes(
        &mut self,
        at: &StagePoint<'_>,
        out: &mut CostSlopes<'_>,
        f: impl Fn(&State<Dual<f64, CHUNK>>, &[Dual<f64, CHUNK>]) -> Dual<f64, CHUNK>,
    ) -> f64 {
        let zeros = std::iter::repeat_n(&0.0, at.simulator.model().nv());
        let numbers = zeros.chain(&at.state.v).chain(&at.state.contact);
        self.0.set(at.state, numbers.chain(at.u).copied());
        let (mut value, model) = (0.0, at.simulator.model());
        let n = out.state.len() + out.input.len();
        self.0.each(model, n, |state, u, first| {
            let x = f(state, u);
            let all = out.state.iter_mut().chain(out.input.iter_mut());
            let own = all.skip(first).zip(x.eps);
            own.for_each(|(out, slope)| *out += slope);
            value = x.re;
        });
        value
    }
}

/// State and input over dual numbers, seeded in some directions at a time.
#[derive(Clone, Debug)]
pub(super) struct SeededState<T: Scalar> {
    start: Vec<Dual<T, CHUNK>>,
    tangent: Vec<Dual<T, CHUNK>>,
    state: State<Dual<T, CHUNK>>,
    u: Vec<Dual<T, CHUNK>>,
}

impl<T: Scalar> SeededState<T> {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let zeros = |n: usize| vec![Dual::from(0.0); n];
        Self {
            start: zeros(simulator.model().nq()),
            tangent: zeros(simulator.model().nv()),
            state: simulator.neutral_state(),
            u: zeros(simulator.nu()),
        }
    }

    /// Takes the configuration of a state, and the values of (δq, v, contact state, u).
    pub(super) fn set(&mut self, state: &State, values: impl Iterator<Item = T>) {
        let start = self.start.iter_mut().zip(&state.q);
        start.for_each(|(out, &q)| *out = q.into());
        let numbers = self.numbers().zip(values);
        numbers.for_each(|(out, x)| *out = Dual::constant_of(x));
    }

    /// Hands over state and input with unit derivatives in some of `n` directions at a time, at least once, with the first of each.
    pub(super) fn each(
        &mut self,
        model: &Model,
        n: usize,
        mut f: impl FnMut(&State<Dual<T, CHUNK>>, &[Dual<T, CHUNK>], usize),
    ) {
        for first in (0..n.max(1)).step_by(CHUNK) {
            let seeded = first..first + CHUNK;
            seed(self.numbers(), &seeded, T::one());
            // Once more after the last direction of it, for a configuration without derivatives.
            if first < self.tangent.len() + CHUNK {
                let q = self.state.q.as_mut_slice();
                model.integrate_into(&self.start, &self.tangent, q);
            }
            f(&self.state, &self.u, first);
            seed(self.numbers(), &seeded, T::zero());
        }
    }

    /// All numbers along which a state and an input move.
    fn numbers(&mut self) -> impl Iterator<Item = &mut Dual<T, CHUNK>> {
        (self.tangent.iter_mut())
            .chain(self.state.v.iter_mut())
            .chain(self.state.contact.iter_mut())
            .chain(self.u.iter_mut())
    }
}

/// The costs of a rollout, whatever their type.
pub(super) trait Costs {
    /// Adds the gradient of the cost of a step. Returns its value.
    fn stage(&mut self, at: &StagePoint<'_>, out: &mut CostSlopes<'_>) -> f64;

    /// Adds the gradient of the cost of the last state. Returns its value.
    fn end(&mut self, simulator: &Simulator, state: &State, out: &mut [f64]) -> f64;
}

/// A cost with working memory.
pub(super) struct Stages<'a, C> {
    cost: &'a C,
    scratch: CostScratch,
}

impl<'a, C: RolloutCost> Stages<'a, C> {
    pub(super) fn new(cost: &'a C, simulator: &Simulator) -> Self {
        Self {
            cost,
            scratch: CostScratch::new(simulator),
        }
    }
}

impl<C: RolloutCost> Costs for Stages<'_, C> {
    fn stage(&mut self, at: &StagePoint<'_>, out: &mut CostSlopes<'_>) -> f64 {
        self.cost.stage_slopes(at, &mut self.scratch, out)
    }

    fn end(&mut self, simulator: &Simulator, state: &State, out: &mut [f64]) -> f64 {
        let at = StagePoint {
            simulator,
            step: 0,
            state,
            u: &[],
        };
        let mut slopes = CostSlopes {
            state: out,
            input: &mut [],
        };
        let cost = self.cost;
        (self.scratch).add_slopes(&at, &mut slopes, |state, _| cost.end(state))
    }
}
