//! Jacobians of the step by the implicit function theorem.
//!
//! Those of a step in parts are products of theirs.
//!
//! With the residual r = μ − (dexp 2φ)ᵀ p − ½ Δt (dexp φ)ᵀ f,  δξ = −(∂r/∂ξ)⁻¹ ∂r; then δq⁺, and δv⁺ = M⁻¹ (δp⁺ − ∂(M v⁺)/∂q δq⁺). With constraints
//! their impulses are found along with ξ and with v⁺, from equations with rows (`saddle.rs`).

use nalgebra::DMatrix;

use super::Memory;
use super::bilateral_derivatives::BilateralDerivatives;
use super::held::add_rows;
use super::joint::{Along, JointDerivatives, OwnMatrix, apply};
use super::point::Midpoint;
use super::slopes::{KineticDerivatives, MidpointDerivatives};
use crate::dynamics::Calls;
use crate::joint::MAX_NV;
use crate::linalg::product::add_scaled;
use crate::scalar::{Differentiable, Scalar, is_nothing};
use crate::sim::integrators::AccelerationScratch;
use crate::sim::integrators::method::{Pushforward, Step, StepColumns, StepPoint};
use crate::sim::simulator::Simulator;
use crate::sim::state::State;

/// A step that has been taken, with the derivatives at start, middle and end of one of its parts.
#[derive(Clone, Debug)]
pub(super) struct TakenStep<T: Differentiable> {
    pub(super) step: Memory<T>,
    pub(super) found: AccelerationScratch<T>,
    pub(super) next: State<T>,
    pub(super) start: KineticDerivatives<T>,
    pub(super) middle: MidpointDerivatives<T>,
    pub(super) end: KineticDerivatives<T>,
    /// Of the rows of the end, or of the start before.
    pub(super) held: BilateralDerivatives<T>,
}

impl<T: Differentiable> TakenStep<T> {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let model = simulator.model();
        Self {
            step: Memory::new(simulator),
            found: AccelerationScratch::new(simulator, Calls::Many),
            next: simulator.neutral_state(),
            start: KineticDerivatives::new(model),
            middle: MidpointDerivatives::new(simulator),
            end: KineticDerivatives::new(model),
            held: BilateralDerivatives::new(simulator),
        }
    }

    /// Takes the step and returns the number of its parts.
    pub(super) fn take(&mut self, simulator: &Simulator, at: &StepPoint<'_, T>) -> usize {
        (self.step).step(simulator, at.state, at.u, &mut self.found, &mut self.next);
        self.step.parts
    }

    /// Differentiates a part of the step.
    pub(super) fn find(&mut self, simulator: &Simulator, u: &[T], k: usize) {
        let (model, next) = (simulator.model(), &mut self.next);
        let Memory {
            part,
            parts,
            starts,
            ..
        } = &mut self.step;
        let state = &starts[k];
        // A whole step uses the memory of the step just taken.
        if *parts > 1 {
            part.take(simulator, state, u, *parts, &mut self.found, next);
        }
        (self.middle).find(simulator, state, u, &part.point, &self.found);
        let (start, end) = (&mut self.start, &mut self.end);
        start.find_mass(model, state.q.as_slice());
        if simulator.constraints().is_empty() {
            start.find_slopes(model, state.q.as_slice(), state.v.as_slice());
            return end.find_slopes(model, next.q.as_slice(), next.v.as_slice());
        }
        let (held, rows) = (&mut self.held, &part.point.held);
        let [impulses, left] = &rows.impulses;
        let (jacobian, out) = (&rows.start.jacobian, &mut start.momentum_by_q);
        held.find(simulator, state, jacobian, impulses.iter().copied(), out);
        // The momentum that is left after the impulses of the end.
        let (jacobian, out) = (&rows.end.jacobian, &mut end.momentum_by_q);
        held.find(simulator, next, jacobian, left.iter().map(|&x| -x), out);
    }

    /// The middle of the part that is differentiated.
    pub(super) fn point(&self) -> &Midpoint<T> {
        &self.step.part.point
    }

    /// Start of a part, with the input.
    pub(super) fn start_of<'a>(&'a self, u: &'a [T], k: usize) -> StepPoint<'a, T> {
        StepPoint {
            state: &self.step.starts[k],
            u,
            acceleration: None,
        }
    }

    /// Length of that part, s.
    pub(super) fn duration(&self, simulator: &Simulator) -> f64 {
        simulator.time_step() * self.point().part
    }
}

/// Working memory: the step with its derivatives, and those in (q, v, u) of its start, a column each.
#[derive(Clone, Debug)]
pub(crate) struct Columns<T: Differentiable> {
    slopes: TakenStep<T>,
    /// Of the momentum of the start, and of its transported value.
    p: DMatrix<T>,
    /// Of ξ.
    xi: DMatrix<T>,
    /// Of the middle, then of the end, each in its tangent space.
    moved: DMatrix<T>,
    /// Of the force, or of other products.
    force: DMatrix<T>,
    /// Of the errors of the end at fixed ξ, row by row; of rows in one direction.
    errors: Vec<T>,
    rows: Vec<T>,
}

