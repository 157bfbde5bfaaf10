//! Items of a recording besides the robots.

use dualbody::spatial::Transform;
use dualbody::view::{Camera, Track};
use nalgebra::Vector3;

use super::recording::PyRecording;
use crate::contact::terrain_of;
use crate::model::{read_geometry, read_pose};
use crate::prelude::*;

fn transform(placement: Option<&Bound<'_, PyAny>>) -> PyResult<Transform<f64>> {
    placement.map_or(Ok(Transform::identity()), |pose| {
        read_pose("placement", pose)
    })
}

impl PyRecording {
    /// Changes what is shown of a robot, by its index; of the first one if none is given.
    fn of_robot<'a, R>(
        &'a mut self,
        robot: Option<&Bound<'_, PyAny>>,
        change: impl FnOnce(&'a mut Track) -> R,
    ) -> PyResult<R> {
        let robot = robot.map_or(Ok(0), |robot| whole("robot", robot))?;
        guarded(|| change(self.recording.robot_mut(robot)))
    }
}

#[pymethods]
impl PyRecording {
    /// Adds a scalar for each time, plotted over time.
    fn add_series(&mut self, name: String, values: &Bound<'_, PyAny>) -> PyResult<()> {
        let values = read_vector("values", values, Some(self.recording.len()))?;
        guarded(|| self.recording.add_series(name, values)).map(drop)
    }

    /// Places the robots side by side.
    fn spread(&mut self, distance: f64) -> PyResult<()> {
        guarded(|| self.recording.spread(distance)).map(drop)
    }

    /// Draws a terrain.
    fn show_ground(&mut self, terrain: &Bound<'_, PyAny>) -> PyResult<()> {
        let terrain = terrain_of(terrain)?;
        guarded(|| self.recording.show_ground(&terrain)).map(drop)
    }
}

methods! { PyRecording {
    /// Draws the path of a frame.
    #[pyo3(text_signature = "($self, frame, robot=0)")]
    fn trace(&mut self, frame: &str, robot = None) -> PyResult<()> {
        self.of_robot(robot, |own| own.trace(frame))?.map(drop).or_raise()
    }

    /// Draws the axes of a frame.
    #[pyo3(text_signature = "($self, frame, robot=0)")]
    fn show_frame(&mut self, frame: &str, robot = None) -> PyResult<()> {
        self.of_robot(robot, |own| own.show_frame(frame))?.map(drop).or_raise()
    }

    /// Draws forces at the origin of a frame, in the world's axes: (len, 3), N.
    #[pyo3(text_signature = "($self, frame, values, robot=0)")]
    fn add_force(&mut self, frame: &str, values, robot = None) -> PyResult<()> {
        let shape = [self.recording.len(), 3];
        let rows = Rows::read(&argument("values", values, &shape))?;
        let forces = rows.as_slice().chunks(3).map(Vector3::from_column_slice);
        self.of_robot(robot, |own| own.add_force(frame, forces).map(drop))?.or_raise()
    }

    /// Draws the forces that act in a simulator, frame by frame.
    #[pyo3(text_signature = "($self, simulator, robot=0)")]
    fn add_applied_forces(&mut self, simulator: &Bound<'py, PySimulator>, robot = None) -> PyResult<()> {
        let simulator = &simulator.get().simulator;
        self.of_robot(robot, |own| own.add_applied_forces(simulator)).map(drop)
    }

    /// Displays a robot at another position, by a pose (4, 4) or a translation.
    #[pyo3(text_signature = "($self, placement, robot=0)")]
    fn place(&mut self, placement, robot = None) -> PyResult<()> {
        let placement = read_pose("placement", placement)?;
        self.of_robot(robot, |own| own.place(placement)).map(drop)
    }

    /// Adds a fixed shape (Box, Sphere, …).
    #[pyo3(text_signature = "($self, name, shape, placement=None, color=(0.6, 0.6, 0.65, 1.0))")]
    fn add_shape(&mut self, name: String, shape, placement = None, color: [f64; 4] = [0.6, 0.6, 0.65, 1.0]) -> PyResult<()> {
        let (geometry, placement) = (read_geometry(shape)?, transform(placement)?);
        guarded(|| self.recording.add_shape(name, geometry, placement, color)).map(drop)
    }

    /// Adds fixed axes.
    fn add_axes(&mut self, name: String, placement = None) -> PyResult<()> {
        let placement = transform(placement)?;
        guarded(|| self.recording.add_axes(name, placement)).map(drop)
    }

    /// Sets the camera: target point (m), distance (m), azimuth and elevation (degrees).
    fn set_camera(&mut self, look_at: [f64; 3], distance: f64, azimuth: f64, elevation: f64) -> PyResult<()> {
        let camera = Camera {
            look_at,
            distance,
            azimuth,
            elevation,
        };
        let recording = self.recording.clone();
        self.recording = guarded(|| recording.with_camera(camera))?;
        Ok(())
    }
} }
