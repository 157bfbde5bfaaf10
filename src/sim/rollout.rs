//! Rollouts: many steps in sequence.

use std::io::{self, Write};

use nalgebra::DVector;

use super::names::{column_names, input_columns};
use super::simulator::Simulator;
use super::state::State;
use super::status::{RolloutStatus, SolverFailure};
use super::step::StepScratch;
use crate::cone::Status;
use crate::memory;
use crate::model::{Model, Structure, numbered};
use crate::scalar::{Over, Scalar};

/// A trajectory of a robot: `states[k + 1]` follows from `states[k]` under `inputs[k]`. Every state is finite if the initial one is, see
/// [`State::check`]. Made by [`Simulator::rollout`], or by [`new`](Self::new) from given states.
#[derive(Clone, Debug)]
pub struct Rollout<T: Scalar = f64> {
    /// Time between two states, s, without derivatives; with several lanes that of the first lane.
    pub time_step: f64,
    /// The states, one more than there are inputs.
    pub states: Vec<State<T>>,
    /// The inputs, each held for one time step.
    pub inputs: Vec<DVector<T>>,
    /// Status of the rollout at its end.
    pub status: RolloutStatus,
    /// The first step in which the solver for contact and constraint forces failed; `None` if it never failed or none was needed.
    pub solver_failure: Option<SolverFailure>,
    /// Structure of the robot that it is of.
    robot: Structure,
    /// Name of the joint or actuator of each input, for plots and tables; empty if unknown. See [`Simulator::input_names`].
    pub input_names: Vec<String>,
}

impl Simulator<f64> {
    /// Takes up to `steps` steps from `initial`; `control(time, state, u)` sets the input of each (u starts at zero).
    ///
    /// Stops at the first input or state that is not finite, or exceeds the [divergence bound](Self::with_divergence_bound), and reports this in the
    /// status. Memory grows with the number of steps taken, not with the number requested; at the memory [limit](crate::memory) the rollout stops.
    /// [`rollout_over`](Self::rollout_over) is the same function over any scalar.
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
        mut control: impl FnMut(f64, &State, &mut [f64]),
    ) -> Rollout {
        self.rollout_by(initial, steps, &mut control)
    }

    /// [`rollout`](Self::rollout) under a controller behind a pointer: compiled here, once.
    #[inline(never)]
    fn rollout_by(
        &self,
        initial: &State,
        steps: usize,
        control: &mut dyn FnMut(f64, &State, &mut [f64]),
    ) -> Rollout {
        self.rollout_over(initial, steps, control)
    }
}

impl<P: Scalar> Simulator<P> {
    /// [`rollout`](Simulator::rollout) over any scalar: over dual numbers the trajectory carries derivatives in all variables of the initial state,
    /// the inputs and the model; over lanes it stops when the first lane stops.
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
        control: impl FnMut(f64, &State<T>, &mut [T]),
    ) -> Rollout<T> {
        let mut scratch = StepScratch::new(self);
        if self
            .contacts()
            .is_some_and(|c| c.solver_options().warm_start)
        {
            scratch = scratch.with_warm_start();
        }
        let step = |state: &State<T>, u: &[T], next: &mut State<T>| {
            self.step_into(state, u, &mut scratch, next);
            let status = (0..T::LANES).map(|lane| scratch.solver_status(lane));
            status.max().unwrap_or(Status::Converged)
        };
        self.rollout_of_steps(initial, steps, control, step)
    }

    /// [`rollout_over`](Self::rollout_over) with a user-supplied step function, for example compiled code.
    ///
    /// * `take_step(state, u, next)` – writes the next state, and returns the status of the solver of contact and constraints
    ///
    /// # Panics
    /// If the step function panics.
    #[doc(hidden)]
    pub fn rollout_of_steps<T: Over<P>>(
        &self,
        initial: &State<T>,
        steps: usize,
        mut control: impl FnMut(f64, &State<T>, &mut [T]),
        mut take_step: impl FnMut(&State<T>, &[T], &mut State<T>) -> Status,
    ) -> Rollout<T> {
        let time_step = self.time_step().value(0);
        let mut rollout = Rollout {
            time_step,
            states: vec![initial.clone()],
            inputs: Vec::new(),
            status: RolloutStatus::Completed,
            robot: self.model().structure(),
            input_names: self.input_names(),
            solver_failure: None,
        };
        let mut next = initial.clone();
        let most = most_states(initial, self.nu());
        for step in 0..steps {
            if !has_room(&mut rollout, most) {
                rollout.status = RolloutStatus::OutOfMemory { step };
                break;
            }
            let mut u = DVector::zeros(self.nu());
            let state = &rollout.states[step];
            control(step as f64 * time_step, state, u.as_mut_slice());
            if let Some(status) = RolloutStatus::before(step, u.as_slice(), 0..T::LANES) {
                rollout.status = status;
                break;
            }
            let status = take_step(state, u.as_slice(), &mut next);
            SolverFailure::note(&mut rollout.solver_failure, step, status);
            let bound = self.divergence_bound();
            if let Some(status) = RolloutStatus::after(step, &next, bound, 0..T::LANES) {
                rollout.status = status;
                break;
            }
            rollout.states.push(next.clone());
            rollout.inputs.push(u);
        }
        rollout
    }
}

