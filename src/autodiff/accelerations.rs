//! Derivatives of forward dynamics by the implicit function theorem.
//!
//! The acceleration solves  ID(q, v, a) = τ. So  M δa = δτ − ∂ID/∂q δq − ∂ID/∂v δv: the derivatives of inverse dynamics and one
//! factorisation of M, which is among them, replace a sweep through forward dynamics for each direction.
//!
//! # References
//! [Carpentier, Mansard 2018].

use aligned_vec::{AVec, ConstAlign};
use nalgebra::DMatrix;

use super::carry::Entries;
use super::elimination::{InverseDynamicsDerivativesScratch, add_derivatives};
use crate::dynamics::{AbaScratch, MassMatrixFactor, forward_dynamics_into};
use crate::model::Model;
use crate::scalar::Lanes;
use crate::spatial::Force;

/// Right-hand sides that are solved together: some vectors of the widest kind, because each step waits for the one before it.
pub(crate) const BLOCK: usize = 16;

/// Bytes, of all CPUs of today or a multiple of theirs.
const CACHE_LINE: usize = 64;

/// Columns of as many numbers as there are rows, in blocks of lanes that are worked on at once.
#[derive(Clone, Debug)]
pub(crate) struct Blocks {
    rows: usize,
    /// Block after block, each from the first row to the last. No vector lies across two cache lines, which costs a tenth.
    lanes: AVec<Lanes<BLOCK>, ConstAlign<CACHE_LINE>>,
}

impl Blocks {
    pub(crate) fn new(rows: usize, columns: usize) -> Self {
        let mut out = Self {
            rows,
            lanes: AVec::new(CACHE_LINE),
        };
        out.resize(rows, columns);
        out
    }

    pub(crate) fn rows(&self) -> usize {
        self.rows
    }

    pub(crate) fn clear(&mut self) {
        self.lanes.fill(Lanes([0.0; BLOCK]));
    }

    /// Zeros in so many rows and columns; allocates if there have never been as many.
    pub(crate) fn resize(&mut self, rows: usize, columns: usize) {
        self.rows = rows;
        self.lanes.clear();
        let size = rows * columns.div_ceil(BLOCK);
        self.lanes.resize(size, Lanes([0.0; BLOCK]));
    }

    #[inline(always)]
    pub(crate) fn at(&mut self, row: usize, column: usize) -> &mut f64 {
        entry(&mut self.lanes, self.rows, row, column)
    }

    #[inline(always)]
    fn view(&mut self) -> View<'_> {
        View {
            rows: self.rows,
            lanes: &mut self.lanes,
        }
    }

    pub(crate) fn column(&self, column: usize) -> impl Iterator<Item = f64> {
        let first = self.rows * (column / BLOCK);
        let block = &self.lanes[first..first + self.rows];
        block.iter().map(move |row| row.0[column % BLOCK])
    }

    pub(crate) fn blocks(&self) -> impl Iterator<Item = &[Lanes<BLOCK>]> {
        self.lanes.chunks_exact(self.rows.max(1))
    }

    pub(crate) fn solve(&mut self, factor: &MassMatrixFactor<f64>) {
        for block in self.blocks_mut() {
            factor.solve(block);
        }
    }

    pub(crate) fn blocks_mut(&mut self) -> impl Iterator<Item = &mut [Lanes<BLOCK>]> {
        self.lanes.chunks_exact_mut(self.rows.max(1))
    }
}

/// Derivatives in q from the first column on, in v from column `nv` on.
impl Entries for Blocks {
    #[inline(always)]
    fn add(&mut self, row: usize, column: usize, by_q: f64, by_v: f64) {
        self.view().add(row, column, by_q, by_v);
    }
}

/// [`Blocks`] whose place is known once and for all.
struct View<'a> {
    rows: usize,
    lanes: &'a mut [Lanes<BLOCK>],
}

impl Entries for View<'_> {
    #[inline(always)]
    fn add(&mut self, row: usize, column: usize, by_q: f64, by_v: f64) {
        // As many rows as directions in q: those in v come next.
        *entry(self.lanes, self.rows, row, column) += by_q;
        *entry(self.lanes, self.rows, row, self.rows + column) += by_v;
    }
}

#[inline(always)]
fn entry(lanes: &mut [Lanes<BLOCK>], rows: usize, row: usize, column: usize) -> &mut f64 {
    &mut lanes[rows * (column / BLOCK) + row].0[column % BLOCK]
}

/// Derivatives of what the acceleration balances, then of −a, in q, v and further directions side by side.
#[derive(Clone, Debug)]
pub(crate) struct AccelerationDerivatives {
    inverse: InverseDynamicsDerivativesScratch,
    pub(crate) columns: Blocks,
    mass: DMatrix<f64>,
    factor: MassMatrixFactor<f64>,
}

impl AccelerationDerivatives {
    /// Memory for a model and a number of further directions.
    pub(crate) fn new(model: &Model, further: usize) -> Self {
        let nv = model.nv();
        Self {
            inverse: InverseDynamicsDerivativesScratch::new(model),
            columns: Blocks::new(nv, 2 * nv + further),
            mass: DMatrix::zeros(nv, nv),
            factor: MassMatrixFactor::new(model, &DMatrix::identity(nv, nv)),
        }
    }

