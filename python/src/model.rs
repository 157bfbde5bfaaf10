//! Robots: loading, questions, changes.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use dualbody::error::EditError;
use dualbody::io::MasslessLinks;
use dualbody::joint::JointKind;
use dualbody::model::{
    Base, Collision, Geometry, JointId, JointSpec, Limits, LinkSpec, Mimic, Mimicry, ModelBuilder,
    SecondAxis, Spring, UpAxis, Visual, samples,
};
use dualbody::sim::{Engine, EngineCoordinates};
use dualbody::spatial::{Inertia, Symmetric3, Transform};
use dualbody::{ImportReport, Model, ModelOptions};
use nalgebra::{DVector, Matrix3, Vector3};
use num_dual::Dual64;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PySlice, PyString, PyTuple};
use rand::SeedableRng;

use crate::arrays::{Array, Work, argument, map_rows, numbers, read_vector, vector};
use crate::errors::{OrRaise, guarded, type_error, value_error};

/// Robot: an immutable tree of bodies and joints.
///
/// Made by `Model.from_urdf`, `Model.from_sdf`, `ModelBuilder` or a function of `dualbody.samples`. Units are SI; q has nq numbers,
/// velocities, accelerations and forces have nv. Pickles as its description.
#[pyclass(frozen, name = "Model", module = "dualbody", weakref)]
pub(crate) struct PyModel {
    pub(crate) model: Arc<Model>,
    /// One number for each robot that was made: what working memory is known by.
    pub(crate) id: u64,
    report: Option<Py<PyImportReport>>,
    /// Name of the function of this module that makes the robot, and its arguments.
    recipe: (&'static str, Py<PyTuple>),
}

/// Makes numbers by which models and simulators are told apart.
pub(crate) fn next_id() -> u64 {
    static LAST: AtomicU64 = AtomicU64::new(0);
    LAST.fetch_add(1, Ordering::Relaxed)
}

impl PyModel {
    fn new(model: Model, recipe: (&'static str, Bound<'_, PyTuple>)) -> Self {
        Self {
            model: Arc::new(model),
            id: next_id(),
            report: None,
            recipe: (recipe.0, recipe.1.unbind()),
        }
    }

    /// A changed robot, which remembers what it was made of.
    fn edited<'py>(
        this: &Bound<'py, Self>,
        method: &str,
        arguments: impl IntoPyObject<'py, Target = PyTuple, Output = Bound<'py, PyTuple>, Error = PyErr>,
        model: Result<Model, EditError>,
    ) -> PyResult<Self> {
        let py = this.py();
        let arguments = arguments.into_pyobject(py)?;
        let recipe = (this, method, arguments).into_pyobject(py)?;
        Ok(Self::new(model.or_raise()?, ("_edited", recipe)))
    }

    /// Applies a function of rows without working memory.
    fn map<'py>(
        &self,
        py: Python<'py>,
        arguments: &[(&'static str, &Bound<'py, PyAny>, usize)],
        width: usize,
        one: &(dyn Fn(&[&[f64]], &mut [f64]) + Sync),
    ) -> PyResult<Array<'py>> {
        let tails: Vec<[usize; 1]> = arguments.iter().map(|a| [a.2]).collect();
        let pairs = arguments.iter().zip(&tails);
        let arguments: Vec<_> = pairs.map(|(a, tail)| argument(a.0, a.1, tail)).collect();
        let work = Work {
            one: &|_, x, out| one(x, out),
            wide: None,
        };
        map_rows(py, (&self.model, self.id), &arguments, &[width], None, work)
    }

    fn joint_id(&self, name: &str) -> PyResult<JointId> {
        self.model.find_joint(name).or_raise()
    }
}

pub(crate) fn base_of(name: &str) -> PyResult<Base> {
    match name {
        "auto" => Ok(Base::Auto),
        "fixed" => Ok(Base::Fixed),
        "floating" => Ok(Base::Floating),
        _ => Err(value_error(format_args!(
            "base is \"{name}\", not \"auto\", \"fixed\" or \"floating\""
        ))),
    }
}

fn up_axis(name: &str) -> PyResult<UpAxis> {
    match name {
        "auto" => Ok(UpAxis::Auto),
        "honour" => Ok(UpAxis::Honour),
        "ignore" => Ok(UpAxis::Ignore),
        _ => Err(value_error(format_args!(
            "mesh_up_axis is \"{name}\", not \"auto\", \"honour\" or \"ignore\""
        ))),
    }
}

