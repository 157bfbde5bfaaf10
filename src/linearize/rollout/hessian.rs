//! Second derivatives of rollouts: products of the Hessian of a cost with a direction, forward over adjoint.
//!
//! Along a direction the states move by δxₖ₊₁ = Aₖ δxₖ + Bₖ δuₖ, and the weights of the way back by
//!
//! > δλₖ = ∂²lₖ (δxₖ, δuₖ) + Aₖᵀ δλₖ₊₁ + ∂²(λₖ₊₁ᵀ xₖ₊₁) (δxₖ, δuₖ),
//!
//! each in the tangent space at its own state. The last term takes the step itself on dual numbers over dual numbers: the outer ones along state and input,
//! some at a time, the inner one along the direction. Their outer derivatives have Aᵀ δλ beside it.
//!
//! # References
//! [Griewank, Walther 2008, chapter 5].

use nalgebra::{DMatrix, DVector};

use super::cost::{Costs, Stages};
use super::{CostSlopes, RolloutCost, StagePoint};
use crate::autodiff::CHUNK;
use crate::linearize::{Linearization, LinearizeScratch};
use crate::scalar::Dual;
use crate::sim::{Rollout, RolloutStatus, Simulator, State, StepScratch};

/// A change of the start and of all inputs of a rollout, or numbers that belong to these.
#[derive(Clone, Debug, PartialEq)]
pub struct RolloutDirection {
    /// Along the tangent of the start (δq, δv, and the state of contact where there is one), length [`Simulator::n_tangent`].
    pub start: DVector<f64>,
    /// Along the input of each step, length `nu` each.
    pub inputs: Vec<DVector<f64>>,
}

impl RolloutDirection {
    /// No change, for a simulator and so many steps.
    pub fn zeros(simulator: &Simulator, steps: usize) -> Self {
        Self {
            start: DVector::zeros(simulator.n_tangent()),
            inputs: vec![DVector::zeros(simulator.nu()); steps],
        }
    }

    /// All numbers, those of the start first.
    fn numbers_mut(&mut self) -> impl Iterator<Item = &mut f64> {
        let inputs = self.inputs.iter_mut().flat_map(|u| u.iter_mut());
        self.start.iter_mut().chain(inputs)
    }

    /// # Panics
    /// If it does not fit.
    fn check(&self, simulator: &Simulator, steps: usize) {
        let (n, given) = (self.start.len(), self.inputs.len());
        let fits = n == simulator.n_tangent() && given == steps;
        let name = simulator.model().name();
        assert!(
            fits,
            "a direction of {n} numbers of the start and {given} inputs is none of {steps} steps of \"{name}\""
        );
        for u in &self.inputs {
            simulator.check_input(u.as_slice());
        }
    }
}

/// Product of the Hessian of a cost of a rollout with a direction.
#[derive(Clone, Debug, PartialEq)]
pub struct RolloutHessianProduct {
    /// The product; zero unless the rollout is completed.
    pub product: RolloutDirection,
    /// Status of the rollout.
    pub status: RolloutStatus,
}

impl Simulator<f64> {
    /// Computes the product of the Hessian of a [cost](RolloutCost) of the rollout from `start` under `inputs` with a direction, in the start (along
    /// its tangent, q ⊕ δq) and all inputs. Allocates, and keeps all states.
    ///
    /// J = Σₖ lₖ(xₖ, uₖ) + l(xₙ). Exact to rounding, no differences: for every four numbers of state and input each step is taken once over dual numbers
    /// of dual numbers, some 40 times the step. For a Hessian that is approximate and cheap, the Jacobians of a residual are the way
    /// ([`least_squares`](crate::least_squares)).
    ///
    /// * `along` – the direction
    ///
    /// # Limitations
    /// Where a force has a kink (touch-down, a stop, a limit, a box on four rigid corners, of which any tilt lifts one) it is the Hessian of the side that
    /// is taken. A
    /// [function](crate::contact::TerrainFunction) of the ground counts as the plane that touches it, and second derivatives in parameters are not found.
    ///
    /// # Panics
    /// If start, an input or the direction has the wrong length.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Scalar, Simulator, State, linearize::{RolloutCost, RolloutDirection}, model::samples};
    /// use nalgebra::DVector;
    ///
    /// /// Fourth power of the angle at the end.
    /// struct Angle;
    /// impl RolloutCost for Angle {
    ///     fn end<T: Scalar>(&self, last: &State<T>) -> T {
    ///         let square = last.q[0] * last.q[0];
    ///         square * square
    ///     }
    /// }
    /// // Without gravity q = q₀ + v₀ t, here with t = 0.5 s: ∂²J = 12 q² (1, t; t, t²)
    /// let model = samples::pendulum().with_gravity(nalgebra::Vector3::zeros());
    /// let simulator = Simulator::new(model).with_time_step(0.01);
    /// let inputs = vec![DVector::zeros(1); 50];
    /// let mut along = RolloutDirection::zeros(&simulator, 50);
    /// along.start[0] = 1.0;
    /// let swing = simulator.rollout_hessian_product(&State::new(&[0.1], &[2.0]), &inputs, &Angle, &along);
    /// let start = &swing.product.start;
    /// assert!((start[0] - 12.0 * 1.21).abs() < 1e-10 && (start[1] - 6.0 * 1.21).abs() < 1e-10);
    /// ```
    ///
    /// # References
    /// [Griewank, Walther 2008, chapter 5].
    pub fn rollout_hessian_product<C: RolloutCost>(
        &self,
        start: &State,
        inputs: &[DVector<f64>],
        cost: &C,
        along: &RolloutDirection,
    ) -> RolloutHessianProduct {
        along.check(self, inputs.len());
        let trajectory = self.linearized_rollout(start, inputs);
        RolloutHessianProduct {
            product: trajectory.product(self, &mut CostsTwice::new(cost, self), along),
            status: trajectory.rollout.status,
        }
    }

