//! The functions of `dualbody::dynamics` on arrays.
//!
//! | file | what it is |
//! |---|---|
//! | `table` | macros that make a function of Python from a function on one row |
//! | `names` | frames, representations, frames of momentum by name |
//! | `write` | results as numbers of an array |
//! | `hot` | RNEA, ABA, CRBA, on one state and on lanes |
//! | `matrices` | inverse of M, Coriolis matrix, derivatives of the dynamics |
//! | `manifold`, `tangents` | derivatives of moves and differences of configurations |
//! | `energy`, `com`, `momenta`, `frames`, `regressors` | what follows from a state |
//! | `base`, `based`, `external` | other velocities of the base, forces by name |
//! | `links` | all links at once |

mod base;
mod based;
mod com;
mod energy;
mod external;
mod frames;
mod hot;
mod links;
mod manifold;
mod matrices;
mod momenta;
mod names;
mod regressors;
pub(crate) mod table;
mod tangents;
mod write;

pub(crate) use base::{
    acceleration_from_representation, acceleration_to_representation, force_from_representation,
    force_to_representation, jacobian_to_representation, mass_matrix_to_representation,
    velocity_from_representation, velocity_to_representation,
};
pub(crate) use based::{
    _base_average_velocity_jacobian, _base_bias_forces, _base_center_of_mass_acceleration,
    _base_center_of_mass_jacobian, _base_center_of_mass_velocity,
    _base_centroidal_momentum_matrix_derivative, _base_centroidal_momentum_rate,
    _base_coriolis_matrix, _base_forward_dynamics, _base_frame_acceleration,
    _base_frame_bias_acceleration, _base_frame_jacobian, _base_frame_jacobian_derivative,
    _base_frame_velocity, _base_gravity_forces, _base_inverse_dynamics, _base_mass_matrix,
    _base_mass_matrix_inverse, _base_momentum, _base_momentum_matrix, _base_state_tangents,
};
pub(crate) use com::{
    center_of_mass, center_of_mass_acceleration, center_of_mass_derivatives,
    center_of_mass_jacobian, center_of_mass_velocity,
};
pub(crate) use energy::{elastic_energy, kinetic_energy, passive_forces, potential_energy};
pub(crate) use external::{check_mass_matrix, external_forces};
pub(crate) use frames::{
    _frame_velocity_derivatives, forward_kinematics, frame_acceleration, frame_bias_acceleration,
    frame_jacobian, frame_jacobian_derivative, frame_placement_derivatives, frame_pose,
    frame_velocity,
};
pub(crate) use hot::{
    aba, bias_forces, forward_dynamics, gravity_forces, inverse_dynamics, mass_matrix, on_both,
    rnea,
};
pub(crate) use links::{
    link_accelerations, link_jacobian_derivatives, link_jacobians, link_velocities,
};
pub(crate) use manifold::{
    _deviation, _difference_jacobian, _integrate_jacobian, write_difference_jacobian,
    write_integrate_jacobian,
};
pub(crate) use matrices::{
    _forward_dynamics_derivatives, _inverse_dynamics_derivatives, coriolis_matrix, forward_slopes,
    inverse_dynamics_second_derivatives, inverse_slopes, mass_matrix_inverse,
};
pub(crate) use momenta::{
    _centroidal_momentum_derivatives, average_velocity, average_velocity_jacobian,
    centroidal_momentum, centroidal_momentum_matrix, centroidal_momentum_matrix_derivative,
    centroidal_momentum_rate, locked_inertia, momentum, momentum_matrix,
};
pub(crate) use names::Named;
pub(crate) use regressors::{
    joint_torque_regressor, kinetic_energy_regressor, potential_energy_regressor,
};
pub(crate) use write::write_pose;
