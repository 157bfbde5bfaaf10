//! Episodes of tasks that are data: a state that starts near another one is kept within bounds.

use dualbody::sim::{
    AutoReset, BATCH_WIDTH, BatchScalar, BatchSimulator, Environment, Environments, Episode,
    Transitions,
};
use numpy::{PyArray2, PyArrayLike1};
use pyo3::exceptions::PyRuntimeError;
use rand::{Rng, RngExt};

use super::memory::threads_for;
use super::spread::Spread;
use crate::prelude::*;

/// Bounds of numbers.
type Bounds = [Vec<f64>; 2];

/// Starts are drawn within bounds around the neutral state, along its directions; an episode is over outside of bounds of the state.
struct Balance {
    model: Model,
    neutral: Vec<f64>,
    nu: usize,
    start: Bounds,
    within: Vec<Within>,
}

/// Bounds of an entry of the state, q and v in a row.
struct Within {
    entry: usize,
    low: f64,
    high: f64,
}

impl Within {
    /// Those of bounds that are any.
    fn all([low, high]: &Bounds) -> Vec<Self> {
        let bounds = low.iter().zip(high).enumerate();
        let all = bounds.map(|(entry, (&low, &high))| Self { entry, low, high });
        all.filter(|own| own.low.is_finite() || own.high.is_finite())
            .collect()
    }
}

impl Environment for Balance {
    fn n_actions(&self) -> usize {
        self.nu
    }

    fn n_observations(&self) -> usize {
        self.model.nq() + self.model.nv()
    }

    fn start(&self, rng: &mut dyn Rng, state: &mut State, _: &mut [f64]) {
        let [low, high] = &self.start;
        let mut drawn = low.iter().zip(high).map(|(low, high)| match low < high {
            true => rng.random_range(*low..*high),
            false => *low,
        });
        let (v, q) = (state.v.as_mut_slice(), state.q.as_mut_slice());
        let mut draw = |v: &mut [f64]| v.iter_mut().zip(&mut drawn).for_each(|(v, x)| *v = x);
        draw(v);
        self.model.integrate_into(&self.neutral, v, q);
        draw(v);
    }

    fn observe(&self, now: &Episode<'_>, out: &mut [BatchScalar]) {
        let numbers = now.state.q.iter().chain(&now.state.v);
        out.iter_mut().zip(numbers).for_each(|(out, x)| *out = *x);
    }

    fn is_over(&self, now: &Episode<'_>) -> [bool; BATCH_WIDTH] {
        let (q, v) = (now.state.q.as_slice(), now.state.v.as_slice());
        let mut over = [false; BATCH_WIDTH];
        for Within { entry, low, high } in &self.within {
            let x = entry
                .checked_sub(q.len())
                .map_or_else(|| q[*entry], |k| v[k]);
            for (over, x) in over.iter_mut().zip(x.0) {
                *over |= (x < *low) | (x > *high);
            }
        }
        over
    }
}

/// Episodes of a `gym.Balance` on many states.
#[pyclass(name = "_Balance", module = "dualbody._dualbody")]
pub(crate) struct PyBalance {
    /// Taken while it gets more threads.
    all: Option<Environments<Balance>>,
    next: Transitions,
    actions: Vec<f64>,
    auto_reset: AutoReset,
    spread: Spread,
}

const MODES: [(&str, AutoReset); 3] = [
    ("NextStep", AutoReset::NextStep),
    ("SameStep", AutoReset::SameStep),
    ("Disabled", AutoReset::Never),
];

#[pymethods]
impl PyBalance {
    /// Seeds the states whose seed is not None, from their next episode on.
    fn seed(&mut self, seeds: Vec<Option<u64>>) {
        if let Some(all) = &mut self.all {
            let seeds = seeds.iter().take(all.states().len()).enumerate();
            seeds.for_each(|(i, seed)| seed.iter().for_each(|seed| all.seed(i, *seed)));
        }
    }

    /// Takes the steps of actions (n, nu): observations, rewards, ends, cuts, and the last observations where episodes have ended and begun again.
    fn step<'py>(&mut self, actions: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyTuple>> {
        let py = actions.py();
        self.read_actions(actions)?;
        self.refuse_ended()?;
        let n = self.next.rewards.len();
        if self.spread.begins() {
            let threads = threads_for(n)?;
            self.all = self.all.take().map(|all| all.with_threads(threads));
        }
        let (all, actions, next) = (&mut self.all, &self.actions, &mut self.next);
        self.spread.run(py, || {
            if let Some(all) = all {
                all.step(actions, next);
            }
        })?;
        let next = &self.next;
        let begins_again = self.auto_reset == AutoReset::SameStep
            && (next.terminated.contains(&true) || next.truncated.contains(&true));
        let last = begins_again.then(|| single(py, &next.final_observations, n));
        let (observations, last) = (single(py, &next.observations, n)?, last.transpose()?);
        let rewards = PyArray1::from_slice(py, &next.rewards);
        let [over, cut] =
            [&next.terminated, &next.truncated].map(|all| PyArray1::from_slice(py, all));
        (observations, rewards, over, cut, last).into_pyobject(py)
    }
}

