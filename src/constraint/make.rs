//! Constructors of constraints.

use super::hold::ForceLaw;
use super::{Anchor, Constraint, ConstraintKind, Regularisation};
use crate::error::UnknownName;
use crate::model::{BodyId, Model};
use crate::numbers::{Domain, Numbers};

/// Default T, s: ten steps of the usual millisecond.
const DEFAULT_TIME_CONSTANT: f64 = 0.01;

impl Constraint<f64> {
    /// Welds two attachment frames: they coincide in position and orientation. Six rows.
    pub fn weld(anchors: [Anchor; 2]) -> Self {
        Self::of(ConstraintKind::Weld(anchors))
    }

    /// Joins the origins of two attachment frames by a ball joint. Three rows.
    pub fn ball(anchors: [Anchor; 2]) -> Self {
        Self::of(ConstraintKind::Ball(anchors))
    }

    /// Keeps the distance (m) of the origins of two attachment frames. One row.
    ///
    /// # Panics
    /// If the distance is not positive and finite; [`ball`](Self::ball) holds them together.
    pub fn distance(anchors: [Anchor; 2], length: f64) -> Self {
        Domain::Positive.hold(format_args!("a distance of {length} m"), length);
        Self::of(ConstraintKind::Distance { anchors, length })
    }

    /// Couples two joints: q₁ = ratio q₂ + offset (rad or m), with forces on both. One row.
    ///
    /// # Errors
    /// If the model has no joint with this name.
    ///
    /// # Panics
    /// If a joint does not have one degree of freedom, or an argument is not finite.
    pub fn coupler(
        model: &Model,
        joints: [&str; 2],
        ratio: f64,
        offset: f64,
    ) -> Result<Self, UnknownName> {
        Self::polynomial_coupler(model, joints, [offset, ratio, 0.0, 0.0, 0.0])
    }

    /// Couples two joints by a polynomial, q₁ = c₀ + c₁ q₂ + c₂ q₂² + c₃ q₂³ + c₄ q₂⁴ (rad or m), with forces on both: a cam, a mechanism that is left
    /// out, the sliding of a knee. One row.
    ///
    /// * `coefficients` – c₀ to c₄
    ///
    /// # Errors
    /// If the model has no joint with this name.
    ///
    /// # Panics
    /// If a joint does not have one degree of freedom, the second follows another one (a mimic joint) and the polynomial is not linear, or an argument is
    /// not finite.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, constraint::Constraint, model::samples};
    ///
    /// // A pole on a cart that turns by the square of the way.
    /// let model = samples::cartpole();
    /// let cam = Constraint::polynomial_coupler(&model, ["pivot", "linear"], [0.0, 0.0, 0.5, 0.0, 0.0])?;
    /// let simulator = Simulator::new(model).with_time_step(1e-3).with_constraints(vec![cam]);
    /// let start = simulator.state(&[1.0, 0.5], &[1.0, 1.0]);
    /// let end = simulator.rollout(&start, 500, |_, _, _| {}).last().clone();
    /// assert!((end.q[1] - 0.5 * end.q[0] * end.q[0]).abs() < 1e-5);
    /// # Ok::<(), dualbody::UnknownName>(())
    /// ```
    pub fn polynomial_coupler(
        model: &Model,
        joints: [&str; 2],
        coefficients: [f64; 5],
    ) -> Result<Self, UnknownName> {
        let [first, second] = joints.map(|name| single_joint(model, name));
        let bodies = [first?, second?];
        let [offset, ratio, higher @ ..] = coefficients;
        let count = higher.iter().rposition(|&h| h != 0.0).map_or(0, |k| k + 1);
        assert!(
            count == 0 || model.body(bodies[1]).coupling.is_none(),
            "\"{}\" follows another joint: couple that one by a polynomial",
            joints[1]
        );
        let kind = ConstraintKind::Coupler {
            bodies,
            ratio,
            offset,
            higher: higher[..count].to_vec(),
        };
        kind.check();
        Ok(Self {
            structure: Some(model.structure()),
            ..Self::of(kind)
        })
    }

