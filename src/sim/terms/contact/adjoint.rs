//! Contribution of contact points to the gradient of a step.
//!
//! As in the Jacobians, one evaluation on dual numbers in pose and velocity of the body gives the derivatives of a point; weighted, they are a
//! force on the body that the common sweep carries to the world. The same evaluation over the numbers of point, law and ground gives the gradient in
//! these.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::over_numbers::{OverNumbers, PointPlace};
use super::point::{LinearizedPoint, Number, PointDual};
use super::rows::Contact;
use crate::contact::{Contacts, ROWS};
use crate::dynamics::{Slopes, Sweep, Weighted};
use crate::model::Model;
use crate::scalar::{Over, Scalar};
use crate::sim::balance::Balance;
use crate::sim::moment::Moment;
use crate::sim::parameter_slots::PartSlots;
use crate::sim::simulator::Simulator;
use crate::sim::terms::adjoint::{AdjointPoint, RowWeights, StepSlopes, TermAdjoint};
use crate::spatial::{Force, Motion};

/// The gradient of the term.
#[derive(Clone, Debug)]
pub(crate) struct ContactAdjoint {
    /// For laws that know the Delassus diagonal.
    delassus: Option<Box<DelassusAdjoint>>,
    /// Weights of what stands beside M.
    pub(crate) by_resistance: Vec<f64>,
    numbers: Option<Box<OverNumbers>>,
    slots: PartSlots,
}

impl ContactAdjoint {
    pub(crate) fn new(simulator: &Simulator) -> Self {
        let contacts = simulator.contacts();
        let read = contacts.is_some_and(Contacts::read_delassus) && simulator.needs_solver();
        Self {
            delassus: read.then(|| Box::new(DelassusAdjoint::new(simulator))),
            by_resistance: vec![0.0; simulator.model().nv()],
            numbers: contacts.map(OverNumbers::new),
            slots: PartSlots::new(simulator),
        }
    }

    /// The contacts over their numbers, where the gradient in these is wanted; to be given back.
    fn take_numbers(
        &mut self,
        contacts: &Contacts,
        out: &StepSlopes<'_>,
    ) -> Option<Box<OverNumbers>> {
        if !out.has_parts {
            return None;
        }
        let own = self.numbers.take();
        let own = own.filter(|own| own.are_of(contacts));
        Some(own.unwrap_or_else(|| OverNumbers::new(contacts)))
    }

    /// Gives them back.
    fn return_numbers(&mut self, numbers: Option<Box<OverNumbers>>, out: &mut StepSlopes<'_>) {
        if let Some(mut numbers) = numbers {
            numbers.finish(&self.slots, out.parameters);
            self.numbers = Some(numbers);
        }
    }

    /// Adds the forces that the solver found on points to those on bodies.
    pub(crate) fn add_body_forces(
        at: &Moment<'_, f64, f64>,
        term: &Contact<f64>,
        bodies: &mut [Force<f64>],
    ) {
        let Some(contacts) = at.solved_contacts() else {
            return;
        };
        for &i in term.touching() {
            bodies[contacts.points()[i].body.0] += term.body_force(contacts, i);
        }
    }

    /// Adds to the weights of the forces of rows those of the changes of bristles that follow from them.
    pub(crate) fn add_bristle_weights(
        at: &Moment<'_, f64, f64>,
        term: &Contact<f64>,
        balance: &Balance<f64>,
        by_contact: &[f64],
        by_force: &mut [f64],
    ) {
        let Some(contacts) = at.solved_contacts().filter(|c| c.have_bristles()) else {
            return;
        };
        let first = balance.rows().count() - ROWS * term.touching().len();
        for (of, &i) in term.touching().iter().enumerate() {
            let row = first + ROWS * of;
            let own = point(at, term, contacts, i).bristle_by_friction();
            let weights = &by_contact[ROWS * i..ROWS * (i + 1)];
            for (k, slopes) in own.iter().enumerate() {
                let sum: f64 = slopes.iter().zip(weights).map(|(x, w)| x * w).sum();
                by_force[row + 1 + k] += sum;
            }
        }
    }

