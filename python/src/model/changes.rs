//! Changed robots.

use dualbody::Model;
use dualbody::model::Spring;
use dualbody::spatial::Transform;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::build::{joint_of, link_of};
use super::handle::PyModel;
use super::load::by_name;
use super::shapes::{inertia_of, read_pose};
use crate::arrays::read_vector;
use crate::counts::whole;
use crate::errors::{OrRaise, guarded, value_error};

pub(super) fn positions(given: &[(String, Vec<f64>)]) -> Vec<(&str, &[f64])> {
    given
        .iter()
        .map(|(name, x)| (name.as_str(), x.as_slice()))
        .collect()
}

impl PyModel {
    /// The robot with other parameters.
    pub(crate) fn changed<'py>(
        this: &Bound<'py, Self>,
        parameters: &Bound<'py, PyAny>,
    ) -> PyResult<Self> {
        let m = &this.get().model;
        let x = read_vector("parameters", parameters, Some(m.parameters().len()))?;
        let model = guarded(|| m.with_parameters(&x))?;
        Self::edited(this, "with_parameters", (x,), Ok(model))
    }
}

/// The velocity coordinate that an argument means: by its index, or by the name of a joint that has one.
fn coordinate(model: &Model, v: &Bound<'_, PyAny>) -> PyResult<usize> {
    let Ok(name) = v.extract::<String>() else {
        let index: usize = whole("v", v)?;
        return match index < model.nv() {
            true => Ok(index),
            false => Err(value_error(format_args!(
                "v is {index}, and \"{}\" has {} velocity coordinates",
                model.name(),
                model.nv()
            ))),
        };
    };
    let range = model.joint_v(model.find_joint(&name).or_raise()?);
    match range.len() {
        1 => Ok(range.start),
        n => Err(value_error(format_args!(
            "joint \"{name}\" has {n} velocity coordinates: give the index of one, joint_v(\"{name}\") has them"
        ))),
    }
}

#[pymethods]
impl PyModel {
    /// The robot with other parameters.
    fn with_parameters<'py>(
        this: &Bound<'py, Self>,
        parameters: &Bound<'py, PyAny>,
    ) -> PyResult<Self> {
        Self::changed(this, parameters)
    }

    /// The robot with another gravity, m/s².
    pub(super) fn with_gravity<'py>(this: &Bound<'py, Self>, gravity: [f64; 3]) -> PyResult<Self> {
        let model = (*this.get().model).clone();
        let model = guarded(|| model.with_gravity(gravity.into()))?;
        Self::edited(this, "with_gravity", (gravity,), Ok(model))
    }

    /// The robot with another damping, N·m·s/rad or N·s/m, of a joint by its name, or of a velocity coordinate by its index.
    pub(super) fn with_damping<'py>(
        this: &Bound<'py, Self>,
        v: &Bound<'py, PyAny>,
        damping: f64,
    ) -> PyResult<Self> {
        let v = coordinate(&this.get().model, v)?;
        let model = (*this.get().model).clone();
        let model = guarded(|| model.with_damping(v, damping))?;
        Self::edited(this, "with_damping", (v, damping), Ok(model))
    }

    /// The robot with another rotor inertia, kg·m² or kg, of a joint by its name, or of a velocity coordinate by its index.
    pub(super) fn with_armature<'py>(
        this: &Bound<'py, Self>,
        v: &Bound<'py, PyAny>,
        armature: f64,
    ) -> PyResult<Self> {
        let v = coordinate(&this.get().model, v)?;
        let model = (*this.get().model).clone();
        let model = guarded(|| model.with_armature(v, armature))?;
        Self::edited(this, "with_armature", (v, armature), Ok(model))
    }

    /// The robot with another spring, N·m/rad or N/m, at rest at `rest`, of a joint by its name, or of a velocity coordinate by its index.
    #[pyo3(signature = (v, stiffness, rest=0.0))]
    pub(super) fn with_spring<'py>(
        this: &Bound<'py, Self>,
        v: &Bound<'py, PyAny>,
        stiffness: f64,
        rest: f64,
    ) -> PyResult<Self> {
        let v = coordinate(&this.get().model, v)?;
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

    /// The robot with joints locked at positions {name: position}: their links become one body.
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
    pub(super) fn with_kept_joints<'py>(
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

    /// The robot with an additional frame, at a pose (4, 4) in a frame or link.
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

    /// The robot with an additional link (LinkSpec) on a joint (JointSpec).
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
}
