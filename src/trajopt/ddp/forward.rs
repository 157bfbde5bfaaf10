//! The forward pass: the policy with the true dynamics; gaps are closed in proportion to the step.

use super::stage::{Stage, StageScratch};
use crate::linalg::product::dot;
use crate::trajopt::constraint::Multipliers;
use crate::trajopt::lagrangian::StagePoint;
use crate::trajopt::problem::{InitialState, Problem};
use crate::trajopt::system::AnySystem;
use crate::trajopt::trajectory::Trajectory;

/// Cost and merit of a trajectory.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Merit {
    /// The costs of the problem.
    pub(super) cost: f64,
    /// Cost with the penalties of the constraints.
    pub(super) merit: f64,
}

/// A step along the policy.
#[derive(Clone, Copy, Debug)]
pub(super) struct Along<'a> {
    /// Change of the first state: the gap to the given one, or the optimal step.
    pub(super) first: &'a [f64],
    /// The share of the step.
    pub(super) alpha: f64,
    /// μ of the penalties.
    pub(super) penalty: f64,
}

/// Working memory of the forward pass.
#[derive(Clone, Debug)]
pub(super) struct Forward {
    dx: Vec<f64>,
    share: Vec<f64>,
    reached: Vec<f64>,
}

impl Forward {
    pub(super) fn new(problem: &Problem) -> Self {
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
    /// Writes it to `out` and returns its merit, or nothing where a number is not finite.
    pub(super) fn run(
        &mut self,
        problem: &Problem,
        from: &Trajectory,
        stages: &[Stage],
        along: &Along<'_>,
        scratch: &mut StageScratch,
        out: &mut Trajectory,
    ) -> Option<Merit> {
        let (system, alpha) = (problem.dynamics(), along.alpha);
        self.start(problem, from, along, out);
        let mut sum = Merit::default();
        for (k, stage) in stages.iter().enumerate() {
            let (before, after) = out.states.split_at_mut(k + 1);
            let x = before[k].as_slice();
            if let Some(u) = out.inputs.get_mut(k) {
                system.difference(from.states[k].as_slice(), x, self.dx.as_mut_slice());
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
            let own = merit_of(&point, stage, along.penalty, scratch);
            sum.cost += own.cost;
            sum.merit += own.merit;
            if !sum.merit.is_finite() {
                return None;
            }
            if let Some(next) = after.first_mut() {
                let next = next.as_mut_slice();
                system.step(x, u, &mut scratch.system, self.reached.as_mut_slice());
                self.leave_gap(system, &stage.gap, alpha, next);
                if !next.iter().all(|x| x.is_finite()) {
                    return None;
                }
            }
        }
        Some(sum)
    }

    /// x̂₀ = start ⊕ (α − 1) (start ⊖ x₀), or x₀ ⊕ α δx₀ where it is free.
    fn start(
        &mut self,
        problem: &Problem,
        from: &Trajectory,
        &Along { first, alpha, .. }: &Along<'_>,
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
            problem
                .dynamics()
                .integrate(x, self.share.as_slice(), start);
        }
    }

    /// out = reached ⊕ (α − 1) gap; exactly reached for the whole step.
    fn leave_gap(&mut self, system: &dyn AnySystem, gap: &[f64], alpha: f64, out: &mut [f64]) {
        if alpha == 1.0 || gap.iter().all(|&gap| gap == 0.0) {
            return out.copy_from_slice(&self.reached);
        }
        for (share, gap) in self.share.iter_mut().zip(gap) {
            *share = (alpha - 1.0) * gap;
        }
        system.integrate(self.reached.as_slice(), self.share.as_slice(), out);
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

/// The merit of one stage.
pub(super) fn merit_of(
    point: &StagePoint<'_>,
    stage: &Stage,
    penalty: f64,
    scratch: &mut StageScratch,
) -> Merit {
    let memory = &mut scratch.memory;
    let cost = point.cost(memory);
    let multipliers = Multipliers {
        lambda: &stage.lambda,
        mu: penalty,
    };
    let merit = cost + point.penalties(&multipliers, memory);
    Merit { cost, merit }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{ROUNDING, SAME_ALGEBRA};
    use crate::trajopt::tests::{A, B, Q, R, START, linear_quadratic};

    // û = u − α k − K δx
    #[test]
    fn policy_equals_its_formula() {
        let problem = linear_quadratic(1);
        let mut stage = Stage::new(&problem, 0);
        (stage.feedforward, stage.gain_t) = (vec![4.0, -1.0], vec![1.0, 2.0, 3.0, 5.0]);
        let mut u = [0.0; 2];
        apply_policy(&stage, &[10.0, 20.0], 0.5, &[0.1, 0.2], &mut u);
        // 10 − 2 − (0.1 + 0.4),  20 + 0.5 − (0.3 + 1)
        assert!((u[0] - 7.5).abs() < 10.0 * ROUNDING && (u[1] - 19.2).abs() < 10.0 * ROUNDING);
    }

    // With the gap d of a planned state, the whole step lands on what the dynamics reach, half a step leaves half of
    // the gap.
    #[test]
    fn share_of_a_step_leaves_that_share_of_a_gap() {
        let problem = linear_quadratic(1);
        let mut from = Trajectory::zero_input(&problem);
        from.states[1][0] = -1.0;
        let reached = A * START;
        let mut stages = [Stage::new(&problem, 0), Stage::new(&problem, 1)];
        stages[0].gap[0] = reached - from.states[1][0];
        let mut scratch = StageScratch::new(&problem);
        for alpha in [1.0, 0.5] {
            let mut out = from.clone();
            let along = Along {
                first: &[0.0],
                alpha,
                penalty: 1.0,
            };
            let merit = Forward::new(&problem)
                .run(&problem, &from, &stages, &along, &mut scratch, &mut out)
                .unwrap();
            let expected = reached + (alpha - 1.0) * stages[0].gap[0];
            assert!((out.states[1][0] - expected).abs() < ROUNDING);
            let last = 0.5 * crate::trajopt::tests::LAST * expected * expected;
            assert!((merit.cost - (0.5 * Q * START * START + last)).abs() < SAME_ALGEBRA);
            assert_eq!(merit.cost, merit.merit);
        }
        // An input moves the end by b and costs ½ R u².
        stages[0].feedforward[0] = -2.0;
        stages[0].gap[0] = 0.0;
        let along = Along {
            first: &[0.0],
            alpha: 1.0,
            penalty: 1.0,
        };
        let mut out = from.clone();
        let merit = Forward::new(&problem)
            .run(&problem, &from, &stages, &along, &mut scratch, &mut out)
            .unwrap();
        let end = A * START + 2.0 * B;
        let costs = 0.5 * (Q * START * START + 4.0 * R + crate::trajopt::tests::LAST * end * end);
        assert!((merit.cost - costs).abs() < SAME_ALGEBRA);
    }
}
