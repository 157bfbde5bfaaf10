//! Robots to description files.
//!
//! Both writers start from [`Model::to_builder`], so fixed links, frames, shapes and edits of the model are kept. Values are written such that they
//! read back exactly.

mod mjcf;
#[cfg(test)]
mod tests;
mod urdf;

use super::names::Names;
use crate::error::WriteError;
use crate::model::{Geometry, LinkSpec, Model, ModelBuilder};
use crate::spatial::{Inertia, Symmetric3};
use nalgebra::Vector3;

/// Name that the joint of the floating base gets in MJCF; it has none here.
pub(super) const FLOATING_BASE: &str = "floating_base";

/// Name of the link that is the world itself.
const WORLD: &str = "world";

impl Model<f64> {
    /// The robot as a URDF file, which [`from_urdf_str`](Self::from_urdf_str) reads back: equal in structure and names,
    /// and in every number up to the rounding of roll, pitch and yaw and of moments about the centre of mass.
    ///
    /// A fixed base is a child of a link `world`. A floating base has no parent, or a link `floating_base` if its frame is not that of its first link
    /// (see [`Base::Floating`](crate::Base::Floating)). Added frames become links without inertia on fixed joints. If a limit is missing, the file
    /// declares version 1.2 of the format. Mimic joints that move independently in the model are written as independent joints.
    ///
    /// # Limitations
    /// A URDF cannot contain gravity, the leader of an independent mimic joint, rotor inertia, springs, and damping that differs between the axes of a
    /// joint: a comment at the top of the file lists the omitted content. Other readers may not support spherical joints and capsules. A universal
    /// joint `j` becomes two revolute joints, `j::axis` and `j::axis2`, with a link without inertia between them.
    ///
    /// # Errors
    /// If a name has a character that XML does not allow, a link has a first moment without mass, or there is a screw joint.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Model, model::samples};
    ///
    /// let cartpole = samples::cartpole();
    /// let again = Model::from_urdf_str(&cartpole.to_urdf()?)?;
    /// assert_eq!(again.joint_names(), cartpole.joint_names());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn to_urdf(&self) -> Result<String, WriteError> {
        let builder = self.to_builder();
        check_texts(&builder, "URDF")?;
        urdf::write(&builder)
    }

    /// The robot as an MJCF file. `MuJoCo` loads it with the dynamics of a simulator with
    /// [`Actuation::from_model`](crate::sim::Actuation::from_model), except for speed limits and the limitations below.
    ///
    /// | model | MJCF |
    /// |---|---|
    /// | links | bodies; a root link `world` that is fixed is the world body |
    /// | revolute, continuous, prismatic, spherical joint | hinge, slide, ball |
    /// | screw joint `j` | hinge `j` and slide `j_advance`, tied by an equality constraint |
    /// | universal joint `j` | hinges `j` and `j_second` |
    /// | planar joint `j` | slides `j_x`, `j_y` and hinge `j_angle` |
    /// | floating base, floating joint on the world | free joint |
    /// | floating joint `j` elsewhere | slides `j_x`, `j_y`, `j_z` and ball `j_rotation` |
    /// | mimic joint | a joint with an equality constraint |
    /// | link without inertia, shapes and frames between two joints | no body: its joint is one of several of the next body |
    /// | frames | sites |
    /// | inertias of links that are fixed to each other | their sum, at the first of them; a separate sum for links without gravity |
    /// | link without gravity | body with `gravcomp` 1 |
    /// | visual shapes | geoms of group 1, which do not collide |
    /// | collision shapes | geoms of group 3 with `contype` 1 and `conaffinity` 0: they touch a ground with default `contype` and `conaffinity`, and not each other |
    /// | STL files of text | their triangles |
    /// | joint of one degree of freedom that is not a mimic joint and whose effort limit is not 0; axis of a universal joint | motor |
    ///
    /// Configurations are equal, except for screw joints, which have their advance (m) as a second coordinate, and free joints, whose position is in the
    /// world. Velocities of planar and floating joints are in the joint frame in `MuJoCo`, in the body frame in this library. Moments of inertia below
    /// the minimum of `MuJoCo` are raised to 10⁻¹² kg·m².
    ///
    /// # Limitations
    /// The file omits speed limits, position limits of zero range, meshes that are not found or whose format `MuJoCo` does not read, and physically
    /// inconsistent inertias of fixed links; comments list them. Flat meshes do not collide. Mesh files have absolute paths. A floating base whose
    /// frame is not that of its first link (see [`Base::Floating`](crate::Base::Floating)) becomes a body `floating_base`.
    ///
    /// # Errors
    /// If `MuJoCo` cannot represent content of the dynamics: a moving body without mass other than such a link, a physically inconsistent sum of
    /// inertias, rotor inertia on a planar or floating joint, different damping of the axes of a joint; or if a name is not allowed.
    ///
    /// # Examples
    /// ```
    /// let mjcf = dualbody::model::samples::cartpole().to_mjcf()?;
    /// assert!(mjcf.contains(r#"<joint name="linear" type="slide""#));
    /// # Ok::<(), dualbody::error::WriteError>(())
    /// ```
    pub fn to_mjcf(&self) -> Result<String, WriteError> {
        let builder = self.to_builder();
        check_texts(&builder, "MJCF")?;
        mjcf::write(self, &builder)
    }
}

/// Mass, centre of mass, and rotational inertia about it.
struct AboutCom {
    mass: f64,
    com: Vector3<f64>,
    moments: Symmetric3<f64>,
}

impl AboutCom {
    /// `None` for a first moment without mass.
    fn of(inertia: &Inertia<f64>) -> Option<Self> {
        let (com, moments) = if inertia.mass != 0.0 {
            (inertia.com(), inertia.about_com())
        } else if inertia.first_moment == Vector3::zeros() {
            (Vector3::zeros(), inertia.rotational)
        } else {
            return None;
        };
        let mass = inertia.mass;
        Some(Self { mass, com, moments })
    }
}

/// XML has no place for control characters, and readers turn line breaks in attributes into spaces.
fn check_texts(builder: &ModelBuilder, format: &'static str) -> Result<(), WriteError> {
    let check = |element: &str, text: &str| {
        let is_bad = |c: char| c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}');
        if !text.chars().any(is_bad) {
            return Ok(());
        }
        Err(WriteError::Unsupported {
            format,
            element: element.into(),
            name: text.into(),
            reason: "the name has control characters".into(),
        })
    };
    check("robot", &builder.name)?;
    for link in &builder.links {
        check("link", &link.name)?;
        shape_texts(link).try_for_each(|text| check("shape", text))?;
    }
    for joint in &builder.joints {
        check("joint", &joint.name)?;
    }
    for frame in &builder.frames {
        check("frame", &frame.name)?;
    }
    Ok(())
}

fn shape_texts(link: &LinkSpec) -> impl Iterator<Item = &str> {
    let visuals = link
        .visuals
        .iter()
        .map(|visual| (&visual.name, &visual.geometry));
    let collisions = link
        .collisions
        .iter()
        .map(|shape| (&shape.name, &shape.geometry));
    visuals.chain(collisions).flat_map(|(name, geometry)| {
        let uri = match geometry {
            Geometry::Mesh { uri, .. } => Some(uri.as_str()),
            _ => None,
        };
        name.as_deref().into_iter().chain(uri)
    })
}
