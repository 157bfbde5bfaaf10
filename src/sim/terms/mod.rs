//! The terms of the equation of motion that are not the robot's own inertia: one file each, and one list.
//!
//! A step balances  M v̇ + h = τ + Σ Jᵀ f. Each term adds its part to τ, to the forces on bodies, to the diagonal beside M, or to the rows
//! whose forces a solver finds; and its part of the derivatives of all that. The list below is the only place that names all of them: the
//! step ([`Simulator::step_into`](crate::Simulator::step_into)) and its Jacobians
//! ([`Simulator::linearize_into`](crate::Simulator::linearize_into)) go over it, so a new force is a file with the functions of [`Term`] and
//! [`TermDerivatives`], and a line.
//!
//! | term | forces | rows |
//! |---|---|---|
//! | `drives` | inputs through motors, springs, dampers, friction | |
//! | `frame_forces` | external forces, frame actuators | |
//! | `constraints` | | loops, welds, rods |
//! | `stops` | at a moment, or linear in the velocity after the step | the same, beside a solver |
//! | `contact` | soft, at a moment | rigid; soft over a step |

mod chain;
mod columns;
mod constraints;
mod contact;
mod contact_columns;
mod drives;
mod frame_forces;
mod linear_point;
mod stops;
mod touch;

pub(crate) use columns::{RowColumns, add_turning};
pub(crate) use constraints::{Bias, Held};
use constraints::{ConstraintColumns, Constraints};
use contact::Contact;
use contact_columns::ContactColumns;
use drives::{DriveColumns, Drives};
use frame_forces::{FrameForceColumns, FrameForces};
pub(crate) use linear_point::{Coordinates, ForceColumns, LinearPoint};
use stops::{StopColumns, Stops};

use super::balance::Balance;
use super::forces::Forces;
use super::moment::Moment;
use super::simulator::Simulator;
use crate::scalar::{Over, Scalar};

/// What a term adds to the balance of forces. Its working memory is the implementor.
pub(crate) trait Term<P: Scalar, T: Over<P>> {
    /// Adds the forces that follow from the state, and the part of them that is linear in the acceleration.
    fn add_forces(&mut self, at: &Moment<'_, P, T>, forces: &mut Forces<T>);

    /// Adds the Jacobians of the rows whose forces a solver finds, with their reference accelerations and regularisation where these do not depend
    /// on M.
    fn add_rows(&mut self, _at: &Moment<'_, P, T>, _balance: &mut Balance<T>) {}

    /// Adds reference accelerations and regularisation that depend on the diagonal of J M⁻¹ Jᵀ, which is known now.
    fn add_references(&mut self, _at: &Moment<'_, P, T>, _balance: &mut Balance<T>) {}

    /// Replaces the rows of the term by more of them where the acceleration `a` breaks its law. Returns whether there are any.
    fn add_violated(
        &mut self,
        _at: &Moment<'_, P, T>,
        _balance: &mut Balance<T>,
        _a: &[T],
    ) -> bool {
        false
    }

    /// Takes the forces of its rows.
    fn accept(&mut self, _at: &Moment<'_, P, T>, _balance: &mut Balance<T>) {}
}

/// What a term adds to the Jacobians of a step. Its working memory is the implementor.
pub(crate) trait TermDerivatives {
    /// Adds −∂τ and −∂(Jᵀ f) of the forces that follow from the state, at the acceleration that has been found.
    fn add_forces(&mut self, at: &LinearPoint<'_>, forces: &mut ForceColumns);

    /// Adds ∂y of its rows at fixed forces and accelerations, and −∂(Jᵀ f).
    fn add_rows(
        &mut self,
        _at: &LinearPoint<'_>,
        _rows: &mut RowColumns,
        _forces: &mut ForceColumns,
    ) {
    }

    /// Takes the derivatives of the forces of its rows.
    fn accept(&mut self, _rows: &RowColumns) {}
}

/// Declares the list: the memory of all terms, and one function for each of the traits above that goes over them in order.
macro_rules! list_terms {
    ($($name:ident: $term:ident, $columns:ident;)*) => {
        /// All terms at a moment.
        #[derive(Clone, Debug)]
        pub(crate) struct Terms<T: Scalar> {
            $(pub(crate) $name: $term<T>,)*
        }

        impl<T: Scalar> Terms<T> {
            pub(super) fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
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
        pub(crate) struct TermColumns {
            $(pub(crate) $name: $columns,)*
        }

        impl TermColumns {
            pub(crate) fn new(simulator: &Simulator) -> Self {
                Self { $($name: $columns::new(simulator),)* }
            }
        }

        impl TermDerivatives for TermColumns {
            fn add_forces(&mut self, at: &LinearPoint<'_>, forces: &mut ForceColumns) {
                $(self.$name.add_forces(at, forces);)*
            }

            fn add_rows(&mut self, at: &LinearPoint<'_>, rows: &mut RowColumns, forces: &mut ForceColumns) {
                $(self.$name.add_rows(at, rows, forces);)*
            }

            fn accept(&mut self, rows: &RowColumns) {
                $(self.$name.accept(rows);)*
            }
        }
    };
}

// In the order of their rows; contact comes last, since the number of its rows may grow.
list_terms! {
    drives: Drives, DriveColumns;
    frame_forces: FrameForces, FrameForceColumns;
    constraints: Constraints, ConstraintColumns;
    stops: Stops, StopColumns;
    contact: Contact, ContactColumns;
}