/// Reads the keywords of a loader.
fn options_of(keywords: &Bound<'_, PyDict>) -> PyResult<ModelOptions> {
    let mut options = ModelOptions::default();
    for (name, value) in keywords {
        let name: String = name.extract()?;
        let wrong = |error: PyErr| type_error(format_args!("{name}: {}", error.value(value.py())));
        options = match name.as_str() {
            "base" => options.with_base(base_of(&value.extract::<String>().map_err(wrong)?)?),
            "gravity" => options.with_gravity(value.extract().map_err(wrong)?),
            "independent_mimic_joints" if value.extract().map_err(wrong)? => {
                options.with_independent_mimic_joints()
            }
            "independent_mimic_joints" => options,
            "kept_joints" => {
                options.with_kept_joints(value.extract::<Vec<String>>().map_err(wrong)?)
            }
            "locked_joints" => {
                let positions = by_name(
                    value
                        .cast::<PyDict>()
                        .map_err(|error| wrong(error.into()))?,
                )?;
                let lock = |options: ModelOptions, (name, x): &(String, Vec<f64>)| {
                    options.with_locked_joint(name.clone(), x)
                };
                positions.iter().fold(options, lock)
            }
            "massless_links" => options.with_massless_links(massless(&value)?),
            "mesh_up_axis" => {
                options.with_mesh_up_axis(up_axis(&value.extract::<String>().map_err(wrong)?)?)
            }
            "model_name" => options.with_model_name(value.extract::<String>().map_err(wrong)?),
            "search_paths" => {
                let paths: Vec<PathBuf> = value.extract().map_err(wrong)?;
                paths
                    .into_iter()
                    .fold(options, ModelOptions::with_search_path)
            }
            "roots" => {
                let paths: Vec<PathBuf> = value.extract().map_err(wrong)?;
                paths.into_iter().fold(options, ModelOptions::with_root)
            }
            _ => {
                return Err(type_error(format_args!(
                    "\"{name}\" is no keyword of a loader"
                )));
            }
        };
    }
    Ok(options)
}

/// "kept", "refused", or (mass, radius) of a ball that such links get.
fn massless(value: &Bound<'_, PyAny>) -> PyResult<MasslessLinks> {
    if let Ok((mass, radius)) = value.extract() {
        return Ok(MasslessLinks::SolidBall { mass, radius });
    }
    match value.extract::<String>().as_deref() {
        Ok("kept") => Ok(MasslessLinks::Kept),
        Ok("refused") => Ok(MasslessLinks::Refused),
        _ => Err(value_error(
            "massless_links is not \"kept\", \"refused\" or (mass, radius)",
        )),
    }
}

/// Loads a robot from a text that begins like XML, or from a file.
fn from_description(
    format: &'static str,
    description: &Bound<'_, PyAny>,
    keywords: Option<&Bound<'_, PyDict>>,
) -> PyResult<PyModel> {
    let py = description.py();
    let none = PyDict::new(py);
    let keywords = keywords.unwrap_or(&none);
    match description.extract::<String>() {
        Ok(text) if text.trim_start().starts_with('<') => {
            _load_model(py, format, Some(text), None, keywords)
        }
        _ => {
            let path = description
                .extract::<PathBuf>()
                .map_err(|_| type_error("description is no text and no path"))?;
            _load_model(py, format, None, Some(path), keywords)
        }
    }
}

/// Loads a robot: `format` is "urdf" or "sdf", `text` the description, `path` the file that it is from, if it is from one.
///
/// A pickled robot is loaded from its text again; its meshes are looked for beside the file if that is there.
#[pyfunction]
pub(crate) fn _load_model(
    py: Python<'_>,
    format: &str,
    text: Option<String>,
    path: Option<PathBuf>,
    options: &Bound<'_, PyDict>,
) -> PyResult<PyModel> {
    let wanted = guarded(|| options_of(options))??;
    let read = path
        .as_ref()
        .and_then(|path| std::fs::read_to_string(path).ok());
    let is_from_file = path.is_some() && (text.is_none() || text == read);
    let loaded = py.detach(|| {
        guarded(|| match (format, &path, &text) {
            ("urdf", Some(path), _) if is_from_file => wanted.load_urdf_file(path),
            ("sdf", Some(path), _) if is_from_file => wanted.load_sdf_file(path),
            ("urdf", _, Some(text)) => beside(wanted, path.as_ref()).load_urdf_str(text),
            (_, _, Some(text)) => beside(wanted, path.as_ref()).load_sdf_str(text),
            _ => wanted.load_urdf_str(""),
        })
    })?;
    let (model, report) = loaded.or_raise()?;
    let recipe = (format, text.or(read), path, options).into_pyobject(py)?;
    let report = Py::new(py, PyImportReport { report })?;
    let model = PyModel::new(model, ("_load_model", recipe));
    Ok(PyModel {
        report: Some(report),
        ..model
    })
}

/// Options that look for meshes beside a file too.
fn beside(options: ModelOptions, path: Option<&PathBuf>) -> ModelOptions {
    match path.and_then(|path| path.parent()) {
        Some(dir) if dir.is_dir() => options.with_search_path(dir),
        _ => options,
    }
}

/// Calls a method of a robot that gives a changed one.
#[pyfunction]
pub(crate) fn _edited<'py>(
    model: &Bound<'py, PyModel>,
    method: &str,
    arguments: &Bound<'py, PyTuple>,
) -> PyResult<Bound<'py, PyAny>> {
    model.call_method1(method, arguments)
}

/// One of the robots that come with the library.
#[pyfunction]
#[pyo3(signature = (name, *arguments))]
pub(crate) fn _sample(name: &str, arguments: &Bound<'_, PyTuple>) -> PyResult<PyModel> {
    let model = match name {
        "pendulum" => samples::pendulum(),
        "double_pendulum" => samples::double_pendulum(),
        "cartpole" => samples::cartpole(),
        "arm" => samples::arm(),
        "random_tree" => {
            let (n, seed) = arguments.extract()?;
            guarded(|| samples::random_tree(n, seed))?
        }
        _ => return Err(value_error(format_args!("there is no sample \"{name}\""))),
    };
    let py = arguments.py();
    let name = PyString::new(py, name).into_any();
    let all = std::iter::once(name).chain(arguments.iter());
    let recipe = PyTuple::new(py, all.collect::<Vec<_>>())?;
    Ok(PyModel::new(model, ("_sample", recipe)))
}

