//! A whole recording at once: what a stream would have sent, and what needs all moments.

use std::path::Path;

use nalgebra::Vector3;
use re_types::archetypes::{Arrows3D, LineStrips3D};

use super::RerunStream;
use super::entities::{AXES, path, transform};
use crate::dynamics::{Kinematics, forward_kinematics, frame_pose_at};
use crate::error::RecordingError;
use crate::model::FrameId;
use crate::view::recording::Recording;
use crate::view::shape;
use crate::view::track::Track;

/// Length of the arrow of the largest force, m.
const LONGEST_ARROW: f32 = 0.5;

impl Recording {
    /// Writes the recording as a file of the Rerun viewer: robots with their meshes, poses of all bodies, traces,
    /// frames, forces, and all numbers, over one timeline. Makes the folder. The entities are those of a
    /// [`RerunStream`], and `robots/<robot>/{traces,frames,forces}/<frame>`.
    ///
    /// # Errors
    /// If the file cannot be written.
    ///
    /// # Examples
    /// ```no_run
    /// use dualbody::{Simulator, State, model::samples, view::Recording};
    ///
    /// let simulator = Simulator::new(samples::cartpole());
    /// let rollout = simulator.rollout(&State::new(&[0.0, 0.5], &[0.0; 2]), 1000, |_, _, _| {});
    /// Recording::from_rollout(simulator.model(), &rollout).save_rrd("out/cartpole.rrd")?; // then: rerun out/cartpole.rrd
    /// # Ok::<(), dualbody::RecordingError>(())
    /// ```
    pub fn save_rrd(&self, path: impl AsRef<Path>) -> Result<(), RecordingError> {
        let mut stream = RerunStream::save(path, self)?;
        stream.push_recording(self);
        stream.flush()
    }
}

impl RerunStream {
    /// Sends all moments of the recording that the stream was opened with.
    pub(super) fn push_recording(&mut self, recording: &Recording) {
        for (k, &time) in recording.times().iter().enumerate() {
            for (robot, track) in recording.robots().iter().enumerate() {
                self.push_robot(time, robot, [track.q(k), track.v(k), track.u(k)]);
            }
            for series in recording.series() {
                self.push_scalar(time, &series.name, series.values[k]);
            }
        }
        let forces = recording.robots().iter().flat_map(Track::forces);
        let sizes = forces.flat_map(|force| force.values.iter().map(Vector3::norm));
        let largest = sizes.filter(|size| size.is_finite()).fold(0.0, f64::max);
        let scale = if largest > 0.0 {
            f64::from(LONGEST_ARROW) / largest
        } else {
            0.0
        };
        for track in recording.robots() {
            self.push_marks(track, recording.times(), scale);
        }
    }

    /// Frames, traces and forces.
    ///
    /// * `scale` – of the arrows, m/N
    fn push_marks(&self, track: &Track, times: &[f64], scale: f64) {
        let at = |kind: &str, frame| path(&["robots", &track.name, kind, track.frame_name(frame)]);
        let poses = poses(track, times.len());
        for &frame in &track.traces {
            let points = poses
                .iter()
                .map(|kinematics| origin(track, kinematics, frame));
            let strip: Vec<_> = points.collect();
            self.log_static(at("traces", frame), &LineStrips3D::new([strip]));
        }
        for (k, &time) in times.iter().enumerate() {
            for &frame in &track.frames {
                let pose = shape::pose(&frame_pose_at(&track.model, &poses[k], frame));
                let axes = transform(&pose).with_axis_length(AXES);
                self.log(at("frames", frame), time, &axes);
            }
            for force in track.forces() {
                let vector = (force.values[k] * scale).map(|x| x as f32);
                let arrow = Arrows3D::from_vectors([<[f32; 3]>::from(vector)])
                    .with_origins([origin(track, &poses[k], force.frame)]);
                self.log(at("forces", force.frame), time, &arrow);
            }
        }
    }
}

/// Kinematics of the bodies at each time; where that is not known, the last that was.
fn poses(track: &Track, length: usize) -> Vec<Kinematics<f64>> {
    if track.traces.is_empty() && track.frames.is_empty() && track.forces().is_empty() {
        return Vec::new();
    }
    let (model, still) = (&track.model, vec![0.0; track.model.nv()]);
    let mut last = forward_kinematics(model, model.neutral().as_slice(), &still);
    let at = |k: usize| {
        if track.q(k).iter().all(|x| x.is_finite()) {
            last = forward_kinematics(model, track.q(k), &still);
        }
        last.clone()
    };
    (0..length).map(at).collect()
}

fn origin(track: &Track, kinematics: &Kinematics<f64>, frame: FrameId) -> [f32; 3] {
    let pose = frame_pose_at(&track.model, kinematics, frame);
    pose.translation.map(|x| x as f32).into()
}
