//! The balance of forces with constraint rows: accelerations under kinematic constraints, rigid contact, and forces that are implicit in velocity.
//!
//! With the acceleration `a_free` without the rows, a = `a_free` + M⁻¹ Jᵀ f. In the rows this is y = G f + J `a_free` − reference with
//! G = J M⁻¹ Jᵀ: the problem of [`cone`](crate::cone). The order of rows is: kinematic constraints, joints at their limits and with dry friction, contact points.

use super::bare_mass::BareMass;
use super::evaluation_point::EvaluationPoint;
use super::force_solver::ForceSolver;
use super::forces::Forces;
use super::placed::Placed;
use super::rows::Rows;
use super::simulator::Simulator;
use crate::cone::{Certificate, ConeOptions, Law, Mode, Smoothed, Status};
use crate::contact::{Contacts, ROWS};
use crate::dynamics::{MassMatrixFactor, TreeMatrix};
use crate::model::Model;
use crate::scalar::{Linear, Over, Scalar, is_f64, pairs};
use crate::spatial::{Motion, Transform};

/// Mass matrix, forces, rows, and the solver of their forces.
#[derive(Clone, Debug)]
pub(crate) struct Balance<T: Scalar> {
    placed: Placed<T>,
    factor: MassMatrixFactor<T>,
    /// Where contact models read the Delassus diagonal and there are bounded forces.
    bare: Option<Box<BareMass<T>>>,
    pub(super) rows: Rows<T>,
    solver: ForceSolver<T>,
    certificate: Certificate,
    /// The worst of each lane since [`forget`](Self::forget).
    statuses: Vec<Status>,
}

