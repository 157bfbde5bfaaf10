//! The centre of mass, momenta.

/// The centre of mass, momenta.
#[macro_export]
macro_rules! momentum_functions {
    ($with:ident) => { $with! { model: Model;
        /// Centre of mass in the world, (..., 3), m. q (..., nq).
        center_of_mass(q) -> |_| shape![3], |m, _, x, out| write_vector3(&d::center_of_mass(m, x[0]), out);

        /// Velocity of the centre of mass in the world, (..., 3), m/s. q (..., nq), v (..., nv).
        center_of_mass_velocity(q, v) -> |_| shape![3], |m, _, x, out| write_vector3(&d::center_of_mass_velocity(m, x[0], x[1]), out);

        /// Acceleration of the centre of mass in the world, (..., 3), m/s². q (..., nq), v and a (..., nv).
        center_of_mass_acceleration(q, v, a) -> |_| shape![3], |m, _, x, out| write_vector3(&d::center_of_mass_acceleration(m, x[0], x[1], x[2]), out);

        /// Jacobian of the centre of mass: its velocity is J v, (..., 3, nv). q (..., nq).
        center_of_mass_jacobian(q) -> |m| shape![3, m.nv()], |m, _, x, out| write_matrix(&d::center_of_mass_jacobian(m, x[0]), out);

        /// Derivative of the centre of mass in tangent directions of q, (..., 3, nv), m. q (..., nq).
        center_of_mass_derivatives(q) -> |m| shape![3, m.nv()], |m, _, x, out| write_matrix(&d::center_of_mass_derivatives(m, x[0]), out);

        /// Momentum about the centre of mass, [linear; angular], (..., 6), kg·m/s and kg·m²/s. q (..., nq), v (..., nv).
        centroidal_momentum(q, v) -> |_| shape![6], |m, _, x, out| write_force(&d::centroidal_momentum(m, x[0], x[1]), out);

        /// Matrix A of the centroidal momentum A v, (..., 6, nv). q (..., nq). [Orin, Goswami, Lee 2013]
        centroidal_momentum_matrix(q) -> |m| shape![6, m.nv()], |m, _, x, out| write_matrix(&d::centroidal_momentum_matrix(m, x[0]), out);

        /// Rate of the centroidal momentum, (..., 6), N and N·m. q (..., nq), v and a (..., nv).
        centroidal_momentum_rate(q, v, a) -> |_| shape![6], |m, _, x, out| write_force(&d::centroidal_momentum_rate(m, x[0], x[1], x[2]), out);

        /// Rate of the centroidal momentum matrix along v, (..., 6, nv). q (..., nq), v (..., nv).
        centroidal_momentum_matrix_derivative(q, v) -> |m| shape![6, m.nv()], |m, _, x, out| write_matrix(&d::centroidal_momentum_matrix_derivative(m, x[0], x[1]), out);

        /// Derivatives of the centroidal momentum in one array (..., 2, 6, nv): by q, v.
        _centroidal_momentum_derivatives(q, v) -> |m| shape![2, 6, m.nv()], |m, _, x, out| {
            let derivatives = d::centroidal_momentum_derivatives(m, x[0], x[1]);
            write_all([&derivatives.dq, &derivatives.dv], out);
        };

        /// Momentum of all bodies in a frame ("centroidal", "world", "base"), [linear; angular], (..., 6). q (..., nq), v (..., nv).
        momentum(q, v; frame: MomentumFrame = "centroidal") -> |_| shape![6], |m, _, x, frame, out| write_force(&d::momentum(m, x[0], x[1], frame), out);

        /// Matrix of the momentum, (..., 6, nv). q (..., nq).
        momentum_matrix(q; frame: MomentumFrame = "centroidal") -> |m| shape![6, m.nv()], |m, _, x, frame, out| write_matrix(&d::momentum_matrix(m, x[0], frame), out);

        /// Inertia of the robot as one body, (..., 6, 6). q (..., nq).
        locked_inertia(q; frame: MomentumFrame = "centroidal") -> |_| shape![6, 6], |m, _, x, frame, out| {
            let inertia = d::locked_inertia(m, x[0], frame).to_matrix();
            for i in 0..6 {
                for j in 0..6 {
                    out[6 * i + j] = inertia[(i, j)];
                }
            }
        };

        /// Velocity that the robot would have as one body of the same momentum, (..., 6). q (..., nq), v (..., nv).
        average_velocity(q, v; frame: MomentumFrame = "centroidal") -> |_| shape![6], |m, _, x, frame, out| write_motion(&d::average_velocity(m, x[0], x[1], frame), out);

        /// Matrix of the average velocity, (..., 6, nv). q (..., nq).
        average_velocity_jacobian(q; frame: MomentumFrame = "centroidal") -> |m| shape![6, m.nv()], |m, _, x, frame, out| {
            write_matrix(&d::average_velocity_jacobian(m, x[0], frame), out);
        };
    } };
}
