//! Inputs and outputs that functions of a robot have in common, and units.

use nalgebra::DVector;

use crate::error::UnknownName;
use crate::model::Model;
use crate::scalar::traced::{Port, Tracer};
use crate::scalar::{Over, Scalar, Traced};
use crate::sim::{Simulator, State, StepScratch};

/// Units along the coordinates of a robot.
pub(super) const POSITION: &str = "rad or m; quaternions w, x, y, z";
pub(super) const VELOCITY: &str = "rad/s or m/s";
pub(super) const ACCELERATION: &str = "rad/s^2 or m/s^2";
pub(super) const FORCE: &str = "N m or N";
pub(super) const CONTACT: &str = "m";
const ACTIVATION: &str = "the input's";

/// Declares q and v.
pub(super) fn motion<P: Scalar>(t: &mut Tracer, model: &Model<P>) -> [Vec<Traced>; 2] {
    [
        t.input(Port::vector("q", model.nq()).with_unit(POSITION)),
        t.input(Port::vector("v", model.nv()).with_unit(VELOCITY)),
    ]
}

/// Declares a state and an input: `q`, `v`, `contact` and `activation` where the state has such numbers, `u`.
pub(super) fn state_and_input<P: Scalar>(
    t: &mut Tracer,
    simulator: &Simulator<P>,
) -> (State<Traced>, Vec<Traced>) {
    let state = state(t, simulator);
    let u = t.input(Port::vector("u", simulator.nu()).with_unit(FORCE));
    (state, u)
}

/// Declares a state: `q`, `v`, `contact` and `activation` where it has such numbers.
///
/// # Panics
/// If bodies can touch each other with shapes that cannot be recorded; the message names shapes and links.
pub(super) fn state<P: Scalar>(t: &mut Tracer, simulator: &Simulator<P>) -> State<Traced> {
    if let Some(contacts) = simulator.contacts() {
        contacts.check_recordable(simulator.model());
    }
    let [q, v] = motion(t, simulator.model());
    let mut state = simulator.state(&q, &v);
    if simulator.n_contact() > 0 {
        let port = Port::vector("contact", simulator.n_contact()).with_unit(CONTACT);
        state.contact = DVector::from_vec(t.input(port));
    }
    if simulator.n_activation() > 0 {
        let port = Port::vector("activation", simulator.n_activation()).with_unit(ACTIVATION);
        state.activation = DVector::from_vec(t.input(port));
    }
    state
}

/// Takes a step, and outputs the next state: `q_next`, `v_next`, and `contact_next` and `activation_next` where it has such numbers.
pub(super) fn output_step<P: Scalar>(
    t: &mut Tracer,
    simulator: &Simulator<P>,
    state: &State<Traced>,
    u: &[Traced],
) where
    Traced: Over<P>,
{
    let (model, next) = (simulator.model(), next(simulator, state, u));
    let q = Port::vector("q_next", model.nq()).with_unit(POSITION);
    t.output(q, &next.q);
    let v = Port::vector("v_next", model.nv()).with_unit(VELOCITY);
    t.output(v, &next.v);
    if simulator.n_contact() > 0 {
        let contact = Port::vector("contact_next", simulator.n_contact()).with_unit(CONTACT);
        t.output(contact, &next.contact);
    }
    if simulator.n_activation() > 0 {
        let port = Port::vector("activation_next", simulator.n_activation());
        t.output(port.with_unit(ACTIVATION), &next.activation);
    }
}

/// The next state.
pub(super) fn next<P: Scalar>(
    simulator: &Simulator<P>,
    state: &State<Traced>,
    u: &[Traced],
) -> State<Traced>
where
    Traced: Over<P>,
{
    let mut next = state.clone();
    simulator.step_into(state, u, &mut StepScratch::new(simulator), &mut next);
    next
}

/// Parameters of a simulator that are inputs of a graph: their places in [`Simulator::parameter_layout`].
pub(super) struct Varied(Vec<usize>);

impl Varied {
    pub(super) fn new(simulator: &Simulator, names: &[&str]) -> Result<Self, UnknownName> {
        let layout = simulator.parameter_layout();
        let places = names.iter().map(|name| layout.find(name));
        Ok(Self(places.collect::<Result<_, _>>()?))
    }

    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    /// Declares them, if there are any: `parameters`. Returns the simulator that has them, all others being constants, and their values.
    #[cfg_attr(not(feature = "graphs"), inline)]
    pub(super) fn input(
        &self,
        t: &mut Tracer,
        simulator: &Simulator,
    ) -> (Simulator<Traced>, Vec<Traced>) {
        if self.0.is_empty() {
            return (simulator.cast(), Vec::new());
        }
        let values = t.input(Port::vector("parameters", self.len()));
        let mut all: Vec<Traced> = simulator.parameters().iter().map(|&p| p.into()).collect();
        for (&k, &p) in self.0.iter().zip(&values) {
            all[k] = p;
        }
        (simulator.with_parameters(&all), values)
    }
}
