//! Activations of the inputs of a simulator, and the signals that they make of these.

use super::activation::{Activation, JointCoordinate, PlacedActivation};
use super::simulator::Simulator;
use super::state::State;
use crate::error::UnknownName;
use crate::scalar::{Over, Scalar};

/// The signals over a step, and the activations after it.
#[derive(Clone, Debug)]
pub(crate) struct Signals<T> {
    signal: Vec<T>,
    next: Vec<T>,
}

impl<T> Default for Signals<T> {
    fn default() -> Self {
        Self {
            signal: Vec::new(),
            next: Vec::new(),
        }
    }
}

impl<T: Scalar> Signals<T> {
    /// Finds what the motors get instead of the input: the input itself where nothing has an activation. Allocates in the first call only.
    pub(crate) fn find<'a, P: Scalar>(
        &'a mut self,
        simulator: &Simulator<P>,
        state: &State<T>,
        u: &'a [T],
    ) -> &'a [T]
    where
        T: Over<P>,
    {
        if simulator.activations().is_empty() {
            return u;
        }
        self.signal.clear();
        self.signal.extend_from_slice(u);
        self.next.resize(simulator.n_activation(), T::zero());
        for own in simulator.activations() {
            let (w, next) = (own.states(state.activation.as_slice()), own.range());
            let next = &mut self.next[next];
            self.signal[own.input] = own.step(simulator.time_step(), state, w, u, next);
        }
        &self.signal
    }

    /// The activations after the step.
    pub(crate) fn next(&self) -> &[T] {
        &self.next
    }
}

impl<P: Scalar> Simulator<P> {
    /// Sets the activation between an input and its motor or servo; replaces an earlier one. The entries of its state follow the existing ones.
    ///
    /// * `input` – one of [`input_names`](Self::input_names)
    ///
    /// # Errors
    /// If there is no such input.
    ///
    /// # Panics
    /// If the input of a [function](Activation::function) is not that of a joint of one degree of freedom.
    pub fn with_activation(
        mut self,
        input: &str,
        activation: Activation<P>,
    ) -> Result<Self, UnknownName> {
        let names = self.input_names();
        let Some(k) = names.iter().position(|name| name == input) else {
            return Err(UnknownName {
                model: self.model().name().into(),
                element: "input".into(),
                name: input.into(),
                known: names,
            });
        };
        let placed = PlacedActivation {
            name: input.into(),
            input: k,
            first: 0,
            joint: None,
            own: activation,
        };
        match (self.activations.iter_mut()).find(|own| own.name == input) {
            Some(own) => *own = placed,
            None => self.activations.push(placed),
        }
        Ok(self.with_activations_placed())
    }

    /// Finds the inputs of activations, which may have moved, and the places of their numbers.
    ///
    /// # Panics
    /// If an input is missing, or a function has no joint.
    pub(super) fn with_activations_placed(mut self) -> Self {
        if self.activations.is_empty() {
            return self;
        }
        let (names, mut first) = (self.input_names(), 0);
        let mut activations = std::mem::take(&mut self.activations);
        for own in &mut activations {
            let input = names.iter().position(|name| *name == own.name);
            let has_input = input.is_some();
            assert!(
                has_input,
                "\"{}\" has an activation of \"{}\", which is not an input any more",
                self.model().name(),
                own.name
            );
            own.input = input.unwrap_or_default();
            own.joint = self.single_coordinate(own.input);
            assert!(
                own.joint.is_some() || !own.own.needs_motion(),
                "an actuator as a function drives \"{}\", which is not a joint of one degree of freedom",
                own.name
            );
            own.first = first;
            first += own.own.states();
        }
        self.activations = activations;
        self
    }

    /// The coordinate of the joint that an input drives, if that has no other.
    fn single_coordinate(&self, input: usize) -> Option<JointCoordinate> {
        let v = *self.actuated().get(input)?;
        let body = self.model().independent().find(|body| body.v == v)?;
        (body.joint.nq() == 1).then_some(JointCoordinate { q: body.q, v })
    }

    /// The simulator whose inputs are the signals.
    pub(crate) fn without_activations(mut self) -> Self {
        self.activations.clear();
        self
    }

    /// Activations of inputs, in the order of their numbers.
    pub(crate) fn activations(&self) -> &[PlacedActivation<P>] {
        &self.activations
    }

    /// Number of entries of the activations in the state.
    pub fn n_activation(&self) -> usize {
        let last = self.activations.last();
        last.map_or(0, |own| own.range().end)
    }
}