/// A pose from a matrix [[R, p], [0, 1]], or from a translation.
pub(crate) fn read_pose(name: &'static str, value: &Bound<'_, PyAny>) -> PyResult<Transform<f64>> {
    use numpy::{PyArrayMethods, PyUntypedArrayMethods};
    let array = numbers(name, value)?;
    // SAFETY: the array is in C order, and its numbers are copied before Python goes on.
    let x = unsafe { array.as_slice().unwrap_or(&[]) };
    match array.shape() {
        [3] => Ok(Transform::from_translation(Vector3::new(x[0], x[1], x[2]))),
        [4, 4] => {
            let rotation = Matrix3::from_fn(|i, j| x[4 * i + j]);
            let off = (rotation.transpose() * rotation - Matrix3::identity()).norm();
            if !(off < 1e-6 && rotation.determinant() > 0.0) {
                return Err(value_error(format_args!(
                    "{name}[:3, :3] is not a rotation"
                )));
            }
            Ok(Transform::new(rotation, Vector3::new(x[3], x[7], x[11])))
        }
        shape => Err(value_error(format_args!(
            "{name} has the shape {shape:?}, expected (4, 4), or (3,) for a translation"
        ))),
    }
}

/// An inertia from mass, centre of mass in the link frame and the matrix about the centre of mass.
fn inertia_of(mass: f64, com: [f64; 3], about_com: [[f64; 3]; 3]) -> Inertia<f64> {
    let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = about_com;
    Inertia::from_com(mass, &com.into(), &Symmetric3::new(xx, xy, xz, yy, yz, zz))
}

type GivenGeometry = (String, Vec<f64>, Option<String>);

fn geometry((kind, x, uri): &GivenGeometry) -> PyResult<Geometry> {
    match (kind.as_str(), x.as_slice(), uri) {
        ("box", &[x, y, z], _) => Ok(Geometry::Box { size: [x, y, z] }),
        ("sphere", &[radius], _) => Ok(Geometry::Sphere { radius }),
        ("cylinder", &[radius, length], _) => Ok(Geometry::Cylinder { radius, length }),
        ("capsule", &[radius, length], _) => Ok(Geometry::Capsule { radius, length }),
        ("mesh", &[x, y, z], Some(uri)) => Ok(Geometry::Mesh {
            uri: uri.clone(),
            path: Some(PathBuf::from(uri)).filter(|path| path.exists()),
            scale: [x, y, z],
            up_axis: UpAxis::Auto,
        }),
        _ => Err(value_error(format_args!("geometry is ({kind:?}, {x:?})"))),
    }
}

/// A shape of Python, by its numbers.
pub(crate) fn read_geometry(shape: &Bound<'_, PyAny>) -> PyResult<Geometry> {
    geometry(&shape.call_method0("_numbers")?.extract()?)
}

fn link_of(link: &Bound<'_, PyAny>) -> PyResult<LinkSpec> {
    let name: String = link.getattr("name")?.extract()?;
    let mass: f64 = link.getattr("mass")?.extract()?;
    let (com, inertia) = (
        link.getattr("com")?.extract()?,
        link.getattr("inertia")?.extract()?,
    );
    let mut spec = LinkSpec::new(name).with_inertia(inertia_of(mass, com, inertia));
    for shape in link.getattr("visuals")?.try_iter()? {
        let shape = shape?;
        spec = spec.with_visual(Visual {
            name: None,
            placement: read_pose("placement", &shape.getattr("placement")?)?,
            geometry: read_geometry(&shape)?,
            color: shape.getattr("color")?.extract()?,
        });
    }
    for shape in link.getattr("collisions")?.try_iter()? {
        let shape = shape?;
        spec = spec.with_collision(Collision {
            name: None,
            placement: read_pose("placement", &shape.getattr("placement")?)?,
            geometry: read_geometry(&shape)?,
        });
    }
    Ok(spec)
}

fn kind_of(name: &str) -> PyResult<JointKind> {
    Ok(match name {
        "fixed" => JointKind::Fixed,
        "revolute" => JointKind::Revolute,
        "continuous" => JointKind::Continuous,
        "prismatic" => JointKind::Prismatic,
        "universal" => JointKind::Universal,
        "spherical" => JointKind::Spherical,
        "planar" => JointKind::Planar,
        "floating" => JointKind::Floating,
        _ => {
            return Err(value_error(format_args!(
                "kind is \"{name}\", which is no kind of joint"
            )));
        }
    })
}

fn limits_of(value: &Bound<'_, PyAny>) -> PyResult<Limits> {
    let (lower, upper, velocity, effort) = value.extract()?;
    Ok(Limits {
        lower,
        upper,
        velocity,
        effort,
    })
}

