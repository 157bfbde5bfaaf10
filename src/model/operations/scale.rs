//! Scaling of the lengths and densities of a robot.

use super::edit::positive;
use crate::error::EditError;
use crate::joint::{JointKind, Pitch};
use crate::model::parts::Geometry;
use crate::model::{JointSpec, Model, ModelBuilder};
use crate::spatial::{Inertia, Transform};

impl ModelBuilder {
    /// [`Model::scaled`].
    pub(crate) fn scale(&mut self, length: f64, density: f64) -> Result<&mut Self, EditError> {
        positive("length factor", length)?;
        positive("density factor", density)?;
        for link in &mut self.links {
            scale_inertia(&mut link.inertia, length, density);
            for visual in &mut link.visuals {
                scale_pose(&mut visual.placement, length);
                scale_geometry(&mut visual.geometry, length);
            }
            for collision in &mut link.collisions {
                scale_pose(&mut collision.placement, length);
                scale_geometry(&mut collision.geometry, length);
            }
        }
        for frame in &mut self.frames {
            scale_pose(&mut frame.placement, length);
        }
        self.scale_ratios(length);
        for joint in &mut self.joints {
            scale_pose(&mut joint.placement, length);
            match &mut joint.kind {
                JointKind::Prismatic => scale_travel(joint, length),
                JointKind::Screw(pitch) => {
                    *pitch = Pitch::per_radian(pitch.metres_per_radian() * length);
                }
                _ => {}
            }
        }
        Ok(self)
    }

    /// Ratios between lengths and angles.
    fn scale_ratios(&mut self, length: f64) {
        let is_length = |joint: &JointSpec| joint.kind == JointKind::Prismatic;
        let slides: Vec<String> = self
            .joints
            .iter()
            .filter(|joint| is_length(joint))
            .map(|joint| joint.name.clone())
            .collect();
        for joint in &mut self.joints {
            let follows_length = is_length(joint);
            if let Some(mimic) = &mut joint.mimic {
                match (follows_length, slides.contains(&mimic.leader)) {
                    (true, false) => mimic.multiplier *= length,
                    (false, true) => mimic.multiplier /= length,
                    _ => {}
                }
            }
        }
    }
}

fn scale_inertia(inertia: &mut Inertia<f64>, length: f64, density: f64) {
    let mass = density * length.powi(3);
    let moments = inertia.scaled(mass * length * length);
    inertia.mass *= mass;
    inertia.first_moment *= mass * length;
    inertia.rotational = moments.rotational;
}

fn scale_pose(pose: &mut Transform<f64>, length: f64) {
    pose.translation *= length;
}

fn scale_geometry(geometry: &mut Geometry, factor: f64) {
    match geometry {
        Geometry::Box { size: lengths }
        | Geometry::Ellipsoid { size: lengths }
        | Geometry::Mesh { scale: lengths, .. } => {
            lengths.iter_mut().for_each(|length| *length *= factor);
        }
        Geometry::Sphere { radius } => *radius *= factor,
        Geometry::Cylinder { radius, length } | Geometry::Capsule { radius, length } => {
            *radius *= factor;
            *length *= factor;
        }
    }
}

/// Scales the lengths along the axis of a prismatic joint: its limits, rest position and offset.
fn scale_travel(joint: &mut JointSpec, factor: f64) {
    let limits = &mut joint.limits;
    for limit in [&mut limits.lower, &mut limits.upper, &mut limits.velocity] {
        *limit = limit.map(|limit| limit * factor);
    }
    joint.spring.rest *= factor;
    if let Some(mimic) = &mut joint.mimic {
        mimic.offset *= factor;
    }
}

