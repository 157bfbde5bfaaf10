//! Frames: poses, velocities, accelerations, Jacobians.

use dualbody::dynamics as d;
use dualbody::model::FrameId;
use dualbody::spatial::Representation;
use pyo3::prelude::*;

use super::table::functions;
use super::write::{write_all, write_motion, write_pose};
use crate::arrays::write_matrix;

functions! {
    /// Poses of all frames in the world, in the order of ``model.frame_names``, (..., n_frames, 4, 4). q (..., nq).
    forward_kinematics(q) -> |m| vec![m.frames().len(), 4, 4], |m, _, x, out| {
        let kinematics = d::forward_kinematics(m, x[0], &vec![0.0; m.nv()]);
        for (k, out) in out.chunks_mut(16).enumerate() {
            write_pose(&d::frame_pose_at(m, &kinematics, FrameId(k)), out);
        }
    };

    /// Velocity of a frame, [linear; angular], (..., 6), m/s and rad/s. q (..., nq), v (..., nv).
    ///
    /// representation: "body" in the frame's axes, "mixed" of its origin in the world's axes, "inertial" of the point of the body at the world's
    /// origin: LOCAL, LOCAL_WORLD_ALIGNED and WORLD of Pinocchio.
    frame_velocity(q, v; frame: FrameId, representation: Representation = "body") -> |_| vec![6], |m, _, x, frame, representation, out| {
        write_motion(&d::frame_velocity(m, x[0], x[1], frame, representation), out);
    };

    /// Acceleration of a frame, [linear; angular], (..., 6), without gravity: classical if mixed, else spatial (ω × v less). q (..., nq), v and a (..., nv).
    frame_acceleration(q, v, a; frame: FrameId, representation: Representation = "body") -> |_| vec![6], |m, _, x, frame, representation, out| {
        write_motion(&d::frame_acceleration(m, x[0], x[1], x[2], frame, representation), out);
    };

    /// Acceleration of a frame where a is zero: the rate of its Jacobian times v, (..., 6). q (..., nq), v (..., nv).
    frame_bias_acceleration(q, v; frame: FrameId, representation: Representation = "body") -> |_| vec![6], |m, _, x, frame, representation, out| {
        write_motion(&d::frame_bias_acceleration(m, x[0], x[1], frame, representation), out);
    };

    /// Jacobian of a frame: its velocity is J v, (..., 6, nv). q (..., nq); representation "body", "mixed" or "inertial".
    frame_jacobian(q; frame: FrameId, representation: Representation = "body") -> |m| vec![6, m.nv()], |m, memory, x, frame, representation, out| {
        d::frame_jacobian_into(m, x[0], frame, representation, &mut memory.one.frame);
        write_matrix(&memory.one.frame, out);
    };

    /// Rate of a frame's Jacobian along v, (..., 6, nv). q (..., nq), v (..., nv).
    frame_jacobian_derivative(q, v; frame: FrameId, representation: Representation = "body") -> |m| vec![6, m.nv()], |m, memory, x, frame, representation, out| {
        d::frame_jacobian_derivative_into(m, x[0], x[1], frame, representation, &mut memory.one.frame);
        write_matrix(&memory.one.frame, out);
    };

    /// Derivatives of a frame's velocity in one array (..., 2, 6, nv): by q, v.
    _frame_velocity_derivatives(q, v; frame: FrameId, representation: Representation = "body") -> |m| vec![2, 6, m.nv()], |m, _, x, frame, representation, out| {
        let derivatives = d::frame_velocity_derivatives(m, x[0], x[1], frame, representation);
        write_all([&derivatives.dq, &derivatives.dv], out);
    };

    /// Pose of a frame or link in the world as a matrix [[R, p], [0, 1]], (..., 4, 4). q (..., nq).
    frame_pose(q; frame: FrameId) -> |_| vec![4, 4], |m, _, x, frame, out| write_pose(&d::frame_pose(m, x[0], frame), out);

    /// Derivative of a frame's pose in tangent directions of q, as a motion in the frame, (..., 6, nv). q (..., nq).
    frame_placement_derivatives(q; frame: FrameId) -> |m| vec![6, m.nv()], |m, _, x, frame, out| {
        write_matrix(&d::frame_placement_derivatives(m, x[0], frame), out);
    };
}