    /// Computes the Hessian of a [cost](RolloutCost) of the rollout, in the numbers of the start (along its tangent) and then those of the input of
    /// each step: a [product](Self::rollout_hessian_product) for each. Symmetric to rounding; zero unless the rollout is completed. Allocates.
    ///
    /// # Panics
    /// If start or an input has the wrong length.
    pub fn rollout_hessian<C: RolloutCost>(
        &self,
        start: &State,
        inputs: &[DVector<f64>],
        cost: &C,
    ) -> DMatrix<f64> {
        let trajectory = self.linearized_rollout(start, inputs);
        let mut costs = CostsTwice::new(cost, self);
        let n = self.n_tangent() + self.nu() * inputs.len();
        let mut out = DMatrix::zeros(n, n);
        for (k, mut column) in out.column_iter_mut().enumerate() {
            let mut along = RolloutDirection::zeros(self, inputs.len());
            if let Some(x) = along.numbers_mut().nth(k) {
                *x = 1.0;
            }
            let mut product = trajectory.product(self, &mut costs, &along);
            let numbers = column.iter_mut().zip(product.numbers_mut());
            numbers.for_each(|(out, x)| *out = *x);
        }
        out
    }

    fn linearized_rollout(&self, start: &State, inputs: &[DVector<f64>]) -> LinearizedRollout {
        let rollout = self.rollout_under(start, inputs);
        let mut scratch = LinearizeScratch::new(self);
        let steps = rollout.states.iter().zip(&rollout.inputs);
        let steps = steps.map(|(state, u)| {
            let mut step = Linearization::zeros(self);
            self.linearize_into(state, u.as_slice(), &mut scratch, &mut step);
            step
        });
        LinearizedRollout {
            steps: steps.collect(),
            rollout,
        }
    }
}

/// A rollout with the Jacobians of its steps.
struct LinearizedRollout {
    rollout: Rollout,
    steps: Vec<Linearization>,
}

impl LinearizedRollout {
    /// ∂²J along a direction; zero unless the rollout is completed.
    fn product(
        &self,
        simulator: &Simulator,
        costs: &mut dyn SecondCosts,
        along: &RolloutDirection,
    ) -> RolloutDirection {
        let (states, inputs) = (&self.rollout.states, &self.rollout.inputs);
        let mut out = RolloutDirection::zeros(simulator, along.inputs.len());
        if self.rollout.status != RolloutStatus::Completed {
            return out;
        }
        let moved = self.moved(along);
        let mut weights = Weights::zeros(simulator);
        let mut point = TwicePoint::new(simulator);
        let last = states.len() - 1;
        let none = DVector::zeros(0);
        let end = Place {
            simulator,
            step: last,
            state: &states[last],
            u: &none,
            dx: &moved[last],
            du: &none,
        };
        costs.end(&end, &mut point, &mut weights);
        for k in (0..last).rev() {
            let at = Place {
                simulator,
                step: k,
                state: &states[k],
                u: &inputs[k],
                dx: &moved[k],
                du: &along.inputs[k],
            };
            let mut before = Weights::zeros(simulator);
            self.steps[k].a.tr_mul_to(&weights.first, &mut before.first);
            point.add_step(&at, &states[k + 1], &weights, &mut before);
            costs.stage(&at, &mut point, &mut before);
            out.inputs[k].copy_from(&before.second_input);
            weights = before;
        }
        out.start.copy_from(&weights.second);
        out
    }

