//! Locking joints: fewer degrees of freedom, with all links and frames.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::collections::{HashMap, HashSet};

use nalgebra::Vector3;

use crate::error::EditError;
use crate::joint::JointKind;
use crate::model::axes::unit;
use crate::model::{JointSpec, Mimicry, Model, ModelBuilder, checks};
use crate::spatial::{Quaternion, Transform};

impl ModelBuilder {
    /// [`Model::with_locked_joints`].
    pub(crate) fn lock_joints(
        &mut self,
        positions: &[(&str, &[f64])],
    ) -> Result<&mut Self, EditError> {
        // Where a joint is locked follows from numbers that must be possible.
        checks::check(self)?;
        let mut locked: HashMap<usize, Vec<f64>> = HashMap::new();
        for &(name, q) in positions {
            let joint = self.joint_index(name)?;
            let expected = self.joints[joint].kind.nq();
            let (joint_name, given) = (name.to_owned(), q.len());
            if given != expected {
                return Err(EditError::WrongLength {
                    joint: joint_name,
                    expected,
                    given,
                });
            }
            if locked.insert(joint, q.to_vec()).is_some() {
                return Err(EditError::DuplicateName {
                    element: "locked joint".into(),
                    name: joint_name,
                });
            }
        }
        self.lock_mimic_joints(&mut locked);
        for (&joint, q) in &locked {
            let spec = &mut self.joints[joint];
            let name = std::mem::take(&mut spec.name);
            self.overrides
                .retain(|edit| edit.joint.as_ref() != Some(&name));
            *spec = JointSpec::new(name, JointKind::Fixed, &spec.parent, &spec.child)
                .with_placement(spec.placement * locked_pose(spec, q));
        }
        Ok(self)
    }

    /// [`Model::with_kept_joints`].
    pub(crate) fn keep_joints(
        &mut self,
        kept: &[&str],
        positions: &[(&str, &[f64])],
    ) -> Result<&mut Self, EditError> {
        let kept_joints: HashSet<usize> = kept
            .iter()
            .map(|name| self.joint_index(name))
            .collect::<Result<_, _>>()?;
        let given: HashSet<&str> = positions.iter().map(|&(name, _)| name).collect();
        let neutral = |(i, joint): (usize, &JointSpec)| {
            let follows = self.leader(joint).is_some();
            let stays = kept_joints.contains(&i) || follows || joint.kind == JointKind::Fixed;
            let mut q = vec![0.0; joint.kind.nq()];
            joint.kind.neutral(&mut q);
            (!stays && !given.contains(joint.name.as_str())).then(|| (joint.name.clone(), q))
        };
        let others: Vec<(String, Vec<f64>)> =
            self.joints.iter().enumerate().filter_map(neutral).collect();
        let others = others.iter().map(|(name, q)| (name.as_str(), q.as_slice()));
        let all: Vec<(&str, &[f64])> = others.chain(positions.iter().copied()).collect();
        let mut reduced = self.clone();
        reduced.lock_joints(&all)?;
        for i in kept_joints {
            let was_free = self.joints[i].kind != JointKind::Fixed;
            if was_free && reduced.joints[i].kind == JointKind::Fixed {
                let joint = self.joints[i].name.clone();
                return Err(EditError::KeptAndLocked { joint });
            }
        }
        *self = reduced;
        Ok(self)
    }

    /// The joint that a joint moves with.
    fn leader<'a>(&self, joint: &'a JointSpec) -> Option<&'a str> {
        let mimic = joint
            .mimic
            .as_ref()
            .filter(|_| self.mimicry == Mimicry::Coupled)?;
        Some(mimic.leader.as_str())
    }

    /// Adds the joints that follow locked ones, directly or by others, where those put them.
    fn lock_mimic_joints(&self, locked: &mut HashMap<usize, Vec<f64>>) {
        let mut followers: HashMap<&str, Vec<usize>> = HashMap::new();
        for (i, joint) in self.joints.iter().enumerate() {
            if let Some(leader) = self.leader(joint) {
                followers.entry(leader).or_default().push(i);
            }
        }
        let mut open: Vec<usize> = locked.keys().copied().collect();
        while let Some(leader) = open.pop() {
            let Some(&q) = locked[&leader].first() else {
                continue;
            };
            for &follower in followers
                .get(self.joints[leader].name.as_str())
                .into_iter()
                .flatten()
            {
                if let Some(mimic) = &self.joints[follower].mimic
                    && !locked.contains_key(&follower)
                {
                    locked.insert(follower, vec![mimic.multiplier * q + mimic.offset]);
                    open.push(follower);
                }
            }
        }
    }
}

