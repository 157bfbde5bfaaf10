//! Inverse masses and inertias that the rows of an equality feel.

use super::entry::Entry;
use super::equality::Reference;
use super::walk::Part;
use crate::constraint::ConstraintKind;

impl Reference<'_> {
    /// Inverse masses and inertias of both bodies together, or of both joints or tendons.
    pub(super) fn inverses_of(
        &self,
        part: &Part<'_, '_>,
        entry: &Entry<'_, '_>,
        kind: &ConstraintKind,
    ) -> [f64; 2] {
        let own = |name: &'static str| entry.text(name).map(|text| part.naming.of(text));
        let mut sum = [0.0; 2];
        let mut add = |inverses: [f64; 2]| {
            sum = [sum[0] + inverses[0], sum[1] + inverses[1]];
        };
        let has_sites = entry.text("site1").is_some();
        for (anchor, name) in kind.anchors().iter().zip(["body1", "body2"]) {
            let body = match has_sites {
                true => self.inverses.body_of_site(anchor, &self.names.sites),
                false => own(name).and_then(|name| self.inverses.body_named(&name)),
            };
            add(self.inverses.of_body(body));
        }
        if kind.anchors().is_empty() {
            for name in ["joint1", "joint2"] {
                let joint = own(name).map(|joint| vec![(joint, 1.0)]);
                add([joint.map_or(0.0, |joint| self.inverse_along(&joint)), 0.0]);
            }
            for name in ["tendon1", "tendon2"] {
                let found = own(name).and_then(|own| self.tendons.get(own.as_str()));
                add([
                    found.map_or(0.0, |own| self.inverse_along(&own.joints)),
                    0.0,
                ]);
            }
        }
        sum
    }

    /// cᵀ M⁻¹ c of joints with their coefficients.
    fn inverse_along(&self, joints: &[(String, f64)]) -> f64 {
        let mut c = vec![0.0; self.model.nv()];
        for (joint, coefficient) in joints {
            if let Some(id) = self.model.joint(joint) {
                c[self.model.joint_v(id).start] += coefficient;
            }
        }
        self.inverses.along(&c)
    }
}
