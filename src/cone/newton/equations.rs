//! The equations of a unit on the piece of its law that holds, with their derivatives.

use crate::cone::Law;
use crate::cone::jacobian::{EquationJacobian, Square, jacobian_of};
use crate::cone::law::{
    Piece, equations, piece_of_cone, piece_of_interval, piece_of_moment, piece_of_ray,
};
use crate::cone::system::{Kind, Unit, UnitState};
use crate::scalar::{Scalar, each};

/// The equations of a unit at the last force and velocity.
#[derive(Clone, Copy, Debug)]
pub(in crate::cone) struct UnitEquations {
    pub(in crate::cone) piece: Piece,
    pub(in crate::cone) e: [f64; 3],
    /// Up to date after [`Newton::assemble`](super::Newton::assemble).
    pub(in crate::cone) jacobian: EquationJacobian,
    /// The piece of which it is.
    linearized: Piece,
    /// Scale factors that bring each equation to size 1.
    pub(in crate::cone) weight: [f64; 3],
}

impl UnitEquations {
    pub(super) const NONE: Self = Self {
        piece: Piece::Separated,
        e: [0.0; 3],
        jacobian: EquationJacobian {
            f: [[0.0; 3]; 3],
            y: [[0.0; 3]; 3],
            mu: [0.0; 3],
        },
        linearized: Piece::PathOfRay,
        weight: [1.0; 3],
    };

    /// The piece that holds, and its equations.
    #[inline(always)]
    pub(super) fn evaluate(&mut self, law: Law, unit: &Unit, at: UnitState, kappa: f64) {
        let UnitState { f, y } = at;
        self.piece = match (unit.kind, kappa > 0.0) {
            (Kind::Row, _) if unit.absent => Piece::Separated,
            (Kind::Row, _) => Piece::Stick,
            (Kind::Ray, false) => piece_of_ray(f[0], y[0]),
            (Kind::Ray, true) => Piece::PathOfRay,
            (Kind::Interval, false) => piece_of_interval(f[0], y[0], unit.mu),
            (Kind::Interval, true) => Piece::PathOfInterval,
            (Kind::Cone, false) => piece_of_cone(law, f, y, unit.mu),
            (Kind::Cone, true) if unit.mu > 0.0 => Piece::PathOfCone(law),
            (Kind::Cone, true) => Piece::PathOfRay,
            (Kind::Spin | Kind::Roll, _) => piece_of_moment(f, y, unit.mu),
        };
        self.e = equations(self.piece, f, y, unit.mu, kappa);
        self.weight = [1.0; 3];
        if self.piece.is_smoothed() {
            self.linearize(unit, at, kappa);
            self.equilibrate(unit.rows());
        }
    }

    pub(super) fn linearize(&mut self, unit: &Unit, at: UnitState, kappa: f64) {
        self.linearized = self.piece;
        self.jacobian = jacobian_of(self.piece, at.f, at.y, unit.mu, kappa);
    }

    /// Whether the derivatives are up to date: those of smoothed laws are found with the equations, and those of planes are the same everywhere.
    pub(super) fn is_linearized(&self) -> bool {
        self.piece.is_smoothed() || self.piece.is_flat() && self.linearized == self.piece
    }

    fn equilibrate(&mut self, rows: usize) {
        for i in 0..rows {
            let entries = self.jacobian.f[i].iter().chain(&self.jacobian.y[i]);
            let size = entries.fold(0.0_f64, |size, x| size.max(x.abs()));
            let weight = if size > 0.0 { 1.0 / size } else { 1.0 };
            self.weight[i] = weight;
            self.e[i] *= weight;
            self.jacobian.mu[i] *= weight;
            for j in 0..3 {
                self.jacobian.f[i][j] *= weight;
                self.jacobian.y[i][j] *= weight;
            }
        }
    }
}

/// A x.
pub(in crate::cone) fn product<T: Scalar>(a: &Square<T>, x: [T; 3]) -> [T; 3] {
    each(|i| a[i][0] * x[0] + a[i][1] * x[1] + a[i][2] * x[2])
}
