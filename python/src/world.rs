//! Worlds: robots and objects in one model.

use dualbody::model::{Mass, Object, World};
use dualbody::spatial::{Quaternion, Transform};
use nalgebra::Vector3;
use pyo3::types::PyList;

use crate::prelude::*;

/// Largest distance of a quaternion's norm from one.
const NORM_TOLERANCE: f64 = 1e-6;

/// Robots and objects, each under a name of its own, that become one model.
///
/// >>> import dualbody as db
/// >>> arm, world = db.samples.arm(), db.World("cell")
/// >>> world.add(arm, prefix="left/", position=(-0.4, 0, 0.7))
/// >>> world.add(arm, prefix="right/", position=(0.4, 0, 0.7))
/// >>> world.add_box("table", (1.2, 0.8, 0.1), fixed=True, position=(0, 0, 0.65))
/// >>> world.add_sphere("ball", 0.05, mass=0.2, position=(0, 0, 1))
/// >>> model = world.build()
/// >>> model.nv, db.Simulator(model).nu
/// (20, 14)
///
/// Links, joints and frames of a robot have its prefix; an object is a link and, if it is free, a floating joint of its name. A robot stands or floats as its model
/// does; it floats on a joint "{prefix}floating_base". Such a joint takes no input; its coordinates are the pose relative to the one at which the member was added, so that
/// the neutral configuration has everything where it was put. Members are ordered by name, whatever the order of adding.
#[pyclass(name = "World", module = "dualbody")]
pub(crate) struct PyWorld {
    world: World,
    name: String,
    gravity: Option<[f64; 3]>,
    /// The calls that made each member: its name, a method and its arguments.
    calls: Vec<(String, Py<PyTuple>)>,
}

/// A pose from a position and a quaternion (w, x, y, z).
fn pose_of(position: [f64; 3], quaternion: [f64; 4]) -> PyResult<Transform<f64>> {
    let norm = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
    let is_unit = (norm - 1.0).abs() <= NORM_TOLERANCE;
    if !is_unit {
        refuse!("quaternion is {quaternion:?}, whose norm is {norm}, not 1");
    }
    let rotation = Quaternion::from_slice(&quaternion.map(|x| x / norm)).to_matrix();
    Ok(Transform::new(rotation, Vector3::from(position)))
}

/// Keywords of objects.
#[derive(Default)]
struct Keywords {
    mass: Option<f64>,
    density: Option<f64>,
    fixed: bool,
    has_gravity: Option<bool>,
    position: [f64; 3],
    quaternion: Option<[f64; 4]>,
    on: Option<String>,
    color: Option<[f64; 4]>,
}

fn object_of(given: Option<&Bound<'_, PyDict>>) -> PyResult<Object> {
    let given = given.map_or(Ok(Keywords::default()), |given| {
        read_options!(Keywords, "an object", given; mass, density, fixed, has_gravity, position, quaternion, on, color)
    })?;
    let mass = match (given.mass, given.density) {
        (Some(_), Some(_)) => refuse!("an object has a mass or a density, not both"),
        (mass, density) => mass.map(Mass::Kilograms).or(density.map(Mass::Density)),
    };
    let object = match (given.on, given.fixed, mass) {
        (Some(frame), _, mass) => Object::fixed_to(frame, mass.unwrap_or(Mass::Kilograms(0.0))),
        (None, true, _) => Object::fixed(),
        (None, false, Some(mass)) => Object::free(mass),
        (None, false, None) => {
            refuse!("a free object needs mass= or density=; fixed=True makes one that stands");
        }
    };
    let quaternion = given.quaternion.unwrap_or([1.0, 0.0, 0.0, 0.0]);
    let mut object = object.at(pose_of(given.position, quaternion)?);
    if let Some(color) = given.color {
        object = object.with_color(color);
    }
    match given.has_gravity {
        Some(false) => Ok(object.without_gravity()),
        _ => Ok(object),
    }
}

getters! { PyWorld {
    /// Prefixes of the robots and names of the objects, in their order in the model.
    members: Vec<String> = |own| own.world.members().map(Into::into).collect();
} }

impl PyWorld {
    /// Name, gravity and calls that make it again.
    fn recipe<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let calls = PyList::new(py, self.calls.iter().map(|(_, call)| call.clone_ref(py)))?;
        (&self.name, self.gravity, calls).into_pyobject(py)
    }

    /// Notes the call that made a member.
    fn note<'py>(
        &mut self,
        py: Python<'py>,
        name: &str,
        method: &str,
        arguments: impl IntoPyObject<'py, Target = PyTuple, Output = Bound<'py, PyTuple>, Error = PyErr>,
        object: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<()> {
        let keywords = match object {
            Some(given) => given.copy()?,
            None => PyDict::new(py),
        };
        let call = (method, arguments.into_pyobject(py)?, keywords).into_pyobject(py)?;
        self.calls.push((name.to_owned(), call.unbind()));
        Ok(())
    }
}

#[pymethods]
impl PyWorld {
    /// Removes a robot by its prefix, or an object by its name.
    fn remove(&mut self, member: &str) -> PyResult<()> {
        self.world.remove(member).map(drop).or_raise()?;
        self.calls.retain(|(name, _)| name != member);
        Ok(())
    }

