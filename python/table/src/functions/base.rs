//! Other velocities of the base.

/// Other velocities of the base.
#[macro_export]
macro_rules! base_functions {
    ($with:ident) => { $with! {
        /// Velocity whose base part is in another representation, (..., nv). q (..., nq), v (..., nv).
        velocity_to_representation(q, v; representation: Representation) -> |m| shape![m.nv()], |m, _, x, to, out| {
            out.copy_from_slice(d::velocity_to_representation(m, x[0], x[1], to).as_slice());
        };

        /// Velocity of this library from one whose base part is in another representation, (..., nv). q (..., nq), v (..., nv).
        velocity_from_representation(q, v; representation: Representation) -> |m| shape![m.nv()], |m, _, x, from, out| {
            out.copy_from_slice(d::velocity_from_representation(m, x[0], x[1], from).as_slice());
        };

        /// Joint forces whose base part is in another representation, (..., nv). q (..., nq), tau (..., nv).
        force_to_representation(q, tau; representation: Representation) -> |m| shape![m.nv()], |m, _, x, to, out| {
            out.copy_from_slice(d::force_to_representation(m, x[0], x[1], to).as_slice());
        };

        /// Joint forces of this library from some whose base part is in another representation, (..., nv). q (..., nq), tau (..., nv).
        force_from_representation(q, tau; representation: Representation) -> |m| shape![m.nv()], |m, _, x, from, out| {
            out.copy_from_slice(d::force_from_representation(m, x[0], x[1], from).as_slice());
        };

        /// Acceleration whose base part is in another representation, (..., nv). q (..., nq), v and a (..., nv).
        acceleration_to_representation(q, v, a; representation: Representation) -> |m| shape![m.nv()], |m, _, x, to, out| {
            out.copy_from_slice(d::acceleration_to_representation(m, x[0], x[1], x[2], to).as_slice());
        };

        /// Acceleration of this library from one whose base part is in another representation, (..., nv). q (..., nq), v and a (..., nv).
        acceleration_from_representation(q, v, a; representation: Representation) -> |m| shape![m.nv()], |m, _, x, from, out| {
            out.copy_from_slice(d::acceleration_from_representation(m, x[0], x[1], x[2], from).as_slice());
        };

        /// Row of a Jacobian for velocities whose base part is in another representation, (..., nv). q (..., nq), row (..., nv).
        _row_to_representation(q, row; representation: Representation) -> |m| shape![m.nv()], |m, _, x, to, out| {
            let row = DMatrix::from_row_slice(1, m.nv(), x[1]);
            out.copy_from_slice(d::jacobian_to_representation(m, x[0], &row, to).as_slice());
        };

        /// Mass matrix for velocities whose base part is in another representation, (..., nv, nv). q (..., nq), mass_matrix (..., nv, nv).
        mass_matrix_to_representation(q, mass_matrix; representation: Representation) -> |m| shape![m.nv(), m.nv()], |m, _, x, to, out| {
            let matrix = DMatrix::from_row_slice(m.nv(), m.nv(), x[1]);
            write_matrix(&d::mass_matrix_to_representation(m, x[0], &matrix, to), out);
        };

        /// Joint forces, (..., nv). q (..., nq), v and a (..., nv).
        _base_inverse_dynamics(q, v, a; base: Representation) -> |m| shape![m.nv()], |m, _, x, base, out| {
            out.copy_from_slice(BaseVelocity::new(m, base).inverse_dynamics(x[0], x[1], x[2]).as_slice());
        };

        /// Accelerations, (..., nv). q (..., nq), v and tau (..., nv).
        _base_forward_dynamics(q, v, tau; base: Representation) -> |m| shape![m.nv()], |m, _, x, base, out| {
            out.copy_from_slice(BaseVelocity::new(m, base).forward_dynamics(x[0], x[1], x[2]).as_slice());
        };

        /// Bias forces, (..., nv). q (..., nq), v (..., nv).
        _base_bias_forces(q, v; base: Representation) -> |m| shape![m.nv()], |m, _, x, base, out| {
            out.copy_from_slice(BaseVelocity::new(m, base).bias_forces(x[0], x[1]).as_slice());
        };

        /// Gravity forces, (..., nv). q (..., nq).
        _base_gravity_forces(q; base: Representation) -> |m| shape![m.nv()], |m, _, x, base, out| {
            out.copy_from_slice(BaseVelocity::new(m, base).gravity_forces(x[0]).as_slice());
        };

        /// Mass matrix, (..., nv, nv). q (..., nq).
        _base_mass_matrix(q; base: Representation) -> |m| shape![m.nv(), m.nv()], |m, _, x, base, out| {
            write_matrix(&BaseVelocity::new(m, base).mass_matrix(x[0]), out);
        };

        /// Inverse of the mass matrix, (..., nv, nv). q (..., nq).
        _base_mass_matrix_inverse(q; base: Representation) -> |m| shape![m.nv(), m.nv()], |m, _, x, base, out| {
            write_matrix(&BaseVelocity::new(m, base).mass_matrix_inverse(x[0]), out);
        };

        /// Coriolis matrix, (..., nv, nv). q (..., nq), v (..., nv).
        _base_coriolis_matrix(q, v; base: Representation) -> |m| shape![m.nv(), m.nv()], |m, _, x, base, out| {
            write_matrix(&BaseVelocity::new(m, base).coriolis_matrix(x[0], x[1]), out);
        };

        /// Velocity of a frame, (..., 6). q (..., nq), v (..., nv).
        _base_frame_velocity(q, v; frame: FrameId, representation: Representation, base: Representation) -> |_| shape![6], |m, _, x, frame, r, base, out| {
            write_motion(&BaseVelocity::new(m, base).frame_velocity(x[0], x[1], frame, r), out);
        };

        /// Acceleration of a frame, (..., 6). q (..., nq), v and a (..., nv).
        _base_frame_acceleration(q, v, a; frame: FrameId, representation: Representation, base: Representation) -> |_| shape![6], |m, _, x, frame, r, base, out| {
            write_motion(&BaseVelocity::new(m, base).frame_acceleration(x[0], x[1], x[2], frame, r), out);
        };

        /// Bias acceleration of a frame, (..., 6). q (..., nq), v (..., nv).
        _base_frame_bias_acceleration(q, v; frame: FrameId, representation: Representation, base: Representation) -> |_| shape![6], |m, _, x, frame, r, base, out| {
            write_motion(&BaseVelocity::new(m, base).frame_bias_acceleration(x[0], x[1], frame, r), out);
        };

        /// Jacobian of a frame, (..., 6, nv). q (..., nq).
        _base_frame_jacobian(q; frame: FrameId, representation: Representation, base: Representation) -> |m| shape![6, m.nv()], |m, _, x, frame, r, base, out| {
            write_matrix(&BaseVelocity::new(m, base).frame_jacobian(x[0], frame, r), out);
        };

        /// Rate of the Jacobian of a frame, (..., 6, nv). q (..., nq), v (..., nv).
        _base_frame_jacobian_derivative(q, v; frame: FrameId, representation: Representation, base: Representation) -> |m| shape![6, m.nv()], |m, _, x, frame, r, base, out| {
            write_matrix(&BaseVelocity::new(m, base).frame_jacobian_derivative(x[0], x[1], frame, r), out);
        };

        /// Momentum, (..., 6). q (..., nq), v (..., nv).
        _base_momentum(q, v; frame: MomentumFrame, base: Representation) -> |_| shape![6], |m, _, x, frame, base, out| {
            write_force(&BaseVelocity::new(m, base).momentum(x[0], x[1], frame), out);
        };

        /// Momentum matrix, (..., 6, nv). q (..., nq).
        _base_momentum_matrix(q; frame: MomentumFrame, base: Representation) -> |m| shape![6, m.nv()], |m, _, x, frame, base, out| {
            write_matrix(&BaseVelocity::new(m, base).momentum_matrix(x[0], frame), out);
        };

        /// Rate of the centroidal momentum, (..., 6). q (..., nq), v and a (..., nv).
        _base_centroidal_momentum_rate(q, v, a; base: Representation) -> |_| shape![6], |m, _, x, base, out| {
            write_force(&BaseVelocity::new(m, base).centroidal_momentum_rate(x[0], x[1], x[2]), out);
        };

        /// Rate of the centroidal momentum matrix, (..., 6, nv). q (..., nq), v (..., nv).
        _base_centroidal_momentum_matrix_derivative(q, v; base: Representation) -> |m| shape![6, m.nv()], |m, _, x, base, out| {
            write_matrix(&BaseVelocity::new(m, base).centroidal_momentum_matrix_derivative(x[0], x[1]), out);
        };

        /// Jacobian of the average velocity, (..., 6, nv). q (..., nq).
        _base_average_velocity_jacobian(q; frame: MomentumFrame, base: Representation) -> |m| shape![6, m.nv()], |m, _, x, frame, base, out| {
            write_matrix(&BaseVelocity::new(m, base).average_velocity_jacobian(x[0], frame), out);
        };

        /// Velocity of the centre of mass, (..., 3). q (..., nq), v (..., nv).
        _base_center_of_mass_velocity(q, v; base: Representation) -> |_| shape![3], |m, _, x, base, out| {
            write_vector3(&BaseVelocity::new(m, base).center_of_mass_velocity(x[0], x[1]), out);
        };

        /// Jacobian of the centre of mass, (..., 3, nv). q (..., nq).
        _base_center_of_mass_jacobian(q; base: Representation) -> |m| shape![3, m.nv()], |m, _, x, base, out| {
            write_matrix(&BaseVelocity::new(m, base).center_of_mass_jacobian(x[0]), out);
        };

        /// Acceleration of the centre of mass, (..., 3). q (..., nq), v and a (..., nv).
        _base_center_of_mass_acceleration(q, v, a; base: Representation) -> |_| shape![3], |m, _, x, base, out| {
            write_vector3(&BaseVelocity::new(m, base).center_of_mass_acceleration(x[0], x[1], x[2]), out);
        };

        /// The maps of tangents of a state to another representation of the base and back, (..., 2, 2 nv, 2 nv). q (..., nq), v (..., nv).
        _base_state_tangents(q, v; base: Representation) -> |m| shape![2, 2 * m.nv(), 2 * m.nv()], |m, _, x, base, out| {
            let n = 2 * m.nv();
            let (to, from) = out.split_at_mut(n * n);
            let mut unit = vec![Zero::zero(); n];
            for k in 0..n {
                unit[k] = One::one();
                let there = d::deviation_to_representation(m, x[0], x[1], &unit, base);
                let back = d::deviation_from_representation(m, x[0], x[1], &unit, base);
                for i in 0..n {
                    to[i * n + k] = there[i];
                    from[i * n + k] = back[i];
                }
                unit[k] = Zero::zero();
            }
        };
    } };
}
