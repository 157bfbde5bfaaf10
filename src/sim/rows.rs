//! The rows of a problem of forces: a Jacobian, what is wanted, and how far each gives way.

use crate::contact::cone::{Block, Certificate, ConeProblem, ConeSolver, Law};
use crate::dynamics::MassMatrixFactor;
use crate::scalar::{Scalar, vectorized};

/// Numbers that are worked on together: some vectors, without an end that is not full.
const GROUP: usize = 8;

/// Rows  y = G f + J a − wanted, block after block.
#[derive(Clone, Debug)]
pub(crate) struct Rows<T> {
    nv: usize,
    /// How many there are.
    count: usize,
    /// J, row after row, `nv` numbers each.
    jacobian: Vec<T>,
    /// X with Lᵀ X = (Jᵀ, τ), coordinate after coordinate, filled up with zeros.
    half: Vec<[T; GROUP]>,
    /// Xᵀ D⁻¹ X below the diagonal, column after column.
    products: Vec<[T; GROUP]>,
    wanted: Vec<T>,
    blocks: Vec<Block>,
    friction: Vec<T>,
    /// G.
    matrix: Vec<T>,
    regularization: Vec<T>,
    offset: Vec<T>,
    forces: Vec<T>,
}

impl<T: Scalar> Rows<T> {
    /// Memory for so many.
    pub(super) fn new(nv: usize, rows: usize, blocks: usize) -> Self {
        Self {
            nv,
            count: 0,
            jacobian: Vec::with_capacity(rows * nv),
            half: Vec::with_capacity((rows / GROUP + 1) * nv),
            products: Vec::with_capacity((rows / GROUP + 1) * rows),
            wanted: Vec::with_capacity(rows),
            blocks: Vec::with_capacity(blocks),
            friction: Vec::with_capacity(blocks),
            matrix: Vec::with_capacity(rows * rows),
            regularization: Vec::with_capacity(rows),
            offset: Vec::with_capacity(rows),
            forces: Vec::with_capacity(rows),
        }
    }

    pub(super) fn clear(&mut self) {
        self.count = 0;
        self.jacobian.clear();
        self.wanted.clear();
        self.blocks.clear();
        self.friction.clear();
        self.regularization.clear();
    }

    /// More rows of zeros, to be filled.
    pub(super) fn grow(&mut self, rows: usize) -> &mut [T] {
        let start = self.jacobian.len();
        self.count += rows;
        self.jacobian.resize(self.count * self.nv, T::zero());
        &mut self.jacobian[start..]
    }

    /// A row with a single entry.
    pub(super) fn push_unit(&mut self, k: usize, entry: f64) {
        self.grow(1)[k] = T::constant(entry);
    }

    /// What is wanted of the next row that has been added, m/s² or rad/s², and R.
    pub(super) fn push_wanted(&mut self, wanted: T, give: T) {
        self.wanted.push(wanted);
        self.regularization.push(give);
    }

    pub(super) fn push_block(&mut self, block: Block, friction: T) {
        self.blocks.push(block);
        self.friction.push(friction);
    }

    /// How many rows know what is wanted of them.
    pub(super) fn asked(&self) -> usize {
        self.wanted.len()
    }

    pub(super) fn blocks(&self) -> usize {
        self.blocks.len()
    }

    /// G, and J M⁻¹ τ for the forces τ along the coordinates.
    ///
    /// With M = Lᵀ D L and Lᵀ X = Jᵀ, which keeps the zeros of J,  G = Xᵀ D⁻¹ X: half of each solution is enough.
    pub(super) fn respond(&mut self, factor: &MassMatrixFactor<T>, tau: &[T]) {
        self.transpose(tau);
        let (n, groups) = (self.count, self.groups());
        self.products.clear();
        self.products.resize(n * groups, [T::zero(); GROUP]);
        let (half, products) = (&mut self.half[..], &mut self.products[..]);
        vectorized(
            #[inline(always)]
            || {
                factor.solve_together_from_tips(half, groups);
                for (k, x) in half.chunks_exact(groups).enumerate() {
                    add_products(n, x, factor.reciprocal(k), products);
                }
            },
        );
        self.matrix.resize(n * n, T::zero());
        self.offset.resize(n, T::zero());
        for (j, column) in self.products.chunks_exact(groups).enumerate() {
            let column = column.as_flattened();
            for i in j..n {
                self.matrix[i + n * j] = column[i];
                self.matrix[j + n * i] = column[i];
            }
            self.offset[j] = column[n];
        }
    }

