//! Tests of files for Rerun, read back by its own reader.

use std::collections::BTreeMap;
use std::io::BufReader;
use std::path::Path;

use re_sdk::external::re_log_encoding::DecoderApp;
use re_sdk::log::{Chunk, LogMsg};
use re_types::Component;
use re_types::archetypes::{Arrows3D, LineStrips3D, Mesh3D, Scalars, Transform3D};
use re_types::components::{
    LineStrip3D, Position3D, RotationQuat, Scalar, Translation3D, Vector3D,
};

use super::RerunStream;
use super::entities::path;
use crate::dynamics::{forward_kinematics, frame_pose};
use crate::io::temporary::Folder;
use crate::model::{BodyId, samples};
use crate::spatial::{Quaternion, Transform};
use crate::view::Appearance;
use crate::view::recording::Recording;
use crate::view::tests::{HOSTILE, everything};
use crate::{Model, State};

/// Poses in the file are in single precision.
const SINGLE: f64 = 1e-6;

/// Chunks that a file holds.
struct File(Vec<Chunk>);

impl File {
    fn read(path: &Path) -> Self {
        let file = BufReader::new(std::fs::File::open(path).unwrap());
        let messages = DecoderApp::decode_lazy(file).map(Result::unwrap);
        let chunks = messages.filter_map(|message| match message {
            LogMsg::ArrowMsg(_, message) => Some(Chunk::from_arrow_msg(&message).unwrap()),
            _ => None,
        });
        Self(chunks.collect())
    }

    fn of(recording: &Recording) -> Self {
        let folder = Folder::new();
        let path = folder.path("deep/er/motion.rrd");
        recording.save_rrd(&path).unwrap();
        Self::read(&path)
    }

    /// A component of an entity, by time in nanoseconds; of what stays the time is none.
    fn get<C: Component + Clone>(
        &self,
        parts: &[&str],
        component: &re_types::ComponentDescriptor,
    ) -> BTreeMap<Option<i64>, Vec<C>> {
        let at = path(parts);
        let chunks = self.0.iter().filter(|chunk| *chunk.entity_path() == at);
        let chunks = chunks.filter(|chunk| chunk.components().contains_key(&component.component));
        let rows = chunks.flat_map(|chunk| {
            let times = match chunk.timelines().values().next() {
                Some(times) => times.times_raw().iter().copied().map(Some).collect(),
                None => vec![None; chunk.num_rows()],
            };
            let values = chunk.iter_component::<C>(component.component);
            let values: Vec<_> = values.map(|batch| batch.as_slice().to_vec()).collect();
            times.into_iter().zip(values)
        });
        rows.collect()
    }

    fn numbers(&self, parts: &[&str]) -> BTreeMap<Option<i64>, Vec<f64>> {
        let numbers = self.get::<Scalar>(parts, &Scalars::descriptor_scalars());
        let plain = |(time, x): (_, Vec<Scalar>)| (time, x.iter().map(|x| x.0.0).collect());
        numbers.into_iter().map(plain).collect()
    }

    /// Fails unless the pose of an entity at a time is the given one.
    fn check_pose(&self, parts: &[&str], time: Option<i64>, expected: &Transform<f64>) {
        let places = self.get::<Translation3D>(parts, &Transform3D::descriptor_translation());
        let turns = self.get::<RotationQuat>(parts, &Transform3D::descriptor_quaternion());
        let (place, turn) = (&places[&time][0], turns[&time][0].xyzw().map(f64::from));
        for axis in 0..3 {
            let (found, expected) = (f64::from(place.0.0[axis]), expected.translation[axis]);
            assert!(
                (found - expected).abs() < SINGLE * expected.abs().max(1.0),
                "{parts:?}"
            );
        }
        let q = Quaternion::from_matrix(&expected.rotation);
        let q = [q.xyz.x, q.xyz.y, q.xyz.z, q.w];
        let cosine: f64 = q.iter().zip(turn).map(|(a, b)| a * b).sum();
        assert!(
            (cosine.abs() - 1.0).abs() < SINGLE,
            "{parts:?} {time:?}: {q:?} against {turn:?}"
        );
    }
}

/// Nanoseconds of the moments of a recording.
fn moments(recording: &Recording) -> Vec<i64> {
    let times = recording.times().iter();
    times.map(|time| (time * 1e9).round() as i64).collect()
}

#[test]
fn poses_in_the_file_equal_kinematics_of_the_recorded_states() {
    let mut recording = everything();
    recording.spread(2.5);
    let file = File::of(&recording);
    for track in recording.robots() {
        file.check_pose(&["robots", track.name()], None, &track.placement);
        for (k, time) in moments(&recording).into_iter().enumerate() {
            let kinematics = forward_kinematics(track.model(), track.q(k), track.v(k));
            for body in (0..track.model().n_bodies()).map(BodyId) {
                let at = ["robots", track.name(), track.model().body_name(body)];
                file.check_pose(&at, Some(time), &kinematics.pose(Some(body)));
            }
        }
    }
}

