//! Kinematic constraints between attachment frames of a robot or the world, in addition to its joint tree.
//!
//! A constraint has rows φ(q) = 0. Their second derivative is J v̇ + J̇ v, and the simulator finds the forces λ with
//!
//! > M v̇ + h = τ + Jᵀ λ  and  J v̇ + J̇ v + (2 / T) J v + φ / T² = 0:
//!
//! an error, from an open start or from the integrator, decays like a critically damped spring with the time constant T [Baumgarte 1972]. Redundant
//! rows, such as those of a planar closed loop, share the force.
//!
//! An Euler step moves along the velocity v⁺ after it, and uses instead
//!
//! > J v̇ + ½ (b(v) + b(v⁺)) + (2 / T) (J v − ½ Δt b(v)) + φ / T² = 0  with  b(v) = J̇ v:
//!
//! to second order φ changes by Δt (J v⁺ + ½ Δt b(v⁺)) in the step and by Δt (J v − ½ Δt b(v)) in the one before. So, except for the stabilisation,
//! the rule is symmetric in time, like that of [Ryckaert, Ciccotti, Berendsen 1977], and constraints neither add energy to a linkage nor remove it;
//! the energy results of [`Integrator`](crate::Integrator) depend on this. In the first steps after a start with J v = 0, as from
//! [`assemble`](crate::Simulator::assemble), forces lack up to Δt / T of those that b needs.
//!
//! A constraint may also be a spring and damper, f = −k φ − d φ̇, and its force may be bounded. Or it is regularised as in `MuJoCo`, φ̈ + b φ̇ + k d φ + R f = 0
//! ([`Regularisation`]).
//!
//! The integrators treat constraints as follows:
//!
//! | | Euler steps | Runge–Kutta | implicit midpoint |
//! |---|---|---|---|
//! | rigid | the second rule above | the first rule, at each of its four stages | φ(q⁺) = 0 and J(q⁺) v⁺ = 0, without T |
//! | spring and damper | f = −k φ⁺ − d φ̇⁺ with φ̇⁺ = φ̇ + Δt φ̈ and φ⁺ = φ + Δt φ̇⁺: implicit, stable at any stiffness | f = −k φ − d φ̇: explicit | refused |
//! | regularised | f from φ and φ̇ at the start of the step | f from φ and φ̇ at each stage | refused |
//! | maximum force | a row that holds with any force within the bound, or yields at it | the same; the force of a spring is clamped to the bound | refused |
//!
//! Velocity forces in the middle of a step are those of the motion under rigid and elastic constraints without a bound; bounded ones act in the step
//! only, as contacts do.
//!
//! A step with constraints forms M and solves for the forces of all rows together, O(rows³) per iteration.
//!
//! | question | function | rows | reference |
//! |---|---|---|---|
//! | fix two frames to each other? | [`Constraint::weld`] | 6 | [Featherstone 2008, chapter 8] |
//! | fix their origins (ball joint)? | [`Constraint::ball`] | 3 | |
//! | keep their distance (rod)? | [`Constraint::distance`] | 1 | |
//! | couple the positions of two joints? | [`Constraint::coupler`] | 1 | |
//! | … by a polynomial: a knee, a cam? | [`Constraint::polynomial_coupler`] | 1 | |
//! | couple the positions of several joints (tendon)? | [`Constraint::tendon`] | 1 | |
//! | set the decay time of errors? | [`Constraint::with_time_constant`] | | [Baumgarte 1972] |
//! | make a constraint elastic? | [`Constraint::with_spring`] | | |
//! | make it yield as in `MuJoCo`? | [`Constraint::with_regularisation`] | | [Todorov 2014] |
//! | limit its force? | [`Constraint::with_largest_force`] | | |
//! | place it on the robot? | [`Anchor`] | | |
//! | find a state that satisfies the constraints? | [`Simulator::assemble`](crate::Simulator::assemble) | | [Marquardt 1963] |
//! | compute their errors? | [`Simulator::constraint_errors`](crate::Simulator::constraint_errors) | | |
//!
//! # References
//! [Featherstone 2008, chapters 3 and 8]; [Baumgarte 1972]; [Ryckaert, Ciccotti, Berendsen 1977].

mod anchor;
mod carried;
mod frame_axis;
mod hold;
mod impedance;
mod joints;
mod kind;
mod make;
mod reference;
mod regularisation;
mod rows;
mod weld_angle;

pub use anchor::Anchor;
use anchor::AnchorMotion;
pub(crate) use anchor::Mounted;
pub(crate) use carried::{CarriedRow, CarrierMotion};
pub(crate) use frame_axis::FrameAxis;
use hold::ForceLaw;
pub(crate) use hold::Hold;
pub use impedance::{Impedance, Sigmoid};
pub(crate) use joints::{JointMotion, TiedJoint};
pub use kind::ConstraintKind;
use kind::POWER;
pub use reference::Reference;
pub use regularisation::Regularisation;
pub(crate) use rows::{ConstraintRow, ConstraintRows};

use crate::model::{Model, Structure};
use crate::numbers::{Domain, Each, Number, Numbers, numbers};
use crate::scalar::{Cast, Dual, Over, Scalar};

/// A kinematic constraint, φ(q) = 0 at all times: its kind with parameters, rigid or elastic, with an optional maximum force.
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
    hold: ForceLaw<P>,
    /// The largest force of each row, N or N·m; `None` for any.
    largest_force: Option<P>,
    /// Structure of the robot whose joints it names, if any.
    structure: Option<Structure>,
}