    /// Makes a fixed tendon: Σ cᵢ qᵢ = length, with forces cᵢ f on all its joints. One row.
    ///
    /// * `joints` – joints of one degree of freedom with their coefficients cᵢ, such as the radius of the pulley that it passes (m)
    /// * `length` – in the unit of cᵢ qᵢ, which is also that of the error: m, with forces in N, if cᵢ are radii; the unit of qᵢ if they are dimensionless
    ///
    /// # Errors
    /// If the model has no joint with this name.
    ///
    /// # Panics
    /// If the list of joints is empty, a joint does not have one degree of freedom, or an argument is not finite.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, State, constraint::Constraint, model::samples};
    ///
    /// // A cable from the shoulder over a pulley of 2 cm at the elbow of 1 cm: as the first joint turns one way, the second turns back twice as far.
    /// let model = samples::double_pendulum();
    /// let cable = Constraint::tendon(&model, &[("shoulder", 0.02), ("elbow", 0.01)], 0.0)?;
    /// let simulator = Simulator::new(model).with_constraints(vec![cable]);
    /// let next = simulator.step(&State::new(&[0.1, -0.2], &[0.0, 0.0]), &[1.0, 0.0]);
    /// assert!((next.v[1] + 2.0 * next.v[0]).abs() < 1e-9);
    /// # Ok::<(), dualbody::UnknownName>(())
    /// ```
    pub fn tendon(model: &Model, joints: &[(&str, f64)], length: f64) -> Result<Self, UnknownName> {
        assert!(
            !joints.is_empty(),
            "a tendon needs at least one joint, got none"
        );
        Domain::Finite.hold(format_args!("a tendon's length of {length}"), length);
        let mut bodies = Vec::with_capacity(joints.len());
        for (name, c) in joints {
            bodies.push(single_joint(model, name)?);
            Domain::Finite.hold(format_args!("a coefficient {c} of \"{name}\""), *c);
        }
        let kind = ConstraintKind::Tendon {
            joints: bodies,
            coefficients: joints.iter().map(|(_, c)| *c).collect(),
            length,
        };
        Ok(Self {
            structure: Some(model.structure()),
            ..Self::of(kind)
        })
    }

    fn of(kind: ConstraintKind<f64>) -> Self {
        let time_constant = DEFAULT_TIME_CONSTANT;
        Self {
            kind,
            hold: ForceLaw::Rigid { time_constant },
            largest_force: None,
            structure: None,
        }
    }

    /// Makes the constraint a spring and damper, f = −k φ − d φ̇ on each row, instead of rigid. Stiffness k in N/m (N·m/rad for angular rows),
    /// damping d in N·s/m (N·m·s/rad); if both are zero there is no force.
    ///
    /// Euler steps use the force at the end of the step, as at joint limits: stable at any stiffness and damping, and dissipative if the step does
    /// not resolve the spring. Runge–Kutta is explicit and needs steps that are short compared with the period of the spring.
    /// [`assemble`](crate::Simulator::assemble) ignores spring constraints.
    ///
    /// # Panics
    /// If an argument is negative or not finite.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, constraint::{Anchor, Constraint}, model::samples};
    ///
    /// // A level link of 1 kg on a pivot and a spring: each carries half of its weight.
    /// let model = samples::pendulum();
    /// let tip = Anchor::frame(&model, "rod")?.moved([0.0, 0.0, -1.0]);
    /// let nail = Anchor::world().moved([0.0, 1.0, 0.0]);
    /// let spring = Constraint::ball([nail, tip]).with_spring(1e4, 1e3);
    /// let simulator = Simulator::new(model).with_constraints(vec![spring]);
    /// let start = simulator.state(&[1.5], &[0.0]);
    /// let rest = simulator.rollout(&start, 2000, |_, _, _| {}).last().clone();
    /// let force = simulator.contact_report(&rest, &[0.0]).constraints;
    /// assert!((force[2] - 0.5 * 9.81).abs() < 0.01);
    /// # Ok::<(), dualbody::UnknownName>(())
    /// ```
    #[must_use]
    pub fn with_spring(mut self, stiffness: f64, damping: f64) -> Self {
        let domain = Domain::NotNegative;
        domain.hold(format_args!("a stiffness of {stiffness}"), stiffness);
        domain.hold(format_args!("a damping of {damping}"), damping);
        self.hold = ForceLaw::Spring { stiffness, damping };
        self
    }

