//! One robot of a recording.

use nalgebra::{DVector, Vector3};

use super::bond::Bond;
use super::rows::Rows;
use super::touches::Touches;
use crate::constraint::Constraint;
use crate::error::UnknownName;
use crate::model::{FrameId, Model, numbered};
use crate::nested::IntoNested;
use crate::sim::{State, column_names, input_columns};
use crate::spatial::Transform;

/// The motion of one robot: one row of values for each time of the recording.
///
/// Unknown values are NaN, for example the input after the last state.
#[derive(Clone, Debug)]
pub struct Track {
    pub(super) name: String,
    pub(super) model: Model,
    pub(super) placement: Transform<f64>,
    pub(super) q: Rows,
    pub(super) v: Rows,
    /// The contact state.
    pub(super) contact: Rows,
    /// Activations of inputs.
    pub(super) activation: Rows,
    /// What sleeps; files do not keep it.
    pub(super) sleep: Rows,
    pub(super) u: Rows,
    /// Names of the inputs; empty if unknown.
    pub(super) inputs: Vec<String>,
    pub(super) traces: Vec<FrameId>,
    pub(super) frames: Vec<FrameId>,
    pub(super) forces: Vec<ForceTrack>,
    pub(super) bonds: Vec<Bond>,
    /// Contact points at some moments, in their order.
    pub(super) touches: Vec<Touches>,
}

/// A force on a frame over time, to be drawn as an arrow at the frame's origin.
#[derive(Clone, Debug)]
pub struct ForceTrack {
    /// Frame that the force acts on, at its origin.
    pub frame: FrameId,
    /// The force at each time of the recording, along world axes, N.
    pub values: Vec<Vector3<f64>>,
}

impl Track {
    pub(super) fn new(name: &str, model: &Model) -> Self {
        Self {
            name: name.into(),
            model: model.clone(),
            placement: Transform::identity(),
            q: Rows::new(model.nq()),
            v: Rows::new(model.nv()),
            contact: Rows::new(0),
            activation: Rows::new(0),
            sleep: Rows::new(0),
            u: Rows::new(0),
            inputs: Vec::new(),
            traces: Vec::new(),
            frames: Vec::new(),
            forces: Vec::new(),
            bonds: Vec::new(),
            touches: Vec::new(),
        }
    }

    /// Adds a state.
    pub(super) fn push(&mut self, state: &State) {
        self.q.push(state.q.as_slice(), "q");
        self.v.push(state.v.as_slice(), "v");
        let contact = state.contact.as_slice();
        self.contact.push_if_known(contact, "the contact state");
        let activation = state.activation.as_slice();
        self.activation.push_if_known(activation, "the activations");
        let sleep = state.sleep.as_slice();
        self.sleep.push_if_known(sleep, "what sleeps");
    }

    /// Name of the robot in the recording.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Model of the robot.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The configuration at the `k`-th time, length `nq`.
    ///
    /// # Panics
    /// If there is no such time.
    pub(crate) fn q(&self, k: usize) -> &[f64] {
        self.q.row(k)
    }

    /// The velocity at the `k`-th time, length `nv`.
    ///
    /// # Panics
    /// If there is no such time.
    pub(crate) fn v(&self, k: usize) -> &[f64] {
        self.v.row(k)
    }

    /// The state at the `k`-th time with contact state and activations, to continue a simulation: bit-identical to the recorded state, also after
    /// reading a file, except that all is awake in states of files. Unknown values are NaN. Allocates.
    ///
    /// # Panics
    /// If there is no such time.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, State, model::samples, view::Recording};
    ///
    /// let simulator = Simulator::new(samples::cartpole());
    /// let start = State::new(&[0.0, 0.5], &[0.0; 2]);
    /// let recording = Recording::from_rollout(simulator.model(), &simulator.rollout(&start, 10, |_, _, _| {}));
    /// let resumed = simulator.rollout(&recording.robots()[0].state(5), 5, |_, _, _| {});
    /// assert_eq!(*resumed.last(), recording.robots()[0].state(10));
    /// ```
    pub fn state(&self, k: usize) -> State {
        let contact = DVector::from_column_slice(self.contact(k));
        let activation = DVector::from_column_slice(self.activation.row(k));
        State {
            contact,
            activation,
            sleep: DVector::from_column_slice(self.sleep.row(k)),
            ..State::new(self.q(k), self.v(k))
        }
    }

