//! Derivatives of the part of velocity forces that belongs to the middle of a step.
//!
//! A step whose velocity forces are those of its middle subtracts G = s ∂c/∂v a₀ from its forces, with the a₀ that it would have under the
//! forces λ₀ of kinematic constraints alone,
//!
//! > ID(q, v, a₀) + G − τ − Jᵀ λ₀ = 0,  y₀ = J ã₀ + rest = 0.
//!
//! So  δG = ∂G δx + s ∂c/∂v δa₀,  where δa₀ and δλ₀ solve the same linear equations with −∂ of both at fixed a₀ and λ₀ on their right side. As
//! c is quadratic in v, G = ½ (c(v + s a₀) − c(v − s a₀)): derivatives of inverse dynamics at two velocities are all that is needed. The rows
//! that constraints have in the step itself look ahead along ã₀, and change with it.

use nalgebra::DMatrix;

use crate::dynamics::{
    At, Blocks, Calls, Entries, Gyroscopic, InverseDynamicsDerivativesScratch, add_derivatives,
    each_left_out,
};
use crate::scalar::{BLOCK, Differentiable, Dual, Linear, Pack, Scalar, is_nothing};
use crate::sim::{
    AllSlopes, Bias, ForceColumns, Held, JacobianMemory, JacobianSink, Moment, RowColumns,
    Simulator, SlopePoint, TermSlopes, Terms, add_turning,
};

/// Working memory of [`find`](Self::find).
#[derive(Clone, Debug)]
pub(in crate::sim::integrators) struct MidpointColumns<T: Differentiable> {
    /// Derivatives −∂τ at a₀, then ∂ID − ∂τ at fixed a₀, then −δa₀, then δG.
    pub(in crate::sim::integrators) forces: ForceColumns<T>,
    /// ∂G at fixed a₀.
    direct: Blocks<T>,
    inverse: InverseDynamicsDerivativesScratch<T>,
    /// ∂y of the constraints that hold a₀, at fixed a₀, then δλ₀.
    rows: RowColumns<T>,
    /// −δa₀, with constraints.
    minus_a: Blocks<T>,
    mass: DMatrix<T>,
    v: Vec<T>,
    v_moved: Vec<Dual<T, 1>>,
    at_rest: Vec<T>,
    left_out: Vec<bool>,
    memory: Vec<Pack<T, BLOCK>>,
}

impl<T: Differentiable> MidpointColumns<T> {
    /// Memory for a simulator.
    pub(in crate::sim::integrators) fn new(simulator: &Simulator) -> Self {
        let (model, nv) = (simulator.model(), simulator.model().nv());
        let width = simulator.n_tangent() + simulator.nu();
        let held = simulator.held_rows();
        let mut left_out = vec![false; nv];
        each_left_out(model, |k| left_out[k] = true);
        Self {
            forces: ForceColumns::new(simulator, Calls::Many),
            direct: Blocks::new(nv, width),
            inverse: InverseDynamicsDerivativesScratch::new(model),
            rows: RowColumns::new(model, held, width),
            minus_a: Blocks::new(nv, if held > 0 { width } else { 0 }),
            mass: DMatrix::zeros(nv, nv),
            v: vec![T::zero(); nv],
            v_moved: vec![Dual::from(0.0); nv],
            at_rest: vec![T::zero(); nv],
            left_out,
            memory: vec![Pack([T::zero(); BLOCK]); nv],
        }
    }

    /// Finds δG. The forces beside velocity forces are those without rows and joint limits, and those of constraints.
    pub(in crate::sim::integrators) fn find(
        &mut self,
        at: &Moment<'_, f64, T>,
        gyroscopic: &Gyroscopic<T>,
        found: &Terms<T>,
        terms: &mut AllSlopes<T>,
        memory: &mut JacobianMemory<T>,
    ) {
        let (simulator, q, v) = (at.simulator, at.q(), at.v());
        let (a, bilateral) = (&gyroscopic.a[..], &gyroscopic.bilateral);
        let width = simulator.n_tangent() + simulator.nu();
        let point = SlopePoint {
            moment: at,
            a,
            is_free: true,
            balance: None,
            held: (simulator.held_rows() > 0).then_some(Held {
                forces: &bilateral.forces,
                bias: Bias::Start,
            }),
        };
        self.forces.clear();
        self.rows
            .start(simulator.model(), v, a, bilateral.jacobian(), width);
        let mut sink = JacobianSink::new(&point, &mut self.forces, &mut self.rows, memory);
        terms.emit_forces(&point, found, &mut sink);
        terms.emit_rows(&point, found, &mut sink);
        let ForceColumns {
            acceleration,
            bodies,
            ..
        } = &mut self.forces;
        acceleration.balance(simulator.model(), &At { q, v, a }, bodies);
        self.differentiate(at, gyroscopic);
        self.follow(at, gyroscopic, width);
    }

    /// ã₀ of the last point, under which constraints look ahead.
    pub(in crate::sim::integrators) fn seen(&self) -> &[T] {
        &self.rows.seen
    }

    /// δG, column after column.
    pub(in crate::sim::integrators) fn change(&self) -> &Blocks<T> {
        &self.forces.acceleration.columns
    }