fn joint_of(joint: &Bound<'_, PyAny>) -> PyResult<JointSpec> {
    let text = |name: &str| -> PyResult<String> { joint.getattr(name)?.extract() };
    let number = |name: &str| -> PyResult<f64> { joint.getattr(name)?.extract() };
    let (stiffness, rest) = joint.getattr("spring")?.extract()?;
    let mut spec = JointSpec::new(
        text("name")?,
        kind_of(&text("kind")?)?,
        text("parent")?,
        text("child")?,
    )
    .with_placement(read_pose("placement", &joint.getattr("placement")?)?)
    .with_axis(joint.getattr("axis")?.extract()?)
    .with_limits(limits_of(&joint.getattr("limits")?)?)
    .with_damping(number("damping")?)
    .with_friction(number("friction")?)
    .with_armature(number("armature")?)
    .with_spring(stiffness, rest);
    if let Some((leader, multiplier, offset)) = joint.getattr("mimic")?.extract()? {
        spec = spec.with_mimic(Mimic {
            leader,
            multiplier,
            offset,
        });
    }
    if let Some(axis) = joint
        .getattr("second_axis")?
        .extract::<Option<[f64; 3]>>()?
    {
        spec = spec.with_second_axis(SecondAxis::about(axis));
    }
    Ok(spec)
}

/// Builds a robot from links, joints and frames.
#[pyfunction]
pub(crate) fn _build_model(
    name: String,
    gravity: [f64; 3],
    base: &str,
    independent_mimic_joints: bool,
    links: Vec<Bound<'_, PyAny>>,
    joints: Vec<Bound<'_, PyAny>>,
    frames: Vec<(String, String, Bound<'_, PyAny>)>,
    py: Python<'_>,
) -> PyResult<PyModel> {
    let mimicry = match independent_mimic_joints {
        true => Mimicry::Independent,
        false => Mimicry::Coupled,
    };
    let mut builder = ModelBuilder::new(name.clone())
        .with_gravity(gravity)
        .with_base(base_of(base)?)
        .with_mimicry(mimicry);
    for link in &links {
        builder.add_link(link_of(link)?);
    }
    for joint in &joints {
        builder.add_joint(joint_of(joint)?);
    }
    for (name, link, placement) in &frames {
        builder.add_frame(name, link, read_pose("placement", placement)?);
    }
    let model = guarded(|| builder.build())?.or_raise()?;
    let recipe = (
        name,
        gravity,
        base,
        independent_mimic_joints,
        links,
        joints,
        frames,
    );
    Ok(PyModel::new(
        model,
        ("_build_model", recipe.into_pyobject(py)?),
    ))
}

fn engine(name: &str) -> PyResult<Engine> {
    match name {
        "pinocchio" => Ok(Engine::Pinocchio),
        "mujoco" => Ok(Engine::MuJoCo),
        "jaxsim" => Ok(Engine::JaxSim),
        _ => Err(value_error(format_args!(
            "engine is \"{name}\", not \"pinocchio\", \"mujoco\" or \"jaxsim\""
        ))),
    }
}

fn coordinates<'m>(
    model: &'m Model,
    name: &str,
    joints: Option<Vec<String>>,
) -> PyResult<EngineCoordinates<'m>> {
    let coordinates = EngineCoordinates::new(model, engine(name)?);
    match joints {
        None => Ok(coordinates),
        Some(joints) => guarded(|| coordinates.with_joint_order(&joints))?.or_raise(),
    }
}

fn positions<'a>(given: &'a [(String, Vec<f64>)]) -> Vec<(&'a str, &'a [f64])> {
    given
        .iter()
        .map(|(name, x)| (name.as_str(), x.as_slice()))
        .collect()
}

/// Positions by name: a number, or a vector for a joint with several coordinates.
fn by_name(given: &Bound<'_, PyDict>) -> PyResult<Vec<(String, Vec<f64>)>> {
    let one = |(name, x): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
        let x = x
            .extract::<f64>()
            .map(|x| vec![x])
            .or_else(|_| read_vector("positions", &x, None));
        Ok((name.extract::<String>()?, x?))
    };
    given.iter().map(one).collect()
}

#[pymethods]
impl PyModel {
    /// Loads a robot from a URDF: a text that begins with "<", or the path of a file.
    ///
    /// base: "auto" (fixed if the root link is "world"), "fixed" or "floating"; gravity: m/s², (0, 0, -9.81) if left out;
    /// independent_mimic_joints: joints that mimic others get coordinates of their own; kept_joints: names, the others are held;
    /// locked_joints: {name: position}; search_paths, roots: directories of meshes; massless_links: "kept", "refused" or (mass, radius);
    /// mesh_up_axis: "auto", "honour" or "ignore". What the loader remarks is in `import_report`.
    #[staticmethod]
    #[pyo3(signature = (description, **keywords))]
    fn from_urdf(
        description: &Bound<'_, PyAny>,
        keywords: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        from_description("urdf", description, keywords)
    }

    /// Loads a robot from an SDF: a text that begins with "<", or the path of a file. The keywords are those of from_urdf, and
    /// model_name where there are several.
    #[staticmethod]
    #[pyo3(signature = (description, **keywords))]
    fn from_sdf(
        description: &Bound<'_, PyAny>,
        keywords: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        from_description("sdf", description, keywords)
    }

