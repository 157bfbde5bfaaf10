//! The bodies whose motions and forces sensors take.

use super::held_links::HeldLinks;
use super::sensor::Sensor;
use crate::dynamics::to_world;
use crate::model::{BodyId, Model};

/// Indices of bodies, each list ascending.
#[derive(Clone, Debug, Default)]
pub(super) struct Needs {
    /// Bodies whose poses in their parents and velocities are needed, each with all of its ancestors; they contain those of the other lists.
    pub(super) moving: Vec<usize>,
    /// Bodies whose accelerations are needed, each with all of its ancestors.
    pub(super) accelerated: Vec<usize>,
    /// Bodies whose motions sensors read, where all are known: without the ancestors from which they follow.
    pub(super) read: Vec<usize>,
    /// Bodies whose poses in the world are needed, each with all of its ancestors.
    pub(super) placed: Vec<usize>,
    /// Bodies whose joints' forces are needed, each with all of its descendants.
    pub(super) loaded: Vec<usize>,
}

/// Marks of the bodies of a model.
struct Marks<'a> {
    model: &'a Model,
    moving: Vec<bool>,
    accelerated: Vec<bool>,
    read: Vec<bool>,
    placed: Vec<bool>,
    loaded: Vec<bool>,
}

impl Needs {
    /// * `sensors` – with the links that force–torque sensors hold
    pub(super) fn new<'s>(
        model: &Model,
        sensors: impl Iterator<Item = (&'s Sensor, Option<&'s HeldLinks>)>,
    ) -> Self {
        let mut marks = Marks::new(model);
        sensors.for_each(|(sensor, held)| marks.add(sensor, held));
        marks.finish()
    }

    /// These, with the poses of all bodies.
    pub(super) fn with_all_placed(&self, n: usize) -> Self {
        Self {
            moving: (0..n).collect(),
            read: (0..n).collect(),
            placed: (0..n).collect(),
            ..self.clone()
        }
    }
}

impl<'a> Marks<'a> {
    fn new(model: &'a Model) -> Self {
        let none = vec![false; model.n_bodies()];
        Self {
            model,
            moving: none.clone(),
            accelerated: none.clone(),
            read: none.clone(),
            placed: none.clone(),
            loaded: none,
        }
    }

    fn add(&mut self, sensor: &Sensor, held: Option<&HeldLinks>) {
        let model = self.model;
        let body = sensor
            .frame()
            .and_then(|frame| model.frames()[frame.0].body);
        if let Some(body) = body {
            let is_contact = matches!(sensor, Sensor::Touch(_) | Sensor::ContactForce(_));
            self.read[body.0] |= !is_contact;
        }
        match *sensor {
            Sensor::JointForce(joint) => {
                (model.joint_bodies(joint)).for_each(|id| self.load(id));
            }
            Sensor::Gyro(_) => mark(model, &mut self.moving, body),
            Sensor::Accelerometer(_) => mark(model, &mut self.accelerated, body),
            Sensor::Magnetometer { .. } | Sensor::FramePose(_) | Sensor::FrameVelocity { .. } => {
                mark(model, &mut self.placed, body);
            }
            Sensor::FrameAcceleration { .. } => {
                mark(model, &mut self.accelerated, body);
                mark(model, &mut self.placed, body);
            }
            Sensor::Wrench(_) => {
                let loaded = held.map_or_else(Vec::new, HeldLinks::loaded);
                loaded.into_iter().for_each(|id| self.load(id));
                mark(model, &mut self.accelerated, body);
                if held.is_some_and(HeldLinks::need_pose) {
                    mark(model, &mut self.placed, body);
                }
            }
            // Shapes may be on any body.
            Sensor::RangeFinder { .. }
            | Sensor::Lidar { .. }
            | Sensor::CenterOfMass
            | Sensor::CenterOfMassVelocity
            | Sensor::Momentum => self.placed.fill(true),
            Sensor::JointPosition(_)
            | Sensor::JointVelocity(_)
            | Sensor::Touch(_)
            | Sensor::ContactForce(_) => {}
        }
    }

    /// The forces of the joints beyond a body, and of its own.
    fn load(&mut self, body: BodyId) {
        let range = body.0..self.model.body(body).subtree_end;
        self.loaded[range].fill(true);
    }

    fn finish(mut self) -> Needs {
        for i in (0..self.loaded.len()).filter(|&i| self.loaded[i]) {
            mark(self.model, &mut self.accelerated, Some(BodyId(i)));
        }
        for (i, read) in self.read.iter_mut().enumerate() {
            *read |= self.loaded[i] || self.placed[i];
        }
        let others = self.accelerated.iter().zip(&self.placed);
        for (moving, (accelerated, placed)) in self.moving.iter_mut().zip(others) {
            *moving |= accelerated | placed;
        }
        let list = |marks: &[bool]| (0..marks.len()).filter(|&i| marks[i]).collect();
        Needs {
            moving: list(&self.moving),
            accelerated: list(&self.accelerated),
            read: list(&self.read),
            placed: list(&self.placed),
            loaded: list(&self.loaded),
        }
    }
}

/// Marks a body and all of its ancestors.
fn mark(model: &Model, marks: &mut [bool], body: Option<BodyId>) {
    to_world(model, body).for_each(|(id, _)| marks[id.0] = true);
}
