//! The integration methods.

/// The integration method.
///
/// Which to take:
///
/// * [`SemiImplicitEuler`](Self::SemiImplicitEuler), the default, for learning and for control at steps of a few milliseconds: cheapest, and stable
///   whatever dampers, springs, friction and stops a description has.
/// * [`ImplicitVelocity`](Self::ImplicitVelocity) for [soft contact](crate::contact::SoftContact), for long steps, and for what spins and must go on
///   spinning.
/// * [`RungeKutta4`](Self::RungeKutta4) for smooth motion that must be right to many digits, of closed loops too. It is explicit
///   in everything, and diverges where forces are stiff; no rigid contact.
/// * [`ImplicitMidpoint`](Self::ImplicitMidpoint) for long smooth motion whose energy and momentum must not drift, of closed loops too; no contact.
///
/// [`Simulator::remarks`](crate::Simulator::remarks) says where a step is too long for springs, dampers, limits and soft contact of a robot with its integrator,
/// [`Simulator::remarks_at`](crate::Simulator::remarks_at) where it is for rotations at a velocity.
///
/// Largest error of a coordinate after 0.5 s (rad or m, against steps of 10 µs), at steps of 1, 5 and 10 ms, and the time of a step on one core of a
/// small virtual machine, optimised for tests (`cargo test --test it -- --nocapture errors_after_half_a_second`):
///
/// | | semi-implicit Euler | implicit velocity | Runge–Kutta |
/// |---|---|---|---|
/// | UR5 with dampers of 2 N·m·s | 3e-4, 2e-3, 3e-3; 0.9 µs | 3e-4, 2e-3, 3e-3; 5 µs | diverges in the second step |
/// | quadruped that falls on soft feet (p = q = ½) | 7e-3, bounces off; 4 µs | 3e-3, 1e-2, 2e-2; 23 µs | 6e-5, 0.2, 1.4; 14 µs |
/// | free body that tumbles at 20 rad/s | 2e-2, 9e-2, 0.2; 0.8 µs | 3e-3, 1.5e-2, 3e-2; 3 µs | below 4e-5; 3 µs |
/// | slider-crank, a closed loop | 1.5e-3, 8e-3, 2e-2; 5 µs | as semi-implicit Euler | 2e-5; 11 µs |
///
/// Conservation by each method, of systems whose energy nothing but the method can change: largest loss and gain of energy as parts of the
/// kinetic energy at the start (of the delta robot, which falls from rest and swings with up to 2 J, in J), measured by the tests in
/// `tests/it/integrators.rs`.
///
/// | | semi-implicit Euler | implicit velocity | Runge–Kutta | implicit midpoint |
/// |---|---|---|---|---|
/// | flywheel, 30 rad/s, 10 s | +0.2 (1 ms), +39 (5 ms) | 1e-15, and its momentum | −8e-12 (1 ms), −2e-8 (5 ms) | +4e-13 (1 ms), −3e-13 (5 ms), and its momentum |
/// | heavy top, 300 rad/s, 5 s | ±1e-6 (1 ms), ±3e-6 (5 ms) | ±1e-6 (1 ms), ±3e-6 (5 ms) | −9e-7 (1 ms), −6e-3 (5 ms) | +4e-7 (1 ms), +1.5e-5 (5 ms) |
/// | wing nut, 6 rad/s, 100 s | +0.13 (1 ms), +6 (10 ms) | +3e-6 (1 ms), +3e-4 (10 ms), back with each flip | −1e-12 (1 ms), −4e-8 (10 ms) | +1e-6 (1 ms), +1e-4 (10 ms), back with each flip |
/// | slider-crank, 15 rad/s, 10 s | −0.014, +0.005 (1 ms); −0.5, +0.1 (10 ms) | as semi-implicit Euler | ±4e-6 (1 ms), −0.2 (10 ms) | −7e-4 (1 ms), ±2e-3 (10 ms), some steps divided |
/// | free delta robot, 10 s | ±0.4 J (1 ms); −1.8, +0.1 J (10 ms) | as semi-implicit Euler | ±5e-4 J (1 ms) | ±3e-3 J (1 ms), −8e-3 J (10 ms), some steps divided |
///
/// Linear momentum of what nothing acts on from outside, measured by the tests in `tests/it/free_bodies.rs`. Both steps of Euler keep that of a free
/// body to rounding, wherever its centre of mass is in its frame. That of a floating robot with joints drifts in proportion to the step, as its other links
/// are not stepped by their centres of mass. Change of the momentum of a robot of nine links whose joints move with up to 2 rad/s, after 1 s, relative to it:
///
/// | step | semi-implicit Euler | implicit velocity |
/// |---|---|---|
/// | 2 ms | 1.1e-3 | 8e-4 |
/// | 1 ms | 6e-4 | 4e-4 |
///
/// [Constraints that are springs](crate::constraint::Constraint::with_spring) have the forces of the end of a step of Euler, and of the state in
/// Runge–Kutta's method.
///
/// Both steps of Euler keep the energy of closed loops but for what the stabilisation of their [constraints](crate::constraint) takes where a loop
/// passes singular places fast, as the delta robot does: −0.06 J at 0.5 ms, −0.01 J at 0.25 ms, and ±0.07 J at 1 ms with
/// [time constants](crate::constraint::Constraint::with_time_constant) of 2 ms instead of 10.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Integrator {
    /// v⁺ = v + Δt a, then q⁺ = q ⊕ Δt v⁺: of first order, one evaluation of the dynamics. A floating or planar base, or a free object, is stepped by
    /// position and velocity of its own centre of mass in the world, so that a free body keeps its linear momentum.
    ///
    /// Forces are those of the start of the step, except two kinds whose stability limit is unknown in advance:
    ///
    /// * Dampers, springs, servos, smoothed friction, speed limits and stops of joints are those of its end, linear in v⁺ with the coefficients of its start:
    ///   (M + Δt C + Δt² K) a = τ − h − Δt K v. So joints are stable at any stiffness and any step. A stop that would pull is let go,
    ///   [exact friction](crate::sim::FrictionLaw::Exact) holds a joint or brakes it, and a servo is within its effort limit.
    ///   Robots without any of these take the step of textbooks.
    /// * Where a coordinate turns by more than 0.1 rad in a step, and faster than 100 rad/s, Coriolis and centrifugal forces become those of the middle of
    ///   the step, as with [`ImplicitVelocity`](Self::ImplicitVelocity), wholly at twice that speed; their share grows as 3 x² − 2 x³ between, so that
    ///   the step and its derivatives are continuous. Light wrists that whirl stay finite. The first step that needs it allocates. With kinematic
    ///   constraints these forces are always those of the middle, which linkages need to keep their energy.
    ///
    /// Below that angle a nutation at the rate λ grows by √(1 + (λ Δt)²) in each step: a body that spins gains energy, slowly at ordinary rates.
    #[default]
    SemiImplicitEuler,
    /// Semi-implicit Euler with more of its forces inside the step: springs, servos, viscous and dry friction and speed limits of joints, their stops,
    /// and [soft contact](crate::contact::SoftContact) are those of its end, each linear in the velocity v⁺ after the step with the coefficients
    /// of its start, but never pulling and within the cone of friction, which a solver sees to. So damping of any strength is stable at any
    /// step, and so are stops; contact far stiffer than the step resolves may bounce.
    ///
    /// Coriolis and centrifugal forces c(q, v) are those of its middle, to first order in the acceleration:
    /// M a + c(v) + ½ Δt ∂c/∂v a = τ − g. Spinning bodies are stable at any rate and keep energy and momentum, see above; a base is
    /// stepped by its centre of mass, as with semi-implicit Euler. Where contact and stops act,
    /// ∂c/∂v is applied to the acceleration that there would be without them, so that the problem of the solver stays symmetric: that under the
    /// forces of kinematic constraints alone.
    ///
    /// Of first order. Motors' torque–speed curves, external forces and gravity are those of the start.
    ///
    /// # References
    /// [Hairer, Wanner 1996, section IV.7] for methods that solve with a Jacobian once.
    ImplicitVelocity,
    /// The classical method of fourth order, four evaluations, in tangent coordinates of the manifold [Munthe-Kaas 1999]. All forces are explicit: with
    /// a damper d on an inertia I it diverges where Δt d / I > 2.8.
    RungeKutta4,
    /// The implicit midpoint rule on the manifold of configurations, symplectic and of second order: the energy of smooth motion does not drift, however
    /// long it lasts, and the momentum of a free body is kept to rounding, linear and angular. Inputs, springs, dampers, friction, stops and external forces
    /// are those of the middle of the step. No contact.
    ///
    /// Rigid [constraints](crate::constraint) are closed at the end of each step, and the velocity across them is zero there, both to rounding: impulses of start
    /// and end hold them, as in the method RATTLE, which takes no [time constant](crate::constraint::Constraint::with_time_constant). A start that does not
    /// obey them is closed within its first step, however fast that is: [`assemble`](super::Simulator::assemble) it. Constraints that are springs, or have
    /// a largest force, are refused.
    ///
    /// A step is found by Newton's method and costs about ten steps of Runge and Kutta's. It is divided into 2, 4, … 1,024 equal parts, each a step of this
    /// rule, until the search for each part leads straight to a solution and the kinetic energy changes in it by the work of the forces, but for 3e-4 of the
    /// kinetic energy. Axes of joints need that where they come into line with light links between them: these joints turn by a radian or more in a step.
    /// Derivatives are those of all parts. Divided steps keep momentum as others do, energy only up to the error of each: it may shift a little with each such
    /// event, and need not come back. A model of a human of 36 joints without dampers, let go from 120 random poses at a step of 1 ms, has lost or gained 0.06 %
    /// of its kinetic energy after 2 s in the median, 0.3 % at most. If no solution is found in 1,024 parts,
    /// [`StepScratch::solver_status`](super::StepScratch::solver_status) and rollouts say so: a shorter step is needed.
    ///
    /// What the table of conservation above says of the heavy top and of the wing nut holds after 1,000,000 steps as well, at both lengths of the step; the
    /// flywheel's energy changes by 5e-11 in as many steps of 1 ms, and by 1.2e-10 in steps of 5 ms.
    ///
    /// # References
    /// [Marsden, West 2001]; [Hairer, Lubich, Wanner 2006, chapter VI].
    ImplicitMidpoint,
}