methods! { PyBalance {
    #[new]
    fn new(
        simulator: &Bound<'py, PySimulator>, n: usize, start: (Bound<'py, PyAny>, Bound<'py, PyAny>), within: (Bound<'py, PyAny>, Bound<'py, PyAny>),
        max_steps: usize, steps_per_action: usize, mode: &str
    ) -> PyResult<Self> {
        let own = &simulator.get().simulator;
        let (nq, nv, nu, _) = simulator.get().sizes();
        let auto_reset = choice("autoreset_mode", mode, &MODES)?;
        for (name, count) in [("max_steps", max_steps), ("steps_per_action", steps_per_action)] {
            if count == 0 {
                refuse!("{name} is 0, expected 1 or more");
            }
        }
        check_array("states", &[n, nq + nv])?;
        let task = Balance {
            model: own.model().clone(),
            neutral: own.model().neutral().as_slice().to_vec(),
            nu,
            start: bounds("start", &start, 2 * nv, true)?,
            within: Within::all(&bounds("within", &within, nq + nv, false)?),
        };
        let batch = BatchSimulator::new((**own).clone(), n).with_threads(1);
        let all = Environments::new(task, batch, 0).with_decimation(steps_per_action);
        let all = all.with_max_length(max_steps).with_auto_reset(auto_reset);
        Ok(Self {
            next: all.transitions(),
            all: Some(all),
            actions: vec![0.0; n * nu],
            auto_reset,
            spread: Spread::new(),
        })
    }

    /// Begins episodes, those of a mask or all: observations.
    fn reset(&mut self, py: Python, mask: Option<PyArrayLike1<'py, bool>> = None) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let n = self.next.rewards.len();
        let mask = mask.map(|mask| mask.as_array().to_vec());
        if let Some(given) = mask.as_ref().map(Vec::len).filter(|given| *given != n) {
            refuse!("reset_mask has the shape ({given},), expected ({n},)");
        }
        if let Some(all) = &mut self.all {
            match &mask {
                Some(mask) => all.reset_where(mask, &mut self.next.observations),
                None => all.reset(&mut self.next.observations),
            }
        }
        single(py, &self.next.observations, n)
    }

    /// The first state (nq,), (nv,), and the number of actions of its episode so far.
    fn first(&self, py: Python) -> PyResult<Option<(Bound<'py, PyAny>, Bound<'py, PyAny>, usize)>> {
        let Some(all) = self.all.as_ref().filter(|all| all.states().len() > 0) else {
            return Ok(None);
        };
        let state = all.states().state(0);
        let [q, v] = [&state.q, &state.v].map(|x| vector(py, x.as_slice()));
        Ok(Some((q, v, all.length(0))))
    }
} }

impl PyBalance {
    /// Reads actions, without a copy on the way if they are those of Gymnasium, in single precision.
    fn read_actions(&mut self, given: &Bound<'_, PyAny>) -> PyResult<()> {
        let n = self.next.rewards.len();
        let nu = self.actions.len() / n.max(1);
        let own = self.actions.iter_mut();
        let refused = |shape: &[usize]| shape_error("actions", shape, format_args!("({n}, {nu})"));
        match given.cast::<PyArray2<f32>>() {
            Ok(array) if array.is_c_contiguous() => {
                if array.shape() != [n, nu] {
                    return Err(refused(array.shape()));
                }
                let numbers = array.readonly();
                let numbers = numbers.as_slice().map_err(value_error)?;
                own.zip(numbers).for_each(|(own, x)| *own = f64::from(*x));
            }
            _ => {
                let rows = Rows::read(&argument("actions", given, &[]))?;
                if rows.batch() != [n, nu] {
                    return Err(refused(rows.batch()));
                }
                own.zip(rows.as_slice()).for_each(|(own, x)| *own = *x);
            }
        }
        match self.actions.iter().position(|x| !x.is_finite()) {
            None => Ok(()),
            Some(k) => Err(invalid!(
                "the action of environment {} is not finite: {}",
                k / nu,
                self.actions[k]
            )),
        }
    }

    fn refuse_ended(&self) -> PyResult<()> {
        let mut all = self.all.iter();
        match self.auto_reset == AutoReset::Never && all.any(Environments::needs_reset) {
            true => Err(PyRuntimeError::new_err(
                "an episode is over: reset it (in a batch with options={'reset_mask': flags})",
            )),
            false => Ok(()),
        }
    }
}

/// Reads bounds; those of starts are finite.
fn bounds(
    name: &'static str,
    (low, high): &(Bound<'_, PyAny>, Bound<'_, PyAny>),
    length: usize,
    are_finite: bool,
) -> PyResult<Bounds> {
    let read = |value| read_vector(name, value, Some(length));
    let [low, high] = [read(low)?, read(high)?];
    for (k, (low, high)) in low.iter().zip(&high).enumerate() {
        let is_finite = low.is_finite() && high.is_finite();
        let are_ordered = low <= high;
        if !are_ordered || (are_finite && !is_finite) {
            refuse!("{name}: the bounds of entry {k} are {low} and {high}");
        }
    }
    Ok([low, high])
}

/// Rows in single precision.
fn single<'py>(py: Python<'py>, numbers: &[f64], n: usize) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let flat = PyArray1::from_iter(py, numbers.iter().map(|x| *x as f32));
    flat.reshape([n, numbers.len() / n.max(1)])
}
