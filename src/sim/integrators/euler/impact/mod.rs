//! An Euler step with an isolated impact.
//!
//! Velocities of semi-implicit Euler are those of half a step earlier: under a constant acceleration a, the motion of (q, v + ½ Δt a) is exact. On
//! that motion the gap γ of a point may become zero at a time t within the step. There an impact changes the velocity. With kicks K of the velocity
//! by a, held over the step, and drifts D of the position at constant velocity,
//!
//! > x* = K₍t/2₎ D₍t₎ K₍(Δt + t)/2₎ x₀ with γ(x*) = 0: the motion until then, and its velocity there,
//! > x₂ = I(x*): the impact, by the contact model, a step of the length ε = [`IMPACT_TIME`],
//! > x₃ = K₍−t/2₎ D₍Δt − t − ε₎ K₍(Δt − t)/2₎ x₂: the rest of the step, and again a velocity of half a step earlier.
//!
//! The time t depends on all other quantities by the implicit function theorem, δt = −δγ / γ̇: the jump of the derivatives of these steps is the
//! saltation matrix. In uniform gravity x₃ is continuous in x₀ where an impact moves from one step to the next, and an elastic impact keeps the
//! energy of the exact motion.
//!
//! It applies to a single point that begins to touch in the step, in values; all other contact is handled by the usual step.
//!
//! # References
//! [Hairer, Lubich, Wanner 2006, section VI.3; Leine, Nijmeijer 2004, chapter 7].

mod pullback;

use super::advance;
use crate::cone::Status;
use crate::dynamics::Calls;
use crate::scalar::{Over, Scalar};
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::integrators::AccelerationScratch;
use crate::sim::integrators::kick_drift::Times;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use crate::sim::terms::{Contact, LEAST_SPEED, LoneImpact};
pub(super) use pullback::Adjoint;

/// ε, the duration of an impact, s; all other forces act during it. Far below all time steps, and long enough that a point that arrives at
/// [`LEAST_SPEED`] is distinguished from one at rest.
const IMPACT_TIME: f64 = 1e-6;

/// A point that leaves an impact with less than this multiple of the velocity which forces add in a step would return within a few steps: it is about
/// to come to rest, and whole steps handle it.
const LEAST_FLIGHT: f64 = 2.0;

/// Allowed increase of the largest depth in the step, m; more is a second contact, which whole steps handle.
const DEEPER: f64 = 1e-9;

/// Bisections and secants until the time of an impact is known, and the part of the step to which it is.
const ROUNDS: usize = 60;
const ACCURACY: f64 = 1e-15;

/// Part of the step for the finite difference of the gap: rounding and curvature errors are balanced.
const DIFFERENCE: f64 = 1e-4;

/// Working memory of a step with an impact.
#[derive(Clone, Debug)]
pub(super) struct Impact<T: Scalar> {
    /// After the first drift, x*, x₂, and after the second drift.
    arriving: State<T>,
    touching: State<T>,
    after: State<T>,
    leaving: State<T>,
    /// Evaluation of the impact.
    found: AccelerationScratch<T>,
    /// Contact points at an intermediate state.
    seen: Contact<T>,
    /// t, s.
    time: T,
    /// First row of the point in the impact.
    row: usize,
}

/// The single point that begins to touch in a step, if any.
#[inline]
pub(super) fn lone<P: Scalar, T: Over<P>>(
    at: &EvaluationPoint<'_, P, T>,
    found: &AccelerationScratch<T>,
) -> Option<LoneImpact> {
    if T::LANES > 1 || P::LANES > 1 || !T::HAS_VALUES {
        return None;
    }
    let contacts = at.solved_contacts()?;
    let balance = found.balance.as_deref()?;
    found
        .terms
        .contact
        .lone_impact(contacts, balance, at.dt().value(0))
}

