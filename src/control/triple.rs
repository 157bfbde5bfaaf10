//! The data of a Riccati equation.

use nalgebra::DMatrix;

/// The data of a Riccati equation, all n × n: the dynamics A, the input term G = B R⁻¹ Bᵀ and the weight H.
#[derive(Clone, Debug)]
pub(super) struct Triple {
    pub(super) a: DMatrix<f64>,
    pub(super) g: DMatrix<f64>,
    pub(super) h: DMatrix<f64>,
}
