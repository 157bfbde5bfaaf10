//! The description of a model, updated by edits of the model.
//!
//! A model merges links into bodies. Its description keeps them separate: all links with their own inertia, all joints including fixed ones, all
//! frames. [`Model::to_builder`] transfers edits of merged parameters ([`Model::with_inertia`], [`Model::with_gravity`], [`Model::with_damping`]) to
//! the description, so that it always agrees with the model.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::collections::HashMap;
use std::ops::Range;

use nalgebra::Matrix3;

use super::axes::{body_frame, unit_axis};
use super::builder::Override;
use super::manifold::v_range;
use super::parts::Spring;
use super::{BodyId, JointSpec, Model, ModelBuilder};
use crate::joint::JointKind;
use crate::scalar::Scalar;
use crate::spatial::{Inertia, Transform};

impl JointSpec {
    /// The rotation `R_LB` of the frame whose z axis is the joint's, in the child link.
    pub(crate) fn motion_frame(&self) -> Matrix3<f64> {
        body_frame(self.kind, &unit_axis(self))
    }
}

impl ModelBuilder {
    /// `true` if the axes of a joint (`None`: of the floating base) have parameters of their own.
    pub(crate) fn has_override(&self, joint: Option<&str>) -> bool {
        let of_joint = |edit: &Override| edit.joint.as_deref() == joint;
        self.overrides.iter().any(of_joint)
    }
}

