//! Direct transcription.

use dualbody::trajopt::{Continuous, Curve, Problem, Transcription, TranscriptionOptions};

use super::problem::{Guess, is_of_user, problem_of, rows};
use super::solution::{nodes, solve};
use crate::prelude::*;

/// States at the nodes and in the middles, inputs likewise.
type Points<'py> = [Bound<'py, PyAny>; 4];

fn options_of(value: &Bound<'_, PyDict>) -> PyResult<TranscriptionOptions> {
    read_options!(TranscriptionOptions, "Transcription", value;
        max_iterations, tolerance, gap_tolerance, threads, line_search_steps,
        constraint_tolerance = constraints.tolerance, penalty = constraints.penalty)
}

fn check_dynamics(problem: &Bound<'_, PyAny>) -> PyResult<()> {
    if is_of_user(problem)? {
        refuse!(
            "transcription needs the rate of the state, and dynamics that are functions have steps only"
        );
    }
    Ok(())
}

/// The points of a curve as rows.
struct Read([Vec<DVector<f64>>; 4]);

impl Read {
    fn new(problem: &Problem, points: &Points<'_>) -> PyResult<Self> {
        let (n, simulator) = (problem.horizon(), problem.dynamics());
        let (nx, nu) = (simulator.nx(), simulator.nu());
        let [states, middle_states, inputs, middle_inputs] = points;
        Ok(Self([
            rows("states", states, nx, n + 1)?,
            rows("middle_states", middle_states, nx, n)?,
            rows("inputs", inputs, nu, n + 1)?,
            rows("middle_inputs", middle_inputs, nu, n)?,
        ]))
    }

    fn curve(&self, problem: &Problem) -> Curve {
        let Self([states, middle_states, inputs, middle_inputs]) = self;
        Curve::from_points(problem, [states, middle_states], [inputs, middle_inputs])
    }
}

functions! {
    /// Solves a problem by direct transcription: see `solution`, with what the curve has besides the states at the nodes.
    ///
    /// * `from` – curve of a former solution, in place of a guess
    fn _transcription(
        problem, options: &Bound<'py, PyDict>, guess: Option<Guess<'py>> = None, from_: Option<Points<'py>> = None, report = None
    ) -> PyResult<Bound<'py, PyTuple>> {
        check_dynamics(problem)?;
        let options = options_of(options)?;
        let from = match from_ {
            Some(points) => {
                let problem = problem_of(problem, &Raised::default())?;
                Some(Read::new(&problem, &points)?)
            }
            None => None,
        };
        solve(
            problem,
            guess,
            report,
            problem_of,
            |problem, guess, report| {
                let solver = Transcription::with_options(options);
                match from {
                    Some(points) => solver.resume_with(problem, &points.curve(problem), report),
                    None => solver.solve_with(problem, guess, report),
                }
            },
            |py, simulator, own: &Continuous| {
                let (nx, nu, curve) = (simulator.nx(), simulator.nu(), &own.curve);
                let arrays = [
                    nodes(py, &curve.middle_states, nx),
                    nodes(py, &curve.inputs, nu),
                    nodes(py, &curve.middle_inputs, nu),
                ];
                Ok(PyTuple::new(py, arrays)?.into_any())
            },
        )
    }

    /// States (n, nx) and inputs (n, nu) of a curve at times (n,), s.
    fn _curve_at(problem, points: Points<'py>, times) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        check_dynamics(problem)?;
        let py = problem.py();
        let problem: Problem = problem_of(problem, &Raised::default())?;
        let (points, times) = (Read::new(&problem, &points)?, read_vector("times", times, None)?);
        if let Some(k) = times.iter().position(|time| time.is_nan()) {
            refuse!("times[{k}] is not a number");
        }
        let simulator = problem.dynamics();
        let (states, inputs): (Vec<_>, Vec<_>) = guarded(|| {
            let curve = points.curve(&problem);
            let at = |&time: &f64| (curve.state(simulator, time), curve.input(time));
            times.iter().map(at).unzip()
        })?;
        Ok((nodes(py, &states, simulator.nx()), nodes(py, &inputs, simulator.nu())))
    }
}