impl<T: Differentiable> Pushforward<T> for Columns<T> {
    fn new(simulator: &Simulator, _: Calls) -> Self {
        let nv = simulator.model().nv();
        let columns = || DMatrix::zeros(nv, 2 * nv + simulator.nu());
        Self {
            slopes: TakenStep::new(simulator),
            p: columns(),
            xi: columns(),
            moved: columns(),
            force: columns(),
            errors: Vec::with_capacity(simulator.bilateral_rows() * nv),
            rows: vec![T::zero(); simulator.bilateral_rows()],
        }
    }

    fn linearize(
        &mut self,
        simulator: &Simulator,
        at: &StepPoint<'_, T>,
        out: &mut StepColumns<'_, T>,
    ) {
        let parts = self.slopes.take(simulator, at);
        self.linearize_part(simulator, at.u, 0, out);
        for k in 1..parts {
            let (mut a, mut b) = (out.a.clone(), out.b.clone());
            let own = &mut StepColumns {
                a: &mut a,
                b: &mut b,
            };
            self.linearize_part(simulator, at.u, k, own);
            let [before_a, before_b] = [&mut *out.a, &mut *out.b].map(|x| x.clone());
            out.a.fill(T::zero());
            add_product(&a, &before_a, out.a);
            out.b.copy_from(&b);
            add_product(&a, &before_b, out.b);
        }
    }
}

impl<T: Differentiable> Columns<T> {
    /// A and B of one part of the step.
    fn linearize_part(
        &mut self,
        simulator: &Simulator,
        u: &[T],
        k: usize,
        out: &mut StepColumns<'_, T>,
    ) {
        self.slopes.find(simulator, u, k);
        let dt = self.slopes.duration(simulator);
        self.find_velocity(dt);
        self.find_momentum(dt);
        self.find_end(dt, out);
    }

    /// ∂ξ; and `p` becomes that of the momentum of the start with the impulses of constraints.
    fn find_velocity(&mut self, dt: f64) {
        let Self {
            slopes,
            p,
            xi,
            moved,
            force,
            errors,
            rows,
        } = self;
        let (middle, nv) = (&slopes.middle, p.nrows());
        let joints = &middle.joints;
        // Target of the momentum of the middle minus its value, at fixed ξ.
        p.fill(T::zero());
        p.columns_mut(0, nv).copy_from(&slopes.start.momentum_by_q);
        p.columns_mut(nv, nv).copy_from(&slopes.start.mass);
        start_motion(joints, |own| &own.middle[0], moved);
        find_force(middle, moved, None, force);
        for (k, xi) in xi.iter_mut().enumerate() {
            *xi = force[k] * (0.5 * dt) + p[k];
        }
        for own in joints {
            for k in 0..xi.ncols() {
                let mut expected = carried(own, p, k);
                for (i, x) in own.range().enumerate() {
                    expected[i] = (expected[i] + p[(x, k)]) * 0.5 + force[(x, k)] * (0.5 * dt);
                }
                apply(&own.momentum[1], &mut expected[..own.nv]);
                write(own, &expected, xi, k);
            }
        }
        force.fill(T::zero());
        add_product(&middle.kinetic.momentum_by_q, moved, force);
        *xi -= &*force;
        let held = &slopes.point().held;
        middle.errors_by(&held.end.jacobian, |own| &own.end[0], 1.0, errors);
        for k in 0..xi.ncols() {
            let by_q = errors.chunks_exact(nv.max(1));
            let entries = by_q.map(|row| row.get(k).map_or(T::zero(), |&x| -x));
            rows.iter_mut().zip(entries).for_each(|(out, x)| *out = x);
            let [xi, p] = [&mut *xi, &mut *p].map(|m| &mut m.as_mut_slice()[k * nv..][..nv]);
            middle.saddle.solve(xi, rows);
            add_rows(&held.start, rows, p);
        }
    }

    /// Of the momentum of the end, in `p`.
    fn find_momentum(&mut self, dt: f64) {
        let Self {
            slopes,
            p,
            xi,
            moved,
            force,
            ..
        } = self;
        let joints = &slopes.middle.joints;
        start_motion(joints, |own| &own.middle[0], moved);
        add_motion(&slopes.middle, |own| &own.middle[1], 0.5 * dt, xi, moved);
        find_force(&slopes.middle, moved, Some(xi), force);
        for own in joints {
            for k in 0..p.ncols() {
                let mut x = carried(own, p, k);
                own.range()
                    .zip(&mut x)
                    .for_each(|(i, x)| *x += force[(i, k)] * dt);
                apply(&own.carry, &mut x[..own.nv]);
                let mut by_xi = column_of(own, xi, k);
                apply(&own.end_momentum, &mut by_xi[..own.nv]);
                x.iter_mut().zip(by_xi).for_each(|(x, y)| *x += y);
                write(own, &x, p, k);
                own.range().for_each(|i| force[(i, k)] = T::zero());
            }
        }
        p.iter_mut().zip(&*force).for_each(|(p, &f)| *p += f * dt);
    }

