//! Multibody dynamics: one file per algorithm, each written once over the scalar.
//!
//! | question | function | cost | reference |
//! |---|---|---|---|
//! | where is everything, how fast? | [`forward_kinematics`] | O(n) | [Featherstone 2008, 3.2] |
//! | where is a frame, how fast? | [`frame_pose`], [`frame_velocity`] | O(depth) | |
//! | how does a frame accelerate? | [`frame_acceleration`], [`frame_bias_acceleration`] | O(depth) | |
//! | how does its Jacobian change? | [`frame_jacobian_derivative`] | O(depth) | |
//! | how do joint rates move a frame? | [`frame_jacobian`] | O(depth) | [Featherstone 2008, 4.1] |
//! | how do they move all links? | [`frame_jacobians`], [`frame_jacobian_derivatives`] | O(n · depth) | |
//! | which forces give these accelerations? | [`inverse_dynamics`] | O(n) | [Featherstone 2008, table 5.1] |
//! | which forces hold, or hold while moving? | [`gravity_forces`], [`bias_forces`] | O(n) | the same |
//! | what is M(q)? | [`mass_matrix`] | O(n · depth) | [Featherstone 2008, table 6.2] |
//! | what is M(q)⁻¹? | [`mass_matrix_inverse`] | O(n²) | [Carpentier 2018] |
//! | solve M x = b | [`MassMatrixFactor`] | O(n · depth) | [Featherstone 2008, table 6.3] |
//! | what is C(q, v), Ṁ − 2C skew? | [`coriolis_matrix`] | O(n · depth) | [Echeandia, Wensing 2021] |
//! | which accelerations follow from forces? | [`forward_dynamics`] | O(n) | [Featherstone 2008, table 7.1] |
//! | where is the centre of mass? | [`center_of_mass`] | O(n) | |
//! | how does it move? | [`center_of_mass_velocity`], [`center_of_mass_jacobian`], [`center_of_mass_acceleration`] | O(n) | |
//! | how much momentum, and its rate? | [`centroidal_momentum`], [`centroidal_momentum_rate`], [`momentum`] | O(n) | [Orin, Goswami, Lee 2013] |
//! | how do joint rates make momentum? | [`centroidal_momentum_matrix`], [`momentum_matrix`] | O(n) | [Orin, Goswami, Lee 2013] |
//! | how does it move as a single body? | [`locked_inertia`], [`average_velocity`], [`average_velocity_jacobian`] | O(n) | [Orin, Goswami, Lee 2013] |
//! | how much energy? | [`kinetic_energy`], [`potential_energy`] | O(n) | |
//! | what do springs and damping do? | [`passive_forces`], [`elastic_energy`] | O(n) | |
//! | how does τ change with q, v, a? | [`inverse_dynamics_derivatives`], [`inverse_dynamics_second_derivatives`] | O(n · depth), O(n³) | [Jain, Rodriguez 1993] |
//! | how does v̇ change with q, v, τ? | [`forward_dynamics_derivatives`] | O(n² · depth) | [Carpentier, Mansard 2018] |
//! | and a weighted sum of τ, or of v̇, with all inputs and parameters? | [`inverse_dynamics_vjp`], [`forward_dynamics_vjp`] | O(n) | [Griewank, Walther 2008, chapter 3] |
//! | how do frames, momentum change with q, v? | [`frame_placement_derivatives`], [`frame_velocity_derivatives`], [`center_of_mass_derivatives`], [`centroidal_momentum_derivatives`] | O(n²) | |
//! | what if the base velocity is in another representation? | [`BaseFrame`] | O(nv²) | |
//! | how does τ depend on masses and inertias? | [`joint_torque_regressor`] | O(n · depth) | [Atkeson, An, Hollerbach 1986] |
//! | how does the energy? | [`kinetic_energy_regressor`], [`potential_energy_regressor`] | O(n) | |
//! | what does a force on a frame do to its body? | [`add_frame_force`] | O(1) | [Featherstone 2008, 2.9] |
//! | which forces are given by name? | [`NamedForces`], [`joint_forces`], [`external_forces`] | O(n) | |
//!
//! Functions of a frame serve links and bodies as well: every link is a frame with its name, and a body, which has no
//! name, is reached by the frame of its first link.
//!
//! | of a | by name | by id |
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
//! The equation of motion is  M(q) v̇ + h(q, v) = τ + Σᵢ Jᵢᵀ Fᵢ. Forms with `_into` do not allocate: they take working
//! memory made by the scratch type's `new`, which any call with the same model can use again.
//!
//! All functions take slices: `q` of length `nq`; `v`, `a`, `tau` of length `nv`. They are differentiable in all of
//! them and in the data of the model, and panic if a slice has the wrong length.

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
mod tree;
mod weightless;

