//! States and inputs that a call is given, and those of rollouts.

use crate::prelude::*;

/// A state, or a batch of them, with an input: arrays of NumPy.
pub(crate) struct Given<'py> {
    pub(crate) q: Rows<'py>,
    pub(crate) v: Rows<'py>,
    pub(crate) u: Option<Rows<'py>>,
    pub(crate) contact: Option<Rows<'py>>,
    pub(crate) batch: Vec<usize>,
}

/// The rows of a state and an input, or of a batch of them.
#[derive(Clone, Copy)]
pub(crate) struct States<'a> {
    pub(crate) q: View<'a>,
    pub(crate) v: View<'a>,
    /// Zero if left out.
    pub(crate) u: Option<View<'a>>,
    /// State of contact, then activations; neutral if left out.
    pub(crate) contact: Option<View<'a>>,
    /// Whether errors name the index of a state.
    pub(crate) is_batch: bool,
}

impl Given<'_> {
    pub(crate) fn count(&self) -> usize {
        self.batch.iter().product()
    }
}

impl<'a> From<&'a Given<'_>> for States<'a> {
    fn from(given: &'a Given<'_>) -> Self {
        Self {
            q: given.q.view(),
            v: given.v.view(),
            u: given.u.as_ref().map(Rows::view),
            contact: given.contact.as_ref().map(Rows::view),
            is_batch: !given.batch.is_empty(),
        }
    }
}

impl States<'_> {
    /// The error of a state, with its index in a batch.
    #[cold]
    pub(super) fn named(&self, k: usize, error: PyErr) -> PyErr {
        if !self.is_batch {
            return error;
        }
        let text = Python::attach(|py| error.value(py).to_string());
        invalid!("state {k} of the batch: {text}")
    }
}

pub(crate) fn check_finite(name: &str, x: &[f64]) -> PyResult<()> {
    match x.iter().position(|x| !x.is_finite()) {
        None => Ok(()),
        Some(k) => Err(invalid!("{name}[{k}] is {}", x[k])),
    }
}

impl PySimulator {
    /// Reads states and inputs; the state of contact is neutral where none is given.
    pub(crate) fn read<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        u: Option<&Bound<'py, PyAny>>,
        contact: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Given<'py>> {
        let (nq, nv, nu, nc) = self.sizes();
        let read = |name, value: &Bound<'py, PyAny>, n: usize| {
            let rows = Rows::read(&argument(name, value, &[n]));
            rows.map_err(|error| about_base(q.py(), self.simulator.model(), error))
        };
        let neutral = || vector(q.py(), &vec![0.0; nc]);
        let neutral = (contact.is_none() && nc > 0).then(neutral);
        let contact = contact.or(neutral.as_ref());
        let given = Given {
            q: read("q", q, nq)?,
            v: read("v", v, nv)?,
            u: u.map(|u| read("u", u, nu)).transpose()?,
            contact: contact
                .map(|contact| read("contact", contact, nc))
                .transpose()?,
            batch: Vec::new(),
        };
        let names = ["q", "v", "u", "contact"];
        let present = [
            Some(&given.q),
            Some(&given.v),
            given.u.as_ref(),
            given.contact.as_ref(),
        ];
        let batches = names.into_iter().zip(present);
        let batch = common_batch(batches.filter_map(|(name, rows)| Some((name, rows?.batch()))))?;
        Ok(Given { batch, ..given })
    }

    /// Reads the k-th state, checked.
    pub(super) fn read_state(&self, given: &States<'_>, k: usize, out: &mut State) -> PyResult<()> {
        out.q.copy_from_slice(given.q.row(k));
        out.v.copy_from_slice(given.v.row(k));
        let beside = out.contact.iter_mut().chain(&mut out.activation);
        let beside = beside.chain(&mut out.sleep);
        match given.contact {
            Some(all) => beside.zip(all.row(k)).for_each(|(out, &x)| *out = x),
            None => beside.for_each(|out| *out = 0.0),
        }
        let checked = out.check(self.simulator.model()).or_raise();
        checked.map_err(|error| given.named(k, error))
    }

    pub(crate) fn states<'a>(
        &self,
        given: impl Into<States<'a>>,
        count: usize,
    ) -> PyResult<Vec<State>> {
        let (given, mut state) = (given.into(), self.simulator.neutral_state());
        let one = |k| (self.read_state(&given, k, &mut state)).map(|()| state.clone());
        (0..count).map(one).collect()
    }

    /// The inputs of all states, one after the other.
    pub(crate) fn inputs<'a>(
        &self,
        given: impl Into<States<'a>>,
        count: usize,
    ) -> PyResult<Vec<f64>> {
        let (given, nu) = (given.into(), self.simulator.nu());
        let Some(u) = given.u else {
            return Ok(vec![0.0; count * nu]);
        };
        let mut all = Vec::with_capacity(count * nu);
        for k in 0..count {
            check_finite("u", u.row(k)).map_err(|error| given.named(k, error))?;
            all.extend_from_slice(u.row(k));
        }
        Ok(all)
    }

    /// All states and their inputs.
    pub(crate) fn states_and_inputs(&self, given: &Given<'_>) -> PyResult<(Vec<State>, Vec<f64>)> {
        let count = given.count();
        Ok((self.states(given, count)?, self.inputs(given, count)?))
    }

    /// One state, not a batch.
    pub(crate) fn one<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        u: Option<&Bound<'py, PyAny>>,
        contact: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Given<'py>> {
        let given = self.read(q, v, u, contact)?;
        match given.batch.is_empty() {
            true => Ok(given),
            false => Err(invalid!(
                "one state is expected, not a batch of shape {:?}",
                given.batch
            )),
        }
    }
}

/// Reads inputs (…, steps, nu), and finds the number of steps.
pub(crate) fn read_inputs<'py>(
    inputs: Option<&Bound<'py, PyAny>>,
    steps: Option<&Bound<'py, PyAny>>,
    nu: usize,
) -> PyResult<(Option<Rows<'py>>, usize)> {
    let steps: Option<usize> = steps.map(|steps| whole("steps", steps)).transpose()?;
    let Some(inputs) = inputs else {
        let steps = steps.ok_or_else(|| value_error("steps is missing"))?;
        return Ok((None, steps));
    };
    let steps = match steps {
        Some(steps) => steps,
        None => {
            let array = numbers("inputs", inputs)?;
            let shape = array.shape();
            let axes = shape.len().checked_sub(2).map(|k| shape[k]);
            axes.ok_or_else(|| shape_error("inputs", shape, format_args!("(…, steps, {nu})")))?
        }
    };
    Ok((
        Some(Rows::read(&argument("inputs", inputs, &[steps, nu]))?),
        steps,
    ))
}

/// Reads the input that a control returned: a vector, or a number if there is one input.
pub(super) fn read_input(given: &Bound<'_, PyAny>, nu: usize, u: &mut [f64]) -> PyResult<()> {
    if nu == 1
        && let Ok(x) = given.extract::<f64>()
    {
        u[0] = x;
        return Ok(());
    }
    u.copy_from_slice(&read_vector("the control's input", given, Some(nu))?);
    Ok(())
}
