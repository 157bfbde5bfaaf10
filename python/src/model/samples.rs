//! Robots that come with the library.

use dualbody::model::samples;
use pyo3::types::PyString;

use crate::prelude::*;

macro_rules! descriptions {
    ($($name:literal),*) => {
        [$(($name, include_str!(concat!("../../../assets/", $name, ".urdf")))),*]
    };
}

/// Descriptions of robots by name, which are in the module itself: an installed package has no files of the repository.
const DESCRIPTIONS: [(&str, &str); 12] = descriptions! {
    "acrobot", "box", "cartpole", "double_pendulum", "four_bar", "hopper", "humanoid", "panda", "quadrotor", "quadruped", "sphere", "ur5"
};

/// The URDF of a robot that comes with the library.
#[pyfunction]
pub(crate) fn _sample_urdf(name: &str) -> PyResult<&'static str> {
    choice("name", name, &DESCRIPTIONS)
}

functions! {
    /// One of the robots that come with the library.
    fn _sample(name: &str, *arguments) -> PyResult<PyModel> {
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
            _ => refuse!("there is no sample \"{name}\""),
        };
        let py = arguments.py();
        let name = PyString::new(py, name).into_any();
        let all = std::iter::once(name).chain(arguments.iter());
        let recipe = PyTuple::new(py, all.collect::<Vec<_>>())?;
        Ok(PyModel::new(model, ("_sample", recipe)))
    }
}
