//! Tests of recordings and their files.

mod files;
mod page;
mod scenery;

use std::path::Path;

use nalgebra::Vector3;
use rand::SeedableRng;
use rand::rngs::Xoshiro256PlusPlus;

use super::{Recording, RecordingError};
use crate::io::temporary::Folder;
use crate::model::{Geometry, Model, UpAxis, samples};
use crate::sim::{BatchSimulator, RolloutStatus};
use crate::spatial::{Quaternion, Transform};
use crate::{Simulator, State};

/// Names that would break a table or a page if they were pasted into it.
pub(super) const HOSTILE: &str = "a \"b\", <script>alert('1')</script>\n & \\u003c";

/// Two random robots that are moved about, with everything that a recording can hold.
pub(super) fn everything() -> Recording {
    let models = [samples::random_tree(7, 1), samples::cartpole()];
    let mut recording = Recording::of_robots(&[&models[0], &models[1]]).with_title(HOSTILE);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
    for k in 0..5 {
        let states = [0, 1].map(|i| State::random(&models[i], &mut rng, 1.0));
        let u = [f64::from(k) / 3.0];
        let u: &[f64] = if k == 4 { &[] } else { &u };
        recording.push_all(0.1 * f64::from(k), &[(&states[0], &[]), (&states[1], u)]);
    }
    recording.add_series(HOSTILE, [1.0 / 3.0, f64::NAN, -0.0, 1e-300, 1e300]);
    let cartpole = recording.robot_mut(1);
    let force = |k: usize| Vector3::new(0.1 * k as f64, -2.0, 0.3);
    cartpole.add_force("pole", (0..5).map(force)).unwrap();
    furnish(&mut recording);
    recording
}

/// Every kind of scene object.
fn furnish(recording: &mut Recording) {
    let turn = Quaternion::exp(&Vector3::new(0.3, -0.5, 0.2)).to_matrix();
    let place = |x: f64| Transform::new(turn, Vector3::new(x, 1.0 / 3.0, -2.0));
    let mesh = Geometry::Mesh {
        uri: HOSTILE.into(),
        path: std::path::absolute("no/such.stl").ok(),
        scale: [1.0, 2.0, 0.1],
        up_axis: UpAxis::Ignore,
    };
    let (radius, length) = (0.3, 0.7);
    let shapes = [
        Geometry::Sphere { radius },
        Geometry::Box {
            size: [0.1, 0.2, 0.3],
        },
        Geometry::Cylinder { radius, length },
        Geometry::Capsule { radius, length },
        mesh,
    ];
    for (k, shape) in shapes.into_iter().enumerate() {
        let color = [0.9, 1.0 / 3.0, 0.2, 0.5];
        recording.add_shape(format!("{HOSTILE}{k}"), shape, place(k as f64), color);
    }
    recording.add_axes(HOSTILE, place(9.0));
}

fn models(recording: &Recording) -> Vec<&Model> {
    recording.robots().iter().map(super::Track::model).collect()
}

/// All numbers of a recording, as bits: NaN equals NaN.
fn bits(recording: &Recording) -> Vec<Vec<u64>> {
    let row = |k: usize| {
        let robots = recording.robots.iter().flat_map(|track| track.row(k));
        let series = recording.series.iter().map(|series| series.values[k]);
        let all = robots.chain(series).chain([recording.times[k]]);
        all.map(f64::to_bits).collect()
    };
    (0..recording.len()).map(row).collect()
}

#[test]
fn csv_read_back_equals_what_was_recorded() {
    let (folder, recording) = (Folder::new(), everything());
    let path = folder.path("deep/er/motion.csv");
    recording.save_csv(&path).unwrap();
    let again = Recording::read_csv(&path, &models(&recording)).unwrap();
    assert_eq!(bits(&again), bits(&recording));
    assert_eq!(again.series()[0].name, HOSTILE);
    assert_eq!(again.robots()[1].forces().len(), 1);
}

