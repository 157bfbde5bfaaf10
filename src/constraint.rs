//! Kinematic constraints: what holds two places of a robot together, or to the world, beyond its tree of joints.
//!
//! A constraint gives rows φ(q) = 0. Differentiated twice they are J v̇ + J̇ v, and the simulator finds the forces λ with which
//!
//! > M v̇ + h = τ + Jᵀ λ  and  J v̇ + J̇ v + (2 / T) J v + φ / T² = 0:
//!
//! an error that is there, from a start that was not quite closed or from the error of the integrator, goes away like a critically
//! damped spring with the time constant T [Baumgarte 1972]. Redundant rows, as closed loops in a plane have them, share the force.
//!
//! A step of Euler moves along the velocity v⁺ after it, and takes instead
//!
//! > J v̇ + ½ (b(v) + b(v⁺)) + (2 / T) (J v − ½ Δt b(v)) + φ / T² = 0  with  b(v) = J̇ v:
//!
//! to second order φ changes by Δt (J v⁺ + ½ Δt b(v⁺)) in the step and by Δt (J v − ½ Δt b(v)) in the one before, so that but for what
//! stabilises it the rule is the same forward and backward in time, as that of [Ryckaert, Ciccotti, Berendsen 1977] is, and constraints neither
//! feed a linkage nor brake it; what [`Integrator`](crate::Integrator) says of energy rests on it. In the first steps after a start whose
//! velocity obeys J v = 0, as [`assemble`](crate::Simulator::assemble) gives it, forces lack up to Δt / T of those that b needs.
//!
//! A constraint may also be a spring and damper, f = −k φ − d φ̇, and its force may be bounded:
//!
//! | | steps of Euler | Runge–Kutta |
//! |---|---|---|
//! | rigid | the second rule above | the first one, at each of its four moments |
//! | spring and damper | f = −k φ⁺ − d φ̇⁺ with φ̇⁺ = φ̇ + Δt φ̈ and φ⁺ = φ + Δt φ̇⁺: implicit, stable at any stiffness | f = −k φ − d φ̇: explicit |
//! | largest force | a row that holds with any force within the bound, or gives way at it | the same; a spring's force is cut at the bound |
//!
//! Velocity forces of the middle of a step are those of the motion that rigid and elastic constraints without a bound allow; bounded ones take part in the
//! step alone, as contacts do.
//!
//! A step with constraints forms M, and solves for the forces of all rows together, O(rows³) an iteration.
//!
//! | question | function | rows | reference |
//! |---|---|---|---|
//! | hold two places together in all directions? | [`Constraint::weld`] | 6 | [Featherstone 2008, chapter 8] |
//! | but let them turn? | [`Constraint::ball`] | 3 | |
//! | hold their distance, as a rod does? | [`Constraint::distance`] | 1 | |
//! | tie one joint's position to another's? | [`Constraint::coupler`] | 1 | |
//! | tie positions of several joints, as a tendon does? | [`Constraint::tendon`] | 1 | |
//! | how fast do errors go away? | [`Constraint::with_time_constant`] | | [Baumgarte 1972] |
//! | give way like a spring and damper? | [`Constraint::with_spring`] | | |
//! | give way at a largest force? | [`Constraint::with_largest_force`] | | |
//! | where on the robot? | [`Anchor`] | | |
//! | a start that obeys them? | [`Simulator::assemble`](crate::Simulator::assemble) | | [Marquardt 1963] |
//! | how far off are they? | [`Simulator::constraint_errors`](crate::Simulator::constraint_errors) | | |
//!
//! # References
//! [Featherstone 2008, chapters 3 and 8]; [Baumgarte 1972]; [Ryckaert, Ciccotti, Berendsen 1977].

mod anchor;
mod carried;
mod hold;
mod joints;
mod rows;

pub use anchor::Anchor;
use anchor::AnchorMotion;
pub(crate) use carried::{CarriedRow, CarrierMotion, Mounted};
pub(crate) use hold::Hold;
pub(crate) use joints::{JointMotion, TiedJoint};
pub(crate) use rows::{ConstraintRow, ConstraintRows};

use crate::error::UnknownName;
use crate::model::{BodyId, Model, Structure};
use crate::numbers::{Domain, Each, Number, Numbers, numbers};
use crate::scalar::{Dual, Over, Scalar};
use crate::spatial::Transform;

