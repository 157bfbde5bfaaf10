//! The robot: an immutable tree of bodies over model data `P`.
//!
//! A [`Model`] lists its moving bodies in depth-first order: parents come before children and each subtree is contiguous. Links that are fixed to
//! each other form one body; each link keeps a frame with its name. Models are built as `Model<f64>`, by [`ModelBuilder`] or from a file;
//! [`Model::cast`] gives the same robot over another scalar, differentiable in its parameters.
//!
//! With n the number of bodies or links:
//!
//! | question | function | cost | reference |
//! |---|---|---|---|
//! | build a robot in code? | [`ModelBuilder`], [`LinkSpec`], [`JointSpec`] | O(n) | |
//! | small example robots? | [`samples`] | O(n) | |
//! | several robots and objects in one model? | [`World`], [`Object`] | O(n) | |
//! | coordinates of a joint in q and v? | [`Model::find_joint`], then [`Model::joint_q`], [`Model::joint_v`] | O(n) by name, then O(1) | |
//! | a frame by name? | [`Model::find_frame`] | O(n) | |
//! | motion, difference and interpolation of configurations? | [`Model::integrate`], [`Model::difference`], [`Model::interpolate`] | O(n) | [Murray, Li, Sastry 1994, chapter 2] |
//! | a random configuration or velocity? | [`Model::random_configuration`], [`Model::random_velocity`] | O(n) | [Shoemake 1992] |
//! | parameters of the dynamics? | [`Model::parameters`], [`Model::parameter_layout`] | O(n) | |
//! | the robot with other parameters, or over another scalar? | [`Model::with_parameters`], [`Model::with_some_parameters`], [`Model::cast`] | O(n) | |
//! | locked joints, attached parts, another scale or mass? | [`Model::with_locked_joints`], [`Model::with_attached`], [`Model::scaled`], [`Model::with_link_mass`] | O(n), built anew | |
//! | lengths, radii and densities of links as design parameters? | [`Hardware`] | O(n), built anew | |
//! | mass, centre of mass, inertia of a link? | [`Model::link_inertia`], [`Model::link_inertias`] | O(n) | |
//! | derivatives of ⊕ and ⊖ in the entries of q? | [`Model::integrate_jacobian`], [`Model::difference_jacobian`] | O(nv · nq) | |
//! | are the inertias physically consistent? | [`Model::inertia_flaws`] | O(1) each | [Wensing, Kim, Slotine 2018] |
//! | is the mass matrix regular? | [`Model::check_mass_matrix`] | O(n) if all bodies are solid, otherwise up to O(nv³) | |
//! | the tree as text? | [`Model::tree`] | O(n) | |
//! | the description of a model? | [`Model::to_builder`] | O(n) | |
//! | a hash of a robot? | [`Model::fingerprint`] | O(n) | |

mod assembly;
mod axes;
mod body;
mod builder;
mod checks;
mod consistency;
mod coordinates;
mod description;
mod equality;
pub(crate) mod fingerprint;
mod generation;
mod graph;
mod hardware;
mod ids;
mod link_inertias;
pub(crate) mod manifold;
mod manifold_jacobians;
mod names;
mod numbers;
mod operations;
mod parameter_derivatives;
mod parameters;
mod parts;
pub mod samples;
mod scalars;
mod sizes;
mod solids;
mod structure;
mod tree;
mod up_axis;
pub(crate) mod walk;
mod weightless;
mod world;

use std::ops::Range;
use std::sync::Arc;

use nalgebra::Vector3;

