//! Minimisation of smooth functions by guarded methods of argmin.
//!
//! argmin's line searches and trust regions may not terminate, or end with an error, if a function overflows, is not finite, or has no minimum.
//! [`minimize`] keeps the best point of each run, counts the evaluations of an iteration, restarts a method that stalls, and ends with a [`Status`].
//!
//! | question | function | cost | reference |
//! |---|---|---|---|
//! | minimise a smooth function? | [`minimize`] of an [`Objective`] | that of its iterations, see [`Minimizer`] | [Nocedal, Wright 2006] |
//! | which method? | [`Minimizer`] | a gradient or a Hessian an iteration | |
//! | derivatives of a function over the scalar? | [`Differentiated`] | that of [`gradient`](crate::autodiff::gradient) | |
//! | why did it end? | [`Status`] | | |
//!
//! `watch.rs` guards the methods, `run.rs` runs them.

mod objective;
mod run;
mod status;
mod watch;

/// The optimiser argmin, in the version of the implemented traits.
#[doc(no_inline)]
pub use argmin;

use crate::numbers::Domain;
pub use objective::{Differentiated, Objective};
pub(crate) use objective::{columns_of, objective_for_argmin};
pub(crate) use run::Run;
pub(crate) use status::COST_LIMIT;
pub use status::Status;
pub(crate) use watch::Iteration;

/// Method of argmin for smooth functions.
///
/// | method | derivatives | an iteration costs | use |
/// |---|---|---|---|
/// | [`Lbfgs`](Self::Lbfgs) | gradient | a few gradients | many variables, expensive Hessians |
/// | [`SteepestDescent`](Self::SteepestDescent) | gradient | a few gradients | reference |
/// | [`NewtonCg`](Self::NewtonCg) | Hessian | a Hessian, a few values | convex near the minimum |
/// | [`TrustRegion`](Self::TrustRegion) | Hessian | a Hessian, a value | not convex |
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Minimizer {
    /// L-BFGS, a quasi-Newton method that keeps the last gradients, with the line search of Moré and Thuente.
    #[default]
    Lbfgs,
    /// Steepest descent: steps along the negative gradient, with the line search of Moré and Thuente. Slow; for comparison.
    SteepestDescent,
    /// Newton-CG: Newton steps by truncated conjugate gradients, with a backtracking line search.
    NewtonCg,
    /// Trust region: the quadratic model within a radius, minimised by Steihaug's conjugate gradients.
    TrustRegion,
}

impl Minimizer {
    /// Array of all methods.
    pub const ALL: [Self; 4] = [
        Self::Lbfgs,
        Self::SteepestDescent,
        Self::NewtonCg,
        Self::TrustRegion,
    ];
}

/// Options of [`minimize`].
#[derive(Clone, Debug, PartialEq)]
pub struct MinimizeOptions {
    /// Maximum number of iterations, 500 by default.
    pub max_iterations: usize,
    /// The method has converged when no entry of the gradient is larger than this times (1 + value), or than this if the value is negative. 1e-7 by
    /// default; a larger value stops earlier.
    pub tolerance: f64,
    /// Number of gradients that L-BFGS stores, 10 by default, and at most the number of iterations; more gradients need fewer iterations and more memory.
    pub memory: usize,
    /// First radius of the trust region, in the units of the variables; 100 by default.
    pub radius: f64,
}

impl Default for MinimizeOptions {
    fn default() -> Self {
        Self {
            max_iterations: 500,
            tolerance: 1e-7,
            memory: 10,
            radius: 100.0,
        }
    }
}

impl MinimizeOptions {
    fn check(&self) {
        check(self.tolerance, self.memory, self.radius);
    }
}

/// Checks options of argmin's methods.
///
/// # Panics
/// If one is out of range, with its name and value.
pub(crate) fn check(tolerance: f64, memory: usize, radius: f64) {
    Domain::NotNegativeOrInfinite.check("tolerance", tolerance);
    assert!(memory > 0, "memory is 0 gradients, expected at least 1");
    assert!(
        radius > 0.0,
        "the radius is {radius}, expected a positive number"
    );
}

/// Result of [`minimize`]: the best point found, and the course of the run.
#[derive(Clone, Debug, PartialEq)]
pub struct Minimum {
    /// Termination status.
    pub status: Status,
    /// Point, as many variables as the function takes.
    pub x: Vec<f64>,
    /// Value of the function there.
    pub value: f64,
    /// Number of iterations.
    pub iterations: usize,
    /// Value of the start, then the best after each iteration.
    pub history: Vec<f64>,
}

impl Minimum {
    /// Whether the status is [`Status::Converged`].
    pub fn is_converged(&self) -> bool {
        self.status == Status::Converged
    }
}