/// The pose of the child link in the joint frame at a configuration.
fn locked_pose(joint: &JointSpec, q: &[f64]) -> Transform<f64> {
    if let (Some(second), [first_angle, second_angle]) = (&joint.second, q) {
        let turn = |axis, angle: f64| Quaternion::exp(&(unit(axis) * angle)).to_matrix();
        let rotation = turn(&joint.axis, *first_angle) * turn(&second.axis, *second_angle);
        return Transform::new(rotation, Vector3::zeros());
    }
    let X_JB = joint.kind.transform(q);
    if X_JB == Transform::identity() {
        return X_JB;
    }
    // The motion is about the local z of frame B, which is turned against the link.
    let X_LB = Transform::new(joint.motion_frame(), Vector3::zeros());
    X_LB * X_JB * X_LB.inverse()
}

impl Model<f64> {
    /// Returns the robot with joints locked at positions: they become fixed, with the placement `X_PL = X_PJ X_JL(q)`.
    ///
    /// Its dynamics are those of the whole robot with these joints held.
    /// Limits, damping and friction of these joints are removed. A mimic joint of a locked leader is locked at the resulting position; a locked mimic
    /// joint no longer follows its leader.
    ///
    /// * `positions` – names of joints, each with its configuration, of length `nq` of its kind (rad, m, unit quaternion)
    ///
    /// # Errors
    /// If a name is unknown or duplicate, a configuration has the wrong length, or the result is not a valid model.
    pub fn with_locked_joints(&self, positions: &[(&str, &[f64])]) -> Result<Self, EditError> {
        Ok(self.to_builder().lock_joints(positions)?.build()?)
    }