    /// Of the state at the end.
    fn find_end(&mut self, dt: f64, out: &mut StepColumns<'_, T>) {
        let Self {
            slopes,
            p,
            xi,
            moved,
            force,
            rows,
            ..
        } = self;
        let (nv, joints) = (p.nrows(), &slopes.middle.joints);
        start_motion(joints, |own| &own.end[0], moved);
        add_motion(&slopes.middle, |own| &own.end[1], dt, xi, moved);
        force.fill(T::zero());
        add_product(&slopes.end.momentum_by_q, moved, force);
        *p -= &*force;
        for (k, mut column) in p.column_iter_mut().enumerate() {
            let moved = &moved.as_slice()[k * nv..][..nv];
            rows.fill(T::zero());
            subtract_product(&slopes.held.rate_by_q, moved, rows);
            let end = &slopes.point().end;
            end.solve(column.as_mut_slice(), rows);
        }
        for (first, part) in [(0, &*moved), (nv, &*p)] {
            let (own, inputs) = (
                part.columns(0, 2 * nv),
                part.columns(2 * nv, part.ncols() - 2 * nv),
            );
            out.a.rows_mut(first, nv).copy_from(&own);
            out.b.rows_mut(first, nv).copy_from(&inputs);
        }
    }
}

/// Derivatives of a configuration in (q, v, u) at fixed ξ.
fn start_motion<T: Scalar>(
    joints: &[JointDerivatives<T>],
    pick: impl Fn(&JointDerivatives<T>) -> &OwnMatrix<T>,
    out: &mut DMatrix<T>,
) {
    out.fill(T::zero());
    (0..out.nrows()).for_each(|k| out[(k, k)] = T::one());
    for own in joints {
        let slopes = pick(own);
        for (i, row) in own.range().zip(slopes) {
            own.range().zip(row).for_each(|(k, &x)| out[(i, k)] = x);
        }
    }
}

/// Adds the part through ξ; the displacement of a vector is a multiple of ξ.
fn add_motion<T: Differentiable>(
    middle: &MidpointDerivatives<T>,
    pick: impl Fn(&JointDerivatives<T>) -> &OwnMatrix<T>,
    time: f64,
    xi: &DMatrix<T>,
    out: &mut DMatrix<T>,
) {
    for k in 0..xi.ncols() {
        let vectors = middle.vectors.iter();
        vectors.for_each(|&i| out[(i, k)] += xi[(i, k)] * time);
        for own in &middle.joints {
            let mut x = column_of(own, xi, k);
            apply(pick(own), &mut x[..own.nv]);
            own.range().zip(x).for_each(|(i, x)| out[(i, k)] += x);
        }
    }
}

/// Derivatives of the force of the middle, which moves, in (q, v, u); with those of ξ or at fixed ξ.
fn find_force<T: Differentiable>(
    middle: &MidpointDerivatives<T>,
    moved: &DMatrix<T>,
    xi: Option<&DMatrix<T>>,
    out: &mut DMatrix<T>,
) {
    let [by_q, by_v, by_u] = &middle.force_by;
    out.fill(T::zero());
    let inputs = out.ncols() - by_u.ncols();
    out.columns_mut(inputs, by_u.ncols()).copy_from(by_u);
    add_product(by_q, moved, out);
    if let Some(xi) = xi {
        add_product(by_v, xi, out);
    }
}

/// out += a b, without allocation.
fn add_product<T: Scalar>(a: &DMatrix<T>, b: &DMatrix<T>, out: &mut DMatrix<T>) {
    let n = a.nrows().max(1);
    let columns = out.as_mut_slice().chunks_exact_mut(n);
    for (out, b) in columns.zip(b.as_slice().chunks_exact(n)) {
        for (a, &x) in a.as_slice().chunks_exact(n).zip(b) {
            if !is_nothing(&x) {
                add_scaled(out, a, x);
            }
        }
    }
}

/// out −= m x
fn subtract_product<T: Scalar>(m: &DMatrix<T>, x: &[T], out: &mut [T]) {
    let columns = m.as_slice().chunks(out.len().max(1));
    for (column, &x) in columns.zip(x) {
        add_scaled(out, column, -x);
    }
}

/// A column of the rows of one joint.
fn column_of<T: Scalar>(own: &JointDerivatives<T>, m: &DMatrix<T>, k: usize) -> Along<T> {
    let mut out = [T::zero(); MAX_NV];
    own.range().zip(&mut out).for_each(|(i, x)| *x = m[(i, k)]);
    out
}

/// A p of one joint.
fn carried<T: Scalar>(own: &JointDerivatives<T>, p: &DMatrix<T>, k: usize) -> Along<T> {
    let mut out = column_of(own, p, k);
    apply(&own.carry, &mut out[..own.nv]);
    out
}

fn write<T: Scalar>(own: &JointDerivatives<T>, x: &Along<T>, m: &mut DMatrix<T>, k: usize) {
    own.range().zip(x).for_each(|(i, &x)| m[(i, k)] = x);
}
