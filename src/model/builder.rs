//! Builder of models from named links, joints and frames, in any order.

use std::collections::HashMap;
use std::fmt;

use nalgebra::Vector3;

use super::parts::{Base, Collision, Limits, Mimic, SecondAxis, Spring, Visual};
use crate::error::SourcePosition;
use crate::joint::JointKind;
use crate::spatial::{Inertia, Symmetric3, Transform};

/// Default gravity in the world, m/s²: 9.81 downwards along z.
pub const DEFAULT_GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];

/// Description of a link for a [`ModelBuilder`]: name, inertia and shapes, in the frame of the link. [`ModelBuilder::build`] checks the values.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct LinkSpec {
    /// Name of the link.
    pub name: String,
    /// Inertia of the link in its own frame, about the origin.
    pub inertia: Inertia<f64>,
    /// Visual shapes.
    pub visuals: Vec<Visual>,
    /// Collision shapes.
    pub collisions: Vec<Collision>,
    /// A bitmask for each collision shape, in their order; all bits by default. Two shapes collide if their bitmasks have a common bit.
    pub collide_bitmasks: Vec<u16>,
    /// Whether gravity acts on the link.
    pub has_gravity: bool,
}

impl LinkSpec {
    /// Makes a link without inertia and shapes.
    ///
    /// * `name` – unique among links and frames; a root called `world` is the world
    pub fn new(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            inertia: Inertia::zero(),
            visuals: Vec::new(),
            collisions: Vec::new(),
            collide_bitmasks: Vec::new(),
            has_gravity: true,
        }
    }

    /// Switches off gravity for the link: it has inertia but no weight, for a balanced or buoyant part.
    ///
    /// # Examples
    /// ```
    /// use dualbody::dynamics::gravity_forces;
    /// use dualbody::joint::JointKind;
    /// use dualbody::model::{JointSpec, LinkSpec, ModelBuilder};
    ///
    /// let rod = |name: &str, mass: f64| LinkSpec::new(name).with_mass(mass, [0.25, 0.0, 0.0], [0.0, 0.02, 0.02]);
    /// let mut arm = ModelBuilder::new("arm");
    /// arm.add_link(LinkSpec::new("world")).add_link(rod("upper", 1.0)).add_link(rod("lower", 2.0).without_gravity());
    /// let hinge = |name: &str, parent: &str, child: &str| JointSpec::new(name, JointKind::Revolute, parent, child).with_axis([0.0, 1.0, 0.0]);
    /// arm.add_joint(hinge("shoulder", "world", "upper"));
    /// arm.add_joint(hinge("elbow", "upper", "lower").with_translation([0.5, 0.0, 0.0]));
    /// let held = gravity_forces(&arm.build()?, &[0.0, 0.0]);
    /// assert!((held[0] + 9.81 * 0.25).abs() < 1e-12 && held[1].abs() < 1e-12);
    /// # Ok::<(), dualbody::LoadError>(())
    /// ```
    #[must_use]
    pub fn without_gravity(mut self) -> Self {
        self.has_gravity = false;
        self
    }

    /// Sets the inertia in the link frame, about its origin.
    #[must_use]
    pub fn with_inertia(mut self, inertia: Inertia<f64>) -> Self {
        self.inertia = inertia;
        self
    }

    /// Sets mass (kg), centre of mass (m) and diagonal rotational inertia about it (kg·m²), with the axes of the link.
    #[must_use]
    pub fn with_mass(self, mass: f64, com: [f64; 3], diagonal: [f64; 3]) -> Self {
        let about_com = Symmetric3::diagonal(&diagonal.into());
        self.with_inertia(Inertia::from_com(mass, &com.into(), &about_com))
    }

    /// Adds a visual shape, which has no effect on the motion.
    #[must_use]
    pub fn with_visual(mut self, visual: Visual) -> Self {
        self.visuals.push(visual);
        self
    }

    /// Adds a collision shape, see [`Contacts`](crate::contact::Contacts).
    #[must_use]
    pub fn with_collision(mut self, collision: Collision) -> Self {
        self.collisions.push(collision);
        self
    }
}

