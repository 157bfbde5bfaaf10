//! Factorisation of the mass matrix that keeps the zeros of the tree.

use std::ops::Range;

use nalgebra::DMatrix;

use super::tree_matrix::{TreeMatrix, trees};
use crate::model::Model;
use crate::model::manifold::v_range;
use crate::scalar::{ELIMINATED, Linear, Scalar, plus_scaled, vectorized_over};

/// The factors of M = Lᵀ D L, L unit lower triangular with a non-zero only where one joint is an ancestor of the other.
///
/// Solves M x = b without an inverse, in O(nv · depth) for each M and each right-hand side.
///
/// # Examples
/// ```
/// use dualbody::{dynamics::{MassMatrixFactor, mass_matrix}, model::samples};
///
/// let model = samples::arm();
/// let m = mass_matrix(&model, &[0.1; 7]);
/// let mut x = [1.0; 7];
/// MassMatrixFactor::new(&model, &m).solve(&mut x);
/// let b = &m * nalgebra::DVector::from_column_slice(&x);
/// assert!(b.iter().all(|b| (b - 1.0).abs() < 1e-10));
/// ```
///
/// # References
/// [Featherstone 2005]; [Featherstone 2008, table 6.3].
#[derive(Clone, Debug)]
pub struct MassMatrixFactor<T> {
    /// L below the diagonal, Lᵀ above it, so that rows and columns of L are both read in order; D⁻¹ on the diagonal.
    factors: TreeMatrix<T>,
    /// Ancestors of each coordinate, nearest first, one list after the other.
    ancestors: Vec<usize>,
    /// Start of the list of each coordinate, and the end of the last.
    starts: Vec<usize>,
    /// Index one past the last descendant of each coordinate; descendants are next to each other.
    ends: Vec<usize>,
    /// Coordinates that are solved for together.
    groups: Vec<Group>,
}

/// Coordinates in a row, each of which is the only child of the one before.
#[derive(Clone, Copy, Debug)]
struct Group {
    first: usize,
    /// One of [`ELIMINATED`].
    size: usize,
}

impl<T: Scalar> MassMatrixFactor<T> {
    /// Factorises a mass matrix of the model. Allocates.
    ///
    /// * `mass_matrix` – `nv` × `nv`, only the upper triangle is read
    ///
    /// A matrix that is not positive definite gives factors that are not finite or not positive.
    ///
    /// # Panics
    /// If the matrix is not `nv` × `nv`.
    pub fn new<P: Scalar>(model: &Model<P>, mass_matrix: &DMatrix<T>) -> Self {
        let mut factor = Self::unfilled(model);
        factor.refactor(mass_matrix);
        factor
    }

    /// Memory for the factors of a model, which are none yet: zeros.
    pub(crate) fn unfilled<P: Scalar>(model: &Model<P>) -> Self {
        let Ancestors {
            lists,
            starts,
            ends,
        } = Ancestors::of(model);
        Self {
            factors: TreeMatrix::zeros(model),
            ancestors: lists,
            starts,
            groups: groups(&ends),
            ends,
        }
    }

    /// Factorises another mass matrix of the same model, without allocation.
    ///
    /// # Panics
    /// If the matrix is not `nv` × `nv`.
    pub fn refactor(&mut self, mass_matrix: &DMatrix<T>) {
        let n = self.factors.size();
        assert_eq!(mass_matrix.shape(), (n, n), "a mass matrix is nv × nv");
        self.refactor_filled(|factors| factors.copy_from(mass_matrix));
    }

    /// [`refactor`](Self::refactor) of a matrix that is written where its factors will be; previous values are
    /// overwritten.
    pub(crate) fn refactor_filled(&mut self, fill: impl FnOnce(&mut TreeMatrix<T>)) {
        fill(&mut self.factors);
        self.factorize();
    }

    /// Not generic in what has filled the matrix: compiled once for each scalar and kind of vector instructions.
    fn factorize(&mut self) {
        vectorized_over::<T, _>(
            #[inline(always)]
            || self.eliminate(),
        );
    }

    #[inline(always)]
    fn eliminate(&mut self) {
        for k in (0..self.factors.size()).rev() {
            let (tree, before, own) = self.factors.split_before(k);
            let own_row = k - tree.start;
            let reciprocal = T::one() / own[own_row];
            own[own_row] = reciprocal;
            let ancestors = &self.ancestors[self.starts[k]..self.starts[k + 1]];
            for &i in ancestors {
                let row = i - tree.start;
                // M_ij −= M_ki M_kj / M_kk for all j of the tree up to i, including zeros of those that are not ancestors of k
                let ratio = own[row] * reciprocal;
                let column = &mut before[tree.len() * row..tree.len() * (row + 1)];
                subtract_scaled(&mut column[..=row], ratio, &own[..=row]);
                own[row] = ratio;
                column[own_row] = ratio;
            }
        }
    }

