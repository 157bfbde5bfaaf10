//! Vector-Jacobian products of the step: the gradient of a weighted sum of the entries of the next state.
//!
//! With the weights λ of the next state, the gradient of λᵀ x⁺ in state, input and all parameters costs a few steps, independent of their number.
//! It is found backwards (`sim/integrators`): through each joint's own step to the weights of its acceleration; by the implicit function theorem to
//! weights μ of the balance of forces; and from these by one sweep along the tree, to which each term of the
//! equation of motion adds its part (`sim/terms`). No graph is recorded, and the derivatives of small functions come from dual numbers. All functions
//! are generic over the scalar: on dual numbers of one direction they also compute second derivatives along it.

use nalgebra::DVector;

use crate::dynamics::Calls;
use crate::model::Generation;
use crate::scalar::Opaque;
use crate::sim::{Pullback, Simulator, State, StepAdjoint, StepGradientSum, StepPoint};

/// Gradient of λᵀ x⁺ of a step from x with input u.
#[derive(Clone, Debug, PartialEq)]
pub struct StepGradient {
    /// In the state, along its tangent (δq, δv, the contact state and activations where there are any), length [`Simulator::n_tangent`]: Aᵀ λ.
    pub state: DVector<f64>,
    /// In the input, length `nu`: Bᵀ λ.
    pub input: DVector<f64>,
    /// In all [parameters](Simulator::parameters) of the simulator, in their order; or only in those of the model, which come first; or empty.
    pub parameters: DVector<f64>,
}

impl StepGradient {
    /// Makes memory for a simulator.
    pub fn zeros(simulator: &Simulator) -> Self {
        Self {
            state: DVector::zeros(simulator.n_tangent()),
            input: DVector::zeros(simulator.nu()),
            parameters: DVector::zeros(simulator.parameters().len()),
        }
    }

    /// Omits the parameters: their vector is empty.
    #[must_use]
    pub fn without_parameters(mut self) -> Self {
        self.parameters = DVector::zeros(0);
        self
    }

    /// Omits all parameters except those of the [model](crate::Model::parameters).
    #[must_use]
    pub fn with_model_parameters_only(mut self, simulator: &Simulator) -> Self {
        self.parameters = DVector::zeros(simulator.model().parameters().len());
        self
    }

    pub(super) fn check(&self, simulator: &Simulator, parameters: Counts) {
        let (n, nu, len) = (self.state.len(), self.input.len(), self.parameters.len());
        assert!(
            n == simulator.n_tangent() && nu == simulator.nu(),
            "a gradient of \"{}\" has {} state and {} input entries, got memory for {n} and {nu}",
            simulator.model().name(),
            simulator.n_tangent(),
            simulator.nu()
        );
        assert!(
            len == 0 || len == parameters.all || len == parameters.of_model,
            "\"{}\" has {} parameters, {} in all, got memory for the gradient in {len}",
            simulator.model().name(),
            parameters.of_model,
            parameters.all
        );
    }

    fn slopes(&mut self, nv: usize, n_contact: usize, parameters: Counts) -> StepGradientSum<'_> {
        let len = self.parameters.len();
        let (q, rest) = self.state.as_mut_slice().split_at_mut(nv);
        let (v, rest) = rest.split_at_mut(nv);
        let (contact, activation) = rest.split_at_mut(n_contact);
        StepGradientSum {
            q,
            v,
            contact,
            activation,
            u: self.input.as_mut_slice(),
            parameters: self.parameters.as_mut_slice(),
            has_parts: len > parameters.of_model,
        }
    }
}

/// Numbers of parameters of a simulator.
#[derive(Clone, Copy, Debug)]
pub(super) struct Counts {
    all: usize,
    of_model: usize,
}

/// Working memory of [`Simulator::vjp_into`]. It belongs to the model that it was made for and to clones of it; after a change of masses, placements,
/// armature, or of the set of actuators and contacts, make a new one.
#[derive(Clone, Debug)]
pub struct VjpScratch {
    generation: Generation,
    pub(super) parameters: Counts,
    adjoint: Opaque<StepAdjoint<f64>>,
}

impl VjpScratch {
    /// Makes memory for a simulator.
    pub fn new(simulator: &Simulator) -> Self {
        Self::for_calls(simulator, Calls::Many)
    }

