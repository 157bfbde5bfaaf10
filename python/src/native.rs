//! Graphs as generated C that is compiled and loaded; simulators likewise: `simulator/native.rs`.

use dualbody_native::NativeFunction;

use crate::codegen::{PyGraph, each_row};
use crate::compiler::compiler_of;
use crate::prelude::*;
use crate::threads::stopped;

/// A graph as a function that the system's C compiler has compiled.
#[pyclass(frozen, name = "NativeFunction", module = "dualbody.native")]
pub(crate) struct PyNativeFunction {
    function: NativeFunction,
}

getters! { PyNativeFunction {
    /// Number of entries of all inputs.
    n_inputs: usize = |own| own.function.n_inputs();

    /// Number of entries of all outputs.
    n_outputs: usize = |own| own.function.n_outputs();
} }

#[pymethods]
impl PyNativeFunction {
    /// Outputs (..., n_outputs) at inputs (..., n_inputs), as Graph.evaluate.
    fn __call__<'py>(&self, inputs: &Bound<'py, PyAny>) -> PyResult<Array<'py>> {
        let sizes = [self.function.n_inputs(), self.function.n_outputs()];
        each_row(inputs, sizes, |x, y| self.function.call(x, y))
    }

    fn __repr__(&self) -> String {
        format!("{:?}", self.function)
    }
}

methods! { PyNativeFunction {
    /// Compiles a Graph as a C function of a given name, or finds it in the cache. Raises an OSError with the reason if that fails. Ctrl-C ends the compiler.
    #[new]
    fn new(graph: &Bound<'py, PyGraph>, name: &str, compiler = None) -> PyResult<Self> {
        let (py, compiler) = (graph.py(), compiler_of(compiler)?);
        let graph = &graph.get().graph;
        let made = stopped(py, || NativeFunction::new(graph, name, &compiler))?;
        Ok(Self {
            function: made.or_raise()?,
        })
    }
} }
