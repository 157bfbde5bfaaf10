//! Accelerations with rigid contact: forces that a solver finds, so that the motion of each point obeys its law.
//!
//! With the acceleration `a_free` without contact, a = `a_free` + M⁻¹ Jᵀ f. Seen from the points that is y = G f + J `a_free` − wanted with
//! G = J M⁻¹ Jᵀ: the problem of [`cone`](crate::contact::cone). Points that cannot touch within the step are left out; which those are is
//! decided on values.

use nalgebra::{DMatrix, Vector3};

use super::contact::ContactScratch;
use super::simulator::Simulator;
use super::state::State;
use crate::contact::cone::{Block, Certificate, ConeProblem, ConeSolver, Law, Mode};
use crate::contact::{ContactLaw, Contacts, PointRows, PointState, each_column};
use crate::dynamics::{
    CrbaScratch, MassMatrixFactor, RneaScratch, bias_forces_into, mass_matrix_into,
};
use crate::model::Model;
use crate::scalar::{Over, Scalar};
use crate::spatial::linear::{dot, scale};

/// Rows of a point: along its normal, and two across.
const ROWS: usize = 3;

/// Acceleration wanted of a point, where it is above the ground in one lane only, m/s²: away, faster than anything pulls.
const FAR: f64 = -1e12;

/// Working memory of [`solve`](Self::solve).
#[derive(Clone, Debug)]
pub(super) struct ConstrainedScratch<T: Scalar> {
    crba: CrbaScratch<T>,
    rnea: RneaScratch<T>,
    mass: DMatrix<T>,
    factor: MassMatrixFactor<T>,
    /// Points that take part.
    active: Vec<usize>,
    /// Axes of each of them (normal, tangent, tangent) in the world.
    axes: Vec<[Vector3<T>; ROWS]>,
    /// J, row after row, and M⁻¹ Jᵀ, column after column: `nv` numbers each.
    jacobian: Vec<T>,
    response: Vec<T>,
    system: System<T>,
    solver: ConeSolver<T>,
    certificate: Certificate,
}

/// The numbers of the problem of cones.
#[derive(Clone, Debug, Default)]
struct System<T> {
    blocks: Vec<Block>,
    friction: Vec<T>,
    matrix: Vec<T>,
    regularization: Vec<T>,
    offset: Vec<T>,
    forces: Vec<T>,
}

impl<T: Scalar> ConstrainedScratch<T> {
    pub(super) fn new<P: Scalar>(simulator: &Simulator<P>, contacts: &Contacts<P>) -> Self {
        let (model, n) = (simulator.model(), contacts.points().len());
        let (nv, rows) = (model.nv(), ROWS * n);
        Self {
            crba: CrbaScratch::new(model),
            rnea: RneaScratch::new(model),
            mass: DMatrix::zeros(nv, nv),
            factor: MassMatrixFactor::new(model, &DMatrix::identity(nv, nv)),
            active: Vec::with_capacity(n),
            axes: Vec::with_capacity(n),
            jacobian: Vec::with_capacity(rows * nv),
            response: Vec::with_capacity(rows * nv),
            system: System {
                blocks: Vec::with_capacity(n),
                friction: Vec::with_capacity(n),
                matrix: Vec::with_capacity(rows * rows),
                regularization: Vec::with_capacity(rows),
                offset: Vec::with_capacity(rows),
                forces: Vec::with_capacity(rows),
            },
            solver: ConeSolver::new(rows, n),
            certificate: Certificate::default(),
        }
    }

    /// What the last solution is worth.
    pub(super) fn certificate(&self) -> Certificate {
        self.certificate
    }

    /// The points that took part in the last solution, with their modes, lane after lane.
    pub(super) fn modes(&self) -> (&[usize], &[Mode]) {
        (&self.active, self.solver.modes())
    }

