//! Recordings as JSON, with display settings.

use std::iter;
use std::path::Path;

use nalgebra::Vector3;
use serde::{Deserialize, Deserializer, Serialize};

use super::bond::{Bond, StoredBond};
use super::camera::Camera;
use super::files::{
    first_disorder, from_folder_of, in_folder_of, malformed, name, other_robots, read, write,
};
use super::recording::{Recording, Series};
use super::rows::Rows;
use super::scene_object::SceneObject;
use super::touches::Touches;
use super::track::{ForceTrack, Track};
use crate::error::{RecordingError, UnknownName};
use crate::model::{FrameId, Model, numbered};
use crate::nested::IntoNested;
use crate::spatial::Transform;

/// Version of the format; a reader refuses later ones.
const VERSION: u32 = 1;

/// The file. Numbers that are unknown are null.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    dualbody_recording: u32,
    title: String,
    camera: Option<Camera>,
    times: Vec<Number>,
    robots: Vec<Robot>,
    series: Vec<Column>,
    #[serde(default, rename = "fixtures")]
    scene_objects: Vec<SceneObject>,
}

/// A robot with its columns q, v, contact state, activations, u in the order of [`column_names`](crate::sim::Rollout::write_csv).
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Robot {
    name: String,
    model: String,
    /// Rotation row by row, then translation.
    placement: [f64; 12],
    columns: Vec<Column>,
    /// Names of the inputs.
    #[serde(default)]
    inputs: Vec<String>,
    forces: Vec<Force>,
    traces: Vec<String>,
    frames: Vec<String>,
    /// Constraints that are drawn.
    #[serde(default)]
    bonds: Vec<StoredBond>,
    /// Contact points and the forces there, at some moments.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    contacts: Vec<Touches>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Column {
    name: String,
    values: Vec<Number>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Force {
    frame: String,
    values: Vec<[Number; 3]>,
}

/// A number, or null for NaN.
#[derive(Clone, Copy, Serialize)]
#[serde(transparent)]
struct Number(f64);

impl<'de> Deserialize<'de> for Number {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        let number = Option::<f64>::deserialize(source)?;
        Ok(Self(number.unwrap_or(f64::NAN)))
    }
}

impl Recording {
    /// Returns the recording as JSON; see [`save_json`](Self::save_json). Meshes of [scene objects](Self::scene_objects) keep their paths, which are
    /// usually absolute.
    pub fn to_json(&self) -> String {
        self.json(self.scene_objects.clone())
    }

    fn json(&self, scene_objects: Vec<SceneObject>) -> String {
        let file = File {
            dualbody_recording: VERSION,
            title: self.title.clone(),
            camera: self.camera,
            times: numbers(self.times.iter().copied()),
            robots: self.robots.iter().map(robot).collect(),
            series: self.series.iter().map(column).collect(),
            scene_objects,
        };
        // Only non-text keys and failing writers cause errors; there are none.
        serde_json::to_string(&file).unwrap_or_else(|error| unreachable!("{error}"))
    }