impl Model<f64> {
    /// Returns the description of the robot with all later edits. Building it gives an equal robot; edited inertias are equal to rounding.
    ///
    /// For a body that [`with_inertia`](Self::with_inertia) changed, the first link has the whole inertia; the links fixed to it become massless.
    ///
    /// Cost: linear in the number of links; allocates.
    ///
    /// # Examples
    /// ```
    /// use dualbody::model::samples;
    ///
    /// let cartpole = samples::cartpole();
    /// let builder = cartpole.to_builder();
    /// assert_eq!(builder.links.len(), 3);
    /// assert_eq!(builder.build()?.nv(), 2);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn to_builder(&self) -> ModelBuilder {
        let mut builder = ModelBuilder::clone(&self.description);
        builder.gravity = self.gravity;
        // A description that was built once can be built again.
        let Ok(described) = self.description.build() else {
            return builder;
        };
        self.describe_inertias(&mut builder, &described);
        self.describe_placements(&mut builder, &described);
        if self.damping != described.damping
            || self.armature != described.armature
            || self.springs != described.springs
        {
            self.describe_coordinates(&mut builder, &described);
        }
        builder
    }

    /// Puts the inertia of every edited body on its first link.
    fn describe_inertias(&self, builder: &mut ModelBuilder, described: &Self) {
        let edited = |body: &BodyId| self.body(*body).inertia != described.body(*body).inertia;
        let spec_of_name: HashMap<String, usize> =
            indices(builder.links.iter().map(|link| link.name.as_str()));
        let mut left: Vec<Inertia<f64>> = self.bodies.iter().map(|body| body.inertia).collect();
        for frame in self.links.iter().map(|link| &self.frames[link.frame.0]) {
            if let Some(body) = frame.body.filter(edited) {
                let X_LB = frame.placement.inverse();
                let inertia = std::mem::replace(&mut left[body.0], Inertia::zero());
                builder.links[spec_of_name[&frame.name]].inertia = X_LB.inertia(&inertia);
            }
        }
    }

    /// Puts the pose of every edited joint in its parent link:  `X_LJ = X_LP X_PJ X_BC` with C the child link.
    fn describe_placements(&self, builder: &mut ModelBuilder, described: &Self) {
        let on_body: HashMap<&str, &Transform<f64>> = (self.frames.iter())
            .map(|frame| (frame.name.as_str(), &frame.placement))
            .collect();
        let spec_of_name = indices(builder.joints.iter().map(|joint| joint.name.as_str()));
        for joint in &self.joints {
            let first = BodyId(joint.bodies().start);
            let placement = self.body(first).placement;
            if placement != described.body(first).placement {
                let spec = &mut builder.joints[spec_of_name[&joint.name]];
                let (parent, child) = (on_body[spec.parent.as_str()], on_body[spec.child.as_str()]);
                // With all that the joint moves at zero, C on the first body.
                let others = &self.bodies[first.0 + 1..joint.bodies().end];
                let X_BC = others
                    .iter()
                    .rev()
                    .fold(*child, |X, body| body.placement * X);
                spec.placement = parent.inverse() * placement * X_BC;
            }
        }
    }

    /// Puts what acts along edited coordinates on the joints that have them; mimic joints then add nothing.
    fn describe_coordinates(&self, builder: &mut ModelBuilder, described: &Self) {
        builder.overrides.clear();
        if self.has_floating_base() {
            self.describe_axes(builder, None, 0..JointKind::Floating.nv());
        }
        let spec_of_name = indices(builder.joints.iter().map(|joint| joint.name.as_str()));
        for part in self.joint_parts() {
            let (joint, body) = (self.joint_of(part.id), self.body(part.body));
            let (range, leads) = (v_range(body), body.coupling.is_none());
            let spec = &mut builder.joints[spec_of_name[&joint.name]];
            let own = |x: &[f64]| if leads { x[range.start] } else { 0.0 };
            let second = spec.second.as_mut().filter(|_| part.body == joint.body);
            let (damping, armature, spring) = match second {
                Some(second) => (
                    &mut second.damping,
                    &mut second.armature,
                    &mut second.spring,
                ),
                None => (&mut spec.damping, &mut spec.armature, &mut spec.spring),
            };
            if self.damping[range.clone()] != described.damping[range.clone()] {
                *damping = own(&self.damping);
            }
            if self.armature[range.clone()] != described.armature[range.clone()] {
                *armature = own(&self.armature);
            }
            if self.springs[range.clone()] != described.springs[range.clone()] {
                *spring = Spring::default();
                if leads {
                    *spring = self.springs[range.start];
                }
            }
            if leads && joint.second.is_none() {
                self.describe_axes(builder, Some(&joint.name), range);
            }
        }
    }

    /// Stores the parameters of the axes of a joint if they differ.
    fn describe_axes(&self, builder: &mut ModelBuilder, joint: Option<&str>, axes: Range<usize>) {
        // The base has nothing but what is noted here.
        let usual = |x: &[f64]| if joint.is_some() { x[axes.start] } else { 0.0 };
        let differ = |x: &[f64]| x[axes.clone()].iter().any(|&own| own != usual(x));
        if !differ(&self.damping) && !differ(&self.armature) {
            return;
        }
        let first = axes.start;
        builder.overrides.extend(axes.map(|k| Override {
            joint: joint.map(Into::into),
            axis: k - first,
            damping: self.damping[k],
            armature: self.armature[k],
        }));
    }
}

impl<P: Scalar> Model<P> {
    /// Sets the parameters of individual degrees of freedom.
    pub(super) fn apply_overrides(&mut self, overrides: &[Override]) {
        for edit in overrides {
            let first = match &edit.joint {
                None => self.has_floating_base().then_some(0),
                Some(name) => self.joint(name).map(|joint| self.joint_v(joint).start),
            };
            if let Some(first) = first {
                self.damping[first + edit.axis] = P::constant(edit.damping);
                self.armature[first + edit.axis] = P::constant(edit.armature);
            }
        }
    }
}

