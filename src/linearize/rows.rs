//! How the rows of a solver, and through its forces the accelerations, change.
//!
//! The acceleration a and the forces f obey
//!
//! > ID(q, v, a) = τ + Jᵀ f,  and the laws for  y = J ã − w + R f,
//!
//! where ã is a with the turning of axes that carry linear velocities, and w and R are what the laws ask. At fixed f, the first says how a
//! changes, and with it how y does; then the solver says how the forces follow, and the first how a does: the implicit function theorem
//! twice.
//!
//! It is done by halves, M = Lᵀ D L, where J keeps its zeros: with Lᵀ X = Jᵀ and Lᵀ Z = `δID` − δτ − δJᵀ f,  J δa = −Xᵀ D⁻¹ Z at fixed f,
//! and −δa = L⁻¹ D⁻¹ (Z − X δf).

use crate::autodiff::{BLOCK, Blocks, Dual};
use crate::joint::MAX_NV;
use crate::model::Model;
use crate::model::manifold::v_range;
use crate::scalar::{GROUP, Lanes, Scalar};
use crate::sim::{ConstrainedScratch, SolverRows};

/// ∂y of all rows at fixed forces and accelerations, then at fixed forces, then ∂f.
#[derive(Clone, Debug)]
pub(super) struct RowColumns {
    pub(super) columns: Blocks,
    /// ã.
    pub(super) seen: Vec<f64>,
    memory: Vec<Lanes<BLOCK>>,
}

impl RowColumns {
    /// Memory for so many rows and columns at most.
    pub(super) fn new(model: &Model, rows: usize, columns: usize) -> Self {
        Self {
            columns: Blocks::new(rows, columns),
            seen: vec![0.0; model.nv()],
            memory: Vec::with_capacity(2 * rows),
        }
    }

    /// ã, and what its turning changes in y of all rows but so many first ones, which see a; the rest of ∂y is to be added.
    pub(super) fn start(
        &mut self,
        model: &Model,
        (v, a): (&[f64], &[f64]),
        (rows, first): (&SolverRows<f64>, usize),
        columns: usize,
    ) {
        self.columns.resize(rows.count(), columns);
        self.seen.copy_from_slice(a);
        for body in model.independent() {
            let own = v_range(body);
            let mut rates = [Dual::<MAX_NV>::from(0.0); MAX_NV];
            for (k, &v) in v[own.clone()].iter().enumerate() {
                rates[k] = Dual::variable(v, k);
            }
            body.joint.turning(&rates[..own.len()], |k, x| {
                self.seen[own.start + k] += x.re;
                for row in first..rows.count() {
                    let entry = rows.row(row)[own.start + k];
                    for (l, slope) in own.clone().zip(x.eps) {
                        *self.columns.at(row, model.nv() + l) += entry * slope;
                    }
                }
            });
        }
    }

    /// From what the acceleration balances at fixed forces to −∂a, and ∂f.
    pub(super) fn solve(
        &mut self,
        constrained: &mut ConstrainedScratch<f64>,
        columns: &mut Blocks,
    ) {
        let (halves, factor) = (constrained.rows(), constrained.factor());
        if halves.count() == 0 {
            return columns.solve(factor);
        }
        Lanes::<BLOCK>::vectorized(
            #[inline(always)]
            || {
                for (z, y) in columns.blocks_mut().zip(self.columns.blocks_mut()) {
                    factor.solve_from_tips(z);
                    for (group, y) in halves.halves().zip(y.chunks_mut(GROUP)) {
                        for (k, (z, x)) in z.iter().zip(group).enumerate() {
                            subtract_product(*z * factor.reciprocal(k), x, y);
                        }
                    }
                }
            },
        );
        let solver = constrained.solver_mut();
        solver.respond(self.columns.blocks_mut(), &mut self.memory);
        let (halves, factor) = (constrained.rows(), constrained.factor());
        Lanes::<BLOCK>::vectorized(
            #[inline(always)]
            || {
                for (z, f) in columns.blocks_mut().zip(self.columns.blocks()) {
                    for (group, f) in halves.halves().zip(f.chunks(GROUP)) {
                        let coordinates = z.iter_mut().zip(group);
                        coordinates.for_each(|(z, x)| *z = minus_product(*z, f, x));
                    }
                    factor.solve_from_world(z);
                }
            },
        );
    }
}

/// y −= z x, where x is mostly zeros.
#[inline(always)]
fn subtract_product(z: Lanes<BLOCK>, x: &[f64], y: &mut [Lanes<BLOCK>]) {
    for (y, &x) in y.iter_mut().zip(x) {
        if x != 0.0 {
            *y = z.mul_add_real(-x, *y);
        }
    }
}

/// z − f x, where x is mostly zeros.
#[inline(always)]
fn minus_product(mut z: Lanes<BLOCK>, f: &[Lanes<BLOCK>], x: &[f64]) -> Lanes<BLOCK> {
    for (f, &x) in f.iter().zip(x) {
        if x != 0.0 {
            z = f.mul_add_real(-x, z);
        }
    }
    z
}
