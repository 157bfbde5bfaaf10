//! The functions of `dualbody::dynamics` on arrays.
//!
//! | file | what it is |
//! |---|---|
//! | `table` | macros that make a function of Python from a function on one row |
//! | `names` | frames, representations, frames of momentum by name |
//! | `write` | results as numbers of an array |
//! | `hot` | RNEA, ABA, CRBA, on one state and on lanes |
//! | `matrices` | inverse of M, Coriolis matrix, derivatives of the dynamics |
//! | `manifold` | derivatives of moves and differences of configurations |
//! | `energy`, `com`, `momenta`, `frames`, `regressors` | what follows from a state |
//! | `base`, `external` | other velocities of the base, forces by name |

mod base;
mod com;
mod energy;
mod external;
mod frames;
mod hot;
mod manifold;
mod matrices;
mod momenta;
mod names;
mod regressors;
pub(crate) mod table;
mod write;

pub(crate) use base::{
    acceleration_from_representation, acceleration_to_representation, force_from_representation,
    force_to_representation, jacobian_to_representation, mass_matrix_to_representation,
    velocity_from_representation, velocity_to_representation,
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
pub(crate) use manifold::{
    _difference_jacobian, _integrate_jacobian, write_difference_jacobian, write_integrate_jacobian,
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
