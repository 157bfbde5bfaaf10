//! Workspaces with data of one model, passed with another model.

use dualbody::Model;
use dualbody::dynamics::{
    AbaScratch, InverseDynamicsDerivatives, InverseDynamicsDerivativesScratch,
    forward_dynamics_into, inverse_dynamics_derivatives_into,
};
use dualbody::model::BodyId;

use super::refused;
use crate::common::asset;

fn accelerate(model: &Model, scratch: &mut AbaScratch<f64>) -> Vec<f64> {
    let (q, zeros) = (model.neutral(), vec![0.0; model.nv()]);
    let mut a = zeros.clone();
    forward_dynamics_into(model, q.as_slice(), &zeros, &zeros, &[], scratch, &mut a);
    a
}

fn differentiate(
    model: &Model,
    scratch: &mut InverseDynamicsDerivativesScratch,
) -> InverseDynamicsDerivatives {
    let (q, ones) = (model.neutral(), vec![1.0; model.nv()]);
    let mut out = InverseDynamicsDerivatives::zeros(model);
    inverse_dynamics_derivatives_into(model, q.as_slice(), &ones, &ones, &[], scratch, &mut out);
    out
}

// The branches of a quadruped are worked on side by side, from a copy of their numbers.
#[test]
fn scratch_of_a_model_before_a_change_is_refused() {
    let model = asset("quadruped.urdf");
    let heavier = model.bodies()[5].inertia.scaled(2.0);
    let changed = model.clone().with_inertia(BodyId(5), heavier);
    let said = "or to this one before a change";

    let mut scratch = AbaScratch::new(&model);
    let a = accelerate(&model, &mut scratch);
    assert_eq!(accelerate(&model.clone(), &mut scratch), a);
    refused(said, || accelerate(&changed, &mut scratch));
    assert_ne!(accelerate(&changed, &mut AbaScratch::new(&changed)), a);

    let mut scratch = InverseDynamicsDerivativesScratch::new(&model);
    let d = differentiate(&model, &mut scratch);
    assert_eq!(differentiate(&model.clone(), &mut scratch), d);
    refused(said, || differentiate(&changed, &mut scratch));
    let new = &mut InverseDynamicsDerivativesScratch::new(&changed);
    assert_ne!(differentiate(&changed, new), d);
}
