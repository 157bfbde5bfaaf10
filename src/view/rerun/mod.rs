//! Motions in the [Rerun](https://rerun.io) viewer: as a stream while a simulation runs, or as a file that the viewer
//! opens.
//!
//! | entity | holds |
//! |---|---|
//! | `robots/<robot>` | where the robot stands |
//! | `robots/<robot>/<body>` | the pose of a body over time |
//! | `robots/<robot>/<body>/<k>`, `robots/<robot>/world/<k>` | a shape |
//! | `numbers/<robot>/q/<name>`, `…/v/<name>`, `…/u/<k>` | configuration, velocity and input over time |
//! | `numbers/<name>` | a scalar over time |
//! | `fixtures/<object>`, `fixtures/<object>/<k>` | axes that stand still, a shape that does |
//! | `warnings` | meshes that cannot be shown |
//!
//! Everything that moves stands on one timeline, `time`, in seconds to the nanosecond. Poses are in single precision,
//! as all of the viewer's; numbers are exact.

mod entities;
mod recorded;
mod shapes;
#[cfg(test)]
mod tests;

use std::path::Path;
use std::time::Duration;

use re_sdk::{RecordingStream, RecordingStreamBuilder, RecordingStreamResult};

use self::entities::{Robot, path, transform};
use super::files::{create_folder, name};
use super::recording::{Recording, check_later};
use super::shape;
use crate::dynamics::forward_kinematics_into;
use crate::error::RecordingError;
use crate::model::BodyId;
use crate::sim::State;

/// Longest wait until a viewer has taken everything, s: longer than a viewer on the same machine takes to start.
const FLUSH_TIMEOUT: Duration = Duration::from_secs(10);

/// A stream of robots to the Rerun viewer, step by step.
///
/// An empty [`Recording`] defines the contents: robots, their poses, other objects, the title. The viewer is a separate program: install the version
/// that this stream supports by `pip install rerun-sdk==0.27.3`. Newer versions read the files, but a stream to them may stall, which
/// [`flush`](Self::flush) reports.
///
/// # Examples
/// ```no_run
/// use dualbody::{Simulator, State, model::samples, view::{Recording, RerunStream}};
///
/// let simulator = Simulator::new(samples::pendulum()).with_time_step(0.01);
/// let mut stream = RerunStream::connect(RerunStream::VIEWER, &Recording::new(simulator.model()))?;
/// let mut state = State::new(&[1.0], &[0.0]);
/// for k in 0..1000 {
///     stream.push(0.01 * k as f64, &state, &[0.0]);
///     stream.push_scalar(0.01 * k as f64, "height of the tip [m]", -state.q[0].cos());
///     state = simulator.step(&state, &[0.0]);
/// }
/// stream.flush()?;
/// # Ok::<(), dualbody::RecordingError>(())
/// ```
#[derive(Debug)]
pub struct RerunStream {
    stream: RecordingStream,
    /// Target that errors name: an address or a file.
    target: String,
    robots: Vec<Robot>,
    last: Option<f64>,
}

impl RerunStream {
    /// Address of a viewer that was started on this machine without options.
    pub const VIEWER: &str = re_sdk::DEFAULT_CONNECT_URL;

    /// Streams to a running viewer. Data that are sent before the viewer runs are stored until it does; see [`flush`](Self::flush).
    ///
    /// * `address` – as `rerun+http://127.0.0.1:9876/proxy`, which is [`VIEWER`](Self::VIEWER)
    /// * `scene` – the robots, an empty recording
    ///
    /// # Errors
    /// If the address is invalid.
    pub fn connect(address: &str, scene: &Recording) -> Result<Self, RecordingError> {
        Self::open(address, scene, |builder| builder.connect_grpc_opts(address))
    }

    /// Starts the viewer, which must be on the path as `rerun`, and streams to it. If a viewer runs already, streams to that.
    ///
    /// # Errors
    /// If no viewer can be started.
    pub fn spawn(scene: &Recording) -> Result<Self, RecordingError> {
        Self::open(Self::VIEWER, scene, RecordingStreamBuilder::spawn)
    }

