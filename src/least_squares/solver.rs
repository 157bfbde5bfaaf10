//! The Levenberg–Marquardt method.

use nalgebra::DMatrix;

use super::system::System;
use super::{Iteration, Options, Residuals, Solution, Status};
use crate::stop::is_stopped;

/// Share of the predicted fall of the cost that a step must reach.
const ACCEPTABLE: f64 = 1e-4;
/// λ, beside the squared columns of the Jacobian, above which a step is only rounding.
const LARGEST_DAMPING: f64 = 1e20;
/// λ below which damping is nothing but rounding.
const LEAST_DAMPING: f64 = 1e-18;

/// Minimises ½ Σ ρ(rᵢ(x)²) from a start, within bounds. It always returns the best point found.
///
/// * `start` – initial variables; those beyond a bound are moved to it
///
/// # Panics
/// If an option is out of its range.
///
/// # Examples
/// ```
/// use dualbody::{Scalar, autodiff::VectorFunction, least_squares::{ByDuals, Options, solve}};
///
/// /// Rosenbrock's valley as residuals, zero at (1, 1).
/// struct Valley;
/// impl VectorFunction for Valley {
///     fn n_outputs(&self) -> usize {
///         2
///     }
///     fn eval<T: Scalar>(&self, x: &[T], r: &mut [T]) {
///         r[0] = (x[1] - x[0] * x[0]) * 10.0;
///         r[1] = -x[0] + 1.0;
///     }
/// }
/// let found = solve(&mut ByDuals::new(Valley), &[-1.2, 1.0], &Options::default());
/// assert!(found.is_converged(), "{found:?}");
/// assert!((found.x[0] - 1.0).abs() < 1e-12, "{found:?}");
/// ```
///
/// # References
/// [Levenberg 1944; Marquardt 1963; Moré 1978; Madsen, Nielsen, Tingleff 2004].
pub fn solve(residuals: &mut dyn Residuals, start: &[f64], options: &Options) -> Solution {
    solve_with(residuals, start, options, &mut |_| {})
}

/// [`solve`] with a report of each iteration.
///
/// # Panics
/// If an option is out of its range.
pub fn solve_with(
    residuals: &mut dyn Residuals,
    start: &[f64],
    options: &Options,
    report: &mut dyn FnMut(&Iteration),
) -> Solution {
    let directions = residuals.n_directions(start);
    options.check(start.len(), directions);
    let mut run = Run::new(residuals, start, options);
    let status = run.descend(report);
    run.finish(status)
}

/// A run of the method.
struct Run<'a> {
    residuals: &'a mut dyn Residuals,
    options: &'a Options,
    system: System,
    jacobian: DMatrix<f64>,
    x: Vec<f64>,
    r: Vec<f64>,
    cost: f64,
    trial_x: Vec<f64>,
    trial_r: Vec<f64>,
    damping: f64,
    /// Factor by which λ grows when the next step fails.
    growth: f64,
    history: Vec<f64>,
    /// Whether the quadratic model is that of `x`.
    is_modelled: bool,
}

/// Outcome of a step.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Outcome {
    Better,
    /// Better, but by no more than counts.
    Same,
    /// No step lowers the cost.
    None,
}

impl<'a> Run<'a> {
    fn new(residuals: &'a mut dyn Residuals, start: &[f64], options: &'a Options) -> Self {
        let (m, n) = (residuals.n_residuals(), residuals.n_directions(start));
        let mut x = start.to_vec();
        into_bounds(&mut x, options);
        let mut r = vec![0.0; m];
        residuals.residuals(&x, &mut r);
        let cost = cost(&r, options);
        Self {
            residuals,
            options,
            system: System::new(m, n),
            jacobian: DMatrix::zeros(m, n),
            trial_x: x.clone(),
            trial_r: r.clone(),
            x,
            r,
            cost,
            damping: options.damping,
            growth: 2.0,
            history: vec![cost],
            is_modelled: false,
        }
    }

    fn descend(&mut self, report: &mut dyn FnMut(&Iteration)) -> Status {
        for iteration in 1..=self.options.max_iterations {
            let is_modelled = !is_stopped() && self.linearize();
            if is_stopped() {
                return Status::Stopped;
            } else if !is_modelled {
                return Status::Diverged;
            }
            let gradient = self.system.largest_cosine(self.weighted_size());
            if gradient <= self.options.gradient_tolerance || self.is_within_errors() {
                return Status::Converged;
            }
            let outcome = self.improve();
            if is_stopped() {
                return Status::Stopped;
            }
            if outcome == Outcome::None {
                return self.without_step();
            }
            self.history.push(self.cost);
            report(&Iteration {
                iteration,
                cost: self.cost,
                gradient,
                damping: self.damping,
            });
            if outcome == Outcome::Same {
                return Status::Converged;
            }
        }
        Status::IterationLimit
    }