/// Index of each name.
pub(super) fn indices<'a>(names: impl Iterator<Item = &'a str>) -> HashMap<String, usize> {
    names
        .zip(0..)
        .map(|(name, i)| (name.to_owned(), i))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Base, LinkSpec, Mimic, samples};
    use crate::tests::ROUNDING;
    use nalgebra::Vector3;

    fn models() -> Vec<Model> {
        let mut models = vec![samples::pendulum(), samples::cartpole(), samples::arm()];
        models.extend((0..4).map(|seed| samples::random_tree(20, seed)));
        models
    }

    /// Asserts that two robots have the same bodies, frames and numbers.
    fn assert_same(a: &Model, b: &Model) {
        assert_eq!(a.bodies(), b.bodies(), "{}", a.name());
        assert_eq!(a.frames(), b.frames(), "{}", a.name());
        assert_eq!(a.damping(), b.damping());
        assert_eq!(a.armature(), b.armature());
        assert_eq!(a.springs(), b.springs());
        assert_eq!(a.gravity(), b.gravity());
    }

    #[test]
    fn rebuilt_description_equals_the_model_in_every_number() {
        for model in models() {
            let rebuilt = model.to_builder().build().unwrap();
            assert_same(&rebuilt, &model);
            assert_eq!(rebuilt.to_builder(), model.to_builder());
        }
    }

    #[test]
    fn rebuilt_description_of_an_edited_model_equals_the_edited_model() {
        let mut builder = samples::random_tree(12, 1).to_builder();
        builder.base = Base::Fixed;
        let model = builder.build().unwrap();
        let ball = model.joint("joint3").unwrap();
        let damped = model.joint_v(ball).start + 1;
        let edited = model
            .clone()
            .with_gravity(Vector3::new(0.0, 1.0, -3.7))
            .with_damping(0, 0.7)
            .with_damping(damped, 0.9)
            .with_armature(damped, 0.2)
            .with_inertia(BodyId(3), model.body(BodyId(0)).inertia);
        let rebuilt = edited.to_builder().build().unwrap();
        assert_eq!(rebuilt.gravity(), edited.gravity());
        assert_eq!(rebuilt.damping(), edited.damping());
        let again = rebuilt.to_builder().build().unwrap();
        assert_eq!(again.damping(), edited.damping());
        assert_eq!(again.armature(), edited.armature());
        for (rebuilt, edited) in rebuilt.bodies().iter().zip(edited.bodies()) {
            let difference = rebuilt.inertia.to_matrix() - edited.inertia.to_matrix();
            assert!(difference.amax() < 10.0 * ROUNDING, "{difference}");
        }
    }

    #[test]
    fn damping_of_a_floating_base_equals_what_was_set_after_rebuilding() {
        let mut builder = ModelBuilder::new("ball");
        builder.add_link(LinkSpec::new("ball").with_mass(1.0, [0.0; 3], [0.1; 3]));
        let model = builder.build().unwrap().with_damping(4, 0.3);
        let rebuilt = model.to_builder().build().unwrap();
        assert_eq!(rebuilt.damping(), [0.0, 0.0, 0.0, 0.0, 0.3, 0.0]);
    }

    #[test]
    fn edited_leader_and_followers_equal_the_edited_model_after_rebuilding() {
        let mut builder = ModelBuilder::new("gripper");
        builder.add_link(LinkSpec::new("world"));
        for (finger, ratio) in [("left", 0.0), ("right", -2.0)] {
            builder.add_link(LinkSpec::new(finger).with_mass(1.0, [0.0; 3], [0.1; 3]));
            let joint = JointSpec::new(
                format!("{finger}_slide"),
                JointKind::Prismatic,
                "world",
                finger,
            )
            .with_damping(0.3)
            .with_spring(5.0, 0.1)
            .with_armature(0.2);
            let leader = "left_slide".into();
            let (multiplier, offset) = (ratio, 0.0);
            builder.add_joint(if ratio == 0.0 {
                joint
            } else {
                joint.with_mimic(Mimic {
                    leader,
                    multiplier,
                    offset,
                })
            });
        }
        let model = builder.build().unwrap();
        let spring = Spring {
            stiffness: 7.0,
            rest: 0.3,
        };
        for edited in [
            model.clone(),
            model.clone().with_damping(0, 0.9),
            model.clone().with_armature(0, 0.7),
            model.with_spring(0, spring),
        ] {
            let rebuilt = edited.to_builder().build().unwrap();
            assert_same(&rebuilt, &edited);
        }
    }
}
