//! Contribution of contact points to the Jacobians of a step.
//!
//! The rows and the force of a point depend on the pose and the velocity of its body: one evaluation on dual numbers in these directions
//! gives their derivatives, and the joints that carry the body do the rest.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::point::{LinearizedPoint, PointDual};
use super::rows::Contact;
use crate::contact::{Contacts, ROWS};
use crate::dynamics::{Blocks, kinetic_energy_gradient_into};
use crate::model::BodyId;
use crate::scalar::{Differentiable, Linear, Scalar, each};
use crate::sim::balance::Balance;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use crate::sim::terms::chain::Chain;
use crate::sim::terms::columns::RowColumns;
use crate::sim::terms::linear_point::{ForceColumns, LinearPoint, OfCoordinate};
use crate::sim::terms::term::TermDerivatives;
use crate::spatial::{Force, Motion, SPATIAL};

/// Derivatives of the term.
#[derive(Clone, Debug)]
pub(crate) struct ContactColumns<T> {
    /// ∂(m⁺ − m) of all bristles; ∂ṁ at an instant.
    pub(crate) bristles: Blocks<T>,
    chain: Chain<T>,
    /// Whose chain it is: points come link after link.
    body: Option<BodyId>,
    turns: ChainTurns<T>,
    /// M⁻¹ Jᵀ of a row.
    response: Vec<T>,
    momenta: Vec<(Motion<T>, Force<T>)>,
    /// Derivative of the Delassus diagonal of a row in q.
    delassus: Vec<T>,
    /// Bristles of the points that take part in the solution.
    solved: Vec<SolvedBristle<T>>,
}

/// Derivatives of motions of a body in the position of each coordinate of its chain: those at v, at ã, and at a response M⁻¹ Jᵀ.
#[derive(Clone, Debug)]
struct ChainTurns<T> {
    velocity: Vec<Motion<T>>,
    acceleration: Vec<Motion<T>>,
    response: Vec<Motion<T>>,
}

/// The bristle of a point whose force the solver has found.
#[derive(Clone, Debug)]
struct SolvedBristle<T> {
    point: usize,
    /// Row of the normal; those across follow.
    first_row: usize,
    /// Derivative of m⁺ in the forces across.
    by_friction: [Vector3<T>; 2],
}

/// A step with contact that is linearised.
#[derive(Clone, Copy)]
struct ContactStep<'a, T: Scalar> {
    simulator: &'a Simulator,
    state: &'a State<T>,
    contacts: &'a Contacts,
    term: &'a Contact<T>,
    /// See [`Moment`](crate::sim::moment::Moment).
    is_instant: bool,
}

impl<'a, T: Scalar> ContactStep<'a, T> {
    fn new(at: &LinearPoint<'a, T>, term: &'a Contact<T>, contacts: &'a Contacts) -> Self {
        Self {
            simulator: at.moment.simulator,
            state: at.moment.state,
            contacts,
            term,
            is_instant: at.moment.is_instant,
        }
    }
}

/// A contact point that takes part in the solution.
struct ActivePoint<'a, T: Scalar> {
    index: usize,
    /// Row of the normal; those across follow.
    first_row: usize,
    kinematics: &'a LinearizedPoint<'a, f64, T>,
    balance: &'a Balance<T>,
}

/// Columns of what depends on one point: those of the joints that carry its body, and those of its bristle.
struct PointColumns<'a, T> {
    chain: &'a Chain<T>,
    /// See [`ChainTurns::velocity`].
    turns: &'a [Motion<T>],
    nv: usize,
    /// First column of the bristle, if there is one.
    bristle: Option<usize>,
}