    /// Writes the recording with the names of the robots, without their models. Finite values read back exactly; others are null, and read back as
    /// NaN. Paths of meshes of [scene objects](Self::scene_objects) are relative to the folder of the file. Creates the folder.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save_json(&self, path: impl AsRef<Path>) -> Result<(), RecordingError> {
        let path = path.as_ref();
        let mut objects = self.scene_objects.clone();
        for object in &mut objects {
            object.move_mesh(|mesh| from_folder_of(path, mesh));
        }
        write(path, self.json(objects))
    }

    /// Reads a file of [`save_json`](Self::save_json). A simulation can continue from any of its states, see [`Track::state`]. Relative paths of
    /// meshes are relative to the folder of the file.
    ///
    /// * `models` – the robots, in the order of the recording
    ///
    /// # Errors
    /// If the file cannot be read, is not such a recording, or contains other robots.
    pub fn read_json(path: impl AsRef<Path>, models: &[&Model]) -> Result<Self, RecordingError> {
        let path = path.as_ref();
        Self::parse_json(&read(path)?, path, models)
    }

    /// Reads the text of [`to_json`](Self::to_json); `models` and errors as for [`read_json`](Self::read_json).
    pub fn from_json(text: impl AsRef<str>, models: &[&Model]) -> Result<Self, RecordingError> {
        Self::parse_json(text.as_ref(), Path::new("text"), models)
    }

    // Inlined, so that reading is compiled by programs that read: 0.1 MB of machine code.
    #[inline]
    fn parse_json(text: &str, path: &Path, models: &[&Model]) -> Result<Self, RecordingError> {
        let mut file: File = serde_json::from_str(text)
            .map_err(|error| malformed(path, error.line(), error.to_string()))?;
        if file.dualbody_recording != VERSION {
            let found = file.dualbody_recording;
            let reason = format!("is of version {found}, not {VERSION}");
            return Err(malformed(path, 1, reason));
        }
        if models.is_empty() || file.robots.len() != models.len() {
            let (held, given) = (file.robots.len(), models.len());
            let reason = format!("holds {held} robots, {given} were given");
            return Err(other_robots(path, reason));
        }
        let times = plain(file.times);
        if let Some(k) = first_disorder(&times) {
            let reason = format!("times[{k}] is missing or not after the one before");
            return Err(malformed(path, 1, reason));
        }
        let mut flaws = file.scene_objects.iter().filter_map(SceneObject::flaw);
        if let Some(flaw) = flaws.next() {
            return Err(malformed(path, 1, flaw));
        }
        for object in &mut file.scene_objects {
            object.move_mesh(|mesh| in_folder_of(path, mesh));
        }
        let robots = file.robots.into_iter().zip(models);
        let tracks = robots.map(|(robot, model)| track(path, robot, model, times.len()));
        Ok(Self {
            title: file.title,
            robots: tracks.collect::<Result<_, _>>()?,
            series: series(path, file.series, times.len())?,
            scene_objects: file.scene_objects,
            camera: file.camera,
            times,
        })
    }
}

fn numbers(values: impl Iterator<Item = f64>) -> Vec<Number> {
    values.map(Number).collect()
}

fn plain(values: Vec<Number>) -> Vec<f64> {
    values.into_iter().map(|Number(x)| x).collect()
}

fn column(series: &Series) -> Column {
    Column {
        name: series.name.clone(),
        values: numbers(series.values.iter().copied()),
    }
}

fn robot(track: &Track) -> Robot {
    let rows = track.rows().into_iter();
    let columns = rows.nested(|rows| (0..rows.width).map(|j| rows.column(j)));
    let names = track.state_names().into_iter();
    let frame = |id: &FrameId| track.frame_name(*id).to_owned();
    let forces = track.forces.iter().map(|force| Force {
        frame: frame(&force.frame),
        values: force
            .values
            .iter()
            .map(|f| [f.x, f.y, f.z].map(Number))
            .collect(),
    });
    Robot {
        name: track.name.clone(),
        model: track.model.name().into(),
        placement: track.placement.to_entries(),
        columns: names
            .zip(columns)
            .map(|(name, column)| Column {
                name,
                values: numbers(column),
            })
            .collect(),
        inputs: track.inputs.clone(),
        forces: forces.collect(),
        traces: track.traces.iter().map(frame).collect(),
        frames: track.frames.iter().map(frame).collect(),
        bonds: track
            .bonds
            .iter()
            .map(|bond| bond.stored(&track.model))
            .collect(),
        contacts: track.touches.clone(),
    }
}

