//! Conversion of a robot to other scalars.

use std::sync::Arc;

use super::{Generation, Model};
use crate::error::StructureMismatch;
use crate::numbers::Numbers;
use crate::scalar::{Lanes, Over, Scalar};

impl<P: Scalar> Model<P> {
    /// Returns the robot over another scalar: differentiable in masses, lengths, gravity and damping.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Model, model::samples};
    /// use num_dual::Dual64;
    ///
    /// let model: Model<Dual64> = samples::pendulum().cast();
    /// assert_eq!(model.total_mass().re, 1.0);
    /// ```
    pub fn cast<Q: Over<P>>(&self) -> Model<Q> {
        self.map(&mut |x| <Q as From<P>>::from(x))
    }

    /// The robot with the values of its parameters in one lane, without derivatives.
    pub(crate) fn values(&self, lane: usize) -> Model {
        self.map(&mut |x| x.value(lane))
    }

    /// [`values`](Self::values) of all that forward dynamics and mass matrices are computed from, into those of a robot
    /// of the same structure, without allocation.
    pub(crate) fn values_into(&self, out: &mut Model) {
        let value = &mut |x: P| x.value(0);
        out.gravity = self.gravity.map(&mut *value);
        for (out, body) in out.bodies.iter_mut().zip(&self.bodies) {
            *out = body.map_numbers(value);
        }
        for (out, own) in out.weightless.iter_mut().zip(&self.weightless) {
            *out = own.map_numbers(value);
        }
        for (out, armature) in out.armature.iter_mut().zip(&self.armature) {
            *out = armature.value(0);
        }
        out.generation = Generation::next();
    }

    /// Returns the robot with every number mapped, always in the same order.
    pub(super) fn map<Q: Scalar>(&self, f: &mut impl FnMut(P) -> Q) -> Model<Q> {
        Model {
            name: self.name.clone(),
            gravity: self.gravity.map(&mut *f),
            bodies: self.bodies.map_numbers(f),
            weightless: self.weightless.map_numbers(f),
            generation: Generation::next(),
            frames: self.frames.map_numbers(f),
            damping: self.damping.iter().map(|&d| f(d)).collect(),
            armature: self.armature.iter().map(|&a| f(a)).collect(),
            springs: self.springs.map_numbers(f),
            joints: self.joints.clone(),
            links: self.links.clone(),
            nq: self.nq,
            structure: self.structure,
            description: Arc::clone(&self.description),
            remarks: Arc::clone(&self.remarks),
        }
    }
}

impl<const N: usize> Model<Lanes<N>> {
    /// Packs `N` robots of equal structure into lanes. The parameters of the dynamics (inertias, placements of joints and frames, gravity, damping,
    /// armature, springs) may differ; limits, shapes and the description are those of the first robot.
    ///
    /// # Errors
    /// If the structures of the robots differ; the error names the robot and its first difference from `models[0]`.
    ///
    /// # Panics
    /// If `N` is zero.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Lanes, Model, model::samples};
    ///
    /// let (one, other) = (samples::cartpole(), samples::cartpole().with_damping(1, 0.5));
    /// let both = Model::<Lanes<2>>::side_by_side([&one, &other])?;
    /// assert_eq!(both.damping()[1], Lanes([0.0, 0.5]));
    /// # Ok::<(), dualbody::StructureMismatch>(())
    /// ```
    pub fn side_by_side(models: [&Model; N]) -> Result<Self, StructureMismatch> {
        let first = models[0];
        for (index, model) in models.iter().enumerate() {
            first.check_structure(model, index)?;
        }
        let mut lanes = models.map(|model| model.numbers().into_iter());
        let next = |lane: &mut std::vec::IntoIter<f64>| lane.next().expect("as many numbers");
        Ok(first.map(&mut |_| Lanes(lanes.each_mut().map(next))))
    }
}

impl Model {
    /// All numbers, in the order in which they are mapped.
    fn numbers(&self) -> Vec<f64> {
        let mut out = Vec::new();
        self.map(&mut |x| {
            out.push(x);
            x
        });
        out
    }
}
