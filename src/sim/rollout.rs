//! Many steps in a row.

use std::io::{self, Write};

use nalgebra::DVector;

use super::integrator::StepScratch;
use super::simulator::Simulator;
use super::state::State;
use crate::contact::cone::Status;
use crate::model::{BodyId, Model};
use crate::scalar::{Over, Scalar};

/// How a rollout ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RolloutStatus {
    /// All steps were taken.
    Completed,
    /// The input of this step was not finite; the trajectory ends at the state that it was computed for.
    NonFiniteInput {
        /// Index of the step, from 0.
        step: usize,
    },
    /// This step led to a state that is not finite, or faster than the [bound](Simulator::with_divergence_bound); the trajectory ends before
    /// it.
    Diverged {
        /// Index of the step, from 0.
        step: usize,
    },
}

/// A step in which the solver of the forces of contact and constraints failed. The trajectory goes on with the best forces that it found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct SolverFailure {
    /// Index of the step, from 0.
    pub step: usize,
    /// How it came out, which is not [`Converged`](Status::Converged).
    pub status: Status,
}

impl SolverFailure {
    /// The failure of a step, if it is one.
    pub(super) fn of(step: usize, status: Status) -> Option<Self> {
        (status != Status::Converged).then_some(Self { step, status })
    }
}

/// A trajectory: `states[k + 1]` follows from `states[k]` under `inputs[k]`. Every state is finite if the initial one is, see [`State::check`].
#[derive(Clone, Debug)]
pub struct Rollout<T: Scalar = f64> {
    /// Time between two states, s.
    pub time_step: f64,
    /// The states, one more than there are inputs.
    pub states: Vec<State<T>>,
    /// The inputs, each held for one time step.
    pub inputs: Vec<DVector<T>>,
    /// How it ended.
    pub status: RolloutStatus,
    /// The first step in which the solver of the forces of contact and constraints failed; `None` if it never did, or if there is none.
    pub solver_failure: Option<SolverFailure>,
}

/// States for which room is made before the first step.
const RESERVED: usize = 1 << 16;

impl Simulator<f64> {
    /// Takes up to `steps` steps from `initial`; `control(time, state, u)` sets the input of each (u starts at zero).
    ///
    /// Stops at the first input or state that is not finite, or faster than the [bound](Self::with_divergence_bound), and says so in the
    /// status. [`rollout_over`](Self::rollout_over) is the same over any scalar.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, State, model::samples, sim::RolloutStatus};
    ///
    /// let simulator = Simulator::new(samples::pendulum()).with_time_step(0.01);
    /// let swing = simulator.rollout(&State::new(&[0.1], &[0.0]), 100, |_, _, _| {});
    /// assert_eq!(swing.status, RolloutStatus::Completed);
    /// assert_eq!(swing.states.len(), 101);
    /// ```
    ///
    /// # Panics
    /// If the state has the wrong length.
    pub fn rollout(
        &self,
        initial: &State,
        steps: usize,
        control: impl FnMut(f64, &State, &mut [f64]),
    ) -> Rollout {
        self.rollout_over(initial, steps, control)
    }
}

impl<P: Scalar> Simulator<P> {
    /// [`rollout`](Simulator::rollout) over any scalar: over dual numbers the trajectory has its derivatives in what the initial state, the
    /// inputs or the model depend on; over lanes it stops where the first of them does.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, State, model::samples};
    /// use num_dual::Dual64;
    ///
    /// // Half a second of a pendulum without gravity: q = q₀ + v₀ t, so ∂q/∂v₀ = t.
    /// let model = samples::pendulum().with_gravity(nalgebra::Vector3::zeros());
    /// let simulator = Simulator::new(model).with_time_step(0.01);
    /// let start = State::new(&[Dual64::from_re(0.1)], &[Dual64::from_re(2.0).derivative()]);
    /// let swing = simulator.rollout_over(&start, 50, |_, _, _| {});
    /// assert!((swing.last().q[0].re - 1.1).abs() < 1e-12 && (swing.last().q[0].eps - 0.5).abs() < 1e-12);
    /// ```
    ///
    /// # Panics
    /// If the state has the wrong length.
    pub fn rollout_over<T: Over<P>>(
        &self,
        initial: &State<T>,
        steps: usize,
        mut control: impl FnMut(f64, &State<T>, &mut [T]),
    ) -> Rollout<T> {
        let mut scratch = StepScratch::new(self);
        let mut rollout = Rollout {
            time_step: self.time_step(),
            states: vec![initial.clone()],
            inputs: Vec::with_capacity(steps.min(RESERVED)),
            status: RolloutStatus::Completed,
            solver_failure: None,
        };
        let mut state = initial.clone();
        let mut next = initial.clone();
        for step in 0..steps {
            let mut u = DVector::zeros(self.nu());
            control(step as f64 * self.time_step(), &state, u.as_mut_slice());
            if !u.iter().all(is_finite) {
                rollout.status = RolloutStatus::NonFiniteInput { step };
                break;
            }
            self.step_into(&state, u.as_slice(), &mut scratch, &mut next);
            let failure = (0..T::LANES).map(|lane| scratch.solver_status(lane)).max();
            let failure = failure.and_then(|status| SolverFailure::of(step, status));
            rollout.solver_failure = rollout.solver_failure.or(failure);
            if !next.numbers().all(is_finite) || self.is_too_fast(&next) {
                rollout.status = RolloutStatus::Diverged { step };
                break;
            }
            rollout.states.push(next.clone());
            rollout.inputs.push(u);
            std::mem::swap(&mut state, &mut next);
        }
        rollout
    }

