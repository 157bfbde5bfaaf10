//! The forward pass: the policy through the true dynamics, gaps closed by a share.

use super::product::dot;
use super::stage::{Stage, Worker};
use crate::trajopt::dynamics::Dynamics;
use crate::trajopt::lagrangian::StagePoint;
use crate::trajopt::problem::{InitialState, Problem};
use crate::trajopt::trajectory::Trajectory;

/// Cost and merit of a trajectory.
#[derive(Clone, Copy, Debug)]
pub(super) struct Price {
    /// The costs of the problem.
    pub(super) cost: f64,
    /// With the penalties of the constraints.
    pub(super) merit: f64,
}

/// Working memory of the forward pass.
#[derive(Clone, Debug)]
pub(super) struct Forward {
    dx: Vec<f64>,
    share: Vec<f64>,
    reached: Vec<f64>,
}

impl Forward {
    pub(super) fn new<D: Dynamics>(problem: &Problem<D>) -> Self {
        let (nx, ndx) = (problem.dynamics().nx(), problem.dynamics().ndx());
        Self {
            dx: vec![0.0; ndx],
            share: vec![0.0; ndx],
            reached: vec![0.0; nx],
        }
    }

    /// Takes the share `alpha` of the step:
    ///
    /// ```text
    ///   û = u − α k − K (x̂ ⊖ x),   x̂⁺ = f(x̂, û) ⊕ (α − 1) gap
    /// ```
    ///
    /// Writes it to `out` and returns its price, or nothing where a number is not finite.
    pub(super) fn run<D: Dynamics>(
        &mut self,
        problem: &Problem<D>,
        from: &Trajectory,
        stages: &[Stage],
        (first, alpha, penalty): (&[f64], f64, f64),
        worker: &mut Worker<D>,
        out: &mut Trajectory,
    ) -> Option<Price> {
        let dynamics = problem.dynamics();
        self.start(problem, from, (first, alpha), out);
        let mut sum = Price {
            cost: 0.0,
            merit: 0.0,
        };
        for (k, stage) in stages.iter().enumerate() {
            let (before, after) = out.states.split_at_mut(k + 1);
            let x = before[k].as_slice();
            if let Some(u) = out.inputs.get_mut(k) {
                dynamics.difference(from.states[k].as_slice(), x, &mut self.dx);
                let old = from.inputs[k].as_slice();
                apply_policy(stage, old, alpha, &self.dx, u.as_mut_slice());
                problem.clamp_input(u.as_mut_slice());
            }
            let u = out.inputs.get(k).map_or(&[][..], |u| u.as_slice());
            let point = StagePoint {
                problem,
                stage: k,
                x,
                u,
            };
            let price = price_of(&point, stage, penalty, worker);
            sum.cost += price.cost;
            sum.merit += price.merit;
            if !sum.merit.is_finite() {
                return None;
            }
            if let Some(next) = after.first_mut() {
                let next = next.as_mut_slice();
                worker.stepper.step(dynamics, x, u, &mut self.reached);
                self.leave_gap(dynamics, &stage.gap, alpha, next);
                if !next.iter().all(|x| x.is_finite()) {
                    return None;
                }
            }
        }
        Some(sum)
    }

    /// x̂₀ = start ⊕ (α − 1) (start ⊖ x₀), or x₀ ⊕ α δx₀ where it is free.
    fn start<D: Dynamics>(
        &mut self,
        problem: &Problem<D>,
        from: &Trajectory,
        (first, alpha): (&[f64], f64),
        out: &mut Trajectory,
    ) {
        let start = out.states[0].as_mut_slice();
        if problem.initial() == InitialState::Fixed {
            self.reached.copy_from_slice(problem.start().as_slice());
            self.leave_gap(problem.dynamics(), first, alpha, start);
        } else {
            self.share
                .iter_mut()
                .zip(first)
                .for_each(|(share, first)| *share = alpha * first);
            let x = from.states[0].as_slice();
            problem.dynamics().integrate(x, &self.share, start);
        }
    }

    /// out = reached ⊕ (α − 1) gap; exactly reached for the whole step.
    fn leave_gap<D: Dynamics>(&mut self, dynamics: &D, gap: &[f64], alpha: f64, out: &mut [f64]) {
        if alpha == 1.0 || gap.iter().all(|&gap| gap == 0.0) {
            return out.copy_from_slice(&self.reached);
        }
        for (share, gap) in self.share.iter_mut().zip(gap) {
            *share = (alpha - 1.0) * gap;
        }
        dynamics.integrate(&self.reached, &self.share, out);
    }
}

/// u − α k − K δx.
fn apply_policy(stage: &Stage, old: &[f64], alpha: f64, dx: &[f64], u: &mut [f64]) {
    let n = dx.len();
    for (i, (u, (old, k))) in u
        .iter_mut()
        .zip(old.iter().zip(&stage.feedforward))
        .enumerate()
    {
        *u = old - alpha * k - dot(&stage.gain_t[i * n..][..n], dx);
    }
}

/// The price of one stage.
pub(super) fn price_of<D: Dynamics>(
    point: &StagePoint<'_, D>,
    stage: &Stage,
    penalty: f64,
    worker: &mut Worker<D>,
) -> Price {
    let memory = &mut worker.memory;
    let cost = point.cost(memory);
    let merit = cost + point.penalties(&stage.lambda, penalty, memory);
    Price { cost, merit }
}