impl<T: Scalar> Impact<T> {
    /// Makes memory for a simulator.
    pub(super) fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
        let state = simulator.neutral_state();
        Self {
            arriving: state.clone(),
            touching: state.clone(),
            leaving: state.clone(),
            after: state,
            found: AccelerationScratch::new(simulator, Calls::Many),
            seen: Contact::new(simulator),
            time: T::zero(),
            row: 0,
        }
    }

    /// Status of the solver of the forces of the impact, in a lane.
    pub(super) fn status(&self, lane: usize) -> Status {
        let balance = self.found.balance.as_ref();
        balance.map_or(Status::Converged, |balance| balance.status(lane))
    }

    /// Takes a step whose evaluation, with the force of the point, is known. Returns `false` if there is no isolated impact: then the evaluation is unchanged.
    ///
    /// * `found` – output, the evaluation without the force of the point
    /// * `next` – output, x₃
    pub(super) fn step<P: Scalar>(
        &mut self,
        at: &EvaluationPoint<'_, P, T>,
        lone: LoneImpact,
        found: &mut AccelerationScratch<T>,
        next: &mut State<T>,
    ) -> bool
    where
        T: Over<P>,
    {
        let (free, contact) = (without_force(at, &lone), &found.terms.contact);
        self.seen.leave_out_as(contact);
        self.found.terms.contact.leave_out_as(contact);
        at.simulator.accelerate(&free, found);
        let a = &found.a;
        let is_found = self.find_time(at, &lone, a) && self.bounce(at, &lone, a, next);
        if !is_found {
            at.simulator.accelerate(at, found);
        }
        is_found
    }

    /// The gap of the point at a time t of the step; `None` if it is out of reach.
    fn gap<P: Scalar>(
        &mut self,
        at: &EvaluationPoint<'_, P, T>,
        lone: &LoneImpact,
        a: &[T],
        t: T,
    ) -> Option<T>
    where
        T: Over<P>,
    {
        let [arrive, ..] = times(at.dt().into(), t);
        arrive.advance(at.model(), at.state, a, &mut self.arriving);
        self.seen.look(at, &self.arriving);
        let k = self.seen.deepest(at.simulator, lone)?;
        Some(-self.seen.points[k].depth)
    }

    /// Finds t; whether there is one.
    fn find_time<P: Scalar>(
        &mut self,
        at: &EvaluationPoint<'_, P, T>,
        lone: &LoneImpact,
        a: &[T],
    ) -> bool
    where
        T: Over<P>,
    {
        let dt = at.dt().value(0);
        let Some(t) = self.bracket(at, lone, a, dt) else {
            return false;
        };
        let mut gap = |t: T| self.gap(at, lone, a, t);
        let step = DIFFERENCE * dt;
        let ends = [t - step, t + step].map(|t| gap(T::constant(t)).map(|gap| gap.value(0)));
        let [Some(before), Some(after)] = ends else {
            return false;
        };
        let slope = (after - before) / (2.0 * step);
        // For numbers with derivatives, each round makes one more order exact.
        let mut time = T::constant(t);
        for _ in 0..T::ORDER + 2 {
            let Some(gap) = gap(time) else { return false };
            time -= gap * slope.recip();
        }
        self.time = time;
        slope < 0.0 && (-IMPACT_TIME..=dt).contains(&time.value(0))
    }

    /// The value of t by the rule of false position, Illinois variant [Dowell, Jarratt 1971].
    fn bracket<P: Scalar>(
        &mut self,
        at: &EvaluationPoint<'_, P, T>,
        lone: &LoneImpact,
        a: &[T],
        dt: f64,
    ) -> Option<f64>
    where
        T: Over<P>,
    {
        let mut gap = |t: f64| Some(self.gap(at, lone, a, T::constant(t))?.value(0));
        // A point may arrive right at the start of the step, where rounding tells on which side it is.
        let (mut inside, mut outside) = ((dt, gap(dt)?), (-IMPACT_TIME, gap(-IMPACT_TIME)?));
        if !(inside.1 < 0.0 && outside.1 > 0.0) {
            return None;
        }
        for _ in 0..ROUNDS {
            let t = (inside.0 * outside.1 - outside.0 * inside.1) / (outside.1 - inside.1);
            let now = (t, gap(t)?);
            let ends = if now.1 < 0.0 {
                (&mut inside, &mut outside)
            } else {
                (&mut outside, &mut inside)
            };
            let moved = (ends.0.0 - t).abs();
            *ends.0 = now;
            ends.1.1 *= 0.5;
            if now.1 == 0.0 || moved < ACCURACY * dt {
                break;
            }
        }
        Some(if inside.1.abs() < outside.1.abs() {
            inside.0
        } else {
            outside.0
        })
    }

    /// The impact and the rest of the step. Returns whether the impact is isolated.
    fn bounce<P: Scalar>(
        &mut self,
        at: &EvaluationPoint<'_, P, T>,
        lone: &LoneImpact,
        a: &[T],
        next: &mut State<T>,
    ) -> bool
    where
        T: Over<P>,
    {
        let model = at.model();
        let [arrive, to_velocity, leave, from_velocity] = times(at.dt().into(), self.time);
        arrive.advance(model, at.state, a, &mut self.arriving);
        to_velocity.advance(model, &self.arriving, a, &mut self.touching);
        if let Some(balance) = &mut self.found.balance {
            balance.forget();
        }
        let duration = P::constant(IMPACT_TIME);
        let point = EvaluationPoint::lasting(at.simulator, &self.touching, at.u, duration);
        at.simulator.accelerate(&point, &mut self.found);
        let contact = &self.found.terms.contact;
        let touching = contact.deepest(at.simulator, lone);
        let Some(row) = touching.and_then(|k| contact.first_row(self.found.balance.as_deref()?, k))
        else {
            return false;
        };
        self.row = row;
        let speed = touching.map_or(0.0, |k| -contact.separation(k));
        let dt = at.dt().value(0);
        let gained = (speed + lone.separation).abs() * dt / (0.5 * dt + self.time.value(0));
        if speed < LEAST_SPEED || speed * lone.restitution < LEAST_FLIGHT * gained {
            return false;
        }
        advance(&point, &self.found, &mut self.after);
        leave.advance(model, &self.after, a, &mut self.leaving);
        from_velocity.advance(model, &self.leaving, a, next);
        self.seen.look(at, next);
        self.seen.largest_depth() <= lone.largest_depth.max(0.0) + DEEPER
    }
}

/// The evaluation of a step without the force of a point.
fn without_force<'a, P: Scalar, T: Over<P>>(
    at: &EvaluationPoint<'a, P, T>,
    lone: &LoneImpact,
) -> EvaluationPoint<'a, P, T> {
    EvaluationPoint {
        left_out: Some(lone.point),
        ..*at
    }
}

/// Times of the motions before the impact and after it, two each, of a step of `dt` with the impact at t.
fn times<T: Scalar>(dt: T, t: T) -> [Times<T>; 4] {
    let still = T::zero();
    [
        Times {
            kick: (dt + t) * 0.5,
            drift: t,
        },
        Times {
            kick: t * 0.5,
            drift: still,
        },
        Times {
            kick: (dt - t) * 0.5,
            drift: dt - t - IMPACT_TIME,
        },
        Times {
            kick: -(t * 0.5),
            drift: still,
        },
    ]
}
