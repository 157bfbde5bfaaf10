//! Contribution of contact points to the gradient of a step.
//!
//! As in the Jacobians, one evaluation on dual numbers in pose and velocity of the body gives the derivatives of a point; weighted, they are a
//! force on the body that the common sweep carries to the world. The same evaluation over the numbers of point, law and ground gives the gradient in
//! these.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::over_numbers::{OverNumbers, PointPlace};
use super::point::{LinearizedPoint, Number, PointDual};
use super::rows::Contact;
use crate::contact::{Contacts, ROWS};
use crate::dynamics::{EnergySlopes, EnergySweep, Pushed, Rates, Sweep};
use crate::linalg::product::dot;
use crate::model::BodyId;
use crate::scalar::{Over, Scalar};
use crate::sim::balance::Balance;
use crate::sim::moment::Moment;
use crate::sim::parameter_slots::PartSlots;
use crate::sim::simulator::Simulator;
use crate::sim::terms::adjoint::{AdjointPoint, RowWeights, StepSlopes, TermAdjoint};
use crate::spatial::{Force, Motion};

/// The gradient of the term.
#[derive(Clone, Debug)]
pub(crate) struct ContactAdjoint<T: Scalar> {
    /// For laws that know the Delassus diagonal.
    delassus: Option<Box<DelassusAdjoint<T>>>,
    /// Weights of what stands beside M.
    pub(crate) by_resistance: Vec<T>,
    numbers: Option<Box<OverNumbers<T>>>,
    slots: PartSlots,
}

impl<T: Scalar> ContactAdjoint<T> {
    pub(crate) fn new(simulator: &Simulator) -> Self {
        let contacts = simulator.contacts();
        let read = contacts.is_some_and(Contacts::read_delassus) && simulator.needs_solver();
        Self {
            delassus: read.then(|| Box::new(DelassusAdjoint::new(simulator))),
            by_resistance: vec![T::zero(); simulator.model().nv()],
            numbers: contacts.map(OverNumbers::new),
            slots: PartSlots::new(simulator),
        }
    }

    /// The contacts over their numbers, where the gradient in these is wanted; to be given back.
    fn take_numbers(
        &mut self,
        contacts: &Contacts,
        out: &StepSlopes<'_, T>,
    ) -> Option<Box<OverNumbers<T>>> {
        if !out.has_parts {
            return None;
        }
        let own = self.numbers.take();
        let own = own.filter(|own| own.are_of(contacts));
        Some(own.unwrap_or_else(|| OverNumbers::new(contacts)))
    }

    /// Gives them back.
    fn return_numbers(
        &mut self,
        numbers: Option<Box<OverNumbers<T>>>,
        out: &mut StepSlopes<'_, T>,
    ) {
        if let Some(mut numbers) = numbers {
            numbers.finish(&self.slots, out.parameters);
            self.numbers = Some(numbers);
        }
    }

    /// Adds the forces that the solver found on points to those on bodies.
    pub(crate) fn add_body_forces(
        at: &Moment<'_, f64, T>,
        term: &Contact<T>,
        bodies: &mut [Force<T>],
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
        at: &Moment<'_, f64, T>,
        term: &Contact<T>,
        balance: &Balance<T>,
        by_contact: &[T],
        by_force: &mut [T],
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
                by_force[row + 1 + k] += dot(slopes.as_slice(), weights);
            }
        }
    }

    /// Rows and force of a point that takes part in the solution. Returns their weighted sum, and the motion of its body along whose normal the weighted
    /// Delassus diagonal looks, if it counts.
    fn add_active(
        &mut self,
        at: &AdjointPoint<'_, T>,
        here: &ActivePoint<'_, T>,
        sweep: &mut Sweep<T>,
        out: &mut StepSlopes<'_, T>,
    ) -> (PointDual<T>, Option<Motion<T>>) {
        let seen = &mut sweep.seen[here.body];
        let y = here.weighted_rows(here.kinematics, &seen.U);
        let axes = here.kinematics.unit_forces();
        for (axis, &weight) in axes.iter().zip(here.weights()) {
            seen.by_U += axis.scaled(weight);
        }
        let (weight, mut along) = (y.by_delassus(), None);
        if let Some(delassus) = self.delassus.as_mut().filter(|_| !weight.is_zero()) {
            along = Some(delassus.add(at, here, weight, &axes[0], sweep, out));
            let squares = self.by_resistance.iter_mut().zip(&delassus.response);
            squares.for_each(|(sum, &s)| *sum -= weight * s * s);
        }
        let W = sweep.bodies[here.body].W;
        (y.plus(&here.weighted_force(here.kinematics, &W)), along)
    }
}

