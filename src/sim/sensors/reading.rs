//! The reading of each kind of sensor: a function of motions and forces of the step.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::catalogue::{Placed, Sensors};
use super::moment::Moment;
use super::range::Ray;
use super::scan;
use super::sensor::Sensor;
use crate::dynamics::{
    MomentumFrame, center_of_mass_at, frame_pose_at, momentum_at, world_acceleration,
};
use crate::model::manifold::{q_range, v_range};
use crate::model::{Body, BodyId, Coupling, FrameId, JointId};
use crate::scalar::{Over, Scalar};
use crate::spatial::linear::{cross, dot, lift_matrix, lift_vector, rotate, rotate_back, scale};
use crate::spatial::{Force, Motion, Quaternion, Representation, Transform};

impl<P: Scalar, T: Over<P>> Moment<'_, P, T> {
    /// Writes the numbers of a sensor.
    pub(super) fn read(&self, sensors: &Sensors, placed: &Placed, out: &mut [T]) {
        match placed.sensor {
            Sensor::JointPosition(joint) => self.positions(joint, out),
            Sensor::JointVelocity(joint) => self.velocities(joint, out),
            Sensor::JointForce(joint) => self.joint_forces(joint, out),
            Sensor::Gyro(frame) => write(&self.angular_velocity(frame), out),
            Sensor::Accelerometer(frame) => write(&self.specific_force(frame), out),
            Sensor::Magnetometer { frame, field } => {
                let field = Vector3::from(field).map(T::constant);
                write(&rotate_back(&self.pose(frame).rotation, &field), out);
            }
            Sensor::FramePose(frame) => {
                let pose = self.pose(frame);
                write(&pose.translation, &mut out[..3]);
                Quaternion::from_matrix(&pose.rotation).write_to(&mut out[3..]);
            }
            Sensor::FrameVelocity {
                frame,
                representation,
            } => {
                let (X_WF, V_F) = (self.pose(frame), self.frame_velocity(frame));
                let velocity = representation.velocity_from_body(&X_WF, &V_F);
                out.copy_from_slice(&velocity.to_array());
            }
            Sensor::FrameAcceleration {
                frame,
                representation,
            } => {
                let acceleration = self.acceleration(frame, representation);
                out.copy_from_slice(&acceleration.to_array());
            }
            Sensor::Wrench(frame) => {
                let held = placed.held.as_ref();
                let force = held.map_or_else(Force::zero, |held| held.force(self));
                out.copy_from_slice(&self.in_frame(frame, &force).to_array());
            }
            Sensor::Touch(frame) => out[0] = self.touch(placed.link.unwrap_or(frame)),
            Sensor::ContactForce(_) if self.at.simulator.contacts().is_none() => {
                out.fill(T::zero());
            }
            Sensor::ContactForce(frame) => {
                let force = self.contact_on(placed.link.unwrap_or(frame));
                out.copy_from_slice(&self.in_frame(frame, &force).to_array());
            }
            Sensor::RangeFinder {
                frame,
                direction,
                range,
            } => out[0] = self.distance(sensors, frame, Vector3::from(direction), range),
            Sensor::Lidar {
                frame,
                horizontal,
                vertical,
                range,
            } => {
                let all = scan::directions(horizontal, vertical);
                for (out, along) in out.iter_mut().zip(all) {
                    *out = self.distance(sensors, frame, along, range);
                }
            }
            Sensor::CenterOfMass => write(&self.center_of_mass(), out),
            Sensor::CenterOfMassVelocity => write(&self.center_of_mass_velocity(), out),
            Sensor::Momentum => out.copy_from_slice(&self.momentum().to_array()),
        }
    }

    /// Positions of a joint, its own where it follows another.
    fn positions(&self, joint: JointId, out: &mut [T]) {
        let mut out = out.iter_mut();
        for body in self.bodies(joint) {
            let own = self.at.q()[q_range(body)].iter();
            own.zip(&mut out).for_each(|(&q, out)| {
                *out = body
                    .coupling
                    .map_or(q, |Coupling { ratio, offset }| q * ratio + offset);
            });
        }
    }

    fn velocities(&self, joint: JointId, out: &mut [T]) {
        let mut out = out.iter_mut();
        for body in self.bodies(joint) {
            let own = self.at.v()[v_range(body)].iter();
            own.zip(&mut out)
                .for_each(|(&v, out)| *out = body.scaled(v));
        }
    }

    /// Sᵀ F of the joint itself.
    fn joint_forces(&self, joint: JointId, out: &mut [T]) {
        let mut first = 0;
        let bodies = self.at.model().joint_bodies(joint);
        for (id, body) in bodies.zip(self.bodies(joint)) {
            (body.joint).project(&self.forces[id.0], |k, x| out[first + k] = x);
            first += body.joint.nv();
        }
    }

    /// The bodies that a joint moves.
    fn bodies(&self, joint: JointId) -> impl Iterator<Item = &Body<P>> {
        let model = self.at.model();
        model.joint_bodies(joint).map(|id| model.body(id))
    }

    fn pose(&self, frame: FrameId) -> Transform<T> {
        frame_pose_at(self.at.model(), self.kinematics, frame)
    }

    /// The velocity of a body in its own frame; zero for the world.
    pub(super) fn velocity(&self, body: Option<BodyId>) -> Motion<T> {
        body.map_or_else(Motion::zero, |body| self.motions.V[body.0])
    }

    /// The spatial acceleration of a body in its own frame, with that of the world against gravity.
    pub(super) fn acceleration_of(&self, body: Option<BodyId>) -> Motion<T> {
        let world = || world_acceleration(self.at.model());
        body.map_or_else(world, |body| self.motions.A[body.0])
    }

    /// The velocity of a frame, seen from it.
    fn frame_velocity(&self, frame: FrameId) -> Motion<T> {
        let own = self.at.model().frame_of(frame);
        let X_BF = own.placement.lift::<T>();
        X_BF.motion_inverse(&self.velocity(own.body))
    }

    /// The angular velocity of a frame, seen from it.
    fn angular_velocity(&self, frame: FrameId) -> Vector3<T> {
        let own = self.at.model().frame_of(frame);
        let R_BF = lift_matrix::<P, T>(&own.placement.rotation);
        rotate_back(&R_BF, &self.velocity(own.body).angular)
    }

    /// The spatial acceleration of a frame, seen from it, with that of the world against gravity.
    fn frame_acceleration(&self, frame: FrameId) -> Motion<T> {
        let own = self.at.model().frame_of(frame);
        let X_BF = own.placement.lift::<T>();
        X_BF.motion_inverse(&self.acceleration_of(own.body))
    }

    /// p̈ − g in the frame: the spatial acceleration of its origin, and ω × v.
    fn specific_force(&self, frame: FrameId) -> Vector3<T> {
        let (V_F, A_F) = (self.frame_velocity(frame), self.frame_acceleration(frame));
        A_F.linear + cross(&V_F.angular, &V_F.linear)
    }

    fn acceleration(&self, frame: FrameId, representation: Representation) -> Motion<T> {
        let (X_WF, V_F) = (self.pose(frame), self.frame_velocity(frame));
        let A_F = self.frame_acceleration(frame);
        let gravity = rotate_back(&X_WF.rotation, &lift_vector(self.at.model().gravity()));
        let A = Motion::new(A_F.linear + gravity, A_F.angular);
        representation.acceleration_from_body(&X_WF, &V_F, &A)
    }

    /// A force on the body of a frame, in the body, seen from the frame.
    fn in_frame(&self, frame: FrameId, F: &Force<T>) -> Force<T> {
        let placement = self.at.model().frame_of(frame).placement;
        placement.lift::<T>().force_inverse(F)
    }

    /// Sum of the normal forces on a link.
    fn touch(&self, link: FrameId) -> T {
        let Some(contacts) = self.at.simulator.contacts() else {
            return T::zero();
        };
        let contact = &self.found.terms.contact;
        let points = contact.points.iter().zip(&contact.forces).enumerate();
        points.fold(T::zero(), |sum, (i, (point, force))| {
            match contact.links(contacts, i).contains(&link) {
                true => sum + dot(&point.normal, force),
                false => sum,
            }
        })
    }

    /// Force of contact on a link, on its body and in it.
    fn contact_on(&self, link: FrameId) -> Force<T> {
        let mut sum = Force::zero();
        if let Some(contacts) = self.at.simulator.contacts() {
            let contact = &self.found.terms.contact;
            contact.each_force_on(contacts, link, |F| sum += F);
        }
        sum
    }

    /// Distance to the nearest surface along a direction.
    fn distance(&self, sensors: &Sensors, frame: FrameId, along: Vector3<f64>, range: f64) -> T {
        let pose = self.pose(frame);
        let along = along.normalize().map(T::constant);
        let ray = Ray {
            origin: pose.translation,
            direction: rotate(&pose.rotation, &along),
            range,
        };
        let own = self.at.model().frame_of(frame).body;
        let others = sensors.shapes.iter().filter(|shape| shape.body != own);
        let shapes = others.map(|shape| (shape, self.kinematics.pose(shape.body)));
        ray.distance(shapes, self.at.simulator.contacts())
    }

    fn center_of_mass(&self) -> Vector3<T> {
        center_of_mass_at(self.at.model(), self.kinematics)
    }

    fn momentum(&self) -> Force<T> {
        momentum_at(self.at.model(), self.kinematics, MomentumFrame::Centroidal)
    }

    fn center_of_mass_velocity(&self) -> Vector3<T> {
        let model = self.at.model();
        if model.n_bodies() == 0 {
            return Vector3::zeros();
        }
        let mass = <T as From<P>>::from(model.total_mass());
        scale(&self.momentum().linear, T::one() / mass)
    }
}

fn write<T: Scalar>(vector: &Vector3<T>, out: &mut [T]) {
    out.copy_from_slice(vector.as_slice());
}
