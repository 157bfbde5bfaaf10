//! Contribution of contact points to the gradient of a step.
//!
//! As in the Jacobians, one evaluation on dual numbers in pose and velocity of the body gives the derivatives of a point; weighted, they are a
//! force on the body that the common sweep carries to the world.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::point::{LinearizedPoint, PointDual};
use super::rows::Contact;
use crate::contact::{ContactLaw, Contacts, PointState, ROWS, body_force};
use crate::dynamics::{Slopes, Sweep, Weighted};
use crate::model::Model;
use crate::scalar::Dual;
use crate::sim::balance::Balance;
use crate::sim::moment::Moment;
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
}

impl ContactAdjoint {
    pub(crate) fn new(simulator: &Simulator) -> Self {
        let contacts = simulator.contacts();
        let read = contacts.is_some_and(Contacts::read_delassus) && simulator.needs_solver();
        Self {
            delassus: read.then(|| Box::new(DelassusAdjoint::new(simulator))),
            by_resistance: vec![0.0; simulator.model().nv()],
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
            let pushes = &balance.rows().forces()[row..row + ROWS];
            let own = point(at, term, contacts, i)
                .bristle_step(pushes)
                .by_friction;
            let weights = &by_contact[ROWS * i..ROWS * (i + 1)];
            for (k, slopes) in own.iter().enumerate() {
                let sum: f64 = slopes.iter().zip(weights).map(|(x, w)| x * w).sum();
                by_force[row + 1 + k] += sum;
            }
        }
    }

    /// Rows and force of a point that takes part in the solution.
    fn add_active(
        &mut self,
        at: &AdjointPoint<'_>,
        here: &ActivePoint<'_>,
        sweep: &mut Sweep<f64>,
        out: &mut StepSlopes<'_>,
    ) -> PointDual {
        let (row, index, kinematics) = (here.row, here.body, here.kinematics);
        let solved = here.rows.balance.rows();
        let (pushes, weights) = (&solved.forces()[row..row + ROWS], &here.rows.y[row..]);
        let weights = &weights[..ROWS];
        let seen = &mut sweep.seen[index];
        let y = kinematics.rows(&seen.U, solved.delassus(row), pushes);
        let axes = kinematics.unit_forces();
        for (axis, &weight) in axes.iter().zip(weights) {
            seen.by_U += axis.scaled(weight);
        }
        let minus_W = sweep.bodies[index].W.to_array().map(|x| -x);
        let y = PointDual::weighted(&y, weights);
        let force = PointDual::weighted(&kinematics.force(pushes), &minus_W);
        if let Some(delassus) = &mut self.delassus {
            let weight = y.by_delassus();
            if weight != 0.0 {
                delassus.add(at, here, weight, &axes[0], out);
                let squares = self.by_resistance.iter_mut().zip(&delassus.response);
                squares.for_each(|(sum, s)| *sum -= weight * s * s);
            }
        }
        y.plus(&force)
    }
}

/// A contact point that takes part in the solution.
struct ActivePoint<'a> {
    kinematics: &'a LinearizedPoint<'a>,
    rows: RowWeights<'a>,
    /// Row of the normal; those across follow.
    row: usize,
    /// Index of its body.
    body: usize,
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

    fn add(
        &mut self,
        at: &AdjointPoint<'_>,
        here: &ActivePoint<'_>,
        weight: f64,
        normal: &Force<f64>,
        out: &mut StepSlopes<'_>,
    ) {
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
        let along = here.kinematics.along_normal(&body.W).in_pose();
        body.by_pose += along.scaled(-2.0);
        let mut slopes = Slopes {
            q: &mut *out.q,
            v: &mut self.by_v,
            a: &mut self.by_a,
            parameters: &mut *out.parameters,
        };
        self.sweep.finish(model, &weighted, &mut slopes);
        self.external[here.body] = Force::zero();
    }
}

/// A number with its derivative in the friction of a point.
type OfFriction = Dual<f64, 1>;

