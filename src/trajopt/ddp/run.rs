//! The run of the solver: from the guess to the solution.

use super::Ddp;
use super::backward::Limits;
use crate::minimize::Status;
use crate::trajopt::problem::Problem;
use crate::trajopt::progress::Progress;
use crate::trajopt::solution::Solution;
use crate::trajopt::trajectory::Trajectory;

impl Ddp {
    /// Optimises from a guess, into the solution.
    pub(super) fn run(
        &mut self,
        problem: &Problem,
        guess: &Trajectory,
        report: &mut dyn FnMut(&Progress),
    ) {
        guess.check(problem);
        assert_eq!(self.stages.len(), problem.horizon() + 1, "the horizon");
        self.solution.trajectory.copy_from(guess);
        for u in &mut self.solution.trajectory.inputs {
            problem.clamp_input(u.as_mut_slice());
        }
        let is_finite = self.begin(problem);
        self.solution.status = if !self.options.curvature.is_known_of(problem.dynamics()) {
            Status::NoStepHessian
        } else if is_finite {
            self.iterate(problem, report)
        } else {
            Status::Diverged
        };
        self.hand_out_gains();
        self.hand_out_multipliers(problem);
    }

    /// Resets the data of the last solution, computes gaps and merit of the guess; `false` if they are not finite.
    fn begin(&mut self, problem: &Problem) -> bool {
        self.regularization = self.options.regularization.start;
        self.penalty = self.options.constraints.penalty;
        self.solution.iterations = 0;
        self.solution.cost_history.clear();
        for stage in &mut self.stages {
            stage.lambda.fill(0.0);
        }
        (self.has_gaps, self.limits) = (true, Limits::Untried);
        self.update_merit(problem);
        let cost = self.solution.cost;
        self.solution.cost_history.push(cost);
        let states = &self.solution.trajectory.states;
        self.merit.is_finite() && states.iter().flatten().all(|x| x.is_finite())
    }

    /// The gains in the form in which they are handed out.
    fn hand_out_gains(&mut self) {
        let n = self.first_gap.len();
        for (gain, stage) in self.solution.own.gains.iter_mut().zip(&self.stages) {
            for (i, column) in stage.gain_t.chunks_exact(n.max(1)).enumerate() {
                let row = gain.row_mut(i).into_iter();
                row.zip(column).for_each(|(gain, &k)| *gain = k);
            }
        }
    }

    /// The multipliers after one more update.
    fn hand_out_multipliers(&mut self, problem: &Problem) {
        let memory = &mut self.scratches[0].memory;
        let Solution {
            trajectory,
            multipliers,
            ..
        } = &mut self.solution;
        for (k, (out, stage)) in multipliers.iter_mut().zip(&self.stages).enumerate() {
            out.copy_from_slice(&stage.lambda);
            let point = trajectory.stage(problem, k);
            point.update_multipliers(out.as_mut_slice(), self.penalty, memory);
        }
    }
}
