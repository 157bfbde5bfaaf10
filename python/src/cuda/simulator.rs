//! The class `dualbody.cuda.Simulator`.

use std::path::PathBuf;

use pyo3::exceptions::PyFloatingPointError;

use super::motions::{Motions, ending_of};
use super::precision::{Either, Gpu, Wanted, on_either, on_gpu};
use crate::prelude::*;
use crate::simulator::{Given, read_inputs, write_row};
use crate::threads::stopped;

/// Steps of many states of a robot, or of variants of it, on a GPU. Its kernels are recorded and compiled when it is made.
///
/// count: states; parameters: {name: (count,)} of the robot in which states differ, named as in Model.parameter_names; precision: "double" or
/// "single", of the GPU (arrays are of float64); derivatives: "jacobians", "gradients", what is compiled besides the step; device: its number;
/// cache: folder of compiled kernels. An OSError says what is missing: the driver, the device, NVRTC. A ValueError where a step decides on
/// values, as rigid contact does. Ctrl-C ends it before the next kernel: NVRTC cannot be interrupted within one, which may take minutes for a humanoid.
#[pyclass(frozen, name = "CudaSimulator", module = "dualbody._dualbody")]
pub(crate) struct PyCudaSimulator {
    pub(super) gpu: Gpu,
    simulator: Py<PySimulator>,
}

getters! { PyCudaSimulator {
    /// The original simulator.
    simulator: Py<PySimulator> = |own, py| own.simulator.clone_ref(py);

    /// Names of the parameters that differ between states.
    parameter_names: Vec<&str> = |own| on_either!(&own.gpu, gpu => gpu.parameter_names());
} }

#[pymethods]
impl PyCudaSimulator {
    pub(super) fn __len__(&self) -> usize {
        on_either!(&self.gpu, gpu => gpu.len())
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let precision = match self.gpu {
            Gpu::Double(_) => "double",
            Gpu::Single(_) => "single",
        };
        let simulator = self.simulator.bind(py).repr()?;
        let count = self.__len__();
        Ok(format!(
            "cuda.Simulator({simulator}, {count} states, precision=\"{precision}\")"
        ))
    }
}

