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

use super::ahead::Ahead;
use super::gyroscopic::{Gyroscopic, each_left_out, each_spin};
use super::{HalfStep, each_derivative, half_step};
use crate::dynamics::{At, Blocks, Calls, InverseDynamicsDerivativesScratch, add_derivatives};
use crate::model::Model;
use crate::nested::IntoNested;
use crate::scalar::{BLOCK, Differentiable, Dual, Linear, Pack, is_nothing};
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::integrators::balance::BalanceColumns;
use crate::sim::simulator::Simulator;
use crate::sim::terms::{
    Acting, AllDerivatives, DerivativePoint, JacobianMemory, JacobianSink, RowColumns,
    TermDerivatives, Terms, add_turning,
};

/// Working memory of [`find`](Self::find).
#[derive(Clone, Debug)]
pub(crate) struct Columns<T: Differentiable> {
    /// Derivatives −∂τ at a₀, then ∂ID − ∂τ at fixed a₀, then −δa₀, then δG; ∂y of the constraints that hold a₀, at fixed a₀, then δλ₀.
    balance: BalanceColumns<T>,
    /// `None` without constraints.
    ahead: Option<Box<AheadColumns<T>>>,
    /// ∂G at fixed a₀.
    direct: Blocks<T>,
    inverse: InverseDynamicsDerivativesScratch<T>,
    mass: DMatrix<T>,
    v: Vec<T>,
    fastest: Vec<Dual<T, 1>>,
    at_rest: Vec<T>,
    memory: Vec<Pack<T, BLOCK>>,
}

/// Dependence of constraints on the velocity after the step.
#[derive(Clone, Debug)]
struct AheadColumns<T: Differentiable> {
    point: Ahead<T>,
    /// Their part of ∂y, in q and v⁺.
    rows: RowColumns<T>,
    /// That in v⁺ alone, row by row, times Δt: in ã₀.
    by_seen: Vec<T>,
    /// −δa₀.
    minus_a: Blocks<T>,
}

impl<T: Differentiable> AheadColumns<T> {
    fn new(simulator: &Simulator) -> Box<Self> {
        let (model, rows) = (simulator.model(), simulator.bilateral_rows());
        let width = simulator.n_motion() + simulator.nu();
        Box::new(Self {
            point: Ahead::new(simulator),
            rows: RowColumns::new(model, rows, width),
            by_seen: vec![T::zero(); rows * model.nv()],
            minus_a: Blocks::new(model.nv(), width),
        })
    }

    /// Adds ∂y = ∂y/∂q δq + ∂y/∂v⁺ (δv + Δt δã₀).
    fn add_to(&mut self, at: &EvaluationPoint<'_, f64, T>, out: &mut Blocks<T>) {
        let (model, nv) = (at.model(), at.model().nv());
        let width = nv.max(1);
        for (row, by_seen) in self.by_seen.chunks_exact_mut(width).enumerate() {
            for (k, by_seen) in by_seen.iter_mut().enumerate() {
                let by_v = *self.rows.columns.at(row, nv + k);
                *out.at(row, k) += *self.rows.columns.at(row, k);
                *out.at(row, nv + k) += by_v;
                *by_seen = by_v * at.dt();
            }
        }
        add_turning(model, at.v(), &self.by_seen, out);
        for (y, minus_a) in out.blocks_mut().zip(self.minus_a.blocks()) {
            for (y, slopes) in y.iter_mut().zip(self.by_seen.chunks_exact(width)) {
                for (&x, &slope) in minus_a.iter().zip(slopes) {
                    *y = x.times_plus(-slope, *y);
                }
            }
        }
    }
}

impl<T: Differentiable> Columns<T> {
    /// Makes memory for a simulator.
    pub(crate) fn new(simulator: &Simulator) -> Box<Self> {
        let (model, nv) = (simulator.model(), simulator.model().nv());
        let (width, held) = (
            simulator.n_motion() + simulator.nu(),
            simulator.bilateral_rows(),
        );
        Box::new(Self {
            balance: BalanceColumns::new(simulator, held, Calls::Many),
            ahead: (held > 0).then(|| AheadColumns::new(simulator)),
            direct: Blocks::new(nv, width),
            inverse: InverseDynamicsDerivativesScratch::new(model),
            mass: DMatrix::zeros(nv, nv),
            v: vec![T::zero(); nv],
            fastest: vec![Dual::from(0.0); nv],
            at_rest: vec![T::zero(); nv],
            memory: vec![Pack([T::zero(); BLOCK]); nv],
        })
    }

    /// Finds δG.
    pub(crate) fn find(
        &mut self,
        at: &EvaluationPoint<'_, f64, T>,
        half_step: &HalfStep<T>,
        found: &Terms<T>,
        terms: &mut AllDerivatives<T>,
        memory: &mut JacobianMemory<T>,
    ) {
        let gyroscopic = &half_step.gyroscopic;
        let point = DerivativePoint {
            point: at,
            a: &gyroscopic.a,
            acting: Acting::Start(&gyroscopic.bilateral.forces),
        };
        let jacobian = Some(gyroscopic.bilateral.jacobian());
        (self.balance).find(&point, jacobian, found, terms, memory);
        self.look_ahead(at, found, terms, memory);
        self.differentiate(at, gyroscopic);
        self.follow(at, gyroscopic);
    }

