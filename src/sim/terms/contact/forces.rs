//! Forces of contact: those that follow from the state, those that a solver has found, and what they do to links and bristles.

use nalgebra::Vector3;

use super::places::{Place, last_forces};
use super::rows::Contact;
use crate::cone::Mode;
use crate::contact::{BristleLoad, BristleRate, ContactLaw, Contacts, ROWS};
use crate::dynamics::forward_kinematics_into;
use crate::model::{BodyId, FrameId};
use crate::nested::IntoNested;
use crate::scalar::{MapEach, Over, Scalar};
use crate::sim::balance::Balance;
use crate::sim::evaluation_point::EvaluationPoint;
use crate::spatial::Force;
use crate::spatial::linear::{dot, scale};

impl<T: Scalar> Contact<T> {
    /// First row and block of a point among those of all terms.
    pub(super) fn place_of(&self, balance: &Balance<T>, of: usize) -> Place {
        let (rows, own) = (balance.rows(), self.places.start(of));
        Place {
            row: rows.count() - self.places.end.row + own.row,
            block: rows.blocks() - self.places.end.block + own.block,
        }
    }

    /// The points that had rows in the last solution, with their modes in the first lane.
    pub(crate) fn modes<'a>(
        &'a self,
        balance: &'a Balance<T>,
    ) -> impl Iterator<Item = (usize, Mode)> + 'a {
        let modes = balance.last_modes(self.places.end.block);
        let points = self.touching().iter().copied().enumerate();
        points.map(move |(of, point)| (point, modes[self.places.start(of).block]))
    }

    /// Spatial force of the contact at a point on one of its bodies, in the body frame.
    fn force_on<P: Scalar>(&self, contacts: &Contacts<P>, point: usize, side: usize) -> Force<T> {
        let (force, touching) = (self.forces[point], self.touching_in(contacts));
        let own = touching.force(point, side, &force);
        match self.moments.get(point) {
            None => own,
            Some(moment) => own + touching.couple(point, side, moment),
        }
    }

    /// The law of a point, and the links that touch there: of a point with the ground one, twice.
    pub(crate) fn law_and_links<P: Scalar>(
        &self,
        contacts: &Contacts<P>,
        point: usize,
    ) -> (ContactLaw<P>, [FrameId; 2]) {
        let law = self.touching_in(contacts).law(point);
        (law, self.links(contacts, point))
    }

    /// The links that touch at a point: of a point with the ground one, twice.
    pub(crate) fn links<P: Scalar>(&self, contacts: &Contacts<P>, point: usize) -> [FrameId; 2] {
        match point.checked_sub(contacts.points().len()) {
            None => [contacts.points()[point].link; 2],
            Some(k) => (self.pairs.get(k).shapes).map_each(|k| contacts.shape_link(k)),
        }
    }

    /// Passes each force on a link, on its body and in it, to `each`.
    pub(crate) fn each_force_on<P: Scalar>(
        &self,
        contacts: &Contacts<P>,
        link: FrameId,
        mut each: impl FnMut(Force<T>),
    ) {
        let n = contacts.points().len();
        for i in 0..self.points.len() {
            let links = self.links(contacts, i);
            let sides = if i < n { 1 } else { 2 };
            for side in (0..sides).filter(|&side| links[side] == link) {
                each(self.force_on(contacts, i, side));
            }
        }
    }

    /// Passes each force on a body, in it, to `each`, with the link that it is on; `None` is what is fixed to the world.
    pub(in crate::sim) fn each_force<P: Scalar>(
        &self,
        contacts: &Contacts<P>,
        mut each: impl FnMut(FrameId, Option<BodyId>, Force<T>),
    ) {
        let n = contacts.points().len();
        let touching = self.touching_in(contacts);
        for i in 0..self.points.len() {
            let links = self.links(contacts, i);
            let sides = if i < n { 1 } else { 2 };
            for (side, body) in touching.bodies(i).into_iter().enumerate().take(sides) {
                each(links[side], body, self.force_on(contacts, i, side));
            }
        }
    }

    /// The rates of all numbers of the contact state, in sequence.
    pub(crate) fn rates(&self) -> impl Iterator<Item = T> + '_ {
        let rates = self.rates.iter();
        rates.nested(|BristleRate { deflection: m, .. }| [m.x, m.y, m.z])
    }

    /// Changes of the contact state over a step of Δt.
    pub(crate) fn steps<D: Scalar>(&self, dt: D) -> impl Iterator<Item = T> + '_
    where
        T: Over<D>,
    {
        let rates = self.rates.iter();
        let steps = rates.map(move |rate| rate.step(dt));
        steps.nested(|step| [step.x, step.y, step.z])
    }

    /// Rate of each bristle; empty for laws without.
    pub(super) fn bristle_rates(&self) -> &[BristleRate<T>] {
        &self.rates
    }

    /// Forces of soft contact on points and bodies at a state.
    pub(super) fn push<P: Scalar>(
        &mut self,
        at: &EvaluationPoint<'_, P, T>,
        contacts: &Contacts<P>,
        bodies: &mut [Force<T>],
    ) where
        T: Over<P>,
    {
        forward_kinematics_into(at.model(), at.q(), at.v(), &mut self.kinematics);
        self.points.truncate(contacts.points().len());
        contacts.states_into(&self.kinematics, &mut self.points);
        self.hide_sleeping(contacts);
        let (asleep, dt) = (&self.asleep, P::zero());
        (self.pairs).find(contacts, &self.kinematics, dt, asleep, &mut self.points);
        self.clear_forces(contacts);
        let (bristles, _) = at.state.contact.as_slice().as_chunks::<ROWS>();
        for i in 0..self.points.len() {
            let touching = self.touching_in(contacts);
            let deflection = bristles.get(i).map_or_else(Vector3::zeros, |&m| m.into());
            let own = touching.law(i).explicit_force(&self.points[i], &deflection);
            let Some(own) = own else { continue };
            let turning = touching.turning(i);
            let moment = turning.map(|turning| {
                let normal = &self.points[i].normal;
                turning.explicit_moment(normal, dot(normal, &own.force))
            });
            for (side, body) in touching.bodies(i).into_iter().enumerate() {
                if let Some(body) = body {
                    bodies[body.0] += touching.force(i, side, &own.force);
                    if let Some(moment) = &moment {
                        bodies[body.0] += touching.couple(i, side, moment);
                    }
                }
            }
            self.forces[i] = own.force;
            if let Some(moment) = moment {
                self.moments[i] = moment;
            }
            if let Some(rate) = self.rates.get_mut(i) {
                *rate = own.bristle;
            }
        }
    }

    /// Updates the rates of the bristles over a step at whose end the forces are those that are known.
    pub(super) fn update_bristles<P: Scalar>(
        &mut self,
        at: &EvaluationPoint<'_, P, T>,
        contacts: &Contacts<P>,
    ) where
        T: Over<P>,
    {
        let dt = at.dt();
        let (bristles, _) = at.state.contact.as_slice().as_chunks::<ROWS>();
        for (i, (law, &m)) in contacts.laws().iter().zip(bristles).enumerate() {
            let (at, f) = (&self.points[i], &self.forces[i]);
            let step = law.bristle_step(&BristleLoad {
                depth: at.depth,
                separation: dot(&at.normal, &at.velocity),
                friction: &(f - scale(&at.normal, dot(&at.normal, f))),
                deflection: &Vector3::from(m),
                dt,
            });
            self.rates[i] = BristleRate {
                deflection: scale(&step, T::from(P::one() / dt)),
                relaxation: T::zero(),
            };
        }
    }

    /// No forces, and no moments where there may be some.
    pub(super) fn clear_forces<P: Scalar>(&mut self, contacts: &Contacts<P>) {
        let n = self.points.len();
        self.forces.clear();
        self.forces.resize(n, Vector3::zeros());
        self.moments.clear();
        if contacts.have_turning() {
            self.moments.resize(n, Vector3::zeros());
        }
    }

    /// Takes forces and moments of points from the rows of a solution.
    pub(super) fn take_forces<P: Scalar>(&mut self, contacts: &Contacts<P>, balance: &Balance<T>) {
        self.clear_forces(contacts);
        for (of, &i) in self.working.active().iter().enumerate() {
            let along = |x: &[T], axes: &[Vector3<T>]| {
                let mut parts = axes.iter().zip(x).map(|(axis, &x)| scale(axis, x));
                let first = parts.next().unwrap_or_else(Vector3::zeros);
                parts.fold(first, |sum, part| sum + part)
            };
            let (axes, own) = (&self.axes[of], last_forces(&self.places, balance, of));
            let (force, moment) = (along(&own[..ROWS], axes), &own[ROWS..]);
            let turning = self.touching_in(contacts).turning(i);
            let moment = turning.map(|turning| along(moment, &axes[turning.friction.axes()]));
            self.forces[i] = force;
            if let Some(moment) = moment {
                self.moments[i] = moment;
            }
        }
    }
}
