//! A point of an interval in tangent coordinates of the interval's first node.
//!
//! ```text
//!   ξ = x ⊖ x₀,   ξ̇ = rate of ξ when x moves at f(x, u)
//! ```
//!
//! On a vector space ξ = x − x₀ and ξ̇ = f. Elsewhere the derivatives in x₀, x and f are by dual numbers.

use nalgebra::{DMatrix, DMatrixView};

use crate::autodiff::{CHUNK, Dual, TangentPoint};
use crate::trajopt::system::{AnySystem, Manifold};

/// Rows of blocks of the Jacobian of a chart.
pub(super) const XI: usize = 0;
pub(super) const RATE: usize = 1;
/// Columns of blocks: derivatives in δx₀, δx, δf.
pub(super) const START: usize = 0;
pub(super) const POINT: usize = 1;
pub(super) const FLOW: usize = 2;

/// ξ and ξ̇ of one point, and their derivatives.
#[derive(Clone, Debug)]
pub(super) struct Chart {
    pub(super) xi: Vec<f64>,
    pub(super) rate: Vec<f64>,
    /// ∂(ξ, ξ̇)/∂(δx₀, δx, δf), 2 `ndx` × 3 `ndx`.
    jacobian: DMatrix<f64>,
}

/// Working memory for derivatives of charts.
pub(super) struct ChartScratch {
    /// (x₀, x), and f beside them.
    point: TangentPoint<Dual<f64, CHUNK>>,
    /// (ξ, ξ̇).
    out: Vec<Dual<f64, CHUNK>>,
}

impl Chart {
    pub(super) fn new(system: &dyn AnySystem) -> Self {
        let ndx = system.ndx();
        let one = DMatrix::identity(ndx, ndx);
        let mut jacobian = DMatrix::zeros(2 * ndx, 3 * ndx);
        // That of a vector space, until others are written over it.
        jacobian.view_mut((0, 0), (ndx, ndx)).copy_from(&-&one);
        jacobian.view_mut((0, ndx), (ndx, ndx)).copy_from(&one);
        jacobian
            .view_mut((ndx, 2 * ndx), (ndx, ndx))
            .copy_from(&one);
        Self {
            xi: vec![0.0; ndx],
            rate: vec![0.0; ndx],
            jacobian,
        }
    }

    /// A block of the Jacobian, `ndx` × `ndx`.
    pub(super) fn block(&self, row: usize, column: usize) -> DMatrixView<'_, f64> {
        let ndx = self.xi.len();
        self.jacobian.view((row * ndx, column * ndx), (ndx, ndx))
    }

    /// ξ and ξ̇ at x, from f there.
    pub(super) fn measure(&mut self, system: &dyn AnySystem, x0: &[f64], x: &[f64], f: &[f64]) {
        system.difference(x0, x, self.xi.as_mut_slice());
        system.chart_rate(&self.xi, f, self.rate.as_mut_slice());
    }

    /// The derivatives there.
    pub(super) fn linearize(
        &mut self,
        system: &dyn AnySystem,
        x0: &[f64],
        x: &[f64],
        f: &[f64],
        scratch: &mut ChartScratch,
    ) {
        if system.is_vector_space() {
            return;
        }
        let (nx, ndx) = (x.len(), f.len());
        let dual: &dyn Manifold<Dual<f64, CHUNK>> = system;
        let states = x0.iter().chain(x).map(|&x| Dual::from(x));
        let zeros = std::iter::repeat_n(Dual::from(0.0), 2 * ndx);
        let rates = f.iter().map(|&f| Dual::from(f));
        scratch.point.set_to(states, zeros.chain(rates));
        scratch.point.jacobian_into(
            |x, dx, out| {
                let (start, end) = out.split_at_mut(nx);
                dual.integrate(&x[..nx], &dx[..ndx], start);
                dual.integrate(&x[nx..], &dx[ndx..], end);
            },
            |x, f, out| {
                let (xi, rate) = out.split_at_mut(ndx);
                dual.difference(&x[..nx], &x[nx..], xi);
                dual.chart_rate(xi, f, rate);
            },
            &mut scratch.out,
            &mut self.jacobian,
        );
    }
}

impl ChartScratch {
    pub(super) fn new(system: &dyn AnySystem) -> Self {
        let (nx, ndx) = (system.nx(), system.ndx());
        Self {
            point: TangentPoint::new(2 * nx, 2 * ndx, ndx),
            out: vec![Dual::from(0.0); 2 * ndx],
        }
    }
}