    /// Motion of the states along a direction.
    fn moved(&self, along: &RolloutDirection) -> Vec<DVector<f64>> {
        let mut out = vec![along.start.clone()];
        for (step, du) in self.steps.iter().zip(&along.inputs) {
            let dx = &out[out.len() - 1];
            let next = &step.a * dx + &step.b * du;
            out.push(next);
        }
        out
    }
}

/// Weights of a state on the way back, λ, with their changes along the direction, and those of the slopes of its input.
struct Weights {
    first: DVector<f64>,
    second: DVector<f64>,
    second_input: DVector<f64>,
}

impl Weights {
    fn zeros(simulator: &Simulator) -> Self {
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
struct Place<'a> {
    simulator: &'a Simulator,
    step: usize,
    state: &'a State,
    u: &'a DVector<f64>,
    dx: &'a DVector<f64>,
    du: &'a DVector<f64>,
}

/// A number with its derivative along the direction.
type Along = Dual<f64, 1>;

/// Such a number with its derivatives in numbers of state and input.
type Twice = Dual<Along, CHUNK>;

/// State and input over these numbers.
struct TwicePoint {
    start: Vec<Twice>,
    tangent: Vec<Twice>,
    state: State<Twice>,
    u: Vec<Twice>,
    next: State<Twice>,
    scratch: StepScratch<Twice>,
}

impl TwicePoint {
    fn new(simulator: &Simulator) -> Self {
        Self {
            start: vec![Twice::from(0.0); simulator.model().nq()],
            tangent: vec![Twice::from(0.0); simulator.model().nv()],
            state: simulator.neutral_state(),
            u: vec![Twice::from(0.0); simulator.nu()],
            next: simulator.neutral_state(),
            scratch: StepScratch::new(simulator),
        }
    }

    /// Hands over the point as often as there are numbers of state and input, some at a time, with the first of each.
    fn each(&mut self, at: &Place<'_>, mut evaluate: impl FnMut(&mut Self, usize)) {
        let n = at.dx.len() + at.u.len();
        for first in (0..n).step_by(CHUNK) {
            self.seed(at, first);
            evaluate(self, first);
        }
    }

    fn seed(&mut self, at: &Place<'_>, first: usize) {
        let (model, state) = (at.simulator.model(), at.state);
        let nv = model.nv();
        let values = std::iter::repeat_n(&0.0, nv).chain(&state.v);
        let values = values.chain(&state.contact).chain(at.u);
        let along = at.dx.iter().chain(at.du);
        let numbers = (self.tangent.iter_mut())
            .chain(self.state.v.iter_mut())
            .chain(self.state.contact.iter_mut())
            .chain(self.u.iter_mut());
        for (k, ((x, &value), &along)) in numbers.zip(values).zip(along).enumerate() {
            let value = Along::new(value, [along]);
            *x = match k.checked_sub(first).filter(|own| *own < CHUNK) {
                Some(own) => Twice::variable(value, own),
                None => Twice::new(value, [Along::from(0.0); CHUNK]),
            };
        }
        let start = self.start.iter_mut().zip(&state.q);
        start.for_each(|(out, &q)| *out = q.into());
        let q = self.state.q.as_mut_slice();
        model.integrate_into(&self.start, &self.tangent, q);
    }

    /// Adds ∂²(λᵀ x⁺) along the direction and Aᵀ δλ, and as much for the input.
    fn add_step(&mut self, at: &Place<'_>, next: &State, after: &Weights, out: &mut Weights) {
        let next: State<Twice> = next.lift();
        self.each(at, |memory, first| {
            let (state, u, step) = (&memory.state, &memory.u, &mut memory.scratch);
            at.simulator.step_into(state, u, step, &mut memory.next);
            let change = memory.next.deviation(at.simulator.model(), &next);
            let weights = after.first.iter().zip(&after.second);
            for (x, (weight, second)) in change.iter().zip(weights) {
                let slopes = out.second_from(first).zip(x.eps);
                slopes.for_each(|(out, x)| *out += weight * x.eps[0] + second * x.re);
            }
        });
    }
}

/// Adds the changes of slopes of a cost.
fn add_second(x: &Twice, first: usize, out: &mut Weights) {
    let slopes = out.second_from(first).zip(x.eps);
    slopes.for_each(|(out, x)| *out += x.eps[0]);
}

/// The costs of a rollout with first and second derivatives, whatever their type.
trait SecondCosts {
    fn stage(&mut self, at: &Place<'_>, point: &mut TwicePoint, out: &mut Weights);
    fn end(&mut self, at: &Place<'_>, point: &mut TwicePoint, out: &mut Weights);
}

struct CostsTwice<'a, C> {
    cost: &'a C,
    slopes: Stages<'a, C>,
}

impl<'a, C: RolloutCost> CostsTwice<'a, C> {
    fn new(cost: &'a C, simulator: &Simulator) -> Self {
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
