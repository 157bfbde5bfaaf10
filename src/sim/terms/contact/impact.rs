//! A contact point that begins to touch by itself, and where it is at other states.

use super::rows::Contact;
use super::touching::Group;
use crate::contact::Contacts;
use crate::dynamics::forward_kinematics_into;
use crate::scalar::{Over, Scalar};
use crate::sim::balance::Balance;
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use crate::spatial::linear::dot;

/// Gap above which a point is separated, m: far above the rounding that decides on which side a body rests. A nearer point may arrive at the very
/// start of the step.
const APART: f64 = 1e-9;

/// Slowest impact that is found at its time, m/s.
pub(crate) const LEAST_SPEED: f64 = 2e-3;

/// Change of velocity by the force of a point below which there is none, m/s.
const NO_PUSH: f64 = 1e-12;

/// A single contact point that begins to touch within a step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LoneImpact {
    /// Its index among all points.
    pub(crate) point: usize,
    /// The shapes that touch; `None` for a point with the ground.
    shapes: Option<[usize; 2]>,
    /// e.
    pub(crate) restitution: f64,
    /// Velocity along the normal at the start of the step, m/s.
    pub(crate) separation: f64,
    /// Of the deepest of all points at the start of the step, m.
    pub(crate) largest_depth: f64,
}

impl<T: Scalar> Contact<T> {
    /// The only point of a solution that pushes and is apart at the start of the step, if its law leaves a part of the speed of impacts.
    pub(crate) fn lone_impact<P: Scalar>(
        &self,
        contacts: &Contacts<P>,
        balance: &Balance<T>,
        dt: f64,
    ) -> Option<LoneImpact> {
        let is_apart = |&&i: &&usize| {
            let depth = self.points[i].depth.value(0);
            depth < -APART || (depth < APART && self.separation(i) < -LEAST_SPEED)
        };
        // Most steps end here.
        self.touching().iter().find(is_apart)?;
        let pushes = |&(of, _): &(usize, &usize)| {
            let row = self.row_of(balance, of);
            let push = balance.rows().forces()[row] * balance.rows().delassus(row);
            dt * push.value(0) > NO_PUSH
        };
        let all = self.touching().iter().enumerate();
        let mut apart = all.filter(|(_, i)| is_apart(i)).filter(pushes);
        let (_, &point) = apart.next()?;
        if apart.next().is_some() || contacts.smoothing().is_some() {
            return None;
        }
        let touching = self.touching_in(contacts);
        Some(LoneImpact {
            point,
            shapes: touching.pair_point(point).map(|pair| pair.shapes),
            restitution: touching.law(point).restitution()?.value(0),
            separation: self.separation(point),
            largest_depth: self.largest_depth(),
        })
    }

    /// Row of the normal of an active point, by its index.
    fn row_of(&self, balance: &Balance<T>, of: usize) -> usize {
        self.place_of(balance, of).row
    }

    /// Row of the normal of a point; `None` if it takes no part.
    pub(crate) fn first_row(&self, balance: &Balance<T>, point: usize) -> Option<usize> {
        let of = self.touching().binary_search(&point).ok()?;
        Some(self.row_of(balance, of))
    }

    /// Velocity of a point along its normal, m/s.
    pub(crate) fn separation(&self, point: usize) -> f64 {
        let point = &self.points[point];
        dot(&point.normal, &point.velocity).value(0)
    }

    /// Of the deepest point, m.
    pub(crate) fn largest_depth(&self) -> f64 {
        let depths = self.points.iter().map(|point| point.depth.value(0));
        depths.fold(f64::NEG_INFINITY, f64::max)
    }

    /// Finds all points at another state, without rows and forces.
    pub(crate) fn look<P: Scalar>(&mut self, at: &EvaluationPoint<'_, P, T>, state: &State<T>)
    where
        T: Over<P>,
    {
        let Some(contacts) = at.solved_contacts() else {
            return;
        };
        let (q, v) = (state.q.as_slice(), state.v.as_slice());
        forward_kinematics_into(at.model(), q, v, &mut self.kinematics);
        self.find_points(contacts, at.dt(), T::zero());
    }

    /// Finds all points where the bodies are.
    ///
    /// * `duration` – time after which the deeper side of an inner edge of the ground determines the contact, s
    pub(super) fn find_points<P: Scalar>(&mut self, contacts: &Contacts<P>, dt: P, duration: T)
    where
        T: Over<P>,
    {
        self.points.truncate(contacts.points().len());
        contacts.states_over_step_into(&self.kinematics, duration, &mut self.points);
        self.hide_sleeping(contacts);
        let asleep = &self.asleep;
        (self.pairs).find(contacts, &self.kinematics, dt, asleep, &mut self.points);
    }

    /// Place of the point of a lone impact among all points, of bodies the deepest one of the same shapes; `None` if these are not near.
    pub(crate) fn deepest<P: Scalar>(
        &self,
        simulator: &Simulator<P>,
        lone: &LoneImpact,
    ) -> Option<usize> {
        let (contacts, Some(shapes)) = (simulator.contacts()?, lone.shapes) else {
            return Some(lone.point);
        };
        let touching = self.touching_in(contacts);
        let all = contacts.points().len()..self.points.len();
        let own = { all }.filter(|&i| touching.group(i) == Group::Pair(shapes));
        let depth = |&i: &usize| self.points[i].depth.value(0);
        own.max_by(|a, b| depth(a).total_cmp(&depth(b)))
    }
}
