//! Inputs that functions of a robot have in common, and units.

use nalgebra::DVector;

use crate::model::Model;
use crate::scalar::traced::{Port, Tracer};
use crate::scalar::{Scalar, Traced};
use crate::sim::{Simulator, State};

/// Units along the coordinates of a robot.
pub(super) const POSITION: &str = "rad or m; quaternions w, x, y, z";
pub(super) const VELOCITY: &str = "rad/s or m/s";
pub(super) const ACCELERATION: &str = "rad/s^2 or m/s^2";
pub(super) const FORCE: &str = "N m or N";
pub(super) const CONTACT: &str = "m";

/// Declares q and v.
pub(super) fn motion<P: Scalar>(t: &mut Tracer, model: &Model<P>) -> [Vec<Traced>; 2] {
    [
        t.input(Port::vector("q", model.nq()).with_unit(POSITION)),
        t.input(Port::vector("v", model.nv()).with_unit(VELOCITY)),
    ]
}

/// Declares a state and an input: `q`, `v`, `contact` where there is a state of contact, `u`.
pub(super) fn state_and_input<P: Scalar>(
    t: &mut Tracer,
    simulator: &Simulator<P>,
) -> (State<Traced>, Vec<Traced>) {
    let [q, v] = motion(t, simulator.model());
    let mut state = simulator.state(&q, &v);
    if simulator.n_contact() > 0 {
        let port = Port::vector("contact", simulator.n_contact()).with_unit(CONTACT);
        state.contact = DVector::from_vec(t.input(port));
    }
    let u = t.input(Port::vector("u", simulator.nu()).with_unit(FORCE));
    (state, u)
}
