//! Other velocities of the base.

/// Other velocities of the base.
#[macro_export]
macro_rules! base_functions {
    ($with:ident) => { $with! { model: Model;
        /// Velocity whose base part is in another representation, (..., nv). q (..., nq), v (..., nv).
        velocity_to_representation(q, v; representation: Representation) -> |m| shape![m.nv()], |m, _, x, to, out| {
            out.copy_from_slice(BaseFrame::new(m, to).to_representation(x[0], BaseQuantity::Velocity, x[1]).as_slice());
        };

        /// Velocity of this library from one whose base part is in another representation, (..., nv). q (..., nq), v (..., nv).
        velocity_from_representation(q, v; representation: Representation) -> |m| shape![m.nv()], |m, _, x, from, out| {
            out.copy_from_slice(BaseFrame::new(m, from).from_representation(x[0], BaseQuantity::Velocity, x[1]).as_slice());
        };

        /// Joint forces whose base part is in another representation, (..., nv). q (..., nq), tau (..., nv).
        force_to_representation(q, tau; representation: Representation) -> |m| shape![m.nv()], |m, _, x, to, out| {
            out.copy_from_slice(BaseFrame::new(m, to).to_representation(x[0], BaseQuantity::Force, x[1]).as_slice());
        };

        /// Joint forces of this library from some whose base part is in another representation, (..., nv). q (..., nq), tau (..., nv).
        force_from_representation(q, tau; representation: Representation) -> |m| shape![m.nv()], |m, _, x, from, out| {
            out.copy_from_slice(BaseFrame::new(m, from).from_representation(x[0], BaseQuantity::Force, x[1]).as_slice());
        };

        /// Acceleration whose base part is in another representation, (..., nv). q (..., nq), v and a (..., nv).
        acceleration_to_representation(q, v, a; representation: Representation) -> |m| shape![m.nv()], |m, _, x, to, out| {
            out.copy_from_slice(BaseFrame::new(m, to).to_representation(x[0], BaseQuantity::Acceleration { v: x[1] }, x[2]).as_slice());
        };

        /// Acceleration of this library from one whose base part is in another representation, (..., nv). q (..., nq), v and a (..., nv).
        acceleration_from_representation(q, v, a; representation: Representation) -> |m| shape![m.nv()], |m, _, x, from, out| {
            out.copy_from_slice(BaseFrame::new(m, from).from_representation(x[0], BaseQuantity::Acceleration { v: x[1] }, x[2]).as_slice());
        };

        /// Row of a Jacobian for velocities whose base part is in another representation, (..., nv). q (..., nq), row (..., nv).
        _row_to_representation(q, row; representation: Representation) -> |m| shape![m.nv()], |m, _, x, to, out| {
            let row = DMatrix::from_row_slice(1, m.nv(), x[1]);
            out.copy_from_slice(BaseFrame::new(m, to).jacobian(x[0], &row).as_slice());
        };

        /// Mass matrix for velocities whose base part is in another representation, (..., nv, nv). q (..., nq), mass_matrix (..., nv, nv).
        mass_matrix_to_representation(q, mass_matrix; representation: Representation) -> |m| shape![m.nv(), m.nv()], |m, _, x, to, out| {
            let matrix = DMatrix::from_row_slice(m.nv(), m.nv(), x[1]);
            let base = BaseFrame::new(m, to);
            let half = base.jacobian(x[0], &matrix).transpose();
            write_matrix(&base.jacobian(x[0], &half), out);
        };

        // Methods of `BaseVelocity`, with the documentation of the functions of these names.
        _base_inverse_dynamics(q, v, a; base: Representation) -> |m| shape![m.nv()], |m, _, x, base, out| {
            out.copy_from_slice(BaseFrame::new(m, base).inverse_dynamics(x[0], x[1], x[2]).as_slice());
        };
        _base_forward_dynamics(q, v, tau; base: Representation) -> |m| shape![m.nv()], |m, _, x, base, out| {
            out.copy_from_slice(BaseFrame::new(m, base).forward_dynamics(x[0], x[1], x[2]).as_slice());
        };
        _base_bias_forces(q, v; base: Representation) -> |m| shape![m.nv()], |m, _, x, base, out| out.copy_from_slice(BaseFrame::new(m, base).bias_forces(x[0], x[1]).as_slice());
        _base_gravity_forces(q; base: Representation) -> |m| shape![m.nv()], |m, _, x, base, out| out.copy_from_slice(BaseFrame::new(m, base).gravity_forces(x[0]).as_slice());
        _base_mass_matrix(q; base: Representation) -> |m| shape![m.nv(), m.nv()], |m, _, x, base, out| write_matrix(&BaseFrame::new(m, base).mass_matrix(x[0]), out);
        _base_mass_matrix_inverse(q; base: Representation) -> |m| shape![m.nv(), m.nv()], |m, _, x, base, out| write_matrix(&BaseFrame::new(m, base).mass_matrix_inverse(x[0]), out);
        _base_coriolis_matrix(q, v; base: Representation) -> |m| shape![m.nv(), m.nv()], |m, _, x, base, out| write_matrix(&BaseFrame::new(m, base).coriolis_matrix(x[0], x[1]), out);
        _base_frame_velocity(q, v; frame: FrameId, representation: Representation, base: Representation) -> |_| shape![6], |m, _, x, frame, r, base, out| {
            write_motion(&d::frame_velocity(m, x[0], &based::velocity(m, base, x[0], x[1]), frame, r), out);
        };
        _base_frame_acceleration(q, v, a; frame: FrameId, representation: Representation, base: Representation) -> |_| shape![6], |m, _, x, frame, r, base, out| {
            let (v, a) = based::motion(m, base, x[0], x[1], x[2]);
            write_motion(&d::frame_acceleration(m, x[0], &v, &a, frame, r), out);
        };
        _base_frame_bias_acceleration(q, v; frame: FrameId, representation: Representation, base: Representation) -> |_| shape![6], |m, _, x, frame, r, base, out| {
            let (v, a) = based::motion(m, base, x[0], x[1], &vec![Zero::zero(); m.nv()]);
            write_motion(&d::frame_acceleration(m, x[0], &v, &a, frame, r), out);
        };
        _base_frame_jacobian(q; frame: FrameId, representation: Representation, base: Representation) -> |m| shape![6, m.nv()], |m, _, x, frame, r, base, out| {
            write_matrix(&BaseFrame::new(m, base).jacobian(x[0], &d::frame_jacobian(m, x[0], frame, r)), out);
        };
        _base_frame_jacobian_derivative(q, v; frame: FrameId, representation: Representation, base: Representation) -> |m| shape![6, m.nv()], |m, _, x, frame, r, base, out| {
            let v = based::velocity(m, base, x[0], x[1]);
            let (j, rate) = (d::frame_jacobian(m, x[0], frame, r), d::frame_jacobian_derivative(m, x[0], &v, frame, r));
            write_matrix(&BaseFrame::new(m, base).jacobian_derivative(x[0], &v, &j, &rate), out);
        };
        _base_momentum(q, v; frame: MomentumFrame, base: Representation) -> |_| shape![6], |m, _, x, frame, base, out| {
            write_force(&d::momentum(m, x[0], &based::velocity(m, base, x[0], x[1]), frame), out);
        };
        _base_momentum_matrix(q; frame: MomentumFrame, base: Representation) -> |m| shape![6, m.nv()], |m, _, x, frame, base, out| {
            write_matrix(&BaseFrame::new(m, base).jacobian(x[0], &d::momentum_matrix(m, x[0], frame)), out);
        };
        _base_centroidal_momentum_rate(q, v, a; base: Representation) -> |_| shape![6], |m, _, x, base, out| {
            let (v, a) = based::motion(m, base, x[0], x[1], x[2]);
            write_force(&d::centroidal_momentum_rate(m, x[0], &v, &a), out);
        };
        _base_centroidal_momentum_matrix_derivative(q, v; base: Representation) -> |m| shape![6, m.nv()], |m, _, x, base, out| {
            let v = based::velocity(m, base, x[0], x[1]);
            let (a, rate) = (d::centroidal_momentum_matrix(m, x[0]), d::centroidal_momentum_matrix_derivative(m, x[0], &v));
            write_matrix(&BaseFrame::new(m, base).jacobian_derivative(x[0], &v, &a, &rate), out);
        };
        _base_average_velocity_jacobian(q; frame: MomentumFrame, base: Representation) -> |m| shape![6, m.nv()], |m, _, x, frame, base, out| {
            write_matrix(&BaseFrame::new(m, base).jacobian(x[0], &d::average_velocity_jacobian(m, x[0], frame)), out);
        };
        _base_center_of_mass_velocity(q, v; base: Representation) -> |_| shape![3], |m, _, x, base, out| {
            write_vector3(&d::center_of_mass_velocity(m, x[0], &based::velocity(m, base, x[0], x[1])), out);
        };
        _base_center_of_mass_jacobian(q; base: Representation) -> |m| shape![3, m.nv()], |m, _, x, base, out| {
            write_matrix(&BaseFrame::new(m, base).jacobian(x[0], &d::center_of_mass_jacobian(m, x[0])), out);
        };
        _base_center_of_mass_acceleration(q, v, a; base: Representation) -> |_| shape![3], |m, _, x, base, out| {
            let (v, a) = based::motion(m, base, x[0], x[1], x[2]);
            write_vector3(&d::center_of_mass_acceleration(m, x[0], &v, &a), out);
        };

        /// The maps of tangents of a state to another representation of the base and back, (..., 2, 2 nv, 2 nv). q (..., nq), v (..., nv).
        _base_state_tangents(q, v; base: Representation) -> |m| shape![2, 2 * m.nv(), 2 * m.nv()], |m, _, x, base, out| {
            let n = 2 * m.nv();
            let (to, from) = out.split_at_mut(n * n);
            let mut unit = vec![Zero::zero(); n];
            for k in 0..n {
                unit[k] = One::one();
                let (frame, tangent) = (BaseFrame::new(m, base), BaseQuantity::Deviation { v: x[1] });
                let there = frame.to_representation(x[0], tangent, &unit);
                let back = frame.from_representation(x[0], tangent, &unit);
                for i in 0..n {
                    to[i * n + k] = there[i];
                    from[i * n + k] = back[i];
                }
                unit[k] = Zero::zero();
            }
        };
    } };
}
