//! The implicit midpoint rule on the manifold of configurations: symplectic, of second order, for smooth motion whose energy must not drift.
//!
//! It is the variational integrator of the discrete Lagrangian Δt L(q ⊕ ½ Δt ξ, ξ). With the velocity ξ of the step, the momentum μ = M ξ and the force
//! f = ∂L/∂q + τ of its middle `q_m` = q ⊕ ½ Δt ξ, and the momentum p = M v of its start,
//!
//! > μ = (dexp 2φ)ᵀ p + ½ Δt (dexp φ)ᵀ f,   φ = ½ Δt ξ,
//! > q⁺ = q ⊕ Δt ξ,   M(q⁺) v⁺ = A (A p + Δt f),
//!
//! where A transports momenta by half of the step along the motion of the joint (`joint.rs`). Of joints whose configuration is a vector dexp and A are 1:
//! μ = p + ½ Δt f and M(q⁺) v⁺ = p + Δt f. So the momentum of a free body is conserved to rounding.
//!
//! | module | content |
//! |---|---|
//! | `joint` | momenta of one joint along its own motion |
//! | `point` | momentum and force at the middle of a step, and the step with them |
//! | `newton` | the velocity ξ, over plain numbers |
//! | `parts`, `part` | division of a step that is too long, and one of its parts |
//! | `held` | constraints of start and end, with their impulses |
//! | `saddle` | equations with constraints |
//! | `slopes` | derivatives of momenta and forces |
//! | `pushforward`, `pullback` | Jacobians and gradient of the step, by the implicit function theorem |
//! | `weights` | weights of intermediate quantities of a step |
//! | `bilateral_derivatives` | derivatives of the contributions of constraints |
//! | `numbers`, `bilateral_parameters` | the gradient in parameters |
//!
//! # References
//! [Marsden, West 2001]; [Hairer, Lubich, Wanner 2006, chapter VI].

mod bilateral_derivatives;
mod bilateral_parameters;
mod held;
mod joint;
mod newton;
mod numbers;
mod part;
mod parts;
mod point;
mod pullback;
mod pushforward;
mod saddle;
mod slopes;
mod weights;

use super::AccelerationScratch;
use super::method::Step;
use crate::cone::Status;
use crate::scalar::{Over, Scalar};
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use newton::Newton;
use part::Part;
use parts::{Search, divided, each, is_finite};
use point::Midpoint;
pub(super) use pullback::Adjoint;
pub(super) use pushforward::Columns;

/// Working memory. Lanes are stepped one by one.
#[derive(Clone, Debug)]
pub(crate) struct Memory<T: Scalar> {
    part: Part<T>,
    /// Number of parts of the last step, and the states at their starts, the first of a longer list.
    parts: usize,
    starts: Vec<State<T>>,
    statuses: Vec<Status>,
}

impl<T: Scalar> Step<T> for Memory<T> {
    fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
        Self {
            part: Part {
                point: Midpoint::new(simulator),
                newton: Newton::new(simulator),
            },
            parts: 1,
            starts: vec![simulator.neutral_state()],
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
                *status = (self.part.newton).step(simulator, state, u, lane, next);
            }
            return;
        }
        self.starts[0].copy_from(state);
        (self.parts, self.statuses[0]) = divided(is_finite(state, u), |parts| {
            self.step_in(simulator, u, parts, found, next)
        });
    }

    fn status(&self, lane: usize) -> Status {
        self.statuses[lane]
    }
}

impl<T: Scalar> Memory<T> {
    /// Takes a step in so many parts. Memory for the states between them is made when they are first needed.
    fn step_in<P: Scalar>(
        &mut self,
        simulator: &Simulator<P>,
        u: &[T],
        parts: usize,
        found: &mut AccelerationScratch<T>,
        next: &mut State<T>,
    ) -> Search
    where
        T: Over<P>,
    {
        let Self { part, starts, .. } = self;
        each(parts, |k| {
            match starts.get_mut(k) {
                Some(start) if k > 0 => start.copy_from(next),
                Some(_) => {}
                None => starts.push(next.clone()),
            }
            part.take(simulator, &starts[k], u, parts, found, next)
        })
    }
}
