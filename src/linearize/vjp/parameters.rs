//! Gradient of a step in parameters by forward mode, for steps through kinematic constraints.
//!
//! Their rows depend on the numbers of every joint on the way to their anchors, twice where velocity forces of the middle of the step are held by them
//! too: no small function of few numbers is left whose derivatives a sweep could carry. The step itself over dual numbers has all of it.

use super::StepPoint;
use crate::autodiff::CHUNK;
use crate::scalar::Dual;
use crate::sim::{Simulator, State};

type Local = Dual<f64, CHUNK>;

/// Adds the gradient of λᵀ x⁺ in as many parameters of the simulator as are wanted, from the first on: a step over dual numbers for every [`CHUNK`] of them. Allocates.
pub(super) fn add_by_forward_mode(
    simulator: &Simulator,
    at: &StepPoint<'_>,
    adjoint: &[f64],
    out: &mut [f64],
) {
    let (state, next): (State<Local>, State<Local>) =
        (at.state.lift(), simulator.step(at.state, at.u).lift());
    let u: Vec<Local> = at.u.iter().map(|&u| u.into()).collect();
    let mut parameters: Vec<Local> = simulator.parameters().iter().map(|&x| x.into()).collect();
    for first in (0..out.len()).step_by(CHUNK) {
        let own = first..out.len().min(first + CHUNK);
        for (k, x) in parameters[own.clone()].iter_mut().enumerate() {
            x.eps[k] = 1.0;
        }
        let moved = simulator.with_parameters(&parameters).step(&state, &u);
        let change = moved.deviation(simulator.model(), &next);
        for (x, weight) in change.iter().zip(adjoint) {
            let slopes = out[own.clone()].iter_mut().zip(x.eps);
            slopes.for_each(|(out, slope)| *out += weight * slope);
        }
        for x in &mut parameters[own] {
            x.eps = [0.0; CHUNK];
        }
    }
}
