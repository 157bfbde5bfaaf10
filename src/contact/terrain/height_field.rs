//! Heights on a grid, interpolated by a cubic spline that is twice continuously differentiable.

use super::{Ground, PlanarDual};
use crate::memory;
use crate::numbers::{Domain, Each, Number, Numbers};
use crate::scalar::{MapEach, Over, Scalar};

/// A regular grid of heights.
///
/// Between the nodes the ground is the bicubic spline through all of them, with natural ends (no curvature across the border): normals and their
/// derivatives are smooth. Beyond the border the ground continues at the height of the border, level in the direction across it; the slope jumps at
/// the border, as at any edge.
///
/// # References
/// [de Boor 1978, chapter IV]; [Unser 1999] for the two passes from heights to coefficients.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightField<P = f64> {
    /// Position of the first node, m.
    origin: [f64; 2],
    /// Distance of neighbours along x and y, m.
    spacing: [f64; 2],
    /// Number of nodes along x and y.
    size: [usize; 2],
    /// The heights, x running fastest.
    heights: Vec<P>,
    /// Weights of the basis splines: one more node around the grid.
    weights: Vec<P>,
    /// Of the elimination of the longer side.
    ratios: Vec<f64>,
}

/// Maximum number of nodes of a recorded grid: each needs four comparisons per position.
const MOST_RECORDED_NODES: usize = 4096;

/// The fewest nodes along a side through which a spline with natural ends goes.
const LEAST_NODES: usize = 2;

impl<P: Scalar> Numbers<P> for HeightField<P> {
    type With<Q: Scalar> = HeightField<Q>;
    const COUNT: usize = 0;

    fn map_numbers<Q: Scalar>(&self, to: &mut impl FnMut(P) -> Q) -> HeightField<Q> {
        let mut all = |numbers: &[P]| numbers.iter().map(|&x| to(x)).collect();
        HeightField {
            origin: self.origin,
            spacing: self.spacing,
            size: self.size,
            heights: all(&self.heights),
            weights: all(&self.weights),
            ratios: self.ratios.clone(),
        }
    }

    /// The weights follow the heights.
    fn each_number(&mut self, each: &mut Each<'_, P>) {
        let nx = self.size[0];
        for (k, height) in self.heights.iter_mut().enumerate() {
            let name = format_args!("height {}, {}", k % nx, k / nx);
            let own = Number::new(&name, &"height of the grid", Domain::Finite);
            each(own, height);
        }
        self.weights = weights(self.size, &self.ratios, &self.heights);
    }
}

impl HeightField<f64> {
    /// A grid of `size` = [nx, ny] nodes, the first at `origin`, with distances `spacing` (m); `heights` (m) with x running fastest.
    ///
    /// # Panics
    /// If there are fewer than two nodes along a side, the number of heights is not nx · ny, a value is not finite or a spacing is not positive. If
    /// the grid would need more memory than the [limit](crate::memory).
    pub fn new(origin: [f64; 2], spacing: [f64; 2], size: [usize; 2], heights: &[f64]) -> Self {
        let [nx, ny] = size;
        assert!(
            nx >= LEAST_NODES && ny >= LEAST_NODES,
            "a height field has {nx} × {ny} nodes, expected at least {LEAST_NODES} × {LEAST_NODES}"
        );
        let nodes = nx.checked_mul(ny);
        assert_eq!(Some(heights.len()), nodes, "a height for each node");
        check_memory(size);
        for &x in origin.iter().chain(heights) {
            Domain::Finite.check("origin or a height of a height field", x);
        }
        for &d in &spacing {
            Domain::Positive.check("spacing of a height field", d);
        }
        let ratios = ratios(nx.max(ny));
        Self {
            origin,
            spacing,
            size,
            heights: heights.to_vec(),
            weights: weights(size, &ratios, heights),
            ratios,
        }
    }
}