/// A kinematic constraint, φ(q) = 0 at all times: its kind with its numbers, how it is held, and the largest force that holds it.
///
/// # Examples
/// ```
/// use dualbody::{Simulator, constraint::{Anchor, Constraint}, model::samples};
///
/// // A double pendulum whose tip is held at the height of its pivot: a triangle, which cannot move.
/// let model = samples::double_pendulum();
/// let tip = Anchor::frame(&model, "lower")?;
/// let nail = Anchor::world().moved([0.0, 0.0, -1.0]);
/// let triangle = Simulator::new(model).with_constraints(vec![Constraint::ball([tip, nail])]);
/// let closed = triangle.assemble(&triangle.state(&[0.9, -1.8], &[0.0, 0.0]))?;
/// assert!(triangle.constraint_errors(&closed.state).iter().all(|error| error.abs() < 1e-12));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Constraint<P = f64> {
    kind: ConstraintKind<P>,
    hold: Hold<P>,
    /// The largest force of each row, N or N·m; `None` for any.
    largest_force: Option<P>,
    /// Structure of the robot whose joints it names, if any.
    structure: Option<Structure>,
}

/// Kinds of constraints with their anchors and numbers.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ConstraintKind<P = f64> {
    /// Two anchors coincide, position and orientation. Six rows: m, in the world's axes; then rad, in the world's axes, the rotation vector from
    /// the first to the second.
    Weld([Anchor<P>; 2]),
    /// The origins of two anchors coincide: a ball joint. Three rows: m, in the world's axes, from the first to the second.
    Ball([Anchor<P>; 2]),
    /// The origins of two anchors are this far from each other: a massless rod. One row, m.
    Distance {
        /// The two anchors at the ends of the rod.
        anchors: [Anchor<P>; 2],
        /// m, positive.
        length: P,
    },
    /// The position of a joint follows that of another one: q₁ = ratio q₂ + offset. One row, rad or m.
    Coupler {
        /// The bodies that the two joints move.
        bodies: [BodyId; 2],
        /// Transmission ratio: displacement of the first joint per displacement of the second.
        ratio: P,
        /// Position of the first where that of the second is 0, rad or m.
        offset: P,
    },
    /// Positions of joints add up to a length, Σ cᵢ qᵢ = length, as where a fixed tendon passes them. One row, in the unit of that sum.
    Tendon {
        /// The bodies that the joints move.
        joints: Vec<BodyId>,
        /// cᵢ of each joint, as the moment arm of a pulley (m).
        coefficients: Vec<P>,
        /// Sum where the tendon is neither stretched nor slack.
        length: P,
    },
}

numbers! { pub struct Constraint {
    kind: part(ConstraintKind),
    hold: part(Hold),
    largest_force: NotNegative("largest force", "largest force of a constraint"),
    structure: kept(),
} }

numbers! { pub enum ConstraintKind {
    Weld(anchors: part(Anchor)),
    Ball(anchors: part(Anchor)),
    Distance { anchors: part(Anchor), length: Positive("length", "distance") },
    Coupler {
        bodies: kept(),
        ratio: Finite("ratio", "ratio of a coupler"),
        offset: Finite("offset", "offset of a coupler"),
    },
    Tendon {
        joints: kept(),
        coefficients: hidden(),
        length: Finite("length", "length of a tendon"),
    },
} }

/// T where nothing else is said, s: ten steps of the usual millisecond.
const DEFAULT_TIME_CONSTANT: f64 = 0.01;

impl Constraint<f64> {
    /// Makes a constraint by which two anchors coincide, position and orientation: six rows.
    pub fn weld(anchors: [Anchor; 2]) -> Self {
        Self::of(ConstraintKind::Weld(anchors))
    }

    /// Makes a constraint by which the origins of two anchors coincide: three rows.
    pub fn ball(anchors: [Anchor; 2]) -> Self {
        Self::of(ConstraintKind::Ball(anchors))
    }

    /// Makes a constraint by which the origins of two anchors keep a distance (m): one row.
    ///
    /// # Panics
    /// If the distance is not positive and finite; [`ball`](Self::ball) holds them together.
    pub fn distance(anchors: [Anchor; 2], length: f64) -> Self {
        Domain::Positive.hold(format_args!("a distance of {length} m"), length);
        Self::of(ConstraintKind::Distance { anchors, length })
    }

