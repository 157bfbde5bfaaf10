//! The identified robot.

use nalgebra::{DMatrix, DVector};

use super::dataset::Segment;
use super::friction::DryFriction;
use super::regressor::{Regressor, Unknown};
use crate::dynamics::{RneaScratch, add_passive_forces, inverse_dynamics_into};
use crate::model::{Model, ParameterGroup};
use crate::scalar::{Lanes, Over, Scalar};
use crate::sim::{Actuation, CoulombFriction};
use crate::spatial::INERTIAL_PARAMETERS;

/// Samples side by side, where the CPU has [registers](Lanes::is_supported) for them.
pub(super) type Samples = Lanes<8>;

/// An identified robot: its model, dry friction and force offsets.
#[derive(Clone, Debug)]
pub struct Robot {
    /// The model with the identified inertias, damping and rotor inertias.
    pub model: Model,
    /// Shape of dry friction; `None` if it was not identified.
    pub shape: Option<DryFriction>,
    /// Force of dry friction along each velocity coordinate, N·m or N.
    pub dry_friction: Vec<f64>,
    /// Constant error of the measured force along each velocity coordinate, N·m or N.
    pub offsets: Vec<f64>,
}

impl Robot {
    /// A robot with these values of the unknowns.
    pub(super) fn of(regressor: &Regressor, x: &DVector<f64>) -> Self {
        let model = regressor.model();
        let layout = model.parameter_layout();
        let first = |group| layout.range(group).map_or(0, |range| range.start);
        let (damping, armature) = (
            first(ParameterGroup::Damping),
            first(ParameterGroup::Armature),
        );
        let mut out = Self {
            model: model.clone(),
            shape: regressor.dry_friction(),
            dry_friction: vec![0.0; model.nv()],
            offsets: vec![0.0; model.nv()],
        };
        let (mut indices, mut values) = (Vec::new(), Vec::new());
        for (unknown, &x) in regressor.unknowns().iter().zip(x) {
            match *unknown {
                Unknown::Inertia { body, number } => {
                    indices.push(INERTIAL_PARAMETERS * body.0 + number);
                    values.push(x);
                }
                Unknown::Damping(k) => {
                    indices.push(damping + k);
                    values.push(x);
                }
                Unknown::Armature(k) => {
                    indices.push(armature + k);
                    values.push(x);
                }
                Unknown::DryFriction(k) => out.dry_friction[k] = x,
                Unknown::Offset(k) => out.offsets[k] = x,
            }
        }
        out.model = model.with_some_parameters(&indices, &values);
        out
    }

    /// Predicts the joint forces of a motion, with springs, damping, dry friction and offsets. Allocates.
    ///
    /// * `q` – configuration, length `nq`
    /// * `v`, `a` – velocity and acceleration in tangent coordinates, length `nv`
    ///
    /// # Panics
    /// If a slice has the wrong length.
    pub fn predict(&self, q: &[f64], v: &[f64], a: &[f64]) -> DVector<f64> {
        let mut out = DVector::zeros(self.model.nv());
        let mut scratch = Prediction::new(&self.model);
        self.predict_into(q, v, a, &mut scratch, out.as_mut_slice());
        out
    }

    /// Predicts the joint forces of a segment, `nv` × samples.
    ///
    /// # Panics
    /// If the segment has the size of another robot's.
    pub(crate) fn predict_segment(&self, segment: &Segment) -> DMatrix<f64> {
        match Samples::is_supported() {
            true => self.predict_segment_over::<Samples>(segment),
            false => self.predict_segment_over::<f64>(segment),
        }
    }

    fn predict_segment_over<T: Over<f64>>(&self, segment: &Segment) -> DMatrix<f64> {
        let mut out = DMatrix::zeros(self.model.nv(), segment.len());
        let mut scratch = Prediction::new(&self.model);
        let mut tau = vec![T::zero(); self.model.nv()];
        for first in (0..segment.len()).step_by(T::LANES) {
            let at = Moments::<T>::of(segment, first);
            self.predict_into(&at.q, &at.v, &at.a, &mut scratch, &mut tau);
            for lane in 0..T::LANES.min(segment.len() - first) {
                for (k, tau) in tau.iter().enumerate() {
                    out[(k, first + lane)] = tau.value(lane);
                }
            }
        }
        out
    }

    pub(super) fn predict_into<T: Over<f64>>(
        &self,
        q: &[T],
        v: &[T],
        a: &[T],
        scratch: &mut Prediction<T>,
        tau: &mut [T],
    ) {
        scratch.passive.fill(T::zero());
        add_passive_forces(&self.model, q, v, &mut scratch.passive);
        inverse_dynamics_into(&self.model, q, v, a, &[], &mut scratch.rnea, tau);
        for k in 0..tau.len() {
            tau[k] += -scratch.passive[k] + self.offsets[k];
            if let Some(shape) = self.shape {
                tau[k] += shape.shape(v[k]) * self.dry_friction[k];
            }
        }
    }

    /// Adds the identified dry friction to an actuation, for simulators. For friction with a dead zone, the dead zone becomes the slip velocity.
    ///
    /// # Panics
    /// If the actuation belongs to another robot, or friction is negative.
    pub fn actuation(&self, actuation: &Actuation) -> Actuation {
        /// Slip velocity where the dead zone is none, rad/s or m/s.
        const LEAST: f64 = 1e-3;
        let slip_velocity = match self.shape {
            None => return actuation.clone(),
            Some(DryFriction::Smooth { slip_velocity }) => slip_velocity,
            Some(DryFriction::Sign { dead_zone }) => dead_zone.max(LEAST),
        };
        let mut actuators = actuation.actuators().to_vec();
        for (actuator, &force) in actuators.iter_mut().zip(&self.dry_friction) {
            let friction = CoulombFriction::smoothed(force, slip_velocity);
            actuator.friction = (force != 0.0).then_some(friction);
        }
        actuation.with_actuators(&actuators)
    }
}

/// Working memory of predictions.
pub(super) struct Prediction<T> {
    rnea: RneaScratch<T>,
    passive: Vec<T>,
}

impl<T: Scalar> Prediction<T> {
    pub(super) fn new(model: &Model) -> Self {
        Self {
            rnea: RneaScratch::new(model),
            passive: vec![T::zero(); model.nv()],
        }
    }
}

/// Some samples of a segment side by side.
pub(super) struct Moments<T> {
    pub(super) q: Vec<T>,
    pub(super) v: Vec<T>,
    pub(super) a: Vec<T>,
}

impl<T: Scalar> Moments<T> {
    /// The samples from one on; after the last it is repeated.
    pub(super) fn of(segment: &Segment, first: usize) -> Self {
        let last = segment.len() - 1;
        let of = |m: &DMatrix<f64>| {
            let row = |k: usize| T::from_values(|lane| m[(k, last.min(first + lane))]);
            (0..m.nrows()).map(row).collect()
        };
        Self {
            q: of(&segment.q),
            v: of(&segment.v),
            a: of(&segment.a),
        }
    }
}