/// A contact point that takes part in the solution.
struct ActivePoint<'a, T: Scalar> {
    kinematics: &'a LinearizedPoint<'a, f64, T>,
    rows: RowWeights<'a, T>,
    /// Row of the normal; those across follow.
    row: usize,
    block: usize,
    /// Index of its body.
    body: usize,
}

impl<T: Scalar> ActivePoint<'_, T> {
    fn forces(&self) -> &[T] {
        &self.rows.balance.rows().forces()[self.row..self.row + ROWS]
    }

    fn weights(&self) -> &[T] {
        &self.rows.y[self.row..self.row + ROWS]
    }

    /// `λ_y`ᵀ y of its rows, on a body that moves with Ã.
    fn weighted_rows<P: Scalar>(
        &self,
        on: &LinearizedPoint<'_, P, T>,
        A_B: &Motion<T>,
    ) -> PointDual<T>
    where
        Number<T>: Over<P>,
    {
        let delassus = self.rows.balance.rows().delassus(self.row);
        PointDual::weighted(&on.rows(A_B, delassus, self.forces()), self.weights())
    }

    /// −W · F of its force.
    fn weighted_force<P: Scalar>(
        &self,
        on: &LinearizedPoint<'_, P, T>,
        W: &Motion<T>,
    ) -> PointDual<T>
    where
        Number<T>: Over<P>,
    {
        PointDual::weighted(&on.force(self.forces()), &W.to_array().map(|x| -x))
    }

    /// All that is weighted of it, over its numbers.
    ///
    /// * `along` – see [`ContactAdjoint::add_active`]
    fn weighted(
        &self,
        on: &LinearizedPoint<'_, Number<T>, T>,
        U: &Motion<T>,
        W: &Motion<T>,
        along: Option<&Motion<T>>,
    ) -> PointDual<T> {
        let mut sum = self.weighted_rows(on, U).plus(&self.weighted_force(on, W));
        if let Some(&slope) = self.rows.friction.get(self.block) {
            sum = sum.plus(&on.friction().scaled(slope));
        }
        match along {
            None => sum,
            Some(V) => sum.plus(&on.along_normal(V).scaled(T::constant(ALONG))),
        }
    }
}

/// Gradient of the Delassus diagonal d = n M⁻¹ nᵀ of a normal row n: with the response s = M⁻¹ nᵀ,  δd = 2 δn s − sᵀ δM s, twice that of the force n · s
/// less the kinetic energy at the rates s.
#[derive(Clone, Debug)]
struct DelassusAdjoint<T: Scalar> {
    energy: EnergySweep<T>,
    /// s.
    response: Vec<T>,
}

/// Slope of d in that energy, and so of the velocity along the normal.
const ALONG: f64 = -2.0;

impl<T: Scalar> DelassusAdjoint<T> {
    fn new(simulator: &Simulator) -> Self {
        let model = simulator.model();
        Self {
            energy: EnergySweep::new(model),
            response: vec![T::zero(); model.nv()],
        }
    }