/// Description of a joint for a [`ModelBuilder`]: kind, the two links, pose in the parent link, axis, limits, and the forces along it.
/// [`ModelBuilder::build`] checks the values.
///
/// # Examples
/// ```
/// use dualbody::{joint::JointKind, model::JointSpec};
///
/// let elbow = JointSpec::new("elbow", JointKind::Revolute, "upper", "lower")
///     .with_translation([0.0, 0.0, -1.0])
///     .with_axis([0.0, 1.0, 0.0])
///     .with_damping(0.1);
/// assert_eq!((elbow.parent.as_str(), elbow.child.as_str(), elbow.damping), ("upper", "lower", 0.1));
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct JointSpec {
    /// Name of the joint.
    pub name: String,
    /// Kind of the joint.
    pub kind: JointKind,
    /// Name of the parent link.
    pub parent: String,
    /// Name of the child link, which the joint moves.
    pub child: String,
    /// Pose of the joint in the parent link; at zero it is the pose of the child link.
    pub placement: Transform<f64>,
    /// Axis of the joint in the frame of the child link, of any length; ignored for kinds without an axis.
    pub axis: Vector3<f64>,
    /// Limits of the joint.
    pub limits: Limits,
    /// Viscous damping of each of its degrees of freedom, N·m·s/rad or N·s/m.
    pub damping: f64,
    /// Coulomb friction of the joint, N·m or N.
    pub friction: f64,
    /// Rotor inertia reflected on each of its degrees of freedom, kg·m² or kg.
    pub armature: f64,
    /// Spring along the joint; stiffness zero for none.
    pub spring: Spring<f64>,
    /// Leader of a mimic joint, with ratio and offset; `None` for independent joints.
    pub mimic: Option<Mimic>,
    /// The second axis of a universal joint.
    pub second: Option<SecondAxis>,
    /// Whether it has no input by default, see [`passive`](Self::passive).
    pub is_passive: bool,
}

impl JointSpec {
    /// Makes a joint at the origin of its parent link, about or along the x axis, without limits, friction, rotor and spring; a universal one
    /// about x and then y.
    ///
    /// * `name` – unique among joints
    /// * `parent`, `child` – names of the links that it connects
    pub fn new(
        name: impl Into<String>,
        kind: JointKind,
        parent: impl Into<String>,
        child: impl Into<String>,
    ) -> Self {
        Self {
            name: name.into(),
            kind,
            parent: parent.into(),
            child: child.into(),
            placement: Transform::identity(),
            axis: Vector3::x(),
            limits: Limits::default(),
            damping: 0.0,
            friction: 0.0,
            armature: 0.0,
            spring: Spring::default(),
            mimic: None,
            second: (kind == JointKind::Universal).then(|| SecondAxis::about([0.0, 1.0, 0.0])),
            is_passive: false,
        }
    }

    /// Sets the pose of the joint (and of the child link at zero) in the parent link.
    #[must_use]
    pub fn with_placement(mut self, placement: Transform<f64>) -> Self {
        self.placement = placement;
        self
    }

    /// Sets the link that the joint moves.
    #[must_use]
    pub(crate) fn with_child(mut self, child: impl Into<String>) -> Self {
        self.child = child.into();
        self
    }

    /// Sets the link that carries the joint.
    #[must_use]
    pub(crate) fn with_parent(mut self, parent: impl Into<String>) -> Self {
        self.parent = parent.into();
        self
    }

    /// Sets the position of the joint in the parent link, m.
    #[must_use]
    pub fn with_translation(self, translation: [f64; 3]) -> Self {
        self.with_placement(Transform::from_translation(translation.into()))
    }

    /// Sets the axis in the joint frame: of rotation, of translation, or normal to the plane. Any length except zero.
    #[must_use]
    pub fn with_axis(mut self, axis: [f64; 3]) -> Self {
        self.axis = axis.into();
        self
    }

    /// Sets the second axis of a universal joint, with its limits and forces.
    #[must_use]
    pub fn with_second_axis(mut self, second: SecondAxis) -> Self {
        self.second = Some(second);
        self
    }