pub(crate) use axes::unit;
pub use body::{Body, Coupling};
pub use builder::{DEFAULT_GRAVITY, FrameSpec, JointSpec, LinkSpec, Mimicry, ModelBuilder};
pub use consistency::InertiaFlaw;
pub(crate) use consistency::inertia_flaw;
pub(crate) use generation::Generation;
pub(crate) use graph::WORLD;
pub(crate) use hardware::Stretch;
pub use hardware::{Dimension, Hardware, LinkShape, MassDistribution, MeshSolids, ScaledLink};
pub use ids::{BodyId, FrameId, JointId};
#[cfg(feature = "identification")]
pub(crate) use names::FLOATING_BASE;
pub(crate) use names::numbered;
pub use parameters::{ParameterGroup, ParameterLayout};
pub(crate) use parts::JointPart;
pub(crate) use parts::short_reference;
pub use parts::{
    Base, Collision, Frame, Geometry, Joint, Limits, Link, Mimic, SecondAxis, Spring, Visual,
};
pub use solids::Mass;
pub(crate) use structure::Structure;
pub use tree::ModelTree;
pub use up_axis::UpAxis;
pub(crate) use weightless::Weightless;
pub(crate) use world::BASE_JOINT;
pub use world::{Object, World};

use crate::error::UnknownName;
use crate::nested::IntoNested;
use crate::numbers::{Domain, Numbers as _};
use crate::scalar::Scalar;
use crate::spatial::{Inertia, Transform};

/// A robot. See the [module](self).
///
/// # Examples
/// ```
/// use dualbody::model::samples;
///
/// let model = samples::cartpole();
/// assert_eq!((model.nq(), model.nv()), (2, 2));
/// assert_eq!(model.joint_names(), ["linear", "pivot"]);
/// ```
#[derive(Clone, Debug)]
pub struct Model<P = f64> {
    name: String,
    gravity: Vector3<P>,
    bodies: Vec<Body<P>>,
    /// Parts of bodies that gravity does not act on.
    weightless: Vec<Weightless<P>>,
    frames: Vec<Frame<P>>,
    damping: Vec<P>,
    armature: Vec<P>,
    springs: Vec<Spring<P>>,
    joints: Vec<Joint>,
    links: Vec<Link>,
    nq: usize,
    /// See [`structure`](Self::structure).
    structure: Structure,
    generation: Generation,
    /// Description that the model was built from; see [`to_builder`](Self::to_builder).
    description: Arc<ModelBuilder>,
    /// See [`remarks`](Self::remarks).
    remarks: Arc<[String]>,
}

impl<P: Scalar> Model<P> {
    /// Name of the robot.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Remarks from loading the file, one sentence each: the base and its reason, limits that act only in some simulators, ambiguous content, and
    /// content that the model does not use. Empty for robots that are built in code.
    ///
    /// They are the lines of the `ImportReport` that `ModelOptions` returns with a model.
    ///
    /// # Examples
    /// ```
    /// use dualbody::Model;
    ///
    /// let arm = Model::from_urdf_str(r#"<robot name="arm"><link name="world"/><gazebo><static>true</static></gazebo></robot>"#)?;
    /// assert!(arm.remarks().iter().any(|line| line.contains("settings of another simulator")));
    /// # Ok::<(), dualbody::LoadError>(())
    /// ```
    pub fn remarks(&self) -> &[String] {
        &self.remarks
    }

    /// Sets the remarks of a reader.
    #[cfg(feature = "formats")]
    pub(crate) fn with_remarks(mut self, remarks: Vec<String>) -> Self {
        self.remarks = remarks.into();
        self
    }

    /// Number of configuration coordinates, length of q.
    #[inline]
    pub fn nq(&self) -> usize {
        self.nq
    }

    /// Number of velocity coordinates: degrees of freedom, length of v, a and τ.
    #[inline]
    pub fn nv(&self) -> usize {
        self.damping.len()
    }

    /// Number of moving bodies, without the world and links fixed to it.
    #[inline]
    pub fn n_bodies(&self) -> usize {
        self.bodies.len()
    }

    /// Number of named joints, without the joint of a floating base and fixed joints.
    pub fn n_joints(&self) -> usize {
        self.joints.len()
    }

    /// The moving bodies in depth-first order.
    #[inline]
    pub fn bodies(&self) -> &[Body<P>] {
        &self.bodies
    }

    /// The generation of the bodies' numbers.
    pub(crate) fn generation(&self) -> Generation {
        self.generation
    }

    /// Refuses working memory that was made for other numbers.
    #[inline]
    pub(crate) fn assert_generation(&self, of_scratch: Generation) {
        assert!(
            of_scratch == self.generation,
            "the scratch belongs to another model than \"{}\", or to this one before a change",
            self.name
        );
    }

