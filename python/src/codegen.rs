//! Dynamics and steps as graphs of operations, and as C.

use dualbody::codegen::{Precision, check_origin};
use dualbody::scalar::traced::{BrokenCondition, Graph, Port};
use dualbody_python_trace as trace;

use crate::prelude::*;

/// A computation as a graph of operations on numbers: it is evaluated, differentiated, and written as C.
#[pyclass(frozen, name = "Graph", module = "dualbody.codegen")]
pub(crate) struct PyGraph {
    pub(crate) graph: Graph,
}

/// Name, rows, columns, unit.
type PortNumbers = (String, usize, usize, String);

fn ports(ports: &[Port]) -> Vec<PortNumbers> {
    let one = |port: &Port| {
        let (name, unit) = (port.name.to_owned(), port.unit.to_owned());
        (name, port.rows, port.columns, unit)
    };
    ports.iter().map(one).collect()
}

fn texts(names: &[String]) -> Vec<&str> {
    names.iter().map(String::as_str).collect()
}

/// Traces a function of a robot.
#[pyfunction]
pub(crate) fn _trace_model(name: &str, model: &Bound<'_, PyModel>) -> PyResult<PyGraph> {
    let record = choice("function", name, trace::OF_MODELS)?;
    let graph = guarded(|| record(&model.get().model))?;
    Ok(PyGraph { graph })
}

/// Traces the step of a simulator.
#[pyfunction]
pub(crate) fn _trace_step(simulator: &Bound<'_, PySimulator>) -> PyResult<PyGraph> {
    let graph = guarded(|| trace::step(&simulator.get().simulator))?;
    Ok(PyGraph { graph })
}

/// Outputs (…, m) of a function of inputs (…, n), row by row.
pub(crate) fn each_row<'py>(
    inputs: &Bound<'py, PyAny>,
    [n, m]: [usize; 2],
    mut one: impl FnMut(&[f64], &mut [f64]) -> Result<(), BrokenCondition> + Send,
) -> PyResult<Array<'py>> {
    let rows = Rows::read(&argument("inputs", inputs, &[n]))?;
    let array = room(inputs.py(), &[rows.batch(), &[m]].concat())?;
    let (given, out) = (rows.as_slice(), numbers_mut(&array));
    let count: usize = rows.batch().iter().product();
    let all = || {
        (0..count).try_for_each(|k| one(&given[k * n..(k + 1) * n], &mut out[k * m..(k + 1) * m]))
    };
    (inputs.py()).detach(|| guarded(all))?.or_raise()?;
    Ok(array)
}

getters! { PyGraph {
    /// Inputs, in the order of the input array: [(name, rows, columns, unit)].
    inputs: Vec<PortNumbers> = |own| ports(own.graph.inputs());

    /// Outputs, likewise; matrices in column-major order.
    outputs: Vec<PortNumbers> = |own| ports(own.graph.outputs());

    /// Number of entries of all inputs.
    n_inputs: usize = |own| own.graph.n_inputs();

    /// Number of entries of all outputs.
    n_outputs: usize = |own| own.graph.n_outputs();

    /// Number of operations.
    operations: usize = |own| own.graph.counts().operations();
} }

#[pymethods]
impl PyGraph {
    /// Conditions of the graph, as text: if one is violated, evaluation raises a ValueError.
    #[getter]
    fn conditions(&self) -> Vec<String> {
        let all = self.graph.conditions().iter();
        all.map(|own| own.condition.clone()).collect()
    }

    /// Outputs (..., n_outputs) at inputs (..., n_inputs).
    fn evaluate<'py>(&self, inputs: &Bound<'py, PyAny>) -> PyResult<Array<'py>> {
        let sizes = [self.graph.n_inputs(), self.graph.n_outputs()];
        let mut scratch = self.graph.scratch::<f64>();
        each_row(inputs, sizes, |x, y| {
            self.graph.evaluate_into(x, &mut scratch, y)
        })
    }

    /// Raises a ValueError unless the graph was recorded from this robot with its current parameters.
    fn check_origin(&self, model: &Bound<'_, PyModel>) -> PyResult<()> {
        check_origin(self.graph.origin(), &*model.get().model).or_raise()
    }

    fn __repr__(&self) -> String {
        let names = |ports: &[Port]| {
            let all = ports.iter().map(|port| port.name.to_owned());
            all.collect::<Vec<_>>().join(", ")
        };
        let (x, y) = (names(self.graph.inputs()), names(self.graph.outputs()));
        format!("Graph(({x}) -> ({y}), {} operations)", self.operations())
    }
}

methods! { PyGraph {
    /// Graph of the Jacobians of outputs in inputs: an output dy_dx for each of outputs y and inputs x.
    fn jacobian(&self, outputs: Vec<String>, inputs: Vec<String>) -> PyResult<Self> {
        Ok(Self { graph: self.graph.jacobian(&texts(&outputs), &texts(&inputs)).or_raise()? })
    }

    /// Graph of the gradient of a scalar output: an output dy_dx for each of the inputs x.
    fn gradient(&self, output: &str, inputs: Vec<String>) -> PyResult<Self> {
        Ok(Self { graph: self.graph.gradient(output, &texts(&inputs)).or_raise()? })
    }

    /// Graph of products of weights with the Jacobian: an additional input y_weight for each output y, an output x_weight for each of the inputs x.
    fn adjoint(&self, inputs: Vec<String>) -> PyResult<Self> {
        Ok(Self { graph: self.graph.adjoint(&texts(&inputs)).or_raise()? })
    }

    /// The graph as a function of C99: a Source (name, header, source). precision: "double" or "single".
    fn to_c(&self, py: Python, name: &str, precision: &str = "double") -> PyResult<Bound<'py, PyAny>> {
        let precision = variant("precision", precision, &[Precision::Double, Precision::Single])?;
        let text = guarded(|| self.graph.to_c(name, precision))?.or_raise()?;
        let texts = (&text.name, &text.header, &text.source);
        of_package!(py, "codegen", "Source").call1(texts)
    }
} }
