//! The equations of motion, energies, regressors.

/// The equations of motion, energies, regressors.
#[macro_export]
macro_rules! dynamics_functions {
    ($with:ident) => { $with! { model: Model;
        /// Joint forces that produce the accelerations ``a``:  tau = M(q) a + h(q, v) - sum J' f.
        ///
        /// q (..., nq), v and a (..., nv; rad/s, rad/s² or m/s, m/s²), external (..., n_bodies, 6): force on each body in its
        /// frame, [linear; angular] (N, N·m), see external_forces. Returns (..., nv), N·m or N. [Featherstone 2008, table 5.1]
        inverse_dynamics [lanes] (q, v, a + external) -> |m| shape![m.nv()], hot::inverse_dynamics;

        /// Accelerations that the joint forces ``tau`` produce:  a = M(q)⁻¹ (tau - h(q, v) + sum J' f).
        ///
        /// q (..., nq), v (..., nv; rad/s or m/s), tau (..., nv; N·m or N), external as in inverse_dynamics. Returns (..., nv), rad/s² or m/s².
        /// A singular mass matrix is a ValueError that names the joints. [Featherstone 2008, table 7.1]
        forward_dynamics [lanes] (q, v, tau + external) -> |m| shape![m.nv()], hot::forward_dynamics;

        /// h(q, v): Coriolis, centrifugal and gravity forces, (..., nv), N·m or N.
        ///
        /// q (..., nq), v (..., nv; rad/s or m/s), external as in inverse_dynamics.
        bias_forces [lanes] (q, v + external) -> |m| shape![m.nv()], hot::bias_forces;

        /// Joint forces that hold the robot still against gravity, (..., nv), N·m or N. q (..., nq).
        gravity_forces [lanes] (q) -> |m| shape![m.nv()], |m, memory, x, out| d::gravity_forces_into(m, x[0], &mut memory.rnea, out);

        /// Mass matrix M(q), (..., nv, nv), rotors included. q (..., nq). [Featherstone 2008, table 6.2]
        mass_matrix [lanes] (q) -> |m| shape![m.nv(), m.nv()], hot::mass_matrix;

        /// Inverse of the mass matrix, (..., nv, nv). q (..., nq). [Carpentier 2018]
        mass_matrix_inverse(q) -> |m| shape![m.nv(), m.nv()], hot::mass_matrix_inverse;

        /// C(q, v) with C v = Coriolis and centrifugal forces and dM/dt - 2 C skew, (..., nv, nv).
        ///
        /// q (..., nq), v (..., nv). [Echeandia, Wensing 2021]
        coriolis_matrix(q, v) -> |m| shape![m.nv(), m.nv()], hot::coriolis_matrix;

        /// Derivatives of inverse dynamics in one array (..., 3, nv, nv): by q, v, a.
        _inverse_dynamics_derivatives(q, v, a) -> |m| shape![3, m.nv(), m.nv()], hot::inverse_dynamics_derivatives;

        /// Derivatives of forward dynamics in one array (..., 3, nv, nv): by q, v, tau.
        _forward_dynamics_derivatives(q, v, tau) -> |m| shape![3, m.nv(), m.nv()], hot::forward_dynamics_derivatives;

        /// Kinetic energy, (...), J. q (..., nq), v (..., nv).
        kinetic_energy(q, v) -> |_| shape![], |m, _, x, out| out[0] = d::kinetic_energy(m, x[0], x[1]);

        /// Potential energy of gravity, -m g' p_com, (...), J: it grows with height. q (..., nq).
        potential_energy(q) -> |_| shape![], |m, _, x, out| out[0] = d::potential_energy(m, x[0]);

        /// Energy of the joints' springs, (...), J. q (..., nq).
        elastic_energy(q) -> |_| shape![], |m, _, x, out| out[0] = d::elastic_energy(m, x[0]);

        /// Forces of springs and damping, (..., nv), N·m or N. q (..., nq), v (..., nv).
        passive_forces(q, v) -> |m| shape![m.nv()], |m, _, x, out| d::passive_forces_into(m, x[0], x[1], out);

        /// Matrix Y with tau = Y p, p the ten inertial parameters of each body, (..., nv, 10 n_bodies). q (..., nq), v and a (..., nv).
        joint_torque_regressor(q, v, a) -> |m| shape![m.nv(), 10 * m.n_bodies()], |m, _, x, out| write_matrix(&d::joint_torque_regressor(m, x[0], x[1], x[2]), out);

        /// Row y with T = y p, p the ten inertial parameters of each body, (..., 10 n_bodies). q (..., nq), v (..., nv).
        kinetic_energy_regressor(q, v) -> |m| shape![10 * m.n_bodies()], |m, _, x, out| out.copy_from_slice(d::kinetic_energy_regressor(m, x[0], x[1]).as_slice());

        /// Row y with U = y p, p the ten inertial parameters of each body, (..., 10 n_bodies). q (..., nq).
        potential_energy_regressor(q) -> |m| shape![10 * m.n_bodies()], |m, _, x, out| out.copy_from_slice(d::potential_energy_regressor(m, x[0]).as_slice());

        /// Forces on the bodies in their frames of a force on one frame or link, (..., n_bodies, 6). q (..., nq), force (..., 6).
        _frame_force(q, force; frame: FrameId, representation: Representation) -> |m| shape![m.n_bodies(), 6], |m, _, x, frame, representation, out| {
        let kinematics = d::forward_kinematics(m, x[0], &vec![Zero::zero(); m.nv()]);
        let mut bodies = vec![Force::zero(); m.n_bodies()];
        let force = Force::from_array(std::array::from_fn(|k| x[1][k]));
        d::add_frame_force(m, &kinematics, frame, &force, representation, &mut bodies);
        bodies.iter().zip(out.chunks_mut(6)).for_each(|(force, out)| write_force(force, out));
        };
    } };
}
