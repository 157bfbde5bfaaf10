//! Gradient of the weighted momenta of start and end of a constrained robot in all parameters, at fixed states:
//!
//! > πᵀ (M(q) v + J(q)ᵀ λ) − yᵀ (M(q⁺) v⁺ − J(q⁺)ᵀ λ⁺) + κᵀ φ(q⁺) − σᵀ J(q⁺) v⁺.
//!
//! The adjoint of the balance of forces gives that of  μᵀ (ID(a) − τ − Jᵀ f) + wᵀ (J a + φ / T²)  at rest, where T is the time constant of a row. At a = v,
//! less the same at a = 0 without forces of rows, that is  μᵀ (M v − Jᵀ f)  and what rows are weighted with.

use super::pushforward::TakenStep;
use super::weights::Weights;
use crate::constraint::{ConstraintRow, Hold};
use crate::dynamics::Calls;
use crate::scalar::{Differentiable, Scalar};
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::integrators::AccelerationScratch;
use crate::sim::integrators::balance::BalanceAdjoint;
use crate::sim::integrators::method::StepPoint;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use crate::sim::terms::{Acting, DerivativePoint, StepGradientSum, TermWeights};

/// Working memory.
#[derive(Clone, Debug)]
pub(super) struct BilateralParameters<T: Scalar> {
    balance: BalanceAdjoint<T>,
    found: AccelerationScratch<T>,
    /// A configuration, at rest.
    state: State<T>,
    rest: Vec<T>,
    weights: [RowWeights<T>; 2],
    /// Gradients in states and inputs, which nothing reads.
    unused: [Vec<T>; 3],
}

/// Weights at the velocity of a state, and at rest.
#[derive(Clone, Debug)]
struct RowWeights<T> {
    mu: Vec<T>,
    forces: Vec<T>,
    y: Vec<T>,
}

impl<T: Scalar> RowWeights<T> {
    fn new(nv: usize, rows: usize) -> Self {
        let zeros = |n: usize| vec![T::zero(); n];
        Self {
            mu: zeros(nv),
            forces: zeros(rows),
            y: zeros(rows),
        }
    }
}

impl<T: Differentiable> BilateralParameters<T> {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let (nv, rows) = (simulator.model().nv(), simulator.bilateral_rows());
        let zeros = |n: usize| vec![T::zero(); n];
        Self {
            balance: BalanceAdjoint::new(simulator),
            found: AccelerationScratch::new(simulator, Calls::Many),
            state: simulator.neutral_state(),
            rest: zeros(nv),
            weights: [RowWeights::new(nv, rows), RowWeights::new(nv, rows)],
            unused: [zeros(nv), zeros(nv), zeros(simulator.nu())],
        }
    }

    /// Adds the gradient.
    pub(super) fn add(
        &mut self,
        simulator: &Simulator,
        at: &StepPoint<'_, T>,
        taken: &TakenStep<T>,
        weights: &Weights<T>,
        out: &mut StepGradientSum<'_, T>,
    ) {
        let held = &taken.point().held;
        let [own, end] = &held.impulses;
        self.start(weights.p.iter().copied(), own.iter().map(|&x| -x));
        self.add_momentum(simulator, at.state, at.u, out);
        let mu = weights.end_p.iter().map(|&x| -x);
        self.start(mu, end.iter().copied());
        let by_row = weights.rates.iter().zip(&weights.errors);
        for (k, ((&rate, &error), row)) in by_row.zip(&held.end.rows).enumerate() {
            self.weights[0].y[k] = -rate;
            self.weights[1].y[k] = error * squared_time_constant(row, simulator) + rate;
        }
        self.add_momentum(simulator, &taken.next, at.u, out);
    }

    /// Takes weights of a momentum, and forces of rows, which are not weighted themselves.
    fn start(&mut self, mu: impl Iterator<Item = T>, forces: impl Iterator<Item = T>) {
        let [moving, resting] = &mut self.weights;
        for (k, mu) in mu.enumerate() {
            (moving.mu[k], resting.mu[k]) = (mu, -mu);
        }
        for (own, force) in moving.forces.iter_mut().zip(forces) {
            *own = force;
        }
        for y in moving.y.iter_mut().chain(&mut resting.y) {
            *y = T::zero();
        }
    }

    /// Adds that of μᵀ (M v − Jᵀ f), and of weighted rows.
    fn add_momentum(
        &mut self,
        simulator: &Simulator,
        at: &State<T>,
        u: &[T],
        out: &mut StepGradientSum<'_, T>,
    ) {
        self.state.q.copy_from(&at.q);
        let at_rest = EvaluationPoint::instant(simulator, &self.state, u);
        simulator.apply_terms(&at_rest, &mut self.found);
        let accelerations = [at.v.as_slice(), &self.rest];
        for (a, own) in accelerations.into_iter().zip(&self.weights) {
            let point = DerivativePoint {
                point: &at_rest,
                a,
                acting: Acting::Start(&own.forces),
            };
            let weights = TermWeights {
                mu: &own.mu,
                y: &own.y,
                by_contact: &[],
                friction: &[],
            };
            let [q, v, u] = &mut self.unused;
            let mut slopes = StepGradientSum {
                q,
                v,
                contact: &mut *out.contact,
                u,
                parameters: &mut *out.parameters,
                has_parts: out.has_parts,
            };
            let terms = &self.found.terms;
            self.balance
                .add(&point, &weights, Some(a), terms, &mut slopes);
        }
    }
}

/// T², of which the rows of a step know a time constant of two steps at least.
fn squared_time_constant<T: Scalar>(row: &ConstraintRow<T>, simulator: &Simulator) -> T {
    let Hold::Rigid { time_constant } = row.hold else {
        return T::zero();
    };
    let time_constant = time_constant.max(T::constant(2.0 * simulator.time_step()));
    time_constant * time_constant
}