numbers! { pub struct Constraint {
    kind: part(ConstraintKind),
    hold: part(ForceLaw),
    largest_force: NotNegative("largest force", "largest force of a constraint"),
    structure: kept(),
} }

impl Constraint<f64> {
    /// The constraint over dual numbers in its own parameters (except attachment frames) and those of its force law, except a regularised one, in order,
    /// from a given direction on. Kinds between attachment frames have at most one, these force laws at most two.
    pub(crate) fn seeded<T: Scalar, const N: usize>(&self, first: usize) -> Constraint<Dual<T, N>> {
        let (mut out, mut direction) = (self.lift::<Dual<T, N>>(), first);
        let mut seed = |_: Number<'_>, x: &mut Dual<T, N>| {
            x.eps[direction] = T::one();
            direction += 1;
        };
        out.kind.each_number(&mut seed);
        if out.regularisation().is_none() {
            out.hold.each_number(&mut seed);
        }
        out
    }

    /// Number of them, and of those of a regularisation. Allocates.
    pub(crate) fn own_numbers(&self) -> usize {
        self.kind.to_vec().len() + self.law_numbers()
    }

    /// Number of the parameters of its force law. Allocates.
    pub(crate) fn law_numbers(&self) -> usize {
        self.hold.to_vec().len()
    }
}

impl<P: Scalar> Constraint<P> {
    /// Kind of the constraint, with its parameters.
    pub fn kind(&self) -> &ConstraintKind<P> {
        &self.kind
    }

    /// Returns the constraint with other parameters of the same kind: over dual numbers, for derivatives in lengths and attachment frames.
    ///
    /// # Panics
    /// If the kind differs, or a value is out of range: a distance that is not positive and finite, another value that is not finite.
    #[must_use]
    pub fn with_kind<Q: Over<P>>(&self, kind: ConstraintKind<Q>) -> Constraint<Q> {
        let own = self.kind.cast::<Q>();
        let same = std::mem::discriminant(&own) == std::mem::discriminant(&kind);
        assert!(same, "a constraint keeps its kind");
        kind.check();
        Constraint {
            kind,
            hold: self.hold.lift(),
            largest_force: self.largest_force.map(Q::from),
            structure: self.structure,
        }
    }

    /// Time constant T of the error decay of a rigid constraint, s; `None` for others.
    pub fn time_constant(&self) -> Option<P> {
        match self.hold {
            ForceLaw::Rigid { time_constant } => Some(time_constant),
            ForceLaw::Spring { .. } | ForceLaw::Soft(_) => None,
        }
    }

    /// Stiffness (N/m or N·m/rad) and damping (N·s/m or N·m·s/rad) of a spring; `None` for others.
    pub fn spring(&self) -> Option<[P; 2]> {
        match self.hold {
            ForceLaw::Spring { stiffness, damping } => Some([stiffness, damping]),
            ForceLaw::Rigid { .. } | ForceLaw::Soft(_) => None,
        }
    }

    /// Parameters of a regularised constraint; `None` for others.
    pub fn regularisation(&self) -> Option<&Regularisation<P>> {
        match &self.hold {
            ForceLaw::Soft(own) => Some(own),
            ForceLaw::Rigid { .. } | ForceLaw::Spring { .. } => None,
        }
    }

    /// The largest force of each row, N or N·m; `None` for any.
    pub fn largest_force(&self) -> Option<P> {
        self.largest_force
    }

    /// Whether it may be open: a spring, regularised, or of bounded force.
    pub(crate) fn gives_way(&self) -> bool {
        self.largest_force.is_some() || self.time_constant().is_none()
    }

    /// Number of blocks of its rows: one, or with bounded forces one for each row.
    pub(crate) fn blocks(&self) -> usize {
        self.largest_force.map_or(1, |_| self.rows())
    }

    /// Number of scalar equations, rows of φ, of the constraint.
    pub(crate) fn rows(&self) -> usize {
        self.kind.rows()
    }

    /// Passes each parameter with its name to `each`: origins of attachment frames, rotations of welded ones, or coefficients of joints, or those of the
    /// powers of a coupler from the second on; length, ratio and offset; time constant, or stiffness and damping, or those of the regularisation; largest force.
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
        let mut each_of = |all: &mut [P], name: &str, first: usize, quantity: &str| {
            for (k, c) in (first..).zip(all) {
                let name = format_args!("{name} {k}");
                each(Number::new(&name, &quantity, Domain::Finite), c);
            }
        };
        match &mut self.kind {
            ConstraintKind::Tendon { coefficients, .. } => {
                each_of(coefficients, "coefficient", 0, "coefficient of a tendon");
            }
            ConstraintKind::Coupler { higher, .. } => {
                each_of(higher, "coefficient of power", 2, POWER);
            }
            _ => {}
        }
        Numbers::each_number(self, each);
    }

    /// # Panics
    /// If it belongs to another model, or a value is out of its domain.
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
    #[should_panic(expected = "a constraint keeps its kind")]
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
    #[should_panic(expected = "a tendon needs at least one joint, got none")]
    fn tendon_without_joints_is_refused() {
        let _ = Constraint::tendon(&samples::double_pendulum(), &[], 1.0);
    }
}