    /// A moving body.
    ///
    /// # Panics
    /// If the id is not one of this model.
    #[inline]
    pub fn body(&self, id: BodyId) -> &Body<P> {
        let found = self.bodies.get(id.0);
        found.unwrap_or_else(|| self.no_such("body", id.0, self.bodies.len()))
    }

    /// The frame of an id.
    ///
    /// # Panics
    /// If the id is not one of this model.
    #[inline]
    pub(crate) fn frame_of(&self, id: FrameId) -> &Frame<P> {
        let found = self.frames.get(id.0);
        found.unwrap_or_else(|| self.no_such("frame", id.0, self.frames.len()))
    }

    fn joint_of(&self, id: JointId) -> &Joint {
        let found = self.joints.get(id.0);
        found.unwrap_or_else(|| self.no_such("joint", id.0, self.joints.len()))
    }

    #[cold]
    fn no_such(&self, element: &str, id: usize, count: usize) -> ! {
        let name = &self.name;
        panic!("\"{name}\" has no {element} {id}: it has {count}, counted from 0");
    }

    /// # Panics
    /// If there is no such velocity coordinate.
    fn check_coordinate(&self, v: usize) {
        if v >= self.nv() {
            self.no_such("velocity coordinate", v, self.nv());
        }
    }

    /// The links of the description, in the order of the tree.
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// The named joints, in the order of their coordinates.
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// Frames of the robot: links first, then those that were added.
    pub fn frames(&self) -> &[Frame<P>] {
        &self.frames
    }

    /// Gravity in the world, m/s².
    #[inline]
    pub fn gravity(&self) -> &Vector3<P> {
        &self.gravity
    }

    /// Viscous damping of each velocity coordinate, N·m·s/rad or N·s/m; length `nv`.
    pub fn damping(&self) -> &[P] {
        &self.damping
    }

    /// Rotor inertia reflected on each velocity coordinate, kg·m² or kg; length `nv`.
    #[inline]
    pub fn armature(&self) -> &[P] {
        &self.armature
    }

    /// The spring along each velocity coordinate; length `nv`. Only joints of one degree of freedom can have one.
    pub fn springs(&self) -> &[Spring<P>] {
        &self.springs
    }

    /// `true` if some joint follows another one.
    #[inline]
    pub(crate) fn has_coupling(&self) -> bool {
        self.bodies.iter().any(|body| body.coupling.is_some())
    }

    /// `true` if the first body is a floating base: q starts with (position, quaternion), v with its body velocity.
    pub fn has_floating_base(&self) -> bool {
        self.joints
            .first()
            .map_or(!self.bodies.is_empty(), |first| first.bodies().start != 0)
    }

    /// Mass of all moving bodies, kg, without links fixed to the world.
    pub fn total_mass(&self) -> P {
        self.bodies
            .iter()
            .fold(P::zero(), |sum, body| sum + body.inertia.mass)
    }

    /// Names of the joints, in the order of their coordinates.
    pub fn joint_names(&self) -> Vec<&str> {
        self.joints
            .iter()
            .map(|joint| joint.name.as_str())
            .collect()
    }

    /// Names of the links, in the order of [`links`](Self::links).
    pub fn link_names(&self) -> Vec<&str> {
        self.links
            .iter()
            .map(|link| self.frames[link.frame.0].name.as_str())
            .collect()
    }

    /// Frames of the links, in the order of [`links`](Self::links).
    pub fn link_frames(&self) -> Vec<FrameId> {
        self.links.iter().map(|link| link.frame).collect()
    }

    /// Names of all frames: those of the links, then the others.
    pub fn frame_names(&self) -> Vec<&str> {
        self.frames
            .iter()
            .map(|frame| frame.name.as_str())
            .collect()
    }

    /// Finds a joint by name; `None` if it does not exist, and for fixed joints, which are part of a body.
    pub fn joint(&self, name: &str) -> Option<JointId> {
        self.joints
            .iter()
            .position(|joint| joint.name == name)
            .map(JointId)
    }

