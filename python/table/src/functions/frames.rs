//! Frames, links and configurations.

/// Frames, links and configurations.
#[macro_export]
macro_rules! frame_functions {
    ($with:ident) => { $with! { model: Model;
        /// Poses of all frames in the world, in the order of ``model.frame_names``, (..., n_frames, 4, 4). q (..., nq).
        forward_kinematics(q) -> |m| shape![m.frames().len(), 4, 4], |m, _, x, out| {
            let kinematics = d::forward_kinematics(m, x[0], &vec![Zero::zero(); m.nv()]);
            for (k, out) in out.chunks_mut(16).enumerate() {
                write_pose(&d::frame_pose_at(m, &kinematics, FrameId(k)), out);
            }
        };

        /// Velocity of a frame, [linear; angular], (..., 6), m/s and rad/s. q (..., nq), v (..., nv).
        ///
        /// representation: "body" in the frame's axes, "mixed" of its origin in the world's axes, "inertial" of the point of the body at the world's
        /// origin: LOCAL, LOCAL_WORLD_ALIGNED and WORLD of Pinocchio.
        frame_velocity(q, v; frame: FrameId, representation: Representation = "body") -> |_| shape![6], |m, _, x, frame, representation, out| {
            write_motion(&d::frame_velocity(m, x[0], x[1], frame, representation), out);
        };

        /// Acceleration of a frame, [linear; angular], (..., 6), without gravity: classical if mixed, else spatial (ω × v less). q (..., nq), v and a (..., nv).
        frame_acceleration(q, v, a; frame: FrameId, representation: Representation = "body") -> |_| shape![6], |m, _, x, frame, representation, out| {
            write_motion(&d::frame_acceleration(m, x[0], x[1], x[2], frame, representation), out);
        };

        /// Acceleration of a frame where a is zero: the rate of its Jacobian times v, (..., 6). q (..., nq), v (..., nv).
        frame_bias_acceleration(q, v; frame: FrameId, representation: Representation = "body") -> |_| shape![6], |m, _, x, frame, representation, out| {
            write_motion(&d::frame_bias_acceleration(m, x[0], x[1], frame, representation), out);
        };

        /// Jacobian of a frame: its velocity is J v, (..., 6, nv). q (..., nq); representation "body", "mixed" or "inertial".
        frame_jacobian(q; frame: FrameId, representation: Representation = "body") -> |m| shape![6, m.nv()], |m, memory, x, frame, representation, out| {
            d::frame_jacobian_into(m, x[0], frame, representation, &mut memory.frame);
            write_matrix(&memory.frame, out);
        };

        /// Rate of a frame's Jacobian along v, (..., 6, nv). q (..., nq), v (..., nv).
        frame_jacobian_derivative(q, v; frame: FrameId, representation: Representation = "body") -> |m| shape![6, m.nv()], |m, memory, x, frame, representation, out| {
            d::frame_jacobian_derivative_into(m, x[0], x[1], frame, representation, &mut memory.frame);
            write_matrix(&memory.frame, out);
        };

        /// Derivatives of a frame's velocity in one array (..., 2, 6, nv): by q, v.
        _frame_velocity_derivatives(q, v; frame: FrameId, representation: Representation = "body") -> |m| shape![2, 6, m.nv()], |m, _, x, frame, representation, out| {
            let derivatives = d::frame_velocity_derivatives(m, x[0], x[1], frame, representation);
            write_all([&derivatives.dq, &derivatives.dv], out);
        };

        /// Pose of a frame or link in the world as a matrix [[R, p], [0, 1]], (..., 4, 4). q (..., nq).
        frame_pose(q; frame: FrameId) -> |_| shape![4, 4], |m, _, x, frame, out| write_pose(&d::frame_pose(m, x[0], frame), out);

        /// Derivative of a frame's pose in tangent directions of q, (..., 12, nv): the entries of the rotation matrix, column by column, then the
        /// translation. q (..., nq).
        frame_placement_derivatives(q; frame: FrameId) -> |m| shape![12, m.nv()], |m, _, x, frame, out| write_matrix(&d::frame_placement_derivatives(m, x[0], frame), out);

        /// Velocities of all links in the order of ``model.link_names``, (..., n_links, 6). q (..., nq), v (..., nv).
        link_velocities(q, v; representation: Representation = "body") -> |m| shape![m.links().len(), 6], |m, _, x, r, out| {
            for (link, out) in m.links().iter().zip(out.chunks_mut(6)) {
                write_motion(&d::frame_velocity(m, x[0], x[1], link.frame, r), out);
            }
        };

        /// Accelerations of all links, (..., n_links, 6): classical if mixed, else spatial. q (..., nq), v and a (..., nv).
        link_accelerations(q, v, a; representation: Representation = "body") -> |m| shape![m.links().len(), 6], |m, _, x, r, out| {
            for (link, out) in m.links().iter().zip(out.chunks_mut(6)) {
                write_motion(&d::frame_acceleration(m, x[0], x[1], x[2], link.frame, r), out);
            }
        };

        /// Jacobians of all links in the order of ``model.link_names``, (..., n_links, 6, nv). q (..., nq).
        link_jacobians(q; representation: Representation = "body") -> |m| shape![m.links().len(), 6, m.nv()], |m, memory, x, r, out| {
            let jacobian = &mut memory.frame;
            for (link, out) in m.links().iter().zip(out.chunks_mut((6 * m.nv()).max(1))) {
                d::frame_jacobian_into(m, x[0], link.frame, r, jacobian);
                write_matrix(jacobian, out);
            }
        };

        /// Rates of the Jacobians of all links along v, (..., n_links, 6, nv). q (..., nq), v (..., nv).
        link_jacobian_derivatives(q, v; representation: Representation = "body") -> |m| shape![m.links().len(), 6, m.nv()], |m, memory, x, r, out| {
            let jacobian = &mut memory.frame;
            for (link, out) in m.links().iter().zip(out.chunks_mut((6 * m.nv()).max(1))) {
                d::frame_jacobian_derivative_into(m, x[0], x[1], link.frame, r, jacobian);
                write_matrix(jacobian, out);
            }
        };

        /// Configuration q moved by the tangent vector dv, (..., nq). q (..., nq), dv (..., nv).
        integrate(q, dv) -> |m| shape![m.nq()], |m, _, x, out| m.integrate_into(x[0], x[1], out);

        /// Tangent vector that leads from q0 to q1, in the axes of the bodies at q0: (..., nv). q0 and q1 (..., nq). The shorter way about a turn.
        difference(q0, q1) -> |m| shape![m.nv()], |m, _, x, out| m.difference_into(x[0], x[1], out);

        /// Deviation of a state from another, (..., 2 nv). q, q0 (..., nq), v, v0 (..., nv).
        _deviation(q, v, q0, v0) -> |m| shape![2 * m.nv()], |m, _, x, out| {
            let (dq, dv) = out.split_at_mut(m.nv());
            m.difference_into(x[2], x[0], dq);
            for (out, (v, v0)) in dv.iter_mut().zip(x[1].iter().zip(x[3])) {
                *out = *v - *v0;
            }
        };
    } };
}