    /// The acceleration at a state with these joint forces; forces on points go to `contact`.
    pub(super) fn solve<P: Scalar>(
        &mut self,
        simulator: &Simulator<P>,
        contacts: &Contacts<P>,
        state: &State<T>,
        tau: &[T],
        contact: &mut ContactScratch<T>,
        a: &mut [T],
    ) where
        T: Over<P>,
    {
        let model = simulator.model();
        let (q, v) = (state.q.as_slice(), state.v.as_slice());
        // a_free = M⁻¹ (τ − h)
        mass_matrix_into(model, q, &mut self.crba, &mut self.mass);
        self.factor.refactor(&self.mass);
        bias_forces_into(model, q, v, &[], &mut self.rnea, a);
        a.iter_mut().zip(tau).for_each(|(a, &tau)| *a = tau - *a);
        self.factor.solve(a);
        contact.locate(model, contacts, state);
        self.select(simulator, contacts, &contact.points);
        if self.active.is_empty() {
            contact.forces.fill(Vector3::zeros());
            return;
        }
        self.form_rows(simulator, contacts, contact);
        self.form_system(simulator, contacts, &contact.points, (v, a));
        self.find_forces(contacts, contact);
        // a = a_free + M⁻¹ Jᵀ f
        let nv = a.len();
        for (column, &f) in self.response.chunks_exact(nv).zip(&self.system.forces) {
            a.iter_mut().zip(column).for_each(|(a, &x)| *a += x * f);
        }
    }

    /// Points that are below the ground, or would be after the step, in some lane.
    fn select<P: Scalar>(
        &mut self,
        simulator: &Simulator<P>,
        contacts: &Contacts<P>,
        points: &[PointState<T>],
    ) {
        self.active.clear();
        let ahead = match contacts.laws()[0] {
            ContactLaw::Rigid(_) => simulator.time_step(),
            _ => 0.0,
        };
        for (i, point) in points.iter().enumerate() {
            let closing = -dot(&point.normal, &point.velocity);
            // Also what gravity adds within the step: too many points do no harm.
            let near = |lane| {
                let reach = ahead * (closing.value(lane).max(0.0) + ahead * HASTE);
                point.depth.value(lane) + reach > 0.0
            };
            if (0..T::LANES).any(near) {
                self.active.push(i);
            }
        }
    }

    /// J and M⁻¹ Jᵀ of the points that take part.
    fn form_rows<P: Scalar>(
        &mut self,
        simulator: &Simulator<P>,
        contacts: &Contacts<P>,
        contact: &ContactScratch<T>,
    ) where
        T: Over<P>,
    {
        let (model, nv) = (simulator.model(), simulator.model().nv());
        let rows = ROWS * self.active.len();
        self.jacobian.clear();
        self.jacobian.resize(rows * nv, T::zero());
        self.axes.clear();
        for (at, &i) in self.active.iter().enumerate() {
            let point = &contact.points[i];
            let [t_1, t_2] = point.tangents();
            let axes = [point.normal, t_1, t_2];
            let own = &mut self.jacobian[ROWS * nv * at..ROWS * nv * (at + 1)];
            let place = (Some(contacts.points()[i].body), &point.in_body);
            each_column(model, &contact.kinematics, place, |k, column| {
                for (row, axis) in axes.iter().enumerate() {
                    own[row * nv + k] += dot(axis, &column);
                }
            });
            self.axes.push(axes);
        }
        self.response.clear();
        self.response.extend_from_slice(&self.jacobian);
        for column in self.response.chunks_exact_mut(nv) {
            self.factor.solve(column);
        }
    }

