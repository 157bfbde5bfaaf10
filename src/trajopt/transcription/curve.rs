//! A trajectory as a function of time.

use nalgebra::DVector;

use super::points::Points;
use crate::trajopt::problem::Problem;
use crate::trajopt::scratch::Scratch;
use crate::trajopt::system::{AnySystem, AsSystem};
use crate::trajopt::trajectory::Trajectory;

/// A trajectory in continuous time. On each interval the state is a cubic in tangent coordinates of the first node, and the input is a parabola. It
/// satisfies the dynamics at the points of the mesh, and between them to the order of the method.
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
    pub(super) fn new(problem: &Problem, points: &Points) -> Self {
        let every = |all: &[DVector<f64>], first: usize| -> Vec<_> {
            all.iter().skip(first).step_by(2).cloned().collect()
        };
        Self {
            states: every(&points.states, 0),
            inputs: every(&points.inputs, 0),
            middle_states: every(&points.states, 1),
            middle_inputs: every(&points.inputs, 1),
            time_step: problem.dynamics().time_step(),
            arcs: (0..problem.horizon())
                .map(|k| Arc::new(problem.dynamics(), points, k))
                .collect(),
        }
    }

    /// Makes the curve through given points, such as those of a saved solution. Its first state is moved to the given start, and inputs are clamped
    /// to their bounds.
    ///
    /// * `states`, `inputs` – at the N + 1 nodes, and in the middle of the N intervals
    ///
    /// # Panics
    /// If the points do not have the shape of the problem, or the system has no rate.
    pub fn from_points(
        problem: &Problem,
        states: [&[DVector<f64>]; 2],
        inputs: [&[DVector<f64>]; 2],
    ) -> Self {
        let (n, system) = (problem.horizon(), problem.dynamics());
        let of = [
            ("state", states, system.nx()),
            ("input", inputs, system.nu()),
        ];
        for (name, [nodes, middles], size) in of {
            let counts = (nodes.len(), middles.len());
            assert_eq!(counts, (n + 1, n), "{name}s at nodes and in middles");
            let fit = nodes.iter().chain(middles).all(|x| x.len() == size);
            assert!(fit, "each {name} has {size} numbers");
        }
        Self::new(problem, &Points::interleaved(problem, states, inputs))
    }

    /// Duration from the first node to the last, s.
    pub fn duration(&self) -> f64 {
        self.time_step * self.arcs.len() as f64
    }

    /// The state at a time, s; before the start and after the end the first and last state. Allocates.
    ///
    /// * `dynamics` – the system of the problem
    pub fn state(&self, dynamics: &(impl AsSystem + ?Sized), time: f64) -> DVector<f64> {
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
        let system = dynamics.as_system();
        system.integrate(start, xi.as_slice(), out.as_mut_slice());
        out
    }

    /// The input at a time, s; before the start and after the end the first and last input. At the points of the mesh it is within its bounds;
    /// between them the parabola may exceed them slightly. Allocates.
    pub fn input(&self, time: f64) -> DVector<f64> {
        let Some((k, s)) = self.locate(time) else {
            return self.inputs[0].clone();
        };
        let (first, last) = ((2.0 * s - 1.0) * (s - 1.0), s * (2.0 * s - 1.0));
        let middle = 4.0 * s * (1.0 - s);
        &self.inputs[k] * first + &self.middle_inputs[k] * middle + &self.inputs[k + 1] * last
    }

    /// The states at the nodes, and the inputs at all nodes except the last. Allocates.
    pub fn nodes(&self) -> Trajectory {
        Trajectory {
            states: self.states.clone(),
            inputs: self.inputs[..self.arcs.len()].to_vec(),
        }
    }

    /// The states at the nodes with the mean input of each interval: a guess for solvers with constant inputs over a step. Allocates.
    pub fn held(&self) -> Trajectory {
        let mean = |(k, middle): (usize, &DVector<f64>)| {
            (&self.inputs[k] + middle * 4.0 + &self.inputs[k + 1]) / 6.0
        };
        Trajectory {
            states: self.states.clone(),
            inputs: self.middle_inputs.iter().enumerate().map(mean).collect(),
        }
    }

    pub(super) fn check(&self, problem: &Problem) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::ROUNDING;
    use crate::trajopt::tests::{Decay, linear_quadratic};

    // ẋ = u with u = 3 t² − 4 t + 1 and x = t³ − 2 t² + t + 1.5: a parabola and a cubic, which the curve has exactly.
    #[test]
    fn cubic_and_parabola_are_reproduced_between_the_points() {
        let problem = linear_quadratic(3);
        let input = |t: f64| 3.0 * t * t - 4.0 * t + 1.0;
        let state = |t: f64| t * t * t - 2.0 * t * t + t + 1.5;
        let column = |x: f64| DVector::from_element(1, x);
        let at = |f: &dyn Fn(f64) -> f64, first: f64, n: usize| -> Vec<DVector<f64>> {
            (0..n).map(|k| column(f(first + k as f64))).collect()
        };
        let states = [at(&state, 0.0, 4), at(&state, 0.5, 3)];
        let inputs = [at(&input, 0.0, 4), at(&input, 0.5, 3)];
        let points =
            Points::interleaved(&problem, [&states[0], &states[1]], [&inputs[0], &inputs[1]]);
        let curve = Curve::new(&problem, &points);
        assert_eq!(curve.duration(), 3.0);
        for k in 0..=30 {
            let t = 0.1 * f64::from(k);
            let (x, u) = (curve.state(&Decay, t)[0], curve.input(t)[0]);
            assert!((x - state(t)).abs() < 20.0 * ROUNDING, "{t}: {x}");
            assert!((u - input(t)).abs() < 20.0 * ROUNDING, "{t}: {u}");
        }
        let again = Curve::from_points(
            &problem,
            [&curve.states, &curve.middle_states],
            [&curve.inputs, &curve.middle_inputs],
        );
        assert_eq!(again, curve);
        // Beyond the ends it stays; over an interval the mean input moves the state as far as the parabola.
        assert_eq!(curve.state(&Decay, -1.0), curve.states[0]);
        assert!((curve.state(&Decay, 9.0)[0] - state(3.0)).abs() < 20.0 * ROUNDING);
        for (k, u) in curve.held().inputs.iter().enumerate() {
            let change = state(k as f64 + 1.0) - state(k as f64);
            assert!((u[0] - change).abs() < 10.0 * ROUNDING);
        }
    }
}
