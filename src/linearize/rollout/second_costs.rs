//! Costs of rollouts with their second derivatives along a direction.

use nalgebra::DVector;

use super::cost::{Costs, SeededState, Stages};
use super::{CostSlopes, RolloutCost, StagePoint};
use crate::autodiff::CHUNK;
use crate::scalar::Dual;
use crate::sim::{Simulator, State};

/// Derivatives of a cost in state and input, with their changes along the direction.
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

    /// Changes of the derivatives in state and input from a direction on.
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

/// A value with its derivative along the direction.
pub(super) type Along = Dual<f64, 1>;

/// State and input over such numbers with their derivatives in numbers of state and input.
pub(super) type TwicePoint = SeededState<Along>;

/// Hands over the point, as it moves along the direction, as often as there are numbers of state and input, some at a time, with the first of each.
fn each(
    at: &Place<'_>,
    point: &mut TwicePoint,
    f: impl FnMut(&State<Dual<Along, CHUNK>>, &[Dual<Along, CHUNK>], usize),
) {
    let zeros = std::iter::repeat_n(&0.0, at.simulator.model().nv());
    let values = zeros.chain(at.state.beside_q()).chain(at.u);
    let moves = values.zip(at.dx.iter().chain(at.du));
    point.set(at.state, moves.map(|(&x, &dx)| Along::new(x, [dx])));
    point.each(at.simulator.model(), at.dx.len() + at.u.len(), f);
}

/// Adds the changes of gradients of a cost.
fn add_second(x: &Dual<Along, CHUNK>, first: usize, out: &mut Weights) {
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
        each(at, point, |state, u, first| {
            add_second(&cost.stage(at.step, state, u), first, out);
        });
    }

    fn end(&mut self, at: &Place<'_>, point: &mut TwicePoint, out: &mut Weights) {
        let slopes = out.first.as_mut_slice();
        self.slopes.end(at.simulator, at.state, slopes);
        let cost = self.cost;
        each(at, point, |state, _, first| {
            add_second(&cost.end(state), first, out);
        });
    }
}
