//! Second derivatives of rollouts: products of the Hessian of a cost with a direction, forward over adjoint.
//!
//! Along a direction the states move by δxₖ₊₁ = Aₖ δxₖ + Bₖ δuₖ, and the weights of the way back by
//!
//! > δλₖ = ∂²lₖ (δxₖ, δuₖ) + Aₖᵀ δλₖ₊₁ + ∂²(λₖ₊₁ᵀ xₖ₊₁) (δxₖ, δuₖ),
//!
//! each in the tangent space at its own state. That is the derivative along the direction of the vector-Jacobian products of the steps: their adjoint, taken
//! once at each state xₖ + ε δxₖ with weights λₖ₊₁ + ε δλₖ₊₁, over dual numbers of one direction. Its weights and gradients are along tangents where the states
//! have moved to, so those of costs, which belong to the states themselves, are taken there, and those of the start back.
//!
//! # References
//! [Griewank, Walther 2008, chapter 5].

use nalgebra::{DMatrix, DVector};

use super::RolloutCost;
use super::directed::Directed;
use super::direction::RolloutDirection;
use super::second_costs::{CostsTwice, Place, SecondCosts, TwicePoint, Weights};
use crate::sim::{RolloutStatus, Simulator, State};

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
    /// J = Σₖ lₖ(xₖ, uₖ) + l(xₙ). Exact to rounding, without finite differences. Each step and its [adjoint](Self::vjp) are evaluated once over dual
    /// numbers of one direction, independent of the number of states and inputs. The costs are evaluated over nested dual numbers, once for every
    /// four state and input coordinates. For an approximate and cheap Hessian, use the Jacobians of a residual
    /// ([`least_squares`](crate::least_squares)).
    ///
    /// * `along` – the direction; the columns of the Hessian are the products with the unit directions
    ///
    /// # Limitations
    /// At a nonsmooth point of a force (touch-down, a joint limit, an effort limit, a box on four rigid corners, one of which lifts at any tilt) it
    /// is the Hessian of one side. A terrain given by a [function](crate::contact::TerrainFunction) is replaced by its tangent plane. Second
    /// derivatives in parameters are not computed.
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
        let mut directed = Directed::new(self, start, inputs);
        RolloutHessianProduct {
            product: directed.product(&mut CostsTwice::new(cost, self), along),
            status: directed.rollout.status,
        }
    }

    /// The Hessian of  λᵀ (f(x ⊕ δx, u + δu) ⊖ f(x, u))  of the step f in (δx, δu), n × n with n = [`n_tangent`](Self::n_tangent) + `nu`; zero where the
    /// step diverges. Allocates.
    ///
    /// * `lambda` – λ, weights of the tangent of the next state
    pub(crate) fn step_hessian(&self, state: &State, u: &[f64], lambda: &[f64]) -> DMatrix<f64> {
        let inputs = [DVector::from_column_slice(u)];
        all_products(self, state, &inputs, &mut WeightedEnd(lambda))
    }
}

/// Products of the Hessian of a cost with all directions.
fn all_products(
    simulator: &Simulator,
    start: &State,
    inputs: &[DVector<f64>],
    costs: &mut dyn SecondCosts,
) -> DMatrix<f64> {
    let mut directed = Directed::new(simulator, start, inputs);
    let n = simulator.n_tangent() + simulator.nu() * inputs.len();
    let mut out = DMatrix::zeros(n, n);
    for (k, mut column) in out.column_iter_mut().enumerate() {
        let mut along = RolloutDirection::zeros(simulator, inputs.len());
        if let Some(x) = along.numbers_mut().nth(k) {
            *x = 1.0;
        }
        let mut product = directed.product(costs, &along);
        let numbers = column.iter_mut().zip(product.numbers_mut());
        numbers.for_each(|(out, x)| *out = *x);
    }
    out
}

/// The cost λᵀ δ of the way δ from the end of the rollout itself, which is linear along it.
struct WeightedEnd<'a>(&'a [f64]);

impl SecondCosts for WeightedEnd<'_> {
    fn stage(&mut self, _: &Place<'_>, _: &mut TwicePoint, _: &mut Weights) {}

    fn end(&mut self, _: &Place<'_>, _: &mut TwicePoint, out: &mut Weights) {
        out.first.copy_from_slice(self.0);
    }
}
