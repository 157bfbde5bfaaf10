//! Accelerations under constraints, rigid contact, and what is implicit in velocity: forces that a solver finds.
//!
//! With the acceleration `a_free` without them, a = `a_free` + M⁻¹ Jᵀ f. Seen from the rows that is y = G f + J `a_free` − wanted with
//! G = J M⁻¹ Jᵀ: the problem of [`cone`](crate::contact::cone). The rows are those of kinematic constraints, then of joints at their
//! stops, then of points that touch. Points that cannot touch within the step are left out; which those are is decided on values.
//!
//! A step whose forces of joints are those of its end takes M + Δt C + Δt² K for M, with dampers C and springs K of the joints, and stops as
//! rows that give way; one that is implicit in velocity soft contact as well.

use nalgebra::{DMatrix, Vector3};

use super::contact::ContactScratch;
use super::integrator::AtEnd;
use super::rows::Rows;
use super::simulator::Simulator;
use super::state::State;
use super::working_set::{StepKinematics, WorkingSet};
use crate::constraint::ConstraintRows;
use crate::contact::cone::{
    Block, Certificate, ConeOptions, ConeSolver, Law, Mode, Smoothed, Status,
};
use crate::contact::{BodyPoint, Contacts, PointKinematics, ROWS, each_jacobian_column};
use crate::dynamics::{
    CrbaScratch, Gyroscopic, MassMatrixFactor, RneaScratch, bias_forces_into,
    mass_matrix_of_placed_into,
};
use crate::model::Model;
use crate::model::manifold::v_range;
use crate::scalar::{Over, Scalar};
use crate::spatial::linear::{dot, scale};
use crate::spatial::{Force, Transform};

/// Working memory of [`solve`](Self::solve).
#[derive(Clone, Debug)]
pub(crate) struct ConstrainedScratch<T: Scalar> {
    crba: CrbaScratch<T>,
    rnea: RneaScratch<T>,
    factor: MassMatrixFactor<T>,
    constraints: ConstraintRows<T>,
    /// The velocity with which the bias of constraints after the step is found.
    next_v: Vec<T>,
    /// τ − h, while forces are looked for.
    pressed: Vec<T>,
    /// Points that take part.
    working: WorkingSet<T>,
    /// Axes of each of them (normal, tangent, tangent) in the world.
    axes: Vec<[Vector3<T>; ROWS]>,
    rows: Rows<T>,
    /// Which ends of joints the first rows after those of constraints are, and in which direction they push.
    stops: Vec<(usize, f64)>,
    solver: ConeSolver<T>,
    certificate: Certificate,
    /// The worst of each lane since [`forget`](Self::forget).
    statuses: Vec<Status>,
}

/// Inputs of [`ConstrainedScratch::solve`].
pub(super) struct Question<'a, P, T: Scalar> {
    pub(super) simulator: &'a Simulator<P>,
    pub(super) state: &'a State<T>,
    /// Joint forces, without stops where they are those at the end of the step.
    pub(super) tau: &'a [T],
    /// Of external forces and frame actuators on each body, in the body; empty for none.
    pub(super) external: &'a [Force<T>],
    pub(super) at_end: AtEnd,
}

impl<P: Scalar, T: Over<P>> Question<'_, P, T> {
    fn model(&self) -> &Model<P> {
        self.simulator.model()
    }

    fn motion(&self) -> (&[T], &[T]) {
        (self.state.q.as_slice(), self.state.v.as_slice())
    }

    /// Contacts whose forces the solver finds.
    fn solved_contacts(&self) -> Option<&Contacts<P>> {
        self.simulator.solved_contacts(self.at_end)
    }

    /// Dampers C and springs K of the joints act with the velocity at the end of the step, v + Δt a:
    /// (M + Δt C + Δt² K) a = τ − h − Δt K v.
    fn stiffen(&self, mass: &mut DMatrix<T>, forces: &mut [T]) {
        let (dt, (_, v)) = (self.simulator.time_step(), self.motion());
        self.simulator.each_resistance(v, |k, damping, stiffness| {
            let spring = stiffness * dt;
            mass[(k, k)] += (damping + spring) * dt;
            forces[k] -= spring * v[k];
        });
    }

    /// κ of smoothed contact, N·m/s²; 0 for the exact law.
    fn kappa(&self) -> f64 {
        let (contacts, dt) = (self.simulator.contacts(), self.simulator.time_step());
        contacts.map_or(0.0, |contacts| contacts.kappa_over_step(dt))
    }
}

