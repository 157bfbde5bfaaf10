//! Simulation: state, actuation, external forces, integrators, one step, a rollout, and batches of them.
//!
//! One step holds the input constant. It is a function of state and input over any scalar. [`linearize`](crate::linearize) computes its exact Jacobians.
//!
//! | question | function | cost | reference |
//! |---|---|---|---|
//! | what is the next state? | [`Simulator::step`], [`Simulator::step_into`] | forward dynamics, O(n); with contact or constraints also the mass matrix and a solver, O(rows³) | |
//! | what are the states after many steps? | [`Simulator::rollout`], [`Simulator::rollout_over`] | that of its steps | |
//! | did it diverge, did the solver find the forces? | [`Rollout::status`], [`Rollout::solver_failure`] | | |
//! | which integrator? | [`Integrator`] | one dynamics evaluation, one with a solve, four, or a Newton search; measured there | [Hairer, Wanner 1996]; [Munthe-Kaas 1999]; [Marsden, West 2001] |
//! | many states, or many robots, at once? | [`BatchSimulator`] | that of the steps, over lanes and cores | |
//! | episodes of reinforcement learning, many at once? | [`Environment`], [`Environments`] | that of the steps | |
//! | many states in single precision? | [`SingleBatch`] | the same, over twice as many lanes | |
//! | motors, servos, dry friction, limits of joints? | [`Simulator::with_actuation`], [`Actuation::from_model`], [`Servo`], [`FrictionLaw`] | O(n), a round or two where joints stick | [Júdice & Pires 1994] |
//! | servos that hold a frame in the world? | [`FrameActuator::with_servo`] | a row of the solver each | |
//! | tendon servos, several servos on a joint? | [`Simulator::with_tendon_servos`], [`TendonServo`] | a row of the solver each | |
//! | filters, integrators and delays of inputs, an actuator of one's own? | [`Simulator::with_activation`], [`Activation`], [`ActuatorFunction`] | a few operations each | |
//! | thrusters, pushes, drag? | [`FrameActuator`], [`ExternalForce`] | O(depth) each | |
//! | forces by name? | [`Simulator::step_with_forces`], [`Simulator::inputs_of`], [`Simulator::with_frame_forces`] | O(depth) each | |
//! | contact with the ground? | [`Simulator::with_contacts`], [`contact`](crate::contact) | see there | |
//! | resting islands that cost nothing? | [`Simulator::with_sleeping`], [`Sleeping`], [`Simulator::asleep`] | a comparison of their numbers | |
//! | closed loops? | [`Simulator::with_constraints`], [`constraint`](crate::constraint) | see there | |
//! | sensors: encoders, inertial units, force and torque, touch, range finders? | [`Sensors`], [`Sensor`] | a few per cent of a step; see there | |
//! | all parameters as one vector, with names? | [`Simulator::parameters`], [`Simulator::parameter_layout`], [`Simulator::with_parameters`] | | |
//! | what happens at a contact point? | [`Simulator::contact_report`], [`ContactReason`] | that of a step | |
//! | is the step short enough, for springs, dampers, limits, soft contact, rotations? | [`Simulator::remarks`], [`Simulator::remarks_at`] | O(nv³ + points · nv²) | |
//! | the acceleration, without a step? | [`Simulator::acceleration_into`] | O(n) without rows | |
//! | A and B of the step? | [`Simulator::linearize`], [`linearize`](crate::linearize) | see there | |
//! | a start that closes all loops? | [`Simulator::assemble`] | O(rows³) an iteration | [Marquardt 1963] |
//! | the same in another engine's coordinates? | [`EngineCoordinates`] | O(n), O(n²) for matrices | |
//! | where are the base and the free bodies of a world, how fast? | [`State::free_pose`], [`State::set_free_pose`], [`State::free_velocity`], [`State::set_free_velocity`] | O(n) | |
//! | a state in a world with other members? | [`State::carried`], [`Simulator::carried_state`] | O(n) | |
//! | a random state? | [`State::random`], [`State::random_within`] | O(n) | |
//! | is a state from a file or another program valid? | [`State::check`] | O(n) | |

mod activation;
mod actuation;
mod applied_forces;
mod assembly;
mod balance;
mod bare_mass;
mod batch;
mod carried;
mod dense_rows;
mod effort_bounds;
mod evaluation_point;
mod force;
mod force_solver;
mod forces;
mod frame_forces;
mod free_body;
mod integrator;
mod integrators;
mod interop;
mod island;
mod island_matrix;
mod islands;
mod lane_rows;
mod named_forces;
mod names;
mod parameter_slots;
mod parameters;
mod placed;
mod random;
mod remarks;
mod report;
mod rollout;
mod rows;
mod sensors;
mod signals;
mod simulator;
mod sleep;
mod sleeping;
mod sparse_rows;
mod state;
mod status;
mod step;
mod terms;
mod user_function;

pub use crate::contact::reason::ContactReason;
pub use activation::{
    Activation, ActuatorFunction, ActuatorNetwork, ActuatorPoint, MAX_ACTUATOR_PARAMETERS,
    MAX_ACTUATOR_STATES,
};
pub use actuation::{
    Actuation, Actuator, CoulombFriction, FrictionLaw, Interval, PositionLimits, Servo,
    TendonServo, TorqueSpeed, VelocityLimit,
};
pub use applied_forces::AppliedForce;
pub use assembly::{Assembly, AssemblyError};
pub use batch::{
    AutoReset, BATCH_WIDTH, BatchMoment, BatchRollout, BatchScalar, BatchSimulator, BatchStates,
    Environment, Environments, Episode, SINGLE_WIDTH, SingleBatch, SingleScalar, Transitions,
};
pub(crate) use effort_bounds::own_joints;
pub(crate) use evaluation_point::EvaluationPoint;
pub use force::{ExternalForce, ForceFunction, FrameActuator, MAX_FORCE_PARAMETERS};
pub use integrator::Integrator;
#[cfg(feature = "second-order")]
pub(crate) use integrators::add_integrated;
pub(crate) use integrators::{
    AccelerationColumns, AccelerationScratch, KnownAcceleration, Pullback, Pushforward,
    StepAdjoint, StepColumns, StepJacobian, StepPoint, linear_factor,
};
pub use interop::{Engine, EngineCoordinates};
pub(crate) use names::{column_names, input_columns};
pub use parameter_slots::SimulatorParameterGroup;
pub use random::StateBounds;
pub use remarks::{NaturalMode, SimulatorRemark};
pub use report::{ContactReport, PairReport};
pub use rollout::Rollout;
#[cfg(feature = "view")]
pub(crate) use rollout::write_cells;
pub(crate) use rollout::{most_states, write_row};
#[cfg(feature = "formats")]
pub(crate) use sensors::MeshTree;
pub use sensors::{NoisySensors, ScanAngles, Sensor, SensorNoise, SensorScratch, Sensors};
pub(crate) use signals::Signals;
pub use simulator::Simulator;
pub use sleeping::Sleeping;
pub use state::State;
pub use status::{RolloutStatus, SolverFailure};
pub use step::StepScratch;
pub(crate) use terms::StepGradientSum;
