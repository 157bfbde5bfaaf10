//! Newton's matrix and step of a system with blocks, in the coordinates of the bodies.

use super::{Newton, product};
use crate::cone::blocks::inverse;
use crate::cone::jacobian::Square;
use crate::cone::law::Piece;
use crate::scalar::{MapEach, each, from_each};

impl Newton {
    /// Factorises the matrix of the bodies for the pieces that hold.
    pub(super) fn factorize_blocks(&mut self, ridge: f64) {
        self.linearize();
        self.inverses.clear();
        for (unit, own) in self.system.units.iter().zip(&self.equations) {
            let (mut b, jacobian) = (own.jacobian.f, &own.jacobian.y);
            for j in 0..unit.rows() {
                let compliance = self.blocks.diagonal[unit.row + j] + ridge;
                (0..unit.rows()).for_each(|i| b[i][j] += jacobian[i][j] * compliance);
            }
            self.inverses.push(inverse(&b, unit.rows()));
        }
        let (equations, inverses) = (&self.equations, &self.inverses);
        self.blocks.factorize(&self.system.units, |k| {
            let own = &equations[k];
            let has_force = own.piece != Piece::Separated;
            has_force.then(|| square_product(&inverses[k], &own.jacobian.y))
        });
    }

    /// δf = −B⁻¹ (e + `E_y` Xᵀ δz)  with  (1 + X B⁻¹ `E_y` Xᵀ) δz = −X B⁻¹ e.
    pub(super) fn step_by_blocks(&mut self) {
        let (units, blocks) = (&self.system.units, &self.blocks);
        let all = || units.iter().zip(self.equations.iter().zip(&self.inverses));
        self.step.clear();
        self.step.resize(blocks.columns.n_coordinates(), 0.0);
        for (unit, (own, inverse)) in all() {
            let change = product(inverse, own.e).map_each(|x| -x);
            blocks.add_unit(unit, change, &mut self.step);
        }
        blocks.solve(&mut self.step);
        for (unit, (own, inverse)) in all() {
            let change = product(&own.jacobian.y, blocks.columns.along(unit, &self.step));
            let change = product(inverse, each(|i| own.e[i] + change[i]));
            for i in 0..unit.rows() {
                self.f[unit.row + i] -= change[i];
            }
        }
    }
}

/// A B.
fn square_product(a: &Square, b: &Square) -> Square {
    let entry = |i: usize, j: usize| a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
    from_each(|i| from_each(|j| entry(i, j)))
}
