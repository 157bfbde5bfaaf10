//! The points of a mesh: nodes, and the middles between them.

use nalgebra::DVector;

use crate::trajopt::cost::{Expansion, Point};
use crate::trajopt::problem::{InitialState, Problem};
use crate::trajopt::residual::ResidualJacobian;
use crate::trajopt::system::AnySystem;
use crate::trajopt::trajectory::Trajectory;

/// States and inputs at 2 N + 1 points in time: node k is point 2 k, the middle of interval k is point 2 k + 1.
#[derive(Clone, Debug)]
pub(super) struct Points {
    pub(super) states: Vec<DVector<f64>>,
    pub(super) inputs: Vec<DVector<f64>>,
}

/// State and input at a point.
#[derive(Clone, Copy)]
pub(super) struct Sample<'a> {
    pub(super) x: &'a [f64],
    pub(super) u: &'a [f64],
}

/// Shares of an interval in the integral of a cost, by Simpson's rule.
const SIMPSON: [f64; 3] = [1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0];

impl Points {
    /// A guess, half-way between its nodes where it has no middles; the last node takes the last input.
    pub(super) fn from_trajectory(problem: &Problem, guess: &Trajectory) -> Self {
        let (system, n) = (problem.dynamics(), problem.horizon());
        let last = match guess.inputs.last() {
            Some(u) => u.clone(),
            None => DVector::zeros(system.nu()),
        };
        let mut out = Self {
            states: Vec::with_capacity(2 * n + 1),
            inputs: Vec::with_capacity(2 * n + 1),
        };
        for k in 0..n {
            let next = guess.inputs.get(k + 1).unwrap_or(&last);
            let (from, to) = (&guess.states[k], &guess.states[k + 1]);
            out.states
                .extend([from.clone(), half_way(system, from, to)]);
            let middle = (&guess.inputs[k] + next) * 0.5;
            out.inputs.extend([guess.inputs[k].clone(), middle]);
        }
        out.states.push(guess.states[n].clone());
        out.inputs.push(last);
        out.prepare(problem);
        out
    }

    /// States and inputs at nodes, and in the middle between them.
    pub(super) fn interleaved(
        problem: &Problem,
        [states, middle_states]: [&[DVector<f64>]; 2],
        [inputs, middle_inputs]: [&[DVector<f64>]; 2],
    ) -> Self {
        let mut out = Self {
            states: interleave(states, middle_states),
            inputs: interleave(inputs, middle_inputs),
        };
        out.prepare(problem);
        out
    }

    /// Moves the first state to the start, if that is given, and the inputs into their bounds.
    fn prepare(&mut self, problem: &Problem) {
        if problem.initial() == InitialState::Fixed {
            self.states[0].copy_from_slice(problem.start().as_slice());
        }
        for u in &mut self.inputs {
            problem.clamp_input(u.as_mut_slice());
        }
    }

    /// Number of points.
    pub(super) fn len(&self) -> usize {
        self.states.len()
    }

    pub(super) fn at(&self, i: usize) -> Sample<'_> {
        Sample {
            x: self.states[i].as_slice(),
            u: self.inputs[i].as_slice(),
        }
    }

    /// Points (x ⊕ α δx, u + α δu), inputs within their bounds, the first state at the start if that is given.
    ///
    /// * `dz` – (δx, δu) of one point after the other
    pub(super) fn step(&self, problem: &Problem, dz: &[f64], alpha: f64, out: &mut Self) {
        let (system, ndx) = (problem.dynamics(), problem.dynamics().ndx());
        let nz = ndx + system.nu();
        let mut dx = vec![0.0; ndx];
        for i in 0..self.len() {
            let dz = &dz[i * nz..(i + 1) * nz];
            let both = dx.iter_mut().zip(dz);
            both.for_each(|(dx, &dz)| *dx = alpha * dz);
            let Sample { x, u } = self.at(i);
            system.integrate(x, dx.as_slice(), out.states[i].as_mut_slice());
            let moved = out.inputs[i].iter_mut().zip(u).zip(&dz[ndx..]);
            moved.for_each(|((out, &u), &du)| *out = u + alpha * du);
        }
        out.prepare(problem);
    }

    pub(super) fn is_finite(&self) -> bool {
        let all = self.states.iter().chain(&self.inputs).flatten();
        all.into_iter().all(|x| x.is_finite())
    }
}

/// The interval whose stage counts at a point: that which it is in, the last for the last node.
pub(super) fn stage_of(problem: &Problem, i: usize) -> usize {
    (i / 2).min(problem.horizon().saturating_sub(1))
}

