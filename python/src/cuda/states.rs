//! The class `dualbody.cuda.States`.

use std::sync::{Mutex, MutexGuard, PoisonError};

use dlpark::DlpackElement;
use dlpark::python::ExportRequest;
use dualbody_cuda::{CudaError, CudaSimulator, CudaStates, Device, Dlpack, Numbers, Real};
use pyo3::exceptions::PyBufferError;

use super::motions::ending_of;
use super::precision::{Either, Gpu, on_either};
use super::simulator::PyCudaSimulator;
use super::tensors;
use crate::prelude::*;

/// States of one precision on the device, with room for their input.
#[derive(Debug)]
pub(super) struct Held<R> {
    states: CudaStates<R>,
    input: Numbers<R>,
    none: Numbers<R>,
}

impl<R: Real + DlpackElement> Held<R> {
    pub(super) fn new(gpu: &CudaSimulator<R>, states: &[State]) -> Result<Self, CudaError> {
        let states = gpu.states(states)?;
        let device = states.numbers().device().clone();
        Ok(Self {
            input: Numbers::zeros(&device, gpu.nu(), gpu.len())?,
            none: Numbers::zeros(&device, 0, gpu.len())?,
            states,
        })
    }

    /// Takes steps with an input that is held; zero without one.
    fn advance(
        &mut self,
        gpu: &CudaSimulator<R>,
        steps: usize,
        input: Option<&Dlpack>,
    ) -> Result<(), CudaError> {
        match input {
            Some(input) => self.input.copy_from_dlpack(input)?,
            None => self.input = Numbers::zeros(self.input.device(), gpu.nu(), gpu.len())?,
        }
        let schedule = gpu.schedule(1, 0);
        (0..steps)
            .try_for_each(|_| gpu.run(schedule, &mut self.states, &self.input, &mut self.none))
    }

    fn device(&self) -> &Device {
        self.states.numbers().device()
    }
}

/// States in the precision of their simulator.
type OfEither = Either<Held<f64>, Held<f32>>;

/// States that stay on the GPU from step to step: what cuda.Simulator.states returns.
///
/// Arrays of other packages on the GPU (PyTorch, CuPy, JAX) are read and made by the protocol of DLPack, without a way over the host: `torch.from_dlpack(states)`
/// is a copy of all numbers, (n, count): a row for each number of a state (q, v, contact), a column for each state, in float64 or float32 as the
/// simulator's precision says. A state whose motion diverges stops at its last valid state, until copy_from replaces it.
#[pyclass(frozen, name = "CudaStates", module = "dualbody._dualbody")]
pub(crate) struct PyCudaStates {
    gpu: Py<PyCudaSimulator>,
    held: Mutex<OfEither>,
}

impl PyCudaStates {
    pub(super) fn new(gpu: Py<PyCudaSimulator>, held: OfEither) -> Self {
        Self {
            gpu,
            held: Mutex::new(held),
        }
    }

    fn held(&self) -> MutexGuard<'_, OfEither> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn device(&self) -> Device {
        on_either!(&*self.held(), own => own.device().clone())
    }

    /// Work on the states without the interpreter lock; what fails is raised.
    fn work<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&Gpu, &mut OfEither) -> Result<T, CudaError> + Send,
    ) -> PyResult<T> {
        let gpu = &self.gpu.get().gpu;
        let done = py.detach(|| guarded(|| work(gpu, &mut self.held())));
        done.and_then(OrRaise::or_raise)
    }
}

methods! { PyCudaSimulator {
    /// Puts states on the GPU, where they stay: a cuda.States. Arguments as in step.
    fn states(this: &Bound<'py, Self>, q, v, *, contact = None) -> PyResult<PyCudaStates> {
        let (py, own) = (q.py(), this.get());
        let (_, states, _) = own.read(q, v, None, contact)?;
        let held = match &own.gpu {
            Gpu::Double(gpu) => put(py, gpu, &states).map(OfEither::Double),
            Gpu::Single(gpu) => put(py, gpu, &states).map(OfEither::Single),
        };
        Ok(PyCudaStates::new(this.clone().unbind(), held?))
    }
} }

