//! The quadruped of the assets on its feet.

use dualbody::contact::{ContactLaw, Contacts, Terrain};
use dualbody::{Model, Simulator, State};

use super::asset;
use super::ground::actuated;

pub(crate) const FEET: [&str; 4] = ["FR_foot", "FL_foot", "RR_foot", "RL_foot"];

/// The quadruped on a ground, which its feet alone touch, with its own actuators, in steps of 2 ms that are implicit in velocity.
///
/// * `law` – of the mass of the robot
pub(crate) fn quadruped(law: impl Fn(f64) -> ContactLaw, terrain: Terrain) -> Simulator {
    let model = asset("quadruped.urdf");
    let law = law(model.total_mass());
    let contacts = on_feet(&model, terrain, law);
    actuated(model, contacts)
}

pub(crate) fn on_feet(model: &Model, terrain: Terrain, law: ContactLaw) -> Contacts {
    let contacts = Contacts::new(model, terrain, law);
    contacts.with_links(model, &FEET).expect("feet")
}

/// Legs bent, the trunk at a height, m.
pub(crate) fn crouching(simulator: &Simulator, height: f64) -> State {
    let mut state: State = simulator.neutral_state();
    state.q[2] = height;
    for leg in 0..4 {
        state.q[7 + 3 * leg + 1] = 0.8;
        state.q[7 + 3 * leg + 2] = -1.6;
    }
    state
}