    /// Makes a constraint by which the first joint follows the second: q₁ = ratio q₂ + offset (rad or m), with forces on both; one row.
    ///
    /// # Errors
    /// If the model has no joint of a name.
    ///
    /// # Panics
    /// If a joint has not one degree of freedom, or a number is not finite.
    pub fn coupler(
        model: &Model,
        joints: [&str; 2],
        ratio: f64,
        offset: f64,
    ) -> Result<Self, UnknownName> {
        let [first, second] = joints.map(|name| single_joint(model, name));
        let bodies = [first?, second?];
        let finite = ratio.is_finite() && offset.is_finite();
        assert!(finite, "ratio {ratio} and offset {offset} are finite");
        let kind = ConstraintKind::Coupler {
            bodies,
            ratio,
            offset,
        };
        Ok(Self {
            structure: Some(model.structure()),
            ..Self::of(kind)
        })
    }

    /// Makes a constraint by which positions of joints add up to a length, Σ cᵢ qᵢ = length, with forces cᵢ f on all of them: a fixed tendon; one row.
    ///
    /// * `joints` – joints of one degree of freedom with their coefficients cᵢ, such as the radius of the pulley that it passes (m)
    /// * `length` – in the unit of cᵢ qᵢ, in which error and force are too: with radii m and N, with numbers the unit of qᵢ
    ///
    /// # Errors
    /// If the model has no joint of a name.
    ///
    /// # Panics
    /// If there is no joint, a joint has not one degree of freedom, or a number is not finite.
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
            "a tendon passes one joint or more, not none"
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
            hold: Hold::Rigid { time_constant },
            largest_force: None,
            structure: None,
        }
    }

    /// Makes a spring and damper of the constraint, f = −k φ − d φ̇ on each row, in place of what holds it rigidly. Stiffness k in N/m (N·m/rad for
    /// rows of angles), damping d in N·s/m (N·m·s/rad); without both there is no force.
    ///
    /// In steps of Euler the force is that of the end of the step, as at joint limits: stable at any stiffness and damping, and dissipative where the
    /// step does not resolve the spring. Runge–Kutta's method takes it as it is at each moment, explicitly, so that it needs steps that are short
    /// beside the period of the spring. [`assemble`](crate::Simulator::assemble) does not close it: its force lets φ be what it is.
    ///
    /// # Panics
    /// If a number is negative or not finite.
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
        self.hold = Hold::Spring { stiffness, damping };
        self
    }

    /// Bounds the force of each row (N, or N·m for rows of angles): beyond it the constraint gives way, and keeps pulling with it until errors are
    /// gone. A breakaway, a motor of limited force; with [a damper alone](Self::with_spring), dry friction.
    ///
    /// A zero leaves no force. Bounds act on each row by itself, the three axes of a ball joint, not on the length of its force. Where a bounded row
    /// is between holding and giving way, derivatives are those of one side.
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

    /// Sets the time in which errors go away, T (s; 10 ms otherwise), and holds the constraint rigidly. Below twice the time step it acts as if it were that; a longer one
    /// is gentler with a start that is open, keeps the errors of the integrator longer, and takes more energy from fast loops in steps of Euler.
    ///
    /// # Panics
    /// If it is not positive and finite.
    #[must_use]
    pub fn with_time_constant(mut self, time_constant: f64) -> Self {
        let phrase = format_args!("a time constant of {time_constant} s");
        Domain::Positive.hold(phrase, time_constant);
        self.hold = Hold::Rigid { time_constant };
        self
    }

    /// The constraint over dual numbers along those of its kind, but for places, and of how it is held, in their order, from a direction on. No
    /// kind between anchors has more than one, and none is held by more than two.
    pub(crate) fn seeded<T: Scalar, const N: usize>(&self, first: usize) -> Constraint<Dual<T, N>> {
        let (mut out, mut direction) = (self.lift::<Dual<T, N>>(), first);
        let mut seed = |_: Number<'_>, x: &mut Dual<T, N>| {
            x.eps[direction] = T::one();
            direction += 1;
        };
        out.kind.each_number(&mut seed);
        out.hold.each_number(&mut seed);
        out
    }

    /// Number of them. Allocates.
    pub(crate) fn own_numbers(&self) -> usize {
        self.kind.to_vec().len() + self.hold.to_vec().len()
    }
}

/// The body that a joint of one degree of freedom moves.
fn single_joint(model: &Model, name: &str) -> Result<BodyId, UnknownName> {
    let joint = model.find_joint(name)?;
    let single = model.joint_q(joint).len() == 1;
    assert!(single, "\"{name}\" has not one degree of freedom to couple");
    Ok(model.joint_body(joint))
}

impl<P: Scalar> Constraint<P> {
    /// Kind of the constraint, with its numbers.
    pub fn kind(&self) -> &ConstraintKind<P> {
        &self.kind
    }