    /// The contact state at the `k`-th time; empty without, NaN where it is not known.
    ///
    /// # Panics
    /// If there is no such time.
    pub(crate) fn contact(&self, k: usize) -> &[f64] {
        self.contact.row(k)
    }

    /// The input from the `k`-th time on; NaN if unknown.
    ///
    /// # Panics
    /// If there is no such time.
    pub fn u(&self, k: usize) -> &[f64] {
        self.u.row(k)
    }

    /// Number of inputs that are recorded.
    pub(crate) fn nu(&self) -> usize {
        self.u.width
    }

    /// Names the inputs, for plots and tables; a rollout already contains these names, see
    /// [`Simulator::input_names`](crate::Simulator::input_names).
    #[cfg(any(test, feature = "live"))]
    pub(crate) fn name_inputs(&mut self, names: Vec<String>) -> &mut Self {
        self.inputs = names;
        self
    }

    /// The forces to draw.
    pub fn forces(&self) -> &[ForceTrack] {
        &self.forces
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

    /// Displays the robot at another position, so that several robots do not overlap. Its recorded values are unchanged.
    ///
    /// # Panics
    /// If a number is not finite.
    pub fn place(&mut self, placement: Transform<f64>) -> &mut Self {
        let are_finite = placement.to_entries().iter().all(|x| x.is_finite());
        let name = &self.name;
        assert!(
            are_finite,
            "the pose of \"{name}\" has a number that is not finite"
        );
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

    /// Names of the columns q, v, contact state, activations, u by what the inputs act on, and three for each force.
    pub(super) fn column_names(&self) -> Vec<String> {
        let mut names = self.state_names();
        names.truncate(names.len() - self.nu());
        names.extend(input_columns(&self.inputs, self.nu()));
        for force in &self.forces {
            names.extend(force_names(self.frame_name(force.frame)));
        }
        names
    }

    /// Names of the columns q, v, contact state, activations and u, whose inputs are numbered.
    pub(super) fn state_names(&self) -> Vec<String> {
        let mut names = column_names(&self.model);
        names.extend(numbered("contact", self.contact.width));
        names.extend(numbered("activation", self.activation.width));
        names.extend(numbered("u", self.nu()));
        names
    }

    /// Name of an input in plots: its own, otherwise that of its column.
    pub(super) fn input_name(&self, k: usize) -> String {
        let name = self.inputs.get(k).cloned();
        name.unwrap_or_else(|| format!("u{k}"))
    }

    /// Recorded rows of q, v, the contact state, activations and u, in the order of the columns.
    pub(super) fn rows(&self) -> [&Rows; 5] {
        [&self.q, &self.v, &self.contact, &self.activation, &self.u]
    }

    /// The numbers of the columns at the `k`-th time.
    pub(super) fn row(&self, k: usize) -> impl Iterator<Item = f64> + '_ {
        let states = self.rows().into_iter().nested(move |rows| rows.row(k));
        let forces = self.forces.iter().nested(move |force| &force.values[k]);
        states.chain(forces).copied()
    }

    /// Draws constraints with the motion of the robot. A rod is drawn as a rod, a ball joint as a ball, a weld as a box, a coupler as a thin line between its joints.
    ///
    /// # Panics
    /// If a constraint is one of another robot.
    pub(crate) fn show_constraints(&mut self, constraints: &[Constraint]) -> &mut Self {
        constraints
            .iter()
            .for_each(|constraint| constraint.check(&self.model));
        let bonds = constraints
            .iter()
            .nested(|constraint| Bond::all(&self.model, constraint));
        self.bonds.extend(bonds);
        self
    }
}

/// Names of the columns of a force on a frame.
pub(super) fn force_names(frame: &str) -> [String; 3] {
    ["x", "y", "z"].map(|axis| format!("f.{frame}.{axis}"))
}
