//! One step, and the acceleration at a moment.

use dualbody::Scalar;
use dualbody::sim::{BatchStates, RolloutStatus};
use pyo3::exceptions::PyFloatingPointError;

use super::given::{Given, States};
use super::memory::{StepMemory, check_batch};
use crate::prelude::*;

/// Writes the numbers of a state as the k-th row of q, v and the numbers beside them. An empty output is left out.
pub(crate) fn write_row<T: Scalar>(
    state: &State<T>,
    k: usize,
    out: &mut [&mut [f64]],
    value: impl Fn(&T) -> f64,
) {
    let none = &DVector::zeros(0);
    let parts = [
        [&state.q, none, none],
        [&state.v, none, none],
        [&state.contact, &state.activation, &state.sleep],
    ];
    let wanted = out.iter_mut().zip(parts);
    for (out, parts) in wanted.filter(|(out, _)| !out.is_empty()) {
        let n: usize = parts.iter().map(|part| part.len()).sum();
        let numbers = parts.into_iter().flatten();
        let row = out[k * n..(k + 1) * n].iter_mut().zip(numbers);
        row.for_each(|(out, x)| *out = value(x));
    }
}

/// Writes the states of a batch into arrays of q, v and the state of contact.
pub(crate) fn write_states(states: &BatchStates, out: &[Array<'_>]) {
    let mut out: Vec<&mut [f64]> = out.iter().map(|array| numbers_mut(array)).collect();
    write_parts(states, &mut out);
}

/// Writes the states of a batch into numbers of q, v and the state of contact, as many of these as there are, except empty ones.
pub(super) fn write_parts(states: &BatchStates, out: &mut [&mut [f64]]) {
    for (k, group) in states.groups().enumerate() {
        for lane in 0..WIDTH.min(states.len() - k * WIDTH) {
            write_row(group, k * WIDTH + lane, out, |x| x.0[lane]);
        }
    }
}

pub(crate) fn diverged(k: Option<usize>) -> PyErr {
    let which = k.map_or(String::new(), |k| format!(" of state {k} of the batch"));
    PyFloatingPointError::new_err(format!("the step{which} diverged"))
}

/// A simulator with an input for each coordinate of the forces, and the input with them.
pub(super) fn with_forces<'py>(
    this: &Bound<'py, PySimulator>,
    u: Option<&Bound<'py, PyAny>>,
    forces: &Bound<'py, PyAny>,
    representation: &str,
    has_models: bool,
) -> PyResult<(Bound<'py, PySimulator>, Option<Bound<'py, PyAny>>)> {
    if has_models {
        refuse!("forces act on states of one robot: give forces or models, not both");
    }
    let py = this.py();
    let parts = this.get().parts.bind(py).as_any();
    let actuators = parts.get_item("frame_actuators")?;
    let forced = of_package!(py, "_forces", "_forced");
    let made = forced.call1((this, actuators, u, forces, representation))?;
    made.extract()
}

methods! { PySimulator {
    /// Advances by one time step with the input held: the next (q, v), or (q, v, contact) if contact is given.
    ///
    /// q (..., nq), v (..., nv), u (..., nu; N·m or N; zero if left out); models: a robot of the same structure for each state of a batch.
    /// contact (..., n_contact): the state of soft contact, neutral if left out. Hand on the one that is returned: without it bristles begin anew
    /// at each step, and nothing sticks. forces {frame or link: (..., 6)}: [linear; angular], N and N·m, in a representation, held as the input is.
    /// out: arrays for the next state, which may be those of the state. Soft contact and stiff springs need
    /// short steps (0.1 ms to 1 ms), rigid contact 1 ms to 10 ms. Raises FloatingPointError if the next state is not finite.
    fn step(
        this: &Bound<'py, Self>, q, v, u = None, *, contact = None, forces = None, representation: &str = "mixed",
        models: Option<Vec<Py<PyModel>>> = None, out: Option<&Bound<'py, PyTuple>> = None
    ) -> PyResult<Bound<'py, PyTuple>> {
        if let Some(forces) = forces {
            let (forced, u) = with_forces(this, u, forces, representation, models.is_some())?;
            let u = u.as_ref();
            return Self::step(&forced, q, v, u, contact, None, representation, None, out);
        }
        let own = this.get();
        let given = own.read(q, v, u, contact)?;
        check_batch(&given.batch, models.is_some())?;
        let (many, count) = (States::from(&given), given.count());
        own.take_step(
            q.py(),
            &given,
            out,
            |memory| own.step_in(memory),
            |out| own.step_batch(&many, count, models.as_deref(), out),
        )
    }
} }

impl PySimulator {
    /// Takes the step of the state in the memory.
    pub(crate) fn step_in(&self, memory: &mut StepMemory) {
        let (state, next) = (&memory.state, &mut memory.next);
        let scratch = &mut memory.scratch;
        self.simulator.step_into(state, &memory.u, scratch, next);
    }

