//! Costs of rollouts with their second derivatives along a direction.

use nalgebra::DVector;

use super::cost::{Costs, Stages};
use super::{CostSlopes, RolloutCost, StagePoint};
use crate::autodiff::CHUNK;
use crate::scalar::Dual;
use crate::sim::{Simulator, State};

/// Slopes of a cost in state and input, with their changes along the direction.
pub(super) struct Weights {
    pub(super) first: DVector<f64>,
    pub(super) second: DVector<f64>,
    pub(super) second_input: DVector<f64>,
}

impl Weights {
    pub(super) fn zeros(simulator: &Simulator) -> Self {
        let n = simulator.n_tangent();
        Self {
            first: DVector::zeros(n),
            second: DVector::zeros(n),
            second_input: DVector::zeros(simulator.nu()),
        }
    }

    /// Changes of the slopes in state and input from a direction on.
    fn second_from(&mut self, first: usize) -> impl Iterator<Item = &mut f64> {
        let all = self.second.iter_mut().chain(self.second_input.iter_mut());
        all.skip(first)
    }
}

/// A step of a rollout, and how its state and input move along the direction.
pub(super) struct Place<'a> {
    pub(super) simulator: &'a Simulator,
    pub(super) step: usize,
    pub(super) state: &'a State,
    pub(super) u: &'a DVector<f64>,
    pub(super) dx: &'a DVector<f64>,
    pub(super) du: &'a DVector<f64>,
}

/// A number with its derivative along the direction.
pub(super) type Along = Dual<f64, 1>;

/// Such a number with its derivatives in numbers of state and input.
type Twice = Dual<Along, CHUNK>;

/// State and input over these numbers.
pub(super) struct TwicePoint {
    start: Vec<Twice>,
    tangent: Vec<Twice>,
    state: State<Twice>,
    u: Vec<Twice>,
}

impl TwicePoint {
    pub(super) fn new(simulator: &Simulator) -> Self {
        Self {
            start: vec![Twice::from(0.0); simulator.model().nq()],
            tangent: vec![Twice::from(0.0); simulator.model().nv()],
            state: simulator.neutral_state(),
            u: vec![Twice::from(0.0); simulator.nu()],
        }
    }

    /// Hands over the point as often as there are numbers of state and input, some at a time, with the first of each.
    fn each(&mut self, at: &Place<'_>, mut evaluate: impl FnMut(&Self, usize)) {
        let (n, nv) = (at.dx.len() + at.u.len(), at.simulator.model().nv());
        self.set(at);
        for first in (0..n).step_by(CHUNK) {
            self.seed(first, Along::from(1.0));
            // Once more after the last of them, for a configuration that moves along the direction alone.
            if first < nv + CHUNK {
                let (start, q) = (&self.start, self.state.q.as_mut_slice());
                at.simulator.model().integrate_into(start, &self.tangent, q);
            }
            evaluate(self, first);
            self.seed(first, Along::from(0.0));
        }
    }

    /// The point as it moves along the direction.
    fn set(&mut self, at: &Place<'_>) {
        let start = self.start.iter_mut().zip(&at.state.q);
        start.for_each(|(out, &q)| *out = q.into());
        let values = std::iter::repeat_n(&0.0, self.tangent.len()).chain(&at.state.v);
        let values = values.chain(&at.state.contact).chain(at.u);
        let moves = values.zip(at.dx.iter().chain(at.du));
        for (x, (&value, &along)) in self.numbers().zip(moves) {
            *x = Twice::constant_of(Along::new(value, [along]));
        }
    }

    /// Gives the directions from `first` on this derivative.
    fn seed(&mut self, first: usize, derivative: Along) {
        for (k, x) in self.numbers().skip(first).take(CHUNK).enumerate() {
            x.eps[k] = derivative;
        }
    }

    /// All numbers along which a state and an input move.
    fn numbers(&mut self) -> impl Iterator<Item = &mut Twice> {
        (self.tangent.iter_mut())
            .chain(self.state.v.iter_mut())
            .chain(self.state.contact.iter_mut())
            .chain(self.u.iter_mut())
    }
}

/// Adds the changes of slopes of a cost.
fn add_second(x: &Twice, first: usize, out: &mut Weights) {
    let slopes = out.second_from(first).zip(x.eps);
    slopes.for_each(|(out, x)| *out += x.eps[0]);
}

/// The costs of a rollout with first and second derivatives, whatever their type.
pub(super) trait SecondCosts {
    fn stage(&mut self, at: &Place<'_>, point: &mut TwicePoint, out: &mut Weights);
    fn end(&mut self, at: &Place<'_>, point: &mut TwicePoint, out: &mut Weights);
}

pub(super) struct CostsTwice<'a, C> {
    cost: &'a C,
    slopes: Stages<'a, C>,
}

impl<'a, C: RolloutCost> CostsTwice<'a, C> {
    pub(super) fn new(cost: &'a C, simulator: &Simulator) -> Self {
        Self {
            cost,
            slopes: Stages::new(cost, simulator),
        }
    }
}

impl<C: RolloutCost> SecondCosts for CostsTwice<'_, C> {
    fn stage(&mut self, at: &Place<'_>, point: &mut TwicePoint, out: &mut Weights) {
        let here = StagePoint {
            simulator: at.simulator,
            step: at.step,
            state: at.state,
            u: at.u.as_slice(),
        };
        let mut slopes = CostSlopes {
            state: out.first.as_mut_slice(),
            input: &mut vec![0.0; at.u.len()],
        };
        self.slopes.stage(&here, &mut slopes);
        let cost = self.cost;
        point.each(at, |memory, first| {
            let x = cost.stage(at.step, &memory.state, &memory.u);
            add_second(&x, first, out);
        });
    }

    fn end(&mut self, at: &Place<'_>, point: &mut TwicePoint, out: &mut Weights) {
        let slopes = out.first.as_mut_slice();
        self.slopes.end(at.simulator, at.state, slopes);
        let cost = self.cost;
        point.each(at, |memory, first| {
            add_second(&cost.end(&memory.state), first, out);
        });
    }
}