/// A law over its friction.
fn over_friction(law: &ContactLaw) -> ContactLaw<OfFriction> {
    let mut law = law.cast::<OfFriction>();
    law.friction_mut().eps[0] = 1.0;
    law
}

/// The friction that solvers see.
fn bounded(law: &ContactLaw) -> OfFriction {
    over_friction(law).bounded_friction()
}

/// Derivative in the friction of a point of −W · F of its force on a body, and of the weighted change of its bristle.
fn explicit_friction(
    at: &AdjointPoint<'_>,
    term: &Contact<f64>,
    contacts: &Contacts,
    i: usize,
    W: &Motion<f64>,
) -> f64 {
    let lift = |x: &Vector3<f64>| x.map(OfFriction::from);
    let (state, moment) = (&term.points[i], at.moment);
    let lifted = PointState {
        position: lift(&state.position),
        velocity: lift(&state.velocity),
        normal: lift(&state.normal),
        depth: state.depth.into(),
        in_body: lift(&state.in_body),
    };
    let bristles = moment.state.contact.as_slice().as_chunks::<ROWS>().0;
    let deflection = bristles.get(i).map_or_else(Vector3::zeros, |&m| m.into());
    let law = over_friction(&contacts.laws()[i]);
    let Some(own) = law.explicit_force(&lifted, &lift(&deflection)) else {
        return 0.0;
    };
    let rotation = term.kinematics.pose_of(contacts.points()[i].body).rotation;
    let force = body_force(&rotation, &state.in_body, &own.force.map(|x| x.eps[0]));
    let step = if moment.is_instant {
        own.bristle.deflection
    } else {
        own.bristle.step(moment.dt())
    };
    let weights = at.by_contact.iter().skip(ROWS * i);
    let products = step.iter().zip(weights).map(|(x, w)| x.eps[0] * w);
    products.sum::<f64>() - W.power(&force)
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
        for (i, place) in contacts.points().iter().enumerate() {
            let point = point(at.moment, term, contacts, i);
            let Some(own) = point.explicit_force(at.moment.is_instant) else {
                continue;
            };
            let W = sweep.bodies[place.body.0].W;
            if let Some(friction) = out.friction.get_mut(i) {
                *friction += explicit_friction(at, term, contacts, i, &W);
            }
            let W = W.to_array();
            let mut sum = PointDual::weighted(&own.force, &W.map(|x| -x));
            if let Some(weights) = at.by_contact.get(ROWS * i..ROWS * (i + 1)) {
                sum = sum.plus(&PointDual::weighted(&own.bristle_step, weights));
            }
            add_point(i, &sum, contacts, sweep, out);
        }
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
        let solved = rows.balance.rows();
        let mut row = solved.count() - ROWS * term.touching().len();
        let mut active = term.touching().iter().copied().peekable();
        let (bristles, mut of) = (contacts.have_bristles(), 0);
        for (index, place) in contacts.points().iter().enumerate() {
            let takes_part = active.next_if_eq(&index).is_some();
            if !takes_part && !bristles {
                continue;
            }
            let kinematics = &point(at.moment, term, contacts, index);
            let mut pushes = &[0.0; ROWS][..];
            let mut sum = PointDual::zero();
            if takes_part {
                pushes = &solved.forces()[row..row + ROWS];
                let body = place.body.0;
                let here = ActivePoint {
                    kinematics,
                    rows,
                    row,
                    body,
                };
                sum = self.add_active(at, &here, sweep, out);
                row += ROWS;
                let block = solved.blocks() - term.touching().len() + of;
                if let Some(&slope) = rows.friction.get(block) {
                    out.friction[index] += slope * bounded(&contacts.laws()[index]).eps[0];
                }
                of += 1;
            }
            if let Some(weights) = at.by_contact.get(ROWS * index..ROWS * (index + 1)) {
                let step = kinematics.bristle_step(pushes).step;
                sum = sum.plus(&PointDual::weighted(&step, weights));
            }
            add_point(index, &sum, contacts, sweep, out);
        }
    }
}