/// The velocity after a step, along the axes of before it.
fn step_velocity_into<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    (v, a): (&[T], &[T]),
    dt: f64,
    next_v: &mut [T],
) {
    for body in model.independent() {
        let own = v_range(body);
        let motion = (&v[own.clone()], &a[own.clone()]);
        body.joint.step_velocity(motion, dt, &mut next_v[own]);
    }
}

impl<T: Scalar> ConstrainedScratch<T> {
    pub(super) fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
        let (model, nv) = (simulator.model(), simulator.model().nv());
        let points = simulator.contacts().map_or(0, |c| c.points().len());
        let given = simulator.contacts().map(Contacts::solver_options);
        let given = given.unwrap_or_default();
        // Lanes that touch with more points than that in all allocate, once.
        let n = points.min(given.points);
        let held = simulator.held_rows();
        let rows = held + nv + ROWS * n;
        let blocks = simulator.constraints().len() + nv + n;
        let options = ConeOptions {
            smoothed: Smoothed::Cones,
            measured: false,
            ..given.cone()
        };
        Self {
            crba: CrbaScratch::new(model),
            rnea: RneaScratch::new(model),
            factor: MassMatrixFactor::new(model, &DMatrix::identity(nv, nv)),
            constraints: ConstraintRows::new(held, nv),
            next_v: Vec::with_capacity(nv),
            pressed: Vec::with_capacity(nv),
            working: WorkingSet::new(points, nv),
            axes: Vec::with_capacity(n),
            rows: Rows::new(nv, rows, blocks),
            stops: Vec::with_capacity(2 * nv),
            solver: ConeSolver::new(rows, blocks).with_options(options),
            certificate: Certificate::default(),
            statuses: vec![Status::default(); T::LANES],
        }
    }

    /// The ends of joints that took part in the last solution: the coordinate, and the direction in which its stop pushes.
    pub(crate) fn stops(&self) -> &[(usize, f64)] {
        &self.stops
    }

    /// The points that took part in the last solution.
    pub(crate) fn touching(&self) -> impl Iterator<Item = usize> {
        self.working.active().iter().copied()
    }

    /// The factors of M, with what is implicit in the step.
    pub(crate) fn factor(&self) -> &MassMatrixFactor<T> {
        &self.factor
    }

    /// The pose of each body in its parent.
    pub(crate) fn placements(&self) -> &[Transform<T>] {
        self.rnea.motions().0
    }

    /// The rows of the last solution.
    pub(crate) fn rows(&self) -> &Rows<T> {
        &self.rows
    }

    /// The solver, with the last solution.
    pub(crate) fn solver_mut(&mut self) -> &mut ConeSolver<T> {
        &mut self.solver
    }

    /// From now on, solutions are measured and told apart by their modes.
    pub(super) fn measure(&mut self) {
        self.solver.options.measured = true;
    }

    /// Certificate of the last solution.
    pub(super) fn certificate(&self) -> Certificate {
        self.certificate
    }

    /// Starts a new step.
    pub(super) fn forget(&mut self) {
        self.statuses.fill(Status::default());
    }

    /// Status of the worst solution of a step, in a lane.
    pub(super) fn status(&self, lane: usize) -> Status {
        self.statuses[lane]
    }

    /// The forces of constraints in the last solution, row after row.
    pub(super) fn constraint_forces(&self) -> &[T] {
        self.rows.first_forces(self.constraints.rows.len())
    }

    /// The points that took part in the last solution, with their modes in the first lane.
    pub(super) fn modes(&self) -> impl Iterator<Item = (usize, Mode)> {
        let points = self.working.active().len();
        let blocks = self.rows.blocks();
        let modes = &self.solver.modes()[blocks.saturating_sub(points)..blocks];
        self.touching().zip(modes.iter().copied())
    }

    /// The acceleration at a state; forces on points go to `contact`. Velocity forces may be those of the middle of a step.
    pub(super) fn solve<P: Scalar>(
        &mut self,
        question: &Question<'_, P, T>,
        mut middle: Option<(&mut Gyroscopic<T>, T)>,
        contact: &mut ContactScratch<T>,
        a: &mut [T],
    ) where
        T: Over<P>,
    {
        let at = question;
        let constraints = at.simulator.constraints();
        self.constraints
            .evaluate(at.model(), constraints, at.motion());
        self.press_freely(at, &mut middle, contact, a);
        self.rows.clear();
        self.stops.clear();
        self.working.clear();
        self.axes.clear();
        self.hold(at, middle.map(|(gyroscopic, _)| &gyroscopic.a[..]));
        if at.at_end.has_joints() {
            self.stop(at);
        }
        if let Some(contacts) = at.solved_contacts() {
            self.solve_contacts(at, contacts, contact, a);
        } else {
            self.rows.respond(&self.factor, a);
            self.find_forces(at, a);
        }
        let statuses = self.statuses.iter_mut().zip(self.solver.statuses());
        statuses.for_each(|(worst, &status)| *worst = (*worst).max(status));
        if self.working.is_full() {
            let limit = Status::IterationLimit;
            self.certificate.status = self.certificate.status.max(limit);
            let all = self.statuses.iter_mut();
            all.for_each(|worst| *worst = (*worst).max(limit));
        }
    }

    /// The acceleration with the forces of points, of which as many take part as have to; before, τ − h.
    fn solve_contacts<P: Scalar>(
        &mut self,
        at: &Question<'_, P, T>,
        contacts: &Contacts<P>,
        contact: &mut ContactScratch<T>,
        a: &mut [T],
    ) where
        T: Over<P>,
    {
        self.pressed.clear();
        self.pressed.extend_from_slice(a);
        let margin = contacts.activation_margin(at.simulator.time_step());
        let points = contact.points.iter().enumerate();
        let inside = points.filter(|(_, point)| margin.contains(point));
        let inside = inside.map(|(i, point)| (i, margin.distance_inside(point)));
        self.working.start(inside);
        let some = contacts.use_working_set();
        if some {
            self.factor.solve(a);
            self.add_points(at, contacts, contact, a);
        } else {
            self.working
                .take_all(&contact.points, contacts.solver_options().points);
        }
        let others = self.rows.mark();
        loop {
            self.rows.truncate(others);
            self.touch(at, contacts, contact);
            self.rows.respond(&self.factor, &self.pressed);
            self.ask(at, contacts, contact);
            self.find_forces(at, a);
            if !some || !self.add_points(at, contacts, contact, a) {
                break;
            }
        }
        self.report(at, contacts, contact);
    }

    /// Lets points take part that an acceleration would leave slower than their law allows; whether there are any.
    fn add_points<P: Scalar>(
        &mut self,
        at: &Question<'_, P, T>,
        contacts: &Contacts<P>,
        contact: &ContactScratch<T>,
        a: &[T],
    ) -> bool
    where
        T: Over<P>,
    {
        let step = StepKinematics {
            model: at.model(),
            contacts,
            kinematics: &contact.kinematics,
            points: &contact.points,
            v: at.motion().1,
            dt: at.simulator.time_step(),
        };
        self.working.grow(&step, a)
    }

    /// The forces of the rows, and the acceleration with them.
    fn find_forces<P: Scalar>(&mut self, at: &Question<'_, P, T>, a: &mut [T])
    where
        T: Over<P>,
    {
        self.offset(at);
        let law = (at.simulator.contacts()).map_or(Law::Coulomb, Contacts::cone);
        self.solver.options.smoothing = at.kappa();
        self.certificate = self.rows.solve(law, &mut self.solver);
        self.rows.accelerations(&self.factor, a);
    }

    /// τ − h, and the factors of M.
    fn press_freely<P: Scalar>(
        &mut self,
        at: &Question<'_, P, T>,
        middle: &mut Option<(&mut Gyroscopic<T>, T)>,
        contact: &mut ContactScratch<T>,
        forces: &mut [T],
    ) where
        T: Over<P>,
    {
        let (model, (q, v)) = (at.model(), at.motion());
        let solved = at.solved_contacts();
        let external = match at.simulator.contacts() {
            Some(contacts) if solved.is_none() => {
                contact.add_explicit_forces(model, contacts, at.state, at.external);
                contact.external.as_slice()
            }
            _ => at.external,
        };
        bias_forces_into(model, q, v, external, &mut self.rnea, forces);
        let motions = self.rnea.motions();
        if let Some(contacts) = solved {
            contact.kinematics.place(model, motions);
            let duration = at.simulator.contact_duration();
            contacts.states_over_step_into(&contact.kinematics, duration, &mut contact.points);
        }
        let balance = forces.iter_mut().zip(at.tau);
        balance.for_each(|(force, &tau)| *force = tau - *force);
        let (dt, constraints) = (at.simulator.time_step(), &self.constraints);
        let rows = constraints.rows.iter();
        let wanted = rows.map(|row| -(row.over_step(row.bias, dt) + row.turning));
        self.factor.refactor_filled(|mass| {
            mass_matrix_of_placed_into(model, motions.0, &mut self.crba, mass);
            if let Some((gyroscopic, _)) = middle {
                gyroscopic.differentiate(model, (q, v), mass);
            }
            if at.at_end.has_joints() {
                at.stiffen(mass, forces);
            }
            if let Some((gyroscopic, half_step)) = middle {
                let held = (&constraints.jacobian[..], wanted);
                gyroscopic.solve(mass, *half_step, forces, held);
                gyroscopic.correct(*half_step, forces);
            }
        });
    }

    /// The rows of kinematic constraints, y = J ã − wanted: at a moment, or over a step from the acceleration that would be without other rows.
    fn hold<P: Scalar>(&mut self, at: &Question<'_, P, T>, a: Option<&[T]>)
    where
        T: Over<P>,
    {
        let (constraints, dt) = (at.simulator.constraints(), at.simulator.time_step());
        let own = self.rows.grow(self.constraints.rows.len());
        own.copy_from_slice(&self.constraints.jacobian);
        for constraint in constraints {
            let block = Block::Free(constraint.rows());
            self.rows.push_block(block, T::zero());
        }
        let Some(a) = a else {
            for row in &self.constraints.rows {
                self.rows.push_wanted(-row.at_moment(dt), T::zero());
            }
            return;
        };
        let (model, (q, v)) = (at.model(), at.motion());
        self.next_v.clear();
        self.next_v.resize(v.len(), T::zero());
        step_velocity_into(model, (v, a), dt, &mut self.next_v);
        self.constraints
            .look_ahead(model, constraints, (q, &self.next_v));
        for (r, row) in self.constraints.rows.iter().enumerate() {
            let bias = row.over_step(self.constraints.bias_after(r), dt);
            self.rows.push_wanted(-bias, T::zero());
        }
    }

    /// A row for each joint beyond an end, or that would be after the step: its stop pushes, with the force at the end of the step.
    fn stop<P: Scalar>(&mut self, at: &Question<'_, P, T>)
    where
        T: Over<P>,
    {
        let dt = at.simulator.time_step();
        let (_, v) = at.motion();
        let (rows, stops) = (&mut self.rows, &mut self.stops);
        at.simulator.each_end(at.state.q.as_slice(), |k, end| {
            let away = v[k] * end.inward;
            let near = |lane| end.depth.value(lane) + (-dt * away.value(lane)).max(0.0) > 0.0;
            if (0..T::LANES).any(near) {
                let row = end.stop.row(end.depth, away, dt);
                stops.push((k, end.inward));
                rows.push_unit(k, end.inward);
                rows.push_wanted(row.reference, row.compliance);
                rows.push_block(Block::Ray, T::zero());
            }
        });
    }

    /// J of the points that take part.
    fn touch<P: Scalar>(
        &mut self,
        at: &Question<'_, P, T>,
        contacts: &Contacts<P>,
        contact: &ContactScratch<T>,
    ) where
        T: Over<P>,
    {
        let (model, nv) = (at.model(), at.model().nv());
        self.axes.clear();
        for &i in self.working.active() {
            let point = &contact.points[i];
            let axes = point.axes();
            let own = self.rows.grow(ROWS);
            let at = BodyPoint {
                body: Some(contacts.points()[i].body),
                in_body: &point.in_body,
            };
            each_jacobian_column(model, &contact.kinematics, at, |k, column| {
                for (row, axis) in axes.iter().enumerate() {
                    own[row * nv + k] += dot(axis, &column);
                }
            });
            self.axes.push(axes);
        }
    }

    /// Adds the reference accelerations and regularisation that the laws give to the active points.
    fn ask<P: Scalar>(
        &mut self,
        at: &Question<'_, P, T>,
        contacts: &Contacts<P>,
        contact: &ContactScratch<T>,
    ) where
        T: Over<P>,
    {
        let first = self.rows.asked();
        let (bristles, _) = at.state.contact.as_slice().as_chunks::<ROWS>();
        for (of, (&i, axes)) in self.working.active().iter().zip(&self.axes).enumerate() {
            let kinematics = PointKinematics {
                state: &contact.points[i],
                axes,
                deflection: bristles.get(i).map(|&m| Vector3::from(m)),
                delassus: self.rows.mobility(first + ROWS * of),
                dt: at.simulator.time_step(),
                kappa: at.kappa(),
            };
            let mut own = contacts.rows(i, &kinematics);
            if T::LANES > 1 {
                own = own.within(self.working.takes_part(of));
            }
            for row in own.rows {
                self.rows.push_wanted(row.reference, row.compliance);
            }
            self.rows.push_block(Block::Cone, own.friction);
        }
    }

    /// J `ã_free` − wanted: rows see the velocity of a step, which takes the turning of the axes in which floating and planar joints have
    /// their linear velocity into account, ω × v.
    fn offset<P: Scalar>(&mut self, at: &Question<'_, P, T>)
    where
        T: Over<P>,
    {
        let (_, v) = at.motion();
        for body in at.model().independent() {
            let own = v_range(body);
            let rows = &mut self.rows;
            body.joint.turning(&v[own.clone()], |k, x| {
                rows.turn(own.start + k, x);
            });
        }
        self.rows.subtract_wanted();
    }

    /// Forces on points in the world, and how bristles move under them.
    fn report<P: Scalar>(
        &self,
        at: &Question<'_, P, T>,
        contacts: &Contacts<P>,
        contact: &mut ContactScratch<T>,
    ) where
        T: Over<P>,
    {
        contact.forces.fill(Vector3::zeros());
        let (forces, _) = self
            .rows
            .last_forces(ROWS * self.axes.len())
            .as_chunks::<ROWS>();
        for ((&i, axes), f) in self.working.active().iter().zip(&self.axes).zip(forces) {
            let [n, t_1, t_2] = axes;
            contact.forces[i] = scale(n, f[0]) + scale(t_1, f[1]) + scale(t_2, f[2]);
        }
        if contacts.have_bristles() {
            contact.update_bristles(contacts, at.state, at.simulator.time_step());
        }
    }
}
