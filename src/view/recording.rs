//! Recordings of simulations.

use std::collections::{HashMap, HashSet};

use super::camera::Camera;
use super::rows::Rows;
use super::scene_object::SceneObject;
use super::track::Track;
use crate::model::Model;
use crate::sim::{BatchRollout, BatchSimulator, Rollout, Simulator, State};
use crate::spatial::Transform;
use nalgebra::Vector3;

/// States, inputs and further data of one or several robots, over one time axis. See the
/// [module](super).
///
/// # Examples
/// ```
/// use dualbody::{Simulator, State, model::samples, view::Recording};
///
/// let simulator = Simulator::new(samples::pendulum()).with_time_step(0.01);
/// let mut recording = Recording::new(simulator.model());
/// let mut state = State::new(&[1.0], &[0.0]);
/// for k in 0..100 {
///     let torque = [-0.5 * state.v[0]];
///     recording.push(0.01 * k as f64, &state, &torque);
///     state = simulator.step(&state, &torque);
/// }
/// recording.add_series("height of the tip [m]", (0..100).map(|k| -f64::cos(recording.robots()[0].state(k).q[0])).collect::<Vec<_>>());
/// recording.robot_mut(0).trace("rod")?;
/// assert_eq!(recording.len(), 100);
/// # Ok::<(), dualbody::UnknownName>(())
/// ```
#[derive(Clone, Debug)]
pub struct Recording {
    pub(super) title: String,
    pub(super) times: Vec<f64>,
    pub(super) robots: Vec<Track>,
    pub(super) series: Vec<Series>,
    pub(super) scene_objects: Vec<SceneObject>,
    pub(super) camera: Option<Camera>,
}

/// A scalar over time, drawn as a curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Display name of the series; `… [unit]` at its end is the unit.
    pub name: String,
    /// Value at each time; NaN for none.
    pub values: Vec<f64>,
}

/// Checks that a moment follows the last one.
///
/// # Panics
/// If it does not; the message names both times.
pub(super) fn check_later(time: f64, last: Option<f64>) {
    assert!(time.is_finite(), "the time {time} s is not finite");
    if let Some(last) = last {
        assert!(time > last, "the time {time} s is not after {last} s");
    }
}

#[expect(
    clippy::len_without_is_empty,
    reason = "a count, none of which is rare"
)]
impl Recording {
    /// Makes an empty recording of one robot; fill it with [`push`](Self::push).
    pub fn new(model: &Model) -> Self {
        Self::of_robots(&[model])
    }

    /// Makes an empty recording of several robots; fill it with [`push_all`](Self::push_all). Robots of equal name are numbered.
    ///
    /// # Panics
    /// If the list of robots is empty.
    pub fn of_robots(models: &[&Model]) -> Self {
        assert!(
            !models.is_empty(),
            "a recording has 0 robots, expected at least 1"
        );
        let names = distinct_names(models).into_iter();
        let tracks = names.zip(models).map(|(name, m)| Track::new(&name, m));
        Self {
            title: models[0].name().into(),
            times: Vec::new(),
            robots: tracks.collect(),
            series: Vec::new(),
            scene_objects: Vec::new(),
            camera: None,
        }
    }

    /// Makes a recording of the states, with contact states, and the inputs of a rollout. The last state has no input.
    ///
    /// # Panics
    /// If the rollout belongs to a robot with other names, joints or tree. Variants of equal structure are allowed.
    pub fn from_rollout(model: &Model, rollout: &Rollout) -> Self {
        rollout.check_robot(model);
        let mut recording = Self::new(model);
        let nu = rollout.inputs.first().map_or(0, |u| u.len());
        let track = &mut recording.robots[0];
        track.u = Rows::new(nu);
        track.inputs = rollout.input_names.clone();
        for (k, state) in rollout.states.iter().enumerate() {
            track.push(state);
            match rollout.inputs.get(k) {
                Some(u) => track.u.push(u.as_slice(), "u"),
                None => track.u.push_unknown(),
            }
        }
        recording.times = rollout.times().collect();
        recording
    }

    /// Makes a recording of a rollout with constraints and, for a simulator with contact, the ground and the contact points with their forces.
    /// Contact forces cost one step for each time in the viewer.
    ///
    /// # Panics
    /// If the rollout is one of another robot.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, State, model::samples, view::Recording};
    ///
    /// let simulator = Simulator::new(samples::cartpole());
    /// let rollout = simulator.rollout(&State::new(&[0.0, 0.5], &[0.0; 2]), 10, |_, _, _| {});
    /// assert_eq!(Recording::of_simulation(&simulator, &rollout).len(), 11);
    /// ```
    pub fn of_simulation(simulator: &Simulator, rollout: &Rollout) -> Self {
        let mut out = Self::from_rollout(simulator.model(), rollout);
        out.robots[0].show_constraints(simulator.constraints());
        if let Some(contacts) = simulator.contacts() {
            out.show_ground(contacts.terrain());
            out.show_contacts(simulator);
        }
        out
    }

