//! Derivatives of a user's force in pose and velocity of its place and in its parameters.

use super::Dual;
use crate::scalar::Scalar;
use crate::sim::{
    ErasedForce, FORCE_DIRECTIONS, FORCE_PLACE, ForceFunction, ForceJet, MAX_FORCE_PARAMETERS,
};
use crate::spatial::transform::TRANSFORM_ENTRIES;
use crate::spatial::{Force, Motion, SPATIAL, Transform};

impl<F: ForceFunction> ErasedForce for F {
    fn value(&self, place: &[f64; FORCE_PLACE], parameters: &[f64]) -> [f64; SPATIAL] {
        evaluate(self, place, parameters).to_array()
    }

    fn jet(&self, place: &[f64; FORCE_PLACE], parameters: &[f64]) -> ForceJet {
        let place = std::array::from_fn(|k| Dual::variable(place[k], k));
        let mut lifted = [Dual::from(0.0); MAX_FORCE_PARAMETERS];
        for (k, (out, &own)) in lifted.iter_mut().zip(parameters).enumerate() {
            *out = Dual::variable(own, FORCE_PLACE + k);
        }
        let force: Force<Dual<f64, FORCE_DIRECTIONS>> =
            evaluate(self, &place, &lifted[..parameters.len()]);
        let force = force.to_array();
        ForceJet {
            force: force.map(|x| x.re),
            slopes: force.map(|x| x.eps),
        }
    }
}

fn evaluate<F: ForceFunction, T: Scalar>(
    function: &F,
    place: &[T; FORCE_PLACE],
    parameters: &[T],
) -> Force<T> {
    let pose = Transform::from_entries(std::array::from_fn(|k| place[k]));
    let velocity = Motion::from_array(std::array::from_fn(|k| place[TRANSFORM_ENTRIES + k]));
    function.force(&pose, &velocity, parameters)
}
