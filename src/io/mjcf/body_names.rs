//! What is done to all bodies once they are read: their total mass, shapes of pairs, names for those without.

use std::collections::HashSet;

use super::body::Bodies;
use super::documents::Source;
use super::option::Acting;
use crate::error::LoadError;
use crate::io::names::Names;
use crate::nested::IntoNested;

impl Bodies {
    /// Scales all masses to the sum that is requested.
    pub(super) fn balance(&mut self, main: &Source<'_>) -> Result<(), LoadError> {
        let wanted = main.compiler.settotalmass;
        let total: f64 = self.entries.iter().map(|body| body.inertia.mass).sum();
        if wanted <= 0.0 || total <= 0.0 {
            return Ok(());
        }
        for body in &mut self.entries {
            body.inertia = body.inertia.scaled(wanted / total);
        }
        Ok(())
    }

    /// Takes limits and dry friction from joints where flags disable them.
    pub(super) fn let_act(&mut self, acting: Acting) {
        let joints = self.entries.iter_mut().nested(|body| &mut body.joints);
        for joint in joints {
            if !acting.limit {
                joint.axis.limits.lower = None;
                joint.axis.limits.upper = None;
            }
            if !acting.friction {
                joint.axis.friction = 0.0;
            }
        }
    }

    /// Lets shapes touch that pairs name.
    pub(super) fn pair(&mut self, names: &HashSet<&str>) {
        for body in &mut self.entries {
            for (collision, contact) in std::mem::take(&mut body.idle) {
                let is_paired = contact
                    .name
                    .as_deref()
                    .is_some_and(|own| names.contains(own));
                if is_paired {
                    body.collisions.push(collision);
                    body.contacts.push(contact);
                }
            }
        }
    }

    /// Makes up names: of bodies by their number, of joints after their body.
    pub(super) fn make_names(&mut self) {
        let mut bodies = Names::of(self.entries.iter().map(|body| body.name.as_str()));
        let joints = self.entries.iter().nested(|body| &body.joints);
        let mut joints = Names::of(joints.map(|joint| joint.name.as_str()));
        for (i, body) in self.entries.iter_mut().enumerate().skip(1) {
            if body.name.is_empty() {
                body.name = bodies.fresh(format!("body_{i}"));
            }
            let idle = body.idle.iter_mut().map(|(_, contact)| contact);
            for contact in body.contacts.iter_mut().chain(idle) {
                contact.link.clone_from(&body.name);
            }
            for (k, joint) in body.joints.iter_mut().enumerate() {
                if joint.name.is_empty() {
                    let number = if k == 0 { String::new() } else { k.to_string() };
                    joint.name = joints.fresh(format!("{}::joint{number}", body.name));
                }
            }
        }
    }
}