/// The stages that a point's running cost counts for, each with its share of the integral, s.
///
/// A node ends one interval and begins the next; so what a cost does at a stage, it does over the whole of that
/// interval.
fn shares(problem: &Problem, i: usize) -> impl Iterator<Item = (usize, f64)> + use<> {
    let (n, h) = (problem.horizon(), problem.dynamics().time_step());
    let is_node = i.is_multiple_of(2);
    let ends = (is_node && i > 0).then(|| (i / 2 - 1, h * SIMPSON[2]));
    let own = if is_node { SIMPSON[0] } else { SIMPSON[1] };
    let begins = (i / 2 < n).then_some((i / 2, h * own));
    ends.into_iter().chain(begins)
}

/// The costs of a point.
pub(super) fn cost(
    problem: &Problem,
    i: usize,
    Sample { x, u }: Sample<'_>,
    memory: &mut ResidualJacobian,
) -> f64 {
    let value = |stage: usize, u: &[f64], memory: &mut ResidualJacobian| {
        problem
            .cost_at(stage)
            .evaluate(at(problem, stage, x, u), memory)
    };
    let running = shares(problem, i).map(|(stage, share)| share * value(stage, u, memory));
    let mut sum = running.sum::<f64>();
    if i == 2 * problem.horizon() {
        sum += value(problem.horizon(), &[], memory);
    }
    sum
}

/// The costs of a point to second order, of the Hessian the upper triangle, as Gauss and Newton have it.
pub(super) fn expand_cost(
    problem: &Problem,
    i: usize,
    Sample { x, u }: Sample<'_>,
    memory: &mut ResidualJacobian,
    out: &mut Expansion,
) {
    out.clear();
    let mut add = |stage: usize, u: &[f64], share: f64| {
        let at = at(problem, stage, x, u);
        problem.cost_at(stage).add_expansion(at, share, memory, out);
    };
    shares(problem, i).for_each(|(stage, share)| add(stage, u, share));
    if i == 2 * problem.horizon() {
        add(problem.horizon(), &[], 1.0);
    }
}

/// Point at which residuals of a stage are evaluated.
fn at<'a>(problem: &'a Problem, stage: usize, x: &'a [f64], u: &'a [f64]) -> Point<'a> {
    Point::new(problem.dynamics(), problem.stage_of_motion(stage), x, u)
}

fn half_way(system: &dyn AnySystem, from: &DVector<f64>, to: &DVector<f64>) -> DVector<f64> {
    let mut dx = vec![0.0; system.ndx()];
    system.difference(from.as_slice(), to.as_slice(), dx.as_mut_slice());
    dx.iter_mut().for_each(|dx| *dx *= 0.5);
    let mut out = from.clone();
    system.integrate(from.as_slice(), dx.as_slice(), out.as_mut_slice());
    out
}

fn interleave(nodes: &[DVector<f64>], middles: &[DVector<f64>]) -> Vec<DVector<f64>> {
    let mut out = Vec::with_capacity(nodes.len() + middles.len());
    for (k, node) in nodes.iter().enumerate() {
        out.push(node.clone());
        out.extend(middles.get(k).cloned());
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::ROUNDING;
    use crate::trajopt::tests::{START, linear_quadratic};

    // Simpson's rule is exact for cubics: Σ shares · t³ = ∫ t³ dt = N⁴ / 4 with steps of one second.
    #[test]
    fn shares_of_the_points_integrate_cubics_exactly() {
        const N: usize = 3;
        let problem = linear_quadratic(N);
        let mut sum = 0.0;
        let mut by_stage = [0.0; N];
        for i in 0..=2 * N {
            let t = 0.5 * i as f64;
            for (stage, share) in shares(&problem, i) {
                by_stage[stage] += share;
                sum += share * t.powi(3);
            }
        }
        assert!((sum - (N as f64).powi(4) / 4.0).abs() < 10.0 * ROUNDING);
        assert!(by_stage.iter().all(|share| (share - 1.0).abs() < ROUNDING));
    }

    #[test]
    fn middles_of_a_guess_are_half_way_between_its_nodes() {
        let problem = linear_quadratic(2);
        let column = |x: f64| DVector::from_element(1, x);
        let guess = Trajectory {
            states: [0.0, 2.0, 6.0].map(column).to_vec(),
            inputs: [1.0, 3.0].map(column).to_vec(),
        };
        let points = Points::from_trajectory(&problem, &guess);
        let states: Vec<f64> = points.states.iter().map(|x| x[0]).collect();
        let inputs: Vec<f64> = points.inputs.iter().map(|u| u[0]).collect();
        // The first state is given.
        assert_eq!(states, [START, 1.0, 2.0, 4.0, 6.0]);
        assert_eq!(inputs, [1.0, 2.0, 3.0, 3.0, 3.0]);
    }
}