/// Puts states on the device of a simulator.
fn put<R: Real + DlpackElement>(
    py: Python<'_>,
    gpu: &CudaSimulator<R>,
    states: &[State],
) -> PyResult<Held<R>> {
    py.detach(|| guarded(|| Held::new(gpu, states)))?.or_raise()
}

#[pymethods]
impl PyCudaStates {
    fn __len__(&self, py: Python<'_>) -> usize {
        self.gpu.bind(py).get().__len__()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let simulator = self.gpu.bind(py).repr()?;
        let n = on_either!(&*self.held(), own => own.states.numbers().rows());
        Ok(format!("cuda.States({n} numbers each, of {simulator})"))
    }

    /// The Status of each state, with the step at which its motion ended, counted from the last copy_from. Waits for the device.
    #[getter]
    fn status<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let endings = self.work(py, |_, held| on_either!(held, own => own.states.endings()))?;
        let count = endings.len();
        let ended = endings.into_iter().enumerate();
        let stopped: Vec<_> = ended
            .filter_map(|(k, end)| Some((k, ending_of(end)?)))
            .collect();
        of_package!(py, "_rollout", "_statuses").call1((count, stopped, true))
    }

    /// The kind and the number of the device, as DLPack counts.
    fn __dlpack_device__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let (kind, number): (u32, i32) = tensors::place(&self.device())?.into();
        PyTuple::new(py, [i64::from(kind), i64::from(number)])
    }
}

methods! { PyCudaStates {
    /// Takes `steps` steps of all states with an input that is held: u (nu, count), an array on the GPU of the simulator's precision, in C order
    /// (`actions.T.contiguous()` of a policy's (count, nu)); zero if it is left out.
    fn advance(&self, py: Python, u = None, steps = None) -> PyResult<()> {
        let steps = steps.map_or(Ok(1), |steps| whole("steps", steps))?;
        let input = u.map(|u| tensors::read("u", u, &self.device())).transpose()?;
        self.work(py, |gpu, held| match (gpu, held) {
            (Gpu::Double(gpu), OfEither::Double(own)) => own.advance(gpu, steps, input.as_ref()),
            (Gpu::Single(gpu), OfEither::Single(own)) => own.advance(gpu, steps, input.as_ref()),
            _ => unreachable!("states have the precision of their simulator"),
        })
    }

    /// Replaces all states by those of an array on the GPU, (n, count), as `torch.from_dlpack(states)` makes it: for example, `torch.where(done, start, x)`
    /// begins some anew. Motions that had ended go on.
    fn copy_from(&self, py: Python, states) -> PyResult<()> {
        let tensor = tensors::read("states", states, &self.device())?;
        self.work(py, |_, held| on_either!(held, own => own.states.copy_from_dlpack(&tensor)))
    }

    /// All numbers, (count, n): q, v, contact of each state, from the device.
    fn numbers(&self, py: Python) -> PyResult<Bound<'py, PyAny>> {
        let all = self.work(py, |_, held| {
            on_either!(held, own => {
                let all = own.states.numbers().download_states()?;
                Ok(all.iter().map(|x| x.to_f64()).collect::<Vec<f64>>())
            })
        })?;
        let count = self.__len__(py);
        let width = all.len() / count;
        PyArray1::from_vec(py, all).call_method1("reshape", ((count, width),))
    }

    /// A copy for another package; see the class.
    fn __dlpack__(
        &self, py: Python, *, stream = None, max_version: Option<(u32, u32)> = None, dl_device: Option<(u32, i32)> = None, copy: Option<bool> = None
    ) -> PyResult<Py<PyAny>> {
        if copy == Some(false) {
            return Err(PyBufferError::new_err("states are passed on as copies"));
        }
        let request = ExportRequest::parse(stream, max_version, dl_device, None)?;
        tensors::write(py, &request, &self.device(), || {
            self.work(py, |_, held| on_either!(held, own => own.states.to_dlpack()))
        })
    }
} }
