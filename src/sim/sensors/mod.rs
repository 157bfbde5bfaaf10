//! Sensors: readings of the step just taken, as a function over the scalar.
//!
//! A step from the state x = (q, v) under the input u finds an acceleration v̇ and the forces of contact and constraints. A reading is a function
//! y = g(q, v, v̇, forces) of these: it belongs to the *start* of the step and to the forces over the step, as in other simulators. So an
//! accelerometer responds to the input at once, and an encoder shows the joint position before the step. An Euler step has one acceleration; with
//! [`RungeKutta4`](super::Integrator::RungeKutta4) and [`ImplicitMidpoint`](super::Integrator::ImplicitMidpoint) the readings use the acceleration at
//! the state, which is evaluated for them.
//!
//! | question | function | cost |
//! |---|---|---|
//! | which sensors? | [`Sensor`], [`Sensors::new`] | |
//! | what do they read in the step just taken? | [`Sensors::read_step_into`] | a few per cent of a step with encoders and inertial units; inverse dynamics for force and torque |
//! | and without a step? | [`Sensors::read`] | additionally the acceleration of a step |
//! | C and D of the observation? | [`Sensors::linearize`] | A and B of the step, and the readings alone over dual numbers for every four directions |
//! | noise, bias, quantisation, rate, delay? | [`SensorNoise`], [`NoisySensors`] | O(readings) |
//!
//! Noise is a layer on readings, not a part of the differentiable function.

mod catalogue;
mod exterior;
mod held_links;
mod mesh;
mod moment;
mod needs;
mod noise;
mod range;
mod ray;
mod read;
mod reading;
mod scan;
mod sensor;
mod triangles;

pub use catalogue::Sensors;
#[cfg(feature = "formats")]
pub(crate) use mesh::MeshTree;
pub use noise::{NoisySensors, SensorNoise};
pub use read::SensorScratch;
pub use scan::ScanAngles;
pub use sensor::Sensor;
