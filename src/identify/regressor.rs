//! The regressor of identification: joint forces as a linear function of unknowns.

use nalgebra::{DMatrix, DVector};

use super::error::IdentifyError;
use super::friction::DryFriction;
use crate::dynamics::joint_torque_regressor;
use crate::model::manifold::v_range;
use crate::model::{BodyId, Model, ParameterGroup};
use crate::nested::IntoNested;
use crate::scalar::Over;
use crate::spatial::INERTIAL_PARAMETERS;

/// An unknown in which joint forces are linear.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Unknown {
    /// One of the ten standard inertial parameters of a body, in the order of [`Inertia::to_parameters`](crate::spatial::Inertia::to_parameters).
    Inertia {
        /// The body.
        body: BodyId,
        /// Index from 0 to 9.
        number: usize,
    },
    /// Viscous damping along a velocity coordinate, N·m·s/rad or N·s/m.
    Damping(usize),
    /// Rotor inertia on a velocity coordinate, kg·m² or kg.
    Armature(usize),
    /// Force of dry friction along a velocity coordinate, N·m or N.
    DryFriction(usize),
    /// Constant error of the force along a velocity coordinate, N·m or N.
    Offset(usize),
}

impl Unknown {
    /// Whether no robot has a value below zero of it.
    pub(super) fn is_not_negative(self) -> bool {
        matches!(
            self,
            Self::Damping(_) | Self::Armature(_) | Self::DryFriction(_)
        )
    }
}

/// Joint forces as a linear function of unknowns:  τ = Y(q, v, v̇) x + known(q, v, v̇).
///
/// Unknowns are the inertial parameters of all bodies with inertia, and optional further ones; all other forces are those of the model: springs, and
/// damping and rotor inertias that are not unknown.
///
/// # Examples
/// ```
/// use dualbody::{identify::{DryFriction, Regressor}, model::samples};
///
/// let regressor = Regressor::new(&samples::pendulum())
///     .with_damping()
///     .with_dry_friction(DryFriction::Smooth { slip_velocity: 0.01 })?;
/// assert_eq!(regressor.names().len(), 12);
/// assert_eq!(regressor.names()[11], "pivot: dry friction");
/// # Ok::<(), dualbody::identify::IdentifyError>(())
/// ```
///
/// # References
/// [Atkeson, An, Hollerbach 1986].
#[derive(Clone, Debug)]
pub struct Regressor {
    model: Model,
    unknowns: Vec<Unknown>,
    names: Vec<String>,
    nominal: DVector<f64>,
    dry_friction: Option<DryFriction>,
}

impl Regressor {
    /// Makes the regressor of a robot with unknown inertias.
    pub fn new(model: &Model) -> Self {
        let layout = model.parameter_layout();
        let mut out = Self {
            model: model.clone(),
            unknowns: Vec::new(),
            names: Vec::new(),
            nominal: DVector::zeros(0),
            dry_friction: None,
        };
        for body in (0..model.n_bodies()).map(BodyId) {
            let values = model.body(body).inertia.to_parameters();
            if values.iter().all(|&x| x == 0.0) {
                continue;
            }
            let range = layout
                .range(ParameterGroup::Inertia(body))
                .unwrap_or_default();
            for (number, (name, value)) in layout.names()[range].iter().zip(values).enumerate() {
                out.push(Unknown::Inertia { body, number }, name.clone(), value);
            }
        }
        out
    }

    fn push(&mut self, unknown: Unknown, name: String, value: f64) {
        self.unknowns.push(unknown);
        self.names.push(name);
        self.nominal = self.nominal.clone().push(value);
    }

    /// Treats the inertias of these links as known: their bodies keep the inertia of the model.
    ///
    /// # Errors
    /// If the robot has no link with this name.
    pub fn with_known_links(mut self, links: &[&str]) -> Result<Self, IdentifyError> {
        for name in links {
            let frame = self.model.find_frame(name)?;
            let known = self.model.frames()[frame.0].body;
            let is_known = |unknown: &Unknown| match unknown {
                Unknown::Inertia { body, .. } => Some(*body) == known,
                _ => false,
            };
            let kept: Vec<usize> = (0..self.unknowns.len())
                .filter(|&k| !is_known(&self.unknowns[k]))
                .collect();
            self.unknowns = kept.iter().map(|&k| self.unknowns[k]).collect();
            self.names = kept.iter().map(|&k| self.names[k].clone()).collect();
            self.nominal = self.nominal.select_rows(&kept);
        }
        Ok(self)
    }