impl Model<f64> {
    /// Returns the robot with all lengths scaled by s and all densities by ρ, for all shapes, and also without shapes.
    ///
    /// | quantity | factor |
    /// |---|---|
    /// | positions of joints, frames, shapes; sizes of shapes | s |
    /// | limits of position and speed, offset and rest position of prismatic joints | s |
    /// | pitch of screw joints | s |
    /// | masses | ρ s³ |
    /// | first moments | ρ s⁴ |
    /// | rotational inertias | ρ s⁵ |
    /// | ratio of a prismatic mimic joint of a revolute leader (the inverse for the reverse case) | s |
    /// | gravity, angles, efforts, damping, friction, rotor inertias, stiffness | 1 |
    ///
    /// # Errors
    /// If a factor is not positive.
    ///
    /// # Examples
    /// ```
    /// use dualbody::model::samples;
    ///
    /// let twice = samples::pendulum().scaled(2.0, 1.0)?;
    /// assert_eq!(twice.total_mass(), 8.0);
    /// # Ok::<(), dualbody::error::EditError>(())
    /// ```
    pub fn scaled(&self, length: f64, density: f64) -> Result<Self, EditError> {
        Ok(self.to_builder().scale(length, density)?.build()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics;
    use crate::model::{LinkSpec, Mass, UpAxis, Visual, samples};
    use crate::tests::ROUNDING;
    use rand::SeedableRng;
    use rand::rngs::Xoshiro256PlusPlus;

    const S: f64 = 1.7;
    const RHO: f64 = 0.6;

    #[test]
    fn scaled_solids_equal_solids_of_the_scaled_size() {
        let (link, scaled) = (
            |s: f64, rho: f64| {
                [
                    LinkSpec::solid_box("a", [0.3 * s, 0.2 * s, 0.1 * s], Mass::Density(rho)),
                    LinkSpec::solid_capsule("b", 0.1 * s, 0.4 * s, Mass::Density(rho)),
                    LinkSpec::solid_cylinder("c", 0.1 * s, 0.4 * s, Mass::Density(rho)),
                    LinkSpec::solid_sphere("d", 0.2 * s, Mass::Density(rho)),
                ]
            },
            |link: LinkSpec| {
                let mut builder = ModelBuilder::new("solid");
                builder.add_link(link).scale(S, RHO).unwrap();
                builder.links[0].clone()
            },
        );
        for (unit, expected) in link(1.0, 800.0).into_iter().zip(link(S, 800.0 * RHO)) {
            let actual = scaled(unit);
            let difference = actual.inertia.to_matrix() - expected.inertia.to_matrix();
            assert!(difference.amax() < 1e-13 * expected.inertia.mass);
            let volume = |link: &LinkSpec| link.collisions[0].geometry.volume().unwrap();
            assert!((volume(&actual) / volume(&expected) - 1.0).abs() < 10.0 * ROUNDING);
        }
    }

    // Dimensions: coordinates of length x have q' = s q, forces' = (ρ s⁴) forces; angles q' = q, torques' = (ρ s⁵) torques, in
    // accelerations' = s accelerations, so in gravity' = s gravity.
    #[test]
    fn inverse_dynamics_of_a_scaled_robot_equal_those_of_the_robot_by_dimensions() {
        let model = samples::random_tree_of(&[JointKind::Revolute, JointKind::Prismatic], 10, 3);
        let gravity = *model.gravity();
        let scaled = model.scaled(S, RHO).unwrap().with_gravity(gravity * S);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        let (q, v) = (
            model.random_configuration(&mut rng),
            model.random_velocity(&mut rng, 1.0),
        );
        // One coordinate per body.
        let kinds: Vec<JointKind> = model.bodies().iter().map(|body| body.joint).collect();
        let factor = |i: usize| {
            if kinds[i] == JointKind::Prismatic {
                S
            } else {
                1.0
            }
        };
        let sized = |x: &nalgebra::DVector<f64>| x.map_with_location(|i, _, x| x * factor(i));
        let bias = dynamics::bias_forces(&model, q.as_slice(), v.as_slice());
        let actual = dynamics::bias_forces(&scaled, sized(&q).as_slice(), sized(&v).as_slice());
        for i in 0..model.nv() {
            let expected = bias[i] * RHO * S.powi(5) / factor(i);
            let error = (actual[i] - expected).abs();
            assert!(error < 1e-11 * bias.amax(), "coordinate {i}: {error:e}");
        }
    }

    // The scale of a shape whose volume is unknown must not make its link massless.
    #[test]
    fn mass_of_a_link_without_known_shape_scales_like_any_other() {
        let mesh = Geometry::Mesh {
            uri: "hand.stl".into(),
            path: None,
            scale: [0.001; 3],
            up_axis: UpAxis::Auto,
        };
        let mut builder = ModelBuilder::new("hand");
        let hand = LinkSpec::new("hand").with_mass(2.0, [0.0; 3], [0.1; 3]);
        builder.add_link(hand.with_visual(Visual {
            name: None,
            placement: Transform::identity(),
            geometry: mesh,
            color: None,
        }));
        let scaled = builder.build().unwrap().scaled(S, RHO).unwrap();
        assert!((scaled.total_mass() - 2.0 * RHO * S.powi(3)).abs() < ROUNDING);
        let Geometry::Mesh { scale, .. } = &scaled.links()[0].visuals[0].geometry else {
            panic!("the mesh is gone");
        };
        assert_eq!(*scale, [0.001 * S; 3]);
        let plain = samples::pendulum().scaled(S, RHO).unwrap();
        assert!((plain.total_mass() - RHO * S.powi(3)).abs() < ROUNDING);
    }

    #[test]
    fn lengths_of_joints_scale_and_angles_stay() {
        let cartpole = samples::cartpole().scaled(S, RHO).unwrap();
        let limits = cartpole.limits(cartpole.joint("linear").unwrap());
        assert_eq!((limits.upper, limits.effort), (Some(2.4 * S), Some(500.0)));
        let error = cartpole.scaled(0.0, 1.0).unwrap_err();
        assert!(matches!(error, EditError::NotPositive { .. }), "{error}");
    }
}