    /// Finds a frame or link by name; `None` if it does not exist.
    pub fn frame(&self, name: &str) -> Option<FrameId> {
        self.frames
            .iter()
            .position(|frame| frame.name == name)
            .map(FrameId)
    }

    /// Finds a joint by name; the error lists the existing names.
    ///
    /// # Errors
    /// If there is no such joint.
    pub fn find_joint(&self, name: &str) -> Result<JointId, UnknownName> {
        self.joint(name).ok_or_else(|| UnknownName {
            model: self.name.clone(),
            element: "joint".into(),
            name: name.into(),
            known: self.joint_names().into_iter().map(Into::into).collect(),
        })
    }

    /// Finds a frame or link by name; the error lists the existing names.
    ///
    /// # Errors
    /// If there is no such frame.
    pub fn find_frame(&self, name: &str) -> Result<FrameId, UnknownName> {
        self.frame(name).ok_or_else(|| UnknownName {
            model: self.name.clone(),
            element: "frame".into(),
            name: name.into(),
            known: self.frame_names().into_iter().map(Into::into).collect(),
        })
    }

    /// The frame of the first link on a body. (The body frame itself has no name.) For the first body of a universal joint, which has no link, it is
    /// the frame of the cross.
    ///
    /// # Panics
    /// If the id is not one of this model.
    pub fn body_frame(&self, body: BodyId) -> FrameId {
        let links = self.links.iter().map(|link| link.frame);
        let others = (self.links.len()..self.frames.len()).map(FrameId);
        let first = links
            .chain(others)
            .find(|link| self.frames[link.0].body == Some(body));
        first.unwrap_or_else(|| self.no_such("body", body.0, self.bodies.len()))
    }

    /// The name of the first link on a body.
    ///
    /// # Panics
    /// If the id is not one of this model.
    pub fn body_name(&self, body: BodyId) -> &str {
        &self.frames[self.body_frame(body).0].name
    }

    /// The body that a joint moves.
    ///
    /// # Panics
    /// If the id is not one of this model.
    pub fn joint_body(&self, joint: JointId) -> BodyId {
        self.joint_of(joint).body
    }

    /// The bodies of a joint: two for a universal joint, the outer one last, otherwise one.
    ///
    /// # Panics
    /// If the id is not one of this model.
    pub(crate) fn joint_bodies(&self, joint: JointId) -> impl Iterator<Item = BodyId> + use<P> {
        self.joint_of(joint).bodies().map(BodyId)
    }

    /// The named joint that moves a body; `None` for a floating base.
    pub fn body_joint(&self, body: BodyId) -> Option<JointId> {
        let place = self.joints.partition_point(|joint| joint.body < body);
        let joint = self.joints.get(place)?;
        joint.bodies().contains(&body.0).then_some(JointId(place))
    }

