//! Activation margin: the height above the ground up to which points of a robot take part in a step.

use super::simulator::Simulator;
use crate::contact::{ContactLaw, Contacts, PointState};
use crate::scalar::Scalar;
use crate::spatial::linear::dot;

/// Acceleration towards the ground that a point may gain within a step and still be noticed, m/s².
const HASTE: f64 = 1e3;

impl<P: Scalar> Simulator<P> {
    /// Time after which the deeper side of a fold of the ground is the one that is touched, s: a step where a solver finds forces for it, and none
    /// where they are those of its start.
    pub(crate) fn contact_ahead(&self) -> f64 {
        let solved = |contacts: &&Contacts<P>| self.at_end().has_contact() || !contacts.are_soft();
        let contacts = self.contacts().filter(solved);
        contacts.map_or(0.0, |_| self.time_step())
    }
}

/// Up to which height points take part.
#[derive(Clone, Copy, Debug)]
pub(super) struct Horizon {
    /// The time in which a point may come down, s.
    ahead: f64,
    /// The velocity that it may gain until then, m/s.
    haste: f64,
    /// The height up to which it takes part in any case, m.
    reach: f64,
}

impl Horizon {
    /// That of contacts in a step of `dt` (s): points that are below the ground, or would be after the step where contact acts over it, or
    /// that a smoothed law reaches. Too many points do no harm.
    pub(super) fn new<P: Scalar>(contacts: &Contacts<P>, dt: f64) -> Self {
        let (ahead, haste) = match contacts.laws()[0] {
            ContactLaw::Rigid(_) => (dt, dt * HASTE),
            ContactLaw::Soft(_) => (dt, 0.0),
            ContactLaw::RelaxedRigid(_) => (0.0, 0.0),
        };
        let reach = contacts.smoothing().map_or(0.0, |s| s.reach());
        Self {
            ahead,
            haste,
            reach,
        }
    }

    /// By how much a point is below it, m, in each lane and without derivatives.
    pub(super) fn margin<T: Scalar>(&self, point: &PointState<T>) -> T {
        let closing = -dot(&point.normal, &point.velocity);
        T::from_values(|lane| {
            let exact = self.ahead * (closing.value(lane).max(0.0) + self.haste);
            point.depth.value(lane) + exact.max(self.reach)
        })
    }

    /// Whether a point takes part in some lane.
    pub(super) fn sees<T: Scalar>(&self, point: &PointState<T>) -> bool {
        let margin = self.margin(point);
        (0..T::LANES).any(|lane| margin.value(lane) > 0.0)
    }
}
