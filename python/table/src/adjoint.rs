//! Gradients of the dynamics along the tree.

use dualbody::Model;
use dualbody::dynamics::{
    ForwardDynamicsGradient, ForwardDynamicsVjpScratch, InverseDynamicsGradient,
    InverseDynamicsVjpScratch, forward_dynamics_vjp_into, inverse_dynamics_vjp_into,
};

/// Derivatives of a weighted sum in the tangent of q, in the other vectors, and in all parameters.
type Derivatives = Vec<Vec<f64>>;

/// Computes the gradient of a weighted sum of the results of a function: model, rows, weights.
pub type Adjoint = fn(&Model, &[&[f64]], &[f64]) -> Derivatives;

/// The gradient of a function of this name in all inputs and parameters at once; `None` if there is none but that by dual numbers.
pub fn adjoint_of(name: &str) -> Option<Adjoint> {
    match name {
        "inverse_dynamics" => Some(inverse),
        "bias_forces" => Some(|m, x, weights| {
            let still = vec![0.0; m.nv()];
            let mut all = inverse(m, &[x[0], x[1], &still], weights);
            all.remove(2);
            all
        }),
        "gravity_forces" => Some(|m, x, weights| {
            let still = vec![0.0; m.nv()];
            let mut all = inverse(m, &[x[0], &still, &still], weights);
            all.drain(1..3);
            all
        }),
        "forward_dynamics" => Some(forward),
        _ => None,
    }
}

fn inverse(m: &Model, x: &[&[f64]], weights: &[f64]) -> Derivatives {
    let mut out = InverseDynamicsGradient::zeros(m);
    let mut scratch = InverseDynamicsVjpScratch::new(m);
    inverse_dynamics_vjp_into(m, x[0], x[1], x[2], &[], weights, &mut scratch, &mut out);
    let all = [out.q, out.v, out.a, out.parameters];
    all.map(|x| x.as_slice().to_vec()).into()
}

fn forward(m: &Model, x: &[&[f64]], weights: &[f64]) -> Derivatives {
    let mut out = ForwardDynamicsGradient::zeros(m);
    let mut scratch = ForwardDynamicsVjpScratch::new(m);
    forward_dynamics_vjp_into(m, x[0], x[1], x[2], &[], weights, &mut scratch, &mut out);
    let all = [out.q, out.v, out.tau, out.parameters];
    all.map(|x| x.as_slice().to_vec()).into()
}
