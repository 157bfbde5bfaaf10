//! Long calls that a signal ends: the best iterate is kept, and the status reports the signal.

use dualbody::minimize::{MinimizeOptions, Minimizer, Objective, Status, minimize};
use dualbody::model::samples;
use dualbody::trajopt::{
    Activation, Cost, Ddp, InputError, Problem, SingleShooting, Solver, StateError, Trajectory,
    Transcription,
};
use dualbody::{Simulator, StopSignal};
use nalgebra::DVector;

fn swing() -> Problem {
    let pendulum = Simulator::new(samples::pendulum()).with_time_step(0.05);
    let effort = Cost::new().with(1e-2, Activation::Quadratic, InputError::to_zero(&pendulum));
    let arrive = Cost::new().with(1e3, Activation::Quadratic, StateError::to(&[3.0, 0.0]));
    let problem = Problem::new(pendulum, 40, &[0.0, 0.0]).with_stage_cost(effort);
    problem.with_final_cost(arrive)
}

/// Stops after two iterations, and from the start.
fn check(solver: &mut impl Solver, problem: &Problem, name: &str) {
    let guess = Trajectory::zero_input(problem);
    let signal = StopSignal::new();
    let first = signal.watch(|| {
        solver.solve_with(problem, &guess, &mut |at| {
            if at.iteration == 2 {
                signal.stop();
            }
        })
    });
    assert_eq!(
        (first.status, first.iterations),
        (Status::Stopped, 2),
        "{name}"
    );
    assert!(
        first.cost < first.cost_history[0] || first.gap > 0.0,
        "{name}"
    );
    let none = signal.watch(|| solver.solve(problem, &guess));
    assert_eq!(
        (none.status, none.iterations),
        (Status::Stopped, 0),
        "{name}"
    );
    let whole = solver.solve(problem, &guess);
    assert_ne!(whole.status, Status::Stopped, "{name}");
    // Where gaps close, the cost may rise.
    let is_better = whole.cost <= first.cost || whole.gap < first.gap;
    assert!(whole.iterations > 2 && is_better, "{name}");
}

#[test]
fn solvers_end_at_a_signal_with_the_best_so_far() {
    let problem = swing();
    let names = ["dynamic programming", "single shooting", "transcription"];
    check(&mut Ddp::new(&problem), &problem, names[0]);
    check(&mut SingleShooting::new(&problem), &problem, names[1]);
    check(&mut Transcription::new(), &problem, names[2]);
}

/// A valley whose values set the signal, after so many.
struct Valley<'a> {
    signal: &'a StopSignal,
    left: std::cell::Cell<usize>,
}

impl Objective for Valley<'_> {
    fn value(&self, x: &[f64]) -> f64 {
        self.left.set(self.left.get().saturating_sub(1));
        if self.left.get() == 0 {
            self.signal.stop();
            return f64::NEG_INFINITY;
        }
        x.iter().map(|x| (x - 1.0).powi(4)).sum()
    }

    fn gradient(&self, x: &[f64]) -> DVector<f64> {
        let slopes = x.iter().map(|x| 4.0 * (x - 1.0).powi(3));
        DVector::from_iterator(x.len(), slopes)
    }
}

// The result of a function that was told to stop is not used as its value.
#[test]
fn minimisers_end_at_a_signal_and_take_no_value_after_it() {
    for minimizer in Minimizer::ALL {
        let signal = StopSignal::new();
        let left = std::cell::Cell::new(6);
        let valley = Valley {
            signal: &signal,
            left,
        };
        let options = MinimizeOptions::default();
        let found = signal.watch(|| minimize(&valley, &[5.0, -3.0], minimizer, &options));
        assert_eq!(found.status, Status::Stopped, "{minimizer:?}");
        assert!(
            found.value.is_finite() && found.value <= 512.0,
            "{minimizer:?}: {}",
            found.value
        );
    }
}
