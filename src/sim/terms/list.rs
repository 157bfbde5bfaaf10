//! The list of terms.

use super::bounded_derivatives::BoundedDerivatives;
use super::bounded_forces::BoundedForces;
use super::constraint_derivatives::ConstraintDerivatives;
use super::constraints::Constraints;
use super::contact::{Contact, ContactDerivatives};
use super::drives::{DriveDerivatives, Drives};
use super::frame_forces::{FrameForceDerivatives, FrameForces};
use super::frame_servos::{FrameServoDerivatives, FrameServos};
use super::joint_limits::{JointLimitDerivatives, JointLimits};
use super::numbers::Numbers;
use super::sink::{DerivativePoint, Sink};
use super::tendon_servos::{TendonDerivatives, TendonServos};
use super::term::{Term, TermDerivatives};
use crate::scalar::{Over, Scalar};
use crate::sim::balance::Balance;
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::forces::Forces;
use crate::sim::simulator::Simulator;

/// Declares the list: the memory of all terms, and one function for each of the traits above that goes over them in order.
macro_rules! list_terms {
    ($($name:ident: $term:ident, $slopes:ident;)*) => {
        /// All terms at an instant.
        #[derive(Clone, Debug)]
        pub(crate) struct Terms<T: Scalar> {
            $(pub(crate) $name: $term<T>,)*
        }

        impl<T: Scalar> Terms<T> {
            pub(crate) fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
                Self { $($name: $term::new(simulator),)* }
            }
        }

        impl<P: Scalar, T: Over<P>> Term<P, T> for Terms<T> {
            #[inline]
            fn add_forces(&mut self, at: &EvaluationPoint<'_, P, T>, forces: &mut Forces<T>) {
                $(self.$name.add_forces(at, forces);)*
            }

            fn add_rows(&mut self, at: &EvaluationPoint<'_, P, T>, balance: &mut Balance<T>) {
                $(self.$name.add_rows(at, balance);)*
            }

            fn add_references(&mut self, at: &EvaluationPoint<'_, P, T>, balance: &mut Balance<T>) {
                $(self.$name.add_references(at, balance);)*
            }

            fn add_violated(&mut self, at: &EvaluationPoint<'_, P, T>, balance: &mut Balance<T>, a: &[T]) -> bool {
                let mut any = false;
                $(any |= self.$name.add_violated(at, balance, a);)*
                any
            }

            fn accept(&mut self, at: &EvaluationPoint<'_, P, T>, balance: &mut Balance<T>) {
                $(self.$name.accept(at, balance);)*
            }
        }

        /// The derivatives of all terms at an instant.
        #[derive(Clone, Debug)]
        pub(crate) struct AllDerivatives<T: Scalar> {
            $($name: $slopes<T>,)*
        }

        impl<T: Scalar> AllDerivatives<T> {
            pub(crate) fn new(simulator: &Simulator) -> Self {
                Self { $($name: $slopes::new(simulator),)* }
            }
        }

        impl<T: Scalar> TermDerivatives<T> for AllDerivatives<T> {
            type Term = Terms<T>;

            fn reserve_numbers(&mut self, simulator: &Simulator) {
                $(self.$name.reserve_numbers(simulator);)*
            }

            fn emit_forces<S: Sink<T>>(&mut self, at: &DerivativePoint<'_, T>, terms: &Terms<T>, out: &mut S) {
                $(self.$name.emit_forces(at, &terms.$name, out);)*
            }

            fn emit_rows<S: Sink<T>>(&mut self, at: &DerivativePoint<'_, T>, terms: &Terms<T>, out: &mut S) {
                $(self.$name.emit_rows(at, &terms.$name, out);)*
            }

            fn emit_numbers(&mut self, at: &DerivativePoint<'_, T>, terms: &Terms<T>, out: &mut Numbers<'_, T>) {
                $(self.$name.emit_numbers(at, &terms.$name, out);)*
            }

            fn each_rate_by_force(at: &DerivativePoint<'_, T>, terms: &Terms<T>, each: &mut dyn FnMut(usize, usize, T)) {
                $($slopes::each_rate_by_force(at, &terms.$name, each);)*
            }
        }
    };
}

impl<T: Scalar> Terms<T> {
    /// Whether the pieces of the last step without rows are valid: for joint limits within reach, and bounded forces.
    pub(crate) fn have_pieces(&self) -> bool {
        !self.stops.ends().is_empty() || !self.bounded_forces.is_empty()
    }
}

// In the order of their rows; contact comes last, since the number of its rows may grow.
list_terms! {
    drives: Drives, DriveDerivatives;
    frame_forces: FrameForces, FrameForceDerivatives;
    constraints: Constraints, ConstraintDerivatives;
    stops: JointLimits, JointLimitDerivatives;
    bounded_forces: BoundedForces, BoundedDerivatives;
    tendon_servos: TendonServos, TendonDerivatives;
    frame_servos: FrameServos, FrameServoDerivatives;
    contact: Contact, ContactDerivatives;
}