    /// Returns the robot with only some joints; all others are locked at the given positions, or at the neutral one (zeros, identity).
    ///
    /// Mimic joints of kept joints remain.
    ///
    /// * `positions` – as in [`with_locked_joints`](Self::with_locked_joints)
    ///
    /// # Errors
    /// As there; and if a kept joint, or its leader, is also to be locked.
    ///
    /// # Examples
    /// ```
    /// use dualbody::model::samples;
    ///
    /// let wrist = samples::arm().with_kept_joints(&["joint5", "joint6"], &[("joint2", &[0.5])])?;
    /// assert_eq!(wrist.joint_names(), ["joint5", "joint6"]);
    /// # Ok::<(), dualbody::error::EditError>(())
    /// ```
    pub fn with_kept_joints(
        &self,
        kept: &[&str],
        positions: &[(&str, &[f64])],
    ) -> Result<Self, EditError> {
        Ok(self.to_builder().keep_joints(kept, positions)?.build()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics;
    use crate::model::{JointId, LinkSpec, Mimic, samples};
    use nalgebra::{DMatrix, DVector};
    use rand::SeedableRng;
    use rand::rngs::Xoshiro256PlusPlus;

    /// Two ways through the same tree: a few roundings per body.
    const TREE_ROUNDING: f64 = 1e-11;

    /// Coordinates (of q or of v) of the joints that are kept.
    fn kept(
        model: &Model,
        locked: &[usize],
        range: impl Fn(JointId) -> std::ops::Range<usize>,
    ) -> Vec<usize> {
        let free = (0..model.n_joints()).filter(|i| !locked.contains(i));
        free.flat_map(|i| range(JointId(i))).collect()
    }

    fn entries(x: &DVector<f64>, at: &[usize]) -> DVector<f64> {
        DVector::from_fn(at.len(), |i, _| x[at[i]])
    }

    fn compare_locked_with_held(model: &Model, locked: &[usize], seed: u64) {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let q = model.random_configuration(&mut rng);
        let mut v = model.random_velocity(&mut rng, 2.0);
        let positions: Vec<(&str, &[f64])> = (locked.iter())
            .map(|&i| {
                let range = model.joint_q(JointId(i));
                v.as_mut_slice()[model.joint_v(JointId(i))].fill(0.0);
                (model.joints()[i].name.as_str(), &q.as_slice()[range])
            })
            .collect();
        let reduced = model.with_locked_joints(&positions).unwrap();
        let of_q = kept(model, locked, |joint| model.joint_q(joint));
        let of_v = kept(model, locked, |joint| model.joint_v(joint));
        let (q_kept, v_kept) = (entries(&q, &of_q), entries(&v, &of_v));
        let what = format!("{} without {locked:?}", model.name());
        let (whole, part) = (
            dynamics::mass_matrix(model, q.as_slice()),
            dynamics::mass_matrix(&reduced, q_kept.as_slice()),
        );
        let sub = DMatrix::from_fn(of_v.len(), of_v.len(), |i, k| whole[(of_v[i], of_v[k])]);
        assert!((sub - part).amax() < TREE_ROUNDING, "{what}: mass matrix");
        let (whole, part) = (
            dynamics::bias_forces(model, q.as_slice(), v.as_slice()),
            dynamics::bias_forces(&reduced, q_kept.as_slice(), v_kept.as_slice()),
        );
        assert!(
            (entries(&whole, &of_v) - part).amax() < TREE_ROUNDING * 10.0,
            "{what}: bias"
        );
        // The cross of a universal joint goes with it.
        for name in (model.frame_names().into_iter()).filter(|name| !name.ends_with("::cross")) {
            let frame = |model: &Model| model.frame(name).unwrap();
            let held = dynamics::frame_pose(model, q.as_slice(), frame(model));
            let fixed = dynamics::frame_pose(&reduced, q_kept.as_slice(), frame(&reduced));
            let turned = (held.rotation - fixed.rotation).amax();
            let moved = (held.translation - fixed.translation).amax();
            assert!(turned.max(moved) < TREE_ROUNDING, "{what}: frame {name}");
        }
    }

    #[test]
    fn dynamics_with_locked_joints_equal_those_with_joints_held() {
        for seed in 0..6 {
            let model = samples::random_tree(14, seed);
            // The first eight joints have the eight kinds in turn.
            for kind in 0..8 {
                compare_locked_with_held(&model, &[kind], seed);
            }
            compare_locked_with_held(&model, &[1, 2, 3, 7, 9, 10], seed);
        }
    }

    #[test]
    fn keeping_joints_equals_locking_the_others() {
        let arm = samples::arm();
        let kept = arm
            .with_kept_joints(&["joint2", "joint7"], &[("joint4", &[0.7])])
            .unwrap();
        let others: [(&str, &[f64]); 5] = [
            ("joint1", &[0.0]),
            ("joint3", &[0.0]),
            ("joint4", &[0.7]),
            ("joint5", &[0.0]),
            ("joint6", &[0.0]),
        ];
        let locked = arm.with_locked_joints(&others).unwrap();
        assert_eq!(kept.bodies(), locked.bodies());
    }

    /// Three sliders in a row; the second and third follow the one before with twice its position and 0.1 m.
    fn followers() -> ModelBuilder {
        let mut builder = ModelBuilder::new("followers");
        builder.add_link(LinkSpec::new("world"));
        for i in 0..3 {
            let parent = if i == 0 {
                "world".to_owned()
            } else {
                format!("link{}", i - 1)
            };
            builder.add_link(LinkSpec::new(format!("link{i}")).with_mass(1.0, [0.0; 3], [0.1; 3]));
            let mut joint = JointSpec::new(
                format!("joint{i}"),
                JointKind::Prismatic,
                parent,
                format!("link{i}"),
            );
            if i > 0 {
                let leader = format!("joint{}", i - 1);
                joint = joint.with_mimic(Mimic {
                    leader,
                    multiplier: 2.0,
                    offset: 0.1,
                });
            }
            builder.add_joint(joint);
        }
        builder
    }

    #[test]
    fn followers_of_a_locked_joint_stand_where_it_puts_them() {
        let mut builder = followers();
        builder.lock_joints(&[("joint0", &[0.5])]).unwrap();
        let x = builder
            .joints
            .iter()
            .map(|joint| joint.placement.translation.x);
        assert_eq!(x.collect::<Vec<_>>(), [0.5, 1.1, 2.3000000000000003]);
        assert!(
            builder
                .joints
                .iter()
                .all(|joint| joint.kind == JointKind::Fixed)
        );
        let mut builder = followers();
        let error = builder.keep_joints(&["joint2"], &[]).unwrap_err();
        assert!(matches!(error, EditError::KeptAndLocked { .. }), "{error}");
        assert_eq!(builder.joints[0].kind, JointKind::Prismatic);
        builder
            .keep_joints(&["joint0"], &[("joint2", &[0.2])])
            .unwrap();
        let kinds: Vec<JointKind> = builder.joints.iter().map(|joint| joint.kind).collect();
        assert_eq!(
            kinds,
            [JointKind::Prismatic, JointKind::Prismatic, JointKind::Fixed]
        );
    }

    #[test]
    fn wrong_positions_are_errors_that_name_the_joint() {
        let model = samples::double_pendulum();
        let fail = |positions: &[(&str, &[f64])]| {
            model.with_locked_joints(positions).unwrap_err().to_string()
        };
        assert!(fail(&[("knee", &[0.0])]).contains("it has: shoulder, elbow"));
        assert!(fail(&[("elbow", &[0.0, 1.0])]).contains("\"elbow\""));
        assert!(fail(&[("elbow", &[0.0]), ("elbow", &[1.0])]).contains("\"elbow\""));
        assert!(fail(&[("elbow", &[f64::NAN])]).contains("\"elbow\""));
    }
}
