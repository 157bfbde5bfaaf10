//! The Python package `dualbody`: arrays in, arrays out.
//!
//! | file | what it is |
//! |---|---|
//! | `arrays` | arguments, batches, results |
//! | `scratch` | working memory of the hot functions |
//! | `threads` | threads of batches, Ctrl-C, progress |
//! | `limits` | the memory that results may take |
//! | `errors`, `words`, `raised`, `options` | errors as exceptions, in the words of Python, exceptions of functions, options as keywords |
//! | `python` | macros for attributes, methods and functions, whose arguments are written as in Python; `stubs.py` makes the types of them |
//! | `kinds` | arguments that are whole numbers, attributes, objects of certain classes |
//! | `prelude` | the items of these that most files use |
//! | `calls` | functions with their derivatives, as JAX and PyTorch call them |
//! | `jax` | how compiled programs of JAX call them |
//! | `model`, `dynamics`, `contact`, `simulator`, `control`, `trajopt`, `identify`, `least_squares`, `codegen`, `native`, `sensors`, `spatial`, `view`, `world` | an area of the library each |
//!
//! Descriptions (contacts, motors, costs) are small classes in Python, which print and pickle by themselves; the functions here read them.

mod arrays;
mod calls;
mod codegen;
mod compiler;
mod contact;
mod control;
#[cfg(feature = "cuda")]
mod cuda;
mod dynamics;
mod errors;
mod identify;
mod jax;
mod kinds;
mod least_squares;
mod limits;
mod model;
mod native;
mod options;
mod prelude;
mod python;
mod raised;
mod scratch;
mod sensors;
mod simulator;
mod spatial;
mod threads;
mod trajopt;
mod view;
mod words;
mod world;

use pyo3::prelude::*;

#[pymodule(gil_used = false)]
mod _dualbody {
    use pyo3::prelude::*;

    #[pymodule_export]
    use super::calls::{_call, _signature, _table};
    #[pymodule_export]
    use super::codegen::{_trace_model, _trace_step, PyGraph};
    #[pymodule_export]
    use super::contact::{
        _estimate_soft_contact, _impact_time, _nearest, _restitution, _srdf, _surface_grid,
        _terrain_surface, _tiled, _with_restitution,
    };
    #[pymodule_export]
    use super::control::{_computed_torque, _finite_horizon_lqr, _lqr};
    #[cfg(feature = "cuda")]
    #[pymodule_export]
    use super::cuda::{PyCudaSimulator, PyCudaStates};
    #[pymodule_export]
    use super::dynamics::check_mass_matrix;
    #[pymodule_export]
    use super::identify::{
        _base_parameters, _consistent, _estimate, _excite, _excited, _hold_back, _identified,
        _intervals, _predict, _prepare, _regressor, _regressor_matrix, _report, _shoot, _validate,
    };
    #[pymodule_export]
    use super::jax::{_foreign_function, _foreign_name};
    #[pymodule_export]
    use super::least_squares::{_least_squares, _loss};
    #[pymodule_export]
    use super::limits::{_check_grid, memory_limit, set_memory_limit};
    #[pymodule_export]
    use super::model::{
        _build_model, _edited, _hardware, _hardware_jacobian, _hardware_model, _import_report,
        _load_model, _load_scene, _random_state, _sample, _sample_urdf, _scene_model,
        _solid_inertia, _unit_joint_forces, PyEngineCoordinates, PyImportReport, PyModel, PyScene,
    };
    #[pymodule_export]
    use super::native::PyNativeFunction;
    #[pymodule_export]
    use super::sensors::{PyNoisySensors, PySensors};
    #[pymodule_export]
    use super::simulator::{
        _simulator, PyBalance, PyBatchSimulator, PyNativeSimulator, PySimulator,
    };
    #[pymodule_export]
    use super::spatial::{_pose, _rotation};
    #[pymodule_export]
    use super::threads::{set_threads, threads};
    #[pymodule_export]
    use super::trajopt::{
        _curve_at, _ddp, _position_bounds, _shooting_at, _shooting_variables, _single_shooting,
        _trajectory_cost, _transcription, PyRecedingHorizon,
    };
    #[pymodule_export]
    use super::view::{_plot, _recording, PyLive, PyPictures, PyPlot, PyRecording};
    #[pymodule_export]
    use super::world::{_build_world, _world, PyWorld, carried_state};

    /// Runs the program `dualbody` with the arguments of a process; its exit status.
    #[pyfunction]
    fn _command(py: Python<'_>, arguments: Vec<String>) -> PyResult<u8> {
        py.detach(|| super::errors::guarded(|| dualbody::command::run(arguments)))
    }

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        super::errors::silence_panics();
        super::dynamics::add_to(module)?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