#[test]
fn json_read_back_equals_what_was_recorded() {
    let (folder, mut recording) = (Folder::new(), everything());
    recording.spread(2.5);
    recording.robot_mut(1).trace("pole").unwrap();
    recording.robot_mut(0).show_frame("link3").unwrap();
    let path = folder.path("motion.json");
    recording.save_json(&path).unwrap();
    let again = Recording::read_json(&path, &models(&recording)).unwrap();
    assert_eq!(bits(&again), bits(&recording));
    assert_eq!(again.title(), HOSTILE);
    assert_eq!(again.robots()[1].traces, recording.robots()[1].traces);
    assert_eq!(again.robots()[0].frames, recording.robots()[0].frames);
    assert_eq!(again.robots()[1].placement, recording.robots()[1].placement);
    assert_eq!(again.scene_objects().len(), 6);
    assert_eq!(again.scene_objects(), recording.scene_objects());
    assert_eq!(again.to_json(), recording.to_json());
}

/// A folder with a recording and its meshes can be handed on, and does not tell where it was made.
#[test]
fn meshes_in_json_are_named_from_its_folder() {
    let (folder, model) = (Folder::new(), samples::pendulum());
    let mesh = |folder: &Folder| Geometry::Mesh {
        uri: "ball.stl".into(),
        path: Some(folder.path("meshes/ball.stl")),
        scale: [1.0; 3],
        up_axis: UpAxis::Auto,
    };
    let mut recording = Recording::new(&model);
    recording.add_shape("ball", mesh(&folder), Transform::identity(), [1.0; 4]);
    let path = folder.path("motion.json");
    recording.save_json(&path).unwrap();
    let stored = std::fs::read_to_string(&path).unwrap();
    assert!(stored.contains("\"path\":\"meshes/ball.stl\""), "{stored}");
    assert!(
        !stored.contains(folder.path("").to_str().unwrap()),
        "{stored}"
    );
    let again = Recording::read_json(&path, &[&model]).unwrap();
    assert_eq!(again.scene_objects(), recording.scene_objects());
    let other = Folder::new();
    let moved = Recording::read_json(other.write("motion.json", stored), &[&model]).unwrap();
    let mut expected = Recording::new(&model);
    expected.add_shape("ball", mesh(&other), Transform::identity(), [1.0; 4]);
    assert_eq!(moved.scene_objects(), expected.scene_objects());
}

#[test]
fn json_without_scene_objects_reads_as_a_recording_without_any() {
    let (folder, model) = (Folder::new(), samples::pendulum());
    let text = Recording::new(&model).to_json();
    let older = text.replace(",\"fixtures\":[]", "");
    assert!(older.len() < text.len(), "{text}");
    let again = Recording::read_json(folder.write("older.json", older), &[&model]).unwrap();
    assert!(again.scene_objects().is_empty());
}

#[test]
fn csv_of_a_recording_equals_csv_of_its_rollout() {
    let simulator = Simulator::new(samples::cartpole()).with_time_step(0.01);
    let start = State::new(&[0.1, 0.2], &[0.3, -0.4]);
    let rollout = simulator.rollout(&start, 20, |time, _, u| u[1] = time);
    let mut expected = Vec::new();
    rollout.write_csv(simulator.model(), &mut expected).unwrap();
    let recording = Recording::from_rollout(simulator.model(), &rollout);
    assert_eq!(recording.to_csv().as_bytes(), expected);
}

#[test]
fn pushing_step_by_step_equals_recording_the_rollout() {
    let simulator = Simulator::new(samples::cartpole()).with_time_step(0.01);
    let start = State::new(&[0.1, 0.2], &[0.3, -0.4]);
    let rollout = simulator.rollout(&start, 20, |time, _, u| u[1] = time);
    let mut recording = Recording::new(simulator.model());
    for (k, time) in rollout.times().enumerate() {
        let u = rollout.inputs.get(k).map_or(&[][..], |u| u.as_slice());
        recording.push(time, &rollout.states[k], u);
    }
    let expected = Recording::from_rollout(simulator.model(), &rollout);
    assert_eq!(bits(&recording), bits(&expected));
}

