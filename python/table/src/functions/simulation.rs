//! Forces on a robot at an instant.

/// Forces on a robot at an instant: functions of a simulator.
#[macro_export]
macro_rules! simulator_functions {
    ($with:ident) => { $with! { simulator: Simulator;
        /// Acceleration dv/dt at a state under the input, (..., nv).
        acceleration(q, v, u + contact) -> |s| shape![s.model().nv()], |s, _, x, out| out.copy_from_slice(s.acceleration(&hot::state(s, x), x[2]).as_slice());

        /// Forces of the ground on all points of contact in the world, (..., n, 3), N, at a state under the input.
        contact_forces(q, v, u + contact) -> |s| shape![points(s), 3], |s, _, x, out| {
            let forces = hot::contact_report(s, x).forces;
            forces.iter().zip(out.chunks_mut(3)).for_each(|(force, out)| write_vector3(force, out));
        };

        /// Positions, velocities, normals and depths of all points of contact in one array, (..., n, 10). q (..., nq), v (..., nv).
        _contact_points(q, v) -> |s| shape![points(s), POINT], |s, _, x, out| {
            let points = contacts(s).states(s.model(), x[0], x[1]);
            points.iter().zip(out.chunks_mut(POINT)).for_each(|(point, out)| write_point(point, out));
        };

        /// Poses of the frames of all points of contact, (..., n, 4, 4): the origin at the point, the axes of its link. q (..., nq).
        contact_frames(q) -> |s| shape![points(s), 4, 4], |s, _, x, out| {
            let frames = contacts(s).frames(s.model(), x[0]);
            frames.iter().zip(out.chunks_mut(16)).for_each(|(frame, out)| write_pose(frame, out));
        };

        /// Jacobians of the frames of all points of contact, (..., n, 6, nv). q (..., nq).
        ///
        /// If mixed, the first three rows give the velocity of the body at the point, in axes of the world. A frame is fixed to its body.
        contact_jacobians(q; representation: Representation = "mixed") -> |s| shape![points(s), 6, s.model().nv()], |s, _, x, r, out| {
            write_all(&contacts(s).frame_jacobians(s.model(), x[0], r), out);
        };

        /// Rates of the Jacobians of the frames of all points of contact along v, (..., n, 6, nv). q (..., nq), v (..., nv).
        contact_jacobian_derivatives(q, v; representation: Representation = "mixed") -> |s| shape![points(s), 6, s.model().nv()], |s, _, x, r, out| {
            write_all(&contacts(s).frame_jacobian_derivatives(s.model(), x[0], x[1], r), out);
        };
    } };
}
