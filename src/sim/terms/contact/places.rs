//! Places of the rows of points that take part: three for the force of a point, then those of its moments.

use crate::cone::Block;
use crate::contact::{ROWS, Turning};
use crate::scalar::Scalar;
use crate::sim::balance::Balance;

/// Rows and blocks of a point, or before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) row: usize,
    pub(super) block: usize,
}

/// Where the rows of each point begin, counted from the first of contact.
#[derive(Clone, Debug)]
pub(super) struct RowPlaces {
    starts: Vec<Place>,
    /// All rows and blocks.
    pub(super) end: Place,
}

impl RowPlaces {
    pub(super) fn new(points: usize) -> Self {
        Self {
            starts: Vec::with_capacity(points),
            end: Place::default(),
        }
    }

    pub(super) fn clear(&mut self) {
        self.starts.clear();
        self.end = Place::default();
    }

    /// Adds a point with the moments that it has.
    pub(super) fn push<P: Scalar, T: Scalar>(&mut self, turning: Option<&Turning<P, T>>) {
        self.starts.push(self.end);
        let axes = turning.map_or(0..0, |turning| turning.friction.axes());
        let blocks = usize::from(axes.contains(&0)) + usize::from(axes.contains(&1));
        self.end.row += ROWS + axes.len();
        self.end.block += 1 + blocks;
    }

    /// Where the rows of a point begin.
    pub(super) fn start(&self, of: usize) -> Place {
        self.starts[of]
    }

    /// Rows of the moments of a point.
    pub(super) fn moments(&self, of: usize) -> usize {
        let next = self.starts.get(of + 1).unwrap_or(&self.end);
        next.row - self.starts[of].row - ROWS
    }
}

/// The blocks of moments about some axes of a point.
pub(super) fn has_block(block: Block, axes: &std::ops::Range<usize>) -> bool {
    axes.contains(&usize::from(block == Block::Roll))
}

/// The forces of the last solution along the axes of a point, then its moments.
pub(super) fn last_forces<'a, T: Scalar>(
    places: &RowPlaces,
    balance: &'a Balance<T>,
    of: usize,
) -> &'a [T] {
    let own = balance.rows.last_forces(places.end.row);
    &own[places.starts[of].row..][..ROWS + places.moments(of)]
}