    /// Name of the robot.
    #[getter]
    fn name(&self) -> &str {
        self.model.name()
    }

    /// Number of configuration coordinates.
    #[getter]
    fn nq(&self) -> usize {
        self.model.nq()
    }

    /// Number of velocity coordinates: degrees of freedom.
    #[getter]
    fn nv(&self) -> usize {
        self.model.nv()
    }

    /// Number of moving bodies.
    #[getter]
    fn n_bodies(&self) -> usize {
        self.model.n_bodies()
    }

    /// Number of named joints.
    #[getter]
    fn n_joints(&self) -> usize {
        self.model.n_joints()
    }

    /// Mass of what moves, kg.
    #[getter]
    fn total_mass(&self) -> f64 {
        self.model.total_mass()
    }

    /// Acceleration of gravity, m/s².
    #[getter]
    fn gravity(&self) -> (f64, f64, f64) {
        let g = self.model.gravity();
        (g.x, g.y, g.z)
    }

    #[getter]
    fn has_floating_base(&self) -> bool {
        self.model.has_floating_base()
    }

    #[getter]
    fn joint_names(&self) -> Vec<&str> {
        self.model.joint_names()
    }

    #[getter]
    fn link_names(&self) -> Vec<&str> {
        self.model.link_names()
    }

    #[getter]
    fn frame_names(&self) -> Vec<&str> {
        self.model.frame_names()
    }

    /// Names of the moving bodies: of a link on each, in the order of external forces.
    #[getter]
    fn body_names(&self) -> Vec<&str> {
        let bodies = 0..self.model.n_bodies();
        bodies
            .map(|k| self.model.body_name(dualbody::model::BodyId(k)))
            .collect()
    }

