//! All numbers that the dynamics of a robot depend on, as one vector.
//!
//! | group | numbers | unit |
//! |---|---|---|
//! | inertia of each body | m, hx, hy, hz, Jxx, Jxy, Jyy, Jxz, Jyz, Jzz, see [`Inertia::to_parameters`] | kg, kg·m, kg·m² |
//! | placement of each named joint | shift x, y, z, then turn x, y, z | m, rad |
//! | gravity | x, y, z in the world | m/s² |
//! | damping, armature | one a velocity coordinate | N·m·s/rad, kg·m²; or N·s/m, kg |
//! | spring of each joint with one coordinate of its own | stiffness, rest position | N·m/rad, rad; or N/m, m |
//! | coupling of each joint that follows another one | ratio, offset | 1, rad/m or m/rad; rad or m |
//! | placement of each frame on its body | shift x, y, z, then turn x, y, z | m, rad |
//!
//! Placements are increments: the pose of a joint is `X_PJ` (p, exp(φ)) with the pose `X_PJ` that the model has, shifted by p and turned
//! by φ, both along the axes of the joint, whose z axis is that of its motion; that of a frame likewise, along its own axes. So zero is the robot as it is, the derivative at zero
//! is that in calibration errors, and no number is redundant as those of a rotation matrix are.
//!
//! Ratio and offset of a follower say how it moves; what it adds to damping, armature and spring of the coordinate that it follows is in the numbers
//! of these, and does not change with its ratio.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::ops::Range;

use nalgebra::{DVector, Vector3};

use super::{BodyId, Coupling, FrameId, Generation, JointId, Model, Spring};
use crate::error::UnknownName;
use crate::numbers::{Domain, Numbers as _, is_finite};
use crate::scalar::{Over, Scalar};
use crate::spatial::{INERTIAL_PARAMETERS, Inertia, Quaternion, SPATIAL, Transform};

/// Numbers that belong together in the vector of parameters; see [the table](Model::parameters).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ParameterGroup {
    /// The ten standard inertial parameters of a body.
    Inertia(BodyId),
    /// The increment of the pose of a named joint: shift, then turn.
    Placement(JointId),
    /// Gravity in the world.
    Gravity,
    /// Damping along all velocity coordinates.
    Damping,
    /// Rotor inertia on all velocity coordinates.
    Armature,
    /// Stiffness and rest position of the spring along a joint with one coordinate of its own.
    Spring(JointId),
    /// Ratio and offset of a joint that follows another one.
    Coupling(JointId),
    /// The increment of the pose of a frame on its body (or the world): shift, then turn. Links are frames.
    Frame(FrameId),
}

/// Layout of a vector of parameters: index and name of each number, and the groups that they belong to, [`ParameterGroup`] for those of a model.
#[derive(Clone, Debug)]
pub struct ParameterLayout<G = ParameterGroup> {
    model: String,
    names: Vec<String>,
    /// Values that each number may have.
    domains: Vec<Domain>,
    groups: Vec<(G, Range<usize>)>,
}

impl<G: Copy + PartialEq> ParameterLayout<G> {
    pub(crate) fn new(
        model: &str,
        names: Vec<String>,
        domains: Vec<Domain>,
        groups: Vec<(G, Range<usize>)>,
    ) -> Self {
        Self {
            model: model.to_owned(),
            names,
            domains,
            groups,
        }
    }

    /// Number of parameters, over all groups.
    pub fn len(&self) -> usize {
        self.names.len()
    }