    /// Whether a coordinate is faster in some lane than the bound from which on a rollout has diverged.
    fn is_too_fast<T: Scalar>(&self, state: &State<T>) -> bool {
        let bound = self.divergence_bound();
        let too_fast = |v: &T| (0..T::LANES).any(|lane| v.value(lane).abs() > bound);
        state.v.iter().any(too_fast)
    }
}

/// Whether a number is finite in all lanes.
fn is_finite<T: Scalar>(x: &T) -> bool {
    (0..T::LANES).all(|lane| x.value(lane).is_finite())
}

impl<T: Scalar> Rollout<T> {
    /// The last state.
    pub fn last(&self) -> &State<T> {
        &self.states[self.states.len() - 1]
    }

    /// Time of each state, s.
    pub fn times(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.states.len()).map(|k| k as f64 * self.time_step)
    }
}

impl Rollout {
    /// Writes one row a state: time, q, v, the state of contact, and the input that acted from there (empty in the last row).
    ///
    /// Columns are named `time`, `q.<joint>`, `v.<joint>`, `contact<k>`, `u<k>`; where a joint has several coordinates they are numbered.
    ///
    /// # Errors
    /// If writing fails.
    pub fn write_csv(&self, model: &Model, mut out: impl Write) -> io::Result<()> {
        let nu = self.inputs.first().map_or(0, |u| u.len());
        let inputs = (0..nu).map(|k| format!("u{k}"));
        let contact = (0..self.states[0].contact.len()).map(|k| format!("contact{k}"));
        let header: Vec<String> = std::iter::once("time".into())
            .chain(column_names(model))
            .chain(contact)
            .chain(inputs)
            .collect();
        writeln!(out, "{}", header.join(","))?;
        for (k, (time, state)) in self.times().zip(&self.states).enumerate() {
            write_row(&mut out, time, state.numbers(), (self.inputs.get(k), nu))?;
        }
        Ok(())
    }
}

/// Writes time, numbers and an input of `nu` entries, which are left empty where there is none.
pub(crate) fn write_row<'a>(
    out: &mut impl Write,
    time: f64,
    numbers: impl IntoIterator<Item = &'a f64>,
    (input, nu): (Option<&DVector<f64>>, usize),
) -> io::Result<()> {
    write!(out, "{time}")?;
    for x in numbers {
        write!(out, ",{x}")?;
    }
    for i in 0..nu {
        match input {
            Some(u) => write!(out, ",{}", u[i])?,
            None => write!(out, ",")?,
        }
    }
    writeln!(out)
}

/// Names of the coordinates of q, then of v.
pub(crate) fn column_names(model: &Model) -> Vec<String> {
    let name_of = |body: usize| {
        let joint = model.body_joint(BodyId(body));
        let name = joint.map_or("base", |joint| &model.joints()[joint.0].name);
        // A name with a comma or a quote would break the table.
        name.replace([',', '"', '\n', '\r'], "_")
    };
    let numbered = |prefix: &str, name: &str, n: usize| -> Vec<String> {
        (0..n)
            .map(|k| {
                if n == 1 {
                    format!("{prefix}.{name}")
                } else {
                    format!("{prefix}.{name}.{k}")
                }
            })
            .collect()
    };
    let bodies = || {
        model
            .bodies()
            .iter()
            .enumerate()
            .filter(|(_, body)| body.coupling.is_none())
    };
    let q = bodies().flat_map(|(i, body)| numbered("q", &name_of(i), body.joint.nq()));
    let v = bodies().flat_map(|(i, body)| numbered("v", &name_of(i), body.joint.nv()));
    q.chain(v).collect()
}