    /// Damping of each velocity coordinate (nv,), N·m·s/rad or N·s/m.
    #[getter]
    fn damping<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        vector(py, self.model.damping().to_vec()).into_any()
    }

    /// Inertia of the rotor of each velocity coordinate (nv,), kg·m² or kg.
    #[getter]
    fn armature<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        vector(py, self.model.armature().to_vec()).into_any()
    }

    /// What was remarked at loading; None for a robot that was built.
    #[getter]
    fn import_report(&self, py: Python<'_>) -> Option<Py<PyImportReport>> {
        self.report.as_ref().map(|report| report.clone_ref(py))
    }

    /// Place of a joint in q.
    fn joint_q<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PySlice>> {
        let range = self.model.joint_q(self.joint_id(name)?);
        Ok(PySlice::new(
            py,
            range.start as isize,
            range.end as isize,
            1,
        ))
    }

    /// Place of a joint in v.
    fn joint_v<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PySlice>> {
        let range = self.model.joint_v(self.joint_id(name)?);
        Ok(PySlice::new(
            py,
            range.start as isize,
            range.end as isize,
            1,
        ))
    }

    /// Kind of a joint: "revolute", "prismatic", …
    fn joint_kind(&self, name: &str) -> PyResult<String> {
        let kind = self.model.joints()[self.joint_id(name)?.0].kind;
        let text = format!("{kind:?}").to_lowercase();
        Ok(text.split('(').next().unwrap_or_default().to_owned())
    }

    /// Limits of a joint: (lower, upper, velocity, effort), None where there is none.
    fn limits<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let limits = self.model.limits(self.joint_id(name)?);
        let numbers = (limits.lower, limits.upper, limits.velocity, limits.effort);
        py.import("dualbody.model")?
            .getattr("Limits")?
            .call1(numbers)
    }

    /// Neutral configuration (nq,).
    fn neutral<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        vector(py, self.model.neutral().as_slice().to_vec()).into_any()
    }

    /// Configuration q moved by the tangent vector dv: (..., nq). q (..., nq), dv (..., nv).
    fn integrate<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        dv: &Bound<'py, PyAny>,
    ) -> PyResult<Array<'py>> {
        let m = &self.model;
        let arguments = [("q", q, m.nq()), ("dv", dv, m.nv())];
        self.map(q.py(), &arguments, m.nq(), &|x, out| {
            m.integrate_into(x[0], x[1], out)
        })
    }

    /// Tangent vector that leads from q0 to q1: (..., nv). q0 and q1 (..., nq).
    fn difference<'py>(
        &self,
        q0: &Bound<'py, PyAny>,
        q1: &Bound<'py, PyAny>,
    ) -> PyResult<Array<'py>> {
        let m = &self.model;
        let arguments = [("q0", q0, m.nq()), ("q1", q1, m.nq())];
        self.map(q0.py(), &arguments, m.nv(), &|x, out| {
            m.difference_into(x[0], x[1], out)
        })
    }

    /// Configuration on the way from q0 (t = 0) to q1 (t = 1): (..., nq).
    fn interpolate<'py>(
        &self,
        q0: &Bound<'py, PyAny>,
        q1: &Bound<'py, PyAny>,
        t: f64,
    ) -> PyResult<Array<'py>> {
        let m = &self.model;
        let arguments = [("q0", q0, m.nq()), ("q1", q1, m.nq())];
        self.map(q0.py(), &arguments, m.nq(), &|x, out| {
            out.copy_from_slice(m.interpolate(x[0], x[1], t).as_slice());
        })
    }

    /// Random configuration within the limits, (nq,), the same for the same seed.
    fn random_configuration<'py>(&self, py: Python<'py>, seed: u64) -> Bound<'py, PyAny> {
        let mut rng = rand::rngs::Xoshiro256PlusPlus::seed_from_u64(seed);
        let q = self.model.random_configuration(&mut rng);
        vector(py, q.as_slice().to_vec()).into_any()
    }

    /// Random velocity of at most a speed in each coordinate, (nv,), the same for the same seed.
    #[pyo3(signature = (seed, speed=1.0))]
    fn random_velocity<'py>(
        &self,
        py: Python<'py>,
        seed: u64,
        speed: f64,
    ) -> PyResult<Bound<'py, PyAny>> {
        let mut rng = rand::rngs::Xoshiro256PlusPlus::seed_from_u64(seed);
        let v = guarded(|| self.model.random_velocity(&mut rng, speed))?;
        Ok(vector(py, v.as_slice().to_vec()).into_any())
    }

    /// Masses, inertias, placements, gravity, damping, rotors and springs in one vector; named by parameter_names.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        vector(py, self.model.parameters().as_slice().to_vec()).into_any()
    }

    #[getter]
    fn parameter_names(&self) -> Vec<String> {
        self.model.parameter_layout().names().to_vec()
    }

    /// The robot with other parameters.
    fn with_parameters<'py>(
        this: &Bound<'py, Self>,
        parameters: &Bound<'py, PyAny>,
    ) -> PyResult<Self> {
        let m = &this.get().model;
        let x = read_vector("parameters", parameters, Some(m.parameters().len()))?;
        let model = guarded(|| m.with_parameters(&x))?;
        Self::edited(this, "with_parameters", (x,), Ok(model))
    }

    /// The robot with another gravity, m/s².
    fn with_gravity<'py>(this: &Bound<'py, Self>, gravity: [f64; 3]) -> PyResult<Self> {
        let model = (*this.get().model).clone();
        let model = guarded(|| model.with_gravity(gravity.into()))?;
        Self::edited(this, "with_gravity", (gravity,), Ok(model))
    }

    /// The robot with another damping in a velocity coordinate, N·m·s/rad or N·s/m.
    fn with_damping<'py>(this: &Bound<'py, Self>, v: usize, damping: f64) -> PyResult<Self> {
        let model = (*this.get().model).clone();
        let model = guarded(|| model.with_damping(v, damping))?;
        Self::edited(this, "with_damping", (v, damping), Ok(model))
    }

    /// The robot with another rotor inertia in a velocity coordinate, kg·m² or kg.
    fn with_armature<'py>(this: &Bound<'py, Self>, v: usize, armature: f64) -> PyResult<Self> {
        let model = (*this.get().model).clone();
        let model = guarded(|| model.with_armature(v, armature))?;
        Self::edited(this, "with_armature", (v, armature), Ok(model))
    }

    /// The robot with another spring in a velocity coordinate, N·m/rad or N/m, at rest at `rest`.
    #[pyo3(signature = (v, stiffness, rest=0.0))]
    fn with_spring<'py>(
        this: &Bound<'py, Self>,
        v: usize,
        stiffness: f64,
        rest: f64,
    ) -> PyResult<Self> {
        let model = (*this.get().model).clone();
        let model = guarded(|| model.with_spring(v, Spring { stiffness, rest }))?;
        Self::edited(this, "with_spring", (v, stiffness, rest), Ok(model))
    }

    /// The robot with another mass of a link, kg; its inertia is scaled.
    fn with_link_mass<'py>(this: &Bound<'py, Self>, link: &str, mass: f64) -> PyResult<Self> {
        let model = guarded(|| this.get().model.with_link_mass(link, mass))?;
        Self::edited(this, "with_link_mass", (link, mass), model)
    }

    /// The robot with another inertia of a link: mass (kg), centre of mass in the link frame (m), matrix about it (kg·m²).
    fn with_link_inertia<'py>(
        this: &Bound<'py, Self>,
        link: &str,
        mass: f64,
        com: [f64; 3],
        inertia: [[f64; 3]; 3],
    ) -> PyResult<Self> {
        let own = inertia_of(mass, com, inertia);
        let model = guarded(|| this.get().model.with_link_inertia(link, own))?;
        Self::edited(this, "with_link_inertia", (link, mass, com, inertia), model)
    }

    /// The robot with joints held at positions {name: position}: their links become one.
    fn with_locked_joints<'py>(
        this: &Bound<'py, Self>,
        positions: &Bound<'py, PyDict>,
    ) -> PyResult<Self> {
        let given = by_name(positions)?;
        let model = guarded(|| {
            this.get()
                .model
                .with_locked_joints(&self::positions(&given))
        })?;
        Self::edited(this, "with_locked_joints", (positions,), model)
    }

    /// The robot with only some joints; the others are held, at positions {name: position} or neutral.
    #[pyo3(signature = (names, positions=None))]
    fn with_kept_joints<'py>(
        this: &Bound<'py, Self>,
        names: Vec<String>,
        positions: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Self> {
        let given = positions.map_or(Ok(Vec::new()), by_name)?;
        let kept: Vec<&str> = names.iter().map(String::as_str).collect();
        let model = guarded(|| {
            this.get()
                .model
                .with_kept_joints(&kept, &self::positions(&given))
        })?;
        Self::edited(this, "with_kept_joints", (names, positions), model)
    }

    /// The robot with another one welded to a frame, at a pose (4, 4) in it; the other's names get a prefix.
    #[pyo3(signature = (other, frame, prefix, pose=None))]
    fn with_attached<'py>(
        this: &Bound<'py, Self>,
        other: &Bound<'py, Self>,
        frame: &str,
        prefix: &str,
        pose: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Self> {
        let at = pose.map_or(Ok(Transform::identity()), |pose| read_pose("pose", pose))?;
        let model = guarded(|| {
            this.get()
                .model
                .with_attached(&other.get().model, frame, prefix, &at)
        })?;
        Self::edited(this, "with_attached", (other, frame, prefix, pose), model)
    }

    /// The robot with one more frame, at a pose (4, 4) in a frame or link.
    fn with_frame<'py>(
        this: &Bound<'py, Self>,
        name: &str,
        parent: &str,
        pose: &Bound<'py, PyAny>,
    ) -> PyResult<Self> {
        let at = read_pose("pose", pose)?;
        let model = guarded(|| this.get().model.with_frame(name, parent, &at))?;
        Self::edited(this, "with_frame", (name, parent, pose), model)
    }

    /// The robot with one more link (LinkSpec) on a joint (JointSpec).
    fn with_body<'py>(
        this: &Bound<'py, Self>,
        link: &Bound<'py, PyAny>,
        joint: &Bound<'py, PyAny>,
    ) -> PyResult<Self> {
        let (own_link, own_joint) = (link_of(link)?, joint_of(joint)?);
        let model = guarded(|| this.get().model.with_body(own_link, own_joint))?;
        Self::edited(this, "with_body", (link, joint), model)
    }

    /// The robot with all lengths and densities multiplied.
    fn scaled<'py>(this: &Bound<'py, Self>, length: f64, density: f64) -> PyResult<Self> {
        let model = guarded(|| this.get().model.scaled(length, density))?;
        Self::edited(this, "scaled", (length, density), model)
    }

    /// The robot as a URDF text.
    fn to_urdf(&self) -> PyResult<String> {
        guarded(|| self.model.to_urdf())?.or_raise()
    }

    /// The robot as a MuJoCo XML text.
    fn to_mjcf(&self) -> PyResult<String> {
        guarded(|| self.model.to_mjcf())?.or_raise()
    }

    /// The tree of links and joints as a text.
    fn tree(&self) -> String {
        self.model.tree().to_string()
    }

    /// Links whose inertia no body can have: [(link, reason)].
    fn inertia_flaws(&self) -> Vec<(String, String)> {
        let flaws = self.model.inertia_flaws().into_iter();
        flaws
            .map(|(link, flaw)| (link.to_owned(), flaw.to_string()))
            .collect()
    }

    /// State of this robot in the coordinates of "pinocchio", "mujoco" or "jaxsim": (q, v). Joints may be in another order.
    #[pyo3(signature = (engine, q, v, joint_order=None))]
    fn to_engine<'py>(
        &self,
        py: Python<'py>,
        engine: &str,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        joint_order: Option<Vec<String>>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let coordinates = coordinates(&self.model, engine, joint_order)?;
        let q = read_vector("q", q, Some(self.model.nq()))?;
        let v = read_vector("v", v, Some(self.model.nv()))?;
        let (q, v) = guarded(|| coordinates.state_to(&dualbody::State::new(&q, &v)))?;
        Ok(pair(py, q, v))
    }

    /// State (q, v) of this robot from the coordinates of "pinocchio", "mujoco" or "jaxsim".
    #[pyo3(signature = (engine, q, v, joint_order=None))]
    fn from_engine<'py>(
        &self,
        py: Python<'py>,
        engine: &str,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        joint_order: Option<Vec<String>>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let coordinates = coordinates(&self.model, engine, joint_order)?;
        let q = read_vector("q", q, Some(coordinates.nq()))?;
        let v = read_vector("v", v, Some(self.model.nv()))?;
        let state = guarded(|| coordinates.state_from(&q, &v))?;
        Ok(pair(py, state.q, state.v))
    }

    /// Page that shows the robot, as HTML.
    fn to_html(&self) -> String {
        dualbody::view::model_page(&self.model)
    }

    /// The page in a frame of a size, for notebooks: width and height as in HTML.
    #[pyo3(signature = (width="100%", height="480"))]
    fn show<'py>(&self, py: Python<'py>, width: &str, height: &str) -> PyResult<Bound<'py, PyAny>> {
        py.import("dualbody.view")?
            .getattr("Page")?
            .call1((self.to_html(), width, height))
    }

    fn _repr_html_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.show(py, "100%", "480")?.call_method0("_repr_html_")
    }

    fn __repr__(&self) -> String {
        let m = &self.model;
        let base = match m.has_floating_base() {
            true => "floating",
            false => "fixed",
        };
        format!(
            "Model(\"{}\", nq={}, nv={}, {} joints, {} base, {:.6} kg)",
            m.name(),
            m.nq(),
            m.nv(),
            m.n_joints(),
            base,
            m.total_mass()
        )
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Py<PyTuple>)> {
        let make = py.import("dualbody._dualbody")?.getattr(self.recipe.0)?;
        Ok((make, self.recipe.1.clone_ref(py)))
    }
}

