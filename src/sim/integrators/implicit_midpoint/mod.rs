//! The implicit midpoint rule on the manifold of configurations: symplectic, of second order, for smooth motion whose energy must not drift.
//!
//! It is the variational integrator of the discrete Lagrangian Δt L(q ⊕ ½ Δt ξ, ξ). With the velocity ξ of the step, the momentum μ = M ξ and the force
//! f = ∂L/∂q + τ of its middle `q_m` = q ⊕ ½ Δt ξ, and the momentum p = M v of its start,
//!
//! > μ = (dexp 2φ)ᵀ p + ½ Δt (dexp φ)ᵀ f,   φ = ½ Δt ξ,
//! > q⁺ = q ⊕ Δt ξ,   M(q⁺) v⁺ = A (A p + Δt f),
//!
//! where A carries momenta by half of the step along the joint's own motion (`joint.rs`). Of joints whose configuration is a vector dexp and A are 1:
//! μ = p + ½ Δt f and M(q⁺) v⁺ = p + Δt f. So the momentum of a body that nothing pushes is kept to rounding.
//!
//! | module | content |
//! |---|---|
//! | `joint` | momenta of one joint along its own motion |
//! | `point` | momentum and force at the middle of a step, and the step with them |
//! | `newton` | the velocity ξ, over plain numbers |
//! | `slopes` | derivatives of momenta and forces |
//! | `pushforward`, `pullback` | Jacobians and gradient of the step, by the implicit function theorem |
//! | `weights` | weights of what a step goes through |
//! | `numbers` | the gradient in what the robot is made of |
//!
//! # References
//! [Marsden, West 2001]; [Hairer, Lubich, Wanner 2006, chapter VI].

mod joint;
mod newton;
mod numbers;
mod point;
mod pullback;
mod pushforward;
mod slopes;
mod weights;

use super::AccelerationScratch;
use super::method::Step;
use crate::cone::Status;
use crate::scalar::{Over, Scalar, is_more_than_values};
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use newton::Newton;
use point::Midpoint;
pub(super) use pullback::Adjoint;
pub(super) use pushforward::Columns;

/// Working memory: the middle of a step, and the search for it on plain numbers. Lanes are stepped one by one.
#[derive(Clone, Debug)]
pub(crate) struct Memory<T: Scalar> {
    point: Midpoint<T>,
    newton: Newton,
    statuses: Vec<Status>,
}

impl<T: Scalar> Step<T> for Memory<T> {
    fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
        Self {
            point: Midpoint::new(simulator),
            newton: Newton::new(simulator),
            statuses: vec![Status::default(); T::LANES],
        }
    }

    fn step<P: Scalar>(
        &mut self,
        simulator: &Simulator<P>,
        state: &State<T>,
        u: &[T],
        found: &mut AccelerationScratch<T>,
        next: &mut State<T>,
    ) where
        T: Over<P>,
    {
        if const { T::LANES > 1 } {
            for (lane, status) in self.statuses.iter_mut().enumerate() {
                *status = self.newton.step(simulator, state, u, lane, next);
            }
            return;
        }
        self.find(simulator, state, u, found);
        self.point.finish(simulator, state, next);
    }

    fn status(&self, lane: usize) -> Status {
        self.statuses[lane]
    }
}

impl<T: Scalar> Memory<T> {
    /// Finds the middle of a step, where there is one lane.
    fn find<P: Scalar>(
        &mut self,
        simulator: &Simulator<P>,
        state: &State<T>,
        u: &[T],
        found: &mut AccelerationScratch<T>,
    ) where
        T: Over<P>,
    {
        let point = &mut self.point;
        point.start(simulator, state);
        self.statuses[0] = self.newton.solve(simulator, state, u);
        let values = self.newton.point.xi.iter().map(|&x| T::constant(x));
        point.xi.iter_mut().zip(values).for_each(|(xi, x)| *xi = x);
        point.evaluate(simulator, state, u, found);
        // Each makes one more order of derivatives exact.
        let corrections = T::ORDER.max(usize::from(is_more_than_values::<T>()));
        for _ in 0..corrections {
            point.find_residual(simulator);
            self.newton.correct(&mut point.residual);
            point.move_by_residual();
            point.evaluate(simulator, state, u, found);
        }
    }
}
