//! The list of terms.

use super::adjoint::{AdjointPoint, StepSlopes, TermAdjoint};
use super::columns::RowColumns;
use super::constraint_adjoint::ConstraintAdjoint;
use super::constraints::{ConstraintColumns, Constraints};
use super::contact::{Contact, ContactAdjoint, ContactColumns};
use super::drives::{DriveAdjoint, DriveColumns, Drives};
use super::frame_forces::{FrameForceAdjoint, FrameForceColumns, FrameForces};
use super::linear_point::{ForceColumns, LinearPoint};
use super::stops::{StopAdjoint, StopColumns, Stops};
use super::term::{Term, TermDerivatives};
use crate::dynamics::Sweep;
use crate::scalar::{Differentiable, Over, Scalar};
use crate::sim::balance::Balance;
use crate::sim::forces::Forces;
use crate::sim::moment::Moment;
use crate::sim::simulator::Simulator;

/// Declares the list: the memory of all terms, and one function for each of the traits above that goes over them in order.
macro_rules! list_terms {
    ($($name:ident: $term:ident, $columns:ident, $adjoint:ident;)*) => {
        /// All terms at a moment.
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
            fn add_forces(&mut self, at: &Moment<'_, P, T>, forces: &mut Forces<T>) {
                $(self.$name.add_forces(at, forces);)*
            }

            fn add_rows(&mut self, at: &Moment<'_, P, T>, balance: &mut Balance<T>) {
                $(self.$name.add_rows(at, balance);)*
            }

            fn add_references(&mut self, at: &Moment<'_, P, T>, balance: &mut Balance<T>) {
                $(self.$name.add_references(at, balance);)*
            }

            fn add_violated(&mut self, at: &Moment<'_, P, T>, balance: &mut Balance<T>, a: &[T]) -> bool {
                let mut any = false;
                $(any |= self.$name.add_violated(at, balance, a);)*
                any
            }

            fn accept(&mut self, at: &Moment<'_, P, T>, balance: &mut Balance<T>) {
                $(self.$name.accept(at, balance);)*
            }
        }

        /// The derivatives of all terms at a moment.
        #[derive(Clone, Debug)]
        pub(crate) struct TermColumns<T: Differentiable> {
            $(pub(crate) $name: $columns<T>,)*
        }

        impl<T: Differentiable> TermColumns<T> {
            pub(crate) fn new(simulator: &Simulator) -> Self {
                Self { $($name: $columns::new(simulator),)* }
            }
        }

        impl<T: Differentiable> TermDerivatives<T> for TermColumns<T> {
            type Term = Terms<T>;

            fn add_forces(&mut self, at: &LinearPoint<'_, T>, terms: &Terms<T>, forces: &mut ForceColumns<T>) {
                $(self.$name.add_forces(at, &terms.$name, forces);)*
            }

            fn add_rows(
                &mut self,
                at: &LinearPoint<'_, T>,
                terms: &Terms<T>,
                rows: &mut RowColumns<T>,
                forces: &mut ForceColumns<T>,
            ) {
                $(self.$name.add_rows(at, &terms.$name, rows, forces);)*
            }

            fn accept(&mut self, rows: &RowColumns<T>) {
                $(self.$name.accept(rows);)*
            }
        }

        /// The gradients of all terms at a moment.
        #[derive(Clone, Debug)]
        pub(crate) struct TermAdjoints<T: Scalar> {
            $(pub(crate) $name: $adjoint<T>,)*
        }

        impl<T: Scalar> TermAdjoints<T> {
            pub(crate) fn new(simulator: &Simulator) -> Self {
                Self { $($name: $adjoint::new(simulator),)* }
            }
        }

        impl<T: Scalar> TermAdjoint<T> for TermAdjoints<T> {
            type Term = Terms<T>;

            fn add_forces(
                &mut self,
                at: &AdjointPoint<'_, T>,
                terms: &Terms<T>,
                sweep: &mut Sweep<T>,
                out: &mut StepSlopes<'_, T>,
            ) {
                $(self.$name.add_forces(at, &terms.$name, sweep, out);)*
            }

            fn add_rows(
                &mut self,
                at: &AdjointPoint<'_, T>,
                terms: &Terms<T>,
                sweep: &mut Sweep<T>,
                out: &mut StepSlopes<'_, T>,
            ) {
                $(self.$name.add_rows(at, &terms.$name, sweep, out);)*
            }
        }
    };
}

// In the order of their rows; contact comes last, since the number of its rows may grow.
list_terms! {
    drives: Drives, DriveColumns, DriveAdjoint;
    frame_forces: FrameForces, FrameForceColumns, FrameForceAdjoint;
    constraints: Constraints, ConstraintColumns, ConstraintAdjoint;
    stops: Stops, StopColumns, StopAdjoint;
    contact: Contact, ContactColumns, ContactAdjoint;
}
