//! The numbers of independent engines, made by `tests/golden/make.py`; joints are compared by name.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use dualbody::dynamics::{
    bias_forces, center_of_mass, center_of_mass_acceleration, center_of_mass_jacobian,
    center_of_mass_velocity, centroidal_momentum, centroidal_momentum_matrix,
    centroidal_momentum_rate, coriolis_matrix, forward_dynamics, forward_dynamics_derivatives,
    frame_acceleration, frame_jacobian, frame_jacobian_derivative, frame_pose, frame_velocity,
    gravity_forces, inverse_dynamics, inverse_dynamics_derivatives, kinetic_energy, mass_matrix,
    potential_energy,
};
use dualbody::model::FrameId;
use dualbody::spatial::{Representation, SPATIAL};
use dualbody::{Base, Integrator, Model, ModelOptions, Simulator, State};
use nalgebra::{DMatrix, DVector};

use crate::common::{OTHER_ALGORITHM, SAME_ALGEBRA};

const MANIFEST: &str = env!("CARGO_MANIFEST_DIR");

/// Records that are inputs.
const INPUTS: [&str; 4] = ["q", "v", "a", "tau"];

/// Numbers are compared relative to the largest of a record, or to this if all are smaller.
const NEGLIGIBLE: f64 = 1e-3;

/// One file: a robot on a base in an engine.
struct Golden {
    file: String,
    header: HashMap<String, Vec<String>>,
    states: Vec<Vec<(String, DMatrix<f64>)>>,
}

impl Golden {
    fn read(path: &Path) -> Self {
        let mut golden = Self {
            file: path.file_stem().expect("a name").display().to_string(),
            header: HashMap::new(),
            states: Vec::new(),
        };
        let text = fs::read_to_string(path).expect("golden values");
        for line in text.lines().filter(|line| !line.starts_with('#')) {
            let (key, rest) = line.split_once(' ').unwrap_or((line, ""));
            let words = rest.split(' ').filter(|word| !word.is_empty());
            if key == "state" {
                golden.states.push(Vec::new());
            } else if let Some(state) = golden.states.last_mut() {
                state.push((key.into(), matrix(words)));
            } else {
                golden
                    .header
                    .insert(key.into(), words.map(Into::into).collect());
            }
        }
        golden
    }

    fn word(&self, key: &str) -> &str {
        &self.header[key][0]
    }

    fn number(&self, key: &str) -> f64 {
        self.header
            .get(key)
            .map_or(0.0, |words| words[0].parse().expect("a number"))
    }

    fn model(&self) -> Model {
        let base = match self.word("base") {
            "fixed" => Base::Fixed,
            _ => Base::Floating,
        };
        let mut options = ModelOptions::default().with_base(base);
        if self.word("mimic") == "independent" {
            options = options.with_independent_mimic_joints();
        }
        let path = format!("{MANIFEST}/assets/{}.urdf", self.word("robot"));
        let xml = fs::read_to_string(path).expect("a robot");
        let xml = match base {
            Base::Floating => without_world(&xml),
            _ => xml,
        };
        let mut model = options.load_urdf_str(&xml).expect("a robot").0;
        for k in base_nv(&model)..model.nv() {
            model = model
                .with_damping(k, self.number("damping"))
                .with_armature(k, self.number("armature"));
        }
        model
    }

    /// For each coordinate of the model, where the file has it: the base comes first in both, then one number a joint.
    fn order(&self, model: &Model, base: usize) -> Vec<usize> {
        let place = |name: &str| {
            let known = &self.header["joints"];
            base + known
                .iter()
                .position(|known| known == name)
                .expect("a joint")
        };
        let independent = model
            .joints()
            .iter()
            .filter(|joint| model.body(joint.body).coupling.is_none());
        (0..base)
            .chain(independent.map(|joint| place(&joint.name)))
            .collect()
    }
}

/// Rows, columns, then the numbers row by row.
fn matrix<'a>(mut words: impl Iterator<Item = &'a str>) -> DMatrix<f64> {
    let mut size = || -> usize {
        let word = words.next().expect("a size");
        word.parse().expect("a size")
    };
    let (rows, columns) = (size(), size());
    DMatrix::from_row_iterator(
        rows,
        columns,
        words.map(|word| word.parse::<f64>().expect("a number")),
    )
}

fn base_nv(model: &Model) -> usize {
    if model.has_floating_base() {
        SPATIAL
    } else {
        0
    }
}

/// A model, with the state at which it is evaluated in its own coordinates.
struct Case {
    model: Model,
    tip: Option<FrameId>,
    /// Where the file has each velocity coordinate, and each coordinate of the configuration.
    order: Vec<usize>,
    order_q: Vec<usize>,
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    tau: Vec<f64>,
}