impl Rollout {
    /// Makes a completed trajectory from given states and inputs: planned, recorded, or subsampled. If there are fewer inputs than states, the last
    /// inputs are unknown.
    ///
    /// # Panics
    /// If the list of states is empty, there are more inputs than states, or a state has the wrong length.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{State, model::samples, sim::Rollout};
    ///
    /// let states = (0..3).map(|k| State::new(&[0.1 * f64::from(k)], &[1.0]));
    /// let plan = Rollout::new(&samples::pendulum(), 0.1, states.collect(), Vec::new());
    /// assert_eq!(plan.last().q[0], 0.2);
    /// ```
    pub fn new(
        model: &Model,
        time_step: f64,
        states: Vec<State>,
        inputs: Vec<DVector<f64>>,
    ) -> Self {
        assert!(
            !states.is_empty(),
            "a trajectory has 0 states, expected at least 1"
        );
        let (n, most) = (inputs.len(), states.len());
        assert!(
            n <= most,
            "a trajectory of {most} states has {n} inputs, expected at most {most}"
        );
        for state in &states {
            model.check_q(state.q.as_slice());
            model.check_v(state.v.as_slice());
        }
        Self {
            time_step,
            states,
            inputs,
            status: RolloutStatus::Completed,
            robot: model.structure(),
            input_names: Vec::new(),
            solver_failure: None,
        }
    }

    /// Checks that it is one of this robot or a variant of it.
    pub(crate) fn check_robot(&self, model: &Model) {
        let name = model.name();
        let is_own = self.robot == model.structure();
        assert!(
            is_own,
            "the rollout is one of another robot than \"{name}\""
        );
    }
}

/// Whether a trajectory has room for one more state.
///
/// * `most` – how many states fit
fn has_room<T: Scalar>(rollout: &mut Rollout<T>, most: usize) -> bool {
    let states = &mut rollout.states;
    states.len() < most && states.try_reserve(1).is_ok() && rollout.inputs.try_reserve(1).is_ok()
}

/// Number of states like one, each with an input of `nu` entries, that fit into memory.
pub(crate) fn most_states<T: Scalar>(state: &State<T>, nu: usize) -> usize {
    let heads = size_of::<State<T>>() + size_of::<DVector<T>>();
    memory::limit() / (heads + (state.len() + nu) * size_of::<T>())
}

impl<T: Scalar> Rollout<T> {
    /// The last state. If [`status`](Self::status) is not `Completed`, the rollout ended early, at a finite state.
    pub fn last(&self) -> &State<T> {
        &self.states[self.states.len() - 1]
    }

    /// Time of each state, s.
    pub fn times(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.states.len()).map(|k| k as f64 * self.time_step)
    }
}