pub use acceleration::{
    frame_acceleration, frame_bias_acceleration, frame_jacobian_derivative,
    frame_jacobian_derivative_into,
};
pub(crate) use adjoint::{
    EnergySlopes, EnergySweep, ParameterSlots, Pushed, Rates, Slopes, Sweep, Weighted,
};
pub use adjoint::{
    ForwardDynamicsGradient, ForwardDynamicsVjpScratch, InverseDynamicsGradient,
    InverseDynamicsVjpScratch, forward_dynamics_vjp, forward_dynamics_vjp_into,
    inverse_dynamics_vjp, inverse_dynamics_vjp_into,
};
pub use base_frame::{BaseFrame, BaseQuantity};
pub(crate) use base_frame::{deviation_to_representation, gradient_to_representation};
pub(crate) use calls::Calls;
pub use center_of_mass::{center_of_mass, center_of_mass_at};
pub use centroidal::{
    MomentumFrame, average_velocity, average_velocity_jacobian, center_of_mass_acceleration,
    center_of_mass_jacobian, center_of_mass_velocity, centroidal_momentum,
    centroidal_momentum_matrix, centroidal_momentum_rate, locked_inertia, locked_inertia_at,
    momentum, momentum_at, momentum_matrix,
};
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
    inverse_dynamics_second_derivatives, inverse_dynamics_second_derivatives_times,
};
pub(crate) use energy::each_kinetic_slope;
pub use energy::{kinetic_energy, kinetic_energy_at, potential_energy, potential_energy_at};
pub use external::add_frame_force;
pub(crate) use forward_dynamics::resisted_forward_dynamics_into;
pub use forward_dynamics::{AbaScratch, forward_dynamics, forward_dynamics_into};
pub use jacobian::{frame_jacobian, frame_jacobian_into};
pub use kinematics::{
    Kinematics, forward_kinematics, forward_kinematics_into, frame_pose, frame_pose_at,
    frame_velocity,
};
pub use many_frames::{
    frame_jacobian_derivatives, frame_jacobian_derivatives_into, frame_jacobians,
    frame_jacobians_into,
};
pub(crate) use mass_matrix_factor::Ancestors;
pub use mass_matrix_factor::MassMatrixFactor;
pub use mass_matrix_inverse::{
    MassMatrixInverseScratch, mass_matrix_inverse, mass_matrix_inverse_into,
};
pub use named_forces::{
    NamedForces, external_forces, external_forces_into, joint_forces, joint_forces_into,
};
pub(crate) use passes::to_world;
#[cfg(feature = "identification")]
pub(crate) use passive::add_passive_forces;
pub(crate) use passive::{Passive, each_passive};
pub use passive::{elastic_energy, passive_forces, passive_forces_into};
pub use regressor::{joint_torque_regressor, kinetic_energy_regressor, potential_energy_regressor};
pub use rnea::{
    RneaScratch, bias_forces, bias_forces_into, gravity_forces, gravity_forces_into,
    inverse_dynamics, inverse_dynamics_into,
};
pub(crate) use rnea::{motions_of_some, transmitted_forces, world_acceleration};
