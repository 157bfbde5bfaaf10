//! The integration methods.

/// The integration method.
///
/// Choosing a method:
///
/// * [`SemiImplicitEuler`](Self::SemiImplicitEuler), the default, for learning and for control at steps of a few milliseconds. It is the cheapest,
///   and stable for all dampers, springs, friction and joint limits of a description.
/// * [`ImplicitVelocity`](Self::ImplicitVelocity) for [soft contact](crate::contact::SoftContact), for long steps, and for free-spinning bodies.
/// * [`RungeKutta4`](Self::RungeKutta4) for smooth motion with high accuracy, including closed loops. It is explicit in all forces and diverges if
///   forces are stiff. It has no rigid contact.
/// * [`ImplicitMidpoint`](Self::ImplicitMidpoint) for long smooth motion whose energy and momentum must not drift, including closed loops. It has no contact.
///
/// [`Simulator::remarks`](crate::Simulator::remarks) reports a step that is too long for springs, dampers, limits and soft contact of a robot with
/// its integrator, and [`Simulator::remarks_at`](crate::Simulator::remarks_at) one that is too long for rotations at a velocity.
///
/// Largest error of a coordinate after 0.5 s (rad or m, compared with steps of 10 µs), at steps of 1, 5 and 10 ms, and the time of a step on one core of
/// a small virtual machine at commit 6a035115, with the profile of tests (`cargo test --test it -- --nocapture errors_after_half_a_second`):
///
/// | | semi-implicit Euler | implicit velocity | Runge–Kutta |
/// |---|---|---|---|
/// | UR5 with dampers of 2 N·m·s | 3e-4, 2e-3, 3e-3; 0.9 µs | 3e-4, 2e-3, 3e-3; 5 µs | diverges in the second step |
/// | quadruped that falls on soft feet (p = q = ½) | 7e-3, bounces off; 4 µs | 3e-3, 1e-2, 2e-2; 23 µs | 6e-5, 0.2, 1.4; 14 µs |
/// | free body that tumbles at 20 rad/s | 2e-2, 9e-2, 0.2; 0.8 µs | 3e-3, 1.5e-2, 3e-2; 3 µs | below 4e-5; 3 µs |
/// | slider-crank, a closed loop | 1.5e-3, 8e-3, 2e-2; 5 µs | as semi-implicit Euler | 2e-5; 11 µs |
///
/// Conservation by each method, for systems whose exact energy is constant: largest loss and gain of energy relative to the kinetic energy at the
/// start. Values for the delta robot, which falls from rest and swings with up to 2 J, are in J. Measured by the tests in `tests/it/integrators.rs`.
///
/// | | semi-implicit Euler | implicit velocity | Runge–Kutta | implicit midpoint |
/// |---|---|---|---|---|
/// | flywheel, 30 rad/s, 10 s | +0.2 (1 ms), +39 (5 ms) | 1e-15, and its momentum | −8e-12 (1 ms), −2e-8 (5 ms) | +4e-13 (1 ms), −3e-13 (5 ms), and its momentum |
/// | heavy top, 300 rad/s, 5 s | ±1e-6 (1 ms), ±3e-6 (5 ms) | ±1e-6 (1 ms), ±3e-6 (5 ms) | −9e-7 (1 ms), −6e-3 (5 ms) | +4e-7 (1 ms), +1.5e-5 (5 ms) |
/// | wing nut, 6 rad/s, 100 s | +0.13 (1 ms), +6 (10 ms) | +3e-6 (1 ms), +3e-4 (10 ms), back with each flip | −1e-12 (1 ms), −4e-8 (10 ms) | +1e-6 (1 ms), +1e-4 (10 ms), back with each flip |
/// | slider-crank, 15 rad/s, 10 s | −0.014, +0.005 (1 ms); −0.5, +0.1 (10 ms) | as semi-implicit Euler | ±4e-6 (1 ms), −0.2 (10 ms) | −7e-4 (1 ms), ±2e-3 (10 ms), some steps divided |
/// | free delta robot, 10 s | ±0.4 J (1 ms); −1.8, +0.1 J (10 ms) | as semi-implicit Euler | ±5e-4 J (1 ms) | ±3e-3 J (1 ms), −8e-3 J (10 ms), some steps divided |
///
/// Linear momentum of systems without external forces, measured by the tests in `tests/it/free_bodies.rs`. Both Euler methods conserve that of a free
/// body to rounding, for any position of its centre of mass in its frame. That of a floating robot with joints drifts in proportion to the step,
/// because its other links are not stepped by their centres of mass. Relative change of the momentum of a robot of nine links, whose joints move with
/// up to 2 rad/s, after 1 s:
///
/// | step | semi-implicit Euler | implicit velocity |
/// |---|---|---|
/// | 2 ms | 1.1e-3 | 8e-4 |
/// | 1 ms | 6e-4 | 4e-4 |
///
/// [Constraints that are springs](crate::constraint::Constraint::with_spring) use the forces at the end of an Euler step, and the forces at the state
/// in the Runge–Kutta method.
///
/// Both Euler methods conserve the energy of closed loops, except for losses through the stabilisation of their [constraints](crate::constraint).
/// These occur where a loop passes singular configurations fast, as the delta robot does: −0.06 J at 0.5 ms, −0.01 J at 0.25 ms, and ±0.07 J at 1 ms
/// with [time constants](crate::constraint::Constraint::with_time_constant) of 2 ms instead of 10.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Integrator {
    /// v⁺ = v + Δt a, then q⁺ = q ⊕ Δt v⁺. It has first order and evaluates the dynamics once. The step of a floating or planar base, or of a free
    /// object, uses position and velocity of its own centre of mass in the world, so a free body conserves its linear momentum.
    ///
    /// Forces are evaluated at the start of the step, except two kinds whose stability limit is unknown in advance:
    ///
    /// * Dampers, springs, servos, smoothed friction, speed limits and joint limits are evaluated at its end, linear in v⁺ with the coefficients of
    ///   its start: (M + Δt C + Δt² K) a = τ − h − Δt K v. So joints are stable at any stiffness and any step. A joint limit that would pull is
    ///   released, [exact friction](crate::sim::FrictionLaw::Exact) holds a joint or brakes it, and a servo is within its effort limit. Without any
    ///   of these the step is the textbook method.
    /// * Coriolis and centrifugal forces move to the middle of the step, as with [`ImplicitVelocity`](Self::ImplicitVelocity), if a coordinate
    ///   rotates by more than 0.1 rad in a step and faster than 100 rad/s. They are fully there at twice that speed; between, their share grows as 3
    ///   x² − 2 x³, so the step and its derivatives are continuous. Light wrists in fast rotation stay finite. The first step that needs this
    ///   allocates. With kinematic constraints these forces are always those of the middle of the step, which linkages need to conserve energy.
    ///
    /// Below that angle a nutation at the rate λ grows by √(1 + (λ Δt)²) in each step: a spinning body gains energy, slowly at ordinary rates.
    #[default]
    SemiImplicitEuler,
    /// Semi-implicit Euler with more implicit forces. Springs, servos, viscous and dry friction, speed limits and joint limits, and [soft
    /// contact](crate::contact::SoftContact) are evaluated at the end of the step. Each is linear in the velocity v⁺ after the step, with the
    /// coefficients of its start; a solver keeps limit and contact forces from pulling, and friction within its cone. So damping and joint limits are
    /// stable at any strength and any step; contact far stiffer than the step resolves may bounce.
    ///
    /// Coriolis and centrifugal forces c(q, v) are those of the middle of the step, to first order in the acceleration: M a + c(v) + ½ Δt ∂c/∂v a = τ
    /// − g. Spinning bodies are stable at any rate and conserve energy and momentum, see above; the step of a base uses its centre of mass, as with
    /// semi-implicit Euler. Under contact and joint limits, ∂c/∂v is applied to the acceleration without these and without servos that have a largest
    /// force (under kinematic constraints alone), so that the problem of the solver stays symmetric.
    ///
    /// It has first order. Torque–speed curves of motors, external forces and gravity are evaluated at the start of the step.
    ///
    /// # References
    /// [Hairer, Wanner 1996, section IV.7] for methods that solve with a Jacobian once.
    ImplicitVelocity,
    /// The classical method of fourth order with four evaluations, in tangent coordinates of the manifold [Munthe-Kaas 1999]. All forces are
    /// explicit: with a damper d on an inertia I it diverges if Δt d / I > 2.8.
    RungeKutta4,
    /// The implicit midpoint rule on the configuration manifold, symplectic and of second order. The energy of smooth motion does not drift, and
    /// linear and angular momentum of a free body are conserved to rounding. Inputs, springs, dampers, friction, joint limits and external forces are
    /// evaluated in the middle of the step. It has no contact.
    ///
    /// At the end of each step, errors and rates of rigid [constraints](crate::constraint) are zero to rounding: impulses at start and end hold them,
    /// as in the RATTLE method, which uses no [time constant](crate::constraint::Constraint::with_time_constant). The first step closes a start that
    /// violates them, at whatever speed that needs: call [`assemble`](super::Simulator::assemble) first. Constraints that are springs, or have a
    /// maximum force, are refused.
    ///
    /// Newton's method finds the step, which costs about ten Runge–Kutta steps. The step is divided into 2, 4, … 1,024 equal parts, each a step of
    /// this rule, until two conditions hold in each part: Newton's method converges directly, and the change of kinetic energy equals the work of the
    /// forces to 3e-4 of the kinetic energy. This is needed where joint axes with light links between them align: such joints rotate by a radian or
    /// more in a step. Derivatives include all parts. Divided steps conserve momentum, and energy only up to the error of each part: it may shift
    /// slightly with each such event. A human model of 36 joints without dampers, released from 120 random poses at a step of 1 ms, has lost or
    /// gained 0.06 % of its kinetic energy after 2 s in the median, and at most 0.3 %. If no solution is found in 1,024 parts,
    /// [`StepScratch::solver_status`](super::StepScratch::solver_status) and rollouts report it: use a shorter step.
    ///
    /// The values for the heavy top and the wing nut in the table of conservation also hold after 1,000,000 steps, at both step lengths; in as many
    /// steps the energy of the flywheel changes by 5e-11 at 1 ms and by 1.2e-10 at 5 ms.
    ///
    /// # References
    /// [Marsden, West 2001]; [Hairer, Lubich, Wanner 2006, chapter VI].
    ImplicitMidpoint,
}
