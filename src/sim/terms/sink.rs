//! Sinks: destinations of the derivatives of terms.
//!
//! A term states its forces and rows once, over numbers with derivatives in its local inputs. The sink uses them: `jacobian.rs` adds them to the
//! columns of A and B, `adjoint.rs` weights them for a gradient in the state, `numbers.rs` weights them for a gradient in the parameters of the term.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::ops::Range;

use super::local::{OfBody, OfCoordinate};
use crate::constraint::CarrierMotion;
use crate::dynamics::Kinematics;
use crate::model::{BodyId, FrameId};
use crate::scalar::Scalar;
use crate::sim::balance::Balance;
use crate::sim::evaluation_point::EvaluationPoint;
use crate::spatial::{Force, Motion, Transform};

/// Point at which terms are differentiated: an acceleration that has been found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DerivativePoint<'a, T: Scalar = f64> {
    pub(crate) point: &'a EvaluationPoint<'a, f64, T>,
    /// v̇.
    pub(crate) a: &'a [T],
    pub(crate) acting: Acting<'a, T>,
}

/// Forces at an evaluation point.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Acting<'a, T: Scalar = f64> {
    /// All, with the rows of a solver where there are any.
    All(Option<&'a Balance<T>>),
    /// Forces without joint limits and rows, and constraints along the velocity of the start of a step, with these forces.
    Start(&'a [T]),
    /// Gaps of contact points, instead of y of their normals. No forces.
    Gaps(&'a Balance<T>),
    /// Constraints alone, of which that part of y counts that depends on the velocity after the step: that of the evaluation point. No forces.
    Ahead,
}

impl<'a, T: Scalar> DerivativePoint<'a, T> {
    /// The acceleration with all that acts.
    pub(crate) fn of_all(
        point: &'a EvaluationPoint<'a, f64, T>,
        a: &'a [T],
        balance: Option<&'a Balance<T>>,
    ) -> Self {
        let acting = Acting::All(balance);
        Self { point, a, acting }
    }

    /// All rows and their forces; `None` where there are none.
    pub(crate) fn balance(&self) -> Option<&'a Balance<T>> {
        match self.acting {
            Acting::All(balance) => balance,
            Acting::Gaps(balance) => Some(balance),
            Acting::Start(_) | Acting::Ahead => None,
        }
    }

    /// Forces of rows, those of constraints first.
    pub(super) fn row_forces(&self) -> &'a [T] {
        match self.acting {
            Acting::All(balance) => balance.map_or(&[], |balance| balance.rows().forces()),
            Acting::Gaps(balance) => balance.rows().forces(),
            Acting::Start(forces) => forces,
            Acting::Ahead => &[],
        }
    }

    /// Whether contact points state their gaps.
    pub(super) fn states_gaps(&self) -> bool {
        matches!(self.acting, Acting::Gaps(_))
    }

    /// Whether rows of constraints or servos on frames depend on accelerations that bodies have while ã = 0.
    pub(super) fn has_biased_rows(&self) -> bool {
        let simulator = self.point.simulator;
        !simulator.constraints().is_empty() || simulator.frame_servos().next().is_some()
    }
}

/// A sink for values that depend on one coordinate.
pub(crate) trait CoordinateSink<L> {
    /// Takes a joint force at fixed accelerations, except for what resistance takes from it, and the input that it depends on.
    fn coordinate(&mut self, k: usize, input: Option<usize>, force: L);

    /// Takes the derivatives of a joint force on the coordinate `k` in position and rate of the coordinate `l`.
    fn coupled(&mut self, k: usize, l: usize, force: L);

    /// Takes the implicit damping diagonal: the joint force decreases by it times the acceleration.
    fn resistance(&mut self, k: usize, resistance: L);

    /// Takes y of a row at fixed forces and accelerations, and the input that it depends on.
    fn coordinate_row(&mut self, row: usize, k: usize, input: Option<usize>, y: L);
}

/// A sink for values that depend on one body, the selected one.
pub(crate) trait BodySink<T: Scalar> {
    /// Takes a force on a body, in that body: it may be another one.
    fn force(&mut self, on: Option<BodyId>, force: &Force<OfBody<T>>, own: Own);

    /// Takes y of rows at fixed forces and accelerations.
    fn rows(&mut self, rows: &[BodyRow<T>], own: Own);

    /// Takes changes over the step of entries of the contact state, or their rates at an instant, from a first one.
    fn rates(&mut self, first: usize, rates: &[OfBody<T>]);

    /// Takes the friction of a block.
    fn friction(&mut self, block: usize, friction: OfBody<T>);

    /// Takes how rows depend on the Delassus diagonal of the first one, a normal.
    fn delassus(&mut self, rows: &[BodyRow<T>], normal: &Normal<'_, T>);
}

/// y of a row, with its derivatives in accelerations of the body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BodyRow<T: Scalar> {
    /// Index of the row.
    pub(crate) row: usize,
    pub(crate) y: OfBody<T>,
    /// In the motion that ã gives to the body.
    pub(crate) by_seen: Force<T>,
    /// In the acceleration of the body while ã = 0; `None` for rows that do not depend on it.
    pub(crate) by_bias: Option<Force<T>>,
}

impl<T: Scalar> BodyRow<T> {
    pub(super) fn zero() -> Self {
        Self {
            row: 0,
            y: OfBody::from(0.0),
            by_seen: Force::zero(),
            by_bias: None,
        }
    }
}

/// The normal of a contact point, over numbers of one of the bodies on which it acts.
pub(crate) struct Normal<'a, T: Scalar> {
    /// The bodies; `None` is the ground, or the world.
    pub(crate) on: [Option<BodyId>; 2],
    /// Their index.
    pub(crate) side: usize,
    /// The unit force along it on that body, in it.
    pub(crate) force: Force<T>,
    /// Velocity along it while the bodies move with motions that are given.
    pub(crate) along: &'a dyn Fn(&[Motion<T>; 2]) -> OfBody<T>,
    /// Whether what follows from the mass matrix is to be taken too: once of the two bodies.
    pub(crate) with_mass: bool,
}

/// Meaning of the directions that are a term's own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Own {
    Nothing,
    /// The first one: an input.
    Input(usize),
    /// The last three: entries of the contact state, from a first one.
    Contact(usize),
    /// After the first one: parameters.
    Parameters(Range<usize>),
}

/// An attachment frame at which a term acts.
#[derive(Clone, Debug)]
pub(crate) struct ActingPlace {
    /// The frame that carries it; `None` is the world.
    pub(crate) frame: Option<FrameId>,
    /// Pose on the body.
    pub(crate) X_BA: Transform<f64>,
    /// Parameters of its origin in the frame, and of its rotation about its own axes; empty for none.
    pub(crate) origin: Range<usize>,
    pub(crate) turn: Range<usize>,
}

/// A sink of derivatives in the state and the input.
pub(crate) trait Sink<T: Scalar>: CoordinateSink<OfCoordinate<T>> + BodySink<T> {
    /// Selects a body or the world: values until the next call depend on it. Returns its motion.
    ///
    /// * `kinematics` – if the term has them
    fn turn_to(
        &mut self,
        at: &DerivativePoint<'_, T>,
        on: Option<BodyId>,
        kinematics: Option<&Kinematics<T>>,
    ) -> CarrierMotion<T>;

    /// Takes the attachment frame, on the body, of all values since the body was selected.
    fn place(&mut self, place: &ActingPlace);

    /// Whether derivatives in parameters are requested.
    fn wants_parameters(&self) -> bool;
}