impl<T: Differentiable> ContactColumns<T> {
    pub(crate) fn new(simulator: &Simulator) -> Self {
        let (model, nv) = (simulator.model(), simulator.model().nv());
        let points = simulator.contacts().map_or(0, |c| c.points().len());
        let columns = simulator.n_tangent() + simulator.nu();
        let turns = || Vec::with_capacity(model.n_bodies().max(nv));
        Self {
            bristles: Blocks::new(simulator.n_contact(), columns),
            chain: Chain::new(model),
            body: None,
            turns: ChainTurns {
                velocity: turns(),
                acceleration: turns(),
                response: turns(),
            },
            response: vec![T::zero(); nv],
            momenta: vec![(Motion::zero(), Force::zero()); model.n_bodies()],
            delassus: vec![T::zero(); nv],
            solved: Vec::with_capacity(points),
        }
    }

    /// Starts anew without contact.
    fn clear(&mut self) {
        self.bristles.clear();
        self.body = None;
        self.solved.clear();
    }

    /// Adds −∂Jᵀ f to the columns, of contact whose laws give the forces by themselves at the start of the step.
    fn add_explicit_forces(&mut self, step: &ContactStep<'_, T>, forces: &mut ForceColumns<T>) {
        for i in 0..step.contacts.points().len() {
            self.update_chain(step, i, None);
            let Some(own) = self.point(step, i).explicit_force(step.is_instant) else {
                continue;
            };
            let columns = PointColumns::new(&self.chain, &self.turns, step, i);
            columns.add_force(&own.force, forces.columns());
            if step.contacts.have_bristles() {
                self.add_bristle_step(step, i, &own.bristle_step);
            }
            let body = step.contacts.points()[i].body;
            forces.bodies[body.0] += step.term.body_force(step.contacts, i);
        }
    }

    /// Computes ∂y at fixed forces and accelerations of the points whose forces the solver found, and adds −∂Jᵀ f to the columns.
    fn add_solved_rows(
        &mut self,
        step: &ContactStep<'_, T>,
        balance: &Balance<T>,
        rows: &mut RowColumns<T>,
        forces: &mut ForceColumns<T>,
    ) {
        let touching = step.term.touching();
        let mut first_row = balance.rows().count() - ROWS * touching.len();
        let mut active = touching.iter().copied().peekable();
        let bristles = step.contacts.have_bristles();
        for index in 0..step.contacts.points().len() {
            let takes_part = active.next_if_eq(&index).is_some();
            if !takes_part && !bristles {
                continue;
            }
            self.update_chain(step, index, Some(&rows.seen));
            let kinematics = &self.point(step, index);
            let none = [T::zero(); ROWS];
            let mut pushes = &none[..];
            if takes_part {
                pushes = &balance.rows().forces()[first_row..first_row + ROWS];
                let point = ActivePoint {
                    index,
                    first_row,
                    kinematics,
                    balance,
                };
                self.add_point(step, &point, rows, forces);
            }
            if bristles {
                let own = kinematics.bristle_step(pushes);
                self.add_bristle_step(step, index, &own);
                if takes_part {
                    self.solved.push(SolvedBristle {
                        point: index,
                        first_row,
                        by_friction: kinematics.bristle_by_friction(),
                    });
                }
            }
            first_row += if takes_part { ROWS } else { 0 };
        }
    }

    /// Follows the joints that carry a point.
    ///
    /// * `acceleration` – ã, where it is needed
    fn update_chain(
        &mut self,
        step: &ContactStep<'_, T>,
        point: usize,
        acceleration: Option<&[T]>,
    ) {
        let model = step.simulator.model();
        let body = step.contacts.points()[point].body;
        if self.body.replace(body) == Some(body) {
            return;
        }
        self.chain.follow(model, &step.term.kinematics, body);
        let (v, turns) = (step.state.v.as_slice(), &mut self.turns);
        self.chain.turns(v, &mut turns.velocity);
        if let Some(a) = acceleration {
            self.chain.turns(a, &mut turns.acceleration);
        }
    }