impl Case {
    fn new(golden: &Golden, state: &[(String, DMatrix<f64>)]) -> Self {
        let model = golden.model();
        let order = golden.order(&model, base_nv(&model));
        let order_q = golden.order(&model, base_nv(&model) + model.nq() - model.nv());
        let read = |name: &str, order: &[usize]| -> Vec<f64> {
            let found = state.iter().find(|(key, _)| key == name);
            found.map_or(Vec::new(), |(_, x)| order.iter().map(|&k| x[k]).collect())
        };
        let [v, a, tau] = ["v", "a", "tau"].map(|name| read(name, &order));
        let tip = golden.header.get("tip");
        Self {
            tip: tip.map(|tip| model.frame(&tip[0]).expect("a link")),
            q: read("q", &order_q),
            v,
            a,
            tau,
            order,
            order_q,
            model,
        }
    }

    /// Columns of a record in the order of the model.
    fn columns(&self, record: &DMatrix<f64>) -> DMatrix<f64> {
        record.select_columns(&self.order)
    }

    /// Rows of a record in the order of the model.
    fn rows(&self, record: &DMatrix<f64>) -> DMatrix<f64> {
        record.select_rows(&self.order)
    }
}

/// A description without the link `world`, if a link is fixed to it, which then floats: the file from which the values were made.
fn without_world(xml: &str) -> String {
    let mut parts = xml.split("<joint ").map(str::to_owned);
    let mut out = parts.next().unwrap_or_default();
    for part in parts {
        let (joint, rest) = part.split_once("</joint>").expect("an end");
        if joint.contains("type=\"fixed\"") && joint.contains("<parent link=\"world\"/>") {
            out = out.replace("<link name=\"world\"/>", "") + rest;
        } else {
            out += &format!("<joint {part}");
        }
    }
    out
}

#[test]
fn everything_agrees_with_pinocchio() {
    check_engine("pinocchio");
}

#[test]
fn mass_matrix_bias_forces_and_motion_agree_with_mujoco() {
    check_engine("mujoco");
}

#[test]
fn every_robot_in_assets_has_golden_values() {
    let known: Vec<Golden> = golden_files()
        .iter()
        .map(|path| Golden::read(path))
        .collect();
    for path in files(&format!("{MANIFEST}/assets"), "urdf") {
        let robot = path.file_stem().expect("a name").display().to_string();
        for engine in ["pinocchio", "mujoco"] {
            let found = known
                .iter()
                .any(|golden| golden.word("robot") == robot && golden.word("engine") == engine);
            assert!(found, "no values of {engine} for {robot}");
        }
    }
}

fn check_engine(engine: &str) {
    for path in golden_files() {
        let golden = Golden::read(&path);
        if golden.word("engine") != engine {
            continue;
        }
        for (k, state) in golden.states.iter().enumerate() {
            let case = Case::new(&golden, state);
            for (name, record) in state {
                if !INPUTS.contains(&name.as_str()) {
                    check(&case, name, record, &format!("{}, state {k}", golden.file));
                }
            }
        }
    }
}

fn check(case: &Case, name: &str, record: &DMatrix<f64>, whence: &str) {
    let (actual, expected) = compare(case, name, record);
    assert_eq!(actual.shape(), expected.shape(), "{whence}: {name}");
    let error = (&actual - &expected).amax() / expected.amax().max(NEGLIGIBLE);
    assert!(
        error <= tolerance(name) && actual.iter().all(|x| x.is_finite()),
        "{whence}: {name}: relative error {error:e}\nactual {actual}expected {expected}"
    );
}

/// Results without a linear solve or a simulation are equal up to rounding.
///
/// After a second a floating robot differs by the truncation errors: both engines have a Runge–Kutta method of order
/// four, but not the same one for rotations. With half the step the differences are a sixteenth.
fn tolerance(name: &str) -> f64 {
    if name.starts_with("forward_dynamics") || name.starts_with("final") {
        OTHER_ALGORITHM
    } else {
        SAME_ALGEBRA
    }
}

fn golden_files() -> Vec<PathBuf> {
    files(&format!("{MANIFEST}/tests/golden"), "txt")
}

fn files(folder: &str, extension: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut paths: Vec<_> = entries
        .map(|entry| entry.expect("an entry").path())
        .collect();
    paths.retain(|path| path.extension().is_some_and(|found| found == extension));
    paths.sort();
    paths
}

