//! The trajectory that was found, as a function of time.

use nalgebra::DVector;

use super::points::Points;
use crate::trajopt::any_problem::AnyProblem;
use crate::trajopt::any_system::AnySystem;
use crate::trajopt::scratch::Scratch;
use crate::trajopt::system::System;
use crate::trajopt::trajectory::Trajectory;

/// A trajectory in continuous time: on each interval the state a cubic in tangent coordinates of the interval's first node, the input
/// a parabola. At the points of the mesh it obeys the dynamics; between them to the order of the method.
///
/// [`Transcription`](super::Transcription) makes one.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// States at the nodes, N + 1 of length `nx`.
    pub states: Vec<DVector<f64>>,
    /// Inputs at the nodes, N + 1 of length `nu`.
    pub inputs: Vec<DVector<f64>>,
    /// States in the middle of the intervals, N of length `nx`.
    pub middle_states: Vec<DVector<f64>>,
    /// Inputs in the middle of the intervals, N of length `nu`.
    pub middle_inputs: Vec<DVector<f64>>,
    time_step: f64,
    arcs: Vec<Arc>,
}

/// The state over one interval, ξ with  x = first node ⊕ ξ.
#[derive(Clone, Debug, PartialEq)]
struct Arc {
    /// ξ at the end; at the start it is zero.
    span: DVector<f64>,
    /// ξ̇ at both ends.
    rates: [DVector<f64>; 2],
}

impl Curve {
    pub(super) fn new(problem: &dyn AnyProblem, points: &Points) -> Self {
        let every = |all: &[DVector<f64>], first: usize| -> Vec<_> {
            all.iter().skip(first).step_by(2).cloned().collect()
        };
        Self {
            states: every(&points.states, 0),
            inputs: every(&points.inputs, 0),
            middle_states: every(&points.states, 1),
            middle_inputs: every(&points.inputs, 1),
            time_step: problem.system().time_step(),
            arcs: (0..problem.horizon())
                .map(|k| Arc::new(problem.system(), points, k))
                .collect(),
        }
    }

    /// Duration from the first node to the last, s.
    pub fn duration(&self) -> f64 {
        self.time_step * self.arcs.len() as f64
    }

    /// The state at a time, s; before the start and after the end the state there. Allocates.
    ///
    /// * `dynamics` – the system of the problem
    pub fn state<D: System>(&self, dynamics: &D, time: f64) -> DVector<f64> {
        let Some((k, s)) = self.locate(time) else {
            return self.states[0].clone();
        };
        let (arc, h) = (&self.arcs[k], self.time_step);
        // Hermite's cubic with ξ(0) = 0:  (3 s² − 2 s³) ξ₁ + h (s³ − 2 s² + s) ξ̇₀ + h (s³ − s²) ξ̇₁
        let (s2, s3) = (s * s, s * s * s);
        let ends = &arc.rates[0] * (h * (s3 - 2.0 * s2 + s)) + &arc.rates[1] * (h * (s3 - s2));
        let xi = &arc.span * (3.0 * s2 - 2.0 * s3) + ends;
        let mut out = self.states[k].clone();
        let start = self.states[k].as_slice();
        dynamics.integrate(start, xi.as_slice(), out.as_mut_slice());
        out
    }

    /// The input at a time, s; before the start and after the end the input there. At the points of the mesh it is within its bounds;
    /// between them the parabola may leave them by a little. Allocates.
    pub fn input(&self, time: f64) -> DVector<f64> {
        let Some((k, s)) = self.locate(time) else {
            return self.inputs[0].clone();
        };
        let (first, last) = ((2.0 * s - 1.0) * (s - 1.0), s * (2.0 * s - 1.0));
        let middle = 4.0 * s * (1.0 - s);
        &self.inputs[k] * first + &self.middle_inputs[k] * middle + &self.inputs[k + 1] * last
    }

    /// The nodes: their states, and their inputs but for the last. Allocates.
    pub fn nodes(&self) -> Trajectory {
        Trajectory {
            states: self.states.clone(),
            inputs: self.inputs[..self.arcs.len()].to_vec(),
        }
    }

    /// The states at the nodes with the mean input over each interval: the guess for a solver whose inputs are constant over a step.
    /// Allocates.
    pub fn held(&self) -> Trajectory {
        let mean = |(k, middle): (usize, &DVector<f64>)| {
            (&self.inputs[k] + middle * 4.0 + &self.inputs[k + 1]) / 6.0
        };
        Trajectory {
            states: self.states.clone(),
            inputs: self.middle_inputs.iter().enumerate().map(mean).collect(),
        }
    }

    pub(super) fn check(&self, problem: &dyn AnyProblem) {
        self.nodes().check(problem);
    }

    /// The interval of a time, and the share of it that has passed; none where there are no intervals.
    fn locate(&self, time: f64) -> Option<(usize, f64)> {
        let last = self.arcs.len().checked_sub(1)?;
        let steps = (time / self.time_step).clamp(0.0, self.arcs.len() as f64);
        let k = (steps as usize).min(last);
        Some((k, steps - k as f64))
    }
}

impl Arc {
    /// Interval `k`.
    fn new(system: &dyn AnySystem, points: &Points, k: usize) -> Self {
        let (ndx, mut scratch) = (system.ndx(), Scratch::new());
        let [from, to] = [points.at(2 * k), points.at(2 * k + 2)];
        let mut span = DVector::zeros(ndx);
        system.difference(from.x, to.x, span.as_mut_slice());
        let [mut start, mut own, mut end] = [(); 3].map(|()| DVector::zeros(ndx));
        system.rate(from.x, from.u, &mut scratch, start.as_mut_slice());
        system.rate(to.x, to.u, &mut scratch, own.as_mut_slice());
        system.chart_rate(span.as_slice(), own.as_slice(), end.as_mut_slice());
        Self {
            span,
            rates: [start, end],
        }
    }
}