    /// Builds the model.
    fn build(&self, py: Python<'_>) -> PyResult<PyModel> {
        let model = guarded(|| self.world.build())?.or_raise()?;
        Ok(PyModel::new(model, ("_build_world", self.recipe(py)?)))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Recipe<'py> {
        let make = of_package!(py, "_dualbody", "_world");
        Ok((make.clone(), self.recipe(py)?.into_any()))
    }

    fn __repr__(&self) -> String {
        format!("World(\"{}\", {:?})", self.name, self.members())
    }
}

methods! { PyWorld {
    /// An empty world; gravity in m/s², by default (0, 0, -9.81), acts on all members.
    #[new]
    fn new(name: &str = "world", *, gravity: Option<[f64; 3]> = None) -> PyResult<Self> {
        let world = World::new(name);
        Ok(Self {
            world: match gravity {
                Some(gravity) => world.with_gravity(gravity),
                None => world,
            },
            name: name.to_owned(),
            gravity,
            calls: Vec::new(),
        })
    }

    /// Adds a robot with a prefix before all its names, at a pose of its root link in the world; fixed to the frame `on` of another member, if one is given.
    #[pyo3(text_signature = "($self, model, prefix='', position=(0, 0, 0), quaternion=(1, 0, 0, 0), on=None)")]
    fn add(
        &mut self, py: Python, model: &Bound<'py, PyModel>, prefix: &str = "", position: [f64; 3] = [0.0; 3],
        quaternion: [f64; 4] = [1.0, 0.0, 0.0, 0.0], on: Option<&str> = None
    ) -> PyResult<()> {
        let (pose, robot) = (pose_of(position, quaternion)?, &model.get().model);
        let added = guarded(|| match on {
            None => self.world.add(robot, prefix, &pose).map(drop),
            Some(frame) => self.world.add_on(robot, prefix, frame, &pose).map(drop),
        })?;
        added.or_raise()?;
        let arguments = (model, prefix, position, quaternion, on);
        self.note(py, prefix, "add", arguments, None)
    }

    /// Adds an object with the shape of a mesh file; an object with mass needs a closed surface.
    #[pyo3(text_signature = "($self, name, path, scale=(1, 1, 1), **object)")]
    fn add_mesh(&mut self, py: Python, name: &str, path: std::path::PathBuf, scale: [f64; 3] = [1.0; 3], **object) -> PyResult<()> {
        // A pickle may be read in another folder.
        let path = std::path::absolute(&path).unwrap_or(path);
        self.world.add_mesh(name, &path, scale, &object_of(object)?).or_raise()?;
        self.note(py, name, "add_mesh", (name, path.into_os_string(), scale), object)
    }

    /// Adds a box with full edge lengths, m.
    fn add_box(&mut self, py: Python, name: &str, size: [f64; 3], **object) -> PyResult<()> {
        self.world.add_box(name, size, &object_of(object)?).or_raise()?;
        self.note(py, name, "add_box", (name, size), object)
    }

    /// Adds a ball; radius in m.
    fn add_sphere(&mut self, py: Python, name: &str, radius: f64, **object) -> PyResult<()> {
        self.world.add_sphere(name, radius, &object_of(object)?).or_raise()?;
        self.note(py, name, "add_sphere", (name, radius), object)
    }

    /// Adds a cylinder about z; radius and full length in m.
    fn add_cylinder(&mut self, py: Python, name: &str, radius: f64, length: f64, **object) -> PyResult<()> {
        self.world.add_cylinder(name, radius, length, &object_of(object)?).or_raise()?;
        self.note(py, name, "add_cylinder", (name, radius, length), object)
    }

    /// Adds a capsule about z; radius, and length between the half balls, in m.
    fn add_capsule(&mut self, py: Python, name: &str, radius: f64, length: f64, **object) -> PyResult<()> {
        self.world.add_capsule(name, radius, length, &object_of(object)?).or_raise()?;
        self.note(py, name, "add_capsule", (name, radius, length), object)
    }
} }

functions! {
    /// A world from the calls that made it: what a pickled one is made again by.
    fn _world(
        py: Python, name: &str, gravity: Option<[f64; 3]>, calls: Vec<(String, Bound<'py, PyTuple>, Bound<'py, PyDict>)>
    ) -> PyResult<Bound<'py, PyWorld>> {
        let world = Bound::new(py, PyWorld::new(name, gravity)?)?;
        for (method, arguments, keywords) in calls {
            if !method.starts_with("add") {
                return Err(wrong_type!("\"{method}\" adds no member"));
            }
            world.call_method(method.as_str(), arguments, Some(&keywords))?;
        }
        Ok(world)
    }

    /// Builds a world from the calls that made it: what a pickled model is made again by.
    fn _build_world(
        py: Python, name: &str, gravity: Option<[f64; 3]>, calls: Vec<(String, Bound<'py, PyTuple>, Bound<'py, PyDict>)>
    ) -> PyResult<PyModel> {
        _world(py, name, gravity, calls)?.borrow().build(py)
    }

    /// The state (q, v) of one model in another, joint by joint of the same name: a world with other members, say.
    ///
    /// Free bodies keep their pose in the world; joints that `before` does not have are neutral and at rest.
    fn carried_state(py: Python, before: &PyModel, after: &PyModel, q: Vec<f64>, v: Vec<f64>) -> PyResult<[Bound<'py, PyArray1<f64>>; 2]> {
        let state = guarded(|| State::new(&q, &v).carried(&before.model, &after.model))?.or_raise()?;
        Ok([state.q, state.v].map(|x| PyArray1::from_slice(py, x.as_slice())))
    }
}
