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
//! A step with constraints forms M, and solves for the forces of all rows together, O(rows³) an iteration.
//!
//! | question | function | rows | reference |
//! |---|---|---|---|
//! | hold two places together in all directions? | [`Constraint::weld`] | 6 | [Featherstone 2008, chapter 8] |
//! | but let them turn? | [`Constraint::ball`] | 3 | |
//! | hold their distance, as a rod does? | [`Constraint::distance`] | 1 | |
//! | tie one joint's position to another's? | [`Constraint::coupler`] | 1 | |
//! | how fast do errors go away? | [`Constraint::with_time_constant`] | | [Baumgarte 1972] |
//! | where on the robot? | [`Anchor`] | | |
//! | a start that obeys them? | [`Simulator::assemble`](crate::Simulator::assemble) | | [Marquardt 1963] |
//! | how far off are they? | [`Simulator::constraint_errors`](crate::Simulator::constraint_errors) | | |
//!
//! # References
//! [Featherstone 2008, chapters 3 and 8]; [Baumgarte 1972]; [Ryckaert, Ciccotti, Berendsen 1977].

mod anchor;
mod carried;
mod rows;

pub use anchor::Anchor;
use anchor::AnchorMotion;
pub(crate) use carried::{CarriedRow, CarrierMotion, Mounted};
pub(crate) use rows::{ConstraintRow, ConstraintRows, CoupledJoint};

use crate::error::UnknownName;
use crate::model::{BodyId, JointId, Model, Structure};
use crate::numbers::{Domain, Each, Numbers, numbers};
use crate::scalar::{Dual, Over, Scalar};
use crate::spatial::Transform;

/// A kinematic constraint, φ(q) = 0 at all times: its kind with its numbers, and the time in which errors go away.
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
    /// T, s.
    time_constant: P,
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
}

numbers! { pub struct Constraint {
    kind: part(ConstraintKind),
    time_constant: Positive("time constant", "time constant of a constraint"),
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
        let [first, second] = joints.map(|name| model.find_joint(name));
        let joint_ids: [JointId; 2] = [first?, second?];
        let bodies = joint_ids.map(|joint| model.joint_body(joint));
        for (name, joint) in joints.iter().zip(joint_ids) {
            let single = model.joint_q(joint).len() == 1;
            assert!(single, "\"{name}\" has not one degree of freedom to couple");
        }
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

    fn of(kind: ConstraintKind<f64>) -> Self {
        let time_constant = DEFAULT_TIME_CONSTANT;
        Self {
            kind,
            time_constant,
            structure: None,
        }
    }

    /// Sets the time in which errors go away, T (s; 10 ms otherwise). Below twice the time step it acts as if it were that; a longer one
    /// is gentler with a start that is open, keeps the errors of the integrator longer, and takes more energy from fast loops in steps of Euler.
    ///
    /// # Panics
    /// If it is not positive and finite.
    #[must_use]
    pub fn with_time_constant(mut self, time_constant: f64) -> Self {
        let phrase = format_args!("a time constant of {time_constant} s");
        Domain::Positive.hold(phrase, time_constant);
        self.time_constant = time_constant;
        self
    }

    /// The constraint over dual numbers along those of its numbers that are not those of a place, in their order, from a direction on.
    pub(crate) fn seeded<T: Scalar, const N: usize>(&self, first: usize) -> Constraint<Dual<T, N>> {
        self.seed(first)
    }

    /// Number of them.
    pub(crate) fn own_numbers(&self) -> usize {
        let mut count = 0;
        self.clone().each_number(&mut |_, _| count += 1);
        count
    }
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
            time_constant: self.time_constant.into(),
            structure: self.structure,
        }
    }

    /// Time constant T with which errors go away, s.
    pub fn time_constant(&self) -> P {
        self.time_constant
    }

    /// Number of scalar equations, rows of φ, of the constraint.
    pub fn rows(&self) -> usize {
        self.kind.rows()
    }

    /// Hands each number with its name to `each`: where anchors are in their frames, turns of those that are welded, length, ratio and offset, time constant.
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
        if let ConstraintKind::Coupler { bodies, .. } = &self.kind {
            bodies.iter().for_each(|&body| {
                model.body(body);
            });
        }
        self.kind.check();
        self.check_numbers();
    }
}

impl<P: Scalar> ConstraintKind<P> {
    fn rows(&self) -> usize {
        match self {
            Self::Weld(_) => 6,
            Self::Ball(_) => 3,
            Self::Distance { .. } | Self::Coupler { .. } => 1,
        }
    }

    /// Motions of the anchors at (q, v); identities at rest in place of missing ones, as couplers have none.
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
            Self::Coupler { .. } => &[],
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
        assert_eq!((longer.time_constant(), longer.rows()), (0.3, 1));
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
}