/// Result of the crate for a record, and the record, both in the order of the model.
fn compare(case: &Case, name: &str, record: &DMatrix<f64>) -> (DMatrix<f64>, DMatrix<f64>) {
    let Case {
        model,
        q,
        v,
        a,
        tau,
        ..
    } = case;
    let of_bodies = |x: &[f64]| (DMatrix::from_column_slice(x.len(), 1, x), record.clone());
    let along_joints = |x: &[f64]| (DMatrix::from_column_slice(x.len(), 1, x), case.rows(record));
    let square = |x: DMatrix<f64>| (x, case.rows(&case.columns(record)));
    let by_joints = |x: DMatrix<f64>| (x, case.columns(record));
    match name {
        "mass_matrix" => square(mass_matrix(model, q)),
        "coriolis_matrix" => square(coriolis_matrix(model, q, v)),
        "bias_forces" => along_joints(bias_forces(model, q, v).as_slice()),
        "gravity_forces" => along_joints(gravity_forces(model, q).as_slice()),
        "inverse_dynamics" => along_joints(inverse_dynamics(model, q, v, a).as_slice()),
        "forward_dynamics" => along_joints(forward_dynamics(model, q, v, tau).as_slice()),
        "inverse_dynamics_dq" => square(inverse_dynamics_derivatives(model, q, v, a).dq),
        "inverse_dynamics_dv" => square(inverse_dynamics_derivatives(model, q, v, a).dv),
        "forward_dynamics_dq" => square(forward_dynamics_derivatives(model, q, v, tau).dq),
        "forward_dynamics_dv" => square(forward_dynamics_derivatives(model, q, v, tau).dv),
        "forward_dynamics_dtau" => square(forward_dynamics_derivatives(model, q, v, tau).dtau),
        "center_of_mass" => of_bodies(center_of_mass(model, q).as_slice()),
        "center_of_mass_velocity" => of_bodies(center_of_mass_velocity(model, q, v).as_slice()),
        "center_of_mass_acceleration" => {
            of_bodies(center_of_mass_acceleration(model, q, v, a).as_slice())
        }
        "center_of_mass_jacobian" => by_joints(center_of_mass_jacobian(model, q)),
        "centroidal_momentum" => of_bodies(&centroidal_momentum(model, q, v).to_array()),
        "centroidal_momentum_rate" => {
            of_bodies(&centroidal_momentum_rate(model, q, v, a).to_array())
        }
        "centroidal_momentum_matrix" => by_joints(centroidal_momentum_matrix(model, q)),
        "kinetic_energy" => of_bodies(&[kinetic_energy(model, q, v)]),
        "potential_energy" => of_bodies(&[potential_energy(model, q)]),
        "final_q" | "final_v" => final_state(case, name, record),
        _ => compare_frame(case, name, record),
    }
}

/// A record `quantity:link` or `quantity:representation`, the latter of the tip.
fn compare_frame(case: &Case, name: &str, record: &DMatrix<f64>) -> (DMatrix<f64>, DMatrix<f64>) {
    let Case { model, q, v, a, .. } = case;
    let (quantity, of) = name.split_once(':').expect("a frame");
    if quantity == "frame_pose" {
        let pose = frame_pose(model, q, model.frame(of).expect("a link"));
        let mut actual = DMatrix::zeros(3, 4);
        actual.columns_mut(0, 3).copy_from(&pose.rotation);
        actual.column_mut(3).copy_from(&pose.translation);
        return (actual, record.clone());
    }
    let tip = case.tip.expect("a tip");
    let frame = match of {
        "body" => Representation::Body,
        "mixed" => Representation::Mixed,
        _ => Representation::Inertial,
    };
    let column = |x: [f64; SPATIAL]| (DMatrix::from_column_slice(SPATIAL, 1, &x), record.clone());
    match quantity {
        "frame_velocity" => column(frame_velocity(model, q, v, tip, frame).to_array()),
        "frame_acceleration" => column(frame_acceleration(model, q, v, a, tip, frame).to_array()),
        "frame_jacobian" => (frame_jacobian(model, q, tip, frame), case.columns(record)),
        "frame_jacobian_derivative" => (
            frame_jacobian_derivative(model, q, v, tip, frame),
            case.columns(record),
        ),
        _ => panic!("unknown record {name}"),
    }
}

/// Where one second takes the robot: the way from the first configuration, or the velocity.
fn final_state(case: &Case, name: &str, record: &DMatrix<f64>) -> (DMatrix<f64>, DMatrix<f64>) {
    const STEPS: usize = 1000;
    let model = &case.model;
    let simulator = Simulator::new(model.clone())
        .with_time_step(1e-3)
        .with_integrator(Integrator::RungeKutta4);
    let u = &case.tau[base_nv(model)..];
    let start = State::new(&case.q, &case.v);
    let last = (0..STEPS).fold(start.clone(), |state, _| simulator.step(&state, u));
    let column = |x: DVector<f64>| DMatrix::from_column_slice(x.len(), 1, x.as_slice());
    if name == "final_v" {
        return (column(last.v), case.rows(record));
    }
    let expected = record.select_rows(&case.order_q);
    let way = |q: &[f64]| column(model.difference(&case.q, q));
    (way(last.q.as_slice()), way(expected.as_slice()))
}
