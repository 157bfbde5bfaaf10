//! Multibody dynamics: one file per algorithm, each written once over the scalar.
//!
//! | question | function | cost | reference |
//! |---|---|---|---|
//! | poses and velocities of all bodies? | [`forward_kinematics`] | O(n) | [Featherstone 2008, 3.2] |
//! | pose and velocity of a frame? | [`frame_pose`], [`frame_velocity`] | O(depth) | |
//! | acceleration of a frame? | [`frame_acceleration`], [`frame_bias_acceleration`] | O(depth) | |
//! | rate of its Jacobian? | [`frame_jacobian_derivative`] | O(depth) | |
//! | frame Jacobian? | [`frame_jacobian`] | O(depth) | [Featherstone 2008, 4.1] |
//! | Jacobians of all links, and their rates? | [`frame_jacobians`], [`frame_jacobian_derivatives`] | O(n · depth) | |
//! | joint forces for given accelerations? | [`inverse_dynamics`] | O(n) | [Featherstone 2008, table 5.1] |
//! | gravity and bias forces? | [`gravity_forces`], [`bias_forces`] | O(n) | [Featherstone 2008, table 5.1] |
//! | mass matrix M(q)? | [`mass_matrix`] | O(n · depth) | [Featherstone 2008, table 6.2] |
//! | its inverse M(q)⁻¹? | [`mass_matrix_inverse`] | O(n²) | [Carpentier 2018] |
//! | solution of M x = b? | [`MassMatrixFactor`] | O(n · depth) | [Featherstone 2008, table 6.3] |
//! | Coriolis matrix C(q, v) with Ṁ − 2C skew? | [`coriolis_matrix`] | O(n · depth) | [Echeandia, Wensing 2021] |
//! | accelerations for given joint forces? | [`forward_dynamics`] | O(n) | [Featherstone 2008, table 7.1] |
//! | centre of mass? | [`center_of_mass`] | O(n) | |
//! | its velocity, Jacobian and acceleration? | [`center_of_mass_velocity`], [`center_of_mass_jacobian`], [`center_of_mass_acceleration`] | O(n) | |
//! | momentum and its rate? | [`centroidal_momentum`], [`centroidal_momentum_rate`], [`momentum`] | O(n) | [Orin, Goswami, Lee 2013] |
//! | momentum matrix? | [`centroidal_momentum_matrix`], [`momentum_matrix`] | O(n) | [Orin, Goswami, Lee 2013] |
//! | locked inertia and average velocity? | [`locked_inertia`], [`average_velocity`], [`average_velocity_jacobian`] | O(n) | [Orin, Goswami, Lee 2013] |
//! | energy? | [`kinetic_energy`], [`potential_energy`] | O(n) | |
//! | forces of springs and damping? | [`passive_forces`], [`elastic_energy`] | O(n) | |
//! | derivatives of τ in q, v, a? | [`inverse_dynamics_derivatives`], [`inverse_dynamics_second_derivatives`] | O(n · depth), O(n³) | [Jain, Rodriguez 1993] |
//! | derivatives of v̇ in q, v, τ? | [`forward_dynamics_derivatives`] | O(n² · depth) | [Carpentier, Mansard 2018] |
//! | gradient of a weighted sum of τ or v̇ in all inputs and parameters? | [`inverse_dynamics_vjp`], [`forward_dynamics_vjp`] | O(n) | [Griewank, Walther 2008, chapter 3] |
//! | derivatives of frames, centre of mass, momentum? | [`frame_placement_derivatives`], [`frame_velocity_derivatives`], [`center_of_mass_derivatives`], [`centroidal_momentum_derivatives`] | O(n²) | |
//! | base velocity in another representation? | [`BaseFrame`] | O(nv²) | |
//! | regressor of τ in masses and inertias? | [`joint_torque_regressor`] | O(n · depth) | [Atkeson, An, Hollerbach 1986] |
//! | regressor of the energy? | [`kinetic_energy_regressor`], [`potential_energy_regressor`] | O(n) | |
//! | force on a frame as a force on its body? | [`add_frame_force`] | O(1) | [Featherstone 2008, 2.9] |
//! | forces given by name? | [`NamedForces`], [`joint_forces`], [`external_forces`] | O(n) | |
//!
//! Functions of a frame also apply to links and bodies: each link has a frame of the same name. A body has no name: use the frame of its first link.
//!
//! | frame of | by name | by id |
//! |---|---|---|
//! | link, added frame | [`Model::frame`], [`Model::find_frame`] | [`FrameId`], [`Link::frame`](crate::model::Link) |
//! | body | [`Model::frame`] of a link on it; [`Model::body_name`] is one | [`Model::body_frame`]; in its own axes [`Kinematics`] |
//! | joint's body | [`Model::find_joint`], then | [`Model::joint_body`], then [`Model::body_frame`] |
//!
//! ```
//! use dualbody::{dynamics::frame_velocity, model::samples, spatial::Representation};
//!
//! let model = samples::cartpole();
//! let pole = model.find_frame("pole")?;
//! let cart = model.body_frame(model.joint_body(model.find_joint("linear")?));
//! let v = |frame| frame_velocity(&model, &[0.0, 0.0], &[0.5, 2.0], frame, Representation::Mixed);
//! assert_eq!((v(pole).angular.x, v(cart).linear.y, v(cart).angular.x), (2.0, 0.5, 0.0));
//! # Ok::<(), dualbody::UnknownName>(())
//! ```
//!
//! [`Model::frame`]: crate::Model::frame
//! [`Model::find_frame`]: crate::Model::find_frame
//! [`Model::find_joint`]: crate::Model::find_joint
//! [`Model::body_frame`]: crate::Model::body_frame
//! [`Model::body_name`]: crate::Model::body_name
//! [`Model::joint_body`]: crate::Model::joint_body
//! [`FrameId`]: crate::model::FrameId
//!
//! The equation of motion is  M(q) v̇ + h(q, v) = τ + Σᵢ Jᵢᵀ Fᵢ. Forms with `_into` do not allocate: they use working memory from the `new` function
//! of the scratch type, for any number of calls with the same model.
//!
//! All functions take slices: `q` of length `nq`; `v`, `a`, `tau` of length `nv`. They are differentiable in all arguments and in the parameters of
//! the model, and panic if a slice has the wrong length.