    /// Bounds the force of each row (N, or N·m for angular rows). At the bound the constraint yields, and pulls with this force until the errors
    /// vanish. Use it for a breakaway joint or a motor of limited force, or with [a damper alone](Self::with_spring) for dry friction.
    ///
    /// A zero bound removes the force. Bounds act on each row separately, for example on the three axes of a ball joint, not on the magnitude of its
    /// force. At the transition between holding and yielding, derivatives are those of one side.
    ///
    /// # Panics
    /// If it is negative or not finite.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, constraint::Constraint, model::samples};
    ///
    /// // The cart is held with up to 2 N.
    /// let model = samples::cartpole();
    /// let brake = Constraint::tendon(&model, &[("linear", 1.0)], 0.0)?.with_largest_force(2.0);
    /// let simulator = Simulator::new(model).with_constraints(vec![brake]);
    /// let rest = simulator.neutral_state();
    /// assert!(simulator.step(&rest, &[1.9, 0.0]).v[0].abs() < 1e-12);
    /// assert!(simulator.step(&rest, &[2.1, 0.0]).v[0] > 1e-6);
    /// # Ok::<(), dualbody::UnknownName>(())
    /// ```
    #[must_use]
    pub fn with_largest_force(mut self, bound: f64) -> Self {
        let phrase = format_args!("a largest force of {bound}");
        Domain::NotNegative.hold(phrase, bound);
        self.largest_force = Some(bound);
        self
    }

    /// Sets the time constant T of the error decay (s; default 10 ms), and makes the constraint rigid. Values below twice the time step act as twice
    /// the time step. A longer T closes an open start more gently, keeps integration errors longer, and dissipates more energy of fast loops in Euler
    /// steps.
    ///
    /// # Panics
    /// If it is not positive and finite.
    #[must_use]
    pub fn with_time_constant(mut self, time_constant: f64) -> Self {
        let phrase = format_args!("a time constant of {time_constant} s");
        Domain::Positive.hold(phrase, time_constant);
        self.hold = ForceLaw::Rigid { time_constant };
        self
    }
}

impl Constraint<f64> {
    /// Regularises the constraint as `MuJoCo` does its equalities: the rows follow a damped oscillator, and yield in proportion to their forces.
    ///
    /// Redundant and contradictory constraints thereby share their load instead of having no solution. The force depends on the state at the start of a step; the step should be
    /// at most half of the time constant.
    ///
    /// The angular error of a weld is 2 sin(θ/2) along the axis of rotation, as in `MuJoCo`, and thus grows up to a half turn.
    ///
    /// # Panics
    /// If a parameter is out of its range.
    ///
    /// # Examples
    /// ```
    /// use dualbody::constraint::{Constraint, Regularisation};
    /// use dualbody::{Simulator, model::samples};
    ///
    /// // A cart of 1 kg with a pole, held softly: pushed by 3 N it yields until k d φ = R f.
    /// let model = samples::cartpole();
    /// let held = Constraint::tendon(&model, &[("linear", 1.0)], 0.0)?.with_regularisation(Regularisation::default());
    /// let simulator = Simulator::new(model).with_constraints(vec![held]);
    /// let start = simulator.neutral_state();
    /// let end = simulator.rollout(&start, 2000, |_, _, u| u[0] = 3.0).last().clone();
    /// assert!(end.q[0] > 1e-6 && end.q[0] < 1e-3);
    /// # Ok::<(), dualbody::UnknownName>(())
    /// ```
    #[must_use]
    pub fn with_regularisation(mut self, regularisation: Regularisation) -> Self {
        regularisation.check_numbers();
        self.hold = ForceLaw::Soft(regularisation);
        self
    }
}

/// The body that a joint of one degree of freedom moves.
fn single_joint(model: &Model, name: &str) -> Result<BodyId, UnknownName> {
    let joint = model.find_joint(name)?;
    let single = model.joint_q(joint).len() == 1;
    assert!(
        single,
        "\"{name}\" does not have exactly one degree of freedom to couple"
    );
    Ok(model.joint_body(joint))
}