    /// Returns the motion of the body at the rates s, times −weight.
    ///
    /// * `sweep` – after its pass outward
    fn add(
        &mut self,
        at: &AdjointPoint<'_, T>,
        here: &ActivePoint<'_, T>,
        weight: T,
        normal: &Force<T>,
        sweep: &Sweep<T>,
        out: &mut StepSlopes<'_, T>,
    ) -> Motion<T> {
        let (model, balance, body) = (at.moment.model(), here.rows.balance, BodyId(here.body));
        let half = balance.rows().half(here.row);
        let response = self.response.iter_mut().zip(half);
        response.for_each(|(s, x)| *s = x);
        balance.factor().forward_substitute(&mut self.response);
        let V = self.energy.start(model, sweep, &self.response, body);
        let pushed = Pushed {
            body,
            force: *normal,
            by_pose: here.kinematics.along_normal(&V).in_pose(),
        };
        let rates = Rates {
            q: at.moment.q(),
            v: &self.response,
        };
        let mut slopes = EnergySlopes {
            q: &mut *out.q,
            parameters: &mut *out.parameters,
        };
        let weight_of_energy = weight * T::constant(ALONG);
        (self.energy).finish(model, sweep, &rates, &pushed, weight_of_energy, &mut slopes);
        V * -weight
    }
}

/// −W · F of the force that a law gives by itself, and the weighted change of its bristle; `None` where only a solver finds it.
fn weighted_explicit<P: Scalar, T: Scalar>(
    on: &LinearizedPoint<'_, P, T>,
    at: &AdjointPoint<'_, T>,
    index: usize,
    W: &Motion<T>,
) -> Option<PointDual<T>>
where
    Number<T>: Over<P>,
{
    let own = on.explicit_force(at.moment.is_instant)?;
    let mut sum = PointDual::weighted(&own.force, &W.to_array().map(|x| -x));
    if let Some(weights) = at.by_contact.get(ROWS * index..ROWS * (index + 1)) {
        sum = sum.plus(&PointDual::weighted(&own.bristle_step, weights));
    }
    Some(sum)
}

/// A point on dual numbers.
fn point<'a, T: Scalar>(
    at: &Moment<'a, f64, T>,
    term: &Contact<T>,
    contacts: &Contacts,
    i: usize,
) -> LinearizedPoint<'a, f64, T> {
    let id = Some(contacts.points()[i].body);
    let (X_WB, V_B) = (term.kinematics.pose(id), term.kinematics.velocity(id));
    LinearizedPoint::new(at.simulator, at.state, i, &X_WB, &V_B)
}

/// Adds the derivatives of a number of a point to those of its body and of its bristle.
fn add_point<T: Scalar>(
    point: usize,
    x: &PointDual<T>,
    contacts: &Contacts,
    sweep: &mut Sweep<T>,
    out: &mut StepSlopes<'_, T>,
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

impl<T: Scalar> TermAdjoint<T> for ContactAdjoint<T> {
    type Term = Contact<T>;

    fn add_forces(
        &mut self,
        at: &AdjointPoint<'_, T>,
        term: &Contact<T>,
        sweep: &mut Sweep<T>,
        out: &mut StepSlopes<'_, T>,
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
                let sum = |on: &LinearizedPoint<'_, Number<T>, T>| {
                    weighted_explicit(on, at, i, &W).unwrap_or_else(PointDual::zero)
                };
                numbers.add(&place, &sum, &self.slots, out.parameters);
            }
        }
        self.return_numbers(numbers, out);
    }

    fn add_rows(
        &mut self,
        at: &AdjointPoint<'_, T>,
        term: &Contact<T>,
        sweep: &mut Sweep<T>,
        out: &mut StepSlopes<'_, T>,
    ) {
        self.by_resistance.fill(T::zero());
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
            let none = [T::zero(); ROWS];
            let pushes = active.as_ref().map_or(&none[..], ActivePoint::forces);
            let weights = at.by_contact.get(ROWS * index..ROWS * (index + 1));
            if let Some(weights) = weights {
                let step = kinematics.bristle_step(pushes);
                sum = sum.plus(&PointDual::weighted(&step, weights));
            }
            if let Some(numbers) = &mut numbers {
                let W = sweep.bodies[place.body.0].W;
                let U = sweep.seen[place.body.0].U;
                let all = |on: &LinearizedPoint<'_, Number<T>, T>| {
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