    /// Makes a recording of some trajectories of a batch. Trajectories that stopped early are unknown afterwards; the viewer shows their last state.
    /// A batch keeps no inputs.
    ///
    /// * `which` – indices into the batch
    ///
    /// # Panics
    /// If the rollout belongs to another batch, an index is out of range, or there are no indices.
    pub fn from_batch(batch: &BatchSimulator, rollout: &BatchRollout, which: &[usize]) -> Self {
        rollout.check_batch(batch);
        let models: Vec<_> = which.iter().map(|&i| batch.simulator(i).model()).collect();
        let mut recording = Self::of_robots(&models);
        let length = which.iter().map(|&i| rollout.n_states(i)).max();
        let length = length.unwrap_or(0);
        for (track, &i) in recording.robots.iter_mut().zip(which) {
            for k in 0..length {
                track.u.push_unknown();
                if k < rollout.n_states(i) {
                    track.q.push(rollout.q(i, k), "q");
                    track.v.push(rollout.v(i, k), "v");
                    let contact = rollout.contact(i, k);
                    track.contact.push_if_known(contact, "the contact state");
                    let activation = rollout.activation(i, k);
                    track
                        .activation
                        .push_if_known(activation, "the activations");
                    track
                        .sleep
                        .push_if_known(rollout.sleep(i, k), "what sleeps");
                } else {
                    let motion = [&mut track.q, &mut track.v];
                    let others = [&mut track.contact, &mut track.activation, &mut track.sleep];
                    let rows = motion.into_iter().chain(others);
                    rows.for_each(Rows::push_unknown);
                }
            }
        }
        recording.times = (0..length).map(|k| k as f64 * rollout.time_step).collect();
        recording
    }

    /// Adds a time with its state and the input from this time on. An empty `u` means that the input is unknown; likewise for the contact state.
    ///
    /// * `time` – s, later than the previous one
    ///
    /// # Panics
    /// If the time is not later, a slice has the wrong length, or the recording has several robots.
    pub fn push(&mut self, time: f64, state: &State, u: &[f64]) {
        self.push_all(time, &[(state, u)]);
    }

    /// [`push`](Self::push) for several robots. At the new time, series are unknown and forces zero until they are set.
    ///
    /// # Panics
    /// As [`push`](Self::push), and if there is not one state for each robot.
    pub fn push_all(&mut self, time: f64, moments: &[(&State, &[f64])]) {
        self.check_next(time, moments.len());
        for (track, (state, u)) in self.robots.iter_mut().zip(moments) {
            track.push(state);
            track.u.push_if_known(u, "u");
            let forces = track.forces.iter_mut();
            forces.for_each(|force| force.values.push(Vector3::zeros()));
        }
        self.times.push(time);
        let series = self.series.iter_mut();
        series.for_each(|series| series.values.push(f64::NAN));
    }

    fn check_next(&self, time: f64, given: usize) {
        check_later(time, self.times.last().copied());
        assert_eq!(given, self.robots.len(), "one state for each robot");
    }

    /// Adds a named scalar, with one value for each time.
    ///
    /// # Panics
    /// If there is not one value for each time.
    pub fn add_series(
        &mut self,
        name: impl Into<String>,
        values: impl IntoIterator<Item = f64>,
    ) -> &mut Self {
        let (name, values): (_, Vec<f64>) = (name.into(), values.into_iter().collect());
        let (given, length) = (values.len(), self.len());
        assert_eq!(given, length, "\"{name}\" has one value for each time");
        self.series.push(Series { name, values });
        self
    }

    /// Sets the title, which is the name of the first robot by default.
    #[must_use]
    pub fn with_title(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// Sets the camera; by default the whole motion is in the picture.
    ///
    /// # Panics
    /// If a number is not finite.
    #[must_use]
    pub fn with_camera(mut self, camera: Camera) -> Self {
        assert!(
            camera.is_finite(),
            "{camera:?} has a number that is not finite"
        );
        self.camera = Some(camera);
        self
    }

    /// Displays the robots on a square grid with a given distance (m). Their recorded values are unchanged.
    ///
    /// # Panics
    /// If the distance is not finite.
    pub fn spread(&mut self, distance: f64) -> &mut Self {
        let n = self.robots.len();
        let columns = (1..).find(|c| c * c >= n).unwrap_or(1);
        let rows = n.div_ceil(columns);
        let at = |i: usize, n: usize| distance * (i as f64 - 0.5 * (n - 1) as f64);
        for (k, track) in self.robots.iter_mut().enumerate() {
            let (x, y) = (at(k / columns, rows), at(k % columns, columns));
            track.place(Transform::from_translation(Vector3::new(x, y, 0.0)));
        }
        self
    }

    /// Title of the viewer: the name of the first robot, unless [set](Self::with_title).
    pub fn title(&self) -> &str {
        &self.title
    }

    /// Number of recorded times.
    pub fn len(&self) -> usize {
        self.times.len()
    }

    /// Times, s, each later than the one before.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Robots with their motions.
    pub fn robots(&self) -> &[Track] {
        &self.robots
    }

    /// A robot, mutable, for its display settings.
    ///
    /// # Panics
    /// If there is no such robot.
    pub fn robot_mut(&mut self, i: usize) -> &mut Track {
        &mut self.robots[i]
    }

    /// Scalars over time, by name.
    pub fn series(&self) -> &[Series] {
        &self.series
    }
}

/// A name for each robot: its own, with a number where several share it, and no name twice.
fn distinct_names(models: &[&Model]) -> Vec<String> {
    let mut of_name: HashMap<&str, usize> = HashMap::new();
    for model in models {
        *of_name.entry(model.name()).or_default() += 1;
    }
    let mut taken: HashSet<String> = of_name.keys().map(|&name| name.into()).collect();
    let mut number = |name: &str, first: usize| {
        let mut numbers = (first..).map(|k| format!("{name} {k}"));
        let free = numbers.find(|name| taken.insert(name.clone()));
        free.unwrap_or_else(|| unreachable!("there are more numbers than robots"))
    };
    let names = models.iter().zip(1..).map(|(model, k)| match model.name() {
        name if of_name[name] == 1 => name.to_owned(),
        name => number(name, k),
    });
    names.collect()
}