fn pair<'py>(
    py: Python<'py>,
    a: DVector<f64>,
    b: DVector<f64>,
) -> (Bound<'py, PyAny>, Bound<'py, PyAny>) {
    let array = |x: DVector<f64>| vector(py, x.as_slice().to_vec()).into_any();
    (array(a), array(b))
}

/// What was remarked when a file was loaded: warnings, and what is not used. Its str is a table.
#[pyclass(frozen, name = "ImportReport", module = "dualbody")]
pub(crate) struct PyImportReport {
    report: ImportReport,
}

/// One remark: element, name, line, reason.
type Note = (String, String, u32, String);

fn notes(notes: &[dualbody::io::ImportNote]) -> Vec<Note> {
    let note =
        |n: &dualbody::io::ImportNote| (n.path.clone(), n.name.clone(), n.line, n.reason.clone());
    notes.iter().map(note).collect()
}

#[pymethods]
impl PyImportReport {
    /// File, or "text".
    #[getter]
    fn file(&self) -> &str {
        &self.report.file
    }

    /// Base of the robot: "fixed" or "floating".
    #[getter]
    fn base(&self) -> String {
        format!("{:?}", self.report.base).to_lowercase()
    }

    #[getter]
    fn root_link(&self) -> &str {
        &self.report.root_link
    }

