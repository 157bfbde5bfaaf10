//! Derivatives of momenta and forces, and the matrix of Newton's method.

use nalgebra::DMatrix;

use super::joint::{JointDerivatives, JointStep, OwnMatrix, apply, apply_transposed};
use super::point::{Kinetic, Midpoint};
use super::saddle::Saddle;
use crate::autodiff::TangentPoint;
use crate::dynamics::{At, Calls, CrbaScratch, mass_matrix_into};
use crate::joint::MAX_NV;
use crate::model::Model;
use crate::model::manifold::{q_range, v_range};
use crate::nested::IntoNested;
use crate::scalar::{CHUNK, Differentiable, Dual, MapEach, Scalar};
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::integrators::AccelerationScratch;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use crate::sim::terms::{
    AllDerivatives, DerivativePoint, ForceColumns, JacobianMemory, JacobianSink, RowColumns,
    TermDerivatives,
};

/// A number with derivatives in some directions of the configuration.
type Moved<T> = Dual<T, CHUNK>;

/// M, and the derivatives in q of the momentum M v and of ∂T/∂q.
#[derive(Clone, Debug)]
pub(super) struct KineticDerivatives<T: Scalar> {
    pub(super) mass: DMatrix<T>,
    pub(super) momentum_by_q: DMatrix<T>,
    pub(super) force_by_q: DMatrix<T>,
    crba: CrbaScratch<T>,
    point: TangentPoint<Moved<T>>,
    v: Vec<Moved<T>>,
    kinetic: Kinetic<Moved<T>>,
    out: [Vec<Moved<T>>; 2],
}

impl<T: Scalar> KineticDerivatives<T> {
    pub(super) fn new(model: &Model) -> Self {
        let nv = model.nv();
        let zeros = || vec![Moved::from(0.0); nv];
        Self {
            mass: DMatrix::zeros(nv, nv),
            momentum_by_q: DMatrix::zeros(nv, nv),
            force_by_q: DMatrix::zeros(nv, nv),
            crba: CrbaScratch::new(model),
            point: TangentPoint::new(model.nq(), nv, 0),
            v: zeros(),
            kinetic: Kinetic::new(model),
            out: [zeros(), zeros()],
        }
    }

    /// Finds them.
    pub(super) fn find(&mut self, model: &Model, q: &[T], v: &[T]) {
        self.find_mass(model, q);
        self.find_slopes(model, q, v);
    }

    pub(super) fn find_mass(&mut self, model: &Model, q: &[T]) {
        mass_matrix_into(model, q, &mut self.crba, &mut self.mass);
    }

    /// All but M.
    pub(super) fn find_slopes(&mut self, model: &Model, q: &[T], v: &[T]) {
        let zeros = std::iter::repeat_n(Moved::from(0.0), model.nv());
        let Self { point, kinetic, .. } = self;
        point.set_to(q.iter().map(|&x| Moved::constant_of(x)), zeros);
        let lifted = self.v.iter_mut().zip(v);
        lifted.for_each(|(own, &v)| *own = Moved::constant_of(v));
        let [momentum, force] = &mut self.out;
        let outputs = [&mut self.momentum_by_q, &mut self.force_by_q];
        let [momentum_by_q, force_by_q] = outputs.map(DMatrix::as_mut_slice);
        point.each(
            0..model.nv(),
            |q, dq, out| model.integrate_into(q, dq, out),
            |q, _, seeded| {
                kinetic.find(model, q, &self.v, momentum, force);
                for (slopes, out) in [
                    (&*momentum, &mut *momentum_by_q),
                    (&*force, &mut *force_by_q),
                ] {
                    for (k, column) in seeded.clone().enumerate() {
                        let own = &mut out[column * model.nv()..][..model.nv()];
                        own.iter_mut()
                            .zip(slopes)
                            .for_each(|(out, x)| *out = x.eps[k]);
                    }
                }
            },
        );
    }
}

