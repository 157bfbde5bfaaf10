//! One robot of a recording.

use nalgebra::Vector3;

use crate::error::UnknownName;
use crate::model::{FrameId, Model};
use crate::sim::column_names;
use crate::spatial::Transform;

/// The motion of one robot: rows of numbers, one for each time of the recording.
///
/// Where nothing is known, as for the input that would follow the last state, a number is NaN.
#[derive(Clone, Debug)]
pub struct Track {
    pub(super) name: String,
    pub(super) model: Model,
    pub(super) placement: Transform<f64>,
    pub(super) q: Rows,
    pub(super) v: Rows,
    pub(super) u: Rows,
    pub(super) traces: Vec<FrameId>,
    pub(super) frames: Vec<FrameId>,
    pub(super) forces: Vec<ForceTrack>,
}

/// A force on a frame over time, to be drawn as an arrow at the frame's origin.
#[derive(Clone, Debug)]
pub struct ForceTrack {
    /// Where it acts.
    pub frame: FrameId,
    /// The force at each time of the recording, along the world's axes, N.
    pub values: Vec<Vector3<f64>>,
}

/// Rows of equal width, one after the other.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Rows {
    pub(super) width: usize,
    pub(super) length: usize,
    pub(super) numbers: Vec<f64>,
}

impl Rows {
    pub(super) fn new(width: usize) -> Self {
        Self {
            width,
            ..Self::default()
        }
    }

    pub(super) fn from_columns(columns: &[&[f64]], length: usize) -> Self {
        let row = |k: usize| columns.iter().map(move |column| column[k]);
        Self {
            width: columns.len(),
            length,
            numbers: (0..length).flat_map(row).collect(),
        }
    }

    pub(super) fn row(&self, k: usize) -> &[f64] {
        &self.numbers[k * self.width..(k + 1) * self.width]
    }

    pub(super) fn column(&self, j: usize) -> impl Iterator<Item = f64> + '_ {
        self.numbers[j..].iter().copied().step_by(self.width)
    }

    pub(super) fn push(&mut self, row: &[f64], what: &str) {
        let (given, width) = (row.len(), self.width);
        assert_eq!(given, width, "{what} has {width} entries");
        self.numbers.extend_from_slice(row);
        self.length += 1;
    }

    /// A row of which nothing is known.
    pub(super) fn push_unknown(&mut self) {
        let longer = self.numbers.len() + self.width;
        self.numbers.resize(longer, f64::NAN);
        self.length += 1;
    }

    /// Makes columns out of nothing, unknown in the past.
    pub(super) fn widen(&mut self, width: usize) {
        self.width = width;
        self.numbers = vec![f64::NAN; width * self.length];
    }
}

impl Track {
    pub(super) fn new(name: &str, model: &Model) -> Self {
        Self {
            name: name.into(),
            model: model.clone(),
            placement: Transform::identity(),
            q: Rows::new(model.nq()),
            v: Rows::new(model.nv()),
            u: Rows::new(0),
            traces: Vec::new(),
            frames: Vec::new(),
            forces: Vec::new(),
        }
    }

    /// Its name in the recording.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The robot.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The configuration at the `k`-th time, length `nq`.
    ///
    /// # Panics
    /// If there is no such time.
    pub fn q(&self, k: usize) -> &[f64] {
        self.q.row(k)
    }

    /// The velocity at the `k`-th time, length `nv`.
    ///
    /// # Panics
    /// If there is no such time.
    pub fn v(&self, k: usize) -> &[f64] {
        self.v.row(k)
    }

    /// The input that acts from the `k`-th time on; NaN where there is none.
    ///
    /// # Panics
    /// If there is no such time.
    pub fn u(&self, k: usize) -> &[f64] {
        self.u.row(k)
    }

    /// Number of inputs.
    pub fn nu(&self) -> usize {
        self.u.width
    }

    /// The forces to draw.
    pub fn forces(&self) -> &[ForceTrack] {
        &self.forces
    }

    /// The frames whose paths are drawn.
    pub fn traces(&self) -> &[FrameId] {
        &self.traces
    }

    /// The frames whose axes are drawn.
    pub fn frames(&self) -> &[FrameId] {
        &self.frames
    }

    /// Draws the path of a frame.
    ///
    /// # Errors
    /// If the robot has no frame of that name.
    pub fn trace(&mut self, frame: &str) -> Result<&mut Self, UnknownName> {
        self.traces.push(self.model.find_frame(frame)?);
        Ok(self)
    }

    /// Draws the axes of a frame.
    ///
    /// # Errors
    /// If the robot has no frame of that name.
    pub fn show_frame(&mut self, frame: &str) -> Result<&mut Self, UnknownName> {
        self.frames.push(self.model.find_frame(frame)?);
        Ok(self)
    }

    /// Draws a force as an arrow from the origin of a frame.
    ///
    /// * `values` – the force at each time, along the world's axes, N
    ///
    /// # Errors
    /// If the robot has no frame of that name.
    ///
    /// # Panics
    /// If there is not one force for each time.
    pub fn add_force(
        &mut self,
        frame: &str,
        values: impl IntoIterator<Item = Vector3<f64>>,
    ) -> Result<&mut Self, UnknownName> {
        let frame = self.model.find_frame(frame)?;
        let values: Vec<_> = values.into_iter().collect();
        assert_eq!(values.len(), self.len(), "one force for each time");
        self.forces.push(ForceTrack { frame, values });
        Ok(self)
    }

    /// Sets the force on a frame at the last moment, while moments are pushed; zero at those without one.
    ///
    /// * `value` – along the world's axes, N
    ///
    /// # Errors
    /// If the robot has no frame of that name.
    ///
    /// # Panics
    /// If there is no moment yet.
    pub fn set_force(
        &mut self,
        frame: &str,
        value: Vector3<f64>,
    ) -> Result<&mut Self, UnknownName> {
        assert!(self.len() > 0, "the force on \"{frame}\" has no moment yet");
        let id = self.model.find_frame(frame)?;
        let known = self.forces.iter().position(|force| force.frame == id);
        let at = known.unwrap_or(self.forces.len());
        if at == self.forces.len() {
            self.add_force(frame, vec![Vector3::zeros(); self.len()])?;
        }
        let last = self.len() - 1;
        self.forces[at].values[last] = value;
        Ok(self)
    }

    /// Stands the robot elsewhere in the picture, so that several do not cover one another. Its numbers stay as they are.
    pub fn place(&mut self, placement: Transform<f64>) -> &mut Self {
        self.placement = placement;
        self
    }

    /// Number of times.
    pub(super) fn len(&self) -> usize {
        self.q.length
    }

    /// The name of a frame.
    pub(super) fn frame_name(&self, frame: FrameId) -> &str {
        &self.model.frames()[frame.0].name
    }

    /// Names of the columns q, v, u, and three for each force.
    pub(super) fn column_names(&self) -> Vec<String> {
        let mut names = column_names(&self.model);
        names.extend((0..self.nu()).map(|k| format!("u{k}")));
        for force in &self.forces {
            let frame = self.frame_name(force.frame);
            names.extend(["x", "y", "z"].map(|axis| format!("f.{frame}.{axis}")));
        }
        names
    }

    /// The numbers of the columns at the `k`-th time.
    pub(super) fn row(&self, k: usize) -> impl Iterator<Item = f64> + '_ {
        let rows = [&self.q, &self.v, &self.u];
        let states = rows.into_iter().flat_map(move |rows| rows.row(k));
        let forces = self.forces.iter().flat_map(move |force| &force.values[k]);
        states.chain(forces).copied()
    }
}