    /// [(element, name, line, reason)] of what was corrected or is doubtful.
    #[getter]
    fn warnings(&self) -> Vec<Note> {
        notes(&self.report.warnings)
    }

    /// [(element, name, line, reason)] of what is not used.
    #[getter]
    fn ignored(&self) -> Vec<Note> {
        notes(&self.report.ignored)
    }

    fn __str__(&self) -> String {
        self.report.to_string()
    }

    fn __repr__(&self) -> String {
        self.report.to_string()
    }

    fn _repr_html_(&self) -> String {
        let escaped = |text: &str| text.replace('&', "&amp;").replace('<', "&lt;");
        let row = |kind: &str, n: &dualbody::io::ImportNote| {
            let cells = [kind, &n.path, &n.name, &n.line.to_string(), &n.reason].map(escaped);
            format!("<tr><td>{}</td></tr>", cells.join("</td><td>"))
        };
        let warnings = self.report.warnings.iter().map(|n| row("warning", n));
        let ignored = self.report.ignored.iter().map(|n| row("not used", n));
        let rows: String = warnings.chain(ignored).collect();
        let head = "<tr><th></th><th>element</th><th>name</th><th>line</th><th>reason</th></tr>";
        format!(
            "<p>{} ({} base, root {})</p><table>{head}{rows}</table>",
            escaped(&self.report.file),
            self.base(),
            escaped(&self.report.root_link)
        )
    }
}

/// Derivative of a configuration in tangent directions, (..., nq, nv): of integrate(q, dv) in dv at zero.
#[pyfunction]
pub(crate) fn _integrate_jacobian<'py>(
    model: &Bound<'py, PyModel>,
    q: &Bound<'py, PyAny>,
) -> PyResult<Array<'py>> {
    let this = model.get();
    let (m, nq, nv) = (&*this.model, [this.model.nq()], this.model.nv());
    let one = |x: &[&[f64]], out: &mut [f64]| {
        let q: Vec<Dual64> = x[0].iter().map(|&x| x.into()).collect();
        for j in 0..nv {
            let mut dv = vec![Dual64::from(0.0); nv];
            dv[j].eps = 1.0;
            for (i, x) in m.integrate(&q, &dv).iter().enumerate() {
                out[i * nv + j] = x.eps;
            }
        }
    };
    let work = Work {
        one: &|_, x, out| one(x, out),
        wide: None,
    };
    let arguments = [argument("q", q, &nq)];
    map_rows(
        model.py(),
        (m, this.id),
        &arguments,
        &[nq[0], nv],
        None,
        work,
    )
}

/// Tangent vector of a change of a configuration's coordinates, (..., nv, nq): the derivative of difference(q, q1) in q1 at q.
#[pyfunction]
pub(crate) fn _difference_jacobian<'py>(
    model: &Bound<'py, PyModel>,
    q: &Bound<'py, PyAny>,
) -> PyResult<Array<'py>> {
    let this = model.get();
    let (m, nq, nv) = (&*this.model, [this.model.nq()], this.model.nv());
    let one = |x: &[&[f64]], out: &mut [f64]| {
        let q: Vec<Dual64> = x[0].iter().map(|&x| x.into()).collect();
        for j in 0..nq[0] {
            let mut moved = q.clone();
            moved[j].eps = 1.0;
            for (i, x) in m.difference(&q, &moved).iter().enumerate() {
                out[i * nq[0] + j] = x.eps;
            }
        }
    };
    let work = Work {
        one: &|_, x, out| one(x, out),
        wide: None,
    };
    let arguments = [argument("q", q, &nq)];
    map_rows(
        model.py(),
        (m, this.id),
        &arguments,
        &[nv, nq[0]],
        None,
        work,
    )
}