/// Derivatives at the middle of a step, and the factors of those of its residuals in ξ and the impulses of constraints.
#[derive(Clone, Debug)]
pub(super) struct MidpointDerivatives<T: Differentiable> {
    pub(super) kinetic: KineticDerivatives<T>,
    /// Of the force in q, v, and the input.
    pub(super) force_by: [DMatrix<T>; 3],
    /// Of joints whose configuration is not a vector.
    pub(super) joints: Vec<JointDerivatives<T>>,
    /// Coordinates of the other joints.
    pub(super) vectors: Vec<usize>,
    pub(super) saddle: Saddle<T>,
    /// The factorised matrix, with working memory.
    matrix: DMatrix<T>,
    /// Derivatives of the errors at the end in ξ, and of the momentum that is expected in the middle in the impulses of the start, row by row.
    errors_by_xi: Vec<T>,
    momentum_by_impulses: Vec<T>,
    product: DMatrix<T>,
    terms: AllDerivatives<T>,
    forces: ForceColumns<T>,
    /// None: all forces follow from the state.
    rows: RowColumns<T>,
    memory: JacobianMemory<T>,
    rest: Vec<T>,
}

impl<T: Differentiable> MidpointDerivatives<T> {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let (model, nv) = (simulator.model(), simulator.model().nv());
        let (vectors, curved): (Vec<_>, Vec<_>) =
            model.independent().partition(|body| body.joint.nv() == 1);
        Self {
            kinetic: KineticDerivatives::new(model),
            force_by: [nv, nv, simulator.nu()].map(|columns| DMatrix::zeros(nv, columns)),
            joints: curved.into_iter().map(JointDerivatives::new).collect(),
            vectors: vectors.iter().map(|body| body.v).collect(),
            saddle: Saddle::new(simulator),
            matrix: DMatrix::zeros(nv, nv),
            errors_by_xi: Vec::with_capacity(simulator.bilateral_rows() * nv),
            momentum_by_impulses: Vec::with_capacity(simulator.bilateral_rows() * nv),
            product: DMatrix::zeros(nv, nv),
            terms: AllDerivatives::new(simulator),
            forces: ForceColumns::new(simulator, Calls::Many),
            rows: RowColumns::new(model, 0, 0),
            memory: JacobianMemory::new(simulator),
            rest: vec![T::zero(); nv],
        }
    }

    /// Finds them at a point that has been evaluated.
    ///
    /// * `start` – the state before the step
    pub(super) fn find(
        &mut self,
        simulator: &Simulator,
        start: &State<T>,
        u: &[T],
        point: &Midpoint<T>,
        found: &AccelerationScratch<T>,
    ) {
        let (model, mid) = (simulator.model(), &point.state);
        self.kinetic.find(model, mid.q.as_slice(), mid.v.as_slice());
        self.find_forces(simulator, u, point, found);
        self.find_joints(simulator, start, point);
        let dt = simulator.time_step() * point.part;
        self.fill_matrix(dt);
        let (mut d, held) = (std::mem::take(&mut self.errors_by_xi), &point.held);
        self.errors_by(&held.end.jacobian, |own| &own.end[1], dt, &mut d);
        self.errors_by_xi = d;
        self.find_momentum_by_impulses(&held.start.jacobian);
        let g = &self.momentum_by_impulses;
        self.saddle.factorize(&self.matrix, &self.errors_by_xi, g);
    }

    /// Rows of the end times derivatives of its configuration, row by row.
    ///
    /// * `pick` – those of a joint whose configuration is not a vector
    /// * `time` – those of the others
    pub(super) fn errors_by(
        &self,
        jacobian: &[T],
        pick: impl Fn(&JointDerivatives<T>) -> &OwnMatrix<T>,
        time: f64,
        out: &mut Vec<T>,
    ) {
        let nv = self.rest.len().max(1);
        out.clear();
        out.extend(jacobian.iter().map(|&x| x * time));
        for (out, row) in out.chunks_exact_mut(nv).zip(jacobian.chunks_exact(nv)) {
            for own in &self.joints {
                let out = &mut out[own.range()];
                out.copy_from_slice(&row[own.range()]);
                apply_transposed(pick(own), out);
            }
        }
    }

    /// J (dexp 2φ) of the rows of the start.
    fn find_momentum_by_impulses(&mut self, jacobian: &[T]) {
        let (g, nv) = (&mut self.momentum_by_impulses, self.rest.len().max(1));
        g.clear();
        g.extend_from_slice(jacobian);
        for row in g.chunks_exact_mut(nv) {
            for own in &self.joints {
                let row = &mut row[own.range()];
                let mut carried = [T::zero(); MAX_NV];
                carried[..own.nv].copy_from_slice(row);
                apply(&own.carry, &mut carried[..own.nv]);
                let both = row.iter_mut().zip(carried);
                both.for_each(|(x, carried)| *x = (*x + carried) * 0.5);
                apply(&own.momentum[1], row);
            }
        }
    }

    /// f = ∂T/∂q + τ + Jᵀ F − g: of the kinetic energy from above, of the rest what resists at rest, the other way round.
    fn find_forces(
        &mut self,
        simulator: &Simulator,
        u: &[T],
        point: &Midpoint<T>,
        found: &AccelerationScratch<T>,
    ) {
        let (model, mid, rest) = (simulator.model(), &point.state, &self.rest);
        let moment = EvaluationPoint::instant(simulator, mid, u);
        let at = DerivativePoint::of_all(&moment, rest, None);
        let (forces, memory) = (&mut self.forces, &mut self.memory);
        forces.clear();
        let mut sink = JacobianSink::new(&at, forces, &mut self.rows, memory);
        self.terms.emit_forces(&at, &found.terms, &mut sink);
        let at_rest = At {
            q: mid.q.as_slice(),
            v: rest,
            a: rest,
        };
        let bodies = &forces.bodies;
        forces.acceleration.balance(model, &at_rest, bodies);
        let nv = model.nv().max(1);
        let outputs = self.force_by.iter_mut();
        let columns = outputs.nested(|m| m.as_mut_slice().chunks_exact_mut(nv));
        forces.acceleration.columns.copy_columns_to(columns, |x| -x);
        let KineticDerivatives {
            momentum_by_q,
            force_by_q,
            ..
        } = &self.kinetic;
        let [by_q, by_v, _] = &mut self.force_by;
        *by_q += force_by_q;
        // At fixed q the force is the derivative of T in a direction, linear in v as the momentum is in that direction.
        for i in 0..model.nv() {
            for k in 0..model.nv() {
                by_v[(i, k)] += momentum_by_q[(k, i)];
            }
        }
    }

    fn find_joints(&mut self, simulator: &Simulator, start: &State<T>, point: &Midpoint<T>) {
        let model = simulator.model();
        let curved = model.independent().filter(|body| body.joint.nv() > 1);
        for (own, body) in self.joints.iter_mut().zip(curved) {
            let (q, v) = (q_range(body), v_range(body));
            own.find(
                body,
                &JointStep {
                    q: &start.q.as_slice()[q],
                    offsets: [&point.half_offset, &point.offset].map_each(|x| &x[v.clone()]),
                    p: &point.p[v.clone()],
                    impulse: &point.impulse[v],
                    dt: simulator.time_step() * point.part,
                },
            );
        }
    }

    /// ∂ residual / ∂ξ = M + ∂μ/∂q H − G (½ Δt (∂f/∂v + ∂f/∂q H)) − C with the derivatives H of the middle in ξ, and G and C of the momentum that is
    /// expected there in half of the impulse and in ξ.
    fn fill_matrix(&mut self, dt: f64) {
        let [by_q, by_v, _] = &self.force_by;
        let (half, out, kinetic) = (0.5 * dt, &mut self.matrix, &self.kinetic);
        times_motion(by_q, &self.joints, half, out);
        *out += by_v;
        let entries = out.iter_mut();
        entries.for_each(|x| *x = *x * -half);
        let n = out.nrows().max(1);
        for own in &self.joints {
            for column in out.as_mut_slice().chunks_exact_mut(n) {
                apply(&own.momentum[1], &mut column[own.range()]);
            }
            for (i, row) in own.range().zip(&own.momentum[0]) {
                for (k, &x) in own.range().zip(row) {
                    out[(i, k)] -= x;
                }
            }
        }
        times_motion(
            &kinetic.momentum_by_q,
            &self.joints,
            half,
            &mut self.product,
        );
        *out += &self.product;
        *out += &kinetic.mass;
    }
}

/// m H, with the derivatives H of the middle in ξ.
fn times_motion<T: Scalar>(
    m: &DMatrix<T>,
    joints: &[JointDerivatives<T>],
    half: f64,
    out: &mut DMatrix<T>,
) {
    out.iter_mut().zip(m).for_each(|(out, &x)| *out = x * half);
    for own in joints {
        for i in 0..m.nrows() {
            let mut row = [T::zero(); MAX_NV];
            own.range().zip(&mut row).for_each(|(k, x)| *x = m[(i, k)]);
            apply_transposed(&own.middle[1], &mut row[..own.nv]);
            own.range().zip(row).for_each(|(k, x)| out[(i, k)] = x);
        }
    }
}
