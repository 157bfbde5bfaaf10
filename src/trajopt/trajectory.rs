//! States and inputs over a horizon.

use std::io::{self, Write};

use nalgebra::DVector;

use super::lagrangian::StagePoint;
use super::problem::Problem;
use super::residual::ResidualJacobian;
use super::scratch::Scratch;
use crate::sim::write_row;

/// States x₀ … `x_N` and inputs u₀ … `u_(N−1)`: a guess, or the result of a solver. A guess need not satisfy the dynamics.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    /// The states, each of length `nx`, one more than there are inputs.
    pub states: Vec<DVector<f64>>,
    /// The inputs, each of length `nu`.
    pub inputs: Vec<DVector<f64>>,
}

impl Trajectory {
    /// Makes the zero-input guess: all inputs zero and all states equal to the start. It satisfies the dynamics only if the start is an equilibrium. Allocates.
    ///
    /// # Panics
    /// If a solver of the problem has no [memory](crate::memory).
    pub fn zero_input(problem: &Problem) -> Self {
        problem.assert_memory();
        let start = problem.start().clone();
        Self {
            states: vec![start; problem.horizon() + 1],
            inputs: vec![DVector::zeros(problem.dynamics().nu()); problem.horizon()],
        }
    }

    /// Makes the trajectory of a rollout from the start with these inputs, clamped to their bounds. Allocates.
    ///
    /// # Panics
    /// If the number of inputs differs from the number of steps, or one does not have length `nu`.
    pub fn rollout(problem: &Problem, inputs: &[DVector<f64>]) -> Self {
        let mut out = Self::zero_input(problem);
        assert_eq!(inputs.len(), problem.horizon(), "an input for every step");
        let mut scratch = Scratch::new();
        for (k, u) in inputs.iter().enumerate() {
            out.inputs[k].copy_from(u);
            problem.clamp_input(out.inputs[k].as_mut_slice());
            let (before, after) = out.states.split_at_mut(k + 1);
            let (x, next) = (before[k].as_slice(), after[0].as_mut_slice());
            let system = problem.dynamics();
            system.step(x, out.inputs[k].as_slice(), &mut scratch, next);
        }
        out
    }

    /// Computes the cost of the trajectory in a problem. Allocates.
    ///
    /// # Panics
    /// If it does not have the shape of the problem.
    pub fn cost(&self, problem: &Problem) -> f64 {
        self.check(problem);
        let mut memory = ResidualJacobian::new(problem.dynamics(), problem.largest_dim());
        let at = |stage| self.stage(problem, stage).cost(&mut memory);
        (0..self.states.len()).map(at).sum()
    }

    /// The largest violation of the constraints. Allocates.
    ///
    /// # Panics
    /// If it does not have the shape of the problem.
    pub fn violation(&self, problem: &Problem) -> f64 {
        self.check(problem);
        let mut memory = ResidualJacobian::new(problem.dynamics(), problem.largest_dim());
        self.largest_violation(problem, &mut memory)
    }

    /// Shifts the trajectory by one stage and repeats the last state and input: the guess for the next problem of a receding horizon.
    pub(crate) fn shift(&mut self) {
        for all in [&mut self.states, &mut self.inputs] {
            for k in 1..all.len() {
                let (before, after) = all.split_at_mut(k);
                before[k - 1].copy_from(&after[0]);
            }
        }
    }

    /// Writes one row per state: time, `x0`, `x1`, …, and the input from there to the next state (empty in the last row).
    ///
    /// # Errors
    /// If writing fails.
    pub fn write_csv(&self, time_step: f64, mut out: impl Write) -> io::Result<()> {
        let nu = self.inputs.first().map_or(0, |u| u.len());
        let nx = self.states.first().map_or(0, |x| x.len());
        let names = (0..nx).map(|i| format!(",x{i}"));
        let names = names.chain((0..nu).map(|i| format!(",u{i}")));
        writeln!(out, "time{}", names.collect::<String>())?;
        for (k, x) in self.states.iter().enumerate() {
            let time = k as f64 * time_step;
            write_row(&mut out, time, x, self.inputs.get(k), nu)?;
        }
        Ok(())
    }