    /// Rows and force of a point that takes part in the solution. Returns their weighted sum, and the motion of its body along whose normal the weighted
    /// Delassus diagonal looks, if it counts.
    fn add_active(
        &mut self,
        at: &AdjointPoint<'_>,
        here: &ActivePoint<'_>,
        sweep: &mut Sweep<f64>,
        out: &mut StepSlopes<'_>,
    ) -> (PointDual, Option<Motion<f64>>) {
        let seen = &mut sweep.seen[here.body];
        let y = here.weighted_rows(here.kinematics, &seen.U);
        let axes = here.kinematics.unit_forces();
        for (axis, &weight) in axes.iter().zip(here.weights()) {
            seen.by_U += axis.scaled(weight);
        }
        let (weight, mut along) = (y.by_delassus(), None);
        if let Some(delassus) = self.delassus.as_mut().filter(|_| weight != 0.0) {
            along = Some(delassus.add(at, here, weight, &axes[0], out));
            let squares = self.by_resistance.iter_mut().zip(&delassus.response);
            squares.for_each(|(sum, s)| *sum -= weight * s * s);
        }
        let W = sweep.bodies[here.body].W;
        (y.plus(&here.weighted_force(here.kinematics, &W)), along)
    }
}

/// A contact point that takes part in the solution.
struct ActivePoint<'a> {
    kinematics: &'a LinearizedPoint<'a>,
    rows: RowWeights<'a>,
    /// Row of the normal; those across follow.
    row: usize,
    block: usize,
    /// Index of its body.
    body: usize,
}

