//! Scene objects and ground of a recording.

use super::ground::Heights;
use super::motion::each_pose;
use super::recording::Recording;
use super::scene_object::{Appearance, SceneObject};
use crate::contact::Terrain;
use crate::model::Geometry;
use crate::scalar::MapEach;
use crate::spatial::Transform;

/// Moments of the motion at which one looks where the robots are.
const MOMENTS: usize = 200;

/// Margin of the ground beyond the motion, relative to the length of its diagonal, and the least margin, m.
const MARGIN: f64 = 0.25;
const LEAST_MARGIN: f64 = 0.5;

impl Recording {
    /// Draws a fixed shape, such as an obstacle or a wall.
    ///
    /// * `name` – display name
    /// * `placement` – its pose in the world
    /// * `color` – red, green, blue, opacity in 0..1
    ///
    /// # Panics
    /// If a number is not finite.
    ///
    /// # Examples
    /// ```
    /// use dualbody::model::{Geometry, samples};
    /// use dualbody::{spatial::Transform, view::Recording};
    ///
    /// let mut recording = Recording::new(&samples::arm());
    /// let ball = Geometry::Sphere { radius: 0.1 };
    /// let place = Transform::from_translation([0.4, 0.0, 0.3].into());
    /// recording.add_shape("ball", ball, place, [0.9, 0.3, 0.2, 1.0]).add_axes("goal", Transform::identity());
    /// assert_eq!(recording.scene_objects().len(), 2);
    /// ```
    pub fn add_shape(
        &mut self,
        name: impl Into<String>,
        geometry: Geometry,
        placement: Transform<f64>,
        color: [f64; 4],
    ) -> &mut Self {
        self.add_object(
            name.into(),
            placement,
            Appearance::Solid { geometry, color },
        )
    }

    /// Draws fixed axes, such as those of a target pose.
    ///
    /// * `name` – display name
    /// * `placement` – their pose in the world
    ///
    /// # Panics
    /// If a number is not finite.
    pub fn add_axes(&mut self, name: impl Into<String>, placement: Transform<f64>) -> &mut Self {
        self.add_object(name.into(), placement, Appearance::Axes)
    }

    pub(super) fn add_object(
        &mut self,
        name: String,
        placement: Transform<f64>,
        appearance: Appearance,
    ) -> &mut Self {
        let numbers = placement
            .to_entries()
            .into_iter()
            .chain(appearance.numbers());
        let are_finite = numbers.into_iter().all(f64::is_finite);
        assert!(are_finite, "\"{name}\" has a number that is not finite");
        self.scene_objects.push(SceneObject {
            name,
            placement,
            appearance,
        });
        self
    }

    /// The scene objects.
    pub fn scene_objects(&self) -> &[SceneObject] {
        &self.scene_objects
    }

    /// Draws the ground of a simulation in and around the region of the motion: a level plane as the floor of the picture, other ground as a
    /// piecewise linear surface. Its position is that for robots without their own [placement](super::Track::place).
    ///
    /// # Panics
    /// If the ground has no finite height in that region.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{State, contact::Terrain, model::samples, view::Recording};
    ///
    /// let mut recording = Recording::new(&samples::pendulum());
    /// recording.push(0.0, &State::new(&[1.0], &[0.0]), &[]);
    /// recording.show_ground(&Terrain::incline(0.2));
    /// assert_eq!(recording.scene_objects()[0].name, "ground");
    /// ```
    pub fn show_ground(&mut self, terrain: &Terrain) -> &mut Self {
        let ground = Heights::of(terrain, self.rectangle());
        self.add_object(
            "ground".into(),
            Transform::identity(),
            Appearance::Ground(ground),
        )
    }

    /// The lower and the upper corner of the rectangle in which the bodies move, with a margin.
    fn rectangle(&self) -> [[f64; 2]; 2] {
        let (mut from, mut to) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let step = self.len().div_ceil(MOMENTS).max(1);
        let moments: Vec<usize> = (0..self.len()).step_by(step).collect();
        for track in &self.robots {
            each_pose(track, &moments, |pose| {
                for axis in 0..2 {
                    from[axis] = pose.translation[axis].min(from[axis]);
                    to[axis] = pose.translation[axis].max(to[axis]);
                }
            });
        }
        if from[0] > to[0] {
            (from, to) = ([0.0; 2], [0.0; 2]);
        }
        let margin = LEAST_MARGIN + MARGIN * (to[0] - from[0]).hypot(to[1] - from[1]);
        [from.map_each(|x| x - margin), to.map_each(|x| x + margin)]
    }
}