    /// [`violation`](Self::violation) without allocation.
    pub(super) fn largest_violation(
        &self,
        problem: &Problem,
        memory: &mut ResidualJacobian,
    ) -> f64 {
        let at = |stage| self.stage(problem, stage).violation(memory);
        (0..self.states.len()).map(at).fold(0.0, f64::max)
    }

    /// A stage where the trajectory passes it.
    pub(super) fn stage<'a>(&'a self, problem: &'a Problem, stage: usize) -> StagePoint<'a> {
        StagePoint {
            problem,
            stage,
            x: self.states[stage].as_slice(),
            u: self.input(stage),
        }
    }

    /// The input of a stage; none at the end.
    pub(super) fn input(&self, stage: usize) -> &[f64] {
        self.inputs.get(stage).map_or(&[], |u| u.as_slice())
    }

    pub(super) fn check(&self, problem: &Problem) {
        let (n, system) = (problem.horizon(), problem.dynamics());
        let (nx, nu) = (system.nx(), system.nu());
        assert_eq!(
            self.states.len(),
            n + 1,
            "a horizon of {n} steps has one state more than steps"
        );
        assert_eq!(
            self.inputs.len(),
            n,
            "a horizon of {n} steps has as many inputs"
        );
        let states_fit = self.states.iter().all(|x| x.len() == nx);
        assert!(states_fit, "a state has nx = {nx} numbers");
        let inputs_fit = self.inputs.iter().all(|u| u.len() == nu);
        assert!(inputs_fit, "an input has nu = {nu} numbers");
    }

    pub(super) fn copy_from(&mut self, other: &Self) {
        let states = self.states.iter_mut().zip(&other.states);
        let inputs = self.inputs.iter_mut().zip(&other.inputs);
        states
            .chain(inputs)
            .for_each(|(x, other)| x.copy_from(other));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::SAME_ALGEBRA;
    use crate::trajopt::tests::{A, B, LAST, Q, R, START, linear_quadratic};

    fn rolled() -> (Problem, Trajectory) {
        let problem = linear_quadratic(2);
        let inputs = [0.5, -1.0].map(|u| DVector::from_element(1, u));
        let trajectory = Trajectory::rollout(&problem, &inputs);
        (problem, trajectory)
    }

    #[test]
    fn rollout_and_its_cost_equal_the_closed_form() {
        let (problem, trajectory) = rolled();
        let x1 = A * START + B * 0.5;
        let x2 = A * x1 - B;
        assert_eq!(trajectory.states[1][0], x1);
        assert_eq!(trajectory.states[2][0], x2);
        let running = Q * (START * START + x1 * x1) + R * (0.25 + 1.0);
        let cost = 0.5 * (running + LAST * x2 * x2);
        assert!((trajectory.cost(&problem) - cost).abs() < SAME_ALGEBRA);
        assert_eq!(trajectory.violation(&problem), 0.0);
    }

    #[test]
    fn zero_input_guess_stays_at_the_start() {
        let problem = linear_quadratic(3);
        let guess = Trajectory::zero_input(&problem);
        assert!(guess.states.iter().all(|x| x[0] == START));
        assert!(guess.inputs.iter().all(|u| u[0] == 0.0));
    }

    #[test]
    fn shifted_trajectory_repeats_its_end() {
        let (_, mut trajectory) = rolled();
        let before = trajectory.clone();
        trajectory.shift();
        assert_eq!(trajectory.states[..2], before.states[1..]);
        assert_eq!(trajectory.states[2], before.states[2]);
        assert_eq!(
            trajectory.inputs,
            [before.inputs[1].clone(), before.inputs[1].clone()]
        );
    }

    #[test]
    fn table_has_a_row_a_state_and_no_input_at_the_end() {
        let (_, mut trajectory) = rolled();
        trajectory.states[1][0] = 0.25;
        trajectory.states[2][0] = -2.0;
        let mut table = Vec::new();
        trajectory.write_csv(0.5, &mut table).unwrap();
        let table = String::from_utf8(table).unwrap();
        assert_eq!(table, "time,x0,u0\n0,1.5,0.5\n0.5,0.25,-1\n1,-2,\n");
    }

    #[test]
    #[should_panic(expected = "an input for every step")]
    fn rollout_of_too_few_inputs_is_refused() {
        Trajectory::rollout(&linear_quadratic(2), &[DVector::zeros(1)]);
    }
}