    /// Finds what constraints see of the velocity after the step.
    fn look_ahead(
        &mut self,
        at: &EvaluationPoint<'_, f64, T>,
        found: &Terms<T>,
        terms: &mut AllDerivatives<T>,
        memory: &mut JacobianMemory<T>,
    ) {
        let BalanceColumns { forces, rows } = &mut self.balance;
        let Some(ahead) = &mut self.ahead else { return };
        let width = at.simulator.n_motion() + at.simulator.nu();
        ahead
            .rows
            .columns
            .resize(at.simulator.bilateral_rows(), width);
        let point = DerivativePoint {
            point: &ahead.point.point(at, &rows.seen),
            a: &self.at_rest,
            acting: Acting::Ahead,
        };
        let mut sink = JacobianSink::new(&point, forces, &mut ahead.rows, memory);
        terms.emit_rows(&point, found, &mut sink);
    }

    /// Adds δG to the derivatives of the balance of forces, and the dependence on the velocity after the step to ∂y of constraints.
    pub(crate) fn add_to(
        &mut self,
        at: &EvaluationPoint<'_, f64, T>,
        forces: &mut Blocks<T>,
        rows: &mut Blocks<T>,
    ) {
        if let Some(ahead) = &mut self.ahead {
            ahead.add_to(at, rows);
        }
        forces.add_all(&self.balance.forces.acceleration.columns);
    }

    /// ∂G at fixed a₀: through the velocity forces, and through the time by which they are ahead.
    ///
    /// −½ (−∂c(v + s a₀) + ∂c(v − s a₀)): weights on all numbers at once, so that derivatives are compiled for one output.
    fn differentiate(&mut self, at: &EvaluationPoint<'_, f64, T>, gyroscopic: &Gyroscopic<T>) {
        let (model, nv) = (at.model(), at.model().nv());
        self.direct.clear();
        for (side, weight) in [(1.0, -1.0), (-1.0, -0.5)] {
            gyroscopic.velocity_into(model, half_step(at), side, &mut self.v);
            let (q, v, a) = (at.q(), &self.v[..], &self.at_rest[..]);
            let (motion, inverse) = (At { q, v, a }, &mut self.inverse);
            let mut out = self.direct.view();
            add_derivatives(model, &motion, &[], inverse, &mut out, &mut self.mass);
            self.direct.scale(weight);
        }
        self.fold_velocities(model);
        each_derivative(at, &mut self.fastest, |k, slope| {
            if !is_nothing(&slope) {
                for (row, &change) in gyroscopic.change.iter().enumerate() {
                    *self.direct.at(row, nv + k) += change * slope;
                }
            }
        });
    }

    /// From ∂G/∂(N v) to ∂G/∂v.
    fn fold_velocities(&mut self, model: &Model) {
        let (direct, nv) = (&mut self.direct, model.nv());
        each_spin(model, |l, k, x: T| {
            for row in 0..nv {
                let linear = *direct.at(row, nv + l);
                *direct.at(row, nv + k) += linear * x;
            }
        });
        each_left_out(model, |l| {
            (0..nv).for_each(|row| *direct.at(row, nv + l) = T::zero());
        });
    }

    /// δG = ∂G + s ∂c/∂v δa₀ with −δa₀ = (M + s ∂c/∂v)⁻¹ (∂ID − ∂τ + ∂G), held by constraints.
    fn follow(&mut self, at: &EvaluationPoint<'_, f64, T>, gyroscopic: &Gyroscopic<T>) {
        let (s, product) = (half_step(at), &mut self.memory);
        let BalanceColumns { forces, rows } = &mut self.balance;
        let mut rows = rows.columns.blocks_mut();
        let mut minus_a = (self.ahead.iter_mut()).nested(|ahead| ahead.minus_a.blocks_mut());
        let columns = &mut forces.acceleration.columns;
        for (x, direct) in columns.blocks_mut().zip(self.direct.blocks()) {
            x.iter_mut()
                .zip(direct)
                .for_each(|(x, &direct)| *x += direct);
            gyroscopic.factor.solve(x);
            if let Some((y, minus_a)) = rows.next().zip(minus_a.next()) {
                gyroscopic.bilateral.solve(x, y);
                minus_a.copy_from_slice(x);
            }
            product.copy_from_slice(direct);
            for (k, x) in x.iter().enumerate() {
                let (rows, column) = gyroscopic.slope.in_tree(k);
                for (product, &slope) in product[rows].iter_mut().zip(column) {
                    if !is_nothing(&slope) {
                        *product = x.times_plus(-s * slope, *product);
                    }
                }
            }
            x.copy_from_slice(product);
        }
    }
}
