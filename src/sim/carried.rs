//! Transfer of states between worlds, by joint name.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::collections::HashMap;

use super::free_body::is_free;
use super::free_body::{BASE_POSE, write_pose};
use super::simulator::Simulator;
use super::state::State;
use crate::contact::Contacts;
use crate::error::InvalidState;
use crate::model::{BodyId, Joint, Model};
use crate::spatial::SPATIAL;

impl State<f64> {
    /// Transfers the state of a robot or world to another one that shares joints with it, for example a world with other objects.
    ///
    /// Joints of the same name keep configuration and velocity; a body on a floating joint keeps its pose in the world. Joints that `from` does not
    /// have are neutral and at rest, so a free object is where it was added; joints that `to` does not have are dropped. The result has no contact
    /// state, see [`Simulator::carried_state`].
    ///
    /// Cost: O(n); allocates.
    ///
    /// * `from`, `to` – models of this state and of the new one
    ///
    /// # Errors
    /// If this is not a state of `from` ([`check`](Self::check)), or a joint of the same name has another kind, or is a mimic joint in one model only.
    ///
    /// # Examples
    /// ```
    /// use dualbody::model::{Mass, Object, World, samples};
    /// use dualbody::{State, spatial::Transform};
    ///
    /// let mut world = World::default();
    /// world.add(&samples::pendulum(), "left/", &Transform::identity())?;
    /// let before = world.build()?;
    /// world.add_sphere("ball", 0.1, &Object::free(Mass::Kilograms(1.0)))?;
    /// let after = world.build()?;
    /// let state = State::new(&[0.5], &[-2.0]).carried(&before, &after)?;
    /// let pivot = after.joint_q(after.find_joint("left/pivot")?);
    /// assert_eq!((state.q.len(), state.q[pivot.start]), (8, 0.5));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn carried(&self, from: &Model, to: &Model) -> Result<Self, InvalidState> {
        self.check(from)?;
        let mut out = Self::neutral(to);
        if from.has_floating_base() && to.has_floating_base() {
            let (q, v) = (&mut out.q, &mut out.v);
            q.rows_mut(0, BASE_POSE)
                .copy_from(&self.q.rows(0, BASE_POSE));
            v.rows_mut(0, SPATIAL).copy_from(&self.v.rows(0, SPATIAL));
        }
        let joints = from.joints().iter();
        let old: HashMap<&str, &Joint> = joints.map(|joint| (&*joint.name, joint)).collect();
        for joint in to.joints() {
            if let Some(old) = old.get(&*joint.name) {
                out.carry(joint, to, self, old, from)?;
            }
        }
        Ok(out)
    }

    /// Takes over the coordinates of a joint.
    fn carry(
        &mut self,
        joint: &Joint,
        to: &Model,
        before: &Self,
        old: &Joint,
        from: &Model,
    ) -> Result<(), InvalidState> {
        let (body, old_body) = (to.body(joint.body), from.body(old.body));
        let follows = body.coupling.is_some();
        if let Some(reason) = difference(joint, old, [follows, old_body.coupling.is_some()]) {
            let name = joint.name.clone();
            return Err(InvalidState::OtherJoint { name, reason });
        }
        if follows {
            return Ok(());
        }
        // A universal joint has two bodies, with coordinates side by side.
        let first = to.body(BodyId(joint.bodies().start));
        let old_first = from.body(BodyId(old.bodies().start));
        let (nq, nv) = (joint.kind.nq(), joint.kind.nv());
        let (q, v) = (&mut self.q, &mut self.v);
        q.rows_mut(first.q, nq)
            .copy_from(&before.q.rows(old_first.q, nq));
        v.rows_mut(first.v, nv)
            .copy_from(&before.v.rows(old_first.v, nv));
        if is_free(body) && is_free(old_body) && body.placement != old_body.placement {
            let X_WB = old_body.place(before.q.as_slice());
            let q = &mut self.q.as_mut_slice()[body.q..body.q + nq];
            write_pose(q, &(body.placement.inverse() * X_WB));
        }
        Ok(())
    }
}

impl Simulator {
    /// Transfers the state of another simulator to this one: [`State::carried`] with contact state and activations. A link keeps its bristles if it has
    /// the same number of contact points in both simulators; other bristles are straight. An input keeps its activation if it has the same name and the
    /// same number of entries in both; other activations are 0.
    ///
    /// # Errors
    /// As for [`State::carried`].
    ///
    /// # Panics
    /// If the state has another length than the states of `from`.
    pub fn carried_state(&self, from: &Self, state: &State) -> Result<State, InvalidState> {
        from.check(state);
        let out = state.carried(from.model(), self.model())?;
        let mut out = self.state(out.q.as_slice(), out.v.as_slice());
        self.carry_activations(from, state, &mut out);
        if out.contact.is_empty() || state.contact.is_empty() {
            return Ok(out);
        }
        let old = points_of_links(from);
        for (link, points) in points_of_links(self) {
            let Some(old) = old.get(link).filter(|old| old.len() == points.len()) else {
                continue;
            };
            for (&point, &old) in points.iter().zip(old) {
                let bristle = state.contact.fixed_rows::<3>(3 * old);
                out.contact
                    .fixed_rows_mut::<3>(3 * point)
                    .copy_from(&bristle);
            }
        }
        Ok(out)
    }

    /// Takes over the activations of inputs of the same name.
    fn carry_activations(&self, from: &Self, state: &State, out: &mut State) {
        for own in self.activations() {
            let mut all = from.activations().iter();
            let Some(old) = all.find(|old| old.name == own.name) else {
                continue;
            };
            let (old, own) = (old.range(), own.range());
            if old.len() == own.len() {
                let numbers = &state.activation.as_slice()[old];
                out.activation.as_mut_slice()[own].copy_from_slice(numbers);
            }
        }
    }
}

/// Reason why coordinates of a joint cannot be transferred to another one.
fn difference(joint: &Joint, old: &Joint, [follows, followed]: [bool; 2]) -> Option<String> {
    if joint.kind != old.kind {
        return Some(format!("is {} and was {}", joint.kind, old.kind));
    }
    let reason = || "mimics another joint in only one of the two models".to_owned();
    (follows != followed).then(reason)
}

/// Numbers of the contact points on each link.
fn points_of_links(simulator: &Simulator) -> HashMap<&str, Vec<usize>> {
    let points = simulator.contacts().map_or(&[][..], Contacts::points);
    let mut of_links: HashMap<&str, Vec<usize>> = HashMap::new();
    for (k, point) in points.iter().enumerate() {
        let link = &simulator.model().frames()[point.link.0].name;
        of_links.entry(link).or_default().push(k);
    }
    of_links
}
