//! The parameters of the dynamics of a robot as one vector.
//!
//! | group | parameters | unit |
//! |---|---|---|
//! | inertia of each body | m, hx, hy, hz, Jxx, Jxy, Jyy, Jxz, Jyz, Jzz, see [`Inertia::to_parameters`] | kg, kg·m, kg·m² |
//! | placement of each named joint | translation x, y, z, then rotation x, y, z | m, rad |
//! | gravity | x, y, z in the world | m/s² |
//! | damping, armature | one per velocity coordinate | N·m·s/rad, kg·m²; or N·s/m, kg |
//! | spring of each joint with one coordinate | stiffness, rest position | N·m/rad, rad; or N/m, m |
//! | coupling of each mimic joint | ratio, offset | 1, rad/m or m/rad; rad or m |
//! | placement of each frame on its body | translation x, y, z, then rotation x, y, z | m, rad |
//!
//! Placements are increments: the pose of a joint is `X_PJ` (p, exp(φ)), the pose `X_PJ` of the model moved by p and rotated by φ, both along the
//! axes of the joint (z is the axis of its motion). Frames are moved likewise, along their own axes. So zero is the unchanged robot, the derivative
//! at zero is that in calibration errors, and no parameter is redundant, unlike the entries of a rotation matrix.
//!
//! Ratio and offset of a mimic joint define its motion only. Its share of damping, armature and spring is part of the parameters of its leader, and
//! does not change with its ratio.

use std::fmt::Display;
use std::ops::Range;

use nalgebra::{DVector, Vector3};

use super::{BodyId, FrameId, Generation, JointId, Model};
use crate::error::UnknownName;
use crate::numbers::{Domain, Each, EachIn, Number, Numbers as _, each_named, is_finite, of};
use crate::scalar::{Over, Scalar};
use crate::spatial::{Quaternion, SPATIAL, Transform};

/// A group of parameters; see [the table](Model::parameters).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ParameterGroup {
    /// The ten standard inertial parameters of a body.
    Inertia(BodyId),
    /// The increment of the pose of a named joint: translation, then rotation.
    Placement(JointId),
    /// Gravity in the world.
    Gravity,
    /// Damping along all velocity coordinates.
    Damping,
    /// Rotor inertia on all velocity coordinates.
    Armature,
    /// Stiffness and rest position of the spring along a joint with one coordinate.
    Spring(JointId),
    /// Ratio and offset of a mimic joint.
    Coupling(JointId),
    /// The increment of the pose of a frame or link on its body (or the world): translation, then rotation.
    Frame(FrameId),
}

use ParameterGroup as Group;

/// Layout of a parameter vector: index, name and group of each parameter ([`ParameterGroup`] for those of a model).
#[derive(Clone, Debug)]
pub struct ParameterLayout<G = ParameterGroup> {
    model: String,
    names: Vec<String>,
    /// Values that each number may have.
    domains: Vec<Domain>,
    groups: Vec<(G, Range<usize>)>,
}

impl<G: Copy + PartialEq> ParameterLayout<G> {
    pub(crate) fn new(model: &str) -> Self {
        Self {
            model: model.to_owned(),
            names: Vec::new(),
            domains: Vec::new(),
            groups: Vec::new(),
        }
    }

    /// Appends a number, to the last group if that is its own.
    pub(crate) fn push(&mut self, group: G, name: String, domain: Domain) {
        let k = self.len();
        match self.groups.last_mut() {
            Some((last, range)) if *last == group => range.end = k + 1,
            _ => self.groups.push((group, k..k + 1)),
        }
        self.names.push(name);
        self.domains.push(domain);
    }

    /// The layout with the groups renamed.
    pub(crate) fn regrouped<H>(self, to: impl Fn(G) -> H) -> ParameterLayout<H> {
        let groups = self.groups.into_iter();
        ParameterLayout {
            model: self.model,
            names: self.names,
            domains: self.domains,
            groups: groups.map(|(group, range)| (to(group), range)).collect(),
        }
    }

    /// Number of parameters, over all groups.
    pub(crate) fn len(&self) -> usize {
        self.names.len()
    }

    /// Name of each parameter: its link, joint or world, and the quantity, as in `forearm: mass`, `elbow: damping`, `world: gravity z`; several of
    /// one kind are numbered, as in `ball: damping 2`.
    ///
    /// The name of a body is that of its first link; the joint of a floating base, which has no name, is `floating base`.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    #[cfg(feature = "identification")]
    pub(crate) fn domains(&self) -> &[Domain] {
        &self.domains
    }

    /// Groups with their ranges of indices, in the order of the vector.
    pub fn groups(&self) -> &[(G, Range<usize>)] {
        &self.groups
    }