    /// The next state, or those of a batch.
    ///
    /// * `one` – takes a step in the memory
    /// * `many` – takes those of a batch without the interpreter lock, and writes them
    pub(super) fn take_step<'py>(
        &self,
        py: Python<'py>,
        given: &Given<'py>,
        out: Option<&Bound<'py, PyTuple>>,
        one: impl FnOnce(&mut StepMemory),
        many: impl FnOnce(&mut [&mut [f64]]) -> PyResult<()> + Send,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let arrays = self.outputs(py, given, out)?;
        let mut numbers: Vec<&mut [f64]> = arrays.iter().map(numbers_mut).collect();
        match given.batch.is_empty() {
            true => self.step_one(given, &mut numbers, one)?,
            false => py.detach(|| many(&mut numbers))?,
        }
        PyTuple::new(py, arrays)
    }

    /// Writes the next state of one.
    pub(crate) fn step_one<'a>(
        &self,
        given: impl Into<States<'a>>,
        out: &mut [&mut [f64]],
        step: impl FnOnce(&mut StepMemory),
    ) -> PyResult<()> {
        let is_finite = self.with_memory(given, |memory| {
            step(memory);
            write_row(&memory.next, 0, out, |&x| x);
            memory.next.is_finite()
        })?;
        match is_finite {
            true => Ok(()),
            false => Err(diverged(None)),
        }
    }

    /// Writes the next states of a batch; the interpreter lock is not needed.
    pub(crate) fn step_batch(
        &self,
        given: &States<'_>,
        count: usize,
        models: Option<&[Py<PyModel>]>,
        out: &mut [&mut [f64]],
    ) -> PyResult<()> {
        if count == 0 {
            return Ok(());
        }
        let (inputs, mut state) = (self.inputs(*given, count)?, self.simulator.neutral_state());
        let stopped = self.on_batch(count, models, |batch| {
            let make = || batch.simulator.states(&vec![state.clone(); count]);
            let states = batch.states.get_or_insert_with(make);
            for k in 0..count {
                self.read_state(given, k, &mut state)?;
                states.set(k, &state);
            }
            batch.simulator.step(states, &inputs);
            let stopped = |i: &usize| !matches!(states.status(*i), RolloutStatus::Completed);
            let first = (0..count).find(stopped);
            if first.is_none() {
                write_parts(states, out);
            }
            Ok::<_, PyErr>(first)
        })??;
        stopped.map_or(Ok(()), |i| Err(diverged(Some(i))))
    }

    /// Arrays for the next state: those of the caller, or new ones.
    pub(crate) fn outputs<'py>(
        &self,
        py: Python<'py>,
        given: &Given<'py>,
        out: Option<&Bound<'py, PyTuple>>,
    ) -> PyResult<Vec<Array<'py>>> {
        let (nq, nv, _, nc) = self.sizes();
        let widths = [("out[0]", nq), ("out[1]", nv), ("out[2]", nc)];
        let count = if given.contact.is_some() { 3 } else { 2 };
        let shape = |n: usize| [given.batch.as_slice(), &[n]].concat();
        let Some(out) = out else {
            return Ok(widths[..count]
                .iter()
                .map(|&(_, n)| empty(py, &shape(n)))
                .collect());
        };
        if out.len() != count {
            refuse!("out has {} arrays, expected {count}", out.len());
        }
        let arrays = widths[..count].iter().zip(out.iter());
        let arrays: Vec<Array<'py>> = arrays
            .map(|(&(name, n), array)| checked_output(name, &array, &shape(n)))
            .collect::<PyResult<_>>()?;
        for (k, own) in arrays.iter().enumerate() {
            let own = numbers_mut(own).as_ptr_range();
            let mut others = (arrays[..k].iter()).map(|other| numbers_mut(other).as_ptr_range());
            if others.any(|other| own.start < other.end && other.start < own.end) {
                refuse!("out[{k}] overlaps another one");
            }
        }
        Ok(arrays)
    }
}

fn not_finite(k: Option<usize>) -> PyErr {
    let which = k.map_or(String::new(), |k| format!(" of state {k} of the batch"));
    PyFloatingPointError::new_err(format!("the acceleration{which} is not finite"))
}

methods! { PySimulator {
    /// Acceleration dv/dt at a state under the input, (..., nv), rad/s² or m/s²: forward dynamics with all forces at this instant.
    ///
    /// Arguments as in step; out: an array for the result. Motors, limits, friction, springs, constraints and contact are evaluated at this state,
    /// while a step evaluates some of them at its end. Rigid contact has forces over a whole step only; the acceleration is the mean over one step.
    /// Raises FloatingPointError if an acceleration is not finite.
    fn acceleration(
        this: &Bound<'py, Self>, q, v, u = None, *, contact = None, forces = None, representation: &str = "mixed",
        models: Option<Vec<Py<PyModel>>> = None, out = None
    ) -> PyResult<Array<'py>> {
        if let Some(forces) = forces {
            let (forced, u) = with_forces(this, u, forces, representation, models.is_some())?;
            let u = u.as_ref();
            return Self::acceleration(&forced, q, v, u, contact, None, representation, None, out);
        }
        let own = this.get();
        let given = own.read(q, v, u, contact)?;
        check_batch(&given.batch, models.is_some())?;
        let variants = own.variants(models.as_deref(), given.count())?;
        let (simulator, nv) = (&*own.simulator, own.sizes().1);
        let array = own.rows(q.py(), &given, nv, out, |k, memory, row| {
            let (state, u, scratch) = (&memory.state, &memory.u, &mut memory.scratch);
            match &variants {
                Some(all) => row.copy_from_slice(all[k].acceleration(state, u).as_slice()),
                None => row.copy_from_slice(simulator.acceleration_into(state, u, scratch)),
            }
        })?;
        match numbers_mut(&array).iter().position(|a| !a.is_finite()) {
            None => Ok(array),
            Some(k) => Err(not_finite((!given.batch.is_empty()).then(|| k / nv))),
        }
    }
} }
