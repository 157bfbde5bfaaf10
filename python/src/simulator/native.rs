//! Simulators whose steps are compiled.

use dualbody_native::{NativeScratch, NativeSimulator};
use dualbody_python_trace as trace;

use super::given::States;
use super::memory::StepMemory;
use super::rollout::Asked;
use super::single::Control;
use super::step::{diverged, write_row};
use crate::compiler::compiler_of;
use crate::model::next_id;
use crate::prelude::*;
use crate::threads::stopped;

/// A Simulator whose steps are compiled for its robot by the system's C compiler.
///
/// Where a step takes something for granted that does not hold at a state, the library's own code computes it: results are the same to
/// rounding. Pickles: it is compiled again where it is loaded, unless there is no compiler.
#[pyclass(frozen, name = "NativeSimulator", module = "dualbody.native")]
pub(crate) struct PyNativeSimulator {
    native: NativeSimulator,
    simulator: Py<PySimulator>,
    /// The compiler, if not the default one.
    compiler: Option<Py<PyAny>>,
    /// The number by which its memory is known.
    id: u64,
}

getters! { PyNativeSimulator {
    /// The original simulator.
    simulator: Py<PySimulator> = |own, py| own.simulator.clone_ref(py);

    /// Reason why the step was not compiled; None if it was.
    reason: Option<String> = |own| own.native.reason().map(ToString::to_string);
} }

#[pymethods]
impl PyNativeSimulator {
    fn __reduce__<'py>(&self, py: Python<'py>) -> Recipe<'py> {
        let make = of_package!(py, "native", "_native_simulator");
        let simulator = self.simulator.clone_ref(py);
        let compiler = self.compiler.as_ref().map(|own| own.clone_ref(py));
        let parts = (simulator, compiler).into_pyobject(py)?;
        Ok((make.clone(), parts.into_any()))
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let simulator = self.simulator.bind(py).repr()?;
        Ok(match self.native.reason() {
            None => format!("NativeSimulator({simulator})"),
            Some(reason) => format!("NativeSimulator({simulator}, not compiled: {reason})"),
        })
    }
}

methods! { PyNativeSimulator {
    /// Compiles the step of a simulator, or finds it in the cache.
    ///
    /// Raises an OSError with the reason if compilation fails, and a ValueError if a step depends on values by branches, as most contact does. Ctrl-C
    /// ends the compiler.
    #[new]
    fn new(simulator: &Bound<'py, PySimulator>, compiler = None) -> PyResult<Self> {
        let (own, with) = (&simulator.get().simulator, compiler_of(compiler)?);
        let make = || trace::native((**own).clone(), &with);
        let native = stopped(simulator.py(), make)?.or_raise()?;
        Ok(Self::of(simulator, native, compiler))
    }

    /// As the constructor, with the library's own code if compilation fails; `reason` contains the cause.
    #[staticmethod]
    fn or_own(simulator: &Bound<'py, PySimulator>, compiler = None) -> PyResult<Self> {
        let (own, with) = (&simulator.get().simulator, compiler_of(compiler)?);
        let make = || trace::native_or_own((**own).clone(), &with);
        let native = stopped(simulator.py(), make)?;
        Ok(Self::of(simulator, native, compiler))
    }

    /// Advances by one time step, as Simulator.step; a batch on all cores.
    fn step(&self, q, v, u = None, *, contact = None, out: Option<&Bound<'py, PyTuple>> = None) -> PyResult<Bound<'py, PyTuple>> {
        let (py, own) = (q.py(), self.simulator.get());
        let given = own.read(q, v, u, contact)?;
        let one = |memory: &mut StepMemory| {
            let (state, next) = (&memory.state, &mut memory.next);
            self.with_memory(|own| self.native.step_into(state, &memory.u, own, next));
        };
        let (many, count) = (States::from(&given), given.count());
        own.take_step(py, &given, out, one, |out| {
            self.step_batch(&many, count, out)
        })
    }

    /// Jacobians of the step, as Simulator.linearize, by the library's own code.
    fn linearize(&self, q, v, u = None, *, contact = None) -> PyResult<Bound<'py, PyAny>> {
        let own = self.simulator.get();
        let given = own.read(q, v, u, contact)?;
        own.linearize_each(q.py(), &given, |state, u, linear| {
            self.with_memory(|own| self.native.linearize_into(state, u, own, linear));
        })
    }

    /// Takes steps from one state and returns a Rollout, as Simulator.rollout, which also runs batches on vector registers.
    fn rollout(&self, q, v, steps = None, *, control = None, inputs = None, contact = None, progress = None) -> PyResult<Bound<'py, PyAny>> {
        let own = self.simulator.get();
        let asked = Asked::read(own.simulator.nu(), steps, control, inputs)?;
        asked.check_memory(1, own)?;
        let given = own.read(q, v, None, contact)?;
        if !given.batch.is_empty() || !asked.batch().is_empty() {
            refuse!("compiled rollouts are of one state; simulator.rollout takes batches, on vector registers");
        }
        let roll = |initial: &State, steps, control: &mut Control<'_>| {
            self.native.rollout(initial, steps, control)
        };
        let states = own.states(&given, 1)?;
        asked.one(self.simulator.bind(q.py()), &states[0], progress, roll)
    }
} }

impl PyNativeSimulator {
    fn of(
        simulator: &Bound<'_, PySimulator>,
        native: NativeSimulator,
        compiler: Option<&Bound<'_, PyAny>>,
    ) -> Self {
        Self {
            native,
            simulator: simulator.clone().unbind(),
            compiler: compiler.map(|own| own.clone().unbind()),
            id: next_id(),
        }
    }

    fn with_memory<R>(&self, work: impl FnOnce(&mut NativeScratch) -> R) -> R {
        with_kept(self.id, || NativeScratch::new(&self.native), work)
    }

    fn step_batch(&self, given: &States<'_>, count: usize, out: &mut [&mut [f64]]) -> PyResult<()> {
        let own = self.simulator.get();
        let (mut states, inputs) = (own.states(*given, count)?, own.inputs(*given, count)?);
        guarded(|| self.native.step_states(&mut states, &inputs))?;
        if let Some(k) = states.iter().position(|state| !state.is_finite()) {
            return Err(diverged(Some(k)));
        }
        for (k, state) in states.iter().enumerate() {
            write_row(state, k, out, |&x| x);
        }
        Ok(())
    }
}