impl<P: Scalar> HeightField<P> {
    /// The heights, x running fastest, m.
    pub fn heights(&self) -> &[P] {
        &self.heights
    }

    /// Number of nodes along x and y.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Position of the first node, m.
    pub(super) fn origin(&self) -> [f64; 2] {
        self.origin
    }

    /// Distance of neighbours along x and y, m.
    pub(super) fn spacing(&self) -> [f64; 2] {
        self.spacing
    }

    /// Weights of the basis splines.
    pub(super) fn weights(&self) -> &[P] {
        &self.weights
    }

    pub(super) fn weights_mut(&mut self) -> &mut [P] {
        &mut self.weights
    }

    /// Adds the indices of the weights of the splines that reach to a place, each once.
    pub(super) fn local_weights(&self, at: [f64; 2], out: &mut Vec<usize>) {
        let cell = [0, 1].map_each(|axis| self.locate(axis, at[axis]).cell);
        for j in 0..ORDER {
            for i in 0..ORDER {
                let index = self.index(cell, [i, j]);
                if !out.contains(&index) {
                    out.push(index);
                }
            }
        }
    }

    /// Adds derivatives in the weights to those in the heights; overwrites the former.
    pub(super) fn add_weight_slopes<T: Scalar>(&self, by_weight: &mut [T], out: &mut [T]) {
        let [nx, ny] = self.size;
        let columns = nx + 2;
        for x in 0..columns {
            spline_transposed(ny, &self.ratios, |k| x + k * columns, by_weight);
        }
        for y in 0..ny {
            let first = (y + 1) * columns;
            spline_transposed(nx, &self.ratios, |k| first + k, by_weight);
            let slopes = &by_weight[first + 1..first + 1 + nx];
            let own = out[y * nx..(y + 1) * nx].iter_mut().zip(slopes);
            own.for_each(|(own, &slope)| *own += slope);
        }
    }

    pub(super) fn surface<T: Over<P>>(&self, x: T, y: T) -> Ground<T> {
        if const { !T::HAS_VALUES } {
            return self.surface_anywhere(x, y);
        }
        self.interpolate([x, y], |[x, y], i, j| {
            let index = |lane| self.index([x.cell.value(lane), y.cell.value(lane)], [i, j]);
            if T::LANES == 1 {
                return self.weights[index(0)].into();
            }
            T::from_values(|lane| T::from(self.weights[index(lane)]).value(lane))
        })
    }

    /// The surface at a position whose cell is not known: comparisons select each weight from those of all cells.
    fn surface_anywhere<T: Over<P>>(&self, x: T, y: T) -> Ground<T> {
        let [nx, ny] = self.size;
        assert!(
            nx * ny <= MOST_RECORDED_NODES,
            "{}: a height field of {nx} × {ny} nodes is too large to be traced, since a trace compares with every cell; at most \
             {MOST_RECORDED_NODES} are possible",
            file!()
        );
        self.interpolate([x, y], |[x, y], i, j| {
            let in_row =
                |column: usize, row| self.weights[self.index([column as f64, row as f64], [i, j])];
            let of_column = |column| pick(y.cell, ny - 1, |row| T::from(in_row(column, row)));
            pick(x.cell, nx - 1, of_column)
        })
    }

    /// The surface about a place in a lane of `T`.
    pub(super) fn surface_in_lane<T: Over<P>>(
        &self,
        lane: usize,
        at: [PlanarDual; 2],
    ) -> Ground<PlanarDual> {
        self.interpolate(at, |[x, y], i, j| {
            let weight = self.weights[self.index([x.cell.re, y.cell.re], [i, j])];
            PlanarDual::from(T::from(weight).value(lane))
        })
    }