    /// Solves M x = b in place: `x` holds b (length `nv`) and becomes the solution. Over lanes, for several right-hand
    /// sides.
    ///
    /// # Panics
    /// If `x` has the wrong length.
    pub fn solve<S: Linear<T>>(&self, x: &mut [S]) {
        let n = self.factors.size();
        assert_eq!(x.len(), n, "a right-hand side has nv entries");
        S::vectorized(
            #[inline(always)]
            || self.substitute(x),
        );
    }

    #[inline(always)]
    fn substitute<S: Linear<T>>(&self, x: &mut [S]) {
        self.back_substitute(x);
        self.forward_substitute(x);
    }

    #[inline(always)]
    fn column(&self, k: usize) -> &[T] {
        self.factors.column(k)
    }

    #[inline(always)]
    fn columns<const N: usize>(&self, first: usize) -> [&[T]; N] {
        let mut out = [self.column(first); N];
        for k in 1..N {
            out[k] = self.column(first + k);
        }
        out
    }

    /// Backward substitution, the first half of [`solve`](Self::solve): Lᵀ y = b in place, from the leaves to the
    /// world. The newest solution comes last.
    #[inline(always)]
    pub(crate) fn back_substitute<S: Linear<T>>(&self, x: &mut [S]) {
        for &Group { first, size } in self.groups.iter().rev() {
            match size {
                4 => self.back_substitute_group::<S, 4>(first, x),
                2 => self.back_substitute_group::<S, 2>(first, x),
                _ => self.back_substitute_group::<S, 1>(first, x),
            }
        }
    }

    /// Backward substitution of a group of `N` coordinates: they read the same others, and none of the sums waits for
    /// another. Loops rather than closures, which are not always inlined.
    #[inline(always)]
    fn back_substitute_group<S: Linear<T>, const N: usize>(&self, first: usize, x: &mut [S]) {
        let (columns, mut y) = (self.columns::<N>(first), [x[first]; N]);
        for k in 0..N {
            y[k] = x[first + k];
        }
        for i in (first + N..self.ends[first]).rev() {
            for k in 0..N {
                y[k] = (-x[i]).times_plus(columns[k][i], y[k]);
            }
        }
        for k in (0..N).rev() {
            for i in (k + 1..N).rev() {
                y[k] = (-y[i]).times_plus(columns[k][first + i], y[k]);
            }
            x[first + k] = y[k];
        }
    }

    /// Forward substitution, the second half of [`solve`](Self::solve): D z = y, L x = z in place, from the world to
    /// the leaves.
    #[inline(always)]
    pub(crate) fn forward_substitute<S: Linear<T>>(&self, x: &mut [S]) {
        for &Group { first, size } in &self.groups {
            match size {
                4 => self.forward_substitute_group::<S, 4>(first, x),
                2 => self.forward_substitute_group::<S, 2>(first, x),
                _ => self.forward_substitute_group::<S, 1>(first, x),
            }
        }
    }

    #[inline(always)]
    fn forward_substitute_group<S: Linear<T>, const N: usize>(&self, first: usize, x: &mut [S]) {
        let (columns, mut z) = (self.columns::<N>(first), [x[first]; N]);
        for k in 0..N {
            z[k] = x[first + k] * columns[k][first + k];
        }
        for &j in self.ancestors_of(first).iter().rev() {
            for k in 0..N {
                z[k] = (-x[j]).times_plus(columns[k][j], z[k]);
            }
        }
        for k in 0..N {
            for j in 0..k {
                z[k] = (-z[j]).times_plus(columns[k][first + j], z[k]);
            }
            x[first + k] = z[k];
        }
    }

    /// Entry of D⁻¹ of a coordinate.
    #[inline(always)]
    pub(crate) fn reciprocal(&self, k: usize) -> T {
        self.column(k)[k]
    }

    /// yᵀ D⁻¹ y of some coordinates, from a first one on: with Lᵀ y = b,  bᵀ M⁻¹ b.
    #[inline(always)]
    pub(crate) fn square(&self, first: usize, y: &[T]) -> T {
        let entries = (first..).zip(y);
        entries.fold(T::zero(), |sum, (k, &y)| {
            (y * self.reciprocal(k)).mul_add(y, sum)
        })
    }

    /// Backward substitution of groups of `N` right-hand sides, which stand side by side for each coordinate; group
    /// after group.
    ///
    /// With Lᵀ X = A as well, Aᵀ M⁻¹ B = Xᵀ D⁻¹ Y; where B is zero but on the way from a coordinate to the world, so is
    /// Y.
    #[inline(always)]
    pub(crate) fn back_substitute_together<const N: usize>(&self, x: &mut [[T; N]]) {
        let n = self.factors.size();
        for j in (0..n).rev() {
            let below = j + 1..self.ends[j];
            let shares = &self.column(j)[below.clone()];
            // All groups in turn, so that none waits for its own last coordinate.
            for x in x.chunks_exact_mut(n) {
                let (mut y, solved) = (x[j], &x[below.clone()]);
                for i in (0..shares.len()).rev() {
                    y = plus_scaled(&y, -shares[i], &solved[i]);
                }
                x[j] = y;
            }
        }
    }