    /// Range of indices of a group; `None` if the model does not have it.
    pub fn range(&self, group: G) -> Option<Range<usize>> {
        let found = self.groups.iter().find(|(own, _)| *own == group);
        found.map(|(_, range)| range.clone())
    }

    /// Index of the parameter with a name.
    ///
    /// # Errors
    /// If there is no parameter with this name.
    pub fn find(&self, name: &str) -> Result<usize, UnknownName> {
        let found = self.names.iter().position(|own| own == name);
        found.ok_or_else(|| UnknownName {
            model: self.model.clone(),
            element: "parameter".into(),
            name: name.into(),
            known: self.names.clone(),
        })
    }
}

impl ParameterLayout {
    /// Range of indices of the inertial parameters of all bodies, in which forces and energies are linear.
    pub fn inertial(&self) -> Range<usize> {
        let is_inertia = |group: &ParameterGroup| matches!(group, ParameterGroup::Inertia(_));
        let inertias = self.groups.iter().filter(|(group, _)| is_inertia(group));
        0..inertias.map(|(_, range)| range.end).max().unwrap_or(0)
    }
}

impl<P: Scalar> Model<P> {
    /// Returns all parameters of the dynamics: inertias (kg, kg·m, kg·m², in the body frame), placements of joints (m, rad; zero, as they are
    /// increments), gravity (m/s²), damping, armature, springs, ratios and offsets of mimic joints, placements of frames; see [`ParameterLayout`] for
    /// the position of each. Allocates.
    ///
    /// [`Simulator::parameters`](crate::Simulator::parameters) adds limits, friction and contact.
    ///
    /// # Examples
    /// ```
    /// use dualbody::model::samples;
    ///
    /// let model = samples::cartpole();
    /// let mass = model.parameter_layout().find("pole: mass")?;
    /// assert_eq!(model.parameters()[mass], 0.5);
    /// # Ok::<(), dualbody::UnknownName>(())
    /// ```
    pub fn parameters(&self) -> DVector<P> {
        let mut all = Vec::new();
        self.clone().each_number(&mut |_, _, x| all.push(*x));
        DVector::from_vec(all)
    }

    /// Returns the robot with other parameters, over their scalar. Over dual numbers this gives derivatives in all parameters.
    ///
    /// Placements are relative to those of this model; with `self.parameters()` the robot is unchanged.
    ///
    /// Negative masses, damping, rotor inertias and stiffnesses are accepted, because finite differences step below zero, the value of damping and
    /// rotor inertia of many robots. Check the result of an optimisation or identification for [inconsistent inertias](Model::inertia_flaws), or
    /// prevent them by [`Inertia::from_log_cholesky`](crate::spatial::Inertia::from_log_cholesky).
    ///
    /// # Panics
    /// If the length differs from that of [`parameters`](Self::parameters), or a value is not finite; the message names it.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Model, Scalar, autodiff, dynamics, model::samples};
    ///
    /// /// The torque that holds a horizontal rod, m g c, as a function of all parameters of the robot.
    /// struct Holding(Model);
    /// impl autodiff::VectorFunction for Holding {
    ///     fn n_outputs(&self) -> usize {
    ///         1
    ///     }
    ///     fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
    ///         let q = T::constant(std::f64::consts::FRAC_PI_2);
    ///         y[0] = dynamics::gravity_forces(&self.0.with_parameters(x), &[q])[0];
    ///     }
    /// }
    /// let model = samples::pendulum();
    /// let gravity = model.parameter_layout().find("world: gravity z").unwrap();
    /// let slope = autodiff::gradient(&Holding(model.clone()), model.parameters().as_slice());
    /// assert!((slope[gravity] + 0.5).abs() < 1e-15);
    /// ```
    pub fn with_parameters<Q: Over<P>>(&self, parameters: &[Q]) -> Model<Q> {
        let (mut model, mut expected) = (self.cast::<Q>(), 0);
        model.each_number(&mut |_, _, x| {
            if let Some(&given) = parameters.get(expected) {
                *x = given;
            }
            expected += 1;
        });
        assert_eq!(
            parameters.len(),
            expected,
            "\"{}\" has {expected} parameters",
            self.name
        );
        if let Some(k) = parameters.iter().position(|&x| !is_finite(x)) {
            let quantity = format!("parameter \"{}\"", self.parameter_layout().names()[k]);
            Domain::Finite.check(quantity, parameters[k]);
        }
        model.generation = Generation::next();
        model
    }

