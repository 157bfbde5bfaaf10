//! Compiles and runs the listings of the guide, chapter by chapter, as documentation tests.

#[doc = include_str!("../guide/src/primer.md")]
struct Primer;

#[doc = include_str!("../guide/src/first_robot.md")]
struct FirstRobot;

#[cfg(feature = "cli")]
#[doc = include_str!("../guide/src/command.md")]
struct Command;

#[doc = include_str!("../guide/src/conventions.md")]
struct Conventions;

#[doc = include_str!("../guide/src/coming_from.md")]
struct ComingFrom;

#[doc = include_str!("../guide/src/dynamics.md")]
struct Dynamics;

#[doc = include_str!("../guide/src/simulation.md")]
struct Simulation;

#[doc = include_str!("../guide/src/worlds.md")]
struct Worlds;

#[doc = include_str!("../guide/src/sensors.md")]
struct Sensors;

#[doc = include_str!("../guide/src/contact.md")]
struct Contact;

#[doc = include_str!("../guide/src/derivatives.md")]
struct Derivatives;

#[doc = include_str!("../guide/src/control.md")]
struct Control;

#[doc = include_str!("../guide/src/quadruped.md")]
struct Quadruped;

#[doc = include_str!("../guide/src/trajopt.md")]
struct TrajectoryOptimisation;

#[cfg(feature = "identification")]
#[doc = include_str!("../guide/src/identification.md")]
struct Identification;

#[doc = include_str!("../guide/src/batches.md")]
struct Batches;

#[doc = include_str!("../guide/src/your_own.md")]
struct YourOwn;