    /// Every body of a named joint, in the order of the tree.
    pub(crate) fn joint_parts(&self) -> impl Iterator<Item = JointPart<'_>> {
        self.joints.iter().zip(0..).nested(|(joint, id)| {
            let id = JointId(id);
            joint.bodies().enumerate().map(move |(k, body)| {
                let second = joint.second.as_ref().filter(|_| k > 0);
                JointPart {
                    id,
                    body: BodyId(body),
                    limits: second.map_or(&joint.limits, |second| &second.limits),
                    friction: second.map_or(joint.friction, |second| second.friction),
                }
            })
        })
    }

    /// Indices of a joint's coordinates in q; a mimic joint has those of its leader.
    ///
    /// # Panics
    /// If the id is not one of this model.
    pub fn joint_q(&self, joint: JointId) -> Range<usize> {
        let bodies = &self.bodies[self.joint_of(joint).bodies()];
        bodies[0].q..bodies[0].q + bodies.iter().map(|body| body.joint.nq()).sum::<usize>()
    }

    /// Indices of a joint's coordinates in v, τ and all tangent vectors; a mimic joint has those of its leader.
    ///
    /// # Panics
    /// If the id is not one of this model.
    pub fn joint_v(&self, joint: JointId) -> Range<usize> {
        let bodies = &self.bodies[self.joint_of(joint).bodies()];
        bodies[0].v..bodies[0].v + bodies.iter().map(|body| body.joint.nv()).sum::<usize>()
    }

    /// Limits of a joint; of a universal joint, those of its first axis ([`Joint::second`] has the others).
    ///
    /// # Panics
    /// If the id is not one of this model.
    pub fn limits(&self, joint: JointId) -> &Limits {
        &self.joint_of(joint).limits
    }

    /// Returns the robot with another inertia of one body (in the body frame), the sum over its links.
    ///
    /// # Panics
    /// If the id is not one of this model, an entry is not finite, or the mass is negative.
    #[must_use]
    pub fn with_inertia(mut self, body: BodyId, inertia: Inertia<P>) -> Self {
        self.body(body);
        inertia.check_numbers();
        self.bodies[body.0].inertia = inertia;
        self.generation = Generation::next();
        self
    }

    /// Returns the robot with another pose `X_PJ` of one joint in the parent body (both with their body axes).
    ///
    /// # Panics
    /// If the id is not one of this model, or is its floating base or the second body of a universal joint, which have no placement. If an entry is not finite.
    #[must_use]
    pub fn with_placement(mut self, body: BodyId, placement: Transform<P>) -> Self {
        self.body(body);
        for &x in placement.rotation.iter().chain(&placement.translation) {
            Domain::Finite.check("number of a placement", x);
        }
        let joint = self.body_joint(body).map(|joint| self.joint_of(joint));
        let Some(joint) = joint else {
            panic!("the floating base of \"{}\" is not placed", self.name);
        };
        assert!(
            joint.bodies().start == body.0,
            "the second body of joint \"{}\" of \"{}\" is not placed: its first axis leads it",
            joint.name,
            self.name
        );
        self.bodies[body.0].placement = placement;
        self.generation = Generation::next();
        self
    }

    /// Returns the robot with another gravity, m/s².
    ///
    /// # Panics
    /// If an entry is not finite.
    #[must_use]
    pub fn with_gravity(mut self, gravity: Vector3<P>) -> Self {
        for &x in &gravity {
            Domain::Finite.check("gravity", x);
        }
        self.gravity = gravity;
        self
    }

    /// Returns the robot with another viscous damping of one velocity coordinate, N·m·s/rad or N·s/m.
    ///
    /// * `v` – index of the coordinate in [`damping`](Self::damping); [`joint_v`](Self::joint_v) gives those of a joint
    ///
    /// # Panics
    /// If there is no such coordinate, or the damping is negative or not finite.
    #[must_use]
    pub fn with_damping(mut self, v: usize, damping: P) -> Self {
        self.check_coordinate(v);
        Domain::NotNegative.check("damping", damping);
        self.damping[v] = damping;
        self
    }

    /// Returns the robot with another rotor inertia on one velocity coordinate, kg·m² or kg.
    ///
    /// * `v` – index of the coordinate in [`armature`](Self::armature); [`joint_v`](Self::joint_v) gives those of a joint
    ///
    /// # Panics
    /// If there is no such coordinate, or the armature is negative or not finite.
    #[must_use]
    pub fn with_armature(mut self, v: usize, armature: P) -> Self {
        self.check_coordinate(v);
        Domain::NotNegative.check("armature", armature);
        self.armature[v] = armature;
        self.generation = Generation::next();
        self
    }

    /// Returns the robot with another spring along one velocity coordinate: stiffness in N·m/rad or N/m, rest position in rad or m.
    ///
    /// * `v` – index of the coordinate in [`springs`](Self::springs); [`joint_v`](Self::joint_v) gives that of a joint
    ///
    /// # Panics
    /// If there is no such coordinate, or if it belongs to a joint of several degrees of freedom; if the stiffness is negative or not finite,
    /// or the rest position is not finite.
    #[must_use]
    pub fn with_spring(mut self, v: usize, spring: Spring<P>) -> Self {
        self.check_coordinate(v);
        spring.check_numbers();
        let single = |body: &Body<P>| body.v == v && body.joint.nv() == 1;
        assert!(
            self.bodies.iter().any(single),
            "coordinate {v} is not that of a joint of one degree of freedom"
        );
        self.springs[v] = spring;
        self
    }
}