    /// Returns the robot with some parameters changed, over their scalar: those at `indices` get `values`, the others are unchanged.
    ///
    /// Inertial parameters are independent: a change of the mass alone keeps the moments. For a heavier body of the same shape use
    /// [`with_link_mass`](Self::with_link_mass), or scale all ten with [`with_inertia`](Self::with_inertia).
    ///
    /// # Panics
    /// If the numbers of values and indices differ, an index is out of range, or a value is not finite.
    pub fn with_some_parameters<Q: Over<P>>(&self, indices: &[usize], values: &[Q]) -> Model<Q> {
        assert_eq!(indices.len(), values.len(), "one value a parameter");
        let mut all = self.parameters().map(<Q as From<P>>::from);
        for (&index, &value) in indices.iter().zip(values) {
            all[index] = value;
        }
        self.with_parameters(all.as_slice())
    }

    /// Returns the layout of the [`parameters`](Self::parameters): index and name of each. Allocates.
    pub fn parameter_layout(&self) -> ParameterLayout {
        let mut out = ParameterLayout::new(&self.name);
        self.clone().each_number(&mut |group, own, _| {
            let last = out.groups.last().filter(|(last, _)| *last == group);
            let k = last.map_or(0, |(_, range)| range.len());
            out.push(group, self.name_of(group, k, own.name), own.domain);
        });
        out
    }

    /// Passes each parameter with its group to `each`, group by group: this function defines the order.
    fn each_number(&mut self, each: &mut EachIn<'_, ParameterGroup, P>) {
        let along = |name| Number::new(name, name, Domain::NotNegative);
        for (i, body) in self.bodies.iter_mut().enumerate() {
            body.inertia
                .each_number(&mut of(Group::Inertia(BodyId(i)), each));
        }
        for (k, joint) in self.joints.iter().enumerate() {
            let placement = &mut self.bodies[joint.bodies().start].placement;
            each_increment(placement, &mut of(Group::Placement(JointId(k)), each));
        }
        each_named(
            &["gravity x", "gravity y", "gravity z"],
            None,
            Domain::Finite,
            self.gravity.as_mut_slice(),
            &mut of(Group::Gravity, each),
        );
        for x in &mut self.damping {
            each(Group::Damping, along(&"damping"), x);
        }
        for x in &mut self.armature {
            each(Group::Armature, along(&"armature"), x);
        }
        for k in 0..self.joints.len() {
            let body = &self.bodies[self.joints[k].body.0];
            if body.coupling.is_none() && body.joint.nv() == 1 {
                let springs = self.joint_v(JointId(k));
                let of_joint = &mut of(Group::Spring(JointId(k)), each);
                for spring in &mut self.springs[springs] {
                    spring.each_number(of_joint);
                }
            }
        }
        for (k, joint) in self.joints.iter().enumerate() {
            let coupling = &mut self.bodies[joint.body.0].coupling;
            coupling.each_number(&mut of(Group::Coupling(JointId(k)), each));
        }
        for (k, frame) in self.frames.iter_mut().enumerate() {
            each_increment(
                &mut frame.placement,
                &mut of(Group::Frame(FrameId(k)), each),
            );
        }
    }

    /// Name of the k-th parameter of a group.
    fn name_of(&self, group: ParameterGroup, k: usize, name: &dyn Display) -> String {
        let of_joint = |joint: JointId| self.joints[joint.0].name.clone();
        let owner = match group {
            Group::Inertia(body) => self.body_name(body).to_owned(),
            Group::Placement(joint) | Group::Coupling(joint) => of_joint(joint),
            Group::Frame(frame) => format!("frame {}", self.frames[frame.0].name),
            Group::Gravity => "world".to_owned(),
            Group::Spring(joint) => {
                // Of each axis, stiffness and rest position.
                let body = self.joint_bodies(joint).nth(k / 2);
                body.and_then(|body| self.part_name(body))
                    .unwrap_or_default()
            }
            Group::Damping | Group::Armature => return self.coordinate_name(k, name),
        };
        format!("{owner}: {name}")
    }
}

/// Passes translation and rotation of a pose along its own axes, initially zero, to `each`, and moves it by them.
fn each_increment<P: Scalar>(pose: &mut Transform<P>, each: &mut Each<'_, P>) {
    const NAMES: [&str; SPATIAL] = [
        "shift x", "shift y", "shift z", "turn x", "turn y", "turn z",
    ];
    let mut own = [P::zero(); SPATIAL];
    each_named(&NAMES, None, Domain::Finite, &mut own, each);
    *pose = *pose * increment(&own);
}

/// The pose (p, exp(φ)) of a translation p and a rotation vector φ.
fn increment<P: Scalar>(x: &[P]) -> Transform<P> {
    let turn = Quaternion::exp(&Vector3::new(x[3], x[4], x[5]));
    Transform::new(turn.to_matrix(), Vector3::new(x[0], x[1], x[2]))
}