mod aba;
mod acceleration;
mod adjoint;
mod articulated_factor;
mod base_frame;
mod calls;
mod center_of_mass;
mod centroidal;
mod columns;
mod coriolis;
mod coupled;
mod crba;
mod derivatives;
mod differential;
mod direct;
mod energy;
mod external;
mod forward_dynamics;
mod jacobian;
mod joint_friction;
mod kinematics;
mod many_frames;
mod mass_matrix_factor;
mod mass_matrix_inverse;
mod named_forces;
mod packed;
mod packed_tree;
mod passes;
mod passive;
mod regressor;
mod rnea;
mod singular;
mod sticking;
mod tree;
mod tree_matrix;
mod weightless;

pub(crate) use aba::Driven;
pub use acceleration::{
    frame_acceleration, frame_bias_acceleration, frame_jacobian_derivative,
    frame_jacobian_derivative_into,
};
pub(crate) use adjoint::{
    EnergyGradientSum, EnergySweep, Gradients, ParameterSlots, Pushed, Rates, Sweep, Weighted,
};
pub use adjoint::{
    ForwardDynamicsGradient, ForwardDynamicsVjpScratch, InverseDynamicsGradient,
    InverseDynamicsVjpScratch, forward_dynamics_vjp, forward_dynamics_vjp_into,
    inverse_dynamics_vjp, inverse_dynamics_vjp_into,
};
pub use base_frame::{BaseFrame, BaseQuantity};
pub(crate) use base_frame::{deviation_to_representation, gradient_to_representation};
pub(crate) use calls::Calls;
pub use center_of_mass::center_of_mass;
pub(crate) use center_of_mass::center_of_mass_at;
pub(crate) use centroidal::momentum_at;
pub use centroidal::{
    MomentumFrame, average_velocity, average_velocity_jacobian, center_of_mass_acceleration,
    center_of_mass_jacobian, center_of_mass_velocity, centroidal_momentum,
    centroidal_momentum_matrix, centroidal_momentum_rate, locked_inertia, momentum,
    momentum_matrix,
};
pub(crate) use coriolis::add_coriolis_matrix;
pub use coriolis::{CoriolisScratch, coriolis_matrix, coriolis_matrix_into};
pub(crate) use crba::mass_matrix_of_placed_into;
pub use crba::{CrbaScratch, mass_matrix, mass_matrix_into};
pub(crate) use derivatives::{
    AccelerationDerivatives, At, Blocks, Entries, add_derivatives, lifted, moved_by_own_tangents,
};
pub use derivatives::{
    ForwardDynamicsDerivatives, ForwardDynamicsDerivativesScratch, InverseDynamicsDerivatives,
    InverseDynamicsDerivativesScratch, StateDerivatives, center_of_mass_derivatives,
    centroidal_momentum_derivatives, centroidal_momentum_matrix_derivative,
    forward_dynamics_derivatives, forward_dynamics_derivatives_into, frame_placement_derivatives,
    frame_velocity_derivatives, inverse_dynamics_derivatives, inverse_dynamics_derivatives_into,
    inverse_dynamics_second_derivatives,
};
pub(crate) use energy::{each_kinetic_derivative, kinetic_energy_at, potential_energy_at};
pub use energy::{kinetic_energy, potential_energy};
pub use external::add_frame_force;
pub use forward_dynamics::{AbaScratch, forward_dynamics, forward_dynamics_into};
pub(crate) use forward_dynamics::{
    frictional_forward_dynamics_into, resisted_forward_dynamics_into,
};
pub use jacobian::{frame_jacobian, frame_jacobian_into};
pub(crate) use joint_friction::{BEYOND, Decision, HELD, JointFriction, side_of};
pub use kinematics::{
    Kinematics, forward_kinematics, forward_kinematics_into, frame_pose, frame_pose_at,
    frame_velocity,
};
pub use many_frames::{frame_jacobian_derivatives, frame_jacobians};
pub(crate) use mass_matrix_factor::Ancestors;
pub use mass_matrix_factor::MassMatrixFactor;
pub use mass_matrix_inverse::{
    MassMatrixInverseScratch, mass_matrix_inverse, mass_matrix_inverse_into,
};
pub use named_forces::{NamedForces, external_forces, joint_forces};
pub(crate) use passes::to_world;
#[cfg(feature = "identification")]
pub(crate) use passive::add_passive_forces;
pub(crate) use passive::{Passive, each_passive};
pub use passive::{elastic_energy, passive_forces, passive_forces_into};
pub use regressor::{joint_torque_regressor, kinetic_energy_regressor, potential_energy_regressor};
pub(crate) use rnea::{
    Motions, accelerations_of_some, bias_forces_of_placed_into, motions_of_some, place_bodies_into,
    transmitted_forces, world_acceleration,
};
pub use rnea::{
    RneaScratch, bias_forces, bias_forces_into, gravity_forces, gravity_forces_into,
    inverse_dynamics, inverse_dynamics_into,
};
pub(crate) use tree_matrix::{TreeMatrix, trees};
