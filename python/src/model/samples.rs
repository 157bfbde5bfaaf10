//! Robots that come with the library.

use dualbody::model::samples;
use pyo3::prelude::*;
use pyo3::types::{PyString, PyTuple};

use super::handle::PyModel;
use crate::counts::whole;
use crate::errors::{guarded, value_error};

/// One of the robots that come with the library.
#[pyfunction]
#[pyo3(signature = (name, *arguments))]
pub(crate) fn _sample(name: &str, arguments: &Bound<'_, PyTuple>) -> PyResult<PyModel> {
    let model = match name {
        "pendulum" => samples::pendulum(),
        "double_pendulum" => samples::double_pendulum(),
        "cartpole" => samples::cartpole(),
        "arm" => samples::arm(),
        "random_tree" => {
            let (n, seed) = (whole("n", &arguments.get_item(0)?)?, arguments.get_item(1)?);
            let seed = whole("seed", &seed)?;
            guarded(|| samples::random_tree(n, seed))?
        }
        _ => return Err(value_error(format_args!("there is no sample \"{name}\""))),
    };
    let py = arguments.py();
    let name = PyString::new(py, name).into_any();
    let all = std::iter::once(name).chain(arguments.iter());
    let recipe = PyTuple::new(py, all.collect::<Vec<_>>())?;
    Ok(PyModel::new(model, ("_sample", recipe)))
}
