//! Runs argmin: one run after another while they improve.

use argmin::solver::gradientdescent::SteepestDescent;
use argmin::solver::linesearch::condition::ArmijoCondition;
use argmin::solver::linesearch::{BacktrackingLineSearch, MoreThuenteLineSearch};
use argmin::solver::newton::NewtonCG;
use argmin::solver::quasinewton::LBFGS;
use argmin::solver::trustregion::{Steihaug, TrustRegion};

use super::objective::Objective;
use super::status::Status;
use super::watch::{Iteration, Limits, Watch};
use super::{MinimizeOptions, Minimizer, Minimum};
use crate::memory;
use crate::stop::is_stopped;

/// Iterations without improvement that line searches are given: a second one starts from the same point.
const STALL_LIMIT: usize = 2;
/// A radius of trust shrinks to a quarter at each failure; this many lead from any to nothing.
const TRUST_STALL_LIMIT: usize = 30;
/// argmin's Newton-CG ends its inner iterations at  ‖r‖² ≤ ½ ‖g‖  (residual and gradient), which for small gradients is
/// before the first: costs this many times larger make it  ‖r‖² ≤ ½ ‖g‖ / scale.
const NEWTON_SCALE: f64 = 1e9;
/// A run that improves the cost by less than this share of 1 + |cost| is not repeated.
const WORTHWHILE: f64 = 1e-12;
/// Share of the expected decrease that a backtracking step has to keep.
const ARMIJO: f64 = 1e-4;
/// A radius of trust never grows beyond this.
const MAX_RADIUS: f64 = 1e6;

/// A function and how it is minimised.
pub(crate) struct Run<'a> {
    pub(crate) objective: &'a dyn Objective,
    pub(crate) minimizer: Minimizer,
    pub(crate) options: &'a MinimizeOptions,
}

impl Run<'_> {
    /// One run after another, each from where the one before ended; what was found, and how it went, into `out`.
    ///
    /// The first step of a line search along a gradient is as long as that. Where that leads nowhere, the next run sees
    /// the function in units in which the gradient is one.
    pub(crate) fn descend(
        &self,
        tolerance: f64,
        out: &mut Minimum,
        report: &mut dyn FnMut(&Iteration),
    ) {
        let mut scale = 1.0;
        loop {
            if is_stopped() {
                out.status = Status::Stopped;
                return;
            }
            out.value = self.objective.value(&out.x);
            let before = out.value;
            let limits = self.limits(tolerance, scale);
            let watch = Watch::new(self.objective, limits, out, report);
            self.run(&watch);
            let (status, gradient) = watch.end();
            let worthwhile = before - out.value > WORTHWHILE * (1.0 + out.value.abs());
            let is_over = out.iterations >= self.options.max_iterations;
            out.status = match status {
                _ if is_stopped() => Status::Stopped,
                Some(Status::Converged) => Status::Converged,
                Some(Status::Diverged) => Status::Diverged,
                _ if is_over => Status::IterationLimit,
                None | Some(Status::LineSearchStalled) if worthwhile => {
                    scale = if scale == 1.0 { 1.0 } else { 1.0 / gradient };
                    continue;
                }
                _ if scale == 1.0 && self.steps_along_gradients() && is_large(gradient) => {
                    scale = 1.0 / gradient;
                    continue;
                }
                status => status.unwrap_or(Status::LineSearchStalled),
            };
            return;
        }
    }

    /// Gradients that L-BFGS remembers, one of each iteration at most.
    ///
    /// # Panics
    /// If there is no memory for their list.
    fn remembered(&self) -> usize {
        let most = self.options.max_iterations.max(1);
        let count = self.options.memory.min(most);
        // Steps, and changes of the gradient.
        let bytes = count.saturating_mul(2 * size_of::<Vec<f64>>());
        match memory::check(
            format_args!("{count} gradients that L-BFGS remembers"),
            bytes,
        ) {
            Ok(()) => count,
            Err(error) => panic!("{error}"),
        }
    }

    fn steps_along_gradients(&self) -> bool {
        matches!(
            self.minimizer,
            Minimizer::Lbfgs | Minimizer::SteepestDescent
        )
    }

    fn limits(&self, tolerance: f64, scale: f64) -> Limits {
        Limits {
            max_iterations: self.options.max_iterations,
            tolerance,
            stall_limit: match self.minimizer {
                Minimizer::TrustRegion => TRUST_STALL_LIMIT,
                _ => STALL_LIMIT,
            },
            scale: match self.minimizer {
                Minimizer::NewtonCg => NEWTON_SCALE,
                _ => scale,
            },
        }
    }

    /// One run of argmin, until its watch ends it or a line search finds nothing.
    fn run(&self, watch: &Watch<'_>) {
        let end = match self.minimizer {
            Minimizer::Lbfgs => {
                let search = MoreThuenteLineSearch::new();
                watch.run::<_, ()>(LBFGS::new(search, self.remembered()))
            }
            Minimizer::SteepestDescent => {
                watch.run::<_, ()>(SteepestDescent::new(MoreThuenteLineSearch::new()))
            }
            Minimizer::NewtonCg => {
                let condition = ArmijoCondition::new(ARMIJO).expect("a share between 0 and 1");
                let search = BacktrackingLineSearch::new(condition).rho(0.5);
                let search = search.expect("a factor between 0 and 1");
                watch.run::<_, Vec<Vec<f64>>>(NewtonCG::new(search))
            }
            Minimizer::TrustRegion => {
                let inner = Steihaug::new().with_max_iters(2 * watch.dim() as u64);
                let method = TrustRegion::new(inner).with_max_radius(MAX_RADIUS);
                let method = method.and_then(|method| method.with_radius(self.options.radius));
                watch.run::<_, Vec<Vec<f64>>>(method.expect("radii are positive"))
            }
        };
        // An error loses nothing: the watch has the best point.
        drop(end);
    }
}

/// Whether a line search along a gradient starts too far away, and can start nearer.
fn is_large(gradient: f64) -> bool {
    gradient > 1.0 && gradient.is_finite()
}
