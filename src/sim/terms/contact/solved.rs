//! Contact points whose forces a solver has found, with their rows.

use std::ops::Range;

use super::rows::Contact;
use crate::contact::{Contacts, PairPoint, ROWS};
use crate::model::BodyId;
use crate::scalar::{Scalar, from_each};
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
#[derive(Clone)]
pub(super) struct ActiveRows<T: Scalar> {
    /// Row of the normal; those across follow.
    pub(super) row: usize,
    pub(super) block: usize,
    pub(super) forces: [T; ROWS],
    pub(super) delassus: T,
    /// Unit forces along the axes on each body, in it.
    pub(super) axes: [[Force<T>; ROWS]; 2],
    /// Of torsional and rolling friction; `None` without.
    pub(super) moments: Option<ActiveMoments<T>>,
}

/// Rows of the moments of a contact point; they follow those of its force.
#[derive(Clone)]
pub(super) struct ActiveMoments<T: Scalar> {
    /// Axes about which there are moments.
    pub(super) axes: Range<usize>,
    /// About all axes; zero about the others.
    pub(super) moments: [T; ROWS],
    /// Unit moments about all axes on each body, in it.
    pub(super) couples: [[Force<T>; ROWS]; 2],
}

impl<T: Scalar> ActiveRows<T> {
    /// Moments with their axes and rows.
    pub(super) fn moment_rows(&self) -> impl Iterator<Item = (usize, usize)> {
        let axes = self.moments.as_ref().map_or(0..0, |own| own.axes.clone());
        axes.zip(self.row + ROWS..)
    }

    /// Moments with their blocks, each the index of one of all that a point may have.
    pub(super) fn moment_blocks(&self) -> impl Iterator<Item = (usize, usize)> {
        let axes = self.moments.as_ref().map_or(0..0, |own| own.axes.clone());
        // The last axis belongs to the block of the one before.
        let blocks = axes.start..axes.end.min(2);
        blocks.zip(self.block + 1..)
    }
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
    let all = term.touching_in(contacts);
    let mut next = touching.iter().enumerate().peekable();
    for index in 0..term.points.len() {
        let active = next.next_if(|(_, touching)| **touching == index);
        if active.is_none() && !contacts.has_bristle(index) {
            continue;
        }
        let active = active.map(|(of, _)| {
            let (place, axes) = (term.place_of(balance, of), term.axes_of(of));
            let row = place.row;
            let moments = all.turning(index).map(|turning| {
                let used = turning.friction.axes();
                let own = |k: usize| solved.forces()[row + ROWS + k - used.start];
                ActiveMoments {
                    moments: from_each(|k| match used.contains(&k) {
                        true => own(k),
                        false => T::zero(),
                    }),
                    couples: all.unit_couples(index, &axes),
                    axes: used,
                }
            });
            ActiveRows {
                row,
                block: place.block,
                moments,
                forces: from_each(|k| solved.forces()[row + k]),
                delassus: term.delassus[of],
                axes: all.unit_forces(index, &axes),
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
