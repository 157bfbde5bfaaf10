//! Simulators of scenes.

use std::collections::HashSet;
use std::path::Path;

use super::scene::{MjcfGeom, MjcfScene};
use crate::contact::{ContactLaw, Contacts, RelaxedRigid, Terrain};
use crate::error::LoadError;
use crate::io::ModelOptions;
use crate::sim::{Actuation, Simulator};
use crate::spatial::Transform;

impl MjcfScene {
    /// Makes a simulator of the scene: its time step and method, joint limits and friction, constraints, contacts with the ground, and an input for
    /// each motor, the force along its joint ([`MjcfActuator::force`](super::MjcfActuator::force) makes it of a control).
    ///
    /// | number | taken as |
    /// |---|---|
    /// | joint limits, friction losses | those of [`Actuation::from_model`] |
    /// | contact | [`RelaxedRigid`] against the ground with its default reference and impedance, `impratio`, and the larger sliding friction of link and ground; 0 for `condim` 1 |
    ///
    /// Links touch the ground only. Reads the meshes that do.
    ///
    /// # Panics
    /// If the mass matrix of the model is singular: [`Model::check_mass_matrix`](crate::Model::check_mass_matrix), or if contact points need more memory than
    /// the [limit](crate::memory).
    ///
    /// # Examples
    /// ```
    /// use dualbody::ModelOptions;
    ///
    /// let xml = r#"<mujoco><option timestep="0.001"/><worldbody><body name="cart"><joint name="x" type="slide" axis="1 0 0"/>
    ///   <geom type="box" size="0.1 0.1 0.1" mass="2"/></body></worldbody><actuator><motor joint="x"/></actuator></mujoco>"#;
    /// let (scene, _) = ModelOptions::default().load_mjcf_scene_str(xml)?;
    /// let simulator = scene.simulator();
    /// let next = simulator.step(&scene.reference, &[4.0]);
    /// assert!((next.v[0] - 0.001 * 4.0 / 2.0).abs() < 1e-15);
    /// # Ok::<(), dualbody::LoadError>(())
    /// ```
    pub fn simulator(&self) -> Simulator {
        let model = self.model.clone();
        let mut motors: Vec<&str> = Vec::new();
        let mut driven = HashSet::new();
        for motor in self.actuation.iter().filter(|own| own.is_motor()) {
            let joint = motor.joint.as_deref().unwrap_or_default();
            // Locked joints are there no more, and two motors on one joint are one input.
            if self.model.joint(joint).is_some() && driven.insert(joint) {
                motors.push(joint);
            }
        }
        let simulator = Simulator::new(model)
            .with_time_step(self.options.time_step)
            .with_integrator(self.options.integrator)
            .with_actuation(Actuation::from_model(&self.model));
        let simulator = match simulator.clone().with_actuated_joints(&motors) {
            Ok(simulator) => simulator,
            Err(_) => simulator,
        };
        let simulator = match self.constraints.is_empty() {
            true => simulator,
            false => simulator.with_constraints(self.constraints.clone()),
        };
        match self.ground_contacts() {
            Some(contacts) => simulator.with_contacts(contacts),
            None => simulator,
        }
    }

    /// Contacts of the geoms that touch the ground; `None` without ground or such geoms.
    fn ground_contacts(&self) -> Option<Contacts> {
        let (pose, ground) = self.contacts.ground.as_ref()?;
        let law = |friction: f64| {
            ContactLaw::RelaxedRigid(RelaxedRigid {
                friction,
                friction_impedance_ratio: self.options.impratio,
                ..RelaxedRigid::default()
            })
        };
        let touching = || self.contacts.geoms.iter().filter(|own| own.touches(ground));
        let moving = |own: &&MjcfGeom| self.moves(&own.link);
        let mut links: Vec<&str> = touching().filter(moving).map(|own| &*own.link).collect();
        links.dedup();
        if links.is_empty() {
            return None;
        }
        let contacts = Contacts::new(&self.model, terrain(pose)?, law(ground.friction[0]));
        let mut contacts = contacts.with_links(&self.model, &links).ok()?;
        for link in links {
            let own = touching().filter(|own| own.link == link);
            let friction = own.map(|own| friction(own, ground)).fold(0.0, f64::max);
            contacts = contacts.with_law(&self.model, link, law(friction)).ok()?;
        }
        Some(contacts)
    }

    fn moves(&self, link: &str) -> bool {
        let frame = self.model.frame(link);
        frame.is_some_and(|frame| self.model.frames()[frame.0].body.is_some())
    }
}

/// Friction of two geoms: that of the one with priority, or else the larger.
fn friction(one: &MjcfGeom, other: &MjcfGeom) -> f64 {
    let [a, b] = [one, other].map(|own| match own.condim {
        1 => 0.0,
        _ => own.friction[0],
    });
    match one.priority.cmp(&other.priority) {
        std::cmp::Ordering::Greater => a,
        std::cmp::Ordering::Less => b,
        std::cmp::Ordering::Equal => a.max(b),
    }
}

/// The plane z = 0 of a pose as terrain, if its normal points up.
fn terrain(pose: &Transform<f64>) -> Option<Terrain> {
    /// Least height of the normal: steeper ground has no height over its points.
    const LEAST: f64 = 1e-3;
    let normal = pose.rotation.column(2).into_owned();
    let is_finite = pose.translation.iter().all(|x| x.is_finite());
    (is_finite && normal.z > LEAST).then(|| Terrain::plane(pose.translation.into(), normal.into()))
}

impl Simulator<f64> {
    /// Makes a simulator of everything that an MJCF file holds and this library can use; see [`MjcfScene::simulator`].
    ///
    /// # Errors
    /// See [`LoadError`].
    ///
    /// # Panics
    /// If the mass matrix of the model is singular.
    pub fn from_mjcf_file(path: impl AsRef<Path>) -> Result<Self, LoadError> {
        let options = ModelOptions::default();
        Ok(options.load_mjcf_scene_file(path)?.0.simulator())
    }
}