    /// Adds what constraints that look ahead see of δã₀: ∂y = ∂y/∂v⁺ Δt δã₀.
    ///
    /// * `by_next_v` – ∂y/∂v⁺, row after row
    pub(in crate::sim::integrators) fn look_ahead(
        &mut self,
        at: &Moment<'_, f64, T>,
        by_next_v: &mut [T],
        rows: &mut Blocks<T>,
    ) {
        let (model, dt) = (at.model(), at.dt());
        by_next_v.iter_mut().for_each(|x| *x = *x * dt);
        add_turning(model, at.v(), by_next_v, rows);
        for (y, minus_a) in rows.blocks_mut().zip(self.minus_a.blocks()) {
            for (y, slopes) in y.iter_mut().zip(by_next_v.chunks_exact(model.nv())) {
                for (&x, &slope) in minus_a.iter().zip(slopes) {
                    *y = x.times_plus(-slope, *y);
                }
            }
        }
    }

    /// ∂G at fixed a₀: by the velocity forces, and by how much of them is that of the middle.
    fn differentiate(&mut self, at: &Moment<'_, f64, T>, gyroscopic: &Gyroscopic<T>) {
        let (model, s) = (at.model(), half_step(at));
        self.direct.clear();
        for side in [1.0, -1.0] {
            for (k, v) in self.v.iter_mut().enumerate() {
                let moved = if self.left_out[k] {
                    T::zero()
                } else {
                    s * gyroscopic.a[k]
                };
                *v = gyroscopic.v[k] + moved * side;
            }
            let mut out = Weighted {
                columns: &mut self.direct,
                weight: 0.5 * side,
                left_out: &self.left_out,
            };
            let motion = At {
                q: at.q(),
                v: &self.v,
                a: &self.at_rest,
            };
            add_derivatives(
                model,
                &motion,
                &[],
                &mut self.inverse,
                &mut out,
                &mut self.mass,
            );
        }
        self.add_half_step(at, gyroscopic);
    }

    /// Adds the derivative of G in the half step s, which depends on the velocity of the fastest coordinate alone, if on any.
    fn add_half_step(&mut self, at: &Moment<'_, f64, T>, gyroscopic: &Gyroscopic<T>) {
        let (simulator, v) = (at.simulator, at.v());
        if simulator.always_in_the_middle() {
            return;
        }
        let lifted = self.v_moved.iter_mut().zip(v);
        lifted.for_each(|(moved, &v)| *moved = Dual::constant_of(v));
        for k in simulator.turning() {
            // One by one, as each lane has a fastest coordinate of its own.
            self.v_moved[k].eps[0] = T::one();
            let half_step = simulator.half_step(&self.v_moved);
            self.v_moved[k].eps[0] = T::zero();
            let slope = half_step.map_or(T::zero(), |s| s.eps[0]);
            if !is_nothing(&slope) {
                for (row, &change) in gyroscopic.change.iter().enumerate() {
                    *self.direct.at(row, v.len() + k) += change * slope;
                }
            }
        }
    }

    /// δG = ∂G + s ∂c/∂v δa₀ with −δa₀ = (M + s ∂c/∂v)⁻¹ (∂ID − ∂τ + ∂G), held by constraints.
    fn follow(&mut self, at: &Moment<'_, f64, T>, gyroscopic: &Gyroscopic<T>, width: usize) {
        let (s, product) = (half_step(at), &mut self.memory);
        let held = gyroscopic.bilateral.count() > 0;
        if held {
            self.minus_a.resize(gyroscopic.a.len(), width);
        }
        let mut rows = self.rows.columns.blocks_mut();
        let mut minus_a = self.minus_a.blocks_mut();
        let columns = &mut self.forces.acceleration.columns;
        for (x, direct) in columns.blocks_mut().zip(self.direct.blocks()) {
            x.iter_mut()
                .zip(direct)
                .for_each(|(x, &direct)| *x += direct);
            gyroscopic.factor.solve(x);
            if let Some((y, minus_a)) = rows.next().zip(minus_a.next()).filter(|_| held) {
                gyroscopic.bilateral.solve(x, y);
                minus_a.copy_from_slice(x);
            }
            product.copy_from_slice(direct);
            for (column, x) in gyroscopic.slope.column_iter().zip(&*x) {
                for (product, &slope) in product.iter_mut().zip(column.iter()) {
                    if !is_nothing(&slope) {
                        *product = x.times_plus(-s * slope, *product);
                    }
                }
            }
            x.copy_from_slice(product);
        }
    }
}

/// By how much of a₀ the velocity is that of the middle, s.
fn half_step<T: Scalar>(at: &Moment<'_, f64, T>) -> T {
    at.half_step.unwrap_or(T::zero())
}

/// Columns to which derivatives are added with a weight; those by linear velocities that are left out are zero.
struct Weighted<'a, T> {
    columns: &'a mut Blocks<T>,
    weight: f64,
    left_out: &'a [bool],
}

impl<T: Scalar> Entries<T> for Weighted<'_, T> {
    #[inline(always)]
    fn add(&mut self, row: usize, column: usize, by_q: T, by_v: T) {
        let left_out = self.left_out[column];
        let by_v = if left_out { T::zero() } else { by_v };
        self.columns
            .add(row, column, by_q * self.weight, by_v * self.weight);
    }
}