    /// Returns the constraint with other numbers of the same kind: over dual numbers, for derivatives in lengths and places.
    ///
    /// # Panics
    /// If it is of another kind, or a number makes no sense: a distance that is not positive and finite, others that are not finite.
    #[must_use]
    pub fn with_kind<Q: Over<P>>(&self, kind: ConstraintKind<Q>) -> Constraint<Q> {
        let own = self.kind.cast::<Q>();
        let same = std::mem::discriminant(&own) == std::mem::discriminant(&kind);
        assert!(same, "a constraint stays of its kind");
        kind.check();
        Constraint {
            kind,
            hold: self.hold.lift(),
            largest_force: self.largest_force.map(Q::from),
            structure: self.structure,
        }
    }

    /// Time constant T with which errors go away, s; `None` for a spring.
    pub fn time_constant(&self) -> Option<P> {
        match self.hold {
            Hold::Rigid { time_constant } => Some(time_constant),
            Hold::Spring { .. } => None,
        }
    }

    /// Stiffness (N/m or N·m/rad) and damping (N·s/m or N·m·s/rad) of a spring; `None` where the constraint is rigid.
    pub fn spring(&self) -> Option<[P; 2]> {
        match self.hold {
            Hold::Rigid { .. } => None,
            Hold::Spring { stiffness, damping } => Some([stiffness, damping]),
        }
    }

    /// The largest force of each row, N or N·m; `None` for any.
    pub fn largest_force(&self) -> Option<P> {
        self.largest_force
    }

    /// Number of blocks of its rows: one, or with bounded forces one for each row.
    pub(crate) fn blocks(&self) -> usize {
        self.largest_force.map_or(1, |_| self.rows())
    }

    /// Number of scalar equations, rows of φ, of the constraint.
    pub fn rows(&self) -> usize {
        self.kind.rows()
    }

    /// Hands each number with its name to `each`: where anchors are in their frames, turns of those that are welded, or coefficients of joints; length, ratio
    /// and offset; time constant, or stiffness and damping; largest force.
    pub(crate) fn each_placed_number(&mut self, each: &mut Each<'_, P>) {
        const OF: [&str; 2] = ["first anchor ", "second anchor "];
        if let ConstraintKind::Weld(anchors)
        | ConstraintKind::Ball(anchors)
        | ConstraintKind::Distance { anchors, .. } = &mut self.kind
        {
            for (anchor, of) in anchors.iter_mut().zip(OF) {
                anchor.each_position(of, each);
            }
        }
        if let ConstraintKind::Weld(anchors) = &mut self.kind {
            for (anchor, of) in anchors.iter_mut().zip(OF) {
                anchor.each_turn(of, each);
            }
        }
        if let ConstraintKind::Tendon { coefficients, .. } = &mut self.kind {
            for (k, c) in coefficients.iter_mut().enumerate() {
                let name = format_args!("coefficient {k}");
                let quantity = &"coefficient of a tendon";
                each(Number::new(&name, quantity, Domain::Finite), c);
            }
        }
        Numbers::each_number(self, each);
    }

    /// # Panics
    /// If it belongs to another model, or a number makes no sense.
    pub(crate) fn check(&self, model: &Model<P>) {
        if let Some(structure) = self.structure {
            structure.check(model, "the joints of a constraint");
        }
        for anchor in self.kind.anchors() {
            anchor.check(model);
        }
        self.kind.joints().for_each(|joint| {
            model.body(joint.body);
        });
        self.kind.check();
        self.check_numbers();
    }
}

impl<P: Scalar> ConstraintKind<P> {
    fn rows(&self) -> usize {
        match self {
            Self::Weld(_) => 6,
            Self::Ball(_) => 3,
            Self::Distance { .. } | Self::Coupler { .. } | Self::Tendon { .. } => 1,
        }
    }

    /// Motions of the anchors at (q, v); identities at rest in place of missing ones, where it ties joints.
    fn motions<T: Over<P>>(&self, model: &Model<P>, q: &[T], v: &[T]) -> [AnchorMotion<T>; 2] {
        let anchors = self.anchors();
        std::array::from_fn(|i| {
            let still = || AnchorMotion::at_rest(Transform::identity());
            anchors.get(i).map_or_else(still, |a| a.motion(model, q, v))
        })
    }

    pub(crate) fn anchors(&self) -> &[Anchor<P>] {
        match self {
            Self::Weld(anchors) | Self::Ball(anchors) | Self::Distance { anchors, .. } => anchors,
            Self::Coupler { .. } | Self::Tendon { .. } => &[],
        }
    }