    /// Writes to a file with the ending `.rrd`, complete when the stream is dropped. Makes the folder.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save(path: impl AsRef<Path>, scene: &Recording) -> Result<Self, RecordingError> {
        let path = path.as_ref();
        create_folder(path)?;
        Self::open(&name(path), scene, |builder| builder.save(path))
    }

    fn open(
        target: &str,
        scene: &Recording,
        start: impl FnOnce(RecordingStreamBuilder) -> RecordingStreamResult<RecordingStream>,
    ) -> Result<Self, RecordingError> {
        // The caller requested a viewer, so environment variables must not disable it.
        let builder = RecordingStreamBuilder::new("dualbody")
            .recording_name(scene.title())
            .enabled(true);
        let stream = start(builder).map_err(|error| failed(target, &error))?;
        let robots = scene.robots.iter().map(Robot::new).collect();
        let stream = Self {
            stream,
            target: target.into(),
            robots,
            last: None,
        };
        stream.log_scene(scene);
        Ok(stream)
    }

    /// Sends the data of one time: the poses of all bodies, the state, and the input from this time on, which may be empty.
    /// NaN values are omitted; if a state is not finite, the robot keeps its last pose.
    ///
    /// * `time` – s, later than the one before
    ///
    /// # Panics
    /// If the time is not later, a slice has the wrong length, or there are several robots.
    pub fn push(&mut self, time: f64, state: &State, u: &[f64]) {
        self.push_all(time, &[(state, u)]);
    }

    /// [`push`](Self::push) for several robots.
    ///
    /// # Panics
    /// As [`push`](Self::push), and if there is not one state for each robot.
    pub fn push_all(&mut self, time: f64, moments: &[(&State, &[f64])]) {
        check_later(time, self.last);
        assert_eq!(moments.len(), self.robots.len(), "one state for each robot");
        self.last = Some(time);
        for (robot, (state, u)) in moments.iter().enumerate() {
            self.push_robot(time, robot, [state.q.as_slice(), state.v.as_slice(), u]);
        }
    }

    fn push_robot(&mut self, time: f64, i: usize, [q, v, u]: [&[f64]; 3]) {
        let robot = &mut self.robots[i];
        let (nq, nv) = (robot.model.nq(), robot.model.nv());
        assert_eq!(
            (q.len(), v.len()),
            (nq, nv),
            "q and v have {nq} and {nv} entries"
        );
        let is_known = q.iter().chain(v).all(|x| x.is_finite());
        if is_known {
            forward_kinematics_into(&robot.model, q, v, &mut robot.kinematics);
        }
        let robot = &self.robots[i];
        if is_known {
            for (i, at) in robot.bodies.iter().enumerate() {
                let pose = shape::pose(&robot.kinematics.pose(Some(BodyId(i))));
                self.log(at.clone(), time, &transform(&pose));
            }
        }
        for (at, &x) in robot.columns.iter().zip(q.iter().chain(v)) {
            self.log_number(at.clone(), time, x);
        }
        for (k, &x) in u.iter().enumerate() {
            self.log_number(robot.numbers.join(&path(&["u", &k.to_string()])), time, x);
        }
    }

    /// Sends a scalar; nothing if it is NaN.
    ///
    /// * `time` – s
    pub fn push_scalar(&self, time: f64, name: &str, value: f64) {
        self.log_number(path(&["numbers", name]), time, value);
    }

    /// Waits until the file or the viewer has all data, at most ten seconds.
    ///
    /// # Errors
    /// If data are missing after that time.
    pub fn flush(&self) -> Result<(), RecordingError> {
        let flushed = self.stream.flush_with_timeout(FLUSH_TIMEOUT);
        flushed.map_err(|error| failed(&self.target, &error))
    }
}

fn failed(target: &str, reason: &dyn std::fmt::Display) -> RecordingError {
    RecordingError::Rerun {
        target: target.into(),
        reason: reason.to_string(),
    }
}