impl<T: Scalar> Balance<T> {
    pub(super) fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
        let model = simulator.model();
        let points = simulator.contacts().map_or(0, |c| c.points().len());
        let given = simulator.contacts().map(Contacts::solver_options);
        let given = given.unwrap_or_default();
        // Lanes that touch with more points than that in all allocate, once.
        let n = points.min(given.points);
        let of_each = simulator.contacts().map_or(ROWS, Contacts::rows_of_each);
        let rows = simulator.bilateral_rows() + simulator.joint_rows() + of_each * n;
        let blocks = simulator.held_blocks() + simulator.joint_rows() + of_each / 2 * n;
        let options = ConeOptions {
            smoothed: Smoothed::Cones,
            measured: false,
            ..given.cone()
        };
        let reads = simulator.contacts().is_some_and(Contacts::read_delassus);
        let is_bounded = simulator
            .actuation()
            .is_some_and(|own| own.bounded_forces() > 0);
        Self {
            placed: Placed::new(model),
            factor: MassMatrixFactor::unfilled(model),
            // Recorded, bounded forces are never added to M.
            bare: (T::HAS_VALUES && reads && is_bounded).then(|| BareMass::new(model)),
            rows: Rows::new(model, rows, blocks),
            solver: ForceSolver::new(rows, blocks, options),
            certificate: Certificate::default(),
            statuses: vec![Status::default(); T::LANES],
        }
    }

    /// Poses and velocities of all bodies.
    pub(super) fn place<P: Scalar>(&mut self, at: &EvaluationPoint<'_, P, T>)
    where
        T: Over<P>,
    {
        self.placed.place(at);
    }

    /// τ − h of bodies that have been placed.
    pub(super) fn load<P: Scalar>(&mut self, at: &EvaluationPoint<'_, P, T>, forces: &Forces<T>)
    where
        T: Over<P>,
    {
        self.placed.load(at, forces);
    }

    /// Drops the rows of the last solution: there are none now.
    pub(super) fn clear_rows(&mut self) {
        self.rows.clear();
        self.solver.clear();
        self.certificate = Certificate::default();
    }

    /// The factors of M, after a change of it and of τ − h.
    pub(super) fn find_mass<P: Scalar>(
        &mut self,
        model: &Model<P>,
        change: impl FnOnce(&mut TreeMatrix<T>, &mut [T]),
    ) where
        T: Over<P>,
    {
        let placed = &mut self.placed;
        self.factor.refactor_filled(|mass| {
            placed.mass_into(model, mass);
            change(mass, &mut placed.forces);
        });
    }

    /// The factors of M after another change of it and of τ − h, which are written.
    pub(super) fn change_mass(&mut self, write: impl FnOnce(&mut TreeMatrix<T>, &mut [T])) {
        let forces = &mut self.placed.forces;
        self.factor.refactor_filled(|mass| write(mass, forces));
    }

    /// The factors of M without bounded forces, where they are read.
    ///
    /// * `mass` – that matrix; `None` in steps without such forces
    pub(super) fn find_bare_mass(&mut self, mass: Option<&TreeMatrix<T>>) {
        if let Some(bare) = &mut self.bare {
            bare.find(mass);
        }
    }

    /// The Delassus diagonal of a row without bounded forces.
    pub(super) fn bare_delassus(&mut self, row: usize) -> T {
        let bare = self.bare.as_mut();
        let own = bare.and_then(|bare| bare.delassus(&self.rows, row));
        own.unwrap_or_else(|| self.rows.delassus(row))
    }

    /// M⁻¹ nᵀ of a row n without bounded forces, once derivatives are prepared.
    pub(super) fn bare_response_into(&self, row: usize, response: &mut [T]) {
        match self.bare.as_ref().and_then(|bare| bare.factor()) {
            None => {
                for (s, x) in pairs(&mut *response, self.rows.half(row)) {
                    *s = x;
                }
                self.factor.forward_substitute(response);
            }
            Some(factor) => {
                let nv = response.len();
                response.copy_from_slice(&self.rows.first_rows(row + 1)[nv * row..]);
                factor.solve(response);
            }
        }
    }

    /// G = J M⁻¹ Jᵀ of the rows, and J M⁻¹ (τ − h).
    pub(super) fn form_delassus(&mut self) {
        self.rows.form_delassus(&self.factor, &self.placed.forces);
    }

    /// The forces of the rows, and the acceleration with them.
    pub(super) fn solve<P: Scalar>(&mut self, at: &EvaluationPoint<'_, P, T>, a: &mut [T])
    where
        T: Over<P>,
    {
        self.see_turning(at);
        self.smooth(at);
        self.rows.accelerations(&self.factor, a);
    }

    /// The forces of the rows, with the κ of the step. Where the time step is more than a plain number, so is κ, and the solver gets that of a plain step Δt₀:
    /// the laws have no scale of their own but κ, so that with s = √(Δt / Δt₀) the forces s f and the velocities s y obey those with κ / Δt₀.
    fn smooth<P: Scalar>(&mut self, at: &EvaluationPoint<'_, P, T>)
    where
        T: Over<P>,
    {
        let (law, dt) = (law_of(at), at.dt());
        let smoothed = at.simulator.contacts().filter(|c| c.smoothing().is_some());
        let plain = match dt.has_value() {
            true => dt.value(0),
            false => 1.0,
        };
        let kappa = smoothed.and_then(|contacts| contacts.kappa_over_step(plain));
        self.solver.one.options.smoothing = kappa.unwrap_or(0.0);
        let scale = smoothed
            .filter(|_| !is_f64::<P>())
            .map(|_| T::from((dt / plain).sqrt()));
        let (rows, factor, solver) = (&mut self.rows, &self.factor, &mut self.solver);
        self.certificate = match scale {
            Some(scale) => rows.solve_scaled(law, factor, solver, scale),
            None => rows.solve(law, factor, solver),
        };
    }

    /// Readies rows and solver for derivatives.
    pub(crate) fn prepare_slopes<P: Scalar>(&mut self, at: &EvaluationPoint<'_, P, T>)
    where
        T: Over<P>,
    {
        let (law, solver) = (law_of(at), &mut self.solver);
        self.rows.prepare_slopes(law, solver);
    }

    /// Turns weights of the forces of the rows into those of y = J ã − w + R f at fixed forces and accelerations.
    ///
    /// * `by_friction` – output, the weights of the friction, or the bound, of each block; empty if they are not wanted
    pub(crate) fn respond_transposed<P: Scalar>(
        &mut self,
        at: &EvaluationPoint<'_, P, T>,
        weights: &mut [T],
        by_friction: &mut [T],
    ) where
        T: Over<P>,
    {
        let (law, solver) = (law_of(at), &mut self.solver);
        self.rows
            .respond_transposed(law, solver, weights, by_friction);
    }

    /// Turns changes of y = J ã − w + R f at fixed forces into those of the forces, several at once.
    ///
    /// * `memory` – working memory
    pub(crate) fn respond<'x, P: Scalar, S: Linear<T>>(
        &mut self,
        at: &EvaluationPoint<'_, P, T>,
        changes: impl Iterator<Item = &'x mut [S]>,
        memory: &mut Vec<S>,
    ) where
        T: Over<P>,
    {
        let (law, solver) = (law_of(at), &mut self.solver);
        self.rows.respond(law, solver, changes, memory);
    }

    /// Keeps the status of the last solution, if it is the worst of the step.
    pub(super) fn retain_status(&mut self) {
        let statuses = self.statuses.iter_mut().zip(self.solver.statuses());
        statuses.for_each(|(worst, &status)| *worst = (*worst).max(status));
    }

    /// J `ã_free` − reference: rows see the velocity of a step, which takes the turning of the axes in which floating and planar joints have
    /// their linear velocity into account, ω × (v + ω × c).
    fn see_turning<P: Scalar>(&mut self, at: &EvaluationPoint<'_, P, T>)
    where
        T: Over<P>,
    {
        for body in at.model().independent() {
            let rows = &mut self.rows;
            body.turning(at.v(), |k, x| rows.turn(k, x));
        }
        self.rows.subtract_references();
    }

    /// The acceleration without rows.
    pub(super) fn free_acceleration_into(&self, a: &mut Vec<T>) {
        a.clone_from(&self.placed.forces);
        self.factor.solve(a);
    }

    /// The factors of M with the implicit diagonal of the step.
    pub(crate) fn factor(&self) -> &MassMatrixFactor<T> {
        &self.factor
    }

    /// Poses of the bodies in their parents, and their velocities and accelerations, of the state.
    pub(crate) fn motions(&self) -> (&[Transform<T>], &[Motion<T>]) {
        self.placed.motions()
    }

    /// The rows of the last solution.
    pub(crate) fn rows(&self) -> &Rows<T> {
        &self.rows
    }

    /// Measures solutions and tells them apart by their modes from now on.
    pub(super) fn measure(&mut self) {
        self.solver.one.options.measured = true;
    }

    /// Certificate of the last solution.
    pub(super) fn certificate(&self) -> Certificate {
        self.certificate
    }

    /// Modes of the last blocks of the last solution, in the first lane.
    pub(super) fn last_modes(&self, blocks: usize) -> &[Mode] {
        let all = self.rows.blocks();
        &self.solver.modes()[all.saturating_sub(blocks)..all]
    }

    /// Reports that rows were dropped that should take part.
    pub(super) fn report_limit(&mut self) {
        let limit = Status::IterationLimit;
        self.certificate.status = self.certificate.status.max(limit);
        let all = self.statuses.iter_mut();
        all.for_each(|worst| *worst = (*worst).max(limit));
    }

    /// Starts a new step.
    pub(super) fn forget(&mut self) {
        self.statuses.fill(Status::default());
    }

    /// Status of the worst solution of a step, in a lane.
    pub(super) fn status(&self, lane: usize) -> Status {
        self.statuses[lane]
    }
}

/// The law of friction of an instant.
fn law_of<P: Scalar, T: Over<P>>(at: &EvaluationPoint<'_, P, T>) -> Law {
    at.simulator.contacts().map_or(Law::Coulomb, Contacts::cone)
}