    /// G, R, g and μ.
    fn form_system<P: Scalar>(
        &mut self,
        simulator: &Simulator<P>,
        contacts: &Contacts<P>,
        points: &[PointState<T>],
        (v, a): (&[T], &[T]),
    ) where
        T: Over<P>,
    {
        let (model, nv, dt) = (simulator.model(), a.len(), simulator.time_step());
        let (s, n) = (&mut self.system, ROWS * self.active.len());
        s.clear();
        for column in self.response.chunks_exact(nv) {
            let rows = self.jacobian.chunks_exact(nv);
            s.matrix.extend(rows.map(|row| product(row, column)));
        }
        for (at, &i) in self.active.iter().enumerate() {
            let point = &points[i];
            let own = std::array::from_fn(|k| dot(&self.axes[at][k], &point.velocity));
            let mobility = s.matrix[(n + 1) * ROWS * at];
            let (rows, mu) = ask(&contacts.laws()[i], point.depth, &own, mobility, dt);
            let relaxed = matches!(contacts.laws()[i], ContactLaw::RelaxedRigid(_));
            for k in 0..ROWS {
                let row = &self.jacobian[nv * (ROWS * at + k)..][..nv];
                let wanted = match (relaxed, k) {
                    // Above the ground nothing is wanted of it.
                    (true, 0) => point
                        .depth
                        .select_lt(T::zero(), T::constant(FAR), rows.wanted[k]),
                    _ => rows.wanted[k],
                };
                s.offset
                    .push(product(row, a) + turning(model, row, v) - wanted);
                s.regularization.push(rows.regularization[k]);
                // From nothing each time: what a step does depends on the state alone, also where forces are not unique.
                s.forces.push(T::zero());
            }
            s.blocks.push(Block::Cone);
            s.friction.push(mu);
        }
    }

    fn find_forces<P: Scalar>(&mut self, contacts: &Contacts<P>, contact: &mut ContactScratch<T>) {
        let s = &mut self.system;
        let law = match contacts.laws()[0] {
            ContactLaw::Rigid(_) => Law::Coulomb,
            _ => Law::Convex,
        };
        let problem = ConeProblem {
            law,
            blocks: &s.blocks,
            friction: &s.friction,
            matrix: &s.matrix,
            regularization: &s.regularization,
            offset: &s.offset,
        };
        self.certificate = self.solver.solve(&problem, &mut s.forces);
        contact.forces.fill(Vector3::zeros());
        let (forces, _) = s.forces.as_chunks::<ROWS>();
        for ((&i, axes), f) in self.active.iter().zip(&self.axes).zip(forces) {
            let [n, t_1, t_2] = axes;
            contact.forces[i] = scale(n, f[0]) + scale(t_1, f[1]) + scale(t_2, f[2]);
        }
    }
}

/// Acceleration towards the ground that a point may gain within a step and still be noticed, m/s².
const HASTE: f64 = 1e3;

impl<T> System<T> {
    fn clear(&mut self) {
        self.blocks.clear();
        self.friction.clear();
        self.matrix.clear();
        self.regularization.clear();
        self.offset.clear();
        self.forces.clear();
    }
}

/// What a law asks of a point, and μ.
fn ask<P: Scalar, T: Over<P>>(
    law: &ContactLaw<P>,
    depth: T,
    v: &[T; ROWS],
    mobility: T,
    dt: f64,
) -> (PointRows<T>, T) {
    match law {
        ContactLaw::Rigid(law) => (law.ask(depth, v, dt), law.friction.into()),
        ContactLaw::RelaxedRigid(law) => (law.ask(depth, v, mobility), law.friction.into()),
        ContactLaw::Soft(_) => unreachable!("soft contact has no rows"),
    }
}

fn product<T: Scalar>(a: &[T], b: &[T]) -> T {
    let zero = T::zero();
    a.iter()
        .zip(b)
        .fold(zero, |sum, (&a, &b)| a.mul_add(b, sum))
}

/// What a row sees of the turning of the axes in which floating and planar joints have their linear velocity, J (ω × v).
fn turning<P: Scalar, T: Over<P>>(model: &Model<P>, row: &[T], v: &[T]) -> T {
    let mut sum = T::zero();
    for body in model.independent() {
        body.joint
            .turning(&v[body.v..body.v + body.joint.nv()], |k, x| {
                sum += row[body.v + k] * x;
            });
    }
    sum
}