impl ActivePoint<'_> {
    fn forces(&self) -> &[f64] {
        &self.rows.balance.rows().forces()[self.row..self.row + ROWS]
    }

    fn weights(&self) -> &[f64] {
        &self.rows.y[self.row..self.row + ROWS]
    }

    /// `λ_y`ᵀ y of its rows, on a body that moves with Ã.
    fn weighted_rows<P: Scalar>(&self, on: &LinearizedPoint<'_, P>, A_B: &Motion<f64>) -> PointDual
    where
        Number: Over<P>,
    {
        let delassus = self.rows.balance.rows().delassus(self.row);
        PointDual::weighted(&on.rows(A_B, delassus, self.forces()), self.weights())
    }

    /// −W · F of its force.
    fn weighted_force<P: Scalar>(&self, on: &LinearizedPoint<'_, P>, W: &Motion<f64>) -> PointDual
    where
        Number: Over<P>,
    {
        PointDual::weighted(&on.force(self.forces()), &W.to_array().map(|x| -x))
    }

    /// All that is weighted of it, over its numbers.
    ///
    /// * `along` – see [`ContactAdjoint::add_active`]
    fn weighted(
        &self,
        on: &LinearizedPoint<'_, Number>,
        U: &Motion<f64>,
        W: &Motion<f64>,
        along: Option<&Motion<f64>>,
    ) -> PointDual {
        let mut sum = self.weighted_rows(on, U).plus(&self.weighted_force(on, W));
        if let Some(&slope) = self.rows.friction.get(self.block) {
            sum = sum.plus(&on.friction().scaled(slope));
        }
        match along {
            None => sum,
            Some(V) => sum.plus(&on.along_normal(V).scaled(DelassusAdjoint::ALONG)),
        }
    }
}

/// Gradient of the Delassus diagonal d = n M⁻¹ nᵀ of a normal row n: with the response s = M⁻¹ nᵀ,  δd = 2 δn s − sᵀ δM s, which is that of
/// inverse dynamics at rest with the acceleration s and the weights −s, under twice the unit force, where nothing has weight.
#[derive(Clone, Debug)]
struct DelassusAdjoint {
    weightless: Model,
    sweep: Sweep<f64>,
    /// s.
    response: Vec<f64>,
    mu: Vec<f64>,
    rest: Vec<f64>,
    /// Results that are of no use.
    by_v: Vec<f64>,
    by_a: Vec<f64>,
    external: Vec<Force<f64>>,
}

impl DelassusAdjoint {
    /// Weight of the velocity along the normal: δd has δn twice.
    const ALONG: f64 = -2.0;

    fn new(simulator: &Simulator) -> Self {
        let model = simulator.model();
        let (zeros, mut sweep) = (|| vec![0.0; model.nv()], Sweep::new(model));
        sweep.slots.gravity = None;
        Self {
            weightless: model.clone().with_gravity(Vector3::zeros()),
            sweep,
            response: zeros(),
            mu: zeros(),
            rest: zeros(),
            by_v: zeros(),
            by_a: zeros(),
            external: vec![Force::zero(); model.n_bodies()],
        }
    }

    /// Returns the weighted motion of the body at the rates s.
    fn add(
        &mut self,
        at: &AdjointPoint<'_>,
        here: &ActivePoint<'_>,
        weight: f64,
        normal: &Force<f64>,
        out: &mut StepSlopes<'_>,
    ) -> Motion<f64> {
        let (model, balance) = (&self.weightless, here.rows.balance);
        let half = balance.rows().half(here.row);
        let response = self.response.iter_mut().zip(half);
        response.for_each(|(s, x)| *s = x);
        balance.factor().forward_substitute(&mut self.response);
        for (mu, s) in self.mu.iter_mut().zip(&self.response) {
            *mu = -weight * s;
        }
        self.external[here.body] = normal.scaled(2.0);
        let weighted = Weighted {
            q: at.moment.q(),
            v: &self.rest,
            a: &self.response,
            mu: &self.mu,
            external: &self.external,
        };
        self.sweep.start(model, &weighted);
        let body = &mut self.sweep.bodies[here.body];
        // W = −weight · (motion at the rates s)
        let W = body.W;
        let along = here.kinematics.along_normal(&W).in_pose();
        body.by_pose += along.scaled(Self::ALONG);
        let mut slopes = Slopes {
            q: &mut *out.q,
            v: &mut self.by_v,
            a: &mut self.by_a,
            parameters: &mut *out.parameters,
        };
        self.sweep.finish(model, &weighted, &mut slopes);
        self.external[here.body] = Force::zero();
        W
    }
}

/// −W · F of the force that a law gives by itself, and the weighted change of its bristle; `None` where only a solver finds it.
fn weighted_explicit<P: Scalar>(
    on: &LinearizedPoint<'_, P>,
    at: &AdjointPoint<'_>,
    index: usize,
    W: &Motion<f64>,
) -> Option<PointDual>
where
    Number: Over<P>,
{
    let own = on.explicit_force(at.moment.is_instant)?;
    let mut sum = PointDual::weighted(&own.force, &W.to_array().map(|x| -x));
    if let Some(weights) = at.by_contact.get(ROWS * index..ROWS * (index + 1)) {
        sum = sum.plus(&PointDual::weighted(&own.bristle_step, weights));
    }
    Some(sum)
}

/// A point on dual numbers.
fn point<'a>(
    at: &Moment<'a, f64, f64>,
    term: &Contact<f64>,
    contacts: &Contacts,
    i: usize,
) -> LinearizedPoint<'a> {
    let id = Some(contacts.points()[i].body);
    let (X_WB, V_B) = (term.kinematics.pose(id), term.kinematics.velocity(id));
    LinearizedPoint::new(at.simulator, at.state, i, &X_WB, &V_B)
}

