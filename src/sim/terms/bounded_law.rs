//! The law of a bounded joint force: a line in the acceleration of its coordinate within a bound.
//!
//! > τ = Π(p − r a)  with the projection Π on [−b, b]
//!
//! For dry friction the line is vertical; for a servo its slope is given by the gains at the end of the step.

use super::drives::Driven;
use crate::dynamics::{HELD, each_passive, side_of};
use crate::scalar::{Dual, Over, Scalar};
use crate::sim::actuation::Actuator;
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::simulator::Simulator;

/// A coordinate with a bounded force.
#[derive(Clone, Copy, Debug)]
pub(super) struct Site {
    pub(super) coordinate: usize,
    pub(super) kind: Kind,
    /// Index of its position in q, where it has one, and of its input.
    q: Option<usize>,
    pub(super) input: Option<usize>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Friction,
    Servo,
}

/// Law of a bounded force.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line<L> {
    /// p, the force if nothing accelerates.
    pub(super) push: L,
    /// r.
    pub(super) resistance: L,
    /// b.
    pub(super) bound: L,
}

/// A force in a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounded<T> {
    pub(super) line: Line<T>,
    /// Acceleration that brings the coordinate to rest, −v / Δt.
    pub(super) stop: T,
    /// 0 on the line, −1 or 1 at a bound.
    pub(super) piece: T,
}

/// Least resistance of a servo, kg or kg·m²: it moves nothing, and a row has it for a compliance.
const LEAST: f64 = 1e-12;
/// Speed up to which a joint is initially assumed to stick, rad/s or m/s. It changes the number of rounds, not the result.
const SLOW: f64 = 1e-9;
impl Site {
    /// The sites of a simulator.
    pub(super) fn all<P: Scalar>(simulator: &Simulator<P>) -> Vec<Self> {
        let Some(actuation) = simulator.actuation() else {
            return Vec::new();
        };
        let mut sites = Vec::with_capacity(actuation.bounded_forces());
        each_passive(simulator.model(), |coordinate, q, _| {
            let actuator = &actuation.actuators()[coordinate];
            for (kind, is_there) in [
                (Kind::Friction, actuator.exact_friction().is_some()),
                (Kind::Servo, actuator.bounded_servo().is_some()),
            ] {
                if is_there {
                    let input = simulator.actuated().iter().position(|&k| k == coordinate);
                    sites.push(Self {
                        coordinate,
                        kind,
                        q,
                        input,
                    });
                }
            }
        });
        sites
    }

    /// Whether it is friction that holds a joint.
    pub(super) fn holds(&self) -> bool {
        self.kind == Kind::Friction
    }

    /// The coordinate at a point.
    pub(super) fn driven<P: Scalar, T: Over<P>>(
        &self,
        at: &EvaluationPoint<'_, P, T>,
    ) -> Driven<T> {
        Driven {
            q: self.q.map(|q| at.q()[q]),
            v: at.v()[self.coordinate],
            u: self.input.map_or(T::zero(), |input| at.u[input]),
        }
    }

    /// The law over a step.
    pub(super) fn line<A: Scalar, L: Over<A>>(
        &self,
        actuator: &Actuator<A>,
        at: Driven<L>,
        dt: L,
    ) -> Line<L> {
        match self.kind {
            Kind::Friction => {
                let force = actuator.exact_friction().map(|own| own.force);
                Line {
                    push: stop_of(at.v, dt) * HELD,
                    resistance: L::constant(HELD),
                    bound: force.map_or(L::zero(), L::from),
                }
            }
            Kind::Servo => servo_line(actuator, at, dt),
        }
    }
}

/// The law of a servo over a step, counted from the middle of its limits.
pub(super) fn servo_line<A: Scalar, L: Over<A>>(
    actuator: &Actuator<A>,
    at: Driven<L>,
    dt: L,
) -> Line<L> {
    let (push, resistance) = actuator.motor_over_step(at.q, at.v, at.u, dt);
    let (middle, bound) = actuator.band::<L>();
    Line {
        push: push - middle,
        resistance: resistance.max(L::constant(LEAST)),
        bound,
    }
}

/// −v / Δt
fn stop_of<L: Scalar>(v: L, dt: L) -> L {
    -(v / dt)
}

impl<L: Scalar> Line<L> {
    /// Reference acceleration of the row that is the line, and its compliance.
    pub(super) fn row(&self) -> (L, L) {
        let compliance = L::one() / self.resistance;
        (self.push * compliance, compliance)
    }
}

impl<const N: usize, T: Scalar> Line<Dual<T, N>> {
    /// y of the row at a force, R f − reference.
    pub(super) fn at_force(&self, force: T) -> Dual<T, N> {
        let (reference, compliance) = self.row();
        compliance.each(|x| x * force) - reference
    }
}

impl<T: Scalar> Bounded<T> {
    /// A force that is first taken to be where it is if nothing accelerates.
    pub(super) fn new(site: &Site, line: Line<T>, v: T, dt: T) -> Self {
        let (zero, one) = (T::zero(), T::one());
        let piece = match site.kind {
            Kind::Friction => {
                let against = v.select_lt(zero, one, -one);
                v.abs().select_lt(T::constant(SLOW), zero, against)
            }
            Kind::Servo => side_of(line.push, line.bound),
        };
        Self {
            line,
            stop: stop_of(v, dt),
            piece,
        }
    }

    /// One of two numbers, in each lane.
    pub(super) fn select(&self, on_line: T, at_bound: T) -> T {
        let half = T::constant(0.5);
        self.piece.abs().select_lt(half, on_line, at_bound)
    }

    /// p or the force at the bound, and r where that acts.
    pub(super) fn parts(&self) -> [T; 2] {
        let Line {
            push,
            resistance,
            bound,
        } = self.line;
        // An infinite bound is never reached.
        let at_bound = self.select(T::zero(), bound) * self.piece;
        [
            self.select(push, at_bound),
            self.select(resistance, T::zero()),
        ]
    }

    /// Whether it may be on its line, in some lane.
    pub(super) fn may_be_on_line(&self) -> bool {
        !self.piece.has_value() || (0..T::LANES).any(|lane| self.piece.value(lane) == 0.0)
    }

    /// The piece of its law that it is on where it obeys that.
    ///
    /// * `a` – the acceleration of its coordinate
    /// * `force` – the force on its line
    /// * `beyond` – what that may be beyond its bound, as a part of it
    pub(super) fn next(&self, a: T, force: T, beyond: f64) -> T {
        let bound = self.line.bound;
        let from_line = side_of(force, bound * (1.0 + beyond));
        let outward = (self.line.push - self.line.resistance * a) * self.piece;
        self.select(from_line, outward.select_lt(bound, T::zero(), self.piece))
    }
}