    /// * `weight` – of the i-th basis spline along x and the j-th along y that reach into the cell
    fn interpolate<T: Scalar>(
        &self,
        at: [T; 2],
        weight: impl Fn(&[Place<T>; 2], usize, usize) -> T,
    ) -> Ground<T> {
        let places = [self.locate(0, at[0]), self.locate(1, at[1])];
        let [x, y] = &places;
        let (zero, mut out) = (
            T::zero(),
            Ground {
                height: T::zero(),
                slope: [T::zero(); 2],
            },
        );
        for j in 0..ORDER {
            let (mut h, mut dh) = (zero, zero);
            for i in 0..ORDER {
                let weight = weight(&places, i, j);
                h += weight * x.basis[i];
                dh += weight * x.slope[i];
            }
            out.height += h * y.basis[j];
            out.slope[0] += dh * y.basis[j];
            out.slope[1] += h * y.slope[j];
        }
        for (axis, slope) in out.slope.iter_mut().enumerate() {
            let last = self.last(axis);
            *slope = within(places[axis].at, last, [zero, *slope, zero]);
        }
        out
    }

    /// Index of the weight of a basis spline of a cell.
    fn index(&self, cell: [f64; 2], [i, j]: [usize; 2]) -> usize {
        (cell[1] as usize + j) * (self.size[0] + 2) + cell[0] as usize + i
    }

    /// The cell along an axis, and the basis splines there.
    fn locate<T: Scalar>(&self, axis: usize, x: T) -> Place<T> {
        let last = self.last(axis);
        let at = (x - self.origin[axis]) * (1.0 / self.spacing[axis]);
        // NaN stays in the first cell and remains NaN.
        let cell = if const { T::HAS_VALUES } {
            T::from_values(|lane| at.value(lane).floor().clamp(0.0, last - 1.0).max(0.0))
        } else {
            pick(at.detached(), self.size[axis] - 1, |cell| {
                T::constant(cell as f64)
            })
        };
        let inside = within(at, last, [T::zero(), at, T::constant(last)]);
        Place::new(at, cell, inside - cell, 1.0 / self.spacing[axis])
    }

    /// Position of the last node along an axis, in cells.
    fn last(&self, axis: usize) -> f64 {
        (self.size[axis] - 1) as f64
    }
}

/// The k-th of some numbers for an x from k on until k + 1; the first and the last also before and beyond.
fn pick<T: Scalar>(x: T, count: usize, number: impl Fn(usize) -> T) -> T {
    (1..count).fold(number(0), |before, k| {
        x.select_lt(T::constant(k as f64), before, number(k))
    })
}

/// One of three numbers: where x is before 0, from there to the last node, and beyond it.
fn within<T: Scalar>(x: T, last: f64, [before, inside, beyond]: [T; 3]) -> T {
    let inside = T::constant(last).select_lt(x, beyond, inside);
    x.select_lt(T::zero(), before, inside)
}

/// Basis splines that reach into a cell.
const ORDER: usize = 4;

struct Place<T> {
    /// In cells from the first node.
    at: T,
    cell: T,
    basis: [T; ORDER],
    /// By metre.
    slope: [T; ORDER],
}

impl<T: Scalar> Place<T> {
    /// The uniform cubic basis splines at t in [0, 1] of a cell.
    fn new(at: T, cell: T, t: T, per_metre: f64) -> Self {
        let s = -t + 1.0;
        let (t2, s2) = (t * t, s * s);
        let middle = |t: T, t2: T| (t2 * t * 3.0 - t2 * 6.0 + 4.0) * (1.0 / 6.0);
        let middle_slope = |t: T, t2: T| t2 * 1.5 - t * 2.0;
        Self {
            at,
            cell,
            basis: [
                s2 * s * (1.0 / 6.0),
                middle(t, t2),
                middle(s, s2),
                t2 * t * (1.0 / 6.0),
            ],
            slope: [
                s2 * (-0.5 * per_metre),
                middle_slope(t, t2) * per_metre,
                -middle_slope(s, s2) * per_metre,
                t2 * (0.5 * per_metre),
            ],
        }
    }
}

