//! Robots from links, joints and frames.

use dualbody::joint::{JointKind, Pitch};
use dualbody::model::{
    Collision, JointSpec, Limits, LinkSpec, Mimic, Mimicry, ModelBuilder, SecondAxis, Visual,
};
use pyo3::prelude::*;

use super::base::base_of;
use super::handle::PyModel;
use super::shapes::{inertia_of, read_geometry, read_pose};
use crate::errors::{OrRaise, choice, guarded, value_error};
use crate::python::functions;

pub(super) fn link_of(link: &Bound<'_, PyAny>) -> PyResult<LinkSpec> {
    let name: String = link.getattr("name")?.extract()?;
    let mass: f64 = link.getattr("mass")?.extract()?;
    let (com, inertia) = (
        link.getattr("com")?.extract()?,
        link.getattr("inertia")?.extract()?,
    );
    let mut spec = LinkSpec::new(name).with_inertia(inertia_of(mass, com, inertia));
    if !link.getattr("gravity")?.extract::<bool>()? {
        spec = spec.without_gravity();
    }
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

/// Kind of a joint; `pitch` is that of a screw joint, m/rad.
fn kind_of(name: &str, pitch: f64) -> PyResult<JointKind> {
    if name == "screw" && !(pitch.is_finite() && pitch != 0.0) {
        return Err(value_error(format_args!(
            "pitch is {pitch}: a screw joint needs one, finite and not zero"
        )));
    }
    let choices = [
        ("fixed", JointKind::Fixed),
        ("revolute", JointKind::Revolute),
        ("continuous", JointKind::Continuous),
        ("prismatic", JointKind::Prismatic),
        ("screw", JointKind::Screw(Pitch::per_radian(pitch))),
        ("universal", JointKind::Universal),
        ("spherical", JointKind::Spherical),
        ("planar", JointKind::Planar),
        ("floating", JointKind::Floating),
    ];
    choice("kind", name, &choices)
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

pub(super) fn joint_of(joint: &Bound<'_, PyAny>) -> PyResult<JointSpec> {
    let text = |name: &str| -> PyResult<String> { joint.getattr(name)?.extract() };
    let number = |name: &str| -> PyResult<f64> { joint.getattr(name)?.extract() };
    let (stiffness, rest) = joint.getattr("spring")?.extract()?;
    let mut spec = JointSpec::new(
        text("name")?,
        kind_of(&text("kind")?, number("pitch")?)?,
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

functions! {
    /// Builds a robot from links, joints and frames.
    fn _build_model(
        py: Python, name: String, gravity: [f64; 3], base: &str, independent_mimic_joints: bool, links: Vec<Bound<'py, PyAny>>,
        joints: Vec<Bound<'py, PyAny>>, frames: Vec<(String, String, Bound<'py, PyAny>)>
    ) -> PyResult<PyModel> {
        let mimicry = match independent_mimic_joints {
            true => Mimicry::Independent,
            false => Mimicry::Coupled,
        };
        let mut builder = ModelBuilder::new(name.clone())
            .with_gravity(gravity)
            .with_base(base_of(base)?);
        builder.mimicry = mimicry;
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
}
