//! Gradient of weighted momenta and forces in the parameters of the robot, at fixed states:
//!
//! > αᵀ μ + βᵀ f + πᵀ M(q) v − yᵀ M(q⁺) v⁺.
//!
//! A momentum is inverse dynamics of the robot without gravity, at rest, with its velocity as the acceleration. The force f is  τ − h  and  ∂T/∂q +
//! c: the balance of forces without acceleration, the kinetic energy as q moves along β, and Coriolis forces of the robot without gravity.
//! `bilateral_parameters.rs` contains the part of constraints.

use super::bilateral_parameters::BilateralParameters;
use super::pushforward::TakenStep;
use super::weights::Weights;
use crate::dynamics::{EnergyGradientSum, EnergySweep, Gradients, Pushed, Rates, Sweep, Weighted};
use crate::model::{BodyId, Model};
use crate::scalar::{Differentiable, Dual, Scalar};
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::integrators::balance::BalanceAdjoint;
use crate::sim::integrators::method::StepPoint;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use crate::sim::terms::{DerivativePoint, StepGradientSum, TermWeights};
use crate::spatial::Force;

/// A number with its rate as the middle moves along β.
type Moving<T> = Dual<T, 1>;

/// Working memory.
#[derive(Clone, Debug)]
pub(super) struct NumberDerivatives<T: Scalar> {
    weightless: Model,
    sweep: Sweep<T>,
    balance: BalanceAdjoint<T>,
    along: AlongForce<T>,
    /// `None` without constraints.
    held: Option<Box<BilateralParameters<T>>>,
    rest: Vec<T>,
    /// Weights with another sign.
    minus: Vec<T>,
    /// Gradients in states and inputs, which nothing reads.
    unused: [Vec<T>; 4],
}

impl<T: Differentiable> NumberDerivatives<T> {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let model = simulator.model();
        let zeros = || vec![T::zero(); model.nv()];
        let weightless = model.clone().with_gravity(nalgebra::Vector3::zeros());
        let mut sweep = Sweep::new(&weightless);
        sweep.slots.gravity = None;
        Self {
            weightless,
            sweep,
            balance: BalanceAdjoint::new(simulator),
            along: AlongForce::new(model),
            held: (simulator.bilateral_rows() > 0)
                .then(|| Box::new(BilateralParameters::new(simulator))),
            rest: zeros(),
            minus: zeros(),
            unused: [zeros(), zeros(), zeros(), vec![T::zero(); simulator.nu()]],
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
        let middle = &taken.point().state;
        self.add_momentum(middle, &weights.residual, out);
        if let Some(held) = &mut self.held {
            held.add(simulator, at, taken, weights, out);
        } else {
            self.add_momentum(at.state, &weights.p, out);
            self.reverse(&weights.end_p);
            let minus = std::mem::take(&mut self.minus);
            self.add_momentum(&taken.next, &minus, out);
            self.minus = minus;
        }
        let rest = std::mem::take(&mut self.rest);
        self.add_weighted(middle, [middle.v.as_slice(), &rest], &weights.force, out);
        self.rest = rest;
        self.reverse(&weights.force);
        self.add_balance(simulator, at, taken, out);
        let model = simulator.model();
        self.along
            .add(model, middle, &weights.force, out.parameters);
    }

    fn reverse(&mut self, weights: &[T]) {
        let both = self.minus.iter_mut().zip(weights);
        both.for_each(|(out, &x)| *out = -x);
    }

    /// μᵀ M v
    fn add_momentum(&mut self, at: &State<T>, mu: &[T], out: &mut StepGradientSum<'_, T>) {
        let rest = std::mem::take(&mut self.rest);
        self.add_weighted(at, [&rest, at.v.as_slice()], mu, out);
        self.rest = rest;
    }

    /// μᵀ ID of the robot without weight, with a velocity and an acceleration.
    fn add_weighted(
        &mut self,
        at: &State<T>,
        [v, a]: [&[T]; 2],
        mu: &[T],
        out: &mut StepGradientSum<'_, T>,
    ) {
        let q = at.q.as_slice();
        let weighted = Weighted {
            q,
            v,
            a,
            mu,
            external: &[],
        };
        let [by_q, by_v, by_a, _] = &mut self.unused;
        let mut slopes = Gradients {
            q: by_q,
            v: by_v,
            a: by_a,
            parameters: &mut *out.parameters,
        };
        self.sweep.add(&self.weightless, &weighted, &mut slopes);
    }