    /// Jᵀ, and τ beside it.
    fn transpose(&mut self, tau: &[T]) {
        let groups = self.groups();
        self.half.clear();
        self.half.resize(self.nv * groups, [T::zero(); GROUP]);
        let rows = self.jacobian.chunks_exact(self.nv.max(1));
        for (i, row) in rows.chain([tau]).enumerate() {
            let own = self.half[i / GROUP..].iter_mut().step_by(groups);
            own.zip(row).for_each(|(own, &x)| own[i % GROUP] = x);
        }
    }

    /// How many groups hold the rows and one more.
    fn groups(&self) -> usize {
        self.count / GROUP + 1
    }

    /// How many there are.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// The entries of J in a row.
    pub(crate) fn row(&self, row: usize) -> &[T] {
        &self.jacobian[self.nv * row..self.nv * (row + 1)]
    }

    /// X with Lᵀ X = Jᵀ, of all rows for each coordinate.
    pub(crate) fn halves(&self) -> impl Iterator<Item = &[T]> {
        let coordinates = self.half.chunks_exact(self.groups());
        coordinates.map(|x| &x.as_flattened()[..self.count])
    }

    /// The forces of the last solution.
    pub(crate) fn forces(&self) -> &[T] {
        &self.forces
    }

    /// `G_ii`.
    pub(crate) fn mobility(&self, row: usize) -> T {
        self.matrix[row * (self.count + 1)]
    }

    /// All rows but so many first ones see another acceleration, by `x` along the coordinate `k`.
    pub(super) fn turn(&mut self, first: usize, k: usize, x: T) {
        let rows = self.jacobian.chunks_exact(self.nv.max(1));
        for (offset, row) in self.offset.iter_mut().zip(rows).skip(first) {
            *offset = row[k].mul_add(x, *offset);
        }
    }

    /// J `a_free` − wanted.
    pub(super) fn subtract_wanted(&mut self) {
        let rows = self.offset.iter_mut().zip(&self.wanted);
        rows.for_each(|(offset, &wanted)| *offset -= wanted);
    }

    /// Finds the forces, from nothing each time: what a step does depends on the state alone, also where forces are not unique.
    pub(super) fn solve(&mut self, law: Law, solver: &mut ConeSolver<T>) -> Certificate {
        self.forces.clear();
        self.forces.resize(self.offset.len(), T::zero());
        let problem = ConeProblem {
            law,
            blocks: &self.blocks,
            friction: &self.friction,
            matrix: &self.matrix,
            regularization: &self.regularization,
            offset: &self.offset,
        };
        solver.solve(&problem, &mut self.forces)
    }

    /// a = M⁻¹ (τ + Jᵀ f)
    pub(super) fn accelerations(&self, factor: &MassMatrixFactor<T>, a: &mut [T]) {
        let coordinates = self.half.chunks_exact(self.groups());
        for (a, x) in a.iter_mut().zip(coordinates) {
            let x = x.as_flattened();
            let pushes = x.iter().zip(&self.forces);
            *a = pushes.fold(x[self.count], |sum, (&x, &f)| x.mul_add(f, sum));
        }
        factor.solve_from_world(a);
    }

    /// The forces of so many first rows.
    pub(super) fn first_forces(&self, rows: usize) -> &[T] {
        &self.forces[..rows]
    }

    /// The forces of so many last rows.
    pub(super) fn last_forces(&self, rows: usize) -> &[T] {
        &self.forces[self.forces.len() - rows..]
    }
}

/// Adds  x xᵀ / d  on and below the diagonal, where x is mostly zeros.
#[inline(always)]
fn add_products<T: Scalar>(
    rows: usize,
    x: &[[T; GROUP]],
    reciprocal: T,
    products: &mut [[T; GROUP]],
) {
    let columns = products.chunks_exact_mut(x.len()).enumerate();
    for (j, column) in columns.take(rows) {
        let x_j = x[j / GROUP][j % GROUP];
        if is_zero(x_j) {
            continue;
        }
        let scaled = x_j * reciprocal;
        let groups = column.iter_mut().zip(x).skip(j / GROUP);
        groups.for_each(|(out, x)| {
            for (out, &x) in out.iter_mut().zip(x) {
                *out = scaled.mul_add(x, *out);
            }
        });
    }
}

/// Whether a number is zero in all lanes, and cannot have derivatives.
#[inline]
fn is_zero<T: Scalar>(x: T) -> bool {
    T::ORDER == 0 && (0..T::LANES).all(|lane| x.value(lane) == 0.0)
}