    /// Adds the viscous damping of all joints to the unknowns.
    #[must_use]
    pub fn with_damping(mut self) -> Self {
        for k in self.coordinates() {
            let name = self.model.coordinate_name(k, &"damping");
            self.push(Unknown::Damping(k), name, self.model.damping()[k]);
        }
        self
    }

    /// Adds the rotor inertias of all joints to the unknowns. For a joint on the world, rotor inertia and the moment of inertia of the first body
    /// about the joint axis are not separately identifiable: [base parameters](super::BaseParameters) contain their sum.
    #[must_use]
    pub fn with_armature(mut self) -> Self {
        for k in self.coordinates() {
            let name = self.model.coordinate_name(k, &"armature");
            self.push(Unknown::Armature(k), name, self.model.armature()[k]);
        }
        self
    }

    /// Adds the dry friction of all joints to the unknowns. Its nominal value is zero.
    ///
    /// # Errors
    /// If the parameter of the shape is out of its range.
    pub fn with_dry_friction(mut self, shape: DryFriction) -> Result<Self, IdentifyError> {
        let (name, value, is_good) = shape.number();
        if !is_good {
            return Err(IdentifyError::option(
                format!("{name} of dry friction"),
                format!("{value} rad/s or m/s"),
            ));
        }
        self.dry_friction = Some(shape);
        Ok(self.with_each("dry friction", Unknown::DryFriction))
    }

    /// Adds a constant error of the measured force of all joints to the unknowns. Its nominal value is zero.
    #[must_use]
    pub fn with_offsets(self) -> Self {
        self.with_each("offset", Unknown::Offset)
    }

    fn with_each(mut self, quantity: &str, unknown: impl Fn(usize) -> Unknown) -> Self {
        for k in self.coordinates() {
            let name = self.model.coordinate_name(k, &quantity);
            self.push(unknown(k), name, 0.0);
        }
        self
    }

    /// The velocity coordinates of named joints.
    fn coordinates(&self) -> Vec<usize> {
        let bodies = self.model.independent_with_ids();
        let named = bodies.filter(|&(id, _)| self.model.body_joint(id).is_some());
        named.nested(|(_, body)| v_range(body)).collect()
    }

    /// The robot with its nominal parameters.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The unknowns, in the order of the columns.
    pub fn unknowns(&self) -> &[Unknown] {
        &self.unknowns
    }

    /// Names of the unknowns, as in [`Model::parameter_layout`]: `forearm: mass`, `elbow: damping`.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Values of the unknowns in the model; dry friction and offsets are zero.
    pub fn nominal(&self) -> &DVector<f64> {
        &self.nominal
    }

    /// Shape of dry friction; `None` if dry friction is not an unknown.
    pub(crate) fn dry_friction(&self) -> Option<DryFriction> {
        self.dry_friction
    }

    /// Computes Y, `nv` × unknowns. Allocates.
    ///
    /// * `q` – configuration, length `nq`
    /// * `v`, `a` – velocity and acceleration in tangent coordinates, length `nv`
    ///
    /// # Panics
    /// If a slice has the wrong length.
    pub fn matrix<T: Over<f64>>(&self, q: &[T], v: &[T], a: &[T]) -> DMatrix<T> {
        let bodies = joint_torque_regressor(&self.model, q, v, a);
        let mut out = DMatrix::zeros(self.model.nv(), self.unknowns.len());
        for (column, unknown) in self.unknowns.iter().enumerate() {
            match *unknown {
                Unknown::Inertia { body, number } => {
                    let own = bodies.column(INERTIAL_PARAMETERS * body.0 + number);
                    out.set_column(column, &own);
                }
                Unknown::Damping(k) => out[(k, column)] = v[k],
                Unknown::Armature(k) => out[(k, column)] = a[k],
                Unknown::Offset(k) => out[(k, column)] = T::one(),
                Unknown::DryFriction(k) => {
                    let shape = self.dry_friction.map(|friction| friction.shape(v[k]));
                    out[(k, column)] = shape.unwrap_or_else(T::zero);
                }
            }
        }
        out
    }
}
