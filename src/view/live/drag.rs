//! The spring between a body and the mouse.

use nalgebra::{DMatrix, Vector3};

use crate::constraint::Anchor;
use crate::dynamics::{Kinematics, forward_kinematics_into, mass_matrix};
use crate::model::{BodyId, Model};
use crate::sim::{FrameActuator, Simulator, State};
use crate::spatial::Representation;

/// Stiffness per mass of the robot, 1/s²: its weight stretches the spring by 2.5 cm.
const STIFFNESS: f64 = 400.0;

/// Largest stiffness and damping in an explicit step, relative to the mass at the point over Δt² and Δt: those at which it would be
/// unstable are 4 and 2.
const STABLE: [f64; 2] = [0.2, 0.5];

/// Largest force, relative to the weight of the robot.
const STRONGEST: f64 = 10.0;
const WEIGHT: f64 = 9.81;

/// A body that is held at a point.
#[derive(Debug)]
pub(super) struct Drag {
    /// The robot with three inputs more: a force at the point, along the axes of the world.
    pub(super) simulator: Simulator,
    body: BodyId,
    /// The point, in the body, m.
    at: Vector3<f64>,
    /// Target of the pull, m.
    pub(super) to: Vector3<f64>,
    stiffness: f64,
    damping: f64,
    strongest: f64,
    kinematics: Kinematics<f64>,
}

impl Drag {
    /// `None` for what is not a body, or a point that is not finite.
    pub(super) fn new(
        simulator: &Simulator,
        state: &State,
        body: usize,
        at: [f64; 3],
    ) -> Option<Self> {
        let model = simulator.model();
        if body >= model.n_bodies() || !at.iter().all(|x| x.is_finite()) {
            return None;
        }
        let (body, at) = (BodyId(body), Vector3::from(at));
        let frame = model.frame_of(model.body_frame(body));
        let in_frame = frame.placement.inverse().point(&at);
        let place = Anchor::frame(model, &frame.name)
            .ok()?
            .moved(in_frame.into());
        let [x, y, z, ..] =
            FrameActuator::wrench(&free_name(simulator), place, Representation::Mixed);
        let mut actuators = simulator.frame_actuators().to_vec();
        actuators.extend([x, y, z]);
        let mut kinematics = Kinematics::new(model);
        forward_kinematics_into(
            model,
            state.q.as_slice(),
            state.v.as_slice(),
            &mut kinematics,
        );
        let to = kinematics.pose(Some(body)).point(&at);
        let (mass, dt) = (model.total_mass(), simulator.time_step());
        let least = least_mass(model, state, body, &at).min(mass);
        let stiffness = (STIFFNESS * mass).min(STABLE[0] * least / (dt * dt));
        Some(Self {
            simulator: simulator.clone().with_frame_actuators(actuators),
            body,
            at,
            to,
            stiffness,
            damping: (2.0 * (stiffness * least).sqrt()).min(STABLE[1] * least / dt),
            strongest: STRONGEST * WEIGHT * mass,
            kinematics,
        })
    }

    /// Position of the point and force on it at a state, both in the world.
    pub(super) fn force(&mut self, state: &State) -> (Vector3<f64>, Vector3<f64>) {
        let model = self.simulator.model();
        forward_kinematics_into(
            model,
            state.q.as_slice(),
            state.v.as_slice(),
            &mut self.kinematics,
        );
        let pose = self.kinematics.pose(Some(self.body));
        let velocity = self.kinematics.velocity(Some(self.body));
        let point = pose.point(&self.at);
        let speed = pose.rotation * (velocity.linear + velocity.angular.cross(&self.at));
        let force = (self.to - point) * self.stiffness - speed * self.damping;
        (point, force.cap_magnitude(self.strongest))
    }
}

/// A name that no other actuator has.
fn free_name(simulator: &Simulator) -> String {
    let is_free = |name: &String| {
        simulator
            .frame_actuators()
            .iter()
            .all(|other| !other.name().starts_with(name.as_str()))
    };
    let mut names = (0..).map(|k| format!("hand {k}"));
    names.find(is_free).unwrap_or_default()
}

/// The mass that a point shows in the direction in which it is lightest, kg: 1 over the largest eigenvalue of J M⁻¹ Jᵀ. Infinite where
/// nothing moves it.
fn least_mass(model: &Model, state: &State, body: BodyId, at: &Vector3<f64>) -> f64 {
    let jacobian = point_jacobian(model, state, body, at);
    let mass = mass_matrix(model, state.q.as_slice());
    let Some(cholesky) = mass.cholesky() else {
        return 0.0;
    };
    let mobility = &jacobian * cholesky.solve(&jacobian.transpose());
    1.0 / mobility.symmetric_eigenvalues().max()
}

/// Velocity of a point of a body in the world per velocity coordinate, 3 × nv.
fn point_jacobian(model: &Model, state: &State, body: BodyId, at: &Vector3<f64>) -> DMatrix<f64> {
    let mut kinematics = Kinematics::new(model);
    let mut out = DMatrix::zeros(3, model.nv());
    for k in 0..model.nv() {
        let mut v = vec![0.0; model.nv()];
        v[k] = 1.0;
        forward_kinematics_into(model, state.q.as_slice(), &v, &mut kinematics);
        let velocity = kinematics.velocity(Some(body));
        let rotation = kinematics.pose(Some(body)).rotation;
        out.set_column(
            k,
            &(rotation * (velocity.linear + velocity.angular.cross(at))),
        );
    }
    out
}