    /// Turns the columns of −∂τ/∂x into those of what the acceleration `a` balances, −∂τ/∂x + ∂ID/∂x, and finds M.
    pub(crate) fn balance(
        &mut self,
        model: &Model,
        motion: (&[f64], &[f64], &[f64]),
        external: &[Force<f64>],
    ) {
        let (mut columns, mass) = (self.columns.view(), &mut self.mass);
        add_derivatives(
            model,
            motion,
            external,
            &mut self.inverse,
            &mut columns,
            mass,
        );
    }

    /// Turns them into −∂a/∂x, with what coordinates resist with beside M; none if empty.
    pub(crate) fn solve(&mut self, resistance: impl IntoIterator<Item = f64>) {
        for (k, resistance) in resistance.into_iter().enumerate() {
            self.mass[(k, k)] += resistance;
        }
        self.factor.refactor(&self.mass);
        self.columns.solve(&self.factor);
    }
}

/// Derivatives of v̇ = FD(q, v, τ).
#[derive(Clone, Debug, PartialEq)]
pub struct ForwardDynamicsDerivatives {
    /// ∂v̇/∂q in tangent directions of q, `nv` × `nv`.
    pub dq: DMatrix<f64>,
    /// ∂v̇/∂v, `nv` × `nv`.
    pub dv: DMatrix<f64>,
    /// ∂v̇/∂τ = M(q)⁻¹, `nv` × `nv`.
    pub dtau: DMatrix<f64>,
}

impl ForwardDynamicsDerivatives {
    /// Memory for a model.
    pub fn zeros(model: &Model) -> Self {
        let zeros = DMatrix::zeros(model.nv(), model.nv());
        Self {
            dq: zeros.clone(),
            dv: zeros.clone(),
            dtau: zeros,
        }
    }
}

/// Working memory of [`forward_dynamics_derivatives_into`].
#[derive(Clone, Debug)]
pub struct ForwardDynamicsDerivativesScratch {
    aba: AbaScratch<f64>,
    a: Vec<f64>,
    derivatives: AccelerationDerivatives,
}

impl ForwardDynamicsDerivativesScratch {
    /// Memory for a model.
    pub fn new(model: &Model) -> Self {
        Self {
            aba: AbaScratch::new(model),
            a: vec![0.0; model.nv()],
            derivatives: AccelerationDerivatives::new(model, model.nv()),
        }
    }
}

/// Computes the derivatives of [`forward_dynamics`](crate::dynamics::forward_dynamics) in q (tangent), v and τ, exact to rounding. Allocates.
///
/// By the implicit function theorem, at v̇ = FD(q, v, τ):  ∂FD = −M⁻¹ ∂ID,  ∂FD/∂τ = M⁻¹.
///
/// * `q` – configuration, length `nq`
/// * `v` – velocity in tangent coordinates, length `nv` (rad/s or m/s)
/// * `tau` – joint forces, length `nv` (N·m or N)
///
/// # Panics
/// If a slice has the wrong length.
///
/// # Examples
/// ```
/// use dualbody::{dynamics::forward_dynamics_derivatives, model::samples};
///
/// // v̇ = 3 τ / (m l²) − (3 g / 2 l) sin q with 1 kg and 1 m
/// let d = forward_dynamics_derivatives(&samples::pendulum(), &[0.0], &[0.0], &[0.0]);
/// assert!((d.dq[(0, 0)] + 1.5 * 9.81).abs() < 1e-12);
/// assert!((d.dtau[(0, 0)] - 3.0).abs() < 1e-14);
/// ```
///
/// # References
/// [Carpentier, Mansard 2018].
pub fn forward_dynamics_derivatives(
    model: &Model,
    q: &[f64],
    v: &[f64],
    tau: &[f64],
) -> ForwardDynamicsDerivatives {
    let mut out = ForwardDynamicsDerivatives::zeros(model);
    let mut scratch = ForwardDynamicsDerivativesScratch::new(model);
    forward_dynamics_derivatives_into(model, q, v, tau, &[], &mut scratch, &mut out);
    out
}

/// [`forward_dynamics_derivatives`] with external forces and without allocation.
///
/// * `external` – force on each body in its body frame, which moves with the body, length `n_bodies`; empty for none
///
/// # Panics
/// If a slice, the scratch or the output has the wrong size.
pub fn forward_dynamics_derivatives_into(
    model: &Model,
    q: &[f64],
    v: &[f64],
    tau: &[f64],
    external: &[Force<f64>],
    scratch: &mut ForwardDynamicsDerivativesScratch,
    out: &mut ForwardDynamicsDerivatives,
) {
    let (s, nv) = (&mut scratch.derivatives, model.nv());
    forward_dynamics_into(model, q, v, tau, external, &mut scratch.aba, &mut scratch.a);
    s.columns.clear();
    for k in 0..nv {
        *s.columns.at(k, 2 * nv + k) = -1.0;
    }
    s.balance(model, (q, v, &scratch.a), external);
    s.solve([]);
    for (first, m) in [(0, &mut out.dq), (nv, &mut out.dv), (2 * nv, &mut out.dtau)] {
        assert_eq!(m.shape(), (nv, nv), "the derivatives are nv × nv");
        for (k, mut column) in m.column_iter_mut().enumerate() {
            for (out, minus_a) in column.iter_mut().zip(s.columns.column(first + k)) {
                *out = -minus_a;
            }
        }
    }
}