methods! { PyCudaSimulator {
    #[new]
    fn new(
        simulator: &Bound<'py, PySimulator>, count, *, parameters: Option<&Bound<'py, PyDict>> = None, precision: &str = "double",
        derivatives: Option<Vec<String>> = None, device = None, cache: Option<PathBuf> = None
    ) -> PyResult<Self> {
        let device = device.map_or(Ok(0), |device| whole("device", device))?;
        let count = whole("count", count)?;
        let derivatives = derivatives.unwrap_or_default();
        let wanted = Wanted::read(count, parameters, precision, &derivatives, device, cache)?;
        let own = &simulator.get().simulator;
        Ok(Self {
            gpu: stopped(simulator.py(), || wanted.make(own))??,
            simulator: simulator.clone().unbind(),
        })
    }

    /// Advances all states by one time step: the next (q, v), or (q, v, contact) if contact is given.
    ///
    /// q (count, nq), v (count, nv), u (count, nu; N·m or N; zero if left out), contact (count, n_contact); arguments that are equal for all states
    /// may lack the first axis, except one of them. Raises FloatingPointError that names the first state whose step fails.
    fn step(&self, q, v, u = None, *, contact = None) -> PyResult<Bound<'py, PyTuple>> {
        let py = q.py();
        let (given, states, inputs) = self.read(q, v, u, contact)?;
        let (next, endings) = on_gpu!(py, &self.gpu, gpu => {
                let mut on_gpu = gpu.states(&states)?;
                gpu.step(&mut on_gpu, &inputs)?;
                Ok((on_gpu.to_vec()?, on_gpu.endings()?))
        })?;
        let mut ends = endings.into_iter().enumerate();
        if let Some((k, (kind, _))) = ends.find_map(|(k, end)| Some((k, ending_of(end)?))) {
            let text = format!("the step of state {k} of the batch: {kind}");
            return Err(PyFloatingPointError::new_err(text));
        }
        let arrays = self.simulator.get().outputs(py, &given, None)?;
        let mut out: Vec<&mut [f64]> = arrays.iter().map(numbers_mut).collect();
        for (k, state) in next.iter().enumerate() {
            write_row(state, k, &mut out, |&x| x);
        }
        PyTuple::new(py, arrays)
    }

    /// Takes steps from each state, and returns a cuda.Rollout of each `every`-th state (of the first and the last state for 0).
    ///
    /// q, v, contact as in step; inputs (count, steps, nu) or (steps, nu) for all, zero if left out.
    fn rollout(&self, q, v, steps = None, *, inputs = None, every = None, contact = None) -> PyResult<Bound<'py, PyAny>> {
        let (py, own, count) = (q.py(), self.simulator.get(), self.__len__());
        let every = every.map_or(Ok(1), |every| whole("every", every))?;
        let given = own.read(q, v, None, contact)?;
        let (inputs, steps) = read_inputs(inputs, steps, own.simulator.nu())?;
        for (name, batch) in [
            ("q and v are", Some(&given.batch[..])),
            ("inputs are", inputs.as_ref().map(Rows::batch)),
        ] {
            self.check_batch(name, batch.unwrap_or(&[]), true)?;
        }
        let states = own.states(&given, count)?;
        let numbers = repeated(inputs.as_ref(), count, steps * own.simulator.nu());
        let motions =
            on_gpu!(py, &self.gpu, gpu => gpu.rollout_inputs(&states, steps, every, &numbers))?;
        let kept = 1 + steps.checked_div(every).unwrap_or(0);
        let motions = Motions::new(&motions, kept);
        let width = states.first().map_or(0, State::len);
        let all = PyArray1::from_vec(py, motions.kept).reshape([count, kept, width])?;
        let last = PyArray1::from_vec(py, motions.last).reshape([count, width])?;
        let make = of_package!(py, "cuda", "_rollout");
        make.call1((&self.simulator, all, last, motions.interval, motions.stopped))
    }

    /// Jacobians of the step of each state, as Simulator.linearize: a (count, n_tangent, n_tangent), b (count, n_tangent, nu). Arguments as in
    /// step. Needs derivatives=["jacobians"], and one robot for all states.
    fn linearize(&self, q, v, u = None, *, contact = None) -> PyResult<Bound<'py, PyAny>> {
        let py = q.py();
        let (given, states, inputs) = self.read(q, v, u, contact)?;
        let all = on_gpu!(py, &self.gpu, gpu => gpu.linearize(&states, &inputs))?;
        (self.simulator.get()).jacobians(py, &given.batch, &all)
    }

    /// Gradients of ⟨adjoint, next state⟩ of each state, as Simulator.vjp: a StepGradient (state, input, parameters, friction), in the parameters
    /// that differ between states, without friction.
    ///
    /// adjoint (count, n_tangent). Needs derivatives=["gradients"]. Raises FloatingPointError that names the first state without a gradient.
    fn vjp(&self, q, v, u, adjoint, *, contact = None) -> PyResult<Bound<'py, PyAny>> {
        let (py, n) = (q.py(), self.simulator.get().simulator.n_tangent());
        let (given, states, inputs) = self.read(q, v, Some(u), contact)?;
        let adjoint = Rows::read(&argument("adjoint", adjoint, &[n]))?;
        self.check_batch("adjoint is", adjoint.batch(), true)?;
        let weights = repeated(Some(&adjoint), self.__len__(), n);
        let found = on_gpu!(py, &self.gpu, gpu => gpu.gradients(&states, &inputs, &weights))?;
        if let Some(k) = found.status.iter().position(|&status| status != 0) {
            let text = format!("the step of state {k} of the batch has no gradient there");
            return Err(PyFloatingPointError::new_err(text));
        }
        let part = |x: &[f64], n: usize| stack(py, &given.batch, &[n], x.chunks(n.max(1)));
        let (nu, p) = (self.simulator.get().simulator.nu(), self.parameter_names().len());
        let arrays = (part(&found.state, n), part(&found.input, nu), part(&found.parameters, p), part(&[], 0));
        of_package!(py, "_rollout", "StepGradient").call1(arrays)
    }
} }

impl PyCudaSimulator {
    /// States and inputs of a call, for every state of the batch.
    pub(super) fn read<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        u: Option<&Bound<'py, PyAny>>,
        contact: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<(Given<'py>, Vec<State>, Vec<f64>)> {
        let (own, count) = (self.simulator.get(), self.__len__());
        let given = own.read(q, v, u, contact)?;
        self.check_batch("q, v and u are", &given.batch, false)?;
        let (states, inputs) = (own.states(&given, count)?, own.inputs(&given, count)?);
        Ok((given, states, inputs))
    }

    /// Checks that a batch has as many states as the simulator was made for, or, where it is `shared`, none.
    fn check_batch(&self, what: &str, batch: &[usize], shared: bool) -> PyResult<()> {
        let count = self.__len__();
        let fits = batch.iter().product::<usize>() == count && !batch.is_empty();
        if fits || (shared && batch.is_empty()) {
            return Ok(());
        }
        Err(invalid!(
            "{what} of a batch of shape {batch:?}, expected ({count},)"
        ))
    }
}

/// Numbers for each state: those of its row, or of the only one; zeros without rows.
fn repeated(rows: Option<&Rows<'_>>, count: usize, width: usize) -> Vec<f64> {
    rows.map_or_else(
        || vec![0.0; count * width],
        |rows| {
            let view = rows.view();
            (0..count).flat_map(|k| view.row(k)).copied().collect()
        },
    )
}