/// # Panics
/// If there is not enough memory for the heights of a grid, the weights of its spline, and the work space.
pub(super) fn check_memory([nx, ny]: [usize; 2]) {
    let weights = nx.saturating_add(2).saturating_mul(ny.saturating_add(2));
    let bytes = weights.saturating_mul(3 * size_of::<f64>());
    let what = format_args!("grids of {nx} × {ny} heights");
    memory::granted(memory::check(what, bytes));
}

/// Six times the height at a node, the sum of the weights 1, 4 and 1 about it.
const SUM: f64 = 6.0;

/// Weights of the basis splines, first along x, then along y.
fn weights<P: Scalar>([nx, ny]: [usize; 2], ratios: &[f64], heights: &[P]) -> Vec<P> {
    let (columns, rows) = (nx + 2, ny + 2);
    let mut out = vec![P::zero(); columns * rows];
    for y in 0..ny {
        let line: Vec<P> = heights[y * nx..(y + 1) * nx].to_vec();
        let first = (y + 1) * columns;
        spline(&line, ratios, out[first..first + columns].iter_mut());
    }
    for x in 0..columns {
        let line: Vec<P> = (1..=ny).map(|y| out[y * columns + x]).collect();
        spline(&line, ratios, out[x..].iter_mut().step_by(columns));
    }
    out
}

/// The n + 2 weights c of the spline through n heights h:  (c₋₁ + 4 c₀ + c₁) / 6 = h₀, …, c₀ = h₀ and cₙ₋₁ = hₙ₋₁ at natural ends.
///
/// Tridiagonal with 4 on the diagonal: solved by elimination without pivots.
fn spline<'a, P: Scalar>(h: &[P], ratios: &[f64], out: impl Iterator<Item = &'a mut P>) {
    let n = h.len();
    let mut c = vec![P::zero(); n + 2];
    c[1] = h[0];
    for k in 1..n - 1 {
        c[k + 1] = (h[k] * SUM - c[k]) * ratios[k];
    }
    c[n] = h[n - 1];
    for k in (1..n - 1).rev() {
        c[k + 1] = c[k + 1] - c[k + 2] * ratios[k];
    }
    // No curvature at the ends: c₋₁ = 2 c₀ − c₁
    c[0] = c[1] * 2.0 - c[2];
    c[n + 1] = c[n] * 2.0 - c[n - 1];
    out.zip(c).for_each(|(out, c)| *out = c);
}

/// The transpose of [`spline`]: from derivatives in the n + 2 weights of a line to derivatives in the n heights, stored from the second position on.
///
/// * `at` – index of each entry of the line
fn spline_transposed<T: Scalar>(
    n: usize,
    ratios: &[f64],
    at: impl Fn(usize) -> usize,
    slopes: &mut [T],
) {
    let mut add = |to: usize, factor: f64, from: usize| {
        let product = slopes[at(from)] * factor;
        slopes[at(to)] += product;
    };
    add(1, 2.0, 0);
    add(2, -1.0, 0);
    add(n, 2.0, n + 1);
    add(n - 1, -1.0, n + 1);
    for k in 1..n - 1 {
        add(k + 2, -ratios[k], k + 1);
    }
    for k in (1..n - 1).rev() {
        add(k, -ratios[k], k + 1);
        // A number to itself: it becomes SUM · ratio times as large.
        add(k + 1, SUM * ratios[k] - 1.0, k + 1);
    }
}

/// Ratios of the elimination of a line of n heights: reciprocals of its pivots, 0 for the first row, which is none of it.
fn ratios(n: usize) -> Vec<f64> {
    let next = |before: &f64| Some(1.0 / (4.0 - before));
    std::iter::successors(Some(0.0), next).take(n).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[should_panic(expected = "grids of 18446744073709551615 × 3 heights need")]
    fn grid_that_memory_has_no_room_for_is_refused_by_name() {
        check_memory([2, 3]);
        check_memory([usize::MAX, 3]);
    }
}