    /// Backward substitution of `N` right-hand sides in some coordinates alone, of which `x` has the entries.
    ///
    /// * `coordinates` – ascending, each with all of its ancestors
    #[inline(always)]
    pub(crate) fn back_substitute_along<const N: usize>(
        &self,
        coordinates: &[usize],
        x: &mut [[T; N]],
    ) {
        let x = &mut x[..coordinates.len()];
        for at in (0..coordinates.len()).rev() {
            let (column, end) = (self.column(coordinates[at]), self.ends[coordinates[at]]);
            let mut y = x[at];
            for i in (at + 1..coordinates.len()).rev() {
                if coordinates[i] < end {
                    y = plus_scaled(&y, -column[coordinates[i]], &x[i]);
                }
            }
            x[at] = y;
        }
    }

    /// Backward substitution in the coordinates of a tree alone, of which `x` has the entries.
    pub(crate) fn back_substitute_in(&self, tree: Range<usize>, x: &mut [T]) {
        for j in tree.clone().rev() {
            let below = j + 1..self.ends[j].min(tree.end);
            let shares = &self.column(j)[below.clone()];
            let mut y = x[j - tree.start];
            for (&share, i) in shares.iter().zip(below).rev() {
                y = (-share).mul_add(x[i - tree.start], y);
            }
            x[j - tree.start] = y;
        }
    }

    /// Forward substitution in the coordinates of a tree alone, of which `x` has the entries.
    pub(crate) fn forward_substitute_in(&self, tree: Range<usize>, x: &mut [T]) {
        for k in tree.clone() {
            let mut z = x[k - tree.start] * self.reciprocal(k);
            let own = self.ancestors_of(k).iter().rev();
            for &j in own.filter(|&&j| j >= tree.start) {
                z = (-x[j - tree.start]).mul_add(self.column(k)[j], z);
            }
            x[k - tree.start] = z;
        }
    }

    /// The next coordinate on the way to the world.
    pub(crate) fn nearest_ancestor(&self, i: usize) -> Option<usize> {
        self.ancestors_of(i).first().copied()
    }

    #[inline(always)]
    fn ancestors_of(&self, i: usize) -> &[usize] {
        &self.ancestors[self.starts[i]..self.starts[i + 1]]
    }
}

/// Ancestors of velocity coordinates: those before each one on the way to the world, nearest first, in its own joint,
/// then in the parent's.
///
/// A mimic joint ties branches together, so with mimic joints every coordinate counts as an ancestor of all after it in
/// what is connected.
pub(crate) struct Ancestors {
    /// Lists of all coordinates, in sequence.
    pub(crate) lists: Vec<usize>,
    /// Start of the list of each coordinate, and the end of the last.
    pub(crate) starts: Vec<usize>,
    /// Index one past the last descendant of each coordinate.
    ends: Vec<usize>,
}

impl Ancestors {
    pub(crate) fn of<P: Scalar>(model: &Model<P>) -> Self {
        let next = nearest_ancestors(model);
        let (mut lists, mut starts, mut ends) = (Vec::new(), vec![0], vec![0; next.len()]);
        for k in 0..next.len() {
            lists.extend(std::iter::successors(next[k], |&i| next[i]));
            ends[k] = k + 1;
            lists[starts[k]..].iter().for_each(|&i| ends[i] = k + 1);
            starts.push(lists.len());
        }
        Self {
            lists,
            starts,
            ends,
        }
    }
}

/// Groups of coordinates with the same last descendant, as large as can be.
fn groups(ends: &[usize]) -> Vec<Group> {
    let (mut out, mut first) = (Vec::new(), 0);
    for chain in ends.chunk_by(|a, b| a == b) {
        let end = first + chain.len();
        for size in ELIMINATED {
            while first + size <= end {
                out.push(Group { first, size });
                first += size;
            }
        }
    }
    out
}

/// y −= a x
#[inline(always)]
fn subtract_scaled<T: Scalar>(y: &mut [T], a: T, x: &[T]) {
    let x = &x[..y.len()];
    for i in 0..y.len() {
        y[i] = (-a).mul_add(x[i], y[i]);
    }
}

/// Nearest ancestor of each velocity coordinate.
fn nearest_ancestors<P: Scalar>(model: &Model<P>) -> Vec<Option<usize>> {
    if model.has_coupling() {
        let own = trees(model).into_iter().enumerate();
        return own.map(|(k, first)| (k > first).then(|| k - 1)).collect();
    }
    let mut out = vec![None; model.nv()];
    for body in model.bodies() {
        let below = body.parent.map(|p| v_range(model.body(p)).end - 1);
        for k in v_range(body) {
            out[k] = if k == body.v { below } else { Some(k - 1) };
        }
    }
    out
}