impl Rollout {
    /// Writes one row a state: time, q, v, the contact state, and the input that acted from there (empty in the last row).
    ///
    /// Columns are named `time`, `q.<joint>`, `v.<joint>`, `contact<k>`, and `u.<input>` by [`input_names`](Self::input_names), or `u<k>` if these
    /// are unknown. The coordinates of a joint with several are numbered.
    ///
    /// # Errors
    /// If writing fails.
    ///
    /// # Panics
    /// If it is one of another robot.
    pub fn write_csv(&self, model: &Model, mut out: impl Write) -> io::Result<()> {
        self.check_robot(model);
        let nu = self.inputs.first().map_or(0, |u| u.len());
        let header: Vec<String> = std::iter::once("time".into())
            .chain(column_names(model))
            .chain(numbered("contact", self.states[0].contact.len()))
            .chain(numbered("activation", self.states[0].activation.len()))
            .chain(input_columns(&self.input_names, nu))
            .collect();
        writeln!(out, "{}", header.join(","))?;
        for (k, (time, state)) in self.times().zip(&self.states).enumerate() {
            write_row(&mut out, time, state.numbers(), self.inputs.get(k), nu)?;
        }
        Ok(())
    }
}

/// Writes time, numbers and an input of `nu` entries, which are left empty where there is none.
pub(crate) fn write_row<'a>(
    out: &mut impl Write,
    time: f64,
    numbers: impl IntoIterator<Item = &'a f64>,
    input: Option<&DVector<f64>>,
    nu: usize,
) -> io::Result<()> {
    let numbers = numbers.into_iter().map(|&x| Some(x));
    write_cells(
        out,
        time,
        numbers.chain((0..nu).map(|i| input.map(|u| u[i]))),
    )
}

/// Writes a row of a table: time and cells; unknown values are empty.
pub(crate) fn write_cells(
    out: &mut impl Write,
    time: f64,
    cells: impl IntoIterator<Item = Option<f64>>,
) -> io::Result<()> {
    write!(out, "{time}")?;
    for cell in cells {
        match cell {
            Some(x) => write!(out, ",{x}")?,
            None => write!(out, ",")?,
        }
    }
    writeln!(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::samples;
    use crate::sim::BatchSimulator;

    fn start() -> State {
        State::new(&[0.0; 2], &[0.0; 2])
    }

    #[test]
    fn rollout_of_more_steps_than_memory_holds_ends_where_its_input_does() {
        let simulator = Simulator::new(samples::cartpole());
        let rollout = simulator.rollout(&start(), usize::MAX, |time, _, u| {
            u[0] = if time > 2.5e-3 { f64::NAN } else { 0.0 };
        });
        assert_eq!(rollout.status, RolloutStatus::NonFiniteInput { step: 3 });
        assert_eq!(rollout.states.len(), 4);
    }

    #[test]
    fn batches_of_more_steps_than_memory_holds_end_before_the_first_step() {
        let batch = || BatchSimulator::new(Simulator::new(samples::cartpole()), 3);
        let starts = vec![start(); 3];
        for steps in [usize::MAX, usize::MAX / 64, 1 << 62, 1 << 48] {
            let found = batch().rollout(&starts, steps, |_, _, _| panic!("a step"));
            for (i, start) in starts.iter().enumerate() {
                assert_eq!(found.status(i), RolloutStatus::OutOfMemory { step: 0 });
                assert_eq!((found.n_states(i), found.last(i)), (1, start.clone()));
            }
            let run = || batch().rollout_inputs(&starts, steps, &[]);
            let panic = std::panic::catch_unwind(run).unwrap_err();
            let text = panic.downcast_ref::<String>().unwrap();
            assert!(text.contains("len × steps × nu inputs"), "{text}");
        }
    }

    #[test]
    #[should_panic(expected = "the states are of another robot")]
    fn states_of_a_batch_of_another_robot_are_refused() {
        let of = |model: Model| BatchSimulator::new(Simulator::new(model), 1);
        let mut states = of(samples::double_pendulum()).states(&[start()]);
        of(samples::cartpole()).step(&mut states, &[0.0; 2]);
    }

    #[test]
    #[should_panic(expected = "another robot than \"double_pendulum\"")]
    fn table_of_a_rollout_of_another_robot_is_refused() {
        let rollout = Rollout::new(&samples::cartpole(), 0.1, vec![start()], Vec::new());
        let _ = rollout.write_csv(&samples::double_pendulum(), Vec::new());
    }
}