    /// Sets the limits of position (rad, m), velocity (rad/s, m/s) and effort (N·m, N); of a universal joint, those of its first axis.
    #[must_use]
    pub fn with_limits(mut self, limits: Limits) -> Self {
        self.limits = limits;
        self
    }

    /// Sets the viscous damping of every degree of freedom of the joint, N·m·s/rad or N·s/m.
    #[must_use]
    pub fn with_damping(mut self, damping: f64) -> Self {
        self.damping = damping;
        if let Some(second) = &mut self.second {
            second.damping = damping;
        }
        self
    }

    /// Sets the Coulomb friction of the joint, N·m or N; simulators apply it if their [actuation](crate::sim::Actuation) has it. Of a universal
    /// joint, that of its first axis.
    #[must_use]
    pub fn with_friction(mut self, friction: f64) -> Self {
        self.friction = friction;
        self
    }

    /// Sets the rotor inertia that the joint's motor reflects on every degree of freedom, kg·m² or kg.
    #[must_use]
    pub fn with_armature(mut self, armature: f64) -> Self {
        self.armature = armature;
        if let Some(second) = &mut self.second {
            second.armature = armature;
        }
        self
    }

    /// Sets a spring along a joint of one degree of freedom, or along the first axis of a universal joint: stiffness in N·m/rad or N/m, rest position in rad or m.
    #[must_use]
    pub fn with_spring(mut self, stiffness: f64, rest: f64) -> Self {
        self.spring = Spring { stiffness, rest };
        self
    }

    /// Sets the axis, the first one of a universal joint, with what acts along it.
    #[must_use]
    pub(crate) fn along(mut self, axis: SecondAxis) -> Self {
        self.axis = axis.axis;
        self.limits = axis.limits;
        self.damping = axis.damping;
        self.friction = axis.friction;
        self.armature = axis.armature;
        self.spring = axis.spring;
        self
    }

    /// The axis, the first one of a universal joint, with what acts along it.
    pub(crate) fn first_axis(&self) -> SecondAxis {
        SecondAxis {
            axis: self.axis,
            limits: self.limits,
            damping: self.damping,
            friction: self.friction,
            armature: self.armature,
            spring: self.spring,
        }
    }

    /// Makes the joint passive: by default a [`Simulator`](crate::Simulator) gives it no input.
    /// [`Simulator::with_actuated_joints`](crate::Simulator::with_actuated_joints) overrides this.
    #[must_use]
    pub fn passive(mut self) -> Self {
        self.is_passive = true;
        self
    }

    /// Makes the joint a mimic joint; see [`Mimicry`] for its coordinate.
    #[must_use]
    pub fn with_mimic(mut self, mimic: Mimic) -> Self {
        self.mimic = Some(mimic);
        self
    }
}

/// A parameter of one degree of freedom of a joint with several, or of the floating base, which has no named joint.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Override {
    /// The joint; `None` is the floating base.
    pub(super) joint: Option<String>,
    /// The velocity coordinate within the joint.
    pub(super) axis: usize,
    /// Viscous damping, N·m·s/rad or N·s/m.
    pub(super) damping: f64,
    /// Rotor inertia, kg·m² or kg.
    pub(super) armature: f64,
}

/// Collects links, joints and frames, then [builds](Self::build) the model, which checks everything.
///
/// # Examples
/// ```
/// use dualbody::joint::JointKind;
/// use dualbody::model::{JointSpec, LinkSpec, ModelBuilder};
///
/// let mut builder = ModelBuilder::new("slider");
/// builder.add_link(LinkSpec::new("world"));
/// builder.add_link(LinkSpec::new("block").with_mass(2.0, [0.0; 3], [0.1; 3]));
/// builder.add_joint(JointSpec::new("slide", JointKind::Prismatic, "world", "block"));
/// let model = builder.build()?;
/// assert_eq!(model.total_mass(), 2.0);
/// # Ok::<(), dualbody::LoadError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ModelBuilder {
    /// Name of the robot.
    pub name: String,
    /// Source in error messages, for example a path.
    pub source: String,
    pub(super) positions: Positions,
    /// Gravity in the world, m/s²; [`DEFAULT_GRAVITY`] by default.
    pub gravity: Vector3<f64>,
    /// Base of the robot, fixed in the world or floating.
    pub base: Base,
    /// Treatment of mimic joints.
    pub mimicry: Mimicry,
    /// The links, in the order in which they were added.
    pub links: Vec<LinkSpec>,
    /// The joints, in the order in which they were added.
    pub joints: Vec<JointSpec>,
    /// The added frames. Each link is a frame, too, and is not in this list.
    pub frames: Vec<FrameSpec>,
    pub(super) overrides: Vec<Override>,
}