/// Minimises a function from a start. It always returns the best point found.
///
/// * `start` – variables of the start, as many as the function takes
///
/// # Panics
/// If an option is out of its range, or the gradients of L-BFGS would need more memory than the [limit](crate::memory).
///
/// # Examples
/// ```
/// use dualbody::{Scalar, autodiff::VectorFunction};
/// use dualbody::minimize::{Differentiated, MinimizeOptions, Minimizer, minimize};
///
/// /// Rosenbrock's valley, with its lowest point at (1, 1).
/// struct Valley;
/// impl VectorFunction for Valley {
///     fn n_outputs(&self) -> usize {
///         1
///     }
///     fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
///         let (a, b) = (-x[0] + 1.0, x[1] - x[0] * x[0]);
///         y[0] = a * a + b * b * 100.0;
///     }
/// }
/// let found = minimize(&Differentiated(Valley), &[-1.2, 1.0], Minimizer::Lbfgs, &MinimizeOptions::default());
/// assert!(found.is_converged() && (found.x[0] - 1.0).abs() < 1e-6);
/// ```
pub fn minimize(
    objective: &impl Objective,
    start: &[f64],
    minimizer: Minimizer,
    options: &MinimizeOptions,
) -> Minimum {
    minimize_any(objective, start, minimizer, options)
}

/// [`minimize`] of a function behind a pointer, compiled once.
fn minimize_any(
    objective: &dyn Objective,
    start: &[f64],
    minimizer: Minimizer,
    options: &MinimizeOptions,
) -> Minimum {
    options.check();
    let value = objective.value(start);
    let mut out = Minimum {
        status: Status::Diverged,
        x: start.to_vec(),
        value,
        iterations: 0,
        history: vec![value],
    };
    let run = Run {
        objective,
        minimizer,
        options,
    };
    run.descend(options.tolerance, &mut out, &mut |_| {});
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::autodiff::VectorFunction;
    use crate::scalar::Scalar;
    use std::cell::Cell;

    /// Rosenbrock's valley, many times as deep.
    struct Valley {
        scale: f64,
    }

    impl VectorFunction for Valley {
        fn n_outputs(&self) -> usize {
            1
        }
        fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
            let (a, b) = (-x[0] + 1.0, x[1] - x[0] * x[0]);
            y[0] = (a * a + b * b * 100.0) * self.scale;
        }
    }

    /// eˣ², which overflows a little way off, with a lowest point at 0.
    struct Steep;

    impl VectorFunction for Steep {
        fn n_outputs(&self) -> usize {
            1
        }
        fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
            y[0] = ((x[0] * x[0]).exp() - 1.0) * 1e3;
        }
    }

    /// A value without a minimum, and a count of how often it was requested.
    struct Falling(Cell<usize>);

    impl Objective for Falling {
        fn value(&self, x: &[f64]) -> f64 {
            self.0.set(self.0.get() + 1);
            -x[0].powi(3)
        }
        fn gradient(&self, x: &[f64]) -> nalgebra::DVector<f64> {
            nalgebra::dvector![-3.0 * x[0] * x[0]]
        }
    }

    #[test]
    fn valley_of_any_depth_is_descended_to_its_lowest_point() {
        for minimizer in Minimizer::ALL {
            for scale in [1e-3, 1.0, 1e3, 1e6] {
                let valley = Differentiated(Valley { scale });
                let options = MinimizeOptions {
                    max_iterations: 20_000,
                    tolerance: 1e-7 * scale,
                    ..MinimizeOptions::default()
                };
                let found = minimize(&valley, &[-1.2, 1.0], minimizer, &options);
                let off = (found.x[0] - 1.0).hypot(found.x[1] - 1.0);
                assert!(
                    off < 1e-4,
                    "{minimizer:?} × {scale}: {off:e}, {}",
                    found.status
                );
                assert_eq!(found.history.len(), found.iterations + 1);
            }
        }
    }

    #[test]
    fn function_that_overflows_is_minimised_all_the_same() {
        for minimizer in Minimizer::ALL {
            let options = MinimizeOptions::default();
            let found = minimize(&Differentiated(Steep), &[3.0], minimizer, &options);
            assert!(found.value < 1e-6, "{minimizer:?}: {found:?}");
        }
    }

    #[test]
    fn function_without_a_minimum_ends_as_diverged_after_a_bounded_number_of_values() {
        for minimizer in Minimizer::ALL {
            let falling = Falling(Cell::new(0));
            let found = minimize(&falling, &[1.0], minimizer, &MinimizeOptions::default());
            assert_eq!(found.status, Status::Diverged, "{minimizer:?}");
            let values = falling.0.get();
            assert!(values < 20_000, "{minimizer:?}: {values}");
        }
    }

    #[test]
    fn all_gradients_are_remembered_and_no_more_are_reserved() {
        let valley = Differentiated(Valley { scale: 1.0 });
        let of = |memory, max_iterations| {
            let options = MinimizeOptions {
                memory,
                max_iterations,
                ..MinimizeOptions::default()
            };
            minimize(&valley, &[-1.2, 1.0], Minimizer::Lbfgs, &options)
        };
        assert_eq!(of(usize::MAX, 500), of(500, 500));
        let endless = std::panic::catch_unwind(|| of(usize::MAX, usize::MAX));
        let text = endless.unwrap_err().downcast::<String>().unwrap();
        assert!(
            text.contains("gradients that L-BFGS remembers need"),
            "{text}"
        );
    }

    #[test]
    fn start_that_is_not_finite_is_reported() {
        for start in [f64::NAN, f64::INFINITY, 1e200] {
            let found = minimize(
                &Differentiated(Steep),
                &[start],
                Minimizer::Lbfgs,
                &MinimizeOptions::default(),
            );
            assert_eq!(found.status, Status::Diverged, "{start}");
        }
    }
}
