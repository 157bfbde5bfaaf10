//! The Python package `dualbody`: arrays in, arrays out.
//!
//! | file | what it is |
//! |---|---|
//! | `arrays` | arguments, batches, results |
//! | `scratch` | working memory of the hot functions |
//! | `threads` | threads of batches, Ctrl-C, progress |
//! | `limits` | the memory that results may take |
//! | `errors`, `words`, `raised`, `options` | errors as exceptions, in Python's words, exceptions of functions, options as keywords |
//! | `counts`, `kinds` | arguments that are whole numbers, or objects of certain classes |
//! | `compiler` | the C compiler of generated code |
//! | `jax` | what compiled programs of JAX call |
//! | `model`, `dynamics`, `contact`, `simulator`, `control`, `trajopt`, `identify`, `least_squares`, `codegen`, `native`, `spatial`, `view`, `world` | an area of the library each |
//!
//! What describes something (contacts, motors, costs) is a small class in Python, which prints and pickles by itself; the functions here read it.

mod arrays;
mod codegen;
mod compiler;
mod contact;
mod control;
mod counts;
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
mod raised;
mod scratch;
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
    use super::codegen::{_trace_model, _trace_step, PyGraph};
    #[pymodule_export]
    use super::contact::{
        _estimate_soft_contact, _impact_time, _restitution, _terrain_surface, _with_restitution,
    };
    #[pymodule_export]
    use super::control::{_computed_torque, _finite_horizon_lqr, _lqr};
    #[cfg(feature = "cuda")]
    #[pymodule_export]
    use super::cuda::PyCudaSimulator;
    #[pymodule_export]
    use super::dynamics::{
        _base_average_velocity_jacobian, _base_bias_forces, _base_center_of_mass_acceleration,
        _base_center_of_mass_jacobian, _base_center_of_mass_velocity,
        _base_centroidal_momentum_matrix_derivative, _base_centroidal_momentum_rate,
        _base_coriolis_matrix, _base_forward_dynamics, _base_frame_acceleration,
        _base_frame_bias_acceleration, _base_frame_jacobian, _base_frame_jacobian_derivative,
        _base_frame_velocity, _base_gravity_forces, _base_inverse_dynamics, _base_mass_matrix,
        _base_mass_matrix_inverse, _base_momentum, _base_momentum_matrix, _base_state_tangents,
        _centroidal_momentum_derivatives, _difference_jacobian, _forward_dynamics_derivatives,
        _frame_velocity_derivatives, _integrate_jacobian, _inverse_dynamics_derivatives,
        acceleration_from_representation, acceleration_to_representation, average_velocity,
        average_velocity_jacobian, bias_forces, center_of_mass, center_of_mass_acceleration,
        center_of_mass_derivatives, center_of_mass_jacobian, center_of_mass_velocity,
        centroidal_momentum, centroidal_momentum_matrix, centroidal_momentum_matrix_derivative,
        centroidal_momentum_rate, check_mass_matrix, coriolis_matrix, elastic_energy,
        external_forces, force_from_representation, force_to_representation, forward_dynamics,
        forward_kinematics, frame_acceleration, frame_bias_acceleration, frame_jacobian,
        frame_jacobian_derivative, frame_placement_derivatives, frame_pose, frame_velocity,
        gravity_forces, inverse_dynamics, inverse_dynamics_second_derivatives,
        jacobian_to_representation, joint_torque_regressor, kinetic_energy,
        kinetic_energy_regressor, link_accelerations, link_jacobian_derivatives, link_jacobians,
        link_velocities, locked_inertia, mass_matrix, mass_matrix_inverse,
        mass_matrix_to_representation, momentum, momentum_matrix, passive_forces, potential_energy,
        potential_energy_regressor, velocity_from_representation, velocity_to_representation,
    };
    #[pymodule_export]
    use super::identify::{
        _base_parameters, _estimate, _excite, _excited, _predict, _prepare, _regressor,
        _regressor_matrix, _restored_estimate, _shoot, _validate, PyEstimate,
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
        _load_model, _random_state, _sample, _sample_urdf, _unit_joint_forces, PyEngineCoordinates,
        PyImportReport, PyModel,
    };
    #[pymodule_export]
    use super::native::PyNativeFunction;
    #[pymodule_export]
    use super::simulator::{_simulator, PyNativeSimulator, PySimulator};
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
    use super::world::{PyWorld, _build_world, carried_state};
    #[pymodule_export]
    use super::view::{_plot, _recording, PyPlot, PyRecording};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        super::errors::silence_panics();
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