/// Positions of links, joints and frames in their files. They are not
/// compared: a robot is the same from any file.
#[derive(Clone, Default)]
pub(super) struct Positions {
    links_and_frames: HashMap<String, SourcePosition>,
    joints: HashMap<String, SourcePosition>,
}

impl fmt::Debug for Positions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Positions")
    }
}

impl PartialEq for Positions {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// Treatment of mimic joints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mimicry {
    /// Mimic joints move with their leaders and have no coordinates.
    #[default]
    Coupled,
    /// Mimic joints move independently, with their own coordinates.
    Independent,
}

/// A frame to build.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameSpec {
    /// Name of the frame.
    pub name: String,
    /// Name of its link.
    pub link: String,
    /// Pose in the frame of the link, m.
    pub placement: Transform<f64>,
}

impl ModelBuilder {
    /// Makes a builder of an empty robot in [`DEFAULT_GRAVITY`] with [`Base::Auto`].
    pub fn new(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            source: "model builder".into(),
            positions: Positions::default(),
            gravity: DEFAULT_GRAVITY.into(),
            base: Base::Auto,
            mimicry: Mimicry::default(),
            links: Vec::new(),
            joints: Vec::new(),
            frames: Vec::new(),
            overrides: Vec::new(),
        }
    }

    /// Sets the source position of a joint, otherwise of a link or frame, for errors.
    pub(crate) fn set_position(&mut self, is_joint: bool, name: &str, at: SourcePosition) {
        let own = match is_joint {
            true => &mut self.positions.joints,
            false => &mut self.positions.links_and_frames,
        };
        own.entry(name.into()).or_insert(at);
    }

    /// Source position of an element, or of the whole description.
    pub(super) fn position(&self, element: &str, name: &str) -> SourcePosition {
        let own = match element {
            "joint" => &self.positions.joints,
            _ => &self.positions.links_and_frames,
        };
        let whole = || SourcePosition {
            file: self.source.clone(),
            line: 0,
        };
        own.get(name).cloned().unwrap_or_else(whole)
    }

    /// Sets the source in error messages.
    #[must_use]
    pub(crate) fn with_source(mut self, source: impl Into<String>) -> Self {
        self.source = source.into();
        self
    }

    /// Sets the treatment of mimic joints.
    #[must_use]
    pub(crate) fn with_mimicry(mut self, mimicry: Mimicry) -> Self {
        self.mimicry = mimicry;
        self
    }

    /// Sets gravity in the world, m/s²; [`DEFAULT_GRAVITY`] by default.
    #[must_use]
    pub fn with_gravity(mut self, gravity: [f64; 3]) -> Self {
        self.gravity = gravity.into();
        self
    }

    /// Sets the base of the robot: fixed or floating.
    #[must_use]
    pub fn with_base(mut self, base: Base) -> Self {
        self.base = base;
        self
    }

    /// Adds a link; links, joints and frames may come in any order.
    pub fn add_link(&mut self, link: LinkSpec) -> &mut Self {
        self.links.push(link);
        self
    }

    /// Adds a joint; its links may be added later.
    pub fn add_joint(&mut self, joint: JointSpec) -> &mut Self {
        self.joints.push(joint);
        self
    }

    /// Replaces all joints.
    pub(crate) fn set_joints(&mut self, joints: Vec<JointSpec>) {
        self.joints = joints;
    }

    /// Adds a frame at a pose in the frame of a link, which may be added later.
    pub fn add_frame(
        &mut self,
        name: impl Into<String>,
        link: impl Into<String>,
        placement: Transform<f64>,
    ) -> &mut Self {
        self.frames.push(FrameSpec {
            name: name.into(),
            link: link.into(),
            placement,
        });
        self
    }
}