    /// Finds the quadratic model; `false` if it is not finite.
    fn linearize(&mut self) -> bool {
        if !self.cost.is_finite() {
            return false;
        }
        self.is_modelled = true;
        self.residuals.jacobian(&self.x, &mut self.jacobian);
        self.system.set(&self.r, &self.jacobian, self.options);
        self.system.bound(&self.x, self.options);
        self.system.is_finite()
    }

    /// Whether what a full step promises is nothing beside the errors that stay, by the tolerance of the relative offset.
    fn is_within_errors(&mut self) -> bool {
        let tolerance = self.options.offset_tolerance;
        let (m, n) = self.jacobian.shape();
        if tolerance <= 0.0 || m <= n {
            return false;
        }
        let Some(predicted) = self.system.step(LEAST_DAMPING) else {
            return false;
        };
        let to_spare = (m - n) as f64;
        predicted * to_spare <= tolerance * tolerance * n as f64 * (self.cost - predicted)
    }

    /// Takes the longest step that lowers the cost.
    fn improve(&mut self) -> Outcome {
        while self.damping < LARGEST_DAMPING && !is_stopped() {
            if let Some(predicted) = self.system.step(self.damping) {
                if self.is_short() || predicted <= 0.0 {
                    return Outcome::None;
                }
                if let Some(found) = self.try_step(predicted) {
                    return found;
                }
            }
            self.damping *= self.growth;
            self.growth *= 2.0;
        }
        Outcome::None
    }

    /// Goes along the step if that lowers the cost as predicted, or nearly.
    fn try_step(&mut self, predicted: f64) -> Option<Outcome> {
        self.residuals
            .retract(&self.x, self.system.d(), &mut self.trial_x);
        into_bounds(&mut self.trial_x, self.options);
        self.residuals.residuals(&self.trial_x, &mut self.trial_r);
        // Residuals returned after a stop signal are not valid.
        if is_stopped() {
            return None;
        }
        let trial = cost(&self.trial_r, self.options);
        let fall = self.cost - trial;
        let ratio = fall / predicted;
        // Not true of numbers that are not finite.
        if !(trial.is_finite() && ratio > ACCEPTABLE) {
            return None;
        }
        let least = self.options.cost_tolerance * self.cost;
        let outcome = match fall <= least && predicted <= least {
            true => Outcome::Same,
            false => Outcome::Better,
        };
        std::mem::swap(&mut self.x, &mut self.trial_x);
        std::mem::swap(&mut self.r, &mut self.trial_r);
        self.cost = trial;
        self.is_modelled = false;
        // [Nielsen 1999]: smoothly from a third, for steps that keep what they promised, to growth for those that do not.
        let factor = (1.0 - (2.0 * ratio - 1.0).powi(3)).clamp(1.0 / 3.0, 2.0);
        self.damping = (self.damping * factor).max(LEAST_DAMPING);
        self.growth = 2.0;
        Some(outcome)
    }

    /// Whether the step is too short to count.
    fn is_short(&self) -> bool {
        let size = match self.x.len() == self.system.d().len() {
            true => self.system.size(&self.x),
            // Points of a curved space have no size of their own.
            false => self.system.size(&vec![1.0; self.system.d().len()]),
        };
        self.system.size(self.system.d()) <= self.options.step_tolerance * size
    }

    /// Status where no step is found: at the least cost that rounding knows, or before.
    fn without_step(&mut self) -> Status {
        /// Share of the cost that rounding of the residuals may hide.
        const HIDDEN: f64 = 1e-12;
        match self.system.step(LEAST_DAMPING) {
            Some(predicted) if predicted <= HIDDEN * self.cost || self.is_short() => {
                Status::Converged
            }
            _ => Status::Stalled,
        }
    }

    /// ‖r‖ with the weights of the loss.
    fn weighted_size(&self) -> f64 {
        let loss = self.options.loss;
        let squares = self.r.iter().map(|r| loss.weight(r * r) * r * r);
        squares.sum::<f64>().sqrt()
    }

    fn finish(mut self, status: Status) -> Solution {
        // The model of the last point, for statistics.
        let is_known = match self.is_modelled {
            true => self.system.is_finite(),
            false if status == Status::Stopped => false,
            false => self.linearize(),
        };
        let directions = 0..self.jacobian.ncols();
        Solution {
            status,
            iterations: self.history.len() - 1,
            held: directions
                .filter(|&k| is_known && self.system.is_held(k))
                .collect(),
            normal_matrix: self.system.normal,
            x: self.x,
            residuals: self.r,
            cost: self.cost,
            history: self.history,
        }
    }
}

/// Moves variables that are beyond a bound onto it.
fn into_bounds(x: &mut [f64], options: &Options) {
    for (x, &lower) in x.iter_mut().zip(&options.lower) {
        *x = x.max(lower);
    }
    for (x, &upper) in x.iter_mut().zip(&options.upper) {
        *x = x.min(upper);
    }
}

/// ½ Σ ρ(r²)
fn cost(r: &[f64], options: &Options) -> f64 {
    let each = r.iter().map(|r| options.loss.value(r * r));
    0.5 * each.sum::<f64>()
}