/// Adds the derivatives of a number of a point to those of its body and of its bristle.
fn add_point(
    point: usize,
    x: &PointDual,
    contacts: &Contacts,
    sweep: &mut Sweep<f64>,
    out: &mut StepSlopes<'_>,
) {
    let body = &mut sweep.bodies[contacts.points()[point].body.0];
    body.by_pose += x.in_pose();
    body.by_V += x.in_velocity();
    if contacts.have_bristles() {
        let own = &mut out.contact[ROWS * point..ROWS * (point + 1)];
        own.iter_mut()
            .zip(x.by_bristle())
            .for_each(|(own, x)| *own += x);
    }
}

impl TermAdjoint for ContactAdjoint {
    type Term = Contact<f64>;

    fn add_forces(
        &mut self,
        at: &AdjointPoint<'_>,
        term: &Contact<f64>,
        sweep: &mut Sweep<f64>,
        out: &mut StepSlopes<'_>,
    ) {
        let Some(contacts) = at.moment.explicit_contacts() else {
            return;
        };
        let mut numbers = self.take_numbers(contacts, out);
        for (i, place) in contacts.points().iter().enumerate() {
            let W = sweep.bodies[place.body.0].W;
            let point = point(at.moment, term, contacts, i);
            let Some(sum) = weighted_explicit(&point, at, i, &W) else {
                continue;
            };
            add_point(i, &sum, contacts, sweep, out);
            if let Some(numbers) = &mut numbers {
                let place = PointPlace::of(&point, at.moment, term);
                let sum = |on: &LinearizedPoint<'_, Number>| {
                    weighted_explicit(on, at, i, &W).unwrap_or_else(PointDual::zero)
                };
                numbers.add(&place, &sum, &self.slots, out.parameters);
            }
        }
        self.return_numbers(numbers, out);
    }

    fn add_rows(
        &mut self,
        at: &AdjointPoint<'_>,
        term: &Contact<f64>,
        sweep: &mut Sweep<f64>,
        out: &mut StepSlopes<'_>,
    ) {
        self.by_resistance.fill(0.0);
        let Some((contacts, rows)) = at.moment.solved_contacts().zip(at.rows) else {
            return;
        };
        let mut numbers = self.take_numbers(contacts, out);
        let solved = rows.balance.rows();
        let mut row = solved.count() - ROWS * term.touching().len();
        let mut block = solved.blocks() - term.touching().len();
        let mut touching = term.touching().iter().copied().peekable();
        for (index, place) in contacts.points().iter().enumerate() {
            let takes_part = touching.next_if_eq(&index).is_some();
            if !takes_part && !contacts.have_bristles() {
                continue;
            }
            let kinematics = &point(at.moment, term, contacts, index);
            let active = takes_part.then_some(ActivePoint {
                kinematics,
                rows,
                row,
                block,
                body: place.body.0,
            });
            let (mut sum, mut along) = (PointDual::zero(), None);
            if let Some(active) = &active {
                (sum, along) = self.add_active(at, active, sweep, out);
                (row, block) = (row + ROWS, block + 1);
            }
            let pushes = active
                .as_ref()
                .map_or(&[0.0; ROWS][..], ActivePoint::forces);
            let weights = at.by_contact.get(ROWS * index..ROWS * (index + 1));
            if let Some(weights) = weights {
                let step = kinematics.bristle_step(pushes);
                sum = sum.plus(&PointDual::weighted(&step, weights));
            }
            if let Some(numbers) = &mut numbers {
                let W = sweep.bodies[place.body.0].W;
                let U = sweep.seen[place.body.0].U;
                let all = |on: &LinearizedPoint<'_, Number>| {
                    let mut sum = PointDual::zero();
                    if let Some(active) = &active {
                        sum = active.weighted(on, &U, &W, along.as_ref());
                    }
                    if let Some(weights) = weights {
                        sum = sum.plus(&PointDual::weighted(&on.bristle_step(pushes), weights));
                    }
                    sum
                };
                let place = PointPlace::of(kinematics, at.moment, term);
                numbers.add(&place, &all, &self.slots, out.parameters);
            }
            add_point(index, &sum, contacts, sweep, out);
        }
        self.return_numbers(numbers, out);
    }
}
