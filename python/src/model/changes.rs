//! Changed robots.

use dualbody::model::Spring;
use dualbody::spatial::Transform;

use super::build::{joint_of, link_of};
use super::load::by_name;
use super::shapes::{inertia_of, read_pose};
use crate::prelude::*;

pub(super) fn positions(given: &[(String, Vec<f64>)]) -> Vec<(&str, &[f64])> {
    given
        .iter()
        .map(|(name, x)| (name.as_str(), x.as_slice()))
        .collect()
}

/// The velocity coordinate that an argument means: by its index, or by the name of a joint that has one.
fn coordinate(model: &Model, v: &Bound<'_, PyAny>) -> PyResult<usize> {
    let Ok(name) = v.extract::<String>() else {
        let index: usize = whole("v", v)?;
        return match index < model.nv() {
            true => Ok(index),
            false => Err(invalid!(
                "v is {index}, and \"{}\" has {} velocity coordinates",
                model.name(),
                model.nv()
            )),
        };
    };
    let range = model.joint_v(model.find_joint(&name).or_raise()?);
    match range.len() {
        1 => Ok(range.start),
        n => Err(invalid!(
            "joint \"{name}\" has {n} velocity coordinates: give the index of one, joint_v(\"{name}\") has them"
        )),
    }
}

/// Methods that give a changed robot, which is pickled as the first one with the method and its arguments.
macro_rules! edits {
    ($($(#[$attribute:meta])* fn $name:ident($($x:ident: $type:ty),*) = |$model:ident| $changed:expr;)*) => {
        #[pymethods]
        impl PyModel { $(
            $(#[$attribute])*
            pub(crate) fn $name<'py>(this: &Bound<'py, Self>, $($x: $type),*) -> PyResult<Self> {
                let $model = &*this.get().model;
                let changed = guarded(|| -> PyResult<Model> { $changed })??;
                Self::edited(this, stringify!($name), ($($x,)*), changed)
            }
        )* }
    };
}

edits! {
    /// The robot with another gravity, m/s².
    fn with_gravity(gravity: [f64; 3]) = |model| Ok(model.clone().with_gravity(gravity.into()));

    /// The robot with another damping, N·m·s/rad or N·s/m, of a joint by its name, or of a velocity coordinate by its index.
    fn with_damping(v: &Bound<'py, PyAny>, damping: f64) = |model| Ok(model.clone().with_damping(coordinate(model, v)?, damping));

    /// The robot with another rotor inertia, kg·m² or kg, of a joint by its name, or of a velocity coordinate by its index.
    fn with_armature(v: &Bound<'py, PyAny>, armature: f64) = |model| Ok(model.clone().with_armature(coordinate(model, v)?, armature));

    /// The robot with another spring, N·m/rad or N/m, at rest at `rest`, of a joint by its name, or of a velocity coordinate by its index.
    #[pyo3(signature = (v, stiffness, rest=0.0))]
    fn with_spring(v: &Bound<'py, PyAny>, stiffness: f64, rest: f64) = |model| {
        Ok(model.clone().with_spring(coordinate(model, v)?, Spring { stiffness, rest }))
    };

    /// The robot with another mass of a link, kg; its inertia is scaled.
    fn with_link_mass(link: &str, mass: f64) = |model| model.with_link_mass(link, mass).or_raise();

    /// The robot with another inertia of a link: mass (kg), centre of mass in the link frame (m), matrix about it (kg·m²).
    fn with_link_inertia(link: &str, mass: f64, com: [f64; 3], inertia: [[f64; 3]; 3]) = |model| {
        model.with_link_inertia(link, inertia_of(mass, com, inertia)).or_raise()
    };

    /// The robot with joints locked at positions {name: position}: their links become one body.
    fn with_locked_joints(positions: &Bound<'py, PyDict>) = |model| {
        model.with_locked_joints(&self::positions(&by_name(positions)?)).or_raise()
    };

    /// The robot with only some joints; the others are held, at positions {name: position} or neutral.
    #[pyo3(signature = (names, positions=None))]
    fn with_kept_joints(names: Vec<String>, positions: Option<&Bound<'py, PyDict>>) = |model| {
        let given = positions.map_or(Ok(Vec::new()), by_name)?;
        let kept: Vec<&str> = names.iter().map(String::as_str).collect();
        model.with_kept_joints(&kept, &self::positions(&given)).or_raise()
    };

    /// The robot with another one welded to a frame, at a pose (4, 4) in it; the other's names get a prefix.
    #[pyo3(signature = (other, frame, prefix, pose=None))]
    fn with_attached(other: &Bound<'py, PyModel>, frame: &str, prefix: &str, pose: Option<&Bound<'py, PyAny>>) = |model| {
        let at = pose.map_or(Ok(Transform::identity()), |pose| read_pose("pose", pose))?;
        model.with_attached(&other.get().model, frame, prefix, &at).or_raise()
    };

    /// The robot with an additional frame, at a pose (4, 4) in a frame or link.
    fn with_frame(name: &str, parent: &str, pose: &Bound<'py, PyAny>) = |model| {
        model.with_frame(name, parent, &read_pose("pose", pose)?).or_raise()
    };

    /// The robot with an additional link (LinkSpec) on a joint (JointSpec).
    fn with_body(link: &Bound<'py, PyAny>, joint: &Bound<'py, PyAny>) = |model| {
        model.with_body(link_of(link)?, joint_of(joint)?).or_raise()
    };

    /// The robot with all lengths and densities multiplied.
    fn scaled(length: f64, density: f64) = |model| model.scaled(length, density).or_raise();
}

methods! { PyModel {
    /// The robot with other parameters.
    fn with_parameters(this: &Bound<'py, Self>, parameters) -> PyResult<Self> {
        let m = &this.get().model;
        let x = read_vector("parameters", parameters, Some(m.parameters().len()))?;
        let model = guarded(|| m.with_parameters(&x))?;
        Self::edited(this, "with_parameters", (x,), model)
    }
} }