    /// `true` if there are none: never, as there is gravity everywhere.
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }

    /// Name of each parameter: the link, joint or world that it belongs to and the quantity, as in `forearm: mass`,
    /// `elbow: damping`, `world: gravity z`; several of one sort are numbered, as in `ball: damping 2`.
    ///
    /// A body is called like its first link; the joint of a floating base, which has no name, `floating base`.
    pub fn names(&self) -> &[String] {
        &self.names
    }

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

    /// Index of the number with a name.
    ///
    /// # Errors
    /// If there is none.
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
    /// Collects all numbers that the dynamics depend on: inertias (kg, kg·m, kg·m², in the body frame), placements of joints (m, rad;
    /// zero, as they are increments), gravity (m/s²), damping, armature, springs, ratios and offsets of followers, placements of frames; see [`ParameterLayout`] for where each
    /// stands. Allocates.
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
        let all = self.parameter_groups();
        let all = all.into_iter().flat_map(|group| self.get(group));
        DVector::from_vec(all.collect())
    }

    /// The robot with other parameters, over their scalar: over dual numbers, the way to derivatives in all of them.
    ///
    /// Placements are relative to this model's; with `self.parameters()` it stays as it is.
    ///
    /// Negative masses, damping, rotors and stiffnesses are taken, though no robot has them: finite differences step over zero, where the damping
    /// and the rotors of many robots are. What an optimiser or an identification ends with is to be asked for
    /// [inertias that no body has](Model::inertia_flaws), or kept from them by [`Inertia::from_log_cholesky`].
    ///
    /// # Panics
    /// If there are not as many as [`parameters`](Self::parameters) gives, or if one is not finite; the message names it.
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
        let groups = self.parameter_groups();
        let expected: usize = groups.iter().map(|&group| self.get(group).len()).sum();
        assert_eq!(
            parameters.len(),
            expected,
            "\"{}\" has {expected} parameters",
            self.name
        );
        if let Some(k) = parameters.iter().position(|&x| !is_finite(x)) {
            let (layout, value) = (self.parameter_layout(), parameters[k]);
            let quantity = format_args!("parameter \"{}\"", layout.names()[k]);
            Domain::Finite.check(quantity, value);
        }
        let (mut model, mut rest) = (self.cast::<Q>(), parameters);
        for group in groups {
            let (own, others) = rest.split_at(self.get(group).len());
            model.set(group, own);
            rest = others;
        }
        model.generation = Generation::next();
        model
    }

    /// The robot with some parameters changed, over their scalar: those at `indices` take `values`, the others stay.
    ///
    /// # Panics
    /// If there are not as many values as indices, if there is no parameter with an index, or if a value is not finite.
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
        let (mut names, mut domains) = (Vec::new(), Vec::new());
        let place = |group| {
            let first = names.len();
            names.extend(self.names_of(group));
            domains.extend((0..names.len() - first).map(|k| domain_of(group, k)));
            (group, first..names.len())
        };
        let groups = self.parameter_groups().into_iter().map(place).collect();
        ParameterLayout::new(&self.name, names, domains, groups)
    }

    /// The groups in their order; the one place that says it.
    fn parameter_groups(&self) -> Vec<ParameterGroup> {
        let joints = || (0..self.n_joints()).map(JointId);
        let has_spring = |joint: &JointId| {
            let body = self.body(self.joint_body(*joint));
            body.coupling.is_none() && body.joint.nv() == 1
        };
        let bodies = (0..self.n_bodies()).map(|i| ParameterGroup::Inertia(BodyId(i)));
        let mut groups: Vec<_> = bodies.collect();
        groups.extend(joints().map(ParameterGroup::Placement));
        groups.extend([
            ParameterGroup::Gravity,
            ParameterGroup::Damping,
            ParameterGroup::Armature,
        ]);
        groups.extend(joints().filter(has_spring).map(ParameterGroup::Spring));
        let follows = |joint: &JointId| self.body(self.joint_body(*joint)).coupling.is_some();
        groups.extend(joints().filter(follows).map(ParameterGroup::Coupling));
        let frames = (0..self.frames.len()).map(FrameId);
        groups.extend(frames.map(ParameterGroup::Frame));
        groups
    }

    fn get(&self, group: ParameterGroup) -> Vec<P> {
        match group {
            ParameterGroup::Inertia(body) => self.body(body).inertia.to_parameters().to_vec(),
            ParameterGroup::Placement(_) | ParameterGroup::Frame(_) => vec![P::zero(); SPATIAL],
            ParameterGroup::Gravity => self.gravity.as_slice().to_vec(),
            ParameterGroup::Damping => self.damping.clone(),
            ParameterGroup::Armature => self.armature.clone(),
            ParameterGroup::Spring(joint) => self.springs[self.joint_v(joint).start].to_vec(),
            ParameterGroup::Coupling(joint) => {
                let coupling = self.body(self.joint_body(joint)).coupling;
                coupling.to_vec()
            }
        }
    }

    /// Sets a group to as many numbers as [`get`](Self::get) gives.
    fn set(&mut self, group: ParameterGroup, x: &[P]) {
        match group {
            ParameterGroup::Inertia(body) => {
                let inertia = Inertia::from_parameters(std::array::from_fn(|k| x[k]));
                self.bodies[body.0].inertia = inertia;
            }
            ParameterGroup::Placement(joint) => {
                let X_PJ = &mut self.bodies[self.joints[joint.0].bodies().start].placement;
                *X_PJ = *X_PJ * increment(x);
            }
            ParameterGroup::Gravity => self.gravity = Vector3::new(x[0], x[1], x[2]),
            ParameterGroup::Damping => self.damping.copy_from_slice(x),
            ParameterGroup::Armature => self.armature.copy_from_slice(x),
            ParameterGroup::Spring(joint) => {
                for (v, x) in self.joint_v(joint).zip(x.chunks_exact(2)) {
                    let (stiffness, rest) = (x[0], x[1]);
                    self.springs[v] = Spring { stiffness, rest };
                }
            }
            ParameterGroup::Coupling(joint) => {
                let (ratio, offset) = (x[0], x[1]);
                let body = self.joint_body(joint);
                self.bodies[body.0].coupling = Some(Coupling { ratio, offset });
            }
            ParameterGroup::Frame(frame) => {
                let X_BF = &mut self.frames[frame.0].placement;
                *X_BF = *X_BF * increment(x);
            }
        }
    }

    fn names_of(&self, group: ParameterGroup) -> Vec<String> {
        /// Names of the numbers of [`Inertia::to_parameters`].
        const INERTIA: [&str; INERTIAL_PARAMETERS] = [
            "mass", "hx", "hy", "hz", "Jxx", "Jxy", "Jyy", "Jxz", "Jyz", "Jzz",
        ];
        const PLACEMENT: [&str; SPATIAL] = [
            "shift x", "shift y", "shift z", "turn x", "turn y", "turn z",
        ];
        let joint_name = |joint: JointId| self.joints[joint.0].name.as_str();
        match group {
            ParameterGroup::Inertia(body) => names(self.body_name(body), &INERTIA),
            ParameterGroup::Placement(joint) => names(joint_name(joint), &PLACEMENT),
            ParameterGroup::Frame(frame) => {
                names(&format!("frame {}", self.frames[frame.0].name), &PLACEMENT)
            }
            ParameterGroup::Coupling(joint) => names(joint_name(joint), &["ratio", "offset"]),
            ParameterGroup::Gravity => names("world", &["gravity x", "gravity y", "gravity z"]),
            ParameterGroup::Damping => self.coordinate_names("damping"),
            ParameterGroup::Armature => self.coordinate_names("armature"),
            ParameterGroup::Spring(joint) => {
                let parts = self
                    .joint_bodies(joint)
                    .filter_map(|body| self.part_name(body));
                parts
                    .flat_map(|part| names(&part, &["stiffness", "rest"]))
                    .collect()
            }
        }
    }

    /// Names of one quantity along all velocity coordinates.
    fn coordinate_names(&self, quantity: &str) -> Vec<String> {
        let own = |(i, body): (usize, &super::Body<P>)| {
            let joint = self.part_name(BodyId(i));
            let joint = joint.as_deref().unwrap_or("floating base");
            match body.joint.nv() {
                1 => names(joint, &[quantity]),
                n => (0..n).map(|k| format!("{joint}: {quantity} {k}")).collect(),
            }
        };
        let bodies = self.bodies.iter().enumerate();
        let independent = bodies.filter(|(_, body)| body.coupling.is_none());
        independent.flat_map(own).collect()
    }
}

/// The pose (p, exp(φ)) of a shift p and a turn φ.
fn increment<P: Scalar>(x: &[P]) -> Transform<P> {
    let turn = Quaternion::exp(&Vector3::new(x[3], x[4], x[5]));
    Transform::new(turn.to_matrix(), Vector3::new(x[0], x[1], x[2]))
}

/// Values that the k-th number of a group has in a robot.
fn domain_of(group: ParameterGroup, k: usize) -> Domain {
    use ParameterGroup::{Armature, Damping, Inertia, Spring};
    match (group, k) {
        (Inertia(_) | Spring(_), 0) | (Damping | Armature, _) => Domain::NotNegative,
        _ => Domain::Finite,
    }
}

fn names(of: &str, quantities: &[&str]) -> Vec<String> {
    let name = |quantity| format!("{of}: {quantity}");
    quantities.iter().map(name).collect()
}
