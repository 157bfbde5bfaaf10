//! Which second derivatives count, and the exact ones by hyper-dual numbers: of the cost, and of the dynamics.

use num_dual::HyperDual64;

use crate::scalar::lift_into;
use crate::trajopt::cost::{Cost, Expansion};
use crate::trajopt::dynamics::Dynamics;
use crate::trajopt::problem::Problem;
use crate::trajopt::residual::Node;
use crate::trajopt::trajectory::Trajectory;

/// Which second derivatives count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Curvature {
    /// Those of the costs as Gauss and Newton have them; none of the dynamics (iLQR).
    #[default]
    GaussNewton,
    /// The exact Hessian of the costs and the second-order terms of the dynamics (DDP), by hyper-dual numbers: many evaluations, which
    /// allocate. Constraints keep the Hessian of Gauss and Newton; so does all else in an iteration where the exact one is not convex.
    /// Fewer iterations near an optimum, each many times as long: for an arm of seven joints some thirty times.
    Exact,
}

/// Adds `factor` times a cost with its exact Hessian. Allocates.
pub(super) fn add_exact_cost<D: Dynamics>(
    cost: &Cost<D>,
    node: &Node<'_, D>,
    (x, u): (&[f64], &[f64]),
    factor: f64,
    out: &mut Expansion,
) {
    let exact = cost.expand_exactly(node.dynamics, node.stage, x, u);
    out.value += factor * exact.value;
    out.gradient.axpy(factor, &exact.gradient, 1.0);
    out.hessian += exact.hessian * factor;
}

/// Adds the Hessian of  Vₓᵀ (f(x ⊕ δx, u + δu) ⊖ f(x, u))  to the upper triangle of `q`, n × n by columns. Allocates.
pub(super) fn add_dynamics<D: Dynamics>(
    problem: &Problem<D>,
    trajectory: &Trajectory,
    k: usize,
    v_x: &[f64],
    q: &mut [f64],
) {
    let dynamics = problem.dynamics();
    let (x, u) = (trajectory.states[k].as_slice(), trajectory.input(k));
    let (ndx, nx) = (dynamics.ndx(), dynamics.nx());
    let zero = HyperDual64::from(0.0);
    let mut next = vec![0.0; nx];
    dynamics.step(x, u, &mut next);
    let (mut start, mut end) = (vec![zero; nx], vec![zero; nx]);
    lift_into(x, &mut start);
    lift_into(&next, &mut end);
    let n = ndx + u.len();
    let inputs = u.iter().map(|&u| HyperDual64::from(u));
    let mut z: Vec<_> = std::iter::repeat_n(zero, ndx).chain(inputs).collect();
    let (mut moved, mut reached, mut dy) = (start.clone(), start.clone(), vec![zero; ndx]);
    for i in 0..n {
        for j in 0..=i {
            (z[j].eps1, z[i].eps2) = (1.0, 1.0);
            dynamics.integrate(&start, &z[..ndx], &mut moved);
            dynamics.step(&moved, &z[ndx..], &mut reached);
            dynamics.difference(&end, &reached, &mut dy);
            (z[j].eps1, z[i].eps2) = (0.0, 0.0);
            let terms = dy.iter().zip(v_x).map(|(dy, v_x)| dy.eps1eps2 * v_x);
            q[i * n + j] += terms.sum::<f64>();
        }
    }
}
