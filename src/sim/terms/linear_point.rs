//! A moment at which terms are differentiated, and what their derivatives add up to.

use crate::dynamics::{AccelerationDerivatives, Blocks, Calls, Entries};
use crate::scalar::{Differentiable, Dual, Scalar};
use crate::sim::balance::Balance;
use crate::sim::moment::Moment;
use crate::sim::simulator::Simulator;
use crate::spatial::Force;

/// A number that depends on one coordinate and one input only: its derivatives in position, velocity, input.
pub(crate) type OfCoordinate<T = f64> = Dual<T, 3>;

/// All coordinates and inputs, each along its own direction.
#[derive(Clone, Debug)]
pub(crate) struct Coordinates<T = f64> {
    pub(crate) q: Vec<OfCoordinate<T>>,
    pub(crate) v: Vec<OfCoordinate<T>>,
    pub(crate) u: Vec<OfCoordinate<T>>,
}

impl<T: Scalar> Coordinates<T> {
    /// Memory for a simulator.
    pub(crate) fn new(simulator: &Simulator) -> Self {
        let zeros = |n: usize| vec![Dual::from(0.0); n];
        let model = simulator.model();
        Self {
            q: zeros(model.nq()),
            v: zeros(model.nv()),
            u: zeros(simulator.nu()),
        }
    }

    /// Takes over those of a moment.
    pub(crate) fn set(&mut self, at: &Moment<'_, f64, T>) {
        let all = [
            (&mut self.q, at.q()),
            (&mut self.v, at.v()),
            (&mut self.u, at.u),
        ];
        for (direction, (out, x)) in all.into_iter().enumerate() {
            let moved = out.iter_mut().zip(x);
            moved.for_each(|(out, &x)| *out = Dual::variable(x, direction));
        }
    }
}

/// Point at which terms are differentiated.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LinearPoint<'a, T: Scalar = f64> {
    pub(crate) moment: &'a Moment<'a, f64, T>,
    pub(crate) coordinates: &'a Coordinates<T>,
    /// v̇.
    pub(crate) a: &'a [T],
    /// `true` for the acceleration that there would be without stops and rows.
    pub(crate) is_free: bool,
    /// The rows and their forces; `None` where there are none.
    pub(crate) balance: Option<&'a Balance<T>>,
    /// The acceleration ã along which constraints look ahead; `None` for those of a moment.
    pub(crate) ahead: Option<&'a [T]>,
}

/// Derivatives of what the acceleration balances, and the forces on bodies at which they hold.
#[derive(Clone, Debug)]
pub(crate) struct ForceColumns<T: Differentiable = f64> {
    pub(crate) acceleration: AccelerationDerivatives<T>,
    /// Δt c + Δt² k of drives and stops whose forces are those of the end of a step; zeros where none are.
    pub(crate) resistance: Vec<OfCoordinate<T>>,
    /// On each body, in the body.
    pub(crate) bodies: Vec<Force<T>>,
}

impl<T: Differentiable> ForceColumns<T> {
    /// Memory for a simulator.
    pub(crate) fn new(simulator: &Simulator, calls: Calls) -> Self {
        let model = simulator.model();
        let further = simulator.n_contact() + simulator.nu();
        Self {
            acceleration: AccelerationDerivatives::new(model, further, calls),
            resistance: vec![Dual::from(0.0); model.nv()],
            bodies: vec![Force::zero(); model.n_bodies()],
        }
    }

    /// Starts anew without forces.
    pub(crate) fn clear(&mut self) {
        self.acceleration.columns.clear();
        self.resistance.fill(Dual::from(0.0));
        self.bodies.fill(Force::zero());
    }

    /// The columns: −∂τ − ∂(Jᵀ f) in q, v, the state of contact and the input.
    pub(crate) fn columns(&mut self) -> &mut Blocks<T> {
        &mut self.acceleration.columns
    }

    /// Subtracts the derivatives of a joint force in its own coordinate.
    #[inline]
    pub(crate) fn subtract_of_coordinate(&mut self, k: usize, tau: &OfCoordinate<T>) {
        self.columns().add(k, k, -tau.eps[0], -tau.eps[1]);
    }
}