#[test]
fn recorded_trajectories_of_a_batch_equal_its_rows() {
    let simulator = Simulator::new(samples::cartpole()).with_time_step(0.01);
    let mut batch = BatchSimulator::new(simulator, 3);
    let start = |k: usize| State::new(&[0.0, 0.1 * k as f64], &[0.0; 2]);
    let starts: Vec<State> = (0..3).map(start).collect();
    // The last one gets an input that is not finite in its sixth step.
    let rollout = batch.rollout(&starts, 10, |moment, _, u| {
        u[0] = moment.gather(|i| {
            if i == 2 && moment.step == 5 {
                f64::NAN
            } else {
                0.1
            }
        });
    });
    assert_ne!(rollout.status(2), RolloutStatus::Completed);
    let recording = Recording::from_batch(&batch, &rollout, &[2, 0]);
    assert_eq!((recording.len(), recording.robots().len()), (11, 2));
    assert_eq!(recording.robots()[0].name(), "cartpole 1");
    for k in 0..11 {
        assert_eq!(recording.robots()[1].q(k), rollout.q(0, k));
        assert_eq!(recording.robots()[0].q(k)[0].is_nan(), k > 5, "row {k}");
    }
}

/// Damages a file and reads it; gives the message.
fn message(recording: &Recording, kind: &str, damage: impl Fn(String) -> String) -> String {
    let folder = Folder::new();
    let text = match kind {
        "csv" => recording.to_csv(),
        _ => recording.to_json(),
    };
    let path = folder.write(&format!("motion.{kind}"), damage(text));
    let read = match kind {
        "csv" => Recording::read_csv(&path, &models(recording)),
        _ => Recording::read_json(&path, &models(recording)),
    };
    let message = read.unwrap_err().to_string();
    let file = path.display().to_string();
    let rest = message.strip_prefix(&file);
    let rest = rest.unwrap_or_else(|| panic!("{message} does not start with the file"));
    rest.to_owned()
}

#[test]
fn errors_of_damaged_files_name_file_line_and_reason() {
    let simulator = Simulator::new(samples::pendulum()).with_time_step(0.5);
    let rollout = simulator.rollout(&State::new(&[1.0], &[0.0]), 2, |_, _, _| {});
    let mut recording = Recording::from_rollout(simulator.model(), &rollout);
    let csv = |from: &str, to: &str| message(&recording, "csv", |text| text.replacen(from, to, 1));
    let json =
        |from: &str, to: &str| message(&recording, "json", |text| text.replacen(from, to, 1));
    for (found, expected) in [
        (
            csv("\n0.5,", "\nhalf,"),
            ":3: time: \"half\" is not a number",
        ),
        (
            csv("\n0.5,", "\n0,"),
            ":3: the time is missing or not after the one before",
        ),
        (csv("\n0.5,", "\n0.5,1,"), ":3: 5 cells under 4 names"),
        (
            csv("v.pivot", "v.other"),
            ": there is no column \"v.pivot\"",
        ),
        (
            message(&recording, "csv", |_| String::new()),
            ":1: is empty",
        ),
        (
            json("\"dualbody_recording\":1", "\"dualbody_recording\":9"),
            ":1: is of version 9, not 1",
        ),
        (
            json("[0.0,0.5,", "[0.0,0.0,"),
            ":1: times[1] is missing or not after the one before",
        ),
        (
            json("[0.0,0.5,", "[0.5,"),
            ":1: \"q.pivot\" has 3 values at 2 times",
        ),
        (
            json("q.pivot", "q.other"),
            ": where \"pendulum\" has the column \"q.pivot\", that of \"pendulum\" is \"q.other\"",
        ),
        (
            json("\"traces\":[]", "\"traces\":[\"nose\"]"),
            ": model \"pendulum\" has no frame \"nose\"; it has: world, rod",
        ),
    ] {
        assert_eq!(found, expected);
    }
    recording.add_axes("goal", Transform::identity());
    let found = message(&recording, "json", |text| text.replace("axes", "nose"));
    assert!(found.contains("unknown variant `nose`"), "{found}");
    let json =
        |from: &str, to: &str| message(&recording, "json", |text| text.replacen(from, to, 1));
    assert!(json("\"times\"", "times").starts_with(":1: key must be a string"));
}