    /// βᵀ (τ − h), with the weights of the other sign.
    fn add_balance(
        &mut self,
        simulator: &Simulator,
        at: &StepPoint<'_, T>,
        taken: &TakenStep<T>,
        out: &mut StepGradientSum<'_, T>,
    ) {
        let moment = EvaluationPoint::instant(simulator, &taken.point().state, at.u);
        let point = DerivativePoint::of_all(&moment, &self.rest, None);
        let weights = TermWeights {
            mu: &self.minus,
            y: &[],
            by_contact: &[],
            friction: &[],
        };
        let [q, v, _, u] = &mut self.unused;
        let mut slopes = StepGradientSum {
            q,
            v,
            contact: &mut *out.contact,
            activation: &mut [],
            u,
            parameters: &mut *out.parameters,
            has_parts: out.has_parts,
        };
        let terms = &taken.found.terms;
        self.balance.add(&point, &weights, None, terms, &mut slopes);
    }
}

/// The kinetic energy as the configuration moves along weights of a force.
#[derive(Clone, Debug)]
struct AlongForce<T> {
    placed: Sweep<Moving<T>>,
    energy: EnergySweep<Moving<T>>,
    /// Configuration, tangent, velocity.
    q: [Vec<Moving<T>>; 2],
    tangent: Vec<Moving<T>>,
    v: Vec<Moving<T>>,
    rest: Vec<Moving<T>>,
    by_q: Vec<Moving<T>>,
    parameters: Vec<Moving<T>>,
}

impl<T: Scalar> AlongForce<T> {
    fn new(model: &Model) -> Self {
        let zeros = |n: usize| vec![Moving::from(0.0); n];
        Self {
            placed: Sweep::new(model),
            energy: EnergySweep::new(model),
            q: [zeros(model.nq()), zeros(model.nq())],
            tangent: zeros(model.nv()),
            v: zeros(model.nv()),
            rest: zeros(model.nv()),
            by_q: zeros(model.nv()),
            parameters: zeros(model.parameters().len()),
        }
    }

    /// Adds the gradient of βᵀ ∂T/∂q.
    fn add(&mut self, model: &Model, at: &State<T>, beta: &[T], out: &mut [T]) {
        if model.n_bodies() == 0 {
            return;
        }
        self.move_along(model, at, beta);
        let (q, v, rest) = (&self.q[1][..], &self.v[..], &self.rest[..]);
        let (a, mu) = (rest, rest);
        let weighted = Weighted {
            q,
            v: rest,
            a,
            mu,
            external: &[],
        };
        self.placed.start(model, &weighted);
        let pushed = Pushed {
            body: BodyId(0),
            force: Force::zero(),
            by_pose: Force::zero(),
        };
        self.energy.start(model, &self.placed, v, true);
        self.parameters.fill(Moving::from(0.0));
        let mut slopes = EnergyGradientSum {
            q: &mut self.by_q,
            parameters: &mut self.parameters,
        };
        let (rates, one) = (Rates { q, v }, Moving::from(1.0));
        self.energy
            .finish(model, &self.placed, &rates, Some(&pushed), one, &mut slopes);
        let rates = self.parameters.iter().map(|x| x.eps[0]);
        out.iter_mut()
            .zip(rates)
            .for_each(|(out, rate)| *out += rate);
    }

    fn move_along(&mut self, model: &Model, at: &State<T>, beta: &[T]) {
        let lift = |own: &mut [Moving<T>], x: &[T]| {
            let both = own.iter_mut().zip(x);
            both.for_each(|(own, &x)| *own = Moving::constant_of(x));
        };
        lift(&mut self.q[0], at.q.as_slice());
        lift(&mut self.v, at.v.as_slice());
        for (own, &rate) in self.tangent.iter_mut().zip(beta) {
            own.eps[0] = rate;
        }
        let [start, moved] = &mut self.q;
        model.integrate_into(start, &self.tangent, moved);
    }
}
