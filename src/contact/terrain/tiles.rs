//! Height fields side by side, as ground for many robots that do not see each other.

use super::HeightField;
use super::height_field::check_memory;
use crate::scalar::{MapEach, from_each};

impl HeightField<f64> {
    /// Combines grids side by side into one: `columns` of them along x, then the next row along y, in the order of `tiles`. The first tile keeps its
    /// position. Returns the grid, and the shift (m) of each tile: the point (x, y) of a tile is at (x, y) plus its shift.
    ///
    /// Neighbouring tiles are one cell apart. The last row is filled with copies of the last tile. All nodes keep their heights. Near the border of a
    /// tile the surface differs from that of the tile alone, whose spline has no curvature there; the difference falls to a quarter with each node
    /// inwards.
    ///
    /// On such a grid robots have many grounds without parameters for each state. To give each state its own ground at the same place, use the heights
    /// as [parameters of a batch](crate::sim::BatchSimulator::of_parameters).
    ///
    /// # Panics
    /// If there are no tiles or columns, the tiles differ in spacing or size, or the grid would need more memory than the [limit](crate::memory).
    ///
    /// # Examples
    /// ```
    /// use dualbody::contact::{HeightField, Terrain};
    ///
    /// let level = |height: f64| HeightField::new([-1.0; 2], [0.5; 2], [5, 5], &[height; 25]);
    /// let (field, shifts) = HeightField::tiled(&[level(0.1), level(0.2), level(0.3)], 2);
    /// assert_eq!((field.size(), shifts[1], shifts[2]), ([10, 10], [2.5, 0.0], [0.0, 2.5]));
    /// let ground = Terrain::HeightField(field);
    /// assert!((ground.surface(&0.0, &2.5).height - 0.3).abs() < 1e-2);
    /// ```
    pub fn tiled(tiles: &[Self], columns: usize) -> (Self, Vec<[f64; 2]>) {
        let [Some(first), Some(last)] = [tiles.first(), tiles.last()] else {
            panic!("a grid of tiles has one tile or more, not none");
        };
        assert!(
            columns > 0,
            "a grid of tiles has one column or more, not none"
        );
        for (k, own) in tiles.iter().enumerate() {
            let found = (own.size(), own.spacing());
            let expected = (first.size(), first.spacing());
            assert!(
                found == expected,
                "tile {k} has size and spacing {found:?}, the first one {expected:?}"
            );
        }
        let ([nx, ny], [dx, dy]) = (first.size(), first.spacing());
        let rows = tiles.len().div_ceil(columns);
        let size = [nx.saturating_mul(columns), ny.saturating_mul(rows)];
        check_memory(size);
        let mut heights = Vec::with_capacity(size[0] * size[1]);
        for row in 0..size[1] {
            for column in 0..columns {
                let own = tiles.get(row / ny * columns + column).unwrap_or(last);
                heights.extend_from_slice(&own.heights()[row % ny * nx..][..nx]);
            }
        }
        let origin = first.origin();
        let shift = |(k, own): (usize, &Self)| {
            let [x, y] = [k % columns, k / columns].map_each(|k| k as f64);
            let place = [
                origin[0] + x * nx as f64 * dx,
                origin[1] + y * ny as f64 * dy,
            ];
            from_each(|axis| place[axis] - own.origin()[axis])
        };
        let shifts = tiles.iter().enumerate().map(shift).collect();
        (Self::new(origin, first.spacing(), size, &heights), shifts)
    }
}