    fn for_calls(simulator: &Simulator, calls: Calls) -> Self {
        Self {
            generation: simulator.model().generation(),
            parameters: Counts {
                all: simulator.parameters().len(),
                of_model: simulator.model().parameters().len(),
            },
            adjoint: Opaque::new(StepAdjoint::new(simulator, calls)),
        }
    }

    /// Whether it belongs to the model of a simulator.
    pub(super) fn belongs_to(&self, simulator: &Simulator) -> bool {
        self.generation == simulator.model().generation()
            && self.adjoint.get().is_of(simulator.integrator())
    }
}

impl Simulator<f64> {
    /// Computes the gradient of λᵀ x⁺, the vector-Jacobian product of the step from `state` with input `u`, in state, input and all parameters at
    /// once. Allocates.
    ///
    /// Works for every joint kind, base, integrator and contact model; exact to rounding. It costs three to six steps.
    ///
    /// # Impacts
    /// It is the derivative of the step, like A and B. For each contact model, see [`linearize`](Self::linearize).
    ///
    /// * `state` – the state before the step
    /// * `u` – the input, length `nu` (N·m or N)
    /// * `adjoint` – λ, weights of the tangent of the next state, length [`n_tangent`](Self::n_tangent)
    ///
    /// # Limitations
    /// Only [parameters](Self::parameters) have a gradient.
    ///
    /// # Panics
    /// If an argument has the wrong length.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, State, model::samples};
    ///
    /// // v⁺ = v + Δt (u − ½ m g l sin q) / J with J = 1/3 kg·m²
    /// let simulator = Simulator::new(samples::pendulum()).with_time_step(0.01);
    /// let gradient = simulator.vjp(&State::new(&[0.0], &[0.0]), &[2.0], &[0.0, 1.0]);
    /// assert!((gradient.input[0] - 0.03).abs() < 1e-15);
    /// let moment = simulator.model().parameter_layout().find("rod: Jzz")?;
    /// assert!((gradient.parameters[moment] + 0.01 * 2.0 * 9.0).abs() < 1e-14); // −Δt u / J²
    /// # Ok::<(), dualbody::UnknownName>(())
    /// ```
    ///
    /// # References
    /// [Griewank, Walther 2008, chapter 3].
    pub fn vjp(&self, state: &State, u: &[f64], adjoint: &[f64]) -> StepGradient {
        let mut out = StepGradient::zeros(self);
        let mut scratch = VjpScratch::for_calls(self, Calls::One);
        self.vjp_into(state, u, adjoint, &mut scratch, &mut out);
        out
    }

    /// [`vjp`](Self::vjp) without allocation, except the first semi-implicit Euler step with fast rotation, see [`Integrator`](crate::Integrator).
    ///
    /// # Panics
    /// If state, input, adjoint, scratch or output have the wrong size.
    pub fn vjp_into(
        &self,
        state: &State,
        u: &[f64],
        adjoint: &[f64],
        scratch: &mut VjpScratch,
        out: &mut StepGradient,
    ) {
        out.check(self, scratch.parameters);
        out.parameters.fill(0.0);
        let at = StepPoint {
            state,
            u,
            acceleration: None,
        };
        self.add_vjp(&at, adjoint, scratch, out);
    }

    /// [`vjp_into`](Self::vjp_into), but adds the gradient in parameters to `out`.
    pub(crate) fn add_vjp(
        &self,
        at: &StepPoint<'_>,
        adjoint: &[f64],
        scratch: &mut VjpScratch,
        out: &mut StepGradient,
    ) {
        assert_eq!(
            adjoint.len(),
            self.n_tangent(),
            "the adjoint of the next state of \"{}\" has one entry per tangent coordinate",
            self.model().name()
        );
        assert!(
            scratch.belongs_to(self),
            "the scratch belongs to another model than \"{}\", or to this one before a change of it or of its integrator",
            self.model().name()
        );
        self.check_input(at.u);
        self.check(at.state);
        out.state.fill(0.0);
        out.input.fill(0.0);
        let mut slopes = out.slopes(self.model().nv(), self.n_contact(), scratch.parameters);
        let method = scratch.adjoint.get_mut();
        method.add_gradient(self, at, adjoint, &mut slopes);
    }
}