    fn point<'a>(&self, step: &ContactStep<'a, T>, index: usize) -> LinearizedPoint<'a, f64, T> {
        let body = Some(step.contacts.points()[index].body);
        let kinematics = &step.term.kinematics;
        let (X_WB, V_B) = (kinematics.pose(body), kinematics.velocity(body));
        LinearizedPoint::new(step.simulator, step.state, index, &X_WB, &V_B)
    }

    /// Rows and force of a point that takes part in the solution.
    fn add_point(
        &mut self,
        step: &ContactStep<'_, T>,
        point: &ActivePoint<'_, T>,
        rows: &mut RowColumns<T>,
        forces: &mut ForceColumns<T>,
    ) {
        let (first, solved) = (point.first_row, point.balance.rows());
        let body = step.contacts.points()[point.index].body;
        let pushes = &solved.forces()[first..first + ROWS];
        let acceleration = self.chain.motion(&rows.seen);
        let y = point
            .kinematics
            .rows(&acceleration, solved.delassus(first), pushes);
        let axes = point.kinematics.unit_forces();
        let own = PointColumns::new(&self.chain, &self.turns, step, point.index);
        for row in 0..ROWS {
            forces.bodies[body.0] += axes[row].scaled(pushes[row]);
            own.add(first + row, &y[row], &mut rows.columns);
            self.add_turning(first + row, &axes[row], rows);
        }
        own.add_force(&point.kinematics.force(pushes), forces.columns());
        if step.contacts.read_delassus() {
            self.differentiate_delassus(step, point, &axes[0]);
            self.add_delassus(point, &y, &forces.resistance, rows);
        }
    }

    /// Adds to a row J ã what J changes as the joints move on.
    fn add_turning(&self, row: usize, axis: &Force<T>, rows: &mut RowColumns<T>) {
        let turns = self.chain.coordinates.iter().zip(&self.turns.acceleration);
        for (&(k, _), turn) in turns {
            *rows.columns.at(row, k) += turn.power(axis);
        }
    }

    /// Adds to the rows of a point what their compliance changes with the Delassus diagonal, in q and, by dampers in M, in v.
    fn add_delassus(
        &self,
        point: &ActivePoint<'_, T>,
        y: &[PointDual<T>; ROWS],
        resistance: &[OfCoordinate<T>],
        rows: &mut RowColumns<T>,
    ) {
        let nv = self.response.len();
        for (row, y) in (point.first_row..).zip(y) {
            for (k, &x) in self.delassus.iter().enumerate() {
                *rows.columns.at(row, k) += y.by_delassus() * x;
            }
            let damped = resistance.iter().zip(&self.response);
            for (k, (resistance, &s)) in damped.enumerate() {
                let change = -s * s * resistance.eps[1];
                *rows.columns.at(row, nv + k) += y.by_delassus() * change;
            }
        }
    }

    /// Adds to ∂(m⁺ − m) of one bristle what it changes by itself, at fixed forces of the solver.
    fn add_bristle_step(
        &mut self,
        step: &ContactStep<'_, T>,
        point: usize,
        x: &[PointDual<T>; ROWS],
    ) {
        let own = PointColumns::new(&self.chain, &self.turns, step, point);
        for (row, x) in (ROWS * point..).zip(x) {
            own.add(row, x, &mut self.bristles);
        }
    }

    /// ∂(J M⁻¹ Jᵀ) of the normal row of a point and itself: with its response s,  2 δJ s − sᵀ δM s; the part of dampers in M is not in it.
    fn differentiate_delassus(
        &mut self,
        step: &ContactStep<'_, T>,
        point: &ActivePoint<'_, T>,
        normal: &Force<T>,
    ) {
        let balance = point.balance;
        let half = balance.rows().half(point.first_row);
        let response = self.response.iter_mut().zip(half);
        response.for_each(|(s, x)| *s = x);
        balance.factor().forward_substitute(&mut self.response);
        kinetic_energy_gradient_into(
            step.simulator.model(),
            balance.motions().0,
            &self.response,
            &mut self.momenta,
            &mut self.delassus,
        );
        self.delassus.iter_mut().for_each(|x| *x = *x * -2.0);
        let along = point
            .kinematics
            .along_normal(&self.chain.motion(&self.response));
        let turns = &mut self.turns.response;
        self.chain.turns(&self.response, turns);
        for (&(k, S), turn) in self.chain.coordinates.iter().zip(turns) {
            self.delassus[k] += (along.by_pose(&S) + turn.power(normal)) * 2.0;
        }
    }
}