#[test]
fn missing_file_is_an_error_that_names_it() {
    let model = samples::pendulum();
    let error = Recording::read_csv("no/such.csv", &[&model]).unwrap_err();
    assert!(error.to_string().starts_with("no/such.csv: "), "{error}");
}

/// Asserts that the result is a whole recording, which equals itself written and read again, or an error that names
/// the file. Tells which.
fn assert_recording_or_error(
    read: Result<Recording, RecordingError>,
    damaged: &Path,
    recorded: &Recording,
) -> bool {
    let recording = match read {
        Ok(recording) => recording,
        Err(error) => {
            let file = damaged.to_string_lossy();
            assert!(error.to_string().starts_with(&*file), "{error}");
            return false;
        }
    };
    let is_later = |pair: &[f64]| pair[0] < pair[1];
    assert!(recording.times().windows(2).all(is_later));
    assert!(recording.len() <= recorded.len());
    let path = damaged.with_file_name("again.json");
    recording.save_json(&path).unwrap();
    let again = Recording::read_json(&path, &models(recorded)).unwrap();
    // JSON holds no infinite number.
    let known = |recording: &Recording| {
        let or_nan = |x: u64| Some(x).filter(|&x| f64::from_bits(x).is_finite());
        let rows = bits(recording).into_iter();
        rows.map(|row| row.into_iter().map(or_nan).collect())
            .collect::<Vec<Vec<_>>>()
    };
    assert_eq!(known(&again), known(&recording));
    true
}

/// Every prefix and many changed bytes of a file.
#[test]
fn damaged_files_are_errors_that_name_them_or_whole_recordings() {
    let (folder, recording) = (Folder::new(), everything());
    let models = models(&recording);
    for (name, text) in [
        ("a.csv", recording.to_csv()),
        ("a.json", recording.to_json()),
    ] {
        let bytes = text.into_bytes();
        let (mut refused, mut read) = (0, 0);
        for k in (0..bytes.len()).step_by(bytes.len() / 97) {
            let mut changed = bytes.clone();
            changed[k] = b"\",\n[]}0-e"[k % 9];
            for damaged in [&bytes[..k], &changed] {
                let path = folder.write(name, damaged);
                let results = [
                    Recording::read_csv(&path, &models),
                    Recording::read_json(&path, &models),
                ];
                for result in results {
                    match assert_recording_or_error(result, &path, &recording) {
                        true => read += 1,
                        false => refused += 1,
                    }
                }
            }
        }
        assert!(refused > 50 && read > 5, "{name}: {refused}, {read}");
    }
}

#[test]
#[should_panic(expected = "the time 0 s is not after 0 s")]
fn time_that_stands_still_is_refused() {
    let model = samples::pendulum();
    let mut recording = Recording::new(&model);
    recording.push(0.0, &State::neutral(&model), &[]);
    recording.push(0.0, &State::neutral(&model), &[]);
}

#[test]
#[should_panic(expected = "\"wall\" has a number that is not finite")]
fn shape_without_a_size_is_refused() {
    let wall = Geometry::Box {
        size: [1.0, f64::NAN, 1.0],
    };
    Recording::new(&samples::pendulum()).add_shape("wall", wall, Transform::identity(), [1.0; 4]);
}
