//! Costs of rollouts, and their slopes.

use nalgebra::DVector;

use crate::autodiff::CHUNK;
use crate::scalar::{Dual, Scalar};
use crate::sim::{Simulator, State};

/// A cost of a trajectory, J = Σₖ lₖ(xₖ, uₖ) + l(xₙ), over any scalar. Both parts are zero where they are not written.
///
/// Slopes come from dual numbers, some directions at a time, which costs as many evaluations as there are numbers of state and input, over
/// [`CHUNK`]. For a robot of many joints that can be more than its steps cost: write
/// [`stage_slopes`](Self::stage_slopes) then.
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

    /// Adds the slopes of lₖ to `out` and returns its value: by dual numbers, unless you know better.
    fn stage_slopes(
        &self,
        at: &StagePoint<'_>,
        scratch: &mut CostScratch,
        out: &mut CostSlopes<'_>,
    ) -> f64 {
        scratch.stage(self, at, out)
    }
}

/// A step of a rollout.
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

/// Sums of the slopes of a cost of a step.
#[derive(Debug)]
pub struct CostSlopes<'a> {
    /// In the state, along its tangent (δq, δv, and the state of contact where there is one), length [`Simulator::n_tangent`].
    pub state: &'a mut [f64],
    /// In the input, length `nu`.
    pub input: &'a mut [f64],
}

type Local = Dual<f64, CHUNK>;

/// Working memory of [`RolloutCost::stage_slopes`].
#[derive(Clone, Debug)]
pub struct CostScratch {
    start: Vec<Local>,
    tangent: Vec<Local>,
    state: State<Local>,
    u: DVector<Local>,
}

impl CostScratch {
    /// Memory for a simulator.
    pub fn new(simulator: &Simulator) -> Self {
        let zeros = |n: usize| vec![Local::from(0.0); n];
        Self {
            start: zeros(simulator.model().nq()),
            tangent: zeros(simulator.model().nv()),
            state: simulator.neutral_state(),
            u: DVector::from_vec(zeros(simulator.nu())),
        }
    }

    /// Adds the slopes of a cost of a step by dual numbers. Returns its value.
    fn stage<C: RolloutCost>(
        &mut self,
        cost: &C,
        at: &StagePoint<'_>,
        out: &mut CostSlopes<'_>,
    ) -> f64 {
        self.each(at, |memory, first| {
            let x = cost.stage(at.step, &memory.state, memory.u.as_slice());
            add_slopes(&x, first, out);
            x.re
        })
    }

    /// Evaluates a cost as often as there are directions, some at a time; `evaluate` gets the first of each.
    fn each(&mut self, at: &StagePoint<'_>, mut evaluate: impl FnMut(&Self, usize) -> f64) -> f64 {
        self.set(at);
        let mut value = 0.0;
        let n = at.simulator.n_tangent() + at.u.len();
        // Once at least, for the value.
        for first in (0..n.max(1)).step_by(CHUNK) {
            self.seed(at, first, 1.0);
            value = evaluate(self, first);
            self.seed(at, first, 0.0);
        }
        value
    }

    /// The point without derivatives.
    fn set(&mut self, at: &StagePoint<'_>) {
        let (state, x) = (&mut self.state, at.state);
        let pairs = [
            (&mut self.start[..], x.q.as_slice()),
            (state.q.as_mut_slice(), x.q.as_slice()),
            (state.v.as_mut_slice(), x.v.as_slice()),
            (state.contact.as_mut_slice(), x.contact.as_slice()),
            (self.u.as_mut_slice(), at.u),
        ];
        for (out, x) in pairs {
            out.iter_mut()
                .zip(x)
                .for_each(|(out, &x)| *out = Dual::from(x));
        }
    }

    /// Gives the directions from `first` on this derivative.
    fn seed(&mut self, at: &StagePoint<'_>, first: usize, derivative: f64) {
        let (model, state) = (at.simulator.model(), &mut self.state);
        let nv = model.nv();
        let numbers = (self.tangent.iter_mut())
            .chain(state.v.iter_mut())
            .chain(state.contact.iter_mut())
            .chain(self.u.iter_mut());
        for (k, x) in numbers.skip(first).take(CHUNK).enumerate() {
            x.eps[k] = derivative;
        }
        if first < nv {
            let q = state.q.as_mut_slice();
            model.integrate_into(&self.start, &self.tangent, q);
        }
    }
}

/// Adds derivatives in the directions from `first` on.
fn add_slopes(x: &Local, first: usize, out: &mut CostSlopes<'_>) {
    let all = out.state.iter_mut().chain(out.input.iter_mut());
    let own = all.skip(first).zip(x.eps);
    own.for_each(|(out, slope)| *out += slope);
}

/// The costs of a rollout, whatever their type.
pub(super) trait Costs {
    /// Adds the slopes of the cost of a step. Returns its value.
    fn stage(&mut self, at: &StagePoint<'_>, out: &mut CostSlopes<'_>) -> f64;

    /// Adds the slopes of the cost of the last state. Returns its value.
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
        let cost = self.cost;
        self.scratch.each(&at, |memory, first| {
            let x = cost.end(&memory.state);
            let mut slopes = CostSlopes {
                state: &mut *out,
                input: &mut [],
            };
            add_slopes(&x, first, &mut slopes);
            x.re
        })
    }
}