impl<T: Differentiable> TermDerivatives<T> for ContactColumns<T> {
    type Term = Contact<T>;

    fn add_forces(
        &mut self,
        at: &LinearPoint<'_, T>,
        term: &Contact<T>,
        forces: &mut ForceColumns<T>,
    ) {
        self.clear();
        if let Some(contacts) = at.moment.explicit_contacts() {
            self.add_explicit_forces(&ContactStep::new(at, term, contacts), forces);
        }
    }

    fn add_rows(
        &mut self,
        at: &LinearPoint<'_, T>,
        term: &Contact<T>,
        rows: &mut RowColumns<T>,
        forces: &mut ForceColumns<T>,
    ) {
        if let Some((contacts, balance)) = at.moment.solved_contacts().zip(at.balance) {
            let step = ContactStep::new(at, term, contacts);
            self.add_solved_rows(&step, balance, rows, forces);
        }
    }

    /// Adds to ∂(m⁺ − m) of the bristles the part by the forces of a solution, whose derivatives are known.
    fn accept(&mut self, rows: &RowColumns<T>) {
        for (bristles, f) in self.bristles.blocks_mut().zip(rows.columns.blocks()) {
            for solved in &self.solved {
                let (first, by_friction) = (solved.first_row, &solved.by_friction);
                for row in 0..ROWS {
                    let own = &mut bristles[ROWS * solved.point + row];
                    *own = f[first + 1].times_plus(by_friction[0][row], *own);
                    *own = f[first + 2].times_plus(by_friction[1][row], *own);
                }
            }
        }
    }
}

impl<'a, T: Scalar> PointColumns<'a, T> {
    fn new(
        chain: &'a Chain<T>,
        turns: &'a ChainTurns<T>,
        step: &ContactStep<'_, T>,
        point: usize,
    ) -> Self {
        let (nv, bristles) = (step.simulator.model().nv(), step.contacts.have_bristles());
        Self {
            chain,
            turns: &turns.velocity,
            nv,
            bristle: bristles.then_some(2 * nv + ROWS * point),
        }
    }

    /// Adds the derivatives of a number to a row.
    fn add(&self, row: usize, x: &PointDual<T>, out: &mut Blocks<T>) {
        for (&(k, S), turn) in self.chain.coordinates.iter().zip(self.turns) {
            *out.at(row, k) += x.by_pose(&S) + x.by_velocity(turn);
            *out.at(row, self.nv + k) += x.by_velocity(&S);
        }
        if let Some(first) = self.bristle {
            for (j, slope) in x.by_bristle().into_iter().enumerate() {
                *out.at(row, first + j) += slope;
            }
        }
    }

    /// Adds −∂(Jᵀ F) at fixed J: forces follow pose and velocity of the body, and the bristle; that J follows the pose is the part of inverse
    /// dynamics.
    fn add_force(&self, force: &[PointDual<T>; SPATIAL], out: &mut Blocks<T>) {
        let mut add = |column: usize, change: [T; SPATIAL]| {
            let change = Force::from_array(change);
            for (k, S) in &self.chain.coordinates {
                *out.at(*k, column) -= S.power(&change);
            }
        };
        for (&(l, S), turn) in self.chain.coordinates.iter().zip(self.turns) {
            let by_q = each(|k| force[k].by_pose(&S) + force[k].by_velocity(turn));
            add(l, by_q);
            add(self.nv + l, each(|k| force[k].by_velocity(&S)));
        }
        if let Some(first) = self.bristle {
            for j in 0..ROWS {
                add(first + j, each(|k| force[k].by_bristle()[j]));
            }
        }
    }
}