    /// # Panics
    /// If a number makes no sense.
    fn check(&self) {
        for anchor in self.anchors() {
            anchor.placement.map_numbers(&mut |x| {
                Domain::Finite.check("number of an anchor's placement", x);
                x
            });
        }
        for joint in self.joints() {
            Domain::Finite.check("coefficient of a joint", joint.coefficient);
        }
        self.check_numbers();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::samples;

    fn anchors() -> [Anchor; 2] {
        [Anchor::world(), Anchor::world().moved([1.0, 0.0, 0.0])]
    }

    // Of the six degrees of freedom between two bodies a weld leaves none, a ball joint three, a rod five.
    #[test]
    fn rows_and_freedoms_of_two_bodies_add_up_to_six() {
        let model = samples::double_pendulum();
        let coupler = Constraint::coupler(&model, ["shoulder", "elbow"], 2.0, 0.0).unwrap();
        let left = [
            (Constraint::weld(anchors()), 0),
            (Constraint::ball(anchors()), 3),
            (Constraint::distance(anchors(), 1.0), 5),
            (coupler, 5),
            (
                Constraint::tendon(&model, &[("elbow", 2.0)], 0.0).unwrap(),
                5,
            ),
        ];
        for (constraint, freedoms) in left {
            assert_eq!(constraint.rows() + freedoms, 6, "{:?}", constraint.kind());
        }
    }

    #[test]
    fn other_numbers_of_a_kind_keep_the_time_constant() {
        let rod = Constraint::distance(anchors(), 1.0).with_time_constant(0.3);
        let longer = rod.with_kind(ConstraintKind::Distance {
            anchors: anchors(),
            length: 2.0,
        });
        assert_eq!((longer.time_constant(), longer.rows()), (Some(0.3), 1));
        assert!(matches!(longer.kind(), ConstraintKind::Distance { length, .. } if *length == 2.0));
    }

    #[test]
    #[should_panic(expected = "a constraint stays of its kind")]
    fn another_kind_is_refused() {
        let _ = Constraint::ball(anchors()).with_kind(ConstraintKind::Weld(anchors()));
    }

    #[test]
    #[should_panic(expected = "a distance of 0 m is not positive and finite")]
    fn rod_of_no_length_is_refused() {
        let _ = Constraint::distance(anchors(), 0.0);
    }

    #[test]
    #[should_panic(expected = "the anchors of a constraint")]
    fn anchor_of_another_robot_is_refused() {
        let tip = Anchor::frame(&samples::double_pendulum(), "lower").unwrap();
        Constraint::ball([tip, Anchor::world()]).check(&samples::arm());
    }

    #[test]
    fn unknown_joint_of_a_coupler_is_an_error_that_names_it() {
        let model = samples::double_pendulum();
        let error = Constraint::coupler(&model, ["shoulder", "knee"], 1.0, 0.0).unwrap_err();
        assert_eq!(error.name, "knee");
    }

    #[test]
    fn springs_and_largest_forces_are_kept_and_replace_what_was_rigid() {
        let rod = Constraint::distance(anchors(), 1.0).with_largest_force(3.0);
        assert_eq!((rod.spring(), rod.largest_force()), (None, Some(3.0)));
        let soft = rod.with_spring(200.0, 5.0);
        assert_eq!(
            (soft.spring(), soft.time_constant()),
            (Some([200.0, 5.0]), None)
        );
        assert_eq!((soft.largest_force(), soft.blocks()), (Some(3.0), 1));
        let rigid = soft.with_time_constant(0.1);
        assert_eq!((rigid.spring(), rigid.time_constant()), (None, Some(0.1)));
        let ball = Constraint::ball(anchors());
        assert_eq!(ball.blocks(), 1);
        assert_eq!(ball.with_largest_force(1.0).blocks(), 3);
    }

    #[test]
    #[should_panic(expected = "a stiffness of -1 is negative or not finite")]
    fn negative_stiffness_is_refused() {
        let _ = Constraint::ball(anchors()).with_spring(-1.0, 0.0);
    }

    #[test]
    #[should_panic(expected = "a largest force of inf is negative or not finite")]
    fn infinite_largest_force_is_refused() {
        let _ = Constraint::ball(anchors()).with_largest_force(f64::INFINITY);
    }

    #[test]
    #[should_panic(expected = "a tendon passes one joint or more, not none")]
    fn tendon_without_joints_is_refused() {
        let _ = Constraint::tendon(&samples::double_pendulum(), &[], 1.0);
    }
}
