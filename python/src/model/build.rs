//! Robots from links, joints and frames.

use dualbody::joint::{JointKind, Pitch};
use dualbody::model::{
    Collision, JointSpec, Limits, LinkSpec, Mimic, Mimicry, ModelBuilder, SecondAxis, Visual,
};

use super::report::base_of;
use super::shapes::{inertia_of, read_geometry, read_pose};
use crate::prelude::*;

pub(super) fn link_of(link: &Bound<'_, PyAny>) -> PyResult<LinkSpec> {
    let name: String = attribute(link, "name")?;
    let mass: f64 = attribute(link, "mass")?;
    let (com, inertia) = (attribute(link, "com")?, attribute(link, "inertia")?);
    let mut spec = LinkSpec::new(name).with_inertia(inertia_of(mass, com, inertia));
    if !attribute::<bool>(link, "gravity")? {
        spec = spec.without_gravity();
    }
    for shape in link.getattr("visuals")?.try_iter()? {
        let shape = shape?;
        spec = spec.with_visual(Visual {
            name: None,
            placement: read_pose("placement", &shape.getattr("placement")?)?,
            geometry: read_geometry(&shape)?,
            color: attribute(&shape, "color")?,
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
        refuse!("pitch is {pitch}: a screw joint needs one, finite and not zero");
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
    let text = |name: &str| -> PyResult<String> { attribute(joint, name) };
    let number = |name: &str| -> PyResult<f64> { attribute(joint, name) };
    let (stiffness, rest) = attribute(joint, "spring")?;
    let mut spec = JointSpec::new(
        text("name")?,
        kind_of(&text("kind")?, number("pitch")?)?,
        text("parent")?,
        text("child")?,
    )
    .with_placement(read_pose("placement", &joint.getattr("placement")?)?)
    .with_axis(attribute(joint, "axis")?)
    .with_limits(limits_of(&joint.getattr("limits")?)?)
    .with_damping(number("damping")?)
    .with_friction(number("friction")?)
    .with_armature(number("armature")?)
    .with_spring(stiffness, rest);
    if let Some((leader, multiplier, offset)) = attribute(joint, "mimic")? {
        spec = spec.with_mimic(Mimic {
            leader,
            multiplier,
            offset,
        });
    }
    if let Some(axis) = attribute::<Option<[f64; 3]>>(joint, "second_axis")? {
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
        let mut builder = ModelBuilder::new(name.clone()).with_gravity(gravity).with_base(base_of(base)?);
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
        let recipe = (name, gravity, base, independent_mimic_joints, links, joints, frames);
        Ok(PyModel::new(model, ("_build_model", recipe.into_pyobject(py)?)))
    }
}