#[test]
fn numbers_in_the_file_equal_those_of_the_recording() {
    let recording = everything();
    let (file, times) = (File::of(&recording), moments(&recording));
    let expected = |values: Vec<f64>| -> BTreeMap<_, _> {
        let known = times.iter().zip(values).filter(|(_, x)| !x.is_nan());
        known.map(|(&time, x)| (Some(time), vec![x])).collect()
    };
    for track in recording.robots() {
        let (nq, nv) = (track.model().nq(), track.model().nv());
        let names = track.column_names();
        for (j, name) in names.iter().take(nq + nv).enumerate() {
            let (kind, rest) = name.split_once('.').unwrap();
            let column = (0..recording.len()).map(|k| track.row(k).nth(j).unwrap());
            let found = file.numbers(&["numbers", track.name(), kind, rest]);
            assert_eq!(found, expected(column.collect()), "{name}");
        }
        for j in 0..track.nu() {
            let column = (0..recording.len()).map(|k| track.u(k)[j]);
            let found = file.numbers(&["numbers", track.name(), "u", &j.to_string()]);
            assert_eq!(found, expected(column.collect()), "u{j}");
        }
    }
    let series = &recording.series()[0];
    let found = file.numbers(&["numbers", HOSTILE]);
    assert_eq!(found, expected(series.values.clone()));
    assert_eq!(found.len(), 4, "what is unknown is left out");
}

#[test]
fn everything_that_moves_stands_on_one_timeline() {
    let file = File::of(&everything());
    let mut moving = 0;
    for chunk in &file.0 {
        let names: Vec<_> = chunk.timelines().keys().map(|name| name.as_str()).collect();
        assert!(names.is_empty() || names == ["time"], "{names:?}");
        moving += usize::from(!chunk.is_static());
    }
    assert!(moving > 10);
}

#[test]
fn stream_of_a_simulation_equals_the_file_of_its_recording() {
    let (folder, recording) = (Folder::new(), everything());
    let path = folder.path("stream.rrd");
    let models: Vec<_> = recording
        .robots()
        .iter()
        .map(|track| track.model())
        .collect();
    let mut stream = RerunStream::save(&path, &Recording::of_robots(&models)).unwrap();
    for (k, &time) in recording.times().iter().enumerate() {
        let state = |i: usize| State::new(recording.robots()[i].q(k), recording.robots()[i].v(k));
        let u = recording.robots()[1].u(k);
        stream.push_all(time, &[(&state(0), &[]), (&state(1), u)]);
        stream.push_scalar(time, HOSTILE, recording.series()[0].values[k]);
    }
    stream.flush().unwrap();
    drop(stream);
    let (streamed, saved) = (File::read(&path), File::of(&recording));
    for track in recording.robots() {
        let (translation, rotation) = (
            Transform3D::descriptor_translation(),
            Transform3D::descriptor_quaternion(),
        );
        for body in (0..track.model().n_bodies()).map(BodyId) {
            let at = ["robots", track.name(), track.model().body_name(body)];
            let place = |file: &File| file.get::<Translation3D>(&at, &translation);
            let turn = |file: &File| file.get::<RotationQuat>(&at, &rotation);
            assert_eq!(
                (place(&streamed), turn(&streamed)),
                (place(&saved), turn(&saved))
            );
        }
    }
    for parts in [
        &["numbers", HOSTILE][..],
        &["numbers", "cartpole", "u", "0"],
    ] {
        assert_eq!(streamed.numbers(parts), saved.numbers(parts));
    }
}

#[test]
fn traces_and_forces_begin_at_the_poses_of_their_frames() {
    let mut recording = everything();
    recording.robot_mut(1).trace("pole").unwrap();
    recording.robot_mut(1).show_frame("pole").unwrap();
    let (file, track) = (File::of(&recording), &recording.robots()[1]);
    let frame = track.model().frame("pole").unwrap();
    let at = |kind: &'static str| ["robots", "cartpole", kind, "pole"];
    let strips = file.get::<LineStrip3D>(&at("traces"), &LineStrips3D::descriptor_strips());
    let origins = file.get::<Position3D>(&at("forces"), &Arrows3D::descriptor_origins());
    let vectors = file.get::<Vector3D>(&at("forces"), &Arrows3D::descriptor_vectors());
    let mut longest: f64 = 0.0;
    for (k, time) in moments(&recording).into_iter().enumerate() {
        let pose = frame_pose(track.model(), track.q(k), frame);
        let expected = pose.translation.map(|x| x as f32);
        file.check_pose(&at("frames"), Some(time), &pose);
        assert_eq!(strips[&None][0].0[k].0, <[f32; 3]>::from(expected));
        assert_eq!(origins[&Some(time)][0].0.0, <[f32; 3]>::from(expected));
        let arrow = nalgebra::Vector3::from(vectors[&Some(time)][0].0.0).map(f64::from);
        assert!(
            arrow.cross(&track.forces()[0].values[k]).norm() < SINGLE,
            "along the force"
        );
        longest = longest.max(arrow.norm());
    }
    assert!((longest - 0.5).abs() < SINGLE, "{longest}");
}