/// The robot of a file, if it is one of this model.
fn track(path: &Path, robot: Robot, model: &Model, length: usize) -> Result<Track, RecordingError> {
    let mut track = Track::new(&robot.name, model);
    let n_state = model.nq() + model.nv();
    let count = |first: usize, kind| {
        let others = robot.columns.iter().skip(first);
        let named = others.zip(numbered(kind, usize::MAX));
        named.take_while(|(own, name)| own.name == *name).count()
    };
    let n_contact = count(n_state, "contact");
    let n_activation = count(n_state + n_contact, "activation");
    let n_others = n_state + n_contact + n_activation;
    let n_inputs = robot.columns.len().saturating_sub(n_others);
    (track.contact, track.u) = (Rows::new(n_contact), Rows::new(n_inputs));
    track.activation = Rows::new(n_activation);
    check_columns(path, &robot, &track)?;
    let columns = series(path, robot.columns, length)?;
    let (q, rest) = columns.split_at(model.nq());
    let (v, rest) = rest.split_at(model.nv());
    let (contact, rest) = rest.split_at(n_contact);
    let (activation, u) = rest.split_at(n_activation);
    (track.q, track.v) = (rows(q, length), rows(v, length));
    (track.contact, track.u) = (rows(contact, length), rows(u, length));
    track.activation = rows(activation, length);
    track.sleep = rows(&[], length);
    track.inputs = robot.inputs;
    track.placement = Transform::from_entries(robot.placement);
    let unknown = |error: UnknownName| other_robots(path, error.to_string());
    for force in robot.forces {
        let frame = model.find_frame(&force.frame).map_err(unknown)?;
        check_length(path, &force.frame, force.values.len(), length)?;
        let values = force
            .values
            .iter()
            .map(|f| Vector3::from(f.map(|Number(x)| x)));
        let values = values.collect();
        track.forces.push(ForceTrack { frame, values });
    }
    for frame in &robot.traces {
        track.trace(frame).map_err(unknown)?;
    }
    for frame in &robot.frames {
        track.show_frame(frame).map_err(unknown)?;
    }
    let moments = robot.contacts.iter().map(|at| at.moment);
    let next = moments.clone().skip(1).chain([length]);
    if let Some((k, _)) = moments.zip(next).find(|(k, next)| k >= next) {
        let reason = format!(
            "contacts of moment {k} are not before the next ones, or not within {length} times"
        );
        return Err(malformed(path, 1, reason));
    }
    track.touches = robot.contacts;
    for bond in robot.bonds {
        track.bonds.push(Bond::read(bond, model).map_err(unknown)?);
    }
    Ok(track)
}

/// Checks that the columns of a file are those of a robot, by their names.
fn check_columns(path: &Path, robot: &Robot, track: &Track) -> Result<(), RecordingError> {
    let given = robot.columns.iter().map(|column| column.name.as_str());
    let expected = track.state_names();
    let mut pairs = given.map(Some).chain(iter::repeat(None)).zip(&expected);
    let Some((given, expected)) = pairs.find(|(given, expected)| *given != Some(*expected)) else {
        return Ok(());
    };
    let given = given.map_or("missing".into(), |given| format!("\"{given}\""));
    let (file, model) = (&robot.model, track.model.name());
    let reason =
        format!("where \"{model}\" has the column \"{expected}\", that of \"{file}\" is {given}");
    Err(other_robots(path, reason))
}

fn rows(columns: &[Series], length: usize) -> Rows {
    let columns: Vec<_> = columns.iter().map(|c| c.values.as_slice()).collect();
    Rows::from_columns(&columns, length)
}

fn series(path: &Path, columns: Vec<Column>, length: usize) -> Result<Vec<Series>, RecordingError> {
    let check = |column: Column| {
        check_length(path, &column.name, column.values.len(), length)?;
        Ok(Series {
            name: column.name,
            values: plain(column.values),
        })
    };
    columns.into_iter().map(check).collect()
}

fn check_length(
    path: &Path,
    of: &str,
    given: usize,
    expected: usize,
) -> Result<(), RecordingError> {
    if given == expected {
        return Ok(());
    }
    let reason = format!("\"{of}\" has {given} values at {expected} times");
    Err(RecordingError::Malformed {
        file: name(path),
        line: 1,
        reason,
    })
}
