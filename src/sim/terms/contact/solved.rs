//! Contact points whose forces a solver has found, with their rows.

use super::rows::Contact;
use crate::contact::{Contacts, PairPoint, ROWS};
use crate::model::BodyId;
use crate::scalar::Scalar;
use crate::sim::terms::sink::DerivativePoint;
use crate::spatial::Force;

/// A contact point whose forces a solver has found, or one without.
pub(super) struct SolvedPoint<'a, T: Scalar> {
    pub(super) contacts: &'a Contacts,
    pub(super) index: usize,
    /// The second one is `None` at a point with the ground.
    pub(super) bodies: [Option<BodyId>; 2],
    /// `None` for a point with the ground.
    pub(super) pair: Option<&'a PairPoint>,
    pub(super) active: Option<ActiveRows<T>>,
    /// Whether the gap is requested instead of rows and forces.
    pub(super) states_gap: bool,
}

/// Rows of a contact point that takes part in the solution.
#[derive(Clone, Copy)]
pub(super) struct ActiveRows<T: Scalar> {
    /// Row of the normal; those across follow.
    pub(super) row: usize,
    pub(super) block: usize,
    pub(super) forces: [T; ROWS],
    pub(super) delassus: T,
    /// Unit forces along the axes on each body, in it.
    pub(super) axes: [[Force<T>; ROWS]; 2],
}

/// Passes the points whose forces a solver has found to `each`; those without force too where they have bristles.
pub(super) fn each_solved<'a, T: Scalar>(
    at: &'a DerivativePoint<'a, T>,
    term: &'a Contact<T>,
    mut each: impl FnMut(SolvedPoint<'a, T>),
) {
    let Some((contacts, balance)) = at.point.solved_contacts().zip(at.balance()) else {
        return;
    };
    let (solved, touching) = (balance.rows(), term.touching());
    let (first_row, first_block) = (
        solved.count() - ROWS * touching.len(),
        solved.blocks() - touching.len(),
    );
    let all = term.touching_in(contacts);
    let mut next = touching.iter().enumerate().peekable();
    for index in 0..term.points.len() {
        let active = next.next_if(|(_, touching)| **touching == index);
        if active.is_none() && !contacts.has_bristle(index) {
            continue;
        }
        let active = active.map(|(of, _)| {
            let row = first_row + ROWS * of;
            ActiveRows {
                row,
                block: first_block + of,
                forces: std::array::from_fn(|k| solved.forces()[row + k]),
                delassus: solved.delassus(row),
                axes: all.unit_forces(index, &term.axes_of(of)),
            }
        });
        each(SolvedPoint {
            contacts,
            index,
            bodies: all.bodies(index),
            pair: all.pair_point(index),
            active,
            states_gap: at.states_gaps(),
        });
    }
}