/// Shapes with volumes or vertices that one can tell by hand.
#[test]
fn shapes_in_the_file_equal_those_of_the_description() {
    let folder = Folder::new();
    folder.write("t.obj", "v 0 0 0\nv 2 0 0\nv 0 3 0\nf 1 2 3\n");
    let solids = [
        "<box size=\"1 2 3\"/>",
        "<sphere radius=\"0.5\"/>",
        "<cylinder radius=\"0.5\" length=\"2\"/>",
        "<mesh filename=\"t.obj\" scale=\"2 2 2\"/>",
        "<mesh filename=\"missing.stl\"/>",
    ];
    let visual = |solid| format!("<visual><geometry>{solid}</geometry></visual>");
    let visuals = solids.map(visual).concat();
    let text = format!("<robot name=\"r\"><link name=\"world\">{visuals}</link></robot>");
    let model = Model::from_urdf_file(folder.write("r.urdf", text)).unwrap();
    let file = File::of(&Recording::new(&model));
    let kinds = file.0.iter().filter_map(|chunk| {
        let mut names = chunk.component_descriptors().filter_map(|c| c.archetype);
        let name = names.find(|name| !name.short_name().contains("Transform3D"))?;
        let parts: Vec<_> = chunk
            .entity_path()
            .iter()
            .map(|part| part.unescaped_str())
            .collect();
        (parts.first() == Some(&"robots"))
            .then(|| (parts[3].to_owned(), name.short_name().to_owned()))
    });
    let kinds: BTreeMap<_, _> = kinds.collect();
    let expected = [
        "Boxes3D",
        "Ellipsoids3D",
        "Cylinders3D",
        "Mesh3D",
        "Boxes3D",
    ];
    let expected = expected
        .iter()
        .zip(0..)
        .map(|(name, k)| (format!("{k}"), (*name).to_owned()));
    assert_eq!(kinds, expected.collect());
    // The mesh stands around its middle, (2, 3, 0) of the corner to which its pose shifts it.
    let at = ["robots", "r", "world", "3"];
    let vertices = file.get::<Position3D>(&at, &Mesh3D::descriptor_vertex_positions());
    let vertices: Vec<_> = vertices[&None].iter().map(|vertex| vertex.0.0).collect();
    assert_eq!(
        vertices,
        [[-2.0, -3.0, 0.0], [2.0, -3.0, 0.0], [-2.0, 3.0, 0.0]]
    );
    let middle = Transform::from_translation(nalgebra::Vector3::new(2.0, 3.0, 0.0));
    file.check_pose(&at, None, &middle);
    let warnings = file
        .0
        .iter()
        .filter(|chunk| *chunk.entity_path() == path(&["warnings"]));
    assert_eq!(warnings.count(), 1);
}

#[test]
fn scene_objects_in_the_file_stand_where_they_were_put() {
    let recording = everything();
    let file = File::of(&recording);
    for object in recording.scene_objects() {
        let at = match object.appearance {
            Appearance::Axes => vec!["fixtures", object.name.as_str()],
            _ => vec!["fixtures", object.name.as_str(), "0"],
        };
        file.check_pose(&at, None, &object.placement);
    }
    assert_eq!(recording.scene_objects().len(), 6);
}

#[test]
fn viewer_that_is_not_there_is_an_error_and_no_wait_without_end() {
    let scene = Recording::new(&samples::pendulum());
    let error = RerunStream::connect("no address", &scene).unwrap_err();
    assert!(error.to_string().starts_with("no address: "), "{error}");
    // Port 9 takes nothing.
    let address = "rerun+http://127.0.0.1:9/proxy";
    let mut stream = RerunStream::connect(address, &scene).unwrap();
    stream.push(0.0, &State::new(&[0.1], &[0.0]), &[]);
    let error = stream.flush().unwrap_err();
    assert!(error.to_string().starts_with(address), "{error}");
}

#[test]
fn file_that_cannot_be_written_is_an_error_that_names_it() {
    let folder = Folder::new();
    folder.write("file", "");
    let path = folder.path("file/motion.rrd");
    let error = Recording::new(&samples::pendulum())
        .save_rrd(&path)
        .unwrap_err();
    assert!(
        error.to_string().starts_with(&path.display().to_string()),
        "{error}"
    );
}

#[test]
#[should_panic(expected = "the time 0 s is not after 0 s")]
fn time_that_stands_still_is_refused() {
    let (folder, model) = (Folder::new(), samples::pendulum());
    let mut stream = RerunStream::save(folder.path("a.rrd"), &Recording::new(&model)).unwrap();
    stream.push(0.0, &State::neutral(&model), &[]);
    stream.push(0.0, &State::neutral(&model), &[]);
}
